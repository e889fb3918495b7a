//! `pintle sweep`.

mod own;

pub use own::{Own, Programs, Start, routines};

use super::audit::Bar;
use super::subject::{drawn_aligned, in_scene, model_of_scene, named, type_of};
use super::tell::complain;
use super::{Failure, Files, one_of, page_width};
use clap::{Args, ValueEnum};
use pintle_audit::{Against, CounterExample, Oracle};
use pintle_kinematics::connector::Definition;
use pintle_report::sweep as report;
use pintle_sweep::ranges::checked;
use pintle_sweep::sweep::Planted;
use pintle_sweep::{Folder, Generator, OfSubject, Plan, Ranges, Subject, Summary, Sweep, SweepError};
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

const HELP: &str = "\
States are drawn by their indices, from 0 on, and none is stored: state 7 of a
seed is the same state in every run, however the work is shared out. Of every
state all values and rows are computed, four at a time. All are asked whether
they are finite, and whether the columns of both nodes belong together: along a
rigid motion nothing is left (\"rigid\"; \"—\" where a row has not all columns).
One state in 16 is turned as a whole, exactly, and computed again with second
derivatives: values and rows must follow (\"frame\"). A share of the states is
judged on 237 bits as pintle audit judges, but for its referee. Only that share
tells a wrong formula; all these choices are made by the indices of states.

With --generator sobol the states of a connector are a Sobol sequence, which the
seed scrambles: they fill its motions more evenly than random ones. States near
singular points stay random.

What is kept is a summary: counts, extrema with their indices, histograms of
integers, the worst states, and a sum over all bits of all numbers. Summaries
merge exactly, so that any partition, order, engine and number of threads give
the same digest. Machines must round alike: the vector unit and the library's
sin, cos, tan, acos, atan2, pow, exp and log are part of a summary, and those
of two kinds refuse to merge.

With --out every chunk is a file of its own, written beside its name and
renamed. The same command again computes what is not there: a worker that is
killed loses the chunk in flight, and nothing else is lost. Machines that share
a folder take a part each: --range 0/8 is the first of eight. --merge prints
what a folder holds. A folder with more states than asked for has all of them
in its summary.

With --python, --library or --with (as in pintle check) the numbers are those of
your routine. It is asked for values and rows at every state. Each is compared
with pintle's; where both cannot be right within their bounds, and at the share,
237 bits judge. Other angles of the same rotation are not judged, nor is what is
no number on a singular set: pintle check judges histories. A process that ends
at a state is started again, up to twenty times, and has no numbers there.
Initial orientations are those that the type allows. Of types with material flow
the share alone is judged.

Exit codes: 1 where a number is wrong, 4 where no number of a routine was
compared, 6 where a folder is of another sweep or cannot be read, 7 where it
cannot be written.

Examples:
  pintle sweep --states 1e5
  pintle sweep REVOLUTE \"CARTESIAN CARDAN\" --states 1e7 --oracle-share 1e-4
  pintle sweep --states 1e9 --out all --picture all.svg
  pintle sweep SLOT --generator sobol
  pintle sweep model.inp --states 1e8 --range $SLURM_ARRAY_TASK_ID/100 --out model
  pintle sweep UJOINT --states 1e7 --library ./ujoint.so
  pintle sweep --merge all --picture all.svg
  pintle sweep REVOLUTE --state 4711 > it.json; pintle replay it.json";

/// How a summary is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A table for reading
    #[default]
    Human,
    /// One JSON document, schema pintle-sweep/2
    Json,
}

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
pub(crate) struct SweepOf {
    /// Connection types, a pair as one word in quotes, scenes, or connectors of scenes, model.inp:101 [default: all types]
    #[arg(value_name = "TYPE|SCENE|SCENE:ELEMENT")]
    of: Vec<String>,
    /// How many states, such as 1e9
    #[arg(long, value_name = "COUNT", default_value = "1e6", value_parser = whole)]
    states: u64,
    /// Compute part i of n of them, from 0 on
    #[arg(long, value_name = "i/n", default_value = "0/1")]
    range: Part,
    /// The share of the states that is judged on 237 bits
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3, value_parser = share)]
    oracle_share: f64,
    /// By what the states are drawn
    #[arg(long, value_enum, default_value_t)]
    generator: Generated,
    /// What the states are drawn from
    #[arg(long, value_name = "TEXT", default_value = "pintle")]
    seed: String,
    /// Keep each chunk in this folder, and compute those that are not there
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// The states of a chunk, which a kill may lose
    #[arg(long, value_name = "COUNT", default_value = "1e6", value_parser = whole)]
    chunk: u64,
    /// Print what a folder holds, and compute nothing
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["of", "states", "range", "oracle_share", "generator", "seed", "out", "chunk"])]
    merge: Option<PathBuf>,
    /// Print the state of that index, and nothing else. pintle replay reads it, and judges pintle's own numbers there, not those of a routine
    #[arg(long, value_name = "INDEX", conflicts_with_all = ["states", "range", "out", "chunk", "merge", "picture", "format"])]
    state: Option<u64>,
    /// Draw the worst errors over the distance to singular sets (SVG)
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// The command that starts a routine, for a shell, whose numbers are swept in place of pintle's
    #[arg(long, value_name = "COMMAND", group = "routine", requires = "of")]
    with: Option<String>,
    /// The same for a Python function
    #[arg(long, value_name = "MODULE:FUNCTION", group = "routine", requires = "of")]
    python: Option<String>,
    /// The same for a shared library with a routine of pintle_element.h
    #[arg(long, value_name = "FILE", group = "routine", requires = "of")]
    library: Option<PathBuf>,
    /// A TOML file with what differs from pintle's conventions, in place of what the routine says
    #[arg(long, value_name = "FILE", requires = "routine")]
    convention: Option<PathBuf>,
    /// Seconds that one answer of a routine may take
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = super::check::positive)]
    timeout: f64,
    /// Put a fault into the numbers, to see it found
    #[arg(long, value_parser = one_of(Planted::ALL, Planted::name), hide = true, conflicts_with_all = ["out", "merge", "state"])]
    plant: Option<Planted>,
}

