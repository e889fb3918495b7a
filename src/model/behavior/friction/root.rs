//! Where a falling excess first vanishes, and the linear systems of the slip equations.

use crate::behavior::friction::flags::{Flag, Flags};
use crate::behavior::friction::{Ordered, is_finite, is_zero};
use pintle_kinematics::Differentiable;
use pintle_kinematics::scalar::{Real, Scalar};
use std::cmp::Ordering;

/// Δγ from p − ℓ(0) − Δγ = ℓ(Δγ) − ℓ(0), the first one met from stick, with its derivatives: p = P(f_tr)/K, ℓ = L/K.
///
/// `excess` is p − ℓ(0), positive, and `most` is p. `rise_and_slope` is ℓ − ℓ(0) and dℓ/dΔγ on real numbers, smooth between `breaks`;
/// `rise` is the first on the scalar.
pub(super) fn slip_increment<S>(
    excess: S,
    most: S::Real,
    breaks: impl Iterator<Item = S::Real>,
    rise_and_slope: impl Fn(S::Real) -> (S::Real, S::Real),
    rise: impl Fn(S) -> S,
    flags: &mut Flags,
) -> S
where
    S: Scalar,
    S::Real: Ordered + Differentiable,
{
    let one = S::Real::integer(1);
    let root = first_root(&sorted(breaks, most), most, |slip| {
        let (rise, slope) = rise_and_slope(slip);
        (excess.real() - slip - rise, -(one + slope))
    });
    let fall = one + rise_and_slope(root).1;
    if !S::Real::ZERO.less(fall) {
        flags.add(Flag::Unstable);
    }
    let there = S::from_real(root);
    there + (excess - there - rise(there)).scale(fall.reciprocal_or_zero())
}

/// The first root in [0, most] of a function that is positive at 0 and not at `most`, given with its slope; by Newton's method,
/// safeguarded by bisection. Between `breaks` the function is smooth.
fn first_root<R: Ordered + Differentiable>(breaks: &[R], most: R, h: impl Fn(R) -> (R, R)) -> R {
    let zero = R::ZERO;
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
        if is_zero(newton - x) {
            break;
        }
        let middle = low + (high - low) * R::ratio(1, 2);
        x = if low.less(newton) && !high.less(newton) {
            newton
        } else if low.less(middle) && middle.less(high) {
            middle
        } else {
            break;
        };
    }
    x
}

