//! What any friction obeys: no violation, no slip in stick, no energy made, nothing lost at zeros and in the range of numbers.

use super::{Numbers, U, coefficients, friction, predefined, users, widened};
use crate::states::Draw;
use crate::tolerance::friction as gate;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::scalar::Wide;
use pintle_model::behavior::Conditions;
use pintle_model::behavior::friction::{
    Belt, BeltInput, Branch, Coefficient, Context, Contribution, Criterion, FLOW, Flag, Input, Internal,
    Potential, Pressing, State, Status, StickStiffness, Tangential,
};
use pintle_model::behavior::table::Table;
use pintle_scene::Extrapolation;

fn slot() -> Criterion {
    let slot = ConnectionType::named("SLOT", None).unwrap().friction.unwrap();
    Criterion::predefined(&slot, &[], &[], false).unwrap().remove(0)
}

fn slide_plane() -> Criterion {
    let slide_plane = ConnectionType::named("SLIDE-PLANE", None).unwrap().friction.unwrap();
    Criterion::predefined(&slide_plane, &[], &[], false).unwrap().remove(0)
}

fn input(displacement: [f64; 6], forces: [f64; 6]) -> Input<'static, f64> {
    Input { displacement, forces, duration: None, context: Context::default() }
}

/// Over random histories: Φ ≤ 0 to rounding, slip exactly zero in stick, force and slip in one direction, and the work put in
/// covers what is stored and lost: friction never makes energy.
#[test]
fn histories_obey_the_law_and_make_no_energy() {
    let mut draw = Draw::new("friction histories");
    let mut criteria: Vec<(String, Criterion)> =
        predefined(&mut draw, false).into_iter().map(|(name, i, _, c)| (format!("{name} {i}"), c)).collect();
    criteria.extend(users().into_iter().map(|(name, c)| (name.to_string(), c)));
    let (mut sticks, mut slips, mut worst) = (0, 0, 0.0_f64);
    for (name, criterion) in &criteria {
        for (law, coefficient) in coefficients() {
            for stiffness in [StickStiffness::Given(40.0), StickStiffness::ElasticSlip(0.02)] {
                let friction = friction(criterion, &coefficient, stiffness);
                let mut state: State<f64> = State::default();
                let (mut work, mut lost, mut size) = (0.0, 0.0, 0.0);
                for step in 0..12 {
                    let mut numbers = Numbers::drawn(&mut draw, if step % 3 == 0 { 0.05 } else { 0.004 });
                    // Scale factors that move with positions make a force do work by themselves.
                    numbers.position = [0.5, -0.4, 0.0, 0.2, 0.1, 0.0];
                    let outcome = friction.update(&state, &numbers.input(), Branch::Decided);
                    let scale = (outcome.limit + outcome.trial.abs()).max(1e-290);
                    let violation = outcome.criterion / (U * scale);
                    worst = worst.max(violation);
                    assert!(violation <= gate("violation"), "{name} {law}: Φ = {violation} u\n{outcome:?}");
                    match outcome.status {
                        Status::Stick => {
                            sticks += 1;
                            assert_eq!((outcome.slip_increment, outcome.slip), (0.0, [0.0; 6]));
                            assert_eq!(
                                (outcome.dissipation, outcome.accumulated_slip),
                                (0.0, state.accumulated_slip)
                            );
                        }
                        Status::Slip => {
                            slips += 1;
                            assert!(outcome.slip_increment >= 0.0, "{name}: {outcome:?}");
                            let miss = -outcome.criterion / (U * scale);
                            assert!(
                                miss <= gate("violation"),
                                "{name} {law}: slips below the limit, {miss} u\n{outcome:?}"
                            );
                            let gains = outcome.flags.contains(&Flag::NegativeDissipation);
                            assert_eq!(gains, outcome.dissipation < 0.0, "{name}: {outcome:?}");
                            // Zero traction lies outside a criterion that is shifted by more than its limit.
                            assert!(!gains || name == "shifted", "{name}: {outcome:?}");
                            let rate = outcome.slip_increment / numbers.duration.unwrap();
                            assert!((outcome.slip_rate - rate).abs() <= 2.0 * U * rate);
                        }
                        Status::Free => assert_eq!(outcome.force, [0.0; 6]),
                    }
                    let step_work: f64 =
                        outcome.force.iter().zip(numbers.displacement).map(|(f, u)| f * u).sum();
                    work += step_work;
                    lost += outcome.dissipation;
                    size += step_work.abs() + outcome.stored;
                    assert!(
                        work >= lost + outcome.stored - gate("energy") * U * size || name == "shifted",
                        "{name} {law} {stiffness:?}: work {work}, lost {lost}, stored {}\n{outcome:?}",
                        outcome.stored
                    );
                    assert!(outcome.accumulated_slip >= state.accumulated_slip);
                    state = outcome.state();
                }
            }
        }
    }
    println!("{sticks} sticks, {slips} slips, violation {worst} u");
    assert!(sticks > 500 && slips > 500, "{sticks} {slips}");
}

