//! The rank of a sparse matrix, which of its rows depend on others, which of its columns are free, and how certain that is.
//!
//! Columns come in groups, those of a node. Groups are eliminated one after the other. Of the rows that hold columns of a group, as
//! many as it has independent columns become pivots, by the largest entry. What is left of the others goes on to the next group
//! that they hold. A row never loses its name: it is always the row of the matrix that it was, less multiples of pivots. One of
//! which nothing is left depends on the pivots; a column without pivot is free. Where more rows are left than they have columns,
//! they are brought to echelon form at once, so that dependent rows are found where they arise and few go on. Rows are sparse
//! throughout: what is exactly zero is not kept.
//!
//! *What is zero?* Every entry knows how uncertain it is ([`crate::matrix::noise`]): |s|/n is the relative change that makes it zero, of
//! everything that it came of, in units of how uncertain each of that is. With [`ROUNDINGS`] = 1e4, an entry that is zero exceeds
//! 1e4 u with probability 6e-16. So s is zero where |s|/n ≤ 1e4 u + the relative uncertainty of the state. Up to a thousand times the former,
//! or three times both, there is no gap: the rank is undecided. It is so, too, where what counts as zero exceeds [`CERTAIN`] = 1e3 u.
//!
//! What rounding leaves is put to zero where it arises ([`REMAINS`]): it would come back multiplied by other remains, with an uncertainty of
//! second order, of which the first says nothing. By how much an entry was changed is added to its uncertainty.

use crate::facts::OPERATIONS;
use crate::matrix::budget::Budget;
use crate::matrix::noise;
use crate::matrix::noise::{NONE, Probes, Roundings, random};
use crate::matrix::sparse::Sparse;
use pintle_kinematics::draw::splitmix64;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

/// Rounding unit.
const U: f64 = pintle_kinematics::scalar::U;
/// Beyond so many rounding units, in units of the estimated condition, an entry is not zero by rounding.
pub(crate) const ROUNDINGS: f64 = 1e4;
/// Beyond so many, what counts as zero is not zero for certain: one that is exceeds that with probability 6e-12.
pub(crate) const CERTAIN: f64 = 1e3;
/// An entry that is not zero should exceed what counts as zero by this factor.
pub(crate) const GAP: f64 = 1e3;
/// An entry of so many rounding units, in units of the estimated condition, that a subtraction left, is what rounding leaves. One that is
/// zero exceeds it with probability 4e-7, and is then kept, which is no harm.
pub(crate) const REMAINS: f64 = 64.0;
/// What a subtraction leaves of numbers larger by this factor is looked at.
const CANCELS: f64 = 1e3;
/// A row of lower number is taken for a pivot where its entry is not smaller than the largest by more than this factor. Multipliers of more
/// than one grow with the number of nodes that are eliminated one after the other, and with them the condition of the pivots.
const PREFERRED: f64 = 0.99;

/// Where a pivot row is taken from rows of so many entries in all, threads share them.
const SHARED: usize = 30_000;
/// Pivot rows are kept that have no more entries, in all.
pub(crate) const KEPT: usize = 20_000_000;

/// A row that became a pivot.
#[derive(Clone, Debug)]
pub(crate) struct Pivot {
    pub(crate) column: u32,
    pub(crate) entry: f64,
    /// Where the other entries of the row are.
    pub(crate) others: Range<usize>,
    pub(crate) right: f64,
}

