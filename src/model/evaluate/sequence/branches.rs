//! What a walk remembers between states: saved, read back, and continued.

use crate::behavior::state::History;
use crate::evaluate::model::{ConnectorElement, ElementBehavior, Model};
use crate::evaluate::plan::Plan;
use crate::evaluate::sequence::nodes::Orientation;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Branch, Mask, Turns};
use pintle_kinematics::vector::{Matrix, Vector};
use pintle_scene::Label;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Everything that a sequence remembers between states. Saved and read back, it continues bit for bit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Branches {
    /// The number of states committed.
    pub states: u64,
    pub(super) connectors: BTreeMap<Label, Saved>,
    pub(super) mpcs: BTreeMap<String, [Turns<f64>; 2]>,
    pub(super) nodes: BTreeMap<Label, Orientation>,
}

/// Every component.
const fn all() -> Mask {
    [true; 6]
}

fn is_all(mask: &Mask) -> bool {
    *mask == all()
}

/// The components whose history a plan needs of connectors with this behaviour: those that it names, and those that the behaviour follows from.
pub(super) fn followed(behavior: &ElementBehavior, plan: &Plan) -> Mask {
    let request = &plan.request;
    if behavior.is_needed(request, request) {
        behavior.request(request, behavior.slides(request)).components()
    } else {
        request.components()
    }
}

/// The branch of a connector, with what it belongs to: turn counts of another type or geometry would be taken for its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Saved {
    connection: String,
    nodes: [Option<Label>; 2],
    reference: Vector<f64>,
    triads: [Matrix<f64>; 2],
    pub(super) branch: Branch<f64>,
    /// The components whose history the branch holds.
    #[serde(default = "all", skip_serializing_if = "is_all")]
    pub(super) followed: Mask,
    /// What the behaviour has decided, and the number that tells it from others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) behavior: Option<(u64, History)>,
}

impl Saved {
    pub(super) fn new(
        element: &ConnectorElement,
        branch: Branch<f64>,
        followed: Mask,
        behavior: Option<History>,
    ) -> Self {
        let identity = element.behavior.identity;
        Self {
            connection: element.connector.connection().name.to_string(),
            nodes: element.nodes,
            reference: element.reference,
            triads: element.triads().map(|triad| *triad),
            branch,
            followed,
            behavior: behavior.map(|history| (identity, history)),
        }
    }

    /// What differs from the element, in words.
    fn difference(&self, element: &ConnectorElement) -> Option<String> {
        let now = Self::new(element, self.branch, self.followed, Some(History::default()));
        let label = element.label;
        if self.connection != now.connection {
            let (saved, now) = (&self.connection, &now.connection);
            return Some(format!("the branch of connector {label} was saved for {saved}, and it is {now}"));
        }
        let identity = |saved: &Self| saved.behavior.as_ref().map(|(identity, _)| *identity);
        if identity(self).is_some_and(|identity_then| Some(identity_then) != identity(&now)) {
            return Some(format!("the history of connector {label} was saved for another behaviour"));
        }
        let place = (self.nodes, self.reference, self.triads) != (now.nodes, now.reference, now.triads);
        place.then(|| {
            format!(
                "the branch of connector {label} was saved for other nodes, initial positions or orientations"
            )
        })
    }
}

impl Branches {
    /// Whether these branches can be continued by a plan.
    ///
    /// # Errors
    /// In words, the first connector that one of the two knows and the other does not.
    pub fn check(&self, model: &Model, plan: &Plan) -> Result<(), String> {
        let planned: BTreeMap<Label, &ConnectorElement> = plan
            .connectors
            .iter()
            .map(|index| &model.connectors[*index])
            .map(|element| (element.label, element))
            .collect();
        if self.states > 0
            && let Some(label) = planned.keys().find(|label| !self.connectors.contains_key(label))
        {
            return Err(format!("connector {label} is to be evaluated, and its branch was not saved"));
        }
        for (label, saved) in &self.connectors {
            let Some(element) = planned.get(label) else {
                return Err(format!(
                    "a branch was saved for connector {label}, which is not to be evaluated"
                ));
            };
            if let Some(difference) = saved.difference(element) {
                return Err(difference);
            }
            let missing = |k: &usize| followed(&element.behavior, plan)[*k] && !saved.followed[*k];
            if let Some(k) = (0..6).find(missing) {
                return Err(format!(
                    "the turns of {} of connector {label} were not followed when its branch was saved",
                    COMPONENT[k]
                ));
            }
            let behavior = &element.behavior;
            let needs = behavior.has_history() && behavior.is_asked(&plan.request);
            if needs && self.states > 0 && saved.behavior.is_none() {
                return Err(format!(
                    "what is asked for depends on the history of connector {label}, which was not followed: \
                     nothing that depends on it was asked for when the branches were saved"
                ));
            }
        }
        let mpcs: BTreeSet<String> = plan.mpcs.iter().map(|index| model.mpcs[*index].key(*index)).collect();
        if self.states > 0 && !mpcs.iter().eq(self.mpcs.keys()) {
            return Err("the MPCs to be evaluated are not those whose branches were saved".to_string());
        }
        if self.states > 0 && !plan.nodes.iter().eq(self.nodes.keys()) {
            return Err("the nodes of the scene are not those whose rotations were saved".to_string());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Selection;
    use crate::evaluate::sequence::Sequence;
    use pintle_kinematics::connector::Request;
    use pintle_scene::State as SceneState;

    /// Branches belong to a type, nodes and geometry, and to nothing else.
    #[test]
    fn foreign_branches_are_refused() {
        let deck = |types: &str, x: &str| {
            let text = format!(
                "*NODE\n1, 0., 0., 0.\n2, {x}, 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
                 *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\n{types}\nO,\n"
            );
            let scene = pintle_scene::Scene::parse("deck.inp", &text).unwrap();
            let model = Model::compile(&scene).unwrap();
            let plan = Plan::compile(&model, &Selection::All, Request::everything(0)).unwrap();
            (model, plan)
        };
        let (model, plan) = deck("CARTESIAN, CARDAN", "1.");
        let mut walk = Sequence::new(&model, &plan);
        walk.step(&SceneState::default());
        let branches = walk.branches();
        assert_eq!(branches.check(&model, &plan), Ok(()));
        let refusal = |types, x| {
            let (model, plan) = deck(types, x);
            branches.check(&model, &plan).unwrap_err()
        };
        assert!(
            refusal("CARTESIAN, EULER", "1.")
                .contains("saved for CARTESIAN + CARDAN, and it is CARTESIAN + EULER")
        );
        assert!(refusal("CARTESIAN, CARDAN", "2.").contains("initial positions"));
    }
}
