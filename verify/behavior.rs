//! Forces that follow from motions: against JAX, against the wide scalar, and by what must hold of springs, dampers, stops, locks,
//! failures and drives.

pub(crate) mod belts; // friction over a ring
mod drives; // motions and loads, step by step
mod holding; // what holds components, and what is said of it
mod tables; // tables in several variables
mod tangents; // consistent tangents

use crate::tolerance::{BEHAVIOR_JAX, BEHAVIOR_SLOPE, BELT_BALANCE, WIDE};
use num_dual::DualSVec64;
use pintle_kinematics::connector::{Components, Flag, Request, State, StopStatus, Tally};
use pintle_kinematics::force::Want;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::{Real, Scalar, Seeded, Wide};
use pintle_kinematics::{so3, vector};
use pintle_model::behavior::state::{Behavior, Velocities};
use pintle_model::behavior::{Conditions, Motion};
use pintle_model::evaluate::{Branches, ConnectorResult, Model, Plan, Selection, Sequence, request};
use pintle_scene::{ElementForces, GALLERY, NodeMotion, Rotation, Scene, State as SceneState};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A connector of this type between nodes 1 and 2, (1, 2, 3) apart, with this behaviour and these steps.
fn deck(types: &str, behavior: &str, steps: &str) -> String {
    format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 2., 3.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\n{types}\nO,\n\
         *AMPLITUDE, NAME=WAVE\n0., 0., 1., 2., 3., -2.\n*CONNECTOR BEHAVIOR, NAME=B\n{behavior}\n{steps}"
    )
}

fn scene(types: &str, behavior: &str, steps: &str) -> Scene {
    let deck = deck(types, behavior, steps);
    Scene::parse("deck.inp", &deck).unwrap_or_else(|error| panic!("{}\n{deck}", error.render(100, false)))
}

const ALL_AVAILABLE: &str = "CARTESIAN, CARDAN";

fn model(types: &str, behavior: &str, steps: &str) -> Model {
    Model::compile(&scene(types, behavior, steps))
        .unwrap_or_else(|error| panic!("{}", error.render(100, false)))
}

fn behavior(of: &str) -> Arc<Behavior> {
    Arc::clone(&model(ALL_AVAILABLE, of, "").connectors[0].behavior.behavior)
}

/// States in which node 2 is displaced along the global 1-axis, with its velocity, at times.
fn along_1(states: &[(f64, f64, f64)]) -> Vec<SceneState> {
    let state = |(time, u, v): &(f64, f64, f64)| {
        let motion =
            NodeMotion { displacement: [*u, 0.0, 0.0], velocity: [*v, 0.0, 0.0], ..NodeMotion::default() };
        SceneState { time: Some(*time), nodes: BTreeMap::from([(2.into(), motion)]), ..SceneState::default() }
    };
    states.iter().map(state).collect()
}

/// Walks through states; `forces` are the total forces of u1 to ur3 given at each.
fn walk(
    model: &Model,
    states: &[SceneState],
    velocities: Velocities,
    forces: &[Components<f64>],
) -> Vec<ConnectorResult> {
    let plan = Plan::compile(model, &Selection::All, request(["ALL"], 0).unwrap()).unwrap();
    let mut sequence = Sequence::new(model, &plan);
    sequence.set_velocities(velocities);
    let mut results = Vec::new();
    for (i, state) in states.iter().enumerate() {
        let mut state = state.clone();
        // A file gives every force of an element.
        let given = |total: &Components<f64>| ElementForces {
            total: total.map(|force| force.or(Some(0.0))),
            ..ElementForces::default()
        };
        state.forces.extend(forces.get(i).map(|forces| (model.connectors[0].label, given(forces))));
        results.extend(sequence.step(&state).connectors);
    }
    results
}

fn exact(motion: &Motion<f64>) -> Motion<Wide> {
    let wide = |values: [f64; 6]| values.map(Wide::from_f64);
    Motion {
        position: wide(motion.position),
        constitutive: wide(motion.constitutive),
        velocity: wide(motion.velocity),
    }
}

/// Random numbers from a counter, in (−1, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn six(&mut self, scale: f64) -> [f64; 6] {
        [0; 6].map(|_| scale * self.next())
    }

    fn motion(&mut self, scale: f64) -> Motion<f64> {
        Motion { position: self.six(scale), constitutive: self.six(scale), velocity: self.six(scale) }
    }
}

