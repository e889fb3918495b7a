//! What moves as one body?
//!
//! Two nodes whose relative motion a connector fixes altogether (BEAM, WELD …) are one rigid body, and so are all that are joined so, one after the
//! other. Eliminated node by node does not know: of a lattice of BEAMs it fills, as that of any lattice. So what each node of
//! a body does is put in beforehand, by that of one of them. With r the arm from that to another, the other's displacement is u + θ × r and its
//! rotation θ. What is left are rows of two bodies, whatever the number of nodes. Of a connector within a body nothing is left: its rows depend on
//! others.
//!
//! *In part.* Columns fall apart where whatever would join them is zero to the last bit, as in and out of the plane of a planar
//! linkage. Each set of columns is looked at by itself: out of the plane hinges make one body of all bars.
//!
//! *Which rows?* Rows that make a body are taken to hold first. Those of connectors that fix all six components begin, in the order of the
//! deck. Those of others follow that fix all that moves in one set of columns. Each of them joins two bodies; what joins one with itself is
//! redundant.
//!
//! *Certain.* Let J_a, J_b be such rows of the two nodes, and T the rigid map. They count only where `J_a + J_b T` is zero to what
//! rounding leaves of what is computed ([`COMPUTED`]), and the least pivot of J_b is far from zero. So only its numbers decide about a
//! connection type, and others (TIE between nodes that are apart) are left as they are. T is that of the places of the nodes, and
//! not of a product along the way from one to the other. Its rounding is that of one arm, however long the way. The node that
//! stands for a body is the one nearest to the middle of its nodes. Rotations are counted in units of one over the longest arm, so
//! that no entry is made of larger ones.

use crate::matrix::eliminate::{CERTAIN, Eliminated, GAP, Pivot, REMAINS, ROUNDINGS, Task, eliminate};
use crate::matrix::noise::{COMPUTED, ROUNDED};
use crate::matrix::order::Union;
use crate::matrix::sparse::{Layout, NONE, RIGID, Sparse, Square};
use pintle_kinematics::scalar::U;

/// An entry that is smaller than the largest of its row by so many rounding units does not join columns.
const JOINS: f64 = 2.0;
/// The least pivot of rows that make a body, relative to the largest entry.
const INDEPENDENT: f64 = 1e-3;
/// The columns of a group that belong together.
#[derive(Clone, Copy, Debug)]
struct Cell {
    group: u32,
    columns: [u32; RIGID + 1],
    count: u8,
}

impl Cell {
    fn columns(&self) -> &[u32] {
        &self.columns[..usize::from(self.count)]
    }
}

/// Rows that make one body of two, or fix one.
#[derive(Clone, Copy, Debug)]
struct Weld {
    rows: [u32; RIGID],
    cells: [u32; 2],
    /// Whether the source fixes all six components.
    is_whole: bool,
    /// The relative change that makes them dependent.
    ratio: f64,
}

/// A matrix whose nodes are put together to bodies.
#[derive(Clone, Debug)]
pub(crate) struct Contracted {
    /// What is left.
    pub(crate) rest: Sparse,
    /// By row of the rest: the row it was.
    pub(crate) names: Vec<u32>,
    /// Rows of which nothing is left, ascending.
    pub(crate) dependent: Vec<u32>,
    /// The rows that make the bodies, in their order.
    pub(crate) made_by: Vec<u32>,
    welds: Vec<Weld>,
    cells: Vec<Cell>,
    cell_of: Vec<u32>,
    /// By cell: the one that stands for its body; [`NONE`] where it is fixed.
    root: Vec<u32>,
    /// By column of the rest: that of the matrix, and by what it is multiplied.
    columns: Vec<u32>,
    scale: Vec<f64>,
    /// By column of the matrix: that of the rest.
    column_of: Vec<u32>,
    size: [usize; 2],
    gap: [f64; 2],
    weakest: Option<u32>,
    widest: Option<u32>,
    remains: bool,
}

