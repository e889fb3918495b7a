//! The command line: its definition, and what each command does.

pub(crate) mod audit;
pub(crate) mod bench;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod eval;
pub(crate) mod export;
pub(crate) mod history;
pub(crate) mod manual;
mod output;
mod reference;
pub(crate) mod replay;
pub(crate) mod solve;
mod start;
pub(crate) mod states;
pub(crate) mod subject;
pub(crate) mod sweep;

use output::Show;
pub(crate) use output::{Failure, Files, tell};
pub use start::command_line;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use pintle_bench::Environment;
use pintle_kinematics::catalog::{ConnectionType, NameError, TABLE};
use pintle_kinematics::mpc;
use pintle_model::behavior::Conditions;
use pintle_report as report;
use pintle_report::{explain, glossary, list};
use pintle_scene::Code;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::PathBuf;

/// A verification workbench for connector (joint) elements: exact values, Jacobians, Hessians and rates.
#[derive(Debug, Parser)]
#[command(name = "pintle", version, long_version = long_version(), arg_required_else_help = true, max_term_width = 100)]
#[command(after_help = "\
Exit codes: 0 all right, 1 a number is wrong, 2 usage, 3 undecided (--strict), 4 nothing was evaluated,
5 the self-test failed, 6 bad input, 7 a file or the results cannot be written, 70 internal error.
Results go to stdout, everything else to stderr. NO_COLOR is respected.")]
pub(crate) struct Cli {
    /// Threads; no result depends on their number [default: one per core, or RAYON_NUM_THREADS]
    #[arg(long, value_name = "COUNT", global = true, display_order = 900, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Let files take the place of others that have their names
    #[arg(long, global = true, display_order = 901)]
    pub(crate) force: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the connection types and multi-point constraints
    List(List),
    /// Explain a connection type, a multi-point constraint (MPC), the code of a diagnostic, or a word of a report
    Explain(Explain),
    /// Evaluate the connectors of a scene: positions, displacements, rates, residuals, derivatives
    Eval(Box<Eval>),
    /// Convert a scene between deck, TOML and JSON, and say what is lost
    Convert(Convert),
    /// Export a connection type as a program: SymPy, JAX, C, Rust, LaTeX, or its expression graph
    Export(export::Export),
    /// Print the JSON Schema of scenes in TOML and JSON, or of the JSON report of an audit
    #[command(after_long_help = SCHEMA_HELP)]
    Schema {
        /// Of what
        #[arg(value_enum, default_value_t)]
        of: Described,
    },
    /// Audit the catalogue, or scenes: are kinematics, forces and slopes right, and would an error have been noticed?
    Audit(Box<audit::Audit>),
    /// Check somebody's element routine, in any language: which entry is wrong, and why?
    Check(Box<check::Check>),
    /// Write states for a harness of your own: about the initial one, near singular sets, along a history
    States(states::States),
    /// Compare what another program has written with what the connectors must give
    Compare(Box<compare::Compare>),
    /// Solve a mechanism of connectors, with friction that sticks: a reference with its digits, its events and its error
    Solve(Box<solve::Solve>),
    /// Sweep over up to 1e15 states, in any partition, on any number of machines: one digest
    Sweep(Box<sweep::SweepOf>),
    /// Ask a shared library by the protocol
    #[command(hide = true)]
    Element(check::Element),
    /// Judge the state of a counter-example again
    Replay(replay::Replay),
    /// Measure what values, Jacobians and Hessians cost on this machine, at which error
    Bench(bench::Bench),
    /// Print the completions of a shell
    #[command(after_long_help = manual::COMPLETIONS_HELP)]
    Completions(manual::Completions),
    /// Print a manual page
    Man(manual::Man),
    /// Panic, to test the report of an internal error
    #[cfg(debug_assertions)]
    #[command(hide = true)]
    Panic,
}

/// What has a JSON Schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Described {
    /// Scenes in TOML and JSON
    #[default]
    Scene,
    /// The JSON report of `pintle audit`
    Audit,
}

