//! Results that another program has written, compared with what connectors must give at the same motion of their nodes.
//!
//! | module | question |
//! |---|---|
//! | `read` | what does a file say, frame by frame, in which format? |
//! | `numpy`, `matrix` | the same of arrays and matrices |
//! | `motion` | how do nodes move, and how between two frames? |
//! | `column` | what does a heading mean? |
//! | `printed` | how many digits has a number? |
//! | `walk`, `evaluate` | what must the connectors and nodes give along that motion? |
//! | `entries` | what must a Jacobian or stiffness be? |
//! | `judge` | how far apart are the two, in units of what the file can tell? |
//! | `cause` | why? |
//! | `digits` | how many digits does a run have of a reference solution? |
//! | `show` | how is it read? |
//!
//! A printed number stands for all that round to it. A difference within half a unit of its last digit, and within what the digits
//! of the motion allow, is none.

mod cause;
mod column;
mod digits;
mod entries;
mod evaluate;
mod judge;
mod matrix;
mod motion;
mod numpy;
mod printed;
mod read;
mod show;
mod walk;

pub use column::{Map, MatrixKind, Motion, Nodal, Rotations};
pub use digits::{Creep, Digits, Events, Given, Quantity, Run, digits, given};
pub use evaluate::Why;
pub use judge::{Comparison, Gap, Series, Unjudged};
pub use motion::states;
pub use printed::Printed;
pub use read::{Frame, Results};
pub use show::write_junit;
pub use walk::compare;
