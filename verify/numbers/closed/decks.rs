//! Known answers of the decks that need forces: the known solution is fed, with inertia, gravity and what is external on this side, and
//! what is left at every free degree of freedom vanishes. (The belt's is in `behavior::belts`.)

use crate::tolerance::DECK_BALANCE;
use pintle_kinematics::vector::{Vector, cross, scale};
use pintle_model::evaluate::{ConnectorResult, Model, Plan, Selection, Sequence, request};
use pintle_scene::{ElementForces, GALLERY, Label, NodeMotion, Rotation, State};
use std::collections::BTreeMap;

fn gallery(name: &str) -> (Model, Vec<State>) {
    let example = GALLERY.iter().find(|example| example.name == name).unwrap();
    let scene = example.scene().unwrap();
    let states = example.states(&scene).unwrap().states;
    (Model::compile(&scene).unwrap(), states)
}

fn give(state: &mut State, element: u64, total: [f64; 6]) {
    state.forces.insert(element.into(), ElementForces { total: total.map(Some), ..ElementForces::default() });
}

/// The nodal forces of all connectors, by node and degree of freedom (0 to 6).
fn assembled(model: &Model, results: &[ConnectorResult]) -> BTreeMap<(Label, usize), f64> {
    let mut sum = BTreeMap::new();
    for result in results {
        let element = &model.connectors[result.index];
        let nodal = result.forces.as_ref().and_then(|forces| forces.nodal);
        let nodal = nodal.unwrap_or_else(|| panic!("{}: {:?}", element.title(), result.flags));
        for (j, force) in nodal.into_iter().enumerate() {
            if let Some(node) = element.nodes[j / 7] {
                *sum.entry((node, j % 7)).or_default() += force;
            }
        }
    }
    sum
}

fn assert_balance(place: &str, sum: &BTreeMap<(Label, usize), f64>, free: &[u64], size: f64) {
    for ((node, dof), rest) in sum {
        if free.iter().any(|free| *node == Label::from(*free)) {
            assert!(rest.abs() <= DECK_BALANCE * size, "{place}, node {node}, {dof}: {rest}");
        }
    }
}

/// The bar falls from the horizontal: (m L² + I) φ̈ = −m g L cos φ and its energy, φ̇² = −2 m g L sin φ/(m L² + I). The hinge carries
/// m (g − a); at the bottom |φ̇| = 4.3227 after 0.6066, and the pin 56.99.
#[test]
fn the_pendulum_is_in_dynamic_equilibrium() {
    let (mass, inertia, length, g) = (2.0, 0.1, 1.0, 9.81);
    let whole: f64 = mass * length * length + inertia;
    let rate = |phi: f64| -(-2.0 * mass * g * length * phi.sin() / whole).sqrt();
    let (model, _) = gallery("hinge_pendulum");
    let plan = Plan::compile(
        &model,
        &Selection::All,
        request(["NF", "RES", "RESV", "RESA", "CVF", "CRF"], 0).unwrap(),
    )
    .unwrap();
    let mut sequence = Sequence::new(&model, &plan);
    let mut last = (0.0, 0.0);
    for step in 0..=16 {
        let phi = -std::f64::consts::FRAC_PI_2 * f64::from(step) / 16.0;
        let (omega, alpha) = (rate(phi), -mass * g * length * phi.cos() / whole);
        let (sin, cos) = phi.sin_cos();
        let arm = [length * cos, length * sin, 0.0];
        let spin = |rate: f64| cross([0.0, 0.0, rate], arm);
        let velocity = spin(omega);
        let acceleration = [0, 1, 2].map(|i| spin(alpha)[i] - omega * omega * arm[i]);
        let turn = NodeMotion {
            rotation: Rotation::Vector([0.0, 0.0, phi]),
            angular_velocity: [0.0, 0.0, omega],
            angular_acceleration: [0.0, 0.0, alpha],
            ..NodeMotion::default()
        };
        let end = NodeMotion { displacement: [arm[0] - length, arm[1], 0.0], velocity, acceleration, ..turn };
        let mut state =
            State { nodes: BTreeMap::from([(2.into(), turn), (3.into(), end)]), ..State::default() };
        // What the arm leaves for node 3: −m a + m g, and −I α.
        let pull: Vector<f64> = [-mass * acceleration[0], -mass * (acceleration[1] + g), 0.0];
        let along = [cos * pull[0] + sin * pull[1], cos * pull[1] - sin * pull[0], 0.0];
        give(&mut state, 102, [along[0], along[1], 0.0, 0.0, 0.0, -inertia * alpha]);
        // The axes of the hinge are z, x, y; it is free to turn.
        give(&mut state, 101, [0.0, pull[0], pull[1], 0.0, 0.0, 0.0]);
        let results = sequence.step(&state).connectors;
        let mut sum = assembled(&model, &results);
        for (i, (a, gravity)) in acceleration.into_iter().zip([0.0, -g, 0.0]).enumerate() {
            *sum.get_mut(&(3.into(), i)).unwrap() += mass * (a - gravity);
        }
        *sum.get_mut(&(3.into(), 5)).unwrap() += inertia * alpha;
        assert_balance(&format!("φ = {phi}"), &sum, &[2, 3], mass * g);
        for result in &results {
            let evaluation = &result.evaluation;
            let of = [&evaluation.residual, &evaluation.residual_rate, &evaluation.residual_acceleration];
            for rest in of.into_iter().flatten().flatten() {
                assert!(rest.abs() < 1e-13, "{phi}: {rest}");
            }
        }
        last = (omega, sum[&(Label::from(1), 1)]);
    }
    // The reaction on the ground is minus what carries the weight: residual-side.
    assert!((last.0 + 4.3227).abs() < 5e-5 && (last.1.abs() - 56.99).abs() < 5e-3, "{last:?}");
    // φ = −x² makes dφ/φ̇ smooth.
    let n = 2000;
    let top = std::f64::consts::FRAC_PI_2.sqrt();
    let middle = |i: i32| (f64::from(i) + 0.5) * top / f64::from(n);
    let time: f64 = (0..n).map(|i| -2.0 * middle(i) / rate(-middle(i).powi(2)) * top / f64::from(n)).sum();
    assert!((time - 0.6066).abs() < 5e-5, "{time}");
}

