//! Which rows depend on the others?
//!
//! Elimination finds how many rows depend on others. Where it brings rows to echelon form before their turn, multiples are taken of rows that may be found
//! to depend on others later: then those that it names need not be ones without which the rank is the same ([`Outcome::misnames`]). So those are named
//! that depend on rows before them, those that make bodies ([`mod@super::contract`]) being before all others: of small matrices by what of each is
//! orthogonal to these, of others by [`mod@super::echelon`].

use super::contract::Contracted;
use super::eliminate::{Outcome, Sparse, Task};
use super::order::Orders;
use super::system::Part;
use super::{dense, echelon};

/// What elimination finds, with rows named without which the rank is the same; where none such are found, with none named.
pub(super) fn named(matrix: &Sparse, part: &Part, task: Task<'_>) -> Outcome {
    let contracted = Contracted::of(matrix, task.uncertainty);
    named_of(matrix, &contracted, &part.orders(&contracted), task)
}

/// The same of what is put together to bodies already.
pub(super) fn named_of(matrix: &Sparse, contracted: &Contracted, orders: &Orders, task: Task<'_>) -> Outcome {
    let mut outcome = contracted.eliminate(matrix, &orders.best, task);
    if outcome.dependent.is_empty() || !outcome.is_decided() {
        return outcome;
    }
    match last(matrix, contracted, orders, &outcome) {
        Some(dependent) => outcome.dependent = dependent,
        None if outcome.misnames => outcome.dependent.clear(),
        None => {}
    }
    outcome
}

/// The rows that depend on those before them, where they are as many as the rank says.
pub(super) fn last(
    matrix: &Sparse,
    contracted: &Contracted,
    orders: &Orders,
    outcome: &Outcome,
) -> Option<Vec<u32>> {
    let count = outcome.redundant();
    let by_size = if dense::is_small(matrix, dense::LARGEST) {
        Some(dense::dependent(matrix, &contracted.in_order())).filter(|dependent| dependent.len() == count)
    } else {
        None
    };
    let by_rows = || {
        let of_rest = count.checked_sub(contracted.dependent.len())?;
        // Columns that are free are made of the others, and so tell nothing of rows; what rounding leaves of them might.
        let free: Vec<u32> =
            outcome.free.iter().filter_map(|column| Some(contracted.given((*column, 0.0))?.0)).collect();
        let free = if outcome.free.len() == outcome.mobility() { free } else { Vec::new() };
        let found = echelon::dependent(&contracted.rest, &orders.by_degree, &free, of_rest, echelon::MOST)?;
        let mut all: Vec<u32> = found.into_iter().map(|row| contracted.names[row as usize]).collect();
        all.extend(&contracted.dependent);
        all.sort_unstable();
        Some(all)
    };
    by_size.or_else(by_rows)
}
