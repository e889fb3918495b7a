//! Small dense systems of linear equations, on any number.

use crate::number::{Number, larger};

/// A square matrix with its right-hand sides, row after row. Bodies are joined to a few others, so most entries are zero.
#[derive(Clone, Debug)]
pub(crate) struct Dense<R> {
    size: usize,
    width: usize,
    /// The words of a row of `filled`.
    words: usize,
    entries: Vec<R>,
    /// Which entries of each row may differ from zero: a bit for each column.
    filled: Vec<u64>,
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
        let words = width.div_ceil(BITS);
        Self { size, width, words, entries: vec![R::ZERO; size * width], filled: vec![0; size * words] }
    }

    /// Adds to an entry; columns from `size` on are right-hand sides.
    pub(crate) fn add(&mut self, row: usize, column: usize, amount: R) {
        if let Some(entry) = self.entries.get_mut(row * self.width + column)
            && !amount.is_nothing()
        {
            *entry = *entry + amount;
            self.filled[row * self.words + column / BITS] |= 1 << (column % BITS);
        }
    }

    /// The solutions, one for each right-hand side: elimination with partial pivoting of rows divided by their largest entry.
    pub(crate) fn solve(mut self) -> Result<Vec<Vec<R>>, NoPivot> {
        let (n, w, words) = (self.size, self.width, self.words);
        let (a, filled) = (&mut self.entries, &mut self.filled);
        let has = |filled: &[u64], row: usize, column: usize| {
            filled[row * words + column / BITS] >> (column % BITS) & 1 == 1
        };
        for (row, filled) in a.chunks_mut(w.max(1)).zip(filled.chunks(words.max(1))) {
            let there = columns(filled, 0).take_while(|j| *j < n);
            let most = there.fold(R::ZERO, |most, j| larger(most, row[j].magnitude()));
            if R::ZERO.less(most) {
                let factor = most.reciprocal_or_zero();
                columns(filled, 0).for_each(|j| row[j] = row[j] * factor);
            }
        }
        let least = R::from_f64(PIVOT * R::ROUNDING);
        // Rows stay where they are: this is their order.
        let mut order: Vec<usize> = (0..n).collect();
        let mut pivot: Vec<(usize, R)> = Vec::with_capacity(w);
        for k in 0..n {
            let mut best = k;
            for i in (k + 1..n).filter(|i| has(filled, order[*i], k)) {
                if a[order[best] * w + k].magnitude().less(a[order[i] * w + k].magnitude()) {
                    best = i;
                }
            }
            order.swap(k, best);
            let first = order[k];
            if !least.less(a[first * w + k].magnitude()) {
                return Err(NoPivot { column: k });
            }
            let inverse = R::integer(1) / a[first * w + k];
            pivot.clear();
            pivot.extend(columns(&filled[first * words..][..words], k + 1).map(|j| (j, a[first * w + j])));
            for row in order[k + 1..].iter().copied() {
                if !has(filled, row, k) {
                    continue;
                }
                for word in k / BITS..words {
                    filled[row * words + word] |= filled[first * words + word];
                }
                let row = &mut a[row * w..][..w];
                let factor = row[k] * inverse;
                for (j, x) in &pivot {
                    row[*j] = row[*j] - factor * *x;
                }
            }
        }
        let mut found = vec![vec![R::ZERO; n]; w - n];
        for (side, x) in found.iter_mut().enumerate() {
            for k in (0..n).rev() {
                let row = &a[order[k] * w..][..w];
                let mut sum = row[n + side];
                for j in columns(&filled[order[k] * words..][..words], k + 1).take_while(|j| *j < n) {
                    sum = sum - row[j] * x[j];
                }
                x[k] = sum / row[k];
            }
        }
        Ok(found)
    }
}

/// Bits of a word of [`Dense::filled`].
const BITS: usize = u64::BITS as usize;

/// The columns from `first` on that are filled.
fn columns(filled: &[u64], first: usize) -> impl Iterator<Item = usize> {
    let words = filled.iter().enumerate().skip(first / BITS);
    words.flat_map(move |(at, word)| {
        let mut left = if at == first / BITS { word & (u64::MAX << (first % BITS)) } else { *word };
        std::iter::from_fn(move || {
            let bit = left.trailing_zeros();
            left &= left.wrapping_sub(1);
            (bit < u64::BITS).then(|| at * BITS + bit as usize)
        })
    })
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
    /// Unknowns in chains, as bodies are joined, and one that all are joined to: rows of several words, which fill in.
    #[test]
    fn what_fills_in_is_eliminated() {
        let n = 150;
        let x = |j: usize| 1.0 + (j * j % 17) as f64;
        let mut matrix: Dense<f64> = Dense::new(n, 2);
        let mut put = |i: usize, j: usize, entry: f64| {
            matrix.add(i, j, entry);
            matrix.add(i, n, entry * x(j));
            matrix.add(i, n + 1, -entry * x(n - 1 - j));
        };
        for i in 0..n {
            // The largest entries stand beside the diagonal: every pivot is another row.
            put(i, (i + 1) % n, 5.0 + (i % 3) as f64);
            put(i, i, 1.0);
            put(i, (i + n - 7) % n, 0.5);
            put(i, n - 70, if i % 2 == 0 { 0.25 } else { -0.25 });
        }
        let found = matrix.solve().unwrap();
        let mut compared = 0;
        for (j, (one, other)) in found[0].iter().zip(&found[1]).enumerate() {
            assert!((one - x(j)).abs() < 1e-11 * x(j), "{j}: {one}, not {}", x(j));
            assert!((other + x(n - 1 - j)).abs() < 1e-11 * x(j), "{j}: {other}");
            compared += 2;
        }
        assert_eq!(compared, 2 * n);
    }

    #[test]
    fn no_number_is_no_pivot() {
        let mut matrix: Dense<f64> = Dense::new(70, 1);
        (0..70).for_each(|i| matrix.add(i, i, if i == 66 { f64::NAN } else { 1.0 }));
        assert_eq!(matrix.solve().unwrap_err().column, 66);
    }
}
