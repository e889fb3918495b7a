//! Rows of the sparse Jacobian, four connectors of one kind at a time ([`pintle_kinematics::batch`]).
//!
//! That is for connectors of which nothing but rows is asked, and whose history is not followed: without behaviour, without forces. What does
//! not change from state to state is put side by side once for each pattern. Beyond the lengths that batches are stated for, connectors
//! are evaluated by themselves.

use crate::evaluate::jacobian::Jacobian;
use crate::evaluate::model::Model;
use crate::evaluate::sequence::Place;
use crate::evaluate::sequence::element::{Memory, Needed};
use crate::evaluate::sequence::nodes::{Moved, STILL};
use pintle_kinematics::batch::{self, Batch, Four, History, LANES, Poses, Section, Tile, Triads, Watch};
use pintle_kinematics::connector::{Components, Flag, Group, Increment, Mask, State, Tally};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::vector::dot;
use std::ops::Range;

/// How many connectors are taken together, among which those of one kind are found.
pub(super) const PART: usize = 512;

/// How many fours are taken at once: they and their rows stay in the first cache.
const AT_ONCE: usize = 8;

/// Connectors that share their measures, and the rows that are wanted of them.
#[derive(Debug)]
struct Kind {
    /// One of them, by its index in the model.
    index: usize,
    wanted: Mask,
    batch: Batch,
    /// The row of each component in the batch.
    rows: [usize; 6],
    watch: Watch,
    history: History,
    /// What fours refer to: most connectors of a model are oriented as the one before.
    triads: Vec<Triads>,
    sections: Vec<Section>,
}

/// Four connectors of a part, the last of which may stand for those that are missing.
#[derive(Clone, Copy, Debug)]
struct Quad {
    kind: u32,
    triads: u32,
    section: u32,
    /// How many there are.
    count: u32,
    /// Their places in the plan.
    at: [u32; LANES],
    ends: [[Place; LANES]; 2],
    reference: [Four; 3],
}

/// Connectors that stand side by side in the plan.
#[derive(Debug, Default)]
struct Part {
    quads: Range<usize>,
    alone: Range<usize>,
}

/// How the connectors of a plan are taken, for one pattern.
#[derive(Debug, Default)]
pub(super) struct Lanes {
    kinds: Vec<Kind>,
    quads: Vec<Quad>,
    /// The places of those that are evaluated by themselves.
    alone: Vec<u32>,
    parts: Vec<Part>,
}

/// Room for what a part is made from.
#[derive(Default)]
pub(super) struct Room {
    tiles: Vec<Tile>,
    found: Vec<batch::CompactRow>,
    /// The places of those of the part that are to be evaluated by themselves.
    pub(super) alone: Vec<u32>,
}

/// Sorts the connectors of a plan.
struct Sorter<'a> {
    model: &'a Model,
    lanes: Lanes,
    /// The kind that was found last.
    last: usize,
    /// The places in the plan of the members of each kind, in the part that is being made.
    members: Vec<Vec<u32>>,
}

/// What becomes of a connector.
enum Way {
    /// No row of it is wanted, and nothing else is.
    Nothing,
    Alone,
    Of(usize),
}

impl Lanes {
    pub(super) fn new(
        (model, connectors): (&Model, &[usize]),
        jacobian: &Jacobian,
        (followed, needed): (&[Mask], &[Needed]),
        (memories, ends): (&[Memory], &[[Place; 2]]),
    ) -> Self {
        let mut sorter = Sorter { model, lanes: Self::default(), last: 0, members: Vec::new() };
        for first in (0..connectors.len()).step_by(PART) {
            let these = first..connectors.len().min(first + PART);
            let (quads, alone) = (sorter.lanes.quads.len(), sorter.lanes.alone.len());
            for at in these {
                let (index, wanted) = (connectors[at], jacobian.wanted(at));
                let connector = &model.connectors[index].connector;
                // What leaves its plane is told of a connector without rows, too.
                let is_alone =
                    needed[at].always || connector.history_turns(followed[at]) || connector.is_planar();
                let way = match wanted {
                    _ if is_alone => Way::Alone,
                    [false, false, false, false, false, false] => Way::Nothing,
                    _ => sorter.way(index, wanted, &memories[at]),
                };
                let Ok(place) = u32::try_from(at) else { continue };
                match way {
                    Way::Nothing => {}
                    Way::Alone => sorter.lanes.alone.push(place),
                    Way::Of(kind) => {
                        sorter.members.resize_with(sorter.lanes.kinds.len(), Vec::new);
                        sorter.members[kind].push(place);
                    }
                }
            }
            sorter.put(connectors, ends);
            let part =
                Part { quads: quads..sorter.lanes.quads.len(), alone: alone..sorter.lanes.alone.len() };
            sorter.lanes.parts.push(part);
        }
        sorter.lanes
    }

