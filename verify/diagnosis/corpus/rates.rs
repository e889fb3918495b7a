//! Rates and accelerations.

use super::{ACC, DDF, DF, F, RATE, Right, Wrong, each, one, part};
use pintle_audit::Numbers;
use pintle_kinematics::vector::{apply, apply_transposed, cross, dot, sub};

/// ċ_k of given nodal rates.
fn along(right: &Right<'_>, k: usize, v: &[f64; 14]) -> f64 {
    (0..14).map(|j| right.of(DF, k, j) * v[j]).sum()
}

/// q̇ᵀ ∂²c_k q̇ of given nodal rates.
fn quadratic(right: &Right<'_>, k: usize, v: &[f64; 14]) -> f64 {
    (0..14).map(|i| v[i] * (0..14).map(|j| right.of(DDF, k, 14 * i + j) * v[j]).sum::<f64>()).sum()
}

/// Rates with the angular ones of both nodes along other axes.
fn resolved(right: &Right<'_>, v: &[f64; 14], back: bool) -> [f64; 14] {
    let mut v = *v;
    for (at, triad) in [(3, right.pair().a.triad), (10, right.pair().b.triad)] {
        let of = part(&v, at);
        let other = if back { apply_transposed(&triad, of) } else { apply(&triad, of) };
        v[at..at + 3].copy_from_slice(&other);
    }
    v
}

/// Rates of b alone.
fn of_b(v: &[f64; 14]) -> [f64; 14] {
    let mut v = *v;
    v[..7].fill(0.0);
    v
}

fn rates(right: &Right<'_>, numbers: &mut Numbers<f64>, of: impl Fn(&[f64; 14]) -> [f64; 14]) {
    let [v, _] = right.rates();
    each(numbers, RATE, |k, _, _| along(right, k, &of(&v)));
}

