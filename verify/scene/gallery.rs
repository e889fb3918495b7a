//! The built-in scenes: what the decks say, and that the states satisfy the equations of their mechanisms.
//!
//! The equations are written here in other words than in scripts/gallery_states.py: constraints on positions,
//! rotation matrices and forces, not solutions.

use super::n;
use pintle_kinematics::connector::Request;
use pintle_kinematics::mpc::MpcType;
use pintle_model::evaluate::{Model, Plan, Selection, Sequence};
use pintle_scene::{
    Example, GALLERY, Label, Law, MpcKind, NodeMotion, Procedure, Rotation, Scene, Solver, State,
};
use std::f64::consts::{PI, TAU};

fn example(name: &str) -> (Scene, Vec<State>) {
    let example: &Example = GALLERY.iter().find(|example| example.name == name).unwrap();
    let scene = example.scene().unwrap_or_else(|error| panic!("{}", error.render(110, false)));
    assert!(scene.warnings.is_empty() && scene.skipped.keywords.is_empty(), "{name}");
    let states = example.states(&scene).unwrap_or_else(|error| panic!("{}", error.render(110, false)));
    (scene, states.states)
}

fn position(scene: &Scene, state: &State, node: u64) -> [f64; 3] {
    let start = scene.nodes[&n(node)].coordinates;
    let motion = state.nodes.get(&n(node)).copied().unwrap_or_default();
    std::array::from_fn(|k| start[k] + motion.displacement[k])
}

