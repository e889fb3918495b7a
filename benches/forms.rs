//! What the forms of states and rows cost, arrays in and out: `Batch::rows_of_states` of 1,000 states, on one core.
//!
//! Each form is compared with dense rows of triads before it is timed. Times are minima over interleaved rounds of one run.
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;

use pintle_kinematics::batch::{
    Array, Batch, COMPACT, Columns, History, Nodes, Orientation, Section, States,
};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Connector, Definition};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, identity};
use std::hint::black_box;
use std::time::Instant;

const TYPES: [&str; 5] = ["SLIDE-PLANE", "REVOLUTE", "TRANSLATOR", "ROTATION", "CARDAN"];
const COUNT: usize = 1000;
const ROUNDS: usize = 12;
const CALLS: usize = 100;

/// Which numbers are given, and which are written.
const FORMS: [(&str, Given, Columns<'static>); 8] = [
    ("dense rows of triads", Given::Triads, Columns::Twelve),
    ("14 columns", Given::Triads, Columns::Fourteen),
    ("sparse", Given::Triads, Columns::Sparse),
    ("compact, 9 columns", Given::Triads, Columns::Chosen(&COMPACT)),
    ("3 columns, x_b", Given::Triads, Columns::Chosen(&[6, 7, 8])),
    ("node a for all states", Given::Shared, Columns::Twelve),
    ("quaternions", Given::Quaternions, Columns::Twelve),
    ("rotation vectors", Given::Vectors, Columns::Twelve),
];

#[derive(Clone, Copy, PartialEq)]
enum Given {
    Triads,
    Shared,
    Quaternions,
    Vectors,
}

struct Drawn {
    reference: Vec<f64>,
    displacement: [Vec<f64>; 2],
    triads: [Vec<f64>; 2],
    quaternions: [Vec<f64>; 2],
    vectors: [Vec<f64>; 2],
}

impl Drawn {
    fn new() -> Self {
        let draw = &mut Draw::new("forms");
        let vectors: [Vec<Vector<f64>>; 2] = [(); 2].map(|()| (0..COUNT).map(|_| draw.vector(1.0)).collect());
        let mut positions = || (0..COUNT).flat_map(|_| draw.vector(1.0)).collect::<Vec<f64>>();
        let flat =
            |of: fn(&Vector<f64>) -> Vec<f64>| [0, 1].map(|end| vectors[end].iter().flat_map(of).collect());
        Self {
            reference: positions(),
            displacement: [positions(), positions()],
            triads: flat(|phi| so3::exp(*phi).concat()),
            quaternions: flat(|phi| so3::exp_quaternion(*phi).to_vec()),
            vectors: flat(|phi| phi.to_vec()),
        }
    }

    /// A node in all states, or a in the first one for all of them.
    fn node(&self, end: usize, given: Given) -> Nodes<'_> {
        let stride = |numbers: &[f64]| {
            let is_one = given == Given::Shared && end == 0;
            if is_one { 0 } else { numbers.len() / COUNT }
        };
        let of = |numbers| Array::new(numbers, stride(numbers));
        Nodes {
            displacement: of(&self.displacement[end]),
            orientation: match given {
                Given::Triads | Given::Shared => Orientation::Triad(of(&self.triads[end])),
                Given::Quaternions => Orientation::Quaternion(of(&self.quaternions[end]), identity()),
                Given::Vectors => Orientation::RotationVector(of(&self.vectors[end]), identity()),
            },
        }
    }
}

/// A type, and room for what it gives.
struct Case {
    connector: Connector<f64>,
    batch: Batch,
    values: Vec<f64>,
    rows: Vec<f64>,
}

impl Case {
    fn new(name: &str) -> Self {
        let still = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
        let initial = Pair { reference: [0.5, -0.2, 0.3], a: still, b: still };
        let definition = Definition::new(ConnectionType::named(name, None).unwrap(), initial);
        let connector = Connector::<f64>::new(&definition);
        let batch = Batch::new(&connector, [true; 6]).unwrap();
        let (values, rows) =
            (vec![0.0; COUNT * batch.rows()], vec![0.0; COUNT * batch.width(Columns::Fourteen)]);
        Self { connector, batch, values, rows }
    }

