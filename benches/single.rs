//! One connector at a time against rows differentiated by hand for the same scalar instructions: `taskset -c 3 cargo bench --bench single`.
//!
//! Every variant is compared with the 237-bit scalar before it is timed. Times are minima over interleaved rounds of one run. With
//! `--once VARIANT TYPE` it runs one of them a fixed number of times, for a counter of instructions.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;
mod hand {
    #[path = "../../src/kinematics/scalar/coefficients.rs"]
    #[expect(dead_code, reason = "the rows need some of them")]
    mod coefficients;
    pub(crate) mod scalar;
    pub(crate) mod types;
}

use hand::scalar::{self, Row};
use hand::types::TYPES;
use pintle_bench::worse;
use pintle_kinematics::Differentiable;
use pintle_kinematics::batch::{Batch, COLUMNS};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{
    Branch, Connector, Definition, Increment, Linear, Output, Request, State, Tally,
};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::{so3, vector};
use std::hint::black_box;
use std::time::{Duration, Instant};

const STATES: usize = 32;
const ROUNDS: usize = 12;
/// The time of one measurement, of which the least pass counts.
const BUDGET: Duration = Duration::from_millis(4);
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
            triad: so3::matrix(so3::exp_quaternion(self.vector().map(|x| 2.0 * x))),
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
        velocity: [R::ZERO; DOFS],
        acceleration: [R::ZERO; DOFS],
    }
}

/// What is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Variant {
    /// Rows by hand.
    Hand,
    /// `Connector::linearize`.
    Linearize,
    /// `Connector::evaluate`: history, values and rows.
    Evaluate,
}

impl Variant {
    const ALL: [Self; 3] = [Self::Hand, Self::Linearize, Self::Evaluate];
}

struct Case {
    name: &'static str,
    connector: Connector<f64>,
    branch: Branch<f64>,
    request: Request,
    states: Vec<State<f64>>,
    frozen: [[f64; 3]; 3],
    /// The components of the rows.
    components: Vec<usize>,
    /// The value and row of each state, by the 237-bit scalar.
    truth: Vec<Vec<(f64, [f64; 12])>>,
}

impl Case {
    fn new(name: &'static str) -> Self {
        let mut draw = Draw(7);
        let mut initial = draw.pair();
        // The directions coincide at first, as where a printed constraint is enforced.
        initial.b.triad = initial.a.triad;
        let definition = Definition::new(ConnectionType::named(name, None).unwrap(), initial);
        let connector = Connector::<f64>::new(&definition);
        let wide = Connector::<Wide>::new(&definition);
        let pairs: Vec<Pair<f64>> = (0..STATES).map(|_| draw.pair()).collect();
        let request = Request::new(&[Output::CP, Output::RES], [true; 6], 1);
        let components: Vec<usize> = (0..6).filter(|k| connector.differentiated(*k).is_some()).collect();
        let truth = pairs.iter().map(|pair| values(&wide, &exact(pair), &components)).collect();
        Self {
            name,
            branch: connector.initial_branch(),
            request,
            states: pairs.iter().map(exact).collect(),
            frozen: connector.section().initial_orientation,
            components,
            truth,
            connector,
        }
    }

    fn by_hand(&self, pair: &Pair<f64>, out: &mut [Row; 6]) {
        let three = out.first_chunk_mut::<3>().unwrap();
        match self.name {
            "SLIDE-PLANE" => scalar::slide_plane(pair, three),
            "REVOLUTE" => scalar::revolute(pair, three),
            "ROTATION" => scalar::rotation(pair, three),
            "CARDAN" => scalar::cardan(pair, three),
            "TRANSLATOR" => scalar::translator(pair, &self.frozen, out),
            other => panic!("{other} is not written by hand"),
        }
    }

    /// The largest error of a variant.
    fn error(&self, variant: Variant) -> f64 {
        let mut worst: f64 = 0.0;
        for (state, truth) in self.states.iter().zip(&self.truth) {
            let found: Vec<(f64, [f64; 12])> = match variant {
                Variant::Hand => {
                    let mut rows = [Row::default(); 6];
                    self.by_hand(&state.pair, &mut rows);
                    rows.iter().map(|row| (row.value, row.columns)).collect()
                }
                Variant::Linearize => {
                    let mut rows = [Linear::default(); 6];
                    let count = self.connector.linearize(&state.pair, &self.branch, [true; 6], &mut rows);
                    rows[..count].iter().map(|row| (row.value, COLUMNS.map(|j| row.row[j]))).collect()
                }
                Variant::Evaluate => values(&self.connector, state, &self.components),
            };
            assert!(found.len() >= truth.len(), "{} {variant:?}: rows are missing", self.name);
            for ((value, row), (exact_value, exact)) in found.iter().zip(truth) {
                let scale = exact.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                worst = worse(worst, (value - exact_value).abs() / scale.max(exact_value.abs()));
                for (x, y) in row.iter().zip(exact) {
                    worst = worse(worst, (x - y).abs() / scale);
                }
            }
        }
        assert!(worst < BOUND, "{} {variant:?}: {worst:e}", self.name);
        worst
    }

