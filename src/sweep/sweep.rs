//! What the states of a chunk give: values and rows of all, and what 237 bits say of a share.

use crate::SweepError;
use crate::plan::{Plan, Subject, sha256};
use crate::ranges::Ranges;
use crate::states::{Drawn, Source};
use crate::summary::{Bits, Largest, OfSubject, Summary};
use pintle_audit::{Entries, Numbers, Quantity, against_truth};
use pintle_kinematics::batch::{Batch, COLUMNS, History, LANES, Row, Section, Tile, advance, vector_unit};
use pintle_kinematics::catalog::{Condition, Slot};
use pintle_kinematics::connector::{Branch, Connector, Definition, Increment, Linear, State};
use pintle_kinematics::draw::splitmix64;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::{Real, U};
use pintle_kinematics::vector::dot;
use rayon::prelude::*;
use std::ops::Range;

/// Consecutive states that one connector has. Tiles of four begin at multiples of four, whatever the chunk.
const BLOCK: u64 = 32;

/// The states that a thread takes at a time.
const PIECE: u64 = 4096;

/// How many roundings may be left of a row along rigid motions.
pub const RIGID: f64 = 8.0;

/// A plan that is ready to run.
#[derive(Debug)]
pub struct Sweep {
    plan: Plan,
    hash: String,
    key: u64,
    arithmetic: String,
    connectors: Vec<Ready>,
}

/// A connector of the plan.
#[derive(Debug)]
struct Ready {
    subject: usize,
    source: Source,
    connector: Connector<f64>,
    branch: Branch<f64>,
    /// None where rows depend on material flow.
    batch: Option<Batch>,
    section: Section,
    has_history: bool,
    /// Whether rows have all columns, so that rigid motions change nothing.
    is_free: bool,
    /// What values count from.
    origin: [f64; 6],
}

/// Room for the states of a block.
#[derive(Default)]
struct Room {
    drawn: Vec<Drawn>,
    branches: Vec<Branch<f64>>,
    tiles: Vec<Tile>,
    sections: Vec<Section>,
    histories: Vec<History>,
    rows: Vec<Row>,
}

/// What rows of four states give besides themselves.
struct Seen {
    hash: [u64; LANES],
    /// Zero, or not a number.
    finite: [f64; LANES],
    rigid: [f64; LANES],
}

/// The factor of each bit pattern in the hash of a state: row by row the value and twelve columns.
const FACTORS: [[u64; 13]; 6] = {
    let mut factors = [[0; 13]; 6];
    let mut at = 0;
    while at < 78 {
        factors[at / 13][at % 13] = splitmix64(at as u64) | 1;
        at += 1;
    }
    factors
};

impl Sweep {
    /// From the text of a plan.
    ///
    /// # Errors
    /// A text that is no plan.
    pub fn new(text: &str) -> Result<Self, SweepError> {
        let plan = Plan::parse(text)?;
        // One connector of each subject after the other, so that few states have some of each.
        let all: Vec<Vec<Definition>> =
            plan.subjects.iter().map(Subject::connectors).collect::<Result<_, _>>()?;
        let most = all.iter().map(Vec::len).max().unwrap_or(0);
        let place = |i: usize| {
            let of = all.iter().enumerate();
            of.filter_map(move |(subject, all)| Some(Ready::new(subject, all.get(i)?)))
        };
        let connectors: Vec<Ready> = (0..most).flat_map(place).collect();
        if connectors.is_empty() {
            return Err(SweepError::Plan("it has no connector".into()));
        }
        let hash = sha256(text);
        let key = u64::from_str_radix(sha256(&plan.seed).get(..16).unwrap_or("0"), 16).unwrap_or(0);
        let arithmetic = vector_unit().unwrap_or("doubles one by one").to_string();
        Ok(Self { plan, hash, key, arithmetic, connectors })
    }

    /// The plan.
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// A summary of no state.
    pub fn empty(&self) -> Summary {
        Summary::empty(&self.hash, &self.arithmetic, self.plan.subjects.iter().map(|of| of.name.clone()))
    }

