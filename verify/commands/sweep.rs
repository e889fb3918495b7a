//! `pintle sweep`: one digest, whoever computes what, and whoever is killed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

fn pintle(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pintle"));
    command.args(words).env("NO_COLOR", "1").env_remove("COLUMNS");
    command
}

fn run(words: &[&str]) -> Output {
    pintle(words).output().expect("it runs")
}

/// The lines of a table that begin with a word.
fn line(output: &Output, word: &str) -> String {
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let found = text.lines().find(|line| line.starts_with(word));
    found
        .unwrap_or_else(|| panic!("no {word} in {text}{}", String::from_utf8_lossy(&output.stderr)))
        .to_string()
}

fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("pintle-sweep-{name}-{}", std::process::id()));
    _ = fs::remove_dir_all(&path);
    path
}

fn chunks(path: &Path) -> usize {
    let names = fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names.filter(|name| name.to_string_lossy().starts_with("chunk-")).count()
}

const STATES: &str = "60000";
const SHARE: [&str; 2] = ["--oracle-share", "0.002"];

fn of(out: &str, more: &[&str]) -> Vec<String> {
    let words = ["sweep", "--states", STATES, "--chunk", "4000", "--out", out];
    words.into_iter().chain(SHARE).chain(more.iter().copied()).map(String::from).collect()
}

fn kill(child: &mut Child) {
    // SIGKILL, which no program can handle.
    child.kill().expect("it can be killed");
    child.wait().expect("it has ended");
}

