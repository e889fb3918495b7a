//! Forces of a file are read with the states: their order, their form and the states that have none change nothing.

use crate::commands::cli::{file, pintle, stderr, stdout};
use std::fmt::Write;

const STATES: usize = 6;

/// A WELD, and its forces at every state but the third.
fn force(state: usize) -> Option<[f64; 6]> {
    let at = state as f64;
    (state != 2).then_some([1.5 + at, -2.25, 0.125 * at, 0.75, -at, 3.0])
}

fn table(order: impl Iterator<Item = usize>) -> String {
    let mut text = "state,element,f1,f2,f3,m1,m2,m3\n".to_string();
    for state in order {
        let Some([f1, f2, f3, m1, m2, m3]) = force(state) else { continue };
        writeln!(text, "{state},7,{f1},{f2},{f3},{m1},{m2},{m3}").unwrap();
    }
    text
}

fn document() -> String {
    let of = |state: usize| {
        let [f1, f2, f3, m1, m2, m3] = force(state)?;
        Some(format!(
            "{{\"state\": {state}, \"forces\": {{\"7\": {{\"f1\": {f1}, \"f2\": {f2}, \"f3\": {f3}, \"m1\": {m1}, \"m2\": {m2}, \"m3\": {m3}}}}}}}"
        ))
    };
    let states: Vec<String> = (0..STATES).filter_map(of).collect();
    format!("{{\"schema\": \"pintle-forces/1\", \"states\": [{}]}}", states.join(", "))
}

/// The deck and its states, of a test of this name: tests run side by side.
fn scene(test: &str) -> [String; 2] {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 2., 0.5, 0.\n*ORIENTATION, NAME=O\n0.6, 0.8, 0., -0.8, 0.6, 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nWELD\nO,\n";
    let mut states = "state,time,node,u1,ur1,ur2\n".to_string();
    for state in 0..STATES {
        let at = 0.25 * state as f64;
        writeln!(states, "{state},{at},2,{at},{at},0.125").unwrap();
    }
    [file(&format!("{test}.inp"), deck), file(&format!("{test}-states.csv"), &states)]
}

#[test]
fn the_order_of_forces_changes_nothing() {
    let [deck, states] = scene("streamed-forces-1");
    let run = |name: &str, text: &str| {
        let forces = file(name, text);
        let of = ["--forces", &forces, "--outputs", "CTF,NF,DNF", "--format", "csv"];
        stdout(&pintle(&[&["eval", &deck, "--states", &states][..], &of].concat()).assert().success())
    };
    let in_order = run("forces-in-order.csv", &table(0..STATES));
    assert_eq!(in_order, run("forces-backwards.csv", &table((0..STATES).rev())));
    assert_eq!(in_order, run("forces-of-states.json", &document()));
    // Forces belong to the states that have them.
    for state in 0..STATES {
        let line = |text: &&str| {
            let cells: Vec<&str> = text.split(',').collect();
            cells[1] == state.to_string() && cells[7] == "u1"
        };
        let found = in_order.lines().find(line).map(|line| line.split(',').nth(11).unwrap().to_string());
        let want = force(state).map(|[f1, ..]| format!("{f1:?}")).unwrap_or_default();
        assert_eq!(found.unwrap_or_default(), want, "state {state}");
    }
}

/// What is wrong with the last of them is said before anything is written, with its line.
#[test]
fn wrong_forces_are_refused_before_the_first_state() {
    let [deck, states] = scene("streamed-forces-2");
    for (name, row, part) in [
        ("unknown", "5,8,1,1,1,1,1,1\n", "there is no connector element 8"),
        ("twice", "4,7,1,1,1,1,1,1\n", "element 7 occurs twice in one state"),
        ("beyond", "6,7,1,1,1,1,1,1\n", "forces of state 6: the states are 0 to 5"),
    ] {
        let text = table(0..STATES - 1) + if name == "twice" { "5,7,1,1,1,1,1,1\n" } else { "" } + row;
        let forces = file(&format!("forces-{name}.csv"), &text);
        let of = ["eval", &deck, "--states", &states, "--forces", &forces, "--outputs", "NF"];
        let assert = pintle(&of).assert().code(6).stdout("");
        let told = stderr(&assert);
        let line = text.lines().count();
        assert!(told.contains(part) && told.contains(&format!("forces-{name}.csv:{line}")), "{told}");
    }
}
