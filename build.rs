//! What the program was built by and for, which `pintle bench` records beside its numbers.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let version = Command::new(variable("RUSTC")).arg("--version").output();
    let version = version.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_string());
    println!("cargo:rustc-env=PINTLE_RUSTC={}", version.unwrap_or_default());
    println!("cargo:rustc-env=PINTLE_TARGET={}", variable("TARGET"));
    println!("cargo:rustc-env=PINTLE_OPT_LEVEL={}", variable("OPT_LEVEL"));
}
