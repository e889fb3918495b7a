//! What is wrong at special states only: no number at all, or fewer digits the nearer they are.

use super::{DF, F, Right, Wrong, each, one, relative, row};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, column, dot, product, transpose};

/// The rotation of b against a since the initial state.
fn since(right: &Right<'_>) -> [[f64; 3]; 3] {
    let q0 = relative(right.initial());
    product(&right.q(), &transpose(&q0))
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("ALIGN", "θ n with n = v/|v|: no number where nothing has turned"),
        &[F],
        |right, numbers| {
            let phi = so3::log(&since(right));
            let angle = norm(phi);
            each(numbers, F, |k, _, _| angle * (phi[k - 3] / angle));
        },
        (&["diagnosis::not-a-number"], "ur1"),
    ),
    Wrong::new(
        ("AXIAL", "the rate of change divides by the change"),
        &[F, DF],
        |right, numbers| {
            let (f, same) = (right.of(F, 0, 0), right.of(F, 0, 0));
            row(numbers, DF, 0, |row| row.iter_mut().for_each(|x| *x *= f / same));
        },
        (&["diagnosis::not-a-number"], "∂u1"),
    ),
    Wrong::new(
        ("FLEXION-TORSION", "the flexion by acos"),
        &[F],
        |right, numbers| {
            let q0 = relative(right.initial());
            one(numbers, F, (3, 0), |_| right.q()[2][2].clamp(-1.0, 1.0).acos() - q0[2][2].acos());
        },
        (&["diagnosis::digits-lost"], "ur1"),
    ),
    Wrong::new(
        ("CARDAN", "the second angle by asin"),
        &[F],
        |right, numbers| {
            let q0 = relative(right.initial());
            one(numbers, F, (4, 0), |_| right.q()[0][2].clamp(-1.0, 1.0).asin() - q0[0][2].asin());
        },
        (&["diagnosis::digits-lost"], "ur2"),
    ),
    Wrong::new(
        ("EULER", "the second angle by acos"),
        &[F],
        |right, numbers| {
            let q0 = relative(right.initial());
            let of = |q: [[f64; 3]; 3]| q[2][2].clamp(-1.0, 1.0).acos();
            // On the sheet of the right one.
            let mine = of(right.q()) - of(q0);
            one(numbers, F, (4, 0), |x| if (mine - x).abs() < 1e-3 { mine } else { x });
        },
        (&["diagnosis::digits-lost"], "ur2"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "the radius as the root of a difference of squares"),
        &[F],
        |right, numbers| {
            let of = |d: Vector<f64>, axis: Vector<f64>| (dot(d, d) - dot(axis, d).powi(2)).max(0.0).sqrt();
            let initial = right.initial();
            let first = of(initial.reference, column(&initial.a.triad, 2));
            one(numbers, F, (0, 0), |_| of(right.d(), right.a(2)) - first);
        },
        (&["diagnosis::digits-lost"], "u1"),
    ),
];
