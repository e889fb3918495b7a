//! Which constraints are redundant, and where?

use super::budget::Budget;
use super::eliminate::{self, Task};
use super::found::{Found, constraint};
use super::moving::{SAMPLES, elsewhere};
use super::naming::named;
use super::system::{Part, Role, System, is_dear, request};
use super::{Constraint, Holds, Redundant, Spent, Unnamed, WhyUnnamed, dense, local, once};
use crate::evaluate::{Plan, Sequence};
use crate::scene::State;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Parts with no more degrees of freedom are moved, to judge where redundancies hold.
const MOVED: usize = 20_000;
/// Parts of which this many constraints are redundant say what from.
pub(super) const EXPLAINED: usize = 24;

/// Parts that are looked at at once: what each may spend is known before.
const BATCH: usize = 16;
/// What a part may spend of what is left, whatever its size.
const SMALL: u64 = 100_000_000;

/// Names the redundant constraints and judges where they are, as far as what may be spent on it leads.
pub(super) fn redundant(
    system: &System<'_>,
    found: &[Result<Found, usize>],
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
    let parts: Vec<(&Part, &Found)> = system
        .parts
        .iter()
        .zip(found)
        .filter_map(|(part, found)| Some((part, found.as_ref().ok()?)))
        .filter(|(_, found)| !found.constraints.dependent.is_empty())
        .collect();
    let weight = |(part, _): &(&Part, &Found)| part.columns.len();
    let mut rest: usize = parts.iter().map(weight).sum();
    let mut of_parts: Vec<Redundant> = Vec::new();
    for batch in parts.chunks(BATCH) {
        let one = |of: &(&Part, &Found)| {
            let own = budget.share([weight(of), rest], SMALL);
            (of_part(system, *of, &own), own)
        };
        for (named, own) in batch.par_iter().map(one).collect::<Vec<_>>() {
            budget.count(&own);
            of_parts.extend(named);
        }
        rest -= batch.iter().map(weight).sum::<usize>();
    }
    held.chain(of_parts).collect()
}

/// The same of a part.
fn of_part(system: &System<'_>, (part, found): (&Part, &Found), budget: &Budget) -> Vec<Redundant> {
    let decided = found.is_decided();
    let dependent = &found.constraints.dependent;
    // Of what may not be redundant nothing is to be found elsewhere.
    let holds =
        if decided { judge(system, part, found, budget) } else { vec![Holds::Unjudged; dependent.len()] };
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

/// What each of the dependent rows of a part follows from, where the part is small enough to say it.
pub(super) fn made_of(system: &System<'_>, found: &Found) -> Vec<Vec<Constraint>> {
    /// More are not said: nobody reads them.
    const MOST: usize = 200;
    let dependent = &found.constraints.dependent;
    let matrix = found.matrix.as_ref().filter(|_| dependent.len() <= EXPLAINED);
    let by_size = matrix.map(|matrix| dense::made_of(matrix, dependent)).unwrap_or_default();
    let named = |rows: &[u32]| rows.iter().map(|row| constraint(system, found.rows[*row as usize])).collect();
    let one = |(at, row): (usize, &u32)| match found.constraints.made_of.iter().find(|(of, _)| of == row) {
        Some((_, made)) if made.len() > MOST => Vec::new(),
        Some((_, made)) => named(made),
        None => by_size.get(at).map(|made| named(made)).unwrap_or_default(),
    };
    dependent.iter().enumerate().map(one).collect()
}

/// Of dependent rows, as many as are not elsewhere: those that are not named there, the last ones if there are more.
pub(super) fn only_here(dependent: &[u32], elsewhere: &[u32]) -> Vec<u32> {
    let count = dependent.len().saturating_sub(elsewhere.len());
    let is_gone = |row: &&u32| elsewhere.binary_search(row).is_err();
    dependent.iter().rev().filter(is_gone).take(count).copied().collect()
}

/// Where the redundancies of a part hold, in their order.
fn judge(system: &System<'_>, part: &Part, found: &Found, budget: &Budget) -> Vec<Holds> {
    // Once for all free motions, and then by neighbourhoods, which have what is left.
    let otherwise = || {
        let own = budget.share([3, 4], 0);
        let once = once::judge(system, part, found, &own);
        budget.count(&own);
        once.unwrap_or_else(|| local::judge(system, part, found, &local::SIZES, budget))
    };
    let is_large =
        part.columns.len() > MOVED || found.constraints.fill > eliminate::KEPT || is_dear(found.cost);
    if is_large && found.constraints.mobility() > 0 {
        return otherwise();
    }
    // Small parts are looked at to second order: nothing else is known of them.
    let own = budget.share([1, if found.matrix.is_some() { 1 } else { 2 }], 0);
    let whole = judge_whole(system, part, found, &own);
    budget.count(&own);
    let is_open = |holds: &Holds| matches!(holds, Holds::Unjudged | Holds::Spent);
    if found.matrix.is_some() || !whole.iter().any(is_open) {
        return whole;
    }
    let of_both = |(whole, other)| if is_open(&whole) { other } else { whole };
    whole.into_iter().zip(otherwise()).map(of_both).collect()
}

/// The same, of a part that is moved as a whole.
pub(super) fn judge_whole(system: &System<'_>, part: &Part, found: &Found, budget: &Budget) -> Vec<Holds> {
    let dependent = &found.constraints.dependent;
    let all = |holds| vec![holds; dependent.len()];
    if found.constraints.mobility() == 0 {
        return all(Holds::Rigid);
    }
    // The part by itself: its connectors, constraints and nodes.
    let mut nodes = BTreeSet::new();
    for index in &part.connectors {
        nodes.extend(system.model.connectors[*index].nodes.iter().flatten());
    }
    for index in &part.mpcs {
        nodes.extend(&system.model.mpcs[*index].nodes);
    }
    let connectors = part.connectors.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
    let mpcs = part.mpcs.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
    let plan = Plan { connectors, mpcs, nodes, request: request() };
    let own = System::new(system.model, &plan, system.prescribed);
    let [part] = own.parts.as_slice() else { return all(Holds::Unjudged) };
    let sequence = Sequence::new(system.model, &plan);
    let mut values = Vec::new();
    let start = State::default();
    if sequence.clone().assemble(&start, &own.jacobian, &mut values).is_err() {
        return all(Holds::Unjudged);
    }
    let (_, matrix) = own.matrix(part, (&start, &values), |role| role != Role::Driven);
    let here = named(&matrix, part, Task { keep: true, budget: Some(budget), ..Task::default() });
    if here.dependent != *dependent {
        return all(if budget.is_spent() { Holds::Spent } else { Holds::Unjudged });
    }
    elsewhere(&own, part, &sequence, &start, &here, SAMPLES, budget)
}

/// Redundant constraints of parts of which not all are named.
pub(super) fn unnamed(found: &[Result<Found, usize>]) -> Option<Unnamed> {
    let all = || found.iter().flatten().map(|found| &found.constraints);
    let count = all().map(|outcome| outcome.redundant() - outcome.dependent.len()).sum();
    // Where nothing was eliminated there is no front.
    let is_dear = all().any(|outcome| !outcome.names_all() && outcome.front == 0);
    let add = |x: Spent, y: Spent| Spent { operations: x.operations + y.operations, most: x.most + y.most };
    let spent = all().filter_map(|outcome| outcome.names_spent).reduce(add);
    let why = if spent.is_some() {
        WhyUnnamed::Spent
    } else if is_dear {
        WhyUnnamed::Dear
    } else {
        WhyUnnamed::Numbers
    };
    (count > 0).then_some(Unnamed { count, why, spent })
}
