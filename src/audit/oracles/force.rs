//! Nodal forces of unit component forces, and how they change: the product's, and what differences on 237-bit numbers say.
//!
//! Row k of [`Quantity::NodalForces`] holds the nodal forces of a unit force of component k, residual-side. They are the
//! derivatives of the position that is conjugate to it, of the length of a belt, or of the turn of b against a about the axis that
//! a constraint moment is printed about. [`Quantity::GeometricStiffness`] holds their derivatives: second derivatives where the row
//! is a gradient.

use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::case::{AtEnd, Case};
use crate::oracles::truth::{Displaced, Truth};
use pintle_kinematics::catalog::Loading;
use pintle_kinematics::connector::{Branch, Components, Connector, Mask, Output, Request, State, Tally};
use pintle_kinematics::force::Want;
use pintle_kinematics::node::{self, DOFS, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::scalar::{Scalar, Wide};
use pintle_kinematics::vector::{Vector, apply, dot, product, sub, transpose};
use pintle_kinematics::{Differentiable, so3};
use std::cell::LazyCell;

/// What the connector says of its forces at a state, into the numbers of that state.
pub(super) fn add_forces<R: Differentiable>(
    numbers: &mut Numbers<R>,
    connector: &Connector<R>,
    state: &State<R>,
    branch: &Branch<R>,
) {
    add_forces_of(numbers, connector, state, branch, [true; 6]);
}

/// The same of some components.
pub fn add_forces_of<R: Differentiable>(
    numbers: &mut Numbers<R>,
    connector: &Connector<R>,
    state: &State<R>,
    branch: &Branch<R>,
    components: Mask,
) {
    let want = Want { stiffness: true, ..Want::default() };
    let rows = connector.force_rows(state, branch, components, want, &mut Tally::default());
    let row = |k: usize| rows.row(k).map(|row| row.row.to_vec());
    let change = |k: usize| Some(rows.row(k)?.change.as_ref()?.as_flattened().to_vec());
    numbers.set(Quantity::NodalForces, Entries(std::array::from_fn(row)));
    numbers.set(Quantity::GeometricStiffness, Entries(std::array::from_fn(change)));
}

/// The product's numbers at the end of a case; `None` for an empty path.
pub fn product_with_forces(case: &Case) -> Option<Numbers<f64>> {
    Some(product_at(&case.at_end()?))
}

/// The same where the end is at hand.
pub fn product_at(end: &AtEnd<'_>) -> Numbers<f64> {
    let (evaluation, _) = end.evaluation(&crate::case::quantity::request());
    let mut numbers = Numbers::of(&evaluation);
    add_forces(&mut numbers, &end.connector, &end.step.state, &evaluation.branch);
    numbers
}

impl Truth {
    /// The rows of virtual work, as differences of what each force is conjugate to.
    pub fn force_rows(&self) -> Entries<Wide> {
        let empty = |k: usize| self.connector().has_force(k).then(|| vec![Wide::zero(); DOFS]);
        let of = |at: &Displaced, values: &Components<Wide>| self.conjugates(at, values);
        self.differenced(std::array::from_fn(empty), self.reach(), of)
    }

    /// What the forces are conjugate to, after the nodes have moved: functions whose derivatives are the rows. `values` are those
    /// there, positions but for their initial ones where these are what is differentiated.
    pub fn conjugates(&self, at: &Displaced, values: &Components<Wide>) -> Components<Wide> {
        let connector = self.connector();
        let is_value = |k: usize| connector.differentiated(k) == connector.position_measure(k);
        let is_conjugate = |k: usize| matches!(connector.connection().loading(k), Some(Loading::Conjugate));
        let others = [0, 1, 2, 3, 4, 5].map(|k| is_conjugate(k) && !is_value(k));
        let position = if others.contains(&true) {
            self.evaluate(at, &Request::new(&[Output::CP], others, 0)).position
        } else {
            [None; 6]
        };
        let (was, pair) = (self.state(), &at.state.pair);
        let turned = LazyCell::new(|| turned(&was.pair, pair));
        std::array::from_fn(|k| {
            if !connector.has_force(k) {
                return None;
            }
            match connector.connection().loading(k)? {
                Loading::Conjugate if connector.position_measure(k)?.is_one_form() => {
                    Some(self.accumulated(&at.by))
                }
                Loading::Conjugate => {
                    if is_value(k) {
                        values[k]
                    } else {
                        position[k]
                    }
                }
                // The belt is |d| long, and what flows in at a and out at b comes on top.
                Loading::Tension => Some(norm(pair.separation()) + pair.b.flow - pair.a.flow),
                Loading::AlongA(_) | Loading::FrozenAxis(_) => {
                    Some(dot(apply(&was.pair.a.triad, self.moment_axes[k]?), *turned))
                }
            }
        })
    }
}

/// How far b has turned more than a since a pair was there, for small turns.
fn turned(was: &Pair<Wide>, is: &Pair<Wide>) -> Vector<Wide> {
    let since = |was: &node::Node<Wide>, is: &node::Node<Wide>| {
        if is.triad == was.triad {
            return [Wide::zero(); 3];
        }
        so3::log(&product(&is.triad, &transpose(&was.triad)))
    };
    sub(since(&was.b, &is.b), since(&was.a, &is.a))
}
