//! Somebody's routine in a process: what is judged, and every way in which a process may misbehave.

use crate::commands::cli::{pintle, stderr, stdout};
use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Once;

const EXAMPLE: &str = "my_elements";

/// Arguments of a short check.
fn brief<'a>(of: &'a str, door: &'a str, routine: &'a str) -> Vec<&'a str> {
    let few = ["--states", "12", "--near-singular-states", "0", "--wide-states", "6", "--timeout", "60"];
    [&["check", of, door, routine][..], &few].concat()
}

/// A folder with the routines that the page shows.
fn elements() -> PathBuf {
    let page =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/how-to/check-my-element.md"));
    let page = page.unwrap();
    let (_, code) = page.split_once("file=my_elements.py\n").unwrap();
    let (code, _) = code.split_once("```").unwrap();
    static WRITTEN: Once = Once::new();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("check");
    WRITTEN.call_once(|| {
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("my_elements.py"), code).unwrap();
    });
    folder
}

/// `pintle` in the folder of the routines.
fn there(arguments: &[&str]) -> Command {
    let mut command = pintle(arguments);
    command.current_dir(elements());
    command
}

/// Whether there is a Python, which continuous integration has.
pub(super) fn has_python() -> bool {
    let found = std::process::Command::new("python3").arg("--version").output().is_ok();
    assert!(found || std::env::var_os("CI").is_none(), "CI has no python3");
    if !found {
        eprintln!("SKIPPED: there is no python3");
    }
    found
}

/// A Python routine is right, or the entry that is wrong is named.
#[test]
fn python_routines_are_judged() {
    if !has_python() {
        return;
    }
    let right = format!("{EXAMPLE}:cartesian");
    let mut report = there(&[&brief("CARTESIAN", "--python", &right)[..], &["--format", "json"]].concat());
    let report: Value = serde_json::from_str(&stdout(&report.assert().success())).unwrap();
    let subject = &report["subjects"][0];
    assert_eq!((&subject["derivative"], &subject["formula"]), (&"pass".into(), &"pass".into()));
    let compared: u64 =
        subject["checks"].as_array().unwrap().iter().map(|check| check["compared"].as_u64().unwrap()).sum();
    assert!(compared > 600, "{compared}");
    let wrong = format!("{EXAMPLE}:without_arm");
    let page = stdout(&there(&brief("CARTESIAN", "--python", &wrong)).assert().code(1));
    assert!(page.contains("∂u") && page.contains("/∂θa") && page.contains("wrong"), "{page}");
    // A connector of a scene.
    let of_scene = "gallery:slider_crank:106";
    let report = stdout(&there(&brief(of_scene, "--python", &right)).assert().code(1));
    assert!(report.contains("is missing"), "TRANSLATOR has rotations: {report}");
    assert!(!report.contains("misaligned initial axes"), "a scene has its own: {report}");
}

/// Node a does not start at the origin: a routine that takes b's place for what lies between the nodes is wrong. Forces of springs are not
/// judged where nobody gave the springs.
#[test]
fn neither_an_origin_nor_zero_forces_hide_a_mistake() {
    if !has_python() {
        return;
    }
    let file = elements().join("forgets_where_a_began.py");
    let text = format!(
        "from {EXAMPLE} import cartesian, dot\n\n\ndef forgets(state, connector):\n    values, rows = cartesian(state, connector)\n    \
         first = connector['initial']\n    for i in range(3):\n        values[i] -= dot(first['a']['triad'][i], first['a']['x'])\n    \
         return values, rows\n"
    );
    fs::write(&file, text).unwrap();
    let text = format!(
        "from {EXAMPLE} import cartesian\n\nOFFERS = ['values', 'rows', 'element_forces']\n\n\ndef sprung(state, connector):\n    \
         values, rows = cartesian(state, connector)\n    return {{'values': values, 'rows': rows, 'element_forces': [0.0] * 14}}\n"
    );
    fs::write(elements().join("has_no_springs.py"), text).unwrap();
    let page =
        stdout(&there(&brief("CARTESIAN", "--python", "forgets_where_a_began:forgets")).assert().code(1));
    assert!(page.contains("values             wrong"), "{page}");
    let page = stdout(&there(&brief("CARTESIAN", "--python", "has_no_springs:sprung")).assert().success());
    let words = page.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words.contains("are not judged: give the springs") && !words.contains("element forces pass"),
        "{page}"
    );
}

