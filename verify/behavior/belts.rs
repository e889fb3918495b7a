//! Friction of belts over rings, along histories of states: the deck of the gallery with its friction, from which the forces at every
//! free degree of freedom vanish.

use crate::tolerance::{BELT_ANGLE, BELT_BALANCE, BELT_FRICTION, BELT_SLOPE};
use pintle_kinematics::connector::Flag;
use pintle_model::behavior::friction::{Status, wrap_angle};
use pintle_model::behavior::{Unknown, Wrap};
use pintle_model::evaluate::{Branches, ConnectorResult, Model, Plan, Selection, Sequence, request};
use pintle_scene::{ElementForces, GALLERY, Label, NodeMotion, Rotation, Scene, State};
use std::collections::BTreeMap;

const FIRST: Label = Label::of(None, 103);
const SECOND: Label = Label::of(None, 104);

/// The belt of the gallery with the friction that its deck has in comments.
pub(crate) fn deck(stick: &str, angle: &str) -> Scene {
    let example = GALLERY.iter().find(|example| example.name == "seat_belt").unwrap();
    let with = |text: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    };
    let text = with(
        example.deck,
        "** *CONNECTOR FRICTION, PREDEFINED",
        &format!("*CONNECTOR FRICTION, PREDEFINED{stick}"),
    );
    let text = with(&text, "** *FRICTION\n** 0.2", "*FRICTION\n0.2");
    Scene::parse("belt.inp", &with(&text, "0.06, 1.5707963", angle)).unwrap()
}

pub(crate) const STIFFNESS: f64 = 1e9;
/// As the deck gives it, to eight digits.
#[expect(clippy::approx_constant, reason = "the number of the deck")]
pub(crate) const ALPHA: f64 = 1.5707963;

/// Ψ10 and Ψ20 of the belt at a pull p, sliding over the ring: 12500 Ψ10 = T1 = 1e5 (1/l1 − 1), T2 = 1e5 ((1 + p)/l2 − 1) = T1 e^(μα),
/// l1 = 1 + Ψ10 − Ψ20, l2 = 1 + Ψ20; by bisection on Ψ10.
pub(crate) fn sliding(pull: f64) -> [f64; 2] {
    let ratio = (0.2 * ALPHA).exp();
    let flows = |psi10: f64| {
        let tension = 12_500.0 * psi10;
        [psi10, 1.0 + psi10 - 1.0 / (1.0 + tension / 1e5)]
    };
    let (mut low, mut high) = (0.0, 0.2);
    for _ in 0..200 {
        let [psi10, psi20] = flows(0.5 * (low + high));
        let second = 1e5 * ((1.0 + pull) / (1.0 + psi20) - 1.0);
        if second > 12_500.0 * psi10 * ratio { low = psi10 } else { high = psi10 }
    }
    flows(0.5 * (low + high))
}

pub(crate) fn state(time: f64, pull: f64, [psi10, psi20]: [f64; 2]) -> State {
    let flow = |flow: f64| NodeMotion { flow, ..NodeMotion::default() };
    let drum = NodeMotion { rotation: Rotation::Vector([0.0, 0.0, 50.0 * psi10]), ..NodeMotion::default() };
    let end = NodeMotion { displacement: [pull, 0.0, 0.0], ..NodeMotion::default() };
    let nodes = [(1, drum), (10, flow(psi10)), (20, flow(psi20)), (30, end)];
    State {
        time: Some(time),
        nodes: nodes.map(|(node, motion)| (node.into(), motion)).into(),
        ..State::default()
    }
}

fn walk(model: &Model, names: &[&str], states: &[State]) -> Vec<Vec<ConnectorResult>> {
    let plan = Plan::compile(model, &Selection::All, request(names.iter().copied(), 0).unwrap()).unwrap();
    let mut sequence = Sequence::new(model, &plan);
    states.iter().map(|state| sequence.step(state).connectors).collect()
}

