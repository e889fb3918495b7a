//! How a run begins: velocities that a deck has rounded, a state to go on from; what nothing determines, and stops that open at once.

use crate::{Method, Options, Solution, What, solve};
use pintle_scene::{NodeMotion, Rotation, Scene, State};

/// A bar that swings about the ground, with all the velocities of its end given.
fn swinging(velocities: [&str; 3]) -> String {
    let [vx, vy, spin] = velocities;
    format!(
        "*NODE\n1, 0., 0., 0.\n2, 0.6, 0.8, 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=PIN\n101, , 1\n\
         *ORIENTATION, NAME=AXIS\n0., 0., 1., 1., 0., 0.\n*CONNECTOR SECTION, ELSET=PIN\nHINGE,\nAXIS,\n\
         *MPC\nBEAM, 2, 1\n*ELEMENT, TYPE=MASS, ELSET=M\n201, 2\n*MASS, ELSET=M\n2.\n\
         *ELEMENT, TYPE=ROTARYI, ELSET=I\n202, 2\n*ROTARY INERTIA, ELSET=I\n0.1, 0.1, 0.1\n\
         *INITIAL CONDITIONS, TYPE=VELOCITY\n2, 1, {vx}\n2, 2, {vy}\n2, 6, {spin}\n\
         *STEP\n*DYNAMIC\n0.01, 0.2\n*END STEP\n"
    )
}

/// Seven digits of velocities that fit a turn do not fit it to more: they are brought to it, and that is said. What is off by 1e-4 is refused.
#[test]
fn velocities_that_a_deck_has_rounded_are_brought_to_the_constraints() {
    // ω = 3.1234567 at (0.6, 0.8).
    let exact = swinging(["-2.49876536", "1.87407402", "3.1234567"]);
    let rounded = swinging(["-2.498765", "1.874074", "3.123457"]);
    let run = |deck: &str| {
        let scene = Scene::parse("deck.inp", deck).unwrap();
        solve::<f64>(&scene, &Options::default())
    };
    let exact = run(&exact).unwrap();
    assert_eq!(exact.changed, 0.0);
    let rounded = run(&rounded).unwrap();
    assert!((1e-9..1e-6).contains(&rounded.changed), "{:e}", rounded.changed);
    let body = |of: &Solution<f64>| {
        let at = of.nodes.iter().position(|label| label.to_string() == "2").unwrap();
        of.frames[0].nodes[at].velocity
    };
    let [vx, vy, _, _, _, spin] = body(&rounded);
    assert!((vx + 0.8 * spin).abs() < 1e-15 && (vy - 0.6 * spin).abs() < 1e-15, "{vx} {vy} {spin}");
    assert!((spin - 3.123_456_7).abs() < 1e-6, "{spin}");
    let why = run(&swinging(["-2.4987", "1.8741", "3.1235"])).unwrap_err().why.to_string();
    assert!(why.contains("do not fit the constraints"), "{why}");
}

/// A mass on a spring of a connector and one of an element, which rubs.
const SPRUNG: &str = "\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 3., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=RAIL
101, 1, 2
*CONNECTOR SECTION, ELSET=RAIL, BEHAVIOR=SOFT
CARTESIAN
*CONNECTOR BEHAVIOR, NAME=SOFT
*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR
-8., -1.
0., 0.
20., 1.
*CONNECTOR DAMPING, COMPONENT=1
0.4
*ELEMENT, TYPE=SPRINGA, ELSET=S
102, 2, 3
*SPRING, ELSET=S

7.
*ELEMENT, TYPE=MASS, ELSET=M
201, 2
*MASS, ELSET=M
1.5
*BOUNDARY
1, 1, 6
3, 1, 6
*STEP
*DYNAMIC
0.01, 2.
*CLOAD
2, 1, 9.
*END STEP
";