/// Of fifty connectors alike a mistake is told once.
#[test]
fn connectors_alike_are_told_once() {
    if !has_python() {
        return;
    }
    let deck = elements().join("alike.inp");
    let mut text = "*NODE\n".to_owned();
    (0..10).for_each(|n| text.push_str(&format!("{}, {n}., 0., 0.\n", n + 1)));
    text.push_str("*ELEMENT, TYPE=CONN3D2, ELSET=A\n");
    (0..5).for_each(|n| text.push_str(&format!("{}, {}, {}\n", n + 1, 2 * n + 1, 2 * n + 2)));
    text.push_str(
        "*CONNECTOR SECTION, ELSET=A\nCARTESIAN\nO,\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n",
    );
    fs::write(&deck, text).unwrap();
    let wrong = format!("{EXAMPLE}:without_arm");
    let page = stdout(&there(&brief("alike.inp", "--python", &wrong)).assert().code(1));
    assert_eq!(page.matches("diagnosis::geometric-term-missing").count(), 1, "{page}");
    assert!(
        page.contains("alike.inp:1: the same of alike.inp:2, alike.inp:3, alike.inp:4 and 1 more"),
        "{page}"
    );
    assert!(page.contains("5 of 5 connectors wrong"), "{page}");
}

/// A routine that fails at some states is judged at all: it has no numbers there, and where and why is said.
#[test]
fn failures_at_some_states_end_nothing() {
    if !has_python() {
        return;
    }
    let file = elements().join("fails_where_nodes_meet.py");
    let text = format!(
        "from {EXAMPLE} import cartesian\n\n\ndef evaluate(state, connector):\n    given = cartesian(state, connector)\n    \
         1.0 / (0.0 if max(map(abs, state['b']['u'])) < 1e-9 else 1.0)\n    return given\n"
    );
    fs::write(&file, text).unwrap();
    let ran = there(&brief("CARTESIAN", "--python", "fails_where_nodes_meet:evaluate")).assert().code(1);
    let page = stdout(&ran);
    assert!(page.contains("the routine failed at ") && page.contains("ZeroDivisionError"), "{page}");
    assert!(page.contains("[diagnosis::not-a-number]"), "{page}");
}

/// A process in Python: `answer` makes the answer to `message` of whatever `id`.
fn process(name: &str, hello: &str, open: &str, answer: &str, close: &str) -> String {
    let folder = elements();
    let file = folder.join(format!("{name}.py"));
    let text = format!(
        "import json, os, sys, time\nfrom {EXAMPLE} import cartesian as evaluate\nconnector = None\n\
         def right(state):\n    values, rows = evaluate(state, connector)\n    return {{'values': values, 'rows': rows}}\n\
         def each(one):\n    send({{'id': id, 'answers': [one(state) for state in asked['states']]}})\n\
         def send(message):\n    print(json.dumps(message), flush=True)\n\
         count = 0\nfor line in sys.stdin:\n    message = json.loads(line)\n    if 'hello' in message:\n        {hello}\n\
         \x20   elif 'open' in message:\n        connector = message['open']\n        {open}\n\
         \x20   elif 'evaluate' in message:\n        asked = message['evaluate']\n        id, count = asked['id'], count + 1\n        {answer}\n\
         \x20   elif 'close' in message:\n        {close}\n",
    );
    fs::write(&file, text).unwrap();
    format!("exec python3 {}", file.display())
}

const HELLO: &str =
    "send({'hello': {'protocol': 'pintle-candidate/1', 'name': 'mine', 'offers': ['values', 'rows']}})";
const OPEN: &str = "send({'opened': True})";
const ANSWER: &str = "each(right)";
const CLOSE: &str = "break";

