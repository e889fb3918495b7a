//! What is found of the parts of an assembly at one state, and of the whole.

use super::budget::Budget;
use super::contract::Contracted;
use super::dense;
use super::eliminate::{Most, Outcome, Sparse, Task};
use super::krylov;
use super::naming::{last, named_of};
use super::system::{Origin, Part, Role, System, is_dear, is_named};
use super::{Constraint, Gap, Position};
use crate::audit::bound::U;
use crate::catalog::COMPONENT;
use crate::evaluate::Source;
use crate::scene::State;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Constraints hold to rounding: a hundred units u, say. At a singular position they allow √(100 u) = 1e-7 to second order, so that a singular value below
/// this part of the largest does not tell whether that is met.
pub(super) const SECOND_ORDER: f64 = 1e-7;
/// By so many rounding units an entry is off that was computed: directions, levers, and what a deck was written from.
pub(super) const COMPUTED: f64 = 1e3;
/// Entries are taken for uncertain by so many times the largest residual of the constraints.
pub(super) const TIMES: f64 = 30.0;
/// By so many rounding units of itself a coordinate is off.
pub(super) const ROUNDED: f64 = 4.0;
/// The size (the smaller of rows and columns) up to which singular values of a part are looked at at every state given, not only initially.
const EVERYWHERE: usize = 60;

/// What one part has at one state.
pub(super) struct Found {
    pub(super) constraints: Outcome,
    /// What its elimination is predicted to cost.
    pub(super) cost: f64,
    /// Rows of the matrix of constraints.
    pub(super) rows: Vec<u32>,
    /// With drives: rank beyond that of the constraints, and what is free.
    driven: Option<(Outcome, Vec<u32>)>,
    singular_values: Option<[f64; 2]>,
    /// Whether the singular values that count as zero are no larger than rounding makes them: by Weyl, no change moves one by more than its norm.
    zero_is_zero: bool,
    /// Whether what is not zero is so whatever the digits are that the scene does not give.
    digits_suffice: bool,
    /// Rows of the matrix of constraints without derivative: what they constrain does not show.
    without_derivative: Vec<u32>,
    pub(super) matrix: Option<Sparse>,
}

impl Found {
    pub(super) fn undriven(&self) -> &Outcome {
        self.driven.as_ref().map_or(&self.constraints, |(driven, _)| driven)
    }

    fn overdriven(&self) -> usize {
        let Some((driven, rows)) = &self.driven else { return 0 };
        (rows.len() - self.rows.len()).saturating_sub(driven.rank - self.constraints.rank.min(driven.rank))
    }

    pub(super) fn is_decided(&self) -> bool {
        let is_beyond = self.singular_values.is_none_or(|[nonzero, _]| nonzero > SECOND_ORDER);
        self.constraints.is_decided()
            && self.undriven().is_decided()
            && is_beyond
            && self.zero_is_zero
            && self.digits_suffice
            && self.without_derivative.is_empty()
    }

    /// Whether the rank is certain, and all redundant rows are named.
    pub(super) fn names_certainly(&self) -> bool {
        self.is_decided() && self.constraints.names_all()
    }

    /// The rank, and the number of motions that nothing drives.
    pub(super) fn numbers(&self) -> [usize; 2] {
        [self.constraints.rank, self.undriven().mobility()]
    }

    /// Dependent rows, of the system.
    pub(super) fn dependent(&self) -> Vec<u32> {
        self.constraints.dependent.iter().map(|row| self.rows[*row as usize]).collect()
    }

    /// Whether a dependent row may be called so: one without derivative may not.
    pub(super) fn may_depend(&self, row: &u32) -> bool {
        !self.without_derivative.contains(row)
    }

    /// The number of redundant constraints.
    fn redundant(&self) -> usize {
        let without = self.constraints.dependent.iter().filter(|row| !self.may_depend(row)).count();
        self.constraints.redundant() - without
    }

    /// Rows of the matrix of constraints whose independence, or dependence, is not certain.
    fn doubtful(&self) -> &[u32] {
        if !self.without_derivative.is_empty() {
            return &self.without_derivative;
        }
        if !self.constraints.doubtful.is_empty() {
            return &self.constraints.doubtful;
        }
        let is_zero = !self.zero_is_zero || self.constraints.remains;
        if is_zero { self.constraints.widest.as_slice() } else { self.constraints.weakest.as_slice() }
    }
}

/// The norm of what rounding, and a relative uncertainty of the entries, can change of a matrix.
pub(super) fn allowed(matrix: &Sparse, uncertainty: f64) -> f64 {
    let [computed, rounded] = matrix.changes();
    U * (COMPUTED * computed + ROUNDED * rounded) + uncertainty * computed
}

