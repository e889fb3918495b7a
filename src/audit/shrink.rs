//! Counter-examples made small: the simplest values at which a check still fails.

use super::case::{Case, Step};
use super::sample::cube_orientations;
use crate::node::{Node, Pair};
use crate::vector::{Matrix, identity};

/// How many passes over all values are tried.
const PASSES: usize = 6;

/// The simplest case found that still fails: zero, one, or few bits in place of each number, right angles in place of each
/// rotation, no states but the last where they do not matter.
pub fn shrink(case: &Case, fails: &dyn Fn(&Case) -> bool) -> Case {
    let mut best = case.clone();
    if !fails(&best) {
        return best;
    }
    let attempt = |best: &mut Case, changed: Case| {
        let kept = fails(&changed);
        if kept {
            *best = changed;
        }
        kept
    };
    // No history first: a scene tells of none but the states it has.
    if let (Some(_), Some(last)) = (&best.start, best.path.last()) {
        let mut alone = Step::between(&best.definition.initial, last.state.pair);
        (alone.state.velocity, alone.state.acceleration) = (last.state.velocity, last.state.acceleration);
        let fresh = Case { start: None, path: vec![alone], ..best.clone() };
        attempt(&mut best, fresh);
    }
    // Then fewer states.
    while best.path.len() > 1 {
        let mut shorter = best.clone();
        shorter.path.remove(0);
        if let Some(first) = shorter.path.first_mut() {
            let mut rebuilt = Step::between(&best.definition.initial, first.state.pair);
            rebuilt.state.velocity = first.state.velocity;
            rebuilt.state.acceleration = first.state.acceleration;
            *first = rebuilt;
        }
        if !attempt(&mut best, shorter) {
            break;
        }
    }
    for _ in 0..PASSES {
        let before = weight(&best);
        for triad in 0..4 {
            for simple in std::iter::once(identity()).chain(cube_orientations()) {
                let mut changed = best.clone();
                set_triad(&mut changed, triad, simple);
                if weight(&changed) < weight(&best) && attempt(&mut best, changed) {
                    break;
                }
            }
        }
        let count = values(&mut best.clone()).len();
        for i in 0..count {
            let Some(x) = values(&mut best.clone()).get(i).map(|x| **x) else { continue };
            for simple in simpler(x) {
                let mut changed = best.clone();
                if let Some(value) = values(&mut changed).into_iter().nth(i) {
                    *value = simple;
                }
                reform(&mut changed);
                if attempt(&mut best, changed) {
                    break;
                }
            }
        }
        if weight(&best) >= before {
            break;
        }
    }
    best
}

/// Candidates for a simpler number, the simplest first.
pub(super) fn simpler(x: f64) -> Vec<f64> {
    let mut found: Vec<f64> = [0.0, 1.0, -1.0, 0.5, -0.5].to_vec();
    for bits in [4, 8, 16, 26] {
        let mask = !((1u64 << (52 - bits)) - 1);
        found.push(f64::from_bits(x.to_bits() & mask));
    }
    found.retain(|y| bits_of(*y) < bits_of(x));
    found
}

/// How many significant bits a number has.
pub(super) fn bits_of(x: f64) -> u32 {
    if x == 0.0 { 0 } else { 53 - (x.to_bits() | 1 << 52).trailing_zeros().min(52) }
}

/// The significant bits of a case.
fn weight(case: &Case) -> u32 {
    let mut copy = case.clone();
    let plain: u32 = values(&mut copy).iter().map(|x| bits_of(**x)).sum();
    let triads: u32 = [&case.definition.initial]
        .into_iter()
        .chain(case.path.last().map(|step| &step.state.pair))
        .flat_map(|pair| [&pair.a.triad, &pair.b.triad])
        .map(|triad| {
            triad.as_flattened().iter().map(|x| bits_of(*x)).sum::<u32>()
                + u32::from(*triad != identity::<f64>())
        })
        .sum();
    plain + triads
}

fn nodes(pair: &mut Pair<f64>) -> [&mut Node<f64>; 2] {
    [&mut pair.a, &mut pair.b]
}

/// Every number but the triads': of the initial state, and of the last.
fn values(case: &mut Case) -> Vec<&mut f64> {
    let mut found: Vec<&mut f64> = Vec::new();
    found.extend(case.definition.initial.reference.iter_mut());
    found.push(&mut case.definition.flow_scale);
    if let Some(step) = case.path.last_mut() {
        for node in nodes(&mut step.state.pair) {
            found.extend(node.displacement.iter_mut());
            found.push(&mut node.flow);
        }
        found.extend(step.state.velocity.iter_mut());
        found.extend(step.state.acceleration.iter_mut());
    }
    found
}

fn set_triad(case: &mut Case, which: usize, triad: Matrix<f64>) {
    let initial = which < 2;
    let at = which % 2;
    if initial {
        nodes(&mut case.definition.initial)[at].triad = triad;
    } else if let Some(step) = case.path.last_mut() {
        nodes(&mut step.state.pair)[at].triad = triad;
    }
    reform(case);
}

/// Makes increments and reference positions agree with changed values.
fn reform(case: &mut Case) {
    let reference = case.definition.initial.reference;
    let mut before = case.definition.initial;
    for step in &mut case.path {
        step.state.pair.reference = reference;
        let rebuilt = Step::between(&before, step.state.pair);
        step.increment = rebuilt.increment;
        before = step.state.pair;
    }
}