    /// Writes the entries of the connectors of a part that go in lanes, and says what needs care of them. Which are to be evaluated
    /// by themselves, `room` tells then.
    pub(super) fn rows(
        &self,
        part: usize,
        (model, connectors, jacobian): (&Model, &[usize], &Jacobian),
        (memories, moved): (&[Memory], &[Moved]),
        (entries, room): (&mut [f64], &mut Room),
        (flags, tally): (&mut Vec<(usize, Flag)>, &mut Tally),
    ) {
        room.alone.clear();
        let (Some(part_of), first) = (self.parts.get(part), part * PART) else { return };
        room.alone.extend(self.alone.get(part_of.alone.clone()).into_iter().flatten());
        let first_entry = jacobian.first_entry(first);
        let quads = self.quads.get(part_of.quads.clone()).unwrap_or_default();
        let alike = |one: &Quad, other: &Quad| one.kind == other.kind && one.section == other.section;
        for quads in quads.chunk_by(alike).flat_map(|alike| alike.chunks(AT_ONCE)) {
            let Some(kind) = quads.first().and_then(|quad| self.kinds.get(quad.kind as usize)) else {
                continue;
            };
            let Some(section) = quads.first().and_then(|quad| kind.sections.get(quad.section as usize))
            else {
                continue;
            };
            room.tiles.clear();
            for quad in quads {
                let Some(triads) = kind.triads.get(quad.triads as usize) else { continue };
                room.tiles.push(quad.tile(triads, moved));
            }
            let each = kind.batch.rows();
            room.found.resize(room.tiles.len() * each, batch::CompactRow::default());
            let (sections, histories) = (std::slice::from_ref(section), std::slice::from_ref(&kind.history));
            let done = kind.batch.rows_of(&room.tiles, sections, histories, &mut room.found);
            debug_assert_eq!(done, Ok(()), "the slices have been made for each other");
            for (quad, (tile, rows)) in
                quads.iter().zip(room.tiles.iter().zip(room.found.chunks_exact(each.max(1))))
            {
                let takes = kind.batch.takes(tile);
                let beside = kind.watch.beside(tile, section);
                let is_finite = rows.iter().all(batch::CompactRow::is_finite);
                tally.gradients += u64::from(quad.count) * each as u64;
                tally.margins += u64::from(quad.count) * kind.watch.count() as u64;
                for (lane, place) in quad.at.iter().enumerate().take(quad.count as usize) {
                    if !takes[lane] {
                        room.alone.push(*place);
                        continue;
                    }
                    let at = *place as usize;
                    let these =
                        jacobian.first_entry(at) - first_entry..jacobian.first_entry(at + 1) - first_entry;
                    let row = |k: usize| rows.get(kind.rows[k]);
                    let of = |k, group: Group| row(k).map_or([f64::NAN; 3], |row| row.group(lane, group));
                    jacobian.write(at, entries.get_mut(these).unwrap_or_default(), of, |_, _| f64::NAN);
                    if beside[lane] {
                        let pair = tile.lane(lane);
                        let state = State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
                        let (connector, branch) =
                            (&model.connectors[connectors[at]].connector, &memories[at - first].branch);
                        let margins = connector.margins(&state, branch, kind.wanted);
                        let still = Increment::none();
                        let found =
                            connector.flags_of([false; 6], &margins, &still, &state, [branch, branch]);
                        flags.extend(found.into_iter().map(|flag| (at, flag)));
                    }
                    if !is_finite {
                        let own: Components<_> =
                            [0, 1, 2, 3, 4, 5].map(|k| Some(row(k).filter(|_| kind.wanted[k])?.lane(lane)));
                        flags.extend(super::assemble::broken(kind.wanted, &own).map(|flag| (at, flag)));
                    }
                }
            }
        }
    }
}

