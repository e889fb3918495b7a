//! Small systems of linear equations, on any number.

use crate::motion::plan::{Plan, Tape};
use crate::number::{Number, is_finite, larger, largest};
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// A square matrix with its right-hand sides. Bodies are joined to a few others, so most entries are zero: the others are listed.
#[derive(Clone, Debug)]
pub(crate) struct System<R> {
    /// Row, column, entry.
    entries: Vec<(usize, usize, R)>,
    /// In which order columns are eliminated.
    order: Vec<usize>,
    /// What elimination does, where that is known.
    tape: Option<Arc<Tape>>,
    right: Vec<Vec<R>>,
}

/// Newton's matrix of static equilibria. It is formed at the beginning of a step and serves all within it, as long as it is near enough.
#[derive(Clone, Debug)]
pub(crate) struct Newton<R> {
    /// The degrees of freedom that it is of.
    pub(crate) columns: Vec<usize>,
    pub(crate) matrix: System<R>,
    /// The sign of the determinant at the beginning of the iterations.
    pub(crate) sign: f64,
}

/// A pivot that rounding explains: its column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NoPivot {
    pub(crate) column: usize,
}

/// Pivots below this part of the largest entry of their scaled matrix count as zero, in rounding units.
const PIVOT: f64 = 1e5;

/// Of the pivots that are at least this part of the largest one, that of the shortest row is taken.
const SHORTEST: f64 = 0.1;

/// The same where elimination is planned: its pivots serve until they are [`SHORTEST`].
const PLANNED: f64 = 0.5;

/// A matrix, eliminated.
struct Eliminated<R> {
    /// By which each row was multiplied.
    factors: Vec<R>,
    /// What was taken from a row: of which pivot, how much.
    taken: Vec<(usize, usize, R)>,
    /// The row of each pivot, in their order, and what was left of it.
    pivots: Vec<(usize, Range<usize>)>,
    /// Entries by column.
    left: Vec<(usize, R)>,
}

impl<R: Number> System<R> {
    /// Zero, of `size` unknowns and `sides` right-hand sides.
    pub(crate) fn new(size: usize, sides: usize) -> Self {
        Self {
            entries: Vec::with_capacity(8 * size),
            order: (0..size).collect(),
            tape: None,
            right: vec![vec![R::ZERO; size]; sides],
        }
    }

    /// Eliminated in this order of columns.
    pub(crate) fn ordered(mut self, order: &[usize]) -> Self {
        if order.len() == self.order.len() {
            self.order.copy_from_slice(order);
        }
        self
    }

    /// Eliminated as planned, as long as the pivots are large enough.
    pub(crate) fn planned(mut self, plan: &Plan) -> Self {
        self.tape = plan.tape().filter(|tape| tape.size() == self.order.len());
        self
    }

    /// The plan for matrices with entries where this one and those of `before` have them, and in some places besides. `None` where `before` is
    /// good for this one, or where there is no elimination.
    pub(crate) fn plan(&self, before: &Plan, is_reordered: bool, besides: &[(usize, usize)]) -> Option<Plan> {
        // What is in one place may come to be in the place across.
        let entries = || self.entries.iter().flat_map(|(row, column, _)| [(*row, *column), (*column, *row)]);
        let is_good =
            || before.takes(entries()) && before.tape().is_some_and(|tape| self.along(&tape).is_some());
        if !is_reordered && is_good() {
            return None;
        }
        let found = self.eliminated(&self.order, PLANNED).ok()?;
        let rows = found.pivots.iter().map(|(row, _)| *row);
        let pivots: Vec<(usize, usize)> = self.order.iter().copied().zip(rows).collect();
        Some(before.with(entries().chain(besides.iter().copied()), &pivots))
    }

    /// Adds to an entry; columns from `size` on are right-hand sides.
    pub(crate) fn add(&mut self, row: usize, column: usize, amount: R) {
        match column.checked_sub(self.order.len()) {
            None if amount.is_nothing() => {}
            None => self.entries.push((row, column, amount)),
            Some(side) => {
                if let Some(entry) = self.right.get_mut(side).and_then(|side| side.get_mut(row)) {
                    *entry = *entry + amount;
                }
            }
        }
    }

