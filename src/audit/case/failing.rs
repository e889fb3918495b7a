//! What fails a check, as values: a connector's case, a constraint, a relation, a friction, a belt, springs and dampers.

use crate::case::Case;
use crate::case::quantity::Quantity;
use crate::laws::demanded::Invariant;
use pintle_kinematics::connector::Turns;
use pintle_kinematics::mpc::{Constraint, State, Turning};
use pintle_kinematics::relation::{Point, Relation};
use pintle_model::behavior::damping::Damping;
use pintle_model::behavior::elasticity::Elasticity;
use pintle_model::behavior::friction::{self, Belt, Friction};
use pintle_model::behavior::{Conditions, Motion};
use serde::{Deserialize, Serialize};

/// One state of something that is judged.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", content = "values", rename_all = "kebab-case")]
pub enum Failing {
    /// A connector after its history.
    Connector(Box<Case>),
    /// A multi-point constraint.
    Mpc(Box<MpcCase>),
    /// An equation, or what a rigid body, a coupling or a tie requires.
    Relation(Box<RelationCase>),
    /// A friction in an increment.
    Friction(Box<FrictionCase>),
    /// A belt around a ring in an increment.
    Belt(Box<BeltCase>),
    /// Springs and dampers at a motion.
    Slopes(Box<SlopesCase>),
}

/// A constraint at a state.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MpcCase {
    /// The constraint and the state, in words.
    pub name: String,
    /// The constraint.
    pub constraint: Constraint<f64>,
    /// The state.
    pub state: State<f64>,
    /// How the first node turned against the second since the state before.
    pub turning: Turning<f64>,
    /// The angles of its hinges that the states before left.
    pub before: [Turns<f64>; 2],
    /// The size of lengths.
    pub length: f64,
}

impl MpcCase {
    /// What is judged of a constraint.
    pub(crate) const QUANTITIES: [Quantity; 5] = [
        Quantity::Value,
        Quantity::FirstDerivatives,
        Quantity::SecondDerivatives,
        Quantity::Rate,
        Quantity::Acceleration,
    ];

    /// The laws that are asked of a constraint.
    pub(crate) const LAWS: [Invariant; 4] =
        [Invariant::RigidModes, Invariant::Frame, Invariant::Power, Invariant::Symmetry];
}

/// A relation at a state.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RelationCase {
    /// The relation and the state, in words.
    pub name: String,
    /// What it is of: `EQUATION`, `RIGID BODY` …
    pub type_name: String,
    /// The relation.
    pub relation: Relation<f64>,
    /// Its nodes.
    pub nodes: Vec<Point<f64>>,
    /// The size of lengths.
    pub length: f64,
}

impl RelationCase {
    /// What is judged of a relation.
    pub(crate) const QUANTITIES: [Quantity; 4] =
        [Quantity::Value, Quantity::FirstDerivatives, Quantity::Rate, Quantity::Acceleration];

    /// The laws that are asked of a relation; of an equation the last alone.
    pub(crate) const LAWS: [Invariant; 3] = [Invariant::RigidModes, Invariant::Frame, Invariant::Power];
}

/// A friction at given forces, and an increment of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionCase {
    /// The state, in words.
    pub(crate) name: String,
    /// What follows the names of entries: nothing for the only friction of a connector.
    pub(crate) title: String,
    pub(crate) friction: Friction,
    pub(crate) coefficient: f64,
    /// The forces at which the criterion is judged: tractions in the sliding components, what presses in the others.
    pub(crate) point: [f64; 6],
    /// What it remembers from before the increment.
    pub(crate) before: friction::State<f64>,
    pub(crate) displacement: [f64; 6],
    /// What presses in the increment.
    pub(crate) forces: [f64; 6],
    pub(crate) position: [f64; 6],
    pub(crate) motion: [f64; 6],
    /// The slip accumulated at the end.
    pub(crate) accumulated_slip: f64,
    pub(crate) duration: Option<f64>,
    pub(crate) conditions: Conditions,
    /// The connector's own length.
    pub(crate) length: f64,
}

/// A belt at an increment.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeltCase {
    /// The state, in words.
    pub(crate) name: String,
    pub(crate) belt: Belt,
    pub(crate) before: friction::State<f64>,
    pub(crate) flow: f64,
    pub(crate) tension: [f64; 2],
    pub(crate) angle: f64,
    pub(crate) duration: Option<f64>,
    pub(crate) conditions: Conditions,
    pub(crate) length: f64,
}

/// Springs and dampers at a motion.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlopesCase {
    /// The state, in words.
    pub(crate) name: String,
    pub(crate) elasticity: Elasticity,
    pub(crate) damping: Damping,
    pub(crate) motion: Motion<f64>,
    pub(crate) conditions: Conditions,
    /// The size of lengths.
    pub(crate) length: f64,
}
