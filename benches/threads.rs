//! What threads bring: `cargo bench --bench threads`.
//!
//! A chain of connectors of every type at one state after the other, evaluated, assembled and written, by 1, 2, 4 … threads up to as many
//! as the machine has, the least time of rounds that take turns. Results are asserted to be the same, bit for bit.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

#[path = "../verify/scale/chain.rs"]
mod chain;
#[path = "hand/commit.rs"]
mod commit;

use pintle_kinematics::connector::{Output, Request};
use pintle_model::evaluate::{Fixed, Item, Jacobian, Model, Plan, Selection, Sequence};
use pintle_report::csv::Csv;
use pintle_report::{Block, BlockKind, Format, Subject};
use pintle_scene::{Scene, State};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::convert::Infallible;
use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;

const CONNECTORS: usize = 20_000;
const ROUNDS: usize = 8;
const OUTPUTS: [Output; 4] = [Output::CP, Output::CU, Output::CV, Output::RES];

/// A sum in which every byte and its place count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sum(u64);

impl Sum {
    fn add(&mut self, bits: u64) {
        self.0 = (self.0.rotate_left(5) ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

impl Write for Sum {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        let (words, rest) = text.as_chunks::<8>();
        words.iter().for_each(|word| self.add(u64::from_le_bytes(*word)));
        rest.iter().for_each(|byte| self.add((*byte).into()));
        Ok(text.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A multi-point constraint from each node to the one after the next, of kinds in turn.
fn constraints() -> String {
    let kinds = ["BEAM", "TIE", "PIN", "LINK"];
    let lines = (1..CONNECTORS).map(|node| format!("{}, {}, {node}\n", kinds[node % 4], node + 2));
    format!("*MPC\n{}", lines.collect::<String>())
}

fn scene(rest: &str) -> Scene {
    let deck = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-threads.inp", std::process::id()));
    std::fs::write(&deck, chain::deck(CONNECTORS, &chain::types(), rest)).unwrap();
    let scene = Scene::read(&deck).unwrap();
    std::fs::remove_file(deck).unwrap();
    scene
}

/// What is done with a state.
type Work<'w> = Box<dyn FnMut(&State) -> Sum + Send + 'w>;

fn evaluated<'w>(model: &'w Model, plan: &'w Plan) -> Work<'w> {
    let mut sequence = Sequence::new(model, plan);
    Box::new(move |state| {
        let mut sum = Sum::default();
        let Ok(()) = sequence.visit(state, |item| -> Result<(), Infallible> {
            let Item::Connector(result) = item else { panic!("a chain has no MPC") };
            result.evaluation.jacobian.iter().flatten().for_each(|row| sum.add(row[1].to_bits()));
            Ok(())
        });
        sum
    })
}

fn filled<'w>(model: &'w Model, plan: &'w Plan, jacobian: &'w Jacobian) -> Work<'w> {
    let (mut sequence, mut values) = (Sequence::new(model, plan), Vec::with_capacity(jacobian.entries()));
    Box::new(move |state| {
        sequence.assemble(state, jacobian, &mut values).unwrap();
        let mut sum = Sum::default();
        values.iter().step_by(16).for_each(|value: &f64| sum.add(value.to_bits()));
        sum
    })
}

fn written<'w>(scene: &'w Scene, model: &'w Model, plan: &'w Plan) -> Work<'w> {
    let (mut sequence, mut texts) = (Sequence::new(model, plan), Vec::new());
    Box::new(move |state| {
        let mut sum = Sum::default();
        let mut format = Csv::new(&mut sum, OUTPUTS.to_vec(), 1);
        format.begin().unwrap();
        format.scene(&Subject { scene, model, plan, states: 1, shown: &[], first: 0, last: 0 }).unwrap();
        format.state(0, state.time).unwrap();
        let render = format.renderer();
        let digest = |item: Item<'_>, text: &mut Vec<u8>| {
            let Item::Connector(result) = item else { panic!("a chain has no MPC") };
            text.clear();
            render(&Block::of_connector(model, &plan.request, result), text).unwrap();
        };
        let put = |text: &mut Vec<u8>| format.rendered(BlockKind::Connector, text);
        sequence.visit_digested(state, &mut texts, digest, put).unwrap();
        format.end().unwrap();
        drop(format);
        sum
    })
}

/// One walk for each pool, through the same states.
fn compare(phase: &str, pools: &[ThreadPool], states: &[State], mut walks: Vec<Work<'_>>) {
    let mut least = vec![f64::INFINITY; pools.len()];
    for state in states {
        let mut known = None;
        for ((pool, walk), least) in pools.iter().zip(&mut walks).zip(&mut least) {
            let start = Instant::now();
            let found = pool.install(|| walk(state));
            *least = least.min(start.elapsed().as_secs_f64());
            let threads = pool.current_num_threads();
            assert_eq!(*known.get_or_insert(found), found, "{phase}: {threads} threads give other bits");
        }
    }
    let columns = least.iter().map(|seconds| {
        let microseconds = 1e6 * seconds / CONNECTORS as f64;
        format!("{:>16}", format!("{microseconds:.3} = {:.2} ×", least[0] / seconds))
    });
    println!("{phase:28}{}", columns.collect::<String>());
}

fn main() {
    if commit::is_told() {
        return;
    }
    let (scene, constrained) = (scene(""), scene(&constraints()));
    let [model, constrained] = [&scene, &constrained].map(|scene| Model::compile(scene).unwrap());
    let request = Request::new(&OUTPUTS, [true; 6], 1);
    let plan = Plan::compile(&model, &Selection::All, request).unwrap();
    let nothing = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::none());
    let all = Plan::compile(&constrained, &Selection::All, Request::nothing(0)).unwrap();
    let with_mpcs = Jacobian::of_constraints(&constrained, &all, &Fixed::none());
    assert_eq!(constrained.mpcs.len(), CONNECTORS - 1);
    let states: Vec<State> = (1..=ROUNDS as u64).map(|number| chain::state(number, CONNECTORS + 1)).collect();
    let available = std::thread::available_parallelism().unwrap().get();
    let counts: Vec<usize> = (0..).map(|k| 1 << k).take_while(|count| *count <= available).collect();
    let pools: Vec<ThreadPool> =
        counts.iter().map(|count| ThreadPoolBuilder::new().num_threads(*count).build().unwrap()).collect();
    println!("{CONNECTORS} connectors; microseconds for each, and the speed over that of one thread");
    println!("{:28}{}", "threads", counts.iter().map(|count| format!("{count:>16}")).collect::<String>());
    let each = || pools.iter();
    compare("evaluate, order 1", &pools, &states, each().map(|_| evaluated(&model, &plan)).collect());
    compare(
        "fill the Jacobian",
        &pools,
        &states,
        each().map(|_| filled(&model, &nothing, &jacobian)).collect(),
    );
    compare(
        "fill it, with as many MPCs",
        &pools,
        &states,
        each().map(|_| filled(&constrained, &all, &with_mpcs)).collect(),
    );
    compare(
        "evaluate, CSV, order 1",
        &pools,
        &states,
        each().map(|_| written(&scene, &model, &plan)).collect(),
    );
}
