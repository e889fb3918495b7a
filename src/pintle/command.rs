//! The `pintle` command, for the program and for what carries it along.

use crate::cli::{self, Cli, Command, Failure, Files};
use clap::Parser;
use pintle_kinematics::connector::Definition;
use pintle_scene::Scene;
use std::ffi::OsString;
use std::panic;
use std::process::ExitCode;
use std::thread::{self, ScopedJoinHandle};

/// The exit code of an internal error.
const INTERNAL_ERROR: u8 = 70;

/// Runs the command of these arguments, the first of which is the name of the program.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let cli = Cli::parse_from(arguments);
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
        Ok(Ok(Ok(()))) => ExitCode::SUCCESS,
        Ok(Ok(Err(failure))) => failure.report(),
        Ok(Err(_)) => ExitCode::from(INTERNAL_ERROR),
        Err(error) => {
            cli::tell::complain("error", &format!("no thread could be started: {error}"));
            ExitCode::from(INTERNAL_ERROR)
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

/// The connector of a TYPE, or of SCENE:ELEMENT.
///
/// # Errors
/// In words, why there is none.
pub fn connector(name: &str) -> Result<Definition, String> {
    cli::check::subject(name).map(|subject| subject.definition).map_err(|failure| failure.to_string())
}

/// A scene of a file, or `gallery:NAME`, with its states.
///
/// # Errors
/// All that is wrong with it, in words.
pub fn scene(name: &str) -> Result<Scene, String> {
    let read = cli::eval::source(name).and_then(|source| cli::eval::read(source, None));
    let (mut scene, states) = read.map_err(|failure| failure.to_string())?;
    scene.states = states;
    Ok(scene)
}