/// A closed path in stick gives back what was put in: the force returns, nothing is lost, nothing slipped.
#[test]
fn closed_paths_in_stick_return() {
    let friction = friction(&slide_plane(), &Coefficient::Constant(0.5), StickStiffness::Given(1024.0));
    let mut state: State<f64> = State::default();
    let mut work = 0.0;
    let square = [(0.25, 0.0), (0.0, 0.25), (-0.25, 0.0), (0.0, -0.25)].map(|(x, y)| (x / 64.0, y / 64.0));
    for (x, y) in square.into_iter().cycle().take(40) {
        let outcome = friction.update(
            &state,
            &input([0.0, x, y, 0.0, 0.0, 0.0], [40.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            Branch::Decided,
        );
        assert_eq!(outcome.status, Status::Stick);
        // The mean force of a step does the work.
        work += 0.5 * ((state.force[1] + outcome.force[1]) * x + (state.force[2] + outcome.force[2]) * y);
        state = outcome.state();
    }
    assert_eq!((state.force, state.accumulated_slip, work), ([0.0; 6], 0.0, 0.0));
}

/// Sliding to and fro loses 4 μ F_N times the amplitude less the elastic slips, in every cycle.
#[test]
fn cycles_lose_the_area_of_their_loop() {
    let friction = friction(&slot(), &Coefficient::Constant(0.5), StickStiffness::Given(100.0));
    let forces = [0.0, 3.0, 4.0, 0.0, 0.0, 0.0];
    let mut state: State<f64> = State::default();
    let mut lost = Vec::new();
    for cycle in 0..3 {
        let mut here = 0.0;
        for (steps, step) in [(if cycle == 0 { 8 } else { 16 }, 0.125), (16, -0.125)] {
            for _ in 0..steps {
                let outcome =
                    friction.update(&state, &input([step, 0.0, 0.0, 0.0, 0.0, 0.0], forces), Branch::Decided);
                here += outcome.dissipation;
                state = outcome.state();
            }
        }
        lost.push(here);
    }
    // Limit 2.5, elastic slip 0.025, from −1 to 1 and back: 2 · 2.5 · (2 − 0.05).
    for cycle in &lost[1..] {
        assert!((cycle - 9.75).abs() < 1e-12, "{lost:?}");
    }
}

/// At the threshold: exactly on it and a hair below sticks, a hair above slips by the hair; both are named, and both tangents can
/// be asked for.
#[test]
fn thresholds_are_told_and_have_two_tangents() {
    let friction = friction(&slot(), &Coefficient::Constant(0.5), StickStiffness::Given(1.0));
    let forces = [0.0, 3.0, 4.0, 0.0, 0.0, 0.0];
    for (hair, status) in [
        (0.0, Status::Stick),
        (-1e-13, Status::Stick),
        (1e-13, Status::Slip),
        (-1e-11, Status::Stick),
        (1e-11, Status::Slip),
    ] {
        let near = input([2.5 * (1.0 + hair), 0.0, 0.0, 0.0, 0.0, 0.0], forces);
        let outcome = friction.update(&State::default(), &near, Branch::Decided);
        assert_eq!(outcome.status, status, "{hair}");
        assert_eq!(outcome.flags.contains(&Flag::Threshold), hair.abs() < 1e-12, "{hair}");
        assert!((outcome.slip_increment - (2.5 * hair).max(0.0)).abs() <= 4.0 * U * 2.5, "{hair}");
        let [stick, slip] =
            [Branch::Stick, Branch::Slip].map(|branch| friction.tangent(&State::default(), &near, branch));
        assert_eq!((stick.1.force[0].displacement[0], stick.1.force[0].forces[1]), (1.0, 0.0));
        assert_eq!(
            (slip.1.force[0].displacement[0], slip.1.force[0].forces[1..3].to_vec()),
            (0.0, vec![0.3, 0.4])
        );
        assert!((stick.0.force[0] - slip.0.force[0]).abs() <= 3e-11);
    }
}

/// Without a contact force nothing holds, and all is regular: no force, no tangent, the motion is slip.
#[test]
fn nothing_pressed_holds_nothing() {
    for stiffness in [StickStiffness::Given(10.0), StickStiffness::ElasticSlip(1e-4)] {
        let friction = friction(&slide_plane(), &Coefficient::Constant(0.5), stiffness);
        let (outcome, tangent) = friction.tangent(
            &State::default(),
            &input([0.0, 3.0, 4.0, 0.0, 0.0, 0.0], [0.0; 6]),
            Branch::Decided,
        );
        assert_eq!((outcome.status, outcome.force), (Status::Free, [0.0; 6]));
        assert_eq!((outcome.slip_increment, outcome.slip), (5.0, [0.0, 3.0, 4.0, 0.0, 0.0, 0.0]));
        assert!(
            tangent
                .force
                .iter()
                .all(|partial| partial.displacement == [0.0; 6] && partial.forces == [0.0; 6])
        );
        assert!(outcome.flags.contains(&Flag::NoContactForce));
        let still = friction.update(&State::default(), &input([0.0; 6], [0.0; 6]), Branch::Decided);
        assert_eq!((still.status, still.slip_increment), (Status::Free, 0.0));
        // What was stored in stick is let go.
        let pressed = friction.update(
            &State::default(),
            &input([0.0, 1e-5, 0.0, 0.0, 0.0, 0.0], [9.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            Branch::Decided,
        );
        assert_eq!(pressed.status, Status::Stick);
        let released = friction.update(&pressed.state(), &input([0.0; 6], [0.0; 6]), Branch::Decided);
        assert_eq!((released.force, released.stored, released.dissipation), ([0.0; 6], 0.0, 0.0));
        assert!((released.slip_increment - 1e-5).abs() < 1e-20);
    }
}

/// The default stiffness lets the limit be reached after the allowed elastic slip, is kept, and is the same in mm and m.
#[test]
fn the_default_stiffness_allows_the_elastic_slip() {
    let friction = friction(&slot(), &Coefficient::Constant(0.5), StickStiffness::ElasticSlip(0.01));
    let forces = |size: f64| [0.0, size, 0.0, 0.0, 0.0, 0.0];
    let first = friction.update(
        &State::default(),
        &input([0.01 * (1.0 - 1e-9), 0.0, 0.0, 0.0, 0.0, 0.0], forces(4.0)),
        Branch::Decided,
    );
    assert_eq!((first.status, first.stick_stiffness), (Status::Stick, Some(200.0)));
    let second = friction.update(&first.state(), &input([0.0; 6], forces(40.0)), Branch::Decided);
    assert_eq!(second.stick_stiffness, Some(200.0));
}

/// From 1e-300 to 1e300, in stick and slip: the same numbers, scaled.
#[test]
fn forces_of_any_size_update_alike() {
    let mut draw = Draw::new("friction update range");
    for (name, _, _, criterion) in predefined(&mut draw, false) {
        for step in [0.002, 0.2] {
            let numbers = Numbers { duration: None, ..Numbers::drawn(&mut draw, step) };
            let of = |factor: f64| {
                let friction =
                    friction(&criterion, &Coefficient::Constant(0.3), StickStiffness::Given(40.0 * factor));
                let scaled = Numbers { forces: numbers.forces.map(|f| f * factor), ..numbers };
                // The internal contact force is a force too.
                let mut friction = friction;
                friction.criterion.internal = Internal::Constant(0.5 * factor);
                friction.tangent(&State::default(), &scaled.input(), Branch::Decided)
            };
            let (base, slope) = of(1.0);
            for power in [-980, -300, 300, 980] {
                let factor = 2.0_f64.powi(power);
                let (scaled, steep) = of(factor);
                assert_eq!(base.status, scaled.status);
                for k in 0..6 {
                    let near = |a: f64, b: f64| (a - b).abs() <= gate("range") * U * (1.0 + a.abs());
                    assert!(
                        near(base.force[k], scaled.force[k] / factor),
                        "{name} 2^{power}: {base:?}\n{scaled:?}"
                    );
                    for j in 0..6 {
                        assert!(near(slope.force[k].forces[j], steep.force[k].forces[j]), "{name} 2^{power}");
                        let stiff = steep.force[k].displacement[j] / factor;
                        assert!(
                            near(slope.force[k].displacement[j] / 40.0, stiff / 40.0),
                            "{name} 2^{power}"
                        );
                    }
                }
                assert!(scaled.flags.iter().all(|flag| !matches!(flag, Flag::NotFinite { .. })));
            }
        }
    }
}

/// CYLINDRICAL on its surface: u1 and R ur1 are alike, and the friction force opposes the velocity of the surface.
#[test]
fn a_cylinder_slips_along_its_surface() {
    let cylindrical = ConnectionType::named("CYLINDRICAL", None).unwrap().friction.unwrap();
    let criterion = Criterion::predefined(&cylindrical, &[Some(0.25)], &[], false).unwrap().remove(0);
    let friction = friction(&criterion, &Coefficient::Constant(0.5), StickStiffness::Given(1e4));
    let outcome = friction.update(
        &State::default(),
        &input([0.3, 0.0, 0.0, 1.6, 0.0, 0.0], [0.0, 6.0, 8.0, 0.0, 0.0, 0.0]),
        Branch::Decided,
    );
    // Surface motion (0.3, 0.25 · 1.6) = 0.5 (0.6, 0.8); limit 5.
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15 * (1.0 + b.abs()), "{a} {b}");
    near(outcome.force[0], 3.0);
    near(outcome.force[3], 4.0 * 0.25);
    near(outcome.slip_increment, 0.5 - 5.0 / 1e4);
    near(outcome.slip[3] * 0.25, outcome.slip_increment * 0.8);
    near(outcome.dissipation, 5.0 * outcome.slip_increment);
}

/// μ that depends on the slip rate is found with the slip, not lagged.
#[test]
fn the_slip_rate_is_that_of_the_increment() {
    let decay = Coefficient::Exponential { at_rest: 0.6, kinetic: 0.2, decay: 3.0 };
    let friction = friction(&slot(), &decay, StickStiffness::Given(500.0));
    let mut increment = input([0.3, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 6.0, 8.0, 0.0, 0.0, 0.0]);
    increment.duration = Some(0.5);
    let outcome = friction.update(&State::default(), &increment, Branch::Decided);
    let mu = 0.2 + 0.4 * (-3.0 * outcome.slip_increment / 0.5).exp();
    assert!((outcome.coefficient - mu).abs() < 1e-15 && (outcome.force[0] - 10.0 * mu).abs() < 1e-14);
    assert!((500.0 * (0.3 - outcome.slip_increment) - outcome.force[0]).abs() < 1e-12);
    increment.duration = None;
    let timeless = friction.update(&State::default(), &increment, Branch::Decided);
    assert_eq!(timeless.force[0], 6.0);
    assert!(timeless.flags.contains(&Flag::NoDuration));
}

/// A table with a sudden fall has several slips that satisfy the equation: the first is taken. At its far side nothing jumps.
#[test]
fn the_first_slip_is_taken() {
    let row = |mu: f64, rate: f64| pintle_scene::TableRow {
        values: vec![Some(mu), Some(rate)],
        ..Default::default()
    };
    let table = Table::new(
        &[row(1.0, 0.0), row(1.0, 1.0), row(0.1, 1.1), row(0.1, 9.0)],
        1,
        &["rate"],
        Extrapolation::Constant,
    )
    .unwrap();
    let friction = friction(&slot(), &Coefficient::Table(table), StickStiffness::Given(1.0));
    let mut increment = input([1.9, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    increment.duration = Some(1.0);
    // 1.9 − Δγ = μ(Δγ): at 0.9 with μ = 1, and at 1.8 with μ = 0.1.
    let outcome = friction.update(&State::default(), &increment, Branch::Decided);
    assert!((outcome.slip_increment - 0.9).abs() < 1e-15, "{outcome:?}");
}

/// The same over a ring: T (e^(μα) − 1) at its rows is 1, 0.91, 0.91, 0.41, 0.41, so that 1.04 − Δγ meets it at 0.13 and at 0.63.
#[test]
fn the_first_slip_over_a_ring_is_taken() {
    let row = |limit: f64, slip: f64| pintle_scene::TableRow {
        values: vec![Some(limit.ln_1p()), Some(slip / 0.5)],
        ..Default::default()
    };
    let rows = [row(1.0, 0.0), row(0.91, 0.1), row(0.91, 0.2), row(0.41, 0.25), row(0.41, 9.0)];
    let table = Table::new(&rows, 1, &["rate"], Extrapolation::Constant).unwrap();
    let belt = Belt {
        coefficient: Coefficient::Table(table),
        maximum: None,
        stick_stiffness: StickStiffness::Given(1.0),
    };
    let conditions = Conditions::default();
    let input = BeltInput {
        flow: 1.04,
        tension: [1.0, 9.0],
        angle: 1.0,
        duration: Some(0.5),
        conditions: &conditions,
    };
    let outcome = belt.update(&State::default(), &input, Branch::Decided);
    assert!((outcome.slip_increment - 0.13).abs() < 1e-14, "{outcome:?}");
}

/// Let go, a cylinder slides by the motion of its surface and by what was stored in stick: f/K along, m/(K R²) around.
#[test]
fn what_is_let_go_slides_with_what_was_stored() {
    let cylindrical = ConnectionType::named("CYLINDRICAL", None).unwrap().friction.unwrap();
    let criterion = Criterion::predefined(&cylindrical, &[Some(0.25)], &[], false).unwrap().remove(0);
    let friction = friction(&criterion, &Coefficient::Constant(0.5), StickStiffness::Given(8.0));
    let mut state = State::default();
    (state.force[0], state.force[3]) = (1.0, 0.5);
    let outcome = friction.update(&state, &input([0.25, 0.0, 0.0, 3.0, 0.0, 0.0], [0.0; 6]), Branch::Decided);
    assert_eq!((outcome.status, outcome.force), (Status::Free, [0.0; 6]));
    assert_eq!((outcome.slip[0], outcome.slip[3]), (0.375, 4.0));
    assert!((outcome.slip_increment - 0.375_f64.hypot(1.0)).abs() < 1e-15);
    assert_eq!((outcome.stored, outcome.dissipation), (0.0, 0.0));
    // In stick the same forces store f²/(2K) + m²/(2 K R²).
    let held = friction.update(&state, &input([0.0; 6], [0.0, 40.0, 0.0, 0.0, 0.0, 0.0]), Branch::Decided);
    assert_eq!((held.status, held.stored, held.dissipation), (Status::Stick, 0.0625 + 0.25, 0.0));
    // The surface moves by (1.5, 2), which would take (12, 16); 4 of these 20 hold, and the rest slips.
    let forces = [0.0, 8.0, 0.0, 0.0, 0.0, 0.0];
    let slid =
        friction.update(&State::default(), &input([1.5, 0.0, 0.0, 8.0, 0.0, 0.0], forces), Branch::Decided);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    near(slid.dissipation, 4.0 * 2.0);
    near(slid.stored, 4.0 * 4.0 / (2.0 * 8.0));
}

/// An ellipsoid is returned to along its normal in the metric of the stiffness: compared with its scalar equation.
#[test]
fn an_ellipsoid_is_met_at_its_closest_point() {
    let (_, criterion) = users().into_iter().find(|(name, _)| *name == "ellipsoid").unwrap();
    let friction = friction(&criterion, &Coefficient::Constant(0.5), StickStiffness::Given(10.0));
    let outcome = friction.update(
        &State::default(),
        &input([0.7, -0.4, 0.0, 1.1, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 2.0, 0.0]),
        Branch::Decided,
    );
    assert_eq!((outcome.status, outcome.limit), (Status::Slip, 1.0));
    assert!(!outcome.flags.contains(&Flag::ReturnedAlongTraction));
    for (k, scale, radius) in [(0, 1.5, 1.0), (1, 0.7, 1.0), (3, 0.4, 0.8)] {
        let normal = outcome.force[k] / (scale * scale);
        let elastic = outcome.force[k] / (10.0 * radius * radius);
        let displacement = [0.7, -0.4, 0.0, 1.1][k];
        let flow = displacement - elastic - outcome.slip_increment * normal;
        assert!(flow.abs() < 1e-15, "{k}: {flow}");
        assert!((outcome.slip[k] - outcome.slip_increment * normal).abs() < 1e-15);
    }
}

/// Where the normal does not exist or Newton's method ends, the traction is returned along itself, which is named.
#[test]
fn an_edge_is_told() {
    let (_, criterion) = users().into_iter().find(|(name, _)| *name == "linear").unwrap();
    let friction = friction(&criterion, &Coefficient::Constant(0.5), StickStiffness::Given(10.0));
    let edge = input([0.01, 5.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
    let outcome = friction.update(&State::default(), &edge, Branch::Decided);
    assert!(outcome.flags.contains(&Flag::ReturnedAlongTraction));
    assert!(outcome.criterion.abs() <= 8.0 * U && outcome.dissipation > 0.0);
    assert!((outcome.force[0] / outcome.force[1] - 0.01 / 5.0).abs() < 1e-17);
}

/// Along the traction f = s f_tr with s = L/P(f_tr), where P is linear; what is not held slips, and the tangent is that of the
/// formula. Of P = |f1|/1.5 + m1/0.8, K = 10 and K R² = 6.4.
#[test]
fn a_return_along_the_traction_is_its_formula() {
    use super::component;
    use pintle_scene::PotentialFunction::{Abs, None as Plain};
    use pintle_scene::PotentialOperator;
    let terms = |shift| {
        vec![
            Contribution { shift, ..component(0, 1.0, Abs) },
            Contribution { scale: 0.8, ..component(3, 1.0, Plain) },
        ]
    };
    let of = |shift| {
        let potential = Potential::new(PotentialOperator::Sum, 1.0, terms(shift)).unwrap();
        let pressing = Pressing::Component(4);
        let criterion = super::criterion(Tangential::Potential(potential), pressing, Internal::Constant(0.0));
        friction(&criterion, &Coefficient::Constant(0.5), StickStiffness::Given(10.0))
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 8.0 * U * (1.0 + b.abs()), "{a} {b}");
    let edge = input([0.01, 0.0, 0.0, 5.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
    let (outcome, tangent) = of(0.0).tangent(&State::default(), &edge, Branch::Decided);
    assert!(outcome.flags.contains(&Flag::ReturnedAlongTraction));
    let (trial, stiffness) = ([0.1, 32.0], [10.0, 6.4]);
    let p = trial[0] / 1.5 + trial[1] / 0.8;
    let elastic = trial[0] * trial[0] / stiffness[0] + trial[1] * trial[1] / stiffness[1];
    near(outcome.slip_increment, (1.0 - 1.0 / p) * elastic / p);
    for (i, k) in [0, 3].into_iter().enumerate() {
        near(outcome.force[k], trial[i] / p);
        near(outcome.slip[k], [0.01, 5.0][i] * (1.0 - 1.0 / p));
        near(tangent.force[k].forces[4], 0.5 * trial[i] / p);
        for (j, l) in [0, 3].into_iter().enumerate() {
            let own = if i == j { 1.0 / p } else { 0.0 };
            let slope = stiffness[j] * (own - trial[i] / (p * p) / [1.5, 0.8][j]);
            near(tangent.force[k].displacement[l], slope);
        }
    }
    // Where zero traction lies beyond the limit there is nothing to return to: no force is left, and all is slip.
    let outcome = of(8.0).update(&State::default(), &edge, Branch::Decided);
    assert!(outcome.flags.contains(&Flag::NoAdmissibleTraction), "{outcome:?}");
    assert_eq!(outcome.force, [0.0; 6]);
    [0.01, 0.0, 0.0, 5.0, 0.0, 0.0].into_iter().zip(outcome.slip).for_each(|(u, slip)| near(slip, u));
    near(outcome.slip_increment, elastic / (8.0 - trial[0] / 1.5 + trial[1] / 0.8));
}

/// Near the threshold the slip keeps its digits: it is the excess over the stiffness, and the limit it is measured by is as large as
/// the forces are. A hair is a hair at every size.
#[test]
fn slips_near_the_threshold_are_exact() {
    let conditions = Conditions::default();
    for size in [-40, 0, 40].map(|power| 2f64.powi(power)) {
        for (hair, is_near) in [(1e-13, true), (1e-11, false), (1e-6, false)] {
            let friction = friction(&slot(), &Coefficient::Constant(0.5), StickStiffness::Given(3.0 * size));
            let mut state = State::default();
            state.force[0] = 2.5 * size;
            let increment = input(
                [2.5 * hair / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 3.0 * size, 4.0 * size, 0.0, 0.0, 0.0],
            );
            let outcome = friction.update(&state, &increment, Branch::Decided);
            let exact = outcome.trial / (3.0 * size);
            assert_eq!((outcome.status, outcome.force[0]), (Status::Slip, 2.5 * size));
            assert!((outcome.slip_increment - exact).abs() <= 2.0 * U * exact, "{hair}: {outcome:?}");
            assert_eq!(outcome.flags.contains(&Flag::Threshold), is_near, "{size} {hair}");

            let belt = Belt {
                coefficient: Coefficient::Constant(0.5),
                maximum: None,
                stick_stiffness: StickStiffness::Given(3.0 * size),
            };
            let held = size * (0.5_f64).exp_m1();
            state.force[FLOW] = held;
            for (sign, status) in [(1.0, Status::Slip), (-1.0, Status::Stick)] {
                let flow = sign * held / size * hair / 3.0;
                let input = BeltInput {
                    flow,
                    tension: [size, 9.0 * size],
                    angle: 1.0,
                    duration: None,
                    conditions: &conditions,
                };
                let outcome = belt.update(&state, &input, Branch::Decided);
                assert_eq!(outcome.status, status);
                assert_eq!(outcome.flags.contains(&Flag::Threshold), is_near, "{size} {hair}");
                let exact = outcome.trial.max(0.0) / (3.0 * size);
                assert!((outcome.slip_increment - exact).abs() <= 2.0 * U * exact, "{hair}: {outcome:?}");
            }
        }
    }
    // Nothing that is free is near a threshold.
    let belt = Belt {
        coefficient: Coefficient::Constant(0.5),
        maximum: None,
        stick_stiffness: StickStiffness::Given(3.0),
    };
    let slack =
        BeltInput { flow: 0.0, tension: [0.0, 1.0], angle: 1.0, duration: None, conditions: &conditions };
    assert_eq!(belt.update(&State::default(), &slack, Branch::Decided).flags, vec![Flag::Slack]);
    let free = friction(&slot(), &Coefficient::Constant(0.5), StickStiffness::Given(3.0));
    let outcome = free.update(&State::default(), &input([0.0; 6], [0.0; 6]), Branch::Decided);
    assert!(!outcome.flags.contains(&Flag::Threshold), "{outcome:?}");
}

/// Without a duration, or with none that is positive, a slip rate is not formed: zero stands in, and that is told where μ needs it.
#[test]
fn a_slip_rate_needs_a_duration() {
    let conditions = Conditions::default();
    for (coefficient, needs) in [
        (Coefficient::Constant(0.5), false),
        (Coefficient::Exponential { at_rest: 0.5, kinetic: 0.25, decay: 2.0 }, true),
    ] {
        let friction = friction(&slot(), &coefficient, StickStiffness::Given(1e3));
        let belt = Belt {
            coefficient: coefficient.clone(),
            maximum: None,
            stick_stiffness: StickStiffness::Given(1e3),
        };
        for duration in [None, Some(0.0), Some(-1.0), Some(1.0)] {
            let mut increment = input([0.5, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 3.0, 4.0, 0.0, 0.0, 0.0]);
            increment.duration = duration;
            let over_ring =
                BeltInput { flow: 0.5, tension: [2.0, 9.0], angle: 1.0, duration, conditions: &conditions };
            for outcome in [
                friction.update(&State::default(), &increment, Branch::Decided),
                belt.update(&State::default(), &over_ring, Branch::Decided),
            ] {
                let has = duration == Some(1.0);
                assert_eq!(outcome.status, Status::Slip);
                assert_eq!(outcome.flags.contains(&Flag::NoDuration), needs && !has, "{duration:?}");
                let (rate, at_rest) = if has { (outcome.slip_increment, !needs) } else { (0.0, true) };
                assert_eq!(outcome.slip_rate, rate, "{duration:?}");
                assert_eq!(outcome.coefficient == 0.5, at_rest, "{duration:?}");
            }
        }
    }
}

/// The tension that holds is the one on the side from which the material comes: the side of the trial force, with what was carried.
#[test]
fn a_belt_is_held_from_where_it_comes() {
    let conditions = Conditions::default();
    let mut state: State<f64> = State::default();
    (state.force[FLOW], state.stick_stiffness) = (1.0, Some(0.25));
    for stick_stiffness in [StickStiffness::Given(0.25), StickStiffness::ElasticSlip(1e-3)] {
        let belt = Belt { coefficient: Coefficient::Constant(0.5), maximum: None, stick_stiffness };
        for (flow, held) in [(-0.0625, 3.0), (-3.75, 3.0), (-4.25, 7.0), (-32.0, 7.0), (1.0, 3.0)] {
            let input =
                BeltInput { flow, tension: [3.0, 7.0], angle: 1.0, duration: None, conditions: &conditions };
            let outcome = belt.update(&state, &input, Branch::Decided);
            assert_eq!((outcome.contact, outcome.normal), (held, held), "{stick_stiffness:?} {flow}");
        }
    }
}

/// The belt of the guide's example over a ring, α = π/2 and μ = 0.2: the second segment pulls 1.3691 times the first.
///
/// A spring of 5 per rad on a drum with β = 50 holds the first end: T1 = 5·50² Ψ1. Belt: 1e5 per unit strain; the segments are
/// 1 long, the far end is drawn by 0.1.
#[test]
fn a_seat_belt_slips_over_its_ring() {
    let conditions = Conditions::default();
    let belt = Belt {
        coefficient: Coefficient::Constant(0.2),
        maximum: None,
        stick_stiffness: StickStiffness::Given(1e6),
    };
    let (mut psi, mut state) = ([0.0_f64; 2], State::default());
    let mut last = None;
    for step in 1..=20 {
        let far = 1.0 + 0.1 * f64::from(step) / 20.0;
        let before = psi;
        let mut errors = Vec::new();
        for _ in 0..30 {
            let [length1, length2] = [1.0 + psi[0] - psi[1], 1.0 + psi[1]];
            let tension = [1e5 * (1.0 / length1 - 1.0), 1e5 * (far / length2 - 1.0)];
            let [slope1, slope2] = [-1e5 / (length1 * length1), -1e5 * far / (length2 * length2)];
            let input = BeltInput {
                flow: psi[1] - before[1],
                tension,
                angle: std::f64::consts::FRAC_PI_2,
                duration: None,
                conditions: &conditions,
            };
            let (outcome, tangent) = belt.tangent(&state, &input, Branch::Decided);
            let residual = [12_500.0 * psi[0] - tension[0], tension[0] - tension[1] + outcome.force[FLOW]];
            errors.push(residual[0].abs() + residual[1].abs());
            last = Some((outcome, tension));
            if errors.last().is_some_and(|error| *error < 1e-8) {
                break;
            }
            let [t1, t2] = [[slope1, -slope1], [0.0, slope2]];
            let friction = [0, 1].map(|j| {
                tangent.tension[0] * t1[j]
                    + tangent.tension[1] * t2[j]
                    + if j == 1 { tangent.flow } else { 0.0 }
            });
            let a = [12_500.0 - t1[0], -t1[1]];
            let b = [t1[0] - t2[0] + friction[0], t1[1] - t2[1] + friction[1]];
            let determinant = a[0] * b[1] - a[1] * b[0];
            psi[0] -= (residual[0] * b[1] - a[1] * residual[1]) / determinant;
            psi[1] -= (a[0] * residual[1] - residual[0] * b[0]) / determinant;
        }
        assert!(errors.len() < 12, "step {step}: {errors:?}");
        state = last.as_ref().unwrap().0.state();
    }
    let (outcome, [first, second]) = last.unwrap();
    assert_eq!(outcome.status, Status::Slip);
    assert!((psi[0] - 0.07636).abs() < 5e-6, "{psi:?}");
    assert!((first - 954.5).abs() < 0.05 && (second - 1306.8).abs() < 0.05, "{first} {second}");
    assert!((second / first - (0.1 * std::f64::consts::PI).exp()).abs() < 1e-9, "{}", second / first);
}

/// A belt's friction loses energy both ways, and a slack one carries none.
#[test]
fn belts_make_no_energy() {
    let mut draw = Draw::new("belt histories");
    let conditions = Conditions::default();
    let belt = Belt {
        coefficient: Coefficient::Exponential { at_rest: 0.4, kinetic: 0.3, decay: 1.0 },
        maximum: Some(2.0),
        stick_stiffness: StickStiffness::ElasticSlip(1e-3),
    };
    let mut state = State::default();
    let (mut work, mut lost, mut size) = (0.0, 0.0, 0.0);
    for step in 0..400 {
        let slack = step % 50 == 49;
        let input = BeltInput {
            flow: draw.between(-0.004, 0.004),
            tension: if slack { [-1.0, 0.0] } else { [draw.between(0.2, 9.0), draw.between(0.2, 9.0)] },
            angle: 1.2,
            duration: Some(0.01),
            conditions: &conditions,
        };
        let outcome = belt.update(&state, &input, Branch::Decided);
        work += outcome.force[FLOW] * input.flow;
        lost += outcome.dissipation;
        size += (outcome.force[FLOW] * input.flow).abs() + outcome.stored;
        assert!(outcome.criterion <= 4.0 * U * outcome.limit.max(outcome.trial.abs()));
        assert!(work >= lost + outcome.stored - gate("energy") * U * size);
        if slack {
            assert_eq!((outcome.status, outcome.force[FLOW]), (Status::Free, 0.0));
            assert_eq!(outcome.slip[FLOW].abs(), outcome.slip_increment);
            assert!(outcome.flags.contains(&Flag::Slack));
        }
        state = outcome.state();
    }
}

/// The update on 237 bits is the update: doubles follow it through a history.
#[test]
fn doubles_follow_the_wide_history() {
    let friction = friction(
        &slide_plane(),
        &Coefficient::Exponential { at_rest: 0.5, kinetic: 0.3, decay: 2.0 },
        StickStiffness::Given(30.0),
    );
    let mut draw = Draw::new("friction wide history");
    let (mut narrow, mut wide) = (State::default(), widened(&State::default()));
    for _ in 0..30 {
        let numbers = Numbers::drawn(&mut draw, 0.05);
        let a = friction.update(&narrow, &numbers.input(), Branch::Decided);
        let b = friction.update(&wide, &numbers.input::<Wide>(), Branch::Decided);
        assert_eq!(a.status, b.status);
        let miss = (Wide::from_f64(a.accumulated_slip) - b.accumulated_slip).to_f64();
        assert!(miss.abs() < 1e-15, "{miss}");
        (narrow, wide) = (a.state(), b.state());
    }
}

/// A tension that is no number is not taken for a slack belt: what rests on it is named.
#[test]
fn a_belt_without_a_number_is_named() {
    let conditions = Conditions::default();
    let belt = Belt {
        coefficient: Coefficient::Constant(0.2),
        maximum: None,
        stick_stiffness: StickStiffness::Given(1e6),
    };
    let input = |tension: [f64; 2]| BeltInput {
        flow: 0.1,
        tension,
        angle: 1.0,
        duration: None,
        conditions: &conditions,
    };
    let outcome = belt.update(&State::default(), &input([f64::NAN, 1.0]), Branch::Decided);
    assert!(outcome.flags.contains(&Flag::NotFinite { quantity: "limit" }), "{outcome:?}");
    assert!(!outcome.flags.contains(&Flag::Slack));
    let outcome = belt.update(&State::default(), &input([0.0, 1.0]), Branch::Decided);
    assert!(outcome.flags.contains(&Flag::Slack), "{outcome:?}");
}
