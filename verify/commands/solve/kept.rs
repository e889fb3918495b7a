//! Runs that are killed go on, to the same digits; arrays and pages are written.

use crate::commands::cli::{pintle, stderr, stdout};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("solve").join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Killed in the middle, twice, a run on 237 bits goes on from what it kept to the same document as one that was left alone. What it kept
/// is whole after each kill.
#[test]
fn a_run_that_is_killed_goes_on_to_the_same_digits() {
    let kept = folder("killed").join("block.run");
    let kept = kept.to_str().unwrap();
    _ = fs::remove_file(kept);
    let asked = ["references/limit_cycle", "--digits", "24", "--every", "0.5", "--format", "json"];
    let whole = stdout(&pintle(&[&["solve"], &asked[..]].concat()).assert().success());
    let mut option = "--keep";
    let mut sizes = Vec::new();
    for _ in 0..2 {
        let before = fs::read(kept).ok();
        let mut child = Command::new(env!("CARGO_BIN_EXE_pintle"))
            .arg("solve")
            .args(asked)
            .args([option, kept])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // Until it has kept something new, and a little longer, into the next writing.
        let begin = Instant::now();
        while fs::read(kept).ok() == before && begin.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(40));
        assert!(
            child.try_wait().unwrap().is_none(),
            "it ended before it could be killed: ask for more digits"
        );
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(output.stdout.is_empty(), "results are printed at the end");
        let text = fs::read_to_string(kept).unwrap();
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        sizes.push(document["methods"][0]["frames"].as_array().map_or(0, Vec::len));
        option = "--resume";
    }
    let done = pintle(&[&["solve"], &asked[..], &["--resume", kept]].concat()).assert().success();
    assert_eq!(stdout(&done), whole, "not the same digits");
    println!("killed with {sizes:?} frames kept, {} bytes compared", whole.len());
    assert!(sizes[1] >= sizes[0]);
    // At its end it is kept, too, and goes on at once.
    let begin = Instant::now();
    let done = pintle(&[&["solve"], &asked[..], &["--resume", kept]].concat()).assert().success();
    assert_eq!(stdout(&done), whole);
    assert!(begin.elapsed() < Duration::from_secs(5));
    // Not of other options, and not over another's file.
    let other =
        pintle(&["solve", "references/limit_cycle", "--digits", "30", "--resume", kept]).assert().code(6);
    assert!(stderr(&other).contains("other options"), "{}", stderr(&other));
    let other = pintle(&["solve", "references/block", "--keep", kept]).assert().code(7);
    assert!(stderr(&other).contains("not overwritten"), "{}", stderr(&other));
}

/// The same on doubles, within and between the steps of a scene, static ones too: each state that was kept goes on to the same bits.
#[test]
fn every_kept_state_goes_on_to_the_same_bits() {
    use pintle_scene::Scene;
    use pintle_solve::{Keeping, Kept, Method, Options, REFERENCES, Solution, Stick, solve, solve_keeping};
    let deck = |name: &str| REFERENCES.iter().find(|(known, _)| *known == name).unwrap().1.to_string();
    let two_steps = deck("stop_friction")
        .replace("NAME=FALLS", "NAME=FALLS, TIME=TOTAL TIME")
        .replace("0.01, 4.", "0.01, 1.")
        .replace("*END STEP", "*END STEP\n*STEP\n*DYNAMIC\n0.01, 3.\n*END STEP");
    let elastic = deck("drawer").replace("PREDEFINED", "PREDEFINED, STICK STIFFNESS=20000.");
    let decks = [
        (deck("slider_crank"), Stick::Rigid),
        (deck("spherical_pendulum"), Stick::Rigid),
        (deck("static_drawer"), Stick::Rigid),
        (deck("failure"), Stick::Rigid),
        (two_steps, Stick::Rigid),
        (elastic, Stick::Elastic),
    ];
    let told =
        |solution: &Solution<f64>| format!("{:?} {:?} {}", solution.frames, solution.events, solution.steps);
    let mut compared = 0;
    for (deck, stick) in decks {
        let scene = Scene::parse("deck.inp", &deck).unwrap();
        for method in [Method::Extrapolation, Method::Collocation] {
            let times = if deck.contains("*STATIC") { Vec::new() } else { vec![0.1, 0.25, 0.7, 1.0, 1.3] };
            let options = Options { method, stick, times, ..Options::default() };
            let whole = told(&solve(&scene, &options).unwrap());
            let mut kept: Vec<String> = Vec::new();
            let take = |of: Kept<f64>| kept.push(serde_json::to_string(&of).unwrap());
            let same: Solution<f64> =
                solve_keeping(&scene, &options, None, Some(Keeping::new(Duration::ZERO, take))).unwrap();
            assert_eq!(told(&same), whole, "keeping changes the run");
            // Some ten of them.
            let every = kept.len().div_ceil(10);
            for text in kept.iter().step_by(every).chain(kept.last()) {
                let from: Kept<f64> = serde_json::from_str(text).unwrap();
                let rest: Solution<f64> = solve_keeping(&scene, &options, Some(from), None).unwrap();
                assert!(told(&rest) == whole, "{method:?}: it goes another way after {} bytes", text.len());
                compared += 1;
            }
        }
    }
    println!("{compared} runs that went on");
    assert!(compared > 50, "{compared}");
}

