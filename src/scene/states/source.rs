//! Where states are read from: a text, or a file that is never held as a whole.

use crate::diagnostic::{Code, Diagnostic, Result};
use crate::span::Span;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

const BYTE_ORDER_MARK: char = '\u{feff}';

/// A text, or a file; bytes are counted after a byte order mark.
#[derive(Clone, Copy)]
pub(crate) enum Source<'a> {
    Text(&'a str),
    File(&'a Path),
}

impl<'a> Source<'a> {
    /// Whether it can be read more than once: not so a pipe.
    pub(crate) fn is_repeatable(self) -> bool {
        match self {
            Self::Text(_) => true,
            Self::File(path) => path.metadata().is_ok_and(|metadata| metadata.is_file()),
        }
    }

    /// The text from a byte on.
    pub(crate) fn reader(self, start: u64) -> io::Result<Box<dyn BufRead + 'a>> {
        match self {
            Self::Text(text) => {
                let start = usize::try_from(start).unwrap_or(usize::MAX);
                Ok(Box::new(text.as_bytes().get(start..).unwrap_or_default()))
            }
            Self::File(path) => {
                let mut file = BufReader::with_capacity(1 << 16, File::open(path)?);
                let mark = BYTE_ORDER_MARK.len_utf8();
                let mut first = Vec::new();
                file.by_ref().take(mark as u64).read_to_end(&mut first)?;
                let mark = if first == BYTE_ORDER_MARK.to_string().as_bytes() { mark as u64 } else { 0 };
                file.seek(SeekFrom::Start(mark + start))?;
                Ok(Box::new(file))
            }
        }
    }

    /// The bytes of the first lines.
    pub(super) fn length_of_lines(self, count: usize) -> u64 {
        let Ok(mut reader) = self.reader(0) else { return 0 };
        (0..count).map_while(|_| skip_line(&mut reader).ok()).sum()
    }

    /// The bytes of all.
    pub(super) fn length(self) -> u64 {
        match self {
            Self::Text(text) => text.len() as u64,
            Self::File(path) => path.metadata().map_or(0, |metadata| metadata.len()),
        }
    }
}

/// Passes over a line, however long, and gives its length in bytes.
fn skip_line(reader: &mut impl BufRead) -> io::Result<u64> {
    let mut length = 0;
    loop {
        let bytes = reader.fill_buf()?;
        let (used, is_end) = match bytes.iter().position(|byte| *byte == b'\n') {
            Some(at) => (at + 1, true),
            None => (bytes.len(), bytes.is_empty()),
        };
        reader.consume(used);
        length += used as u64;
        if is_end {
            return Ok(length);
        }
    }
}

/// An error in a file, with its place shown.
pub(crate) fn located_in(path: &Path, error: Diagnostic) -> Diagnostic {
    let name = path.display().to_string();
    match Source::File(path).reader(0) {
        Ok(reader) => error.shown_in(&name, reader),
        Err(_) => error.shown_in(&name, io::empty()),
    }
}

/// Whether a file of `what` is JSON rather than CSV, by its ending.
pub(crate) fn is_json(path: &Path, what: &str) -> Result<bool> {
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    match ending.as_ref().and_then(|ending| ending.to_str()) {
        Some("csv") => Ok(false),
        Some("json") => Ok(true),
        _ => {
            let remedy = format!("name the file of {what} .csv or .json, as it is written");
            let name = path.display().to_string();
            Err(Diagnostic::error(Code::UnknownFormat, Span::default(), "neither .csv nor .json", "")
                .help(remedy)
                .in_file(&name))
        }
    }
}

/// A file that cannot be read.
pub(crate) fn unreadable(error: &io::Error) -> Diagnostic {
    let message = format!("cannot be read: {error}");
    Diagnostic::error(Code::Unreadable, Span::default(), message, "")
        .help("check the path and its permissions")
}

/// The name and text of a file of `what`, and whether it is JSON rather than CSV.
pub(crate) fn text_of(path: &Path, what: &str) -> Result<(String, String, bool)> {
    let name = path.display().to_string();
    let is_json = is_json(path, what)?;
    let text = std::fs::read_to_string(path).map_err(|error| unreadable(&error).in_file(&name))?;
    Ok((name, text, is_json))
}

pub(crate) fn without_mark(text: &str) -> &str {
    text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)
}

pub(crate) fn located(error: Diagnostic, name: &str, text: &str) -> Diagnostic {
    error.shown_in(name, text.as_bytes())
}
