//! The `pintle` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    pintle::command::main(std::env::args_os())
}