fn of<'a>(model: &Model, results: &'a [ConnectorResult], label: Label) -> &'a ConnectorResult {
    results.iter().find(|result| model.connectors[result.index].label == label).unwrap()
}

/// T1 = 954.5, T2 = 1306.8 = 1.3691 T1, CSF2 = T2 − T1 at the ring; every free degree of freedom is in balance, the reaction of the drum
/// on the belt being what the belt leaves for it.
#[test]
fn the_belt_slips_over_its_ring() {
    let scene = deck(&format!(", STICK STIFFNESS={STIFFNESS}"), "0.06, 1.5707963");
    let model = Model::compile(&scene).unwrap();
    let mut states: Vec<State> = (0..=20)
        .map(|i| f64::from(i) / 20.0)
        .map(|time| state(time, 0.1 * time, sliding(0.1 * time)))
        .collect();
    let last = states.last_mut().unwrap();
    let tension = 12_500.0 * last.nodes[&10.into()].flow;
    // m3 = −T1/β_s. What the exit and the frame carry is not looked at.
    let retractor = [Some(0.0), Some(0.0), Some(0.0), None, None, Some(-tension / 50.0)];
    let spool = [Some(0.0), Some(0.0), Some(0.0), Some(tension / 50.0), Some(0.0), Some(0.0)];
    for (element, total) in [(102, retractor), (101, spool)] {
        last.forces.insert(element.into(), ElementForces { total, ..ElementForces::default() });
    }
    let all = walk(&model, &["CTF", "CSF", "CNF", "CASU", "SLIP", "NF", "CU", "TANGENT"], &states);
    let end = all.last().unwrap();
    let [first, second] = [FIRST, SECOND].map(|label| of(&model, end, label));
    let total =
        |result: &ConnectorResult, k: usize| result.behavior.as_ref().unwrap().total.value[k].unwrap();
    let [t1, t2, friction] = [total(first, 0), total(second, 0), total(first, 1)];
    assert!((t1 - 954.5).abs() < 0.05 && (t2 - 1306.8).abs() < 0.05, "{t1} {t2}");
    assert!((friction - (t2 - t1)).abs() < BELT_FRICTION * t2, "{friction} {}", t2 - t1);
    let slip = first.behavior.as_ref().unwrap().slips[0].outcome.as_ref().unwrap();
    assert_eq!(slip.status, Status::Slip);
    // All of the flow but the elastic slip.
    let psi20 = states[20].nodes[&20.into()].flow;
    assert!((slip.accumulated_slip - (psi20 - friction / STIFFNESS)).abs() < 1e-12, "{slip:?}");
    // Nothing goes on beyond the anchor.
    assert_eq!(second.behavior.as_ref().unwrap().friction.value[1], Some(0.0));

    let mut residual: BTreeMap<(String, &str), f64> = BTreeMap::new();
    for result in end {
        let element = &model.connectors[result.index];
        let nodal = result.forces.as_ref().unwrap().nodal.unwrap_or_else(|| panic!("{:?}", result.flags));
        for (j, force) in nodal.into_iter().enumerate() {
            if let Some(label) = element.nodes[j / 7] {
                let name = ["u1", "u2", "u3", "ur1", "ur2", "ur3", "flow"][j % 7];
                *residual.entry((label.to_string(), name)).or_default() += force;
            }
        }
    }
    for free in [("1", "ur3"), ("10", "flow"), ("20", "flow")] {
        let rest = residual[&(free.0.to_string(), free.1)];
        assert!(rest.abs() < BELT_BALANCE * t2, "{free:?}: {rest}");
    }
    // ∂CSF2/∂T2 = 0 in slip: the smaller tension holds. ∂CSF2/∂T1 = e^(μα) − 1, through ∂T1/∂u1 = 1e5.
    let tangent = first.tangent.as_ref().unwrap();
    let growth = (0.2 * ALPHA).exp_m1();
    assert_eq!((tangent.beyond[1], tangent.displacement[1][1]), (0.0, 0.0));
    assert!((tangent.displacement[1][0] - 1e5 * growth).abs() < BELT_SLOPE * 1e5, "{tangent:?}");
}

