//! Philox4x32-10: random numbers by their index, of Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3" (2011).

use pintle_kinematics::vector::Vector;

const ROUNDS: usize = 10;
const MULTIPLIER: [u32; 2] = [0xd251_1f53, 0xcd9e_8d57];
const WEYL: [u32; 2] = [0x9e37_79b9, 0xbb67_ae85];

/// The four numbers that belong to a counter under a key.
pub const fn philox([mut a, mut b, mut c, mut d]: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    let mut round = 0;
    while round < ROUNDS {
        let first = MULTIPLIER[0] as u64 * a as u64;
        let second = MULTIPLIER[1] as u64 * c as u64;
        [a, b, c, d] = [
            (second >> 32) as u32 ^ b ^ key[0],
            second as u32,
            (first >> 32) as u32 ^ d ^ key[1],
            first as u32,
        ];
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
        round += 1;
    }
    [a, b, c, d]
}

/// The numbers of one state: they depend on the key and the index of the state alone.
#[derive(Clone, Debug)]
pub struct Stream {
    key: [u32; 2],
    index: u64,
    block: u32,
}

impl Stream {
    /// Those of a state.
    pub const fn new(key: u64, index: u64) -> Self {
        Self { key: [key as u32, (key >> 32) as u32], index, block: 0 }
    }

    /// The next two numbers of 64 bits.
    pub const fn bits(&mut self) -> [u64; 2] {
        let [a, b, c, d] = philox([self.index as u32, (self.index >> 32) as u32, self.block, 0], self.key);
        self.block = self.block.wrapping_add(1);
        [(a as u64) << 32 | b as u64, (c as u64) << 32 | d as u64]
    }

    /// The next two, uniform in [−1, 1).
    pub const fn signed(&mut self) -> [f64; 2] {
        let [a, b] = self.bits();
        [uniform(a), uniform(b)]
    }

    /// A vector in a cube of half the side `size`.
    pub const fn cube(&mut self, size: f64) -> Vector<f64> {
        let ([x, y], [z, _]) = (self.signed(), self.signed());
        [x * size, y * size, z * size]
    }

    /// A point in the unit disc, with the square of its distance from the middle, which is not zero.
    pub fn disc(&mut self) -> ([f64; 2], f64) {
        loop {
            let [x, y] = self.signed();
            let square = x * x + y * y;
            if square < 1.0 && square > f64::MIN_POSITIVE {
                return ([x, y], square);
            }
        }
    }
}

/// 53 of the bits as a number in [−1, 1).
const fn uniform(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::{Stream, philox};

    /// The known answers of Random123, `kat_vectors`.
    #[test]
    fn philox_gives_the_published_answers() {
        let all = u32::MAX;
        let known = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([all; 4], [all; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, answer) in known {
            assert_eq!(philox(counter, key), answer);
        }
    }

    #[test]
    fn numbers_are_spread() {
        let (mut sum, mut square, mut inside) = (0.0, 0.0, 0);
        const COUNT: u64 = 20_000;
        for index in 0..COUNT {
            let [x, y] = Stream::new(7, index).signed();
            assert!((-1.0..1.0).contains(&x) && (-1.0..1.0).contains(&y));
            (sum, square) = (sum + x, square + y * y);
            inside += u64::from(x * x + y * y < 1.0);
        }
        let count = COUNT as f64;
        let off =
            [sum / count, square / count - 1.0 / 3.0, inside as f64 / count - std::f64::consts::FRAC_PI_4];
        assert!(off.iter().all(|off| off.abs() < 0.02), "{off:?}");
    }
}
