//! Lanes against doubles, at points where formulas change.

use super::{LANES, Lanes, Real};
use crate::scalar::elementary::{atan2, norm};
use crate::scalar::{Differentiable, Seeded, Wide};

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
