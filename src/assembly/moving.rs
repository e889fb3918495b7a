//! Does a dependence hold elsewhere? The connected component is moved along its free motions, brought back to where its constraints hold, and
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
//! *Where can it go?* Small connected components are looked at to second order ([`mod@crate::second`]), and moved along what that leaves. Of others a state counts
//! as one where the rank is the same only where none of the free motions was taken back.

use crate::facts::{Holds, Role};
use crate::matrix::budget::{Budget, EVALUATION, ROW};
use crate::matrix::contract::Contracted;
use crate::matrix::dense;
use crate::matrix::eliminate::{Eliminated, Task};
use crate::matrix::naming::named;
use crate::matrix::sparse::{Sparse, largest as largest_of};
use crate::second::{Second, mixed, second};
use crate::system::{ConnectedComponent, System};
use pintle_kinematics::scalar::U;
use pintle_model::evaluate::Sequence;
use pintle_scene::State;

/// The states that a connected component is moved to at most.
pub(crate) const SAMPLES: usize = STEPS.len();
/// How far the connected component is moved (rad, or lengths of a connector): a small and a larger step.
const STEPS: [f64; 4] = [0.05, 0.2, 0.3, 0.1];
/// The same along each motion to which second order narrows them down.
const BRANCH: [f64; 3] = [0.1, -0.1, 0.02];
/// The residual at which constraints hold again.
const HOLDS: f64 = 1e-11;
/// The largest number of corrections: at a singular position each takes a quarter of the residual.
const CORRECTIONS: usize = 40;
/// Corrections after which the residual must be half of what it was, at a singular position too.
const PATIENCE: usize = 8;
/// A motion that gets less far than this part of its step is none.
const MOVED: f64 = 0.1;
/// Free columns that begin with less than this part of the largest are not looked at when it is asked whether they moved.
const BEGINS: f64 = 0.25;
/// The size up to which the shortest solution is sought, by a dense decomposition: at a singular position no other leads back as surely.
const SHORTEST: usize = 500;
/// A singular value is well beyond √ε, and beyond what a correction moves, by this factor.
const BEYOND: f64 = 100.0;