    /// The summary of `count` states from `first` on, by all threads of the pool that this runs in. `progress` is told how many more are done.
    ///
    /// # Errors
    /// As [`Summary::merge`].
    pub fn run(
        &self,
        first: u64,
        count: u64,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Summary, SweepError> {
        let pieces = Ranges::of(first, count).chunks(PIECE);
        let done = |mut summary: Summary, (from, some): (u64, u64)| {
            self.piece(from..from + some, &mut summary);
            progress(some);
            Ok(summary)
        };
        let merged = |mut one: Summary, other: Summary| one.merge(&other).map(|()| one);
        let pieces = pieces.into_par_iter();
        pieces.try_fold(|| self.empty(), done).try_reduce(|| self.empty(), merged)
    }

    /// The state of an index, with the name of its subject.
    pub fn state(&self, index: u64) -> Option<(&str, Drawn)> {
        let ready = self.connector_of(index)?;
        let name = self.plan.subjects.get(ready.subject)?.name.as_str();
        Some((name, ready.source.state(self.key, index)))
    }

    fn connector_of(&self, index: u64) -> Option<&Ready> {
        let count = self.connectors.len() as u64;
        self.connectors.get((index / BLOCK).checked_rem(count)? as usize)
    }

    /// Whether a state is judged on 237 bits: a matter of its index alone.
    fn is_judged(&self, index: u64) -> bool {
        const ALL: f64 = 18_446_744_073_709_551_616.0;
        let share = self.plan.share * ALL;
        share >= ALL || splitmix64(self.key ^ splitmix64(index)) < share as u64
    }

    fn piece(&self, range: Range<u64>, summary: &mut Summary) {
        let mut room = Room::default();
        let mut from = range.start;
        while from < range.end {
            let to = ((from / BLOCK + 1) * BLOCK).min(range.end);
            let Some(ready) = self.connector_of(from) else { return };
            if let Some(of) = summary.subjects.get_mut(ready.subject) {
                let hash = self.block(ready, from..to, &mut room, of);
                summary.fingerprint = summary.fingerprint.wrapping_add(hash);
            }
            from = to;
        }
        summary.states.add(&Ranges::of(range.start, range.end - range.start));
    }

    /// The states of one block, and the sum of their hashes.
    fn block(&self, ready: &Ready, range: Range<u64>, room: &mut Room, of: &mut OfSubject) -> u64 {
        const FOUR: u64 = LANES as u64;
        let whole = range.start / FOUR * FOUR..range.end.div_ceil(FOUR) * FOUR;
        room.drawn.clear();
        room.drawn.extend(whole.clone().map(|index| ready.source.state(self.key, index)));
        room.follow(ready);
        let rows = match &ready.batch {
            Some(batch) => {
                room.rows.clear();
                room.rows.resize(batch.rows() * room.tiles.len(), Row::default());
                let done = batch.rows_of(&room.tiles, &room.sections, &room.histories, &mut room.rows);
                debug_assert_eq!(done, Ok(()), "the slices have been made for each other");
                batch.rows()
            }
            None => room.one_by_one(ready),
        };
        let mut sum = 0_u64;
        for (t, tile) in room.tiles.iter().enumerate() {
            let own = room.rows.get(t * rows..(t + 1) * rows).unwrap_or_default();
            let seen = Seen::of(own, tile, ready.is_free);
            for lane in 0..LANES {
                let at = t * LANES + lane;
                let index = whole.start + at as u64;
                let Some(drawn) = room.drawn.get(at).filter(|_| range.contains(&index)) else { continue };
                sum = sum.wrapping_add(splitmix64(seen.hash[lane] ^ splitmix64(index)));
                of.add(drawn, index, (seen.finite[lane], seen.rigid[lane]), ready.source.length);
                of.numbers += 13 * rows as u64;
                if self.is_judged(index) {
                    let branch = room.branches.get(at).copied().unwrap_or_else(|| {
                        ready.connector.advance(&drawn.state(), &drawn.increment, &ready.branch)
                    });
                    ready.judge((drawn, &branch), own, (lane, index), of);
                }
            }
        }
        sum
    }
}

impl Room {
    /// The branches of the states, and their tiles.
    fn follow(&mut self, ready: &Ready) {
        let Self { drawn, branches, tiles, sections, histories, .. } = self;
        branches.clear();
        tiles.clear();
        histories.clear();
        let (fours, _) = drawn.as_chunks::<LANES>();
        for four in fours {
            tiles.push(Tile::new(&four.map(|one| one.pair)));
            if ready.has_history {
                let states: [State<f64>; LANES] = four.map(|one| one.state());
                let increments: [Increment<f64>; LANES] = four.map(|one| one.increment);
                let before = [ready.branch; LANES];
                let after = advance(&[&ready.connector; LANES], &states, &increments, &before);
                histories.push(History::new(&after));
                branches.extend(after);
            }
        }
        if !ready.has_history {
            histories.resize(tiles.len(), History::new(&[ready.branch; LANES]));
        }
        sections.clear();
        sections.resize(tiles.len(), ready.section);
    }

