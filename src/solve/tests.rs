use crate::fault::Fault;
use crate::motion::mechanism::Mechanism;
use crate::motion::rows::Instant;
use crate::motion::state::{DOFS, Pose, State};
use crate::{Method, NodeFrame, Options, REFERENCES, Solution, Solvable, Stick, What, solve};
use pintle_kinematics::scalar::{Real, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{add, apply, cross};
use pintle_model::behavior::drive::Schedule;
use pintle_model::evaluate::Model;
use pintle_scene::Scene;

fn solved<R: Solvable>(deck: &str, options: &Options) -> Solution<R> {
    let scene = Scene::parse("deck.inp", deck).unwrap();
    match solve(&scene, options) {
        Ok(solution) => solution,
        Err(ended) => panic!("at {}: {}", ended.time, ended.why),
    }
}

const PENDULUM: &str = "\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=JOINT
101, , 1
*ORIENTATION, NAME=AXIS
0., 0., 1., 1., 0., 0.
*CONNECTOR SECTION, ELSET=JOINT
HINGE,
AXIS,
*ELEMENT, TYPE=MASS, ELSET=BOB
201, 2
*MASS, ELSET=BOB
2.
*MPC
BEAM, 1, 2
*STEP
*DYNAMIC
0.01, 4.
*DLOAD
BOB, GRAV, 10., 0., -1., 0.
*END STEP
";

/// Released level, a pendulum is level again on the other side after K(sin 45°) 2 √(L/g): elliptic functions, typed from tables.
#[test]
fn a_pendulum_swings_as_elliptic_functions_say() {
    let quarter = 1.854_074_677_301_372_f64 * (1.0_f64 / 10.0).sqrt();
    for method in [Method::Extrapolation, Method::Collocation] {
        let options = Options {
            times: vec![quarter, 2.0 * quarter],
            method,
            until: Some(2.0 * quarter),
            ..Options::default()
        };
        let solution: Solution<f64> = solved(PENDULUM, &options);
        let at = |i: usize| &solution.frames[i];
        println!(
            "{method:?}: {} steps, {} evaluations, violation {:e}",
            solution.steps, solution.evaluations, solution.violation
        );
        assert_eq!(solution.frames.len(), 3);
        // At the bottom after a quarter, with ω² = 2 g/L.
        let bottom = at(1).nodes.iter().find(|node| node.displacement[0].abs() > 0.5).unwrap();
        assert!((bottom.displacement[0] + 1.0).abs() < 1e-13, "{:?}", bottom.displacement);
        assert!((bottom.displacement[1] + 1.0).abs() < 1e-13, "{:?}", bottom.displacement);
        assert!((bottom.velocity[5] + 20.0_f64.sqrt()).abs() < 1e-12, "{:?}", bottom.velocity);
        let other = at(2).nodes.iter().find(|node| node.displacement[0].abs() > 0.5).unwrap();
        assert!((other.displacement[0] + 2.0).abs() < 1e-12, "{:?}", other.displacement);
        assert!(at(2).energies.balance.abs() < 1e-12, "{:?}", at(2).energies);
        // CTF at the bottom: the pin pulls with 3 m g.
        let pull = at(1).connectors[0].total;
        let size = pull[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((size - 60.0).abs() < 1e-11, "{pull:?}");
    }
}

#[test]
fn a_pendulum_on_237_bits() {
    let options = Options { digits: 36, until: Some(0.5), ..Options::default() };
    let one: Solution<Wide> = solved(PENDULUM, &options);
    let other: Solution<Wide> = solved(PENDULUM, &Options { method: Method::Collocation, ..options });
    let apart = one.difference(&other);
    println!("{} and {} evaluations: {apart:?}", one.evaluations, other.evaluations);
    assert!(apart.compared > 50 && apart.largest() < 1e-33, "{apart:?}");
}

/// A block on a TRANSLATOR that presses with its weight, pulled by a spring whose other end moves.
const BLOCK: &str = "\
*NODE
1, 0., 0., 0.
2, 0., 0., 0.
3, 1., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=RAIL
101, 1, 2
*ORIENTATION, NAME=ALONG
1., 0., 0., 0., 1., 0.
*CONNECTOR SECTION, ELSET=RAIL, BEHAVIOR=DRY
TRANSLATOR,
ALONG,
*CONNECTOR BEHAVIOR, NAME=DRY
*CONNECTOR FRICTION, PREDEFINED
0.5, 0.2
*FRICTION
0.25
*ELEMENT, TYPE=MASS, ELSET=M
201, 2
*MASS, ELSET=M
2.
*ELEMENT, TYPE=ROTARYI, ELSET=I
202, 2
*ROTARY INERTIA, ELSET=I
1., 1., 1.
*ELEMENT, TYPE=SPRINGA, ELSET=S
203, 2, 3
*SPRING, ELSET=S

100.
*BOUNDARY
1, 1, 6
3, 2, 6
*AMPLITUDE, NAME=PULL
0., 0., 10., 1.
*STEP
*DYNAMIC
0.01, 3.
*BOUNDARY, AMPLITUDE=PULL
3, 1, 1, 5.
*DLOAD
M, GRAV, 10., 0., -1., 0.
*END STEP
";

/// Drives node 3 to 1 at 0.5 and leaves it there: stick, one slip whose end is in closed form, rest.
#[test]
fn a_block_sticks_and_slips() {
    let deck = BLOCK
        .replace("0., 0., 10., 1.", "0., 0., 0.2, 0.1, 5., 0.1")
        .replace("*AMPLITUDE, NAME=PULL", "*AMPLITUDE, NAME=PULL, SMOOTH=0.")
        .replace("3, 1, 1, 5.", "3, 1, 1, 2.");
    let solution: Solution<f64> =
        solved(&deck, &Options { times: vec![0.02, 0.04, 0.15, 1.0, 2.0], ..Options::default() });
    for event in &solution.events {
        println!("{:.16} {:?} {:?} {:e}", event.time, event.what, event.margin, event.lipschitz);
    }
    println!(
        "{} steps, {} evaluations, violation {:e}",
        solution.steps, solution.evaluations, solution.violation
    );
    for frame in &solution.frames {
        println!(
            "{:.4} {:?} {:?} {:?}",
            frame.time,
            frame.nodes.iter().map(|n| n.displacement[0]).collect::<Vec<_>>(),
            frame.connectors[0].velocity[0],
            frame.connectors[0].total[0]
        );
    }
    // The end moves with 1: the spring pulls with 5 = μ m g at 0.05; ω² = 50.
    let w = 50.0_f64.sqrt();
    assert!((solution.events[0].time - 0.05).abs() < 1e-15, "{}", solution.events[0].time);
    // x = τ − sin(ωτ)/ω until 0.2, then free about 0.2 − 0.05 = 0.15 until it rests.
    let tau: f64 = 0.15;
    let (x, v) = (tau - (w * tau).sin() / w, 1.0 - (w * tau).cos());
    let rest = 0.2 + (v * w).atan2(50.0 * (x - 0.15)).rem_euclid(std::f64::consts::PI) / w;
    assert_eq!(solution.events[1].what, What::Reverses);
    assert!((solution.events[1].time - rest).abs() < 1e-14, "{} {rest}", solution.events[1].time);
    // Back about 0.2 + 0.05 for half a period, where the spring holds less than friction.
    let turn = 0.15 + ((x - 0.15).powi(2) + v * v / 50.0).sqrt();
    let (end, at_rest) = (rest + std::f64::consts::PI / w, 0.5 - turn);
    assert_eq!(solution.events[2].what, What::Sticks);
    assert!((solution.events[2].time - end).abs() < 1e-14, "{} {end}", solution.events[2].time);
    assert_eq!(solution.events.len(), 3);
    let last = solution.frames.last().unwrap();
    assert!(
        (last.connectors[0].displacement[0] - at_rest).abs() < 1e-14,
        "{:?} {at_rest}",
        last.connectors[0]
    );
    let mut compared = 0;
    for frame in &solution.frames {
        assert!(frame.energies.balance.abs() < 1e-13, "{:?}", frame.energies);
        if frame.connectors[0].sticks[0] {
            assert_eq!(frame.connectors[0].velocity[0], 0.0, "at {}", frame.time);
            compared += 1;
        }
        if frame.time > end {
            assert_eq!(frame.connectors[0].displacement[0], last.connectors[0].displacement[0], "creep");
        }
    }
    assert!(compared >= 5);
}

/// A mass on a rail that rubs: 20 N press it, and it sticks up to 5 N.
const RAIL: &str = "\
*NODE
1, 0., 0., 0.
2, 0., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=RAIL
101, 1, 2
*ORIENTATION, NAME=ALONG
1., 0., 0., 0., 1., 0.
*CONNECTOR SECTION, ELSET=RAIL, BEHAVIOR=DRY
TRANSLATOR,
ALONG,
*CONNECTOR BEHAVIOR, NAME=DRY
*CONNECTOR FRICTION, PREDEFINED
0.5, 0.2
*FRICTION
0.25
*ELEMENT, TYPE=MASS, ELSET=M
201, 2
*MASS, ELSET=M
2.
*ELEMENT, TYPE=ROTARYI, ELSET=I
202, 2
*ROTARY INERTIA, ELSET=I
1., 1., 1.
*BOUNDARY
1, 1, 6
*AMPLITUDE, NAME=A, ITS LINES
*STEP
*DYNAMIC
0.01, LENGTH
*CLOAD, AMPLITUDE=A
2, 1, PUSH
*DLOAD
M, GRAV, 10., 0., -1., 0.
*END STEP
";

/// Its solution under a load by an amplitude, by both methods, and how far they are apart.
fn on_the_rail(amplitude: &str, length: &str, load: &str) -> ([Solution<f64>; 2], f64) {
    let deck = RAIL.replace("ITS LINES", amplitude).replace("LENGTH", length).replace("PUSH", load);
    let both = [Method::Extrapolation, Method::Collocation]
        .map(|method| solved::<f64>(&deck, &Options { method, ..Options::default() }));
    let apart = both[0].difference(&both[1]).largest();
    (both, apart)
}

/// The rail with another friction, and what comes before its step, under a load that stays.
fn rubbed(friction: &str, before: &str, load: &str, length: &str) -> String {
    let deck = RAIL.replace("*CONNECTOR FRICTION, PREDEFINED\n0.5, 0.2\n*FRICTION\n0.25\n", friction);
    let deck = deck.replace("*AMPLITUDE, NAME=A, ITS LINES\n", before).replace(", AMPLITUDE=A", "");
    deck.replace("PUSH", load).replace("LENGTH", length)
}

/// What presses is a derived component of 20 N, and 50 N inside or −50 N: μ |20 ± 50| brakes.
#[test]
fn an_internal_contact_force_presses_beside_a_derived_component() {
    for (internal, force) in [(0.0, 20.0), (50.0, 70.0), (-50.0, 30.0)] {
        let friction = format!(
            "*CONNECTOR DERIVED COMPONENT, NAME=N\n2, 3\n1., 2.\n*CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=N\n, {internal}\n\
             *FRICTION\n0.25\n"
        );
        let deck = rubbed(&friction, "*INITIAL CONDITIONS, TYPE=VELOCITY\n2, 1, 9.\n", "0.", "0.5");
        let solution: Solution<f64> = solved(&deck, &Options::default());
        let last = solution.frames.last().unwrap();
        let brakes = 0.25 * force;
        assert!((last.connectors[0].friction[0] - brakes).abs() < 1e-13, "{:?}", last.connectors[0].friction);
        let [x, v] = [last.nodes[1].displacement[0], last.nodes[1].velocity[0]];
        assert!((v - (9.0 - brakes / 4.0)).abs() < 1e-13, "{v}");
        assert!((x - (4.5 - brakes / 16.0)).abs() < 1e-13, "{x}");
    }
}

/// Nothing presses as it begins: the weight swings on a spring, N = 20 (1 − cos 20 t), and the load grows as 100 t.
#[test]
fn a_slip_begins_where_nothing_presses_yet() {
    let friction = "*CONNECTOR ELASTICITY, COMPONENT=2\n800.\n*CONNECTOR DERIVED COMPONENT, NAME=N\n2\n1.\n\
                    *CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=N\n*FRICTION\n0.1\n";
    let grows = "*AMPLITUDE, NAME=A\n0., 0., 1., 1.\n*BOUNDARY\n2, 4, 6\n";
    let deck = rubbed(friction, grows, "100.", "0.5")
        .replace("*CLOAD", "*CLOAD, AMPLITUDE=A")
        .replace("TRANSLATOR", "CARTESIAN");
    for method in [Method::Extrapolation, Method::Collocation] {
        let solution: Solution<f64> = solved(&deck, &Options { method, ..Options::default() });
        let speed = solution.frames.last().unwrap().nodes[1].velocity[0];
        let by_hand = 25.0 * 0.25 - (0.5 - 10.0_f64.sin() / 20.0);
        assert!((speed - by_hand).abs() < 1e-12, "{method:?}: {speed} {by_hand}");
    }
}

/// A spring of 60 on the rail fails at 0.1 as friction slips, at cos ωt = 0.4; nothing rubs any more where its load turns, and in a static path.
#[test]
fn friction_is_gone_where_its_component_has_failed() {
    let friction = "*CONNECTOR ELASTICITY, COMPONENT=1\n60.\n*CONNECTOR FAILURE, COMPONENT=1, RELEASE=1\n, 0.1\n\
                    *CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=2000.\n0.5, 0.2\n*FRICTION\n0.1\n";
    let turns = "*AMPLITUDE, NAME=A\n0., 1., .5, 1., .6, -1., 2., -1.\n";
    let deck = rubbed(friction, turns, "12.", "2.").replace("*CLOAD", "*CLOAD, AMPLITUDE=A");
    for (stick, method) in [
        (Stick::Rigid, Method::Extrapolation),
        (Stick::Rigid, Method::Collocation),
        (Stick::Elastic, Method::Extrapolation),
    ] {
        let options = Options { stick, method, times: vec![0.3, 0.55, 1.0], ..Options::default() };
        let solution: Solution<f64> = solved(&deck, &options);
        let last = solution.events.last().unwrap();
        assert_eq!(last.what, What::Fails);
        let failed = last.time;
        let frame = |time: f64| solution.frames.iter().rfind(|frame| frame.time <= time).unwrap();
        let before = frame(failed).nodes[1].velocity[0];
        if stick == Stick::Rigid {
            let w = 30.0_f64.sqrt();
            let by_hand = 0.4_f64.acos() / w;
            assert!((failed - by_hand).abs() < 1e-14, "{failed} {by_hand}");
            assert!((before - (w * by_hand).sin() * w / 6.0).abs() < 1e-13, "{before}");
        }
        let after = before + 6.0 * (0.5 - failed) - 6.0 * 1.4;
        let speed = frame(2.0).nodes[1].velocity[0];
        assert!((speed - after).abs() < 1e-12, "{speed} {after}");
        let mut compared = 0;
        for frame in solution.frames.iter().filter(|frame| frame.time >= failed) {
            let rail = &frame.connectors[0];
            assert!(rail.failed[0] && rail.friction[0] == 0.0 && rail.sticks == [false], "{rail:?}");
            assert!(frame.energies.balance.abs() < 1e-12, "{:?}", frame.energies);
            compared += 1;
        }
        assert!(compared >= 5);
        // All that the spring of stick held is lost with it.
        assert!(frame(2.0).energies.stored.abs() < 1e-12, "{:?}", frame(2.0).energies);
    }
    // A spring of 40 beside it, and all loads grow: 100 x = 21 t − 2 t up to 0.1, then 40 x = 21 t.
    let ground = "*ELEMENT, TYPE=SPRING1, ELSET=G\n204, 2\n*SPRING, ELSET=G\n1\n40.\n";
    let deck = rubbed(friction, ground, "21.", "1.")
        .replace("*DYNAMIC", "*STATIC")
        .replace("*CLOAD", "*CLOAD, AMPLITUDE=UP");
    let deck = deck.replace("*STEP\n", "*AMPLITUDE, NAME=UP\n0., 0., 1., 1.\n*STEP\n");
    let solution: Solution<f64> = solved(&deck, &Options::default());
    let last = solution.frames.last().unwrap();
    assert!((solution.events.last().unwrap().time - 10.0 / 19.0).abs() < 1e-12, "{:?}", solution.events);
    assert!((last.nodes[1].displacement[0] - 21.0 / 40.0).abs() < 1e-12, "{:?}", last.nodes[1].displacement);
}

/// A pin that slips fails: nothing is hit, and nothing takes energy from there on: ½ 2.1 ω² + 2 g y stays.
#[test]
fn a_failure_is_no_impact() {
    let deck = PENDULUM
        .replace("ELSET=JOINT\nHINGE", "ELSET=JOINT, BEHAVIOR=DRY\nHINGE")
        .replace("*MPC", "*CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR FRICTION, PREDEFINED\n0.02, 0.3, 0.5\n*FRICTION\n0.15\n\
                          *CONNECTOR FAILURE, COMPONENT=4, RELEASE=4\n-1., \n*MPC")
        .replace("*STEP\n", "*ELEMENT, TYPE=ROTARYI, ELSET=I\n202, 2\n*ROTARY INERTIA, ELSET=I\n0.1, 0.1, 0.1\n*STEP\n")
        .replace("0.01, 4.", "0.01, 2.");
    let solution: Solution<f64> = solved(&deck, &Options::default());
    let fails = solution.events.last().unwrap();
    assert_eq!(fails.what, What::Fails);
    let bob = solution.nodes.iter().position(|node| node.to_string() == "2").unwrap();
    let frame = |time: f64| solution.frames.iter().rfind(|frame| frame.time <= time).unwrap();
    let [before, after] = [fails.time, 2.0].map(|time| {
        let bob = &frame(time).nodes[bob];
        1.05 * bob.velocity[5].powi(2) + 20.0 * bob.displacement[1]
    });
    assert!((before - after).abs() < 1e-12 && before < -0.05, "{before} {after}");
    assert!(frame(2.0).energies.balance.abs() < 1e-12, "{:?}", frame(2.0).energies);
}

/// μ F_N is 5, but no more than 3 rubs: 2 a = −4 − 3 until it rests at 2/7, and 2 a = −4 + 3 back.
#[test]
fn a_largest_friction_force_holds_no_more() {
    let friction = "*CONNECTOR FRICTION, PREDEFINED\n0.5, 0.2\n*FRICTION, TAUMAX=3.\n0.25\n";
    let deck = rubbed(friction, "*INITIAL CONDITIONS, TYPE=VELOCITY\n2, 1, 1.\n", "-4.", "1.");
    let solution: Solution<f64> = solved(&deck, &Options::default());
    let [turns] = solution.events.as_slice() else { panic!("{:?}", solution.events) };
    assert_eq!(turns.what, What::Reverses);
    assert!((turns.time - 2.0 / 7.0).abs() < 1e-14, "{}", turns.time);
    assert!((turns.margin.unwrap() - 0.25).abs() < 1e-13, "{:?}", turns.margin);
    let speed = solution.frames.last().unwrap().nodes[1].velocity[0];
    assert!((speed + 0.5 * 5.0 / 7.0).abs() < 1e-13, "{speed}");
}

/// A mass 0.3 above a rail of length L, pushed along by 8: T = 0.3 (20 + 2 |M|/L) with M = 0.3 (8 − T). Where 0.18/L > 1 both signs of M give a
/// root, below there is one.
#[test]
fn two_friction_forces_that_fit_are_both_named() {
    let short = "*CONNECTOR FRICTION, PREDEFINED\n0.5, ARM\n*FRICTION\n0.3\n";
    let above = "*NODE\n3, 0., 0.3, 0.\n*MPC\nBEAM, 3, 2\n*INITIAL CONDITIONS, TYPE=VELOCITY\n2, 1, 1.\n";
    let deck =
        rubbed(short, above, "8.", "1.").replace("201, 2\n", "201, 3\n").replace("202, 2\n", "202, 3\n");
    let deck = deck.replace("1., 1., 1.", "0.1, 0.1, 0.1");
    let scene = Scene::parse("deck.inp", &deck.replace("ARM", "0.1")).unwrap();
    let why = solve::<f64>(&scene, &Options::default()).unwrap_err().why.to_string();
    // T = 6 ± 1.8 (8 − T).
    assert!(why.contains("7.285714;") && why.contains("10.5"), "{why}");
    // From rest 10.5 would turn the slip back: it fits from then on.
    let deck_at_rest = deck.replace("2, 1, 1.\n", "2, 1, 0.\n").replace("ARM", "0.1");
    let ended =
        solve::<f64>(&Scene::parse("deck.inp", &deck_at_rest).unwrap(), &Options::default()).unwrap_err();
    assert!(ended.time > 0.0 && ended.time < 1e-3, "{}", ended.time);
    let solution: Solution<f64> = solved(&deck.replace("ARM", "0.2"), &Options::default());
    let rubs = solution.frames[0].connectors[0].friction[0];
    assert!((rubs - 13.2 / 1.9).abs() < 1e-13 && solution.lipschitz < 1.0, "{rubs} {}", solution.lipschitz);
}

/// The margin of a turn is by what the load exceeds what friction holds, that of rest by what it holds more, each of its own friction. Of two
/// masses on rails, up to 5 N each, one stands under 4.9 N as the other comes to rest under 1 N. What is prescribed has none.
#[test]
fn margins_are_those_of_the_friction_itself() {
    let dry = "*CONNECTOR FRICTION, PREDEFINED\n0.5, 0.2\n*FRICTION\n0.25\n";
    let moves = "*INITIAL CONDITIONS, TYPE=VELOCITY\n2, 1, 1.\n";
    let margin = |deck: &str| {
        let solution: Solution<f64> = solved(deck, &Options::default());
        (solution.events[0].what, solution.events[0].margin)
    };
    for more in [1e-7, 1e-4, 2.0] {
        let (what, margin) = margin(&rubbed(dry, moves, &format!("{}", -5.0 - more), "1."));
        let wanted = more / (5.0 + more);
        assert_eq!(what, What::Reverses);
        assert!((margin.unwrap() / wanted - 1.0).abs() < 1e-6, "{margin:?} {wanted:e}");
    }
    let second = "*NODE\n11, 0., 0., 0.\n12, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=RAIL\n111, 11, 12\n\
                  *ELEMENT, TYPE=MASS, ELSET=M\n211, 12\n*ELEMENT, TYPE=ROTARYI, ELSET=I\n212, 12\n*BOUNDARY\n11, 1, 6\n";
    let deck = rubbed(dry, &format!("{second}{moves}"), "1.\n12, 1, 4.9", "1.");
    let (what, own) = margin(&deck);
    assert_eq!(what, What::Sticks);
    assert!((own.unwrap() - 0.8).abs() < 1e-13, "{own:?}");
    let driven = "*AMPLITUDE, NAME=D, DEFINITION=PERIODIC\n1, 5., 0., 0.\n0., 1.\n";
    let deck = rubbed(dry, driven, "0.", "0.5")
        .replace("*CLOAD", "*CONNECTOR MOTION, AMPLITUDE=D\nRAIL, 1, 0.3\n*CLOAD");
    let solution: Solution<f64> = solved(&deck, &Options::default());
    assert!(!solution.events.is_empty());
    for event in &solution.events {
        assert_eq!(event.what, What::Reverses);
        assert_eq!(event.margin, None);
    }
}

/// A load that oscillates above the bound for a moment, once in 2π, while nothing moves: each moment is met, by both methods.
#[test]
fn a_load_that_oscillates_is_seen_while_all_sticks() {
    let ten = "DEFINITION=PERIODIC\n10, 1., -0.9, 0.\n.1, 0., .1, 0., .1, 0., .1, 0.\n.1, 0., .1, 0., .1, 0., .1, 0.\n.1, 0., .1, 0.";
    let (both, _) = on_the_rail(ten, "20.", "5.2");
    for solution in both {
        let slips = solution.events.iter().filter(|event| event.what == What::Slips);
        let slips: Vec<f64> = slips.map(|event| event.time).collect();
        assert_eq!(slips.len(), 3, "{:?}: {slips:?}", solution.method);
        // As often as the load comes round.
        let apart: Vec<f64> = slips.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(apart.iter().all(|time| (time - std::f64::consts::TAU).abs() < 1e-10), "{apart:?}");
        let moved = solution.frames.last().unwrap().nodes[1].displacement[0];
        assert!((moved - 3.0 * 4.556e-4).abs() < 1e-6, "{moved}");
    }
}

/// Loads that jump past the bound within a step: slip begins there, with a = (6 − 5)/2.
#[test]
fn a_load_that_jumps_begins_a_slip() {
    let jumps = [
        "DEFINITION=TABULAR\n0., 0., 1., 0., 1., 1., 4., 1.",
        "DEFINITION=PERIODIC\n1, 1e-9, 1., 0.\n1., 0.",
        "DEFINITION=DECAY\n0., 1., 1., 1e12",
    ];
    for amplitude in jumps {
        let (both, apart) = on_the_rail(amplitude, "3.", "6.");
        assert!(apart < 1e-12, "{amplitude}: {apart:e}");
        for solution in both {
            let events: Vec<_> = solution.events.iter().map(|event| (event.time, event.what)).collect();
            assert!(
                matches!(events[..], [(time, What::Slips)] if (time - 1.0).abs() < 1e-14),
                "{amplitude}, {:?}: {events:?}",
                solution.method
            );
            let last = solution.frames.last().unwrap();
            assert!((last.nodes[1].displacement[0] - 1.0).abs() < 1e-11, "{amplitude}: {:?}", last.nodes[1]);
        }
    }
    // Below the bound nothing happens.
    let (both, _) = on_the_rail(jumps[0], "3.", "4.9");
    assert!(both.iter().all(|solution| solution.events.is_empty()));
}

/// What sticks all the time is at rest, and rounding no error.
#[test]
fn rest_is_known() {
    let (both, apart) = on_the_rail("DEFINITION=PERIODIC\n1, 3., 0., 0.\n0., 1.", "2.", "4.");
    assert!(apart < 1e-12, "{apart:e}");
    for solution in &both {
        let last = solution.frames.last().unwrap();
        assert!(solution.events.is_empty());
        assert!(
            (last.connectors[0].total[0] - 4.0 * 6.0_f64.sin()).abs() < 1e-13,
            "{:?}",
            last.connectors[0]
        );
    }
}

/// Every problem of `references/`, with the error that is allowed between the methods, and how many events it has.
const EXPECTED: [(&str, f64, usize); 78] = [
    ("andrews", 2e-12, 0),
    ("belt_swing", 1e-12, 6),
    ("block", 1e-12, 3),
    ("bricard", 1e-12, 0),
    ("cardan_shaft", 1e-12, 0),
    ("carrier_jumps", 1e-12, 2),
    ("chain", 1e-12, 13),
    ("clutch", 1e-12, 2),
    ("collar_held", 1e-12, 1),
    ("collision", 1e-12, 2),
    ("cross_friction", 1e-12, 18),
    ("cross_swing", 1e-12, 10),
    ("cv_joint", 1e-12, 0),
    ("cylinder_eccentric", 1e-12, 0),
    ("cylinder_wander", 1e-12, 6),
    ("damped_coast", 1e-12, 0),
    ("damper_oneway", 1e-12, 0),
    ("double_hinge", 1e-12, 14),
    ("double_pendulum", 1e-12, 0),
    ("drawer", 1e-12, 5),
    ("driven_plane", 1e-12, 0),
    ("ellipse_slide", 1e-12, 1),
    ("failure", 1e-12, 1),
    ("failure_hang", 1e-12, 1),
    // Moments of 4e-3 beside stiff springs, whose forces round to 2e-11.
    ("flyball", 1e-9, 0),
    ("four_bar", 1e-12, 0),
    ("free_top", 1e-12, 0),
    ("friction_decay", 1e-12, 7),
    ("helical_slide", 1e-12, 1),
    ("hinge_rest", 1e-12, 11),
    ("incline_rest", 1e-12, 1),
    ("incline_return", 1e-12, 1),
    ("ladder", 1e-12, 1),
    ("limit_cycle", 1e-12, 8),
    ("load_reversal", 1e-12, 0),
    ("lock", 1e-12, 1),
    ("lock_flywheel", 1e-12, 1),
    ("lock_slide", 1e-12, 1),
    ("oscillator", 1e-12, 0),
    ("pendulum", 1e-12, 0),
    ("pendulum_cart", 1e-12, 9),
    ("pendulum_turns", 1e-12, 0),
    ("planar_edge", 1e-12, 2),
    ("planar_spin", 1e-12, 2),
    ("press", 1e-12, 1),
    ("projectile", 1e-12, 0),
    ("puck", 1e-12, 0),
    ("retractor_drum", 2e-12, 0),
    ("rotating_arm", 1e-12, 0),
    ("rough_four_bar", 1e-12, 2),
    ("scotch_yoke", 1e-12, 5),
    ("self_locking", 1e-12, 0),
    ("slider_crank", 1e-12, 9),
    ("slot", 1e-12, 1),
    ("spherical_pendulum", 1e-12, 0),
    ("spin_down", 1e-12, 1),
    ("stacked", 1e-12, 6),
    ("static_axial", 1e-12, 0),
    ("static_belt", 1e-12, 3),
    ("static_drawer", 1e-12, 5),
    ("static_hinge", 1e-12, 5),
    ("static_lever", 1e-12, 1),
    ("static_rings", 1e-12, 6),
    ("static_slot", 1e-12, 2),
    ("stop_between", 1e-12, 0),
    ("stop_elastic", 1e-12, 0),
    ("stop_friction", 1e-12, 4),
    ("stop_pendulum", 1e-12, 1),
    ("stop_rigid", 1e-12, 3),
    ("stop_together", 1e-12, 2),
    ("stribeck", 1e-12, 2),
    ("top", 2e-12, 0),
    ("translator_moment", 1e-12, 1),
    ("turntable", 1e-12, 1),
    ("two_blocks", 1e-12, 12),
    ("two_masses", 1e-12, 0),
    ("unbalance", 1e-12, 0),
    ("wander", 1e-12, 6),
];

fn reference(name: &str) -> &'static str {
    REFERENCES.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("{name} is not listed")).1
}

