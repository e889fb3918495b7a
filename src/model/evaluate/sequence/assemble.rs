//! The sparse Jacobian along a walk.
//!
//! Entries by rows are those of one element after the other, so that each thread writes its own part of them, and nothing is left to be
//! done in order but to gather what needs care.

use crate::evaluate::jacobian::{ForeignPattern, Jacobian};
use crate::evaluate::parallel;
use crate::evaluate::sequence::element::{ConnectorResult, Context};
use crate::evaluate::sequence::lanes::{Lanes, PART, Room};
use crate::evaluate::sequence::nodes::STILL;
use crate::evaluate::sequence::{Sequence, at_mpc, at_relation, turns};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{CompactRow, Components, Flag, Mask, Request, Tally};
use pintle_kinematics::mpc::Dofs;
use pintle_scene::State as SceneState;
use std::sync::Arc;

/// Elements of which one is next to the other, and their entries.
struct Part<'p, M> {
    /// The place of the first in the plan.
    first: usize,
    memories: &'p mut [M],
    entries: &'p mut [f64],
}

/// What came of a part besides its entries.
#[derive(Default)]
struct Told {
    /// What needs care, by the place of the element in the plan.
    flags: Vec<(usize, Flag)>,
    tally: Tally,
}

/// Fills the entries of elements in parts of that size; `begin` gives the first entry of each element, and the end after the last.
fn fill<M: Send>(
    (memories, size): (&mut [M], usize),
    begin: impl Fn(usize) -> usize,
    values: &mut [f64],
    work: impl Fn(Part<'_, M>) -> Told + Sync,
) -> Told {
    let mut entries = values.get_mut(begin(0)..).unwrap_or_default();
    let mut parts = Vec::with_capacity(memories.len().div_ceil(size));
    let mut first = 0;
    for memories in memories.chunks_mut(size) {
        let next = first + memories.len();
        let count = (begin(next) - begin(first)).min(entries.len());
        let (own, others) = entries.split_at_mut(count);
        parts.push(Part { first, memories, entries: own });
        (first, entries) = (next, others);
    }
    let mut told = Told::default();
    for Told { flags, tally } in parallel::parts(parts, work) {
        told.flags.extend(flags);
        told.tally += tally;
    }
    told
}

impl Sequence<'_> {
    /// Commits the next state and writes the entries of the sparse Jacobian there, and nothing else of it: `values` gets the length of
    /// [`Jacobian::entries`] and, in its order, the entries. Gives what needs care.
    ///
    /// # Errors
    /// A pattern that was made for another plan; one with rows whose history has not been followed. Then nothing is committed.
    pub fn assemble(
        &mut self,
        state: &SceneState,
        jacobian: &Jacobian,
        values: &mut Vec<f64>,
    ) -> Result<Vec<(String, Flag)>, ForeignPattern> {
        self.follow_rows(jacobian)?;
        values.resize(jacobian.entries(), 0.0);
        self.follow_nodes(state);
        let beyond = self.beyond(state);
        let Self {
            model,
            plan,
            moved,
            ends,
            connectors,
            followed,
            needed,
            tally,
            velocities,
            conditions,
            mpc_nodes,
            relation_nodes,
            mpcs,
            lanes,
            ..
        } = self;
        let context = Context {
            model,
            planned: &plan.request,
            velocities: *velocities,
            conditions,
            scene_state: state,
            beyond: &beyond,
        };
        let (followed, needed) = (&*followed, &*needed);
        let are_in_lanes = state.forces.is_empty();
        let of_connectors = |Part { first, memories, entries }: Part<'_, _>| {
            let (mut told, mut result, mut room) =
                (Told::default(), ConnectorResult::room(), Room::default());
            if are_in_lanes {
                let of = (&**model, plan.connectors.as_slice(), jacobian);
                let told = (&mut told.flags, &mut told.tally);
                lanes.rows(first / PART, of, (memories, moved), (entries, &mut room), told);
            } else {
                room.alone.extend((first..first + memories.len()).filter_map(|at| u32::try_from(at).ok()));
            }
            let first_entry = jacobian.first_entry(first);
            for at in room.alone.drain(..).map(|at| at as usize) {
                let memory = &mut memories[at - first];
                let nodes = ends[at].map(|end| end.map_or(&STILL, |end| &moved[end as usize]));
                let wanted = jacobian.wanted(at);
                let mut request = Request::nothing(0);
                request.add_rows(wanted);
                let index = plan.connectors[at];
                let history = (followed[at], needed[at].always);
                context.connector((index, nodes), memory, &request, history, &mut result, &mut told.tally);
                let (connector, branch) = (&model.connectors[index].connector, &result.evaluation.branch);
                let rows = connector.compact_rows(&result.state, branch, wanted, &mut told.tally);
                let these =
                    jacobian.first_entry(at) - first_entry..jacobian.first_entry(at + 1) - first_entry;
                jacobian.write_rows(at, &rows, entries.get_mut(these).unwrap_or_default());
                let flags = result.flags.drain(..).chain(broken(wanted, &rows));
                told.flags.extend(flags.map(|flag| (at, flag)));
            }
            told.flags.sort_by_key(|(at, _)| *at);
            told
        };
        let told = fill((connectors, PART), |at| jacobian.first_entry(at), values, of_connectors);
        *tally += told.tally;
        let title = |at: usize| model.connectors[plan.connectors[at]].title();
        let mut care: Vec<_> = told.flags.into_iter().map(|(at, flag)| (title(at), flag)).collect();
        let mut request = Request::nothing(1);
        request.add_rows([true; 6]);
        let [mpc_part, relation_part] = [mpcs.len(), relation_nodes.len()].map(parallel::part);
        let of_mpcs = |Part { first, memories, entries }: Part<'_, _>| {
            let mut told = Told::default();
            let mut put = in_turn(entries);
            for (at, angles) in (first..).zip(memories) {
                let index = plan.mpcs[at];
                let element = &model.mpcs[index];
                let (nodes, count) = at_mpc(&mpc_nodes[at], moved);
                let of_state = (&request, &model.schedule, state);
                let result = element.evaluate(index, &nodes[..count], angles, of_state, &mut told.tally);
                *angles = result.evaluation.angles;
                let rows = &result.evaluation.jacobian;
                jacobian.write_mpc(at, rows, &mut put);
                let has = element.constraint.rows();
                let is_broken = |row: &Dofs<f64>| row.iter().any(|x| !x.is_finite());
                let broken = |row: &usize| has[*row] && rows[*row].as_ref().is_none_or(is_broken);
                let broken = (0..rows.len()).filter(broken).map(|row| Flag::NotFinite {
                    component: element.constraint.kind().row_name(row),
                    quantity: "derivative",
                });
                told.flags.extend(result.flags.into_iter().chain(broken).map(|flag| (at, flag)));
            }
            told
        };
        let told = fill((mpcs, mpc_part), |at| jacobian.first_mpc_entry(at), values, of_mpcs);
        *tally += told.tally;
        let title = |at: usize| model.mpcs[plan.mpcs[at]].title();
        care.extend(told.flags.into_iter().map(|(at, flag)| (title(at), flag)));
        let of_relations = |Part { first, memories, entries }: Part<'_, _>| {
            let mut told = Told::default();
            let mut put = in_turn(entries);
            for (at, nodes) in (first..).zip(&*memories) {
                let index = plan.relations[at];
                let nodes: &Vec<_> = nodes;
                let element = &model.relations[index];
                let result = element.evaluate(index, at_relation(nodes, moved), &request, &mut told.tally);
                jacobian.write_relation(at, &result.rows, &mut put);
                told.flags.extend(result.flags.into_iter().map(|flag| (at, flag)));
            }
            told
        };
        let told = fill(
            (relation_nodes, relation_part),
            |at| jacobian.first_relation_entry(at),
            values,
            of_relations,
        );
        *tally += told.tally;
        let title = |at: usize| model.relations[plan.relations[at]].title();
        care.extend(told.flags.into_iter().map(|(at, flag)| (title(at), flag)));
        self.states += 1;
        Ok(care)
    }

    /// Follows the histories that rows of the pattern depend on, which is seen to once for each pattern.
    fn follow_rows(&mut self, jacobian: &Jacobian) -> Result<(), ForeignPattern> {
        if self.pattern.as_ref().is_some_and(|known| jacobian.is_copy_of(known)) {
            return Ok(());
        }
        jacobian.check(self.plan)?;
        for (at, (index, followed)) in self.plan.connectors.iter().zip(&mut self.followed).enumerate() {
            let connector = &self.model.connectors[*index].connector;
            let (wanted, known) = (jacobian.wanted(at), *followed);
            for k in (0..6).filter(|k| wanted[*k] && !known[*k] && connector.row_has_history(*k)) {
                if self.states > 0 {
                    return Err(ForeignPattern::History);
                }
                followed[k] = true;
                turns(&mut self.turning, &self.ends[at]);
            }
        }
        let of = (self.model, self.plan.connectors.as_slice());
        let own = (self.connectors.as_slice(), self.ends.as_slice());
        self.lanes = Arc::new(Lanes::new(of, jacobian, (&self.followed, &self.needed), own));
        self.pattern = Some(jacobian.origin().clone());
        Ok(())
    }
}

/// The rows wanted that are not there, or not finite.
pub(super) fn broken(wanted: Mask, rows: &Components<CompactRow<f64>>) -> impl Iterator<Item = Flag> {
    let is_broken = [0, 1, 2, 3, 4, 5]
        .map(|k| wanted[k] && rows[k].as_ref().is_none_or(|row: &CompactRow<f64>| !row.is_finite()));
    (0..6)
        .filter(move |k| is_broken[*k])
        .map(|k| Flag::NotFinite { component: COMPONENT[k], quantity: "derivative" })
}

/// Puts one entry after the other.
fn in_turn(entries: &mut [f64]) -> impl FnMut(f64) {
    let mut places = entries.iter_mut();
    move |entry| {
        if let Some(place) = places.next() {
            *place = entry;
        }
    }
}
