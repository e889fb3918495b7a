//! The sparse Jacobian along a walk.

use super::element::Context;
use super::nodes::STILL;
use super::{Sequence, at_mpc, turns};
use crate::catalog::COMPONENT;
use crate::connector::{CompactRow, Flag, Request, Tally};
use crate::evaluate::jacobian::{CompressedColumns, ForeignPattern, Jacobian};
use crate::evaluate::parallel::{self, in_order};
use crate::mpc::{self, Dofs};
use crate::scene::State as SceneState;
use std::convert::Infallible;

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
        self.fill(state, jacobian, |entry| entry, values)
    }

    /// As [`Sequence::assemble`], with the entries in the order of the columns ([`Jacobian::by_columns`]): each goes straight to its place from the
    /// compact rows of its element.
    ///
    /// # Errors
    /// As [`Sequence::assemble`]; columns of another pattern.
    pub fn assemble_columns(
        &mut self,
        state: &SceneState,
        jacobian: &Jacobian,
        columns: &CompressedColumns,
        values: &mut Vec<f64>,
    ) -> Result<Vec<(String, Flag)>, ForeignPattern> {
        columns.check(jacobian)?;
        self.fill(state, jacobian, |entry| columns.place(entry), values)
    }

    /// Writes entry number i, by rows, to place `place(i)` of the values.
    fn fill(
        &mut self,
        state: &SceneState,
        jacobian: &Jacobian,
        place: impl Fn(usize) -> usize,
        values: &mut Vec<f64>,
    ) -> Result<Vec<(String, Flag)>, ForeignPattern> {
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
        values.clear();
        values.resize(jacobian.entries(), 0.0);
        self.follow_nodes(state);
        let beyond = self.beyond(state);
        self.make_room();
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
            rooms,
            mpc_nodes,
            mpcs,
            ..
        } = self;
        let followed = &*followed;
        let context = Context {
            model,
            planned: &plan.request,
            velocities: *velocities,
            conditions,
            scene_state: state,
            beyond: &beyond,
        };
        let mut care = Vec::new();
        let mut entries = 0;
        let mut put = |entry| {
            if let Some(value) = values.get_mut(place(entries)) {
                *value = entry;
            }
            entries += 1;
        };
        let mut rooms: Vec<_> = rooms.0.iter_mut().map(|result| (result, [const { None }; 6])).collect();
        let Ok(()) = in_order(
            connectors,
            &mut rooms,
            |at, memory, (result, rows)| {
                let mut tally = Tally::default();
                let nodes = ends[at].map(|end| end.map_or(&STILL, |end| &moved[end as usize]));
                let mut request = Request::nothing(0);
                request.add_rows(jacobian.wanted(at));
                let index = plan.connectors[at];
                let history = (followed[at], needed[at].always);
                context.connector((index, nodes), memory, &request, history, result, &mut tally);
                let element = &model.connectors[index];
                let branch = &result.evaluation.branch;
                *rows =
                    element.connector.compact_rows(&result.state, branch, jacobian.wanted(at), &mut tally);
                let mut flags = std::mem::take(&mut result.flags);
                let wanted = jacobian.wanted(at);
                let broken = |k: &usize| {
                    wanted[*k] && rows[*k].as_ref().is_none_or(|row: &CompactRow<f64>| !row.is_finite())
                };
                flags.extend(
                    (0..6)
                        .filter(broken)
                        .map(|k| Flag::NotFinite { component: COMPONENT[k], quantity: "derivative" }),
                );
                (flags, tally)
            },
            |at, (flags, work), (_, rows)| -> Result<(), Infallible> {
                *tally += work;
                jacobian.write(at, rows, &mut put);
                let title = || model.connectors[plan.connectors[at]].title();
                care.extend(flags.into_iter().map(|flag| (title(), flag)));
                Ok(())
            },
        );
        let mut request = Request::nothing(1);
        request.add_rows([true; 6]);
        let mut rooms: Vec<mpc::Rows<Dofs<f64>>> = vec![Default::default(); parallel::held(mpcs.len())];
        let Ok(()) = in_order(
            mpcs,
            &mut rooms,
            |at, angles, rows| {
                let mut tally = Tally::default();
                let index = plan.mpcs[at];
                let element = &model.mpcs[index];
                let (nodes, count) = at_mpc(&mpc_nodes[at], moved);
                let of_state = (&request, &model.schedule, state);
                let result = element.evaluate(index, &nodes[..count], angles, of_state, &mut tally);
                *angles = result.evaluation.angles;
                *rows = result.evaluation.jacobian;
                let mut flags = result.flags;
                let has = element.constraint.rows();
                let is_broken = |row: &Dofs<f64>| row.iter().any(|x| !x.is_finite());
                let broken = |row: &usize| has[*row] && rows[*row].as_ref().is_none_or(is_broken);
                flags.extend((0..rows.len()).filter(broken).map(|row| Flag::NotFinite {
                    component: element.constraint.kind().row_name(row),
                    quantity: "derivative",
                }));
                (flags, tally)
            },
            |at, (flags, work), rows| -> Result<(), Infallible> {
                *tally += work;
                jacobian.write_mpc(at, rows, &mut put);
                let title = || model.mpcs[plan.mpcs[at]].title();
                care.extend(flags.into_iter().map(|flag| (title(), flag)));
                Ok(())
            },
        );
        self.states += 1;
        Ok(care)
    }
}
