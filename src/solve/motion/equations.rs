//! The equations of motion at one instant: M a + Σ f G + h = 0, J a + b = 0, and the limit of each friction that slips.

use crate::fault::{Fault, has};
use crate::motion::linear::{Dense, NoPivot, System};
use crate::motion::mechanism::{Mechanism, Slider, Stop, TableOf};
use crate::motion::mode::{Branches, Cause, Does, Mode, Modes, Side, Switch, Touch};
use crate::motion::rows::{Assembled, Layout, Line, NoPivotAt, Owner, Row, Trouble};
use crate::motion::slide::{Contact, Limit, belt_limit, length};
use crate::motion::state::DOFS;
use crate::number::{Number, is_finite, larger, largest};
use pintle_kinematics::vector::{apply, dot};
use pintle_model::behavior::Conditions;
use std::ops::Range;

/// Accelerations and forces.
#[derive(Clone, Debug)]
pub(crate) struct Solved<R> {
    /// By node.
    pub(crate) accelerations: Vec<[R; DOFS]>,
    /// The force of each row.
    pub(crate) forces: Vec<R>,
    /// CTF of each connector.
    pub(crate) total: Vec<[R; 6]>,
    /// CSF of each connector.
    pub(crate) friction: Vec<[R; 6]>,
    /// What of it slips.
    pub(crate) slipping: Vec<[R; 6]>,
    /// The limit of each friction.
    pub(crate) limits: Vec<Limit<R>>,
    /// P of each friction.
    pub(crate) tangential: Vec<R>,
    /// Σ R_k n_k v_k of each friction that slips.
    pub(crate) slip_rates: Vec<R>,
    pub(crate) switches: Vec<Switch<R>>,
    /// The rates of [`State::sums`].
    pub(crate) sums: Vec<R>,
}

/// So many roundings of a slip rate beyond zero it has passed it.
pub(crate) const PASSED: f64 = 64.0;

/// What goes away from a limit is open from this distance on, in rounding units of the size of lengths.
pub(crate) const LEAVING: f64 = 1e5;

/// How far Newton's method goes, for friction forces.
const ITERATIONS: usize = 60;

impl<R: Number> Assembled<R> {
    /// The matrix of accelerations and forces of rows; right-hand sides are zero.
    pub(crate) fn matrix(&self, layout: &Layout, sides: usize) -> System<R> {
        let (n, m) = (layout.columns.len(), layout.kept.len());
        let mut matrix = System::new(n + m, sides).ordered(&layout.order).planned(&layout.plan);
        for (i, dof) in layout.columns.iter().enumerate() {
            let (node, k) = (dof / DOFS, dof % DOFS);
            match k {
                6 => matrix.add(i, i, self.flows[node]),
                0..3 => matrix.add(i, i, self.masses[node]),
                3..6 => {
                    for j in 0..3 {
                        if let Some(place) = layout.place[DOFS * node + 3 + j] {
                            matrix.add(i, place, self.inertias[node][k - 3][j]);
                        }
                    }
                }
                _ => {}
            }
        }
        for (r, index) in layout.kept.iter().enumerate() {
            let row = &self.rows[*index];
            for (dof, entry) in self.lines.of(layout.force(*index, row)) {
                if let Some(place) = layout.place[*dof] {
                    matrix.add(place, n + r, *entry);
                }
            }
            for (dof, entry) in self.lines.of(row.coefficients) {
                if let Some(place) = layout.place[*dof] {
                    matrix.add(n + r, place, *entry);
                }
            }
        }
        matrix
    }

    /// The change of the degrees of freedom, of least M-norm, that takes each row by −`gap`, and the impulse of each row that counts: M Δ +
    /// Gᵀ P = 0.
    pub(crate) fn correction(
        &self,
        layout: &Layout,
        gap: impl Fn(&Row<R>) -> Option<R>,
    ) -> Result<(Vec<R>, Vec<R>), Trouble> {
        let n = layout.columns.len();
        let mut matrix = self.matrix(layout, 1);
        let side = n + layout.kept.len();
        for (r, index) in layout.kept.iter().enumerate() {
            matrix.add(n + r, side, -gap(&self.rows[*index]).unwrap_or(R::ZERO));
        }
        let found = matrix.solve().map_err(|error| at(layout, error))?;
        let found = found.into_iter().next().unwrap_or_default();
        let mut change = vec![R::ZERO; layout.place.len()];
        for (x, dof) in found.iter().zip(&layout.columns) {
            change[*dof] = *x;
        }
        Ok((change, found.get(n..).unwrap_or_default().to_vec()))
    }