fn accelerations(right: &Right<'_>, numbers: &mut Numbers<f64>, of: impl Fn(&[f64; 14]) -> [f64; 14]) {
    let [v, a] = right.rates();
    each(numbers, ACC, |k, _, _| along(right, k, &of(&a)) + quadratic(right, k, &of(&v)));
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("CARTESIAN", "ẋ_b alone"),
        &[F, RATE],
        |right, numbers| rates(right, numbers, of_b),
        (&["diagnosis::rates-of-a-ignored"], "du1/dt"),
    ),
    Wrong::new(
        ("REVOLUTE", "angular velocities along the axes of the nodes"),
        &[RATE],
        |right, numbers| rates(right, numbers, |v| resolved(right, v, true)),
        (&["diagnosis::body-rates"], "dur1/dt"),
    ),
    Wrong::new(
        ("CARDAN", "angular velocities turned once more"),
        &[RATE],
        |right, numbers| rates(right, numbers, |v| resolved(right, v, false)),
        (&["diagnosis::body-rates"], "dur1/dt"),
    ),
    Wrong::new(
        ("SLOT", "e1a·(v_b − v_a) without ω_a × d"),
        &[RATE],
        |right, numbers| {
            let v = right.state.velocity;
            each(numbers, RATE, |k, _, _| dot(right.a(k), sub(part(&v, 7), part(&v, 0))));
        },
        (&["diagnosis::geometric-term-missing", "diagnosis::block-missing"], "du1/dt"),
    ),
    Wrong::new(
        ("JOIN", "ω_a × d added instead of subtracted"),
        &[RATE],
        |right, numbers| {
            let v = right.state.velocity;
            let spin = cross(part(&v, 3), right.d());
            each(numbers, RATE, |k, _, _| {
                dot(right.a(k), sub(part(&v, 7), part(&v, 0))) + dot(right.a(k), spin)
            });
        },
        (&["diagnosis::geometric-term-reversed", "diagnosis::sign-of-block"], "du1/dt"),
    ),
    Wrong::new(
        ("EULER", "rates in degrees per second"),
        &[RATE],
        |right, numbers| each(numbers, RATE, |k, _, x| if right.is_angle(k) { x.to_degrees() } else { x }),
        (&["diagnosis::degrees"], "dur1/dt"),
    ),
    Wrong::new(
        ("ROTATION", "ω_b − ω_a along a for the rate of the rotation vector"),
        &[RATE],
        |right, numbers| {
            let v = right.state.velocity;
            each(numbers, RATE, |k, _, _| dot(right.a(k - 3), sub(part(&v, 10), part(&v, 3))));
        },
        (&["diagnosis::axis-for-gradient"], "dur1/dt"),
    ),
    Wrong::new(
        ("UNIVERSAL", "ω_b − ω_a along the axes e1a and e3b"),
        &[RATE],
        |right, numbers| {
            let v = right.state.velocity;
            let relative = sub(part(&v, 10), part(&v, 3));
            one(numbers, RATE, (3, 0), |_| dot(right.a(0), relative));
            one(numbers, RATE, (5, 0), |_| dot(right.b(2), relative));
        },
        (&["diagnosis::axis-for-gradient"], "dur1/dt"),
    ),
    Wrong::new(
        ("ACCELEROMETER", "the time derivatives of the coordinates"),
        &[RATE],
        |right, numbers| rates(right, numbers, |v| *v),
        (&["diagnosis::derivative-for-resolved"], "du1/dt"),
    ),
    Wrong::new(
        ("AXIAL", "the magnitude of the rate"),
        &[RATE],
        |_, numbers| each(numbers, RATE, |_, _, x| x.abs()),
        (&["diagnosis::sign-lost"], "du1/dt"),
    ),
    Wrong::new(
        ("LINK", "minus the rate"),
        &[RATE],
        |_, numbers| each(numbers, RATE, |_, _, x| -x),
        (&["diagnosis::sign"], "du1/dt"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "the accelerations without J̇ q̇"),
        &[ACC],
        |right, numbers| each(numbers, ACC, |k, _, _| along(right, k, &right.state.acceleration)),
        (&["diagnosis::quadratic-part-missing"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("PLANAR", "the quadratic part halved: Coriolis once"),
        &[ACC],
        |right, numbers| {
            let [v, a] = right.rates();
            each(numbers, ACC, |k, _, _| along(right, k, &a) + quadratic(right, k, &v) / 2.0);
        },
        (&["diagnosis::quadratic-part-multiple"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("HINGE", "the quadratic part subtracted"),
        &[ACC],
        |right, numbers| {
            let [v, a] = right.rates();
            each(numbers, ACC, |k, _, _| along(right, k, &a) - quadratic(right, k, &v));
        },
        (&["diagnosis::quadratic-part-multiple"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("TRANSLATOR", "the quadratic part alone"),
        &[ACC],
        |right, numbers| each(numbers, ACC, |k, _, _| quadratic(right, k, &right.state.velocity)),
        (&["diagnosis::linear-part-missing"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("BUSHING", "accelerations of b alone"),
        &[ACC],
        |right, numbers| accelerations(right, numbers, of_b),
        (&["diagnosis::rates-of-a-ignored"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("FLEXION-TORSION", "angular rates and accelerations along the nodes' axes"),
        &[RATE, ACC],
        |right, numbers| {
            rates(right, numbers, |v| resolved(right, v, true));
            accelerations(right, numbers, |v| resolved(right, v, true));
        },
        (&["diagnosis::body-rates"], "ur1/dt"),
    ),
    Wrong::new(
        ("CARTESIAN", "centripetal without Coriolis: no term in ω × v"),
        &[ACC],
        |right, numbers| {
            let [v, a] = right.rates();
            let relative = sub(part(&v, 7), part(&v, 0));
            each(numbers, ACC, |k, _, _| {
                let coriolis = -2.0 * dot(right.a(k), cross(part(&v, 3), relative));
                along(right, k, &a) + quadratic(right, k, &v) - coriolis
            });
        },
        (&["diagnosis::coriolis"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("SLIDE-PLANE", "Coriolis without centripetal"),
        &[ACC],
        |right, numbers| {
            let [v, a] = right.rates();
            let relative = sub(part(&v, 7), part(&v, 0));
            each(numbers, ACC, |k, _, _| {
                along(right, k, &a) - 2.0 * dot(right.a(k), cross(part(&v, 3), relative))
            });
        },
        (&["diagnosis::coriolis"], "d²u1/dt²"),
    ),
    Wrong::new(
        ("SLIPRING", "the rate of strain per initial length, in percent"),
        &[RATE],
        |_, numbers| one(numbers, RATE, (0, 0), |x| 100.0 * x),
        (&["diagnosis::factor"], "du1/dt"),
    ),
    Wrong::new(
        ("FLOW-CONVERTER", "the rate of flow left out"),
        &[RATE],
        |right, numbers| {
            let mut v = right.state.velocity;
            v[13] = 0.0;
            each(numbers, RATE, |k, _, _| along(right, k, &v));
        },
        (&["diagnosis::block-missing"], "dur3/dt"),
    ),
    Wrong::new(
        ("UJOINT", "rates of ur1 and ur3 exchanged"),
        &[RATE],
        |right, numbers| {
            one(numbers, RATE, (3, 0), |_| right.of(RATE, 5, 0));
            one(numbers, RATE, (5, 0), |_| right.of(RATE, 3, 0));
        },
        (&["diagnosis::components-swapped"], "dur1/dt"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "velocities along the axes of a"),
        &[RATE],
        |right, numbers| {
            let mut v = right.state.velocity;
            for at in [0, 7] {
                let x = apply_transposed(&right.pair().a.triad, part(&v, at));
                v[at..at + 3].copy_from_slice(&x);
            }
            each(numbers, RATE, |k, _, _| along(right, k, &v));
        },
        (&["diagnosis::displacement-as-local"], "du1/dt"),
    ),
];
