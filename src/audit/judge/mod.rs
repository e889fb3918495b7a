//! Numbers against what they must be: the bound, the verdict, the report.

pub mod bound;
pub mod comparison;
pub mod components;
pub mod conditioned;
pub mod examined;
pub mod judged;
pub mod outcome;
pub mod slopes;
pub mod table;
pub mod verdict;
