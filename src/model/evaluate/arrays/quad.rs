//! Connectors of one kind, four at a time.

use crate::evaluate::arrays::part::write;
use crate::evaluate::arrays::{Kind, Numbers, Sorted};
use crate::evaluate::model::Model;
use crate::evaluate::sequence::nodes::{Moved, STILL};
use pintle_kinematics::batch::{CompactRow, Four, Fours, History, LANES, Poses, Section, Tile, Triads};
use pintle_kinematics::connector::{
    Branch, Connector, Evaluation, Increment, Mask, Output, Request, State, Tally,
};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::DOFS;

/// Connectors of one kind, by fours.
pub(super) struct Quads<'a> {
    /// Its place among those of the plan.
    kind: usize,
    /// The components whose histories are followed; none where no history depends on how nodes turn.
    followed: Option<Mask>,
    /// Where the values of each output come from.
    values: Vec<(Output, [Source; 6])>,
    /// The row of each component in the batch, where it is wanted.
    rows: [Option<usize>; 6],
    all: Vec<Quad<'a>>,
    tiles: Vec<Tile>,
    sections: Vec<Section>,
    histories: Vec<History>,
}

/// Four connectors, the last of which may stand for those that are missing.
struct Quad<'a> {
    fours: Fours,
    triads: Triads,
    connectors: [&'a Connector<f64>; LANES],
    /// Their places in the part: of no more than there are.
    members: Vec<usize>,
    /// Their nodes, by their places in the part; none is the ground.
    ends: [[Option<usize>; LANES]; 2],
    /// Whether each has all columns.
    is_free: [bool; LANES],
}

/// Where the values of an output of a component come from.
#[derive(Clone, Copy)]
enum Source {
    None,
    Turns,
    /// An angle that winds.
    Angle(Counted),
    /// The value of a row of the batch.
    Row(usize, Counted),
    /// A measure that is not differentiated.
    Measure(Measure, Counted),
}

/// What values are counted from.
#[derive(Clone, Copy)]
enum Counted {
    Zero,
    Initial,
    Residual,
    Reference,
}

/// Room for the rows of some of them, and for one connector.
pub(super) struct Room {
    rows: Vec<CompactRow>,
    evaluation: Evaluation<f64>,
}

impl Default for Room {
    fn default() -> Self {
        Self { rows: Vec::new(), evaluation: Evaluation::empty(Branch::none()) }
    }
}

/// A connector of a part: its place there, its index in the model, its nodes.
pub(super) type Member = (usize, usize, [Option<usize>; 2]);

impl<'a> Quads<'a> {
    pub(super) fn new(sorted: &Sorted<'a>, kind: usize, members: &[Member]) -> Self {
        let (Kind { connector, batch }, request) = (&sorted.kinds[kind], sorted.request());
        let is_with_rows = request.order > 0;
        let row = |k: usize| batch.measures().iter().position(|(of, _)| *of == k);
        let values = request.outputs().map(|output| {
            let sources = [0, 1, 2, 3, 4, 5].map(|k| {
                let row = row(k).filter(|_| is_with_rows);
                if request.wants(output, k) { Source::of(connector, output, k, row) } else { Source::None }
            });
            (output, sources)
        });
        let (components, count) = (request.components(), members.len().div_ceil(LANES));
        let mut quads = Self {
            kind,
            followed: connector.history_turns(components).then_some(components),
            values: values.collect(),
            rows: [0, 1, 2, 3, 4, 5].map(|k| row(k).filter(|_| request.rows()[k])),
            all: Vec::with_capacity(count),
            tiles: Vec::with_capacity(count),
            sections: Vec::with_capacity(count),
            histories: Vec::with_capacity(count),
        };
        members.chunks(LANES).for_each(|members| quads.add(sorted.model, members));
        quads
    }