    /// Goes through all states so many times.
    fn run(&mut self, drawn: &Drawn, (given, columns): (Given, Columns<'_>), times: usize) -> &[f64] {
        let sections = [Section::new(&[&self.connector; 4])];
        let histories = [History::new(&[self.connector.initial_branch(); 4])];
        let states = States {
            count: COUNT,
            reference: Array::new(&drawn.reference, 3),
            nodes: [0, 1].map(|end| drawn.node(end, given)),
            sections: &sections,
            histories: &histories,
        };
        let rows = &mut self.rows[..COUNT * self.batch.width(columns)];
        for _ in 0..times {
            self.batch
                .rows_of_states(black_box(&states), columns, &mut self.values, black_box(rows))
                .unwrap();
        }
        rows
    }

    /// The places among twelve of the numbers that each row has; none of a column of material flow.
    fn places(&self, columns: Columns<'_>) -> Vec<Vec<Option<usize>>> {
        let each = match columns {
            Columns::Sparse => {
                let pattern = self.batch.pattern();
                return pattern.into_iter().map(|row| row.into_iter().map(Some).collect()).collect();
            }
            Columns::Twelve => (0..12).map(Some).collect(),
            Columns::Fourteen => {
                let flow = [None];
                (0..6).map(Some).chain(flow).chain((6..12).map(Some)).chain(flow).collect()
            }
            Columns::Chosen(places) => places.iter().copied().map(Some).collect::<Vec<_>>(),
        };
        vec![each; self.batch.rows()]
    }

    /// The largest difference to dense rows of triads, in the largest entry of all.
    fn apart(&mut self, drawn: &Drawn, (given, columns): (Given, Columns<'_>)) -> f64 {
        let from = if given == Given::Shared { Given::Shared } else { Given::Triads };
        let dense = self.run(drawn, (from, Columns::Twelve), 1).to_vec();
        let largest = dense.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let (places, each) = (self.places(columns), self.batch.rows());
        let found = self.run(drawn, (given, columns), 1);
        let expected = dense.chunks_exact(12 * each).flat_map(|state| {
            let rows = places.iter().zip(state.chunks_exact(12));
            rows.flat_map(|(places, row)| places.iter().map(|place| place.map_or(0.0, |j| row[j])))
        });
        let pairs: Vec<_> = found.iter().zip(expected).collect();
        assert_eq!(pairs.len(), found.len());
        pairs.into_iter().fold(0.0, |most, (x, y)| f64::max(most, (x - y).abs())) / largest
    }
}

fn main() {
    if commit::is_told() {
        return;
    }
    let drawn = Drawn::new();
    let mut cases = TYPES.map(Case::new);
    let mut least = [[f64::INFINITY; TYPES.len()]; FORMS.len()];
    let mut apart = [0.0_f64; FORMS.len()];
    for (apart, (_, given, columns)) in apart.iter_mut().zip(FORMS) {
        for case in &mut cases {
            *apart = apart.max(case.apart(&drawn, (given, columns)));
        }
        // The same rotations as triads and otherwise differ by rounding.
        let allowed = if matches!(given, Given::Triads | Given::Shared) { 0.0 } else { 1e-14 };
        assert!(*apart <= allowed, "{apart:e}");
    }
    for _ in 0..ROUNDS {
        for (least, (_, given, columns)) in least.iter_mut().zip(FORMS) {
            for (least, case) in least.iter_mut().zip(&mut cases) {
                let start = Instant::now();
                case.run(&drawn, (given, columns), CALLS);
                *least = least.min(start.elapsed().as_secs_f64() * 1e9 / (CALLS * COUNT) as f64);
            }
        }
    }
    println!(
        "{COUNT} states, ns for a state; at last the geometric mean of the time over that of dense rows of triads"
    );
    println!("{:22} {}", "", TYPES.map(|name| format!("{name:>12}")).join(" "));
    for (times, (name, ..)) in least.iter().zip(FORMS) {
        let logs: f64 = times.iter().zip(&least[0]).map(|(time, dense)| (time / dense).ln()).sum();
        let mean = (logs / TYPES.len() as f64).exp();
        println!("{name:22} {}   {mean:.2}", times.map(|time| format!("{time:12.2}")).join(" "));
    }
}
