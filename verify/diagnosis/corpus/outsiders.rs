//! Routines of a second reader who had not seen the causes, as far as the check did not name them, or named them misleadingly.

use super::{ACC, DDF, DF, F, RATE, Right, Wrong, continued, each, one, put, relative, row};
use pintle_kinematics::node::{DOFS, Node, Pair, THETA_A, THETA_B, XB};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3::{self, exp};
use pintle_kinematics::vector::{
    Matrix, Vector, apply, apply_transposed, column, cross, dot, product, scale, skew, sub, transpose,
};

/// The rotation vector of a node since the initial state.
fn total(now: &Node<f64>, first: &Node<f64>) -> Vector<f64> {
    so3::log(&product(&now.triad, &transpose(&first.triad)))
}

/// The right numbers at nodes whose rotations are read otherwise.
fn read_as(right: &Right<'_>, read: fn(Vector<f64>) -> Matrix<f64>) -> pintle_audit::Numbers<f64> {
    let initial = right.initial();
    let mut state = *right.state;
    for (node, first) in [(&mut state.pair.a, &initial.a), (&mut state.pair.b, &initial.b)] {
        node.triad = product(&read(total(node, first)), &first.triad);
    }
    (right.at)(&state)
}

/// How far b is turned against a.
fn angle(right: &Right<'_>) -> f64 {
    norm(so3::log(&right.q()))
}

/// The row of component i of the rotation vector by an inverse Jacobian 1 − φ^/2 + c φ^².
fn by_coefficient(right: &Right<'_>, i: usize, of: fn(f64) -> f64) -> Vector<f64> {
    let phi = so3::log(&right.q());
    let hat = skew(phi);
    let square = product(&hat, &hat);
    let c = of(norm(phi));
    let line = [0, 1, 2].map(|j| f64::from(u8::from(i == j)) - hat[i][j] / 2.0 + c * square[i][j]);
    apply(&right.pair().a.triad, line)
}

fn turning(row: &mut [f64], gradient: Vector<f64>) {
    put(row, THETA_A, scale(gradient, -1.0));
    put(row, THETA_B, gradient);
}

