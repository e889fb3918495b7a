//! Elementary functions, lifted: exact derivatives of every order the scalar carries.
//!
//! Each is written in the frame of its real part, where the rest is nilpotent, so that no derivative is ever taken
//! through a division, a square root or an arctangent. Errors are stated in units u = 2⁻⁵³ of the conditioned scale
//! |f| + Σ|x_i||∂f/∂x_i| (value / first / second derivative; `verify/numbers/numerics.rs` measures them).
//! They hold on doubles with any type that carries up to two orders, and on lanes but for [`norm`] (1 / 3 / 4 u) and [`direction`] (3 / 4 / 5 u).

use crate::scalar::{MAX_ORDER, Real, Scalar, Series};

inlined_for_doubles! {
    /// √x for x > 0, 1 / 1.5 / 2 u.
    ///
    /// At x = 0 the value is 0 and the derivatives, which do not exist, are 0.
    pub fn sqrt<S: Scalar>(x: S) -> S {
        let root = x.real().square_root();
        if const { S::ORDER == 0 } {
            return S::from_real(root);
        }
        // √(x₀(1 + r)) with r = e / x₀; the first order on its own, so that no intermediate overflows.
        let ratio = S::Real::ratio;
        let slope = x.nilpotent().scale(root.reciprocal_or_zero() * ratio(1, 2));
        if const { S::ORDER == 1 } {
            return slope.with_real(root);
        }
        let r = x.nilpotent().scale(x.real().reciprocal_or_zero());
        let c = [S::Real::integer(1), ratio(-1, 4), ratio(1, 8), ratio(-5, 64)];
        let mut sum = S::from_real(c[S::ORDER - 1]);
        for k in (0..S::ORDER - 1).rev() {
            sum = S::from_real(c[k]) + r * sum;
        }
        S::from_real(root) + slope * sum
    }
}

inlined_for_doubles! {
    /// 1 / √x for x > 0, 2 / 2 / 3 u; at x = 0 the value and the derivatives, which do not exist, are 0.
    pub fn inverse_sqrt<S: Scalar>(x: S) -> S {
        let root = x.real().square_root().reciprocal_or_zero();
        if const { S::ORDER == 0 } {
            return S::from_real(root);
        }
        let r = x.nilpotent().scale(x.real().reciprocal_or_zero());
        let ratio = S::Real::ratio;
        let c = [S::Real::integer(1), ratio(-1, 2), ratio(3, 8), ratio(-5, 16), ratio(35, 128)];
        let mut sum = S::from_real(c[S::ORDER]);
        for k in (0..S::ORDER).rev() {
            sum = S::from_real(c[k]) + r * sum;
        }
        sum.scale(root)
    }
}

inlined_for_doubles! {
    /// 1 / x for x ≠ 0, 1 / 2 / 3 u; at x = 0 the value and the derivatives, which do not exist, are 0.
    pub fn recip<S: Scalar>(x: S) -> S {
        let inverse = x.real().reciprocal_or_zero();
        if const { S::ORDER == 0 } {
            return S::from_real(inverse);
        }
        inverse_one_plus(x.nilpotent().scale(inverse)).scale(inverse)
    }
}

inlined_for_doubles! {
    /// x / y for y ≠ 0, of quotients alone: no power of 1 / y underflows or overflows that the result does not have. At y = 0 the value and
    /// the derivatives, which do not exist, are 0.
    pub(crate) fn ratio<S: Scalar>(x: S, y: S) -> S {
        let inverse = y.real().reciprocal_or_zero();
        let scaled = x.scale(inverse);
        if const { S::ORDER == 0 } {
            return scaled;
        }
        scaled * inverse_one_plus(y.nilpotent().scale(inverse))
    }
}

/// 1 / (1 + r) = 1 − r + r² … for nilpotent r.
#[inline(always)]
fn inverse_one_plus<S: Scalar>(r: S) -> S {
    let mut sum = S::one();
    unrolled!(_k < S::ORDER, {
        sum = S::one() - r * sum;
    });
    sum
}

inlined_for_doubles! {
    /// (sin x, cos x), x in radians.
    pub fn sin_cos<S: Scalar>(x: S) -> (S, S) {
        let (s, c) = x.real().sine_cosine();
        if const { S::ORDER == 0 } {
            return (S::from_real(s), S::from_real(c));
        }
        let (half, sixth, twenty_fourth) = (S::Real::ratio(1, 2), S::Real::ratio(1, 6), S::Real::ratio(1, 24));
        (
            x.lift(&[s, c, -(s * half), -(c * sixth), s * twenty_fourth]),
            x.lift(&[c, -s, -(c * half), s * sixth, c * twenty_fourth]),
        )
    }
}

inlined_for_doubles! {
    /// eˣ, 1 / 1 / 1 u.
    pub fn exp<S: Scalar>(x: S) -> S {
        let e = x.real().exponential();
        let ratio = S::Real::ratio;
        x.lift(&[e, e, e * ratio(1, 2), e * ratio(1, 6), e * ratio(1, 24)])
    }
}

