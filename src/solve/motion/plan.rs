//! Elimination whose pivots are known: what becomes of which entry is found once, for all matrices with entries in the same places.

use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// The pivots of matrices with entries in some places.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Plan {
    /// Row and column of each entry, sorted.
    entries: Vec<(usize, usize)>,
    /// In which order columns are eliminated, and the row that each is eliminated with.
    columns: Vec<usize>,
    rows: Vec<usize>,
    #[serde(skip)]
    tape: OnceLock<Option<Arc<Tape>>>,
}

impl Plan {
    /// One for other entries besides.
    pub(crate) fn with(
        &self,
        entries: impl Iterator<Item = (usize, usize)>,
        pivots: &[(usize, usize)],
    ) -> Self {
        let mut all: Vec<(usize, usize)> = self.entries.iter().copied().chain(entries).collect();
        all.sort_unstable();
        all.dedup();
        let (columns, rows) = pivots.iter().copied().unzip();
        Self { entries: all, columns, rows, tape: OnceLock::new() }
    }

    /// Whether it has a place for all of these.
    pub(crate) fn takes(&self, mut entries: impl Iterator<Item = (usize, usize)>) -> bool {
        entries.all(|entry| self.entries.binary_search(&entry).is_ok())
    }

    /// What is done to the entries. `None` where an entry that a pivot needs is not there.
    pub(crate) fn tape(&self) -> Option<Arc<Tape>> {
        self.tape.get_or_init(|| Tape::new(self).map(Arc::new)).clone()
    }
}

/// What elimination does, entry by entry: each has a slot, also those that elimination makes.
#[derive(Debug)]
pub(crate) struct Tape {
    /// Where the slots of each row begin.
    begins: Vec<usize>,
    /// The column of each slot. In a row they are in the order of elimination.
    pub(crate) columns: Vec<usize>,
    pub(crate) steps: Vec<Step>,
    pub(crate) lines: Vec<Line>,
    /// Of each line, the slots that the slots of the pivot after its first are taken from.
    pub(crate) targets: Vec<usize>,
}

/// A pivot.
#[derive(Debug)]
pub(crate) struct Step {
    pub(crate) row: usize,
    /// Its slots, from the pivot itself on.
    pub(crate) slots: Range<usize>,
    pub(crate) lines: Range<usize>,
}

/// A row that a multiple of a pivot is taken from.
#[derive(Debug)]
pub(crate) struct Line {
    pub(crate) row: usize,
    /// What becomes zero.
    pub(crate) slot: usize,
    pub(crate) targets: Range<usize>,
}

impl Tape {
    fn new(plan: &Plan) -> Option<Self> {
        let n = plan.columns.len();
        let mut place = vec![0; n];
        for (k, column) in plan.columns.iter().enumerate() {
            *place.get_mut(*column)? = k;
        }
        // The places of each row, in the order of elimination.
        let mut rows: Vec<Vec<usize>> = vec![Vec::new(); n];
        for (row, column) in &plan.entries {
            rows.get_mut(*row)?.push(*place.get(*column)?);
        }
        rows.iter_mut().for_each(|row| row.sort_unstable());
        let mut is_left = vec![true; n];
        let mut others = Vec::with_capacity(n);
        for (k, pivot) in plan.rows.iter().enumerate() {
            let from = rows.get(*pivot)?.binary_search(&k).ok()?;
            let adds = rows[*pivot][from..].to_vec();
            is_left[*pivot] = false;
            let these: Vec<usize> =
                (0..n).filter(|row| is_left[*row] && rows[*row].binary_search(&k).is_ok()).collect();
            for row in &these {
                rows[*row].extend(&adds);
                rows[*row].sort_unstable();
                rows[*row].dedup();
            }
            others.push(these);
        }
        let mut begins = vec![0];
        rows.iter().for_each(|row| begins.push(begins[begins.len() - 1] + row.len()));
        let slot = |row: usize, place: usize| Some(begins[row] + rows[row].binary_search(&place).ok()?);
        let columns = rows.iter().flatten().map(|k| plan.columns[*k]).collect();
        let (mut steps, mut lines, mut targets) = (Vec::with_capacity(n), Vec::new(), Vec::new());
        for (k, (pivot, others)) in plan.rows.iter().zip(others).enumerate() {
            let slots = slot(*pivot, k)?..begins[pivot + 1];
            let first = lines.len();
            for row in others {
                let start = targets.len();
                let after = &rows[*pivot][slots.start + 1 - begins[*pivot]..];
                for place in after {
                    targets.push(slot(row, *place)?);
                }
                lines.push(Line { row, slot: slot(row, k)?, targets: start..targets.len() });
            }
            steps.push(Step { row: *pivot, slots, lines: first..lines.len() });
        }
        Some(Self { begins, columns, steps, lines, targets })
    }

    /// Of how many unknowns.
    pub(crate) fn size(&self) -> usize {
        self.steps.len()
    }

    /// The slots of a row.
    pub(crate) fn row(&self, row: usize) -> Range<usize> {
        self.begins[row]..self.begins[row + 1]
    }

    /// The slot of an entry.
    pub(crate) fn slot(&self, row: usize, column: usize) -> Option<usize> {
        let slots = self.row(row);
        self.columns[slots.clone()].iter().position(|of| *of == column).map(|at| slots.start + at)
    }
}
