//! Which rows depend on the others?
//!
//! Elimination finds how many rows depend on others. Where it brings rows to echelon form before their turn, multiples are taken of rows that may be found
//! to depend on others later: then those that it names need not be ones without which the rank is the same ([`Outcome::misnames`]). So those are named
//! that depend on rows before them: of small matrices by what of each is orthogonal to these, of others by [`mod@super::echelon`].

use super::eliminate::{Outcome, Sparse, Task, eliminate};
use super::system::Part;
use super::{dense, echelon};

/// What elimination finds, with rows named without which the rank is the same; where none such are found, with none named.
pub(super) fn named(matrix: &Sparse, part: &Part, task: Task<'_>) -> Outcome {
    let mut outcome = eliminate(matrix, &part.order, task);
    if outcome.dependent.is_empty() || !outcome.is_decided() {
        return outcome;
    }
    let count = outcome.dependent.len();
    let by_size = if dense::is_small(matrix, dense::LARGEST) {
        Some(dense::dependent(matrix)).filter(|dependent| dependent.len() == count)
    } else {
        None
    };
    match by_size.or_else(|| echelon::dependent(matrix, &part.by_degree, count, echelon::MOST)) {
        Some(dependent) => outcome.dependent = dependent,
        None if outcome.misnames => outcome.dependent.clear(),
        None => {}
    }
    outcome
}
