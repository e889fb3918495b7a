//! Small dense systems of linear equations, on any number.

use crate::number::{Number, larger};

/// A square matrix with its right-hand sides, row after row.
#[derive(Clone, Debug)]
pub(crate) struct Dense<R> {
    size: usize,
    width: usize,
    entries: Vec<R>,
}

/// A pivot that rounding explains: its column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NoPivot {
    pub(crate) column: usize,
}

/// Pivots below this part of the largest entry of their scaled matrix count as zero, in rounding units.
const PIVOT: f64 = 1e5;

impl<R: Number> Dense<R> {
    /// Zero, of `size` unknowns and `sides` right-hand sides.
    pub(crate) fn new(size: usize, sides: usize) -> Self {
        let width = size + sides;
        Self { size, width, entries: vec![R::integer(0); size * width] }
    }

    /// Adds to an entry; columns from `size` on are right-hand sides.
    pub(crate) fn add(&mut self, row: usize, column: usize, amount: R) {
        if let Some(entry) = self.entries.get_mut(row * self.width + column) {
            *entry = *entry + amount;
        }
    }

    /// The solutions, one for each right-hand side: elimination with partial pivoting of rows divided by their largest entry.
    pub(crate) fn solve(mut self) -> Result<Vec<Vec<R>>, NoPivot> {
        let (n, w) = (self.size, self.width);
        let zero = R::integer(0);
        let a = &mut self.entries;
        for row in a.chunks_mut(w.max(1)) {
            let there = row.iter().take(n).filter(|x| !x.is_nothing());
            let most = there.fold(zero, |most, x| larger(most, x.magnitude()));
            if zero.less(most) {
                let factor = most.reciprocal_or_zero();
                row.iter_mut().filter(|x| !x.is_nothing()).for_each(|x| *x = *x * factor);
            }
        }
        let least = R::from_f64(PIVOT * R::ROUNDING);
        let mut filled = Vec::with_capacity(w);
        for k in 0..n {
            let mut best = k;
            for i in (k + 1..n).filter(|i| !a[*i * w + k].is_nothing()) {
                if a[best * w + k].magnitude().less(a[i * w + k].magnitude()) {
                    best = i;
                }
            }
            if !least.less(a[best * w + k].magnitude()) {
                return Err(NoPivot { column: k });
            }
            if best != k {
                for j in k..w {
                    a.swap(k * w + j, best * w + j);
                }
            }
            let inverse = R::integer(1) / a[k * w + k];
            // Bodies are joined to a few others: most entries are zero.
            let (above, below) = a.split_at_mut((k + 1) * w);
            let pivot = above.get(k * w..).unwrap_or_default();
            filled.clear();
            filled.extend((k + 1..w).filter(|j| !pivot[*j].is_nothing()));
            for row in below.chunks_mut(w).filter(|row| !row[k].is_nothing()) {
                let factor = row[k] * inverse;
                for j in &filled {
                    row[*j] = row[*j] - factor * pivot[*j];
                }
            }
        }
        let mut found = vec![vec![zero; n]; w - n];
        for (side, x) in found.iter_mut().enumerate() {
            for k in (0..n).rev() {
                let mut sum = a[k * w + n + side];
                for j in (k + 1..n).filter(|j| !a[k * w + j].is_nothing()) {
                    sum = sum - a[k * w + j] * x[j];
                }
                x[k] = sum / a[k * w + k];
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::Dense;
    use pintle_kinematics::scalar::{Scalar, Wide};

    #[test]
    fn hilbert_is_inverted() {
        // Σ_j H_ij = b_i has the solution 1, whose condition takes 17 of 71 digits.
        let n = 12;
        let mut matrix: Dense<Wide> = Dense::new(n, 1);
        for i in 0..n {
            for j in 0..n {
                let entry = Wide::from_f64(1.0) / Wide::from_f64((i + j + 1) as f64);
                matrix.add(i, j, entry);
                matrix.add(i, n, entry);
            }
        }
        let found = matrix.solve().unwrap();
        assert_eq!(found[0].len(), n);
        for x in &found[0] {
            assert!((*x - Wide::from_f64(1.0)).abs() < Wide::from_f64(1e-50), "{}", x.real());
        }
    }

    #[test]
    fn a_singular_matrix_has_no_pivot() {
        let mut matrix: Dense<f64> = Dense::new(3, 1);
        for i in 0..3 {
            for j in 0..3 {
                matrix.add(i, j, (i * 3 + j) as f64);
            }
        }
        assert_eq!(matrix.solve().unwrap_err().column, 2);
    }
}
