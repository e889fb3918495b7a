//! pintle (crate page to come)

pub mod scalar;
pub mod scene;
