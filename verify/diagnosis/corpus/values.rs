//! Values.

use super::{F, Right, Wrong, each, one};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::{column, dot};
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
];

/// The first Cardan angle less its initial value, from −π to π.
fn principal(right: &Right<'_>) -> f64 {
    let x = right.of(F, 3, 0);
    x - TAU * (x / TAU).round()
}
