//! `f64` as a [`Real`]: formulas chosen so that every Taylor coefficient is accurate on the whole domain.

use crate::scalar::coefficients::{BESSEL_1, BESSEL_2, LOG_1, LOG_2};
use crate::scalar::{MAX_ORDER, Real, Scalar, Series};
use std::f64::consts::TAU;

/// 2π − [`TAU`], so that `TAU + TAU_REST` is 2π to 107 bits.
const TAU_REST: f64 = 2.449_293_598_294_706_4e-16;

impl Scalar for f64 {
    type Real = Self;
    const ORDER: usize = 0;
    const IS_INLINED: bool = true;

    #[inline(always)]
    fn from_real(value: Self) -> Self {
        value
    }

    #[inline(always)]
    fn real(self) -> Self {
        self
    }

    #[inline(always)]
    fn nilpotent(self) -> Self {
        0.0
    }

    #[inline(always)]
    fn with_real(self, value: Self) -> Self {
        value
    }

    #[inline(always)]
    fn scale(self, factor: Self) -> Self {
        self * factor
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn integer(n: i32) -> Self {
        Self::from(n)
    }

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn pi() -> Self {
        std::f64::consts::PI
    }

    #[inline(always)]
    fn quaternion_of(r: &[[Self; 3]; 3]) -> [Self; 4] {
        crate::so3::dominant_eigenvector(r)
    }

    #[inline(always)]
    fn with_turns(principal: Self, n: Self) -> Self {
        // 2πn as a sum of two doubles, then the sum with its rounding error (Knuth).
        let whole = n * TAU;
        let rest = n.mul_add(TAU, -whole) + n * TAU_REST;
        let sum = whole + principal;
        let shifted = sum - whole;
        let lost = (whole - (sum - shifted)) + (principal - shifted);
        sum + (lost + rest)
    }

    #[inline(always)]
    fn nearest_integer(self) -> Self {
        self.round()
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        self.copysign(sign)
    }

    #[inline(always)]
    fn reciprocal_or_zero(self) -> Self {
        let inverse = 1.0 / self;
        if inverse.is_infinite() { 0.0 } else { inverse }
    }

    #[inline(always)]
    fn exponential_minus_one(self) -> Self {
        self.exp_m1()
    }

    #[inline(always)]
    fn power(self, exponent: Self) -> Self {
        self.powf(exponent)
    }

    type Mask = bool;

    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn holds(mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn sine_cosine(self) -> (Self, Self) {
        self.sin_cos()
    }

    #[inline(always)]
    fn exponential(self) -> Self {
        self.exp()
    }

    #[inline(always)]
    fn arctangent(self, x: Self) -> Self {
        self.atan2(x)
    }

    #[inline(always)]
    fn direction_and_norm<const N: usize>(v: [Self; N]) -> ([Self; N], Self) {
        let Some((scale, square)) = scaled_square(v) else { return ([0.0; N], 0.0) };
        let norm = square.sqrt();
        (each_of(v, |x| x * scale / norm), norm / scale)
    }

    /// One division per component: 1.5 u, where dividing the direction by the norm would make 3 u.
    #[inline(always)]
    fn inverted<const N: usize>(v: [Self; N]) -> [Self; N] {
        let Some((scale, square)) = scaled_square(v) else { return [0.0; N] };
        let inverted = each_of(v, |x| x * scale / square * scale);
        if inverted.iter().all(|x| x.is_finite()) { inverted } else { [0.0; N] }
    }

    #[inline(always)]
    fn exp_series(s: Self, order: usize) -> (Series<Self>, Series<Self>) {
        // With x = √s / 2 and g_n = j_n(x)/xⁿ (g₋₁ = cos x): w = Σ (−1/8)ⁿ/n! g_(n−1) eⁿ, k = ½ Σ (−1/8)ⁿ/n! g_n eⁿ.
        let g = bessel_ratios(s / 4.0, order);
        let mut w = [0.0; MAX_ORDER + 1];
        let mut k = [0.0; MAX_ORDER + 1];
        let mut factor = 1.0;
        for n in 0..=order {
            w[n] = factor * g[n];
            k[n] = 0.5 * factor * g[n + 1];
            factor *= -0.125 / (n + 1) as Self;
        }
        (w, k)
    }

    #[inline(always)]
    fn log_series(c: Self, order: usize) -> Series<Self> {
        let mut k = [0.0; MAX_ORDER + 1];
        let rest = (1.0 - c) * (1.0 + c); // 1 − c²
        k[0] = if c < 1.0 { 2.0 * c.acos() / rest.sqrt() } else { 2.0 };
        if order == 0 {
            return k;
        }
        let y = 0.5 * (1.0 - c);
        // (1 − c²) K′ = c K − 2 and its derivatives. For positive c the recurrence subtracts: beyond a half the first two coefficients
        // feel it, and the others everywhere.
        let recurrence = |k: &[f64], n: usize| match n {
            1 => (c * k[0] - 2.0) / rest,
            _ => ((2 * n - 1) as Self * c * k[n - 1] + (n - 1) as Self * k[n - 2]) / (n as Self * rest),
        };
        for n in 1..=order {
            k[n] = match n {
                1 if c > 0.5 => polynomial(&LOG_1, y),
                2 if c > 0.5 => polynomial(&LOG_2, y),
                3.. if c > 0.0 => log_power_series(y, n),
                _ => recurrence(&k, n),
            };
        }
        k
    }
}

/// A power of two p such that the squares of p v neither overflow nor lose digits to subnormals, and |p v|²; None at v = 0.
#[inline(always)]
fn scaled_square<const N: usize>(v: [f64; N]) -> Option<(f64, f64)> {
    let largest = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let scale = if largest > 1e140 {
        2f64.powi(-600)
    } else if largest < 1e-140 {
        2f64.powi(600)
    } else {
        1.0
    };
    let mut square = 0.0;
    for x in v {
        square += (x * scale) * (x * scale);
    }
    Some((scale, square))
}

/// f of each. `map` of arrays is a call where another unit of the crate compiled it.
#[inline(always)]
fn each_of<const N: usize>(mut v: [f64; N], f: impl Fn(f64) -> f64) -> [f64; N] {
    for x in &mut v {
        *x = f(*x);
    }
    v
}

/// Σ c_i xⁱ by Horner's rule.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f64; N], x: f64) -> f64 {
    let mut sum = c[N - 1];
    for i in (0..N - 1).rev() {
        sum = sum * x + c[i];
    }
    sum
}

/// g_(n−1) = j_(n−1)(x)/x^(n−1) for n = 0 … order + 1, with g₋₁ = cos x; x² = `square`.
#[inline(always)]
fn bessel_ratios(square: f64, order: usize) -> [f64; MAX_ORDER + 2] {
    let mut g = [0.0; MAX_ORDER + 2];
    let x = square.sqrt();
    let (sin, cos) = x.sin_cos();
    g[0] = cos;
    g[1] = if x <= 1e-8 { 1.0 } else { sin / x };
    if order <= 2 && square < 5.0 {
        g[2] = polynomial(&BESSEL_1, square);
        if order == 2 {
            g[3] = polynomial(&BESSEL_2, square);
        }
        return g;
    }
    let top = order + 1;
    if x < 1.6 + 0.7 * order as f64 {
        // Downwards from two series: g_n = (2n + 3) g_(n+1) − x² g_(n+2) is stable in this direction.
        g[top] = bessel_power_series(square, top - 1);
        g[top - 1] = bessel_power_series(square, top - 2);
        for i in (2..top - 1).rev() {
            g[i] = (2 * i + 1) as f64 * g[i + 1] - square * g[i + 2];
        }
    } else {
        for i in 2..=top {
            g[i] = ((2 * i - 3) as f64 * g[i - 1] - g[i - 2]) / square;
        }
    }
    g
}

/// j_n(x)/xⁿ = Σ (−x²/2)ᵏ / (k! (2n + 2k + 1)!!), x² = `square` < 25.
fn bessel_power_series(square: f64, n: usize) -> f64 {
    let mut term = 1.0;
    for i in 1..=n {
        term /= (2 * i + 1) as f64;
    }
    let mut sum = 0.0;
    for k in 0..30 {
        sum += term;
        term *= -0.5 * square / ((k + 1) * (2 * n + 2 * k + 3)) as f64;
    }
    sum
}

/// K⁽ⁿ⁾(c)/n! by its power series in y = (1 − c)/2 ≤ 1/2, all of whose terms have one sign.
fn log_power_series(y: f64, n: usize) -> f64 {
    let mut weight = 2.0; // 2 (2i)!!/(2i + 1)!!
    let mut sum = 0.0;
    let mut power = 1.0; // C(i, n) y^(i − n)
    for i in 0..n + 70 {
        if i >= n {
            sum += weight * power;
            power *= y * (i + 1) as f64 / (i + 1 - n) as f64;
        }
        weight *= (2 * i + 2) as f64 / (2 * i + 3) as f64;
    }
    sum * (-0.5f64).powi(n as i32)
}