impl Sorter<'_> {
    /// How the rows of a connector are found.
    fn way(&mut self, index: usize, wanted: Mask, memory: &Memory) -> Way {
        /// Rotation vectors that continue a shorter one (rad) are not beside a whole turn.
        const SHORT: f64 = 3.0;
        let connector = &self.model.connectors[index].connector;
        if connector.undetermined_origins().iter().any(Option::is_some)
            || (0..6).any(|k| wanted[k] && connector.row_has_history(k))
        {
            return Way::Alone;
        }
        let model = self.model;
        let is_of = |kind: &Kind| {
            kind.wanted == wanted && model.connectors[kind.index].connector.has_measures_of(connector)
        };
        let kinds = &mut self.lanes.kinds;
        let known = kinds.get(self.last).filter(|kind| is_of(kind)).map(|_| self.last);
        let place = match known.or_else(|| kinds.iter().position(is_of)) {
            Some(place) => place,
            None => {
                let Ok(batch) = Batch::new(connector, wanted) else { return Way::Alone };
                let row = |k: usize| batch.measures().iter().position(|(of, _)| *of == k);
                kinds.push(Kind {
                    index,
                    wanted,
                    rows: [0, 1, 2, 3, 4, 5].map(|k| row(k).unwrap_or(usize::MAX)),
                    batch,
                    watch: Watch::new(connector, wanted),
                    history: History::new(&[connector.initial_branch(); LANES]),
                    triads: Vec::new(),
                    sections: Vec::new(),
                });
                kinds.len() - 1
            }
        };
        self.last = place;
        let vector = memory.branch.rotation_vector;
        let is_long = kinds[place].watch.turns() && dot(vector, vector) > SHORT * SHORT;
        if is_long { Way::Alone } else { Way::Of(place) }
    }

    /// Puts the members of the part by fours.
    fn put(&mut self, connectors: &[usize], ends: &[[Place; 2]]) {
        let Self { model, lanes: Lanes { kinds, quads, .. }, members, .. } = self;
        for (number, (kind, members)) in (0..).zip(kinds.iter_mut().zip(members)) {
            for four in members.chunks(LANES) {
                let at: [u32; LANES] = std::array::from_fn(|lane| four[lane.min(four.len() - 1)]);
                let places = at.map(|at| at as usize);
                let elements = places.map(|at| &model.connectors[connectors[at]]);
                let triads = Triads::new(&elements.map(|element| element.triads()));
                let section = Section::new(&elements.map(|element| &element.connector));
                quads.push(Quad {
                    kind: number,
                    triads: last_or_new(&mut kind.triads, triads),
                    section: last_or_new(&mut kind.sections, section),
                    count: four.len() as u32,
                    at,
                    ends: [0, 1].map(|end| places.map(|at| ends[at][end])),
                    reference: Tile::references(&elements.map(|element| element.reference)),
                });
            }
            members.clear();
        }
    }
}

/// The place of the last of those, if it is that one, or of that one, put behind it.
fn last_or_new<T: PartialEq>(all: &mut Vec<T>, one: T) -> u32 {
    if all.last() != Some(&one) {
        all.push(one);
    }
    (all.len() - 1) as u32
}

impl Quad {
    /// Where the nodes are.
    fn tile(&self, triads: &Triads, moved: &[Moved]) -> Tile {
        let node =
            |end: usize, lane: usize| self.ends[end][lane].map_or(&STILL, |place| &moved[place as usize]);
        let nodes = |end: usize| [node(end, 0), node(end, 1), node(end, 2), node(end, 3)];
        let [[a0, a1, a2, a3], [b0, b1, b2, b3]] = [nodes(0), nodes(1)];
        let poses = Poses {
            displacement: [
                [&a0.displacement, &a1.displacement, &a2.displacement, &a3.displacement],
                [&b0.displacement, &b1.displacement, &b2.displacement, &b3.displacement],
            ],
            rotation: [
                [&a0.rotation, &a1.rotation, &a2.rotation, &a3.rotation],
                [&b0.rotation, &b1.rotation, &b2.rotation, &b3.rotation],
            ],
        };
        let mut tile = Tile::initial(self.reference, triads);
        tile.place(triads, &poses);
        tile
    }
}
