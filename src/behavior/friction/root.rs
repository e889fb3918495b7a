//! Where a falling excess first vanishes, and the linear systems of the slip equations.

use super::flags::{Flag, Flags};
use super::{Ordered, is_finite, is_zero};
use crate::scalar::{Differentiable, Real, Scalar};
use std::cmp::Ordering;

/// Δγ from p − K Δγ = L(Δγ), the first one met from stick, with its derivatives.
///
/// `limit_and_slope` is L and dL/dΔγ on real numbers, smooth between `breaks`; `limit` is L on the scalar.
pub(super) fn slip_increment<S>(
    trial: S,
    stiffness: S,
    breaks: impl Iterator<Item = S::Real>,
    limit_and_slope: impl Fn(S::Real) -> (S::Real, S::Real),
    limit: impl Fn(S) -> S,
    flags: &mut Flags,
) -> S
where
    S: Scalar,
    S::Real: Ordered + Differentiable,
{
    let (p, k) = (trial.real(), stiffness.real());
    let most = p / k;
    let root = first_root(&sorted(breaks, most), most, |slip| {
        let (limit, slope) = limit_and_slope(slip);
        (p - k * slip - limit, -(k + slope))
    });
    let fall = k + limit_and_slope(root).1;
    if !S::Real::integer(0).less(fall) {
        flags.add(Flag::Unstable);
    }
    let there = S::from_real(root);
    there + (trial - stiffness.scale(root) - limit(there)).scale(fall.reciprocal_or_zero())
}

/// The first root in [0, most] of a function that is positive at 0 and not at `most`, given with its slope; by Newton's method,
/// safeguarded by bisection. Between `breaks` the function is smooth.
fn first_root<R: Ordered + Differentiable>(breaks: &[R], most: R, h: impl Fn(R) -> (R, R)) -> R {
    let zero = R::integer(0);
    let (mut low, mut high) = (zero, most);
    for point in breaks {
        if zero.less(h(*point).0) {
            low = *point;
        } else {
            high = *point;
            break;
        }
    }
    /// Bisection alone narrows 1e300 to the last of 237 bits in fewer.
    const ITERATIONS: usize = 1300;
    let mut x = low;
    for _ in 0..ITERATIONS {
        let (value, slope) = h(x);
        if zero.less(value) {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let is_between = |x: R| low.less(x) && x.less(high);
        let next = if is_between(newton) { newton } else { low + (high - low) * R::ratio(1, 2) };
        if is_zero(value) || is_zero(newton - x) || !is_between(next) {
            break;
        }
        x = next;
    }
    x
}

/// The slips below `most`, each once, in increasing order.
fn sorted<R: Ordered + Differentiable>(slips: impl Iterator<Item = R>, most: R) -> Vec<R> {
    let mut sorted: Vec<R> = slips.filter(|slip| R::integer(0).less(*slip) && slip.less(most)).collect();
    sorted.sort_by(|x, y| {
        if x.less(*y) {
            Ordering::Less
        } else if y.less(*x) {
            Ordering::Greater
        } else {
            Ordering::Equal
        }
    });
    sorted.dedup_by(|x, y| !y.less(*x));
    sorted
}

/// Places in the slip equations: six forces and the slip.
pub(super) const SLOTS: usize = 7;

/// The matrix of a linear system of n equations.
pub(super) struct Equations<R> {
    pub(super) jacobian: [[R; SLOTS]; SLOTS],
    pub(super) n: usize,
}

impl<R: Ordered + Differentiable> Equations<R> {
    /// The solution for a right-hand side that may carry derivatives, by elimination with row pivoting; none where the matrix
    /// is singular.
    pub(super) fn solve<S: Scalar<Real = R>>(&self, right: &[S; SLOTS]) -> Option<[S; SLOTS]> {
        let (mut a, mut b, n) = (self.jacobian, *right, self.n);
        for column in 0..n {
            let mut pivot = column;
            for row in column..n {
                if a[pivot][column].magnitude().less(a[row][column].magnitude()) {
                    pivot = row;
                }
            }
            if is_zero(a[pivot][column]) || !is_finite(a[pivot][column]) {
                return None;
            }
            a.swap(column, pivot);
            b.swap(column, pivot);
            for row in column + 1..n {
                let factor = a[row][column] / a[column][column];
                for k in column..n {
                    a[row][k] = a[row][k] - factor * a[column][k];
                }
                b[row] = b[row] - b[column].scale(factor);
            }
        }
        for column in (0..n).rev() {
            for k in column + 1..n {
                b[column] = b[column] - b[k].scale(a[column][k]);
            }
            b[column] = b[column].scale(R::integer(1) / a[column][column]);
        }
        Some(b)
    }
}

#[cfg(test)]
mod tests {
    use super::sorted;

    /// Each once, in increasing order; a table of a hundred thousand rows costs no time.
    #[test]
    fn slips_are_sorted_once() {
        let given = [3.0, 1.0, 9.0, 1.0, f64::NAN, -1.0, 2.0, 0.0];
        assert_eq!(sorted(given.into_iter(), 9.0), [1.0, 2.0, 3.0]);
        let many = (1..=100_000).rev().map(f64::from);
        assert_eq!(sorted(many, 1e9).len(), 100_000);
    }
}
