//! Large scenes: an even share within a budget, which every form of the report says; and what is said of many connectors, said once.

use crate::commands::cli::{pintle, stderr, stdout};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

/// A file of that name.
fn file(name: &str, text: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("sample_{name}"));
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

/// A row of connectors, each with a section of its own, with `states` of their nodes.
fn row(name: &str, kind: &str, count: usize, states: usize) -> [String; 2] {
    let mut deck = "*NODE\n".to_string();
    (0..2 * count).for_each(|i| writeln!(deck, "{}, {i}., 0.5, 0.", i + 1).unwrap());
    for i in 0..count {
        writeln!(deck, "*ELEMENT, TYPE=CONN3D2, ELSET=E{i}\n{}, {}, {}", i + 1, 2 * i + 1, 2 * i + 2)
            .unwrap();
        writeln!(deck, "*CONNECTOR SECTION, ELSET=E{i}\n{kind}").unwrap();
    }
    let mut rows = "state,node,u1,ur1,ur2\n".to_string();
    for state in 0..states {
        for node in 1..=2 * count {
            writeln!(rows, "{state},{node},0.0{state},0.{state}{},0.1", node % 7).unwrap();
        }
    }
    [file(&format!("{name}.inp"), &deck), file(&format!("{name}.csv"), &rows)]
}

/// A budget judges a share, and no form of the report presents it as the whole; `--strict` does not pass it.
#[test]
fn a_share_is_never_the_whole() {
    let [deck, states] = row("share", "ROTATION", 400, 3);
    let run = |more: &[&str]| {
        let words = [&["audit", &deck, "--at", &states, "--budget", "1s"], more].concat();
        let assert = pintle(&words).assert();
        let code = assert.get_output().status.code().unwrap();
        (code, stdout(&assert), stderr(&assert))
    };
    let (code, page, said) = run(&[]);
    assert_eq!(code, 0, "{page}");
    assert!(page.contains("only a sample of") && page.contains("nothing is said of the others"), "{page}");
    let last = page.trim_end().lines().last().unwrap();
    assert!(
        last.starts_with("no mismatch in the sample; ") && last.contains("of 1200 connector states"),
        "{last}"
    );
    assert!(said.contains("of 1200 connector states") && said.contains("about"), "{said}");
    let (code, text, _) = run(&["--format", "json"]);
    let document: Value = serde_json::from_str(&text).unwrap();
    let share = &document["sampled"][0];
    let [judged, all] = ["states", "of_states"].map(|key| share[key].as_u64().unwrap());
    assert!(code == 0 && judged > 0 && judged < all && all == 1200, "{share}");
    let subjects = document["subjects"].as_array().unwrap();
    let cases: u64 = subjects.iter().map(|subject| subject["cases"].as_u64().unwrap()).sum();
    assert_eq!((cases, subjects.len() as u64), (judged, share["connectors"].as_u64().unwrap()));
    // The sample is even: no half of the row is without its share.
    let number = |subject: &Value| {
        subject["name"].as_str().unwrap().rsplit_once(' ').unwrap().1.parse::<u64>().unwrap()
    };
    let low = subjects.iter().filter(|subject| number(subject) <= 200).count();
    assert!(low * 4 >= subjects.len() && low * 4 <= 3 * subjects.len() + 4, "{low} of {}", subjects.len());
    for (format, words) in
        [("junit", "only a sample of"), ("markdown", "only a sample of"), ("html", "judged by a sample")]
    {
        let (_, text, _) = run(&["--format", format]);
        assert!(text.contains(words), "{format}");
    }
    let (code, page, _) = run(&["--strict"]);
    assert_eq!(code, 3, "{page}");
    // What fits is judged whole, and nothing is said of samples.
    let [deck, states] = row("whole", "BEAM", 3, 2);
    let whole = stdout(&pintle(&["audit", &deck, "--at", &states, "--budget", "5m"]).assert().code(0));
    assert!(!whole.contains("in the sample") && !whole.contains("only a sample"), "{whole}");
    for time in ["0s", "soon", "-1s", "5d"] {
        pintle(&["audit", &deck, "--budget", time]).assert().code(2);
    }
}

