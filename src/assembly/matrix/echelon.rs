//! Which rows depend on those before them?
//!
//! Rows are put in one after the other. What is left of a row where the pivots so far have taken their columns from it becomes a pivot itself, or is
//! nothing. Where it is nothing, the row depends on those that were put in before. So what is named does not depend on the order of elimination, but
//! on that of the rows alone. The columns are taken in an order of least degree, which keeps rows sparse.
//!
//! What a pivot has in common with a row is taken from it by a rotation (George and Heath, 1980), so that rounding does not grow from pivot to pivot.
//! An entry does not know how uncertain it is, as it does in [`crate::matrix::eliminate`]: rows are named where as many are found as are known to depend.

use crate::matrix::budget::{Budget, PRODUCTS};
use crate::matrix::sparse::Sparse;

/// What is zero, of rows whose largest entries are about one; and what rounding leaves.
const ZERO: f64 = 1e-10;
const LEFT: f64 = 1e-14;

/// The entries that may be looked at, of both rows each time: some ten seconds.
const MOST: usize = 5_000_000_000;
/// So many entries are looked at in the time of an operation.
const ENTRIES: usize = PRODUCTS / 2;

type Entries = Vec<(u32, f64)>;

/// Rows put in so far.
struct Echelon<'a> {
    matrix: &'a Sparse,
    /// The place of each column in the order of elimination.
    place: Vec<u32>,
    /// By column: whether it is left out.
    is_out: Vec<bool>,
    /// By place: the row of which it is the first entry.
    pivots: Vec<Entries>,
    /// The row that is being put in, by place, and where it is not zero.
    row: Vec<f64>,
    marks: Marks,
    spare: [Entries; 2],
    /// The entries that may still be looked at.
    left: usize,
}

impl<'a> Echelon<'a> {
    /// None yet, of a matrix whose groups of columns are taken in an order; so many entries may be looked at.
    fn new(matrix: &'a Sparse, order: &[u32], most: usize) -> Self {
        let mut place = vec![0; matrix.width()];
        let columns = order.iter().flat_map(|group| matrix.columns_of(*group as usize));
        for (at, column) in (0..).zip(columns) {
            place[column] = at;
        }
        let pivots = vec![Entries::new(); matrix.width()];
        let (is_out, row) = (vec![false; matrix.width()], vec![0.0; matrix.width()]);
        let marks = Marks::new(matrix.width());
        Self { matrix, place, is_out, pivots, row, marks, spare: Default::default(), left: most }
    }

    /// The same without these columns.
    fn without(mut self, columns: &[u32]) -> Self {
        columns.iter().for_each(|column| self.is_out[*column as usize] = true);
        self
    }

    /// Puts in a row: whether it does not depend on those before; `None` where that takes too long, and nothing else is to be put in.
    fn put(&mut self, row: u32) -> Option<bool> {
        let range = self.matrix.range(row as usize);
        for (column, value) in self.matrix.columns[range.clone()].iter().zip(&self.matrix.values[range]) {
            if !self.is_out[*column as usize] && *value != 0.0 {
                let at = self.place[*column as usize];
                self.row[at as usize] = *value;
                self.marks.set(at);
            }
        }
        let mut from = 0;
        while let Some(at) = self.marks.next(from) {
            let value = self.row[at as usize];
            if value.abs() <= ZERO {
                self.row[at as usize] = 0.0;
                self.marks.clear(at);
                from = at + 1;
                continue;
            }
            let Some((_, of_first)) = self.pivots[at as usize].first().copied() else {
                self.gather(at);
                let entries = self.spare[0].clone();
                self.spare[0].iter().for_each(|(at, _)| self.row[*at as usize] = 0.0);
                self.pivots[at as usize] = entries;
                return Some(true);
            };
            self.take(self.pivots[at as usize].len())?;
            let size = value.hypot(of_first);
            let [c, s] = [of_first / size, value / size];
            self.gather(at);
            self.take(self.spare[0].len())?;
            for (at, value) in &self.spare[0] {
                self.row[*at as usize] = c * value;
                self.marks.set(*at);
            }
            self.add(at, -s);
            let pivot = &mut self.pivots[at as usize];
            let [row, turned] = &mut self.spare;
            combined(row, pivot, [s, c], turned);
            turned.insert(0, (at, size));
            std::mem::swap(pivot, turned);
            self.row[at as usize] = 0.0;
            self.marks.clear(at);
            from = at + 1;
        }
        Some(false)
    }

    /// Counts entries that are looked at; `None` where there are too many.
    fn take(&mut self, entries: usize) -> Option<()> {
        let left = self.left.checked_sub(entries);
        self.left = left.unwrap_or_default();
        left.map(|_| ())
    }

    /// Adds a multiple of a pivot to the row.
    fn add(&mut self, at: u32, times: f64) {
        for (at, value) in &self.pivots[at as usize] {
            self.row[*at as usize] += times * value;
            self.marks.set(*at);
        }
    }

    /// Takes down what of the row is not zero from a place on, and takes its marks away.
    fn gather(&mut self, from: u32) {
        let [entries, _] = &mut self.spare;
        entries.clear();
        let mut at = from;
        while let Some(next) = self.marks.next(at) {
            let value = self.row[next as usize];
            if value.abs() > LEFT {
                entries.push((next, value));
            } else {
                self.row[next as usize] = 0.0;
            }
            self.marks.clear(next);
            at = next + 1;
        }
    }
}

/// Which places of a row are marked, each by a bit, and which words of these have any.
#[derive(Debug, Default)]
struct Marks {
    words: Vec<u64>,
    any: Vec<u64>,
}

