//! The left Jacobian of the rotation vector and its inverse: against differences of exp, and with derivatives of their own.

use super::U;
use super::grid::Stream;
use num_dual::{Dual3, Dual64};
use pintle_kinematics::scalar::{Scalar, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, add, product, scale};

/// exp((φ + h e)^) exp((φ − h e)^)ᵀ of 2h, on 237 bits: the column of J_l along e, with an error of h².
fn column(phi: Vector<f64>, axis: usize) -> Vector<Wide> {
    let h = Wide::from_f64(1e-20);
    let phi = phi.map(Wide::from_f64);
    let mut step = [Wide::from_f64(0.0); 3];
    step[axis] = h;
    let [up, down] = [add(phi, step), add(phi, scale(step, Wide::from_f64(-1.0)))];
    let turned =
        so3::log_quaternion(so3::compose(so3::exp_quaternion(up), so3::conjugate(so3::exp_quaternion(down))));
    turned.map(|x| x / (h + h))
}

#[test]
fn jacobians_of_rotation_vectors() {
    let mut stream = Stream(7);
    let (mut worst, mut worst_inverse, mut compared) = (0.0f64, 0.0f64, 0);
    for size in [0.0, 1e-300, 1e-12, 1e-6, 1e-3, 0.1, 0.7, 1.5, 2.2, 2.9, 3.1, 4.0, 6.0, 9.9] {
        for _ in 0..20 {
            let v = stream.vector();
            let phi = scale(v, size / v.iter().map(|x| x * x).sum::<f64>().sqrt());
            let jacobian = so3::left_jacobian(phi);
            let inverse = so3::inverse_left_jacobian(phi);
            let largest = |m: &Matrix<f64>| m.as_flattened().iter().fold(0.0f64, |most, x| most.max(x.abs()));
            let unit = product(&jacobian, &inverse);
            for j in 0..3 {
                for (i, exact) in column(phi, j).into_iter().enumerate() {
                    let off = (Wide::from_f64(jacobian[i][j]) - exact).abs().to_f64();
                    worst = worst.max(off / U / largest(&jacobian));
                    let off = (unit[i][j] - f64::from(u8::from(i == j))).abs();
                    if size < 3.0 {
                        worst_inverse = worst_inverse.max(off / U / largest(&jacobian) / largest(&inverse));
                    }
                    compared += 1;
                }
            }
            // Along a line: derivatives of the entries are differences of entries, and the third order agrees with the first.
            let along = v;
            let first = so3::left_jacobian([0, 1, 2].map(|i| Dual64::new(phi[i], along[i])));
            let third = so3::left_jacobian([0, 1, 2].map(|i| Dual3::new(phi[i], along[i], 0.0, 0.0)));
            let h = Wide::from_f64(1e-20);
            let at = |sign: f64| {
                let step = along.map(|x| Wide::from_f64(x) * h * Wide::from_f64(sign));
                so3::left_jacobian(add(phi.map(Wide::from_f64), step))
            };
            let (up, down) = (at(1.0), at(-1.0));
            for i in 0..3 {
                for j in 0..3 {
                    let exact = ((up[i][j] - down[i][j]) / (h + h)).to_f64();
                    assert!(
                        (first[i][j].eps - exact).abs() < 32.0 * U,
                        "{phi:?}: {} {exact}",
                        first[i][j].eps
                    );
                    assert!((third[i][j].v1 - exact).abs() < 32.0 * U, "{phi:?}: {} {exact}", third[i][j].v1);
                    assert!((first[i][j].real() - jacobian[i][j]).abs() < 16.0 * U);
                }
            }
        }
    }
    assert_eq!(compared, 14 * 20 * 9);
    assert!(worst < 8.0 && worst_inverse < 10.0, "{worst} {worst_inverse}");
}