/// Laws of every kind, one set after another.
const LAWS: [&str; 6] = [
    "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR DAMPING, COMPONENT=6\n0.25",
    "*CONNECTOR ELASTICITY\n4., 1., 5., 0.5, -1., 6., 0., 0.25\n0.75, 7., 0.1, 0.2, 0.3, 0.4, 8., -0.5\n0.6, 0.7, 0.8, 0.9, 9.",
    "*CONNECTOR DAMPING, UNSYMM\n1., 2., 3., 4., 5., 6., 7., 8.\n9., 1., 2., 3., 4., 5., 6., 7.\n8., 9., 1., 2., 3., 4., 5., 6.\n\
     7., 8., 9., 1., 2., 3., 4., 5.\n6., 7., 8., 9.",
    "*CONNECTOR ELASTICITY, COMPONENT=2, NONLINEAR\n-3., -0.5\n0., 0.\n1., 0.25\n7., 0.75\n\
     *CONNECTOR DAMPING, COMPONENT=2, NONLINEAR, EXTRAPOLATION=LINEAR\n-1., -1.\n0., 0.\n4., 1.",
    "*CONNECTOR ELASTICITY, COMPONENT=3, NONLINEAR, INDEPENDENT COMPONENTS=POSITION\n1, 3\n\
     0., -1., -1.\n1., 0., -1.\n5., 1., -1.\n2., -1., 0.5\n-1., 0., 0.5\n3., 1., 0.5\n0.5, -1., 1.\n4., 0., 1.\n-2., 1., 1.",
    "*CONNECTOR DAMPING, COMPONENT=4, NONLINEAR, INDEPENDENT COMPONENTS=CONSTITUTIVE MOTION\n5\n\
     -2., -1., 0.\n3., 1., 0.\n-4., -1., 1.\n9., 1., 1.",
];

/// Every tangent against central differences of the forces on the wide scalar, which have no step to tune.
#[test]
fn tangents_are_derivatives() {
    let mut numbers = Numbers(1);
    let conditions = Conditions::default();
    for law in LAWS {
        let behavior = behavior(law);
        for scale in [0.3, 1.0, 5.0, 1e-8] {
            for _ in 0..20 {
                let motion = numbers.motion(scale);
                let tangent = behavior.tangent(&motion, &conditions, None, [false; 6]);
                let h = Wide::from_f64(1e-25 * scale);
                for j in 0..12 {
                    let moved = |by: Wide| {
                        let mut at = exact(&motion);
                        if j < 6 {
                            at.position[j] += by;
                            at.constitutive[j] += by;
                        } else {
                            at.velocity[j - 6] += by;
                        }
                        behavior.forces(&at, &conditions)
                    };
                    let (above, below) = (moved(h), moved(-h));
                    for i in 0..6 {
                        let slope = ((above[i] - below[i]) / (h + h)).to_f64();
                        let got = if j < 6 { tangent.displacement[i][j] } else { tangent.velocity[i][j - 6] };
                        assert!(
                            (got - slope).abs() <= BEHAVIOR_SLOPE * (1.0 + slope.abs()),
                            "{law}: ∂F{i}/∂{j} {got} {slope}"
                        );
                    }
                }
            }
        }
    }
}

/// At a row the slope is one of both sides, the smaller one, and the two are told.
#[test]
fn kinks_are_told() {
    let model = model(ALL_AVAILABLE, LAWS[3], "");
    let states = [0.0, 0.25, 0.75, 0.3].map(|u| {
        let motion = NodeMotion { displacement: [0.0, u, 0.0], ..NodeMotion::default() };
        SceneState { nodes: BTreeMap::from([(2.into(), motion)]), ..SceneState::default() }
    });
    let results = walk(&model, &states, Velocities::Rates, &[]);
    let slopes: Vec<f64> = results.iter().map(|r| r.tangent.as_ref().unwrap().displacement[1][1]).collect();
    assert_eq!(slopes[..3], [4.0, 4.0, 0.0]);
    assert_eq!(slopes[3], 12.0);
    let kinks = |result: &ConnectorResult| -> Vec<(f64, f64, f64)> {
        let kink = |flag: &Flag| match flag {
            Flag::ForceKink { at, left, right, .. } => Some((*at, *left, *right)),
            _ => None,
        };
        result.flags.iter().filter_map(kink).collect()
    };
    // The damping table has its own row at v = 0.
    assert_eq!(kinks(&results[0]), [(0.0, 6.0, 4.0), (0.0, 1.0, 4.0)]);
    assert_eq!(kinks(&results[1]), [(0.25, 4.0, 12.0), (0.0, 1.0, 4.0)]);
    assert_eq!(kinks(&results[2]), [(0.75, 12.0, 0.0), (0.0, 1.0, 4.0)]);
    assert_eq!(kinks(&results[3]), [(0.0, 1.0, 4.0)]);
}