/// Arrays for NumPy: their heads, and the end of the numbers.
#[test]
fn arrays_are_written_for_numpy() {
    let path = folder("arrays").join("run.npz");
    pintle(&["solve", "references/block", "--every", "0.5", "-o", path.to_str().unwrap()]).assert().success();
    let bytes = fs::read(&path).unwrap();
    let archive = rawzip::ZipArchive::from_slice(&bytes).unwrap();
    let files: BTreeMap<String, &[u8]> = archive
        .entries()
        .map(|entry| {
            let entry = entry.unwrap();
            let name = String::from_utf8(entry.file_path().as_ref().to_vec()).unwrap();
            (name, archive.get_entry(entry.wayfinder()).unwrap().data())
        })
        .collect();
    let read = |name: &str| {
        let bytes = files[name];
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        (String::from_utf8(bytes[10..10 + length].to_vec()).unwrap(), bytes[10 + length..].to_vec())
    };
    let (head, body) = read("CU.npy");
    assert!(head.contains("'descr': '<f8'") && head.contains("'shape': (10, 1, 6, )"), "{head}");
    let last: Vec<f64> =
        body.chunks(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).skip(54).collect();
    assert!((last[0] - 0.206_933_032_589_514_2).abs() < 1e-13, "{last:?}");
    let (head, body) = read("event.npy");
    assert!(head.contains("<U8") && body.len() == 3 * 8 * 4, "{head}");
    assert_eq!(char::from(body[0]), 's');
    assert_eq!(files.len(), 21);
}

/// The page has a path of each node that moves, shaded stick, and as many frames as points; it loads nothing.
#[test]
fn the_page_shows_motion_forces_and_energies() {
    let path = folder("page").join("drawer.html");
    pintle(&["solve", "references/drawer", "--html", path.to_str().unwrap()]).assert().success();
    let text = fs::read_to_string(&path).unwrap();
    for word in
        ["id=\"motion\"", "id=\"forces\"", "id=\"energies\"", "class=\"stuck\"", "class=\"trace\"", "CSF u1"]
    {
        assert!(text.contains(word), "{word}");
    }
    assert!(
        !text.contains("http://")
            || text.matches("http://").count() == text.matches("http://www.w3.org/2000/svg").count()
    );
    let data = text.split_once("id=\"frames\">").unwrap().1.split_once("</script>").unwrap().0;
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let count = data["times"].as_array().unwrap().len();
    assert_eq!(count, 246, "240 intervals and 5 events");
    for of in ["points", "sticks"] {
        assert_eq!(data[of].as_array().unwrap().len(), count);
    }
    let stuck = data["sticks"].as_array().unwrap().iter().filter(|all| !all.as_array().unwrap().is_empty());
    assert!(stuck.count() >= 5);
}
