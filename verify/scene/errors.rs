//! One run tells all that is wrong with a file, each once; and shows no more of a line than fits.

use assert_cmd::Command;
use pintle_model::evaluate::Model;
use pintle_scene::{Code, Diagnostic, MAX_ERRORS, Scene};
use std::fs;
use std::path::Path;

const DECK: &str = "\
*NODE
1, 0., 0., 0.
2, 1., x, 0.
3, 2., 0., y
*NSET, NSET=N, GENRATE
1, 3
*ELEMENT, TYPE=CONN3D2, ELSET=E
101, 1, 2
102, 2, 3
*ORIENTATION, NAME=OZ, SYSTEM=ROUND
0., 0., 1., 1., 0., 0.
*CONNECTOR SECTION, ELSET=E, BEHAVIOR=C
HINGE
OZ,
*CONNECTOR BEHAVIOR, NAME=B
*CONNECTOR STOP, COMPONENT=7
1., 2.
*STEP
*CONNECTOR MOTION
E, 9, 1.
E, 8, 1.
*STATIC, DIRECT
-1.
*END STEP
";

fn codes(error: &Diagnostic) -> Vec<(Code, Option<u32>)> {
    std::iter::once(error).chain(error.further()).map(|one| (one.code(), one.line())).collect()
}

/// A faulty line hides what follows from it, and nothing else.
#[test]
fn a_faulty_line_hides_only_what_uses_it() {
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, x, 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=K\n102, 1, 2\n103, 1, 3\n104, 1, 99\n\
                 *CONNECTOR SECTION, ELSET=K\nAXIAL\n";
    let error = Scene::parse("deck.inp", nodes).unwrap_err();
    assert_eq!(codes(&error), [(Code::MalformedNumber, Some(4)), (Code::UnknownNode, Some(8))]);
    // Of a section that no element has, the type is judged.
    let (scene, error) = {
        let text = nodes.replace("3, x", "3, 0.").replace("104, 1, 99\n", "");
        let text =
            text.replace("*CONNECTOR SECTION", "*CONNECTOR SECTION, ELSET=G\nHINGEE\n*CONNECTOR SECTION");
        let path = crate::commands::cli::file("errors-unused-section.inp", &text);
        Scene::examine(&path)
    };
    assert_eq!(codes(&error.unwrap()), [(Code::UnknownElementSet, Some(8))]);
    let (_, broken) = Model::examine(&scene);
    let broken: Vec<_> = broken.iter().map(|rule| (rule.code(), rule.line())).collect();
    assert_eq!(broken, [(Code::UnknownConnectionType, Some(9))]);
}

#[test]
fn all_errors_come_in_one_run_and_none_that_follows_from_another() {
    let error = Scene::parse("deck.inp", DECK).unwrap_err();
    let expected = [
        (Code::MalformedNumber, 3),
        (Code::MalformedNumber, 4),
        (Code::UnknownParameter, 5),
        (Code::BadParameterValue, 10),
        (Code::UnknownBehavior, 12),
        (Code::BadComponent, 16),
        (Code::BadComponent, 20),
        (Code::BadComponent, 21),
        (Code::NumberOutOfRange, 23),
    ];
    let expected: Vec<_> = expected.iter().map(|(code, line)| (*code, Some(*line))).collect();
    assert_eq!((codes(&error), error.unsaid()), (expected, 0));
    let references = DECK.replace(", x,", ", 0.,").replace(", y", ", 0.").replace("GENRATE\n", "GENERATE\n");
    let references = references.replace("SYSTEM=ROUND", "SYSTEM=R").replace("COMPONENT=7", "COMPONENT=4");
    let references = references.replace("E, 9", "F, 4").replace("E, 8", "103, 5").replace("-1.", "1.");
    let references = references.replace("102, 2, 3", "102, 2, 4");
    let error = Scene::parse("deck.inp", &references).unwrap_err();
    let found: Vec<Code> = codes(&error).into_iter().map(|(code, _)| code).collect();
    assert_eq!(
        found,
        [Code::UnknownNode, Code::UnknownBehavior, Code::UnknownElementSet, Code::UnknownElement]
    );
}

#[test]
fn errors_beyond_the_limit_are_counted() {
    let lines: String = (1..=50).map(|node| format!("{node}, x, 0., 0.\n")).collect();
    let error = Scene::parse("deck.inp", &format!("*NODE\n{lines}*MPC\nTIE, 1, 2\n")).unwrap_err();
    assert_eq!((error.further().len() + 1, error.unsaid()), (MAX_ERRORS, 50 - MAX_ERRORS));
    // One of another code is told all the same.
    let other = "*ELEMENT, TYPE=CONN3D2\n1, 1, 2\n";
    let error = Scene::parse("deck.inp", &format!("*NODE\n{lines}*MPC\nTIE, 1, 2\n{other}")).unwrap_err();
    let found = codes(&error);
    assert_eq!((found.len(), found.last().map(|one| one.0)), (MAX_ERRORS + 1, Some(Code::MissingSection)));
}