/// Springs return along a closed path what was put in, and their energy is what was put in.
#[test]
fn springs_return_what_was_put_in() {
    let mut numbers = Numbers(2);
    let conditions = Conditions::default();
    for law in [LAWS[0], LAWS[1], LAWS[3]] {
        let behavior = behavior(law);
        let corners: Vec<Motion<f64>> = (0..7).map(|_| numbers.motion(1.0)).collect();
        let energy = |at: &Motion<Wide>| behavior.elasticity.energy(at, &conditions).unwrap();
        let mut work = Wide::ZERO;
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let (from, to) = (exact(from), exact(to));
            // Forces are linear between rows: the trapezoidal rule is exact on pieces that meet no row inside.
            let mut cuts = vec![Wide::ZERO, Wide::integer(1)];
            for k in 0..6 {
                for row in [-0.5, 0.0, 0.25, 0.75] {
                    let t = (Wide::from_f64(row) - from.constitutive[k])
                        / (to.constitutive[k] - from.constitutive[k]);
                    if t > Wide::ZERO && t < Wide::integer(1) {
                        cuts.push(t);
                    }
                }
            }
            cuts.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let at = |t: Wide| {
                let between =
                    |a: [Wide; 6], b: [Wide; 6]| [0, 1, 2, 3, 4, 5].map(|k| a[k] + (b[k] - a[k]) * t);
                Motion {
                    position: between(from.position, to.position),
                    constitutive: between(from.constitutive, to.constitutive),
                    velocity: [Wide::ZERO; 6],
                }
            };
            let mut along = Wide::ZERO;
            for pair in cuts.windows(2) {
                let (a, b) = (at(pair[0]), at(pair[1]));
                let (fa, fb) = (
                    behavior.elasticity.forces(&a, &conditions),
                    behavior.elasticity.forces(&b, &conditions),
                );
                for k in 0..6 {
                    let force = fa.value[k].unwrap_or_default() + fb.value[k].unwrap_or_default();
                    along += force * (b.constitutive[k] - a.constitutive[k]) / 2.0;
                }
            }
            let stored = energy(&to) - energy(&from);
            assert!((along - stored).magnitude() < Wide::from_f64(WIDE), "{law}: {along:e} {stored:e}");
            work += along;
        }
        assert!(work.magnitude() < Wide::from_f64(WIDE), "{law}: {work:e}");
    }
    // An unsymmetric matrix has no energy, and says so.
    let unsymmetric = behavior(&LAWS[2].replace("DAMPING", "ELASTICITY"));
    assert!(unsymmetric.elasticity.energy(&exact(&numbers.motion(1.0)), &conditions).is_none());
}

/// The energy of a spring has the force as its derivative.
#[test]
fn energy_is_the_potential_of_the_force() {
    let mut numbers = Numbers(3);
    let conditions = Conditions::default();
    for law in [LAWS[0], LAWS[1], LAWS[3]] {
        let behavior = behavior(law);
        for _ in 0..20 {
            let motion = numbers.motion(1.0);
            let seeded: [DualSVec64<6>; 6] =
                [0, 1, 2, 3, 4, 5].map(|k| Seeded::seed(motion.constitutive[k], k));
            let zero = DualSVec64::<6>::zero();
            let moving = Motion { position: seeded, constitutive: seeded, velocity: [zero; 6] };
            let gradient = behavior.elasticity.energy(&moving, &conditions).unwrap().gradient();
            let forces = behavior.elasticity.forces(&motion, &conditions).value;
            for k in 0..6 {
                let force = forces[k].unwrap_or(0.0);
                assert!((gradient[k] - force).abs() < BEHAVIOR_SLOPE * (1.0 + force.abs()), "{law}: {k}");
            }
        }
    }
}

/// A damper whose force has the sign of the velocity takes energy up, whatever the motion.
#[test]
fn dampers_take_energy_up() {
    let mut numbers = Numbers(4);
    let conditions = Conditions::default();
    let coupled = LAWS[1].replace("ELASTICITY", "DAMPING");
    for law in [LAWS[0], &coupled, LAWS[3], LAWS[5]] {
        let behavior = behavior(law);
        for _ in 0..200 {
            let motion = numbers.motion(3.0);
            assert!(
                behavior.damping.power(&motion, &conditions) >= 0.0 || law == LAWS[5],
                "{law} {motion:?}"
            );
        }
    }
    // One that pushes at rest gives energy, and is seen.
    let law = behavior("*CONNECTOR DAMPING, COMPONENT=1, NONLINEAR\n-1., -1.\n2., 1.");
    let mut motion = numbers.motion(1.0);
    motion.velocity[0] = -0.1;
    assert!(law.damping.power(&motion, &conditions) < 0.0);
}

/// How many states of springs and dampers JAX has.
pub(crate) fn states_of_jax() -> u64 {
    let file: serde_json::Value = serde_json::from_str(include_str!("golden/behavior.json")).unwrap();
    file["cases"].as_array().unwrap().len() as u64
}

