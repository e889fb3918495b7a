//! What is compared.

/// The connection types whose rows are written by hand, in the order of the tables.
pub(crate) const TYPES: [&str; 5] = ["SLIDE-PLANE", "REVOLUTE", "TRANSLATOR", "ROTATION", "CARDAN"];
