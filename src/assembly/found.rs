//! What is found of the connected components of an assembly at one state, and of the whole.

use crate::facts::{Constraint, Gap, LISTED, Position, Role};
use crate::matrix::budget::Budget;
use crate::matrix::contract::Contracted;
use crate::matrix::dense;
use crate::matrix::eliminate::{Eliminated, Most, Task};
use crate::matrix::naming::named;
use crate::matrix::noise::{COMPUTED, ROUNDED};
use crate::matrix::sparse::{Sparse, largest};
use crate::system::{ConnectedComponent, Origin, System};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::scalar::U;
use pintle_model::evaluate::Source;
use pintle_scene::State;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Constraints hold to rounding: a hundred units u, say. At a singular position they allow √(100 u) = 1e-7 to second order, so that a singular value below
/// this part of the largest does not tell whether that is met.
const SECOND_ORDER: f64 = 1e-7;
/// Entries are taken for uncertain by so many times the largest residual of the constraints.
pub(crate) const TIMES: f64 = 30.0;
/// The size (the smaller of rows and columns) up to which singular values of a connected component are looked at at every state given, not only initially.
const EVERYWHERE: usize = 60;

/// What one connected component has at one state.
pub(crate) struct Found {
    pub(crate) constraints: Eliminated,
    /// Rows of the matrix of constraints.
    pub(crate) rows: Vec<u32>,
    /// With drives: rank beyond that of the constraints, and what is free.
    driven: Option<(Eliminated, Vec<u32>)>,
    singular_values: Option<[f64; 2]>,
    /// Whether the singular values that count as zero are no larger than rounding makes them: by Weyl, no change moves one by more than its norm.
    zero_is_zero: bool,
    /// Whether what is not zero is so whatever the digits are that the scene does not give.
    digits_suffice: bool,
    /// Rows of the matrix of constraints without derivative: what they constrain does not show.
    without_derivative: Vec<u32>,
    pub(crate) matrix: Option<Sparse>,
}

impl Found {
    pub(crate) fn undriven(&self) -> &Eliminated {
        self.driven.as_ref().map_or(&self.constraints, |(driven, _)| driven)
    }

    fn overdriven(&self) -> usize {
        let Some((driven, rows)) = &self.driven else { return 0 };
        (rows.len() - self.rows.len()).saturating_sub(driven.rank - self.constraints.rank.min(driven.rank))
    }

    pub(crate) fn is_decided(&self) -> bool {
        let is_beyond = self.singular_values.is_none_or(|[nonzero, _]| nonzero > SECOND_ORDER);
        self.constraints.is_decided()
            && self.undriven().is_decided()
            && is_beyond
            && self.zero_is_zero
            && self.digits_suffice
            && self.without_derivative.is_empty()
    }

    /// Whether the rank is certain, and all redundant rows are named.
    pub(crate) fn names_certainly(&self) -> bool {
        self.is_decided() && self.constraints.names_all()
    }

    /// The rank, and the number of motions that nothing drives.
    pub(crate) fn numbers(&self) -> [usize; 2] {
        [self.constraints.rank, self.undriven().mobility()]
    }

    /// Dependent rows, of the system.
    pub(crate) fn dependent(&self) -> Vec<u32> {
        self.constraints.dependent.iter().map(|row| self.rows[*row as usize]).collect()
    }

