//! `*INCLUDE`: where the files that a deck includes come from.

use crate::diagnostic::{Code, Diagnostic};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

/// How deep includes may nest.
pub const MAX_INCLUDE_DEPTH: usize = 16;

/// How many files a deck may include altogether.
pub const MAX_INCLUDES: u16 = 10_000;

/// How many bytes all included files may have together.
pub const MAX_INCLUDED_BYTES: u64 = 1 << 34;

/// The files that a deck may include.
///
/// Reading a deck opens nothing but what this gives: [`Disk`] for files, a map from names to texts for decks in memory,
/// [`NoFiles`] where a deck must stand alone.
pub trait Files {
    /// What the file is called that `from` includes as `path`, or nothing if this opens no files at all.
    fn name(&self, path: &str, from: &str) -> Option<String>;

    /// The text of the file of that name.
    ///
    /// # Errors
    /// When there is none, or it cannot be opened.
    fn open(&self, name: &str) -> io::Result<Box<dyn BufRead + '_>>;
}

/// Files on disk, relative to the file that includes them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disk;

impl Files for Disk {
    fn name(&self, path: &str, from: &str) -> Option<String> {
        // Decks from Windows have backslashes; elsewhere they would be part of a file name, which nobody means.
        let path = if std::path::MAIN_SEPARATOR == '/' { path.replace('\\', "/") } else { path.to_owned() };
        let directory = Path::new(from).parent().unwrap_or(Path::new(""));
        Some(directory.join(path).display().to_string())
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn BufRead + '_>> {
        if Path::new(name).is_dir() {
            return Err(io::Error::other("a directory, not a file"));
        }
        Ok(Box::new(BufReader::new(File::open(name)?)))
    }
}

/// No files: a deck that includes one is refused.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoFiles;

impl Files for NoFiles {
    fn name(&self, _: &str, _: &str) -> Option<String> {
        None
    }

    fn open(&self, _: &str) -> io::Result<Box<dyn BufRead + '_>> {
        Err(io::ErrorKind::NotFound.into())
    }
}

/// Texts by name, for decks in memory.
impl<T: AsRef<[u8]>> Files for BTreeMap<String, T> {
    fn name(&self, path: &str, _: &str) -> Option<String> {
        Some(path.to_owned())
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn BufRead + '_>> {
        match self.get(name) {
            Some(text) => Ok(Box::new(text.as_ref())),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }
}

/// The deck itself under its name, and what `files` has under theirs.
pub(crate) struct Named<'a> {
    pub(crate) root: &'a str,
    pub(crate) text: Option<&'a [u8]>,
    pub(crate) files: &'a dyn Files,
}

impl Named<'_> {
    pub(crate) fn open(&self, name: &str) -> io::Result<Box<dyn BufRead + '_>> {
        match self.text.filter(|_| name == self.root) {
            Some(text) => Ok(Box::new(text)),
            None => self.files.open(name),
        }
    }

    /// Names the file of every diagnostic and fetches the lines that it shows. `names` has the files by number.
    pub(crate) fn attach(&self, diagnostics: &mut [Diagnostic], names: &[String]) {
        for diagnostic in &mut *diagnostics {
            diagnostic.name_files(names);
        }
        diagnostics.sort_by_key(|diagnostic| diagnostic.span().file());
        for part in diagnostics.chunk_by_mut(|a, b| a.span().file() == b.span().file()) {
            let Some(name) = part.first().map(|first| first.file().to_owned()) else { continue };
            if let Ok(source) = self.open(&name) {
                Diagnostic::attach(part, &name, source);
            }
        }
    }
}

/// Why a file is not included.
pub(super) fn chain(names: &[&str]) -> String {
    names.join(" → ")
}

/// The remedy where nothing may be included.
pub(super) const ALONE: (Code, &str) = (
    Code::UnsupportedKeyword,
    "copy the lines of the included file into the deck, or read the deck from a file on disk",
);
