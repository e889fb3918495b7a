//! `pintle bench` and the library beneath it: errors are what they must be, a wrong number is not timed, every format says the same.

use crate::cli::{file, pintle};
use pintle::bench::{Method, Order, Place, Prepared, Report, Session, Settings, Subject, Way};
use pintle::catalog::ConnectionType;
use std::fs;
use std::path::Path;
use std::time::Duration;

fn settings() -> Settings {
    Settings { rounds: 1, states: 2, budget: Duration::ZERO, ..Settings::default() }
}

fn subject(name: &str, place: Place) -> Subject {
    Subject::new(&ConnectionType::named(name, None).unwrap(), place, 2, 1e-4).unwrap()
}

/// The errors that theory gives: of each way at its best step, and of a difference at a large one.
#[test]
fn ways_have_the_errors_of_theory() {
    for name in ["REVOLUTE", "CARDAN", "TRANSLATOR", "ROTATION", "AXIAL"] {
        let subject = [subject(name, Place::Far)];
        let ways = Way::all();
        let methods: Vec<&dyn Method> = ways.iter().map(|way| way as &dyn Method).collect();
        let points = Session::new(&settings(), &subject, &methods).unwrap().points();
        let best = |method: &str, order: Order| {
            let own = points.iter().filter(|p| p.method == method && p.order == order);
            own.map(|p| p.largest_error).fold(f64::INFINITY, f64::min)
        };
        let between = |method: &str, order: Order, low: f64, high: f64| {
            let error = best(method, order);
            assert!(low < error && error < high, "{name} {method} {order:?}: {error:e}");
        };
        for order in Order::ALL {
            between("pintle", order, -1.0, 1e-14);
        }
        between("forward differences", Order::Jacobian, 1e-10, 1e-6);
        between("central differences", Order::Jacobian, 1e-13, 1e-8);
        between("central differences", Order::Hessian, 1e-10, 1e-5);
        between("complex step", Order::Jacobian, -1.0, 1e-14);
        between("dual numbers by node", Order::Jacobian, -1.0, 1e-14);
        between("nested dual numbers by node", Order::Hessian, -1.0, 1e-13);
        let coarse =
            points.iter().find(|p| p.method == "forward differences" && p.step == Some(0.1)).unwrap();
        assert!(coarse.largest_error > 1e-3, "{name}: {coarse:?}");
    }
}

/// pintle's own way with an entry that is wrong by 1e-6.
struct Spoilt;

struct SpoiltRun<'s>(Box<dyn Prepared + 's>);

impl Method for Spoilt {
    fn name(&self) -> &'static str {
        "spoilt"
    }

    fn order(&self) -> Order {
        Order::Jacobian
    }

    fn is_ours(&self) -> bool {
        true
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Option<Box<dyn Prepared + 's>> {
        Some(Box::new(SpoiltRun(Way::Pintle(Order::Jacobian).prepare(subject)?)))
    }
}

impl Prepared for SpoiltRun<'_> {
    fn run(&mut self) {
        self.0.run();
    }

    fn numbers(&self) -> Vec<f64> {
        let mut numbers = self.0.numbers();
        numbers[12] += 1e-6;
        numbers
    }
}

#[test]
fn a_wrong_number_is_not_timed() {
    let subject = [subject("ROTATION", Place::Near)];
    let wrong = Session::new(&settings(), &subject, &[&Spoilt]).err().unwrap();
    assert!(wrong.to_string().contains("spoilt, Jacobian of ROTATION"), "{wrong}");
    assert!(wrong.error > 1e-8 && wrong.bound < 1e-9, "{wrong:?}");
}

/// The same points in every format, and a figure for each diagram.
#[test]
fn the_command_measures_a_type() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bench");
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    let run = |format: &str, more: &[&str]| {
        let words = [&["bench", "slide-plane", "revolute", "--rounds", "1", "--states", "1"], more].concat();
        let assert = pintle(&[&words[..], &["--format", format]].concat()).assert().success();
        String::from_utf8(assert.get_output().stdout.clone()).unwrap()
    };
    let json = run("json", &["--plots", folder.to_str().unwrap()]);
    let report: Report = serde_json::from_str(&json).unwrap();
    assert_eq!((report.schema.as_ref(), report.rounds, report.states), ("pintle-bench/1", 1, 1));
    assert!(report.environment.rustc.starts_with("rustc 1."), "{:?}", report.environment);
    assert!(report.points.iter().all(|p| p.nanoseconds > 0.0 && p.slowest_round >= p.nanoseconds));
    // SLIDE-PLANE has no singular point.
    assert_eq!(report.omitted.len(), 1);
    assert!(!report.points.iter().any(|p| p.connection == "SLIDE-PLANE" && p.place == Place::Near));
    assert_eq!(run("csv", &[]).lines().count(), 1 + report.points.len());
    for (format, head) in [("human", "REVOLUTE, far from singular points"), ("markdown", "**REVOLUTE**, far")]
    {
        let text = run(format, &[]);
        assert!(text.contains(head) && text.contains("forward differences"), "{text}");
        assert!(text.contains("SLIDE-PLANE, near: not measured: it has no singular point"), "{text}");
    }
    let figure = fs::read_to_string(folder.join("revolute-jacobian-near.svg")).unwrap();
    assert!(figure.contains("complex step") && figure.matches("<polyline").count() == 5, "{figure}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 6);
}

#[test]
fn what_cannot_be_measured_is_said() {
    let refused = |words: &[&str], code: i32, message: &str| {
        let assert = pintle(words).assert().code(code);
        let text = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
        assert!(text.contains(message), "{text}");
    };
    refused(&["bench", "REVOLVE"], 2, "REVOLVE");
    refused(&["bench", "--rounds", "0"], 2, "--rounds");
    refused(&["bench", "--near", "1"], 2, "is not a distance");
    refused(&["bench", "FLOW-CONVERTER"], 4, "nothing to measure but one-forms");
    let occupied = file("bench-file", "");
    refused(
        &["bench", "SLIDE-PLANE", "--rounds", "1", "--states", "1", "--plots", &occupied],
        6,
        "cannot write figures",
    );
}
