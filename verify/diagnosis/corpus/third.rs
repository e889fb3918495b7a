//! Mistakes that a third outsider made, whose families had no name.

use super::{ACC, DDF, DF, F, RATE, Right, Wrong, each, one, part, put, relative, row};
use pintle_audit::Numbers;
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{column, cross, dot, scale, sub};
use std::f64::consts::{PI, TAU};

/// The columns from one on, to another, one place further on.
fn shifted(numbers: &mut Numbers<f64>, from: usize, to: usize) {
    for row in numbers.entries_mut(DF).0.iter_mut().flatten() {
        row[from..to].rotate_right(1);
        row[from] = 0.0;
    }
}

/// l, l_ref, and both at first, of a belt.
fn belt(right: &Right<'_>) -> [f64; 4] {
    let of = |pair: &Pair<f64>, strain: f64| {
        let l = norm(pair.separation());
        [l, l / (1.0 + strain)]
    };
    let first = right.case.at_rest().positions()[0].unwrap();
    let [l, reference] = of(right.pair(), right.case.positions()[0].unwrap());
    let [l0, reference0] = of(right.initial(), first);
    [l, reference, l0, reference0]
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("SLOT", "the lever of u3 copied from the line of u2"),
        &[F, DF],
        |right, numbers| row(numbers, DF, 2, |row| put(row, 3, cross(right.a(1), right.d()))),
        (&["diagnosis::components-swapped"], "∂u3"),
    ),
    Wrong::new(
        ("SLIDE-PLANE", "the velocity of the axes by x_b for d"),
        &[RATE],
        |right, numbers| {
            let first = pintle_audit::initial_places(right.initial().reference, right.definition.planar)[1];
            let x: [f64; 3] = std::array::from_fn(|i| first[i] + right.pair().b.displacement[i]);
            let [v, _] = right.rates();
            let more = cross(part(&v, 3), sub(x, right.d()));
            each(numbers, RATE, |k, _, rate| rate - dot(right.a(k), more));
        },
        (&["diagnosis::other-length"], "du1/dt"),
    ),
    Wrong::new(
        ("AXIAL", "the speed for its component along the line"),
        &[RATE],
        |right, numbers| {
            let [v, _] = right.rates();
            each(numbers, RATE, |_, _, _| norm(sub(part(&v, 7), part(&v, 0))));
        },
        (&["diagnosis::other-length"], "du1/dt"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "second derivatives of the radius without t tᵀ/r"),
        &[DDF],
        |right, numbers| {
            let (d, e3) = (right.d(), right.a(2));
            let radial = sub(d, scale(e3, dot(d, e3)));
            let t = scale(cross(radial, e3), 1.0 / norm(radial));
            let mut of = [0.0; DOFS];
            put(&mut of, 0, scale(t, -1.0));
            put(&mut of, 7, t);
            put(&mut of, 3, cross(t, d));
            row(numbers, DDF, 0, |matrix| {
                for (n, x) in matrix.iter_mut().enumerate() {
                    *x -= of[n / DOFS] * of[n % DOFS] / norm(radial);
                }
            });
        },
        (&["diagnosis::geometric-term-missing"], "∂²u1"),
    ),
    Wrong::new(
        ("CONSTANT VELOCITY", "the shaft e1 for e3"),
        &[F],
        |right, numbers| {
            let of = |pair: &Pair<f64>| {
                let q = relative(pair);
                // e1 for e3, e3 for −e1.
                let from = [2, 1, 0];
                let sign = |i: usize| if i == 2 { -1.0 } else { 1.0 };
                let other =
                    [0, 1, 2].map(|i| [0, 1, 2].map(|j| sign(from[i]) * sign(from[j]) * q[from[i]][from[j]]));
                so3::torsion(&other)
            };
            let mine = of(right.pair()) - of(right.initial());
            one(numbers, F, (4, 0), |x| mine + TAU * ((x - mine) / TAU).round());
        },
        (&["diagnosis::other-axis", "diagnosis::other-parameters", "diagnosis::other-order"], "ur2"),
    ),
    Wrong::new(
        ("CARDAN", "half of the first angle, as it continues"),
        &[F],
        |_, numbers| one(numbers, F, (3, 0), |x| x / 2.0 + if x.abs() > 1.0 { PI } else { 0.0 }),
        (&["diagnosis::factor"], "ur1"),
    ),
    Wrong::new(
        ("CARDAN", "3.1416 for π where the turns of ur1 are added"),
        &[F],
        |_, numbers| {
            one(numbers, F, (3, 0), |x| x + 2.0 * (x / TAU).round() * ((PI * 1e4).round() / 1e4 - PI))
        },
        (&["diagnosis::rounded"], "3.1416"),
    ),
    Wrong::new(
        ("ROTATION", "the principal rotation vector, where it is continued"),
        &[F],
        |right, numbers| {
            let (now, first) = (so3::log(&right.q()), so3::log(&relative(right.initial())));
            each(numbers, F, |k, _, _| now[k - 3] - first[k - 3]);
        },
        (&["diagnosis::turns-forgotten"], "ur1"),
    ),
    Wrong::new(
        ("ALIGN", "rows are the axes of a"),
        &[DF],
        |right, numbers| {
            for k in 3..6 {
                row(numbers, DF, k, |row| {
                    put(row, 3, scale(right.a(k - 3), -1.0));
                    put(row, 10, right.a(k - 3));
                });
            }
        },
        (&["diagnosis::other-jacobian"], "the axis itself"),
    ),
    Wrong::new(
        ("ROTATION", "the inverse Jacobian transposed"),
        &[DF],
        |right, numbers| {
            let whole = right.case.positions();
            let phi = [3, 4, 5].map(|k| whole[k].unwrap());
            let inverse = so3::inverse_left_jacobian(phi);
            for k in 3..6 {
                let along = [0, 1, 2].map(|j| inverse[j][k - 3]);
                let g = [0, 1, 2].map(|i| (0..3).map(|j| right.pair().a.triad[i][j] * along[j]).sum());
                row(numbers, DF, k, |row| {
                    put(row, 10, g);
                    put(row, 3, scale(g, -1.0));
                });
            }
        },
        (&["diagnosis::other-jacobian"], "∂ur1"),
    ),
    Wrong::new(
        ("ROTATION-ACCELEROMETER", "the derivative of the rotation vector for the resolved rate"),
        &[F, DF, RATE],
        |right, numbers| {
            let [v, _] = right.rates();
            let rates = [3, 4, 5].map(|k| (0..DOFS).map(|j| right.of(DF, k, j) * v[j]).sum::<f64>());
            each(numbers, RATE, |k, _, _| rates[k - 3]);
        },
        (&["diagnosis::derivative-for-resolved"], "dur1/dt"),
    ),
    Wrong::new(
        ("ACCELEROMETER", "the time derivative of the resolved velocity"),
        &[ACC],
        |right, numbers| {
            let [v, a] = right.rates();
            let (slow, fast) = (sub(part(&v, 7), part(&v, 0)), sub(part(&a, 7), part(&a, 0)));
            each(numbers, ACC, |k, _, _| dot(right.b(k), fast) + dot(cross(part(&v, 10), right.b(k)), slow));
        },
        (&["diagnosis::derivative-for-resolved"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("ACCELEROMETER", "the velocity of b as a sees it"),
        &[RATE],
        |right, numbers| {
            let [v, _] = right.rates();
            let seen = sub(sub(part(&v, 7), part(&v, 0)), cross(part(&v, 3), right.d()));
            each(numbers, RATE, |k, _, _| dot(right.b(k), seen));
        },
        (&["diagnosis::derivative-for-resolved"], "du1/dt"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "the columns of b without a place for the flow of a"),
        &[DF],
        |_, numbers| {
            for row in numbers.entries_mut(DF).0.iter_mut().flatten() {
                row[6..].rotate_left(1);
            }
        },
        (&["diagnosis::columns-swapped"], "one place further back"),
    ),
    Wrong::new(
        ("JOIN", "rotations written one column too far"),
        &[DF],
        |_, numbers| shifted(numbers, 3, 7),
        (&["diagnosis::columns-swapped"], "one place further on"),
    ),
    Wrong::new(
        ("CARTESIAN", "an index of the lever mistyped"),
        &[DF],
        |right, numbers| {
            for k in 0..3 {
                let (e, d) = (right.a(k), right.d());
                let typed = [0, 1, 2].map(|i| {
                    let (j, l) = ((i + 1) % 3, (i + 2) % 3);
                    e[j] * d[l] - e[j] * d[j]
                });
                row(numbers, DF, k, |row| put(row, 3, typed));
            }
        },
        (&["diagnosis::geometric-term-missing"], "an index mistyped"),
    ),
    Wrong::new(
        ("SLIPRING", "the elongation for the strain"),
        &[F],
        |right, numbers| {
            let [l, reference, l0, reference0] = belt(right);
            one(numbers, F, (0, 0), |_| (l - reference) - (l0 - reference0));
        },
        (&["diagnosis::other-length"], "elongation"),
    ),
    Wrong::new(
        ("SLIPRING", "the columns of the flows without the stretch"),
        &[DF],
        |right, numbers| {
            let [l, reference, ..] = belt(right);
            row(numbers, DF, 0, |row| {
                row[6] *= reference / l;
                row[13] *= reference / l;
            });
        },
        (&["diagnosis::not-normalised"], "∂u1"),
    ),
    Wrong::new(
        ("RETRACTOR", "the sign of the flow"),
        &[F],
        |right, numbers| {
            let before = right.case.path.iter().rev().nth(1).map_or(*right.initial(), |step| step.state.pair);
            let flow = right.pair().b.flow - before.b.flow;
            one(numbers, F, (5, 0), |x| x + 2.0 * right.definition.flow_scale * flow);
        },
        (&["diagnosis::term-left-out"], "the flow"),
    ),
    Wrong::new(
        ("RETRACTOR", "the axis at the end of the increment"),
        &[F],
        |right, numbers| {
            let Some((last, path)) = right.case.path.split_last() else { return };
            let before = path.last().map_or(*right.initial(), |step| step.state.pair);
            let spin = sub(last.increment.rotation[0], last.increment.rotation[1]);
            let flow = right.pair().b.flow - before.b.flow;
            let turned = dot(column(&right.pair().a.triad, 2), spin);
            let mine = right.values_before[5].unwrap_or(0.0) + turned - right.definition.flow_scale * flow;
            one(numbers, F, (5, 0), |_| mine);
        },
        (&["diagnosis::not-halfway"], "ur3"),
    ),
];
