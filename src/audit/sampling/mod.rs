//! Where connectors are tried: every type at seeded states, each with the path that leads there.
//!
//! A type brings its own domain: initial orientations that satisfy its printed constraints or do not, the axis about which it
//! may turn without end, and states clear of its singular sets. The paths are made from so few ingredients (the initial
//! relative orientation, a rotation common to both nodes, a rotation of b against a) that what an angle must be is known.

pub mod coverage;
mod domain;
mod region;
#[cfg(feature = "proptest")]
pub mod strategies;

pub(crate) use region::{about_initial_by, rates, regions_drawn};

pub use domain::{Turning, about_1, about_3, aligned, is_in_table, needs_length, spin_axis, turning, types};
pub use region::{
    Extent, Motion, Region, SPECIAL, about_initial, along_initial, beside_half_turn, cases, cases_drawn,
    cube_orientations, definition, draw_case, extent, pair, random_case, special_initial,
};
