//! Which rows depend on the others?
//!
//! Elimination finds how many rows depend on others. Where it brings rows to echelon form before their turn, multiples are taken of rows that may be found
//! to depend on others later: then those that it names need not be ones without which the rank is the same ([`Outcome::misnames`]). So those are named
//! that depend on rows before them, those that make bodies ([`mod@super::contract`]) being before all others: of small matrices by what of each is
//! orthogonal to these, of others by [`mod@super::echelon`], as far as what is left is found to be independent.

use super::budget::{Budget, PRODUCTS};
use super::contract::Contracted;
use super::eliminate::{Outcome, Sparse, Task, eliminate};
use super::order::Orders;
use super::system::Part;
use super::{dense, echelon};

/// What elimination finds, with rows named without which the rank is the same; where none such are found, with none named.
pub(super) fn named(matrix: &Sparse, part: &Part, task: Task<'_>) -> Outcome {
    let contracted = Contracted::of(matrix, task.uncertainty);
    let unlimited = Budget::new(u64::MAX);
    let budget = task.budget.unwrap_or(&unlimited);
    named_of(matrix, &contracted, &part.orders(&contracted), task, budget)
}

/// The same of what is put together to bodies already, with what may be spent on names.
pub(super) fn named_of(
    matrix: &Sparse,
    contracted: &Contracted,
    orders: &Orders,
    task: Task<'_>,
    budget: &Budget,
) -> Outcome {
    let mut outcome = contracted.eliminate(matrix, &orders.best, task);
    if outcome.dependent.is_empty() || !outcome.is_decided() {
        return outcome;
    }
    match last(matrix, contracted, orders, &outcome, budget) {
        Some(dependent) => outcome.dependent = dependent,
        None if outcome.misnames => {
            outcome.dependent.clear();
            outcome.names_spent = budget.exceeded();
        }
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
    budget: &Budget,
) -> Option<Vec<u32>> {
    let count = outcome.redundant();
    let [rows, columns] = [matrix.rows(), matrix.width()];
    let by_size = if dense::is_small(matrix, dense::LARGEST)
        && budget.spend(rows.min(columns) * rows * columns / PRODUCTS)
    {
        Some(dense::dependent(matrix, &contracted.in_order())).filter(|dependent| dependent.len() == count)
    } else {
        None
    };
    by_size.or_else(|| by_rows(contracted, orders, outcome, count, budget))
}

/// The same of what is not small.
///
/// Where many loops meet, rows that do not depend on those before them may nearly do so, the more nearly the more there are, until rounding decides. So
/// what is named counts where elimination finds those that are left to be independent. Else those are named that it found to depend on others, which it
/// takes from the largest entries; of what is left it is asked again whether it is independent, and where it is not, those of the others
/// take its place along which most of what is then free moves.
fn by_rows(
    contracted: &Contracted,
    orders: &Orders,
    outcome: &Outcome,
    count: usize,
    budget: &Budget,
) -> Option<Vec<u32>> {
    /// What is left is put right so often.
    const TIMES: usize = 8;
    /// What is left is no nearer to what is dependent than the whole, by this factor.
    const NEARER: f64 = 1e-3;
    let (rest, all) = (&contracted.rest, || 0..contracted.rest.rows() as u32);
    let of_rest = count.checked_sub(contracted.dependent.len())?;
    let rank = rest.rows().checked_sub(of_rest)?;
    // Columns that are free are made of the others, and so tell nothing of rows; what rounding leaves of them might.
    let free: Vec<u32> =
        outcome.free.iter().filter_map(|column| Some(contracted.given((*column, 0.0))?.0)).collect();
    let free = if outcome.free.len() == outcome.mobility() { free } else { Vec::new() };
    let nearer = if outcome.gap[1].is_finite() { NEARER * outcome.gap[1] } else { 0.0 };
    let left = |rows: &[u32], uncertainty: f64| {
        let task = Task { keep: true, uncertainty, budget: Some(budget), ..Task::default() };
        eliminate(&rest.with_rows(rows), &orders.best, task)
    };
    let without =
        |rows: &[u32]| -> Vec<u32> { all().filter(|row| rows.binary_search(row).is_err()).collect() };
    let in_order = echelon::dependent(rest, (&orders.by_degree, &free), of_rest, budget);
    // Where nothing was eliminated there is nothing to be asked.
    let found = if outcome.front == 0 || of_rest == 0 {
        in_order?
    } else if let Some(found) = in_order.filter(|found| left(&without(found), nearer).rank == rank) {
        found
    } else {
        let is_named = |row: &u32| {
            let name = contracted.names[*row as usize];
            outcome.dependent.binary_search(&name).is_ok()
        };
        let mut basis: Vec<u32> = all().filter(|row| !is_named(row)).collect();
        let mut times = 0;
        loop {
            let found = left(&basis, nearer);
            if found.rank == rank && basis.len() == rank {
                break;
            }
            times += 1;
            if found.exhausted || !found.has_pivots() {
                return None;
            }
            let before = basis.clone();
            let gone: Vec<u32> = found.dependent.iter().map(|row| basis[*row as usize]).collect();
            basis.retain(|row| gone.binary_search(row).is_err());
            basis.extend(moving(rest, &without(&basis), &found, rank - found.rank, budget)?);
            basis.sort_unstable();
            if times > TIMES || basis == before {
                // No better ones were found: those that are independent to rounding will do.
                if left(&basis, 0.0).rank < rank {
                    return None;
                }
                break;
            }
        }
        without(&basis)
    };
    let mut all: Vec<u32> = found.into_iter().map(|row| contracted.names[row as usize]).collect();
    all.extend(&contracted.dependent);
    all.sort_unstable();
    Some(all)
}

/// So many of some rows along which the motions that others leave free move most, and which are independent there.
fn moving(matrix: &Sparse, rows: &[u32], found: &Outcome, count: usize, budget: &Budget) -> Option<Vec<u32>> {
    /// Motions that are looked at: as many numbers are kept of each row.
    const MOST: usize = 200;
    /// What a row moves at least, relative to the motion.
    const MOVES: f64 = 1e-14;
    // Motions, what rows move along each, and what is chosen of them.
    let of_each = found.others.len() + matrix.columns.len() + count * rows.len();
    if found.free.len() > MOST || !budget.spend(found.free.len() * of_each / PRODUCTS) {
        return None;
    }
    let width = matrix.width();
    let mut moved: Vec<Vec<f64>> = vec![Vec::with_capacity(found.free.len()); rows.len()];
    for column in &found.free {
        let motion = found.solve(width, |other| f64::from(u8::from(other == *column)), true);
        let size = super::largest(&motion);
        for (row, of_row) in rows.iter().zip(&mut moved) {
            let along = |at: usize| matrix.values[at] * motion[matrix.columns[at] as usize] / size;
            of_row.push(matrix.range(*row as usize).map(along).sum());
        }
    }
    let mut chosen = Vec::with_capacity(count);
    for _ in 0..count {
        let largest = |of_row: &Vec<f64>| of_row.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let (at, _) = moved.iter().enumerate().max_by(|x, y| largest(x.1).total_cmp(&largest(y.1)))?;
        let pivot = moved[at].clone();
        let (place, _) = pivot.iter().enumerate().max_by(|x, y| x.1.abs().total_cmp(&y.1.abs()))?;
        if pivot[place].is_nan() || pivot[place].abs() < MOVES {
            return None;
        }
        for of_row in &mut moved {
            let factor = of_row[place] / pivot[place];
            of_row.iter_mut().zip(&pivot).for_each(|(x, by)| *x -= factor * by);
            of_row[place] = 0.0;
        }
        chosen.push(rows[at]);
    }
    Some(chosen)
}
