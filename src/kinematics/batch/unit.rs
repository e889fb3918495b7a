//! The moves between numbers of a state and lanes, in the instructions of a vector unit.

use crate::batch::Four;
#[cfg(target_arch = "x86_64")]
use pulp::cast;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::__m256d;

/// A vector unit, as far as numbers are moved. The processor has it where there is a value of it.
pub(super) trait Unit: Copy {
    /// Rows as columns.
    fn transposed(self, rows: [Four; 4]) -> [Four; 4];

    /// The first numbers of four pairs, and the second ones.
    fn lanes_of_pairs(self, pairs: [[f64; 2]; 4]) -> [Four; 2];

    /// The pairs of four first numbers and four second ones.
    fn to_pairs(self, of: [Four; 2]) -> [[f64; 2]; 4];

    /// The first, second and third numbers of four triples that stand one after the other.
    fn lanes_of_threes(self, of: [Four; 3]) -> [Four; 3];

    /// X + (b − a) of each.
    fn separation(self, reference: Four, a: Four, b: Four) -> Four;

    /// 0 − x of each: no zero is negative.
    fn opposite(self, of: Four) -> Four;
}

/// Every other processor than those named below.
#[derive(Clone, Copy, Debug)]
pub(super) struct Any;

impl Unit for Any {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn transposed(self, [a, b, c, d]: [Four; 4]) -> [Four; 4] {
        [0, 1, 2, 3].map(|i| [a[i], b[i], c[i], d[i]])
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lanes_of_pairs(self, [a, b, c, d]: [[f64; 2]; 4]) -> [Four; 2] {
        [[a[0], b[0], c[0], d[0]], [a[1], b[1], c[1], d[1]]]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_pairs(self, [a, b]: [Four; 2]) -> [[f64; 2]; 4] {
        [[a[0], b[0]], [a[1], b[1]], [a[2], b[2]], [a[3], b[3]]]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lanes_of_threes(self, [a, b, c]: [Four; 3]) -> [Four; 3] {
        [[a[0], a[3], b[2], c[1]], [a[1], b[0], b[3], c[2]], [a[2], b[1], c[0], c[3]]]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn separation(self, reference: Four, a: Four, b: Four) -> Four {
        let of = |lane: usize| reference[lane] + (b[lane] - a[lane]);
        [of(0), of(1), of(2), of(3)]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn opposite(self, [a, b, c, d]: Four) -> Four {
        [0.0 - a, 0.0 - b, 0.0 - c, 0.0 - d]
    }
}

#[cfg(target_arch = "x86_64")]
impl Unit for pulp::x86::V3 {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn transposed(self, [a, b, c, d]: [Four; 4]) -> [Four; 4] {
        let (a, b, c, d): (__m256d, __m256d, __m256d, __m256d) = (cast(a), cast(b), cast(c), cast(d));
        let avx = self.avx;
        let (ab, cd) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpacklo_pd(c, d));
        let (ab_odd, cd_odd) = (avx._mm256_unpackhi_pd(a, b), avx._mm256_unpackhi_pd(c, d));
        [
            cast(avx._mm256_permute2f128_pd::<0x20>(ab, cd)),
            cast(avx._mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd)),
            cast(avx._mm256_permute2f128_pd::<0x31>(ab, cd)),
            cast(avx._mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd)),
        ]
    }

    /// Halves of a register come from memory as they are, so that two shuffles do what four would.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lanes_of_pairs(self, [a, b, c, d]: [[f64; 2]; 4]) -> [Four; 2] {
        let avx = self.avx;
        let both = |low: [f64; 2], high: [f64; 2]| {
            avx._mm256_insertf128_pd::<1>(avx._mm256_castpd128_pd256(cast(low)), cast(high))
        };
        let (ac, bd) = (both(a, c), both(b, d));
        [cast(avx._mm256_unpacklo_pd(ac, bd)), cast(avx._mm256_unpackhi_pd(ac, bd))]
    }

    /// Halves go to memory as they are. Where arrays begin at a multiple of 16 bytes, as those of glibc and NumPy do, no half crosses a
    /// line of the cache.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_pairs(self, [a, b]: [Four; 2]) -> [[f64; 2]; 4] {
        let avx = self.avx;
        let (even, odd) =
            (avx._mm256_unpacklo_pd(cast(a), cast(b)), avx._mm256_unpackhi_pd(cast(a), cast(b)));
        [
            cast(avx._mm256_castpd256_pd128(even)),
            cast(avx._mm256_castpd256_pd128(odd)),
            cast(avx._mm256_extractf128_pd::<1>(even)),
            cast(avx._mm256_extractf128_pd::<1>(odd)),
        ]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lanes_of_threes(self, [a, b, c]: [Four; 3]) -> [Four; 3] {
        let avx = self.avx;
        let (a, b, c): (__m256d, __m256d, __m256d) = (cast(a), cast(b), cast(c));
        let ab = avx._mm256_blend_pd::<0b1100>(a, b);
        let ac = avx._mm256_permute2f128_pd::<0x21>(a, c);
        let bc = avx._mm256_blend_pd::<0b1100>(b, c);
        [
            cast(avx._mm256_shuffle_pd::<0b1010>(ab, ac)),
            cast(avx._mm256_shuffle_pd::<0b0101>(ab, bc)),
            cast(avx._mm256_shuffle_pd::<0b1010>(ac, bc)),
        ]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn separation(self, reference: Four, a: Four, b: Four) -> Four {
        let avx = self.avx;
        let apart = avx._mm256_sub_pd(cast(b), cast(a));
        cast(avx._mm256_add_pd(cast(reference), apart))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn opposite(self, of: Four) -> Four {
        cast(self.avx._mm256_sub_pd(self.avx._mm256_setzero_pd(), cast(of)))
    }
}
