//! Which nodes stand still, and which cannot turn, whatever the assembly does?
//!
//! Those that boundary conditions hold in every step, and those that connectors and multi-point constraints fix to such nodes, or to the ground.
//! What follows from a loop as a whole is not found: of a node that is not among these it is not known.

use pintle_assembly::Role;
use pintle_assembly::prescribed::{Prescribed, differing};
use pintle_assembly::system::request;
use pintle_kinematics::catalog::{PLANE, in_plane};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::mpc::Translation;
use pintle_kinematics::node::{DOF_NUMBER, DOFS};
use pintle_kinematics::relation::Form;
use pintle_model::evaluate::{
    ConnectorElement, Fixed, Freedom, Jacobian, Model, MpcElement, Plan, RelationElement,
};
use pintle_scene::{Diagnostic, Label, Scene};
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::ops::{Range, RangeInclusive};

/// Nodes that stand still.
#[derive(Debug, Default)]
pub(super) struct Still {
    /// Those that cannot turn.
    turning: HashSet<Label>,
    /// Those that stay where they are, whether they turn or not.
    places: HashSet<Label>,
    /// Those whose material flow is held.
    flows: HashSet<Label>,
}

impl Still {
    /// The nodes of connectors and constraints that stand still in every step.
    ///
    /// # Errors
    /// The points of a `*TRANSFORM` that define no directions.
    pub(super) fn of(scene: &Scene, model: &Model) -> Result<Self, Diagnostic> {
        let known = Known::of(scene, model)?;
        let turns = |element: &MpcElement| element.constraint.kind().entry().hinges == Some(0);
        let carried = |element: &RelationElement| match element.relation.form() {
            Form::Carried { fixed, arm, .. } => Some((*fixed, *arm)),
            _ => None,
        };
        let turns_with = |element: &RelationElement| {
            carried(element).is_some_and(|(fixed, _)| !fixed[3..].contains(&false))
        };
        let turning = known.held(4..=6, |element| known.holds_all(element, 3..6), turns, turns_with);
        let is_still = |node: Option<&Label>| node.is_none_or(|node| turning.contains(node));
        let places = known.held(
            1..=3,
            |element| {
                // What coincides does so however the directions turn.
                let coincides = element.initial().reference == [0.0; 3];
                let [a, b] = element.nodes.each_ref().map(|node| is_still(node.as_ref()));
                let is_carried = match directions(element) {
                    Some(Directions::OfA) => coincides || a,
                    Some(Directions::OfBoth) => coincides || (a && b),
                    None => false,
                };
                is_carried && known.holds_all(element, 0..3)
            },
            |element| match element.constraint.kind().entry().translation {
                Translation::Equal => true,
                Translation::Carried => {
                    element.constraint.arm() == [0.0; 3] || is_still(element.nodes.get(1))
                }
                Translation::Free | Translation::Distance => false,
            },
            |element| {
                carried(element).is_some_and(|(fixed, arm)| {
                    !fixed[..3].contains(&false) && (arm == [0.0; 3] || is_still(element.nodes.get(1)))
                })
            },
        );
        let flows = known.held(10..=10, |_| false, |_| false, |_| false);
        Ok(Self { turning, places, flows })
    }

    /// Whether each end of a connector is held from turning.
    pub(super) fn cannot_turn(&self, element: &ConnectorElement) -> [bool; 2] {
        element.nodes.map(|node| node.is_none_or(|node| self.turning.contains(&node)))
    }

    /// Whether neither end of a connector can move in the degrees of freedom that it has there.
    pub(super) fn cannot_move(&self, element: &ConnectorElement) -> bool {
        let is_held = |j: usize| {
            let Some(node) = element.nodes[usize::from(j >= DOFS / 2)] else { return true };
            match DOF_NUMBER[j] {
                1..=3 => self.places.contains(&node),
                4..=6 => self.turning.contains(&node),
                _ => self.flows.contains(&node),
            }
        };
        let active = element.connector.active();
        (0..DOFS).filter(|j| active[*j]).all(is_held)
    }
}

/// Which nodes move as one body, whatever happens: what fails holds nothing together.
#[derive(Debug, Default)]
pub(super) struct Bodies {
    /// The number of a body by node, where it has more nodes than one, or stands still: then 0.
    of: HashMap<Label, usize>,
}

impl Bodies {
    /// Those that connectors without a free component, rigid bodies and multi-point constraints join, and those that stand still.
    pub(super) fn of(model: &Model, still: &Still) -> Self {
        let mut beside: HashMap<Label, Vec<Label>> = HashMap::new();
        let mut grounded: Vec<Label> = still.places.intersection(&still.turning).copied().collect();
        let mut join = |a: Label, b: Label| {
            beside.entry(a).or_default().push(b);
            beside.entry(b).or_default().push(a);
        };
        for element in model.connectors.iter().filter(|element| !element.is_planar() && !may_fail(element)) {
            if (0..6).all(|k| element.connector.is_constrained(k)) {
                match element.nodes {
                    [Some(a), Some(b)] => join(a, b),
                    nodes => grounded.extend(nodes.iter().flatten()),
                }
            }
        }
        for MpcElement { constraint, nodes, .. } in &model.mpcs {
            let entry = constraint.kind().entry();
            // Equal displacements of nodes that are apart are no motion of one body.
            let carries = match entry.translation {
                Translation::Carried => true,
                Translation::Equal => constraint.arm() == [0.0; 3],
                Translation::Free | Translation::Distance => false,
            };
            if let ([s, m, ..], true) = (nodes.as_slice(), carries && entry.hinges == Some(0)) {
                join(*s, *m);
            }
        }
        for RelationElement { relation, nodes, .. } in &model.relations {
            let is_rigid = matches!(relation.form(), Form::Carried { fixed, .. } if !fixed.contains(&false));
            if let ([s, m, ..], true) = (nodes.as_slice(), is_rigid) {
                join(*s, *m);
            }
        }
        let mut found = Self::default();
        let mut flood = |first: Vec<Label>, number: usize| {
            let mut waiting = first;
            while let Some(node) = waiting.pop() {
                if let Entry::Vacant(place) = found.of.entry(node) {
                    place.insert(number);
                    waiting.extend(beside.get(&node).into_iter().flatten());
                }
            }
        };
        flood(grounded, 0);
        for (number, node) in beside.keys().enumerate() {
            flood(vec![*node], number + 1);
        }
        found
    }

