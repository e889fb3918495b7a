//! Whether the pages tell the truth: each command of the tutorial and of the how-to pages is run, and prints what the page shows.
//!
//! A fence with `file=NAME` is a file, that of `examples/elements` where there is one. In a fence `console`, a line `$ pintle …` is a command.
//! What follows is its output, with what goes to the terminal's errors after it. A line `…` stands for any lines. `$ echo $?` is the exit code of the
//! command before. All of a page runs in one folder.

mod words; // whether every word of the reports is explained

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::{env, fs};

/// A fence: what stands behind its opening, the line of the page, and what it holds.
struct Fence {
    kind: String,
    line: usize,
    lines: Vec<String>,
}

fn fences(page: &str) -> Vec<Fence> {
    let mut found = Vec::new();
    let mut open: Option<Fence> = None;
    for (number, line) in page.lines().enumerate() {
        match (line.strip_prefix("```"), open.take()) {
            (Some(_), Some(fence)) => found.push(fence),
            (Some(kind), None) => {
                open = Some(Fence { kind: kind.to_string(), line: number + 1, lines: Vec::new() });
            }
            (None, Some(mut fence)) => {
                fence.lines.push(line.to_string());
                open = Some(fence);
            }
            (None, None) => {}
        }
    }
    found
}

/// Whether lines are those of a page, in which `…` stands for any.
fn shows(page: &[&str], got: &[&str]) -> bool {
    match page.split_first() {
        None => got.is_empty(),
        Some((&"…", rest)) => (0..=got.len()).any(|skipped| shows(rest, &got[skipped..])),
        Some((line, rest)) => got.split_first().is_some_and(|(first, got)| first == line && shows(rest, got)),
    }
}

/// A Python: that of the environment of the tests, or of the system.
fn python() -> PathBuf {
    let made = Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv/bin/python");
    if made.exists() { made } else { "python3".into() }
}

/// Whether a page's compilers are there, and JAX.
fn can_run(page: &str) -> bool {
    let lacks = |program: &str| {
        page.contains(&format!("$ {program} ")) && Command::new(program).arg("--version").output().is_err()
    };
    let lacks_jax = || {
        let imported = Command::new(python()).args(["-c", "import jax"]).output();
        page.contains("import jax") && !imported.is_ok_and(|imported| imported.status.success())
    };
    let lacking = ["cc", "gfortran"].into_iter().find(|program| lacks(program));
    let lacking = lacking.or_else(|| lacks_jax().then_some("jax"));
    if let Some(program) = lacking {
        assert!(env::var_os("CI").is_none(), "CI has no {program}");
        eprintln!("SKIPPED: a page needs {program}, which is not installed");
    }
    lacking.is_none()
}

fn run(command: &str, folder: &Path) -> Output {
    let (command, file) = command.split_once(" > ").map_or((command, None), |(c, file)| (c, Some(file)));
    // What stands between quotes is one word.
    let quoted = command.split('"').enumerate();
    let words: Vec<&str> = quoted
        .flat_map(|(n, part)| if n % 2 == 1 { vec![part] } else { part.split_whitespace().collect() })
        .collect();
    let (program, arguments) = words.split_first().expect("a command");
    let mut command = match *program {
        "pintle" => Command::new(env!("CARGO_BIN_EXE_pintle")),
        "python3" => Command::new(python()),
        "cat" | "cc" | "gfortran" => Command::new(program),
        other => panic!("the pages run pintle, python3, cat and compilers, not {other}"),
    };
    command.args(arguments).current_dir(folder).env_remove("COLUMNS").env("NO_COLOR", "1");
    // `python3` is that of the environment of the tests for the programs that a check starts, too.
    if let Some(folder) = python().parent().filter(|folder| folder.is_absolute()) {
        let others = env::var_os("PATH").unwrap_or_default();
        let folders = std::iter::once(folder.to_path_buf()).chain(env::split_paths(&others));
        command.env("PATH", env::join_paths(folders).expect("a path"));
    }
    let mut output = command.output().expect("it runs");
    if let Some(file) = file {
        fs::write(folder.join(file), std::mem::take(&mut output.stdout)).expect("a file");
    }
    output
}

/// Runs a page; gives how many commands it ran, and what it shows that is not so.
fn check(path: &Path) -> (usize, Vec<String>) {
    let page = fs::read_to_string(path).expect("the page");
    let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
    let folder = env::temp_dir().join(format!("pintle-page-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let (mut commands, mut wrong, mut code) = (0, Vec::new(), None);
    for fence in fences(&page) {
        if let Some((_, file)) = fence.kind.split_once(" file=") {
            let text = fence.lines.join("\n") + "\n";
            let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/elements").join(file);
            if example.exists() {
                let example = fs::read_to_string(&example).expect("an example");
                assert_eq!(text, example, "{}: {file} is another one than the example", path.display());
            }
            fs::write(folder.join(file), text).expect("a file of the page");
        }
        if fence.kind != "console" {
            continue;
        }
        let mut blocks: Vec<(usize, &str, Vec<&str>)> = Vec::new();
        for (at, line) in fence.lines.iter().enumerate() {
            if let Some(command) = line.strip_prefix("$ ") {
                blocks.push((fence.line + at + 1, command, Vec::new()));
            } else if let Some((_, _, shown)) = blocks.last_mut() {
                shown.push(line);
            }
        }
        for (line, command, shown) in blocks {
            commands += 1;
            let text = if command == "echo $?" {
                format!("{}\n", code.unwrap_or(0))
            } else {
                let output = run(command, &folder);
                code = output.status.code();
                String::from_utf8_lossy(&output.stdout).into_owned()
                    + &String::from_utf8_lossy(&output.stderr)
            };
            let trimmed = |lines: Vec<&str>| -> Vec<String> {
                let lines: Vec<String> = lines.into_iter().map(|line| line.trim_end().to_string()).collect();
                let end = lines.iter().rposition(|line| !line.is_empty()).map_or(0, |last| last + 1);
                lines.into_iter().take(end).collect()
            };
            let (shown, got) = (trimmed(shown), trimmed(text.lines().collect()));
            let (shown, got): (Vec<&str>, Vec<&str>) =
                (shown.iter().map(String::as_str).collect(), got.iter().map(String::as_str).collect());
            if !shows(&shown, &got) {
                wrong.push(format!("{}:{line}: $ {command}\nprints\n{}\n", path.display(), got.join("\n")));
            }
        }
    }
    fs::remove_dir_all(&folder).ok();
    (commands, wrong)
}

#[test]
fn pages_show_what_their_commands_print() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let mut pages = vec![docs.join("tutorial.md")];
    let how_to = fs::read_dir(docs.join("how-to")).expect("the how-to pages");
    pages.extend(how_to.map(|entry| entry.expect("a page").path()));
    let (mut commands, mut wrong) = (0, Vec::new());
    // Sessions of Python are run by the tests of its package.
    pages.retain(|page| !fs::read_to_string(page).expect("the page").contains("\n>>> "));
    for page in &pages {
        if !can_run(&fs::read_to_string(page).expect("the page")) {
            continue;
        }
        let (ran, found) = check(page);
        assert!(ran > 1, "{}: {ran} commands", page.display());
        commands += ran;
        wrong.extend(found);
    }
    assert!(pages.len() >= 5 && commands >= 20, "{} pages, {commands} commands", pages.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
