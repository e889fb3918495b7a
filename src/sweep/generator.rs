//! Which point of the unit cube belongs to an index, and what its coordinates are made into.
//!
//! But for roots, only sums, products and quotients are computed, which every machine rounds alike.

use crate::philox::philox;
use crate::sobol::{scrambled, sobol};
use pintle_kinematics::draw::splitmix64;
use pintle_kinematics::so3::Quaternion;
use pintle_kinematics::vector::Vector;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

pintle_kinematics::named! {
    /// Where the numbers of a state come from: the n-th is a matter of its index and a key alone.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Generator {
        /// Philox4x32-10: random ones.
        #[default]
        Philox = "philox",
        /// The Sobol sequence, scrambled by the key: points that lie more evenly than random ones.
        Sobol = "sobol",
    }
}

impl Generator {
    /// The one of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }
}

/// The numbers of one state.
#[derive(Clone, Debug)]
pub struct Stream {
    generator: Generator,
    key: u64,
    index: u64,
    /// How many were taken.
    taken: usize,
    /// The second half of a block of Philox.
    kept: u64,
}

impl Stream {
    /// Those of a state.
    pub const fn new(generator: Generator, key: u64, index: u64) -> Self {
        Self { generator, key, index, taken: 0, kept: 0 }
    }

    /// What tells it from others.
    pub fn name(&self) -> String {
        format!("{:x} {}", self.key, self.index)
    }

    /// How many numbers were taken.
    pub const fn taken(&self) -> usize {
        self.taken
    }

    /// The next number, times 2⁶⁴.
    pub const fn bits(&mut self) -> u64 {
        let Self { key, index, taken, .. } = *self;
        self.taken += 1;
        match self.generator {
            Generator::Sobol => scrambled(sobol(index, taken), splitmix64(splitmix64(key) ^ taken as u64)),
            Generator::Philox if taken % 2 == 1 => self.kept,
            Generator::Philox => {
                let counter = [index as u32, (index >> 32) as u32, (taken / 2) as u32, 0];
                let [a, b, c, d] = philox(counter, [key as u32, (key >> 32) as u32]);
                self.kept = (c as u64) << 32 | d as u64;
                (a as u64) << 32 | b as u64
            }
        }
    }

    /// The next as one of 0 to `count` − 1.
    pub const fn below(&mut self, count: u64) -> u64 {
        ((self.bits() as u128 * count as u128) >> 64) as u64
    }

    /// The next, uniform in [0, 1).
    pub const fn unit(&mut self) -> f64 {
        unit(self.bits())
    }

    /// The next, uniform in [−1, 1).
    pub const fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// A vector in a cube of half the side `size`.
    pub fn cube(&mut self, size: f64) -> Vector<f64> {
        [(); 3].map(|()| self.signed() * size)
    }

    /// A point of the unit circle.
    pub fn circle(&mut self) -> [f64; 2] {
        circle(self.bits())
    }

    /// Uniform on the rotations (Shoemake, "Uniform random rotations", 1992).
    pub fn rotation(&mut self) -> Quaternion<f64> {
        let part = self.unit();
        let ([x, y], [z, w]) = (self.circle(), self.circle());
        let (one, other) = ((1.0 - part).sqrt(), part.sqrt());
        [one * x, one * y, other * z, other * w]
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vector<f64> {
        let part = self.unit();
        let [x, y] = self.circle();
        let root = 2.0 * (part * (1.0 - part)).sqrt();
        [x * root, y * root, 1.0 - 2.0 * part]
    }
}

/// 53 of the bits as a number in [0, 1).
const fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// The point of the unit circle at 2π times what the bits are, less π/4: the series of the cosine and the sine within π/4, turned by right angles.
fn circle(bits: u64) -> [f64; 2] {
    let angle = (unit(bits << 2) - 0.5) * FRAC_PI_2;
    let square = angle * angle;
    // Term n is the one before times −x²/((n − 1) n); what comes after the last is below 2⁻⁵⁵.
    let series = |last: i32| {
        (2..=last).rev().step_by(2).fold(1.0, |sum, n| 1.0 - sum * square / f64::from((n - 1) * n))
    };
    let (cos, sin) = (series(16), angle * series(17));
    match bits >> 62 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

#[cfg(test)]
mod tests {
    use super::{Generator, Stream, circle, unit};
    use crate::sobol::DIMENSIONS;
    use std::f64::consts::{FRAC_PI_4, TAU};

    #[test]
    fn a_circle_is_round() {
        let mut most = 0.0_f64;
        for i in 0..4096_u64 {
            let bits = i << 52 | i.wrapping_mul(0x9e37_79b9) << 10;
            let (sin, cos) = (unit(bits) * TAU - FRAC_PI_4).sin_cos();
            let [x, y] = circle(bits);
            most = most.max((x - cos).abs()).max((y - sin).abs());
            assert!((x * x + y * y - 1.0).abs() < 4e-16, "{x} {y}");
        }
        // The angle of the other computation is rounded, to 4e-16 rad.
        assert!(most < 1e-15, "{most:e}");
    }

    /// Of a Sobol sequence all coordinates of point 0 are zero, and those of others related: each has a scramble of its own.
    #[test]
    fn every_coordinate_is_scrambled_by_itself() {
        for generator in Generator::ALL {
            let stream = &mut Stream::new(generator, 7, 0);
            let mut point: Vec<u64> = (0..DIMENSIONS).map(|_| stream.bits() >> 32).collect();
            point.sort_unstable();
            point.dedup();
            assert_eq!(point.len(), DIMENSIONS, "{generator:?}");
        }
    }

    /// Means over the whole cube, of every generator: a Sobol sequence comes nearer by more than a factor of ten.
    #[test]
    fn numbers_are_spread() {
        const COUNT: u64 = 1 << 14;
        let off = |generator: Generator| {
            let mut sums = [0.0; 4];
            for index in 0..COUNT {
                let stream = &mut Stream::new(generator, 7, index);
                let [w, x, y, z] = stream.rotation();
                assert!((w * w + x * x + y * y + z * z - 1.0).abs() < 1e-15);
                let direction = stream.direction();
                let (cube, flow, one) = (stream.cube(1.0), stream.signed(), stream.below(24));
                assert!((-1.0..1.0).contains(&flow) && one < 24);
                let terms = [
                    w * w * w * w - 1.0 / 8.0,
                    direction[0] * direction[0] - 1.0 / 3.0,
                    (cube[0] * cube[1] * cube[2]).abs() - 1.0 / 8.0,
                    one as f64 - 11.5,
                ];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term / COUNT as f64);
                assert!(stream.taken() <= DIMENSIONS);
            }
            sums.map(f64::abs)
        };
        let [random, sobol] = Generator::ALL.map(off);
        assert!(random.iter().all(|off| *off < 0.1), "{random:?}");
        assert!(sobol.iter().all(|off| *off < 1e-3), "{sobol:?}");
        let sum = |of: [f64; 4]| of.iter().sum::<f64>();
        assert!(sum(random) > 10.0 * sum(sobol), "{random:?} {sobol:?}");
    }
}
