//! What holds at the states given? They are followed one after the other, for some constraints count turns, and those looked at that satisfy
//! the constraints.

use super::found::{Found, constraint, look, position};
use super::system::System;
use super::{Assembly, LISTED, NotAssembled, largest};
use crate::evaluate::Sequence;
use crate::scene::State;
use std::collections::BTreeSet;

/// The residual (rad, or lengths of the connectors) beyond which a state does not satisfy the constraints, so that their rank says nothing.
const SATISFIED: f64 = 1e-4;
/// The work, in degrees of freedom times states, that given states may cost; beyond, some are left out, evenly.
const WORK: usize = 3_000_000;
/// Looks at the states given.
pub(super) fn along(
    system: &System<'_>,
    states: &[State],
    initial: &[Option<Found>],
    fixed: usize,
    assembly: &mut Assembly,
) {
    let size = (system.jacobian.columns() + system.origins.len()).max(1);
    let stride = (states.len() * size).div_ceil(WORK).max(1);
    let mut sequence = Sequence::new(system.model, system.plan);
    let mut values = Vec::new();
    let mut dependent: Vec<(u64, Vec<u32>)> = Vec::new();
    let rows_of = |found: &[Option<Found>]| -> Vec<u32> {
        let of_part = |found: &Found| {
            found.constraints.dependent.iter().map(|row| found.rows[*row as usize]).collect::<Vec<u32>>()
        };
        found.iter().flatten().flat_map(of_part).collect()
    };
    let is_decided = |found: &[Option<Found>]| found.iter().flatten().all(Found::is_decided);
    // What is not decided proves nothing of other states.
    let mut least = is_decided(initial).then(|| rows_of(initial));
    for (index, state) in states.iter().enumerate() {
        let is_looked_at = index % stride == 0 || index + 1 == states.len();
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
        assembly.positions.push(position(system, Some(number), &found, fixed));
        if !is_decided(&found) {
            continue;
        }
        let rows = rows_of(&found);
        if least.as_ref().is_none_or(|least| rows.len() < least.len()) {
            least = Some(rows.clone());
        }
        dependent.push((number, rows));
    }
    let usual: BTreeSet<u32> = least.into_iter().flatten().collect();
    for (state, rows) in dependent.iter().filter(|(_, rows)| rows.len() > usual.len()) {
        let more = rows.iter().filter(|row| !usual.contains(row)).take(rows.len() - usual.len());
        for row in more {
            if assembly.redundant_at.len() < LISTED {
                assembly.redundant_at.push((*state, constraint(system, *row)));
            }
        }
    }
}
