//! Connectors of one kind, four at a time.

use crate::evaluate::arrays::part::write;
use crate::evaluate::arrays::{Kind, Places};
use crate::evaluate::model::Model;
use crate::evaluate::sequence::nodes::{Moved, STILL};
use pintle_kinematics::batch::{CompactRow, Four, Fours, History, LANES, Moves, Section, Tile};
use pintle_kinematics::connector::{Branch, Connector, Evaluation, Increment, Output, Request, State, Tally};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::DOFS;

/// Connectors of one kind.
pub(super) struct Quads<'a> {
    kind: &'a Kind<'a>,
    request: &'a Request,
    all: Vec<Quad<'a>>,
}

/// Four connectors, the last of which may stand for those that are missing.
struct Quad<'a> {
    fours: Fours,
    /// Their places in the part.
    members: Vec<usize>,
    connectors: [&'a Connector<f64>; LANES],
    /// Their nodes, by their places in the part; none is the ground.
    ends: [[Option<usize>; LANES]; 2],
}

/// Room for the rows of some of them.
pub(super) struct Room {
    tiles: Vec<Tile>,
    sections: Vec<Section>,
    histories: Vec<History>,
    rows: Vec<CompactRow>,
    evaluation: Evaluation<f64>,
}

impl Default for Room {
    fn default() -> Self {
        Self {
            tiles: Vec::new(),
            sections: Vec::new(),
            histories: Vec::new(),
            rows: Vec::new(),
            evaluation: Evaluation::empty(Branch::none()),
        }
    }
}

/// A connector of a part: its place there, its index in the model, its nodes.
pub(super) type Member = (usize, usize, [Option<usize>; 2]);

impl<'a> Quads<'a> {
    pub(super) fn new(
        model: &'a Model,
        kind: &'a Kind<'a>,
        request: &'a Request,
        members: &[Member],
    ) -> Self {
        let all = members.chunks(LANES).filter_map(|members| {
            let last = *members.last()?;
            let four: [Member; LANES] = std::array::from_fn(|i| members.get(i).copied().unwrap_or(last));
            let elements = four.map(|(_, index, _)| &model.connectors[index]);
            let connectors: [&Connector<f64>; LANES] = elements.map(|element| &element.connector);
            Some(Quad {
                connectors,
                fours: Fours::new(
                    &connectors,
                    &elements.map(|element| element.reference),
                    &elements.map(|element| element.triads().map(|triad| *triad)),
                ),
                members: members.iter().map(|(at, ..)| *at).collect(),
                ends: [0, 1].map(|end| four.map(|(_, _, ends)| ends[end])),
            })
        });
        Self { kind, request, all: all.collect() }
    }

    /// Evaluates them at the next state.
    pub(super) fn run(
        &mut self,
        moved: &[Moved],
        room: &mut Room,
        places: &mut Places<'_>,
        tally: &mut Tally,
    ) {
        /// They and their rows stay in the second cache.
        const AT_ONCE: usize = 16;
        let Self { kind: Kind { connector, batch }, request, all } = self;
        let wanted = request.components();
        let follows = connector.history_turns(wanted);
        let rows = if request.order > 0 { batch.rows() } else { 0 };
        for quads in all.chunks_mut(AT_ONCE) {
            room.tiles.clear();
            room.sections.clear();
            room.histories.clear();
            for Quad { fours, ends, .. } in &mut *quads {
                let at = |end: Option<usize>| end.map_or(&STILL, |end| &moved[end]);
                let ends = ends.map(|of| of.map(at));
                let moves = Moves {
                    displacement: ends.map(|of| of.map(|node| node.displacement)),
                    rotation: ends.map(|of| of.map(|node| node.rotation)),
                };
                let increments = follows.then(|| {
                    std::array::from_fn(|lane| Increment {
                        rotation: ends.map(|of| of[lane].change),
                        whole_turns: ends.map(|of| of[lane].whole_turns),
                        flow: [0.0; 2],
                    })
                });
                let history = increments.as_ref().map(|increments| (increments, wanted));
                fours.follow_moves(connector, &moves, history, tally);
                if rows > 0 {
                    room.tiles.push(*fours.tile());
                    room.sections.push(*fours.section());
                    room.histories.push(fours.history());
                }
            }
            room.rows.resize(room.tiles.len() * rows, CompactRow::default());
            if rows > 0 {
                let done = batch.rows_of(&room.tiles, &room.sections, &room.histories, &mut room.rows);
                debug_assert_eq!(done, Ok(()), "the slices have been made for each other");
            }
            for (q, quad) in quads.iter().enumerate() {
                let own = room.rows.get(q * rows..(q + 1) * rows).unwrap_or_default();
                let count = quad.members.len() as u64;
                tally.gradients += count * own.len() as u64;
                for (output, numbers) in &mut places.values {
                    for k in 0..6 {
                        let value = if request.wants(*output, k) {
                            quad.value((connector, batch.measures(), own), *output, k, tally)
                        } else {
                            None
                        };
                        for (lane, at) in quad.members.iter().enumerate() {
                            if let Some(place) = numbers.get_mut(at * 6 + k) {
                                *place = value.map_or(f64::NAN, |value| value[lane]);
                            }
                        }
                    }
                }
                if let Some(numbers) = &mut places.jacobian {
                    quad.put_rows((batch.measures(), own), request, numbers);
                }
                for (lane, at) in quad.members.iter().enumerate() {
                    if !batch.takes(quad.fours.tile(), lane) {
                        quad.alone(lane, request, room);
                        tally.values += room.evaluation.position.iter().flatten().count() as u64;
                        write(&room.evaluation, quad.connectors[lane], request, *at, places);
                    }
                }
            }
        }
    }
}

