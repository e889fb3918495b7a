//! Lanes against doubles.
