//! Decks and states: what the gallery contains, and that nothing panics.
#![expect(clippy::panic, reason = "a test fails by panicking")]

mod assembly;
mod documents;
mod gallery;
mod reading;
mod states;

/// The node or element of a deck without parts.
fn n(number: u64) -> pintle::scene::Label {
    number.into()
}
