//! Friction along a history of states: what `eval` makes of motions and given constraint forces.

use crate::tolerance::FRICTION_HISTORY;
use pintle_kinematics::connector::Flag;
use pintle_model::behavior::friction::Status;
use pintle_model::behavior::{Slip, Unknown};
use pintle_model::evaluate::{Branches, ConnectorResult, Model, Plan, Selection, Sequence, request};
use pintle_scene::{ElementForces, GALLERY, Label, NodeMotion, Scene, State};
use std::collections::BTreeMap;

/// The guide of the gallery's slider-crank.
const SLIDE: Label = Label::of(None, 106);

/// Where the slider is, and the constraint forces f2, f3, m1, m2, m3.
type Row = (f64, [f64; 5]);

const PATH: [Row; 12] = [
    (1e-5, [3.0, 4.0, 0.5, 0.3, 0.4]),
    (2e-5, [3.0, -4.0, -0.5, 0.3, 0.4]),
    (1e-3, [3.0, 4.0, 0.5, 0.3, 0.4]),
    (0.999e-3, [3.0, 4.0, 0.5, 0.3, 0.4]),
    (0.97e-3, [3.0, 4.0, 0.25, -0.3, 0.4]),
    (0.97e-3, [0.3, 0.4, 0.0, 0.0, 0.0]),
    (-0.2, [6.0, 8.0, -1.0, 0.6, 0.8]),
    (-0.2 + 2e-5, [6.0, 8.0, -1.0, 0.6, 0.8]),
    (-0.2 + 4e-5, [6.0, 8.0, -1.0, 0.6, 0.8]),
    (0.05, [0.0, 0.0, 0.0, 0.0, 0.0]),
    (0.05, [0.0, 0.0, 0.0, 0.0, 5.0]),
    (0.0, [-1.0, 2.0, 0.1, 0.0, 0.2]),
];

fn scene_of(text: &str) -> Model {
    let scene = Scene::parse("deck.inp", text).unwrap_or_else(|error| panic!("{}", error.render(100, false)));
    Model::compile(&scene).unwrap_or_else(|error| panic!("{}", error.render(100, false)))
}

fn slider_crank() -> Model {
    let example = GALLERY.iter().find(|example| example.name == "slider_crank").unwrap();
    Model::compile(&example.scene().unwrap()).unwrap()
}

fn state(node: u64, displacement: [f64; 3], time: f64) -> State {
    let motion = NodeMotion { displacement, ..NodeMotion::default() };
    State { time: Some(time), nodes: BTreeMap::from([(Label::of(None, node), motion)]), ..State::default() }
}

fn path() -> Vec<State> {
    let one = |(i, (u, [f2, f3, m1, m2, m3])): (usize, &Row)| {
        let mut state = state(6, [*u, 0.0, 0.0], 0.25 * (i + 1) as f64);
        let total = [0.0, *f2, *f3, *m1, *m2, *m3].map(Some);
        state.forces.insert(SLIDE, ElementForces { total, ..ElementForces::default() });
        state
    };
    PATH.iter().enumerate().map(one).collect()
}

fn walk(model: &Model, element: Label, names: &[&str], states: &[State]) -> Vec<ConnectorResult> {
    let plan = Plan::compile(model, &Selection::All, request(names.iter().copied(), 0).unwrap()).unwrap();
    let mut sequence = Sequence::new(model, &plan);
    let of = |result: &ConnectorResult| model.connectors[result.index].label == element;
    states.iter().map(|state| sequence.step(state).connectors.into_iter().find(of).unwrap()).collect()
}

fn is_near(got: f64, expected: f64, scale: f64) -> bool {
    (got - expected).abs() <= FRICTION_HISTORY * scale
}

