//! `pintle bench` and the library beneath it: errors are what they must be, a wrong number is not timed, every format says the same.

use crate::commands::cli::{file, pintle};
use pintle_bench::{
    CLEAR, Cause, Method, Order, Point, Prepared, Proximity, Report, Session, Settings, Subject, Unmeasured,
    Way, Wrong, measure, worse,
};
use pintle_kinematics::catalog::ConnectionType;
use pintle_report::bench;
use std::fs;
use std::path::Path;
use std::time::Duration;

fn settings() -> Settings {
    Settings { rounds: 1, states: 2, budget: Duration::ZERO, ..Settings::default() }
}

fn subject(name: &str, place: Proximity) -> Subject {
    Subject::new(&ConnectionType::named(name, None).unwrap(), place, 2, 1e-4).unwrap()
}

/// The errors that theory gives: of each way at its best step, and of a difference at a large one.
#[test]
fn ways_have_the_errors_of_theory() {
    for name in
        ["REVOLUTE", "CARDAN", "TRANSLATOR", "ROTATION", "AXIAL", "FLEXION-TORSION", "PROJECTION CARTESIAN"]
    {
        let subject = [subject(name, Proximity::Far)];
        let ways = Way::all();
        let methods: Vec<&dyn Method> = ways.iter().map(|way| way as &dyn Method).collect();
        let points = Session::new(&settings(), &subject, &methods).points();
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
        for order in [Order::Jacobian, Order::Hessian] {
            between("pintle, batch", order, -1.0, 1e-14);
        }
        between("forward differences", Order::Jacobian, 1e-10, 1e-6);
        between("central differences", Order::Jacobian, 1e-13, 1e-8);
        between("central differences", Order::Hessian, 1e-10, 1e-5);
        between("num-dual by node", Order::Jacobian, -1.0, 1e-14);
        between("nested num-dual by node", Order::Hessian, -1.0, 1e-13);
        let coarse =
            points.iter().find(|p| p.method == "forward differences" && p.step == Some(0.1)).unwrap();
        assert!(coarse.largest_error > 1e-3, "{name}: {coarse:?}");
    }
}

/// Batches are measured for every type that they know, with errors as small as those of one connector at a time, on whichever vector unit there is; of a
/// type whose rows depend on material flow the reason is told.
#[test]
fn batches_are_measured_of_every_type_that_has_them() {
    let mut refused = Vec::new();
    for connection in pintle_kinematics::catalog::TABLE {
        for place in Proximity::ALL {
            let Ok(subject) = Subject::new(connection, place, 3, 1e-4) else { continue };
            let subject = [subject.repeated(5)];
            let ways = [Way::Batch(Order::Jacobian), Way::Batch(Order::Hessian)];
            let methods = [&ways[0] as &dyn Method, &ways[1]];
            let mut session = Session::new(&settings(), &subject, &methods);
            session.round();
            if session.untimed().is_empty() {
                let points = session.points();
                assert_eq!(points.len(), 2, "{} {place:?}", connection.name);
                for point in points {
                    assert_eq!(point.vector_unit.as_deref(), pintle_kinematics::batch::vector_unit());
                    assert!(point.method == "pintle, batch" && point.nanoseconds > 0.0, "{point:?}");
                }
            } else {
                assert!(session.untimed().iter().all(|one| one.why.contains("material flow")));
                refused.push((connection.name.as_ref(), place));
            }
            // Five elements fill two tiles.
            let prepared = ways[0].prepare(&subject[0]);
            assert!(prepared.is_err() || prepared.is_ok_and(|run| run.states() == 8), "{}", connection.name);
        }
    }
    assert!(!refused.is_empty() && refused.iter().all(|(name, _)| *name == "SLIPRING"), "{refused:?}");
    let subject = subject("HINGE", Proximity::Far);
    assert!(Way::Batch(Order::Value).prepare(&subject).err().unwrap().contains("not alone"));
}

/// pintle's own way with a number that is wrong by a relative amount: which one, of how many before the last.
struct Spoilt(Order, f64, usize, Cause);

/// The states so many times.
struct SpoiltRun<'s>(Box<dyn Prepared + 's>, f64, usize, usize);

impl Method for Spoilt {
    fn name(&self) -> &'static str {
        "spoilt"
    }

    fn order(&self) -> Order {
        self.0
    }

    fn cause(&self) -> Cause {
        self.3
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
        let repeated = subject.batch / subject.states();
        Ok(Box::new(SpoiltRun(Way::Pintle(self.0).prepare(subject)?, self.1, self.2, repeated)))
    }
}

