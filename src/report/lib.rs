//! Reports: one file per format, all from the same data.
//!
//! Every function writes to a stream that it is given. Human text carries ANSI styles, which a stream that is no terminal
//! drops (`anstream`); it fits the width that the caller names.

pub mod audit;
pub mod bench;
mod evaluation;
pub mod explain;
pub mod export;
pub mod formulas;
pub mod glossary;
mod layout;
pub mod list;
pub mod mpc;
pub mod solve;
pub mod sweep;
mod words;

pub use evaluation::{
    ArrayEvaluation, Block, BlockKind, Column, ComponentRow, Derivative, Format, HingeFacts, MpcFacts, Nodal,
    NodalForce, Renderer, Subject, Unevaluated, Value, csv, flag_in_words, flags_in_words, human,
    into_arrays, json, matrix_market, unevaluated, value_of,
};
pub use layout::{table, wrap};
pub use words::{NOTATION, ROWS, SIGNS};
