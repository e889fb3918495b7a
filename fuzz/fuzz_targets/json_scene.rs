#![no_main]
#[path = "../targets.rs"]
mod targets;

targets::target!(json_scene);
