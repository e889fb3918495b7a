//! States, and other rows, from CSV, as they are read.

use crate::diagnostic::{Code, Diagnostic, Result, suggest};
use crate::freedom::NodeFreedom;
use crate::label::Label;
use crate::lexer::{NotANumber, parse_number};
use crate::model::Scene;
use crate::model::{NodeMotion, State};
use crate::span::Span;
use crate::states::source::{Source, unreadable};
use crate::states::{Faults, Take, check_motion, check_node, label, rotation};
use std::io::{self, BufRead};
use std::ops::ControlFlow;

const COLUMNS: [&str; 28] = [
    "state", "time", "node", "u1", "u2", "u3", "ur1", "ur2", "ur3", "q0", "q1", "q2", "q3", "v1", "v2", "v3",
    "vr1", "vr2", "vr3", "a1", "a2", "a3", "ar1", "ar2", "ar3", "flow", "flow_v", "flow_a",
];

/// Hands on the rows of a table, each with whether nothing was wrong before it, until `take` breaks off. `find` knows its columns by the
/// fields of its first line; `known` lists them.
pub(crate) fn csv_rows(
    source: Source<'_>,
    known: &[&'static str],
    find: impl Fn(&str) -> Option<&'static str>,
    needed: &'static str,
    mut take: impl FnMut(&CsvRow<'_>, bool) -> Result<ControlFlow<()>>,
) -> Result<()> {
    let mut faults = Faults::default();
    // A comment that ends the file without a line break would be read as an empty row.
    let lines = io::Read::chain(source.reader(0).map_err(|error| unreadable(&error))?, b"\n".as_slice());
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(lines);
    let malformed = |error: &csv::Error| {
        if let csv::ErrorKind::Io(error) = error.kind() {
            return unreadable(error);
        }
        let span = error.position().map(place).unwrap_or_default();
        Diagnostic::error(Code::StatesMalformed, span, format!("malformed CSV: {error}"), "here")
            .help(format!("separate fields by commas, one row per {needed} and state"))
    };
    let mut record = csv::StringRecord::new();
    // A line of blanks is none, as an empty one.
    let mut next = |record: &mut csv::StringRecord| loop {
        let is_there = reader.read_record(record).map_err(|error| malformed(&error))?;
        if !(is_there && record.len() == 1 && record.iter().all(str::is_empty)) {
            return Ok(is_there);
        }
    };
    if !next(&mut record)? {
        return Err(empty("columns"));
    }
    let columns = header_columns(&record, row_span(&record, source), known, find, needed)?;
    let mut is_empty = true;
    loop {
        match next(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            // Where the next row begins is not known.
            Err(error) => {
                faults.add(error);
                break;
            }
        }
        is_empty = false;
        if record.len() != columns.len() {
            let span = row_span(&record, source);
            let message = format!("a row of {} fields under a header of {}", record.len(), columns.len());
            faults.add(
                Diagnostic::error(Code::StatesMalformed, span, message, "this row")
                    .help("give every row as many fields as the header; an empty field is 0"),
            );
            continue;
        }
        match take(&CsvRow { record: &record, columns: &columns, source }, faults.is_empty()) {
            Ok(ControlFlow::Continue(())) => {}
            Ok(ControlFlow::Break(())) => return Ok(()),
            Err(error) => faults.add(error),
        }
    }
    faults.end()?;
    if is_empty { Err(empty("rows")) } else { Ok(()) }
}

/// Hands on the states of a table, one after another.
pub(super) fn states(source: Source<'_>, scene: &Scene, take: &mut Take<'_>) -> Result<()> {
    let freedom = NodeFreedom::of(scene);
    let mut current: Option<(u64, State)> = None;
    let find = |field: &str| COLUMNS.into_iter().find(|column| column.eq_ignore_ascii_case(field));
    let mut stopped = false;
    csv_rows(source, &COLUMNS, find, "node", |row, is_clean| {
        let (number, time) = (row.integer("state")?.unwrap_or(0), row.number("time")?);
        let own = row.has("state").then_some(number);
        let next = (number, State { number: own, time, ..State::default() });
        let disorder = |message: String, remedy: &str| {
            Err(Diagnostic::error(Code::StatesOrder, row.span(), message, "this row").help(remedy))
        };
        match &mut current {
            Some((last, state)) if *last == number => {
                if state.time != time {
                    state.time = time;
                    let message = format!("state {number} has rows of different time");
                    return disorder(
                        message,
                        "give all rows of a state the same time, or another state number",
                    );
                }
            }
            Some((last, _)) if *last > number => {
                let message = format!("state {number} comes after state {last}");
                current = Some(next);
                return disorder(message, "put the rows of a state together, and number the states upwards");
            }
            _ => {
                if let Some((_, whole)) = current.replace(next)
                    && is_clean
                    && take(whole).is_break()
                {
                    stopped = true;
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
        let Some((_, state)) = &mut current else { return Ok(ControlFlow::Continue(())) };
        let Some(node) = row.label("node")? else {
            return Err(Diagnostic::error(
                Code::StatesMalformedNumber,
                row.span(),
                "a row without a node",
                "this row",
            )
            .help("give the node number in the column `node`"));
        };
        let checked =
            check_node(node, scene, state).map_err(|fault| fault.at(row.place("node"), "this node"));
        let motion = row.motion();
        if let Some(error) =
            Diagnostic::joined(checked.err().into_iter().chain(motion.as_ref().err().cloned()))
        {
            return Err(error);
        }
        let motion = motion?;
        check_motion(node, &motion, &freedom).map_err(|fault| fault.at(row.span(), "this row"))?;
        state.nodes.insert(node, motion);
        Ok(ControlFlow::Continue(()))
    })?;
    if let Some((_, last)) = current
        && !stopped
    {
        _ = take(last);
    }
    Ok(())
}

pub(crate) fn empty(what: &str) -> Diagnostic {
    Diagnostic::error(Code::StatesEmpty, Span::default(), format!("the file has no {what}"), "")
        .help("give a header line and at least one row, or leave the file out for the initial state")
}

fn place(position: &csv::Position) -> Span {
    Span::new(0, u32::try_from(position.line()).unwrap_or(u32::MAX), position.byte(), 0)
}

/// The lines of a source from a byte on, with the byte and number of each, counted on from `line`.
fn lines_from(source: Source<'_>, mut start: u64, mut line: u32) -> impl Iterator<Item = (u64, u32, String)> {
    let mut reader = source.reader(start).ok();
    std::iter::from_fn(move || {
        let mut bytes = Vec::new();
        let length = reader.as_mut()?.read_until(b'\n', &mut bytes).ok().filter(|length| *length > 0)?;
        let found = (start, line, String::from_utf8_lossy(&bytes).into_owned());
        (start, line) = (start + length as u64, line.saturating_add(1));
        Some(found)
    })
}

/// The first line of a record, after the blank lines and comments that its position may include.
fn row_line(record: &csv::StringRecord, source: Source<'_>) -> Option<(u64, u32, String)> {
    let position = record.position()?;
    let line = u32::try_from(position.line()).unwrap_or(u32::MAX);
    let is_content = |text: &str| !text.trim_end().is_empty() && !text.starts_with('#');
    lines_from(source, position.byte(), line).find(|(_, _, text)| is_content(text))
}

fn row_span(record: &csv::StringRecord, source: Source<'_>) -> Span {
    match row_line(record, source) {
        Some((start, line, text)) => Span::new(0, line, start, text.trim_end().len()),
        None => record.position().map(place).unwrap_or_default(),
    }
}

fn header_columns(
    record: &csv::StringRecord,
    span: Span,
    known: &[&'static str],
    find: impl Fn(&str) -> Option<&'static str>,
    needed: &'static str,
) -> Result<Vec<&'static str>> {
    let mut columns: Vec<&'static str> = Vec::with_capacity(record.len());
    let mut faults = Faults::default();
    for field in record {
        let Some(column) = find(field) else {
            let is_apart = record.len() == 1 && field.contains([';', '\t', '|', ' ']);
            let remedy = match is_apart {
                true => "separate columns by commas, in the header and in each row".to_owned(),
                false => {
                    suggest(field, known.iter().copied(), || format!("columns are {}", known.join(", ")))
                }
            };
            let message = format!("there is no column `{field}`");
            faults
                .add(Diagnostic::error(Code::StatesUnknownColumn, span, message, "the header").help(remedy));
            continue;
        };
        if columns.contains(&column) {
            let message = format!("the column `{column}` occurs twice");
            faults.add(
                Diagnostic::error(Code::StatesRepeatedColumn, span, message, "the header")
                    .help("remove one of the two"),
            );
        }
        columns.push(column);
    }
    faults.end()?;
    if !columns.contains(&needed) {
        let message = format!("no column `{needed}`");
        return Err(Diagnostic::error(Code::StatesMissingColumn, span, message, "the header")
            .help(format!("name the column of {needed} numbers `{needed}`")));
    }
    Ok(columns)
}

/// A row of a table. Where it stands is found when it is asked for.
pub(crate) struct CsvRow<'a> {
    record: &'a csv::StringRecord,
    columns: &'a [&'static str],
    source: Source<'a>,
}

impl CsvRow<'_> {
    fn has(&self, column: &str) -> bool {
        self.columns.contains(&column)
    }

    pub(crate) fn span(&self) -> Span {
        row_span(self.record, self.source)
    }

    pub(crate) fn field(&self, column: &str) -> Option<&str> {
        let index = self.columns.iter().position(|known| *known == column)?;
        self.record.get(index).filter(|field| !field.is_empty())
    }

    /// Where a field stands; the whole row if it has quotation marks.
    pub(crate) fn place(&self, column: &str) -> Span {
        let index = self.columns.iter().position(|known| *known == column);
        let found = row_line(self.record, self.source);
        let (Some(index), Some((start, line, row))) = (index, found) else { return self.span() };
        if row.contains('"') {
            return self.span();
        }
        let row = row.trim_end_matches(['\n', '\r']);
        let before: usize = row.split(',').take(index).map(|field| field.len() + 1).sum();
        let field = row.split(',').nth(index).unwrap_or_default();
        let lead = field.len() - field.trim_start().len();
        Span::new(0, line, start + (before + lead) as u64, field.trim().len())
    }

    pub(crate) fn number(&self, column: &str) -> Result<Option<f64>> {
        let Some(field) = self.field(column) else { return Ok(None) };
        parse_number(field).map(Some).map_err(|why| {
            let (code, message, remedy) = match why {
                NotANumber::Malformed => (
                    Code::StatesMalformedNumber,
                    format!("`{field}` in column {column} is not a number"),
                    "write numbers like 1, 0.5 or 1e-3; states are finite",
                ),
                NotANumber::OutOfRange => (
                    Code::StatesNumberOutOfRange,
                    format!("{field} in column {column} does not fit into a double"),
                    "doubles reach from 5e-324 to 1.8e308",
                ),
            };
            Diagnostic::error(code, self.place(column), message, format!("column {column}")).help(remedy)
        })
    }

    pub(crate) fn integer(&self, column: &str) -> Result<Option<u64>> {
        let Some(field) = self.field(column) else { return Ok(None) };
        field.parse().map(Some).map_err(|_| {
            let message = format!("`{field}` in column {column} is not a whole number");
            Diagnostic::error(
                Code::StatesMalformedNumber,
                self.place(column),
                message,
                format!("column {column}"),
            )
            .help("write digits only")
        })
    }

    pub(crate) fn label(&self, column: &str) -> Result<Option<Label>> {
        let Some(field) = self.field(column) else { return Ok(None) };
        label(field, column)
            .map(Some)
            .map_err(|fault| fault.at(self.place(column), &format!("column {column}")))
    }

    /// The numbers of several columns; none when all of them are empty or absent.
    fn numbers<const N: usize>(&self, columns: [&str; N]) -> Result<Option<[f64; N]>> {
        let mut values = [0.0; N];
        let (mut given, mut faults) = (false, Faults::default());
        for (value, column) in values.iter_mut().zip(columns) {
            match self.number(column) {
                Ok(Some(number)) => (*value, given) = (number, true),
                Ok(None) => {}
                Err(error) => faults.add(error),
            }
        }
        faults.end()?;
        Ok(given.then_some(values))
    }

    fn motion(&self) -> Result<NodeMotion> {
        let vector = |columns| Ok(self.numbers::<3>(columns)?.unwrap_or_default());
        let rotation =
            rotation(self.numbers(["ur1", "ur2", "ur3"])?, self.numbers(["q0", "q1", "q2", "q3"])?)
                .map_err(|fault| fault.at(self.span(), "this row"))?;
        Ok(NodeMotion {
            displacement: vector(["u1", "u2", "u3"])?,
            rotation,
            velocity: vector(["v1", "v2", "v3"])?,
            angular_velocity: vector(["vr1", "vr2", "vr3"])?,
            acceleration: vector(["a1", "a2", "a3"])?,
            angular_acceleration: vector(["ar1", "ar2", "ar3"])?,
            flow: self.number("flow")?.unwrap_or(0.0),
            flow_velocity: self.number("flow_v")?.unwrap_or(0.0),
            flow_acceleration: self.number("flow_a")?.unwrap_or(0.0),
        })
    }
}
