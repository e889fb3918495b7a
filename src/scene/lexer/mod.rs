//! Lines of a deck: comments, keyword lines with their continuation, data lines with their items.
//!
//! The lexer reads one line at a time into one buffer. Names without quotation marks are compared in upper
//! case; quoted names keep their case and their blanks.

mod item;
mod parameter;
mod value;

use crate::diagnostic::{Code, Diagnostic, Result, ends_with_line_feed};
use crate::include;
use crate::include::{Files, MAX_INCLUDE_DEPTH, MAX_INCLUDED_BYTES, MAX_INCLUDES};
use crate::span::Span;
use item::LinePlaces;
use std::io::{BufRead, Read};

pub(crate) use item::{Data, Item, Items, Places};
pub(crate) use parameter::Parameters;
pub(crate) use value::{NotANumber, Value, begun, parse_number};

/// The longest line that is read, in bytes.
pub const MAX_LINE: usize = 65_535;

/// Reads a deck line by line, and the files that it includes as if their lines stood in their place.
pub(crate) struct Lexer<'a> {
    files: &'a dyn Files,
    /// The file that is being read, within those that include it.
    frames: Vec<Frame<'a>>,
    /// Every file by its number in spans.
    names: Vec<String>,
    buffer: Vec<u8>,
    /// The buffer holds a line that nobody has taken yet.
    pending: bool,
    file: u16,
    line: u32,
    start: u64,
    /// Bytes that may still be included.
    budget: u64,
    places: Option<&'a Places>,
    /// What `<name>` stands for.
    pub(crate) parameters: Parameters,
    /// The line is not as it was written: names were replaced in it.
    replaced: bool,
    /// The name of the assembly, which may stand before names of its instances and sets.
    pub(crate) assembly: Option<String>,
    /// Comment lines so far.
    pub(crate) comments: u64,
}

/// A file that is being read.
struct Frame<'a> {
    input: Box<dyn BufRead + 'a>,
    file: u16,
    line: u32,
    next: u64,
    /// What was read beyond the line, where lines end in CR.
    rest: Vec<u8>,
}

impl Frame<'_> {
    /// Reads a line, which ends in LF, CRLF or CR, and gives its length; 0 at the end of the file.
    fn read_line(&mut self, buffer: &mut Vec<u8>) -> std::io::Result<usize> {
        std::mem::swap(buffer, &mut self.rest);
        self.rest.clear();
        if !buffer.iter().any(|byte| b"\r\n".contains(byte)) {
            let limit = (MAX_LINE as u64 + 1).saturating_sub(buffer.len() as u64);
            Read::take(&mut self.input, limit).read_until(b'\n', buffer)?;
        }
        let mut from = 0;
        while let Some(at) = buffer.get(from..).and_then(|rest| rest.iter().position(|byte| *byte == b'\r')) {
            from += at + 1;
            if !buffer.get(from..).is_none_or(ends_with_line_feed) {
                self.rest.extend(buffer.drain(from..));
            }
        }
        Ok(buffer.len())
    }
}

/// Writes blanks for the blanks that do not break lines, which word processors and pages leave.
fn blank_spaces(line: &mut [u8]) {
    if line.is_ascii() {
        return;
    }
    for at in 1..line.len() {
        if line.get(at - 1..=at) == Some(b"\xc2\xa0") {
            line[at - 1..=at].fill(b' ');
        }
    }
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
    /// The first byte that is not UTF-8; question marks stand for such bytes.
    pub(crate) not_utf8: Option<Span>,
    /// A comma at its end that nothing continues.
    pub(crate) dangling: Option<Dangling>,
}

/// A comma at the end of a keyword line, before another keyword or the end of the deck.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dangling(Span);