/// What elimination finds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Eliminated {
    /// The number of pivots.
    pub(crate) rank: usize,
    /// Rows that depend on others.
    pub(crate) dependent: Vec<u32>,
    /// Whether one of them had been taken from others that do not: these then stand for it, too, and the rows that are not named need not
    /// be independent ([`crate::matrix::naming`]).
    pub(crate) misnames: bool,
    /// Columns without pivot.
    pub(crate) free: Vec<u32>,
    /// Rows whose independence is not certain.
    pub(crate) doubtful: Vec<u32>,
    /// The row of the pivot of smallest |s|/n.
    pub(crate) weakest: Option<u32>,
    /// The row of the largest |s|/n that counts as zero.
    pub(crate) widest: Option<u32>,
    /// Whether something counts as zero that is not zero for certain.
    pub(crate) remains: bool,
    /// The largest |s|/n that counts as zero, and the smallest that does not.
    pub(crate) gap: [f64; 2],
    /// The number of entries of pivot rows.
    pub(crate) fill: usize,
    /// The largest number of columns of rows that held those of one group.
    pub(crate) front: usize,
    /// Whether an entry is no finite number, or so large that its uncertainty is none: nothing is then certain.
    pub(crate) overflows: bool,
    /// Whether the elimination was given up, for it would have cost too much: nothing is then known but `front`, at which that was.
    pub(crate) exhausted: bool,
    /// Entries that multiples of pivot rows were taken from.
    pub(crate) work: usize,
    /// The number of rows and columns.
    pub(crate) size: [usize; 2],
    pub(crate) pivots: Vec<Pivot>,
    pub(crate) others: Vec<(u32, f64)>,
}

/// What an elimination may cost; more, and it is given up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Most {
    /// Entries of rows that are on their way, at once: 32 bytes each, 1.3 GB.
    pub(crate) entries: usize,
    /// Entries that multiples of pivot rows are taken from, in all: some 8 ns each.
    pub(crate) work: usize,
}

impl Default for Most {
    fn default() -> Self {
        Self { entries: 40_000_000, work: OPERATIONS }
    }
}

/// What is asked of an elimination.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Task<'a> {
    /// The relative uncertainty of the entries, besides rounding.
    pub(crate) uncertainty: f64,
    /// Right-hand sides by row, where a solution is wanted.
    pub(crate) right: Option<&'a [f64]>,
    /// Whether pivot rows are kept, for solutions and null vectors.
    pub(crate) keep: bool,
    /// What it may cost.
    pub(crate) most: Most,
    /// What it, and what names rows after it, may spend besides; nothing is counted where there is none.
    pub(crate) budget: Option<&'a Budget>,
}

/// An entry of a row that is on its way.
#[derive(Clone, Copy, Debug)]
struct PartialEntry {
    /// The place of its column in the order of elimination.
    at: u32,
    value: f64,
    probes: Probes,
}

/// A row on its way: entries by place, ascending.
#[derive(Debug, Default)]
struct PartialRow {
    name: u32,
    right: f64,
    entries: Vec<PartialEntry>,
}

impl PartialRow {
    fn entry(&self, at: u32) -> Option<&PartialEntry> {
        let place = self.entries.binary_search_by_key(&at, |entry| entry.at).ok()?;
        self.entries.get(place)
    }
}

/// Rows that go on together, and the groups (by turn) that they may hold.
#[derive(Debug, Default)]
struct Block {
    groups: Vec<u32>,
    rows: Vec<PartialRow>,
}

struct Elimination<'a> {
    matrix: &'a Sparse,
    task: Task<'a>,
    zero: f64,
    decided: f64,
    /// The columns in the order of elimination, and the place of each in it.
    columns: Vec<u32>,
    place: Vec<u32>,
    outcome: Eliminated,
    /// The entries of rows that wait.
    waiting: usize,
    roundings: Roundings,
    spare: Vec<PartialEntry>,
    /// Rows that were taken from others before they were pivots.
    taken: HashSet<u32>,
}

/// The number of entries of rows.
fn entries(rows: &[PartialRow]) -> usize {
    rows.iter().map(|row| row.entries.len()).sum()
}

