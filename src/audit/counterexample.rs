//! A counter-example as values, not as the seed of a random stream: every number bit for bit, so that any version on any
//! machine sees the same state.

use super::case::{Case, Step};
use super::failing::Failing;
use super::hex::Hex;
use super::invariant::{Demanded, Invariant};
use super::oracle::{Oracle, Remainder};
use super::outcome::{Against, Check};
use super::quantity::Quantity;
use super::sums::remainder_along;
use super::verdict::Summand;
use crate::catalog::{ConnectionType, NameError};
use crate::connector::{Branch, Definition, Increment, State, Stop, Turns};
use crate::node::{DOFS, Node, Pair};
use crate::vector::{Matrix, Vector};
use serde::{Deserialize, Serialize};

/// The schema of the file.
pub const SCHEMA: &str = "pintle-counterexample/1";

type HexVector = [Hex; 3];
type HexMatrix = [[Hex; 3]; 3];

/// One failing check at one state, everything in it bit-exact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CounterExample {
    /// [`SCHEMA`].
    pub schema: String,
    /// The version of pintle that wrote it.
    pub version: String,
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
    pub sum: Vec<SummandValues>,
    /// What was given.
    pub got: Hex,
    /// What it must be.
    pub want: Hex,
    /// How far it may be from that.
    pub tolerance: Hex,
    /// The connector.
    pub connector: ConnectorValues,
    /// The oracles that were asked; none written is all of them. A replay asks the same.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub oracles: Vec<Oracle>,
    /// The state by name, from which Taylor's and hyper-dual directions are drawn: a replay takes the same.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub state: String,
    /// What the states before left; none is the initial branch.
    pub start: Option<BranchValues>,
    /// The states up to the one judged.
    pub path: Vec<StepValues>,
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

/// A number of a connector in a sum, in values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SummandValues {
    /// The kind of number.
    pub quantity: Quantity,
    /// The component (0-based).
    pub component: usize,
    /// The place within it.
    pub entry: usize,
    /// What it is multiplied by.
    pub by: Hex,
}

impl SummandValues {
    const fn of(summand: &Summand) -> Self {
        let Summand { quantity, component, entry, by } = *summand;
        Self { quantity, component, entry, by: Hex(by) }
    }
}

/// A connector in values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConnectorValues {
    /// One type, or a basic translational and a basic rotational one.
    pub types: Vec<String>,
    /// The initial state.
    pub initial: PairValues,
    /// β_s (rad/length).
    pub flow_scale: Hex,
    /// The direction of a coincident AXIAL.
    pub fixed_direction: HexVector,
    /// Reference lengths and angles (degrees).
    pub references: [Option<Hex>; 6],
    /// Lower and upper stops.
    pub stops: [Option<[Option<Hex>; 2]>; 6],
    /// Two-dimensional.
    pub planar: bool,
    /// Whether a and b have degrees of freedom.
    pub moves: [bool; 2],
    /// Whether a and b have rotational ones.
    pub rotates: [bool; 2],
    /// s, the connector's own length.
    pub length: Hex,
}

/// Two nodes in values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairValues {
    /// X_b − X_a.
    pub reference: HexVector,
    /// U_a, U_b.
    pub displacement: [HexVector; 2],
    /// The triads, directions as columns.
    pub triad: [HexMatrix; 2],
    /// Ψ_a, Ψ_b.
    pub flow: [Hex; 2],
}

/// One state in values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepValues {
    /// The nodes.
    pub pair: PairValues,
    /// Rates, in the order of the nodal degrees of freedom.
    pub velocity: Vec<Hex>,
    /// Accelerations.
    pub acceleration: Vec<Hex>,
    /// Δθ of a and b.
    pub rotation: [HexVector; 2],
    /// The whole turns in them.
    pub whole_turns: [HexVector; 2],
    /// ΔΨ of a and b.
    pub flow_change: [Hex; 2],
}

/// A branch in values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BranchValues {
    /// (turns, principal) of each component, then of the torsion.
    pub turns: Vec<[Hex; 2]>,
    /// The last well-conditioned rotation vector.
    pub rotation_vector: HexVector,
    /// The sign of sin β.
    pub euler_sign: Hex,
    /// The sum of a one-form, and what rounding left out of it.
    pub accumulated: [Hex; 2],
}

