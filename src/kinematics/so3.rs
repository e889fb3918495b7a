//! Rotations: exp and log of SO(3), the log continued over turns, Cardan and Euler angles.
//!
//! All are regular at zero rotation, through half a turn and at exact right angles, for every order of derivative, because
//! derivatives are lifted from real Taylor coefficients ([`crate::scalar`]).
//!
//! Errors are in units u = 2⁻⁵³ of the conditioned scale: value / first / second derivative, as `verify/numbers/numerics.rs` asserts
//! them. They hold on doubles with any type that carries up to two orders. Third and fourth derivatives have bounds along motions alone
//! (`verify/numbers/numerics/chain.rs`). 237 bits are what the others are measured by, and have no bound here.
//! What states no figure is sums and products of its arguments, or is made of what states one. On lanes they are larger for these:
//!
//! - continued logs, 5 / 6 / 12 u;
//! - Cardan angles one by one, 1 / 5 / 3 u; Euler angles, 2 / 5 / 3 u.
//!
//! ```
//! use num_dual::Dual64;
//! use pintle_kinematics::so3;
//! // At zero rotation the derivative of the rotation vector with respect to the rotation is the identity:
//! let spin = [Dual64::new(0.0, 1.0), Dual64::new(0.0, 2.0), Dual64::new(0.0, 3.0)];
//! let phi = so3::log(&so3::matrix(so3::exp_quaternion(spin)));
//! assert_eq!(phi.map(|p| p.eps), [1.0, 2.0, 3.0]);
//! ```

use crate::scalar::elementary::{
    atan2, atan2_opposite, direction, elevation, norm, norm_and_direction, recip,
};
use crate::scalar::{MAX_ORDER, Real, Scalar, Series, each, inlined_for_doubles, unrolled};
use crate::vector;
use crate::vector::{Matrix, Vector, dot, dot_real, scale, times};

/// A quaternion (w, x, y, z), scalar part first.
pub type Quaternion<S> = [S; 4];

inlined_for_doubles! {
    /// The unit quaternion (cos |φ|/2, sin(|φ|/2) φ/|φ|) of the rotation vector φ in radians, 4 / 4 / 5 u up to 10⁶ rad.
    ///
    /// Theory Guide 1.3.1: exp(φ^) is the rotation by |φ| about φ.
    pub fn exp_quaternion<S: Scalar>(phi: Vector<S>) -> Quaternion<S> {
        let square = dot(phi, phi);
        let (w, k) = S::Real::exp_series(square.real(), S::ORDER);
        let [x, y, z] = times(phi, square.lift(&k));
        [square.lift(&w), x, y, z]
    }
}

