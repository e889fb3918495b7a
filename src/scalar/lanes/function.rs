//! Elementary functions without branches: one division at most, and polynomials.

use super::super::coefficients::{ARCTANGENT, LONG_LOG_0, LONG_LOG_1, LONG_LOG_2};
use super::{Lanes, MAX_ORDER, Real, Scalar, Series};

/// A quarter of π in two parts. The first has three zero bits at its end, so that up to eight of it are exact.
const QUARTER: f64 = f64::from_bits(std::f64::consts::FRAC_PI_4.to_bits() & !7);
const QUARTER_REST: f64 = 6.123_233_995_736_766e-17 / 2.0 + (std::f64::consts::FRAC_PI_4 - QUARTER);

/// The smallest number above 0, by which 0 may be divided.
const SMALLEST: f64 = f64::from_bits(1);

/// tan(π/8): beyond it an arctangent is taken from π/4.
const TAN_EIGHTH: f64 = 0.414_213_562_373_095_03;

/// Half of π in three parts, each of 33 bits, and beyond which angle a multiple of the first is not exact.
const HALF: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
const LARGE_ANGLE: f64 = 1e5;

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

/// Σ c_i xⁱ as two interleaved polynomials in x², which the processor evaluates side by side.
#[inline(always)]
fn polynomial<const FUSED: bool, const N: usize>(c: &[f64; N], x: Lanes<FUSED>) -> Lanes<FUSED> {
    let square = x * x;
    let (last, before) = (N - 1, N - 2);
    let mut own = Lanes::splat(c[last]);
    let mut other = Lanes::splat(c[before]);
    let mut i = before;
    while i >= 2 {
        own = own.multiply_add(square, Lanes::splat(c[i - 1]));
        other = other.multiply_add(square, Lanes::splat(c[i - 2]));
        i -= 2;
    }
    if i == 1 {
        // c[0] is left, and belongs to the powers of `own`.
        own = own.multiply_add(square, Lanes::splat(c[0]));
        return other.multiply_add(x, own);
    }
    own.multiply_add(x, other)
}

/// The angle of (x, y), 1.5 u; signs of zeros as IEEE 754 asks.
///
/// With t = smaller/larger of |x|, |y| in [0, 1]: atan t, or π/4 + atan((t − 1)/(t + 1)) beyond π/8, each by one division; then
/// the octant as a multiple of π/4. Which formula holds is a factor ±1 by the sign of a difference: masks do not vectorise.
#[inline(always)]
pub(super) fn arctangent<const FUSED: bool>(y: Lanes<FUSED>, x: Lanes<FUSED>) -> Lanes<FUSED> {
    let (one, two, half) = (Lanes::splat(1.0), Lanes::splat(2.0), Lanes::splat(0.5));
    let (across, along) = (y.magnitude(), x.magnitude());
    // 1 where |x| ≥ |y|, −1 elsewhere.
    let flat = one.with_sign_of(along - across);
    let smaller = across.lesser(along);
    let larger = across.greater(along);
    // 1 beyond π/8, 0 elsewhere and at the origin.
    let beyond = one.with_sign_of(larger * Lanes::splat(TAN_EIGHTH) - smaller).multiply_add(-half, half);
    let numerator = smaller - beyond * larger;
    let denominator = beyond.multiply_add(smaller, larger).greater(Lanes::splat(SMALLEST));
    let t = numerator / denominator;
    let square = t * t;
    let angle = (polynomial(&ARCTANGENT, square) * square).multiply_add(t, t);
    // The angle is quarters π/4 + turn·angle; each mirror is exact.
    let forwards = one.with_sign_of(x);
    let quarters = flat.multiply_add(beyond - one, one);
    let quarters = forwards.multiply_add(quarters - two, two);
    let turn = flat * forwards;
    let rest = quarters.multiply_add(Lanes::splat(QUARTER_REST), turn * angle);
    quarters.multiply_add(Lanes::splat(QUARTER), rest).with_sign_of(y)
}

