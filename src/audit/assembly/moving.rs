//! Does a dependence hold elsewhere? The part is moved along its free motions, brought back to where its constraints hold, and
//! looked at there.
//!
//! Rank is lower semicontinuous and, where the functions are analytic, as large at almost every state of a branch of motion as
//! anywhere on it. So a rank that is *larger* at another admissible state proves, to rounding, that the dependence there was one of a
//! singular position. A rank that is the same at several random states is *judged* to be the one of all.
//!
//! *What is admissible?* At a singular position constraints that hold to ε allow motions of √ε, and a rank that is larger by singular
//! values of that size. So a larger rank counts only where it is well beyond √ε, and beyond what the next correction would still move: ε is
//! brought down to rounding first.
//!
//! *Where can it go?* Small parts are looked at to second order ([`mod@super::second`]), and moved along what that leaves. Of others a state counts
//! as one where the rank is the same only where none of the free motions was taken back.

use super::budget::{Budget, EVALUATION, ROW};
use super::contract::Contracted;
use super::eliminate::{Outcome, Sparse, Task};
use super::naming::named_of;
use super::redundant::only_here;
use super::second::{Second, mixed, second};
use super::system::{Part, Role, System};
use super::{Holds, dense, krylov, largest as largest_of};
use crate::audit::bound::U;
use crate::evaluate::Sequence;
use crate::scene::State;

/// The states that a part is moved to at most.
pub(super) const SAMPLES: usize = STEPS.len();
/// How far the part is moved (rad, or lengths of a connector): a small and a larger step.
const STEPS: [f64; 4] = [0.05, 0.2, 0.3, 0.1];
/// The same along each motion to which second order narrows them down.
const BRANCH: [f64; 3] = [0.1, -0.1, 0.02];
/// The residual at which constraints hold again.
pub(super) const HOLDS: f64 = 1e-11;
/// The largest number of corrections: at a singular position each takes a quarter of the residual.
const CORRECTIONS: usize = 40;
/// Corrections after which the residual must be half of what it was, at a singular position too.
const PATIENCE: usize = 8;
/// A motion that gets less far than this part of its step is none.
const MOVED: f64 = 0.1;
/// Free columns that begin with less than this part of the largest are not looked at when it is asked whether they moved.
const BEGINS: f64 = 0.25;
/// A singular value is well beyond √ε, and beyond what a correction moves, by this factor.
pub(super) const BEYOND: f64 = 100.0;

/// Where the dependences of a part hold, by dependent row: follows its free motions from the state to which the sequence comes next, to so many
/// states at which the rank is certain, besides those to which second order leads, as far as what may be spent on it leads.
pub(super) fn elsewhere(
    system: &System<'_>,
    part: &Part,
    sequence: &Sequence<'_>,
    state: &State,
    here: &Outcome,
    samples: usize,
    budget: &Budget,
) -> Vec<Holds> {
    let all = |holds| vec![holds; here.dependent.len()];
    if here.free.is_empty() {
        return all(Holds::Rigid);
    }
    let second = second(system, part, sequence, state, here, budget);
    let restrained = second.as_ref().filter(|second| !second.restraining.is_empty());
    if let Some(second) = restrained.filter(|second| second.excludes && second.open.is_empty()) {
        // Those that restrain no motion have nothing to do with the position.
        let one = |row: &u32| {
            if second.restraining.contains(row) { Holds::Isolated } else { Holds::Rigid }
        };
        return here.dependent.iter().map(one).collect();
    }
    let [narrowed, open] = motions(part, here, restrained);
    let seen = seen(system, part, sequence, state, here, (&narrowed, &open, samples), budget);
    let is_whole = second.is_some() || seen.is_whole;
    let others = if seen.best.is_some() && is_whole && !seen.is_doubtful && !seen.is_cut_short {
        Holds::Throughout
    } else {
        not_judged(budget)
    };
    if let Some(best) = seen.best.filter(|best| best.rank > here.rank) {
        let only = only_here(&here.dependent, &best.dependent);
        return here
            .dependent
            .iter()
            .map(|row| if only.contains(row) { Holds::Here } else { others })
            .collect();
    }
    let excludes = restrained.is_some_and(|second| second.excludes);
    // Where other motions lead to states at which they restrain the same, it is no matter of this one.
    let of_restrained = match others {
        _ if !excludes => not_judged(budget),
        Holds::Throughout => Holds::Singular,
        Holds::Spent => Holds::Spent,
        _ => Holds::Isolated,
    };
    let is_restraining = |row: &u32| restrained.is_some_and(|second| second.restraining.contains(row));
    let one = |row: &u32| if is_restraining(row) { of_restrained } else { others };
    here.dependent.iter().map(one).collect()
}

