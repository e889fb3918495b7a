//! What the frictions of belts need of the segments beyond their rings.

use crate::behavior::{Beyond, Unknown, Wrap};
use crate::evaluate::model::ConnectorElement;
use crate::evaluate::sequence::Sequence;
use crate::evaluate::sequence::element::{Context, place};
use crate::evaluate::sequence::nodes::STILL;
use pintle_scene::{Label, State as SceneState};
use std::collections::BTreeMap;

impl Sequence<'_> {
    /// What the friction of belts needs of the segments beyond their rings, by the index of the segment that ends there: found before
    /// anything is committed, so that it does not depend on the order of the connectors.
    pub(super) fn beyond(&mut self, scene_state: &SceneState) -> BTreeMap<usize, Beyond> {
        let mut found = BTreeMap::new();
        let Self { model, plan, labels, moved, connectors, tally, velocities, conditions, .. } = self;
        let (none, planned) = (BTreeMap::new(), &plan.request);
        let (velocities, beyond) = (*velocities, &none);
        let context = Context { model, planned, velocities, conditions, scene_state, beyond };
        let at = |node: Option<Label>| {
            let place = node.and_then(|label| labels.binary_search(&label).ok());
            place.and_then(|place| moved.get(place)).unwrap_or(&STILL)
        };
        let is_planned = |index: &usize| plan.connectors.binary_search(index).is_ok();
        for (&index, ring) in model.rings.iter().filter(|(index, _)| is_planned(index)) {
            let Some(element) = model.connectors.get(index) else { continue };
            if !element.behavior.slides(planned) {
                continue;
            }
            let next = ring.next.and_then(|next| Some((next, model.connectors.get(next)?)));
            let Some((next, beyond)) = next else {
                found.insert(
                    index,
                    Beyond { tension: Err(Unknown::OpposedBelts), angle: 0.0, wrap: Wrap::Given },
                );
                continue;
            };
            let direction = |of: &ConnectorElement| place(of, of.nodes.map(at)).0.pair.separation();
            let measured = || Wrap::measured(direction(element), direction(beyond));
            let (angle, wrap) = ring.angle.map_or_else(measured, |angle| (angle, Wrap::Given));
            let memory = plan.connectors.binary_search(&next).ok().and_then(|place| connectors.get(place));
            // What came before is not known of a segment that is not planned.
            let is_known = self.states == 0 || memory.is_some_and(|memory| memory.behavior.is_some());
            let tension = if is_known || !beyond.behavior.remembers_tension() {
                context.tension(beyond, beyond.nodes.map(at), memory, tally)
            } else {
                Err(Unknown::Part)
            };
            found.insert(index, Beyond { tension, angle, wrap });
        }
        found
    }
}
