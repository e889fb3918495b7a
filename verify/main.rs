//! The tests.

mod scene;
