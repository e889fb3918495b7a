//! What holds components, and what is said of it: stops, locks, failures, motions, rigid elasticities, reactions; by hand.

use super::{ALL_AVAILABLE, along_1, behavior, deck, model, walk};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Components, Flag, StopStatus};
use pintle_model::behavior::limits::Passed;
use pintle_model::behavior::state::{Behavior, Velocities};
use pintle_model::evaluate::{ConnectorResult, Model};
use pintle_scene::{Code, NodeMotion, Scene, State as SceneState};
use std::collections::BTreeMap;

const STEP: &str = "*STEP\n*STATIC\n0.1, 4.\n*CONNECTOR MOTION";

/// A total force of u1, and of nothing else.
fn pulled(force: f64) -> Components<f64> {
    [Some(force), None, None, None, None, None]
}

fn one(law: &str, steps: &str, states: &[(f64, f64, f64)], forces: &[f64]) -> Vec<ConnectorResult> {
    let forces: Vec<_> = forces.iter().map(|force| pulled(*force)).collect();
    walk(&model(ALL_AVAILABLE, law, steps), &along_1(states), Velocities::Rates, &forces)
}

fn has(result: &ConnectorResult, test: impl Fn(&Flag) -> bool) -> bool {
    result.flags.iter().any(test)
}

#[test]
fn a_behaviour_says_what_it_holds() {
    const NONE: [bool; 6] = [false; 6];
    const FIRST: [bool; 6] = [true, false, false, false, false, false];
    let cases = [
        ("", true, false, false, NONE),
        ("*CONNECTOR ELASTICITY, COMPONENT=1\n5.", false, false, false, NONE),
        ("*CONNECTOR DAMPING, COMPONENT=1\n5.", false, false, false, NONE),
        ("*CONNECTOR STOP, COMPONENT=1\n0.5, 1.5", false, true, false, FIRST),
        ("*CONNECTOR LOCK, COMPONENT=1, LOCK=1\n, 1.5", false, false, false, FIRST),
        ("*CONNECTOR LOCK, COMPONENT=1, LOCK=1\n, , , 5.", false, false, true, FIRST),
        ("*CONNECTOR FAILURE, COMPONENT=1, RELEASE=1\n, , -5.", false, false, true, FIRST),
        (
            "*CONNECTOR FAILURE, COMPONENT=1, RELEASE=3\n, 1.5",
            false,
            false,
            false,
            [true, false, true, false, false, false],
        ),
    ];
    for (text, is_empty, has_stops, by_force, limited) in cases {
        let behavior = behavior(text);
        let found =
            (behavior.is_empty(), behavior.has_stops(), behavior.decides_by_force(), behavior.limited());
        assert_eq!(found, (is_empty, has_stops, by_force, limited), "{text}");
    }
    let rigid = behavior("*CONNECTOR ELASTICITY, RIGID\n2, 4");
    assert_eq!(rigid.elasticity.rigid(), [false, true, false, true, false, false]);
    let damping = behavior(
        "*CONNECTOR DAMPING, COMPONENT=1\n5.\n*CONNECTOR DAMPING, COMPONENT=3, TYPE=STRUCTURAL\n0.02",
    );
    assert_eq!((damping.damping.structural(), behavior("").damping.structural()), (1, 0));
    let words = [Passed::LowerPosition, Passed::UpperPosition, Passed::LowerForce, Passed::UpperForce];
    assert_eq!(
        words.map(Passed::in_words),
        ["lower position", "upper position", "lower force", "upper force"]
    );
}