/// Eliminates the groups of a matrix in an order. Rows of lower number are preferred as pivots.
pub(crate) fn eliminate(matrix: &Sparse, order: &[u32], task: Task<'_>) -> Eliminated {
    let zero = ROUNDINGS * U + task.uncertainty;
    let columns: Vec<u32> = order
        .iter()
        .flat_map(|group| matrix.columns_of(*group as usize))
        .map(|column| column as u32)
        .collect();
    let (mut place, mut turn) = (vec![0_u32; columns.len()], Vec::with_capacity(columns.len()));
    for (at, column) in columns.iter().enumerate() {
        place[*column as usize] = at as u32;
    }
    for (at, group) in order.iter().enumerate() {
        turn.extend(matrix.columns_of(*group as usize).map(|_| at as u32));
    }
    let mut work = Elimination {
        matrix,
        task,
        zero,
        decided: (GAP * ROUNDINGS * U).max(3.0 * zero),
        place,
        outcome: Eliminated {
            gap: [0.0, f64::INFINITY],
            size: [matrix.rows(), matrix.width()],
            ..Eliminated::default()
        },
        waiting: 0,
        roundings: Roundings::new(),
        spare: Vec::new(),
        taken: HashSet::new(),
        columns,
    };
    // Rows of the matrix, and rows on their way, by the first group that they hold.
    let mut begin: Vec<Vec<u32>> = vec![Vec::new(); order.len()];
    for row in 0..matrix.rows() {
        let first = matrix.columns[matrix.range(row)].iter().map(|column| work.place[*column as usize]).min();
        match first {
            Some(first) => begin[turn[first as usize] as usize].push(row as u32),
            None => work.outcome.dependent.push(row as u32),
        }
    }
    let mut waiting: Vec<Block> = (0..order.len()).map(|_| Block::default()).collect();
    let mut first = 0;
    for (at, group) in order.iter().enumerate() {
        let mut block = std::mem::take(&mut waiting[at]);
        work.waiting -= entries(&block.rows);
        for row in std::mem::take(&mut begin[at]) {
            let row = work.row(row as usize);
            block.groups.extend(row.entries.iter().map(|entry| turn[entry.at as usize]));
            block.rows.push(row);
        }
        block.groups.push(at as u32);
        block.groups.sort_unstable();
        block.groups.dedup();
        let end = first + matrix.columns_of(*group as usize).len() as u32;
        let width = block.groups.iter().map(|at| matrix.columns_of(order[*at as usize] as usize).len()).sum();
        work.outcome.front = work.outcome.front.max(width);
        if work.waiting + block.rows.len() * width > task.most.entries {
            work.outcome.exhausted = true;
        }
        if work.outcome.exhausted {
            break;
        }
        let rest = work.group(block.rows, first..end, width);
        work.waiting += entries(&rest);
        if let Some(next) = block.groups.get(1).filter(|_| !rest.is_empty()) {
            let next = &mut waiting[*next as usize];
            next.rows.extend(rest);
            next.groups.extend_from_slice(&block.groups[1..]);
        }
        first = end;
    }
    work.outcome.dependent.sort_unstable();
    work.outcome.free.sort_unstable();
    work.outcome.doubtful.sort_unstable();
    work.outcome.doubtful.dedup();
    work.outcome
}

