//! A counter-example as values, not as the seed of a random stream: every double bit for bit in hexadecimal, so that any version on any
//! machine sees the same state. Of a connector, a multi-point constraint, a friction, a belt, or springs and dampers.

use crate::case::Case;
use crate::case::failing::Failing;
use crate::case::hex::Hex;
use crate::case::quantity::Quantity;
use crate::judge::outcome::{Against, Check};
use crate::judge::verdict::Summand;
use crate::laws::{Demanded, Invariant};
use crate::oracles::oracle::{Oracle, Remainder};
use crate::oracles::sums::remainder_along;
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::vector::{cross, dot, transpose};
use serde::{Deserialize, Serialize};
use serde_json::{Number, Value, json};
use std::collections::BTreeSet;

/// The schema of the file.
pub const SCHEMA: &str = "pintle-counterexample/2";

pintle_kinematics::named! {
    /// What a file is about: the tag of [`Failing`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum About {
        /// A connector after its history.
        Connector = "connector",
        /// A multi-point constraint at a state.
        Mpc = "multi-point constraint",
        /// A relation at a state.
        Relation = "relation",
        /// A friction in an increment.
        Friction = "friction",
        /// A belt around a ring in an increment.
        Belt = "belt around a ring",
        /// Springs and dampers at a motion.
        Slopes = "slope of a behaviour",
    }
}

impl About {
    const fn of(failing: &Failing) -> Self {
        match failing {
            Failing::Connector(_) => Self::Connector,
            Failing::Mpc(_) => Self::Mpc,
            Failing::Relation(_) => Self::Relation,
            Failing::Friction(_) => Self::Friction,
            Failing::Belt(_) => Self::Belt,
            Failing::Slopes(_) => Self::Slopes,
        }
    }
}

/// One failing check at one state, everything in it bit-exact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CounterExample {
    /// [`SCHEMA`].
    pub schema: String,
    /// The version of pintle that wrote it.
    pub version: String,
    /// What it is about.
    pub kind: About,
    /// Who gave the numbers: pintle, or the name of a candidate.
    pub subject: String,
    /// What they were compared with.
    pub against: String,
    /// The kind of number.
    pub quantity: Option<Quantity>,
    /// The entry by name.
    pub entry: String,
    /// The law that it breaks, where it was compared with one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<BrokenLaw>,
    /// The numbers that are added up, where it is a sum: along a direction, or over component forces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sum: Vec<Summand>,
    /// What was given.
    pub got: Hex,
    /// What it must be.
    pub want: Hex,
    /// How far it may be from that.
    pub tolerance: Hex,
    /// The oracles that were asked; none written is all of them. A replay asks the same.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub oracles: Vec<Oracle>,
    /// The values that the numbers follow from, doubles in hexadecimal.
    pub values: Value,
}

/// A law that numbers break.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BrokenLaw {
    /// The law.
    pub name: Invariant,
    /// Which of its demands; none of a law of types.
    pub demanded: Option<Demanded>,
}

impl BrokenLaw {
    /// What numbers were compared with, if it was a law, and which of its demands they meet least.
    const fn of(against: Against, demanded: Option<Demanded>) -> Option<Self> {
        match against {
            Against::Law(name) => Some(Self { name, demanded }),
            Against::Oracle(_) | Against::Own => None,
        }
    }
}

/// Why a counter-example cannot be replayed.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ReplayError {
    /// Another kind of file, or one of another version.
    #[error("schema {0:?}, not {SCHEMA:?}")]
    Schema(String),
    /// Values that make nothing that can be judged.
    #[error("its values: {0}")]
    Values(String),
    /// A number that is infinite or not a number.
    #[error("{place} has the value {value}, which is not finite")]
    NotFinite {
        /// Where.
        place: String,
        /// Infinite, or not a number.
        value: f64,
    },
}

/// Refuses a document of another schema.
fn check_schema(schema: &str) -> Result<(), ReplayError> {
    if schema == SCHEMA { Ok(()) } else { Err(ReplayError::Schema(schema.to_string())) }
}

impl CounterExample {
    /// Reads a file's text.
    ///
    /// # Errors
    /// What is no counter-example: no JSON, another schema, missing or unknown fields.
    pub fn read(text: &str) -> Result<Self, serde_json::Error> {
        #[derive(Deserialize)]
        struct Header {
            schema: String,
        }
        let header: Header = serde_json::from_str(text)?;
        check_schema(&header.schema).map_err(serde::de::Error::custom)?;
        serde_json::from_str(text)
    }

    /// Of a check that failed; `None` for one that did not, of which nothing was kept, or with a value that is not finite.
    pub fn of(check: &Check, subject: &str) -> Option<Self> {
        let (failing, worst) = (check.failing.as_deref()?, check.worst.as_ref()?);
        let example = Self {
            subject: subject.to_string(),
            quantity: check.quantity,
            entry: worst.entry.clone(),
            law: BrokenLaw::of(check.against, worst.demanded),
            sum: worst.sum.to_vec(),
            got: Hex(worst.got),
            want: Hex(worst.want),
            tolerance: Hex(worst.tolerance),
            ..Self::of_values(failing, check.against)
        };
        // What is not finite has no place in a document, and would be lost.
        example.plain().is_ok().then_some(example)
    }