/// Where the dependences of a connected component hold, by dependent row. It follows the free motions of the connected component from the state to which the
/// sequence comes next. It goes to so many states at which the rank is certain, besides those to which second order leads, as far
/// as what may be spent on it leads.
pub(crate) fn elsewhere(
    system: &System<'_>,
    component: &ConnectedComponent,
    sequence: &Sequence<'_>,
    state: &State,
    here: &Eliminated,
    samples: usize,
    budget: &Budget,
) -> Vec<Holds> {
    let all = |holds| vec![holds; here.dependent.len()];
    if here.free.is_empty() {
        return all(Holds::Rigid);
    }
    let second = second(system, component, sequence, state, here, budget);
    let restrained = second.as_ref().filter(|second| !second.restraining.is_empty());
    if let Some(second) = restrained.filter(|second| second.excludes && second.open.is_empty()) {
        // Those that restrain no motion have nothing to do with the position.
        let one = |row: &u32| {
            if second.restraining.contains(row) { Holds::Isolated } else { Holds::Rigid }
        };
        return here.dependent.iter().map(one).collect();
    }
    let [narrowed, open] = motions(component, here, restrained);
    let seen = seen(system, component, sequence, state, here, (&narrowed, &open, samples), budget);
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
fn motions(
    component: &ConnectedComponent,
    here: &Eliminated,
    restrained: Option<&Second>,
) -> [Vec<Vec<f64>>; 2] {
    let steps = || STEPS.into_iter().enumerate();
    let Some(second) = restrained else {
        return [
            Vec::new(),
            steps().filter_map(|(sample, step)| spread(component, here, sample, step)).collect(),
        ];
    };
    let along = |zero: &Vec<f64>| -> Vec<Vec<f64>> {
        BRANCH.into_iter().filter_map(|step| mixed(std::slice::from_ref(zero), 0, step)).collect()
    };
    let open = steps().filter_map(|(sample, step)| mixed(&second.open, sample, step)).collect();
    [second.zeros.iter().flat_map(along).collect(), open]
}

/// All free motions at once, by well spread numbers: multiples of the golden ratio.
fn spread(component: &ConnectedComponent, here: &Eliminated, sample: usize, step: f64) -> Option<Vec<f64>> {
    let free = |column: u32| {
        let turn = f64::from(column + 1) * 0.618_033_988_749_894_9 + sample as f64 * 0.414_213_562_373_095;
        2.0 * turn.fract() - 1.0
    };
    let mut change = here.solve(component.columns.len(), free, true);
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
    best: Option<Eliminated>,
    /// Whether the rank of a state may be larger.
    is_doubtful: bool,
    /// Whether there was a state to which no free motion was taken back.
    is_whole: bool,
    /// Whether more states were wanted than what may be spent was enough for.
    is_cut_short: bool,
}

fn seen(
    system: &System<'_>,
    component: &ConnectedComponent,
    sequence: &Sequence<'_>,
    state: &State,
    here: &Eliminated,
    (narrowed, open, samples): (&[Vec<f64>], &[Vec<f64>], usize),
    budget: &Budget,
) -> Seen {
    let mut seen = Seen { best: None, is_doubtful: false, is_whole: false, is_cut_short: false };
    let mut reached = 0;
    // Of larger connected components the shortest solution is dear, and asked for last.
    let order = if here.size[0].min(here.size[1]) <= dense::LARGEST {
        [Correction::Least, Correction::Gauged, Correction::Basic]
    } else {
        [Correction::Gauged, Correction::Basic, Correction::Least]
    };
    for (at, motion) in narrowed.iter().chain(open).enumerate() {
        if reached == samples || budget.is_spent() {
            break;
        }
        let mut got = Reached::Lost;
        for by in order {
            if matches!(got, Reached::Lost) && !budget.is_spent() {
                got = reach(system, component, sequence, state, here, (motion, by), budget);
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
    There(Box<Eliminated>, bool),
    /// Where the rank may be larger, which is no more than what the constraints leave open.
    Doubtful,
    /// Only where it was.
    Stuck,
    Lost,
}

/// How a state is brought back to where its constraints hold: by which of the solutions of J δ = −r.
#[derive(Clone, Copy, PartialEq)]
enum Correction {
    /// The shortest; of connected components that are not large.
    Least,
    /// The one that leaves what the motion began with: the columns that were free.
    Gauged,
    /// The one that leaves the columns that are free now.
    Basic,
}

/// What a correction costs besides its elimination: the connected component is evaluated twice, and its rows are put into matrices.
fn correcting(system: &System<'_>, component: &ConnectedComponent) -> usize {
    2 * EVALUATION * system.evaluated_elements() + 2 * ROW * component.rows.len()
}

fn is_constraint(role: Role) -> bool {
    role != Role::Driven
}

fn reach(
    system: &System<'_>,
    component: &ConnectedComponent,
    sequence: &Sequence<'_>,
    from: &State,
    here: &Eliminated,
    (motion, by): (&[f64], Correction),
    budget: &Budget,
) -> Reached {
    let step = largest_of(motion);
    let one = correcting(system, component);
    let mut total = motion.to_vec();
    let mut state = system.moved(component, from, motion);
    let (mut values, mut before) = (Vec::new(), f64::INFINITY);
    let (mut best, mut since) = (f64::INFINITY, 0);
    for _ in 0..CORRECTIONS {
        if !budget.spend(one) {
            return Reached::Lost;
        }
        let residuals = system.residuals(component, sequence, &state);
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
        let (rows, matrix) = system.matrix(component, (&state, &values), is_constraint);
        // Names are asked for where the rank is larger, and then certain.
        let rank = |uncertainty: f64| -> Option<Eliminated> {
            let task = Task { uncertainty, budget: Some(budget), ..Task::default() };
            let contracted = Contracted::of(&matrix, uncertainty);
            let order = component.order(&contracted)?;
            let outcome = contracted.eliminate(&matrix, &order, task);
            if outcome.rank <= here.rank || !outcome.is_decided() {
                return Some(outcome);
            }
            Some(named(&matrix, &contracted, &order, task, budget))
        };
        let is_there = worst < HOLDS;
        if is_there {
            if largest_of(&total) < MOVED * step {
                return Reached::Stuck;
            }
            let Some(outcome) = rank(BEYOND * worst).filter(|outcome| !outcome.exhausted) else {
                return Reached::Lost;
            };
            if outcome.rank <= here.rank {
                return Reached::There(Box::new(outcome), is_whole(here, motion, &total));
            }
        }
        let place = |row: &u32| component.rows.binary_search(row).ok();
        let right: Vec<f64> =
            rows.iter().map(|row| place(row).and_then(|at| residuals.get(at)).map_or(0.0, |x| -x)).collect();
        let Some(mut change) = solution(&matrix, component, right, here, by, budget) else {
            return Reached::Lost;
        };
        let largest = largest_of(&change);
        if !largest.is_finite() {
            return Reached::Lost;
        }
        if is_there && worst > before / 4.0 {
            let Some(outcome) = rank(BEYOND * worst.max(U).sqrt().max(largest)) else { return Reached::Lost };
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
        state = system.moved(component, &state, &change);
    }
    Reached::Lost
}

/// Whether none of the free motions was taken back.
fn is_whole(here: &Eliminated, motion: &[f64], total: &[f64]) -> bool {
    let of = |column: &u32| Some((motion.get(*column as usize)?.abs(), total.get(*column as usize)?.abs()));
    let free: Vec<(f64, f64)> = here.free.iter().filter_map(of).collect();
    let largest = free.iter().map(|(began, _)| *began).fold(0.0, f64::max);
    free.iter().all(|(began, now)| *began < BEGINS * largest || *now >= MOVED * began)
}

/// A solution of J δ = right; `None` where the matrix is too large for it.
fn solution(
    matrix: &Sparse,
    component: &ConnectedComponent,
    mut right: Vec<f64>,
    here: &Eliminated,
    by: Correction,
    budget: &Budget,
) -> Option<Vec<f64>> {
    if by == Correction::Least {
        let may = dense::is_small(matrix, SHORTEST) && budget.decompose(matrix.rows(), matrix.width());
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
    let order = component.order(&contracted)?;
    let outcome = contracted.eliminate(&gauged, &order, task);
    (!outcome.exhausted).then(|| outcome.solve(matrix.width(), |_| 0.0, false))
}

/// Of dependent rows, as many as are not elsewhere: those that are not named there, the last ones if there are more.
pub(crate) fn only_here(dependent: &[u32], elsewhere: &[u32]) -> Vec<u32> {
    let count = dependent.len().saturating_sub(elsewhere.len());
    let is_gone = |row: &&u32| elsewhere.binary_search(row).is_err();
    dependent.iter().rev().filter(is_gone).take(count).copied().collect()
}