/// Every misbehaviour is told as what it is, in time, with exit code 6; nothing of the process is left.
#[test]
fn misbehaviours_are_named() {
    if !has_python() {
        return;
    }
    let cases = [
        (
            "dies-at-hello",
            "sys.exit(3)",
            OPEN,
            ANSWER,
            CLOSE,
            "ended (exit status: 3) when it was to say hello",
        ),
        (
            "other-protocol",
            "send({'hello': {'protocol': 'mine/2', 'name': 'x', 'offers': []}})",
            OPEN,
            ANSWER,
            CLOSE,
            "its protocol is \"mine/2\"",
        ),
        ("no-hello", "send({'hi': 1})", OPEN, ANSWER, CLOSE, "it has no \"hello\""),
        (
            "unknown-key",
            "send({'hello': {'protocol': 'pintle-candidate/1', 'name': 'x', 'offers': ['rows'], 'colour': 1}})",
            OPEN,
            ANSWER,
            CLOSE,
            "unknown field `colour`",
        ),
        (
            "bad-convention",
            "send({'hello': {'protocol': 'pintle-candidate/1', 'name': 'x', 'offers': ['rows'], 'convention': {'columns': ['ux']}}})",
            OPEN,
            ANSWER,
            CLOSE,
            "names \"ux\"",
        ),
        (
            "offers-nothing",
            "send({'hello': {'protocol': 'pintle-candidate/1', 'name': 'x', 'offers': []}})",
            OPEN,
            ANSWER,
            CLOSE,
            "offers nothing",
        ),
        ("refuses", HELLO, "send({'error': 'no CARTESIAN here'})", ANSWER, CLOSE, "no CARTESIAN here"),
        ("opens-nothing", HELLO, "send({'fine': 1})", ANSWER, CLOSE, "is not {\"opened\": true}"),
        (
            "dies",
            HELLO,
            OPEN,
            "sys.exit(9) if count == 5 else each(right)",
            CLOSE,
            "ended (exit status: 9) when it was to answer, at state ",
        ),
        ("is-killed", HELLO, OPEN, "os.kill(os.getpid(), 11)", CLOSE, "signal: 11"),
        ("hangs", HELLO, OPEN, "time.sleep(60)", CLOSE, "did not answer within"),
        ("floods", HELLO, OPEN, "print('x' * 30000000, flush=True)", CLOSE, "longer than 16 MB"),
        (
            "half-a-line",
            HELLO,
            OPEN,
            "sys.stdout.write('{\"id\":'); sys.exit(0)",
            CLOSE,
            "in the middle of a line",
        ),
        (
            "no-text",
            HELLO,
            OPEN,
            "sys.stdout.buffer.write(b'\\xff\\xfe\\n'); sys.stdout.flush()",
            CLOSE,
            "no UTF-8",
        ),
        ("prints", HELLO, OPEN, "print('iteration 1', flush=True)", CLOSE, "belongs on stderr"),
        ("wrong-id", HELLO, OPEN, "send({'id': id + 1, 'answers': []})", CLOSE, "was asked id 1"),
        ("twice", HELLO, OPEN, "[each(right) for _ in range(2)]; time.sleep(0.05)", CLOSE, "a second "),
        ("no-answers", HELLO, OPEN, "send({'id': id})", CLOSE, "\"answers\" is no list"),
        (
            "wrong-count",
            HELLO,
            OPEN,
            "send({'id': id, 'answers': []})",
            CLOSE,
            "has 0 items, and 12 states were asked",
        ),
        (
            "wrong-width",
            HELLO,
            OPEN,
            "each(lambda state: {'values': [1] * 6, 'rows': [[1] * 12] * 6})",
            CLOSE,
            "\"rows\"[0] has 12 items, not 14",
        ),
        (
            "no-number",
            HELLO,
            OPEN,
            "each(lambda state: {'values': ['one'] * 6})",
            CLOSE,
            "is \"one\", not a number",
        ),
        ("fails", HELLO, OPEN, "each(lambda state: {'error': 'singular matrix'})", CLOSE, "singular matrix"),
        ("closes-output", HELLO, OPEN, "os.close(1); time.sleep(60)", CLOSE, "closed its standard output"),
        (
            "changes",
            HELLO,
            OPEN,
            "each(lambda state: {**right(state), 'values': [x if x is None else x + (count > 9) * 1e-17 for x in right(state)['values']]})",
            CLOSE,
            "gave another answer",
        ),
        ("ignores-close", HELLO, OPEN, ANSWER, "time.sleep(60)", "did not end within"),
        ("bad-end", HELLO, OPEN, ANSWER, "sys.exit(4)", "exit status: 4 after it was closed"),
    ];
    for (name, hello, open, answer, close, told) in cases {
        let command = process(name, hello, open, answer, close);
        let mut arguments = brief("CARTESIAN", "--with", &command);
        if name == "hangs" {
            arguments.pop();
            arguments.push("15");
        }
        let message = stderr(&pintle(&arguments).assert().code(6));
        assert!(message.contains(told), "{name}: {message}");
    }
    let message = stderr(&pintle(&brief("CARTESIAN", "--with", "no-such-program-here")).assert().code(6));
    assert!(message.contains("cannot be started"), "{message}");
    assert_eq!(cases.len(), 26);
    let left = std::process::Command::new("ps").args(["-eo", "args"]).output().map(|output| output.stdout);
    let left = String::from_utf8_lossy(&left.unwrap_or_default()).to_string();
    let own: Vec<String> =
        cases.iter().map(|(name, ..)| elements().join(format!("{name}.py")).display().to_string()).collect();
    let left: Vec<&str> =
        left.lines().filter(|line| own.iter().any(|file| line == &format!("python3 {file}"))).collect();
    assert!(left.is_empty(), "{left:?}");
}

