//! A long history of many connectors, streamed: `cargo bench --bench history [STATES]`.
//!
//! A chain of 1e4 connectors of every type, whose states are read from a file one at a time, and CP of every connector evaluated by all threads. First all
//! nodes move at every state, for 10, 100 and 1000 states; then sixteen of them, others at each state, for 1e5 states unless told otherwise and a tenth of that: a file in
//! which all of them do would have fifty gigabytes. 1e5 states are 1e9 evaluations, and take minutes. The most memory beyond that of the scene and the model is asserted to be the same for any number of states.
//! Before that, what is streamed is compared, bit for bit, with states that are evaluated where they stand in memory.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

#[path = "../verify/scale/chain.rs"]
mod chain;
#[path = "hand/commit.rs"]
mod commit;

use peak_alloc::PeakAlloc;
use pintle_kinematics::connector::{Output, Request};
use pintle_model::evaluate::{Item, Model, Plan, Selection, Sequence};
use pintle_scene::{Diagnostic, Label, NodeMotion, Rotation, Scene, State, StateStream};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const CONNECTORS: usize = 10_000;
const STATES: u64 = 100_000;
/// Numbers of states at which every node moves.
const FEW: [u64; 3] = [10, 100, 1000];
/// The nodes that move at each state of a long history.
const MOVING: u64 = 16;
/// States that differ; longer histories repeat them.
const DIFFERENT: u64 = 8;
/// How far the most memory may be from one number of states to another.
const CONSTANT: f64 = 1.05;

/// Motions of all nodes, with four decimals.
fn motions() -> Vec<State> {
    let round = |x: f64| (1e4 * x).round() / 1e4;
    let states = (1..=DIFFERENT).map(|number| {
        let mut state = chain::state(number, CONNECTORS + 1);
        for (node, motion) in &mut state.nodes {
            let Rotation::Vector(rotation) = motion.rotation else { panic!("{node}") };
            *motion = NodeMotion {
                displacement: motion.displacement.map(round),
                rotation: Rotation::Vector(rotation.map(round)),
                ..NodeMotion::default()
            };
        }
        state
    });
    states.collect()
}

/// A history of so many states, and the nodes that each moves.
#[derive(Clone, Copy)]
struct History {
    states: u64,
    moving: u64,
}

impl History {
    /// The nodes that move at a state: all, or some in turn.
    fn nodes(self, number: u64) -> impl Iterator<Item = Label> {
        let nodes = CONNECTORS as u64 + 1;
        (0..self.moving).map(move |i| Label::from((number * self.moving + i) % nodes + 1))
    }

    fn state(self, number: u64, motions: &[State]) -> State {
        let all = &motions[(number % DIFFERENT) as usize].nodes;
        let nodes = self.nodes(number).map(|node| (node, all[&node])).collect();
        State { number: Some(number), nodes, ..State::default() }
    }

    fn file(self, motions: &[State]) -> PathBuf {
        let name = format!("{}-history-{}.csv", std::process::id(), self.states);
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let mut out = BufWriter::new(File::create(&path).unwrap());
        writeln!(out, "state,node,u1,u2,u3,ur1,ur2,ur3").unwrap();
        for number in 0..self.states {
            for (node, motion) in &self.state(number, motions).nodes {
                let [u1, u2, u3] = motion.displacement;
                let Rotation::Vector([r1, r2, r3]) = motion.rotation else { panic!("{node}") };
                writeln!(out, "{number},{node},{u1},{u2},{u3},{r1},{r2},{r3}").unwrap();
            }
        }
        out.flush().unwrap();
        path
    }
}

/// The bits of CP of what a walk hands on.
fn bits(item: Item<'_>, all: &mut Vec<Option<u64>>) {
    let Item::Connector(result) = item else { panic!("a chain has no MPC") };
    all.extend(result.evaluation.position.map(|value| value.map(f64::to_bits)));
}

/// The states of a file, one at a time.
fn stream(path: &Path, scene: &Scene, mut take: impl FnMut(State)) {
    let Ok(()) = StateStream::open(path).unwrap().for_each(scene, |state| -> Result<(), Diagnostic> {
        take(state);
        Ok(())
    }) else {
        panic!("{} cannot be read", path.display())
    };
}

