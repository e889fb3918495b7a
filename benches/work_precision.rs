//! Time against error of values, Jacobians and Hessians, far from singular points, near them and at rest: what `pintle bench` measures, and
//! besides it batches, and rows and second derivatives by hand: `taskset -c 3 cargo bench --bench work_precision`. All go through the same
//! states; what takes one state at a time writes its rows into the same memory again, batches into as much as they have rows.
//!
//! By itself it prints the tables. For `scripts/measure.py`: `--export FILE` writes states and truth for JAX; `--serve` writes the
//! points with their errors, then runs a round for each line read, and answers with the times of the points in the same order;
//! `--draw FILE FOLDER` prints the tables of a report and draws it.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

mod hand {
    #[path = "../../src/scalar/coefficients.rs"]
    #[expect(dead_code, reason = "the rows need some of them")]
    mod coefficients;
    pub(crate) mod common;
    #[cfg(target_arch = "x86_64")]
    mod hessian;
    pub(crate) mod peer;
    pub(crate) mod scalar;
    #[cfg(target_arch = "x86_64")]
    mod simd;
    #[cfg(target_arch = "x86_64")]
    pub(crate) mod sweep;
    pub(crate) mod types;
    #[cfg(target_arch = "x86_64")]
    mod vector;
}

use hand::common::{flat, is_written, settings, spread, spread_matrix, untimed};
use hand::peer::serve;
use hand::scalar;
use hand::types::TYPES;
use pintle::batch::{Batch, HessianRow, History, Row, Section, Tile};
use pintle::bench::{Cause, Method, Order, Prepared, Report, Session, Settings, Subject, Way};
use pintle::catalog::ConnectionType;
use pintle::report::bench as report;
use serde_json::{Map, Value, json};
use std::hint::black_box;

/// Values and rows by hand, plain doubles.
struct Hand;

impl Method for Hand {
    fn name(&self) -> &'static str {
        "by hand, doubles"
    }

    fn order(&self) -> Order {
        Order::Jacobian
    }

    fn cause(&self) -> Cause {
        Cause::Rounding
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
        is_written(subject)?;
        Ok(Box::new(ByHand { subject, rows: [scalar::Row::default(); 6] }))
    }
}

struct ByHand<'s> {
    subject: &'s Subject,
    rows: [scalar::Row; 6],
}

impl ByHand<'_> {
    #[inline(always)]
    fn one(&mut self, i: usize) {
        let (element, rows) = (&self.subject.elements[i], &mut self.rows);
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

impl Prepared for ByHand<'_> {
    fn run(&mut self) {
        for i in 0..self.subject.elements.len() {
            self.one(i);
            black_box(&mut self.rows);
        }
    }

    fn states(&self) -> usize {
        self.subject.elements.len()
    }

    fn numbers(&mut self) -> Vec<f64> {
        let mut all = Vec::new();
        for i in 0..self.subject.elements.len() {
            self.one(i);
            let rows = &self.rows[..self.subject.rows()];
            assert!(rows.iter().all(|row| row.value.is_finite()));
            all.extend(rows.iter().flat_map(|row| spread(&row.columns)));
        }
        all
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

    fn cause(&self) -> Cause {
        Cause::Ours
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
        Ok(Box::new(ByLanes(Tiles::new(self.0, subject))))
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
        let all: Vec<&pintle::bench::Element> = subject.in_batch().collect();
        let fours: Vec<&[&pintle::bench::Element]> = all.chunks_exact(4).collect();
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

    fn states(&self) -> usize {
        4 * self.0.tiles.len()
    }

    fn numbers(&mut self) -> Vec<f64> {
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

        fn cause(&self) -> Cause {
            Cause::Rounding
        }

        fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
            is_written(subject)?;
            let v = V3::try_new().ok_or("the processor has no AVX2 and FMA")?;
            Ok(Box::new(ByHandLanes { v, tiles: Tiles::new(self.0, subject) }))
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

        fn states(&self) -> usize {
            4 * self.tiles.tiles.len()
        }

        fn numbers(&mut self) -> Vec<f64> {
            self.tiles.numbers()
        }
    }
}

/// The subjects for those that run beside this program: their rows are those of `hand`, with bounds for formulas without branches.
fn export(subjects: &[Subject], settings: &Settings) -> Value {
    let all = subjects.iter().filter(|subject| is_written(subject).is_ok()).map(|subject| {
        let bounds: Map<String, Value> = Order::ALL
            .iter()
            .map(|order| {
                let distance = subject.place.distance(settings.distance);
                (order.name().to_owned(), json!(Cause::NoBranches.bound(*order, subject.place, distance)))
            })
            .collect();
        let truth: Map<String, Value> =
            Order::ALL.iter().map(|order| (order.name().to_owned(), json!(subject.truth(*order)))).collect();
        json!({
            "connection": subject.connection.name,
            "place": subject.place,
            "rows": subject.rows(),
            "states": flat(subject),
            "batch": subject.batch,
            "bounds": bounds,
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
    let settings = settings();
    let mut found = Report::new(&settings);
    let types = TYPES.map(|name| ConnectionType::named(name, None).unwrap());
    let subjects: Vec<Subject> =
        types.iter().flat_map(|connection| found.subjects(&settings, connection)).collect();
    if let Some(at) = at("--export") {
        std::fs::write(&words[at + 1], export(&subjects, &settings).to_string()).unwrap();
        return;
    }
    let ways = Way::all();
    let mut more: Vec<Box<dyn Method>> =
        vec![Box::new(Hand), Box::new(Lanes(Order::Jacobian)), Box::new(Lanes(Order::Hessian))];
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
        found.take(&session);
        serve(&untimed(&found), || json!(session.round()));
        return;
    }
    (0..settings.rounds).for_each(|_| drop(session.round()));
    found.take(&session);
    report::human(&mut anstream::stdout().lock(), &found, 110).unwrap();
}