    /// An order of columns in which few entries become other than zero: next comes what adds least, as its column and row are now
    /// (Markowitz).
    pub(crate) fn sparse_order(&self) -> Vec<usize> {
        let n = self.order.len();
        let mut rows = vec![BTreeSet::new(); n];
        let mut columns = vec![BTreeSet::new(); n];
        for (row, column, _) in &self.entries {
            rows[*row].insert(*column);
            columns[*column].insert(*row);
        }
        let mut left: BTreeSet<usize> = (0..n).collect();
        let mut order = Vec::with_capacity(n);
        while let Some((_, column, row)) = left
            .iter()
            .map(|column| {
                let of = &columns[*column];
                let shortest = of.iter().map(|row| (rows[*row].len(), *row)).min();
                let adds = shortest.map_or(0, |(length, _)| (length - 1) * (of.len() - 1));
                (adds, *column, shortest.map(|(_, row)| row))
            })
            .min()
        {
            left.remove(&column);
            order.push(column);
            let Some(row) = row else { continue };
            let pivot = std::mem::take(&mut rows[row]);
            for of in &pivot {
                columns[*of].remove(&row);
            }
            for other in std::mem::take(&mut columns[column]) {
                rows[other].extend(&pivot);
                rows[other].remove(&column);
                pivot.iter().filter(|of| **of != column).for_each(|of| _ = columns[*of].insert(other));
            }
        }
        order
    }

    /// The solutions, one for each right-hand side.
    ///
    /// Masses and inertias beside rows of size 1 may be so small, in some units, that they look like rounding. Where no pivot is found unknowns
    /// and equations are taken in units in which none is.
    pub(crate) fn solve(self) -> Result<Vec<Vec<R>>, NoPivot> {
        self.solved().or_else(|error| {
            let (balanced, units) = self.balanced();
            let mut found = balanced.solved().map_err(|_| error)?;
            for side in &mut found {
                side.iter_mut().zip(&units).for_each(|(x, unit)| *x = *x * *unit);
            }
            Ok(found)
        })
    }

    /// The same in other units, powers of two, and the unit of each unknown: those in which the squares of the logarithms of the entries are
    /// least (Curtis and Reid).
    fn balanced(&self) -> (Self, Vec<R>) {
        const TIMES: usize = 20;
        // Beyond this no change is one of units.
        const MOST: f64 = 500.0;
        let n = self.order.len();
        let [mut of_rows, mut of_columns] = [vec![0.0; n], vec![0.0; n]];
        let mut sizes: Vec<(usize, usize, f64)> = self
            .entries
            .iter()
            .map(|(row, column, entry)| (*row, *column, entry.to_f64().abs().log2()))
            .filter(|(.., size)| size.is_finite())
            .collect();
        // What rounding leaves beside others of its row and its column says nothing of units. Masses stand on the diagonal.
        let (mut rows, mut columns) = (vec![f64::NEG_INFINITY; n], vec![f64::NEG_INFINITY; n]);
        for (row, column, size) in sizes.iter().filter(|(row, column, _)| row != column) {
            rows[*row] = rows[*row].max(*size);
            columns[*column] = columns[*column].max(*size);
        }
        sizes.retain(|(row, column, size)| {
            row == column || *size > rows[*row].min(columns[*column]) + R::ROUNDING.log2() / 1.5
        });
        let means = |of: &mut [f64], entries: &mut dyn Iterator<Item = (usize, f64)>| {
            let mut sums = vec![(0.0, 0.0); of.len()];
            entries.for_each(|(place, size)| {
                sums[place].0 += size;
                sums[place].1 += 1.0;
            });
            let some = of.iter_mut().zip(sums).filter(|(_, (_, count))| *count > 0.0);
            some.for_each(|(of, (sum, count))| *of = (-sum / count).clamp(-MOST, MOST));
        };
        for _ in 0..TIMES {
            let mut entries = sizes.iter().map(|(row, column, size)| (*row, size + of_columns[*column]));
            means(&mut of_rows, &mut entries);
            let mut entries = sizes.iter().map(|(row, column, size)| (*column, size + of_rows[*row]));
            means(&mut of_columns, &mut entries);
        }
        let powers = |of: Vec<f64>| -> Vec<R> {
            of.into_iter().map(|power| R::from_f64(power.round().exp2())).collect()
        };
        let [of_rows, of_columns] = [of_rows, of_columns].map(powers);
        let scaled = |(row, column, entry): &(usize, usize, R)| {
            (*row, *column, *entry * of_rows[*row] * of_columns[*column])
        };
        let entries = self.entries.iter().map(scaled).collect();
        let side =
            |side: &Vec<R>| side.iter().zip(&of_rows).map(|(x, factor)| *x * *factor).collect::<Vec<R>>();
        let right = self.right.iter().map(side).collect();
        (Self { entries, order: self.order.clone(), tape: None, right }, of_columns)
    }

