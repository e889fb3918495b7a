//! Which degrees of freedom are unknown, and which equations count.

use crate::motion::mechanism::{Hold, Mechanism};
use crate::motion::mode::Modes;
use crate::motion::rows::{Assembled, Layout, Line, Lines, Owner, Row};
use crate::motion::state::DOFS;
use crate::number::Number;
use crate::refusal::Refusal;
use std::collections::BTreeMap;

/// Entries of rows below this count as zero, and rows that are nearer to a combination of others as one.
const ZERO: f64 = 1e-9;

impl Layout {
    /// That of a mode. An equation that follows from those before it does not count; where friction needs its force, that is refused.
    pub(crate) fn new<R: Number>(
        mechanism: &Mechanism<R>,
        assembled: &Assembled<R>,
        modes: &Modes<R>,
    ) -> Result<Self, Refusal> {
        let count = DOFS * mechanism.bodies.len();
        let mut is_touched = vec![false; count];
        for row in &assembled.rows {
            for (dof, entry) in
                [row.coefficients, row.force()].into_iter().flat_map(|line| assembled.lines.of(line))
            {
                is_touched[*dof] |= entry.to_f64().abs() > ZERO;
            }
        }
        let is_unknown = |dof: &usize| {
            let acts = assembled.has_inertia(*dof) || is_touched[*dof] || assembled.is_loaded(*dof);
            let is_carried = dof % DOFS < 6 && assembled.lines.carried(dof / DOFS).is_some();
            acts && !mechanism.held[*dof] && !is_carried
        };
        let columns: Vec<usize> = (0..count).filter(is_unknown).collect();
        let acting = assembled.acting(mechanism);
        let may_act = |dof: usize| {
            let group = dof - dof % DOFS + dof % DOFS / 3 * 3;
            dof % DOFS < 6 && acting[group..group + 3].contains(&true)
        };
        let is_idle = |dof: &usize| {
            let is_carried = assembled.lines.carried(dof / DOFS).is_some();
            may_act(*dof) && !is_unknown(dof) && !mechanism.held[*dof] && !is_carried
        };
        let idle = (0..count).filter(is_idle).collect();
        let mut place = vec![None; count];
        for (i, dof) in columns.iter().enumerate() {
            place[*dof] = Some(i);
        }
        let mut layout = Self { columns, place, idle, ..Self::default() };
        layout.keep(mechanism, assembled, modes, false)?;
        layout.determine(mechanism, assembled);
        Ok(layout)
    }

    /// Whether something acts now on what has no inertia, where nothing did before.
    pub(crate) fn wakes<R: Number>(&self, mechanism: &Mechanism<R>, assembled: &Assembled<R>) -> bool {
        let unit = |dof: usize| if dof % DOFS < 3 { 1.0 } else { mechanism.length };
        let load = |dof: usize| assembled.applied[dof].to_f64().abs() / unit(dof);
        let most = (0..assembled.applied.len()).map(load).fold(0.0, f64::max);
        let rows = assembled.rows.iter().flat_map(|row| assembled.lines.of(row.coefficients));
        self.idle.iter().any(|dof| ZERO * most < load(*dof))
            || rows
                .into_iter()
                .any(|(dof, x)| self.idle.contains(dof) && ZERO < x.to_f64().abs() / unit(*dof))
    }

    /// The nodal forces of a unit of the force of an equation. Where others repeat it they are its coefficients: its connector may have equations
    /// that do not count, and what their forces span together, those of the rest may not.
    pub(crate) fn force<R>(&self, index: usize, row: &Row<R>) -> Line {
        match self.open.binary_search(&index) {
            Ok(_) => row.coefficients,
            Err(_) => row.force(),
        }
    }

    /// The equations whose forces others leave open, friction or not.
    pub(crate) fn undetermined<R: Number>(
        &self,
        mechanism: &Mechanism<R>,
        assembled: &Assembled<R>,
        modes: &Modes<R>,
    ) -> Result<Vec<usize>, Refusal> {
        let mut layout = Self { columns: self.columns.clone(), place: self.place.clone(), ..Self::default() };
        layout.keep(mechanism, assembled, modes, true)?;
        Ok(layout.open)
    }

    /// Finds the order of elimination, where equations have more entries than ever, and what it does, where they have others.
    pub(crate) fn arrange<R: Number>(&mut self, assembled: &Assembled<R>) {
        let filled = assembled
            .rows
            .iter()
            .map(|row| assembled.lines.of(row.coefficients).len() + assembled.lines.of(row.force()).len())
            .sum();
        let is_more = filled > self.filled;
        let mut matrix = assembled.matrix(self, 0);
        if is_more {
            self.filled = filled;
            self.order = matrix.sparse_order();
            matrix = matrix.ordered(&self.order);
        }
        // Inertias turn with their nodes.
        let place = &self.place;
        let turns = self.columns.iter().enumerate().filter(|(_, dof)| (3..6).contains(&(**dof % DOFS)));
        let turned = turns.flat_map(|(i, dof)| {
            let node = DOFS * (dof / DOFS);
            (3..6).filter_map(move |k| Some((i, place[node + k]?)))
        });
        let turned: Vec<(usize, usize)> = turned.collect();
        if let Some(plan) = matrix.plan(&self.plan, is_more, &turned) {
            self.plan = plan;
        }
    }

