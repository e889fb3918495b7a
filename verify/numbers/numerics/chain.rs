//! The whole way from two moving nodes to the relative rotation vector and its rates.
//!
//! Node a moves as q_a(t), node b as q_b = q_a exp(ρ(t)) with ρ(t) = r₀ + r₁t + r₂t²/2 + …: what comes out is known exactly.
//! Errors are absolute, in u, over the size of the terms of each order: 1, |r₁|, |r₂| + |r₁|², and so on as in the chain rule
//! for the exponential.

use super::grid::Stream;
use super::{U, Worst, assert_gates};
use num_dual::{Dual2, Dual3};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Connector, Definition, Increment, Output, Request, State, Tally};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::Vector;
use std::f64::consts::PI;

/// The derivatives of a moving quantity, from the value up.
type Taylor<const N: usize> = [Vector<f64>; N];

/// How the relative rotation vector is formed from the two orientations.
#[derive(Clone, Copy)]
enum Route {
    /// log(q_a* q_b).
    Quaternion,
    /// log(AᵀB).
    Matrix,
}

/// φ of the two nodes, on the sheet of `reference`.
fn relative<S: Scalar<Real = f64>>(
    route: Route,
    a: Vector<S>,
    rho: Vector<S>,
    reference: Vector<f64>,
) -> Vector<S> {
    let qa = so3::exp_quaternion(a);
    let qb = so3::compose(qa, so3::exp_quaternion(rho));
    match route {
        Route::Quaternion => {
            so3::continuous_log_quaternion(so3::compose(so3::conjugate(qa), qb), reference).phi
        }
        Route::Matrix => {
            let q = vector::transposed_product(&so3::matrix(qa), &so3::matrix(qb));
            so3::continuous_log(&q, reference).phi
        }
    }
}

fn size(v: Vector<f64>) -> f64 {
    vector::dot(v, v).sqrt()
}

/// Angles from 0 to half a turn and as near to it as a double comes.
fn angles() -> Vec<f64> {
    let mut angles = vec![0.0, 0.3, 0.7, 1.0, 1.5, 1.8, 2.0, 2.5, 3.0, PI];
    angles.extend((1..=16).map(|k| 10f64.powi(-k)));
    angles.extend((1..=15).map(|k| PI - 10f64.powi(-k)));
    angles
}

/// Random motions: ρ with the given |r₀|, and that of node a, the rates of both of one size: |r_k| = |a_k| = rate^k.
fn motions<const N: usize>(seed: u64, count: usize) -> impl Iterator<Item = (Taylor<N>, Taylor<N>)> {
    let mut stream = Stream(seed);
    angles().into_iter().flat_map(move |angle| {
        let motions: Vec<_> = (0..count)
            .map(|_| {
                let rate = 10f64.powf(stream.between(-1.0, 1.0));
                let mut motion = |start: f64| -> Taylor<N> {
                    std::array::from_fn(|k| {
                        let v = stream.vector();
                        let wanted = if k == 0 { start } else { rate.powi(k as i32) };
                        vector::scale(v, wanted / size(v))
                    })
                };
                let of_a = motion(2.5);
                let rho = motion(angle);
                (of_a, rho)
            })
            .collect();
        motions
    })
}

fn note(worst: &mut Worst, order: usize, computed: Vector<f64>, exact: Vector<f64>, scale: f64, angle: f64) {
    for i in 0..3 {
        worst.note(order, (computed[i] - exact[i]).abs() / (U * scale), || format!("angle {angle:e}"));
    }
}

/// The axial vector of m.
fn axial(m: &vector::Matrix<Wide>) -> Vector<Wide> {
    let half = Wide::ratio(1, 2);
    [(m[2][1] - m[1][2]) * half, (m[0][2] - m[2][0]) * half, (m[1][0] - m[0][1]) * half]
}

/// Triad, angular velocity and angular acceleration of a node with the orientation q(t), each rounded.
fn node_state(q: so3::Quaternion<Dual2<Wide>>) -> (vector::Matrix<f64>, Vector<f64>, Vector<f64>) {
    let r = so3::matrix(q);
    let triad = r.map(|row| row.map(|x| x.re));
    let back = vector::transpose(&triad);
    let spin = |part: fn(&Dual2<Wide>) -> Wide| {
        axial(&vector::product(&r.map(|row| row.map(|x| part(&x))), &back)).map(Wide::to_f64)
    };
    (triad.map(|row| row.map(Wide::to_f64)), spin(|x| x.v1), spin(|x| x.v2))
}

