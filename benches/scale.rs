//! Time and memory of every phase of a run, from one connector to a million: `taskset -c 3 cargo bench --bench scale [CONNECTORS]`.
//!
//! A chain of connectors of every type, read from a file, evaluated at one state and written. What is linear is the same number in every
//! column. There are microseconds on a core for each connector, the least of rounds, and bytes for each connector: those that a phase leaves,
//! and the most that it takes while it is at work. Memory is asserted to be linear; times are for reading. One connector is a HINGE.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

#[path = "../verify/scale/chain.rs"]
mod chain;
#[path = "hand/commit.rs"]
mod commit;

use peak_alloc::PeakAlloc;
use pintle_kinematics::catalog::Orientation;
use pintle_kinematics::connector::{Output, Request};
use pintle_model::evaluate::{Fixed, Item, Jacobian, Model, Plan, Selection, Sequence};
use pintle_report::csv::Csv;
use pintle_report::json::Json;
use pintle_report::{Block, BlockKind, Format, Subject, matrix_market};
use pintle_scene::{Diagnostic, NodeMotion, Rotation, Scene, State, StateStream};
use std::convert::Infallible;
use std::fs::File;
use std::hint::black_box;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// How far bytes for each connector may be from one size to another: tables double in size.
const LINEAR: f64 = 1.6;

const BEGIN: &str = "begin a walk";
const AGAIN: &str = "fill it at the next state";
const TOUCH: &str = "fill that much new memory";

/// What a phase took, for each connector.
struct Cost {
    phase: &'static str,
    seconds: f64,
    held: f64,
    most: f64,
}

/// The seconds that this thread has been on a core, where the system tells (Linux).
fn on_core() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(1e-9 * text.split_whitespace().next()?.parse::<f64>().ok()?)
}

/// The time on a core since `before`, which is told by ticks, or since `start` where that is too short to be told.
fn spent(before: f64, start: Instant) -> f64 {
    const CERTAIN: f64 = 0.05;
    let elapsed = start.elapsed().as_secs_f64();
    on_core().map(|after| after - before).filter(|spent| *spent > CERTAIN).unwrap_or(elapsed)
}

struct Meter {
    connectors: f64,
    costs: Vec<Cost>,
}

impl Meter {
    fn of<T>(&mut self, phase: &'static str, work: impl FnOnce() -> T) -> T {
        let before = MEMORY.current_usage() as f64;
        MEMORY.reset_peak_usage();
        // The clock starts last: to ask for the time on a core takes as long as a phase of one connector.
        let on_core = on_core();
        let start = Instant::now();
        let made = work();
        let seconds = on_core.map_or_else(|| start.elapsed().as_secs_f64(), |before| spent(before, start));
        let per = |bytes: usize| (bytes as f64 - before) / self.connectors;
        let (held, most) = (per(MEMORY.current_usage()), per(MEMORY.peak_usage()));
        match self.costs.iter_mut().find(|cost| cost.phase == phase) {
            Some(known) => known.seconds = known.seconds.min(seconds),
            None => self.costs.push(Cost { phase, seconds, held, most }),
        }
        made
    }
}

fn temporary(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{name}", std::process::id()))
}

const ORIENTED: &[Orientation] = &[Orientation::Required];

/// The files of a chain and of one state of it.
fn files(connectors: usize) -> [PathBuf; 2] {
    let [deck, states] = ["scale.inp", "scale.csv"].map(temporary);
    let types = if connectors == 1 { vec![("HINGE".into(), ORIENTED)] } else { chain::types() };
    std::fs::write(&deck, chain::deck(connectors, &types, "")).unwrap();
    let mut out = BufWriter::new(File::create(&states).unwrap());
    writeln!(out, "state,time,node,u1,u2,u3,ur1,ur2,ur3,v1,v2,v3").unwrap();
    for (node, motion) in &chain::state(1, connectors + 1).nodes {
        let NodeMotion { displacement: [u1, u2, u3], velocity: [v1, v2, v3], .. } = motion;
        let Rotation::Vector([r1, r2, r3]) = motion.rotation else { panic!("{node}") };
        writeln!(out, "1,0.125,{node},{u1},{u2},{u3},{r1},{r2},{r3},{v1},{v2},{v3}").unwrap();
    }
    out.flush().unwrap();
    [deck, states]
}

/// The last state of a file.
fn read(scene: &Scene, states: &Path) -> State {
    let mut read = None;
    let stream = StateStream::open(states).unwrap();
    let Ok(()) = stream.for_each(scene, |state| -> Result<(), Diagnostic> {
        read = Some(state);
        Ok(())
    }) else {
        panic!("{} cannot be read", states.display())
    };
    read.unwrap()
}

/// What is asked for besides rows.
const OUTPUTS: [Output; 4] = [Output::CP, Output::CU, Output::CV, Output::RES];

fn planned(model: &Model, order: u8) -> Plan {
    Plan::compile(model, &Selection::All, Request::new(&OUTPUTS, [true; 6], order)).unwrap()
}

/// Evaluates a state and writes what is planned; the number of connectors written.
fn write(scene: &Scene, model: &Model, plan: &Plan, state: &State, format: &mut dyn Format) -> usize {
    let mut sequence = Sequence::new(model, plan);
    format.begin().unwrap();
    format.scene(&Subject { scene, model, plan, states: 1, shown: &[], first: 0, last: 0 }).unwrap();
    format.state(0, state.time).unwrap();
    let render = format.renderer();
    let mut count = 0;
    let digest = |item: Item<'_>, text: &mut Vec<u8>| match item {
        Item::Connector(result) => {
            text.clear();
            render(&Block::of_connector(model, &plan.request, result), text).unwrap();
        }
        Item::Mpc(_) | Item::Relation(_) => panic!("a chain has no constraint"),
    };
    let put = |text: &mut Vec<u8>| {
        count += 1;
        format.rendered(BlockKind::Connector, text)
    };
    sequence.visit_digested(state, &mut Vec::new(), digest, put).unwrap();
    format.end_state().unwrap();
    format.end_scene(sequence.tally()).unwrap();
    format.end().unwrap();
    count
}

