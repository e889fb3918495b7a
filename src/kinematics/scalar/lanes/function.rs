//! Elementary functions without branches: one division at most, and polynomials.

use crate::scalar::coefficients::{ARCTANGENT, LONG_LOG_0, LONG_LOG_1, LONG_LOG_2};
use crate::scalar::lanes::{LANES, LaneMask, Lanes, MAX_ORDER, Real, Scalar, Series};

/// A quarter of π in two parts. The first happens to have three zero bits at its end, so that up to eight of it are exact.
const QUARTER: f64 = std::f64::consts::FRAC_PI_4;
const QUARTER_REST: f64 = 3.061_616_997_868_383e-17;

/// The smallest number above 0, by which 0 may be divided.
const SMALLEST: f64 = f64::from_bits(1);

/// tan(π/8): beyond it an arctangent is taken from π/4.
const TAN_EIGHTH: f64 = 0.414_213_562_373_095_03;

/// Half of π in three parts, the first two of 33 bits, and beyond which angle sines are those of doubles.
const HALF: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
const LARGE_ANGLE: f64 = 1e5;

/// 1.5 · 2⁵²: a small number added to it is rounded to an integer, whose last bits are those of the sum.
const COUNTER: f64 = 6_755_399_441_055_744.0;

/// sin r = r + r³ (…) and cos r = 1 − r²/2 + r⁴ (…) for |r| ≤ π/4: fits of fdlibm (Sun Microsystems, 1993), ascending powers of r².
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_007e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Σ c_i xⁱ as interleaved polynomials, which the processor evaluates side by side: two in x², of long ones four in x⁴. Of longer
/// chains the compiler makes no vectors.
#[cfg_attr(not(debug_assertions), inline(always))]
fn polynomial<const FUSED: bool, const N: usize>(c: &[f64; N], x: Lanes<FUSED>) -> Lanes<FUSED> {
    const { assert!(4 <= N && N <= 32, "not as many coefficients as are written out") };
    let square = x * x;
    if const { N < 16 } {
        return part::<FUSED, N, 1, 2>(c, square).multiply_add(x, part::<FUSED, N, 0, 2>(c, square));
    }
    let fourth = square * square;
    let low = part::<FUSED, N, 1, 4>(c, fourth).multiply_add(x, part::<FUSED, N, 0, 4>(c, fourth));
    let high = part::<FUSED, N, 3, 4>(c, fourth).multiply_add(x, part::<FUSED, N, 2, 4>(c, fourth));
    high.multiply_add(square, low)
}

/// Σ c_i yʲ over i = FIRST + j STEP.
#[cfg_attr(not(debug_assertions), inline(always))]
fn part<const FUSED: bool, const N: usize, const FIRST: usize, const STEP: usize>(
    c: &[f64; N],
    y: Lanes<FUSED>,
) -> Lanes<FUSED> {
    let mut sum = Lanes::splat(c[const { FIRST + (N - 1 - FIRST) / STEP * STEP }]);
    // Written out, as `unrolled` does.
    macro_rules! terms {
        ($($j:literal)+) => {
            $(if const { FIRST + ($j + 1) * STEP < N } {
                sum = sum.multiply_add(y, Lanes::splat(c[FIRST + $j * STEP]));
            })+
        };
    }
    terms!(6 5 4 3 2 1 0);
    sum
}

