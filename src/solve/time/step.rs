//! From a state to the next: one step, the event within it, and back to the constraints.

use crate::fault::{Fault, has};
use crate::motion::assemble::are_parallel;
use crate::motion::equations::{PASSED, Solved};
use crate::motion::mechanism::Slider;
use crate::motion::mode::{Cause, Does, Switch, Touch};
use crate::motion::rows::{Assembled, Instant, Layout, Owner, Trouble};
use crate::motion::slide::length;
use crate::motion::state::{DOFS, Pose, State, WORKS};
use crate::motion::tangent::{self, Tangent, Ways};
use crate::motion::zero::Zero;
use crate::number::{Number, larger, largest};
use crate::refusal::Refusal;
use crate::time::integrate::{Ahead, Newton, Slope, Tried, at_zero};
use crate::time::onset::{Onset, decay};
use crate::time::run::Run;
use crate::time::stiff::{self, Pace};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::Vector;
use pintle_scene::{Amplitude, AmplitudeDefinition, Scene};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// So many events may follow one another at one time, and some for each stop.
const MOST_AT_ONCE: usize = 100;

/// The part of the usual length of a step that the first one in a mode has.
const CAREFUL: f64 = 0.02;

/// The part of a step by which the change of a limit is found.
const DIFFERENCE: f64 = 1e-3;

/// What is less than this part of a step is next to the error of its end.
const STALE: f64 = 1e-6;

/// How far two nodes may turn in a step (rad): less than half a turn against each other.
const MOST_TURNED: f64 = 2.5;

/// The part of the way to rest that one step goes.
const APPROACH: f64 = 0.6;

/// Into how many steps the fastest oscillation of an amplitude is parted: where all sticks nothing else limits them, and limits are passed
/// unseen.
pub(crate) const PARTS: f64 = 16.0;

/// The shortest period of the amplitudes of a scene.
pub(crate) fn shortest_period(scene: &Scene) -> f64 {
    let frequency = |amplitude: &Amplitude| {
        let datum = |i: usize| amplitude.data.get(i).copied().flatten().unwrap_or(0.0);
        match amplitude.definition {
            AmplitudeDefinition::Periodic => datum(0) * datum(1).abs(),
            AmplitudeDefinition::Modulated => datum(3).abs() + datum(4).abs(),
            _ => 0.0,
        }
    };
    TAU / scene.amplitudes.values().map(frequency).fold(0.0, f64::max)
}

/// By which part of their length steps are shorter from one trial to the next.
const SLOWER: f64 = 0.1;

/// After how many steps without an event a stiff motion is looked for, and again whenever they are twice as many.
const FIRST: usize = 8;

/// How many steps tell how many are to come.
pub(crate) const WINDOW: usize = 256;

/// Since the last event.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Quiet {
    steps: usize,
    /// Whether motion is stiff: implicit steps.
    is_stiff: bool,
    /// When the first of the last [`WINDOW`] steps began.
    #[serde(default)]
    since: f64,
}

impl Quiet {
    /// How long [`WINDOW`] steps have gone that end now.
    pub(crate) fn window(&mut self, now: f64) -> Option<f64> {
        let is_first = self.steps <= 1;
        let is_whole = self.steps.is_multiple_of(WINDOW);
        let passed = now - self.since;
        if is_first || is_whole {
            self.since = now;
        }
        (is_whole && !is_first).then_some(passed)
    }
}

/// Where nodes are, how fast, and how far each has turned.
type Moved<R> = (Vec<Pose<R>>, Vec<[R; DOFS]>, Vec<Vector<R>>);