impl Prepared for SpoiltRun<'_> {
    fn run(&mut self) {
        self.0.run();
    }

    fn states(&self) -> usize {
        self.0.states() * self.3
    }

    fn numbers(&mut self) -> Vec<f64> {
        let mut numbers = self.0.numbers().repeat(self.3);
        let place = numbers.len() - 1 - self.2;
        numbers[place] += self.1;
        numbers
    }
}

#[test]
fn a_wrong_number_is_not_timed() {
    let subject = [subject("ROTATION", Proximity::Near)];
    let spoilt = Spoilt(Order::Jacobian, 1e-6, 1, Cause::Ours);
    let mut session = Session::new(&settings(), &subject, &[&spoilt, &Way::Pintle(Order::Jacobian)]);
    let [wrong] = session.wrong() else { panic!("{:?}", session.wrong()) };
    assert!(wrong.to_string().contains("ROTATION, near: Jacobian of spoilt is wrong"), "{wrong}");
    assert!(wrong.error > 1e-8 && wrong.bound < 1e-9, "{wrong:?}");
    // What is right is measured all the same.
    assert_eq!((session.round().len(), session.points().len(), session.untimed().len()), (1, 1, 0));
}

/// What is wrong is told in every format, beside what is right; of a type with nothing that is right, too.
#[test]
fn what_is_wrong_is_told_in_its_place() {
    let types = ["SLIDE-PLANE", "ALIGN"].map(|name| ConnectionType::named(name, None).unwrap());
    let mut report = measure(&settings(), &types, &|_| {});
    assert_eq!(report.wrong, []);
    for connection in ["ALIGN", "PLANAR"] {
        report.wrong.push(Wrong {
            connection: connection.into(),
            place: Proximity::Far,
            order: Order::Jacobian,
            method: "pintle, batch".into(),
            error: f64::INFINITY,
            bound: 2.5e-15,
        });
    }
    let told = |write: &dyn Fn(&mut Vec<u8>)| {
        let mut out = Vec::new();
        write(&mut out);
        String::from_utf8(out).unwrap()
    };
    let human = told(&|out| bench::human(out, &report, 110).unwrap());
    let markdown = told(&|out| bench::markdown(out, &report).unwrap());
    for text in [&human, &markdown] {
        assert_eq!(text.matches("2.5e-15 is allowed").count(), 2, "{text}");
        assert!(text.contains("PLANAR") && text.contains("SLIDE-PLANE"), "{text}");
    }
    let csv = told(&|out| bench::csv(out, &report).unwrap());
    assert_eq!(csv.lines().count(), 1 + report.points.len() + 2);
    assert!(csv.ends_with("PLANAR,far,Jacobian,\"pintle, batch\",,,,,,inf,,,2.5e-15\n"), "{csv}");
    let json = told(&|out| bench::json(out, &report).unwrap());
    let same: Report = serde_json::from_str(&json).unwrap();
    assert_eq!(same.wrong, report.wrong);
}

