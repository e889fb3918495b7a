//! An element routine in a shared library, asked by the protocol pintle-candidate/1.
//!
//! | symbol | the routine is |
//! |---|---|
//! | `pintle_element` | a connector of `pintle_element.h` ([`HEADER`]) |
//! | `pintle_mpc` | a multi-point constraint of the same |
//! | `pintle_friction` | a friction of the same |
//! | `uel_` | an Abaqus user element of two nodes, as gfortran and ifort compile it |
//!
//! `pintle check --library FILE` starts `pintle element FILE` as a process of its own, so that a routine that crashes takes nothing
//! else along. What C and Fortran declare cannot be checked from here: a library that declares other arguments does what it likes.

mod constraint;
mod friction;
mod message;
mod native;
mod uel;

use libloading::Library;
use message::{Answer, Asked};
use serde_json::{Value, json};
use std::io::{BufRead, Read, Write};
use std::path::{Path, PathBuf};

/// The header of a routine in C.
pub const HEADER: &str = include_str!("pintle_element.h");

/// What is loaded, and what a user element is called with besides.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The shared library.
    pub library: PathBuf,
    /// PROPS of a user element.
    pub properties: Vec<f64>,
    /// NSVARS of a user element.
    pub svars: usize,
    /// The degrees of freedom of the routine, in its order. Without them, those of its own convention; of a user element
    /// `a.u1 … a.ur3, b.u1 … b.ur3`.
    pub columns: Vec<String>,
}

/// A routine of any kind.
enum Routine {
    Native(native::Native),
    Constraint(constraint::Native),
    Friction(friction::Native),
    User(uel::UserElement),
}

impl Routine {
    /// Loads a library.
    ///
    /// # Errors
    /// In words, why it is none.
    fn load(options: &Options) -> Result<Self, String> {
        // Its functions are called until the process ends.
        let library: &Library = Box::leak(Box::new(open(&options.library)?));
        if let Some(native) = native::Native::of(library, options)? {
            return Ok(Self::Native(native));
        }
        if let Some(constraint) = constraint::Native::of(library)? {
            return Ok(Self::Constraint(constraint));
        }
        if let Some(friction) = friction::Native::of(library)? {
            return Ok(Self::Friction(friction));
        }
        if let Some(user) = uel::UserElement::of(library, options)? {
            return Ok(Self::User(user));
        }
        let file = options.library.display();
        Err(format!(
            "{file} defines neither pintle_element, pintle_mpc, pintle_friction nor uel_ (UEL of Fortran): pintle check --header declares the first \
             three"
        ))
    }

    fn hello(&self) -> Value {
        match self {
            Self::Native(native) => native.hello(),
            Self::Constraint(constraint) => constraint.hello(),
            Self::Friction(friction) => friction.hello(),
            Self::User(user) => user.hello(),
        }
    }

    fn open(&mut self, open: &Value) -> Result<(), String> {
        match self {
            Self::Native(native) => native.open(open),
            Self::Constraint(constraint) => constraint.open(open),
            Self::Friction(friction) => friction.open(open),
            Self::User(user) => user.open(open),
        }
    }

    fn evaluate(&self, asked: &Asked<'_>) -> Answer {
        match self {
            Self::Native(native) => native.evaluate(asked),
            Self::Constraint(constraint) => constraint.evaluate(asked),
            Self::Friction(friction) => friction.evaluate(asked),
            Self::User(user) => user.evaluate(asked),
        }
    }
}

/// Loads a library.
fn open(file: &Path) -> Result<Library, String> {
    let file = file.canonicalize().map_err(|error| format!("{}: {error}", file.display()))?;
    #[expect(unsafe_code, reason = "the library that the user names is loaded")]
    // SAFETY: what its initialisers do is the user's own; they run in a process that holds nothing else.
    let library = unsafe { Library::new(&file) };
    library.map_err(|error| {
        let why = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
        format!("{} cannot be loaded: {why}", file.display())
    })
}

/// Answers by the protocol until it is closed.
///
/// # Errors
/// Of the streams, or a message that is none.
pub fn serve(options: &Options, mut input: impl BufRead, mut output: impl Write) -> Result<(), String> {
    let mut routine = Routine::load(options);
    let in_words = |error: std::io::Error| error.to_string();
    let mut send = |message: Value, bytes: &[u8]| {
        writeln!(output, "{message}")
            .and_then(|()| output.write_all(bytes))
            .and_then(|()| output.flush())
            .map_err(in_words)
    };
    let mut line = String::new();
    loop {
        line.clear();
        if input.read_line(&mut line).map_err(in_words)? == 0 {
            return Ok(());
        }
        let message: Value = serde_json::from_str(&line).map_err(|error| error.to_string())?;
        if message.get("hello").is_some() {
            match &routine {
                Ok(routine) => send(json!({ "hello": routine.hello() }), &[])?,
                Err(why) => return Err(why.clone()),
            }
        } else if let (Some(open), Ok(routine)) = (message.get("open"), &mut routine) {
            match routine.open(open) {
                Ok(()) => send(json!({ "opened": true }), &[])?,
                Err(why) => send(json!({ "error": why }), &[])?,
            }
        } else if let (Some(asked), Ok(routine)) = (message.get("evaluate"), &routine) {
            let id = asked.get("id");
            let follow = asked.get("bytes").and_then(Value::as_u64).unwrap_or_default();
            let mut bytes = Vec::new();
            input.by_ref().take(follow).read_to_end(&mut bytes).map_err(in_words)?;
            if let (Routine::Native(native), true) = (routine, follow > 0) {
                match native.answer(asked.get("want"), &bytes) {
                    Ok(bytes) => send(json!({ "id": id, "bytes": bytes.len() }), &bytes)?,
                    Err(answers) => send(json!({ "id": id, "answers": answers }), &[])?,
                }
                continue;
            }
            let none = Vec::new();
            let states = asked.get("states").and_then(Value::as_array).unwrap_or(&none);
            let wants = message::wants(asked.get("want"));
            let answers: Vec<Answer> =
                states.iter().map(|state| routine.evaluate(&Asked { state, wants })).collect();
            send(json!({ "id": id, "answers": answers }), &[])?;
        } else if message.get("close").is_some() {
            return Ok(());
        }
    }
}