/// The least pivot of a matrix of so many rows and columns, by its largest entries, and the solution for a right-hand side.
fn solved(matrix: &Square, count: usize, mut right: [f64; RIGID]) -> (f64, [f64; RIGID]) {
    let mut left = *matrix;
    let mut least = f64::INFINITY;
    let mut order: [usize; RIGID] = std::array::from_fn(|k| k);
    for k in 0..count {
        let places = || (k..count).flat_map(|i| (k..count).map(move |j| (i, j)));
        let size = |(i, j): &(usize, usize)| left[*i][*j].abs();
        let Some((row, column)) = places().max_by(|x, y| size(x).total_cmp(&size(y))) else { break };
        left.swap(k, row);
        right.swap(k, row);
        left.iter_mut().for_each(|row| row.swap(k, column));
        order.swap(k, column);
        let pivot = left[k][k];
        least = least.min(pivot.abs());
        if pivot == 0.0 {
            return (0.0, right);
        }
        for i in k + 1..count {
            let factor = left[i][k] / pivot;
            for j in k..count {
                left[i][j] -= factor * left[k][j];
            }
            right[i] -= factor * right[k];
        }
    }
    let mut solution = [0.0; RIGID];
    for k in (0..count).rev() {
        let sum: f64 = (k + 1..count).map(|j| left[k][j] * solution[order[j]]).sum();
        solution[order[k]] = (right[k] - sum) / left[k][k];
    }
    (least, solution)
}

/// What is built of a matrix on the way to what is left of it.
struct Building<'a> {
    matrix: &'a Sparse,
    layout: Option<&'a Layout>,
    uncertainty: f64,
    cells: Vec<Cell>,
    cell_of: Vec<u32>,
    /// By column: its place in its cell.
    within: Vec<u8>,
}

impl<'a> Building<'a> {
    fn new(matrix: &'a Sparse, uncertainty: f64) -> Self {
        let width = matrix.width();
        let mut sets = Union::new(width);
        for row in 0..matrix.rows() {
            let mut first = None;
            for column in joining(matrix, row) {
                match first {
                    Some(first) => sets.join(first, column),
                    None => first = Some(column),
                }
            }
        }
        let (mut cells, mut cell_of, mut within) = (Vec::<Cell>::new(), vec![0; width], vec![0; width]);
        let mut of_set: Vec<(u32, usize)> = Vec::new();
        for group in 0..matrix.groups.len().saturating_sub(1) {
            of_set.clear();
            for column in matrix.columns_of(group) {
                let set = sets.find(column as u32);
                let cell = match of_set
                    .iter()
                    .find(|(of, cell)| *of == set && cells[*cell].columns().len() <= RIGID)
                {
                    Some((_, cell)) => *cell,
                    None => {
                        cells.push(Cell { group: group as u32, columns: [0; RIGID + 1], count: 0 });
                        of_set.push((set, cells.len() - 1));
                        cells.len() - 1
                    }
                };
                cell_of[column] = cell as u32;
                within[column] = cells[cell].count;
                let of: &mut Cell = &mut cells[cell];
                of.columns[usize::from(of.count)] = column as u32;
                of.count += 1;
            }
        }
        Self { matrix, layout: matrix.layout.as_ref(), uncertainty, cells, cell_of, within }
    }

    /// By what the columns of a cell follow those of another, and what of other columns they follow at most; `None` where they do not.
    fn map(&self, of: u32, from: u32) -> Option<(Square, f64)> {
        let layout = self.layout?;
        let [to, from] = [of, from].map(|cell| &self.cells[cell as usize]);
        let full = layout.rigid(to.group, from.group);
        let (mut map, mut most) = ([[0.0; RIGID]; RIGID], 0.0_f64);
        for (i, column) in to.columns().iter().enumerate() {
            let mut others = full[layout.place(*column)?];
            for (j, column) in from.columns().iter().enumerate() {
                map[i][j] = std::mem::take(&mut others[layout.place(*column)?]);
            }
            most = others.iter().fold(most, |most, x| most.max(x.abs()));
        }
        Some((map, most))
    }

