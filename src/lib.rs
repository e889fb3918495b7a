//! pintle (crate page to come)

pub mod catalog;
pub mod connector;
pub mod evaluate;
pub mod measure;
pub mod mpc;
pub mod node;
pub mod report;
pub mod scalar;
pub mod scene;
pub mod so3;
pub mod vector;

/// The version of this crate, as every report states it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
