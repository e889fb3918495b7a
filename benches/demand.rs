//! Cost follows the request: the time of a state beside the counter of work, as outputs, connectors, the order of derivatives and the
//! nodes on the ground vary: `taskset -c 3 cargo bench --bench demand [CONNECTORS]`.
//!
//! Times are the least of rounds that take turns; the counts are asserted, the times are for reading.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

use pintle::connector::{Mask, Output, Request, Tally};
use pintle::evaluate::{Fixed, Jacobian, Model, Plan, Selection, Sequence};
use pintle::scene::{Label, NodeMotion, Rotation, Scene, State};
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 7;
const STATES: usize = 3;

/// Springs, dampers, friction and a stop on every HINGE.
const BEHAVIOR: &str = "*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=4\n10.\n*CONNECTOR DAMPING, COMPONENT=4\n1.\n\
                        *CONNECTOR FRICTION, COMPONENT=4\n, 5.\n*FRICTION\n0.1\n*CONNECTOR STOP, COMPONENT=4\n-9., 9.\n";

/// A chain of HINGEs in which every node turns; of `grounded` in eight the first end is the ground.
fn scene(connectors: usize, grounded: usize, is_laden: bool) -> Scene {
    let mut text = String::from("*NODE\n");
    (1..=connectors + 1).for_each(|node| writeln!(text, "{node}, {node}., 0.1, 0.2").unwrap());
    text.push_str("*ORIENTATION, NAME=A\n0.6, 0.8, 0., -0.8, 0.6, 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n");
    for number in 1..=connectors {
        if number % 8 < grounded {
            writeln!(text, "{number}, , {}", number + 1).unwrap();
        } else {
            writeln!(text, "{number}, {number}, {}", number + 1).unwrap();
        }
    }
    let (option, data) = if is_laden { (", BEHAVIOR=B", BEHAVIOR) } else { ("", "") };
    writeln!(text, "*CONNECTOR SECTION, ELSET=E{option}\nHINGE\nA,\n{data}").unwrap();
    Scene::parse("demand.inp", &text).unwrap_or_else(|error| panic!("{}", error.render(100, false)))
}

fn state(number: usize, nodes: usize) -> State {
    let time = number as f64 * 0.25;
    let moved = (1..=nodes).map(|node| {
        let swing = |rate: f64| (rate * time + node as f64).sin();
        let motion = NodeMotion {
            displacement: [0.05 * swing(1.0), 0.04 * swing(1.3), 0.03 * swing(0.7)],
            rotation: Rotation::Vector([0.2 * swing(0.9), 0.3 * swing(1.1), 0.4 * swing(0.8)]),
            velocity: [0.05, 0.04 * swing(0.3), -0.02],
            angular_velocity: [0.1 * swing(0.2), 0.2, 0.5],
            ..NodeMotion::default()
        };
        (Label::from(node as u64), motion)
    });
    State { number: Some(number as u64), time: Some(time), nodes: moved.collect(), ..State::default() }
}

/// What is done with a plan.
#[derive(Clone, Copy)]
enum Work {
    Evaluate,
    /// The sparse constraint Jacobian and nothing else.
    Assemble,
}

struct Line<'a> {
    what: String,
    model: &'a Model,
    plan: Plan,
    jacobian: Option<Jacobian>,
    least: f64,
    tally: Tally,
}

impl<'a> Line<'a> {
    fn new(what: &str, model: &'a Model, selection: &Selection, request: Request, work: Work) -> Self {
        let plan = Plan::compile(model, selection, request).unwrap();
        let jacobian = match work {
            Work::Evaluate => None,
            Work::Assemble => Some(Jacobian::of_constraints(model, &plan, &Fixed::none())),
        };
        Self { what: what.to_owned(), model, plan, jacobian, least: f64::INFINITY, tally: Tally::default() }
    }

    fn round(&mut self, states: &[State]) {
        let mut sequence = Sequence::new(self.model, &self.plan);
        let mut values = Vec::new();
        for state in states {
            let start = Instant::now();
            match &self.jacobian {
                None => drop(black_box(sequence.step(black_box(state)))),
                Some(jacobian) => {
                    black_box(sequence.assemble(black_box(state), jacobian, &mut values).unwrap());
                }
            }
            self.least = self.least.min(start.elapsed().as_secs_f64());
        }
        self.tally = sequence.tally();
    }
}

