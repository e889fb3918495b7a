//! pintle (crate page to come)

pub mod catalog;
pub mod connector;
pub mod measure;
pub mod mpc;
pub mod node;
pub mod scalar;
pub mod so3;
pub mod vector;