/// 60 connectors with the same fault are one finding with its entry; so are 60 notes with the same words. Each stands in JSON, and
/// under `-v`.
#[test]
fn what_is_said_of_many_is_said_once() {
    let [deck, states] = row("many", "ROTATION", 60, 2);
    let words = ["audit", &deck, "--at", &states, "--wide-states", "1", "--plant", "wrong-entry", "--format"];
    let run = |more: &[&str]| stdout(&pintle(&[&words[..], more].concat()).assert().code(1));
    let page = run(&["human"]);
    assert!(page.contains("ROTATION 1, ROTATION 2, ROTATION 3 and 57 more of"), "{page}");
    assert!(page.matches("must be").count() <= 4, "{page}");
    assert!(page.contains("told by ") && page.contains(" too"), "{page}");
    assert_eq!(page.matches("note[model::orientation-default]").count(), 1, "{page}");
    assert!(page.contains("and 59 more of this code: element 2, element 3, element 4, …"), "{page}");
    assert!(page.contains("ROTATION × 60"), "{page}");
    let whole = run(&["human", "-v"]);
    assert_eq!(whole.matches("note[model::orientation-default]").count(), 60);
    assert!(whole.matches("must be").count() >= 60 && whole.contains("ROTATION 37"));
    let document: Value = serde_json::from_str(&run(&["json"])).unwrap();
    let findings = document["models"][0]["findings"].as_array().unwrap();
    let notes = findings.iter().filter(|finding| finding["code"] == "model::orientation-default");
    assert_eq!((notes.count(), document["mismatches"].as_u64()), (60, Some(60)));
    let page = run(&["html"]);
    assert!(page.contains("ROTATION 1, ROTATION 2, ROTATION 3 and 57 more of"));
    assert!(page.matches("class=\"problem\"").count() <= 4, "{}", page.matches("class=\"problem\"").count());
}

/// Numbers are short: a quotient of them is shown as it would be written by hand.
#[test]
fn numbers_are_written_as_by_hand() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\nBEAM\n";
    let (deck, states) = (file("short.inp", deck), file("short.csv", "state,node,u1\n0,2,0.8\n"));
    let page = stdout(&pintle(&["audit", &deck, "--at", &states, "--model-only"]).assert().code(0));
    assert!(page.contains("u1 is constrained, and is 0.8 off at state 0"), "{page}");
    let words = ["audit", &deck, "--at", &states, "--wide-states", "1", "--plant", "wrong-sign"];
    let page = stdout(&pintle(&words).assert().code(1));
    assert!(
        page.contains(": 1, must be -1, tolerance ") || page.contains(": -1, must be 1, tolerance "),
        "{page}"
    );
}

/// A page begins with one sentence for those who do not know its words.
#[test]
fn a_page_begins_with_a_sentence() {
    let deck = |more: &str| {
        format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\n{more}"
        )
    };
    let page = |name: &str, more: &str, code: i32| {
        let words = ["audit", &file(name, &deck(more)), "--model-only", "--format", "html"];
        stdout(&pintle(&words).assert().code(code))
    };
    for (name, more, code, sentence) in [
        ("beam.inp", "BEAM\n*BOUNDARY\n1, 1, 6\n", 0, "The model is sound; nothing was found"),
        ("axial.inp", "AXIAL\n*BOUNDARY\n1, 1, 3\n", 0, "The model is sound; one remark"),
    ] {
        let page = page(name, more, code);
        let first = page.find(sentence).unwrap_or_else(|| panic!("{sentence}: {page}"));
        let detail = page.find("<h2").unwrap_or(page.len());
        assert!(first < detail, "{name}: {first} {detail}");
    }
}

