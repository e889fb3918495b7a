//! Who else can say what a number must be, and what each shares with the product.

pub mod certificate;
pub mod differences;
pub mod force;
pub mod golden;
pub mod oracle;
pub mod referee;
pub mod second;
pub mod sums;
pub mod truth;
