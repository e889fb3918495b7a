//! `pintle export`.

use super::{Failure, Files, connection};
use clap::{Args, ValueEnum};
use pintle_report::export::{Export as Program, Target};
use pintle_symbolic::Frame;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

/// The languages of programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Language {
    /// Python functions of SymPy expressions
    Sympy,
    /// Python functions of JAX arrays
    Jax,
    /// C99 functions
    C,
    /// Rust functions that need the standard library only
    Rust,
    /// Formulas in a LaTeX document
    Latex,
    /// The expression graph of the values, for Graphviz
    Dot,
}

/// What derivatives are taken by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Variables {
    /// d and Q: position and orientation of b relative to a, in the directions of a
    #[default]
    Relative,
    /// Displacements, directions and flows of both nodes
    Nodal,
}

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
pub(crate) struct Export {
    /// A connection type such as REVOLUTE, in any case
    #[arg(value_name = "TYPE")]
    name: String,
    /// A second type: a basic translational and a basic rotational type make a pair
    #[arg(value_name = "TYPE")]
    second: Option<String>,
    /// The language
    #[arg(long = "as", value_enum, value_name = "LANGUAGE")]
    language: Language,
    /// What the functions take, and what derivatives are taken by
    #[arg(long, value_enum, default_value_t)]
    variables: Variables,
    /// Where to write it; without it, to standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

const HELP: &str = "\
The program is traced from the formulas that `pintle eval` computes, and differentiated as an expression graph. It has
the functions values, jacobian and hessian of the type, and friction_1, friction_2 … where it has predefined friction;
its header states conventions, inputs with shapes and units, and outputs.

Examples:
  pintle export REVOLUTE --as c -o revolute.c
  pintle export TRANSLATOR --as sympy --variables nodal -o translator.py
  pintle export HINGE --as dot | dot -Tsvg > hinge.svg";

/// `pintle export`.
pub(crate) fn run(arguments: &Export, files: Files) -> Result<(), Failure> {
    files.check(&arguments.output)?;
    let connection = connection(&arguments.name, arguments.second.as_deref())?;
    let frame = match arguments.variables {
        Variables::Relative => Frame::Relative,
        Variables::Nodal => Frame::Nodal,
    };
    let program = Program::of(&connection, frame).map_err(|error| Failure::Input(error.to_string()))?;
    let text = match arguments.language {
        Language::Sympy => program.write(Target::Sympy),
        Language::Jax => program.write(Target::Jax),
        Language::C => program.write(Target::C),
        Language::Rust => program.write(Target::Rust),
        Language::Latex => program.write(Target::Latex),
        Language::Dot => program.graphviz(),
    };
    match &arguments.output {
        Some(path) => files.text(path, &text),
        None => {
            let mut out = BufWriter::new(io::stdout().lock());
            out.write_all(text.as_bytes())?;
            Ok(out.flush()?)
        }
    }
}