impl<R: Number> Run<'_, R> {
    /// Which rotations of a node are unknown.
    pub(crate) fn turns(&self, node: usize) -> [bool; 3] {
        let node = self.mechanism.root(node);
        [3, 4, 5].map(|k| self.layout.place.get(DOFS * node + k).is_some_and(Option::is_some))
    }

    /// The state after the unknowns have moved.
    pub(crate) fn unpacked(&self, base: &State<R>, y: &[R], with_vectors: bool) -> Moved<R> {
        let zero = R::ZERO;
        let n = self.layout.columns.len();
        let mut moved = vec![[zero; DOFS]; base.poses.len()];
        let mut rates = base.rates.clone();
        for (i, dof) in self.layout.columns.iter().enumerate() {
            moved[dof / DOFS][dof % DOFS] = y[i];
            rates[dof / DOFS][dof % DOFS] = y[n + i];
        }
        let (poses, turned) = self.moved_by(&base.poses, &moved, &mut rates, with_vectors);
        (poses, rates, turned)
    }

    /// Poses after such changes of those that no others carry, and how far each has turned. Rates are brought along.
    fn moved_by(
        &self,
        from: &[Pose<R>],
        by: &[[R; DOFS]],
        rates: &mut [[R; DOFS]],
        with_vectors: bool,
    ) -> (Vec<Pose<R>>, Vec<Vector<R>>) {
        let moves = |by: &[R; DOFS]| by.iter().any(|x| !x.is_nothing());
        let poses = from.iter().zip(by).enumerate();
        let poses = poses.map(|(node, (pose, by))| match moves(by) {
            true => pose.moved(by, self.turns(node), with_vectors),
            false => *pose,
        });
        let mut poses: Vec<Pose<R>> = poses.collect();
        self.mechanism.bring(&mut poses, rates);
        let turned = (0..poses.len()).map(|node| {
            let by = by[self.mechanism.root(node)];
            [by[3], by[4], by[5]]
        });
        let turned = turned.collect();
        (poses, turned)
    }

    /// Brings nodes that are carried along.
    pub(crate) fn bring(&mut self) {
        self.mechanism.bring(&mut self.state.poses, &mut self.state.rates);
    }

    /// The rates of positions: velocities, and of turns since the state what these make of angular velocities.
    fn moving(&self, base: &State<R>, y: &[R]) -> Vec<R> {
        let columns = &self.layout.columns;
        let velocities = y.get(columns.len()..).unwrap_or_default();
        let mut moving = Vec::with_capacity(columns.len());
        let mut at = 0;
        while let Some(dof) = columns.get(at) {
            let (node, k) = (dof / DOFS, dof % DOFS);
            if !(3..6).contains(&k) || has(Fault::TurnRateTaken) {
                moving.push(velocities[at]);
                at += 1;
                continue;
            }
            // Those of one node stand together.
            let rates = &base.rates[node];
            let (mut turned, mut spin) = ([R::ZERO; 3], [rates[3], rates[4], rates[5]]);
            let these = at..columns[at..]
                .iter()
                .position(|of| *of >= DOFS * node + 6)
                .map_or(columns.len(), |n| at + n);
            for i in these.clone() {
                (turned[columns[i] % DOFS - 3], spin[columns[i] % DOFS - 3]) = (y[i], velocities[i]);
            }
            let back = pintle_kinematics::so3::inverse_left_jacobian(turned);
            let all = pintle_kinematics::vector::apply(&back, spin);
            moving.extend(columns[these.clone()].iter().map(|of| all[of % DOFS - 3]));
            at = these.end;
        }
        moving
    }

    /// The equations at y.
    pub(crate) fn assembled_at(&self, base: &State<R>, time: R, y: &[R]) -> Result<Assembled<R>, Trouble> {
        let n = self.layout.columns.len();
        let (poses, rates, turned) = self.unpacked(base, y, self.mechanism.needs_vectors());
        let instant = Instant {
            time,
            step: self.step,
            poses: &poses,
            rates: &rates,
            sums: y.get(2 * n..).unwrap_or_default(),
            turned: &turned,
            branches: &base.branches,
        };
        self.mechanism.assemble(&instant, &self.modes, &self.beginnings)
    }

    /// Where y may go, numbers by such sizes.
    pub(crate) fn tangent(
        &self,
        base: &State<R>,
        (time, y, sizes): (R, &[R], &[R]),
    ) -> Result<Tangent, Trouble> {
        let ways = Ways {
            layout: &self.layout,
            moving: &|y| self.moving(base, y),
            assemble: &|y| self.assembled_at(base, time, y),
        };
        Tangent::at(y, sizes, &ways)
    }

    /// ẏ.
    fn bare_flow(&self, base: &State<R>, time: R, y: &[R]) -> Result<(Slope<R>, Solved<R>), Trouble> {
        let found = self.assembled_at(base, time, y)?;
        let solved = found.solve_near(&self.mechanism, &self.layout, (&self.modes, &self.limits))?;
        let mut slope = Slope { rates: Vec::with_capacity(y.len()), switches: solved.switches.clone() };
        slope.rates.extend(self.moving(base, y));
        for dof in &self.layout.columns {
            slope.rates.push(solved.accelerations[dof / DOFS][dof % DOFS]);
        }
        slope.rates.extend(&solved.sums);
        Ok((slope, solved))
    }

    /// The flow, where slip on springs ends with its plastic part: n·v − (μ F_N)˙/K.
    pub(crate) fn flow(&self, base: &State<R>, time: R, y: &[R]) -> Result<(Slope<R>, Solved<R>), Trouble> {
        let (mut slope, solved) = self.bare_flow(base, time, y)?;
        if self.mechanism.stiffness.is_empty() || !slope.switches.iter().any(|of| of.cause == Cause::Stops) {
            return Ok((slope, solved));
        }
        // Central differences along the motion, extrapolated twice.
        let step = R::from_f64(self.h.max(1e-300) * DIFFERENCE * (R::ROUNDING / f64::ROUNDING).powf(0.15));
        let mut slopes = Vec::new();
        for level in 0..3 {
            let h = step / R::integer(1 << level);
            let limits = |by: R| -> Result<Vec<R>, Trouble> {
                let moved: Vec<R> = y.iter().zip(&slope.rates).map(|(y, rate)| *y + by * *rate).collect();
                let (_, solved) = self.bare_flow(base, time + by, &moved)?;
                Ok(solved.limits.iter().map(|limit| limit.value).collect())
            };
            let [above, below] = [limits(h)?, limits(-h)?];
            slopes.push(above.iter().zip(&below).map(|(x, y)| (*x - *y) / (h + h)).collect());
        }
        let changes = at_zero(slopes, 4);
        for switch in slope.switches.iter_mut().filter(|switch| switch.cause == Cause::Stops) {
            if let (Some(change), Some(stiffness)) =
                (changes.get(switch.of), self.mechanism.stiffness.get(switch.of))
            {
                switch.value = switch.value - *change / *stiffness;
            }
        }
        Ok((slope, solved))
    }

    pub(crate) fn packed(&self) -> Vec<R> {
        let zero = R::ZERO;
        let columns = &self.layout.columns;
        let mut y = vec![zero; columns.len()];
        y.extend(columns.iter().map(|dof| self.state.rates[dof / DOFS][dof % DOFS]));
        y.extend(&self.state.sums);
        y
    }

    /// The largest error of each number in a step of length h.
    pub(crate) fn allowed(&self, y: &[R], h: f64) -> Vec<R> {
        let tolerance = 10.0_f64.powi(-(self.options.digits as i32));
        let n = self.layout.columns.len();
        let length = self.mechanism.length;
        let size = |dof: usize| if dof % DOFS < 3 || dof % DOFS == 6 { length } else { 1.0 };
        let energy = larger(self.kinetic.magnitude(), largest(self.state.sums.iter().take(WORKS).copied()));
        let energy = energy.to_f64().max(1e-6 * self.work());
        let speed = self.usual_speed();
        let each = (0..y.len()).map(|i| {
            let scale = if i < n {
                size(self.layout.columns[i])
            } else if i < 2 * n {
                let size = size(self.layout.columns[i - n]);
                (size / h).min(size * speed * 10.0).max(1e-3 * size * speed)
            } else if i < 2 * n + WORKS {
                energy
            } else if i < 2 * n + WORKS + self.mechanism.sliders.len() {
                length
            } else {
                length * speed
            };
            R::from_f64(tolerance * scale)
        });
        let mut all: Vec<R> = each.collect();
        all.push(R::from_f64(tolerance));
        all
    }

    /// A size of works: masses, speeds and lengths by their units.
    pub(crate) fn work(&self) -> f64 {
        let masses = self.mechanism.bodies.iter().map(|body| body.mass.to_f64().abs());
        let heaviest = masses.fold(0.0, f64::max);
        (if heaviest > 0.0 { heaviest } else { 1.0 }) * self.mechanism.length.powi(2)
    }

    /// The largest speed until now, lengths by the size of the model.
    pub(crate) fn speed(&self) -> f64 {
        let length = self.mechanism.length;
        let all = self.state.rates.iter().flat_map(|rates| {
            rates.iter().enumerate().map(move |(k, x)| x.to_f64().abs() / if k < 3 { length } else { 1.0 })
        });
        all.fold(self.fastest.max(1e-12), f64::max)
    }

    /// The same, but no less than what goes a thousandth of a length within a step of the scene: what sets out from rest would be lost in
    /// rounding.
    pub(crate) fn usual_speed(&self) -> f64 {
        const PACE: f64 = 1e-3;
        let span = self.mechanism.schedule.span(self.step);
        span.map_or(0.0, |([from, to], _)| PACE / (to - from)).max(self.speed())
    }

    /// What has no more to slip than this before it rests is at rest: a length.
    pub(crate) fn least_way(&self) -> f64 {
        10.0_f64.powi(-(self.options.digits as i32)) * self.mechanism.length
    }

    /// What is slower is at rest, but for rounding.
    fn rounding_of_speed(&self) -> f64 {
        1e4 * R::ROUNDING * self.usual_speed()
    }

    /// The sizes of numbers y. The direction of a slip of several components changes with rates as small as its own.
    fn sizes_for_differences(&self, base: &State<R>, y: &[R], allowed: &[R]) -> Result<Vec<R>, Trouble> {
        let mut sizes = stiff::sizes(y, allowed);
        if self.mechanism.turning().next().is_some() {
            let (_, solved) = self.flow(base, base.time, y)?;
            let rates = self.mechanism.turning().filter_map(|(s, _)| solved.slip_rates.get(s));
            let slowest = rates.filter(|rate| R::ZERO.less(**rate)).copied().reduce(R::lesser);
            let n = self.layout.columns.len();
            if let Some(slowest) = slowest {
                // No less than a thousand roundings.
                let least = R::from_f64(1e3 * f64::ROUNDING / tangent::DIFFERENCE);
                for (size, y) in sizes.iter_mut().zip(y).skip(n).take(n) {
                    *size = larger(size.lesser(slowest), least * y.magnitude());
                }
            }
        }
        Ok(sizes)
    }

    pub(crate) fn tried(
        &mut self,
        base: &State<R>,
        y: &[R],
        slope: &Slope<R>,
        h: R,
    ) -> Result<Tried<R>, Trouble> {
        let allowed = self.allowed(y, h.to_f64());
        let start = (base.time, y, slope);
        let sizes =
            if self.quiet.is_stiff { self.sizes_for_differences(base, y, &allowed)? } else { Vec::new() };
        let mut evaluations = 0;
        let mut flow = |time: R, y: &[R]| {
            evaluations += 1;
            self.flow(base, time, y).map(|(slope, _)| slope)
        };
        let onsets = self.onsets(y.len() - base.sums.len());
        let newton = match self.quiet.is_stiff {
            _ if !onsets.is_empty() => Newton::Onsets(&onsets),
            true => Newton::All(sizes),
            false => Newton::None,
        };
        let moving = |y: &[R]| self.moving(base, y);
        let positions = self.layout.columns.len();
        let tangent = |time: R, y: &[R], sizes: &[R]| self.tangent(base, (time, y, sizes));
        let ahead = Ahead { positions, moving: &moving, tangent: &tangent, stages: self.stages.as_ref() };
        let mut tried = self.rule.step(&mut flow, start, h, &allowed, (&newton, Some(&ahead)));
        // Near rest the direction of a slip changes at once, and stages do not contract.
        let turns = |slider: &Slider| slider.components.len() > 1;
        if tried.as_ref().is_ok_and(|tried| tried.error.is_infinite())
            && onsets.is_empty()
            && self.mechanism.sliders.iter().any(turns)
        {
            tried = self.rule.extrapolated(&mut flow, start, h, &allowed);
        }
        self.solution.evaluations += evaluations;
        if let Ok(tried) = &mut tried {
            self.stages = tried.stages.take().or(self.stages.take());
        }
        tried
    }

    /// Whether the friction of several components has another direction, by more than 60°, and did not begin at rest.
    fn has_turned(&self, before: &Solved<R>, after: &Solved<R>) -> bool {
        let least = R::from_f64(self.rounding_of_speed());
        self.mechanism.turning().any(|(s, _)| {
            let slider = &self.mechanism.sliders[s];
            let moved = before.slip_rates.get(s).is_some_and(|rate| least.less(*rate));
            // Where what presses passes zero, friction turns without the slip.
            let presses = [before, after]
                .iter()
                .all(|solved| solved.limits.get(s).is_some_and(|limit| R::ZERO.less(limit.value)));
            if !moved || !presses || self.modes.frictions[s].is_stuck() {
                return false;
            }
            let [one, other] = [before, after].map(|solved| {
                let mut traction = [R::ZERO; 6];
                for (k, radius) in &slider.components {
                    traction[*k] =
                        solved.friction[slider.joint][*k] * R::from_f64(*radius).reciprocal_or_zero();
                }
                traction
            });
            let along = one.iter().zip(&other).fold(R::ZERO, |sum, (x, y)| sum + *x * *y);
            along.less(length(&one) * length(&other) * R::ratio(1, 2))
        })
    }

    /// How far the nodes of a connector have turned in a step, together, where it is not about one axis.
    fn most_turned(&self, base: &State<R>, y: &[R]) -> R {
        let n = self.layout.columns.len();
        let mut turned = vec![[R::ZERO; 3]; base.poses.len()];
        let mut spins: Vec<Vector<R>> =
            base.rates.iter().map(|rates| [rates[3], rates[4], rates[5]]).collect();
        for (i, dof) in
            self.layout.columns.iter().enumerate().filter(|(_, dof)| (3..6).contains(&(**dof % DOFS)))
        {
            let (node, k) = (dof / DOFS, dof % DOFS - 3);
            (turned[node][k], spins[node][k]) = (y[i], y[n + i]);
        }
        for node in 0..turned.len() {
            let root = self.mechanism.root(node);
            (turned[node], spins[node]) = (turned[root], spins[root]);
        }
        let both = |all: &[Vector<R>], ends: &[Option<usize>; 2]| {
            ends.map(|end| end.and_then(|n| all.get(n)).copied().unwrap_or([R::ZERO; 3]))
        };
        self.mechanism.joints.iter().fold(R::ZERO, |most, joint| {
            let (turned, spins) = (both(&turned, &joint.ends), both(&spins, &joint.ends));
            let is_one_axis =
                are_parallel(turned) && [0, 1].iter().all(|end| are_parallel([turned[*end], spins[*end]]));
            if is_one_axis { most } else { larger(most, norm(turned[0]) + norm(turned[1])) }
        })
    }

    /// The frictions whose slip begins: of each the places of its R_k v_k in y, of which `from` are others, and the direction it has at rest.
    fn onsets(&self, from: usize) -> Vec<Onset<R>> {
        let slips = from + WORKS;
        let begins = self.mechanism.turning().filter_map(|(s, places)| {
            let Does::Slips(along) = &self.modes.frictions.get(s).filter(|mode| mode.in_onset)?.does else {
                return None;
            };
            let components = self.mechanism.sliders[s].components.iter();
            Some(components.zip(places).map(|((k, _), place)| (slips + place, along[*k])).collect())
        });
        begins.collect()
    }

    /// Slips that have begun go on by the velocities of the state: where these are no rounding, and steps are not stiff any more.
    fn leave_onsets(&mut self) -> Result<(), Refusal> {
        /// What moves faster than this part of the largest speed has been moving.
        const MOVES: f64 = 1e-9;
        /// From this part of the largest speed on the direction of a velocity is exact enough.
        const CLEAR: f64 = 1e-3;
        /// Within a step a direction decays less often than this to where it belongs.
        const DECAYS: f64 = 0.3;
        let all: Vec<(usize, Range<usize>)> = self.mechanism.turning().collect();
        if !all.iter().any(|(s, _)| self.modes.frictions.get(*s).is_some_and(|mode| mode.in_onset)) {
            return Ok(());
        }
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        for (s, places) in all {
            let slider = &self.mechanism.sliders[s];
            let places = WORKS + places.start..WORKS + places.end;
            let moving = slider.rates(&found.joints[slider.joint].velocity);
            let speed = length(&moving).to_f64();
            let is_at_rest = self.state.sums[places.clone()].iter().all(|x| !R::ZERO.less(x.magnitude()));
            let is_clear = speed > CLEAR * self.speed();
            let is_stiff = is_clear && !is_at_rest && {
                let (base, y) = (self.state.clone(), self.packed());
                let from = y.len() - base.sums.len();
                let mut flow = |time: R, y: &[R]| self.flow(&base, time, y).map(|(slope, _)| slope);
                let all: Vec<usize> = places.clone().map(|place| from + place).collect();
                let decay = decay(&mut flow, (base.time, &y), &all).map_err(|trouble| self.say(trouble))?;
                decay * self.h > DECAYS
            };
            let begins = self.modes.frictions[s].in_onset
                && match is_at_rest {
                    true => speed <= MOVES * self.speed(),
                    false => !is_clear || is_stiff,
                };
            self.modes.frictions[s].in_onset = begins;
            let is_moving = is_at_rest && speed > self.rounding_of_speed();
            for ((k, _), place) in self.mechanism.sliders[s].components.iter().zip(places) {
                let sum = &mut self.state.sums[place];
                *sum = match begins {
                    true if is_clear || is_moving => moving[*k],
                    true => *sum,
                    false => R::ZERO,
                };
            }
        }
        Ok(())
    }

    /// Now and then, whether motion has become stiff: whether something decays much faster than steps go.
    fn look_for_decay(&mut self) -> Result<(), Refusal> {
        self.quiet.steps += 1;
        let is_time = self.quiet.steps >= FIRST && self.quiet.steps.is_power_of_two();
        if self.quiet.is_stiff || !is_time {
            return Ok(());
        }
        let (base, y) = (self.state.clone(), self.packed());
        let allowed = self.allowed(&y, self.h);
        let mut flow = |time: R, y: &[R]| self.flow(&base, time, y).map(|(slope, _)| slope);
        let found = flow(base.time, &y).and_then(|slope| {
            let pace = Pace::of(&mut flow, (base.time, &y, &slope), &allowed, self.h)?;
            if pace.is_lively() {
                return Ok(false);
            }
            let sizes = self.sizes_for_differences(&base, &y, &allowed)?;
            let tangent = self.tangent(&base, (base.time, &y, &sizes))?;
            let derivatives = stiff::derivatives(&mut flow, (base.time, &y, &slope), &tangent.directions)?;
            Ok(stiff::is_stiff((&tangent, &derivatives), pace, self.h))
        });
        self.quiet.is_stiff = found.map_err(|trouble| self.say(trouble))?;
        Ok(())
    }

    /// Goes on to a time, over all events before it. Where it `is_break`, what acts may jump there: it is met from below.
    pub(crate) fn reach(&mut self, to: f64, is_break: bool) -> Result<(), Refusal> {
        let end = R::from_f64(to);
        let below = if is_break { 4.0 * R::ROUNDING } else { 0.0 };
        let goal = end - end.magnitude() * R::from_f64(below);
        let least = (to - self.state.time.to_f64()).abs().max(to.abs()) * 1e3 * R::ROUNDING;
        let longest = shortest_period(self.scene) / PARTS;
        let pace = 1.0 - SLOWER * f64::from(self.options.trial);
        let mut halvings = 0;
        let mut at_once = 0;
        while self.state.time.less(goal) {
            self.keep(false);
            self.wake()?;
            self.solution.steps += 1;
            if self.solution.steps > self.options.most_steps {
                return Err(Refusal::of(
                    "the solution",
                    &format!(
                        "{} steps were not enough to pass time {}",
                        self.options.most_steps,
                        self.state.time.to_f64()
                    ),
                    "something rings or is stiff: ask for a shorter time",
                ));
            }
            self.limits.clear();
            self.hold_zeros(false);
            self.leave_onsets()?;
            let base = self.state.clone();
            let y = self.packed();
            let (mut slope, mut solved) =
                self.flow(&base, base.time, &y).map_err(|trouble| self.say(trouble))?;
            if self.keep_branches(&solved) {
                (slope, solved) = self.flow(&base, base.time, &y).map_err(|trouble| self.say(trouble))?;
            }
            // Where there may be other solutions, that is sought which is found from no friction at all.
            if self.solution.lipschitz < 1.0 {
                self.limits = solved.limits.iter().map(|limit| limit.value).collect();
            }
            if self.solution.lipschitz >= 1.0 {
                let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
                self.refuse_others(&found, &self.layout, (&self.modes, &solved))?;
            }
            if self.leaves(&slope.switches)? {
                continue;
            }
            if let Some(switch) = self.overdue(&slope.switches, &solved)? {
                at_once += 1;
                if at_once > MOST_AT_ONCE + 4 * self.mechanism.stops.len() {
                    return Err(self.stuck_in_time());
                }
                self.crosses(&switch)?;
                continue;
            }
            at_once = 0;
            let nearest = self.rests_in(&solved)?;
            if let Some((slider, rest, is_now)) =
                nearest.filter(|(_, rest, now)| *now || rest.to_f64() < least)
            {
                if is_now {
                    self.go_to_rest(slider, rest, goal)?;
                } else {
                    // No step is as short as what is left.
                    self.state.time = (self.state.time + rest).lesser(goal);
                }
                self.happens(slider, Cause::Stops)?;
                continue;
            }
            // What has just become zero may do so again soon.
            if std::mem::take(&mut self.is_new) {
                self.h *= CAREFUL;
            }
            let mut wanted = R::from_f64((self.h.min(longest) * pace).min(self.until_lock()?));
            if let Some((_, rest, false)) = nearest {
                wanted = wanted.lesser(rest * R::from_f64(APPROACH));
            }
            let left = goal - self.state.time;
            let is_last = !wanted.less(left);
            let h = if is_last { left } else { wanted };
            let zeros_stay = !std::mem::take(&mut self.has_grown);
            self.hold_zeros(zeros_stay);
            let tried = self.tried(&base, &y, &slope, h);
            let tried = match tried {
                Ok(tried) if tried.error <= 1.0 => tried,
                Ok(Tried { growth, .. }) => {
                    self.h = h.to_f64() * growth.min(0.8);
                    halvings += 1;
                    if self.h < least || halvings > 200 {
                        return Err(self.stuck_in_time());
                    }
                    continue;
                }
                Err(trouble) => {
                    self.h = h.to_f64() * 0.3;
                    halvings += 1;
                    if self.h < least || halvings > 200 {
                        return Err(self.singular().unwrap_or_else(|| self.say(trouble)));
                    }
                    continue;
                }
            };
            // About axes that turn, turns are counted from step to step.
            let turned = self.most_turned(&base, &tried.end).to_f64();
            if turned > MOST_TURNED {
                self.h = h.to_f64() * 0.9 * MOST_TURNED / turned;
                continue;
            }
            let (ended, after) = self.switches_at(&base, base.time + h, &tried.end)?;
            if zeros_stay && self.zeros_grow(&base, (base.time + h, &tried.end), &after)? {
                self.has_grown = true;
                continue;
            }
            // A slip that has passed rest has turned, and its stages need not show it.
            if self.has_turned(&solved, &after) && self.h > least {
                self.h = h.to_f64() * 0.5;
                continue;
            }
            halvings = 0;
            let crossing = crossing(&slope.switches, &tried.inner, &ended);
            match crossing {
                None => {
                    let grown = h.to_f64() * tried.growth;
                    self.h = if is_last { grown.max(self.h) } else { grown };
                    let time = if is_last { goal } else { base.time + h };
                    self.commit(&base, time, &tried.end)?;
                    self.look_for_decay()?;
                    self.crawls()?;
                }
                Some(Crossing::Inside(part)) => {
                    // Back before the end of the step: what is negative within it must be so at its end.
                    self.h = h.to_f64() * part;
                    if self.h < least {
                        return Err(self.stuck_in_time());
                    }
                }
                Some(Crossing::AtEnd) if has(Fault::EventInterpolated) => {
                    let pairs = ended.iter().zip(&slope.switches);
                    let crossed =
                        pairs.filter(|(then, now)| then.value.less(R::ZERO) && !now.value.less(R::ZERO));
                    let part = |(then, now): &(&Switch<R>, &Switch<R>)| {
                        (now.value / (now.value - then.value)).to_f64()
                    };
                    let first = crossed.min_by(|one, two| part(one).total_cmp(&part(two)));
                    if let Some((switch, now)) = first {
                        let h = h * R::from_f64(part(&(switch, now)));
                        let tried = self.tried(&base, &y, &slope, h).map_err(|trouble| self.say(trouble))?;
                        self.commit(&base, base.time + h, &tried.end)?;
                        self.happens(switch.of, switch.cause)?;
                    }
                }
                Some(Crossing::AtEnd) => {
                    let usual = self.h;
                    self.locate(h, &slope.switches, &tried.inner, &ended)?;
                    self.h = usual.min(h.to_f64());
                    self.quiet = Quiet::default();
                }
            }
        }
        // What acts may jump there.
        self.hold_zeros(false);
        self.state.time = end;
        self.wake()
    }

    /// What has no inertia becomes unknown where something acts on it that did not before.
    fn wake(&mut self) -> Result<(), Refusal> {
        if self.layout.idle.is_empty() {
            return Ok(());
        }
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        if self.layout.wakes(&self.mechanism, &found) {
            self.layout = Layout::new(&self.mechanism, &found, &self.modes)?;
            let y = self.packed();
            self.flow(&self.state, self.state.time, &y).map_err(|trouble| self.say(trouble))?;
        }
        Ok(())
    }

    /// Whether stops have been left with rates: from there on their gaps are exact.
    fn leaves(&mut self, switches: &[Switch<R>]) -> Result<bool, Refusal> {
        /// Of the usual speed: what goes away more slowly may be pushed back by rounding.
        const CLEAR: f64 = 1e-10;
        let is_new = |(of, touch): &(usize, &Touch)| {
            matches!(touch, Touch::Leaves(_)) && self.modes.left(*of).is_none()
        };
        let new: Vec<(usize, Touch)> =
            self.modes.stops.iter().enumerate().filter(is_new).map(|(of, touch)| (of, *touch)).collect();
        if self.is_still || new.is_empty() {
            return Ok(false);
        }
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let least = CLEAR * self.usual_speed();
        let mut any = false;
        for (of, touch) in new {
            let (Some(side), stop) = (touch.side(), &self.mechanism.stops[of]) else { continue };
            let now = &found.joints[stop.joint];
            let unit = if stop.component < 3 { self.mechanism.length } else { 1.0 };
            let rate = -side.sign::<R>() * now.velocity[stop.component];
            let Some(gap) = stop.gap(side, now.position[stop.component]) else { continue };
            let is_watched =
                switches.iter().any(|switch| switch.of == of && switch.cause == Cause::Closes(side));
            if is_watched && least * unit < rate.to_f64() {
                self.modes.left.resize(self.mechanism.stops.len(), None);
                self.modes.left[of] = Some([self.state.time, larger(-gap, R::ZERO)]);
                any = true;
            }
        }
        Ok(any)
    }

    /// What has passed its end as a step begins: a stop that another has made close, a limit that a force has jumped over, a table left by
    /// rounding. What has gone away from a limit is open.
    fn overdue(&mut self, switches: &[Switch<R>], solved: &Solved<R>) -> Result<Option<Switch<R>>, Refusal> {
        let zero = R::ZERO;
        let ending = self.ending(switches, solved)?;
        let beyond = |switch: &&Switch<R>| {
            let slack = switch.scale * R::from_f64(crate::motion::equations::LEAVING * R::ROUNDING);
            match switch.cause {
                Cause::Meets(_) | Cause::Closes(_) => switch.value.less(zero),
                Cause::Stops if !self.mechanism.stiffness.is_empty() => switch.value.less(-slack),
                Cause::Stops => ending.contains(&switch.of),
                Cause::Passes(_) => switch.value.less(-slack),
                _ => false,
            }
        };
        for switch in switches {
            let slack = switch.scale * R::from_f64(2.0 * crate::motion::equations::LEAVING * R::ROUNDING);
            if let Cause::Closes(side) = switch.cause
                && let Some(touch) = self.modes.stops.get_mut(switch.of)
                && *touch == Touch::Leaves(side)
                && slack.less(switch.value)
            {
                *touch = Touch::Open;
            }
        }
        Ok(switches.iter().find(beyond).copied())
    }

    /// The slips of one component that end now. With another event one may have come to zero, or passed it by rounding.
    pub(crate) fn ending(&self, switches: &[Switch<R>], solved: &Solved<R>) -> Result<Vec<usize>, Refusal> {
        let is_near = |switch: &&Switch<R>| {
            switch.cause == Cause::Stops
                && self.mechanism.sliders[switch.of].components.len() == 1
                && switch.value.less(switch.scale * R::from_f64(PASSED * R::ROUNDING))
        };
        let near: Vec<usize> = switches.iter().filter(is_near).map(|switch| switch.of).collect();
        if near.is_empty() {
            return Ok(near);
        }
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        Ok(near.into_iter().filter(|s| self.slows(*s, &found, solved)).collect())
    }

    /// Whether what slips in one direction goes ever less that way: not by rounding, as where a slip begins.
    pub(crate) fn slows(&self, slider: usize, found: &Assembled<R>, solved: &Solved<R>) -> bool {
        /// Of the acceleration to the usual speed within the step of the scene.
        const LEAST: f64 = 1e-6;
        let of = &self.mechanism.sliders[slider];
        let Does::Slips(along) = &self.modes.frictions[slider].does else { return false };
        let unit = if of.components.iter().all(|(k, _)| *k < 3) { self.mechanism.length } else { 1.0 };
        let span = self.mechanism.schedule.span(self.step).map_or(1.0, |([from, to], _)| to - from);
        let least = LEAST * unit * self.usual_speed() / span;
        let change = of.components.iter().fold(R::ZERO, |sum, (k, _)| {
            sum + along[*k] * self.second_rate(found, solved, (of.joint, *k))[0]
        });
        change.less(R::from_f64(-least))
    }

    pub(crate) fn stuck_in_time(&self) -> Refusal {
        if let Some(why) = self.singular() {
            return why;
        }
        Refusal::of(
            "the solution",
            &format!("steps become too short at time {}", self.state.time.to_f64()),
            "a singular position is near, or something rings",
        )
    }

    /// What is prescribed goes on while what is left to go is rounding: the state goes to where it rests, at the zero of its rate or at a break.
    fn go_to_rest(&mut self, slider: usize, rest: R, goal: R) -> Result<(), Refusal> {
        /// A rate that vanishes as (T − t)ⁿ has n times as long to go as its deceleration tells.
        const SMOOTH: f64 = 4.0;
        let of = &self.mechanism.sliders[slider];
        if !of.components.iter().any(|(k, _)| self.mechanism.is_given(of.joint, *k, self.step)) {
            return Ok(());
        }
        let now = self.state.time;
        let latest = now + rest * R::from_f64(SMOOTH);
        let breaks = self.breaks().into_iter().map(R::from_f64);
        let next = breaks.filter(|time| now.less(*time) && !latest.less(*time)).reduce(R::lesser);
        let to = next.unwrap_or(now + rest).lesser(goal);
        if now.less(to) {
            self.state.time = to;
            self.project()?;
        }
        Ok(())
    }

    /// The friction of several components that comes to rest first, in how long, and whether it rests now. Its direction has no
    /// meaning at rest, so that it is approached: each step goes a part of the way.
    fn rests_in(&self, solved: &Solved<R>) -> Result<Option<(usize, R, bool)>, Refusal> {
        let zero = R::ZERO;
        let mut found: Option<(usize, R, bool)> = None;
        let several = |s: &usize| {
            self.mechanism.sliders[*s].components.len() > 1 && !self.modes.frictions[*s].is_stuck()
        };
        if !(0..self.modes.frictions.len()).any(|s| several(&s)) {
            return Ok(None);
        }
        let known = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let tolerance = 10.0_f64.powi(-(self.options.digits as i32)) * self.speed();
        for s in (0..self.modes.frictions.len()).filter(several) {
            let slider = &self.mechanism.sliders[s];
            let Some(rate) = solved.slip_rates.get(s).copied() else { continue };
            let moving = known.slip_velocity(&self.mechanism, &self.modes, s);
            let accelerations = known.slip_acceleration(slider, &solved.accelerations);
            let pairs = slider.components.iter().zip(accelerations);
            let change = pairs.fold(zero, |sum, ((k, _), x)| sum + moving[*k] * x);
            if !change.less(zero) {
                continue;
            }
            // d|v|/dt = v·a/|v|.
            let rest = rate * rate / -change;
            if rate.to_f64() <= tolerance {
                return Ok(Some((s, rest, true)));
            }
            // What is prescribed goes to rest as slowly as it likes: what it has left to go counts.
            let is_given = |(k, _): &(usize, f64)| self.mechanism.is_given(slider.joint, *k, self.step);
            if slider.components.iter().any(is_given) && (rate * rest).to_f64() <= self.least_way() {
                return Ok(Some((s, rest, true)));
            }
            if found.is_none_or(|(_, other, _)| rest.less(other)) {
                found = Some((s, rest, false));
            }
        }
        Ok(found)
    }

    /// Branches of magnitudes that were zero and are not any more.
    pub(crate) fn keep_branches(&mut self, solved: &Solved<R>) -> bool {
        let mut changed = false;
        let zero = R::ZERO;
        for (s, (mode, limit)) in self.modes.frictions.iter_mut().zip(&solved.limits).enumerate() {
            if mode.along().is_none() {
                continue;
            }
            if mode.branches.magnitudes.len() != limit.branches.magnitudes.len() {
                mode.branches = limit.branches.clone();
                changed = true;
                continue;
            }
            let magnitudes = mode.branches.magnitudes.iter_mut().zip(&limit.branches.magnitudes);
            for (part, (known, now)) in magnitudes.enumerate() {
                // Directions turn with the forces; what counts is which there are.
                changed |= known.is_some() != now.is_some();
                // To the opposite one they turn by an event alone: just after it rounding may have them on the other side.
                let turn = |switch: &&Switch<R>| switch.of == s && switch.cause == Cause::Turns(Some(part));
                let along = solved.switches.iter().find(turn).map(|switch| switch.value);
                let is_beyond = along.is_some_and(|along| along.less(zero));
                if !is_beyond || !mode.branches.turned.contains(&Some(part)) {
                    changed |= is_beyond;
                    // Next to zero, where another has turned at the same time, there is no direction but the opposite one.
                    match (&mut *known, now) {
                        (Some(unit), Some(now))
                            if is_beyond && zero.less(along_of(unit, now)) && !has(Fault::KinksApart) =>
                        {
                            unit.iter_mut().for_each(|x| *x = -*x);
                        }
                        _ => known.clone_from(now),
                    }
                }
            }
            let has_turned = mode.branches.turned.contains(&None);
            let turn = |switch: &&Switch<R>| switch.of == s && switch.cause == Cause::Turns(None);
            let is_beyond = solved.switches.iter().find(turn).is_some_and(|switch| switch.value.less(zero));
            if is_beyond && !has_turned && limit.branches.normal.is_none() {
                mode.branches.normal = mode.branches.normal.map(|sign| -sign);
                changed = true;
            }
            let kept = mode.branches.normal.filter(|_| has_turned);
            let normal = kept.or(limit.branches.normal).or(mode.branches.normal);
            changed |= normal.is_some() != mode.branches.normal.is_some();
            mode.branches.normal = normal;
        }
        changed
    }

    /// From now on magnitudes that are zero count as zero, or are found.
    pub(crate) fn hold_zeros(&mut self, stay: bool) {
        self.modes.frictions.iter_mut().for_each(|mode| mode.branches.zeros_stay = stay);
    }

    /// Whether a magnitude that counted as zero is none at the end of a step, on the constraints.
    fn zeros_grow(
        &mut self,
        base: &State<R>,
        (time, y): (R, &[R]),
        ended: &Solved<R>,
    ) -> Result<bool, Refusal> {
        if !self.is_beyond_zero(ended) {
            return Ok(false);
        }
        let kept = (self.state.clone(), self.layout.clone());
        let arrived = self.arrive(base, time, y).and_then(|_| {
            let (there, y) = (self.state.clone(), self.packed());
            self.flow(&there, time, &y).map_err(|trouble| self.say(trouble))
        });
        (self.state, self.layout) = kept;
        Ok(self.is_beyond_zero(&arrived?.1))
    }

    /// Whether a magnitude that is zero in the modes is none.
    fn is_beyond_zero(&self, solved: &Solved<R>) -> bool {
        self.modes.frictions.iter().zip(&solved.limits).any(|(mode, limit)| {
            let mut all = mode.branches.magnitudes.iter().zip(&limit.branches.magnitudes);
            mode.along().is_some() && all.any(|(known, now)| known.is_none() && now.is_some())
        })
    }

    pub(crate) fn switches_at(
        &mut self,
        base: &State<R>,
        time: R,
        y: &[R],
    ) -> Result<(Vec<Switch<R>>, Solved<R>), Refusal> {
        self.solution.evaluations += 1;
        let (slope, solved) = self.flow(base, time, y).map_err(|trouble| self.say(trouble))?;
        Ok((slope.switches, solved))
    }

    /// Finds the first event within h, by whole steps: the state goes on to it. Switches at both ends are known.
    pub(crate) fn locate(
        &mut self,
        h: R,
        first: &[Switch<R>],
        inner: &[(f64, Vec<Switch<R>>)],
        last_switches: &[Switch<R>],
    ) -> Result<(), Refusal> {
        /// So often in a row values tell where to go.
        const TOLD: usize = 12;
        /// So many digits more than a state has a time of an event.
        const BEYOND: i32 = 4;
        let zero = R::ZERO;
        let mut low = (zero, first.to_vec());
        let mut high = h;
        let known = earliest(first, last_switches);
        let mut which: Option<usize> = known.map(|(index, _)| index);
        let mut weight = R::integer(1);
        let mut high_value: Option<R> = known.map(|(_, switch)| switch.value);
        // Values within the step tell where it vanishes.
        let zero_of = |index: usize| {
            let value = |of: &[Switch<R>]| of.get(index).map(|switch| switch.value.to_f64());
            let h = h.to_f64();
            let all = std::iter::once((0.0, value(first)));
            let all = all.chain(inner.iter().map(|(part, of)| (part * h, value(of))));
            let all = all.chain([(h, value(last_switches))]);
            let mut all: Vec<(f64, f64)> = all.filter_map(|(time, value)| Some((time, value?))).collect();
            all.sort_by(|one, two| one.0.total_cmp(&two.0));
            all.dedup_by_key(|(time, _)| *time);
            Zero::near(all)
        };
        let mut vanishing: Option<(usize, Zero<R>)> = which.map(|index| (index, zero_of(index)));
        // The value before, and when.
        let mut last: Option<(R, R)> = None;
        // Half of a step that was too long.
        let mut shorter: Option<R> = None;
        let start = self.state.time;
        let finest = 10.0_f64.powi(-BEYOND - self.options.digits as i32).max(4.0 * R::ROUNDING);
        let resolution = larger(start.magnitude(), h) * R::from_f64(finest);
        // A gap is as exact as the way that it goes: what has just been left comes back from there.
        let ways: Vec<R> =
            first.iter().zip(last_switches).map(|(one, two)| largest([one.value, two.value])).collect();
        let rounded = |index: usize, now: &Switch<R>| {
            let scale = match now.cause {
                Cause::Closes(_) => ways.get(index).map_or(now.scale, |way| way.lesser(now.scale)),
                _ => now.scale,
            };
            scale * R::from_f64(16.0 * R::ROUNDING)
        };
        let mut was_away = known.is_none_or(|(index, _)| {
            first.get(index).is_none_or(|now| !matches!(now.cause, Cause::Closes(_)) || zero.less(now.value))
        });
        for iteration in 0..400 {
            let base = self.state.clone();
            let y = self.packed();
            let (slope, _) = self.flow(&base, base.time, &y).map_err(|trouble| self.say(trouble))?;
            // Back on its constraints a state may be beyond what it was just before.
            let beyond = which.filter(|_| iteration > 0).and_then(|index| slope.switches.get(index));
            if let Some(switch) = beyond.filter(|switch| switch.value.less(zero)) {
                return self.crosses(switch);
            }
            if iteration > 0 {
                low.1.clone_from(&slope.switches);
            }
            let passed = base.time - start;
            // The end of the interval is known from before, by the error of a longer step: what vanishes just beyond it is followed there.
            let value = which.and_then(|index| low.1.get(index)).map(|switch| switch.value);
            if let (Some(value), Some((at, known))) = (value, last)
                && at.less(passed)
                && value.less(known)
            {
                let left = value * (passed - at) / (known - value);
                if (high - passed).less(left) && left.less(h * R::from_f64(STALE)) {
                    high = passed + left + left;
                    high_value = Some(-value);
                    weight = R::integer(1);
                }
            }
            last = value.map(|value| (passed, value));
            // Where the switch that is nearest to its end would vanish.
            let ahead = high - passed;
            let guess = match (which, high_value) {
                (Some(index), Some(below)) if iteration % 4 != 3 => {
                    let above = low.1.get(index).map_or(zero, |switch| switch.value);
                    let span = above - below * weight;
                    let part = if was_away && zero.less(span) { above / span } else { R::ratio(1, 2) };
                    ahead * part
                }
                (None, _) => ahead,
                _ => ahead * R::ratio(1, 2),
            };
            let told = vanishing.as_ref().filter(|_| was_away && iteration < TOLD);
            let told = told.and_then(|(_, zero)| zero.time()).map(|time| time - passed);
            let guess = match told {
                Some(told) if resolution.less(told) && told.less(ahead) => told,
                // It is here, but for rounding.
                Some(told) if !resolution.less(told.magnitude()) => resolution,
                _ => guess,
            };
            let is_small = !resolution.less(ahead);
            let guess = if is_small { ahead } else { guess };
            let guess =
                if guess.less(resolution * R::ratio(1, 4)) { resolution * R::ratio(1, 4) } else { guess };
            let guess = shorter.take().map_or(guess, |most: R| guess.lesser(most));
            let tried = self.tried(&base, &y, &slope, guess).map_err(|trouble| self.say(trouble))?;
            if tried.error > 1.0 {
                shorter = Some(guess * R::ratio(1, 2));
                continue;
            }
            let (ended, _) = self.switches_at(&base, base.time + guess, &tried.end)?;
            let found = earliest(&low.1, &ended);
            let of = found.map(|(index, _)| index).or(which);
            if let Some(of) = of
                && vanishing.as_ref().is_none_or(|(known, _)| *known != of)
            {
                vanishing = Some((of, zero_of(of)));
            }
            if let (Some((of, zero)), true) = (&mut vanishing, was_away)
                && let Some(switch) = ended.get(*of)
            {
                zero.put(passed + guess, switch.value);
            }
            match found {
                None => {
                    // On this side: the state goes on to it.
                    self.commit(&base, base.time + guess, &tried.end)?;
                    low = (base.time + guess - start, ended.clone());
                    weight = R::ratio(1, 2);
                    let now = which.and_then(|index| Some((index, ended.get(index)?)));
                    let is_zero = |(index, now): (usize, &Switch<R>)| {
                        now.cause != Cause::Stops && !rounded(index, now).less(now.value.magnitude())
                    };
                    let vanishes = was_away && now.is_some_and(is_zero);
                    was_away |= now.is_some_and(|now| !is_zero(now));
                    if vanishes || !(resolution).less(high - low.0) {
                        let Some(switch) = which.and_then(|index| ended.get(index)) else { return Ok(()) };
                        return self.crosses(switch);
                    }
                }
                Some((index, switch)) => {
                    which = Some(index);
                    high = passed + guess;
                    high_value = Some(switch.value);
                    if !resolution.less(guess) {
                        self.commit(&base, base.time + guess, &tried.end)?;
                        return self.crosses(&switch);
                    }
                    weight = R::integer(1);
                }
            }
        }
        Err(self.stuck_in_time())
    }

    /// An event where a quantity passes zero. Its margin is the rate of the quantity along the motion, in its size per duration of the run.
    fn crosses(&mut self, switch: &Switch<R>) -> Result<(), Refusal> {
        let (base, y) = (self.state.clone(), self.packed());
        let h = R::from_f64(self.h.max(1e-9 * self.duration()) * DIFFERENCE);
        let value_after = |by: R| {
            let (slope, _) = self.bare_flow(&base, base.time, &y)?;
            let moved: Vec<R> = y.iter().zip(&slope.rates).map(|(y, rate)| *y + by * *rate).collect();
            let (there, _) = self.bare_flow(&base, base.time + by, &moved)?;
            let same = |other: &&Switch<R>| (other.of, other.cause) == (switch.of, switch.cause);
            Ok(there.switches.iter().find(same).map(|there| there.value))
        };
        // Where the mode has no sense on one side, the event has no margin.
        let both: Result<[Option<R>; 2], Trouble> =
            value_after(h).and_then(|then| Ok([then, value_after(-h)?]));
        if let Ok([Some(after), Some(before)]) = both {
            self.crossing = self.sharpness(before - after, h + h, switch.scale);
        }
        let done = self.happens(switch.of, switch.cause);
        self.crossing = None;
        done
    }

    /// How fast a quantity of this scale passes zero that changes by so much within h: in its scale per duration of the run. None where the scale
    /// is rounding.
    pub(crate) fn sharpness(&self, change: R, h: R, scale: R) -> Option<f64> {
        /// From this on the scale is rounding, as that of a friction that nothing presses yet.
        const MOST: f64 = 1e9;
        let rate = ((change / scale).to_f64() * (self.duration() / h.to_f64())).abs();
        (rate < MOST).then_some(rate)
    }

    /// From the beginning of the run to its end.
    pub(crate) fn duration(&self) -> f64 {
        let schedule = &self.mechanism.schedule;
        let last = schedule.len().checked_sub(1).and_then(|last| schedule.span(last));
        let end = last.map_or(1.0, |([_, end], _)| end);
        self.options.until.map_or(end, |until| until.min(end)).max(f64::MIN_POSITIVE)
    }

    /// Goes on to a state, and back to its constraints.
    pub(crate) fn commit(&mut self, base: &State<R>, time: R, y: &[R]) -> Result<(), Refusal> {
        self.modes.frictions.iter_mut().for_each(|mode| mode.branches.turned.clear());
        let kinetic = self.arrive(base, time, y)?;
        let far = self.state.poses.iter().flat_map(|pose| pose.displacement).map(|x| x.to_f64().abs());
        self.solution.farthest = far.fold(self.solution.farthest, f64::max);
        if !self.is_still {
            self.solution.liveliest = self.solution.liveliest.max(kinetic.to_f64());
        }
        if let Some(reached) = &self.options.reached {
            reached.store(self.state.time.to_f64().to_bits(), Ordering::Relaxed);
        }
        self.fastest = self.speed();
        Ok(())
    }

    /// The state there, on its constraints; the kinetic energy with which it came.
    fn arrive(&mut self, base: &State<R>, time: R, y: &[R]) -> Result<R, Refusal> {
        let n = self.layout.columns.len();
        let (poses, rates, turned) = self.unpacked(base, y, true);
        let mut next = State {
            time,
            poses,
            rates,
            branches: base.branches.clone(),
            sums: y.get(2 * n..).unwrap_or_default().to_vec(),
        };
        let instant = Instant { turned: &turned, ..Instant::of(&next, self.step, &turned) };
        let found = self
            .mechanism
            .assemble(&instant, &self.modes, &self.beginnings)
            .map_err(|trouble| self.say(trouble))?;
        next.branches = found.joints.iter().map(|now| now.branch).collect();
        self.layout.arrange(&found);
        self.state = next;
        let kinetic = found.kinetic();
        self.project_from(found)?;
        Ok(kinetic)
    }

    /// Brings positions and rates back to the equations.
    pub(crate) fn project(&mut self) -> Result<(), Refusal> {
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        self.project_from(found)
    }

    /// What a residual of an equation is measured by: 1 rad, or the length of the model.
    pub(crate) fn size_of(&self, owner: Owner) -> R {
        match owner {
            Owner::Joint(_, k) if k >= 3 => R::integer(1),
            Owner::Mpc(_, row) if (3..6).contains(&row) => R::integer(1),
            Owner::Given(of) if self.mechanism.velocities.get(of).is_some_and(|(_, k, _)| *k >= 3) => {
                R::integer(1)
            }
            _ => R::from_f64(self.mechanism.length),
        }
    }

    /// Brings positions back to what the layout keeps.
    pub(crate) fn place(&mut self, mut found: Assembled<R>) -> Result<Assembled<R>, Refusal> {
        let zero = R::ZERO;
        let small = R::from_f64(4.0 * R::ROUNDING);
        for iteration in 0..12 {
            let gap = self.layout.kept.iter().fold(zero, |most, index| {
                let row = &found.rows[*index];
                let gap = row.residual.unwrap_or(zero).magnitude() / self.size_of(row.owner);
                larger(most, gap)
            });
            if !small.less(gap) || has(Fault::Drift) {
                break;
            }
            if iteration == 11 {
                break;
            }
            let (change, _) =
                found.correction(&self.layout, |row| row.residual).map_err(|trouble| self.say(trouble))?;
            let by: Vec<[R; DOFS]> =
                change.chunks_exact(DOFS).map(|of| std::array::from_fn(|k| of[k])).collect();
            let mut rates = std::mem::take(&mut self.state.rates);
            let (poses, turned) = self.moved_by(&self.state.poses, &by, &mut rates, true);
            (self.state.poses, self.state.rates) = (poses, rates);
            let instant = Instant { turned: &turned, ..Instant::of(&self.state, self.step, &turned) };
            found = self
                .mechanism
                .assemble(&instant, &self.modes, &self.beginnings)
                .map_err(|trouble| self.say(trouble))?;
            self.state.branches = found.joints.iter().map(|now| now.branch).collect();
            if self.is_still {
                found.rest(&self.mechanism);
            }
            if !R::from_f64(1e3 * R::ROUNDING).less(gap) {
                break;
            }
        }
        Ok(found)
    }

    /// The same, where it is known what holds now.
    fn project_from(&mut self, found: Assembled<R>) -> Result<(), Refusal> {
        let zero = R::ZERO;
        let found = self.place(found)?;
        if self.is_still {
            return Ok(());
        }
        let (change, _) =
            found.correction(&self.layout, |row| row.rate).map_err(|trouble| self.say(trouble))?;
        for (dof, by) in change.iter().enumerate() {
            let rate = &mut self.state.rates[dof / DOFS][dof % DOFS];
            *rate = *rate + *by;
        }
        // What equations hold, and nothing drives, rests bit for bit.
        for (unknowns, rows) in &self.layout.determined {
            if rows
                .iter()
                .all(|row| found.rows[*row].rate.is_some() && !zero.less(found.rows[*row].driven.magnitude()))
            {
                for i in unknowns {
                    let dof = self.layout.columns[*i];
                    self.state.rates[dof / DOFS][dof % DOFS] = zero;
                }
            }
        }
        self.bring();
        Ok(())
    }
}

