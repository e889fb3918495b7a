//! Somebody's element routine in a process of its own: asked line by line, judged by the audit.
//!
//! | module | question |
//! |---|---|
//! | `protocol` | what is sent, and what must come back? |
//! | `convention` | in which order, unit and frame does the routine answer? |
//! | `process` | does the process behave? |
//! | `python` | how is a Python function asked? |
//!
//! The audit judges; nothing here does.

mod convention;
mod process;
mod protocol;
mod python;

pub use convention::Convention;
pub use process::{Misbehaviour, Patience, Session};
pub use protocol::PROTOCOL;
pub use python::command as python_command;

use pintle_audit::{Candidate, Question, Report, Settings};
use pintle_kinematics::connector::Definition;
use std::cell::{Cell, RefCell};

/// A report, and what it rests on.
#[derive(Debug)]
pub struct Checked {
    /// What the audit found.
    pub report: Report,
    /// How many states were asked for.
    pub states: u64,
    /// At how many of them the routine said that it does not cover them.
    pub outside: u64,
    /// What it does not offer: values, rows, components of the connector.
    pub not_offered: Vec<&'static str>,
    /// How often it was asked, differences of its own values and all.
    pub asked: u64,
}

/// Starts `command` in a shell, opens `definition`, and checks what the process answers.
///
/// # Errors
/// [`Misbehaviour`]: what the process did that the protocol does not allow.
pub fn check(
    command: &str,
    definition: &Definition,
    settings: Settings,
    patience: Patience,
) -> Result<Checked, Misbehaviour> {
    let session = Session::start(command, definition, patience)?;
    let name = session.name().to_string();
    let (values, rows, components) = session.offers();
    let session = RefCell::new(session);
    let (states, outside) = (Cell::new(0), Cell::new(0));
    let candidate = Candidate::new(&name, definition).settings(settings).offers(values, rows, components);
    let report = candidate.try_check(|asked: &Question<'_>| {
        let given = session.borrow_mut().ask(asked)?;
        // Values alone are asked for where they are differenced.
        if asked.is_drawn {
            states.set(states.get() + 1);
            outside.set(outside.get() + u64::from(given.is_none()));
        }
        Ok(given)
    })?;
    let mut session = session.into_inner();
    let not_offered = session.not_offered();
    session.ask_again()?;
    let asked = session.asked();
    session.close()?;
    Ok(Checked { report, states: states.get(), outside: outside.get(), not_offered, asked })
}