inlined_for_doubles! {
    /// The rotation matrix of a unit quaternion, in the quadratic form 2(xy − wz) …, which has no 1 − cos.
    ///
    /// On the diagonal 1 − 2(y² + z²) = 2(w² + x²) − 1, whichever has the smaller squares and so the smaller errors.
    pub fn matrix<S: Scalar>(q: Quaternion<S>) -> Matrix<S> {
        let [w, x, y, z] = q;
        let two = S::Real::integer(2);
        let (w2, x2, y2, z2) = (w.scale(two), x.scale(two), y.scale(two), z.scale(two));
        let (ww, xx, yy, zz) = (w * w2, x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        [
            [diagonal(ww, xx, [yy, zz]), xy - wz, xz + wy],
            [xy + wz, diagonal(ww, yy, [xx, zz]), yz - wx],
            [xz - wy, yz + wx, diagonal(ww, zz, [xx, yy])],
        ]
    }
}

/// The rotation matrix exp(φ^) of the rotation vector φ in radians.
#[inline(always)]
pub fn exp<S: Scalar>(phi: Vector<S>) -> Matrix<S> {
    matrix(exp_quaternion(phi))
}

/// exp(ε^) R₀ of a constant rotation matrix R₀ and a variation ε, which is zero and carries derivatives. Those of what follows are by rotations of
/// R₀ about the fixed axes, as rows of nodes are.
///
/// ```
/// use num_dual::DualSVec64;
/// use pintle_kinematics::scalar::Seeded;
/// use pintle_kinematics::so3;
/// let r = so3::exp([0.3, -0.2, 0.5]);
/// let varied = so3::vary([0, 1, 2].map(|i| DualSVec64::<3>::seed(0.0, i)), &r);
/// // ∂φ/∂ε is the inverse left Jacobian of φ.
/// let row = so3::log(&varied)[0].gradient();
/// let expected = so3::inverse_left_jacobian([0.3, -0.2, 0.5])[0];
/// assert!(row.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-15));
/// ```
pub fn vary<S: Scalar>(variation: Vector<S>, r: &Matrix<S::Real>) -> Matrix<S> {
    vector::product(&exp(variation), &r.map(|row| row.map(S::from_real)))
}

/// J_l(φ) of the rotation vector φ in radians: δθ = J_l δφ, with exp((φ + δφ)^) = exp(δθ^) exp(φ^) to first order.
///
/// J_l = 1 + (1 − cos|φ|)/|φ|² φ^ + (|φ| − sin|φ|)/|φ|³ φ^². It is formed of the factor k(|φ|²) = sin(|φ|/2)/|φ| of [`exp_quaternion`] and its
/// derivative: nothing cancels near φ = 0. Of numbers with up to three orders of derivatives; 8 u of the largest entry on doubles, where |φ| ≤ 10.
/// Spatial: rows by the total rotation vector are rows by δθ times J_l.
///
/// ```
/// use pintle_kinematics::so3;
/// let (jacobian, inverse) = (so3::left_jacobian([0.3, -0.2, 0.5]), so3::inverse_left_jacobian([0.3, -0.2, 0.5]));
/// let product = pintle_kinematics::vector::product(&jacobian, &inverse);
/// assert!((product[0][0] - 1.0).abs() < 1e-15 && product[0][1].abs() < 1e-15);
/// ```
pub fn left_jacobian<S: Scalar>(phi: Vector<S>) -> Matrix<S> {
    let square = dot(phi, phi);
    let (k, _) = half_sine(square);
    let (_, slope) = half_sine(square.scale(S::Real::integer(4)));
    let odd = (k * k).scale(S::Real::integer(2));
    quadratic(phi, odd, odd + slope.scale(S::Real::integer(16)))
}

/// J_l(φ)⁻¹ = 1 − φ^/2 + (1/|φ|² − cot(|φ|/2)/(2|φ|)) φ^²: δφ = J_l⁻¹ δθ, as [`left_jacobian`]; 10 u for |φ| ≤ 3.
///
/// At whole turns |φ| = 2πk, k ≠ 0, it does not exist, and beside them it grows without bound.
pub fn inverse_left_jacobian<S: Scalar>(phi: Vector<S>) -> Matrix<S> {
    let (k, slope) = half_sine(dot(phi, phi));
    let even = crate::scalar::elementary::ratio(slope.scale(S::Real::integer(-2)), k);
    quadratic(phi, S::from_real(S::Real::ratio(-1, 2)), even)
}

/// k(s) = sin(√s/2)/√s and its derivative.
fn half_sine<S: Scalar>(square: S) -> (S, S) {
    const { assert!(S::ORDER < MAX_ORDER, "the derivative of k has one order less") }
    let (_, k) = S::Real::exp_series(square.real(), S::ORDER + 1);
    let mut slope = [S::Real::ZERO; MAX_ORDER + 1];
    for n in 0..=S::ORDER {
        slope[n] = k[n + 1] * S::Real::integer(n as i32 + 1);
    }
    (square.lift(&k), square.lift(&slope))
}

/// 1 + odd φ^ + even φ^².
fn quadratic<S: Scalar>(phi: Vector<S>, odd: S, even: S) -> Matrix<S> {
    let [x, y, z] = phi;
    let [u, v, w] = times(phi, odd);
    let diagonal = |p: S, q: S| S::one() - even * (p * p + q * q);
    let (xy, xz, yz) = (even * x * y, even * x * z, even * y * z);
    [[diagonal(y, z), xy - w, xz + v], [xy + w, diagonal(x, z), yz - u], [xz - v, yz + u, diagonal(x, y)]]
}

/// 1 − 2(y² + z²) = 2(w² + x²) − 1 of [`matrix`], from 2w², 2x² (`along`), 2y², 2z² (`across`).
#[inline(always)]
fn diagonal<S: Scalar>(ww: S, along: S, across: [S; 2]) -> S {
    let small = (ww.real() + along.real()).less(S::Real::integer(1));
    S::Real::more_exact(small, || ww + along - S::one(), || S::one() - (across[0] + across[1]))
}

inlined_for_doubles! {
    /// The quaternion product p q: the rotation q followed by the rotation p.
    pub fn compose<S: Scalar>(p: Quaternion<S>, q: Quaternion<S>) -> Quaternion<S> {
        [
            p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
            p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
            p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
            p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
        ]
    }
}

/// The inverse of a unit quaternion.
#[inline(always)]
pub fn conjugate<S: Scalar>([w, x, y, z]: Quaternion<S>) -> Quaternion<S> {
    [w, -x, -y, -z]
}

/// q / |q|, of any length between 1e−300 and 1e300; zero where q = 0, which is no rotation.
#[inline(always)]
pub fn normalize<S: Scalar>(q: Quaternion<S>) -> Quaternion<S> {
    direction(q)
}

/// The unit quaternion, w ≥ 0, of the rotation nearest to a rotation matrix with rounding errors.
///
/// It is the dominant eigenvector of a symmetric matrix M, linear in R, that is q qᵀ for an exact rotation. The real part q₀ is
/// the column with the largest diagonal entry, refined by one multiplication; with derivatives q = M q₀/(q·q₀),
/// (q·q₀)² = q₀·M q₀. Taken through the real formulas derivatives would be sums of large terms that cancel.
#[inline(always)]
pub fn quaternion<S: Scalar>(r: &Matrix<S>) -> Quaternion<S> {
    quaternion_along(r, None)
}

/// As [`quaternion`], of R = exp(σ^) R₀ where the nilpotent spin σ is known: derivatives then come from exp(σ^) instead of R.
#[inline(always)]
pub fn quaternion_along<S: Scalar>(r: &Matrix<S>, spin: Option<Vector<S>>) -> Quaternion<S> {
    let q0 = real_unit_quaternion(r);
    varied(r, q0, spin)
}

inlined_for_doubles! {
    /// The quaternion of R from that of its real part, by the spin where it is known.
    fn varied<S: Scalar>(r: &Matrix<S>, q0: Quaternion<S::Real>, spin: Option<Vector<S>>) -> Quaternion<S> {
        match spin {
            Some(spin) => turned(q0, spin),
            None => derived(r, q0),
        }
    }
}

/// exp(σ^) q₀ for a nilpotent σ: (1 − σ·σ/8 + …, ½σ (1 − σ·σ/24 + …)) q₀.
#[inline(always)]
fn turned<S: Scalar>(q0: Quaternion<S::Real>, spin: Vector<S>) -> Quaternion<S> {
    if const { S::ORDER == 0 } {
        return constant(q0);
    }
    let half = S::Real::ratio(1, 2);
    let [w, x, y, z] = [q0[0] * half, q0[1] * half, q0[2] * half, q0[3] * half];
    let mut q = [
        dot_real([-x, -y, -z], spin),
        dot_real([w, z, -y], spin),
        dot_real([-z, w, x], spin),
        dot_real([y, -x, w], spin),
    ];
    if const { S::ORDER == 1 } {
        unrolled!(i < 4, {
            q[i] = q[i].with_real(q0[i]);
        });
        return q;
    }
    let square = spin[0].nilpotent_product(spin[0])
        + spin[1].nilpotent_product(spin[1])
        + spin[2].nilpotent_product(spin[2]);
    let mut cosine = square.scale(S::Real::ratio(-1, 8)); // cos(|σ|/2) − 1
    let sine = square.scale(S::Real::ratio(-1, 24)); // sin(|σ|/2)/(|σ|/2) − 1, to the third order of the whole
    if const { S::ORDER > 3 } {
        cosine = cosine + (square * square).scale(S::Real::ratio(1, 384));
    }
    unrolled!(i < 4, {
        let whole = if const { S::ORDER > 2 } { q[i] + q[i] * sine } else { q[i] };
        q[i] = cosine.scale_add(q0[i], whole).with_real(q0[i]);
    });
    q
}

/// The quaternion of R, from that of its real part.
#[inline(always)]
fn derived<S: Scalar>(r: &Matrix<S>, q0: Quaternion<S::Real>) -> Quaternion<S> {
    if const { S::ORDER == 0 } {
        return constant(q0);
    }
    let mut change_of_r = *r;
    each!(S, i < 3, {
        each!(S, j < 3, {
            change_of_r[i][j] = r[i][j].nilpotent();
        })
    });
    let e = eigen_matrix(S::zero(), &change_of_r);
    let quarter = S::Real::ratio(1, 4);
    let quarter = [q0[0] * quarter, q0[1] * quarter, q0[2] * quarter, q0[3] * quarter];
    let mut change = [S::zero(); 4];
    let mut rest = S::zero(); // (q·q₀)² − 1
    for i in 0..4 {
        change[i] = e[i][0].scale(quarter[0])
            + e[i][1].scale(quarter[1])
            + e[i][2].scale(quarter[2])
            + e[i][3].scale(quarter[3]);
        rest = rest + change[i].scale(q0[i]);
    }
    // Its first order is rounding error, its second |δ|²/4.
    let mut inverse_rest = rest.scale(S::Real::ratio(-1, 2));
    if const { S::ORDER > 3 } {
        inverse_rest = inverse_rest + (rest * rest).scale(S::Real::ratio(3, 8));
    }
    stretched(q0, change, inverse_rest)
}

/// (q₀ + e)(1 + c) where c begins with the second order but for rounding.
#[inline(always)]
fn stretched<S: Scalar>(q0: Quaternion<S::Real>, e: Quaternion<S>, c: S) -> Quaternion<S> {
    let mut q = e;
    for i in 0..4 {
        let sum = S::from_real(q0[i]) + e[i] + c.scale(q0[i]);
        q[i] = if const { S::ORDER > 2 } { sum + e[i] * c } else { sum };
    }
    q
}

/// 4 M by rows, (1 + tr R, a), (a, R + Rᵀ + (1 − tr R) I) with a = (R₃₂ − R₂₃, …). Its 1 is `one`: 1 for a rotation, and
/// 0 for a change of one.
#[inline(always)]
fn eigen_matrix<S: Scalar>(one: S, r: &Matrix<S>) -> [Quaternion<S>; 4] {
    let [x, y, z] = twice_axial(r);
    let (xy, xz, yz) = (r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]);
    [
        [one + r[0][0] + r[1][1] + r[2][2], x, y, z],
        [x, one + r[0][0] - r[1][1] - r[2][2], xy, xz],
        [y, xy, one + r[1][1] - r[0][0] - r[2][2], yz],
        [z, xz, yz, one + r[2][2] - r[0][0] - r[1][1]],
    ]
}