/// P = |f1|, F_C = |m1|/R_r + √(f2² + f3²) + 2 √(m2² + m3²)/L. The data are R_r = 0.05, L = 0.1, F_C^int = 10, μ = 0.1.
///
/// Stick is elastic up to 1e-4 of the mean length of crank (0.2) and rod (0.6), for the guide has none. Worked out apart from the program.
#[test]
fn the_slider_sticks_and_slips() {
    let model = slider_crank();
    let results = walk(&model, SLIDE, &["ALL"], &path());
    let (mut force, mut slipped, mut before) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut stiffness = None;
    let mut seen = [0; 2];
    for (i, (result, (_, [f2, f3, m1, m2, m3]))) in results.iter().zip(PATH).enumerate() {
        let outcome = result.behavior.as_ref().unwrap();
        let u = result.evaluation.displacement[0].unwrap();
        let contact = m1.abs() / 0.05 + f2.hypot(f3) + 2.0 * m2.hypot(m3) / 0.1;
        let limit = 0.1 * (contact + 10.0);
        let stiffness = *stiffness.get_or_insert(limit / (1e-4 * 0.4));
        let trial = force + stiffness * (u - before);
        let excess = (trial.abs() - limit).max(0.0);
        (force, before) = (trial - excess.copysign(trial), u);
        slipped += excess / stiffness;

        let Slip { components: mask, outcome: slip, .. } = &outcome.slips[0];
        let slip = slip.as_ref().unwrap();
        assert_eq!(*mask, [true, false, false, false, false, false]);
        let scale = trial.abs() + limit;
        assert!(is_near(slip.contact, contact, contact), "{i}: F_C {} {contact}", slip.contact);
        assert!(is_near(slip.normal, contact + 10.0, contact + 10.0), "{i}: F_N {}", slip.normal);
        assert!(is_near(slip.limit, limit, limit), "{i}: limit {} {limit}", slip.limit);
        assert!(is_near(slip.force[0], force, scale), "{i}: f1 {} {force}", slip.force[0]);
        assert!(is_near(slip.tangential, force.abs(), scale), "{i}: P {}", slip.tangential);
        assert!(is_near(slip.accumulated_slip, slipped, slipped + scale / stiffness), "{i}: CASU");
        assert!(is_near(slip.slip_rate, 4.0 * excess / stiffness, 4.0 * scale / stiffness), "{i}: CIVC");
        let status = if excess > 0.0 { Status::Slip } else { Status::Stick };
        assert_eq!(slip.status, status, "{i}: trial {trial}, limit {limit}");
        seen[usize::from(excess > 0.0)] += 1;
        if status == Status::Stick {
            assert_eq!(slip.slip_increment.to_bits(), 0.0_f64.to_bits(), "{i}");
            assert_eq!(slip.slip[0], 0.0, "{i}");
            let last = i.checked_sub(1).map_or(0.0, |j| {
                let slip = &results[j].behavior.as_ref().unwrap().slips[0].outcome;
                slip.as_ref().unwrap().accumulated_slip
            });
            assert_eq!(slip.accumulated_slip.to_bits(), last.to_bits(), "{i}");
        }
        // CTF = CEF + CVF + CSF + CRF − CCF, of which only CSF is there.
        assert_eq!(outcome.friction.value[0], Some(slip.force[0]));
        assert_eq!(outcome.total.value[0], Some(slip.force[0]));
        assert_eq!(outcome.reaction.value[0], Some(0.0));
    }
    assert!(seen[0] >= 4 && seen[1] >= 4, "{seen:?} states stick and slip");
}

/// Cut anywhere, saved, read back and continued: the same bits.
#[test]
fn a_restored_history_slides_on() {
    let model = slider_crank();
    let plan = Plan::compile(&model, &Selection::All, request(["ALL"], 0).unwrap()).unwrap();
    let states = path();
    let text = |sequence: &mut Sequence<'_>, states: &[State]| -> Vec<String> {
        let one = |state| {
            let results = sequence.step(state).connectors;
            let words =
                |one: &ConnectorResult| format!("{:?} {:?} {:?}", one.behavior, one.flags, one.evaluation);
            results.iter().map(words).collect()
        };
        states.iter().map(one).collect()
    };
    let expected = text(&mut Sequence::new(&model, &plan), &states);
    for cut in 1..states.len() {
        let mut begun = Sequence::new(&model, &plan);
        let mut got = text(&mut begun, &states[..cut]);
        let saved = serde_json::to_string(&begun.branches()).unwrap();
        let branches: Branches = serde_json::from_str(&saved).unwrap();
        assert_eq!(branches.check(&model, &plan), Ok(()));
        got.extend(text(&mut Sequence::resume(&model, &plan, branches), &states[cut..]));
        assert_eq!(got, expected, "cut at {cut}");
    }
}

fn not_known(result: &ConnectorResult, quantity: &str) -> Vec<(&'static str, &'static str)> {
    let mut found = Vec::new();
    for flag in &result.flags {
        if let Flag::NotKnown { component, quantity: of, why } = flag
            && *of == quantity
        {
            found.push((*component, *why));
        }
    }
    found
}

/// Without the forces that press, friction and what it leaves are not known, and nothing stands in for them.
#[test]
fn what_presses_is_not_guessed() {
    let mut states = path();
    states[1].forces.clear();
    let results = walk(&slider_crank(), SLIDE, &["CSF", "CNF", "CASU", "CIVC", "CTF"], &states[..3]);
    assert!(not_known(&results[0], "CSF").is_empty());
    for (result, why) in [(&results[1], Unknown::ContactForce), (&results[2], Unknown::FrictionHistory)] {
        for quantity in ["CSF", "CNF", "CASU", "CIVC"] {
            assert_eq!(not_known(result, quantity), [("u1", why.in_words())], "{quantity}");
        }
        let outcome = result.behavior.as_ref().unwrap();
        assert_eq!((outcome.friction.value[0], outcome.friction.unknown[0]), (None, Some(why)));
        assert_eq!(outcome.slips[0].outcome.as_ref().err(), Some(&why));
        assert!(outcome.reaction.value[0].is_none());
    }
    assert!(not_known(&results[1], "CTF").contains(&("u1", Unknown::Part.in_words())));
}

