//! [`Wide`]: a 237-bit [`Real`] with textbook formulas, the truth that `f64` is judged by.

use crate::scalar::{MAX_ORDER, Real, Scalar, Series};
use ::f256::{consts, f256};
use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::cmp::Ordering;
use std::fmt;
use std::iter::{Product, Sum};
use std::num::ParseFloatError;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};
use std::str::FromStr;
use std::sync::LazyLock;

/// A binary floating-point number with 237 significant bits (71 decimal digits) and exponents to ±262 143.
///
/// IEEE 754 `binary256`, rounded to nearest even; the arithmetic is the crate `f256`'s. Arctangents of quotients, sines of
/// small angles and the conversion to `f64` are written here, because f256 0.11.3 gets them wrong or has none. Roots and exponentials are, because
/// its own take four and five times as long.
///
/// ```
/// use pintle_kinematics::scalar::{Real, Wide};
/// let third = Wide::ratio(1, 3);
/// assert_eq!(third.to_f64(), 1.0 / 3.0);
/// assert!((third * 3.0 - 1.0).abs() < Wide::from_f64(1e-71));
/// ```
#[derive(Clone, Copy, Default, PartialEq, PartialOrd)]
pub struct Wide(f256);

/// As doubles whose sum it is, each the nearest to what is left.
impl Serialize for Wide {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        /// The doubles that 237 bits are at most.
        const MOST: usize = 6;
        let (mut parts, mut rest) = (Vec::with_capacity(MOST), *self);
        while parts.len() < MOST {
            let part = rest.to_f64();
            parts.push(part);
            rest -= Self::from_f64(part);
            if rest == Self::from_f64(0.0) {
                break;
            }
        }
        parts.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Wide {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let parts = Vec::<f64>::deserialize(deserializer)?;
        let parts = parts.into_iter().map(Self::from_f64);
        // A zero keeps its sign.
        Ok(parts.reduce(|sum, part| sum + part).unwrap_or_default())
    }
}

// The two words of a number: sign, 19 bits of exponent, 236 of fraction, of which so many are in the high word.
const FRACTION_BITS: u32 = 108;
const EXPONENT_MASK: i32 = 0x7_ffff;
const BIAS: i32 = 262_143;

/// 2π − `TAU`, where `TAU` is 2π rounded to 237 bits.
const TAU_REST: f64 = 1.632_735_494_056_505_3e-71;

/// ln 2 − `LN_2`, where `LN_2` is ln 2 rounded to 237 bits.
const LN_2_REST: f64 = 1.685_053_844_727_834e-72;

/// 1/18!, 1/17!, …, 1: of eʸ − 1 = y (1 + y/2! + …), at |y| < 7e-4 the first one left out is below 2⁻²⁴⁰ of the sum.
static INVERSE_FACTORIALS: LazyLock<[Wide; 18]> = LazyLock::new(|| {
    let mut factorial = Wide::integer(1);
    let mut found = std::array::from_fn(|n| {
        factorial *= Wide::integer(n as i32 + 1);
        Wide::integer(1) / factorial
    });
    found.reverse();
    found
});

/// Below this |x|, sin x is summed from its Taylor series: f256's own has a fixed absolute error of 2⁻⁴⁹².
const SMALL_ANGLE: f64 = 1e-9;

/// From this s on the values come from sine and cosine of √s/2, below it from the power series. The series takes 30 terms at most
/// there, in half the time, and near 0, where differences are taken, in a twentieth.
const EXP_CLOSED: f64 = 1.0;

/// Above this y = (1 − c)/2 the value of K alone comes from the arctangent: it takes as long as 75 terms of the power series.
const LOG_CLOSED: f64 = 0.0625;

/// Arctangents of n/[`ARCTANGENT_PARTS`], from 0 to 1.
static ARCTANGENTS: LazyLock<[Wide; ARCTANGENT_PARTS + 1]> = LazyLock::new(|| {
    std::array::from_fn(|n| Wide((f256::from(n as u64) / f256::from(ARCTANGENT_PARTS as u64)).atan()))
});

