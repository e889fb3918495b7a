//! Batches, on the states that `scripts/measure.py` hands to num-dual (`num_dual.rs`), JAX and CasADi too.
//!
//! Every variant is compared with the 237-bit scalar before it is timed. By itself it prints one round:
//! `taskset -c 3 cargo bench --bench peers`. With `--export FILE` it writes the states and the truth; with `--serve` it runs a round
//! for each line that it reads, for the script, which takes the rounds of all in turn.
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;
mod hand {
    pub(crate) mod clock;
    pub(crate) mod peer;
    pub(crate) mod types;
}

use hand::clock::{BATCHES, time};
use hand::peer::{numbers, serve};
use hand::types::TYPES;
use pintle_audit::case::exact_state;
use pintle_bench::worse;
use pintle_kinematics::batch::{
    Array, Batch, Columns, History, Nodes, Orientation, Row, Section, States, Tile,
};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Connector, Definition, Increment, Output, Request, State, Tally};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::vector;
use pulp::{Arch, Simd, WithSimd};
use serde_json::{Map, Value, json};
use std::hint::black_box;

/// States that differ; larger batches repeat them.
const STATES: usize = 1000;
/// The largest error over the largest entry of the row.
const BOUND: f64 = 1e-14;

fn states() -> Vec<Pair<f64>> {
    let draw = &mut Draw::new("peers");
    let node = |draw: &mut Draw| Node { displacement: draw.vector(1.0), triad: draw.triad(), flow: 0.0 };
    (0..STATES).map(|_| Pair { reference: draw.vector(1.0), a: node(draw), b: node(draw) }).collect()
}

fn at_rest(pair: &Pair<f64>) -> State<f64> {
    State { pair: *pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }
}

/// A value and its derivatives by x_a, θ_a, x_b, θ_b.
type Entry = (f64, [f64; 12]);

struct Case {
    name: &'static str,
    connector: Connector<f64>,
    batch: Batch,
    /// The rows of each state, by the 237-bit scalar.
    truth: Vec<Vec<Entry>>,
}

impl Case {
    fn new(name: &'static str, states: &[Pair<f64>]) -> Self {
        let still = Node { displacement: [0.0; 3], triad: vector::identity(), flow: 0.0 };
        // Q₀ = I exactly, so that the peers need not know it.
        let initial = Pair { reference: [0.5, -0.2, 0.3], a: still, b: still };
        let definition = Definition::new(ConnectionType::named(name, None).unwrap(), initial);
        let connector = Connector::<f64>::new(&definition);
        let wide = Connector::<Wide>::new(&definition);
        let batch = Batch::new(&connector, [true; 6]).unwrap();
        let request = Request::new(&[Output::CP, Output::RES], [true; 6], 1);
        let truth = states
            .iter()
            .map(|pair| {
                let found = wide.evaluate(
                    &exact_state(&at_rest(pair)),
                    &Increment::none(),
                    &wide.initial_branch(),
                    &request,
                    &mut Tally::default(),
                );
                let of = |(k, _): &(usize, _)| {
                    let value =
                        if wide.is_printed_constraint(*k) { found.residual[*k] } else { found.position[*k] };
                    let row = found.jacobian[*k].unwrap().map(Wide::to_f64);
                    let mut columns = [0.0; 12];
                    columns[..6].copy_from_slice(&row[..6]);
                    columns[6..].copy_from_slice(&row[7..13]);
                    (value.unwrap().to_f64(), columns)
                };
                batch.measures().iter().map(of).collect()
            })
            .collect();
        Self { name, connector, batch, truth }
    }

    /// The largest error of the entries of the rows that `of` gives for a state and a row.
    fn error(&self, of: impl Fn(usize, usize) -> Entry) -> f64 {
        let mut worst: f64 = 0.0;
        for (i, rows) in self.truth.iter().enumerate() {
            for (r, (value, columns)) in rows.iter().enumerate() {
                let (found, row) = of(i, r);
                let scale = columns.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                worst = worse(worst, (found - value).abs() / scale.max(value.abs()));
                for (x, y) in row.iter().zip(columns) {
                    worst = worse(worst, (x - y).abs() / scale);
                }
            }
        }
        worst
    }
}

/// The input and output of batches.
struct Lanes {
    tiles: Vec<Tile>,
    sections: Vec<Section>,
    histories: Vec<History>,
    rows: Vec<Row>,
}

