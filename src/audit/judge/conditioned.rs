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
use pintle_kinematics::node::{DOFS, dof_size};

/// The relative error that must be noticed.
pub const NOTICED: f64 = 1e-9;

/// The part of a size from which on an entry is significant.
const SIGNIFICANT: f64 = 1e-3;

/// How far from its singular sets, in radians or lengths, a function is well-conditioned.
pub(crate) const CLEAR: f64 = 0.1;

/// The sizes from which on numbers of a well-conditioned function are significant: derivatives in units of the degrees of freedom; 0
/// where nothing is demanded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Least {
    pub(crate) value: f64,
    pub(crate) derivative: f64,
    pub(crate) rate: f64,
    pub(crate) acceleration: f64,
}

impl Least {
    /// Of f, S and S₂, the unit of f, and the largest rates of the degrees of freedom in their units; `None` where it is not
    /// well-conditioned.
    pub(crate) fn of(
        (f, s, s2): (f64, f64, f64),
        unit: f64,
        [velocity, acceleration]: [f64; 2],
    ) -> Option<Self> {
        const LEAST: f64 = 1e-15;
        let is_plain = f.abs() <= 10.0 * unit && (0.3..=30.0).contains(&(s / unit)) && s2 <= 30.0 * s;
        // A rate that is nothing beside what the acceleration makes of it in no time is not told by differences in time.
        let moves = velocity >= LEAST * acceleration.sqrt();
        is_plain.then_some(Self {
            value: SIGNIFICANT * unit,
            derivative: SIGNIFICANT * s,
            rate: if moves { SIGNIFICANT * s * velocity } else { 0.0 },
            acceleration: SIGNIFICANT * (s * acceleration + (s + s2) * velocity * velocity),
        })
    }

    /// Whether a relative error of [`NOTICED`] must be noticed on a number of a quantity, `size` being that of the degrees of freedom by
    /// which it is a derivative.
    pub(crate) fn demands(&self, quantity: Quantity, entry: f64, size: f64) -> bool {
        let least = match quantity {
            Quantity::Value => self.value,
            Quantity::FirstDerivatives | Quantity::SecondDerivatives => self.derivative,
            Quantity::Rate => self.rate,
            Quantity::Acceleration => self.acceleration,
            _ => 0.0,
        };
        least > 0.0 && entry.abs() * size >= least
    }
}

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
                found.least[quantity as usize][k] = (size > 0.0).then_some(size);
            };
            let value = numbers.entries(Quantity::Value).get(k, 0);
            let (first, second) = (sum(Quantity::FirstDerivatives, k), sum(Quantity::SecondDerivatives, k));
            if let (Some(value), Some(s), Some(s2)) = (value, first, second)
                && let Some(least) = Least::of((value, s, s2), unit, [velocity, acceleration])
            {
                set(Quantity::Value, least.value);
                set(Quantity::FirstDerivatives, least.derivative);
                set(Quantity::SecondDerivatives, least.derivative);
                set(Quantity::Rate, least.rate);
                set(Quantity::Acceleration, least.acceleration);
            }
            if let (Some(s), Some(s2)) = (sum(Quantity::NodalForces, k), sum(Quantity::GeometricStiffness, k))
                && let Some(least) = Least::of((0.0, s, s2), unit, [0.0; 2])
            {
                set(Quantity::NodalForces, least.derivative);
                set(Quantity::GeometricStiffness, least.derivative);
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