/// [`Generator`].
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Generated {
    /// Random numbers by their index, Philox4x32-10
    #[default]
    Philox,
    /// The Sobol sequence of each connector, scrambled by the seed: states that lie more evenly
    Sobol,
}

impl From<Generated> for Generator {
    fn from(generated: Generated) -> Self {
        match generated {
            Generated::Philox => Self::Philox,
            Generated::Sobol => Self::Sobol,
        }
    }
}

/// Part i of n.
#[derive(Clone, Copy, Debug)]
struct Part {
    i: u64,
    n: u64,
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<u64>().ok();
        let parts = text.split_once('/').and_then(|(i, n)| Some((number(i)?, number(n)?)));
        let part = parts.filter(|(i, n)| i < n).map(|(i, n)| Self { i, n });
        part.ok_or_else(|| format!("{text:?} is no part: write i/n with i from 0 to n − 1, as 0/8"))
    }
}

/// A count, as 1e9 or 1000000000.
fn whole(text: &str) -> Result<u64, String> {
    let short = || text.parse::<f64>().ok().filter(|number| number.fract() == 0.0 && *number > 0.0);
    // A number that is too large becomes the largest.
    let count = text.parse().ok().or_else(|| short().map(|number| number as u64));
    let count = count.filter(|count| *count > 0 && checked(0, *count).is_ok());
    count.ok_or_else(|| format!("{text:?} is no count from 1 to 1e15: write 1000000 or 1e6"))
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| format!("{text:?} is no share between 0 and 1"))
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Unwritten(..) => Self::Unwritten(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

/// What words name: the whole catalogue where there is none.
fn subjects(words: &[String]) -> Result<Vec<Subject>, Failure> {
    if words.is_empty() {
        return Ok(Subject::catalogue());
    }
    let mut found = Vec::new();
    for word in words {
        if let Some((_, element)) = in_scene(word) {
            found.push(subject(named(word)?.definition, element));
        } else if let Some((model, _)) = model_of_scene(word, None)? {
            let all = model.connectors.iter();
            found.extend(all.map(|element| subject(element.definition(), &element.label.to_string())));
        } else {
            found.push(Subject::of_type(&type_of(word)?));
        }
    }
    Ok(found)
}

/// A connector of a scene, by the same name however its scene is spelled.
fn subject(definition: Definition, label: &str) -> Subject {
    Subject::of(format!("{} {label}", definition.connection.name), definition)
}

/// The plan of a sweep over what words name, as text: of pintle's own numbers, or of those of a routine.
///
/// # Errors
/// In words, where there is nothing of that name, or no such routine can be started.
pub fn plan(
    words: &[String],
    generator: Generator,
    seed: &str,
    share: f64,
    routine: Option<&Own>,
) -> Result<String, String> {
    planned(words, (generator, seed), share, routine).map_err(|failure| failure.to_string())
}

fn planned(
    words: &[String],
    (generator, seed): (Generator, &str),
    share: f64,
    routine: Option<&Own>,
) -> Result<String, Failure> {
    if let Some(own) = routine {
        own.command(None)?;
    }
    let routine = routine.map(Own::text).transpose()?;
    Ok(Plan::new(generator, seed, share, subjects(words)?, routine)?.text()?)
}

/// Sweeps, or prints what was swept.
pub(crate) fn run(arguments: &SweepOf, files: Files) -> Result<(), Failure> {
    files.check(&arguments.picture)?;
    if let Some(folder) = &arguments.merge {
        let (folder, text) = Folder::known(folder)?;
        let summary = folder.merged(Sweep::new(&text)?.empty())?;
        let wanted = summary.states.count();
        return tell(arguments, files, &summary, wanted);
    }
    let routine = routine(arguments)?;
    let drawn = (Generator::from(arguments.generator), arguments.seed.as_str());
    let text = planned(&arguments.of, drawn, arguments.oracle_share, routine.as_ref())?;
    let sweep = Sweep::new(&text)?.planting(arguments.plant);
    if let Some(index) = arguments.state {
        return state(&sweep, index);
    }
    let folder = arguments.out.as_deref().map(|path| Folder::open(path, &text)).transpose()?;
    let mut summary = sweep.empty();
    let mut left = part(arguments);
    if let Some(folder) = &folder {
        left = left.without(&folder.done()?);
    }
    if routine.is_some() {
        arguments.of.iter().filter_map(|of| drawn_aligned(of)).for_each(|note| complain("note", &note));
    }
    let routines = routines(&sweep, None, Duration::from_secs_f64(arguments.timeout))?;
    let bar = Bar::new();
    bar.expect(usize::try_from(left.count()).unwrap_or(usize::MAX));
    let progress = |more: u64| bar.advance(more as usize, "states");
    for (first, count) in left.chunks(arguments.chunk) {
        let chunk = match &routines {
            Some(routines) => routines.run(first, count, &progress)?,
            None => sweep.run(first, count, &progress)?,
        };
        match &folder {
            Some(folder) => folder.keep(&chunk)?,
            None => summary.merge(&chunk)?,
        }
    }
    bar.finish();
    if let Some(folder) = &folder {
        summary = folder.merged(sweep.empty())?;
    }
    tell(arguments, files, &summary, arguments.states)
}

/// The routine that is swept.
fn routine(arguments: &SweepOf) -> Result<Option<Own>, Failure> {
    let SweepOf { python, library, with, .. } = arguments;
    let start = match (python, library, with) {
        (Some(function), _, _) => Start::Python(function.clone()),
        (_, Some(file), _) => Start::Library(file.clone()),
        (_, _, Some(command)) => Start::With(command.clone()),
        (None, None, None) => return Ok(None),
    };
    let convention = arguments.convention.as_deref().map(super::check::convention).transpose()?;
    Ok(Some(Own { start, convention }))
}

/// The states of a part: whole chunks.
fn part(SweepOf { states, range: Part { i, n }, chunk, .. }: &SweepOf) -> Ranges {
    let chunks = u128::from(states.div_ceil(*chunk));
    let end = |i: u64| {
        let of_chunk = chunks * u128::from(i) / u128::from(*n);
        u64::try_from(of_chunk * u128::from(*chunk)).unwrap_or(u64::MAX).min(*states)
    };
    Ranges::of(end(*i), end(i + 1) - end(*i))
}

/// One state, with all bits, as a file that `pintle replay` reads.
fn state(sweep: &Sweep, index: u64) -> Result<(), Failure> {
    let Some(case) = sweep.case(index) else {
        return Err(Failure::Nothing("the plan has no connector".into()));
    };
    let example = CounterExample::record(&case, Against::Oracle(Oracle::WideDifferences));
    let mut out = BufWriter::new(io::stdout().lock());
    serde_json::to_writer_pretty(&mut out, &example).map_err(io::Error::from)?;
    writeln!(out)?;
    Ok(out.flush()?)
}

fn tell(arguments: &SweepOf, files: Files, summary: &Summary, wanted: u64) -> Result<(), Failure> {
    let digest = summary.digest()?;
    let mut out = BufWriter::new(anstream::stdout().lock());
    match arguments.format {
        Format::Human => report::human(&mut out, summary, &digest, wanted, page_width(&io::stdout()))?,
        Format::Json => report::json(&mut out, summary, &digest)?,
    }
    out.flush()?;
    if let Some(file) = &arguments.picture {
        files.text(file, report::picture(summary))?;
    }
    if summary.wrong() > 0 {
        return Err(Failure::Mismatch);
    }
    let passed = |of: &OfSubject| of.outside + of.elsewhere + of.undefined;
    let swept: u64 = summary.subjects.iter().map(OfSubject::states).sum();
    if swept > 0 && summary.subjects.iter().map(passed).sum::<u64>() == swept {
        return Err(Failure::Nothing("no number of the routine was compared at any state".into()));
    }
    Ok(())
}