    /// Adds up to four.
    fn add(&mut self, model: &'a Model, members: &[Member]) {
        let Some(last) = members.last() else { return };
        let four: [Member; LANES] = std::array::from_fn(|i| *members.get(i).unwrap_or(last));
        let elements = four.map(|(_, index, _)| &model.connectors[index]);
        let connectors = elements.map(|element| &element.connector);
        let fours = Fours::new(&connectors);
        let triads = Triads::new(&elements.map(|element| element.triads()));
        let references = Tile::references(&elements.map(|element| element.reference));
        self.tiles.push(Tile::initial(references, &triads));
        self.sections.push(Section::new(&connectors));
        self.histories.push(fours.history());
        self.all.push(Quad {
            fours,
            triads,
            connectors,
            members: members.iter().map(|(at, ..)| *at).collect(),
            ends: [0, 1].map(|end| four.map(|(_, _, ends)| ends[end])),
            is_free: connectors.map(|one| (0..DOFS).all(|j| one.active()[j] || j % (DOFS / 2) == 6)),
        });
    }

    /// Evaluates them at the next state.
    pub(super) fn run(
        &mut self,
        sorted: &Sorted<'_>,
        moved: &[Moved],
        room: &mut Room,
        numbers: &mut Numbers<'_>,
        tally: &mut Tally,
    ) {
        /// They and their rows stay in the second cache.
        const AT_ONCE: usize = 16;
        let (Kind { connector, batch }, request) = (&sorted.kinds[self.kind], sorted.request());
        let Self { followed, all, .. } = self;
        let (tiles, sections, histories) = (&mut self.tiles, &self.sections, &mut self.histories);
        let each = if request.order > 0 { batch.rows() } else { 0 };
        let mut first = 0;
        for quads in all.chunks_mut(AT_ONCE) {
            let these = first..first + quads.len();
            first = these.end;
            let (Some(tiles), Some(sections), Some(histories)) =
                (tiles.get_mut(these.clone()), sections.get(these.clone()), histories.get_mut(these))
            else {
                return;
            };
            for (quad, ((tile, section), history)) in
                quads.iter_mut().zip(tiles.iter_mut().zip(sections).zip(&mut *histories))
            {
                let nodes =
                    quad.ends.each_ref().map(|of| of.map(|end| end.map_or(&STILL, |end| &moved[end])));
                quad.place(&nodes, tile);
                if let Some(wanted) = *followed {
                    let increments = std::array::from_fn(|lane| Increment {
                        rotation: [nodes[0][lane].change, nodes[1][lane].change],
                        whole_turns: [nodes[0][lane].whole_turns, nodes[1][lane].whole_turns],
                        flow: [0.0; 2],
                    });
                    quad.fours.follow(connector, (tile, section), &increments, wanted, tally);
                    *history = quad.fours.history();
                }
            }
            room.rows.resize(quads.len() * each, CompactRow::default());
            if each > 0 {
                let done = batch.rows_of(tiles, sections, histories, &mut room.rows);
                debug_assert_eq!(done, Ok(()), "the slices have been made for each other");
            }
            for (q, (quad, at)) in quads.iter().zip(tiles.iter().zip(sections)).enumerate() {
                let own = room.rows.get(q * each..(q + 1) * each).unwrap_or_default();
                tally.gradients += (quad.members.len() * each) as u64;
                for (output, array) in &mut numbers.values {
                    let known = self.values.iter().find(|(of, _)| of == output);
                    let sources = known.map_or([Source::None; 6], |(_, sources)| *sources);
                    for (k, source) in sources.iter().enumerate() {
                        let value = quad.value(*source, k, at, own, tally);
                        for (lane, of) in quad.members.iter().enumerate() {
                            if let Some(place) = array.get_mut(of * 6 + k) {
                                *place = value[lane];
                            }
                        }
                    }
                }
                if let Some(array) = &mut numbers.jacobian {
                    quad.put_rows(&self.rows, own, array);
                }
                let takes = batch.takes(at.0);
                for (lane, of) in quad.members.iter().enumerate() {
                    if !takes[lane] {
                        quad.alone(lane, at.0, request, &mut room.evaluation);
                        write(&room.evaluation, quad.connectors[lane], request, *of, numbers);
                    }
                }
            }
        }
    }
}