    fn run(&self, variant: Variant) {
        match variant {
            Variant::Hand => {
                let mut rows = [Row::default(); 6];
                for state in black_box(&self.states) {
                    self.by_hand(&state.pair, &mut rows);
                    black_box(&mut rows);
                }
            }
            Variant::Linearize => {
                let mut rows = [Linear::default(); 6];
                for state in black_box(&self.states) {
                    self.connector.linearize(&state.pair, &self.branch, [true; 6], &mut rows);
                    black_box(&mut rows);
                }
            }
            Variant::Evaluate => {
                let mut tally = Tally::default();
                for state in black_box(&self.states) {
                    let increment = Increment::none();
                    let (request, branch) = (&self.request, &self.branch);
                    black_box(self.connector.evaluate(state, &increment, branch, request, &mut tally));
                }
            }
        }
    }

    /// The least time of a state, in ns.
    fn time(&self, variant: Variant) -> f64 {
        let (begin, mut least) = (Instant::now(), f64::INFINITY);
        while begin.elapsed() < BUDGET {
            let start = Instant::now();
            (0..8).for_each(|_| self.run(black_box(variant)));
            least = least.min(start.elapsed().as_secs_f64() / 8.0);
        }
        1e9 * least / STATES as f64
    }
}

/// Values and rows by evaluation.
fn values<R: Differentiable>(
    connector: &Connector<R>,
    state: &State<R>,
    components: &[usize],
) -> Vec<(f64, [f64; 12])>
where
    f64: From<Narrow<R>>,
{
    let request = Request::new(&[Output::CP, Output::RES], [true; 6], 1);
    let branch = connector.initial_branch();
    let found = connector.evaluate(state, &Increment::none(), &branch, &request, &mut Tally::default());
    let of = |k: &usize| {
        let value = if connector.is_printed_constraint(*k) { found.residual[*k] } else { found.position[*k] };
        let row = found.jacobian[*k].unwrap();
        (f64::from(Narrow(value.unwrap())), COLUMNS.map(|j| f64::from(Narrow(row[j]))))
    };
    components.iter().map(of).collect()
}

/// A number to be rounded to a double.
struct Narrow<R>(R);

impl From<Narrow<f64>> for f64 {
    fn from(number: Narrow<f64>) -> Self {
        number.0
    }
}

impl From<Narrow<Wide>> for f64 {
    fn from(number: Narrow<Wide>) -> Self {
        number.0.to_f64()
    }
}

fn main() {
    if commit::is_told() {
        return;
    }
    let cases = TYPES.map(Case::new);
    let words: Vec<String> = std::env::args().collect();
    if let Some(at) = words.iter().position(|word| word == "--once") {
        let variant = Variant::ALL.into_iter().find(|v| format!("{v:?}") == words[at + 1]).unwrap();
        let case = cases.iter().find(|case| case.name == words[at + 2]).unwrap();
        (0..1000).for_each(|_| case.run(black_box(variant)));
        return;
    }
    let errors = cases.each_ref().map(|case| Variant::ALL.map(|variant| case.error(variant)));
    let mut least = [[f64::INFINITY; 3]; 5];
    for _ in 0..ROUNDS {
        for (case, least) in cases.iter().zip(&mut least) {
            for (variant, least) in Variant::ALL.into_iter().zip(least) {
                *least = least.min(case.time(variant));
            }
        }
    }
    println!(
        "ns per state, value and Jacobian; minima of {ROUNDS} interleaved rounds, in brackets the largest error"
    );
    println!("{:12} {:>18} {:>26} {:>26}", "", "by hand", "linearize", "evaluate");
    let mut logs = [0.0; 2];
    for ((case, [hand, linear, whole]), errors) in cases.iter().zip(&least).zip(errors) {
        let [of_hand, of_linear, of_whole] = errors;
        println!(
            "{:12} {hand:8.2} ({of_hand:7.1e}) {linear:8.2} = {:4.2} × ({of_linear:7.1e}) {whole:8.1} = {:4.2} × ({of_whole:7.1e})",
            case.name,
            linear / hand,
            whole / hand
        );
        logs[0] += (linear / hand).ln() / 5.0;
        logs[1] += (whole / hand).ln() / 5.0;
    }
    println!("geometric mean: linearize {:.2} ×, evaluate {:.2} ×", logs[0].exp(), logs[1].exp());
    without_batches();
}