impl Lanes {
    fn new(case: &Case, states: &[Pair<f64>], count: usize) -> Self {
        let fours: Vec<[Pair<f64>; 4]> = (0..count / 4)
            .map(|tile| std::array::from_fn(|lane| states[(4 * tile + lane) % states.len()]))
            .collect();
        let branch = case.connector.initial_branch();
        Self {
            tiles: fours.iter().map(Tile::new).collect(),
            sections: vec![Section::new(&[&case.connector; 4]); fours.len()],
            histories: vec![History::new(&[branch; 4]); fours.len()],
            rows: vec![Row::default(); fours.len() * case.batch.rows()],
        }
    }

    fn run(&mut self, case: &Case) {
        let Self { tiles, sections, histories, rows } = self;
        case.batch.rows_of(black_box(tiles), sections, histories, black_box(rows)).unwrap();
    }
}

/// Arrays of states in C order, into arrays of values and rows, as all others read and write them.
struct Arrays {
    reference: Vec<f64>,
    displacement: [Vec<f64>; 2],
    triad: [Vec<f64>; 2],
    sections: [Section; 1],
    histories: [History; 1],
    values: Vec<f64>,
    rows: Vec<f64>,
}

impl Arrays {
    fn new(case: &Case, flat: &[[f64; 27]], count: usize) -> Self {
        let of = |first: usize, width: usize| -> Vec<f64> {
            (0..count).flat_map(|i| flat[i % flat.len()][first..first + width].iter().copied()).collect()
        };
        let n = case.batch.rows();
        Self {
            reference: of(0, 3),
            displacement: [of(3, 3), of(6, 3)],
            triad: [of(9, 9), of(18, 9)],
            sections: [Section::new(&[&case.connector; 4])],
            histories: [History::new(&[case.connector.initial_branch(); 4])],
            values: vec![0.0; count * n],
            rows: vec![0.0; count * n * 12],
        }
    }

    fn run(&mut self, case: &Case) {
        let Self { reference, displacement, triad, sections, histories, values, rows } = self;
        let node = |end: usize| Nodes {
            displacement: Array::new(&displacement[end], 3),
            orientation: Orientation::Triad(Array::new(&triad[end], 9)),
        };
        let states = States {
            count: reference.len() / 3,
            reference: Array::new(reference, 3),
            nodes: [node(0), node(1)],
            sections,
            histories,
        };
        case.batch
            .rows_of_states(black_box(&states), Columns::Twelve, black_box(values), black_box(rows))
            .unwrap();
    }

    /// The entries of a row of a state.
    fn entry(&self, n: usize, i: usize, r: usize) -> Entry {
        let at = n * i + r;
        (self.values[at], std::array::from_fn(|j| self.rows[12 * at + j]))
    }

    /// A loop that reads what is read, and writes as much as is written.
    fn moved(&mut self) {
        let Self { reference, displacement: [x_a, x_b], triad: [a, b], values, rows, .. } = black_box(self);
        let read = [&*reference, x_a, x_b, a, b].map(|all| &all[..]);
        Arch::new().dispatch(Move { read, written: [values, rows] });
        black_box(rows);
    }
}

/// Sums all that is read, by sixteen, and writes the sum everywhere, on the vector unit that there is.
struct Move<'l> {
    read: [&'l [f64]; 5],
    written: [&'l mut [f64]; 2],
}

impl WithSimd for Move<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) {
        let mut sums = [0.0; 16];
        for all in self.read {
            let (parts, rest) = all.as_chunks::<16>();
            for part in parts {
                for k in 0..16 {
                    sums[k] += part[k];
                }
            }
            for x in rest {
                sums[0] += x;
            }
        }
        let mut sum = 0.0;
        for x in sums {
            sum += x;
        }
        for all in self.written {
            for x in all {
                *x = sum;
            }
        }
    }
}

/// The variants, in the order in which they are measured.
const VARIANTS: [&str; 3] = ["pintle", "pintle, tiles", "the same bytes, moved"];

struct Bench {
    states: Vec<Pair<f64>>,
    flat: Vec<[f64; 27]>,
    cases: Vec<Case>,
}

