//! The Sobol sequence: of any 2ᵏ consecutive points from a multiple of 2ᵏ on, each of 2ᵏ equal parts of a coordinate holds one.
//!
//! Direction numbers are those of Joe and Kuo, "Constructing Sobol sequences with better two-dimensional projections" (2008), `new-joe-kuo-6`.
//! A seed scrambles a coordinate as Owen proposed, "Randomly permuted (t,m,s)-nets and (t,s)-sequences" (1995). Each bit is flipped or not, by a
//! hash of the bits above it; that keeps what is said above. The hash has the form of Laine and Karras, "Stratified sampling for stochastic
//! transparency" (2011).

/// How many coordinates a point has.
pub const DIMENSIONS: usize = 20;

/// The bits of an index, and of a coordinate.
const BITS: usize = 64;

/// For each coordinate but the first: the inner coefficients of its primitive polynomial, and the first direction integers, as many as its degree.
const JOE_KUO: [(u64, &[u64]); DIMENSIONS - 1] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
    (1, &[1, 3, 3, 9, 7, 49]),
    (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]),
    (19, &[1, 1, 1, 15, 7, 5]),
    (22, &[1, 3, 1, 15, 13, 25]),
    (25, &[1, 1, 5, 5, 19, 61]),
    (1, &[1, 3, 7, 11, 23, 15, 103]),
];

/// What each bit of an index adds to a coordinate, modulo 2.
const DIRECTIONS: [[u64; BITS]; DIMENSIONS] = {
    let mut all = [[0; BITS]; DIMENSIONS];
    let mut bit = 0;
    while bit < BITS {
        all[0][bit] = 1 << (BITS - 1 - bit);
        bit += 1;
    }
    let mut dimension = 1;
    while dimension < DIMENSIONS {
        let (inner, first) = JOE_KUO[dimension - 1];
        let (degree, of) = (first.len(), &mut all[dimension]);
        let mut bit = 0;
        while bit < BITS {
            if bit < degree {
                of[bit] = first[bit] << (BITS - 1 - bit);
            } else {
                of[bit] = of[bit - degree] ^ (of[bit - degree] >> degree);
                let mut back = 1;
                while back < degree {
                    of[bit] ^= (inner >> (degree - 1 - back) & 1) * of[bit - back];
                    back += 1;
                }
            }
            bit += 1;
        }
        dimension += 1;
    }
    all
};

/// A coordinate of a point of the sequence, times 2⁶⁴, not scrambled. Those beyond [`DIMENSIONS`] are the first ones again.
pub const fn sobol(mut index: u64, dimension: usize) -> u64 {
    let of = &DIRECTIONS[dimension % DIMENSIONS];
    let mut sum = 0;
    while index != 0 {
        sum ^= of[index.trailing_zeros() as usize];
        index &= index - 1;
    }
    sum
}

