//! Numbers in a list: of multi-point constraints, frictions, slopes of behaviour.

use super::matching::{Datum, Hypothesis, Matching, Place, Words, ranges};
use super::{Cause, Diagnosis};
use crate::audit::mutant::Changes;
use crate::audit::sheet::Sheet;
use std::collections::BTreeSet;

/// Why numbers are wrong; `None` where none is. Tried are the mistakes that the sheet knows, and those that every number can suffer.
pub fn diagnose_sheet(sheet: &Sheet) -> Option<Diagnosis> {
    let width = sheet.width();
    let place = |i: usize| (i / width, i % width);
    let data = sheet.entries.iter().enumerate().map(|(i, entry)| {
        let (want, tolerance) = (entry.want.to_f64(), entry.tolerance());
        (place(i), Datum { got: Some(entry.got), want, tolerance, class: entry.class })
    });
    let known = sheet.mistakes.iter().map(|change| Hypothesis {
        cause: Cause::of(change.mistake),
        changes: Changes::Many(change.changes.iter().map(|(i, x)| (i / width, i % width, *x)).collect()),
    });
    let mut hypotheses: Vec<Hypothesis> = known.collect();
    for row in 0..sheet.rows.len() {
        let changes = sheet.entries.iter().enumerate().skip(row * width).take(width);
        let changes = changes.map(|(i, entry)| (row, i % width, -entry.want.to_f64())).collect();
        hypotheses.push(Hypothesis { cause: Cause::Reversed, changes: Changes::Many(changes) });
    }
    hypotheses.extend(sheet.conventions.iter().map(|(cause, changes)| Hypothesis {
        cause: *cause,
        changes: Changes::Many(changes.iter().map(|(i, x)| (i / width, i % width, *x)).collect()),
    }));
    let words = Named { sheet, width };
    let mut matching = Matching { data: data.collect(), hypotheses, words: &words };
    matching.add_mistakes_of_entries();
    matching.diagnosis()
}

struct Named<'a> {
    sheet: &'a Sheet,
    width: usize,
}

impl Words for Named<'_> {
    fn entry(&self, (row, column): Place) -> String {
        let entry = self.sheet.entries.get(row * self.width + column);
        entry.map(|entry| entry.name.clone()).unwrap_or_default()
    }

    fn region(&self, places: &BTreeSet<Place>) -> String {
        let mut rows: Vec<(String, String)> = Vec::new();
        for (n, row) in self.sheet.rows.iter().enumerate() {
            let columns: BTreeSet<usize> =
                places.iter().filter(|(row, _)| *row == n).map(|(_, column)| *column).collect();
            if columns.is_empty() {
                continue;
            }
            let name = |j: usize| self.sheet.columns.get(j).cloned().unwrap_or_default();
            let of_columns = if columns.len() == self.width || self.sheet.columns.is_empty() {
                String::new()
            } else {
                format!("/∂{}", ranges(&columns, &name).join(" and ∂"))
            };
            rows.push((row.clone(), of_columns));
        }
        let named: Vec<String> = rows.into_iter().map(|(row, columns)| row + &columns).collect();
        named.join(", ")
    }

    fn triads(&self) -> [&'static str; 2] {
        ["C_S", "C_M"]
    }

    fn rotations(&self, places: &BTreeSet<Place>) -> [bool; 2] {
        let has = |start: &str| {
            let names = places.iter().filter_map(|(_, column)| self.sheet.columns.get(*column));
            names.into_iter().any(|name| name.starts_with(start))
        };
        [has("θS"), has("θM")]
    }
}