    /// The forces that press in a connector without those of its equations.
    fn pressing(&self, joint: usize) -> [R; 6] {
        let now = &self.joints[joint];
        std::array::from_fn(|k| now.elastic[k] + now.viscous[k] - now.load[k])
    }

    /// Adds a unit of a friction along n as a right-hand side.
    fn push(
        &self,
        matrix: &mut System<R>,
        layout: &Layout,
        side: usize,
        (slider, along): (&Slider, &[R; 6]),
    ) {
        for (k, radius) in &slider.components {
            let factor = R::from_f64(*radius) * along[*k];
            for (dof, entry) in self.lines.of(self.joints[slider.joint].columns[*k]) {
                if let Some(place) = layout.place[*dof] {
                    matrix.add(place, side, -(factor * *entry));
                }
            }
        }
    }

    /// Accelerations and forces in a mode.
    pub(crate) fn solve(
        &self,
        mechanism: &Mechanism<R>,
        layout: &Layout,
        modes: &Modes<R>,
    ) -> Result<Solved<R>, Trouble> {
        self.solve_from(mechanism, layout, modes, None)
    }

    /// The same, from the limits of frictions at an instant that is near.
    pub(crate) fn solve_near(
        &self,
        mechanism: &Mechanism<R>,
        layout: &Layout,
        (modes, limits): (&Modes<R>, &[R]),
    ) -> Result<Solved<R>, Trouble> {
        let slips = |(_, mode): &(&R, &Mode<R>)| mode.along().is_some();
        let start: Vec<R> =
            limits.iter().zip(&modes.frictions).filter(slips).map(|(limit, _)| *limit).collect();
        let is_known = limits.len() == modes.frictions.len();
        self.solve_from(mechanism, layout, modes, Some(start.as_slice()).filter(|_| is_known))
    }

    /// Other friction forces that fit a mode than those of its solution: as far as Newton's method finds them from large ones.
    pub(crate) fn others(
        &self,
        mechanism: &Mechanism<R>,
        layout: &Layout,
        (modes, solved): (&Modes<R>, &Solved<R>),
    ) -> Vec<Solved<R>> {
        /// The most frictions whose combinations of large forces are all tried.
        const ALL: usize = 4;
        /// Large forces are by so much beyond all that act.
        const LARGE: f64 = 1e4;
        /// Forces that differ by less than this part of the largest are the same.
        const SAME: f64 = 1e-6;
        let slipping: Vec<usize> =
            (0..modes.frictions.len()).filter(|s| modes.frictions[*s].along().is_some()).collect();
        let value = |of: &Solved<R>, s: usize| of.limits.get(s).map_or(R::ZERO, |limit| limit.value);
        let own: Vec<R> = slipping.iter().map(|s| value(solved, *s)).collect();
        let size = largest(solved.forces.iter().chain(&own).copied());
        let mut free = modes.clone();
        slipping.iter().for_each(|s| free.frictions[*s].branches = Branches::none());
        let mut found: Vec<Solved<R>> = Vec::new();
        for number in 1..1_usize << slipping.len().min(ALL) {
            let is_large = |i: usize| i < ALL && number >> i & 1 == 1;
            let large = size * R::from_f64(LARGE);
            let start: Vec<R> =
                own.iter().enumerate().map(|(i, own)| if is_large(i) { large } else { *own }).collect();
            let Ok(other) = self.solve_from(mechanism, layout, &free, Some(&start)) else { continue };
            let is_same = |known: &Solved<R>| {
                let apart = slipping.iter().map(|s| value(known, *s) - value(&other, *s));
                !(size * R::from_f64(SAME)).less(largest(apart))
            };
            if !is_same(solved) && !found.iter().any(is_same) {
                found.push(other);
            }
        }
        found
    }

