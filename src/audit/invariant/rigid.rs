//! Laws of rigid motions: what a connector measures and loads is between its nodes.
//!
//! A node may have no rotations, or be the ground; a connector may lie in a plane. Each law is asked of a component for the motions
//! that are there: those of which every degree of freedom by which the component changes is among its columns.

use super::{Claim, Context, Demand, What};
use crate::audit::bound::{C, U};
use crate::audit::case::{Case, carried, dof_size, turn};
use crate::audit::quantity::{OneOrMany, Quantity};
use crate::catalog::Loading;
use crate::measure::Measure;
use crate::node::{self, DOFS};
use crate::vector::{Matrix, Vector, apply_transposed, cross};

/// The places of both nodes' translations and rotations along an axis.
const fn both(a: usize, b: usize, i: usize) -> [usize; 2] {
    [a + i, b + i]
}

fn axis(i: usize) -> Vector<f64> {
    let mut axis = [0.0; 3];
    axis[i] = 1.0;
    axis
}

impl Context<'_> {
    /// Whether a rigid motion can change the component: the direction of a coincident AXIAL is fixed in space.
    pub(super) fn is_fixed_in_space(&self, measure: Measure) -> bool {
        matches!(measure, Measure::Distance) && self.state.pair.separation() == [0.0; 3]
    }

    /// The axes along which a rigid motion translates, and about which it turns: of a two-dimensional connector those of its plane.
    const fn motions(&self) -> [&'static [usize]; 2] {
        if self.case.definition.planar { [&[0, 1], &[2]] } else { [&[0, 1, 2], &[0, 1, 2]] }
    }

    /// The sums of a row along the rigid motions of which it has every column.
    fn along_rigid_motions(
        &self,
        (quantity, k): (Quantity, usize),
        is_there: impl Fn(usize) -> bool,
    ) -> Vec<Demand> {
        let separation = self.state.pair.separation();
        let [along, about] = self.motions();
        let mut found = Vec::new();
        for i in along {
            let columns = both(node::XA, node::XB, *i);
            if columns.iter().all(|j| is_there(*j)) {
                let terms = columns.map(|j| (quantity, k, j, 1.0)).to_vec();
                found.push(self.sum(terms, 0.0, What::of(Claim::Translation, quantity, k, *i)));
            }
        }
        for i in about {
            let arm = cross(axis(*i), separation);
            let mut terms = both(node::THETA_A, node::THETA_B, *i).map(|j| (quantity, k, j, 1.0)).to_vec();
            terms.extend((0..3).map(|j| (quantity, k, node::XB + j, arm[j])));
            terms.retain(|term| term.3 != 0.0);
            if terms.iter().all(|(_, _, j, _)| is_there(*j)) {
                found.push(self.sum(terms, 0.0, What::of(Claim::Rotation, quantity, k, *i)));
            }
        }
        found
    }

    pub(super) fn rigid_modes(&self) -> Vec<Demand> {
        let active = self.connector.active();
        let components = self.components().filter(|(_, measure)| !self.is_fixed_in_space(*measure));
        let of = |(k, measure): (usize, Measure)| {
            self.along_rigid_motions((Quantity::FirstDerivatives, k), |j| {
                active[j] || !self.depends(measure, j)
            })
        };
        components.flat_map(of).collect()
    }

    /// Whether the force of component k loads a degree of freedom, as its declaration says.
    pub(super) fn loads(&self, k: usize, j: usize) -> bool {
        match self.connector.connection().loading(k) {
            Some(Loading::Conjugate) => {
                self.connector.position_measure(k).is_some_and(|measure| self.depends(measure, j))
            }
            Some(Loading::Tension) => match j % 7 {
                3..=5 => false,
                6 => self.connector.connection().flow[j / 7],
                _ => true,
            },
            Some(Loading::AlongA(_) | Loading::FrozenAxis(_)) => matches!(j % 7, 3..=5),
            None => false,
        }
    }

    /// The components that have a force and are not on a singular set.
    pub(super) fn forces(&self) -> impl Iterator<Item = usize> + '_ {
        (0..6)
            .filter(|k| self.is_smooth[*k])
            .filter(|k| self.numbers.entries(Quantity::NodalForces).0[*k].is_some())
    }

    /// Forces sum to zero, and so do moments about a: M_a + M_b + d × F_b.
    pub(super) fn equilibrium(&self) -> Vec<Demand> {
        let reach = self.connector.reach();
        let is_fixed = |k: usize| {
            self.connector.position_measure(k).is_some_and(|measure| self.is_fixed_in_space(measure))
        };
        let of = |k: usize| {
            self.along_rigid_motions((Quantity::NodalForces, k), |j| reach[j] || !self.loads(k, j))
        };
        self.forces().filter(|k| !is_fixed(*k)).flat_map(of).collect()
    }

    /// The state in turned axes, and the rotation: one that is far from every special one, about the third axis where the connector lies in a plane.
    pub(in crate::audit) fn turned(&self) -> (Matrix<f64>, Case) {
        let rotation = turn(if self.case.definition.planar { [0.0, 0.0, 1.3] } else { [0.9, -1.3, 0.4] });
        let mut state = self.state;
        state.pair = carried(&self.state.pair, &rotation, [0.0; 3]);
        (rotation, self.beside(self.case.definition.clone(), state, self.after))
    }

    /// What a number changes by to second order where every degree of freedom is rounded by ε = C u of its size: a value f by
    /// ½ Σ_jk abs(∂²f/∂q_j∂q_k) ε_j ε_k; a first derivative, or a nodal force, by Cauchy's estimate (ε/δ)² Σ_j abs(∂f/∂q_j) s_j over the size, δ from
    /// a singular set. Near one, at a symmetric state, the first order may vanish.
    fn bent(&self, quantity: Quantity, k: usize, i: usize) -> f64 {
        let size = |j: usize| dof_size(j, self.case.length);
        let sum = |of: Quantity, by: &dyn Fn(usize) -> f64| -> f64 {
            let all = self.numbers.entries(of).0[k].iter().flatten().enumerate();
            all.map(|(i, x)| x.abs() * by(i)).sum()
        };
        if quantity == Quantity::Value {
            let both = |i: usize| size(i / DOFS) * size(i % DOFS);
            return 0.5 * (C * U).powi(2) * sum(Quantity::SecondDerivatives, &both);
        }
        (C * U / self.nearness[k]).powi(2) * sum(quantity, &size) / size(i)
    }

    pub(super) fn frame(&self) -> Vec<Demand> {
        let (rotation, turned) = self.turned();
        let twin = self.numbers_of(&turned);
        let mut found = Vec::new();
        for (k, measure) in self.components() {
            if self.is_fixed_in_space(measure) {
                continue;
            }
            // The turned inputs are rounded: three roundings in each direction.
            let wider = |mut demand: Demand| {
                demand.allowed *= 4.0;
                demand
            };
            if let (Some(want), false) = (twin.entries(Quantity::Value).get(k, 0), measure.is_one_form()) {
                let terms = OneOrMany::One([(Quantity::Value, k, 0, 1.0)]);
                let what = What::of(Claim::TurnedAxes, Quantity::Value, k, 0);
                let mut demand = wider(self.sum(terms, want, what));
                // Four times as much is rounded.
                demand.allowed += 16.0 * self.bent(Quantity::Value, k, 0);
                found.push(demand);
            }
            let vectors = [Quantity::FirstDerivatives, Quantity::NodalForces]
                .into_iter()
                .flat_map(|q| [node::XA, node::THETA_A, node::XB, node::THETA_B].map(|at| (q, at)));
            for (quantity, at) in vectors {
                let Some(row) = &twin.entries(quantity).0[k] else { continue };
                let back = apply_transposed(&rotation, [row[at], row[at + 1], row[at + 2]]);
                for (i, want) in back.into_iter().enumerate() {
                    let terms = OneOrMany::One([(quantity, k, at + i, 1.0)]);
                    let what = What::of(Claim::TurnedAxes, quantity, k, at + i);
                    let mut demand = wider(self.sum(terms, want, what));
                    // A component of a vector is as uncertain as the vector.
                    demand.allowed = (0..3)
                        .map(|j| 4.0 * self.tolerance(quantity, k, at + j))
                        .sum::<f64>()
                        .max(demand.allowed);
                    demand.allowed += 16.0 * self.bent(quantity, k, at + i);
                    found.push(demand);
                }
            }
        }
        found
    }
}
