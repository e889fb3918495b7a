//! What an audit finds in models: for every code a deck that has exactly it, and one near it that has not.
//!
//! A deck of `verify/findings` says in its first lines what is to be found (`** finds: CODE, CODE`), and of the first: the line, a part
//! of the message, and a part of the remedy. Its neighbour, `NAME.near.inp`, says what it lacks (`** lacks: CODE`). The
//! states of either are in the file `.csv` of the same name.

use pintle_audit::model::{Finding, Levels, ModelReport, audit_model};
use pintle_scene::{Code, Scene, Severity, StateFile};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("verify/findings")
}

struct Expected {
    path: PathBuf,
    finds: Vec<Code>,
    lacks: Option<Code>,
    line: Option<u32>,
    message: String,
    remedy: String,
}

fn code(text: &str, path: &Path) -> Code {
    let found = Code::ALL.iter().find(|code| code.as_str() == text.trim());
    *found.unwrap_or_else(|| panic!("{}: there is no code {text}", path.display()))
}

impl Expected {
    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).unwrap();
        let (mut finds, mut lacks, mut line) = (Vec::new(), None, None);
        let (mut message, mut remedy) = (String::new(), String::new());
        for said in text.lines() {
            let Some((key, value)) = said.trim_start_matches(['*', ' ']).split_once(": ") else { break };
            match key {
                "finds" => finds = value.split(',').map(|text| code(text, &path)).collect(),
                "lacks" => lacks = Some(code(value, &path)),
                "line" => line = Some(value.parse().unwrap()),
                "message" => value.clone_into(&mut message),
                "remedy" => value.clone_into(&mut remedy),
                _ => break,
            }
        }
        assert!(!finds.is_empty() || lacks.is_some(), "{} says nothing", path.display());
        Self { path, finds, lacks, line, message, remedy }
    }

    fn name(&self) -> String {
        self.path.file_name().unwrap().to_str().unwrap().to_string()
    }

    fn report(&self) -> ModelReport {
        let scene = Scene::read(&self.path).unwrap_or_else(|error| panic!("{}", error.render(110, false)));
        let states = self.path.with_extension("csv");
        let states =
            if states.exists() { StateFile::read(&states, &scene).unwrap().states } else { Vec::new() };
        audit_model(&scene, &states, &Levels::default())
    }
}

fn all() -> Vec<Expected> {
    let entries = fs::read_dir(directory()).unwrap().map(|entry| entry.unwrap().path());
    let mut decks: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "inp")).collect();
    decks.sort();
    decks.into_iter().map(Expected::read).collect()
}

fn shown(findings: &[Finding]) -> String {
    findings.iter().map(|finding| finding.diagnostic().render(120, false)).collect()
}

