//! Files that commands write: none takes the place of another unasked, all fail with one exit code.

use crate::commands::cli::stderr;
use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};

fn pintle(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pintle"));
    command.args(arguments);
    command
}

/// An empty folder.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// The files of a folder and what they hold.
fn held(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let content = if path.is_dir() { Vec::new() } else { fs::read(&path).unwrap() };
        found.push((path, content));
    }
    found.sort();
    found
}

/// Every option that writes a file refuses one that is there, says so before it computes, and writes it with `--force`.
#[test]
fn no_file_is_overwritten_unasked() {
    let folder = folder("files");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_string();
    let [text, json, example] = [path("it.inp"), path("it.json"), path("example.json")];
    let cases = path("cases");
    pintle(&[
        "audit",
        "gallery:hinge_pendulum",
        "--connector",
        "102",
        "--wide-states",
        "1",
        "--plant",
        "wrong-entry",
    ])
    .args(["--counter-examples", &cases])
    .assert()
    .code(1);
    let first = fs::read_dir(&cases).unwrap().next().unwrap().unwrap().path();
    fs::rename(&first, &example).unwrap();
    fs::write(Path::new(&cases).join("kept.json"), "mine").unwrap();
    for (kept, ending) in [("man", "1"), ("plots", "svg")] {
        fs::create_dir_all(path(kept)).unwrap();
        fs::write(Path::new(&path(kept)).join(format!("kept.{ending}")), "mine").unwrap();
    }
    let [man, plots] = [path("man"), path("plots")];
    let brief = ["audit", "gallery:hinge_pendulum", "--connector", "102", "--wide-states", "1"];
    let pendulum = ["eval", "gallery:hinge_pendulum", "--connector", "101"];
    let with = |words: &[&'static str], more: [&str; 2]| -> Vec<String> {
        words.iter().copied().chain(more).map(str::to_string).collect()
    };
    let writers = [
        with(&["convert", "gallery:hinge_pendulum"], ["-o", &text]),
        with(&["convert", "gallery:hinge_pendulum", "--to", "toml"], ["--save-states", &json]),
        with(&["export", "HINGE", "--as", "c"], ["-o", &text]),
        [
            vec!["replay".to_string(), example.clone(), "--export".into(), "rust".into()],
            with(&[], ["-o", &text]),
        ]
        .concat(),
        with(&pendulum, ["--jacobian", &text]),
        with(&pendulum, ["--save-branches", &text]),
        with(&brief, ["--html", &text]),
        with(&brief, ["--plots", &plots]),
        with(&brief, ["--counter-examples", &cases]),
        with(&["man"], ["--folder", &man]),
        with(&["bench", "SLIDE-PLANE", "--rounds", "1", "--states", "1"], ["--plots", &plots]),
    ];
    let mut tried = 0;
    for words in &writers {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        fs::write(&text, "mine").unwrap();
        fs::write(&json, "mine").unwrap();
        let before = held(&folder);
        let refused = pintle(&words).assert().code(7).stdout("");
        assert!(stderr(&refused).contains("--force"), "{words:?}: {}", stderr(&refused));
        assert_eq!(held(&folder), before, "{words:?}");
        tried += 1;
        if !words.contains(&"bench") {
            pintle(&words).arg("--force").assert().code(0);
            let parts =
                held(&folder).into_iter().filter(|(path, _)| path.to_str().unwrap().ends_with(".part"));
            assert_eq!(parts.count(), 0);
        }
    }
    assert_eq!(tried, 11);
    // An input is a file that is there.
    pintle(&["convert", "gallery:hinge_pendulum", "-o", &text, "--force"]).assert().code(0);
    let deck = fs::read(&text).unwrap();
    pintle(&["convert", &text, "-o", &text]).assert().code(7);
    assert_eq!(fs::read(&text).unwrap(), deck);
}

/// What cannot be written has one exit code, be it a file, a folder or standard output; a device is written to as it is.
#[test]
#[cfg(target_os = "linux")]
fn what_cannot_be_written_has_one_exit_code() {
    use std::process::Stdio;
    let full = || fs::File::options().write(true).open("/dev/full").unwrap();
    let export = &["export", "HINGE", "--as", "c"];
    for words in [&["eval", "gallery:hinge_pendulum"][..], &["list"], export, &["--help"], &["--version"]] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_pintle"));
        let output = command.args(words).stdout(Stdio::from(full())).output().unwrap();
        assert_eq!(output.status.code(), Some(7), "{words:?}");
    }
    let convert = ["convert", "gallery:hinge_pendulum", "--to", "toml", "-o"];
    for file in ["/dev/full", "/no/such/folder/it.toml", "/dev"] {
        let refused = pintle(&convert).arg(file).assert().code(7);
        assert!(stderr(&refused).contains(file), "{}", stderr(&refused));
    }
    let twice = ["eval", "gallery:hinge_pendulum", "--jacobian", "one", "--save-branches", "one", "--force"];
    assert!(stderr(&pintle(&twice).assert().code(7)).contains("twice"));
    assert!(!Path::new("one").exists());
    let written = pintle(&convert).arg("/dev/stdout").assert().code(0);
    assert!(written.get_output().stdout.len() > 100);
}
