//! How certain is a position? Coordinates are rounded numbers: to the units of doubles, and to the digits with which they are written.
//!
//! The row ∂p/∂q of a position p over the nodal degrees of freedom carries what is rounded into p:
//! - A coordinate X of a node with displacement U is known to `u (|X| + 2|U|)`, for X, U and their sum are rounded.
//! - An X that is computed (of r and θ, or by the placement of an instance) is known to u times what is rounded on the way besides
//!   (`WrittenNode::sizes`). Of an instance that is moved by t that is |X − t| as it is read and |t|.
//! - The triad of a node is known to an angle ε, by the points of its orientation.
//! - The formula is known to C u F, the bound of the audit of numbers ([`crate::judge::bound`]).
//!
//! > δp = Σ |∂p/∂x_i| u (|X_i| + 2|U_i|) + Σ |∂p/∂θ_i| ε + C u F,  F = |p| + Σ |∂p/∂q_j| s_j.
//!
//! The same sum over half a unit of the last decimal of each coordinate, displacement, rotation and orientation is what their digits leave open
//! ([`Digits`], [`DigitsOfState`]).

use crate::judge::bound::{C, scales};
use crate::model::geometry::uncertain_directions;
use pintle_kinematics::connector::{Increment, Request, State, Tally};
use pintle_kinematics::node::{Node, THETA_A, THETA_B, XA, XB, dof_size};
use pintle_kinematics::scalar::U;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::{add, sub};
use pintle_model::evaluate::ConnectorElement;
use pintle_scene as scene;
use pintle_scene::{Digits, DigitsOfState, End, Scene};
use std::cell::OnceCell;

/// How far a position may be from what it is taken for: a length in the unit of the scene, or an angle (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Open {
    /// By the rounding of coordinates and of the formula.
    pub(super) rounding: f64,
    /// By the digits of coordinates, orientations, displacements and rotations, and of a number that it is compared with.
    pub(super) digits: f64,
}

/// What is certain of the positions in a scene.
pub(super) struct Certainty<'a> {
    scene: &'a Scene,
    digits: OnceCell<Digits>,
    /// The state that is looked at: none but the initial one.
    state: Option<&'a scene::State>,
    digits_of_state: OnceCell<DigitsOfState>,
}

impl<'a> Certainty<'a> {
    /// Of what the scene gives, initially.
    pub(super) fn of(scene: &'a Scene) -> Self {
        Self { scene, digits: OnceCell::new(), state: None, digits_of_state: OnceCell::new() }
    }

    /// Looks at another state given.
    pub(super) fn at(&mut self, state: &'a scene::State) {
        (self.state, self.digits_of_state) = (Some(state), OnceCell::new());
    }

    /// What the digits of the state given leave open of what has such derivatives by the motion of a node: nothing where the node is as it is initially.
    fn of_motion(
        &self,
        element: &ConnectorElement,
        end: usize,
        node: &Node<f64>,
        [at, turn]: [[f64; 3]; 2],
    ) -> f64 {
        let is_initial = node.displacement == [0.0; 3] && node.triad == *element.triads()[end];
        let motion = element.nodes[end].and_then(|label| self.state?.nodes.get(&label));
        let (Some(state), Some(motion), false) = (self.state, motion, is_initial) else { return 0.0 };
        let digits = self.digits_of_state.get_or_init(|| DigitsOfState::of(state));
        let (displacement, angle) = digits.of_motion(motion);
        let moved: f64 = at.iter().zip(displacement).map(|(by, open)| by.abs() * open).sum();
        moved + norm(turn) * angle
    }

    /// How far the position of component k (0-based), initially or at the state given, may be from a limit that it is computed to be at.
    pub(super) fn open(
        &self,
        element: &ConnectorElement,
        state: &State<f64>,
        (k, position, limit): (usize, f64, f64),
    ) -> Open {
        let digits = self.digits.get_or_init(|| Digits::of(self.scene));
        let mut wanted = [false; 6];
        wanted[k] = true;
        let connector = &element.connector;
        let (branch, mut tally) = (connector.initial_branch(), Tally::default());
        let rows = Request::new(&[], wanted, 1);
        let found = connector.evaluate(state, &Increment::none(), &branch, &rows, &mut tally);
        let row = found.jacobian[k].unwrap_or_default();
        let given = self.scene.connectors.get(&element.label);
        let [a, b] = [End::A, End::B]
            .map(|end| given.and_then(|element| self.scene.position(element, end)).unwrap_or_default());
        let moved = sub(state.pair.b.displacement, state.pair.a.displacement);
        let length = norm(add(state.pair.reference, moved));
        let size = std::array::from_fn::<f64, { pintle_kinematics::node::DOFS }, _>(|j| dof_size(j, length));
        let [value, ..] = scales(position, &row, &[], (&size, &size), (&[], &[]), 1.0);
        let formula = C * U * value.first().copied().unwrap_or_default();
        let turned = |from: usize| row[from..from + 3].iter().map(|x| x.abs()).sum::<f64>();
        // The ground is where the other node is.
        let written = [0, 1].map(|end| {
            let label = element.nodes[end].or(element.nodes[1 - end])?;
            Some(self.scene.written.node(&label)?.sizes())
        });
        let coordinates = |end: usize, at: [f64; 3], node: &Node<f64>| -> f64 {
            let (from, sizes) = ([XA, XB][end], written[end].unwrap_or_default());
            let size = |i: usize| at[i].abs() + sizes[i] + 2.0 * node.displacement[i].abs();
            (0..3).map(|i| row[from + i].abs() * U * size(i)).sum()
        };
        let angles = uncertain_directions(self.scene, element);
        let rounding = coordinates(0, a, &state.pair.a)
            + coordinates(1, b, &state.pair.b)
            + turned(THETA_A) * angles[0]
            + turned(THETA_B) * angles[1]
            + formula
            + U * limit.abs();
        let reach = norm(element.reference);
        let by = |from: usize| [row[from], row[from + 1], row[from + 2]];
        let of_node = |end: usize, node: &Node<f64>| {
            let (at, turn) = (by([XA, XB][end]), by([THETA_A, THETA_B][end]));
            let position = element.nodes[end].map_or(0.0, |node| digits.of_position(&node, reach, at));
            position + self.of_motion(element, end, node, [at, turn])
        };
        let directions = digits.of_directions(&element.label);
        let of_digits = of_node(0, &state.pair.a)
            + of_node(1, &state.pair.b)
            + (turned(THETA_A) + turned(THETA_B)) * directions
            + Digits::of_number(limit);
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        Open { rounding: finite(rounding), digits: finite(of_digits) }
    }
}