/// What is alike is shown once, with how often, and of whom.
#[test]
fn what_is_alike_is_told_once() {
    let folder = crate::commands::cli::folder("alike");
    let nodes: String = (1..=201).map(|node| format!("{node}, {node}., 0., 0.\n")).collect();
    let hinges: String = (1..=200)
        .map(|n| {
            format!(
                "*ELEMENT, TYPE=CONN3D2, ELSET=E{n}\n{}, {n}, {}\n*CONNECTOR SECTION, ELSET=E{n}\nHINGE\n",
                1000 + n,
                n + 1
            )
        })
        .collect();
    let loads: String = (1..=9).map(|node| format!("{node}, 1, x\n")).collect();
    let cases = [
        (
            "hinges",
            hinges.clone(),
            "rule::orientation-required",
            "more times: element 1002, element 1003, element 1004 …",
        ),
        (
            "loads",
            format!("{hinges}*STEP\n*CLOAD\n{loads}*END STEP\n"),
            "deck::malformed-number",
            "loads.inp:1006, ",
        ),
    ];
    for (name, lines, code, more) in cases {
        let deck = folder.join(format!("{name}.inp"));
        fs::write(&deck, format!("*NODE\n{nodes}{lines}")).unwrap();
        let run = |words: &[&str]| {
            let mut run = Command::new(env!("CARGO_BIN_EXE_pintle"));
            let output = run.env("NO_COLOR", "1").args(words).arg(&deck).output().unwrap();
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap())
        };
        let [_, shown] = run(&["eval"]);
        let blocks = shown.lines().filter(|line| line.trim() == code).count();
        assert!(blocks == 1 && shown.contains(more), "{name}: {blocks}\n{shown}");
        // The report of an audit has what refuses a model, and stderr does not.
        if name == "hinges" {
            let [report, shown] = run(&["audit", "--model-only"]);
            assert!(report.contains(code) && !shown.contains(code), "{report}\n{shown}");
        }
    }
}

#[test]
fn commands_show_every_error_once() {
    let folder = crate::commands::cli::folder("errors-of-a-file");
    let deck = folder.join("faulty.inp");
    fs::write(&deck, DECK).unwrap();
    let rules = folder.join("rules.inp");
    let sound = DECK.replace(", x,", ", 0.,").replace(", y", ", 0.").replace("GENRATE\n", "GENERATE\n");
    let sound = sound.replace("SYSTEM=ROUND", "SYSTEM=R").replace("COMPONENT=7", "COMPONENT=2");
    let sound =
        sound.replace("E, 9", "E, 1").replace("E, 8", "E, 2").replace("-1.", "1.").replace("=C\n", "=B\n");
    fs::write(&rules, sound).unwrap();
    for (file, errors) in [(&deck, 9), (&rules, 3)] {
        for command in [vec!["eval"], vec!["audit", "--model-only"], vec!["convert", "--to", "json"]] {
            if file == &rules && command[0] == "convert" {
                continue;
            }
            let mut run = Command::new(env!("CARGO_BIN_EXE_pintle"));
            run.env("NO_COLOR", "1").args(&command).arg(file);
            let output = run.output().unwrap();
            let [report, shown] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
            let is_of_report = command[0] == "audit" && file == &rules;
            let begins = if is_of_report { "error[" } else { "×" };
            let all = if is_of_report { report } else { shown };
            let blocks = all.lines().filter(|line| line.trim_start().starts_with(begins)).count();
            // What is like another one is counted with it.
            let more = if is_of_report { "and " } else { "more time" };
            let number = |line: &str| {
                let (before, after) = line.split_once(more)?;
                let text =
                    if is_of_report { after.split(' ').next() } else { before.split_whitespace().last() };
                text?.parse::<usize>().ok()
            };
            let alike = all.lines().filter(|line| line.contains("more ")).filter_map(number);
            let count = blocks + alike.sum::<usize>();
            assert_eq!((output.status.code(), count), (Some(6), errors), "{command:?}:\n{all}");
        }
    }
}

/// All that is wrong with one constraint is told.
#[test]
fn every_fault_of_a_constraint_is_told() {
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n";
    for (lines, faults) in [
        ("*RIGID BODY, REF NODE=55, TIE NSET=NOPE, PIN NSET=NONE\n", 3),
        ("*RIGID BODY, REF NODE=55, ELSET=NOPE\n", 2),
        ("*COUPLING, REF NODE=55, SURFACE=NOPE, CONSTRAINT NAME=C\n*KINEMATIC\n", 2),
    ] {
        let error = Scene::parse("deck.inp", &format!("{nodes}{lines}")).unwrap_err();
        assert_eq!(codes(&error).len(), faults, "{lines}: {:?}", codes(&error));
    }
}

