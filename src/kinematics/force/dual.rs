//! Dual bases of one, two or three directions.

use crate::scalar::Real;
use crate::vector::{Vector, cross, dot, scale};

/// The vectors h'_k in the span of the directions h_k with `h'_i·h_j = δ_ij`. The coefficient of h_k in a vector v of that span is
/// `h'_k·v`. `None` where the directions are not independent.
pub(super) fn dual_basis<R: Real>(directions: [Option<Vector<R>>; 3]) -> [Option<Vector<R>>; 3] {
    let of = |numerator: Vector<R>, own: Vector<R>| {
        let (zero, product) = (R::ZERO, dot(numerator, own));
        R::holds(zero.less(product.magnitude())).then(|| scale(numerator, R::integer(1) / product))
    };
    let plane = |u: Vector<R>, v: Vector<R>| {
        let normal = cross(u, v);
        [of(cross(v, normal), u), of(cross(normal, u), v)]
    };
    match directions {
        [Some(u), Some(v), Some(w)] => [of(cross(v, w), u), of(cross(w, u), v), of(cross(u, v), w)],
        [Some(u), Some(v), None] => {
            let [u, v] = plane(u, v);
            [u, v, None]
        }
        [Some(u), None, Some(w)] => {
            let [u, w] = plane(u, w);
            [u, None, w]
        }
        [None, Some(v), Some(w)] => {
            let [v, w] = plane(v, w);
            [None, v, w]
        }
        [u, v, w] => [u, v, w].map(|one| one.and_then(|own| of(own, own))),
    }
}
