//! What an item says: a number, a name, a component, a word.

use crate::diagnostic::{Code, Diagnostic, Result, suggest};
use crate::label::normal;
use crate::span::{Span, Spanned};

/// The value of a parameter or an item of a data line, detached from the buffer.
#[derive(Debug, Clone)]
pub(crate) struct Value {
    pub(super) text: String,
    pub(super) quoted: bool,
    pub(crate) span: Span,
}

impl Value {
    /// What was written.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Is it a name of `*PARAMETER` that is not known?
    pub(crate) fn is_parameter(&self) -> bool {
        is_parameter(&self.text)
    }

    pub(crate) fn number(&self) -> Result<f64> {
        number(&self.text, self.span)
    }

    pub(crate) fn integer(&self, what: &str) -> Result<u64> {
        integer(&self.text, self.span, what)
    }

    pub(crate) fn name(&self) -> Result<Spanned<String>> {
        name(&self.text, self.span)
    }

    pub(crate) fn component(&self) -> Result<u8> {
        component(&self.text, self.span)
    }

    /// One of `words`, in any case.
    pub(crate) fn word(&self, what: &str, words: &[&'static str]) -> Result<&'static str> {
        word(&self.text, self.span, Code::BadParameterValue, what, words)
    }

    /// Quoted values are names, never numbers.
    pub(crate) fn is_integer(&self) -> bool {
        !self.quoted && !self.text.is_empty() && self.text.bytes().all(|byte| byte.is_ascii_digit())
    }
}

/// Is it `<name>`, which `*PARAMETER` would have replaced?
pub(super) fn is_parameter(text: &str) -> bool {
    text.starts_with('<') && text.ends_with('>')
}

/// Why a text is no finite double.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NotANumber {
    /// Not written as a number.
    Malformed,
    /// Beyond 1.8e308, or not zero but below 5e-324.
    OutOfRange,
}

/// The double nearest to a decimal number. The exponent may be written with E or D, in either case.
pub(crate) fn parse_number(text: &str) -> Result<f64, NotANumber> {
    let allowed =
        |byte: u8| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E' | b'd' | b'D');
    if !text.bytes().all(allowed) {
        return Err(NotANumber::Malformed);
    }
    let value = if text.bytes().any(|byte| matches!(byte, b'd' | b'D')) {
        text.replace(['d', 'D'], "e").parse::<f64>()
    } else {
        text.parse::<f64>()
    };
    let value = value.map_err(|_| NotANumber::Malformed)?;
    let mantissa = text.split(['e', 'E', 'd', 'D']).next().unwrap_or_default();
    let vanished = value == 0.0 && mantissa.bytes().any(|byte| matches!(byte, b'1'..=b'9'));
    if value.is_finite() && !vanished { Ok(value) } else { Err(NotANumber::OutOfRange) }
}

pub(super) fn number(text: &str, span: Span) -> Result<f64> {
    parse_number(text).map_err(|why| match why {
        NotANumber::OutOfRange => {
            let message = format!("{text} does not fit into a double");
            Diagnostic::error(Code::NumberOutOfRange, span, message, "too large or too small")
                .help("doubles reach from 5e-324 to 1.8e308")
        }
        NotANumber::Malformed => {
            let blank = text.contains(|letter: char| letter.is_ascii_whitespace());
            let remedy = if text.starts_with('<') && text.ends_with('>') {
                "define it by *PARAMETER from numbers, + - * / **, parentheses and functions such as sqrt, or write its value"
            } else if blank {
                "separate items by commas; a number has no blanks inside"
            } else {
                "write numbers like 1, 1., .5, 1.E-3 or 1.D-3"
            };
            Diagnostic::error(
                Code::MalformedNumber,
                span,
                format!("`{text}` is not a number"),
                "expected a number",
            )
            .help(remedy)
        }
    })
}

pub(super) fn integer(text: &str, span: Span, what: &str) -> Result<u64> {
    let digits = text.strip_prefix('+').unwrap_or(text);
    if !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return digits.parse().map_err(|_| {
            Diagnostic::error(
                Code::NumberOutOfRange,
                span,
                format!("{what} {text} is too large"),
                "too large",
            )
            .help("use a smaller number")
        });
    }
    let whole = parse_number(text).ok().filter(|value| value.fract() == 0.0 && (0.0..=1e15).contains(value));
    let remedy = match whole {
        Some(value) => format!("write {value}, without a decimal point"),
        None => "write digits only".to_owned(),
    };
    let message = format!("{what} must be a whole number, but is `{text}`");
    Err(Diagnostic::error(Code::MalformedInteger, span, message, "expected a whole number").help(remedy))
}

pub(super) fn name(text: &str, span: Span) -> Result<Spanned<String>> {
    let name = pieces(text);
    match name.filter(|name| !name.is_empty()) {
        Some(name) => Ok(Spanned::new(name, span)),
        None => {
            let message = format!("`{text}` is not a name");
            Err(Diagnostic::error(Code::MalformedName, span, message, "expected a name")
                .help("a name is a word, or any text between two quotation marks"))
        }
    }
}

/// A name; `"Part 1-1".SET` is one in two pieces, of which the first stands as it is.
fn pieces(text: &str) -> Option<String> {
    if !text.contains('"') {
        return Some(normal(text));
    }
    let (mut name, mut rest) = (String::new(), text);
    loop {
        if let Some(quoted) = rest.strip_prefix('"') {
            let (inner, after) = quoted.split_once('"')?;
            name.push_str(inner.trim());
            rest = after;
        } else {
            let end = rest.find('.').unwrap_or(rest.len());
            let (plain, after) = rest.split_at(end);
            if plain.contains('"') {
                return None;
            }
            name.push_str(&normal(plain));
            rest = after;
        }
        match rest.strip_prefix('.') {
            Some(after) => {
                name.push('.');
                rest = after;
            }
            None => return rest.is_empty().then_some(name),
        }
    }
}

pub(super) fn component(text: &str, span: Span) -> Result<u8> {
    let number = integer(text, span, "a component")?;
    u8::try_from(number).ok().filter(|component| (1..=6).contains(component)).ok_or_else(|| {
        let message = format!("there is no component {number}");
        Diagnostic::error(Code::BadComponent, span, message, "must be 1 to 6")
            .help("components 1, 2, 3 are translations (u1 to u3) and 4, 5, 6 rotations (ur1 to ur3)")
    })
}

/// The one of some words that is written, or of which the beginning is: values of parameters may be shortened as their names are.
pub(crate) fn begun<'a>(written: &str, words: &[&'a str]) -> Option<&'a str> {
    let mut all = words.iter().filter(|word| word.starts_with(written));
    let found = all.next().filter(|_| written.len() > 2)?;
    all.next().is_none().then_some(*found)
}

pub(super) fn word(
    text: &str,
    span: Span,
    code: Code,
    what: &str,
    words: &[&'static str],
) -> Result<&'static str> {
    let written = normal(text);
    let is_parameter = code == Code::BadParameterValue;
    let known = words.iter().copied().find(|word| *word == written);
    known.or_else(|| begun(&written, words).filter(|_| is_parameter)).ok_or_else(|| {
        let remedy =
            suggest(&written, words.iter().copied(), || format!("{what} is one of {}", words.join(", ")));
        Diagnostic::error(code, span, format!("{what} cannot be `{text}`"), "not one of those allowed")
            .help(remedy)
    })
}