fn measure(connectors: usize) -> Meter {
    // The first round meets memory that nobody has touched.
    let rounds = (200_000 / connectors).clamp(2, 2000);
    let mut meter = Meter { connectors: connectors as f64, costs: Vec::new() };
    let [deck, states] = files(connectors);
    for _ in 0..rounds {
        let scene = meter.of("read the deck", || Scene::read(&deck)).unwrap();
        let model = meter.of("resolve the model", || Model::compile(&scene)).unwrap();
        let state = meter.of("read a state", || read(&scene, &states));
        let plan = |order| planned(&model, order);
        let plan_of = meter.of("plan", || plan(0));
        let before = MEMORY.current_usage();
        let walk = meter.of(BEGIN, || Sequence::new(&model, &plan_of));
        let bytes = MEMORY.current_usage() - before;
        drop(walk);
        // What of this is the system's: each page is zeroed, and touched for the first time.
        drop(meter.of(TOUCH, || black_box(vec![1_u8; bytes])));
        for (phase, order) in [("evaluate, order 0", 0), ("evaluate, order 1", 1), ("evaluate, order 2", 2)] {
            let plan = plan(order);
            let mut sequence = Sequence::new(&model, &plan);
            let mut count = 0;
            let Ok(()) = meter.of(phase, || {
                sequence.visit(&state, |item| -> Result<(), Infallible> {
                    black_box(item);
                    count += 1;
                    Ok(())
                })
            });
            assert_eq!(count, connectors);
        }
        let jacobian = meter
            .of("pattern of the Jacobian", || Jacobian::of_constraints(&model, &plan_of, &Fixed::none()));
        let mut values = Vec::with_capacity(jacobian.entries());
        let nothing = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
        let mut sequence = Sequence::new(&model, &nothing);
        meter.of("fill the Jacobian", || sequence.assemble(&state, &jacobian, &mut values)).unwrap();
        assert!(values.iter().filter(|value| **value != 0.0).count() > connectors);
        meter.of(AGAIN, || sequence.assemble(&state, &jacobian, &mut values)).unwrap();
        let mut sink = io::sink();
        meter
            .of("write it as Matrix Market", || {
                matrix_market::write(&mut sink, "a chain", &model, &jacobian, &values)
            })
            .unwrap();
        drop((jacobian, values, sequence));
        for (phase, is_json, order) in [
            ("evaluate, CSV, order 0", false, 0),
            ("evaluate, CSV, order 1", false, 1),
            ("evaluate, JSON, order 1", true, 1),
        ] {
            let plan = plan(order);
            let written = meter.of(phase, || {
                let mut sink: Box<dyn Write> = Box::new(io::sink());
                let mut format: Box<dyn Format> = match is_json {
                    true => Box::new(Json::new(&mut sink)),
                    false => Box::new(Csv::new(&mut sink, OUTPUTS.to_vec(), order)),
                };
                write(&scene, &model, &plan, &state, format.as_mut())
            });
            assert_eq!(written, connectors);
        }
    }
    [deck, states].iter().for_each(|path| std::fs::remove_file(path).unwrap());
    meter
}

/// What a table tells of a cost, of so many connectors.
type Cell = fn(&Cost, f64) -> String;

fn main() {
    if commit::is_told() {
        return;
    }
    let most: usize = std::env::args().filter_map(|word| word.parse().ok()).next().unwrap_or(1_000_000);
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    let sizes: Vec<usize> = [1, 100, 1000, 10_000, 100_000, 1_000_000]
        .into_iter()
        .filter(|size| *size < most)
        .chain([most])
        .collect();
    let meters: Vec<Meter> = sizes.iter().map(|size| measure(*size)).collect();
    let heads: String = sizes.iter().map(|size| format!("{:>9}", format!("{:e}", *size as f64))).collect();
    println!("a chain of connectors of every type, one thread; for each connector:");
    let tables: [(&str, Cell); 3] = [
        ("microseconds", |cost, connectors| format!("{:.3}", 1e6 * cost.seconds / connectors)),
        ("bytes that it leaves", |cost, _| format!("{:.0}", cost.held)),
        ("bytes while at work", |cost, _| format!("{:.0}", cost.most)),
    ];
    for (what, of) in tables {
        println!("{what:28}{heads}");
        for (at, Cost { phase, .. }) in meters[0].costs.iter().enumerate() {
            let each = meters.iter().map(|meter| format!("{:>9}", of(&meter.costs[at], meter.connectors)));
            println!("{phase:28}{}", each.collect::<String>());
        }
    }
    let largest = meters.last().unwrap();
    for cost in largest.costs.iter().filter(|cost| cost.phase.starts_with("evaluate")) {
        println!(
            "{}: {:.3e} connectors per second, of {:e}",
            cost.phase,
            largest.connectors / cost.seconds,
            largest.connectors
        );
    }
    for (meter, next) in meters.iter().zip(&meters[1..]) {
        for (cost, next_cost) in meter.costs.iter().zip(&next.costs) {
            let [few, many] = [cost.most, next_cost.most].map(|bytes| bytes.max(8.0));
            assert!(
                many < LINEAR * few || many < 100.0,
                "{}: {few:.0} bytes for each of {} connectors, {many:.0} for each of {}",
                cost.phase,
                meter.connectors,
                next.connectors
            );
        }
    }
}
