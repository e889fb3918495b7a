//! One verdict and one sentence through every door: routines in Python, in C, and behind JSON lines.

mod corpus;

use crate::commands::cli::{pintle, stdout};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Routines whose mistake is the environment's WRONG; each in Python, then in C.
const PYTHON: &str = r#"
import math, os, sys, json
WRONG = os.environ.get("WRONG", "")
OFFERS = {"SLIDE": ["criterion", "gradients"]}.get(os.environ.get("OF"), ["values", "rows"])
def dot(v, w): return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]
def cross(v, w): return [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]]
def cartesian(state, connector):
    a, b, initial = state["a"], state["b"], connector["initial"]
    d = [float(b["x"][i]) - float(a["x"][i]) for i in range(3)]
    values, rows = [None] * 6, [None] * 6
    for k in range(3):
        e, e0 = [[float(x) for x in axes["triad"][k]] for axes in (a, initial["a"])]
        d0 = [float(initial["b"]["x"][i]) - float(initial["a"]["x"][i]) for i in range(3)]
        arm = [0.0] * 3 if WRONG == "arm" else cross(e, d)
        values[k] = dot(e, d) - dot(e0, d0)
        rows[k] = [-e[0], -e[1], -e[2], *arm, 0.0, *e, 0.0, 0.0, 0.0, 0.0]
    return values, rows
def pin(state, constraint):
    s, m, x = state["S"], state["M"], constraint["initial"]
    arm = [float(x["S"]["x"][i]) - float(x["M"]["x"][i]) for i in range(3)]
    values, rows = [None] * 7, [None] * 7
    for i in range(3):
        carried = sum(float(m["triad"][j][i]) * arm[j] for j in range(3))
        values[i] = float(s["x"][i]) - float(m["x"][i]) - (carried if WRONG == "turned" else arm[i])
        row = [0.0] * 14
        row[i], row[7 + i] = 1.0, -1.0
        rows[i] = row
    return values, rows
def slide(state, friction):
    f, mu = [float(x) for x in state["forces"]], friction["coefficient"]
    internal = friction["parameters"]["F_C^int"]
    p = abs(f[1]) + abs(f[2]) if WRONG == "sum" else math.hypot(f[1], f[2])
    n = abs(abs(f[0]) + internal)
    sign = math.copysign(1.0, f[0])
    of_p = [0.0] * 6
    for k in (1, 2):
        of_p[k] = (0.0 if f[k] == 0 else math.copysign(1.0, f[k])) if WRONG == "sum" else f[k] / (p or 1.0)
    of_n = [sign, 0.0, 0.0, 0.0, 0.0, 0.0]
    return {"criterion": [p, abs(f[0]), n, p - mu * n],
            "gradients": [of_p, of_n, of_n, [x - mu * y for x, y in zip(of_p, of_n)]]}
if __name__ == "__main__":
    routine, own = {"PIN": pin, "SLIDE": slide}.get(os.environ.get("OF"), cartesian), None
    def plain(x): return [plain(y) for y in x] if isinstance(x, list) else x
    for line in sys.stdin:
        message = json.loads(line)
        if "hello" in message:
            answer = {"hello": {"protocol": "pintle-candidate/1", "name": "mine", "offers": OFFERS}}
        elif "open" in message:
            own, answer = message["open"], {"opened": True}
        elif "evaluate" in message:
            answers = []
            for state in message["evaluate"]["states"]:
                given = routine(state, own)
                answers.append(given if isinstance(given, dict) else {"values": given[0], "rows": given[1]})
            answer = {"id": message["evaluate"]["id"], "answers": answers}
        else:
            break
        print(json.dumps(answer), flush=True)
"#;

