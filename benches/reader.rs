//! Reading speed and memory: a deck of a million lines, and files of states, beside a plain count of their lines.
//!
//! What is read is compared with what was written before anything is timed. Memory is counted by the allocator: what is kept,
//! and the peak on the way, for each node and element kept. Read times as ratios to the count of lines within one run.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use peak_alloc::PeakAlloc;
use pintle_scene::{Label, Scene, StateFile};
use std::fmt::Write;
use std::hint::black_box;
use std::io::BufRead;
use std::time::Instant;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Data lines of the deck, by kind; keywords and comments make up the million.
const NODES: usize = 400_000;
const CONNECTORS: usize = 150_000;
const SOLIDS: usize = 350_000;
const SET_LINES: usize = 60_000;
const LINES: usize = 1_000_000;

/// Connection types of the sections, which share the connectors equally.
const TYPES: [&str; 5] = ["HINGE", "UJOINT", "TRANSLATOR", "CARTESIAN, CARDAN", "BUSHING"];

/// Rows of the files of states: nodes × states.
const STATES: usize = 100;
const MOVED: usize = 1_000;

fn x(node: usize) -> f64 {
    node as f64 * 0.125
}

fn deck() -> String {
    let mut text = String::with_capacity(45_000_000);
    text.push_str("*HEADING\na million lines\n*NODE, NSET=ALL\n");
    for node in 1..=NODES {
        writeln!(text, "{node:8}, {:14.6}, {:14.6e}, {:10.4}", x(node), -x(node), node % 7).unwrap();
    }
    text.push_str("*ELEMENT, TYPE=C3D8R, ELSET=BODY\n");
    for solid in 0..SOLIDS {
        let [a, b] = [solid + 1, solid + 9];
        writeln!(
            text,
            "{}, {a}, {}, {}, {}, {b}, {}, {}, {}",
            1_000_000 + solid,
            a + 1,
            a + 2,
            a + 3,
            b + 1,
            b + 2,
            b + 3
        )
        .unwrap();
    }
    text.push_str("*ORIENTATION, NAME=AXES\n0., 0., 1., 1., 0., 0.\n");
    let each = CONNECTORS / TYPES.len();
    for (place, types) in TYPES.iter().enumerate() {
        writeln!(text, "*ELEMENT, TYPE=CONN3D2, ELSET=JOINTS-{place}").unwrap();
        for connector in place * each..(place + 1) * each {
            writeln!(text, "{}, {}, {}", connector + 1, 2 * connector + 1, 2 * connector + 2).unwrap();
        }
        writeln!(text, "*CONNECTOR SECTION, ELSET=JOINTS-{place}\n{types}\nAXES,").unwrap();
    }
    text.push_str("*NSET, NSET=LISTED\n");
    for line in 0..SET_LINES {
        let from = line * 5 % (NODES - 16);
        let members: Vec<String> = (1..=16).map(|step| (from + step).to_string()).collect();
        writeln!(text, "{}", members.join(", ")).unwrap();
    }
    let rest = LINES - text.lines().count();
    (0..rest).for_each(|_| text.push_str("** a comment, as preprocessors leave them\n"));
    text
}

/// Panics unless the scene is what was written.
fn assert_read(scene: &Scene) {
    assert_eq!((scene.nodes.len(), scene.connectors.len()), (NODES, CONNECTORS));
    assert_eq!(scene.skipped.element_types["C3D8R"].count, SOLIDS as u64);
    assert_eq!(scene.node_sets["ALL"].labels.len(), NODES);
    assert_eq!(scene.node_sets["LISTED"].labels.len(), SET_LINES * 5 + 11);
    assert!(scene.warnings.is_empty());
    for node in [1, 77, NODES] {
        let at = scene.nodes[&Label::from(node as u64)].coordinates;
        assert_eq!((at[0], at[2]), (x(node), (node % 7) as f64));
        assert!((at[1] + x(node)).abs() <= 1e-6 * x(node));
    }
    let connector = &scene.connectors[&Label::from(CONNECTORS as u64)];
    assert_eq!(connector.b, Some(Label::from(2 * CONNECTORS as u64)));
    assert_eq!(scene.connector_sections.len(), TYPES.len());
}

