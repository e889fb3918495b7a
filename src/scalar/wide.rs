//! Wide.
