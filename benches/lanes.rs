//! Batches against derivatives written by hand, on the same tiles, which stay in the first cache.
//!
//! Every variant is compared with the 237-bit scalar before it is timed. Times are minima over interleaved rounds of one
//! run: `taskset -c 3 cargo bench --bench lanes`.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

#[cfg(target_arch = "x86_64")]
mod hand;

use pintle::batch::{Batch, HessianRow, History, Row, Section, Tile};
use pintle::catalog::{ConnectionType, TABLE};
use pintle::connector::{Connector, Definition, Increment, Output, Request, State, Tally};
use pintle::node::{DOFS, Node, Pair};
use pintle::scalar::{Differentiable, Wide};
use pintle::{so3, vector};
use std::hint::black_box;
use std::time::Instant;

/// Tiles of four states: 29 KiB with their rows.
const TILES: usize = 8;
const ROUNDS: usize = 8;
/// The largest error of an entry over the largest of its row.
const BOUND: f64 = 1e-14;

/// Numbers in [−1, 1] that look random.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> [f64; 3] {
        [self.next(), self.next(), self.next()]
    }

    fn pair(&mut self) -> Pair<f64> {
        let mut node = || Node {
            displacement: self.vector(),
            triad: so3::matrix(so3::exp(self.vector().map(|x| 2.0 * x))),
            flow: 0.0,
        };
        let (a, b) = (node(), node());
        Pair { reference: self.vector(), a, b }
    }
}

fn exact<R: Differentiable>(pair: &Pair<f64>) -> State<R> {
    let node = |node: &Node<f64>| Node {
        displacement: vector::exact(node.displacement),
        triad: vector::exact_matrix(&node.triad),
        flow: R::from_f64(node.flow),
    };
    State {
        pair: Pair { reference: vector::exact(pair.reference), a: node(&pair.a), b: node(&pair.b) },
        velocity: [R::integer(0); DOFS],
        acceleration: [R::integer(0); DOFS],
    }
}

struct Case {
    name: &'static str,
    connector: Connector<f64>,
    batch: Batch,
    pairs: Vec<Pair<f64>>,
    tiles: Vec<Tile>,
    sections: Vec<Section>,
    histories: Vec<History>,
    /// The value and row of each state and row, by the 237-bit scalar.
    truth: Vec<Vec<(f64, [f64; 12])>>,
}

/// `None` for a type that has no batch.
fn case(name: &'static str) -> Option<Case> {
    let mut draw = Draw(7);
    let mut initial = draw.pair();
    // The directions coincide at first, as where a printed constraint is enforced.
    initial.b.triad = initial.a.triad;
    let definition = Definition::new(ConnectionType::named(name, None).unwrap(), initial);
    let connector = Connector::<f64>::new(&definition);
    let wide = Connector::<Wide>::new(&definition);
    let batch = Batch::new(&connector, [true; 6]).ok()?;
    let pairs: Vec<Pair<f64>> = (0..4 * TILES).map(|_| draw.pair()).collect();
    let request = Request::new(&[Output::CP, Output::RES], [true; 6], 1);
    let truth = pairs
        .iter()
        .map(|pair| {
            let found = wide.evaluate(
                &exact(pair),
                &Increment::none(),
                &wide.initial_branch(),
                &request,
                &mut Tally::default(),
            );
            batch
                .measures()
                .iter()
                .map(|(k, _)| {
                    let value = found.residual[*k].or(found.position[*k]).unwrap().to_f64();
                    let row = found.jacobian[*k].unwrap().map(Wide::to_f64);
                    let mut columns = [0.0; 12];
                    columns[..6].copy_from_slice(&row[..6]);
                    columns[6..].copy_from_slice(&row[7..13]);
                    (value, columns)
                })
                .collect()
        })
        .collect();
    let fours: Vec<[Pair<f64>; 4]> =
        pairs.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect();
    Some(Case {
        name,
        batch,
        tiles: fours.iter().map(Tile::new).collect(),
        sections: fours.iter().map(|_| Section::new(&[&connector; 4])).collect(),
        histories: fours.iter().map(|_| History::new(&[connector.initial_branch(); 4])).collect(),
        connector,
        pairs,
        truth,
    })
}

/// The largest error over the largest entry of the row.
fn error(case: &Case, rows: &[Row]) -> f64 {
    let n = case.batch.rows();
    let mut worst: f64 = 0.0;
    for (i, truth) in case.truth.iter().enumerate() {
        for (r, (value, columns)) in truth.iter().enumerate() {
            let row = &rows[i / 4 * n + r];
            let scale = columns.iter().fold(value.abs(), |m, x| m.max(x.abs()));
            let offset = row.value[i % 4] - value;
            // Residuals of held positions are differences from the initial one, which rows do not know.
            let is_held = case.connector.is_constrained(case.batch.measures()[r].0)
                && !case.connector.is_printed_constraint(case.batch.measures()[r].0);
            if !is_held {
                worst = worst.max(offset.abs() / scale);
            }
            for (x, y) in row.columns.iter().zip(columns) {
                worst = worst.max((x[i % 4] - y).abs() / scale);
            }
        }
    }
    worst
}

/// The time of one call in ns: the least of `samples`.
fn time(samples: usize, mut call: impl FnMut()) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..samples {
        let start = Instant::now();
        for _ in 0..64 {
            call();
        }
        least = least.min(start.elapsed().as_secs_f64() / 64.0);
    }
    least * 1e9
}

