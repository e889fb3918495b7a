//! Arrays of states give the numbers of a walk through the same states, in every form of rotations, for any number of threads.

use super::{chain, model};
use crate::tolerance;
use pintle_kinematics::connector::{Output, Request, Tally};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::U;
use pintle_kinematics::so3;
use pintle_model::evaluate::{
    ArrayError, ArrayWalk, ByNode, Item, Model, Motions, NodeArrays, Numbers, Plan, Rotations, Selection,
    Sequence, evaluate_arrays,
};
use pintle_report::{Value, value_of};
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Motions of all nodes about no fixed axis, some of them with whole turns.
fn history(states: u64, nodes: usize) -> Vec<State> {
    (0..states)
        .map(|number| {
            let mut state = chain::state(number, nodes);
            for (label, motion) in &mut state.nodes {
                if label.number().is_multiple_of(4) {
                    let t = number as f64 * 0.3;
                    motion.rotation = Rotation::Vector([1.1 * t, -0.7 * t * t, 0.4 + 2.0 * t]);
                }
            }
            state
        })
        .collect()
}

/// Arrays that hold what states do.
struct Held {
    nodes: Vec<Label>,
    three: BTreeMap<&'static str, Vec<f64>>,
    quaternions: Vec<f64>,
    flow: [Vec<f64>; 3],
    times: Vec<f64>,
}

impl Held {
    fn of(states: &[State]) -> Self {
        let nodes: Vec<Label> = states[0].nodes.keys().copied().collect();
        let motions = || states.iter().flat_map(|state| state.nodes.values());
        let vector = |motion: &NodeMotion| match motion.rotation {
            Rotation::Vector(vector) => vector,
            Rotation::Quaternion(_) => unreachable!(),
        };
        let three = BTreeMap::from([
            ("u", motions().flat_map(|motion| motion.displacement).collect()),
            ("vector", motions().flat_map(vector).collect()),
            ("v", motions().flat_map(|motion| motion.velocity).collect()),
            ("w", motions().flat_map(|motion| motion.angular_velocity).collect()),
            ("a", motions().flat_map(|motion| motion.acceleration).collect()),
            ("alpha", motions().flat_map(|motion| motion.angular_acceleration).collect()),
        ]);
        Self {
            quaternions: motions()
                .flat_map(|motion| so3::exp_quaternion(vector(motion)).map(|x| 2.5 * x))
                .collect(),
            flow: [
                motions().map(|motion| motion.flow).collect(),
                motions().map(|motion| motion.flow_velocity).collect(),
                motions().map(|motion| motion.flow_acceleration).collect(),
            ],
            times: states.iter().map(|state| state.time.unwrap()).collect(),
            nodes,
            three,
        }
    }

    fn arrays(&self, by_quaternions: bool) -> NodeArrays<'_> {
        let count = self.nodes.len();
        let by = |numbers, each| ByNode::new(numbers, count * each, each);
        let three = |name: &str| Some(by(&self.three[name], 3));
        NodeArrays {
            count: self.times.len(),
            nodes: &self.nodes,
            times: Some(&self.times),
            displacement: three("u"),
            rotation: Some(if by_quaternions {
                Rotations::Quaternions(by(&self.quaternions, 4))
            } else {
                Rotations::Vectors(by(&self.three["vector"], 3))
            }),
            velocity: three("v"),
            angular_velocity: three("w"),
            acceleration: three("a"),
            angular_acceleration: three("alpha"),
            flow: self.flow.each_ref().map(|numbers| Some(by(numbers, 1))),
        }
    }
}

/// What arrays hold after an evaluation.
struct Found {
    outputs: Vec<Output>,
    values: Vec<Vec<f64>>,
    jacobian: Vec<f64>,
    hessian: Vec<f64>,
    tally: Tally,
}

fn found(model: &Model, request: &Request, motions: Motions<'_>) -> Found {
    let plan = Plan::compile(model, &Selection::All, request.clone()).unwrap();
    let outputs: Vec<Output> = request.outputs().collect();
    let count = motions.count() * plan.connectors.len() * 6;
    let mut values = vec![vec![7.0; count]; outputs.len()];
    let room = |least: u8, each: usize| vec![7.0; if request.order >= least { count * each } else { 0 }];
    let (mut jacobian, mut hessian) = (room(1, DOFS), room(2, DOFS * DOFS));
    let numbers = Numbers {
        values: outputs.iter().copied().zip(values.iter_mut().map(Vec::as_mut_slice)).collect(),
        jacobian: (request.order > 0).then_some(jacobian.as_mut_slice()),
        hessian: (request.order > 1).then_some(hessian.as_mut_slice()),
    };
    let tally = evaluate_arrays(model, &plan, motions, numbers).unwrap();
    Found { outputs, values, jacobian, hessian, tally }
}