/// How pages are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum PageFormat {
    /// Text for reading
    #[default]
    Human,
    /// One JSON document
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct List {
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: PageFormat,
}

/// How an explanation is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExplainFormat {
    /// Text for reading
    #[default]
    Human,
    /// One JSON document
    Json,
    /// The formulas of a connection type, in LaTeX
    Latex,
}

impl ExplainFormat {
    /// The format of a page that has no formulas.
    fn page(self) -> Result<PageFormat, Failure> {
        match self {
            Self::Human => Ok(PageFormat::Human),
            Self::Json => Ok(PageFormat::Json),
            Self::Latex => Err(Failure::Usage("only connection types have formulas in LaTeX".to_string())),
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// A connection type such as REVOLUTE, in any case; MPC or MPC REVOLUTE; the code of a diagnostic such as deck::unknown-node; or a word
    /// of a report such as kink
    #[arg(value_name = "TYPE|MPC|CODE|WORD")]
    name: String,
    /// More words of it; or a second type, for a basic translational and a basic rotational one make a pair
    #[arg(value_name = "TYPE|WORD")]
    rest: Vec<String>,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: ExplainFormat,
}

/// Takes one of several by its name.
fn one_of<T: Copy + Send + Sync + 'static, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let named = move |text: String| all.into_iter().find(|one| name(*one) == text).ok_or("no such name");
    PossibleValuesParser::new(all.map(name)).try_map(named)
}

/// A number that is one.
fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| format!("{text} is not a finite number"))
}

/// The forms of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SceneFormat {
    /// A deck of keywords
    Inp,
    /// TOML
    Toml,
    /// JSON
    Json,
}

#[derive(Debug, Args)]
#[command(after_long_help = CONVERT_HELP)]
pub(crate) struct Convert {
    /// A scene (.inp, .toml, .json) or gallery:NAME
    #[arg(value_name = "SCENE")]
    scene: String,
    /// Where to write it; without it, to standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The form to convert to [default: by the ending of the output file]
    #[arg(long, value_enum, value_name = "FORM")]
    to: Option<SceneFormat>,
    /// Put these states (.csv or .json) into the scene, instead of its own
    #[arg(long, value_name = "FILE")]
    states: Option<PathBuf>,
    /// Write the states of the scene to a file of states (JSON): a deck cannot hold them
    #[arg(long, value_name = "FILE")]
    save_states: Option<PathBuf>,
    /// Write nothing, with exit code 1, if something of the input would be lost
    #[arg(long)]
    strict: bool,
}

const CONVERT_HELP: &str = "\
Numbers are written in the shortest digits that read back to the same double;
`pintle eval` gives the same numbers for the result, to the last bit. What the
result has not is said on stderr, one line for each thing: keywords that are
skipped, with their counts, parameters, comments, elements of other types,
states in a deck.

Examples:
  pintle convert model.inp -o model.toml
  pintle convert model.inp --states run.csv -o model.json
  pintle convert model.toml --to inp
  pintle convert gallery:seat_belt --to toml

`pintle schema` describes the TOML and JSON forms.";

const SCHEMA_HELP: &str = "\
A scene in TOML or JSON is read like a deck, with the same checks, and evaluated
by `pintle eval`. Angles are in radians except constitutive_reference and the
angle of an orientation, in degrees. An empty item of a row is \"\" (in JSON also
null). Names stand as they are: a deck writes them in upper case, unless quoted.

An example in TOML:
  nodes = { 1 = [0, 0, 0], 2 = [0, 0, 0] }
  connectors.101 = { a = 1, b = 2 }
  element_sets.PIN = [101]
  orientations.OZ = { a = [0, 0, 1], b = [1, 0, 0] }

  [[connector_sections]]
  element_set = \"PIN\"
  type = \"HINGE\"
  orientation_a = \"OZ\"
  behavior = \"B\"

  [behaviors.B]
  stops = [{ component = 4, lower = -1.5, upper = 1.5 }]

  [[states]]
  time = 0.5
  nodes.2 = { rotation = [0, 0, 0.3], angular_velocity = [0, 0, 1] }