/// The constant q.
#[inline(always)]
fn constant<S: Scalar>(q: Quaternion<S::Real>) -> Quaternion<S> {
    [S::from_real(q[0]), S::from_real(q[1]), S::from_real(q[2]), S::from_real(q[3])]
}

/// The real part of R.
#[inline(always)]
fn real_matrix<S: Scalar>(r: &Matrix<S>) -> Matrix<S::Real> {
    [vector::real(r[0]), vector::real(r[1]), vector::real(r[2])]
}

/// The unit quaternion, w ≥ 0, of the real part of R.
#[inline(always)]
fn real_unit_quaternion<S: Scalar>(r: &Matrix<S>) -> Quaternion<S::Real> {
    let q = S::Real::quaternion_of(&real_matrix(r));
    // On lanes it has w ≥ 0 already.
    if const { S::Real::HAS_LANES } { q } else { upper_half(q) }
}

/// The real part of q.
#[inline(always)]
fn real_quaternion<S: Scalar>(q: Quaternion<S>) -> Quaternion<S::Real> {
    [q[0].real(), q[1].real(), q[2].real(), q[3].real()]
}

/// (R₃₂ − R₂₃, R₁₃ − R₃₁, R₂₁ − R₁₂) = 2 sin|φ| φ/|φ|.
#[inline(always)]
fn twice_axial<S: Scalar>(r: &Matrix<S>) -> Vector<S> {
    [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
}

/// The dominant eigenvector of M ([`eigen_matrix`]), w ≥ 0.
#[inline(always)]
pub(crate) fn dominant_eigenvector<R: Real>(r: &Matrix<R>) -> Quaternion<R> {
    let m = eigen_matrix(R::integer(1), r);
    let first = larger((m[0][0], m[0]), (m[1][1], m[1]));
    let second = larger((m[2][2], m[2]), (m[3][3], m[3]));
    let start = larger(first, second).1;
    let mut q = start;
    each!(R, i < 4, {
        let first = m[i][1].multiply_add(start[1], m[i][0] * start[0]);
        q[i] = m[i][3].multiply_add(start[3], m[i][2].multiply_add(start[2], first));
    });
    let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    // Adding zero makes +0 of −0, whose sign is none.
    let inverse = (R::integer(1) / square.square_root()).with_sign_of(q[0] + R::ZERO);
    [q[0] * inverse, q[1] * inverse, q[2] * inverse, q[3] * inverse]
}

/// What stands with the larger key.
#[inline(always)]
fn larger<R: Real>(a: (R, Quaternion<R>), b: (R, Quaternion<R>)) -> (R, Quaternion<R>) {
    R::either(a.0.less(b.0), b, a)
}

/// ±q with w ≥ 0.
#[inline(always)]
fn upper_half<S: Scalar>(q: Quaternion<S>) -> Quaternion<S> {
    S::Real::either(q[0].real().less(S::Real::ZERO), [-q[0], -q[1], -q[2], -q[3]], q)
}

inlined_for_doubles! {
    /// ±q/|q|, w ≥ 0, of a quaternion that is a unit but for rounding: what a product of several left of its norm does not enter the
    /// log.
    fn on_sphere<S: Scalar>(q: Quaternion<S>) -> Quaternion<S> {
        let q0 = real_quaternion(q);
        let square = q0[0] * q0[0] + q0[1] * q0[1] + q0[2] * q0[2] + q0[3] * q0[3];
        let inverse = square.square_root().reciprocal_or_zero();
        let p0 = [q0[0] * inverse, q0[1] * inverse, q0[2] * inverse, q0[3] * inverse];
        if const { S::ORDER == 0 } {
            return upper_half(constant(p0));
        }
        // The derivatives of |q|² are rounding errors: the first term of 1/√(1 + …) is enough.
        let p = [q[0].scale(inverse), q[1].scale(inverse), q[2].scale(inverse), q[3].scale(inverse)];
        let small = [p[0].nilpotent(), p[1].nilpotent(), p[2].nilpotent(), p[3].nilpotent()];
        let rest = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]).nilpotent();
        upper_half(stretched(p0, small, rest.scale(S::Real::ratio(-1, 2))))
    }
}

