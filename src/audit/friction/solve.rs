//! Equations solved on 237 bits by Newton's method, from the product's solution on: an oracle of its own, which says where it has no
//! answer.

use crate::oracles::differences::FIRST_STEP;
use pintle_kinematics::scalar::{Scalar, Wide};
use pintle_model::behavior::friction::Flag;

/// Steps of Newton's method: two or three are enough from a double that is right.
pub(super) const STEPS: usize = 12;

/// A step this small, in sizes of the unknown, ends it: fourteen decades below the rounding of doubles, and above that of
/// differences on 237 bits (1e-45). The sizes are those of the solution, not of what it is returned from: traction after a stick so stiff
/// that it would be 1e35 times the limit must not be stepped over.
pub(super) const CONVERGED: f64 = 1e-30;

/// Why a witness has no answer.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Unsolved {
    /// Newton's method went on beyond its steps.
    NotConverged,
    /// The equations are singular on the way.
    Singular,
    /// The given numbers satisfy the equations as well as rounding lets them, and Newton's method leads to others.
    Another,
    /// Before the given slip there is one at which the limit is met already.
    NotFirst,
    /// The product says that there is no solution to compare with.
    Flagged(&'static str),
}

impl Unsolved {
    /// A flag of the product that says so, if there is one.
    pub(super) fn of(flags: &[Flag]) -> Option<Self> {
        let lost = |flag: &&Flag| matches!(flag, Flag::NoAdmissibleTraction | Flag::Unstable);
        flags.iter().find(lost).map(|flag| Self::Flagged(flag.name()))
    }

    /// The reason, by name and in words.
    pub(super) fn reason(&self) -> String {
        match self {
            Self::NotConverged => format!(
                "newton-not-converged: the equations of slip on 237 bits are not solved after {STEPS} steps from the given solution"
            ),
            Self::Singular => {
                "newton-singular: the equations of slip on 237 bits have no unique solution near the given one".to_string()
            }
            Self::Another => {
                "several-solutions: the given forces and slip satisfy the equations of slip on 237 bits within their tolerances, and \
                 Newton's method leads to others: which of them is meant is not decided"
                    .to_string()
            }
            Self::NotFirst => {
                "earlier-solution: the equations of slip on 237 bits are met by a smaller slip than the given one".to_string()
            }
            Self::Flagged(flag) => format!("{flag}: the flag says that the equations of slip define no solution of the increment"),
        }
    }
}

/// x with f(x) = 0, near a first guess; `size` is what x is measured by.
pub(super) fn root(guess: Wide, size: Wide, f: impl Fn(Wide) -> Wide) -> Result<Wide, Unsolved> {
    let mut x = guess;
    let h = Wide::from_f64(FIRST_STEP) * size;
    for _ in 0..STEPS {
        let slope = (f(x + h) - f(x - h)) / (h + h);
        if slope == Wide::zero() {
            return Err(Unsolved::Singular);
        }
        let step = f(x) / slope;
        x -= step;
        if is_converged([(step, size)]) {
            return Ok(x);
        }
    }
    Err(Unsolved::NotConverged)
}

/// Whether all steps are small, each beside what its unknown is measured by.
pub(super) fn is_converged(steps: impl IntoIterator<Item = (Wide, Wide)>) -> bool {
    steps.into_iter().all(|(step, size)| step.abs() <= size.abs() * Wide::from_f64(CONVERGED))
}

/// Solves a small system given by columns; nothing where it is singular.
pub(super) fn linear(columns: &[Vec<Wide>], right: &[Wide]) -> Option<Vec<Wide>> {
    let n = right.len();
    let mut rows: Vec<Vec<Wide>> =
        (0..n).map(|i| columns.iter().map(|column| column[i]).chain([right[i]]).collect()).collect();
    for at in 0..n {
        let pivot = (at..n).max_by(|a, b| {
            let size = |row: &usize| rows[*row][at].abs().to_f64();
            size(a).total_cmp(&size(b))
        })?;
        rows.swap(at, pivot);
        if rows[at][at] == Wide::zero() {
            return None;
        }
        for row in at + 1..n {
            let factor = rows[row][at] / rows[at][at];
            for column in at..=n {
                let by = factor * rows[at][column];
                rows[row][column] -= by;
            }
        }
    }
    let mut found = vec![Wide::zero(); n];
    for at in (0..n).rev() {
        let known = (at + 1..n).fold(Wide::zero(), |sum, j| sum + rows[at][j] * found[j]);
        found[at] = (rows[at][n] - known) / rows[at][at];
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::{Unsolved, root};
    use pintle_kinematics::scalar::Wide;

    #[test]
    fn a_root_is_found_or_missed_with_a_reason() {
        let [one, two] = [1.0, 2.0].map(Wide::from_f64);
        let near = root(Wide::from_f64(std::f64::consts::SQRT_2), one, |x| x * x - two).unwrap_or(one);
        assert!((near * near - two).abs() < Wide::from_f64(1e-60), "{:e}", near.to_f64());
        assert_eq!(root(two, one, |x| x * x + one), Err(Unsolved::NotConverged));
        assert_eq!(root(two, one, |_| one), Err(Unsolved::Singular));
        assert_eq!(root(two, one, |x| x / (x - x)), Err(Unsolved::NotConverged));
    }
}
