//! Which conventions make every entry right, and which leaves the fewest wrong.
//!
//! What a hypothesis costs is stated: each departure from pintle's own conventions some units (`space`), a wrong entry
//! [`WRONG`] of them. An order of columns, an axis and a unit decide what each block of three columns must be, whatever the rest is. So
//! blocks are matched by themselves, and only what may still be the best is put together.

use super::data::{Block, Expected, Line, Number, Right1};
use super::space::{
    Names, Order, PLACES, Reading, Units, cost_of_axes, cost_of_frame, cost_of_variation, is_rotation,
};
use crate::convention::{Angle, Axes, Frame, Positions, Storage, Variation};
use pintle_kinematics::measure::Unit;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::rc::Rc;

/// What a wrong entry costs: more than any two departures, less than four.
const WRONG: f64 = 5.0;

/// A row with another factor than units explain.
pub(super) const ODD_FACTOR: f64 = 4.0;

/// So many fits are kept.
const KEPT: usize = 20_000;

/// What was given at one state.
#[derive(Clone, Debug, Default)]
pub struct GivenRows {
    /// A list of lists as it came, null where a line was null; one list where it came flat.
    pub rows: Vec<Option<Vec<f64>>>,
    /// The values, by line.
    pub values: Option<Vec<Option<f64>>>,
    /// The rates, by line.
    pub rates: Option<Vec<Option<f64>>>,
    /// The second derivatives, by line: a matrix, row by row.
    pub second: Option<Vec<Option<Vec<f64>>>>,
    /// The nodal forces of unit forces, by line.
    pub nodal: Option<Vec<Option<Vec<f64>>>>,
}

/// The rows of all states as they were stored: by state, line, column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stored {
    pub(super) storage: Storage,
    pub(super) height: usize,
    pub(super) width: usize,
    /// The lines that hold something.
    pub(super) lines: Vec<usize>,
    entries: Vec<Vec<f64>>,
}

impl Stored {
    /// Every way in which the lists may be meant.
    pub(super) fn all(given: &[GivenRows], names: &Names) -> Vec<Self> {
        let widths = match names.hinges {
            0 => vec![14, 12, 7, 6],
            hinges => vec![14 + hinges, 12 + hinges, 14, 12],
        };
        let Some(first) = given.first() else { return Vec::new() };
        let outer = first.rows.len();
        let inner = first.rows.iter().flatten().map(Vec::len).max().unwrap_or(0);
        let same = |of: &GivenRows| {
            of.rows.len() == outer && of.rows.iter().flatten().all(|line| line.len() == inner)
        };
        if inner == 0 || !given.iter().all(same) {
            return Vec::new();
        }
        let mut found = Vec::new();
        let mut add = |storage: Storage, height: usize, width: usize| {
            if !(1..=names.height).contains(&height)
                || !widths.contains(&width)
                || height * width != outer * inner
            {
                return;
            }
            let place = |i: usize, j: usize| match storage {
                Storage::Rows => i * width + j,
                Storage::Columns => j * height + i,
            };
            let of = |given: &GivenRows| {
                let flat: Vec<f64> = given
                    .rows
                    .iter()
                    .flat_map(|line| line.clone().unwrap_or_else(|| vec![0.0; inner]))
                    .collect();
                (0..height * width).map(|n| flat[place(n / width, n % width)]).collect::<Vec<f64>>()
            };
            let entries: Vec<Vec<f64>> = given.iter().map(of).collect();
            let holds =
                |i: &usize| entries.iter().any(|of| of[i * width..(i + 1) * width].iter().any(|x| *x != 0.0));
            let lines = (0..height).filter(holds).collect();
            found.push(Self { storage, height, width, lines, entries });
        };
        if outer == 1 && inner > 16 {
            for width in widths.clone() {
                for storage in [Storage::Rows, Storage::Columns] {
                    add(storage, inner / width, width);
                }
            }
        } else {
            add(Storage::Rows, outer, inner);
            add(Storage::Columns, inner, outer);
        }
        found
    }

    /// An entry.
    pub(super) fn get(&self, state: usize, line: usize, column: usize) -> f64 {
        self.entries[state][line * self.width + column]
    }
}

/// What a line of the routine is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Matched {
    /// Where the routine has it.
    pub(super) line: usize,
    /// Which of the expected lines it is.
    pub(super) of: usize,
    pub(super) is: Line,
    /// ±1, or an odd factor.
    pub(super) factor: f64,
}