fn csv() -> String {
    let mut text = String::from("state,time,node,u1,u2,u3,ur1,ur2,ur3,v1,v2,v3\n");
    for state in 0..STATES {
        for node in 1..=MOVED {
            let u = x(node) / (state + 3) as f64;
            writeln!(
                text,
                "{state},{},{node},{u},{},0,{},0,0.25,{},0,1",
                state as f64 * 0.1,
                -u,
                u / 1e3,
                u * u
            )
            .unwrap();
        }
    }
    text
}

/// The time of the quickest of a few runs, in seconds.
fn quickest<T>(mut run: impl FnMut() -> T) -> f64 {
    let time = |_| {
        let begun = Instant::now();
        black_box(run());
        begun.elapsed().as_secs_f64()
    };
    (0..5).map(time).fold(f64::INFINITY, f64::min)
}

/// Lines, counted by reading them one after the other into a buffer, as a reader must at least.
fn count_lines(text: &str) -> usize {
    let (mut input, mut line, mut count) = (text.as_bytes(), Vec::new(), 0);
    while input.read_until(b'\n', &mut line).unwrap() > 0 {
        line.clear();
        count += 1;
    }
    count
}

/// Prints speed beside a count of lines, and memory for each of `kept`.
fn tell<T>(what: &str, text: &str, kept: usize, read: impl Fn() -> T) {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let result = read();
    let each = |bytes: usize| (bytes - before) as f64 / kept as f64;
    let (peak, held) = (each(MEMORY.peak_usage()), each(MEMORY.current_usage()));
    drop(result);
    let (reading, counting) = (quickest(read), quickest(|| count_lines(text)));
    let speed = |seconds: f64| text.len() as f64 / 1e6 / seconds;
    println!(
        "{what}: {:.0} MB/s, {:.1} × the time of counting lines ({:.0} MB/s); {held:.0} B kept and {peak:.0} B at the peak for each of {kept}",
        speed(reading),
        reading / counting,
        speed(counting),
    );
}

fn reader(criterion: &mut Criterion) {
    let deck = deck();
    assert_eq!(count_lines(&deck), LINES);
    let read = || Scene::parse("deck.inp", &deck).unwrap();
    let scene = read();
    assert_read(&scene);
    let csv = csv();
    let read_csv = || StateFile::parse_csv("states.csv", &csv, &scene).unwrap();
    let states = read_csv();
    assert_eq!((states.states.len(), states.states[STATES - 1].nodes.len()), (STATES, MOVED));
    let json = states.to_json().unwrap();
    let read_json = || StateFile::parse_json("states.json", &json, &scene).unwrap();
    assert_eq!(read_json(), states);

    tell("deck of a million lines", &deck, NODES + CONNECTORS, read);
    tell("states as CSV", &csv, STATES * MOVED, read_csv);
    tell("states as JSON", &json, STATES * MOVED, read_json);

    let mut group = criterion.benchmark_group("reader");
    group.sample_size(10);
    group.throughput(Throughput::Bytes(deck.len() as u64));
    group.bench_function("count the lines of the deck", |timer| timer.iter(|| count_lines(black_box(&deck))));
    group.bench_function("read the deck", |timer| {
        timer.iter(|| Scene::parse("deck.inp", black_box(&deck)).unwrap())
    });
    group.throughput(Throughput::Bytes(csv.len() as u64));
    group.bench_function("read states as CSV", |timer| {
        timer.iter(|| StateFile::parse_csv("states.csv", black_box(&csv), &scene).unwrap());
    });
    group.throughput(Throughput::Bytes(json.len() as u64));
    group.bench_function("read states as JSON", |timer| {
        timer.iter(|| StateFile::parse_json("states.json", black_box(&json), &scene).unwrap());
    });
    group.finish();
}

criterion_group!(benches, reader);
criterion_main!(benches);