/// What is told of that which was not judged.
fn not_judged(budget: &Budget) -> Holds {
    if budget.is_spent() { Holds::Spent } else { Holds::Unjudged }
}

/// The motions that are tried: those to which second order narrows them down, and mixtures of the others.
fn motions(part: &Part, here: &Outcome, restrained: Option<&Second>) -> [Vec<Vec<f64>>; 2] {
    let steps = || STEPS.into_iter().enumerate();
    let Some(second) = restrained else {
        return [Vec::new(), steps().filter_map(|(sample, step)| spread(part, here, sample, step)).collect()];
    };
    let along = |zero: &Vec<f64>| -> Vec<Vec<f64>> {
        BRANCH.into_iter().filter_map(|step| mixed(std::slice::from_ref(zero), 0, step)).collect()
    };
    let open = steps().filter_map(|(sample, step)| mixed(&second.open, sample, step)).collect();
    [second.zeros.iter().flat_map(along).collect(), open]
}

/// All free motions at once, by well spread numbers: multiples of the golden ratio.
pub(super) fn spread(part: &Part, here: &Outcome, sample: usize, step: f64) -> Option<Vec<f64>> {
    let free = |column: u32| {
        let turn = f64::from(column + 1) * 0.618_033_988_749_894_9 + sample as f64 * 0.414_213_562_373_095;
        2.0 * turn.fract() - 1.0
    };
    let mut change = here.solve(part.columns.len(), free, true);
    let largest = largest_of(&change);
    if largest.is_nan() || largest == 0.0 {
        return None;
    }
    change.iter_mut().for_each(|x| *x *= step / largest);
    Some(change)
}

/// What was seen elsewhere.
struct Seen {
    /// The largest rank of all states whose rank is certain.
    best: Option<Outcome>,
    /// Whether the rank of a state may be larger.
    is_doubtful: bool,
    /// Whether there was a state to which no free motion was taken back.
    is_whole: bool,
    /// Whether more states were wanted than what may be spent was enough for.
    is_cut_short: bool,
}

fn seen(
    system: &System<'_>,
    part: &Part,
    sequence: &Sequence<'_>,
    state: &State,
    here: &Outcome,
    (narrowed, open, samples): (&[Vec<f64>], &[Vec<f64>], usize),
    budget: &Budget,
) -> Seen {
    let mut seen = Seen { best: None, is_doubtful: false, is_whole: false, is_cut_short: false };
    let mut reached = 0;
    for (at, motion) in narrowed.iter().chain(open).enumerate() {
        if reached == samples || budget.is_spent() {
            break;
        }
        let mut got = Reached::Lost;
        for by in [Correction::Least, Correction::Nearest, Correction::Gauged, Correction::Basic] {
            if matches!(got, Reached::Lost) && !budget.is_spent() {
                got = reach(system, part, sequence, state, here, (motion, by), budget);
            }
        }
        match got {
            // One whose rank is not certain tells nothing.
            Reached::There(outcome, _) if !outcome.is_decided() => {}
            Reached::There(outcome, is_whole) => {
                seen.is_whole |= is_whole;
                reached += usize::from(at >= narrowed.len());
                if seen.best.as_ref().is_none_or(|best| outcome.rank > best.rank) {
                    seen.best = Some(*outcome);
                }
            }
            Reached::Doubtful => seen.is_doubtful = true,
            Reached::Stuck | Reached::Lost => {}
        }
    }
    seen.is_cut_short = reached < samples && budget.is_spent();
    seen
}

