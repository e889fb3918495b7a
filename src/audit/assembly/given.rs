//! What holds at the states given? They are followed one after the other, for some constraints count turns, and those looked at that satisfy
//! the constraints. Where the rank or the motions are others than initially, they are named.

use super::found::{Found, constraint, look, position};
use super::modes::modes;
use super::redundant::made_of;
use super::system::System;
use super::{Assembly, Holds, LISTED, NotAssembled, Position, Redundant, largest};
use crate::evaluate::Sequence;
use crate::scene::State;
use std::collections::{BTreeMap, BTreeSet};

/// The residual (rad, or lengths of the connectors) beyond which a state does not satisfy the constraints, so that their rank says nothing.
const SATISFIED: f64 = 1e-4;
/// The work, in degrees of freedom times states, that given states may cost; beyond, some are left out, evenly.
const WORK: usize = 3_000_000;

/// Dependent rows by part; `None` where the rank of the part is not certain, which proves nothing of other states.
type Dependent = Vec<Option<Vec<u32>>>;

/// States, all of which are followed, and which of them are wanted.
type Wanted<'a> = (&'a [State], &'a dyn Fn(&State) -> bool);

/// Looks at those of the states given that are wanted.
pub(super) fn along(
    system: &System<'_>,
    (states, is_of): Wanted<'_>,
    initial: &[Result<Found, usize>],
    fixed: usize,
    assembly: &mut Assembly,
) {
    let size = (system.jacobian.columns() + system.origins.len()).max(1);
    let stride = (states.len() * size).div_ceil(WORK).max(1);
    let mut sequence = Sequence::new(system.model, system.plan);
    let mut values = Vec::new();
    let rows = |found: &Result<Found, usize>| {
        found.as_ref().ok().filter(|found| found.is_decided()).map(Found::dependent)
    };
    let mut least: Dependent = initial.iter().map(rows).collect();
    least.resize(system.parts.len(), None);
    let (mut all, mut listed): (Vec<(usize, Dependent)>, usize) = (Vec::new(), 0);
    for (index, state) in states.iter().enumerate() {
        let is_looked_at = is_of(state) && (index % stride == 0 || index + 1 == states.len());
        let residuals = if is_looked_at { system.all_residuals(&sequence, state) } else { Vec::new() };
        let number = state.number.unwrap_or(index as u64);
        if let Err(error) = sequence.assemble(state, &system.jacobian, &mut values) {
            assembly.not_assembled = Some(NotAssembled { state: Some(number), why: error.to_string() });
            break;
        }
        if !is_looked_at {
            continue;
        }
        let worst = largest(&residuals);
        if worst.is_nan() || worst > SATISFIED {
            assembly.off.push(number);
            continue;
        }
        let found = look(system, &values, &residuals, false);
        let mut position = position(system, Some(number), &found, fixed);
        let numbers = |found: &Result<Found, usize>| found.as_ref().ok().map(Found::numbers);
        position.differs = initial.iter().zip(&found).any(|(initial, now)| numbers(initial) != numbers(now));
        if position.differs && listed < LISTED {
            let kept = look(system, &values, &residuals, true);
            position.modes = modes(system, &kept);
            position.dependent = dependent(system, &kept);
            position.modes.truncate(LISTED - listed);
            listed += position.modes.len();
            position.dependent.truncate(LISTED - listed);
            listed += position.dependent.len();
        }
        let now: Dependent = found.iter().map(rows).collect();
        for (least, now) in least.iter_mut().zip(&now) {
            let is_less = |now: &Vec<u32>| least.as_ref().is_none_or(|least| now.len() < least.len());
            if let Some(now) = now.as_ref().filter(|now| is_less(now)) {
                *least = Some(now.clone());
            }
        }
        all.push((assembly.positions.len(), now));
        assembly.positions.push(position);
    }
    let throughout = throughout(initial, &assembly.redundant);
    compare(system, &least, &throughout, &all, assembly);
}

/// The redundant constraints at one state, which are not yet judged.
fn dependent(system: &System<'_>, found: &[Result<Found, usize>]) -> Vec<Redundant> {
    let of_part = |found: &Found| -> Vec<Redundant> {
        let decided = found.is_decided();
        let one = |row: &u32| Redundant {
            constraint: constraint(system, found.rows[*row as usize]),
            holds: Holds::Unjudged,
            decided,
            held: false,
            from: made_of(system, found, *row),
        };
        found.constraints.dependent.iter().take(LISTED).map(one).collect()
    };
    found.iter().flatten().flat_map(of_part).collect()
}

/// How many of the dependent rows of each part hold throughout, by what was judged initially.
fn throughout(initial: &[Result<Found, usize>], redundant: &[Redundant]) -> Vec<usize> {
    let counts =
        || initial.iter().map(|found| found.as_ref().map_or(0, |found| found.constraints.dependent.len()));
    // Those between nodes that are all fixed come first.
    let mut rest = redundant.get(redundant.len().saturating_sub(counts().sum())..).unwrap_or_default();
    counts()
        .map(|count| {
            let (of_part, others) = rest.split_at(count.min(rest.len()));
            rest = others;
            of_part.iter().filter(|one| matches!(one.holds, Holds::Throughout | Holds::Rigid)).count()
        })
        .collect()
}

/// What is redundant at one state and not where the fewest are, holds there only; the rest throughout, where initially as many do.
fn compare(
    system: &System<'_>,
    least: &Dependent,
    throughout: &[usize],
    all: &[(usize, Dependent)],
    assembly: &mut Assembly,
) {
    for (at, parts) in all {
        let Some(Position { state: Some(state), dependent, .. }) = assembly.positions.get_mut(*at) else {
            continue;
        };
        let mut of = BTreeMap::new();
        for (part, (rows, least)) in parts.iter().zip(least).enumerate() {
            let (Some(rows), Some(least)) = (rows, least) else { continue };
            let usual: BTreeSet<&u32> = least.iter().collect();
            let count = rows.len().saturating_sub(usual.len());
            let here: Vec<&u32> = rows.iter().filter(|row| !usual.contains(row)).take(count).collect();
            if assembly.redundant_at.len() < LISTED {
                let named = here.iter().map(|row| (*state, constraint(system, **row)));
                assembly.redundant_at.extend(named);
            }
            if dependent.is_empty() {
                continue;
            }
            let is_usual = throughout.get(part) == Some(&usual.len());
            let rest = if is_usual { Holds::Throughout } else { Holds::Unjudged };
            let holds = |row: &u32| if here.contains(&row) { Holds::Here } else { rest };
            of.extend(rows.iter().map(|row| (constraint(system, *row), holds(row))));
        }
        for one in dependent {
            one.holds = of.get(&one.constraint).copied().unwrap_or(Holds::Unjudged);
        }
    }
    assembly.redundant_at.truncate(LISTED);
}
