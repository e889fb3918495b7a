//! Is something there twice?

use crate::model::finding::{About, Finding};
use crate::model::gather::Gathered;
use crate::model::levels::Levels;
use pintle_kinematics::catalog::component_index;
use pintle_kinematics::measure::Measure;
use pintle_model::evaluate::{ConnectorElement, Model};
use pintle_scene::grammar::with_article;
use pintle_scene::{Behavior, Code, Label, Mpc, Scene};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// What a connector does: what two that do the same have in common besides their nodes and directions.
#[derive(PartialEq, Eq, Hash)]
enum Does<'a> {
    /// What its type does, with a behaviour of this content, whatever its name, or none.
    Type(&'a str, Option<u64>),
    /// Nothing but what a behaviour of this content gives to single components, each by what it measures. Constraints are compared by
    /// a rule of their own.
    Components(u64, Vec<(u8, Option<Measure>)>),
}

/// What it does, the nodes in ascending order, and the bits of both triads in the order of the nodes.
type Same<'a> = (Does<'a>, [Option<Label>; 2], [u64; 18]);

/// Connectors that are there twice. Those that constrain the same components alike are told by a rule, and not again.
pub(super) fn findings(scene: &Scene, model: &Model, levels: &Levels) -> Vec<Finding> {
    let mut first: HashMap<Same<'_>, &ConnectorElement> = HashMap::new();
    let mut gathered = Gathered::new(levels);
    for element in &model.connectors {
        let Some(given) = scene.connectors.get(&element.label) else { continue };
        let Some(section) = scene.section(given) else { continue };
        let key = same(element, scene.behavior(section));
        match first.get(&key) {
            None => drop(first.insert(key, element)),
            Some(_) if model.repeated.contains(&element.label) => {}
            Some(other) => {
                let [name, of_other] = [element, other].map(|element| &element.connector.connection().name);
                let what = match key.0 {
                    Does::Type(_, None) => format!("is {} as well", with_article(name)),
                    Does::Type(..) => format!("is {} with the same behaviour", with_article(name)),
                    Does::Components(..) if name == of_other => {
                        format!("is {} with the same behaviour", with_article(name))
                    }
                    Does::Components(..) => {
                        format!(
                            "has, as {name}, the behaviour that {of_other} has, on components that measure the same"
                        )
                    }
                };
                let message = format!(
                    "element {} joins the nodes of element {}, and {what}",
                    element.label, other.label
                );
                let reason =
                    "nodes, directions and the content of the behaviours agree, whatever their names";
                let remedy = "remove one of the two; if both are meant, allow this code";
                let finding =
                    Finding::new(scene, Code::ModelDuplicateConnector, given.span, message, reason, remedy);
                let about = About { elements: vec![element.label, other.label], ..About::default() };
                gathered.add((given.section, None), element.label, finding.about(about), |_, _| false);
            }
        }
    }
    gathered.findings().chain(constraints(scene)).collect()
}

/// Multi-point constraints that are there twice: of one kind, between the same nodes. Those of two nodes are the same whichever comes first.
fn constraints(scene: &Scene) -> Vec<Finding> {
    let mut first: HashMap<(&str, Vec<Label>), &Mpc> = HashMap::new();
    let mut found = Vec::new();
    for mpc in scene.mpcs.iter().filter(|mpc| mpc.kind.evaluated().is_some()) {
        let mut nodes = mpc.nodes.clone();
        if nodes.len() == 2 {
            nodes.sort();
        }
        let other = match first.entry((mpc.kind.name(), nodes)) {
            Entry::Vacant(place) => {
                place.insert(mpc);
                continue;
            }
            Entry::Occupied(known) => *known.get(),
        };
        let label = mpc.nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join("-");
        let title = format!("MPC {} {label}", mpc.kind.name());
        let message =
            format!("{title} joins the nodes of that of line {}, and is of the same kind", other.span.line());
        let reason = "kind and nodes agree: the second enforces nothing that the first does not, and how they share the force is not determined";
        let remedy = "remove one of the two";
        let finding = Finding::new(scene, Code::ModelDuplicateMpc, mpc.span, message, reason, remedy);
        found.push(finding.about(About { mpcs: vec![title], nodes: mpc.nodes.clone(), ..About::default() }));
    }
    found
}

fn same<'a>(element: &'a ConnectorElement, behavior: Option<&Behavior>) -> Same<'a> {
    let mut ends = [0, 1].map(|end| (element.nodes[end], element.triads()[end]));
    if ends[1].0 < ends[0].0 {
        ends.swap(0, 1);
    }
    let mut bits = [0; 18];
    let entries = ends.iter().flat_map(|(_, triad)| triad.as_flattened());
    for (bits, entry) in bits.iter_mut().zip(entries) {
        // −0 and 0 are the same direction cosine.
        *bits = (entry + 0.0).to_bits();
    }
    let content = element.behavior.identity;
    let does = match behavior.and_then(single_components) {
        Some(components) => {
            let measured =
                |k: u8| (k, component_index(k).and_then(|k| element.connector.position_measure(k)));
            Does::Components(content, components.into_iter().map(measured).collect())
        }
        None => Does::Type(&element.connector.connection().name, behavior.map(|_| content)),
    };
    (does, ends.map(|(node, _)| node), bits)
}

/// The components (1 to 6) on which a behaviour acts one by one; none where it couples components, or is triggered by others.
fn single_components(behavior: &Behavior) -> Option<Vec<u8>> {
    let Behavior { elasticity, damping, friction, plasticity, damage, stops, locks, failures, .. } = behavior;
    let attached = elasticity.len() + damping.len() + friction.len() + plasticity.len() + damage.len();
    let mut components: Vec<u8> = behavior.acts_on().collect();
    components.sort_unstable();
    let is_single = attached > 0 && components.len() == attached;
    (is_single && stops.is_empty() && locks.is_empty() && failures.is_empty()).then_some(components)
}