/// A convention that was found, with what it leaves wrong.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fit {
    pub(super) names: Names,
    pub(super) reading: Reading,
    pub(super) axes: Axes,
    pub(super) storage: Storage,
    pub(super) height: usize,
    pub(super) order: Order,
    pub(super) units: Units,
    pub(super) frame: Frame,
    pub(super) variations: [Variation; 2],
    pub(super) positions: Positions,
    pub(super) lines: Vec<Matched>,
    /// Entries that are wrong under it, in rows, values and rates.
    pub(super) wrong: usize,
    pub(super) cost: f64,
}

impl Fit {
    /// What it costs with its wrong entries.
    pub(super) fn total(&self) -> f64 {
        self.cost + WRONG * self.wrong as f64
    }

    /// The factor of an entry.
    pub(super) fn factor(&self, matched: &Matched, place: usize) -> f64 {
        matched.factor * self.units.of_entry(matched.is.unit, is_rotation(place))
    }

    /// What an entry of a line must be, but for [`Fit::factor`].
    pub(super) fn entry(&self, right: &Right1, place: usize) -> Number {
        if PLACES.contains(&place) {
            return right.row.by(place);
        }
        let (end, of) = (place / 7, place % 7);
        match of {
            0..=2 => right.row.displacements[end][index(&Frame::ALL, self.frame)][of],
            _ => right.row.rotations[end][index(&Variation::ALL, self.variations[end])][of - 3],
        }
    }
}

/// The place of one of a list.
pub(super) fn index<T: PartialEq>(all: &[T], one: T) -> usize {
    all.iter().position(|of| *of == one).unwrap_or(0)
}

/// The conventions found so far.
#[derive(Clone, Debug)]
pub(super) struct Fits {
    pub(super) all: Vec<Fit>,
    /// The least total so far.
    best: f64,
    /// Whether there were more than are kept.
    pub(super) is_cut: bool,
}

impl Default for Fits {
    fn default() -> Self {
        Self { all: Vec::new(), best: f64::INFINITY, is_cut: false }
    }
}

impl Fits {
    fn add(&mut self, fit: Fit) {
        let is_best = fit.total() < self.best;
        self.best = self.best.min(fit.total());
        if self.all.len() >= KEPT {
            self.is_cut = true;
            if !is_best {
                return;
            }
            // What is wrong somewhere is worse than this one, and would not stay.
            self.all.retain(|known| known.wrong == 0);
        }
        self.all.push(fit);
    }

    /// Without what is neither right throughout nor the simplest.
    pub(super) fn settle(&mut self) {
        let best = self.best;
        self.all.retain(|fit| fit.wrong == 0 || fit.total() <= best);
        self.all.sort_by(|one, other| one.total().total_cmp(&other.total()));
    }
}

const UNITS: [Unit; 3] = [Unit::Length, Unit::Angle, Unit::None];

/// How the entries of a block are off.
fn misses(block: &Block, factor: f64, got: [f64; 3]) -> [bool; 3] {
    [0, 1, 2].map(|i| !block[i].is(got[i], factor))
}

