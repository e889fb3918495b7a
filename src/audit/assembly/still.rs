//! Which nodes stand still, and which cannot turn, whatever the assembly does?
//!
//! Those that boundary conditions hold in every step, and those that connectors and multi-point constraints fix to such nodes, or to the ground.
//! What follows from a loop as a whole is not found: of a node that is not among these it is not known.

use super::steps::differing;
use super::system::{Prescribed, Role};
use crate::catalog::PLANE;
use crate::evaluate::{ConnectorElement, Fixed, Freedom, Jacobian, Model, Plan};
use crate::mpc::{Entry, Translation};
use crate::scene::{Diagnostic, Label, Scene};
use std::collections::{HashMap, HashSet};

/// Nodes that stand still.
#[derive(Debug, Default)]
pub(in crate::audit) struct Still {
    /// Those that cannot turn.
    turning: HashSet<Label>,
    /// Those that cannot move at all.
    moving: HashSet<Label>,
}

/// What is held of a node: its rotations, or all that it can do.
#[derive(Clone, Copy, PartialEq)]
enum What {
    Rotations,
    All,
}

impl Still {
    /// The nodes of connectors and constraints that stand still in every step.
    ///
    /// # Errors
    /// The points of a `*TRANSFORM` that define no directions.
    pub(in crate::audit) fn of(scene: &Scene, model: &Model) -> Result<Self, Diagnostic> {
        let steps: Vec<Prescribed> =
            differing(scene)?.into_iter().map(|(_, prescribed)| prescribed).collect();
        let plan = Plan::everything(model, super::system::request());
        let jacobian = Jacobian::new(model, &plan, &Fixed::none(), |_, _| false);
        let mut freedoms: HashMap<Label, Vec<Freedom>> = HashMap::new();
        for freedom in jacobian.freedoms() {
            freedoms.entry(freedom.node).or_default().push(*freedom);
        }
        let of = |what| held(model, &steps, &freedoms, what);
        Ok(Self { turning: of(What::Rotations), moving: of(What::All) })
    }

    /// Whether each end of a connector is held from turning.
    pub(in crate::audit) fn cannot_turn(&self, element: &ConnectorElement) -> [bool; 2] {
        element.nodes.map(|node| node.is_none_or(|node| self.turning.contains(&node)))
    }

    /// Whether neither end of a connector can move.
    pub(in crate::audit) fn cannot_move(&self, element: &ConnectorElement) -> bool {
        element.nodes.iter().flatten().all(|node| self.moving.contains(node))
    }
}

/// The nodes that are held, from those that boundary conditions hold on.
fn held(
    model: &Model,
    steps: &[Prescribed],
    freedoms: &HashMap<Label, Vec<Freedom>>,
    what: What,
) -> HashSet<Label> {
    let is_held = |freedom: &Freedom| steps.iter().all(|step| step.held.contains(*freedom));
    // Flow is no motion that another node could hold.
    let is_carried = |freedom: &Freedom| match what {
        What::Rotations => true,
        What::All => (1..=6).contains(&freedom.number),
    };
    let is_asked = |freedom: &Freedom| what == What::All || (4..=6).contains(&freedom.number);
    // A failure may release what is held, a constraint too.
    let holds = |element: &ConnectorElement, k: usize| {
        if !element.behavior.behavior.failures.is_empty() {
            return false;
        }
        let motion = |step: &Prescribed| step.motions.get(&(element.label, k)) == Some(&Role::Held);
        element.connector.is_constrained(k) || steps.iter().all(motion)
    };
    let of_node = |node: &Label| freedoms.get(node).into_iter().flatten();
    // In the plane there are fewer components; a node that a spatial element moves too may leave it.
    let is_in_plane = |node: &Label| of_node(node).all(|freedom| in_plane(freedom.number));
    let components = if what == What::All { 0..6 } else { 3..6 };
    let fixes = |element: &&ConnectorElement| {
        let lies = element.is_planar() && element.nodes.iter().flatten().all(is_in_plane);
        components.clone().filter(|k| !lies || PLANE[*k]).all(|k| holds(element, k))
    };
    let ties = |entry: &Entry| {
        let is_carried = matches!(entry.translation, Translation::Equal | Translation::Carried);
        entry.hinges == Some(0) && (what == What::Rotations || is_carried)
    };
    let mut beside: HashMap<Label, Vec<Label>> = HashMap::new();
    let mut join = |a: Label, b: Label| {
        beside.entry(a).or_default().push(b);
        beside.entry(b).or_default().push(a);
    };
    let mut waiting: Vec<Label> = Vec::new();
    for element in model.connectors.iter().filter(fixes) {
        match element.nodes {
            [Some(a), Some(b)] => join(a, b),
            nodes => waiting.extend(nodes.iter().flatten()),
        }
    }
    for element in model.mpcs.iter().filter(|element| ties(element.constraint.kind().entry())) {
        if let [s, m, ..] = element.nodes.as_slice() {
            join(*s, *m);
        }
    }
    let is_fixed = |node: &&Label| of_node(node).filter(|one| is_asked(one)).all(is_held);
    waiting.extend(freedoms.keys().filter(is_fixed));
    let mut found = HashSet::new();
    while let Some(node) = waiting.pop() {
        if found.contains(&node) || !of_node(&node).filter(|one| !is_carried(one)).all(is_held) {
            continue;
        }
        found.insert(node);
        waiting.extend(beside.get(&node).into_iter().flatten());
    }
    found
}

/// Whether a degree of freedom is none that leads out of the plane.
fn in_plane(number: u8) -> bool {
    PLANE.get(usize::from(number).wrapping_sub(1)).is_none_or(|is| *is)
}