#[expect(clippy::cast_possible_truncation, reason = "the mistake")]
fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("AXIAL", "the logarithm of the stretch times the initial length"),
        &[F],
        |right, numbers| {
            let (l, l0) = (norm(right.d()), norm(right.initial().separation()));
            one(numbers, F, (0, 0), |_| l0 * (l / l0).ln());
        },
        (&["diagnosis::other-length"], "x₀ ln(x/x₀)"),
    ),
    Wrong::new(
        ("AXIAL", "the logarithm times the initial length, its row"),
        &[F, DF],
        |right, numbers| {
            let (l, l0) = (norm(right.d()), norm(right.initial().separation()));
            one(numbers, F, (0, 0), |_| l0 * (l / l0).ln());
            row(numbers, DF, 0, |row| row.iter_mut().for_each(|x| *x *= l0 / l));
        },
        (&["diagnosis::other-length", "diagnosis::not-normalised"], "u1"),
    ),
    Wrong::new(
        ("CARDAN", "angles of the rotation since the initial state"),
        &[F],
        |right, numbers| {
            let since = product(&right.q(), &transpose(&relative(right.initial())));
            let angles = so3::cardan(&since);
            each(numbers, F, |k, _, x| continued(angles[k - 3], x));
        },
        (&["diagnosis::other-order", "diagnosis::other-parameters"], "Q Q₀ᵀ"),
    ),
    Wrong::new(
        ("CARDAN", "angles along the global axes"),
        &[F],
        |right, numbers| {
            let of = |pair: &Pair<f64>| so3::cardan(&product(&pair.b.triad, &transpose(&pair.a.triad)));
            let (now, first) = (of(right.pair()), of(right.initial()));
            each(numbers, F, |k, _, _| now[k - 3] - first[k - 3]);
        },
        (&["diagnosis::global-axes"], "ur1"),
    ),
    Wrong::new(
        ("EULER", "the other three angles of the rotation"),
        &[F],
        |right, numbers| {
            let (now, first) = (so3::euler(&right.q(), -1.0), so3::euler(&relative(right.initial()), 1.0));
            each(numbers, F, |k, _, _| now[k - 3] - first[k - 3]);
        },
        (&["diagnosis::other-order"], "ur2"),
    ),
    Wrong::new(
        ("ROTATION", "Cardan angles for the rotation vector"),
        &[F],
        |right, numbers| {
            let (now, first) = (so3::cardan(&right.q()), so3::cardan(&relative(right.initial())));
            each(numbers, F, |k, _, _| now[k - 3] - first[k - 3]);
        },
        (&["diagnosis::other-order", "diagnosis::other-parameters"], "ur1"),
    ),
    Wrong::new(
        ("HINGE", "displacements along the global axes"),
        &[F],
        |right, numbers| {
            let moved = sub(right.d(), right.initial().separation());
            each(numbers, F, |k, _, x| if k < 3 { moved[k] } else { x });
        },
        (&["diagnosis::global-axes", "diagnosis::initial-separation-turned"], "u1"),
    ),
    Wrong::new(
        ("CARTESIAN", "along the axes of a at the state before"),
        &[F],
        |right, numbers| {
            let before = right.path.last().map_or(right.initial(), |step| &step.state.pair);
            let (now, first) = (
                apply_transposed(&before.a.triad, right.d()),
                apply_transposed(&right.initial().a.triad, right.initial().separation()),
            );
            each(numbers, F, |k, _, _| now[k] - first[k]);
        },
        (&["diagnosis::state-before", "diagnosis::initial-axes"], "u1"),
    ),
    Wrong::new(
        ("UNIVERSAL", "rotations of nodes read as three angles"),
        &[F],
        |right, numbers| {
            *numbers = read_as(right, |phi| {
                let about = |i: usize| exp([0, 1, 2].map(|j| if i == j { phi[j] } else { 0.0 }));
                product(&about(2), &product(&about(1), &about(0)))
            });
        },
        (&["diagnosis::other-parameters"], "angles about"),
    ),
    Wrong::new(
        ("CARTESIAN", "triads turned by 1 + φ^"),
        &[F],
        |right, numbers| {
            *numbers = read_as(right, |phi| {
                let hat = skew(phi);
                [0, 1, 2].map(|i| [0, 1, 2].map(|j| hat[i][j] + f64::from(u8::from(i == j))))
            });
        },
        (&["diagnosis::other-parameters", "diagnosis::linearised"], "1 + φ^"),
    ),
    Wrong::new(
        ("AXIAL", "a root that is smooth at zero, its row too"),
        &[F, DF],
        |right, numbers| {
            let of = |x: f64| x.mul_add(x, 1e-6).sqrt();
            let (l, l0) = (norm(right.d()), norm(right.initial().separation()));
            one(numbers, F, (0, 0), |_| of(l) - of(l0));
            row(numbers, DF, 0, |row| row.iter_mut().for_each(|x| *x *= l / of(l)));
        },
        (&["diagnosis::regularised"], "ε = 0.001"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "a millionth added to a divisor"),
        &[DF],
        |right, numbers| {
            let along = apply_transposed(&right.pair().a.triad, right.d());
            let r = along[0].hypot(along[1]);
            row(numbers, DF, 0, |row| row.iter_mut().for_each(|x| *x *= r / (r + 1e-6)));
        },
        (&["diagnosis::regularised"], "l/(l + ε)"),
    ),
    Wrong::new(
        ("UNIVERSAL", "no rotation beside half a turn"),
        &[F],
        |right, numbers| {
            let angle = so3::cardan_first(&right.q());
            if (angle.abs() - std::f64::consts::PI).abs() < 0.012 {
                one(numbers, F, (3, 0), |_| 0.0);
            }
        },
        (&["diagnosis::near-only", "diagnosis::component-zero"], "ur1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "half of the moment on each node"),
        &[DF],
        |right, numbers| {
            for i in 0..3 {
                let d = right.d();
                row(numbers, DF, i, |row| {
                    let lever = scale(cross([row[XB], row[XB + 1], row[XB + 2]], d), 0.5);
                    put(row, THETA_A, lever);
                    put(row, THETA_B, lever);
                });
            }
        },
        (&["diagnosis::lever-at-b"], "∂u1"),
    ),
    Wrong::new(
        ("AXIAL", "no row where the nodes are near each other"),
        &[DF],
        |right, numbers| {
            if norm(right.d()) < 1e-3 {
                row(numbers, DF, 0, |row| row.fill(0.0));
            }
        },
        (&["diagnosis::near-only"], "∂u1"),
    ),
    Wrong::new(
        ("AXIAL", "a divisor of at least 1e-3"),
        &[DF],
        |right, numbers| {
            let l = norm(right.d());
            row(numbers, DF, 0, |row| row.iter_mut().for_each(|x| *x *= l / l.max(1e-3)));
        },
        (&["diagnosis::near-only"], "∂u1"),
    ),
    Wrong::new(
        ("ROTATION", "the row of a small rotation up to 1e-2"),
        &[DF],
        |right, numbers| {
            if angle(right) < 1e-2 {
                for i in 0..3 {
                    let gradient = by_coefficient(right, i, |_| 0.1);
                    row(numbers, DF, 3 + i, |row| turning(row, gradient));
                }
            }
        },
        (&["diagnosis::near-only"], "∂ur1"),
    ),
    Wrong::new(
        ("ALIGN", "the axial vector of a small rotation"),
        &[F],
        |right, numbers| {
            let q0 = relative(right.initial());
            let phi = so3::log(&product(&right.q(), &transpose(&q0)));
            let length = norm(phi);
            if length < 0.05 {
                each(numbers, F, |_, _, x| x * length.sin() / length.max(1e-300));
            }
        },
        (&["diagnosis::near-only"], "ur1"),
    ),
    Wrong::new(
        ("ROTATION", "cot θ for cot(θ/2)"),
        &[DF],
        |right, numbers| {
            for i in 0..3 {
                let of = |t: f64| (1.0 - t / 2.0 / t.tan()) / (t * t);
                let gradient = by_coefficient(right, i, of);
                row(numbers, DF, 3 + i, |row| turning(row, gradient));
            }
        },
        (&["diagnosis::other-jacobian"], "∂ur1"),
    ),
    Wrong::new(
        ("ROTATION", "1/12 at any angle"),
        &[DF],
        |right, numbers| {
            for i in 0..3 {
                let gradient = by_coefficient(right, i, |_| 1.0 / 12.0);
                row(numbers, DF, 3 + i, |row| turning(row, gradient));
            }
        },
        (&["diagnosis::other-jacobian"], "∂ur1"),
    ),
    Wrong::new(
        ("AXIAL", "the second derivatives times l/l₀"),
        &[DDF],
        |right, numbers| {
            let factor = norm(right.d()) / norm(right.initial().separation());
            each(numbers, DDF, |_, _, x| factor * x);
        },
        (&["diagnosis::not-normalised"], "∂²u1"),
    ),
    Wrong::new(
        ("CARTESIAN", "a plus for a minus in a cross product"),
        &[DF],
        |right, numbers| {
            let (g, d) = (right.a(0), right.d());
            one(numbers, DF, (0, THETA_A + 1), |_| g[2] * d[0] + g[0] * d[2]);
        },
        (&["diagnosis::geometric-term-reversed"], "∂u1/∂θa2"),
    ),
    Wrong::new(
        ("CARTESIAN", "positions in single precision"),
        &[F],
        |right, numbers| {
            let d = right.d().map(single);
            let now = apply_transposed(&right.pair().a.triad, d);
            let first = apply_transposed(&right.initial().a.triad, right.initial().separation());
            each(numbers, F, |k, _, _| now[k] - first[k]);
        },
        (&["diagnosis::single-precision"], "u1"),
    ),
    Wrong::new(
        ("REVOLUTE", "an entry of Q mistyped"),
        &[F],
        |right, numbers| {
            let of = |q: &Matrix<f64>| (-q[1][2]).atan2(q[1][1]);
            let mine = of(&right.q()) - of(&relative(right.initial()));
            one(numbers, F, (3, 0), |_| mine);
        },
        (&["diagnosis::other-parameters", "diagnosis::other-order"], "ur1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "the strain of the coordinate"),
        &[F],
        |right, numbers| {
            let half = |pair: &Pair<f64>| {
                let sum: Vector<f64> =
                    [0, 1, 2].map(|i| column(&pair.a.triad, 0)[i] + column(&pair.b.triad, 0)[i]);
                dot(scale(sum, 1.0 / norm(sum)), pair.separation())
            };
            let (now, first) = (half(right.pair()), half(right.initial()));
            one(numbers, F, (0, 0), |_| (now - first) / first);
        },
        (&["diagnosis::other-length"], "(x − x₀)/x₀"),
    ),
    Wrong::new(
        ("HINGE", "the sine of the angle, with its row and rate"),
        &[F, DF, RATE],
        |right, numbers| {
            let (now, first) = (so3::cardan_first(&right.q()), so3::cardan_first(&relative(right.initial())));
            one(numbers, F, (3, 0), |_| now.sin() - first.sin());
            row(numbers, DF, 3, |row| row.iter_mut().for_each(|x| *x *= now.cos()));
            one(numbers, RATE, (3, 0), |x| x * now.cos());
        },
        (&["diagnosis::other-parameters", "diagnosis::not-normalised"], "ur1"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "half the square of the radius, with its acceleration"),
        &[F, ACC],
        |right, numbers| {
            let radius = |pair: &Pair<f64>| {
                let along = apply_transposed(&pair.a.triad, pair.separation());
                along[0].hypot(along[1])
            };
            let (now, first) = (radius(right.pair()), radius(right.initial()));
            one(numbers, F, (0, 0), |_| (now * now - first * first) / 2.0);
            let rate = right.of(RATE, 0, 0);
            one(numbers, ACC, (0, 0), |x| now * x + rate * rate);
        },
        (&["diagnosis::other-length"], "u1"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "rows along the axes of b, moments too"),
        &[DF],
        |right, numbers| {
            for i in 0..3 {
                let e = right.b(i);
                let lever = cross(e, right.d());
                row(numbers, DF, i, |row| {
                    if row[..XB].iter().any(|x| *x != 0.0) {
                        put(row, 0, scale(e, -1.0));
                        put(row, XB, e);
                        put(row, THETA_A, [0.0; 3]);
                        put(row, THETA_B, lever);
                    }
                });
            }
        },
        (&["diagnosis::axes-of-b"], "u2"),
    ),
    Wrong::new(
        ("WELD", "rotation vector of A Bᵀ"),
        &[F],
        |right, numbers| {
            let of = |pair: &Pair<f64>| so3::log(&product(&pair.a.triad, &transpose(&pair.b.triad)));
            let (now, first) = (of(right.pair()), of(right.initial()));
            each(numbers, F, |k, _, x| if k >= 3 { now[k - 3] - first[k - 3] } else { x });
        },
        (&["diagnosis::global-axes"], "ur1"),
    ),
    Wrong::new(
        ("CARDAN", "∇α without −sin β e3b"),
        &[DF],
        |right, numbers| {
            let axis = column(&right.pair().a.triad, 0);
            let cosine = 1.0 - right.q()[0][2].powi(2);
            row(numbers, DF, 3, |row| turning(row, scale(axis, 1.0 / cosine)));
        },
        (&["diagnosis::term-left-out"], "equals what is expected without its term along e3b"),
    ),
    Wrong::new(
        ("AXIAL", "l̈ without −l̇²/l"),
        &[ACC],
        |right, numbers| {
            let rate = right.of(RATE, 0, 0);
            one(numbers, ACC, (0, 0), |x| x + rate * rate / norm(right.d()));
        },
        (&["diagnosis::coriolis"], "without −ẋ²/x"),
    ),
    Wrong::new(
        ("ROTATION", "an acceleration without the product of the spins"),
        &[ACC],
        |right, numbers| {
            let [v, _] = right.rates();
            let quadratic = |of_a: f64, relative: f64| {
                let mut state = *right.state;
                (state.velocity, state.acceleration) = ([0.0; DOFS], [0.0; DOFS]);
                for i in THETA_A..THETA_A + 3 {
                    state.velocity[i] = of_a * v[i];
                    state.velocity[i + XB] = of_a * v[i] + relative * (v[i + XB] - v[i]);
                }
                (right.at)(&state)
            };
            let [all, together, apart] = [quadratic(1.0, 1.0), quadratic(1.0, 0.0), quadratic(0.0, 1.0)];
            let of = |numbers: &pintle_audit::Numbers<f64>, k| numbers.entries(ACC).get(k, 0).unwrap_or(0.0);
            each(numbers, ACC, |k, _, x| x - (of(&all, k) - of(&together, k) - of(&apart, k)));
        },
        (&["diagnosis::coriolis"], "the product of the spin of b against a and the spin of a"),
    ),
    Wrong::new(
        ("HINGE", "quaternions read with the scalar last"),
        &[F],
        |right, numbers| {
            let other = read_as(right, |phi| {
                let mut quaternion = so3::quaternion(&exp(phi));
                quaternion.rotate_left(3);
                so3::matrix(quaternion)
            });
            let sheet = |k: usize, x: f64| if k == 3 { continued(x, right.of(F, k, 0)) } else { x };
            each(numbers, F, |k, _, _| sheet(k, other.entries(F).get(k, 0).unwrap()));
        },
        (&["diagnosis::other-parameters"], "by quaternions whose scalar"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "variations of b along axes that turn with it and were global"),
        &[DF],
        |right, numbers| {
            let since = product(&right.pair().b.triad, &transpose(&right.initial().b.triad));
            for k in 3..6 {
                row(numbers, DF, k, |row| {
                    let block = [row[THETA_B], row[THETA_B + 1], row[THETA_B + 2]];
                    put(row, THETA_B, apply_transposed(&since, block));
                });
            }
        },
        (&["diagnosis::rotation-as-local"], "C the rotation of the node since the start"),
    ),
    Wrong::new(
        ("REVOLUTE", "atan2(−e2a·e1b, e3a·e3b), the index of an axis mistyped"),
        &[F],
        |right, numbers| {
            let (q, q0) = (right.q(), relative(right.initial()));
            let first = (-q0[1][2]).atan2(q0[2][2]);
            let x = (-q[1][0]).atan2(q[2][2]) - first;
            one(numbers, F, (3, 0), |expected| continued(x, expected));
        },
        (&["diagnosis::other-order"], "atan2(Q21, Q33)"),
    ),
    Wrong::new(
        ("TRANSLATOR", "the lever x_b for x_b − x_a"),
        &[DF],
        |right, numbers| {
            let [first, _] = pintle_audit::initial_places(right.initial().reference, false);
            let place = [0, 1, 2].map(|i| first[i] + right.pair().a.displacement[i]);
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    let more = cross([row[XB], row[XB + 1], row[XB + 2]], place);
                    let block = [0, 1, 2].map(|i| row[THETA_A + i] + more[i]);
                    put(row, THETA_A, block);
                });
            }
        },
        (&["diagnosis::other-length"], "with x_b for the lever"),
    ),
];
