//! Four doubles at once, one of each of four elements: the [`Real`] of batches.
//!
//! Every operation is written out for the four lanes, without a branch, so that the compiler makes vector instructions of it. They
//! are those of the processor that [`pulp`] finds at run time, where the loop around it is compiled for that ([`crate::batch`]).
//! Where lanes may need different formulas both are computed and the result selected, or one formula serves the whole domain. So
//! norms are taken of vectors scaled by a power of two. What only rare arguments need (sines of large angles) is computed lane by
//! lane when one of the four does.
//!
//! What the loops of [`crate::batch`] call is marked `#[inline]`, or is a loop over indices. Iterators over arrays and `map` are
//! not so marked in the standard library. That puts them into units of compilation of their own, and numbers that they touch into
//! memory.

mod dual;
mod function;

pub use dual::{FirstOrder, SecondOrder};

use crate::scalar::{MAX_ORDER, Real, Scalar, Series};
#[cfg(target_arch = "x86_64")]
use pulp::bytemuck::cast;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::__m256d;
#[cfg(target_arch = "x86_64")]
use std::hint::black_box;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The number of lanes.
pub const LANES: usize = 4;

/// Four doubles. `FUSED`: whether x y + z is rounded once, which is fast where the processor has an instruction for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Lanes<const FUSED: bool>(pub [f64; LANES]);

/// One answer for each lane.
#[derive(Clone, Copy, Debug)]
pub struct LaneMask([bool; LANES]);

impl LaneMask {
    /// Whether it holds in every lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn all(self) -> bool {
        self.count() == LANES as f64
    }

    /// Whether it holds in at least one lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn any(self) -> bool {
        self.count() > 0.0
    }

    /// In how many lanes it holds: as a sum of doubles, half and half, which vectorises.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(self) -> f64 {
        let one = |holds: bool| if holds { 1.0 } else { 0.0 };
        (one(self.0[0]) + one(self.0[2])) + (one(self.0[1]) + one(self.0[3]))
    }
}

impl<const FUSED: bool> Lanes<FUSED> {
    /// The same number in every lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub const fn splat(x: f64) -> Self {
        Self([x; LANES])
    }

    /// Writes the lanes as one vector. Of four numbers beside those of the next column the compiler takes any that follow each other, from
    /// where that first looks cheap to it, and shuffles lanes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn store(self, to: &mut [f64; LANES]) {
        #[cfg(target_arch = "x86_64")]
        {
            *to = cast(cast::<[f64; LANES], __m256d>(self.0));
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            *to = self.0;
        }
    }

    /// The same, by way of memory. Where a long computation is narrow, the compiler makes vectors of what is before and of what is behind it;
    /// of all at once it does not.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kept(self) -> Self {
        #[cfg(target_arch = "x86_64")]
        return Self(cast(*black_box(&cast::<_, __m256d>(self.0))));
        #[cfg(not(target_arch = "x86_64"))]
        self
    }

    /// `function` of each lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        let [a, b, c, d] = self.0;
        Self([function(a), function(b), function(c), function(d)])
    }

    /// `function` of each pair of lanes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn both(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([function(a, e), function(b, f), function(c, g), function(d, h)])
    }

    /// The greater of each pair of lanes that are not NaN: one instruction.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn greater(self, other: Self) -> Self {
        self.both(other, |x, y| if x > y { x } else { y })
    }

    /// `negative` where the sign bit of `sign` is set, else `positive`: one instruction.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn by_sign(sign: Self, negative: Self, positive: Self) -> Self {
        let lane = |i: usize| if sign.0[i].is_sign_negative() { negative.0[i] } else { positive.0[i] };
        Self([lane(0), lane(1), lane(2), lane(3)])
    }

    /// −self where the sign bit of `sign` is set.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mirrored_by(self, sign: Self) -> Self {
        const SIGN: u64 = 1 << 63;
        self.both(sign, |x, s| f64::from_bits(x.to_bits() ^ (s.to_bits() & SIGN)))
    }

    /// An answer for each pair of lanes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compare(self, other: Self, test: impl Fn(f64, f64) -> bool) -> LaneMask {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        LaneMask([test(a, e), test(b, f), test(c, g), test(d, h)])
    }

    /// Series of each lane, computed on doubles.
    fn lane_by_lane(self, series: impl Fn(f64) -> Series<f64>) -> Series<Self> {
        let of = self.0.map(series);
        let mut result = [Self::splat(0.0); MAX_ORDER + 1];
        for (k, coefficient) in result.iter_mut().enumerate() {
            *coefficient = Self(of.map(|lane| lane[k]));
        }
        result
    }
}

