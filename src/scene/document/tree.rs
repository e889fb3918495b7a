//! A document as a tree of values, each of which knows where it was read; TOML and JSON give the same trees.

use crate::diagnostic::{Code, Diagnostic, Result};
use crate::span::Span;
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use toml::de::{DeTable, DeValue};

/// How deep values may lie within each other.
pub(super) const MAX_DEPTH: usize = 32;

/// A value and its place.
#[derive(Debug)]
pub(super) struct Tree<'a> {
    pub(super) span: Span,
    pub(super) value: Value<'a>,
    /// Whether something that was wrong was taken out of it.
    pub(super) is_pruned: bool,
}

impl Tree<'_> {
    /// Takes out the innermost value of a list or table that has this place, or whose name has. Whether that value was pruned itself; `None` where there is none.
    pub(super) fn prune(&mut self, span: Span) -> Option<bool> {
        let found = match &mut self.value {
            Value::Array(items) => {
                if let Some(pruned) = items.iter_mut().find_map(|item| item.prune(span)) {
                    return Some(pruned);
                }
                let at = items.iter().position(|item| item.span == span)?;
                items.remove(at)
            }
            Value::Table(entries) => {
                if let Some(pruned) = entries.iter_mut().find_map(|(_, value)| value.prune(span)) {
                    return Some(pruned);
                }
                let at = entries.iter().position(|(key, value)| key.span == span || value.span == span)?;
                entries.remove(at).1
            }
            _ => return None,
        };
        self.is_pruned = true;
        Some(found.is_pruned)
    }
}

/// A value. Numbers are kept as they are written, in decimal digits.
#[derive(Debug)]
pub(super) enum Value<'a> {
    Null,
    Boolean(bool),
    Number(Cow<'a, str>),
    Text(Cow<'a, str>),
    Array(Vec<Tree<'a>>),
    Table(Vec<(Key<'a>, Tree<'a>)>),
}

/// The name of a field and its place.
#[derive(Debug)]
pub(super) struct Key<'a> {
    pub(super) span: Span,
    pub(super) name: Cow<'a, str>,
}

/// The lines of a text, to turn byte offsets into places.
pub(super) struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
    /// Bytes of the file before the text.
    before: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn of(text: &'a str, before: usize) -> Self {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(place, _)| place + 1);
        Self { text, starts: std::iter::once(0).chain(breaks).collect(), before }
    }

    /// The bytes from `start` to `end`, as far as they stand on the first line.
    pub(super) fn place(&self, start: usize, end: usize) -> Span {
        let start = start.min(self.text.len());
        let line = self.starts.partition_point(|first| *first <= start);
        let line_end = self.starts.get(line).map_or(self.text.len(), |next| next - 1);
        let length = end.clamp(start, line_end.max(start)) - start;
        Span::new(0, u32::try_from(line).unwrap_or(u32::MAX), (self.before + start) as u64, length)
    }

    fn begin(&self, line: usize) -> usize {
        self.starts.get(line.saturating_sub(1)).copied().unwrap_or(self.text.len())
    }
}

fn malformed(message: String, span: Span, remedy: &str) -> Diagnostic {
    Diagnostic::error(Code::SceneMalformed, span, message, "here").help(remedy)
}

fn too_deep(span: Span) -> Diagnostic {
    let message = format!("values lie more than {MAX_DEPTH} deep within each other");
    Diagnostic::error(Code::SceneTooDeep, span, message, "too deep")
        .help("no field of a scene lies so deep; see `pintle schema`")
}

fn repeated(key: &Key<'_>, first: Span) -> Diagnostic {
    let message = format!("`{}` is given twice", key.name);
    let label = format!("first given on line {}", first.line());
    Diagnostic::error(Code::SceneRepeatedField, key.span, message, label).help("keep one of the two")
}

