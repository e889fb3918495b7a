//! The same numbers with one mistake in them: on which every check must speak, and by which a wrong number is explained.

pub mod cause;
pub mod diagnosis;
pub mod mutant;
pub mod planted;