    /// The values of a case, with no verdict on it.
    pub fn record(case: &Case, against: Against) -> Self {
        Self::of_values(&Failing::Connector(Box::new(case.clone())), against)
    }

    fn of_values(failing: &Failing, against: Against) -> Self {
        let values = serde_json::to_value(failing).ok();
        let values = values.and_then(|mut tagged| Some(tagged.get_mut("values")?.take()));
        Self {
            schema: SCHEMA.to_string(),
            version: pintle_kinematics::VERSION.to_string(),
            kind: About::of(failing),
            subject: "pintle".to_string(),
            against: against.name().to_string(),
            quantity: None,
            entry: String::new(),
            law: BrokenLaw::of(against, None),
            sum: Vec::new(),
            got: Hex(0.0),
            want: Hex(0.0),
            tolerance: Hex(0.0),
            oracles: Vec::new(),
            values: values.map_or(Value::Null, hexadecimal),
        }
    }

    /// The same as what these oracles found.
    pub fn found_by(mut self, asked: &BTreeSet<Oracle>) -> Self {
        if *asked != BTreeSet::from(Oracle::ALL) {
            self.oracles = asked.iter().copied().collect();
        }
        self
    }

    /// The oracles that found it: a replay must ask the same.
    pub fn oracles(&self) -> BTreeSet<Oracle> {
        if self.oracles.is_empty() { Oracle::ALL.into() } else { self.oracles.iter().copied().collect() }
    }

    /// What failed, bit for bit.
    ///
    /// # Errors
    /// Another schema; values that make no such thing: a number that is not finite; of a connector an unknown type, no state, a triad that
    /// is no rotation, a length that is not positive, stops that leave nothing between them.
    pub fn failing(&self) -> Result<Failing, ReplayError> {
        check_schema(&self.schema)?;
        let failing = self.plain()?;
        if let Failing::Connector(case) = &failing {
            check_case(case)?;
        }
        if let Some(lost) = self.sum.iter().find(|summand| !summand.by.is_finite()) {
            return Err(ReplayError::NotFinite { place: "sum".to_string(), value: lost.by });
        }
        Ok(failing)
    }

    /// What failed, of whatever values.
    fn plain(&self) -> Result<Failing, ReplayError> {
        let values = decimal(self.values.clone(), "")?;
        if self.kind != About::Connector {
            check_indices(&values, "")?;
        }
        serde_json::from_value(json!({"kind": self.kind, "values": values}))
            .map_err(|error| ReplayError::Values(format!("they make no {}: {error}", self.kind.name())))
    }

    /// The case of a connector.
    ///
    /// # Errors
    /// Those of [`CounterExample::failing`]; what is of no connector.
    pub fn case(&self) -> Result<Case, ReplayError> {
        match self.failing()? {
            Failing::Connector(case) => Ok(*case),
            _ => Err(ReplayError::Values(format!("they are of a {}, not of a connector", self.kind.name()))),
        }
    }

    /// Whether a law is broken that is asked of every state of a connector.
    pub(super) fn is_of_a_law_of_states(&self) -> bool {
        use Invariant::{Carried, FreeAxis, Start, Turns};
        self.law.is_some_and(|law| !matches!(law.name, Start | Turns | FreeAxis | Carried))
    }

    /// Whether it is Taylor's remainder that falls too slowly.
    pub(super) fn is_of_taylor(&self) -> bool {
        self.against == Oracle::Taylor.name()
    }

    /// Taylor's remainder `f(q + hv) − f(q) − h ∂f·v` over h of the row in question, as this version of the program gives it at the
    /// recorded state along the recorded direction v. It is in units of what it may be, at the worst of the steps h: at most 1 of a
    /// right row. Values are on 237 bits.
    ///
    /// # Errors
    /// What cannot be replayed; what is no such remainder, or does not say along which direction.
    pub fn remainder(&self) -> Result<f64, ReplayError> {
        self.taylor().map(|(_, remainder)| remainder.units())
    }

    /// The direction and the remainder.
    pub(super) fn taylor(&self) -> Result<([f64; DOFS], Remainder), ReplayError> {
        let refuse = |why: &str| Err(ReplayError::Values(format!("{}: {why}", self.entry)));
        let case = self.case()?;
        let Some(first) = self.sum.first().filter(|_| self.is_of_taylor()) else {
            return refuse("it is no remainder of Taylor's along a direction that it says (`sum`)");
        };
        let mut v = [0.0; DOFS];
        for Summand { quantity, component, entry, by } in &self.sum {
            match v.get_mut(*entry) {
                Some(x) if (*quantity, *component) == (Quantity::FirstDerivatives, first.component) => {
                    *x = *by;
                }
                _ => return refuse("`sum` is no row along a direction"),
            }
        }
        match remainder_along(&case, first.component, &v) {
            Some(remainder) => Ok((v, remainder)),
            None => refuse("the connector has no such row that Taylor's test can judge"),
        }
    }
}