/// What is streamed is what the same states give that stand in memory.
fn compare(scene: &Scene, model: &Model, plan: &Plan, motions: &[State]) {
    for moving in [CONNECTORS as u64 + 1, MOVING] {
        let history = History { states: DIFFERENT, moving };
        let path = history.file(motions);
        let (mut streamed, mut held) = (Sequence::new(model, plan), Sequence::new(model, plan));
        let mut number = 0;
        stream(&path, scene, |state| {
            let (mut of_stream, mut of_memory) = (Vec::new(), Vec::new());
            let walks = [
                (&mut streamed, &state, &mut of_stream),
                (&mut held, &history.state(number, motions), &mut of_memory),
            ];
            for (walk, state, all) in walks {
                let Ok(()) = walk.visit(state, |item| -> Result<(), std::convert::Infallible> {
                    bits(item, all);
                    Ok(())
                });
            }
            assert!(of_stream.iter().flatten().count() > CONNECTORS);
            assert!(of_stream == of_memory, "state {number} of {moving} nodes differs when it is streamed");
            number += 1;
        });
        assert_eq!(number, history.states);
        std::fs::remove_file(path).unwrap();
    }
}

/// Streams and evaluates a history; the seconds that it took, and the most memory beyond what there was before.
fn measure(history: History, path: &Path, scene: &Scene, model: &Model, plan: &Plan) -> (f64, usize) {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let start = Instant::now();
    let mut walk = Sequence::new(model, plan);
    let mut values = 0_u64;
    stream(path, scene, |state| {
        let Ok(()) = walk.visit(&state, |item| -> Result<(), std::convert::Infallible> {
            let Item::Connector(result) = item else { panic!("a chain has no MPC") };
            values +=
                result.evaluation.position.iter().flatten().filter(|value| value.is_finite()).count() as u64;
            Ok(())
        });
    });
    let seconds = start.elapsed().as_secs_f64();
    assert_eq!(walk.states(), history.states);
    assert!(values > history.states * CONNECTORS as u64);
    (seconds, MEMORY.peak_usage() - before)
}

fn main() {
    if commit::is_told() {
        return;
    }
    let states = std::env::args().filter_map(|word| word.parse().ok()).next().unwrap_or(STATES);
    let motions = motions();
    let scene = Scene::parse("chain.inp", &chain::deck(CONNECTORS, &chain::types(), "")).unwrap();
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, Request::new(&[Output::CP], [true; 6], 0)).unwrap();
    compare(&scene, &model, &plan, &motions);
    let all = CONNECTORS as u64 + 1;
    let steps = FEW.into_iter().chain([states / 10, states]);
    let moving = [all; FEW.len()].into_iter().chain([MOVING; 2]);
    let histories = steps.zip(moving).map(|(states, moving)| History { states, moving });
    println!(
        "CP of {CONNECTORS} connectors of every type at each state of a file, {} threads; memory beyond that of the scene and the model",
        rayon::current_num_threads()
    );
    println!(
        "{:>9}{:>20}{:>12}{:>14}{:>34}{:>18}",
        "states", "nodes that move", "file", "time", "for each connector and state", "most memory"
    );
    let mut known: Option<usize> = None;
    for history in histories {
        let path = history.file(&motions);
        let file = path.metadata().unwrap().len();
        let (seconds, bytes) = measure(history, &path, &scene, &model, &plan);
        std::fs::remove_file(path).unwrap();
        let History { states, moving } = history;
        let nanoseconds = 1e9 * seconds / (states as f64 * CONNECTORS as f64);
        println!(
            "{:>9}{moving:>20}{:>12}{:>14}{:>34}{:>18}",
            format!("{:e}", states as f64),
            format!("{:.1} MB", 1e-6 * file as f64),
            format!("{seconds:.2} s"),
            format!("{nanoseconds:.0} ns"),
            format!("{:.2} MB", 1e-6 * bytes as f64),
        );
        let least = *known.get_or_insert(bytes);
        assert!(
            (bytes as f64) < CONSTANT * least as f64,
            "{bytes} bytes for {states} states, {least} for fewer"
        );
    }
}
