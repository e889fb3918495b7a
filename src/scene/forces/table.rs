//! Forces from CSV, as they are read.

use crate::diagnostic::{Code, Diagnostic, Result};
use crate::forces::{Group, KEYS, NAMES, Owner, Take};
use crate::model::Scene;
use crate::model::{ElementForces, ForceSign, StateForces};
use crate::states;
use crate::states::{CsvRow, Source};
use indexmap::IndexMap;
use std::collections::HashSet;
use std::ops::ControlFlow;

/// What tells the rows of one state: its number, or else its time.
type Key = (Option<u64>, Option<u64>);

fn key(row: &CsvRow<'_>) -> Result<(Key, Option<u64>, Option<f64>)> {
    let (state, time) = (row.integer("state")?, row.number("time")?);
    Ok(((state, time.filter(|_| state.is_none()).map(f64::to_bits)), state, time))
}

/// Hands on the forces of a table, state by state. Where rows of one state are apart, as in a table by elements, it is read as a whole first.
pub(super) fn groups(source: Source<'_>, scene: &Scene, sign: ForceSign, take: &mut Take<'_>) -> Result<()> {
    let known = || KEYS.into_iter().chain(NAMES.iter().map(|(name, _)| *name));
    let find = |field: &str| known().find(|known| known.eq_ignore_ascii_case(field));
    let columns = known().collect::<Vec<_>>();
    let holds_all = !source.is_repeatable() || {
        let (mut seen, mut last, mut is_apart) = (HashSet::new(), None, false);
        // What is wrong is told by the second reading.
        let read = states::csv_rows(source, &columns, find, "element", |row, _| {
            let Ok((key, ..)) = key(row) else { return Ok(ControlFlow::Continue(())) };
            is_apart |= last != Some(key) && !seen.insert(key);
            last = Some(key);
            Ok(ControlFlow::Continue(()))
        });
        is_apart && read.is_ok()
    };
    let mut held: IndexMap<Key, Group> = IndexMap::new();
    let mut stopped = false;
    states::csv_rows(source, &columns, find, "element", |row, is_clean| {
        let (key, state, time) = key(row)?;
        if !holds_all
            && !held.contains_key(&key)
            && let Some((_, whole)) = held.pop()
            && is_clean
            && take(whole).is_break()
        {
            stopped = true;
            return Ok(ControlFlow::Break(()));
        }
        let new = || Group { state, time, forces: StateForces::default(), span: row.span() };
        let group = held.entry(key).or_insert_with(new);
        if group.time != time {
            group.time = time;
            let message = "rows of one state have different times";
            return Err(Diagnostic::error(Code::StatesOrder, row.span(), message, "this row")
                .help("give all rows of a state the same time, or another state number"));
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
        let mut forces = ElementForces { sign, span: row.span(), ..ElementForces::default() };
        let mut is_given = false;
        for (name, _) in &NAMES {
            if let Some(value) = row.number(name)? {
                is_given = true;
                forces.set(name, Some(value)).map_err(|fault| fault.at(row.place(name), "this column"))?;
            }
        }
        let owner = Owner::named(element, scene);
        let owner = owner.and_then(|owner| group.forces.check(&owner).map(|()| owner));
        let owner = owner.map_err(|fault| fault.at(row.place("element"), "this element"))?;
        // A row of gaps gives nothing.
        if is_given {
            group.forces.insert(owner, forces);
        }
        Ok(ControlFlow::Continue(()))
    })?;
    if stopped {
        return Ok(());
    }
    for whole in held.into_values() {
        if take(whole).is_break() {
            break;
        }
    }
    Ok(())
}
