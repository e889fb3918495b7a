//! `pintle check`.

mod fit;

use super::audit::{AuditFormat, verdict, write};
use super::eval::{read, source};
use super::subject::{At, drawn_aligned, found, named, of_scene};
use super::sweep::Programs;
use super::tell::complain;
use super::{Failure, page_width};
use clap::{ArgGroup, Args};
use pintle_audit::{Check as Checking, Domain, Quantity, Report};
use pintle_check::{Asked, Checked, Convention, Misbehaviour, Patience, Process};
use pintle_report::audit::likeness;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

const HELP: &str = "\
The routine runs in a process of its own and answers one state after the other.
It gives, of each component, the residual of what the connection constrains and
the displacement of what it leaves free (CU), and rows: derivatives by the 14
degrees of freedom of the nodes. pintle explain TYPE has the formulas, and
docs/reference/protocol.md the messages. Every number is judged against 237-bit
numbers, within what the conditioning of the state allows; rows besides against
differences of the routine's own values.

--python MODULE:FUNCTION needs no protocol. The function gets a state and the
connector as dictionaries (arrays where NumPy is installed) and gives values and
rows: two lists of six, None where the connector has no such component.

  def evaluate(state, connector):
      d = state[\"b\"][\"x\"] - state[\"a\"][\"x\"]
      ...
      return values, rows

Angles go on through half a turn: state[\"previous\"] has the values before. A
module with MEMORY = True gives \"memory\" beside its numbers, and gets it back
there. CONVENTION = {\"turns\": \"principal\"} says that angles do not go on.
OFFERS names what else it gives: rates, accelerations, second_derivatives,
nodal_forces, geometric_stiffness. The third argument is what is wanted now.

--library FILE loads a shared library in a process of its own: a routine of
pintle_element.h (--header prints it), or an Abaqus user element of two nodes,
which is judged as springs along the components (--springs).

--fit-convention tells in which units, signs, orders, axes and variations of
rotations its rows are right, as the TOML that declares it, and then checks the
routine under it. Where its states leave several open, it tells all of them.

A routine in any other language prints hello, opened and answers as JSON lines.
A state that it does not cover is answered by {\"out_of_domain\": \"why\"}.

The connector of a TYPE has initial axes that meet its constraints. Misaligned
axes are another branch of the formulas: give a scene that has them.

--at FILE asks at your own states alone, a history or, with --independent, each after
the initial one: nodes 1 (a) and 2 (b) of a TYPE, those of the scene otherwise.

Examples:
  pintle check AXIAL --python my_elements:axial
  pintle check model.inp:106 --at run.csv --python my_elements:translator
  pintle check model.inp --python my_elements:every_type
  pintle check CARTESIAN --within x1=-0.1:0.1,r3=0:1 --python my_elements:cartesian
  pintle check model.inp:106 --with './my_element --json'
  pintle check REVOLUTE --python my_elements:hinge --fit-convention
  pintle check REVOLUTE --at states.csv --answers rows.json --fit-convention
  pintle check AXIAL --library ./uel.so --springs 250 --properties 250
  pintle check \"CARTESIAN CARDAN\" --with 'python3 bushing.py' --format junit

Exit codes: 0 right, 1 a number is wrong, 3 undecided, 4 the routine covers no
state, 6 the process misbehaved.";

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
#[command(group(ArgGroup::new("door").required(true).args(["with", "python", "library", "header", "answers"])))]
pub(crate) struct Check {
    /// A connection type, or two basic ones in quotes. A connector of a scene is SCENE:ELEMENT, all of them are SCENE. A constraint is
    /// "MPC KIND", or "MPC SCENE:S-M…" by its nodes. The friction of a type or connector is "FRICTION TYPE"
    #[arg(value_name = "TYPE|SCENE[:ELEMENT]|MPC …|FRICTION …", required_unless_present = "header")]
    of: Option<String>,
    /// The command that starts the routine, for a shell
    #[arg(long, value_name = "COMMAND")]
    with: Option<String>,
    /// A Python function, from the current folder or the path of Python
    #[arg(long, value_name = "MODULE:FUNCTION")]
    python: Option<String>,
    /// A shared library with a routine of pintle_element.h, or an Abaqus user element (UEL) of two nodes
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// Print pintle_element.h
    #[arg(long)]
    header: bool,
    /// PROPS of a user element
    #[arg(long, value_name = "P1,P2,…", requires = "library", value_delimiter = ',', allow_hyphen_values = true, value_parser = super::finite)]
    properties: Vec<f64>,
    /// NSVARS of a user element
    #[arg(long, value_name = "COUNT", requires = "library", default_value_t = 0)]
    svars: usize,
    /// States about the initial one
    #[arg(long, value_name = "COUNT", default_value_t = 200)]
    states: usize,
    /// States near the singular sets of the connector, besides
    #[arg(long, value_name = "COUNT", default_value_t = 50)]
    near_singular_states: usize,
    /// How many of all are judged by differences on 237 bits
    #[arg(long, value_name = "COUNT", default_value_t = 30)]
    wide_states: usize,
    /// How many of the states about the initial one end a history, through half a turn and whole ones
    #[arg(long, value_name = "COUNT", default_value_t = 40)]
    histories: usize,
    /// A TOML file with what differs from pintle's conventions, in place of what the routine says
    #[arg(long, value_name = "FILE")]
    convention: Option<PathBuf>,
    /// Find the conventions from the numbers: units, signs, order, axes, variation of rotations
    #[arg(long, conflicts_with_all = ["convention", "springs"])]
    fit_convention: bool,
    /// Rows that a harness of one's own computed at the states of --at: JSON, an answer for each state
    #[arg(long, value_name = "FILE", requires = "at", requires = "fit_convention")]
    answers: Option<PathBuf>,
    /// Your own states in place of drawn ones: CSV, JSON, or the result of another program
    #[arg(long, value_name = "FILE", conflicts_with_all = ["states", "near_singular_states", "histories"])]
    at: Option<PathBuf>,
    /// The states of --at are no history: each follows the initial state
    #[arg(long, requires = "at")]
    independent: bool,
    /// Where states are drawn: x1, x2, x3 of b along the axes of a; r1, r2, r3 of its rotation since the initial state (rad), a held
    #[arg(long, value_name = "x1=LOW:HIGH,…", conflicts_with = "at", allow_hyphen_values = true)]
    within: Option<Domain>,
    /// The stiffness of each component of an element of springs that gives element_forces: six numbers, - for none
    #[arg(long, value_name = "D1,…,D6", allow_hyphen_values = true, value_parser = springs)]
    springs: Option<Springs>,
    /// What random states are drawn from
    #[arg(long, value_name = "WORD", default_value = "pintle")]
    seed: String,
    /// Seconds that one answer may take
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = positive)]
    timeout: f64,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: AuditFormat,
    /// Show every check
    #[arg(short, long)]
    verbose: bool,
}

/// A number of seconds.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = super::finite(text)?;
    if number > 0.0 && number < 1e6 { Ok(number) } else { Err(format!("{text} is no time")) }
}

/// Of each component, none for what bears nothing.
type Springs = [Option<f64>; 6];

fn springs(text: &str) -> Result<Springs, String> {
    let mut found = [None; 6];
    let given: Vec<&str> = text.split(',').map(str::trim).collect();
    if given.len() > found.len() {
        return Err(format!("{} numbers, and there are six components", given.len()));
    }
    for (stiffness, given) in found.iter_mut().zip(given) {
        if !matches!(given, "" | "-") {
            *stiffness = Some(super::finite(given)?);
        }
    }
    Ok(found)
}

/// The conventions that a file declares.
pub(super) fn convention(file: &Path) -> Result<Convention, Failure> {
    let named = |why: String| Failure::Input(format!("{}: {why}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|error| named(error.to_string()))?;
    Convention::from_toml(&text).map_err(named)
}

/// The command that starts a routine: a Python function, a shared library, or what is given for a shell. What asks it are these programs, or
/// the Python of the path and this one.
pub(super) fn command(
    (python, library, with): (Option<&str>, Option<&Path>, Option<&str>),
    (properties, svars): (&[f64], usize),
    convention: Option<&Convention>,
    programs: Option<&Programs>,
) -> Result<String, Failure> {
    match (python, library) {
        (Some(routine), _) => {
            let program = programs.map_or("python3", |programs| programs.python.as_str());
            pintle_check::python_command(program, routine).map_err(Failure::Usage)
        }
        (None, Some(library)) => library_command(library, (properties, svars), convention, programs),
        (None, None) => Ok(with.unwrap_or_default().to_string()),
    }
}

/// The command that asks a shared library: this program, in a process of its own.
fn library_command(
    library: &Path,
    (properties, svars): (&[f64], usize),
    convention: Option<&Convention>,
    programs: Option<&Programs>,
) -> Result<String, Failure> {
    let quoted = |path: &Path| format!("'{}'", path.display().to_string().replace('\'', r"'\''"));
    // The Python package says how it is started: its program is Python.
    let program = match (programs, std::env::var("PINTLE_COMMAND")) {
        (Some(programs), _) => programs.pintle.clone(),
        (None, Ok(command)) => command,
        (None, Err(_)) => {
            quoted(&std::env::current_exe().map_err(|error| Failure::Usage(error.to_string()))?)
        }
    };
    let mut command = format!("exec {program} element {} --svars {}", quoted(library), svars);
    if !properties.is_empty() {
        let properties: Vec<String> = properties.iter().map(f64::to_string).collect();
        command.push_str(&format!(" --properties={}", properties.join(",")));
    }
    if let Some(convention) = convention {
        command.push_str(&format!(" --columns {}", convention.columns.join(",")));
    }
    Ok(command)
}

/// Checks a routine and writes the report.
pub(crate) fn run(arguments: &Check) -> Result<(), Failure> {
    if arguments.header {
        return Ok(io::stdout().lock().write_all(pintle_element::HEADER.as_bytes())?);
    }
    let of = arguments.of.as_deref().unwrap_or_default();
    if let (Some(answers), Some(at)) = (&arguments.answers, &arguments.at) {
        let subject = named(of)?;
        let scene = match of.rsplit_once(':').filter(|_| subject.is_of_scene) {
            Some((scene, _)) => Some(read(source(scene)?, None)?.0),
            None => None,
        };
        let (found, gaps) = fit::of_files(&subject, scene.as_ref(), at, answers)?;
        fit::tell(&found, fit::Of::Connector(&subject.definition, subject.nodes, None), &gaps)?;
        return if found.wrong.is_empty() { Ok(()) } else { Err(Failure::Mismatch) };
    }
    let at = arguments.at.as_deref().map(|file| At { file, independent: arguments.independent });
    let Some(connectors) = of_scene(of, at)? else {
        let subject = found(of, at)?;
        let checked = one(arguments, &subject, (of, None))?.map_err(misbehaved(arguments))?;
        tell(arguments, &subject.name(), None, &checked)?;
        return concluded(arguments, checked.report);
    };
    if arguments.fit_convention {
        return Err(Failure::Usage(format!(
            "--fit-convention is of one connector: {}",
            connectors.names().join(", ")
        )));
    }
    let (mut whole, mut refused): (Option<Report>, Vec<String>) = (None, Vec::new());
    let (mut alike, mut wrong, mut judged) = (Alike::default(), 0, 0);
    for (of, subject) in connectors.subjects() {
        match one(arguments, &subject, (&of, Some(&of)))? {
            Ok(checked) => {
                let key = likeness(&checked.report, &subject.name(), &checked.notes());
                if alike.is_new(key, &of) || !matches!(arguments.format, AuditFormat::Human) {
                    tell(arguments, &subject.name(), Some(&of), &checked)?;
                }
                judged += 1;
                wrong += usize::from(checked.report.mismatches() > 0);
                whole = Some(match whole {
                    Some(whole) => whole.joined(checked.report),
                    None => checked.report,
                });
            }
            Err(Misbehaviour::Refused(why)) => refused.push(format!("{of}: {why}")),
            Err(other) => {
                let failure = misbehaved(arguments)(other);
                return Err(match failure {
                    Failure::Input(why) => Failure::Input(format!("{of}: {why}")),
                    other => other,
                });
            }
        }
    }
    let Some(whole) = whole else {
        return Err(Failure::Input(format!(
            "the routine covers no connector of the scene:\n  {}",
            refused.join("\n  ")
        )));
    };
    refused.iter().for_each(|why| complain("note", &format!("not covered, and not judged: {why}")));
    if matches!(arguments.format, AuditFormat::Human) && judged > 1 {
        let mut out = BufWriter::new(anstream::stdout().lock());
        let lines = alike.lines().chain([format!("{wrong} of {judged} connectors wrong")]);
        for line in lines {
            writeln!(out, "{line}")?;
        }
        out.flush()?;
    }
    concluded(arguments, whole)
}

/// Connectors of which the same is to be said: it is said of the first, and the others are named.
#[derive(Default)]
struct Alike(Vec<(String, Vec<String>)>);

impl Alike {
    /// Whether nothing like it was said before.
    fn is_new(&mut self, key: String, of: &str) -> bool {
        if let Some((_, names)) = self.0.iter_mut().find(|(known, _)| *known == key) {
            names.push(of.to_owned());
            return false;
        }
        self.0.push((key, vec![of.to_owned()]));
        true
    }

    /// Who is like the first.
    fn lines(&self) -> impl Iterator<Item = String> {
        const NAMED: usize = 3;
        let several = self.0.iter().filter_map(|(_, names)| names.split_first());
        let several = several.filter(|(_, others)| !others.is_empty());
        several.map(|(first, others)| {
            let named = others.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
            let more = others.len().saturating_sub(NAMED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!("{first}: the same of {named}{more}")
        })
    }
}

/// A misbehaviour in words.
fn misbehaved(arguments: &Check) -> impl Fn(Misbehaviour) -> Failure {
    let may_fit = !arguments.fit_convention;
    move |misbehaviour| {
        let hint = if matches!(misbehaviour, Misbehaviour::WrongShape { .. }) && may_fit {
            "\n  help: --fit-convention finds in which order and shape a routine gives its rows"
        } else {
            ""
        };
        Failure::Input(format!("{misbehaviour}{hint}"))
    }
}

/// The check of a routine as one subject, by the name that is asked for, `among` several.
fn one(
    arguments: &Check,
    subject: &pintle_check::Subject,
    (of, among): (&str, Option<&str>),
) -> Result<Result<Checked, Misbehaviour>, Failure> {
    if arguments.within.is_some() && !matches!(subject, pintle_check::Subject::Connector(..)) {
        let what =
            format!("--within limits places and turns of a connector, and {} has none", subject.name());
        return Err(Failure::Usage(what));
    }
    let mut convention = arguments.convention.as_deref().map(convention).transpose()?;
    let door = (arguments.python.as_deref(), arguments.library.as_deref(), arguments.with.as_deref());
    let command = command(door, (&arguments.properties, arguments.svars), convention.as_ref(), None)?;
    let patience = Patience { answer: Duration::from_secs_f64(arguments.timeout), ..Patience::default() };
    if arguments.fit_convention {
        let about = match subject {
            pintle_check::Subject::Constraint(constraint, _) => fit::Of::Constraint(constraint),
            pintle_check::Subject::Connector(definition, _) => {
                fit::Of::Connector(definition, named(of)?.nodes, arguments.within.as_ref())
            }
            pintle_check::Subject::Friction(_) => {
                let what = "--fit-convention finds the conventions of a connector or constraint";
                return Err(Failure::Usage(what.into()));
            }
        };
        let found = Process::start(&command, patience)
            .and_then(|process| {
                pintle_check::fit_convention(process, subject, &arguments.seed, arguments.within.as_ref())
            })
            .map_err(misbehaved(arguments))?;
        fit::tell(&found, about, &[])?;
        println!();
        convention = Some(found.convention);
    }
    let settings = pintle_audit::Settings {
        states: arguments.states,
        near_singular_states: arguments.near_singular_states,
        wide_states: arguments.wide_states,
        seed: arguments.seed.clone(),
        atlas: false,
        ..pintle_audit::Settings::default()
    };
    let springs = arguments.springs.unwrap_or_default();
    let domain = arguments.within.clone();
    let among = among.map(str::to_string);
    let histories = arguments.histories;
    let asked = Asked { settings, histories, convention, springs, domain, simplest: false, among };
    Ok(Process::start(&command, patience).and_then(|process| pintle_check::check(process, subject, asked)))
}

/// A short report for people, and what was not judged.
fn tell(arguments: &Check, name: &str, among: Option<&str>, checked: &Checked) -> Result<(), Failure> {
    let mut notes = checked.notes();
    let is_unnamed = |check: &Checking| {
        let of = matches!(check.quantity, Some(Quantity::Value | Quantity::FirstDerivatives));
        of && check.diagnosis.as_ref().is_some_and(|found| found.causes.is_empty())
    };
    let mut checks = checked.report.subjects.iter().flat_map(|subject| &subject.checks);
    if !arguments.fit_convention && !name.starts_with("FRICTION") && checks.any(is_unnamed) {
        notes.push("no cause is named: --fit-convention tries other units, orders, frames and variations of rotations".into());
    }
    let of = arguments.of.as_deref().unwrap_or_default();
    notes.extend(drawn_aligned(of).filter(|_| among.is_none()));
    if let Some(among) = among {
        notes.iter_mut().for_each(|note| *note = format!("{among}: {note}"));
    }
    if !matches!(arguments.format, AuditFormat::Human) {
        notes.iter().for_each(|note| complain("note", note));
        return Ok(());
    }
    let mut out = BufWriter::new(anstream::stdout().lock());
    pintle_report::audit::checked(&mut out, &checked.report, name, &notes, page_width(&io::stdout()))?;
    Ok(out.flush()?)
}

/// The whole report, where that is asked for, and the verdict.
fn concluded(arguments: &Check, report: Report) -> Result<(), Failure> {
    if arguments.verbose || !matches!(arguments.format, AuditFormat::Human) {
        write(arguments.format, arguments.verbose, &report)?;
    }
    verdict(&report)?;
    if report.is_open() { Err(Failure::Undecided) } else { Ok(()) }
}

/// A shared library that is asked by the protocol.
#[derive(Debug, Args)]
pub(crate) struct Element {
    library: PathBuf,
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = super::finite)]
    properties: Vec<f64>,
    #[arg(long, default_value_t = 0)]
    svars: usize,
    #[arg(long, value_delimiter = ',')]
    columns: Vec<String>,
}

/// Answers from a shared library until it is closed.
pub(crate) fn serve(element: &Element) -> Result<(), Failure> {
    let Element { library, properties, svars, columns } = element;
    let options = pintle_element::Options {
        library: library.clone(),
        properties: properties.clone(),
        svars: *svars,
        columns: columns.clone(),
    };
    pintle_element::serve(&options, io::stdin().lock(), io::stdout()).map_err(Failure::Input)
}