/// A run in two parts has the motion, the kinetic energy and what springs hold of the run in one; works count from where each begins.
#[test]
fn a_run_that_goes_on_has_the_energies_of_the_run_in_one() {
    let scene = Scene::parse("deck.inp", SPRUNG).unwrap();
    let options = Options { times: vec![0.7], ..Options::default() };
    let whole = solve::<f64>(&scene, &options).unwrap();
    let frame = &whole.frames[1];
    let nodes = whole.nodes.iter().zip(&frame.nodes).map(|(label, node)| {
        let [vx, vy, vz, wx, wy, wz] = node.velocity;
        let motion = NodeMotion {
            displacement: node.displacement,
            rotation: Rotation::Vector(node.rotation),
            velocity: [vx, vy, vz],
            angular_velocity: [wx, wy, wz],
            ..NodeMotion::default()
        };
        (*label, motion)
    });
    let from = State { time: Some(0.7), nodes: nodes.collect(), ..State::default() };
    let part = solve::<f64>(&scene, &Options { from: Some(from), ..Options::default() }).unwrap();
    let [first, of_part, last] = [&frame.energies, &part.frames[0].energies, &part.frames[1].energies];
    let end = &whole.frames[2].energies;
    assert!(first.stored > 1.0 && first.dissipated > 0.01, "{first:?}");
    let mut compared = 0;
    for (x, y) in [
        (first.kinetic, of_part.kinetic),
        (first.stored, of_part.stored),
        (end.kinetic, last.kinetic),
        (end.stored, last.stored),
        (end.dissipated, first.dissipated + last.dissipated),
        (end.external, first.external + last.external),
        (last.balance, 0.0),
        (whole.frames[2].nodes[1].displacement[0], part.frames[1].nodes[1].displacement[0]),
    ] {
        assert!((x - y).abs() < 2e-13, "{x} {y}");
        compared += 1;
    }
    assert!(compared == 8 && !part.stored_is_open && of_part.balance.abs() < 1e-15);
}

/// A bar on a ball joint whose Cardan angles α and γ have springs, turned at a rate about its middle axis, beside which it spins a little.
fn towards_lock(beside: &str) -> String {
    format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=PIN\n101, , 1\n\
         *CONNECTOR SECTION, ELSET=PIN, BEHAVIOR=B\nJOIN, CARDAN\n*CONNECTOR BEHAVIOR, NAME=B\n\
         *CONNECTOR ELASTICITY, COMPONENT=4\n20.\n*CONNECTOR ELASTICITY, COMPONENT=6\n20.\n*MPC\nBEAM, 2, 1\n\
         *ELEMENT, TYPE=MASS, ELSET=M\n201, 2\n*MASS, ELSET=M\n1.\n*ELEMENT, TYPE=ROTARYI, ELSET=I\n202, 2\n\
         *ROTARY INERTIA, ELSET=I\n0.1, 0.2, 0.3\n*INITIAL CONDITIONS, TYPE=VELOCITY\n2, 5, 5.\n{beside}\
         *STEP\n*DYNAMIC\n0.01, 1.\n*END STEP\n"
    )
}

/// Angles lock at β = 90°: who runs into it is told when and where, who goes by it passes.
#[test]
fn a_lock_of_angles_is_named() {
    let run = |deck: &str| {
        let scene = Scene::parse("deck.inp", deck).unwrap();
        solve::<f64>(&scene, &Options::default())
    };
    let ended = run(&towards_lock("")).unwrap_err();
    let why = ended.why.to_string();
    assert!(why.contains("CARDAN 101") && why.contains("lock at time 0.314"), "{why}");
    // β = 5 t.
    assert!((ended.time - std::f64::consts::PI / 10.0).abs() < 1e-6, "{}", ended.time);
    let passed = run(&towards_lock("2, 4, 0.5\n")).unwrap();
    assert!(passed.frames.last().unwrap().energies.balance.abs() < 1e-9);
}

/// A crank and a rod of equal lengths, and no friction: at 90° its slider may stay at the crank's axis, or go on.
const CRANK: &str = "\
*NODE
1, 0., 0., 0.
2, 0.6, 0.8, 0.
3, 0.6, 0.8, 0.
4, 1.2, 0., 0.
5, 1.2, 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=PIN
101, , 1
102, 2, 3
103, 5, 4
*ORIENTATION, NAME=AX
0., 0., 1., 1., 0., 0.
*CONNECTOR SECTION, ELSET=PIN
HINGE,
AX,
*ELEMENT, TYPE=CONN3D2, ELSET=RAIL
104, , 5
*ORIENTATION, NAME=ALONG
1., 0., 0., 0., 1., 0.
*CONNECTOR SECTION, ELSET=RAIL
TRANSLATOR,
ALONG,
*MPC
BEAM, 2, 1
BEAM, 4, 3
*ELEMENT, TYPE=MASS, ELSET=M
201, 2
203, 4
205, 5
*MASS, ELSET=M
1.
*ELEMENT, TYPE=ROTARYI, ELSET=I
202, 2
204, 4
*ROTARY INERTIA, ELSET=I
0.1, 0.2, 0.3
*INITIAL CONDITIONS, TYPE=VELOCITY
2, 6, 2.
*STEP
*DYNAMIC
0.01, 4.
*END STEP
";