const C: &str = r#"
#include "pintle_element.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
static int is(const char *what) { const char *wrong = getenv("WRONG"); return wrong && !strcmp(wrong, what); }
static void cross(const double *v, const double *w, double *u) {
    for (int i = 0; i < 3; i++) u[i] = v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3];
}
#ifdef CARTESIAN
const unsigned pintle_offers = PINTLE_VALUES | PINTLE_ROWS;
int pintle_element(const pintle_connector *connector, const pintle_state *state, unsigned want, double *svars,
                   pintle_numbers *numbers) {
    for (int k = 0; k < 3; k++) {
        const double *e0 = connector->triad[0][k], *e = state->a.triad[k];
        double d[3], d0[3], arm[3], row[14] = {0};
        for (int i = 0; i < 3; i++) {
            d[i] = state->b.x[i] - state->a.x[i];
            d0[i] = connector->x[1][i] - connector->x[0][i];
        }
        cross(e, d, arm);
        for (int i = 0; i < 3; i++) {
            row[i] = -e[i];
            row[7 + i] = e[i];
            row[3 + i] = is("arm") ? 0 : arm[i];
        }
        numbers->values[k] = e[0] * d[0] + e[1] * d[1] + e[2] * d[2] - (e0[0] * d0[0] + e0[1] * d0[1] + e0[2] * d0[2]);
        memcpy(numbers->rows[k], row, sizeof row);
    }
    return 0;
}
#elif defined PIN
const unsigned pintle_offers = PINTLE_VALUES | PINTLE_ROWS;
const char *const pintle_convention = "{\"columns\": [\"S.u1\", \"S.u2\", \"S.u3\", \"M.u1\", \"M.u2\", \"M.u3\"]}";
int pintle_mpc(const pintle_constraint *constraint, const pintle_mpc_state *state, unsigned want,
               pintle_mpc_numbers *numbers) {
    double arm[3];
    for (int i = 0; i < 3; i++) arm[i] = constraint->x[0][i] - constraint->x[1][i];
    for (int i = 0; i < 3; i++) {
        double carried = 0, *row = numbers->rows[i];
        for (int j = 0; j < 3; j++) carried += state->m.triad[j][i] * arm[j];
        numbers->values[i] = state->s.x[i] - state->m.x[i] - (is("turned") ? carried : arm[i]);
        for (int j = 0; j < 3; j++) {
            row[j] = i == j;
            row[3 + j] = -(i == j);
        }
    }
    return 0;
}
#else
const unsigned pintle_offers = PINTLE_CRITERION | PINTLE_GRADIENTS;
int pintle_friction(const pintle_friction_data *friction, const pintle_friction_state *state, unsigned want,
                    pintle_friction_numbers *numbers) {
    const double *f = state->forces;
    double mu = friction->coefficient, p, n = fabs(fabs(f[0]) + friction->parameters[0]);
    p = is("sum") ? fabs(f[1]) + fabs(f[2]) : hypot(f[1], f[2]);
    numbers->criterion[0] = p;
    numbers->criterion[1] = fabs(f[0]);
    numbers->criterion[2] = n;
    numbers->criterion[3] = p - mu * n;
    memset(numbers->gradients, 0, sizeof numbers->gradients);
    for (int k = 1; k < 3; k++)
        numbers->gradients[0][k] = is("sum") ? (f[k] > 0) - (f[k] < 0) : p == 0 ? 0 : f[k] / p;
    numbers->gradients[1][0] = numbers->gradients[2][0] = copysign(1, f[0]);
    for (int j = 0; j < 6; j++) numbers->gradients[3][j] = numbers->gradients[0][j] - mu * numbers->gradients[2][j];
    return 0;
}
#endif
"#;

/// What is asked, what is wrong, and the code of the cause that must be told; none of a right routine.
const SAMPLE: [(&str, &str, Option<&str>); 6] = [
    ("CARTESIAN", "", None),
    ("CARTESIAN", "arm", Some("geometric-term-missing")),
    ("MPC PIN", "", None),
    ("MPC PIN", "turned", Some("initial-separation-turned")),
    ("FRICTION SLIDE-PLANE", "", None),
    ("FRICTION SLIDE-PLANE", "sum", Some("sum-for-norm")),
];

/// A folder with these files, and the header.
fn folder(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = crate::commands::cli::folder(name);
    let header = stdout(&pintle(&["check", "--header"]).assert().success());
    for (file, text) in files.iter().copied().chain([("pintle_element.h", header.as_str())]) {
        fs::write(folder.join(file), text).unwrap();
    }
    folder
}

