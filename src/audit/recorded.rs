//! Counter-examples of what is no connector: a multi-point constraint, a friction, a belt, springs and dampers. The same file as that of
//! a connector ([`super::counterexample`]) with a kind, and all values that the numbers follow from, bit for bit.

use super::counterexample::{ReplayError, SCHEMA};
use super::failing::Failing;
use super::hex::Hex;
use super::oracle::Oracle;
use super::outcome::Check;
use super::quantity::Quantity;
use super::shrink::{bits_of, simpler};
use crate::scene::{Format, Scene, State, StateFile};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Number, Value};

/// What a file is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A multi-point constraint at a state.
    Mpc,
    /// A friction in an increment.
    Friction,
    /// A belt around a ring in an increment.
    Belt,
    /// Springs and dampers at a motion.
    Slopes,
}

impl Kind {
    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mpc => "multi-point constraint",
            Self::Friction => "friction",
            Self::Belt => "belt around a ring",
            Self::Slopes => "slope of a behaviour",
        }
    }
}

/// One failing check at one state, everything in it bit-exact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorded {
    /// [`SCHEMA`].
    pub schema: String,
    /// The version of pintle that wrote it.
    pub version: String,
    /// What it is about.
    pub kind: Kind,
    /// Who gave the numbers.
    pub subject: String,
    /// What they were compared with.
    pub against: String,
    /// The kind of number.
    pub quantity: Option<Quantity>,
    /// The entry by name.
    pub entry: String,
    /// What was given.
    pub got: Hex,
    /// What it must be.
    pub want: Hex,
    /// How far it may be from that.
    pub tolerance: Hex,
    /// The oracles that were asked; none written is all of them. A replay asks the same.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub oracles: Vec<Oracle>,
    /// The values, doubles in hexadecimal.
    pub values: Value,
    /// The scene that it was found in, where it was at one of the states given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub found_in: Option<FoundIn>,
}

/// The scene of a counter-example, as it was audited: not shrunk.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FoundIn {
    /// The number of the state.
    pub state: u64,
    /// The deck.
    pub deck: String,
    /// The states up to that one with their forces, in the form of `--states`.
    pub states: String,
}

impl Recorded {
    /// Of a check that failed; `None` for one that did not, of a connector, or with a value that is not finite.
    pub fn of(check: &Check, subject: &str) -> Option<Self> {
        let (failing, worst) = (check.failing.as_ref()?, check.worst.as_ref()?);
        let (kind, values) = plain(failing)?;
        let recorded = Self {
            schema: SCHEMA.to_string(),
            version: crate::VERSION.to_string(),
            kind,
            subject: subject.to_string(),
            against: check.against.name().to_string(),
            quantity: check.quantity,
            entry: worst.entry.clone(),
            got: Hex(worst.got),
            want: Hex(worst.want),
            tolerance: Hex(worst.tolerance),
            oracles: Vec::new(),
            values: hexadecimal(values),
            found_in: None,
        };
        // What is not finite has no place in a document, and would be lost.
        recorded.failing().is_ok().then_some(recorded)
    }

    /// The values of what is no connector, with no verdict on them.
    pub(super) fn stated(failing: &Failing) -> Option<Self> {
        let (kind, values) = plain(failing)?;
        Some(Self {
            schema: SCHEMA.to_string(),
            version: crate::VERSION.to_string(),
            kind,
            subject: "pintle".to_string(),
            against: String::new(),
            quantity: None,
            entry: String::new(),
            got: Hex(0.0),
            want: Hex(0.0),
            tolerance: Hex(0.0),
            oracles: Vec::new(),
            values: hexadecimal(values),
            found_in: None,
        })
    }

