//! What is found of the parts of an assembly at one state, and of the whole.

use super::dense;
use super::eliminate::{Outcome, Sparse, Task, eliminate};
use super::system::{Origin, Part, Role, System};
use super::{Constraint, Gap, Position};
use crate::audit::bound::U;
use crate::catalog::COMPONENT;
use crate::evaluate::Source;
use rayon::prelude::*;

/// A singular value below this part of the largest that is not zero by rounding is decided by digits that decks do not have.
const DIGITS: f64 = 1e-7;
/// By so many rounding units an entry is off that was computed: directions, levers, and what a deck was written from.
const COMPUTED: f64 = 1e3;
/// By so many rounding units of itself a coordinate is off.
const ROUNDED: f64 = 4.0;
/// The size (the smaller of rows and columns) up to which singular values of a part are looked at at every state given, not only initially.
const EVERYWHERE: usize = 60;

/// What one part has at one state.
pub(super) struct Found {
    pub(super) constraints: Outcome,
    /// Rows of the matrix of constraints.
    pub(super) rows: Vec<u32>,
    /// With drives: rank beyond that of the constraints, and what is free.
    driven: Option<(Outcome, Vec<u32>)>,
    singular_values: Option<[f64; 2]>,
    /// Whether the singular values that count as zero are no larger than rounding makes them: by Weyl, no change moves one by more than its norm.
    zero_is_zero: bool,
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
        let digits = self.singular_values.is_none_or(|[nonzero, _]| nonzero > DIGITS);
        self.constraints.is_decided() && self.undriven().is_decided() && digits && self.zero_is_zero
    }

    /// The rank, and the number of motions that nothing drives.
    pub(super) fn numbers(&self) -> [usize; 2] {
        [self.constraints.rank, self.undriven().free.len()]
    }

    /// Dependent rows, of the system.
    pub(super) fn dependent(&self) -> Vec<u32> {
        self.constraints.dependent.iter().map(|row| self.rows[*row as usize]).collect()
    }

    /// Rows of the matrix of constraints whose independence, or dependence, is not certain.
    fn doubtful(&self) -> &[u32] {
        if !self.constraints.doubtful.is_empty() {
            return &self.constraints.doubtful;
        }
        let is_zero = !self.zero_is_zero || self.constraints.remains;
        if is_zero { self.constraints.widest.as_slice() } else { self.constraints.weakest.as_slice() }
    }
}

/// Looks at every part at one state, whose equations are satisfied but for `residuals` (by row of the system). Of those whose elimination would
/// cost too much, the columns of the front where that was.
pub(super) fn look(
    system: &System<'_>,
    values: &[f64],
    residuals: &[f64],
    keep: bool,
) -> Vec<Result<Found, usize>> {
    let of_part = |part: &Part| {
        let worst = part.rows.iter().filter_map(|row| residuals.get(*row as usize));
        let worst = super::largest(worst);
        let has_drives = part.rows.iter().any(|row| system.roles[*row as usize] == Role::Driven);
        let (rows, matrix) = system.matrix(part, values, |role| role != Role::Driven);
        let task = Task { uncertainty: 30.0 * worst, keep, right: None, most: part.most };
        let constraints = eliminate(&matrix, &part.order, task);
        if constraints.exhausted {
            return Err(constraints.front);
        }
        let driven = has_drives.then(|| {
            let (rows, matrix) = system.matrix(part, values, |_| true);
            (eliminate(&matrix, &part.order, task), rows)
        });
        if let Some((driven, _)) = driven.as_ref().filter(|(driven, _)| driven.exhausted) {
            return Err(driven.front);
        }
        let is_small = dense::is_small(&matrix, if keep { dense::LARGEST } else { EVERYWHERE });
        let values = if is_small { dense::singular_values(&matrix) } else { Vec::new() };
        let [computed, rounded] = matrix.changes();
        let allowed = U * (COMPUTED * computed + ROUNDED * rounded) + task.uncertainty * computed;
        let zero_is_zero = values.get(constraints.rank).is_none_or(|zero| *zero <= allowed);
        let singular_values = (!values.is_empty()).then_some(values).and_then(|values| {
            let largest = values.first().copied().filter(|largest| *largest > 0.0)?;
            let nonzero = values.get(constraints.rank.checked_sub(1)?)?;
            let zero = values.get(constraints.rank).copied().unwrap_or_default();
            Some([nonzero / largest, zero / largest])
        });
        let is_wanted = keep && is_small && !constraints.dependent.is_empty();
        let matrix = is_wanted.then_some(matrix);
        Ok(Found { constraints, rows, driven, singular_values, zero_is_zero, matrix })
    };
    system.parts.par_iter().map(of_part).collect()
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
    Position {
        state,
        rank: sum(|found| found.constraints.rank),
        mobility: sum(|found| found.constraints.free.len()),
        undriven: sum(|found| found.undriven().free.len()),
        redundant: sum(|found| found.constraints.dependent.len()).map(|redundant| redundant + fixed),
        undriven_undecided: known()
            .filter(|found| !found.is_decided())
            .map(|found| found.undriven().free.len())
            .sum(),
        overdriven: sum(Found::overdriven),
        decided: found.iter().all(|found| found.as_ref().is_ok_and(Found::is_decided)),
        finite: outcomes().all(|outcome| !outcome.overflows),
        gap: Gap { zero, nonzero, singular_values },
        doubtful: doubtful.take(100).collect(),
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