    /// Accelerations and forces in a mode, from friction forces that are near.
    fn solve_from(
        &self,
        mechanism: &Mechanism<R>,
        layout: &Layout,
        modes: &Modes<R>,
        start: Option<&[R]>,
    ) -> Result<Solved<R>, Trouble> {
        let zero = R::ZERO;
        let (n, m) = (layout.columns.len(), layout.kept.len());
        let slipping: Vec<(usize, [R; 6])> =
            modes.frictions.iter().enumerate().filter_map(|(s, mode)| Some((s, *mode.along()?))).collect();
        let moving: Vec<[R; 6]> =
            slipping.iter().map(|(s, _)| self.slip_velocity(mechanism, modes, *s)).collect();
        let directions: Vec<[R; 6]> = slipping
            .iter()
            .zip(&moving)
            .map(|((s, along), v)| direction(&mechanism.sliders[*s], &modes.frictions[*s], along, v))
            .collect();
        let rate_of = |i: usize| moving[i].iter().zip(&directions[i]).fold(zero, |sum, (v, n)| sum + *v * *n);
        let conditions = Conditions::default();
        // A slip rate, and the point of its table where that ends.
        let with_table = |s: usize, rate: R| {
            let mut tables = mechanism.tables.iter().zip(&modes.spans);
            let table = tables.find(|(table, _)| table.of == TableOf::Slip(s));
            (rate, table.and_then(|(table, span)| table.inside(*span, rate)))
        };
        let contact_of = |s: usize| {
            let slider = &mechanism.sliders[s];
            let now = &self.joints[slider.joint];
            let friction = mechanism.friction(slider).filter(|_| slider.ring.is_none())?;
            let slip = self.slips.get(s).copied().unwrap_or(zero);
            Some(Contact::new(friction, (now.position, now.motion, slip), &conditions))
        };
        let of_ring = |s: usize, rate: (R, Option<R>)| {
            let slider = &mechanism.sliders[s];
            let (next, angle) = slider.ring?;
            let tension = |joint: usize| self.joints[joint].elastic[0] + self.joints[joint].viscous[0];
            let tensions = [tension(slider.joint), tension(next)];
            Some(belt_limit(mechanism.belt(slider)?, tensions, angle, rate, &conditions))
        };
        // The equations of connectors: connector, component, and whether friction is what holds it.
        let owners: Vec<Option<(usize, usize, bool)>> = layout
            .kept
            .iter()
            .map(|index| match self.rows[*index].owner {
                Owner::Joint(of, k) => Some((of, k, mechanism.is_stuck(modes, of, k))),
                _ => None,
            })
            .collect();
        let side = n + m;
        let mut matrix = self.matrix(layout, 1 + slipping.len());
        for (i, dof) in layout.columns.iter().enumerate() {
            matrix.add(i, side, self.applied[*dof]);
        }
        for (r, index) in layout.kept.iter().enumerate() {
            if !has(Fault::BiasLeftOut) {
                matrix.add(n + r, side, -self.rows[*index].bias);
            }
        }
        for (i, (s, _)) in slipping.iter().enumerate() {
            self.push(&mut matrix, layout, side + 1 + i, (&mechanism.sliders[*s], &directions[i]));
        }
        let found = matrix.solve().map_err(|error| at(layout, error))?;
        // What there is without friction, and what a unit of each friction changes.
        let Some((without, changes)) = found.split_first() else { return Err(Trouble::NotFound) };
        if !found.iter().flatten().all(|x| is_finite(*x)) {
            return Err(Trouble::NotFinite);
        }
        let with = |tensions: &[R], range: Range<usize>| -> Vec<R> {
            let mut sum = without[range.clone()].to_vec();
            for (tension, change) in tensions.iter().zip(changes) {
                sum.iter_mut().zip(&change[range.clone()]).for_each(|(sum, x)| *sum = *sum + *tension * *x);
            }
            sum
        };
        let mut forces = start.map_or_else(|| vec![zero; m], |start| with(start, n..n + m));
        let mut tensions = start.map_or_else(|| vec![zero; slipping.len()], <[R]>::to_vec);
        // What presses in each friction that slips: of its connector, and by which equations.
        let contacts: Vec<_> = slipping
            .iter()
            .map(|(s, _)| {
                let joint = mechanism.sliders[*s].joint;
                let all = owners.iter().enumerate();
                let presses = all.filter_map(|(r, owner)| match owner {
                    Some((of, k, false)) if *of == joint => Some((r, *k)),
                    _ => None,
                });
                (contact_of(*s), self.pressing(joint), presses.collect::<Vec<_>>())
            })
            .collect();
        let rates: Vec<_> =
            slipping.iter().enumerate().map(|(i, (s, _))| with_table(*s, rate_of(i))).collect();
        for iteration in 0.. {
            if slipping.is_empty() {
                forces = with(&[], n..n + m);
                break;
            }
            let mut limits = Dense::new(slipping.len());
            for (i, (s, _)) in slipping.iter().enumerate() {
                let (contact, own, presses) = &contacts[i];
                let mut pressing = *own;
                presses.iter().for_each(|(r, k)| pressing[*k] = pressing[*k] + forces[*r]);
                let found = match contact {
                    Some(contact) => {
                        let known = Some(&modes.frictions[*s].branches);
                        Some(contact.limit(&pressing, rates[i], known, false))
                    }
                    None => of_ring(*s, rates[i]),
                };
                let Some(found) = found else { continue };
                limits.add(i, i, R::integer(1));
                let mut right = found.value;
                for (r, k) in presses.iter().filter(|_| !has(Fault::CouplingLeftOut)) {
                    right = right + found.gradient[*k] * (without[n + r] - forces[*r]);
                    for (j, change) in changes.iter().enumerate() {
                        limits.add(i, j, -found.gradient[*k] * change[n + r]);
                    }
                }
                limits.right[i] = right;
            }
            let next = limits.solve().map_err(|error| Trouble::Singular(NoPivotAt::Slider(error.column)))?;
            if !next.iter().all(|x| is_finite(*x)) {
                return Err(Trouble::NotFinite);
            }
            let moved = with(&next, n..n + m);
            let size = largest(moved.iter().chain(&next).copied());
            let pairs = moved.iter().zip(&forces).chain(next.iter().zip(&tensions));
            let change = largest(pairs.map(|(new, old)| *new - *old));
            (forces, tensions) = (moved, next);
            let is_done = !(size * R::from_f64(1e3 * R::ROUNDING)).less(change);
            let is_faulty = has(Fault::CouplingLeftOut) && iteration > 0;
            if is_done || is_faulty {
                break;
            }
            if iteration >= ITERATIONS {
                return Err(Trouble::NotFound);
            }
        }
        let mut accelerations = with(&tensions, 0..n);
        // What equations hold, and nothing drives, rests bit for bit.
        for (unknowns, rows) in &layout.determined {
            if rows.iter().all(|row| !zero.less(self.rows[*row].bias.magnitude())) {
                unknowns.iter().for_each(|i| accelerations[*i] = zero);
            }
        }
        let mut solved = Solved {
            accelerations: vec![[zero; DOFS]; self.masses.len()],
            total: Vec::with_capacity(self.joints.len()),
            friction: Vec::with_capacity(self.joints.len()),
            slipping: Vec::with_capacity(self.joints.len()),
            limits: Vec::with_capacity(slipping.len()),
            tangential: Vec::with_capacity(slipping.len()),
            slip_rates: Vec::with_capacity(slipping.len()),
            switches: Vec::new(),
            sums: self.powers.to_vec(),
            forces,
        };
        for (x, dof) in accelerations.iter().zip(&layout.columns) {
            solved.accelerations[dof / DOFS][dof % DOFS] = *x;
        }
        for node in 0..solved.accelerations.len() {
            if let Some(of) = self.lines.carried(node) {
                let [own, by] = [node, of.by].map(|node| solved.accelerations[node]);
                solved.accelerations[node] = of.acceleration(&by, &own);
            }
        }
        for (joint, now) in self.joints.iter().enumerate() {
            solved.total.push(self.pressing(joint));
            solved.friction.push(now.held);
            solved.slipping.push([zero; 6]);
        }
        for (i, (s, _)) in slipping.iter().enumerate() {
            let slider = &mechanism.sliders[*s];
            for (k, radius) in &slider.components {
                let force = tensions[i] * R::from_f64(*radius) * directions[i][*k];
                for of in [&mut solved.slipping[slider.joint], &mut solved.friction[slider.joint]] {
                    of[*k] = of[*k] + force;
                }
            }
        }
        for (owner, force) in owners.iter().zip(&solved.forces) {
            let Some((joint, k, is_stuck)) = *owner else { continue };
            let of = if is_stuck { &mut solved.friction[joint] } else { &mut solved.total[joint] };
            of[k] = of[k] + *force;
        }
        for (joint, now) in self.joints.iter().enumerate() {
            for k in 0..6 {
                solved.total[joint][k] = solved.total[joint][k] + solved.friction[joint][k];
                if !has(Fault::FrictionForgotten) {
                    solved.sums[1] = solved.sums[1] + solved.slipping[joint][k] * now.velocity[k];
                }
            }
        }
        for (force, index) in solved.forces.iter().zip(&layout.kept).filter(|_| !has(Fault::DriveForgotten)) {
            let row = &self.rows[*index];
            solved.sums[0] = solved.sums[0] - *force * row.driven;
        }
        for (s, (slider, mode)) in mechanism.sliders.iter().zip(&modes.frictions).enumerate() {
            let total = &solved.total[slider.joint];
            let friction = &solved.friction[slider.joint];
            let mut pressing: [R; 6] = std::array::from_fn(|k| total[k] - friction[k]);
            for k in 0..6 {
                if !self.is_available(mechanism, slider.joint, k) {
                    pressing[k] = total[k];
                }
            }
            let of_slip = slipping.iter().position(|(of, _)| *of == s);
            let (rate, inside) = of_slip.map_or((zero, None), |i| rates[i]);
            let known = of_slip.map(|_| &mode.branches);
            let contact = match of_slip {
                Some(i) => &contacts[i].0,
                None => &contact_of(s),
            };
            let found = match contact {
                Some(contact) => Some(contact.limit(&pressing, (rate, inside), known, true)),
                None => of_ring(s, (rate, inside)),
            };
            let Some(found) = found else { continue };
            let tractions: Vec<R> = slider
                .components
                .iter()
                .map(|(k, radius)| friction[*k] * R::from_f64(*radius).reciprocal_or_zero())
                .collect();
            let tangential = length(&tractions);
            let mut push = |cause, value, scale| solved.switches.push(Switch { of: s, cause, value, scale });
            match &mode.does {
                Does::Sticks(_) | Does::Stretches(_) if mechanism.is_idle(modes, slider) => {}
                Does::Sticks(_) | Does::Stretches(_) => {
                    let late = if has(Fault::OnsetLate) { R::from_f64(1e-6) * found.value } else { zero };
                    push(Cause::Breaks, found.value - tangential + late, larger(found.value, tangential));
                }
                Does::Slips(_) | Does::Stands(_) => {
                    if !mode.is_stuck() {
                        push(Cause::Stops, rate, larger(rate.magnitude(), R::integer(1)));
                    }
                    for (part, [value, scale]) in found.turns.iter().filter(|_| !has(Fault::KinkPassed)) {
                        push(Cause::Turns(*part), *value, *scale);
                    }
                    if let Some([value, scale]) = found.caps {
                        push(Cause::Caps, value, scale);
                    }
                }
            }
            solved.sums.push(rate);
            solved.slip_rates.push(rate);
            solved.tangential.push(tangential);
            solved.limits.push(found);
        }
        for (s, places) in mechanism.turning() {
            if modes.frictions.get(s).is_some_and(|mode| mode.in_onset) {
                solved.sums.extend(self.slip_acceleration(&mechanism.sliders[s], &solved.accelerations));
            } else {
                solved.sums.extend(places.map(|_| zero));
            }
        }
        self.watch(mechanism, layout, modes, &mut solved);
        Ok(solved)
    }