    /// The solutions, each improved once by what it leaves.
    fn solved(&self) -> Result<Vec<Vec<R>>, NoPivot> {
        if self.order.len() == 1 {
            let entry = self.entries.iter().fold(R::ZERO, |sum, (.., entry)| sum + *entry);
            let is_some = R::ZERO.less(entry.magnitude()) && is_finite(entry);
            let of = |side: &Vec<R>| side.iter().map(|x| *x / entry).collect();
            return if is_some {
                Ok(self.right.iter().map(of).collect())
            } else {
                Err(NoPivot { column: 0 })
            };
        }
        let natural: Vec<usize> = (0..self.order.len()).collect();
        // The pivot that there is not is named as in the natural order.
        let eliminated = match self.tape.as_ref().and_then(|tape| self.along(tape)) {
            Some(eliminated) => eliminated,
            None => {
                let found = self.eliminated(&self.order, SHORTEST);
                found.or_else(|_| self.eliminated(&natural, SHORTEST))?
            }
        };
        let solved = self.right.iter().map(|right| {
            let mut x = eliminated.solve(right);
            let mut left = right.clone();
            self.entries
                .iter()
                .for_each(|(row, column, entry)| left[*row] = left[*row] - *entry * x[*column]);
            x.iter_mut().zip(eliminated.solve(&left)).for_each(|(x, by)| *x = *x + by);
            x
        });
        Ok(solved.collect())
    }

    /// Elimination with the pivots of before, as long as they are as large as [`System::eliminated`] wants them. Where entries below them are a
    /// hundred times larger, and each solution is improved once, a swing of ten turns still lost three digits.
    fn along(&self, tape: &Tape) -> Option<Eliminated<R>> {
        let n = self.order.len();
        let mut left: Vec<(usize, R)> = tape.columns.iter().map(|column| (*column, R::ZERO)).collect();
        for (row, column, entry) in &self.entries {
            let slot = &mut left[tape.slot(*row, *column)?].1;
            *slot = *slot + *entry;
        }
        let mut sizes = vec![R::ZERO; n];
        let mut factors = Vec::with_capacity(n);
        for row in 0..n {
            let entries = &mut left[tape.row(row)];
            let most = entries.iter().fold(R::ZERO, |most, (_, x)| larger(most, x.magnitude()));
            let factor = most.reciprocal_or_zero();
            for (column, x) in entries {
                *x = *x * factor;
                sizes[*column] = larger(sizes[*column], x.magnitude());
            }
            factors.push(factor);
        }
        let least = R::from_f64(PIVOT * R::ROUNDING);
        let most = R::from_f64(1.0 / SHORTEST);
        let mut taken = Vec::with_capacity(tape.lines.len());
        let mut pivots = Vec::with_capacity(n);
        for step in &tape.steps {
            let (column, pivot) = left[step.slots.start];
            if !(least * sizes[column]).less(pivot.magnitude()) {
                return None;
            }
            let inverse = R::integer(1) / pivot;
            for line in &tape.lines[step.lines.clone()] {
                let factor = left[line.slot].1 * inverse;
                if factor.is_nothing() {
                    continue;
                }
                if most.less(factor.magnitude()) {
                    return None;
                }
                taken.push((line.row, step.row, factor));
                let others = step.slots.start + 1..step.slots.end;
                for (to, of) in tape.targets[line.targets.clone()].iter().zip(others) {
                    left[*to].1 = left[*to].1 - factor * left[of].1;
                }
            }
            pivots.push((step.row, step.slots.clone()));
        }
        Some(Eliminated { factors, taken, pivots, left })
    }