/// (sin x, cos x), 1 u.
#[inline(always)]
pub(super) fn sine_cosine<const FUSED: bool>(x: Lanes<FUSED>) -> (Lanes<FUSED>, Lanes<FUSED>) {
    if !x.magnitude().less(Lanes::splat(LARGE_ANGLE)).all() {
        return (x.each(f64::sin), x.each(f64::cos));
    }
    let one = Lanes::splat(1.0);
    let quarter = (x * Lanes::splat(std::f64::consts::FRAC_2_PI)).nearest_integer();
    let mut r = x;
    for part in HALF {
        r = r - quarter * Lanes::splat(part);
    }
    let square = r * r;
    let sine = (polynomial(&SINE, square) * square).multiply_add(r, r);
    let half = square * Lanes::splat(0.5);
    let whole = one - half;
    // 1 − r²/2 with its rounding error.
    let lost = (one - whole) - half;
    let cosine = whole + (polynomial(&COSINE, square) * square).multiply_add(square, lost);
    // Which quarter turn: odd ones exchange sine and cosine, the second half changes signs.
    let half_turn = quarter * Lanes::splat(0.5);
    let odd = Lanes::splat(0.25).less((half_turn - half_turn.each(f64::floor)).magnitude());
    let (s, c) = (Lanes::select(odd, cosine, sine), Lanes::select(odd, sine, cosine));
    // sin is negative in quarters 2 and 3, cos in quarters 1 and 2.
    let below = |quarter: Lanes<FUSED>| {
        let quarters = quarter * Lanes::splat(0.25);
        Lanes::splat(0.4).less(quarters - quarters.each(f64::floor))
    };
    (Lanes::select(below(quarter), -s, s), Lanes::select(below(quarter + one), -c, c))
}

/// The sum of the squares.
#[inline(always)]
pub(super) fn square<const FUSED: bool, const N: usize>(v: [Lanes<FUSED>; N]) -> Lanes<FUSED> {
    let mut square = v[0] * v[0];
    for component in v.iter().skip(1) {
        square = component.multiply_add(*component, square);
    }
    square
}

/// Whether squares, and reciprocals of squares, are below 1e279 in every lane: nothing overflows, or loses digits to subnormals.
/// One comparison, of the sum.
#[inline(always)]
pub(super) fn is_usual<const FUSED: bool>(square: Lanes<FUSED>, inverse: Lanes<FUSED>) -> bool {
    let [a, b, c, d] = (square + inverse).0;
    (a + b) + (c + d) < 1e279
}

/// v/|v| and |v| of every magnitude.
#[cold]
#[inline(never)]
pub(super) fn any_direction_and_norm<const FUSED: bool, const N: usize>(
    v: [Lanes<FUSED>; N],
) -> ([Lanes<FUSED>; N], Lanes<FUSED>) {
    let (scale, square) = rescaled_square(v);
    let norm = square.square_root();
    let inverse = norm.reciprocal_or_zero();
    (v.map(|component| component * scale * inverse), norm / scale)
}

/// v/|v|² of every magnitude, 0 where that overflows.
#[cold]
#[inline(never)]
pub(super) fn any_inverted<const FUSED: bool, const N: usize>(v: [Lanes<FUSED>; N]) -> [Lanes<FUSED>; N] {
    let (scale, square) = rescaled_square(v);
    let inverse = square.reciprocal_or_zero();
    let inverted = v.map(|component| component * scale * inverse * scale);
    let sum = inverted.iter().fold(Lanes::splat(0.0), |sum, component| sum + component.magnitude());
    let infinite = Lanes::splat(f64::MAX).less(sum);
    inverted.map(|component| Lanes::select(infinite, Lanes::splat(0.0), component))
}

/// A power of two p for each lane such that the squares of p v neither overflow nor lose digits to subnormals, and |p v|².
fn rescaled_square<const FUSED: bool, const N: usize>(v: [Lanes<FUSED>; N]) -> (Lanes<FUSED>, Lanes<FUSED>) {
    let mut largest = Lanes::splat(0.0);
    for component in v {
        largest = largest.both(component, |m, x| m.max(x.abs()));
    }
    let scale = largest.each(|m| {
        if m > 1e140 {
            2f64.powi(-600)
        } else if m < 1e-140 {
            2f64.powi(600)
        } else {
            1.0
        }
    });
    let mut square = Lanes::splat(0.0);
    for component in v {
        square = square + (component * scale) * (component * scale);
    }
    (scale, square)
}

/// The coefficients of K at c in [0, 1], to the second.
#[inline(always)]
pub(super) fn log_series<const FUSED: bool>(c: Lanes<FUSED>, order: usize) -> Series<Lanes<FUSED>> {
    let mut series = [Lanes::splat(0.0); MAX_ORDER + 1];
    let y = (Lanes::splat(1.0) - c) * Lanes::splat(0.5);
    series[0] = polynomial(&LONG_LOG_0, y);
    if order > 0 {
        series[1] = polynomial(&LONG_LOG_1, y);
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