    /// Finds the equations that count, one after the other.
    fn keep<R: Number>(
        &mut self,
        mechanism: &Mechanism<R>,
        assembled: &Assembled<R>,
        modes: &Modes<R>,
        may_be_open: bool,
    ) -> Result<(), Refusal> {
        let n = self.columns.len();
        // Rows with an unknown of their own follow from no others, and no others from them.
        let alone = self.alone(mechanism, assembled);
        let mut chosen: Vec<usize> = Vec::new();
        // Orthonormal directions, with the equations that each is made of.
        let mut basis: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        // Stick comes last: what boundary conditions hold or move needs no friction to do so.
        let sticks = |owner: Owner| match owner {
            Owner::Joint(joint, k) => mechanism.is_stuck(modes, joint, k),
            _ => false,
        };
        let [held, stuck] = [false, true].map(|wanted| {
            assembled.rows.iter().enumerate().filter(move |(_, row)| sticks(row.owner) == wanted)
        });
        for (index, row) in held.chain(stuck).filter(|(index, _)| !alone[*index]) {
            let mut vector = vec![0.0; n];
            self.entries(mechanism, (&assembled.lines, row))
                .for_each(|(place, entry)| vector[place] += entry);
            let size = norm(&vector);
            if size <= ZERO * ZERO {
                // All of it is held. Where beams lead to what holds it, its force may be in them.
                if mechanism.has_carried(row.owner) {
                    if !may_be_open {
                        needed(mechanism, assembled, modes, &[index])?;
                    }
                    self.open.push(index);
                }
                continue;
            }
            vector.iter_mut().for_each(|x| *x /= size);
            let mut made = vec![0.0; chosen.len() + 1];
            made[chosen.len()] = 1.0;
            for _ in 0..2 {
                for (direction, of) in &basis {
                    let part: f64 = vector.iter().zip(direction).map(|(x, y)| x * y).sum();
                    vector.iter_mut().zip(direction).for_each(|(x, y)| *x -= part * y);
                    made.iter_mut().zip(of).for_each(|(x, y)| *x -= part * y);
                }
            }
            let left = norm(&vector);
            if left > ZERO {
                if self.nearest.is_none_or(|(least, _)| left < least) {
                    self.nearest = Some((left, row.owner));
                }
                vector.iter_mut().for_each(|x| *x /= left);
                made.iter_mut().for_each(|x| *x /= left);
                basis.push((vector, made));
                chosen.push(index);
                continue;
            }
            let involved = made.iter().zip(chosen.iter().chain([&index]));
            let involved: Vec<usize> =
                involved.filter(|(part, _)| part.abs() > ZERO).map(|(_, index)| *index).collect();
            // At a dead point a row may follow from those of other connectors for a moment: they do not hold it.
            let holds = |of: &usize| match (assembled.rows[*of].owner, row.owner) {
                (Owner::Bound(_), _) => true,
                (Owner::Joint(of, k), Owner::Joint(joint, own)) => {
                    of == joint && (k == own || !mechanism.is_stuck(modes, of, k))
                }
                _ => false,
            };
            let carries = |of: &usize| *of == index || !sticks(assembled.rows[*of].owner);
            if let (true, Owner::Joint(joint, k)) = (sticks(row.owner), row.owner)
                && (involved.iter().all(holds) || mechanism.is_still && involved.iter().all(carries))
            {
                self.carried.push((joint, k));
                continue;
            }
            if !may_be_open {
                needed(mechanism, assembled, modes, &involved)?;
            }
            self.open.extend(involved);
        }
        self.kept = chosen;
        self.kept.extend((0..alone.len()).filter(|index| alone[*index]));
        self.kept.sort_unstable();
        self.open.sort_unstable();
        self.open.dedup();
        Ok(())
    }

    /// The entries of an equation by the places of unknowns, rotations by the size of lengths.
    fn entries<'a, R: Number>(
        &'a self,
        mechanism: &'a Mechanism<R>,
        (lines, row): (&'a Lines<R>, &Row<R>),
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        lines.of(row.coefficients).iter().filter_map(|(dof, entry)| {
            let scale = if dof % DOFS < 3 { 1.0 } else { mechanism.length };
            Some((self.place[*dof]?, entry.to_f64() / scale))
        })
    }

