//! Numbers in a list: of multi-point constraints, frictions, slopes of behaviour.

use crate::judge::table::ResultTable;
use crate::mutants::diagnosis::matching::{AtState, Cell, Datum, Hypothesis, Matching, Words, ranges};
use crate::mutants::diagnosis::{Cause, Diagnosis};
use std::collections::BTreeSet;

/// Why numbers are wrong; `None` where none is. Tried are the mistakes that the table knows, and those that every number can suffer.
pub fn diagnose_table(table: &ResultTable) -> Option<Diagnosis> {
    let width = table.width();
    let place = |i: usize| (i / width, i % width);
    let data = table.entries.iter().enumerate().map(|(i, entry)| {
        let (want, tolerance) = (entry.want.to_f64(), entry.tolerance());
        (place(i), Datum { got: Some(entry.got), want, tolerance, class: entry.class })
    });
    let placed = |changes: &[(usize, f64)]| changes.iter().map(|(i, x)| (i / width, i % width, *x)).collect();
    let known = table
        .mistakes
        .iter()
        .map(|change| Hypothesis::many(Cause::of(change.mistake), placed(&change.changes)));
    let mut hypotheses: Vec<Hypothesis> = known.collect();
    for row in 0..table.rows.len() {
        let changes = table.entries.iter().enumerate().skip(row * width).take(width);
        let changes = changes.map(|(i, entry)| (i % width, -entry.want.to_f64()));
        hypotheses.push(Hypothesis::of_row(Cause::Reversed, row, changes));
    }
    let conventions = table.conventions.iter();
    hypotheses.extend(conventions.map(|(cause, changes)| Hypothesis::many(*cause, placed(changes))));
    let words = TableWords { table, width };
    let mut state = AtState { data: data.collect(), hypotheses };
    state.add_mistakes_of_entries();
    Matching { states: vec![state], regions: Vec::new(), has_offsets: false, words: &words }.diagnosis()
}

struct TableWords<'a> {
    table: &'a ResultTable,
    width: usize,
}

impl Words for TableWords<'_> {
    fn entry(&self, (row, column): Cell) -> String {
        let entry = self.table.entries.get(row * self.width + column);
        entry.map(|entry| entry.name.clone()).unwrap_or_default()
    }

    fn region(&self, places: &BTreeSet<Cell>) -> String {
        let mut rows: Vec<(String, String)> = Vec::new();
        for (n, row) in self.table.rows.iter().enumerate() {
            let columns: BTreeSet<usize> =
                places.iter().filter(|(row, _)| *row == n).map(|(_, column)| *column).collect();
            if columns.is_empty() {
                continue;
            }
            let name = |j: usize| self.table.columns.get(j).cloned().unwrap_or_default();
            let of_columns = if columns.len() == self.width || self.table.columns.is_empty() {
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

    fn rotations(&self, places: &BTreeSet<Cell>) -> [bool; 2] {
        let has = |start: &str| {
            let names = places.iter().filter_map(|(_, column)| self.table.columns.get(*column));
            names.into_iter().any(|name| name.starts_with(start))
        };
        [has("θS"), has("θM")]
    }
}