impl Source {
    /// Of an output of component k, whose value the batch gives with a row where there is one.
    fn of(connector: &Connector<f64>, output: Output, k: usize, row: Option<usize>) -> Self {
        let (Some(position), Some(differentiated)) =
            (connector.position_measure(k), connector.differentiated(k))
        else {
            return Self::None;
        };
        let (measure, from) = match output {
            Output::TURNS if position.winds() => return Self::Turns,
            Output::RES if connector.is_constrained(k) => (differentiated, Counted::Residual),
            Output::CP => (position, Counted::Zero),
            Output::CU => (position, Counted::Initial),
            Output::CCU if connector.connection().slots[k].is_available() => (position, Counted::Reference),
            _ => return Self::None,
        };
        match row {
            _ if measure.winds() => Self::Angle(from),
            Some(row) if measure == differentiated => Self::Row(row, from),
            _ => Self::Measure(measure, from),
        }
    }
}

impl Quad<'_> {
    /// Brings the nodes where they are.
    fn place(&self, nodes: &[[&Moved; LANES]; 2], tile: &mut Tile) {
        let poses = Poses {
            displacement: nodes.each_ref().map(|of| of.map(|node| &node.displacement)),
            rotation: nodes.each_ref().map(|of| of.map(|node| &node.rotation)),
        };
        tile.place(&self.triads, &poses);
    }

    /// The values of an output of component k; NaN where there are none.
    fn value(
        &self,
        source: Source,
        k: usize,
        at: (&Tile, &Section),
        rows: &[CompactRow],
        tally: &mut Tally,
    ) -> Four {
        const NONE: Four = [f64::NAN; LANES];
        let from = |from: Counted| {
            let origin = self.fours.origin(k);
            match from {
                Counted::Zero => [0.0; LANES],
                Counted::Initial => origin.map_or(NONE, |of| of.initial),
                Counted::Residual => origin.map_or(NONE, |of| of.residual),
                Counted::Reference => origin.map_or(NONE, |of| of.reference),
            }
        };
        let less = |value: Four, of: Counted| {
            let origin = from(of);
            std::array::from_fn(|lane| value[lane] - origin[lane])
        };
        match source {
            Source::None => NONE,
            Source::Turns => self.fours.turns(k)[0],
            Source::Angle(of) => self.fours.angle(k, &from(of)),
            Source::Row(row, of) => less(rows.get(row).map_or(NONE, |row| row.value), of),
            Source::Measure(measure, of) => {
                tally.values += self.members.len() as u64;
                less(self.fours.value(measure, at), of)
            }
        }
    }

    /// The connector of a lane by itself, where its nodes are too far apart, or too near, for a batch.
    fn alone(&self, lane: usize, tile: &Tile, request: &Request, evaluation: &mut Evaluation<f64>) {
        let state = State { pair: tile.lane(lane), velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let (branch, work) = (self.fours.branch(lane), &mut Tally::default());
        self.connectors[lane].evaluate_into(evaluation, &state, branch, request, work);
    }

    /// Writes rows: x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b.
    fn put_rows(&self, rows: &[Option<usize>; 6], own: &[CompactRow], array: &mut [f64]) {
        for (lane, at) in self.members.iter().enumerate() {
            let Some(to) = array.get_mut(at * 6 * DOFS..(at + 1) * 6 * DOFS) else { continue };
            for (to, row) in to.as_chunks_mut::<DOFS>().0.iter_mut().zip(rows) {
                let Some(row) = row.and_then(|row| own.get(row)) else {
                    *to = [f64::NAN; DOFS];
                    continue;
                };
                let ([t1, t2, t3], [x1, x2, x3], [y1, y2, y3]) =
                    (&row.turning_a, &row.moving_b, &row.turning_b);
                let of = |x: &Four| x[lane];
                *to = [
                    0.0 - of(x1),
                    0.0 - of(x2),
                    0.0 - of(x3),
                    of(t1),
                    of(t2),
                    of(t3),
                    0.0,
                    of(x1),
                    of(x2),
                    of(x3),
                    of(y1),
                    of(y2),
                    of(y3),
                    0.0,
                ];
                if !self.is_free[lane] {
                    let active = self.connectors[lane].active();
                    to.iter_mut().zip(active).filter(|(_, is)| !*is).for_each(|(entry, _)| *entry = 0.0);
                }
            }
        }
    }
}