/// The units that the sizes of the entries allow.
fn units(stored: &Stored, expected: &Expected) -> Vec<Units> {
    /// Of those that nothing tells apart, and of those that few entries speak for.
    const FACTORS: usize = 6;
    // By kind of row and column: the sizes that are right, and the factors for which some entry speaks.
    let mut allowed: Vec<Option<Vec<f64>>> = Vec::new();
    let mut got: Vec<f64> = Vec::new();
    for state in &stored.entries {
        got.extend(state.iter().map(|x| x.abs()).filter(|x| *x > 0.0));
    }
    for unit in UNITS {
        for is_rotation in [false, true] {
            let mut right: Vec<f64> = Vec::new();
            for of_state in &expected.at {
                for (line, of) in expected.lines.iter().zip(of_state) {
                    if line.unit != unit {
                        continue;
                    }
                    let blocks: Vec<&Block> = if is_rotation {
                        of.row.rotations.iter().flatten().collect()
                    } else {
                        of.row.displacements.iter().flatten().collect()
                    };
                    let telling = blocks.into_iter().flatten().filter(|number| !number.tells_nothing());
                    right.extend(telling.map(|number| number.x.abs()));
                }
            }
            right.sort_unstable_by(f64::total_cmp);
            right.dedup();
            if right.is_empty() {
                allowed.push(None);
                continue;
            }
            let mut factors: Vec<f64> = Units::all().map(|units| units.of_entry(unit, is_rotation)).collect();
            factors.sort_by(f64::total_cmp);
            factors.dedup_by(|one, other| (*one / *other - 1.0).abs() < 1e-12);
            let speak = |factor: &f64| {
                let is_near = |x: &&f64| {
                    let want = **x / factor;
                    let at = right.partition_point(|of| *of < want * (1.0 - 1e-9));
                    right.get(at).is_some_and(|of| *of <= want * (1.0 + 1e-9))
                };
                got.iter().filter(is_near).count()
            };
            let mut voted: Vec<(usize, f64)> =
                factors.into_iter().map(|factor| (speak(&factor), factor)).collect();
            voted.retain(|(votes, _)| *votes > 0);
            voted.sort_by(|one, other| other.0.cmp(&one.0).then(one.1.total_cmp(&other.1)));
            let most = voted.first().map_or(0, |(votes, _)| *votes);
            voted.retain(|(votes, _)| 3 * votes >= most);
            voted.truncate(FACTORS);
            allowed.push(Some(voted.into_iter().map(|(_, factor)| factor).collect()));
        }
    }
    let is_allowed = |units: &Units| {
        let kinds = UNITS.into_iter().flat_map(|unit| [false, true].map(|is_rotation| (unit, is_rotation)));
        kinds.zip(&allowed).all(|((unit, is_rotation), allowed)| {
            allowed.as_ref().is_none_or(|factors| {
                // Where no entry speaks for any, none is refused.
                let factor = units.of_entry(unit, is_rotation);
                factors.is_empty() || factors.iter().any(|of| (of / factor - 1.0).abs() < 1e-12)
            })
        })
    };
    Units::all().filter(is_allowed).collect()
}

/// How many entries are the multiple, by some units, of no entry that is right in any form.
fn unexplained(stored: &Stored, expected: &Expected, all: &[Units]) -> usize {
    let mut factors: Vec<(Unit, bool, f64)> = Vec::new();
    for units in all {
        for unit in UNITS {
            for is_rotation in [false, true] {
                let factor = units.of_entry(unit, is_rotation);
                let is_known =
                    |known: &(Unit, bool, f64)| (known.0, known.1, known.2) == (unit, is_rotation, factor);
                if !factors.iter().any(is_known) {
                    factors.push((unit, is_rotation, factor));
                }
            }
        }
    }
    let (Some(right), Some(got)) = (expected.at.first(), stored.entries.first()) else { return 0 };
    // By kind of row and column: the sizes that are right.
    let mut sizes: Vec<f64> = Vec::new();
    for (unit, is_rotation, factor) in factors {
        for (_, of) in expected.lines.iter().zip(right).filter(|(line, _)| line.unit == unit) {
            let row = &of.row;
            if is_rotation {
                sizes.extend(row.rotations.iter().flatten().flatten().map(|number| number.x.abs() * factor));
                sizes.extend(row.single[2..].iter().map(|number| number.x.abs() * factor));
            } else {
                sizes.extend(
                    row.displacements.iter().flatten().flatten().map(|number| number.x.abs() * factor),
                );
                sizes.extend(row.single[..2].iter().map(|number| number.x.abs() * factor));
            }
        }
    }
    sizes.sort_unstable_by(f64::total_cmp);
    let largest = sizes.last().copied().unwrap_or(0.0);
    let is_unexplained = |x: &&f64| {
        let x = x.abs();
        if x.is_nan() {
            return true;
        }
        // What is nearly zero is told by its tolerance alone.
        if x <= 1e-6 * largest {
            return false;
        }
        let at = sizes.partition_point(|of| *of < x * (1.0 - 1e-6));
        !sizes.get(at).is_some_and(|of| *of <= x * (1.0 + 1e-6))
    };
    got.iter().filter(is_unexplained).count()
}

/// Puts together what fits.
pub(super) struct Search<'a> {
    pub(super) names: Names,
    pub(super) given: &'a [GivenRows],
    pub(super) fits: Fits,
    /// So many entries may be wrong.
    pub(super) most: usize,
}

