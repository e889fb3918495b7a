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
    fn paired(self, pairs: [[f64; 2]; 4]) -> [Four; 2];

    /// The second number first, and the first last.
    fn rotated(self, of: Four) -> Four;

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
    fn paired(self, [a, b, c, d]: [[f64; 2]; 4]) -> [Four; 2] {
        [0, 1].map(|i| [a[i], b[i], c[i], d[i]])
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rotated(self, [a, b, c, d]: Four) -> Four {
        [b, c, d, a]
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
    fn paired(self, [a, b, c, d]: [[f64; 2]; 4]) -> [Four; 2] {
        let avx = self.avx;
        let both = |low: [f64; 2], high: [f64; 2]| {
            avx._mm256_insertf128_pd::<1>(avx._mm256_castpd128_pd256(cast(low)), cast(high))
        };
        let (ac, bd) = (both(a, c), both(b, d));
        [cast(avx._mm256_unpacklo_pd(ac, bd)), cast(avx._mm256_unpackhi_pd(ac, bd))]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rotated(self, of: Four) -> Four {
        cast(self.avx2._mm256_permute4x64_pd::<0b00_11_10_01>(cast(of)))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn opposite(self, of: Four) -> Four {
        cast(self.avx._mm256_sub_pd(self.avx._mm256_setzero_pd(), cast(of)))
    }
}