    /// Elimination with pivots that are large in rows divided by their largest entry.
    fn eliminated(&self, order: &[usize], shortest: f64) -> Result<Eliminated<R>, NoPivot> {
        const NONE: usize = usize::MAX;
        let n = order.len();
        let mut place = vec![0; n];
        order.iter().enumerate().for_each(|(k, column)| place[*column] = k);
        // Rows one after the other, each by the places of its columns.
        let mut ends = vec![0; n + 1];
        self.entries.iter().for_each(|(row, ..)| ends[*row + 1] += 1);
        (0..n).for_each(|row| ends[row + 1] += ends[row]);
        let mut next = ends.clone();
        let mut left = Vec::with_capacity(2 * self.entries.len());
        left.resize(self.entries.len(), (0, R::ZERO));
        for (row, column, entry) in &self.entries {
            let mut at = next[*row];
            next[*row] += 1;
            while at > ends[*row] && left[at - 1].0 > place[*column] {
                left[at] = left[at - 1];
                at -= 1;
            }
            left[at] = (place[*column], *entry);
        }
        // What is left of rows, in lists by where they begin.
        let mut begins = vec![NONE; n];
        let mut follows = vec![NONE; n];
        let mut rows: Vec<Range<usize>> = Vec::with_capacity(n);
        let mut factors = Vec::with_capacity(n);
        // The largest entry of each column: masses may have any unit.
        let mut sizes = vec![R::ZERO; n];
        for row in 0..n {
            let mut end = ends[row];
            for at in ends[row]..ends[row + 1] {
                if end > ends[row] && left[end - 1].0 == left[at].0 {
                    left[end - 1].1 = left[end - 1].1 + left[at].1;
                } else {
                    left[end] = left[at];
                    end += 1;
                }
            }
            let entries = &mut left[ends[row]..end];
            let most = entries.iter().fold(R::ZERO, |most, (_, x)| larger(most, x.magnitude()));
            let factor = most.reciprocal_or_zero();
            entries.iter_mut().for_each(|(_, x)| *x = *x * factor);
            if let Some((k, _)) = entries.first() {
                follows[row] = std::mem::replace(&mut begins[*k], row);
            }
            for (k, x) in &left[ends[row]..end] {
                sizes[*k] = larger(sizes[*k], x.magnitude());
            }
            factors.push(factor);
            rows.push(ends[row]..end);
        }
        // Long rows, as that of a node which carries many, stand whole: what a short pivot takes of one costs the pivot's length.
        let mut whole: Vec<Option<Whole<R>>> = Vec::new();
        whole.resize_with(n, || None);
        for row in (0..n).filter(|row| rows[*row].len() > LONG) {
            whole[row] = Some(Whole::new(&left[rows[row].clone()], n));
        }
        let least = R::from_f64(PIVOT * R::ROUNDING);
        let mut taken = Vec::with_capacity(2 * n);
        let mut pivots = Vec::with_capacity(n);
        let (mut candidates, mut less) = (Vec::new(), Vec::new());
        for k in 0..n {
            candidates.clear();
            let mut row = begins[k];
            while row != NONE {
                candidates.push(row);
                row = follows[row];
            }
            let leading = |row: usize| match &whole[row] {
                Some(whole) => whole.entries[k],
                None => left[rows[row].start].1,
            };
            let size = |row: usize| leading(row).magnitude();
            let most = candidates.iter().fold(R::ZERO, |most, row| larger(most, size(*row)));
            let enough = most * R::from_f64(shortest);
            let large = candidates.iter().filter(|row| !size(**row).less(enough));
            let length = |row: usize| whole[row].as_ref().map_or(rows[row].len(), |whole| whole.length);
            let best =
                large.min_by_key(|row| (length(**row), **row)).filter(|_| (least * sizes[k]).less(most));
            let Some(best) = best.copied() else { return Err(NoPivot { column: order[k] }) };
            let factors_of: Vec<(usize, R)> = {
                let inverse = R::integer(1) / leading(best);
                let others = candidates.iter().copied().filter(|row| *row != best);
                others.map(|row| (row, leading(row) * inverse)).collect()
            };
            if let Some(of) = whole[best].take() {
                let start = left.len();
                left.extend(
                    (k..n).map(|at| (at, of.entries[at])).filter(|(at, x)| *at == k || !x.is_nothing()),
                );
                rows[best] = start..left.len();
            }
            let pivot = rows[best].clone();
            for (row, factor) in factors_of {
                taken.push((row, best, factor));
                if let Some(of) = &mut whole[row] {
                    let next = of.subtract(k, &left[pivot.start + 1..pivot.end], factor);
                    if let Some(next) = next {
                        follows[row] = std::mem::replace(&mut begins[next], row);
                    }
                    continue;
                }
                subtract(
                    &left[rows[row].start + 1..rows[row].end],
                    &left[pivot.start + 1..pivot.end],
                    factor,
                    &mut less,
                );
                // What has become no longer stays where it was.
                let mut start = rows[row].start;
                if less.len() <= rows[row].len() {
                    left[start..start + less.len()].copy_from_slice(&less);
                } else {
                    start = left.len();
                    left.extend_from_slice(&less);
                }
                rows[row] = start..start + less.len();
                if let Some((k, _)) = less.first() {
                    follows[row] = std::mem::replace(&mut begins[*k], row);
                }
                if less.len() > LONG {
                    whole[row] = Some(Whole::new(&less, n));
                }
            }
            pivots.push((best, pivot));
        }
        // Columns themselves, from here on.
        left.iter_mut().for_each(|(k, _)| *k = order[*k]);
        Ok(Eliminated { factors, taken, pivots, left })
    }
}

