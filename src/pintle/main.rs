//! The `pintle` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(pintle::command_line(std::env::args_os()))
}