/// Independent formulas in another language.
#[test]
fn jax_agrees() {
    let file: serde_json::Value = serde_json::from_str(include_str!("golden/behavior.json")).unwrap();
    assert_eq!(file["schema"], "pintle-behavior/1");
    let cases = file["cases"].as_array().unwrap();
    assert!(cases.len() >= 39);
    for (i, case) in cases.iter().enumerate() {
        let six = |key: &str| -> [f64; 6] { serde_json::from_value(case[key].clone()).unwrap() };
        let motion = Motion {
            position: six("position"),
            constitutive: six("constitutive"),
            velocity: six("velocity"),
        };
        let conditions = Conditions { temperature: case["temperature"].as_f64(), ..Conditions::default() };
        let behavior = behavior(case["deck"].as_str().unwrap());
        for (key, forces) in [
            ("CEF", behavior.elasticity.forces(&motion, &conditions)),
            ("CVF", behavior.damping.forces(&motion, &conditions)),
        ] {
            let expected: Components<f64> = serde_json::from_value(case[key].clone()).unwrap();
            for k in 0..6 {
                match (forces.value[k], expected[k]) {
                    (None, None) => {}
                    (Some(got), Some(want)) => assert!(
                        (got - want).abs() < BEHAVIOR_JAX * (1.0 + want.abs()),
                        "{i} {key} {k}: {got} {want}"
                    ),
                    other => panic!("{i} {key} {k}: {other:?}"),
                }
            }
        }
        let slopes: Vec<Vec<f64>> = serde_json::from_value(case["slopes"].clone()).unwrap();
        let tangent = behavior.tangent(&motion, &conditions, None, [false; 6]);
        for (k, want) in slopes.iter().enumerate() {
            for (j, want) in want.iter().enumerate() {
                let got = if j < 6 { tangent.displacement[k][j] } else { tangent.velocity[k][j - 6] };
                assert!(
                    (got - want).abs() < BEHAVIOR_JAX * (1.0 + want.abs()),
                    "{i} ∂F{k}/∂{j}: {got} {want}"
                );
            }
        }
    }
}

/// Forces between 1e−300 and 1e300 neither vanish nor overflow.
#[test]
fn the_range_of_doubles_is_used() {
    for (k, x) in [(1e300, 1e-300), (1e-300, 1e300), (1e150, 1e150), (1e-150, 1e-150), (1e-300, 1.0)] {
        let law = behavior(&format!("*CONNECTOR ELASTICITY, COMPONENT=1\n{k:e}"));
        let mut motion = Numbers(5).motion(0.0);
        motion.constitutive[0] = x;
        assert_eq!(law.elasticity.forces(&motion, &Conditions::default()).value[0], Some(k * x));
    }
    let table = behavior("*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR\n-1.E-300, -1.E300\n1.E-300, 1.E300");
    let mut motion = Numbers(5).motion(0.0);
    motion.constitutive[0] = 5e299;
    assert_eq!(table.elasticity.forces(&motion, &Conditions::default()).value[0], Some(5e-301));
}

/// What depends on a temperature that is not given is not known, and said to be so; other components are.
#[test]
fn what_is_not_known_is_said() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=1\n5., , 20.\n6., , 30.\n*CONNECTOR ELASTICITY, COMPONENT=2\n5., , 20.";
    let result =
        &walk(&model(ALL_AVAILABLE, law, ""), &along_1(&[(0.0, 0.1, 0.0)]), Velocities::Rates, &[])[0];
    let outcome = result.behavior.as_ref().unwrap();
    assert_eq!(outcome.elastic.value, [None, Some(0.0), None, None, None, None]);
    let why = "it depends on the temperature, which is not given";
    assert!(
        result.flags.contains(&Flag::NotKnown { component: "u1", quantity: "CEF", why }),
        "{:?}",
        result.flags
    );
    assert_eq!(outcome.total.value[1], Some(0.0));
    assert_eq!(outcome.total.value[0], None);
}

/// Velocities from increments over time steps; not where no time has passed.
#[test]
fn velocities_may_be_increments() {
    let model = model(ALL_AVAILABLE, "*CONNECTOR DAMPING, COMPONENT=1\n8.", "");
    let states = along_1(&[(0.0, 0.0, 0.0), (0.5, 0.25, 0.0), (0.5, 0.5, 0.0), (1.5, 0.25, 0.0)]);
    let results = walk(&model, &states, Velocities::Increments, &[]);
    let force = |i: usize| results[i].behavior.as_ref().unwrap().viscous.value[0];
    assert_eq!([force(0), force(1), force(2), force(3)], [Some(0.0), Some(4.0), None, Some(-2.0)]);
    let slopes = results[1].tangent.as_ref().unwrap();
    assert_eq!((slopes.total()[0][0], slopes.time[0]), (16.0, -8.0));
    assert!(results[2].flags.iter().any(|flag| matches!(flag, Flag::NotKnown { quantity: "CVF", .. })));
    let rates = walk(&model, &along_1(&[(0.5, 0.25, 3.0)]), Velocities::Rates, &[]);
    assert_eq!(rates[0].behavior.as_ref().unwrap().viscous.value[0], Some(24.0));
}

