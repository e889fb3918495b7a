//! The rank of a sparse matrix, which of its rows depend on others, which of its columns are free, and how certain that is.
//!
//! Columns come in groups, those of a node. Groups are eliminated one after the other: all rows that hold columns of a group are
//! brought together in a dense front, and as many of them as the group has independent columns become pivots, by the largest entry; what is left of the
//! others goes on to the next group that they hold (the multifrontal method). A row never loses its name: it is always the row of
//! the matrix that it was, less multiples of pivots. One of which nothing is left depends on the pivots; a column
//! without pivot is free. In a front with more rows than columns what is left is brought to echelon form at once, so that
//! dependent rows are found where they arise and fronts stay small.
//!
//! *What is zero?* An entry carries, besides its value s, its derivatives ṡ along four random directions of the entries of the
//! matrix, in each row by as much as the largest entry there, and of every product that is taken from it, for the roundings on the
//! way: the small-sample estimate of its condition (Kenney and Laub, 1994).
//! Their root mean square n says by how much s changes when all entries change by relative amounts: |s|/n is the
//! relative change of the matrix that makes it zero. Entries rounded by u make a zero entry of size u·n times a random number
//! of Student's distribution with four degrees of freedom, which exceeds x with probability 6/x⁴ for large x: [`ROUNDINGS`] = 1e4
//! with 6e-16. So s is zero where |s|/n ≤ 1e4 u + the relative uncertainty of the state. Up to a thousand times the
//! former, or three times both, there is no gap: the rank is undecided.

use std::ops::Range;

/// Rounding unit.
const U: f64 = crate::audit::bound::U;
/// Beyond so many rounding units, in units of the estimated condition, an entry is not zero by rounding.
pub(super) const ROUNDINGS: f64 = 1e4;
/// An entry that is not zero should exceed what counts as zero by this factor.
pub(super) const GAP: f64 = 1e3;
/// A row of lower number is taken for a pivot where its entry is not smaller than the largest by more than this factor.
const PREFERRED: f64 = 0.3;
/// The number of random directions.
const PROBES: usize = 4;

type Probes = [f32; PROBES];

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

    fn group_count(&self) -> usize {
        self.groups.len().saturating_sub(1)
    }

    /// The columns of a group.
    pub(super) fn columns_of(&self, group: usize) -> Range<usize> {
        self.groups[group] as usize..self.groups[group + 1] as usize
    }

    /// The group of each column.
    pub(super) fn group_of(&self) -> Vec<u32> {
        let mut of = vec![0; self.width()];
        for group in 0..self.group_count() {
            of[self.columns_of(group)].fill(group as u32);
        }
        of
    }
}

/// A row that became a pivot.
#[derive(Clone, Debug)]
struct Pivot {
    column: u32,
    entry: f64,
    /// Where the other entries of the row are.
    others: Range<usize>,
    right: f64,
}

/// What elimination finds.
#[derive(Clone, Debug, Default)]
pub(super) struct Outcome {
    /// The number of pivots.
    pub(super) rank: usize,
    /// Rows that depend on others.
    pub(super) dependent: Vec<u32>,
    /// Columns without pivot.
    pub(super) free: Vec<u32>,
    /// Rows whose independence is not certain.
    pub(super) doubtful: Vec<u32>,
    /// The row of the pivot of smallest |s|/n.
    pub(super) weakest: Option<u32>,
    /// The largest |s|/n that counts as zero, and the smallest that does not.
    pub(super) gap: [f64; 2],
    /// The number of entries of pivot rows.
    pub(super) fill: usize,
    /// The largest front, in columns.
    pub(super) front: usize,
    /// Whether an entry is no finite number, or so large that its uncertainty is none: nothing is then certain.
    pub(super) overflows: bool,
    pivots: Vec<Pivot>,
    others: Vec<(u32, f64)>,
}

/// What is asked of an elimination.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Task<'a> {
    /// The relative uncertainty of the entries, besides rounding.
    pub(super) uncertainty: f64,
    /// Right-hand sides by row, where a solution is wanted.
    pub(super) right: Option<&'a [f64]>,
    /// Whether pivot rows are kept, for solutions and null vectors.
    pub(super) keep: bool,
}

/// Rows on their way, over the columns of some groups.
struct Block {
    /// In the order of elimination, ascending.
    groups: Vec<u32>,
    rows: Vec<u32>,
    width: usize,
    values: Vec<f64>,
    probes: Vec<Probes>,
    right: Vec<f64>,
}

