//! Text for a terminal: display widths, wrapping, columns.

use anstyle::{AnsiColor, Style};
use std::fmt::Display;
use std::io;
use std::io::Write;
use unicode_width::UnicodeWidthStr;

/// What is said.
pub(crate) const PLAIN: Style = Style::new();
/// Headings.
pub(crate) const BOLD: Style = Style::new().bold();
/// What is read second.
pub(crate) const DIM: Style = Style::new().dimmed();
/// What needs care.
pub(crate) const CARE: Style = AnsiColor::Yellow.on_default();

/// The number of terminal cells that a text takes; codes of styles take none.
pub(crate) fn width(text: &str) -> usize {
    if text.bytes().all(|byte| matches!(byte, b' '..=b'~')) {
        return text.len();
    }
    if text.contains('\u{1b}') {
        return anstream::adapter::strip_str(text).map(UnicodeWidthStr::width).sum();
    }
    text.width()
}

/// A count with a separator between thousands.
pub(crate) fn grouped(n: u64, separator: char) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(separator);
        }
        text.push(digit);
    }
    text
}

/// A text in a style. The codes take no cells; a stream that is no terminal drops them.
pub(crate) fn styled(style: Style, text: impl Display) -> String {
    format!("{style}{text}{style:#}")
}

/// A text filled up to a width on the right.
pub(crate) fn left(text: &str, cells: usize) -> String {
    let mut line = String::with_capacity(text.len().max(cells));
    push_left(&mut line, text, cells);
    line
}

/// Appends a text filled up to a width on the right.
pub(crate) fn push_left(line: &mut String, text: &str, cells: usize) {
    line.push_str(text);
    push_blanks(line, cells.saturating_sub(width(text)));
}

/// Appends blanks.
pub(crate) fn push_blanks(line: &mut String, count: usize) {
    const BLANKS: &str = "                                ";
    let mut left = count;
    while left > 0 {
        let now = left.min(BLANKS.len());
        line.push_str(&BLANKS[..now]);
        left -= now;
    }
}

/// A text in lines of at most `cells`, broken at blanks; a word that is longer stands alone.
pub fn wrap(text: &str, cells: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width(line) + 1 + width(word) <= cells => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_string()),
        }
    }
    lines
}

/// Writes a text in lines of at most `cells`, each `indent` blanks in.
pub(crate) fn paragraph(
    out: &mut dyn Write,
    style: Style,
    indent: usize,
    text: &str,
    cells: usize,
) -> io::Result<()> {
    for line in wrap(text, cells.saturating_sub(indent)) {
        writeln!(out, "{:indent$}{}", "", styled(style, line))?;
    }
    Ok(())
}

/// A text behind a label, wrapped so that every line begins in the same column.
pub(crate) fn labelled(label: &str, indent: usize, column: usize, text: &str, cells: usize) -> String {
    let mut result = String::new();
    let lines = wrap(text, cells.saturating_sub(column).max(20));
    for (i, line) in lines.iter().enumerate() {
        let start = if i == 0 { format!("{}{label}", " ".repeat(indent)) } else { String::new() };
        result.push_str(&left(&start, column));
        result.push_str(line);
        result.push('\n');
    }
    result
}

/// Rows of cells under a heading, each column as wide as its widest cell, two blanks between.
pub fn table(heading: &[&str], rows: &[Vec<String>]) -> String {
    let mut widths: Vec<usize> = heading.iter().map(|title| width(title)).collect();
    for row in rows {
        for (column, cell) in widths.iter_mut().zip(row) {
            *column = (*column).max(width(cell));
        }
    }
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let joined: Vec<String> = cells.zip(&widths).map(|(cell, cells)| left(cell, *cells)).collect();
        joined.join("  ").trim_end().to_string()
    };
    let mut result = styled(BOLD, line(&mut heading.iter().copied()));
    result.push('\n');
    for row in rows {
        result.push_str(&line(&mut row.iter().map(String::as_str)));
        result.push('\n');
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn combining_marks_take_no_cell() {
        assert_eq!(width("J q̇"), 3);
        assert_eq!(left("q̇", 3), "q̇  ");
    }

    #[test]
    fn styles_take_no_cell() {
        assert_eq!(width(&styled(CARE, "wrong")), 5);
    }

    #[test]
    fn lines_break_at_blanks() {
        assert_eq!(wrap("one two  three", 7), ["one two", "three"]);
        assert_eq!(wrap("unbreakable a", 4), ["unbreakable", "a"]);
        assert_eq!(wrap("", 4), Vec::<String>::new());
    }
}