/// What breaks the rules of a connection type is told beside what cannot be read.
#[test]
fn rules_are_told_beside_errors_of_reading() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n3, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n1, 1, 2\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=D\n2, 1, 3\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n3, 1, 3\n\
                *CONNECTOR SECTION, ELSET=C\nHINGE\n*CONNECTOR SECTION, ELSET=D\nSLOT\n*CONNECTOR SECTION, ELSET=E\nHINGEE\n\
                *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR STOP, COMPONENT=1\n5., -5.\n\
                *STEP\n*STATIC\n*CONNECTOR MOTION\nC, 1, 1.\n*CONNECTOR MOTION, AMPLITUDE=A\nD, 1, 1.\n*END STEP\n";
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rules-beside.inp");
    fs::write(&file, deck).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_pintle")).arg("eval").arg(&file).output().unwrap();
    let shown = String::from_utf8(output.stderr).unwrap();
    let codes: Vec<&str> = shown.lines().filter(|line| line.contains("::")).map(str::trim).collect();
    let expected = [
        "deck::limits-reversed",
        "deck::unknown-amplitude",
        "rule::orientation-required",
        "rule::action-not-available",
        "rule::unknown-connection-type",
        "note: rule::orientation-required 1 more time: element 2",
    ];
    assert_eq!((output.status.code(), codes), (Some(6), expected.to_vec()), "{shown}");
}

/// A mark beyond column 65,535, a line of five million bytes, and brackets without end: no panic and no flood.
#[test]
fn excerpts_are_windows_around_the_place() {
    let nodes: Vec<String> = (1..=5000).map(|node| format!("\"{node}\": [0, 0, {node}.5]")).collect();
    let json = format!("{{\"nodes\": {{{}}}, \"conectors\": {{}}}}", nodes.join(", "));
    assert!(json.len() > 100_000);
    let error = Scene::parse_json("scene.json", &json).unwrap_err();
    let shown = error.render(200, false);
    assert!(shown.contains("conectors") && shown.contains('…') && shown.len() < 3000, "{shown}");
    let column = json.find("\"conectors\"").unwrap();
    assert!(
        shown.contains(&format!("scene.json:1:{}", column + 1))
            || shown.contains(&format!("scene.json:1:{}", column + 2)),
        "{shown}"
    );
    let line = format!("*NODE\n1, 0., 0., 0.\n2, {}x\n*MPC\nTIE, 1, 2\n", "é".repeat(2_500_000));
    let brackets = "[".repeat(200_000);
    let unknown = format!("*MPC, {}=3\n", "ü".repeat(20_000));
    for (name, text) in [
        ("deck.inp", line.as_str()),
        ("deck.inp", &unknown),
        ("scene.json", &brackets),
        ("scene.toml", &brackets),
    ] {
        let error = match name {
            "deck.inp" => Scene::parse(name, text),
            "scene.json" => Scene::parse_json(name, text),
            _ => Scene::parse_toml(name, text),
        };
        let error = error.unwrap_err();
        for width in [40, 110] {
            let shown = error.render(width, false);
            assert!(shown.len() < 6000, "{name}: {} bytes", shown.len());
        }
    }
}

#[test]
fn two_types_without_a_comma_are_told_to_have_one() {
    for written in ["Join Revolute", "JOIN+REVOLUTE", "slot-align"] {
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n1, 1, 2\n*CONNECTOR SECTION, ELSET=E\n{written}\n"
        );
        let error = Model::compile(&Scene::parse("deck.inp", &deck).unwrap()).unwrap_err();
        let types = written.to_uppercase().replace([' ', '+', '-'], ", ");
        assert!(error.remedy().contains(&format!("write {types}: a comma")), "{written}: {}", error.remedy());
    }
}

/// A name as long as a line is shown by its beginning; a table with other separators is told what separates.
#[test]
fn long_names_and_other_separators_are_told_shortly() {
    let long = "Z".repeat(60_000);
    let error = Scene::parse("deck.inp", &format!("*MPC\n{long}, 1, 2\n")).unwrap_err();
    assert_eq!(error.code(), Code::UnknownMpc);
    assert!(error.render(100, false).len() < 3_000);
    let scene = Scene::parse("deck.inp", &format!("*NODE\n1, 0., 0., 0.\n*{long}\n1\n")).unwrap();
    assert!(scene.skipped.keywords.keys().all(|name| name.chars().count() <= 81));
    assert_eq!(scene.skipped.keywords.len(), 1);
    for separator in [";", "\t", " "] {
        let path = crate::commands::cli::file(
            "errors-separator.csv",
            &format!("state{separator}node{separator}u1\n"),
        );
        let error = pintle_scene::StateFile::read(Path::new(&path), &scene).unwrap_err();
        assert!(error.remedy().contains("separate columns by commas"), "{error}");
    }
}
