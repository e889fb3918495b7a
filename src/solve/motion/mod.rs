//! The mechanics: a scene as a mechanism, and its equations of motion at one instant.
//!
//! | module | question |
//! |---|---|
//! | `mechanism` | which bodies, joints, constraints and loads are there? |
//! | `state` | where are the nodes, and how fast? |
//! | `mode` | which friction sticks, which slips, and what ends that? |
//! | `rows`, `assemble` | which equations hold at an instant, and what acts? |
//! | `slide` | what is the limit of a friction at some forces, with its derivatives? |
//! | `equations` | which accelerations and forces follow? |
//! | `layout` | which equations count, where some repeat others? |
//! | `tangent` | where may a state go without leaving its equations? |
//! | `zero` | when does a quantity vanish? |
//! | `linear` | small systems of linear equations on any number |
//! | `plan` | what does elimination do, where its pivots are known? |

pub(crate) mod assemble;
pub(crate) mod equations;
pub(crate) mod layout;
pub(crate) mod linear;
pub(crate) mod mechanism;
pub(crate) mod mode;
pub(crate) mod plan;
pub(crate) mod rows;
pub(crate) mod slide;
pub(crate) mod state;
pub(crate) mod tangent;
pub(crate) mod zero;