/// A stop reached, passed, and what a given force leaves for its reaction.
#[test]
fn stops_push_and_do_not_pull() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR STOP, COMPONENT=1\n0.5, 1.5";
    let states =
        along_1(&[(0.0, 0.25, 0.0), (1.0, 0.5, 0.0), (2.0, 0.75, 0.0), (3.0, 0.5, 0.0), (4.0, -0.5, 0.0)]);
    let given = [2.5, 9.0, 9.0, 1.0, -9.0].map(|force| [Some(force), None, None, None, None, None]);
    let results = walk(&model(ALL_AVAILABLE, law, ""), &states, Velocities::Rates, &given);
    let held: Vec<_> = results.iter().map(|result| result.stops[0].unwrap()).collect();
    use StopStatus::{AtLower, AtUpper, Free};
    assert_eq!(held, [Free, AtUpper, AtUpper, AtUpper, AtLower]);
    let reaction: Vec<_> =
        results.iter().map(|result| result.behavior.as_ref().unwrap().reaction.value[0].unwrap()).collect();
    assert_eq!(reaction, [0.0, 4.0, 1.5, -4.0, -4.0]);
    assert!(results[0].flags.is_empty() && results[1].flags.iter().all(|flag| flag.component() != "u1"));
    assert!(results[2].flags.contains(&Flag::BeyondStop { component: "u1", by: 0.25 }));
    assert!(results[3].flags.contains(&Flag::StopPulls { component: "u1", reaction: -4.0 }));
    // Nothing tells the reaction without a force.
    let unknown = walk(&model(ALL_AVAILABLE, law, ""), &states, Velocities::Rates, &[]);
    let outcome = unknown[1].behavior.as_ref().unwrap();
    assert_eq!(
        (outcome.reaction.value[0], outcome.total.value[0], outcome.elastic.value[0]),
        (None, None, Some(5.0))
    );
    // A free component balances, or the difference is told.
    let wrong = walk(
        &model(ALL_AVAILABLE, law, ""),
        &states[..1],
        Velocities::Rates,
        &[[Some(3.5), None, None, None, None, None]],
    );
    assert!(wrong[0].flags.contains(&Flag::OutOfBalance { component: "u1", by: 1.0 }));
}

/// A lock closes at the state that passes its limit, keeps that position, and never opens.
#[test]
fn locks_are_permanent() {
    for (law, locked) in [
        ("*CONNECTOR LOCK, COMPONENT=1, LOCK=1\n, 1.5", [true, false, false]),
        ("*CONNECTOR LOCK, COMPONENT=1\n, 1.5", [true, true, true]),
        (
            "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR LOCK, COMPONENT=1, LOCK=2\n, , , 5.",
            [false, true, false],
        ),
    ] {
        let states = along_1(&[(0.0, 0.25, 0.0), (1.0, 0.75, 0.0), (2.0, 0.5, 0.0), (3.0, -0.75, 0.0)]);
        let results = walk(&model(ALL_AVAILABLE, law, ""), &states, Velocities::Rates, &[]);
        let outcome = |i: usize| results[i].behavior.as_ref().unwrap();
        assert_eq!(outcome(0).locked, [false; 6], "{law}");
        for i in 1..4 {
            assert_eq!(outcome(i).locked[..3], locked, "{law}");
        }
        assert_eq!(outcome(1).history, {
            let mut h = outcome(3).history.clone();
            h.time = outcome(1).history.time;
            h.displacement = outcome(1).history.displacement;
            h
        });
        if locked[0] {
            assert_eq!(results[1].stops[0], Some(StopStatus::Locked));
            let residual: Vec<_> = results.iter().map(|result| result.evaluation.residual[0]).collect();
            assert_eq!(residual, [None, Some(0.0), Some(-0.25), Some(-1.5)], "{law}");
        }
        let events =
            results.iter().map(|r| r.flags.iter().filter(|f| matches!(f, Flag::Locked { .. })).count());
        assert!(events.eq([0, 1, 0, 0]), "{law}");
    }
}

/// A force limit on a constrained component asks for its reaction: given, it locks; not given, that is said.
#[test]
fn constrained_forces_may_lock() {
    let law = "*CONNECTOR LOCK, COMPONENT=2, LOCK=1\n, , -5., 5.";
    let model = model("SLOT", law, "");
    let states = along_1(&[(0.0, 0.25, 0.0), (1.0, 0.5, 0.0)]);
    let force = |f: f64| [None, Some(f), Some(0.0), None, None, None];
    let results = walk(&model, &states, Velocities::Rates, &[force(4.0), force(-6.0)]);
    assert!(!results[0].behavior.as_ref().unwrap().locked[0]);
    assert!(results[1].behavior.as_ref().unwrap().locked[0]);
    assert_eq!(results[1].behavior.as_ref().unwrap().reaction.value[1], Some(-6.0));
    let unknown = walk(&model, &states, Velocities::Rates, &[]);
    assert!(
        unknown[1]
            .flags
            .iter()
            .any(|flag| matches!(flag, Flag::Undecided { criterion: "lock", component: "u2", .. }))
    );
}

/// The forces of what failed vanish at the state that fails, and stay away.
#[test]
fn failures_release() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR ELASTICITY, COMPONENT=2\n3.\n";
    let states = along_1(&[(0.0, 0.25, 0.0), (1.0, 0.75, 0.0), (2.0, 0.5, 0.0)]);
    for (failure, failed) in [
        ("*CONNECTOR FAILURE, COMPONENT=1, RELEASE=1\n, 1.5", [true, false]),
        ("*CONNECTOR FAILURE, COMPONENT=1\n, , , 5.", [true, true]),
        ("*CONNECTOR FAILURE, COMPONENT=1, RELEASE=2\n, , , 5.", [false, true]),
    ] {
        let model = model(ALL_AVAILABLE, &format!("{law}{failure}"), "");
        let results = walk(&model, &states, Velocities::Rates, &[]);
        let outcome = |i: usize| results[i].behavior.as_ref().unwrap();
        assert_eq!(outcome(0).total.value[0], Some(2.5), "{failure}");
        for i in 1..3 {
            assert_eq!(outcome(i).failed[..2], failed, "{failure}");
            let expected = if failed[0] { 0.0 } else { 10.0 * [0.0, 0.75, 0.5][i] };
            assert_eq!(outcome(i).total.value[0], Some(expected), "{failure}");
            let slope = results[i].tangent.as_ref().unwrap().displacement[0][0];
            assert_eq!(slope, if failed[0] { 0.0 } else { 10.0 }, "{failure}");
        }
    }
}

