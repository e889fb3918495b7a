//! What batches ask of a first attempt.

use crate::measure::Measure;
use crate::measure::Measure::{
    Cardan, Euler, Misalignment, Position, PositionAtB, RotationVector, RotationVectorAtB, Torsion,
};
use crate::measure::{Exchanged, History, Section, Shared, SingularClass};
use crate::node::{DOFS, Node, Pair, Relative};
use crate::{so3, vector};
use std::f64::consts::{FRAC_PI_2, PI};

/// A connector whose directions are aligned initially, of length one.
fn section() -> Section<f64> {
    Section {
        initial_orientation: vector::identity(),
        initial_length: 1.0,
        fixed_direction: [0.0; 3],
        flow_scale: 1.0,
    }
}

/// The rotation vector of a first attempt is the principal one. It continues the history where the reference is within half a turn
/// of zero and not on the other side; half a turn from a reference at zero does. Where it has not been asked for, nothing is lost.
#[test]
fn a_first_attempt_knows_whether_it_holds() {
    let continued = |angle: f64, reference: f64, asks: bool| {
        let axis = [0.0, 0.6, 0.8];
        let q = so3::matrix(so3::exp_quaternion(vector::scale(axis, angle)));
        let relative = Relative { d: [0.0; 3], q, flow: [0.0; 2], spin: None };
        let history =
            History { rotation_vector: vector::scale(axis, reference), euler_sign: 1.0, torsion_turns: 0.0 };
        let section = section();
        let triad = vector::identity();
        let mut shared = Shared::new(&relative, &triad, &section, &history).principal();
        if asks {
            let phi = shared.rotation_vector();
            assert!((vector::dot(phi, axis) - angle).abs() < 1e-14, "{angle} {phi:?}");
        }
        shared.is_continued()
    };
    for (angle, reference, holds) in [
        (0.5, 0.0, true),
        (0.5, 3.0, true),
        (0.5, -3.0, false),
        (0.5, 3.2, false),
        (2.0, 2.5, true),
        (3.0, -1.0, false),
        (FRAC_PI_2, -0.4, true),
    ] {
        assert_eq!(continued(angle, reference, true), holds, "{angle} {reference}");
        assert!(continued(angle, reference, false));
    }
    // Half a turn exactly, where w = 0.
    let half = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    let (phi, nearness) = so3::principal_log_along(&half, None, [0.0; 3]);
    assert_eq!(phi, [0.0, 0.0, PI]);
    assert!(nearness > 0.0);
}

/// Two of three angles share a lock, never the second.
#[test]
fn first_and_third_angles_lock() {
    let locks = |measures: [Measure; 3]| measures.map(Measure::locks);
    assert_eq!(locks([Cardan(1), Cardan(2), Cardan(3)]), [true, false, true]);
    assert_eq!(locks([Euler(1), Euler(2), Euler(3)]), [true, false, true]);
    assert_eq!(locks([Torsion, RotationVector(1), Position(1)]), [false; 3]);
}

/// Where only a formula fails, and nothing is lost.
#[test]
fn removable_points_are_known() {
    let at = |measure: Measure| measure.removable_sets().iter().map(|set| set.at).collect::<Vec<_>>();
    assert_eq!(at(RotationVector(2)), ["φ = 0", "|φ| = π"]);
    assert_eq!(at(RotationVectorAtB(1)), ["φ = 0", "|φ| = π"]);
    assert_eq!(at(Misalignment(3)), ["b in its initial orientation, ρ = 0"]);
    for bent in [Torsion, Measure::ComponentFlexion(1), Measure::ProjectedPosition(2)] {
        assert_eq!(at(bent), ["e3b = e3a, α = 0"]);
        assert!(bent.removable_sets().iter().all(|set| set.class == SingularClass::Removable));
    }
    assert!(at(Position(1)).is_empty() && at(Cardan(1)).is_empty());
}

