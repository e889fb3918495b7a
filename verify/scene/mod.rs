//! Decks and states: what the gallery contains, and that nothing panics.
#![expect(clippy::panic, reason = "a test fails by panicking")]

mod assembly;
mod constraints; // equations, rigid bodies, couplings, ties
mod decks;
mod documents;
mod errors;
pub(crate) mod faults; // what is said about every faulty input
pub(crate) mod freedom; // which degrees of freedom nodes have
pub(crate) mod fuzzing; // what holds of any bytes whatever
mod gallery;
pub(crate) mod plane; // the two-dimensional forms
mod reading;
pub(crate) mod rules;
mod states; // what a connector section may do

/// The node or element of a deck without parts.
fn n(number: u64) -> pintle_scene::Label {
    number.into()
}