inlined_for_doubles! {
    /// The angle of the point (x, y) in (−π, π], 1 / 2 / 3 u, exact right angles included.
    ///
    /// With (c, s) = (x₀, y₀)/r²: θ₀ + atan t, t = (c e_y − s e_x) / (1 + c e_x + s e_y). At the origin the value is 0 and the
    /// derivatives, which do not exist, are 0.
    pub fn atan2<S: Scalar>(y: S, x: S) -> S {
        let angle = S::from_real(y.real().arctangent(x.real()));
        if const { S::ORDER == 0 } {
            return angle;
        }
        let [c, s] = S::Real::inverted([x.real(), y.real()]);
        let (ex, ey) = (x.nilpotent(), y.nilpotent());
        let lateral = ey.scale_add(c, ex.scale(-s));
        if const { S::ORDER == 1 } {
            return lateral.with_real(angle.real());
        }
        let radial = ey.scale_add(s, ex.scale(c));
        let shortened = |lateral: S, radial: S| {
            if const { S::ORDER == 2 } {
                return lateral.nilpotent_product(radial);
            }
            lateral.nilpotent_times(radial.nilpotent_times(inverse_one_plus(radial)))
        };
        let size = c.magnitude() + s.magnitude();
        let is_near = || S::Real::from_f64(1e150).less(size);
        let t = if const { !S::Real::HAS_LANES } && S::Real::shortcut(is_near) {
            // So near the origin the product is formed without 1/r, so that it overflows only where second derivatives do.
            let flat = lateral.scale(size.reciprocal_or_zero());
            (flat - shortened(flat, radial)).scale(size)
        } else {
            lateral - shortened(lateral, radial)
        };
        if const { S::ORDER == 2 } {
            return t.with_real(angle.real());
        }
        angle + t - (t * t * t).scale(S::Real::ratio(1, 3))
    }
}

/// The angle of the point (x, 0 − y), as [`atan2`] gives it, of direction cosines: half a turn is +π for y = 0 too.
///
/// On lanes, first derivatives at a point nearer to the origin than 1e−150, which is far within the rounding of a lock, are too small.
#[inline(always)]
pub fn atan2_opposite<S: Scalar>(y: S, x: S) -> S {
    if const { !S::Real::HAS_LANES || S::ORDER != 1 } {
        return atan2(S::zero() - y, x);
    }
    // Without the opposite of y, whose square is that of y, lanes take its reciprocal once for this and for |(y, x)|.
    let value = (S::Real::ZERO - y.real()).arctangent(x.real());
    let ([s, c], _) = S::Real::inverted_cosines([y.real(), x.real()]);
    y.scale_add(-c, x.scale(s)).with_real(value)
}

/// The angle of the point (|x|, y) in [−π/2, π/2], of direction cosines y and x: atan2(y, |x|), with what [`atan2_opposite`] says of lanes.
#[inline(always)]
pub fn elevation<S: Scalar>(y: S, x: [S; 2]) -> S {
    if const { !S::Real::HAS_LANES || S::ORDER != 1 } {
        return atan2(y, norm(x));
    }
    let ([u, v], across) = S::Real::inverted_cosines([x[0].real(), x[1].real()]);
    let ([c, s], _) = S::Real::inverted_cosines([across, y.real()]);
    let value = y.real().arctangent(across);
    // c δy − s (x·δx)/|x|.
    let along = -(s * across);
    y.scale_add(c, x[0].scale_add(u * along, x[1].scale(v * along))).with_real(value)
}

/// |v|, 1 / 2 / 4 u for components between 1e−300 and 1e300.
///
/// With u = v₀/|v₀|, a = u·e and p the components of e across u: |v| = (|v₀| + a) √(1 + t·t), t = p/(|v₀| + a); nothing
/// cancels. At v = 0 the value is 0 and the derivatives, which do not exist, are 0.
#[inline(always)]
pub fn norm<S: Scalar, const N: usize>(v: [S; N]) -> S {
    norm_and_direction(v).0
}

/// v / |v|, 2 / 4 / 5 u; the zero vector where v = 0 (the direction does not exist there: the caller keeps another).
#[inline(always)]
pub fn direction<S: Scalar, const N: usize>(v: [S; N]) -> [S; N] {
    norm_and_direction(v).1
}