/// A user's friction in u1 of CARTESIAN + CARDAN, nodes 1 and 2 apart by 1 in x.
fn user(friction: &str, more: &str) -> Model {
    scene_of(&format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nCARTESIAN, CARDAN\nO,\n\
         *CONNECTOR BEHAVIOR, NAME=B\n{friction}\n{more}"
    ))
}

/// F_C^int alone presses: motions tell everything.
#[test]
fn internal_contact_forces_need_no_forces() {
    let model = user("*CONNECTOR FRICTION, COMPONENT=1, STICK STIFFNESS=1.E4\n, 20.\n*FRICTION\n0.25", "");
    let results = walk(
        &model,
        Label::of(None, 7),
        &["ALL"],
        &[0.5_f64.powi(14), 0.5, 0.5].map(|u| state(2, [u, 0.0, 0.0], u)),
    );
    let friction = |i: usize| results[i].behavior.as_ref().unwrap().friction.value[0].unwrap();
    assert!(is_near(friction(0), 0.6103515625, 1.0));
    assert!(is_near(friction(1), 5.0, 5.0) && is_near(friction(2), 5.0, 5.0));
    // No time has passed between the last two.
    assert_eq!(not_known(&results[2], "CIVC"), [("u1", Unknown::TimeStep.in_words())]);
    assert!(not_known(&results[1], "CIVC").is_empty());
}

/// What presses is a spring: its force is told by the motion, until a motion is prescribed that holds it with a force of its own.
#[test]
fn a_held_component_presses_with_what_holds_it() {
    let friction = "*CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=2, STICK STIFFNESS=1.E4\n, 0.\n*FRICTION\n0.5\n\
                    *CONNECTOR ELASTICITY, COMPONENT=2\n100.";
    let states = [state(2, [1.0, 0.2, 0.0], 1.0)];
    let free = walk(&user(friction, ""), Label::of(None, 7), &["ALL"], &states);
    assert!(is_near(free[0].behavior.as_ref().unwrap().friction.value[0].unwrap(), 10.0, 10.0));

    let held = user(friction, "*STEP\n*STATIC\n1., 1.\n*CONNECTOR MOTION\nC, 2, 0.2\n*END STEP");
    let unknown = walk(&held, Label::of(None, 7), &["ALL"], &states);
    assert_eq!(not_known(&unknown[0], "CSF"), [("u1", Unknown::ContactForce.in_words())]);

    let mut states = states;
    let total = [10.0, 30.0, 0.0, 0.0, 0.0, 0.0].map(Some);
    states[0].forces.insert(Label::of(None, 7), ElementForces { total, ..ElementForces::default() });
    let told = walk(&held, Label::of(None, 7), &["ALL"], &states);
    // CTF2 = 30 presses, of which the spring gives 20.
    assert!(is_near(told[0].behavior.as_ref().unwrap().friction.value[0].unwrap(), 15.0, 15.0));
    // A load on it presses too: CTF = CEF + CRF − CCF.
    let loaded = user(
        friction,
        "*STEP\n*STATIC\n1., 1.\n*CONNECTOR MOTION\nC, 2, 0.2\n*CONNECTOR LOAD\nC, 2, 4.\n*END STEP",
    );
    let told = walk(&loaded, Label::of(None, 7), &["ALL"], &states);
    let outcome = told[0].behavior.as_ref().unwrap();
    let load = outcome.load.value[1].unwrap();
    assert!(load == 4.0, "{load}");
    assert!(is_near(outcome.friction.value[0].unwrap(), 17.0, 17.0), "{:?}", outcome.friction);
}

/// The total force of a component that is held and slides itself holds its own friction: what presses of it is not known.
#[test]
fn a_held_component_that_slides_does_not_tell_what_presses() {
    let frictions = "*CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=3, STICK STIFFNESS=1.E4\n, 5.\n*FRICTION\n0.5\n\
                     *CONNECTOR FRICTION, COMPONENT=2, CONTACT FORCE=1, STICK STIFFNESS=1.E4\n, 0.\n*FRICTION\n0.5";
    let held = user(frictions, "*STEP\n*STATIC\n1., 1.\n*CONNECTOR MOTION\nC, 1, 0.5\n*END STEP");
    let mut states = [state(2, [0.5, 0.2, 0.0], 1.0)];
    let total = [10.0, 30.0, 0.0, 0.0, 0.0, 0.0].map(Some);
    states[0].forces.insert(Label::of(None, 7), ElementForces { total, ..ElementForces::default() });
    let results = walk(&held, Label::of(None, 7), &["ALL"], &states);
    let slips = &results[0].behavior.as_ref().unwrap().slips;
    assert!(slips[0].outcome.is_ok());
    assert_eq!(slips[1].outcome.as_ref().err(), Some(&Unknown::ContactForce));
}