/// Every folder of `references/` is listed.
#[test]
fn references_are_all_solved() {
    let folder = format!("{}/../../references", env!("CARGO_MANIFEST_DIR"));
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, EXPECTED.map(|(name, ..)| name));
    assert!(REFERENCES.iter().map(|(name, _)| *name).eq(EXPECTED.map(|(name, ..)| name)));
}

/// The solution that is stored: events at their times, what they are, and the last state. Those in closed form are typed apart, in
/// `scripts/reference/reference_solve.py`.
fn meets(name: &str, solution: &Solution<f64>, seen: &mut Seen) {
    const ALLOWED: f64 = 2e-12;
    let path = format!("{}/../../references/{name}/closed.json", env!("CARGO_MANIFEST_DIR"));
    let Ok(text) = std::fs::read_to_string(&path) else { return };
    let stored: serde_json::Value = serde_json::from_str(&text).unwrap();
    let last = solution.frames.last().unwrap();
    let number = |value: &serde_json::Value| value.as_str().unwrap().parse::<f64>().unwrap();
    let events = stored["events"].as_array().unwrap();
    let told: Vec<&str> = solution.events.iter().map(|event| event.what.name()).collect();
    let wanted: Vec<String> = events
        .iter()
        .map(|event| {
            event[1].as_str().unwrap().replace("closes", "stop closes").replace("opens", "stop opens")
        })
        .collect();
    assert_eq!(told, wanted, "{name}");
    for (found, event) in solution.events.iter().zip(events) {
        let apart = found.time - number(&event[0]);
        assert!(apart.abs() <= EVENT, "{name}: event at {:e}, {apart:e} apart", found.time);
        seen.numbers += 1;
    }
    let mut meet = |found: f64, wanted: f64, scale: f64, what: &str| {
        assert!(
            (found - wanted).abs() <= ALLOWED * scale.max(1.0),
            "{name}, {what}: {found:e}, not {wanted:e}"
        );
        seen.numbers += 1;
    };
    for (label, components) in stored["last"]["connectors"].as_object().unwrap() {
        let index = solution.connectors.iter().position(|(known, _)| known.to_string() == *label).unwrap();
        let found = &last.connectors[index];
        for (k, of) in components.as_object().unwrap() {
            let k = k.parse::<usize>().unwrap() - 1;
            let all = [("CU", found.displacement[k]), ("CV", found.velocity[k]), ("CTF", found.total[k])];
            for (what, x) in all {
                let wanted = number(&of[what]);
                meet(x, wanted, 10.0 * wanted.abs(), what);
            }
        }
    }
    for (label, rates) in stored["last"]["velocities"].as_object().unwrap() {
        let index = solution.nodes.iter().position(|known| known.to_string() == *label).unwrap();
        for (k, rate) in rates.as_array().unwrap().iter().enumerate() {
            meet(last.nodes[index].velocity[k], number(rate), 10.0, "velocity");
        }
    }
    for (label, moved) in stored["last"]["displacements"].as_object().into_iter().flatten() {
        let index = solution.nodes.iter().position(|known| known.to_string() == *label).unwrap();
        for (k, x) in moved.as_array().unwrap().iter().enumerate() {
            meet(last.nodes[index].displacement[k], number(x), 1.0, "displacement");
        }
    }
    seen.closed += usize::from(stored["from"].as_str().unwrap().contains("closed form"));
}

