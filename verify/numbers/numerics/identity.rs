//! At zero rotation the derivatives of exp and log are known exactly, and must be exact: the place where a Jacobian is seeded,
//! and where formulas with a norm or an arccosine silently return zero.

use super::function::Function;
use num_dual::{Dual, Dual2, Dual3, DualSVec, HyperDual};
use pintle_kinematics::scalar::Scalar;
use pintle_kinematics::so3;

const ZERO: [f64; 3] = [0.0; 3];
const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// Positions of the second derivatives 11, 12, 13, 22, 23, 33 among the numbers of an output.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

fn delta(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

/// The entry (i, j) of the cross-product matrix of the unit vector k.
fn generator(k: usize, i: usize, j: usize) -> f64 {
    if i == j || i == k || j == k {
        0.0
    } else if (i + 1) % 3 == j {
        -1.0
    } else {
        1.0
    }
}

#[test]
fn log_is_the_identity_map_at_zero() {
    let with_reference = |rotation: &[f64]| [rotation, &ZERO].concat();
    let cases = [
        (Function::LogQuaternion, vec![1.0, 0.0, 0.0, 0.0]),
        (Function::LogQuaternion, vec![-1.0, 0.0, 0.0, 0.0]),
        (Function::LogQuaternion, vec![-1.0, -0.0, 0.0, -0.0]),
        (Function::LogMatrix, IDENTITY.to_vec()),
        (Function::ContinuousLog, with_reference(&[1.0, 0.0, 0.0, 0.0])),
        (Function::ContinuousLogMatrix, with_reference(&IDENTITY)),
    ];
    for (function, input) in cases {
        for (i, output) in function.numbers(&input).iter().enumerate() {
            assert_eq!(output[0], 0.0, "{function:?} at {input:?}");
            for j in 0..3 {
                assert_eq!(output[1 + j], delta(i, j), "{function:?} at {input:?}, ∂φ{i}/∂e{j}");
            }
            assert_eq!(output[4..], [0.0; 6], "{function:?} at {input:?}, second derivatives");
        }
    }
}

#[test]
fn exp_has_the_generators_at_zero() {
    for (i, output) in Function::ExpQuaternion.numbers(&ZERO).iter().enumerate() {
        assert_eq!(output[0], delta(i, 0));
        for j in 0..3 {
            assert_eq!(output[1 + j], 0.5 * delta(i, j + 1));
        }
        for (n, (j, k)) in PAIRS.into_iter().enumerate() {
            assert_eq!(output[4 + n], -0.25 * delta(i, 0) * delta(j, k));
        }
    }
    for (index, output) in Function::ExpMatrix.numbers(&ZERO).iter().enumerate() {
        let (i, j) = (index / 3, index % 3);
        assert_eq!(output[0], delta(i, j));
        for k in 0..3 {
            assert_eq!(output[1 + k], generator(k, i, j));
        }
        for (n, (k, l)) in PAIRS.into_iter().enumerate() {
            // (G_k G_l + G_l G_k)/2 = (e_k e_lᵀ + e_l e_kᵀ)/2 − δ_kl I
            let expected =
                0.5 * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k)) - delta(k, l) * delta(i, j);
            assert_eq!(output[4 + n], expected, "R{i}{j}, {k}{l}");
        }
    }
}

/// φ → R → φ and φ → q → φ at φ = 0, moving.
fn there_and_back<S: Scalar<Real = f64>>(phi: [S; 3]) -> [[S; 3]; 4] {
    let q = so3::exp_quaternion(phi);
    let r = so3::matrix(q);
    [
        so3::log(&r),
        so3::log_quaternion(q),
        so3::continuous_log(&r, ZERO).phi,
        so3::continuous_log_quaternion(q, ZERO).phi,
    ]
}

#[test]
fn every_dual_number_passes_through_zero_unchanged() {
    let (a, b, c) = ([1.0, -2.0, 0.5], [0.25, 3.0, -1.0], [0.0, 1.0, 2.0]);
    for phi in there_and_back([0, 1, 2].map(|i| Dual::new(0.0, a[i]))) {
        assert_eq!(phi.map(|p| (p.re, p.eps)), a.map(|a| (0.0, a)));
    }
    for phi in there_and_back([0, 1, 2].map(|i| Dual2::new(0.0, a[i], b[i]))) {
        assert_eq!(phi.map(|p| (p.re, p.v1, p.v2)), [0, 1, 2].map(|i| (0.0, a[i], b[i])));
    }
    for phi in there_and_back([0, 1, 2].map(|i| Dual3::new(0.0, a[i], b[i], c[i]))) {
        assert_eq!(phi.map(|p| (p.re, p.v1, p.v2)), [0, 1, 2].map(|i| (0.0, a[i], b[i])));
        for (p, c) in phi.iter().zip(c) {
            assert!((p.v3 - c).abs() < 1e-14, "{} for {c}", p.v3);
        }
    }
    for phi in there_and_back([0, 1, 2].map(|i| HyperDual::new(0.0, a[i], b[i], c[i]))) {
        let parts = phi.map(|p| (p.re, p.eps1, p.eps2, p.eps1eps2));
        assert_eq!(parts, [0, 1, 2].map(|i| (0.0, a[i], b[i], c[i])));
    }
    let seeded: [DualSVec<f64, 3>; 3] = [0, 1, 2].map(|i| DualSVec::from_re(0.0).derivative(i));
    for phi in there_and_back(seeded) {
        for (i, p) in phi.iter().enumerate() {
            let gradient = p.eps.unwrap_generic(nalgebra::Const::<3>, nalgebra::Const::<1>);
            assert_eq!(gradient.as_slice(), &[delta(i, 0), delta(i, 1), delta(i, 2)]);
        }
    }
    for phi in
        there_and_back([0, 1, 2].map(|i| {
            Dual2::new(Dual2::new(0.0, a[i], 0.0), Dual2::new(b[i], c[i], 0.0), Dual2::from_re(0.0))
        }))
    {
        let parts = phi.map(|p| (p.re.v1, p.v1.re, p.v1.v1));
        assert_eq!(parts, [0, 1, 2].map(|i| (a[i], b[i], c[i])));
    }
}