/// The angle of (x, y), 2.4 u; signs of zeros as IEEE 754 asks.
///
/// With t = smaller/larger of |x|, |y| in [0, 1]: atan t, or π/4 + atan((t − 1)/(t + 1)) beyond π/8, each by one division. Then
/// comes the octant as a multiple of π/4.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn arctangent<const FUSED: bool>(y: Lanes<FUSED>, x: Lanes<FUSED>) -> Lanes<FUSED> {
    let (one, two, four) = (Lanes::splat(1.0), Lanes::splat(2.0), Lanes::splat(4.0));
    let (across, along) = (y.magnitude(), x.magnitude());
    let (smaller, larger) = (across.lesser(along), along.greater(across));
    // Negative beyond π/8, and beyond π/4.
    let eighth = larger * Lanes::splat(TAN_EIGHTH) - smaller;
    let quarter = along - across;
    let numerator = Lanes::by_sign(eighth, smaller - larger, smaller);
    let denominator = Lanes::by_sign(eighth, smaller + larger, larger.greater(Lanes::splat(SMALLEST)));
    let t = numerator / denominator;
    let square = t * t;
    let angle = (polynomial(&ARCTANGENT, square) * square).multiply_add(t, t);
    // The angle is quarters π/4 ± angle; each mirror is exact.
    let quarters = Lanes::by_sign(eighth, one, Lanes::splat(0.0));
    let quarters = Lanes::by_sign(quarter, two - quarters, quarters);
    let quarters = Lanes::by_sign(x, four - quarters, quarters);
    let angle = angle.mirrored_by(quarter).mirrored_by(x);
    let rest = quarters.multiply_add(Lanes::splat(QUARTER_REST), angle);
    quarters.multiply_add(Lanes::splat(QUARTER), rest).with_sign_of(y)
}

/// (sin x, cos x), 1.8 u of |x| < π, 2.7 u of larger angles.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn sine_cosine<const FUSED: bool>(x: Lanes<FUSED>) -> (Lanes<FUSED>, Lanes<FUSED>) {
    let found = of_small_angles(x);
    let is_small = x.magnitude().less(Lanes::splat(LARGE_ANGLE));
    if is_small.all() { found } else { of_large_angles(x, is_small, found) }
}

/// Those of doubles where an angle is large or NaN: what a lane has does not depend on others.
#[cold]
#[inline(never)]
fn of_large_angles<const FUSED: bool>(
    x: Lanes<FUSED>,
    is_small: LaneMask,
    (sine, cosine): (Lanes<FUSED>, Lanes<FUSED>),
) -> (Lanes<FUSED>, Lanes<FUSED>) {
    (Lanes::select(is_small, sine, x.each(f64::sin)), Lanes::select(is_small, cosine, x.each(f64::cos)))
}

/// (sin x, cos x) of |x| < [`LARGE_ANGLE`].
#[cfg_attr(not(debug_assertions), inline(always))]
fn of_small_angles<const FUSED: bool>(x: Lanes<FUSED>) -> (Lanes<FUSED>, Lanes<FUSED>) {
    let one = Lanes::splat(1.0);
    let counted = x.multiply_add(Lanes::splat(std::f64::consts::FRAC_2_PI), Lanes::splat(COUNTER));
    let quarter = counted - Lanes::splat(COUNTER);
    let mut r = x;
    unrolled!(i < 3, {
        r = r - quarter * Lanes::splat(HALF[i]);
    });
    let square = r * r;
    let sine = (polynomial(&SINE, square) * square).multiply_add(r, r);
    let half = square * Lanes::splat(0.5);
    let whole = one - half;
    // 1 − r²/2 with its rounding error.
    let lost = (one - whole) - half;
    let cosine = whole + (polynomial(&COSINE, square) * square).multiply_add(square, lost);
    // Odd quarter turns exchange sine and cosine. The sine is negative in quarters 2 and 3, the cosine in 1 and 2.
    let sign_from = |bit: u32, more: u64| {
        counted.each(|count| f64::from_bits(count.to_bits().wrapping_add(more) << (63 - bit)))
    };
    let odd = sign_from(0, 0);
    let (s, c) = (Lanes::by_sign(odd, cosine, sine), Lanes::by_sign(odd, sine, cosine));
    (s.mirrored_by(sign_from(1, 0)), c.mirrored_by(sign_from(1, 1)))
}

/// The sum of the squares.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn square<const FUSED: bool, const N: usize>(v: [Lanes<FUSED>; N]) -> Lanes<FUSED> {
    let mut square = v[0] * v[0];
    unrolled!(i < N, {
        if i > 0 {
            square = v[i].multiply_add(v[i], square);
        }
    });
    square
}

/// The exponent of a double.
const EXPONENT: u64 = 0x7ff << 52;