/// A dead position is named within a few thousand steps, with how near it is.
#[test]
fn a_dead_position_is_named() {
    let scene = Scene::parse("deck.inp", CRANK).unwrap();
    let ended = solve::<f64>(&scene, &Options::default()).unwrap_err();
    let why = ended.why.to_string();
    println!("{} steps, at {}: {why}", ended.solution.steps, ended.time);
    assert!(ended.solution.steps < 5_000, "{}", ended.solution.steps);
    assert!(why.contains("singular position"), "{why}");
}

/// A collar that its weight presses, and a small load drives along its shaft, while it is turned to and fro as 1 − cos 3t. With the turning it comes
/// to rest every π/3, and sets out again the other way.
const TO_AND_FRO: &str = "\
*NODE
1, 0., 0., 0.
2, 0., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=SHAFT
101, 1, 2
*ORIENTATION, NAME=AX
1., 0., 0., 0., 1., 0.
*CONNECTOR SECTION, ELSET=SHAFT, BEHAVIOR=DRY
CYLINDRICAL,
AX,
*CONNECTOR BEHAVIOR, NAME=DRY
*CONNECTOR FRICTION, PREDEFINED
0.05
*FRICTION
0.2
*ELEMENT, TYPE=MASS, ELSET=M
201, 2
*MASS, ELSET=M
1.5
*ELEMENT, TYPE=ROTARYI, ELSET=I
202, 2
*ROTARY INERTIA, ELSET=I
0.004, 0.02, 0.02
*BOUNDARY
1, 1, 6
*AMPLITUDE, NAME=A, DEFINITION=PERIODIC
1, 3., 0., 1.
-1., 0.
*STEP
*DYNAMIC
0.01, 1.5
*CONNECTOR MOTION, AMPLITUDE=A
SHAFT, 4, 1.
*CLOAD
2, 1, 1.
*DLOAD
M, GRAV, 10., 0., 0., -1.
*END STEP
";

/// What is driven through rest goes on, by both methods: it was restarted before its rest, ever again.
#[test]
fn a_drive_through_rest_goes_on() {
    let scene = Scene::parse("deck.inp", TO_AND_FRO).unwrap();
    let run = |method| {
        let options = Options { method, most_steps: 2_000, ..Options::default() };
        solve::<f64>(&scene, &options).map_err(|ended| format!("at {}: {}", ended.time, ended.why))
    };
    let [one, other] = [Method::Extrapolation, Method::Collocation].map(|method| run(method).unwrap());
    let apart = one.difference(&other);
    let last = one.frames.last().unwrap();
    println!("{} and {} steps, {apart:?}, {:?}", one.steps, other.steps, last.connectors[0].displacement);
    assert!(apart.largest() < 1e-11, "{apart:?}");
    assert!(last.energies.balance.abs() < 1e-12, "{:?}", last.energies);
}

/// A drive that ends in mid-step, smoothly, rests when it ends: both methods know the instant, and it sticks from there.
#[test]
fn a_drive_that_ends_in_mid_step_rests_there() {
    let deck = TO_AND_FRO
        .replace(
            "DEFINITION=PERIODIC\n1, 3., 0., 1.\n-1., 0.",
            "DEFINITION=SMOOTH STEP\n0., 0., 0.5, 0., 2.4, 3.",
        )
        .replace("0.01, 1.5", "0.01, 2.5");
    let scene = Scene::parse("deck.inp", &deck).unwrap();
    for method in [Method::Extrapolation, Method::Collocation] {
        let solution = solve::<f64>(&scene, &Options { method, ..Options::default() }).unwrap();
        let events: Vec<_> = solution.events.iter().map(|event| (event.what, event.time)).collect();
        let [(What::Slips, _), (What::Sticks, rest)] = events[..] else { panic!("{events:?}") };
        assert!((rest - 2.4).abs() < 1e-14, "{rest}");
    }
}

