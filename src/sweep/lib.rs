//! Very many states, in any partition: what a billion of them give fits into some kilobytes, and is the same however they are shared out.
//!
//! A state is its index: a [`generator`] gives its numbers from that, so that nothing travels and nothing is stored. A [`Plan`] is the text of
//! what is swept; a chunk is a plan, a first index and a count; [`Sweep::run`] makes a [`Summary`] of it. Summaries merge exactly: they
//! hold counts, extrema with their indices, and a sum of integers over all bits of all numbers, but no sum of floating-point numbers. The
//! merge is associative and commutative, and so any partition, order and number of threads give one [`Summary::digest`].
//!
//! | module | question |
//! |---|---|
//! | [`generator`] | which numbers belong to an index? |
//! | [`philox`], [`sobol`] | random ones; ones that lie more evenly |
//! | [`plan`] | what is swept? |
//! | [`states`] | which state has an index? |
//! | [`routine`] | whose numbers are they, if not our own? |
//! | [`sweep`] | what do the states of a chunk give? |
//! | [`summary`] | what is known of them in the end? |
//! | [`folder`] | what is done already? |
//! | [`whole`] | how is a file written that nobody sees half? |

pub mod bins;
pub mod folder;
pub mod generator;
pub mod philox;
pub mod plan;
pub mod ranges;
pub mod routine;
pub mod sobol;
pub mod states;
pub mod summary;
pub mod sweep;
#[cfg(test)]
mod tests;
pub mod whole;

pub use folder::Folder;
pub use generator::Generator;
pub use plan::{Plan, Subject};
pub use ranges::Ranges;
pub use routine::{Routine, Routines};
pub use summary::{OfLaw, OfQuantity, OfSubject, Summary, Worst};
pub use sweep::Sweep;

/// Why there is no sweep.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A text that is no plan.
    #[error("this is no plan of a sweep: {0}")]
    Plan(String),
    /// A file that is not what it should be.
    #[error("{file}: {what}; {remedy}")]
    File {
        /// Its name.
        file: String,
        /// What is wrong.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Summaries that do not belong together.
    #[error("{0}")]
    Merge(String),
    /// More states than there are.
    #[error("states {first} to {first} + {count} are beyond 1e15: ask for less")]
    TooMany {
        /// The first.
        first: u64,
        /// How many.
        count: u64,
    },
    /// A routine that does not answer as it should.
    #[error("{0}")]
    Routine(String),
    /// A folder that cannot be read.
    #[error("cannot read {0}: {1}")]
    Unread(String, std::io::Error),
    /// A folder that cannot be written.
    #[error("cannot write {0}: {1}")]
    Unwritten(String, std::io::Error),
}