/// Why a counter-example cannot be replayed.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ReplayError {
    /// Another kind of file.
    #[error("schema {0:?}, not {SCHEMA:?}")]
    Schema(String),
    /// No such type.
    #[error(transparent)]
    Type(#[from] NameError),
    /// The wrong number of values.
    #[error("{what} has {found} values, not {wanted}")]
    Count {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        wanted: usize,
    },
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

fn hex(v: Vector<f64>) -> HexVector {
    v.map(Hex)
}

fn hex_matrix(m: &Matrix<f64>) -> HexMatrix {
    m.map(hex)
}

fn plain(v: HexVector) -> Vector<f64> {
    v.map(|x| x.0)
}

fn plain_matrix(m: &HexMatrix) -> Matrix<f64> {
    m.map(plain)
}

impl PairValues {
    fn of(pair: &Pair<f64>) -> Self {
        Self {
            reference: hex(pair.reference),
            displacement: [hex(pair.a.displacement), hex(pair.b.displacement)],
            triad: [hex_matrix(&pair.a.triad), hex_matrix(&pair.b.triad)],
            flow: [Hex(pair.a.flow), Hex(pair.b.flow)],
        }
    }

    /// Refuses what is not finite, and triads that are no rotations.
    fn check(&self, place: &str) -> Result<(), ReplayError> {
        /// So far may the products of a triad's directions be from those of a rotation.
        const SLACK: f64 = 1e-8;
        finite(&format!("{place}.reference"), self.reference)?;
        finite(&format!("{place}.displacement"), self.displacement.into_iter().flatten())?;
        finite(&format!("{place}.flow"), self.flow)?;
        for (end, triad) in ["a", "b"].iter().zip(&self.triad) {
            finite(&format!("{place}.triad of {end}"), triad.iter().flatten().copied())?;
            let [x, y, z] = crate::vector::transpose(&plain_matrix(triad));
            let third = crate::vector::cross(x, y);
            let products = [(x, x, 1.0), (y, y, 1.0), (x, y, 0.0), (third, z, 1.0), (z, z, 1.0)];
            if products.iter().any(|(v, w, wanted)| (crate::vector::dot(*v, *w) - wanted).abs() > SLACK) {
                return Err(ReplayError::Values(format!(
                    "{place}.triad of {end} is no right-handed rotation"
                )));
            }
        }
        Ok(())
    }

    fn pair(&self) -> Pair<f64> {
        let node = |end: usize| Node {
            displacement: plain(self.displacement[end]),
            triad: plain_matrix(&self.triad[end]),
            flow: self.flow[end].0,
        };
        Pair { reference: plain(self.reference), a: node(0), b: node(1) }
    }
}

impl StepValues {
    fn of(step: &Step) -> Self {
        Self {
            pair: PairValues::of(&step.state.pair),
            velocity: step.state.velocity.map(Hex).to_vec(),
            acceleration: step.state.acceleration.map(Hex).to_vec(),
            rotation: step.increment.rotation.map(hex),
            whole_turns: step.increment.whole_turns.map(hex),
            flow_change: step.increment.flow.map(Hex),
        }
    }

    fn step(&self) -> Result<Step, ReplayError> {
        let rates = |what: &'static str, values: &[Hex]| -> Result<[f64; DOFS], ReplayError> {
            let count = ReplayError::Count { what, found: values.len(), wanted: DOFS };
            let plain: Vec<f64> = values.iter().map(|x| x.0).collect();
            plain.try_into().map_err(|_| count)
        };
        Ok(Step {
            state: State {
                pair: self.pair.pair(),
                velocity: rates("velocity", &self.velocity)?,
                acceleration: rates("acceleration", &self.acceleration)?,
            },
            increment: Increment {
                rotation: self.rotation.map(plain),
                whole_turns: self.whole_turns.map(plain),
                flow: self.flow_change.map(|x| x.0),
            },
        })
    }
}

impl BranchValues {
    fn of(branch: &Branch<f64>) -> Self {
        let both = |t: &Turns<f64>| [Hex(t.turns), Hex(t.principal)];
        Self {
            turns: branch.turns.iter().chain([&branch.torsion]).map(both).collect(),
            rotation_vector: hex(branch.rotation_vector),
            euler_sign: Hex(branch.euler_sign),
            accumulated: [Hex(branch.accumulated), Hex(branch.accumulated_rest)],
        }
    }

