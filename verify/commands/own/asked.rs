//! Where and how a routine is asked: all connectors of a scene, within a domain, at arrays of NumPy, with steps that are taken back.

use crate::commands::check::has_python;
use crate::commands::cli::{pintle, stderr, stdout};
use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Routines in Python. `keeps` counts its turns itself; what is wrong is the environment's WRONG.
const ROUTINES: &str = r#"
import math, os
WRONG = os.environ.get("WRONG", "")
def dot(v, w): return sum(float(x) * float(y) for x, y in zip(v, w))
def cross(v, w): return [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]]
def cartesian(state, connector):
    a, b, initial = state["a"], state["b"], connector["initial"]
    d = [float(b["x"][i]) - float(a["x"][i]) for i in range(3)]
    d0 = [float(initial["b"]["x"][i]) - float(initial["a"]["x"][i]) for i in range(3)]
    if "NARROW" in os.environ and abs(dot(a["triad"][0], d)) > 0.2:
        raise ValueError("asked outside")
    values, rows = [None] * 6, [None] * 6
    for k in range(3):
        e = [float(x) for x in a["triad"][k]]
        values[k] = dot(e, d) - dot(initial["a"]["triad"][k], d0)
        rows[k] = [*(-x for x in e), *cross(e, d), 0.0, *e, 0.0, 0.0, 0.0, 0.0]
    return values, rows
def alpha(a, b): return math.atan2(-dot(a[1], b[2]), dot(a[2], b[2]))
kept = tried = first = 0.0
def begin(connector):
    global kept, tried, first
    if "initial" in connector:
        first = kept = tried = alpha(connector["initial"]["a"]["triad"], connector["initial"]["b"]["triad"])
def keeps(state, connector):
    global kept, tried
    a, b = state["a"], state["b"]
    now = alpha(a["triad"], b["triad"])
    tried = now + 2 * math.pi * round((kept - now) / (2 * math.pi))
    value = tried - first
    if WRONG == "leaks": kept += 1e-3 * now
    if WRONG == "leaks": value += kept
    if WRONG == "eager": kept = tried
    return {"values": [None, None, None, value, None, None]}
def commit():
    global kept
    if WRONG != "forgets": kept = tried
def revert():
    global tried
    tried = kept
"#;

/// The same behind JSON lines.
const LINES: &str = r#"
import json, os, sys
import asked_routines as mine
name, opened = sys.argv[1], 0
def send(message): print(json.dumps(message), flush=True)
for line in sys.stdin:
    message = json.loads(line)
    if "hello" in message:
        hello = {"protocol": "pintle-candidate/1", "name": name, **json.loads(sys.argv[2])}
        send({"hello": hello})
    elif "open" in message:
        connector, opened = message["open"], opened + 1
        mine.begin(connector)
        if mine.WRONG == "open" and opened > 1: send({"error": "no second open"})
        else: send({"opened": True} if connector["type"] in ("CARTESIAN", "REVOLUTE") else {"error": "CARTESIAN alone"})
    elif "commit" in message or "revert" in message:
        word = next(iter(message))
        getattr(mine, word)()
        done = {"commit": "committed", "revert": "reverted"}[word]
        send({"error": f"no {word}"} if mine.WRONG == word else {done: True})
    elif "evaluate" in message:
        asked, answers = message["evaluate"], []
        for state in asked["states"]:
            given = getattr(mine, name)(state, connector)
            answers.append(given if isinstance(given, dict) else dict(zip(("values", "rows"), given)))
        send({"id": asked["id"], "answers": answers})
    else:
        break
"#;

const DECK: &str = "\
*NODE
1, 0., 0., 0.
2, 1., 0.2, 0.
3, 2., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=C
101, 1, 2
102, 2, 3
*CONNECTOR SECTION, ELSET=C
CARTESIAN,
*ELEMENT, TYPE=CONN3D2, ELSET=L
103, 1, 3
*CONNECTOR SECTION, ELSET=L
AXIAL,
";