/// In Standard what is constrained is not released; in Explicit it is.
#[test]
fn solvers_release_differently() {
    let law = "*CONNECTOR FAILURE, COMPONENT=1\n, 1.2";
    let states = along_1(&[(0.0, 0.25, 0.0)]);
    for (step, expected) in [
        ("*STEP\n*STATIC\n1., 1.\n*END STEP\n", [true, false, false]),
        ("*STEP\n*DYNAMIC, EXPLICIT\n, 1.\n*END STEP\n", [true, true, true]),
    ] {
        let results = walk(&model("SLOT", law, step), &states, Velocities::Rates, &[]);
        assert_eq!(results[0].behavior.as_ref().unwrap().failed[..3], expected, "{step}");
    }
}

/// Motions: ramps, amplitudes, what is held, from step to step.
#[test]
fn motions_prescribe() {
    let steps = "*STEP\n*STATIC\n0.1, 2.\n*CONNECTOR MOTION\n7, 1, 4.\n*CONNECTOR MOTION, AMPLITUDE=WAVE\n7, 2, 0.5\n*END STEP\n\
                 *STEP\n*STATIC\n0.1, 1.\n*CONNECTOR MOTION\n7, 1, 6.\n*END STEP\n\
                 *STEP\n*STATIC\n0.1, 1.\n*CONNECTOR MOTION, OP=NEW, FIXED\n7, 1\n*CONNECTOR MOTION, OP=NEW, TYPE=VELOCITY\n7, 3, 5.\n*END STEP\n";
    let model = model(ALL_AVAILABLE, "*CONNECTOR DAMPING, COMPONENT=6\n0.", steps);
    let states = along_1(&[
        (0.0, 0.0, 2.0),
        (1.0, 2.5, 2.0),
        (2.0, 4.0, 2.0),
        (2.5, 5.0, 2.0),
        (3.5, 6.0, 0.0),
        (5.0, 6.0, 0.0),
    ]);
    let results = walk(&model, &states, Velocities::Rates, &[]);
    let driven =
        |i: usize, k: usize| results[i].behavior.as_ref().unwrap().prescribed[k].and_then(|p| p.value().1);
    assert_eq!([0, 1, 2, 3, 4].map(|i| driven(i, 0)), [0.0, 2.0, 4.0, 5.0, 6.0].map(Some));
    // WAVE: 2 at 1, 0 at 2, where it stays in the step after it; OP=NEW ends it.
    assert_eq!([0, 1, 2, 3, 4].map(|i| driven(i, 1)), [Some(0.0), Some(1.0), Some(0.0), Some(0.0), None]);
    assert_eq!([3, 4].map(|i| driven(i, 2)), [None, Some(5.0)]);
    let residual: Vec<_> = results.iter().map(|result| result.evaluation.residual[0]).collect();
    assert_eq!(residual[..5], [Some(0.0), Some(0.5), Some(0.0), Some(0.0), Some(0.0)]);
    let rate: Vec<_> = results.iter().map(|result| result.evaluation.residual_rate[0]).collect();
    assert_eq!(rate[..5], [Some(0.0), Some(0.0), Some(0.0), Some(0.0), Some(0.0)]);
    // After the steps it is not known.
    assert_eq!(driven(5, 0), None);
    assert!(
        results[5]
            .flags
            .iter()
            .any(|flag| matches!(flag, Flag::NotKnown { quantity: "DRIVEN", component: "u1", .. }))
    );
}

/// A motion held from the beginning of a step counts from the displacement there.
#[test]
fn held_motions_start_where_the_component_is() {
    let steps = "*STEP\n*STATIC\n0.1, 1.\n*END STEP\n*STEP\n*STATIC\n0.1, 1.\n*CONNECTOR MOTION, FIXED\n7, 1\n*END STEP\n";
    let damper = "*CONNECTOR DAMPING, COMPONENT=6\n0.";
    let model = model(ALL_AVAILABLE, damper, steps);
    let results = walk(&model, &along_1(&[(1.0, 0.3, 0.0), (1.5, 0.4, 0.0)]), Velocities::Rates, &[]);
    assert!((results[1].evaluation.residual[0].unwrap() - 0.1).abs() < 1e-15);
    let unknown = walk(&model, &along_1(&[(0.9, 0.3, 0.0), (1.5, 0.4, 0.0)]), Velocities::Rates, &[]);
    let why = "it counts from the beginning of a step, and no state was given there";
    assert!(unknown[1].flags.contains(&Flag::NotKnown { component: "u1", quantity: "DRIVEN", why }));
}