/// How far the times of events may be apart, in units of time.
const EVENT: f64 = 1e-13;

/// How much was compared.
#[derive(Default)]
struct Seen {
    frames: usize,
    stuck: usize,
    events: usize,
    numbers: usize,
    closed: usize,
    criteria: usize,
    momenta: usize,
}

const FEW: usize = 20_000;

/// Two methods agree; energy is kept; equations hold; what sticks stands still, and closed stops push.
fn obeys(name: &str, allowed: f64, expected: usize, seen: &mut Seen) {
    let deck = reference(name);
    let schedule = Schedule::new(&Scene::parse(name, deck).unwrap());
    let ([_, end], _) = schedule.span(schedule.len() - 1).unwrap();
    let times = vec![0.23 * end, 0.51 * end, 0.77 * end];
    let options = Options { most_steps: FEW, times, ..Options::default() };
    let one: Solution<f64> = solved(deck, &options);
    let other: Solution<f64> = solved(deck, &Options { method: Method::Collocation, ..options.clone() });
    let apart = one.difference(&other);
    // Positions are back on their equations however large the errors of steps are.
    let coarse: Solution<f64> = solved(deck, &Options { digits: 8, ..options });
    assert!(coarse.violation < 5e-15, "{name}, 8 digits: {}", coarse.violation);
    assert!(apart.largest() <= allowed && apart.event * end <= EVENT, "{name}: {apart:?}");
    assert_eq!(one.events.len(), expected, "{name}");
    assert!(one.violation < 5e-15 && one.lipschitz < 1.0, "{name}: {} {}", one.violation, one.lipschitz);
    let most =
        one.frames.iter().map(|of| of.energies.external.abs().max(of.energies.kinetic)).fold(1e-3, f64::max);
    for pair in one.frames.windows(2) {
        let lost = pair[1].energies.dissipated - pair[0].energies.dissipated;
        assert!(lost >= -1e-12 * most, "{name} at {}: dissipation gives {lost:e}", pair[1].time);
    }
    for frame in &one.frames {
        seen.frames += 1;
        assert!(frame.energies.balance.abs() <= 1e-11 * most, "{name}: {:?}", frame.energies);
        for connector in &frame.connectors {
            for ([tangential, limit], sticks) in connector.limits.iter().zip(&connector.sticks) {
                // Φ ≤ 0, and Φ = 0 in slip.
                let allowed = 1e-12 * limit.max(1.0);
                assert!(tangential - limit <= allowed, "{name} at {}: {tangential} {limit}", frame.time);
                assert!(
                    *sticks || limit - tangential <= allowed,
                    "{name} at {}: {tangential} {limit}",
                    frame.time
                );
                seen.criteria += 1;
            }
            if !connector.sticks.is_empty() && connector.sticks.iter().all(|sticks| *sticks) {
                seen.stuck += 1;
                for k in (0..6).filter(|k| connector.friction[*k] != 0.0) {
                    // On a body that turns, two velocities differ by their rounding.
                    let allowed = if name == "turntable" { 1e-15 } else { 0.0 };
                    assert!(connector.velocity[k].abs() <= allowed, "{name} at {}", frame.time);
                }
            }
        }
    }
    seen.events += one.events.len();
    momentum(name, &one, seen);
    meets(name, &one, seen);
}

