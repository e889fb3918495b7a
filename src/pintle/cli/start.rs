//! The command line from its words to its exit code.

use super::{Cli, Command, Failure, Files};
use crate::cli;
use clap::Parser;
use std::ffi::OsString;
use std::io::{self, Write};
use std::panic;
use std::thread::{self, ScopedJoinHandle};

/// The exit code of an internal error.
const INTERNAL_ERROR: u8 = 70;

/// Runs the command `pintle` with these words, the first of which is its name, and gives its exit code.
///
/// Results go to standard output, everything else to standard error. An internal error ends the process.
pub fn command_line(words: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(words) {
        Ok(cli) => cli,
        // Wrong words, or help: what cannot be written is an error here, too.
        Err(told) => {
            let written = told.print().and_then(|()| io::stdout().flush());
            return match (written, u8::try_from(told.exit_code())) {
                (Err(error), _) if !told.use_stderr() => Failure::from(error).report(),
                (_, code) => code.unwrap_or(INTERNAL_ERROR),
            };
        }
    };
    panic::set_hook(Box::new(|defect| {
        cli::tell::complain("internal error", &format!("{defect}"));
        cli::tell::complain(
            "note",
            "this is a defect of pintle; please report it with the command and its input",
        );
        std::process::exit(INTERNAL_ERROR.into());
    }));
    let outcome = thread::scope(|scope| {
        let thread = thread::Builder::new().stack_size(cli::STACK);
        thread.spawn_scoped(scope, || run(&cli)).map(ScopedJoinHandle::join)
    });
    match outcome {
        Ok(Ok(Ok(()))) => 0,
        Ok(Ok(Err(failure))) => failure.report(),
        Ok(Err(_)) => INTERNAL_ERROR,
        Err(error) => {
            cli::tell::complain("error", &format!("no thread could be started: {error}"));
            INTERNAL_ERROR
        }
    }
}

fn run(cli: &Cli) -> Result<(), Failure> {
    cli::use_threads(cli.threads)?;
    let files = Files::new(cli.force);
    match &cli.command {
        Command::List(arguments) => cli::list(arguments),
        Command::Explain(arguments) => cli::explain(arguments),
        Command::Eval(arguments) => cli::eval::run(arguments, files),
        Command::Convert(arguments) => cli::convert::run(arguments, files),
        Command::Export(arguments) => cli::export::run(arguments, files),
        Command::Schema { of } => cli::convert::schema(*of),
        Command::Audit(arguments) => cli::audit::run(arguments, files),
        Command::Check(arguments) => cli::check::run(arguments),
        Command::States(arguments) => cli::states::run(arguments, files),
        Command::Compare(arguments) => cli::compare::run(arguments),
        Command::Solve(arguments) => cli::solve::run(arguments, files),
        Command::Sweep(arguments) => cli::sweep::run(arguments, files),
        Command::Element(arguments) => cli::check::serve(arguments),
        Command::Replay(arguments) => cli::replay::run(arguments, files),
        Command::Bench(arguments) => cli::bench::run(arguments, files),
        Command::Completions(arguments) => cli::manual::completions(arguments),
        Command::Man(arguments) => cli::manual::man(arguments, files),
        #[cfg(debug_assertions)]
        #[expect(clippy::panic, reason = "its purpose")]
        Command::Panic => panic!("as asked"),
    }
}
