//! The one bound under every formula: a number that may carry derivatives.
//!
//! [`Scalar`] is what a measure is generic over: ring operations, constants and a handful of elementary
//! functions. [`Real`] is the number without derivatives underneath it ([`Scalar::Real`]): `f64`, the
//! 237-bit [`Wide`], and whatever else is to run the same formulas (vector lanes, a traced symbol).
//!
//! Three rules make derivatives exact to rounding, for every order and nesting:
//!
//! 1. *Lift, do not differentiate.* A function of a dual number x = x₀ + e, e nilpotent, is its Taylor
//!    polynomial Σ c_k eᵏ. The coefficients c_k are computed on the real x₀ by a formula that is accurate
//!    for each k; only sums and products touch derivative parts ([`Scalar::lift`], [`elementary`]).
//! 2. *Branches live on the real.* [`Scalar`] has no ordering. Where a formula changes with its argument,
//!    the [`Real`] implementation decides, so a measure holds no branch and a lane type can select.
//! 3. *Nothing is divided by a dual number.* A quotient of real parts and a nilpotent rest is formed instead.
//!
//! ```
//! use num_dual::Dual64;
//! use pintle_kinematics::scalar::{elementary, Scalar};
//! // d/dy atan2(y, x) at the exact right angle (1, 0), where the quotient y / x has no value:
//! let angle = elementary::atan2(Dual64::new(1.0, 1.0), Dual64::new(0.0, 1.0));
//! assert_eq!(angle.real(), std::f64::consts::FRAC_PI_2);
//! assert_eq!(angle.eps, -1.0); // (x dy − y dx) / (x² + y²)
//! ```

/// A loop over 0..n for a constant n, written out where n ≤ 6: the compiler unrolls loops of few instructions only, and keeps what it
/// indexes in others in memory. Dual numbers of lanes are many. `i < m; n` is a loop over 0..m for a variable m ≤ n.
macro_rules! unrolled {
    ($i:ident < 3, $body:block) => { unrolled!(@ $i, 3, $body, 0 1 2) };
    ($i:ident < 4, $body:block) => { unrolled!(@ $i, 4, $body, 0 1 2 3) };
    ($i:ident < $n:expr, $body:block) => {
        if const { $n <= 6 } {
            unrolled!(@ $i, $n, $body, 0 1 2 3 4 5)
        } else {
            for $i in 0..$n $body
        }
    };
    ($i:ident < $m:expr; 3, $body:block) => { unrolled!($i < 3, { if $i < $m $body }) };
    ($i:ident < $m:expr; $n:expr, $body:block) => { unrolled!($i < $n, { if $i < $m $body }) };
    (@ $i:ident, $n:expr, $body:block, $($at:literal)+) => {{
        $(if const { $at < $n } {
            let $i: usize = $at;
            $body
        })+
    }};
}
pub(crate) use unrolled;

