//! A counter-example in a form for others: a Rust test; of a connector a JAX script, or a deck with its states.

mod deck;
mod jax;
mod law;
mod number;
mod rust;

use crate::case::quantity::{Numbers, Quantity};
use crate::replay::counterexample::{CounterExample, ReplayError};
use pintle_kinematics::vector::{Matrix, Vector};
use pintle_scene::Diagnostic;

pub use deck::{Deck, Difference};

/// Why a counter-example cannot be written in another form.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ExportError {
    /// It is no counter-example that can be replayed.
    #[error("cannot be replayed: {0}")]
    Replay(#[from] ReplayError),
    /// The form has no place for something in it.
    #[error("{0}")]
    Lost(String),
    /// A deck of it is refused.
    #[error("it cannot be a deck: {0}")]
    Deck(#[from] Diagnostic),
}

/// What a form says of a counter-example, in one line.
fn about(title: &str, of: &CounterExample) -> String {
    let CounterExample { subject, entry, against, version, .. } = of;
    let entry = if entry.is_empty() { "no entry" } else { entry };
    comment(&format!("{title} by {subject}: {entry} against {against}, written by pintle {version}"))
}

/// One number of an evaluation: its kind, component (0-based) and place.
#[derive(Clone, Copy, Debug)]
struct NumberAt {
    quantity: Quantity,
    k: usize,
    i: usize,
}

/// The entry that a counter-example is about.
fn entry(example: &CounterExample, numbers: &Numbers<f64>) -> Result<NumberAt, ExportError> {
    let found = example.quantity.and_then(|quantity| {
        let mut all = numbers.entries(quantity).iter();
        let (k, i, _) = all.find(|(k, i, _)| quantity.entry_name(*k, *i) == example.entry)?;
        Some(NumberAt { quantity, k, i })
    });
    found.ok_or_else(|| {
        let what = if example.entry.is_empty() { "it names no entry" } else { &example.entry };
        ExportError::Lost(format!("{what}: that is no value or derivative of the connector at this state"))
    })
}

/// A double as Rust, Python and decks read it, to the last bit.
fn number(x: f64) -> String {
    format!("{x:?}")
}

/// A counter-example as a constant of a test in Rust.
fn embedded(example: &CounterExample) -> Result<String, ExportError> {
    let values =
        serde_json::to_string_pretty(example).map_err(|error| ExportError::Lost(error.to_string()))?;
    // A raw string ends at a quote with as many marks.
    let marks = (1..).map(|n| "#".repeat(n)).find(|marks| !values.contains(&format!("\"{marks}")));
    let marks = marks.unwrap_or_default();
    Ok(format!(
        "/// The values that the number follows from, doubles in hexadecimal.\nconst COUNTER_EXAMPLE: &str = r{marks}\"{values}\"{marks};\n\n"
    ))
}

fn list(all: &[f64]) -> String {
    format!("[{}]", all.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
}

fn vector(v: &Vector<f64>) -> String {
    list(v)
}

fn matrix(m: &Matrix<f64>) -> String {
    format!("[{}]", m.iter().map(vector).collect::<Vec<_>>().join(", "))
}

/// Text of a file that cannot end the comment it is put into.
fn comment(text: &str) -> String {
    text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}
