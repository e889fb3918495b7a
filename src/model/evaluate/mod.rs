//! From a scene and a request to numbers.
//!
//! [`Model::compile`] resolves a [`pintle_scene::Scene`] once: types by the catalogue, orientations to triads, rules to
//! errors and warnings. [`Plan::compile`] turns a request (outputs × connectors × order of derivative) into the list of
//! what is to be computed, and of the nodes that need it. [`Sequence`] walks through states in order, one at a time,
//! committing every branch as it goes.

mod arrays;
mod behavior;
mod belt;
mod fixed;
mod forces;
mod jacobian;
mod model;
mod mpc;
mod outputs;
mod parallel;
mod places;
mod plan;
mod plane;
mod relation;
mod rules;
mod sequence;
mod shared;

pub use arrays::{
    ArrayError, ArrayWalk, ByNode, MotionError, Motions, NodeArrays, Numbers, Rotations, evaluate_arrays,
    is_kinematic,
};
pub use belt::Ring;
pub use fixed::keeps_zero;
pub use fixed::{Fixed, Freedom};
pub use forces::{ForceCheck, ForceResult};
pub use jacobian::{Equation, ForeignPattern, Jacobian, Source};
pub use model::{ConnectorElement, ElementBehavior, Model};
pub use mpc::forces::{Hinge, MpcForces, MpcSlopes};
pub use mpc::{HingeMoments, MpcElement, MpcResult};
pub use outputs::{OutputError, request};
pub use plan::{Plan, Selection, SelectionError};
pub use relation::{RelationElement, RelationResult};
pub use sequence::{Branches, ConnectorResult, Item, Sequence, StepResult};

/// The suboptions of `*CONNECTOR BEHAVIOR` that are evaluated; of all others `pintle eval` says that they were read and are not.
pub const SUBOPTIONS: &[&str] = &[
    "CONNECTOR CONSTITUTIVE REFERENCE",
    "CONNECTOR ELASTICITY",
    "CONNECTOR DAMPING",
    "CONNECTOR FRICTION",
    "CONNECTOR DERIVED COMPONENT",
    "CONNECTOR POTENTIAL",
    "CONNECTOR STOP",
    "CONNECTOR LOCK",
    "CONNECTOR FAILURE",
];
