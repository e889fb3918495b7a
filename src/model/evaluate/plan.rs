//! What is to be computed, decided once.

use crate::evaluate::model::Model;
use pintle_kinematics::connector::Request;
use pintle_scene::{Label, LabelMap};
use std::collections::BTreeSet;

/// The connectors of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selection {
    /// All, and all constraints.
    All,
    /// Those named by element number or element set.
    Named(Vec<String>),
}

/// A name that selects nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no connector or element set {name:?} in the scene; {known}")]
pub struct SelectionError {
    /// What was asked for.
    pub name: String,
    /// What there is.
    pub known: String,
}

/// The work of every state: which connectors and constraints, which nodes they need, what of each.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Indices of connectors in the model, in its order.
    pub connectors: Vec<usize>,
    /// Indices of multi-point constraints in the model.
    pub mpcs: Vec<usize>,
    /// Indices of relations in the model.
    pub relations: Vec<usize>,
    /// The nodes whose state is needed.
    pub nodes: BTreeSet<Label>,
    /// What is computed of each.
    pub request: Request,
}

impl Plan {
    /// Compiles a request.
    ///
    /// # Errors
    /// A name that is neither a connector's number nor an element set with connectors.
    pub fn compile(model: &Model, selection: &Selection, request: Request) -> Result<Self, SelectionError> {
        let Selection::Named(names) = selection else { return Ok(Self::everything(model, request)) };
        let mut chosen = BTreeSet::new();
        let labels = model.connectors.iter().enumerate();
        let labels = labels.map(|(index, connector)| (connector.label, index)).collect();
        for name in names {
            chosen.extend(find(model, &labels, name)?);
        }
        Ok(Self::of(model, chosen.into_iter().collect(), [Vec::new(), Vec::new()], request))
    }

    /// Whether there is nothing to be computed.
    pub const fn is_empty(&self) -> bool {
        self.connectors.is_empty() && self.mpcs.is_empty() && self.relations.is_empty()
    }

    /// Compiles a request for every connector and constraint of a model.
    pub fn everything(model: &Model, request: Request) -> Self {
        let all = |count: usize| (0..count).collect();
        let constraints = [all(model.mpcs.len()), all(model.relations.len())];
        Self::of(model, all(model.connectors.len()), constraints, request)
    }

    /// Of these connectors, multi-point constraints and relations, by index.
    pub fn of(
        model: &Model,
        connectors: Vec<usize>,
        [mpcs, relations]: [Vec<usize>; 2],
        request: Request,
    ) -> Self {
        let mut nodes = BTreeSet::new();
        for index in &connectors {
            nodes.extend(model.connectors[*index].nodes.iter().flatten());
            let next = model.rings.get(index).and_then(|ring| ring.next);
            let beyond = next.and_then(|next| model.connectors.get(next));
            nodes.extend(beyond.iter().flat_map(|element| element.nodes).flatten());
        }
        for index in &mpcs {
            nodes.extend(&model.mpcs[*index].nodes);
        }
        for index in &relations {
            nodes.extend(&model.relations[*index].nodes);
        }
        Self { connectors, mpcs, relations, nodes, request }
    }
}

fn find(model: &Model, labels: &LabelMap<usize>, name: &str) -> Result<Vec<usize>, SelectionError> {
    if let Ok(label) = name.trim().parse::<Label>()
        && let Some(index) = labels.get(&label)
    {
        return Ok(vec![*index]);
    }
    let found = model.sets.iter().find(|(known, _)| known.eq_ignore_ascii_case(name.trim()));
    found.map(|(_, members)| members.clone()).ok_or_else(|| {
        const SHOWN: usize = 8;
        let mut names: Vec<String> = model.sets.keys().take(SHOWN).cloned().collect();
        names.extend(model.connectors.iter().take(SHOWN).map(|connector| connector.label.to_string()));
        let known = match names.as_slice() {
            [] => "the scene has no connectors".to_string(),
            names => format!("there are {}", names.join(", ")),
        };
        SelectionError { name: name.to_string(), known }
    })
}
