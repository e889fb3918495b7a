//! What the states of a chunk give: values and rows of all, and what 237 bits say of a share.

use crate::SweepError;
use crate::generator::Generator;
use crate::plan::{Plan, sha256};
use crate::ranges::{Ranges, checked};
use crate::routine::{Due, Routines};
use crate::states::{Drawn, Source};
use crate::summary::{OfSubject, Summary, first};
use pintle_audit::sampling::cube_orientations;
use pintle_audit::{
    AgainstTruth, C, Case, Entries, Given, Numbers, Quantity, against_truth, others_against_truth,
};
use pintle_kinematics::batch::{
    Batch, COLUMNS, Four, Fours, HessianRow, History, LANES, Row, Section, Tile, vector_unit,
};
use pintle_kinematics::connector::{Branch, Connector, Definition, Increment, Linear, Tally, Turns};
use pintle_kinematics::draw::splitmix64;
use pintle_kinematics::measure::{Margin, Measure, SingularClass};
use pintle_kinematics::node::{DOFS, PSI_A, PSI_B};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::scalar::{Real, U};
use pintle_kinematics::vector::{Matrix, Vector, apply, dot, product, sub};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Consecutive states that one connector has. Tiles of four begin at multiples of four, whatever the chunk.
const BLOCK: u64 = 32;

/// The states that a thread takes at a time.
const PIECE: u64 = 4096;

/// One block of so many is turned as a whole, and computed again.
const TURNED: u64 = 16;

/// Numbers of a routine may be so many roundings of the audit's scale off ours: its own are within three times C, ours within C. What is
/// further, 237 bits judge.
const APART: f64 = 2.0 * C;

/// What is so far off is wrong, whatever 237 bits say.
const FAR: f64 = 1e6;

/// On a singular set there is no scale: 237 bits judge.
const BESIDE: f64 = FAR;

/// As near to a singular set is on it: rounding puts exact right angles so far off.
const ON_SET: f64 = 1e-14;

/// As near to a singular set (rad, or lengths) 237 bits judge whatever is apart.
const NEAR: f64 = 1e-6;

/// How many roundings may be left of a row along rotations, of all that is added up.
///
/// In θ_a = fl(fl(g × D) − h) the products are rounded twice and the difference once. The sum θ_a + θ_b + D × g rounds its products once,
/// their difference once and the first sum once: 4 of |θ| + |D| |g|.
///
/// A row without θ_a, of a distance, has g = A Aᵀ D/|D|. Two sums of three products, a root and a quotient are 8 of |D| |g|, which is counted
/// twice; with the check's own 2 that is 6. Triads are rotations to within 2 roundings more. Along translations nothing may be left, for x_a
/// is the opposite of x_b.
pub const RIGID: f64 = 8.0;

/// By how many roundings of the audit's scale values and rows may change when both nodes are turned as one.
///
/// The turn itself rounds nothing. Both results are within C roundings of the exact one, or within 2 C beside a singular set.
pub const FRAME: f64 = 4.0 * C;

/// A plan that is ready to run.
#[derive(Debug)]
pub struct Sweep {
    plan: Plan,
    hash: String,
    key: u64,
    arithmetic: String,
    connectors: Vec<Ready>,
    /// The exact orientations; the first is none.
    cubes: Vec<Matrix<f64>>,
    planted: Option<Planted>,
}

pintle_kinematics::named! {
    /// A fault that is put into numbers, to see it found.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Planted {
        /// One column of one state is 16 roundings off.
        Column = "column",
        /// One number of one state is none.
        NotANumber = "not-a-number",
        /// One entry of what is judged is changed.
        Judged = "judged",
        /// Rotations about two axes are exchanged, of both nodes, so that no rigid motion tells.
        Axes = "axes",
    }
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
    /// Four of it before any motion.
    fours: Fours,
    has_history: bool,
    /// Whether rows have all columns of both nodes: those of a batch do, whatever can move.
    is_whole: bool,
    /// Which rows are angles that wind.
    winds: Vec<bool>,
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
    /// Columns of material flow of the rows, where there is no batch.
    flows: Vec<[Four; 2]>,
    turned: Vec<Tile>,
    hessians: Vec<HessianRow>,
}