#[cfg(target_arch = "x86_64")]
struct Sweep<'a> {
    v: pulp::x86::V3,
    name: &'static str,
    case: &'a Case,
    out: &'a mut [Row],
}

#[cfg(target_arch = "x86_64")]
impl pulp::NullaryFnOnce for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { v, name, case, out } = self;
        // Loops written out: a closure would be compiled for the baseline, and called.
        macro_rules! each {
            (|$tile:ident, $section:ident, $out:ident| $row:expr) => {
                for (($tile, $section), $out) in
                    case.tiles.iter().zip(&case.sections).zip(out.chunks_exact_mut(case.batch.rows()))
                {
                    $row
                }
            };
        }
        match name {
            "SLIDE-PLANE" => each!(|tile, _section, out| hand::simd::slide_plane(v, tile, out)),
            "REVOLUTE" => each!(|tile, _section, out| hand::simd::revolute(v, tile, out)),
            "TRANSLATOR" => each!(|tile, section, out| hand::simd::translator(v, tile, section, out)),
            "ROTATION" => each!(|tile, _section, out| hand::simd::rotation(v, tile, out)),
            "CARDAN" => each!(|tile, _section, out| hand::simd::cardan(v, tile, out)),
            other => panic!("{other} is not written by hand"),
        }
    }
}

/// The types written by hand.
const BY_HAND: [&str; 5] = ["SLIDE-PLANE", "REVOLUTE", "TRANSLATOR", "ROTATION", "CARDAN"];

fn main() {
    let cases: Vec<Case> = BY_HAND.into_iter().filter_map(case).collect();
    let mut least = vec![[f64::INFINITY; 2]; cases.len()];
    for round in 0..ROUNDS {
        for (i, case) in cases.iter().enumerate() {
            let mut rows = vec![Row::default(); case.tiles.len() * case.batch.rows()];
            let v = pulp::x86::V3::try_new().unwrap();
            let hand = |out: &mut [Row]| v.vectorize(Sweep { v, name: case.name, case, out });
            let lanes = |out: &mut [Row]| {
                case.batch.rows_of(black_box(&case.tiles), &case.sections, &case.histories, out).unwrap();
            };
            if round == 0 {
                lanes(&mut rows);
                let of_lanes = error(case, &rows);
                hand(&mut rows);
                let errors = [of_lanes, error(case, &rows)];
                println!(
                    "{}: largest error {:.1e} (lanes), {:.1e} (by hand)",
                    case.name, errors[0], errors[1]
                );
                assert!(errors.iter().all(|e| *e < BOUND), "{}: {errors:?}", case.name);
            }
            let each = case.pairs.len() as f64;
            // Both write to the same memory: another address may cost a fifth by itself.
            least[i][0] = least[i][0].min(time(400, || lanes(black_box(&mut rows))) / each);
            least[i][1] = least[i][1].min(time(400, || hand(black_box(&mut rows))) / each);
        }
    }
    let mut product = 1.0;
    for (case, [lanes, hand]) in cases.iter().zip(&least) {
        println!(
            "{:12} lanes {lanes:6.2} ns  hand {hand:6.2} ns  speed {:.0} %",
            case.name,
            100.0 * hand / lanes
        );
        product *= hand / lanes;
    }
    println!("geometric mean of the speed: {:.0} %", 100.0 * f64::powf(product, 1.0 / cases.len() as f64));
    every_type();
}

/// The time per row of every type, alone and with second derivatives, and of assembled ones over that of their dearer half.
fn every_type() {
    let names = TABLE.iter().map(|connection| -> &'static str { &connection.name });
    let cases: Vec<Case> = names.filter_map(case).collect();
    let mut least = vec![[f64::INFINITY; 2]; cases.len()];
    for round in 0..ROUNDS {
        for (case, least) in cases.iter().zip(&mut least) {
            let mut rows = vec![Row::default(); case.tiles.len() * case.batch.rows()];
            let mut second = vec![HessianRow::default(); rows.len()];
            let Case { batch, tiles, sections, histories, .. } = case;
            let mut first =
                || batch.rows_of(black_box(tiles), sections, histories, black_box(&mut rows)).unwrap();
            let mut both =
                || batch.hessians_of(black_box(tiles), sections, histories, black_box(&mut second)).unwrap();
            let each = (case.pairs.len() * batch.rows()) as f64;
            *least = [least[0].min(time(100, &mut first) / each), least[1].min(time(50, &mut both) / each)];
            if round == 0 {
                let error = error(case, &rows);
                assert!(error < BOUND, "{}: {error:e}", case.name);
            }
        }
    }
    println!("ns per row: first derivatives, with second; over the dearer half");
    let of = |name: &str| cases.iter().position(|case| case.name == name).map(|i| least[i]);
    for (case, [first, second]) in cases.iter().zip(&least) {
        let halves: Vec<[f64; 2]> =
            case.connector.connection().halves.iter().flatten().filter_map(|half| of(half.name)).collect();
        let dearer = halves.iter().fold(0.0, |most: f64, half| most.max(half[0]));
        println!("{:26} {first:6.2} {second:7.2}  {:.2}", case.name, first / dearer);
    }
}
