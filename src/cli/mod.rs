//! The command line: its definition, and what each command does.

pub(crate) mod eval;
mod failure;
mod show;

pub(crate) use failure::Failure;

use clap::{Args, Parser, Subcommand, ValueEnum};
use pintle::catalog::{ConnectionType, NameError};
use pintle::report::{explain, list};
use pintle::scene::Code;
use show::Show;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::PathBuf;

/// A verification workbench for connector (joint) elements: exact values, Jacobians, Hessians and rates.
#[derive(Debug, Parser)]
#[command(name = "pintle", version, arg_required_else_help = true, max_term_width = 100)]
#[command(after_help = "\
Exit codes: 0 all right, 2 usage, 4 nothing was evaluated, 6 bad input, 70 internal error.
Results go to stdout, everything else to stderr. NO_COLOR is respected.")]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the connection types
    List(List),
    /// Explain a connection type, or the code of a diagnostic
    Explain(Explain),
    /// Evaluate the connectors of a scene: positions, displacements, rates, residuals, derivatives
    Eval(Box<Eval>),
    /// Panic, to test the report of an internal error
    #[cfg(debug_assertions)]
    #[command(hide = true)]
    Panic,
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

#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// A connection type such as REVOLUTE, in any case, or the code of a diagnostic such as deck::unknown-node
    #[arg(value_name = "TYPE|CODE")]
    name: String,
    /// A second type: a basic translational and a basic rotational type make a pair
    #[arg(value_name = "TYPE")]
    second: Option<String>,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: PageFormat,
}

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
}

#[derive(Debug, Args)]
#[command(after_long_help = EVAL_HELP)]
pub(crate) struct Eval {
    /// A deck (.inp) or gallery:NAME; without it, all of the gallery with its own states
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// States of the nodes (.csv or .json), evaluated in order; without it, the initial state
    #[arg(long, value_name = "FILE", requires = "scene")]
    states: Option<PathBuf>,
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
    /// Say more: what was read and not evaluated, what was computed
    #[arg(short, long)]
    verbose: bool,
}

const EVAL_HELP: &str = "\
Outputs:
  CP, CU, CCU    position; displacement from the initial position; from the
                 constitutive reference
  CV, CA         velocity, acceleration
  RES, RESV      residual of each constrained component, and its rate J q̇
  RESB, RESA     J̇ q̇, and the acceleration J q̈ + J̇ q̇ of the residual
  CSLST          stop status, 1 at a limit
  TURNS, MARGIN  whole turns counted; distance to the nearest singular point
  CU names all components, CUR the rotations, CU1 to CU3 and CUR1 to CUR3 one
  of them; likewise CP, CCU, CV, CA. The others take 1 to 6: RES4 is that of
  ur1. Derivatives are taken of every component named.
  Without --outputs: CP, CU, RES; CV and CA if a state has rates; CSLST if a
  connector has stops; in every format. What is not asked for is not computed.

Tables: a number that needs an exponent and is below 1e-10 of the largest in
  its table is shown with 4 digits: it is rounding, or nearly so.

CSV: one line for each state × connector × component, one column for each
  output. With --order 1 or 2 there are the columns dof_1, node_1, dof_2,
  node_2, derivative, and one line more for each derivative that is not 0:
  ∂/∂dof_1 (dof_2 empty), or ∂²/∂dof_1∂dof_2.

JSON: {\"schema\": \"pintle-eval/1\", …, \"scenes\": [{\"scene\", \"states\":
  [{\"index\", \"time\", \"connectors\": [{\"element\", \"type\", \"nodes\",
  \"components\", \"jacobian\", \"hessian\", \"flags\"}], \"mpcs\"}]}]}. Numbers read
  back to the same doubles; one that is not finite is null, with the flag
  not-finite.

Examples:
  pintle eval
  pintle eval gallery:slider_crank --outputs CU1 --show 12
  pintle eval model.inp --states run.csv --order 1 --connector 101,SLIDE";

/// The width of a page: that of the terminal, or 100.
fn page_width(stream: &impl IsTerminal) -> usize {
    const DEFAULT: usize = 100;
    if !stream.is_terminal() {
        return DEFAULT;
    }
    terminal_size::terminal_size().map_or(DEFAULT, |(width, _)| usize::from(width.0).max(40))
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

/// `pintle explain`.
pub(crate) fn explain(arguments: &Explain) -> Result<(), Failure> {
    let mut out = BufWriter::new(anstream::stdout().lock());
    let width = page_width(&io::stdout());
    if let Some(code) = Code::ALL.iter().find(|code| code.as_str().eq_ignore_ascii_case(&arguments.name)) {
        match arguments.format {
            PageFormat::Human => explain::code(&mut out, *code, width)?,
            PageFormat::Json => explain::code_json(&mut out, *code)?,
        }
        return Ok(out.flush()?);
    }
    let connection =
        ConnectionType::named(&arguments.name, arguments.second.as_deref()).map_err(|error| {
            let remedy = match &error {
                NameError::Unknown { nearest: None, .. } => "; `pintle list` shows the types there are",
                NameError::Unknown { .. } | NameError::Pair { .. } => "",
            };
            Failure::Usage(format!("{error}{remedy}"))
        })?;
    let explanation = explain::Explanation::of(&connection);
    match arguments.format {
        PageFormat::Human => explanation.human(&mut out, width)?,
        PageFormat::Json => explanation.json(&mut out)?,
    }
    Ok(out.flush()?)
}
