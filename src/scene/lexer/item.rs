//! Data lines and their items, and the places of lines that were not written as a deck.

use crate::choice::Choice;
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::label::MAX_LABEL;
use crate::label::normal;
use crate::label::{Label, LabelError};
use crate::lexer::value::{Value, component, integer, is_parameter, name, number, word};
use crate::lexer::{Keyword, KeywordParameter};
use crate::span::{Span, Spanned};

/// Where the lines and items of a deck come from that was not written as a deck.
#[derive(Debug, Default)]
pub(crate) struct Places {
    /// The place of each line, and the number of items before it.
    lines: Vec<(Span, usize)>,
    items: Vec<Span>,
}

impl Places {
    /// Another line begins.
    pub(crate) fn line(&mut self, span: Span) {
        self.lines.push((span, self.items.len()));
    }

    /// Another item of it.
    pub(crate) fn item(&mut self, span: Span) {
        self.items.push(span);
    }

    pub(super) fn of_line(&self, line: u32) -> Option<LinePlaces<'_>> {
        let place = usize::try_from(line).ok()?.checked_sub(1)?;
        let &(span, first) = self.lines.get(place)?;
        let end = self.lines.get(place + 1).map_or(self.items.len(), |(_, next)| *next);
        Some(LinePlaces { span, items: self.items.get(first..end).unwrap_or_default() })
    }
}

/// Where a line and its items come from.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinePlaces<'a> {
    pub(super) span: Span,
    pub(super) items: &'a [Span],
}

/// A data line, in the buffer of the lexer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Data<'a> {
    pub(crate) text: &'a str,
    pub(crate) span: Span,
    pub(super) start: u64,
    pub(super) places: Option<LinePlaces<'a>>,
    /// The name of the assembly.
    pub(super) assembly: Option<&'a str>,
}

/// An item of a data line, without the blanks around it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Item<'a> {
    pub(crate) text: &'a str,
    pub(crate) span: Span,
    /// The place is not that of the text.
    placed: bool,
    /// The name of the assembly.
    assembly: Option<&'a str>,
}

/// A name of an instance, set or node without that of the assembly: `ASSEMBLY.CRANK-1.PIN` is `CRANK-1.PIN`.
fn without_assembly<'a>(text: &'a str, assembly: Option<&str>) -> &'a str {
    let Some(name) = assembly else { return text };
    let (bare, quote) = text.strip_prefix('"').map_or((text, 0), |bare| (bare, 1));
    let rest = bare.split_at_checked(name.len()).filter(|(head, _)| head.eq_ignore_ascii_case(name));
    match rest.and_then(|(_, rest)| rest.strip_prefix(if quote == 1 { "\"." } else { "." })) {
        Some(rest) if !rest.is_empty() => rest,
        _ => text,
    }
}

impl<'a> Data<'a> {
    /// The items between the commas. A line without text has none; a comma at its end adds none.
    pub(crate) fn items(&self) -> Items<'a> {
        Items { line: *self, rest: 0, index: 0, done: self.text.trim_ascii().is_empty() }
    }

    /// No text on it.
    pub(crate) fn is_blank(&self) -> bool {
        self.text.trim_ascii().is_empty()
    }

    pub(super) fn part(&self, from: usize, to: usize, index: usize) -> Item<'a> {
        let raw = &self.text[from..to];
        let text = raw.trim_ascii();
        let lead = raw.len() - raw.trim_ascii_start().len();
        let start = if text.is_empty() { from } else { from + lead };
        let shown = if text.is_empty() { raw.len() } else { text.len() };
        let span = match self.places {
            Some(places) => places.items.get(index).copied().unwrap_or(places.span),
            None => Span::new(self.span.file(), self.span.line(), self.start + start as u64, shown),
        };
        Item {
            text: without_assembly(text, self.assembly),
            span,
            placed: self.places.is_some(),
            assembly: self.assembly,
        }
    }

    pub(super) fn last_byte(&self) -> Span {
        if let Some(places) = self.places {
            return places.items.last().copied().unwrap_or(places.span);
        }
        let length = self.text.len();
        Span::new(
            self.span.file(),
            self.span.line(),
            self.start + length.saturating_sub(1) as u64,
            1.min(length),
        )
    }

    pub(super) fn check_quotes(&self) -> Result<()> {
        if self.text.bytes().filter(|&byte| byte == b'"').count() % 2 == 0 {
            return Ok(());
        }
        let from = self.text.rfind('"').unwrap_or(0);
        let span = self.part(from, self.text.len(), usize::MAX).span;
        Err(Diagnostic::error(
            Code::UnclosedQuote,
            span,
            "a quotation mark without its partner",
            "opens here",
        )
        .help("close the name with a second quotation mark on the same line"))
    }
}

