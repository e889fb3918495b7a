//! Belts over rings: which SLIPRING goes on where another ends, and what of it the friction at the ring needs.

use crate::evaluate::model::{ConnectorElement, Model};
use pintle_scene::{Code, Diagnostic, Label, Scene, Solver};
use std::collections::BTreeMap;

/// The ring at node b of a SLIPRING with friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// The SLIPRING that begins there, by its index in the model; `None` where the other one ends there too, so that neither
    /// goes on in the other.
    pub next: Option<usize>,
    /// The angle of wrap (rad); `None` is the one between the segments as they are (Explicit without a contact
    /// angle in the section data).
    pub angle: Option<f64>,
}

/// The rings of belts with friction, by the index of the segment that ends there.
pub(super) fn rings(scene: &Scene, model: &mut Model) -> BTreeMap<usize, Ring> {
    let is_belt = |element: &ConnectorElement| element.connector.connection().is_belt();
    let mut meeting: BTreeMap<Label, Vec<usize>> = BTreeMap::new();
    for (index, element) in model.connectors.iter().enumerate().filter(|(_, element)| is_belt(element)) {
        for node in element.nodes.into_iter().flatten() {
            meeting.entry(node).or_default().push(index);
        }
    }
    let mut rings = BTreeMap::new();
    let mut warnings = Vec::new();
    for (node, belts) in meeting {
        let [one, other] = belts.as_slice() else { continue };
        let pair = [*one, *other].map(|index| model.connectors.get(index).map(|element| (index, element)));
        let [Some(one), Some(other)] = pair else { continue };
        let slides =
            |(_, element): (usize, &ConnectorElement)| element.behavior.behavior.friction.belt.is_some();
        let ends = |(_, element): (usize, &ConnectorElement)| element.nodes[1] == Some(node);
        let is_opposed = ends(one) == ends(other);
        if is_opposed && (slides(one) || slides(other)) {
            let verb = if ends(one) { "ends" } else { "begins" };
            let message = format!(
                "element {} {verb} at node {node}, as element {} does: material does not go on from one into the other",
                other.1.label, one.1.label
            );
            let label = "by connection type SLIPRING, flow past b";
            let span = scene.connectors.get(&other.1.label).map(|element| element.span).unwrap_or_default();
            warnings.push(
                Diagnostic::warning(Code::OpposedSliprings, span, message, label)
                    .help(
                        "exchange the nodes of one of them; until then friction at the node is not evaluated",
                    )
                    .in_scene(scene)
                    .concerning(other.1.label),
            );
        }
        for (before, after) in [(one, other), (other, one)] {
            if !(ends(before) && slides(before)) {
                continue;
            }
            let section = scene.connectors.get(&before.1.label).and_then(|element| scene.section(element));
            let given = section.and_then(|section| section.section_data.get(1).copied().flatten());
            let by_default = (scene.solver != Some(Solver::Explicit)).then_some(0.0);
            let next = (!is_opposed).then_some(after.0);
            rings.insert(before.0, Ring { next, angle: given.or(by_default) });
        }
    }
    model.warnings.append(&mut warnings);
    rings
}
