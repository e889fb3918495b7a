//! Rows by hand, four elements at a time.

use super::coefficients::{ARCTANGENT, LONG_LOG_0, LONG_LOG_1, LONG_LOG_2};
use super::vector::{Three, Vec4, column, cross, dot, load3};
use pintle_kinematics::batch::{Row, Section, Tile};
use pulp::x86::V3;

/// Σ c_i xⁱ as two interleaved polynomials.
#[inline(always)]
fn polynomial<const N: usize>(v: V3, c: &[f64; N], x: Vec4) -> Vec4 {
    let square = x * x;
    part(v, c, 1, square).fma(x, part(v, c, 0, square))
}

/// Every second term, from the first or the second on.
#[inline(always)]
fn part<const N: usize>(v: V3, c: &[f64; N], first: usize, square: Vec4) -> Vec4 {
    let mut i = first + 2 * ((N - 1 - first) / 2);
    let mut sum = Vec4::splat(v, c[i]);
    while i > first {
        i -= 2;
        sum = sum.fma(square, Vec4::splat(v, c[i]));
    }
    sum
}

#[inline(always)]
pub(crate) fn separation(v: V3, tile: &Tile) -> Three {
    let (reference, a, b) =
        (load3(v, &tile.reference), load3(v, &tile.displacement[0]), load3(v, &tile.displacement[1]));
    [reference[0] + (b[0] - a[0]), reference[1] + (b[1] - a[1]), reference[2] + (b[2] - a[2])]
}

/// A row that depends on d alone: −g, g × D, g, 0.
#[inline(always)]
pub(crate) fn put_translation(v: V3, out: &mut Row, value: Vec4, g: Three, separation: Three) {
    let zero = Vec4::splat(v, 0.0);
    let arm = cross(g, separation);
    value.store(&mut out.value);
    for i in 0..3 {
        (-g[i]).store(&mut out.columns[i]);
        arm[i].store(&mut out.columns[3 + i]);
        g[i].store(&mut out.columns[6 + i]);
        zero.store(&mut out.columns[9 + i]);
    }
}

/// A row that depends on Q alone: 0, −h, 0, h.
#[inline(always)]
pub(crate) fn put_rotation(v: V3, out: &mut Row, value: Vec4, h: Three) {
    let zero = Vec4::splat(v, 0.0);
    value.store(&mut out.value);
    for i in 0..3 {
        zero.store(&mut out.columns[i]);
        (-h[i]).store(&mut out.columns[3 + i]);
        zero.store(&mut out.columns[6 + i]);
        h[i].store(&mut out.columns[9 + i]);
    }
}

/// e_i^a·d of SLIDE-PLANE.
#[inline(always)]
pub(crate) fn slide_plane(v: V3, tile: &Tile, out: &mut [Row]) {
    let d = separation(v, tile);
    for (i, row) in out.iter_mut().enumerate().take(3) {
        let e = column(v, &tile.triad[0], i);
        put_translation(v, row, dot(e, d), e, d);
    }
}

/// φ_i of ROTATION, principal: with the quaternion (w, v) of Q, φ = K(w) v and ∂φ/∂ρ = ½ K (w I − v^) − ½ K′ v vᵀ, along e_i^a.
#[inline(always)]
pub(crate) fn rotation(v: V3, tile: &Tile, out: &mut [Row]) {
    put_log(v, &turn_of(v, tile), out);
}

/// A rotation R whose variation is a spin along the directions of a.
pub(crate) struct RelativeTurn {
    pub(crate) directions: [Three; 3],
    r: [[Vec4; 3]; 3],
}

/// Q.
#[inline(always)]
pub(crate) fn turn_of(v: V3, tile: &Tile) -> RelativeTurn {
    let (a1, a2, a3) =
        (column(v, &tile.triad[0], 0), column(v, &tile.triad[0], 1), column(v, &tile.triad[0], 2));
    let (b1, b2, b3) =
        (column(v, &tile.triad[1], 0), column(v, &tile.triad[1], 1), column(v, &tile.triad[1], 2));
    let r = [
        [dot(a1, b1), dot(a1, b2), dot(a1, b3)],
        [dot(a2, b1), dot(a2, b2), dot(a2, b3)],
        [dot(a3, b1), dot(a3, b2), dot(a3, b3)],
    ];
    RelativeTurn { directions: [a1, a2, a3], r }
}

/// Q Q₀ᵀ.
#[inline(always)]
pub(crate) fn turn_of_frozen(v: V3, tile: &Tile, section: &Section) -> RelativeTurn {
    let RelativeTurn { directions, r: q } = turn_of(v, tile);
    let (f1, f2, f3) = (
        load3(v, &section.initial_orientation[0]),
        load3(v, &section.initial_orientation[1]),
        load3(v, &section.initial_orientation[2]),
    );
    let r = [
        [dot(q[0], f1), dot(q[0], f2), dot(q[0], f3)],
        [dot(q[1], f1), dot(q[1], f2), dot(q[1], f3)],
        [dot(q[2], f1), dot(q[2], f2), dot(q[2], f3)],
    ];
    RelativeTurn { directions, r }
}

