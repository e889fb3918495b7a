//! A scene as numbers: the forces that follow from a motion, and the evaluation of all its connectors and constraints.
//!
//! | module | question |
//! |---|---|
//! | [`behavior`] | which forces follow from a motion: springs, dampers, friction, stops, locks, drives? |
//! | [`evaluate`] | what is to be computed for a scene, and in which order? |

pub mod behavior;
pub mod evaluate;
