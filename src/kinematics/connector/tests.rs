//! Tests that look inside.

use crate::connector::*;
use crate::node;
use crate::scalar::{Scalar, Seeded};
use crate::vector::{column, scale, sub};
use num_dual::Dual2SVec64;

fn pair(seed: f64) -> Pair<f64> {
    let triad = |a: f64, b: f64, c: f64| so3::matrix(so3::exp_quaternion([a, b, c]));
    Pair {
        reference: [1.0 + seed, 0.3, -0.7],
        a: node::Node { displacement: [0.1, 0.2 * seed, 0.3], triad: triad(0.3, -0.5, seed), flow: 0.1 },
        b: node::Node { displacement: [0.4, -0.2, 0.5], triad: triad(-0.2 * seed, 0.6, 0.9), flow: 0.02 },
    }
}

/// The relative variations and nodal maps against fourteen-seed differentiation of the same measures.
#[test]
fn nodal_maps_equal_naive_seeding() {
    let mut compared = 0;
    for entry in crate::catalog::TABLE {
        let initial = pair(0.2);
        let definition = Definition { flow_scale: 50.0, ..Definition::new(entry.clone(), initial) };
        let connector = Connector::<f64>::new(&definition);
        let mut state = State { pair: pair(0.25), velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        state.pair.reference = initial.reference;
        let branch = connector.initial_branch();
        let mut tally = Tally::default();
        let request = Request::new(&[], [true; 6], 2);
        let evaluation = connector.evaluate(&state, &Increment::none(), &branch, &request, &mut tally);
        type Naive = Dual2SVec64<14>;
        let zero = <Naive as Scalar>::zero();
        let dofs = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13].map(|i| zero + Naive::seed(0.0, i));
        let moved = state.pair.moved(&dofs).relative();
        let history = branch.history();
        let mut shared = Shared::new(&moved, &state.pair.a.triad, &connector.kind.section, &history);
        for k in 0..6 {
            let Some(measure) = connector.differentiated(k) else { continue };
            if measure.is_one_form() {
                continue;
            }
            let naive = measure.evaluate(&mut shared);
            let (row, hessian) = (evaluation.jacobian[k].unwrap(), evaluation.hessian[k].as_ref().unwrap());
            for i in 0..DOFS {
                if !connector.active()[i] {
                    continue;
                }
                assert!((naive.gradient()[i] - row[i]).abs() < 1e-14, "{} {k} {i}", entry.name);
                for j in 0..DOFS {
                    if connector.active()[j] {
                        let difference = naive.hessian()[i][j] - hessian[i][j];
                        assert!(difference.abs() < 1e-13, "{} {k} {i} {j}: {difference:e}", entry.name);
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 14_000, "{compared}");
}

/// The short way gives the numbers of the long one, also where degrees of freedom are fixed, and leaves alone what is not wanted.
#[test]
fn linearized_is_evaluated() {
    let free = |entry: &Arc<ConnectionType>| Definition {
        flow_scale: 50.0,
        ..Definition::new(entry.clone(), pair(0.2))
    };
    let alterations: [fn(&mut Definition); 3] = [
        |_| {},
        |definition| definition.moves = [false, true],
        |definition| definition.rotates = [true, false],
    ];
    let mut compared = 0;
    for entry in crate::catalog::TABLE {
        let entry = Arc::new(entry.clone());
        for alter in alterations {
            let mut definition = free(&entry);
            alter(&mut definition);
            let connector = Connector::<f64>::new(&definition);
            let mut state = State { pair: pair(0.25), velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
            state.pair.reference = definition.initial.reference;
            let branch = connector.advance(&state, &Increment::none(), &connector.initial_branch());
            let request = Request::new(&[Output::CP, Output::RES], [true; 6], 1);
            let found = connector.evaluate_on(&state, branch, &request, &mut Tally::default());
            for wanted in [[true; 6], [false, true, false, true, true, false]] {
                let mut rows = [Linear::default(); 6];
                let count = connector.linearize(&state.pair, &branch, wanted, &mut rows);
                let values = connector.values(&state.pair, &branch, wanted);
                let components: Vec<usize> =
                    (0..6).filter(|k| wanted[*k] && connector.differentiated(*k).is_some()).collect();
                let of_rows: Vec<usize> = rows[..count].iter().map(|row| row.component).collect();
                assert_eq!(of_rows, components, "{}", entry.name);
                for row in &rows[..count] {
                    let k = row.component;
                    assert_eq!(Some(row.row), found.jacobian[k], "{} {k}", entry.name);
                    assert_eq!(Some(row.value), values[k], "{} {k}", entry.name);
                    let fixed = row.row.iter().zip(connector.active()).filter(|(_, active)| !**active);
                    assert!(fixed.map(|(part, _)| *part).all(|part| part == 0.0), "{} {k}", entry.name);
                    if connector.differentiated(k) == connector.position_measure(k) {
                        assert_eq!(Some(row.value), found.position[k], "{} {k}", entry.name);
                    } else {
                        assert_eq!(Some(row.value), found.residual[k], "{} {k}", entry.name);
                    }
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

/// A node b that turns, from the initial state, by `angle` about a global axis, whole turns included.
fn turned(name: &str, of_b: [f64; 3], axis: [f64; 3], angle: f64) -> (Evaluation<f64>, Vec<Flag>) {
    let still = |triad| node::Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let triad = so3::matrix(so3::exp_quaternion(of_b));
    let initial = Pair { reference: [0.0; 3], a: still(vector::identity()), b: still(triad) };
    let connection = ConnectionType::named(name, None).unwrap();
    let connector = Connector::<f64>::new(&Definition::new(connection, initial));
    let turn = scale(axis, angle);
    let principal = so3::log_quaternion(so3::exp_quaternion(turn));
    let zero = [0.0; 3];
    let increment =
        Increment { rotation: [zero, turn], whole_turns: [zero, sub(turn, principal)], flow: [0.0; 2] };
    let b = still(vector::product(&so3::matrix(so3::exp_quaternion(turn)), &triad));
    let state = State { pair: Pair { b, ..initial }, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
    let branch = connector.initial_branch();
    let request = Request::everything(0);
    let evaluation = connector.evaluate(&state, &increment, &branch, &request, &mut Tally::default());
    let margins = connector.margins(&state, &evaluation.branch, [true; 6]);
    let flags = connector.flags(&margins, &increment, &state, &branch, &evaluation.branch);
    (evaluation, flags)
}

/// The turns of torsion are uncertain after nearly half a turn, also where no component is a torsion, and certain when told.
#[test]
fn uncertain_torsion_is_told() {
    let nearly_half = 0.95 * std::f64::consts::PI;
    for (name, count) in [("PROJECTION CARTESIAN", 3), ("PROJECTION FLEXION-TORSION", 3), ("BUSHING", 6)] {
        for (angle, expected) in [(0.5, 0), (nearly_half, count), (std::f64::consts::TAU + 0.5, 0)] {
            let (_, flags) = turned(name, [0.3, 0.0, 0.0], [0.0, 0.0, 1.0], angle);
            assert_eq!(flags.len(), expected, "{name} {angle}: {flags:?}");
        }
    }
}

/// Whole turns about the axis of one angle advance that angle alone, however far from square the axes are.
#[test]
fn whole_turns_go_to_the_angle_they_are_about() {
    let angle = 3.0 * std::f64::consts::TAU + 0.1;
    for tilt in [0.01, 0.6, 1.2] {
        for (name, of_b, axis) in
            [("CARDAN", [0.0, tilt, 0.0], [1.0, 0.0, 0.0]), ("EULER", [tilt, 0.0, 0.0], [0.0, 0.0, 1.0])]
        {
            let (evaluation, flags) = turned(name, of_b, axis, angle);
            let [_, _, _, first, _, third] = evaluation.displacement;
            assert!((first.unwrap() - angle).abs() < 1e-9, "{name} {tilt}: {first:?}");
            assert!(third.unwrap().abs() < 1e-9, "{name} {tilt}: {third:?}");
            assert_eq!(flags, []);
            // About e3b, carried by b itself.
            let own = column(&so3::matrix(so3::exp_quaternion(of_b)), 2);
            let (evaluation, _) = turned(name, of_b, own, angle);
            let [_, _, _, first, _, third] = evaluation.displacement;
            assert!((third.unwrap() - angle).abs() < 1e-9, "{name} {tilt}: {third:?}");
            assert!(first.unwrap().abs() < 1e-9, "{name} {tilt}: {first:?}");
        }
    }
}

/// Whole turns about no axis of the joint, and a rotation vector that may have gone either way round, are told.
#[test]
fn uncertain_turns_are_flagged() {
    let large = |flags: Vec<Flag>| flags.iter().any(|flag| matches!(flag, Flag::LargeIncrement { .. }));
    let tau = std::f64::consts::TAU;
    assert!(large(turned("REVOLUTE", [0.0; 3], [0.8, 0.6, 0.0], tau + 0.1).1));
    assert!(!large(turned("REVOLUTE", [0.0; 3], [1.0, 0.0, 0.0], tau + 0.1).1));
    assert!(large(turned("ROTATION", [0.0; 3], [0.8, 0.6, 0.0], 3.0).1));
    assert!(!large(turned("ROTATION", [0.0; 3], [0.8, 0.6, 0.0], 2.0).1));
}

/// A half turn told by rotation vectors beyond π is certain; the same change of quaternions is not.
#[test]
fn told_increments_are_certain() {
    let large = |flags: Vec<Flag>| flags.iter().any(|flag| matches!(flag, Flag::LargeIncrement { .. }));
    assert!(!large(turned("REVOLUTE", [0.0; 3], [1.0, 0.0, 0.0], 3.2).1));
    assert!(large(turned("REVOLUTE", [0.0; 3], [1.0, 0.0, 0.0], 3.1).1));
}

/// The state of a FLOW-CONVERTER whose drum a turns by `of_a` while b turns by `of_b`, and its flags.
fn drum(of_a: Vector<f64>, of_b: Vector<f64>) -> (f64, Vec<Flag>) {
    let still = |triad| node::Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let initial = Pair { reference: [0.0; 3], a: still(vector::identity()), b: still(vector::identity()) };
    let connection = ConnectionType::named("FLOW-CONVERTER", None).unwrap();
    let connector = Connector::<f64>::new(&Definition::new(connection, initial));
    let turn = |by| still(so3::matrix(so3::exp_quaternion(by)));
    let pair = Pair { a: turn(of_a), b: turn(of_b), ..initial };
    let state = State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
    let increment = Increment { rotation: [of_a, of_b], ..Increment::none() };
    let before = connector.initial_branch();
    let after = connector.advance(&state, &increment, &before);
    (after.accumulated, connector.flags(&[None; 6], &increment, &state, &before, &after))
}

/// Where a node turns too far, it is the node that is named, and not the component that follows it.
#[test]
fn the_node_that_turned_is_named() {
    for (of_a, of_b, node) in [(3.0, 0.2, Turned::NodeA), (-0.4, -3.0, Turned::NodeB)] {
        let (_, flags) = drum([0.0, 0.0, of_a], [0.0, 0.0, of_b]);
        let [Flag::LargeIncrement { component: "ur3", of, change }] = flags[..] else { panic!("{flags:?}") };
        assert_eq!((of, change), (node, 3.0));
    }
}

/// A drum that spins about its own axis accumulates its angle. One that tips while b turns depends on the path. The flag tells by
/// how much: mean direction (sin 1.5)/1.5 against the midpoint's cos 0.75.
#[test]
fn a_tipping_drum_is_path_dependent() {
    let (spun, flags) = drum([0.0, 0.0, 1.5], [0.0; 3]);
    assert!((spun - 1.5).abs() < 1e-15 && flags.is_empty(), "{spun} {flags:?}");
    let (tipped, flags) = drum([1.5, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert!((tipped + 0.75f64.cos()).abs() < 1e-15, "{tipped}");
    let [Flag::PathDependent { component: "ur3", difference }] = flags[..] else { panic!("{flags:?}") };
    assert!((difference - (0.75f64.cos() - 1.5f64.sin() / 1.5)).abs() < 1e-9, "{difference}");
}

/// A two-dimensional connector tells when its nodes leave the plane.
#[test]
fn leaving_the_plane_is_told() {
    let still = |displacement, by| node::Node {
        displacement,
        triad: so3::matrix(so3::exp_quaternion(by)),
        flow: 0.0,
    };
    let initial =
        Pair { reference: [1.0, 0.0, 0.0], a: still([0.0; 3], [0.0; 3]), b: still([0.0; 3], [0.0; 3]) };
    let connection = ConnectionType::named("SLOT", None).unwrap();
    let definition = Definition { planar: true, ..Definition::new(connection, initial) };
    let connector = Connector::<f64>::new(&definition);
    let flags = |b, spin: f64| {
        let mut state = State { pair: initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        state.pair.b = b;
        state.velocity[node::THETA_A] = spin;
        let branch = connector.initial_branch();
        let found = connector.flags(&[None; 6], &Increment::none(), &state, &branch, &branch);
        found.iter().map(Flag::component).collect::<Vec<_>>()
    };
    assert!(flags(still([0.2, 0.3, 0.0], [0.0, 0.0, 2.5]), 0.0).is_empty());
    assert_eq!(flags(still([0.0, 0.0, 0.5], [0.0; 3]), 0.0), ["u3"]);
    assert_eq!(flags(still([0.0; 3], [0.0, 0.3, 0.0]), 0.0), ["ur2"]);
    assert_eq!(flags(still([0.0; 3], [0.0; 3]), 0.7), ["ur1"]);
}

/// What is flagged does not change with the unit of length.
#[test]
fn lengths_are_flagged_alike_in_every_unit() {
    for unit in [1e-9, 1e-3, 1.0, 1e3] {
        for (gap, flagged) in [(1e-6, false), (1e-10, true)] {
            let mut pair = pair(0.0);
            pair.a.displacement = scale([0.3, 0.4, 0.5], unit);
            pair.b.displacement = scale([0.3 + gap, 0.4, 0.5], unit);
            pair.reference = [0.0; 3];
            let connection = ConnectionType::named("AXIAL", None).unwrap();
            let connector = Connector::<f64>::new(&Definition::new(connection, pair));
            let state = State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
            let branch = connector.initial_branch();
            let margins = connector.margins(&state, &branch, [true; 6]);
            let flags = connector.flags(&margins, &Increment::none(), &state, &branch, &branch);
            assert_eq!(!flags.is_empty(), flagged, "{unit} {gap}");
        }
    }
}

/// At the lock the angles still compose to the rotation, and the passage loses neither turn nor sheet.
#[test]
fn angles_pass_the_lock() {
    let product = |p: [f64; 3], q: [f64; 3], r: [f64; 3]| {
        let [p, q, r] = [p, q, r].map(|v| so3::matrix(so3::exp_quaternion(v)));
        vector::product(&vector::product(&p, &q), &r)
    };
    let cardan = |[a, b, c]: [f64; 3]| product([a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]);
    let euler = |[a, b, c]: [f64; 3]| product([0.0, 0.0, a], [b, 0.0, 0.0], [0.0, 0.0, c]);
    let right = std::f64::consts::FRAC_PI_2;
    type Rotation<'a> = &'a dyn Fn([f64; 3]) -> vector::Matrix<f64>;
    let paths: [(&str, Rotation<'_>, [[f64; 3]; 4]); 4] = [
        ("EULER", &euler, [[3.0, 0.4, 0.4], [3.1, 0.2, 0.5], [3.1, 0.0, 0.6], [3.3, -0.2, 0.7]]),
        ("EULER", &euler, [[0.7, 2.7, 3.0], [0.7, 3.0, 3.0], [0.7, 2.0 * right, 3.1], [0.8, 3.3, 3.2]]),
        ("CARDAN", &cardan, [[3.0, 1.2, 0.2], [3.1, 1.4, 0.2], [3.1, right, 0.3], [3.3, 1.4, 0.4]]),
        ("CARDAN", &cardan, [[0.4, -1.2, -3.0], [0.5, -1.4, -3.1], [0.5, -right, -3.1], [0.6, -1.4, -3.3]]),
    ];
    for (name, rotation, states) in paths {
        let still = |triad| node::Node { displacement: [0.0; 3], triad, flow: 0.0 };
        let initial =
            Pair { reference: [0.0; 3], a: still(vector::identity()), b: still(rotation(states[0])) };
        let connection = ConnectionType::named(name, None).unwrap();
        let connector = Connector::<f64>::new(&Definition::new(connection, initial));
        let mut branch = connector.initial_branch();
        for angles in states {
            let pair = Pair { b: still(rotation(angles)), ..initial };
            let state = State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
            let request = Request::everything(0);
            let increment = Increment::none();
            let found = connector.evaluate(&state, &increment, &branch, &request, &mut Tally::default());
            for k in 0..3 {
                let angle = found.position[3 + k].unwrap();
                assert!((angle - angles[k]).abs() < 1e-12, "{name} {angles:?}: {:?}", found.position);
            }
            branch = found.branch;
        }
    }
}