/// The principal rotation vector φ, |φ| ≤ π, of a unit quaternion (either sign), 4 / 5 / 6 u.
///
/// φ = K(w) v with K(c) = 2 acos(c)/√(1 − c²), a univariate lift: regular at zero rotation and through half a turn.
#[inline(always)]
pub fn log_quaternion<S: Scalar>(q: Quaternion<S>) -> Vector<S> {
    principal(on_sphere(q))
}

inlined_for_doubles! {
    /// K(w) v of a unit quaternion with w ≥ 0.
    fn principal<S: Scalar>(q: Quaternion<S>) -> Vector<S> {
        let [w, x, y, z] = q;
        times([x, y, z], w.lift(&S::Real::log_series(w.real(), S::ORDER)))
    }
}

/// The principal rotation vector φ, |φ| ≤ π, of a rotation matrix: R = exp(φ^), 4 / 5 / 6 u.
///
/// Below a right angle φ = ¼ K((tr R − 1)/2) (R₃₂ − R₂₃, …); beyond, by way of the quaternion.
#[inline(always)]
pub fn log<S: Scalar>(r: &Matrix<S>) -> Vector<S> {
    log_along(r, None)
}

inlined_for_doubles! {
    /// As [`log`], of R = exp(σ^) R₀ where the nilpotent spin σ is known, or on lanes: by way of the quaternion everywhere.
    pub fn log_along<S: Scalar>(r: &Matrix<S>, spin: Option<Vector<S>>) -> Vector<S> {
        if spin.is_some() || S::Real::HAS_LANES {
            return principal(quaternion_along(r, spin));
        }
        let trace = r[0][0] + r[1][1] + r[2][2];
        let one = S::Real::integer(1);
        S::Real::more_exact(
            one.less(trace.real()),
            || {
                let cosine = (trace - S::one()).scale(S::Real::ratio(1, 2));
                let k = cosine.lift(&S::Real::log_series(cosine.real(), S::ORDER));
                times(twice_axial(r), k.scale(S::Real::ratio(1, 4)))
            },
            || principal(quaternion(r)),
        )
    }
}