/// Loads: CCF drives, CTF resists; ramps, and what follows them.
#[test]
fn loads_act() {
    let steps = "*STEP\n*STATIC\n0.1, 2.\n*CONNECTOR LOAD\n7, 1, 4.\n*END STEP\n\
                 *STEP\n*STATIC\n0.1, 2.\n*CONNECTOR LOAD, OP=NEW, AMPLITUDE=WAVE\n7, 2, 1.\n*END STEP\n\
                 *STEP\n*DYNAMIC\n0.1, 2.\n*CONNECTOR LOAD\n7, 1, 7.\n*END STEP\n";
    let model = model(ALL_AVAILABLE, "*CONNECTOR ELASTICITY, COMPONENT=1\n2.", steps);
    let states = along_1(&[
        (0.0, 0.0, 0.0),
        (1.0, 1.0, 0.0),
        (2.0, 2.0, 0.0),
        (3.0, 1.0, 0.0),
        (4.0, 0.0, 0.0),
        (5.0, 3.5, 0.0),
    ]);
    let results = walk(&model, &states, Velocities::Rates, &[]);
    let outcome = |i: usize| results[i].behavior.as_ref().unwrap();
    assert_eq!(
        [0, 1, 2, 3, 4, 5].map(|i| outcome(i).load.value[0]),
        [0.0, 2.0, 4.0, 2.0, 0.0, 7.0].map(Some)
    );
    // WAVE is at 2 after one time unit of the step, and at 0 after two, where it stays.
    assert_eq!([3, 4, 5].map(|i| outcome(i).load.value[1]), [Some(2.0), Some(0.0), Some(0.0)]);
    // The spring balances the load.
    assert_eq!([0, 1, 2, 3, 4, 5].map(|i| outcome(i).total.value[0]), [Some(0.0); 6]);
}

/// A history continued from a file is the uninterrupted one, and belongs to its behaviour.
#[test]
fn a_restored_history_continues() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR DAMPING, COMPONENT=1\n3.\n*CONNECTOR LOCK, COMPONENT=1, LOCK=2\n, 1.5\n\
               *CONNECTOR FAILURE, COMPONENT=1, RELEASE=1\n0.3\n";
    let model = model(ALL_AVAILABLE, law, "");
    let plan = Plan::compile(&model, &Selection::All, request(["ALL"], 1).unwrap()).unwrap();
    let mut numbers = Numbers(6);
    let states: Vec<SceneState> = (0..40)
        .map(|i| {
            let motion = NodeMotion {
                displacement: [0.9 * numbers.next(), numbers.next(), 0.0],
                rotation: Rotation::Vector([numbers.next(), numbers.next(), numbers.next()]),
                ..NodeMotion::default()
            };
            SceneState {
                time: Some(f64::from(i) / 8.0),
                nodes: BTreeMap::from([(2.into(), motion)]),
                ..SceneState::default()
            }
        })
        .collect();
    let text = |sequence: &mut Sequence<'_>, states: &[SceneState]| -> Vec<String> {
        let one = |state| {
            let result = sequence.step(state).connectors.remove(0);
            format!("{:?} {:?} {:?} {:?}", result.behavior, result.flags, result.evaluation, result.tangent)
        };
        states.iter().map(one).collect()
    };
    let mut whole = Sequence::new(&model, &plan);
    whole.set_velocities(Velocities::Increments);
    let expected = text(&mut whole, &states);
    let mut begun = Sequence::new(&model, &plan);
    begun.set_velocities(Velocities::Increments);
    let mut got = text(&mut begun, &states[..17]);
    let saved = serde_json::to_string(&begun.branches()).unwrap();
    let branches: Branches = serde_json::from_str(&saved).unwrap();
    assert_eq!(branches.check(&model, &plan), Ok(()));
    let mut rest = Sequence::resume(&model, &plan, branches.clone());
    rest.set_velocities(Velocities::Increments);
    got.extend(text(&mut rest, &states[17..]));
    assert_eq!(got, expected);
    assert!(expected.last().unwrap().contains("failed: [true"), "the failure was never met");
    let other = self::model(ALL_AVAILABLE, &law.replace("10.", "11."), "");
    let plan = Plan::compile(&other, &Selection::All, Request::everything(0)).unwrap();
    assert!(branches.check(&other, &plan).unwrap_err().contains("another behaviour"));
}

