//! A verification workbench for connector (joint) elements of finite-element and multibody codes: REVOLUTE, TRANSLATOR,
//! SLIDE-PLANE, RETRACTOR, ROTATION …, and of the multi-point constraints BEAM, LINK, PIN, REVOLUTE, TIE, UNIVERSAL.
//!
//! What should this connector give here? Every number is exact to rounding, or comes with a flag that says why it is not.
//!
//! | module | question |
//! |---|---|
//! | [`so3`], [`vector`], [`scalar`] | rotations and vectors, on numbers that carry derivatives |
//! | [`catalog`] | which connection types are there? |
//! | [`connector`], [`node`] | what does one connector give at one state, after its history? |
//! | [`force`], [`mpc`], [`relation`] | what do its forces do to its nodes; what does a constraint give? |
//! | [`batch`] | what do many connectors of one type give, four at a time? |
//! | [`scene`], [`evaluate`] | what does a deck say, and which numbers follow? |
//! | [`audit`] | is it right, and how do we know? |
//!
//! Without the feature `cli`, which is there by default, this crate is the mathematics alone, up to [`batch`].
//!
//! Notation, signs, units and the order of degrees of freedom: `docs/reference/conventions.md`. Indices are 1-based, as the
//! manual's; angles are in radians; the columns of a row are x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b ([`node::DOF`]).
//!
//! ```
//! use pintle::catalog::ConnectionType;
//! use pintle::connector::{Connector, Definition, Linear};
//! use pintle::node::{Node, Pair};
//! use pintle::{so3, vector};
//!
//! // A REVOLUTE whose node b has turned by 0.3 rad about the shared axis e1.
//! let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
//! let initial = Pair { reference: [0.0; 3], a: node(vector::identity()), b: node(vector::identity()) };
//! let definition = Definition::new(ConnectionType::named("REVOLUTE", None)?, initial);
//! let connector = Connector::<f64>::new(&definition);
//! let turned = Pair { b: node(so3::exp([0.3, 0.0, 0.0])), ..initial };
//! let mut rows = [Linear::default(); 6];
//! let count = connector.linearize(&turned, &connector.initial_branch(), [true; 6], &mut rows);
//! assert_eq!(count, 3); // ur1, ur2, ur3
//! assert_eq!(rows[0].value, 0.3);
//! assert_eq!(rows[0].row[10..13], [1.0, 0.0, 0.0]); // ∂ur1/∂θb1, ∂ur1/∂θb2, ∂ur1/∂θb3
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The map
//!
//! Each layer is a crate under `src/`, and uses those above it in this table alone.
//!
//! | crate | what is in it |
//! |---|---|
//! | `kinematics` | scalars, rotations, measures, the catalogue, connectors, batches, forces, constraints |
//! | `scene` | decks, TOML, JSON, states, forces, diagnostics |
//! | `model` | behaviour, friction, the evaluation of a scene, the sparse Jacobian |
//! | `assembly` | rank, redundancy, mobility |
//! | `solve` | reference solutions of small mechanisms, with friction that sticks |
//! | `symbolic` | formulas traced, their derivatives, programs in other languages |
//! | `audit` | oracles, bounds, verdicts, laws, mutants, singular points, findings |
//! | `bench` | run time against error |
//! | `sweep` | very many states, in any partition: summaries that merge exactly |
//! | `report` | text, JSON, JUnit, Markdown, HTML |
//! | `check`, `element` | somebody's routine asked and judged; the conventions of its rows found |
//! | `compare` | results that other programs have written |
//! | `pintle` | this facade, and the command line |

#[cfg(feature = "cli")]
mod cli;

#[cfg(feature = "cli")]
pub use cli::{STACK, command_line};
pub use num_dual;
pub use pintle_kinematics::VERSION;
pub use pintle_kinematics::{so3, vector};

/// Numbers that carry derivatives.
pub mod scalar {
    pub use pintle_kinematics::Differentiable;
    pub use pintle_kinematics::scalar::{Duals, Real, Scalar, Seeded, U, Wide, elementary};
}

/// Connection types.
pub mod catalog {
    pub use pintle_kinematics::catalog::{COMPONENT, ConnectionType, NameError, Slot, TABLE};
}

/// Two nodes and their degrees of freedom.
pub mod node {
    pub use pintle_kinematics::node::{DOF, DOFS, Node, Pair};
}

/// One connector.
pub mod connector {
    pub use pintle_kinematics::connector::{
        Branch, Connector, Definition, Evaluation, Flag, Increment, Linear, Output, Request, State, Tally,
        Turns,
    };
}

/// Forces of components on the nodes.
pub mod force {
    pub use pintle_kinematics::force::*;
}

/// Multi-point constraints.
pub mod mpc {
    pub use pintle_kinematics::mpc::{Body, Constraint, MpcType, State};
}

/// Constraints between any number of nodes: equations, rigid bodies, couplings.
pub mod relation {
    pub use pintle_kinematics::relation::{ConstraintRow, Form, Point, Relation};
}

/// Many connectors of one type.
pub mod batch {
    pub use pintle_kinematics::batch::{
        Array, Batch, BatchError, COMPACT, Columns, CompactRow, Fours, HessianRow, History, Nodes,
        Orientation, Poses, Row, Section, States, Tile, Triads, Velocities,
    };
}

/// Decks, documents, states, forces.
#[cfg(feature = "cli")]
pub mod scene {
    pub use crate::cli::eval::scene as open;
    pub use pintle_scene::{
        Code, Diagnostic, ForceFile, Label, Scene, Severity, State, StateFile, StateStream,
    };
}

/// The numbers of a scene.
#[cfg(feature = "cli")]
pub mod evaluate {
    pub use pintle_model::evaluate::{Jacobian, Model, Plan, Selection, Sequence, request};
}

/// Formulas traced, their derivatives.
#[cfg(feature = "cli")]
pub mod symbolic {
    pub use pintle_symbolic::{Derivation, Frame, Graph, Model};
}

/// Is it right, and how do we know?
#[cfg(feature = "cli")]
pub mod audit {
    #[cfg(feature = "proptest")]
    pub use pintle_audit::sampling::strategies;
    pub use pintle_audit::{
        Candidate, CounterExample, Given, Oracle, Report, Settings, Verdict, audit_catalogue, audit_scenes,
    };
    pub use pintle_report::audit::AssertOk;
}

/// Is somebody's routine right?
#[cfg(feature = "cli")]
pub mod check {
    pub use crate::cli::subject::{At, subject};
    pub use pintle_check::{Asked, Checked, Convention, DRIVER, Door, Misbehaviour, Subject, check};
}

/// Many states, in any partition.
#[cfg(feature = "cli")]
pub mod sweep {
    pub use crate::cli::sweep::{Own, Programs, Start, plan, routines};
    pub use pintle_sweep::{Folder, Generator, Plan, Ranges, Subject, Summary, Sweep, SweepError};
}

#[cfg(doctest)]
#[doc = include_str!("../../docs/explanation/symbolic.md")]
struct Page;
