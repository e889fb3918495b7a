//! Time against error of values, Jacobians and Hessians, far from singular points and near them: what `pintle bench` measures, and
//! besides it batches, rows and second derivatives by hand, and num-dual with twelve seeds as it comes: `taskset -c 3 cargo bench
//! --bench work_precision`. All go through the same states in batches of the same size.
//!
//! By itself it prints the tables. For `scripts/measure.py`: `--export FILE` writes states and truth for JAX; `--serve` writes the
//! points with their errors, then runs a round for each line read, and answers with the times of the points in the same order;
//! `--draw FILE FOLDER` prints the tables of a report and draws it.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

mod hand {
    #[path = "../../src/scalar/coefficients.rs"]
    #[expect(dead_code, reason = "the rows need some of them")]
    mod coefficients;
    #[cfg(target_arch = "x86_64")]
    mod hessian;
    pub(crate) mod naive;
    pub(crate) mod scalar;
    #[cfg(target_arch = "x86_64")]
    mod simd;
    #[cfg(target_arch = "x86_64")]
    pub(crate) mod sweep;
    pub(crate) mod types;
    #[cfg(target_arch = "x86_64")]
    mod vector;
}

use hand::types::TYPES;
use hand::{naive, scalar};
use num_dual::{Dual2SVec, DualSVec};
use pintle::batch::{Batch, HessianRow, History, Row, Section, Tile};
use pintle::bench::{Method, Order, Point, Prepared, Report, Session, Settings, Subject, Way};
use pintle::catalog::ConnectionType;
use pintle::node::{DOFS, Pair};
use pintle::report::bench as report;
use pintle::scalar::Seeded;
use serde_json::{Map, Value, json};
use std::io::{BufRead, Write};

/// States that differ, and how many elements each way goes through.
const STATES: usize = 64;
const BATCH: usize = 1024;
/// The columns x_a, θ_a, x_b, θ_b in a row of all nodal degrees of freedom.
const PLACE: [usize; 12] = [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12];

/// X_b − X_a, U_a, U_b, A and B by rows.
fn numbers(pair: &Pair<f64>) -> [f64; 27] {
    let vectors = [pair.reference, pair.a.displacement, pair.b.displacement];
    let triads = [pair.a.triad, pair.b.triad];
    let mut all = vectors.iter().flatten().chain(triads.as_flattened().as_flattened());
    std::array::from_fn(|_| *all.next().unwrap())
}

fn flat(subject: &Subject) -> Vec<[f64; 27]> {
    subject.elements.iter().map(|element| numbers(&element.state.pair)).collect()
}

/// A row of twelve columns among all degrees of freedom.
fn spread(columns: &[f64; 12]) -> [f64; DOFS] {
    let mut row = [0.0; DOFS];
    PLACE.iter().zip(columns).for_each(|(j, x)| row[*j] = *x);
    row
}

fn spread_matrix(matrix: &[[f64; 12]; 12]) -> [f64; DOFS * DOFS] {
    let mut all = [0.0; DOFS * DOFS];
    for (i, line) in PLACE.iter().zip(matrix) {
        PLACE.iter().zip(line).for_each(|(j, x)| all[i * DOFS + j] = *x);
    }
    all
}

/// num-dual as it comes, a seed for each degree of freedom.
struct NumDual(Order);

impl Method for NumDual {
    fn name(&self) -> &'static str {
        "num-dual, 12 seeds"
    }

    fn order(&self) -> Order {
        self.0
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Option<Box<dyn Prepared + 's>> {
        Some(Box::new(ByNumDual {
            order: self.0,
            name: &subject.connection.name,
            flat: flat(subject),
            rows: Vec::new(),
            hessians: Vec::new(),
        }))
    }
}

struct ByNumDual<'s> {
    order: Order,
    name: &'s str,
    flat: Vec<[f64; 27]>,
    rows: Vec<[f64; 12]>,
    hessians: Vec<[[f64; 12]; 12]>,
}

impl Prepared for ByNumDual<'_> {
    fn run(&mut self) {
        let (first, second) = (&mut self.rows, &mut self.hessians);
        first.clear();
        second.clear();
        for state in &self.flat {
            match self.order {
                Order::Jacobian => naive::rows(self.name, state, &mut |_, x: DualSVec<f64, 12>| {
                    first.push(Seeded::gradient(x));
                }),
                _ => naive::rows(self.name, state, &mut |_, x: Dual2SVec<f64, 12>| {
                    second.push(Seeded::hessian(x));
                }),
            }
        }
    }

    fn numbers(&self) -> Vec<f64> {
        match self.order {
            Order::Jacobian => self.rows.iter().flat_map(spread).collect(),
            _ => self.hessians.iter().flat_map(spread_matrix).collect(),
        }
    }
}