/// Half the width, as |sin(|φ|/2)|, of the zone around whole turns in which the sheet of the log is kept.
const ZONE: (i32, i32) = (1, 20);

/// The smallest |reference| for which there is a sheet to keep: just beyond half a turn.
const SHEET: (i32, i32) = (16, 5);

/// Whether a rotation vector that continues others is so near a whole turn, other than none, that its sheet is theirs.
pub(crate) fn keeps_sheet(phi: Vector<f64>) -> bool {
    let part = |(over, under): (i32, i32)| f64::from(over) / f64::from(under);
    let length = norm(phi);
    length > part(SHEET) && (length / 2.0).sin().abs() < part(ZONE)
}

/// The rotation vector continued over turns, chosen near a reference, 4 / 6 / 12 u.
#[derive(Clone, Copy, Debug)]
pub struct ContinuousLog<S: Scalar> {
    /// φ with exp(φ^) = R, in radians.
    pub phi: Vector<S>,
    /// |sin(|φ|/2)|: the distance to the nearest whole turn, where for φ ≠ 0 the derivatives across φ grow like
    /// (|φ|/2)/|sin(|φ|/2)| and do not exist at 0.
    pub lateral: S::Real,
}

/// The rotation vector φ of R on the sheet that continues `reference`, the last well-conditioned φ of the history.
///
/// With the principal φ_p = θ_p d, |d| = 1: φ = (θ_p + 2πk) d.
///
/// *Turn rule.* The set |φ| = 2πk, k ≠ 0, is a single rotation, the identity. The exact continuation of a path that misses it
/// by any distance swings around it and never counts a turn. Continuation therefore means counting turns at the resolution of
/// the history. Away from whole turns k makes φ nearest to the reference. Where |sin(|φ|/2)| < 0.05 and the reference is
/// beyond half a turn, k stays on the turn of the reference: k = ±round(|reference|/2π). The caller keeps a reference taken
/// outside that zone ([`ContinuousLog::is_reference`]).
///
/// At R = I exactly with k ≠ 0 the axis is the reference's, and derivatives are taken along it only (those across do not
/// exist; `lateral` is 0).
pub fn continuous_log<S: Scalar>(r: &Matrix<S>, reference: Vector<S::Real>) -> ContinuousLog<S> {
    continuous_log_along(r, None, reference)
}

/// As [`continuous_log`], of R = exp(σ^) R₀ where the nilpotent spin σ is known.
#[inline(always)]
pub fn continuous_log_along<S: Scalar>(
    r: &Matrix<S>,
    spin: Option<Vector<S>>,
    reference: Vector<S::Real>,
) -> ContinuousLog<S> {
    let q0 = real_unit_quaternion(r);
    let q = varied(r, q0, spin);
    continued(q, reference)
}

/// The principal log, and whether it is that of [`continuous_log`] too ([`nearness`] is positive).
#[inline(always)]
pub(crate) fn principal_log_along<S: Scalar>(
    r: &Matrix<S>,
    spin: Option<Vector<S>>,
    reference: Vector<S::Real>,
) -> (Vector<S>, S::Real) {
    let q0 = real_unit_quaternion(r);
    let q = varied(r, q0, spin);
    (principal(q), nearness(q0, reference))
}

/// As [`continuous_log`], from a unit quaternion.
pub fn continuous_log_quaternion<S: Scalar>(
    q: Quaternion<S>,
    reference: Vector<S::Real>,
) -> ContinuousLog<S> {
    continued(on_sphere(q), reference)
}

/// How clearly the log of a unit quaternion with w ≥ 0 that continues `reference` is the principal one.
///
/// Mostly the reference is within half a turn of zero and not on the other side, which is enough: with v·reference ≥ −w |v|²,
/// (unit·reference) ≥ −w > −(π − θ_p). It is positive there, and as near to a tie as that goes to the principal log.
#[inline(always)]
fn nearness<R: Real>([w, x, y, z]: Quaternion<R>, reference: Vector<R>) -> R {
    let v = [x, y, z];
    let near = R::pi() * R::pi() - dot(reference, reference);
    near.lesser(w.multiply_add(dot(v, v), dot(v, reference))) + tie()
}

/// By how much of a turn halves go towards zero: half a turn from a reference at zero is principal.
#[inline(always)]
fn tie<R: Real>() -> R {
    R::ratio(1, i32::MAX)
}

inlined_for_doubles! {
    /// The log of a unit quaternion with w ≥ 0 on its sheet.
    fn continued<S: Scalar>(q: Quaternion<S>, reference: Vector<S::Real>) -> ContinuousLog<S> {
        let q0 = real_quaternion(q);
        // With derivatives, lanes come here where that failed.
        let knows_better = S::Real::HAS_LANES && S::ORDER > 0;
        if !knows_better && S::Real::shortcut_where_positive(|| nearness(q0, reference)) {
            let v = [q0[1], q0[2], q0[3]];
            return ContinuousLog { phi: principal(q), lateral: dot(v, v).square_root() };
        }
        beyond_half_a_turn(q, reference)
    }
}