macro_rules! lanewise {
    ($($operation:ident :: $method:ident),*) => { $(
        impl<const FUSED: bool> $operation for Lanes<FUSED> {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: Self) -> Self {
                self.both(other, |x, y| x.$method(y))
            }
        }
    )* };
}

lanewise!(Add::add, Sub::sub, Mul::mul, Div::div);

impl<const FUSED: bool> Neg for Lanes<FUSED> {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> Self {
        self.each(|x| -x)
    }
}

impl<const FUSED: bool> Scalar for Lanes<FUSED> {
    type Real = Self;
    const ORDER: usize = 0;
    const IS_INLINED: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_real(value: Self) -> Self {
        value
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn real(self) -> Self {
        self
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nilpotent(self) -> Self {
        Self::splat(0.0)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_real(self, value: Self) -> Self {
        value
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn scale(self, factor: Self) -> Self {
        self * factor
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: LaneMask, yes: Self, no: Self) -> Self {
        let lane = |i: usize| if mask.0[i] { yes.0[i] } else { no.0[i] };
        Self([lane(0), lane(1), lane(2), lane(3)])
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn multiply_add(self, y: Self, z: Self) -> Self {
        if const { FUSED } {
            let lane = |i: usize| self.0[i].mul_add(y.0[i], z.0[i]);
            Self([lane(0), lane(1), lane(2), lane(3)])
        } else {
            self * y + z
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn scale_add(self, factor: Self, z: Self) -> Self {
        self.multiply_add(factor, z)
    }
}

impl<const FUSED: bool> Real for Lanes<FUSED> {
    const ZERO: Self = Self([0.0; LANES]);
    const HAS_LANES: bool = true;

    type Mask = LaneMask;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn holds(mask: LaneMask) -> bool {
        mask.all()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn choose<T: crate::scalar::Select<Self>>(
        mask: LaneMask,
        yes: impl FnOnce() -> T,
        no: impl FnOnce() -> T,
    ) -> T {
        T::pick(mask, yes(), no())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less(self, other: Self) -> LaneMask {
        self.compare(other, |x, y| x < y)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn integer(n: i32) -> Self {
        Self::splat(f64::from(n))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_f64(x: f64) -> Self {
        Self::splat(x)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn pi() -> Self {
        Self::splat(std::f64::consts::PI)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_turns(principal: Self, n: Self) -> Self {
        principal.both(n, f64::with_turns)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nearest_integer(self) -> Self {
        self.each(f64::round)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn square_root(self) -> Self {
        self.each(f64::sqrt)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn magnitude(self) -> Self {
        self.each(f64::abs)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_sign_of(self, sign: Self) -> Self {
        self.both(sign, f64::copysign)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn reciprocal_or_zero(self) -> Self {
        let inverse = Self::splat(1.0) / self;
        Self::select(Self::splat(f64::MAX).less(inverse.magnitude()), Self::splat(0.0), inverse)
    }

    fn exponential_minus_one(self) -> Self {
        self.each(f64::exp_m1)
    }

    fn power(self, exponent: Self) -> Self {
        self.both(exponent, f64::powf)
    }

    fn exponential(self) -> Self {
        self.each(f64::exp)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sine_cosine(self) -> (Self, Self) {
        function::sine_cosine(self)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn arctangent(self, x: Self) -> Self {
        function::arctangent(self, x)
    }

    /// By the signs of all lanes joined: sums of answers would make the compiler split vectors.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn shortcut_where_positive(number: impl FnOnce() -> Self) -> bool {
        let [a, b, c, d] = number().0;
        (a.to_bits() | b.to_bits() | c.to_bits() | d.to_bits()) >> 63 == 0
    }

    /// Of lanes that are not NaN: one instruction.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lesser(self, other: Self) -> Self {
        self.both(other, |x, y| if x < y { x } else { y })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn quaternion_of(r: &[[Self; 3]; 3]) -> [Self; 4] {
        function::quaternion(r)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn direction_and_norm<const N: usize>(v: [Self; N]) -> ([Self; N], Self) {
        function::direction_and_norm(v)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverted<const N: usize>(v: [Self; N]) -> [Self; N] {
        function::inverted(v)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverted_cosines<const N: usize>(v: [Self; N]) -> ([Self; N], Self) {
        function::inverted_cosines(v)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp_series(s: Self, order: usize) -> (Series<Self>, Series<Self>) {
        if order > 0 {
            return function::exp_series_lane_by_lane(s, order);
        }
        function::exp_series(s)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log_series(c: Self, order: usize) -> Series<Self> {
        if order > 2 {
            return function::log_series_lane_by_lane(c, order);
        }
        function::log_series(c, order)
    }
}

#[cfg(test)]
mod tests;
