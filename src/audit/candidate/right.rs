//! What is right at the end of a case, and how far a right answer may be from it.

use crate::case::Case;
use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::judge::bound::Bound;
use crate::oracles::truth::Truth;
use pintle_kinematics::connector::{Components, Output, Request};

/// The right numbers of a connector at one state.
#[derive(Clone, Debug)]
pub struct Right {
    /// By dual numbers on 237 bits, rounded to doubles.
    pub numbers: Numbers<f64>,
    /// The tolerances ([`crate::judge::bound`]).
    pub bound: Bound,
    /// CP of each component (length, rad).
    pub positions: Components<f64>,
    /// CCU of each component (length, rad).
    pub constitutive: Components<f64>,
    /// min(1, distance to the nearest singular set), in radians and lengths of the connector; 0 on one.
    pub nearness: f64,
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
        let (evaluation, _) = case.evaluation(&Request::new(&[Output::CP, Output::CCU], [true; 6], 0))?;
        let (positions, constitutive) = (evaluation.position, evaluation.constitutive);
        Some(Self { numbers, bound, positions, constitutive, nearness: truth.nearness() })
    }
}