/// As [`continued`], wherever the reference is.
#[inline(always)]
fn beyond_half_a_turn<S: Scalar>(q: Quaternion<S>, reference: Vector<S::Real>) -> ContinuousLog<S> {
    let zero = S::Real::ZERO;
    let half_turn = S::Real::pi();
    let turn = half_turn + half_turn;
    let q0 = real_quaternion(q);
    let v = [q0[1], q0[2], q0[3]];
    let (unit, lateral) = S::Real::direction_and_norm(v);
    let (reference_direction, length) = S::Real::direction_and_norm(reference);
    let along = dot(unit, reference);
    let half = lateral.arctangent(q0[0]);
    let angle = half + half;
    let [k] = S::Real::joined(|| {
        let nearest = || {
            let (turns, little) = ((along - angle) / turn, tie());
            S::Real::choose(zero.less(turns), || turns - little, || turns + little).nearest_integer()
        };
        [S::Real::choose(
            S::Real::ratio(SHEET.0, SHEET.1).less(length),
            || {
                let own = (length / turn).nearest_integer();
                S::Real::choose(
                    lateral.less(S::Real::ratio(ZONE.0, ZONE.1)),
                    || S::Real::choose(along.less(zero), || -own, || own),
                    nearest,
                )
            },
            nearest,
        )]
    });
    let on_principal_sheet = principal(q);
    let whole = S::Real::with_turns(zero, k);
    if const { S::Real::HAS_LANES } {
        // One series for all, with no turns on the principal sheet.
        let one = S::Real::integer(1);
        let is_principal = k.magnitude().less(S::Real::ratio(1, 2));
        let sine = S::Real::either(zero.less(lateral), lateral, one);
        let series = shifted_series(q0[0], sine, whole, S::ORDER);
        // Both without a closure, which the compiler would leave a function of its own, for the baseline processor.
        let mut beyond = times([q[1], q[2], q[3]], q[0].lift(&series));
        // Of the value alone: K s is the principal angle, to which 2πk is added without the rounding of 2π.
        let of_principal = S::Real::log_series(q0[0], 0)[0];
        let shifted = S::Real::with_turns(of_principal * sine, k) / sine;
        let factor = S::Real::either(is_principal, of_principal, shifted);
        for i in 0..3 {
            beyond[i] = beyond[i].with_real(v[i] * factor);
        }
        let beside = beside_whole_turns(reference_direction, whole, on_principal_sheet);
        let is_beyond = zero.less(lateral + S::Real::either(is_principal, one, zero));
        let phi = S::Real::either(is_beyond, beyond, beside);
        return ContinuousLog { phi, lateral };
    }
    if S::Real::shortcut(|| k.magnitude().less(S::Real::ratio(1, 2))) {
        return ContinuousLog { phi: on_principal_sheet, lateral };
    }
    let off_identity = || {
        let [w, x, y, z] = q;
        let phi = S::Real::more_exact(
            q0[0].less(S::Real::ratio(1, 2)),
            || times([x, y, z], w.lift(&turned_series(w.real(), k, S::ORDER))),
            || vector::add(on_principal_sheet, scale(direction([x, y, z]), whole)),
        );
        // The value on its own, (θ_p + 2πk) v/|v|, takes the fewest roundings.
        let factor = S::Real::with_turns(angle, k) / lateral;
        [phi[0].with_real(v[0] * factor), phi[1].with_real(v[1] * factor), phi[2].with_real(v[2] * factor)]
    };
    let phi = S::joined(|| {
        let turned = || {
            S::Real::choose(zero.less(lateral), off_identity, || {
                beside_whole_turns(reference_direction, whole, on_principal_sheet)
            })
        };
        S::Real::choose(zero.less(k.magnitude()), turned, || on_principal_sheet)
    });
    ContinuousLog { phi, lateral }
}

/// The log at whole turns but for rounding: along the reference, with what is left of the principal one.
#[inline(always)]
fn beside_whole_turns<S: Scalar>(
    reference_direction: Vector<S::Real>,
    whole: S::Real,
    on_principal_sheet: Vector<S>,
) -> Vector<S> {
    let angle = S::from_real(whole) + dot_real(reference_direction, on_principal_sheet);
    times(vector::constant(reference_direction), angle)
}

/// The Taylor coefficients of K_k(c) = (2 acos c + 2πk)/√(1 − c²) at 0 ≤ c < 1: on the sheet k, φ = K_k(w) v.
///
/// (1 − c²) K′ = c K − 2 holds on every sheet. Beyond 120° from a whole turn this is better than the sum of two vectors.
#[inline(always)]
fn turned_series<R: Real>(c: R, k: R, order: usize) -> Series<R> {
    let one = R::integer(1);
    let rest = (one - c) * (one + c);
    let sine = rest.square_root();
    let half_angle = sine.arctangent(c);
    let mut series = [R::ZERO; MAX_ORDER + 1];
    series[0] = R::with_turns(half_angle + half_angle, k) / sine;
    if order > 0 {
        series[1] = (c * series[0] - R::integer(2)) / rest;
    }
    for n in 1..order {
        let m = n as i32;
        let sum = R::integer(2 * m + 1) * c * series[n] + R::integer(m) * series[n - 1];
        series[n + 1] = sum / (R::integer(m + 1) * rest);
    }
    series
}

/// The same as the sum of the principal series and 2πk/s with s = √(1 − c²) known by itself: for which (1 − c²) G′ = c G.
#[inline(always)]
fn shifted_series<R: Real>(c: R, sine: R, whole: R, order: usize) -> Series<R> {
    let mut series = R::log_series(c, order);
    let inverse = R::integer(1) / sine;
    let square = inverse * inverse;
    let (mut before, mut shift) = (R::ZERO, whole / sine);
    series[0] = series[0] + shift;
    for n in 0..order {
        let m = n as i32;
        let sum = R::integer(2 * m + 1) * c * shift + R::integer(m) * before;
        (before, shift) = (shift, sum * square * R::ratio(1, m + 1));
        series[n + 1] = series[n + 1] + shift;
    }
    series
}