/// In how many parts the arctangent's range is divided.
const ARCTANGENT_PARTS: usize = 128;

/// (−1)ᵐ/(2m + 1), m = 1, 2, …: the arctangent's power series, its first term aside. Of |x| ≤ 1/256 the first one left out is below 2⁻²⁵⁰ of
/// the sum.
static INVERSE_ODD: LazyLock<[Wide; 15]> =
    LazyLock::new(|| std::array::from_fn(|n| Wide::ratio(if n % 2 == 0 { -1 } else { 1 }, 2 * n as i32 + 3)));

/// Terms of the power series of w and k; at s = [`EXP_LIMIT`] the first one left out is below 2⁻³⁰⁰.
const EXP_TERMS: usize = 50;

/// Below this s the derivatives come from the power series, which loses up to 3 bits to alternating signs there, beyond it
/// from the recurrence, which loses up to 4.
const EXP_LIMIT: f64 = 64.0;

/// Terms of the power series of K in y < 1/2; those left out are below 2⁻²⁵⁰ of the sum even in the fourth derivative.
const LOG_TERMS: usize = 290;

/// w = Σ a_m sᵐ and k = Σ b_m sᵐ, a_m = (−1/4)ᵐ/(2m)!, b_m = ½ (−1/4)ᵐ/(2m + 1)!.
static EXP: LazyLock<[[Wide; EXP_TERMS]; 2]> = LazyLock::new(|| {
    let mut series = [[Wide::integer(1), Wide::ratio(1, 2)]; EXP_TERMS];
    for m in 1..EXP_TERMS {
        let i = 2 * m as i32;
        series[m][0] = series[m - 1][0] / Wide::integer(-4 * (i - 1) * i);
        series[m][1] = series[m - 1][1] / Wide::integer(-4 * i * (i + 1));
    }
    [series.map(|pair| pair[0]), series.map(|pair| pair[1])]
});

/// K = Σ c_n yⁿ with y = (1 − c)/2, c_n = 2 (2n)!!/(2n + 1)!!.
static LOG: LazyLock<[Wide; LOG_TERMS]> = LazyLock::new(|| {
    let mut series = [Wide::integer(2); LOG_TERMS];
    for n in 1..LOG_TERMS {
        let i = 2 * n as i32;
        series[n] = series[n - 1] * Wide::ratio(i, i + 1);
    }
    series
});

impl Wide {
    /// The double x, exactly.
    #[inline]
    pub fn from_f64(x: f64) -> Self {
        Self(f256::from(x))
    }

    /// The nearest double, ties to even; subnormal below 2⁻¹⁰²², infinite from 2¹⁰²⁴ − 2⁹⁷⁰ on.
    pub fn to_f64(self) -> f64 {
        let (high, low) = self.0.to_bits();
        let sign = if high >> 127 == 0 { 1.0 } else { -1.0 };
        let exponent = ((high >> FRACTION_BITS) as i32 & EXPONENT_MASK) - BIAS;
        if self.0.is_nan() {
            return f64::NAN;
        }
        if exponent > 1023 {
            return sign * f64::INFINITY;
        }
        if exponent < -1075 {
            return sign * 0.0;
        }
        let significand = (high & ((1 << FRACTION_BITS) - 1)) + (1 << FRACTION_BITS);
        let normal = exponent.max(-1022);
        // 53 of the 109 bits stay, fewer where the result is subnormal.
        let dropped = 56 + (normal - exponent) as u32;
        let kept = (significand >> dropped) as u64;
        let rest = significand & ((1 << dropped) - 1);
        let half = 1 << (dropped - 1);
        let up = rest > half || rest == half && (low != 0 || kept & 1 == 1);
        // The leading bit of `kept`, and a carry out of it, add one to the exponent field.
        sign * f64::from_bits((((normal + 1022) as u64) << 52) + kept + u64::from(up))
    }

