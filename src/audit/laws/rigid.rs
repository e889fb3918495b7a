//! Laws of rigid motions: what a connector measures and loads is between its nodes.
//!
//! A node may have no rotations, or be the ground; a connector may lie in a plane. Each law is asked of a component for the motions
//! that are there: those of which every degree of freedom by which the component changes is among its columns.

use crate::case::quantity::{OneOrMany, Quantity};
use crate::case::{Case, Step, carried};
use crate::judge::bound::{Bound, C};
use crate::laws::{Claim, Context, Demand, Term, What};
use crate::oracles::force::product_with_forces;
use pintle_kinematics::catalog::Loading;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{self, DOFS, dof_size};
use pintle_kinematics::scalar::U;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{Matrix, Vector, apply, cross};

/// How the axes are turned: far from every special rotation.
const TURN: Vector<f64> = [0.9, -1.3, 0.4];

/// The same in the plane, or in space.
pub(crate) fn turning(is_planar: bool) -> Vector<f64> {
    if is_planar { [0.0, 0.0, 1.3] } else { TURN }
}

/// A rotation, or the rate of one, where there is only that about 3; else as it is.
pub(crate) fn about_third(is_planar: bool, of: Vector<f64>) -> Vector<f64> {
    if is_planar { [0.0, 0.0, of[2]] } else { of }
}

/// A displacement, or the rate of one, where there is only the plane; else as it is.
pub(crate) fn along_plane(is_planar: bool, of: Vector<f64>) -> Vector<f64> {
    if is_planar { [of[0], of[1], 0.0] } else { of }
}

/// The places of both nodes' translations and rotations along an axis.
const fn both(a: usize, b: usize, i: usize) -> [usize; 2] {
    [a + i, b + i]
}

