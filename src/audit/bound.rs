//! The bound: how far two right answers may be apart, from the conditioning of the state and nothing else.
//!
//! With s_j the size of degree of freedom j (1 rad, or the connector's length), u = 2⁻⁵³, f a function with rows ∂f and second
//! derivatives ∂²f,
//!
//! > F = |f| + Σ_k |∂f/∂q_k| s_k,  F₂ = F + Σ_jk |∂²f/∂q_j∂q_k| s_j s_k,
//!
//! | of | tolerance |
//! |---|---|
//! | a value | C u F |
//! | a first derivative | C u (F/s_j + Σ_k abs(∂²f/∂q_j∂q_k) s_k) |
//! | a second derivative | C u F₂/(s_j s_k) · max(1, 1/δ) |
//! | a rate | Σ_j tol_j abs(q̇_j) |
//! | an acceleration | Σ_j tol_j abs(q̈_j) + C u F₂ max(1, 1/δ) max_j (q̇_j/s_j)² |
//!
//! Beside the third derivatives, which are not computed, stands their Cauchy estimate: within the distance δ of a singular set,
//! in radians or lengths, they are at most those of the second divided by δ. Lengths enter only relative to s, so the verdict
//! is the same in millimetres and metres and far from the origin.

use super::case::dof_size;
use super::quantity::{Entries, Numbers, Quantity};
use crate::node::{DOFS, NodalRates};

/// u = 2⁻⁵³, the unit of rounding of `f64`.
pub const U: f64 = 1.0 / 9_007_199_254_740_992.0;

/// C, stated in every report: how many roundings of the conditioned scale are allowed. The worst ever measured over the
/// catalogue is in `verify/audit.rs`.
pub const C: f64 = 4.0;

/// Tolerances and scales of everything that is judged at one state.
#[derive(Clone, Debug, Default)]
pub struct Bound {
    tolerance: Numbers<f64>,
    scale: Numbers<f64>,
}

impl Bound {
    /// From derivatives that are trusted: the wide oracle's, where it was asked.
    pub fn new(
        truth: &Numbers<f64>,
        velocity: &NodalRates<f64>,
        acceleration: &NodalRates<f64>,
        length: f64,
        nearness: f64,
    ) -> Self {
        let size: [f64; DOFS] = std::array::from_fn(|j| dof_size(j, length));
        let mut of = Self::default();
        let mut scales: [Entries<f64>; 5] = Default::default();
        for k in 0..6 {
            let Some(value) = truth.entries(Quantity::Value).get(k, 0) else { continue };
            let first = |j: usize| truth.entries(Quantity::FirstDerivatives).get(k, j).unwrap_or(0.0);
            let second = |j: usize, l: usize| {
                truth.entries(Quantity::SecondDerivatives).get(k, j * DOFS + l).unwrap_or(0.0)
            };
            let f = (0..DOFS).fold(value.abs(), |sum, j| sum + first(j).abs() * size[j]);
            let bent: [f64; DOFS] =
                std::array::from_fn(|j| (0..DOFS).map(|l| second(j, l).abs() * size[l]).sum());
            let f2 = (0..DOFS).fold(f, |sum, j| sum + bent[j] * size[j]);
            let near = if nearness > 0.0 { (1.0 / nearness).max(1.0) } else { 1.0 };
            let row: Vec<f64> = (0..DOFS).map(|j| f / size[j] + bent[j]).collect();
            let matrix: Vec<f64> =
                (0..DOFS * DOFS).map(|i| near * f2 / (size[i / DOFS] * size[i % DOFS])).collect();
            let rate: f64 = (0..DOFS).map(|j| row[j] * velocity[j].abs()).sum();
            let fastest = (0..DOFS).fold(0.0_f64, |most, j| most.max(velocity[j].abs() / size[j]));
            let pushed: f64 = (0..DOFS).map(|j| row[j] * acceleration[j].abs()).sum();
            let faster = pushed + near * f2 * fastest * fastest;
            for (scale, entries) in scales.iter_mut().zip([vec![f], row, matrix, vec![rate], vec![faster]]) {
                scale.0[k] = Some(entries);
            }
        }
        for (quantity, scale) in Quantity::ALL.into_iter().zip(scales) {
            of.tolerance.set(quantity, scale.map(|_, _, x| C * U * x));
            of.scale.set(quantity, scale);
        }
        of
    }

    /// How far an entry may be from the truth.
    pub fn tolerance(&self, quantity: Quantity, k: usize, i: usize) -> f64 {
        self.tolerance.entries(quantity).get(k, i).unwrap_or(0.0)
    }

    /// The conditioned scale of an entry: the tolerance is C u times it.
    pub fn scale(&self, quantity: Quantity, k: usize, i: usize) -> f64 {
        self.scale.entries(quantity).get(k, i).unwrap_or(0.0)
    }
}
