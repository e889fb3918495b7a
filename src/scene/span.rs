//! Where in which file something was read.

use serde::{Serialize, Serializer};

/// A place in an input file: line, and byte range from the start of the file.
///
/// Sixteen bytes, because every node and element of a deck carries one. The default value is "no place".
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    start: u64,
    line: u32,
    length: u16,
    file: u16,
}

impl Span {
    /// The bytes `start .. start + length` of a file, on the 1-based `line`; lengths beyond 65 535 are cut.
    #[must_use]
    pub fn new(file: u16, line: u32, start: u64, length: usize) -> Self {
        Self { start, line, length: u16::try_from(length).unwrap_or(u16::MAX), file }
    }

    /// The 1-based line; 0 when there is no place.
    #[must_use]
    pub fn line(self) -> u32 {
        self.line
    }

    /// The first byte, counted from the start of the file.
    #[must_use]
    pub fn start(self) -> u64 {
        self.start
    }

    /// The byte after the last one.
    #[must_use]
    pub fn end(self) -> u64 {
        self.start + u64::from(self.length)
    }

    /// The number of the file, 0 for the one that was asked for.
    #[must_use]
    pub fn file(self) -> u16 {
        self.file
    }

    /// Is there a place at all?
    #[must_use]
    pub fn is_known(self) -> bool {
        self.line > 0
    }
}

/// A value and where it was read. It serialises as the value alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it was read.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// `value`, read at `span`.
    #[must_use]
    pub fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}

impl<T> std::ops::Deref for Spanned<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T: Serialize> Serialize for Spanned<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.value.serialize(serializer)
    }
}
