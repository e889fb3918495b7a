//! Numbers by where they stand. Rows are few and short, so that each place has its own room.

/// Where a number stands: its row (a component, an equation, a part) and its place in that row.
pub(super) type Cell = (usize, usize);

/// What stands in cells, in the order of rows and places.
pub(super) struct Cells<T> {
    rows: Vec<Vec<Option<T>>>,
    len: usize,
}

impl<T> Default for Cells<T> {
    fn default() -> Self {
        Self { rows: Vec::new(), len: 0 }
    }
}

impl<T> Cells<T> {
    pub(super) fn get(&self, (k, i): Cell) -> Option<&T> {
        self.rows.get(k)?.get(i)?.as_ref()
    }

    pub(super) fn contains(&self, cell: Cell) -> bool {
        self.get(cell).is_some()
    }

    pub(super) fn insert(&mut self, (k, i): Cell, x: T) {
        if self.rows.len() <= k {
            self.rows.resize_with(k + 1, Vec::new);
        }
        let row = &mut self.rows[k];
        if row.len() <= i {
            row.resize_with(i + 1, || None);
        }
        self.len += usize::from(row[i].replace(x).is_none());
    }

    pub(super) const fn len(&self) -> usize {
        self.len
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (Cell, &T)> {
        self.rows
            .iter()
            .enumerate()
            .flat_map(|(k, row)| row.iter().enumerate().filter_map(move |(i, x)| Some(((k, i), x.as_ref()?))))
    }

    pub(super) fn cells(&self) -> impl Iterator<Item = Cell> {
        self.iter().map(|(cell, _)| cell)
    }

    /// Leaves out what stands in the cells of others.
    pub(super) fn without<U>(&mut self, others: &Cells<U>) {
        for (k, i) in others.cells() {
            let left = self.rows.get_mut(k).and_then(|row| row.get_mut(i)?.take());
            self.len -= usize::from(left.is_some());
        }
    }
}

impl<T> Extend<(Cell, T)> for Cells<T> {
    fn extend<I: IntoIterator<Item = (Cell, T)>>(&mut self, others: I) {
        others.into_iter().for_each(|(cell, x)| self.insert(cell, x));
    }
}

impl<T> FromIterator<(Cell, T)> for Cells<T> {
    fn from_iter<I: IntoIterator<Item = (Cell, T)>>(all: I) -> Self {
        let mut cells = Self::default();
        cells.extend(all);
        cells
    }
}
