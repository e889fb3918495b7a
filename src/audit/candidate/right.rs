//! What is right at the end of a case, and how far a right answer may be from it.

use crate::case::Case;
use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::judge::bound::Bound;
use crate::oracles::truth::Truth;

/// The right numbers of a connector at one state.
#[derive(Clone, Debug)]
pub struct Right {
    /// By dual numbers on 237 bits, rounded to doubles.
    pub numbers: Numbers<f64>,
    /// The tolerances ([`crate::judge::bound`]).
    pub bound: Bound,
}

impl Right {
    /// Of the end of a case; `None` for an empty path.
    pub fn of(case: &Case) -> Option<Self> {
        let truth = Truth::of(case)?;
        let wide = truth.dual();
        let mut numbers = Numbers::default();
        for quantity in Quantity::ALL {
            let entries: Entries<f64> = wide.entries(quantity).map(|_, _, x| x.to_f64());
            numbers.set(quantity, entries);
        }
        let state = case.last()?.state;
        let near = truth.nearness_of_components();
        let bound = Bound::of_components(&numbers, &state, truth.length(), &near);
        Some(Self { numbers, bound })
    }
}