/// Loads and reactions make the momentum and the moment of momentum about the origin, M a + ω × I ω: what acts between bodies cancels. Where
/// something acts from outside that is no support (the ground of a connector, a spring on one node), nothing is said.
fn momentum(name: &str, solution: &Solution<f64>, seen: &mut Seen) {
    let scene = Scene::parse(name, reference(name)).unwrap();
    let model = Model::compile(&scene).unwrap();
    let schedule = Schedule::new(&scene);
    for frame in &solution.frames {
        let within = |step: &usize| schedule.span(*step).is_some_and(|([_, end], _)| frame.time <= end);
        let step = (0..schedule.len()).find(within).unwrap();
        let mechanism: Mechanism<f64> = Mechanism::new(&scene, &model, step).unwrap();
        let is_grounded = mechanism.joints.iter().any(|joint| joint.ends.contains(&None));
        let is_open = frame.connectors.iter().any(|of| of.open.contains(&true));
        // Springs between degrees of freedom, equations and belts at a distance turn.
        let turns =
            mechanism.springs.iter().any(|spring| spring.line.is_none()) || !mechanism.relations.is_empty();
        if is_grounded || is_open || turns {
            return;
        }
        let pose = |node: &NodeFrame<f64>| Pose {
            displacement: node.displacement,
            rotation: so3::turn(node.rotation),
            vector: node.rotation,
            flow: 0.0,
        };
        let rates = |node: &NodeFrame<f64>| {
            [0, 1, 2, 3, 4, 5, 6].map(|k| node.velocity.get(k).copied().unwrap_or(0.0))
        };
        let state = State {
            time: frame.time,
            poses: frame.nodes.iter().map(pose).collect(),
            rates: frame.nodes.iter().map(rates).collect(),
            branches: Vec::new(),
            sums: Vec::new(),
        };
        let still = vec![[0.0; 3]; state.poses.len()];
        let loaded = mechanism.loaded(&Instant::of(&state, step, &still)).unwrap();
        let (mut sum, mut size) = ([0.0; 6], 1e-12);
        for (n, (body, node)) in mechanism.bodies.iter().zip(&frame.nodes).enumerate() {
            let [a, alpha] = [0, 3].map(|from| [0, 1, 2].map(|k| node.acceleration[from + k]));
            let turning = apply(&loaded.inertias[n], alpha);
            let force = |k: usize| loaded.applied[DOFS * n + k] + node.reaction[k];
            let left = [0, 1, 2].map(|k| force(k) - loaded.masses[n] * a[k]);
            let arm = add(body.position, node.displacement);
            let moment = cross(arm, left);
            for k in 0..3 {
                sum[k] += left[k];
                sum[3 + k] += moment[k] + force(3 + k) - turning[k];
                let parts = [force(k), loaded.masses[n] * a[k], moment[k], force(3 + k), turning[k]];
                size = parts.iter().fold(size, |most: f64, x| most.max(x.abs()));
            }
        }
        for x in sum {
            assert!(x.abs() <= 1e-12 * size, "{name} at {}: {sum:?} of {size:e}", frame.time);
        }
        seen.momenta += 1;
    }
}

/// Where states are asked for shifts the steps, and so what Newton's method meets as a force passes zero. It changes no event.
#[test]
fn times_that_are_asked_for_change_no_event() {
    let drawn = (1..=12).map(|i| vec![0.026 * f64::from(i), 0.065 * f64::from(i), 0.7, 1.3]);
    let all: Vec<Vec<f64>> = drawn.chain([vec![0.1], vec![0.1, 0.25, 0.7, 1.0, 1.3]]).collect();
    let (mut lists, mut events) = (0, 0);
    for (name, allowed, expected) in EXPECTED.into_iter().filter(|(name, ..)| name.starts_with("static_")) {
        let deck = reference(name);
        for times in &all {
            let options = Options { times: times.clone(), most_steps: FEW, ..Options::default() };
            let one: Solution<f64> = solved(deck, &options);
            let other: Solution<f64> = solved(deck, &Options { method: Method::Collocation, ..options });
            let apart = one.difference(&other);
            assert!(apart.largest() <= allowed, "{name} at {times:?}: {apart:?}");
            assert_eq!(one.events.len(), expected, "{name} at {times:?}");
            (lists, events) = (lists + 1, events + one.events.len());
        }
    }
    println!("{lists} lists of times, {events} events");
    assert!(lists >= 50 && events >= 100, "{lists} lists, {events} events");
}

/// Rotation vectors tell their turns, however often states are asked for.
#[test]
fn rotation_vectors_are_the_same_at_any_times() {
    let mut compared = 0;
    for (name, end) in [("top", 2.0), ("free_top", 1.0)] {
        let [few, many] = [20, 340].map(|count: u32| -> Solution<f64> {
            let times = (1..=count).map(|i| end * f64::from(i) / f64::from(count)).collect();
            solved(reference(name), &Options { times, until: Some(end), ..Options::default() })
        });
        for frame in &few.frames {
            let same = |other: &&crate::Frame<f64>| (other.time - frame.time).abs() < 1e-12;
            let Some(other) = many.frames.iter().find(same) else { continue };
            for (one, two) in frame.nodes.iter().zip(&other.nodes) {
                for (x, y) in one.rotation.iter().zip(two.rotation) {
                    assert!((x - y).abs() < 1e-8, "{name} at {}: {x}, not {y}", frame.time);
                    compared += 1;
                }
            }
        }
    }
    assert!(compared >= 120, "{compared}");
}

/// A damper whose table has a row at rest, beside a friction that a slow ramp breaks either way: the table goes on to the side of the slip. It
/// is the damper of that side, which is linear.
#[test]
fn a_table_with_a_row_at_rest_goes_the_way_of_the_slip() {
    let deck = |load: f64, damping: &str| {
        format!(
            "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n101, 1, 2\n\
             *CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nCARTESIAN\n\
             *CONNECTOR BEHAVIOR, NAME=B, EXTRAPOLATION=LINEAR\n*CONNECTOR ELASTICITY, COMPONENT=2\n150.\n\
             *CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=2\n*FRICTION\n0.2\n\
             *CONNECTOR DAMPING, COMPONENT=1{damping}\n*ELEMENT, TYPE=MASS, ELSET=M\n201, 2\n*MASS, ELSET=M\n0.75\n\
             *BOUNDARY\n1, 1, 1\n1, 3, 6\n2, 2, 6\n*AMPLITUDE, NAME=RAMP\n0., 0., 3., 1.\n*AMPLITUDE, NAME=ON\n0., 1., 3., 1.\n\
             *STEP\n*DYNAMIC\n0.01, 3.\n*CLOAD, AMPLITUDE=RAMP\n2, 1, {load}\n\
             *BOUNDARY, AMPLITUDE=ON\n1, 2, 2, 0.1\n*END STEP\n"
        )
    };
    let table = ", NONLINEAR\n-1.2, -2.\n0., 0.\n0.4, 2.";
    let mut compared = 0;
    for (load, slope) in [(-4.3, 0.6), (4.3, 0.2), (-5.171, 0.6), (6.07, 0.2)] {
        for method in [Method::Extrapolation, Method::Collocation] {
            let options = Options { method, ..Options::default() };
            let one: Solution<f64> = solved(&deck(load, table), &options);
            let other: Solution<f64> = solved(&deck(load, &format!("\n{slope}")), &options);
            let ends = [&one, &other].map(|of| of.frames.last().unwrap().connectors[0].displacement[0]);
            assert!((ends[0] - ends[1]).abs() < 1e-11 && ends[0] * load > 0.01, "{load}: {ends:?}");
            assert_eq!([one.events.len(), other.events.len()], [1, 1], "{load}");
            compared += 1;
        }
    }
    assert_eq!(compared, 8);
}

/// A slip of two components that has passed rest within a step is not missed, wherever its steps end.
#[test]
fn rest_is_met_wherever_steps_end() {
    let (mut runs, mut events) = (0, 0);
    for name in ["wander", "cylinder_wander"] {
        let known: Solution<f64> = solved(reference(name), &Options::default());
        for i in (1..40).step_by(3) {
            let times = [0.0231, 0.051, 0.087].map(|by| by * f64::from(i)).to_vec();
            for method in [Method::Extrapolation, Method::Collocation] {
                let options = Options { method, times: times.clone(), most_steps: 500, ..Options::default() };
                let found: Solution<f64> = solved(reference(name), &options);
                assert_eq!(found.events.len(), known.events.len(), "{name} {i} {method:?}");
                for (one, other) in found.events.iter().zip(&known.events) {
                    let apart: f64 = one.time - other.time;
                    assert!(apart.abs() < EVENT, "{name} {i} {method:?}: {apart:e}");
                    events += 1;
                }
                runs += 1;
            }
        }
    }
    assert!(runs == 52 && events == 312, "{runs} runs, {events} events");
}

#[test]
fn references_obey_their_laws() {
    let mut seen = Seen::default();
    for (name, allowed, expected) in EXPECTED {
        obeys(name, allowed, expected, &mut seen);
    }
    let Seen { frames, stuck, events, numbers, closed, criteria, momenta } = seen;
    println!(
        "{frames} frames, {stuck} stuck, {events} events, {numbers} numbers, {closed} closed forms, {criteria} criteria, {momenta} momenta"
    );
    assert!(frames > 500 && stuck > 100 && events > 150, "{frames} frames, {stuck} stuck, {events} events");
    assert!(momenta > 150, "{momenta}");
    assert!(
        numbers >= 240 && closed >= 45 && criteria > 500,
        "{numbers} numbers, {closed} problems in closed form"
    );
}

/// A decimal number, on 237 bits.
fn exact(text: &str) -> Wide {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, part) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let ten = Wide::from_f64(10.0);
    let mut value = Wide::from_f64(0.0);
    for digit in whole.trim_start_matches('-').bytes().chain(part.bytes()) {
        value = value * ten + Wide::from_f64(f64::from(digit - b'0'));
    }
    let shift = exponent.parse::<i32>().unwrap() - part.len() as i32;
    for _ in 0..shift.abs() {
        value = if shift < 0 { value / ten } else { value * ten };
    }
    if mantissa.starts_with('-') { Wide::from_f64(0.0) - value } else { value }
}

/// On 237 bits events and last states are those of the closed forms to 25 digits, on numbers that doubles hold exactly in the deck.
#[test]
fn closed_forms_are_met_on_237_bits() {
    let mut compared = 0;
    for name in ["collision", "stop_rigid", "static_lever"] {
        let path = format!("{}/../../references/{name}/closed.json", env!("CARGO_MANIFEST_DIR"));
        let stored: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        // 0.8 is no double: its digits are those of the deck's.
        let deck = reference(name).replace("-0.8,", "-0.75,");
        let solution: Solution<Wide> = solved(&deck, &Options { digits: 30, ..Options::default() });
        let mut meet = |found: Wide, wanted: Wide| {
            assert!((found - wanted).abs() < Wide::from_f64(1e-25), "{name}: {found:.30e} {wanted:.30e}");
            compared += 1;
        };
        if name == "static_lever" {
            // 10 t cos 0.75 = 7.5.
            let angle = Wide::from_f64(0.75);
            meet(solution.events[0].time * angle.sine_cosine().1, angle);
            continue;
        }
        for (event, stored) in solution.events.iter().zip(stored["events"].as_array().unwrap()) {
            meet(event.time, exact(stored[0].as_str().unwrap()));
        }
        let last = solution.frames.last().unwrap();
        let of = &stored["last"]["connectors"]["101"]["1"];
        meet(last.connectors[0].displacement[0], exact(of["CU"].as_str().unwrap()));
        meet(last.connectors[0].velocity[0], exact(of["CV"].as_str().unwrap()));
    }
    assert_eq!(compared, 10);
}

/// A spring first presses the block down and then lifts it. Where the force on its rail passes zero, friction goes on along its other branch:
/// on 237 bits, too, where a state has fewer digits than its numbers.
#[test]
fn a_force_passes_zero_on_237_bits() {
    let deck = BLOCK
        .replace("3, 1., 0., 0.", "3, 0.5, 0.8, 0.")
        .replace("3, 2, 6", "3, 1, 6")
        .replace("*BOUNDARY, AMPLITUDE=PULL\n3, 1, 1, 5.\n", "")
        .replace("M, GRAV, 10.", "M, GRAV, 1.")
        .replace("*STEP\n", "*INITIAL CONDITIONS, TYPE=VELOCITY\n2, 1, 3.\n*STEP\n");
    let options = Options { digits: 17, until: Some(0.75), ..Options::default() };
    let one: Solution<Wide> = solved(&deck, &options);
    let other: Solution<Wide> = solved(&deck, &Options { method: Method::Collocation, ..options });
    let force = |frame: usize| one.frames[frame].connectors[0].total[1].to_f64();
    assert!(force(0) * force(one.frames.len() - 1) < 0.0, "{} {}", force(0), force(one.frames.len() - 1));
    let apart = one.difference(&other);
    println!("{apart:?}");
    assert!(apart.compared > 20 && apart.largest() < 1e-15, "{apart:?}");
}