/// The slips below `most`, each once, in increasing order.
fn sorted<R: Ordered + Differentiable>(slips: impl Iterator<Item = R>, most: R) -> Vec<R> {
    let mut sorted: Vec<R> = slips.filter(|slip| R::ZERO.less(*slip) && slip.less(most)).collect();
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
    use super::{Equations, SLOTS, first_root, slip_increment, sorted};
    use crate::behavior::friction::flags::{Flag, Flags};
    use pintle_kinematics::scalar::Duals;
    use pintle_kinematics::scalar::elementary::{exp, recip};
    use pintle_kinematics::scalar::{Scalar, Seeded};
    use std::cell::Cell;

    /// Each once, in increasing order; a table of a hundred thousand rows costs no time.
    #[test]
    fn slips_are_sorted_once() {
        let given = [3.0, 1.0, 9.0, 1.0, f64::NAN, -1.0, 2.0, 0.0];
        assert_eq!(sorted(given.into_iter(), 9.0), [1.0, 2.0, 3.0]);
        let many = (1..=100_000).rev().map(f64::from);
        assert_eq!(sorted(many, 1e9).len(), 100_000);
    }

    /// The root of h, and how often h was asked.
    fn counted(most: f64, h: impl Fn(f64) -> (f64, f64)) -> (f64, usize) {
        let count = Cell::new(0);
        let root = first_root(&[], most, |x| {
            count.set(count.get() + 1);
            h(x)
        });
        (root, count.get())
    }

    /// Newton's steps, concave and convex, none of them wasted at the end; and halves alone where slopes mislead.
    #[test]
    fn roots_are_found_in_few_steps() {
        let smooth = |height: f64, x: f64| (6.0 - 2.0 * x - height * (-x).exp(), -2.0 + height * (-x).exp());
        for height in [-3.0, -0.5, 0.0, 0.5, 1.0] {
            let (root, count) = counted(5.0, |x| smooth(height, x));
            assert!(smooth(height, root).0.abs() <= 4.0 * f64::EPSILON, "{height}: {root}");
            assert!(count <= 8, "{height}: {count} steps");
        }
        for slope in [0.0, 1.0, -1e-3, f64::NAN] {
            let (root, count) = counted(8.0, |x| (1.0 - x / 3.0, slope));
            assert!(
                (root - 3.0).abs() <= 4.0 * f64::EPSILON && count <= 60,
                "{slope}: {root}, {count} steps"
            );
        }
        // The root is at an end: of nothing, or of all.
        assert_eq!(counted(8.0, |x| (-1.0 - x, -1.0)).0, 0.0);
        assert_eq!(counted(8.0, |x| (8.0 - x, -1.0)).0, 8.0);
    }

    /// (6 − 1)/K − x = (3 − 3 exp(−x/2))/K: the slope of the limit counts among the steps and in the derivatives. These are 1/(K + L′) by
    /// the trial force and −x/(K + L′) by the stiffness.
    #[test]
    fn slips_have_their_derivatives() {
        type Number = <f64 as Duals>::Gradient<2>;
        let count = Cell::new(0);
        let steep = |x: f64| 1.5 * (-x / 2.0).exp();
        let mut flags = Flags::default();
        let flexibility = recip(Number::seed(2.0, 1));
        let slip = slip_increment(
            (Number::seed(6.0, 0) - Number::one()) * flexibility,
            3.0,
            [].into_iter(),
            |x: f64| {
                count.set(count.get() + 1);
                (1.5 - steep(x), 0.5 * steep(x))
            },
            |x: Number| (Number::one() - exp(x.scale(-0.5))).scale(3.0) * flexibility,
            &mut flags,
        );
        let x = slip.real();
        assert!((6.0 - 2.0 * x - (4.0 - 2.0 * steep(x))).abs() <= 4.0 * f64::EPSILON, "{x}");
        let [by_trial, by_stiffness] = slip.gradient();
        let fall = 2.0 + steep(x);
        assert!((by_trial - 1.0 / fall).abs() < 1e-15 && (by_stiffness + x / fall).abs() < 1e-15);
        assert!(count.get() <= 8, "{} steps", count.get());
        assert!(flags.into_vec().is_empty());
    }

    /// A limit that falls faster than the spring unloads: no slip is stable there.
    #[test]
    fn a_limit_that_falls_faster_is_told() {
        for (fall, is_unstable) in [(0.5, false), (1.0, true), (2.0, true)] {
            let mut flags = Flags::default();
            let rise = |x: f64| -fall * x;
            slip_increment(0.5, 1.5, [].into_iter(), |x| (rise(x), -fall), rise, &mut flags);
            assert_eq!(flags.into_vec(), if is_unstable { vec![Flag::Unstable] } else { vec![] }, "{fall}");
        }
    }

    /// Rows are exchanged where a pivot is zero; what is singular or no number has no solution.
    #[test]
    fn systems_are_solved_or_refused() {
        let of = |rows: [[f64; 3]; 3], right: [f64; 3]| {
            let mut jacobian = [[0.0; SLOTS]; SLOTS];
            let mut b = [0.0; SLOTS];
            for i in 0..3 {
                jacobian[i][..3].copy_from_slice(&rows[i]);
                b[i] = right[i];
            }
            Equations { jacobian, n: 3 }.solve(&b).map(|x| [x[0], x[1], x[2]])
        };
        let rows = [[0.0, 2.0, 1.0], [4.0, 2.0, 0.0], [2.0, 5.0, 8.0]];
        assert_eq!(of(rows, [7.0, 8.0, 36.0]), Some([1.0, 2.0, 3.0]));
        assert_eq!(of([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 1.0, 1.0]], [1.0; 3]), None);
        assert_eq!(of([[f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [1.0; 3]), None);
        assert_eq!(of([[f64::INFINITY, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [1.0; 3]), None);
    }
}
