//! Counter-examples of what is no connector: constraints, frictions, belts, springs and dampers, as values that fail again.

use crate::audit::command::folder;
use crate::behavior::belts::{STIFFNESS, deck as belt, state as pulled};
use crate::commands::cli::{pintle, stderr, stdout};
use crate::laws::mpc;
use pintle_audit::{
    About, Check, CounterExample, Failing, MpcCase, Oracle, Planted, Report, Settings, Target, audit_scenes,
    friction_cases,
};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::{Request, Turns};
use pintle_kinematics::mpc::Turning;
use pintle_model::evaluate::{Model, Plan, Selection};
use pintle_scene::{Scene, State};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;

const START: [Turns<f64>; 2] = [Turns { turns: 0.0, principal: 0.0 }; 2];

/// A drawn constraint as the audit judges it.
fn judged(drawn: &mpc::Case) -> MpcCase {
    MpcCase {
        constraint: drawn.constraint(),
        name: drawn.name.clone(),
        state: drawn.state,
        turning: Turning::none(),
        before: START,
        length: drawn.length,
    }
}

/// The counter-example of a constraint at a state, of its first derivative that a planted fault spoils.
pub(crate) fn of_constraint(drawn: &mpc::Case) -> (MpcCase, CounterExample) {
    let case = judged(drawn);
    let checks = case.audit(&planted(Planted::WrongEntry), false);
    let wrong = checks.iter().find(|check| check.verdict.is_mismatch()).unwrap();
    let recorded = CounterExample::of(wrong, "a test").unwrap_or_else(|| panic!("{wrong:?}"));
    (case, recorded)
}

/// Counter-examples of a friction, a belt, and springs with tables.
pub(crate) fn others() -> Vec<CounterExample> {
    let connection = TABLE.iter().find(|connection| connection.name == "SLOT").unwrap();
    let settings = planted(Planted::WrongFriction);
    let frictions: Vec<Check> =
        friction_cases(connection, &settings, 1).iter().flat_map(|case| case.audit(&settings)).collect();
    let belts = belts(&settings);
    let (springs, _) = springs();
    let first = |mut checks: Vec<&Check>| checks.swap_remove(0).clone();
    let frictions = first(frictions.iter().filter(|check| check.verdict.is_mismatch()).collect());
    let slopes = |check: &&&Check| matches!(check.failing.as_deref(), Some(Failing::Slopes(_)));
    let springs = (**wrong(&springs).iter().find(slopes).unwrap()).clone();
    let all = [frictions, first(wrong(&belts)), springs];
    let recorded: Vec<CounterExample> =
        all.iter().map(|check| CounterExample::of(check, "a test").unwrap()).collect();
    assert_eq!(
        recorded.iter().map(|of| of.kind).collect::<Vec<_>>(),
        [About::Friction, About::Belt, About::Slopes]
    );
    recorded
}

fn planted(planted: Planted) -> Settings {
    Settings { planted: Some(planted), oracles: [Oracle::WideDifferences].into(), ..Settings::default() }
}

fn has_decimals(value: &Value) -> bool {
    match value {
        Value::Number(x) => x.is_f64(),
        Value::Array(all) => all.iter().any(has_decimals),
        Value::Object(all) => all.values().any(has_decimals),
        _ => false,
    }
}

/// Written, read and judged again: the same entry with the same numbers, to the last bit; and a pass where no fault is planted.
fn fails_again(check: &Check, settings: &Settings, kind: About) {
    let example = CounterExample::of(check, "a test").unwrap_or_else(|| panic!("{check:?}"));
    let text = serde_json::to_string_pretty(&example).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["schema"], "pintle-counterexample/2");
    assert_eq!(document["kind"], serde_json::to_value(kind).unwrap());
    assert!(!has_decimals(&document["values"]), "every double is hexadecimal: {text}");
    let again = CounterExample::read(&text).unwrap();
    assert_eq!(again, example);
    let failing = again.failing().unwrap();
    let of = |settings: &Settings| -> Report { failing.audit(settings) };
    let report = of(settings);
    let same = |other: &&Check| (other.quantity, other.against) == (check.quantity, check.against);
    let found = report.subjects[0].checks.iter().find(same).unwrap();
    let [was, is] = [check, found].map(|check| check.worst.clone().unwrap());
    assert_eq!(
        (was.entry, was.got.to_bits(), was.want.to_bits()),
        (is.entry, is.got.to_bits(), is.want.to_bits())
    );
    assert_eq!(of(&Settings { planted: None, ..settings.clone() }).mismatches(), 0, "{text}");
}

