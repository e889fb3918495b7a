//! Do the given states move what boundary conditions hold?

use super::finding::{About, Finding};
use crate::audit::assembly::steps::{ends, of_state};
use crate::evaluate::{Fixed, Freedom};
use crate::grammar::count;
use crate::scene::{Code, ConditionKind, Label, Scene, Span, State, Target};
use indexmap::IndexMap;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// What counts as moved (rad, or mean lengths of connectors): well above what solvers leave.
const MOVED: f64 = 1e-4;
/// The nodes that a finding names.
const NAMED: usize = 100;

/// What moves of what one boundary condition holds.
#[derive(Default)]
struct Moved {
    /// The worst, in radians or mean lengths.
    most: f64,
    /// The state, node and number of that, and how much it is (rad, or in the unit of length).
    worst: Option<(u64, Freedom, f64)>,
    nodes: BTreeSet<Label>,
    states: BTreeSet<u64>,
}

/// One finding for each boundary condition that states do not observe, of the worst.
pub(super) fn findings(scene: &Scene, states: &[State], length: f64) -> Vec<Finding> {
    let ends = ends(scene);
    let mut held: BTreeMap<usize, Fixed> = BTreeMap::new();
    let mut places: BTreeMap<usize, HashMap<Freedom, Span>> = BTreeMap::new();
    let mut found: IndexMap<Span, Moved> = IndexMap::new();
    for (index, state) in states.iter().enumerate() {
        let step = of_state(ends.as_deref(), state);
        // What defines no directions is told with the assembly.
        let fixed = held.entry(step).or_insert_with(|| Fixed::held_in_step(scene, step).unwrap_or_default());
        for (node, motion) in &state.nodes {
            for (number, amount) in fixed.moved_by(*node, motion) {
                let size = amount.abs() / if (4..=6).contains(&number) { 1.0 } else { length };
                let freedom = Freedom { node: *node, number };
                if size <= MOVED {
                    continue;
                }
                let places = places.entry(step).or_insert_with(|| places_in(scene, step));
                let moved = found.entry(places.get(&freedom).copied().unwrap_or_default()).or_default();
                let state = state.number.unwrap_or(index as u64);
                moved.nodes.insert(*node);
                moved.states.insert(state);
                // What is no number is worse than any.
                if moved.worst.is_none() || !(size <= moved.most || moved.most.is_nan()) {
                    (moved.most, moved.worst) = (size, Some((state, freedom, amount)));
                }
            }
        }
    }
    found.into_iter().filter_map(|(place, moved)| finding(scene, place, &moved)).collect()
}

/// Where each degree of freedom is prescribed last, up to a step.
fn places_in(scene: &Scene, step: usize) -> HashMap<Freedom, Span> {
    let mut places = HashMap::new();
    let put = |places: &mut HashMap<Freedom, Span>, boundary: &crate::scene::Boundary| {
        let nodes: &[Label] = match &boundary.target.value {
            Target::Label(label) => std::slice::from_ref(label),
            Target::Set(name) => scene.node_sets.get(name.as_str()).map_or(&[], |set| set.labels.as_slice()),
        };
        for node in nodes {
            let freedoms =
                boundary.degrees_of_freedom.iter().map(|number| Freedom { node: *node, number: *number });
            places.extend(freedoms.map(|freedom| (freedom, boundary.target.span)));
        }
    };
    for boundary in &scene.boundaries {
        put(&mut places, boundary);
    }
    for step in scene.steps.iter().take(step) {
        if step.removes(ConditionKind::Boundary) {
            places.clear();
        }
        for boundary in &step.boundaries {
            put(&mut places, boundary);
        }
    }
    places
}

fn finding(scene: &Scene, place: Span, moved: &Moved) -> Option<Finding> {
    let (state, Freedom { node, number }, amount) = moved.worst?;
    let (verb, unit) = if (4..=6).contains(&number) { ("turns", " rad") } else { ("moves", "") };
    let others = |all: usize, word: &str| match all {
        0 | 1 => None,
        more => Some(count(more - 1, &format!("other {word}"))),
    };
    let others: Vec<String> = [others(moved.nodes.len(), "node of it"), others(moved.states.len(), "state")]
        .into_iter()
        .flatten()
        .collect();
    let others =
        if others.is_empty() { String::new() } else { format!(" (and so on for {})", others.join(" and ")) };
    let message = format!(
        "state {state} {verb} node {node} by {amount:.3e}{unit} in degree of freedom {number}, which a boundary condition holds{others}"
    );
    let reason = "more than 1e-4 rad, or 1e-4 of the mean length of the connectors, from where it is held in the step of the state";
    let remedy = "check that the states are those of this model, and their step and units; what is meant to move there needs a magnitude, or no \
                  boundary condition";
    let mut nodes = vec![node];
    nodes.extend(moved.nodes.iter().copied().filter(|other| *other != node).take(NAMED - 1));
    let about = About { nodes, state: Some(state), value: Some(amount), ..About::default() };
    Some(Finding::new(scene, Code::ModelHeldNodeMoves, place, message, reason, remedy).about(about))
}
