//! Scenes by arrays: `cargo bench --bench arrays`.
//!
//! A chain of connectors of every type, at states that turn on and on: arrays of motions in, CU, RES and rows of 14 columns out. Beside it the
//! batch kernels alone, on the same connectors and motions, which know the histories beforehand, and a walk that copies its results
//! into the same arrays. Numbers are asserted to agree first. The least time of rounds that take turns.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

#[path = "../verify/scale/chain.rs"]
mod chain;
#[path = "hand/commit.rs"]
mod commit;

use pintle_kinematics::batch::{Array, Batch, Columns, History, LANES, Nodes, Orientation, Section, States};
use pintle_kinematics::connector::{Branch, Connector, Output, Request};
use pintle_kinematics::node::DOFS;
use pintle_model::evaluate::{
    ByNode, Item, Model, Motions, NodeArrays, Numbers, Plan, Rotations, Selection, Sequence, evaluate_arrays,
};
use pintle_scene::{Label, Rotation, Scene, State};
use rayon::ThreadPoolBuilder;
use std::convert::Infallible;
use std::time::Instant;

/// How many connectors, and at how many states: as many as their results leave room for.
const SIZES: [(usize, usize); 4] = [(100, 100), (1_000, 100), (10_000, 100), (100_000, 20)];
const ROUNDS: usize = 7;

/// Connectors of one kind at all states, as arrays.
struct Kind {
    batch: Batch,
    members: Vec<usize>,
    reference: Vec<f64>,
    displacement: [Vec<f64>; 2],
    vectors: [Vec<f64>; 2],
    initial: [[[f64; 3]; 3]; 2],
    sections: Vec<Section>,
    histories: Vec<History>,
    values: Vec<f64>,
    rows: Vec<f64>,
}

/// Results of a walk, by state and connector.
struct Walked {
    values: [Vec<f64>; 2],
    jacobian: Vec<f64>,
    branches: Vec<Branch<f64>>,
}

fn walk(model: &Model, plan: &Plan, states: &[State], found: &mut Walked, keeps: bool) {
    let mut sequence = Sequence::new(model, plan);
    let count = plan.connectors.len();
    found.branches.clear();
    for (s, state) in states.iter().enumerate() {
        let Ok(()) = sequence.visit(state, |item| -> Result<(), Infallible> {
            let Item::Connector(result) = item else { return Ok(()) };
            let (of, first) = (&result.evaluation, (s * count + result.index) * 6);
            for k in 0..6 {
                found.values[0][first + k] = of.displacement[k].unwrap_or(f64::NAN);
                found.values[1][first + k] = of.residual[k].unwrap_or(f64::NAN);
                let row = of.jacobian[k].as_ref().unwrap_or(&[f64::NAN; DOFS]);
                found.jacobian[(first + k) * DOFS..][..DOFS].copy_from_slice(row);
            }
            if keeps {
                found.branches.push(of.branch);
            }
            Ok(())
        });
    }
}

fn kinds(model: &Model, states: &[State], branches: &[Branch<f64>]) -> Vec<Kind> {
    let mut groups: Vec<(&Connector<f64>, Vec<usize>)> = Vec::new();
    for (index, element) in model.connectors.iter().enumerate() {
        match groups.iter_mut().find(|(one, _)| one.has_measures_of(&element.connector)) {
            Some((_, members)) => members.push(index),
            None => groups.push((&element.connector, vec![index])),
        }
    }
    let count = model.connectors.len();
    let made = groups.into_iter().filter_map(|(connector, members)| {
        let batch = Batch::new(connector, [true; 6]).ok()?;
        let all = || (0..states.len()).flat_map(|s| members.iter().map(move |index| (s, *index)));
        let motion = |s: usize, index: usize, end: usize| {
            let label = model.connectors[index].nodes[end];
            label.and_then(|label| states[s].nodes.get(&label)).copied().unwrap_or_default()
        };
        let vector = |s, index, end| match motion(s, index, end).rotation {
            Rotation::Vector(vector) => vector,
            Rotation::Quaternion(_) => panic!("vectors"),
        };
        let fours: Vec<(usize, usize)> = all().collect();
        let fours: Vec<[(usize, usize); LANES]> = fours
            .chunks(LANES)
            .map(|four| std::array::from_fn(|i| *four.get(i).unwrap_or(&four[four.len() - 1])))
            .collect();
        let of = |(_, index): (usize, usize)| &model.connectors[index].connector;
        let triads = model.connectors[members[0]].triads();
        let size = all().count();
        let width = batch.width(Columns::Fourteen);
        Some(Kind {
            reference: all().flat_map(|(_, index)| model.connectors[index].reference).collect(),
            displacement: [0, 1]
                .map(|end| all().flat_map(|(s, index)| motion(s, index, end).displacement).collect()),
            vectors: [0, 1].map(|end| all().flat_map(|(s, index)| vector(s, index, end)).collect()),
            initial: triads.map(|triad| *triad),
            sections: fours.iter().map(|four| Section::new(&four.map(of))).collect(),
            histories: fours
                .iter()
                .map(|four| History::new(&four.map(|(s, index)| branches[s * count + index])))
                .collect(),
            values: vec![0.0; size * batch.rows()],
            rows: vec![0.0; size * width],
            batch,
            members,
        })
    });
    made.collect()
}

