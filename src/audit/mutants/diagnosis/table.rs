//! Numbers in a list: of multi-point constraints, frictions, slopes of behaviour.

use crate::case::failing::MpcCase;
use crate::case::quantity::Quantity;
use crate::judge::table::{Entry, ResultTable};
use crate::mutants::diagnosis::cells::Cell;
use crate::mutants::diagnosis::component::is_derivative;
use crate::mutants::diagnosis::matching::{AtState, Hypothesis, Matching, Words, equation, ranges};
use crate::mutants::diagnosis::{Cause, Diagnosis, Explained};
use crate::mutants::mutant::Changes;
use std::collections::BTreeSet;

/// Why numbers are wrong; `None` where none is. Tried are the mistakes that the table knows, and those that every number can suffer.
pub fn diagnose_table(table: &ResultTable) -> Option<Diagnosis> {
    diagnose_tables(&[table], false)
}

/// The same of one quantity at several states, all with the same rows and columns: a cause is one that holds at nearly all of them. Whether it
/// passes `elsewhere`: at many other states.
pub fn diagnose_tables(tables: &[&ResultTable], elsewhere: bool) -> Option<Diagnosis> {
    let table = *tables.first()?;
    let words = TableWords { table, width: table.width(), elsewhere };
    let is_finite = |table: &&&ResultTable| table.entries.iter().all(|entry| entry.got.is_finite());
    let is_wrong =
        |entry: &Entry| entry.sides.is_none() && (entry.got - entry.want.to_f64()).abs() > entry.tolerance();
    let is_smooth = tables.iter().any(|table| table.entries.iter().any(is_wrong));
    let states = tables.iter().filter(is_finite).map(|table| at_state(table, is_smooth)).collect();
    // One constant may put off a row, or all of it, wherever several states tell that it is one.
    let rows = (0..table.rows.len()).map(|row| (0..words.width).map(|j| (row, j)).collect());
    let mut regions: Vec<Vec<Cell>> = if tables.len() > 1 { rows.collect() } else { Vec::new() };
    if regions.len() > 1 {
        regions.push(regions.concat());
    }
    let has_offsets = tables.len() > 1 && table.quantity == Quantity::Value;
    let has_bounds = tables.len() > 1 && !is_derivative(table.quantity);
    let matching = Matching { states, regions, has_offsets, has_bounds, seen: None, words: &words };
    let found = matching.diagnosis();
    let lost: Vec<_> = tables.iter().filter(|table| !is_finite(table)).collect();
    if lost.is_empty() {
        return found;
    }
    let mut found = found.unwrap_or_default();
    let of_table = |table: &&&ResultTable| {
        let lost = table.entries.iter().enumerate().filter(|(_, entry)| !entry.got.is_finite());
        lost.map(|(i, _)| (i / words.width, i % words.width)).collect::<Vec<Cell>>()
    };
    let region: BTreeSet<Cell> = lost.iter().flat_map(of_table).collect();
    let place = words.region(&region);
    let (cause, at) = (Cause::NotANumber, Matching::at_states(lost.len(), tables.len()));
    let sentence = equation(&place, cause.relation(), cause.meaning(), &at);
    found.causes.push(Explained { cause, code: cause.code(), sentence, also: Vec::new() });
    Some(found)
}

/// The numbers of a table, with what may explain them; `is_smooth` without those on kinks, where another convention has other sides, too.
fn at_state(table: &ResultTable, is_smooth: bool) -> AtState {
    let width = table.width();
    let place = |i: usize| (i / width, i % width);
    let is_told = |i: usize| table.entries.get(i).is_some_and(|entry| !is_smooth || entry.sides.is_none());
    let told = |changes: &Changes| {
        let told = changes.iter().filter(|(row, i, _)| is_told(row * width + i));
        Changes::Many(told.copied().collect())
    };
    let given = table.entries.iter().enumerate().filter(|(i, _)| is_told(*i)).map(|(i, entry)| {
        let (want, tolerance) = (entry.target(entry.got).to_f64(), entry.tolerance());
        (place(i), (Some(entry.got), want, tolerance, entry.class))
    });
    let known = table.mistakes.iter();
    let known = known.map(|made| Hypothesis::new(Cause::of(made.mistake), told(&made.changes)));
    let mut hypotheses: Vec<Hypothesis> = known.collect();
    for row in 0..table.rows.len() {
        let changes = table.entries.iter().enumerate().skip(row * width).take(width);
        let changes =
            changes.filter(|(i, _)| is_told(*i)).map(|(i, entry)| (i % width, -entry.want.to_f64()));
        hypotheses.push(Hypothesis::of_row(Cause::Reversed, row, changes));
    }
    if table.quantity == Quantity::FrictionGradient {
        hypotheses.extend(columns_swapped(table, &is_told));
    }
    let others = table.conventions.iter();
    hypotheses.extend(others.map(|of| Hypothesis { changes: told(&of.changes), ..of.clone() }));
    AtState::new(given, hypotheses, 0)
}

