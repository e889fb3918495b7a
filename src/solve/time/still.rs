//! Static steps: the quasi-static path. Each of its states is an equilibrium by itself, found by Newton's method; time is what loads and
//! prescribed motions follow. The modes are those of dynamics: what sticks is held, what slips has the force μ F_N, stops push.
//!
//! *Equilibrium.* Unit masses stand in place of the real ones. Let a be the accelerations at rest, and c the least change of positions that
//! satisfies the equations. a lies in the kernel of J, c across it. So a + c = 0 says both: equations hold, and forces balance. Newton's
//! matrix is formed by differences; what decides is the residual.
//!
//! *Uniqueness* is lost where Newton's matrix is singular: its determinant changes sign, or no equilibrium follows. Both end the path by name.
//! Rates are zero on it: dampers take nothing, μ is that of rest. Energies are the work along it, from its first equilibrium on.

use crate::motion::equations::Solved;
use crate::motion::linear::{Newton, System};
use crate::motion::mechanism::Mechanism;
use crate::motion::mode::{Cause, Does, Mode, Switch, Touch};
use crate::motion::rows::{Assembled, Instant, Layout, Trouble};
use crate::motion::slide::length;
use crate::motion::state::{DOFS, State, WORKS};
use crate::number::{Number, is_finite, larger, largest};
use crate::refusal::Refusal;
use crate::time::integrate::{Method, at_zero};
use crate::time::run::Run;
use crate::time::solution::{Event, What};
use crate::time::step::{Crossing, PARTS, along_of, crossing, shortest_period};
use pintle_kinematics::vector::Vector;

/// A state, its equations and their solution.
type Moved<R> = (State<R>, Assembled<R>, Solved<R>);

/// An equilibrium.
#[derive(Clone)]
pub(crate) struct Found<R: Number> {
    pub(crate) state: State<R>,
    pub(crate) solved: Solved<R>,
    /// The positions of the connector of each friction.
    pub(crate) positions: Vec<[R; 6]>,
    /// By what the degrees of freedom have changed.
    pub(crate) by: Vec<R>,
    /// Where frictions slip along curves: their step.
    pub(crate) curve: Option<Curve<R>>,
    /// The sign of the determinant of Newton's matrix, at the beginning of the iterations.
    sign: f64,
}

/// What a step knows besides its end.
#[derive(Clone, Debug)]
pub(crate) struct Curve<R> {
    pub(crate) slips: Vec<Slip<R>>,
    /// Switches within the step, by the part of it that has passed.
    pub(crate) inner: Vec<(f64, Vec<Switch<R>>)>,
    /// Work along the step.
    pub(crate) works: [R; WORKS],
}

/// A slip of several components during a step.
#[derive(Clone, Debug)]
pub(crate) struct Slip<R> {
    /// Whose it is.
    pub(crate) of: usize,
    /// n at the beginning and at the end.
    pub(crate) along: [[R; 6]; 2],
    /// γ at the beginning and at the end.
    pub(crate) rates: [R; 2],
}

/// Where frictions are before a slip, and how far those have slipped of which that is known.
struct Before<'a, R> {
    positions: Vec<[R; 6]>,
    slips: &'a [(usize, R)],
}

/// How many roundings a slip may be off: that of two positions. Each comes from two triads, a difference of points and a product with a
/// direction, some thirty operations.
const SLIP_ROUNDINGS: f64 = 64.0;

/// A step that leaves less than this part of itself goes to the end: of a rest as small as rounding, forth and back are the same.
const REST: f64 = 1e-6;

/// The part of a step by which the rate is found of what passes zero.
const NEAR: f64 = 1e-3;

