//! What acts on the angles of hinges of multi-point constraints, and what these transmit, as `eval` tells it.

use crate::states::Draw;
use crate::tolerance::HINGE;
use pintle_kinematics::connector::Flag;
use pintle_kinematics::mpc::{DOFS, Dofs, PHI, THETA_M, THETA_S, XM, XS};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, dot};
use pintle_model::evaluate::{Model, MpcResult, Plan, Selection, Sequence, request};
use pintle_report::unevaluated;
use pintle_scene::{ElementForces, ForceFile, ForceSign, GALLERY, NodeMotion, Rotation, Scene, State};

/// A universal joint with the axes 3 and 1, a spring and a dashpot on the first angle, a moment on it, the second angle prescribed.
const DECK: &str = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n3, 0., 0., 1.\n4, 1., 0., 0.\n*MPC\nUNIVERSAL, 1, 2, 3, 4\n\
    *ELEMENT, TYPE=SPRING1, ELSET=K\n11, 3\n*SPRING, ELSET=K\n6\n2.5\n\
    *ELEMENT, TYPE=DASHPOT1, ELSET=C\n13, 3\n*DASHPOT, ELSET=C\n6\n0.5\n\
    *AMPLITUDE, NAME=A\n0., 0., 2., 2.\n*STEP\n*STATIC\n0.1, 2.\n*CLOAD, AMPLITUDE=A\n3, 6, 7.\n3, 6, -1.\n\
    *BOUNDARY, AMPLITUDE=A\n4, 6, 6, 0.3\n*END STEP\n*STEP\n*STATIC\n0.1, 1.\n*BOUNDARY, OP=NEW\n4, 6, 6, 0.9\n*END STEP\n";

fn state(time: f64, angles: [f64; 2], rate: f64) -> State {
    let turn = |angle: f64, rate: f64| NodeMotion {
        rotation: Rotation::Vector([0.0, 0.0, angle]),
        angular_velocity: [0.0, 0.0, rate],
        ..NodeMotion::default()
    };
    let [first, second] = [[0.0, 0.0, angles[0]], [angles[1], 0.0, 0.0]].map(so3::exp_quaternion);
    let slave =
        NodeMotion { rotation: Rotation::Quaternion(so3::compose(first, second)), ..NodeMotion::default() };
    let nodes = [(1, slave), (3, turn(angles[0], rate)), (4, turn(angles[1], 0.0))];
    State {
        time: Some(time),
        nodes: nodes.map(|(node, motion)| (node.into(), motion)).into(),
        ..State::default()
    }
}

fn step(model: &Model, state: &State) -> MpcResult {
    let names = [
        "CP", "CV", "CEF", "CVF", "CCF", "CRF", "CTF", "DRIVEN", "RES", "NF", "LM", "KG", "DNF", "KT", "CT",
        "KR",
    ];
    let plan = Plan::compile(model, &Selection::All, request(names, 0).unwrap()).unwrap();
    Sequence::new(model, &plan).step(state).mpcs.remove(0)
}

fn near(got: f64, want: f64) {
    assert!((got - want).abs() <= HINGE * (1.0 + want.abs()), "{got} {want}");
}

