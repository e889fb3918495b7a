//! Four doubles in a vector register, with the processor's own instructions.

use pintle_kinematics::batch::Four;
use pulp::f64x4;
use pulp::x86::V3;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Four doubles, and the proof that the processor has AVX2 and FMA.
#[derive(Clone, Copy)]
pub(crate) struct Vec4(V3, f64x4);

macro_rules! operation {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for Vec4 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.$instruction(self.1, other.1))
            }
        }
    };
}
operation!(Add, add, add_f64x4);
operation!(Sub, sub, sub_f64x4);
operation!(Mul, mul, mul_f64x4);
operation!(Div, div, div_f64x4);

impl Neg for Vec4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let sign = self.0.splat_f64x4(-0.0);
        Self(self.0, self.0.xor_f64x4(self.1, sign))
    }
}

impl Vec4 {
    #[inline(always)]
    pub(crate) fn splat(v: V3, x: f64) -> Self {
        Self(v, v.splat_f64x4(x))
    }
    #[inline(always)]
    pub(crate) fn load(v: V3, from: &Four) -> Self {
        Self(v, pulp::cast(*from))
    }
    #[inline(always)]
    pub(crate) fn store(self, to: &mut Four) {
        *to = pulp::cast(self.1);
    }
    /// self·y + z.
    #[inline(always)]
    pub(crate) fn fma(self, y: Self, z: Self) -> Self {
        Self(self.0, self.0.mul_add_f64x4(self.1, y.1, z.1))
    }
    /// self·y − z.
    #[inline(always)]
    pub(crate) fn fms(self, y: Self, z: Self) -> Self {
        Self(self.0, self.0.mul_sub_f64x4(self.1, y.1, z.1))
    }
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_f64x4(self.1))
    }
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(self.0, self.0.abs_f64x4(self.1))
    }
    /// `yes` where self < other.
    #[inline(always)]
    pub(crate) fn pick_less(self, other: Self, yes: Self, no: Self) -> Self {
        let mask = self.0.cmp_lt_f64x4(self.1, other.1);
        Self(self.0, self.0.select_f64x4(mask, yes.1, no.1))
    }
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(self.0, self.0.max_f64x4(self.1, other.1))
    }
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self(self.0, self.0.min_f64x4(self.1, other.1))
    }
    /// The magnitude of self with the sign of `sign`.
    #[inline(always)]
    pub(crate) fn with_sign_of(self, sign: Self) -> Self {
        let bit = self.0.splat_f64x4(-0.0);
        let of_sign = self.0.and_f64x4(sign.1, bit);
        Self(self.0, self.0.or_f64x4(self.abs().1, of_sign))
    }
}

pub(crate) type Three = [Vec4; 3];

#[inline(always)]
pub(crate) fn load3(v: V3, from: &[Four; 3]) -> Three {
    [Vec4::load(v, &from[0]), Vec4::load(v, &from[1]), Vec4::load(v, &from[2])]
}

#[inline(always)]
pub(crate) fn column(v: V3, m: &[[Four; 3]; 3], j: usize) -> Three {
    [Vec4::load(v, &m[0][j]), Vec4::load(v, &m[1][j]), Vec4::load(v, &m[2][j])]
}

#[inline(always)]
pub(crate) fn dot(a: Three, b: Three) -> Vec4 {
    a[2].fma(b[2], a[1].fma(b[1], a[0] * b[0]))
}

#[inline(always)]
pub(crate) fn cross(a: Three, b: Three) -> Three {
    [a[1].fms(b[2], a[2] * b[1]), a[2].fms(b[0], a[0] * b[2]), a[0].fms(b[1], a[1] * b[0])]
}
