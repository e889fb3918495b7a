//! Rows by hand, one element at a time: plain doubles, the functions of the standard library.
//!
//! Nothing of it is left to the inliner's mood: loops, and no closures over arrays.

use super::coefficients::LOG_1;
use pintle_kinematics::node::Pair;

/// A value and its derivatives by x_a, θ_a, x_b, θ_b.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Row {
    pub(crate) value: f64,
    pub(crate) columns: [f64; 12],
}

pub(super) type Three = [f64; 3];
pub(super) type Matrix = [Three; 3];

#[inline(always)]
pub(super) fn column(m: &Matrix, j: usize) -> Three {
    [m[0][j], m[1][j], m[2][j]]
}

#[inline(always)]
pub(super) fn dot(a: Three, b: Three) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: Three, b: Three) -> Three {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a x + b y.
#[inline(always)]
fn combined(a: Three, x: f64, b: Three, y: f64) -> Three {
    [a[0] * x + b[0] * y, a[1] * x + b[1] * y, a[2] * x + b[2] * y]
}

#[inline(always)]
pub(super) fn separation(pair: &Pair<f64>) -> Three {
    let (a, b) = (&pair.a.displacement, &pair.b.displacement);
    let at = |i: usize| pair.reference[i] + (b[i] - a[i]);
    [at(0), at(1), at(2)]
}

/// A row that depends on d alone: −g, g × D, g, 0.
#[inline(always)]
fn translation(value: f64, g: Three, separation: Three) -> Row {
    let arm = cross(g, separation);
    let columns = [-g[0], -g[1], -g[2], arm[0], arm[1], arm[2], g[0], g[1], g[2], 0.0, 0.0, 0.0];
    Row { value, columns }
}

/// A row that depends on Q alone: 0, −h, 0, h.
#[inline(always)]
fn rotation_row(value: f64, h: Three) -> Row {
    let columns = [0.0, 0.0, 0.0, -h[0], -h[1], -h[2], 0.0, 0.0, 0.0, h[0], h[1], h[2]];
    Row { value, columns }
}

/// e_i^a·d of SLIDE-PLANE.
pub(crate) fn slide_plane(pair: &Pair<f64>, out: &mut [Row; 3]) {
    let d = separation(pair);
    for i in 0..3 {
        let e = column(&pair.a.triad, i);
        out[i] = translation(dot(e, d), e, d);
    }
}

/// α = atan2(−e2a·e3b, e3a·e3b), e1a·e3b and e1a·e2b of REVOLUTE: ∂α/∂ρ = −e3b × (x e2a + y e3a)/(x² + y²).
pub(crate) fn revolute(pair: &Pair<f64>, out: &mut [Row; 3]) {
    let (a, b) = (&pair.a.triad, &pair.b.triad);
    let (a1, a2, a3, b2, b3) = (column(a, 0), column(a, 1), column(a, 2), column(b, 1), column(b, 2));
    out[0] = angle_across(a2, a3, b3);
    out[1] = rotation_row(dot(a1, b3), cross(b3, a1));
    out[2] = rotation_row(dot(a1, b2), cross(b2, a1));
}

/// atan2(−e2a·e3b, e3a·e3b).
#[inline(always)]
fn angle_across(a2: Three, a3: Three, b3: Three) -> Row {
    let (y, x) = (-dot(a2, b3), dot(a3, b3));
    let inverse = 1.0 / (x * x + y * y);
    rotation_row(y.atan2(x), cross(combined(a2, x * inverse, a3, y * inverse), b3))
}

/// The angles of CARDAN.
pub(crate) fn cardan(pair: &Pair<f64>, out: &mut [Row; 3]) {
    let (a, b) = (&pair.a.triad, &pair.b.triad);
    let (a1, a2, a3) = (column(a, 0), column(a, 1), column(a, 2));
    let (b1, b2, b3) = (column(b, 0), column(b, 1), column(b, 2));
    let (y, x) = (-dot(a2, b3), dot(a3, b3));
    let across = x * x + y * y;
    let inverse = 1.0 / across;
    out[0] = rotation_row(y.atan2(x), cross(combined(a2, x * inverse, a3, y * inverse), b3));
    let (sine, norm) = (dot(a1, b3), across.sqrt());
    // b3 is a unit vector.
    let over = sine * norm * inverse;
    let along = combined(a2, y * over, a3, -(x * over));
    let lever = combined(a1, norm, along, 1.0);
    out[1] = rotation_row(sine.atan2(norm), cross(b3, lever));
    let (y, x) = (-dot(a1, b2), dot(a1, b1));
    let inverse = 1.0 / (x * x + y * y);
    out[2] = rotation_row(y.atan2(x), cross(a1, combined(b2, x * inverse, b1, y * inverse)));
}

/// Q = AᵀB.
#[inline(always)]
pub(super) fn relative(pair: &Pair<f64>) -> Matrix {
    let (a, b) = (&pair.a.triad, &pair.b.triad);
    let mut q = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            q[i][j] = dot(column(a, i), column(b, j));
        }
    }
    q
}

