//! The tests.

mod laws; // what holds for every connection type
mod states; // where laws are tried
mod tolerance; // every tolerance, with the cause of the odd ones
mod wide;