/// Types whose rows are in no batch, evaluated one at a time, and their halves.
fn without_batches() {
    let is_in_no_batch = |of: &&ConnectionType| {
        let connector = Connector::<f64>::new(&definition(of));
        Batch::new(&connector, [true; 6]).is_err()
    };
    println!(
        "ns for a row of what is in no batch, evaluated; of an assembled type over that of its dearer half, where the aim is 2.00"
    );
    for connection in TABLE.iter().filter(is_in_no_batch) {
        let own = Evaluated::new(connection);
        let others = connection.halves.iter().flatten().filter(|half| half.name != connection.name);
        let halves: Vec<Evaluated> =
            others.map(|half| Evaluated::new(&ConnectionType::named(half.name, None).unwrap())).collect();
        let mut least = vec![f64::INFINITY; 1 + halves.len()];
        for _ in 0..ROUNDS {
            for (of, least) in halves.iter().chain([&own]).zip(&mut least) {
                *least = least.min(of.time());
            }
        }
        let (own_time, of_halves) = least.split_last().unwrap();
        let dearer = of_halves.iter().copied().reduce(f64::max);
        let over = dearer.map_or(String::new(), |dearer| format!(" = {:.2} ×", own_time / dearer));
        let each = halves.iter().zip(of_halves).map(|(half, ns)| format!("{} {ns:.1}", half.name));
        let each: Vec<String> = each.collect();
        println!("{:16} {own_time:8.1}{over}  {}", own.name, each.join(", "));
    }
}

/// A type with material flow.
fn definition(connection: &ConnectionType) -> Definition {
    let pair = Draw(7).pair();
    Definition { flow_scale: 50.0, ..Definition::new(connection.clone(), pair) }
}

/// A type that is evaluated with its rows.
struct Evaluated {
    name: String,
    connector: Connector<f64>,
    branch: Branch<f64>,
    request: Request,
    states: Vec<State<f64>>,
    rows: usize,
}

impl Evaluated {
    /// Its rows are compared with those by the 237-bit scalar.
    fn new(connection: &ConnectionType) -> Self {
        let definition = definition(connection);
        let (connector, wide) = (Connector::<f64>::new(&definition), Connector::<Wide>::new(&definition));
        let request = Request::new(&[Output::CP, Output::RES], [true; 6], 1);
        let mut draw = Draw(11);
        let pairs: Vec<Pair<f64>> = (0..STATES).map(|_| draw.pair()).collect();
        let mut rows = 0;
        for pair in &pairs {
            let tally = &mut Tally::default();
            let none = Increment::none();
            let found = connector.evaluate(&exact(pair), &none, &connector.initial_branch(), &request, tally);
            let none = Increment::none();
            let truth = wide.evaluate(&exact(pair), &none, &wide.initial_branch(), &request, tally);
            rows = found.jacobian.iter().flatten().count();
            assert_eq!(rows, truth.jacobian.iter().flatten().count(), "{}", connection.name);
            for (row, known) in found.jacobian.iter().zip(&truth.jacobian) {
                let (Some(row), Some(known)) = (row, known) else { continue };
                let scale = known.iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
                let is_close = |(x, y): (&f64, &Wide)| (x - y.to_f64()).abs() <= BOUND * scale;
                assert!(row.iter().zip(known).all(is_close), "{}", connection.name);
            }
        }
        Self {
            name: connection.name.to_string(),
            branch: connector.initial_branch(),
            states: pairs.iter().map(exact).collect(),
            connector,
            request,
            rows,
        }
    }

    /// The least time of a row, in ns.
    fn time(&self) -> f64 {
        let (begin, mut least) = (Instant::now(), f64::INFINITY);
        let mut tally = Tally::default();
        while begin.elapsed() < BUDGET {
            let start = Instant::now();
            for state in black_box(&self.states) {
                let increment = Increment::none();
                black_box(self.connector.evaluate(
                    state,
                    &increment,
                    &self.branch,
                    &self.request,
                    &mut tally,
                ));
            }
            least = least.min(start.elapsed().as_secs_f64());
        }
        1e9 * least / (STATES * self.rows) as f64
    }
}