/// The manual adds elasticities and dampings of one component; of several stops the tighter limits hold.
#[test]
fn laws_of_one_component_add() {
    let table = "*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR\n0., 0.\n1., 1.\n5., 2.";
    let zeros = "0., 0., 0., 0., 0., 0., 0., 0.";
    let coupled =
        format!("*CONNECTOR ELASTICITY\n2., 0., 0., 0., 0., 0., 0., 0.\n{zeros}\n0., 0., 0., 0., 0.\n");
    let laws = format!(
        "*CONNECTOR ELASTICITY, COMPONENT=1\n5.\n{table}\n{coupled}*CONNECTOR DAMPING, COMPONENT=1\n3.\n*CONNECTOR DAMPING, COMPONENT=1, NONLINEAR\n-1., -1.\n1., 1."
    );
    let found = one(&laws, "", &[(0.0, 1.5, 0.25)], &[])[0].behavior.clone().unwrap();
    // 5 · 1.5 + (1 + 0.5 · 4) + 2 · 1.5, and 3 · 0.25 + 0.25.
    assert_eq!((found.elastic.value[0], found.viscous.value[0]), (Some(13.5), Some(1.0)));
    let heated = format!("{laws}\n*CONNECTOR ELASTICITY, COMPONENT=1\n5., , 20.\n6., , 30.");
    let found = one(&heated, "", &[(0.0, 1.5, 0.25)], &[])[0].behavior.clone().unwrap();
    assert!(found.elastic.value[0].is_none() && found.elastic.unknown[0].is_some(), "{:?}", found.elastic);
    let stops = "*CONNECTOR STOP, COMPONENT=1\n-1., 1.5\n*CONNECTOR STOP, COMPONENT=1\n-2., 0.5\n*CONNECTOR STOP, COMPONENT=1\n-0.5";
    let stop = behavior(stops).stops()[0].unwrap();
    assert_eq!((stop.lower, stop.upper), (Some(-0.5), Some(0.5)));
    let apart =
        deck(ALL_AVAILABLE, "*CONNECTOR STOP, COMPONENT=1\n, -1.\n*CONNECTOR STOP, COMPONENT=1\n1.", "");
    let error = Scene::parse("apart.inp", &apart).unwrap_err();
    assert_eq!(error.code(), Code::RepeatedSuboption);
}

/// What is given for a component on which nothing of the model acts is its force; where something does, the sum of that is.
#[test]
fn given_forces_of_free_components_stand() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=2\n5.";
    for (law, force, flagged) in [(law, 7.0, false), ("*CONNECTOR ELASTICITY, COMPONENT=1\n5.", 0.5, true)] {
        let [found] = &one(law, "", &[(0.0, 0.1, 0.0)], &[7.0])[..] else { panic!("one state") };
        let outcome = found.behavior.as_deref().unwrap();
        let total = outcome.total.value[0].unwrap();
        assert!((total - force).abs() < 1e-14 && outcome.reaction.value[0] == Some(0.0), "{law}: {total}");
        assert_eq!(has(found, |flag| flag.name() == "out-of-balance"), flagged, "{law}");
        let nodal = found.forces.as_deref().unwrap().nodal.unwrap();
        assert!((nodal[7] - force).abs() < 1e-14, "{law}: {nodal:?}");
    }
}

/// Motions alone tell friction that no constraint force presses.
#[test]
fn friction_is_told_where_nothing_constrained_presses() {
    let told = |types: &str, options: &str, row: &str| {
        let law =
            format!("*CONNECTOR FRICTION, COMPONENT=1, STICK STIFFNESS=3.{options}\n{row}\n*FRICTION\n0.1\n");
        model(types, &law, "").connectors[0].behavior.behavior.tells_friction()
    };
    assert!(told("SLOT", "", ", 5.") && told(ALL_AVAILABLE, ", CONTACT FORCE=2", ", 5."));
    assert!(!told("SLOT", ", CONTACT FORCE=2", ", 5."));
    assert!(!behavior("*CONNECTOR STOP, COMPONENT=1\n0.5, 1.5").tells_friction());
}

