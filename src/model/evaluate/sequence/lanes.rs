//! Rows of the sparse Jacobian, four connectors of one kind at a time ([`pintle_kinematics::batch`]).
//!
//! That is for connectors of which nothing but rows is asked, and whose history is not followed: without behaviour, without forces. Near singular
//! sets they are flagged as others are. Beyond the lengths that batches are stated for, connectors are evaluated by themselves.

use crate::evaluate::jacobian::Jacobian;
use crate::evaluate::model::Model;
use crate::evaluate::sequence::Place;
use crate::evaluate::sequence::element::{Memory, Needed};
use crate::evaluate::sequence::nodes::{Moved, STILL};
use pintle_kinematics::batch::{self, Batch, History, LANES, Poses, Section, Tile, Triads};
use pintle_kinematics::connector::{CompactRow, Components, Flag, Increment, Mask, State, Tally};
use pintle_kinematics::node::DOFS;

/// How many connectors are taken together, among which those of one kind are found.
pub(super) const PART: usize = 256;

/// Connectors that share their measures, and the rows that are wanted of them.
#[derive(Clone, Debug)]
struct Kind {
    /// One of them, by its index in the model.
    index: usize,
    wanted: Mask,
    batch: Batch,
    /// Whether it has singular sets.
    is_singular_somewhere: bool,
}

/// Which connectors of a plan go in lanes, for one pattern.
#[derive(Clone, Debug, Default)]
pub(super) struct Lanes {
    kinds: Vec<Kind>,
    of: Vec<Option<u32>>,
}

/// The rows of a part, and room for what they are made from.
#[derive(Default)]
pub(super) struct Rows {
    /// Of each connector of the part.
    pub(super) all: Vec<Option<Components<CompactRow<f64>>>>,
    members: Vec<(u32, usize)>,
    tiles: Vec<Tile>,
    sections: Vec<Section>,
    histories: Vec<History>,
    found: Vec<batch::CompactRow>,
}

impl Lanes {
    pub(super) fn new(
        (model, connectors): (&Model, &[usize]),
        jacobian: &Jacobian,
        (followed, needed): (&[Mask], &[Needed]),
    ) -> Self {
        let mut lanes = Self::default();
        let mut last = 0;
        for (at, index) in connectors.iter().enumerate() {
            let element = &model.connectors[*index];
            let (connector, wanted) = (&element.connector, jacobian.wanted(at));
            let is_plain = !needed[at].always
                && !connector.history_turns(followed[at])
                && !connector.is_planar()
                && connector.undetermined_origins().iter().all(Option::is_none)
                && !(0..6).any(|k| wanted[k] && connector.row_has_history(k))
                && wanted != [false; 6];
            let place = is_plain.then(|| {
                let is_of = |kind: &Kind| {
                    kind.wanted == wanted && model.connectors[kind.index].connector.has_measures_of(connector)
                };
                if lanes.kinds.get(last).is_some_and(is_of) {
                    return Some(last);
                }
                if let Some(known) = lanes.kinds.iter().position(is_of) {
                    return Some(known);
                }
                let batch = Batch::new(connector, wanted).ok()?;
                let is_singular_somewhere = batch.measures().iter().any(|(k, of)| {
                    of.singular_set().is_some()
                        || connector.position_measure(*k).is_some_and(|of| of.singular_set().is_some())
                });
                lanes.kinds.push(Kind { index: *index, wanted, batch, is_singular_somewhere });
                Some(lanes.kinds.len() - 1)
            });
            let place = place.flatten();
            last = place.unwrap_or(last);
            lanes.of.push(place.and_then(|place| u32::try_from(place).ok()));
        }
        lanes
    }

    /// The rows of the connectors of a part that go in lanes, `first` of the plan on, and what needs care of them.
    pub(super) fn rows(
        &self,
        (model, connectors): (&Model, &[usize]),
        (first, memories): (usize, &[Memory]),
        (ends, moved): (&[[Place; 2]], &[Moved]),
        rows: &mut Rows,
        (flags, tally): (&mut Vec<(usize, Flag)>, &mut Tally),
    ) {
        rows.all.clear();
        rows.all.resize(memories.len(), None);
        rows.members.clear();
        rows.members.extend((0..memories.len()).filter_map(|at| Some(((*self.of.get(first + at)?)?, at))));
        // The sort keeps their order.
        rows.members.sort_by_key(|(kind, _)| *kind);
        let members = std::mem::take(&mut rows.members);
        for of_kind in members.chunk_by(|(one, _), (other, _)| one == other) {
            let Some(kind) = of_kind.first().and_then(|(kind, _)| self.kinds.get(*kind as usize)) else {
                continue;
            };
            rows.tiles.clear();
            rows.sections.clear();
            rows.histories.clear();
            for four in of_kind.chunks(LANES) {
                let at: [usize; LANES] = std::array::from_fn(|lane| four[lane.min(four.len() - 1)].1);
                let elements = at.map(|at| &model.connectors[connectors[first + at]]);
                let nodes = [0, 1].map(|end| {
                    at.map(|at| ends[first + at][end].map_or(&STILL, |place| &moved[place as usize]))
                });
                let poses = Poses {
                    displacement: nodes.map(|of| of.map(|node| &node.displacement)),
                    rotation: nodes.map(|of| of.map(|node| &node.rotation)),
                };
                let triads = Triads::new(&elements.map(|element| element.triads()));
                let mut tile = Tile::initial(&elements.map(|element| element.reference), &triads);
                tile.place(&triads, &poses);
                rows.tiles.push(tile);
                rows.sections.push(Section::new(&elements.map(|element| &element.connector)));
                rows.histories.push(History::new(&at.map(|at| memories[at].branch)));
            }
            let each = kind.batch.rows();
            rows.found.resize(rows.tiles.len() * each, batch::CompactRow::default());
            let done = kind.batch.rows_of(&rows.tiles, &rows.sections, &rows.histories, &mut rows.found);
            debug_assert_eq!(done, Ok(()), "the slices have been made for each other");
            tally.gradients += (of_kind.len() * each) as u64;
            for (n, (_, at)) in of_kind.iter().enumerate() {
                let (tile, lane) = (n / LANES, n % LANES);
                if !kind.batch.takes(&rows.tiles[tile], lane) {
                    continue;
                }
                let mut own = [None; 6];
                for ((k, _), row) in kind.batch.measures().iter().zip(&rows.found[tile * each..]) {
                    own[*k] = Some(row.lane(lane));
                }
                rows.all[*at] = Some(own);
                if kind.is_singular_somewhere {
                    let index = connectors[first + at];
                    let pair = rows.tiles[tile].lane(lane);
                    let state = State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
                    look(
                        model,
                        (index, kind.wanted),
                        (&state, &memories[*at]),
                        |flag| flags.push((first + at, flag)),
                        tally,
                    );
                }
            }
        }
        rows.members = members;
    }
}

/// Whether a connector is near a singular set.
fn look(
    model: &Model,
    (index, wanted): (usize, Mask),
    (state, memory): (&State<f64>, &Memory),
    tell: impl FnMut(Flag),
    tally: &mut Tally,
) {
    let connector = &model.connectors[index].connector;
    let margins = connector.margins(state, &memory.branch, wanted);
    tally.margins += margins.iter().flatten().count() as u64;
    let branches = [&memory.branch; 2];
    let flags = connector.flags_of([false; 6], &margins, &Increment::none(), state, branches);
    flags.into_iter().for_each(tell);
}