#[test]
fn constraints_are_recorded() {
    let settings = planted(Planted::WrongEntry);
    let (mut kinds, mut tried) = (BTreeSet::new(), 0);
    for drawn in mpc::cases() {
        if !kinds.insert(drawn.kind) {
            continue;
        }
        let checks = judged(&drawn).audit(&settings, false);
        let wrong: Vec<&Check> = checks.iter().filter(|check| check.verdict.is_mismatch()).collect();
        let (laws, of_rows): (Vec<&Check>, Vec<&Check>) =
            wrong.into_iter().partition(|check| check.quantity.is_none());
        assert!(of_rows.len() == 1 && !laws.is_empty(), "{}", drawn.name);
        fails_again(of_rows[0], &settings, About::Mpc);
        for check in laws {
            fails_again(check, &settings, About::Mpc);
            // What was planted is not in the file: the sum is right, and so is the test that is made of it.
            let recorded = CounterExample::of(check, "a test").unwrap_or_else(|| panic!("{check:?}"));
            let sum = recorded.number().unwrap();
            assert!((sum - recorded.want.0).abs() <= recorded.tolerance.0, "{}: {sum:e}", recorded.entry);
            assert_ne!(sum.to_bits(), recorded.got.0.to_bits(), "{}", recorded.entry);
            assert!(recorded.rust().unwrap().contains("COUNTER_EXAMPLE"), "{}", recorded.entry);
            let refused = recorded.jax().unwrap_err().to_string();
            assert!(refused.starts_with("scripts and decks are of connectors"), "{refused}");
            tried += 1;
        }
    }
    assert!(kinds.len() == pintle_kinematics::mpc::MpcType::ALL.len() && tried >= kinds.len(), "{tried}");
}

#[test]
fn frictions_of_every_type_are_recorded() {
    let mut tried = 0;
    for settings in [planted(Planted::WrongFriction), planted(Planted::WrongEntry)] {
        for case in TABLE.iter().flat_map(|connection| friction_cases(connection, &settings, 2)) {
            for check in case.audit(&settings).iter().filter(|check| check.verdict.is_mismatch()) {
                fails_again(check, &settings, About::Friction);
                tried += 1;
            }
        }
    }
    assert!(tried > 20, "{tried}");
}

fn audited(scene: &Scene, states: &[State], settings: &Settings) -> Report {
    let model = Model::compile(scene).unwrap_or_else(|error| panic!("{}", error.render(100, false)));
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    audit_scenes(settings, &[Target { name: "scene", model: &model, plan: &plan, states }], &|_| {})
}

fn wrong(report: &Report) -> Vec<&Check> {
    let checks = report.subjects.iter().flat_map(|subject| &subject.checks);
    checks.filter(|check| check.verdict.is_mismatch()).collect()
}

fn belts(settings: &Settings) -> Report {
    let states: Vec<State> =
        (0..3).map(|i| pulled(1.0 + f64::from(i), 0.03, [1e-6 * f64::from(i); 2])).collect();
    audited(&belt(&format!(", STICK STIFFNESS={STIFFNESS}"), "0.06, 1.57"), &states, settings)
}

fn springs() -> (Report, Settings) {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 2., 0.3, -0.4\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nCARTESIAN, CARDAN\nO, O\n\
        *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR\n-900., -3.\n-100., -0.01\n0., 0.\n\
        150., 0.01\n800., 3.\n*CONNECTOR ELASTICITY, COMPONENT=3, NONLINEAR, INDEPENDENT COMPONENTS=POSITION\n1, 3\n\
        -30., -9., -9.\n10., 9., -9.\n70., -9., 9.\n210., 9., 9.\n*CONNECTOR DAMPING, COMPONENT=5\n3.5,\n";
    let scene =
        Scene::parse("springs.inp", deck).unwrap_or_else(|error| panic!("{}", error.render(100, false)));
    let settings = Settings { wide_states: 3, drawn_states: 3, ..planted(Planted::WrongEntry) };
    (audited(&scene, &[], &settings), settings)
}