/// The direction of an axis.
pub(crate) fn axis(i: usize) -> Vector<f64> {
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
        let mut found: Vec<Demand> = components.flat_map(of).collect();
        if !self.asks(Quantity::SecondDerivatives) {
            return found;
        }
        let functions = self
            .components()
            .filter(|(_, measure)| !measure.is_one_form() && !self.is_fixed_in_space(*measure));
        for (k, measure) in functions {
            self.second_along_rigid_motions(k, |j| active[j] || !self.depends(measure, j), &mut found);
        }
        found
    }

    /// That a row vanishes along a rigid motion holds at every state, so that its derivative by every degree of freedom vanishes
    /// too. Let r be the motion, ω about a. Then `∂²f r + ∂f/∂x·(ω × e) = 0` for the translations e of either node, and
    /// `∂²f r + ½ ∂f/∂θ·(ω × e) = 0` for rotations about e. For of turns one after the other,
    /// `exp(s e^) exp(t ω^) = exp(s e^ + t ω^ + ½ s t (e × ω)^ + …)`.
    fn second_along_rigid_motions(
        &self,
        k: usize,
        is_there: impl Fn(usize) -> bool,
        found: &mut Vec<Demand>,
    ) {
        let (first, second) = (Quantity::FirstDerivatives, Quantity::SecondDerivatives);
        let separation = self.state.pair.separation();
        let [along, about] = self.motions();
        for j in (0..DOFS).filter(|j| self.connector.active()[*j]) {
            for i in along {
                let columns = both(node::XA, node::XB, *i);
                if columns.iter().all(|l| is_there(*l)) {
                    let terms = columns.map(|l| (second, k, j * DOFS + l, 1.0)).to_vec();
                    found.push(self.sum(terms, 0.0, What::of(Claim::Translation, second, k, j * DOFS + i)));
                }
            }
            for i in about {
                let arm = cross(axis(*i), separation);
                let turns = both(node::THETA_A, node::THETA_B, *i);
                let mut terms: Vec<_> = turns.map(|l| (second, k, j * DOFS + l, 1.0)).to_vec();
                terms.extend((0..3).map(|l| (second, k, j * DOFS + node::XB + l, arm[l])));
                let (component, half) = (j % 7 % 3, if matches!(j % 7, 3..=5) { 0.5 } else { 1.0 });
                if j % 7 != 6 {
                    let moved = cross(axis(*i), axis(component));
                    terms.extend((0..3).map(|l| (first, k, j - component + l, half * moved[l])));
                }
                terms.retain(|term| term.3 != 0.0);
                if terms.iter().all(|(_, _, l, _)| is_there(l % DOFS)) {
                    found.push(self.sum(terms, 0.0, What::of(Claim::Rotation, second, k, j * DOFS + i)));
                }
            }
        }
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
    pub(crate) fn turned(&self) -> (Matrix<f64>, Case) {
        let rotation = exp(turning(self.case.definition.planar));
        let mut state = self.state;
        state.pair = carried(&self.state.pair, &rotation, [0.0; 3]);
        for rates in [&mut state.velocity, &mut state.acceleration] {
            for at in VECTORS {
                let turned = apply(&rotation, [rates[at], rates[at + 1], rates[at + 2]]);
                rates[at..at + 3].copy_from_slice(&turned);
            }
        }
        (rotation, self.beside(self.case.definition.clone(), state, self.after))
    }

    /// What an entry changes by to second order where every degree of freedom is rounded by ε = C u of its size. A value f changes
    /// by `½ Σ_jk abs(∂²f/∂q_j∂q_k) ε_j ε_k`. A derivative, or a nodal force, changes by Cauchy's estimate
    /// `(ε/δ)² Σ_j abs(∂f/∂q_j) s_j` over the size (of matrices by ε/δ), δ from a singular set. Near one, at a symmetric state, the
    /// first order may vanish.
    fn bent(&self, quantity: Quantity, k: usize) -> impl Fn(usize) -> f64 {
        let length = self.case.length;
        let size = |j: usize| dof_size(j, length);
        let both = |i: usize| size(i / DOFS) * size(i % DOFS);
        let sum = |of: Quantity, by: &dyn Fn(usize) -> f64| -> f64 {
            let all = self.numbers.entries(of).0[k].iter().flatten().enumerate();
            all.map(|(i, x)| x.abs() * by(i)).sum()
        };
        let rounded = C * U / self.nearness[k];
        let total = match quantity {
            Quantity::Value => 0.5 * (C * U).powi(2) * sum(Quantity::SecondDerivatives, &both),
            Quantity::Rate | Quantity::Acceleration => {
                let fastest = |rates: &[f64; DOFS]| {
                    rates.iter().enumerate().fold(0.0_f64, |most, (j, rate)| most.max(rate.abs() / size(j)))
                };
                let (v, a) = (fastest(&self.state.velocity), fastest(&self.state.acceleration));
                let first = sum(Quantity::FirstDerivatives, &size);
                let changes = if quantity == Quantity::Rate {
                    first * v
                } else {
                    first * a + sum(Quantity::SecondDerivatives, &both) * v * v
                };
                rounded.powi(2) * changes
            }
            _ => {
                // Of matrices, whose third derivatives no tolerance knows, to first order.
                let order = if quantity.entries() > DOFS { 1 } else { 2 };
                rounded.powi(order) * sum(quantity, &|i| quantity.entry_size(i, length))
            }
        };
        move |i| if quantity.entries() == 1 { total } else { total / quantity.entry_size(i, length) }
    }

    pub(super) fn frame(&self) -> Vec<Demand> {
        let (rotation, turned) = self.turned();
        let Some(twin) = product_with_forces(&turned) else { return Vec::new() };
        // Turned inputs are rounded, so that the state there is another one; close to a singular set it may be where derivatives are far larger.
        // No multiple of the tolerance here limits that: at a symmetric state it may be nothing here.
        let there = turned.last().map(|Step { state, .. }| {
            let length = self.case.length;
            Bound::of_components(&twin, state, length, &self.nearness)
        });
        let mut found = Vec::new();
        for (k, measure) in self.components() {
            if self.is_fixed_in_space(measure) {
                continue;
            }
            for quantity in Quantity::ALL.into_iter().filter(|quantity| self.compares(*quantity, k)) {
                let is_value = quantity == Quantity::Value;
                if is_value && measure.is_one_form() || twin.entries(quantity).0[k].is_none() {
                    continue;
                }
                let bent = self.bent(quantity, k);
                let is_matrix = quantity.entries() == DOFS * DOFS;
                // Of second derivatives that are symmetric one half tells.
                let is_half = is_matrix && !measure.is_one_form();
                for i in (0..quantity.entries()).filter(|i| !is_half || i % DOFS <= i / DOFS) {
                    let terms = turned_terms(&rotation, quantity, k, i);
                    let of_twin = |(q, k, i, c): &(Quantity, usize, usize, f64)| {
                        c * twin.entries(*q).get(*k, *i).unwrap_or(f64::NAN)
                    };
                    let want = terms.iter().map(of_twin).sum();
                    let one = OneOrMany::One([(quantity, k, i, 1.0)]);
                    let mut demand = self.sum(one, want, What::of(Claim::TurnedAxes, quantity, k, i));
                    // Three roundings in each direction; a component of a vector is as uncertain as the vector; and to second order four times as
                    // much is rounded.
                    let here = Self::around(self.bound, quantity, k, i);
                    let of_twin = there.as_ref().map_or(0.0, |there| Self::around(there, quantity, k, i));
                    demand.allowed = 4.0 * demand.allowed.max(of_twin).max(here);
                    demand.allowed += 16.0 * bent(i);
                    found.push(demand);
                }
            }
        }
        found
    }
}

/// The places of vectors in a row.
const VECTORS: [usize; 4] = [node::XA, node::THETA_A, node::XB, node::THETA_B];

/// The sum of entries in turned axes that an entry is: R the rotation, Rᵀ times the vector of a node, Rᵀ ∂²f R of two.
pub(crate) fn turned_terms(rotation: &Matrix<f64>, quantity: Quantity, k: usize, i: usize) -> Vec<Term> {
    // The columns that make up a column, with their factors.
    let columns = |j: usize| {
        let component = j % 7 % 3;
        let is_flow = j % 7 == 6;
        (0..if is_flow { 1 } else { 3 })
            .map(move |l| if is_flow { (j, 1.0) } else { (j - component + l, rotation[l][component]) })
    };
    match quantity.entries() {
        1 => vec![(quantity, k, i, 1.0)],
        DOFS => columns(i).map(|(j, c)| (quantity, k, j, c)).collect(),
        _ => {
            let rows = columns(i / DOFS);
            let both = rows.flat_map(|(j, x)| columns(i % DOFS).map(move |(l, y)| (j * DOFS + l, x * y)));
            both.map(|(place, c)| (quantity, k, place, c)).collect()
        }
    }
}
