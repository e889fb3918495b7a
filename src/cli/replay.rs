//! `pintle replay`.

use super::Failure;
use super::audit::{AuditFormat, Plant};
use clap::Args;
use pintle::audit::{Case, CounterExample, Planted, Settings, audit_cases};
use std::fs;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct Replay {
    /// A counter-example, as `pintle audit --counter-examples` writes it
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Plant a fault, to see the state fail
    #[arg(long, value_enum, hide = true)]
    plant: Option<Plant>,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: AuditFormat,
}

/// Judges the state of a counter-example again, by every oracle.
pub(crate) fn run(arguments: &Replay) -> Result<(), Failure> {
    let name = arguments.file.display();
    let text = fs::read_to_string(&arguments.file)
        .map_err(|error| Failure::Input(format!("cannot read {name}: {error}")))?;
    let example: CounterExample = serde_json::from_str(&text).map_err(|error| {
        Failure::Input(format!("{name} is no counter-example, as --counter-examples writes it: {error}"))
    })?;
    let case: Case =
        example.case().map_err(|error| Failure::Input(format!("{name} cannot be replayed: {error}")))?;
    if matches!(arguments.format, AuditFormat::Human) {
        let mut out = BufWriter::new(anstream::stdout().lock());
        writeln!(
            out,
            "{name}: {} by {} of version {}: {} against {}\n  given {}, must be {}, tolerance {}\n",
            case.definition.connection.name,
            example.subject,
            example.version,
            if example.entry.is_empty() { "no entry" } else { &example.entry },
            example.against,
            example.got,
            example.want,
            example.tolerance
        )?;
        out.flush()?;
    }
    let planted = arguments.plant.map(Planted::from);
    let settings = Settings { wide_states: 1, atlas: false, planted, ..Settings::default() };
    let title = format!("{} now", case.definition.connection.name);
    let report = audit_cases(&settings, &[(title, vec![case])], &|_| {});
    super::audit::write(arguments.format, true, &report)?;
    super::audit::verdict(false, &report)
}
