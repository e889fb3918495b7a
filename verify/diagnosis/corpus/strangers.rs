//! Routines of a reader who had not seen the causes: clamps, axes of the other node, factors next to 1, flows in other columns.

use super::{ACC, DF, F, FORCE, RATE, Wrong, continued, each, one, part, put, relative, row};
use pintle_kinematics::node::Pair;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{
    Matrix, add, apply, apply_transposed, column, cross, dot, product, scale, sub, transpose,
};

/// The first Cardan angle by an arccosine, its sign put back.
fn by_acos(q: &Matrix<f64>) -> f64 {
    let angle = (q[2][2] / q[1][2].hypot(q[2][2])).clamp(-1.0, 1.0).acos();
    if q[1][2] > 0.0 { -angle } else { angle }
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("REVOLUTE", "acos for atan2, the sign put back"),
        &[F],
        |right, numbers| {
            let mine = by_acos(&right.q()) - by_acos(&relative(right.initial()));
            one(numbers, F, (3, 0), |x| continued(mine, x));
        },
        (&["diagnosis::digits-lost"], "ur1"),
    ),
    Wrong::new(
        ("HINGE", "asin of an entry for small angles"),
        &[F],
        |right, numbers| {
            let of = |q: Matrix<f64>| q[0][2].clamp(-1.0, 1.0).asin();
            let mine = of(right.q()) - of(relative(right.initial()));
            one(numbers, F, (4, 0), |_| mine);
        },
        (&["diagnosis::digits-lost"], "ur2"),
    ),
    Wrong::new(
        ("CARTESIAN", "a displacement clamped at 0.8"),
        &[F],
        |_, numbers| one(numbers, F, (0, 0), |x| x.clamp(-0.8, 0.8)),
        (&["diagnosis::limited"], "u1"),
    ),
    Wrong::new(
        ("SLIDE-PLANE", "a displacement clamped at 3"),
        &[F],
        |_, numbers| each(numbers, F, |k, _, x| if k == 2 { x.clamp(-3.0, 3.0) } else { x }),
        (&["diagnosis::limited"], "u3"),
    ),
    Wrong::new(
        ("UNIVERSAL", "an angle clamped at 2.5"),
        &[F],
        |_, numbers| one(numbers, F, (3, 0), |x| x.clamp(-2.5, 2.5)),
        (&["diagnosis::limited"], "ur1"),
    ),
    Wrong::new(
        ("PLANAR", "no less than nothing"),
        &[F],
        |_, numbers| one(numbers, F, (1, 0), |x| x.max(0.0)),
        (&["diagnosis::limited"], "u2"),
    ),
    Wrong::new(
        ("EULER", "principal values of all three"),
        &[F],
        |right, numbers| {
            let of = |q: &Matrix<f64>| [1, 2, 3].map(|i| so3::euler_angle(q, 1.0, i));
            let (now, first) = (of(&right.q()), of(&relative(right.initial())));
            each(numbers, F, |k, _, _| now[k - 3] - first[k - 3]);
        },
        (&["diagnosis::turns-forgotten"], "ur1"),
    ),
    Wrong::new(
        ("EULER", "principal values of the third"),
        &[F],
        |right, numbers| {
            let of = |q: &Matrix<f64>| so3::euler_angle(q, 1.0, 3);
            let (now, first) = (of(&right.q()), of(&relative(right.initial())));
            one(numbers, F, (5, 0), |_| now - first);
        },
        (&["diagnosis::turns-forgotten"], "ur3"),
    ),
    Wrong::new(
        ("UNIVERSAL", "ur1 times 1 + 1e-7"),
        &[F],
        |_, numbers| one(numbers, F, (3, 0), |x| x * (1.0 + 1e-7)),
        (&["diagnosis::factor", "diagnosis::scaled"], "ur1"),
    ),
    Wrong::new(
        ("BUSHING", "rows of u2 times 1 − 4e-9"),
        &[F, DF],
        |_, numbers| row(numbers, DF, 1, |row| row.iter_mut().for_each(|x| *x *= 1.0 - 4e-9)),
        (&["diagnosis::factor"], "∂u2"),
    ),
    Wrong::new(
        ("TRANSLATOR", "all rows times 1 + 3e-11"),
        &[F, DF],
        |_, numbers| each(numbers, DF, |_, _, x| x * (1.0 + 3e-11)),
        (&["diagnosis::factor"], "∂u1"),
    ),
    Wrong::new(
        ("HINGE", "π by 355/113"),
        &[F],
        |_, numbers| one(numbers, F, (3, 0), |x| x.to_degrees() * (355.0 / 113.0) / 180.0),
        (&["diagnosis::factor"], "ur1"),
    ),
    Wrong::new(
        ("FLOW-CONVERTER", "β_s in the column of node a"),
        &[DF],
        |_, numbers| row(numbers, DF, 5, |row| row.swap(6, 13)),
        (&["diagnosis::flow-column"], "∂ur3"),
    ),
    Wrong::new(
        ("RETRACTOR", "β_s in the columns of both nodes"),
        &[DF],
        |_, numbers| row(numbers, DF, 5, |row| row[6] = -row[13]),
        (&["diagnosis::flow-column"], "∂ur3"),
    ),
    Wrong::new(
        ("FLOW-CONVERTER", "β_s beside a rotation"),
        &[DF],
        |_, numbers| {
            row(numbers, DF, 5, |row| {
                row[12] += row[13];
                row[13] = 0.0;
            })
        },
        (&["diagnosis::flow-column"], "∂ur3"),
    ),
    Wrong::new(
        ("SLIPRING", "flows of the nodes exchanged"),
        &[F, DF],
        |_, numbers| row(numbers, DF, 0, |row| row.swap(6, 13)),
        (&["diagnosis::sign-of-block"], "∂u1"),
    ),
    Wrong::new(
        ("SLIPRING", "the strain of the initial length: flows do not count"),
        &[F],
        |right, numbers| {
            let first = norm(right.initial().separation());
            one(numbers, F, (0, 0), |_| norm(right.d()) / first - 1.0);
        },
        (&["diagnosis::motion-ignored", "diagnosis::other-length"], "u1"),
    ),
    Wrong::new(
        ("RETRACTOR", "the flow with the opposite sign"),
        &[DF],
        |_, numbers| row(numbers, DF, 5, |row| row[13] = -row[13]),
        (&["diagnosis::sign-of-block", "diagnosis::sign-of-entry"], "∂ur3"),
    ),
    Wrong::new(
        ("ROTATION", "θ of b along the axes of a"),
        &[F, DF],
        |right, numbers| {
            let a = right.pair().a.triad;
            (3..6).for_each(|k| row(numbers, DF, k, |row| put(row, 10, apply_transposed(&a, part(row, 10)))));
        },
        (&["diagnosis::rotation-as-local"], "Aᵀ"),
    ),
    Wrong::new(
        ("HINGE", "θ of a along the axes of b"),
        &[F, DF],
        |right, numbers| {
            let b = right.pair().b.triad;
            (0..6).for_each(|k| row(numbers, DF, k, |row| put(row, 3, apply_transposed(&b, part(row, 3)))));
        },
        (&["diagnosis::rotation-as-local"], "Bᵀ"),
    ),
    Wrong::new(
        ("UJOINT", "θ of each along the axes of the other"),
        &[F, DF],
        |right, numbers| {
            let [a, b] = [right.pair().a.triad, right.pair().b.triad];
            (3..6).for_each(|k| {
                row(numbers, DF, k, |row| {
                    put(row, 3, apply_transposed(&b, part(row, 3)));
                    put(row, 10, apply_transposed(&a, part(row, 10)));
                });
            });
        },
        (&["diagnosis::rotation-as-local"], "ur1"),
    ),
    Wrong::new(
        ("ROTATION", "components along b's axes"),
        &[F],
        |right, numbers| {
            let turned = |pair: &Pair<f64>| {
                let all = so3::log(&product(&pair.b.triad, &transpose(&pair.a.triad)));
                apply_transposed(&right.initial().b.triad, all)
            };
            let (now, first) = (turned(right.pair()), turned(right.initial()));
            each(numbers, F, |k, _, _| now[k - 3] - first[k - 3]);
        },
        (&["diagnosis::initial-axes", "diagnosis::axes-of-b"], "ur1"),
    ),
    Wrong::new(
        ("ACCELEROMETER", "the second derivative of the place for the acceleration along b"),
        &[ACC],
        |right, numbers| {
            for k in 0..3 {
                let rows = right.numbers.entries(DF);
                let hessians = right.numbers.entries(super::DDF);
                let [velocity, acceleration] = right.rates();
                let mut x = 0.0;
                for i in 0..14 {
                    x += rows.get(k, i).unwrap() * acceleration[i];
                    for j in 0..14 {
                        x += hessians.get(k, 14 * i + j).unwrap() * velocity[i] * velocity[j];
                    }
                }
                one(numbers, ACC, (k, 0), |_| x);
            }
        },
        (&["diagnosis::derivative-for-resolved"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("ACCELEROMETER", "velocities along the axes of a"),
        &[RATE],
        |right, numbers| {
            let [v, _] = right.rates();
            each(numbers, RATE, |k, _, _| dot(right.a(k), sub(part(&v, 7), part(&v, 0))));
        },
        (&["diagnosis::axes-of-a"], "du1/dt"),
    ),
    Wrong::new(
        ("ROTATION-ACCELEROMETER", "ω along the initial axes of b"),
        &[RATE],
        |right, numbers| {
            let [v, _] = right.rates();
            let initial = right.initial().b.triad;
            each(numbers, RATE, |k, _, _| dot(column(&initial, k - 3), sub(part(&v, 10), part(&v, 3))));
        },
        (&["diagnosis::initial-axes"], "dur1/dt"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "the distance from the axis of b"),
        &[F],
        |right, numbers| {
            let of = |pair: &Pair<f64>| {
                let d = pair.separation();
                dot(column(&pair.b.triad, 0), d).hypot(dot(column(&pair.b.triad, 1), d))
            };
            let (now, first) = (of(right.pair()), of(right.initial()));
            one(numbers, F, (0, 0), |_| now - first);
        },
        (&["diagnosis::nodes-swapped", "diagnosis::other-length"], "u1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "the mean of the axes, not divided by its length"),
        &[F],
        |right, numbers| {
            let of = |pair: &Pair<f64>, k: usize| {
                let mean = scale(add(column(&pair.a.triad, k), column(&pair.b.triad, k)), 0.5);
                dot(mean, pair.separation())
            };
            each(numbers, F, |k, _, _| of(right.pair(), k) - of(right.initial(), k));
        },
        (&["diagnosis::not-normalised"], "u1"),
    ),
    Wrong::new(
        ("PROJECTION FLEXION-TORSION", "the sine of the flexion"),
        &[F],
        |right, numbers| {
            let first = so3::component_flexions(&relative(right.initial()), None, 0.0);
            let now = [0, 1].map(|i| right.of(F, 3 + i, 0) + first[i]);
            let of = |[x, y]: [f64; 2]| [x, y].map(|part| part * x.hypot(y).sin() / x.hypot(y));
            let (now, first) = (of(now), of(first));
            each(numbers, F, |k, _, x| if k < 5 { now[k - 3] - first[k - 3] } else { x });
        },
        (&["diagnosis::other-parameters"], "ur1"),
    ),
    Wrong::new(
        ("FLEXION-TORSION", "the bend by 1 − cos"),
        &[F],
        |right, numbers| {
            let of = |q: Matrix<f64>| 1.0 - q[2][2];
            let (now, first) = (of(right.q()), of(relative(right.initial())));
            one(numbers, F, (3, 0), |_| now - first);
        },
        (&["diagnosis::other-parameters"], "ur1"),
    ),
    Wrong::new(
        ("FLEXION-TORSION", "the row of the bend without its division by the sine"),
        &[F, DF],
        |right, numbers| {
            let axis = cross(right.a(2), right.b(2));
            row(numbers, DF, 3, |row| {
                put(row, 3, scale(axis, -1.0));
                put(row, 10, axis);
            });
        },
        (&["diagnosis::not-normalised", "diagnosis::axis-for-gradient"], "∂ur1"),
    ),
    Wrong::new(
        ("CVJOINT", "the difference of Euler angles for their sum"),
        &[F],
        |right, numbers| {
            let of = |q: &Matrix<f64>| so3::euler_angle(q, 1.0, 1) - so3::euler_angle(q, 1.0, 3);
            let mine = of(&right.q()) - of(&relative(right.initial()));
            one(numbers, F, (4, 0), |_| mine);
        },
        (&["diagnosis::other-order", "diagnosis::other-parameters"], "ur2"),
    ),
    Wrong::new(
        ("UJOINT", "the second angle is not computed"),
        &[F],
        |_, numbers| one(numbers, F, (4, 0), |_| 0.0),
        (&["diagnosis::component-zero"], "ur2"),
    ),
    Wrong::new(
        ("UJOINT", "the sequence 1-3-2"),
        &[F],
        |right, numbers| {
            let of = |q: Matrix<f64>| [q[2][1].atan2(q[1][1]), q[0][2].atan2(q[0][0]), (-q[0][1]).asin()];
            let (now, first) = (of(right.q()), of(relative(right.initial())));
            each(numbers, F, |k, _, x| if k < 3 { x } else { now[k - 3] - first[k - 3] });
        },
        (&["diagnosis::other-order"], "ur1"),
    ),
    Wrong::new(
        ("CARDAN", "the rotation of a against b"),
        &[F],
        |right, numbers| {
            let of = |q: Matrix<f64>| {
                let q = transpose(&q);
                [(-q[1][2]).atan2(q[2][2]), q[0][2].asin(), (-q[0][1]).atan2(q[0][0])]
            };
            let (now, first) = (of(right.q()), of(relative(right.initial())));
            each(numbers, F, |k, _, _| now[k - 3] - first[k - 3]);
        },
        (&["diagnosis::nodes-swapped", "diagnosis::other-order"], "ur1"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "the angle of b about its own axis less that of a"),
        &[F],
        |right, numbers| {
            let of = |now: &Matrix<f64>, then: &Matrix<f64>| so3::log(&product(now, &transpose(then)))[0];
            let (now, first) = (right.pair(), right.initial());
            let mine = of(&now.b.triad, &first.b.triad) - of(&now.a.triad, &first.a.triad);
            one(numbers, F, (3, 0), |_| mine);
        },
        (&["diagnosis::other-parameters"], "ur1"),
    ),
    Wrong::new(
        ("WELD", "inches for millimetres in u2"),
        &[F],
        |_, numbers| one(numbers, F, (1, 0), |x| x / 25.4),
        (&["diagnosis::factor", "diagnosis::scaled"], "u2"),
    ),
    Wrong::new(
        ("LINK", "the row of the displaced length divided by the initial one"),
        &[F, DF],
        |right, numbers| {
            let by = norm(right.d()) / norm(right.initial().separation());
            row(numbers, DF, 0, |row| row.iter_mut().for_each(|x| *x *= by));
        },
        (&["diagnosis::not-normalised", "diagnosis::other-length"], "∂u1"),
    ),
    Wrong::new(
        ("SLIDE-PLANE", "u2 along b's axis, the others right"),
        &[F],
        |right, numbers| {
            let of = |pair: &Pair<f64>| dot(column(&pair.b.triad, 1), pair.separation());
            let (now, first) = (of(right.pair()), of(right.initial()));
            one(numbers, F, (1, 0), |_| now - first);
        },
        (&["diagnosis::axes-of-b"], "u2"),
    ),
    Wrong::new(
        ("BEAM", "moments of the forces at b left out"),
        &[FORCE],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, FORCE, k, |row| {
                    let lever = cross(part(row, 7), right.d());
                    put(row, 3, sub(part(row, 3), lever));
                });
            }
        },
        (&["diagnosis::geometric-term-missing", "diagnosis::block-missing"], "u1"),
    ),
    Wrong::new(
        ("REVOLUTE", "moments along the axes of b"),
        &[FORCE],
        |right, numbers| {
            for k in 4..6 {
                let e = right.b(k - 3);
                let size = right.of(FORCE, k, 10).hypot(right.of(FORCE, k, 11)).hypot(right.of(FORCE, k, 12));
                row(numbers, FORCE, k, |row| {
                    put(row, 10, scale(e, size));
                    put(row, 3, scale(e, -size));
                });
            }
        },
        (&["diagnosis::axis-for-gradient", "diagnosis::nodes-swapped"], "ur2"),
    ),
    Wrong::new(
        ("ROTATION-ACCELEROMETER", "angular accelerations of b alone"),
        &[ACC],
        |right, numbers| {
            let [_, a] = right.rates();
            each(numbers, ACC, |k, _, _| dot(right.b(k - 3), part(&a, 10)));
        },
        (&["diagnosis::rates-of-a-ignored"], "d²ur1/dt²"),
    ),
    Wrong::new(
        ("CARTESIAN", "global rows turned with A instead of back"),
        &[F, DF],
        |right, numbers| {
            let a = right.pair().a.triad;
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    put(row, 0, apply(&a, part(row, 0)));
                    put(row, 7, apply(&a, part(row, 7)));
                });
            }
        },
        (&["diagnosis::displacement-as-local", "diagnosis::axes"], "∂u1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "the mid axes do not turn"),
        &[F, DF],
        |_, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    put(row, 3, [0.0; 3]);
                    put(row, 10, [0.0; 3]);
                });
            }
        },
        (&["diagnosis::block-missing", "diagnosis::frame-held"], "∂u1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "the axes turn with a alone"),
        &[F, DF],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    put(row, 3, cross(part(row, 7), right.d()));
                    put(row, 10, [0.0; 3]);
                });
            }
        },
        (&["diagnosis::axes-of-a", "diagnosis::lever-at-b"], "∂u1"),
    ),
    Wrong::new(
        ("ALIGN", "the first misalignment by acos of the trace"),
        &[F],
        |right, numbers| {
            let r = product(&right.q(), &transpose(&relative(right.initial())));
            let cosine = ((r[0][0] + r[1][1] + r[2][2] - 1.0) / 2.0).clamp(-1.0, 1.0);
            let phi = so3::log(&r);
            let part = cosine.acos() / norm(phi).max(1e-300);
            each(numbers, F, |k, _, _| part * phi[k - 3]);
        },
        (&["diagnosis::digits-lost"], "ur1"),
    ),
];
