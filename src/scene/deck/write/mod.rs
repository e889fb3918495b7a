//! A scene as a deck: every part as the keywords and data lines from which it can be read again.
//!
//! Documents in TOML and JSON are read in the same way: as the deck they stand for, each item of which knows its
//! place in the document. What the reader of decks checks is therefore checked for them by the same code.

mod behavior;
mod constraint;
mod history;
mod line;
mod mesh;
mod property;

use crate::diagnostic::{Code, Diagnostic, Result};
use crate::document::form::{Document, Row};
use crate::label::normal;
use crate::label::{Label, LabelError};
use crate::lexer::Places;
use crate::span::{Span, Spanned};
use mesh::instances;

/// Members of a set on one data line.
const MEMBERS_PER_LINE: usize = 16;

/// Nodes of a constraint on its first data line.
const NODES_PER_LINE: usize = 15;

/// A deck, and where its items come from.
#[derive(Default)]
pub(crate) struct Deck {
    pub(crate) text: String,
    pub(crate) places: Places,
    /// Has the line an item yet?
    begun: bool,
}

/// The deck that a document stands for.
pub(crate) fn deck(document: &Document) -> Result<Deck> {
    let mut deck = Deck::default();
    deck.heading(&document.heading)?;
    deck.mesh(document)?;
    deck.properties(document)?;
    if !instances(document).is_empty() {
        deck.keyword("END ASSEMBLY", Span::default());
        deck.go();
    }
    for (name, amplitude) in &document.amplitudes.0 {
        deck.amplitude(name, amplitude)?;
    }
    for (name, behavior) in &document.behaviors.0 {
        deck.behavior(name, behavior)?;
    }
    deck.velocities(&document.initial_velocities)?;
    deck.actuation(&document.boundaries, &document.connector_motions)?;
    for step in &document.steps {
        deck.step(step)?;
    }
    if deck.text.is_empty() {
        deck.keyword("HEADING", Span::default());
        deck.go();
    }
    Ok(deck)
}

type Name = Spanned<String>;

fn refuse(code: Code, span: Span, message: String, label: &str, remedy: &str) -> Diagnostic {
    Diagnostic::error(code, span, message, label).help(remedy)
}

fn has_control(text: &str) -> bool {
    text.chars().any(char::is_control)
}

/// A name as a deck writes it: between quotation marks if it would not be the same without them.
fn quoted(name: &Name) -> Result<String> {
    let text = name.value.as_str();
    if text.is_empty() || text.contains('"') || has_control(text) || text.trim() != text {
        let message = format!("`{}` is not a name", text.escape_debug());
        return Err(refuse(
            Code::MalformedName,
            name.span,
            message,
            "not a name",
            "a name has no quotation marks, no line breaks, and no blanks at its ends",
        ));
    }
    let numeric = text.starts_with(|letter: char| letter.is_ascii_digit() || "+-.".contains(letter));
    let plain = normal(text) == text && !numeric && !text.contains([',', '=', '*', '.']);
    Ok(if plain { text.to_owned() } else { format!("\"{text}\"") })
}

/// A word of our choice, which must not break the line.
fn plain(text: &Name, what: &str) -> Result<String> {
    let bad =
        has_control(&text.value) || text.value.contains([',', '"', '*', '=']) || text.value.trim().is_empty();
    if bad {
        let message = format!("`{}` is not {what}", text.value.escape_debug());
        return Err(refuse(Code::BadValue, text.span, message, "not a word", "write a word"));
    }
    Ok(text.value.trim().to_owned())
}

fn on_off(on: bool) -> &'static str {
    if on { "ON" } else { "OFF" }
}

fn yes_no(yes: bool) -> &'static str {
    if yes { "YES" } else { "NO" }
}

/// The shortest digits that read back to the same double.
fn number(value: f64) -> String {
    let mut text = String::new();
    text.push_str(&format!("{value:?}"));
    text
}

/// The number of field variables of a table: that of the row with the most.
fn fields(rows: &[Spanned<Row>]) -> usize {
    rows.iter().map(|row| row.value.fields.len()).max().unwrap_or(0)
}

fn dependencies(count: Option<Spanned<u64>>) -> usize {
    let count = count.map_or(0, |count| count.value);
    usize::try_from(count).unwrap_or(usize::MAX).min(crate::deck::MAX_DEPENDENCIES)
}

/// A label as a deck writes it, or a name.
fn label_or_name(text: &str, span: Span) -> Result<String> {
    match text.parse::<Label>() {
        Ok(label) => Ok(label.to_string()),
        Err(LabelError::OutOfRange(_)) => Ok(text.trim().to_owned()),
        Err(LabelError::Malformed(_)) => quoted(&Spanned::new(text.to_owned(), span)),
    }
}
