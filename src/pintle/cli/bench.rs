//! `pintle bench`.

use super::{Failure, Files, page_width};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use pintle_bench::{Report, Settings, measure};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_report::bench as report;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

const HELP: &str = "\
For each type, far from its singular points, near one (or near half a turn,
where a rotation vector is measured) and where almost nothing is turned (1e-8
rad): the time of one state with all its rows,
and the error against 237-bit numbers, of pintle one connector at a time and in
batches (values with rows, or with second derivatives besides, of four states at
a time on the vector unit that the processor has, which is named), of finite
differences over a sweep of steps, and of num-dual's
dual numbers with a direction for every degree of freedom of the nodes. The
error of a value is over |f| + Σ |∂f/∂q| s, s = 1 rad or the length of the
connector, that of a derivative over the largest number of its row. Before
anything is timed each is asserted, of a sweep of steps the best: what is wrong is
not timed, and said in its place. The ways take turns in rounds, on one thread,
and of each the least time counts, so that other work on the machine disturbs
all alike; the column × pintle is the ratio to trust. Tables show of a sweep the
step with the smallest error; JSON and CSV have all.

One-forms (FLOW-CONVERTER, and its row of RETRACTOR) have no function to
difference and are left out by every way, which the report says.
Batches read and write tiles of four states, which are made before the clock
starts; types whose rows depend on material flow have none. Rows by hand, JAX and
CasADi are measured by the crate's benches: cargo bench --bench work_precision, and scripts/measure.py.

Exit codes: 1 where a number of pintle is wrong (after all else has been measured
and told), 4 where nothing can be measured, 6 where figures cannot be written,
which is seen before anything is measured.

Examples:
  pintle bench HINGE
  pintle bench REVOLUTE \"CARTESIAN CARDAN\" --plots figures
  pintle bench --rounds 20 --format csv > times.csv";

/// How times are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum BenchFormat {
    /// Tables for reading
    #[default]
    Human,
    /// One JSON document, schema pintle-bench/1
    Json,
    /// One table in long form
    Csv,
    /// Markdown, for a comment on a change
    Markdown,
}

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
pub(crate) struct Bench {
    /// Connection types, in any case; a free pair as one word in quotes; without any, the whole catalogue
    #[arg(value_name = "TYPE")]
    types: Vec<String>,
    /// Rounds, in which every way takes its turn
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().rounds as u32, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rounds: u32,
    /// States of each type and place; a thousand of them take 100 MB
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().states as u32, value_parser = clap::value_parser!(u32).range(1..=1000))]
    states: u32,
    /// How far states near a singular point are from it (rad, or lengths of the connector)
    #[arg(long, value_name = "DISTANCE", default_value_t = Settings::default().distance, value_parser = distance)]
    near: f64,
    /// Draw time against error into this folder, a figure for each type, place and order, as SVG files
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: BenchFormat,
}

fn distance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(distance) if (1e-12..=0.1).contains(&distance) => Ok(distance),
        _ => Err(format!("{text:?} is not a distance from 1e-12 to 0.1")),
    }
}

/// Measures and writes the report.
pub(crate) fn run(arguments: &Bench, files: Files) -> Result<(), Failure> {
    let types: Vec<ConnectionType> = match arguments.types.as_slice() {
        [] => TABLE.to_vec(),
        names => {
            let mut types: Vec<ConnectionType> = Vec::new();
            for name in names {
                let connection = named(name)?;
                if types.iter().all(|known| known.name != connection.name) {
                    types.push(connection);
                }
            }
            types
        }
    };
    let settings = Settings {
        rounds: arguments.rounds as usize,
        states: arguments.states as usize,
        distance: arguments.near,
        ..Settings::default()
    };
    arguments.plots.as_deref().map_or(Ok(()), |folder| writable(folder, files))?;
    let bar = ProgressBar::new(types.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    let progress = |name: &str| {
        bar.inc(1);
        bar.set_message(name.to_string());
    };
    let found = measure(&settings, &types, &progress);
    bar.finish_and_clear();
    if found.points.is_empty() && found.wrong.is_empty() {
        return Err(Failure::Nothing("of these types there is nothing to measure but one-forms".into()));
    }
    write(arguments.format, &found)?;
    arguments.plots.as_ref().map_or(Ok(()), |folder| draw(folder, &found, files))?;
    found.wrong.iter().for_each(|wrong| crate::cli::tell::complain("error", &wrong.to_string()));
    if found.wrong.is_empty() { Ok(()) } else { Err(Failure::Mismatch) }
}

/// A type, or the two of a free pair.
fn named(name: &str) -> Result<ConnectionType, Failure> {
    let words: Vec<&str> = name.split_whitespace().collect();
    match words[..] {
        // Some types have names of two words.
        [first, second] => {
            crate::cli::connection(name, None).or_else(|_| crate::cli::connection(first, Some(second)))
        }
        _ => crate::cli::connection(name, None),
    }
}

/// Makes a folder; refuses one in which no file can be made.
fn writable(folder: &Path, files: Files) -> Result<(), Failure> {
    files.check_folder(Some(folder), "svg")?;
    files.folder(folder)?;
    let probe = folder.join(format!(".pintle-{}", std::process::id()));
    files.text(&probe, "?")?;
    Ok(fs::remove_file(&probe)?)
}

fn draw(folder: &Path, found: &Report, files: Files) -> Result<(), Failure> {
    report::figures(found).into_iter().try_for_each(|(name, svg)| files.text(&folder.join(name), svg))
}

fn write(format: BenchFormat, found: &Report) -> Result<(), Failure> {
    let mut out = BufWriter::new(anstream::stdout().lock());
    match format {
        BenchFormat::Human => report::human(&mut out, found, page_width(&io::stdout()))?,
        BenchFormat::Json => report::json(&mut out, found)?,
        BenchFormat::Csv => report::csv(&mut out, found)?,
        BenchFormat::Markdown => report::markdown(&mut out, found)?,
    }
    Ok(out.flush()?)
}
