//! The numbers that a solution is computed on.

use pintle_kinematics::scalar::{Differentiable, Wide};
use pintle_model::behavior::friction::Ordered;

/// A number of a solution: `f64`, or [`Wide`] with 237 bits.
pub trait Number: Differentiable + Ordered + Send + Sync + 'static {
    /// Half of the distance from 1 to the next number.
    const ROUNDING: f64;

    /// The nearest double.
    fn to_f64(self) -> f64;

    /// So many significant digits, in scientific notation.
    fn digits(self, count: usize) -> String;
}

impl Number for f64 {
    const ROUNDING: f64 = f64::EPSILON / 2.0;

    fn to_f64(self) -> f64 {
        self
    }

    fn digits(self, count: usize) -> String {
        let places = count.saturating_sub(1);
        format!("{self:.places$e}")
    }
}

impl Number for Wide {
    // 2⁻²³⁷
    const ROUNDING: f64 = 4.5e-72;

    fn to_f64(self) -> f64 {
        Self::to_f64(self)
    }

    fn digits(self, count: usize) -> String {
        let places = count.saturating_sub(1);
        format!("{self:.places$e}")
    }
}

/// Whether x is neither infinite nor NaN.
pub(crate) fn is_finite<R: Number>(x: R) -> bool {
    (x * R::integer(0)).magnitude().less(R::integer(1))
}

/// The larger of two numbers.
pub(crate) fn larger<R: Number>(x: R, y: R) -> R {
    if x.less(y) { y } else { x }
}

/// The largest magnitude.
pub(crate) fn largest<R: Number>(of: impl IntoIterator<Item = R>) -> R {
    of.into_iter().fold(R::integer(0), |most, x| larger(most, x.magnitude()))
}
