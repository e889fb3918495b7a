//! Time against error of values, Jacobians and Hessians, far from singular points, near them and at rest: what `pintle bench` measures, and
//! besides it values, rows and second derivatives by hand: `taskset -c 3 cargo bench --bench work_precision`. All go through the same
//! states; what takes one state at a time writes its rows into the same memory again, batches into as much as they have rows.
//!
//! By itself it prints the tables. For `scripts/measure.py` it has three options:
//!
//! - `--export FILE` writes states and truth for JAX.
//! - `--serve` writes the points with their errors. Then it runs a round for each line read, and answers with the times of the points.
//! - `--draw FILE FOLDER` prints the tables of a report and draws it.
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;
mod hand {
    pub(crate) mod arrays;
    #[path = "../../src/kinematics/scalar/coefficients.rs"]
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
    mod simd_values;
    #[cfg(target_arch = "x86_64")]
    pub(crate) mod sweep;
    pub(crate) mod types;
    pub(crate) mod values;
    #[cfg(target_arch = "x86_64")]
    mod vector;
}

use hand::arrays::ByArrays;
use hand::common::{flat, is_written, settings, spread, untimed};
use hand::peer::serve;
use hand::types::TYPES;
use hand::{scalar, values};
use pintle_bench::{Cause, Method, Order, Prepared, Report, Session, Settings, Subject, Way};
use pintle_kinematics::catalog::ConnectionType;
use pintle_report::bench as report;
use serde_json::{Map, Value, json};
use std::hint::black_box;

/// By hand, plain doubles: values alone, or with their rows.
struct Hand(Order);

impl Method for Hand {
    fn name(&self) -> &'static str {
        "by hand, doubles"
    }

    fn order(&self) -> Order {
        self.0
    }

    fn cause(&self) -> Cause {
        Cause::Rounding
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
        is_written(subject)?;
        Ok(match self.0 {
            Order::Value => ByHand::<f64>::prepared(subject),
            Order::Jacobian => ByHand::<scalar::Row>::prepared(subject),
            Order::Hessian => return Err("second derivatives are written for four lanes"),
        })
    }
}

/// What is written for a type of a subject, for its element number `i`: a function for its three rows, or that of TRANSLATOR for six.
macro_rules! by_hand {
    ($module:ident, $subject:expr, $i:expr, $out:expr) => {{
        let element = &$subject.elements[$i];
        let pair = &element.state.pair;
        let three = $out.first_chunk_mut::<3>().unwrap();
        match $subject.connection.name.as_ref() {
            "SLIDE-PLANE" => $module::slide_plane(pair, three),
            "REVOLUTE" => $module::revolute(pair, three),
            "ROTATION" => $module::rotation(pair, three),
            "CARDAN" => $module::cardan(pair, three),
            "TRANSLATOR" => {
                $module::translator(pair, &element.connector.section().initial_orientation, $out);
            }
            other => panic!("{other} is not written by hand"),
        }
    }};
}

/// What is computed by hand of one measure: its value, or its row.
trait Computed: Copy + Default {
    /// Of all measures of an element.
    fn compute(subject: &Subject, i: usize, out: &mut [Self; 6]);

    /// What is compared with the truth.
    fn numbers(self) -> impl Iterator<Item = f64>;
}

impl Computed for f64 {
    #[inline(always)]
    fn compute(subject: &Subject, i: usize, out: &mut [f64; 6]) {
        by_hand!(values, subject, i, out);
    }

    fn numbers(self) -> impl Iterator<Item = f64> {
        [self].into_iter()
    }
}

impl Computed for scalar::Row {
    #[inline(always)]
    fn compute(subject: &Subject, i: usize, out: &mut [scalar::Row; 6]) {
        by_hand!(scalar, subject, i, out);
    }

    fn numbers(self) -> impl Iterator<Item = f64> {
        assert!(self.value.is_finite());
        spread(&self.columns).into_iter()
    }
}

struct ByHand<'s, T> {
    subject: &'s Subject,
    out: [T; 6],
}

impl<'s, T: Computed + 's> ByHand<'s, T> {
    fn prepared(subject: &'s Subject) -> Box<dyn Prepared + 's> {
        Box::new(ByHand { subject, out: [T::default(); 6] })
    }
}