    /// The rows of one source, of one set of columns, where they make one body of two cells, or fix one.
    fn weld(&self, rows: &[u32], is_whole: bool) -> Option<Weld> {
        let count = rows.len();
        if count > RIGID {
            return None;
        }
        let mut cells: Vec<u32> = Vec::with_capacity(2);
        for column in rows.iter().flat_map(|row| joining(self.matrix, *row as usize)) {
            let cell = self.cell_of[column as usize];
            if !cells.contains(&cell) {
                cells.push(cell);
            }
        }
        if cells.len() > 2 || cells.iter().any(|cell| self.cells[*cell as usize].columns().len() != count) {
            return None;
        }
        let (mut of, mut largest, mut rough) = ([[[0.0; RIGID]; RIGID]; 2], 0.0_f64, 0.0_f64);
        for (i, row) in rows.iter().enumerate() {
            for at in self.matrix.range(*row as usize) {
                let (column, value) = (self.matrix.columns[at] as usize, self.matrix.values[at]);
                if let Some(place) = cells.iter().position(|cell| *cell == self.cell_of[column]) {
                    of[place][i][usize::from(self.within[column])] = value;
                }
            }
            let [zero, other] = self.matrix.uncertainty(*row as usize).map(f64::from);
            (largest, rough) = (largest.max(zero), rough.max(other));
        }
        let mut least = f64::INFINITY;
        for place in 0..cells.len() {
            least = least.min(solved(&of[place], count, [0.0; RIGID]).0);
        }
        let ratio = least / rough;
        let decided = (GAP * ROUNDINGS * U).max(3.0 * (ROUNDINGS * U + self.uncertainty));
        if !(least >= INDEPENDENT * largest && ratio > decided && ratio.is_finite()) {
            return None;
        }
        if let [a, b] = cells.as_slice() {
            let (map, most) = self.map(*b, *a)?;
            if most > COMPUTED * U {
                return None;
            }
            for i in 0..count {
                for j in 0..count {
                    let products = || (0..count).map(|k| of[1][i][k] * map[k][j]);
                    let sum = of[0][i][j] + products().sum::<f64>();
                    let size = largest + products().map(f64::abs).sum::<f64>();
                    let arm = (0..count).map(|k| map[k][j].abs()).sum::<f64>().max(1.0);
                    let allowed = (U * COMPUTED + self.uncertainty) * size + U * ROUNDED * rough * arm;
                    if sum.is_nan() || sum.abs() > allowed {
                        return None;
                    }
                }
            }
        }
        let mut found = [NONE; RIGID];
        found[..count].copy_from_slice(rows);
        let cells = [cells.first().copied()?, cells.get(1).copied().unwrap_or(NONE)];
        Some(Weld { rows: found, cells, is_whole, ratio })
    }

    /// The rows that make one body of two, those of sources that fix all first.
    fn welds(&self) -> Vec<Weld> {
        let Some(layout) = self.layout else { return Vec::new() };
        let of = |row: usize| layout.sources.get(row).copied().unwrap_or(NONE);
        let (mut welds, mut row) = (Vec::new(), 0);
        while row < self.matrix.rows() {
            let (source, begin) = (of(row), row);
            while row < self.matrix.rows() && of(row) == source {
                row += 1;
            }
            if source == NONE {
                continue;
            }
            // By set of columns: the rows of one belong to the cells that they share.
            let mut sets: Vec<(u32, Vec<u32>)> = Vec::new();
            for one in begin..row {
                let Some(column) = joining(self.matrix, one).next() else { continue };
                let cells =
                    |row: u32| joining(self.matrix, row as usize).map(|column| self.cell_of[column as usize]);
                let own: Vec<u32> = cells(one as u32).collect();
                match sets
                    .iter_mut()
                    .find(|(_, rows)| rows.iter().any(|row| cells(*row).any(|cell| own.contains(&cell))))
                {
                    Some((_, rows)) => rows.push(one as u32),
                    None => sets.push((column, vec![one as u32])),
                }
            }
            let is_whole = row - begin == RIGID;
            welds.extend(sets.iter().filter_map(|(_, rows)| self.weld(rows, is_whole)));
        }
        welds.sort_by_key(|weld| !weld.is_whole);
        welds
    }
}

/// Whether an entry is larger than that, or no number.
fn exceeds(value: f64, least: f64) -> bool {
    value.is_nan() || value.abs() > least
}

/// The columns that a row joins.
fn joining(matrix: &Sparse, row: usize) -> impl Iterator<Item = u32> + use<'_> {
    let least = JOINS * U * f64::from(matrix.uncertainty(row)[0]);
    let range = matrix.range(row);
    let entries = matrix.columns[range.clone()].iter().zip(&matrix.values[range]);
    entries.filter(move |(_, value)| exceeds(**value, least)).map(|(column, _)| *column)
}

