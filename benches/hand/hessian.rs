//! Rows with second derivatives by hand, four elements at a time: the 3 × 3 matrix of second derivatives by the relative
//! translation or rotation, and the blocks that it becomes.

use super::simd::{
    QuaternionLog, RelativeTurn, combined, put_rotation, put_translation, scaled, separation, turn_of,
    turn_of_frozen,
};
use super::vector::{Three, Vec4, column, cross, dot};
use pintle_kinematics::batch::{Four, HessianRow, Section, Tile};
use pulp::x86::V3;

type Block = [Three; 3];

/// Where the degrees of freedom of each node begin in a row.
const XA: usize = 0;
const THETA_A: usize = 3;
const XB: usize = 6;
const THETA_B: usize = 9;

/// Writes a block and, apart from the diagonal, its transpose.
#[inline(always)]
fn write(to: &mut [[Four; 12]; 12], at: (usize, usize), block: &Block) {
    for i in 0..3 {
        for j in 0..3 {
            block[i][j].store(&mut to[at.0 + i][at.1 + j]);
            if at.0 != at.1 {
                block[i][j].store(&mut to[at.1 + j][at.0 + i]);
            }
        }
    }
}

#[inline(always)]
fn zeros(v: V3, to: &mut [[Four; 12]; 12], at: &[(usize, usize)]) {
    let zero = [[Vec4::splat(v, 0.0); 3]; 3];
    for at in at {
        write(to, *at, &zero);
    }
}

#[inline(always)]
fn negated(b: &Block) -> Block {
    [[-b[0][0], -b[0][1], -b[0][2]], [-b[1][0], -b[1][1], -b[1][2]], [-b[2][0], -b[2][1], -b[2][2]]]
}

/// (a bᵀ + b aᵀ)/2.
#[inline(always)]
fn symmetric(v: V3, a: Three, b: Three) -> Block {
    let half = scaled(a, Vec4::splat(v, 0.5));
    let mut block = [[half[0]; 3]; 3];
    for i in 0..3 {
        block[i][i] = a[i] * b[i];
        for j in 0..i {
            block[i][j] = half[i].fma(b[j], half[j] * b[i]);
            block[j][i] = block[i][j];
        }
    }
    block
}

/// A row linear in d along g: its second derivatives are those of the map alone.
#[inline(always)]
fn put_linear(v: V3, out: &mut HessianRow, value: Vec4, g: Three, separation: Three) {
    put_translation(v, &mut out.row, value, g, separation);
    let to = &mut out.hessian;
    zeros(
        v,
        to,
        &[(XA, XA), (XB, XB), (XA, XB), (XA, THETA_B), (XB, THETA_B), (THETA_A, THETA_B), (THETA_B, THETA_B)],
    );
    let zero = Vec4::splat(v, 0.0);
    let spin = [[zero, g[2], -g[1]], [-g[2], zero, g[0]], [g[1], -g[0], zero]];
    write(to, (XB, THETA_A), &spin);
    write(to, (XA, THETA_A), &negated(&spin));
    let mut centripetal = symmetric(v, g, separation);
    for i in 0..3 {
        centripetal[i][i] = centripetal[i][i] - value;
    }
    write(to, (THETA_A, THETA_A), &centripetal);
}

/// A row that depends on Q alone, with gradient h and second derivatives by ρ.
#[inline(always)]
fn put_turning(v: V3, out: &mut HessianRow, value: Vec4, h: Three, second: &Block) {
    put_rotation(v, &mut out.row, value, h);
    let to = &mut out.hessian;
    zeros(v, to, &[(XA, XA), (XB, XB), (XA, XB), (XA, THETA_A), (XB, THETA_A), (XA, THETA_B), (XB, THETA_B)]);
    write(to, (THETA_A, THETA_A), second);
    write(to, (THETA_B, THETA_B), second);
    let k = scaled(h, Vec4::splat(v, 0.5));
    let mixed = [
        [-second[0][0], k[2] - second[0][1], -k[1] - second[0][2]],
        [-k[2] - second[1][0], -second[1][1], k[0] - second[1][2]],
        [k[1] - second[2][0], -k[0] - second[2][1], -second[2][2]],
    ];
    write(to, (THETA_B, THETA_A), &mixed);
}

/// e_i^a·d of SLIDE-PLANE.
#[inline(always)]
pub(crate) fn slide_plane(v: V3, tile: &Tile, out: &mut [HessianRow]) {
    let d = separation(v, tile);
    for (i, row) in out.iter_mut().enumerate().take(3) {
        let e = column(v, &tile.triad[0], i);
        put_linear(v, row, dot(e, d), e, d);
    }
}

/// a·b of a direction of each node: ½(a bᵀ + b aᵀ) − (a·b) I.
#[inline(always)]
fn put_cosine(v: V3, out: &mut HessianRow, a: Three, b: Three) {
    let value = dot(a, b);
    let mut second = symmetric(v, a, b);
    for i in 0..3 {
        second[i][i] = second[i][i] - value;
    }
    put_turning(v, out, value, cross(b, a), &second);
}

/// The angle of (x, y), where y = m·f and x = n·f but for the factors that make (x, y) a unit: with `tangent` = (x m − y n)/r² and
/// `radial` = (y m + x n)/r², the second derivatives are those of f·tangent less 2 sym(L Rᵀ).
#[inline(always)]
fn put_angle(v: V3, out: &mut HessianRow, value: Vec4, [tangent, fixed]: [Three; 2], [l, r]: [Three; 2]) {
    let mut second = symmetric(v, tangent, fixed);
    let twice = scaled(l, Vec4::splat(v, -2.0));
    let across = symmetric(v, twice, r);
    for i in 0..3 {
        for j in 0..3 {
            second[i][j] = second[i][j] + across[i][j];
        }
    }
    put_turning(v, out, value, l, &second);
}