    /// Rows without a batch, in the places that a batch would give them; columns of material flow are left to the share that is judged.
    fn one_by_one(&mut self, ready: &Ready) -> usize {
        let mut linear = [Linear::default(); 6];
        self.rows.clear();
        let mut rows = 0;
        for (at, drawn) in self.drawn.iter().enumerate() {
            let (tile, lane) = (at / LANES, at % LANES);
            let branch = self.branches.get(at).unwrap_or(&ready.branch);
            rows = ready.connector.linearize(&drawn.pair, branch, [true; 6], &mut linear);
            self.rows.resize((tile + 1) * rows, Row::default());
            let places = self.rows.iter_mut().skip(tile * rows);
            for (place, one) in places.zip(&linear) {
                place.value[lane] = one.value;
                for (column, j) in place.columns.iter_mut().zip(COLUMNS) {
                    column[lane] = one.row[j];
                }
            }
        }
        rows
    }
}

impl Ready {
    fn new(subject: usize, definition: &Definition) -> Self {
        let connector = Connector::<f64>::new(definition);
        let origin = [0, 1, 2, 3, 4, 5].map(|k| {
            let (of, position) = (connector.differentiated(k), connector.position_measure(k));
            let vanishes = match definition.connection.slots[k] {
                Slot::Constrained(_, Condition::Zero(_)) => true,
                Slot::Constrained(_, Condition::ZeroOrHeld(printed)) => of == Some(printed) && of != position,
                _ => false,
            };
            connector.counts_from(k).filter(|_| !vanishes).unwrap_or(0.0)
        });
        Self {
            subject,
            source: Source::new(definition, &connector),
            branch: connector.initial_branch(),
            batch: Batch::new(&connector, [true; 6]).ok(),
            section: Section::new(&[&connector; LANES]),
            has_history: (0..6).any(|k| {
                let is_one_form = connector.position_measure(k).is_some_and(Measure::is_one_form);
                is_one_form || connector.row_has_history(k)
            }),
            is_free: !definition.planar && definition.rotates == [true; 2] && definition.moves == [true; 2],
            origin,
            connector,
        }
    }

    /// The value of component k as the audit has it: from where it counts, with its turns.
    fn counted(&self, k: usize, value: f64, branch: &Branch<f64>) -> f64 {
        let value = value - self.origin[k];
        let winds = self.connector.differentiated(k).is_some_and(|measure| measure.winds());
        if winds { f64::with_turns(value, branch.turns[k].turns) } else { value }
    }

