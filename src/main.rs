//! The `pintle` command.

mod cli;

use clap::Parser;
use cli::{Cli, Command, TextFormat};
use pintle::catalog::ConnectionType;
use pintle::report::{self, explain::Explanation};
use std::io::{self, Write};
use std::process::ExitCode;

/// What ends a command early. Each has its exit code.
#[derive(Debug, thiserror::Error)]
enum Failure {
    /// 2
    #[error("{0}")]
    Usage(String),
    /// The reader of our output has gone: not an error.
    #[error(transparent)]
    Output(#[from] io::Error),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(2)
        }
    }
}

fn run(cli: &Cli) -> Result<(), Failure> {
    match &cli.command {
        Command::List(list) => {
            let mut out = anstream::stdout().lock();
            match list.format {
                TextFormat::Human => report::list::human(&mut out, 100)?,
                TextFormat::Json => report::list::json(&mut out)?,
            }
            out.flush()?;
        }
        Command::Explain(explain) => {
            let connection = ConnectionType::named(&explain.name, explain.second.as_deref())
                .map_err(|error| Failure::Usage(error.to_string()))?;
            let explanation = Explanation::of(&connection);
            let mut out = anstream::stdout().lock();
            match explain.format {
                TextFormat::Human => explanation.human(&mut out, 100)?,
                TextFormat::Json => explanation.json(&mut out)?,
            }
            out.flush()?;
        }
        Command::Eval(_) => {}
    }
    Ok(())
}