inlined_for_doubles! {
    /// (|v|, v / |v|), sharing what [`norm`] and [`direction`] have in common.
    pub fn norm_and_direction<S: Scalar, const N: usize>(v: [S; N]) -> (S, [S; N]) {
        let mut real = const { [S::Real::ZERO; N] };
        each!(S, i < N, {
            real[i] = v[i].real();
        });
        let (u, n) = S::Real::direction_and_norm(real);
        if const { S::ORDER == 0 } {
            let mut constant = v;
            each!(S, i < N, {
                constant[i] = S::from_real(u[i]);
            });
            return (S::from_real(n), constant);
        }
        let inverse = n.reciprocal_or_zero();
        let mut e = v;
        let mut a = S::zero();
        each!(S, i < N, {
            e[i] = v[i].nilpotent();
            a = a + e[i].scale(u[i]);
        });
        // With p_ij = u_j e_i − u_i e_j: the part of e across u is Σ_j p_ij u_j, and its square Σ_{i<j} p_ij². Over 1 + a/n, these are
        // P_ij, τ and Σ P_ij²: the tangent is τ/n. What is multiplied is of the size of e, and divided by n last, so that nothing
        // overflows that the derivatives do not.
        let radial = a.scale(inverse);
        let shorten = if const { S::ORDER > 2 } { inverse_one_plus(radial) } else { S::one() };
        let mut tangent = [S::zero(); N]; // τ
        let mut rise = S::zero(); // Σ p P/n
        let mut square = S::zero(); // Σ P²/n
        each!(S, i < N, {
            each!(S, j < i; N, {
                let p = e[i].scale(u[j]) - e[j].scale(u[i]);
                let short = if const { S::ORDER > 2 } {
                    p.nilpotent_times(shorten)
                } else if const { S::ORDER == 2 } {
                    p - p.nilpotent_product(radial)
                } else {
                    p
                };
                tangent[i] = tangent[i] + short.scale(u[j]);
                tangent[j] = tangent[j] - short.scale(u[i]);
                if const { S::ORDER == 2 } {
                    rise = rise + p.nilpotent_product(p.scale(inverse));
                } else if const { S::ORDER > 2 } {
                    rise = rise + p.nilpotent_product(short.scale(inverse));
                    square = square + short.nilpotent_product(short.scale(inverse));
                }
            })
        });
        if const { S::ORDER == 2 } {
            square = rise;
        }
        let mut length = S::from_real(n) + a;
        let mut unit = v;
        let half = S::Real::ratio(1, 2);
        if const { S::ORDER > 1 } {
            length = length + rise.scale(half); // √(1 + t·t) = 1 + t·t/2 − (t·t)²/8
        }
        let quotient = if const { S::ORDER > 2 } { square.scale(inverse) } else { S::zero() }; // t·t
        let mut shrink = square.scale(-half);
        if const { S::ORDER > 3 } {
            length = length - rise.nilpotent_product(quotient).scale(S::Real::ratio(1, 8));
            shrink = shrink + square.nilpotent_product(quotient).scale(S::Real::ratio(3, 8));
        }
        each!(S, i < N, {
            let mut across = tangent[i];
            if const { S::ORDER > 1 } {
                across = across + shrink.scale(u[i]);
            }
            if const { S::ORDER > 2 } {
                across = across - tangent[i].nilpotent_product(quotient).scale(half);
            }
            unit[i] = S::from_real(u[i]) + across.scale(inverse);
        });
        (length, unit)
    }
}

/// |x|.
///
/// At x = 0 the value is 0 and the derivatives, which do not exist, are 0.
#[inline(always)]
pub fn abs<S: Scalar>(x: S) -> S {
    norm([x])
}

inlined_for_doubles! {
    /// exp x − 1, accurate near 0.
    pub fn exp_m1<S: Scalar>(x: S) -> S {
        let value = x.real().exponential_minus_one();
        x.lift(&exponential_series(value, x.real().exponential()))
    }
}

/// The Taylor coefficients of a function whose derivatives are all `slope`, as those of exp − 1.
#[inline(always)]
fn exponential_series<R: Real>(value: R, slope: R) -> Series<R> {
    let by = |n| slope / R::integer(n);
    [value, slope, by(2), by(6), by(24)]
}

inlined_for_doubles! {
    /// xᵖ for x ≥ 0 and a real p > 0.
    ///
    /// At x = 0 the value is 0; derivatives that do not exist there (those of an order above p, unless p is an integer) are 0.
    pub fn power<S: Scalar>(x: S, exponent: S::Real) -> S {
        let (zero, one) = (S::Real::ZERO, S::Real::integer(1));
        let base = x.real();
        let mut series = [zero; MAX_ORDER + 1];
        let mut binomial = one;
        let mut left = exponent; // the exponent of the k-th derivative
        for (k, coefficient) in series.iter_mut().enumerate().take(S::ORDER + 1) {
            *coefficient = if is_zero(binomial) || (is_zero(base) && is_less(left, zero)) {
                zero
            } else if is_zero(left) {
                binomial
            } else {
                binomial * base.power(left)
            };
            binomial = binomial * left / S::Real::integer(k as i32 + 1);
            left = left - one;
        }
        x.lift(&series)
    }
}

#[inline(always)]
fn is_less<R: Real>(x: R, y: R) -> bool {
    R::holds(x.less(y))
}

#[inline(always)]
fn is_zero<R: Real>(x: R) -> bool {
    !is_less(x, R::ZERO) && !is_less(R::ZERO, x)
}
