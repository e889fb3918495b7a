//! `pintle replay`.

use super::audit::AuditFormat;
use super::{Failure, Files, one_of};
use clap::{Args, ValueEnum};
use pintle_audit::{CounterExample, ExportError, Planted, Settings};
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// The forms of counter-examples for others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    /// A test in Rust that needs this crate
    Rust,
    /// A script for Python with JAX: the reference formulas at the same state
    Jax,
    /// A deck, for which -o is needed: its states are in a file beside it, the ending replaced by .states.json
    Inp,
}

#[derive(Debug, Args)]
pub(crate) struct Replay {
    /// A counter-example, as `pintle audit --counter-examples` or `pintle sweep --state` writes it
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Plant a fault, to see the state fail
    #[arg(long, value_parser = one_of(Planted::ALL, Planted::name), hide = true)]
    plant: Option<Planted>,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: AuditFormat,
    /// Write it in another form instead of judging it
    #[arg(long, value_enum, value_name = "FORM", conflicts_with = "format")]
    export: Option<Form>,
    /// Where to write that form; without it, to standard output. A deck needs it: its states are in a file beside it
    #[arg(short, long, value_name = "FILE", requires = "export")]
    output: Option<PathBuf>,
}

/// Writes a counter-example in another form.
fn export(
    form: Form,
    example: &CounterExample,
    name: &str,
    (output, files): (Option<&Path>, Files),
) -> Result<(), Failure> {
    let refused = |error: ExportError| Failure::Input(format!("{name} cannot be exported: {error}"));
    let text = match form {
        Form::Rust => example.rust().map_err(refused)?,
        Form::Jax => example.jax().map_err(refused)?,
        Form::Inp => {
            let Some(output) = output else {
                let message = "a deck has its states in a file beside it: say where by -o FILE.inp";
                return Err(Failure::Usage(message.to_string()));
            };
            let deck = example.deck().map_err(refused)?;
            let states = output.with_extension("states.json");
            files.check([&output.to_path_buf(), &states])?;
            files.text(&states, &deck.states)?;
            deck.text
        }
    };
    match output {
        Some(path) => files.text(path, &text),
        None => {
            let mut out = BufWriter::new(io::stdout().lock());
            out.write_all(text.as_bytes())?;
            Ok(out.flush()?)
        }
    }
}

/// Judges the state of a counter-example again, by every oracle, or writes it in another form.
pub(crate) fn run(arguments: &Replay, files: Files) -> Result<(), Failure> {
    let name = arguments.file.display().to_string();
    let text = fs::read_to_string(&arguments.file)
        .map_err(|error| Failure::Input(format!("cannot read {name}: {error}")))?;
    let example = CounterExample::read(&text).map_err(|error| {
        Failure::Input(format!("{name} is no counter-example, as --counter-examples writes it: {error}"))
    })?;
    let failing =
        example.failing().map_err(|error| Failure::Input(format!("{name} cannot be replayed: {error}")))?;
    if let Some(form) = arguments.export {
        return export(form, &example, &name, (arguments.output.as_deref(), files));
    }
    if matches!(arguments.format, AuditFormat::Human) {
        let CounterExample { subject, version, entry, against, got, want, tolerance, .. } = &example;
        let entry = if entry.is_empty() { "no entry" } else { entry };
        let mut out = BufWriter::new(anstream::stdout().lock());
        writeln!(
            out,
            "{name}: {} by {subject} of version {version}: {entry} against {against}\n  given {got}, must be {want}, tolerance \
             {tolerance}\n",
            failing.title()
        )?;
        out.flush()?;
    }
    let planted = arguments.plant;
    let oracles = example.oracles();
    let settings = Settings { wide_states: 1, atlas: false, oracles, planted, ..Settings::default() };
    let report = failing.audit(&settings);
    crate::cli::audit::write(arguments.format, true, &report)?;
    crate::cli::audit::verdict(&report)
}