    /// The same with the scene that it was found in, for what does not follow from a state of nodes alone: frictions, belts, springs and
    /// dampers at one of the `states`, under forces that these give. Nothing is added where it was at drawn states or forces, or where the
    /// scene is too large to be handed over.
    #[must_use]
    pub fn found_in(self, scene: &Scene, states: &[State]) -> Self {
        /// A megabyte of deck, or of states.
        const LARGEST: usize = 1 << 20;
        let name = self.values.get("name").and_then(Value::as_str).unwrap_or_default();
        let number = name.rsplit_once(" at state ").and_then(|(_, number)| number.parse::<u64>().ok());
        let Some(number) = number.filter(|_| self.kind != Kind::Mpc) else { return self };
        let of = |index: usize, state: &State| state.number.unwrap_or(index as u64);
        let until = states.iter().enumerate().filter(|(index, state)| of(*index, state) <= number);
        let states: Vec<State> = until.map(|(_, state)| state.clone()).collect();
        let bare = Scene { states: Vec::new(), ..scene.clone() };
        let (Ok(deck), Ok(states)) = (bare.write(Format::Deck), StateFile { states }.to_json()) else {
            return self;
        };
        if deck.text.len().max(states.len()) > LARGEST {
            return self;
        }
        Self { found_in: Some(FoundIn { state: number, deck: deck.text, states }), ..self }
    }

    /// What failed, bit for bit.
    ///
    /// # Errors
    /// Another schema, values that make no such thing, values that are not finite.
    pub fn failing(&self) -> Result<Failing, ReplayError> {
        if self.schema != SCHEMA {
            return Err(ReplayError::Schema(self.schema.clone()));
        }
        let values = decimal(self.values.clone())?;
        check_indices(&values, "")?;
        of_plain(self.kind, values).ok_or_else(|| self.refusal())
    }

    fn refusal(&self) -> ReplayError {
        let values = decimal(self.values.clone()).unwrap_or_default();
        let why = match self.kind {
            Kind::Mpc => why::<super::mpc::MpcCase>(values),
            Kind::Friction => why::<super::friction::FrictionCase>(values),
            Kind::Belt => why::<super::friction::BeltCase>(values),
            Kind::Slopes => why::<super::behavior::SlopesCase>(values),
        };
        ReplayError::Values(format!("they make no {}: {why}", self.kind.name()))
    }

    /// The simplest values found that still fail: the identity in place of a rotation, zero, one, or few bits in place of each number.
    pub(super) fn shrunk(failing: &Failing, fails: &dyn Fn(&Failing) -> bool) -> Failing {
        /// So often is it tried, for each trial is an audit.
        const TRIALS: usize = 200;
        let Some((kind, mut best)) = plain(failing) else { return failing.clone() };
        let mut left = TRIALS;
        let mut attempt = |changed: Value, best: &mut Value| {
            if left == 0 {
                return false;
            }
            left -= 1;
            let kept = of_plain(kind, changed.clone()).is_some_and(|changed| fails(&changed));
            if kept {
                *best = changed;
            }
            kept
        };
        for path in paths(&best, &is_rotation) {
            let mut changed = best.clone();
            if let Some(place) = changed.pointer_mut(&path) {
                *place = serde_json::json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
            }
            attempt(changed, &mut best);
        }
        let is_double = |value: &Value| value.is_f64();
        // What sizes are measured by is no part of the state, and an axis stays of unit length.
        let is_kept = |path: &String| path.ends_with("/length") || path.starts_with("/constraint/axes/");
        for path in paths(&best, &is_double).into_iter().filter(|path| !is_kept(path)) {
            // Part of a rotation is no number by itself.
            let matrix = path.rsplitn(3, '/').nth(2).unwrap_or_default();
            if best.pointer(matrix).is_some_and(is_rotation) {
                continue;
            }
            let Some(x) = best.pointer(&path).and_then(Value::as_f64) else { continue };
            for y in simpler(x).into_iter().filter(|y| bits_of(*y) < bits_of(x)) {
                let mut changed = best.clone();
                if let (Some(place), Some(y)) = (changed.pointer_mut(&path), Number::from_f64(y)) {
                    *place = Value::Number(y);
                }
                if attempt(changed, &mut best) {
                    break;
                }
            }
        }
        of_plain(kind, best).unwrap_or_else(|| failing.clone())
    }
}