/// A function that is inlined where its numbers are doubles or lanes of them, and called where they are anything else
/// ([`Scalar::IS_INLINED`]). There a call costs nothing beside the arithmetic, and each copy takes the compiler seconds.
macro_rules! inlined_for_doubles {
    ($($(#[$meta:meta])* $visibility:vis fn $name:ident<S: Scalar $(, const $n:ident: usize)?>(
        $($argument:ident: $type:ty),* $(,)?
    ) -> $result:ty $body:block)+) => { $(
        $(#[$meta])*
        #[inline(always)]
        $visibility fn $name<S: Scalar $(, const $n: usize)?>($($argument: $type),*) -> $result {
            #[inline(always)]
            fn inlined<S: Scalar $(, const $n: usize)?>($($argument: $type),*) -> $result $body
            #[inline(never)]
            fn called<S: Scalar $(, const $n: usize)?>($($argument: $type),*) -> $result {
                inlined::<S $(, $n)?>($($argument),*)
            }
            if const { S::IS_INLINED } {
                inlined::<S $(, $n)?>($($argument),*)
            } else {
                called::<S $(, $n)?>($($argument),*)
            }
        }
    )+ };
}
pub(crate) use inlined_for_doubles;

/// A loop, written out where what runs in it is inlined.
macro_rules! each {
    ($scalar:ty, $i:ident < $m:expr; $n:tt, $body:block) => {
        if const { <$scalar as crate::scalar::Scalar>::IS_INLINED } {
            crate::scalar::unrolled!($i < $m; $n, $body)
        } else {
            for $i in 0..$m $body
        }
    };
    ($scalar:ty, $i:ident < $n:tt, $body:block) => {
        if const { <$scalar as crate::scalar::Scalar>::IS_INLINED } {
            crate::scalar::unrolled!($i < $n, $body)
        } else {
            for $i in 0..$n $body
        }
    };
}
pub(crate) use each;

mod coefficients;
mod double;
mod dual;
pub mod elementary;
pub mod lanes;
mod wide;

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

pub use dual::{Duals, Seeded};
pub use wide::Wide;

/// u = 2⁻⁵³, the unit of rounding of `f64`.
pub const U: f64 = 1.0 / 9_007_199_254_740_992.0;

/// The highest order of derivative that any [`Scalar`] carries: 4, as in a `Dual2` of `Dual2`.
pub const MAX_ORDER: usize = 4;

/// Taylor coefficients c_k = f⁽ᵏ⁾(x₀)/k!, k = 0 … [`MAX_ORDER`]; those beyond the order asked for are zero.
pub type Series<R> = [R; MAX_ORDER + 1];

/// A number with [`Scalar::ORDER`] orders of derivatives, or none.
///
/// `==` is deliberately absent: on dual numbers it compares real parts only.
pub trait Scalar:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// The number underneath, which carries no derivatives; nested duals reach through to the innermost.
    type Real: Real;

    /// The order N of the highest derivative carried: the nilpotent part e obeys e^(N+1) = 0. At most [`MAX_ORDER`].
    const ORDER: usize;

    /// Whether the elementary functions and those of rotations are inlined: for doubles and lanes.
    const IS_INLINED: bool = false;

    /// The constant `value`: all derivatives are zero.
    fn from_real(value: Self::Real) -> Self;

    /// The real part x₀.
    fn real(self) -> Self::Real;

    /// The nilpotent part e = x − x₀, whose real part is exactly zero.
    fn nilpotent(self) -> Self;

    /// The product with a real constant; cheaper than a product with [`Scalar::from_real`].
    fn scale(self, factor: Self::Real) -> Self;

    /// value + e: the number with another real part.
    fn with_real(self, value: Self::Real) -> Self;

    /// The product of a number whose real part is zero with another: what is infinite in the other only meets what is not zero.
    #[inline(always)]
    fn nilpotent_times(self, other: Self) -> Self {
        if const { Self::ORDER == 0 } { Self::zero() } else { self * other }
    }

    /// The product of two numbers whose real parts are zero.
    #[inline(always)]
    fn nilpotent_product(self, other: Self) -> Self {
        self.nilpotent_times(other)
    }

    /// `yes` where the mask holds, else `no`.
    #[inline(always)]
    fn select(mask: <Self::Real as Real>::Mask, yes: Self, no: Self) -> Self {
        if Self::Real::holds(mask) { yes } else { no }
    }

    /// x y + z; rounded once where the machine does so as fast, as vector lanes do.
    #[inline(always)]
    fn multiply_add(self, y: Self, z: Self) -> Self {
        self * y + z
    }

    /// x f + z for a real constant f, rounded as [`Scalar::multiply_add`].
    #[inline(always)]
    fn scale_add(self, factor: Self::Real, z: Self) -> Self {
        self.scale(factor) + z
    }

    /// The constant 0.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_real(Self::Real::ZERO)
    }

    /// The constant 1.
    #[inline(always)]
    fn one() -> Self {
        Self::from_real(Self::Real::integer(1))
    }

    /// What `f` gives; a number that records formulas (`Symbol`) takes every branch of `f` and joins them here.
    #[inline(always)]
    fn joined<const N: usize>(f: impl Fn() -> [Self; N]) -> [Self; N] {
        f()
    }

    /// Σ c_k eᵏ: the function whose Taylor coefficients at the real part are `c`, applied to this number.
    #[inline(always)]
    fn lift(self, c: &Series<Self::Real>) -> Self {
        const { assert!(Self::ORDER <= MAX_ORDER, "more orders of derivative than Taylor coefficients") }
        if const { Self::ORDER == 0 } {
            return Self::from_real(c[0]);
        }
        let e = self.nilpotent();
        let mut sum = Self::from_real(c[Self::ORDER]);
        for k in (0..Self::ORDER).rev() {
            sum = Self::from_real(c[k]) + e * sum;
        }
        sum
    }
}