/// The unit quaternion (w, v), and K, K′, K″ at w.
pub(crate) struct QuaternionLog {
    pub(crate) w: Vec4,
    pub(crate) v: Three,
    pub(crate) k: Vec4,
    pub(crate) slope: Vec4,
    pub(crate) curve: Vec4,
}

impl RelativeTurn {
    #[inline(always)]
    pub(crate) fn log(&self, v: V3) -> QuaternionLog {
        let [w, x, y, z] = quaternion(v, &self.r);
        let c = (Vec4::splat(v, 1.0) - w) * Vec4::splat(v, 0.5);
        let half_curve = polynomial(v, &LONG_LOG_2, c - Vec4::splat(v, 0.25));
        QuaternionLog {
            w,
            v: [x, y, z],
            k: polynomial(v, &LONG_LOG_0, c),
            slope: polynomial(v, &LONG_LOG_1, c),
            curve: half_curve + half_curve,
        }
    }
}

/// The rows of the rotation vector of R, whose variation is a spin along the directions of a.
#[inline(always)]
fn put_log(v: V3, turn: &RelativeTurn, out: &mut [Row]) {
    let [a1, a2, a3] = turn.directions;
    let half = Vec4::splat(v, 0.5);
    let QuaternionLog { w, v: [x, y, z], k, slope, .. } = turn.log(v);
    let (half_k, half_slope) = (k * half, slope * half);
    let kw = half_k * w;
    let u = [x, y, z];
    let ku = [half_k * x, half_k * y, half_k * z];
    let su = [half_slope * x, half_slope * y, half_slope * z];
    let spin = [[kw, ku[2], -ku[1]], [-ku[2], kw, ku[0]], [ku[1], -ku[0], kw]];
    for i in 0..3 {
        let a = spin[i][0] - su[i] * u[0];
        let b = spin[i][1] - su[i] * u[1];
        let c = spin[i][2] - su[i] * u[2];
        let h = [
            a.fma(a1[0], b.fma(a2[0], c * a3[0])),
            a.fma(a1[1], b.fma(a2[1], c * a3[1])),
            a.fma(a1[2], b.fma(a2[2], c * a3[2])),
        ];
        put_rotation(v, &mut out[i], k * u[i], h);
    }
}

/// The unit quaternion, w ≥ 0, of a rotation: the column of 4 q qᵀ with the largest diagonal entry, over its root.
#[inline(always)]
fn quaternion(v: V3, r: &[[Vec4; 3]; 3]) -> [Vec4; 4] {
    let one = Vec4::splat(v, 1.0);
    let (a, b, c) = (r[0][0], r[1][1], r[2][2]);
    let diagonal = [one + a + (b + c), one + a - (b + c), one - a + (b - c), one - a - (b - c)];
    let (x, y, z) = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]);
    let (xy, xz, yz) = (r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]);
    let columns = [
        [diagonal[0], x, y, z],
        [x, diagonal[1], xy, xz],
        [y, xy, diagonal[2], yz],
        [z, xz, yz, diagonal[3]],
    ];
    let (largest, column) = larger(
        larger((diagonal[0], columns[0]), (diagonal[1], columns[1])),
        larger((diagonal[2], columns[2]), (diagonal[3], columns[3])),
    );
    // |column|² = 4 largest; its sign is that of w.
    let scale = (Vec4::splat(v, 0.5) / largest.sqrt()).with_sign_of(column[0]);
    [column[0] * scale, column[1] * scale, column[2] * scale, column[3] * scale]
}

/// What stands with the larger key.
#[inline(always)]
fn larger(i: (Vec4, [Vec4; 4]), j: (Vec4, [Vec4; 4])) -> (Vec4, [Vec4; 4]) {
    let mut picked = i.1;
    for m in 0..4 {
        picked[m] = i.0.pick_less(j.0, j.1[m], i.1[m]);
    }
    (i.0.max(j.0), picked)
}

/// Half of π and a quarter, each in two parts; the first of the quarter is exact eight times over.
const QUARTER: f64 = f64::from_bits(std::f64::consts::FRAC_PI_4.to_bits() & !7);
const QUARTER_REST: f64 = 3.061_616_997_868_383e-17 + (std::f64::consts::FRAC_PI_4 - QUARTER);

