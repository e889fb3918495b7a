#![no_main]
#[path = "../targets.rs"]
mod targets;

targets::target!(csv_states);
