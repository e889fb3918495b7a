//! What holds at the states given? They are followed one after the other, for some constraints count turns, and those looked at that satisfy
//! the constraints. Where the rank or the motions are others than initially, they are named.

use crate::facts::{Assembly, Constraint, Holds, LISTED, NotAssembled, Position, Redundant};
use crate::found::{Found, TIMES, constraint, look, position};
use crate::matrix::sparse::largest;
use crate::modes::modes;
use crate::redundant::made_of;
use crate::system::System;
use pintle_kinematics::scalar::U;
use pintle_model::evaluate::Sequence;
use pintle_scene::State;
use std::collections::{BTreeMap, BTreeSet};

/// The residual (rad, or lengths of the connectors) beyond which a state does not satisfy the constraints, so that their rank says nothing.
const SATISFIED: f64 = 1e-4;
/// The residual up to which constraints hold to rounding, so that a rank proves something of other states.
const PROVES: f64 = 1e-12;
/// At a singular position constraints that hold to ε allow motions of √ε: a rank that is larger by less than this multiple of it is not certain to be so.
const SECOND_ORDER: f64 = 10.0;
/// The work, in degrees of freedom times states, that given states may cost; beyond, some are left out, evenly.
const WORK: usize = 3_000_000;

/// Dependent rows by connected component; `None` where the rank of the connected component is not certain, which proves nothing of other states.
type Dependent = Vec<Option<Vec<u32>>>;

/// States, all of which are followed, and which of them are wanted.
type Wanted<'a> = (&'a [State], &'a dyn Fn(&State) -> bool);

/// Looks at those of the states given that are wanted.
pub(crate) fn along(
    system: &System<'_>,
    (states, is_of): Wanted<'_>,
    initial: &[Option<Found>],
    fixed: usize,
    assembly: &mut Assembly,
) {
    let size = (system.jacobian.columns() + system.origins.len()).max(1);
    let stride = (states.len() * size).div_ceil(WORK).max(1);
    let mut sequence = Sequence::new(system.model, system.plan);
    let mut values = Vec::new();
    let rows =
        |found: &Option<Found>| found.as_ref().filter(|found| found.names_certainly()).map(Found::dependent);
    let mut least: Dependent = initial.iter().map(rows).collect();
    least.resize(system.components.len(), None);
    let mut proven = vec![true; least.len()];
    let (mut all, mut listed): (Vec<(usize, Dependent)>, usize) = (Vec::new(), 0);
    for (index, state) in states.iter().enumerate() {
        let is_looked_at = is_of(state) && (index % stride == 0 || index + 1 == states.len());
        let residuals = if is_looked_at { system.all_residuals(&sequence, state) } else { Vec::new() };
        let without_derivative =
            if is_looked_at { system.without_derivative(&sequence, state) } else { Vec::new() };
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
        let moved = system.moves_held(state);
        if moved.is_nan() || moved > SATISFIED {
            assembly.off_boundary.push(number);
            continue;
        }
        let found = look(system, (state, &values), (&residuals, &without_derivative), false);
        let mut position = position(system, Some(number), &found, fixed);
        let numbers = |found: &Option<Found>| found.as_ref().map(Found::numbers);
        position.differs = initial.iter().zip(&found).any(|(initial, now)| numbers(initial) != numbers(now));
        if position.differs && listed < LISTED {
            let kept = look(system, (state, &values), (&residuals, &without_derivative), true);
            position.modes = modes(system, &kept);
            position.dependent = dependent(system, &kept);
            position.modes.truncate(LISTED - listed);
            listed += position.modes.len();
            position.dependent.truncate(LISTED - listed);
            listed += position.dependent.len();
        }
        let now: Dependent = found.iter().map(rows).collect();
        let is_less = |least: &Option<Vec<u32>>, now: &Vec<u32>| {
            least.as_ref().is_none_or(|least| now.len() < least.len())
        };
        let has_fewer =
            least.iter().zip(&now).any(|(least, now)| now.as_ref().is_some_and(|now| is_less(least, now)));
        if position.differs || has_fewer {
            let open: Vec<f64> = residuals
                .iter()
                .map(|residual| SECOND_ORDER / TIMES * residual.abs().max(U).sqrt())
                .collect();
            let strictly = look(system, (state, &values), (&open, &without_derivative), false);
            // A rank that the residual alone may have made is none of an admissible state.
            position.decided &= found.iter().zip(&strictly).all(|(found, strictly)| {
                strictly.as_ref().is_some_and(Found::is_decided) && numbers(found) == numbers(strictly)
            });
            for ((least, proven), now) in least.iter_mut().zip(&mut proven).zip(strictly.iter().map(rows)) {
                if let Some(now) = now.filter(|now| is_less(least, now)) {
                    *least = Some(now);
                    *proven = worst <= PROVES;
                }
            }
        }
        all.push((assembly.positions.len(), now));
        assembly.positions.push(position);
    }
    let throughout = throughout(initial, &assembly.redundant);
    compare(system, (&least, &proven), &throughout, &all, assembly);
}