/// Builds NAME.so of a file, with NAME defined.
fn library(folder: &Path, file: &str, name: &str) {
    let (define, output) = (format!("-D{name}"), format!("{name}.so"));
    let built = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", &define, "-o", &output, file, "-lm"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
}

/// Whether there is no Python or no compiler, which is said.
fn lacks_programs() -> bool {
    let has = |program: &str| Command::new(program).arg("--version").output().is_ok();
    let lacking: Vec<&str> = ["python3", "cc"].into_iter().filter(|program| !has(program)).collect();
    if !lacking.is_empty() {
        assert!(std::env::var_os("CI").is_none(), "CI has no {}", lacking.join(", "));
        eprintln!("SKIPPED: there is no {}", lacking.join(", "));
    }
    !lacking.is_empty()
}

/// The verdict of each quantity, with the causes in words.
type Said = BTreeMap<String, (Vec<String>, Vec<String>)>;

fn asked(folder: &Path, of: &str, wrong: &str, door: &[&str]) -> (i32, Said) {
    let few = ["--states", "12", "--near-singular-states", "0", "--wide-states", "6", "--histories", "0"];
    let arguments = [&["check", of], door, &few, &["--timeout", "60", "--format", "json"]].concat();
    let mut command = pintle(&arguments);
    let kind = of.strip_prefix("MPC ").unwrap_or(if of.starts_with("FRICTION") { "SLIDE" } else { of });
    let output = command.current_dir(folder).env("WRONG", wrong).env("OF", kind).output().unwrap();
    let code = output.status.code().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).to_string();
    let report: Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|why| panic!("{of} {wrong}: {why}: {errors}"));
    let mut said = Said::new();
    for check in report["subjects"][0]["checks"].as_array().unwrap() {
        let entry = said.entry(check["quantity"].as_str().unwrap().to_string()).or_default();
        entry.0.push(format!("{} {}", check["against"], check["verdict"]));
        for cause in check["diagnosis"]["causes"].as_array().into_iter().flatten() {
            let [sentence, code] = ["sentence", "code"].map(|key| cause[key].as_str().unwrap());
            entry.1.push(format!("{sentence} [{code}]"));
        }
    }
    (code, said)
}

/// Every door says the same of every routine of the sample: exit code, verdicts, causes in words.
#[test]
fn every_door_says_the_same() {
    if lacks_programs() {
        return;
    }
    let folder = folder("doors", &[("mine.py", PYTHON), ("mine.c", C)]);
    ["CARTESIAN", "PIN", "SLIDE"].into_iter().for_each(|name| library(&folder, "mine.c", name));
    let mut sentences = 0;
    for (of, wrong, cause) in SAMPLE {
        let (routine, library) = match of {
            "CARTESIAN" => ("mine:cartesian", "./CARTESIAN.so"),
            "MPC PIN" => ("mine:pin", "./PIN.so"),
            _ => ("mine:slide", "./SLIDE.so"),
        };
        let by_lines = asked(&folder, of, wrong, &["--with", "exec python3 mine.py"]);
        let by_python = asked(&folder, of, wrong, &["--python", routine]);
        let by_c = asked(&folder, of, wrong, &["--library", library]);
        let (code, said) = &by_lines;
        assert_eq!(*code, i32::from(cause.is_some()), "{of} {wrong}: {said:?}");
        let is_told = |cause: &str| {
            said.values()
                .any(|(_, told)| told.iter().any(|told| told.contains(&format!("[diagnosis::{cause}]"))))
        };
        assert!(cause.is_none_or(is_told), "{of} {wrong}: {cause:?} is not among {said:#?}");
        assert_eq!(by_lines, by_python, "{of} {wrong}: JSON lines and Python");
        assert_eq!(by_lines, by_c, "{of} {wrong}: JSON lines and C");
        sentences += said.values().map(|(_, told)| told.len()).sum::<usize>();
    }
    assert!(sentences >= 3, "{sentences}");
}
