//! pintle (crate page to come)

pub mod scalar;
pub mod so3;
pub mod vector;
