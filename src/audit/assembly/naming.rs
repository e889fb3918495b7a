//! Which rows depend on the others?
//!
//! Elimination finds how many rows depend on others. Where it brings rows to echelon form before their turn, multiples are taken of rows that may be found
//! to depend on others later: then those that it names need not be ones without which the rank is the same ([`Outcome::misnames`]), and others are
//! found that are. Of small matrices they are those that depend on rows before them.

use super::eliminate::{Outcome, Sparse, Task, eliminate};
use super::{dense, largest};
use crate::audit::sample::Draw;
use nalgebra::{DMatrix, DVector};

/// The matrix of some rows.
fn of_rows(matrix: &Sparse, rows: &[u32]) -> Sparse {
    let mut some = Sparse { groups: matrix.groups.clone(), offsets: vec![0], ..Sparse::default() };
    for row in rows {
        let range = matrix.range(*row as usize);
        some.columns.extend_from_slice(&matrix.columns[range.clone()]);
        some.values.extend_from_slice(&matrix.values[range]);
        some.offsets.push(some.columns.len());
        some.rough.extend(matrix.rough.get(*row as usize));
        some.open.extend(matrix.open.get(*row as usize));
    }
    some
}

/// All rows but these, which are ascending.
fn others(matrix: &Sparse, rows: &[u32]) -> Vec<u32> {
    (0..matrix.rows() as u32).filter(|row| rows.binary_search(row).is_err()).collect()
}

/// What elimination finds, with rows named without which the rank is the same; where none such are found, with none named.
pub(super) fn named(matrix: &Sparse, order: &[u32], task: Task<'_>) -> Outcome {
    let mut outcome = eliminate(matrix, order, task);
    name(matrix, order, task, &mut outcome);
    outcome
}

/// Names the rows of an outcome anew, if need be.
fn name(matrix: &Sparse, order: &[u32], task: Task<'_>, outcome: &mut Outcome) {
    if outcome.dependent.is_empty() || !outcome.is_decided() {
        return;
    }
    if dense::is_small(matrix, dense::LARGEST) {
        let dependent = dense::dependent(matrix);
        if dependent.len() == outcome.dependent.len() {
            outcome.dependent = dependent;
            return;
        }
    }
    if outcome.misnames {
        exchange(matrix, order, task, outcome);
    }
}

/// Names other rows, so that the rank without them is the same; or none. Of the rows that are not named those are left out that depend on others, until
/// none does, and rows are taken back that null vectors of these are not null vectors of.
pub(super) fn exchange(matrix: &Sparse, order: &[u32], task: Task<'_>, outcome: &mut Outcome) {
    const TIMES: usize = 8;
    let mut inside = others(matrix, &outcome.dependent);
    outcome.dependent.clear();
    for time in 0..TIMES {
        let task = Task { right: None, keep: time > 0, plain: true, ..task };
        let some = eliminate(&of_rows(matrix, &inside), order, task);
        if some.exhausted {
            return;
        }
        if some.rank < inside.len() {
            let mut at = 0..;
            inside.retain(|_| at.next().is_some_and(|at| some.dependent.binary_search(&at).is_err()));
        } else if inside.len() == outcome.rank {
            outcome.dependent = others(matrix, &inside);
            return;
        } else if some.has_pivots() {
            let missing = outcome.rank.saturating_sub(inside.len());
            inside.extend(taken_back(matrix, &some, &others(matrix, &inside), missing));
            inside.sort_unstable();
        }
    }
}

/// Of these rows so many that are independent of others, of which the null vectors are known, and of each other.
fn taken_back(matrix: &Sparse, known: &Outcome, rows: &[u32], missing: usize) -> Vec<u32> {
    /// Null vectors beyond what is missing.
    const MORE: usize = 4;
    /// What is left of a row that is independent, of the largest.
    const ZERO: f64 = 1e-6;
    const MOST: usize = 300;
    if missing == 0 || missing > MOST {
        return Vec::new();
    }
    let mut draw = Draw::new("null vectors");
    let mut products = DMatrix::zeros(missing + MORE, rows.len());
    for k in 0..missing + MORE {
        let random: Vec<f64> = (0..matrix.width()).map(|_| draw.between(-1.0, 1.0)).collect();
        let vector = known.solve(matrix.width(), |column| random[column as usize], true);
        let size = largest(&vector).max(f64::MIN_POSITIVE);
        for (at, row) in rows.iter().enumerate() {
            let entries = matrix.range(*row as usize);
            let product: f64 =
                entries.map(|place| matrix.values[place] * vector[matrix.columns[place] as usize]).sum();
            products[(k, at)] = product / size;
        }
    }
    let (mut taken, mut first) = (Vec::new(), 0.0);
    for _ in 0..missing {
        let best = (0..rows.len())
            .max_by(|i, j| products.column(*i).norm_squared().total_cmp(&products.column(*j).norm_squared()));
        let Some(best) = best else { break };
        let direction: DVector<f64> = products.column(best).into_owned();
        let size = dense::size(&direction);
        first = if first == 0.0 { size } else { first };
        if size <= ZERO * first || size == 0.0 {
            break;
        }
        let direction = direction / size;
        for mut column in products.column_iter_mut() {
            let along = direction.dot(&column);
            column.axpy(-along, &direction, 1.0);
        }
        taken.push(rows[best]);
    }
    taken
}