/// A free angle: M_J is what moment, spring and dashpot leave. A prescribed one: what it is off, and a reaction that is not known
/// without forces.
#[test]
fn moments_and_prescribed_angles() {
    let scene = Scene::parse("joint.inp", DECK).unwrap();
    let model = Model::compile(&scene).unwrap();
    let left: Vec<_> = unevaluated(&scene, &model).into_iter().map(|note| (note.count, note.what)).collect();
    assert_eq!(left, [(2, "solutions of steps")], "what acts on hinges alone is evaluated");
    for time in [0.0, 0.25, 1.5, 2.0] {
        let result = step(&model, &state(time, [0.4, 0.3 * time + 0.01], -0.2));
        let [first, second] = result.hinges.map(Option::unwrap);
        near(first.load.unwrap().unwrap(), 6.0 * time);
        near(first.constraint.unwrap(), 6.0 * time - 2.5 * 0.4 + 0.5 * 0.2);
        assert_eq!(first.reaction, Ok(0.0));
        near(second.prescribed.unwrap().value().1.unwrap(), 0.3 * time);
        near(second.residual[0].unwrap(), 0.01);
        // The amplitude ramps by 1 per time.
        near(second.residual[1].unwrap(), -0.3);
        assert!(second.constraint.is_err() && second.reaction.is_err() && second.load.is_none());
        assert!(result.forces.is_none());
        // What spring and dashpot do to KT and CT is known without forces; that KG is not is told.
        let slopes = result.slopes.as_ref().unwrap();
        let (stiffness, damping) = (slopes.tangent.as_ref().unwrap(), slopes.damping.as_ref().unwrap());
        let mut rest: f64 = -2.5 - 0.5;
        rest += stiffness.iter().chain(damping.iter()).flatten().map(|x| x.abs()).sum::<f64>();
        assert_eq!((stiffness[PHI][PHI], damping[PHI][PHI], rest), (2.5, 0.5, 0.0));
        let told = |flag: &Flag| matches!(flag, Flag::NotKnown { quantity: "KG", component: "all", .. });
        assert!(result.flags.iter().any(told), "{:?}", result.flags);
    }
    let block = |text: &str| {
        let scene = Scene::parse("joint.inp", text).unwrap();
        let model = Model::compile(&scene).unwrap();
        step(&model, &state(0.25, [0.4, 0.1], -0.2))
    };
    let bare = DECK.replace("*ELEMENT, TYPE=SPRING1, ELSET=K\n11, 3\n*SPRING, ELSET=K\n6\n2.5\n", "");
    let bare = bare.replace("*ELEMENT, TYPE=DASHPOT1, ELSET=C\n13, 3\n*DASHPOT, ELSET=C\n6\n0.5\n", "");
    assert!(block(&bare).slopes.is_none() && block(DECK).slopes.is_some());
    // Forces of which some are not given give nothing, and that is told.
    let mut refused = state(0.25, [0.4, 0.1], 0.0);
    refused
        .mpc_forces
        .insert("1-2-3-4".into(), ElementForces { total: [None; 6], ..ElementForces::default() });
    let result = step(&model, &refused);
    let told = |flag: &Flag| matches!(flag, Flag::NotKnown { component: "f1" | "m1", quantity: "NF", .. });
    assert!(result.forces.is_none() && result.flags.iter().any(told), "{:?}", result.flags);
    // OP=NEW: the moment stays as it was at the end of its step, the angle goes on from there.
    let result = step(&model, &state(2.5, [0.4, 0.75], 0.0));
    let [first, second] = result.hinges.map(Option::unwrap);
    near(first.load.unwrap().unwrap(), 12.0);
    near(second.residual[0].unwrap(), 0.0);
}