impl Elimination<'_> {
    /// A row of the matrix.
    fn row(&self, row: usize) -> PartialRow {
        let [zero, other] = self.matrix.uncertainty(row);
        let entry = |place: usize| PartialEntry {
            at: self.place[self.matrix.columns[place] as usize],
            value: self.matrix.values[place],
            probes: {
                let uncertain = if self.matrix.values[place] == 0.0 { zero } else { other };
                random(place as u64).map(|number| number * uncertain)
            },
        };
        let mut entries: Vec<PartialEntry> = self.matrix.range(row).map(entry).collect();
        entries.sort_unstable_by_key(|entry| entry.at);
        let right = self.task.right.map_or(0.0, |right| right[row]);
        PartialRow { name: row as u32, right, entries }
    }

    /// |s|/n of an entry; `None` where it is zero.
    fn certain(&mut self, entry: &PartialEntry) -> Option<f64> {
        if entry.value == 0.0 {
            return None;
        }
        let noise = noise::size(&entry.probes);
        if !(entry.value.is_finite() && noise.is_finite()) {
            self.outcome.overflows = true;
            return None;
        }
        let ratio = entry.value.abs() / noise;
        (ratio > self.zero).then_some(ratio)
    }

    /// Entries are left out, for they count as zero: by how much is noted.
    fn leave(&mut self, name: u32, entries: &[PartialEntry]) {
        for entry in entries.iter().filter(|entry| entry.value != 0.0) {
            let ratio = entry.value.abs() / noise::size(&entry.probes);
            if ratio > self.outcome.gap[0] {
                self.outcome.gap[0] = ratio;
                self.outcome.widest = Some(name);
            }
            self.outcome.remains |= ratio > CERTAIN * U + self.task.uncertainty;
        }
    }

    /// The row among those from `first` on, and the place among these, of the next pivot.
    fn choose(&mut self, rows: &[PartialRow], first: usize, among: &[u32]) -> Option<(usize, u32)> {
        self.spend(rows.len().saturating_sub(first) * among.len());
        let mut candidates: Vec<(usize, u32, f64)> = Vec::new();
        let mut largest = 0.0_f64;
        for (row, of) in rows.iter().enumerate().skip(first) {
            for at in among {
                let Some(entry) = of.entry(*at) else { continue };
                if self.certain(entry).is_some() {
                    let size = entry.value.abs();
                    largest = largest.max(size);
                    candidates.push((row, *at, size));
                }
            }
        }
        let preferred = candidates.into_iter().filter(|(_, _, size)| *size >= PREFERRED * largest);
        let best = preferred.min_by(|x, y| rows[x.0].name.cmp(&rows[y.0].name).then(y.2.total_cmp(&x.2)));
        let (row, at, ..) = best?;
        self.judge(&rows[row], at);
        Some((row, at))
    }

    /// Counts operations of what may be spent besides.
    fn spend(&mut self, operations: usize) {
        self.outcome.exhausted |= self.task.budget.is_some_and(|budget| !budget.spend(operations));
    }

    /// Notes a row of which nothing is left.
    fn depends(&mut self, name: u32) {
        self.outcome.misnames |= self.taken.contains(&name);
        self.outcome.dependent.push(name);
    }

    /// Notes how certain a pivot is.
    fn judge(&mut self, row: &PartialRow, at: u32) {
        let Some(ratio) = row.entry(at).and_then(|entry| self.certain(entry)) else { return };
        if ratio < self.outcome.gap[1] {
            self.outcome.gap[1] = ratio;
            self.outcome.weakest = Some(row.name);
        }
        if ratio < self.decided {
            self.outcome.doubtful.push(row.name);
        }
    }

    /// Takes multiples of a pivot row from rows of which nothing is left then at a place.
    fn reduce_all(&mut self, rows: &mut [PartialRow], pivot: &PartialRow, at: u32) {
        self.outcome.work += rows.len() * pivot.entries.len();
        self.outcome.exhausted |= self.outcome.work > self.task.most.work;
        if self.task.budget.is_some() {
            self.spend(rows.len() * pivot.entries.len() + entries(rows));
        }
        let roundings = &self.roundings;
        let largest = if rows.len() * pivot.entries.len() < SHARED {
            let spare = &mut self.spare;
            rows.iter_mut().map(|row| reduce(row, pivot, at, roundings, spare)).fold(0.0, f64::max)
        } else {
            let one = |spare: &mut Vec<PartialEntry>, row: &mut PartialRow| {
                reduce(row, pivot, at, roundings, spare)
            };
            rows.par_iter_mut().map_init(Vec::new, one).reduce(|| 0.0, f64::max)
        };
        self.outcome.gap[0] = self.outcome.gap[0].max(largest);
    }

    /// Finds the pivots of a group, whose places are given, and gives what is left of the other rows.
    fn group(&mut self, mut rows: Vec<PartialRow>, places: Range<u32>, width: usize) -> Vec<PartialRow> {
        let mut open: Vec<u32> = places.clone().collect();
        let mut done = 0;
        while let Some((row, at)) = self.choose(&rows, done, &open).filter(|_| !self.outcome.exhausted) {
            rows.swap(done, row);
            let (above, below) = rows.split_at_mut(done + 1);
            self.reduce_all(below, &above[done], at);
            open.retain(|other| *other != at);
            self.keep(&rows[done], at);
            done += 1;
        }
        self.outcome.rank += done;
        self.outcome.free.extend(open.iter().map(|at| self.columns[*at as usize]));
        rows.drain(..done);
        let mut rest = Vec::with_capacity(rows.len());
        for mut row in rows {
            let begin = row.entries.partition_point(|entry| entry.at < places.end);
            let of_group: Vec<PartialEntry> = row.entries.drain(..begin).collect();
            self.leave(row.name, &of_group);
            if row.entries.iter().all(|entry| self.certain(entry).is_none()) {
                self.leave(row.name, &row.entries);
                self.depends(row.name);
                continue;
            }
            if row.entries.capacity() > 2 * row.entries.len() {
                row.entries.shrink_to_fit();
            }
            rest.push(row);
        }
        if rest.len() > width - places.len() { self.compress(rest) } else { rest }
    }

    /// Keeps a pivot row.
    fn keep(&mut self, row: &PartialRow, at: u32) {
        self.outcome.fill += row.entries.iter().filter(|entry| entry.value != 0.0).count();
        if !self.task.keep {
            return;
        }
        let Some(entry) = row.entry(at).map(|entry| entry.value) else { return };
        if self.outcome.fill > KEPT {
            // Pivot rows that would take too much memory are not kept at all.
            self.task.keep = false;
            self.outcome.pivots = Vec::new();
            self.outcome.others = Vec::new();
            return;
        }
        let begin = self.outcome.others.len();
        let others = row.entries.iter().filter(|entry| entry.at != at && entry.value != 0.0);
        self.outcome.others.extend(others.map(|entry| (self.columns[entry.at as usize], entry.value)));
        let others = begin..self.outcome.others.len();
        let column = self.columns[at as usize];
        self.outcome.pivots.push(Pivot { column, entry, others, right: row.right });
    }

    /// Brings rows to echelon form and drops those of which nothing is left.
    fn compress(&mut self, rows: Vec<PartialRow>) -> Vec<PartialRow> {
        let mut independent = Vec::with_capacity(rows.len());
        // By the first place that was not yet looked at.
        let mut waiting: BTreeMap<u32, Vec<PartialRow>> = BTreeMap::new();
        for row in rows {
            if let Some(first) = row.entries.first() {
                waiting.entry(first.at).or_default().push(row);
            }
        }
        while let Some((at, mut rows)) = waiting.pop_first().filter(|_| !self.outcome.exhausted) {
            if let Some((pivot, _)) = self.choose(&rows, 0, &[at]) {
                let pivot = rows.swap_remove(pivot);
                if !rows.is_empty() {
                    self.taken.insert(pivot.name);
                }
                self.reduce_all(&mut rows, &pivot, at);
                independent.push(pivot);
            }
            for row in rows {
                let next = row.entries.partition_point(|entry| entry.at <= at);
                match row.entries.get(next) {
                    Some(next) => waiting.entry(next.at).or_default().push(row),
                    None => {
                        self.leave(row.name, &row.entries);
                        self.depends(row.name);
                    }
                }
            }
        }
        independent
    }
}

