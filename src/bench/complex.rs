//! The complex step: f(x + ih) = f(x) + ih f′(x) − h² f″(x)/2 …, of which Im f(x + ih)/h is f′ but for h² f‴/6, without a difference.

use crate::measure::{History, Measure, Section, Shared};
use crate::node::{DOFS, Node, Pair};
use crate::scalar::{MAX_ORDER, Real, Scalar, Series};
use crate::vector::{Vector, exact, exact_matrix};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// re + i·im, as a number underneath: the formulas are those of `f64`, continued to complex numbers.
///
/// Every function is the analytic one, written such that an imaginary part as small as 1e−100 is not lost beside the real one. Branches are
/// decided on the real part, and norms and absolute values are roots of sums of squares, not of products with conjugates: what has a branch
/// has a complex step on either side of it. Magnitudes are between 1e−140 and 1e140.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Complex {
    pub(super) re: f64,
    pub(super) im: f64,
}

const fn complex(re: f64, im: f64) -> Complex {
    Complex { re, im }
}

impl Complex {
    /// ln z, off the cut of negative numbers.
    fn logarithm(self) -> Self {
        complex(self.re.hypot(self.im).ln(), self.im.atan2(self.re))
    }

    /// atan z, off the cuts from ±i: ½ arg, and ¼ ln of 1 + 4y/(x² + (1 − y)²), which keeps a small y.
    fn arctangent_of(self) -> Self {
        let Self { re: x, im: y } = self;
        let re = 0.5 * (2.0 * x).atan2((1.0 - x) * (1.0 + x) - y * y);
        complex(re, 0.25 * (4.0 * y / (x * x + (1.0 - y) * (1.0 - y))).ln_1p())
    }

    fn times(self, factor: f64) -> Self {
        complex(self.re * factor, self.im * factor)
    }

    fn is_zero(self) -> bool {
        self.re == 0.0 && self.im == 0.0
    }
}

impl Add for Complex {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        complex(self.re + other.re, self.im + other.im)
    }
}

impl Sub for Complex {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        complex(self.re - other.re, self.im - other.im)
    }
}

impl Mul for Complex {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        complex(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)
    }
}

impl Div for Complex {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / (other.re * other.re + other.im * other.im);
        let re = self.re * other.re + self.im * other.im;
        complex(re * inverse, (self.im * other.re - self.re * other.im) * inverse)
    }
}

impl Neg for Complex {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        complex(-self.re, -self.im)
    }
}

impl Scalar for Complex {
    type Real = Self;
    const ORDER: usize = 0;

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
        complex(0.0, 0.0)
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

impl Real for Complex {
    fn integer(n: i32) -> Self {
        complex(n.into(), 0.0)
    }

    fn from_f64(x: f64) -> Self {
        complex(x, 0.0)
    }

    fn pi() -> Self {
        complex(std::f64::consts::PI, 0.0)
    }

    fn with_turns(principal: Self, n: Self) -> Self {
        complex(f64::with_turns(principal.re, n.re), principal.im)
    }

    fn nearest_integer(self) -> Self {
        complex(self.re.round(), 0.0)
    }

    /// The root with the positive real part: √((|z| + |re|)/2) is its larger part.
    fn square_root(self) -> Self {
        if self.is_zero() {
            return self;
        }
        let larger = (0.5 * (self.re.hypot(self.im) + self.re.abs())).sqrt();
        let smaller = 0.5 * self.im.abs() / larger;
        if self.re < 0.0 {
            complex(smaller, larger.copysign(self.im))
        } else {
            complex(larger, smaller.copysign(self.im))
        }
    }

    /// √z² with the sign that makes the real part positive.
    fn magnitude(self) -> Self {
        if self.re < 0.0 { -self } else { self }
    }

    fn with_sign_of(self, sign: Self) -> Self {
        let magnitude = self.magnitude();
        if sign.re < 0.0 { -magnitude } else { magnitude }
    }

    fn reciprocal_or_zero(self) -> Self {
        if self.is_zero() { self } else { Self::integer(1) / self }
    }

    fn exponential_minus_one(self) -> Self {
        let half = (0.5 * self.im).sin();
        let grown = self.re.exp();
        complex(self.re.exp_m1() - 2.0 * grown * half * half, grown * self.im.sin())
    }