/// A number of the sequence of splitmix64.
fn mix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Four random numbers, nearly normal: sums of four uniform ones.
fn random(seed: u64) -> Probes {
    std::array::from_fn(|i| {
        let bits = mix(seed.wrapping_mul(PROBES as u64).wrapping_add(i as u64));
        let sum: i32 = (0..4).map(|part| i32::from((bits >> (16 * part)) as u16)).sum();
        (sum - 2 * 65_535) as f32 * (3.0_f32.sqrt() / 65_536.0)
    })
}

/// The root mean square, in doubles: squares of narrow numbers would overflow or vanish.
fn noise(probes: &Probes) -> f64 {
    let sum: f64 = probes.iter().map(|probe| f64::from(*probe) * f64::from(*probe)).sum();
    (sum / PROBES as f64).sqrt()
}

struct Elimination<'a> {
    matrix: &'a Sparse,
    task: Task<'a>,
    zero: f64,
    decided: f64,
    /// Groups in the order of elimination.
    order: &'a [u32],
    outcome: Outcome,
    /// The first column in the front of each group (by place in the order).
    place: Vec<u32>,
}

/// Eliminates the groups of a matrix in an order. Rows of lower number are preferred as pivots.
pub(super) fn eliminate(matrix: &Sparse, order: &[u32], task: Task<'_>) -> Outcome {
    let count = matrix.group_count();
    let zero = ROUNDINGS * U + task.uncertainty;
    let outcome = Outcome { gap: [0.0, f64::INFINITY], ..Outcome::default() };
    let mut turn = vec![0_u32; count];
    for (at, group) in order.iter().enumerate() {
        turn[*group as usize] = at as u32;
    }
    let group_of = matrix.group_of();
    let mut begin: Vec<Vec<u32>> = vec![Vec::new(); count];
    let decided = (GAP * ROUNDINGS * U).max(3.0 * zero);
    let mut work = Elimination { matrix, task, zero, decided, order, outcome, place: vec![0; count] };
    for row in 0..matrix.rows() {
        let columns = &matrix.columns[matrix.range(row)];
        let first = columns.iter().map(|column| turn[group_of[*column as usize] as usize]).min();
        match first {
            Some(first) => begin[first as usize].push(row as u32),
            None => work.outcome.dependent.push(row as u32),
        }
    }
    let mut waiting: Vec<Vec<Block>> = (0..count).map(|_| Vec::new()).collect();
    for at in 0..count {
        let rows = std::mem::take(&mut begin[at]);
        let blocks = std::mem::take(&mut waiting[at]);
        let mut front = work.front(at, &rows, blocks, &turn, &group_of);
        if let Some(rest) = work.pivot(at, &mut front)
            && let Some(next) = rest.groups.first()
        {
            waiting[*next as usize].push(rest);
        }
    }
    work.outcome.dependent.sort_unstable();
    work.outcome.free.sort_unstable();
    work.outcome
}

