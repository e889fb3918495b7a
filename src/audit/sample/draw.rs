//! A reproducible stream of numbers.

use crate::audit::case::{dof_size, turn};
use crate::node::DOFS;
use crate::scalar::Real;
use crate::vector::{Matrix, Vector, scale};
use std::f64::consts::PI;

/// A reproducible stream of numbers (splitmix64), seeded by a name (FNV-1a): the same on every machine and in every version.
#[derive(Clone, Debug)]
pub struct Draw(u64);

impl Draw {
    /// The stream of that name.
    pub fn new(seed: &str) -> Self {
        Self(
            seed.bytes()
                .fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)),
        )
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
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

    /// A unit vector, uniform on the sphere.
    pub fn direction(&mut self) -> Vector<f64> {
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
        turn(self.rotation(0.0, PI))
    }

    /// Nodal rates: translations and flows of size `length`, rotations of size 1.
    pub fn rates(&mut self, length: f64) -> [f64; DOFS] {
        let mut rates = [0.0; DOFS];
        for (j, rate) in rates.iter_mut().enumerate() {
            *rate = self.between(-1.0, 1.0) * dof_size(j, length);
        }
        rates
    }
}