/// Σ x y.
pub(crate) fn along_of<R: Number>(one: &[R], other: &[R]) -> R {
    one.iter().zip(other).fold(R::ZERO, |sum, (x, y)| sum + *x * *y)
}

/// The switch that is crossed first, by its value before and now.
fn earliest<R: Number>(before: &[Switch<R>], now: &[Switch<R>]) -> Option<(usize, Switch<R>)> {
    let part = |(now, before): (&Switch<R>, &Switch<R>)| (before.value / (before.value - now.value)).to_f64();
    let pairs = now.iter().zip(before).enumerate();
    let crossed = pairs.filter(|(_, (now, before))| now.value.less(R::ZERO) && !before.value.less(R::ZERO));
    let first = crossed.min_by(|(_, one), (_, two)| part(*one).total_cmp(&part(*two)));
    first.map(|(index, (now, _))| (index, *now))
}

/// Where a step passed the end of a mode.
pub(crate) enum Crossing {
    /// Within it, at this part.
    Inside(f64),
    /// At its end.
    AtEnd,
}

/// Whether a switch became negative.
pub(crate) fn crossing<R: Number>(
    first: &[Switch<R>],
    inner: &[(f64, Vec<Switch<R>>)],
    last: &[Switch<R>],
) -> Option<Crossing> {
    let zero = R::ZERO;
    let dips = dips(first, inner, last);
    let passes = |now: &[Switch<R>]| {
        now.iter().zip(first).any(|(now, before)| now.value.less(zero) && !before.value.less(zero))
    };
    if passes(last) {
        return Some(Crossing::AtEnd);
    }
    let found = inner.iter().find(|(_, switches)| {
        switches.iter().zip(first).any(|(now, before)| {
            // Points within a step are less exact than its end.
            let margin = now.scale * R::from_f64(1e-6);
            (now.value + margin).less(zero) && !before.value.less(zero)
        })
    });
    found.map(|(part, _)| *part).or(dips).map(Crossing::Inside)
}