/// Values and rows by hand, plain doubles.
struct Hand;

impl Method for Hand {
    fn name(&self) -> &'static str {
        "by hand, doubles"
    }

    fn order(&self) -> Order {
        Order::Jacobian
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Option<Box<dyn Prepared + 's>> {
        Some(Box::new(ByHand { subject, rows: vec![[scalar::Row::default(); 6]; subject.elements.len()] }))
    }
}

struct ByHand<'s> {
    subject: &'s Subject,
    rows: Vec<[scalar::Row; 6]>,
}

impl Prepared for ByHand<'_> {
    fn run(&mut self) {
        for (element, rows) in self.subject.elements.iter().zip(&mut self.rows) {
            let pair = &element.state.pair;
            let three = rows.first_chunk_mut::<3>().unwrap();
            match self.subject.connection.name.as_ref() {
                "SLIDE-PLANE" => scalar::slide_plane(pair, three),
                "REVOLUTE" => scalar::revolute(pair, three),
                "ROTATION" => scalar::rotation(pair, three),
                "CARDAN" => scalar::cardan(pair, three),
                "TRANSLATOR" => {
                    scalar::translator(pair, &element.connector.section().initial_orientation, rows);
                }
                other => panic!("{other} is not written by hand"),
            }
        }
    }

    fn numbers(&self) -> Vec<f64> {
        let count = self.subject.rows();
        assert!(self.rows.iter().flatten().all(|row| row.value.is_finite()));
        self.rows.iter().flat_map(|rows| rows[..count].iter().flat_map(|row| spread(&row.columns))).collect()
    }
}

/// Four elements at a time.
struct Lanes(Order);

impl Method for Lanes {
    fn name(&self) -> &'static str {
        "pintle, batch"
    }

    fn order(&self) -> Order {
        self.0
    }

    fn is_ours(&self) -> bool {
        true
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Option<Box<dyn Prepared + 's>> {
        Some(Box::new(ByLanes(Tiles::new(self.0, subject))))
    }
}

/// Elements in tiles of four, and room for their rows.
struct Tiles<'s> {
    order: Order,
    name: &'s str,
    batch: Batch,
    tiles: Vec<Tile>,
    sections: Vec<Section>,
    histories: Vec<History>,
    rows: Vec<Row>,
    second: Vec<HessianRow>,
}

impl<'s> Tiles<'s> {
    fn new(order: Order, subject: &'s Subject) -> Self {
        let fours: Vec<&[pintle::bench::Element]> = subject.elements.chunks_exact(4).collect();
        let batch = Batch::new(&subject.elements[0].connector, [true; 6]).unwrap();
        let count = fours.len() * batch.rows();
        let is_second = order == Order::Hessian;
        Self {
            order,
            name: &subject.connection.name,
            tiles: fours.iter().map(|four| Tile::new(&std::array::from_fn(|i| four[i].state.pair))).collect(),
            sections: fours
                .iter()
                .map(|four| Section::new(&std::array::from_fn::<_, 4, _>(|i| &four[i].connector)))
                .collect(),
            histories: fours
                .iter()
                .map(|four| History::new(&std::array::from_fn(|i| four[i].branch)))
                .collect(),
            rows: vec![Row::default(); if is_second { 0 } else { count }],
            second: vec![HessianRow::default(); if is_second { count } else { 0 }],
            batch,
        }
    }

    fn numbers(&self) -> Vec<f64> {
        let n = self.batch.rows();
        let states = 0..4 * self.tiles.len();
        let at = |i: usize| (0..n).map(move |r| (i / 4 * n + r, i % 4));
        match self.order {
            Order::Hessian => states
                .flat_map(at)
                .flat_map(|(at, lane)| {
                    spread_matrix(&self.second[at].hessian.map(|line| line.map(|four| four[lane])))
                })
                .collect(),
            _ => states
                .flat_map(at)
                .flat_map(|(at, lane)| spread(&self.rows[at].columns.map(|four| four[lane])))
                .collect(),
        }
    }
}

struct ByLanes<'s>(Tiles<'s>);

impl Prepared for ByLanes<'_> {
    fn run(&mut self) {
        let Tiles { order, batch, tiles, sections, histories, rows, second, .. } = &mut self.0;
        match order {
            Order::Hessian => batch.rows_of(tiles, sections, histories, second).unwrap(),
            _ => batch.rows_of(tiles, sections, histories, rows).unwrap(),
        }
    }

    fn numbers(&self) -> Vec<f64> {
        self.0.numbers()
    }
}