/// What a routine has started, in sessions of their own, is ended with it, whether or not it behaves. A shell that waits for it does not
/// hide that it closed its output.
#[cfg(target_os = "linux")]
#[test]
fn nothing_outlives_a_check() {
    if !has_python() {
        return;
    }
    // Seconds that no other run of this test sleeps. The routine goes on when the sleeper is there.
    let sleep = format!("97531.{}", std::process::id());
    let parted = format!(
        "(os.fork() or (os.setsid(), os.fork() or os.execvp('sleep', ['sleep', '{sleep}']), os._exit(0))); \
         import subprocess, pathlib; is_there = lambda: b'sleep {sleep}' in subprocess.run(['ps', '-eo', 'args'], capture_output=True).stdout; \
         any(is_there() or time.sleep(0.05) for _ in range(100)); pathlib.Path(os.environ['SEEN']).write_text(str(is_there()))"
    );
    let seen = Path::new(env!("CARGO_TARGET_TMPDIR")).join("seen");
    let open = format!("{parted}; {OPEN}");
    for (name, answer, code) in [("parts", ANSWER, 0), ("parts-and-hangs", "time.sleep(60)", 6)] {
        let command = process(name, HELLO, &open, answer, CLOSE);
        let mut arguments = brief("CARTESIAN", "--with", &command);
        arguments.pop();
        arguments.push("5");
        let _ = fs::remove_file(&seen);
        pintle(&arguments).env("SEEN", &seen).assert().code(code);
        assert_eq!(fs::read_to_string(&seen).unwrap(), "True", "{name}: the sleeper began");
        let all = std::process::Command::new("ps").args(["-eo", "args"]).output().unwrap().stdout;
        let all = String::from_utf8_lossy(&all).to_string();
        assert!(all.contains("ps -eo") && !all.contains(&format!("sleep {sleep}")), "{name}: {all}");
    }
    let command = process("closes-behind", HELLO, OPEN, "os.close(1); time.sleep(60)", CLOSE);
    let behind = format!("true; {}; true", command.trim_start_matches("exec "));
    let mut arguments = brief("CARTESIAN", "--with", &behind);
    arguments.pop();
    arguments.push("2");
    let message = stderr(&pintle(&arguments).assert().code(6));
    assert!(message.contains("closed its standard output"), "{message}");
    // One that waits for a program of its own has not: it is slow.
    let waits = "import subprocess; subprocess.run(['sleep', '60'], stdout=subprocess.DEVNULL)";
    let command = process("waits", HELLO, OPEN, waits, CLOSE);
    let mut arguments = brief("CARTESIAN", "--with", &command);
    arguments.pop();
    arguments.push("2");
    let message = stderr(&pintle(&arguments).assert().code(6));
    assert!(
        !message.contains("closed its standard output") && message.contains("did not answer within 2"),
        "{message}"
    );
}

