//! Rows to rows: states from arrays as users have them, values and rows into arrays that they give.

use crate::batch::kernel::Slices;
use crate::batch::layout::CompactRow;
use crate::batch::tile::Four;
use crate::batch::unit::{Any, Unit};
use crate::batch::{Batch, BatchError, History, Layout, Section, Tile, same_length};
use crate::measure::Measure;
use crate::node::{Dependence, Node, Pair};
use crate::scalar::elementary::norm_and_direction;
use crate::scalar::lanes::{LANES, Lanes};
use crate::scalar::{Real, Scalar};
use crate::so3;
use crate::vector::{Matrix, product};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Numbers of many states, where they lie: those of state s begin at number s · stride.
#[derive(Clone, Copy, Debug)]
pub struct Array<'a> {
    numbers: &'a [f64],
    stride: usize,
}

impl<'a> Array<'a> {
    /// Numbers whose states begin `stride` numbers apart: 3 for positions that stand one after the other.
    pub const fn new(numbers: &'a [f64], stride: usize) -> Self {
        Self { numbers, stride }
    }

    /// Numbers that all states share.
    pub const fn shared(numbers: &'a [f64]) -> Self {
        Self { numbers, stride: 0 }
    }

    /// The first N numbers of a state.
    pub(super) fn at<const N: usize>(self, state: usize) -> Option<&'a [f64; N]> {
        self.numbers.get(state.checked_mul(self.stride)?..)?.first_chunk::<N>()
    }

    /// The states named, in whole tiles: where they lie, if they stand one after the other, else copied into `room`. Beyond the
    /// last stands the last again.
    fn taken<'b, const N: usize>(self, states: &Range<usize>, room: &'b mut Vec<[f64; N]>) -> &'b [[f64; N]]
    where
        'a: 'b,
    {
        if self.stride == N
            && states.len().is_multiple_of(LANES)
            && let Some(numbers) = self.numbers.get(states.start * N..states.end * N)
        {
            return numbers.as_chunks::<N>().0;
        }
        let at = |s: usize| self.at(s.min(states.end - 1)).copied().unwrap_or([f64::NAN; N]);
        room.clear();
        room.extend((states.start..states.start + states.len().next_multiple_of(LANES)).map(at));
        room
    }

    /// Whether there are `width` numbers for each of `count` states.
    pub(super) fn check(self, what: &'static str, count: usize, width: usize) -> Result<(), BatchError> {
        let expected = match count.checked_sub(1) {
            None => 0,
            Some(last) => last.saturating_mul(self.stride).saturating_add(width),
        };
        let found = self.numbers.len();
        if found >= expected { Ok(()) } else { Err(BatchError::Length { what, found, expected }) }
    }
}

