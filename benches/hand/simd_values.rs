//! Values by hand, without rows, four elements at a time.

use super::simd::{RelativeTurn, atan2, separation, turn_of, turn_of_frozen};
use super::vector::{Vec4, column, dot};
use pintle_kinematics::batch::{Four, Section, Tile};
use pulp::x86::V3;

/// e_i^a·d of SLIDE-PLANE.
#[inline(always)]
pub(crate) fn slide_plane(v: V3, tile: &Tile, out: &mut [Four]) {
    let d = separation(v, tile);
    for (i, value) in out.iter_mut().enumerate().take(3) {
        dot(column(v, &tile.triad[0], i), d).store(value);
    }
}

/// α = atan2(−e2a·e3b, e3a·e3b), e1a·e3b and e1a·e2b of REVOLUTE.
#[inline(always)]
pub(crate) fn revolute(v: V3, tile: &Tile, out: &mut [Four]) {
    let [a, b] = &tile.triad;
    let (a1, b3) = (column(v, a, 0), column(v, b, 2));
    let (y, x) = (-dot(column(v, a, 1), b3), dot(column(v, a, 2), b3));
    atan2(v, y, x).store(&mut out[0]);
    dot(a1, b3).store(&mut out[1]);
    dot(a1, column(v, b, 1)).store(&mut out[2]);
}

/// The angles of CARDAN.
#[inline(always)]
pub(crate) fn cardan(v: V3, tile: &Tile, out: &mut [Four]) {
    let [a, b] = &tile.triad;
    let (a1, b3) = (column(v, a, 0), column(v, b, 2));
    let (y, x) = (-dot(column(v, a, 1), b3), dot(column(v, a, 2), b3));
    atan2(v, y, x).store(&mut out[0]);
    atan2(v, dot(a1, b3), x.fma(x, y * y).sqrt()).store(&mut out[1]);
    let (y, x) = (-dot(a1, column(v, b, 1)), dot(a1, column(v, b, 0)));
    atan2(v, y, x).store(&mut out[2]);
}

/// φ_i of ROTATION, principal.
#[inline(always)]
pub(crate) fn rotation(v: V3, tile: &Tile, out: &mut [Four]) {
    put_log(v, &turn_of(v, tile), out);
}

/// u1, u2, u3 of TRANSLATOR, and the rotation vector of Q Q₀ᵀ.
#[inline(always)]
pub(crate) fn translator(v: V3, tile: &Tile, section: &Section, out: &mut [Four]) {
    slide_plane(v, tile, &mut out[..3]);
    put_log(v, &turn_of_frozen(v, tile, section), &mut out[3..]);
}

#[inline(always)]
fn put_log(v: V3, turn: &RelativeTurn, out: &mut [Four]) {
    let log = turn.log(v);
    for i in 0..3 {
        Vec4::store(log.k * log.v[i], &mut out[i]);
    }
}
