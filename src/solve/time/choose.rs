//! At an event: which frictions stick and which slip, by trying all that is consistent.

use crate::motion::equations::Solved;
use crate::motion::mode::{Branches, Cause, Does, Mode};
use crate::motion::rows::{Assembled, Layout};
use crate::motion::state::DOFS;
use crate::number::{Number, larger, largest};
use crate::refusal::Refusal;
use crate::time::run::Run;
use crate::time::solution::{Event, What};

/// Margins below this count as ties.
const TIE: f64 = 1e-9;

impl<R: Number> Run<'_, R> {
    /// What frictions do that have no slip rate: all that is consistent is tried, the neighbours of now first. `stopping` has just come to
    /// rest, from the direction that its mode has.
    pub(crate) fn choose(&mut self, open: &[usize], stopping: Option<usize>) -> Result<(), Refusal> {
        /// The most frictions whose combinations are all tried.
        const ALL: usize = 6;
        let zero = R::integer(0);
        if open.is_empty() {
            let modes = self.modes.clone();
            let (found, layout, solved) = self.instant(&modes)?;
            return self.settle(modes, &found, layout, &solved);
        }
        let positions: Vec<[R; 6]> = {
            let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
            self.mechanism.sliders.iter().map(|slider| found.joints[slider.joint].position).collect()
        };
        let before = self.modes.clone();
        let mut all_stuck = before.clone();
        for s in open {
            all_stuck[*s] = Mode::sticks(positions[*s]);
        }
        // Where slip would go: against the friction of stick.
        let stuck = self.instant(&all_stuck).ok().map(|(_, _, stuck)| stuck);
        let directions: Vec<[R; 6]> = open
            .iter()
            .map(|s| {
                let slider = &self.mechanism.sliders[*s];
                let mut along = [zero; 6];
                if let Some(force) = stuck.as_ref().and_then(|stuck| stuck.friction.get(slider.joint)) {
                    for (k, radius) in &slider.components {
                        along[*k] = force[*k] * R::from_f64(*radius).reciprocal_or_zero();
                    }
                }
                let size = crate::motion::slide::length(&along);
                if zero.less(size) {
                    along.map(|x| x / size)
                } else {
                    let mut unit = [zero; 6];
                    if let Some((k, _)) = slider.components.first() {
                        unit[*k] = R::integer(1);
                    }
                    unit
                }
            })
            .collect();
        let count = open.len();
        let combinations: usize = 3_usize.pow(count.min(ALL) as u32);
        let mut consistent: Vec<(Vec<Mode<R>>, f64)> = Vec::new();
        'combinations: for number in 0..combinations {
            let mut modes = all_stuck.clone();
            let mut rest = number;
            for (i, s) in open.iter().enumerate().take(ALL) {
                match rest % 3 {
                    0 => {}
                    1 => modes[*s] = Mode::slips(directions[i]),
                    // Of several components there is one direction, which is sought.
                    _ if self.mechanism.sliders[*s].components.len() > 1 => continue 'combinations,
                    _ => modes[*s] = Mode::slips(directions[i].map(|x| -x)),
                }
                rest /= 3;
            }
            let Ok((mut found, mut layout, mut solved)) = self.instant(&modes) else { continue };
            if self.turn(&mut modes, open, (&mut found, &mut layout, &mut solved)).is_err() {
                continue;
            }
            let margin = self.margin(&found, (&layout, &solved), &modes, open);
            if margin >= 0.0 {
                consistent.push((modes, margin));
            }
        }
        // A tie between stick and slip is one motion, not two.
        let real: Vec<usize> = (0..consistent.len()).filter(|i| consistent[*i].1 > TIE).collect();
        let chosen = match (real.as_slice(), consistent.len()) {
            ([one], _) => *one,
            ([], 0) => {
                let names: Vec<&str> = open.iter().map(|s| self.title(*s)).collect();
                return Err(Refusal::of(
                    &names.join(", "),
                    &format!(
                        "neither stick nor slip is consistent at time {}: a jam",
                        self.state.time.to_f64()
                    ),
                    "reduce the coefficient of friction, or the offset of the load",
                ));
            }
            ([], _) => 0,
            (several, _) => {
                let told: Vec<String> = several.iter().map(|i| self.told(&consistent[*i].0, open)).collect();
                return Err(Refusal::of(
                    "friction",
                    &format!(
                        "{} solutions are consistent at time {}: {}",
                        several.len(),
                        self.state.time.to_f64(),
                        told.join("; ")
                    ),
                    "the motion is not unique from here: reduce the coefficient of friction",
                ));
            }
        };
        let Some((modes, margin)) = consistent.into_iter().nth(chosen) else { return Ok(()) };
        let time = self.state.time;
        for (i, s) in open.iter().enumerate() {
            let was_stuck = before[*s].is_stuck() && stopping != Some(*s);
            let what = match (&modes[*s].does, was_stuck) {
                (Does::Sticks(_), true) => continue,
                (Does::Sticks(_), false) => What::Sticks,
                (Does::Slips(_), true) => What::Slips,
                (Does::Slips(along), false) => {
                    let Does::Slips(old) = &before[*s].does else { continue };
                    let same = along.iter().zip(old).fold(zero, |sum, (x, y)| sum + *x * *y);
                    if zero.less(same) {
                        continue;
                    }
                    What::Reverses
                }
            };
            if self.solution.frames.is_empty() {
                continue;
            }
            let _ = i;
            self.event(*s, what, Some(margin), time);
        }
        let (found, layout, solved) = self.instant(&modes)?;
        self.settle(modes, &found, layout, &solved)
    }

    pub(crate) fn event(&mut self, slider: usize, what: What, margin: Option<f64>, time: R) {
        let of = &self.mechanism.sliders[slider];
        self.solution.events.push(Event {
            time,
            connector: of.joint,
            components: of.components.iter().map(|(k, _)| *k).collect(),
            what,
            margin,
            lipschitz: 0.0,
        });
    }

    pub(crate) fn title(&self, slider: usize) -> &str {
        let joint = self.mechanism.sliders.get(slider).and_then(|of| self.mechanism.joints.get(of.joint));
        joint.map_or("", |joint| joint.title.as_str())
    }

    pub(crate) fn told(&self, modes: &[Mode<R>], open: &[usize]) -> String {
        let each = open.iter().map(|s| match &modes[*s].does {
            Does::Sticks(_) => format!("{} sticks", self.title(*s)),
            Does::Slips(along) => {
                let sum: f64 = along.iter().map(|x| x.to_f64()).sum();
                format!("{} slips {}", self.title(*s), if sum < 0.0 { "backwards" } else { "forwards" })
            }
        });
        each.collect::<Vec<_>>().join(" and ")
    }

    /// Turns frictions of several components that begin to slip to where they go: n along R_k times the acceleration of component k.
    fn turn(
        &mut self,
        modes: &mut [Mode<R>],
        open: &[usize],
        (found, layout, solved): (&mut Assembled<R>, &mut Layout, &mut Solved<R>),
    ) -> Result<(), Refusal> {
        const ITERATIONS: usize = 2000;
        let slipping: Vec<usize> = open
            .iter()
            .copied()
            .filter(|s| !modes[*s].is_stuck() && self.mechanism.sliders[*s].components.len() > 1)
            .collect();
        if slipping.is_empty() {
            return Ok(());
        }
        let enough = R::from_f64(1e2 * R::ROUNDING);
        for _ in 0..ITERATIONS {
            let mut change = R::integer(0);
            for s in &slipping {
                let slider = &self.mechanism.sliders[*s];
                let now = &found.joints[slider.joint];
                let mut along = [R::integer(0); 6];
                for (k, radius) in &slider.components {
                    let acceleration = now.rows[*k].iter().fold(now.bias[*k], |sum, (dof, entry)| {
                        sum + *entry * solved.accelerations[dof / DOFS][dof % DOFS]
                    });
                    along[*k] = R::from_f64(*radius) * acceleration;
                }
                let size = crate::motion::slide::length(&along);
                if !R::integer(0).less(size) {
                    return Ok(());
                }
                let along = along.map(|x| x / size);
                if let Does::Slips(old) = &modes[*s].does {
                    change = larger(change, largest(along.iter().zip(old).map(|(new, old)| *new - *old)));
                }
                modes[*s] = Mode::slips(along);
            }
            (*found, *layout, *solved) = self.instant(modes)?;
            if !enough.less(change) {
                break;
            }
        }
        Ok(())
    }

    /// By how much the open frictions are consistent with a mode: the least of them, relative; negative where one is not.
    pub(crate) fn margin(
        &self,
        found: &Assembled<R>,
        (_, solved): (&Layout, &Solved<R>),
        modes: &[Mode<R>],
        open: &[usize],
    ) -> f64 {
        let mut least = f64::INFINITY;
        for s in open {
            let slider = &self.mechanism.sliders[*s];
            let (Some(limit), Some(tangential)) = (solved.limits.get(*s), solved.tangential.get(*s)) else {
                return -1.0;
            };
            let margin = match &modes[*s].does {
                Does::Sticks(_) => {
                    let size = larger(limit.value, *tangential);
                    match R::integer(0).less(size) {
                        true => ((limit.value - *tangential) / size).to_f64(),
                        // Nothing presses, and nothing pulls.
                        false => 1.0,
                    }
                }
                Does::Slips(along) => {
                    // The acceleration along n, relative to what the frictionless parts of it are.
                    let now = &found.joints[slider.joint];
                    let mut sum = R::integer(0);
                    let mut size = R::from_f64(f64::MIN_POSITIVE);
                    for (k, radius) in &slider.components {
                        let factor = R::from_f64(*radius) * along[*k];
                        let mut acceleration = now.bias[*k];
                        let mut parts = now.bias[*k].magnitude();
                        for (dof, entry) in &now.rows[*k] {
                            let part = *entry * solved.accelerations[dof / DOFS][dof % DOFS];
                            acceleration = acceleration + part;
                            parts = parts + part.magnitude();
                        }
                        sum = sum + factor * acceleration;
                        size = size + (factor * parts).magnitude();
                    }
                    let presses = R::integer(0).less(limit.value);
                    let margin = (sum / size).to_f64();
                    if presses { margin } else { margin.min(0.0) - 1e-300 }
                }
            };
            let margin = if margin.abs() <= TIE { 0.0 } else { margin };
            least = least.min(margin);
        }
        least
    }

    /// Takes a mode, with the branches of its frictions and its certificate.
    pub(crate) fn settle(
        &mut self,
        modes: Vec<Mode<R>>,
        found: &Assembled<R>,
        layout: Layout,
        solved: &Solved<R>,
    ) -> Result<(), Refusal> {
        let kappa = found
            .lipschitz(&self.mechanism, &layout, (&modes, solved))
            .map_err(|trouble| self.say(trouble))?
            .to_f64();
        self.solution.lipschitz = self.solution.lipschitz.max(kappa);
        let time = self.state.time;
        for event in self.solution.events.iter_mut().rev() {
            if time.less(event.time) || event.time.less(time) {
                break;
            }
            event.lipschitz = kappa;
        }
        self.is_new = !modes.is_empty();
        self.modes = modes;
        self.layout = layout;
        self.branch(solved, None);
        self.project()
    }

    /// Fixes the branches of frictions to those of a solution; that of a magnitude which has just passed zero is open.
    pub(crate) fn branch(&mut self, solved: &Solved<R>, _turned: Option<usize>) {
        for (mode, limit) in self.modes.iter_mut().zip(&solved.limits) {
            mode.branches = if mode.is_stuck() { Branches::none() } else { limit.branches.clone() };
        }
    }

    /// An event at this state.
    pub(crate) fn happens(
        &mut self,
        slider: usize,
        cause: Cause,
        part: Option<usize>,
    ) -> Result<(), Refusal> {
        let zero = R::integer(0);
        match cause {
            Cause::Turns => {
                self.is_new = true;
                // On the other side of zero the direction is the opposite one.
                if let Some(mode) = self.modes.get_mut(slider) {
                    let branches = &mut mode.branches;
                    match part {
                        None => branches.normal = branches.normal.map(|sign| -sign),
                        Some(part) => {
                            if let Some(Some(unit)) = branches.magnitudes.get_mut(part) {
                                unit.iter_mut().for_each(|x| *x = -*x);
                            }
                        }
                    }
                }
                Ok(())
            }
            Cause::Caps => {
                if let Some(mode) = self.modes.get_mut(slider) {
                    mode.branches.is_capped = !mode.branches.is_capped;
                }
                Ok(())
            }
            Cause::Breaks => {
                let modes = self.modes.clone();
                let (_, _, solved) = self.instant(&modes)?;
                let of = &self.mechanism.sliders[slider];
                let force = &solved.friction[of.joint];
                let mut along = [zero; 6];
                for (k, radius) in &of.components {
                    along[*k] = force[*k] * R::from_f64(*radius).reciprocal_or_zero();
                }
                let size = crate::motion::slide::length(&along);
                // Others that reach their limit at the same time go with it.
                let mut modes = modes;
                let mut going = vec![(slider, along.map(|x| x / size))];
                for switch in &solved.switches {
                    let is_at_limit = switch.cause == Cause::Breaks
                        && switch.slider != slider
                        && switch.value.to_f64() <= switch.scale.to_f64() * TIE;
                    if is_at_limit {
                        let of = &self.mechanism.sliders[switch.slider];
                        let force = &solved.friction[of.joint];
                        let mut along = [zero; 6];
                        for (k, radius) in &of.components {
                            along[*k] = force[*k] * R::from_f64(*radius).reciprocal_or_zero();
                        }
                        let size = crate::motion::slide::length(&along);
                        going.push((switch.slider, along.map(|x| x / size)));
                    }
                }
                let time = self.state.time;
                for (s, along) in going {
                    modes[s] = Mode::slips(along);
                    self.event(s, What::Slips, None, time);
                }
                let (found, layout, solved) = self.instant(&modes)?;
                self.settle(modes, &found, layout, &solved)?;
                self.record(true)
            }
            Cause::Stops => {
                // At rest exactly, by the equations of stick; then all that stands is decided anew.
                let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
                let joint = self.mechanism.sliders[slider].joint;
                let position = found.joints[joint].position;
                let before = self.modes.clone();
                if let Some(mode) = self.modes.get_mut(slider) {
                    *mode = Mode::sticks(position);
                }
                let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
                // What is driven cannot stick.
                if let Ok(layout) = Layout::new(&self.mechanism, &found, &self.modes) {
                    self.layout = layout;
                    self.project()?;
                }
                let open: Vec<usize> = (0..self.modes.len()).filter(|s| self.modes[*s].is_stuck()).collect();
                if let (Some(mode), Some(old)) = (self.modes.get_mut(slider), before.get(slider)) {
                    *mode = old.clone();
                }
                self.choose(&open, Some(slider))?;
                self.record(true)
            }
        }
    }
}
