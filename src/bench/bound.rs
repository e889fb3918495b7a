//! How far a way may be off and still be timed: by what the errors come from.

use crate::place::{CLEAR, Proximity};
use crate::subject::Order;
use pintle_kinematics::scalar::U;

/// What the errors of a way come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The rounding of pintle's own numbers: more than that is a mistake, and is told as one.
    Ours,
    /// The rounding of exact derivatives by formulas with a branch for each singular point.
    Rounding,
    /// The rounding of exact derivatives by formulas without such branches: they divide by the sine of an angle, and each derivative
    /// divides once more.
    NoBranches,
    /// The truncation h f″ beside the rounding u f/h, at the step of a sweep that is best for all rows, near a singular point the steep and the flat.
    ForwardDifference,
    /// h² f‴ beside u f/h, likewise.
    CentralDifference,
    /// h² f⁗ beside u f/h², likewise.
    SecondDifference,
}

/// The room that errors beyond those of rounding alone are given: what the coefficients of their orders may be.
const ROOM: f64 = 100.0;

impl Cause {
    /// The largest error ([`crate::Subject::errors`]) of a way that is timed, at states whose distance from a singular point (rad,
    /// or lengths of the connector) is `distance`. It is `None` where rounding is all that there is, which has a bound for every
    /// entry ([`crate::Subject::beyond_rounding`]).
    ///
    /// Near a singular point values are known to u/distance, and derivatives grow by 1/distance with each order. At rest all functions
    /// are regular, and only formulas that divide by the sine are not.
    pub fn bound(self, order: Order, place: Proximity, distance: f64) -> Option<f64> {
        let steepness = match place {
            Proximity::Near => distance.recip().max(1.0),
            Proximity::Far => CLEAR.recip(),
            Proximity::Rest => 1.0,
        };
        Some(match self {
            Self::Ours | Self::Rounding => return None,
            // At rest the vector that the sine divides is as small as it, which gives two orders back.
            Self::NoBranches if place == Proximity::Rest => {
                ROOM * U * if order == Order::Hessian { distance.recip() } else { 1.0 }
            }
            Self::NoBranches => ROOM * U * steepness.powi(1 + order as i32),
            Self::ForwardDifference | Self::SecondDifference => ROOM * U.sqrt() * steepness,
            Self::CentralDifference => ROOM * (U * steepness * steepness).cbrt().powi(2),
        })
    }
}