    fn power(self, exponent: Self) -> Self {
        if self.is_zero() { self } else { (self.logarithm() * exponent).exponential() }
    }

    type Mask = bool;

    fn less(self, other: Self) -> bool {
        self.re < other.re
    }

    fn holds(mask: bool) -> bool {
        mask
    }

    fn sine_cosine(self) -> (Self, Self) {
        let ((sin, cos), (sinh, cosh)) = (self.re.sin_cos(), (self.im.sinh(), self.im.cosh()));
        (complex(sin * cosh, cos * sinh), complex(cos * cosh, -sin * sinh))
    }

    fn exponential(self) -> Self {
        let (sin, cos) = self.im.sin_cos();
        complex(cos, sin).times(self.re.exp())
    }

    /// The angle θ₀ of the real parts, and the arctangent of how far the point lies aside of that direction over how far along it.
    fn arctangent(self, x: Self) -> Self {
        let angle = self.re.atan2(x.re);
        let [c, s] = f64::direction_and_norm([x.re, self.re]).0;
        let aside = complex(0.0, c * self.im - s * x.im);
        let along = complex(c * x.re + s * self.re, c * x.im + s * self.im);
        if along.is_zero() {
            return complex(angle, 0.0);
        }
        complex(angle, 0.0) + (aside / along).arctangent_of()
    }

    fn direction_and_norm<const N: usize>(v: [Self; N]) -> ([Self; N], Self) {
        let square = v.iter().fold(complex(0.0, 0.0), |sum, x| sum + *x * *x);
        let norm = square.square_root();
        let inverse = norm.reciprocal_or_zero();
        (v.map(|x| x * inverse), norm)
    }

    fn exp_series(s: Self, _: usize) -> (Series<Self>, Series<Self>) {
        let (mut w, mut k) = ([complex(0.0, 0.0); MAX_ORDER + 1], [complex(0.0, 0.0); MAX_ORDER + 1]);
        let half = s.square_root().times(0.5);
        let (sine, cosine) = half.sine_cosine();
        w[0] = cosine;
        // sin(x)/2x, by 1 − x²/6 where the next term is no longer seen.
        let is_small = s.re.hypot(s.im) < 1e-7;
        k[0] = if is_small { Self::from_f64(0.5) - s.times(1.0 / 48.0) } else { sine / half.times(2.0) };
        (w, k)
    }

    /// 2 atan2(s, c)/s with s = √(1 − c²), which is 2 (1 + s²/6 + 3 s⁴/40 …) where s is small.
    fn log_series(c: Self, _: usize) -> Series<Self> {
        let one = Self::integer(1);
        let square = (one - c) * (one + c);
        let mut series = [complex(0.0, 0.0); MAX_ORDER + 1];
        if square.re.hypot(square.im) < 0.04 && c.re > 0.0 {
            // The coefficient of sᵏ⁺² in asin(s)/s is (k + 1)²/((k + 2)(k + 3)) times that of sᵏ.
            let mut sum = one;
            for k in (0..24).step_by(2).rev() {
                let k = f64::from(k);
                sum = one + (square * sum).times((k + 1.0) * (k + 1.0) / ((k + 2.0) * (k + 3.0)));
            }
            series[0] = sum.times(2.0);
        } else {
            let sine = square.square_root();
            series[0] = (sine.arctangent(c) / sine).times(2.0);
        }
        series
    }
}

/// What does not move.
pub(super) struct Still {
    section: Section<Complex>,
    history: History<Complex>,
}

impl Still {
    pub(super) fn new(section: &Section<f64>, history: &History<f64>) -> Self {
        Self {
            section: Section {
                initial_orientation: exact_matrix(&section.initial_orientation),
                initial_length: Complex::from_f64(section.initial_length),
                fixed_direction: exact(section.fixed_direction),
                flow_scale: Complex::from_f64(section.flow_scale),
            },
            history: History {
                rotation_vector: exact(history.rotation_vector),
                euler_sign: Complex::from_f64(history.euler_sign),
                torsion_turns: Complex::from_f64(history.torsion_turns),
            },
        }
    }