    fn branch(&self) -> Result<Branch<f64>, ReplayError> {
        const WANTED: usize = 7;
        let found = self.turns.len();
        let count = ReplayError::Count { what: "turns", found, wanted: WANTED };
        let all: Vec<Turns<f64>> = self
            .turns
            .iter()
            .map(|[turns, principal]| Turns { turns: turns.0, principal: principal.0 })
            .collect();
        let all: [Turns<f64>; WANTED] = all.try_into().map_err(|_| count)?;
        let [t1, t2, t3, t4, t5, t6, torsion] = all;
        Ok(Branch {
            turns: [t1, t2, t3, t4, t5, t6],
            torsion,
            rotation_vector: plain(self.rotation_vector),
            euler_sign: self.euler_sign.0,
            accumulated: self.accumulated[0].0,
            accumulated_rest: self.accumulated[1].0,
        })
    }
}

impl ConnectorValues {
    fn of(definition: &Definition, length: f64) -> Self {
        let types = match definition.connection.halves {
            [Some(t), Some(r)] => vec![t.name.to_string(), r.name.to_string()],
            _ => vec![definition.connection.name.to_string()],
        };
        Self {
            types,
            initial: PairValues::of(&definition.initial),
            flow_scale: Hex(definition.flow_scale),
            fixed_direction: hex(definition.fixed_direction),
            references: definition.references.map(|x| x.map(Hex)),
            stops: definition.stops.map(|stop| stop.map(|s| [s.lower.map(Hex), s.upper.map(Hex)])),
            planar: definition.planar,
            moves: definition.moves,
            rotates: definition.rotates,
            length: Hex(length),
        }
    }

    fn definition(&self) -> Result<Definition, ReplayError> {
        let connection = match self.types.as_slice() {
            [one] => ConnectionType::named(one, None)?,
            [translational, rotational] => ConnectionType::named(translational, Some(rotational))?,
            others => return Err(ReplayError::Count { what: "types", found: others.len(), wanted: 1 }),
        };
        Ok(Definition {
            flow_scale: self.flow_scale.0,
            fixed_direction: plain(self.fixed_direction),
            references: self.references.map(|x| x.map(|x| x.0)),
            stops: self.stops.map(|stop| {
                stop.map(|[lower, upper]| Stop { lower: lower.map(|x| x.0), upper: upper.map(|x| x.0) })
            }),
            planar: self.planar,
            moves: self.moves,
            rotates: self.rotates,
            ..Definition::new(connection, self.initial.pair())
        })
    }
}

impl CounterExample {
    /// Of a check of a connector that failed; `None` for any other.
    pub fn of(check: &Check, subject: &str) -> Option<Self> {
        let (Failing::Connector(case), worst) = (check.failing.as_deref()?, check.worst.as_ref()?) else {
            return None;
        };
        Some(Self {
            schema: SCHEMA.to_string(),
            version: crate::VERSION.to_string(),
            subject: subject.to_string(),
            against: check.against.name().to_string(),
            quantity: check.quantity,
            entry: worst.entry.clone(),
            law: BrokenLaw::of(check.against, worst.demanded),
            sum: worst.sum.iter().map(SummandValues::of).collect(),
            got: Hex(worst.got),
            want: Hex(worst.want),
            tolerance: Hex(worst.tolerance),
            connector: ConnectorValues::of(&case.definition, case.length),
            oracles: Vec::new(),
            state: case.name.clone(),
            start: case.start.as_ref().map(BranchValues::of),
            path: case.path.iter().map(StepValues::of).collect(),
        })
    }

    /// The values of a case, with no verdict on it.
    pub fn record(case: &Case, against: Against) -> Self {
        Self {
            schema: SCHEMA.to_string(),
            version: crate::VERSION.to_string(),
            subject: "pintle".to_string(),
            against: against.name().to_string(),
            quantity: None,
            entry: String::new(),
            law: BrokenLaw::of(against, None),
            sum: Vec::new(),
            got: Hex(0.0),
            want: Hex(0.0),
            tolerance: Hex(0.0),
            connector: ConnectorValues::of(&case.definition, case.length),
            oracles: Vec::new(),
            state: case.name.clone(),
            start: case.start.as_ref().map(BranchValues::of),
            path: case.path.iter().map(StepValues::of).collect(),
        }
    }

    /// Whether a law is broken: as it says, or in files of versions that had no such field, by the law's words.
    pub(super) fn is_of_a_law(&self) -> bool {
        self.broken_law().is_some()
    }

    /// The law that is broken.
    pub(super) fn broken_law(&self) -> Option<Invariant> {
        let named = || Invariant::ALL.into_iter().find(|law| law.name() == self.against);
        self.law.map(|law| law.name).or_else(named)
    }

