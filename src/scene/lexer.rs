//! Lines of a deck: comments, keyword lines with their continuation, data lines with their items.
//!
//! The lexer reads one line at a time into one buffer. Names without quotation marks are compared in upper
//! case; quoted names keep their case and their blanks.

use super::choice::Choice;
use super::diagnostic::{Code, Diagnostic, Result};
use super::label::{Label, LabelError};
use super::span::{Span, Spanned};
use std::io::{BufRead, Read};

/// The longest line that is read, in bytes.
pub const MAX_LINE: usize = 65_535;

/// The largest node or element number: up to it, a double holds every whole number.
pub const MAX_LABEL: u64 = 1 << 53;

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

    fn of_line(&self, line: u32) -> Option<LinePlaces<'_>> {
        let place = usize::try_from(line).ok()?.checked_sub(1)?;
        let &(span, first) = self.lines.get(place)?;
        let end = self.lines.get(place + 1).map_or(self.items.len(), |(_, next)| *next);
        Some(LinePlaces { span, items: self.items.get(first..end).unwrap_or_default() })
    }
}

/// Where a line and its items come from.
#[derive(Debug, Clone, Copy)]
struct LinePlaces<'a> {
    span: Span,
    items: &'a [Span],
}

/// Reads a deck line by line.
pub(crate) struct Lexer<'a> {
    input: &'a mut dyn BufRead,
    places: Option<&'a Places>,
    buffer: Vec<u8>,
    /// The buffer holds a line that nobody has taken yet.
    pending: bool,
    line: u32,
    start: u64,
    next: u64,
    /// Comment lines so far.
    pub(crate) comments: u64,
}

/// A keyword line with everything that continues it.
#[derive(Debug, Clone)]
pub(crate) struct Keyword {
    /// The keyword in upper case, words separated by one blank, without the asterisk.
    pub(crate) name: String,
    /// The keyword with its asterisk.
    pub(crate) span: Span,
    /// What follows the keyword.
    pub(crate) parameters: Vec<KeywordParameter>,
}

/// One parameter of a keyword line.
#[derive(Debug, Clone)]
pub(crate) struct KeywordParameter {
    /// Upper case, words separated by one blank.
    pub(crate) name: String,
    /// Parameter and value.
    pub(crate) span: Span,
    /// What follows the equals sign, if there is one.
    pub(crate) value: Option<Value>,
}

/// The value of a parameter or an item of a data line, detached from the buffer.
#[derive(Debug, Clone)]
pub(crate) struct Value {
    text: String,
    quoted: bool,
    pub(crate) span: Span,
}

/// A data line, in the buffer of the lexer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Data<'a> {
    pub(crate) text: &'a str,
    pub(crate) span: Span,
    start: u64,
    places: Option<LinePlaces<'a>>,
}

/// An item of a data line, without the blanks around it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Item<'a> {
    pub(crate) text: &'a str,
    pub(crate) span: Span,
    /// The place is not that of the text.
    placed: bool,
}

impl<'a> Lexer<'a> {
    pub(crate) fn new(input: &'a mut dyn BufRead) -> Self {
        Self {
            input,
            places: None,
            buffer: Vec::new(),
            pending: false,
            line: 0,
            start: 0,
            next: 0,
            comments: 0,
        }
    }

    /// Reads a deck whose lines and items come from elsewhere.
    pub(crate) fn placed(input: &'a mut dyn BufRead, places: &'a Places) -> Self {
        Self { places: Some(places), ..Self::new(input) }
    }

    fn place(&self, start: u64, length: usize) -> Span {
        let place = self.places.and_then(|places| places.of_line(self.line));
        place.map_or_else(|| Span::new(0, self.line, start, length), |place| place.span)
    }