/// A folder of the test's own, with the routines and what each door needs besides.
fn folder(name: &str, besides: &str) -> PathBuf {
    let folder = crate::commands::cli::folder(format!("asked-{name}"));
    fs::write(folder.join("asked_routines.py"), ROUTINES).unwrap();
    // A module without commit and revert, for routines that keep nothing.
    let plain = format!("from asked_routines import cartesian\n{besides}\n");
    fs::write(folder.join("plain.py"), plain).unwrap();
    let keeps =
        "from asked_routines import keeps, begin, commit, revert\nOFFERS, COMPONENTS = ['values'], ['ur1']\n";
    fs::write(folder.join("keeping.py"), keeps).unwrap();
    fs::write(folder.join("lines.py"), LINES).unwrap();
    fs::write(folder.join("deck.inp"), DECK).unwrap();
    folder
}

fn there(folder: &Path, of: &str, door: [&str; 2], more: &[&str]) -> Command {
    let few: &[&str] = if more.contains(&"--at") {
        &["--wide-states", "6"]
    } else if more.contains(&"--histories") {
        &["--states", "40", "--near-singular-states", "6", "--wide-states", "6"]
    } else {
        &["--states", "40", "--near-singular-states", "6", "--wide-states", "6", "--histories", "12"]
    };
    let mut command = pintle(&[&["check", of, "--timeout", "60"][..], &door, few, more].concat());
    command.current_dir(folder).env_remove("WRONG").env_remove("NARROW");
    command
}

fn lines(name: &str, hello: &str) -> String {
    format!("exec python3 lines.py {name} '{hello}'")
}

