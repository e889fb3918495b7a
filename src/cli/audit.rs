//! `pintle audit`.

use super::{Failure, page_width};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use pintle::audit::{Oracle, Report, Settings, audit_catalogue};
use pintle::report::audit as report;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// How an audit is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum AuditFormat {
    /// Text for reading
    #[default]
    Human,
    /// One JSON document, schema pintle-audit/1
    Json,
    /// JUnit XML, for continuous integration
    Junit,
    /// Markdown, for a comment on a change
    Markdown,
}

#[derive(Debug, Args)]
pub(crate) struct Audit {
    /// States per type for the oracles on doubles
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().states)]
    states: usize,
    /// States per type near its singular sets, besides
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().near_singular_states)]
    near_singular_states: usize,
    /// States per type for the oracles on 237 bits
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().wide_states)]
    wide_states: usize,
    /// What random states are drawn from
    #[arg(long, value_name = "WORD", default_value_t = Settings::default().seed)]
    seed: String,
    /// Only these oracles, separated by commas: wide-differences, wide-dual, taylor, nodal-dual, hyper-dual, differences
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = oracle)]
    oracles: Vec<Oracle>,
    /// Write a counter-example for every mismatch into this folder, for `pintle replay`
    #[arg(long, value_name = "FOLDER")]
    counter_examples: Option<PathBuf>,
    /// Exit with 3 where something is undecided
    #[arg(long)]
    strict: bool,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: AuditFormat,
    /// Show every check
    #[arg(short, long)]
    verbose: bool,
}

fn oracle(name: &str) -> Result<Oracle, String> {
    let names = || Oracle::ALL.map(Oracle::name).join(", ");
    let found = Oracle::ALL.into_iter().find(|oracle| oracle.name().eq_ignore_ascii_case(name));
    found.ok_or_else(|| format!("there is no oracle {name:?}; there are {}", names()))
}

/// Audits and writes the report.
pub(crate) fn run(arguments: &Audit) -> Result<(), Failure> {
    let mut settings = Settings {
        states: arguments.states,
        near_singular_states: arguments.near_singular_states,
        wide_states: arguments.wide_states,
        seed: arguments.seed.clone(),
        ..Settings::default()
    };
    if !arguments.oracles.is_empty() {
        settings.oracles = arguments.oracles.iter().copied().collect();
    }
    let bar = ProgressBar::new(pintle::catalog::TABLE.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    let report = audit_catalogue(&settings, &|name: &str| {
        bar.inc(1);
        bar.set_message(name.to_string());
    });
    bar.finish_and_clear();
    write(arguments.format, arguments.verbose, &report)?;
    if let Some(folder) = &arguments.counter_examples {
        save(folder, &report)?;
    }
    verdict(arguments.strict, &report)
}

/// Writes the counter-examples of a report, shrunk to the simplest values that still fail.
fn save(folder: &Path, report: &Report) -> Result<(), Failure> {
    let cannot = |error: &dyn std::fmt::Display| {
        Failure::Input(format!("cannot write counter-examples to {}: {error}", folder.display()))
    };
    fs::create_dir_all(folder).map_err(|error| cannot(&error))?;
    for (name, example) in report.counter_examples() {
        let text = serde_json::to_string_pretty(&example).map_err(|error| cannot(&error))?;
        fs::write(folder.join(name), text + "\n").map_err(|error| cannot(&error))?;
    }
    Ok(())
}

/// Writes a report.
pub(super) fn write(format: AuditFormat, verbose: bool, found: &Report) -> Result<(), Failure> {
    match format {
        AuditFormat::Human => {
            let mut out = BufWriter::new(anstream::stdout().lock());
            report::human(&mut out, found, page_width(&io::stdout()), verbose)?;
            Ok(out.flush()?)
        }
        AuditFormat::Json => {
            let mut out = BufWriter::new(io::stdout().lock());
            report::json(&mut out, found)?;
            Ok(out.flush()?)
        }
        AuditFormat::Junit => {
            let mut out = BufWriter::new(io::stdout().lock());
            report::junit(&mut out, found)?;
            Ok(out.flush()?)
        }
        AuditFormat::Markdown => {
            let mut out = BufWriter::new(io::stdout().lock());
            report::markdown(&mut out, found)?;
            Ok(out.flush()?)
        }
    }
}

/// The exit code of a report.
pub(super) fn verdict(strict: bool, report: &Report) -> Result<(), Failure> {
    if report.survivors() > 0 {
        return Err(Failure::SelfTest);
    }
    if report.mismatches() > 0 {
        return Err(Failure::Mismatch);
    }
    if report.compared() == 0 {
        return Err(Failure::Nothing("no number was compared".into()));
    }
    if strict && report.undecided() > 0 {
        return Err(Failure::Undecided);
    }
    Ok(())
}