impl Contracted {
    /// Puts the nodes of a matrix together, whose entries are uncertain by that besides rounding.
    pub(crate) fn of(matrix: &Sparse, uncertainty: f64) -> Self {
        let building = Building::new(matrix, uncertainty);
        let ground = building.cells.len() as u32;
        let mut sets = Union::new(building.cells.len() + 1);
        let mut welds = building.welds();
        welds.retain(|weld| {
            let [a, b] = weld.cells.map(|cell| cell.min(ground));
            let is_new = sets.find(a) != sets.find(b);
            sets.join(a, b);
            is_new
        });
        let fixed = sets.find(ground);
        let root = roots(&building, &mut sets, fixed);
        let mut gap = [0.0, f64::INFINITY];
        let mut weakest = None;
        for weld in welds.iter().filter(|weld| weld.ratio < f64::INFINITY) {
            if weld.ratio < gap[1] {
                (gap[1], weakest) = (weld.ratio, Some(weld.rows[0]));
            }
        }
        let made_by = welds.iter().flat_map(|weld| weld.rows).filter(|row| *row != NONE).collect();
        let Building { cells, cell_of, within, .. } = &building;
        let mut contracted = Self {
            rest: Sparse { offsets: vec![0], ..Sparse::default() },
            names: Vec::new(),
            dependent: Vec::new(),
            made_by,
            welds,
            cells: Vec::new(),
            cell_of: Vec::new(),
            root,
            columns: Vec::new(),
            scale: Vec::new(),
            column_of: vec![NONE; matrix.width()],
            size: [matrix.rows(), matrix.width()],
            gap,
            weakest,
            widest: None,
            remains: false,
        };
        contracted.columns_of_bodies(&building);
        let mut is_taken = vec![false; matrix.rows()];
        contracted.made_by.iter().for_each(|row| is_taken[*row as usize] = true);
        let mut scratch = Vec::new();
        for row in (0..matrix.rows()).filter(|row| !is_taken[*row]) {
            contracted.put(&building, row, within, &mut scratch);
        }
        contracted.cells.clone_from(cells);
        contracted.cell_of.clone_from(cell_of);
        contracted
    }

    /// Gives the cells that stand for bodies columns.
    fn columns_of_bodies(&mut self, building: &Building<'_>) {
        let mut longest = vec![1.0_f64; building.cells.len()];
        for (cell, root) in self.root.iter().enumerate() {
            if let (Some(layout), false) = (building.layout, *root == NONE || *root == cell as u32) {
                let [to, from] = [cell as u32, *root].map(|cell| building.cells[cell as usize].group);
                let map = layout.rigid(to, from);
                let most =
                    map[..3].iter().flat_map(|row| &row[3..]).fold(0.0_f64, |most, x| most.max(x.abs()));
                longest[*root as usize] = longest[*root as usize].max(most);
            }
        }
        for (at, cell) in building.cells.iter().enumerate().filter(|(at, _)| self.root[*at] == *at as u32) {
            self.rest.groups.push(self.columns.len() as u32);
            for column in cell.columns() {
                self.column_of[*column as usize] = self.columns.len() as u32;
                self.columns.push(*column);
                let is_rotation =
                    building.layout.is_some_and(|layout| matches!(layout.numbers[*column as usize], 4..=6));
                self.scale.push(if is_rotation { longest[at] } else { 1.0 });
            }
        }
        self.rest.groups.push(self.columns.len() as u32);
    }

