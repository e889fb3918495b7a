//! Every fault gives one error: its code, its place, and a remedy that helps; from the library and from the command.
//!
//! One file of `verify/faults/` is one fault; its README says how to add one.

use assert_cmd::Command;
use pintle_model::evaluate::Model;
use pintle_scene::{Code, Diagnostic, ForceFile, ForceSign, Scene, Severity, State, StateFile};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A faulty file and what is to be said about it.
struct Fault {
    path: PathBuf,
    severity: Severity,
    code: Code,
    /// None: the fault has no place.
    line: Option<u32>,
    /// The file that is at fault, if it is not this one.
    file: Option<String>,
    /// What the message and the remedy contain.
    message: String,
    remedy: String,
}

fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("verify/faults")
}

/// The scene that faulty states, or forces, are those of.
fn sound(kind: &str) -> PathBuf {
    directory().join(kind).join("sound.inp")
}

/// The files of a directory, in alphabetical order.
fn files(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries.filter(|path| path.is_file()).collect();
    files.sort();
    files
}

fn faults() -> Vec<Fault> {
    let kinds = fs::read_dir(directory()).unwrap().map(|entry| entry.unwrap().path());
    let mut kinds: Vec<_> = kinds.filter(|path| path.is_dir()).collect();
    kinds.sort();
    let files = kinds.iter().flat_map(|kind| files(kind));
    let faulty = files.filter(|path| !path.ends_with("sound.inp") && path.extension().unwrap() != "expect");
    faulty.map(|path| Fault::read(&path)).collect()
}

impl Fault {
    /// Reads what is expected: comments at the head of the file, or the file beside it that ends in `.expect`.
    fn read(path: &Path) -> Self {
        let beside = path.with_extension("expect");
        let head = if beside.exists() { &beside } else { path };
        let bytes = fs::read(head).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let mut fault = Self {
            path: path.to_owned(),
            severity: Severity::Error,
            code: Code::Unreadable,
            line: None,
            file: None,
            message: String::new(),
            remedy: String::new(),
        };
        let mut expected = 0;
        for line in text.lines() {
            let Some((key, value)) = line.trim_start_matches(['*', '#', ' ']).split_once(": ") else { break };
            let code = || {
                let found = Code::ALL.iter().find(|code| code.as_str() == value);
                *found.unwrap_or_else(|| panic!("{}: there is no code {value}", head.display()))
            };
            match key {
                "error" => fault.code = code(),
                "warning" => (fault.severity, fault.code) = (Severity::Warning, code()),
                "line" => fault.line = Some(value.parse().unwrap()),
                "file" => fault.file = Some(value.to_owned()),
                "message" => value.clone_into(&mut fault.message),
                "remedy" => value.clone_into(&mut fault.remedy),
                _ => break,
            }
            expected += 1;
        }
        let complete = expected >= 2 && !fault.remedy.is_empty();
        assert!(complete, "{} does not say what is to be said about it", head.display());
        fault
    }

    fn name(&self) -> &str {
        self.path.file_name().unwrap().to_str().unwrap()
    }

    fn is_of_states(&self) -> bool {
        self.path.parent().unwrap().ends_with("states")
    }

    fn is_of_forces(&self) -> bool {
        self.path.parent().unwrap().ends_with("forces")
    }

    /// What the library says.
    fn diagnostics(&self) -> Result<Vec<Diagnostic>, Diagnostic> {
        if self.is_of_states() {
            let scene = Scene::read(sound("states"))?;
            return StateFile::read(&self.path, &scene).map(|_| Vec::new());
        }
        if self.is_of_forces() {
            let scene = Scene::read(sound("forces"))?;
            let mut states = vec![State::default()];
            ForceFile::read(&self.path, &scene, ForceSign::Internal)?.attach(&mut states, 0)?;
            let name = self.path.display().to_string();
            return Model::compile(&scene)?.check_forces(&states, 0, &name).map(|()| Vec::new());
        }
        let mut scene = Scene::read(&self.path)?;
        let model = Model::compile(&scene)?;
        scene.warnings.extend(model.warnings);
        Ok(scene.warnings)
    }

    /// What the command says.
    fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pintle"));
        for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "COLUMNS", "RUST_BACKTRACE"] {
            command.env_remove(name);
        }
        command.current_dir(self.path.parent().unwrap()).arg("eval");
        if self.is_of_states() {
            command.args(["sound.inp", "--states"]);
        }
        if self.is_of_forces() {
            command.args(["sound.inp", "--forces"]);
        }
        command.arg(self.name());
        command
    }

    /// Where the fault is, as it is shown.
    fn place(&self) -> String {
        let file = self.file.as_deref().unwrap_or(self.name());
        self.line.map_or_else(|| file.to_owned(), |line| format!("{file}:{line}:"))
    }

    /// What is wrong with a diagnostic of the library.
    fn complaints(&self, diagnostic: &Diagnostic) -> Vec<&'static str> {
        let shown = diagnostic.render(200, false);
        let file = self.file.as_deref().unwrap_or(self.name());
        let text = fs::read(self.path.parent().unwrap().join(file)).unwrap_or_default();
        let (start, end) = (diagnostic.span().start() as usize, diagnostic.span().end() as usize);
        let lines = |end: usize| text[..end].iter().filter(|&&byte| byte == b'\n').count() + 1;
        let marks_its_line = || {
            (start < end || text.get(start) == Some(&b'\n') || self.is_of_states() || self.is_of_forces())
                && end <= text.len()
                && Some(lines(start) as u32) == self.line
        };
        let is_rule = self.code.as_str().starts_with("rule::") && self.code != Code::UnknownConnectionType;
        let names = |what| diagnostic.message().contains(what);
        let checks = [
            (diagnostic.severity() == self.severity, "severity"),
            (diagnostic.code() == self.code, "code"),
            (diagnostic.line() == self.line, "line"),
            (diagnostic.file().ends_with(file), "file"),
            (!diagnostic.message().is_empty() && diagnostic.message().contains(&self.message), "message"),
            (diagnostic.remedy().contains(&self.remedy), "remedy"),
            (self.line.is_none() || !diagnostic.label().is_empty(), "label"),
            (self.line.is_none() || marks_its_line(), "marked text"),
            (shown.contains(self.code.as_str()) && shown.contains(&self.place()), "rendering"),
            (!is_rule || names("element ") || names("MPC "), "name of the element"),
            (!(is_rule && names("element ")) || diagnostic.label().starts_with("by "), "source of the rule"),
        ];
        checks.iter().filter(|(passed, _)| !passed).map(|(_, what)| *what).collect()
    }
}

