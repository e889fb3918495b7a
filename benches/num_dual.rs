//! num-dual as it comes, with a seed for each nodal degree of freedom, and its formulas on doubles alone, beside which pintle is measured.
//!
//! A program of its own, so that it can have its best build whatever the build of pintle costs: its functions are compiled with their
//! caller, and `scripts/measure.py` compiles this in one unit and for the processor at hand,
//! `cargo rustc --profile bench --all-features --bench num_dual -- -C codegen-units=1 -C target-cpu=native`. In the sixteen units of the profile they are
//! called instead of inlined, and take three to five times as long. The script has these settings compiled in besides (`PINTLE_BENCH_BUILD`); the program answers
//! `--build` with them, and the script takes none that does not.
//!
//! It takes part in what the script measures, as the peers in Python do: with `--peers FILE` on the states that `benches/peers.rs` exports, with
//! `--precision` on those of `benches/work_precision.rs`. Without either it prints one round of the latter.
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;
mod hand {
    pub(crate) mod clock;
    pub(crate) mod common;
    pub(crate) mod naive;
    pub(crate) mod over_lanes;
    pub(crate) mod peer;
    pub(crate) mod types;
}

use hand::clock::{BATCHES, time};
use hand::common::{flat, is_written, settings, spread, untimed};
use hand::peer::serve;
use hand::types::TYPES;
use hand::{naive, over_lanes};
use num_dual::{Dual2SVec, DualSVec};
use pintle_bench::{Cause, Method, Order, Prepared, Report, Rows, Session, Subject, Tiles, worse};
use pintle_kinematics::batch::{COLUMNS, LANES};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::Seeded;
use pintle_report::bench as report;
use serde_json::{Map, Value, json};
use std::hint::black_box;

/// The largest error over the largest entry of the row, by formulas without branches as close to half a turn as the states come.
const BOUND: f64 = 1e-6;

/// num-dual as it comes, a seed for each degree of freedom; for values its functions of doubles, without seeds.
struct NumDual(Order);

impl Method for NumDual {
    fn name(&self) -> &'static str {
        match self.0 {
            Order::Value => "num-dual, no seeds",
            _ => "num-dual, 12 seeds",
        }
    }

    fn order(&self) -> Order {
        self.0
    }

    fn cause(&self) -> Cause {
        Cause::NoBranches
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
        is_written(subject)?;
        Ok(Box::new(ByNumDual {
            order: self.0,
            name: &subject.connection.name,
            flat: flat(subject),
            count: subject.rows(),
            values: [0.0; 6],
            rows: [[0.0; 12]; 6],
            hessians: [[[0.0; 12]; 12]; 6],
        }))
    }
}

struct ByNumDual<'s> {
    order: Order,
    name: &'s str,
    flat: Vec<[f64; 27]>,
    count: usize,
    values: [f64; 6],
    rows: [[f64; 12]; 6],
    hessians: [[[f64; 12]; 12]; 6],
}

impl ByNumDual<'_> {
    #[inline(always)]
    fn one(&mut self, i: usize) {
        let Self { order, name, flat, values, rows, hessians, .. } = self;
        let state = &flat[i];
        match order {
            Order::Value => naive::rows(name, state, &mut |r, x: f64| values[r] = x),
            Order::Jacobian => naive::rows(name, state, &mut |r, x: DualSVec<f64, 12>| {
                rows[r] = Seeded::gradient(x);
            }),
            Order::Hessian => naive::rows(name, state, &mut |r, x: Dual2SVec<f64, 12>| {
                hessians[r] = Seeded::hessian(x);
            }),
        }
    }
}

impl Prepared for ByNumDual<'_> {
    fn run(&mut self) {
        for i in 0..self.flat.len() {
            self.one(i);
            black_box((&mut self.values, &mut self.rows, &mut self.hessians));
        }
    }

    fn states(&self) -> usize {
        self.flat.len()
    }

    fn numbers(&mut self) -> Vec<f64> {
        let mut all = Vec::new();
        for i in 0..self.flat.len() {
            self.one(i);
            match self.order {
                Order::Value => all.extend(&self.values[..self.count]),
                Order::Jacobian => all.extend(self.rows[..self.count].iter().flat_map(spread)),
                Order::Hessian => all.extend(self.hessians[..self.count].iter().flat_map(spread_matrix)),
            }
        }
        all
    }
}

/// num-dual over four lanes, with a seed for each relative variation: on the tiles of a batch, into its rows.
struct OverLanes;

impl Method for OverLanes {
    fn name(&self) -> &'static str {
        "num-dual on four lanes, relative"
    }

    fn order(&self) -> Order {
        Order::Jacobian
    }

    fn cause(&self) -> Cause {
        Cause::NoBranches
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
        is_written(subject)?;
        let (tiles, rows) = (Tiles::new(subject)?, Rows::new(Order::Jacobian, subject)?);
        Ok(Box::new(ByLanes { name: &subject.connection.name, tiles, rows }))
    }
}

