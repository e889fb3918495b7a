//! Counter-examples made small: the simplest values at which a check still fails.

use crate::case::failing::Failing;
use crate::case::{Case, Step};
use crate::sampling::cube_orientations;
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::vector::{Matrix, identity, product};
use serde_json::{Number, Value};

/// How many of the values are of the initial state.
const OF_INITIAL: usize = 4;

/// How many passes over all values are tried.
const PASSES: usize = 6;

/// The simplest case found that still fails: zero, one, or few bits in place of each number, right angles in place of each
/// rotation, no states but the last where they do not matter.
pub fn shrink(case: &Case, fails: &dyn Fn(&Case) -> bool) -> Case {
    if fails(case) { shrunk(case, fails, true) } else { case.clone() }
}

/// The same, with the connector as it is initially; `None` where it does not fail.
pub(crate) fn shrink_state(case: &Case, fails: &dyn Fn(&Case) -> bool) -> Option<Case> {
    fails(case).then(|| shrunk(case, fails, false))
}

fn shrunk(case: &Case, fails: &dyn Fn(&Case) -> bool, with_initial: bool) -> Case {
    let mut best = case.clone();
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
    for pass in 0..PASSES {
        let before = weight(&best);
        for triad in if with_initial { 0..4 } else { 2..4 } {
            let [a, b] = [&best.definition.initial.a, &best.definition.initial.b].map(|node| node.triad);
            let own = if with_initial { identity() } else { [a, b][triad % 2] };
            let turned = cube_orientations().into_iter().map(|turn| product(&turn, &own));
            for simple in std::iter::once(own).chain(turned) {
                let mut changed = best.clone();
                set_triad(&mut changed, triad, simple);
                let is_simpler = if with_initial { weight(&changed) < weight(&best) } else { pass == 0 };
                if is_simpler && attempt(&mut best, changed) {
                    break;
                }
            }
        }
        let count = values(&mut best.clone()).len();
        for i in if with_initial { 0 } else { OF_INITIAL }..count {
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
fn simpler(x: f64) -> Vec<f64> {
    let mut found: Vec<f64> = [0.0, 1.0, -1.0, 0.5, -0.5].to_vec();
    for bits in [4, 8, 16, 26] {
        let mask = !((1u64 << (52 - bits)) - 1);
        found.push(f64::from_bits(x.to_bits() & mask));
    }
    found.retain(|y| bits_of(*y) < bits_of(x));
    found
}

/// How many significant bits a number has.
fn bits_of(x: f64) -> u32 {
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

/// The simplest values found that still fail: the identity in place of a rotation, zero, one, or few bits in place of each number.
pub fn shrink_values(failing: &Failing, fails: &dyn Fn(&Failing) -> bool) -> Failing {
    /// So often is it tried, for each trial is an audit.
    const TRIALS: usize = 200;
    let Ok(mut best) = serde_json::to_value(failing) else { return failing.clone() };
    let mut left = TRIALS;
    let mut attempt = |changed: Value, best: &mut Value| {
        if left == 0 {
            return false;
        }
        left -= 1;
        let kept = serde_json::from_value::<Failing>(changed.clone()).is_ok_and(|changed| fails(&changed));
        if kept {
            *best = changed;
        }
        kept
    };
    for path in paths(&best, &is_rotation) {
        let mut changed = best.clone();
        if let Some(place) = changed.pointer_mut(&path) {
            *place = serde_json::json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        }
        attempt(changed, &mut best);
    }
    let is_double = |value: &Value| value.is_f64();
    // What sizes are measured by is no part of the state, and an axis stays of unit length.
    let is_kept = |path: &String| path.ends_with("/length") || path.starts_with("/values/constraint/axes/");
    for path in paths(&best, &is_double).into_iter().filter(|path| !is_kept(path)) {
        // Part of a rotation is no number by itself.
        let matrix = path.rsplitn(3, '/').nth(2).unwrap_or_default();
        if best.pointer(matrix).is_some_and(is_rotation) {
            continue;
        }
        let Some(x) = best.pointer(&path).and_then(Value::as_f64) else { continue };
        for y in simpler(x).into_iter().filter(|y| bits_of(*y) < bits_of(x)) {
            let mut changed = best.clone();
            if let (Some(place), Some(y)) = (changed.pointer_mut(&path), Number::from_f64(y)) {
                *place = Value::Number(y);
            }
            if attempt(changed, &mut best) {
                break;
            }
        }
    }
    serde_json::from_value(best).unwrap_or_else(|_| failing.clone())
}

/// Whether a value is a 3 × 3 matrix with rows of unit length.
fn is_rotation(value: &Value) -> bool {
    let rows = value.as_array().filter(|rows| rows.len() == 3);
    rows.is_some_and(|rows| {
        rows.iter().all(|row| {
            let numbers: Option<Vec<f64>> = row
                .as_array()
                .and_then(|row| row.iter().map(|x| x.as_f64().filter(|_| x.is_f64())).collect());
            numbers.is_some_and(|row| {
                row.len() == 3 && (row.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-9
            })
        })
    })
}

/// The places of values of some sort, as JSON pointers.
fn paths(value: &Value, is_it: &dyn Fn(&Value) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    let mut waiting = vec![(String::new(), value)];
    while let Some((path, value)) = waiting.pop() {
        if is_it(value) {
            found.push(path.clone());
        }
        match value {
            Value::Array(all) => {
                waiting.extend(all.iter().enumerate().rev().map(|(i, value)| (format!("{path}/{i}"), value)));
            }
            Value::Object(all) => {
                let name = |name: &str| name.replace('~', "~0").replace('/', "~1");
                waiting.extend(all.iter().map(|(key, value)| (format!("{path}/{}", name(key)), value)));
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{is_rotation, paths};
    use serde_json::json;

    #[test]
    fn rotations_are_found() {
        let turn = json!([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        let all = json!({"state": {"body": [turn, [1.0, 0.0, 0.0]]}});
        assert_eq!(paths(&all, &is_rotation), ["/state/body/0"]);
        assert!(!is_rotation(&json!([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])));
    }
}
