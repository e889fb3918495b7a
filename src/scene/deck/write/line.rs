//! Lines of a deck and their items: keywords, parameters, numbers, rows of tables.

use crate::choice::Choice;
use crate::deck::table::PER_LINE;
use crate::deck::write::{Deck, Name, fields, label_or_name, number, on_off, quoted, refuse};
use crate::diagnostic::{Code, Result};
use crate::document::form;
use crate::document::form::{Item, Options, Row, Target};
use crate::span::{Span, Spanned};

impl Deck {
    pub(super) fn item(&mut self, text: &str, span: Span) {
        self.text.push_str(if self.begun { ", " } else { "" });
        self.text.push_str(text);
        self.places.item(span);
        self.begun = true;
    }

    pub(super) fn end(&mut self, comma: bool) {
        self.text.push_str(if comma { ",\n" } else { "\n" });
        self.begun = false;
    }

    pub(super) fn begin(&mut self, span: Span) {
        self.places.line(span);
    }

    pub(super) fn keyword(&mut self, name: &str, span: Span) {
        self.begin(span);
        self.item(&format!("*{name}"), span);
    }

    /// The end of a keyword line.
    pub(super) fn go(&mut self) {
        self.end(false);
    }

    pub(super) fn flag(&mut self, name: &str, set: bool, span: Span) {
        if set {
            self.item(name, span);
        }
    }

    pub(super) fn parameter(&mut self, name: &str, value: impl std::fmt::Display, span: Span) {
        self.item(&format!("{name}={value}"), span);
    }

    pub(super) fn word<C: Choice>(&mut self, name: &str, choice: Option<C>, span: Span) {
        if let Some(choice) = choice {
            self.parameter(name, choice.spelling(), span);
        }
    }

    pub(super) fn name(&mut self, parameter: &str, name: &Name) -> Result<()> {
        self.parameter(parameter, quoted(name)?, name.span);
        Ok(())
    }

    pub(super) fn maybe_name(&mut self, parameter: &str, name: Option<&Name>) -> Result<()> {
        name.map_or(Ok(()), |name| self.name(parameter, name))
    }

    pub(super) fn number_of(&mut self, parameter: &str, value: Option<Spanned<f64>>) {
        if let Some(value) = value {
            self.parameter(parameter, number(value.value), value.span);
        }
    }

    pub(super) fn count_of(&mut self, parameter: &str, value: Option<Spanned<u64>>) {
        if let Some(value) = value {
            self.parameter(parameter, value.value, value.span);
        }
    }

    pub(super) fn component_of(&mut self, component: Option<Spanned<form::Component>>) {
        if let Some(component) = component {
            self.parameter("COMPONENT", component.value.0, component.span);
        }
    }

    pub(super) fn options(&mut self, (extrapolation, regularize, rtol): Options, span: Span) {
        self.word("EXTRAPOLATION", extrapolation, span);
        if let Some(regularize) = regularize {
            self.parameter("REGULARIZE", on_off(regularize), span);
        }
        self.number_of("RTOL", rtol);
    }

    pub(super) fn dependencies(&mut self, count: usize, span: Span) {
        if count > 0 {
            self.parameter("DEPENDENCIES", count, span);
        }
    }

    pub(super) fn number(&mut self, value: f64, span: Span) {
        self.item(&number(value), span);
    }

    pub(super) fn numbers(&mut self, values: &[f64], span: Span) {
        for value in values {
            self.number(*value, span);
        }
    }

    pub(super) fn maybe(&mut self, item: Option<f64>, span: Span) {
        self.item(&item.map(number).unwrap_or_default(), span);
    }

    /// A record of `width` items, eight on a line. Trailing empty ones of the last line are left out.
    pub(super) fn record(&mut self, values: &[(Option<f64>, Span)], width: usize, span: Span) {
        let lines = width.max(values.len()).div_ceil(PER_LINE).max(1);
        for line in 0..lines {
            let rest = values.get(line * PER_LINE..).unwrap_or_default();
            // What is too much stands on the last line, where the reader finds it.
            let here = if line + 1 == lines { rest.len() } else { rest.len().min(PER_LINE) };
            let here = rest.get(..here).unwrap_or_default();
            let last = here.iter().rposition(|(value, _)| value.is_some()).map_or(0, |last| last + 1);
            self.begin(here.first().map_or(span, |(_, span)| *span));
            for (value, span) in here.iter().take(last) {
                self.maybe(*value, *span);
            }
            self.end(last == 0 || here.get(last - 1).is_some_and(|(value, _)| value.is_none()));
        }
    }

    /// A row as it is written.
    fn raw(&mut self, row: &Spanned<Vec<Spanned<Item>>>, width: usize) {
        let values: Vec<_> = row.value.iter().map(|item| (item.value.0, item.span)).collect();
        self.record(&values, width, row.span);
    }

    pub(super) fn raws(&mut self, rows: &[Spanned<Vec<Spanned<Item>>>], width: usize) {
        for row in rows {
            self.raw(row, width);
        }
    }

    /// Rows of `columns` columns, with temperature and fields.
    pub(super) fn rows(&mut self, rows: &[Spanned<Row>], columns: usize) -> Result<()> {
        let fields = fields(rows);
        for row in rows {
            let Row { values, temperature, fields: own } = &row.value;
            if values.len() > columns {
                let span = values.get(columns).map_or(row.span, |item| item.span);
                let message = format!("a row of {} numbers, where there are {columns} columns", values.len());
                return Err(refuse(
                    Code::SurplusData,
                    span,
                    message,
                    "too many",
                    "give a temperature and field variables as {values = […], temperature = …, fields = […]}",
                ));
            }
            let mut record: Vec<_> = values.iter().map(|item| (item.value.0, item.span)).collect();
            record.resize(columns, (None, row.span));
            record.push((temperature.map(|value| value.value), row.span));
            record.extend(own.iter().map(|item| (item.value.0, item.span)));
            self.record(&record, columns + 1 + fields, row.span);
        }
        Ok(())
    }

    pub(super) fn components(&mut self, components: &[Spanned<form::Component>], span: Span) {
        self.begin(components.first().map_or(span, |component| component.span));
        for component in components {
            self.item(&component.value.0.to_string(), component.span);
        }
        self.end(components.is_empty());
    }

    pub(super) fn target(&mut self, target: &Spanned<Target>) -> Result<()> {
        let text = match &target.value {
            Target::Number(number) => number.to_string(),
            Target::Text(text) => label_or_name(text, target.span)?,
        };
        self.item(&text, target.span);
        Ok(())
    }
}