/// Powers of two p and 1/p that bring the largest of |v| into [1, 2), and p v, whose squares neither overflow nor lose digits to
/// subnormals: 0 where v = 0.
#[cfg_attr(not(debug_assertions), inline(always))]
fn rescaled<const FUSED: bool, const N: usize>(v: [Lanes<FUSED>; N]) -> (Lanes<FUSED>, [Lanes<FUSED>; N]) {
    let mut largest = v[0].magnitude();
    unrolled!(i < N, {
        if i > 0 {
            largest = v[i].magnitude().greater(largest);
        }
    });
    let scale = opposite_power(largest);
    let mut scaled = v;
    unrolled!(i < N, {
        scaled[i] = v[i] * scale;
    });
    (scale, scaled)
}

/// 2⁻ᵉ where 2ᵉ ≤ x < 2ᵉ⁺¹; 2¹⁰²³ at 0.
#[cfg_attr(not(debug_assertions), inline(always))]
fn opposite_power<const FUSED: bool>(x: Lanes<FUSED>) -> Lanes<FUSED> {
    const SUM: u64 = (2 * 1023) << 52;
    x.each(|lane| f64::from_bits(SUM.wrapping_sub(lane.to_bits() & EXPONENT)))
}

/// |p v|², and 1/|p v|²: the square is at least 1, but for v = 0, where any factor will do, and for subnormal numbers, whose
/// reciprocals would overflow.
#[cfg_attr(not(debug_assertions), inline(always))]
fn square_and_inverse<const FUSED: bool, const N: usize>(
    scaled: [Lanes<FUSED>; N],
) -> (Lanes<FUSED>, Lanes<FUSED>) {
    let square = square(scaled);
    (square, Lanes::splat(1.0) / square.greater(Lanes::splat(1.0)))
}

/// v/|v| and |v|. The division is that of [`inverted`], beside the square root.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn direction_and_norm<const FUSED: bool, const N: usize>(
    v: [Lanes<FUSED>; N],
) -> ([Lanes<FUSED>; N], Lanes<FUSED>) {
    let (scale, scaled) = rescaled(v);
    let (square, inverse) = square_and_inverse(scaled);
    let norm = square.square_root();
    let factor = norm * inverse;
    let mut unit = scaled;
    unrolled!(i < N, {
        unit[i] = scaled[i] * factor;
    });
    (unit, norm * opposite_power(scale))
}

/// v/|v|².
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn inverted<const FUSED: bool, const N: usize>(v: [Lanes<FUSED>; N]) -> [Lanes<FUSED>; N] {
    let (scale, scaled) = rescaled(v);
    let factor = square_and_inverse(scaled).1 * scale;
    let mut inverted = scaled;
    unrolled!(i < N, {
        inverted[i] = scaled[i] * factor;
    });
    inverted
}

/// The smallest square of a direction cosine that counts: nearer to 0 than that, the reciprocal would overflow.
const SMALLEST_SQUARE: f64 = 1e-300;

/// v/|v|² and |v| of direction cosines, as they are.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn inverted_cosines<const FUSED: bool, const N: usize>(
    v: [Lanes<FUSED>; N],
) -> ([Lanes<FUSED>; N], Lanes<FUSED>) {
    let square = square(v);
    let inverse = Lanes::splat(1.0) / square.greater(Lanes::splat(SMALLEST_SQUARE));
    let mut inverted = v;
    unrolled!(i < N, {
        inverted[i] = v[i] * inverse;
    });
    (inverted, square.square_root())
}