/// The items of a data line, one after the other.
#[derive(Debug, Clone)]
pub(crate) struct Items<'a> {
    line: Data<'a>,
    rest: usize,
    index: usize,
    done: bool,
}

impl<'a> Iterator for Items<'a> {
    type Item = Item<'a>;

    fn next(&mut self) -> Option<Item<'a>> {
        if self.done {
            return None;
        }
        let from = self.rest;
        let bytes = &self.line.text.as_bytes()[from..];
        let mut quoted = false;
        let end = bytes.iter().position(|&byte| {
            quoted ^= byte == b'"';
            byte == b',' && !quoted
        });
        let to = end.map_or(self.line.text.len(), |length| from + length);
        self.rest = to + 1;
        self.done = end.is_none() || self.line.text[self.rest..].trim_ascii().is_empty();
        self.index += 1;
        Some(self.line.part(from, to, self.index - 1))
    }
}

impl<'a> Items<'a> {
    /// The next item that must be there; `what` names it in the message.
    pub(crate) fn need(&mut self, what: &str) -> Result<Item<'a>> {
        let item = self.next();
        if let Some(item) = item.filter(|item| !item.text.is_empty()) {
            return Ok(item);
        }
        let span = item.map_or(self.line.last_byte(), |item| item.span);
        Err(Diagnostic::error(Code::MissingData, span, format!("{what} is missing"), "expected here").help(
            ["; items of a data line are separated by commas", ""].map(|more| format!("give {what}{more}")),
        ))
    }

    /// The next item, if it is there and not empty.
    pub(crate) fn maybe(&mut self) -> Option<Item<'a>> {
        self.next().filter(|item| !item.text.is_empty())
    }

    /// The next item as a number, if it is there and not empty.
    pub(crate) fn number(&mut self) -> Result<Option<f64>> {
        self.maybe().map(|item| item.number()).transpose()
    }

    /// The next three items as a vector; those that are not there are 0.
    pub(crate) fn vector(&mut self) -> Result<[f64; 3]> {
        let mut vector = [0.0; 3];
        for part in &mut vector {
            *part = self.number()?.unwrap_or(0.0);
        }
        Ok(vector)
    }

    /// Nothing but blanks may follow.
    pub(crate) fn end(mut self, takes: &str) -> Result<()> {
        match self.find(|item| !item.text.is_empty()) {
            None => Ok(()),
            Some(item) => {
                Err(Diagnostic::error(Code::SurplusData, item.span, "too many items", "not expected")
                    .help(format!("this line takes {takes}")))
            }
        }
    }
}

impl<'a> Item<'a> {
    pub(super) fn keyword(&self) -> Result<Keyword> {
        let name = normal(self.text.trim_start_matches('*'));
        if name.is_empty() {
            return Err(Diagnostic::error(
                Code::EmptyKeyword,
                self.span,
                "an asterisk without a keyword",
                "here",
            )
            .help("write a keyword after the asterisk, or ** for a comment"));
        }
        Ok(Keyword { name, span: self.span, parameters: Vec::new(), not_utf8: None, dangling: None })
    }

