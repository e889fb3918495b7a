//! Does a dependence hold elsewhere? The part is moved along its free motions, brought back to where its constraints hold, and
//! looked at there.
//!
//! Rank is lower semicontinuous and, where the functions are analytic, as large at almost every state of a branch of motion as
//! anywhere on it. So a rank that is *larger* at another admissible state proves, to rounding, that the dependence there was one of a
//! singular position. A rank that is the same at several random states is *judged* to be the one of all.

use super::eliminate::{Outcome, Sparse, Task, eliminate};
use super::system::{Part, Role, System};
use super::{Holds, dense, krylov, largest as largest_of};
use crate::evaluate::Sequence;
use crate::scene::State;

/// The states that a part is moved to at most.
pub(super) const SAMPLES: usize = STEPS.len();
/// How far the part is moved (rad, or lengths of a connector): a small and a larger step.
const STEPS: [f64; 4] = [0.05, 0.2, 0.3, 0.1];
/// The residual at which constraints hold again.
const HOLDS: f64 = 1e-11;
/// The largest number of corrections.
const CORRECTIONS: usize = 20;
/// A motion that gets less far than this part of its step is none.
const MOVED: f64 = 0.1;

/// What became of the dependent rows elsewhere.
pub(super) struct Elsewhere {
    pub(super) holds: Holds,
    /// The rows (of the part's matrix) that depend on others elsewhere too.
    pub(super) dependent: Vec<u32>,
}

/// Follows the free motions of a part from the state to which the sequence comes next, to so many states at which the rank is certain.
pub(super) fn elsewhere(
    system: &System<'_>,
    part: &Part,
    sequence: &Sequence<'_>,
    state: &State,
    here: &Outcome,
    samples: usize,
) -> Elsewhere {
    let unjudged = |holds| Elsewhere { holds, dependent: here.dependent.clone() };
    if here.free.is_empty() {
        return unjudged(Holds::Rigid);
    }
    let (mut best, mut stuck): (Option<Box<Outcome>>, usize) = (None, 0);
    let mut reached = 0;
    for (sample, step) in STEPS.into_iter().enumerate() {
        if reached == samples {
            break;
        }
        let corrected = |by| reach(system, part, sequence, state, here, (sample, step, by));
        let mut got = Reached::Lost;
        for by in [Correction::Least, Correction::Nearest, Correction::Gauged, Correction::Basic] {
            if matches!(got, Reached::Lost) {
                got = corrected(by);
            }
        }
        match got {
            // One whose rank is not certain tells nothing.
            Reached::There(outcome) if !outcome.is_decided() => {}
            Reached::There(outcome) => {
                reached += 1;
                if best.as_ref().is_none_or(|best| outcome.rank > best.rank) {
                    best = Some(outcome);
                }
            }
            Reached::Stuck => stuck += 1,
            Reached::Lost => {}
        }
    }
    match best {
        Some(best) if best.rank > here.rank => Elsewhere { holds: Holds::Here, dependent: best.dependent },
        Some(best) => Elsewhere { holds: Holds::Throughout, dependent: best.dependent },
        None if stuck == STEPS.len() => unjudged(Holds::Isolated),
        None => unjudged(Holds::Unjudged),
    }
}

enum Reached {
    There(Box<Outcome>),
    /// Only where it was.
    Stuck,
    Lost,
}

/// How a state is brought back to where its constraints hold: by which of the solutions of J δ = −r.
#[derive(Clone, Copy, PartialEq)]
enum Correction {
    /// The shortest; of small parts.
    Least,
    /// The same of others, to some digits: what is left of the constraints then shrinks no less than by those.
    Nearest,
    /// The one that leaves what the motion began with: the columns that were free.
    Gauged,
    /// The one that leaves the columns that are free now.
    Basic,
}

fn is_constraint(role: Role) -> bool {
    role != Role::Driven
}

fn reach(
    system: &System<'_>,
    part: &Part,
    sequence: &Sequence<'_>,
    from: &State,
    here: &Outcome,
    (sample, step, by): (usize, f64, Correction),
) -> Reached {
    let width = part.columns.len();
    // Well spread numbers: multiples of the golden ratio.
    let free = |column: u32| {
        let turn = f64::from(column + 1) * 0.618_033_988_749_894_9 + sample as f64 * 0.414_213_562_373_095;
        2.0 * turn.fract() - 1.0
    };
    let mut change = here.solve(width, free, true);
    let largest = largest_of(&change);
    if largest.is_nan() || largest == 0.0 {
        return Reached::Lost;
    }
    change.iter_mut().for_each(|x| *x *= step / largest);
    let mut total = change.clone();
    let mut state = system.moved(part, from, &change);
    let mut values = Vec::new();
    for _ in 0..CORRECTIONS {
        let residuals = system.residuals(part, sequence, &state);
        let worst = largest_of(&residuals);
        if worst.is_nan() || worst > 1e3 {
            return Reached::Lost;
        }
        if sequence.clone().assemble(&state, &system.jacobian, &mut values).is_err() {
            return Reached::Lost;
        }
        let (rows, matrix) = system.matrix(part, &values, is_constraint);
        if worst < HOLDS {
            let moved = largest_of(&total);
            if moved < MOVED * step {
                return Reached::Stuck;
            }
            let task = Task { uncertainty: 100.0 * worst, ..Task::default() };
            return Reached::There(Box::new(eliminate(&matrix, &part.order, task)));
        }
        let place = |row: &u32| part.rows.binary_search(row).ok();
        let right: Vec<f64> =
            rows.iter().map(|row| place(row).and_then(|at| residuals.get(at)).map_or(0.0, |x| -x)).collect();
        let Some(mut change) = solution(&matrix, &part.order, right, here, by) else { return Reached::Lost };
        let largest = largest_of(&change);
        if !largest.is_finite() {
            return Reached::Lost;
        }
        if largest > step {
            change.iter_mut().for_each(|x| *x *= step / largest);
        }
        for (sum, x) in total.iter_mut().zip(&change) {
            *sum += x;
        }
        state = system.moved(part, &state, &change);
    }
    Reached::Lost
}

/// A solution of J δ = right; `None` where the matrix is too large for it.
fn solution(
    matrix: &Sparse,
    order: &[u32],
    mut right: Vec<f64>,
    here: &Outcome,
    by: Correction,
) -> Option<Vec<f64>> {
    if by == Correction::Nearest {
        return (!dense::is_small(matrix, dense::LARGEST)).then(|| krylov::least(matrix, &right)).flatten();
    }
    if by == Correction::Least {
        return dense::is_small(matrix, dense::LARGEST).then(|| dense::least(matrix, &right)).flatten();
    }
    let mut gauged = matrix.clone();
    if by == Correction::Gauged {
        for column in &here.free {
            gauged.columns.push(*column);
            gauged.values.push(1.0);
            gauged.offsets.push(gauged.columns.len());
            right.push(0.0);
        }
    }
    let task = Task { right: Some(&right), keep: true, ..Task::default() };
    Some(eliminate(&gauged, order, task).solve(matrix.width(), |_| 0.0, false))
}
