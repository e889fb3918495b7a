//! Which constraints are redundant, and where?

use super::eliminate::{self, Task};
use super::found::{Found, constraint};
use super::moving::{SAMPLES, elsewhere};
use super::naming::named;
use super::system::{Part, Role, System, is_dear, request};
use super::{Constraint, Holds, Redundant, Unnamed, WhyUnnamed, dense, local, once};
use crate::evaluate::{Plan, Sequence};
use crate::scene::State;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Parts with no more degrees of freedom are moved, to judge where redundancies hold.
const MOVED: usize = 20_000;
/// Parts of which this many constraints are redundant say what from.
pub(super) const EXPLAINED: usize = 24;

/// Names the redundant constraints and judges where they are.
pub(super) fn redundant(
    system: &System<'_>,
    found: &[Result<Found, usize>],
    fixed: &[u32],
) -> Vec<Redundant> {
    let held = fixed.iter().map(|row| Redundant {
        constraint: constraint(system, *row),
        holds: Holds::Rigid,
        decided: true,
        held: true,
        from: Vec::new(),
    });
    let of_parts: Vec<Vec<Redundant>> = system
        .parts
        .par_iter()
        .zip(found)
        .map(|(part, found)| {
            let Ok(found) = found else { return Vec::new() };
            if found.constraints.dependent.is_empty() {
                return Vec::new();
            }
            let decided = found.is_decided();
            let dependent = &found.constraints.dependent;
            // Of what may not be redundant nothing is to be found elsewhere.
            let holds =
                if decided { judge(system, part, found) } else { vec![Holds::Unjudged; dependent.len()] };
            dependent
                .iter()
                .zip(holds)
                .filter(|(row, _)| found.may_depend(row))
                .map(|(row, holds)| Redundant {
                    constraint: constraint(system, found.rows[*row as usize]),
                    holds,
                    decided,
                    held: false,
                    from: made_of(system, found, *row),
                })
                .collect()
        })
        .collect();
    held.chain(of_parts.into_iter().flatten()).collect()
}

/// What a dependent row of a part follows from, where the part is small enough to say it.
pub(super) fn made_of(system: &System<'_>, found: &Found, row: u32) -> Vec<Constraint> {
    /// More are not said: nobody reads them.
    const MOST: usize = 200;
    let dependent = &found.constraints.dependent;
    if let Some((_, made)) = found.constraints.made_of.iter().find(|(of, _)| *of == row) {
        let named = if made.len() > MOST { &[] } else { made.as_slice() };
        return named.iter().map(|row| constraint(system, found.rows[*row as usize])).collect();
    }
    let Some(matrix) = found.matrix.as_ref().filter(|_| dependent.len() <= EXPLAINED) else {
        return Vec::new();
    };
    let made = dense::made_of(matrix, dependent, row);
    made.iter().map(|row| constraint(system, found.rows[*row as usize])).collect()
}

/// Of dependent rows, as many as are not elsewhere: those that are not named there, the last ones if there are more.
pub(super) fn only_here(dependent: &[u32], elsewhere: &[u32]) -> Vec<u32> {
    let count = dependent.len().saturating_sub(elsewhere.len());
    let is_gone = |row: &&u32| elsewhere.binary_search(row).is_err();
    dependent.iter().rev().filter(is_gone).take(count).copied().collect()
}

/// Where the redundancies of a part hold, in their order.
fn judge(system: &System<'_>, part: &Part, found: &Found) -> Vec<Holds> {
    let is_large =
        part.columns.len() > MOVED || found.constraints.fill > eliminate::KEPT || is_dear(found.cost);
    if is_large && found.constraints.mobility() > 0 {
        return once::judge(system, part, found)
            .unwrap_or_else(|| local::judge(system, part, found, &local::SIZES));
    }
    let whole = judge_whole(system, part, found);
    // Small parts were looked at to second order: nothing else is known of them.
    if found.matrix.is_some() || !whole.contains(&Holds::Unjudged) {
        return whole;
    }
    let others =
        once::judge(system, part, found).unwrap_or_else(|| local::judge(system, part, found, &local::SIZES));
    let of_both = |(whole, other): (Holds, Holds)| if whole == Holds::Unjudged { other } else { whole };
    whole.into_iter().zip(others).map(of_both).collect()
}

/// The same, of a part that is moved as a whole.
pub(super) fn judge_whole(system: &System<'_>, part: &Part, found: &Found) -> Vec<Holds> {
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
    let here = named(&matrix, part, Task { keep: true, ..Task::default() });
    if here.dependent != *dependent {
        return all(Holds::Unjudged);
    }
    elsewhere(&own, part, &sequence, &start, &here, SAMPLES)
}

/// Redundant constraints of parts of which not all are named.
pub(super) fn unnamed(found: &[Result<Found, usize>]) -> Option<Unnamed> {
    let all = || found.iter().flatten().map(|found| &found.constraints);
    let count = all().map(|outcome| outcome.redundant() - outcome.dependent.len()).sum();
    // Where nothing was eliminated there is no front.
    let is_dear = all().any(|outcome| !outcome.names_all() && outcome.front == 0);
    let why = if is_dear { WhyUnnamed::Dear } else { WhyUnnamed::Numbers };
    (count > 0).then_some(Unnamed { count, why })
}
