//! What the program was built by, for and from, which `pintle bench` and the page of `pintle audit` record beside their numbers.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let version = Command::new(variable("RUSTC")).arg("--version").output();
    let version = version.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_string());
    println!("cargo:rustc-env=PINTLE_RUSTC={}", version.unwrap_or_default());
    println!("cargo:rustc-env=PINTLE_TARGET={}", variable("TARGET"));
    println!("cargo:rustc-env=PINTLE_OPT_LEVEL={}", variable("OPT_LEVEL"));
    println!("cargo:rerun-if-changed=Cargo.lock");
    let lock = std::fs::read_to_string("Cargo.lock").unwrap_or_default();
    println!("cargo:rustc-env=PINTLE_NUMBERS={}, {}", locked(&lock, "f256"), locked(&lock, "num-dual"));
}

/// The name of a package with the version that the lock file holds, if there is one.
fn locked(lock: &str, name: &str) -> String {
    let entry = lock.split("[[package]]").find(|entry| entry.contains(&format!("name = \"{name}\"\n")));
    let version = entry.and_then(|entry| entry.split("version = \"").nth(1)?.split('"').next());
    version.map_or_else(|| name.to_string(), |version| format!("{name} {version}"))
}