/// A motion in two steps is that in one: what a stop and friction hold goes on.
#[test]
fn steps_go_on() {
    let whole: Solution<f64> = solved(reference("stop_friction"), &Options::default());
    let deck = reference("stop_friction")
        .replace("NAME=FALLS", "NAME=FALLS, TIME=TOTAL TIME")
        .replace("0.01, 4.", "0.01, 1.")
        .replace("*END STEP", "*END STEP\n*STEP\n*DYNAMIC\n0.01, 3.\n*END STEP");
    let parts: Solution<f64> = solved(&deck, &Options::default());
    let [one, two] = [&whole, &parts].map(|of| of.frames.last().unwrap());
    assert_eq!(two.time, 4.0);
    let [x, y] = [one, two].map(|of| of.connectors[0].displacement[0]);
    assert!((x - y).abs() < 1e-13, "{x} {y}");
    let told = |of: &Solution<f64>| of.events.iter().map(|event| event.what).collect::<Vec<_>>();
    assert_eq!(told(&whole), told(&parts));
}

/// Springs of stick go on from step to step: two of half the time are one.
#[test]
fn springs_of_stick_go_on() {
    let friction = "*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=200.\n0.5, 0.2\n*FRICTION\n0.25\n";
    let options = Options { stick: Stick::Elastic, ..Options::default() };
    let whole: Solution<f64> = solved(&rubbed(friction, "", "4.", "1."), &options);
    let deck = rubbed(friction, "", "4.", "0.5")
        .replace("*END STEP", "*END STEP\n*STEP\n*DYNAMIC\n0.01, 0.5\n*END STEP");
    let parts: Solution<f64> = solved(&deck, &options);
    let [one, two] = [&whole, &parts].map(|of| of.frames.last().unwrap().nodes[1].displacement[0]);
    assert!((one - two).abs() < 1e-13, "{one} {two}");
}

/// A later state does not tell what a run has come to: how springs of stick are stretched, what has failed.
#[test]
fn what_a_state_does_not_tell_is_refused() {
    let refused = |deck: &str, time: f64, stick: Stick| {
        let scene = Scene::parse("deck.inp", deck).unwrap();
        let from = pintle_scene::State { time: Some(time), ..pintle_scene::State::default() };
        solve::<f64>(&scene, &Options { from: Some(from), stick, ..Options::default() })
            .err()
            .map(|ended| ended.why.to_string())
    };
    let plain = rubbed(
        "*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=200.\n0.5, 0.2\n*FRICTION\n0.25\n",
        "",
        "4.",
        "1.",
    );
    let fails = plain.replace(
        "*CONNECTOR FRICTION",
        "*CONNECTOR FAILURE, COMPONENT=1, RELEASE=1\n, 9.\n*CONNECTOR FRICTION",
    );
    let locks = fails.replace("FAILURE, COMPONENT=1, RELEASE=1", "LOCK, COMPONENT=1, LOCK=1");
    for (deck, stick, why) in [
        (&plain, Stick::Elastic, "how far the spring of its stick is stretched"),
        (&fails, Stick::Rigid, "whether it has failed"),
        (&locks, Stick::Rigid, "where it has locked"),
        (&reference("belt_swing").to_string(), Stick::Rigid, "how far its belt has run"),
    ] {
        let told = refused(deck, 0.5, stick).unwrap();
        assert!(told.contains(why), "{told}");
    }
    assert_eq!(refused(&plain, 0.5, Stick::Rigid), None);
    assert_eq!(refused(&plain, 0.0, Stick::Elastic), None);
    assert_eq!(refused(&fails, 0.0, Stick::Rigid), None);
}

/// Each fault of the solver is noticed by one of these references.
#[test]
fn faults_are_noticed() {
    let faults: [(Fault, &[&str]); 25] = [
        (Fault::SlipReversed, &["stop_friction"]),
        (Fault::OnsetByDefault, &["stop_friction"]),
        (Fault::Drift, &["pendulum_turns"]),
        (Fault::EventInterpolated, &["friction_decay"]),
        (Fault::CouplingLeftOut, &["drawer", "cross_friction"]),
        (Fault::KinkPassed, &["slider_crank"]),
        (Fault::RowPassed, &["stop_elastic"]),
        (Fault::ImpactForgotten, &["collision"]),
        (Fault::StopPulls, &["stop_rigid"]),
        (Fault::TurnLost, &["spin_down"]),
        (Fault::TurnsApart, &["clutch"]),
        (Fault::KinksApart, &["cross_swing"]),
        (Fault::LockSlips, &["lock"]),
        (Fault::SticksAlways, &["block"]),
        (Fault::ReversesAlways, &["block"]),
        (Fault::OnsetLate, &["block"]),
        (Fault::BiasLeftOut, &["pendulum"]),
        (Fault::GyroscopicLeftOut, &["free_top"]),
        (Fault::CornersPassed, &["spin_down"]),
        (Fault::FailureForgotten, &["failure"]),
        (Fault::FrictionForgotten, &["block"]),
        (Fault::DriveForgotten, &["block"]),
        (Fault::RotationAdded, &["free_top"]),
        (Fault::TurnRateTaken, &["free_top"]),
        (Fault::CapstanTurned, &["belt_swing"]),
    ];
    let mut missed = Vec::new();
    for (fault, names) in faults {
        let noticed = names.iter().any(|name| {
            let (name, allowed, expected) = *EXPECTED.iter().find(|(known, ..)| known == name).unwrap();
            let faulty = std::thread::spawn(move || {
                crate::fault::NOW.set(Some(fault));
                obeys(name, allowed, expected, &mut Seen::default());
            });
            faulty.join().is_err()
        });
        if !noticed {
            missed.push(fault);
        }
    }
    assert!(missed.is_empty(), "not noticed: {missed:?}");
}

/// The flywheel: ω = (2 − 0.17) 0.5 / 0.05 after the push, 3.4 rad/s² of friction: M = μ (R_a 30 + R_p 40).
#[test]
fn a_flywheel_comes_to_rest_by_hand() {
    let solution: Solution<f64> = solved(reference("spin_down"), &Options::default());
    // The push ends on a ramp of 1e-7 s.
    let by_hand = 0.5 + (2.0 - 0.17) * 0.5 / 0.05 / 3.4;
    assert_eq!(solution.events[0].what, What::Sticks);
    assert!((solution.events[0].time - by_hand).abs() < 2e-6, "{} {by_hand}", solution.events[0].time);
}

/// Stick by a spring of 2000: 2 ẍ = 100 (t − x) − 2000 x until that carries 5. With a stiffer spring it comes to the rigid law, and where the
/// limit depends on the reaction both methods agree, too.
#[test]
fn elastic_stick_is_a_spring() {
    let elastic = Options { stick: Stick::Elastic, ..Options::default() };
    let with = |stiffness: f64| {
        let given = format!("PREDEFINED, STICK STIFFNESS={stiffness}");
        reference("block").replace("PREDEFINED", &given)
    };
    let soft: Solution<f64> = solved(&with(2000.0), &elastic);
    let w = 1050.0_f64.sqrt();
    let mut t: f64 = 0.05;
    for _ in 0..50 {
        t -= (t - (w * t).sin() / w - 0.0525) / (1.0 - (w * t).cos());
    }
    assert_eq!(soft.events[0].what, What::Slips);
    assert!((soft.events[0].time - t).abs() < 1e-14, "{} {t}", soft.events[0].time);
    let rigid: Solution<f64> = solved(reference("block"), &Options::default());
    let [near, far] = [1e6, 1e4].map(|stiffness| {
        let solution: Solution<f64> = solved(&with(stiffness), &elastic);
        let place = |of: &Solution<f64>| of.frames.last().unwrap().connectors[0].displacement[0];
        (place(&solution) - place(&rigid)).abs()
    });
    assert!(near < 2e-5 && near > 1e-8 && far > 10.0 * near, "{near:e} {far:e}");
    let deck = reference("drawer").replace("PREDEFINED", "PREDEFINED, STICK STIFFNESS=20000.");
    let one: Solution<f64> = solved(&deck, &elastic);
    let other: Solution<f64> = solved(&deck, &Options { method: Method::Collocation, ..elastic });
    let apart = one.difference(&other);
    assert!(apart.compared > 50 && apart.largest() < 1e-10, "{apart:?}");
    for frame in soft.frames.iter().chain(&one.frames) {
        assert!(frame.energies.balance.abs() < 1e-12, "{:?}", frame.energies);
    }
}

/// Andrews' squeezing mechanism, seven bodies in a plane: its seven angles with their turns, and their rates, are the published ones.
#[test]
fn the_squeezing_mechanism_is_the_published_one() {
    let path = format!("{}/../../references/andrews/published.json", env!("CARGO_MANIFEST_DIR"));
    let stored: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let solution: Solution<f64> = solved(reference("andrews"), &Options::default());
    let last = solution.frames.last().unwrap();
    let number = |value: &serde_json::Value| value.as_str().unwrap().parse::<f64>().unwrap();
    // What moves freely is an output, too: the crank in its hinge, with its turns.
    let crank = &last.connectors[0];
    let turned = number(&stored["end"]["beta"][0]) - number(&stored["begin"]["beta"]);
    assert!(
        crank.free[3] && (crank.displacement[3] / turned - 1.0).abs() < 1e-10,
        "{:?}",
        crank.displacement
    );
    let mut compared = 0;
    for (label, angles) in stored["nodes"].as_object().unwrap() {
        let node = solution.nodes.iter().position(|known| known.to_string() == *label).unwrap();
        let (mut turned, mut spin) = (0.0, 0.0);
        for angle in angles.as_array().unwrap() {
            let angle = angle.as_str().unwrap();
            turned += number(&stored["end"][angle][0]) - number(&stored["begin"][angle]);
            spin += number(&stored["end"][angle][1]);
        }
        let node = &last.nodes[node];
        // Their own error: what two formulations and both methods agree on is 1.1e-9 away from their β, 1.1e-7 from its rate.
        let [angle, rate] = [(node.rotation[2] - turned) / 15.8, (node.velocity[5] - spin) / 1424.0];
        assert!(angle.abs() < 1e-10 && rate.abs() < 1e-9, "{label}: {angle:e} {rate:e}");
        compared += 2;
    }
    assert_eq!(compared, 14);
}

/// The governor by three coordinates, in 1e5 steps: angle b of the rods below the horizontal, way s of the slider, turn of the shaft. What is
/// stiff decays 8,000 times a second, and few steps suffice.
#[test]
fn a_stiff_governor_goes_in_few_steps() {
    const G: f64 = 9.81;
    let com = (0.3 * 0.5 + 5.0) / 5.3;
    let across = 0.3 / 12.0 + 0.3 * (com - 0.5_f64).powi(2) + 5.0 * (1.0 - com).powi(2);
    let (along, about) = (0.3 * 2e-4 / 12.0, 5.3 * com * com + across);
    let inertia = |b: f64| 2.0 * about * b.cos().powi(2) + 2.0 * along * b.sin().powi(2) + 5e-6 + 0.005;
    let spin = std::f64::consts::TAU;
    let momentum = inertia(std::f64::consts::FRAC_PI_6) * spin;
    let rates = |[_, b, s, to_b, to_s]: [f64; 5]| {
        let spin = momentum / inertia(b);
        let length = (0.25 + s * s - s * b.sin()).sqrt();
        let [by_b, by_s] = [-s * b.cos() / (2.0 * length), (2.0 * s - b.sin()) / (2.0 * length)];
        let force = 8e5 * (length - 0.5) + 4e4 * (by_b * to_b + by_s * to_s);
        let thrown = -(about - along) * (2.0 * b).sin() * spin * spin;
        let of_b = (thrown + 2.0 * 5.3 * com * G * b.cos() - 2.0 * force * by_b) / (2.0 * about);
        [spin, to_b, to_s, of_b, G - 2.0 * force * by_s / 3.0]
    };
    let h = 1e-5;
    let mut y = [0.0, std::f64::consts::FRAC_PI_6, 0.5, 0.0, 0.0];
    for _ in 0..100_000 {
        let moved = |by: f64, along: [f64; 5]| std::array::from_fn(|i| y[i] + by * along[i]);
        let one = rates(y);
        let two = rates(moved(h / 2.0, one));
        let three = rates(moved(h / 2.0, two));
        let four = rates(moved(h, three));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (one[i] + 2.0 * (two[i] + three[i]) + four[i]));
    }
    for method in [Method::Extrapolation, Method::Collocation] {
        let solution: Solution<f64> = solved(reference("flyball"), &Options { method, ..Options::default() });
        assert!(solution.steps < 200, "{method:?}: {} steps", solution.steps);
        let last = solution.frames.last().unwrap();
        let node = |label: &str| {
            &last.nodes[solution.nodes.iter().position(|known| known.to_string() == label).unwrap()]
        };
        let [shaft, slider] = [node("1"), node("4")];
        let found = [shaft.rotation[2], 0.5 - slider.displacement[2], shaft.velocity[5], -slider.velocity[2]];
        let wanted = [y[0], y[2], momentum / inertia(y[1]), y[4]];
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 2e-11, "{method:?}: {found} {wanted}");
        }
    }
}

