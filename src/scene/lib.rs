//! Scenes: the model that a deck describes, and the states of its nodes.
//!
//! - [`Scene`] is the model: nodes, sets, connector elements and their sections, orientations, behaviours,
//!   constraints, what is prescribed, steps. [`Scene::read`] and [`Scene::parse`] read it from an
//!   Abaqus-style deck (`.inp`) in one pass. Connection types stay names here; the catalogue says what they mean.
//! - [`Orientation::triad`] gives the directions e1, e2, e3 at a point.
//! - [`StateFile`] holds what the nodes do: displacement, total rotation, velocities, accelerations, flow.
//! - [`ForceFile`] holds component forces of connectors, as FE codes export them.
//! - [`Diagnostic`] says what is wrong with an input, where, and what to do about it.
//! - [`GALLERY`] has scenes with states in closed form, embedded in the binary.
//!
//! # Decks
//! Keyword lines begin with an asterisk and go on after a comma at their end; comments begin with two. Case and
//! blanks do not matter, except between quotation marks, where a name stands as it is. Data items are separated
//! by commas; an empty item is the default, and trailing ones may be left out. Numbers may have a Fortran
//! exponent (`1.D0`). Names may be used before they are defined.
//!
//! What does not bear on a connector or a constraint is skipped with its data and counted in [`Skipped`]; what bears on one and is
//! not understood is an error. An error carries the others of its file: [`Diagnostic::further`].
//!
//! A deck may include files (`*INCLUDE`, `INPUT=`): their lines stand in place of the keyword, and their paths count from the file
//! that includes them. [`Scene::read`] opens them on disk, [`Scene::parse_with`] where the caller says; [`Scene::parse`] opens
//! nothing.
//!
//! # Parts and instances
//! A deck is flat, or consists of `*PART`s and an `*ASSEMBLY` of their `*INSTANCE`s, as CAE writes it. The scene is the
//! assembly: every instance has a copy of the nodes, elements, sets, orientations and sections of its part, moved by the
//! translation and *then* turned about the axis, which stays where it is given. What the lines of an instance add counts in the axes of
//! the part, too. Node 5 of the instance CRANK-1 has the [`Label`] `CRANK-1.5`, its set PIN is `CRANK-1.PIN`, its orientation
//! likewise; names between quotation marks keep their case, `"Part 1-1".PIN`. What the assembly defines itself has bare numbers and
//! names. Element-based surfaces and contact are skipped and counted.
//!
//! # TOML and JSON
//! The same model, which may hold its states too ([`Scene::states`]): [`Scene::parse_toml`], [`Scene::parse_json`], and
//! [`Scene::read`] by the ending of the file. [`schema`] is the JSON Schema, made from the types that are read. A document is
//! read as the deck it stands for, each item of which knows its place in the document: what is checked of decks is checked
//! of documents, by the same code. Names stand as they are: a deck has them in upper case, unless it quotes them. An empty
//! item of a row is `""`, in JSON also `null`.
//!
//! [`Scene::write`] writes any scene in any of the three forms; reading that gives the same scene to the last bit, and
//! [`Converted::dropped`] says what of the file is not in it. Instances are written as parts of their own, in their places.
//!
//! # Units
//! Those of the deck, and radians. Degrees stand in [`Behavior::constitutive_reference`] and
//! [`Orientation::angle`] only, as in the deck.
//!
//! # Limits
//! Includes 16 deep ([`MAX_INCLUDE_DEPTH`]), 10 000 files ([`MAX_INCLUDES`]) and 16 GiB ([`MAX_INCLUDED_BYTES`]) in all.
//! Lines of 65 535 bytes ([`MAX_LINE`]), numbers of nodes and elements up to 2⁵³ ([`MAX_LABEL`]), ten million
//! members of all sets together ([`MAX_MEMBERS`]). What is kept grows with the deck; nothing recurses.

mod behavior;
mod choice;
mod deck;
mod diagnostic;
mod digits;
mod document;
mod forces;
mod freedom;
mod gallery;
pub mod grammar;
mod include;
mod label;
mod lexer;
mod model;
mod orientation;
mod span;
mod states;
mod wording;
mod written;

pub use behavior::{
    Affected, Basis, Behavior, Damage, DamageCriterion, DamageEvolution, DamageEvolutionKind, Damping,
    DampingKind, Degradation, DerivedTerm, Elasticity, Extrapolation, Failure, Friction, FrictionCoefficient,
    FrictionKind, FrictionLaw, Hardening, HardeningDefinition, HardeningKind, Independent, Integration, Law,
    Limits, Lock, Operator, Plasticity, Potential, PotentialFunction, PotentialOperator, PotentialTerm,
    RateInterpolation, Softening, Source, Stop, TableOptions, TableRow,
};
pub use choice::Choice;
pub use deck::MAX_MEMBERS;
pub use diagnostic::{Code, Diagnostic, MAX_ERRORS, Result, Severity};
pub use digits::{Digits, DigitsOfState};
#[cfg(feature = "schema")]
pub use document::schema;
pub use document::{Converted, Format, MAX_DOCUMENT, SCHEMA_TEXT};
pub use forces::{ForceFile, ForceStream, StateIndex};
pub use freedom::{Lack, NodeFreedom};
pub use gallery::{Example, GALLERY};
pub use include::{Disk, Files, MAX_INCLUDE_DEPTH, MAX_INCLUDED_BYTES, MAX_INCLUDES, NoFiles};
pub use label::MAX_LABEL;
pub use label::labelled::{ByLabel, LabelMap, LabelSet, LabelState};
pub use label::{Instance, Label, LabelError};
pub use lexer::MAX_LINE;
pub use model::{
    Amplitude, AmplitudeDefinition, AmplitudeTime, AmplitudeValue, Application, Boundary, ConcentratedLoad,
    ConditionKind, ConnectorElement, ConnectorLoad, ConnectorMotion, ConnectorSection, Coupling,
    CouplingKind, DefaultAmplitude, Dimension, Discrete, DistributedLoad, ElementForces, End, Equation,
    EquationTerm, ForceSign, InitialVelocity, MAX_WARNINGS, Mass, MotionType, Mpc, MpcKind, Node, NodeMotion,
    Operation, OutputRequest, PointElement, PointKind, Procedure, RigidBody, RotaryInertia, Rotation, Scene,
    Set, Skipped, SkippedConstraint, SkippedItem, Solver, State, StateForces, Step, Surface, Target, Tie,
    Times, Transform, TransformKind, Weighting,
};
pub use orientation::{Definition, GLOBAL, Orientation, SMALLEST_SINE, System, Triad};
pub use span::{Span, Spanned};
pub use states::{Degrees, InDegrees, is_in_degrees, told_in_degrees};
pub use states::{MAX_ROTATION, QUATERNION_TOLERANCE, StateFile, StateMark, StateStream, Vanishing};
pub use wording::Words;
pub use written::{Placement, WrittenNode};
