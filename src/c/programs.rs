//! Programs in C and Fortran, compiled and run against the library.
#![expect(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};
use std::process::Command;

/// The folder of the library: that of this test.
fn library() -> PathBuf {
    let test = std::env::current_exe().expect("a path");
    let deps = test.parent().expect("deps");
    let found = [deps.to_path_buf(), deps.parent().expect("debug").to_path_buf()];
    let has = |folder: &&PathBuf| folder.join("libpintle_c.so").exists();
    found.iter().find(has).unwrap_or_else(|| panic!("no libpintle_c.so in {found:?}")).clone()
}

/// Compiles and runs a program; nothing where the compiler is missing.
fn run(compiler: &str, sources: &[&str], name: &str) -> Option<Vec<String>> {
    if Command::new(compiler).arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "CI has no {compiler}");
        eprintln!("SKIPPED: there is no {compiler}");
        return None;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let library = library();
    let mut command = Command::new(compiler);
    command.current_dir(&folder).args(["-O1", "-Wall", "-Wextra", "-Werror", "-o", "program"]);
    command.args(sources.iter().map(|source| here.join(source))).arg("-I").arg(here);
    command.arg("-L").arg(&library).args(["-lpintle_c", "-lm"]);
    command.arg(format!("-Wl,-rpath,{}", library.display()));
    let built = command.output().expect("the compiler runs");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let output =
        Command::new(folder.join("program")).current_dir(&folder).output().expect("the program runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    watch(&folder);
    Some(said.lines().map(String::from).collect())
}

/// Runs a program under Valgrind: it reads nothing that is not its own or not set, and leaves nothing allocated.
fn watch(folder: &Path) {
    let mut valgrind = Command::new("valgrind");
    valgrind.current_dir(folder).args(["--quiet", "--error-exitcode=9", "--leak-check=full"]);
    match valgrind.arg("./program").output() {
        Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
        Err(_) => {
            assert!(std::env::var_os("CI").is_none(), "CI has no valgrind");
            eprintln!("SKIPPED: there is no valgrind");
        }
    }
}

/// The example in C: the angle goes on, its rate and row are those of the turn, and errors are said.
#[test]
fn c_gets_what_a_connector_gives() {
    let Some(lines) = run("gcc", &["example.c"], "c") else { return };
    let near = |text: &str, want: f64| {
        let found: f64 = text.parse().expect("a number");
        assert!((found - want).abs() < 1e-11, "{text} is not {want}");
    };
    assert_eq!(lines.len(), 6, "{lines:?}");
    assert_eq!(lines[0], "kinds 0 1 1");
    let words: Vec<&str> = lines[1].split(' ').collect();
    near(words[1], 1.5 * std::f64::consts::PI);
    near(words[3], 2.0);
    near(words[5], 1.0);
    near(lines[2].rsplit(' ').next().expect("a word"), -0.5 * std::f64::consts::PI);
    assert!(lines[3].contains("NO SUCH TYPE"), "{}", lines[3]);
    assert!(lines[4].contains("is among the numbers of the pair"), "{}", lines[4]);
    assert_eq!(lines[5], "the connector is NULL");
}

/// The example in Fortran.
#[test]
fn fortran_gets_what_a_connector_gives() {
    let Some(lines) = run("gfortran", &["pintle.f90", "example.f90"], "fortran") else { return };
    let numbers: Vec<f64> = lines
        .iter()
        .map(|line| line.rsplit(' ').next().and_then(|x| x.parse().ok()).expect("a number"))
        .collect();
    assert_eq!(numbers.len(), 2, "{lines:?}");
    assert!((numbers[0] - 0.5).abs() < 1e-14 && (numbers[1] - 1.0).abs() < 1e-14, "{lines:?}");
}