/// A rate that is prescribed jumps from 1 to 3: its impulse gives ½ 2 (9 − 1), and the spring of the second mass goes on as it was.
#[test]
fn a_jump_of_a_prescribed_rate_works() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n9, , 1\n10, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\n\
                CARTESIAN\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR STOP, COMPONENT=1\n, 100.\n*ELEMENT, TYPE=MASS, ELSET=M\n8, 1\n7, 2\n*MASS, ELSET=M\n2.\n\
                *ELEMENT, TYPE=SPRINGA, ELSET=S\n6, 1, 2\n*SPRING, ELSET=S\n\n8.\n*BOUNDARY\n1, 2, 6\n2, 2, 6\n\
                *STEP\n*DYNAMIC\n0.1, 1.\n*BOUNDARY, TYPE=VELOCITY\n1, 1, 1, 1.\n*END STEP\n\
                *STEP\n*DYNAMIC\n0.1, 1.\n*BOUNDARY, TYPE=VELOCITY, OP=NEW\n1, 1, 1, 3.\n*END STEP\n*STEP\n*DYNAMIC\n0.1, 1.\n*END STEP\n";
    for method in [Method::Extrapolation, Method::Collocation] {
        let options = Options { method, times: vec![0.5, 1.5, 2.5], ..Options::default() };
        let solution: Solution<f64> = solved(deck, &options);
        let speed = |i: usize| solution.frames[i].nodes[0].velocity[0];
        assert_eq!([speed(1), speed(3)], [1.0, 3.0]);
        for frame in &solution.frames {
            assert!(frame.energies.balance.abs() < 1e-12, "{:?}", frame.energies);
        }
        assert!(solution.frames[3].energies.external > 8.0);
    }
}

#[test]
fn what_is_not_determined_is_refused_by_name() {
    let refused = |deck: &str| {
        let scene = Scene::parse("deck.inp", deck).unwrap();
        solve::<f64>(&scene, &Options::default()).unwrap_err().why.to_string()
    };
    let without_mass = PENDULUM.replace("*MASS, ELSET=BOB\n2.\n", "*MASS, ELSET=BOB\n0.\n");
    let why = refused(&without_mass);
    assert!(why.contains("node") || why.contains("HINGE") || why.contains("BEAM"), "{why}");
    let free = "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n9, , 1\n*CONNECTOR SECTION, ELSET=C\nCARTESIAN\n\
                *STEP\n*STATIC\n0.1, 1.\n*CLOAD\n1, 1, 4.\n*END STEP\n";
    assert!(refused(free).contains("no equilibrium"), "{}", refused(free));
    let clash = PENDULUM.replace("*STEP\n", "*INITIAL CONDITIONS, TYPE=VELOCITY\n1, 1, 2.\n*STEP\n");
    assert!(refused(&clash).contains("do not fit"), "{}", refused(&clash));
    let beyond =
        BLOCK.replace("*FRICTION\n0.25\n", "*FRICTION\n0.25\n*CONNECTOR STOP, COMPONENT=1\n0.1, 1.\n");
    assert!(refused(&beyond).contains("beyond its stop"), "{}", refused(&beyond));
    let cubes =
        reference("ellipse_slide").replace("*CONNECTOR POTENTIAL", "*CONNECTOR POTENTIAL, EXPONENT=3.");
    assert!(refused(&cubes).contains("no root of squares"), "{}", refused(&cubes));
    let wet = reference("belt_swing").replace("1000.\n", "1000.\n*CONNECTOR DAMPING, COMPONENT=1\n2.\n");
    assert!(refused(&wet).contains("a belt with damping"), "{}", refused(&wet));
}

/// A puck that slides, sticks and slips, in metres and kilograms, and in millionths of both and less: the numbers of rows and of inertia are then
/// 1e15 apart. What has no unit is the same.
#[test]
fn small_units_change_nothing() {
    let with = |length: f64, mass: f64| {
        let [x, y, z, dx, dy, dz, radius, g, vx, vy] =
            [0.2, 0.1, 0.05, 0.24, 0.12, 0.08, 0.15, 10.0, 0.88, 0.74].map(|number| number * length);
        let [fx, fy] = [2.2, 0.6].map(|number| number * mass * length);
        let (inertia, moment, mass) =
            (0.01 * mass * length * length, 0.35 * mass * length * length, 1.3 * mass);
        let deck = format!(
            "*NODE\n1, {x:e}, {y:e}, {z:e}\n2, {x:e}, {y:e}, {z:e}\n3, {dx:e}, {dy:e}, {dz:e}\n*ELEMENT, TYPE=CONN3D2, ELSET=T\n101, 1, 2\n\
             *ORIENTATION, NAME=UP\n0., 0., 1., 1., 0., 0.\n*CONNECTOR SECTION, ELSET=T, BEHAVIOR=DRY\nPLANAR,\nUP,\n\
             *CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR FRICTION, PREDEFINED\n{radius:e}\n*FRICTION\n0.2\n*MPC\nBEAM, 2, 3\n\
             *ELEMENT, TYPE=MASS, ELSET=M\n201, 3\n*MASS, ELSET=M\n{mass:e}\n*ELEMENT, TYPE=ROTARYI, ELSET=I\n202, 3\n\
             *ROTARY INERTIA, ELSET=I\n{inertia:e}, {inertia:e}, {inertia:e}\n*BOUNDARY\n1, 1, 6\n\
             *INITIAL CONDITIONS, TYPE=VELOCITY\n3, 1, {vx:e}\n3, 2, {vy:e}\n3, 6, 6.\n\
             *AMPLITUDE, NAME=A, DEFINITION=PERIODIC\n2, 6., 0., 0.\n1., 0., 0., 0.8\n*STEP\n*DYNAMIC\n0.01, 0.8\n\
             *CLOAD, AMPLITUDE=A\n3, 1, {fx:e}\n3, 2, {fy:e}\n3, 6, {moment:e}\n*DLOAD\nM, GRAV, {g:e}, 0., 0., -1.\n*END STEP\n"
        );
        solved::<f64>(&deck, &Options::default())
    };
    let (usual, small) = (with(1.0, 1.0), with(1e-6, 1e-12));
    let times = |of: &Solution<f64>| of.events.iter().map(|event| event.time).collect::<Vec<f64>>();
    assert!(usual.events.len() >= 2, "{:?}", times(&usual));
    assert_eq!(usual.events.len(), small.events.len());
    for (one, other) in times(&usual).iter().zip(times(&small)) {
        assert!((one - other).abs() < 1e-6, "{one} {other}");
    }
    let [one, other] = [&usual, &small].map(|of| of.frames.last().unwrap().connectors[0].displacement);
    assert!((one[3] - other[3]).abs() < 1e-7, "{one:?} {other:?}");
    for k in 1..3 {
        assert!((one[k] - other[k] * 1e6).abs() < 1e-7, "{one:?} {other:?}");
    }
}

/// Nodes that coincide have no size: how far they go is it. A millionth of a load moves them a millionth as far, with as many digits.
#[test]
fn what_has_no_length_is_sized_by_its_motion() {
    let times = vec![0.3, 1.1, 2.6, 4.0];
    let [usual, small, tiny] = ["10.", "1e-5", "1e-14"].map(|load| {
        let deck = reference("oscillator").replace("2, 1, 10.", &format!("2, 1, {load}"));
        let options = Options { times: times.clone(), ..Options::default() };
        let [one, other] = [Method::Extrapolation, Method::Collocation]
            .map(|method| solved::<f64>(&deck, &Options { method, ..options.clone() }));
        assert!(one.difference(&other).largest() < 1e-13, "{:?}", one.difference(&other));
        one
    });
    let mut compared = 0;
    for (scaled, by) in [(&small, 1e6), (&tiny, 1e15)] {
        assert!((scaled.length * by / usual.length - 1.0).abs() < 1e-3, "{} {}", scaled.length, usual.length);
        for (one, other) in usual.frames.iter().zip(&scaled.frames) {
            let [(x, v), (y, w)] =
                [one, other].map(|frame| (frame.nodes[1].displacement[0], frame.nodes[1].velocity[0]));
            assert!((x - y * by).abs() < 1e-13 && (v - w * by).abs() < 1e-12, "{x} {y:e}, {v} {w:e}");
            compared += 1;
        }
    }
    assert_eq!(compared, 12);
}

/// A collar on a shaft that a smooth step turns, from rest and to rest, so that both ends graze. Friction holds its load until then. It creeps along
/// as the direction of slip has it: 0.411547618 by SciPy's Radau method, apart.
#[test]
fn a_drive_that_grazes_lets_creep() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=SHAFT\n101, 1, 2\n*ORIENTATION, NAME=AX\n1., 0., 0., 0., 1., 0.\n\
        *CONNECTOR SECTION, ELSET=SHAFT, BEHAVIOR=DRY\nCYLINDRICAL,\nAX,\n*CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR FRICTION, PREDEFINED\n0.05\n\
        *FRICTION\n0.2\n*ELEMENT, TYPE=MASS, ELSET=M\n201, 2\n*MASS, ELSET=M\n1.5\n*ELEMENT, TYPE=ROTARYI, ELSET=I\n202, 2\n\
        *ROTARY INERTIA, ELSET=I\n0.004, 0.02, 0.02\n*BOUNDARY\n1, 1, 6\n*AMPLITUDE, NAME=A, DEFINITION=SMOOTH STEP\n0., 0., 1., 0., 3., 30.\n\
        *STEP\n*DYNAMIC\n0.01, 3.\n*CONNECTOR MOTION, AMPLITUDE=A\nSHAFT, 4, 1.\n*CLOAD\n2, 1, 1.\n*DLOAD\nM, GRAV, 10., 0., 0., -1.\n*END STEP\n";
    let solution: Solution<f64> = solved(deck, &Options::default());
    assert_eq!(
        solution.events.iter().map(|event| event.what).collect::<Vec<_>>(),
        [What::Slips, What::Sticks]
    );
    let crept = solution.frames.last().unwrap().connectors[0].displacement[0];
    assert!((crept - 0.411_547_618).abs() < 2e-8, "{crept}");
    // 99 of them, 2,760 where differences take rates to be as large as they once were.
    assert!(solution.steps < 300, "{}", solution.steps);
}

/// The same collar, turned ever faster from rest by a small rate. Its direction is where friction and acceleration agree: 1.5 a = 0.5 − 3 a/√(a² +
/// (R α)²). Each turns the other by more than it was turned.
#[test]
fn a_slow_drive_finds_its_direction() {
    for (alpha, creeps) in [(20.0_f64, 0.111_569_766_772_991_5_f64), (5.0, 0.037_403_002_201_549_2)] {
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=SHAFT\n101, 1, 2\n*ORIENTATION, NAME=AX\n1., 0., 0., 0., 1., 0.\n\
             *CONNECTOR SECTION, ELSET=SHAFT, BEHAVIOR=DRY\nCYLINDRICAL,\nAX,\n*CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR FRICTION, PREDEFINED\n0.05\n\
             *FRICTION\n0.2\n*ELEMENT, TYPE=MASS, ELSET=M\n201, 2\n*MASS, ELSET=M\n1.5\n*ELEMENT, TYPE=ROTARYI, ELSET=I\n202, 2\n\
             *ROTARY INERTIA, ELSET=I\n0.004, 0.02, 0.02\n*BOUNDARY\n1, 1, 6\n*AMPLITUDE, NAME=A, SMOOTH=0.\n0., 0., 1., 1.\n\
             *STEP\n*DYNAMIC\n0.01, 1.\n*CONNECTOR MOTION, AMPLITUDE=A, TYPE=VELOCITY\nSHAFT, 4, {alpha}\n*CLOAD\n2, 1, 0.5\n\
             *DLOAD\nM, GRAV, 10., 0., 0., -1.\n*END STEP\n"
        );
        let solution: Solution<f64> = solved(&deck, &Options::default());
        let left = 1.5 * creeps - 0.5 + 3.0 * creeps / creeps.hypot(0.05 * alpha);
        assert!(left.abs() < 1e-12, "{left}");
        let first = solution.frames.first().unwrap();
        assert!((first.nodes[1].acceleration[0] - creeps).abs() < 1e-12, "{:?}", first.nodes[1].acceleration);
        let last = solution.frames.last().unwrap();
        assert!((last.connectors[0].displacement[0] - creeps / 2.0).abs() < 1e-12);
    }
}

