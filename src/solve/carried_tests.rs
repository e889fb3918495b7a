//! Nodes that beams, rigid bodies and couplings make parts of bodies, and laws of equations at states that are anywhere.

use crate::motion::mechanism::Mechanism;
use crate::number::Number;
use crate::time::run::Run;
use crate::{Method, Options, REFERENCES, Solution, solve};
use nalgebra::DMatrix;
use pintle_kinematics::scalar::Wide;
use pintle_model::evaluate::Model;
use pintle_scene::{Label, NodeMotion, Scene, State};

/// Beams between bodies, hinges and springs in space and in a plane, friction.
const NAMES: [&str; 6] = ["flyball", "bricard", "andrews", "double_hinge", "drawer", "double_pendulum"];

fn scene_of(name: &str) -> Scene {
    let (_, deck) = REFERENCES.iter().find(|(of, _)| *of == name).unwrap();
    Scene::parse(name, deck).unwrap()
}

/// A run where it begins, at a state that fits no equation: each number is moved by another part of a hundredth.
fn anywhere<'a, R: Number>(scene: &'a Scene, model: &'a Model, options: &'a Options) -> (Run<'a, R>, Vec<R>) {
    let mut run: Run<'_, R> = Run::new(scene, model, options).unwrap();
    run.begin().unwrap();
    let y = run.packed();
    let moved = y.iter().enumerate().map(|(i, x)| {
        let part = R::from_f64(0.01 * ((i * i * 7 % 13) as f64 - 6.0) / 6.0);
        *x + (x.magnitude() + R::integer(1)) * part
    });
    let moved = moved.collect();
    (run, moved)
}

/// d/dt of each equation is its rate and d/dt of that zero, wherever a state is: of connectors whose nodes are carried as well.
#[test]
fn equations_keep_their_rates_wherever_a_state_is() {
    let (mut compared, mut carried) = (0, 0);
    for name in NAMES {
        let (scene, options) = (scene_of(name), Options::default());
        let model = Model::compile(&scene).unwrap();
        let (run, y) = anywhere::<Wide>(&scene, &model, &options);
        carried += run.mechanism.carried.iter().flatten().count();
        let (slope, _) = run.flow(&run.state, run.state.time, &y).unwrap();
        let by = Wide::from_f64(1e-28);
        let moved: Vec<Wide> = y.iter().zip(&slope.rates).map(|(y, rate)| *y + by * *rate).collect();
        let after = run.assembled_at(&run.state, run.state.time + by, &moved).unwrap();
        let here = run.assembled_at(&run.state, run.state.time, &y).unwrap();
        let change = |after: Option<Wide>, here: Option<Wide>| {
            after.zip(here).map(|(after, here)| ((after - here) / by).to_f64())
        };
        for row in &run.layout.kept {
            let [now, then] = [&here, &after].map(|of| &of.rows[*row]);
            let size = 1.0 + now.bias.to_f64().abs();
            let acceleration = change(then.rate, now.rate).unwrap();
            assert!(acceleration.abs() < 1e-20 * size, "{name}, {:?}: {acceleration:e}", now.owner);
            let rate = now.rate.unwrap().to_f64();
            let found = change(then.residual, now.residual).unwrap();
            assert!((found - rate).abs() < 1e-20 * size, "{name}, {:?}: {found}, not {rate}", now.owner);
            compared += 1;
        }
    }
    assert!(compared > 90 && carried > 20, "{compared} equations, {carried} nodes");
}

