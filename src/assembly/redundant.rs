//! Which constraints are redundant, and where?

use crate::facts::{Constraint, Holds, Redundant, Role};
use crate::found::{Found, constraint};
use crate::matrix::budget::Budget;
use crate::matrix::contract::Contracted;
use crate::matrix::dense;
use crate::matrix::eliminate::{KEPT, Task};
use crate::matrix::naming::named;
use crate::moving::{SAMPLES, elsewhere};
use crate::system::{ConnectedComponent, System, request};
use pintle_model::evaluate::{Plan, Sequence};
use pintle_scene::State;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Parts with no more degrees of freedom are moved, to judge where redundancies hold.
const MOVED: usize = 20_000;
/// Parts of which this many constraints are redundant say what from.
pub const EXPLAINED: usize = 24;

/// Connected components that are looked at at once: what each may spend is known before.
const BATCH: usize = 16;
/// What a connected component may spend of what is left, whatever its size.
const SMALL: u64 = 100_000_000;

/// Names the redundant constraints and judges where they are, as far as what may be spent on it leads.
pub(crate) fn redundant(
    system: &System<'_>,
    found: &[Option<Found>],
    fixed: &[u32],
    budget: &Budget,
) -> Vec<Redundant> {
    let held = fixed.iter().map(|row| Redundant {
        constraint: constraint(system, *row),
        holds: Holds::Rigid,
        decided: true,
        held: true,
        from: Vec::new(),
    });
    let components: Vec<(&ConnectedComponent, &Found)> = system
        .components
        .iter()
        .zip(found)
        .filter_map(|(component, found)| Some((component, found.as_ref()?)))
        .filter(|(_, found)| !found.constraints.dependent.is_empty())
        .collect();
    let weight = |(component, _): &(&ConnectedComponent, &Found)| component.columns.len();
    let mut rest: usize = components.iter().map(weight).sum();
    let mut of_components: Vec<Redundant> = Vec::new();
    for batch in components.chunks(BATCH) {
        let one = |of: &(&ConnectedComponent, &Found)| {
            let own = budget.share([weight(of), rest], SMALL);
            (of_component(system, *of, &own), own)
        };
        for (named, own) in batch.par_iter().map(one).collect::<Vec<_>>() {
            budget.count(&own);
            of_components.extend(named);
        }
        rest -= batch.iter().map(weight).sum::<usize>();
    }
    held.chain(of_components).collect()
}

/// The same of a connected component.
fn of_component(
    system: &System<'_>,
    (component, found): (&ConnectedComponent, &Found),
    budget: &Budget,
) -> Vec<Redundant> {
    let decided = found.is_decided();
    let dependent = &found.constraints.dependent;
    // Of what may not be redundant nothing is to be found elsewhere.
    let holds = if decided {
        judge(system, component, found, budget)
    } else {
        vec![Holds::Unjudged; dependent.len()]
    };
    let all = dependent.iter().zip(holds).zip(made_of(system, found));
    all.filter(|((row, _), _)| found.may_depend(row))
        .map(|((row, holds), from)| Redundant {
            constraint: constraint(system, found.rows[*row as usize]),
            holds,
            decided,
            held: false,
            from,
        })
        .collect()
}

/// What each of the dependent rows of a connected component follows from, where the connected component is small enough to say it.
pub(crate) fn made_of(system: &System<'_>, found: &Found) -> Vec<Vec<Constraint>> {
    let dependent = &found.constraints.dependent;
    let matrix = found.matrix.as_ref().filter(|_| dependent.len() <= EXPLAINED);
    let by_size = matrix.map(|matrix| dense::made_of(matrix, dependent)).unwrap_or_default();
    let named = |rows: &[u32]| rows.iter().map(|row| constraint(system, found.rows[*row as usize])).collect();
    (0..dependent.len()).map(|at| by_size.get(at).map(|made| named(made)).unwrap_or_default()).collect()
}

/// Where the redundancies of a connected component hold, in their order: it is moved as a whole, by itself.
pub(crate) fn judge(
    system: &System<'_>,
    component: &ConnectedComponent,
    found: &Found,
    budget: &Budget,
) -> Vec<Holds> {
    let dependent = &found.constraints.dependent;
    let all = |holds| vec![holds; dependent.len()];
    if found.constraints.mobility() == 0 {
        return all(Holds::Rigid);
    }
    if component.columns.len() > MOVED || found.constraints.fill > KEPT {
        return all(Holds::Large);
    }
    // The connected component by itself: its connectors, constraints and nodes.
    let mut nodes = BTreeSet::new();
    for index in &component.connectors {
        nodes.extend(system.model.connectors[*index].nodes.iter().flatten());
    }
    for index in &component.mpcs {
        nodes.extend(&system.model.mpcs[*index].nodes);
    }
    for index in &component.relations {
        nodes.extend(&system.model.relations[*index].nodes);
    }
    let each = |indices: &[usize]| indices.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
    let [connectors, mpcs, relations] =
        [&component.connectors, &component.mpcs, &component.relations].map(|indices| each(indices));
    let plan = Plan { connectors, mpcs, relations, nodes, request: request() };
    let own = System::new(system.model, &plan, system.prescribed);
    let [component] = own.components.as_slice() else { return all(Holds::Unjudged) };
    let sequence = Sequence::new(system.model, &plan);
    let mut values = Vec::new();
    let start = State::default();
    if sequence.clone().assemble(&start, &own.jacobian, &mut values).is_err() {
        return all(Holds::Unjudged);
    }
    let (_, matrix) = own.matrix(component, (&start, &values), |role| role != Role::Driven);
    let contracted = Contracted::of(&matrix, 0.0);
    let task = Task { keep: true, budget: Some(budget), ..Task::default() };
    let Some(order) = component.order(&contracted) else { return all(Holds::Unjudged) };
    let here = named(&matrix, &contracted, &order, task, budget);
    if here.dependent != *dependent {
        return all(if budget.is_spent() { Holds::Spent } else { Holds::Unjudged });
    }
    elsewhere(&own, component, &sequence, &start, &here, SAMPLES, budget)
}

/// How many redundant constraints are counted, and not named.
pub(crate) fn unnamed(found: &[Option<Found>]) -> usize {
    let all = found.iter().flatten().map(|found| &found.constraints);
    all.map(|outcome| outcome.redundant() - outcome.dependent.len()).sum()
}
