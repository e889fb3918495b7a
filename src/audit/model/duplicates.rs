//! Is something there twice?

use super::finding::{About, Finding};
use super::gather::Gathered;
use crate::evaluate::{ConnectorElement, Model};
use crate::scene::{Code, Label, Scene};
use std::collections::HashMap;

/// What two connectors have in common that do the same: the type, what is attached, the nodes in ascending order, and the bits of
/// both triads in the order of the nodes.
type Same<'a> = (&'a str, Option<&'a str>, [Option<Label>; 2], [u64; 18]);

/// Connectors that are there twice. Those that constrain the same components alike are told by a rule, and not again.
pub(super) fn findings(scene: &Scene, model: &Model) -> Vec<Finding> {
    let mut first: HashMap<Same<'_>, Label> = HashMap::new();
    let mut gathered = Gathered::default();
    for element in &model.connectors {
        let Some(given) = scene.connectors.get(&element.label) else { continue };
        let Some(section) = scene.section(given) else { continue };
        let behavior = section.behavior.as_ref().map(|name| name.value.as_str());
        let key = same(element, behavior);
        match first.get(&key) {
            None => drop(first.insert(key, element.label)),
            Some(_) if model.repeated.contains(&element.label) => {}
            Some(other) => {
                let message = format!(
                    "element {} joins the nodes of element {other}, and is a {} with the same behaviour",
                    element.label,
                    element.connector.connection().name
                );
                let reason = "type, nodes, orientations and behaviour agree";
                let remedy = "remove one of the two; if both are meant, allow this code";
                let finding =
                    Finding::new(scene, Code::ModelDuplicateConnector, given.span, message, reason, remedy);
                let about = About { elements: vec![element.label, *other], ..About::default() };
                gathered.add(given.section, element.label, finding.about(about), |_, _| false);
            }
        }
    }
    gathered.findings().collect()
}

fn same<'a>(element: &'a ConnectorElement, behavior: Option<&'a str>) -> Same<'a> {
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
    (&element.connector.connection().name, behavior, ends.map(|(node, _)| node), bits)
}