    /// Puts a row in by what bodies do.
    fn put(&mut self, building: &Building<'_>, row: usize, within: &[u8], sums: &mut Vec<(u32, f64, f64)>) {
        let matrix = building.matrix;
        let [zero, other] = matrix.uncertainty(row).map(f64::from);
        let least = JOINS * U * zero;
        sums.clear();
        let mut cells: Vec<(u32, [f64; RIGID + 1], [f64; RIGID + 1])> = Vec::with_capacity(2);
        for at in matrix.range(row) {
            let (column, value) = (matrix.columns[at], matrix.values[at]);
            let cell = building.cell_of[column as usize];
            let place = usize::from(within[column as usize]);
            let known = match cells.iter().position(|(of, ..)| *of == cell) {
                Some(known) => known,
                None => {
                    cells.push((cell, [0.0; RIGID + 1], [0.0; RIGID + 1]));
                    cells.len() - 1
                }
            };
            let (_, values, uncertain) = &mut cells[known];
            values[place] = value;
            uncertain[place] = if value == 0.0 { zero } else { other };
        }
        // Cells that nothing joins with those of the row are not its own.
        let is_own = |values: &[f64; RIGID + 1]| values.iter().any(|value| exceeds(*value, least));
        for (cell, values, uncertain) in cells.iter().filter(|(_, values, _)| is_own(values)) {
            let root = self.root[*cell as usize];
            if root == NONE {
                continue;
            }
            let (of, body) = (&building.cells[*cell as usize], &building.cells[root as usize]);
            if root == *cell {
                for (k, column) in of.columns().iter().enumerate() {
                    let at = self.column_of[*column as usize];
                    let scale = self.scale[at as usize];
                    sums.push((at, values[k] / scale, uncertain[k] / scale));
                }
                continue;
            }
            let Some((map, _)) = building.map(*cell, root) else { continue };
            for (j, column) in body.columns().iter().enumerate() {
                let at = self.column_of[*column as usize];
                let scale = self.scale[at as usize];
                let (mut value, mut size) = (0.0, 0.0);
                for k in 0..of.columns().len() {
                    value += values[k] * map[k][j];
                    size += (uncertain[k] + 2.0 * values[k].abs()) * map[k][j].abs();
                }
                if size > 0.0 {
                    sums.push((at, value / scale, size / scale));
                }
            }
        }
        sums.sort_by_key(|(at, ..)| *at);
        sums.dedup_by(|next, before| {
            let is_same = next.0 == before.0;
            if is_same {
                before.1 += next.1;
                before.2 += next.2;
            }
            is_same
        });
        let zero = ROUNDINGS * U + building.uncertainty;
        let ratio = |(_, value, size): &(u32, f64, f64)| if *value == 0.0 { 0.0 } else { value.abs() / size };
        // What is no number is kept.
        if sums.iter().all(|sum| ratio(sum) <= zero) {
            let most = sums.iter().map(ratio).fold(0.0, f64::max);
            self.leave(row as u32, most, building.uncertainty);
            self.dependent.push(row as u32);
            return;
        }
        let (mut largest, mut rough) = (0.0_f64, 0.0_f64);
        for sum in sums.iter() {
            let (at, mut value, size) = *sum;
            if value != 0.0 && ratio(sum) <= REMAINS * U {
                value = 0.0;
                self.gap[0] = self.gap[0].max(ratio(sum));
            }
            (largest, rough) = (largest.max(value.abs()), rough.max(size));
            self.rest.columns.push(at);
            self.rest.values.push(value);
        }
        self.rest.offsets.push(self.rest.columns.len());
        self.rest.rough.push((rough - largest).max(0.0) as f32);
        self.names.push(row as u32);
    }

    /// Something is left out that counts as zero.
    fn leave(&mut self, row: u32, ratio: f64, uncertainty: f64) {
        if ratio > self.gap[0] {
            (self.gap[0], self.widest) = (ratio, Some(row));
        }
        self.remains |= ratio > CERTAIN * U + uncertainty;
    }

    /// The sets of groups that rows of the rest join.
    pub(crate) fn cliques(&self) -> Vec<Vec<u32>> {
        let mut of = vec![0; self.columns.len()];
        for group in 0..self.rest.groups.len().saturating_sub(1) {
            self.rest.columns_of(group).for_each(|column| of[column] = group as u32);
        }
        let mut cliques: Vec<Vec<u32>> = Vec::new();
        for row in 0..self.rest.rows() {
            let mut clique: Vec<u32> =
                self.rest.columns[self.rest.range(row)].iter().map(|column| of[*column as usize]).collect();
            clique.dedup();
            if cliques.last() != Some(&clique) {
                cliques.push(clique);
            }
        }
        cliques
    }

    /// The numbers of columns of the groups of the rest.
    pub(crate) fn widths(&self) -> Vec<usize> {
        self.rest.groups.windows(2).map(|ends| (ends[1] - ends[0]) as usize).collect()
    }
}

