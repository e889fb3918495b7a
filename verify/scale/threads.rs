//! What is written does not depend on the number of threads, to the last byte.

use super::chain;
use crate::commands::cli::{file, pintle};
use pintle_kinematics::connector::Request;
use pintle_model::evaluate::{Fixed, Jacobian, Plan, Selection, Sequence};
use pintle_scene::StateFile;
use std::fmt::Write;
use std::fs;

const THREADS: [u16; 4] = [1, 2, 3, 7];

/// Connectors with springs and friction from every node to the one after the next, and constraints of kinds in turn.
fn laden(connectors: usize) -> String {
    let mut text = String::from("*ELEMENT, TYPE=CONN3D2, ELSET=LADEN\n");
    for node in 1..connectors {
        writeln!(text, "{}, {node}, {}", 20_000_000 + node, node + 2).unwrap();
    }
    text.push_str(
        "*CONNECTOR SECTION, ELSET=LADEN, BEHAVIOR=B\nCARTESIAN, CARDAN\nA,\n*CONNECTOR BEHAVIOR, NAME=B\n\
         *CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR FRICTION, COMPONENT=1\n, 5.\n*FRICTION\n0.1\n*MPC\n",
    );
    for node in 1..connectors {
        writeln!(text, "{}, {}, {node}", ["BEAM", "TIE", "PIN", "LINK"][node % 4], node + 2).unwrap();
    }
    text
}

/// The files of a chain and its history, with what loads it where `rest` says so, and their names.
fn files(name: &str, connectors: usize, states: u64, rest: &str) -> [String; 2] {
    let deck = chain::deck(connectors, &chain::types(), rest);
    let states = (0..states).map(|number| chain::state(number, connectors + 1)).collect();
    let states = StateFile { states }.to_json().unwrap();
    [file(&format!("{name}.inp"), &deck), file(&format!("{name}.json"), &states)]
}

/// What a run writes: to its streams, and to files of the Jacobian and of the branches.
fn written(arguments: &[&str], threads: Option<u16>, name: &str) -> [Vec<u8>; 4] {
    let count = threads.map(|count| count.to_string());
    let [jacobian, branches] = ["mtx", "branches"].map(|ending| file(&format!("{name}.{ending}"), ""));
    let mut command = pintle(arguments);
    command.args(["--jacobian", &jacobian, "--save-branches", &branches, "--force"]);
    if let Some(count) = &count {
        command.args(["--threads", count]);
    }
    command.env("RAYON_NUM_THREADS", "5");
    let output = command.assert().success().get_output().clone();
    [output.stdout, output.stderr, fs::read(jacobian).unwrap(), fs::read(branches).unwrap()]
}

fn assert_same(arguments: &[&str], name: &str) {
    let one = written(arguments, Some(1), name);
    assert!(one.iter().all(|text| text.len() > 100), "{arguments:?}: {:?}", one.each_ref().map(Vec::len));
    for threads in THREADS.into_iter().map(Some).chain([None]) {
        let many = written(arguments, threads, name);
        for (what, (one, many)) in
            ["stdout", "stderr", "Jacobian", "branches"].iter().zip(one.iter().zip(&many))
        {
            assert!(one == many, "{arguments:?}: {what} differs with {threads:?} threads");
        }
    }
}

/// Everything of connectors of every type, in every format; then more connectors than are held at a time.
#[test]
fn threads_change_no_byte() {
    let [deck, states] = files("threads", 3 * chain::types().len(), 3, "");
    for format in ["human", "json", "csv"] {
        let all =
            ["eval", &deck, "--states", &states, "--format", format, "--outputs", "ALL", "--order", "2"];
        assert_same(&all, &format!("threads-{format}"));
    }
    let [deck, states] = files("many-threads", 2600, 2, "");
    assert_same(&["eval", &deck, "--states", &states, "--format", "csv", "--order", "1"], "many-threads");
    // More constraints, springs and frictions than are taken at a time.
    let [deck, states] = files("laden-threads", 1200, 3, &laden(1200));
    let forces = [
        "eval",
        &deck,
        "--states",
        &states,
        "--format",
        "json",
        "--outputs",
        "CU,RES,CEF,CSF,CTF",
        "--order",
        "1",
    ];
    assert_same(&forces, "laden-threads");
}

/// Entries, and what needs care, of more connectors and constraints than a thread works on at a time.
#[test]
fn threads_change_no_entry() {
    const CONNECTORS: usize = 2600;
    let (_, model) = super::model(CONNECTORS, &laden(CONNECTORS));
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::none());
    let filled = || {
        let mut by_rows = Sequence::new(&model, &plan);
        let (mut values, mut all) = (Vec::new(), Vec::new());
        for number in [1, 2] {
            let state = chain::state(number, CONNECTORS + 1);
            // What was there before is no number, and nothing of it is left.
            values.fill(f64::NAN);
            let care = by_rows.assemble(&state, &jacobian, &mut values).unwrap();
            let bits: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
            assert!(values.iter().all(|value| value.is_finite()));
            all.push((care, bits, by_rows.tally()));
        }
        all
    };
    let pools = [1, 2, 3, 7].map(|count| rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap());
    let [one, others @ ..] = pools.map(|pool| pool.install(filled));
    assert!(one.iter().all(|(_, bits, _)| bits.len() > 10 * CONNECTORS));
    assert!(others.iter().all(|many| *many == one));
}

/// A number of threads that there cannot be.
#[test]
fn no_threads_are_refused() {
    pintle(&["eval", "--threads", "0"]).assert().code(2);
}