/// Takes the multiple of a pivot row from a row of which nothing is left then at a place, and gives the largest |s|/n of what was put to zero.
fn reduce(
    row: &mut PartialRow,
    pivot: &PartialRow,
    at: u32,
    roundings: &Roundings,
    spare: &mut Vec<PartialEntry>,
) -> f64 {
    let (Some(of_row), Some(of_pivot)) = (row.entry(at).copied(), pivot.entry(at).copied()) else {
        return 0.0;
    };
    let factor = of_row.value / of_pivot.value;
    let narrow = factor as f32;
    let slope: Probes =
        std::array::from_fn(|i| (of_row.probes[i] - narrow * of_pivot.probes[i]) / of_pivot.value as f32);
    // The rounding of the factor is that of the whole row; each product and difference has one of its own.
    let step = splitmix64(splitmix64(u64::from(row.name) << 32 | u64::from(pivot.name)) ^ u64::from(at));
    let taking = Taking { factor, narrow, slope, common: random(step), step, roundings };
    row.right -= factor * pivot.right;
    let mut largest = 0.0_f64;
    let is_same = row.entries.len() == pivot.entries.len()
        && row.entries.iter().zip(&pivot.entries).all(|(x, y)| x.at == y.at);
    if is_same {
        for (entry, by) in row.entries.iter_mut().zip(&pivot.entries) {
            taking.take(entry, by, &mut largest);
        }
        let is_left = |entry: &PartialEntry| entry.at != at && (entry.value != 0.0 || entry.probes != NONE);
        row.entries.retain(is_left);
        return largest;
    }
    spare.clear();
    let (mut left, mut right) = (row.entries.iter().peekable(), pivot.entries.iter().peekable());
    loop {
        let order = match (left.peek(), right.peek()) {
            (Some(x), Some(y)) => x.at.cmp(&y.at),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => break,
        };
        let old = if order == Ordering::Greater { None } else { left.next() };
        let taken = if order == Ordering::Less { None } else { right.next() };
        let Some(place) = old.or(taken).map(|entry| entry.at).filter(|place| *place != at) else {
            continue;
        };
        let mut entry = old.copied().unwrap_or(PartialEntry { at: place, value: 0.0, probes: NONE });
        if let Some(by) = taken {
            taking.take(&mut entry, by, &mut largest);
        }
        if entry.value != 0.0 || entry.probes != NONE {
            spare.push(entry);
        }
    }
    std::mem::swap(&mut row.entries, spare);
    largest
}

