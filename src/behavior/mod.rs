//! What a connector does besides its kinematics: forces from motions.

pub mod friction;
pub mod table;