/// By cell, the one that stands for its body: the one whose node is nearest to the middle of all; [`NONE`] of those that are fixed.
fn roots(building: &Building<'_>, sets: &mut Union, fixed: u32) -> Vec<u32> {
    let count = building.cells.len();
    let set_of: Vec<u32> = (0..count as u32).map(|cell| sets.find(cell)).collect();
    let Some(layout) = building.layout else { return (0..count as u32).collect() };
    let mut middle = vec![([0.0; 3], 0_usize); count + 1];
    for (cell, set) in set_of.iter().enumerate() {
        let (sum, of) = &mut middle[*set as usize];
        let place = layout.initial(building.cells[cell].group);
        (0..3).for_each(|i| sum[i] += place[i]);
        *of += 1;
    }
    let mut nearest = vec![(f64::INFINITY, NONE); count + 1];
    for (cell, set) in set_of.iter().enumerate() {
        let (sum, of) = middle[*set as usize];
        let place = layout.initial(building.cells[cell].group);
        let distance: f64 = (0..3).map(|i| (place[i] - sum[i] / of as f64).powi(2)).sum();
        let least = &mut nearest[*set as usize];
        // What is no number is far.
        if distance < least.0 || least.1 == NONE {
            *least = (distance, cell as u32);
        }
    }
    set_of.iter().map(|set| if *set == fixed { NONE } else { nearest[*set as usize].1 }).collect()
}

/// Of right-hand sides by row: what is added to each column of the matrix, and the right-hand sides of the rest.
pub(crate) struct Shifted {
    of_columns: Vec<f64>,
    pub(crate) right: Vec<f64>,
}

impl Contracted {
    /// What right-hand sides make of bodies that are put together: each node moves as its body, and besides by what the rows that make the body say.
    pub(crate) fn shifted(&self, matrix: &Sparse, right: &[f64]) -> Shifted {
        let mut of_columns = vec![0.0; self.size[1]];
        let count = self.cells.len();
        let mut beside: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (at, weld) in self.welds.iter().enumerate() {
            weld.cells
                .iter()
                .filter(|cell| **cell != NONE)
                .for_each(|cell| beside[*cell as usize].push(at as u32));
        }
        let mut is_known = vec![false; count];
        let mut queue: Vec<u32> = Vec::new();
        for (cell, root) in self.root.iter().enumerate() {
            if *root == cell as u32 {
                is_known[cell] = true;
                queue.push(cell as u32);
            }
        }
        let solve = |weld: &Weld, cell: u32, is_known: &[bool], of_columns: &mut [f64]| {
            let columns = self.cells[cell as usize].columns();
            let (mut square, mut rest) = ([[0.0; RIGID]; RIGID], [0.0; RIGID]);
            for (i, row) in weld.rows.iter().filter(|row| **row != NONE).enumerate() {
                rest[i] = right[*row as usize];
                for at in matrix.range(*row as usize) {
                    let (column, value) = (matrix.columns[at], matrix.values[at]);
                    match columns.iter().position(|own| *own == column) {
                        Some(place) => square[i][place] = value,
                        None if is_known[self.cell_of[column as usize] as usize] => {
                            rest[i] -= value * of_columns[column as usize];
                        }
                        None => {}
                    }
                }
            }
            let (_, solution) = solved(&square, columns.len(), rest);
            columns.iter().zip(solution).for_each(|(column, value)| of_columns[*column as usize] = value);
        };
        for weld in self.welds.iter().filter(|weld| weld.cells[1] == NONE) {
            let [cell, _] = weld.cells;
            if !is_known[cell as usize] {
                solve(weld, cell, &is_known, &mut of_columns);
                is_known[cell as usize] = true;
                queue.push(cell);
            }
        }
        while let Some(cell) = queue.pop() {
            for weld in &beside[cell as usize] {
                let weld = &self.welds[*weld as usize];
                let Some(next) =
                    weld.cells.into_iter().find(|next| *next != NONE && !is_known[*next as usize])
                else {
                    continue;
                };
                solve(weld, next, &is_known, &mut of_columns);
                is_known[next as usize] = true;
                queue.push(next);
            }
        }
        let of_row = |row: &u32| {
            let row = *row as usize;
            let known =
                matrix.range(row).map(|at| matrix.values[at] * of_columns[matrix.columns[at] as usize]);
            right[row] - known.sum::<f64>()
        };
        let right = self.names.iter().map(of_row).collect();
        Shifted { of_columns, right }
    }

    /// The column of the rest that a column of the matrix became; `None` where that is none of the rest.
    pub(crate) fn column(&self, column: u32) -> Option<u32> {
        self.column_of.get(column as usize).copied().filter(|at| *at != NONE)
    }