impl Dangling {
    /// That something is missing.
    pub(crate) fn error(self) -> Diagnostic {
        let message = "a keyword line ends in a comma, but nothing continues it";
        let label = "this comma announces another line";
        Diagnostic::error(Code::DanglingContinuation, self.0, message, label)
            .help("remove the comma, or continue the keyword on the next line")
    }
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

impl<'a> Lexer<'a> {
    pub(crate) fn new(name: &str, input: Box<dyn BufRead + 'a>, files: &'a dyn Files) -> Self {
        Self {
            files,
            frames: vec![Frame { input, file: 0, line: 0, next: 0, rest: Vec::new() }],
            names: vec![name.to_owned()],
            buffer: Vec::new(),
            pending: false,
            file: 0,
            line: 0,
            start: 0,
            budget: MAX_INCLUDED_BYTES,
            places: None,
            parameters: Parameters::default(),
            replaced: false,
            assembly: None,
            comments: 0,
        }
    }

    /// The same deck, whose lines and items come from elsewhere.
    pub(crate) fn placed(self, places: &'a Places) -> Self {
        Self { places: Some(places), ..self }
    }

    fn place(&self, start: u64, length: usize) -> Span {
        let place = self.places.and_then(|places| places.of_line(self.line));
        place.map_or_else(|| Span::new(self.file, self.line, start, length), |place| place.span)
    }

    /// The file and line that were read last.
    pub(crate) fn place_of_line(&self) -> (u16, u32, bool) {
        (self.file, self.line, self.pending)
    }

    /// The names of all files, by their numbers in spans.
    pub(crate) fn into_names(self) -> Vec<String> {
        self.names
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
        self.pending_keyword()
    }