/// A block on a rail with a spring k = 100 and friction 5, in statics: `steps` is what loads or moves it.
fn on_the_spring(steps: &str) -> String {
    format!(
        "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=RAIL\n101, 1, 2\n*ORIENTATION, NAME=ALONG\n1., 0., 0., 0., 1., 0.\n\
         *CONNECTOR SECTION, ELSET=RAIL, BEHAVIOR=DRY\nTRANSLATOR,\nALONG,\n*CONNECTOR BEHAVIOR, NAME=DRY\n\
         *CONNECTOR ELASTICITY, COMPONENT=1\n100.\n*CONNECTOR FRICTION, PREDEFINED\n.5, .2\n*FRICTION\n0.25\n*BOUNDARY\n1, 1, 6\n\
         *AMPLITUDE, NAME=ONE\n0., 1., 9., 1.\n*AMPLITUDE, NAME=P\n0., 0., 1., 1., 2., -1.\n\
         *AMPLITUDE, NAME=A, DEFINITION=PERIODIC\n1, 4., 0., 0.\n0., 1.\n*STEP\n*STATIC\n0.01, 2.\n*CLOAD, AMPLITUDE=ONE\n2, 2, -20.\n\
         {steps}*END STEP\n"
    )
}

/// A load 20 sin 4t in statics: slip from where it exceeds friction to where it turns, (2n + 1) π/8, and back from where it is less by twice the friction.
#[test]
fn a_static_slip_ends_where_its_load_turns() {
    let deck = on_the_spring("*CLOAD, AMPLITUDE=A\n2, 1, 20.\n");
    let turn = |n: f64| (2.0 * n + 1.0) * std::f64::consts::PI / 8.0;
    // sin 4t = 1/4; then 20 sin 4t = ±(20 − 10).
    let quarter = 0.25_f64.asin() / 4.0;
    let sixth = std::f64::consts::PI / 24.0;
    let wanted = [
        quarter,
        turn(0.0),
        std::f64::consts::PI / 4.0 - sixth,
        turn(1.0),
        std::f64::consts::PI / 2.0 - sixth,
        turn(2.0),
    ];
    for method in [Method::Extrapolation, Method::Collocation] {
        let solution: Solution<f64> = solved(&deck, &Options { method, ..Options::default() });
        assert_eq!(solution.events.len(), wanted.len(), "{method:?}");
        for (event, want) in solution.events.iter().zip(wanted) {
            assert!((event.time - want).abs() < 1e-12, "{method:?}: {} {want}", event.time);
        }
        let last = solution.frames.last().unwrap().connectors[0].displacement[0];
        assert!((last - 0.15).abs() < 1e-14, "{method:?}: {last}");
    }
}

/// What is moved in statics rubs: friction against the motion, its work beside that of the spring, whatever prescribes it.
#[test]
fn what_is_moved_in_statics_rubs() {
    for moved in ["*BOUNDARY, AMPLITUDE=P\n2, 1, 1, 0.3\n", "*CONNECTOR MOTION, AMPLITUDE=P\nRAIL, 1, 0.3\n"]
    {
        let options = Options { times: vec![0.5, 1.5], ..Options::default() };
        let solution: Solution<f64> = solved(&on_the_spring(moved), &options);
        let events: Vec<(f64, What)> = solution.events.iter().map(|event| (event.time, event.what)).collect();
        assert_eq!(events, [(0.0, What::Slips), (1.0, What::Reverses)], "{moved}");
        for (time, friction, dissipated) in [(0.5, 5.0, 0.75), (1.5, -5.0, 3.0), (2.0, -5.0, 4.5)] {
            let frame = solution.frames.iter().find(|frame| frame.time == time).unwrap();
            let rail = &frame.connectors[0];
            assert!((rail.friction[0] - friction).abs() < 1e-12, "{moved}: {:?}", rail.friction);
            assert!((frame.energies.dissipated - dissipated).abs() < 1e-12, "{moved}: {:?}", frame.energies);
            assert!(frame.energies.balance.abs() < 1e-12, "{moved}: {:?}", frame.energies);
        }
    }
}

/// A block on a plane with springs, pulled by a force whose direction turns.
///
/// The end of the springs goes round a corner. The block follows it at the distance ℓ = μ N/k: a tractrix, u2 = 0.2 − ℓ sech(s/ℓ), u3 = s −
/// ℓ tanh(s/ℓ). The force then goes back, and it sticks.
#[test]
fn a_static_slip_follows_a_tractrix() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n101, 1, 2\n*ORIENTATION, NAME=O\n0., 0., 1., 1., 0., 0.\n\
        *CONNECTOR SECTION, ELSET=C, BEHAVIOR=DRY\nSLIDE-PLANE,\nO,\n*CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR ELASTICITY, COMPONENT=2\n100.\n\
        *CONNECTOR ELASTICITY, COMPONENT=3\n100.\n*CONNECTOR FRICTION, PREDEFINED\n\n*FRICTION\n0.2\n*BOUNDARY\n1, 1, 6\n2, 4, 6\n\
        *AMPLITUDE, NAME=A\n0., 0., 1., 1., 9., 1.\n*AMPLITUDE, NAME=B\n0., 0., 1., 0., 2., 1., 3., 0.9\n*AMPLITUDE, NAME=ONE\n0., 1., 9., 1.\n\
        *STEP\n*STATIC\n0.01, 3.\n*CLOAD, AMPLITUDE=A\n2, 1, 20.\n*CLOAD, AMPLITUDE=B\n2, 2, 20.\n*CLOAD, AMPLITUDE=ONE\n2, 3, -30.\n*END STEP\n";
    let times = [1.1, 1.3, 1.65, 2.0, 2.5].map(|time: f64| time).to_vec();
    for method in [Method::Extrapolation, Method::Collocation] {
        let solution: Solution<f64> =
            solved(deck, &Options { times: times.clone(), method, ..Options::default() });
        for time in &times {
            let frame = solution.frames.iter().rfind(|frame| frame.time == *time).unwrap();
            let (s, l) = (0.2 * (time.min(2.0) - 1.0), 0.06);
            let wanted = [0.2 - l / (s / l).cosh(), s - l * (s / l).tanh()];
            let of = &frame.connectors[0];
            for (x, wanted) in of.displacement[1..3].iter().zip(wanted) {
                assert!((x - wanted).abs() < 1e-14, "{method:?} {time}: {x} for {wanted}");
            }
            // The work of 20 (A u2 + B u3) goes into springs and friction, which takes 6 for each length of the curve, ℓ ln cosh(s/ℓ).
            let slid = 0.14 + l * (s / l).cosh().ln();
            let [external, dissipated] = [frame.energies.external, frame.energies.dissipated];
            assert!((dissipated - 6.0 * slid).abs() < 1e-13, "{time}: {dissipated} for {}", 6.0 * slid);
            assert!(frame.energies.balance.abs() < 1e-13 * external, "{time}: {:?}", frame.energies);
        }
        let told: Vec<(What, f64)> = solution.events.iter().map(|event| (event.what, event.time)).collect();
        assert!(matches!(told[..], [(What::Slips, _), (What::Sticks, 2.0)]), "{told:?}");
    }
}

/// A limit that grows with the slip, 0.2 (10 + 10 s): where a spring and friction balance a force F, 100 u + 2 + 2 u = F.
#[test]
fn a_static_limit_over_the_slip_is_that_of_now() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n101, 1, 2\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
        *CONNECTOR SECTION, ELSET=C, BEHAVIOR=DRY\nCARTESIAN,\nO,\n*CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR ELASTICITY, COMPONENT=1\n100.\n\
        *CONNECTOR FRICTION, COMPONENT=1\n, 10., 0.\n, 20., 1.\n*FRICTION\n0.2\n*BOUNDARY\n1, 1, 6\n2, 2, 6\n*AMPLITUDE, NAME=A\n\
        0., 0., 1., 1.\n*STEP\n*STATIC\n0.01, 1.\n*CLOAD, AMPLITUDE=A\n2, 1, 10.\n*END STEP\n";
    let options = Options { times: vec![0.4, 0.7], ..Options::default() };
    let solution: Solution<f64> = solved(deck, &options);
    let slid = solution.frames.iter().filter(|frame| frame.time > 0.3);
    let mut compared = 0;
    for frame in slid {
        let wanted = (10.0 * frame.time - 2.0) / 102.0;
        let found = frame.connectors[0].displacement[0];
        assert!((found - wanted).abs() < 1e-14, "{}: {found} for {wanted}", frame.time);
        compared += 1;
    }
    assert_eq!(compared, 3);
}

/// A block that is led round a circle: its friction is along the tangent from the beginning, and does the work μ N r φ.
#[test]
fn what_is_led_along_a_circle_rubs_along_its_tangent() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n101, 1, 2\n*ORIENTATION, NAME=O\n0., 0., 1., 1., 0., 0.\n\
        *CONNECTOR SECTION, ELSET=C, BEHAVIOR=DRY\nSLIDE-PLANE,\nO,\n*CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR FRICTION, PREDEFINED\n\n*FRICTION\n0.2\n\
        *AMPLITUDE, NAME=COS, DEFINITION=PERIODIC\n1, 1., 0., -1.\n1., 0.\n*AMPLITUDE, NAME=SIN, DEFINITION=PERIODIC\n1, 1., 0., 0.\n0., 1.\n\
        *AMPLITUDE, NAME=ONE\n0., 1., 9., 1.\n*STEP\n*STATIC\n0.01, 6.\n*BOUNDARY\n1, 1, 6\n2, 4, 6\n*BOUNDARY, AMPLITUDE=COS\n2, 1, 1, 1.\n\
        *BOUNDARY, AMPLITUDE=SIN\n2, 2, 2, 1.\n*CLOAD, AMPLITUDE=ONE\n2, 3, -30.\n*END STEP\n";
    let solution: Solution<f64> = solved(deck, &Options { times: vec![1.0, 2.5, 6.0], ..Options::default() });
    assert!(solution.frames.len() >= 4, "{}", solution.frames.len());
    for frame in &solution.frames {
        let t: f64 = frame.time;
        let of = &frame.connectors[0];
        if of.friction == [0.0; 6] {
            assert_eq!(t, 0.0, "nothing rubs before it moves");
            continue;
        }
        let [f2, f3] = [of.friction[1], of.friction[2]];
        let wanted = [-6.0 * t.sin(), 6.0 * t.cos()];
        assert!(
            (f2 - wanted[0]).abs() < 1e-12 && (f3 - wanted[1]).abs() < 1e-12,
            "{t}: {f2}, {f3} for {wanted:?}"
        );
        assert!((frame.energies.dissipated - 6.0 * t).abs() < 1e-12, "{t}: {:?}", frame.energies);
    }
}

/// Initial velocities are along global axes, whatever axes *TRANSFORM gives a node; loads follow the latter.
#[test]
fn initial_velocities_are_global() {
    let deck = "*NODE, NSET=N\n1, 0., 0., 0.\n*TRANSFORM, NSET=N\n0., 1., 0., -1., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=M\n21, 1\n*MASS, ELSET=M\n2.\n\
        *INITIAL CONDITIONS, TYPE=VELOCITY\n1, 1, 3.\n*STEP\n*DYNAMIC\n0.01, 1.\n*CLOAD\n1, 1, 8.\n*END STEP\n";
    let solution: Solution<f64> = solved(deck, &Options::default());
    let moved = solution.frames.last().unwrap().nodes[0].displacement;
    for (x, wanted) in moved.iter().zip([3.0, 2.0, 0.0]) {
        assert!((x - wanted).abs() < 1e-13, "{moved:?}");
    }
}

