//! The tests.

mod cli; // the command line
mod numerics; // how exact the elementary functions and the rotations are
mod scene; // the deck reader, files of states, the gallery
mod tolerance; // every tolerance, with the cause of the odd ones
mod wide; // the 237-bit scalar against mpmath