impl<R: Number> Assembled<R> {
    /// At rest: unit masses where something acts, and no accelerations that are prescribed.
    pub(crate) fn rest(&mut self, mechanism: &Mechanism<R>) {
        let (zero, one) = (R::ZERO, R::integer(1));
        let inertia = R::from_f64(mechanism.length * mechanism.length);
        let acts = self.acting(mechanism);
        for (node, (mass, matrix)) in self.masses.iter_mut().zip(&mut self.inertias).enumerate() {
            let [moves, turns] = [0, 3].map(|from| (from..from + 3).any(|k| acts[DOFS * node + k]));
            *mass = if moves { one } else { zero };
            for (i, row) in matrix.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry = if i == j && turns { inertia } else { zero };
                }
            }
        }
        for (dof, _) in
            self.joints.iter().flat_map(|now| now.columns.iter().flat_map(|of| self.lines.of(*of)))
        {
            if dof % DOFS == DOFS - 1 {
                self.flows[dof / DOFS] = one;
            }
        }
        self.rows.iter_mut().for_each(|row| row.bias = zero);
    }

    /// The degrees of freedom on which something acts, now or as they move: a node that only AXIAL connectors hold does not turn.
    pub(crate) fn acting(&self, mechanism: &Mechanism<R>) -> Vec<bool> {
        let mut acts: Vec<bool> = (0..self.applied.len())
            .map(|dof| self.is_loaded(dof) || dof % DOFS < 6 && self.has_inertia(dof))
            .collect();
        for (dof, _) in self.lines.all() {
            acts[*dof] = true;
        }
        for (node, body) in mechanism.bodies.iter().enumerate() {
            for (k, _) in &body.loads {
                acts[DOFS * node + k / 3 * 3] = true;
            }
            acts[DOFS * node] |= !body.weights.is_empty();
        }
        for spring in &mechanism.springs {
            let along = spring.line.into_iter().flatten().map(|node| (node, false));
            for (node, turns) in along.chain(spring.terms.iter().map(|(node, _, turns, _)| (*node, *turns))) {
                acts[DOFS * node + if turns { 3 } else { 0 }] = true;
            }
        }
        // What acts on a node that is carried moves and turns the one that carries it.
        for node in (0..mechanism.bodies.len()).filter(|node| mechanism.root(*node) != *node) {
            let root = mechanism.root(node);
            let [moves, turns] =
                [0, 3].map(|from| acts[DOFS * node + from..DOFS * node + from + 3].contains(&true));
            acts[DOFS * root] |= moves;
            acts[DOFS * root + 3] |= moves || turns;
            acts[DOFS * node..DOFS * node + 6].fill(false);
        }
        acts
    }
}