impl Quad<'_> {
    /// The values of an output of component k.
    fn value(
        &self,
        (connector, measures, rows): (&Connector<f64>, &[(usize, Measure)], &[CompactRow]),
        output: Output,
        k: usize,
        tally: &mut Tally,
    ) -> Option<Four> {
        let origin = self.fours.origin(k)?;
        let position = connector.position_measure(k)?;
        let (measure, from) = match output {
            Output::TURNS => return position.winds().then(|| self.fours.turns(k)[0]),
            Output::RES if !connector.is_constrained(k) => return None,
            Output::RES => (connector.differentiated(k)?, origin.residual),
            Output::CP => (position, [0.0; LANES]),
            Output::CU => (position, origin.initial),
            Output::CCU if connector.connection().slots[k].is_available() => (position, origin.reference),
            _ => return None,
        };
        if measure.winds() {
            return Some(self.fours.angle(k, &from));
        }
        let known = measures.iter().position(|of| *of == (k, measure)).and_then(|row| rows.get(row));
        let value = known.map_or_else(
            || {
                tally.values += self.members.len() as u64;
                self.fours.value(measure)
            },
            |row| row.value,
        );
        Some(std::array::from_fn(|lane| value[lane] - from[lane]))
    }

    /// The connector of a lane by itself, where its nodes are too far apart, or too near, for a batch.
    fn alone(&self, lane: usize, request: &Request, room: &mut Room) {
        let pair = self.fours.tile().lane(lane);
        let state = State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let branch = self.fours.branch(lane);
        let work = &mut Tally::default();
        self.connectors[lane].evaluate_into(&mut room.evaluation, &state, branch, request, work);
    }

    /// Writes rows: x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b.
    fn put_rows(
        &self,
        (measures, rows): (&[(usize, Measure)], &[CompactRow]),
        request: &Request,
        numbers: &mut [f64],
    ) {
        let wanted = request.rows();
        for (lane, at) in self.members.iter().enumerate() {
            let active = self.connectors[lane].active();
            let is_free = active.iter().enumerate().all(|(j, is)| *is || j % (DOFS / 2) == 6);
            let Some(own) = numbers.get_mut(at * 6 * DOFS..(at + 1) * 6 * DOFS) else { continue };
            let own = own.as_chunks_mut::<DOFS>().0;
            let mut is_there = [false; 6];
            for ((k, _), row) in measures.iter().zip(rows).filter(|((k, _), _)| wanted[*k]) {
                let ([t1, t2, t3], [x1, x2, x3], [y1, y2, y3]) = (row.turning_a, row.moving_b, row.turning_b);
                let of = |x: Four| x[lane];
                let Some(to) = own.get_mut(*k) else { continue };
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
                if !is_free {
                    to.iter_mut().zip(active).filter(|(_, is)| !*is).for_each(|(entry, _)| *entry = 0.0);
                }
                is_there[*k] = true;
            }
            for (row, _) in own.iter_mut().zip(is_there).filter(|(_, is)| !*is) {
                *row = [f64::NAN; DOFS];
            }
        }
    }
}
