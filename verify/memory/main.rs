//! Memory does not grow with the number of states: they are read, evaluated and written one at a time.
//!
//! A binary of its own, because the counter of memory counts all of it.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

#[path = "../scale/chain.rs"]
mod chain;

use peak_alloc::PeakAlloc;
use pintle_kinematics::connector::{Output, Request};
use pintle_model::evaluate::{Item, Model, Plan, Selection, Sequence};
use pintle_report::csv::Csv;
use pintle_report::json::Json;
use pintle_report::{Block, BlockKind, Format, Subject};
use pintle_scene::{
    Diagnostic, ForceSign, ForceStream, NodeMotion, Rotation, Scene, State, StateIndex, StateMark,
    StateStream,
};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// One test at a time: the counter of memory is that of all.
static ALONE: Mutex<()> = Mutex::new(());

const CONNECTORS: usize = 120;
const FEW: u64 = 10;
const MANY: u64 = 120;

/// A file of states, written one at a time.
fn file(states: u64, is_json: bool) -> PathBuf {
    let ending = if is_json { "json" } else { "csv" };
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("memory-{states}.{ending}"));
    let mut out = BufWriter::new(File::create(&path).unwrap());
    match is_json {
        true => out.write_all(b"{\"schema\": \"pintle-states/1\", \"states\": [").unwrap(),
        false => out.write_all(b"state,time,node,u1,u2,u3,ur1,ur2,ur3,v1,v2,v3\n").unwrap(),
    }
    for number in 0..states {
        let state = chain::state(number, CONNECTORS + 1);
        if is_json {
            out.write_all(if number > 0 { b",\n" } else { b"\n" }).unwrap();
            serde_json::to_writer(&mut out, &state).unwrap();
            continue;
        }
        let mut rows = String::new();
        for (node, motion) in &state.nodes {
            let NodeMotion { displacement: [u1, u2, u3], velocity: [v1, v2, v3], .. } = motion;
            let Rotation::Vector([r1, r2, r3]) = motion.rotation else { panic!("{node}") };
            let time = number as f64 * 0.125;
            writeln!(rows, "{number},{time},{node},{u1},{u2},{u3},{r1},{r2},{r3},{v1},{v2},{v3}").unwrap();
        }
        out.write_all(rows.as_bytes()).unwrap();
    }
    if is_json {
        out.write_all(b"]}").unwrap();
    }
    out.flush().unwrap();
    path
}

/// The number of states in a file, and by how many bytes memory grew to evaluate and write them all.
fn peak(path: &Path, scene: &Scene, plan: (&Model, &Plan), is_json: bool) -> (u64, usize) {
    let (model, plan) = plan;
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    let mut out: Box<dyn Write> = Box::new(io::sink());
    let outputs = plan.request.outputs().collect();
    let mut format: Box<dyn Format> = match is_json {
        true => Box::new(Json::new(&mut out)),
        false => Box::new(Csv::new(&mut out, outputs, 1)),
    };
    let (mut sequence, mut texts) = (Sequence::new(model, plan), Vec::new());
    format.begin().unwrap();
    format.scene(&Subject { scene, model, plan, states: 0, shown: &[], first: 0, last: 0 }).unwrap();
    let stream = StateStream::open(path).unwrap();
    let read = stream.for_each(scene, |state: State| -> Result<(), Diagnostic> {
        format.state(sequence.states(), state.time).unwrap();
        let render = format.renderer();
        let digest = |item: Item<'_>, text: &mut Vec<u8>| match item {
            Item::Connector(result) => {
                text.clear();
                render(&Block::of_connector(model, &plan.request, result), text).unwrap();
            }
            Item::Mpc(_) | Item::Relation(_) => panic!("there are no constraints"),
        };
        let put = |text: &mut Vec<u8>| format.rendered(BlockKind::Connector, text);
        sequence.visit_digested(&state, &mut texts, digest, put).unwrap();
        format.end_state().unwrap();
        Ok(())
    });
    read.unwrap();
    format.end().unwrap();
    (sequence.states(), ALLOCATOR.peak_usage() - before)
}

/// Twelve times the states take no more memory, though a file of them is many times as large as what is taken.
#[test]
fn memory_does_not_grow_with_states() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let deck = chain::deck(CONNECTORS, &chain::types(), "");
    let scene = Scene::parse("chain.inp", &deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    let request = Request::new(&[Output::CP, Output::CU, Output::CV, Output::RES], [true; 6], 1);
    let plan = Plan::compile(&model, &Selection::All, request).unwrap();
    for is_json in [false, true] {
        let [few, many] = [FEW, MANY].map(|states| file(states, is_json));
        // What is made once in the life of the program is made here.
        peak(&few, &scene, (&model, &plan), is_json);
        let (counted_few, of_few) = peak(&few, &scene, (&model, &plan), is_json);
        let (counted_many, of_many) = peak(&many, &scene, (&model, &plan), is_json);
        assert_eq!((counted_few, counted_many), (FEW, MANY));
        let (held, bytes) = (of_many as f64 / of_few as f64, many.metadata().unwrap().len());
        println!(
            "json {is_json}: {of_few} bytes for {FEW} states, {of_many} for {MANY}, of a file of {bytes}"
        );
        assert!(held < 1.2, "{of_few} bytes for {FEW} states, {of_many} for {MANY}");
        assert!((of_many as u64) < bytes / 2, "{of_many} bytes for a file of {bytes}");
    }
}