/// Reads TOML.
pub(super) fn of_toml<'a>(text: &'a str, lines: &Lines<'_>) -> Result<Tree<'a>> {
    let (root, errors) = DeTable::parse_recoverable(text);
    let told = |error: toml::de::Error| {
        let span = error.span().unwrap_or(0..0);
        // An error at the end of a line may be said to stand at the beginning of the next one.
        let start =
            if span.start == text.len() { text.trim_end().len().saturating_sub(1) } else { span.start };
        let place = lines.place(start, span.end.max(start + 1));
        if error.message().contains("recursion") {
            return too_deep(place);
        }
        if error.message().contains("duplicate key") {
            return Diagnostic::error(
                Code::SceneRepeatedField,
                place,
                "a field or table is given twice".to_owned(),
                "the second time",
            )
            .help("keep one of the two, or write both into one table");
        }
        let message = format!("malformed TOML: {}", error.message().lines().next().unwrap_or_default());
        malformed(
            message,
            place,
            "write name = value, tables as [name], lists of tables as [[name]]; texts stand in quotation marks",
        )
    };
    // What follows on a line that is wrong follows from that.
    let mut errors: Vec<Diagnostic> = errors.into_iter().map(told).collect();
    errors.dedup_by_key(|error| error.line());
    Diagnostic::joined(errors).map_or(Ok(()), Err)?;
    let span = lines.place(0, text.len());
    Ok(Tree { span, value: toml_table(root.into_inner(), lines, 1)?, is_pruned: false })
}

fn toml_table<'a>(table: DeTable<'a>, lines: &Lines<'_>, depth: usize) -> Result<Value<'a>> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        let span = lines.place(key.span().start, key.span().end);
        let key = Key { span, name: key.into_inner() };
        let place = value.span();
        let mut tree = toml_value(value.into_inner(), lines.place(place.start, place.end), lines, depth)?;
        if !tree.span.is_known() || matches!(tree.value, Value::Table(_)) && tree.span.line() < span.line() {
            tree.span = span;
        }
        entries.push((key, tree));
    }
    Ok(Value::Table(entries))
}

fn toml_value<'a>(value: DeValue<'a>, span: Span, lines: &Lines<'_>, depth: usize) -> Result<Tree<'a>> {
    if depth > MAX_DEPTH {
        return Err(too_deep(span));
    }
    let value = match value {
        DeValue::String(text) => Value::Text(text),
        DeValue::Boolean(truth) => Value::Boolean(truth),
        DeValue::Integer(integer) if integer.radix() == 10 => {
            Value::Number(integer.as_str().trim_start_matches('+').to_owned().into())
        }
        DeValue::Integer(integer) => match u64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(number) => Value::Number(number.to_string().into()),
            Err(_) => {
                let message = format!("{} does not fit", integer.as_str());
                return Err(Diagnostic::error(Code::NumberOutOfRange, span, message, "too large")
                    .help("write the number in decimal digits"));
            }
        },
        DeValue::Float(float) => Value::Number(float.as_str().trim_start_matches('+').to_owned().into()),
        DeValue::Datetime(date) => Value::Text(date.to_string().into()),
        DeValue::Array(items) => {
            let items = items.into_iter().map(|item| {
                let place = item.span();
                toml_value(item.into_inner(), lines.place(place.start, place.end), lines, depth + 1)
            });
            Value::Array(items.collect::<Result<_>>()?)
        }
        DeValue::Table(table) => toml_table(table, lines, depth + 1)?,
    };
    Ok(Tree { span, value, is_pruned: false })
}

/// Reads JSON. Names that are given twice are added to the errors.
pub(super) fn of_json<'a>(
    text: &'a str,
    lines: &Lines<'_>,
    errors: &mut Vec<Diagnostic>,
) -> Result<Tree<'a>> {
    let raw: &RawValue = serde_json::from_str(text).map_err(|error| json_error(&error, lines, 0))?;
    json_value(raw, (text, lines), 1, errors)
}