/// What rows of four states give besides themselves.
struct Seen {
    hash: [u64; LANES],
    /// Zero, or not a number.
    finite: [f64; LANES],
    /// What rigid motions leave, where that can be asked.
    rigid: Option<[f64; LANES]>,
    /// What turning both nodes changes, where that was asked.
    frame: [Option<f64>; LANES],
}

/// The factor of each bit pattern in the hash of a state: row by row the value, twelve columns and those of material flow.
const FACTORS: [[u64; 15]; 6] = {
    let mut factors = [[0; 15]; 6];
    let mut at = 0;
    while at < 90 {
        factors[at / 15][at % 15] = splitmix64(at as u64) | 1;
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
        let (all, definitions) = plan.connectors()?;
        if definitions != plan.definitions {
            return Err(SweepError::Plan(
                "it was made where sines, cosines and powers round otherwise, and so types are other connectors here: \
                 sweep on machines of one kind"
                    .into(),
            ));
        }
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
        let unit = vector_unit().unwrap_or("doubles one by one");
        let arithmetic = format!("{unit}, elementary functions {:016x}", elementary(&FUNCTIONS));
        Ok(Self { plan, hash, key, arithmetic, connectors, cubes: cube_orientations(), planted: None })
    }

    /// The same with a fault.
    #[must_use]
    pub const fn planting(mut self, planted: Option<Planted>) -> Self {
        self.planted = planted;
        self
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
    /// As [`checked`]; a plan that names a routine, which [`crate::Routines::run`] asks.
    pub fn run(
        &self,
        first: u64,
        count: u64,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Summary, SweepError> {
        self.run_of(first, count, progress, None)
    }

    /// The same of the numbers of somebody's routine, where one is given.
    pub(crate) fn run_of(
        &self,
        first: u64,
        count: u64,
        progress: &(dyn Fn(u64) + Sync),
        routines: Option<&Routines<'_>>,
    ) -> Result<Summary, SweepError> {
        if self.plan.routine.is_some() && routines.is_none() {
            return Err(SweepError::Routine("the plan is of a routine, and none was started".into()));
        }
        let end = checked(first, count)?;
        let pieces = first / PIECE..end.div_ceil(PIECE);
        let done = |mut summary: Summary, piece: u64| {
            let range = first.max(piece * PIECE)..end.min((piece + 1) * PIECE);
            let some = range.end - range.start;
            self.piece(range, &mut summary, routines)?;
            progress(some);
            Ok(summary)
        };
        let merged = |mut one: Summary, other: Summary| one.merge(&other).map(|()| one);
        let pieces = pieces.into_par_iter();
        pieces.try_fold(|| self.empty(), done).try_reduce(|| self.empty(), merged)
    }

    /// The state of an index, as a case of the audit with the name of its subject.
    pub fn case(&self, index: u64) -> Option<Case> {
        let ready = self.connector_of(index)?;
        let name = self.plan.subjects.get(ready.subject)?.name.as_str();
        Some(ready.source.case(name, index, &self.state(ready, index)))
    }

    /// The state of an index. A Sobol sequence is one of each connector by itself, whose states are counted without the others.
    fn state(&self, ready: &Ready, index: u64) -> Drawn {
        let count = self.connectors.len() as u64;
        let (block, at) = (index / BLOCK, index % BLOCK);
        let (key, index) = match self.plan.generator {
            Generator::Philox => (self.key, index),
            Generator::Sobol => (self.key ^ splitmix64(block % count), block / count * BLOCK + at),
        };
        ready.source.state(self.plan.generator, key, index)
    }

    fn connector_of(&self, index: u64) -> Option<&Ready> {
        self.connectors.get(self.place_of(index)?)
    }

    /// The place of the connector that a state is of.
    fn place_of(&self, index: u64) -> Option<usize> {
        (index / BLOCK).checked_rem(self.connectors.len() as u64).map(|place| place as usize)
    }

    /// What defines the connector at a place.
    pub(crate) fn definition_at(&self, place: usize) -> Option<&Definition> {
        self.connectors.get(place).map(|ready| &ready.source.definition)
    }

    /// Whether a state is judged on 237 bits: a matter of its index alone.
    fn is_judged(&self, index: u64) -> bool {
        const ALL: f64 = 18_446_744_073_709_551_616.0;
        let share = self.plan.share * ALL;
        share >= ALL || splitmix64(self.key ^ splitmix64(index)) < share as u64
    }

    /// How the states of a block are turned besides, of a share of the blocks: a matter of its index alone, and never not at all.
    fn turn_of(&self, block: u64) -> Option<Matrix<f64>> {
        let drawn = splitmix64(splitmix64(self.key) ^ block);
        let at = 1 + drawn / TURNED % (self.cubes.len() as u64 - 1);
        self.cubes.get(at as usize).copied().filter(|_| drawn.is_multiple_of(TURNED))
    }

    fn piece(
        &self,
        range: Range<u64>,
        summary: &mut Summary,
        routines: Option<&Routines<'_>>,
    ) -> Result<(), SweepError> {
        let mut room = Room::default();
        let mut from = range.start;
        while from < range.end {
            let to = ((from / BLOCK + 1) * BLOCK).min(range.end);
            let (Some(ready), Some(place)) = (self.connector_of(from), self.place_of(from)) else { break };
            if let Some(of) = summary.subjects.get_mut(ready.subject) {
                let hash = match routines {
                    Some(routines) => {
                        self.block_of_routine(ready, from..to, &mut room, of, (routines, place))?
                    }
                    None => self.block(ready, from..to, &mut room, of),
                };
                summary.fingerprint = summary.fingerprint.wrapping_add(hash);
            }
            from = to;
        }
        summary.states.add(&Ranges::of(range.start, range.end - range.start));
        Ok(())
    }

    /// The states of one block, and the sum of their hashes.
    fn block(&self, ready: &Ready, range: Range<u64>, room: &mut Room, of: &mut OfSubject) -> u64 {
        let whole = self.draw(ready, &range, room);
        room.flows.clear();
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
        if let Some(planted) = self.planted {
            planted.spoil(&mut room.rows);
        }
        let turn = self.turn_of(range.start / BLOCK);
        let turn = turn.zip(ready.batch.as_ref()).map(|(turn, batch)| {
            room.turn(ready, batch, &turn);
            turn
        });
        let mut sum = 0_u64;
        for (t, tile) in room.tiles.iter().enumerate() {
            let own = room.rows.get(t * rows..(t + 1) * rows).unwrap_or_default();
            let flows = room.flows.get(t * rows..(t + 1) * rows).unwrap_or_default();
            let mut seen = Seen::of(own, flows, tile, ready.is_whole);
            if let (Some(turn), Some(again)) = (&turn, room.hessians.get(t * rows..(t + 1) * rows)) {
                seen.add_frame((own, again), turn, tile, ready);
            }
            for lane in 0..LANES {
                let at = t * LANES + lane;
                let index = whole.start + at as u64;
                let Some(drawn) = room.drawn.get(at).filter(|_| range.contains(&index)) else { continue };
                // On a singular set rounding decides values, and the sign of a zero may.
                if seen.frame[lane].is_some_and(|frame| frame > FRAME)
                    && ready.distance(drawn, room.branches.get(at).unwrap_or(&ready.branch), false) <= 0.0
                {
                    seen.frame[lane] = None;
                }
                sum = sum.wrapping_add(splitmix64(seen.hash[lane] ^ splitmix64(index)));
                let mut is_wrong = of.add(drawn, index, (&seen, lane), ready.source.length);
                of.numbers += (if flows.is_empty() { 13 } else { 15 }) * rows as u64;
                if self.is_judged(index) {
                    let branch = room.branches.get(at).copied().unwrap_or_else(|| {
                        ready.connector.advance(&drawn.state(), &drawn.increment, &ready.branch)
                    });
                    is_wrong |= ready.judge((drawn, &branch), own, (lane, index, self.planted), of);
                }
                of.wrong += u64::from(is_wrong);
            }
        }
        sum
    }

    /// Draws the states of whole tiles around a range, and follows their histories.
    fn draw(&self, ready: &Ready, range: &Range<u64>, room: &mut Room) -> Range<u64> {
        const FOUR: u64 = LANES as u64;
        let whole = range.start / FOUR * FOUR..range.end.div_ceil(FOUR) * FOUR;
        room.drawn.clear();
        room.drawn.extend(whole.clone().map(|index| self.state(ready, index)));
        room.follow(ready);
        whole
    }

    /// The same of a routine, asked at every state. Where a batch has our own numbers they are compared: 237 bits judge what is further from them than
    /// two right ones can be, and the share.
    fn block_of_routine(
        &self,
        ready: &Ready,
        range: Range<u64>,
        room: &mut Room,
        of: &mut OfSubject,
        (routines, place): (&Routines<'_>, usize),
    ) -> Result<u64, SweepError> {
        let whole = self.draw(ready, &range, room);
        room.hessians.clear();
        let rows = ready.batch.as_ref().map_or(0, Batch::rows);
        if let Some(batch) = &ready.batch {
            room.hessians.resize(rows * room.tiles.len(), HessianRow::default());
            let done = batch.rows_of(&room.tiles, &room.sections, &room.histories, &mut room.hessians);
            debug_assert_eq!(done, Ok(()), "the slices have been made for each other");
        }
        let at = |index: u64| (index - whole.start) as usize;
        let drawn = |index: u64| room.drawn.get(at(index)).map(|drawn| (index, drawn));
        let asked: Vec<(u64, &Drawn)> = range.clone().filter_map(drawn).collect();
        let case = |(index, drawn): &(u64, &Drawn)| (*index, ready.source.case(&of.name, *index, drawn));
        let cases: Vec<(u64, Case)> = asked.iter().map(case).collect();
        let (answers, due) = routines.ask(place, &cases)?;
        let mut sum = 0_u64;
        for (((index, drawn), (_, case)), given) in asked.iter().zip(&cases).zip(answers) {
            let branch = room.branches.get(at(*index)).unwrap_or(&ready.branch);
            let given = given.map(|given| given.on_sheet_of(case));
            let read = given.as_ref().map(|given| ready.read(given, due));
            let passed = match (&given, &read) {
                (Some(given), _) if given.is_on_another_sheet(case) => Some(&mut of.elsewhere),
                (Some(_), Some(Read { finite, .. }))
                    if *finite != 0.0 && ready.distance(drawn, branch, true) <= ON_SET =>
                {
                    Some(&mut of.undefined)
                }
                (Some(_), _) => None,
                (None, _) => Some(&mut of.outside),
            };
            if let Some(passed) = passed {
                *passed += 1;
                *of.places.entry(drawn.place).or_default() += 1;
                continue;
            }
            let (Some(given), Some(read)) = (given, read) else { continue };
            let lane = at(*index) % LANES;
            let own = room.hessians.get(at(*index) / LANES * rows..).and_then(|own| own.get(..rows));
            let own = own.filter(|own| !own.is_empty());
            let mut seen = Seen { hash: [0; LANES], finite: [0.0; LANES], rigid: None, frame: [None; LANES] };
            (seen.hash[lane], seen.finite[lane]) = (read.hash, read.finite);
            sum = sum.wrapping_add(splitmix64(read.hash ^ splitmix64(*index)));
            let mut is_wrong = of.add(drawn, *index, (&seen, lane), ready.source.length);
            of.numbers += read.numbers;
            let apart = own.map_or(0.0, |own| ready.apart(&given, (own, lane), branch, case.length));
            // Next to a singular set another number may be as right.
            let is_far = apart > FAR && ready.distance(drawn, branch, false) > NEAR;
            is_wrong |= is_far;
            if self.is_judged(*index) || (apart > APART && !is_far) {
                is_wrong |= of.add_judged(others_against_truth(case, &given), *index);
            }
            of.wrong += u64::from(is_wrong);
            of.first_wrong = first(of.first_wrong, is_wrong.then_some(*index));
        }
        Ok(sum)
    }
}

/// What is read off the numbers of a routine at a state.
struct Read {
    hash: u64,
    /// Zero, or not a number: where something is missing that is due, too.
    finite: f64,
    numbers: u64,
}

/// A function of the machine, of which no standard says how it rounds.
type Function = fn(f64, f64) -> f64;

/// Those by which states near singular points are drawn, and by which what is computed one by one is.
const FUNCTIONS: [Function; 8] = [
    |x, _| x.sin(),
    |x, _| x.cos(),
    |x, _| x.tan(),
    |x, y| x.atan2(y),
    |x, _| (x / 16.0).acos(),
    |x, y| x.abs().powf(y),
    |x, _| x.exp(),
    |x, _| x.abs().ln(),
];

/// A hash of all bits of what functions give at fixed points: other functions round otherwise at some of them.
fn elementary(functions: &[Function]) -> u64 {
    const POINTS: u64 = 512;
    let at = |i: u64| (splitmix64(i) >> 11) as f64 / (1_u64 << 48) as f64 - 16.0;
    let mut hash = 0;
    for i in 0..POINTS {
        for function in functions {
            let bits = function(at(2 * i), at(2 * i + 1)).to_bits();
            hash = splitmix64(hash ^ bits);
        }
    }
    hash
}

impl Planted {
    /// Puts the fault into rows: where one is enough, into those of the first lane.
    fn spoil(self, rows: &mut [Row]) {
        match (self, rows) {
            (Self::Column, [row, ..]) => row.columns[6][0] *= 1.0 + 16.0 * U,
            (Self::NotANumber, [row, ..]) => row.value[0] = f64::NAN,
            (Self::Axes, rows) => rows.iter_mut().for_each(|row| {
                row.columns.swap(3, 4);
                row.columns.swap(9, 10);
            }),
            _ => {}
        }
    }

    /// Puts it into what is judged.
    fn spoil_judged(self, first: &mut Entries<f64>) {
        let entry = first.0.iter_mut().flatten().flatten().find(|entry| entry.abs() > 0.1);
        if let Some(entry) = entry.filter(|_| self == Self::Judged) {
            *entry += 1e-6;
        }
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
            let tile = Tile::new(&four.map(|one| one.pair));
            tiles.push(tile);
            if ready.has_history {
                let increments: [Increment<f64>; LANES] = four.map(|one| one.increment);
                let mut fours = ready.fours.clone();
                let (kind, at) = (&ready.connector, (&tile, &ready.section));
                fours.follow(kind, at, &increments, [true; 6], &mut Tally::default());
                histories.push(fours.history());
                branches.extend((0..LANES).map(|lane| fours.branch(lane)));
            }
        }
        if !ready.has_history {
            histories.resize(tiles.len(), History::new(&[ready.branch; LANES]));
        }
        sections.clear();
        sections.resize(tiles.len(), ready.section);
    }

    /// Tiles turned as one, with node a at the origin, and their rows by second-order numbers. Both are exact: with U_a gone U_b is the
    /// change that every row begins with.
    fn turn(&mut self, ready: &Ready, batch: &Batch, turn: &Matrix<f64>) {
        let Self { tiles, sections, histories, turned, hessians, .. } = self;
        turned.clear();
        turned.extend(tiles.iter().map(|tile| turned_tile(tile, turn)));
        for section in sections.iter_mut() {
            section.fixed_direction = turned_vector(&section.fixed_direction, turn);
        }
        hessians.clear();
        hessians.resize(batch.rows() * turned.len(), HessianRow::default());
        let done = batch.rows_of(turned, sections, histories, hessians);
        debug_assert_eq!(done, Ok(()), "the slices have been made for each other");
        sections.fill(ready.section);
    }

    /// Rows without a batch, in the places that a batch would give them.
    fn one_by_one(&mut self, ready: &Ready) -> usize {
        let mut linear = [Linear::default(); 6];
        self.rows.clear();
        let mut rows = 0;
        for (at, drawn) in self.drawn.iter().enumerate() {
            let (tile, lane) = (at / LANES, at % LANES);
            let branch = self.branches.get(at).unwrap_or(&ready.branch);
            rows = ready.connector.linearize(&drawn.pair, branch, [true; 6], &mut linear);
            self.rows.resize((tile + 1) * rows, Row::default());
            self.flows.resize((tile + 1) * rows, [[0.0; LANES]; 2]);
            let places = self.rows.iter_mut().zip(&mut self.flows).skip(tile * rows);
            for ((place, flow), one) in places.zip(&linear) {
                (flow[0][lane], flow[1][lane]) = (one.row[PSI_A], one.row[PSI_B]);
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
        let batch = Batch::new(&connector, [true; 6]).ok();
        Self {
            subject,
            source: Source::new(definition, &connector),
            branch: connector.initial_branch(),
            is_whole: batch.is_some() || COLUMNS.iter().all(|j| connector.active()[*j]),
            winds: batch.iter().flat_map(Batch::measures).map(|(_, measure)| measure.winds()).collect(),
            batch,
            section: Section::new(&[&connector; LANES]),
            fours: Fours::new(&[&connector; LANES]),
            has_history: (0..6).any(|k| {
                let is_one_form = connector.position_measure(k).is_some_and(Measure::is_one_form);
                is_one_form || connector.row_has_history(k)
            }),
            connector,
        }
    }

    /// The value of component k as the audit has it: from where it counts, with its turns.
    ///
    /// At half a turn the sign of a zero decides between π and −π, and rounding decides that sign: the side that the history took counts.
    fn counted(&self, k: usize, value: f64, branch: &Branch<f64>) -> f64 {
        let counted = value - self.connector.origin(k).unwrap_or(0.0);
        if !self.connector.differentiated(k).is_some_and(|measure| measure.winds()) {
            return counted;
        }
        let Turns { turns, principal } = branch.turns[k];
        let crossed = if value.abs() <= PI { ((principal - value) / TAU).round() } else { 0.0 };
        f64::with_turns(counted, turns + crossed)
    }

    /// How far a state is from the nearest singular set, or from one that cannot be removed, as far as doubles can tell.
    fn distance(&self, drawn: &Drawn, branch: &Branch<f64>, stays: bool) -> f64 {
        let margins = self.connector.margins(&drawn.state(), branch, [true; 6]);
        let counts = |margin: &&Margin| !stays || margin.set.class != SingularClass::Removable;
        margins.iter().flatten().filter(counts).map(|margin| margin.distance).fold(f64::INFINITY, f64::min)
    }

    /// What a routine gives, as it is hashed.
    fn read(&self, given: &Given, due: Due) -> Read {
        let mut read = Read { hash: 0, finite: 0.0, numbers: 0 };
        for (quantity, is_due) in [(Quantity::Value, due.values), (Quantity::FirstDerivatives, due.rows)] {
            for (k, (entries, factors)) in
                given.numbers().entries(quantity).0.iter().zip(&FACTORS).enumerate()
            {
                let measure = self.connector.differentiated(k);
                let is_form = quantity == Quantity::Value && measure.is_some_and(|of| of.is_one_form());
                if entries.is_none() && is_due && due.components[k] && measure.is_some() && !is_form {
                    read.finite = f64::NAN;
                }
                let first = usize::from(quantity == Quantity::FirstDerivatives);
                for (x, factor) in entries.iter().flatten().zip(factors.iter().skip(first)) {
                    read.hash = read.hash.wrapping_add(x.to_bits().wrapping_mul(*factor));
                    read.finite += x * 0.0;
                    read.numbers += 1;
                }
            }
        }
        read
    }

    /// How far numbers of a routine are from our own, in roundings of the audit's scale; [`BESIDE`] where that has no end.
    fn apart(
        &self,
        given: &Given,
        (own, lane): (&[HessianRow], usize),
        branch: &Branch<f64>,
        length: f64,
    ) -> f64 {
        let size = |j: usize| if (j / 3).is_multiple_of(2) { length } else { 1.0 };
        let mut most = 0.0_f64;
        let mut add = |off: f64, scale: f64| most = most.max(in_units(off, scale).unwrap_or(BESIDE));
        let measures = self.batch.iter().flat_map(Batch::measures);
        for ((k, measure), HessianRow { row, hessian }) in measures.zip(own) {
            let sum = |of: &[Four; 12]| (0..12).map(|j| of[j][lane].abs() * size(j)).sum::<f64>();
            let value = self.counted(*k, row.value[lane], branch);
            let scale = row.value[lane].abs().max(value.abs()) + sum(&row.columns);
            if let Some(other) = given.numbers().entries(Quantity::Value).get(*k, 0) {
                let mut off = (value - other).abs();
                if measure.winds() {
                    off = (off - TAU * (off / TAU).round()).abs();
                }
                add(off, scale);
            }
            let Some(entries) = given.numbers().entries(Quantity::FirstDerivatives).0.get(*k) else {
                continue;
            };
            let Some(entries) = entries else { continue };
            for (place, (column, bent)) in row.columns.iter().zip(hessian).enumerate() {
                let j = COLUMNS[place];
                let own = if self.connector.active()[j] { column[lane] } else { 0.0 };
                let Some(other) = entries.get(j) else { continue };
                add((own - other).abs(), scale / size(place) + sum(bent));
            }
        }
        most
    }

    /// What 237 bits say of the numbers of a lane, and whether they are wrong.
    fn judge(
        &self,
        (drawn, branch): (&Drawn, &Branch<f64>),
        rows: &[Row],
        at: (usize, u64, Option<Planted>),
        of: &mut OfSubject,
    ) -> bool {
        let (lane, index, planted) = at;
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
                for Linear { component, value, row, .. } in linear.into_iter().take(count) {
                    values.0[component] = Some(vec![self.counted(component, value, branch)]);
                    first.0[component] = Some(row.to_vec());
                }
            }
        }
        if let Some(planted) = planted {
            planted.spoil_judged(&mut first);
        }
        let mut numbers = Numbers::default();
        numbers.set(Quantity::Value, values);
        numbers.set(Quantity::FirstDerivatives, first);
        let case = self.source.case(&of.name, index, drawn);
        of.add_judged(against_truth(&case, &numbers), index)
    }
}

/// x by lanes, turned.
fn turned_vector(x: &[Four; 3], turn: &Matrix<f64>) -> [Four; 3] {
    let mut turned = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let one = apply(turn, [x[0][lane], x[1][lane], x[2][lane]]);
        (0..3).for_each(|i| turned[i][lane] = one[i]);
    }
    turned
}

fn turned_tile(tile: &Tile, turn: &Matrix<f64>) -> Tile {
    let [a, b] = &tile.displacement;
    let change = std::array::from_fn(|i| std::array::from_fn(|lane| b[i][lane] - a[i][lane]));
    let mut turned = *tile;
    turned.reference = turned_vector(&tile.reference, turn);
    turned.displacement = [[[0.0; LANES]; 3], turned_vector(&change, turn)];
    for (to, from) in turned.triad.iter_mut().zip(&tile.triad) {
        for lane in 0..LANES {
            let one = product(turn, &from.map(|row| row.map(|x| x[lane])));
            (0..9).for_each(|at| to[at / 3][at % 3][lane] = one[at / 3][at % 3]);
        }
    }
    turned
}

impl Seen {
    fn of(rows: &[Row], flows: &[[Four; 2]], tile: &Tile, is_whole: bool) -> Self {
        let rigid = is_whole.then_some([0.0; LANES]);
        let mut seen = Self { hash: [0; LANES], finite: [0.0; LANES], rigid, frame: [None; LANES] };
        let none: [Four; 0] = [];
        for ((at, row), factors) in rows.iter().enumerate().zip(&FACTORS) {
            let flows = flows.get(at).map_or(none.as_slice(), |of| of.as_slice());
            for (column, factor) in [&row.value].into_iter().chain(&row.columns).chain(flows).zip(factors) {
                for lane in 0..LANES {
                    seen.hash[lane] =
                        seen.hash[lane].wrapping_add(column[lane].to_bits().wrapping_mul(*factor));
                    seen.finite[lane] += column[lane] * 0.0;
                }
            }
        }
        if let Some(rigid) = &mut seen.rigid {
            for (lane, rigid) in rigid.iter_mut().enumerate() {
                let d = tile.apart(lane);
                *rigid = rows.iter().fold(0.0, |most, row| most.max(left_along_rigid(&row.columns, lane, d)));
            }
        }
        seen
    }

    /// What turning both nodes as one changes, in roundings of the scale by which the audit allows errors: C of them make its bound.
    fn add_frame(
        &mut self,
        (rows, again): (&[Row], &[HessianRow]),
        turn: &Matrix<f64>,
        tile: &Tile,
        of: &Ready,
    ) {
        for (lane, frame) in self.frame.iter_mut().enumerate() {
            let length = of.source.length.max(norm(tile.apart(lane)));
            let size = |j: usize| if (j / 3).is_multiple_of(2) { length } else { 1.0 };
            let mut most = Some(0.0);
            for ((row, again), winds) in rows.iter().zip(again).zip(&of.winds) {
                let HessianRow { row: turned, hessian } = again;
                let (value, other) = (turned.value[lane], row.value[lane]);
                let sum = |of: &[Four; 12]| (0..12).map(|j| of[j][lane].abs() * size(j)).sum::<f64>();
                let scale = value.abs() + sum(&turned.columns);
                let mut off = (value - other).abs();
                if *winds {
                    off = off.min((off - TAU).abs());
                }
                let mut units = in_units(off, scale);
                for (j, bent) in hessian.iter().enumerate() {
                    let first = j / 3 * 3;
                    let own = apply(turn, [0, 1, 2].map(|i| row.columns[first + i][lane]))[j % 3];
                    let off = (turned.columns[j][lane] - own).abs();
                    units = units.zip(in_units(off, scale / size(j) + sum(bent))).map(|(a, b)| a.max(b));
                }
                most = most.zip(units).map(|(a, b): (f64, f64)| a.max(b));
            }
            *frame = most;
        }
    }
}

/// None where the scale is not finite, as at a singular point; infinite where the number is none.
fn in_units(off: f64, scale: f64) -> Option<f64> {
    let units = if off > 0.0 { off / (U * scale) } else { off };
    scale.is_finite().then(|| if units.is_nan() { f64::INFINITY } else { units })
}

/// What is left of a row along rigid motions, in roundings of what is added up.
///
/// A translation of both nodes changes nothing, and no rotation about a does: x_a + x_b = 0, to the last bit, and θ_a + θ_b + d × x_b = 0.
fn left_along_rigid(of: &[Four; 12], lane: usize, d: Vector<f64>) -> f64 {
    let column = |j: usize| of[j][lane];
    let (mut is_off, mut left, mut forces, mut moments, mut arm) = (false, 0.0_f64, 0.0, 0.0, 0.0);
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (one, other) = (d[j] * column(6 + k), d[k] * column(6 + j));
        let moment = column(3 + i) + column(9 + i) + (one - other);
        is_off |= (column(i) + column(6 + i)).abs() > 0.0;
        left = left.max(moment.abs());
        forces += column(i).abs() + column(6 + i).abs();
        moments += column(3 + i).abs() + column(9 + i).abs();
        arm += d[i].abs();
    }
    // 0/0 is not a number, and the larger of it and a number that number.
    if is_off { f64::INFINITY } else { 0.0_f64.max(left / (U * (moments + arm * forces))) }
}

