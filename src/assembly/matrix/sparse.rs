//! A sparse matrix by rows, its columns in groups.

use std::ops::Range;

/// The columns that the motion of a rigid body has.
pub(crate) const RIGID: usize = 6;

/// By what the columns of one body follow those of another.
pub(crate) type Square = [[f64; RIGID]; RIGID];

/// Of a row: no source. Of a cell: no other one, for it is fixed.
pub(crate) const NONE: u32 = u32::MAX;

/// What of the nodes, rows and columns of a matrix the rigid map is made of.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    /// By row: the number of the connector or constraint that enforces it; [`NONE`] where it is held or driven, or beyond the end.
    pub(crate) sources: Vec<u32>,
    /// By column: the number of the degree of freedom.
    pub(crate) numbers: Vec<u8>,
    /// By group: where its node is initially, and by how much it is displaced.
    pub(crate) places: Vec<[[f64; 3]; 2]>,
    /// By group: the axes of its columns, as rows.
    pub(crate) axes: Vec<Option<[[f64; 3]; 3]>>,
    /// The unit of lengths.
    pub(crate) length: f64,
}

impl Layout {
    /// By what the column of one group follows that of another in rigid motion: all six of both.
    pub(crate) fn rigid(&self, of: u32, from: u32) -> Square {
        let [to, of_from] = [of, from].map(|group| self.places[group as usize]);
        let [x, y, z] =
            std::array::from_fn(|i| ((to[0][i] - of_from[0][i]) + (to[1][i] - of_from[1][i])) / self.length);
        let turned = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]];
        let mut map = [[0.0; RIGID]; RIGID];
        let [after, before] = [of, from].map(|group| self.axes[group as usize]);
        if after.is_none() && before.is_none() {
            for i in 0..3 {
                (map[i][i], map[3 + i][3 + i]) = (1.0, 1.0);
                map[i][3..].copy_from_slice(&turned[i]);
            }
            return map;
        }
        const GLOBAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [after, before] = [after, before].map(|axes| axes.unwrap_or(GLOBAL));
        for i in 0..3 {
            for j in 0..3 {
                let along = |k: usize, l: usize| after[i][k] * before[j][l];
                let straight: f64 = (0..3).map(|k| along(k, k)).sum();
                (map[i][j], map[3 + i][3 + j]) = (straight, straight);
                map[i][3 + j] = (0..3)
                    .flat_map(|k| (0..3).map(move |l| (k, l)))
                    .map(|(k, l)| along(k, l) * turned[k][l])
                    .sum();
            }
        }
        map
    }

    /// The place of a column among the six of a rigid motion.
    pub(crate) fn place(&self, column: u32) -> Option<usize> {
        let number = usize::from(*self.numbers.get(column as usize)?);
        (1..=RIGID).contains(&number).then(|| number - 1)
    }

    /// Where a group is, initially.
    pub(crate) fn initial(&self, group: u32) -> [f64; 3] {
        self.places[group as usize][0]
    }
}

/// A sparse matrix, its columns in groups.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sparse {
    /// The first column of each group, and the number of columns at the end: columns of a group are neighbours.
    pub(crate) groups: Vec<u32>,
    /// Where the entries of each row begin, and the number of entries at the end.
    pub(crate) offsets: Vec<usize>,
    /// The column of each entry.
    pub(crate) columns: Vec<u32>,
    /// The entries.
    pub(crate) values: Vec<f64>,
    /// By how much the entries of each row that are not zero are uncertain besides by rounding, in rounding units; nothing where left out.
    pub(crate) rough: Vec<f32>,
    /// By how much the digits of what is given leave the entries of each row that are not zero open, relative to the largest of the row; nothing where
    /// left out.
    pub(crate) open: Vec<f32>,
    /// What the rigid map between groups is made of, where it is known.
    pub(crate) layout: Option<Layout>,
}

impl Sparse {
    pub(crate) fn rows(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    pub(crate) fn width(&self) -> usize {
        self.groups.last().copied().unwrap_or_default() as usize
    }

    pub(crate) fn range(&self, row: usize) -> Range<usize> {
        self.offsets[row]..self.offsets[row + 1]
    }

    /// The same of some rows alone, in their order.
    pub(crate) fn with_rows(&self, rows: &[u32]) -> Self {
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

    /// By how much an entry may be another one, for what is given has so many digits.
    pub(crate) fn openness(&self, row: usize) -> f64 {
        let Some(open) = self.open.get(row).copied().filter(|open| *open > 0.0) else { return 0.0 };
        let largest = self.values[self.range(row)].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        f64::from(open) * largest
    }

    /// The columns of a group.
    pub(crate) fn columns_of(&self, group: usize) -> Range<usize> {
        self.groups[group] as usize..self.groups[group + 1] as usize
    }

    /// Bounds of the norms of the changes of the matrix that rounding can make, in rounding units. All entries change by as much as
    /// the largest of their rows. Those that are not zero change by as much as their rows are uncertain besides. The norm is at
    /// most √(‖E‖₁ ‖E‖∞).
    pub(crate) fn changes(&self) -> [f64; 2] {
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
    pub(crate) fn uncertainty(&self, row: usize) -> [f32; 2] {
        let largest = self.values[self.range(row)].iter().fold(0.0_f64, |most, x| most.max(x.abs())) as f32;
        [largest, largest + self.rough.get(row).copied().unwrap_or_default()]
    }
}

/// The largest magnitude; what is no number stays one.
pub(crate) fn largest<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    let larger = |most: f64, x: &f64| if most.is_nan() || x.is_nan() { f64::NAN } else { most.max(x.abs()) };
    numbers.into_iter().fold(0.0, larger)
}
