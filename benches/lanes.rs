//! Batches against derivatives written by hand, on the same tiles, which stay in the first cache; then every type.
//!
//! Every variant is compared with the 237-bit scalar before it is timed. Times are minima over interleaved rounds of one
//! run: `taskset -c 3 cargo bench --bench lanes`. With `--once WHO ORDER TYPE COUNT` (lanes or hand; rows or second; a type, or with " beyond half a turn") it goes through the tiles so many
//! times and prints how many they were, for a counter of instructions.
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;
#[cfg(target_arch = "x86_64")]
mod hand;

use pintle_audit::case::exact_state;
use pintle_bench::worse;
use pintle_kinematics::batch::{Batch, Columns12, Four, HessianRow, History, Row, Section, Tile};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{Branch, Connector, Definition, Increment, Output, Request, State, Tally};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Instant;

/// Tiles of four states: 29 KiB with their rows.
const TILES: usize = 8;
/// Tiles whose second derivatives are taken: 30 KiB for six rows.
const TILES_OF_SECOND: usize = 1;
const ROUNDS: usize = 16;
/// What stands behind the name of a type where all states go on beyond half a turn.
const BEYOND: &str = " beyond half a turn";
/// The largest error of an entry over the largest of its row.
const BOUND: f64 = 1e-14;
/// The same of second derivatives.
const BOUND_OF_SECOND: f64 = 1e-13;

fn drawn(draw: &mut Draw) -> Pair<f64> {
    let node = |draw: &mut Draw| Node { displacement: draw.vector(1.0), triad: draw.triad(), flow: 0.0 };
    Pair { reference: draw.vector(1.0), a: node(draw), b: node(draw) }
}

fn at_rest(pair: &Pair<f64>) -> State<f64> {
    State { pair: *pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }
}

/// A value with its row and second derivatives.
type Truth = (f64, [f64; 12], [[f64; 12]; 12]);

/// Degrees of freedom but material flow.
fn twelve<T: Copy>(of: &[T; DOFS]) -> [T; 12] {
    std::array::from_fn(|j| of[if j < 6 { j } else { j + 1 }])
}

struct Case {
    name: &'static str,
    connector: Connector<f64>,
    batch: Batch,
    pairs: Vec<Pair<f64>>,
    tiles: Vec<Tile>,
    sections: Vec<Section>,
    histories: Vec<History>,
    /// Each row of each state, by the 237-bit scalar; second derivatives of the first tiles only.
    truth: Vec<Vec<Truth>>,
}

/// The branch at a state that follows the initial one, or the one with the rotation vector that goes the other way round.
fn branch(connector: &Connector<f64>, pair: &Pair<f64>, beyond: bool) -> Branch<f64> {
    let mut branch = connector.advance(&at_rest(pair), &Increment::none(), &connector.initial_branch());
    if beyond {
        let length = norm(branch.rotation_vector);
        branch.rotation_vector = vector::scale(branch.rotation_vector, (length - TAU) / length);
    }
    branch
}

/// `None` for a type that has no batch.
fn case(name: &'static str) -> Option<Case> {
    case_of(name, name, false, true)
}

