//! Counter-examples: made small, written, read, handed over.

pub mod again;
pub mod counterexample;
pub mod handover;
pub mod shrink;