/// The multiple of a pivot row that is taken from a row.
struct Taking<'a> {
    factor: f64,
    narrow: f32,
    slope: Probes,
    common: Probes,
    step: u64,
    roundings: &'a Roundings,
}

impl Taking<'_> {
    #[inline(always)]
    fn take(&self, entry: &mut PartialEntry, by: &PartialEntry, largest: &mut f64) {
        let product = self.factor * by.value;
        entry.value -= product;
        let (value, size) = (by.value as f32, (product as f32).abs());
        noise::add(&mut entry.probes, -value, &self.slope);
        noise::add(&mut entry.probes, -self.narrow, &by.probes);
        if product == 0.0 {
            return;
        }
        let place = u64::from(entry.at);
        let left = entry.value.abs();
        noise::add(&mut entry.probes, size, &self.common);
        noise::add(
            &mut entry.probes,
            size + left as f32,
            self.roundings.of((self.step >> 16).wrapping_add(place)),
        );
        if left > 0.0 && left * CANCELS < product.abs() && left <= REMAINS * U * noise::size(&entry.probes) {
            *largest = largest.max(left / noise::size(&entry.probes));
            let dropped = self.roundings.of((self.step >> 40).wrapping_add(place));
            noise::add(&mut entry.probes, (left / U) as f32, dropped);
            entry.value = 0.0;
        }
    }
}

impl Eliminated {
    /// Whether what counts as zero and what does not are well apart.
    pub(crate) fn is_decided(&self) -> bool {
        self.doubtful.is_empty() && !self.remains && !self.overflows && !self.exhausted
    }

    /// The number of rows that depend on others: as many as are named, or more where nothing was eliminated.
    pub(crate) fn redundant(&self) -> usize {
        self.size[0] - self.rank
    }

    /// The number of free motions, as [`Eliminated::redundant`].
    pub(crate) fn mobility(&self) -> usize {
        self.size[1] - self.rank
    }

    /// Whether all rows that depend on others are named.
    pub(crate) fn names_all(&self) -> bool {
        self.dependent.len() == self.redundant()
    }

    /// Whether pivot rows were kept.
    pub(crate) fn has_pivots(&self) -> bool {
        !self.pivots.is_empty()
    }

    /// The solution of the pivot rows with the right-hand sides given, and these values of free columns; of the homogeneous ones
    /// where `homogeneous`. Needs pivots that were kept.
    pub(crate) fn solve(&self, width: usize, free: impl Fn(u32) -> f64, homogeneous: bool) -> Vec<f64> {
        let mut solution = vec![0.0; width];
        for column in &self.free {
            solution[*column as usize] = free(*column);
        }
        for pivot in self.pivots.iter().rev() {
            let mut sum = if homogeneous { 0.0 } else { pivot.right };
            for (column, value) in &self.others[pivot.others.clone()] {
                sum -= value * solution[*column as usize];
            }
            solution[pivot.column as usize] = sum / pivot.entry;
        }
        solution
    }
}
