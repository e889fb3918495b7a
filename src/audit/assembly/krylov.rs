//! Rank, null vectors and least solutions from products with the matrix alone: of parts that fill when they are eliminated. Memory is that of
//! the entries and of some vectors.
//!
//! *Null vectors.* A random vector less its part in the range of M is a null vector of Mᵀ: conjugate gradients on the normal equations find
//! it. It is drawn as often as something is left, of the rows or of the columns, whichever are fewer; of a matrix with more than
//! [`EXPLAINED`] on both sides nothing is found.
//!
//! *That there are no more* is certified from below: what is not a null vector is stretched by at least σ. The Lanczos process on M Mᵀ from
//! a random start, orthogonal to the null vectors, overestimates its least eigenvalue λ after k steps by more than ε of the largest with
//! probability 1.648 √p exp(−(2k − 1) √ε) at most (Kuczyński and Woźniakowski, 1992, theorem 4.2, for the largest eigenvalue, applied to
//! top − M Mᵀ, p the number of rows). Steps go on until that is below [`MISSED`] with an ε of half of what was found. The theorem is of exact
//! arithmetic and a start uniform on the sphere. In doubles what is found does not fall below the least eigenvalue by more than roundings
//! (Paige), but lost orthogonality may delay it by some steps, and the start is of sums of four uniform numbers: the probability is that of the
//! model, not of the program.
//! By Weyl the rank is then certain where σ exceeds the norm of what rounding can change, and the null vectors are
//! mapped to less than that.

use super::budget::{Budget, PRODUCTS};
use super::dense::CONTRIBUTES;
use super::eliminate::{Outcome, Sparse};
use super::found::{SECOND_ORDER, allowed};
use super::noise::random;
use super::redundant::EXPLAINED;
use rayon::prelude::*;
use std::borrow::Cow;

/// The probability that the least singular value is smaller than certified.
const MISSED: f64 = 6e-12;
/// Products with single entries that may be spent on a matrix: some ten seconds of two processors.
const WORK: u64 = 15_000_000_000;
/// Of this part of a random vector that is left, rounding cannot be told from a null vector.
const LEFT: f64 = 1e-9;
/// Motions, or redundant rows, that are named where there are more than were found one by one.
const NAMED: usize = 8;
/// Of which amounts of a vector so found, relative to the largest, is known that they are not zero.
pub(super) const MOVES: f64 = 1e-6;
/// A matrix of fewer entries is multiplied by one thread.
const SHARED: usize = 50_000;

/// A vector that stands for a row or column.
pub(super) type Named = (u32, Vec<f64>);

/// A matrix by rows: the entries of one that is given, or of its transpose.
struct Compressed<'a> {
    offsets: Cow<'a, [usize]>,
    indices: Cow<'a, [u32]>,
    values: Cow<'a, [f64]>,
}

impl<'a> Compressed<'a> {
    fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    fn of(matrix: &'a Sparse) -> Self {
        let Sparse { offsets, columns, values, .. } = matrix;
        Self { offsets: offsets.into(), indices: columns.into(), values: values.into() }
    }

