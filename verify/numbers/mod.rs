//! Whether numbers are right: formulas by hand, extended precision, tables of the manual, motions.

pub(crate) mod batch; // whether four lanes give what one element at a time gives
pub(crate) mod closed; // rows derived by hand
pub(crate) mod manual; // the manual's summary tables, transcribed apart
pub(crate) mod numerics; // how exact the elementary functions and the rotations are
pub(crate) mod properties; // what holds of random motions, readable by itself
pub(crate) mod wide; // the 237-bit scalar against mpmath

mod rows; // whether arrays of states and of rows, in any form, hold the numbers of tiles
