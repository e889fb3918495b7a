//! Cost follows the request: the time of a state beside the counter of work, as outputs, connectors, the order of derivatives and the
//! nodes on the ground vary: `taskset -c 3 cargo bench --bench demand [CONNECTORS] [-- LINE]`.
//!
//! Times are the least of rounds that take turns; the counts are asserted, the times are for reading. With the name of a line that alone
//! is done, for counters of instructions: `valgrind --tool=callgrind --toggle-collect='*Line*round*' PROGRAM 200 "CU, with rows"`.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;

use pintle_kinematics::connector::{Mask, Output, Request, Tally};
use pintle_model::evaluate::{Fixed, Freedom, Jacobian, Model, Plan, Selection, Sequence};
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State};
use std::convert::Infallible;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 7;
const STATES: usize = 3;

/// How many of eight connectors have the ground as their first end, in words.
const GROUNDED: [(usize, &str); 5] = [
    (0, "none on the ground"),
    (2, "a quarter on the ground"),
    (4, "half on the ground"),
    (6, "three quarters on the ground"),
    (8, "all on the ground"),
];

/// A spring, a damper and a stop on every HINGE.
const BEHAVIOR: &str = "*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=4\n10.\n*CONNECTOR DAMPING, COMPONENT=4\n1.\n\
                        *CONNECTOR STOP, COMPONENT=4\n-9., 9.\n";

/// Friction besides.
const FRICTION: &str = "*CONNECTOR FRICTION, COMPONENT=4\n, 5.\n*FRICTION\n0.1\n";

/// What acts on the connectors.
#[derive(Clone, Copy, PartialEq)]
enum Laden {
    Not,
    WithoutFriction,
    WithFriction,
}

/// A chain of HINGEs in which every node turns; of `grounded` in eight the first end is the ground.
fn scene(connectors: usize, grounded: usize, laden: Laden) -> Scene {
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
    let option = if laden == Laden::Not { "" } else { ", BEHAVIOR=B" };
    writeln!(text, "*CONNECTOR SECTION, ELSET=E{option}\nHINGE\nA,").unwrap();
    match laden {
        Laden::Not => {}
        Laden::WithoutFriction => text.push_str(BEHAVIOR),
        Laden::WithFriction => text.extend([BEHAVIOR, FRICTION]),
    }
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
    /// The sparse constraint Jacobian and nothing else, of nodes of which one in so many is fixed; 0 is none.
    Assemble(usize),
}

