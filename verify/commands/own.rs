//! A check at somebody's own states, of a constraint of a scene, and with answers as bytes.

mod asked; // where and how a routine is asked

use crate::commands::cli::{pintle, stderr, stdout};
use crate::commands::export::python;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

const ROUTINES: &str = r#"
import math
SEEN = open("seen.txt", "a")
def dot(v, w): return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]
def revolute(state, connector, *, turns=True):
    """ur1 alone: the angle about e1a, which goes on from the value before."""
    a, b, first = state["a"]["triad"], state["b"]["triad"], connector["initial"]
    angle = lambda a, b: math.atan2(-dot(a[1], b[2]), dot(a[2], b[2]))
    x = angle(a, b) - angle(first["a"]["triad"], first["b"]["triad"])
    before = state["previous"]["values"][3]
    SEEN.write(f"{before!r}\n")
    if turns: x += 2 * math.pi * round((before - x) / (2 * math.pi))
    return [None, None, None, x, None, None], None
def principal(state, connector): return revolute(state, connector, turns=False)
def pin(state, constraint, *, wrong=0.0):
    rows, values = [None] * 7, [None] * 7
    for i in range(3):
        values[i] = float(state["S"]["u"][i] - state["M"]["u"][i]) * (1 + wrong)
        rows[i] = [0.0] * 14
        rows[i][i], rows[i][7 + i] = 1.0 + wrong, -1.0 - wrong
    return values, rows
def stretched(state, constraint): return pin(state, constraint, wrong=0.5)
OFFERS, COMPONENTS = ["values"], ["ur1"]
"#;