#[test]
fn belts_and_slopes_are_recorded() {
    let settings = planted(Planted::WrongFriction);
    let report = belts(&settings);
    assert!(!wrong(&report).is_empty());
    wrong(&report).into_iter().for_each(|check| fails_again(check, &settings, About::Belt));
    let (report, settings) = springs();
    let slopes = |check: &&&Check| matches!(check.failing.as_deref(), Some(Failing::Slopes(_)));
    let found = wrong(&report);
    let check = found.iter().find(slopes).unwrap();
    fails_again(check, &settings, About::Slopes);
}

/// Through the command line: shrunk, replayed with the fault and without; other forms are refused, and so is what is no such thing.
#[test]
fn constraints_are_shrunk_and_replayed() {
    let folder = folder("counter-examples-of-constraints");
    let path = folder.to_str().unwrap();
    let brief = ["--wide-states", "1", "--oracles", "wide-differences", "--plant", "wrong-entry"];
    let scenes = ["audit", "gallery:revolute_mpc", "--counter-examples", path];
    let found = pintle(&[&scenes[..], &brief].concat()).assert().code(1);
    assert!(!stderr(&found).contains("no counter-example"), "{}", stderr(&found));
    let file = folder.join("mpc-pin-10-20-0.json");
    let text = fs::read_to_string(&file)
        .unwrap_or_else(|_| panic!("{:?}", fs::read_dir(&folder).unwrap().collect::<Vec<_>>()));
    let name = file.to_str().unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&document["kind"], &document["version"]), (&"mpc".into(), &pintle::VERSION.into()));
    // Shrunk: the derivative of a PIN needs no velocity.
    let velocity = document["values"]["state"]["velocity"].as_array().unwrap();
    assert!(velocity.iter().all(|x| x == "0x0p+0"), "{velocity:?}");
    let fails = pintle(&["replay", name, "--plant", "wrong-entry"]).assert().code(1);
    let page = stdout(&fails);
    assert!(
        page.contains("MPC PIN by MPC PIN 10-20") && page.contains("  given -0x1.000010c6f7a0bp+0"),
        "{page}"
    );
    let passes = pintle(&["replay", name]).assert().code(0);
    assert!(stdout(&passes).trim_end().ends_with("no mismatch"), "{}", stdout(&passes));
    let exported = folder.join("pin.rs");
    let exported = exported.to_str().unwrap();
    pintle(&["replay", name, "--export", "rust", "-o", exported]).assert().code(0);
    let test = fs::read_to_string(exported).unwrap();
    assert!(test.contains("COUNTER_EXAMPLE") && test.contains(".number().unwrap()"), "{test}");
    for form in ["jax", "inp"] {
        let refused = pintle(&["replay", name, "--export", form, "-o", exported]).assert().code(6);
        assert!(stderr(&refused).contains("this is of a multi-point constraint"), "{}", stderr(&refused));
    }
    for (from, to, says) in [
        (
            "\"mpc\"",
            "\"beam\"",
            "unknown variant `beam`, expected one of `connector`, `mpc`, `relation`, `friction`, `belt`, `slopes`",
        ),
        ("\"mpc\"", "\"belt\"", "they make no belt around a ring: unknown field"),
        ("\"length\": \"0x", "\"length\": \"0y", "they make no multi-point constraint: invalid type: string"),
        ("\"length\": \"0x", "\"length\": \"0xz", "is no number"),
        ("\"length\": ", "\"breadth\": ", "they make no multi-point constraint: unknown field `breadth`"),
        ("counterexample/2", "counterexample/7", "schema \"pintle-counterexample/7\""),
    ] {
        assert!(text.contains(from), "{from}");
        let file = crate::commands::cli::file("refused.json", &text.replace(from, to));
        let refused = pintle(&["replay", &file]).assert().code(6);
        assert!(stderr(&refused).contains(says), "{from} {to}: {}", stderr(&refused));
    }
}