fn run_kernels(kinds: &mut [Kind]) {
    for kind in kinds {
        let Kind {
            batch, reference, displacement, vectors, initial, sections, histories, values, rows, ..
        } = kind;
        let nodes = [0, 1].map(|end| Nodes {
            displacement: Array::new(&displacement[end], 3),
            orientation: Orientation::RotationVector(Array::new(&vectors[end], 3), initial[end]),
        });
        let states = States {
            count: reference.len() / 3,
            reference: Array::new(reference, 3),
            nodes,
            sections,
            histories,
        };
        batch.rows_of_states(&states, Columns::Fourteen, values, rows).unwrap();
    }
}

fn measured(connectors: usize, states: usize) {
    let deck = chain::deck(connectors, &chain::types(), "");
    let model = Model::compile(&Scene::parse("chain.inp", &deck).unwrap()).unwrap();
    let count = states;
    let states: Vec<State> = (0..count as u64).map(|s| chain::state(s, connectors + 1)).collect();
    let request = Request::new(&[Output::CU, Output::RES], [true; 6], 1);
    let plan = Plan::compile(&model, &Selection::All, request).unwrap();
    let nodes: Vec<Label> = states[0].nodes.keys().copied().collect();
    let motions = || states.iter().flat_map(|state| state.nodes.values());
    let u: Vec<f64> = motions().flat_map(|motion| motion.displacement).collect();
    let vectors: Vec<f64> = motions()
        .flat_map(|motion| match motion.rotation {
            Rotation::Vector(vector) => vector,
            Rotation::Quaternion(_) => panic!("vectors"),
        })
        .collect();
    let flow: Vec<f64> = motions().map(|motion| motion.flow).collect();
    let by = |numbers, each: usize| ByNode::new(numbers, nodes.len() * each, each);
    let arrays = NodeArrays {
        count,
        nodes: &nodes,
        displacement: Some(by(&u, 3)),
        rotation: Some(Rotations::Vectors(by(&vectors, 3))),
        flow: [Some(by(&flow, 1)), None, None],
        ..NodeArrays::default()
    };
    let size = count * connectors * 6;
    let mut walked = Walked {
        values: [vec![0.0; size], vec![0.0; size]],
        jacobian: vec![0.0; size * DOFS],
        branches: Vec::new(),
    };
    let mut values = [vec![0.0; size], vec![0.0; size]];
    let mut jacobian = vec![0.0; size * DOFS];
    let mut fill = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let [cu, res] = &mut values;
        let numbers = Numbers {
            values: vec![(Output::CU, cu), (Output::RES, res)],
            jacobian: Some(&mut jacobian),
            hessian: None,
        };
        let begun = Instant::now();
        pool.install(|| evaluate_arrays(&model, &plan, Motions::Arrays(&arrays), numbers)).unwrap();
        begun.elapsed().as_secs_f64()
    };
    fill(1);
    let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    one.install(|| walk(&model, &plan, &states, &mut walked, true));
    let mut kinds = kinds(&model, &states, &walked.branches);
    let batched: usize = kinds.iter().map(|kind| kind.members.len()).sum();
    let mut least = [f64::MAX; 4];
    for _ in 0..ROUNDS {
        let mut kernels = || {
            let begun = Instant::now();
            run_kernels(&mut kinds);
            begun.elapsed().as_secs_f64()
        };
        let mut walking = || {
            let begun = Instant::now();
            one.install(|| walk(&model, &plan, &states, &mut walked, false));
            begun.elapsed().as_secs_f64()
        };
        let round = [kernels(), fill(1), fill(2), walking()];
        for (least, time) in least.iter_mut().zip(round) {
            *least = least.min(time);
        }
    }
    let (mut compared, mut worst) = (0, 0.0_f64);
    let pairs = values.iter().zip(&walked.values).chain([(&jacobian, &walked.jacobian)]);
    for (x, y) in pairs.flat_map(|(x, y)| x.iter().zip(y)) {
        assert_eq!(x.is_nan(), y.is_nan());
        if !x.is_nan() {
            compared += 1;
            worst = worst.max((x - y).abs() / (1.0 + connectors as f64));
        }
    }
    assert!(worst < 1e-14 && compared > size, "{worst:e} of {compared}");
    let [kernels, single, double, walking] = least;
    let each = |time: f64, connectors: usize| time * 1e9 / (count * connectors) as f64;
    println!(
        "{connectors:>10}  {count:>6}  {:>7.0}  {:>8.0}  {:>6.2}  {:>8.0}  {:>6.2}  {:>8.0}  {:>6.1}",
        each(kernels, batched),
        each(single, connectors),
        each(single, connectors) / each(kernels, batched),
        each(double, connectors),
        single / double,
        each(walking, connectors),
        walking / single,
    );
}

fn main() {
    if commit::is_told() {
        return;
    }
    println!("a chain of connectors of every type; ns for each connector and state");
    println!("connectors  states  kernels    arrays  ratio  2 threads  speed      walk  speed");
    for (connectors, states) in SIZES {
        measured(connectors, states);
    }
}
