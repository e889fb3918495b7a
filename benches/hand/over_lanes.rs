//! num-dual over four lanes: its dual numbers in three relative directions, of a number that is four doubles.
#![expect(clippy::disallowed_methods, reason = "num-dual's own functions are what is measured")]

use nalgebra::SVector;
use num_dual::{Derivative, DualNum, DualSVec, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use pintle_kinematics::batch::{Four, Row, Tile};
use pintle_kinematics::scalar::Real;
use pintle_kinematics::scalar::lanes::Lanes as LanesOf;
use std::cmp::Ordering;
use std::fmt;
use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

type Lanes = LanesOf<{ cfg!(target_feature = "fma") }>;

/// Four doubles as num-dual asks for them; what it asks of one double alone is that of the first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Number(Lanes);

type Dual = DualSVec<Number, 3>;

fn splat(x: f64) -> Number {
    Number(Lanes::splat(x))
}

macro_rules! operations {
    ($($trait:ident :: $method:ident, $assign:ident :: $assigned:ident, $of:expr;)*) => { $(
        impl $trait for Number {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($of(self.0, other.0))
            }
        }
        impl $trait<&Self> for Number {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: &Self) -> Self {
                Self($of(self.0, other.0))
            }
        }
        impl $trait<f64> for Number {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Self($of(self.0, Lanes::splat(other)))
            }
        }
        impl $assign for Number {
            #[inline(always)]
            fn $assigned(&mut self, other: Self) {
                self.0 = $of(self.0, other.0);
            }
        }
        impl $assign<f64> for Number {
            #[inline(always)]
            fn $assigned(&mut self, other: f64) {
                self.0 = $of(self.0, Lanes::splat(other));
            }
        }
    )* };
}
operations! {
    Add::add, AddAssign::add_assign, Add::add;
    Sub::sub, SubAssign::sub_assign, Sub::sub;
    Mul::mul, MulAssign::mul_assign, Mul::mul;
    Div::div, DivAssign::div_assign, Div::div;
    Rem::rem, RemAssign::rem_assign, |x: Lanes, y: Lanes| LanesOf(std::array::from_fn(|i| x.0[i] % y.0[i]));
}