impl<R: Number> Eliminated<R> {
    fn solve(&self, right: &[R]) -> Vec<R> {
        let mut right: Vec<R> = right.iter().zip(&self.factors).map(|(x, factor)| *x * *factor).collect();
        for (row, pivot, factor) in &self.taken {
            right[*row] = right[*row] - *factor * right[*pivot];
        }
        let mut x = vec![R::ZERO; right.len()];
        for (of, pivot) in self.pivots.iter().rev() {
            let Some(((column, divisor), others)) = self.left[pivot.clone()].split_first() else { continue };
            let sum = others.iter().fold(right[*of], |sum, (column, entry)| sum - *entry * x[*column]);
            x[*column] = sum / *divisor;
        }
        x
    }
}

/// A few equations of as many unknowns, most of whose entries are there: [`System`] would spend more on its lists than on them.
#[derive(Clone, Debug)]
pub(crate) struct Dense<R> {
    /// By rows.
    entries: Vec<R>,
    pub(crate) right: Vec<R>,
}

impl<R: Number> Dense<R> {
    /// Zero.
    pub(crate) fn new(size: usize) -> Self {
        Self { entries: vec![R::ZERO; size * size], right: vec![R::ZERO; size] }
    }

    /// Adds to an entry.
    pub(crate) fn add(&mut self, row: usize, column: usize, amount: R) {
        let entry = &mut self.entries[row * self.right.len() + column];
        *entry = *entry + amount;
    }

    /// The solution. Where no pivot is found, that of [`System::solve`], which tries other units.
    pub(crate) fn solve(self) -> Result<Vec<R>, NoPivot> {
        self.eliminated().or_else(|_| {
            let n = self.right.len();
            let mut system = System::new(n, 1);
            self.entries.iter().enumerate().for_each(|(at, x)| system.add(at / n, at % n, *x));
            self.right.iter().enumerate().for_each(|(row, x)| system.add(row, n, *x));
            Ok(system.solve()?.swap_remove(0))
        })
    }

    /// The same with pivots that are large in rows divided by their largest entry.
    fn eliminated(&self) -> Result<Vec<R>, NoPivot> {
        let Self { mut entries, mut right } = self.clone();
        let n = right.len();
        let least = R::from_f64(PIVOT * R::ROUNDING);
        let mut sizes = vec![R::ZERO; n];
        for (row, x) in entries.chunks_exact_mut(n.max(1)).zip(&mut right) {
            let factor = largest(row.iter().copied()).reciprocal_or_zero();
            *x = *x * factor;
            for (entry, size) in row.iter_mut().zip(&mut sizes) {
                *entry = *entry * factor;
                *size = larger(*size, entry.magnitude());
            }
        }
        for k in 0..n {
            let size = |row: usize| entries[row * n + k].magnitude();
            let best = (k + 1..n).fold(k, |best, row| if size(best).less(size(row)) { row } else { best });
            if !(least * sizes[k]).less(size(best)) {
                return Err(NoPivot { column: k });
            }
            right.swap(k, best);
            (0..n).for_each(|j| entries.swap(k * n + j, best * n + j));
            for row in k + 1..n {
                let factor = entries[row * n + k] / entries[k * n + k];
                for j in k + 1..n {
                    entries[row * n + j] = entries[row * n + j] - factor * entries[k * n + j];
                }
                right[row] = right[row] - factor * right[k];
            }
        }
        for k in (0..n).rev() {
            let sum = (k + 1..n).fold(right[k], |sum, j| sum - entries[k * n + j] * right[j]);
            right[k] = sum / entries[k * n + k];
        }
        Ok(right)
    }
}

