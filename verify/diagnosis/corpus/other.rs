//! Other formulas: small motions, increments, lengths and Jacobians that are not meant, fewer digits.

use super::{ACC, DDF, DF, F, FORCE, RATE, Right, STIFF, Wrong, each, one, part, put, relative, row};
use pintle_audit::Numbers;
use pintle_kinematics::connector::State;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{add, apply, cross, dot, product, scale, sub, transpose};

/// The state before: numbers there.
fn at_rest(right: &Right<'_>) -> Numbers<f64> {
    let still = State { pair: *right.initial(), velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
    (right.at)(&still)
}

/// By forward differences of the right values, with a step.
fn differenced(right: &Right<'_>, numbers: &mut Numbers<f64>, step: f64) {
    for j in (0..3).chain(7..10) {
        let mut state = *right.state;
        let node = if j < 7 { &mut state.pair.a } else { &mut state.pair.b };
        node.displacement[j % 7] += step;
        let moved = (right.at)(&state);
        for k in 0..6 {
            let change = moved.entries(F).get(k, 0).unwrap_or(0.0) - right.of(F, k, 0);
            row(numbers, DF, k, |row| row[j] = change / step);
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "that is the mistake")]
fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("LINK", "the length of u_b − u_a"),
        &[F],
        |right, numbers| one(numbers, F, (0, 0), |_| norm(sub(right.d(), right.initial().separation()))),
        (&["diagnosis::other-length"], "u1"),
    ),
    Wrong::new(
        ("AXIAL", "the strain of Green times the length"),
        &[F],
        |right, numbers| {
            let (d, d0) = (right.d(), right.initial().separation());
            one(numbers, F, (0, 0), |_| (dot(d, d) - dot(d0, d0)) / (2.0 * norm(d0)));
        },
        (&["diagnosis::other-length"], "u1"),
    ),
    Wrong::new(
        ("SLIPRING", "the logarithmic strain"),
        &[F],
        |right, numbers| one(numbers, F, (0, 0), |_| right.of(F, 0, 0).ln_1p()),
        (&["diagnosis::other-length"], "u1"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "the distance of the nodes for that from the axis"),
        &[F],
        |right, numbers| one(numbers, F, (0, 0), |_| norm(right.d()) - norm(right.initial().separation())),
        (&["diagnosis::other-length"], "u1"),
    ),
    Wrong::new(
        ("REVOLUTE", "the printed constraint e1a·e3b for the second angle"),
        &[F],
        |right, numbers| {
            let q0 = relative(right.initial());
            one(numbers, F, (4, 0), |_| right.q()[0][2] - q0[0][2]);
        },
        (&["diagnosis::other-parameters"], "ur2"),
    ),
    Wrong::new(
        ("SLOT", "small displacements: along the initial axes, lever and all"),
        &[F],
        |right, numbers| {
            let rest = at_rest(right);
            let (now, first) = (right.pair(), right.initial());
            let turned = |now, then| so3::log(&product(now, &transpose(then)));
            let mut q = [0.0; DOFS];
            put(&mut q, 0, now.a.displacement);
            put(&mut q, 3, turned(&now.a.triad, &first.a.triad));
            put(&mut q, 7, now.b.displacement);
            put(&mut q, 10, turned(&now.b.triad, &first.b.triad));
            each(numbers, F, |k, _, _| (0..DOFS).map(|j| rest.entries(DF).get(k, j).unwrap() * q[j]).sum());
        },
        (&["diagnosis::linearised"], "u1"),
    ),
    Wrong::new(
        ("CARDAN", "the change since the state before"),
        &[F],
        |right, numbers| each(numbers, F, |k, _, x| x - right.values_before[k].unwrap()),
        (&["diagnosis::increment"], "ur1"),
    ),
    Wrong::new(
        ("BUSHING", "single precision"),
        &[F],
        |_, numbers| each(numbers, F, |_, _, x| single(x)),
        (&["diagnosis::single-precision"], "u1"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "rows read from a file with 24 bits"),
        &[F, DF],
        |_, numbers| each(numbers, DF, |_, _, x| single(x)),
        (&["diagnosis::single-precision"], "∂u1"),
    ),
    Wrong::new(
        ("AXIAL", "rows of d, not of d/|d|"),
        &[F, DF],
        |right, numbers| {
            row(numbers, DF, 0, |row| {
                put(row, 0, scale(right.d(), -1.0));
                put(row, 7, right.d());
            });
        },
        (&["diagnosis::not-normalised"], "∂u1"),
    ),
    Wrong::new(
        ("CARDAN", "no division by cos β"),
        &[F, DF],
        |right, numbers| {
            let cosine = (1.0 - right.q()[0][2].powi(2)).sqrt();
            for k in [3, 5] {
                row(numbers, DF, k, |row| row.iter_mut().for_each(|x| *x *= cosine));
            }
        },
        (&["diagnosis::not-normalised"], "∂ur1"),
    ),
    Wrong::new(
        ("LINK", "the force along d, not along d/|d|"),
        &[FORCE],
        |right, numbers| {
            row(numbers, FORCE, 0, |row| {
                put(row, 0, scale(right.d(), -1.0));
                put(row, 7, right.d());
            });
        },
        (&["diagnosis::not-normalised"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("ROTATION", "the Jacobian of the rotation vector not inverted"),
        &[F, DF],
        |right, numbers| {
            let jacobian = so3::left_jacobian(so3::log(&right.q()));
            for i in 0..3 {
                let g = apply(&right.pair().a.triad, jacobian[i]);
                row(numbers, DF, 3 + i, |row| {
                    put(row, 3, scale(g, -1.0));
                    put(row, 10, g);
                });
            }
        },
        (&["diagnosis::other-jacobian"], "∂ur1"),
    ),
    Wrong::new(
        ("CARTESIAN", "forward differences with a step of 1e-6"),
        &[F, DF],
        |right, numbers| differenced(right, numbers, 1e-6),
        (&["diagnosis::differences"], "∂u1"),
    ),
    Wrong::new(
        ("JOIN", "e_a·(a_b − a_a) formed with velocities"),
        &[ACC],
        |right, numbers| {
            let [v, _] = right.rates();
            each(numbers, ACC, |k, _, _| (0..DOFS).map(|j| right.of(DF, k, j) * v[j]).sum());
        },
        (&["diagnosis::rate-for-acceleration"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("EULER", "rates formed with the accelerations"),
        &[RATE],
        |right, numbers| {
            let [_, a] = right.rates();
            each(numbers, RATE, |k, _, _| (0..DOFS).map(|j| right.of(DF, k, j) * a[j]).sum());
        },
        (&["diagnosis::rate-for-acceleration"], "dur1/dt"),
    ),
    Wrong::new(
        ("FLOW-CONVERTER", "the matrix made symmetric"),
        &[DDF],
        |right, numbers| {
            each(numbers, DDF, |k, n, x| (x + right.of(DDF, k, n % DOFS * DOFS + n / DOFS)) / 2.0);
        },
        (&["diagnosis::symmetrised"], "∂²ur3"),
    ),
    Wrong::new(
        ("REVOLUTE", "a stiffness made symmetric for the solver"),
        &[STIFF],
        |right, numbers| {
            each(numbers, STIFF, |k, n, x| (x + right.of(STIFF, k, n % DOFS * DOFS + n / DOFS)) / 2.0);
        },
        (&["diagnosis::symmetrised"], "stiffness of ur2"),
    ),
    Wrong::new(
        ("SLOT", "the force at the middle between the nodes: half of the lever at each"),
        &[FORCE],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, FORCE, k, |row| {
                    let lever = scale(cross(part(row, 7), right.d()), 0.5);
                    let (of_a, of_b) = (part(row, 3), part(row, 10));
                    put(row, 3, sub(of_a, lever));
                    put(row, 10, add(of_b, lever));
                });
            }
        },
        (&["diagnosis::lever-at-b"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("PLANAR", "u2 and u3 exchanged, one with the opposite sign"),
        &[DF],
        |_, numbers| {
            numbers.entries_mut(DF).0.swap(1, 2);
            row(numbers, DF, 2, |row| row.iter_mut().for_each(|x| *x = -*x));
        },
        (&["diagnosis::components-swapped"], "∂u2, ∂u3"),
    ),
    Wrong::new(
        ("AXIAL", "(1 − q qᵀ) without the division by |d|"),
        &[DDF],
        |right, numbers| each(numbers, DDF, |_, _, x| x * norm(right.d())),
        (&["diagnosis::not-normalised"], "∂²u1"),
    ),
    Wrong::new(
        ("SLIPRING", "the belt's flow left out"),
        &[F],
        |right, numbers| {
            one(numbers, F, (0, 0), |_| norm(right.d()) / norm(right.initial().reference) - 1.0);
        },
        (&["diagnosis::motion-ignored"], "u1"),
    ),
    Wrong::new(
        ("CONSTANT VELOCITY", "the third Cardan angle for the torsion"),
        &[F],
        |right, numbers| one(numbers, F, (4, 0), |_| (-right.q()[0][1]).atan2(right.q()[0][0])),
        (&["diagnosis::other-order"], "ur2"),
    ),
    Wrong::new(
        ("ROTATION", "the rotation vector of Q Q₀ᵀ for the difference"),
        &[F],
        |right, numbers| {
            let q0 = relative(right.initial());
            let phi = so3::log(&product(&right.q(), &transpose(&q0)));
            each(numbers, F, |k, _, _| phi[k - 3]);
        },
        (&["diagnosis::other-parameters"], "ur1"),
    ),
    Wrong::new(
        ("BEAM", "log Q: what the directions differ by initially is ignored"),
        &[F],
        |right, numbers| {
            let phi = so3::log(&right.q());
            for k in 3..6 {
                one(numbers, F, (k, 0), |_| phi[k - 3]);
            }
        },
        (&["diagnosis::initial-value-kept"], "ur1"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "the row of e1a for that of the radial direction"),
        &[DF],
        |right, numbers| {
            row(numbers, DF, 0, |row| {
                put(row, 0, scale(right.a(0), -1.0));
                put(row, 3, cross(right.a(0), right.d()));
                put(row, 7, right.a(0));
            });
        },
        (&["diagnosis::other-length"], "∂u1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "the moments of both nodes at a"),
        &[F, DF],
        |_, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    put(row, 3, add(part(row, 3), part(row, 10)));
                    put(row, 10, [0.0; 3]);
                });
            }
        },
        (&["diagnosis::lever-at-b"], "∂u1"),
    ),
    Wrong::new(
        ("ACCELEROMETER", "accelerations along the axes of a"),
        &[ACC],
        |right, numbers| {
            let [_, a] = right.rates();
            each(numbers, ACC, |k, _, _| dot(right.a(k), sub(part(&a, 7), part(&a, 0))));
        },
        (&["diagnosis::axes-of-a"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("ROTATION-ACCELEROMETER", "ω_b alone"),
        &[RATE],
        |right, numbers| {
            let [v, _] = right.rates();
            each(numbers, RATE, |k, _, _| dot(right.b(k - 3), part(&v, 10)));
        },
        (&["diagnosis::rates-of-a-ignored"], "dur1/dt"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "an identity left over in the stiffness of a"),
        &[STIFF],
        |_, numbers| {
            each(numbers, STIFF, |_, n, x| if n / DOFS == n % DOFS && n % DOFS < 3 { x + 1.0 } else { x })
        },
        (&["diagnosis::offset", "diagnosis::spurious"], "stiffness of ur1"),
    ),
];