/// Traits of which each function is one expression.
macro_rules! traits {
    ($($trait:ty {
        $(const $constant:ident: $known:ty = $value:expr;)*
        $(type $kind:ident = $of:ty;)*
        $(fn $name:ident $(<$g:ident: $bound:path>)? ($($argument:ident: $type:ty),*) -> $result:ty = $body:expr;)*
    })*) => { $(
        impl $trait for Number {
            $(const $constant: $known = $value;)*
            $(type $kind = $of;)*
            $(
                #[inline(always)]
                fn $name $(<$g: $bound>)? ($($argument: $type),*) -> $result {
                    $body
                }
            )*
        }
    )* };
}
traits! {
    Neg { type Output = Self; fn neg(self: Self) -> Self = Self(-self.0); }
    Inv { type Output = Self; fn inv(self: Self) -> Self = splat(1.0) / self; }
    Zero { fn zero() -> Self = splat(0.0); fn is_zero(self: &Self) -> bool = *self == splat(0.0); }
    One { fn one() -> Self = splat(1.0); }
    Num { type FromStrRadixErr = (); fn from_str_radix(_text: &str, _radix: u32) -> Result<Self, ()> = Err(()); }
    Sum { fn sum<I: Iterator<Item = Self>>(all: I) -> Self = all.fold(splat(0.0), Add::add); }
    Product { fn product<I: Iterator<Item = Self>>(all: I) -> Self = all.fold(splat(1.0), Mul::mul); }
    From<f64> { fn from(x: f64) -> Self = splat(x); }
    FromPrimitive {
        fn from_i64(n: i64) -> Option<Self> = Some(splat(n as f64));
        fn from_u64(n: u64) -> Option<Self> = Some(splat(n as f64));
    }
    Signed {
        fn abs(self: &Self) -> Self = Self(self.0.magnitude());
        fn abs_sub(self: &Self, other: &Self) -> Self = (*self - other).abs();
        fn signum(self: &Self) -> Self = self.each(f64::signum);
        fn is_positive(self: &Self) -> bool = self.re() > 0.0;
        fn is_negative(self: &Self) -> bool = self.re() < 0.0;
    }
    PartialEq<f64> { fn eq(self: &Self, x: &f64) -> bool = *self == splat(*x); }
    PartialOrd { fn partial_cmp(self: &Self, other: &Self) -> Option<Ordering> = self.re().partial_cmp(&other.re()); }
    PartialOrd<f64> { fn partial_cmp(self: &Self, x: &f64) -> Option<Ordering> = self.re().partial_cmp(x); }
    fmt::Display { fn fmt(self: &Self, out: &mut fmt::Formatter<'_>) -> fmt::Result = write!(out, "{:?}", self.0.0); }
    DualStruct {
        type Real = f64;
        type Inner = Self;
        fn re(self: &Self) -> f64 = self.0.0[0];
        fn from_inner(inner: &Self) -> Self = *inner;
    }
    DualNum {
        const NDERIV: usize = 0;
        type Primitive = f64;
        type InnerDual = Self;
        fn from_re(re: Self) -> Self = re;
        fn scale(self: Self, factor: &Self) -> Self = self * factor;
        fn recip(self: &Self) -> Self = splat(1.0) / *self;
        fn sqrt(self: &Self) -> Self = Self(self.0.square_root());
        fn atan(self: &Self) -> Self = self.atan2(splat(1.0));
        fn atan2(self: &Self, x: Self) -> Self = Self(self.0.arctangent(x.0));
        fn powi(self: &Self, n: i32) -> Self = self.each(|x| x.powi(n));
        fn powf(self: &Self, n: f64) -> Self = self.each(|x| x.powf(n));
        fn log(self: &Self, base: f64) -> Self = self.each(|x| x.log(base));
        fn sin_cos(self: &Self) -> (Self, Self) = (self.sin(), self.cos());
        fn cbrt(self: &Self) -> Self = self.each(f64::cbrt);
        fn exp(self: &Self) -> Self = self.each(f64::exp);
        fn exp2(self: &Self) -> Self = self.each(f64::exp2);
        fn exp_m1(self: &Self) -> Self = self.each(f64::exp_m1);
        fn ln(self: &Self) -> Self = self.each(f64::ln);
        fn log2(self: &Self) -> Self = self.each(f64::log2);
        fn log10(self: &Self) -> Self = self.each(f64::log10);
        fn ln_1p(self: &Self) -> Self = self.each(f64::ln_1p);
        fn sin(self: &Self) -> Self = self.each(f64::sin);
        fn cos(self: &Self) -> Self = self.each(f64::cos);
        fn tan(self: &Self) -> Self = self.each(f64::tan);
        fn asin(self: &Self) -> Self = self.each(f64::asin);
        fn acos(self: &Self) -> Self = self.each(f64::acos);
        fn sinh(self: &Self) -> Self = self.each(f64::sinh);
        fn cosh(self: &Self) -> Self = self.each(f64::cosh);
        fn tanh(self: &Self) -> Self = self.each(f64::tanh);
        fn asinh(self: &Self) -> Self = self.each(f64::asinh);
        fn acosh(self: &Self) -> Self = self.each(f64::acosh);
        fn atanh(self: &Self) -> Self = self.each(f64::atanh);
        fn sph_j0(self: &Self) -> Self = self.each(|x| DualNum::sph_j0(&x));
        fn sph_j1(self: &Self) -> Self = self.each(|x| DualNum::sph_j1(&x));
        fn sph_j2(self: &Self) -> Self = self.each(|x| DualNum::sph_j2(&x));
    }
}

impl Mappable<Self> for Number {
    type Output<O> = O;
    fn map_dual<G: Fn(Self) -> O, O>(self, of: G) -> O {
        of(self)
    }
}

impl Number {
    fn each(self, of: impl Fn(f64) -> f64) -> Self {
        Self(LanesOf(self.0.0.map(of)))
    }
}

type Three = [Lanes; 3];

#[inline(always)]
fn column(triad: &[[Four; 3]; 3], j: usize) -> Three {
    [LanesOf(triad[0][j]), LanesOf(triad[1][j]), LanesOf(triad[2][j])]
}

#[inline(always)]
fn dot(a: Three, b: Three) -> Lanes {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A number and its derivatives.
#[inline(always)]
fn dual(value: Lanes, by: Three) -> Dual {
    Dual::new(Number(value), Derivative::some(SVector::from([Number(by[0]), Number(by[1]), Number(by[2])])))
}

/// The value and the derivatives.
#[inline(always)]
fn parts(of: Dual) -> (Lanes, Three) {
    let by = of.eps.0.unwrap_or_else(|| SVector::from([splat(0.0); 3]));
    (of.re.0, [by[0].0, by[1].0, by[2].0])
}

fn put(row: &mut Row, value: Lanes, by: [Three; 4]) {
    row.value = value.0;
    for (place, part) in by.iter().enumerate() {
        for i in 0..3 {
            row.columns[3 * place + i] = part[i].0;
        }
    }
}

const NONE: Three = [LanesOf([0.0; 4]); 3];

/// e_i^a·d, by variations of D: the row −g, g × D, g, 0.
#[inline(always)]
fn coordinates(tile: &Tile, out: &mut [Row]) {
    let [a, b] = &tile.displacement;
    let d = [0, 1, 2].map(|i| LanesOf(tile.reference[i]) + (LanesOf(b[i]) - LanesOf(a[i])));
    let [zero, one] = [0.0, 1.0].map(Lanes::splat);
    let seeds = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    let moved = [dual(d[0], seeds[0]), dual(d[1], seeds[1]), dual(d[2], seeds[2])];
    for i in 0..3 {
        let e = column(&tile.triad[0], i).map(|x| Dual::from_re(Number(x)));
        let (value, g) = parts(e[0] * moved[0] + e[1] * moved[1] + e[2] * moved[2]);
        let arm = [g[1] * d[2] - g[2] * d[1], g[2] * d[0] - g[0] * d[2], g[0] * d[1] - g[1] * d[0]];
        put(&mut out[i], value, [g.map(Neg::neg), arm, g, NONE]);
    }
}

/// Q = AᵀB, by variations ρ along e_i^a: δQ = ρ^ Q.
#[inline(always)]
fn relative(tile: &Tile) -> [[Dual; 3]; 3] {
    let entry = |i: usize, j: usize| dot(column(&tile.triad[0], i), column(&tile.triad[1], j));
    let q = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)));
    let zero = Lanes::splat(0.0);
    let of = |j: usize| {
        let [x, y, z] = [q[0][j], q[1][j], q[2][j]];
        [dual(x, [zero, z, -y]), dual(y, [-z, zero, x]), dual(z, [y, -x, zero])]
    };
    let columns = [of(0), of(1), of(2)];
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| columns[j][i]))
}