/// Drawn back, the belt sticks, then slips the other way, where the second segment holds; what friction does never gives energy.
#[test]
fn the_belt_is_drawn_back() {
    let scene = deck(&format!(", STICK STIFFNESS={STIFFNESS}"), "0.06, 1.5707963");
    let model = Model::compile(&scene).unwrap();
    let flows =
        [[0.0, 0.0], [0.01, 0.011], [0.012, 0.0115], [0.012, 0.011_500_1], [0.011, 0.006], [0.0, 0.0]];
    let pulls = [0.0, 0.03, 0.03, 0.03, 0.03, 0.02];
    let states: Vec<State> = (0..6).map(|i| state(i as f64, pulls[i], flows[i])).collect();
    let mut seen = Vec::new();
    for results in walk(&model, &["CSF", "TANGENT"], &states) {
        let (first, second) = (of(&model, &results, FIRST), of(&model, &results, SECOND));
        let slip = first.behavior.as_ref().unwrap().slips[0].outcome.clone().unwrap();
        let tension = [first, second].map(|result| result.behavior.as_ref().unwrap().total.value[0].unwrap());
        seen.push((slip.status, slip.force[1] > 0.0));
        let growth = (0.2 * ALPHA).exp_m1();
        if slip.status == Status::Slip {
            let holding = if slip.force[1] > 0.0 { tension[0] } else { tension[1] };
            assert!((slip.force[1].abs() - holding * growth).abs() < 1e-9 * holding, "{slip:?}");
            let beyond = first.tangent.as_ref().unwrap().beyond[1];
            let want = if slip.force[1] > 0.0 { 0.0 } else { -growth };
            assert!((beyond - want).abs() < 1e-14, "{beyond}");
        }
        assert!(slip.dissipation >= 0.0);
    }
    assert!(seen.contains(&(Status::Slip, true)) && seen.contains(&(Status::Slip, false)), "{seen:?}");
}