/// Along its directions a state leaves its equations by squares of the way alone, and each is part of itself, once.
#[test]
fn a_tangent_keeps_equations() {
    let (mut compared, mut least) = (0, usize::MAX);
    for name in NAMES {
        let (scene, options) = (scene_of(name), Options::default());
        let model = Model::compile(&scene).unwrap();
        let (run, y) = anywhere::<Wide>(&scene, &model, &options);
        let sizes: Vec<Wide> = (0..y.len()).map(|i| Wide::from_f64(0.5 + (i % 3) as f64)).collect();
        let tangent = run.tangent(&run.state, (run.state.time, &y, &sizes)).unwrap();
        let count = tangent.directions.ncols();
        let apart = &tangent.parts * &tangent.directions - DMatrix::identity(count, count);
        assert!(apart.amax() < 1e-12, "{name}: {}", apart.amax());
        least = least.min(count);
        let step = Wide::from_f64(1e-9);
        let at = |y: &[Wide]| run.assembled_at(&run.state, run.state.time, y).unwrap();
        let here = at(&y);
        for direction in tangent.directions.column_iter() {
            let moved: Vec<Wide> =
                y.iter().zip(&direction).map(|(y, x)| *y + step * Wide::from_f64(*x)).collect();
            let there = at(&moved);
            for row in &run.layout.kept {
                let (now, then) = (&here.rows[*row], &there.rows[*row]);
                for (now, then) in [(now.residual, then.residual), (now.rate, then.rate)] {
                    let change = (then.unwrap() - now.unwrap()).to_f64();
                    // Velocities along are those of a difference.
                    assert!(change.abs() < 1e-14, "{name}: {change:e}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 700 && least >= 1, "{compared} {least}");
}

/// Ties of nodes 2 and 3 to node 1.
const BEAMS: &str = "*MPC\nBEAM, 1, 2\nBEAM, 3, 2\n";
/// The same as other keywords have them.
const TIES: [&str; 3] = [
    BEAMS,
    "*NSET, NSET=TIED\n2, 3\n*RIGID BODY, REF NODE=1, TIE NSET=TIED\n",
    "*SURFACE, TYPE=NODE, NAME=CLOUD\n2\n3\n*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=CLOUD\n*KINEMATIC\n1, 6\n",
];

/// A body with two nodes carried that hangs on a joint: a force, a moment, a spring and a velocity are theirs.
fn hung(ties: &str, masses: &str) -> String {
    format!(
        "*NODE\n1, 0., 0., 0.\n2, 0.4, 0.1, 0.2\n3, 0.7, -0.2, 0.3\n\
         *ELEMENT, TYPE=MASS, ELSET=M\n201, 1\n*MASS, ELSET=M\n2.\n\
         *ELEMENT, TYPE=ROTARYI, ELSET=I\n301, 1\n*ROTARY INERTIA, ELSET=I\n0.1, 0.2, 0.25\n{masses}{ties}\
         *ELEMENT, TYPE=CONN3D2, ELSET=HANGS\n101, 3,\n*CONNECTOR SECTION, ELSET=HANGS\nJOIN\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=PULLS\n102, , 2\n\
         *CONNECTOR SECTION, ELSET=PULLS, BEHAVIOR=SOFT\nCARTESIAN, CARDAN\n\
         *CONNECTOR BEHAVIOR, NAME=SOFT\n*CONNECTOR ELASTICITY, COMPONENT=1\n30.\n\
         *CONNECTOR DAMPING, COMPONENT=5\n0.4\n\
         *INITIAL CONDITIONS, TYPE=VELOCITY\n2, 2, 0.5\n\
         *STEP\n*DYNAMIC\n0.01, 0.5\n*CLOAD\n2, 1, 3.\n2, 6, 0.7\n3, 3, -0.2\n*DLOAD\nM, GRAV, 9.81, 0., 0., -1.\n*END STEP\n"
    )
}

/// The same in the plane.
fn hung_in_plane(ties: &str, masses: &str) -> String {
    format!(
        "*HEADING\n*NODE\n1, 0., 0.\n2, 0.4, 0.1\n3, 0.7, -0.2\n\
         *ELEMENT, TYPE=MASS, ELSET=M\n201, 1\n*MASS, ELSET=M\n2.\n\
         *ELEMENT, TYPE=ROTARYI, ELSET=I\n301, 1\n*ROTARY INERTIA, ELSET=I\n0.1, 0.2, 0.25\n{masses}{ties}\
         *ELEMENT, TYPE=CONN2D2, ELSET=HANGS\n101, 3,\n*CONNECTOR SECTION, ELSET=HANGS\nJOIN\n\
         *ELEMENT, TYPE=CONN2D2, ELSET=PULLS\n102, , 2\n\
         *CONNECTOR SECTION, ELSET=PULLS, BEHAVIOR=SOFT\nCARTESIAN\n\
         *CONNECTOR BEHAVIOR, NAME=SOFT\n*CONNECTOR ELASTICITY, COMPONENT=1\n30.\n\
         *CONNECTOR DAMPING, COMPONENT=2\n0.4\n\
         *INITIAL CONDITIONS, TYPE=VELOCITY\n2, 2, 0.5\n\
         *STEP\n*DYNAMIC\n0.01, 0.5\n*CLOAD\n2, 1, 3.\n1, 6, 0.7\n3, 2, -0.2\n*DLOAD\nM, GRAV, 9.81, 0., -1.\n*END STEP\n"
    )
}

/// A body whose nodes 2 and 3 have no rotations: pins.
fn pinned(_: &str, masses: &str) -> String {
    format!(
        "*NODE\n1, 0., 0., 0.\n2, 0.4, 0.1, 0.2\n3, 0.7, -0.2, 0.3\n4, 2., 1., 1.\n5, 1., -1., 2.\n\
         *ELEMENT, TYPE=MASS, ELSET=M\n201, 1\n*MASS, ELSET=M\n2.\n\
         *ELEMENT, TYPE=ROTARYI, ELSET=I\n301, 1\n*ROTARY INERTIA, ELSET=I\n0.1, 0.2, 0.25\n{masses}\
         *NSET, NSET=PINS\n2, 3\n*RIGID BODY, REF NODE=1, PIN NSET=PINS\n*BOUNDARY\n4, 1, 3\n5, 1, 3\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=PULLS\n101, 2, 4\n102, 3, 5\n\
         *CONNECTOR SECTION, ELSET=PULLS, BEHAVIOR=SOFT\nAXIAL\n\
         *CONNECTOR BEHAVIOR, NAME=SOFT\n*CONNECTOR ELASTICITY, COMPONENT=1\n30.\n\
         *STEP\n*DYNAMIC\n0.01, 0.5\n*CLOAD\n2, 1, 3.\n*DLOAD\nM, GRAV, 9.81, 0., 0., -1.\n*END STEP\n"
    )
}

/// What is carried moves, and is loaded, as where its ties are equations: there its nodes have a mass that weighs nothing.
#[test]
fn what_is_carried_moves_as_equations_say() {
    let tiny = "*ELEMENT, TYPE=MASS, ELSET=T\n202, 2\n203, 3\n*MASS, ELSET=T\n1e-26\n";
    type Deck = fn(&str, &str) -> String;
    let of = |deck: Deck, ties: &'static [&'static str]| ties.iter().map(move |ties| (deck, *ties));
    let decks = of(hung, &TIES).chain(of(hung_in_plane, &TIES)).chain(of(pinned, &TIES[1..2]));
    let mut compared = 0;
    for ((deck, ties), method) in
        decks.flat_map(|of| [(of, Method::Extrapolation), (of, Method::Collocation)])
    {
        let options = Options { method, times: vec![0.2, 0.5], ..Options::default() };
        let [carried, held]: [Solution<f64>; 2] = [("", 2), (tiny, 0)].map(|(masses, count)| {
            let scene = Scene::parse("deck.inp", &deck(ties, masses)).unwrap();
            let mechanism = Mechanism::<f64>::new(&scene, &Model::compile(&scene).unwrap(), 0).unwrap();
            assert_eq!(mechanism.carried.iter().flatten().count(), count, "{ties} {}", scene.two_dimensional);
            solve(&scene, &options).unwrap()
        });
        for (one, other) in carried.frames.iter().zip(&held.frames) {
            assert!(one.nodes.len() >= 3);
            for (node, (one, other)) in one.nodes.iter().zip(&other.nodes).enumerate() {
                let all = |of: &crate::NodeFrame<f64>| {
                    [of.displacement.as_slice(), &of.rotation, &of.velocity, &of.acceleration].concat()
                };
                for (k, (x, y)) in all(one).into_iter().zip(all(other)).enumerate() {
                    assert!((x - y).abs() < 1e-11, "{ties} {method:?} node {node}, {k}: {x}, not {y}");
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 2 * 3 * (6 * 3 + 5) * 18);
}

/// A rod without mass between two bodies, of which each holds one of its ends, turns by itself: a pin does not make it part of a body.
#[test]
fn a_pin_does_not_carry_what_carries_its_node() {
    let deck = "*NODE\n1, 0.5, 0., 0.\n2, 0., 0., 0.\n3, 1., 0., 0.\n4, 0., 1., 0.\n5, 1., 1., 0.\n\
        *ELEMENT, TYPE=MASS, ELSET=M\n201, 4\n202, 5\n*MASS, ELSET=M\n2.\n\
        *ELEMENT, TYPE=ROTARYI, ELSET=I\n301, 4\n302, 5\n*ROTARY INERTIA, ELSET=I\n0.1, 0.2, 0.25\n\
        *NSET, NSET=ENDS\n2, 3\n*NSET, NSET=LEFT\n2\n*NSET, NSET=RIGHT\n3\n*RIGID BODY, REF NODE=1, PIN NSET=ENDS\n\
        *RIGID BODY, REF NODE=4, PIN NSET=LEFT\n*RIGID BODY, REF NODE=5, PIN NSET=RIGHT\n\
        *STEP\n*DYNAMIC\n0.01, 0.5\n*CLOAD\n4, 2, 3.\n*END STEP\n";
    let scene = Scene::parse("deck.inp", deck).unwrap();
    let mechanism = Mechanism::<f64>::new(&scene, &Model::compile(&scene).unwrap(), 0).unwrap();
    let of = |label: u64| mechanism.bodies.iter().position(|body| body.label == Label::from(label)).unwrap();
    assert!(mechanism.carried[of(1)].is_none() && mechanism.relations.len() == 2, "{:?}", mechanism.carried);
    assert_eq!([2, 3].map(|end| mechanism.root(of(end))), [of(1); 2]);
}

/// A node without rotations that a moment acts on is no part of its body: the moment would act on that, and nothing says so.
#[test]
fn a_moment_on_a_pin_is_refused() {
    let loaded = pinned("", "").replace("*CLOAD\n", "*CLOAD\n2, 5, 1.\n");
    let scene = Scene::parse("deck.inp", &loaded).unwrap();
    let found = solve::<f64>(&scene, &Options::default());
    assert!(found.is_err_and(|why| format!("{why:?}").contains("ur2 of node 2")));
}

/// A state that has a carried node elsewhere than its body says so: it is brought there, and how far counts as a violation.
#[test]
fn a_state_that_does_not_fit_its_beams_is_a_violation() {
    let scene = Scene::parse("deck.inp", &hung(BEAMS, "")).unwrap();
    let violation = |off: f64| {
        let node = |x: f64| NodeMotion { displacement: [x, 0.0, 0.0], ..NodeMotion::default() };
        let nodes = [(Label::from(1_u64), node(0.0)), (Label::from(2_u64), node(off))];
        let from = State { time: Some(0.0), nodes: nodes.into_iter().collect(), ..State::default() };
        let options = Options { from: Some(from), until: Some(0.01), ..Options::default() };
        solve::<f64>(&scene, &options).unwrap().violation
    };
    let (fits, elsewhere) = (violation(0.0), violation(0.05));
    assert!(fits < 1e-13 && elsewhere > 0.01, "{fits} {elsewhere}");
}

/// A moment that is zero presses nothing, and costs no digits. The cart has a rail that bears none, in the plane and in space, with a beam
/// that is carried and with one that is an equation. Events are those that two methods on 237 bits give.
#[test]
fn a_moment_that_is_zero_costs_no_digits() {
    let [deck, stored] = ["deck.inp", "solution.json"].map(|name| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../references/pendulum_cart");
        std::fs::read_to_string(std::path::Path::new(folder).join(name)).unwrap()
    });
    let stored: serde_json::Value = serde_json::from_str(&stored).unwrap();
    let times = stored["events"].as_array().unwrap().iter().map(|event| event[0].as_str().unwrap());
    let times: Vec<f64> = times.map(|time| time.parse().unwrap()).collect();
    let tiny = "*ELEMENT, TYPE=MASS, ELSET=T\n205, 3\n*MASS, ELSET=T\n1e-26\n*STEP\n";
    let mut compared = 0;
    for (is_space, is_equation) in [(false, false), (true, false), (false, true), (true, true)] {
        let deck = if is_space { deck.replace("CONN2D2", "CONN3D2") } else { deck.clone() };
        let deck = if is_equation { deck.replace("*STEP\n", tiny) } else { deck };
        for method in [Method::Extrapolation, Method::Collocation] {
            let scene = Scene::parse("deck.inp", &deck).unwrap();
            let found: Solution<f64> = solve(&scene, &Options { method, ..Options::default() }).unwrap();
            assert_eq!(found.events.len(), times.len());
            for (event, time) in found.events.iter().zip(&times) {
                let apart = (event.time - time).abs();
                assert!(
                    apart < 1e-13,
                    "{apart:e}: in space {is_space}, an equation {is_equation}, {method:?}"
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 8 * times.len());
}

/// A moment that is zero at first presses as soon as it is not. It jumps where a step of the scene begins, or grows from a break of its
/// amplitude on. Its weight alone slows the block before, and both after.
#[test]
fn a_moment_that_begins_later_presses_then() {
    let deck = |steps: &str| {
        format!(
            "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN2D2, ELSET=RAIL\n101, 1, 2\n\
             *ORIENTATION, NAME=ALONG\n1., 0., 0., 0., 1., 0.\n*CONNECTOR SECTION, ELSET=RAIL, BEHAVIOR=DRY\nTRANSLATOR,\nALONG,\n\
             *CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR FRICTION, PREDEFINED\n0.05, 0.2\n*FRICTION\n0.2\n\
             *ELEMENT, TYPE=MASS, ELSET=CART\n201, 2\n*MASS, ELSET=CART\n1.\n*ELEMENT, TYPE=ROTARYI, ELSET=I\n203, 2\n\
             *ROTARY INERTIA, ELSET=I\n0.01, 0.01, 0.01\n*BOUNDARY\n1, 1, 6\n2, 3, 5\n\
             *AMPLITUDE, NAME=GROWS\n0., 0., 0.25, 0., 0.5, 1., 1., 1.\n\
             *INITIAL CONDITIONS, TYPE=VELOCITY\n2, 1, 4.\n{steps}"
        )
    };
    let weight = "*DLOAD\nCART, GRAV, 9.81, 0., -1., 0.\n";
    let jumps = deck(&format!(
        "*STEP\n*DYNAMIC\n0.01, 0.25\n{weight}*END STEP\n*STEP\n*DYNAMIC\n0.01, 0.5\n*CLOAD\n2, 6, 0.5\n*END STEP\n"
    ));
    let grows = deck(&format!(
        "*STEP\n*DYNAMIC\n0.01, 0.75\n{weight}*CLOAD, AMPLITUDE=GROWS\n2, 6, 0.5\n*END STEP\n"
    ));
    let mut last = Vec::new();
    for (name, deck) in [("jumps", jumps), ("grows", grows)] {
        let scene = Scene::parse("deck.inp", &deck).unwrap();
        for method in [Method::Extrapolation, Method::Collocation] {
            let options = Options { method, times: vec![0.2, 0.7, 0.75], ..Options::default() };
            let found: Solution<f64> = solve(&scene, &options).unwrap();
            let at = |time: f64| {
                let frame = found.frames.iter().find(|frame| (frame.time - time).abs() < 1e-12).unwrap();
                let node = &frame.nodes[1];
                [node.displacement[0], node.velocity[0], node.acceleration[0]]
            };
            let ([x0, v0, a0], [x1, v1, a1], [x2, v2, a2]) = (at(0.2), at(0.7), at(0.75));
            // The weight alone presses, and slows the block evenly.
            let is_near = |found: f64, wanted: f64, what: &str| {
                assert!((found - wanted).abs() < 1e-12, "{name}, {method:?}, {what}: {found}, not {wanted}");
            };
            is_near(a0, -0.2 * 9.81, "acceleration before");
            is_near(v0, 4.0 + 0.2 * a0, "velocity before");
            is_near(x0, 0.2 * 4.0 + 0.02 * a0, "way before");
            // The moment presses by 0.5 over its lever, whatever that is.
            assert!(a1 < 1.1 * a0, "{name}, {method:?}: {a1}, {a0} before");
            is_near(a2, a1, "acceleration after");
            is_near(v2, v1 + 0.05 * a1, "velocity after");
            is_near(x2, x1 + 0.05 * v1 + 0.00125 * a1, "way after");
            if name == "jumps" {
                is_near(v1, 4.0 + 0.25 * a0 + 0.45 * a1, "velocity across the jump");
            }
            last.push([x2, v2, a2]);
        }
    }
    let apart = |one: usize, other: usize, k: usize| (last[one][k] - last[other][k]).abs();
    for k in 0..3 {
        assert!(apart(0, 1, k) < 1e-12 && apart(2, 3, k) < 1e-12, "{last:?}");
    }
    // Grown, it presses as it does where it jumps to as much.
    assert!(apart(0, 2, 2) < 1e-12, "{last:?}");
}