    /// The keyword that begins with the pending line.
    fn pending_keyword(&mut self) -> Result<Option<Keyword>> {
        let mut keyword: Option<Keyword> = None;
        let mut not_utf8 = None;
        loop {
            if let Err(error) = std::str::from_utf8(&self.buffer) {
                let place = Span::new(self.file, self.line, self.start + error.valid_up_to() as u64, 1);
                not_utf8.get_or_insert(place);
                self.buffer.iter_mut().filter(|byte| !byte.is_ascii()).for_each(|byte| *byte = b'?');
            }
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
                return Ok(keyword.map(|keyword| Keyword { not_utf8, ..keyword }));
            }
            let comma = line.last_byte();
            let goes_on = self.fill_line()?;
            if goes_on && self.at_number() {
                // No parameter begins like that: the comma is one too many, and the line one of data.
                return Ok(keyword.map(|keyword| Keyword { not_utf8, ..keyword }));
            }
            if !goes_on || self.at_keyword() {
                let dangling = Some(Dangling(comma));
                return Ok(keyword.map(|keyword| Keyword { not_utf8, dangling, ..keyword }));
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

    /// The data line that was read last is the next one again.
    pub(crate) fn again(&mut self) {
        self.pending = true;
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

    fn at_number(&self) -> bool {
        let first = self.buffer.trim_ascii_start().first();
        first.is_some_and(|byte| byte.is_ascii_digit() || b"+-.".contains(byte))
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

    /// Makes sure that the buffer holds a line that is neither a comment nor an include; false at the end of the deck.
    fn fill(&mut self) -> Result<bool> {
        while self.fill_line()? {
            if !self.at_include() {
                return Ok(true);
            }
            if let Some(keyword) = self.pending_keyword()? {
                self.include_keyword(&keyword)?;
            }
        }
        Ok(false)
    }

    /// The same, with includes taken for lines.
    fn fill_line(&mut self) -> Result<bool> {
        while !self.pending {
            let Some(frame) = self.frames.last_mut() else { return Ok(false) };
            self.buffer.clear();
            frame.line = frame.line.saturating_add(1);
            (self.file, self.line, self.start) = (frame.file, frame.line, frame.next);
            let place = Span::new(self.file, self.line, self.start, 1);
            let length = frame.read_line(&mut self.buffer).map_err(|error| {
                let message = format!("cannot read on: {error}");
                Diagnostic::error(Code::Unreadable, place, message, "up to here")
                    .help("check the file and the disk it is on")
            })?;
            if length == 0 {
                self.frames.pop();
                continue;
            }
            frame.next += length as u64;
            if self.file > 0 {
                self.budget = self.budget.checked_sub(length as u64).ok_or_else(|| {
                    let message = format!("included files have more than {MAX_INCLUDED_BYTES} bytes");
                    Diagnostic::error(Code::IncludeLimit, place, message, "up to here")
                        .help("include each file once; does a file include others many times?")
                })?;
            }
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
            if self.line == 1
                && [&b"\xff\xfe"[..], b"\xfe\xff"].iter().any(|mark| self.buffer.starts_with(mark))
            {
                let message = "the file is encoded as UTF-16";
                return Err(Diagnostic::error(Code::NotUtf8, place, message, "its byte order mark")
                    .help("save the deck as UTF-8"));
            }
            blank_spaces(&mut self.buffer);
            let text = self.buffer.trim_ascii();
            // The last is the end of a file of DOS.
            self.pending = !text.starts_with(b"**") && text != b"*" && text != b"\x1a";
            self.comments += u64::from(!self.pending);
            self.replaced = self.pending && self.parameters.replace(&mut self.buffer);
        }
        Ok(true)
    }

    fn at_include(&self) -> bool {
        let text = self.buffer.trim_ascii_start();
        let Some(word) = text.strip_prefix(b"*").map(<[u8]>::trim_ascii_start) else { return false };
        let end = word.iter().position(|byte| *byte == b',').unwrap_or(word.len());
        let word = word.get(..end).unwrap_or_default().trim_ascii_end();
        // No other keyword begins with INCL.
        word.len() >= 4 && b"INCLUDE".get(..word.len()).is_some_and(|begun| begun.eq_ignore_ascii_case(word))
    }

    fn include_keyword(&mut self, keyword: &Keyword) -> Result<()> {
        if let Some(place) = keyword.not_utf8 {
            return Err(not_utf8(place));
        }
        if let Some(comma) = keyword.dangling {
            return Err(comma.error());
        }
        let input = |parameter: &&KeywordParameter| {
            "INPUT".starts_with(parameter.name.as_str()) && !parameter.name.is_empty()
        };
        if let Some(other) = keyword.parameters.iter().find(|parameter| !input(parameter)) {
            let (code, remedy) = if other.name == "PASSWORD" {
                (Code::UnsupportedKeyword, "decrypt the file, and include it without PASSWORD")
            } else {
                (Code::UnknownParameter, "*INCLUDE takes INPUT")
            };
            let message = format!("*INCLUDE has a parameter {}", other.name);
            return Err(Diagnostic::error(code, other.span, message, "not supported").help(remedy));
        }
        let value = keyword.parameters.iter().find(input).and_then(|parameter| parameter.value.as_ref());
        match value.filter(|value| !value.text.is_empty()) {
            Some(value) => self.include(value),
            None => {
                let message = "*INCLUDE does not say what to include";
                Err(Diagnostic::error(Code::MissingParameter, keyword.span, message, "INPUT is missing")
                    .help("write *INCLUDE, INPUT=…"))
            }
        }
    }

    /// Goes on with the lines of another file.
    pub(crate) fn include(&mut self, input: &Value) -> Result<()> {
        let written = input.text.trim_matches('"');
        let from = self.names.get(usize::from(input.span.file())).map_or("", String::as_str);
        let fail = |code, message: String, remedy: String| {
            Err(Diagnostic::error(code, input.span, message, "this file").help(remedy))
        };
        // Paths count from the file that has them, or from the deck itself, as where a solver runs.
        let root = self.names.first().map_or("", String::as_str);
        let names: Vec<String> =
            [from, root].iter().filter_map(|from| self.files.name(written, from)).collect();
        let opened = names.iter().find_map(|name| Some((name, self.files.open(name).ok()?)));
        let (name, opened) = match (opened, names.first()) {
            (Some((name, input)), _) => (name.clone(), Ok(input)),
            (None, Some(name)) => (name.clone(), self.files.open(name)),
            (None, None) => {
                let (code, remedy) = include::ALONE;
                return fail(code, format!("{written} cannot be included here"), remedy.to_owned());
            }
        };
        let open = self.frames.iter().filter_map(|frame| self.names.get(usize::from(frame.file)));
        let mut chain: Vec<&str> = open.map(String::as_str).collect();
        let circle = chain.contains(&name.as_str());
        chain.push(&name);
        if circle {
            let message = format!("a file includes itself: {}", include::chain(&chain));
            return fail(Code::IncludeCycle, message, "remove one of these includes".to_owned());
        }
        if chain.len() > MAX_INCLUDE_DEPTH + 1 {
            let message =
                format!("includes nest deeper than {MAX_INCLUDE_DEPTH}: {}", include::chain(&chain));
            return fail(Code::IncludeLimit, message, "include the files from the deck itself".to_owned());
        }
        let number = u16::try_from(self.names.len()).ok().filter(|number| *number <= MAX_INCLUDES);
        let Some(file) = number else {
            let message = format!("more than {MAX_INCLUDES} files are included");
            return fail(Code::IncludeLimit, message, "include each file once".to_owned());
        };
        match opened {
            Ok(input) => {
                self.names.push(name);
                self.frames.push(Frame { input, file, line: 0, next: 0, rest: Vec::new() });
                Ok(())
            }
            Err(error) => {
                let message = format!("{name} cannot be included: {error}");
                let remedy =
                    format!("check the path; it counts from the directory of {from}, or of the deck");
                fail(Code::IncludeUnreadable, message, remedy)
            }
        }
    }

    /// The pending line as text.
    fn take(&mut self) -> Result<Data<'_>> {
        self.pending = false;
        let bytes = self.buffer.trim_ascii_end();
        let places = self.places.and_then(|places| places.of_line(self.line));
        let span = self.place(self.start, bytes.len());
        let places = if self.replaced { Some(LinePlaces { span, items: &[] }) } else { places };
        match std::str::from_utf8(bytes) {
            Ok(text) => {
                Ok(Data { text, span, start: self.start, places, assembly: self.assembly.as_deref() })
            }
            Err(error) => {
                let place = Span::new(self.file, self.line, self.start + error.valid_up_to() as u64, 1);
                Err(not_utf8(place))
            }
        }
    }
}

/// The error for bytes that are not UTF-8 where they must be read.
pub(crate) fn not_utf8(place: Span) -> Diagnostic {
    let message = "a line with bytes that are not UTF-8";
    Diagnostic::error(Code::NotUtf8, place, message, "the first such byte")
        .help("save the deck as UTF-8, or write names in plain ASCII")
}

#[cfg(test)]
mod tests {
    use super::{Keyword, Lexer, NotANumber, parse_number};
    use crate::{Code, NoFiles};

    fn lexer(text: &str) -> Lexer<'_> {
        Lexer::new("deck.inp", Box::new(text.as_bytes()), &NoFiles)
    }

    fn keyword(text: &str) -> Keyword {
        lexer(text).keyword().unwrap().unwrap()
    }

    fn items(text: &str) -> Vec<String> {
        let mut lexer = lexer(text);
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
        let mut lexer = lexer(text);
        lexer.keyword().unwrap();
        let item = lexer.data().unwrap().unwrap().items().nth(1).unwrap();
        let (start, end) = (item.span.start() as usize, item.span.end() as usize);
        assert_eq!((&text[start..end], item.span.line()), ("2.5", 2));
    }

    #[test]
    fn long_lines_are_refused() {
        let text = format!("*NODE\n{}", "1".repeat(70_000));
        let mut lexer = lexer(&text);
        lexer.keyword().unwrap();
        assert_eq!(lexer.data().unwrap_err().code(), Code::LineTooLong);
    }
}