/// The values of what is no connector, doubles as numbers.
fn plain(failing: &Failing) -> Option<(Kind, Value)> {
    match failing {
        Failing::Connector(_) => None,
        Failing::Mpc(case) => Some((Kind::Mpc, serde_json::to_value(case).ok()?)),
        Failing::Friction(case) => Some((Kind::Friction, serde_json::to_value(case).ok()?)),
        Failing::Belt(case) => Some((Kind::Belt, serde_json::to_value(case).ok()?)),
        Failing::Slopes(case) => Some((Kind::Slopes, serde_json::to_value(case).ok()?)),
    }
}

fn of_plain(kind: Kind, values: Value) -> Option<Failing> {
    match kind {
        Kind::Mpc => serde_json::from_value(values).ok().map(Failing::Mpc),
        Kind::Friction => serde_json::from_value(values).ok().map(Failing::Friction),
        Kind::Belt => serde_json::from_value(values).ok().map(Failing::Belt),
        Kind::Slopes => serde_json::from_value(values).ok().map(Failing::Slopes),
    }
}

fn why<T: DeserializeOwned>(values: Value) -> String {
    serde_json::from_value::<T>(values).err().map_or_else(String::new, |error| error.to_string())
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

/// The same with every double as a number.
fn decimal(value: Value) -> Result<Value, ReplayError> {
    match value {
        Value::String(text) if text.trim_start_matches('-').starts_with("0x") => {
            let x: Hex = text.parse().map_err(|error| ReplayError::Values(format!("{error}")))?;
            Number::from_f64(x.0)
                .map(Value::Number)
                .ok_or(ReplayError::NotFinite { place: "values".to_string(), value: x.0 })
        }
        Value::Array(all) => Ok(Value::Array(all.into_iter().map(decimal).collect::<Result<_, _>>()?)),
        Value::Object(all) => {
            let all = all.into_iter().map(|(name, value)| Ok((name, decimal(value)?)));
            Ok(Value::Object(all.collect::<Result<_, ReplayError>>()?))
        }
        other => Ok(other),
    }
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

/// Whether a value is a 3 × 3 matrix with rows of unit length.
fn is_rotation(value: &Value) -> bool {
    let rows = value.as_array().filter(|rows| rows.len() == 3);
    rows.is_some_and(|rows| {
        rows.iter().all(|row| {
            let numbers: Option<Vec<f64>> = row
                .as_array()
                .and_then(|row| row.iter().map(|x| x.as_f64().filter(|_| x.is_f64())).collect());
            numbers.is_some_and(|row| {
                row.len() == 3 && (row.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-9
            })
        })
    })
}

/// The places of values of some sort, as JSON pointers.
fn paths(value: &Value, is_it: &dyn Fn(&Value) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    let mut waiting = vec![(String::new(), value)];
    while let Some((path, value)) = waiting.pop() {
        if is_it(value) {
            found.push(path.clone());
        }
        match value {
            Value::Array(all) => {
                waiting.extend(all.iter().enumerate().rev().map(|(i, value)| (format!("{path}/{i}"), value)));
            }
            Value::Object(all) => {
                let name = |name: &str| name.replace('~', "~0").replace('/', "~1");
                waiting.extend(all.iter().map(|(key, value)| (format!("{path}/{}", name(key)), value)));
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{decimal, hexadecimal, is_rotation, paths};
    use serde_json::json;

    #[test]
    fn doubles_are_hexadecimal_and_integers_are_not() {
        let plain = json!({"a": [0.1, -2.0, 3], "name": "0 x", "none": null, "on": true});
        let hex = hexadecimal(plain.clone());
        assert_eq!(hex["a"], json!(["0x1.999999999999ap-4", "-0x1p+1", 3]));
        assert_eq!(decimal(hex).ok(), Some(plain));
        assert!(decimal(json!(["0x1.zp+0"])).is_err() && decimal(json!("0x1p+1024")).is_err());
    }

    #[test]
    fn rotations_are_found() {
        let turn = json!([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        let all = json!({"state": {"body": [turn, [1.0, 0.0, 0.0]]}});
        assert_eq!(paths(&all, &is_rotation), ["/state/body/0"]);
        assert!(!is_rotation(&json!([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])));
    }
}
