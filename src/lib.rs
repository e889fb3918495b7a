//! pintle (crate page to come)

pub mod scalar;