    /// What 237 bits say of the numbers of a lane.
    fn judge(
        &self,
        (drawn, branch): (&Drawn, &Branch<f64>),
        rows: &[Row],
        at: (usize, u64),
        of: &mut OfSubject,
    ) {
        let (lane, index) = at;
        let (mut values, mut first) = (Entries::default(), Entries::default());
        match &self.batch {
            Some(batch) => {
                for (row, (k, _)) in rows.iter().zip(batch.measures()) {
                    let mut entries = vec![0.0; DOFS];
                    for (j, column) in COLUMNS.into_iter().zip(&row.columns) {
                        if self.connector.active()[j] {
                            entries[j] = column[lane];
                        }
                    }
                    values.0[*k] = Some(vec![self.counted(*k, row.value[lane], branch)]);
                    first.0[*k] = Some(entries);
                }
            }
            None => {
                let mut linear = [Linear::default(); 6];
                let count = self.connector.linearize(&drawn.pair, branch, [true; 6], &mut linear);
                for Linear { component, value, row } in linear.into_iter().take(count) {
                    values.0[component] = Some(vec![self.counted(component, value, branch)]);
                    first.0[component] = Some(row.to_vec());
                }
            }
        }
        let mut numbers = Numbers::default();
        numbers.set(Quantity::Value, values);
        numbers.set(Quantity::FirstDerivatives, first);
        let case = self.source.case(&of.name, index, drawn);
        if let Some(found) = against_truth(&case, &numbers) {
            let [value, row] = &found.found;
            of.judged += 1;
            of.value.add(found.nearness, value, index);
            of.row.add(found.nearness, row, index);
        }
    }
}

impl Seen {
    fn of(rows: &[Row], tile: &Tile, is_free: bool) -> Self {
        let mut seen = Self { hash: [0; LANES], finite: [0.0; LANES], rigid: [0.0; LANES] };
        let [a, b] = &tile.displacement;
        let apart: [[f64; LANES]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|lane| tile.reference[i][lane] + (b[i][lane] - a[i][lane]))
        });
        for (row, factors) in rows.iter().zip(&FACTORS) {
            for (column, factor) in [&row.value].into_iter().chain(&row.columns).zip(factors) {
                for lane in 0..LANES {
                    seen.hash[lane] =
                        seen.hash[lane].wrapping_add(column[lane].to_bits().wrapping_mul(*factor));
                    seen.finite[lane] += column[lane] * 0.0;
                }
            }
            if is_free {
                seen.add_rigid(&row.columns, &apart);
            }
        }
        seen
    }

    /// A translation of both nodes changes nothing, and no rotation about a does: x_a + x_b = 0, θ_a + θ_b + d × x_b = 0.
    fn add_rigid(&mut self, of: &[[f64; LANES]; 12], apart: &[[f64; LANES]; 3]) {
        for lane in 0..LANES {
            let column = |j: usize| of[j][lane];
            let d = [apart[0][lane], apart[1][lane], apart[2][lane]];
            let (mut off, mut forces, mut moments, mut arm) = ([0.0_f64; 2], 0.0, 0.0, 0.0);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let (one, other) = (d[j] * column(6 + k), d[k] * column(6 + j));
                let moment = column(3 + i) + column(9 + i) + (one - other);
                off[0] = off[0].max((column(i) + column(6 + i)).abs());
                off[1] = off[1].max(moment.abs());
                forces += column(i).abs() + column(6 + i).abs();
                moments += column(3 + i).abs() + column(9 + i).abs();
                arm += d[i].abs();
            }
            moments += arm * forces;
            // 0/0 is not a number, and the larger of it and a number that number.
            let units = (off[0] / (U * forces)).max(off[1] / (U * moments));
            self.rigid[lane] = self.rigid[lane].max(units);
        }
    }
}

impl OfSubject {
    /// Adds a state, whose numbers are finite where the first of these is zero.
    fn add(&mut self, drawn: &Drawn, index: u64, (finite, rigid): (f64, f64), length: f64) {
        let pair = &drawn.pair;
        *self.places.entry(drawn.place).or_default() += 1;
        let trace = (0..3).fold(0.0, |sum, i| sum + dot(pair.a.triad[i], pair.b.triad[i]));
        self.turned.add(0.25 * (3.0 - trace));
        let d = pair.separation();
        self.apart.add(dot(d, d) / (length * length));
        if finite != 0.0 {
            self.not_finite += 1;
            self.first_not_finite = Some(self.first_not_finite.map_or(index, |first| first.min(index)));
        }
        self.rigid.add(rigid);
        self.not_rigid += u64::from(rigid > RIGID);
        self.largest_rigid = Largest::of(self.largest_rigid, Some(Largest { value: Bits(rigid), index }));
    }
}