/// A type under a title; where it goes on `beyond` half a turn, no rotation vector is principal.
fn case_of(title: &'static str, name: &str, beyond: bool, has_truth: bool) -> Option<Case> {
    let draw = &mut Draw::new("lanes");
    let mut initial = drawn(draw);
    // The directions coincide at first, as where a printed constraint is enforced.
    initial.b.triad = initial.a.triad;
    let definition = Definition::new(ConnectionType::named(name, None).unwrap(), initial);
    let connector = Connector::<f64>::new(&definition);
    let wide = Connector::<Wide>::new(&definition);
    let batch = Batch::new(&connector, [true; 6]).ok()?;
    let pairs: Vec<Pair<f64>> = (0..4 * TILES).map(|_| drawn(draw)).collect();
    let branches: Vec<Branch<f64>> = pairs.iter().map(|pair| branch(&connector, pair, beyond)).collect();
    let requests = [1, 2].map(|order| Request::new(&[Output::CP, Output::RES], [true; 6], order));
    let truth = |(i, pair): (usize, &Pair<f64>)| {
        let request = &requests[usize::from(i < 4 * TILES_OF_SECOND)];
        let rotation_vector = vector::exact(branches[i].rotation_vector);
        let branch = Branch { rotation_vector, ..wide.initial_branch() };
        let (state, tally) = (exact_state(&at_rest(pair)), &mut Tally::default());
        let found = wide.evaluate(&state, &Increment::none(), &branch, request, tally);
        let of_row = |(k, _): &(usize, _)| {
            let value = found.residual[*k].or(found.position[*k]).unwrap().to_f64();
            let second = found.hessian[*k].as_ref().map(|hessian| hessian.map(|row| row.map(Wide::to_f64)));
            let hessian = second.map(|hessian| twelve(&hessian).map(|row| twelve(&row))).unwrap_or_default();
            (value, twelve(&found.jacobian[*k].unwrap().map(Wide::to_f64)), hessian)
        };
        batch.measures().iter().map(of_row).collect()
    };
    let truth = pairs.iter().enumerate().filter(|_| has_truth).map(truth).collect();
    let fours: Vec<[Pair<f64>; 4]> =
        pairs.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect();
    Some(Case {
        name: title,
        batch,
        tiles: fours.iter().map(Tile::new).collect(),
        sections: fours.iter().map(|_| Section::new(&[&connector; 4])).collect(),
        histories: branches
            .chunks_exact(4)
            .map(|four| History::new(&[four[0], four[1], four[2], four[3]]))
            .collect(),
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
        for (r, (value, columns, _)) in truth.iter().enumerate() {
            let row = &rows[i / 4 * n + r];
            let scale = columns.iter().fold(value.abs(), |m, x| m.max(x.abs()));
            let mut offset = row.value[i % 4] - value;
            if case.batch.measures()[r].1.winds() {
                // Rows have the principal value.
                offset -= TAU * (offset / TAU).round();
            }
            // Residuals of held positions are differences from the initial one, which rows do not know.
            let is_held = case.connector.is_constrained(case.batch.measures()[r].0)
                && !case.connector.is_printed_constraint(case.batch.measures()[r].0);
            if !is_held {
                worst = worse(worst, offset.abs() / scale);
            }
            for (x, y) in row.columns.iter().zip(columns) {
                worst = worse(worst, (x[i % 4] - y).abs() / scale);
            }
        }
    }
    worst
}

/// The largest error of rows with second derivatives over the largest entry of their row: of first and of second derivatives.
fn errors(case: &Case, rows: &[HessianRow]) -> [f64; 2] {
    let n = case.batch.rows();
    let mut worst = [0.0_f64; 2];
    for (i, truth) in case.truth.iter().take(4 * TILES_OF_SECOND).enumerate() {
        for (r, (_, columns, hessian)) in truth.iter().enumerate() {
            let row = &rows[i / 4 * n + r];
            let largest = |of: &[f64]| of.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let scale = largest(columns);
            for (x, y) in row.row.columns.iter().zip(columns) {
                worst[0] = worse(worst[0], (x[i % 4] - y).abs() / scale);
            }
            let scale = scale.max(largest(hessian.as_flattened()));
            for (x, y) in row.hessian.as_flattened().iter().zip(hessian.as_flattened()) {
                worst[1] = worse(worst[1], (x[i % 4] - y).abs() / scale);
            }
        }
    }
    worst
}

fn assert_exact(case: &Case, rows: &[Row], second: &[HessianRow], who: &str) -> [f64; 3] {
    let [of_row, of_second] = errors(case, second);
    let found = [error(case, rows), of_row, of_second];
    let bounds = [BOUND, BOUND, BOUND_OF_SECOND];
    assert!(found.iter().zip(bounds).all(|(e, bound)| *e < bound), "{} ({who}): {found:?}", case.name);
    found
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

/// Room for the rows of a case, and for its first tiles with second derivatives, a little further on in each round.
///
/// Where rows and tiles have addresses alike but for their upper digits, the processor waits, and that is chance.
struct Room {
    round: usize,
    rows: Vec<Row>,
    second: Vec<HessianRow>,
}

impl Room {
    fn new(case: &Case, round: usize) -> Self {
        let rows = case.batch.rows();
        let room = |tiles: usize| round + tiles * rows;
        let (of_rows, of_second) = (room(case.tiles.len()), room(TILES_OF_SECOND));
        Self { round, rows: vec![Row::default(); of_rows], second: vec![HessianRow::default(); of_second] }
    }

    fn rows(&mut self) -> &mut [Row] {
        black_box(&mut self.rows[self.round..])
    }

    fn second(&mut self) -> &mut [HessianRow] {
        black_box(&mut self.second[self.round..])
    }
}

impl Case {
    fn rows(&self, out: &mut [Row]) {
        let Self { batch, tiles, sections, histories, .. } = self;
        batch.rows_of(black_box(tiles), sections, histories, out).unwrap();
    }

    fn hessians(&self, out: &mut [HessianRow]) {
        let Self { batch, tiles, sections, histories, .. } = self;
        let (sections, histories) = (&sections[..TILES_OF_SECOND], &histories[..TILES_OF_SECOND]);
        batch.rows_of(black_box(&tiles[..TILES_OF_SECOND]), sections, histories, out).unwrap();
    }
}

/// J̇v, Σ λ ∂²c and its product with v of the tiles of a case.
struct Products {
    velocities: Vec<Columns12>,
    multipliers: Vec<Four>,
    bias: Vec<Four>,
    stiffness: Vec<[Columns12; 12]>,
    along: Vec<Columns12>,
}

impl Products {
    fn new(case: &Case) -> Self {
        let (tiles, draw) = (case.tiles.len(), &mut Draw::new("products"));
        let mut number = || draw.vector(1.0)[0];
        let mut four = || [number(), number(), number(), number()];
        let rows = tiles * case.batch.rows();
        Self {
            velocities: (0..tiles).map(|_| std::array::from_fn(|_| four())).collect(),
            multipliers: (0..rows).map(|_| four()).collect(),
            bias: vec![[0.0; 4]; rows],
            stiffness: vec![[[[0.0; 4]; 12]; 12]; tiles],
            along: vec![[[0.0; 4]; 12]; tiles],
        }
    }

    fn bias(&mut self, case: &Case) {
        let Case { batch, tiles, sections, histories, .. } = case;
        batch
            .bias_of(black_box(tiles), sections, histories, &self.velocities, black_box(&mut self.bias))
            .unwrap();
    }

    fn stiffness(&mut self, case: &Case) {
        let Case { batch, tiles, sections, histories, .. } = case;
        let out = black_box(&mut self.stiffness);
        batch.geometric_stiffness_of(black_box(tiles), sections, histories, &self.multipliers, out).unwrap();
    }

    fn along(&mut self, case: &Case) {
        let Case { batch, tiles, sections, histories, .. } = case;
        let (out, slices) =
            (black_box(&mut self.along), (&black_box(tiles)[..], &sections[..], &histories[..]));
        batch.geometric_stiffness_along(slices, &self.multipliers, &self.velocities, out).unwrap();
    }

    /// Asserts all against the second derivatives of the 237-bit scalar.
    fn assert_exact(&mut self, case: &Case) {
        self.bias(case);
        self.stiffness(case);
        self.along(case);
        let each = case.batch.rows();
        let check = |found: f64, terms: &mut dyn Iterator<Item = f64>, what: &str| {
            let (sum, size) = terms.fold((0.0, 1.0_f64), |(sum, size), x| (sum + x, size + x.abs()));
            assert!((found - sum).abs() < BOUND_OF_SECOND * size, "{}: {what} {found}, not {sum}", case.name);
        };
        for (i, truth) in case.truth.iter().take(4 * TILES_OF_SECOND).enumerate() {
            let (tile, lane) = (i / 4, i % 4);
            let v = self.velocities[tile].map(|four| four[lane]);
            for (r, (_, _, hessian)) in truth.iter().enumerate() {
                let terms = &mut (0..144).map(|k| hessian[k / 12][k % 12] * v[k / 12] * v[k % 12]);
                check(self.bias[tile * each + r][lane], terms, "J̇v");
            }
            for i in 0..12 {
                let of = |(r, (_, _, hessian)): (usize, &Truth)| {
                    let row: f64 = (0..12).map(|j| hessian[i][j] * v[j]).sum();
                    self.multipliers[tile * each + r][lane] * row
                };
                check(self.along[tile][i][lane], &mut truth.iter().enumerate().map(of), "(Σ λ ∂²c) v");
            }
            for k in 0..144 {
                let of = |(r, (_, _, hessian)): (usize, &Truth)| {
                    self.multipliers[tile * each + r][lane] * hessian[k / 12][k % 12]
                };
                check(
                    self.stiffness[tile][k / 12][k % 12][lane],
                    &mut truth.iter().enumerate().map(of),
                    "Σ λ ∂²c",
                );
            }
        }
    }
}

fn main() {
    if commit::is_told() {
        return;
    }
    #[cfg(target_arch = "x86_64")]
    {
        let words: Vec<String> = std::env::args().collect();
        if let Some(at) = words.iter().position(|word| word == "--once") {
            return by_hand::once(&words[at + 1..]);
        }
        by_hand::compare();
    }
    every_type();
}

/// The rows written by hand, for the vector unit of one processor.
#[cfg(target_arch = "x86_64")]
mod by_hand {
    use super::*;
    use crate::hand::sweep::Sweep;
    use crate::hand::types::TYPES;
    use pulp::x86::V3;

    fn sweep<'a, L>(v: V3, case: &'a Case, out: &'a mut [L]) -> Sweep<'a, L> {
        let Case { name, tiles, sections, batch, .. } = case;
        Sweep { v, name, tiles, sections, rows: batch.rows(), out }
    }

    /// The least times of a state in ns, lanes and by hand: of rows, and with second derivatives.
    type Times = [[f64; 2]; 2];

    fn round(v: V3, case: &Case, number: usize, least: &mut Times) {
        let mut room = Room::new(case, number);
        let states = case.pairs.len() as f64;
        let of_second = (4 * TILES_OF_SECOND) as f64;
        // Both write to the same memory: another address may cost a third by itself.
        let mut note = |which: usize, who: usize, time: f64, states: f64| {
            least[which][who] = least[which][who].min(time / states);
        };
        note(0, 0, time(400, || case.rows(room.rows())), states);
        note(0, 1, time(400, || v.vectorize(sweep(v, case, room.rows()))), states);
        note(1, 0, time(200, || case.hessians(room.second())), of_second);
        note(1, 1, time(200, || v.vectorize(sweep(v, case, room.second()))), of_second);
    }

    fn check(v: V3, case: &Case) {
        let mut room = Room::new(case, 0);
        case.rows(room.rows());
        case.hessians(room.second());
        let of_lanes = assert_exact(case, &room.rows, &room.second, "lanes");
        let mut room = Room::new(case, 0);
        v.vectorize(sweep(v, case, room.rows()));
        v.vectorize(sweep(v, case, room.second()));
        let of_hand = assert_exact(case, &room.rows, &room.second, "by hand");
        let text = |errors: [f64; 3]| errors.map(|error| format!("{error:.1e}")).join(" ");
        println!("{:12} largest errors: lanes {}, by hand {}", case.name, text(of_lanes), text(of_hand));
    }

    pub(super) fn once(words: &[String]) {
        let [who, order, name, count] = words else { return eprintln!("--once WHO ORDER TYPE COUNT") };
        let known = |name: &str| TYPES.into_iter().find(|known| *known == name);
        let (name, is_beyond) =
            name.strip_suffix(BEYOND).map_or((known(name), false), |name| (known(name), true));
        let name = name.unwrap();
        let (v, case) = (V3::try_new().unwrap(), case_of(name, name, is_beyond, false).unwrap());
        let mut room = Room::new(&case, 0);
        let count: usize = count.parse().unwrap();
        for _ in 0..count {
            match (who.as_str(), order.as_str()) {
                ("lanes", "rows") => case.rows(room.rows()),
                ("lanes", _) => case.hessians(room.second()),
                (_, "rows") => v.vectorize(sweep(v, &case, room.rows())),
                _ => v.vectorize(sweep(v, &case, room.second())),
            }
        }
        println!("{}", count * if order == "rows" { TILES } else { TILES_OF_SECOND });
    }

    pub(super) fn compare() {
        let Some(v) = V3::try_new() else {
            println!("what is written by hand needs AVX2 and FMA");
            return;
        };
        let cases: Vec<Case> = TYPES.into_iter().filter_map(case).collect();
        let mut least = vec![[[f64::INFINITY; 2]; 2]; cases.len()];
        cases.iter().for_each(|case| check(v, case));
        for number in 0..ROUNDS {
            cases.iter().zip(&mut least).for_each(|(case, least)| round(v, case, number, least));
        }
        let sections = [
            ("value and row", "90 % in the mean, 80 % for each"),
            ("value, row and second derivatives", "80 %, which is 1.25 times the time"),
        ];
        for (which, (what, aim)) in sections.into_iter().enumerate() {
            println!("{what}, ns for a state; the aim is {aim}");
            let mut product = 1.0;
            for (case, times) in cases.iter().zip(&least) {
                let [lanes, hand] = times[which];
                let speed = 100.0 * hand / lanes;
                println!("{:12} lanes {lanes:6.2}  by hand {hand:6.2}  speed {speed:.0} %", case.name);
                product *= hand / lanes;
            }
            let mean = f64::powf(product, 1.0 / cases.len() as f64);
            println!("geometric mean of the speed: {:.0} %", 100.0 * mean);
        }
    }
}

/// The time per row of every type, alone and with second derivatives, and of assembled ones over that of their dearer half.
fn every_type() {
    let names = || TABLE.iter().map(|connection| -> &'static str { &connection.name });
    let mut cases: Vec<Case> = names().filter_map(case).collect();
    // The rows of such tiles are computed a second time; what they are compared with are those of the principal sheet.
    cases.extend(case_of("ROTATION beyond half a turn", "ROTATION", true, true));
    let mut least = vec![[f64::INFINITY; 5]; cases.len()];
    for case in &cases {
        Products::new(case).assert_exact(case);
        let mut room = Room::new(case, 0);
        case.rows(room.rows());
        case.hessians(room.second());
        assert_exact(case, &room.rows, &room.second, "lanes");
    }
    for number in 0..ROUNDS {
        for (case, least) in cases.iter().zip(&mut least) {
            let mut room = Room::new(case, number);
            let rows_of = (case.pairs.len() * case.batch.rows()) as f64;
            let second_of = (4 * TILES_OF_SECOND * case.batch.rows()) as f64;
            let first = time(100, || case.rows(room.rows())) / rows_of;
            let both = time(50, || case.hessians(room.second())) / second_of;
            let mut products = Products::new(case);
            let bias = time(100, || products.bias(case)) / rows_of;
            let stiffness = time(50, || products.stiffness(case)) / rows_of;
            let along = time(100, || products.along(case)) / rows_of;
            for (least, time) in least.iter_mut().zip([first, both, bias, along, stiffness]) {
                *least = least.min(time);
            }
        }
    }
    println!(
        "ns for a row: first derivatives, with second; each over that of the dearer half, where the aim is 2.00; \
         J̇v, (Σ λ ∂²c) v and Σ λ ∂²c over the time of rows, where the aim is 2.50"
    );
    let mut dearest = [("", 0.0_f64); 2];
    let mut logs = [0.0_f64; 3];
    let left_out: Vec<&str> = names().filter(|name| cases.iter().all(|case| case.name != *name)).collect();
    let of = |name: &str| cases.iter().position(|case| case.name == name).map(|i| least[i]);
    for (case, own) in cases.iter().zip(&least) {
        let halves = case.connector.connection().halves.iter().flatten();
        let dearer = halves
            .filter(|half| half.name != case.name)
            .filter_map(|half| of(half.name))
            .reduce(|a, b| [0, 1, 2, 3, 4].map(|i| a[i].max(b[i])));
        for (which, dearest) in dearest.iter_mut().enumerate() {
            let over = dearer.map_or(0.0, |half| own[which] / half[which]);
            if case.name == &case.connector.connection().name[..] && over > dearest.1 {
                *dearest = (case.name, over);
            }
        }
        let over =
            |which: usize| dearer.map_or("–".into(), |half| format!("{:.2}", own[which] / half[which]));
        let products = [own[2] / own[0], own[3] / own[0], own[4] / own[0]];
        logs.iter_mut().zip(products).for_each(|(log, of)| *log += of.ln() / cases.len() as f64);
        let [bias, along, stiffness] = products;
        println!(
            "{:27} {:6.2} {:7.2}  {:>4} {:>4}  {bias:4.2} {along:5.2} {stiffness:5.2}",
            case.name,
            own[0],
            own[1],
            over(0),
            over(1)
        );
    }
    let [bias, along, stiffness] = logs.map(f64::exp);
    println!("geometric means: J̇v {bias:.2}, (Σ λ ∂²c) v {along:.2}, Σ λ ∂²c {stiffness:.2} times the rows");
    let [(first, over_first), (second, over_second)] = dearest;
    println!("at most {over_first:.2} ({first}), with second derivatives {over_second:.2} ({second})");
    println!("not in batches, for columns of material flow or rows of one-forms: {}", left_out.join(", "));
}
