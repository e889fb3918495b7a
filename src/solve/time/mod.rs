//! The motion in time: steps, events, modes, and what is kept of them.
//!
//! | module | question |
//! |---|---|
//! | `integrate` | two methods of high order |
//! | `stiff` | … where something decays much faster than what moves |
//! | `step` | from a state to the next: one step, the event within it, back to the constraints |
//! | `happen` | what changes at an event, and which impulses? |
//! | `choose` | what sticks and what slips after an event? |
//! | `near` | which singular position is near? |
//! | `still` | the path of a static step |
//! | `curve` | … where frictions of several components slip |
//! | `work` | and the work along it |
//! | `launch` | with which rates does it begin? |
//! | `run` | from the first time to the last |
//! | `keep` | where does a run go on? |
//! | `solution` | what is kept |

pub(crate) mod choose;
pub(crate) mod curve;
pub(crate) mod happen;
pub(crate) mod integrate;
pub(crate) mod keep;
pub(crate) mod launch;
pub(crate) mod near;
pub(crate) mod onset;
pub(crate) mod run;
pub(crate) mod solution;
pub(crate) mod step;
mod stiff;
pub(crate) mod still;
pub(crate) mod work;