/// One run, one thread, parts in any order, and a run that is killed again and again: one digest.
#[test]
fn a_sweep_has_one_digest_whoever_is_killed() {
    let whole = run(&["sweep", "--states", STATES, SHARE[0], SHARE[1]]);
    assert!(whole.status.success(), "{}", String::from_utf8_lossy(&whole.stderr));
    let digest = line(&whole, "digest");
    assert!(line(&whole, "states").starts_with("states    60,000, "), "{}", line(&whole, "states"));

    let parts = folder("parts");
    let name = parts.to_str().expect("a path");
    for part in ["2/3", "0/3", "1/3"] {
        let words = of(name, &["--range", part, "--threads", "1"]);
        let found = pintle(&words.iter().map(String::as_str).collect::<Vec<_>>()).output().expect("it runs");
        assert_eq!(line(&found, "digest") == digest, part == "1/3", "{part}");
    }
    assert_eq!(chunks(&parts), 15);
    assert_eq!(line(&run(&["sweep", "--merge", name]), "digest"), digest);

    let killed = folder("killed");
    let name = killed.to_str().expect("a path");
    let words = of(name, &["--threads", "1"]);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let (mut kills, mut before) = (0, 0);
    while kills < 4 {
        let mut child =
            pintle(&words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
        let begun = Instant::now();
        // As soon as there is one more chunk, the next is in flight.
        while chunks(&killed) <= before && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        kill(&mut child);
        let now = chunks(&killed);
        assert!(now > before, "a killed run keeps what it wrote");
        (before, kills) = (now, kills + 1);
        if now >= 14 {
            break;
        }
    }
    assert!(kills >= 1, "a run that was killed");
    let resumed = run(&words);
    assert_eq!((line(&resumed, "digest"), chunks(&killed)), (digest, 15));
    for path in [parts, killed] {
        fs::remove_dir_all(path).expect("a folder");
    }
}

/// States of a Sobol sequence are other ones, and in parts the same.
#[test]
fn a_sobol_sequence_has_one_digest_too() {
    let path = folder("sobol");
    let name = path.to_str().expect("a path");
    let sweep = |more: &[&str]| {
        let words = ["sweep", "HINGE", "--states", "9000", "--oracle-share", "0.01"];
        let found = run(&[&words[..], more].concat());
        assert!(found.status.success(), "{}", String::from_utf8_lossy(&found.stderr));
        line(&found, "digest")
    };
    let random = sweep(&[]);
    let even = sweep(&["--generator", "sobol"]);
    assert_ne!(even, random);
    for part in ["2/3", "0/3"] {
        sweep(&["--generator", "sobol", "--chunk", "700", "--out", name, "--range", part]);
    }
    assert_eq!(sweep(&["--generator", "sobol", "--chunk", "700", "--out", name]), even);
    fs::remove_dir_all(path).expect("a folder");
}

/// Bad words and folders are refused, each in one line with its remedy.
#[test]
fn what_cannot_be_swept_is_refused() {
    let path = folder("refused");
    let name = path.to_str().expect("a path");
    let first = run(&["sweep", "HINGE", "--states", "100", "--out", name]);
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let cases: [(&[&str], i32, &str); 10] = [
        (&["sweep", "--states", "0"], 2, "no count"),
        (&["sweep", "--states", "1.5"], 2, "no count"),
        (&["sweep", "--range", "3/3"], 2, "write i/n"),
        (&["sweep", "--oracle-share", "2"], 2, "between 0 and 1"),
        (&["sweep", "HINGEE"], 2, "did you mean HINGE"),
        (&["sweep", "--generator", "halton"], 2, "possible values: philox, sobol"),
        (
            &["sweep", "HINGE", "--generator", "sobol", "--out", name],
            6,
            "the generator sobol in place of philox",
        ),
        (&["sweep", "gallery:nothing"], 2, "the gallery has no scene"),
        (&["sweep", "WELD", "--states", "100", "--out", name], 6, "give another folder"),
        (&["sweep", "--merge", "/nowhere"], 6, "plan.json"),
    ];
    for (words, code, told) in cases {
        let found = run(words);
        let text = String::from_utf8_lossy(&found.stderr).into_owned();
        assert_eq!(found.status.code(), Some(code), "{words:?}: {text}");
        assert!(text.contains(told), "{words:?}: {text}");
    }
    fs::remove_dir_all(path).expect("a folder");
}

/// A scene's connectors are swept one by one; the picture is a file; a state is printed with all its bits.
#[test]
fn scenes_pictures_and_states() {
    let path = folder("picture");
    fs::create_dir_all(&path).expect("a folder");
    let file = path.join("worst.svg");
    let name = file.to_str().expect("a path");
    let words =
        ["sweep", "gallery:slider_crank", "--states", "3000", "--oracle-share", "0.05", "--picture", name];
    let found = run(&words);
    assert!(found.status.success(), "{}", String::from_utf8_lossy(&found.stderr));
    assert!(line(&found, "TRANSLATOR 106").contains(" 480 "), "{}", line(&found, "TRANSLATOR 106"));
    let svg = fs::read_to_string(&file).expect("a picture");
    assert!(svg.starts_with("<svg") && svg.contains("TRANSLATOR 106") && svg.contains("below 2^"));
    assert_eq!(run(&words).status.code(), Some(7), "no file is overwritten");
    let state = |seed: &str| run(&["sweep", "HINGE", "--state", "12345", "--seed", seed]).stdout;
    assert!(state("a") == state("a") && state("a") != state("b"));
    // It is judged again as a counter-example is.
    let kept = path.join("state.json");
    fs::write(&kept, state("a")).expect("a file");
    let replayed = run(&["replay", kept.to_str().expect("a path")]);
    assert!(replayed.status.success(), "{}", String::from_utf8_lossy(&replayed.stderr));
    assert!(String::from_utf8_lossy(&replayed.stdout).contains("1 subject audited"));
    fs::remove_dir_all(path).expect("a folder");
}

/// Whatever is wrong ends with exit code 1, and is counted.
#[test]
fn what_is_wrong_ends_with_code_one() {
    for (of, fault) in
        [("CARTESIAN", "column"), ("CARDAN", "not-a-number"), ("CARDAN", "judged"), ("CARDAN", "axes")]
    {
        let words = ["sweep", of, "--states", "3200", "--oracle-share", "0.02", "--plant", fault];
        let found = run(&words);
        assert_eq!(found.status.code(), Some(1), "{fault}: {}", String::from_utf8_lossy(&found.stderr));
        let wrong = line(&found, of).split_whitespace().last().map(str::to_string);
        assert!(wrong.is_some_and(|wrong| wrong != "0"), "{fault}: {}", line(&found, of));
    }
    let sound = run(&["sweep", "CARDAN", "--states", "3200", "--oracle-share", "0.02"]);
    assert!(sound.status.success());
}

/// A routine of somebody else: a right one, one that is wrong everywhere, and one that is wrong at a few states, which no share has to meet.
#[test]
fn a_routine_is_swept() {
    let path = folder("routine");
    fs::create_dir_all(&path).expect("a folder");
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/elements");
    let rare = "import sys\nsys.path.insert(0, OWN)\nfrom my_elements import cartesian, without_arm\n\
        def rare(state, connector):\n    values, rows = cartesian(state, connector)\n    \
        if abs(state['b']['x'][0] - state['a']['x'][0]) < 2e-3:\n        rows[1][3] += 1e-9\n    return values, rows\n\
        def nowhere(state, connector):\n    raise ValueError('no')\n\
        def refuses(state, connector):\n    return {'out_of_domain': 'not here'}\n\
        def dies(state, connector):\n    x = abs(state['b']['x'][0] - state['a']['x'][0])\n    \
        return __import__('os')._exit(5) if x < 2e-3 else cartesian(state, connector)\n\
        def dies_often(state, connector):\n    x = state['b']['x'][0] - state['a']['x'][0]\n    \
        return __import__('os')._exit(5) if x > 0 else cartesian(state, connector)\n\
        def hangs(state, connector):\n    __import__('time').sleep(60)\n";
    fs::write(path.join("mine.py"), rare.replace("OWN", &format!("{own:?}"))).expect("a module");
    let sweep = |function: &str, more: &[&str]| {
        let python = format!("mine:{function}");
        let words = ["sweep", "CARTESIAN", "--python", &python, "--states", "6000"];
        let words: Vec<&str> = words.into_iter().chain(more.iter().copied()).collect();
        pintle(&words).current_dir(&path).output().expect("it runs")
    };
    let right = sweep("cartesian", &["--oracle-share", "0.01"]);
    assert!(right.status.success(), "{}", String::from_utf8_lossy(&right.stderr));
    assert!(line(&right, "CARTESIAN").trim_end().ends_with(" 0"), "{}", line(&right, "CARTESIAN"));
    // The same numbers in chunks, on one thread.
    let parts = sweep("cartesian", &["--oracle-share", "0.01", "--chunk", "700"]);
    assert_eq!(line(&parts, "digest"), line(&right, "digest"));
    // The plan says the convention, and so a folder does.
    fs::write(path.join("body.toml"), "rotations = \"body\"\n").expect("a convention");
    let kept = sweep("cartesian", &["--out", "kept"]);
    assert!(kept.status.success(), "{}", String::from_utf8_lossy(&kept.stderr));
    let other = sweep("cartesian", &["--out", "kept", "--convention", "body.toml"]);
    let said = String::from_utf8_lossy(&other.stderr).into_owned();
    assert_eq!(other.status.code(), Some(6), "{said}");
    assert!(said.contains("the numbers of another routine"), "{said}");
    let wrong = sweep("without_arm", &["--oracle-share", "0"]);
    assert_eq!(wrong.status.code(), Some(1));
    assert!(line(&wrong, "CARTESIAN").trim_end().ends_with(" 6,000"), "{}", line(&wrong, "CARTESIAN"));
    let some = sweep("rare", &["--oracle-share", "0"]);
    assert_eq!(some.status.code(), Some(1));
    let table = line(&some, "CARTESIAN");
    let count: u64 =
        table.split_whitespace().next_back().and_then(|last| last.parse().ok()).expect("a count");
    assert!((1..200).contains(&count), "{table}");
    assert!(
        line(&some, "CARTESIAN: ").contains("the first wrong state is")
            && line(&some, "CARTESIAN: ").contains("the same command with --state "),
        "{}",
        line(&some, "CARTESIAN: ")
    );
    let none = sweep("nowhere", &[]);
    assert_eq!(none.status.code(), Some(6), "{}", String::from_utf8_lossy(&none.stderr));
    // One that dies at some states has no numbers there, and the sweep goes on; one that dies at every other state ends it. Both name a state.
    let dies = sweep("dies", &["--oracle-share", "0"]);
    assert_eq!(dies.status.code(), Some(1), "{}", String::from_utf8_lossy(&dies.stderr));
    let count = |of: &Output| line(of, "CARTESIAN").split_whitespace().next_back().map(str::to_string);
    assert_eq!(count(&dies), count(&some));
    assert!(line(&dies, "CARTESIAN: ").contains("state "), "{}", line(&dies, "CARTESIAN: "));
    let said = String::from_utf8_lossy(&dies.stderr).into_owned();
    assert!(said.contains("no numbers at state ") && said.contains("exit status: 5"), "{said}");
    let often = sweep("dies_often", &["--oracle-share", "0"]);
    let said = String::from_utf8_lossy(&often.stderr).into_owned();
    assert_eq!(often.status.code(), Some(6), "{said}");
    assert!(said.contains("when it was to answer, at state ") && said.contains(" prints it"), "{said}");
    let hangs = sweep("hangs", &["--timeout", "6"]);
    let said = String::from_utf8_lossy(&hangs.stderr).into_owned();
    assert_eq!(hangs.status.code(), Some(6), "{said}");
    assert!(said.contains("within 6s") && said.contains("at one of the states "), "{said}");
    // A routine that covers no state is not right.
    let refuses = sweep("refuses", &[]);
    assert_eq!(refuses.status.code(), Some(4), "{}", String::from_utf8_lossy(&refuses.stderr));
    assert!(line(&refuses, "passed").contains("6,000 states, not judged"), "{}", line(&refuses, "passed"));
    assert!(String::from_utf8_lossy(&refuses.stderr).contains("nothing was evaluated"));
    let words = ["sweep", "REVOLUTE", "--python", "mine:refuses", "--states", "40"];
    let held = pintle(&words).current_dir(&path).output().expect("it runs");
    let said = |of: &Output| String::from_utf8_lossy(&of.stderr).contains("misaligned initial axes");
    assert!(said(&held) && !said(&refuses));
    let unnamed = run(&["sweep", "--python", "mine:cartesian"]);
    assert_eq!(unnamed.status.code(), Some(2));
    fs::remove_dir_all(path).expect("a folder");
}