/// R = Q Q₀ᵀ.
#[inline(always)]
pub(super) fn relative_to(pair: &Pair<f64>, frozen: &Matrix) -> Matrix {
    let q = relative(pair);
    let mut r = q;
    for i in 0..3 {
        for j in 0..3 {
            r[i][j] = dot(q[i], frozen[j]);
        }
    }
    r
}

/// φ_i of ROTATION.
pub(crate) fn rotation(pair: &Pair<f64>, out: &mut [Row; 3]) {
    log(&pair.a.triad, &relative(pair), out);
}

/// u1, u2, u3 of TRANSLATOR, and the rotation vector of Q Q₀ᵀ.
pub(crate) fn translator(pair: &Pair<f64>, frozen: &Matrix, out: &mut [Row; 6]) {
    let [positions, angles] = out.as_chunks_mut::<3>().0 else { return };
    slide_plane(pair, positions);
    log(&pair.a.triad, &relative_to(pair, frozen), angles);
}

/// The rotation vector of R, principal, whose variation is a spin along the directions of a: with the quaternion (w, v), φ = K(w) v
/// and ∂φ/∂ρ = ½ K (w I − v^) − ½ K′ v vᵀ.
#[inline(always)]
fn log(a: &Matrix, r: &Matrix, out: &mut [Row; 3]) {
    let [w, x, y, z] = quaternion(r);
    let square = x * x + y * y + z * z;
    let (k, slope) = if w > 0.5 {
        let c = 0.5 * (1.0 - w);
        let mut slope = 0.0;
        for term in LOG_1.into_iter().rev() {
            slope = slope * c + term;
        }
        let sine = square.sqrt();
        // The least rotation whose sine is known to rounding.
        (if sine < 1e-150 { 2.0 } else { 2.0 * sine.atan2(w) / sine }, slope)
    } else {
        let sine = square.sqrt();
        let k = 2.0 * sine.atan2(w) / sine;
        (k, (w * k - 2.0) / square)
    };
    let v = [x, y, z];
    let (half_k, half_slope) = (0.5 * k, 0.5 * slope);
    let kw = half_k * w;
    let (ku, su) = ([half_k * x, half_k * y, half_k * z], [half_slope * x, half_slope * y, half_slope * z]);
    let spin = [[kw, ku[2], -ku[1]], [-ku[2], kw, ku[0]], [ku[1], -ku[0], kw]];
    for i in 0..3 {
        let s = [spin[i][0] - su[i] * x, spin[i][1] - su[i] * y, spin[i][2] - su[i] * z];
        out[i] = rotation_row(k * v[i], [dot(s, a[0]), dot(s, a[1]), dot(s, a[2])]);
    }
}

/// The unit quaternion, w ≥ 0, of a rotation: the column of 4 q qᵀ with the largest diagonal entry, over its root (Shepperd).
#[inline(always)]
pub(super) fn quaternion(r: &Matrix) -> [f64; 4] {
    let (a, b, c) = (r[0][0], r[1][1], r[2][2]);
    let (x, y, z) = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]);
    let (xy, xz, yz) = (r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]);
    let trace = a + b + c;
    let (column, largest) = if trace >= a && trace >= b && trace >= c {
        ([1.0 + trace, x, y, z], 1.0 + trace)
    } else if a >= b && a >= c {
        let largest = 1.0 + a - b - c;
        ([x, largest, xy, xz], largest)
    } else if b >= c {
        let largest = 1.0 + b - a - c;
        ([y, xy, largest, yz], largest)
    } else {
        let largest = 1.0 + c - a - b;
        ([z, xz, yz, largest], largest)
    };
    let scale = (0.5 / largest.sqrt()).copysign(column[0]);
    [column[0] * scale, column[1] * scale, column[2] * scale, column[3] * scale]
}