impl OfSubject {
    /// Adds what 237 bits say of a state; whether anything is wrong with it.
    fn add_judged(&mut self, found: Option<AgainstTruth>, index: u64) -> bool {
        let Some(AgainstTruth { nearness, found }) = found else { return false };
        let [value, row] = &found;
        self.judged += 1;
        self.value.add(nearness, value, index);
        self.row.add(nearness, row, index);
        found.iter().any(|measured| measured.verdict.is_mismatch())
    }

    /// Adds a state; whether anything is wrong with it.
    fn add(&mut self, drawn: &Drawn, index: u64, (seen, lane): (&Seen, usize), length: f64) -> bool {
        let pair = &drawn.pair;
        *self.places.entry(drawn.place).or_default() += 1;
        let apart = (0..3).map(|i| sub(pair.a.triad[i], pair.b.triad[i]));
        self.turned.add(0.125 * apart.map(|row| dot(row, row)).sum::<f64>());
        let d = pair.separation();
        self.apart.add(dot(d, d) / (length * length));
        let is_finite = seen.finite[lane] == 0.0;
        if !is_finite {
            self.not_finite += 1;
            self.first_not_finite = Some(self.first_not_finite.map_or(index, |first| first.min(index)));
        }
        let is_rigid = seen.rigid.is_none_or(|rigid| self.rigid.add(rigid[lane], RIGID, index));
        let is_framed = seen.frame[lane].is_none_or(|frame| self.frame.add(frame, FRAME, index));
        !(is_finite && is_rigid && is_framed)
    }
}