    /// (h, l) with h the nearest double and l the double nearest to the rest: h + l has 106 bits at least, barring underflow.
    pub fn split(self) -> (f64, f64) {
        let high = self.to_f64();
        (high, (self - high).to_f64())
    }

    /// |x|.
    #[inline]
    pub fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// The greater of two numbers; the other one where one is NaN.
    pub fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    /// The lesser of two numbers; the other one where one is NaN.
    pub fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }

    /// Whether the number is neither infinite nor NaN.
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// arctan q = arctan t + arctan((q − t)/(1 + q t)) for 0 ≤ q ≤ 1, with t = n/128 the nearest. The power series of the second takes half of the
    /// time of f256's own.
    fn inverse_tangent(self) -> Self {
        let parts = ARCTANGENT_PARTS as f64;
        let n = (self.to_f64() * parts).round();
        let t = Self::from_f64(n / parts);
        let x = (self - t) / (self * t + 1.0);
        let square = x * x;
        let mut sum = <Self as Scalar>::zero();
        for term in INVERSE_ODD.iter().rev() {
            sum = (sum + term) * square;
        }
        ARCTANGENTS.get(n as usize).copied().unwrap_or(Self(f256::NAN)) + (x + x * sum)
    }

    /// sin x from x − x³/3! + …, for |x| < [`SMALL_ANGLE`].
    fn small_sine(self) -> Self {
        let square = self * self;
        let mut term = self;
        let mut sum = self;
        for i in 1..4 {
            term = -term * square / Self::integer(2 * i * (2 * i + 1));
            sum += term;
        }
        Self(sum.0.copysign(self.0))
    }
}

impl Scalar for Wide {
    type Real = Self;
    const ORDER: usize = 0;

    #[inline]
    fn from_real(value: Self) -> Self {
        value
    }

    #[inline]
    fn real(self) -> Self {
        self
    }

    #[inline]
    fn nilpotent(self) -> Self {
        Self(f256::ZERO)
    }

    #[inline]
    fn with_real(self, value: Self) -> Self {
        value
    }

    #[inline]
    fn scale(self, factor: Self) -> Self {
        self * factor
    }
}

impl Real for Wide {
    const ZERO: Self = Self(f256::ZERO);

    #[inline]
    fn integer(n: i32) -> Self {
        Self(f256::from(n))
    }

    #[inline]
    fn from_f64(x: f64) -> Self {
        Self::from_f64(x)
    }

    fn pi() -> Self {
        Self(consts::PI)
    }

    #[inline(always)]
    fn quaternion_of(r: &[[Self; 3]; 3]) -> [Self; 4] {
        crate::so3::dominant_eigenvector(r)
    }

    fn with_turns(principal: Self, n: Self) -> Self {
        Self(n.0.mul_add(consts::TAU, n.0.mul_add(f256::from(TAU_REST), principal.0)))
    }

    fn nearest_integer(self) -> Self {
        Self(self.0.round())
    }

    /// By Newton's method: a quarter of the time of f256's own, which finds one bit after the other. 1/√m is known to 53 bits from doubles,
    /// after two steps to 200. The last step adds the rest of m − r², which a fused multiply-add gives without its rounding.
    fn square_root(self) -> Self {
        let (high, low) = self.0.to_bits();
        let biased = (high >> FRACTION_BITS) as i32;
        // Zero and what is less than normal, what is infinite, not a number, or (with the sign's bit) negative.
        if biased == 0 || biased >= EXPONENT_MASK {
            return Self(self.0.sqrt());
        }
        // x = m 4ʰ with 1 ≤ m < 4.
        let halved = (biased - BIAS).div_euclid(2);
        let fraction = high & ((1 << FRACTION_BITS) - 1);
        let with_exponent = |exponent: i32| ((BIAS + exponent) as u128) << FRACTION_BITS;
        let m = Self(f256::from_bits((fraction | with_exponent((biased - BIAS).rem_euclid(2)), low)));
        let (one, half) = (f256::ONE, Self::ratio(1, 2));
        let mut inverse = Self::from_f64(m.to_f64().sqrt().recip());
        for _ in 0..2 {
            inverse += inverse * half * Self(one - (m * inverse * inverse).0);
        }
        let root = m * inverse;
        let rest = Self((-root.0).mul_add(root.0, m.0));
        (root + rest * inverse * half) * Self(f256::from_bits((with_exponent(halved), 0)))
    }

