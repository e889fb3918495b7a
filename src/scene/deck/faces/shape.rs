//! Where a point lies on a face, by the shape functions of its nodes.

use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::{cross, dot, sub};

/// A share beyond the edge of a face that rounding of coordinates explains.
const BEYOND: f64 = 1e-6;

/// N_i at (r, s) and their derivatives by r and by s: corners first, then the nodes in the middle of edges, in order.
type Functions = Vec<[f64; 3]>;

/// Of a triangle with 3 or 6 nodes: N_i = L_i, or L_i (2 L_i − 1) and 4 L_i L_j, with L = (1 − r − s, r, s).
fn triangle(count: usize, [r, s]: [f64; 2]) -> Functions {
    let corners = [[1.0 - r - s, -1.0, -1.0], [r, 1.0, 0.0], [s, 0.0, 1.0]];
    if count == 3 {
        return corners.to_vec();
    }
    let middles = [[0, 1], [1, 2], [2, 0]].map(|[i, j]| {
        let ([a, a_r, a_s], [b, b_r, b_s]): ([f64; 3], [f64; 3]) = (corners[i], corners[j]);
        [4.0 * a * b, 4.0 * (a_r * b + a * b_r), 4.0 * (a_s * b + a * b_s)]
    });
    let corners =
        corners.map(|[l, by_r, by_s]| [l * (2.0 * l - 1.0), (4.0 * l - 1.0) * by_r, (4.0 * l - 1.0) * by_s]);
    corners.into_iter().chain(middles).collect()
}

/// Of a quadrilateral with 4 or 8 nodes (serendipity), −1 ≤ r, s ≤ 1.
fn quadrilateral(count: usize, [r, s]: [f64; 2]) -> Functions {
    const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let is_second = count == 8;
    let corner = |[a, b]: [f64; 2]| {
        let (p, q) = (1.0 + a * r, 1.0 + b * s);
        if is_second {
            let sum = a * r + b * s;
            [p * q * (sum - 1.0) / 4.0, a * q * (sum - 1.0 + p) / 4.0, b * p * (sum - 1.0 + q) / 4.0]
        } else {
            [p * q / 4.0, a * q / 4.0, b * p / 4.0]
        }
    };
    let mut found: Functions = CORNERS.map(corner).to_vec();
    if is_second {
        for [a, b] in [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]] {
            let (p, q) = (1.0 + a * r, 1.0 + b * s);
            found.push(if a == 0.0 {
                [(1.0 - r * r) * q / 2.0, -r * q, (1.0 - r * r) * b / 2.0]
            } else {
                [p * (1.0 - s * s) / 2.0, a * (1.0 - s * s) / 2.0, -p * s]
            });
        }
    }
    found
}

/// The shape functions N_i of a face at the point of it that is nearest to x, and the distance of that point (length). They are those of the
/// isoparametric elements with 3, 4, 6 or 8 nodes (Bathe, Finite Element Procedures, 5.3), corners first. None where the point is beyond an
/// edge, and for another face.
pub(in crate::deck) fn at(face: &[[f64; 3]], x: [f64; 3]) -> Option<(Vec<f64>, f64)> {
    const STEPS: usize = 30;
    let is_triangle = matches!(face.len(), 3 | 6);
    let functions = match face.len() {
        3 | 6 => triangle,
        4 | 8 => quadrilateral,
        _ => return None,
    };
    let mut place = if is_triangle { [1.0 / 3.0; 2] } else { [0.0; 2] };
    for _ in 0..STEPS {
        let shape = functions(face.len(), place);
        let of = |which: usize| {
            [0, 1, 2].map(|i| shape.iter().zip(face).map(|(n, node)| n[which] * node[i]).sum::<f64>())
        };
        let (apart, by_r, by_s) = (sub(x, of(0)), of(1), of(2));
        // Least squares of two unknowns, over the normal of the face.
        let normal = cross(by_r, by_s);
        let area = dot(normal, normal);
        if area <= 0.0 || !area.is_finite() {
            return None;
        }
        let step = [dot(cross(apart, by_s), normal) / area, dot(cross(by_r, apart), normal) / area];
        place = [place[0] + step[0], place[1] + step[1]];
        if step.iter().all(|step| step.abs() < 1e-14) {
            break;
        }
        if place.iter().any(|coordinate| coordinate.is_nan() || coordinate.abs() >= 4.0) {
            return None;
        }
    }
    let [r, s] = place;
    let is_inside =
        if is_triangle { r.min(s).min(1.0 - r - s) >= -BEYOND } else { r.abs().max(s.abs()) <= 1.0 + BEYOND };
    let shares: Vec<f64> = functions(face.len(), place).into_iter().map(|[n, ..]| n).collect();
    let on = [0, 1, 2].map(|i| shares.iter().zip(face).map(|(n, node)| n * node[i]).sum::<f64>());
    is_inside.then(|| (shares, norm(sub(x, on))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each shape function is one at its node and zero at the others. They add up to one, and have their derivatives. Faces carry a linear field
    /// exactly, those of second order a quadratic one.
    #[test]
    fn shapes_carry_fields() {
        let triangles = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
        let squares = [
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 1.0],
            [-1.0, 1.0],
            [0.0, -1.0],
            [1.0, 0.0],
            [0.0, 1.0],
            [-1.0, 0.0],
        ];
        let mut compared = 0;
        for (count, nodes, functions) in [
            (3, &triangles[..3], triangle as fn(usize, [f64; 2]) -> Functions),
            (6, &triangles[..], triangle),
            (4, &squares[..4], quadrilateral),
            (8, &squares[..], quadrilateral),
        ] {
            for (place, node) in nodes.iter().enumerate() {
                for (other, [n, ..]) in functions(count, *node).into_iter().enumerate() {
                    assert!(
                        (n - f64::from(u8::from(other == place))).abs() < 1e-15,
                        "{count} {place} {other}"
                    );
                    compared += 1;
                }
            }
            let face: Vec<[f64; 3]> = nodes
                .iter()
                .map(|[r, s]| [2.0 + 3.0 * r - s, 0.5 * r + 2.0 * s, 1.0 - r + 0.25 * s])
                .collect();
            for [r, s] in [[0.25, 0.125], [0.1, 0.7], [0.4, 0.3]] {
                let shape = functions(count, [r, s]);
                let step = 1e-6;
                for (which, moved) in [[r + step, s], [r, s + step]].into_iter().enumerate() {
                    for (n, other) in shape.iter().zip(functions(count, moved)) {
                        assert!(((other[0] - n[0]) / step - n[which + 1]).abs() < 1e-5);
                        compared += 1;
                    }
                }
                let x = [2.0 + 3.0 * r - s, 0.5 * r + 2.0 * s, 1.0 - r + 0.25 * s];
                let (shares, apart) = at(&face, x).unwrap();
                assert!(apart < 1e-14 && (shares.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{count} {apart}");
                let quadratic =
                    |[a, b]: [f64; 2]| 1.0 + a - 2.0 * b + if count > 4 { a * b - b * b } else { 0.0 };
                let carried: f64 = shares.iter().zip(nodes).map(|(n, node)| n * quadratic(*node)).sum();
                assert!((carried - quadratic([r, s])).abs() < 1e-13, "{count}");
                compared += 2;
            }
            assert!(at(&face, [2.0 + 3.0 * 1.5, 0.75, -0.5]).is_none(), "beyond an edge");
        }
        assert_eq!(compared, 9 + 36 + 16 + 64 + 4 * 6 + 6 * (3 + 6 + 4 + 8));
    }
}