/// A limit is passed beyond it, not at it: of positions and of forces, on both sides.
#[test]
fn limits_are_passed_beyond_them() {
    let spring = "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR LOCK, COMPONENT=1, LOCK=2\n";
    for (limits, at, beyond) in
        [(", 1.5", 0.5, 0.625), ("1.25", 0.25, 0.125), (", , , 5.", 0.5, 0.625), (", , -5.", -0.5, -0.625)]
    {
        let locked = |u: f64| {
            let result = one(&format!("{spring}{limits}"), "", &[(1.0, u, 0.0)], &[]).remove(0);
            result.behavior.as_ref().unwrap().locked[1]
        };
        assert!(!locked(at) && locked(beyond), "{limits}");
    }
}

/// In the plane only displacements in it and the rotation about its normal remain.
#[test]
fn a_type_without_behaviour_has_its_components() {
    let of = |name: &str, second, is_planar| {
        let none = Behavior::none(&ConnectionType::named(name, second).unwrap(), is_planar);
        (none.available(), none.constrained())
    };
    let (all, none, plane) = ([true; 6], [false; 6], [true, true, false, false, false, true]);
    assert_eq!(of("CARTESIAN", Some("CARDAN"), false), (all, none));
    assert_eq!(of("CARTESIAN", Some("CARDAN"), true), (plane, none));
    assert_eq!(of("BEAM", None, false), (none, all));
    assert_eq!(of("BEAM", None, true), (none, plane));
    assert_eq!(
        of("SLOT", None, true),
        ([true, false, false, false, false, false], [false, true, false, false, false, false])
    );
}

/// What keeps a rigid elasticity at its reference is its elastic force; a lock or stop beside it takes the reaction.
#[test]
fn rigid_elasticities_take_what_is_left() {
    let law = "*CONNECTOR ELASTICITY, RIGID\n1";
    let result = &one(law, "", &[(1.0, 0.25, 3.0)], &[7.0])[0];
    let outcome = result.behavior.as_ref().unwrap();
    assert_eq!((outcome.elastic.value[0], outcome.reaction.value[0]), (Some(7.0), Some(0.0)));
    assert_eq!((result.evaluation.residual[0], result.evaluation.residual_rate[0]), (Some(0.25), Some(3.0)));
    let locked = "*CONNECTOR ELASTICITY, RIGID\n1\n*CONNECTOR LOCK, COMPONENT=1, LOCK=1\n, 1.2";
    let results = one(locked, "", &[(1.0, 0.25, 0.0), (2.0, 0.5, 0.0)], &[7.0, 7.0]);
    let outcome = results[1].behavior.as_ref().unwrap();
    assert_eq!((outcome.elastic.value[0], outcome.reaction.value[0]), (None, Some(7.0)));
}

/// Motions of velocity and acceleration are residuals of the rates, with the time derivatives of their amplitude.
#[test]
fn prescribed_rates_are_residuals_of_rates() {
    for (kind, expected) in
        [("VELOCITY", [None, Some(2.0), Some(3.0)]), ("ACCELERATION", [None, None, Some(4.0)])]
    {
        // WAVE is 2 t until 1.
        let model =
            model(ALL_AVAILABLE, "", &format!("{STEP}, TYPE={kind}, AMPLITUDE=WAVE\n7, 1, 1.\n*END STEP\n"));
        let motion =
            NodeMotion { velocity: [3.0, 0.0, 0.0], acceleration: [5.0, 0.0, 0.0], ..NodeMotion::default() };
        let state = SceneState {
            time: Some(0.5),
            nodes: BTreeMap::from([(2.into(), motion)]),
            ..SceneState::default()
        };
        let result = &walk(&model, &[state], Velocities::Rates, &[])[0].evaluation;
        let found = [result.residual[0], result.residual_rate[0], result.residual_acceleration[0]];
        assert_eq!(found, expected, "{kind}");
    }
}