/// What [`Real::choose`] chooses between: scalars, and arrays and tuples of them.
pub trait Select<R: Real>: Sized {
    /// `yes` where the mask holds, else `no`.
    fn pick(mask: R::Mask, yes: Self, no: Self) -> Self;
}

impl<S: Scalar> Select<S::Real> for S {
    #[inline(always)]
    fn pick(mask: <S::Real as Real>::Mask, yes: Self, no: Self) -> Self {
        S::select(mask, yes, no)
    }
}

impl<R: Real, T: Select<R> + Copy, const N: usize> Select<R> for [T; N] {
    #[inline(always)]
    fn pick(mask: R::Mask, yes: Self, no: Self) -> Self {
        let mut picked = yes;
        for i in 0..N {
            picked[i] = T::pick(mask, yes[i], no[i]);
        }
        picked
    }
}

impl<R: Real, T: Select<R>, U: Select<R>> Select<R> for (T, U) {
    #[inline(always)]
    fn pick(mask: R::Mask, yes: Self, no: Self) -> Self {
        (T::pick(mask, yes.0, no.0), U::pick(mask, yes.1, no.1))
    }
}

/// A number that carries no derivatives, with the real functions that the elementary functions are lifted from.
///
/// Each function here owns its branches. Implementations differ on purpose: `f64` uses economised polynomials
/// and recurrences, [`Wide`] plain textbook series, so that the second checks the first.
pub trait Real: Scalar<Real = Self> + Div<Output = Self> {
    /// The number 0.
    const ZERO: Self;

    /// The integer n, exactly.
    fn integer(n: i32) -> Self;

    /// The double x, exactly.
    fn from_f64(x: f64) -> Self;

    /// The ratio p / q, rounded once in this type.
    #[inline(always)]
    fn ratio(p: i32, q: i32) -> Self {
        Self::integer(p) / Self::integer(q)
    }

    /// π, rounded in this type.
    fn pi() -> Self;

    /// principal + 2π n for an integer n, with 2π carried beyond the precision of this type, so that the turns add no error
    /// of their own beyond the rounding of the result.
    fn with_turns(principal: Self, n: Self) -> Self;

    /// The nearest integer; halves away from zero.
    fn nearest_integer(self) -> Self;

    /// √x for x ≥ 0.
    fn square_root(self) -> Self;

    /// |x|.
    fn magnitude(self) -> Self;

    /// |x| with the sign of another number, that of −0 included where the type has one.
    fn with_sign_of(self, sign: Self) -> Self;

    /// 1 / x, or 0 where x = 0 or, in a type of narrow range, 1 / x would overflow (`f64`: |x| < 2⁻¹⁰²⁴).
    ///
    /// The second case is the minimal-norm choice of a derivative at a point that has none; whoever can meet such a
    /// point reports it (`Measure::margin`).
    fn reciprocal_or_zero(self) -> Self;

    /// exp x − 1, accurate near 0.
    fn exponential_minus_one(self) -> Self;

    /// xᵖ for x ≥ 0.
    fn power(self, exponent: Self) -> Self;

    /// The answer to a comparison: `bool`, or one bit per lane.
    type Mask: Copy;

    /// Whether both sides of a choice are computed, because lanes may take different ones.
    const HAS_LANES: bool = false;

    /// Whether the mask holds, of lanes in every one of them. What is to run on lanes uses [`Real::choose`].
    fn holds(mask: Self::Mask) -> bool;