/// `base` is the offset of the part that was being read; none of its lines count.
fn json_error(error: &serde_json::Error, lines: &Lines<'_>, base: usize) -> Diagnostic {
    let line = lines.place(base, base).line() as usize + error.line().saturating_sub(1);
    let begin = if error.line() <= 1 { base } else { lines.begin(line) };
    let start = begin + error.column().saturating_sub(1);
    let message = error.to_string();
    let message = message.split(" at line ").next().unwrap_or_default();
    let start = if error.is_eof() { lines.text.trim_end().len().saturating_sub(1) } else { start };
    malformed(
        format!("malformed JSON: {message}"),
        lines.place(start, start + 1),
        if error.is_eof() {
            "the file ends too early; close every bracket and quotation mark"
        } else {
            "write {\"name\": value, …}; no comments, and no comma after the last value"
        },
    )
}

/// Where a part of `text` begins in it.
fn offset(part: &str, text: &str) -> Option<usize> {
    let distance = (part.as_ptr() as usize).checked_sub(text.as_ptr() as usize)?;
    (distance + part.len() <= text.len()).then_some(distance)
}

fn json_value<'a>(
    raw: &'a RawValue,
    (text, lines): (&'a str, &Lines<'_>),
    depth: usize,
    errors: &mut Vec<Diagnostic>,
) -> Result<Tree<'a>> {
    let part = raw.get();
    let base = offset(part, text).unwrap_or(0);
    let span = lines.place(base, base + part.len());
    if depth > MAX_DEPTH {
        return Err(too_deep(span));
    }
    let fail = |error: serde_json::Error| json_error(&error, lines, base);
    let value = match part.as_bytes().first() {
        Some(b'{') => {
            let fields: Fields<'a> = serde_json::from_str(part).map_err(fail)?;
            let mut entries: Vec<(Key<'a>, Tree<'a>)> = Vec::with_capacity(fields.0.len());
            let mut seen = std::collections::HashMap::with_capacity(fields.0.len());
            for (name, value) in fields.0 {
                let place = match &name.0 {
                    Cow::Borrowed(name) => offset(name, text).map(|start| (start, start + name.len())),
                    Cow::Owned(_) => None,
                };
                let tree = json_value(value, (text, lines), depth + 1, errors)?;
                let span = place.map_or(tree.span, |(start, end)| lines.place(start, end));
                let key = Key { span, name: name.0 };
                if let Some(first) = seen.insert(key.name.to_string(), span) {
                    errors.push(repeated(&key, first));
                    continue;
                }
                entries.push((key, tree));
            }
            Value::Table(entries)
        }
        Some(b'[') => {
            let items: Vec<&'a RawValue> = serde_json::from_str(part).map_err(fail)?;
            let items = items.into_iter().map(|item| json_value(item, (text, lines), depth + 1, errors));
            Value::Array(items.collect::<Result<_>>()?)
        }
        Some(b'"') => Value::Text(serde_json::from_str::<Word<'a>>(part).map_err(fail)?.0),
        Some(b't') => Value::Boolean(true),
        Some(b'f') => Value::Boolean(false),
        Some(b'n') => Value::Null,
        _ => Value::Number(part.into()),
    };
    Ok(Tree { span, value, is_pruned: false })
}

/// A text, borrowed where it has no escapes.
#[derive(Deserialize)]
struct Word<'a>(#[serde(borrow)] Cow<'a, str>);

/// The fields of an object in their order, repeated ones too.
struct Fields<'a>(Vec<(Word<'a>, &'a RawValue)>);

impl<'de: 'a, 'a> Deserialize<'de> for Fields<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Fields<'de>;
            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fields<'de>, A::Error> {
                let mut fields = Vec::new();
                while let Some(entry) = map.next_entry::<Word<'de>, &'de RawValue>()? {
                    fields.push(entry);
                }
                Ok(Fields(fields))
            }
        }
        deserializer.deserialize_map(Reader)
    }
}