    fn transposed(&self, width: usize) -> Compressed<'static> {
        let mut offsets = vec![0; width + 1];
        for column in self.indices.iter() {
            offsets[*column as usize + 1] += 1;
        }
        for column in 0..width {
            offsets[column + 1] += offsets[column];
        }
        let mut next = offsets.clone();
        let (mut indices, mut values) = (vec![0; self.indices.len()], vec![0.0; self.indices.len()]);
        for row in 0..self.rows() {
            for at in self.offsets[row]..self.offsets[row + 1] {
                let place = &mut next[self.indices[at] as usize];
                indices[*place] = row as u32;
                values[*place] = self.values[at];
                *place += 1;
            }
        }
        Compressed { offsets: offsets.into(), indices: indices.into(), values: values.into() }
    }

    /// The product with a vector.
    fn times(&self, vector: &[f64], product: &mut [f64]) {
        let one = |row: usize| {
            let range = self.offsets[row]..self.offsets[row + 1];
            let entries = self.indices[range.clone()].iter().zip(&self.values[range]);
            entries.map(|(column, value)| value * vector[*column as usize]).sum::<f64>()
        };
        if self.values.len() < SHARED {
            product.iter_mut().enumerate().for_each(|(row, sum)| *sum = one(row));
        } else {
            product.par_iter_mut().with_min_len(2048).enumerate().for_each(|(row, sum)| *sum = one(row));
        }
    }

    /// The largest sum of magnitudes of a row.
    fn norm(&self) -> f64 {
        let sum = |row: usize| {
            self.values[self.offsets[row]..self.offsets[row + 1]].iter().map(|x| x.abs()).sum::<f64>()
        };
        (0..self.rows()).map(sum).fold(0.0, f64::max)
    }
}

/// A matrix M of p rows with its transpose, and what may still be spent on it.
struct Both<'a> {
    by_rows: &'a Compressed<'a>,
    by_columns: &'a Compressed<'a>,
    /// A bound of the largest eigenvalue of M Mᵀ.
    top: f64,
    left: &'a mut u64,
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

fn add(to: &mut [f64], times: f64, vector: &[f64]) {
    for (sum, x) in to.iter_mut().zip(vector) {
        *sum += times * x;
    }
}