    #[inline]
    fn magnitude(self) -> Self {
        self.abs()
    }

    fn with_sign_of(self, sign: Self) -> Self {
        Self(self.0.copysign(sign.0))
    }

    fn reciprocal_or_zero(self) -> Self {
        if self.0.eq_zero() { Self(f256::ZERO) } else { Self(f256::ONE / self.0) }
    }

    fn exponential_minus_one(self) -> Self {
        Self(self.0.exp_m1())
    }

    fn power(self, exponent: Self) -> Self {
        Self(self.0.powf(&exponent.0))
    }

    type Mask = bool;

    #[inline]
    fn less(self, other: Self) -> bool {
        self < other
    }

    #[inline]
    fn holds(mask: bool) -> bool {
        mask
    }

    fn sine_cosine(self) -> (Self, Self) {
        let (sine, cosine) = self.0.sin_cos();
        let small = self.abs() < SMALL_ANGLE;
        (if small { self.small_sine() } else { Self(sine) }, Self(cosine))
    }

    /// eˣ = 2ⁿ eʳ with r = x − n ln 2, in a fifth of the time of f256's own. The power series of eʸ − 1 is short for y = r/2⁹. Each step
    /// from m to m (m + 2), nine in all, doubles y without loss.
    fn exponential(self) -> Self {
        const DOUBLINGS: i32 = 9;
        // Farther away are the ends of the exponents, at e^±181 704, which f256 knows.
        const FARTHEST: f64 = 1e5;
        let is_near = self.abs() < FARTHEST;
        if !is_near {
            return Self(self.0.exp());
        }
        let n = (self / Self(consts::LN_2)).0.round();
        let r = Self((-n).mul_add(consts::LN_2, self.0)) - Self(n * f256::from(LN_2_REST));
        let y = r / Self::integer(1 << DOUBLINGS);
        let [first, rest @ ..] = &*INVERSE_FACTORIALS;
        let two = Self::integer(2);
        let series = rest.iter().fold(*first, |sum, coefficient| sum * y + coefficient) * y;
        let less_one = (0..DOUBLINGS).fold(series, |m, _| m * (m + two));
        let power = ((BIAS + Self(n).to_f64() as i32) as u128) << FRACTION_BITS;
        (less_one + Self(f256::ONE)) * Self(f256::from_bits((power, 0)))
    }

    fn arctangent(self, x: Self) -> Self {
        let (y, x) = (self.0, x.0);
        let (height, width) = (y.abs(), x.abs());
        let octant = if height.eq_zero() {
            f256::ZERO
        } else {
            match height.partial_cmp(&width) {
                Some(Ordering::Equal) => consts::FRAC_PI_4,
                Some(Ordering::Less) => Self(height / width).inverse_tangent().0,
                _ => consts::FRAC_PI_2 - Self(width / height).inverse_tangent().0,
            }
        };
        let upper = if x.is_sign_negative() { consts::PI - octant } else { octant };
        if y.is_nan() || x.is_nan() { Self(f256::NAN) } else { Self(upper.copysign(y)) }
    }

    fn direction_and_norm<const N: usize>(v: [Self; N]) -> ([Self; N], Self) {
        let norm = v.iter().map(|x| *x * *x).sum::<Self>().square_root();
        if norm.0.eq_zero() { ([norm; N], norm) } else { (v.map(|x| x / norm), norm) }
    }