/// At the lower stop the reaction is negative; one that pulls is told, unless something else holds the component too.
#[test]
fn lower_stops_push_and_do_not_pull() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR STOP, COMPONENT=1\n0.5, 1.5";
    let at = |u: f64, force: f64, steps: &str| one(law, steps, &[(1.0, u, 0.0)], &[force]).remove(0);
    let pulls = |result: &ConnectorResult| has(result, |flag| matches!(flag, Flag::StopPulls { .. }));
    let beyond = at(-0.75, -9.0, "");
    assert_eq!(beyond.stops[0], Some(StopStatus::AtLower));
    assert!(beyond.flags.contains(&Flag::BeyondStop { component: "u1", by: 0.25 }) && !pulls(&beyond));
    assert!(
        !has(&at(-0.5, -9.0, ""), |flag| matches!(flag, Flag::BeyondStop { .. })),
        "at the stop is not beyond"
    );
    assert!(pulls(&at(-0.5, -4.5, "")) && !pulls(&at(-0.5, -5.0, "")) && !pulls(&at(-0.5, -5.5, "")));
    assert!(pulls(&at(0.5, 4.5, "")) && !pulls(&at(0.5, 5.0, "")) && !pulls(&at(0.5, 5.5, "")));
    assert!(!pulls(&at(0.5, 4.5, &format!("{STEP}\n7, 1, 2.\n*END STEP\n"))), "the motion holds it");
    let locked = format!("{law}\n*CONNECTOR LOCK, COMPONENT=1, LOCK=1\n, 1.25");
    let results = one(&locked, "", &[(1.0, 0.5, 0.0), (2.0, 0.5, 0.0)], &[5.5, 4.5]);
    assert!(!pulls(&results[1]), "the lock holds it");
}

/// A difference of rounding is none, whatever the size of the forces; a larger one is told. What is not there is in no balance.
#[test]
fn balances_are_relative() {
    for size in [1e-3, 1.0, 1e3] {
        let law = format!("*CONNECTOR ELASTICITY, COMPONENT=1\n{:?}", 10.0 * size);
        let told = |share: f64| {
            has(&one(&law, "", &[(1.0, 0.5, 0.0)], &[5.0 * size * (1.0 + share)])[0], |flag| {
                matches!(flag, Flag::OutOfBalance { .. })
            })
        };
        // Printed with six digits or more.
        assert!(!told(1e-7) && !told(-1e-7) && told(1e-4) && told(-1e-4), "{size}");
    }
    let results =
        walk(&model("SLOT", "", ""), &along_1(&[(1.0, 0.5, 0.0)]), Velocities::Rates, &[pulled(0.0)]);
    let total = results[0].behavior.as_ref().map(|outcome| outcome.total.value);
    assert!(total.is_none_or(|total| total[3..] == [None; 3]));
}

/// What failed stays away: it is told once, its motion ends, and nothing is balanced there.
#[test]
fn failures_are_told_once() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR ELASTICITY, COMPONENT=2\n5., , 20.\n6., , 30.\n\
               *CONNECTOR FAILURE, COMPONENT=1\n, 1.5\n*CONNECTOR FAILURE, COMPONENT=1, RELEASE=1\n, 1.25";
    let steps = format!("{STEP}\n7, 1, 2.\n*END STEP\n");
    let states = [(1.0, 0.5, 0.0), (2.0, 0.75, 0.0), (3.0, 0.875, 0.0)];
    let results = one(law, &steps, &states, &[5.0, 7.5, 99.0]);
    let failures: Vec<_> = results
        .iter()
        .map(|result| result.flags.iter().filter(|flag| matches!(flag, Flag::Failed { .. })).count())
        .collect();
    // A limit that is met is not passed: 1.5 at the first state, which is beyond 1.25.
    assert_eq!(failures, [1, 1, 0], "{:?}", results[1].flags);
    let outcome = |i: usize| results[i].behavior.as_ref().unwrap();
    assert_eq!(outcome(0).failed, [true, false, false, false, false, false]);
    assert_eq!(outcome(1).failed, [true; 6]);
    assert!(outcome(0).prescribed[0].is_none() && outcome(2).prescribed[0].is_none());
    // The second force was not known, the third was not there.
    assert_eq!(outcome(0).elastic.unknown[1].is_some(), outcome(0).elastic.value[1].is_none());
    assert_eq!(
        (outcome(1).elastic.value, outcome(1).elastic.unknown[1]),
        ([Some(0.0), Some(0.0), None, None, None, None], None)
    );
    assert!(!has(&results[2], |flag| matches!(flag, Flag::OutOfBalance { .. })));
}