/// The same by a walk, with second derivatives, which say how much rounding may change.
fn walked(model: &Model, request: &Request, states: &[State]) -> Found {
    let mut request = request.clone();
    request.order = 2;
    let plan = Plan::compile(model, &Selection::All, request.clone()).unwrap();
    let outputs: Vec<Output> = request.outputs().collect();
    let (mut values, mut jacobian, mut hessian) = (vec![Vec::new(); outputs.len()], Vec::new(), Vec::new());
    let mut sequence = Sequence::new(model, &plan);
    for state in states {
        let Ok(()) = sequence.visit(state, |item| -> Result<(), std::convert::Infallible> {
            let Item::Connector(result) = item else { return Ok(()) };
            for (output, to) in outputs.iter().zip(&mut values) {
                to.extend((0..6).map(|k| {
                    let value = value_of(result, *output, k).map(Value::number);
                    value.unwrap_or(f64::NAN)
                }));
            }
            let of = &result.evaluation;
            jacobian.extend(of.jacobian.iter().flat_map(|row| row.unwrap_or([f64::NAN; DOFS])));
            for hessian_of in &of.hessian {
                match hessian_of {
                    Some(of) => hessian.extend_from_slice(of.as_flattened()),
                    None => hessian.extend([f64::NAN; DOFS * DOFS]),
                }
            }
            Ok(())
        });
    }
    Found { outputs, values, jacobian, hessian, tally: sequence.tally() }
}

fn is_same(x: f64, y: f64) -> bool {
    x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan())
}

/// Largest differences in units of rounding of what each number is computed from: values, rows; and how many there are.
fn differences(found: &Found, known: &Found, size: &dyn Fn(usize) -> [f64; DOFS]) -> ([f64; 2], usize) {
    let (mut worst, mut compared) = ([0.0_f64; 2], 0);
    let mut note = |order: usize, (x, y): (f64, f64), scale: f64, what: &dyn std::fmt::Debug| {
        assert_eq!(x.is_nan(), y.is_nan(), "{what:?}: {x} {y}");
        if !x.is_nan() {
            compared += 1;
            let units = if x == y { 0.0 } else { (x - y).abs() / (U * scale) };
            assert!(units.is_finite(), "{what:?}: {x} {y} {scale}");
            worst[order] = worst[order].max(units);
        }
    };
    for place in 0..known.values[0].len() {
        let row = &known.jacobian[place * DOFS..][..DOFS];
        let hessian = &known.hessian[place * DOFS * DOFS..][..DOFS * DOFS];
        let size = size(place / 6);
        let first: f64 = row.iter().zip(&size).map(|(x, size)| x.abs() * size).sum();
        let largest = found.outputs.iter().zip(&known.values).filter(|(output, _)| **output != Output::TURNS);
        let largest = largest.fold(0.0, |most: f64, (_, values)| most.max(values[place].abs()));
        // Of a printed constraint the position has another row, of an angle.
        let scale = largest + first + 1.0;
        for ((output, values), known) in found.outputs.iter().zip(&found.values).zip(&known.values) {
            note(0, (values[place], known[place]), scale, &(output, place));
        }
        if !found.jacobian.is_empty() {
            for j in 0..DOFS {
                let own: f64 = (0..DOFS).map(|l| hessian[j * DOFS + l].abs() * size[l]).sum();
                let pair = (found.jacobian[place * DOFS + j], row[j]);
                let scale = scale / size[j] + if own.is_nan() { 0.0 } else { own };
                note(1, pair, scale, &("row", place, j));
            }
        }
    }
    (worst, compared)
}

