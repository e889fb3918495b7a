//! No finite input gives a number that is not finite, except where the true derivative overflows.

use super::function::Function;
use pintle_kinematics::so3;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const SPECIAL: &[f64] = &[1.0, 0.5, FRAC_PI_2, PI, TAU, 1e-8, f64::EPSILON, 1.0 + f64::EPSILON];

/// A finite number of either sign: a zero, a special value, or of log-uniform magnitude 10^low to 10^high.
fn number(low: f64, high: f64) -> impl Strategy<Value = f64> {
    let magnitude = prop_oneof![
        1 => Just(0.0),
        2 => proptest::sample::select(SPECIAL),
        7 => (low..high).prop_map(|k| 10f64.powf(k)),
    ];
    (magnitude, any::<bool>()).prop_map(|(x, negative)| if negative { -x } else { x })
}

fn numbers<const N: usize>(low: f64, high: f64) -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(number(low, high), N)
}

/// A unit quaternion from four such numbers; the identity for four zeros.
fn quaternion() -> impl Strategy<Value = [f64; 4]> {
    numbers::<4>(-70.0, 70.0).prop_map(|q| {
        let largest = q.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if largest == 0.0 {
            return [1.0, 0.0, 0.0, 0.0];
        }
        so3::normalize([q[0] / largest, q[1] / largest, q[2] / largest, q[3] / largest])
    })
}

/// Every number of the orders up to `orders` is finite.
fn finite(function: Function, input: &[f64], orders: usize) -> Result<(), TestCaseError> {
    for output in function.numbers(input) {
        for (k, x) in output.iter().enumerate() {
            let judged = super::order(k, function.directions()) <= orders;
            prop_assert!(!judged || x.is_finite(), "{function:?} at {input:?}: number {k} is {x}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4096, failure_persistence: None, ..ProptestConfig::default() })]

    /// 1/√x, 1/x: the first derivative overflows below 1e−154, the second below 1e−102.
    #[test]
    fn functions_of_a_positive_number(k in -300.0..300.0) {
        let x = [10f64.powf(k)];
        let orders = if k > -102.0 { 2 } else if k > -154.0 { 1 } else { 0 };
        for function in [Function::Sqrt, Function::InverseSqrt, Function::Recip] {
            finite(function, &x, orders)?;
        }
        finite(Function::Sqrt, &x, if k > -205.0 { 2 } else { 1 })?;
        finite(Function::SinCos, &x, 2)?;
    }

    /// The second derivatives of angle and direction overflow below 1e−154, those of the norm nowhere.
    #[test]
    fn functions_of_a_vector(v in numbers::<3>(-300.0, 300.0)) {
        let size = |v: &[f64]| v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let orders = |v: &[f64]| if size(v) > 1e-153 || size(v) == 0.0 { 2 } else { 1 };
        finite(Function::Atan2, &v[..2], orders(&v[..2]))?;
        finite(Function::Norm2, &v[..2], 2)?;
        finite(Function::Norm3, &v, 2)?;
        finite(Function::Direction3, &v, orders(&v))?;
    }

    /// Down to the last subnormal number.
    #[test]
    fn functions_of_a_vanishing_vector(bits in proptest::collection::vec(0u64..1 << 53, 3)) {
        let v: Vec<f64> = bits.into_iter().map(f64::from_bits).collect();
        finite(Function::Sqrt, &v[..1], 0)?;
        finite(Function::Atan2, &v[..2], 0)?;
        finite(Function::Norm2, &v[..2], 1)?;
        finite(Function::Norm3, &v, 1)?;
        finite(Function::Direction3, &v, 0)?;
    }

    #[test]
    fn exp_of_any_rotation_vector(phi in numbers::<3>(-300.0, 6.0)) {
        finite(Function::ExpQuaternion, &phi, 2)?;
        finite(Function::ExpMatrix, &phi, 2)?;
    }

    #[test]
    fn functions_of_any_rotation(q in quaternion(), reference in numbers::<3>(-20.0, 4.0), sign in any::<bool>()) {
        let matrix = so3::matrix(q).concat();
        finite(Function::LogQuaternion, &q, 2)?;
        finite(Function::LogMatrix, &matrix, 2)?;
        finite(Function::ContinuousLog, &[&q[..], &reference].concat(), 2)?;
        finite(Function::ContinuousLogMatrix, &[&matrix[..], &reference].concat(), 2)?;
        finite(Function::Cardan, &matrix, 2)?;
        finite(Function::Euler, &[&matrix[..], &[if sign { 1.0 } else { -1.0 }]].concat(), 2)?;
    }
}

/// Rotations that permute the axes, with zeros of both signs: right angles, half turns and locks, exactly.
#[test]
fn exact_rotations() {
    for axes in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
        for signs in 0..8 {
            for zero in [0.0, -0.0] {
                let mut matrix = [zero; 9];
                for (row, axis) in axes.into_iter().enumerate() {
                    matrix[3 * row + axis] = if signs >> row & 1 == 0 { 1.0 } else { -1.0 };
                }
                let m = |i: usize, j: usize| matrix[3 * i + j];
                let determinant = m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1))
                    - m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0))
                    + m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0));
                if determinant < 0.0 {
                    continue;
                }
                for function in [Function::LogMatrix, Function::Cardan] {
                    finite(function, &matrix, 2).unwrap();
                }
                for sign in [1.0, -1.0] {
                    finite(Function::Euler, &[&matrix[..], &[sign]].concat(), 2).unwrap();
                }
                for turns in [0.0, 1.0, -3.0] {
                    for reference in [[TAU * turns, 0.0, 0.0], [0.0, TAU * turns + 1.0, 0.0]] {
                        finite(Function::ContinuousLogMatrix, &[&matrix[..], &reference].concat(), 2)
                            .unwrap();
                    }
                }
                // Angles of exact rotations are exact multiples of a right angle, never −π.
                for angles in [so3::cardan(&rows(&matrix)), so3::euler(&rows(&matrix), 1.0)] {
                    for angle in angles {
                        assert!([-FRAC_PI_2, 0.0, FRAC_PI_2, PI].contains(&angle), "{matrix:?}: {angles:?}");
                    }
                }
            }
        }
    }
}

fn rows(m: &[f64; 9]) -> [[f64; 3]; 3] {
    [0, 3, 6].map(|i| [m[i], m[i + 1], m[i + 2]])
}