Editors complete and check scenes with the schema: save it to a file and name it
in a first line `#:schema FILE` of TOML, or in the field \"$schema\" of JSON.";

/// How evaluations are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum EvalFormat {
    /// Tables for reading
    #[default]
    Human,
    /// One JSON document, schema pintle-eval/1
    Json,
    /// One table in long form
    Csv,
    /// Arrays of NumPy by state, connector and component, written as states are evaluated: what
    /// pintle.Scene.evaluate gives
    Npz,
}

/// What a positive force means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Sign {
    /// Every force resists growth of its component, so that CTF = CEF + CVF + CSF + CRF − CCF
    #[default]
    Internal,
    /// Forces of constrained components are those applied at node b to enforce the constraint: minus the internal ones
    ConstraintsOnB,
}

/// What forces depend on besides motions, of a command whose scenes have the id `scene`.
#[derive(Clone, Debug, Args)]
struct ConditionOptions {
    /// The temperature, in every state, of tables that depend on it
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, value_parser = finite, requires = "scene")]
    temperature: Option<f64>,
    /// Field variables in every state, from the first, separated by commas
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', allow_negative_numbers = true, value_parser = finite, requires = "scene")]
    fields: Vec<f64>,
}

impl From<&ConditionOptions> for Conditions {
    fn from(ConditionOptions { temperature, fields }: &ConditionOptions) -> Self {
        Self { temperature: *temperature, fields: fields.clone() }
    }
}

#[derive(Debug, Args)]
#[command(after_long_help = EVAL_HELP)]
pub(crate) struct Eval {
    /// A deck (.inp), TOML or JSON scene (.toml, .json) or gallery:NAME; without it, all of the gallery with its own states
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// States of the nodes (.csv, .json, .npz), evaluated in order; without it, those of the scene, or the initial state
    #[arg(long, value_name = "FILE", requires = "scene")]
    states: Option<PathBuf>,
    /// Each state follows the initial one, not the one before: no turn, friction or damage is carried on
    #[arg(long, requires = "scene", conflicts_with_all = ["resume", "save_branches"])]
    independent: bool,
    /// Component forces of connectors (.csv or .json), as an FE code exports them: gives nodal forces (see below)
    #[arg(long, value_name = "FILE", requires = "scene")]
    forces: Option<PathBuf>,
    /// What a positive force of a constrained component means in the file of forces
    #[arg(long, value_enum, default_value_t, requires = "forces")]
    force_sign: Sign,
    #[command(flatten)]
    conditions: ConditionOptions,
    /// Outputs, separated by commas, such as CU,CPR1,RES (see below); ALL; NONE for derivatives only
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    outputs: Vec<String>,
    /// Derivatives by the nodal degrees of freedom: 0 none, 1 Jacobian, 2 also second derivatives
    /// [default: 1; 0 with --outputs]
    #[arg(long, value_name = "ORDER", value_parser = clap::value_parser!(u8).range(0..=2))]
    order: Option<u8>,
    /// Only these connectors, by element number or element set; MPCs are then left out
    #[arg(long, value_name = "NUMBER|SET", value_delimiter = ',', requires = "scene")]
    connector: Vec<String>,
    /// States to write, such as 0,6,12-14 or first,middle,last; every state is evaluated [default: all;
    /// middle,last for tables of all of the gallery]
    #[arg(long, value_name = "STATES")]
    show: Option<Show>,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: EvalFormat,
    /// Significant digits of tables; JSON and CSV are always exact
    #[arg(long, value_name = "DIGITS", default_value_t = 10, value_parser = clap::value_parser!(u8).range(1..=17))]
    digits: u8,
    /// Save the branches (turn counts and their kin) after the last state
    #[arg(long, value_name = "FILE", requires = "scene")]
    save_branches: Option<PathBuf>,
    /// Continue from saved branches, bit for bit as if the states had followed in one run
    #[arg(long, value_name = "FILE", requires = "scene")]
    resume: Option<PathBuf>,
    /// Write the constraint Jacobian of the last state shown, a sparse matrix (Matrix Market, .mtx; see below)
    #[arg(long, value_name = "FILE", requires = "scene")]
    jacobian: Option<PathBuf>,
    /// Say more: what was read and not evaluated, what was computed
    #[arg(short, long)]
    verbose: bool,
}