/// The angle of the point (x, y).
#[inline(always)]
pub(crate) fn atan2(v: V3, y: Vec4, x: Vec4) -> Vec4 {
    let (zero, one, two) = (Vec4::splat(v, 0.0), Vec4::splat(v, 1.0), Vec4::splat(v, 2.0));
    let (across, along) = (y.abs(), x.abs());
    let (smaller, larger) = (across.min(along), across.max(along));
    let limit = larger * Vec4::splat(v, std::f64::consts::SQRT_2 - 1.0);
    let numerator = limit.pick_less(smaller, smaller - larger, smaller);
    let denominator = limit.pick_less(smaller, smaller + larger, larger);
    let t = numerator / denominator;
    let square = t * t;
    let angle = (polynomial(v, &ARCTANGENT, square) * square).fma(t, t);
    let mut quarters = limit.pick_less(smaller, one, zero);
    let mut turn = one;
    quarters = along.pick_less(across, two - quarters, quarters);
    turn = along.pick_less(across, -turn, turn);
    quarters = x.pick_less(zero, two + two - quarters, quarters);
    turn = x.pick_less(zero, -turn, turn);
    let rest = quarters.fma(Vec4::splat(v, QUARTER_REST), turn * angle);
    quarters.fma(Vec4::splat(v, QUARTER), rest).with_sign_of(y)
}

/// a x + b y.
#[inline(always)]
pub(crate) fn combined(a: Three, x: Vec4, b: Three, y: Vec4) -> Three {
    [a[0].fma(x, b[0] * y), a[1].fma(x, b[1] * y), a[2].fma(x, b[2] * y)]
}

#[inline(always)]
pub(crate) fn scaled(a: Three, x: Vec4) -> Three {
    [a[0] * x, a[1] * x, a[2] * x]
}

/// α = atan2(−e2a·e3b, e3a·e3b), e1a·e3b and e1a·e2b of REVOLUTE: ∂α/∂ρ = −e3b × (x e2a + y e3a)/(x² + y²).
#[inline(always)]
pub(crate) fn revolute(v: V3, tile: &Tile, out: &mut [Row]) {
    let (a1, a2, a3) =
        (column(v, &tile.triad[0], 0), column(v, &tile.triad[0], 1), column(v, &tile.triad[0], 2));
    let (b2, b3) = (column(v, &tile.triad[1], 1), column(v, &tile.triad[1], 2));
    let (y, x) = (-dot(a2, b3), dot(a3, b3));
    let inverse = Vec4::splat(v, 1.0) / x.fma(x, y * y);
    let lever = combined(a2, x * inverse, a3, y * inverse);
    put_rotation(v, &mut out[0], atan2(v, y, x), cross(lever, b3));
    put_rotation(v, &mut out[1], dot(a1, b3), cross(b3, a1));
    put_rotation(v, &mut out[2], dot(a1, b2), cross(b2, a1));
}

/// The angles of CARDAN.
#[inline(always)]
pub(crate) fn cardan(v: V3, tile: &Tile, out: &mut [Row]) {
    let (a1, a2, a3) =
        (column(v, &tile.triad[0], 0), column(v, &tile.triad[0], 1), column(v, &tile.triad[0], 2));
    let (b1, b2, b3) =
        (column(v, &tile.triad[1], 0), column(v, &tile.triad[1], 1), column(v, &tile.triad[1], 2));
    let one = Vec4::splat(v, 1.0);
    let (y, x) = (-dot(a2, b3), dot(a3, b3));
    let across = x.fma(x, y * y);
    let inverse = one / across;
    let lever = combined(a2, x * inverse, a3, y * inverse);
    put_rotation(v, &mut out[0], atan2(v, y, x), cross(lever, b3));
    let (sine, norm) = (dot(a1, b3), across.sqrt());
    let whole = one / sine.fma(sine, across);
    // −y e2a + x e3a over the norm is the direction of e3b across e1a.
    let over = sine * whole * norm * inverse;
    let along = combined(a2, y * over, a3, -(x * over));
    let reach = scaled(a1, norm * whole);
    let lever = [reach[0] + along[0], reach[1] + along[1], reach[2] + along[2]];
    put_rotation(v, &mut out[1], atan2(v, sine, norm), cross(b3, lever));
    let (y, x) = (-dot(a1, b2), dot(a1, b1));
    let inverse = one / x.fma(x, y * y);
    let lever = combined(b2, x * inverse, b1, y * inverse);
    put_rotation(v, &mut out[2], atan2(v, y, x), cross(a1, lever));
}

/// u1, u2, u3 of TRANSLATOR, and the rotation vector of Q Q₀ᵀ.
#[inline(always)]
pub(crate) fn translator(v: V3, tile: &Tile, section: &Section, out: &mut [Row]) {
    slide_plane(v, tile, &mut out[..3]);
    put_log(v, &turn_of_frozen(v, tile, section), &mut out[3..]);
}