/// Without a contact angle the angle is zero in Standard, and that of the segments in Explicit (decision D-26).
#[test]
fn the_angle_of_wrap_is_that_of_the_solver() {
    let standard = deck("", "0.06");
    let mut explicit = standard.clone();
    explicit.solver = Some(pintle_scene::Solver::Explicit);
    // Solvers refuse what the other has; the rings are what matters here.
    let angle = |scene: &Scene| Model::compile(scene).unwrap().rings.values().next().unwrap().angle;
    assert_eq!(angle(&standard), Some(0.0));
    assert_eq!(angle(&explicit), None);
    assert_eq!(angle(&deck("", "0.06, 1.25")), Some(1.25));
    let model = Model::compile(&explicit).unwrap();
    let states = [state(0.0, 0.0, [0.0; 2]), state(1.0, 0.1, sliding(0.1))];
    let results = walk(&model, &["CSF", "TANGENT", "KT", "KR"], &states);
    let first = of(&model, &results[1], FIRST);
    let slip = &first.behavior.as_ref().unwrap().slips[0];
    assert!((slip.beyond.unwrap().angle - std::f64::consts::FRAC_PI_2).abs() < 1e-15, "{slip:?}");
    // It changes as the segments move: by ∂CSF2/∂α times ∂α/∂x, which KT leaves to KR. CSF2 = T1 (e^(μα) − 1).
    let tangent = first.tangent.as_ref().unwrap();
    assert_eq!(tangent.unknown[1], None);
    let held = slip.outcome.as_ref().unwrap().normal;
    let want = 0.2 * held * (0.2 * std::f64::consts::FRAC_PI_2).exp();
    assert!((tangent.angle[1] - want).abs() < BELT_SLOPE * held, "{} {want}", tangent.angle[1]);
    let forces = first.forces.as_ref().unwrap();
    assert!(forces.tangent.is_some());
    let column = forces.by_angle.unwrap();
    assert_eq!((column[13], column[6]), (tangent.angle[1], 0.0));
    // By differences of the angle itself, at the places of nodes 10, 20 and 30.
    let at = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.1, 1.0, 0.0]];
    let angle = |node: usize, axis: usize, h: f64| {
        let mut at = at;
        at[node][axis] += h;
        wrap_angle(at[0], at[1], at[2]).0
    };
    let wrap = tangent.wrap.unwrap();
    for node in 0..3 {
        for axis in 0..3 {
            let slope = (angle(node, axis, 1e-5) - angle(node, axis, -1e-5)) / 2e-5;
            assert!((wrap[node][axis] - slope).abs() < BELT_ANGLE, "{node} {axis}: {wrap:?} {slope}");
        }
    }
    // Segments in line: the angle has no derivative, and the slope is not known; nor is the force zero beside it.
    let mut text = deck("", "0.06");
    text.solver = Some(pintle_scene::Solver::Explicit);
    text.nodes.get_mut(&Label::of(None, 30)).unwrap().coordinates = [0.0, 2.0, 0.0];
    let model = Model::compile(&text).unwrap();
    let results = walk(&model, &["CSF", "TANGENT", "KT"], &[state(0.0, 0.0, [0.0, 0.01])]);
    let first = of(&model, &results[0], FIRST);
    assert_eq!(first.behavior.as_ref().unwrap().slips[0].beyond.unwrap().wrap, Wrap::Kink);
    assert_eq!(first.tangent.as_ref().unwrap().unknown[1], Some(Unknown::WrapAngle));
    assert!(first.forces.as_ref().unwrap().tangent.is_none());
    // Slack, nothing would hold to any side.
    let results = walk(&model, &["CSF", "TANGENT"], &[state(0.0, 0.0, [0.0; 2])]);
    let first = of(&model, &results[0], FIRST);
    assert_eq!(first.behavior.as_ref().unwrap().slips[0].beyond.unwrap().wrap, Wrap::Kink);
    assert_eq!(first.tangent.as_ref().unwrap().unknown[1], None);
    let model = Model::compile(&deck("", "0.06, 1.25")).unwrap();
    let results = walk(&model, &["CSF", "TANGENT", "KT"], &states);
    let first = of(&model, &results[1], FIRST);
    assert_eq!(first.tangent.as_ref().unwrap().unknown[1], None);
    assert!(first.forces.as_ref().unwrap().tangent.is_some());
}

/// One segment alone finds the tension of the other; histories continue; what is not known is said.
#[test]
fn segments_know_one_another() {
    let scene = deck(&format!(", STICK STIFFNESS={STIFFNESS}"), "0.06, 1.5707963");
    let model = Model::compile(&scene).unwrap();
    let states: Vec<State> =
        [0.0, 0.05, 0.1].map(|pull| state(10.0 * pull, pull, sliding(pull))).into_iter().collect();
    let whole = walk(&model, &["CSF", "CASU"], &states);
    let alone = Selection::Named(vec!["103".into()]);
    let plan = Plan::compile(&model, &alone, request(["CSF", "CASU"], 0).unwrap()).unwrap();
    let mut sequence = Sequence::new(&model, &plan);
    for (state, all) in states.iter().zip(&whole) {
        let found = sequence.step(state).connectors.remove(0);
        let want = of(&model, all, FIRST);
        assert_eq!(
            found.behavior.unwrap().friction.value[1].map(f64::to_bits),
            want.behavior.as_ref().unwrap().friction.value[1].map(f64::to_bits)
        );
    }
    // Saved and read back.
    let plan = Plan::compile(&model, &Selection::All, request(["CSF", "CASU"], 0).unwrap()).unwrap();
    let mut sequence = Sequence::new(&model, &plan);
    states[..2].iter().for_each(|state| drop(sequence.step(state)));
    let text = serde_json::to_string(&sequence.branches()).unwrap();
    let branches: Branches = serde_json::from_str(&text).unwrap();
    assert_eq!(branches.check(&model, &plan), Ok(()));
    let resumed = Sequence::resume(&model, &plan, branches).step(&states[2]).connectors;
    let slip = |results: &[ConnectorResult]| {
        let slips = &of(&model, results, FIRST).behavior.as_ref().unwrap().slips;
        slips[0].outcome.clone().unwrap()
    };
    assert_eq!(slip(&resumed).accumulated_slip.to_bits(), slip(&whole[2]).accumulated_slip.to_bits());
    // Where nothing asked for it, no history was followed, and none can be continued.
    let others = Plan::compile(&model, &Selection::All, request(["CP"], 0).unwrap()).unwrap();
    let mut sequence = Sequence::new(&model, &others);
    states[..2].iter().for_each(|state| assert!(sequence.step(state).connectors[2].behavior.is_none()));
    let refused = sequence.branches().check(&model, &plan).unwrap_err();
    assert!(refused.contains("history of connector 103"), "{refused}");
}