    /// Whether `self` < `other`.
    fn less(self, other: Self) -> Self::Mask;

    /// `yes` where the mask holds, else `no`; of a single number only what is chosen is computed.
    #[inline(always)]
    fn choose<T: Select<Self>>(mask: Self::Mask, yes: impl FnOnce() -> T, no: impl FnOnce() -> T) -> T {
        if Self::holds(mask) { yes() } else { no() }
    }

    /// `yes` where the mask holds, else `no`, both known.
    #[inline(always)]
    fn either<T: Select<Self>>(mask: Self::Mask, yes: T, no: T) -> T {
        T::pick(mask, yes, no)
    }

    /// The lesser of two numbers.
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        Self::either(self.less(other), self, other)
    }

    /// Whether a test holds that leads to the same number sooner; a number that records formulas takes no shortcuts.
    #[inline(always)]
    fn shortcut(test: impl FnOnce() -> Self::Mask) -> bool {
        Self::holds(test())
    }

    /// As [`Real::shortcut`], where a number is positive.
    #[inline(always)]
    fn shortcut_where_positive(number: impl FnOnce() -> Self) -> bool {
        Self::shortcut(|| Self::integer(0).less(number()))
    }

    /// As [`Real::choose`] between two formulas of the same quantity that differ in rounding only; a number that records formulas
    /// keeps `no`.
    #[inline(always)]
    fn more_exact<T: Select<Self>>(mask: Self::Mask, yes: impl FnOnce() -> T, no: impl FnOnce() -> T) -> T {
        Self::choose(mask, yes, no)
    }

    /// The unit quaternion, either sign, of the rotation nearest to a rotation matrix with rounding errors. On lanes errors of the
    /// matrix are not taken out: where it is orthonormal to δ only, the quaternion is a unit, and right, to about 0.4 δ.
    fn quaternion_of(r: &[[Self; 3]; 3]) -> [Self; 4];

    /// (sin x, cos x), x in radians.
    fn sine_cosine(self) -> (Self, Self);

    /// eˣ.
    fn exponential(self) -> Self;

    /// The angle of the point (x, y) in (−π, π] (y is `self`), 0 at the origin, with the signs of zeros as IEEE 754 asks.
    fn arctangent(self, x: Self) -> Self;

    /// (v / |v|, |v|) without overflow or underflow for components between 1e−300 and 1e300; (0, 0) at v = 0.
    fn direction_and_norm<const N: usize>(v: [Self; N]) -> ([Self; N], Self);

    /// v / |v|², with the range of [`Real::direction_and_norm`]; 0 at v = 0 and where it would overflow.
    #[inline(always)]
    fn inverted<const N: usize>(v: [Self; N]) -> [Self; N] {
        let (mut u, norm) = Self::direction_and_norm(v);
        let inverse = norm.reciprocal_or_zero();
        for component in &mut u {
            *component = *component * inverse;
        }
        u
    }

    /// (v / |v|², |v|) of direction cosines; (0, 0) at v = 0.
    ///
    /// What other lengths need to neither overflow nor underflow may be left out. Where all are nearer to 0 than 1e−150, v / |v|² is then too
    /// small, never infinite.
    #[inline(always)]
    fn inverted_cosines<const N: usize>(v: [Self; N]) -> ([Self; N], Self) {
        (Self::inverted(v), Self::direction_and_norm(v).1)
    }

    /// The Taylor coefficients, to the order asked for, of w(s) = cos(√s / 2) and k(s) = sin(√s / 2) / √s at s = |φ|² ≥ 0.
    ///
    /// exp maps the rotation vector φ to the unit quaternion (w, k φ).
    fn exp_series(s: Self, order: usize) -> (Series<Self>, Series<Self>);

    /// The Taylor coefficients, to the order asked for, of K(c) = 2 acos(c) / √(1 − c²) at c in [0, 1]. The logarithm maps
    /// the unit quaternion (w, v), w ≥ 0, to the rotation vector K(w) v. K(1) = 2; the function is analytic there and
    /// through c = 0.
    fn log_series(c: Self, order: usize) -> Series<Self>;
}