/// Connectors of every type, in numbers that fill no part and no four.
#[test]
fn arrays_give_what_a_walk_gives() {
    const CONNECTORS: usize = 2 * 256 + 83;
    let (_, model) = model(CONNECTORS, "");
    let states = history(9, CONNECTORS + 1);
    let held = Held::of(&states);
    // Displacements count from where nodes are.
    let size = |at: usize| {
        let x = 2.0 + (at % CONNECTORS) as f64;
        std::array::from_fn(|j| if matches!(j % 7, 3..=5) { 1.0 } else { x })
    };
    let mut compared = 0;
    for outputs in [&[Output::CP, Output::CU, Output::CCU, Output::RES, Output::TURNS][..], &[Output::CU]] {
        for order in [0, 1] {
            let request = Request::new(outputs, [true; 6], order);
            let known = walked(&model, &request, &states);
            for (form, motions, told) in [
                ("states", Motions::States(&states), true),
                ("vectors", Motions::Arrays(&held.arrays(false)), true),
                ("quaternions", Motions::Arrays(&held.arrays(true)), false),
            ] {
                let mut found = found(&model, &request, motions);
                if !told {
                    // Quaternions know no whole turns: angles are the same but for these.
                    for (values, known) in found.values.iter_mut().zip(&known.values) {
                        for (x, y) in values.iter_mut().zip(known).filter(|(x, _)| x.is_finite()) {
                            *x += TAU * ((y - *x) / TAU).round();
                        }
                    }
                    found.outputs.retain(|output| *output != Output::TURNS);
                }
                let (worst, all) = differences(&found, &known, &size);
                println!("{outputs:?} order {order} {form}: {worst:.2?} units of {all} numbers");
                let [value, row] = tolerance::ARRAYS;
                assert!(worst[0] <= value && worst[1] <= row, "{form}: {worst:?}");
                compared += all;
                let of = &found.tally;
                let all = (states.len() * CONNECTORS) as u64;
                assert_eq!((of.hessians, of.rates, of.margins, of.behaviors), (0, 0, 0, 0), "{of:?}");
                assert!(order > 0 || of.gradients == 0, "{of:?}");
                assert!(of.gradients <= 6 * all && (outputs.len() > 1 || of.values <= 6 * all), "{of:?}");
            }
        }
    }
    assert!(compared > 1_000_000, "{compared}");
}

/// What lanes do not give has the bits of a walk: rates, second derivatives, stops.
#[test]
fn what_is_taken_one_by_one_has_the_same_bits() {
    const CONNECTORS: usize = 300;
    let (_, model) = model(CONNECTORS, "");
    let states = history(4, CONNECTORS + 1);
    let held = Held::of(&states);
    const ALL: [Output; 11] = [
        Output::CP,
        Output::CU,
        Output::CCU,
        Output::CV,
        Output::CA,
        Output::RES,
        Output::RESV,
        Output::RESB,
        Output::RESA,
        Output::CSLST,
        Output::TURNS,
    ];
    let request = Request::new(&ALL, [true; 6], 2);
    let known = walked(&model, &request, &states);
    let found = found(&model, &request, Motions::Arrays(&held.arrays(false)));
    let mut compared = 0;
    let pairs = found
        .values
        .iter()
        .zip(&known.values)
        .chain([(&found.jacobian, &known.jacobian), (&found.hessian, &known.hessian)]);
    for (found, known) in pairs {
        assert_eq!(found.len(), known.len());
        for (x, y) in found.iter().zip(known) {
            assert!(is_same(*x, *y), "{x} {y}");
            compared += usize::from(!x.is_nan());
        }
    }
    assert!(compared > 500_000, "{compared}");
}

/// Threads change no bit, and neither does how many connectors and states there are besides.
#[test]
fn threads_change_no_bit_of_arrays() {
    const CONNECTORS: usize = 700;
    let (_, model) = model(CONNECTORS, "");
    let states = history(5, CONNECTORS + 1);
    let request = Request::new(&[Output::CU, Output::RES], [true; 6], 1);
    let with = |threads: usize, states: &[State]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| found(&model, &request, Motions::States(states)))
    };
    let one = with(1, &states);
    let bits = |of: &[f64]| of.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    for threads in [2, 3, 7] {
        let many = with(threads, &states);
        assert!(one.values.iter().zip(&many.values).all(|(x, y)| bits(x) == bits(y)), "{threads}");
        assert_eq!(bits(&one.jacobian), bits(&many.jacobian), "{threads}");
    }
    let some = with(2, &states[..3]);
    let all = some.jacobian.len();
    assert!(all > 100_000 && bits(&one.jacobian[..all]) == bits(&some.jacobian));
}

