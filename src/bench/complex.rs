//! The complex step: f(x + ih) = f(x) + ih f′(x) + O(h²), a derivative without a difference.

use crate::scalar::Scalar;
use std::ops::{Add, Mul, Neg, Sub};

/// re + i·im.
///
/// Elementary functions of it are their Taylor polynomials about the real part up to i·im, so that their branches are decided on the
/// real part, and a type whose formulas choose between branches has a complex step too. Beside exact complex functions that leaves out
/// terms of the size im²: no less work than a first derivative needs, and no more. Products are those of complex numbers, im² included.
#[derive(Clone, Copy, Debug)]
pub(super) struct Complex {
    pub(super) re: f64,
    pub(super) im: f64,
}

impl Add for Complex {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Complex {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

impl Neg for Complex {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { re: -self.re, im: -self.im }
    }
}

impl Scalar for Complex {
    type Real = f64;
    const ORDER: usize = 1;

    #[inline(always)]
    fn from_real(value: f64) -> Self {
        Self { re: value, im: 0.0 }
    }

    #[inline(always)]
    fn real(self) -> f64 {
        self.re
    }

    #[inline(always)]
    fn nilpotent(self) -> Self {
        Self { re: 0.0, im: self.im }
    }

    #[inline(always)]
    fn with_real(self, value: f64) -> Self {
        Self { re: value, im: self.im }
    }

    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        Self { re: self.re * factor, im: self.im * factor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::elementary::atan2;

    /// The imaginary part over the step is the derivative, to rounding, also at an exact right angle.
    #[test]
    fn the_step_needs_no_difference() {
        let h = 1e-30;
        let angle = atan2(Complex::from_real(1.0), Complex { re: 0.0, im: h });
        assert_eq!((angle.re, angle.im / h), (std::f64::consts::FRAC_PI_2, -1.0));
        // A product has the error of the complex step, h².
        let x = Complex { re: 0.5, im: 1e-3 };
        let slope = (x * x * x).im / 1e-3;
        assert!((slope - 0.75 + 1e-6).abs() < 1e-15, "{slope}");
    }
}
