//! Where do the redundancies of a large part hold? It is moved once, along all its free motions, and brought back to where its constraints hold.
//!
//! A random state of a branch of motion has the largest rank there is on it, but for states of no measure. There the constraints that were not redundant
//! are solved for a random motion: where it is one of those that were, too, they hold throughout, as is judged. Where it is
//! not, elimination has the rank, with what is certain of it; then some held at the first state only.
//!
//! It counts as moved only where none of the free motions was taken back: others may be excluded to second order, of which nothing is known here.

use super::Holds;
use super::budget::Budget;
use super::contract::Contracted;
use super::eliminate::{Outcome, Sparse, Task, eliminate};
use super::found::Found;
use super::largest;
use super::moving::{BEYOND, HOLDS, correcting, is_constraint, is_whole, spread};
use super::naming::named;
use super::noise::random;
use super::redundant::only_here;
use super::system::{Part, System};
use crate::audit::bound::U;
use crate::evaluate::Sequence;
use crate::scene::State;
use std::collections::HashMap;

/// How far it is moved (rad, or lengths of a connector): the first where that leads somewhere.
const STEPS: [f64; 2] = [0.05, 0.01];
/// The residual at which constraints hold to rounding, as they must where rows are to depend on each other: or as near as that gets.
const ROUNDED: f64 = 1e-14;
/// A motion is off what a row allows by more than this part of what the row is made of, and of the largest amount of the motion, if it is: more than
/// rounding leaves.
const FRESH: [f64; 2] = [1e-8, 1e-10];
/// Free motions by less than this part of the step, as of what hangs on a long body that turns, do not show what second order takes back.
const LEAST: f64 = 1e-2;
/// Corrections, each of which squares what is left.
const CORRECTIONS: usize = 8;

/// Where the dependences of a part hold, by dependent row; `None` where it could not be moved, or the rank elsewhere is not certain.
pub(super) fn judge(system: &System<'_>, part: &Part, found: &Found, budget: &Budget) -> Option<Vec<Holds>> {
    let here = &found.constraints;
    if !here.has_pivots() || !here.names_all() {
        return None;
    }
    let sequence = Sequence::new(system.model, system.plan);
    let mut there = None;
    for (sample, step) in STEPS.into_iter().enumerate() {
        let motion = spread(part, here, sample, step)?;
        there = there.or_else(|| arrive(system, part, &sequence, (found, &motion), budget));
    }
    let There { matrix, is_fresh, uncertainty } = there?;
    if !is_fresh {
        return Some(vec![Holds::Throughout; here.dependent.len()]);
    }
    let task = Task { uncertainty, most: part.most, budget: Some(budget), ..Task::default() };
    let outcome = named(&matrix, part, task);
    if !outcome.is_decided() || !outcome.names_all() || outcome.rank <= here.rank {
        return None;
    }
    let only = only_here(&here.dependent, &outcome.dependent);
    let holds = |row: &u32| if only.contains(row) { Holds::Here } else { Holds::Throughout };
    Some(here.dependent.iter().map(holds).collect())
}

/// Another admissible state.
struct There {
    matrix: Sparse,
    /// Whether a motion that the other rows allow is none that those allow which were dependent.
    is_fresh: bool,
    /// By how much the entries may be others, for the constraints hold to no more.
    uncertainty: f64,
}