impl<S: Scalar> ContinuousLog<S> {
    /// Whether φ may become the reference of what follows: it lies outside the zone around whole turns, or within half a
    /// turn of zero, where the log is regular.
    pub fn is_reference(&self) -> <S::Real as Real>::Mask {
        let (_, length) = S::Real::direction_and_norm(vector::real(self.phi));
        let distance = S::Real::choose(length.less(S::Real::pi()), || S::Real::integer(1), || self.lateral);
        S::Real::ratio(ZONE.0, ZONE.1).less(distance)
    }
}

/// Cardan angles (α, β, γ) of `R = Rx(α) Ry(β) Rz(γ)`, α and γ in (−π, π], β in [−π/2, π/2]. Errors are 1 / 2 / 3 u where the
/// entries of R are exact, to within 1e−16 of the lock β = ±π/2.
///
/// Manual, connection type CARDAN: α = −tan⁻¹(R₂₃/R₃₃), β = sin⁻¹ R₁₃, γ = −tan⁻¹(R₁₂/R₁₁). Here each is an arctangent of two arguments.
/// `0 − x` keeps +0 from becoming −0, so that half a turn is +π.
#[inline(always)]
pub fn cardan<S: Scalar>(r: &Matrix<S>) -> [S; 3] {
    [cardan_first(r), cardan_second(r), cardan_third(r)]
}

/// α of [`cardan`], the angle of REVOLUTE: positive counter-clockwise about e1a, from e2a to e2b.
#[inline(always)]
pub fn cardan_first<S: Scalar>(r: &Matrix<S>) -> S {
    atan2_opposite(r[1][2], r[2][2])
}

/// β of [`cardan`].
#[inline(always)]
pub fn cardan_second<S: Scalar>(r: &Matrix<S>) -> S {
    elevation(r[0][2], [r[1][2], r[2][2]])
}

/// γ of [`cardan`].
#[inline(always)]
pub fn cardan_third<S: Scalar>(r: &Matrix<S>) -> S {
    atan2_opposite(r[0][1], r[0][0])
}

/// Euler angles (α, β, γ) of `R = Rz(α) Rx(β) Rz(γ)` with the sign s = ±1 of sin β. Errors are 1 / 2 / 3 u where the entries of R
/// are exact, to within 1e−16 of the lock sin β = 0.
///
/// Manual, connection type EULER, with β = s acos R₃₃ and α, γ turning by π together with s. `0 + x` keeps −0 from becoming
/// half a turn of the other sign.
#[inline(always)]
pub fn euler<S: Scalar>(r: &Matrix<S>, s: S::Real) -> [S; 3] {
    [euler_angle(r, s, 1), euler_angle(r, s, 2), euler_angle(r, s, 3)]
}

inlined_for_doubles! {
    /// The angle α (1), β (2) or γ (3) of [`euler`].
    pub fn euler_angle<S: Scalar>(r: &Matrix<S>, s: S::Real, which: usize) -> S {
        match which {
            1 => atan2(signed(s, r[0][2]), signed(s, -r[1][2])),
            2 => atan2(norm([r[0][2], r[1][2]]), r[2][2]).scale(s),
            _ => atan2(signed(s, r[2][0]), signed(s, r[2][1])),
        }
    }
}

/// s x, with +0 for −0.
#[inline(always)]
fn signed<S: Scalar>(s: S::Real, x: S) -> S {
    S::zero() + x.scale(s)
}

/// α in [0, π], the angle between the third directions: the flexion of FLEXION-TORSION. A kink at 0 and π.
#[inline(always)]
pub fn flexion<S: Scalar>(r: &Matrix<S>) -> S {
    atan2(norm([r[0][2], r[1][2]]), r[2][2])
}

/// θ in (−π, π], the direction of the axis of flexion q = cos θ e1a + sin θ e2a. It does not exist without
/// flexion.
#[inline(always)]
pub fn sweep<S: Scalar>(r: &Matrix<S>) -> S {
    atan2(r[0][2], S::zero() - r[1][2])
}

/// β in (−π, π], the torsion about the third directions: with R = Rz(φ) Ry(α) Rz(ψ), β = φ + ψ.
///
/// 2 atan(z/w) of the quaternion, which is −tan⁻¹((R₁₂ − R₂₁)/(R₁₁ + R₂₂)) of connection type FLEXION-TORSION, and is regular up
/// to α = π.
#[inline(always)]
pub fn torsion<S: Scalar>(r: &Matrix<S>) -> S {
    torsion_along(r, None)
}

/// As [`torsion`], of R = exp(σ^) R₀ where the nilpotent spin σ is known.
#[inline(always)]
pub fn torsion_along<S: Scalar>(r: &Matrix<S>, spin: Option<Vector<S>>) -> S {
    let [w, _, _, z] = half_torsion(r, spin);
    atan2(z, w).scale(S::Real::integer(2))
}

