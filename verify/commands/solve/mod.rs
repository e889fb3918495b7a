//! `pintle solve`: events with their digits, states that `eval` reads, a motion that goes on, refusals by name.

mod kept;
mod references;

use crate::commands::cli::{folder, pintle, stderr, stdout};
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

/// States of a retractor have the flow of its belt, as a table and as arrays: its constraints hold where they are evaluated.
#[test]
fn states_have_the_material_flow() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("solve_flow");
    fs::create_dir_all(&folder).unwrap();
    let deck = "references/retractor_drum/deck.inp";
    let mut compared = 0;
    for name in ["run.csv", "run.json", "run.npz"] {
        let path = folder.join(name);
        let path = path.to_str().unwrap();
        pintle(&["--force", "solve", deck, "--every", "0.2", "-o", path]).assert().success();
        let mut done = pintle(&["eval", deck, "--states", path, "--outputs", "RES", "--format", "csv"]);
        let told = stdout(&done.assert().success());
        let mut lines = told.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let at = lines.next().unwrap().iter().position(|cell| *cell == "RES").unwrap();
        for residual in lines.filter_map(|cells| cells.get(at)?.parse::<f64>().ok()) {
            assert!(residual.abs() < 1e-12, "{name}: {residual}");
            compared += 1;
        }
    }
    assert!(compared >= 30, "{compared}");
}

#[test]
fn what_is_not_solved_is_refused_by_name() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("solve_0");
    fs::create_dir_all(&folder).unwrap();
    // Two rails between the same nodes, which press nobody knows how.
    let rails = folder.join("rails.inp");
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=RAIL\n101, 1, 2\n102, 1, 2\n\
                *ORIENTATION, NAME=ALONG\n1., 0., 0., 0., 1., 0.\n*CONNECTOR SECTION, ELSET=RAIL, BEHAVIOR=DRY\nTRANSLATOR,\nALONG,\n\
                *CONNECTOR BEHAVIOR, NAME=DRY\n*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n*CONNECTOR FRICTION, PREDEFINED\n.5, .2\n*FRICTION\n0.25\n\
                *BOUNDARY\n1, 1, 6\n*STEP\n*STATIC\n0.01, 2.\n*CLOAD\n2, 2, -20.\n*END STEP\n";
    fs::write(&rails, deck).unwrap();
    for (scene, words) in [
        ("gallery:seat_belt", "RETRACTOR 102 ur3: a velocity or acceleration is prescribed in a static step"),
        (rails.to_str().unwrap(), "constraints repeat each other"),
    ] {
        let done = pintle(&["solve", scene]).assert().code(6);
        let told = stderr(&done);
        assert!(told.contains(words) && told.contains("help"), "{told}");
    }
    // A crank that is turned moves the slide: what would hold it in stick repeats nothing.
    let done = pintle(&["solve", "gallery:slider_crank"]).assert().code(0);
    assert!(stdout(&done).contains("TRANSLATOR 106 u1  reverses"), "{}", stdout(&done));
}

const SPRING: &str = "\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=C
10, 1, 2
*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B
AXIAL
*CONNECTOR BEHAVIOR, NAME=B
*CONNECTOR ELASTICITY, COMPONENT=1
3.
";

const PULLED: &str = "\
*BOUNDARY
1, 1, 3
2, 2, 3
*STEP
*STATIC
1., 1.
*CLOAD
2, 1, 6.
*END STEP
*STEP
*STATIC
1., 1.
*CLOAD
2, 1, 3.
*END STEP
";

/// What would be the solution of another mechanism is none.
#[test]
fn what_is_left_out_is_refused_by_name() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("solve_1");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("deck.inp");
    for (more, words) in [
        (
            "*CONNECTOR PLASTICITY, COMPONENT=1\n*CONNECTOR HARDENING\n5., 0.\n6., 1.\n",
            "AXIAL 10: plasticity",
        ),
        (
            "*CONNECTOR UNIAXIAL BEHAVIOR, COMPONENT=1\n*LOADING DATA, DIRECTION=TENSION\n0., 0.\n10., 1.\n",
            "a uniaxial behaviour acts on u1",
        ),
        ("*ELEMENT, TYPE=T3D2, ELSET=T\n11, 1, 2\n", "elements of type T3D2 act on nodes of its connectors"),
        (
            "*DISTRIBUTING COUPLING, ELSET=C\n2, 1.\n",
            "*DISTRIBUTING COUPLING: nodes are constrained by what is not read",
        ),
        ("*MPC\nSS LINEAR, 2, 3\n", "MPC SS LINEAR: nodes are constrained by what is not read"),
    ] {
        fs::write(&path, format!("{SPRING}{more}{PULLED}")).unwrap();
        let done = pintle(&["solve", path.to_str().unwrap()]).assert().code(6);
        let told = stderr(&done);
        assert!(told.contains(words) && told.contains("help"), "{words}: {told}");
    }
}

