//! Do the given states move what boundary conditions hold?

use crate::model::finding::{About, Finding};
use pintle_assembly::steps::{ends, of_state};
use pintle_model::evaluate::{Fixed, Freedom};
use pintle_scene::grammar::count;
use pintle_scene::grammar::number as short;
use pintle_scene::{Boundary, Code, Label, Scene, Span, State, Target};
use std::collections::{BTreeMap, BTreeSet};

/// What counts as moved (rad, or mean lengths of connectors): well above what solvers leave.
const MOVED: f64 = 1e-4;
/// The nodes that a finding names.
const NAMED: usize = 100;

/// What moves of what the boundary conditions of a step hold.
#[derive(Default)]
struct Moved {
    /// The worst, in radians or mean lengths.
    most: f64,
    /// The state, node and number of that, and how much it is (rad, or in the unit of length).
    worst: Option<(u64, Freedom, f64)>,
    nodes: BTreeSet<Label>,
    states: BTreeSet<u64>,
}

/// One finding for each step whose boundary conditions states do not observe, of the worst.
pub(super) fn findings(scene: &Scene, states: &[State], length: f64) -> Vec<Finding> {
    let ends = ends(scene);
    let mut held: BTreeMap<usize, (Fixed, BTreeSet<Label>)> = BTreeMap::new();
    let mut found: BTreeMap<usize, Moved> = BTreeMap::new();
    for (index, state) in states.iter().enumerate() {
        // What rests in the last step did so in all before it: of a state whose step is not known nothing else is.
        let is_known = ends.is_some() && state.time.is_some();
        let step = if is_known { of_state(ends.as_deref(), state) } else { scene.steps.len().max(1) };
        // What defines no directions is told with the assembly.
        let (fixed, nodes) = held.entry(step).or_insert_with(|| {
            let fixed = Fixed::resting_in_step(scene, step).unwrap_or_default();
            let nodes = fixed.iter().map(|freedom| freedom.node).collect();
            (fixed, nodes)
        });
        for (node, motion) in nodes.iter().filter_map(|node| state.nodes.get_key_value(node)) {
            for (number, amount) in fixed.moved_by(*node, motion) {
                let size = amount.abs() / if (4..=6).contains(&number) { 1.0 } else { length };
                let freedom = Freedom { node: *node, number };
                if size <= MOVED {
                    continue;
                }
                let moved = found.entry(step).or_default();
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
    found.into_iter().filter_map(|(step, moved)| finding(scene, step, &moved)).collect()
}

/// Where a degree of freedom is prescribed last, up to a step.
fn place(scene: &Scene, step: usize, Freedom { node, number }: Freedom) -> Option<Span> {
    let names = |boundary: &&Boundary| {
        let is_it = match &boundary.target.value {
            Target::Label(label) => *label == node,
            Target::Set(name) => {
                scene.node_sets.get(name.as_str()).is_some_and(|set| set.labels.contains(&node))
            }
        };
        is_it && boundary.degrees_of_freedom.contains(&number)
    };
    let of_steps = scene.steps.iter().take(step).rev().flat_map(|step| step.boundaries.iter().rev());
    let mut all = of_steps.chain(scene.boundaries.iter().rev());
    all.find(names).map(|boundary| boundary.target.span)
}

fn finding(scene: &Scene, step: usize, moved: &Moved) -> Option<Finding> {
    let (state, freedom, amount) = moved.worst?;
    let place = place(scene, step, freedom).unwrap_or_default();
    let Freedom { node, number } = freedom;
    let (verb, unit) = if (4..=6).contains(&number) { ("turns", " rad") } else { ("moves", "") };
    let others = |all: usize, word: &str| match all {
        0 | 1 => None,
        more => Some(count(more - 1, &format!("other {word}"))),
    };
    let others: Vec<String> = [others(moved.nodes.len(), "node"), others(moved.states.len(), "state")]
        .into_iter()
        .flatten()
        .collect();
    let others =
        if others.is_empty() { String::new() } else { format!(" (and so on for {})", others.join(" and ")) };
    let message = format!(
        "state {state} {verb} node {node} by {amount}{unit} in degree of freedom {number}, which a boundary condition holds{others}",
        amount = short(amount, 4)
    );
    let reason = "more than 1e-4 rad, or 1e-4 of the mean length of the connectors, from where it is held in the step of the state";
    let remedy = "check that the states are those of this model, and their step and units; what is meant to move there needs a magnitude, or no \
                  boundary condition";
    let mut nodes = vec![node];
    nodes.extend(moved.nodes.iter().copied().filter(|other| *other != node).take(NAMED - 1));
    let about = About { nodes, state: Some(state), value: Some(amount), ..About::default() };
    Some(Finding::new(scene, Code::ModelHeldNodeMoves, place, message, reason, remedy).about(about))
}
