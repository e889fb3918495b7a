//! The directions midway between a and b, near opposite third directions.

use super::U;
use super::function::turned_matrix;
use pintle_kinematics::Differentiable;
use pintle_kinematics::scalar::{Seeded, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::Matrix;
use std::f64::consts::PI;

/// The gradient of each entry of the mid frame of a turn about e1 (0) or e2 (1), whose matrix has `cosine` and `sine`.
fn gradients<R: Differentiable>(axis: usize, cosine: f64, sine: f64) -> [[[R; 3]; 3]; 3] {
    let o = 0.0;
    let r: Matrix<f64> = match axis {
        0 => [[1.0, o, o], [o, cosine, -sine], [o, sine, cosine]],
        _ => [[cosine, o, sine], [o, 1.0, o], [-sine, o, cosine]],
    };
    let r = turned_matrix::<R, R::Hessian<3>>(&r.map(vector::exact));
    let frame = so3::mid_frame(&r, None, R::ZERO);
    frame.map(|row| row.map(|entry| entry.gradient()))
}

/// Where b is turned about e1a or e2a to within δ of π, derivatives of the mid frame are as large as 1/δ. Those of the components
/// of e1 and e2 along the axis, and along e3a, are not. They keep all their digits.
#[test]
fn what_is_finite_at_opposite_directions_keeps_its_digits() {
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for axis in [0, 1] {
        for decade in 1..=15 {
            for factor in [1.0, 0.37] {
                let delta = factor * 10f64.powi(-decade);
                for angle in [PI - delta, delta - PI] {
                    let (sine, cosine) = angle.sin_cos();
                    let found = gradients::<f64>(axis, cosine, sine);
                    let exact = gradients::<Wide>(axis, cosine, sine);
                    largest = largest
                        .max(found.as_flattened().as_flattened().iter().fold(0.0, |m, x| m.max(x.abs())));
                    for (row, column) in [axis, 2].into_iter().flat_map(|row| [(row, 0), (row, 1)]) {
                        for k in 0..3 {
                            let error = (exact[row][column][k] - Wide::from_f64(found[row][column][k]))
                                .abs()
                                .to_f64();
                            worst = worst.max(error / U);
                        }
                    }
                }
            }
        }
    }
    assert!(largest > 1e13, "the singular point is not approached: {largest:e}");
    assert!(worst <= 4.0, "{worst} roundings");
}
