//! Values.

use super::{F, Right, Wrong, each, one, relative};
use pintle_kinematics::node::Pair;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{add, column, dot, product, sub, transpose, transposed_product};
use std::f64::consts::{PI, TAU};

pub(super) const ALL: &[Wrong] = &[
    Wrong {
        name: "u2 × 1000: metres taken for millimetres",
        connection: "CARTESIAN",
        offers: &[F],
        spoil: |_, numbers| one(numbers, F, (1, 0), |x| 1000.0 * x),
        causes: &["diagnosis::unit-of-length"],
        place: "u2",
    },
    Wrong {
        name: "ur1 in degrees",
        connection: "REVOLUTE",
        offers: &[F],
        spoil: |_, numbers| one(numbers, F, (3, 0), f64::to_degrees),
        causes: &["diagnosis::degrees"],
        place: "ur1",
    },
    Wrong {
        name: "the initial length is not subtracted",
        connection: "AXIAL",
        offers: &[F],
        spoil: |right, numbers| one(numbers, F, (0, 0), |_| norm(right.d())),
        causes: &["diagnosis::initial-value-kept"],
        place: "u1",
    },
    Wrong {
        name: "the initial position is subtracted twice",
        connection: "SLOT",
        offers: &[F],
        spoil: |right, numbers| {
            let initial = dot(column(&right.initial().a.triad, 0), right.initial().reference);
            one(numbers, F, (0, 0), |_| dot(right.a(0), right.d()) - 2.0 * initial);
        },
        causes: &["diagnosis::initial-value-twice"],
        place: "u1",
    },
    Wrong {
        name: "along b's axes instead of a's",
        connection: "CARTESIAN",
        offers: &[F],
        spoil: |right, numbers| {
            let initial = right.initial();
            each(numbers, F, |k, _, _| {
                dot(right.b(k), right.d()) - dot(column(&initial.b.triad, k), initial.reference)
            });
        },
        causes: &["diagnosis::axes-of-b"],
        place: "u1, u2, u3",
    },
    Wrong {
        name: "along the global axes",
        connection: "SLIDE-PLANE",
        offers: &[F],
        spoil: |right, numbers| each(numbers, F, |k, _, _| right.d()[k] - right.initial().reference[k]),
        causes: &["diagnosis::global-axes"],
        place: "u1, u2, u3",
    },
    Wrong {
        name: "u1 and u3 exchanged",
        connection: "CARTESIAN",
        offers: &[F],
        spoil: |right, numbers| {
            one(numbers, F, (0, 0), |_| right.of(F, 2, 0));
            one(numbers, F, (2, 0), |_| right.of(F, 0, 0));
        },
        causes: &["diagnosis::components-swapped"],
        place: "u1, u3",
    },
    Wrong {
        name: "principal angle where turns go on",
        connection: "HINGE",
        offers: &[F],
        spoil: |right, numbers| {
            let start = principal(right);
            one(numbers, F, (3, 0), |_| start);
        },
        causes: &["diagnosis::turns-forgotten"],
        place: "ur1",
    },
    Wrong {
        name: "−π for π",
        connection: "UNIVERSAL",
        offers: &[F],
        spoil: |_, numbers| one(numbers, F, (3, 0), |x| x - PI),
        causes: &["diagnosis::half-turn"],
        place: "ur1",
    },
    Wrong {
        name: "the opposite sign: a relative to b",
        connection: "ROTATION",
        offers: &[F],
        spoil: |_, numbers| each(numbers, F, |_, _, x| -x),
        causes: &["diagnosis::sign", "diagnosis::nodes-swapped"],
        place: "ur1, ur2, ur3",
    },
    Wrong::new(
        ("UNIVERSAL", "atan for atan2"),
        &[F],
        |right, numbers| {
            let q = right.q();
            let q0 = relative(right.initial());
            one(numbers, F, (3, 0), |_| (-q[1][2] / q[2][2]).atan() - (-q0[1][2] / q0[2][2]).atan());
        },
        (&["diagnosis::folded", "diagnosis::half-turn"], "ur1"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "the first angle by acos of one entry"),
        &[F],
        |right, numbers| {
            let (q, q0) = (right.q(), relative(right.initial()));
            let angle =
                |q: [[f64; 3]; 3]| (q[2][2] / (1.0 - q[0][2] * q[0][2]).sqrt()).clamp(-1.0, 1.0).acos();
            one(numbers, F, (3, 0), |_| angle(q) - angle(q0));
        },
        (&["diagnosis::sign-lost"], "ur1"),
    ),
    Wrong::new(
        ("CARDAN", "the sequence 3-2-1 for 1-2-3"),
        &[F],
        |right, numbers| {
            let of = |q: [[f64; 3]; 3]| [q[2][1].atan2(q[2][2]), (-q[2][0]).asin(), q[1][0].atan2(q[0][0])];
            let q0 = relative(right.initial());
            each(numbers, F, |k, _, _| of(right.q())[k - 3] - of(q0)[k - 3]);
        },
        (&["diagnosis::other-order"], "ur1, ur2, ur3"),
    ),
    Wrong::new(
        ("EULER", "Cardan angles for Euler angles"),
        &[F],
        |right, numbers| {
            let of =
                |q: [[f64; 3]; 3]| [(-q[1][2]).atan2(q[2][2]), q[0][2].asin(), (-q[0][1]).atan2(q[0][0])];
            let q0 = relative(right.initial());
            each(numbers, F, |k, _, _| of(right.q())[k - 3] - of(q0)[k - 3]);
        },
        (&["diagnosis::other-order"], "ur1, ur2, ur3"),
    ),
    Wrong::new(
        ("ROTATION", "twice the vector of the quaternion for the rotation vector"),
        &[F],
        |right, numbers| {
            let of = |q: &[[f64; 3]; 3]| {
                let [_, x, y, z] = so3::quaternion(q);
                [2.0 * x, 2.0 * y, 2.0 * z]
            };
            let q0 = relative(right.initial());
            each(numbers, F, |k, _, _| of(&right.q())[k - 3] - of(&q0)[k - 3]);
        },
        (&["diagnosis::other-parameters"], "ur1, ur2, ur3"),
    ),
    Wrong::new(
        ("ALIGN", "the skew part of Q Q₀ᵀ for its rotation vector"),
        &[F],
        |right, numbers| {
            let q0 = relative(right.initial());
            let r = product(&right.q(), &transpose(&q0));
            let skew = [(r[2][1] - r[1][2]) / 2.0, (r[0][2] - r[2][0]) / 2.0, (r[1][0] - r[0][1]) / 2.0];
            each(numbers, F, |k, _, _| skew[k - 3]);
        },
        (&["diagnosis::other-parameters"], "ur1, ur2, ur3"),
    ),
    Wrong::new(
        ("JOIN", "u_b − u_a along the axes of a"),
        &[F],
        |right, numbers| {
            let moved = sub(right.d(), right.initial().separation());
            each(numbers, F, |k, _, _| dot(right.a(k), moved));
        },
        (&["diagnosis::initial-separation-turned"], "u1, u2, u3"),
    ),
    Wrong::new(
        ("BEAM", "the axes of a do not turn"),
        &[F],
        |right, numbers| {
            let moved = sub(right.d(), right.initial().separation());
            for k in 0..3 {
                one(numbers, F, (k, 0), |_| dot(column(&right.initial().a.triad, k), moved));
            }
        },
        (&["diagnosis::initial-axes", "diagnosis::motion-ignored"], "u1, u2, u3"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "the initial radius is kept"),
        &[F],
        |right, numbers| {
            one(numbers, F, (0, 0), |_| dot(right.a(0), right.d()).hypot(dot(right.a(1), right.d())));
        },
        (&["diagnosis::initial-value-kept"], "u1"),
    ),
    Wrong::new(
        ("LINK", "the length of node b's displacement alone"),
        &[F],
        |right, numbers| {
            let pair = right.pair();
            let d = add(pair.reference, pair.b.displacement);
            one(numbers, F, (0, 0), |_| norm(d) - norm(pair.reference));
        },
        (&["diagnosis::motion-ignored"], "u1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "along the axes of a"),
        &[F],
        |right, numbers| {
            let initial = right.initial();
            let first = |k: usize| dot(column(&initial.a.triad, k), initial.reference);
            each(numbers, F, |k, _, _| dot(right.a(k), right.d()) - first(k));
        },
        (&["diagnosis::axes-of-a"], "u1, u2, u3"),
    ),
    Wrong::new(
        ("BUSHING", "ur3 in degrees"),
        &[F],
        |_, numbers| one(numbers, F, (5, 0), f64::to_degrees),
        (&["diagnosis::degrees"], "ur3"),
    ),
    Wrong::new(
        ("FLEXION-TORSION", "an angle converted to radians that is in them"),
        &[F],
        |_, numbers| one(numbers, F, (3, 0), f64::to_radians),
        (&["diagnosis::degrees"], "ur1"),
    ),
    Wrong::new(
        ("CONSTANT VELOCITY", "a reference angle of 0.2 forgotten in the value"),
        &[F],
        |_, numbers| one(numbers, F, (4, 0), |x| x + 0.2),
        (&["diagnosis::offset"], "ur2"),
    ),
    Wrong::new(
        ("PLANAR", "twice the displacement"),
        &[F],
        |_, numbers| one(numbers, F, (1, 0), |x| 2.0 * x),
        (&["diagnosis::factor"], "u2"),
    ),
    Wrong::new(
        ("SLIPRING", "the strain in percent"),
        &[F],
        |_, numbers| one(numbers, F, (0, 0), |x| 100.0 * x),
        (&["diagnosis::factor"], "u1"),
    ),
    Wrong::new(
        ("TRANSLATOR", "a step behind: the values of the state before"),
        &[F],
        |right, numbers| each(numbers, F, |k, _, _| right.values_before[k].unwrap()),
        (&["diagnosis::state-before"], "u1"),
    ),
    Wrong::new(
        ("ACCELEROMETER", "triads read by rows"),
        &[F],
        |right, numbers| {
            let (pair, initial) = (right.pair(), right.initial());
            each(numbers, F, |k, _, _| {
                dot(pair.a.triad[k], right.d()) - dot(initial.a.triad[k], initial.reference)
            });
        },
        (&["diagnosis::triads-transposed"], "u1, u2, u3"),
    ),
    Wrong::new(
        ("UJOINT", "the two angles exchanged"),
        &[F],
        |right, numbers| {
            one(numbers, F, (3, 0), |_| right.of(F, 5, 0));
            one(numbers, F, (5, 0), |_| right.of(F, 3, 0));
        },
        (&["diagnosis::components-swapped"], "ur1, ur3"),
    ),
    Wrong::new(
        ("WELD", "u1 and ur1 exchanged"),
        &[F],
        |right, numbers| {
            one(numbers, F, (0, 0), |_| right.of(F, 3, 0));
            one(numbers, F, (3, 0), |_| right.of(F, 0, 0));
        },
        (&["diagnosis::components-swapped"], "u1, ur1"),
    ),
    Wrong::new(
        ("REVOLUTE", "an angle from 0 to 2π"),
        &[F],
        |_, numbers| one(numbers, F, (3, 0), |x| x.rem_euclid(TAU)),
        (&["diagnosis::turns-added", "diagnosis::turns-forgotten"], "ur1"),
    ),
    Wrong::new(
        ("CARDAN", "the rotation of node a is not looked at"),
        &[F],
        |right, numbers| {
            let of =
                |q: [[f64; 3]; 3]| [(-q[1][2]).atan2(q[2][2]), q[0][2].asin(), (-q[0][1]).atan2(q[0][0])];
            let a0 = right.initial().a.triad;
            let [now, first] =
                [right.pair(), right.initial()].map(|pair| transposed_product(&a0, &pair.b.triad));
            each(numbers, F, |k, _, _| of(now)[k - 3] - of(first)[k - 3]);
        },
        (&["diagnosis::motion-ignored"], "ur1, ur2, ur3"),
    ),
    Wrong::new(
        ("ROTATION-ACCELEROMETER", "the rotation vector along global axes"),
        &[F],
        |right, numbers| {
            let of = |pair: &Pair<f64>| so3::log(&product(&pair.b.triad, &transpose(&pair.a.triad)));
            each(numbers, F, |k, _, _| of(right.pair())[k - 3] - of(right.initial())[k - 3]);
        },
        (&["diagnosis::global-axes"], "ur1, ur2, ur3"),
    ),
    Wrong::new(
        ("HINGE", "the tangent of half the angle, doubled"),
        &[F],
        |right, numbers| one(numbers, F, (3, 0), |_| 2.0 * (right.of(F, 3, 0) / 2.0).tan()),
        (&["diagnosis::other-parameters"], "ur1"),
    ),
    Wrong::new(
        ("AXIAL", "the distance of the nodes exchanged for its change in magnitude"),
        &[F],
        |_, numbers| one(numbers, F, (0, 0), f64::abs),
        (&["diagnosis::sign-lost"], "u1"),
    ),
    Wrong::new(
        ("SLOT", "u2 is left at zero"),
        &[F],
        |_, numbers| one(numbers, F, (1, 0), |_| 0.0),
        (&["diagnosis::component-zero"], "u2"),
    ),
];

/// The first Cardan angle less its initial value, from −π to π.
fn principal(right: &Right<'_>) -> f64 {
    let x = right.of(F, 3, 0);
    x - TAU * (x / TAU).round()
}
