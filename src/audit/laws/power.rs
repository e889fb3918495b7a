//! The law of power: rates and accelerations are those that the rows give along the motion, and the nodal forces do the work of the
//! component forces.

use crate::case::quantity::Quantity;
use crate::laws::{Claim, Context, Demand, Term, What};
use pintle_kinematics::catalog::Loading;
use pintle_kinematics::connector::{Output, Request, Tally};
use pintle_kinematics::node::{self, DOFS};
use pintle_kinematics::scalar::elementary::direction;
use pintle_kinematics::vector::{dot, sub};

/// ḟ − J q̇ and f̈ − J q̈ − q̇ᵀ H q̇ of row k, which are zero; and whether squares of rates underflow in them.
pub(crate) fn along_rows<const N: usize>(
    k: usize,
    v: &[f64; N],
    a: &[f64; N],
) -> (Vec<Term>, Vec<Term>, bool) {
    let row = |rates: &[f64; N]| {
        let terms = rates.iter().enumerate().filter(|(_, x)| **x != 0.0);
        terms.map(|(j, x)| (Quantity::FirstDerivatives, k, j, -x)).collect::<Vec<Term>>()
    };
    let mut rate = vec![(Quantity::Rate, k, 0, 1.0)];
    rate.extend(row(v));
    let mut acceleration = vec![(Quantity::Acceleration, k, 0, 1.0)];
    acceleration.extend(row(a));
    let mut underflows = false;
    for (j, x) in v.iter().enumerate().filter(|(_, x)| **x != 0.0) {
        for (l, y) in v.iter().enumerate().filter(|(_, y)| **y != 0.0) {
            underflows |= (x * y).abs() < f64::MIN_POSITIVE;
            if x * y != 0.0 {
                acceleration.push((Quantity::SecondDerivatives, k, j * N + l, -x * y));
            }
        }
    }
    (rate, acceleration, underflows)
}

impl Context<'_> {
    pub(super) fn power(&self) -> Vec<Demand> {
        let mut found = self.rates_along_rows();
        found.extend(self.power_of_forces());
        found
    }

    /// Whether the nodes move by a degree of freedom that changes something and has no column: rows do not tell of that.
    fn moves_beside(&self, is_there: &[bool; DOFS], changes: impl Fn(usize) -> bool) -> bool {
        let (v, a) = (&self.state.velocity, &self.state.acceleration);
        (0..DOFS).any(|j| changes(j) && !is_there[j] && (v[j] != 0.0 || a[j] != 0.0))
    }

    fn rates_along_rows(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        let (v, a) = (&self.state.velocity, &self.state.acceleration);
        for (k, measure) in self.components() {
            let beside = self.moves_beside(self.connector.active(), |j| self.depends(measure, j));
            if measure.has_nodal_rates() || beside {
                continue;
            }
            let (rate, acceleration, underflows) = along_rows(k, v, a);
            found.push(self.sum(rate, 0.0, What::of(Claim::AlongRows, Quantity::Rate, k, 0)));
            let what = What::of(Claim::AlongRows, Quantity::Acceleration, k, 0);
            let mut demand = self.sum(acceleration, 0.0, what);
            if underflows {
                // Squares of the rates are lost: nothing is decided.
                demand.allowed = f64::INFINITY;
            }
            found.push(demand);
        }
        found
    }

    /// The nodal forces of a unit force times the nodal velocities are the rate that the force is conjugate to:
    /// - of a force, that of its position;
    /// - of a moment about an axis that a carries, the relative rate of rotation about it;
    /// - of a tension, the rate of the length and of the flow.
    fn power_of_forces(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        let v = &self.state.velocity;
        let asked = Request::new(&[Output::CV], [true; 6], 0);
        let rates = self.connector.evaluate(
            &self.state,
            &self.increment,
            &self.before,
            &asked,
            &mut Tally::default(),
        );
        let part = |at: usize| [v[at], v[at + 1], v[at + 2]];
        for k in self.forces() {
            let (Some(loading), Some(position)) =
                (self.connector.connection().loading(k), self.connector.position_measure(k))
            else {
                continue;
            };
            if self.moves_beside(self.connector.reach(), |j| self.loads(k, j)) {
                continue;
            }
            let mut terms: Vec<_> =
                (0..DOFS).map(|j| (Quantity::NodalForces, k, j, v[j])).filter(|term| term.3 != 0.0).collect();
            let mut want = 0.0;
            match loading {
                // Its rates are not those of its position.
                Loading::Conjugate if position.has_nodal_rates() => continue,
                Loading::Conjugate if self.measure(k) == Some(position) => {
                    terms.push((Quantity::Rate, k, 0, -1.0));
                }
                Loading::Conjugate => match rates.velocity[k] {
                    Some(rate) => want = rate,
                    None => continue,
                },
                Loading::AlongA(_) | Loading::FrozenAxis(_) => {
                    let Some(axis) = self.connector.moment_axis(k, &self.state.pair.a.triad) else {
                        continue;
                    };
                    want = dot(axis, sub(part(node::THETA_B), part(node::THETA_A)));
                }
                Loading::Tension => {
                    // No product of two lengths, which may leave the range of doubles.
                    let along = direction(self.state.pair.separation());
                    let stretching = dot(along, sub(part(node::XB), part(node::XA)));
                    want = stretching + v[node::PSI_B] - v[node::PSI_A];
                }
            }
            let what = What::of(Claim::Power, Quantity::NodalForces, k, 0);
            let mut demand = self.sum(terms, want, what);
            // Both sides are rounded.
            demand.allowed *= 2.0;
            found.push(demand);
        }
        found
    }
}
