//! Formulas seen: the generic kinematics, traced instead of computed.

mod derivative;
mod evaluate;
mod friction;
mod graph;
mod input;
mod model;
pub(crate) mod print;
mod symbol;

pub use derivative::Derivation;
pub use friction::{FrictionModel, FrictionTraceError, POINT};
pub use graph::{Graph, Id, Node, Number};
pub use input::{Input, InputUnit, Inputs, Shape};
pub use model::{Derivatives, Frame, Function, Model, VARIATION, nodal_inputs, relative_inputs};
pub use print::graphviz;
pub use symbol::{Symbol, TraceError, trace};

#[cfg(test)]
mod tests;
