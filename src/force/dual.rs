//! Dual bases of one, two or three directions.

use crate::scalar::Real;
use crate::vector::{Vector, cross, dot, scale};

/// The vectors h'_k in the span of the directions h_k with h'_i·h_j = δ_ij: the coefficient of h_k in a vector v of that span is
/// h'_k·v. Zero where the directions do not span as many dimensions as they are.
pub(super) fn dual_basis<R: Real>(directions: [Option<Vector<R>>; 3]) -> [Option<Vector<R>>; 3] {
    let of =
        |numerator: Vector<R>, own: Vector<R>| scale(numerator, dot(numerator, own).reciprocal_or_zero());
    let plane = |u: Vector<R>, v: Vector<R>| {
        let normal = cross(u, v);
        (of(cross(v, normal), u), of(cross(normal, u), v))
    };
    match directions {
        [Some(u), Some(v), Some(w)] => {
            let (vw, wu, uv) = (cross(v, w), cross(w, u), cross(u, v));
            [Some(of(vw, u)), Some(of(wu, v)), Some(of(uv, w))]
        }
        [Some(u), Some(v), None] => {
            let (u, v) = plane(u, v);
            [Some(u), Some(v), None]
        }
        [Some(u), None, Some(w)] => {
            let (u, w) = plane(u, w);
            [Some(u), None, Some(w)]
        }
        [None, Some(v), Some(w)] => {
            let (v, w) = plane(v, w);
            [None, Some(v), Some(w)]
        }
        [u, v, w] => [u, v, w].map(|one| one.map(|own| of(own, own))),
    }
}