    /// R_k times the acceleration of each component of a friction.
    pub(crate) fn slip_acceleration(&self, slider: &Slider, accelerations: &[[R; DOFS]]) -> Vec<R> {
        let now = &self.joints[slider.joint];
        let of = |(k, radius): &(usize, f64)| {
            let acceleration =
                self.lines.of(now.rows[*k]).iter().fold(now.bias[*k], |sum, (dof, entry)| {
                    sum + *entry * accelerations[dof / DOFS][dof % DOFS]
                });
            R::from_f64(*radius) * acceleration
        };
        slider.components.iter().map(of).collect()
    }

    /// R_k v_k of each component: of the state, or as integrated since slip began.
    pub(crate) fn slip_velocity(&self, mechanism: &Mechanism<R>, modes: &Modes<R>, s: usize) -> [R; 6] {
        let slider = &mechanism.sliders[s];
        let places = match modes.frictions[s].in_onset {
            true => mechanism.turning().find(|(of, _)| *of == s),
            false => None,
        };
        let Some((_, places)) = places else { return slider.rates(&self.joints[slider.joint].velocity) };
        let mut found = [R::ZERO; 6];
        for ((k, _), place) in slider.components.iter().zip(places) {
            found[*k] = self.slips.get(place).copied().unwrap_or(R::ZERO);
        }
        found
    }