/// How many entries of a line would be wrong, were it this line with this sign: of every form of every block.
#[derive(Clone, Debug)]
struct Tally {
    displacements: [[u8; Frame::ALL.len()]; 2],
    rotations: [[u8; Variation::ALL.len()]; 2],
    single: u8,
}

impl Tally {
    /// The least that is wrong.
    fn least(&self) -> usize {
        let least = |of: &[u8]| usize::from(of.iter().copied().min().unwrap_or(0));
        let frames = (0..Frame::ALL.len())
            .map(|n| usize::from(self.displacements[0][n]) + usize::from(self.displacements[1][n]));
        frames.min().unwrap_or(0)
            + least(&self.rotations[0])
            + least(&self.rotations[1])
            + usize::from(self.single)
    }

    fn of(&self, frame: usize, variations: [usize; 2]) -> usize {
        [0, 1]
            .map(|end| {
                usize::from(self.displacements[end][frame])
                    + usize::from(self.rotations[end][variations[end]])
            })
            .into_iter()
            .sum::<usize>()
            + usize::from(self.single)
    }
}

/// How many forms a block has at most.
const FORMS: usize = Variation::ALL.len();

/// What orders share: by expected line and sign, the wrong entries of each form.
type Shared = Rc<Vec<[u8; FORMS]>>;

/// How many entries of a line in three columns are wrong, were they that block: by expected line and sign, then by form. Orders share them,
/// and most are refused at their first line.
struct Blocks<'a> {
    stored: &'a Stored,
    expected: &'a Expected,
    units: Units,
    known: HashMap<(usize, usize, [usize; 3]), Shared>,
    single: HashMap<(usize, usize, usize), Rc<Vec<u8>>>,
}

impl Blocks<'_> {
    /// Of a line, the block that begins at a place of pintle's, in these columns; nothing is wrong where it is left out.
    fn of(&mut self, line: usize, first: usize, columns: [usize; 3]) -> Shared {
        if let Some(known) = self.known.get(&(line, first, columns)) {
            return Rc::clone(known);
        }
        let (end, is_rotation) = (first / 7, first % 7 == 3);
        let mut found = Vec::with_capacity(2 * self.expected.lines.len());
        for (l, is) in self.expected.lines.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let factor = sign * self.units.of_entry(is.unit, is_rotation);
                let mut wrong = [[false; 3]; FORMS];
                if columns[0] != usize::MAX {
                    for (state, of) in self.expected.at.iter().enumerate() {
                        let got = columns.map(|column| self.stored.get(state, line, column));
                        let row = &of[l].row;
                        let forms: &[Block] =
                            if is_rotation { &row.rotations[end] } else { &row.displacements[end] };
                        for (wrong, block) in wrong.iter_mut().zip(forms) {
                            let off = misses(block, factor, got);
                            *wrong = [0, 1, 2].map(|i| wrong[i] || off[i]);
                        }
                        if wrong[..forms.len()].iter().flatten().all(|is_wrong| *is_wrong) {
                            break;
                        }
                    }
                }
                found.push(wrong.map(|wrong| wrong.into_iter().map(u8::from).sum()));
            }
        }
        let found = Rc::new(found);
        self.known.insert((line, first, columns), Rc::clone(&found));
        found
    }

    /// The same of a flow or the angle of a hinge.
    fn of_single(&mut self, line: usize, place: usize, column: usize) -> Rc<Vec<u8>> {
        if let Some(known) = self.single.get(&(line, place, column)) {
            return Rc::clone(known);
        }
        let mut found = Vec::with_capacity(2 * self.expected.lines.len());
        for (l, is) in self.expected.lines.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let factor = sign * self.units.of_entry(is.unit, is_rotation(place));
                let is_off = |(state, of): (usize, &Vec<Right1>)| {
                    !of[l].row.by(place).is(self.stored.get(state, line, column), factor)
                };
                let is_wrong = column != usize::MAX && self.expected.at.iter().enumerate().any(is_off);
                found.push(u8::from(is_wrong));
            }
        }
        let found = Rc::new(found);
        self.single.insert((line, place, column), Rc::clone(&found));
        found
    }
}