/// Rates that are the nodal ones resolved in b: v_b − v_a and ω_b − ω_a, and likewise accelerations.
#[test]
fn rates_resolved_in_b_are_nodal() {
    let turned = so3::matrix(so3::exp_quaternion([0.0, 0.0, FRAC_PI_2]));
    let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let pair = Pair { reference: [1.0, 0.0, 0.0], a: node(vector::identity()), b: node(turned) };
    let mut velocity = [0.0; DOFS];
    let mut acceleration = [0.0; DOFS];
    for (i, place) in [0, 1, 2, 3, 4, 5].into_iter().enumerate() {
        let half = DOFS / 2;
        (velocity[place], velocity[half + place]) = (1.0, 2.0 + i as f64);
        (acceleration[place], acceleration[half + place]) = (10.0, 30.0 + i as f64);
    }
    // e1b = e2, e2b = −e1, e3b = e3; translations are 1, 2, 3 apart, rotations 4, 5, 6, and accelerations 20 … 25.
    let rates = |measure: Measure| measure.nodal_rates(&pair, &velocity, &acceleration);
    let near = |found: Option<[f64; 2]>, expected: [f64; 2]| {
        let found = found.unwrap();
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-14), "{found:?} {expected:?}");
    };
    near(rates(PositionAtB(1)), [2.0, 21.0]);
    near(rates(PositionAtB(2)), [-1.0, -20.0]);
    near(rates(PositionAtB(3)), [3.0, 22.0]);
    near(rates(RotationVectorAtB(1)), [5.0, 24.0]);
    near(rates(RotationVectorAtB(2)), [-4.0, -23.0]);
    assert_eq!((rates(Position(1)), rates(RotationVector(1))), (None, None));
}

/// The margin of a rotation vector is the distance of its angle from the nearest whole turn.
#[test]
fn whole_turns_are_the_margin_of_rotation_vectors() {
    let section = section();
    let distance = |turned: f64, before: f64| {
        let along = |angle: f64| vector::scale([0.0, 0.6, 0.8], angle);
        let q = so3::matrix(so3::exp_quaternion(along(turned)));
        let relative = Relative { d: [0.0; 3], q, flow: [0.0; 2], spin: None };
        let history = History { rotation_vector: along(before), euler_sign: 1.0, torsion_turns: 0.0 };
        RotationVector(1).margin(&relative, &section, &history).unwrap().distance
    };
    for (angle, expected) in [
        (0.5, 2.0 * PI - 0.5),
        (3.5, 2.0 * PI - 3.5),
        (6.0, 2.0 * PI - 6.0),
        (6.6, 6.6 - 2.0 * PI),
        (7.0, 7.0 - 2.0 * PI),
        (12.0, 4.0 * PI - 12.0),
    ] {
        let found = distance(angle, angle);
        assert!((found - expected).abs() < 1e-13, "{angle}: {found}");
    }
    // It has its own digits, of which the angle has none left.
    for little in [1e-9, 1e-15, 3e-300] {
        let found = distance(little, 2.0 * PI + 1e-3);
        assert!((found / little - 1.0).abs() < 1e-12, "{little}: {found}");
    }
}

/// What rounding of b's place leaves of the radius is none.
#[test]
fn a_radius_of_rounding_is_none() {
    let section = section();
    let history = History { rotation_vector: [0.0; 3], euler_sign: 1.0, torsion_turns: 0.0 };
    for (radius, expected) in [(0.0, 0.0), (1e-12, 0.0), (3e-12, 3e-12), (1.0, 1.0), (2e3, 2e3)] {
        let d = [0.6 * radius, 0.8 * radius, 1000.0];
        let relative = Relative { d, q: vector::identity(), flow: [0.0; 2], spin: None };
        let found = Measure::RadialDistance.margin(&relative, &section, &history).unwrap().distance;
        assert!((found - expected).abs() <= 1e-15 * radius, "{radius}: {found}");
    }
}

