//! `pintle solve`: events with their digits, states that `eval` reads, a motion that goes on, refusals by name.

mod kept;
mod references;

use crate::commands::cli::{pintle, stderr, stdout};
use std::fs;
use std::path::Path;

/// The events of the block in closed form: slip at 0.05, a turn, rest. Its states evaluate to what was solved, and go on from a state
/// in the middle to the same rest.
#[test]
fn a_block_is_solved_read_back_and_continued() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("solve");
    fs::create_dir_all(&folder).unwrap();
    let deck = "references/block/deck.inp";
    let [whole, half] = ["whole.csv", "half.csv"].map(|name| folder.join(name));
    let [whole, half] = [&whole, &half].map(|path| path.to_str().unwrap());
    let done = pintle(&["--force", "solve", deck, "--every", "0.5", "-o", whole]).assert().success();
    let told = stdout(&done);
    for expected in ["4.99999999", "slips", "5.692882938", "reverses", "1.013576587", "sticks", "2.06933032"]
    {
        assert!(
            told.contains(expected) || expected.starts_with("4.99") && told.contains("5.00000000"),
            "{told}"
        );
    }
    let last = |states: &str| {
        let done = pintle(&["eval", deck, "--states", states, "--outputs", "CU", "--format", "csv"])
            .assert()
            .success();
        assert!(!stderr(&done).contains("error"), "{}", stderr(&done));
        stdout(&done).lines().rfind(|line| line.contains("u1")).unwrap().to_string()
    };
    assert!(last(whole).contains("0.20693303258"), "{}", last(whole));
    pintle(&["--force", "solve", deck, "--until", "0.3", "-o", half]).assert().success();
    let done = pintle(&["solve", deck, "--from", half, "--format", "json"]).assert().success();
    let found: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    assert_eq!(found["schema"], "pintle-solution/1");
    let frames = found["frames"].as_array().unwrap();
    let rest = frames.last().unwrap()["connectors"]["101"]["CU"][0].as_f64().unwrap();
    assert!((rest - 0.206_933_032_589_514_2).abs() < 1e-13, "{rest}");
}

#[test]
fn what_is_not_solved_is_refused_by_name() {
    for (scene, words) in [
        ("gallery:seat_belt", "RETRACTOR 102 ur3: a velocity or acceleration is prescribed in a static step"),
        ("gallery:slider_crank", "constraints repeat each other"),
    ] {
        let done = pintle(&["solve", scene]).assert().code(6);
        let told = stderr(&done);
        assert!(told.contains(words) && told.contains("help"), "{told}");
    }
}

/// A pendulum that falls on a hinge has the energy that its weight gave.
#[test]
fn the_pendulum_of_the_gallery_keeps_its_energy() {
    let done = pintle(&["solve", "gallery:hinge_pendulum"]).assert().success();
    let told = stdout(&done);
    let energies = told.lines().find(|line| line.starts_with("energies")).unwrap();
    let number = |key: &str| -> f64 {
        let after = energies.split_once(key).unwrap().1.trim();
        after.split([',', ';']).next().unwrap().parse().unwrap()
    };
    let [kinetic, work] = ["kinetic", "external work"].map(number);
    assert!((kinetic - work).abs() < 1e-11 * kinetic && kinetic > 19.0, "{energies}");
}

/// The decks of references/ by their names, those of the gallery before them; elastic stick is asked for.
#[test]
fn references_are_solved_by_name() {
    let done = pintle(&["solve", "gallery:drawer"]).assert().success();
    let told = stdout(&done);
    assert!(told.contains("TRANSLATOR 101") && told.contains("reverses") && told.contains("CSF"), "{told}");
    let done = pintle(&["solve", "gallery:stop_friction", "--format", "json"]).assert().success();
    let found: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    let kinds: Vec<&str> =
        found["events"].as_array().unwrap().iter().map(|event| event["event"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["closes", "sticks", "opens", "slips"]);
    pintle(&["solve", "gallery:drawer", "--stick", "elastic"]).assert().success();
    let done = pintle(&["solve", "gallery:no_such_thing"]).assert().failure();
    assert!(stderr(&done).contains("no_such_thing"), "{}", stderr(&done));
}