/// Rows of more entries than this stand whole.
const LONG: usize = 64;

/// A row with a place for each column.
struct Whole<R> {
    entries: Vec<R>,
    /// How many may be other than zero.
    length: usize,
}

impl<R: Number> Whole<R> {
    fn new(row: &[(usize, R)], n: usize) -> Self {
        let mut entries = vec![R::ZERO; n];
        row.iter().for_each(|(k, x)| entries[*k] = *x);
        Self { entries, length: row.len() }
    }

    /// Takes a multiple of a pivot of column k, and gives the column where it begins then.
    fn subtract(&mut self, k: usize, pivot: &[(usize, R)], factor: R) -> Option<usize> {
        self.entries[k] = R::ZERO;
        self.length = self.length.saturating_sub(1);
        for (column, x) in pivot {
            let entry = &mut self.entries[*column];
            self.length += usize::from(entry.is_nothing());
            *entry = *entry - factor * *x;
        }
        (k + 1..self.entries.len()).find(|at| !self.entries[*at].is_nothing())
    }
}

/// row − factor·pivot.
fn subtract<R: Number>(row: &[(usize, R)], pivot: &[(usize, R)], factor: R, into: &mut Vec<(usize, R)>) {
    into.clear();
    let (mut row, mut pivot) = (row, pivot);
    while let ([(of, x), rows @ ..], [(column, y), pivots @ ..]) = (row, pivot) {
        into.push(match of.cmp(column) {
            Ordering::Less => (*of, *x),
            Ordering::Equal => (*of, *x - factor * *y),
            Ordering::Greater => (*column, -(factor * *y)),
        });
        row = if of <= column { rows } else { row };
        pivot = if column <= of { pivots } else { pivot };
    }
    into.extend_from_slice(row);
    into.extend(pivot.iter().map(|(column, y)| (*column, -(factor * *y))));
}

#[cfg(test)]
mod tests {
    use super::{Dense, System};
    use crate::motion::plan::Plan;
    use pintle_kinematics::scalar::{Scalar, Wide};