fn arrive(
    system: &System<'_>,
    part: &Part,
    sequence: &Sequence<'_>,
    (found, motion): (&Found, &[f64]),
    budget: &Budget,
) -> Option<There> {
    let here = &found.constraints;
    let (step, mut total) = (largest(motion), motion.to_vec());
    let of_free = here.free.iter().filter_map(|column| motion.get(*column as usize));
    if largest(of_free) < LEAST * step {
        return None;
    }
    let mut state = system.moved(part, &State::default(), motion);
    let (mut values, mut last, mut before) = (Vec::new(), f64::INFINITY, f64::INFINITY);
    let one = correcting(system, part);
    for _ in 0..CORRECTIONS {
        if !budget.spend(one) {
            return None;
        }
        let residuals = system.residuals(part, sequence, &state);
        let worst = largest(&residuals);
        if worst.is_nan() || worst > step {
            return None;
        }
        let is_there = worst < ROUNDED || (worst < HOLDS && worst > before / 4.0);
        before = worst;
        sequence.clone().assemble(&state, &system.jacobian, &mut values).ok()?;
        let (rows, matrix) = system.matrix(part, (&state, &values), is_constraint);
        let residual = |row: u32| {
            let place = rows.get(row as usize).and_then(|row| part.rows.binary_search(row).ok());
            place.and_then(|place| residuals.get(place)).copied().unwrap_or_default()
        };
        if is_there && !is_whole(here, motion, &total) {
            return None;
        }
        // What was free is left as it is, or moves at random.
        let given = |column: &u32| {
            let [random, ..] = random(u64::from(*column));
            (*column, if is_there { f64::from(random) } else { 0.0 })
        };
        let right = |row: u32| if is_there { 0.0 } else { -residual(row) };
        let change = solution(&matrix, part, here, (&given, &right), budget)?;
        if is_there {
            let (most, mut is_fresh) = (largest(&change), false);
            for row in &here.dependent {
                let (mut product, mut own, mut moved) = (0.0_f64, 0.0_f64, 0.0_f64);
                for at in matrix.range(*row as usize) {
                    let (column, value) = (matrix.columns[at] as usize, matrix.values[at]);
                    product += value * change[column];
                    own += (value * change[column]).abs();
                    moved += (value * total[column]).abs();
                }
                is_fresh |= product.abs() > FRESH[0] * own + FRESH[1] * most;
                // What moves so little that a difference would not show tells nothing.
                if own > FRESH[1] * most && own * moved < 10.0 * FRESH[1] * most {
                    return None;
                }
            }
            let uncertainty = BEYOND * worst.max(U).sqrt().max(last.powi(2));
            return Some(There { matrix, is_fresh, uncertainty });
        }
        last = largest(&change);
        if last.is_nan() || last > step {
            return None;
        }
        for (sum, x) in total.iter_mut().zip(&change) {
            *sum += x;
        }
        state = system.moved(part, &state, &change);
    }
    None
}

/// What is given of a free column.
type Given<'a> = dyn Fn(&u32) -> (u32, f64) + 'a;

/// A solution of the rows that were not redundant, with what is given of the free columns; `None` where they depend on each other, or these are others now.
fn solution(
    matrix: &Sparse,
    part: &Part,
    here: &Outcome,
    (given, right): (&Given<'_>, &dyn Fn(u32) -> f64),
    budget: &Budget,
) -> Option<Vec<f64>> {
    let is_redundant = |row: &u32| here.dependent.binary_search(row).is_ok();
    let contracted = Contracted::of(matrix, 0.0);
    if contracted.made_by.iter().any(is_redundant) || !contracted.dependent.iter().all(is_redundant) {
        return None;
    }
    let right: Vec<f64> = (0..matrix.rows() as u32).map(right).collect();
    let shifted = contracted.shifted(matrix, &right);
    let given: Option<Vec<_>> = here.free.iter().map(|column| contracted.given(given(column))).collect();
    let given: HashMap<u32, f64> = given?.into_iter().collect();
    // What is given goes to the right-hand side: its columns are without entries, and free.
    let names = (0..).zip(&contracted.names);
    let rows: Vec<u32> = names.filter(|(_, name)| !is_redundant(name)).map(|(row, _)| row).collect();
    let mut rest = contracted.rest.with_rows(&rows);
    let mut of_rest: Vec<f64> = rows.iter().map(|row| shifted.right[*row as usize]).collect();
    for (row, right) in of_rest.iter_mut().enumerate() {
        for at in rest.range(row) {
            if let Some(given) = given.get(&rest.columns[at]) {
                *right -= rest.values[at] * given;
                rest.values[at] = 0.0;
            }
        }
    }
    rest.drop_zeros();
    let orders = part.orders(&contracted);
    let task =
        Task { right: Some(&of_rest), keep: true, most: part.most, budget: Some(budget), ..Task::default() };
    let outcome = eliminate(&rest, &orders.best, task);
    if outcome.exhausted || outcome.rank < rows.len() || !(outcome.has_pivots() || rows.is_empty()) {
        return None;
    }
    let free = |column: u32| given.get(&column).copied().unwrap_or_default();
    Some(contracted.expanded(matrix, &outcome.solve(rest.width(), free, false), &shifted))
}