impl<R: Number> Run<'_, R> {
    /// One static step of the scene, to a time.
    pub(crate) fn still(&mut self, to: f64) -> Result<(), Refusal> {
        if !std::mem::take(&mut self.is_resumed) {
            self.began = self.state.time.to_f64();
            // What moves is brought to rest.
            self.is_still = false;
            let moving = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?.kinetic();
            self.is_still = true;
            if !self.solution.frames.is_empty() {
                self.state.sums[1] = self.state.sums[1] + moving;
            }
            self.state.rates.iter_mut().for_each(|rates| *rates = [R::ZERO; DOFS]);
            self.begin_still()?;
        }
        let breaks = self.breaks();
        let mut stops: Vec<(f64, bool)> = vec![(to, true)];
        stops.extend(self.options.times.iter().map(|time| (*time, true)));
        stops.extend(breaks.iter().map(|time| (*time, false)));
        let now = self.state.time.to_f64();
        stops.retain(|(time, _)| *time > now && *time <= to);
        stops.sort_by(|one, two| one.0.total_cmp(&two.0).then(two.1.cmp(&one.1)));
        stops.dedup_by_key(|(time, _)| *time);
        if self.solution.frames.is_empty() {
            self.record(false)?;
        }
        // The witness goes another way: other steps, and so other beginnings of Newton's method.
        let parts = if self.options.method == Method::Extrapolation { 50.0 } else { 37.0 };
        let most = ((to - self.began) / parts).min(shortest_period(self.scene) / PARTS);
        for (time, is_frame) in stops {
            self.keep(false);
            self.go(R::from_f64(time), R::from_f64(most))?;
            if is_frame {
                self.record(false)?;
            }
        }
        self.state.rates.iter_mut().for_each(|rates| *rates = [R::ZERO; DOFS]);
        Ok(())
    }

    /// Everything that may stick stands; stops are as positions have them; then equilibrium at the first time.
    fn begin_still(&mut self) -> Result<(), Refusal> {
        self.remember()?;
        self.prepare()?;
        self.touch()?;
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let sliders = self.mechanism.sliders.iter();
        self.modes.frictions = sliders.map(|of| Mode::sticks(found.joints[of.joint].position)).collect();
        self.modes.spans = self.spans(&found);
        self.relay()?;
        let found = self.balance(self.state.time)?;
        self.state = found.state;
        Ok(())
    }

    fn relay(&mut self) -> Result<(), Refusal> {
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        self.layout = Layout::new(&self.mechanism, &found, &self.modes)?;
        self.newton = None;
        Ok(())
    }

    /// The state after δ, and what holds there.
    fn moved(&self, time: R, by: &[R], before: &Before<'_, R>) -> Result<Moved<R>, Trouble> {
        let base = &self.state;
        let mut y = by.to_vec();
        y.resize(2 * by.len(), R::ZERO);
        let (poses, rates, turned): (_, _, Vec<Vector<R>>) = self.unpacked(base, &y, true);
        let mut next = State { time, poses, rates, branches: base.branches.clone(), sums: base.sums.clone() };
        let instant = Instant { turned: &turned, ..Instant::of(&next, self.step, &turned) };
        let mut found = self.mechanism.assemble(&instant, &self.modes, &self.beginnings)?;
        found.rest(&self.mechanism);
        next.branches = found.joints.iter().map(|now| now.branch).collect();
        let frictions = self.mechanism.sliders.iter().zip(&self.modes.frictions).zip(&before.positions);
        for (s, ((slider, mode), then)) in frictions.enumerate() {
            let Does::Slips(along) = &mode.does else { continue };
            let (Some(sum), Some(slip)) = (next.sums.get_mut(WORKS + s), found.slips.get_mut(s)) else {
                continue;
            };
            *sum = match before.slips.iter().find(|(of, _)| *of == s) {
                Some((_, known)) => *known,
                None => *sum + along_of(along, &slider.moved(then, &found.joints[slider.joint].position)),
            };
            *slip = *sum;
        }
        let solved = found.solve(&self.mechanism, &self.layout, &self.modes)?;
        Ok((next, found, solved))
    }

    /// a + c.
    fn unbalance(&self, time: R, by: &[R], before: &Before<'_, R>) -> Result<Vec<R>, Trouble> {
        let (_, found, solved) = self.moved(time, by, before)?;
        if let Some(row) = self.layout.kept.iter().find(|row| found.rows[**row].residual.is_none()) {
            return Err(Trouble::Unknown(
                self.mechanism.named(found.rows[*row].owner),
                "a velocity or acceleration is prescribed in a static step".to_string(),
            ));
        }
        let (change, _) = found.correction(&self.layout, |row| row.residual)?;
        let columns = self.layout.columns.iter();
        Ok(columns.map(|dof| solved.accelerations[dof / DOFS][dof % DOFS] + change[*dof]).collect())
    }

    /// The equilibrium at a time, next to this state.
    pub(crate) fn balance(&mut self, time: R) -> Result<Found<R>, Refusal> {
        let curving = self.curving();
        if curving.is_empty() || !self.state.time.less(time) {
            return self.equilibrium(time, &[], &[]);
        }
        self.along_curves(time, &curving)
    }

    /// The same where frictions slip along the direction that each has, from degrees of freedom that are near. `slips` are known of some.
    pub(crate) fn equilibrium(
        &mut self,
        time: R,
        near: &[R],
        slips: &[(usize, R)],
    ) -> Result<Found<R>, Refusal> {
        let zero = R::ZERO;
        let n = self.layout.columns.len();
        let start = if near.len() == n { near.to_vec() } else { vec![zero; n] };
        let beginning = self.beginning(slips).map_err(|trouble| self.say(trouble))?;
        let kept = self.newton.take().filter(|kept| kept.columns == self.layout.columns);
        let reused = kept.is_some();
        let found = match self.iterated(time, start.clone(), &beginning, kept) {
            Err(_) if reused => self.iterated(time, start, &beginning, None),
            found => found,
        };
        let (by, newton) = found?;
        let sign = newton.as_ref().map_or(0.0, |newton| newton.sign);
        self.newton = newton;
        self.solution.steps += 1;
        let (state, found, mut solved) =
            self.moved(time, &by, &beginning).map_err(|trouble| self.say(trouble))?;
        solved.switches.retain(|switch| switch.cause != Cause::Stops);
        let positions =
            self.mechanism.sliders.iter().map(|slider| found.joints[slider.joint].position).collect();
        Ok(Found { state, solved, positions, by, curve: None, sign })
    }

    /// Newton's method from degrees of freedom on, with a matrix that is formed again where it is no longer near enough.
    fn iterated(
        &mut self,
        time: R,
        mut by: Vec<R>,
        beginning: &Before<'_, R>,
        mut newton: Option<Newton<R>>,
    ) -> Result<(Vec<R>, Option<Newton<R>>), Refusal> {
        const ITERATIONS: usize = 120;
        /// What a matrix leaves of a change, at most, for it to be kept.
        const LEFT: f64 = 0.1;
        let n = self.layout.columns.len();
        if n == 0 {
            // It says what cannot be solved.
            self.unbalance(time, &by, beginning).map_err(|trouble| self.say(trouble))?;
            return Ok((by, None));
        }
        let sizes = self.sizes();
        let small = 8.0 * R::ROUNDING;
        let noise = 1e5 * R::ROUNDING;
        let reused = newton.is_some();
        let mut sign = newton.as_ref().map(|known| known.sign);
        // The change before, by this matrix; and whether this matrix is known to be near enough.
        let (mut before, mut is_near) = (f64::INFINITY, false);
        for _ in 0..ITERATIONS {
            let residual = self.unbalance(time, &by, beginning).map_err(|trouble| self.say(trouble))?;
            self.solution.evaluations += 1;
            let is_formed = newton.is_none();
            let now = match newton.take() {
                Some(known) => known,
                None => {
                    let formed = self.newton(time, &by, beginning).map_err(|trouble| self.say(trouble))?;
                    // An iterate on the way may be beyond a limit point that the path does not reach.
                    Newton { sign: *sign.get_or_insert(formed.sign), ..formed }
                }
            };
            let mut system = now.matrix.clone();
            residual.iter().enumerate().for_each(|(i, x)| system.add(i, n, -*x));
            let change = system.solve().map_err(|_| self.lost())?.into_iter().next().unwrap_or_default();
            if !change.iter().all(|x| is_finite(*x)) {
                return Err(self.lost());
            }
            let most = largest(change.iter().zip(&sizes).map(|(x, size)| *x / *size)).to_f64();
            by.iter_mut().zip(&change).for_each(|(x, more)| *x = *x + *more);
            if is_formed {
                (before, is_near) = (f64::INFINITY, most < noise);
            }
            // As small as rounding leaves it.
            let left = most / before;
            let is_noise = most < noise && left > 0.3 && is_near;
            if most <= small || is_noise {
                return Ok((by, Some(now)));
            }
            if most > 1e3 || reused && left >= 1.0 {
                return Err(self.lost());
            }
            let is_slow =
                before.is_finite() && (left > LEFT || (small / most).ln() / left.ln() > (2 * n) as f64);
            is_near |= left <= LEFT;
            before = most;
            newton = (!is_slow).then_some(now);
        }
        Err(self.lost())
    }

    /// The sizes of the degrees of freedom.
    fn sizes(&self) -> Vec<R> {
        let size = |dof: &usize| if dof % DOFS < 3 { self.mechanism.length } else { 1.0 };
        self.layout.columns.iter().map(|dof| R::from_f64(size(dof))).collect()
    }

    /// Where the path is lost.
    fn lost(&self) -> Refusal {
        Refusal::of(
            "the static path",
            &format!(
                "no equilibrium follows at time {}: it is not unique there, or there is none (a limit point)",
                self.state.time.to_f64()
            ),
            "hold or spring what moves freely, load less, or use *DYNAMIC",
        )
    }

    /// Newton's matrix by differences.
    fn newton(&mut self, time: R, by: &[R], beginning: &Before<'_, R>) -> Result<Newton<R>, Trouble> {
        let n = by.len();
        let sizes = self.sizes();
        let step = R::from_f64(R::ROUNDING.powf(1.0 / 3.0));
        let half = R::ratio(1, 2);
        let mut matrix = System::new(n, 1);
        let mut plain = nalgebra::DMatrix::<f64>::zeros(n, n);
        for j in 0..n {
            let h = step * sizes[j];
            let at = |sign: R| {
                let mut other = by.to_vec();
                other[j] = other[j] + sign * h;
                self.unbalance(time, &other, beginning)
            };
            let (above, below) = (at(R::integer(1))?, at(R::integer(-1))?);
            for i in 0..n {
                let slope = (above[i] - below[i]) * half / h;
                matrix.add(i, j, slope);
                plain[(i, j)] = slope.to_f64() * (sizes[j] / sizes[i]).to_f64();
            }
        }
        self.solution.evaluations += 2 * n;
        // The determinant by its sign alone, of a matrix whose rows have the size 1.
        for mut row in plain.row_iter_mut() {
            let most = row.amax();
            if most > 0.0 {
                row /= most;
            }
        }
        Ok(Newton { columns: self.layout.columns.clone(), matrix, sign: plain.determinant() })
    }

    /// Where frictions are now.
    fn beginning<'a>(&self, slips: &'a [(usize, R)]) -> Result<Before<'a, R>, Trouble> {
        let positions = match self.modes.frictions.iter().any(|mode| !mode.is_stuck()) {
            true => {
                let now = self.assembled(&self.modes)?;
                self.mechanism.sliders.iter().map(|slider| now.joints[slider.joint].position).collect()
            }
            false => Vec::new(),
        };
        Ok(Before { positions, slips })
    }

    /// A friction that stands, of which others prescribe how it moves, and that has moved: the direction, by component times radius.
    fn carried_off(&self, found: &Found<R>, at: &Assembled<R>) -> Option<(usize, [R; 6])> {
        let stuck =
            self.mechanism.sliders.iter().zip(&self.modes.frictions).zip(&found.positions).enumerate();
        stuck.filter(|(s, _)| self.is_carried(*s)).find_map(|(s, ((slider, mode), now))| {
            let Does::Sticks(from) = &mode.does else { return None };
            let moved = slider.moved(from, now);
            let far = length(&moved);
            self.slip_noise(at, s).less(far).then(|| (s, moved.map(|x| x / far)))
        })
    }

    /// Whether how a friction moves is prescribed, by its own components or by what else holds its nodes.
    fn is_carried(&self, s: usize) -> bool {
        let slider = &self.mechanism.sliders[s];
        slider.components.iter().any(|(k, _)| {
            self.mechanism.is_given(slider.joint, *k, self.step)
                || self.layout.carried.contains(&(slider.joint, *k))
        })
    }

    /// The slip of a friction between this state and one found.
    fn slip_to(&self, found: &Found<R>, s: usize) -> R {
        found.state.sums[WORKS + s] - self.state.sums[WORKS + s]
    }

    /// What rounding leaves of a slip between two states (length, or rad by the radius of a component).
    ///
    /// It is [`SLIP_ROUNDINGS`] of the positions or of the unit that they are solved in, and of the sum that the slip is added to.
    pub(crate) fn slip_noise(&self, at: &Assembled<R>, s: usize) -> R {
        let slider = &self.mechanism.sliders[s];
        let position = &at.joints[slider.joint].position;
        let moved = slider.components.iter().fold(R::ZERO, |sum, (k, radius)| {
            let unit = if *k < 3 { self.mechanism.length } else { 1.0 };
            sum + R::from_f64(*radius) * larger(position[*k].magnitude(), R::from_f64(unit))
        });
        (moved + self.state.sums[WORKS + s].magnitude()) * R::from_f64(SLIP_ROUNDINGS * R::ROUNDING)
    }

    fn slipping(&self) -> Vec<usize> {
        let frictions = &self.modes.frictions;
        (0..frictions.len()).filter(|s| !frictions[*s].is_stuck()).collect()
    }

    /// Along the path to a time, over all events before it.
    fn go(&mut self, goal: R, most: R) -> Result<(), Refusal> {
        let zero = R::ZERO;
        let mut h = most;
        let mut last_sign: Option<f64> = None;
        let mut events_here = 0;
        while self.state.time.less(goal) {
            if self.solution.steps > self.options.most_steps {
                return Err(self.stuck_in_time());
            }
            let left = goal - self.state.time;
            let is_last = !h.less(left * R::from_f64(1.0 - REST));
            let time = if is_last { goal } else { self.state.time + h };
            let length = time - self.state.time;
            // Its sign is that of this step's beginning.
            self.newton = None;
            let found = match self.balance(time) {
                Ok(found) => found,
                Err(why) => {
                    h = length * R::ratio(1, 4);
                    if h.less(most * R::from_f64(1e-8)) {
                        return Err(why);
                    }
                    continue;
                }
            };
            let (_, known, first) = self.here().map_err(|trouble| self.say(trouble))?;
            self.depart(&known);
            // Where all that presses passes zero, what friction carries is rounding of the other forces.
            let forces =
                larger(largest(first.forces.iter().copied()), largest(first.total.iter().flatten().copied()));
            let size = |switch: &Switch<R>| match switch.cause {
                Cause::Breaks => larger(switch.scale, forces),
                _ => switch.scale,
            };
            let now: Vec<Switch<R>> =
                first.switches.into_iter().filter(|switch| switch.cause != Cause::Stops).collect();
            // What is beyond its end already ends here.
            let slack = |switch: &Switch<R>| size(switch) * R::from_f64(1e4 * R::ROUNDING);
            let overdue = now.iter().find(|switch| switch.value.less(-slack(switch)));
            if let Some((s, moved)) = self.carried_off(&found, &known) {
                events_here += 1;
                self.bounded(events_here)?;
                self.modes.frictions[s] = Mode::slips(moved);
                self.relay()?;
                // Along a curve it begins along its tangent.
                if let Some(slip) = self.curved(time, s)? {
                    self.modes.frictions[s] = Mode::slips(slip.along[0]);
                }
                self.event(s, What::Slips, None);
                self.record(true)?;
                last_sign = None;
                continue;
            }
            let mut reversed = None;
            for s in self.slipping() {
                let noise = self.slip_noise(&known, s);
                // Forth and back within the step it may have gone farther forth.
                if self.slip_to(&found, s).less(zero - noise)
                    || self.slip_rate(length, s, length)?.less(zero - noise / self.difference(length))
                {
                    reversed = Some(s);
                    break;
                }
            }
            if let Some(switch) = overdue {
                events_here += 1;
                self.bounded(events_here)?;
                let (of, cause) = (switch.of, switch.cause);
                self.meets_at_rest(of, cause)?;
                last_sign = None;
                continue;
            }
            if let Some(s) = reversed {
                self.turn_back(s, length)?;
                events_here += 1;
                self.bounded(events_here)?;
                last_sign = None;
                continue;
            }
            // What stays at its limit, as a belt that nothing moves any more, is on either side of it by rounding.
            let rounded = |switch: &Switch<R>| size(switch) * R::from_f64(1e3 * R::ROUNDING);
            let crossed = found.solved.switches.iter().zip(&now).position(|(then, now)| {
                then.cause == now.cause && then.value.less(-rounded(then)) && !now.value.less(-slack(now))
            });
            if let Some(index) = crossed {
                let (time, of, cause) = self.passing(&now, index, length)?;
                let d = length * R::from_f64(NEAR);
                let before = self.balance(time - d)?;
                let found = self.balance(time)?;
                let same = |switch: &&Switch<R>| (switch.of, switch.cause) == (of, cause);
                let passing = [&before, &found].map(|at| at.solved.switches.iter().find(same).copied());
                self.advance(found)?;
                if let [Some(before), Some(now)] = passing {
                    self.crossing = self.sharpness(before.value - now.value, d, now.scale);
                }
                self.meets_at_rest(of, cause)?;
                self.crossing = None;
                last_sign = None;
                continue;
            }
            // What passes its end and returns within the step is looked at more closely.
            if (most * R::from_f64(1e-6)).less(length)
                && let Some(part) = self.dip(&now, &found, length)?
            {
                h = length * R::from_f64(part);
                continue;
            }
            if last_sign.is_some_and(|sign| sign * found.sign < 0.0) {
                return Err(Refusal::of(
                    "the static path",
                    &format!(
                        "the equilibrium is not unique between time {} and {}: Newton's matrix changes the sign of its determinant",
                        self.state.time.to_f64(),
                        time.to_f64()
                    ),
                    "the path goes through a limit point or a bifurcation: use *DYNAMIC from before it",
                ));
            }
            last_sign = Some(found.sign);
            events_here = 0;
            self.advance(found)?;
            h = (length + length).lesser(most);
            if let Some(reached) = &self.options.reached {
                reached.store(time.to_f64().to_bits(), std::sync::atomic::Ordering::Relaxed);
            }
        }
        Ok(())
    }

    /// What holds now.
    fn here(&self) -> Result<Moved<R>, Trouble> {
        self.moved(self.state.time, &vec![R::ZERO; self.layout.columns.len()], &self.beginning(&[])?)
    }

    /// What has left its stop is open: at rest nothing else tells.
    fn depart(&mut self, known: &Assembled<R>) {
        /// So near to its limit a component is there (rad, or lengths of the model).
        const MEETS: f64 = 1e-9;
        for (stop, touch) in self.mechanism.stops.iter().zip(&mut self.modes.stops) {
            let Touch::Leaves(side) = *touch else { continue };
            let unit = if stop.component < 3 { self.mechanism.length } else { 1.0 };
            let gap = stop.gap(side, known.joints[stop.joint].position[stop.component]);
            if gap.is_some_and(|gap| gap.to_f64() > MEETS * unit) {
                *touch = Touch::Open;
            }
        }
    }

    /// Where within a step a quantity comes so near to the end of its mode that it may have passed and returned.
    fn dip(&mut self, now: &[Switch<R>], found: &Found<R>, length: R) -> Result<Option<f64>, Refusal> {
        let mut inner = found.curve.as_ref().map_or_else(Vec::new, |curve| curve.inner.clone());
        let parts: &[f64] = if inner.is_empty() { &[0.25, 0.5, 0.75] } else { &[] };
        for part in parts {
            let between = self.balance(self.state.time + length * R::from_f64(*part))?;
            inner.push((*part, between.solved.switches));
        }
        Ok(match crossing(now, &inner, &found.solved.switches) {
            Some(Crossing::Inside(part)) => Some(part),
            _ => None,
        })
    }

    /// Events at one place that go on for ever have no solution.
    fn bounded(&self, events: usize) -> Result<(), Refusal> {
        const MOST: usize = 20;
        if events <= MOST {
            return Ok(());
        }
        Err(Refusal::of(
            "the static path",
            &format!("no mode is consistent at time {}: a jam", self.state.time.to_f64()),
            "reduce the coefficient of friction, or use *DYNAMIC",
        ))
    }

    /// When the first of the switches vanishes that are negative after `length`, each state an equilibrium by itself.
    fn passing(
        &mut self,
        now: &[Switch<R>],
        mut index: usize,
        length: R,
    ) -> Result<(R, usize, Cause), Refusal> {
        let (zero, half) = (R::ZERO, R::ratio(1, 2));
        let start = self.state.time;
        let resolution = larger(start.magnitude(), length) * R::from_f64(4.0 * R::ROUNDING);
        let (mut low, mut high) = (zero, length);
        let mut low_value = now[index].value;
        let mut high_value: Option<R> = None;
        for iteration in 0..300 {
            if !resolution.less(high - low) {
                break;
            }
            let width = high - low;
            let guess = match high_value {
                Some(below) if iteration % 3 != 2 && zero.less(low_value) => {
                    let span = low_value - below;
                    let part = if zero.less(span) { low_value / span } else { half };
                    // Past the root by a little, so that both ends come near it.
                    low + width * part
                }
                _ => low + width * half,
            };
            let guess = if guess.less(low + resolution * half) { low + resolution * half } else { guess };
            let found = self.balance(start + guess)?;
            let switches = &found.solved.switches;
            // That which is known to cross may begin below zero, by rounding.
            let negative = switches.iter().zip(now).enumerate().find(|(i, (then, now))| {
                then.cause == now.cause && then.value.less(zero) && (*i == index || !now.value.less(zero))
            });
            match negative.map(|(other, (then, _))| (other, then.value)) {
                Some((other, value)) => {
                    if other != index {
                        index = other;
                        low_value = now[index].value;
                        low = zero;
                    }
                    (high, high_value) = (guess, Some(value));
                }
                None => {
                    low = guess;
                    if let Some(switch) = switches.get(index) {
                        let rounded = switch.scale * R::from_f64(16.0 * R::ROUNDING);
                        // What begins at its end, as stick after a slip, vanishes only once it has been away from it.
                        if rounded.less(low_value) && !rounded.less(switch.value.magnitude()) {
                            high = guess;
                        }
                        low_value = switch.value;
                    }
                }
            }
        }
        Ok((start + high, now[index].of, now[index].cause))
    }

    /// A slip turns back within `length`: it sticks where its rate is zero.
    fn turn_back(&mut self, s: usize, length: R) -> Result<(), Refusal> {
        let zero = R::ZERO;
        let start = self.state.time;
        let mut values = [self.slip_rate(zero, s, length)?, R::integer(-1)];
        if !zero.less(values[0]) {
            // At once: the load has turned here.
            return self.stick_at_rest(s);
        }
        let (mut low, mut high) = (zero, length);
        values[1] = self.slip_rate(high, s, length)?;
        if !values[1].less(zero) {
            // It has turned back, and forth again.
            high = high * R::ratio(1, 2);
            values[1] = self.slip_rate(high, s, length)?;
        }
        let resolution = length * R::from_f64(1e3 * R::ROUNDING);
        for iteration in 0..200 {
            if !resolution.less(high - low) {
                break;
            }
            let width = high - low;
            let part = match iteration % 3 {
                2 => R::ratio(1, 2),
                _ => values[0] / (values[0] - values[1]),
            };
            let guess = low + width * part;
            if !low.less(guess) || !guess.less(high) {
                break;
            }
            let rate = self.slip_rate(guess, s, length)?;
            if zero.less(rate) {
                (low, values[0]) = (guess, rate);
            } else {
                (high, values[1]) = (guess, rate);
            }
        }
        let found = self.balance(start + high)?;
        self.advance(found)?;
        self.stick_at_rest(s)
    }

    /// The length of the differences of a step. The witness has others.
    fn difference(&self, length: R) -> R {
        length * R::from_f64(if self.options.method == Method::Extrapolation { 3e-3 } else { 5e-3 })
    }

    /// The rate of a slip at a time after now, by differences that stay within `length`, for there is no corner of a load. They are central and
    /// extrapolated, at an end of it one-sided.
    fn slip_rate(&mut self, at: R, s: usize, length: R) -> Result<R, Refusal> {
        let (zero, start) = (R::ZERO, self.state.time);
        let until = if zero.less(at) { at } else { length };
        if let Some(slip) = self.curved(start + until, s)? {
            return Ok(slip.rates[usize::from(zero.less(at))]);
        }
        let levels = if R::ROUNDING < 1e-20 { 9 } else { 3 };
        let d = self.difference(length);
        let room = at.lesser(length - at);
        let is_central = (d * R::ratio(1, 64)).less(room);
        let sign = if is_central || at.less(length - at) { R::integer(1) } else { R::integer(-1) };
        let d = if is_central { d.lesser(room) } else { d } * sign;
        let here = if is_central { zero } else { self.slip_at(start + at, s)? };
        let mut slopes = Vec::new();
        for level in 0..levels {
            let h = d / R::integer(1 << level);
            let above = self.slip_at(start + at + h, s)?;
            slopes.push(match is_central {
                true => vec![(above - self.slip_at(start + at - h, s)?) / (h + h)],
                false => vec![(above - here) / h],
            });
        }
        Ok(at_zero(slopes, if is_central { 4 } else { 2 }).first().copied().unwrap_or(zero))
    }

    /// The slip of a friction along a curve until a time.
    fn curved(&mut self, time: R, s: usize) -> Result<Option<Slip<R>>, Refusal> {
        if !self.curving().contains(&s) {
            return Ok(None);
        }
        let slips = self.balance(time)?.curve.map_or_else(Vec::new, |curve| curve.slips);
        Ok(slips.into_iter().find(|slip| slip.of == s))
    }

    /// How far a friction has slipped at a time.
    fn slip_at(&mut self, time: R, s: usize) -> Result<R, Refusal> {
        if !self.state.time.less(time) {
            return Ok(R::ZERO);
        }
        let found = self.balance(time)?;
        Ok(self.slip_to(&found, s))
    }

    fn stick_at_rest(&mut self, s: usize) -> Result<(), Refusal> {
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let position = found.joints[self.mechanism.sliders[s].joint].position;
        let before = std::mem::replace(&mut self.modes.frictions[s], Mode::sticks(position));
        self.relay()?;
        // What moves as prescribed cannot stick: it slips the other way.
        let is_turned = self.is_carried(s);
        if let (true, Does::Slips(along)) = (is_turned, before.does) {
            self.modes.frictions[s] = Mode::slips(along.map(|x| -x));
            self.relay()?;
        }
        let time = self.state.time;
        let joint = self.mechanism.sliders[s].joint;
        let begun = self
            .solution
            .events
            .iter()
            .rposition(|event| event.connector == joint && event.what == What::Slips);
        let is_now = |event: &Event<R>| !event.time.less(time) && !time.less(event.time);
        match begun.filter(|begun| is_now(&self.solution.events[*begun])) {
            // A slip that ends as it begins is none.
            Some(begun) => drop(self.solution.events.remove(begun)),
            None if is_turned => self.event(s, What::Reverses, None),
            None => self.event(s, What::Sticks, None),
        }
        self.record(true)
    }

    /// An event of the path.
    fn meets_at_rest(&mut self, of: usize, cause: Cause) -> Result<(), Refusal> {
        if let Cause::Closes(side) = cause {
            let (joint, k) = (self.mechanism.stops[of].joint, self.mechanism.stops[of].component);
            if self.mechanism.is_given(joint, k, self.step) {
                return Err(Refusal::of(
                    self.joint_title(joint),
                    &format!("what is prescribed runs into its stop at time {}", self.state.time.to_f64()),
                    "prescribe less, or take the stop out",
                ));
            }
            self.modes.stops[of] = Touch::Closed(side);
            self.event_of_stop(of, What::Closes, None);
            self.relay()?;
            return self.record(true);
        }
        self.happens(of, cause)?;
        self.relay()
    }
}
