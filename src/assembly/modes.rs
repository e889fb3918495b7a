//! Which motions are left, and what moves?

use crate::facts::{LISTED, Mode};
use crate::found::Found;
use crate::system::System;
use pintle_scene::Label;

/// The modes that are named by all nodes that move, of one connected component.
pub const MODES: usize = 20;
/// What rounding leaves, relative to the largest amount, of a node that does not move.
const ROUNDING: f64 = 1e-9;

/// The motions that are left, and what moves.
pub(crate) fn modes(system: &System<'_>, found: &[Option<Found>]) -> Vec<Mode> {
    let freedoms = system.jacobian.freedoms();
    let mut modes = Vec::new();
    for (component, found) in system.components.iter().zip(found) {
        let Some(found) = found else { continue };
        let (outcome, decided) = (found.undriven(), found.is_decided());
        let is_known = outcome.has_pivots() || outcome.rank == 0;
        for (at, column) in outcome.free.iter().enumerate() {
            if modes.len() >= LISTED {
                return modes;
            }
            let leading = freedoms[component.columns[*column as usize] as usize];
            if at >= MODES || !is_known {
                modes.push(Mode { leading, nodes: vec![leading.node], moving: None, decided });
                continue;
            }
            let motion =
                outcome.solve(component.columns.len(), |other| f64::from(u8::from(other == *column)), true);
            let mut nodes: Vec<(Label, f64)> = Vec::new();
            for (column, amount) in component.columns.iter().zip(&motion) {
                let node = freedoms[*column as usize].node;
                match nodes.last_mut() {
                    Some((last, most)) if *last == node => *most = most.max(amount.abs()),
                    _ => nodes.push((node, amount.abs())),
                }
            }
            let largest = nodes.iter().map(|(_, amount)| *amount).fold(0.0, f64::max);
            nodes.retain(|(_, amount)| *amount > ROUNDING * largest);
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
