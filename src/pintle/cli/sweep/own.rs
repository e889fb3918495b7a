//! Somebody's routine in a sweep: what the plan says of it, and how a worker starts it.

use crate::cli::tell::complain;
use crate::cli::{Failure, check};
use pintle_audit::{Given, Quantity, Question};
use pintle_check::{Convention, Misbehaviour, Patience, Process, Session};
use pintle_kinematics::connector::Definition;
use pintle_sweep::{Routine, Routines, Sweep, SweepError};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Duration;

/// How many states may end a process before the sweep ends with it.
const ENDS: usize = 20;

/// A routine, as the plan names it. Programs are left out: each worker has its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Own {
    /// What is started.
    pub start: Start,
    /// What replaces the conventions of its greeting.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convention: Option<Convention>,
}

/// What a worker starts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Start {
    /// A Python function, `module:function`.
    Python(String),
    /// A shared library.
    Library(PathBuf),
    /// A command for a shell.
    With(String),
}

/// How a worker starts what asks a routine, as words for a shell.
#[derive(Clone, Debug)]
pub struct Programs {
    /// Python.
    pub python: String,
    /// The command of this package.
    pub pintle: String,
}

impl Own {
    /// The command that starts it, by other programs than those of the command line where they are given.
    pub(super) fn command(&self, programs: Option<&Programs>) -> Result<String, Failure> {
        let door = match &self.start {
            Start::Python(function) => (Some(function.as_str()), None, None),
            Start::Library(file) => (None, Some(file.as_path()), None),
            Start::With(command) => (None, None, Some(command.as_str())),
        };
        check::command(door, (&[], 0), self.convention.as_ref(), programs)
    }

    /// As the plan has it.
    pub(super) fn text(&self) -> Result<String, SweepError> {
        serde_json::to_string(self).map_err(|error| SweepError::Plan(error.to_string()))
    }
}

/// The routines of a sweep whose plan names one. Each has so long for an answer.
///
/// # Errors
/// A plan whose routine cannot be started.
pub fn routines<'a>(
    sweep: &'a Sweep,
    programs: Option<&Programs>,
    answer: Duration,
) -> Result<Option<Routines<'a>>, SweepError> {
    let Some(text) = &sweep.plan().routine else { return Ok(None) };
    let own: Own = serde_json::from_str(text).map_err(|error| SweepError::Plan(error.to_string()))?;
    let command = own.command(programs).map_err(|failure| SweepError::Routine(failure.to_string()))?;
    let patience = Patience { answer, ..Patience::default() };
    Ok(Some(Routines::new(sweep, move |definition| {
        opened(&command, own.convention.as_ref(), patience, definition)
    })))
}

/// A routine in a process of its own.
struct Opened<'a>(Session<'a, Process>);

impl Routine for Opened<'_> {
    fn ask(&mut self, asked: &[Question<'_>]) -> Result<Vec<Option<Given>>, String> {
        let (before, _) = self.0.failures();
        let given = self.0.ask(asked);
        // Once for each process.
        if let ((1.., Some((number, why))), 0) = (self.0.failures(), before) {
            complain("note", &format!("the routine has no numbers at state {number}: {why}"));
        }
        given.map_err(|misbehaviour| match misbehaviour {
            Misbehaviour::AtState { number, .. } => {
                format!("{misbehaviour}; the same command with --state {number} prints it")
            }
            Misbehaviour::Among { .. } => {
                format!("{misbehaviour}; the same command with --state INDEX prints one")
            }
            other => other.to_string(),
        })
    }

    fn offers(&self) -> &[Quantity] {
        self.0.offers()
    }

    fn components(&self) -> [bool; 6] {
        self.0.components()
    }
}

fn opened<'a>(
    command: &str,
    convention: Option<&Convention>,
    patience: Patience,
    definition: &'a Definition,
) -> Result<Box<dyn Routine + 'a>, String> {
    let process = Process::start(command, patience).map_err(|why| why.to_string())?;
    let session = Session::open(process, definition, convention, &[None; 6]);
    Ok(Box::new(Opened(session.map_err(|why| why.to_string())?.starting_again(ENDS))))
}