/// A tension that is not known holds nothing back, on neither side; a friction that is not followed is a part that is missing.
#[test]
fn unknown_tensions_are_not_guessed() {
    let model = |laws: [&str; 2]| {
        let text = format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n\
             *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*ELEMENT, TYPE=CONN3D2, ELSET=D\n8, 2, 3\n\
             *CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nSLIPRING\n\n0.06, 1.5\n\
             *CONNECTOR SECTION, ELSET=D, BEHAVIOR=E\nSLIPRING\n\n0.06\n\
             *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=1{}\n\
             *CONNECTOR FRICTION, PREDEFINED\n*FRICTION\n0.2\n\
             *CONNECTOR BEHAVIOR, NAME=E\n*CONNECTOR ELASTICITY, COMPONENT=1{}\n",
            laws[0], laws[1]
        );
        Model::compile(
            &Scene::parse("belts.inp", &text).unwrap_or_else(|e| panic!("{}", e.render(100, false))),
        )
        .unwrap()
    };
    let pulled = NodeMotion { displacement: [0.0, 0.5, 0.0], ..NodeMotion::default() };
    let aside = NodeMotion { displacement: [-0.5, 0.0, 0.0], ..NodeMotion::default() };
    let nodes = [(3.into(), pulled), (1.into(), aside)];
    let state = State { time: Some(1.0), nodes: nodes.into(), ..State::default() };
    let (known, unknown) = ("\n10.", ", DEPENDENCIES=1\n10., , 1.\n20., , 2.");
    let label = Label::of(None, 7);
    for (laws, why) in [
        ([known, known], None),
        ([unknown, known], Some(Unknown::ContactForce)),
        ([known, unknown], Some(Unknown::Part)),
    ] {
        let model = model(laws);
        let results = walk(&model, &["CSF"], std::slice::from_ref(&state)).remove(0);
        let outcome = of(&model, &results, label).behavior.as_ref().unwrap().clone();
        assert_eq!(outcome.slips[0].outcome.as_ref().err().copied(), why, "{laws:?}");
        let results = walk(&model, &["CEF"], std::slice::from_ref(&state)).remove(0);
        let outcome = of(&model, &results, label).behavior.as_ref().unwrap().clone();
        assert!(outcome.slips.is_empty());
        assert_eq!(outcome.friction.unknown[1], Some(Unknown::Part));
    }
}

/// Two belts that both end at the ring, and a friction over it: told, not guessed.
#[test]
fn opposed_belts_have_no_friction() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n8, 3, 2\n\
        *CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nSLIPRING\n\n0.06, 1.5\n*CONNECTOR BEHAVIOR, NAME=B\n\
        *CONNECTOR FRICTION, PREDEFINED\n*FRICTION\n0.2\n";
    let model = Model::compile(&Scene::parse("belts.inp", text).unwrap()).unwrap();
    let results = walk(&model, &["CSF"], &[State::default()]).remove(0);
    for result in &results {
        let said = result.flags.iter().any(|flag| {
            matches!(flag, Flag::NotKnown { quantity: "CSF", why, .. } if *why == Unknown::OpposedBelts.in_words())
        });
        assert!(said, "{:?}", result.flags);
    }
}
