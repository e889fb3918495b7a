//! `pintle bench` and the library beneath it: errors are what they must be, a wrong number is not timed, every format says the same.

use crate::cli::{file, pintle};
use pintle::bench::{Method, Order, Place, Prepared, Report, Session, Settings, Subject, Unmeasured, Way};
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
        between("num-dual by node", Order::Jacobian, -1.0, 1e-14);
        between("nested num-dual by node", Order::Hessian, -1.0, 1e-13);
        let coarse =
            points.iter().find(|p| p.method == "forward differences" && p.step == Some(0.1)).unwrap();
        assert!(coarse.largest_error > 1e-3, "{name}: {coarse:?}");
    }
}

/// pintle's own way with a number that is wrong by a relative amount: which one, of how many before the last.
struct Spoilt(Order, f64, usize);

struct SpoiltRun<'s>(Box<dyn Prepared + 's>, f64, usize);

impl Method for Spoilt {
    fn name(&self) -> &'static str {
        "spoilt"
    }

    fn order(&self) -> Order {
        self.0
    }

    fn is_ours(&self) -> bool {
        true
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Option<Box<dyn Prepared + 's>> {
        Some(Box::new(SpoiltRun(Way::Pintle(self.0).prepare(subject)?, self.1, self.2)))
    }
}

impl Prepared for SpoiltRun<'_> {
    fn run(&mut self) {
        self.0.run();
    }

    fn numbers(&self) -> Vec<f64> {
        let mut numbers = self.0.numbers();
        let place = numbers.len() - 1 - self.2;
        numbers[place] += self.1;
        numbers
    }
}

#[test]
fn a_wrong_number_is_not_timed() {
    let subject = [subject("ROTATION", Place::Near)];
    let spoilt = Spoilt(Order::Jacobian, 1e-6, 1);
    let wrong = Session::new(&settings(), &subject, &[&spoilt]).err().unwrap();
    assert!(wrong.to_string().contains("spoilt, Jacobian of ROTATION"), "{wrong}");
    assert!(wrong.error > 1e-8 && wrong.bound < 1e-9, "{wrong:?}");
}

/// A value is compared with what rounding of the input does to it, near a singular point as elsewhere: an error a hundred times that is
/// noticed, though derivatives there may be off by 1e-10.
#[test]
fn values_near_singular_points_are_judged_by_their_own_condition() {
    for name in ["ROTATION", "CARDAN", "AXIAL", "EULER"] {
        let subject = [subject(name, Place::Near)];
        let right = Spoilt(Order::Value, 0.0, 0);
        assert!(Session::new(&settings(), &subject, &[&right]).is_ok(), "{name}");
        let size = *subject[0].size_of_values().last().unwrap();
        let off = Spoilt(Order::Value, 100.0 * f64::EPSILON * size, 0);
        let wrong = Session::new(&settings(), &subject, &[&off]).err().unwrap();
        assert!(wrong.bound == 1e-14 && wrong.error < 1e-13, "{name}: {wrong:?}");
    }
}

/// A batch has the same states over and over, and every one of its numbers is looked at.
#[test]
fn a_batch_repeats_its_states() {
    let subject = [subject("REVOLUTE", Place::Far).repeated(7)];
    assert_eq!((subject[0].states(), subject[0].elements.len()), (2, 7));
    let [same, last] = [0, 6].map(|i| subject[0].elements[i].state.pair.b.triad);
    assert_eq!(same, last);
    let right = Spoilt(Order::Jacobian, 0.0, 0);
    assert!(Session::new(&settings(), &subject, &[&right]).is_ok());
    assert!(Session::new(&settings(), &subject, &[&Spoilt(Order::Jacobian, 1e-6, 1)]).is_err());
}

/// What is left out is left out for the reason told.
#[test]
fn reasons_are_what_happened() {
    let why = |name: &str, place: Place, states: usize| {
        Subject::new(&ConnectionType::named(name, None).unwrap(), place, states, 1e-4).err()
    };
    assert_eq!(why("SLIDE-PLANE", Place::Near, 1), Some(Unmeasured::NoSingularPoint));
    assert_eq!(why("SLIDE-PLANE", Place::Far, 0), Some(Unmeasured::NoState));
    for place in Place::ALL {
        assert_eq!(why("FLOW-CONVERTER", place, 1), Some(Unmeasured::NoFunction));
        assert_eq!(why("ROTATION", place, 1), None);
    }
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
        assert!(run(format, &["--near", "1.5e-3"]).contains("1.5e-3 from a singular point"), "{format}");
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