/// Forces of a file are held for one state, too.
#[test]
fn memory_does_not_grow_with_forces() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let deck = chain::deck(CONNECTORS, &chain::types(), "");
    let scene = Scene::parse("chain.inp", &deck).unwrap();
    let path = |states: u64, is_json: bool| {
        let ending = if is_json { "json" } else { "csv" };
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("memory-forces-{states}.{ending}"))
    };
    let write = |states: u64, is_json: bool| {
        let mut out = BufWriter::new(File::create(path(states, is_json)).unwrap());
        let elements = || scene.connectors.keys();
        if is_json {
            let forces: Vec<String> =
                elements().map(|label| format!("\"{label}\": {{\"f1\": 0.125}}")).collect();
            let of = |state: u64| format!("{{\"state\": {state}, \"forces\": {{{}}}}}", forces.join(", "));
            let all: Vec<String> = (0..states).map(of).collect();
            write!(out, "{{\"schema\": \"pintle-forces/1\", \"states\": [{}]}}", all.join(", ")).unwrap();
        } else {
            writeln!(out, "state,element,f1").unwrap();
            for state in 0..states {
                elements().for_each(|label| writeln!(out, "{state},{label},0.125").unwrap());
            }
        }
        out.flush().unwrap();
    };
    let peak = |states: u64, is_json: bool| {
        let marks = vec![StateMark::default(); states as usize];
        let before = ALLOCATOR.current_usage();
        let index = StateIndex::new(&marks, 0);
        let of_index = ALLOCATOR.current_usage() - before;
        assert!(of_index <= 16 * states as usize, "{of_index} bytes for the index of {states} states");
        ALLOCATOR.reset_peak_usage();
        let before = ALLOCATOR.current_usage();
        let mut read = 0;
        let stream = ForceStream::open(path(states, is_json), ForceSign::Internal).unwrap();
        let all = stream.for_each(&scene, &index, |place, forces| -> Result<(), Diagnostic> {
            assert_eq!((place as u64, forces.elements.len()), (read, CONNECTORS));
            read += 1;
            Ok(())
        });
        all.unwrap();
        assert_eq!(read, states);
        ALLOCATOR.peak_usage() - before
    };
    for is_json in [false, true] {
        [FEW, MANY].into_iter().for_each(|states| write(states, is_json));
        peak(FEW, is_json);
        let [few, many] = [FEW, MANY].map(|states| peak(states, is_json));
        assert!((many as f64) < 1.2 * few as f64, "{few} bytes for {FEW} states, {many} for {MANY}");
    }
}

/// Results of other programs are held for one state, too: a list in JSON, lines of JSON, a table.
#[test]
fn memory_does_not_grow_with_results() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=PIN\n7, 1, 2\n*CONNECTOR SECTION, ELSET=PIN\nCARTESIAN\n";
    let scene = Scene::parse("pin.inp", deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    // More than are kept of a series.
    let (few, many) = (6_000, 40_000);
    let write = |states: u32, ending: &str| {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("memory-results-{states}.{ending}"));
        let mut out = BufWriter::new(File::create(&path).unwrap());
        let [first, between, last] = match ending {
            "json" => ["[\n", ",\n", "\n]\n"],
            "jsonl" => ["", "\n", "\n"],
            _ => ["time,node,U1,element,CU1\n", "\n", "\n"],
        };
        out.write_all(first.as_bytes()).unwrap();
        for state in 0..states {
            let (time, u) = (f64::from(state) * 0.125, f64::from(state % 64) * 0.5);
            if state > 0 {
                out.write_all(between.as_bytes()).unwrap();
            }
            match ending {
                "csv" => write!(out, "{time},2,{u:.2},7,{u:.2}").unwrap(),
                _ => write!(
                    out,
                    "{{\"time\": {time}, \"node\": \"2\", \"U1\": {u:.2}, \"element\": \"7\", \"CU1\": {u:.2}}}"
                )
                .unwrap(),
            }
        }
        out.write_all(last.as_bytes()).unwrap();
        out.flush().unwrap();
        path
    };
    let peak = |path: &Path, states: u32| {
        let results = pintle_compare::Results::new(vec![path.to_path_buf()], pintle_compare::Map::default());
        ALLOCATOR.reset_peak_usage();
        let before = ALLOCATOR.current_usage();
        let found = pintle_compare::compare(&scene, &model, &results).unwrap();
        assert_eq!((found.compared(), found.wrong()), (u64::from(states), 0));
        ALLOCATOR.peak_usage() - before
    };
    for ending in ["csv", "jsonl", "json"] {
        let [one, other] = [few, many].map(|states| (write(states, ending), states));
        let [of_few, of_many] = [one, other].map(|(path, states)| peak(&path, states));
        println!("{ending}: {of_few} bytes for {few} states, {of_many} for {many}");
        assert!(
            (of_many as f64) < 1.2 * of_few as f64,
            "{ending}: {of_few} bytes for {few}, {of_many} for {many}"
        );
    }
}