fn folder(name: &str) -> PathBuf {
    let folder = crate::commands::cli::folder(format!("own-{name}"));
    fs::write(folder.join("mine.py"), ROUTINES).unwrap();
    let text = ROUTINES.replace(r#"OFFERS, COMPONENTS = ["values"], ["ur1"]"#, "");
    fs::write(folder.join("tied.py"), text).unwrap();
    fs::write(folder.join("seen.txt"), "").unwrap();
    folder
}

/// Whether there is a NumPy, which continuous integration must have.
fn has_numpy() -> bool {
    let has = std::process::Command::new(python()).args(["-c", "import numpy"]).output();
    let has = has.is_ok_and(|output| output.status.success());
    assert!(has || std::env::var_os("CI").is_none(), "CI has no NumPy");
    if !has {
        eprintln!("SKIPPED: there is no NumPy");
    }
    has
}

fn there(folder: &Path, arguments: &[&str]) -> assert_cmd::Command {
    let mut command = pintle(arguments);
    command.current_dir(folder);
    command
}

/// States of a file are a history: an angle goes on through two turns, and a principal one is wrong, with that cause. The same
/// states one by one have no turns to go on. Of a type, of a connector of a scene, in the order of the file.
#[test]
fn own_states_are_asked_alone() {
    let folder = folder("states");
    let history = [
        "--force",
        "states",
        "REVOLUTE",
        "--count",
        "40",
        "--history",
        "-o",
        "history.csv",
        "--deck",
        "deck.inp",
    ];
    there(&folder, &history).assert().success();
    let scene = fs::read_to_string(folder.join("deck.inp")).unwrap();
    assert!(scene.contains("REVOLUTE"));
    for of in ["REVOLUTE", "deck.inp:1"] {
        let arguments = ["check", of, "--python", "mine:revolute", "--at", "history.csv", "--format", "json"];
        let report: Value =
            serde_json::from_str(&stdout(&there(&folder, &arguments).assert().success())).unwrap();
        let subject = &report["subjects"][0];
        assert_eq!((&subject["cases"], &subject["formula"]), (&40.into(), &"pass".into()), "{of}");
    }
    let seen = fs::read_to_string(folder.join("seen.txt")).unwrap();
    let largest = seen.lines().map(|line| line.parse::<f64>().unwrap().abs()).fold(0.0, f64::max);
    assert!(largest > 6.0, "{largest}: no turns were handed over");
    let wrong = ["check", "REVOLUTE", "--python", "mine:principal", "--at", "history.csv"];
    let told = stdout(&there(&folder, &wrong).assert().code(1));
    assert!(told.contains("turns-forgotten") || told.contains("principal"), "{told}");
    let alone = ["check", "REVOLUTE", "--python", "mine:revolute", "--at", "history.csv", "--independent"];
    there(&folder, &alone).assert().success();
    // What is not there is told, and a friction has no states.
    for (of, at, says) in [
        ("REVOLUTE", "none.csv", "none.csv"),
        ("FRICTION HINGE", "history.csv", "at forces that are drawn"),
        ("MPC PIN", "history.csv", "MPC SCENE:S-M"),
    ] {
        let code = if of == "REVOLUTE" { 6 } else { 2 };
        let told = stderr(
            &there(&folder, &["check", of, "--python", "mine:revolute", "--at", at]).assert().code(code),
        );
        assert!(told.contains(says), "{of}: {told}");
    }
}

/// A constraint of a scene is named by its nodes, asked at drawn states or at those of a file.
#[test]
fn constraints_of_a_scene_are_checked() {
    let folder = folder("constraints");
    let deck = Path::new(env!("CARGO_MANIFEST_DIR")).join("decks/revolute_mpc");
    let [deck, states] = ["inp", "states.csv"].map(|end| deck.with_extension(end).display().to_string());
    let of = |nodes: &str| format!("MPC {deck}:{nodes}");
    for (routine, at, code) in
        [("tied:pin", None, 0), ("tied:stretched", None, 1), ("tied:pin", Some(&states), 0)]
    {
        for nodes in ["10-20", "pin 10-20"] {
            let of = of(nodes);
            let at = at.map(|at| vec!["--at", at]).unwrap_or_default();
            let arguments = [&["check", &of, "--python", routine][..], &at].concat();
            let told = stdout(&there(&folder, &arguments).assert().code(code));
            assert!(told.contains("as MPC PIN"), "{told}");
        }
    }
    let told = stderr(&there(&folder, &["check", &of("10-21"), "--python", "tied:pin"]).assert().code(2));
    assert!(told.contains("10-20-30, 10-20"), "{told}");
}

/// A routine whose answers are bytes, in Python without NumPy, with a mistake in them.
const BYTES: &str = r#"
import json, math, struct, sys
fault = sys.argv[1] if len(sys.argv) > 1 else ""
say = lambda message, data=b"": (sys.stdout.buffer.write(json.dumps(message).encode() + b"\n" + data), sys.stdout.buffer.flush())
for line in sys.stdin.buffer:
    message = json.loads(line)
    if "hello" in message:
        say({"hello": {"protocol": "pintle-candidate/1", "name": "bytes", "offers": ["values", "rows"], "binary": True,
                       "memory": fault == "memory"}})
    elif "open" in message:
        first = message["open"]["initial"]
        d0 = math.dist(first["a"]["x"], first["b"]["x"])
        say({"opened": True})
    elif "evaluate" in message:
        asked = message["evaluate"]
        assert asked["want"] in (["values", "rows"], ["values"]) and asked["bytes"] == asked["count"] * 166 * 8
        out, words = [], []
        for n in range(asked["count"]):
            state = struct.unpack("<166d", sys.stdin.buffer.read(166 * 8))
            d = [state[40 + i] - state[i] for i in range(3)]
            length = math.hypot(*d)
            row = [-x / length for x in d] + [0.0] * 4 + [x / length for x in d] + [0.0] * 4
            if fault == "wrong": row[3] = 1.0
            nothing = [math.nan]
            out += [length - d0] + nothing * 5
            if "rows" in asked["want"]: out += row + nothing * 70
            words.append({"values": [length - d0, *[None] * 5], "rows": [row, *[None] * 5]})
        data = struct.pack(f"<{len(out)}d", *out)
        if fault == "short": data = data[:-8]
        if fault == "words": say({"id": asked["id"], "answers": words})
        elif fault == "cut":
            say({"id": asked["id"], "bytes": len(data) + 8}, data)
            sys.exit(0)
        else: say({"id": asked["id"], "bytes": len(data)}, data)
    else:
        break
"#;

/// Bytes are judged as text is; each fault of theirs is named.
#[test]
fn bytes_are_read_as_text_is() {
    let folder = folder("bytes");
    fs::write(folder.join("bytes.py"), BYTES).unwrap();
    let asked = |fault: &str, code: i32| {
        let command = format!("exec python3 bytes.py {fault}");
        let few = ["--states", "12", "--near-singular-states", "0", "--wide-states", "6", "--format", "json"];
        let arguments = [&["check", "AXIAL", "--with", &command][..], &few].concat();
        let done = there(&folder, &arguments).assert().code(code);
        (stdout(&done), stderr(&done))
    };
    let (by_bytes, _) = asked("", 0);
    assert_eq!(by_bytes, asked("words", 0).0);
    assert!(asked("wrong", 1).0.contains("∂u1/∂θa1"));
    for (fault, says) in [
        ("short", "bytes followed, and"),
        ("cut", "in the middle of a line"),
        ("memory", "cannot announce binary"),
    ] {
        let (_, told) = asked(fault, 6);
        assert!(told.contains(says), "{fault}: {told}");
    }
}

/// States for NumPy are those of the table, array by array.
#[test]
fn arrays_of_states_are_those_of_the_table() {
    let folder = folder("arrays");
    if !has_numpy() {
        return;
    }
    for (format, file) in [("csv", "states.csv"), ("npz", "states.npz")] {
        let arguments =
            ["--force", "states", "HINGE", "--count", "9", "--near", "3", "--format", format, "-o", file];
        there(&folder, &arguments).assert().success();
    }
    let program = r#"
import csv, numpy
arrays, compared = numpy.load("states.npz"), 0
rows = list(csv.DictReader(open("states.csv")))
names = {"u": ["u1", "u2", "u3"], "quaternion": ["q0", "q1", "q2", "q3"], "flow": ["flow"], "velocity": ["v1", "v2", "v3"],
         "angular_velocity": ["vr1", "vr2", "vr3"], "flow_velocity": ["flow_v"], "acceleration": ["a1", "a2", "a3"],
         "angular_acceleration": ["ar1", "ar2", "ar3"], "flow_acceleration": ["flow_a"]}
assert set(arrays.files) == {"state", "node", *names}, arrays.files
assert arrays["node"].tolist() == ["1", "2"] and len(arrays["state"]) * 2 == len(rows)
for n, row in enumerate(rows):
    assert str(arrays["state"][n // 2]) == row["state"] and arrays["node"][n % 2] == row["node"]
    for name, columns in names.items():
        assert arrays[name][n // 2, n % 2].ravel().tolist() == [float(row[column]) for column in columns], (name, row)
        compared += len(columns)
print(compared)
"#;
    let output =
        std::process::Command::new(python()).args(["-c", program]).current_dir(&folder).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    let compared: usize =
        String::from_utf8_lossy(&output.stdout).trim().parse().unwrap_or_else(|_| panic!("{told}"));
    assert_eq!(compared, 12 * 2 * 22);
}

/// What `eval --format npz` writes are the numbers of its JSON, with and without behaviour; what arrays cannot hold is refused.
#[test]
fn evaluations_are_written_as_arrays() {
    let folder = folder("evaluated");
    if !has_numpy() {
        return;
    }
    let mut compared = 0;
    for (scene, outputs) in [
        ("gallery:slider_crank", "CP,CU,RES"),
        ("gallery:slider_crank", "CU,CTF,CEF"),
        ("gallery:seat_belt", "CU,CV,CA"),
    ] {
        for (format, file) in [("json", "it.json"), ("npz", "it.npz")] {
            let arguments = ["eval", scene, "--outputs", outputs, "--order", "1", "--format", format];
            let done = there(&folder, &arguments).assert().success();
            fs::write(folder.join(file), &done.get_output().stdout).unwrap();
        }
        let program = r#"
import json, numpy
arrays, compared, lines = numpy.load("it.npz"), 0, json.load(open("it.json"))
names, components = [n for n in arrays.files if n.startswith("C")], ["u1", "u2", "u3", "ur1", "ur2", "ur3"]
for s, state in enumerate(lines["scenes"][0]["states"]):
    assert arrays["state"][s] == state["index"] and arrays["time"][s] == state["time"]
    for c, connector in enumerate(state["connectors"]):
        assert arrays["element"][c] == str(connector["element"])
        for component, of in connector["components"].items():
            k = components.index(component)
            for name in names:
                known, found = of.get(name), arrays[name][s, c, k]
                if isinstance(known, float):
                    assert abs(found - known) <= 1e-14 * (1 + abs(known)), (name, s, c, k, found, known)
                    compared += 1
                elif known is None:
                    assert numpy.isnan(found), (name, s, c, k, found)
assert arrays["jacobian"].shape == (*arrays[names[0]].shape, 14)
print(compared)
"#;
        let output =
            std::process::Command::new(python()).args(["-c", program]).current_dir(&folder).output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        let all = String::from_utf8_lossy(&output.stdout);
        compared += all.trim().parse::<usize>().unwrap_or_else(|_| panic!("{scene} {outputs}: {told}"));
    }
    assert!(compared > 1_000, "{compared}");
    for (more, why) in [
        (&["--outputs", "NF"][..], "no number of a component"),
        (&["--jacobian", "it.mtx"], "--jacobian is not for --format npz"),
        (&["--show", "1"], "--show is not for --format npz"),
    ] {
        let arguments = [&["eval", "gallery:slider_crank", "--format", "npz"], more].concat();
        let refused = stderr(&there(&folder, &arguments).assert().code(2));
        assert!(refused.contains(why), "{refused}");
    }
}
