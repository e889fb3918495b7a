//! Forces from CSV, as they are read.

use crate::diagnostic::{Code, Diagnostic, Result};
use crate::forces::{ElementForces, ForceSign, Group, KEYS, NAMES, Owner, StateForces, Take};
use crate::model::Scene;
use crate::span::Span;
use crate::states;
use crate::states::{CsvRow, Source};
use std::collections::HashSet;

/// Hands on the forces of a table, state by state.
pub(super) fn groups(source: Source<'_>, scene: &Scene, sign: ForceSign, take: &mut Take<'_>) -> Result<()> {
    let mut current: Option<Group> = None;
    let mut stopped = false;
    let mut seen: HashSet<(Option<u64>, Option<u64>)> = HashSet::new();
    let known = || KEYS.into_iter().chain(NAMES.iter().map(|(name, _)| *name));
    let find = |field: &str| known().find(|known| known.eq_ignore_ascii_case(field));
    let read = states::csv_rows(source, &known().collect::<Vec<_>>(), find, "element", |row: &CsvRow<'_>| {
        let (state, time) = (row.integer("state")?, row.number("time")?);
        let is_same = current.as_ref().is_some_and(|last| last.state == state && last.time == time);
        if !is_same {
            let key = (state, time.filter(|_| state.is_none()).map(f64::to_bits));
            if !seen.insert(key) {
                let message = "rows of one state are apart, or have different times";
                return Err(Diagnostic::error(Code::StatesOrder, row.span(), message, "this row")
                    .help("put the rows of a state together, all with its number and time"));
            }
            let next = Group { state, time, forces: StateForces::default(), span: row.span() };
            if let Some(whole) = current.replace(next)
                && take(whole).is_break()
            {
                stopped = true;
                return Err(Diagnostic::error(Code::StatesMalformed, Span::default(), "stopped", ""));
            }
        }
        let Some(element) = row.field("element") else {
            return Err(Diagnostic::error(
                Code::StatesMalformedNumber,
                row.span(),
                "a row without an element",
                "this row",
            )
            .help("give the element number in the column `element`"));
        };
        let Some(group) = &mut current else { return Ok(()) };
        let owner = Owner::named(element, scene);
        let owner = owner.and_then(|owner| group.forces.check(&owner).map(|()| owner));
        let owner = owner.map_err(|fault| fault.at(row.place("element"), "this element"))?;
        let mut forces = ElementForces { sign, span: row.span(), ..ElementForces::default() };
        for (name, _) in &NAMES {
            if let Some(value) = row.number(name)? {
                forces.set(name, value).map_err(|fault| fault.at(row.place(name), "this column"))?;
            }
        }
        group.forces.insert(owner, forces);
        Ok(())
    });
    if stopped {
        return Ok(());
    }
    read?;
    if let Some(last) = current {
        _ = take(last);
    }
    Ok(())
}
