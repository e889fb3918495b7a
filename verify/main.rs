//! The tests.

mod wide;