/// Rows, and with second derivatives, by hand for one vector unit.
#[cfg(target_arch = "x86_64")]
mod by_hand {
    use super::*;
    use crate::hand::sweep::Sweep;
    use pulp::x86::V3;

    pub(super) struct HandLanes(pub(super) Order);

    impl Method for HandLanes {
        fn name(&self) -> &'static str {
            "by hand, four lanes"
        }

        fn order(&self) -> Order {
            self.0
        }

        /// `None` where the processor has no AVX2 and FMA.
        fn prepare<'s>(&self, subject: &'s Subject) -> Option<Box<dyn Prepared + 's>> {
            Some(Box::new(ByHandLanes { v: V3::try_new()?, tiles: Tiles::new(self.0, subject) }))
        }
    }

    struct ByHandLanes<'s> {
        v: V3,
        tiles: Tiles<'s>,
    }

    impl Prepared for ByHandLanes<'_> {
        fn run(&mut self) {
            let Self { v, tiles: Tiles { order, name, batch, tiles, sections, rows, second, .. } } = self;
            let (v, name, count) = (*v, *name, batch.rows());
            match order {
                Order::Hessian => {
                    v.vectorize(Sweep { v, name, tiles, sections, rows: count, out: &mut second[..] });
                }
                _ => v.vectorize(Sweep { v, name, tiles, sections, rows: count, out: &mut rows[..] }),
            }
        }

        fn numbers(&self) -> Vec<f64> {
            self.tiles.numbers()
        }
    }
}

fn export(subjects: &[Subject]) -> Value {
    let all = subjects.iter().map(|subject| {
        let truth: Map<String, Value> =
            Order::ALL.iter().map(|order| (order.name().to_owned(), json!(subject.truth(*order)))).collect();
        json!({
            "connection": subject.connection.name,
            "place": subject.place,
            "rows": subject.rows(),
            "states": flat(subject)[..subject.states()],
            "batch": subject.elements.len(),
            "size_of_values": subject.size_of_values(),
            "truth": truth,
        })
    });
    json!(all.collect::<Vec<Value>>())
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let at = |option: &str| words.iter().position(|word| word == option);
    if let Some(at) = at("--draw") {
        let found: Report = serde_json::from_slice(&std::fs::read(&words[at + 1]).unwrap()).unwrap();
        std::fs::create_dir_all(&words[at + 2]).unwrap();
        for (name, svg) in report::figures(&found) {
            std::fs::write(std::path::Path::new(&words[at + 2]).join(name), svg).unwrap();
        }
        report::markdown(&mut std::io::stdout().lock(), &found).unwrap();
        return;
    }
    let settings = Settings { states: STATES, batch: BATCH, ..Settings::default() };
    let mut found = Report::new(&settings);
    let types = TYPES.map(|name| ConnectionType::named(name, None).unwrap());
    let subjects: Vec<Subject> =
        types.iter().flat_map(|connection| found.subjects(&settings, connection)).collect();
    if let Some(at) = at("--export") {
        std::fs::write(&words[at + 1], export(&subjects).to_string()).unwrap();
        return;
    }
    let ways = Way::all();
    let mut more: Vec<Box<dyn Method>> = vec![
        Box::new(NumDual(Order::Jacobian)),
        Box::new(NumDual(Order::Hessian)),
        Box::new(Hand),
        Box::new(Lanes(Order::Jacobian)),
        Box::new(Lanes(Order::Hessian)),
    ];
    #[cfg(target_arch = "x86_64")]
    more.extend(
        [Order::Jacobian, Order::Hessian]
            .map(|order| -> Box<dyn Method> { Box::new(by_hand::HandLanes(order)) }),
    );
    let more = more;
    let methods: Vec<&dyn Method> =
        ways.iter().map(|way| way as &dyn Method).chain(more.iter().map(AsRef::as_ref)).collect();
    let mut session = Session::new(&settings, &subjects, &methods).unwrap_or_else(|wrong| panic!("{wrong}"));
    if at("--serve").is_some() {
        let mut out = std::io::stdout().lock();
        found.points = session.points();
        let mut greeting = serde_json::to_value(&found).unwrap();
        for point in greeting["points"].as_array_mut().unwrap() {
            point["nanoseconds"] = json!(0.0);
        }
        writeln!(out, "{greeting}").unwrap();
        out.flush().unwrap();
        for line in std::io::stdin().lock().lines() {
            line.unwrap();
            writeln!(out, "{}", json!(session.round())).unwrap();
            out.flush().unwrap();
        }
        return;
    }
    (0..settings.rounds).for_each(|_| drop(session.round()));
    found.points = session.points();
    found.points.retain(|point: &Point| point.nanoseconds.is_finite());
    report::human(&mut anstream::stdout().lock(), &found, 110).unwrap();
}