enum Reached {
    /// At an admissible state; whether all free motions led there.
    There(Box<Outcome>, bool),
    /// Where the rank may be larger, which is no more than what the constraints leave open.
    Doubtful,
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

/// What a correction costs besides its elimination: the part is evaluated twice, and its rows are put into matrices.
pub(super) fn correcting(system: &System<'_>, part: &Part) -> usize {
    2 * EVALUATION * (system.plan.connectors.len() + system.plan.mpcs.len()) + 2 * ROW * part.rows.len()
}

pub(super) fn is_constraint(role: Role) -> bool {
    role != Role::Driven
}

fn reach(
    system: &System<'_>,
    part: &Part,
    sequence: &Sequence<'_>,
    from: &State,
    here: &Outcome,
    (motion, by): (&[f64], Correction),
    budget: &Budget,
) -> Reached {
    let step = largest_of(motion);
    let one = correcting(system, part);
    let mut total = motion.to_vec();
    let mut state = system.moved(part, from, motion);
    let (mut values, mut before) = (Vec::new(), f64::INFINITY);
    let (mut best, mut since) = (f64::INFINITY, 0);
    for _ in 0..CORRECTIONS {
        if !budget.spend(one) {
            return Reached::Lost;
        }
        let residuals = system.residuals(part, sequence, &state);
        let worst = largest_of(&residuals);
        if worst.is_nan() || worst > 1e3 || since > PATIENCE {
            return Reached::Lost;
        }
        since += 1;
        if worst < best / 2.0 {
            (best, since) = (worst, 0);
        }
        if sequence.clone().assemble(&state, &system.jacobian, &mut values).is_err() {
            return Reached::Lost;
        }
        let (rows, matrix) = system.matrix(part, (&state, &values), is_constraint);
        // Names are asked for where the rank is larger, and then certain.
        let rank = |uncertainty: f64| -> Outcome {
            let task = Task { uncertainty, budget: Some(budget), ..Task::default() };
            let contracted = Contracted::of(&matrix, uncertainty);
            let orders = part.orders(&contracted);
            let outcome = contracted.eliminate(&matrix, &orders.best, task);
            if outcome.rank <= here.rank || !outcome.is_decided() {
                return outcome;
            }
            named_of(&matrix, &contracted, &orders, task, budget)
        };
        let is_there = worst < HOLDS;
        if is_there {
            if largest_of(&total) < MOVED * step {
                return Reached::Stuck;
            }
            let outcome = rank(BEYOND * worst);
            if outcome.exhausted {
                return Reached::Lost;
            }
            if outcome.rank <= here.rank {
                return Reached::There(Box::new(outcome), is_whole(here, motion, &total));
            }
        }
        let place = |row: &u32| part.rows.binary_search(row).ok();
        let right: Vec<f64> =
            rows.iter().map(|row| place(row).and_then(|at| residuals.get(at)).map_or(0.0, |x| -x)).collect();
        let Some(mut change) = solution(&matrix, part, right, here, by, budget) else { return Reached::Lost };
        let largest = largest_of(&change);
        if !largest.is_finite() {
            return Reached::Lost;
        }
        if is_there && worst > before / 4.0 {
            let outcome = rank(BEYOND * worst.max(U).sqrt().max(largest));
            let is_certain = outcome.is_decided();
            return if is_certain {
                Reached::There(Box::new(outcome), is_whole(here, motion, &total))
            } else {
                Reached::Doubtful
            };
        }
        before = worst;
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

/// Whether none of the free motions was taken back.
pub(super) fn is_whole(here: &Outcome, motion: &[f64], total: &[f64]) -> bool {
    let of = |column: &u32| Some((motion.get(*column as usize)?.abs(), total.get(*column as usize)?.abs()));
    let free: Vec<(f64, f64)> = here.free.iter().filter_map(of).collect();
    let largest = free.iter().map(|(began, _)| *began).fold(0.0, f64::max);
    free.iter().all(|(began, now)| *began < BEGINS * largest || *now >= MOVED * began)
}

/// A solution of J δ = right; `None` where the matrix is too large for it.
fn solution(
    matrix: &Sparse,
    part: &Part,
    mut right: Vec<f64>,
    here: &Outcome,
    by: Correction,
    budget: &Budget,
) -> Option<Vec<f64>> {
    if by == Correction::Nearest {
        return (!dense::is_small(matrix, dense::LARGEST))
            .then(|| krylov::least(matrix, &right, budget))
            .flatten();
    }
    if by == Correction::Least {
        let may = dense::is_small(matrix, dense::LARGEST) && budget.decompose(matrix.rows(), matrix.width());
        return may.then(|| dense::least(matrix, &right)).flatten();
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
    let task = Task { right: Some(&right), keep: true, budget: Some(budget), ..Task::default() };
    let contracted = Contracted::of(&gauged, 0.0);
    let orders = part.orders(&contracted);
    let outcome = contracted.eliminate(&gauged, &orders.best, task);
    (!outcome.exhausted).then(|| outcome.solve(matrix.width(), |_| 0.0, false))
}