/// Each deck has what it says and nothing else, at the place that it says.
#[test]
fn every_deck_has_exactly_what_it_says() {
    let mut complaints = Vec::new();
    for expected in all() {
        let report = expected.report();
        let codes: BTreeSet<&str> = report.findings.iter().map(|finding| finding.code().as_str()).collect();
        let wanted: BTreeSet<&str> = expected.finds.iter().map(|code| code.as_str()).collect();
        if codes != wanted {
            complaints.push(format!("{}: {codes:?}\n{}", expected.name(), shown(&report.findings)));
            continue;
        }
        assert!(expected.lacks.is_none_or(|code| !codes.contains(code.as_str())));
        let Some(first) = expected.finds.first().filter(|_| expected.lacks.is_none()) else { continue };
        let of_code = report.findings.iter().filter(|finding| finding.code() == *first);
        let is_it = |finding: &Finding| {
            finding.line() == expected.line
                && finding.message().contains(&expected.message)
                && finding.remedy().contains(&expected.remedy)
                && finding.file().ends_with(&expected.name())
                && finding.severity() < Severity::Error
                && !finding.reason().is_empty()
        };
        if !of_code.clone().any(is_it) {
            complaints.push(format!("{}: not as it says:\n{}", expected.name(), shown(&report.findings)));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// What is found of a scene; what an audit says of numbers has tests of its own.
const GROUPS: [&str; 3] = ["model", "assembly", "coverage"];
/// What no deck provokes: a mistake of the program. The module of assemblies tests that it would be told.
const ELSEWHERE: [Code; 1] = [Code::AssemblyNotAssembled];

/// Every code has a deck that has it and a neighbour that has not.
#[test]
fn every_finding_has_a_deck_and_a_neighbour() {
    let decks = all();
    let had: BTreeSet<&str> = decks
        .iter()
        .filter(|deck| deck.lacks.is_none())
        .flat_map(|deck| &deck.finds)
        .map(|code| code.as_str())
        .collect();
    let lacked: BTreeSet<&str> = decks.iter().filter_map(|deck| deck.lacks).map(Code::as_str).collect();
    let codes = Code::ALL
        .iter()
        .filter(|code| GROUPS.contains(&code.group()) && !ELSEWHERE.contains(code))
        .map(|code| code.as_str());
    let missing: Vec<&str> = codes.filter(|code| !had.contains(code) || !lacked.contains(code)).collect();
    assert!(missing.is_empty(), "without deck or neighbour: {}", missing.join(", "));
}

/// Findings have their place in TOML and JSON too: the line of what they are about.
#[test]
fn findings_have_a_place_in_every_form() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for (form, about) in [("toml", "stops = [{"), ("json", "{\"component\":1,\"lower\":-0.5,\"upper\":0.5}")]
    {
        let path = folder.join(format!("stop-violated.{form}"));
        let deck = directory().join("stop-violated.inp");
        crate::commands::cli::pintle(&["convert", deck.to_str().unwrap(), "-o", path.to_str().unwrap()])
            .assert()
            .success();
        let scene = Scene::read(&path).unwrap_or_else(|error| panic!("{}", error.render(110, false)));
        let report = audit_model(&scene, &[], &Levels::default());
        let found = report.findings.iter().find(|finding| finding.code() == Code::ModelStopViolated).unwrap();
        assert!(found.file().ends_with(&format!("stop-violated.{form}")), "{}", found.file());
        let text = fs::read_to_string(&path).unwrap();
        let line = text.lines().nth(found.line().unwrap() as usize - 1).unwrap();
        assert!(line.contains(about), "{form}: {line}");
    }
}

fn command(arguments: &[&str]) -> std::process::Output {
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_pintle"));
    for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "COLUMNS", "RUST_BACKTRACE"] {
        command.env_remove(name);
    }
    command.current_dir(directory()).arg("audit").args(arguments).args([
        "--drawn-states",
        "2",
        "--wide-states",
        "1",
    ]);
    command.output().unwrap()
}

/// The command shows findings, and the levels given decide what is shown and whether it fails.
#[test]
fn levels_are_set_on_the_command_line() {
    let told = |arguments: &[&str]| {
        let output = command(arguments);
        (
            output.status.code(),
            String::from_utf8(output.stdout).unwrap(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let deck = "stop-violated.inp";
    let (code, shown, _) = told(&[deck]);
    assert_eq!(code, Some(0), "{shown}");
    assert!(shown.contains("warning[model::stop-violated] stop-violated.inp:17"), "{shown}");
    assert!(shown.contains("help: move the stop") && shown.contains("degrees of freedom"), "{shown}");
    for denied in ["model::stop-violated", "model", "warnings"] {
        let (code, shown, said) = told(&[deck, "--deny", denied]);
        assert_eq!(code, Some(1), "{shown}");
        assert!(
            shown.contains("error[model::stop-violated]") && said.contains("a finding"),
            "{shown} {said}"
        );
    }
    // What is said of a code outweighs what is said of all.
    let (code, shown, _) = told(&[deck, "--deny", "warnings", "--allow", "model::stop-violated"]);
    assert_eq!((code, shown.contains("stop-violated]")), (Some(0), false), "{shown}");
    let (code, shown, _) = told(&[deck, "--note", "model::stop-violated", "--format", "json"]);
    let document: serde_json::Value = serde_json::from_str(&shown).unwrap();
    let finding = &document["models"][0]["findings"][0];
    assert_eq!((code, &finding["severity"], &finding["line"]), (Some(0), &"note".into(), &17.into()));
    assert_eq!(finding["about"]["components"][0], "u1");
    let (code, _, said) = told(&[deck, "--deny", "model::stop-violatd"]);
    assert_eq!(code, Some(2));
    assert!(said.contains("did you mean model::stop-violated?"), "{said}");
    // Where the rank is undecided, --strict says so.
    let (code, shown, _) = told(&["undecided.inp", "--strict"]);
    assert_eq!(code, Some(3), "{shown}");
}
