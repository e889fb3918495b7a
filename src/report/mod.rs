//! Reports: one file per format, all from the same data.
//!
//! Every function writes to a stream that it is given. Human text carries ANSI styles, which a stream that is no terminal
//! drops (`anstream`); it fits the width that the caller names.

pub mod audit;
pub mod bench;
mod block;
pub mod csv;
mod evaluation;
pub mod explain;
pub mod export;
mod flags;
pub mod formulas;
pub mod human;
pub mod json;
mod layout;
pub mod list;
pub mod matrix_market;
pub mod mpc;
mod number;
mod words;

pub use block::{Block, Column, Derivative, HingeFacts, Kind, MpcFacts, Nodal, NodalForce, Row, Value};
pub use evaluation::{Format, Renderer, Subject, Unevaluated, unevaluated};
pub use flags::{flag_in_words, flags_in_words};
pub use words::{NOTATION, ROWS, SIGNS};
