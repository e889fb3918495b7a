//! Rotations: exp and log of SO(3), the log continued over turns, Cardan and Euler angles.
//!
//! All are regular at zero rotation, through half a turn and at exact right angles, for every order of derivative, because
//! derivatives are lifted from real Taylor coefficients ([`crate::scalar`]). Errors are in units u = 2⁻⁵³ of the conditioned
//! scale, value / first / second derivative, as `verify/numerics.rs` asserts them.
//!
//! ```
//! use num_dual::Dual64;
//! use pintle::so3;
//! // At zero rotation the derivative of the rotation vector with respect to the rotation is the identity:
//! let spin = [Dual64::new(0.0, 1.0), Dual64::new(0.0, 2.0), Dual64::new(0.0, 3.0)];
//! let phi = so3::log(&so3::matrix(so3::exp(spin)));
//! assert_eq!(phi.map(|p| p.eps), [1.0, 2.0, 3.0]);
//! ```

use crate::scalar::elementary::{atan2, direction, inverse_sqrt, norm, sqrt};
use crate::scalar::{Real, Scalar};
use crate::vector::{self, Matrix, Vector, dot, dot_real, scale, times};

/// A quaternion (w, x, y, z), scalar part first.
pub type Quaternion<S> = [S; 4];

/// The unit quaternion (cos |φ|/2, sin(|φ|/2) φ/|φ|) of the rotation vector φ in radians, 4 / 4 / 5 u up to 10⁶ rad.
///
/// Theory Guide 1.3.1: exp(φ^) is the rotation by |φ| about φ.
#[inline(always)]
pub fn exp<S: Scalar>(phi: Vector<S>) -> Quaternion<S> {
    let square = dot(phi, phi);
    let (w, k) = S::Real::exp_series(square.real(), S::ORDER);
    let [x, y, z] = times(phi, square.lift(&k));
    [square.lift(&w), x, y, z]
}

/// The rotation matrix of a unit quaternion, in the quadratic form 1 − 2(y² + z²), 2(xy − wz) …, which has no 1 − cos.
#[inline(always)]
pub fn matrix<S: Scalar>([w, x, y, z]: Quaternion<S>) -> Matrix<S> {
    let two = S::Real::integer(2);
    let (x2, y2, z2) = (x.scale(two), y.scale(two), z.scale(two));
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    let one = S::one();
    [
        [one - (yy + zz), xy - wz, xz + wy],
        [xy + wz, one - (xx + zz), yz - wx],
        [xz - wy, yz + wx, one - (xx + yy)],
    ]
}

/// The quaternion product p q: the rotation q followed by the rotation p.
#[inline(always)]
pub fn compose<S: Scalar>(p: Quaternion<S>, q: Quaternion<S>) -> Quaternion<S> {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
        p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
    ]
}

/// The inverse of a unit quaternion.
#[inline(always)]
pub fn conjugate<S: Scalar>([w, x, y, z]: Quaternion<S>) -> Quaternion<S> {
    [w, -x, -y, -z]
}

/// q / |q|; q ≠ 0.
#[inline(always)]
pub fn normalize<S: Scalar>(q: Quaternion<S>) -> Quaternion<S> {
    let inverse = inverse_sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    [q[0] * inverse, q[1] * inverse, q[2] * inverse, q[3] * inverse]
}

/// The unit quaternion of a rotation matrix, w ≥ 0, from the largest of 1 + tr R and 1 + 2 R_ii − tr R.
#[inline(always)]
pub fn quaternion<S: Scalar>(r: &Matrix<S>) -> Quaternion<S> {
    let trace = r[0][0] + r[1][1] + r[2][2];
    S::Real::choose(
        S::Real::integer(0).less(trace.real()),
        || {
            let half = S::Real::ratio(1, 2);
            let [x, y, z] = times(twice_axial(r), inverse_sqrt(S::one() + trace).scale(half));
            [sqrt(S::one() + trace).scale(half), x, y, z]
        },
        || beyond_right_angle(r),
    )
}