    /// Which equations have an unknown that no other one has; and which have one once those are set aside.
    fn alone<R: Number>(&self, mechanism: &Mechanism<R>, assembled: &Assembled<R>) -> Vec<bool> {
        /// Of the largest entry of a row, what is no rounding.
        const CLEAR: f64 = 1e-3;
        let mut of_columns: Vec<Vec<usize>> = vec![Vec::new(); self.columns.len()];
        let mut entries: Vec<BTreeMap<usize, f64>> = Vec::with_capacity(assembled.rows.len());
        for (index, row) in assembled.rows.iter().enumerate() {
            let mut all = BTreeMap::new();
            self.entries(mechanism, (&assembled.lines, row))
                .for_each(|(place, entry)| *all.entry(place).or_insert(0.0) += entry);
            all.keys().for_each(|place| of_columns[*place].push(index));
            entries.push(all);
        }
        let mut left: Vec<usize> = of_columns.iter().map(Vec::len).collect();
        let mut alone = vec![false; entries.len()];
        let mut single: Vec<usize> = (0..left.len()).filter(|place| left[*place] == 1).collect();
        while let Some(place) = single.pop() {
            let Some(index) = of_columns[place].iter().copied().find(|index| !alone[*index]) else {
                continue;
            };
            let of = &entries[index];
            let size = of.values().fold(0.0_f64, |most, x| most.max(x.abs()));
            if of[&place].abs() <= (CLEAR * size).max(ZERO) {
                continue;
            }
            alone[index] = true;
            for other in of.keys() {
                left[*other] -= 1;
                if left[*other] == 1 {
                    single.push(*other);
                }
            }
        }
        alone
    }

    /// Finds what equations alone determine: sets of unknowns that share equations, and have as many.
    fn determine<R: Number>(&mut self, mechanism: &Mechanism<R>, assembled: &Assembled<R>) {
        let n = self.columns.len();
        let mut root: Vec<usize> = (0..n).collect();
        fn find(root: &mut [usize], mut i: usize) -> usize {
            while root[i] != i {
                root[i] = root[root[i]];
                i = root[i];
            }
            i
        }
        // An equation couples all degrees of freedom of its nodes: entries that are zero now need not stay so.
        let places = |row: usize| -> Vec<usize> {
            let nodes = mechanism.nodes_of(assembled.rows[row].owner);
            let dofs = nodes.into_iter().flat_map(|node| DOFS * node..DOFS * (node + 1));
            dofs.filter_map(|dof| self.place[dof]).collect()
        };
        for row in &self.kept {
            let places = places(*row);
            for pair in places.windows(2) {
                let (i, j) = (find(&mut root, pair[0]), find(&mut root, pair[1]));
                root[i] = j;
            }
        }
        let mut sets: Vec<(Vec<usize>, Vec<usize>)> = vec![(Vec::new(), Vec::new()); n];
        for i in 0..n {
            sets[find(&mut root, i)].0.push(i);
        }
        for row in &self.kept {
            if let Some(first) = places(*row).first() {
                sets[find(&mut root, *first)].1.push(*row);
            }
        }
        sets.retain(|(unknowns, rows)| !rows.is_empty() && unknowns.len() == rows.len());
        self.determined = sets;
    }
}

/// Whether friction needs a force that these equations leave undetermined.
fn needed<R: Number>(
    mechanism: &Mechanism<R>,
    assembled: &Assembled<R>,
    modes: &Modes<R>,
    involved: &[usize],
) -> Result<(), Refusal> {
    let owners: Vec<Owner> = involved.iter().map(|index| assembled.rows[*index].owner).collect();
    let stopped = owners.iter().find(|owner| match owner {
        Owner::Joint(joint, k) => matches!(mechanism.hold(modes, *joint, *k), Hold::Stopped(_)),
        _ => false,
    });
    if let Some(owner) = stopped {
        return Err(Refusal::of(
            &mechanism.named(*owner),
            "the force of its stop is not determined, for other constraints hold it as well",
            "take one of the two out, or give the stop a spring: *CONNECTOR ELASTICITY, NONLINEAR",
        ));
    }
    for (slider, mode) in mechanism.sliders.iter().zip(&modes.frictions) {
        let Some(friction) = mechanism.friction(slider).filter(|_| !mechanism.is_gone(modes, slider)) else {
            continue;
        };
        let presses = friction.criterion.pressing_components();
        let needs = |k: usize| {
            let slides = mode.is_stuck() && slider.components.iter().any(|(of, _)| *of == k);
            presses[k] || slides && mechanism.is_stuck(modes, slider.joint, k)
        };
        let found = owners
            .iter()
            .any(|owner| matches!(owner, Owner::Joint(joint, k) if *joint == slider.joint && needs(*k)));
        if found {
            let title = &mechanism.joints[slider.joint].title;
            let names: Vec<String> = owners.iter().take(6).map(|owner| mechanism.named(*owner)).collect();
            let more = if owners.len() > names.len() { ", …" } else { "" };
            return Err(Refusal::of(
                title,
                &format!(
                    "the forces that press are not determined, for constraints repeat each other: {}{more}",
                    names.join(", ")
                ),
                "release one of these; pintle audit names all that are redundant",
            ));
        }
    }
    Ok(())
}

fn norm(of: &[f64]) -> f64 {
    of.iter().map(|x| x * x).sum::<f64>().sqrt()
}
