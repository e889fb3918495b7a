//! The tests, in one binary: each module asks one question of the whole.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod scene; // what decks and state files mean, and how faulty ones are refused
