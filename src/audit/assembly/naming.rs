//! Which rows depend on the others?
//!
//! Elimination finds how many rows depend on others. Where it brings rows to echelon form before their turn, multiples are taken of rows that may be found
//! to depend on others later: then those that it names need not be ones without which the rank is the same ([`Outcome::misnames`]), and others are
//! found that are. Of small matrices they are those that depend on rows before them.

use super::dense;
use super::eliminate::{Outcome, Sparse, Task, eliminate};

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
    /// Exchanges of rows that were named for others.
    const TIMES: usize = 4;
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
    if !outcome.misnames {
        return;
    }
    let task = Task { right: None, keep: false, ..task };
    let look = |rows: &[u32]| {
        let mut some = eliminate(&of_rows(matrix, rows), order, task);
        some.dependent.iter_mut().for_each(|row| *row = rows[*row as usize]);
        some
    };
    for _ in 0..TIMES {
        let rest = look(&others(matrix, &outcome.dependent));
        if rest.rank == outcome.rank {
            return;
        }
        // These do depend on others, so that some that were named do not.
        let mut dependent = rest.dependent;
        dependent.extend(look(&others(matrix, &dependent)).dependent);
        dependent.sort_unstable();
        dependent.dedup();
        if dependent.len() != outcome.dependent.len() {
            break;
        }
        outcome.dependent = dependent;
    }
    outcome.dependent.clear();
}
