//! Which motions are left, and what moves?

use super::found::Found;
use super::krylov::MOVES;
use super::system::System;
use super::{LISTED, Mode};
use crate::scene::Label;

/// The modes that are named by all nodes that move, of one part.
pub(super) const MODES: usize = 20;
/// What rounding leaves, relative to the largest amount, of a node that does not move.
const ROUNDING: f64 = 1e-9;

/// The motions that are left, and what moves.
pub(super) fn modes(system: &System<'_>, found: &[Result<Found, usize>]) -> Vec<Mode> {
    let freedoms = system.jacobian.freedoms();
    let mut modes = Vec::new();
    for (part, found) in system.parts.iter().zip(found) {
        let Ok(found) = found else { continue };
        let (outcome, decided) = (found.undriven(), found.is_decided());
        let is_known = outcome.has_pivots() || outcome.rank == 0;
        for (at, column) in outcome.free.iter().enumerate() {
            if modes.len() >= LISTED {
                return modes;
            }
            let leading = freedoms[part.columns[*column as usize] as usize];
            let known = outcome.motions.iter().find(|(of, _)| of == column);
            let motion = match known {
                Some((_, motion)) => motion.clone(),
                None if at < MODES && is_known => {
                    outcome.solve(part.columns.len(), |other| f64::from(u8::from(other == *column)), true)
                }
                None => {
                    modes.push(Mode { leading, nodes: vec![leading.node], moving: None, decided });
                    continue;
                }
            };
            let mut nodes: Vec<(Label, f64)> = Vec::new();
            for (column, amount) in part.columns.iter().zip(&motion) {
                let node = freedoms[*column as usize].node;
                match nodes.last_mut() {
                    Some((last, most)) if *last == node => *most = most.max(amount.abs()),
                    _ => nodes.push((node, amount.abs())),
                }
            }
            let largest = nodes.iter().map(|(_, amount)| *amount).fold(0.0, f64::max);
            let rounding = if known.is_some() { MOVES } else { ROUNDING };
            nodes.retain(|(_, amount)| *amount > rounding * largest);
            nodes.sort_by(|x, y| y.1.total_cmp(&x.1).then(x.0.cmp(&y.0)));
            let moving = Some(nodes.len());
            modes.push(Mode {
                leading,
                nodes: nodes.iter().take(20).map(|(node, _)| *node).collect(),
                moving,
                decided,
            });
        }
    }
    modes
}