const EVAL_HELP: &str = "\
States: a table (.csv) or a document (.json); examples below. They are evaluated
  in order, and called by their numbers in the file, the column state or the
  name number; without, from 0, with --resume on from those before. Lengths in
  the unit of the deck, angles in rad, all components global. What is missing
  or empty is 0: a node that a state leaves out is at rest in its initial place.
  CSV: the first line names the columns, in any order; lines that begin with #
  are comments. Only node is needed.
    state              rows of one number form one state; it must not decrease
    time               the same in all rows of a state
    node               the node number; INSTANCE.NUMBER in an assembly, CRANK-1.5
    u1 u2 u3           displacement from the initial position
    ur1 ur2 ur3        total rotation from the initial orientation, as a
                       rotation vector; turns are kept where it is longer than π
    q0 q1 q2 q3        or the same as a quaternion of norm 1, scalar first;
                       it holds no turns
    v1 v2 v3           velocity, the rate of u
    vr1 vr2 vr3        spatial angular velocity ω, with Ṙ = ω^ R (not the rate
                       of ur)
    a1 a2 a3           acceleration, the rate of v
    ar1 ar2 ar3        spatial angular acceleration, the rate of ω
    flow flow_v flow_a material flow (degree of freedom 10), and its rates
  JSON: the same by node number, under the names displacement, rotation or
  quaternion, velocity, angular_velocity, acceleration, angular_acceleration,
  flow, flow_velocity, flow_acceleration.
  The angles of the hinges of an MPC REVOLUTE or UNIVERSAL, degree of freedom 6
  of its third and fourth node, are ur3 of those nodes, with the rates vr3 and
  ar3. Where a state leaves out the node, or gives it a quaternion, the angle is
  what the rotations imply.

