//! Reports: one file per format, all from the same data.
//!
//! Every function writes to a stream that it is given. Human text carries ANSI styles, which a stream that is no terminal
//! drops (`anstream`); it fits the width that the caller names.

pub mod explain;
mod layout;
pub mod list;
mod words;

pub use words::{NOTATION, ROWS, SIGNS};