/// What a routine declares of its conventions is undone; what it does not offer is not asked of it.
#[test]
fn conventions_are_undone() {
    if !has_python() {
        return;
    }
    let hello = |convention: &str| {
        format!(
            "send({{'hello': {{'protocol': 'pintle-candidate/1', 'name': 'mine', 'offers': ['values', 'rows'], 'convention': {convention}}}}})"
        )
    };
    let changed = |change: &str| {
        format!("def one(state): answer = right(state); {change}; return answer\n        each(one)")
    };
    let turned = "M = lambda n: list(map(list, zip(*[[sum(state[n]['triad'][k][i] * connector['initial'][n]['triad'][k][j] for k in range(3)) for j in range(3)] for i in range(3)]))); \
                  answer['rows'] = [r and r[:3] + [sum(M('a')[i][j] * r[3 + j] for j in range(3)) for i in range(3)] + r[6:] for r in answer['rows']]";
    let total = "import math; p = state['a']['rotation_vector']; t = math.hypot(*p); K = [[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]]; \
                 e, f = ((1 - math.cos(t)) / t ** 2, (t - math.sin(t)) / t ** 3) if t > 1e-2 else (0.5 - t * t / 24 + t ** 4 / 720, 1 / 6 - t * t / 120 + t ** 4 / 5040); \
                 J = [[(i == j) + e * K[i][j] + f * sum(K[i][k] * K[k][j] for k in range(3)) for j in range(3)] for i in range(3)]; \
                 answer['rows'] = [r and r[:3] + [sum(r[3 + i] * J[i][j] for i in range(3)) for j in range(3)] + r[6:] for r in answer['rows']]";
    let cases = [
        (
            "signs",
            "{'factors': [-1, 2, 1, 1, 1, 1]}".to_string(),
            "answer['values'][0] *= -1; answer['rows'][0] = [-x for x in answer['rows'][0]]; answer['values'][1] *= 2; answer['rows'][1] = [2 * x for x in answer['rows'][1]]",
        ),
        (
            "columns",
            "{'columns': ['b.u1', 'b.u2', 'b.u3', 'a.u1', 'a.u2', 'a.u3', 'a.ur1', 'a.ur2', 'a.ur3']}"
                .to_string(),
            "answer['rows'] = [r and r[7:10] + r[:6] for r in answer['rows']]",
        ),
        (
            "stored",
            "{'storage': 'columns'}".to_string(),
            "answer['rows'] = [[r and r[j] for r in answer['rows']] for j in range(14)]",
        ),
        ("length", "{'length': 0.001}".to_string(), "pass"),
        (
            "degrees",
            "{'column_angles': 'deg'}".to_string(),
            "answer['rows'] = [r and [x * (0.017453292519943295 if j % 7 in (3, 4, 5) else 1) for j, x in enumerate(r)] for r in answer['rows']]",
        ),
        ("total", "{'rotations': 'total-vector'}".to_string(), total),
        ("body", "{'rotations': 'body'}".to_string(), turned),
    ];
    for (name, convention, change) in cases {
        let right = process(name, &hello(&convention), OPEN, &changed(change), CLOSE);
        pintle(&brief("CARTESIAN", "--with", &right)).assert().success();
        // Undeclared, it is wrong, but for a length that is the unit of everything.
        let undeclared = process(&format!("{name}-not"), HELLO, OPEN, &changed(change), CLOSE);
        let code = match name {
            "length" => 0,
            "columns" | "stored" => 6,
            _ => 1,
        };
        pintle(&brief("CARTESIAN", "--with", &undeclared)).assert().code(code);
    }
    // Of some components only: of TRANSLATOR the translations.
    let some = HELLO.replace("]}})", "], 'components': ['u1', 'u2', 'u3']}})");
    let part = process("components", &some, OPEN, ANSWER, CLOSE);
    let message = stdout(&pintle(&brief("TRANSLATOR", "--with", &part)).assert().success());
    assert!(message.contains("ur1, ur2, ur3"), "{message}");
    // What is never asked is told, of types that have it.
    assert!(message.contains("misaligned initial axes are another branch of TRANSLATOR"), "{message}");
    let rows = HELLO.replace("'values', ", "");
    let alone = process("rows-alone", &rows, OPEN, ANSWER, CLOSE);
    pintle(&brief("CARTESIAN", "--with", &alone)).assert().success();
    let outside = "each(lambda state: {'out_of_domain': 'small turns only'} if state['a']['u'][0] > 0.1 else right(state))";
    let some = process("outside", &rows, OPEN, outside, CLOSE);
    let message = stdout(&pintle(&brief("CARTESIAN", "--with", &some)).assert().success());
    assert!(message.lines().count() <= 25, "{message}");
    assert!(message.contains("outside the domain of the routine"), "{message}");
    assert!(!message.contains("misaligned initial axes"), "{message}");
    // One that covers no state is not right.
    let refuses = "each(lambda state: {'out_of_domain': 'nowhere'})";
    let none = process("nowhere", &rows, OPEN, refuses, CLOSE);
    pintle(&brief("CARTESIAN", "--with", &none)).assert().code(4);
    let help = stdout(&pintle(&["check", "--help"]).assert().success());
    assert!(help.contains("4 the routine covers no\nstate"), "{help}");
}