/// CP, CV and CA of a ROTATION connector between the two nodes.
fn connector_rates(of_a: Taylor<3>, rho: Taylor<3>) -> [Vector<f64>; 3] {
    let moving = |x: Taylor<3>| -> Vector<Dual2<Wide>> {
        std::array::from_fn(|i| Dual2::new(x[0][i].into(), x[1][i].into(), x[2][i].into()))
    };
    let qa = so3::exp_quaternion(moving(of_a));
    let nodes = [node_state(qa), node_state(so3::compose(qa, so3::exp_quaternion(moving(rho))))];
    let at = |triad: vector::Matrix<f64>| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let pair = |a, b| Pair { reference: [0.0; 3], a: at(a), b: at(b) };
    // Nodal rates are in the order x (3), θ (3), Ψ of a, then of b.
    let (mut velocity, mut acceleration) = ([0.0; DOFS], [0.0; DOFS]);
    for (start, (_, omega, alpha)) in [3, 10].into_iter().zip(nodes) {
        velocity[start..start + 3].copy_from_slice(&omega);
        acceleration[start..start + 3].copy_from_slice(&alpha);
    }
    let aligned = vector::identity();
    let definition =
        Definition::new(ConnectionType::named("ROTATION", None).unwrap(), pair(aligned, aligned));
    let connector = Connector::<f64>::new(&definition);
    let mut branch = connector.initial_branch();
    branch.rotation_vector = rho[0];
    let evaluation = connector.evaluate(
        &State { pair: pair(nodes[0].0, nodes[1].0), velocity, acceleration },
        &Increment::none(),
        &branch,
        &Request::new(&[Output::CP, Output::CV, Output::CA], [false, false, false, true, true, true], 0),
        &mut Tally::default(),
    );
    [evaluation.position, evaluation.velocity, evaluation.acceleration]
        .map(|c| [3, 4, 5].map(|k| c[k].unwrap()))
}

/// As the product does it: from rounded triads and angular rates to the rotation vector and its rates.
#[test]
fn rotation_connector() {
    let mut worst = Worst::new("ROTATION connector");
    for (of_a, rho) in motions::<3>(13, 30) {
        let computed = connector_rates(of_a, rho);
        let (r1, r2) = (size(rho[1]), size(rho[2]));
        for (order, scale) in [1.0, r1, r2 + r1 * r1].into_iter().enumerate() {
            note(&mut worst, order, computed[order], rho[order], scale, size(rho[0]));
        }
    }
    assert_gates("ROTATION connector", &[worst], &[]);
}

#[test]
fn two_moving_nodes() {
    let routes = [(Route::Quaternion, "chain of quaternions"), (Route::Matrix, "chain of matrices")];
    let measured = routes.map(|(route, name)| {
        let mut worst = Worst::new(name);
        for (of_a, rho) in motions::<3>(11, 200) {
            let moving = |x: Taylor<3>| -> Vector<Dual2<f64>> {
                std::array::from_fn(|i| Dual2::new(x[0][i], x[1][i], x[2][i]))
            };
            let phi = relative(route, moving(of_a), moving(rho), rho[0]);
            let (r1, r2) = (size(rho[1]), size(rho[2]));
            let angle = size(rho[0]);
            note(&mut worst, 0, phi.map(|p| p.re), rho[0], 1.0, angle);
            note(&mut worst, 1, phi.map(|p| p.v1), rho[1], r1, angle);
            note(&mut worst, 2, phi.map(|p| p.v2), rho[2], r2 + r1 * r1, angle);
        }
        worst
    });
    assert_gates("two moving nodes", &measured, &[]);
}

/// Third derivatives through `Dual3`, fourth through `Dual2` of `Dual2`.
#[test]
fn jerk_and_beyond() {
    let routes = [(Route::Quaternion, "jerk, quaternions"), (Route::Matrix, "jerk, matrices")];
    let measured = routes.map(|(route, name)| {
        let mut worst = Worst::new(name);
        for (of_a, rho) in motions::<5>(12, 60) {
            let [r1, r2, r3, r4] = [1, 2, 3, 4].map(|k| size(rho[k]));
            let angle = size(rho[0]);
            let third = |x: Taylor<5>| -> Vector<Dual3<f64>> {
                std::array::from_fn(|i| Dual3::new(x[0][i], x[1][i], x[2][i], x[3][i]))
            };
            let phi = relative(route, third(of_a), third(rho), rho[0]);
            let scale = r3 + 3.0 * r1 * r2 + r1.powi(3);
            note(&mut worst, 0, phi.map(|p| p.v3), rho[3], scale, angle);

            // f(s + t): every further order in s beside every order in t.
            let fourth = |x: Taylor<5>| -> Vector<Dual2<Dual2<f64>>> {
                let inner = |k: usize, i: usize| Dual2::new(x[k][i], x[k + 1][i], x[k + 2][i]);
                std::array::from_fn(|i| Dual2::new(inner(0, i), inner(1, i), inner(2, i)))
            };
            let phi = relative(route, fourth(of_a), fourth(rho), rho[0]);
            let scale = r4 + 4.0 * r1 * r3 + 3.0 * r2 * r2 + 6.0 * r1 * r1 * r2 + r1.powi(4);
            note(&mut worst, 1, phi.map(|p| p.v2.v2), rho[4], scale, angle);
            note(&mut worst, 2, phi.map(|p| p.v1.v1), rho[2], r2 + r1 * r1, angle);
        }
        worst
    });
    assert_gates("third and fourth derivative, and the second among them", &measured, &[]);
}