    /// What supports exert in each degree of freedom, along global axes: M a + Gᵀ f less what acts there, without the rows of boundary
    /// conditions. It is zero where nothing is prescribed.
    pub(crate) fn reactions(
        &self,
        layout: &Layout,
        solved: &Solved<R>,
        accelerations: &[[R; DOFS]],
    ) -> Vec<R> {
        let mut all: Vec<R> = self.applied.iter().map(|force| -*force).collect();
        for (node, a) in accelerations.iter().enumerate() {
            let turning = apply(&self.inertias[node], [a[3], a[4], a[5]]);
            for k in 0..3 {
                let (of_force, of_moment) = (DOFS * node + k, DOFS * node + 3 + k);
                all[of_force] = all[of_force] + self.masses[node] * a[k];
                all[of_moment] = all[of_moment] + turning[k];
            }
        }
        let mut add = |force: R, column: Line| {
            for (dof, entry) in self.lines.of(column) {
                all[*dof] = all[*dof] + force * *entry;
            }
        };
        for (force, index) in solved.forces.iter().zip(&layout.kept) {
            let row = &self.rows[*index];
            if !matches!(row.owner, Owner::Bound(_)) {
                add(*force, layout.force(*index, row));
            }
        }
        for (now, friction) in self.joints.iter().zip(&solved.slipping) {
            for (column, force) in now.columns.iter().zip(friction) {
                add(*force, *column);
            }
        }
        all
    }