/// A coordinate, times 2⁶⁴, scrambled.
///
/// With its bits in reverse, what a product with an even number, a sum or a product with an odd one does to a bit depends on lower ones alone.
pub const fn scrambled(coordinate: u64, seed: u64) -> u64 {
    const EVEN: [u64; 3] = [0x9e37_79b9_7f4a_7c16, 0xbf58_476d_1ce4_e5b8, 0x94d0_49bb_1331_11ea];
    let mut x = coordinate.reverse_bits();
    x ^= x.wrapping_mul(EVEN[0]);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 32 | 1);
    x ^= x.wrapping_mul(EVEN[1]);
    x ^= x.wrapping_mul(EVEN[2]);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::{DIMENSIONS, scrambled, sobol};
    use pintle_kinematics::draw::splitmix64;

    /// Of 2ᵏ points from a multiple of 2ᵏ on, each of 2ᵏ equal parts of each coordinate holds one; so does each box of the first two.
    #[test]
    fn every_part_of_a_coordinate_has_its_share() {
        let mut looked = 0;
        for (power, block) in [(1, 5), (5, 0), (8, 3), (10, 1), (12, 977), (8, (1 << 42) + 3)] {
            let points = block << power..(block + 1) << power;
            let at = |index: u64, dimension: usize| {
                scrambled(sobol(index, dimension), splitmix64(dimension as u64))
            };
            let is_one_each = |part: &dyn Fn(u64) -> u64| {
                let mut held = vec![0_u32; 1 << power];
                points.clone().for_each(|index| held[part(index) as usize] += 1);
                held.iter().all(|count| *count == 1)
            };
            for dimension in 0..DIMENSIONS {
                assert!(is_one_each(&|index| at(index, dimension) >> (64 - power)), "{dimension}, 2^{power}");
                looked += 1;
            }
            for wide in 0..=power {
                let high = |x: u64, bits: u32| x.unbounded_shr(64 - bits);
                let of = |index: u64| {
                    high(at(index, 0), wide) << (power - wide) | high(at(index, 1), power - wide)
                };
                assert!(is_one_each(&of), "2^{wide} by 2^{}", power - wide);
                looked += 1;
            }
        }
        assert_eq!(looked, 6 * DIMENSIONS + 44 + 6);
    }

    /// What SciPy 1.17.1 gives, `scipy.stats.qmc.Sobol(20, scramble=False, bits=32)`, at these indices; it counts them by a Gray code.
    #[test]
    fn points_are_those_of_another_program() {
        let known: [(u64, [u32; DIMENSIONS]); 2] = [
            (
                1_000,
                [
                    0x17c0_0000,
                    0x2940_0000,
                    0x7340_0000,
                    0xe8c0_0000,
                    0xfe40_0000,
                    0x29c0_0000,
                    0x0440_0000,
                    0xa3c0_0000,
                    0xffc0_0000,
                    0x1f40_0000,
                    0x3b40_0000,
                    0xfcc0_0000,
                    0x23c0_0000,
                    0xeec0_0000,
                    0xe140_0000,
                    0x0440_0000,
                    0xaac0_0000,
                    0x6ec0_0000,
                    0xc340_0000,
                    0x7340_0000,
                ],
            ),
            (
                33_554_427,
                [
                    0xdfff_ff80,
                    0x2181_8180,
                    0xe000_a780,
                    0x0a7f_ff80,
                    0x6510_c980,
                    0x23c9_3180,
                    0x1d55_7780,
                    0xf606_fb80,
                    0xea6f_7180,
                    0x2b7f_5080,
                    0x74dc_8f80,
                    0x5798_0080,
                    0x7280_0c80,
                    0xa73c_f380,
                    0x0262_6780,
                    0x1966_f980,
                    0xf757_5d80,
                    0x57b1_1980,
                    0x2b93_1980,
                    0x4cbd_8880,
                ],
            ),
        ];
        for (index, point) in known {
            for (dimension, known) in point.into_iter().enumerate() {
                assert_eq!(sobol(index, dimension), u64::from(known) << 32, "{index}, {dimension}");
            }
        }
    }

    /// Owen's scramble: a bit decides itself and about half of the lower ones, but none above it.
    #[test]
    fn a_bit_is_flipped_by_those_above_it() {
        const TRIED: u64 = 4000;
        for bit in [63, 62, 60, 50, 40, 20] {
            let mut flipped = [0_u64; 64];
            for i in 0..TRIED {
                let (x, seed) = (splitmix64(2 * i), splitmix64(2 * i + 1));
                let changed = scrambled(x, seed) ^ scrambled(x ^ 1 << bit, seed);
                assert_eq!(changed.leading_zeros(), 63 - bit, "{x:x} {seed:x}");
                flipped.iter_mut().enumerate().for_each(|(at, count)| *count += changed >> at & 1);
            }
            // Five standard deviations, of half the root of those tried.
            let is_half = |count: &u64| count.abs_diff(TRIED / 2) < 160;
            assert!(flipped[..bit as usize].iter().all(is_half), "{bit}: {flipped:?}");
        }
    }
}