/// What a measure becomes when the nodes are exchanged, d → −Qᵀd, Q → Qᵀ, Ψ_a ↔ Ψ_b: a sum of measures but for a constant, which two
/// states have in common.
#[test]
fn exchanged_measures_are_what_they_are_said_to_be() {
    let section = section();
    let value = |measure: Measure, relative: &Relative<f64>| {
        let phi = so3::log(&relative.q);
        let history = History { rotation_vector: phi, euler_sign: 1.0, torsion_turns: 0.0 };
        let triad = vector::identity();
        measure.evaluate(&mut Shared::new(relative, &triad, &section, &history))
    };
    let states =
        [([0.4, -0.7, 0.5], [0.3, 0.8, -0.2], [0.1, 0.7]), ([-0.2, 0.5, 0.9], [-0.5, 0.4, 0.6], [-0.3, 0.2])];
    let states = states.map(|(d, phi, flow)| {
        let q = so3::matrix(so3::exp_quaternion(phi));
        let back = vector::scale(vector::apply_transposed(&q, d), -1.0);
        let there = Relative { d: back, q: vector::transpose(&q), flow: [flow[1], flow[0]], spin: None };
        [Relative { d, q, flow, spin: None }, there]
    });
    let mut sums = 0;
    let all = [1, 2, 3].into_iter().flat_map(|i| {
        [
            Euler(i),
            RotationVector(i),
            RotationVectorAtB(i),
            Measure::ProjectedPosition(i),
            Measure::Cosine(i, i),
        ]
    });
    let flows = [1, 2].into_iter().flat_map(|i| [Measure::Flow(i), Measure::ComponentFlexion(i)]);
    let others = [Measure::Distance, Measure::Flexion, Measure::Sweep, Torsion];
    let all: Vec<Measure> = all.chain(flows).chain(others).collect();
    for measure in all.iter().copied() {
        let Exchanged::Sum(terms) = measure.exchanged() else { panic!("{measure:?} has no rule") };
        assert!(terms.iter().flatten().all(|(of, _)| all.contains(of)), "{measure:?} becomes what is none");
        let changed = |side: usize, measure: Measure| {
            value(measure, &states[0][side]) - value(measure, &states[1][side])
        };
        let told: f64 = terms.iter().flatten().map(|(of, factor)| factor * changed(0, *of)).sum();
        let off = (changed(1, measure) - told).rem_euclid(2.0 * PI);
        assert!(off.min(2.0 * PI - off) < 1e-13, "{measure:?}: {off}");
        sums += 1;
    }
    assert_eq!(sums, 23);
    let has_none = |measure: Measure| matches!(measure.exchanged(), Exchanged::None(_));
    assert!(has_none(Measure::Cosine(1, 2)) && has_none(Cardan(1)) && has_none(Position(1)));
}

/// What is straight has no second difference along d, and what is not has one.
#[test]
fn straight_measures_have_no_curvature() {
    let section = section();
    let phi = [0.3, 0.8, -0.2];
    let value = |measure: Measure, d: [f64; 3]| {
        let relative = Relative { d, q: so3::matrix(so3::exp_quaternion(phi)), flow: [0.1, 0.4], spin: None };
        let history = History { rotation_vector: phi, euler_sign: 1.0, torsion_turns: 0.0 };
        measure.evaluate(&mut Shared::new(&relative, &vector::identity(), &section, &history))
    };
    let all =
        [1, 2, 3].into_iter().flat_map(|i| [Position(i), PositionAtB(i), Measure::ProjectedPosition(i)]);
    let others =
        [Measure::Flow(1), Measure::Flow(2), Measure::Distance, Measure::RadialDistance, Measure::Strain];
    for measure in all.chain(others) {
        let bent = (0..3).any(|i| {
            let at = |h: f64| {
                let mut d = [0.4, -0.7, 0.5];
                d[i] += h;
                value(measure, d)
            };
            (at(0.25) - 2.0 * at(0.0) + at(-0.25)).abs() > 1e-12
        });
        assert_eq!(measure.is_straight(), !bent, "{measure:?}");
    }
}