impl Marks {
    fn new(width: usize) -> Self {
        let words = width.div_ceil(64);
        Self { words: vec![0; words], any: vec![0; words.div_ceil(64)] }
    }

    #[inline]
    fn set(&mut self, at: u32) {
        let word = at as usize / 64;
        self.words[word] |= 1 << (at % 64);
        self.any[word / 64] |= 1 << (word % 64);
    }

    fn clear(&mut self, at: u32) {
        let word = at as usize / 64;
        self.words[word] &= !(1 << (at % 64));
        if self.words[word] == 0 {
            self.any[word / 64] &= !(1 << (word % 64));
        }
    }

    /// The first that is marked, from one on.
    fn next(&self, from: u32) -> Option<u32> {
        let word = from as usize / 64;
        let rest = self.words.get(word)? & (u64::MAX << (from % 64));
        if rest != 0 {
            return Some(word as u32 * 64 + rest.trailing_zeros());
        }
        let next = word + 1;
        let mut of = next / 64;
        let mut any = self.any.get(of)? & (u64::MAX << (next % 64));
        while any == 0 {
            of += 1;
            any = *self.any.get(of)?;
        }
        let word = of * 64 + any.trailing_zeros() as usize;
        Some(word as u32 * 64 + self.words[word].trailing_zeros())
    }
}

/// A sum of multiples of two rows but for their first entries, which are in the same place.
fn combined(x: &[(u32, f64)], y: &[(u32, f64)], [of_x, of_y]: [f64; 2], sum: &mut Entries) {
    sum.clear();
    let (mut x, mut y) = (x.iter().skip(1).peekable(), y.iter().skip(1).peekable());
    loop {
        let places = [&x.peek(), &y.peek()].map(|next| next.map_or(u32::MAX, |(at, _)| *at));
        let at = places[0].min(places[1]);
        if at == u32::MAX {
            return;
        }
        let mut value = 0.0;
        if places[0] == at {
            value += of_x * x.next().map_or(0.0, |(_, value)| *value);
        }
        if places[1] == at {
            value += of_y * y.next().map_or(0.0, |(_, value)| *value);
        }
        if value.abs() > LEFT {
            sum.push((at, value));
        }
    }
}

/// The rows that depend on those before them; `None` where they are not as many as are known to, or where that takes more than may be spent, or [`MOST`]
/// entries.
///
/// Columns that are known to be free are made of the others: they are left out.
pub(crate) fn dependent(
    matrix: &Sparse,
    (order, free): (&[u32], &[u32]),
    count: usize,
    budget: &Budget,
) -> Option<Vec<u32>> {
    let most = MOST.min((budget.left() as usize).saturating_mul(ENTRIES));
    let mut echelon = Echelon::new(matrix, order, most).without(free);
    let mut look = || {
        let mut found = Vec::new();
        for row in 0..matrix.rows() as u32 {
            if !echelon.put(row)? {
                found.push(row);
            }
            if found.len() > count {
                return None;
            }
        }
        (found.len() == count).then_some(found)
    };
    let found = look();
    budget.spend((most - echelon.left).div_ceil(ENTRIES));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::reference;
    use pintle_kinematics::draw::Draw;

    /// Random rows over a few of the columns, and sums of such that share them.
    fn random(draw: &mut Draw) -> Sparse {
        let width = 6 + draw.below(30);
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for _ in 0..2 * width {
            let mut row = vec![0.0; width];
            if rows.len() > 3 && draw.below(3) == 0 {
                for _ in 0..2 {
                    let (of, times) = (draw.below(rows.len()), draw.between(0.5, 2.0));
                    row.iter_mut().zip(&rows[of]).for_each(|(sum, x)| *sum += times * x);
                }
            } else {
                let first = draw.below(width - 3);
                row[first..first + 3].iter_mut().for_each(|x| *x = draw.between(-1.0, 1.0));
            }
            rows.push(row);
        }
        let mut matrix =
            Sparse { groups: (0..=width as u32).collect(), offsets: vec![0], ..Sparse::default() };
        for row in rows {
            for (column, value) in (0..).zip(row).filter(|(_, value)| *value != 0.0) {
                matrix.columns.push(column);
                matrix.values.push(value);
            }
            matrix.offsets.push(matrix.columns.len());
        }
        matrix
    }

    /// Whatever the order of columns those rows are named that dense matrices name; and where others are known to depend, or where that takes more than
    /// may be spent, none.
    #[test]
    fn names_are_those_of_dense_matrices() {
        let mut draw = Draw::new("echelon");
        let unlimited = || Budget::new(u64::MAX);
        for case in 0..100 {
            let matrix = random(&mut draw);
            let rows: Vec<u32> = (0..matrix.rows() as u32).collect();
            let expected = reference(&matrix, &rows);
            let count = expected.len();
            assert!(count > 0, "case {case}");
            let forwards: Vec<u32> = (0..matrix.width() as u32).collect();
            let backwards: Vec<u32> = forwards.iter().rev().copied().collect();
            for order in [&forwards, &backwards] {
                let found = dependent(&matrix, (order, &[]), count, &unlimited());
                assert_eq!(found.as_ref(), Some(&expected), "case {case}");
            }
            assert_eq!(dependent(&matrix, (&forwards, &[]), count - 1, &unlimited()), None);
            assert_eq!(dependent(&matrix, (&forwards, &[]), count + 1, &unlimited()), None);
            assert_eq!(dependent(&matrix, (&forwards, &[]), count, &Budget::new(2)), None);
        }
    }
}