/// Forces on the first node: M_M = −M_S, M_J = −M_S·a = M_M·a, the reaction of a prescribed angle, and a free angle that is not in
/// balance; by NF, LM and tangents.
#[test]
fn given_forces_are_transmitted() {
    let scene = Scene::parse("joint.inp", DECK).unwrap();
    let model = Model::compile(&scene).unwrap();
    let mut draw = Draw::new("hinges");
    for _ in 0..20 {
        let angles = [draw.between(-2.0, 2.0), draw.between(-1.0, 1.0)];
        let (time, rate) = (draw.between(0.1, 1.9), draw.between(-1.0, 1.0));
        let mut at = state(time, angles, rate);
        let mut moment: Vector<f64> = draw.vector(3.0);
        let bare = step(&model, &at);
        let axes = bare.evaluation.axes.map(Option::unwrap);
        // What the first hinge leaves is what M_S·a1 has to be.
        let wanted = bare.hinges[0].unwrap().constraint.unwrap();
        let off = -wanted - dot(moment, axes[0]);
        (0..3).for_each(|i| moment[i] += off * axes[0][i]);
        let given = |moment: Vector<f64>| ElementForces {
            total: [None, None, None, Some(moment[0]), Some(moment[1]), Some(moment[2])],
            ..ElementForces::default()
        };
        at.mpc_forces.insert("1-2-3-4".into(), given(moment));
        model.check_forces(std::slice::from_ref(&at), 0, "given").unwrap();
        let result = step(&model, &at);
        let is_off = |result: &MpcResult| {
            result.flags.iter().any(|flag| matches!(flag, Flag::OutOfBalance { component: "φ1", .. }))
        };
        assert!(!is_off(&result), "{:?}", result.flags);
        let forces = result.forces.as_ref().unwrap();
        for i in 0..3 {
            near(forces.nodal[THETA_S + i], moment[i]);
            near(forces.nodal[THETA_M + i], -moment[i]);
            assert_eq!((forces.nodal[XS + i], forces.nodal[XM + i]), (0.0, 0.0));
        }
        for i in 0..2 {
            near(forces.nodal[PHI + i], -dot(moment, axes[i]));
            near(result.hinges[i].unwrap().constraint.unwrap(), -dot(moment, axes[i]));
        }
        near(result.hinges[1].unwrap().reaction.unwrap(), dot(moment, axes[1]));
        // KR · λ = NF, and what springs and dashpots add to the tangents.
        let mut sum: Dofs<f64> = [0.0; DOFS];
        for (column, multiplier) in forces.by_multipliers.iter().zip(forces.multipliers) {
            let (Some(column), Some(multiplier)) = (column, multiplier) else { continue };
            (0..DOFS).for_each(|j| sum[j] += column[j] * multiplier);
        }
        (0..DOFS).for_each(|j| near(sum[j], forces.nodal[j]));
        let [tangent, geometric, damping] =
            [&forces.tangent, &forces.geometric, &forces.damping].map(|of| of.as_ref().unwrap());
        for i in 0..DOFS {
            for j in 0..DOFS {
                let [k, c] = if (i, j) == (PHI, PHI) { [2.5, 0.5] } else { [0.0; 2] };
                near(tangent[i][j] - geometric[i][j], k);
                assert_eq!(damping[i][j], c);
            }
        }
        // A moment that the free hinge cannot carry.
        at.mpc_forces.insert("1-2-3-4".into(), given([0, 1, 2].map(|i| moment[i] + 0.1 * axes[0][i])));
        assert!(is_off(&step(&model, &at)));
        let on_b = ElementForces { sign: ForceSign::ConstraintsOnB, ..given(moment.map(|m| -m)) };
        at.mpc_forces.insert("1-2-3-4".into(), on_b);
        near(step(&model, &at).forces.unwrap().nodal[THETA_S], moment[0]);
    }
}

