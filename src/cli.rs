//! The command line's definition.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// A verification workbench for connector (joint) elements: exact values, Jacobians, Hessians and rates.
#[derive(Debug, Parser)]
#[command(name = "pintle", version, arg_required_else_help = true, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 all right · 2 usage · 4 nothing was evaluated · 6 bad input · 70 internal error"
)]
pub(crate) struct Cli {
    /// What to do.
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
    Eval(Eval),
}

/// How text reports are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum TextFormat {
    /// Tables for reading
    #[default]
    Human,
    /// One JSON document
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct List {
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: TextFormat,
}

#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// A connection type such as REVOLUTE, in any case, or a code such as deck::unknown-node
    #[arg(value_name = "TYPE|CODE")]
    pub(crate) name: String,
    /// A second type, for a pair of a basic translational and a basic rotational type
    #[arg(value_name = "TYPE")]
    pub(crate) second: Option<String>,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: TextFormat,
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
pub(crate) struct Eval {
    /// A deck (.inp) or `gallery:NAME`; without it, every scene of the gallery with its own states
    #[arg(value_name = "SCENE")]
    pub(crate) scene: Option<String>,
    /// States of the nodes, CSV or JSON; without it, the initial state
    #[arg(long, value_name = "FILE")]
    pub(crate) states: Option<PathBuf>,
}