    fn exp_series(s: Self, order: usize) -> (Series<Self>, Series<Self>) {
        let (closed, recurrent) = (s >= EXP_CLOSED, s >= EXP_LIMIT);
        let (mut w, mut k) = if !recurrent && (order > 0 || !closed) {
            let terms = exp_terms(s) + order;
            let of = |series: &[Self; EXP_TERMS]| taylor(series.get(..terms).unwrap_or(series), s, order);
            (of(&EXP[0]), of(&EXP[1]))
        } else {
            ([Scalar::zero(); MAX_ORDER + 1], [Scalar::zero(); MAX_ORDER + 1])
        };
        if closed {
            // √s / 2 = half + rest, with the rounding error of the root: near the zeros of sine and cosine it counts.
            let root = s.square_root();
            let half = root / 2.0;
            let rest = Self((-root.0).mul_add(root.0, s.0)) / (root * 4.0);
            let (sine, cosine) = half.sine_cosine();
            w[0] = cosine - sine * rest;
            k[0] = (sine + cosine * rest) / root;
        }
        if recurrent {
            // w′ = −k/4 and s k′ = w/4 − k/2, and their derivatives.
            for n in 0..order {
                let next = Self::integer(n as i32 + 1);
                w[n + 1] = k[n] / (next * -4.0);
                k[n + 1] = (w[n] / 4.0 - k[n] * (n as f64 + 0.5)) / (next * s);
            }
        }
        (w, k)
    }

    fn log_series(c: Self, order: usize) -> Series<Self> {
        let one = <Self as Scalar>::one();
        // In neither branch do terms of different sign meet.
        let y = (one - c) / 2.0;
        if c > 0.0 && (order > 0 || y < LOG_CLOSED) {
            let mut k = taylor(LOG.get(..log_terms(y) + order).unwrap_or(&*LOG), y, order);
            let mut power = one; // dy/dc = −1/2
            for coefficient in &mut k {
                *coefficient *= power;
                power *= -0.5;
            }
            return k;
        }
        let square = (one - c) * (one + c);
        let sine = square.square_root();
        let mut k = [Scalar::zero(); MAX_ORDER + 1];
        k[0] = sine.arctangent(c) * 2.0 / sine;
        // (1 − c²) K′ = c K − 2 and its derivatives.
        for n in 0..order {
            let m = n as f64;
            let before = if n == 0 { Self::integer(-2) } else { k[n - 1] * m };
            k[n + 1] = (c * k[n] * (2.0 * m + 1.0) + before) / (square * (m + 1.0));
        }
        k
    }
}

/// The least n, and one more, with |x|ⁿ 2⁻ᵉⁿ below 2⁻³⁰⁰, for |x| < 1 and e = `extra`.
fn factors(x: Wide, extra: f64) -> usize {
    const BITS: f64 = 300.0;
    let bits = -x.to_f64().abs().log2();
    // None of 0, whose logarithm is infinite.
    (BITS / (bits + extra)).ceil() as usize + 1
}

/// Terms of the power series of K that count at y < 1/2: n of them leave out less than 2⁻³⁰⁰ times a binomial coefficient.
fn log_terms(y: Wide) -> usize {
    factors(y, 0.0)
}

/// Terms of the power series of w and k that count at s: from (s/4)ᵐ alone where s < 1, and (2m)! makes it 30 at most.
fn exp_terms(s: Wide) -> usize {
    const AT_ONE: usize = 30;
    if s.abs() < 1.0 { factors(s, 2.0).min(AT_ONE) } else { EXP_TERMS }
}

/// The Taylor coefficients at x, to the order asked for, of the polynomial Σ a_m xᵐ (Horner's scheme, repeated).
fn taylor(coefficients: &[Wide], x: Wide, order: usize) -> Series<Wide> {
    let mut sums = [<Wide as Scalar>::zero(); MAX_ORDER + 1];
    for a in coefficients.iter().rev() {
        for n in (1..=order).rev() {
            sums[n] = sums[n] * x + sums[n - 1];
        }
        sums[0] = sums[0] * x + a;
    }
    sums
}