impl<T: Computed> Prepared for ByHand<'_, T> {
    fn run(&mut self) {
        for i in 0..self.subject.elements.len() {
            T::compute(self.subject, i, &mut self.out);
            black_box(&mut self.out);
        }
    }

    fn states(&self) -> usize {
        self.subject.elements.len()
    }

    fn numbers(&mut self) -> Vec<f64> {
        let mut all = Vec::new();
        for i in 0..self.subject.elements.len() {
            T::compute(self.subject, i, &mut self.out);
            all.extend(self.out[..self.subject.rows()].iter().flat_map(|each| each.numbers()));
        }
        all
    }
}

/// Values alone, with rows, and with second derivatives, by hand for one vector unit.
#[cfg(target_arch = "x86_64")]
mod by_hand {
    use super::*;
    use crate::hand::sweep::Sweep;
    use pintle_bench::{Rows, Tiles};
    use pintle_kinematics::batch::{Four, LANES};
    use pulp::x86::V3;

    pub(super) struct HandLanes(pub(super) Order);

    impl Method for HandLanes {
        fn name(&self) -> &'static str {
            "by hand, four lanes"
        }

        fn order(&self) -> Order {
            self.0
        }

        fn vector_unit(&self) -> Option<&'static str> {
            Some("AVX2/FMA")
        }

        fn cause(&self) -> Cause {
            Cause::Rounding
        }

        fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
            is_written(subject)?;
            let v = V3::try_new().ok_or("the processor has no AVX2 and FMA")?;
            let tiles = Tiles::new(subject)?;
            let found = match self.0 {
                Order::Value => Found::Values(vec![Four::default(); tiles.tiles.len() * subject.rows()]),
                order => Found::Rows(Rows::new(order, subject)?),
            };
            Ok(Box::new(ByHandLanes { v, name: &subject.connection.name, tiles, found }))
        }
    }

    /// Room for what is computed.
    enum Found {
        Values(Vec<Four>),
        Rows(Rows),
    }

    struct ByHandLanes<'s> {
        v: V3,
        name: &'s str,
        tiles: Tiles,
        found: Found,
    }

    impl Prepared for ByHandLanes<'_> {
        fn run(&mut self) {
            let Self { v, name, tiles: Tiles { batch, tiles, sections, .. }, found } = self;
            let (v, name, rows) = (*v, *name, batch.rows());
            match found {
                Found::Values(out) => {
                    v.vectorize(Sweep { v, name, tiles, sections, rows, out: &mut out[..] })
                }
                Found::Rows(Rows::First(out)) => {
                    v.vectorize(Sweep { v, name, tiles, sections, rows, out: &mut out[..] });
                }
                Found::Rows(Rows::Second(out)) => {
                    v.vectorize(Sweep { v, name, tiles, sections, rows, out: &mut out[..] });
                }
            }
        }

        fn states(&self) -> usize {
            LANES * self.tiles.tiles.len()
        }

        fn numbers(&mut self) -> Vec<f64> {
            let rows = self.tiles.batch.rows();
            match &self.found {
                Found::Values(found) => {
                    let of_tile = |tile: &[Four]| -> Vec<f64> {
                        (0..LANES).flat_map(|lane| tile.iter().map(move |row| row[lane])).collect()
                    };
                    found.chunks_exact(rows).flat_map(of_tile).collect()
                }
                Found::Rows(found) => found.numbers(rows),
            }
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
                (
                    order.name().to_owned(),
                    json!(Cause::NoBranches.bound(*order, subject.place, distance).unwrap()),
                )
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
    if commit::is_told() {
        return;
    }
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
        vec![Box::new(Hand(Order::Value)), Box::new(Hand(Order::Jacobian)), Box::new(ByArrays)];
    #[cfg(target_arch = "x86_64")]
    more.extend(Order::ALL.map(|order| -> Box<dyn Method> { Box::new(by_hand::HandLanes(order)) }));
    let more = more;
    let methods: Vec<&dyn Method> =
        ways.iter().map(|way| way as &dyn Method).chain(more.iter().map(AsRef::as_ref)).collect();
    let mut session = Session::new(&settings, &subjects, &methods);
    assert!(session.wrong().is_empty(), "{:?}", session.wrong());
    if at("--serve").is_some() {
        found.take(&session);
        serve(&untimed(&found), || json!(session.round()));
        return;
    }
    (0..settings.rounds).for_each(|_| drop(session.round()));
    found.take(&session);
    report::human(&mut anstream::stdout().lock(), &found, 110).unwrap();
}