    /// The next keyword line, or nothing at the end of the deck. A data line here is an error.
    pub(crate) fn keyword(&mut self) -> Result<Option<Keyword>> {
        loop {
            if !self.fill()? {
                return Ok(None);
            }
            if self.at_keyword() {
                break;
            }
            if !self.buffer.trim_ascii().is_empty() {
                return Err(self.stray());
            }
            self.pending = false;
        }
        let mut keyword: Option<Keyword> = None;
        loop {
            let line = self.take()?;
            let continued = line.text.trim_end().ends_with(',');
            line.check_quotes()?;
            for item in line.items() {
                match &mut keyword {
                    None => keyword = Some(item.keyword()?),
                    Some(_) if item.text.is_empty() => {}
                    Some(keyword) => keyword.parameters.push(item.parameter()),
                }
            }
            if !continued {
                return Ok(keyword);
            }
            let comma = line.last_byte();
            if !self.fill()? || self.at_keyword() {
                return Err(Diagnostic::error(
                    Code::DanglingContinuation,
                    comma,
                    "a keyword line ends in a comma, but nothing continues it",
                    "this comma announces another line",
                )
                .help("remove the comma, or continue the keyword on the next line"));
            }
        }
    }

    /// The next data line, or nothing before a keyword and at the end of the deck.
    pub(crate) fn data(&mut self) -> Result<Option<Data<'_>>> {
        if !self.fill()? || self.at_keyword() {
            return Ok(None);
        }
        let data = self.take()?;
        data.check_quotes()?;
        Ok(Some(data))
    }

    /// The next data line that is not blank.
    pub(crate) fn row(&mut self) -> Result<Option<Data<'_>>> {
        while self.fill()? && self.buffer.trim_ascii().is_empty() {
            self.pending = false;
        }
        self.data()
    }

    /// The next data line as text, whatever its bytes.
    pub(crate) fn text(&mut self) -> Result<Option<String>> {
        if !self.fill()? || self.at_keyword() {
            return Ok(None);
        }
        self.pending = false;
        Ok(Some(String::from_utf8_lossy(self.buffer.trim_ascii()).into_owned()))
    }

    /// Passes over the data lines up to the next keyword and counts them.
    pub(crate) fn skip(&mut self) -> Result<u64> {
        let mut count = 0;
        while self.fill()? && !self.at_keyword() {
            self.pending = false;
            count += 1;
        }
        Ok(count)
    }

    fn at_keyword(&self) -> bool {
        self.buffer.trim_ascii_start().first() == Some(&b'*')
    }

    fn stray(&self) -> Diagnostic {
        let span = self.place(self.start, self.buffer.trim_ascii_end().len());
        Diagnostic::error(
            Code::StrayData,
            span,
            "a data line without a keyword",
            "no keyword takes this line",
        )
        .help("a deck begins with a keyword such as *HEADING or *NODE; comments begin with **")
    }

    /// Makes sure that the buffer holds a line that is no comment; false at the end of the deck.
    fn fill(&mut self) -> Result<bool> {
        while !self.pending {
            self.buffer.clear();
            self.start = self.next;
            self.line = self.line.saturating_add(1);
            let limit = MAX_LINE as u64 + 1;
            let length =
                Read::take(&mut self.input, limit).read_until(b'\n', &mut self.buffer).map_err(|error| {
                    let place = Span::new(0, self.line, self.start, 0);
                    Diagnostic::error(
                        Code::Unreadable,
                        place,
                        format!("cannot read on: {error}"),
                        "up to here",
                    )
                    .help("check the file and the disk it is on")
                })?;
            if length == 0 {
                return Ok(false);
            }
            self.next += length as u64;
            if self.line == 1 && self.buffer.starts_with(b"\xef\xbb\xbf") {
                self.buffer.drain(..3);
                self.start += 3;
            }
            if length > MAX_LINE {
                let place = self.place(self.start, 1);
                let message = format!("a line of more than {MAX_LINE} bytes");
                return Err(Diagnostic::error(Code::LineTooLong, place, message, "begins here")
                    .help("break the line; is this a text file?"));
            }
            self.pending = !self.buffer.trim_ascii_start().starts_with(b"**");
            self.comments += u64::from(!self.pending);
        }
        Ok(true)
    }

    /// The pending line as text.
    fn take(&mut self) -> Result<Data<'_>> {
        self.pending = false;
        let bytes = self.buffer.trim_ascii_end();
        let places = self.places.and_then(|places| places.of_line(self.line));
        let span =
            places.map_or_else(|| Span::new(0, self.line, self.start, bytes.len()), |place| place.span);
        match std::str::from_utf8(bytes) {
            Ok(text) => Ok(Data { text, span, start: self.start, places }),
            Err(error) => {
                let place = Span::new(0, self.line, self.start + error.valid_up_to() as u64, 1);
                let message = "a line with bytes that are not UTF-8";
                Err(Diagnostic::error(Code::NotUtf8, place, message, "the first such byte")
                    .help("save the deck as UTF-8, or write names in plain ASCII"))
            }
        }
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

    fn part(&self, from: usize, to: usize, index: usize) -> Item<'a> {
        let raw = &self.text[from..to];
        let text = raw.trim_ascii();
        let lead = raw.len() - raw.trim_ascii_start().len();
        let start = if text.is_empty() { from } else { from + lead };
        let shown = if text.is_empty() { raw.len() } else { text.len() };
        let span = match self.places {
            Some(places) => places.items.get(index).copied().unwrap_or(places.span),
            None => Span::new(0, self.span.line(), self.start + start as u64, shown),
        };
        Item { text, span, placed: self.places.is_some() }
    }

    fn last_byte(&self) -> Span {
        if let Some(places) = self.places {
            return places.items.last().copied().unwrap_or(places.span);
        }
        let length = self.text.len();
        Span::new(0, self.span.line(), self.start + length.saturating_sub(1) as u64, 1.min(length))
    }

    fn check_quotes(&self) -> Result<()> {
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
        Err(Diagnostic::error(Code::MissingData, span, format!("{what} is missing"), "expected here")
            .help(format!("give {what}; items of a data line are separated by commas")))
    }

    /// The next item, if it is there and not empty.
    pub(crate) fn maybe(&mut self) -> Option<Item<'a>> {
        self.next().filter(|item| !item.text.is_empty())
    }

    /// The next item as a number, if it is there and not empty.
    pub(crate) fn number(&mut self) -> Result<Option<f64>> {
        self.maybe().map(|item| item.number()).transpose()
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

/// Blanks collapsed, upper case.
pub(crate) fn normal(text: &str) -> String {
    let mut name = String::with_capacity(text.len());
    for word in text.split_ascii_whitespace() {
        if !name.is_empty() {
            name.push(' ');
        }
        name.push_str(&word.to_ascii_uppercase());
    }
    name
}

impl<'a> Item<'a> {
    fn keyword(&self) -> Result<Keyword> {
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
        Ok(Keyword { name, span: self.span, parameters: Vec::new() })
    }

    fn parameter(&self) -> KeywordParameter {
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
            Span::new(0, self.span.line(), self.span.start() + start as u64, shown)
        };
        let value = Item { text, span, placed: self.placed };
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

impl Value {
    /// What was written.
    pub(crate) fn text(&self) -> &str {
        &self.text
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

fn number(text: &str, span: Span) -> Result<f64> {
    parse_number(text).map_err(|why| match why {
        NotANumber::OutOfRange => {
            let message = format!("{text} does not fit into a double");
            Diagnostic::error(Code::NumberOutOfRange, span, message, "too large or too small")
                .help("doubles reach from 5e-324 to 1.8e308")
        }
        NotANumber::Malformed => {
            let blank = text.contains(|letter: char| letter.is_ascii_whitespace());
            let remedy = if blank {
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

fn integer(text: &str, span: Span, what: &str) -> Result<u64> {
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

fn name(text: &str, span: Span) -> Result<Spanned<String>> {
    let inner = text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    let name = inner.map_or_else(|| normal(text), |inner| inner.trim().to_owned());
    if name.is_empty() || name.contains('"') {
        let message = format!("`{text}` is not a name");
        return Err(Diagnostic::error(Code::MalformedName, span, message, "expected a name")
            .help("a name is a word, or any text between two quotation marks"));
    }
    Ok(Spanned::new(name, span))
}

fn component(text: &str, span: Span) -> Result<u8> {
    let number = integer(text, span, "a component")?;
    u8::try_from(number).ok().filter(|component| (1..=6).contains(component)).ok_or_else(|| {
        let message = format!("there is no component {number}");
        Diagnostic::error(Code::BadComponent, span, message, "must be 1 to 6")
            .help("components 1, 2, 3 are translations (u1 to u3) and 4, 5, 6 rotations (ur1 to ur3)")
    })
}

fn word(text: &str, span: Span, code: Code, what: &str, words: &[&'static str]) -> Result<&'static str> {
    let written = normal(text);
    words.iter().find(|&&word| word == written).copied().ok_or_else(|| {
        let remedy = super::diagnostic::suggest(&written, words.iter().copied(), || {
            format!("{what} is one of {}", words.join(", "))
        });
        Diagnostic::error(code, span, format!("{what} cannot be `{text}`"), "not one of those allowed")
            .help(remedy)
    })
}

#[cfg(test)]
mod tests {
    use super::{Keyword, Lexer, NotANumber, parse_number};
    use crate::scene::Code;

    fn keyword(text: &str) -> Keyword {
        Lexer::new(&mut text.as_bytes()).keyword().unwrap().unwrap()
    }

    fn items(text: &str) -> Vec<String> {
        let mut bytes = text.as_bytes();
        let mut lexer = Lexer::new(&mut bytes);
        lexer.data().unwrap().unwrap().items().map(|item| item.text.to_owned()).collect()
    }

    #[test]
    fn numbers_are_exact_and_finite() {
        for (text, value) in [
            ("1", 1.0_f64),
            ("1.", 1.0),
            (".5", 0.5),
            ("-3.2", -3.2),
            ("+4", 4.0),
            ("1.D0", 1.0),
            ("2.5d-3", 2.5e-3),
            ("1.E-6", 1e-6),
            ("0.1000000000000000055511151231257827", 0.1),
            ("0.0e-999", 0.0),
        ] {
            assert_eq!(parse_number(text).map(f64::to_bits), Ok(value.to_bits()), "{text}");
        }
        for text in ["", ".", "1 0", "nan", "inf", "1e", "0x1", "1e5e5", "--1", "1_000"] {
            assert_eq!(parse_number(text), Err(NotANumber::Malformed), "{text}");
        }
        for text in ["1e999", "-1e999", "1e-999"] {
            assert_eq!(parse_number(text), Err(NotANumber::OutOfRange), "{text}");
        }
    }

    #[test]
    fn keywords_continue_and_fold_case() {
        let keyword =
            keyword("** first\n*connector   Section, elset = Pin ,\n** between\n behavior=\"My, Set\"\n");
        assert_eq!(keyword.name, "CONNECTOR SECTION");
        let [elset, behavior] = keyword.parameters.as_slice() else { panic!("{keyword:?}") };
        assert_eq!((elset.name.as_str(), elset.span.line()), ("ELSET", 2));
        assert_eq!(elset.value.as_ref().unwrap().name().unwrap().value, "PIN");
        assert_eq!((behavior.name.as_str(), behavior.span.line()), ("BEHAVIOR", 4));
        assert_eq!(behavior.value.as_ref().unwrap().name().unwrap().value, "My, Set");
    }

    #[test]
    fn items_keep_empty_ones_inside_and_drop_a_trailing_comma() {
        assert_eq!(items("1, , 3"), ["1", "", "3"]);
        assert_eq!(items("Hinge,"), ["Hinge"]);
        assert_eq!(items(" , 3.0 "), ["", "3.0"]);
        assert_eq!(items("\"a, b\", c"), ["\"a, b\"", "c"]);
        assert_eq!(items("1,,"), ["1", ""]);
        assert!(items("   ").is_empty());
    }

    #[test]
    fn spans_point_at_the_bytes() {
        let text = "*NODE\r\n1, 2.5\r\n";
        let mut bytes = text.as_bytes();
        let mut lexer = Lexer::new(&mut bytes);
        lexer.keyword().unwrap();
        let item = lexer.data().unwrap().unwrap().items().nth(1).unwrap();
        let (start, end) = (item.span.start() as usize, item.span.end() as usize);
        assert_eq!((&text[start..end], item.span.line()), ("2.5", 2));
    }

    #[test]
    fn long_lines_are_refused() {
        let text = format!("*NODE\n{}", "1".repeat(70_000));
        let mut bytes = text.as_bytes();
        let mut lexer = Lexer::new(&mut bytes);
        lexer.keyword().unwrap();
        assert_eq!(lexer.data().unwrap_err().code(), Code::LineTooLong);
    }
}