    /// Whether a dependent row may be called so: one without derivative may not.
    pub(crate) fn may_depend(&self, row: &u32) -> bool {
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
fn allowed(matrix: &Sparse, uncertainty: f64) -> f64 {
    let [computed, rounded] = matrix.changes();
    U * (COMPUTED * computed + ROUNDED * rounded) + uncertainty * computed
}

/// The rank of the matrix of a connected component, with what may be spent on names; `None` where its elimination would take too much.
fn outcome(component: &ConnectedComponent, matrix: &Sparse, task: Task<'_>) -> Option<Eliminated> {
    let contracted = Contracted::of(matrix, task.uncertainty);
    let order = component.order(&contracted)?;
    let outcome = named(matrix, &contracted, &order, task, &Budget::of(component.columns.len()));
    (!outcome.exhausted).then_some(outcome)
}

/// Parts of no more columns are looked at by as many threads as there are.
const TOGETHER: usize = 3000;
/// Entries that the elimination of any connected component may take, whatever others took before.
const CHEAP: usize = 10_000_000;

/// Looks at every connected component at one state, whose equations are satisfied but for `residuals` (by row of the system). Some rows have no
/// derivative there. Components whose elimination would take too much are left out.
pub(crate) fn look(
    system: &System<'_>,
    (state, values): (&State, &[f64]),
    (residuals, without_derivative): (&[f64], &[u32]),
    keep: bool,
) -> Vec<Option<Found>> {
    let worked = AtomicUsize::new(0);
    let of_component = |component: &ConnectedComponent, most: Most| {
        let worst = component.rows.iter().filter_map(|row| residuals.get(*row as usize));
        let worst = largest(worst);
        let has_drives = component.rows.iter().any(|row| system.roles[*row as usize] == Role::Driven);
        let (rows, matrix) = system.matrix(component, (state, values), |role| role != Role::Driven);
        let task = Task { uncertainty: TIMES * worst, keep, most, ..Task::default() };
        let outcome = |matrix: &Sparse| -> Option<Eliminated> {
            let found = outcome(component, matrix, task)?;
            worked.fetch_add(found.work, Ordering::Relaxed);
            Some(found)
        };
        let constraints = outcome(&matrix)?;
        let driven = match has_drives.then(|| system.matrix(component, (state, values), |_| true)) {
            Some((rows, matrix)) => Some((outcome(&matrix)?, rows)),
            None => None,
        };
        let is_small = dense::is_small(&matrix, if keep { dense::LARGEST } else { EVERYWHERE });
        let values = if is_small { dense::singular_values(&matrix) } else { Vec::new() };
        let allowed = allowed(&matrix, task.uncertainty);
        let zero_is_zero = values.get(constraints.rank).is_none_or(|zero| *zero <= allowed);
        let largest_value = values.first().copied();
        let singular_values = (!values.is_empty()).then_some(values).and_then(|values| {
            let largest = values.first().copied().filter(|largest| *largest > 0.0)?;
            let nonzero = values.get(constraints.rank.checked_sub(1)?)?;
            let zero = values.get(constraints.rank).copied().unwrap_or_default();
            Some([nonzero / largest, zero / largest])
        });
        let most_open = (0..matrix.rows()).map(|row| matrix.openness(row)).fold(0.0, f64::max);
        let digits_suffice = match (singular_values, largest_value, constraints.rank.checked_sub(1)) {
            _ if most_open == 0.0 => true,
            (_, _, None) => true,
            (Some([nonzero, _]), Some(largest), Some(at)) => {
                dense::openness(&matrix, at).is_some_and(|open| nonzero * largest > open)
            }
            // Of larger ones by the relative change that makes the smallest pivot zero.
            _ => constraints.gap[1] > most_open,
        };
        let without_derivative: Vec<u32> = (0..)
            .zip(&rows)
            .filter(|(_, row)| without_derivative.binary_search(row).is_ok())
            .map(|(at, _)| at)
            .collect();
        let is_wanted = keep && is_small && !constraints.dependent.is_empty();
        let matrix = is_wanted.then_some(matrix);
        Some(Found {
            constraints,
            rows,
            driven,
            singular_values,
            zero_is_zero,
            digits_suffice,
            without_derivative,
            matrix,
        })
    };
    let weight = |component: &ConnectedComponent| component.columns.len();
    let of_small = |component: &ConnectedComponent| {
        (weight(component) <= TOGETHER).then(|| of_component(component, component.most))
    };
    let small: Vec<_> = system.components.par_iter().map(of_small).collect();
    // What is large is looked at one after the other, so that the limits of memory and of work of one are those of all.
    let of_large = |component: &ConnectedComponent| {
        let left = Most::default().work.saturating_sub(worked.load(Ordering::Relaxed)).max(CHEAP);
        let most = Most { work: component.most.work.min(left), ..component.most };
        of_component(component, most)
    };
    small
        .into_iter()
        .zip(&system.components)
        .map(|(found, component)| found.unwrap_or_else(|| of_large(component)))
        .collect()
}

/// The whole at one state, from its connected components and the number of constraints between nodes that are all fixed.
pub(crate) fn position(
    system: &System<'_>,
    state: Option<u64>,
    found: &[Option<Found>],
    fixed: usize,
) -> Position {
    // Of connected components that were not looked at nothing is known, and so neither of the whole.
    let sum =
        |of: fn(&Found) -> usize| found.iter().map(|found| found.as_ref().map(of)).sum::<Option<usize>>();
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
        decided: found.iter().all(|found| found.as_ref().is_some_and(Found::is_decided)),
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
pub(crate) fn constraint(system: &System<'_>, row: u32) -> Constraint {
    let role = system.roles[row as usize];
    let none = Constraint {
        element: None,
        mpc: None,
        index: None,
        joined: None,
        node: None,
        component: String::new(),
        role,
    };
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
            Source::Relation(index) => {
                let element = &system.model.relations[index];
                let rows = element.relation.rows();
                let component = rows.get(equation.component).map_or("", |(name, _)| *name).to_string();
                let joined = Some((element.span, element.nodes.clone()));
                let index = Some(system.model.mpcs.len() + index);
                Constraint { mpc: Some(element.title()), index, joined, component, ..none }
            }
        },
    }
}

/// Drives that act on what is determined already, and the other drives of the same components.
pub(crate) fn overdriven(system: &System<'_>, found: &[Option<Found>]) -> (Vec<Constraint>, Vec<Constraint>) {
    let (mut named, mut besides) = (Vec::new(), Vec::new());
    for found in found.iter().flatten() {
        let Some((driven, rows)) = found.driven.as_ref().filter(|_| found.overdriven() > 0) else { continue };
        let is_drive = |row: &u32| system.roles[*row as usize] == Role::Driven;
        let dependent = driven.dependent.iter().map(|row| rows[*row as usize]).filter(is_drive);
        let mut of_component: Vec<u32> = dependent.collect();
        if of_component.is_empty() {
            of_component = rows.iter().copied().filter(is_drive).collect();
        }
        let others = rows.iter().copied().filter(is_drive).filter(|row| !of_component.contains(row));
        besides.extend(others.take(LISTED).map(|row| constraint(system, row)));
        named.extend(of_component.into_iter().map(|row| constraint(system, row)));
    }
    named.extend(
        system
            .fixed_rows
            .iter()
            .filter(|row| system.roles[**row as usize] == Role::Driven)
            .map(|row| constraint(system, *row)),
    );
    (named, besides)
}