/// A coefficient over temperature is not known without one, and nothing stands in for it.
#[test]
fn a_coefficient_needs_its_temperature() {
    let friction = "*CONNECTOR FRICTION, COMPONENT=1, STICK STIFFNESS=1.E4\n, 20.\n*FRICTION\n0.25, , , 10.\n0.5, , , 30.";
    let model = user(friction, "");
    let results = walk(&model, Label::of(None, 7), &["ALL"], &[state(2, [0.5, 0.0, 0.0], 1.0)]);
    let outcome = results[0].behavior.as_ref().unwrap();
    assert_eq!(outcome.slips[0].outcome.as_ref().err(), Some(&Unknown::Temperature));
    assert_eq!((outcome.friction.value[0], outcome.friction.unknown[0]), (None, Some(Unknown::Temperature)));
}

/// A friction that several components share has one slip: CSFC, CNFC, CASUC, CIVC.
#[test]
fn a_coupled_friction_has_one_slip() {
    let model = scene_of(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nSLIDE-PLANE\nO,\n\
         *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=1.E4\n4.\n*FRICTION\n0.5\n",
    );
    let mut states = [state(2, [0.0, 0.3, 0.4], 1.0)];
    let unknown = walk(&model, Label::of(None, 7), &["ALL"], &states);
    assert_eq!(not_known(&unknown[0], "CNF"), [("C", Unknown::ContactForce.in_words())]);
    let total = [Some(6.0), Some(3.0), Some(4.0), None, None, None];
    states[0].forces.insert(Label::of(None, 7), ElementForces { total, ..ElementForces::default() });
    let results = walk(&model, Label::of(None, 7), &["ALL"], &states);
    let outcome = results[0].behavior.as_ref().unwrap();
    let Slip { components: mask, outcome: slip, .. } = &outcome.slips[0];
    let slip = slip.as_ref().unwrap();
    assert_eq!(*mask, [false, true, true, false, false, false]);
    assert_eq!(slip.normal, 10.0);
    assert!(is_near(slip.tangential, 5.0, 5.0));
    assert!(is_near(slip.force[1], 3.0, 5.0) && is_near(slip.force[2], 4.0, 5.0));
    assert!(is_near(slip.slip_increment, 0.5 - 5e-4, 1.0));
}

/// Where friction is not asked for it is not followed, and the total force given is not compared with a sum that lacks it.
#[test]
fn friction_that_is_not_followed_is_not_missed() {
    let model = slider_crank();
    let given = |state: &mut State| {
        let total = [Some(5.0), Some(3.0), Some(4.0), Some(0.5), Some(0.3), Some(0.4)];
        state.forces.insert(SLIDE, ElementForces { total, ..ElementForces::default() });
    };
    let mut states = path();
    states.iter_mut().for_each(given);
    for result in walk(&model, SLIDE, &["CEF", "CCF"], &states) {
        assert!(
            !result.flags.iter().any(|flag| matches!(flag, Flag::OutOfBalance { .. })),
            "{:?}",
            result.flags
        );
        assert!(result.behavior.as_ref().unwrap().slips.is_empty());
    }
    let followed = walk(&model, SLIDE, &["CSF"], &states);
    assert!(
        followed
            .iter()
            .any(|result| result.flags.iter().any(|flag| matches!(flag, Flag::OutOfBalance { .. })))
    );
}

/// Forces that are not those of the connector are not taken, and that is told: by a state of a library's caller, for files are refused.
#[test]
fn forces_that_are_refused_are_told() {
    let model = slider_crank();
    let mut states = path();
    states.truncate(1);
    let given = states[0].forces.get_mut(&SLIDE).unwrap();
    given.reaction[3] = given.total[3].map(|moment| moment + 1.0);
    let result = walk(&model, SLIDE, &["CTF", "CSF"], &states).remove(0);
    let told = |flag: &Flag| matches!(flag, Flag::ForcesRefused { .. });
    assert!(result.flags.iter().any(told), "{:?}", result.flags);
    assert_eq!(result.behavior.unwrap().total.value[1], None);
    let result = walk(&model, SLIDE, &["CTF", "CSF"], &path()[..1]).remove(0);
    assert!(!result.flags.iter().any(told), "{:?}", result.flags);
}