/// The row 0, −h, 0, h of a function of Q.
#[inline(always)]
fn put_turned(tile: &Tile, of: Dual, row: &mut Row) {
    let (value, by) = parts(of);
    let line = |i: usize| [0, 1, 2].map(|j| LanesOf(tile.triad[0][i][j]));
    let h = [dot(line(0), by), dot(line(1), by), dot(line(2), by)];
    put(row, value, [NONE, h.map(Neg::neg), NONE, h]);
}

#[inline(always)]
fn rotation_vector(tile: &Tile, out: &mut [Row]) {
    let q = relative(tile);
    let v = [q[2][1] - q[1][2], q[0][2] - q[2][0], q[1][0] - q[0][1]];
    let sine = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let factor = sine.atan2(q[0][0] + q[1][1] + q[2][2] - 1.0) / sine;
    for i in 0..3 {
        put_turned(tile, v[i] * factor, &mut out[i]);
    }
}

/// The rows of a tile, by the formulas of `naive`.
#[inline(always)]
pub(crate) fn rows(name: &str, tile: &Tile, out: &mut [Row]) {
    match name {
        "SLIDE-PLANE" => coordinates(tile, out),
        "TRANSLATOR" => {
            coordinates(tile, out);
            rotation_vector(tile, &mut out[3..]);
        }
        "ROTATION" => rotation_vector(tile, out),
        "REVOLUTE" => {
            let q = relative(tile);
            put_turned(tile, (-q[1][2]).atan2(q[2][2]), &mut out[0]);
            put_turned(tile, q[0][2], &mut out[1]);
            put_turned(tile, q[0][1], &mut out[2]);
        }
        _ => {
            let q = relative(tile);
            let (y, x) = (-q[1][2], q[2][2]);
            put_turned(tile, y.atan2(x), &mut out[0]);
            put_turned(tile, q[0][2].atan2((x * x + y * y).sqrt()), &mut out[1]);
            put_turned(tile, (-q[0][1]).atan2(q[0][0]), &mut out[2]);
        }
    }
}