/// The redundant constraints at one state, which are not yet judged.
fn dependent(system: &System<'_>, found: &[Option<Found>]) -> Vec<Redundant> {
    let of_component = |found: &Found| -> Vec<Redundant> {
        let decided = found.is_decided();
        let one = |(row, from): (&u32, Vec<Constraint>)| Redundant {
            constraint: constraint(system, found.rows[*row as usize]),
            holds: Holds::Unjudged,
            decided,
            held: false,
            from,
        };
        let rows = found.constraints.dependent.iter().zip(made_of(system, found));
        rows.filter(|(row, _)| found.may_depend(row)).take(LISTED).map(one).collect()
    };
    found.iter().flatten().flat_map(of_component).collect()
}

/// How many of the dependent rows of each connected component hold throughout, by what was judged initially.
fn throughout(initial: &[Option<Found>], redundant: &[Redundant]) -> Vec<usize> {
    let counts =
        || initial.iter().map(|found| found.as_ref().map_or(0, |found| found.constraints.dependent.len()));
    // Those between nodes that are all fixed come first.
    let mut rest = redundant.get(redundant.len().saturating_sub(counts().sum())..).unwrap_or_default();
    counts()
        .map(|count| {
            let (of_component, others) = rest.split_at(count.min(rest.len()));
            rest = others;
            of_component.iter().filter(|one| one.holds.is_throughout()).count()
        })
        .collect()
}

/// What is redundant at one state and not where the fewest are, holds there only; the rest throughout, where initially as many do.
fn compare(
    system: &System<'_>,
    (least, proven): (&Dependent, &[bool]),
    throughout: &[usize],
    all: &[(usize, Dependent)],
    assembly: &mut Assembly,
) {
    for (at, components) in all {
        let Some(Position { state: Some(state), dependent, .. }) = assembly.positions.get_mut(*at) else {
            continue;
        };
        let mut of = BTreeMap::new();
        for (component, (rows, least)) in components.iter().zip(least).enumerate() {
            let (Some(rows), Some(least)) = (rows, least) else { continue };
            let usual: BTreeSet<&u32> = least.iter().collect();
            let count = rows.len().saturating_sub(usual.len());
            let only = if proven.get(component) == Some(&true) { Holds::Here } else { Holds::Differs };
            let here: Vec<&u32> = rows.iter().filter(|row| !usual.contains(row)).take(count).collect();
            if assembly.redundant_at.len() < LISTED {
                let named = here.iter().map(|row| (*state, constraint(system, **row), only));
                assembly.redundant_at.extend(named);
            }
            if dependent.is_empty() {
                continue;
            }
            let is_usual = throughout.get(component) == Some(&usual.len());
            let rest = if is_usual { Holds::Throughout } else { Holds::Unjudged };
            let holds = |row: &u32| if here.contains(&row) { only } else { rest };
            of.extend(rows.iter().map(|row| (constraint(system, *row), holds(row))));
        }
        for one in dependent {
            one.holds = of.get(&one.constraint).copied().unwrap_or(Holds::Unjudged);
        }
    }
    assembly.redundant_at.truncate(LISTED);
}