impl FromStr for Wide {
    type Err = ParseFloatError;

    /// The number nearest to a decimal literal of any length, ties to even.
    fn from_str(literal: &str) -> Result<Self, ParseFloatError> {
        f256::from_str(literal).map(Self)
    }
}

impl fmt::Display for Wide {
    /// The shortest decimal that reads back as the same number; with a precision, at most 75 decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match f.precision() {
            Some(76..) => write!(f, "{:.75}", self.0),
            _ => fmt::Display::fmt(&self.0, f),
        }
    }
}

impl fmt::LowerExp for Wide {
    /// The shortest decimal that reads back as the same number, with an exponent; with a precision, at most 75 decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match f.precision() {
            Some(76..) => write!(f, "{:.75e}", self.0),
            _ => fmt::LowerExp::fmt(&self.0, f),
        }
    }
}

impl fmt::Debug for Wide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::LowerExp::fmt(self, f)
    }
}

impl From<f64> for Wide {
    fn from(x: f64) -> Self {
        Self::from_f64(x)
    }
}

impl PartialEq<f64> for Wide {
    fn eq(&self, other: &f64) -> bool {
        *self == Self::from_f64(*other)
    }
}

impl PartialOrd<f64> for Wide {
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.partial_cmp(&Self::from_f64(*other))
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident),*) => { $(
        impl $operator for Wide {
            type Output = Self;

            #[inline]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }

        impl $operator<&Self> for Wide {
            type Output = Self;

            #[inline]
            fn $method(self, other: &Self) -> Self {
                self.$method(*other)
            }
        }

        impl $operator<f64> for Wide {
            type Output = Self;

            #[inline]
            fn $method(self, other: f64) -> Self {
                self.$method(Self::from_f64(other))
            }
        }

        impl $assign for Wide {
            #[inline]
            fn $assign_method(&mut self, other: Self) {
                *self = self.$method(other);
            }
        }

        impl $assign<f64> for Wide {
            #[inline]
            fn $assign_method(&mut self, other: f64) {
                *self = self.$method(other);
            }
        }
    )* };
}

operators!(
    Add add AddAssign add_assign,
    Sub sub SubAssign sub_assign,
    Mul mul MulAssign mul_assign,
    Div div DivAssign div_assign,
    Rem rem RemAssign rem_assign
);

impl Neg for Wide {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Inv for Wide {
    type Output = Self;

    fn inv(self) -> Self {
        Self(f256::ONE / self.0)
    }
}

impl Sum for Wide {
    fn sum<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Scalar::zero(), Add::add)
    }
}

impl Product for Wide {
    fn product<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Scalar::one(), Mul::mul)
    }
}

impl Zero for Wide {
    fn zero() -> Self {
        Self(f256::ZERO)
    }

    fn is_zero(&self) -> bool {
        self.0.eq_zero()
    }
}

impl One for Wide {
    fn one() -> Self {
        Self(f256::ONE)
    }
}

impl Num for Wide {
    type FromStrRadixErr = ParseFloatError;

    /// Reads a decimal literal; any other radix is an error.
    fn from_str_radix(literal: &str, radix: u32) -> Result<Self, ParseFloatError> {
        if radix == 10 { literal.parse() } else { "radix".parse() }
    }
}

impl Signed for Wide {
    fn abs(&self) -> Self {
        Self::abs(*self)
    }

    fn abs_sub(&self, other: &Self) -> Self {
        if *self <= *other { Scalar::zero() } else { *self - other }
    }

    fn signum(&self) -> Self {
        Self(self.0.signum())
    }

    fn is_positive(&self) -> bool {
        self.0.is_sign_positive()
    }

    fn is_negative(&self) -> bool {
        self.0.is_sign_negative()
    }
}

impl FromPrimitive for Wide {
    fn from_i64(n: i64) -> Option<Self> {
        Some(Self(f256::from(n)))
    }

