//! A sparse matrix by rows, its columns in groups.

use super::contract::Layout;
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
    /// By how much the digits of what is given leave the entries of each row that are not zero open, relative to the largest of the row; nothing where
    /// left out.
    pub(super) open: Vec<f32>,
    /// What the rigid map between groups is made of, where it is known.
    pub(super) layout: Option<Layout>,
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

    /// The same of some rows alone, in their order.
    pub(super) fn with_rows(&self, rows: &[u32]) -> Self {
        let mut some = Self { groups: self.groups.clone(), offsets: vec![0], ..Self::default() };
        for row in rows {
            let row = *row as usize;
            some.columns.extend_from_slice(&self.columns[self.range(row)]);
            some.values.extend_from_slice(&self.values[self.range(row)]);
            some.offsets.push(some.columns.len());
            some.rough.push(self.rough.get(row).copied().unwrap_or_default());
        }
        some
    }

    /// Leaves out entries that are zero.
    pub(super) fn drop_zeros(&mut self) {
        let (mut kept, mut begin) = (0, 0);
        for row in 0..self.rows() {
            let end = self.offsets[row + 1];
            for at in begin..end {
                if self.values[at] != 0.0 {
                    (self.columns[kept], self.values[kept]) = (self.columns[at], self.values[at]);
                    kept += 1;
                }
            }
            begin = end;
            self.offsets[row + 1] = kept;
        }
        self.columns.truncate(kept);
        self.values.truncate(kept);
    }

    /// By how much an entry may be another one, for what is given has so many digits.
    pub(super) fn openness(&self, row: usize) -> f64 {
        let Some(open) = self.open.get(row).copied().filter(|open| *open > 0.0) else { return 0.0 };
        let largest = self.values[self.range(row)].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        f64::from(open) * largest
    }

    /// The columns of a group.
    pub(super) fn columns_of(&self, group: usize) -> Range<usize> {
        self.groups[group] as usize..self.groups[group + 1] as usize
    }

    /// Bounds of the norms of the changes of the matrix that rounding can make, in rounding units: of all entries by as much as the largest of
    /// their rows, and of those that are not zero by as much as their rows are uncertain besides. The norm is at most √(‖E‖₁ ‖E‖∞).
    pub(super) fn changes(&self) -> [f64; 2] {
        let mut columns = vec![[0.0_f64; 2]; self.width()];
        let mut most = [0.0_f64; 2];
        for row in 0..self.rows() {
            let [zero, other] = self.uncertainty(row).map(f64::from);
            let mut sums = [0.0; 2];
            for at in self.range(row) {
                let rough = if self.values[at] == 0.0 { 0.0 } else { other - zero };
                for (k, change) in [zero, rough].into_iter().enumerate() {
                    sums[k] += change;
                    columns[self.columns[at] as usize][k] += change;
                }
            }
            most = [0, 1].map(|k| most[k].max(sums[k]));
        }
        [0, 1].map(|k| (most[k] * columns.iter().map(|sums| sums[k]).fold(0.0, f64::max)).sqrt())
    }

    /// How uncertain the entries of a row are, in rounding units: those that are zero, and those that are not.
    pub(super) fn uncertainty(&self, row: usize) -> [f32; 2] {
        let largest = self.values[self.range(row)].iter().fold(0.0_f64, |most, x| most.max(x.abs())) as f32;
        [largest, largest + self.rough.get(row).copied().unwrap_or_default()]
    }
}
