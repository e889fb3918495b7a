//! At an event: which frictions stick and which slip, by trying all that is consistent.

use crate::motion::equations::Solved;
use crate::motion::mechanism::{Hold, Slider, Stop, TableOf};
use crate::motion::mode::{Branches, Does, Mode, Modes, Side, TIE, Touch};
use crate::motion::rows::{Assembled, Layout};
use crate::motion::slide::length;
use crate::motion::state::DOFS;
use crate::number::{Number, larger, largest};
use crate::refusal::Refusal;
use crate::time::run::Run;
use crate::time::solution::{Event, What};
use pintle_kinematics::scalar::elementary;

/// The direction in which what is prescribed moves a friction, and whether it grazes; none where nothing prescribed does.
type Driven<R> = Option<([R; 6], bool)>;

impl<R: Number> Run<'_, R> {
    /// What frictions do that have no slip rate, and stops that are closed or at their limit without a rate: all that is consistent is tried.
    /// The `open` frictions may still have the modes in which they came to rest.
    pub(crate) fn choose(&mut self, open: &[usize]) -> Result<(), Refusal> {
        /// The most frictions, and stops, whose combinations are all tried.
        const ALL: usize = 6;
        let zero = R::ZERO;
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let touching = self.touching(&found);
        if open.is_empty() && touching.is_empty() {
            let modes = self.modes.clone();
            let (found, layout, solved) = self.instant(&modes)?;
            return self.settle(modes, &found, layout, &solved);
        }
        let before = self.modes.clone();
        let mut all_held = before.clone();
        for s in open {
            let position = found.joints[self.mechanism.sliders[*s].joint].position;
            all_held.frictions[*s] = Mode::sticks(position);
        }
        // Where slip would go: against the friction of stick; where stick repeats what others hold, as without friction.
        let stuck = self.instant(&all_held).ok();
        let free = match stuck {
            None => self.instant(&before.without_friction()).ok(),
            Some(_) => None,
        };
        let directions: Vec<[R; 6]> = open
            .iter()
            .map(|s| {
                let slider = &self.mechanism.sliders[*s];
                if let Some((found, _, solved)) = &free {
                    let along = self.accelerating(slider, (found, solved));
                    if along.iter().any(|x| zero.less(x.magnitude())) {
                        return along;
                    }
                }
                let force = stuck.as_ref().and_then(|(_, _, stuck)| stuck.friction.get(slider.joint));
                slider.against(force.unwrap_or(&[zero; 6]))
            })
            .collect();
        let driven = match &stuck {
            Some((_, layout, stuck)) if !self.is_still => self.driven(&all_held, (layout, stuck), open)?,
            _ => vec![None; open.len()],
        };
        // What grazes has no acceleration but roundings: it does not turn.
        let grazing = |i: usize| driven[i].is_some_and(|(_, grazes)| grazes);
        let turning: Vec<usize> = (0..open.len()).filter(|i| !grazing(*i)).map(|i| open[i]).collect();
        let slips = 3_usize.pow(open.len().min(ALL) as u32);
        let stops = 2_usize.pow(touching.len().min(ALL) as u32);
        let mut consistent: Vec<(Modes<R>, f64)> = Vec::new();
        let (mut why_not, mut has_directions) = (None, true);
        'combinations: for number in 0..slips * stops {
            let mut modes = all_held.clone();
            let mut rest = number % slips;
            for (i, s) in open.iter().enumerate().take(ALL) {
                match rest % 3 {
                    // What is driven from here slips, and that way.
                    which if driven[i].is_some() => match (which, driven[i]) {
                        (1, Some((along, _))) => modes.frictions[*s] = Mode::slips(along),
                        _ => continue 'combinations,
                    },
                    0 => {}
                    // What has no inertia slips by its tensions alone, whose ratio is another one.
                    _ if self.mechanism.sliders[*s].ring.is_some() => continue 'combinations,
                    1 => modes.frictions[*s] = Mode::slips(directions[i]),
                    // Of several components there is one direction, which is sought.
                    _ if self.mechanism.sliders[*s].components.len() > 1 => continue 'combinations,
                    _ => modes.frictions[*s] = Mode::slips(directions[i].map(|x| -x)),
                }
                rest /= 3;
            }
            let mut rest = number / slips;
            for (stop, side) in touching.iter().take(ALL) {
                modes.stops[*stop] =
                    if rest.is_multiple_of(2) { Touch::Closed(*side) } else { Touch::Leaves(*side) };
                modes.meet(*stop);
                rest /= 2;
            }
            // What stops hold does not slip.
            let is_held = |s: &usize| {
                let slider = &self.mechanism.sliders[*s];
                let held =
                    |k: usize| matches!(self.mechanism.hold(&modes, slider.joint, k), Hold::Stopped(_));
                !modes.frictions[*s].is_stuck() && slider.components.iter().all(|(k, _)| held(*k))
            };
            if open.iter().any(is_held) {
                continue;
            }
            let (mut found, mut layout, mut solved) = match self.instant(&modes) {
                Ok(all) => all,
                Err(why) => {
                    why_not = Some(why);
                    continue;
                }
            };
            match self.turn(&mut modes, &turning, (&mut found, &mut layout, &mut solved)) {
                Ok(true) => {}
                Ok(false) => {
                    has_directions = false;
                    continue;
                }
                Err(_) => continue,
            }
            let undriven: Vec<usize> =
                open.iter().zip(&driven).filter(|(_, along)| along.is_none()).map(|(s, _)| *s).collect();
            let margin = self.margin(&found, (&layout, &solved), &modes, &undriven);
            let margin = margin.min(self.margin_of_stops(&found, (&layout, &solved), &modes, &touching));
            if margin >= 0.0 {
                consistent.push((modes, margin));
            }
        }
        // Where more stand than hold, how they share what they hold is open.
        if stuck.is_none()
            && !consistent.iter().any(|(_, margin)| *margin > TIE)
            && let Some(shared) = self.shared(&all_held, open, &directions)
        {
            consistent = vec![shared];
        }
        // A tie between stick and slip is one motion, not two.
        let real: Vec<usize> = (0..consistent.len()).filter(|i| consistent[*i].1 > TIE).collect();
        let chosen = match (real.as_slice(), consistent.len()) {
            ([one], _) => *one,
            ([], 0) => {
                if let Some(why) = why_not.filter(|_| open.is_empty()) {
                    return Err(why);
                }
                let mut names: Vec<&str> = open.iter().map(|s| self.title(*s)).collect();
                names.extend(
                    touching.iter().map(|(stop, _)| self.joint_title(self.mechanism.stops[*stop].joint)),
                );
                names.dedup();
                let time = self.state.time.to_f64();
                let (what, remedy) = match has_directions {
                    true => (
                        format!("neither stick nor slip is consistent at time {time}: a jam"),
                        "reduce the coefficient of friction, or the offset of the load",
                    ),
                    false => (
                        format!("the direction in which it begins to slip at time {time} is not found"),
                        "begin a moment later, or let what is prescribed begin more steeply",
                    ),
                };
                return Err(Refusal::of(&names.join(", "), &what, remedy));
            }
            // The one that there is: nothing presses what slips.
            ([], 1) => 0,
            ([], _) => {
                let time = self.state.time.to_f64();
                let tied = open.iter().map(|s| (time, self.mechanism.sliders[*s].joint));
                self.solution.ties.extend(tied);
                0
            }
            (several, _) => {
                let told: Vec<String> =
                    several.iter().map(|i| self.told(&consistent[*i].0, open, &touching)).collect();
                return Err(Refusal::of(
                    if open.is_empty() { "stops" } else { "friction" },
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
        let Some((modes, _)) = consistent.into_iter().nth(chosen) else { return Ok(()) };
        let (found, layout, solved) = self.instant(&modes)?;
        if !self.solution.frames.is_empty() {
            // What is decided here is as sure as it is consistent, however sharply its time is met.
            self.crossing = None;
            for (i, s) in open.iter().enumerate() {
                let was_stuck = before.frictions[*s].is_stuck();
                let what = match (&modes.frictions[*s].does, was_stuck) {
                    (Does::Sticks(_) | Does::Stretches(_) | Does::Stands(_), true) => continue,
                    (Does::Sticks(_) | Does::Stretches(_) | Does::Stands(_), false) => What::Sticks,
                    (Does::Slips(_), true) => What::Slips,
                    (Does::Slips(along), false) => {
                        let Does::Slips(old) = &before.frictions[*s].does else { continue };
                        let same = along.iter().zip(old).fold(zero, |sum, (x, y)| sum + *x * *y);
                        if zero.less(same) {
                            continue;
                        }
                        What::Reverses
                    }
                };
                let margin = match driven[i] {
                    // What is prescribed decides.
                    Some(_) => None,
                    None => self.sureness(*s, (&found, &layout, &solved), &modes),
                };
                self.event(*s, what, margin);
            }
            for touching in &touching {
                let (stop, _) = touching;
                let [was, is] = [&before, &modes].map(|modes| matches!(modes.stops[*stop], Touch::Closed(_)));
                if was != is {
                    let what = if is { What::Closes } else { What::Opens };
                    let margin = self.margin_of_stops(&found, (&layout, &solved), &modes, &[*touching]);
                    self.event_of_stop(*stop, what, Some(margin));
                }
            }
        }
        self.settle(modes, &found, layout, &solved)
    }

    /// A mode in which all these frictions stand, though fewer hold what there is. As many stick as are independent; the others have no force, or
    /// their limit against where it would go without friction. The one that is surest of those first found; none where none is consistent.
    pub(crate) fn shared(
        &mut self,
        all_held: &Modes<R>,
        open: &[usize],
        directions: &[[R; 6]],
    ) -> Option<(Modes<R>, f64)> {
        let no_belt = |s: &usize| self.mechanism.sliders[*s].ring.is_none();
        if open.len() < 2 || !self.mechanism.stiffness.is_empty() || !open.iter().all(no_belt) {
            return None;
        }
        let found = self.assembled(all_held).ok()?;
        let mut best: Option<(Modes<R>, f64)> = None;
        for first in 0..open.len() {
            let order: Vec<usize> = (0..open.len()).map(|i| (first + i) % open.len()).collect();
            let mut modes = all_held.clone();
            open.iter().for_each(|s| modes.frictions[*s] = Mode::stands([R::ZERO; 6]));
            let mut others = Vec::new();
            for i in order {
                let s = open[i];
                modes.frictions[s] = Mode::sticks(found.joints[self.mechanism.sliders[s].joint].position);
                let now = self.assembled(&modes).ok()?;
                if Layout::new(&self.mechanism, &now, &modes).is_err() {
                    modes.frictions[s] = Mode::stands([R::ZERO; 6]);
                    others.push(i);
                }
            }
            for limited in 0..=others.len() {
                if let Some(i) = limited.checked_sub(1).and_then(|last| others.get(last)) {
                    modes.frictions[open[*i]] = Mode::stands(directions[*i]);
                }
                let Ok((found, layout, solved)) = self.instant(&modes) else { continue };
                let margin = self.margin(&found, (&layout, &solved), &modes, open);
                if margin >= 0.0 && best.as_ref().is_none_or(|(_, known)| *known < margin) {
                    best = Some((modes.clone(), margin));
                    if margin > TIE {
                        return best;
                    }
                }
            }
        }
        best
    }

    /// Of the frictions named those that what is prescribed moves from now on, though all of them stick. Each has the direction in which it slips
    /// a moment later. It grazes where it sets out without an acceleration.
    fn driven(
        &mut self,
        all_held: &Modes<R>,
        (layout, stuck): (&Layout, &Solved<R>),
        open: &[usize],
    ) -> Result<Vec<Driven<R>>, Refusal> {
        /// A moment, as a part of the time to the next break.
        const MOMENT: f64 = 1e-3;
        /// Below this part of the usual speed nothing moves.
        const STILL: f64 = 1e-10;
        /// What has no more than so many least ways to go before it rests is at rest: how it slows down is known to rounding of its direction.
        const NOTHING: f64 = 32.0;
        /// What sets out with an acceleration has half of its rate in half of the time; what grazes has less than this part.
        const GRAZES: f64 = 0.35;
        let none = vec![None; open.len()];
        let now = self.state.time;
        let Some(([_, end], _)) = self.mechanism.schedule.span(self.step) else { return Ok(none) };
        let is_later = |time: &f64| *time > now.to_f64();
        let next = self.breaks().into_iter().chain([end]).filter(is_later).fold(f64::INFINITY, f64::min);
        if next.is_infinite() {
            return Ok(none);
        }
        let mut later = Vec::new();
        for part in [MOMENT, MOMENT / 2.0] {
            self.state.time = now + (R::from_f64(next) - now) * R::from_f64(part);
            let found = self.assembled(all_held);
            self.state.time = now;
            let found = found.map_err(|trouble| self.say(trouble))?;
            let Ok((change, _)) = found.correction(layout, |row| row.rate) else { return Ok(none) };
            later.push((found, change));
        }
        let usual = self.usual_speed();
        // R_k v_k of a friction at one of these times.
        let rates = |slider: &Slider, (found, change): &(Assembled<R>, Vec<R>)| {
            let joint = &found.joints[slider.joint];
            let mut along = [R::ZERO; 6];
            for (k, radius) in &slider.components {
                let rate = found
                    .lines
                    .of(joint.rows[*k])
                    .iter()
                    .fold(joint.velocity[*k], |sum, (dof, entry)| sum + *entry * change[*dof]);
                along[*k] = R::from_f64(*radius) * rate;
            }
            along
        };
        let moves = |s: &usize| {
            let slider = &self.mechanism.sliders[*s];
            let [along, halfway] = [&later[0], &later[1]].map(|at| rates(slider, at));
            let size = length(&along);
            let lever = slider.components.iter().fold(0.0, |most: f64, (_, radius)| most.max(*radius));
            if size.to_f64() <= STILL * usual * lever.max(f64::MIN_POSITIVE) {
                return None;
            }
            // What comes to rest at the next break, and has nothing left to go, is at rest.
            if size.to_f64() * (next - now.to_f64()) <= NOTHING * self.least_way() {
                return None;
            }
            let mut along = along.map(|x| x / size);
            if !length(&halfway).less(size * R::from_f64(GRAZES)) {
                return Some((along, false));
            }
            // A component that nothing drives is pulled by what held it: it follows what is driven, so that friction balances that. Where it
            // cannot, it accelerates by itself.
            let limit = stuck.limits.get(*s).map_or(R::ZERO, |limit| limit.value);
            let (mut free, mut share) = ([R::ZERO; 6], R::ZERO);
            for (k, radius) in &slider.components {
                let holds = limit * R::from_f64(*radius);
                if along[*k].magnitude().to_f64() < STILL && R::ZERO.less(holds) {
                    free[*k] = stuck.friction[slider.joint][*k] / holds;
                    share = share + free[*k] * free[*k];
                }
            }
            let follows = share.less(R::integer(1));
            if follows {
                let rest = elementary::sqrt(R::integer(1) - share);
                (0..6).for_each(|k| along[k] = along[k] * rest + free[k]);
            }
            Some((along, follows))
        };
        Ok(open.iter().map(moves).collect())
    }

    /// The stops at a limit that need not stay as they are: closed ones, and those that have no rate.
    fn touching(&self, found: &Assembled<R>) -> Vec<(usize, Side)> {
        let speed = 1e-12 * self.speed();
        let all = self.mechanism.stops.iter().zip(&self.modes.stops).enumerate();
        let touching = all.filter_map(|(i, (stop, touch))| {
            let side = touch.side().filter(|_| !self.modes.has_failed(stop.joint, stop.component))?;
            let unit = if stop.component < 3 { self.mechanism.length } else { 1.0 };
            let rate = found.joints[stop.joint].velocity[stop.component].to_f64().abs() / unit;
            (matches!(touch, Touch::Closed(_)) || rate <= speed).then_some((i, side))
        });
        touching.collect()
    }

    /// The rate at which component k of a connector grows faster, and the sum of what that consists of.
    pub(crate) fn second_rate(
        &self,
        found: &Assembled<R>,
        solved: &Solved<R>,
        (joint, k): (usize, usize),
    ) -> [R; 2] {
        let now = &found.joints[joint];
        let mut sum = [now.bias[k], now.bias[k].magnitude()];
        for (dof, entry) in found.lines.of(now.rows[k]) {
            let part = *entry * solved.accelerations[dof / DOFS][dof % DOFS];
            sum = [sum[0] + part, sum[1] + part.magnitude()];
        }
        sum
    }

    /// The direction of R_k times the acceleration of each component of a friction; zero where none accelerates.
    pub(crate) fn accelerating(
        &self,
        slider: &Slider,
        (found, solved): (&Assembled<R>, &Solved<R>),
    ) -> [R; 6] {
        let mut along = [R::ZERO; 6];
        for ((k, _), x) in
            slider.components.iter().zip(found.slip_acceleration(slider, &solved.accelerations))
        {
            along[*k] = x;
        }
        let size = length(&along);
        if R::ZERO.less(size) { along.map(|x| x / size) } else { along }
    }

    /// By how much the stops at limits are consistent: a closed one pushes, an open one goes away.
    fn margin_of_stops(
        &self,
        found: &Assembled<R>,
        (layout, solved): (&Layout, &Solved<R>),
        modes: &Modes<R>,
        touching: &[(usize, Side)],
    ) -> f64 {
        let mut least = f64::INFINITY;
        let tiny = R::from_f64(f64::MIN_POSITIVE);
        let forces = larger(largest(solved.forces.iter().copied()), tiny);
        for (of, side) in touching {
            let Stop { joint, component: k, .. } = self.mechanism.stops[*of];
            let sign = side.sign::<R>();
            let margin = match modes.stops[*of] {
                Touch::Closed(_) => match found.row_force(layout, &solved.forces, joint, k) {
                    Some(force) => (sign * force / forces).to_f64(),
                    None => -1.0,
                },
                // What friction holds at a limit would else go away from it: a push is the stop's.
                _ if self.mechanism.is_stuck(modes, joint, k) => {
                    let pushes = TIE < (sign * solved.friction[joint][k] / forces).to_f64();
                    if pushes { -1.0 } else { 1.0 }
                }
                _ => {
                    let [growth, parts] = self.second_rate(found, solved, (joint, k));
                    (-sign * growth / larger(parts, tiny)).to_f64()
                }
            };
            least = least.min(if margin.abs() <= TIE { 0.0 } else { margin });
        }
        least
    }

    pub(crate) fn event(&mut self, slider: usize, what: What, margin: Option<f64>) {
        let of = &self.mechanism.sliders[slider];
        let components = of.components.iter().map(|(k, _)| *k).collect();
        self.event_of((of.joint, components), what, margin);
    }

    pub(crate) fn event_of_stop(&mut self, stop: usize, what: What, margin: Option<f64>) {
        let of = &self.mechanism.stops[stop];
        self.event_of((of.joint, vec![of.component]), what, margin);
    }

    pub(crate) fn event_of(
        &mut self,
        (connector, components): (usize, Vec<usize>),
        what: What,
        margin: Option<f64>,
    ) {
        let time = self.state.time;
        let margin = margin.or(self.crossing);
        self.solution.events.push(Event { time, connector, components, what, margin, lipschitz: 0.0 });
    }

    pub(crate) fn joint_title(&self, joint: usize) -> &str {
        self.mechanism.joints.get(joint).map_or("", |joint| joint.title.as_str())
    }

    pub(crate) fn title(&self, slider: usize) -> &str {
        self.mechanism.sliders.get(slider).map_or("", |of| self.joint_title(of.joint))
    }

    fn told(&self, modes: &Modes<R>, open: &[usize], touching: &[(usize, Side)]) -> String {
        let each = open.iter().map(|s| match &modes.frictions[*s].does {
            Does::Sticks(_) | Does::Stretches(_) | Does::Stands(_) => format!("{} sticks", self.title(*s)),
            Does::Slips(along) => {
                let sum: f64 = along.iter().map(|x| x.to_f64()).sum();
                format!("{} slips {}", self.title(*s), if sum < 0.0 { "backwards" } else { "forwards" })
            }
        });
        let stops = touching.iter().map(|(stop, _)| {
            let is_closed = matches!(modes.stops[*stop], Touch::Closed(_));
            let does = if is_closed { "stays at" } else { "leaves" };
            format!("{} {does} its stop", self.joint_title(self.mechanism.stops[*stop].joint))
        });
        each.chain(stops).collect::<Vec<_>>().join(" and ")
    }

    /// Turns frictions of several components that begin to slip to where they go: n along R_k times the acceleration of component k. False where
    /// no such directions are found.
    fn turn(
        &mut self,
        modes: &mut Modes<R>,
        open: &[usize],
        (found, layout, solved): (&mut Assembled<R>, &mut Layout, &mut Solved<R>),
    ) -> Result<bool, Refusal> {
        const ITERATIONS: usize = 2000;
        let slipping: Vec<usize> = open
            .iter()
            .copied()
            .filter(|s| !modes.frictions[*s].is_stuck() && self.mechanism.sliders[*s].components.len() > 1)
            .collect();
        if slipping.is_empty() {
            return Ok(true);
        }
        let enough = R::from_f64(1e2 * R::ROUNDING);
        // By which part directions follow accelerations: these may turn back by more than they were turned (Aitken's method).
        let mut part = R::integer(1);
        let mut before: Vec<R> = Vec::new();
        for _ in 0..ITERATIONS {
            let mut apart: Vec<R> = Vec::new();
            let mut directions: Vec<[R; 6]> = Vec::new();
            for s in &slipping {
                let slider = &self.mechanism.sliders[*s];
                let along = self.accelerating(slider, (found, solved));
                if !along.iter().any(|x| R::ZERO.less(x.magnitude())) {
                    return Ok(true);
                }
                let Does::Slips(old) = modes.frictions[*s].does else { return Ok(true) };
                apart.extend(along.iter().zip(old).map(|(new, old)| *new - old));
                directions.push(old);
            }
            if !enough.less(largest(apart.iter().copied())) {
                return Ok(true);
            }
            if !before.is_empty() {
                let [mut across, mut square] = [R::ZERO; 2];
                for (now, then) in apart.iter().zip(&before) {
                    let change = *now - *then;
                    (across, square) = (across + *then * change, square + change * change);
                }
                if R::ZERO.less(square) {
                    part = -(part * across) / square;
                }
                // Neither away from where they go, nor nowhere.
                let [least, most] = [1e-6, 1.0].map(R::from_f64);
                if !least.less(part) || most.less(part) {
                    part = R::from_f64(0.5);
                }
            }
            for ((s, old), apart) in slipping.iter().zip(directions).zip(apart.chunks(6)) {
                let mut along: [R; 6] = std::array::from_fn(|k| old[k] + part * apart[k]);
                let size = length(&along);
                if R::ZERO.less(size) {
                    along = along.map(|x| x / size);
                }
                modes.frictions[*s] = Mode::slips(along);
            }
            before = apart;
            (*found, *layout, *solved) = self.instant(modes)?;
        }
        Ok(false)
    }

    /// By how much the open frictions are consistent with a mode: the least of them, relative; negative where one is not.
    pub(crate) fn margin(
        &self,
        found: &Assembled<R>,
        (_, solved): (&Layout, &Solved<R>),
        modes: &Modes<R>,
        open: &[usize],
    ) -> f64 {
        let mut least = f64::INFINITY;
        for s in open {
            let slider = &self.mechanism.sliders[*s];
            let (Some(limit), Some(tangential)) = (solved.limits.get(*s), solved.tangential.get(*s)) else {
                return -1.0;
            };
            let margin = match &modes.frictions[*s].does {
                Does::Sticks(_) | Does::Stands(_)
                    if slider.components.iter().any(|(k, _)| {
                        // What others move does not stick; what is prescribed and moves is known.
                        if self.mechanism.is_given(slider.joint, *k, self.step) {
                            return false;
                        }
                        let [acceleration, parts] = self.second_rate(found, solved, (slider.joint, *k));
                        let noise = larger(parts * R::from_f64(TIE), self.noise(found, solved));
                        noise.less(acceleration.magnitude())
                    }) =>
                {
                    -1.0
                }
                Does::Stands(_) => 1.0,
                Does::Sticks(_) | Does::Stretches(_) => {
                    let size = larger(limit.value, *tangential);
                    match R::ZERO.less(size) {
                        true => ((limit.value - *tangential) / size).to_f64(),
                        // Nothing presses, and nothing pulls.
                        false => 1.0,
                    }
                }
                Does::Slips(along) => {
                    // The acceleration along n, relative to what the frictionless parts of it are.
                    let mut sum = R::ZERO;
                    let mut size = R::from_f64(f64::MIN_POSITIVE);
                    for (k, radius) in &slider.components {
                        let factor = R::from_f64(*radius) * along[*k];
                        let [acceleration, parts] = self.second_rate(found, solved, (slider.joint, *k));
                        sum = sum + factor * acceleration;
                        size = size + (factor * parts).magnitude();
                    }
                    let presses = R::ZERO.less(limit.value);
                    let margin = (sum / size).to_f64();
                    if presses { margin } else { margin.min(0.0) - 1e-300 }
                }
            };
            let margin = if margin.abs() <= TIE { 0.0 } else { margin };
            least = least.min(margin);
        }
        least
    }

    /// What rounding leaves of an acceleration where forces balance: of the largest force over the least mass.
    fn noise(&self, found: &Assembled<R>, solved: &Solved<R>) -> R {
        let masses = found.masses.iter().copied().filter(|mass| R::ZERO.less(*mass));
        let least = masses.reduce(|one, two| if two.less(one) { two } else { one });
        let forces = largest(solved.forces.iter().copied());
        least.map_or(R::ZERO, |mass| forces / mass * R::from_f64(64.0 * R::ROUNDING))
    }

    /// How sure a friction sticks or slips in a mode: by which part of the larger its limit and its load differ, where it alone would stick.
    /// None where other equations do not let it.
    fn sureness(
        &mut self,
        s: usize,
        (found, layout, solved): (&Assembled<R>, &Layout, &Solved<R>),
        modes: &Modes<R>,
    ) -> Option<f64> {
        if modes.frictions[s].is_held_by_others() {
            return None;
        }
        if modes.frictions[s].is_stuck() {
            return Some(self.margin(found, (layout, solved), modes, &[s]));
        }
        let mut held = modes.clone();
        held.frictions[s] = Mode::sticks(found.joints[self.mechanism.sliders[s].joint].position);
        let (_, _, stuck) = self.instant(&held).ok()?;
        let (limit, load) = (stuck.limits.get(s)?.value, *stuck.tangential.get(s)?);
        let size = larger(limit, load);
        let part = R::ZERO.less(size).then(|| ((load - limit) / size).to_f64().abs())?;
        Some(if part <= TIE { 0.0 } else { part })
    }

    /// Takes a mode, with the branches of its frictions and its certificate.
    pub(crate) fn settle(
        &mut self,
        modes: Modes<R>,
        found: &Assembled<R>,
        layout: Layout,
        solved: &Solved<R>,
    ) -> Result<(), Refusal> {
        let kappa = found
            .lipschitz(&self.mechanism, &layout, (&modes, solved))
            .map_err(|trouble| self.say(trouble))?
            .to_f64();
        self.solution.lipschitz = self.solution.lipschitz.max(kappa);
        self.refuse_others(found, &layout, (&modes, solved))?;
        let time = self.state.time;
        for event in self.solution.events.iter_mut().rev() {
            if time.less(event.time) || event.time.less(time) {
                break;
            }
            event.lipschitz = kappa;
        }
        self.is_new = !(modes.frictions.is_empty() && modes.stops.is_empty());
        self.modes = modes;
        self.span_ahead(found, solved);
        self.layout = layout;
        self.branch(solved);
        self.project()
    }

    /// What sets out may be at the row of a table of rates. The table goes on to the side that it sets out to: that in which a friction
    /// slips, else that of the acceleration.
    fn span_ahead(&mut self, found: &Assembled<R>, solved: &Solved<R>) {
        let least = R::from_f64(1e-12 * self.speed());
        for (of, table) in self.mechanism.tables.iter().enumerate().filter(|(_, table)| table.is_rate) {
            let TableOf::Joint(joint, k) = table.of else { continue };
            let now = self.mechanism.argument(table, found);
            let is_here = |row: &f64| !least.less((R::from_f64(*row) - now).magnitude());
            let Some(row) = table.rows.iter().position(is_here) else { continue };
            let mut frictions = self.mechanism.sliders.iter().zip(&self.modes.frictions);
            let slipping = frictions.find_map(|(slider, mode)| match &mode.does {
                Does::Slips(along)
                    if slider.joint == joint && slider.components.iter().any(|of| of.0 == k) =>
                {
                    Some(along[k])
                }
                _ => None,
            });
            let is_at_rest = !least.less(now.magnitude());
            let ahead = slipping
                .filter(|_| is_at_rest)
                .unwrap_or_else(|| self.second_rate(found, solved, (joint, k))[0]);
            if let Some(span) = self.modes.spans.get_mut(of) {
                match ahead.less(R::ZERO) {
                    true => *span = row,
                    false if R::ZERO.less(ahead) => *span = row + 1,
                    false => {}
                }
            }
        }
    }

    /// Refuses a slip that other friction forces fit as well, where κ does not exclude that.
    pub(crate) fn refuse_others(
        &self,
        found: &Assembled<R>,
        layout: &Layout,
        (modes, solved): (&Modes<R>, &Solved<R>),
    ) -> Result<(), Refusal> {
        if self.solution.lipschitz < 1.0 {
            return Ok(());
        }
        let slipping: Vec<usize> =
            (0..modes.frictions.len()).filter(|s| !modes.frictions[*s].is_stuck()).collect();
        // What is at rest must begin to slip the way it does.
        let speed = 1e-12 * self.speed();
        let resting: Vec<usize> =
            slipping.iter().copied().filter(|s| solved.slip_rates[*s].to_f64() <= speed).collect();
        // Where it goes from rest follows from its own forces.
        if resting.iter().any(|s| self.mechanism.sliders[*s].components.len() > 1) {
            return Ok(());
        }
        let others = found.others(&self.mechanism, layout, (modes, solved));
        let fits = |other: &&Solved<R>| self.margin(found, (layout, other), modes, &resting) > 0.0;
        let all: Vec<&Solved<R>> = std::iter::once(solved).chain(others.iter().filter(fits)).collect();
        if all.len() < 2 {
            return Ok(());
        }
        // Seven digits.
        let rounded = |x: f64| format!("{x:.6e}").parse().unwrap_or(x);
        let told = |of: &&Solved<R>| {
            let each = slipping.iter().map(|s| {
                let limit = of.limits.get(*s).map_or(0.0, |limit| limit.value.to_f64());
                format!("{} slips with {}", self.title(*s), rounded(limit))
            });
            each.collect::<Vec<_>>().join(" and ")
        };
        Err(Refusal::of(
            "friction",
            &format!(
                "{} friction forces fit at time {}: {}",
                all.len(),
                self.state.time.to_f64(),
                all.iter().map(told).collect::<Vec<_>>().join("; ")
            ),
            "the motion is not unique from here: reduce the coefficient of friction",
        ))
    }

    /// Fixes the branches of frictions to those of a solution.
    fn branch(&mut self, solved: &Solved<R>) {
        for (mode, limit) in self.modes.frictions.iter_mut().zip(&solved.limits) {
            mode.branches = if mode.along().is_none() { Branches::none() } else { limit.branches.clone() };
        }
    }
}
