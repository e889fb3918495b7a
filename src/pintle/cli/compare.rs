//! `pintle compare`.

use super::eval::{read, source};
use super::reference::{both, length, reference};
use super::{Failure, page_width};
use clap::{Args, ValueEnum};
use pintle_compare::{Comparison, Map, Results, compare, digits, given, write_junit};
use pintle_model::evaluate::Model;
use pintle_scene::StateFile;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

const HELP: &str = "\
Compares what another program has written with what the connectors of a scene must
give along the same motion, number by number: CP, CU, CCU, CV, CA and forces of
connectors, reactions RF, RM and sums NF, NM of nodal forces, Jacobians and stiffness.

The motion is in the files, too: U and UR of the nodes (or q0 to q3), and V, VR
where rates are compared. Files given together are one run, joined by time. Tables
(.csv), records (.json, .jsonl), arrays (.npy, .npz) and what Abaqus and CalculiX
print (.dat) are read by their standard headings; a map in TOML says what others
mean. A matrix (.mtx, .npy, .npz) is the constraint Jacobian, as written by pintle
eval --jacobian, or the stiffness, at the last state.

A number stands for all that round to it: a difference within half a unit of its
last digit, and within what the digits of the motion allow, is none.

  [columns]
  \"Door angle\" = \"CUR1\"

