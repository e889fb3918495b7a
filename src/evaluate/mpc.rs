//! The multi-point constraints of a scene: resolved once, evaluated at a state.

use super::sequence::Moved;
use crate::connector::{Flag, Request, Tally, Turns};
use crate::mpc::{Body, Constraint, DOFS, Dofs, Evaluation, Kind, Margins, PHI, State, Turning};
use crate::scene::{Label, Mpc, Scene};
use crate::vector::sub;

/// A multi-point constraint, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct MpcElement {
    /// Its nodes, in the order of [`crate::mpc::Entry::nodes`].
    pub nodes: Vec<Label>,
    /// The constraint.
    pub constraint: Constraint<f64>,
}

/// One multi-point constraint at one state.
#[derive(Clone, Debug)]
pub struct MpcResult {
    /// Its index in the model.
    pub index: usize,
    /// The numbers.
    pub evaluation: Evaluation<f64>,
    /// The angles of its hinges as the state gives them, where it does (rad).
    pub given: [Option<f64>; 2],
    /// How far the relative rotation is from what the hinges allow (rad), where there are any.
    pub misalignment: Option<f64>,
    /// The distances to singular points.
    pub margins: Margins,
    /// What needs care.
    pub flags: Vec<Flag>,
}

/// The angles that a walk begins with.
pub(super) const START: [Turns<f64>; 2] = [Turns { turns: 0.0, principal: 0.0 }; 2];

impl MpcElement {
    /// The constraint of a scene.
    pub(super) fn new(kind: Kind, mpc: &Mpc, scene: &Scene, flows: impl Fn(Label) -> bool) -> Self {
        let at = |place: usize| {
            let node = mpc.nodes.get(place).and_then(|label| scene.nodes.get(label));
            node.map_or([0.0; 3], |node| node.coordinates)
        };
        let constraint = Constraint::new(kind, at(0), at(1), [at(2), at(3)]);
        let both_flow = mpc.nodes.iter().take(2).all(|label| flows(*label));
        let constraint = if both_flow { constraint.with_flow() } else { constraint };
        Self { nodes: mpc.nodes.clone(), constraint }
    }

    /// Its nodes as one word: `10-20-30`.
    pub fn label(&self) -> String {
        self.nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join("-")
    }

    /// Its kind and nodes: `MPC REVOLUTE 10-20-30`.
    pub fn title(&self) -> String {
        format!("MPC {} {}", self.constraint.kind().name(), self.label())
    }

    /// What saved branches call it: its place among the constraints, its kind and nodes.
    pub(super) fn key(&self, index: usize) -> String {
        format!("{index}:{}:{}", self.constraint.kind().name(), self.label())
    }

    /// Evaluates it with its nodes, in their order, where they are, after angles of hinges that were `before`.
    pub(super) fn evaluate(
        &self,
        index: usize,
        nodes: &[Moved],
        before: &[Turns<f64>; 2],
        request: &Request,
        tally: &mut Tally,
    ) -> MpcResult {
        let still = Moved::still();
        let node = |place: usize| nodes.get(place).unwrap_or(&still);
        let (slave, master) = (node(0), node(1));
        let hinges = [node(2), node(3)];
        let body =
            |node: &Moved| Body { displacement: node.displacement, rotation: node.rotation, flow: node.flow };
        let combined = |of: fn(&Moved) -> &[f64; 7]| -> Dofs<f64> {
            let mut combined = [0.0; DOFS];
            combined[..7].copy_from_slice(of(slave));
            combined[7..PHI].copy_from_slice(of(master));
            for (entry, hinge) in combined[PHI..].iter_mut().zip(hinges) {
                *entry = of(hinge)[5];
            }
            combined
        };
        let state = State {
            slave: body(slave),
            master: body(master),
            angles: hinges.map(|hinge| hinge.sixth),
            velocity: combined(|node| &node.rates),
            acceleration: combined(|node| &node.accelerations),
        };
        let whole = sub(slave.whole_turns, master.whole_turns);
        let turning = Turning { whole, rest: sub(sub(slave.change, master.change), whole) };
        let constraint = &self.constraint;
        let evaluation = constraint.evaluate(&state, before, &turning, request, tally);
        let flags = constraint.flags(&state, before, &turning, &evaluation);
        let margins = constraint.margins(&state, &evaluation);
        let misalignment = constraint.misalignment(&state);
        MpcResult { index, evaluation, given: state.angles, misalignment, margins, flags }
    }
}
