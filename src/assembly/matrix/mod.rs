//! Sparse matrices of constraints: rank, dependent rows and free columns, and how certain they are.
//!
//! | module | question |
//! |---|---|
//! | `sparse` | what is a matrix made of? |
//! | `noise` | what of a number is rounding? |
//! | `budget` | what may be spent on what follows the rank? |
//! | `order` | in which order are bodies eliminated? |
//! | `eliminate` | what are rank, dependent rows and free columns? |
//! | `contract` | what moves as one body? |
//! | `echelon` | which rows depend on those before them? |
//! | `naming` | … and which rows may be named? |
//! | `dense` | singular values of small connected components |

pub(crate) mod budget;
pub(crate) mod contract;
pub mod dense;
pub(crate) mod echelon;
pub(crate) mod eliminate;
pub(crate) mod naming;
pub(crate) mod noise;
pub(crate) mod order;
pub(crate) mod sparse;