/// An output that is not asked for is not computed, and a connector without behaviour pays nothing.
#[test]
fn unused_behaviour_costs_nothing() {
    let model = model(ALL_AVAILABLE, LAWS[0], "");
    let work = |names: &[&str], order| {
        let plan =
            Plan::compile(&model, &Selection::All, request(names.iter().copied(), order).unwrap()).unwrap();
        let mut sequence = Sequence::new(&model, &plan);
        sequence.step(&along_1(&[(0.0, 0.3, 0.0)])[0]);
        sequence.tally()
    };
    let spring = self::model(ALL_AVAILABLE, "*CONNECTOR ELASTICITY, COMPONENT=1\n10.", "");
    let plan = Plan::compile(&spring, &Selection::All, request(["CU1"], 1).unwrap()).unwrap();
    let mut sequence = Sequence::new(&spring, &plan);
    let result = sequence.step(&along_1(&[(0.0, 0.3, 0.0)])[0]).connectors.remove(0);
    assert!(result.behavior.is_none());
    assert_eq!(sequence.tally(), Tally { values: 1, gradients: 1, ..Tally::default() });
    // Derivatives are taken of what is named alone.
    assert_eq!(work(&["CEF1"], 1).gradients, 1);
    assert_eq!(work(&["CEF1"], 0).gradients, 0);
}

/// A scene of the gallery, and everything of it that is planned, with its states.
fn of_gallery(name: &str) -> (Model, Plan, Vec<SceneState>) {
    let example = GALLERY.iter().find(|example| example.name == name).unwrap();
    let scene = example.scene().unwrap();
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, request(["ALL"], 0).unwrap()).unwrap();
    (model, plan, example.states(&scene).unwrap().states)
}

/// The known solution of the belt: tension 992.1 in both segments, 19.84 at the drum, and every free degree of freedom in balance.
#[test]
fn the_belt_is_in_equilibrium() {
    let (model, plan, states) = of_gallery("seat_belt");
    let mut sequence = Sequence::new(&model, &plan);
    let mut last = Vec::new();
    for state in &states {
        last = sequence.step(state).connectors;
    }
    let state = states.last().unwrap();
    let mut residual: BTreeMap<(String, usize), f64> = BTreeMap::new();
    for result in &last {
        let element = &model.connectors[result.index];
        let outcome = result.behavior.as_ref().unwrap();
        let mut forces = outcome.total.value;
        match element.label.to_string().as_str() {
            "101" => assert!((forces[3].unwrap() - 19.8425).abs() < 1e-4),
            // The drum's multiplier is what the belt leaves for it, T = β_s |m3|; it acts on a, against its sense on b.
            "102" => forces[5] = Some(-992.125_496 / 50.0),
            _ => assert!((forces[0].unwrap() - 992.1255).abs() < 1e-3, "{forces:?}"),
        }
        let node = |end: usize| {
            let motion =
                element.nodes[end].and_then(|label| state.nodes.get(&label)).copied().unwrap_or_default();
            let Rotation::Vector(phi) = motion.rotation else { panic!("a rotation vector") };
            Node {
                displacement: motion.displacement,
                triad: vector::product(&so3::matrix(so3::exp_quaternion(phi)), element.triads()[end]),
                flow: motion.flow,
            }
        };
        let pair = Pair { reference: element.reference, a: node(0), b: node(1) };
        let state = State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let rows = element.connector.force_rows(
            &state,
            &result.evaluation.branch,
            [true; 6],
            Want::default(),
            &mut Tally::default(),
        );
        for (j, force) in rows.nodal(&forces).into_iter().enumerate() {
            if let Some(label) = element.nodes[j / 7] {
                *residual.entry((label.to_string(), j % 7)).or_default() += force;
            }
        }
    }
    // Free: the spin of the drum about z, and the flow at the exit and at the ring.
    for free in [("1", 5), ("10", 6), ("20", 6)] {
        let rest = residual[&(free.0.to_string(), free.1)];
        assert!(rest.abs() < BELT_BALANCE * 992.0, "{free:?}: {rest}");
    }
}

/// The crank follows its motion, and the guide rubs: what friction leaves open is not given as zero.
#[test]
fn the_slider_crank_is_driven() {
    let (model, plan, states) = of_gallery("slider_crank");
    let mut sequence = Sequence::new(&model, &plan);
    for state in &states {
        let results = sequence.step(state).connectors;
        let drive = &results[0];
        // The deck gives 2π as 6.283185307.
        assert!(drive.evaluation.residual[3].unwrap().abs() < 2e-10);
        assert!(drive.evaluation.residual_rate[3].unwrap().abs() < 2e-10);
        assert!(drive.behavior.as_ref().unwrap().prescribed[3].is_some());
    }
}

/// The pendulum turns on where its stop would hold it: that is told, with how far.
#[test]
fn the_pendulum_passes_its_stop() {
    let (model, plan, states) = of_gallery("hinge_pendulum");
    let mut sequence = Sequence::new(&model, &plan);
    let mut beyond = 0;
    for state in &states {
        for result in sequence.step(state).connectors {
            let turned = result.evaluation.position[3];
            beyond += result
                .flags
                .iter()
                .filter(|flag| matches!(flag, Flag::BeyondStop { by, .. } if Some(3.2 + by).is_some_and(|at| (at - turned.unwrap().abs()).abs() < 1e-12)))
                .count();
            let outcome = result.behavior.as_ref().unwrap();
            if result.index == 0 {
                assert_eq!(outcome.viscous.value[3], Some(0.0));
            }
        }
    }
    assert!(beyond > 10, "{beyond}");
}