/// A routine that commits and reverts is led along histories through whole turns. One whose revert leaves something behind is named, and
/// so is one that does not commit.
#[test]
fn steps_are_taken_back() {
    if !has_python() {
        return;
    }
    let folder = folder("commits", "");
    let by_lines = lines("keeps", r#"{"offers": ["values"], "components": ["ur1"], "commits": true}"#);
    let mut compared = 0;
    for door in [["--python", "keeping:keeps"], ["--with", &by_lines]] {
        let right = there(&folder, "REVOLUTE", door, &["--format", "json"]).assert().success();
        let report: Value = serde_json::from_str(&stdout(&right)).unwrap();
        let checks = report["subjects"][0]["checks"].as_array().unwrap();
        compared += checks.iter().map(|check| check["compared"].as_u64().unwrap()).sum::<u64>();
        // One that commits what is tried is noticed without histories, too.
        for (wrong, more) in [("leaks", &[][..]), ("eager", &[]), ("eager", &["--histories", "0"])] {
            let fails = there(&folder, "REVOLUTE", door, more).env("WRONG", wrong).assert().code(6);
            let why = stderr(&fails);
            assert!(why.contains("taken back and taken again"), "{wrong}: {why}");
        }
        let forgets = there(&folder, "REVOLUTE", door, &[]).env("WRONG", "forgets").assert().code(1);
        assert!(stdout(&forgets).contains("turn"), "{}", stdout(&forgets));
    }
    assert!(compared >= 80, "{compared}");
    let both = lines("keeps", r#"{"offers": ["values"], "commits": true, "memory": true}"#);
    let why = stderr(&there(&folder, "REVOLUTE", ["--with", &both], &[]).assert().code(6));
    assert!(why.contains("cannot announce memory"), "{why}");
}

/// Routines beside the commit and revert of others, which fail.
const BESIDE: &str = r#"
import math
import asked_routines as mine
from asked_routines import cartesian
def begin(connector): raise RuntimeError("another's begin")
def commit(): raise RuntimeError("another's commit")
revert = commit
class Keeps:
    def begin(self, connector): mine.begin(connector)
    def commit(self): mine.commit()
    def revert(self): mine.revert()
    def __call__(self, state, connector): return mine.keeps(state, connector)
    def ask(self, state, connector): return self(state, connector)
def apart(begin, commit, revert):
    def ask(state, connector): return mine.keeps(state, connector)
    ask.begin, ask.commit, ask.revert = begin, commit, revert
    return ask
keeps, by_attributes = Keeps(), apart(mine.begin, mine.commit, mine.revert)
"#;

/// Of a Python routine, what it or its object commits by stands before that of its module. What has no steps is not told of any.
#[test]
fn steps_are_those_of_the_routine() {
    if !has_python() {
        return;
    }
    let folder = folder("beside", "");
    fs::write(folder.join("beside.py"), format!("{BESIDE}OFFERS, COMPONENTS = ['values'], ['ur1']\n"))
        .unwrap();
    let mut compared = 0;
    let asked = |of: &str, routine: &str| {
        let done = there(&folder, of, ["--python", routine], &["--format", "json"]).assert().success();
        let report: Value = serde_json::from_str(&stdout(&done)).unwrap();
        let checks = report["subjects"][0]["checks"].as_array().unwrap();
        checks.iter().map(|check| check["compared"].as_u64().unwrap()).sum::<u64>()
    };
    for routine in ["beside:keeps", "beside:keeps.ask", "beside:by_attributes"] {
        compared += asked("REVOLUTE", routine);
    }
    // A memory in answers, a constraint and a friction.
    let remembers = "
def remembers(state, connector):
    mine.begin(connector)
    mine.kept = state['previous'].get('memory', mine.kept)
    return {**mine.keeps(state, connector), 'memory': mine.tried}
MEMORY = True
";
    fs::write(
        folder.join("remembers.py"),
        format!("{BESIDE}{remembers}OFFERS, COMPONENTS = ['values'], ['ur1']\n"),
    )
    .unwrap();
    compared += asked("REVOLUTE", "remembers:remembers");
    let others = "
def pin(state, constraint):
    values, rows = [None] * 7, [None] * 7
    for i in range(3):
        values[i] = float(state['S']['u'][i] - state['M']['u'][i])
        rows[i] = [float(j == i) - float(j == 7 + i) for j in range(14)]
    return values, rows
";
    fs::write(folder.join("pins.py"), format!("{BESIDE}{others}DOMAIN = {{'x1': [-1, 1]}}\n")).unwrap();
    compared += asked("MPC PIN", "pins:pin");
    let slide = "
def slide(state, friction):
    f, mu = [float(x) for x in state['forces']], friction['coefficient']
    p, n = math.hypot(f[1], f[2]), abs(abs(f[0]) + friction['parameters']['F_C^int'])
    return {'criterion': [p, abs(f[0]), n, p - mu * n]}
OFFERS = ['criterion']
";
    fs::write(folder.join("slides.py"), format!("{BESIDE}{slide}")).unwrap();
    compared += asked("FRICTION SLIDE-PLANE", "slides:slide");
    assert!(compared > 1_000, "{compared}");
}

/// What a routine fails at after it was opened ends the check of a scene: it is no connector that it does not cover.
#[test]
fn failures_are_no_refusals() {
    if !has_python() {
        return;
    }
    let folder = folder("refusals", "");
    let deck = DECK.replace("CARTESIAN,", "REVOLUTE,\nAXIS,");
    let deck = deck.replace(
        "*CONNECTOR SECTION, ELSET=C",
        "*ORIENTATION, NAME=AXIS\n1., 0., 0., 0., 1., 0.\n*CONNECTOR SECTION, ELSET=C",
    );
    fs::write(folder.join("revolute.inp"), deck).unwrap();
    let by_lines = lines("keeps", r#"{"offers": ["values"], "components": ["ur1"], "commits": true}"#);
    let mut told = 0;
    for (wrong, says) in [
        ("open", "did not open the connector again: \"no second open\""),
        ("commit", "did not commit: \"no commit\""),
        ("revert", "did not revert: \"no revert\""),
    ] {
        for of in ["revolute.inp", "REVOLUTE"] {
            let fails = there(&folder, of, ["--with", &by_lines], &[]).env("WRONG", wrong).assert().code(6);
            let why = stderr(&fails);
            assert!(why.contains(says) && !why.contains("not covered"), "{of} {wrong}: {why}");
            told += 1;
        }
    }
    assert_eq!(told, 6);
    there(&folder, "revolute.inp", ["--with", &by_lines], &[]).assert().success();
}

/// States lie within a domain, whoever declares it.
#[test]
fn states_are_drawn_within_a_domain() {
    if !has_python() {
        return;
    }
    let folder = folder("domain", "DOMAIN = {'x1': [-0.1, 0.1]}");
    fs::write(folder.join("domain.toml"), "domain = { x1 = [-0.1, 0.1] }\n").unwrap();
    let bare = lines("cartesian", r#"{"offers": ["values", "rows"]}"#);
    let told = lines("cartesian", r#"{"offers": ["values", "rows"], "domain": {"x1": [-0.1, 0.1]}}"#);
    fs::write(folder.join("wide.toml"), "domain = { x1 = [-9, 9] }\n").unwrap();
    fs::write(folder.join("wide.py"), "from asked_routines import cartesian\nDOMAIN = {'x1': [-9, 9]}\n")
        .unwrap();
    let wide = lines("cartesian", r#"{"offers": ["values", "rows"], "domain": {"x1": [-9, 9]}}"#);
    // The command line stands before the file, and that before the routine; where conventions are found, too.
    let ways: [(&str, &str, &[&str]); 12] = [
        ("--with", &bare, &["--within", "x1=-0.1:0.1"]),
        ("--with", &bare, &["--convention", "domain.toml"]),
        ("--with", &told, &[]),
        ("--python", "plain:cartesian", &[]),
        ("--with", &wide, &["--convention", "domain.toml"]),
        ("--python", "wide:cartesian", &["--convention", "domain.toml"]),
        ("--with", &wide, &["--convention", "wide.toml", "--within", "x1=-0.1:0.1"]),
        ("--python", "wide:cartesian", &["--convention", "wide.toml", "--within", "x1=-0.1:0.1"]),
        ("--with", &wide, &["--fit-convention", "--within", "x1=-0.1:0.1"]),
        ("--python", "wide:cartesian", &["--fit-convention", "--within", "x1=-0.1:0.1"]),
        ("--with", &told, &["--fit-convention"]),
        ("--python", "plain:cartesian", &["--fit-convention"]),
    ];
    for (door, routine, more) in ways {
        there(&folder, "CARTESIAN", [door, routine], more).env("NARROW", "1").assert().success();
    }
    // Without it the routine is asked outside.
    let outside = there(&folder, "CARTESIAN", ["--with", &bare], &[]).env("NARROW", "1").assert().code(6);
    assert!(!stderr(&outside).is_empty());
    for (wrong, why) in [("y1=0:1", "there are x1"), ("x1=1:0", "no range"), ("r1=0:4", "between −π and π")]
    {
        let told =
            stderr(&there(&folder, "CARTESIAN", ["--with", &bare], &["--within", wrong]).assert().failure());
        assert!(told.contains(why), "{told}");
    }
    // A domain is of connectors.
    for (of, routine) in [("MPC PIN", "plain:cartesian"), ("FRICTION HINGE", "plain:cartesian")] {
        for door in [["--python", routine], ["--with", &bare]] {
            let told = stderr(&there(&folder, of, door, &["--within", "x1=0:1"]).assert().code(2));
            assert!(
                told.contains("--within limits") && told.contains(of.split(' ').next().unwrap()),
                "{told}"
            );
        }
    }
    let mut states = pintle(&[
        "states",
        "CARTESIAN",
        "--count",
        "30",
        "--within",
        "x1=-0.1:0.1,x2=0:0,x3=0:0.5,r1=-0.1:0.1",
    ]);
    let table = stdout(&states.assert().success());
    assert_eq!(table.lines().count(), 61);
}

/// Of a scene all connectors are asked that the routine covers, and those that it does not cover are named.
#[test]
fn all_connectors_of_a_scene_are_asked() {
    if !has_python() {
        return;
    }
    let folder = folder("scene", "TYPES = ['CARTESIAN']");
    let by_lines = lines("cartesian", r#"{"offers": ["values", "rows"]}"#);
    for door in [["--python", "plain:cartesian"], ["--with", &by_lines]] {
        let done = there(&folder, "deck.inp", door, &["--format", "json"]).assert().success();
        let report: Value = serde_json::from_str(&stdout(&done)).unwrap();
        let subjects = report["subjects"].as_array().unwrap();
        let names: Vec<&str> = subjects.iter().map(|one| one["name"].as_str().unwrap()).collect();
        let [one, other] = names[..] else { panic!("{names:?}") };
        let [one, other] = [one, other].map(|name| name.split_once(" for ").unwrap());
        assert_eq!((one.1, other.1), ("deck.inp:101", "deck.inp:102"));
        assert_eq!(one.0, other.0);
        let note = stderr(&done);
        assert!(note.contains("deck.inp:103") && note.contains("CARTESIAN"), "{note}");
        for element in ["101", "102"] {
            assert!(note.contains(&format!("deck.inp:{element}: not offered, and not judged: ")), "{note}");
            for format in ["junit", "markdown"] {
                let text =
                    stdout(&there(&folder, "deck.inp", door, &["--format", format]).assert().success());
                assert!(text.contains(&format!("{} for deck.inp:{element}", one.0)), "{format}: {text}");
            }
        }
        let page = stdout(&there(&folder, "deck.inp", door, &[]).assert().success());
        assert!(page.contains("deck.inp:101") && page.contains("deck.inp:102"), "{page}");
    }
    fs::write(folder.join("other.py"), "from asked_routines import cartesian\nTYPES = ['HINGE']\n").unwrap();
    let none = there(&folder, "deck.inp", ["--python", "other:cartesian"], &[]).assert().failure();
    let why = stderr(&none);
    assert!(why.contains("covers no connector") && why.contains("deck.inp:102"), "{why}");
    let fit = there(&folder, "deck.inp", ["--with", &by_lines], &["--fit-convention"]).assert().failure();
    assert!(stderr(&fit).contains("deck.inp:101, deck.inp:102"), "{}", stderr(&fit));
}

/// What `pintle states` writes for NumPy is read again, and so is an array of records.
#[test]
fn states_are_read_from_arrays() {
    if !has_python() {
        return;
    }
    let folder = folder("arrays", "");
    let written = ["states", "CARTESIAN", "--count", "24", "--deck", "c.inp"];
    pintle(&[&written[..], &["--format", "npz", "-o", "s.npz"]].concat())
        .current_dir(&folder)
        .assert()
        .success();
    pintle(&[&written[..], &["-o", "s.csv"]].concat()).current_dir(&folder).assert().success();
    let by_lines = lines("cartesian", r#"{"offers": ["values", "rows"]}"#);
    for door in [["--python", "plain:cartesian"], ["--with", &by_lines]] {
        let own = ["--at", "s.npz", "--independent", "--format", "json"];
        let report: Value =
            serde_json::from_str(&stdout(&there(&folder, "CARTESIAN", door, &own).assert().success()))
                .unwrap();
        let checks = report["subjects"][0]["checks"].as_array().unwrap();
        assert!(checks.iter().map(|check| check["compared"].as_u64().unwrap()).sum::<u64>() >= 24 * 3);
    }
    let evaluated = |states: &str| {
        let arguments =
            ["eval", "c.inp", "--states", states, "--independent", "--outputs", "CU", "--format", "csv"];
        stdout(&pintle(&arguments).current_dir(&folder).assert().success())
    };
    // A quaternion is brought to the length 1 once more.
    let numbers = |states: &str| -> Vec<f64> {
        evaluated(states).split([',', '\n']).filter_map(|cell| cell.parse().ok()).collect()
    };
    let [one, other] = ["s.npz", "s.csv"].map(numbers);
    assert_eq!(one.len(), other.len());
    assert!(one.len() > 24 * 3);
    assert!(one.iter().zip(&other).all(|(x, y)| (x - y).abs() <= 1e-14 * (1.0 + y.abs())));
    // Records of NumPy, written by hand.
    let header = "{'descr': [('state', '<f8'), ('node', '<i4'), ('U1', '<f8'), ('UR3', '<f8')], 'fortran_order': False, 'shape': (4,), }\n";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for (state, node, u, ur) in
        [(1.0_f64, 1_i32, 0.0_f64, 0.25_f64), (1.0, 2, 0.5, 0.0), (2.0, 1, 0.125, 0.5), (2.0, 2, 0.0, 0.0)]
    {
        bytes.extend(state.to_le_bytes());
        bytes.extend(node.to_le_bytes());
        bytes.extend(u.to_le_bytes());
        bytes.extend(ur.to_le_bytes());
    }
    fs::write(folder.join("r.npy"), bytes).unwrap();
    there(&folder, "CARTESIAN", ["--with", &by_lines], &["--at", "r.npy"]).assert().success();
    assert_eq!(evaluated("r.npy").lines().count(), 1 + 2 * 3);
}