    fn from_u64(n: u64) -> Option<Self> {
        Some(Self(f256::from(n)))
    }

    fn from_f64(x: f64) -> Option<Self> {
        Some(Self::from_f64(x))
    }
}

impl DualStruct for Wide {
    type Real = f64;
    type Inner = Self;

    fn re(&self) -> f64 {
        self.to_f64()
    }

    fn from_inner(inner: &Self) -> Self {
        *inner
    }
}

impl Mappable<Self> for Wide {
    type Output<O> = O;

    fn map_dual<M: Fn(Self) -> O, O>(self, f: M) -> O {
        f(self)
    }
}

/// Functions that are f256's own.
macro_rules! forwarded {
    ($($function:ident),*) => { $(
        fn $function(&self) -> Self {
            Self(self.0.$function())
        }
    )* };
}

/// What num-dual asks of the number inside its dual numbers; the formulas of this crate use [`Real`] instead.
impl DualNum for Wide {
    type Primitive = f64;
    const NDERIV: usize = 0;
    type InnerDual = Self;

    forwarded!(sqrt, cbrt, exp, exp2, exp_m1, ln, log2, log10, cos, tan, asin, acos, atan);

    fn from_re(re: Self) -> Self {
        re
    }

    fn scale(self, factor: &Self) -> Self {
        self * factor
    }

    fn recip(&self) -> Self {
        self.inv()
    }

    fn powi(&self, n: i32) -> Self {
        Self(self.0.powi(n))
    }

    fn powf(&self, n: f64) -> Self {
        Self(self.0.powf(&f256::from(n)))
    }

    fn log(&self, base: f64) -> Self {
        Self(self.0.log(&f256::from(base)))
    }

    // f256's own is NaN between −1 and 0.
    fn ln_1p(&self) -> Self {
        let sum = self.0 + f256::ONE;
        let exact = sum == f256::ONE || sum.is_infinite();
        if exact { *self } else { Self(sum.ln() * (self.0 / (sum - f256::ONE))) }
    }

    fn sin(&self) -> Self {
        self.sine_cosine().0
    }

    fn sin_cos(&self) -> (Self, Self) {
        self.sine_cosine()
    }

    fn atan2(&self, other: Self) -> Self {
        self.arctangent(other)
    }

    fn sinh(&self) -> Self {
        let grown = self.0.abs().exp_m1();
        Self(((grown + grown / (grown + f256::ONE)) / f256::TWO).copysign(self.0))
    }

    fn cosh(&self) -> Self {
        let grown = self.0.abs().exp();
        Self((grown + f256::ONE / grown) / f256::TWO)
    }

    fn tanh(&self) -> Self {
        let shrunk = (self.0.abs() * -f256::TWO).exp_m1();
        Self((shrunk / (shrunk + f256::TWO)).copysign(self.0))
    }

    fn asinh(&self) -> Self {
        let x = self.0.abs();
        let root = (x * x + f256::ONE).sqrt();
        let rise = Self(x + x * x / (f256::ONE + root));
        Self(rise.ln_1p().0.copysign(self.0))
    }

    fn acosh(&self) -> Self {
        let above = self.0 - f256::ONE;
        Self(above + (above * (self.0 + f256::ONE)).sqrt()).ln_1p()
    }

    fn atanh(&self) -> Self {
        Self(self.0 * f256::TWO / (f256::ONE - self.0)).ln_1p() / 2.0
    }

    // j_n(x) = xⁿ (−8)ⁿ n! 2 k_n at s = 4x².

    fn sph_j0(&self) -> Self {
        Self::exp_series(*self * *self * 4.0, 0).1[0] * 2.0
    }

    fn sph_j1(&self) -> Self {
        Self::exp_series(*self * *self * 4.0, 1).1[1] * *self * -16.0
    }

    fn sph_j2(&self) -> Self {
        let square = *self * *self;
        Self::exp_series(square * 4.0, 2).1[2] * square * 256.0
    }
}
