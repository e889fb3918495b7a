//! Lanes against doubles, at points where formulas change.

use super::{LANES, Lanes, Real};
use crate::scalar::elementary::{atan2, norm};
use crate::scalar::{Differentiable, Scalar, Seeded, Wide};
use crate::so3;
use crate::vector::{self, Matrix};

type Fused = Lanes<true>;

/// Two doubles are at most this many roundings of the larger one apart, or differ below the normal numbers, where the scaling of one
/// double by a fixed power of two makes 0 of what that of lanes keeps: 1e-160 over 1e150.
fn close(x: f64, y: f64, units: f64) -> bool {
    let subnormal = x != y && (x - y).abs() < f64::MIN_POSITIVE;
    x == y && x.is_sign_negative() == y.is_sign_negative()
        || (x - y).abs() <= units * f64::EPSILON / 2.0 * y.abs()
        || x.is_nan() && y.is_nan()
        || subnormal
}

fn lane_by_lane(
    points: &[[f64; 2]],
    lanes: impl Fn([Fused; 2]) -> Fused,
    one: impl Fn([f64; 2]) -> f64,
    units: f64,
) {
    // Every point meets every lane, with other neighbours each time.
    for shift in 0..points.len() {
        let at = |i: usize| points[(i * (shift + 1) + shift) % points.len()];
        let found = lanes([0, 1].map(|j| Lanes([0, 1, 2, 3].map(|i| at(i)[j]))));
        for i in 0..LANES {
            let expected = one(at(i));
            assert!(close(found.0[i], expected, units), "{:?}: {:e}, one: {expected:e}", at(i), found.0[i]);
        }
    }
}

fn grid() -> Vec<[f64; 2]> {
    let mut numbers = vec![0.0, 1.0, 0.4142, 0.4143, 2.414, 2.415, 1e-9, 1e-160, 1e150, 0.1, 0.7, 3.0];
    numbers.extend(numbers.clone().iter().map(|x| -x));
    numbers.iter().flat_map(|x| numbers.iter().map(|y| [*x, *y])).collect()
}

#[test]
fn arctangents() {
    lane_by_lane(&grid(), |[y, x]| y.arctangent(x), |[y, x]| y.atan2(x), 3.0);
}

#[test]
fn sines_and_cosines() {
    let mut points: Vec<[f64; 2]> = (-40..=40).map(|i| [f64::from(i) * 0.4, 0.0]).collect();
    points.extend([0.0, 1e-300, 1e-9, 1e4, 99_999.0, 1e5, 1e9].map(|x| [x, 0.0]));
    // Near a zero the error is that of the reduced angle.
    lane_by_lane(&points, |[x, _]| x.sine_cosine().0, |[x, _]| x.sin(), 4.0);
    lane_by_lane(&points, |[x, _]| x.sine_cosine().1, |[x, _]| x.cos(), 4.0);
}

#[test]
fn norms_of_every_size() {
    let mut points = grid();
    points.extend([[1e300, -3e299], [1e-300, 2e-300], [1e300, 1e-300], [-1e-300, 0.0]]);
    lane_by_lane(
        &points,
        |[x, y]| Fused::direction_and_norm([x, y]).1,
        |[x, y]| f64::direction_and_norm([x, y]).1,
        3.0,
    );
    lane_by_lane(
        &points,
        |[x, y]| Fused::direction_and_norm([x, y]).0[0],
        |[x, y]| f64::direction_and_norm([x, y]).0[0],
        4.0,
    );
    lane_by_lane(&points, |[x, y]| Fused::inverted([x, y])[1], |[x, y]| f64::inverted([x, y])[1], 5.0);
}

#[test]
fn series_of_the_log() {
    let points: Vec<[f64; 2]> = (0..=200).map(|i| [f64::from(i) / 200.0, 0.0]).collect();
    for order in 0..3 {
        lane_by_lane(
            &points,
            |[c, _]| Fused::log_series(c, 2)[order],
            // The recurrence by which doubles come to the second coefficient beyond 60° loses a digit of it.
            |[c, _]| Wide::log_series(Wide::from_f64(c), 2)[order].to_f64(),
            4.0,
        );
    }
}

#[test]
fn integers_and_turns() {
    let points: Vec<[f64; 2]> = [0.5, -0.5, 1.5, 2.5, 0.499_999_999_999_999_94, -2.5, 3.2, 1e9, -0.2]
        .into_iter()
        .flat_map(|x| [[x, 3.0], [x, 1e9], [x, 0.0]])
        .collect();
    lane_by_lane(&points, |[x, _]| x.nearest_integer(), |[x, _]| x.nearest_integer(), 0.0);
    lane_by_lane(&points, |[x, n]| Fused::with_turns(x, n), |[x, n]| f64::with_turns(x, n), 0.0);
    lane_by_lane(&points, |[x, _]| x.reciprocal_or_zero(), |[x, _]| x.reciprocal_or_zero(), 0.0);
    lane_by_lane(
        &[[0.0, 0.0], [f64::NAN, 0.0]],
        |[x, _]| x.reciprocal_or_zero(),
        |[x, _]| x.reciprocal_or_zero(),
        0.0,
    );
}