#[test]
fn the_sound_deck_is_sound() {
    for kind in ["states", "forces"] {
        let scene = Scene::read(sound(kind)).unwrap();
        assert!(scene.warnings.is_empty());
        assert!(Model::compile(&scene).unwrap().warnings.is_empty());
    }
}

#[test]
fn every_fault_has_a_file_of_its_own() {
    let faults = faults();
    assert!(faults.len() >= 100);
    let names: BTreeSet<&str> = faults.iter().map(Fault::name).collect();
    assert_eq!(names.len(), faults.len(), "two faults have the same name");
}

/// A doubtful file is read with exactly one warning, a faulty one refused with one error.
#[test]
fn the_library_names_every_fault() {
    let mut complaints = Vec::new();
    for fault in faults() {
        let said = match (fault.diagnostics(), fault.severity) {
            (Ok(said), Severity::Warning | Severity::Note) => said,
            (Err(error), Severity::Error) => vec![error],
            (Ok(_), Severity::Error) => {
                complaints.push(format!("{} is not refused", fault.name()));
                continue;
            }
            (Err(error), Severity::Warning | Severity::Note) => {
                complaints.push(format!("{} is refused: {}", fault.name(), error.render(110, false)));
                continue;
            }
        };
        let [diagnostic] = said.as_slice() else {
            complaints.push(format!("{} has {} warnings: {said:?}", fault.name(), said.len()));
            continue;
        };
        let wrong = fault.complaints(diagnostic);
        if !wrong.is_empty() {
            let shown = diagnostic.render(110, false);
            complaints.push(format!("{}: wrong {}:\n{shown}", fault.name(), wrong.join(", ")));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// `pintle eval` ends with exit code 6 and shows one error with its place and remedy, or goes on after a warning.
#[test]
fn the_command_names_every_fault() {
    let mut complaints = Vec::new();
    for fault in faults() {
        let output = fault.command().output().unwrap();
        let shown = String::from_utf8(output.stderr).unwrap();
        let words = shown.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        let marked = |mark: &str| shown.lines().filter(|line| line.trim_start().starts_with(mark)).count();
        let is_error = fault.severity == Severity::Error;
        let checks = [
            (output.status.code() == Some(if is_error { 6 } else { 0 }), "exit code"),
            (output.stdout.is_empty() == is_error, "standard output"),
            (marked("×") == usize::from(is_error), "number of errors"),
            (is_error || marked("⚠") == 1, "number of warnings"),
            (shown.contains(fault.code.as_str()), "code"),
            (shown.contains(&fault.place()), "place"),
            (words.contains(&fault.message), "message"),
            (words.contains(&fault.remedy), "remedy"),
        ];
        let wrong: Vec<_> = checks.iter().filter(|(passed, _)| !passed).map(|(_, what)| *what).collect();
        if !wrong.is_empty() {
            complaints.push(format!("{}: wrong {}:\n{shown}", fault.name(), wrong.join(", ")));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn files_that_are_not_there_are_refused() {
    let error = Scene::read("no/such/deck.inp").unwrap_err();
    assert_eq!((error.code(), error.line(), error.file()), (Code::Unreadable, None, "no/such/deck.inp"));
    let scene = Scene::read(sound("states")).unwrap();
    assert_eq!(StateFile::read("no/such/states.csv", &scene).unwrap_err().code(), Code::Unreadable);
}

#[test]
fn every_code_has_a_fault() {
    let mut provoked: BTreeSet<&str> = faults().iter().map(|fault| fault.code.as_str()).collect();
    provoked.insert(Code::Unreadable.as_str()); // a file that is not there
    // What an audit finds has decks of its own.
    let read = Code::ALL.iter().filter(|code| !code.is_finding()).map(|code| code.as_str());
    let missing: Vec<&str> = read.filter(|code| !provoked.contains(code)).collect();
    assert!(missing.is_empty(), "no file of verify/faults provokes {}", missing.join(", "));
}

#[test]
fn messages_read_like_rustc() {
    for name in ["deck/parameter-misspelt.inp", "deck/stop-reversed.inp", "states/csv-unknown-node.csv"] {
        let fault = Fault::read(&directory().join(name));
        let shown = String::from_utf8(fault.command().output().unwrap().stderr).unwrap();
        insta::assert_snapshot!(name.split(['/', '.']).nth(1).unwrap(), shown);
    }
}