fn length(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// A random vector.
fn drawn(count: usize, seed: u64) -> Vec<f64> {
    (0..count).map(|i| f64::from(random(seed << 40 | i as u64)[0])).collect()
}

/// Takes from a vector what of it is along others, which are orthonormal.
fn clear(vector: &mut [f64], basis: &[Vec<f64>]) {
    for other in basis {
        let along = dot(vector, other);
        add(vector, -along, other);
    }
}

impl Both<'_> {
    /// Counts the entries of a product with M and one with Mᵀ; `false` where no more may be spent.
    fn spend(&mut self) -> bool {
        let cost = 2 * self.by_rows.values.len() as u64 + self.by_rows.rows() as u64 * 4;
        let enough = *self.left >= cost;
        *self.left = self.left.saturating_sub(cost);
        enough
    }

    /// What of a vector is not in the range of M, by conjugate gradients on the normal equations, to a part of its own length; `None` where that would
    /// take too long. With `solution`, x with M x nearest to the vector too.
    fn left_of(
        &mut self,
        vector: &[f64],
        exactness: f64,
        mut solution: Option<&mut Vec<f64>>,
    ) -> Option<Vec<f64>> {
        /// Without progress for so many steps, rounding allows none.
        const PATIENCE: usize = 300;
        let (size, largest) = (length(vector), self.top.sqrt());
        let mut left = vector.to_vec();
        let mut slope = vec![0.0; self.by_columns.rows()];
        self.by_columns.times(&left, &mut slope);
        let (mut direction, mut image) = (slope.clone(), vec![0.0; left.len()]);
        let mut now = dot(&slope, &slope);
        let (mut best, mut since) = (now, 0);
        if let Some(solution) = solution.as_deref_mut() {
            *solution = vec![0.0; slope.len()];
        }
        while now.sqrt() > exactness * largest * length(&left) && length(&left) > 1e-13 * size {
            if since > PATIENCE {
                break;
            }
            if !self.spend() {
                return None;
            }
            self.by_rows.times(&direction, &mut image);
            let step = now / dot(&image, &image);
            if !step.is_finite() {
                break;
            }
            add(&mut left, -step, &image);
            if let Some(solution) = solution.as_deref_mut() {
                add(solution, step, &direction);
            }
            self.by_columns.times(&left, &mut slope);
            let next = dot(&slope, &slope);
            let turn = next / now;
            for (d, s) in direction.iter_mut().zip(&slope) {
                *d = s + turn * *d;
            }
            now = next;
            since += 1;
            if now < 0.5 * best {
                (best, since) = (now, 0);
            }
        }
        left.iter().all(|x| x.is_finite()).then_some(left)
    }

    /// Orthonormal null vectors of Mᵀ; `None` where they are too many, or take too long.
    fn null_vectors(&mut self) -> Option<Vec<Vec<f64>>> {
        let count = self.by_rows.rows();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        loop {
            let mut random = drawn(count, basis.len() as u64 + 1);
            clear(&mut random, &basis);
            let size = length(&random);
            let mut left = self.left_of(&random, 1e-11, None)?;
            clear(&mut left, &basis);
            if length(&left) <= LEFT * size {
                return Some(basis);
            }
            // Of a random vector in so many dimensions so much is along null vectors.
            let expected = count as f64 * (length(&left) / size).powi(2);
            if basis.len() >= EXPLAINED || expected > 4.0 * EXPLAINED as f64 {
                return None;
            }
            // What rounding left of the first time is small beside what is left now.
            let mut again = self.left_of(&left, 1e-15, None)?;
            clear(&mut again, &basis);
            clear(&mut again, &basis);
            let size = length(&again);
            if size.is_nan() || size <= 0.5 * length(&left) {
                return None;
            }
            again.iter_mut().for_each(|x| *x /= size);
            basis.push(again);
        }
    }

    /// A lower bound of the least eigenvalue of M Mᵀ on vectors that are orthogonal to others; `None` where none is found that is not zero.
    fn least_eigenvalue(&mut self, others: &[Vec<f64>]) -> Option<f64> {
        const ROUNDING: f64 = 1e-13;
        let count = self.by_rows.rows();
        if count == others.len() {
            return Some(f64::INFINITY);
        }
        let exponent = (1.648 * (count as f64).sqrt() / MISSED).ln();
        let mut vector = drawn(count, 77);
        clear(&mut vector, others);
        let size = length(&vector);
        vector.iter_mut().for_each(|x| *x /= size);
        let (mut before, mut product) = (vec![0.0; count], vec![0.0; count]);
        let mut middle = vec![0.0; self.by_columns.rows()];
        let (mut diagonal, mut beside): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut look = 20;
        loop {
            let may_go_on = self.spend();
            self.by_columns.times(&vector, &mut middle);
            self.by_rows.times(&middle, &mut product);
            let on = dot(&product, &vector);
            diagonal.push(on);
            add(&mut product, -on, &vector);
            add(&mut product, -beside.last().copied().unwrap_or_default(), &before);
            clear(&mut product, others);
            let off = length(&product);
            let steps = diagonal.len();
            // Where nothing is left, the vectors so far span all that the start is made of, to rounding.
            let is_whole = off <= ROUNDING * self.top;
            if is_whole || steps >= look || !may_go_on {
                let least = least_of(&diagonal, &beside, self.top);
                if is_whole {
                    let bound = least - 10.0 * ROUNDING * self.top;
                    return (bound > 0.0).then_some(bound);
                }
                let part = (exponent / (2 * steps - 1) as f64).powi(2);
                let bound = (least - part * self.top) / (1.0 - part);
                if part < 0.5 && bound >= 0.5 * least {
                    return Some(bound);
                }
                // Less than any rank is decided by, or too near to zero to be told from it in time.
                if !may_go_on || least < 1e-9 * self.top {
                    return (part < 0.5 && bound > 0.0).then_some(bound);
                }
                look = steps + steps / 4;
            }
            beside.push(off);
            std::mem::swap(&mut before, &mut vector);
            for (x, y) in vector.iter_mut().zip(&product) {
                *x = y / off;
            }
        }
    }
}