/// The unit quaternion, w ≥ 0, of a rotation R: the column of 4 q qᵀ with the largest diagonal entry.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn quaternion<const FUSED: bool>(r: &[[Lanes<FUSED>; 3]; 3]) -> [Lanes<FUSED>; 4] {
    let one = Lanes::splat(1.0);
    let (sum, difference) = (r[1][1] + r[2][2], r[1][1] - r[2][2]);
    let (plus, minus) = (one + r[0][0], one - r[0][0]);
    let diagonal = [plus + sum, plus - sum, minus + difference, minus - difference];
    let (x, y, z) = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]);
    let (xy, xz, yz) = (r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]);
    let (upper, first) =
        larger((diagonal[0], [diagonal[0], x, y, z]), (diagonal[1], [x, diagonal[1], xy, xz]));
    let (lower, last) =
        larger((diagonal[2], [y, xy, diagonal[2], yz]), (diagonal[3], [z, xz, yz, diagonal[3]]));
    let (largest, column) = larger((upper, first), (lower, last));
    // |column|² is 4 times its diagonal entry. Adding zero makes +0 of −0, whose sign is none.
    let sign = column[0] + Lanes::splat(0.0);
    let inverse = (Lanes::splat(0.5) / largest.square_root()).with_sign_of(sign);
    [column[0] * inverse, column[1] * inverse, column[2] * inverse, column[3] * inverse]
}

/// What stands with the larger key, and that key.
#[cfg_attr(not(debug_assertions), inline(always))]
fn larger<const FUSED: bool>(
    a: (Lanes<FUSED>, [Lanes<FUSED>; 4]),
    b: (Lanes<FUSED>, [Lanes<FUSED>; 4]),
) -> (Lanes<FUSED>, [Lanes<FUSED>; 4]) {
    let difference = a.0 - b.0;
    let mut column = a.1;
    unrolled!(i < 4, {
        column[i] = Lanes::by_sign(difference, b.1[i], a.1[i]);
    });
    (a.0.greater(b.0), column)
}

/// cos x and sin x / (2 x) of x = √s / 2, without derivatives.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn exp_series<const FUSED: bool>(s: Lanes<FUSED>) -> (Series<Lanes<FUSED>>, Series<Lanes<FUSED>>) {
    let half = Lanes::splat(0.5);
    let x = s.square_root() * half;
    let (sine, cosine) = sine_cosine(x);
    let (mut w, mut k) =
        const { ([Lanes([0.0; LANES]); MAX_ORDER + 1], [Lanes([0.0; LANES]); MAX_ORDER + 1]) };
    w[0] = cosine;
    // Nearer to zero than this, sin x is x. NaN is not less.
    k[0] = Lanes::select(x.less(Lanes::splat(1e-8)), half, half * (sine / x));
    (w, k)
}

#[cold]
#[inline(never)]
pub(super) fn exp_series_lane_by_lane<const FUSED: bool>(
    s: Lanes<FUSED>,
    order: usize,
) -> (Series<Lanes<FUSED>>, Series<Lanes<FUSED>>) {
    let part = |which: usize| {
        s.lane_by_lane(|lane| {
            let (w, k) = f64::exp_series(lane, order);
            if which == 0 { w } else { k }
        })
    };
    (part(0), part(1))
}

/// Those of (K − 2)/y: 2 is added last, and leaves nothing but its own rounding.
const LONG_LOG_BEYOND_TWO: [f64; LONG_LOG_0.len() - 1] = {
    let mut c = [0.0; LONG_LOG_0.len() - 1];
    let mut i = 0;
    while i < c.len() {
        c[i] = LONG_LOG_0[i + 1];
        i += 1;
    }
    c
};

/// The coefficients of K at c in [0, 1], to the second.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn log_series<const FUSED: bool>(c: Lanes<FUSED>, order: usize) -> Series<Lanes<FUSED>> {
    let mut series = const { [Lanes([0.0; LANES]); MAX_ORDER + 1] };
    let y = ((Lanes::splat(1.0) - c) * Lanes::splat(0.5)).kept();
    series[0] = polynomial(&LONG_LOG_BEYOND_TWO, y).multiply_add(y, Lanes::splat(LONG_LOG_0[0])).kept();
    if order > 0 {
        series[1] = polynomial(&LONG_LOG_1, y).kept();
    }
    if order > 1 {
        series[2] = polynomial(&LONG_LOG_2, y - Lanes::splat(0.25));
    }
    series
}

#[cold]
#[inline(never)]
pub(super) fn log_series_lane_by_lane<const FUSED: bool>(
    c: Lanes<FUSED>,
    order: usize,
) -> Series<Lanes<FUSED>> {
    c.lane_by_lane(|lane| f64::log_series(lane, order))
}