impl Elimination<'_> {
    fn size(&self, at: u32) -> usize {
        self.matrix.columns_of(self.order[at as usize] as usize).len()
    }

    /// Brings together what holds columns of a group.
    fn front(
        &mut self,
        at: usize,
        rows: &[u32],
        blocks: Vec<Block>,
        turn: &[u32],
        group_of: &[u32],
    ) -> Block {
        let mut groups: Vec<u32> = vec![at as u32];
        groups.extend(blocks.iter().flat_map(|block| &block.groups));
        for row in rows {
            let columns = &self.matrix.columns[self.matrix.range(*row as usize)];
            groups.extend(columns.iter().map(|column| turn[group_of[*column as usize] as usize]));
        }
        groups.sort_unstable();
        groups.dedup();
        let mut width = 0;
        for group in &groups {
            self.place[*group as usize] = width as u32;
            width += self.size(*group);
        }
        let count = rows.len() + blocks.iter().map(|block| block.rows.len()).sum::<usize>();
        let mut front = Block {
            groups,
            rows: Vec::with_capacity(count),
            width,
            values: vec![0.0; count * width],
            probes: vec![[0.0; PROBES]; count * width],
            right: Vec::with_capacity(count),
        };
        for row in rows {
            let base = front.rows.len() * width;
            let range = self.matrix.range(*row as usize);
            let largest = self.matrix.values[range.clone()].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for place in range {
                let column = self.matrix.columns[place];
                let group = group_of[column as usize];
                let within = column - self.matrix.groups[group as usize];
                let to = base + (self.place[turn[group as usize] as usize] + within) as usize;
                front.values[to] = self.matrix.values[place];
                front.probes[to] = random(place as u64).map(|number| number * largest as f32);
            }
            front.rows.push(*row);
            front.right.push(self.task.right.map_or(0.0, |right| right[*row as usize]));
        }
        for block in blocks {
            let mut from = 0;
            let mut spans: Vec<(usize, usize, usize)> = Vec::with_capacity(block.groups.len());
            for group in &block.groups {
                let size = self.size(*group);
                spans.push((from, self.place[*group as usize] as usize, size));
                from += size;
            }
            for (i, row) in block.rows.iter().enumerate() {
                let (base, source) = (front.rows.len() * width, i * block.width);
                for (from, to, size) in &spans {
                    let (from, to) = (source + from, base + to);
                    front.values[to..to + size].copy_from_slice(&block.values[from..from + size]);
                    front.probes[to..to + size].copy_from_slice(&block.probes[from..from + size]);
                }
                front.rows.push(*row);
                front.right.push(block.right[i]);
            }
        }
        self.outcome.front = self.outcome.front.max(width);
        front
    }

    /// |s|/n of an entry; `None` where it is zero, and by how much is noted.
    fn certain(&mut self, value: f64, probes: &Probes) -> Option<f64> {
        if value == 0.0 {
            return None;
        }
        let noise = noise(probes);
        if !(value.is_finite() && noise.is_finite()) {
            self.outcome.overflows = true;
            return None;
        }
        let ratio = value.abs() / noise;
        if ratio > self.zero {
            return Some(ratio);
        }
        self.outcome.gap[0] = self.outcome.gap[0].max(ratio);
        None
    }

    /// The row from `first` on, and its column among `columns`, that is the next pivot.
    fn choose(&mut self, front: &Block, first: usize, columns: &[usize]) -> Option<(usize, usize)> {
        let mut candidates: Vec<(usize, usize, f64)> = Vec::new();
        let mut largest = 0.0_f64;
        for row in first..front.rows.len() {
            for column in columns {
                let at = row * front.width + column;
                if self.certain(front.values[at], &front.probes[at]).is_some() {
                    let size = front.values[at].abs();
                    largest = largest.max(size);
                    candidates.push((row, *column, size));
                }
            }
        }
        let preferred = candidates.into_iter().filter(|(_, _, size)| *size >= PREFERRED * largest);
        let best = preferred.min_by(|x, y| front.rows[x.0].cmp(&front.rows[y.0]).then(y.2.total_cmp(&x.2)));
        let (row, column, _) = best?;
        let at = row * front.width + column;
        let ratio = self.certain(front.values[at], &front.probes[at])?;
        if ratio < self.outcome.gap[1] {
            self.outcome.gap[1] = ratio;
            self.outcome.weakest = Some(front.rows[row]);
        }
        if ratio < self.decided && !self.outcome.doubtful.contains(&front.rows[row]) {
            self.outcome.doubtful.push(front.rows[row]);
        }
        Some((row, column))
    }

    /// Takes multiples of row `by` from all rows below, so that nothing is left of its `column`.
    fn reduce(&self, front: &mut Block, by: usize, column: usize, from: usize) {
        let width = front.width;
        let (above, below) = front.values.split_at_mut((by + 1) * width);
        let (probes_above, probes_below) = front.probes.split_at_mut((by + 1) * width);
        let pivot = &above[by * width..];
        let pivot_probes = &probes_above[by * width..];
        let (entry, entry_probes) = (pivot[column], pivot_probes[column]);
        let right = front.right[by];
        let used: Vec<usize> =
            (from..width).filter(|j| pivot[*j] != 0.0 || pivot_probes[*j] != [0.0; PROBES]).collect();
        let is_dense = used.len() * 2 > width - from;
        let rows = below.chunks_exact_mut(width).zip(probes_below.chunks_exact_mut(width));
        for (at, ((row, probes), rest)) in rows.zip(&mut front.right[by + 1..]).enumerate() {
            if row[column] == 0.0 && probes[column] == [0.0; PROBES] {
                continue;
            }
            let factor = row[column] / entry;
            let slope: Probes =
                std::array::from_fn(|i| (probes[column][i] - factor as f32 * entry_probes[i]) / entry as f32);
            let narrow = factor as f32;
            // The rounding of this step: what is taken away may be larger than the rows were.
            let seed = u64::from(front.rows[by + 1 + at]) << 32 | u64::from(front.rows[by]);
            let rounding = random(mix(seed) ^ column as u64);
            let update = |value: &mut f64, probes: &mut Probes, j: usize| {
                *value -= factor * pivot[j];
                let by = pivot[j] as f32;
                let taken = (narrow * by).abs();
                for i in 0..PROBES {
                    probes[i] -= slope[i] * by + narrow * pivot_probes[j][i] + rounding[i] * taken;
                }
            };
            if is_dense {
                for j in from..width {
                    update(&mut row[j], &mut probes[j], j);
                }
            } else {
                for j in &used {
                    update(&mut row[*j], &mut probes[*j], *j);
                }
            }
            row[column] = 0.0;
            probes[column] = [0.0; PROBES];
            *rest -= factor * right;
        }
    }

    fn swap(front: &mut Block, i: usize, j: usize) {
        if i != j {
            let width = front.width;
            for k in 0..width {
                front.values.swap(i * width + k, j * width + k);
                front.probes.swap(i * width + k, j * width + k);
            }
            front.rows.swap(i, j);
            front.right.swap(i, j);
        }
    }

    /// Finds the pivots of the first group of a front, and gives what is left of the other rows.
    fn pivot(&mut self, at: usize, front: &mut Block) -> Option<Block> {
        let size = self.size(at as u32);
        let first_column = self.matrix.columns_of(self.order[at] as usize).start;
        let mut columns: Vec<usize> = (0..size).collect();
        let mut done = 0;
        while let Some((row, column)) = self.choose(front, done, &columns) {
            Self::swap(front, done, row);
            self.reduce(front, done, column, 0);
            columns.retain(|other| *other != column);
            self.keep(front, done, column, first_column + column);
            done += 1;
        }
        self.outcome.rank += done;
        self.outcome.free.extend(columns.iter().map(|column| (first_column + column) as u32));
        self.rest(front, done, size)
    }

    /// Keeps a pivot row.
    fn keep(&mut self, front: &Block, row: usize, column: usize, name: usize) {
        let values = &front.values[row * front.width..(row + 1) * front.width];
        self.outcome.fill += values.iter().filter(|value| **value != 0.0).count();
        if !self.task.keep {
            return;
        }
        let begin = self.outcome.others.len();
        let mut from = 0;
        for group in &front.groups {
            let columns = self.matrix.columns_of(self.order[*group as usize] as usize);
            for (within, name) in columns.enumerate() {
                let value = values[from + within];
                if value != 0.0 && from + within != column {
                    self.outcome.others.push((name as u32, value));
                }
            }
            from += self.size(*group);
        }
        self.outcome.pivots.push(Pivot {
            column: name as u32,
            entry: values[column],
            others: begin..self.outcome.others.len(),
            right: front.right[row],
        });
    }

    /// What is left of the rows from `done` on in the columns from `size` on, without rows of which nothing is left.
    fn rest(&mut self, front: &Block, done: usize, size: usize) -> Option<Block> {
        let width = front.width - size;
        let mut rest = Block {
            groups: front.groups[1..].to_vec(),
            rows: Vec::new(),
            width,
            values: Vec::new(),
            probes: Vec::new(),
            right: Vec::new(),
        };
        for row in done..front.rows.len() {
            let range = row * front.width + size..(row + 1) * front.width;
            let is_zero = range.clone().all(|at| self.certain(front.values[at], &front.probes[at]).is_none());
            if is_zero {
                self.outcome.dependent.push(front.rows[row]);
                continue;
            }
            rest.rows.push(front.rows[row]);
            rest.values.extend_from_slice(&front.values[range.clone()]);
            rest.probes.extend_from_slice(&front.probes[range]);
            rest.right.push(front.right[row]);
        }
        if rest.rows.len() > width {
            self.compress(&mut rest);
        }
        (!rest.rows.is_empty()).then_some(rest)
    }

    /// Brings rows to echelon form and drops those of which nothing is left.
    fn compress(&mut self, block: &mut Block) {
        let mut done = 0;
        for column in 0..block.width {
            if let Some((row, _)) = self.choose(block, done, &[column]) {
                Self::swap(block, done, row);
                self.reduce(block, done, column, column);
                done += 1;
            }
        }
        self.outcome.dependent.extend(block.rows.drain(done..));
        block.values.truncate(done * block.width);
        block.probes.truncate(done * block.width);
        block.right.truncate(done);
    }
}

impl Outcome {
    /// Whether what counts as zero and what does not are well apart.
    pub(super) fn is_decided(&self) -> bool {
        self.doubtful.is_empty() && !self.overflows
    }

    /// Whether pivot rows were kept.
    pub(super) fn has_pivots(&self) -> bool {
        !self.pivots.is_empty()
    }

    /// The solution of the pivot rows with the right-hand sides given, and these values of free columns; of the homogeneous ones
    /// where `homogeneous`. Needs pivots that were kept.
    pub(super) fn solve(&self, width: usize, free: impl Fn(u32) -> f64, homogeneous: bool) -> Vec<f64> {
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
