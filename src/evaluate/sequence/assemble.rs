//! The sparse Jacobian along a walk.

use super::element::Context;
use super::nodes::{Moved, STILL};
use super::{Sequence, turns};
use crate::catalog::COMPONENT;
use crate::connector::{CompactRow, Components, Flag, Request, Tally};
use crate::evaluate::jacobian::{CompressedColumns, ForeignPattern, Jacobian};
use crate::evaluate::parallel::in_order;
use crate::mpc::Dofs;
use crate::scene::State as SceneState;
use std::convert::Infallible;

/// What is found of a connector: flags, work and, where they are not written yet, its rows.
type Found = (Vec<Flag>, Tally, Option<Box<Components<CompactRow<f64>>>>);

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
        self.fill(state, jacobian, None, values)
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
        let is_same =
            columns.places.len() == jacobian.entries() && columns.offsets.len() == jacobian.columns() + 1;
        if !is_same {
            return Err(ForeignPattern::Plan);
        }
        self.fill(state, jacobian, Some(columns), values)
    }

    fn fill(
        &mut self,
        state: &SceneState,
        jacobian: &Jacobian,
        columns: Option<&CompressedColumns>,
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
        let followed = &self.followed.clone();
        values.clear();
        values.resize(jacobian.entries(), 0.0);
        self.follow_nodes(state);
        let beyond = self.beyond(state);
        self.make_room();
        let Self {
            model, plan, moved, ends, connectors, needed, tally, velocities, conditions, rooms, ..
        } = self;
        let context = Context {
            model,
            planned: &plan.request,
            velocities: *velocities,
            conditions,
            scene_state: state,
            beyond: &beyond,
        };
        let mut care = Vec::new();
        // By rows the entries of each connector are a slice of their own, which a thread may write; by columns they lie apart.
        let (mut of_connectors, mut of_mpcs): (&mut [f64], &mut [f64]) = match columns {
            None => values.split_at_mut(jacobian.connector_entries()),
            Some(_) => (&mut [], values),
        };
        let mut places = match columns {
            None => jacobian.split(std::mem::take(&mut of_connectors)),
            Some(_) => connectors.iter().map(|_| <&mut [f64]>::default()).collect(),
        };
        let mut work: Vec<_> = connectors.iter_mut().zip(&mut places).collect();
        let Ok(()) = in_order(
            &mut work,
            &mut rooms.0,
            |at, (memory, place), result| {
                let mut tally = Tally::default();
                let nodes = ends[at].map(|end| end.map_or(&STILL, |end| &moved[end as usize]));
                let mut request = Request::nothing(0);
                request.add_rows(jacobian.wanted(at));
                let index = plan.connectors[at];
                let history = (followed[at], needed[at].always);
                context.connector((index, nodes), memory, &request, history, result, &mut tally);
                let element = &model.connectors[index];
                let branch = &result.evaluation.branch;
                let rows =
                    element.connector.compact_rows(&result.state, branch, jacobian.wanted(at), &mut tally);
                if columns.is_none() {
                    let mut place = place.iter_mut();
                    jacobian
                        .write(at, &rows, |entry| place.by_ref().take(1).for_each(|place| *place = entry));
                }
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
                (flags, tally, columns.map(|_| Box::new(rows)))
            },
            |at, (flags, work, rows): Found, _| -> Result<(), Infallible> {
                *tally += work;
                if let (Some(columns), Some(rows)) = (columns, rows) {
                    let first = jacobian.first_entry(at);
                    jacobian.write(at, &rows, columns.writer(first, of_mpcs));
                }
                let title = || model.connectors[plan.connectors[at]].title();
                care.extend(flags.into_iter().map(|flag| (title(), flag)));
                Ok(())
            },
        );
        drop(work);
        let mut first = jacobian.connector_entries();
        let request = {
            let mut request = Request::nothing(1);
            request.add_rows([true; 6]);
            request
        };
        for (at, index) in self.plan.mpcs.iter().enumerate() {
            let element = &self.model.mpcs[*index];
            let nodes =
                self.mpc_nodes[at].iter().map(|node| node.map_or(STILL, |node| self.moved[node as usize]));
            let nodes: Vec<Moved> = nodes.collect();
            let of_state = (&request, &self.model.schedule, state);
            let result = element.evaluate(*index, &nodes, &self.mpcs[at], of_state, &mut self.tally);
            self.mpcs[at] = result.evaluation.angles;
            match columns {
                None => {
                    let mut place =
                        of_mpcs.split_off_mut(..jacobian.mpc_entries(at)).unwrap_or_default().iter_mut();
                    let put = |entry| place.by_ref().take(1).for_each(|place| *place = entry);
                    jacobian.write_mpc(at, &result.evaluation.jacobian, put);
                }
                Some(columns) => {
                    jacobian.write_mpc(at, &result.evaluation.jacobian, columns.writer(first, of_mpcs));
                    first += jacobian.mpc_entries(at);
                }
            }
            let rows = &result.evaluation.jacobian;
            let has = element.constraint.rows();
            let is_broken = |row: &Dofs<f64>| row.iter().any(|x| !x.is_finite());
            let broken = |row: &usize| has[*row] && rows[*row].as_ref().is_none_or(is_broken);
            let broken = (0..rows.len()).filter(broken).map(|row| Flag::NotFinite {
                component: element.constraint.kind().row_name(row),
                quantity: "derivative",
            });
            care.extend(result.flags.into_iter().chain(broken).map(|flag| (element.title(), flag)));
        }
        self.states += 1;
        Ok(care)
    }
}