/// The rank of the matrix of a part, and what its elimination is predicted to cost: by elimination, but where that is dear first by products with it. With
/// what may be spent on names.
fn outcome(part: &Part, matrix: &Sparse, task: Task<'_>, budget: &Budget) -> (Outcome, f64) {
    let contracted = Contracted::of(matrix, task.uncertainty);
    let orders = part.orders(&contracted);
    let cost = part.cost.unwrap_or(orders.cost);
    let by_products =
        if is_dear(cost) { krylov::rank(matrix, task.uncertainty, cost / 4.0, budget) } else { None };
    let Some(mut outcome) = by_products else {
        return (named_of(matrix, &contracted, &orders, task, budget), cost);
    };
    if !outcome.names_all() && is_named(cost) {
        match last(matrix, &contracted, &orders, &outcome, budget) {
            Some(dependent) => {
                outcome.dependent = dependent;
                outcome.made_of.clear();
            }
            None => outcome.names_spent = budget.exceeded(),
        }
    }
    (outcome, cost)
}

/// Parts of no more columns are looked at by as many threads as there are.
const TOGETHER: usize = 3000;
/// What may be spent on the names of a part, whatever its size: as much as a matrix of [`dense::LARGEST`] takes.
const LEAST: u64 = 2_000_000;
/// Entries that the elimination of any part may take, whatever others took before.
const CHEAP: usize = 10_000_000;

/// Looks at every part at one state, whose equations are satisfied but for `residuals` (by row of the system), and of which these rows have no
/// derivative there. Of those whose elimination would
/// cost too much, the columns of the front where that was.
pub(super) fn look(
    system: &System<'_>,
    (state, values): (&State, &[f64]),
    (residuals, without_derivative): (&[f64], &[u32]),
    keep: bool,
) -> Vec<Result<Found, usize>> {
    let worked = AtomicUsize::new(0);
    let of_part = |part: &Part, names: Budget, most: Most| {
        let worst = part.rows.iter().filter_map(|row| residuals.get(*row as usize));
        let worst = super::largest(worst);
        let has_drives = part.rows.iter().any(|row| system.roles[*row as usize] == Role::Driven);
        let (rows, matrix) = system.matrix(part, (state, values), |role| role != Role::Driven);
        let task = Task { uncertainty: TIMES * worst, keep, most, ..Task::default() };
        let budget = part.names.map_or(names, Budget::new);
        let outcome = |matrix: &Sparse| {
            let found = outcome(part, matrix, task, &budget);
            worked.fetch_add(found.0.work, Ordering::Relaxed);
            found
        };
        let (constraints, cost) = outcome(&matrix);
        if constraints.exhausted {
            return Err(constraints.front);
        }
        let driven = has_drives.then(|| {
            let (rows, matrix) = system.matrix(part, (state, values), |_| true);
            (outcome(&matrix).0, rows)
        });
        if let Some((driven, _)) = driven.as_ref().filter(|(driven, _)| driven.exhausted) {
            return Err(driven.front);
        }
        let is_small = dense::is_small(&matrix, if keep { dense::LARGEST } else { EVERYWHERE });
        let values = if is_small { dense::singular_values(&matrix) } else { Vec::new() };
        let allowed = allowed(&matrix, task.uncertainty);
        let zero_is_zero = values.get(constraints.rank).is_none_or(|zero| *zero <= allowed);
        let largest_value = values.first().copied();
        let of_small = (!values.is_empty()).then_some(values).and_then(|values| {
            let largest = values.first().copied().filter(|largest| *largest > 0.0)?;
            let nonzero = values.get(constraints.rank.checked_sub(1)?)?;
            let zero = values.get(constraints.rank).copied().unwrap_or_default();
            Some([nonzero / largest, zero / largest])
        });
        let singular_values = of_small.or(constraints.singular_values);
        let most_open = (0..matrix.rows()).map(|row| matrix.openness(row)).fold(0.0, f64::max);
        let digits_suffice = match (of_small, largest_value, constraints.rank.checked_sub(1)) {
            _ if most_open == 0.0 => true,
            (_, _, None) => true,
            (Some([nonzero, _]), Some(largest), Some(at)) => {
                dense::openness(&matrix, at).is_some_and(|open| nonzero * largest > open)
            }
            // Of larger ones by the relative change that makes the smallest pivot zero.
            _ => {
                let nonzero = singular_values
                    .map_or(constraints.gap[1], |[nonzero, _]| nonzero.min(constraints.gap[1]));
                nonzero > most_open
            }
        };
        let without_derivative: Vec<u32> = (0..)
            .zip(&rows)
            .filter(|(_, row)| without_derivative.binary_search(row).is_ok())
            .map(|(at, _)| at)
            .collect();
        let is_wanted = keep && is_small && !constraints.dependent.is_empty();
        let matrix = is_wanted.then_some(matrix);
        Ok(Found {
            constraints,
            cost,
            rows,
            driven,
            singular_values,
            zero_is_zero,
            digits_suffice,
            without_derivative,
            matrix,
        })
    };
    let weight = |part: &Part| part.columns.len();
    let all = system.parts.iter().map(weight).sum();
    let budget = Budget::of(all);
    let of_small = |part: &Part| {
        (weight(part) <= TOGETHER).then(|| of_part(part, budget.share([weight(part), all], LEAST), part.most))
    };
    let small: Vec<_> = system.parts.par_iter().map(of_small).collect();
    // What is large is looked at one after the other, so that the limits of memory and of work of one are those of all.
    let of_large = |part: &Part| {
        let left = Most::default().work.saturating_sub(worked.load(Ordering::Relaxed)).max(CHEAP);
        let most = Most { work: part.most.work.min(left), ..part.most };
        of_part(part, budget.share([weight(part), all], LEAST), most)
    };
    small
        .into_iter()
        .zip(&system.parts)
        .map(|(found, part)| found.unwrap_or_else(|| of_large(part)))
        .collect()
}

