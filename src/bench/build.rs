//! What the program was built by, for and from, which `pintle bench` and the page of `pintle audit` record beside their numbers.

use std::path::Path;
use std::process::Command;

/// The folder of the workspace, from that of this package.
const ROOT: &str = "../..";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let version = Command::new(variable("RUSTC")).arg("--version").output();
    let version = version.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_string());
    println!("cargo:rustc-env=PINTLE_RUSTC={}", version.unwrap_or_default());
    println!("cargo:rustc-env=PINTLE_TARGET={}", variable("TARGET"));
    println!("cargo:rustc-env=PINTLE_OPT_LEVEL={}", variable("OPT_LEVEL"));
    println!("cargo:rerun-if-changed={ROOT}/Cargo.lock");
    let lock = std::fs::read_to_string(format!("{ROOT}/Cargo.lock")).unwrap_or_default();
    println!("cargo:rustc-env=PINTLE_NUMBERS={}, {}", locked(&lock, "f256"), locked(&lock, "num-dual"));
    if let Some(commit) = commit() {
        println!("cargo:rustc-env=PINTLE_COMMIT={commit}");
    }
}

/// What git says in this folder, where there is a git and it has something to say.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git")
        .current_dir(ROOT)
        .args(arguments)
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_string())
}

/// The commit that a release is built of, with a mark where tracked files are others than it has. There is none where the sources
/// are not a repository of their own, as those of a registry.
fn commit() -> Option<String> {
    // A build for development would be made anew after each commit.
    let is_for_development = std::env::var("PROFILE").is_ok_and(|profile| profile == "debug");
    if is_for_development || !Path::new(ROOT).join(".git").exists() {
        return None;
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let place = |name: &str| {
        git(&["rev-parse", "--git-path", name])
            .map(|path| Path::new(ROOT).join(path))
            .filter(|path| path.exists())
    };
    // What does not exist would be watched in vain, and the crate built again each time.
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    let branch = branch.map(|branch| place(&branch).or_else(|| place("packed-refs")));
    for path in [place("HEAD"), branch.flatten()].into_iter().flatten() {
        println!("cargo:rerun-if-changed={}", path.display());
    }
    let sources = ["src", "decks", "Cargo.toml", "Cargo.lock"];
    sources.iter().for_each(|path| println!("cargo:rerun-if-changed={ROOT}/{path}"));
    let changed = git(&[&["status", "--porcelain", "--untracked-files=no", "--"], &sources[..]].concat());
    Some(if changed.is_none_or(|changed| !changed.is_empty()) {
        format!("{commit}, with changes")
    } else {
        commit
    })
}

/// The name of a package with the version that the lock file holds, if there is one.
fn locked(lock: &str, name: &str) -> String {
    let entry = lock.split("[[package]]").find(|entry| entry.contains(&format!("name = \"{name}\"\n")));
    let version = entry.and_then(|entry| entry.split("version = \"").nth(1)?.split('"').next());
    version.map_or_else(|| name.to_string(), |version| format!("{name} {version}"))
}