/// A mass that sets out from its stop against gravity comes back after 2 v/g, however slow it is.
#[test]
fn a_stop_just_left_closes_when_it_is_met() {
    for (v, g) in [("1e-2", 10.0), ("1e-4", 10.0), ("1e-6", 10.0), ("1e-9", 10.0), ("1e-11", 1e-10)] {
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=L\n12, , 1\n*CONNECTOR SECTION, ELSET=L, BEHAVIOR=B\nCARTESIAN\n\
             *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR STOP, COMPONENT=2\n0.,\n*ELEMENT, TYPE=MASS, ELSET=M\n21, 1\n*MASS, ELSET=M\n1.\n\
             *BOUNDARY\n1, 1, 1\n1, 3, 3\n*INITIAL CONDITIONS, TYPE=VELOCITY\n1, 2, {v}\n*STEP\n*DYNAMIC\n0.01, 1.\n*DLOAD\n\
             M, GRAV, {g}, 0., -1., 0.\n*END STEP\n"
        );
        let solution: Solution<f64> = solved(&deck, &Options::default());
        let wanted = 2.0 * v.parse::<f64>().unwrap() / g;
        let told: Vec<(What, f64)> = solution.events.iter().map(|event| (event.what, event.time)).collect();
        let [(What::Closes, time)] = told[..] else { panic!("{v}: {told:?}") };
        assert!((time - wanted).abs() < 1e-11 * wanted, "{v}: {time:e} for {wanted:e}");
    }
}

/// A bar on two stops rocks from one end to the other, each time with a third of the rate (Housner: (I − m l²)/(I + m l²)): it rests after 0.09.
#[test]
fn impacts_that_accumulate_end() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, -1., 0., 0.\n3, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=L\n12, , 2\n13, , 3\n\
        *CONNECTOR SECTION, ELSET=L, BEHAVIOR=B\nCARTESIAN\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR STOP, COMPONENT=2\n0.,\n*MPC\n\
        BEAM, 2, 1\nBEAM, 3, 1\n*ELEMENT, TYPE=MASS, ELSET=M\n21, 1\n*MASS, ELSET=M\n1.\n*ELEMENT, TYPE=ROTARYI, ELSET=I\n22, 1\n\
        *ROTARY INERTIA, ELSET=I\n2., 2., 2.\n*BOUNDARY\n1, 1, 1\n1, 3, 5\n*INITIAL CONDITIONS, TYPE=VELOCITY\n1, 2, 0.1\n1, 6, 0.1\n\
        *STEP\n*DYNAMIC\n0.01, 1.\n*DLOAD\nM, GRAV, 10., 0., -1., 0.\n*END STEP\n";
    for method in [Method::Extrapolation, Method::Collocation] {
        let solution: Solution<f64> = solved(deck, &Options { method, ..Options::default() });
        let times: Vec<f64> = solution.events.iter().map(|event| event.time).collect();
        assert!(times.len() >= 12, "{method:?}: {times:?}");
        // Until the bar has turned: the arm of its weight is not quite 1.
        for (time, wanted) in times.iter().zip([0.06, 0.08, 0.26 / 3.0, 0.8 / 9.0]) {
            assert!((time - wanted).abs() < 1e-7, "{method:?}: {time} for {wanted}");
        }
        assert!(times.iter().all(|time| *time < 0.0900001), "{method:?}: {times:?}");
        let last = solution.frames.last().unwrap();
        for of in &last.connectors {
            assert!((of.total[1] + 5.0).abs() < 1e-12 && of.velocity == [0.0; 6], "{method:?}: {of:?}");
        }
        assert!((last.energies.dissipated - 0.015).abs() < 1e-12, "{method:?}: {:?}", last.energies);
    }
}

/// Boxes on a floor, joined by rods: how they share a load that does not move them is open. They slip together as it exceeds all limits, μ g Σ m.
#[test]
fn boxes_on_rods_share_a_load() {
    for masses in [vec![1.0, 1.0], vec![1.0, 1.5, 2.0, 2.5], vec![3.0, 0.5, 0.5]] {
        let n = masses.len();
        let lines = |of: &dyn Fn(usize) -> String| (0..n).map(of).collect::<String>();
        let rods: String = (1..n).map(|i| format!("{}, {i}, {}\n", 20 + i, i + 1)).collect();
        let weights = lines(&|i| {
            let (set, element, node) = (i, 30 + i, i + 1);
            format!(
                "*ELEMENT, TYPE=MASS, ELSET=M{set}\n{element}, {node}\n*MASS, ELSET=M{set}\n{}\n",
                masses[i]
            )
        });
        let deck = format!(
            "*NODE\n{}*ELEMENT, TYPE=CONN3D2, ELSET=C\n{}*ELEMENT, TYPE=CONN3D2, ELSET=ROD\n{rods}*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
             *CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nSLOT\nO,\n*CONNECTOR SECTION, ELSET=ROD\nLINK\n*CONNECTOR BEHAVIOR, NAME=B\n\
             *CONNECTOR FRICTION, PREDEFINED\n\n*FRICTION\n0.2\n{weights}*AMPLITUDE, NAME=A\n0., 0., 1., 1.\n*STEP\n*DYNAMIC\n0.01, 1.\n\
             *DLOAD\n{}*CLOAD, AMPLITUDE=A\n1, 1, 40.\n*END STEP\n",
            lines(&|i| format!("{}, {i}., 0., 0.\n", i + 1)),
            lines(&|i| format!("{}, , {}\n", 10 + i, i + 1)),
            lines(&|i| format!("M{i}, GRAV, 10., 0., -1., 0.\n")),
        );
        let options = Options { times: vec![0.1], ..Options::default() };
        let solution: Solution<f64> = solved(&deck, &options);
        let all: f64 = masses.iter().sum();
        let (limit, load) = (2.0 * all, 40.0);
        let onset = limit / load;
        let slips: Vec<f64> = solution.events.iter().map(|event| event.time).collect();
        assert_eq!(slips.len(), n, "{masses:?}: {:?}", solution.events);
        assert!(slips.iter().all(|time| (time - onset).abs() < 1e-13), "{masses:?}: {slips:?} for {onset}");
        let resting = solution.frames.iter().find(|frame| frame.time == 0.1).unwrap();
        for of in &resting.connectors {
            assert!(of.open[0] && of.velocity == [0.0; 6], "{masses:?}: {of:?}");
            assert!(of.sticks.iter().all(|sticks| *sticks), "{masses:?}: {of:?}");
        }
        let last = solution.frames.last().unwrap();
        let speed = load * (1.0 - onset).powi(2) / 2.0 / all;
        for of in last.connectors.iter().filter(|of| !of.sticks.is_empty()) {
            assert!((of.velocity[0] - speed).abs() < 1e-13 && !of.open[0], "{masses:?}: {of:?} for {speed}");
        }
    }
}

/// Two masses on rails at right angles, joined by a rod, coast to rest: nothing acts there, so that neither friction need hold anything.
#[test]
fn what_coasts_to_rest_without_a_load_is_no_jam() {
    let deck = "*NODE\n1, 1., 0., 0.\n2, 0., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=H\n12, , 1\n*ELEMENT, TYPE=CONN3D2, ELSET=S\n13, , 2\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=ROD\n14, 1, 2\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*ORIENTATION, NAME=A\n0., 1., 0., -1., 0., 0.\n\
        *CONNECTOR SECTION, ELSET=H, BEHAVIOR=B\nSLOT\nO,\n*CONNECTOR SECTION, ELSET=S, BEHAVIOR=D\nSLOT\nA,\n*CONNECTOR SECTION, ELSET=ROD\n\
        LINK\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR FRICTION, PREDEFINED\n0.5\n*FRICTION\n0.3\n*CONNECTOR BEHAVIOR, NAME=D\n\
        *CONNECTOR FRICTION, PREDEFINED\n0.5\n*FRICTION\n1.1\n*ELEMENT, TYPE=MASS, ELSET=M\n21, 1\n22, 2\n*MASS, ELSET=M\n1.\n\
        *INITIAL CONDITIONS, TYPE=VELOCITY\n1, 1, -0.2\n*STEP\n*DYNAMIC\n0.01, 9.\n*END STEP\n";
    let solution: Solution<f64> = solved(deck, &Options::default());
    let last = solution.frames.last().unwrap();
    assert_eq!((last.time, last.energies.kinetic), (9.0, 0.0), "{:?}", solution.events);
    assert!((last.energies.dissipated - 0.04).abs() < 1e-12, "{:?}", last.energies);
    for (of, rubs) in last.connectors.iter().zip([true, true, false]) {
        assert!(of.open[0] && of.open_friction[0] == rubs, "{of:?}");
    }
    let told: Vec<What> = solution.events.iter().map(|event| event.what).collect();
    assert_eq!(told, [What::Sticks, What::Sticks]);
}

/// A block on a rail with spring, friction and stops, in statics, under loads that are straight between points in time.
///
/// u stays where it is between (f − μ|N|)/k and (f + μ|N|)/k, each within the stops, and goes with that which it meets. Between points all three
/// are straight. What presses passes zero in some, stops are met in some.
#[test]
fn a_static_block_is_a_play_between_bounds() {
    let line = |points: &[(f64, f64)], t: f64| {
        let at = points.iter().rposition(|(time, _)| *time <= t).unwrap().min(points.len() - 2);
        let [(t0, x0), (t1, x1)] = [points[at], points[at + 1]];
        x0 + (x1 - x0) * (t - t0) / (t1 - t0)
    };
    let mut compared = 0;
    for (k, mu, stops, loads, presses) in [
        (87.858, 0.342, Some([-0.115, 0.084]), [28.7, -13.1, 16.6, 12.7], [28.148, 8.856, 5.943]),
        (30.858, 0.152, Some([-0.113, 0.194]), [21.0, -25.0, 24.0, -3.0], [30.983, -21.291, 33.945]),
        (61.2, 0.25, None, [-14.0, 19.0, -22.0, 4.0], [12.0, -18.0, 25.0]),
        (120.0, 0.39, None, [33.0, 35.0, 2.0, -30.0], [6.484, 38.354, 13.949]),
        (45.0, 0.11, Some([-0.2, 0.05]), [9.0, -9.0, 9.0, -9.0], [8.0, 8.0, -8.0]),
    ] {
        let f: Vec<(f64, f64)> =
            [0.0, 0.4, 0.9, 1.3, 2.0].into_iter().zip(std::iter::once(0.0).chain(loads)).collect();
        let n: Vec<(f64, f64)> = [0.0, 1.1, 2.0].into_iter().zip(presses).collect();
        let mut points: Vec<f64> = f.iter().chain(&n).map(|(t, _)| *t).collect();
        for pair in n.windows(2).filter(|pair| pair[0].1 * pair[1].1 < 0.0) {
            points.push(pair[0].0 - pair[0].1 * (pair[1].0 - pair[0].0) / (pair[1].1 - pair[0].1));
        }
        points.sort_by(f64::total_cmp);
        points.dedup();
        let within = |x: f64| stops.map_or(x, |[low, high]: [f64; 2]| x.clamp(low, high));
        let mut u = 0.0_f64;
        let wanted: Vec<(f64, f64)> = points
            .iter()
            .map(|t| {
                let (load, limit) = (line(&f, *t), mu * line(&n, *t).abs());
                u = u.clamp(within((load - limit) / k), within((load + limit) / k));
                (*t, u)
            })
            .collect();
        let table =
            |of: &[(f64, f64)]| of.iter().map(|(t, x)| format!("{t}, {x}")).collect::<Vec<_>>().join("\n");
        let stop = stops
            .map_or(String::new(), |[low, high]| format!("*CONNECTOR STOP, COMPONENT=1\n{low}, {high}\n"));
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=RAIL\n101, 1, 2\n*ORIENTATION, NAME=ALONG\n1., 0., 0., 0., 1., 0.\n\
             *CONNECTOR SECTION, ELSET=RAIL, BEHAVIOR=DRY\nTRANSLATOR,\nALONG,\n*CONNECTOR BEHAVIOR, NAME=DRY\n\
             *CONNECTOR ELASTICITY, COMPONENT=1\n{k}\n{stop}*CONNECTOR FRICTION, PREDEFINED\n.5, .2\n*FRICTION\n{mu}\n*BOUNDARY\n1, 1, 6\n\
             *AMPLITUDE, NAME=F\n{}\n*AMPLITUDE, NAME=N\n{}\n*STEP\n*STATIC\n0.01, 2.\n*CLOAD, AMPLITUDE=F\n2, 1, 1.\n\
             *CLOAD, AMPLITUDE=N\n2, 2, -1.\n*END STEP\n",
            table(&f),
            table(&n)
        );
        for method in [Method::Extrapolation, Method::Collocation] {
            let options = Options { times: points.clone(), method, ..Options::default() };
            let solution: Solution<f64> = solved(&deck, &options);
            for (time, want) in &wanted {
                let frame = solution.frames.iter().rfind(|frame| frame.time == *time).unwrap();
                let got = frame.connectors[0].displacement[0];
                assert!((got - want).abs() < 1e-11, "k = {k}, {method:?}, at {time}: {got}, not {want}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 70);
}