/// The angle and the two cosines of REVOLUTE.
#[inline(always)]
pub(crate) fn revolute(v: V3, tile: &Tile, out: &mut [HessianRow]) {
    let (a1, a2, a3) =
        (column(v, &tile.triad[0], 0), column(v, &tile.triad[0], 1), column(v, &tile.triad[0], 2));
    let (b2, b3) = (column(v, &tile.triad[1], 1), column(v, &tile.triad[1], 2));
    put_first_angle(v, &mut out[0], [a2, a3, b3]);
    put_cosine(v, &mut out[1], a1, b3);
    put_cosine(v, &mut out[2], a1, b2);
}

/// atan2(−a2·b3, a3·b3), and 1/(x² + y²).
#[inline(always)]
fn put_first_angle(v: V3, out: &mut HessianRow, [a2, a3, b3]: [Three; 3]) -> Vec4 {
    let (y, x) = (-dot(a2, b3), dot(a3, b3));
    let across = x.fma(x, y * y);
    let inverse = Vec4::splat(v, 1.0) / across;
    let (c, s) = (x * inverse, y * inverse);
    let tangent = combined(a2, -c, a3, -s);
    let radial = combined(a2, -s, a3, c);
    put_angle(v, out, super::simd::atan2(v, y, x), [tangent, b3], [cross(b3, tangent), cross(b3, radial)]);
    across
}

/// The angles of CARDAN.
#[inline(always)]
pub(crate) fn cardan(v: V3, tile: &Tile, out: &mut [HessianRow]) {
    let (a1, a2, a3) =
        (column(v, &tile.triad[0], 0), column(v, &tile.triad[0], 1), column(v, &tile.triad[0], 2));
    let (b1, b2, b3) =
        (column(v, &tile.triad[1], 0), column(v, &tile.triad[1], 1), column(v, &tile.triad[1], 2));
    let one = Vec4::splat(v, 1.0);
    let across = put_first_angle(v, &mut out[0], [a2, a3, b3]);
    // cos β δβ = δ(e1a·e3b).
    let (sine, norm) = (dot(a1, b3), across.sqrt());
    let inverse = one / norm;
    let slope = scaled(cross(b3, a1), inverse);
    let mut second = symmetric(v, scaled(a1, inverse), b3);
    let tangent = sine * inverse;
    let along = scaled(slope, tangent);
    for i in 0..3 {
        second[i][i] = second[i][i] - tangent;
        for j in 0..3 {
            second[i][j] = along[i].fma(slope[j], second[i][j]);
        }
    }
    put_turning(v, &mut out[1], super::simd::atan2(v, sine, norm), slope, &second);
    let (y, x) = (-dot(a1, b2), dot(a1, b1));
    let inverse = one / x.fma(x, y * y);
    let (c, s) = (x * inverse, y * inverse);
    let tangent = combined(b2, -c, b1, -s);
    let radial = combined(b2, -s, b1, c);
    let slopes = [cross(tangent, a1), cross(radial, a1)];
    put_angle(v, &mut out[2], super::simd::atan2(v, y, x), [tangent, a1], slopes);
}

/// φ_i of ROTATION.
#[inline(always)]
pub(crate) fn rotation(v: V3, tile: &Tile, out: &mut [HessianRow]) {
    put_log(v, &turn_of(v, tile), out);
}

/// u1, u2, u3 and the misalignments of TRANSLATOR.
#[inline(always)]
pub(crate) fn translator(v: V3, tile: &Tile, section: &Section, out: &mut [HessianRow]) {
    slide_plane(v, tile, &mut out[..3]);
    put_log(v, &turn_of_frozen(v, tile, section), &mut out[3..]);
}

/// φ = K(w) v with v′_i = p_i = ½(w e_i + u × e_i), u = Σ v_j e_j, w′ = −½ u: φ_i″ = v_i (¼ K″ u uᵀ − ¼ (K′ w + K) I) − K′ sym(u p_iᵀ).
#[inline(always)]
fn put_log(v: V3, turn: &RelativeTurn, out: &mut [HessianRow]) {
    let QuaternionLog { w, v: q, k, slope, curve } = turn.log(v);
    let a = turn.directions;
    let (half, quarter) = (Vec4::splat(v, 0.5), Vec4::splat(v, 0.25));
    let u = [
        q[0].fma(a[0][0], q[1].fma(a[1][0], q[2] * a[2][0])),
        q[0].fma(a[0][1], q[1].fma(a[1][1], q[2] * a[2][1])),
        q[0].fma(a[0][2], q[1].fma(a[1][2], q[2] * a[2][2])),
    ];
    let mut shared = symmetric(v, scaled(u, curve * quarter), u);
    let level = slope.fma(w, k) * quarter;
    for i in 0..3 {
        shared[i][i] = shared[i][i] - level;
    }
    for i in 0..3 {
        let p = scaled(combined(a[i], w, cross(u, a[i]), Vec4::splat(v, 1.0)), half);
        let h = combined(p, k, u, -(slope * half * q[i]));
        let mut second = symmetric(v, scaled(u, -slope), p);
        for j in 0..3 {
            for m in 0..3 {
                second[j][m] = shared[j][m].fma(q[i], second[j][m]);
            }
        }
        put_turning(v, &mut out[i], k * q[i], h, &second);
    }
}
