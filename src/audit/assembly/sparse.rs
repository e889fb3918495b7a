//! A sparse matrix by rows, its columns in groups.

use std::ops::Range;

/// A sparse matrix, its columns in groups.
#[derive(Clone, Debug, Default)]
pub(super) struct Sparse {
    /// The first column of each group, and the number of columns at the end: columns of a group are neighbours.
    pub(super) groups: Vec<u32>,
    /// Where the entries of each row begin, and the number of entries at the end.
    pub(super) offsets: Vec<usize>,
    /// The column of each entry.
    pub(super) columns: Vec<u32>,
    /// The entries.
    pub(super) values: Vec<f64>,
    /// By how much the entries of each row that are not zero are uncertain besides by rounding, in rounding units; nothing where left out.
    pub(super) rough: Vec<f32>,
}

impl Sparse {
    pub(super) fn rows(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    pub(super) fn width(&self) -> usize {
        self.groups.last().copied().unwrap_or_default() as usize
    }

    pub(super) fn range(&self, row: usize) -> Range<usize> {
        self.offsets[row]..self.offsets[row + 1]
    }

    /// The columns of a group.
    pub(super) fn columns_of(&self, group: usize) -> Range<usize> {
        self.groups[group] as usize..self.groups[group + 1] as usize
    }

    /// How uncertain the entries of a row are, in rounding units: those that are zero, and those that are not.
    pub(super) fn uncertainty(&self, row: usize) -> [f32; 2] {
        let largest = self.values[self.range(row)].iter().fold(0.0_f64, |most, x| most.max(x.abs())) as f32;
        [largest, largest + self.rough.get(row).copied().unwrap_or_default()]
    }
}