/// The crank drives against the friction of the guide: with the force S along the rod, f1 = ±μ (10 + |S sin ψ|) = ±S cos ψ, so that
/// S = 10 μ/(cos ψ − μ |sin ψ|), and the hinge takes the moment of S about its axis. Friction itself finds f1 from what presses.
#[test]
fn the_slider_crank_is_in_equilibrium() {
    let (model, mut states) = gallery("slider_crank");
    let (crank, rod, friction) = (0.2, 0.6, 0.1);
    let plan = Plan::compile(
        &model,
        &Selection::All,
        request(["NF", "CSF", "CNF", "CRF", "DRIVEN", "SLIP"], 0).unwrap(),
    )
    .unwrap();
    let mut sequence = Sequence::new(&model, &plan);
    let mut before = 0.0;
    let mut torques = Vec::new();
    for (i, state) in states.iter_mut().enumerate() {
        let theta = 2.0 * std::f64::consts::PI * i as f64 / 24.0;
        let sine = -crank / rod * theta.sin();
        let cosine = (1.0 - sine * sine).sqrt();
        let slider = crank * theta.cos() + rod * cosine - crank - rod;
        let way = if i == 0 { 0.0 } else { (slider - before).signum() };
        before = slider;
        let size = 10.0 * friction / (cosine - friction * sine.abs());
        // The force of every link on its node b, towards the slider.
        let force = scale([cosine, sine, 0.0], -way * size);
        let tip = [crank * theta.cos(), crank * theta.sin(), 0.0];
        let torque = cross(tip, force)[2];
        let local = |c: f64, s: f64| [c * force[0] + s * force[1], c * force[1] - s * force[0]];
        let with = |f: [f64; 3]| [f[0], f[1], f[2], 0.0, 0.0, 0.0];
        // Axes: z, x, y of the hinge and the universal joint.
        give(state, 101, [0.0, force[0], force[1], torque, 0.0, 0.0]);
        let (cos, sin) = (theta.cos(), theta.sin());
        let [x, y] = local(cos, sin);
        give(state, 102, with([x, y, 0.0]));
        // JOIN follows node 3, the tip of the crank.
        let joined = ElementForces {
            total: [Some(x), Some(y), Some(0.0), None, None, None],
            ..ElementForces::default()
        };
        state.forces.insert(103.into(), joined);
        let [x, y] = local(cosine, sine);
        give(state, 104, with([x, y, 0.0]));
        give(state, 105, with([0.0, -force[0], -force[1]]));
        let guide = with([-force[0], -force[1], 0.0]);
        give(state, 106, guide);
        let results = sequence.step(state).connectors;
        let sum = assembled(&model, &results);
        assert_balance(&format!("state {i}"), &sum, &[2, 3, 4, 5, 6], 2.0);
        let slide =
            results.iter().find(|result| model.connectors[result.index].label == Label::from(106)).unwrap();
        let slip = slide.behavior.as_ref().unwrap().slips[0].outcome.as_ref().unwrap();
        assert!((slip.force[0] - guide[0]).abs() < DECK_BALANCE, "{i}: {slip:?}");
        if i > 0 {
            assert!(
                (slip.normal - (10.0 + (size * sine).abs())).abs() < DECK_BALANCE * 10.0,
                "{i}: {slip:?}"
            );
        }
        torques.push(torque);
        // Nothing but the motion holds the crank: all of its moment is the reaction.
        let drive =
            results.iter().find(|result| model.connectors[result.index].label == Label::from(101)).unwrap();
        assert_eq!(drive.behavior.as_ref().unwrap().reaction.value[3], Some(torque));
    }
    // The motion drives the crank all the way round, which as an internal moment is negative, and lifts nothing where the rod is in
    // line with it.
    assert!(torques.iter().enumerate().all(|(i, torque)| *torque < 0.0 || i % 12 == 0), "{torques:?}");
    assert!(torques[12].abs() < 1e-14, "{torques:?}");
}