/// Each held motion counts from where the component was when its own step began.
#[test]
fn every_step_knows_its_beginning() {
    let held = "*STEP\n*STATIC\n0.1, 1.\n*CONNECTOR MOTION, OP=NEW, FIXED\n7, 1\n*END STEP\n";
    let steps = format!("*STEP\n*STATIC\n0.1, 1.\n*END STEP\n{held}{held}");
    let states = [(1.0, 0.25, 0.0), (1.5, 0.375, 0.0), (2.0, 0.5, 0.0), (2.0, 0.75, 0.0), (2.5, 1.0, 0.0)];
    let results = one("*CONNECTOR DAMPING, COMPONENT=6\n0.", &steps, &states, &[]);
    assert_eq!(results[1].evaluation.residual[0], Some(0.125));
    // At the beginning of the third step two states are given: the first one counts.
    assert_eq!(results[4].evaluation.residual[0], Some(0.5));
}

/// Plasticity is told of its component alone.
#[test]
fn inelastic_components_are_told() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR ELASTICITY, COMPONENT=2\n10.\n\
               *CONNECTOR PLASTICITY, COMPONENT=1\n*CONNECTOR HARDENING\n10., 0.\n12., 0.1";
    let result = &one(law, "", &[(1.0, 0.5, 0.0)], &[])[0];
    let told = |component: &str| has(result, |flag| flag.component() == component);
    assert!(told("u1") && !told("u2"), "{:?}", result.flags);
    assert!(!behavior(law).is_empty());
}

/// What is told of laws that cannot be: by the names of their quantities.
#[test]
fn laws_are_refused_by_name() {
    let refused = |law: &str| {
        let error = Scene::parse("deck.inp", &deck(ALL_AVAILABLE, law, ""))
            .and_then(|scene| Model::compile(&scene))
            .err()
            .unwrap_or_else(|| panic!("accepted:\n{law}"));
        (error.code(), error.message().to_string())
    };
    // 5e-324 is a number apart from 0, by which nothing can be divided.
    for (law, name) in [
        ("ELASTICITY, COMPONENT=1, NONLINEAR", "the displacement"),
        ("DAMPING, COMPONENT=1, NONLINEAR", "the velocity"),
    ] {
        let (code, message) = refused(&format!("*CONNECTOR {law}\n1., 0.\n2., 5.E-324"));
        assert_eq!((code, message.starts_with(name)), (Code::NumberOutOfRange, true), "{message}");
    }
    for (of, name) in [
        ("POSITION", "the position of component 3"),
        ("CONSTITUTIVE MOTION", "the constitutive motion of component 3"),
    ] {
        let law = format!(
            "*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR, INDEPENDENT COMPONENTS={of}\n3\n1., 0.\n2., 5.E-324"
        );
        let (code, message) = refused(&law);
        assert_eq!((code, message.starts_with(name)), (Code::NumberOutOfRange, true), "{message}");
    }
    // Terms of components that the type has not are not used.
    let ones = "4., 9., 9., 9., 9., 9., 9., 9.\n9., 9., 9., 9., 9., 9., 9., 9.\n9., 9., 9., 9., 9.";
    let slot = model("SLOT", &format!("*CONNECTOR ELASTICITY\n{ones}"), "");
    let result = &walk(&slot, &along_1(&[(1.0, 0.5, 0.0)]), Velocities::Rates, &[])[0];
    assert_eq!(result.behavior.as_ref().unwrap().elastic.value[0], Some(2.0));
    assert_eq!(slot.connectors[0].behavior.behavior.elasticity.components()[1..], [false; 5]);
}
