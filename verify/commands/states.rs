//! `pintle states`: what it writes is read back, and evaluates to what the library says there.

use crate::commands::cli::{pintle, stderr, stdout};
use pintle_audit::{Candidate, Settings};
use pintle_kinematics::catalog::TABLE;

/// Of every type the deck and the states are read without a warning, state by state, and along a history; the numbers of one of
/// both are those of the other at the first state.
#[test]
fn states_of_every_type_are_read_back() {
    let folder = crate::commands::cli::folder("states");
    let [deck, csv, json] = ["one.inp", "one.csv", "one.json"].map(|name| folder.join(name));
    let [deck, csv, json] = [&deck, &csv, &json].map(|path| path.to_str().unwrap());
    let mut rows = 0;
    for connection in TABLE.iter() {
        let name = connection.name.as_ref();
        pintle(&["--force", "states", name, "--count", "9", "--near", "3", "--deck", deck, "-o", csv])
            .assert()
            .success();
        pintle(&["--force", "states", name, "--count", "9", "--near", "3", "--format", "json", "-o", json])
            .assert()
            .success();
        let read = |states: &str| {
            let arguments = [
                "eval",
                deck,
                "--states",
                states,
                "--independent",
                "--outputs",
                "CU,RES,CV,CA",
                "--format",
                "csv",
            ];
            let done = pintle(&arguments).assert().success();
            let told = stderr(&done);
            assert!(!told.contains('⚠'), "{name}: {told}");
            stdout(&done)
        };
        let table = read(csv);
        assert_eq!(table, read(json), "{name}");
        assert!(table.contains(",0,") && !table.contains("NaN"), "{name}: {table}");
        rows += table.lines().count();
    }
    assert!(rows > 31 * 9, "{rows}");
}

/// `--near` without a number asks for 50 states, each of two nodes.
#[test]
fn near_needs_no_number() {
    let table = |near: &[&str]| {
        stdout(&pintle(&[&["states", "REVOLUTE", "--count", "9"], near].concat()).assert().success())
    };
    let [plain, some, default] = [table(&[]), table(&["--near", "50"]), table(&["--near"])];
    assert_eq!(some, default);
    assert_eq!(some.lines().count() - plain.lines().count(), 2 * 50);
}

/// An angle goes on along a history, and not from one independent state to the next.
#[test]
fn histories_go_on_and_independent_states_do_not() {
    let folder = crate::commands::cli::folder("histories");
    let [deck, csv] = ["hinge.inp", "hinge.csv"].map(|name| folder.join(name));
    let [deck, csv] = [&deck, &csv].map(|path| path.to_str().unwrap());
    pintle(&["--force", "states", "HINGE", "--count", "60", "--history", "--deck", deck, "-o", csv])
        .assert()
        .success();
    let last = |independent: &[&str]| -> f64 {
        let arguments = [
            &["eval", deck, "--states", csv, "--outputs", "CU", "--format", "csv", "--show", "last"],
            independent,
        ]
        .concat();
        let table = stdout(&pintle(&arguments).assert().success());
        let line = table.lines().find(|line| line.contains(",ur1,")).unwrap();
        line.rsplit(',').next().unwrap().parse().unwrap()
    };
    let (along, alone) = (last(&[]), last(&["--independent"]));
    assert!((along.abs() - 21.0).abs() < 1e-9, "{along}");
    let turns = (along - alone) / std::f64::consts::TAU;
    assert!(
        alone.abs() <= std::f64::consts::PI && (turns - turns.round()).abs() < 1e-9 && turns.round() != 0.0,
        "{alone}"
    );
}

/// The states are those at which a check asks, special values among them.
#[test]
fn states_are_those_of_a_check() {
    let definition = crate::audit::at_rest("CARDAN");
    let settings = Settings { states: 30, near_singular_states: 5, wide_states: 0, ..Settings::default() };
    let candidate = Candidate::new("CARDAN", &definition).settings(settings);
    let mut asked = 0;
    let drawn = candidate.drawn();
    let Ok(_) = candidate.try_check(|questions| {
        for question in questions.iter().filter(|question| question.is_drawn) {
            let end = drawn[asked].last().unwrap();
            assert_eq!(format!("{:?}", end.state), format!("{:?}", question.state()));
            asked += 1;
        }
        Ok::<_, std::convert::Infallible>(questions.iter().map(|_| None).collect())
    });
    assert_eq!((asked, drawn.len()), (35, 35));
    assert!(drawn.iter().any(|case| case.name.contains("special")));
}