impl Search<'_> {
    /// Adds what fits where orientations are read, vectors resolved and rows stored in one way.
    pub(super) fn add(&mut self, stored: &Stored, expected: &Expected, reading: Reading, axes: Axes) {
        let base = cost_of_axes(axes)
            + if reading == Reading::Right { 0.0 } else { 2.0 }
            + if stored.storage == Storage::Rows { 0.0 } else { 1.0 };
        let said = &expected.said;
        let mut all_units = units(stored, expected);
        all_units.retain(|units| {
            let has = |unit: Unit| expected.lines.iter().any(|line| line.unit == unit);
            (said.displacements || said.flows || units.column_length == 1.0)
                && (has(Unit::Length) || units.row_length == 1.0)
                && (has(Unit::Angle) || units.row_angle == Angle::Radian)
                && (said.rotations.contains(&true) || said.hinges || units.column_angle == Angle::Radian)
        });
        if unexplained(stored, expected, &all_units) > self.budget(base) {
            return;
        }
        let mut alike: Vec<(Units, Vec<Units>)> = Vec::new();
        for units in all_units {
            let same = |known: &Units| {
                UNITS.into_iter().filter(|unit| expected.lines.iter().any(|line| line.unit == *unit)).all(
                    |unit| {
                        [false, true].into_iter().all(|is_rotation| {
                            (known.of_entry(unit, is_rotation) / units.of_entry(unit, is_rotation) - 1.0)
                                .abs()
                                < 1e-12
                        })
                    },
                )
            };
            match alike.iter_mut().find(|(known, _)| same(known)) {
                Some((_, all)) => all.push(units),
                None => alike.push((units, vec![units])),
            }
        }
        let orders = Order::all(stored.width, self.names.hinges);
        for (units, all) in &alike {
            let cheapest = all.iter().map(Units::cost).fold(f64::INFINITY, f64::min);
            if unexplained(stored, expected, &[*units]) > self.budget(base + cheapest) {
                continue;
            }
            let (known, single) = (HashMap::new(), HashMap::new());
            let mut blocks = Blocks { stored, expected, units: *units, known, single };
            for order in &orders {
                let cost = base + order.cost + cheapest;
                let Some(tallies) = self.tallies(&mut blocks, order, cost) else { continue };
                self.together(stored, expected, (reading, axes), order, all, &tallies, base);
            }
        }
    }

    /// How many entries may be wrong where the rest costs so much, that it is still among the best.
    fn budget(&self, cost: f64) -> usize {
        let left = (self.fits.best - cost) / WRONG;
        if left < self.most as f64 { left.max(0.0) as usize } else { self.most }
    }

    /// Of each given line, by expected line and sign; `None` where more is wrong, whatever the rest is, than may be.
    fn tallies(&self, blocks: &mut Blocks<'_>, order: &Order, cost: f64) -> Option<Vec<Vec<[Tally; 2]>>> {
        let budget = self.budget(cost);
        let mut at = [usize::MAX; 16];
        for (column, place) in order.places.iter().enumerate() {
            at[*place] = column;
        }
        let columns = |first: usize| [0, 1, 2].map(|i| at[first + i]);
        let expected = blocks.expected.lines.len();
        let (mut least, mut found) = (0_usize, Vec::new());
        for line in &blocks.stored.lines {
            let parts = [0, 3, 7, 10].map(|first| blocks.of(*line, first, columns(first)));
            let single = PLACES.map(|place| blocks.of_single(*line, place, at[place]));
            let mut best = usize::MAX;
            let of_line: Vec<[Tally; 2]> = (0..expected)
                .map(|l| {
                    [0, 1].map(|sign| {
                        let n = 2 * l + sign;
                        let frames = |part: &[[u8; FORMS]]| [0, 1, 2, 3].map(|m| part[n][m]);
                        let tally = Tally {
                            displacements: [frames(&parts[0]), frames(&parts[2])],
                            rotations: [parts[1][n].map(|x| x), parts[3][n].map(|x| x)],
                            single: single.iter().map(|of| of[n]).sum(),
                        };
                        best = best.min(tally.least());
                        tally
                    })
                })
                .collect();
            least = least.saturating_add(best);
            if least > budget {
                return None;
            }
            found.push(of_line);
        }
        Some(found)
    }

    /// Every frame, variation and assignment of lines that is right throughout or may be the best.
    #[expect(clippy::too_many_arguments, reason = "what a fit is made of")]
    fn together(
        &mut self,
        stored: &Stored,
        expected: &Expected,
        (reading, axes): (Reading, Axes),
        order: &Order,
        alike: &[Units],
        tallies: &[Vec<[Tally; 2]>],
        base: f64,
    ) {
        let cheapest = alike.iter().map(Units::cost).fold(f64::INFINITY, f64::min);
        let said = &expected.said;
        for (f, frame) in Frame::ALL.into_iter().enumerate().filter(|(f, _)| *f == 0 || said.displacements) {
            // How orientations are read is no matter where none is looked at.
            if reading != Reading::Right && !said.turns && frame == Frame::Global {
                continue;
            }
            for (m, one) in
                Variation::ALL.into_iter().enumerate().filter(|(m, _)| *m == 0 || said.rotations[0])
            {
                for (n, other) in
                    Variation::ALL.into_iter().enumerate().filter(|(n, _)| *n == 0 || said.rotations[1])
                {
                    // A node without rotational columns goes with the other.
                    let (one, other) = match said.rotations {
                        [true, false] => (one, one),
                        [false, true] => (other, other),
                        _ => (one, other),
                    };
                    let of_variations = if one == other {
                        cost_of_variation(one)
                    } else {
                        cost_of_variation(one) + cost_of_variation(other) + 1.0
                    };
                    let cost = base + order.cost + cost_of_frame(frame) + of_variations;
                    let budget = self.budget(cost + cheapest);
                    let least = |of_line: &Vec<[Tally; 2]>| {
                        of_line.iter().flatten().map(|tally| tally.of(f, [m, n])).min().unwrap_or(0)
                    };
                    if tallies.iter().map(least).sum::<usize>() > budget {
                        continue;
                    }
                    let mut chosen = Vec::new();
                    let mut found: Vec<(usize, Vec<(usize, usize)>)> = Vec::new();
                    choose(tallies, expected, (f, [m, n]), (0, budget), &mut chosen, &mut found);
                    let fewest = found.iter().map(|(wrong, _)| *wrong).min().unwrap_or(0);
                    for (wrong, choice) in found.into_iter().filter(|(wrong, _)| *wrong == fewest) {
                        let lines: Vec<Matched> = stored
                            .lines
                            .iter()
                            .zip(choice)
                            .map(|(line, (l, sign))| Matched {
                                line: *line,
                                of: l,
                                is: expected.lines[l],
                                factor: [1.0, -1.0][sign],
                            })
                            .collect();
                        let names = self.names;
                        let of_lines = cost_of_lines(&lines, stored.height == names.height);
                        let fit = |units: &Units, positions: Positions| Fit {
                            names,
                            reading,
                            axes,
                            storage: stored.storage,
                            height: stored.height,
                            order: order.clone(),
                            units: *units,
                            frame,
                            variations: [one, other],
                            positions,
                            lines: lines.clone(),
                            wrong,
                            cost: cost
                                + of_lines
                                + units.cost()
                                + if positions == Positions::Displacement { 0.0 } else { 0.5 },
                        };
                        self.with_values(alike, expected, &fit);
                    }
                }
            }
        }
    }

    /// The units and kinds of values that the values and rates allow.
    fn with_values(&mut self, alike: &[Units], expected: &Expected, fit: &dyn Fn(&Units, Positions) -> Fit) {
        for units in alike {
            for (n, positions) in Positions::ALL.into_iter().enumerate() {
                let mut fit = fit(units, positions);
                let wrong = self.wrong_values(&fit, expected, n);
                // Where kinds are the same numbers, the plainer one is meant; without values, the plainest.
                let numbers =
                    |n: usize| expected.at.iter().flatten().map(move |of| of.values[n].map(|value| value.x));
                let is_plainer = |m: usize| numbers(n).eq(numbers(m));
                let has_values = self.given.iter().any(|of| of.values.is_some());
                if n > 0 && (!has_values || numbers(n).all(|x| x.is_none()) || (0..n).any(is_plainer)) {
                    continue;
                }
                fit.wrong += wrong;
                if fit.wrong == 0 || fit.total() <= self.fits.best {
                    self.fits.add(fit);
                }
            }
        }
    }

    /// How many values and rates are wrong under a fit.
    pub(super) fn wrong_values(&self, fit: &Fit, expected: &Expected, positions: usize) -> usize {
        let of_value = |matched: &&Matched| {
            let factor = matched.factor * fit.units.of_value(matched.is.unit);
            self.given.iter().zip(&expected.at).any(|(given, of)| {
                let got = given.values.as_ref().and_then(|values| values.get(matched.line).copied().flatten());
                let want = of[matched.of].values[positions];
                matches!((got, want), (Some(got), Some(want)) if !is_value(&want, got, factor, matched.is.unit))
            })
        };
        let of_rate = |matched: &&Matched| {
            let factor = matched.factor * fit.units.of_value(matched.is.unit);
            self.given.iter().zip(&expected.at).any(|(given, of)| {
                let got = given.rates.as_ref().and_then(|rates| rates.get(matched.line).copied().flatten());
                matches!((got, of[matched.of].rate), (Some(got), Some(want)) if !want.is(got, factor))
            })
        };
        fit.lines.iter().filter(of_value).count() + fit.lines.iter().filter(of_rate).count()
    }
}

