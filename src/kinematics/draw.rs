//! A reproducible stream of numbers.

use crate::node::{DOFS, dof_size};
use crate::scalar::Real;
use crate::so3::exp;
use crate::vector::{Matrix, Vector, scale};
use std::f64::consts::PI;

/// By what the state of splitmix64 grows.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// The number of the sequence of splitmix64 that follows a state.
pub const fn splitmix64(state: u64) -> u64 {
    let mut z = state.wrapping_add(STEP);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A reproducible stream of numbers (splitmix64), seeded by a name (FNV-1a): the same on every machine and in every version.
#[derive(Clone, Debug)]
pub struct Draw {
    state: u64,
    /// Whether directions are along axes, and nodes turn about one of them.
    structured: bool,
}

impl Draw {
    /// The stream of that name.
    pub fn new(seed: &str) -> Self {
        let state = seed
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        Self { state, structured: false }
    }

    /// The same stream from here on with the structure that models have: directions along axes, zeros, nodes that turn about one axis.
    pub fn structured(&mut self) {
        self.structured = true;
    }

    /// Whether it has structure.
    pub const fn is_structured(&self) -> bool {
        self.structured
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        let drawn = splitmix64(self.state);
        self.state = self.state.wrapping_add(STEP);
        (drawn >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Below `count`, uniform.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Each component uniform in ±size.
    pub fn vector(&mut self, size: f64) -> Vector<f64> {
        [0; 3].map(|_| self.between(-size, size))
    }

    /// A unit vector, uniform on the sphere; along an axis where there is structure.
    pub fn direction(&mut self) -> Vector<f64> {
        if self.structured {
            let along = self.below(3);
            let sign = if self.unit() < 0.5 { 1.0 } else { -1.0 };
            return [0, 1, 2].map(|i| if i == along { sign } else { 0.0 });
        }
        loop {
            let v = self.vector(1.0);
            let (u, n) = f64::direction_and_norm(v);
            if (0.1..=1.0).contains(&n) {
                return u;
            }
        }
    }

    /// A rotation vector whose length is in [low, high].
    pub fn rotation(&mut self, low: f64, high: f64) -> Vector<f64> {
        let size = self.between(low, high);
        scale(self.direction(), size)
    }

    /// A triad in any orientation.
    pub fn triad(&mut self) -> Matrix<f64> {
        exp(self.rotation(0.0, PI))
    }

    /// Nodal rates: translations and flows of size `length`, rotations of size 1.
    pub fn rates(&mut self, length: f64) -> [f64; DOFS] {
        let mut rates = [0.0; DOFS];
        if self.structured {
            // Nothing moves, or one degree of freedom does.
            let only = self.below(2 * DOFS);
            if let Some(rate) = rates.get_mut(only) {
                *rate = dof_size(only, length);
            }
            return rates;
        }
        for (j, rate) in rates.iter_mut().enumerate() {
            *rate = self.between(-1.0, 1.0) * dof_size(j, length);
        }
        rates
    }
}
