//! Values by hand, without rows: one element at a time, plain doubles, the functions of the standard library.

use super::scalar::{Matrix, column, dot, quaternion, relative, relative_to, separation};
use pintle_kinematics::node::Pair;

/// e_i^a·d of SLIDE-PLANE.
#[inline(always)]
pub(crate) fn slide_plane(pair: &Pair<f64>, out: &mut [f64; 3]) {
    let d = separation(pair);
    for i in 0..3 {
        out[i] = dot(column(&pair.a.triad, i), d);
    }
}

/// α = atan2(−e2a·e3b, e3a·e3b), e1a·e3b and e1a·e2b of REVOLUTE.
#[inline(always)]
pub(crate) fn revolute(pair: &Pair<f64>, out: &mut [f64; 3]) {
    let (a, b) = (&pair.a.triad, &pair.b.triad);
    let (a1, b3) = (column(a, 0), column(b, 2));
    out[0] = f64::atan2(-dot(column(a, 1), b3), dot(column(a, 2), b3));
    out[1] = dot(a1, b3);
    out[2] = dot(a1, column(b, 1));
}

/// The angles of CARDAN.
#[inline(always)]
pub(crate) fn cardan(pair: &Pair<f64>, out: &mut [f64; 3]) {
    let (a, b) = (&pair.a.triad, &pair.b.triad);
    let (a1, b3) = (column(a, 0), column(b, 2));
    let (y, x) = (-dot(column(a, 1), b3), dot(column(a, 2), b3));
    out[0] = y.atan2(x);
    out[1] = dot(a1, b3).atan2((x * x + y * y).sqrt());
    out[2] = f64::atan2(-dot(a1, column(b, 1)), dot(a1, column(b, 0)));
}

/// φ_i of ROTATION.
#[inline(always)]
pub(crate) fn rotation(pair: &Pair<f64>, out: &mut [f64; 3]) {
    log(&relative(pair), out);
}

/// u1, u2, u3 of TRANSLATOR, and the rotation vector of Q Q₀ᵀ.
#[inline(always)]
pub(crate) fn translator(pair: &Pair<f64>, frozen: &Matrix, out: &mut [f64; 6]) {
    let [positions, angles] = out.as_chunks_mut::<3>().0 else { return };
    slide_plane(pair, positions);
    log(&relative_to(pair, frozen), angles);
}

/// The rotation vector of R, principal: 2 atan2(|v|, w)/|v| v of the quaternion (w, v).
#[inline(always)]
fn log(r: &Matrix, out: &mut [f64; 3]) {
    let [w, x, y, z] = quaternion(r);
    let sine = (x * x + y * y + z * z).sqrt();
    // The least rotation whose sine is known to rounding.
    let k = if sine < 1e-150 { 2.0 } else { 2.0 * sine.atan2(w) / sine };
    *out = [k * x, k * y, k * z];
}