/// Every pair of columns exchanged in a row, and each copied into the place of every other.
fn columns_swapped(table: &ResultTable, is_told: &dyn Fn(usize) -> bool) -> Vec<Hypothesis> {
    let width = table.width();
    let mut found = Vec::new();
    for row in 0..table.rows.len() {
        for i in 0..width {
            for j in (i + 1..width).filter(|j| is_told(row * width + i) && is_told(row * width + *j)) {
                let [x, y] = [table.want(row, i), table.want(row, j)];
                if x != y {
                    let name = |j: usize| table.columns.get(j).map_or("", String::as_str);
                    let swapped = Hypothesis::of_row(Cause::ColumnsSwapped, row, [(i, y), (j, x)]);
                    let words = format!("what is expected of {} and {} exchanged", name(i), name(j));
                    found.push(swapped.related(words));
                    for (at, x, [from, to]) in [(i, y, [j, i]), (j, x, [i, j])] {
                        let copied = Hypothesis::of_row(Cause::ColumnsSwapped, row, [(at, x)]);
                        let words =
                            format!("what is expected of {} in the place of {}", name(from), name(to));
                        found.push(copied.related(words));
                    }
                }
            }
        }
    }
    found
}

struct TableWords<'a> {
    table: &'a ResultTable,
    width: usize,
    elsewhere: bool,
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
                // A column that there is not has no name.
                let named: Vec<String> =
                    ranges(&columns, &name).into_iter().filter(|name| !name.is_empty()).collect();
                format!("/∂{}", named.join(" and ∂"))
            };
            rows.push((row.clone(), of_columns));
        }
        if matches!(self.table.quantity, Quantity::ElementForces | Quantity::ElementStiffness) {
            // Fourteen rows, most of them alike.
            let every =
                rows.len() == self.table.rows.len() && rows.iter().all(|(_, columns)| columns.is_empty());
            if every {
                return format!("every entry of the {}", self.table.quantity.name());
            }
            let mut alike: Vec<(BTreeSet<usize>, String)> = Vec::new();
            for (row, columns) in rows {
                let place = self.table.rows.iter().position(|known| *known == row).unwrap_or_default();
                match alike.iter_mut().find(|(_, known)| *known == columns) {
                    Some((places, _)) => drop(places.insert(place)),
                    None => alike.push((BTreeSet::from([place]), columns)),
                }
            }
            let name = |row: usize| self.table.rows.get(row).cloned().unwrap_or_default();
            let named =
                alike.into_iter().map(|(places, columns)| ranges(&places, &name).join(", ") + &columns);
            return named.collect::<Vec<_>>().join("; ");
        }
        let named: Vec<String> = rows.into_iter().map(|(row, columns)| row + &columns).collect();
        named.join(", ")
    }

    fn triads(&self) -> [&'static str; 2] {
        ["C_S", "C_M"]
    }

    fn meaning(&self, cause: Cause) -> &'static str {
        let is_of_constraint = MpcCase::QUANTITIES.contains(&self.table.quantity);
        match cause {
            Cause::Reversed if self.elsewhere => {
                "right at other states, so that a magnitude is left out, or taken"
            }
            Cause::AxesOfA if is_of_constraint => "axes of S for those that are meant",
            Cause::AxesOfB if is_of_constraint => "axes of M for those that are meant",
            Cause::InitialAxes if is_of_constraint => "axes or an arm that do not turn with M",
            Cause::InitialTurned if is_of_constraint => "the initial separation turned with M",
            _ => cause.meaning(),
        }
    }

    fn rotations(&self, places: &BTreeSet<Cell>) -> [bool; 2] {
        let has = |start: &str| {
            let names = places.iter().filter_map(|(_, column)| self.table.columns.get(*column));
            names.into_iter().any(|name| name.starts_with(start))
        };
        [has("θS"), has("θM")]
    }
}