impl Bench {
    fn new() -> Self {
        let states = states();
        let cases = TYPES.iter().map(|name| Case::new(name, &states)).collect();
        Self { flat: states.iter().map(numbers).collect(), states, cases }
    }

    fn export(&self) -> Value {
        let types: Map<String, Value> = self
            .cases
            .iter()
            .map(|case| {
                let values: Vec<Vec<f64>> =
                    case.truth.iter().map(|rows| rows.iter().map(|row| row.0).collect()).collect();
                let rows: Vec<Vec<[f64; 12]>> =
                    case.truth.iter().map(|rows| rows.iter().map(|row| row.1).collect()).collect();
                (case.name.to_owned(), json!({ "values": values, "jacobian": rows }))
            })
            .collect();
        json!({ "states": self.flat, "types": types })
    }

    /// Errors by variant and type; panics where one is not small.
    fn errors(&self) -> Value {
        let mut errors = VARIANTS.map(|_| Map::new());
        for case in &self.cases {
            let mut lanes = Lanes::new(case, &self.states, STATES);
            lanes.run(case);
            let n = case.batch.rows();
            let tiles = case.error(|i, r| {
                let row = &lanes.rows[i / 4 * n + r];
                (row.value[i % 4], row.columns.map(|four| four[i % 4]))
            });
            let mut arrays = Arrays::new(case, &self.flat, STATES);
            arrays.run(case);
            // Nothing is computed where bytes are moved.
            let found = [case.error(|i, r| arrays.entry(n, i, r)), tiles, 0.0];
            for (at, error) in found.into_iter().enumerate() {
                assert!(error < BOUND, "{}: {error:e} where {BOUND:e} is allowed", case.name);
                errors[at].insert(case.name.to_owned(), json!(error));
            }
        }
        by_variant(errors)
    }

    /// ns per state, by variant, batch and type.
    fn round(&self) -> Value {
        let mut times = VARIANTS.map(|_| Map::new());
        for count in BATCHES {
            let mut of = VARIANTS.map(|_| Map::new());
            for case in &self.cases {
                let mut lanes = Lanes::new(case, &self.states, count);
                let tiles = time(count, || lanes.run(case)) / count as f64;
                drop(lanes);
                let mut arrays = Arrays::new(case, &self.flat, count);
                let rows = time(count, || arrays.run(case)) / count as f64;
                let moved = time(count, || arrays.moved()) / count as f64;
                for (of, ns) in of.iter_mut().zip([rows, tiles, moved]) {
                    of.insert(case.name.to_owned(), json!(ns));
                }
            }
            for (times, of) in times.iter_mut().zip(of) {
                times.insert(count.to_string(), Value::Object(of));
            }
        }
        by_variant(times)
    }
}

fn by_variant(of: [Map<String, Value>; 3]) -> Value {
    let named = VARIANTS.iter().zip(of).map(|(name, of)| ((*name).to_owned(), Value::Object(of)));
    Value::Object(named.collect())
}

fn main() {
    if commit::is_told() {
        return;
    }
    let words: Vec<String> = std::env::args().collect();
    let bench = Bench::new();
    if let Some(at) = words.iter().position(|word| word == "--export") {
        std::fs::write(&words[at + 1], bench.export().to_string()).unwrap();
        return;
    }
    if let Some(at) = words.iter().position(|word| word == "--once") {
        let [name, count, calls] = &words[at + 1..] else { return eprintln!("--once TYPE BATCH CALLS") };
        let case = bench.cases.iter().find(|case| case.name == name).unwrap();
        let mut lanes = Lanes::new(case, &bench.states, count.parse().unwrap());
        (0..calls.parse().unwrap()).for_each(|_: usize| lanes.run(case));
        return;
    }
    let errors = bench.errors();
    if words.iter().any(|word| word == "--serve") {
        let greeting = json!({ "errors": errors, "versions": { "pintle": pintle::VERSION } });
        serve(&greeting, || bench.round());
        return;
    }
    let times = bench.round();
    println!("ns per state, value and 12 columns; largest error of an entry over the largest of its row");
    for variant in VARIANTS {
        for name in TYPES {
            let error = errors[variant][name].as_f64().unwrap();
            print!("{variant:20} {name:12} {error:8.1e}");
            for count in BATCHES {
                print!("  {count}: {:8.2}", times[variant][&count.to_string()][name].as_f64().unwrap());
            }
            println!();
        }
    }
}
