//! What happens at an event: friction breaks or rests, a stop closes or opens, a lock holds, a failure releases.
//!
//! *Impacts* are plastic: what runs into a stop, or is locked in motion, loses its velocity there by an impulse, M Δv + Gᵀ P = 0, and the energy
//! ½ P v. Stops only push, P ≥ 0 and v ≥ 0 away from them, one of the two zero. Friction of finite forces has no impulse. Where the impulse
//! presses a friction that moves, the rule does not decide what friction takes, and the impact is refused.

use crate::fault::{Fault, has};
use crate::motion::equations::Solved;
use crate::motion::mechanism::{Hold, Stop, TableOf, Threshold};
use crate::motion::mode::{Cause, Does, Mode, Side, TIE, Touch};
use crate::motion::rows::{Assembled, Layout, Owner, Row};
use crate::motion::slide::length;
use crate::motion::state::{DOFS, WORKS};
use crate::number::{Number, larger, largest};
use crate::refusal::Refusal;
use crate::time::run::Run;
use crate::time::solution::What;
use pintle_model::behavior::friction::{ContactParts, Context};
use pintle_model::behavior::{Conditions, Motion};

/// What rises by less than a quarter of this part of the slack of a stop bounces no more.
const BOUNCE: f64 = 1e-3;

impl<R: Number> Run<'_, R> {
    /// An event at this state.
    pub(crate) fn happens(&mut self, of: usize, cause: Cause) -> Result<(), Refusal> {
        self.hold_zeros(false);
        match cause {
            Cause::Turns(part) => {
                self.is_new = true;
                // On the other side of zero the direction is the opposite one.
                if let Some(mode) = self.modes.frictions.get_mut(of) {
                    let branches = &mut mode.branches;
                    branches.turned.push(part);
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
                if let Some(mode) = self.modes.frictions.get_mut(of) {
                    let is_capped = &mut mode.branches.is_capped;
                    *is_capped = is_capped.map(|is_capped| !is_capped);
                }
                Ok(())
            }
            Cause::Passes(side) => {
                self.is_new = true;
                if let Some(span) = self.modes.spans.get_mut(of) {
                    *span = if side == Side::Lower { span.saturating_sub(1) } else { *span + 1 };
                }
                Ok(())
            }
            Cause::Breaks => self.breaks_loose(of),
            Cause::Stops => self.rests(of),
            Cause::Closes(side) => self.closes(of, side),
            Cause::Opens => self.opens(of),
            Cause::Meets(_) => self.meets(of),
        }
    }

    /// Stick ends: others that reach their limit at the same time go with it.
    fn breaks_loose(&mut self, slider: usize) -> Result<(), Refusal> {
        let mut modes = self.modes.clone();
        let (found, layout, solved) = self.instant(&modes)?;
        let also = solved.switches.iter().filter(|switch| {
            switch.cause == Cause::Breaks
                && switch.of != slider
                && switch.value.to_f64() <= switch.scale.to_f64() * TIE
        });
        let going: Vec<usize> = std::iter::once(slider).chain(also.map(|switch| switch.of)).collect();
        let others = self.goes_along(&going, (&found, &layout, &solved))?;
        if !others.is_empty() && self.takes_over(&going)? {
            return Ok(());
        }
        let going = going.into_iter().map(|s| (s, None)).chain(others.into_iter().map(|(s, n)| (s, Some(n))));
        for (s, known) in going {
            let of = &self.mechanism.sliders[s];
            let mut along = known.unwrap_or_else(|| of.against(&solved.friction[of.joint]));
            if has(Fault::SlipReversed) {
                along = along.map(|x| -x);
            }
            if has(Fault::OnsetByDefault) {
                along = of.against(&[R::ZERO; 6]);
            }
            let joint = of.joint;
            let ahead = self.mechanism.stops.iter().zip(&modes.stops).position(|(stop, touch)| {
                let side = touch.side();
                let pushes = |side: Side| R::ZERO.less(side.sign::<R>() * along[stop.component]);
                stop.joint == joint && matches!(touch, Touch::Leaves(_)) && side.is_some_and(pushes)
            });
            match ahead.and_then(|stop| Some((stop, modes.stops[stop].side()?))) {
                // Slip would go into a stop, which takes over.
                Some((stop, side)) => {
                    modes.stops[stop] = Touch::Closed(side);
                    self.event_of_stop(stop, What::Closes, None);
                }
                None => {
                    if let (Some(stiffness), Some(limit)) =
                        (self.mechanism.stiffness.get(s), solved.limits.get(s))
                    {
                        self.stretched[s] = limit.value * limit.value / *stiffness * R::ratio(1, 2);
                    }
                    modes.frictions[s] = Mode::slips(along);
                    self.forget_onset(s);
                    self.event(s, What::Slips, None);
                }
            }
        }
        let (found, layout, solved) = self.instant(&modes)?;
        self.settle(modes, &found, layout, &solved)?;
        self.record(true)
    }

    /// The frictions that others hold and that go along where some begin to slip, with the directions in which they do.
    fn goes_along(
        &self,
        going: &[usize],
        (found, layout, solved): (&Assembled<R>, &Layout, &Solved<R>),
    ) -> Result<Vec<(usize, [R; 6])>, Refusal> {
        let held = |s: &usize| self.modes.frictions[*s].is_held_by_others();
        let held: Vec<usize> = (0..self.modes.frictions.len()).filter(held).collect();
        if held.is_empty() {
            return Ok(Vec::new());
        }
        let rate = |row: &Row<R>| match row.owner {
            Owner::Joint(joint, k) if self.mechanism.is_stuck(&self.modes, joint, k) => going
                .iter()
                .map(|s| &self.mechanism.sliders[*s])
                .find(|of| of.joint == joint)
                .map(|of| -of.against(&solved.friction[joint])[k]),
            _ => None,
        };
        let (change, _) = found.correction(layout, rate).map_err(|trouble| self.say(trouble))?;
        let moves = |s: usize| {
            let slider = &self.mechanism.sliders[s];
            let rows = &found.joints[slider.joint].rows;
            let rates: [R; 6] = std::array::from_fn(|k| {
                let entries = found.lines.of(rows[k]).iter();
                entries.fold(R::ZERO, |sum, (dof, entry)| sum + *entry * change[*dof])
            });
            let along = slider.rates(&rates);
            let size = length(&along);
            (TIE * TIE < size.to_f64()).then(|| (s, along.map(|x| x / size)))
        };
        Ok(held.into_iter().filter_map(moves).collect())
    }

    /// Whether others that stand can take over what those hold that have come to their limits: then nothing slips.
    fn takes_over(&mut self, going: &[usize]) -> Result<bool, Refusal> {
        let held = (0..self.modes.frictions.len()).filter(|s| self.modes.frictions[*s].is_held_by_others());
        let open: Vec<usize> = going.iter().copied().chain(held).collect();
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let mut all_held = self.modes.clone();
        for s in &open {
            let position = found.joints[self.mechanism.sliders[*s].joint].position;
            all_held.frictions[*s] = Mode::sticks(position);
        }
        let (found, _, solved) = self.instant(&all_held.without_friction())?;
        let directions: Vec<[R; 6]> =
            open.iter().map(|s| self.accelerating(&self.mechanism.sliders[*s], (&found, &solved))).collect();
        match self.shared(&all_held, &open, &directions) {
            Some((modes, margin)) if margin > TIE => {
                let (found, layout, solved) = self.instant(&modes)?;
                self.settle(modes, &found, layout, &solved)?;
                Ok(true)
            }
            _ => Ok(false),
        }
    }

    /// Slip ends: at rest exactly, by the equations of stick; then all that stands is decided anew.
    fn rests(&mut self, slider: usize) -> Result<(), Refusal> {
        if let Some(stiffness) = self.mechanism.stiffness.get(slider).copied() {
            return self.rests_on_spring(slider, stiffness);
        }
        let before = self.modes.clone();
        let (found, _, solved) = self.instant(&before)?;
        let ending = self.ending(&solved.switches, &solved)?;
        self.stands(slider, &found);
        // What is driven cannot stick.
        let now = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        if let Ok(layout) = Layout::new(&self.mechanism, &now, &self.modes) {
            self.layout = layout;
            self.project()?;
        }
        // Others that end at the same time, as in a closed chain, are decided with it.
        let now = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let speed = 1e-12 * self.speed();
        let is_brought_to_rest = |s: &usize| {
            let of = &self.mechanism.sliders[*s];
            let rate = length(&of.rates(&now.joints[of.joint].velocity)).to_f64();
            !self.modes.frictions[*s].is_stuck()
                && (ending.contains(s) || rate <= speed && self.slows(*s, &found, &solved))
        };
        let others: Vec<usize> = (0..self.modes.frictions.len()).filter(is_brought_to_rest).collect();
        others.into_iter().for_each(|s| self.stands(s, &found));
        if has(Fault::SticksAlways) {
            self.event(slider, What::Sticks, None);
            return self.record(true);
        }
        let open = self.standing();
        self.modes = before;
        if has(Fault::ReversesAlways)
            && let Does::Slips(along) = self.modes.frictions[slider].does
        {
            self.modes.frictions[slider] = Mode::slips(along.map(|x| -x));
            self.event(slider, What::Reverses, None);
            return self.record(true);
        }
        self.choose(&open)?;
        self.record(true)
    }

    fn stands(&mut self, slider: usize, found: &Assembled<R>) {
        self.forget_onset(slider);
        let position = found.joints[self.mechanism.sliders[slider].joint].position;
        if let Some(mode) = self.modes.frictions.get_mut(slider) {
            *mode = Mode::sticks(position);
        }
    }

    /// What slips from here begins from rest, whatever way it slipped before.
    fn forget_onset(&mut self, slider: usize) {
        for (_, places) in self.mechanism.turning().filter(|(s, _)| *s == slider) {
            self.state.sums[WORKS + places.start..WORKS + places.end].fill(R::ZERO);
        }
    }

    /// Slip ends in elastic stick: the spring goes on with the force that friction has.
    fn rests_on_spring(&mut self, slider: usize, stiffness: R) -> Result<(), Refusal> {
        let mut modes = self.modes.clone();
        let (found, _, solved) = self.instant(&modes)?;
        let of = &self.mechanism.sliders[slider];
        let mut slack = found.joints[of.joint].position;
        for (k, radius) in &of.components {
            let radius = R::from_f64(*radius);
            slack[*k] = slack[*k] - solved.friction[of.joint][*k] / (stiffness * radius * radius);
        }
        let limit = solved.limits[slider].value;
        let more = limit * limit / stiffness * R::ratio(1, 2) - self.stretched[slider];
        self.state.sums[1] = self.state.sums[1] - more;
        self.state.sums[2] = self.state.sums[2] + more;
        modes.frictions[slider] = Mode::stretches(slack);
        self.event(slider, What::Sticks, None);
        let (found, layout, solved) = self.instant(&modes)?;
        self.settle(modes, &found, layout, &solved)?;
        self.record(true)
    }

    /// A component runs into a stop, and others with it that reach theirs at the same time.
    fn closes(&mut self, stop: usize, side: Side) -> Result<(), Refusal> {
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let mut closing = vec![(stop, side)];
        for (of, (other, touch)) in self.mechanism.stops.iter().zip(&self.modes.stops).enumerate() {
            let k = other.component;
            let now = &found.joints[other.joint];
            let meets = |side: &Side| {
                let rate = side.sign::<R>() * now.velocity[k];
                let gap = other.gap(*side, now.position[k]);
                gap.is_some_and(|gap| gap.less(self.slack(k))) && R::ZERO.less(rate)
            };
            if of != stop && *touch == Touch::Open {
                closing.extend(Side::BOTH.iter().find(|side| meets(side)).map(|side| (of, *side)));
            }
        }
        let mut slow = R::ZERO;
        for (of, side) in closing {
            let Stop { joint, component: k, .. } = self.mechanism.stops[of];
            let rate = side.sign::<R>() * found.joints[joint].velocity[k];
            if let Some([since, _]) = self.modes.left(of)
                && (rate * (self.state.time - since)).less(self.slack(k) * R::from_f64(BOUNCE))
            {
                slow = larger(slow, rate);
            }
            self.modes.meet(of);
            if self.mechanism.is_given(joint, k, self.step) {
                return Err(Refusal::of(
                    self.joint_title(joint),
                    &format!(
                        "what is prescribed for component {} runs into its stop at time {}",
                        k + 1,
                        self.state.time.to_f64()
                    ),
                    "prescribe less, or take the stop out",
                ));
            }
            self.modes.stops[of] = Touch::Closed(side);
            self.event_of_stop(of, What::Closes, None);
        }
        self.stand_at_limits()?;
        self.collide()?;
        self.end_bouncing(slow)?;
        self.begin_modes()?;
        self.record(true)
    }

    /// Brings what has just closed to its limit, which it has passed as far as the digits of an event's time leave open. One that opens at once
    /// would still be beyond, and close again for ever.
    fn stand_at_limits(&mut self) -> Result<(), Refusal> {
        let free = self.modes.without_friction();
        let found = self.assembled(&free).map_err(|trouble| self.say(trouble))?;
        let Ok(layout) = Layout::new(&self.mechanism, &found, &free) else { return Ok(()) };
        let modes = std::mem::replace(&mut self.modes, free);
        let kept = std::mem::replace(&mut self.layout, layout);
        let placed = self.place(found);
        (self.modes, self.layout) = (modes, kept);
        placed.map(|_| ())
    }

    /// Impacts that accumulate, as of a bar that rocks from one end to the other, end where what rises is rounding: then all stops that are
    /// left that slowly hold.
    fn end_bouncing(&mut self, slow: R) -> Result<(), Refusal> {
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let is_slow = |(of, touch): (usize, &Touch)| {
            let Touch::Leaves(side) = touch else { return None };
            let Stop { joint, component: k, .. } = self.mechanism.stops[of];
            let away = -side.sign::<R>() * found.joints[joint].velocity[k];
            (R::ZERO.less(away) && !slow.less(away)).then_some((of, *side))
        };
        let slow: Vec<(usize, Side)> = self.modes.stops.iter().enumerate().filter_map(is_slow).collect();
        if slow.is_empty() {
            return Ok(());
        }
        let before = found.kinetic();
        let frictions = std::mem::take(&mut self.modes.frictions);
        for (of, side) in slow {
            self.modes.stops[of] = Touch::Closed(side);
            self.event_of_stop(of, What::Closes, None);
        }
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        self.layout = Layout::new(&self.mechanism, &found, &self.modes)?;
        self.project()?;
        let after = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?.kinetic();
        self.state.sums[1] = self.state.sums[1] + (before - after);
        self.modes.frictions = frictions;
        Ok(())
    }

    /// The force of a stop has come to zero: it grows no gap yet, so that nothing jumps.
    fn opens(&mut self, stop: usize) -> Result<(), Refusal> {
        let mut modes = self.modes.clone();
        let Stop { joint, component: k, .. } = self.mechanism.stops[stop];
        if let Some(touch) = modes.stops.get_mut(stop)
            && let Some(side) = touch.side()
        {
            *touch = Touch::Leaves(side);
            modes.meet(stop);
            // A friction that stands at the limit holds on from here.
            let limit = self.mechanism.stops[stop].limit(side);
            for (slider, mode) in self.mechanism.sliders.iter().zip(&mut modes.frictions) {
                if let (Does::Sticks(position), Some(limit)) = (&mut mode.does, limit)
                    && slider.joint == joint
                {
                    position[k] = limit;
                }
            }
        }
        self.event_of_stop(stop, What::Opens, None);
        let (found, layout, solved) = self.instant(&modes)?;
        self.settle(modes, &found, layout, &solved)?;
        self.record(true)
    }

    /// A lock or a failure meets its limit.
    fn meets(&mut self, of: usize) -> Result<(), Refusal> {
        let Threshold { joint, component, affected, is_failure, .. } = self.mechanism.criteria[of];
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let now = &found.joints[joint];
        let what = if is_failure { What::Fails } else { What::Locks };
        if is_failure {
            let motion = Motion { position: now.position, constitutive: now.motion, velocity: now.velocity };
            let mut without = motion;
            (0..6).filter(|k| affected[*k]).for_each(|k| without.constitutive[k] = R::ZERO);
            let elasticity = &self.mechanism.joints[joint].behavior.behavior.elasticity;
            let conditions = Conditions::default();
            let energies = [motion, without].map(|motion| elasticity.energy(&motion, &conditions));
            let [Some(whole), Some(rest)] = energies else {
                return Err(Refusal::of(
                    self.joint_title(joint),
                    "the energy is not known that its springs lose as it fails",
                    "give an elasticity with a potential: symmetric, each force over its own displacement",
                ));
            };
            if !has(Fault::FailureForgotten) {
                self.state.sums[1] = self.state.sums[1] + whole - rest;
            }
            self.state.sums[2] = self.state.sums[2] - whole + rest;
            for k in (0..6).filter(|k| affected[*k]) {
                self.modes.failed[joint][k] = true;
                self.modes.locked[joint][k] = None;
            }
            for (stop, touch) in self.mechanism.stops.iter().zip(&mut self.modes.stops) {
                if stop.joint == joint && affected[stop.component] {
                    *touch = Touch::Open;
                }
            }
            self.let_go(joint, now.position);
        } else {
            for k in (0..6).filter(|k| affected[*k] && !self.modes.failed[joint][*k]) {
                let at = &mut self.modes.locked[joint][k];
                *at = at.or(Some(now.position[k]));
            }
        }
        self.event_of((joint, vec![component]), what, None);
        if !self.is_still {
            // What is released has no impact.
            if !is_failure && !has(Fault::LockSlips) {
                self.collide()?;
            }
            self.begin_modes()?;
        }
        // Before anything is kept the first state is still to come.
        if self.solution.frames.is_empty() { Ok(()) } else { self.record(true) }
    }

    /// The frictions of a connector whose components have failed are gone for good, and what their springs hold with them.
    fn let_go(&mut self, joint: usize, position: [R; 6]) {
        for s in 0..self.modes.frictions.len() {
            let slider = &self.mechanism.sliders[s];
            if slider.joint != joint || !self.mechanism.is_gone(&self.modes, slider) {
                continue;
            }
            if let Some(stiffness) = self.mechanism.stiffness.get(s) {
                let held = match &self.modes.frictions[s].does {
                    Does::Stretches(slack) => slider.components.iter().fold(R::ZERO, |sum, (k, radius)| {
                        let stretch = R::from_f64(*radius) * (position[*k] - slack[*k]);
                        sum + *stiffness * stretch * stretch * R::ratio(1, 2)
                    }),
                    Does::Slips(_) => self.stretched[s],
                    Does::Sticks(_) | Does::Stands(_) => R::ZERO,
                };
                self.state.sums[1] = self.state.sums[1] + held;
                self.state.sums[2] = self.state.sums[2] - held;
                self.stretched[s] = R::ZERO;
            }
            self.forget_onset(s);
            self.modes.frictions[s] = Mode::sticks(position);
        }
    }

    /// How far from a limit counts as at it: rounding.
    pub(crate) fn slack(&self, k: usize) -> R {
        let unit = if k < 3 { self.mechanism.length } else { 1.0 };
        R::from_f64(crate::motion::equations::LEAVING * R::ROUNDING * unit)
    }

    /// The impulses by which rates fit what holds now: locks, and those stops at a limit that push.
    pub(crate) fn collide(&mut self) -> Result<(), Refusal> {
        /// The most stops whose combinations are all tried.
        const ALL: usize = 8;
        let touching: Vec<(usize, Side)> = self
            .modes
            .stops
            .iter()
            .enumerate()
            .filter_map(|(i, touch)| Some((i, touch.side()?)))
            .take(ALL)
            .collect();
        let free = self.modes.without_friction();
        let rates = self.state.rates.clone();
        let moving = self.assembled(&free).map_err(|trouble| self.say(trouble))?;
        let speed = R::from_f64(1e-12 * self.speed());
        let mut why_not = None;
        for combination in 0..1_usize << touching.len() {
            let mut modes = free.clone();
            for (i, (stop, side)) in touching.iter().enumerate() {
                let is_closed = combination >> i & 1 == 0;
                modes.stops[*stop] = if is_closed { Touch::Closed(*side) } else { Touch::Leaves(*side) };
                modes.meet(*stop);
            }
            let found = self.assembled(&modes).map_err(|trouble| self.say(trouble))?;
            let layout = match Layout::new(&self.mechanism, &found, &modes) {
                Ok(layout) => layout,
                Err(why) => {
                    why_not = Some(why);
                    continue;
                }
            };
            let corrected = found.correction(&layout, |row| row.rate);
            let (change, impulses) = match corrected {
                Ok(corrected) => corrected,
                Err(trouble) => {
                    why_not = Some(self.say(trouble));
                    continue;
                }
            };
            for (dof, by) in change.iter().enumerate() {
                self.state.rates[dof / DOFS][dof % DOFS] = rates[dof / DOFS][dof % DOFS] + *by;
            }
            self.bring();
            let after = self.assembled(&modes).map_err(|trouble| self.say(trouble))?;
            let size = largest(impulses.iter().copied());
            let fits = touching.iter().all(|(of, side)| {
                let Stop { joint, component: k, .. } = self.mechanism.stops[*of];
                let sign = side.sign::<R>();
                match modes.stops[*of] {
                    Touch::Closed(_) => found
                        .row_force(&layout, &impulses, joint, k)
                        .is_none_or(|push| !(sign * push).less(-size * R::from_f64(TIE))),
                    _ => !speed.less(sign * after.joints[joint].velocity[k]),
                }
            });
            if !fits {
                self.state.rates.clone_from(&rates);
                continue;
            }
            self.decided([&moving, &after], (&layout, &impulses), &found)?;
            for (impulse, index) in impulses.iter().zip(&layout.kept) {
                let row = &found.rows[*index];
                let half = row.rate.unwrap_or(R::ZERO) * R::ratio(1, 2);
                let ends = match row.owner {
                    Owner::Joint(joint, k) => {
                        matches!(self.mechanism.hold(&modes, joint, k), Hold::Stopped(_) | Hold::Locked(_))
                    }
                    _ => false,
                };
                let sums = &mut self.state.sums;
                if ends {
                    let lost = *impulse * half;
                    sums[1] = if has(Fault::ImpactForgotten) { sums[1] } else { sums[1] + lost };
                } else {
                    sums[0] = sums[0] - *impulse * (row.driven + half);
                }
            }
            self.modes.stops = modes.stops;
            self.modes.left = modes.left;
            return Ok(());
        }
        let named = touching.first().map_or(0, |(stop, _)| self.mechanism.stops[*stop].joint);
        Err(why_not.unwrap_or_else(|| {
            Refusal::of(
                self.joint_title(named),
                &format!("no impulse brings it to rest at its stop at time {}", self.state.time.to_f64()),
                "what is prescribed runs into the stop: prescribe less, or take it out",
            )
        }))
    }

    /// Whether the plastic rule decides an impact: no impulse presses a friction that moves before or after it.
    fn decided(
        &self,
        moving: [&Assembled<R>; 2],
        (layout, impulses): (&Layout, &[R]),
        found: &Assembled<R>,
    ) -> Result<(), Refusal> {
        let zero = R::ZERO;
        let size = largest(impulses.iter().copied()).to_f64();
        // Rates that fit but for rounding have no impact.
        let lacks = layout.kept.iter().filter_map(|index| {
            let row = &found.rows[*index];
            Some((row.rate?.magnitude() / self.size_of(row.owner)).to_f64())
        });
        if lacks.fold(0.0, f64::max) <= 1e-12 * self.speed() {
            return Ok(());
        }
        for slider in self.mechanism.sliders.iter().filter(|of| !self.mechanism.is_gone(&self.modes, of)) {
            let Some(friction) = self.mechanism.friction(slider) else { continue };
            let presses = friction.criterion.pressing_components();
            let pressing: [R; 6] = std::array::from_fn(|k| {
                let impulse = found.row_force(layout, impulses, slider.joint, k);
                impulse.filter(|_| presses[k]).unwrap_or(zero)
            });
            let now = moving[1].joints[slider.joint].position;
            let conditions = Conditions::default();
            let context =
                Context { position: now, motion: now, accumulated_slip: zero, conditions: &conditions };
            let pressed = match friction.criterion.contact_parts(&context) {
                None => length(&pressing),
                Some(parts) => pressed_by(&parts, &pressing),
            };
            let moves = moving.iter().any(|found| {
                let rate = length(&slider.rates(&found.joints[slider.joint].velocity)).to_f64();
                rate > 1e-12 * self.speed()
            });
            if moves && pressed.to_f64().abs() > 1e-9 * size {
                return Err(Refusal::of(
                    self.joint_title(slider.joint),
                    &format!(
                        "an impact at time {} presses its friction while it slides: a plastic stop does not decide what friction takes",
                        self.state.time.to_f64()
                    ),
                    "give the stop a spring (*CONNECTOR ELASTICITY, NONLINEAR), or let it act through the centre of mass",
                ));
            }
        }
        Ok(())
    }

    /// Modes from rates and positions: what moves slips, what stands is decided, tables are between the rows where they are.
    pub(crate) fn begin_modes(&mut self) -> Result<(), Refusal> {
        let free = self.modes.without_friction();
        let found = self.assembled(&free).map_err(|trouble| self.say(trouble))?;
        self.modes.spans = self.spans(&found);
        (0..self.mechanism.sliders.len()).for_each(|s| self.forget_onset(s));
        if !self.mechanism.stiffness.is_empty() {
            // Springs go on through impacts, and so do slips until their plastic part has ended.
            for slider in self.mechanism.sliders.iter().skip(self.modes.frictions.len()) {
                let slack = found.joints[slider.joint].position;
                let is_gone = self.mechanism.is_gone(&free, slider);
                self.modes.frictions.push(if is_gone { Mode::sticks(slack) } else { Mode::stretches(slack) });
            }
            return self.choose(&[]);
        }
        let speed = self.speed();
        let before = std::mem::take(&mut self.modes.frictions);
        let mut open = Vec::new();
        let mut events = Vec::new();
        for (s, slider) in self.mechanism.sliders.iter().enumerate() {
            let now = &found.joints[slider.joint];
            let along = slider.rates(&now.velocity);
            let size = length(&along);
            let is_idle = self.mechanism.is_idle(&free, slider);
            if is_idle || size.to_f64() <= 1e-12 * speed {
                if !is_idle {
                    open.push(s);
                }
                // The mode in which it came to rest is told.
                let known = before.get(s).filter(|_| !is_idle).cloned();
                self.modes.frictions.push(known.unwrap_or_else(|| Mode::sticks(now.position)));
                continue;
            }
            let along = along.map(|x| x / size);
            match before.get(s).map(|mode| &mode.does) {
                Some(Does::Sticks(_) | Does::Stretches(_) | Does::Stands(_)) => events.push((s, What::Slips)),
                Some(Does::Slips(old)) => {
                    let same = along.iter().zip(old).fold(R::ZERO, |sum, (x, y)| sum + *x * *y);
                    if same.less(R::ZERO) {
                        events.push((s, What::Reverses));
                    }
                }
                None => {}
            }
            self.modes.frictions.push(Mode::slips(along));
        }
        for (s, what) in events {
            self.event(s, what, None);
        }
        self.choose(&open)
    }

    /// Between which rows tables are, and at a row those ahead.
    pub(crate) fn spans(&self, found: &Assembled<R>) -> Vec<usize> {
        self.mechanism
            .tables
            .iter()
            .map(|table| {
                let now = self.mechanism.argument(table, found);
                let goes_up = match table.of {
                    TableOf::Joint(joint, k) if !table.is_rate => {
                        !found.joints[joint].velocity[k].less(R::ZERO)
                    }
                    TableOf::Spring(spring) if !table.is_rate => !found.springs[spring][1].less(R::ZERO),
                    _ => true,
                };
                let is_below = |row: f64| {
                    let row = R::from_f64(row);
                    row.less(now) || goes_up && !now.less(row)
                };
                table.rows.iter().take_while(|row| is_below(**row)).count()
            })
            .collect()
    }

    /// Stops as positions have them at the beginning of a step.
    pub(crate) fn touch(&mut self) -> Result<(), Refusal> {
        /// How far states of files are rounded, relative to lengths.
        const PRINTED: f64 = 1e-11;
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let mut stops = Vec::with_capacity(self.mechanism.stops.len());
        for stop in &self.mechanism.stops {
            let k = stop.component;
            let unit = if k < 3 { self.mechanism.length } else { 1.0 };
            let mut touch = Touch::Open;
            for side in Side::BOTH {
                let Some(gap) = stop.gap(side, found.joints[stop.joint].position[k]) else { continue };
                let gap = gap.to_f64();
                if self.modes.has_failed(stop.joint, k) {
                    continue;
                }
                if gap < -PRINTED * unit {
                    return Err(Refusal::of(
                        self.joint_title(stop.joint),
                        &format!("component {} begins beyond its stop, by {:e}", k + 1, -gap),
                        "move the stop or the nodes",
                    ));
                }
                if gap <= PRINTED * unit && !self.mechanism.is_given(stop.joint, k, self.step) {
                    touch = Touch::Closed(side);
                }
            }
            stops.push(touch);
        }
        self.modes.stops = stops;
        let touches = self.modes.stops.iter().any(|touch| touch.side().is_some());
        if touches && !self.is_still { self.collide() } else { Ok(()) }
    }
}

/// F_C of impulses: what of it has a magnitude.
fn pressed_by<R: Number>(parts: &ContactParts<R>, pressing: &[R; 6]) -> R {
    let times = |row: &[R; 6]| row.iter().zip(pressing).fold(R::ZERO, |sum, (x, y)| sum + *x * *y);
    parts.magnitudes.iter().fold(times(&parts.linear), |sum, (factor, rows)| {
        let vector: Vec<R> = rows.iter().map(times).collect();
        sum + *factor * length(&vector)
    })
}
