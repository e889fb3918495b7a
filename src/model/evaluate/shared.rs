//! Connectors that share nodes.
//!
//! Several connectors between the same two nodes act side by side: each is evaluated by itself, and what they do to a node together
//! is the sum of what their rows do.

use crate::evaluate::model::{ConnectorElement, Model};
use pintle_kinematics::catalog::{COMPONENT, Slot};
use pintle_kinematics::measure::Measure;
use pintle_scene::{Code, Diagnostic, Label, LabelMap, Scene};
use std::collections::HashMap;

/// A constraint between two nodes: component, measure, nodes, and the number of their triads.
type Constraint = (usize, Measure, [Option<Label>; 2], usize);

/// What connectors that share nodes may not do: more than two belt segments at a node. Components constrained twice alike are warned about.
pub(super) fn check(scene: &Scene, model: &mut Model) -> Vec<Diagnostic> {
    let mut first: HashMap<Constraint, Label> = HashMap::new();
    let mut triads: HashMap<[u64; 18], usize> = HashMap::new();
    let mut segments: LabelMap<[Option<Label>; 2]> = LabelMap::default();
    let (mut errors, mut warnings) = (Vec::new(), Vec::new());
    let has_neighbour = beside_another(&model.connectors);
    for (element, has_neighbour) in model.connectors.iter().zip(has_neighbour) {
        let place = || scene.connectors.get(&element.label).map(|element| element.span).unwrap_or_default();
        let connection = element.connector.connection();
        if connection.is_belt() {
            for node in element.nodes.into_iter().flatten() {
                let known = segments.entry(node).or_default();
                if let [Some(one), Some(other)] = known {
                    let message = format!(
                        "element {} is the third SLIPRING at node {node}, after {one} and {other}",
                        element.label
                    );
                    let label = "by connection type SLIPRING, Description";
                    errors.push(
                        Diagnostic::error(Code::CrowdedSliprings, place(), message, label)
                            .help("give each belt a node of its own, and tie the nodes by JOIN")
                            .in_scene(scene)
                            .concerning(element.label),
                    );
                    continue;
                }
                let at = usize::from(known[0].is_some());
                known[at] = Some(element.label);
            }
        }
        if !has_neighbour {
            continue;
        }
        let mut repeated: Vec<(Label, &str)> = Vec::new();
        let known = triads.len();
        let triads = *triads.entry(bits(element)).or_insert(known);
        for k in connection.components(Slot::is_constrained) {
            let Some(measure) = element.connector.differentiated(k) else { continue };
            let constraint = (k, measure, element.nodes, triads);
            match first.get(&constraint) {
                Some(other) => repeated.push((*other, COMPONENT[k])),
                None => drop(first.insert(constraint, element.label)),
            }
        }
        if let Some((other, _)) = repeated.first() {
            let components: Vec<&str> =
                repeated.iter().filter(|(of, _)| of == other).map(|(_, component)| *component).collect();
            let message = format!(
                "element {} constrains {} of the same nodes as element {other} once more",
                element.label,
                components.join(", ")
            );
            let label = "by the rules for several connectors on the same nodes";
            model.repeated.insert(element.label);
            warnings.push(
                Diagnostic::warning(Code::RepeatedConstraint, place(), message, label)
                    .help("remove one of the two: how they share the constraint force is not determined")
                    .in_scene(scene)
                    .concerning(element.label),
            );
        }
    }
    model.warnings.append(&mut warnings);
    errors
}

/// Which connectors have another one from the same node to the same node: few, mostly, and only those can repeat a constraint.
fn beside_another(connectors: &[ConnectorElement]) -> Vec<bool> {
    let mut by_nodes: Vec<([Option<Label>; 2], usize)> =
        connectors.iter().enumerate().map(|(at, element)| (element.nodes, at)).collect();
    by_nodes.sort_unstable();
    let mut found = vec![false; connectors.len()];
    for together in by_nodes.chunk_by(|(one, _), (other, _)| one == other).filter(|run| run.len() > 1) {
        for (_, at) in together {
            if let Some(found) = found.get_mut(*at) {
                *found = true;
            }
        }
    }
    found
}

/// The bits of both triads.
fn bits(element: &ConnectorElement) -> [u64; 18] {
    let mut bits = [0; 18];
    for (bits, entry) in
        bits.iter_mut().zip(element.triads().into_iter().flat_map(|triad| triad.as_flattened()))
    {
        // −0 and 0 are the same direction cosine.
        *bits = (entry + 0.0).to_bits();
    }
    bits
}