/// Whether values make a connector at states.
fn check_case(case: &Case) -> Result<(), ReplayError> {
    let refuse = |why: String| Err(ReplayError::Values(why));
    if case.path.is_empty() {
        return refuse("path has no state".to_string());
    }
    if case.length <= 0.0 {
        return refuse(format!("length is {}, not a positive length", case.length));
    }
    for (k, stop) in case.definition.stops.iter().enumerate() {
        if let Some((lower, upper)) = stop.and_then(|stop| stop.lower.zip(stop.upper))
            && lower > upper
        {
            return refuse(format!(
                "definition.stops[{k}] is {lower} to {upper}, which leaves nothing between"
            ));
        }
    }
    check_triads(&case.definition.initial, "definition.initial")?;
    let mut steps = case.path.iter().enumerate();
    steps.try_for_each(|(n, step)| check_triads(&step.state.pair, &format!("path[{n}].state.pair")))
}

/// Refuses triads that are no rotations.
fn check_triads(pair: &Pair<f64>, place: &str) -> Result<(), ReplayError> {
    /// So far may the products of a triad's directions be from those of a rotation.
    const SLACK: f64 = 1e-8;
    for (end, node) in [("a", &pair.a), ("b", &pair.b)] {
        let [x, y, z] = transpose(&node.triad);
        let products = [(x, x, 1.0), (y, y, 1.0), (x, y, 0.0), (cross(x, y), z, 1.0), (z, z, 1.0)];
        if products.iter().any(|(v, w, wanted)| (dot(*v, *w) - wanted).abs() > SLACK) {
            return Err(ReplayError::Values(format!("{place}.{end}.triad is no right-handed rotation")));
        }
    }
    Ok(())
}

/// The same with every double in hexadecimal.
fn hexadecimal(value: Value) -> Value {
    match value {
        Value::Number(x) if x.is_f64() => x.as_f64().map_or(Value::Null, |x| Hex(x).to_string().into()),
        Value::Array(all) => all.into_iter().map(hexadecimal).collect(),
        Value::Object(all) => all.into_iter().map(|(name, value)| (name, hexadecimal(value))).collect(),
        other => other,
    }
}

/// The same with every double as a number; `place` is where it stands, as errors name it.
fn decimal(value: Value, place: &str) -> Result<Value, ReplayError> {
    match value {
        Value::String(text) if is_number(&text) => {
            let x: Hex = text.parse().map_err(|error| ReplayError::Values(format!("{error}")))?;
            Number::from_f64(x.0)
                .map(Value::Number)
                .ok_or(ReplayError::NotFinite { place: place.to_string(), value: x.0 })
        }
        Value::Array(all) => {
            let all = all.into_iter().enumerate();
            all.map(|(i, value)| decimal(value, &format!("{place}[{i}]"))).collect()
        }
        Value::Object(all) => {
            let within =
                |name: &str| if place.is_empty() { name.to_string() } else { format!("{place}.{name}") };
            let all = all.into_iter().map(|(name, value)| {
                let value = decimal(value, &within(&name))?;
                Ok((name, value))
            });
            Ok(Value::Object(all.collect::<Result<_, ReplayError>>()?))
        }
        other => Ok(other),
    }
}

/// Whether a text is meant as a number, finite or not.
fn is_number(text: &str) -> bool {
    let size = text.trim_start_matches('-');
    size.starts_with("0x") || matches!(size, "inf" | "nan")
}

/// Integers are places of components, from 0, but for the columns of tables, field variables and the numbers of factors.
fn check_indices(value: &Value, name: &str) -> Result<(), ReplayError> {
    const COMPONENTS: u64 = 6;
    let most = match name {
        "number" => return Ok(()),
        "Column" => COMPONENTS,
        "Field" | "structural" => 1000,
        _ => COMPONENTS - 1,
    };
    match value {
        Value::Number(x) if !x.is_f64() => match x.as_u64() {
            Some(x) if x <= most => Ok(()),
            _ => Err(ReplayError::Values(format!("{name} {x} is no place of a component, from 0"))),
        },
        Value::Array(all) => all.iter().try_for_each(|value| check_indices(value, name)),
        Value::Object(all) => all.iter().try_for_each(|(name, value)| check_indices(value, name)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::{decimal, hexadecimal};
    use serde_json::json;

    #[test]
    fn doubles_are_hexadecimal_and_integers_are_not() {
        let plain = json!({"a": [0.1, -2.0, 3], "name": "0 x", "none": null, "on": true});
        let hex = hexadecimal(plain.clone());
        assert_eq!(hex["a"], json!(["0x1.999999999999ap-4", "-0x1p+1", 3]));
        assert_eq!(decimal(hex, "").ok(), Some(plain));
        assert!(decimal(json!(["0x1.zp+0"]), "").is_err() && decimal(json!("0x1p+1024"), "").is_err());
    }
}