/// How the directions of a node are given.
#[derive(Clone, Copy, Debug)]
pub enum Orientation<'a> {
    /// The triad T: nine numbers, row by row, a local direction a column.
    Triad(Array<'a>),
    /// The local directions one after the other: nine numbers, the rows of Tᵀ.
    Directions(Array<'a>),
    /// The turn since the initial state as a quaternion w, x, y, z, and the initial triad T₀: T = R(q/‖q‖) T₀. Any length will do
    /// between 1e−300 and 1e300; zero gives NaN.
    Quaternion(Array<'a>, Matrix<f64>),
    /// The turn as a rotation vector (rad), and the initial triad T₀: T = exp(φ^) T₀.
    RotationVector(Array<'a>, Matrix<f64>),
}

impl<'a> Orientation<'a> {
    /// The numbers given, and how many there are of a state.
    const fn array(self) -> (Array<'a>, usize) {
        match self {
            Self::Triad(array) | Self::Directions(array) => (array, 9),
            Self::Quaternion(array, _) => (array, 4),
            Self::RotationVector(array, _) => (array, 3),
        }
    }
}

/// One node in many states.
#[derive(Clone, Copy, Debug)]
pub struct Nodes<'a> {
    /// u, or the position x where the reference is zero (length), three numbers.
    pub displacement: Array<'a>,
    /// The local directions.
    pub orientation: Orientation<'a>,
}

/// Many states of one connector, or of connectors that share a [`Batch`].
#[derive(Clone, Copy, Debug)]
pub struct States<'a> {
    /// How many.
    pub count: usize,
    /// X_b − X_a (length), three numbers.
    pub reference: Array<'a>,
    /// a and b.
    pub nodes: [Nodes<'a>; 2],
    /// The connectors' data: one for all states, or one for each four.
    pub sections: &'a [Section],
    /// What the past decides: one for all states, or one for each four.
    pub histories: &'a [History],
}

impl States<'_> {
    /// Whether there are as many numbers as it says.
    pub(super) fn check(&self) -> Result<(), BatchError> {
        let (count, tiles) = (self.count, self.count.div_ceil(LANES));
        self.reference.check("numbers of the reference", count, 3)?;
        for Nodes { displacement, orientation } in self.nodes {
            displacement.check("numbers of displacements", count, 3)?;
            let (array, width) = orientation.array();
            array.check("numbers of rotations", count, width)?;
        }
        for (what, found) in [("sections", self.sections.len()), ("histories", self.histories.len())] {
            if found != 1 {
                same_length(what, found, tiles)?;
            }
        }
        Ok(())
    }

    /// The nodes of a state; NaN where an array ends before it.
    pub fn pair(&self, state: usize) -> Pair<f64> {
        let three = |array: Array<'_>| array.at(state).copied().unwrap_or([f64::NAN; 3]);
        let mut tile = [STILL];
        let mut rooms = [Room::default(), Room::default()];
        for (end, room) in rooms.iter_mut().enumerate() {
            let turned = self.nodes[end].orientation.taken(&(state..state + 1), room);
            on_unit(Arch::Scalar, FillTriads { turned, end, tiles: &mut tile });
        }
        let [Tile { triad, .. }] = &tile;
        let node = |end: usize| Node {
            displacement: three(self.nodes[end].displacement),
            triad: triad[end].map(|row| row.map(|of| of[0])),
            flow: 0.0,
        };
        Pair { reference: three(self.reference), a: node(0), b: node(1) }
    }
}

/// Which columns of a row are written.
#[derive(Clone, Copy, Debug)]
pub enum Columns<'a> {
    /// x_a, θ_a, x_b, θ_b.
    Twelve,
    /// All of [`crate::node::DOF`]: those of material flow are zero.
    Fourteen,
    /// Those that may differ from zero, row after row, as the values of a sparse matrix by rows: [`Batch::pattern`] names them.
    Sparse,
    /// Those whose places among the twelve are named, in this order. [`COMPACT`] leaves out x_a, the opposite of x_b.
    Chosen(&'a [usize]),
}

/// The columns θ_a, x_b, θ_b.
pub const COMPACT: [usize; 9] = [3, 4, 5, 6, 7, 8, 9, 10, 11];

/// How many tiles are computed and written at a time: they stay in the first cache with their rows.
pub(super) const TILES: usize = 8;
/// How many states are read before any is computed.
const AT_ONCE: usize = 64;
/// Of more states than the second cache holds with their rows, longer parts of their arrays are read at a time.
const MANY: usize = 16_384;
const AT_ONCE_OF_MANY: usize = 2048;

/// How many of `count` states are read at a time.
const fn at_once(count: usize) -> usize {
    if count < MANY { AT_ONCE } else { AT_ONCE_OF_MANY }
}

/// Twelve columns.
type Dense = [f64; 12];
/// The place of a column that is none of them.
const NONE: usize = 12;
/// The columns and it.
const PLACES: usize = NONE + 1;
const TWELVE: [usize; 12] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
/// Those of fourteen columns: of material flow there is none.
const FOURTEEN: [usize; 14] = [0, 1, 2, 3, 4, 5, NONE, 6, 7, 8, 9, 10, 11, NONE];

impl Batch {
    /// The columns (of twelve) that may differ from zero, row by row.
    pub fn pattern(&self) -> Vec<Vec<usize>> {
        let of = |measure: &Measure| {
            let needed = measure.dependence();
            let turning = measure.turns_with_a();
            let is_there = [needed.translation, turning, needed.translation, needed.rotation];
            (0..12).filter(|j| is_there[j / 3]).collect()
        };
        self.measures().iter().map(|(_, measure)| of(measure)).collect()
    }

    /// How many numbers of rows a state has.
    pub fn width(&self, columns: Columns<'_>) -> usize {
        match columns {
            Columns::Twelve => 12 * self.rows(),
            Columns::Fourteen => 14 * self.rows(),
            Columns::Chosen(places) => places.len() * self.rows(),
            Columns::Sparse => self.pattern().iter().map(Vec::len).sum(),
        }
    }

    /// Values and rows of many states, into memory of the caller, in C order: those of [`Batch::rows_of`], bit by bit where triads are
    /// given but for the sign of zeros.
    ///
    /// - `values` (count, [`Batch::rows`]): lengths, and angles (rad), principal but for what the histories say
    /// - `rows` (count, [`Batch::width`]): ∂value/∂x (global components) and ∂value/∂θ, with C(new) = exp(δθ^) C
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use pintle_kinematics::batch::{Array, Batch, Columns, History, Nodes, Orientation, Section, States};
    /// use pintle_kinematics::catalog::ConnectionType;
    /// use pintle_kinematics::connector::{Connector, Definition};
    /// use pintle_kinematics::node::{Node, Pair};
    /// use pintle_kinematics::vector::identity;
    ///
    /// // A REVOLUTE between a fixed node a and a node b that turns about e1.
    /// let still = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    /// let initial = Pair { reference: [0.0; 3], a: still, b: still };
    /// let connector = Connector::new(&Definition::new(ConnectionType::named("REVOLUTE", None)?, initial));
    /// let batch = Batch::new(&connector, [true; 6])?;
    /// let turns = [0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0];
    /// let (origin, triad) = ([0.0; 3], [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    /// let states = States {
    ///     count: 3,
    ///     reference: Array::shared(&origin),
    ///     nodes: [
    ///         Nodes { displacement: Array::shared(&origin), orientation: Orientation::Triad(Array::shared(&triad)) },
    ///         Nodes {
    ///             displacement: Array::shared(&origin),
    ///             orientation: Orientation::RotationVector(Array::new(&turns, 3), identity()),
    ///         },
    ///     ],
    ///     sections: &[Section::new(&[&connector; 4])],
    ///     histories: &[History::new(&[connector.initial_branch(); 4])],
    /// };
    /// let (mut values, mut rows) = (vec![0.0; 3 * batch.rows()], vec![0.0; 3 * batch.width(Columns::Twelve)]);
    /// batch.rows_of_states(&states, Columns::Twelve, &mut values, &mut rows)?;
    /// assert!((values[3] - 0.5).abs() < 4e-16); // ur1 of the second state
    /// assert!((rows[3 * 12 + 9] - 1.0).abs() < 4e-16); // ∂ur1/∂θb1
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BatchError::Length`] where an array is too short, or `values` or `rows` have another length; [`BatchError::Column`] for a
    /// place beyond the twelve.
    pub fn rows_of_states(
        &self,
        states: &States<'_>,
        columns: Columns<'_>,
        values: &mut [f64],
        rows: &mut [f64],
    ) -> Result<(), BatchError> {
        let (count, each) = (states.count, self.rows());
        states.check()?;
        if let Columns::Chosen(places) = columns
            && let Some(place) = places.iter().find(|place| **place >= NONE)
        {
            return Err(BatchError::Column(*place));
        }
        let width = self.width(columns);
        same_length("values", values.len(), count.saturating_mul(each))?;
        same_length("rows", rows.len(), count.saturating_mul(width))?;
        let sources = if matches!(columns, Columns::Twelve) { Vec::new() } else { self.sources(columns) };
        let write = |found: &[CompactRow], values: &mut [f64], rows: &mut [f64]| match columns {
            Columns::Twelve => {
                let rows = rows.as_chunks_mut::<12>().0;
                on_unit(self.arch, Spread { found, each, values, rows });
            }
            _ => on_unit(self.arch, Gather { found, each, sources: &sources, values, rows }),
        };
        let mut found = vec![CompactRow::default(); count.div_ceil(LANES).min(TILES) * each];
        let (mut own_values, mut own_rows) = (Vec::new(), Vec::new());
        self.in_blocks(states, |these, slices| {
            let tiles = slices.tiles.len();
            let found = part(&mut found, tiles * each);
            CompactRow::fill(self, slices, found);
            let value = values.get_mut(these.start * each..these.end * each).unwrap_or_default();
            let row = rows.get_mut(these.start * width..these.end * width).unwrap_or_default();
            if these.len().is_multiple_of(LANES) {
                return write(found, value, row);
            }
            // Those of the last tile are too many.
            own_values.resize(tiles * LANES * each, 0.0);
            own_rows.resize(tiles * LANES * width, 0.0);
            write(found, &mut own_values, &mut own_rows);
            copy(&own_values, value);
            copy(&own_rows, row);
        });
        Ok(())
    }

    /// Goes through states in blocks of [`TILES`] tiles; beyond the last state stands the last again.
    pub(super) fn in_blocks(&self, states: &States<'_>, mut of_block: impl FnMut(Range<usize>, Slices<'_>)) {
        if self.rows() == 0 {
            return;
        }
        let mut work = Work::new(self, states);
        let at_once = at_once(states.count);
        for first in (0..states.count).step_by(at_once) {
            let these = first..states.count.min(first + at_once);
            work.fill(self, states, &these);
            for first in these.clone().step_by(LANES * TILES) {
                let these = first..these.end.min(first + LANES * TILES);
                of_block(these.clone(), work.slices(states, &these));
            }
        }
    }

    /// Where the numbers of a state stand among the places of [`Gather`].
    fn sources(&self, columns: Columns<'_>) -> Vec<usize> {
        let mut sources = Vec::with_capacity(self.width(columns));
        let mut add = |row: usize, places: &[usize]| sources.extend(places.iter().map(|j| PLACES * row + j));
        match columns {
            Columns::Sparse => self.pattern().iter().enumerate().for_each(|(row, places)| add(row, places)),
            Columns::Twelve => (0..self.rows()).for_each(|row| add(row, &TWELVE)),
            Columns::Fourteen => (0..self.rows()).for_each(|row| add(row, &FOURTEEN)),
            Columns::Chosen(places) => (0..self.rows()).for_each(|row| add(row, places)),
        }
        sources
    }
}

/// As many of the numbers as there is room for.
fn copy(from: &[f64], to: &mut [f64]) {
    let count = from.len().min(to.len());
    to[..count].copy_from_slice(&from[..count]);
}

const ZERO: Four = [0.0; LANES];
const ONE: Four = [1.0; LANES];
const IDENTITY: [[Four; 3]; 3] = [[ONE, ZERO, ZERO], [ZERO, ONE, ZERO], [ZERO, ZERO, ONE]];
/// Nodes at the origin, along the axes.
const STILL: Tile = Tile { reference: [ZERO; 3], displacement: [[ZERO; 3]; 2], triad: [IDENTITY, IDENTITY] };

/// Room for numbers of a node that do not stand one after the other.
#[derive(Debug, Default)]
struct Room {
    threes: Vec<[f64; 3]>,
    fours: Vec<[f64; 4]>,
    nines: Vec<[f64; 9]>,
}

/// Room for states that are read at a time.
struct Work {
    reference: Vec<[f64; 3]>,
    displacement: [Vec<[f64; 3]>; 2],
    rooms: [Room; 2],
    needed: Dependence,
    tiles: Vec<Tile>,
    /// The first state of the tiles.
    first: usize,
}

impl Work {
    fn new(batch: &Batch, states: &States<'_>) -> Self {
        let tiles = states.count.min(at_once(states.count)).div_ceil(LANES);
        let needed = batch.measures().iter().map(|(_, measure)| measure.dependence());
        Self {
            reference: Vec::new(),
            displacement: [Vec::new(), Vec::new()],
            rooms: [Room::default(), Room::default()],
            needed: needed.fold(Dependence::default(), Dependence::or),
            tiles: vec![STILL; tiles],
            first: 0,
        }
    }

    /// Takes some states, in tiles; the last tile is filled with the last state. What is not needed is left as it is.
    fn fill(&mut self, batch: &Batch, states: &States<'_>, these: &Range<usize>) {
        let Self { reference, displacement: [x_a, x_b], rooms, needed, tiles, first } = self;
        let tiles = part(tiles, these.len().div_ceil(LANES));
        if needed.translation {
            let [a, b] = &states.nodes;
            let (a, b) = (a.displacement.taken(these, x_a), b.displacement.taken(these, x_b));
            let reference = states.reference.taken(these, reference);
            on_unit(batch.arch, FillSeparations { reference, a, b, tiles });
        }
        for end in 0..2 {
            if end == 0 || needed.rotation {
                let turned = states.nodes[end].orientation.taken(these, &mut rooms[end]);
                on_unit(batch.arch, FillTriads { turned, end, tiles });
            }
        }
        *first = these.start;
    }

    /// The tiles of some of these states, with what belongs to them.
    fn slices<'l>(&'l self, states: &States<'l>, these: &Range<usize>) -> Slices<'l> {
        let (count, first) = (these.len().div_ceil(LANES), these.start / LANES);
        fn of<T>(all: &[T], first: usize, count: usize) -> &[T] {
            if all.len() == 1 { all } else { all.get(first..first + count).unwrap_or_default() }
        }
        let here = (these.start - self.first) / LANES;
        Slices {
            tiles: self.tiles.get(here..here + count).unwrap_or_default(),
            sections: of(states.sections, first, count),
            histories: of(states.histories, first, count),
        }
    }
}

fn part<T>(of: &mut [T], count: usize) -> &mut [T] {
    let count = count.min(of.len());
    of.split_at_mut(count).0
}

/// How a node is turned, state after state.
#[derive(Clone, Copy, Debug)]
enum Turned<'a> {
    Triads(&'a [[f64; 9]]),
    Directions(&'a [[f64; 9]]),
    Quaternions(&'a [[f64; 4]], Matrix<f64>),
    Vectors(&'a [[f64; 3]], Matrix<f64>),
}

impl<'a> Orientation<'a> {
    /// The numbers of the states named, in whole tiles; beyond the last stand those of the last again.
    fn taken<'b>(self, states: &Range<usize>, room: &'b mut Room) -> Turned<'b>
    where
        'a: 'b,
    {
        match self {
            Self::Triad(array) => Turned::Triads(array.taken(states, &mut room.nines)),
            Self::Directions(array) => Turned::Directions(array.taken(states, &mut room.nines)),
            Self::Quaternion(array, initial) => {
                Turned::Quaternions(array.taken(states, &mut room.fours), initial)
            }
            Self::RotationVector(array, initial) => {
                Turned::Vectors(array.taken(states, &mut room.threes), initial)
            }
        }
    }
}

/// What moves numbers.
pub(super) trait Moves {
    fn on<U: Unit>(self, unit: U);
}

/// Does it on the vector unit that there is.
pub(super) fn on_unit(arch: Arch, moves: impl Moves) {
    match arch {
        #[cfg(target_arch = "x86_64")]
        Arch::V3(unit) => Simd::vectorize(unit, On { unit, moves }),
        arch => arch.dispatch(On { unit: Any, moves }),
    }
}

struct On<U, W> {
    unit: U,
    moves: W,
}

impl<U: Unit, W: Moves> WithSimd for On<U, W> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_simd<V: Simd>(self, _: V) {
        self.moves.on(self.unit);
    }
}

/// x_b − x_a of tiles, in the place of the reference.
struct FillSeparations<'l> {
    reference: &'l [[f64; 3]],
    a: &'l [[f64; 3]],
    b: &'l [[f64; 3]],
    tiles: &'l mut [Tile],
}

impl Moves for FillSeparations<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn on<U: Unit>(self, unit: U) {
        // By numbers: an iterator over several arrays is a call for each where another unit of the crate holds it.
        let (reference, a, b) = (threes(self.reference), threes(self.a), threes(self.b));
        let count = self.tiles.len().min(reference.len()).min(a.len()).min(b.len());
        for i in 0..count {
            let mut apart = [ZERO; 3];
            for k in 0..3 {
                apart[k] = unit.separation(reference[i][k], a[i][k], b[i][k]);
            }
            self.tiles[i].reference = unit.lanes_of_threes(apart);
        }
    }
}

/// The triads of one end of tiles.
struct FillTriads<'l> {
    turned: Turned<'l>,
    end: usize,
    tiles: &'l mut [Tile],
}

impl Moves for FillTriads<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn on<U: Unit>(self, unit: U) {
        let Self { turned, end, tiles } = self;
        match turned {
            Turned::Triads(of) => {
                let of = of.as_chunks::<LANES>().0;
                for i in 0..tiles.len().min(of.len()) {
                    tiles[i].triad[end] = nines(unit, &of[i]);
                }
            }
            Turned::Directions(of) => {
                let of = of.as_chunks::<LANES>().0;
                for i in 0..tiles.len().min(of.len()) {
                    let [[a, b, c], [d, e, f], [g, h, j]] = nines(unit, &of[i]);
                    tiles[i].triad[end] = [[a, d, g], [b, e, h], [c, f, j]];
                }
            }
            Turned::Quaternions(of, initial) => {
                let of = of.as_chunks::<LANES>().0;
                for i in 0..tiles.len().min(of.len()) {
                    let [w, x, y, z] = unit.transposed(of[i]);
                    let q = unit_quaternion([Lanes(w), Lanes(x), Lanes(y), Lanes(z)]);
                    place(&so3::matrix(q), &initial, &mut tiles[i].triad[end]);
                }
            }
            Turned::Vectors(of, initial) => {
                let of = threes(of);
                for i in 0..tiles.len().min(of.len()) {
                    let [x, y, z] = unit.lanes_of_threes(of[i]);
                    let turn = so3::exp([Lanes(x), Lanes(y), Lanes(z)]);
                    place(&turn, &initial, &mut tiles[i].triad[end]);
                }
            }
        }
    }
}

/// Three numbers of each of four states, as they stand one after the other.
#[cfg_attr(not(debug_assertions), inline(always))]
fn threes(of: &[[f64; 3]]) -> &[[Four; 3]] {
    of.as_flattened().as_chunks::<LANES>().0.as_chunks::<3>().0
}

/// Nine numbers of each of four states.
#[cfg_attr(not(debug_assertions), inline(always))]
fn nines<U: Unit>(unit: U, of: &[[f64; 9]; LANES]) -> [[Four; 3]; 3] {
    let at = |k: usize| {
        let half = |lane: usize| [of[lane][k], of[lane][k + 1]];
        unit.lanes_of_pairs([half(0), half(1), half(2), half(3)])
    };
    let ([a, b], [c, d], [e, f], [g, h], [_, i]) = (at(0), at(2), at(4), at(6), at(7));
    [[a, b, c], [d, e, f], [g, h, i]]
}

/// q/‖q‖; NaN of zero.
#[cfg_attr(not(debug_assertions), inline(always))]
fn unit_quaternion(q: [Lanes<false>; 4]) -> [Lanes<false>; 4] {
    let (unit, usual) = of_usual_length(q);
    if Lanes::shortcut_where_positive(|| usual) { unit } else { of_any_length(q) }
}

/// The same of usual lengths, and what is negative where the square of a length is no number, or has lost digits.
#[cfg_attr(not(debug_assertions), inline(always))]
fn of_usual_length(q: [Lanes<false>; 4]) -> ([Lanes<false>; 4], Lanes<false>) {
    const SMALL: f64 = 1e-200;
    let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    let inverse = Lanes::splat(1.0) / square.square_root();
    let unit = [q[0] * inverse, q[1] * inverse, q[2] * inverse, q[3] * inverse];
    (unit, (square - Lanes::splat(SMALL)).lesser(Lanes::splat(1.0 / SMALL) - square))
}

/// Both, by lanes.
#[cold]
#[inline(never)]
fn of_any_length(q: [Lanes<false>; 4]) -> [Lanes<false>; 4] {
    let zero = Lanes::splat(0.0);
    let ((mut found, usual), (length, direction)) = (of_usual_length(q), norm_and_direction(q));
    let (is_usual, has_length) = (zero.less(usual), zero.less(length));
    for k in 0..4 {
        let scaled = Lanes::select(has_length, direction[k], Lanes::splat(f64::NAN));
        found[k] = Lanes::select(is_usual, found[k], scaled);
    }
    found
}

/// R T₀ of four.
#[cfg_attr(not(debug_assertions), inline(always))]
fn place(turn: &Matrix<Lanes<false>>, initial: &Matrix<f64>, to: &mut [[Four; 3]; 3]) {
    let mut start = [[Lanes::splat(0.0); 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            start[i][j] = Lanes::splat(initial[i][j]);
        }
    }
    let triad = product(turn, &start);
    for i in 0..3 {
        for j in 0..3 {
            triad[i][j].store(&mut to[i][j]);
        }
    }
}

/// Values and rows of tiles, state by state.
struct Spread<'l> {
    found: &'l [CompactRow],
    each: usize,
    values: &'l mut [f64],
    rows: &'l mut [Dense],
}

impl Moves for Spread<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn on<U: Unit>(self, unit: U) {
        let Self { found, each, values, rows } = self;
        for first in (0..found.len() / each * each).step_by(each) {
            let (states, tile) = (LANES * first..LANES * (first + each), &found[first..first + each]);
            let (Some(values), Some(rows)) = (values.get_mut(states.clone()), rows.get_mut(states)) else {
                return;
            };
            let [v0, v1, v2, v3] = quarters(values, each);
            let [r0, r1, r2, r3] = quarters(rows, each);
            for i in 0..each {
                let row = &tile[i];
                (v0[i], v1[i], v2[i], v3[i]) = (row.value[0], row.value[1], row.value[2], row.value[3]);
                let to = [&mut r0[i], &mut r1[i], &mut r2[i], &mut r3[i]];
                let ([t1, t2, t3], [x1, x2, x3], [y1, y2, y3]) = (row.turning_a, row.moving_b, row.turning_b);
                let pairs = [
                    unit.to_pairs([unit.opposite(x1), unit.opposite(x2)]),
                    unit.to_pairs([unit.opposite(x3), t1]),
                    unit.to_pairs([t2, t3]),
                    unit.to_pairs([x1, x2]),
                    unit.to_pairs([x3, y1]),
                    unit.to_pairs([y2, y3]),
                ];
                for lane in 0..LANES {
                    let to = to[lane].as_chunks_mut::<2>().0;
                    for k in 0..6 {
                        to[k] = pairs[k][lane];
                    }
                }
            }
        }
    }
}

/// Values, and chosen columns of rows, state by state.
struct Gather<'l> {
    found: &'l [CompactRow],
    each: usize,
    /// Of each number of a state the place among the twelve columns of each row, and zero behind them.
    sources: &'l [usize],
    values: &'l mut [f64],
    rows: &'l mut [f64],
}

impl Moves for Gather<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn on<U: Unit>(self, unit: U) {
        let Self { found, each, sources, values, rows } = self;
        let width = sources.len();
        let mut places = vec![[ZERO; PLACES]; each];
        for first in (0..found.len() / each * each).step_by(each) {
            let tile = &found[first..first + each];
            let here = first / each * LANES;
            let (Some(values), Some(rows)) = (
                values.get_mut(here * each..(here + LANES) * each),
                rows.get_mut(here * width..(here + LANES) * width),
            ) else {
                return;
            };
            let [v0, v1, v2, v3] = quarters(values, each);
            for i in 0..each {
                let row = &tile[i];
                (v0[i], v1[i], v2[i], v3[i]) = (row.value[0], row.value[1], row.value[2], row.value[3]);
                let Some(to) = places.get_mut(i) else { return };
                for k in 0..3 {
                    to[k] = unit.opposite(row.moving_b[k]);
                    to[3 + k] = row.turning_a[k];
                    to[6 + k] = row.moving_b[k];
                    to[9 + k] = row.turning_b[k];
                }
            }
            let room = places.as_flattened();
            let [r0, r1, r2, r3] = quarters(rows, width);
            let (fours, rest) = sources.as_chunks::<LANES>();
            let ((r0, e0), (r1, e1)) = (r0.as_chunks_mut::<LANES>(), r1.as_chunks_mut::<LANES>());
            let ((r2, e2), (r3, e3)) = (r2.as_chunks_mut::<LANES>(), r3.as_chunks_mut::<LANES>());
            let count = fours.len().min(r0.len()).min(r1.len()).min(r2.len()).min(r3.len());
            for i in 0..count {
                let [a, b, c, d] = fours[i];
                [r0[i], r1[i], r2[i], r3[i]] = unit.transposed([room[a], room[b], room[c], room[d]]);
            }
            for i in 0..rest.len() {
                [e0[i], e1[i], e2[i], e3[i]] = room[rest[i]];
            }
        }
    }
}

/// The parts of four states.
#[cfg_attr(not(debug_assertions), inline(always))]
fn quarters<T>(of: &mut [T], each: usize) -> [&mut [T]; LANES] {
    let (a, rest) = of.split_at_mut(each);
    let (b, rest) = rest.split_at_mut(each);
    let (c, rest) = rest.split_at_mut(each);
    [a, b, c, rest.split_at_mut(each).0]
}