/// First and second derivatives, each lane at another kind of point.
#[test]
fn derivatives_of_angles_and_norms() {
    type Second = <Fused as Differentiable>::Hessian<2>;
    type One = <f64 as Differentiable>::Hessian<2>;
    let y = [1.0, 0.0, -1e-3, 3.0];
    let x = [0.0, -2.0, 1.0, -4.0];
    let seed = |i: usize| -> [One; 2] { [One::seed(y[i], 0), One::seed(x[i], 1)] };
    let lanes = [Second::seed(Lanes(y), 0), Second::seed(Lanes(x), 1)];
    let check = |found: Second, one: fn([One; 2]) -> One| {
        for i in 0..LANES {
            let expected = one(seed(i));
            for j in 0..2 {
                assert!(close(found.gradient()[j].0[i], expected.gradient()[j], 4.0), "lane {i}, {j}");
                for k in 0..2 {
                    let (x, y) = (found.hessian()[j][k].0[i], expected.hessian()[j][k]);
                    assert!((x - y).abs() <= 1e-15 * (1.0 + y.abs()), "lane {i}, {j} {k}: {x:e} {y:e}");
                }
            }
        }
    };
    check(atan2(lanes[0], lanes[1]), |[y, x]| atan2(y, x));
    check(norm(lanes), norm);
}

/// Logs, torsions and component flexions of rotations on lanes, with first and second derivatives, are those of doubles: at no
/// rotation and near it, at exact quarter and half turns about every axis, near half turns, anywhere.
#[test]
fn rotations_are_those_of_doubles() {
    type Second = <Fused as Differentiable>::Hessian<3>;
    type One = <f64 as Differentiable>::Hessian<3>;
    let axes: [[f64; 3]; 6] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.6, 0.0, -0.8],
        [-0.36, 0.48, 0.8],
        [0.48, 0.64, -0.6],
    ];
    let angles = [0.0, 1e-9, 0.3, 1.2, 1.6, 2.2, 3.0, 3.13];
    let mut rotations: Vec<Matrix<f64>> = Vec::new();
    for axis in axes {
        for angle in angles {
            rotations.push(so3::matrix(so3::exp(axis.map(|e| e * angle))));
            rotations.push(so3::matrix(so3::exp(axis.map(|e| -e * angle))));
        }
    }
    for (i, j) in [(1, 2), (2, 0), (0, 1)] {
        // A quarter turn and a half one, exact.
        let mut quarter = [[0.0; 3]; 3];
        (quarter[3 - i - j][3 - i - j], quarter[i][j], quarter[j][i]) = (1.0, -1.0, 1.0);
        rotations.push(quarter);
        rotations.push(vector::product(&quarter, &quarter));
    }
    /// φ, β, α_1 and α_2 of exp(σ^) R.
    fn measured<S: Scalar>(r: &Matrix<S>, spin: [S; 3]) -> [S; 6] {
        let [x, y, z] = spin;
        let zero = S::zero();
        let skew = [[zero, -z, y], [z, zero, -x], [-y, x, zero]];
        let (first, second) = (vector::product(&skew, r), vector::product(&skew, &vector::product(&skew, r)));
        let half = S::Real::ratio(1, 2);
        let turned = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[i][j] + first[i][j] + second[i][j].scale(half)));
        let log = so3::log_along(&turned, Some(spin));
        let [x, y] = so3::component_flexions(&turned, Some(spin), S::Real::integer(0));
        [log[0], log[1], log[2], so3::torsion_along(&turned, Some(spin)), x, y]
    }
    for shift in 0..rotations.len() {
        // Each lane another kind of rotation.
        let at = |lane: usize| &rotations[(shift + 17 * lane) % rotations.len()];
        let r = [0, 1, 2]
            .map(|i| [0, 1, 2].map(|j| Second::from_real(Lanes([0, 1, 2, 3].map(|lane| at(lane)[i][j])))));
        let found = measured(&r, [0, 1, 2].map(|k| Second::seed(Fused::integer(0), k)));
        for lane in 0..LANES {
            let r = at(lane).map(|row| row.map(One::from_real));
            let expected = measured(&r, [0, 1, 2].map(|k| One::seed(0.0, k)));
            // Torsion and flexions end where the third directions are opposite, the log's derivatives grow towards half a turn.
            let to_opposite = 1.0 + at(lane)[2][2];
            let trace = at(lane)[0][0] + at(lane)[1][1] + at(lane)[2][2];
            for c in 0..6 {
                let distance: f64 =
                    if c < 3 { (trace + 1.0).max(0.0).sqrt() } else { to_opposite.max(0.0).sqrt() };
                if distance < 0.05 {
                    continue;
                }
                let size = 1.0 / distance;
                let near = |x: f64, y: f64, scale: f64| (x - y).abs() <= 2e-15 * (scale + y.abs());
                let (x, y) = (found[c].real().0[lane], expected[c].real());
                assert!(near(x, y, size), "{c} of {:?}: {x:e}, one: {y:e}", at(lane));
                for j in 0..3 {
                    let (x, y) = (found[c].gradient()[j].0[lane], expected[c].gradient()[j]);
                    assert!(near(x, y, size * size), "∂{c}/∂{j} of {:?}: {x:e}, one: {y:e}", at(lane));
                    for k in 0..3 {
                        let (x, y) = (found[c].hessian()[j][k].0[lane], expected[c].hessian()[j][k]);
                        let scale = size * size * size;
                        assert!(
                            near(x, y, 4.0 * scale),
                            "∂²{c}/∂{j}∂{k} of {:?}: {x:e}, one: {y:e}",
                            at(lane)
                        );
                    }
                }
            }
        }
    }
}