    /// By cell that does not stand for its body: by what its columns follow those of the one that does.
    fn followers<'a>(
        &'a self,
        building: &'a Building<'_>,
    ) -> impl Iterator<Item = (&'a Cell, Option<(&'a Cell, Square)>)> {
        self.root.iter().enumerate().filter(|(cell, root)| **root != *cell as u32).map(move |(cell, root)| {
            let own = &self.cells[cell];
            if *root == NONE {
                return (own, None);
            }
            let map = building.map(cell as u32, *root).map(|(map, _)| map);
            (own, map.map(|map| (&self.cells[*root as usize], map)))
        })
    }

    fn building<'a>(&self, matrix: &'a Sparse) -> Building<'a> {
        Building {
            matrix,
            layout: matrix.layout.as_ref(),
            uncertainty: 0.0,
            cells: self.cells.clone(),
            cell_of: Vec::new(),
            within: Vec::new(),
        }
    }

    /// Eliminates what is left, and tells of the whole.
    pub(crate) fn eliminate(&self, matrix: &Sparse, order: &[u32], task: Task<'_>) -> Eliminated {
        let shifted = task.right.map(|right| self.shifted(matrix, right));
        let of_rest = Task { right: shifted.as_ref().map(|shifted| shifted.right.as_slice()), ..task };
        let mut outcome = eliminate(&self.rest, order, of_rest);
        outcome.size = self.size;
        if outcome.exhausted {
            return outcome;
        }
        let name = |row: &u32| self.names[*row as usize];
        let renamed = |rows: &[u32]| -> Vec<u32> { rows.iter().map(name).collect() };
        outcome.dependent = renamed(&outcome.dependent);
        outcome.dependent.extend(&self.dependent);
        outcome.dependent.sort_unstable();
        outcome.doubtful = renamed(&outcome.doubtful);
        outcome.weakest = outcome.weakest.as_ref().map(name);
        outcome.widest = outcome.widest.as_ref().map(name);
        if self.gap[1] < outcome.gap[1] {
            (outcome.gap[1], outcome.weakest) = (self.gap[1], self.weakest);
        }
        if self.gap[0] > outcome.gap[0] {
            (outcome.gap[0], outcome.widest) = (self.gap[0], self.widest.or(outcome.widest));
        }
        outcome.remains |= self.remains;
        outcome.rank += self.made_by.len();
        outcome.free = outcome.free.iter().map(|column| self.columns[*column as usize]).collect();
        outcome.free.sort_unstable();
        let of_welds = self.welds.iter().map(|weld| weld.rows.iter().filter(|row| **row != NONE).count());
        outcome.front = outcome.front.max(of_welds.map(|count| 2 * count).max().unwrap_or_default());
        if task.keep && (outcome.has_pivots() || outcome.fill == 0) {
            self.keep(matrix, &mut outcome, shifted.as_ref());
        }
        outcome
    }

    /// Adds to the pivots that were kept those by which the columns of a body follow that of the node that stands for it.
    fn keep(&self, matrix: &Sparse, outcome: &mut Eliminated, shifted: Option<&Shifted>) {
        for pivot in &mut outcome.pivots {
            pivot.entry *= self.scale[pivot.column as usize];
            pivot.column = self.columns[pivot.column as usize];
        }
        for (column, value) in &mut outcome.others {
            *value *= self.scale[*column as usize];
            *column = self.columns[*column as usize];
        }
        let building = self.building(matrix);
        let mut pivots = Vec::with_capacity(self.made_by.len() + outcome.pivots.len());
        for (own, body) in self.followers(&building) {
            for (i, column) in own.columns().iter().enumerate() {
                let begin = outcome.others.len();
                if let Some((root, map)) = &body {
                    let of = root.columns().iter().zip(map[i]).filter(|(_, value)| *value != 0.0);
                    outcome.others.extend(of.map(|(column, value)| (*column, -value)));
                }
                let right = shifted.map_or(0.0, |shifted| shifted.of_columns[*column as usize]);
                pivots.push(Pivot {
                    column: *column,
                    entry: 1.0,
                    others: begin..outcome.others.len(),
                    right,
                });
            }
        }
        outcome.fill += pivots.len();
        // What follows is solved last.
        pivots.append(&mut outcome.pivots);
        outcome.pivots = pivots;
    }
}
