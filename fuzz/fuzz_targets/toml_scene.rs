#![no_main]
#[path = "../targets.rs"]
mod targets;

targets::target!(toml_scene);
