//! pintle (crate page to come)

pub mod catalog;
pub mod measure;
pub mod node;
pub mod scalar;
pub mod so3;
pub mod vector;