    /// The body of a node: none for the ground, else its number or, of a body of one node, its label.
    pub(super) fn body(&self, node: Option<Label>) -> Option<Result<usize, Label>> {
        let node = node?;
        match self.of.get(&node) {
            Some(0) => None,
            Some(number) => Some(Ok(*number)),
            None => Some(Err(node)),
        }
    }
}

/// Whether a failure may release what a connector holds, a constraint too.
pub(super) fn may_fail(element: &ConnectorElement) -> bool {
    !element.behavior.behavior.failures.is_empty()
}

/// The directions along which the position of b from a is said.
enum Directions {
    OfA,
    OfBoth,
}

/// Those of a connector whose components 1 to 3, as many as there are, are coordinates of b.
fn directions(element: &ConnectorElement) -> Option<Directions> {
    let mut measures = (0..3).filter_map(|k| element.connector.position_measure(k));
    measures.try_fold(Directions::OfA, |found, measure| match (found, measure) {
        (found, Measure::Position(_)) => Some(found),
        (_, Measure::ProjectedPosition(_)) => Some(Directions::OfBoth),
        _ => None,
    })
}

/// What is prescribed in steps, and the degrees of freedom that nodes have.
struct Known<'a> {
    model: &'a Model,
    steps: Vec<Prescribed>,
    freedoms: HashMap<Label, Vec<Freedom>>,
}

impl<'a> Known<'a> {
    fn of(scene: &Scene, model: &'a Model) -> Result<Self, Diagnostic> {
        let steps = differing(scene)?.into_iter().map(|(_, prescribed)| prescribed).collect();
        let plan = Plan::everything(model, request());
        let jacobian = Jacobian::new(model, &plan, &Fixed::none(), |_, _| false);
        let mut freedoms: HashMap<Label, Vec<Freedom>> = HashMap::new();
        for freedom in jacobian.freedoms() {
            freedoms.entry(freedom.node).or_default().push(*freedom);
        }
        Ok(Self { model, steps, freedoms })
    }

    fn of_node(&self, node: &Label) -> impl Iterator<Item = &Freedom> {
        self.freedoms.get(node).into_iter().flatten()
    }

    /// Whether a connector holds components (0-based) in every step.
    fn holds_all(&self, element: &ConnectorElement, mut components: Range<usize>) -> bool {
        if may_fail(element) {
            return false;
        }
        let holds = |k: usize| {
            let motion = |step: &Prescribed| step.motions.get(&(element.label, k)) == Some(&Role::Held);
            element.connector.is_constrained(k) || self.steps.iter().all(motion)
        };
        // In the plane there are fewer components; a node that a spatial element moves too may leave it.
        let is_in_plane = |node: &Label| self.of_node(node).all(|freedom| in_plane(freedom.number));
        let lies = element.is_planar() && element.nodes.iter().flatten().all(is_in_plane);
        components.all(|k| (lies && !PLANE[k]) || holds(k))
    }

    /// The nodes whose degrees of freedom of these numbers are held: by boundary conditions, and by what `fixes`, `ties` and
    /// `carries` them with such nodes.
    fn held(
        &self,
        numbers: RangeInclusive<u8>,
        fixes: impl Fn(&ConnectorElement) -> bool,
        ties: impl Fn(&MpcElement) -> bool,
        carries: impl Fn(&RelationElement) -> bool,
    ) -> HashSet<Label> {
        let mut beside: HashMap<Label, Vec<Label>> = HashMap::new();
        let mut join = |a: Label, b: Label| {
            beside.entry(a).or_default().push(b);
            beside.entry(b).or_default().push(a);
        };
        let mut waiting: Vec<Label> = Vec::new();
        for element in self.model.connectors.iter().filter(|element| fixes(element)) {
            match element.nodes {
                [Some(a), Some(b)] => join(a, b),
                nodes => waiting.extend(nodes.iter().flatten()),
            }
        }
        for element in self.model.mpcs.iter().filter(|element| ties(element)) {
            if let [s, m, ..] = element.nodes.as_slice() {
                join(*s, *m);
            }
        }
        for element in self.model.relations.iter().filter(|element| carries(element)) {
            if let [s, m, ..] = element.nodes.as_slice() {
                join(*s, *m);
            }
        }
        let is_held = |freedom: &Freedom| self.steps.iter().all(|step| step.held.contains(*freedom));
        let is_fixed =
            |node: &&Label| self.of_node(node).filter(|one| numbers.contains(&one.number)).all(is_held);
        waiting.extend(self.freedoms.keys().filter(is_fixed));
        let mut found = HashSet::new();
        while let Some(node) = waiting.pop() {
            if found.insert(node) {
                waiting.extend(beside.get(&node).into_iter().flatten());
            }
        }
        found
    }
}
