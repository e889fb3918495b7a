//! Which rows depend on the others?
//!
//! Eliminated finds how many rows depend on others. Where it brings rows to echelon form before their turn, it takes multiples of rows that may be
//! found to depend on others later. Then those that it names need not be ones without which the rank is the same ([`Eliminated::misnames`]). So those are
//! named that depend on rows before them ([`mod@crate::matrix::echelon`]), those that make bodies ([`mod@crate::matrix::contract`]) being before all others. They count
//! where elimination finds that those that are left are independent. Where it does not, those that it named are asked the same.

use crate::matrix::budget::Budget;
use crate::matrix::contract::Contracted;
use crate::matrix::echelon;
use crate::matrix::eliminate::{Eliminated, Task, eliminate};
use crate::matrix::sparse::Sparse;

/// What elimination finds, with rows named without which the rank is the same, by what may be spent on names; where none such are found, with none named.
pub(crate) fn named(
    matrix: &Sparse,
    contracted: &Contracted,
    order: &[u32],
    task: Task<'_>,
    budget: &Budget,
) -> Eliminated {
    let mut outcome = contracted.eliminate(matrix, order, task);
    if outcome.dependent.is_empty() || !outcome.is_decided() {
        return outcome;
    }
    match names(contracted, order, &outcome, budget) {
        Some(dependent) => outcome.dependent = dependent,
        None if outcome.misnames => outcome.dependent.clear(),
        None => {}
    }
    outcome
}

/// Rows without which the rank is the same, as many as it says.
fn names(contracted: &Contracted, order: &[u32], outcome: &Eliminated, budget: &Budget) -> Option<Vec<u32>> {
    /// What is left is no nearer to what is dependent than the whole, by this factor.
    const NEARER: f64 = 1e-3;
    let rest = &contracted.rest;
    let count = outcome.redundant().checked_sub(contracted.dependent.len())?;
    let rank = rest.rows().checked_sub(count)?;
    let is_left = |named: &[u32], uncertainty: f64| {
        let rows: Vec<u32> =
            (0..rest.rows() as u32).filter(|row| named.binary_search(row).is_err()).collect();
        let task = Task { uncertainty, budget: Some(budget), ..Task::default() };
        rows.len() == rank && eliminate(&rest.with_rows(&rows), order, task).rank == rank
    };
    let nearer = if outcome.gap[1].is_finite() { NEARER * outcome.gap[1] } else { 0.0 };
    // Columns that are free are made of the others, and so tell nothing of rows; what rounding leaves of them might.
    let free: Vec<u32> = outcome.free.iter().filter_map(|column| contracted.column(*column)).collect();
    let free = if outcome.free.len() == outcome.mobility() { free } else { Vec::new() };
    let in_order = echelon::dependent(rest, (order, &free), count, budget);
    let is_eliminated = |name: &u32| outcome.dependent.binary_search(name).is_ok();
    let by_elimination = || -> Vec<u32> {
        let names = (0..).zip(&contracted.names);
        names.filter(|(_, name)| is_eliminated(name)).map(|(row, _)| row).collect()
    };
    let found = in_order
        .filter(|named| named.is_empty() || is_left(named, nearer))
        .or_else(|| Some(by_elimination()).filter(|named| is_left(named, 0.0)))?;
    let mut all: Vec<u32> = found.into_iter().map(|row| contracted.names[row as usize]).collect();
    all.extend(&contracted.dependent);
    all.sort_unstable();
    Some(all)
}