/// States in parts give what they give at once, bit for bit, whatever of a part is asked for and in whichever order.
#[test]
fn a_walk_in_parts_is_the_whole() {
    const CONNECTORS: usize = 96;
    let (_, model) = model(CONNECTORS, "");
    let states = history(9, CONNECTORS + 1);
    let request = Request::new(&[Output::CU, Output::TURNS], [true; 6], 1);
    let whole = found(&model, &request, Motions::States(&states));
    let plan = Plan::compile(&model, &Selection::All, request.clone()).unwrap();
    let mut walk = ArrayWalk::new(&model, &plan).unwrap();
    let each = CONNECTORS * 6;
    let mut compared = 0;
    for (first, last, is_wanted) in [(0, 1, true), (1, 4, false), (4, 4, true), (4, 9, true)] {
        let motions = Motions::States(&states[first..last]);
        if !is_wanted {
            walk.advance(motions, Numbers::default()).unwrap();
            continue;
        }
        let count = (last - first) * each;
        let (mut turns, mut moved, mut rows) = (vec![7.0; count], vec![7.0; count], vec![7.0; count * DOFS]);
        // Not in the order of the request.
        let values = vec![(Output::TURNS, turns.as_mut_slice()), (Output::CU, moved.as_mut_slice())];
        walk.advance(motions, Numbers { values, jacobian: Some(&mut rows), hessian: None }).unwrap();
        for (output, found) in [(Output::TURNS, &turns), (Output::CU, &moved)] {
            let known = &whole.values[whole.outputs.iter().position(|of| *of == output).unwrap()];
            for (x, y) in found.iter().zip(&known[first * each..]) {
                assert_eq!(x.to_bits(), y.to_bits(), "{} of states {first} to {last}", output.name());
                compared += 1;
            }
        }
        for (x, y) in rows.iter().zip(&whole.jacobian[first * each * DOFS..]) {
            assert_eq!(x.to_bits(), y.to_bits(), "rows of states {first} to {last}");
            compared += 1;
        }
    }
    assert_eq!(compared, 6 * each * (2 + DOFS));
}

/// Arrays of another size, outputs that need more, and behaviours are refused.
#[test]
fn what_arrays_do_not_give_is_refused() {
    let (_, model) = model(8, "");
    let states = history(2, 9);
    let refused = |request: Request, length: usize| {
        let plan = Plan::compile(&model, &Selection::All, request.clone()).unwrap();
        let mut room = vec![vec![0.0; length]; request.outputs().count()];
        let values = request.outputs().zip(room.iter_mut().map(Vec::as_mut_slice)).collect();
        let numbers = Numbers { values, ..Numbers::default() };
        evaluate_arrays(&model, &plan, Motions::States(&states), numbers).unwrap_err()
    };
    let of = |output: Output| Request::new(&[output], [true; 6], 0);
    assert_eq!(refused(of(Output::CTF), 96), ArrayError::Output("CTF"));
    assert_eq!(refused(of(Output::CU), 95), ArrayError::Length { what: "CU", found: 95, expected: 96 });
}

/// Beyond the lengths that batches are stated for, and on singular sets, numbers are those of a connector by itself, bit for bit.
#[test]
fn lengths_beyond_a_batch_are_taken_one_by_one() {
    let deck = "*NODE\n3, 0., 0., 0.\n4, 2., 0., 0.\n5, 1., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 3, 4\n8, 3, 5\n\
                *CONNECTOR SECTION, ELSET=C\nLINK,\n";
    let scene = Scene::parse("far.inp", deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    let at = |x: f64, y: f64| NodeMotion { displacement: [x, y, 0.0], ..NodeMotion::default() };
    let states: Vec<State> = [
        [at(-1.5e308, 1e308), at(1.5e308, 1e308)],
        [at(0.0, 0.0), at(-2.0, 0.0)],
        [at(0.0, 0.0), at(-2.0, 1e-305)],
        [at(0.0, 0.0), at(-2.0, 1e305)],
    ]
    .map(|[a, b]| State { nodes: [(3.into(), a), (4.into(), b)].into(), ..State::default() })
    .into();
    let request = Request::new(&[Output::CU, Output::RES], [true; 6], 1);
    let (known, found) =
        (walked(&model, &request, &states), found(&model, &request, Motions::States(&states)));
    let mut compared = 0;
    for s in 0..states.len() {
        // The first connector; the second is sound in all but the first state.
        let first = s * 12;
        for k in first..first + 6 {
            let rows = (&found.jacobian[k * DOFS..][..DOFS], &known.jacobian[k * DOFS..][..DOFS]);
            let values = found.values.iter().zip(&known.values).map(|(x, y)| (x[k], y[k]));
            for (x, y) in values.chain(rows.0.iter().copied().zip(rows.1.iter().copied())) {
                assert!(is_same(x, y), "state {s}: {x} {y}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, states.len() * 6 * 16);
}