/// A mass on a spring meets a stop, loses its speed there, and is pulled back at once, whatever digits its time has: no event without end.
#[test]
fn a_stop_that_opens_at_once_is_met_once() {
    let mut compared = 0;
    for (k, v) in [(50.0, 1.0), (40.0, 1.0), (64.0, 2.0), (17.0, 0.7), (90.0, 3.0)] {
        for digits in [3, 5, 8, 13] {
            let deck = format!(
                "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=M\n201, 1\n*MASS, ELSET=M\n1.\n\
                 *ELEMENT, TYPE=CONN3D2, ELSET=C\n101, , 1\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nCARTESIAN\n\
                 *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=1\n{k}\n*CONNECTOR STOP, COMPONENT=1\n, 0.1\n\
                 *BOUNDARY\n1, 2, 6\n*INITIAL CONDITIONS, TYPE=VELOCITY\n1, 1, {v}\n*STEP\n*DYNAMIC\n0.01, 0.8\n*END STEP\n"
            );
            let scene = Scene::parse("deck.inp", &deck).unwrap();
            for method in [Method::Extrapolation, Method::Collocation] {
                let options = Options { digits, method, most_steps: 2_000, ..Options::default() };
                let found = solve::<f64>(&scene, &options).unwrap();
                let omega = f64::sqrt(k);
                let wanted = (0.1 * omega / v).asin() / omega;
                let times: Vec<(What, f64)> =
                    found.events.iter().map(|event| (event.what, event.time)).collect();
                let closed = times.iter().filter(|(what, _)| *what == What::Closes).count();
                let allowed = 10.0_f64.powi(1 - digits as i32).max(1e-12);
                assert!((times[0].1 - wanted).abs() < allowed && closed <= 2, "{k} {v} {digits}: {times:?}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 40);
}

/// A point mass on an arm, without rotary inertia: a spring, or a load that grows, turns what nothing can. It is refused where that begins.
#[test]
fn what_is_pushed_later_is_refused_as_what_is_pushed_at_once() {
    let deck = |acts: &str, load: &str| {
        format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=M\n201, 1\n*MASS, ELSET=M\n2.\n*MPC\nBEAM, 2, 1\n\
             *ELEMENT, TYPE=CONN3D2, ELSET=S\n101, , 2\n*CONNECTOR SECTION, ELSET=S, BEHAVIOR=K\nCARTESIAN\n\
             *CONNECTOR BEHAVIOR, NAME=K\n*CONNECTOR ELASTICITY, COMPONENT={acts}\n50.\n*AMPLITUDE, NAME=GROWS\n0., 0., 1., 1.\n\
             *STEP\n*DYNAMIC\n0.01, 1.\n{load}*END STEP\n"
        )
    };
    let run = |acts: &str, load: &str| {
        let scene = Scene::parse("deck.inp", &deck(acts, load)).unwrap();
        solve::<f64>(&scene, &Options::default())
    };
    for load in ["*CLOAD\n1, 2, 3.\n", "*CLOAD, AMPLITUDE=GROWS\n2, 2, 3.\n", "*CLOAD\n2, 2, 3.\n"] {
        let why = run("2", load).unwrap_err().why.to_string();
        assert!(why.contains("ur3 of node 1: nothing determines how it accelerates"), "{load}: {why}");
    }
    // Along the arm nothing turns it.
    assert!(run("1", "*CLOAD, AMPLITUDE=GROWS\n1, 1, 3.\n").is_ok());
    // Two springs one after the other, with nothing between them.
    let springs = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=M\n201, 2\n*MASS, ELSET=M\n2.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=S\n101, , 1\n102, 1, 2\n*CONNECTOR SECTION, ELSET=S, BEHAVIOR=K\nAXIAL\n\
        *CONNECTOR BEHAVIOR, NAME=K\n*CONNECTOR ELASTICITY, COMPONENT=1\n50.\n*STEP\n*DYNAMIC\n0.01, 1.\n*CLOAD\n2, 1, 3.\n*END STEP\n";
    let springs = springs.replace("1, 0., 0., 0.\n2", "1, 0.5, 0., 0.\n2");
    let why =
        solve::<f64>(&Scene::parse("deck.inp", &springs).unwrap(), &Options::default()).unwrap_err().why;
    assert!(why.to_string().contains("u1 of node 1: nothing determines"), "{why}");
}