    pub(super) fn parameter(&self) -> KeywordParameter {
        let mut quoted = false;
        let equals = self.text.bytes().position(|byte| {
            quoted ^= byte == b'"';
            byte == b'=' && !quoted
        });
        let Some(equals) = equals else {
            return KeywordParameter { name: normal(self.text), span: self.span, value: None };
        };
        let raw = &self.text[equals + 1..];
        let text = raw.trim_ascii();
        let start = equals + 1 + (raw.len() - raw.trim_ascii_start().len());
        let shown = if text.is_empty() { 0 } else { text.len() };
        let span = if self.placed {
            self.span
        } else {
            Span::new(self.span.file(), self.span.line(), self.span.start() + start as u64, shown)
        };
        let value = Item { text: without_assembly(text, self.assembly), span, ..*self };
        KeywordParameter { name: normal(&self.text[..equals]), span: self.span, value: Some(value.detach()) }
    }

    fn detach(&self) -> Value {
        Value { text: self.text.to_owned(), quoted: self.text.contains('"'), span: self.span }
    }

    /// A finite number.
    pub(crate) fn number(&self) -> Result<f64> {
        number(self.text, self.span)
    }

    /// A whole number that is not negative.
    pub(crate) fn integer(&self, what: &str) -> Result<u64> {
        integer(self.text, self.span, what)
    }

    /// A node or element: a number, or in an assembly `INSTANCE.NUMBER`.
    pub(crate) fn label(&self, what: &str) -> Result<Label> {
        if self.is_integer() || self.looks_numeric() {
            return self.label_number(what).map(Label::from);
        }
        match self.text.parse() {
            Ok(label) => Ok(label),
            Err(LabelError::Malformed(_)) => self.label_number(what).map(Label::from),
            Err(error @ LabelError::OutOfRange(_)) => {
                Err(Diagnostic::error(Code::BadLabel, self.span, error.to_string(), "out of range")
                    .help("number from 1 upwards"))
            }
        }
    }

    /// Is it written as a number, or as `INSTANCE.NUMBER`?
    pub(crate) fn is_label(&self) -> bool {
        self.is_integer()
            || self.looks_numeric()
            || !matches!(self.text.parse::<Label>(), Err(LabelError::Malformed(_)))
    }

    /// The number of a node or element.
    pub(crate) fn label_number(&self, what: &str) -> Result<u64> {
        let label = self.integer(what)?;
        if (1..=MAX_LABEL).contains(&label) {
            return Ok(label);
        }
        let message = format!("{what} must be from 1 to 2^53, but is {label}");
        Err(Diagnostic::error(Code::BadLabel, self.span, message, "out of range")
            .help("number from 1 upwards"))
    }

    /// Is it written as a whole number?
    pub(crate) fn is_integer(&self) -> bool {
        self.text.bytes().all(|byte| byte.is_ascii_digit()) && !self.text.is_empty()
    }

    /// Does it have a name of `*PARAMETER` that is not known?
    pub(crate) fn is_parameter(&self) -> bool {
        is_parameter(self.text)
    }

    /// Would it pass for a number?
    pub(crate) fn looks_numeric(&self) -> bool {
        self.text.starts_with(|letter: char| letter.is_ascii_digit() || "+-.".contains(letter))
            && self.number().is_ok()
    }

    /// A name: upper case, or as it stands between quotation marks.
    pub(crate) fn name(&self) -> Result<Spanned<String>> {
        name(self.text, self.span)
    }

    /// A component of relative motion, 1 to 6.
    pub(crate) fn component(&self) -> Result<u8> {
        component(self.text, self.span)
    }

    /// One of the words of `C`, in any case.
    pub(crate) fn choice<C: Choice>(&self, what: &str) -> Result<Option<C>> {
        word(self.text, self.span, Code::BadValue, what, C::SPELLINGS).map(C::of_spelling)
    }
}