/// All degrees of freedom of one in so many nodes.
fn fixed(plan: &Plan, each: usize) -> Fixed {
    let chosen = plan.nodes.iter().enumerate().filter(|(at, _)| each > 0 && at % each == 0);
    chosen.flat_map(|(_, node)| (1..=6).map(|number| Freedom { node: *node, number })).collect()
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
            Work::Assemble(each) => Some(Jacobian::of_constraints(model, &plan, &fixed(&plan, each))),
        };
        Self { what: what.to_owned(), model, plan, jacobian, least: f64::INFINITY, tally: Tally::default() }
    }

    fn round(&mut self, states: &[State]) {
        let mut sequence = Sequence::new(self.model, &self.plan);
        let mut values = Vec::new();
        for state in states {
            let start = Instant::now();
            match &self.jacobian {
                None => {
                    let Ok(()) = sequence.visit(black_box(state), |item| -> Result<(), Infallible> {
                        black_box(item);
                        Ok(())
                    });
                }
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
    if commit::is_told() {
        return;
    }
    let count: usize = std::env::args().filter_map(|word| word.parse().ok()).next().unwrap_or(4000);
    let count = count.next_multiple_of(8);
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    let only = std::env::args().skip(1).find(|word| !word.starts_with('-') && word.parse::<usize>().is_err());
    let model = |grounded, laden| Model::compile(&scene(count, grounded, laden)).unwrap();
    let [laden, sliding] = &[Laden::WithoutFriction, Laden::WithFriction].map(|laden| model(0, laden));
    // By how many eighths of the connectors are on the ground.
    let grounded = GROUNDED.map(|(eighths, words)| (words, model(eighths, Laden::Not)));
    let plain = &grounded[0].1;
    let states: Vec<State> = (1..=STATES).map(|number| state(number, count + 1)).collect();
    let named = |part: usize| Selection::Named((1..=count / part).map(|number| number.to_string()).collect());
    let whole = Selection::All;
    let rates = [Output::CP, Output::CU, Output::CV, Output::RES];
    let evaluate = |what: &str, model, selection: &Selection, request| {
        Line::new(what, model, selection, request, Work::Evaluate)
    };
    let cu = |components, order| Request::new(&[Output::CU], components, order);
    let elastic = || Request::new(&[Output::CU, Output::CEF], [true; 6], 1);
    let friction = [Output::CU, Output::CEF, Output::CSF];
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
        evaluate("CU, with behaviours unasked for", sliding, &whole, cu([true; 6], 1)),
        evaluate("CU and CEF", laden, &whole, elastic()),
        evaluate("CU and CEF, friction unasked for", sliding, &whole, elastic()),
        evaluate("CU, CEF and CSF", sliding, &whole, Request::new(&friction, [true; 6], 1)),
    ];
    for (words, model) in &grounded[1..] {
        lines.push(evaluate(&format!("CU, with rows, {words}"), model, &whole, cu([true; 6], 1)));
    }
    let on_the_ground = grounded.iter().map(|(words, model)| (*words, model, 0));
    let fixed = [("half of the nodes fixed", plain, 2), ("all nodes fixed", plain, 1)];
    for (what, model, each) in on_the_ground.chain(fixed) {
        let title = format!("Jacobian alone, {what}");
        lines.push(Line::new(&title, model, &whole, Request::nothing(0), Work::Assemble(each)));
    }
    if let Some(only) = only {
        let line = lines.iter_mut().find(|line| line.what == only);
        return line.unwrap_or_else(|| panic!("there is no line {only:?}")).round(&states);
    }
    for _ in 0..ROUNDS {
        lines.iter_mut().for_each(|line| line.round(&states));
    }
    println!("{count} HINGEs, one thread; per connector and state; counts are of the counter of work");
    println!(
        "{:46} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8}",
        "", "ns", "values", "rows", "second", "rates", "turns", "forces", "rotations"
    );
    let each = |of: u64| of as f64 / (count * STATES) as f64;
    for Line { what, least, tally, jacobian, .. } in &lines {
        print!("{what:46} {:8.0}", 1e9 * least / count as f64);
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
    let line = |what: &str| lines.iter().find(|line| line.what == what).unwrap();
    let tally = |what: &str| line(what).tally;
    let (rows, unasked) = (tally("CU, with rows"), tally("CU, with behaviours unasked for"));
    assert_eq!(unasked, rows, "a behaviour that nobody asks about is work");
    assert_eq!(
        tally("CU and CEF, friction unasked for"),
        tally("CU and CEF"),
        "friction that nobody asks about is work"
    );
    for (what, part) in
        [("CU, of an eighth", 8), ("CU, of a quarter", 4), ("CU, of half of the connectors", 2)]
    {
        let part_of = tally(what);
        assert_eq!(
            [part_of.values, part_of.gradients].map(|count| count * part),
            [rows.values, rows.gradients],
            "{what}"
        );
    }
    // A HINGE has three positions along which it measures, and three angles of which the first winds and is counted.
    let values = ["nothing", "CU of u1", "CU of u1 to u3", "CU of all six"].map(|what| tally(what).values);
    assert!(values.is_sorted() && values[0] == 0 && values[2] == 3 * values[1], "{values:?}");
    assert_eq!([tally("nothing").gradients, tally("CU of all six").gradients, rows.hessians], [0; 3]);
    assert!(tally("CU, with rows and second derivatives").hessians > 0);
    // The ground is turned by nobody, and has no columns; neither have nodes that are fixed.
    let grounded = tally("CU, with rows, all on the ground");
    assert_eq!(grounded.rotations, rows.rotations - STATES as u64);
    let entries = |what: &str| line(what).jacobian.as_ref().unwrap().entries();
    let by_ground = GROUNDED.map(|(_, words)| entries(&format!("Jacobian alone, {words}")));
    assert!(by_ground.is_sorted_by(|more, fewer| more > fewer), "{by_ground:?}");
    assert!(entries("Jacobian alone, half of the nodes fixed") < by_ground[0]);
    assert_eq!(entries("Jacobian alone, all nodes fixed"), 0);
    let Tally { values, gradients, histories, .. } = tally("Jacobian alone, all nodes fixed");
    assert_eq!([values, gradients, histories], [0; 3], "nodes that are fixed are work");
}