fn vector(motion: &NodeMotion) -> [f64; 3] {
    match motion.rotation {
        Rotation::Vector(vector) => vector,
        Rotation::Quaternion(quaternion) => panic!("a quaternion: {quaternion:?}"),
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn close(got: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((got - wanted).abs() <= tolerance, "{what}: {got}, not {wanted}");
}

/// Rotation matrix of a quaternion, rows first.
fn matrix([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Quaternion of a rotation vector; good enough away from zero.
fn quaternion(theta: [f64; 3]) -> [f64; 4] {
    let angle = dot(theta, theta).sqrt();
    let factor = if angle > 0.0 { (angle / 2.0).sin() / angle } else { 0.5 };
    [(angle / 2.0).cos(), theta[0] * factor, theta[1] * factor, theta[2] * factor]
}

fn product(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

#[test]
fn names_are_unique_and_summaries_short() {
    for (index, example) in GALLERY.iter().enumerate() {
        assert!(GALLERY[..index].iter().all(|other| other.name != example.name));
        assert!(example.summary.len() < 100);
    }
}

#[test]
fn hinge_pendulum_reads_as_written() {
    let (scene, states) = example("hinge_pendulum");
    assert_eq!(scene.heading, "hinge pendulum: node 1 ground, node 2 pin on body, node 3 mass centre");
    assert_eq!((scene.nodes.len(), scene.connectors.len(), scene.point_elements.len()), (3, 2, 2));
    assert_eq!(scene.node_sets["GROUND"].labels, [1]);
    let connector = scene.connectors[&n(101)];
    assert_eq!((connector.a, connector.b), (Some(n(1)), Some(n(2))));
    let section = scene.section(&connector).unwrap();
    assert_eq!(section.type_names[0].value, "HINGE");
    assert_eq!(section.orientation_a.as_ref().unwrap().value, "HAXIS");
    assert!(section.orientation_b.is_none() && section.section_data.is_empty());
    let behavior = scene.behavior(section).unwrap();
    let [stop] = behavior.stops.as_slice() else { panic!("{:?}", behavior.stops) };
    assert_eq!((stop.component, stop.lower, stop.upper), (4, Some(-3.2), Some(3.2)));
    let Law::Linear { component: 4, rows } = &behavior.damping[0].law else {
        panic!("{:?}", behavior.damping)
    };
    assert_eq!(rows[0].values, [Some(0.0), None]);
    assert_eq!(scene.masses[0].mass, 2.0);
    assert_eq!(scene.rotary_inertias[0].inertia, [0.1, 0.1, 0.1, 0.0, 0.0, 0.0]);
    assert_eq!(scene.boundaries[0].degrees_of_freedom, [1, 2, 3, 4, 5, 6]);
    let [step] = scene.steps.as_slice() else { panic!("{:?}", scene.steps) };
    assert_eq!(
        (step.nlgeom, step.increments, scene.solver),
        (Some(true), Some(2000), Some(Solver::Standard))
    );
    let Some(Procedure::Dynamic { explicit: false, times }) = &step.procedure else { panic!("{step:?}") };
    assert_eq!((times.total, times.minimum), (Some(0.6066), Some(1e-6)));
    assert_eq!(step.distributed_loads[0].label, "GRAV");
    assert_eq!(step.distributed_loads[0].values, [Some(9.81), Some(0.0), Some(-1.0), Some(0.0)]);
    assert_eq!(step.outputs[1].variables, ["CU", "CP", "CTF", "CRF", "CSF", "CSLST"]);

    let triad = scene.orientations["HAXIS"].triad("HAXIS", &scene, [0.0; 3], &[]).unwrap();
    assert_eq!(triad, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);

    let mut last = -1.0;
    for state in &states {
        let body = state.nodes[&n(3)];
        let phi = vector(&body)[2];
        assert!(phi > last);
        last = phi;
        let at = position(&scene, state, 3);
        close(dot(at, at), 1.0, 4e-16, "the mass stays on its circle");
        close(at[1].atan2(at[0]), phi.sin().atan2(phi.cos()), 1e-14, "angle of the mass");
        close(dot(at, body.velocity), 0.0, 1e-14, "velocity along the circle");
        let rate = body.angular_velocity[2];
        close(dot(body.velocity, body.velocity), rate * rate, 1e-13 * rate * rate, "speed");
        close(dot(body.acceleration, at), -rate * rate, 1e-13 * rate * rate, "centripetal acceleration");
        let tangential = at[0] * body.acceleration[1] - at[1] * body.acceleration[0];
        close(tangential, body.angular_acceleration[2], 1e-12, "tangential acceleration");
        assert_eq!(vector(&state.nodes[&n(2)]), vector(&body));
    }
    assert_eq!(states.len(), 25);
    close(last, 3.0 * TAU, 1e-14, "three turns");
}

#[test]
#[expect(clippy::approx_constant, reason = "the deck writes these digits")]
fn slider_crank_satisfies_its_joints() {
    let (scene, states) = example("slider_crank");
    assert_eq!((scene.nodes.len(), scene.connectors.len(), scene.connector_sections.len()), (7, 6, 6));
    let slide = scene.section(&scene.connectors[&n(106)]).unwrap();
    let behavior = scene.behavior(slide).unwrap();
    let [friction] = behavior.friction.as_slice() else { panic!("{behavior:?}") };
    let json = serde_json::to_value(friction).unwrap();
    assert_eq!(json["kind"]["predefined"]["constants"], serde_json::json!([0.05, 0.1, 10.0]));
    assert_eq!(json["coefficient"]["law"]["table"][0]["values"], serde_json::json!([0.1, null, null]));
    let motion = &scene.steps[0].connector_motions[0];
    assert_eq!((motion.component, motion.magnitude), (4, Some(6.283185307)));
    assert_eq!(motion.applied.amplitude.as_ref().unwrap().value, "TURN");
    assert_eq!(scene.amplitudes["TURN"].data, [Some(0.0), Some(0.0), Some(1.0), Some(1.0)]);
    let Some(Procedure::Static(times)) = &scene.steps[0].procedure else { panic!("{:?}", scene.steps) };
    assert_eq!((times.initial, times.total), (Some(0.01), Some(1.0)));

    let rod = distance(scene.nodes[&n(5)].coordinates, scene.nodes[&n(4)].coordinates);
    for state in &states {
        let at = |node| position(&scene, state, node);
        assert_eq!(at(3), at(4));
        assert_eq!(at(5), at(6));
        close(distance(at(2), at(3)), 0.2, 1e-16, "crank");
        close(distance(at(4), at(5)), rod, 2e-16, "rod");
        assert_eq!((at(6)[1], at(6)[2]), (0.0, 0.0));
        let (crank, turn) = (vector(&state.nodes[&n(3)])[2], vector(&state.nodes[&n(4)])[2]);
        close(at(5)[0] - at(4)[0], rod * turn.cos(), 2e-16, "rod angle, along");
        close(at(5)[1] - at(4)[1], rod * turn.sin(), 2e-16, "rod angle, across");
        close(at(3)[1], 0.2 * crank.sin(), 1e-16, "crank angle");
        // The slider moves as a point of the rod: v5 = v4 + ω × (x5 − x4), a5 = a4 + α × r − ω² r.
        let (from, to) = (state.nodes[&n(4)], state.nodes[&n(5)]);
        let (w, alpha) = (from.angular_velocity[2], from.angular_acceleration[2]);
        let r = [at(5)[0] - at(4)[0], at(5)[1] - at(4)[1]];
        close(to.velocity[0], from.velocity[0] - w * r[1], 1e-14, "v1");
        close(0.0, from.velocity[1] + w * r[0], 1e-14, "v2");
        close(to.acceleration[0], from.acceleration[0] - alpha * r[1] - w * w * r[0], 2e-14, "a1");
        close(0.0, from.acceleration[1] + alpha * r[0] - w * w * r[1], 2e-14, "a2");
    }
    let angles = [(6, 0.5 * PI, -0.23431), (12, PI, -0.4), (18, 1.5 * PI, -0.23431), (24, TAU, 0.0)];
    for (index, angle, travel) in angles {
        assert_eq!(vector(&states[index].nodes[&n(2)])[2], angle);
        close(states[index].nodes[&n(6)].displacement[0], travel, 5e-6, "travel of the slider");
    }
    assert_eq!(states[6].nodes[&n(3)].displacement, [-0.2, 0.2, 0.0]);
    assert_eq!(states[12].nodes[&n(6)].displacement[0], -0.4);
}

#[test]
#[expect(clippy::approx_constant, reason = "the deck writes these digits")]
fn seat_belt_is_in_equilibrium() {
    let (scene, states) = example("seat_belt");
    assert_eq!((scene.nodes.len(), scene.connectors.len()), (5, 4));
    let retractor = scene.section(&scene.connectors[&n(102)]).unwrap();
    assert_eq!(retractor.section_data, [Some(50.0)]);
    let belt = scene.section(&scene.connectors[&n(103)]).unwrap();
    assert!(belt.orientation_a.is_none() && belt.orientation_b.is_none());
    assert_eq!(belt.section_data, [Some(0.06), Some(1.5707963)]);
    let elasticity = &scene.behavior(belt).unwrap().elasticity[0];
    let Law::Nonlinear { component: 1, independent: None, rows } = &elasticity.law else {
        panic!("{elasticity:?}")
    };
    let points: Vec<_> = rows.iter().map(|row| (row.values[0].unwrap(), row.values[1].unwrap())).collect();
    assert_eq!(points, [(0.0, -1.0), (0.0, 0.0), (1e5, 1.0)]);
    let flow = scene.boundaries.last().unwrap();
    assert_eq!((flow.degrees_of_freedom.as_slice(), flow.magnitude), ([10].as_slice(), 0.0));

    for state in &states {
        let flow = |node| state.nodes.get(&n(node)).map_or(0.0, |motion| motion.flow);
        let turn = vector(&state.nodes[&n(1)])[2];
        close(turn, 50.0 * flow(10), 1e-15, "retractor");
        close(
            state.nodes[&n(1)].angular_velocity[2],
            50.0 * state.nodes[&n(10)].flow_velocity,
            1e-15,
            "retractor rate",
        );
        let tension = |a, b| {
            let length = distance(position(&scene, state, a), position(&scene, state, b));
            let start = distance(scene.nodes[&n(a)].coordinates, scene.nodes[&n(b)].coordinates);
            1e5 * (length / (start + flow(a) - flow(b)) - 1.0)
        };
        let (first, second) = (tension(10, 20), tension(20, 30));
        close(first, second, 1e-10, "equal tensions");
        close(first, 5.0 * turn * 50.0, 1e-10, "drum spring");
    }
    let last = states.last().unwrap();
    close(last.nodes[&n(10)].flow, 0.07937, 5e-6, "flow");
    close(vector(&last.nodes[&n(1)])[2], 3.9685, 5e-5, "drum");
    assert_eq!(last.nodes[&n(30)].displacement, [0.1, 0.0, 0.0]);
}

/// The joints of the assembly hold, and turn as far as the cranks do.
#[test]
fn parallel_cranks_stay_parallel() {
    let (scene, states) = example("parallel_cranks");
    let label = |text: &str| text.parse::<Label>().unwrap();
    assert_eq!((scene.nodes.len(), scene.connectors.len(), scene.orientations.len()), (8, 7, 4));
    assert_eq!(scene.node_sets["TIPS"].labels, [label("Crank-1.2"), label("Crank-2.2")]);
    for (node, place) in [
        ("Crank-1.1", [0.0, 0.0, 0.0]),
        ("Crank-1.2", [0.0, 0.5, 0.0]),
        ("Crank-2.1", [1.0, 0.0, 0.0]),
        ("Crank-2.2", [1.0, 0.5, 0.0]),
        ("Coupler-1.1", [0.0, 0.5, 0.0]),
        ("Coupler-1.2", [1.0, 0.5, 0.0]),
    ] {
        assert_eq!(scene.nodes[&label(node)].coordinates, place, "{node}");
    }
    let triad = |name: &str| scene.orientations[name].triad(name, &scene, [0.0; 3], &[]).unwrap();
    assert_eq!(triad("CRANK-2.PIN")[..2], [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
    assert_eq!(triad("COUPLER-1.Datum csys-1")[..2], [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);

    let model = Model::compile(&scene).unwrap();
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    let plan = Plan::compile(&model, &Selection::All, Request::everything(1)).unwrap();
    let mut walk = Sequence::new(&model, &plan);
    let mut turned = 0.0;
    for state in &states {
        let at = |node: &str| {
            let motion = state.nodes[&label(node)];
            let start = scene.nodes[&label(node)].coordinates;
            std::array::from_fn(|k| start[k] + motion.displacement[k])
        };
        let foot = scene.nodes[&label("Crank-2.1")].coordinates;
        // Coordinates around 1 are rounded by 1.1e-16.
        close(distance(at("Crank-2.2"), foot), 0.5, 3e-16, "crank");
        close(distance(at("Coupler-1.1"), at("Coupler-1.2")), 1.0, 3e-16, "coupler");
        turned = vector(&state.nodes[&label("Crank-1.1")])[2];
        let result = walk.step(state);
        for connector in &result.connectors {
            let element = &model.connectors[connector.index];
            let evaluation = &connector.evaluation;
            for residual in evaluation.residual.iter().flatten() {
                close(*residual, 0.0, 2e-15, &format!("constraint of {}", element.label));
            }
            let wanted = match element.label.to_string().as_str() {
                "1" | "2" => turned,
                "3" => -turned,
                _ => continue,
            };
            close(evaluation.displacement[3].unwrap(), wanted, 1e-14, "angle of the joint");
        }
    }
    assert_eq!(turned, scene.steps[0].connector_motions[0].magnitude.unwrap());
}

#[test]
fn revolute_mpc_holds_through_its_turns() {
    let (scene, states) = example("revolute_mpc");
    let kinds: Vec<_> = scene.mpcs.iter().map(|mpc| (mpc.kind.clone(), mpc.nodes.clone())).collect();
    assert_eq!(
        kinds,
        [
            (MpcKind::Evaluated(MpcType::Revolute), [10, 20, 30].map(n).to_vec()),
            (MpcKind::Evaluated(MpcType::Pin), [10, 20].map(n).to_vec())
        ]
    );
    assert_eq!(scene.springs[0].degrees_of_freedom, [6]);
    let axis = [2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0];
    let triad = scene.orientations["AXIS"].triad("AXIS", &scene, [0.0; 3], &[]).unwrap();
    close(distance(triad[0], axis), 0.0, 2e-16, "e1 is the axis of the joint");
    for state in &states {
        let (dependent, master, joint) = (state.nodes[&n(10)], state.nodes[&n(20)], state.nodes[&n(30)]);
        assert_eq!((dependent.displacement, dependent.velocity), (master.displacement, master.velocity));
        let Rotation::Quaternion(q) = dependent.rotation else { panic!("{dependent:?}") };
        let phi = vector(&joint)[2];
        let carried = matrix(quaternion(vector(&master)));
        let wanted = product(carried, matrix(quaternion(axis.map(|part| part * phi))));
        let got = matrix(q);
        let a: [f64; 3] = std::array::from_fn(|i| dot(carried[i], axis));
        for i in 0..3 {
            close(distance(got[i], wanted[i]), 0.0, 1e-14, "C_S = C_M C(φ a0)");
            let spin = master.angular_velocity[i] + joint.angular_velocity[2] * a[i];
            close(dependent.angular_velocity[i], spin, 1e-13, "ω_S = ω_M + φ′ a");
        }
    }
    close(vector(&states[32].nodes[&n(30)])[2], 2.9 * TAU, 1e-14, "2.9 turns of the joint");
    let turned = vector(&states[32].nodes[&n(20)]);
    close(dot(turned, turned).sqrt(), 1.5 * TAU, 1e-14, "one and a half turns of the master");
}
