//! Singular points: cases at a given distance from them, and what exists on them.

pub mod atlas;
pub mod beside;
pub mod near;
pub mod quotients;
#[cfg(test)]
mod right_angles;
pub mod sides;
pub mod standing;