fn first(count: usize) -> Mask {
    std::array::from_fn(|k| k < count)
}

fn main() {
    let count: usize = std::env::args().filter_map(|word| word.parse().ok()).next().unwrap_or(4000);
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    let models = [(0, false), (4, false), (8, false), (0, true)]
        .map(|(grounded, is_laden)| Model::compile(&scene(count, grounded, is_laden)).unwrap());
    let [plain, half, all, laden] = &models;
    let states: Vec<State> = (1..=STATES).map(|number| state(number, count + 1)).collect();
    let named = |part: usize| Selection::Named((1..=count / part).map(|number| number.to_string()).collect());
    let whole = Selection::All;
    let rates = [Output::CP, Output::CU, Output::CV, Output::RES];
    let evaluate = |what: &str, model, selection: &Selection, request| {
        Line::new(what, model, selection, request, Work::Evaluate)
    };
    let cu = |components, order| Request::new(&[Output::CU], components, order);
    let mut lines = vec![
        evaluate("nothing", plain, &whole, Request::nothing(0)),
        evaluate("CU of u1", plain, &whole, cu(first(1), 0)),
        evaluate("CU of u1 to u3", plain, &whole, cu(first(3), 0)),
        evaluate("CU of all six", plain, &whole, cu([true; 6], 0)),
        evaluate("CP, CU, CV, RES of all six", plain, &whole, Request::new(&rates, [true; 6], 0)),
        evaluate("CU, of an eighth", plain, &named(8), cu([true; 6], 1)),
        evaluate("CU, of a quarter", plain, &named(4), cu([true; 6], 1)),
        evaluate("CU, of half of the connectors", plain, &named(2), cu([true; 6], 1)),
        evaluate("CU, with rows", plain, &whole, cu([true; 6], 1)),
        evaluate("CU, with rows and second derivatives", plain, &whole, cu([true; 6], 2)),
        evaluate("CU, with rows, half on the ground", half, &whole, cu([true; 6], 1)),
        evaluate("CU, with rows, all on the ground", all, &whole, cu([true; 6], 1)),
        evaluate("CU, with behaviours unasked for", laden, &whole, cu([true; 6], 1)),
        evaluate("CU and CEF", laden, &whole, Request::new(&[Output::CU, Output::CEF], [true; 6], 1)),
    ];
    for (what, model) in [("none", plain), ("half", half), ("all", all)] {
        let title = format!("Jacobian alone, {what} on the ground");
        lines.push(Line::new(&title, model, &whole, Request::new(&[], [true; 6], 1), Work::Assemble));
    }
    for _ in 0..ROUNDS {
        lines.iter_mut().for_each(|line| line.round(&states));
    }
    println!("{count} HINGEs, one thread; per connector and state; counts are of the counter of work");
    println!(
        "{:38} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8}",
        "", "ns", "values", "rows", "second", "rates", "turns", "forces", "rotations"
    );
    let each = |of: u64| of as f64 / (count * STATES) as f64;
    for Line { what, least, tally, jacobian, .. } in &lines {
        print!("{what:38} {:8.0}", 1e9 * least / count as f64);
        for number in
            [tally.values, tally.gradients, tally.hessians, tally.rates, tally.histories, tally.behaviors]
        {
            print!(" {:7.2}", each(number));
        }
        print!(" {:8.2}", each(tally.rotations));
        if let Some(jacobian) = jacobian {
            print!("   {:.1} entries", jacobian.entries() as f64 / count as f64);
        }
        println!();
    }
    let tally = |what: &str| lines.iter().find(|line| line.what == what).unwrap().tally;
    let (rows, unasked) = (tally("CU, with rows"), tally("CU, with behaviours unasked for"));
    assert_eq!(unasked, rows, "a behaviour that nobody asks about is work");
    assert_eq!(tally("CU, of an eighth").gradients * 8, rows.gradients);
    assert_eq!([tally("nothing").values, tally("CU of all six").gradients], [0; 2]);
    assert_eq!(rows.hessians, 0);
}