Forces (--forces): a table (.csv) or a document (.json), or \"forces\" beside
  \"nodes\" in a JSON file of states. Names are f1 f2 f3 m1 m2 m3 or, the same,
  CTF1 to CTM3, the total force; CRF1 to CRM3 is accepted for constrained
  components. A force that is left out is not known, and what rests on it has a
  flag; those of components that an element does not have may be 0. Elements and
  states that are not named have no nodal forces. Columns of CSV: element, state (numbered from 0)
  or time, and the forces. JSON: {\"schema\": \"pintle-forces/1\", \"states\":
  [{\"state\": 0, \"forces\": {\"101\": {\"f1\": 2.5, \"m2\": 0}}}]}. Signs are internal:
  positive resists growth of the component; --force-sign constraints-on-b takes
  those of constrained components as applied at node b. The element may be the
  nodes of an MPC, 10-20-30: its forces are then those that it puts on its first
  node, residual-side, global components, and NF, LM, KG, DNF, KT, CT and KR
  tell what it transmits.

Outputs:
  CP, CU, CCU    position; displacement from the initial position; from the
                 constitutive reference
  CV, CA         velocity, acceleration
  RES, RESV      residual of each constrained component, and its rate J q̇
  RESB, RESA     J̇ q̇, and the acceleration J q̈ + J̇ q̇ of the residual
  CSLST          stop and lock status, 1 at a limit
  CEF, CVF, CCF  elastic force, viscous force, applied connector load
  CSF, CNF       friction force, contact force of friction
  CASU, CIVC     accumulated slip, slip rate
  SLIP           whether friction sticks or slips, or is free where nothing
                 presses: stick, slip, free
  CRF, CTF       reaction; total force CEF + CVF + CSF + CRF − CCF, or as given
  CFAILST        failure status, 1 when released
  DRIVEN         what a connector motion prescribes; RES is how far off it is
  TANGENT        slopes of component forces: elastic, viscous, friction with its
                 consistent tangent; by displacement, velocity, reaction (CRF) of
                 what is constrained or held, time step, and at a ring the
                 tension T2 and measured angle of wrap α beyond; ∂α by positions
  PM             moments by which the printed formula gives the same moment,
                 where that is another one
  LM             multipliers of the equations enforced (those of RES)
  NF             nodal forces, residual-side: rows transposed × forces; those of
                 the ground are its reactions; NF4 is the part of m1
  KG, DNF        geometric stiffness Σ f ∂²c; derivative of the nodal forces at
                 constant component forces, rotations spatial
  KT, CT, KR     tangent of the nodal forces: Jᵀ (∂F/∂u) J + KG; by velocities,
                 Jᵀ (∂F/∂v) J; by reactions. ∂NF/∂q is KT − KG + DNF
  TURNS, MARGIN  whole turns counted; distance to the nearest singular point
  CU names all components, CUR the rotations, CU1 to CU3 and CUR1 to CUR3 one
  of them; likewise CP, CCU, CV, CA. CTF names all forces, CTM the moments, CTF1
  to CTF3 and CTM1 to CTM3 one of them; likewise CEF, CVF, CRF, CCF. The others
  take 1 to 6: RES4 is that of ur1. Derivatives are taken of every component
  named.
  Without --outputs: CP, CU, RES; CV and CA if a state has rates; CSLST, CEF, CVF,
  CCF, CFAILST, DRIVEN if a connector has what they tell of; CSF, CNF, CASU if
  motions tell what presses on a friction, or forces are given; CTF, PM, NF if
  forces are given; in every format. What is not asked for is not computed.
  Velocities of dampers are the rates of the states; if no state has rates, they
  are increments over the time between states, as in statics.

Tables: a number that needs an exponent and is below 1e-10 of the largest in
  its table is shown with 4 digits: it is rounding, or nearly so.

CSV: one line for each state × connector × component, one column for each
  output. With --order 1 or 2 there are the columns dof_1, node_1, dof_2,
  node_2, derivative, and one line more for each derivative that is not 0:
  ∂/∂dof_1 (dof_2 empty), or ∂²/∂dof_1∂dof_2.

JSON: {\"schema\": \"pintle-eval/1\", …, \"scenes\": [{\"scene\", \"states\":
  [{\"index\", \"time\", \"connectors\": [{\"element\", \"type\", \"nodes\",
  \"components\", \"jacobian\", \"hessian\", \"flags\"}], \"mpcs\", \"relations\"}]}]}. Numbers
  read back to the same doubles; one that is not finite is null, with the flag
  not-finite. Relations are equations, rigid bodies, couplings and ties.

Jacobian (--jacobian): rows are the constrained components of connectors and the
  equations of constraints, columns the degrees of freedom of their nodes, numbered by
  node; the ground, and what *BOUNDARY prescribes before or in the first step,
  have none. Columns of a node under *TRANSFORM are along its axes. Comments of
  the file name every row and column. scipy.io.mmread reads it, as do MATLAB,
  Octave and Julia.

A file of two states, as CSV and as JSON:
  state,time,node,u1,ur3,vr3
  0,0,2,0,0,15
  1,0.5,2,0.1,7.5,15
  1,0.5,3,0.2,,

  {\"schema\": \"pintle-states/1\", \"states\": [
    {\"number\": 0, \"time\": 0, \"nodes\": {
      \"2\": {\"angular_velocity\": [0, 0, 15]}}},
    {\"number\": 1, \"time\": 0.5, \"nodes\": {
      \"2\": {\"displacement\": [0.1, 0, 0], \"rotation\": [0, 0, 7.5],
            \"angular_velocity\": [0, 0, 15]},
      \"3\": {\"displacement\": [0.2, 0, 0]}}}]}

Examples:
  pintle eval
  pintle eval gallery:slider_crank --outputs CU1 --show 12
  pintle eval model.inp --states run.csv --order 1 --connector 101,SLIDE";

/// What was built, from what, by and for what.
fn long_version() -> String {
    let here = Environment::here();
    let lines = [
        (
            "commit",
            here.commit
                .unwrap_or_else(|| "not known: a build for development, or outside its repository".into()),
        ),
        ("compiler", format!("{} for {}", here.rustc, here.target).into()),
        ("optimised", if here.is_optimised { "yes" } else { "no: for tests" }.into()),
    ];
    let lines: Vec<String> = lines.iter().map(|(name, value)| format!("{name}: {value}")).collect();
    format!("{}\n{}", here.pintle, lines.join("\n"))
}

/// The stack of every thread, in bytes: derivatives of derivatives lie on it, whole, in a build without optimisation.
pub const STACK: usize = 64 << 20;

/// Gives the pool of rayon its stacks, and its number of threads if there is one to give.
pub(crate) fn use_threads(count: Option<u16>) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK).num_threads(count.map_or(0, usize::from));
    pool.build_global().map_err(|error| {
        let asked = count.map_or_else(String::new, |count| format!("{count} "));
        Failure::Usage(format!("{asked}threads cannot be started: {error}"))
    })
}

/// The width of a page: that of the terminal; elsewhere the environment's COLUMNS, or 100.
fn page_width(stream: &impl IsTerminal) -> usize {
    const DEFAULT: usize = 100;
    const LEAST: usize = 40;
    let terminal = stream.is_terminal().then(terminal_size::terminal_size).flatten();
    if let Some((width, _)) = terminal {
        return usize::from(width.0).max(LEAST);
    }
    let columns = std::env::var("COLUMNS").ok().and_then(|columns| columns.trim().parse().ok());
    columns.map_or(DEFAULT, |columns: usize| columns.clamp(LEAST, 1000))
}

/// `pintle list`.
pub(crate) fn list(arguments: &List) -> Result<(), Failure> {
    let mut out = BufWriter::new(anstream::stdout().lock());
    match arguments.format {
        PageFormat::Human => list::human(&mut out, page_width(&io::stdout()))?,
        PageFormat::Json => list::json(&mut out)?,
    }
    Ok(out.flush()?)
}

/// `pintle explain MPC`.
fn explain_mpc(
    out: &mut impl Write,
    kind: Option<mpc::MpcType>,
    format: PageFormat,
    width: usize,
) -> Result<(), Failure> {
    match format {
        PageFormat::Human => report::mpc::human(out, kind, width)?,
        PageFormat::Json => report::mpc::json(out, kind)?,
    }
    Ok(out.flush()?)
}

/// The connection type of a name, or of a pair of names.
fn connection(name: &str, second: Option<&str>) -> Result<ConnectionType, Failure> {
    // One name of two words, without quotes.
    if let Some(one) = second.and_then(|second| ConnectionType::named(&format!("{name} {second}"), None).ok())
    {
        return Ok(one);
    }
    ConnectionType::named(name, second).map_err(|error| {
        let remedy = match &error {
            NameError::Unknown { nearest: None, .. } => "; `pintle list` shows the types there are",
            NameError::Unknown { .. } | NameError::Pair { .. } => "",
        };
        Failure::Usage(format!("{error}{remedy}"))
    })
}

/// What the name of a type or constraint means elsewhere.
fn besides(out: &mut dyn Write, name: &str, width: usize) -> io::Result<()> {
    let found = glossary::exactly(name);
    if found.is_empty() {
        return Ok(());
    }
    writeln!(out)?;
    glossary::human(out, &found, width)
}

/// What is asked of `explain` and begins with no type, with the nearest word that has a meaning.
fn unknown(asked: &str) -> Option<Failure> {
    let lower = asked.to_lowercase();
    let first = lower.split([' ', ',', '+']).next().unwrap_or_default();
    if TABLE.iter().any(|entry| entry.name.eq_ignore_ascii_case(first)) {
        return None;
    }
    let mut words: Vec<String> = TABLE.iter().map(|entry| entry.name.to_string()).collect();
    for meaning in glossary::meanings() {
        words.extend(meaning.word.split(", ").map(|word| word.replace(['`', '…', '*'], "")));
    }
    let away = |word: &String| strsim::damerau_levenshtein(&word.to_lowercase(), &lower);
    let near = words.into_iter().map(|word| (away(&word), word)).min();
    let near = near.filter(|(away, _)| *away <= 1.max(lower.chars().count() / 4));
    let meant = near.map_or_else(
        || "it explains types (pintle list), MPCs, outputs, codes and words of reports".to_owned(),
        |(_, word)| format!("did you mean {word}?"),
    );
    Some(Failure::Usage(format!("pintle explains nothing called {asked:?}; {meant}")))
}

/// `pintle explain`.
pub(crate) fn explain(arguments: &Explain) -> Result<(), Failure> {
    let mut out = BufWriter::new(anstream::stdout().lock());
    let width = page_width(&io::stdout());
    if let Some(code) = Code::ALL.iter().find(|code| code.as_str().eq_ignore_ascii_case(&arguments.name)) {
        match arguments.format.page()? {
            PageFormat::Human => explain::code(&mut out, *code, width)?,
            PageFormat::Json => explain::code_json(&mut out, *code)?,
        }
        return Ok(out.flush()?);
    }
    if arguments.name.contains("::") {
        let near = Code::nearest(&arguments.name);
        let meant = near.map_or_else(String::new, |near| format!("; did you mean {}?", near.as_str()));
        return Err(Failure::Usage(format!("there is no code {:?}{meant}", arguments.name)));
    }
    let rest = Some(arguments.rest.join(" ")).filter(|rest| !rest.is_empty());
    let asked =
        rest.as_ref().map_or_else(|| arguments.name.clone(), |rest| format!("{} {rest}", arguments.name));
    let words = asked.to_ascii_uppercase();
    match words.split_whitespace().collect::<Vec<_>>()[..] {
        ["MPC"] => return explain_mpc(&mut out, None, arguments.format.page()?, width),
        ["MPC", name] => {
            let Some(kind) = mpc::MpcType::named(name) else {
                let names = mpc::TABLE.map(|entry| entry.name).join(", ");
                return Err(Failure::Usage(format!(
                    "the MPCs that are evaluated, and explained, are {names}"
                )));
            };
            return explain_mpc(&mut out, Some(kind), arguments.format.page()?, width);
        }
        ["MPC", ..] => return Err(Failure::Usage("an MPC has one type: MPC REVOLUTE".to_string())),
        // A name that no connection type has.
        [name] if !TABLE.iter().any(|entry| entry.name == name) => {
            if let Some(kind) = mpc::MpcType::named(name) {
                let format = arguments.format.page()?;
                explain_mpc(&mut out, Some(kind), format, width)?;
                if matches!(format, PageFormat::Human) {
                    besides(&mut out, name, width)?;
                }
                return Ok(out.flush()?);
            }
        }
        _ => {}
    }
    let found = glossary::of(asked.trim());
    if !found.is_empty() && !TABLE.iter().any(|entry| entry.name.eq_ignore_ascii_case(&arguments.name)) {
        match arguments.format.page()? {
            PageFormat::Human => glossary::human(&mut out, &found, width)?,
            PageFormat::Json => glossary::json(&mut out, &found)?,
        }
        return Ok(out.flush()?);
    }
    let connection =
        connection(&arguments.name, rest.as_deref()).map_err(|refused| unknown(&asked).unwrap_or(refused))?;
    let explanation = || explain::Explanation::of(&connection);
    match arguments.format {
        ExplainFormat::Human => {
            explanation().human(&mut out, width)?;
            besides(&mut out, &asked, width)?;
        }
        ExplainFormat::Json => explanation().json(&mut out)?,
        ExplainFormat::Latex => report::formulas::latex(&connection, &mut out)?,
    }
    Ok(out.flush()?)
}