/// (R₃₂ − R₂₃, R₁₃ − R₃₁, R₂₁ − R₁₂) = 2 sin|φ| φ/|φ|.
#[inline(always)]
fn twice_axial<S: Scalar>(r: &Matrix<S>) -> Vector<S> {
    [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
}

/// The quaternion, w ≥ 0, of a rotation by more than about a right angle, from its largest diagonal entry.
#[inline(always)]
fn beyond_right_angle<S: Scalar>(r: &Matrix<S>) -> Quaternion<S> {
    let d = [r[0][0].real(), r[1][1].real(), r[2][2].real()];
    let q = S::Real::choose(
        d[0].less(d[1]),
        || S::Real::choose(d[1].less(d[2]), || from_pivot::<S, 2>(r), || from_pivot::<S, 1>(r)),
        || S::Real::choose(d[0].less(d[2]), || from_pivot::<S, 2>(r), || from_pivot::<S, 0>(r)),
    );
    upper_half(q)
}

/// (w, v) from the diagonal entry I: 4 v_I² = 1 + R_II − R_JJ − R_KK, I, J, K cyclic.
#[inline(always)]
fn from_pivot<S: Scalar, const I: usize>(r: &Matrix<S>) -> Quaternion<S> {
    let (j, k) = ((I + 1) % 3, (I + 2) % 3);
    let pivot = S::one() + r[I][I] - r[j][j] - r[k][k];
    let half = S::Real::ratio(1, 2);
    let f = inverse_sqrt(pivot).scale(half);
    let mut q = [S::zero(); 4];
    q[0] = (r[k][j] - r[j][k]) * f;
    q[1 + I] = sqrt(pivot).scale(half);
    q[1 + j] = (r[I][j] + r[j][I]) * f;
    q[1 + k] = (r[I][k] + r[k][I]) * f;
    q
}

/// ±q with w ≥ 0.
#[inline(always)]
fn upper_half<S: Scalar>(q: Quaternion<S>) -> Quaternion<S> {
    S::Real::choose(q[0].real().less(S::Real::integer(0)), || [-q[0], -q[1], -q[2], -q[3]], || q)
}

/// The principal rotation vector φ, |φ| ≤ π, of a unit quaternion (either sign), 4 / 5 / 6 u.
///
/// φ = K(w) v with K(c) = 2 acos(c)/√(1 − c²), a univariate lift: regular at zero rotation and through half a turn.
#[inline(always)]
pub fn log_quaternion<S: Scalar>(q: Quaternion<S>) -> Vector<S> {
    let [w, x, y, z] = upper_half(q);
    times([x, y, z], w.lift(&S::Real::log_series(w.real(), S::ORDER)))
}

/// The principal rotation vector φ, |φ| ≤ π, of a rotation matrix: R = exp(φ^), 4 / 5 / 6 u.
///
/// Below a right angle φ = ¼ K((tr R − 1)/2) (R₃₂ − R₂₃, …); beyond, by way of the quaternion.
#[inline(always)]
pub fn log<S: Scalar>(r: &Matrix<S>) -> Vector<S> {
    let trace = r[0][0] + r[1][1] + r[2][2];
    let one = S::Real::integer(1);
    S::Real::choose(
        one.less(trace.real()),
        || {
            let cosine = (trace - S::one()).scale(S::Real::ratio(1, 2));
            let k = cosine.lift(&S::Real::log_series(cosine.real(), S::ORDER));
            times(twice_axial(r), k.scale(S::Real::ratio(1, 4)))
        },
        || {
            let [w, x, y, z] = beyond_right_angle(r);
            times([x, y, z], w.lift(&S::Real::log_series(w.real(), S::ORDER)))
        },
    )
}

/// Half the width, as |sin(|φ|/2)|, of the zone around whole turns in which the sheet of the log is kept.
const ZONE: (i32, i32) = (1, 20);

/// The smallest |reference| for which there is a sheet to keep: just beyond half a turn.
const SHEET: (i32, i32) = (16, 5);

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
/// *Turn rule.* The set |φ| = 2πk, k ≠ 0, is a single rotation, the identity: the exact continuation of a path that misses it
/// by any distance swings around it and never counts a turn. Continuation therefore means counting turns at the resolution
/// of the history. Away from whole turns k makes φ nearest to the reference; where |sin(|φ|/2)| < 0.05 and the reference
/// is beyond half a turn, k stays on the reference's own turn, k = ±round(|reference|/2π). The caller keeps a reference
/// taken outside that zone ([`ContinuousLog::is_reference`]).
///
/// At R = I exactly with k ≠ 0 the axis is the reference's, and derivatives are taken along it only (those across do not
/// exist; `lateral` is 0).
pub fn continuous_log<S: Scalar>(r: &Matrix<S>, reference: Vector<S::Real>) -> ContinuousLog<S> {
    continue_from_quaternion(quaternion(r), log(r), reference)
}

/// As [`continuous_log`], from a unit quaternion.
pub fn continuous_log_quaternion<S: Scalar>(
    q: Quaternion<S>,
    reference: Vector<S::Real>,
) -> ContinuousLog<S> {
    continue_from_quaternion(upper_half(q), log_quaternion(q), reference)
}

fn continue_from_quaternion<S: Scalar>(
    [w, x, y, z]: Quaternion<S>,
    principal: Vector<S>,
    reference: Vector<S::Real>,
) -> ContinuousLog<S> {
    let zero = S::Real::integer(0);
    let turn = S::Real::pi() + S::Real::pi();
    let v = [x, y, z];
    let (unit, lateral) = S::Real::direction_and_norm(vector::real(v));
    let (reference_direction, length) = S::Real::direction_and_norm(reference);
    let along = dot(unit, reference);
    let k = S::Real::choose(
        S::Real::ratio(SHEET.0, SHEET.1).less(length),
        || {
            let own = (length / turn).nearest_integer();
            S::Real::choose(
                lateral.less(S::Real::ratio(ZONE.0, ZONE.1)),
                || S::Real::choose(along.less(zero), || -own, || own),
                || nearest_turn::<S>(principal, along, turn),
            )
        },
        || nearest_turn::<S>(principal, along, turn),
    );
    let minus_one = S::Real::integer(-1);
    let phi = S::Real::choose(
        zero.less(k.magnitude()),
        || {
            S::Real::choose(
                zero.less(lateral),
                || {
                    // On the sheet k = −1 away from the identity, −K(−w) v needs no sum.
                    S::Real::choose(
                        minus_one.less(k),
                        || along_direction::<S>(v, principal, k),
                        || {
                            S::Real::choose(
                                k.less(minus_one),
                                || along_direction::<S>(v, principal, k),
                                || {
                                    S::Real::choose(
                                        w.real().less(S::Real::ratio(4, 5)),
                                        || {
                                            let opposite = -w;
                                            let series = S::Real::log_series(opposite.real(), S::ORDER);
                                            times(v, -opposite.lift(&series))
                                        },
                                        || along_direction::<S>(v, principal, k),
                                    )
                                },
                            )
                        },
                    )
                },
                || {
                    let axial = dot_real(reference_direction, principal);
                    let angle = S::from_real(S::Real::with_turns(zero, k)) + axial;
                    let axis: Vector<S> = vector::constant(reference_direction);
                    times(axis, angle)
                },
            )
        },
        || principal,
    );
    ContinuousLog { phi, lateral }
}

/// round((d·reference − θ_p)/2π), halves towards zero: a half turn from a reference at zero is principal.
#[inline(always)]
fn nearest_turn<S: Scalar>(principal: Vector<S>, along: S::Real, turn: S::Real) -> S::Real {
    let (_, angle) = S::Real::direction_and_norm(vector::real(principal));
    let turns = (along - angle) / turn;
    (turns - turns * S::Real::ratio(1, i32::MAX)).nearest_integer()
}

/// φ_p + 2πk v/|v|.
#[inline(always)]
fn along_direction<S: Scalar>(v: Vector<S>, principal: Vector<S>, k: S::Real) -> Vector<S> {
    let zero = S::Real::integer(0);
    let d = direction(v);
    let whole = S::Real::with_turns(zero, k);
    let mut phi = vector::add(principal, scale(d, whole));
    // The value alone: θ_p d₀ + 2πk d₀ with one rounding, rather than the sum of two rounded vectors.
    let (_, angle) = S::Real::direction_and_norm(vector::real(principal));
    let total = S::Real::with_turns(angle, k);
    for (component, direction) in phi.iter_mut().zip(d) {
        *component = S::from_real(direction.real() * total) + component.nilpotent();
    }
    phi
}

impl<S: Scalar> ContinuousLog<S> {
    /// Whether φ may become the reference of what follows: it lies outside the zone around whole turns, or within half a
    /// turn of zero, where the log is regular.
    pub fn is_reference(&self) -> <S::Real as Real>::Mask {
        let (_, length) = S::Real::direction_and_norm(vector::real(self.phi));
        // Inside the zone and beyond half a turn the mask is false.
        let zone = S::Real::ratio(ZONE.0, ZONE.1);
        S::Real::choose(
            length.less(S::Real::pi()),
            || zone.less(S::Real::integer(1)),
            || zone.less(self.lateral),
        )
    }
}

/// Cardan angles (α, β, γ) of R = Rx(α) Ry(β) Rz(γ), α and γ in (−π, π], β in [−π/2, π/2]; 1 / 2 / 3 u where the entries of R
/// are exact, to within 1e−16 of the lock β = ±π/2.
///
/// Manual, connection type CARDAN: α = −tan⁻¹(R₂₃/R₃₃), β = sin⁻¹ R₁₃, γ = −tan⁻¹(R₁₂/R₁₁), here each as an arctangent of two
/// arguments. `0 − x` keeps +0 from becoming −0, so that half a turn is +π.
#[inline(always)]
pub fn cardan<S: Scalar>(r: &Matrix<S>) -> [S; 3] {
    [cardan_first(r), cardan_second(r), cardan_third(r)]
}

/// α of [`cardan`], the angle of REVOLUTE: positive counter-clockwise about e1a, from e2a to e2b.
#[inline(always)]
pub fn cardan_first<S: Scalar>(r: &Matrix<S>) -> S {
    atan2(S::zero() - r[1][2], r[2][2])
}

/// β of [`cardan`].
#[inline(always)]
pub fn cardan_second<S: Scalar>(r: &Matrix<S>) -> S {
    atan2(r[0][2], norm([r[1][2], r[2][2]]))
}

/// γ of [`cardan`].
#[inline(always)]
pub fn cardan_third<S: Scalar>(r: &Matrix<S>) -> S {
    atan2(S::zero() - r[0][1], r[0][0])
}

/// Euler angles (α, β, γ) of R = Rz(α) Rx(β) Rz(γ) with the sign s = ±1 of sin β; 1 / 2 / 3 u where the entries of R are exact,
/// to within 1e−16 of the lock sin β = 0.
///
/// Manual, connection type EULER, with β = s acos R₃₃ and α, γ turning by π together with s. `0 + x` keeps −0 from becoming
/// half a turn of the other sign.
#[inline(always)]
pub fn euler<S: Scalar>(r: &Matrix<S>, s: S::Real) -> [S; 3] {
    [euler_angle(r, s, 1), euler_angle(r, s, 2), euler_angle(r, s, 3)]
}

/// The angle α (1), β (2) or γ (3) of [`euler`].
#[inline(always)]
pub fn euler_angle<S: Scalar>(r: &Matrix<S>, s: S::Real, which: usize) -> S {
    let signed = |x: S| S::zero() + x.scale(s);
    match which {
        1 => atan2(signed(r[0][2]), signed(-r[1][2])),
        2 => atan2(norm([r[0][2], r[1][2]]), r[2][2]).scale(s),
        _ => atan2(signed(r[2][0]), signed(r[2][1])),
    }
}