    /// Whether a law is broken that is asked of every state of a connector.
    pub(super) fn is_of_a_law_of_states(&self) -> bool {
        use Invariant::{Carried, FreeAxis, Start, Turns};
        self.broken_law().is_some_and(|law| !matches!(law, Start | Turns | FreeAxis | Carried))
    }

    /// Whether it is Taylor's remainder that falls too slowly.
    pub(super) fn is_of_taylor(&self) -> bool {
        self.against == Oracle::Taylor.name()
    }

    /// Taylor's remainder f(q + hv) − f(q) − h ∂f·v over h of the row in question, as this version of the program gives it at the recorded
    /// state along the recorded direction v, in units of what it may be, at the worst of the steps h: at most 1 of a right row. Values
    /// are on 237 bits.
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
        for SummandValues { quantity, component, entry, by } in &self.sum {
            match v.get_mut(*entry) {
                Some(x) if (*quantity, *component) == (Quantity::FirstDerivatives, first.component) => {
                    *x = by.0;
                }
                _ => return refuse("`sum` is no row along a direction"),
            }
        }
        match remainder_along(&case, first.component, &v) {
            Some(remainder) => Ok((v, remainder)),
            None => refuse("the connector has no such row that Taylor's test can judge"),
        }
    }

    /// The case, bit for bit.
    ///
    /// # Errors
    /// Another schema, an unknown type, a wrong number of values, values that make no state: a number that is not finite, a triad
    /// that is no rotation, a length that is not positive, stops that leave nothing between them.
    pub fn case(&self) -> Result<Case, ReplayError> {
        if self.schema != SCHEMA {
            return Err(ReplayError::Schema(self.schema.clone()));
        }
        let definition = self.connector.definition()?;
        let path: Vec<Step> = self.path.iter().map(StepValues::step).collect::<Result<_, _>>()?;
        if path.is_empty() {
            return Err(ReplayError::Count { what: "path", found: 0, wanted: 1 });
        }
        let start = self.start.as_ref().map(BranchValues::branch).transpose()?;
        self.check_values()?;
        finite("sum", self.sum.iter().map(|summand| summand.by))?;
        let name = match self.state.as_str() {
            "" => format!("{} replayed", definition.connection.name),
            state => state.to_string(),
        };
        Ok(Case { name, definition, start, path, length: self.connector.length.0 })
    }
    /// Whether the values make a connector at states.
    fn check_values(&self) -> Result<(), ReplayError> {
        let connector = &self.connector;
        let refuse = |why: String| Err(ReplayError::Values(why));
        if !(connector.length.0 > 0.0 && connector.length.0.is_finite()) {
            return refuse(format!("connector.length is {}, not a positive length", connector.length.0));
        }
        connector.initial.check("connector.initial")?;
        finite("connector.flow_scale", [connector.flow_scale])?;
        finite("connector.fixed_direction", connector.fixed_direction)?;
        finite("connector.references", connector.references.into_iter().flatten())?;
        for (index, stop) in connector.stops.iter().enumerate() {
            let Some(bounds) = stop else { continue };
            let place = format!("connector.stops[{index}]");
            finite(&place, bounds.iter().flatten().copied())?;
            if let [Some(lower), Some(upper)] = bounds
                && lower.0 > upper.0
            {
                return refuse(format!(
                    "{place} is {} to {}, which leaves nothing between",
                    lower.0, upper.0
                ));
            }
        }
        if let Some(start) = &self.start {
            finite("start.turns", start.turns.iter().flatten().copied())?;
            finite("start.rotation_vector", start.rotation_vector)?;
            finite("start", [start.euler_sign].into_iter().chain(start.accumulated))?;
        }
        self.path.iter().enumerate().try_for_each(|(index, step)| {
            let place = format!("path[{index}]");
            step.pair.check(&format!("{place}.pair"))?;
            let motion = step.rotation.iter().chain(&step.whole_turns).flatten();
            let rates = step.velocity.iter().chain(&step.acceleration);
            finite(&place, rates.chain(motion).chain(&step.flow_change).copied())
        })
    }
}

/// Refuses numbers of which one is not finite.
fn finite(place: &str, numbers: impl IntoIterator<Item = Hex>) -> Result<(), ReplayError> {
    match numbers.into_iter().find(|x| !x.0.is_finite()) {
        None => Ok(()),
        Some(x) => Err(ReplayError::NotFinite { place: place.to_string(), value: x.0 }),
    }
}