/// Without states on 237 bits nobody judges constraints, and that is undecided. Of a coupling of many nodes the report says how many of their
/// columns are compared.
#[test]
fn what_is_not_compared_of_constraints_is_said() {
    let mut deck = "*NODE\n100, 0., 0., 1.\n".to_string();
    for node in 1..=20_u8 {
        let angle = f64::from(node);
        deck += &format!("{node}, {:.6}, {:.6}, {:.6}\n", angle.cos(), angle.sin(), 0.01 * angle);
    }
    deck += "*NSET, NSET=ALL, GENERATE\n1, 20\n*SURFACE, TYPE=NODE, NAME=S\nALL,\n*COUPLING, REF NODE=100, CONSTRAINT NAME=C, SURFACE=S\n\
             *DISTRIBUTING\n*NODE\n200, 0., 0., 0.\n*MPC\nPIN, 200, 100\n";
    let deck = file("compared.inp", &deck);
    let subjects = |wide: &str, code: i32| -> Vec<Value> {
        let words = ["audit", &deck, "--wide-states", wide, "--format", "json"];
        let document: Value = serde_json::from_str(&stdout(&pintle(&words).assert().code(code))).unwrap();
        document["subjects"].as_array().unwrap().clone()
    };
    let judged = subjects("1", 0);
    let names: Vec<&str> = judged.iter().map(|subject| subject["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["MPC PIN 200-100", "DISTRIBUTING COUPLING 100 (columns of 8 of its 21 nodes)"]);
    assert!(judged.iter().all(|subject| !subject["checks"].as_array().unwrap().is_empty()));
    for subject in subjects("0", 4) {
        assert_eq!(subject["checks"].as_array().unwrap().len(), 0, "{subject}");
        assert_eq!(subject["derivative"], "undecided", "{subject}");
    }
}

/// A zero has no sign where people read it. JSON is exact.
#[test]
fn zeros_have_no_sign() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n\
        *CONNECTOR SECTION, ELSET=E\nCARTESIAN, CARDAN\n*MPC\nREVOLUTE, 2, 1, 3\n";
    let (deck, states) =
        (file("zeros.inp", deck), file("zeros.csv", "state,node,u1,u2,ur3\n0,2,-0.0,-0.0,0.5\n"));
    for format in ["csv", "human"] {
        let page = stdout(
            &pintle(&["eval", &deck, "--states", &states, "--order", "2", "--format", format])
                .assert()
                .code(0),
        );
        let is_number = |c: char| c.is_ascii_digit() || matches!(c, '-' | '.' | 'e');
        let cells = page.split(|c: char| !is_number(c)).filter(|cell| cell.contains('0'));
        let signed: Vec<&str> = cells.filter(|cell| matches!(*cell, "-0" | "-0.0")).collect();
        assert_eq!(signed, Vec::<&str>::new(), "{format}: {page}");
        assert!(page.contains("0.5"), "{page}");
    }
}

/// Elements that are not read may hold what moves: the audit does not ask to hold it.
#[test]
fn what_is_not_read_is_not_asked_to_be_held() {
    let deck = |more: &str| {
        format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n{more}\
             *CONNECTOR SECTION, ELSET=E\nAXIAL\n*BOUNDARY\n1, 1, 3\n"
        )
    };
    let page = |name: &str, more: &str| {
        stdout(&pintle(&["audit", &file(name, &deck(more)), "--model-only"]).assert().code(0))
    };
    let alone = page("alone.inp", "");
    assert!(alone.contains("in statics, hold or drive the motion"), "{alone}");
    let beside = page("beside.inp", "*ELEMENT, TYPE=B31\n7, 2, 3\n");
    assert!(!beside.contains("hold or drive"), "{beside}");
    let beside = beside.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(beside.contains("elements that are not read (B31) may hold it"), "{beside}");
    // Elsewhere they hold nothing that moves here.
    let apart = page("apart.inp", "*NODE\n8, 9., 0., 0.\n9, 9., 1., 0.\n*ELEMENT, TYPE=B31\n7, 8, 9\n");
    assert!(apart.contains("in statics, hold or drive the motion") && !apart.contains("B31) may"), "{apart}");
}