/// Where a switch comes so near to zero within a step that it may have passed and returned between two points.
fn dips<R: Number>(first: &[Switch<R>], inner: &[(f64, Vec<Switch<R>>)], last: &[Switch<R>]) -> Option<f64> {
    /// A vertex below this part of its neighbours is looked at.
    const LOW: f64 = 0.2;
    let mut earliest: Option<f64> = None;
    for i in 0..first.len() {
        let value = |switches: &[Switch<R>]| switches.get(i).map(|switch| switch.value.to_f64());
        let all = std::iter::once((0.0, value(first)))
            .chain(inner.iter().map(|(part, switches)| (*part, value(switches))))
            .chain([(1.0, value(last))]);
        let points: Vec<(f64, f64)> = all.filter_map(|(part, value)| Some((part, value?))).collect();
        let scale = first[i].scale.to_f64();
        for three in points.windows(3) {
            let [(t0, g0), (t1, g1), (t2, g2)] = [three[0], three[1], three[2]];
            if g0.min(g2) <= 1e-9 * scale {
                continue;
            }
            // The vertex of the parabola through the three.
            let (s0, s1) = ((g1 - g0) / (t1 - t0), (g2 - g1) / (t2 - t1));
            let bend = (s1 - s0) / (t2 - t0);
            let at = (t0 + t1) / 2.0 - s0 / (2.0 * bend);
            if !(bend > 0.0 && t0 < at && at < t2) {
                continue;
            }
            let lowest = g0 + s0 * (at - t0) + bend * (at - t0) * (at - t1);
            // Points are too far apart to tell where it bends as much between them as it is high.
            let unsure = bend * (t1 - t0).max(t2 - t1).powi(2);
            if lowest < unsure.max(LOW * g0.min(g2)) && at > 1e-3 && at < 1.0 - 1e-3 {
                earliest = Some(earliest.map_or(at, |known: f64| known.min(at)));
            }
        }
    }
    earliest
}
