//! Tables of numbers: records of several columns, temperature and field variables.

use crate::behavior::TableRow;
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::lexer::Lexer;
use crate::span::Span;
use crate::wording::keyword;

/// What is said where the lines of a keyword should be.
pub(super) const LINE_FOLLOWS: [&str; 2] = ["a data line should follow", "here"];

/// Items on one data line of a table.
pub(super) const PER_LINE: usize = 8;

/// Numbers of one record, and its first line.
#[derive(Debug, Clone)]
pub(super) struct Record {
    pub(super) values: Vec<Option<f64>>,
    pub(super) span: Span,
}

impl Record {
    /// Column `index`, which may not be empty.
    pub(super) fn need(&self, index: usize, what: &str) -> Result<f64> {
        self.values.get(index).copied().flatten().ok_or_else(|| {
            Diagnostic::error(Code::MissingData, self.span, format!("{what} is missing"), "on this line")
                .help(format!("give {what} as item {} of the line", index + 1))
        })
    }

    /// Columns, then temperature, then field variables.
    pub(super) fn row(self, columns: usize) -> TableRow {
        let mut values = self.values;
        let rest = values.split_off(columns.min(values.len()));
        values.resize(columns, None);
        let mut rest = rest.into_iter();
        TableRow { values, temperature: rest.next().flatten(), fields: rest.collect(), span: self.span }
    }
}

/// The next record of `width` numbers, eight on a line; trailing ones may be missing.
pub(super) fn record(lexer: &mut Lexer<'_>, width: usize) -> Result<Option<Record>> {
    let mut values = Vec::with_capacity(width);
    let Some(first) = lexer.row()? else { return Ok(None) };
    let span = first.span;
    let mut line = first;
    loop {
        let here = PER_LINE.min(width - values.len());
        let mut items = line.items();
        for _ in 0..here {
            values.push(items.number()?);
        }
        items.end(&format!("{here} number{}", if here == 1 { "" } else { "s" }))?;
        if values.len() >= width {
            return Ok(Some(Record { values, span }));
        }
        let filled = values.len();
        line = match lexer.data()? {
            Some(line) => line,
            None => {
                let message = format!("a row of {width} numbers ends after {filled}");
                return Err(Diagnostic::error(Code::MissingData, span, message, "begins here")
                    .help(format!("continue the row on the next line, {PER_LINE} numbers on each")));
            }
        };
    }
}

/// All records up to the next keyword.
pub(super) fn records(lexer: &mut Lexer<'_>, width: usize) -> Result<Vec<Record>> {
    let mut records = Vec::new();
    while let Some(record) = record(lexer, width)? {
        records.push(record);
    }
    Ok(records)
}

/// All records as they stand.
pub(super) fn raw(lexer: &mut Lexer<'_>, width: usize) -> Result<Vec<Vec<Option<f64>>>> {
    Ok(records(lexer, width)?.into_iter().map(|record| record.values).collect())
}

/// A table that must have a row, each with its first `needed` columns.
pub(super) fn rows(
    lexer: &mut Lexer<'_>,
    keyword: (&str, Span),
    columns: &[&str],
    needed: usize,
    fields: usize,
) -> Result<Vec<TableRow>> {
    let records = records(lexer, columns.len() + 1 + fields)?;
    if records.is_empty() {
        return Err(no_rows(keyword, columns));
    }
    for record in &records {
        for (index, what) in columns.iter().enumerate().take(needed) {
            record.need(index, what)?;
        }
    }
    Ok(records.into_iter().map(|record| record.row(columns.len())).collect())
}

pub(super) fn no_rows((name, span): (&str, Span), columns: &[&str]) -> Diagnostic {
    let [keyword, field] = keyword(name);
    let message = [format!("{keyword} has no data line"), format!("{field} has no rows")];
    Diagnostic::error(Code::MissingData, span, message, LINE_FOLLOWS)
        .help(["line", "row"].map(|line| format!("give a {line} with {}", columns.join(", "))))
}