inlined_for_doubles! {
    /// The quaternion `(cos α/2 cos β/2, −sin α/2 sin χ, sin α/2 cos χ, cos α/2 sin β/2)` of `R = Rz(φ) Ry(α) Rz(ψ)`, with χ = (φ −
    /// ψ)/2, of the sign that has β/2 in (−π/2, π/2].
    fn half_torsion<S: Scalar>(r: &Matrix<S>, spin: Option<Vector<S>>) -> Quaternion<S> {
        let q = quaternion_along(r, spin);
        if S::Real::shortcut_where_positive(|| q[0].real() - S::Real::from_f64(f64::MIN_POSITIVE)) {
            return q;
        }
        beside_half_a_turn(q)
    }
}

/// That of q and −q, w ≥ 0, which [`half_torsion`] gives. Lanes come here where a w may be zero: a function of its own keeps the rest of
/// theirs in vectors.
#[cold]
#[inline(never)]
fn beside_half_a_turn<S: Scalar>(q: Quaternion<S>) -> Quaternion<S> {
    let zero = S::Real::ZERO;
    S::joined(|| {
        let opposite = [S::zero() - q[0], S::zero() - q[1], S::zero() - q[2], S::zero() - q[3]];
        let known = S::Real::choose(zero.less(q[0].real()), || S::Real::integer(1), || q[3].real());
        S::Real::either(known.less(zero), opposite, q)
    })
}

/// The sign that e1, e2 midway between a and b take after whole `turns` of β, whose half they follow: −1 after an odd number.
#[inline(always)]
fn sign_after<R: Real>(turns: R) -> R {
    let half = turns * R::ratio(1, 2);
    let odd = (half - half.nearest_integer()).magnitude(); // ½ for an odd number, else 0
    R::integer(1) - R::integer(4) * odd
}

inlined_for_doubles! {
    /// α_1 and α_2, the flexion α about q resolved in the directions e1, e2 midway between a and b; β has made `turns` turns.
    ///
    /// (α_1, α_2) = K (x, y), with the quaternion (w, x, y, z) and K(c) = 2 acos(c)/√(1 − c²) at c = cos α/2 = |(w, z)|.
    /// Regular without flexion, singular at α = π.
    pub fn component_flexions<S: Scalar>(r: &Matrix<S>, spin: Option<Vector<S>>, turns: S::Real) -> [S; 2] {
        let [w, x, y, z] = half_torsion(r, spin);
        let cosine = norm([w, z]);
        let k = cosine.lift(&S::Real::log_series(cosine.real(), S::ORDER)).scale(sign_after(turns));
        [x * k, y * k]
    }
}

inlined_for_doubles! {
    /// The directions e1, e2, e3 midway between a and b as columns, components along e_i^a: Rz(φ) Ry(α/2) Rz((ψ − φ)/2).
    ///
    /// e3 = (e3a + e3b)/|e3a + e3b|; e1, e2 lie at half the torsion β, of which `turns` are whole. Symmetric in a and b; singular at
    /// α = π (connection type PROJECTION FLEXION-TORSION).
    ///
    /// With the quaternion (w, x, y, z), c = |(w, z)| = cos α/2 and (ξ, η) = (x w − y z, y w + x z)/c = sin α/2 (q·e1a, q·e2a):
    ///
    /// ```text
    ///       ⎡ w + ξx/(1 + c)   ξy/(1 + c) − z    η ⎤
    /// ±     ⎢ z + ηx/(1 + c)   w + ηy/(1 + c)   −ξ ⎥   (the sign of whole turns for e1 and e2 alone)
    ///       ⎣       −y                x          c ⎦
    /// ```
    ///
    /// Derivatives of order 1/c come from the direction (w, z)/c alone, so that what stays finite up to α = π keeps its digits.
    pub fn mid_frame<S: Scalar>(r: &Matrix<S>, spin: Option<Vector<S>>, turns: S::Real) -> Matrix<S> {
        let [w, x, y, z] = half_torsion(r, spin);
        let (cosine, [along, across]) = norm_and_direction([w, z]);
        let (xi, eta) = (x * along - y * across, y * along + x * across);
        let shrink = recip(S::one() + cosine);
        let (x_shrunk, y_shrunk) = (x * shrink, y * shrink);
        let sign = sign_after(turns);
        [
            [(w + xi * x_shrunk).scale(sign), (xi * y_shrunk - z).scale(sign), eta],
            [(z + eta * x_shrunk).scale(sign), (w + eta * y_shrunk).scale(sign), S::zero() - xi],
            [(S::zero() - y).scale(sign), x.scale(sign), cosine],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both series of K_k(c) = (2 acos c + 2πk)/√(1 − c²), the one whose sheet is in its first coefficient and the sum.
    #[test]
    fn two_series_of_a_turned_log_agree() {
        let order = MAX_ORDER.min(4);
        for k in [-3.0, -1.0, 0.0, 1.0, 2.0] {
            for c in [0.0_f64, 0.1, 0.45, 0.7, 0.93] {
                let sine = ((1.0 - c) * (1.0 + c)).sqrt();
                let turned = turned_series(c, k, order);
                let shifted = shifted_series(c, sine, k * std::f64::consts::TAU, order);
                let principal = f64::log_series(c, order);
                for n in 0..=order {
                    // Two terms that may cancel are summed.
                    let size = turned[n].abs().max(principal[n].abs()) / sine.powi(2 * n as i32);
                    let error = (turned[n] - shifted[n]).abs();
                    assert!(error <= 1e-14 * size, "k = {k}, c = {c}, {n}: {} {}", turned[n], shifted[n]);
                }
            }
        }
    }
}