/// Whether a value is right, but for whole turns of an angle.
pub(super) fn is_value(want: &Number, got: f64, factor: f64, unit: Unit) -> bool {
    if want.is(got, factor) {
        return true;
    }
    let turns = ((got / factor - want.x) / TAU).round();
    unit == Unit::Angle && turns != 0.0 && {
        let turned = Number { x: want.x + TAU * turns, off: want.off + 1e-15 * (TAU * turns).abs() };
        turned.is(got, factor)
    }
}

/// What the lines cost: another order, signs, angles in place of cosines.
fn cost_of_lines(lines: &[Matched], is_whole: bool) -> f64 {
    let is_in_place = lines.iter().all(|of| is_whole && of.line == of.is.k);
    let is_in_order = lines.windows(2).all(|pair| pair[0].is.k < pair[1].is.k);
    let order = if is_in_place {
        0.0
    } else if is_in_order {
        0.5
    } else {
        2.0
    };
    let minus = lines.iter().filter(|of| of.factor < 0.0).count();
    let signs = if minus == lines.len() { minus.min(1) } else { minus };
    let angles = lines.iter().filter(|of| of.is.is_as_angle).count();
    order + signs as f64 + 2.0 * angles as f64
}

/// Every assignment of given lines to expected ones that leaves no more wrong than the budget, each with what it leaves wrong.
fn choose(
    tallies: &[Vec<[Tally; 2]>],
    expected: &Expected,
    form: (usize, [usize; 2]),
    (wrong, budget): (usize, usize),
    chosen: &mut Vec<(usize, usize)>,
    found: &mut Vec<(usize, Vec<(usize, usize)>)>,
) {
    let Some(of_line) = tallies.get(chosen.len()) else {
        let fewest = found.iter().map(|(wrong, _)| *wrong).min().unwrap_or(usize::MAX);
        if wrong < fewest {
            found.clear();
        }
        if wrong <= fewest && found.len() < KEPT {
            found.push((wrong, chosen.clone()));
        }
        return;
    };
    let fewest = found.iter().map(|(wrong, _)| *wrong).min().unwrap_or(usize::MAX);
    let budget = budget.min(fewest);
    // What the lines after this one leave wrong at least.
    let least = |of_line: &Vec<[Tally; 2]>| {
        of_line.iter().flatten().map(|tally| tally.of(form.0, form.1)).min().unwrap_or(0)
    };
    let rest: usize = tallies[chosen.len() + 1..].iter().map(least).sum();
    let mut options: Vec<(usize, usize, usize)> = Vec::new();
    for (l, signs) in of_line.iter().enumerate() {
        let k = expected.lines[l].k;
        if chosen.iter().any(|(other, _)| expected.lines[*other].k == k) {
            continue;
        }
        for (sign, tally) in signs.iter().enumerate() {
            options.push((tally.of(form.0, form.1), l, sign));
        }
    }
    options.sort_unstable();
    for (more, l, sign) in options {
        let wrong = wrong.saturating_add(more);
        let fewest = found.iter().map(|(wrong, _)| *wrong).min().unwrap_or(usize::MAX);
        if wrong.saturating_add(rest) > budget.min(fewest) || found.len() >= KEPT {
            break;
        }
        chosen.push((l, sign));
        choose(tallies, expected, form, (wrong, budget), chosen, found);
        chosen.pop();
    }
}
