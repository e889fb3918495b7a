//! Results that another program has written, compared with what connectors must give at the same motion of their nodes.
//!
//! | module | question |
//! |---|---|
//! | `read` | what does a file say, frame by frame, in which format? |
//! | `column` | what does a heading mean? |
//! | `printed` | how many digits has a number? |
//! | `walk` | what must the connectors give along that motion? |
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
mod judge;
mod printed;
mod read;
mod show;
mod walk;

pub use column::{Map, Motion, Rotations};
pub use digits::{Creep, Digits, Events, Given, Quantity, Run, digits, given};
pub use judge::{Comparison, Series, Unjudged};
pub use printed::Printed;
pub use read::{Frame, Results};
pub use walk::{compare, states};