    /// The degrees of freedom that supports hold, with a reaction that is the only one: no force that is one of many acts there.
    pub(crate) fn supported(&self, mechanism: &Mechanism<R>, layout: &Layout) -> Vec<bool> {
        let mut held = mechanism.held.clone();
        for row in self.rows.iter().filter(|row| matches!(row.owner, Owner::Bound(_))) {
            self.lines.of(row.coefficients).iter().for_each(|(dof, _)| held[*dof] = true);
        }
        for row in layout.open.iter().filter_map(|row| self.rows.get(*row)) {
            self.lines.of(row.force()).iter().for_each(|(dof, _)| held[*dof] = false);
        }
        held
    }

    /// The force of the row of a component, where it has one.
    pub(crate) fn row_force(&self, layout: &Layout, forces: &[R], joint: usize, k: usize) -> Option<R> {
        let mut rows = layout.kept.iter().zip(forces);
        rows.find_map(|(row, force)| (self.rows[*row].owner == Owner::Joint(joint, k)).then_some(*force))
    }

    /// What may end the mode of stops, locks, failures and tables.
    fn watch(&self, mechanism: &Mechanism<R>, layout: &Layout, modes: &Modes<R>, solved: &mut Solved<R>) {
        let length = R::from_f64(mechanism.length);
        let unit = |k: usize| if k < 3 { length } else { R::integer(1) };
        let size = larger(largest(solved.forces.iter().copied()), R::from_f64(f64::MIN_POSITIVE));
        for (of, (stop, touch)) in mechanism.stops.iter().zip(&modes.stops).enumerate() {
            let Stop { joint, component: k, .. } = *stop;
            if modes.has_failed(joint, k) {
                continue;
            }
            let mut push = |cause, value, scale| solved.switches.push(Switch { of, cause, value, scale });
            if let Touch::Closed(side) = touch {
                if let Some(force) = self.row_force(layout, &solved.forces, joint, k)
                    && !has(Fault::StopPulls)
                {
                    push(Cause::Opens, side.sign::<R>() * force, size);
                }
                continue;
            }
            for side in Side::BOTH {
                let Some(gap) = stop.gap(side, self.joints[joint].position[k]) else { continue };
                let scale = unit(k);
                // What goes away from a limit has rounding on either side of it, and so has what something else holds there.
                let leaves = *touch == Touch::Leaves(side)
                    || self.row_force(layout, &solved.forces, joint, k).is_some();
                let gap = match modes.left(of).filter(|_| *touch == Touch::Leaves(side)) {
                    Some([_, beyond]) => gap + beyond,
                    None if leaves => gap + scale * R::from_f64(LEAVING * R::ROUNDING),
                    None => gap,
                };
                push(Cause::Closes(side), gap, scale);
            }
        }
        for (of, criterion) in mechanism.criteria.iter().enumerate() {
            if !criterion.waits(modes) {
                continue;
            }
            let k = criterion.component;
            for (i, limit) in criterion.limits.iter().enumerate() {
                let Some(limit) = *limit else { continue };
                let is_force = i >= 2;
                let now = match is_force {
                    true => solved.total[criterion.joint][k],
                    false => self.joints[criterion.joint].position[k],
                };
                let value = if i % 2 == 0 { now - limit } else { limit - now };
                let scale = if is_force { larger(size, limit.magnitude()) } else { unit(k) };
                solved.switches.push(Switch { of, cause: Cause::Meets(i), value, scale });
            }
        }
        for (of, (table, span)) in mechanism.tables.iter().zip(&modes.spans).enumerate() {
            if let TableOf::Joint(joint, k) = table.of
                && modes.has_failed(joint, k)
            {
                continue;
            }
            if let TableOf::Slip(s) = table.of
                && mechanism.sliders.get(s).is_some_and(|slider| mechanism.is_gone(modes, slider))
            {
                continue;
            }
            let now = mechanism.argument(table, self);
            for side in Side::BOTH.into_iter().filter(|_| !has(Fault::RowPassed)) {
                // The end of a slip is not that of a table.
                let is_end = |row: &f64| !matches!(table.of, TableOf::Slip(_)) || *row > 0.0;
                let Some(row) = table.end(*span, side).filter(is_end).map(R::from_f64) else { continue };
                let value = side.sign::<R>() * (row - now);
                let scale = larger(larger(row.magnitude(), now.magnitude()), length);
                solved.switches.push(Switch { of, cause: Cause::Passes(side), value, scale });
            }
        }
    }