Also in the map: node, element (of files that name none), rotation_angles and
angles (\"deg\"), length and force (the file's unit in the scene's), rotations
(\"incremental\"), single (true for single precision), matrix (\"jacobian\",
\"stiffness\"), matrix_state (from 0 on).

Examples:
  pintle compare model.inp --against model.dat
  pintle compare model.inp --against nodes.csv connectors.csv --map map.toml
  pintle compare model.inp --against model.dat stiffness.mtx --format junit
  pintle compare model.inp --against abaqus.dat --or mine.csv

Of references/NAME, a mechanism that pintle solve knows, it says how many digits a
run has: of each output, of the events (--events FILE, a table with time, connector
and event), and how fast what sticks creeps. The reference is solved at the times
of the run.

  pintle compare references/drawer --against my-run.csv --events my-events.csv

Exit codes: 0 all agree, 1 a number differs, 4 nothing was compared, 6 bad input.";

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
pub(crate) struct Compare {
    /// A scene (.inp, .toml, .json), gallery:NAME, or references/NAME
    #[arg(value_name = "SCENE")]
    scene: String,
    /// The files of one run: motions of nodes and outputs of connectors
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    against: Vec<PathBuf>,
    /// The files of another program's run, compared by themselves
    #[arg(long, value_name = "FILE", num_args = 1..)]
    or: Vec<PathBuf>,
    /// The events of the run, beside those of references/NAME (.csv)
    #[arg(long, value_name = "FILE")]
    events: Option<PathBuf>,
    /// What is not standard in the files, as TOML
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Where outputs have no motion at their time, take it between those before and after
    #[arg(long)]
    interpolate: bool,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Text for reading
    #[default]
    Human,
    /// One JSON document
    Json,
    /// JUnit XML, a case for each output
    Junit,
    /// Markdown, for a comment in a review
    Markdown,
    /// One self-contained page of HTML, with both curves
    Html,
}

/// The map of a file.
fn map(file: Option<&Path>) -> Result<Map, Failure> {
    let Some(file) = file else { return Ok(Map::default()) };
    let named = |why: String| Failure::Input(format!("{}: {why}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|error| named(error.to_string()))?;
    Map::from_toml(&text).map_err(named)
}

/// Whether a file of states is what pintle compare reads: another program's, or arrays of NumPy.
pub(crate) fn is_of_another(path: &Path) -> bool {
    let is = |known: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(known));
    ["dat", "npy", "npz"].into_iter().any(is)
}

/// The states of a file: pintle's own, another program's, arrays of NumPy.
pub(crate) fn any_states(
    path: &Path,
    scene: &pintle_scene::Scene,
) -> Result<Vec<pintle_scene::State>, Failure> {
    if is_of_another(path) { states(path, scene) } else { Ok(StateFile::read(path, scene)?.states) }
}

/// The states of such a file.
pub(crate) fn states(path: &Path, scene: &pintle_scene::Scene) -> Result<Vec<pintle_scene::State>, Failure> {
    let results = Results::new(vec![path.to_path_buf()], Map::default());
    let states = pintle_compare::states(scene, &results).map_err(Failure::Input)?;
    if states.is_empty() {
        return Err(Failure::Input(format!("{}: no motion of a node of the scene", path.display())));
    }
    Ok(states)
}

/// Which of two programs is right.
fn arbiter(found: &[(String, Comparison)]) -> Option<String> {
    let [(one, first), (other, second)] = found else { return None };
    if first.compared() == 0 || second.compared() == 0 {
        return None;
    }
    Some(match (first.wrong(), second.wrong()) {
        (0, 0) => format!("Both are right: {one}, and {other}."),
        (0, _) => format!("{one}: right. {other}: wrong."),
        (_, 0) => format!("{one}: wrong. {other}: right."),
        _ => format!("Neither is right: {one}, nor {other}."),
    })
}

/// Compares files with what a scene gives.
pub(crate) fn run(arguments: &Compare) -> Result<(), Failure> {
    if let Some(scene) = reference(&arguments.scene) {
        return beside_reference(arguments, &scene?);
    }
    if arguments.events.is_some() {
        return Err(Failure::Usage("--events are compared with those of references/NAME".to_string()));
    }
    let source = source(&arguments.scene)?;
    let (scene, _) = read(source, None)?;
    let model = Model::compile(&scene).map_err(|error| source.quoted(error))?;
    let map = map(arguments.map.as_deref())?;
    let mut found: Vec<(String, Comparison)> = Vec::new();
    for files in [&arguments.against, &arguments.or] {
        if files.is_empty() {
            continue;
        }
        let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        let mut results = Results::new(files.clone(), map.clone());
        results.interpolates = arguments.interpolate;
        found.push((names.join(", "), compare(&scene, &model, &results).map_err(Failure::Input)?));
    }
    let mut out = BufWriter::new(anstream::stdout().lock());
    match arguments.format {
        Format::Human => {
            let width = page_width(&io::stdout());
            if let Some(words) = arbiter(&found) {
                writeln!(out, "{words}\n")?;
            }
            for (n, (name, comparison)) in found.iter().enumerate() {
                if n > 0 {
                    writeln!(out)?;
                }
                comparison.write_human(&mut out, name, width)?;
            }
        }
        Format::Json => {
            let all: Vec<serde_json::Value> = found
                .iter()
                .map(|(name, comparison)| {
                    serde_json::json!({ "schema": "pintle-comparison/1", "files": name,
                        "headline": comparison.headline(), "comparison": comparison })
                })
                .collect();
            serde_json::to_writer_pretty(&mut out, &all).map_err(io::Error::from)?;
            writeln!(out)?;
        }
        Format::Junit => write_junit(&mut out, &found)?,
        Format::Markdown => {
            for (name, comparison) in &found {
                comparison.write_markdown(&mut out, name)?;
            }
        }
        Format::Html => {
            for (name, comparison) in &found {
                comparison.write_html(&mut out, name)?;
            }
        }
    }
    out.flush()?;
    if found.iter().any(|(_, comparison)| comparison.compared() == 0) {
        return Err(Failure::Nothing("no number of the files could be compared".to_string()));
    }
    if found.iter().any(|(_, comparison)| comparison.wrong() > 0) { Err(Failure::Mismatch) } else { Ok(()) }
}

/// Says how many digits a run has of a reference.
fn beside_reference(arguments: &Compare, scene: &pintle_scene::Scene) -> Result<(), Failure> {
    let map = map(arguments.map.as_deref())?;
    let events = arguments.events.as_deref().map(given).transpose().map_err(Failure::Input)?;
    let mut out = BufWriter::new(anstream::stdout().lock());
    let mut documents = Vec::new();
    for files in [&arguments.against, &arguments.or] {
        if files.is_empty() {
            continue;
        }
        let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        let names = names.join(", ");
        let results = Results::new(files.clone(), map.clone());
        let run = pintle_compare::Run::read(&results).map_err(Failure::Input)?;
        let (solution, difference) = both(scene, run.times([0.0, length(scene)]))?;
        let found = digits(&solution, &run, events.as_deref());
        let Some(fewest) = found.fewest() else {
            return Err(Failure::Nothing("no number of the files is one of the reference".to_string()));
        };
        match arguments.format {
            Format::Human => {
                let width = page_width(&io::stdout());
                let told = format!(
                    "{names}: {:.1} digits at least, beside {} (its own error is {:.0e})",
                    fewest.digits,
                    arguments.scene,
                    difference.largest()
                );
                for line in pintle_report::wrap(&told, width) {
                    writeln!(out, "{line}")?;
                }
                writeln!(out)?;
                found.write_human(&mut out, width)?;
            }
            Format::Json => documents.push(serde_json::json!({
                "schema": "pintle-digits/1", "files": names, "reference": arguments.scene,
                "error": difference, "digits": found,
            })),
            Format::Html | Format::Junit | Format::Markdown => {
                return Err(Failure::Usage("digits are written as text or JSON".to_string()));
            }
        }
    }
    if !documents.is_empty() {
        serde_json::to_writer_pretty(&mut out, &documents).map_err(io::Error::from)?;
        writeln!(out)?;
    }
    Ok(out.flush()?)
}
