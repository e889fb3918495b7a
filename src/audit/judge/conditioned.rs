//! Where every relative error of 1e-9 must be noticed: on significant entries of well-conditioned components.
//!
//! That a mutant beyond twice the tolerance is noticed follows from the tolerance; that the tolerance is small does not. What must
//! be noticed is therefore said here without the bound: by the distance to singular sets and by the sizes of the numbers
//! themselves. Let s_j be the size of degree of freedom j, `S = Σ abs(∂f/∂q_j) s_j`, `S₂ = Σ abs(∂²f/∂q_j∂q_k) s_j s_k` and r the
//! largest `abs(q̇_j)/s_j`. A component is well-conditioned where its singular sets are at least 0.1 away, `abs(f) ≤ 10` (radians,
//! lengths of the connector), `0.3 ≤ S ≤ 30` of them, and `S₂ ≤ 30 S`. An entry is significant that is at least a thousandth of
//!
//! | of | size |
//! |---|---|
//! | a value | 1 rad, or the length of the connector |
//! | a first or second derivative, in units of the degrees of freedom | S |
//! | a rate | S r |
//! | an acceleration | S max abs(q̈_j)/s_j + (S + S₂) r² |

use crate::case::Case;
use crate::case::quantity::{Numbers, Quantity};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::node::dof_size;

/// The relative error that must be noticed.
pub const NOTICED: f64 = 1e-9;

/// The part of a size from which on an entry is significant.
const SIGNIFICANT: f64 = 1e-3;

/// The sizes from which on entries are significant; none of a component that is not well-conditioned.
#[derive(Clone, Debug, Default)]
pub struct Conditioned {
    /// Of each quantity, in the order of [`Quantity::ALL`], and component.
    least: [[Option<f64>; 6]; Quantity::ALL.len()],
    length: f64,
}

impl Conditioned {
    /// Of numbers at the end of a case; `units` are those of the components, `nearness` their distances to singular sets.
    pub fn new(numbers: &Numbers<f64>, case: &Case, units: &[Option<Unit>; 6], nearness: &[f64; 6]) -> Self {
        const CLEAR: f64 = 0.1;
        const LEAST: f64 = 1e-15;
        let mut found = Self { length: case.length, ..Self::default() };
        let Some(state) = case.last().map(|step| step.state) else { return found };
        let size = |j: usize| dof_size(j, case.length);
        let fastest = |rates: &[f64; DOFS]| {
            rates.iter().enumerate().fold(0.0_f64, |most, (j, rate)| most.max(rate.abs() / size(j)))
        };
        let (velocity, acceleration) = (fastest(&state.velocity), fastest(&state.acceleration));
        let sum = |quantity: Quantity, k: usize| {
            let entries = numbers.entries(quantity).0[k].as_ref()?;
            let sized = entries.iter().enumerate();
            Some(sized.map(|(i, x)| x.abs() * quantity.entry_size(i, case.length)).sum::<f64>())
        };
        for k in (0..6).filter(|k| nearness[*k] >= CLEAR) {
            let Some(unit) = units[k] else { continue };
            let unit = if unit == Unit::Length { case.length } else { 1.0 };
            let mut set = |quantity: Quantity, size: f64| {
                found.least[quantity as usize][k] = (size > 0.0).then_some(SIGNIFICANT * size);
            };
            let is_plain = |s: f64, s2: f64| (0.3..=30.0).contains(&(s / unit)) && s2 <= 30.0 * s;
            let value = numbers.entries(Quantity::Value).get(k, 0).filter(|value| value.abs() <= 10.0 * unit);
            let (first, second) = (sum(Quantity::FirstDerivatives, k), sum(Quantity::SecondDerivatives, k));
            if let (Some(_), Some(s), Some(s2)) = (value, first, second)
                && is_plain(s, s2)
            {
                set(Quantity::Value, unit);
                set(Quantity::FirstDerivatives, s);
                set(Quantity::SecondDerivatives, s);
                // A rate that is nothing beside what the acceleration makes of it in no time is not told by differences in time.
                if velocity >= LEAST * acceleration.sqrt() {
                    set(Quantity::Rate, s * velocity);
                }
                set(Quantity::Acceleration, s * acceleration + (s + s2) * velocity * velocity);
            }
            if let (Some(s), Some(s2)) = (sum(Quantity::NodalForces, k), sum(Quantity::GeometricStiffness, k))
                && is_plain(s, s2)
            {
                set(Quantity::NodalForces, s);
                set(Quantity::GeometricStiffness, s);
            }
        }
        found
    }

    /// Whether a relative error of [`NOTICED`] must be noticed on an entry.
    pub fn demands(&self, quantity: Quantity, k: usize, i: usize, entry: f64) -> bool {
        let least =
            self.least.get(quantity as usize).and_then(|of_quantity| of_quantity.get(k).copied().flatten());
        least.is_some_and(|least| entry.abs() * quantity.entry_size(i, self.length) >= least)
    }
}