struct ByLanes<'s> {
    name: &'s str,
    tiles: Tiles,
    rows: Rows,
}

impl Prepared for ByLanes<'_> {
    fn run(&mut self) {
        let Rows::First(rows) = &mut self.rows else { return };
        let count = self.tiles.batch.rows();
        for (tile, rows) in self.tiles.tiles.iter().zip(rows.chunks_exact_mut(count)) {
            over_lanes::rows(self.name, tile, rows);
        }
    }

    fn states(&self) -> usize {
        LANES * self.tiles.tiles.len()
    }

    fn numbers(&mut self) -> Vec<f64> {
        self.run();
        self.rows.numbers(self.tiles.batch.rows())
    }
}

/// A value and its derivatives by x_a, θ_a, x_b, θ_b.
type Entry = (f64, [f64; 12]);

/// The rows of a state.
fn rows(name: &str, state: &[f64], put: &mut impl FnMut(usize, Entry)) {
    naive::rows(name, state, &mut |r, x: DualSVec<f64, 12>| put(r, (x.re, Seeded::gradient(x))));
}

/// The states that others read, and the truth of each type.
struct Peers {
    states: Vec<[f64; 27]>,
    truth: Map<String, Value>,
}

impl Peers {
    fn read(path: &str) -> Self {
        let content: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        let states = content["states"].as_array().unwrap().iter();
        let states = states.map(|state| numbers(state).try_into().unwrap()).collect();
        Self { states, truth: content["types"].as_object().unwrap().clone() }
    }

    /// The largest errors by type; panics where one is not small.
    fn errors(&self) -> Value {
        let of = self.truth.iter().map(|(name, truth)| {
            let mut worst: f64 = 0.0;
            for (i, state) in self.states.iter().enumerate() {
                rows(name, state, &mut |r, (value, columns)| {
                    let (known, exact) =
                        (truth["values"][i][r].as_f64().unwrap(), numbers(&truth["jacobian"][i][r]));
                    let scale = exact.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                    let entries = columns.iter().zip(exact).map(|(x, y)| (x - y).abs() / scale);
                    for error in entries.chain([(value - known).abs() / scale.max(known.abs())]) {
                        worst = worse(worst, error);
                    }
                });
            }
            assert!(worst < BOUND, "{name}: {worst:e} where {BOUND:e} is allowed");
            (name.clone(), json!(worst))
        });
        json!({ "num-dual": of.collect::<Map<String, Value>>() })
    }

    /// ns per state, by batch and type.
    fn round(&self) -> Value {
        let mut times = Map::new();
        for count in BATCHES {
            let states: Vec<f64> = self.states.iter().cycle().take(count).flatten().copied().collect();
            let of = self.truth.iter().map(|(name, truth)| {
                let n = truth["values"][0].as_array().unwrap().len();
                let mut found = vec![(0.0, [0.0; 12]); n * count];
                let ns = time(count, || {
                    for (state, found) in black_box(&states).chunks_exact(27).zip(found.chunks_exact_mut(n)) {
                        rows(name, state, &mut |r, row| found[r] = row);
                    }
                    black_box(&mut found);
                });
                (name.clone(), json!(ns / count as f64))
            });
            times.insert(count.to_string(), Value::Object(of.collect()));
        }
        json!({ "num-dual": times })
    }
}

fn numbers(of: &Value) -> Vec<f64> {
    of.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn spread_matrix(matrix: &[[f64; 12]; 12]) -> [f64; DOFS * DOFS] {
    let mut all = [0.0; DOFS * DOFS];
    for (i, line) in COLUMNS.iter().zip(matrix) {
        all[i * DOFS..][..DOFS].copy_from_slice(&spread(line));
    }
    all
}

fn main() {
    if commit::is_told() {
        return;
    }
    let words: Vec<String> = std::env::args().collect();
    if words.iter().any(|word| word == "--build") {
        println!("{}", option_env!("PINTLE_BENCH_BUILD").unwrap_or("none"));
        return;
    }
    if let Some(at) = words.iter().position(|word| word == "--peers") {
        let peers = Peers::read(&words[at + 1]);
        serve(&json!({ "errors": peers.errors(), "versions": {} }), || peers.round());
        return;
    }
    let settings = settings();
    let mut found = Report::new(&settings);
    let types = TYPES.map(|name| ConnectionType::named(name, None).unwrap());
    let subjects: Vec<Subject> =
        types.iter().flat_map(|connection| found.subjects(&settings, connection)).collect();
    let methods = Order::ALL.map(NumDual);
    let methods: Vec<&dyn Method> =
        methods.iter().map(|method| method as &dyn Method).chain([&OverLanes as &dyn Method]).collect();
    let mut session = Session::new(&settings, &subjects, &methods);
    if words.iter().any(|word| word == "--precision") {
        found.take(&session);
        serve(&untimed(&found), || json!(session.round()));
        return;
    }
    drop(session.round());
    found.take(&session);
    report::human(&mut anstream::stdout().lock(), &found, 110).unwrap();
}