    #[test]
    fn hilbert_is_inverted() {
        // Σ_j H_ij = b_i has the solution 1, whose condition takes 17 of 71 digits.
        let n = 12;
        let mut matrix: System<Wide> = System::new(n, 1);
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
    fn a_few_equations_have_the_solution_of_many() {
        let n = 5;
        let mut compared = 0;
        for tiny in [1.0, 1e-3, 0.0] {
            let (mut dense, mut sparse) = (Dense::new(n), System::new(n, 1));
            for i in 0..n {
                for j in 0..n {
                    let entry =
                        if i == j { tiny } else { ((3 * i + 5 * j) % 7) as f64 * 10.0_f64.powi(i as i32) };
                    dense.add(i, j, entry);
                    sparse.add(i, j, entry);
                }
                dense.right[i] = 1.0 + i as f64;
                sparse.add(i, n, 1.0 + i as f64);
            }
            for (x, y) in dense.solve().unwrap().iter().zip(&sparse.solve().unwrap()[0]) {
                assert!((x - y).abs() < 1e-12 * (1.0 + y.abs()), "{x}, not {y}");
                compared += 1;
            }
        }
        assert_eq!(compared, 3 * n);
        let mut singular: Dense<f64> = Dense::new(2);
        (0..4).for_each(|k| singular.add(k / 2, k % 2, 1.0));
        assert_eq!(singular.solve().unwrap_err().column, 1);
    }

    #[test]
    fn a_singular_matrix_has_no_pivot() {
        let mut matrix: System<f64> = System::new(3, 1);
        for i in 0..3 {
            for j in 0..3 {
                matrix.add(i, j, (i * 3 + j) as f64);
            }
        }
        assert_eq!(matrix.clone().ordered(&[2, 0, 1]).solve().unwrap_err().column, 2);
        assert_eq!(matrix.solve().unwrap_err().column, 2);
    }

    /// Masses of 1e-12 and inertias of 1e-27 beside rows of size 1: what they solve is exact, and what is singular stays so.
    #[test]
    fn small_units_are_no_rounding() {
        // Two unknowns with masses, the first of them held by a row with a lever on a third.
        let masses = [1.3e-12, 2e-12, 1e-27];
        let row = [1.0, 0.0, 3e-8];
        let want = [3e-6, -7.0, -100.0, 2.5e-13];
        let matrix = |held: bool| {
            let mut matrix: System<f64> = System::new(4, 1);
            for i in 0..3 {
                if held || i != 1 {
                    matrix.add(i, i, masses[i]);
                    matrix.add(i, 4, masses[i] * want[i]);
                }
                matrix.add(i, 3, row[i]);
                matrix.add(i, 4, row[i] * want[3]);
                matrix.add(3, i, row[i]);
                matrix.add(3, 4, row[i] * want[i]);
            }
            matrix
        };
        assert!(matrix(true).solved().is_err());
        let found = matrix(true).solve().unwrap();
        for (x, want) in found[0].iter().zip(want) {
            assert!((x / want - 1.0).abs() < 1e-9, "{x} {want}");
        }
        assert_eq!(matrix(false).solve().unwrap_err().column, 1);
    }

    /// Unknowns in chains, as bodies are joined, and one that all are joined to: rows of several words, which fill in.
    #[test]
    fn what_fills_in_is_eliminated() {
        let n = 150;
        let x = |j: usize| 1.0 + (j * j % 17) as f64;
        let mut matrix: System<f64> = System::new(n, 2);
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
        let order = matrix.sparse_order();
        assert!(!order.is_sorted());
        let mut compared = 0;
        for matrix in [matrix.clone(), matrix.ordered(&order)] {
            let found = matrix.solve().unwrap();
            for (j, (one, other)) in found[0].iter().zip(&found[1]).enumerate() {
                assert!((one - x(j)).abs() < 1e-11 * x(j), "{j}: {one}, not {}", x(j));
                assert!((other + x(n - 1 - j)).abs() < 1e-11 * x(j), "{j}: {other}");
                compared += 2;
            }
        }
        assert_eq!(compared, 4 * n);
    }

    /// A plan gives the bits of the elimination that it was made of. Where pivots are too small, or entries have no place, it is left.
    #[test]
    fn a_plan_repeats_an_elimination() {
        let n = 40;
        let with = |tiny: f64, other: bool| {
            let mut matrix: System<f64> = System::new(n, 1);
            for i in 0..n {
                matrix.add(i, (i + 1) % n, 5.0 + (i % 3) as f64);
                matrix.add(i, i, if i == 7 { tiny } else { 1.0 + i as f64 / 8.0 });
                matrix.add(i, (i + n - 7) % n, 0.5);
                matrix.add(i, n, 1.0 / (1.0 + i as f64));
            }
            if other {
                matrix.add(3, 20, 0.25);
            }
            matrix
        };
        let first = with(1.0, false);
        let order = first.sparse_order();
        let first = first.ordered(&order);
        let plan = first.plan(&Plan::default(), true, &[]).unwrap();
        assert!(first.along(&plan.tape().unwrap()).is_some() && first.plan(&plan, false, &[]).is_none());
        let [planned, along] =
            [first.eliminated(&order, super::PLANNED).unwrap(), first.along(&plan.tape().unwrap()).unwrap()]
                .map(|of| of.solve(&first.right[0]));
        assert_eq!(planned, along);
        let mut compared = 0;
        for other in [false, true] {
            for power in 0..20 {
                let matrix = with(0.1_f64.powi(power), other).ordered(&order);
                let [found, known] = [matrix.clone().planned(&plan), matrix].map(|of| of.solve().unwrap());
                for (x, y) in found[0].iter().zip(&known[0]) {
                    assert!((x - y).abs() < 1e-12, "{power} {other}: {x}, not {y}");
                    compared += 1;
                }
            }
        }
        assert_eq!(compared, 40 * n);
        let nothing = Plan::default().with(std::iter::empty(), &[(9, 0)]);
        assert!(nothing.tape().is_none(), "a column that is not there");
    }

    #[test]
    fn no_number_is_no_pivot() {
        let mut matrix: System<f64> = System::new(70, 1);
        (0..70).for_each(|i| matrix.add(i, i, if i == 66 { f64::NAN } else { 1.0 }));
        assert_eq!(matrix.solve().unwrap_err().column, 66);
    }
}
