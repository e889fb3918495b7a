//! Formulas seen: the generic kinematics, traced instead of computed.
//!
//! [`Symbol`] is one more [`Scalar`](pintle_kinematics::scalar::Scalar): it records what is done to it in a [`Graph`], in which each
//! expression stands once. Elementary functions and rotations are atoms with known derivatives ([`Node`]); every branch is taken
//! and joined ([`trace`]). A [`Derivation`] differentiates, any number of times, and no dual number takes part; [`Model`] does so
//! for a connection type and [`FrictionModel`] for its friction. The reports write them as programs and
//! for reading.
//!
//! ```
//! use pintle_kinematics::scalar::elementary::atan2;
//! use pintle_kinematics::scalar::Wide;
//! use pintle_symbolic::{Derivation, Symbol, trace};
//! // The angle of (x, y) = (1, 0), and its derivatives by y: 1, 0, −2.
//! let (mut graph, [mut angle]) = trace(|| [atan2(Symbol::input(1), Symbol::input(0))])?;
//! let one = graph.integer(1);
//! let mut by_y = Derivation::along([(1, one)]);
//! for want in [0.0, 1.0, 0.0, -2.0] {
//!     assert_eq!(graph.evaluate(&[angle], &[1.0, 0.0]), [want]);
//!     assert_eq!(graph.evaluate(&[angle], &[Wide::from_f64(1.0), Wide::from_f64(0.0)])[0].to_f64(), want);
//!     angle = by_y.of(&mut graph, angle);
//! }
//! # Ok::<(), pintle_symbolic::TraceError>(())
//! ```

mod condition;
mod derivative;
mod evaluate;
mod friction;
mod graph;
mod input;
mod model;
pub mod print;
mod symbol;

pub use condition::Condition;
pub use derivative::Derivation;
pub use friction::{FrictionModel, FrictionTraceError, POINT};
pub use graph::{Graph, Id, Node, Number};
pub use input::{Input, InputUnit, Inputs, Shape};
pub use model::{Derivatives, Frame, Function, Model, VARIATION, nodal_inputs, relative_inputs};
pub use print::graphviz;
pub use symbol::{Symbol, TraceError, trace};

#[cfg(test)]
mod tests;