/// A load of exactly μ F_N: stick and slip both fit, which is said.
#[test]
fn a_tie_is_told() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("solve_2");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("deck.inp");
    let deck = fs::read_to_string("references/self_locking/deck.inp").unwrap();
    let exact = deck.replace("0., 0., 2., 1., 3., 1.", "0., 1., 3., 1.").replace("2, 1, 4.9", "2, 1, 5.");
    assert_ne!(exact, deck);
    fs::write(&path, exact).unwrap();
    let done = pintle(&["solve", path.to_str().unwrap()]).assert().success();
    assert!(stdout(&done).contains("tie"), "{}", stdout(&done));
}

/// Nodes that only AXIAL connectors hold do not turn; a run ends with a step, and supports pull as hard as the load.
#[test]
fn a_spring_alone_is_pulled_step_by_step() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("solve_3");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("deck.inp");
    fs::write(&path, format!("{SPRING}{PULLED}")).unwrap();
    for (step, time, force) in [("1", 1.0, 6.0), ("2", 2.0, 3.0)] {
        let done =
            pintle(&["solve", path.to_str().unwrap(), "--step", step, "--format", "json"]).assert().success();
        let found: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
        let last = found["frames"].as_array().unwrap().last().unwrap();
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        assert_eq!(number(&last["time"]), time);
        assert!((number(&last["connectors"]["10"]["CU"][0]) - force / 3.0).abs() < 1e-14, "{last}");
        assert!((number(&last["nodes"]["1"]["RF"][0]) + force).abs() < 1e-13, "{last}");
        assert!(last["nodes"]["2"]["RF"][0].is_null() && last["nodes"]["1"]["RM"][0].is_null(), "{last}");
    }
    let done = pintle(&["solve", path.to_str().unwrap(), "--step", "3"]).assert().failure();
    assert!(stderr(&done).contains("step"), "{}", stderr(&done));
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
    let done = pintle(&["solve", "gallery:drawer", "--stick", "elastic"]).assert().success();
    assert!(stdout(&done).contains("rigid stick differs by"), "{}", stdout(&done));
    let done = pintle(&["solve", "gallery:no_such_thing"]).assert().failure();
    assert!(stderr(&done).contains("no_such_thing"), "{}", stderr(&done));
}

/// A directory stands for its one deck, by whichever path; that of a reference is the reference.
#[test]
fn a_directory_stands_for_its_deck() {
    let whole = Path::new(env!("CARGO_MANIFEST_DIR")).join("references/drawer");
    let whole = whole.to_str().unwrap();
    let by_name = stdout(&pintle(&["solve", "references/drawer"]).assert().success());
    let at = |path: &str| {
        let mut command = pintle(&["solve", path]);
        stdout(&command.current_dir(env!("CARGO_MANIFEST_DIR")).assert().success())
    };
    for path in [whole, "./references/drawer", "./references/../references/drawer/"] {
        assert_eq!(at(path), by_name, "{path}");
    }
    // A deck that is another one is solved as it is.
    let mine = folder("solve-directory").join("drawer");
    fs::create_dir_all(&mine).unwrap();
    let deck = fs::read_to_string(Path::new(whole).join("deck.inp")).unwrap();
    fs::write(mine.join("deck.inp"), format!("** mine\n{deck}")).unwrap();
    let found = at(mine.to_str().unwrap());
    let (title, rest) = found.split_once('\n').unwrap();
    assert!(title.contains("deck.inp: solved from 0 to 4"), "{title}");
    assert_eq!(Some(rest), by_name.split_once('\n').map(|(_, rest)| rest));
    // Other commands take it, too.
    let page = stdout(&pintle(&["audit", whole, "--model-only"]).assert().success());
    assert!(page.contains("Rank"), "{page}");
}