/// CSV, JSON and scenes name an MPC by its nodes; what it does not transmit is refused.
#[test]
fn mpcs_are_named_by_their_nodes() {
    let scene = Scene::parse("joint.inp", DECK).unwrap();
    let model = Model::compile(&scene).unwrap();
    let mut states = [state(1.0, [0.4, 0.3], 0.0)];
    let csv = "element,m1,m2,m3,f1\n1-2-3-4,1,2,3,0\n";
    let json = "{\"schema\": \"pintle-forces/1\", \"states\": [{\"state\": 0, \"forces\": {\"1-2-3-4\": \
        {\"m1\": 1, \"m2\": 2, \"m3\": 3}}}]}";
    let read = |text: &str| match text.starts_with('{') {
        true => ForceFile::parse_json("forces.json", text, &scene, ForceSign::Internal),
        false => ForceFile::parse_csv("forces.csv", text, &scene, ForceSign::Internal),
    };
    for text in [csv, json] {
        states[0].mpc_forces.clear();
        read(text).unwrap().attach(&mut states, 0).unwrap();
        assert_eq!(states[0].mpc_forces["1-2-3-4"].total[3..], [Some(1.0), Some(2.0), Some(3.0)]);
        model.check_forces(&states, 0, "forces").unwrap();
        assert!(read(text).unwrap().attach(&mut states, 0).is_err(), "twice");
    }
    // A gap is not given.
    states[0].mpc_forces.clear();
    read("element,m1,m2\n1-2-3-4,1,2\n").unwrap().attach(&mut states, 0).unwrap();
    model.check_forces(&states, 0, "forces").unwrap();
    states[0].mpc_forces.clear();
    read("element,m1,m2,m3,f2\n1-2-3-4,1,2,3,4\n").unwrap().attach(&mut states, 0).unwrap();
    let error = model.check_forces(&states, 0, "forces").unwrap_err();
    let part = "MPC UNIVERSAL 1-2-3-4";
    assert!(error.message().contains("it transmits no f2") && error.message().contains(part), "{error}");
    let error = read("element,m1,m2,m3\n1-2-3-4,1,2,3\n1-2-3-4,1,2,3\n").unwrap_err();
    assert!(error.message().contains("MPC 1-2-3-4 occurs twice"), "{}", error.message());
}

/// The joint of the gallery turns as its deck says.
#[test]
fn the_joint_of_the_gallery_is_driven() {
    let example = GALLERY.iter().find(|example| example.name == "revolute_mpc").unwrap();
    let scene = example.scene().unwrap();
    let states = example.states(&scene).unwrap().states;
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, request(["DRIVEN", "RESV", "RESA", "CEF"], 0).unwrap())
        .unwrap();
    let mut sequence = Sequence::new(&model, &plan);
    for state in &states {
        let result = sequence.step(state).mpcs.remove(0);
        let hinge = result.hinges[0].unwrap();
        assert_eq!(hinge.residual[0], None);
        assert!(
            hinge.residual[1].unwrap().abs() < 1e-13 && hinge.residual[2].unwrap().abs() < 1e-12,
            "{hinge:?}"
        );
        near(result.moments[0].unwrap().unwrap().spring, 2.5 * result.given[0].unwrap());
    }
}

/// What is flagged of all components stands in the table too, with the first row of its block, and in JSON.
#[test]
fn flags_of_all_components_are_in_every_format() {
    let deck = crate::commands::cli::file("hinge-springs.inp", DECK);
    let output = |outputs: &str, format: &str| {
        let arguments = ["eval", &deck, "--outputs", outputs, "--format", format];
        crate::commands::cli::stdout(&crate::commands::cli::pintle(&arguments).assert().code(0))
    };
    let flagged = |outputs: &str| {
        let table = output(outputs, "csv");
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let heading = reader.headers().unwrap().clone();
        let [component, flags] =
            ["component", "flags"].map(|name| heading.iter().position(|h| h == name).unwrap());
        let rows = reader.records().map(Result::unwrap);
        let rows = rows.map(|row| (row[component].to_string(), row[flags].to_string()));
        let all: Vec<(String, String)> = rows.collect();
        assert!(!all.is_empty());
        let mut told: Vec<String> = Vec::new();
        for (component, _) in all.into_iter().filter(|(_, flags)| flags.contains("not-known")) {
            if !told.contains(&component) {
                told.push(component);
            }
        }
        told
    };
    // Of the rows of an equation the first, and the lines of nodes, which have no component.
    assert_eq!(flagged("RES,KT"), ["ρ1", ""]);
    assert_eq!(flagged("RES"), [""; 0]);
    for format in ["human", "json"] {
        assert!(output("RES,KT", format).contains("KG"), "{format}");
        assert!(!output("RES", format).contains("KG"), "{format}");
    }
}