/// At the states that the command measures, and nearer to and farther from singular points, all of pintle's numbers are within what rounding explains, of every
/// type; so are those of the other ways that only round.
#[test]
fn no_number_of_pintle_is_wrong_where_it_is_measured() {
    let ways: Vec<Way> = Way::all().into_iter().filter(|way| way.cause() == Cause::Ours).collect();
    let ways = ways.into_iter().chain([Way::NodalDual, Way::NestedDual]);
    let ways: Vec<Way> = ways.collect();
    let methods: Vec<&dyn Method> = ways.iter().map(|way| way as &dyn Method).collect();
    let mut bad = Vec::new();
    for (distance, states) in
        [(1e-4, Settings::default().states), (1e-1, 3), (1e-2, 3), (1e-7, 3), (1e-11, 3)]
    {
        let settings = Settings { distance, states, ..settings() };
        for connection in pintle_kinematics::catalog::TABLE {
            let subjects = Report::new(&settings).subjects(&settings, connection);
            let session = Session::new(&settings, &subjects, &methods);
            bad.extend(session.wrong().iter().map(|wrong| format!("{distance:e}: {wrong}")));
            let untimed = session.untimed().iter().filter(|one| one.why.contains("is allowed"));
            bad.extend(untimed.map(|one| format!("{distance:e}: {one:?}")));
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// A row whose own derivatives are small and whose second ones are large, beside a singular point, is known to less than its largest number says; and
/// no worse than its second derivatives say.
#[test]
fn rows_are_judged_by_their_own_condition() {
    let connection = ConnectionType::named("PROJECTION CARTESIAN", None).unwrap();
    let states = Settings::default().states;
    let subject = Subject::new(&connection, Proximity::Near, states, 1e-4).unwrap();
    let mut found = Way::Batch(Order::Jacobian).prepare(&subject).unwrap().numbers();
    let [_, largest] = subject.errors(Order::Jacobian, &found);
    let [error, allowed] = subject.beyond_rounding(Order::Jacobian, &found);
    // 1.6e-10 was measured, where 1e-14/distance = 1e-10 was allowed.
    assert!(largest > 1e-11 && error <= allowed, "{largest:e} {error:e} {allowed:e}");
    // The entry of the row that is known best, off by a hundred roundings.
    let truth = subject.truth(Order::Jacobian);
    let most = (0..truth.len()).max_by(|a, b| truth[*a].abs().total_cmp(&truth[*b].abs())).unwrap();
    found[most] += 1e-10 * truth[most];
    let [error, allowed] = subject.beyond_rounding(Order::Jacobian, &found);
    assert!(error > allowed && error < 1.1e-10, "{error:e} {allowed:e}");
}

/// A number that is missing or none is an infinite error, one that is as it must be is none.
#[test]
fn what_is_not_a_number_is_beyond_rounding() {
    let subject = subject("SLIDE-PLANE", Proximity::Far);
    let truth = subject.truth(Order::Jacobian);
    let judged = |found: &[f64]| subject.beyond_rounding(Order::Jacobian, found);
    assert!(judged(&truth)[0] < 1e-15);
    assert_eq!(judged(&truth[1..])[0], f64::INFINITY);
    assert_eq!(judged(&[])[0], f64::INFINITY);
    let spoilt = |x: f64| [&truth[..3], &[x], &truth[4..]].concat();
    for x in [f64::NAN, f64::INFINITY] {
        assert_eq!(judged(&spoilt(x))[0], f64::INFINITY);
        assert_eq!(subject.errors(Order::Jacobian, &spoilt(x))[1], f64::INFINITY);
    }
}

/// The largest of errors is never a number where one of them is none: [`f64::max`] would pass over it.
#[test]
fn no_error_is_passed_over() {
    for (worst, error) in [(0.0, f64::NAN), (f64::NAN, 0.0), (f64::NAN, f64::NAN), (f64::INFINITY, 1.0)] {
        assert_eq!(worse(worst, error), f64::INFINITY);
    }
    assert_eq!([0.5, f64::NAN, 1.0].into_iter().fold(0.0, worse), f64::INFINITY);
    assert_eq!([0.5, 2.0, 1.0].into_iter().fold(0.0, worse), 2.0);
}

/// A row that no way has is told in every format.
#[test]
fn rows_that_are_left_out_are_told() {
    let types = [ConnectionType::named("RETRACTOR", None).unwrap()];
    let report = measure(&settings(), &types, &|_| {});
    let rows = |point: &Point| (point.rows.join(" "), point.left_out.join(" "));
    assert!(report.points.iter().any(|point| point.method == "pintle, batch"));
    for point in &report.points {
        assert_eq!(rows(point), ("u1 u2 u3".into(), "ur3".into()), "{point:?}");
    }
    let mut out = Vec::new();
    bench::human(&mut out, &report, 200).unwrap();
    bench::markdown(&mut out, &report).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert_eq!(
        text.matches("RETRACTOR: every way leaves out the row of ur3, a one-form").count(),
        2,
        "{text}"
    );
    let mut out = Vec::new();
    bench::csv(&mut out, &report).unwrap();
    assert!(String::from_utf8(out).unwrap().lines().skip(1).all(|line| line.ends_with(",u1 u2 u3,ur3,")));
    // Of all that there are, others leave nothing out.
    assert_eq!(
        measure(&settings(), &[ConnectionType::named("HINGE", None).unwrap()], &|_| {}).points[0]
            .left_out
            .len(),
        0
    );
}

/// A value is compared with what rounding of the input does to it, near a singular point as elsewhere: an error a hundred times that is
/// noticed, though derivatives there may be off by 1e-10.
#[test]
fn values_near_singular_points_are_judged_by_their_own_condition() {
    for name in ["ROTATION", "CARDAN", "AXIAL", "EULER"] {
        let subject = [subject(name, Proximity::Near)];
        let right = Spoilt(Order::Value, 0.0, 0, Cause::Ours);
        assert_eq!(Session::new(&settings(), &subject, &[&right]).wrong(), [], "{name}");
        let size = *subject[0].size_of_values().last().unwrap();
        let off = Spoilt(Order::Value, 100.0 * f64::EPSILON * size, 0, Cause::Ours);
        let session = Session::new(&settings(), &subject, &[&off]);
        let [wrong] = session.wrong() else { panic!("{name}: {:?}", session.wrong()) };
        assert!(wrong.bound < 1e-15 && wrong.error < 1e-13, "{name}: {wrong:?}");
    }
}

/// A batch has the same states over and over, and every one of its numbers is looked at.
#[test]
fn a_batch_repeats_its_states() {
    let subject = [subject("REVOLUTE", Proximity::Far).repeated(6)];
    assert_eq!((subject[0].states(), subject[0].in_batch().count()), (2, 6));
    let triads: Vec<_> = subject[0].in_batch().map(|element| element.state.pair.b.triad).collect();
    assert_eq!(triads[0], triads[4]);
    let of_last = |error: f64, before: usize| {
        let spoilt = Spoilt(Order::Jacobian, error, before, Cause::Ours);
        Session::new(&settings(), &subject, &[&spoilt]).wrong().is_empty()
    };
    assert!(of_last(0.0, 0) && !of_last(1e-6, 1) && !of_last(1e-6, 3 * 14 * 5));
}

/// Another's numbers that are wrong are not timed either, and that is said; the bound is that of what its errors come from.
#[test]
fn who_is_wrong_is_named_and_not_timed() {
    let subject = [subject("ROTATION", Proximity::Near)];
    let found = |error: f64, cause: Cause| {
        let spoilt = Spoilt(Order::Jacobian, error, 1, cause);
        let session = Session::new(&settings(), &subject, &[&spoilt]);
        (session.points().len(), session.untimed().to_vec())
    };
    assert_eq!(found(1e-8, Cause::NoBranches), (1, Vec::new()));
    for (error, cause) in
        [(1e-8, Cause::Rounding), (1e-3, Cause::NoBranches), (1e-1, Cause::ForwardDifference)]
    {
        let (points, untimed) = found(error, cause);
        assert_eq!((points, untimed.len()), (0, 1));
        assert!(untimed[0].method == "spoilt" && untimed[0].why.contains("is allowed"), "{untimed:?}");
    }
}

/// All states of a subject have the rows of the type with its constraints met, and lie where they are said to.
#[test]
fn states_have_the_same_rows() {
    for connection in pintle_kinematics::catalog::TABLE {
        for place in Proximity::ALL {
            let Ok(subject) = Subject::new(connection, place, 9, 1e-4) else { continue };
            for element in &subject.elements {
                let own: Vec<_> = (0..6).filter_map(|k| element.connector.differentiated(k)).collect();
                let own: Vec<_> = own.into_iter().filter(|measure| !measure.is_one_form()).collect();
                assert_eq!(own, subject.measures, "{} {place:?}", connection.name);
                let margins = element.connector.margins(&element.state, &element.branch, [true; 6]);
                let of_rows = subject.components.iter().filter_map(|k| margins[*k]);
                let least = of_rows.map(|margin| margin.distance).fold(f64::INFINITY, f64::min);
                match place {
                    Proximity::Far => assert!(least >= CLEAR, "{}: {least:e}", connection.name),
                    // Rotation vectors are near half a turn, which is not singular.
                    Proximity::Near => assert!(
                        (least / 1e-4 - 1.0).abs() < 1e-6 || least > 3.0,
                        "{}: {least:e}",
                        connection.name
                    ),
                    Proximity::Rest => {}
                }
            }
        }
    }
}

/// Far states go through the regions: angles of b against a from small to nearly half a turn, all quadrants.
#[test]
fn far_states_cover_the_regions() {
    for name in ["REVOLUTE", "TRANSLATOR", "ROTATION", "CARDAN"] {
        let subject =
            Subject::new(&ConnectionType::named(name, None).unwrap(), Proximity::Far, 64, 1e-4).unwrap();
        let q: Vec<_> = subject.elements.iter().map(|element| element.state.pair.relative().q).collect();
        let angles: Vec<f64> = q.iter().map(|q| ((q[0][0] + q[1][1] + q[2][2] - 1.0) / 2.0).acos()).collect();
        let count = |from: f64, to: f64| angles.iter().filter(|angle| (from..to).contains(*angle)).count();
        assert!(count(0.0, 1.0) > 5 && count(1.0, 2.0) > 5 && count(2.0, 3.0) >= 3, "{name}: {angles:?}");
        for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let in_quadrant =
                q.iter().filter(|q| q[1][2] * signs[0] > 0.0 && q[2][2] * signs[1] > 0.0).count();
            assert!(in_quadrant > 0, "{name} {signs:?}: {in_quadrant}");
        }
    }
}

/// What is left out is left out for the reason told.
#[test]
fn reasons_are_what_happened() {
    let why = |name: &str, place: Proximity, states: usize| {
        Subject::new(&ConnectionType::named(name, None).unwrap(), place, states, 1e-4).err()
    };
    assert_eq!(why("SLIDE-PLANE", Proximity::Near, 1), Some(Unmeasured::NoSingularPoint));
    assert_eq!(why("SLIDE-PLANE", Proximity::Far, 0), Some(Unmeasured::NoState));
    assert_eq!(why("SLIDE-PLANE", Proximity::Rest, 1), Some(Unmeasured::NothingAtRest));
    for place in Proximity::ALL {
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
    // SLIDE-PLANE has no singular point, and neither divides by an angle that is zero at rest.
    assert_eq!(report.omitted.len(), 3);
    assert!(!report.points.iter().any(|p| p.connection == "SLIDE-PLANE" && p.place == Proximity::Near));
    let table = run("csv", &[]);
    assert_eq!(table.lines().count(), 1 + report.points.len());
    let unit = pintle_kinematics::batch::vector_unit();
    let batches = || report.points.iter().filter(|p| p.method == "pintle, batch");
    // Rows and second derivatives of SLIDE-PLANE far, and of REVOLUTE far and near.
    assert_eq!(batches().count(), 6);
    assert!(batches().all(|p| p.vector_unit.as_deref() == unit && p.largest_error < 1e-10));
    let cells = format!("jacobian,\"pintle, batch\",,{},", unit.unwrap_or_default()).to_lowercase();
    assert!(table.to_lowercase().contains(&cells), "{table}");
    for (format, head) in [("human", "REVOLUTE, far from singular points"), ("markdown", "**REVOLUTE**, far")]
    {
        let text = run(format, &[]);
        assert!(text.contains(head) && text.contains("forward differences"), "{text}");
        let batch = unit.map_or("pintle, batch".into(), |unit| format!("pintle, batch, {unit}"));
        assert!(text.contains(&batch), "{text}");
        assert!(text.contains("SLIDE-PLANE, near: not measured: its rows have no singular point"), "{text}");
        assert!(run(format, &["--near", "1.5e-3"]).contains("1.5e-3 from a singular point"), "{format}");
    }
    let figure = fs::read_to_string(folder.join("revolute-jacobian-near.svg")).unwrap();
    assert!(figure.contains("num-dual by node") && figure.matches("<polyline").count() == 5, "{figure}");
    assert!(figure.contains(">REVOLUTE: Jacobian, time against error</text>"), "{figure}");
    let machine = report.environment.short();
    assert!(machine.contains(&report.environment.date), "{machine}");
    let version = report.environment.commit.as_ref().unwrap_or(&report.environment.pintle);
    assert!(machine.ends_with(&format!("pintle {version}")), "{machine}");
    assert!(figure.contains(&format!(">one core of {machine}</text>")), "{figure}");
    // Six diagrams, and both types together; nothing of what was written to see whether it can be.
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 7);
    let both = fs::read_to_string(folder.join("jacobian-far.svg")).unwrap();
    assert!(
        both.contains(">geometric mean of SLIDE-PLANE, REVOLUTE</text>")
            && both.matches("<polyline").count() == 5,
        "{both}"
    );
}

#[test]
fn what_cannot_be_measured_is_said() {
    let refused = |words: &[&str], code: i32, message: &str| {
        let assert = pintle(words).assert().code(code);
        let text = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
        assert!(text.contains(message), "{text}");
        // Before anything is measured.
        assert!(assert.get_output().stdout.is_empty());
    };
    refused(&["bench", "REVOLVE"], 2, "REVOLVE");
    refused(&["bench", "--rounds", "0"], 2, "--rounds");
    refused(&["bench", "--near", "1"], 2, "is not a distance");
    refused(&["bench", "FLOW-CONVERTER"], 4, "nothing to measure but one-forms");
    let occupied = file("bench-file", "");
    refused(
        &["bench", "SLIDE-PLANE", "--rounds", "1", "--states", "1", "--plots", &occupied],
        7,
        "cannot write",
    );
}