/// The whole at one state, from its parts and the number of constraints between nodes that are all fixed.
pub(super) fn position(
    system: &System<'_>,
    state: Option<u64>,
    found: &[Result<Found, usize>],
    fixed: usize,
) -> Position {
    // Of parts that were not looked at nothing is known, and so neither of the whole.
    let sum = |of: fn(&Found) -> usize| {
        found.iter().map(|found| found.as_ref().ok().map(of)).sum::<Option<usize>>()
    };
    let known = || found.iter().flatten();
    let outcomes = || known().flat_map(|found| [&found.constraints, found.undriven()]);
    let zero = outcomes().map(|outcome| outcome.gap[0]).fold(0.0, f64::max);
    let nonzero = outcomes().map(|outcome| outcome.gap[1]).fold(f64::INFINITY, f64::min);
    let values = known().filter_map(|found| found.singular_values);
    let singular_values = values.reduce(|x, y| [x[0].min(y[0]), x[1].max(y[1])]);
    let doubtful = known()
        .filter(|found| !found.is_decided())
        .flat_map(|found| found.doubtful().iter().map(|row| constraint(system, found.rows[*row as usize])));
    let named = |found: &Found| -> Vec<Constraint> {
        found.without_derivative.iter().map(|row| constraint(system, found.rows[*row as usize])).collect()
    };
    let without_derivative = known().flat_map(named);
    Position {
        state,
        rank: sum(|found| found.constraints.rank),
        mobility: sum(|found| found.constraints.mobility()),
        undriven: sum(|found| found.undriven().mobility()),
        redundant: sum(Found::redundant).map(|redundant| redundant + fixed),
        undriven_undecided: known()
            .filter(|found| !found.is_decided())
            .map(|found| found.undriven().mobility())
            .sum(),
        overdriven: sum(Found::overdriven),
        decided: found.iter().all(|found| found.as_ref().is_ok_and(Found::is_decided)),
        finite: outcomes().all(|outcome| !outcome.overflows),
        gap: Gap { zero, nonzero, singular_values },
        doubtful: doubtful.take(100).collect(),
        without_derivative: without_derivative.take(100).collect(),
        differs: false,
        dependent: Vec::new(),
        modes: Vec::new(),
    }
}

/// The name of a row of a system.
pub(super) fn constraint(system: &System<'_>, row: u32) -> Constraint {
    let role = system.roles[row as usize];
    let none =
        Constraint { element: None, mpc: None, index: None, node: None, component: String::new(), role };
    match system.origins[row as usize] {
        Origin::Boundary(freedom) => {
            Constraint { node: Some(freedom.node), component: freedom.number.to_string(), ..none }
        }
        Origin::Equation(equation) => match equation.source {
            Source::Connector(index) => Constraint {
                element: Some(system.model.connectors[index].label),
                component: COMPONENT[equation.component].to_string(),
                ..none
            },
            Source::Mpc(index) => {
                let mpc = &system.model.mpcs[index];
                let component = mpc.constraint.kind().row_name(equation.component).to_string();
                Constraint { mpc: Some(mpc.title()), index: Some(index), component, ..none }
            }
        },
    }
}

/// Drives that act on what is determined already.
pub(super) fn overdriven(system: &System<'_>, found: &[Result<Found, usize>]) -> Vec<Constraint> {
    let mut named = Vec::new();
    for found in found.iter().flatten() {
        let Some((driven, rows)) = found.driven.as_ref().filter(|_| found.overdriven() > 0) else { continue };
        let is_drive = |row: &u32| system.roles[*row as usize] == Role::Driven;
        let dependent = driven.dependent.iter().map(|row| rows[*row as usize]).filter(is_drive);
        let mut of_part: Vec<u32> = dependent.collect();
        if of_part.is_empty() {
            of_part = rows.iter().copied().filter(is_drive).collect();
        }
        named.extend(of_part.into_iter().map(|row| constraint(system, row)));
    }
    named.extend(
        system
            .fixed_rows
            .iter()
            .filter(|row| system.roles[**row as usize] == Role::Driven)
            .map(|row| constraint(system, *row)),
    );
    named
}