    fn is_available(&self, mechanism: &Mechanism<R>, joint: usize, k: usize) -> bool {
        !mechanism.joints[joint].constrained[k]
    }

    /// How strongly the limits of frictions may depend on friction: the spectral radius of the bounds |μ ∂F_N/∂T| (κ), of any units. Below 1
    /// the friction forces are the only ones.
    pub(crate) fn lipschitz(
        &self,
        mechanism: &Mechanism<R>,
        layout: &Layout,
        (modes, solved): (&Modes<R>, &Solved<R>),
    ) -> Result<R, Trouble> {
        let zero = R::ZERO;
        let (n, m) = (layout.columns.len(), layout.kept.len());
        let acting: Vec<usize> =
            (0..modes.frictions.len()).filter(|s| modes.frictions[*s].along().is_some()).collect();
        if acting.is_empty() {
            return Ok(zero);
        }
        let mut matrix = self.matrix(layout, acting.len());
        for (i, s) in acting.iter().enumerate() {
            let slider = &mechanism.sliders[*s];
            let Some(along) = modes.frictions[*s].along() else { continue };
            let moving = self.slip_velocity(mechanism, modes, *s);
            let direction = direction(slider, &modes.frictions[*s], along, &moving);
            self.push(&mut matrix, layout, n + m + i, (slider, &direction));
        }
        let found = matrix.solve().map_err(|error| at(layout, error))?;
        let mut bounds = Vec::with_capacity(acting.len());
        for s in &acting {
            let joint = mechanism.sliders[*s].joint;
            let Some(limit) = solved.limits.get(*s) else { continue };
            let mut row = Vec::with_capacity(acting.len());
            for response in &found {
                let mut sum = zero;
                let mut change = [zero; 6];
                for (r, index) in layout.kept.iter().enumerate() {
                    if let Owner::Joint(of, k) = self.rows[*index].owner
                        && of == joint
                    {
                        change[k] = change[k] + response[n + r];
                    }
                }
                for (factor, rows) in &limit.reach {
                    let vector: Vec<R> = rows
                        .iter()
                        .map(|row| row.iter().zip(&change).fold(zero, |sum, (x, y)| sum + *x * *y))
                        .collect();
                    sum = sum + *factor * length(&vector);
                }
                row.push(sum.to_f64());
            }
            bounds.push(row);
        }
        Ok(R::from_f64(radius(&bounds)))
    }