/// The least eigenvalue of a symmetric tridiagonal matrix that is not negative, by bisection.
fn least_of(diagonal: &[f64], beside: &[f64], top: f64) -> f64 {
    let is_below = |x: f64| {
        let mut pivot = f64::INFINITY;
        let squares = std::iter::once(0.0).chain(beside.iter().map(|x| x * x));
        diagonal.iter().zip(squares).any(|(on, square)| {
            pivot = on - x - if square == 0.0 { 0.0 } else { square / pivot };
            pivot < 0.0
        })
    };
    let (mut low, mut high) = (0.0, top);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if is_below(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    low
}

/// Vectors of the same span, each with one at a place where the others are zero. `prefers` says which of two places whose entries are not much
/// smaller than the largest is taken.
fn reduced(mut basis: Vec<Vec<f64>>, prefers_last: bool) -> Option<Vec<Named>> {
    let mut places: Vec<usize> = Vec::new();
    for n in 0..basis.len() {
        // The row of the largest of the vectors that are left.
        let largest = |vector: &Vec<f64>| vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let sizes: Vec<f64> = basis[n..].iter().map(largest).collect();
        let best = sizes.iter().enumerate().max_by(|x, y| x.1.total_cmp(y.1)).map(|(at, _)| n + at)?;
        basis.swap(n, best);
        let size = largest(&basis[n]);
        let enough = |x: &f64| x.abs() >= if prefers_last { 0.3 } else { 1.0 } * size;
        let place =
            if prefers_last { basis[n].iter().rposition(enough) } else { basis[n].iter().position(enough) }?;
        let at = basis[n][place];
        basis[n].iter_mut().for_each(|x| *x /= at);
        let pivot = std::mem::take(&mut basis[n]);
        for (m, other) in basis.iter_mut().enumerate().filter(|(m, _)| *m != n) {
            debug_assert!(m != n);
            let times = other[place];
            add(other, -times, &pivot);
            other[place] = 0.0;
        }
        basis[n] = pivot;
        places.push(place);
    }
    Some(places.into_iter().map(|place| place as u32).zip(basis).collect())
}

/// What of the unit vectors along some places is in the null space of Mᵀ, where that has more dimensions than are named: of places of which much
/// is, and which are not the same motion.
fn some_null_vectors(both: &mut Both<'_>, count: usize) -> Vec<Named> {
    /// Amounts of less than [`MOVES`] are not told apart.
    const EXACT: f64 = 1e-8;
    let size = both.by_rows.rows();
    let Some(spread) = both.left_of(&drawn(size, 99), EXACT, None) else { return Vec::new() };
    let mut places: Vec<usize> = (0..size).collect();
    places.sort_by(|x, y| spread[*y].abs().total_cmp(&spread[*x].abs()));
    let (mut found, mut basis): (Vec<Named>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    for place in places.into_iter().take(4 * NAMED) {
        if found.len() >= NAMED.min(count) {
            break;
        }
        let mut unit = vec![0.0; size];
        unit[place] = 1.0;
        let Some(mut vector) = both.left_of(&unit, EXACT, None) else { break };
        let mut own = vector.clone();
        clear(&mut own, &basis);
        let (before, left) = (length(&vector), length(&own));
        if before > 0.05 && left > 0.2 * before {
            own.iter_mut().for_each(|x| *x /= left);
            basis.push(own);
            let at = vector[place];
            vector.iter_mut().for_each(|x| *x /= at);
            found.push((place as u32, vector));
        }
    }
    found
}

/// The rank of a matrix whose entries are uncertain by that besides rounding, where it is certain; `None` where it is not, or would take more than so many
/// products, or [`WORK`]. What is named where there is more than was found one by one costs what may be spent on names.
pub(super) fn rank(matrix: &Sparse, uncertainty: f64, most: f64, budget: &Budget) -> Option<Outcome> {
    let mut left = WORK.min(most as u64);
    let by_rows = Compressed::of(matrix);
    let by_columns = by_rows.transposed(matrix.width());
    let top = by_rows.norm() * by_columns.norm();
    let (computed, allowed) = (matrix.changes()[0], allowed(matrix, uncertainty));
    if !(top.is_finite() && top > 0.0 && allowed.is_finite()) {
        return None;
    }
    let sides = if matrix.rows() <= matrix.width() { [true, false] } else { [false, true] };
    for of_rows in sides {
        let (one, other) = if of_rows { (&by_rows, &by_columns) } else { (&by_columns, &by_rows) };
        let mut both = Both { by_rows: one, by_columns: other, top, left: &mut left };
        let Some(basis) = both.null_vectors() else { continue };
        let Some(least) = both.least_eigenvalue(&basis) else { continue };
        let mut image = vec![0.0; other.rows()];
        let mut zero = 0.0_f64;
        for vector in &basis {
            other.times(vector, &mut image);
            zero = zero.hypot(length(&image));
        }
        let nonzero = least.sqrt();
        if zero > allowed || nonzero <= allowed || nonzero <= SECOND_ORDER * top.sqrt() {
            continue;
        }
        let rank = one.rows() - basis.len();
        let beside = other.rows() - rank;
        let listed = reduced(basis, of_rows)?;
        let of_names = (WORK / 2).min(budget.left().saturating_mul(PRODUCTS as u64));
        let mut for_names = of_names;
        let mut across = Both { by_rows: other, by_columns: one, top, left: &mut for_names };
        let others = if beside == 0 { Vec::new() } else { some_null_vectors(&mut across, beside) };
        budget.spend((of_names - for_names) as usize / PRODUCTS);
        let (redundant, motions) = if of_rows { (listed, others) } else { (others, listed) };
        let mut dependent: Vec<u32> = redundant.iter().map(|(row, _)| *row).collect();
        dependent.sort_unstable();
        let mut free: Vec<u32> = motions.iter().map(|(column, _)| *column).collect();
        free.sort_unstable();
        return Some(Outcome {
            rank,
            size: [matrix.rows(), matrix.width()],
            dependent,
            free,
            gap: [zero / computed, nonzero / computed],
            singular_values: Some([nonzero / top.sqrt(), zero / top.sqrt()]),
            motions,
            made_of: if of_rows { redundant.iter().map(contributing).collect() } else { Vec::new() },
            ..Outcome::default()
        });
    }
    None
}

/// The rows that one is made of, by the weights of the null vector that stands for it.
fn contributing((row, weights): &Named) -> (u32, Vec<u32>) {
    let largest = weights.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let is_one = |(at, weight): &(usize, &f64)| *at != *row as usize && weight.abs() > CONTRIBUTES * largest;
    (*row, weights.iter().enumerate().filter(is_one).map(|(at, _)| at as u32).collect())
}

/// The shortest solution of M δ = right, or of the nearest right-hand side that has one, to some digits; `None` where that would take too long.
pub(super) fn least(matrix: &Sparse, right: &[f64], budget: &Budget) -> Option<Vec<f64>> {
    /// Steps for each column: more, and elimination is faster.
    const STEPS: u64 = 600;
    let by_rows = Compressed::of(matrix);
    let by_columns = by_rows.transposed(matrix.width());
    let top = by_rows.norm() * by_columns.norm();
    let steps = STEPS * (2 * matrix.values.len() + 4 * matrix.rows()) as u64;
    let most = steps.min(budget.left().saturating_mul(PRODUCTS as u64));
    let mut left = most;
    let mut both = Both { by_rows: &by_rows, by_columns: &by_columns, top, left: &mut left };
    let mut solution = Vec::new();
    let found = both.left_of(right, 1e-7, Some(&mut solution));
    budget.spend((most - left) as usize / PRODUCTS);
    found.map(|_| solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::sample::Draw;

    fn matrix(rows: &[Vec<f64>]) -> Sparse {
        let width = rows[0].len();
        let mut found = Sparse { offsets: vec![0], ..Sparse::default() };
        found.groups = (0..=width as u32).collect();
        for row in rows {
            for (column, value) in row.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                found.columns.push(column as u32);
                found.values.push(*value);
            }
            found.offsets.push(found.columns.len());
        }
        found
    }

    fn drawn_rows(rows: usize, width: usize, draw: &mut Draw) -> Vec<Vec<f64>> {
        (0..rows).map(|_| (0..width).map(|_| draw.between(-1.0, 1.0)).collect()).collect()
    }

    /// Of matrices of known rank, wide and tall, by the side with fewer null vectors; what is named is a null vector.
    #[test]
    fn ranks_of_random_matrices() {
        let mut draw = Draw::new("krylov");
        for (rows, width, dependent) in [(30, 50, 0), (30, 50, 3), (60, 40, 0), (60, 40, 5), (40, 40, 2)] {
            let mut all = drawn_rows(rows - dependent, width, &mut draw);
            for n in 0..dependent {
                let sum = (0..width).map(|k| all[n][k] - 2.0 * all[n + 3][k]).collect();
                all.push(sum);
            }
            let rank = (rows - dependent).min(width);
            let matrix = matrix(&all);
            let outcome = rank_of(&matrix).unwrap_or_else(|| panic!("{rows} {width} {dependent}"));
            assert_eq!((outcome.rank, outcome.is_decided()), (rank, true), "{rows} {width} {dependent}");
            assert_eq!(outcome.redundant(), rows - rank);
            for (column, motion) in &outcome.motions {
                let image = |row: &Vec<f64>| dot(row, motion).abs();
                let worst = all.iter().map(image).fold(0.0, f64::max);
                assert!(worst < 1e-6 && (motion[*column as usize] - 1.0).abs() < 1e-12, "{worst}");
            }
            if rows < width {
                // What is dependent is made of the three others of its sum, or of all of those.
                let made: Vec<usize> = outcome.made_of.iter().map(|(_, made)| made.len()).collect();
                assert_eq!(made, vec![2; dependent], "{:?}", outcome.made_of);
            }
        }
    }

    fn rank_of(matrix: &Sparse) -> Option<Outcome> {
        rank(matrix, 0.0, f64::INFINITY, &Budget::new(u64::MAX))
    }

    /// A singular value far below the digits of decks is not decided.
    #[test]
    fn what_is_nearly_singular_is_not_certain() {
        let mut draw = Draw::new("nearly");
        let mut all = drawn_rows(20, 30, &mut draw);
        let nearly: Vec<f64> = all[0].iter().zip(&all[1]).map(|(x, y)| x + y).collect();
        all.push(nearly.clone());
        assert_eq!(rank_of(&matrix(&all)).map(|found| found.rank), Some(20));
        for off in [1e-11, 1e-9] {
            let last = all.last_mut().unwrap();
            *last = nearly.clone();
            last[3] += off;
            let found = rank_of(&matrix(&all));
            assert!(found.is_none(), "{off}: {:?}", found.map(|found| (found.rank, found.gap)));
        }
    }

    /// The bound of the least eigenvalue is one, and no less than half of it.
    #[test]
    fn the_least_eigenvalue_is_bounded() {
        let chain = |n: usize| -> Vec<Vec<f64>> {
            (0..n)
                .map(|i| {
                    (0..=n).map(|k| f64::from(u8::from(k == i)) - f64::from(u8::from(k == i + 1))).collect()
                })
                .collect()
        };
        for n in [40, 120] {
            let chained = matrix(&chain(n));
            let by_rows = Compressed::of(&chained);
            let by_columns = by_rows.transposed(n + 1);
            let mut left = WORK;
            let top = by_rows.norm() * by_columns.norm();
            let mut both = Both { by_rows: &by_rows, by_columns: &by_columns, top, left: &mut left };
            let found = both.least_eigenvalue(&[]).unwrap();
            let exact = 4.0 * (std::f64::consts::PI / (2 * (n + 1)) as f64).sin().powi(2);
            assert!(found <= exact * (1.0 + 1e-9) && found >= 0.49 * exact, "{n}: {found} {exact}");
        }
    }
}