/// `eval` flags what the state violates, and says what holds it.
#[test]
fn residuals_are_flagged() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=A\n1., 0., 0., 0., 1., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\nTRANSLATOR\nA,\n\
        *STEP\n*STATIC\n1., 1.\n*CONNECTOR MOTION\n101, 1, 0.5\n*END STEP\n";
    let deck = file("flags.inp", deck);
    let flags = |rows: &str| -> Vec<Value> {
        let states = file("flags.csv", &format!("state,time,node,u1,u2\n{rows}"));
        let text =
            stdout(&pintle(&["eval", &deck, "--states", &states, "--format", "json"]).assert().code(0));
        let document: Value = serde_json::from_str(&text).unwrap();
        document["scenes"][0]["states"][0]["connectors"][0]["flags"].as_array().cloned().unwrap_or_default()
    };
    assert_eq!(flags("0,1,2,0.5,0\n"), Vec::<Value>::new());
    // What six digits leave is no violation.
    assert_eq!(flags("0,1,2,0.5000005,0.0000005\n"), Vec::<Value>::new());
    let told = flags("0,1,2,0.4,0.01\n");
    let said: Vec<(&str, &str)> =
        told.iter().map(|flag| (flag["component"].as_str().unwrap(), flag["by"].as_str().unwrap())).collect();
    assert_eq!(said, [("u1", "motion"), ("u2", "constraint")], "{told:?}");
    assert!(told.iter().all(|flag| flag["flag"] == "off-constraint"), "{told:?}");
    let states = file("flags.csv", "state,time,node,u1,u2\n0,1,2,0.4,0.01\n");
    let page = stdout(&pintle(&["eval", &deck, "--states", &states]).assert().code(0));
    assert!(page.contains("u1 is driven by a connector motion, and is -0.1 off"), "{page}");
    // A node that a later state leaves out is told once.
    let states = file("vanish.csv", "state,time,node,u1\n0,0,2,0.1\n1,0.5,1,0\n2,1,1,0\n");
    let told = stderr(&pintle(&["eval", &deck, "--states", &states]).assert().code(0));
    assert!(told.contains("model::node-vanishes") && told.contains("state 1 leaves out node 2"), "{told}");
    // So are angles in degrees, the largest of them.
    let states = file("degrees.csv", "state,time,node,ur1\n0,0,2,45\n1,0.5,2,90\n");
    let told = stderr(&pintle(&["eval", &deck, "--states", &states]).assert().code(0));
    assert!(
        told.contains("model::degrees") && told.contains("state 1 turns node 2 by 90 (and 1 more"),
        "{told}"
    );
    let states = file("degrees.csv", "state,time,node,ur1\n0,0,2,0.785\n1,0.5,2,1.571\n");
    let told = stderr(&pintle(&["eval", &deck, "--states", &states]).assert().code(0));
    assert!(!told.contains("degrees"), "{told}");
}

/// So are the residuals of MPCs and relations, each by its own name.
#[test]
fn residuals_of_constraints_are_flagged() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 5., 0., 0.\n5, 1., 2., 0.\n\
        *NSET, NSET=BODY\n2,\n*NSET, NSET=CLOUD\n2, 3, 5\n*NSET, NSET=ALL\n1, 2, 3, 4, 5\n\
        *MPC\nPIN, 3, 1\n*EQUATION\n2\n4, 1, 2., 3, 1, -1.\n*RIGID BODY, REF NODE=1, PIN NSET=BODY\n\
        *SURFACE, TYPE=NODE, NAME=S\nCLOUD,\n\
        *COUPLING, REF NODE=4, CONSTRAINT NAME=C, SURFACE=S\n*DISTRIBUTING\n";
    let deck = file("constraints.inp", deck);
    let flags = |rows: &str| -> Vec<String> {
        let states = file("constraints.csv", &format!("state,time,node,u1,u2\n{rows}"));
        let text =
            stdout(&pintle(&["eval", &deck, "--states", &states, "--format", "json"]).assert().code(0));
        let document: Value = serde_json::from_str(&text).unwrap();
        let state = &document["scenes"][0]["states"][0];
        let of = |kind: &str| state[kind].as_array().cloned().unwrap_or_default();
        let all: Vec<Value> = of("mpcs").into_iter().chain(of("relations")).collect();
        assert_eq!(all.len(), 4, "{state}");
        let told = |(place, one): (usize, &Value)| -> Vec<String> {
            let flags = one["flags"].as_array().cloned().unwrap_or_default();
            let name = |flag: &Value| {
                assert_eq!(flag["flag"], "off-constraint", "{flag}");
                format!("{place} {}", flag["component"].as_str().unwrap())
            };
            flags.iter().map(name).collect()
        };
        all.iter().enumerate().flat_map(told).collect()
    };
    assert_eq!(flags("0,1,1,0,0\n"), Vec::<String>::new());
    // Everything moves by 0.5, but for the sixth digit, and the equation halves that.
    let moved =
        |last: &str| format!("0,1,1,0.5,0\n0,1,2,0.5,0.0000009\n0,1,3,0.5,0\n0,1,5,0.5,0\n0,1,4,{last},0\n");
    assert_eq!(flags(&moved("0.5")), ["1 g"]);
    assert_eq!(flags(&moved("0.2500004")), ["3 δ1"]);
    let off = "0,1,1,0,0\n0,1,2,0.1,0\n0,1,3,0,0.1\n0,1,5,0,0\n0,1,4,0,0\n";
    assert_eq!(flags(off), ["0 δ2", "2 δ1", "3 δ1", "3 δ2", "3 ρ3"]);
}