    /// ½ Σ v·M v.
    pub(crate) fn kinetic(&self) -> R {
        let mut twice = R::ZERO;
        for ((mass, inertia), rates) in self.masses.iter().zip(&self.inertias).zip(&self.rates) {
            let (v, w) = ([rates[0], rates[1], rates[2]], [rates[3], rates[4], rates[5]]);
            twice = twice + *mass * dot(v, v) + dot(w, apply(inertia, w));
        }
        twice * R::ratio(1, 2)
    }

    /// Whether a node has mass, or inertia, in a degree of freedom.
    pub(crate) fn has_inertia(&self, dof: usize) -> bool {
        let zero = R::ZERO;
        let (node, k) = (dof / DOFS, dof % DOFS);
        match k {
            0..3 => zero.less(self.masses[node].magnitude()),
            3..6 => self.inertias[node].iter().flatten().any(|x| zero.less(x.magnitude())),
            _ => zero.less(self.flows[node].magnitude()),
        }
    }

    /// Whether a load acts in a degree of freedom.
    pub(crate) fn is_loaded(&self, dof: usize) -> bool {
        R::ZERO.less(self.applied[dof].magnitude())
    }
}

/// An upper bound of the spectral radius of a matrix A without negative entries: the largest (A x)_i/x_i of a positive x (Collatz, Wielandt). Along
/// powers of A + 1 it falls to that radius.
fn radius(matrix: &[Vec<f64>]) -> f64 {
    const POWERS: usize = 200;
    let mut x = vec![1.0; matrix.len()];
    let mut least = f64::INFINITY;
    for _ in 0..POWERS {
        let times: Vec<f64> =
            matrix.iter().map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>()).collect();
        least = times.iter().zip(&x).map(|(y, x)| y / x).fold(0.0, f64::max).min(least);
        x.iter_mut().zip(times).for_each(|(x, y)| *x += y);
        let most = x.iter().copied().fold(0.0, f64::max);
        x.iter_mut().for_each(|x| *x = (*x / most).max(f64::MIN_POSITIVE));
    }
    least
}

/// n of a slipping friction: the direction of its R_k v_k; of one component, and where it is at rest, the one it has.
fn direction<R: Number>(slider: &Slider, mode: &Mode<R>, along: &[R; 6], moving: &[R; 6]) -> [R; 6] {
    if slider.components.len() == 1 || mode.is_held_by_others() {
        return *along;
    }
    let size = length(moving);
    // What is left of a velocity by rounding has no direction.
    let least = if mode.in_onset { 0.0 } else { 100.0 * R::ROUNDING };
    if R::from_f64(least).less(size) { moving.map(|x| x / size) } else { *along }
}

fn at(layout: &Layout, NoPivot { column }: NoPivot) -> Trouble {
    let n = layout.columns.len();
    Trouble::Singular(match column {
        k if k < n => NoPivotAt::Freedom(layout.columns[k]),
        k => NoPivotAt::Row(layout.kept[k - n]),
    })
}

#[cfg(test)]
mod tests {
    use super::radius;

    /// Bounds of the radius, which no change of units moves: eigenvalues by hand.
    #[test]
    fn the_radius_has_no_units() {
        // λ² − 0.6 λ + 0.05 = 0.
        let matrix = |unit: f64| [vec![0.2, 0.3 * unit], vec![0.1 / unit, 0.4]];
        for unit in [1.0, 1e3, 1e-6] {
            let found = radius(&matrix(unit));
            assert!((found - 0.5).abs() < 1e-12, "{unit}: {found}");
        }
        // What depends on another alone adds nothing.
        let found = radius(&[vec![0.0, 6.0], vec![0.0, 0.0]]);
        assert!((0.0..0.01).contains(&found), "{found}");
        assert_eq!((radius(&[vec![0.7]]), radius(&[])), (0.7, 0.0));
    }
}