    /// Im f(q + ih e)/h of each measure, for a degree of freedom of the nodes.
    pub(super) fn derivatives<'a>(
        &'a self,
        pair: &Pair<f64>,
        measures: &'a [Measure],
        dof: usize,
        h: f64,
        mut put: impl FnMut(usize, f64),
    ) {
        let moved = stepped(pair, dof, h);
        let relative = moved.relative();
        let triad_a = exact_matrix(&pair.a.triad);
        let mut shared = Shared::new(&relative, &triad_a, &self.section, &self.history);
        for (row, measure) in measures.iter().enumerate() {
            put(row, measure.evaluate(&mut shared).im / h);
        }
    }
}

/// The pair with a degree of freedom moved by ih; a rotation of ih about a global axis e takes a triad C to exp(ih e^) C, with
/// exp(ih e^) = I + i sinh h e^ + (1 − cosh h) e^².
fn stepped(pair: &Pair<f64>, dof: usize, h: f64) -> Pair<Complex> {
    let end = |node: &Node<f64>, dof: Option<usize>| {
        let mut moved = Node {
            displacement: exact::<Complex>(node.displacement),
            triad: exact_matrix::<Complex>(&node.triad),
            flow: Complex::from_f64(node.flow),
        };
        match dof {
            Some(i @ 0..3) => moved.displacement[i].im = h,
            Some(i @ 3..6) => {
                let (j, k) = ((i - 2) % 3, (i - 1) % 3);
                let (sinh, cosh) = (h.sinh(), h.cosh());
                for column in 0..3 {
                    let [own, next] = [node.triad[j][column], node.triad[k][column]];
                    moved.triad[j][column] = complex(own * cosh, -next * sinh);
                    moved.triad[k][column] = complex(next * cosh, own * sinh);
                }
            }
            Some(_) => moved.flow.im = h,
            None => {}
        }
        moved
    };
    let (own, of_b) = (dof % (DOFS / 2), dof >= DOFS / 2);
    let (a, b) = (end(&pair.a, (!of_b).then_some(own)), end(&pair.b, of_b.then_some(own)));
    let reference: Vector<Complex> = exact(pair.reference);
    Pair { reference, a, b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::elementary::{atan2, norm};
    use std::f64::consts::FRAC_PI_2;

    /// The imaginary part over the step is the derivative, to rounding, also at an exact right angle.
    #[test]
    fn the_step_needs_no_difference() {
        let h = 1e-100;
        let angle = atan2(complex(1.0, 0.0), complex(0.0, h));
        assert_eq!((angle.re, angle.im / h), (FRAC_PI_2, -1.0));
        let length = norm([complex(3.0, h), complex(-4.0, 0.0)]);
        assert_eq!(length.re, 5.0);
        assert!((length.im / h - 0.6).abs() <= f64::EPSILON, "{:e}", length.im / h);
    }

    /// f(z̄) = conj f(z), and the inverse functions undo what they are the inverse of, on complex numbers too.
    #[test]
    fn functions_are_those_of_complex_numbers() {
        let near = |x: Complex, y: Complex| {
            assert!((x - y).re.hypot((x - y).im) < 4e-15, "{x:?} for {y:?}");
        };
        for (re, im) in [(0.3, 0.2), (1.2, -0.4), (0.05, 1e-3), (0.999, 0.3)] {
            let z = complex(re, im);
            let root = z.square_root();
            near(root * root, z);
            let (sine, cosine) = z.sine_cosine();
            near(sine * sine + cosine * cosine, complex(1.0, 0.0));
            near(sine.arctangent(cosine), z);
            near((-sine).arctangent(-cosine), z - Complex::pi());
            near(z.exponential() - Complex::integer(1), z.exponential_minus_one());
            near(z.power(complex(2.0, 0.0)), z * z);
            // K(cos x) = 2x / sin x.
            near(Complex::log_series(cosine, 0)[0] * sine, z.times(2.0));
            // w = cos(x/2), k = sin(x/2)/x at s = x².
            let (w, k) = Complex::exp_series(z * z, 0);
            let (sine, cosine) = z.times(0.5).sine_cosine();
            near(w[0], cosine);
            near(k[0] * z, sine);
        }
    }
}