/// 200 warnings in the same words are one, with a count, wherever a scene is read.
#[test]
fn warnings_are_shown_once() {
    let mut deck =
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n".to_string();
    for i in 0..30 {
        let elasticity = "*CONNECTOR ELASTICITY, COMPONENT=1\n-5.,\n";
        writeln!(deck, "*CONNECTOR BEHAVIOR, NAME=B{i}\n{elasticity}").unwrap();
    }
    deck = deck.replace("\n\n", "\n") + "*CONNECTOR SECTION, ELSET=E, BEHAVIOR=B0\nAXIAL\n";
    let told = stderr(&pintle(&["eval", &file("warned.inp", &deck)]).assert().code(0));
    assert_eq!(told.matches("is negative").count(), 1, "{told}");
    assert!(told.contains("model::negative-stiffness 29 more times"), "{told}");
}

/// The keys of a JSON document.
fn keys(of: &Value, found: &mut BTreeSet<String>) {
    match of {
        Value::Object(all) => all.iter().for_each(|(key, below)| {
            found.insert(key.clone());
            keys(below, found);
        }),
        Value::Array(all) => all.iter().for_each(|below| keys(below, found)),
        _ => {}
    }
}

/// Every key that JSON documents have, and every flag and every option, is explained. Elements and nodes, which are keys too, are not.
#[test]
fn every_key_and_flag_is_explained() {
    let mut found = BTreeSet::new();
    let driven = concat!(env!("CARGO_MANIFEST_DIR"), "/verify/findings/constraint-violated-driven");
    let [deck, states] = ["inp", "csv"].map(|ending| format!("{driven}.{ending}"));
    for words in [
        &["eval", "gallery:seat_belt", "--show", "3", "--order", "2", "--format", "json"][..],
        &[
            "eval",
            "gallery:slider_crank",
            "--show",
            "3",
            "--order",
            "2",
            "--outputs",
            "ALL",
            "--format",
            "json",
        ],
        &["eval", &deck, "--states", &states, "--format", "json"],
        &[
            "audit",
            "gallery:revolute_mpc",
            "--wide-states",
            "1",
            "--plant",
            "wrong-entry",
            "--format",
            "json",
        ],
        &["audit", &deck, "--at", &states, "--model-only", "--format", "json"],
    ] {
        let output = pintle(words).output().unwrap();
        keys(&serde_json::from_slice(&output.stdout).unwrap(), &mut found);
    }
    let is_word = |key: &&String| key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    let is_name = |key: &&String| key.contains(|c: char| c.is_ascii_lowercase()) && !key.contains("::");
    let asked: Vec<&String> = found.iter().filter(is_word).filter(is_name).collect();
    let lacking: Vec<&&String> =
        asked.iter().filter(|key| pintle_report::glossary::of(key).is_empty()).collect();
    assert!(lacking.is_empty() && asked.len() > 150, "{} asked, without a meaning: {lacking:?}", asked.len());
    let flags = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/src/kinematics/connector/flags.rs"))
        .unwrap();
    let names: Vec<&str> = flags
        .lines()
        .filter_map(|line| {
            line.trim().strip_prefix("Self::")?.split_once("{ .. } => \"")?.1.split('"').next()
        })
        .collect();
    let lacking: Vec<&&str> =
        names.iter().filter(|name| pintle_report::glossary::of(name).is_empty()).collect();
    assert!(lacking.is_empty() && names.len() > 15, "{names:?}: {lacking:?}");
    let told = stdout(&pintle(&["explain", "off-constraint"]).assert().code(0));
    assert!(told.contains("residual beyond rounding"), "{told}");
}
