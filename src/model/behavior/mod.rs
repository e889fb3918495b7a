//! What a connector does besides its kinematics: forces from motions.
//!
//! CTF = CEF + CVF + CSF + CRF − CCF: elastic, viscous, friction force, reaction, minus the applied load. Each is internal
//! (positive resists growth of its component) but the load, which drives its component. Everything is generic over the scalar: on
//! numbers with derivatives the same functions give exact tangents.
//!
//! | module | question |
//! |---|---|
//! | [`table`] | what lies between the rows of a table? |
//! | [`elasticity`], [`damping`] | which forces follow from displacements and velocities? |
//! | [`friction`] | what sticks, what slips, and with which force? |
//! | [`ground`] | what do springs and dashpots from a degree of freedom to ground give? |
//! | [`amplitude`], [`drive`] | how does what is prescribed change in time? |
//! | [`limits`] | when does a component lock or fail? |
//! | [`state`] | what of all that holds at one state, after its history? |
//! | [`Tangent`] | how do the forces change with the motion? |

pub mod amplitude;
pub mod damping;
pub mod drive;
pub mod elasticity;
pub mod friction;
pub mod ground;
mod law;
pub mod limits;
mod slide;
pub mod state;
pub mod table;
mod tangent;

pub use law::ForceKink;
pub use law::entry;
pub use slide::{Beyond, Slip, Wrap};
pub use tangent::Tangent;

use pintle_kinematics::connector::Components;
use pintle_kinematics::scalar::{Real, Scalar};
use serde::Serialize;
use table::Variable;

/// The motion of the available components; zero for the others.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Motion<S> {
    /// Positions (CP), of all components.
    pub position: [S; 6],
    /// Constitutive displacements (CCU).
    pub constitutive: [S; 6],
    /// Velocities (CV).
    pub velocity: [S; 6],
}

/// What forces depend on besides motions. The default is that nothing of it is known.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Conditions {
    /// The temperature.
    pub temperature: Option<f64>,
    /// Field variables, from the first.
    pub fields: Vec<f64>,
}

impl Conditions {
    /// Why a variable of a table has no value; `None` where it has one.
    fn lacks(&self, variable: Variable) -> Option<Unknown> {
        match variable {
            Variable::Temperature if self.temperature.is_none() => Some(Unknown::Temperature),
            Variable::Field(field) if self.fields.len() <= field => Some(Unknown::Field(field + 1)),
            _ => None,
        }
    }

    /// The value of a variable that is no motion; frequencies are zero.
    fn of<S: Scalar>(&self, variable: Variable) -> S {
        let value = match variable {
            Variable::Temperature => self.temperature,
            Variable::Field(field) => self.fields.get(field).copied(),
            Variable::Column(_) => None,
        };
        S::from_real(S::Real::from_f64(value.unwrap_or(0.0)))
    }
}

/// How far a given force may differ from the sum of its parts, relative to them: files of forces have six digits or so.
pub(crate) const PRINTED: f64 = 1e-5;

/// Why a force is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unknown {
    /// It depends on the temperature, which is not given.
    Temperature,
    /// It depends on this field variable (from 1), which is not given.
    Field(usize),
    /// A rigid elasticity: motions do not tell its force.
    Rigid,
    /// It depends on the time, which the state does not give.
    Time,
    /// It is a velocity formed from increments, and the time since the previous state is not known, or zero.
    TimeStep,
    /// The time lies after the last step whose length is known.
    AfterSteps,
    /// It is counted from where the component was at the beginning of a step, and no state was given there.
    StepBeginning,
    /// A subroutine, another program or the solution gives it.
    External,
    /// A reaction: motions do not tell it, and no total force is given.
    Reaction,
    /// It rests on another part that is not known.
    Part,
    /// The two belts at a ring do not run on, one from the other.
    OpposedBelts,
    /// The angle of wrap is that between the segments of a belt, which are in line or folded back: it has no derivative there.
    WrapAngle,
    /// What presses is the force of a component for which none is given.
    ContactForce,
    /// Forces are given that are not those of the connector: none of them is taken.
    ForcesRefused,
    /// Friction was not known at an earlier state, so that what it left is not known.
    FrictionHistory,
    /// It follows from a velocity that is neither given nor asked for (output CV).
    Rate,
    /// Plasticity, damage or a uniaxial behaviour acts on the component, and is not evaluated.
    Inelastic,
}

impl Unknown {
    /// Why, in words.
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::Temperature => "it depends on the temperature, which is not given",
            Self::Field(_) => "it depends on a field variable that is not given",
            Self::Rigid => "its elasticity is rigid, and no total force is given",
            Self::Time => "it depends on the time, which the state does not give",
            Self::TimeStep => "its velocity is an increment over a time step that is not known, or zero",
            Self::AfterSteps => "the time lies after the last step whose length is known",
            Self::StepBeginning => "it counts from the beginning of a step, and no state was given there",
            Self::External => "a subroutine, another program or the solution gives it",
            Self::Reaction => "motions do not tell a reaction, and no total force is given",
            Self::Part => "a part of it is not known",
            Self::WrapAngle => {
                "the angle of wrap is measured between segments that are in line or folded back, where it has no derivative"
            }
            Self::OpposedBelts => "the two belts at the ring both end there: neither runs on in the other",
            Self::ContactForce => "what presses is the force of a component for which none is given",
            Self::ForcesRefused => {
                "the forces given are not those of the connector, and none of them is taken"
            }
            Self::FrictionHistory => {
                "friction was not known at an earlier state, so that what it left is not known"
            }
            Self::Rate => "it follows from a velocity that is neither given nor asked for (CV)",
            Self::Inelastic => {
                "plasticity, damage or a uniaxial behaviour acts on the component, and is not evaluated"
            }
        }
    }
}

/// The forces of one kind: of the components that have one, unless it is not known.
#[derive(Clone, Copy, Debug)]
pub struct Forces<S> {
    /// The forces; `None` where there is none, or it is not known.
    pub value: Components<S>,
    /// Why a force is not known.
    pub unknown: Components<Unknown>,
}

impl<S: Copy> Forces<S> {
    /// No force at all.
    pub const fn none() -> Self {
        Self { value: [None; 6], unknown: [None; 6] }
    }
}
