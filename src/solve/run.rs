//! From time to time: steps, events, modes.

use crate::Refusal;
use crate::equations::{Assembled, Beginnings, Instant, Layout, NoPivotAt, Owner, Solved, Trouble};
use crate::integrate::{Method, Rule, Slope, Tried};
use crate::mechanism::Mechanism;
use crate::mode::{Branches, Cause, Does, Mode, Switch};
use crate::number::{Number, larger, largest};
use crate::solution::{ConnectorFrame, Energies, Event, Frame, NodeFrame, Solution, What};
use crate::state::{DOFS, Pose, State, WORKS};
use pintle_kinematics::vector::Vector;
use pintle_model::evaluate::Model;
use pintle_scene::{Rotation, Scene};

/// What is asked of a solution.
#[derive(Clone, Debug)]
pub struct Options {
    /// How many digits are wanted.
    pub digits: usize,
    /// How it goes on in time.
    pub method: Method,
    /// When it ends; none is the end of the last step.
    pub until: Option<f64>,
    /// The times asked for, besides the beginning and the end.
    pub times: Vec<f64>,
    /// Where it begins.
    pub from: Option<pintle_scene::State>,
    /// The most steps.
    pub most_steps: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            digits: 14,
            method: Method::default(),
            until: None,
            times: Vec::new(),
            from: None,
            most_steps: 1_000_000,
        }
    }
}

/// Where a solution ended early.
#[derive(Clone, Debug)]
pub struct Ended<R> {
    /// What is known of it.
    pub solution: Solution<R>,
    /// When it ended.
    pub time: f64,
    /// Why.
    pub why: Refusal,
}

/// A solution in the making.
struct Run<'a, R: Number> {
    scene: &'a Scene,
    model: &'a Model,
    options: &'a Options,
    rule: Rule<R>,
    mechanism: Mechanism<R>,
    beginnings: Beginnings,
    step: usize,
    state: State<R>,
    modes: Vec<Mode<R>>,
    layout: Layout,
    kinetic: R,
    solution: Solution<R>,
    /// The length of the next step.
    h: f64,
}

/// Solves a scene: every step that takes time, from its initial state or the one given.
///
/// # Errors
/// What is not solved, before it begins; or where it ends early, with the solution so far.
pub fn solve<R: Number>(scene: &Scene, options: &Options) -> Result<Solution<R>, Box<Ended<R>>> {
    let nothing =
        |why: Refusal| Box::new(Ended { solution: Solution::empty(options.method), time: 0.0, why });
    let model = Model::compile(scene).map_err(|error| nothing(error.into()))?;
    let mut run = Run::new(scene, &model, options).map_err(nothing)?;
    match run.all() {
        Ok(()) => Ok(run.solution),
        Err(why) => Err(Box::new(Ended { time: run.state.time.to_f64(), solution: run.solution, why })),
    }
}

impl<R> Solution<R> {
    fn empty(method: Method) -> Self {
        Self {
            nodes: Vec::new(),
            connectors: Vec::new(),
            frames: Vec::new(),
            events: Vec::new(),
            lipschitz: 0.0,
            method,
            steps: 0,
            evaluations: 0,
            violation: 0.0,
        }
    }
}

impl<'a, R: Number> Run<'a, R> {
    fn new(scene: &'a Scene, model: &'a Model, options: &'a Options) -> Result<Self, Refusal> {
        let mechanism: Mechanism<R> = Mechanism::new(scene, model, 0)?;
        if mechanism.schedule.is_empty() {
            return Err(Refusal::of(
                &scene.name,
                "there is no step with a known length",
                "add *STEP, *DYNAMIC with its initial increment and length, *END STEP",
            ));
        }
        let zero = R::integer(0);
        let mut state = State {
            time: zero,
            poses: vec![Pose::at_rest(); mechanism.bodies.len()],
            rates: vec![[zero; DOFS]; mechanism.bodies.len()],
            branches: mechanism.joints.iter().map(|joint| joint.connector.initial_branch()).collect(),
            sums: vec![zero; WORKS + mechanism.sliders.len()],
        };
        if let Some(from) = &options.from {
            state.time = R::from_f64(from.time.unwrap_or(0.0));
            for (body, (pose, rates)) in
                mechanism.bodies.iter().zip(state.poses.iter_mut().zip(&mut state.rates))
            {
                let Some(motion) = from.nodes.get(&body.label) else { continue };
                let vector = match motion.rotation {
                    Rotation::Vector(vector) => vector,
                    Rotation::Quaternion(q) => pintle_kinematics::so3::log_quaternion(q),
                };
                *pose = Pose {
                    displacement: motion.displacement.map(R::from_f64),
                    vector: vector.map(R::from_f64),
                    rotation: pintle_kinematics::so3::turn(vector.map(R::from_f64)),
                    flow: R::from_f64(motion.flow),
                };
                let all =
                    motion.velocity.iter().chain(&motion.angular_velocity).chain([&motion.flow_velocity]);
                for (rate, x) in rates.iter_mut().zip(all) {
                    *rate = R::from_f64(*x);
                }
            }
        }
        let mut solution = Solution::empty(options.method);
        solution.nodes = mechanism.bodies.iter().map(|body| body.label).collect();
        solution.connectors =
            mechanism.joints.iter().map(|joint| (joint.label, joint.title.clone())).collect();
        let rule = Rule::new(options.method, options.digits);
        let mut run = Self {
            scene,
            model,
            options,
            rule,
            beginnings: Beginnings::default(),
            step: 0,
            modes: Vec::new(),
            layout: Layout::default(),
            kinetic: zero,
            state,
            solution,
            mechanism,
            h: 0.0,
        };
        if options.from.is_some() {
            run.follow_given();
        }
        Ok(run)
    }

    /// Takes the histories of connectors to a state that is given: the whole rotation is their increment.
    fn follow_given(&mut self) {
        let turned: Vec<Vector<R>> = self.state.poses.iter().map(|pose| pose.vector).collect();
        let instant = Instant { turned: &turned, ..Instant::of(&self.state, self.step, &turned) };
        if let Ok(found) = self.mechanism.assemble(&instant, &[], &self.beginnings) {
            self.state.branches = found.joints.iter().map(|now| now.branch).collect();
        }
    }

    fn all(&mut self) -> Result<(), Refusal> {
        let begin = self.state.time.to_f64();
        for step in 0..self.mechanism.schedule.len() {
            let Some(([from, to], is_dynamic)) = self.mechanism.schedule.span(step) else { break };
            if to <= begin && to > 0.0 {
                continue;
            }
            let to = self.options.until.map_or(to, |until| until.min(to));
            if to < from || to <= begin && begin > 0.0 {
                break;
            }
            if !is_dynamic {
                return Err(Refusal::of(
                    &format!("step {}", step + 1),
                    "a static step is not solved yet",
                    "use *DYNAMIC, with damping where rest is wanted",
                ));
            }
            if step > 0 {
                let held = std::mem::take(&mut self.mechanism.held);
                self.mechanism = Mechanism::new(self.scene, self.model, step)?;
                drop(held);
            }
            self.step = step;
            self.one(to)?;
        }
        Ok(())
    }

    fn say(&self, trouble: Trouble) -> Refusal {
        let time = self.state.time.to_f64();
        match trouble {
            Trouble::Unknown(what, why) => Refusal::of(&what, &why, "give it, or take it out"),
            Trouble::Singular(NoPivotAt::Freedom(dof)) => Refusal::of(
                &self.mechanism.freedom(dof),
                &format!("nothing determines how it accelerates at time {time}"),
                "give *MASS or *ROTARY INERTIA to its node, or hold it by *BOUNDARY",
            ),
            Trouble::Singular(NoPivotAt::Row(row)) => {
                let owner = self.rows().get(row).copied();
                let named =
                    owner.map_or_else(|| "a constraint".to_string(), |owner| self.mechanism.named(owner));
                Refusal::of(
                    &named,
                    &format!(
                        "its force is not determined at time {time}: the position is singular, or its nodes have no inertia"
                    ),
                    "give its nodes *MASS and *ROTARY INERTIA; pintle audit names constraints that repeat each other",
                )
            }
            Trouble::Singular(NoPivotAt::Slider(_)) | Trouble::NotFound => Refusal::of(
                "friction",
                &format!("no friction forces were found at time {time} (κ = {:.3})", self.solution.lipschitz),
                "a coefficient so large that the mechanism jams has no solution, or several",
            ),
            Trouble::NotFinite => Refusal::of(
                "the solution",
                &format!("a number overflows at time {time}"),
                "check masses and stiffnesses",
            ),
        }
    }

    fn rows(&self) -> Vec<Owner> {
        let still = vec![[R::integer(0); 3]; self.state.poses.len()];
        let instant = Instant::of(&self.state, self.step, &still);
        let found = self.mechanism.assemble(&instant, &self.modes, &self.beginnings);
        found.map_or(Vec::new(), |found| found.rows.iter().map(|row| row.owner).collect())
    }

    fn assembled(&self, modes: &[Mode<R>]) -> Result<Assembled<R>, Trouble> {
        let still = vec![[R::integer(0); 3]; self.state.poses.len()];
        self.mechanism.assemble(&Instant::of(&self.state, self.step, &still), modes, &self.beginnings)
    }

    /// One step of the scene, to a time.
    fn one(&mut self, to: f64) -> Result<(), Refusal> {
        self.begin()?;
        let mut stops: Vec<(f64, bool)> = vec![(to, true)];
        stops.extend(self.options.times.iter().map(|time| (*time, true)));
        stops.extend(self.breaks().into_iter().map(|time| (time, false)));
        let now = self.state.time.to_f64();
        stops.retain(|(time, _)| *time > now && *time <= to);
        stops.sort_by(|one, two| one.0.total_cmp(&two.0).then(two.1.cmp(&one.1)));
        stops.dedup_by_key(|(time, _)| *time);
        if self.solution.frames.is_empty() {
            self.record(false)?;
        }
        if self.h <= 0.0 {
            self.h = (to - now) * 1e-3;
        }
        let breaks = self.breaks();
        for (time, is_frame) in stops {
            self.reach(time)?;
            if is_frame {
                self.record(false)?;
            }
            if breaks.contains(&time) && time < to {
                self.pass()?;
            }
        }
        Ok(())
    }

    /// Goes past a time at which something that acts is not smooth: rates that are prescribed may jump there, and so may loads.
    fn pass(&mut self) -> Result<(), Refusal> {
        let time = self.state.time;
        self.state.time =
            time + larger(time.magnitude(), R::from_f64(1e-300)) * R::from_f64(4.0 * R::ROUNDING);
        self.project()?;
        let open: Vec<usize> = (0..self.modes.len()).filter(|s| self.modes[*s].is_stuck()).collect();
        self.choose(&open, None)
    }

    /// The times at which something that acts is not smooth.
    fn breaks(&self) -> Vec<f64> {
        let mechanism = &self.mechanism;
        let mut found = Vec::new();
        let joints = mechanism.joints.iter().flat_map(|joint| {
            let drives = &joint.behavior.drives;
            drives.motions.iter().chain(&drives.loads).flatten()
        });
        let nodes = mechanism.bodies.iter().flat_map(|body| body.loads.iter().map(|(_, drive)| drive));
        let bounds = mechanism.bounds.iter().map(|bound| &bound.drive);
        let gravities = mechanism.gravities.iter().flatten().map(|(_, drive)| drive);
        for drive in joints.chain(nodes).chain(bounds).chain(gravities) {
            found.extend(drive.breaks(self.step));
        }
        found
    }

    /// The beginning of a step: where things are, what sticks, rates that fit.
    fn begin(&mut self) -> Result<(), Refusal> {
        let none: Vec<Mode<R>> = Vec::new();
        let found = self.assembled(&none).map_err(|trouble| self.say(trouble))?;
        let joints = found.joints.iter().map(|now| now.displacement.map(Number::to_f64)).collect();
        let nodes = self.state.poses.iter().map(|pose| {
            let [a, b, c] = pose.displacement.map(Number::to_f64);
            let [d, e, f] = pose.vector.map(Number::to_f64);
            [a, b, c, d, e, f]
        });
        self.beginnings.nodes.resize(self.step, Vec::new());
        self.beginnings.nodes.push(nodes.collect());
        self.beginnings.joints.resize(self.step, Vec::new());
        self.beginnings.joints.push(joints);
        // Rates that fit, with nothing stuck; then what stands may stick.
        self.modes = none;
        let found = self.assembled(&[]).map_err(|trouble| self.say(trouble))?;
        self.layout = Layout::new(&self.mechanism, &found, &[])?;
        self.project()?;
        let found = self.assembled(&[]).map_err(|trouble| self.say(trouble))?;
        let speed = self.speed();
        let mut open = Vec::new();
        self.modes = self
            .mechanism
            .sliders
            .iter()
            .enumerate()
            .map(|(s, slider)| {
                let now = &found.joints[slider.joint];
                let mut along = [R::integer(0); 6];
                for (k, radius) in &slider.components {
                    along[*k] = R::from_f64(*radius) * now.velocity[*k];
                }
                let size = crate::slide::length(&along);
                if size.to_f64() <= 1e-12 * speed {
                    open.push(s);
                    return Mode::sticks(now.position);
                }
                Mode::slips(along.map(|x| x / size))
            })
            .collect();
        self.choose(&open, None)?;
        if self.solution.frames.is_empty() {
            let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
            self.kinetic = found.kinetic();
        }
        Ok(())
    }

    /// The largest speed, lengths by the size of the model.
    fn speed(&self) -> f64 {
        let length = self.mechanism.length;
        let all = self.state.rates.iter().flat_map(|rates| {
            rates.iter().enumerate().map(move |(k, x)| x.to_f64().abs() / if k < 3 { length } else { 1.0 })
        });
        all.fold(1e-12, f64::max)
    }

    /// The equations that count in a mode, and its solution.
    fn instant(&mut self, modes: &[Mode<R>]) -> Result<(Assembled<R>, Layout, Solved<R>), Refusal> {
        self.solution.evaluations += 1;
        let found = self.assembled(modes).map_err(|trouble| self.say(trouble))?;
        let layout = Layout::new(&self.mechanism, &found, modes)?;
        let solved = found.solve(&self.mechanism, &layout, modes).map_err(|trouble| self.say(trouble))?;
        Ok((found, layout, solved))
    }

    /// What frictions do that have no slip rate: all that is consistent is tried, the neighbours of now first. `stopping` has just come to
    /// rest, from the direction that its mode has.
    fn choose(&mut self, open: &[usize], stopping: Option<usize>) -> Result<(), Refusal> {
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
                let size = crate::slide::length(&along);
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
        for number in 0..combinations {
            let mut modes = all_stuck.clone();
            let mut rest = number;
            for (i, s) in open.iter().enumerate().take(ALL) {
                match rest % 3 {
                    0 => {}
                    1 => modes[*s] = Mode::slips(directions[i]),
                    _ => modes[*s] = Mode::slips(directions[i].map(|x| -x)),
                }
                rest /= 3;
            }
            let Ok((found, layout, solved)) = self.instant(&modes) else { continue };
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

    fn event(&mut self, slider: usize, what: What, margin: Option<f64>, time: R) {
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

    fn title(&self, slider: usize) -> &str {
        let joint = self.mechanism.sliders.get(slider).and_then(|of| self.mechanism.joints.get(of.joint));
        joint.map_or("", |joint| joint.title.as_str())
    }

    fn told(&self, modes: &[Mode<R>], open: &[usize]) -> String {
        let each = open.iter().map(|s| match &modes[*s].does {
            Does::Sticks(_) => format!("{} sticks", self.title(*s)),
            Does::Slips(along) => {
                let sum: f64 = along.iter().map(|x| x.to_f64()).sum();
                format!("{} slips {}", self.title(*s), if sum < 0.0 { "backwards" } else { "forwards" })
            }
        });
        each.collect::<Vec<_>>().join(" and ")
    }

    /// By how much the open frictions are consistent with a mode: the least of them, relative; negative where one is not.
    fn margin(
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
    fn settle(
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
        self.modes = modes;
        self.layout = layout;
        self.branch(solved, None);
        self.project()
    }

    /// Fixes the branches of frictions to those of a solution; that of a magnitude which has just passed zero is open.
    fn branch(&mut self, solved: &Solved<R>, _turned: Option<usize>) {
        for (mode, limit) in self.modes.iter_mut().zip(&solved.limits) {
            mode.branches = if mode.is_stuck() { Branches::none() } else { limit.branches.clone() };
        }
    }

    /// Which rotations of a node are unknown.
    fn turns(&self, node: usize) -> [bool; 3] {
        [3, 4, 5].map(|k| self.layout.place.get(DOFS * node + k).is_some_and(Option::is_some))
    }

    /// The state after the unknowns have moved.
    fn unpacked(
        &self,
        base: &State<R>,
        y: &[R],
        with_vectors: bool,
    ) -> (Vec<Pose<R>>, Vec<[R; DOFS]>, Vec<Vector<R>>) {
        let zero = R::integer(0);
        let n = self.layout.columns.len();
        let mut moved = vec![[zero; DOFS]; base.poses.len()];
        let mut rates = base.rates.clone();
        for (i, dof) in self.layout.columns.iter().enumerate() {
            moved[dof / DOFS][dof % DOFS] = y[i];
            rates[dof / DOFS][dof % DOFS] = y[n + i];
        }
        let poses = base.poses.iter().zip(&moved).enumerate();
        let poses = poses.map(|(node, (pose, by))| pose.moved(by, self.turns(node), with_vectors)).collect();
        let turned = moved.iter().map(|by| [by[3], by[4], by[5]]).collect();
        (poses, rates, turned)
    }

    /// ẏ.
    fn flow(&self, base: &State<R>, time: R, y: &[R]) -> Result<(Slope<R>, Solved<R>), Trouble> {
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
        let found = self.mechanism.assemble(&instant, &self.modes, &self.beginnings)?;
        let solved = found.solve(&self.mechanism, &self.layout, &self.modes)?;
        let mut slope = Slope { rates: Vec::with_capacity(y.len()), switches: solved.switches.clone() };
        let mut turning: Vec<Option<Vector<R>>> = vec![None; poses.len()];
        for dof in &self.layout.columns {
            let (node, k) = (dof / DOFS, dof % DOFS);
            slope.rates.push(match k {
                3..6 => {
                    let all = turning[node].get_or_insert_with(|| {
                        let spin = [rates[node][3], rates[node][4], rates[node][5]];
                        let back = pintle_kinematics::so3::inverse_left_jacobian(turned[node]);
                        pintle_kinematics::vector::apply(&back, spin)
                    });
                    all[k - 3]
                }
                _ => rates[node][k],
            });
        }
        for dof in &self.layout.columns {
            slope.rates.push(solved.accelerations[dof / DOFS][dof % DOFS]);
        }
        slope.rates.extend(&solved.sums);
        Ok((slope, solved))
    }

    fn packed(&self) -> Vec<R> {
        let zero = R::integer(0);
        let columns = &self.layout.columns;
        let mut y = vec![zero; columns.len()];
        y.extend(columns.iter().map(|dof| self.state.rates[dof / DOFS][dof % DOFS]));
        y.extend(&self.state.sums);
        y
    }

    /// The largest error of each number in a step of length h.
    fn allowed(&self, y: &[R], h: f64) -> Vec<R> {
        let tolerance = 10.0_f64.powi(-(self.options.digits as i32));
        let n = self.layout.columns.len();
        let length = self.mechanism.length;
        let size = |dof: usize| if dof % DOFS < 3 || dof % DOFS == 6 { length } else { 1.0 };
        let energy = larger(self.kinetic.magnitude(), largest(self.state.sums.iter().take(WORKS).copied()));
        let energy = energy.to_f64().max(1e-6 * self.work());
        let speed = self.speed();
        let each = (0..y.len()).map(|i| {
            let scale = if i < n {
                size(self.layout.columns[i])
            } else if i < 2 * n {
                let size = size(self.layout.columns[i - n]);
                (size / h).min(size * speed * 10.0).max(1e-3 * size * speed)
            } else if i < 2 * n + WORKS {
                energy
            } else {
                length
            };
            R::from_f64(tolerance * scale)
        });
        let mut all: Vec<R> = each.collect();
        all.push(R::from_f64(tolerance));
        all
    }

    /// A size of works: masses, speeds and lengths by their units.
    fn work(&self) -> f64 {
        let masses = self.mechanism.bodies.iter().map(|body| body.mass.to_f64().abs());
        masses.fold(1.0, f64::max) * self.mechanism.length.powi(2)
    }

    fn tried(&mut self, base: &State<R>, y: &[R], slope: &Slope<R>, h: R) -> Result<Tried<R>, Trouble> {
        let allowed = self.allowed(y, h.to_f64());
        let mut evaluations = 0;
        let mut flow = |time: R, y: &[R]| {
            evaluations += 1;
            self.flow(base, time, y).map(|(slope, _)| slope)
        };
        let tried = self.rule.step(&mut flow, (base.time, y, slope), h, &allowed);
        self.solution.evaluations += evaluations;
        tried
    }

    /// Goes on to a time, over all events before it.
    fn reach(&mut self, to: f64) -> Result<(), Refusal> {
        let goal = R::from_f64(to);
        let least = (to - self.state.time.to_f64()).abs().max(to.abs()) * 1e3 * R::ROUNDING;
        let mut halvings = 0;
        while self.state.time.less(goal) {
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
            let left = goal - self.state.time;
            let is_last = !R::from_f64(self.h).less(left);
            let h = if is_last { left } else { R::from_f64(self.h) };
            let base = self.state.clone();
            let y = self.packed();
            let (slope, solved) = self.flow(&base, base.time, &y).map_err(|trouble| self.say(trouble))?;
            self.keep_branches(&solved);
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
                        return Err(self.say(trouble));
                    }
                    continue;
                }
            };
            halvings = 0;
            let ended = self.switches_at(&base, base.time + h, &tried.end)?;
            let crossing = crossing(&slope.switches, &tried.inner, &ended);
            match crossing {
                None => {
                    let grown = h.to_f64() * tried.growth;
                    self.h = if is_last { grown.max(self.h) } else { grown };
                    let time = if is_last { goal } else { base.time + h };
                    self.commit(&base, time, &tried.end)?;
                }
                Some(Crossing::Inside(part)) => {
                    // Back before the end of the step: what is negative within it must be so at its end.
                    self.h = h.to_f64() * part;
                    if self.h < least {
                        return Err(self.stuck_in_time());
                    }
                }
                Some(Crossing::AtEnd) => {
                    let usual = self.h;
                    self.locate(h, &slope.switches)?;
                    self.h = usual.min(h.to_f64());
                }
            }
        }
        Ok(())
    }

    fn stuck_in_time(&self) -> Refusal {
        Refusal::of(
            "the solution",
            &format!("steps become too short at time {}", self.state.time.to_f64()),
            "a singular position is near, or something rings",
        )
    }

    /// Branches of magnitudes that were zero and are not any more.
    fn keep_branches(&mut self, solved: &Solved<R>) {
        for (mode, limit) in self.modes.iter_mut().zip(&solved.limits) {
            if mode.is_stuck() {
                continue;
            }
            if mode.branches.magnitudes.len() != limit.branches.magnitudes.len() {
                mode.branches = limit.branches.clone();
                continue;
            }
            for (known, now) in mode.branches.magnitudes.iter_mut().zip(&limit.branches.magnitudes) {
                *known = now.clone();
            }
            if mode.branches.normal.is_none() {
                mode.branches.normal = limit.branches.normal;
            }
        }
    }

    fn switches_at(&mut self, base: &State<R>, time: R, y: &[R]) -> Result<Vec<Switch<R>>, Refusal> {
        self.solution.evaluations += 1;
        let found = self.flow(base, time, y).map_err(|trouble| self.say(trouble))?;
        Ok(found.0.switches)
    }

    /// Finds the first event within h, by whole steps: the state goes on to it.
    fn locate(&mut self, h: R, first: &[Switch<R>]) -> Result<(), Refusal> {
        let zero = R::integer(0);
        let mut low = (zero, first.to_vec());
        let mut high = h;
        let mut which: Option<usize> = None;
        let mut weight = R::integer(1);
        let mut high_value: Option<R> = None;
        let start = self.state.time;
        let resolution = larger(start.magnitude(), h) * R::from_f64(4.0 * R::ROUNDING);
        for iteration in 0..400 {
            let base = self.state.clone();
            let y = self.packed();
            let (slope, _) = self.flow(&base, base.time, &y).map_err(|trouble| self.say(trouble))?;
            let passed = base.time - start;
            // Where the switch that is nearest to its end would vanish.
            let ahead = high - passed;
            let guess = match (which, high_value) {
                (Some(index), Some(below)) if iteration % 4 != 3 => {
                    let above = low.1.get(index).map_or(zero, |switch| switch.value);
                    let span = above - below * weight;
                    let part = if zero.less(span) { above / span } else { R::ratio(1, 2) };
                    ahead * part
                }
                (None, _) => ahead,
                _ => ahead * R::ratio(1, 2),
            };
            let is_small = !resolution.less(ahead);
            let guess = if is_small { ahead } else { guess };
            let guess =
                if guess.less(resolution * R::ratio(1, 4)) { resolution * R::ratio(1, 4) } else { guess };
            let tried = self.tried(&base, &y, &slope, guess).map_err(|trouble| self.say(trouble))?;
            if tried.error > 1.0 {
                return Err(self.stuck_in_time());
            }
            let ended = self.switches_at(&base, base.time + guess, &tried.end)?;
            // The one that is crossed first: by its value before and after.
            let part = |(now, before): (&Switch<R>, &Switch<R>)| {
                (before.value / (before.value - now.value)).to_f64()
            };
            let pairs = ended.iter().zip(&low.1).enumerate();
            let crossed = pairs.filter(|(_, (now, before))| now.value.less(zero) && !before.value.less(zero));
            let earliest = crossed.min_by(|(_, one), (_, two)| part(*one).total_cmp(&part(*two)));
            match earliest.map(|(index, (now, _))| (index, *now)) {
                None => {
                    // On this side: the state goes on to it.
                    self.commit(&base, base.time + guess, &tried.end)?;
                    low = (base.time + guess - start, ended.clone());
                    weight = R::ratio(1, 2);
                    let vanishes = which.and_then(|index| ended.get(index)).is_some_and(|now| {
                        let rounded = now.scale * R::from_f64(16.0 * R::ROUNDING);
                        now.cause != Cause::Stops && !rounded.less(now.value.magnitude())
                    });
                    if vanishes || !(resolution).less(high - low.0) {
                        let Some(switch) = which.and_then(|index| ended.get(index)) else { return Ok(()) };
                        return self.happens(switch.slider, switch.cause);
                    }
                }
                Some((index, switch)) => {
                    which = Some(index);
                    high = passed + guess;
                    high_value = Some(switch.value);
                    if !resolution.less(guess) {
                        self.commit(&base, base.time + guess, &tried.end)?;
                        return self.happens(switch.slider, switch.cause);
                    }
                    weight = R::integer(1);
                }
            }
        }
        Err(self.stuck_in_time())
    }

    /// An event at this state.
    fn happens(&mut self, slider: usize, cause: Cause) -> Result<(), Refusal> {
        let zero = R::integer(0);
        match cause {
            Cause::Turns | Cause::Caps => {
                let modes = self.modes.clone();
                let mut open = modes;
                if let Some(mode) = open.get_mut(slider) {
                    let capped = mode.branches.is_capped;
                    mode.branches = Branches::none();
                    mode.branches.is_capped = if cause == Cause::Caps { !capped } else { capped };
                }
                self.modes = open;
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
                let size = crate::slide::length(&along);
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
                        let size = crate::slide::length(&along);
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

    /// Goes on to a state, and back to its constraints.
    fn commit(&mut self, base: &State<R>, time: R, y: &[R]) -> Result<(), Refusal> {
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
        self.state = next;
        self.project()
    }

    /// Brings positions and rates back to the equations.
    fn project(&mut self) -> Result<(), Refusal> {
        let zero = R::integer(0);
        let small = R::from_f64(4.0 * R::ROUNDING);
        let length = R::from_f64(self.mechanism.length);
        for iteration in 0..12 {
            let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
            let size = |owner: Owner| match owner {
                Owner::Joint(_, k) if k >= 3 => R::integer(1),
                Owner::Mpc(_, row) if (3..6).contains(&row) => R::integer(1),
                _ => length,
            };
            let gap = self.layout.kept.iter().fold(zero, |most, index| {
                let row = &found.rows[*index];
                let gap = row.residual.unwrap_or(zero).magnitude() / size(row.owner);
                larger(most, gap)
            });
            if !small.less(gap) {
                break;
            }
            if iteration == 11 {
                break;
            }
            let change =
                found.correction(&self.layout, |row| row.residual).map_err(|trouble| self.say(trouble))?;
            let mut turned = vec![[zero; 3]; self.state.poses.len()];
            for node in 0..self.state.poses.len() {
                let mut by = [zero; DOFS];
                by.copy_from_slice(&change[DOFS * node..DOFS * (node + 1)]);
                let turns = self.turns(node);
                if by.iter().any(|x| zero.less(x.magnitude())) {
                    self.state.poses[node] = self.state.poses[node].moved(&by, turns, true);
                }
                turned[node] = [by[3], by[4], by[5]];
            }
            let instant = Instant { turned: &turned, ..Instant::of(&self.state, self.step, &turned) };
            let found = self
                .mechanism
                .assemble(&instant, &self.modes, &self.beginnings)
                .map_err(|trouble| self.say(trouble))?;
            self.state.branches = found.joints.iter().map(|now| now.branch).collect();
            if !R::from_f64(1e3 * R::ROUNDING).less(gap) {
                break;
            }
        }
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let change = found.correction(&self.layout, |row| row.rate).map_err(|trouble| self.say(trouble))?;
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
        Ok(())
    }

    /// Keeps this state as a frame.
    fn record(&mut self, is_event: bool) -> Result<(), Refusal> {
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let solved =
            found.solve(&self.mechanism, &self.layout, &self.modes).map_err(|trouble| self.say(trouble))?;
        for row in &found.rows {
            let scale = match row.owner {
                Owner::Joint(_, k) if k >= 3 => 1.0,
                Owner::Mpc(_, row) if (3..6).contains(&row) => 1.0,
                _ => self.mechanism.length,
            };
            let gap = row.residual.map_or(0.0, |gap| gap.to_f64().abs() / scale);
            self.solution.violation = self.solution.violation.max(gap);
        }
        let six = |all: &[R; DOFS]| [all[0], all[1], all[2], all[3], all[4], all[5]];
        let nodes = self.state.poses.iter().enumerate().map(|(node, pose)| NodeFrame {
            displacement: pose.displacement,
            rotation: pose.vector,
            velocity: six(&self.state.rates[node]),
            acceleration: six(&solved.accelerations[node]),
        });
        let connectors = self.mechanism.joints.iter().enumerate().map(|(index, joint)| {
            let now = &found.joints[index];
            let of = self.mechanism.sliders.iter().zip(&self.modes);
            ConnectorFrame {
                position: now.position,
                displacement: now.displacement,
                velocity: now.velocity,
                total: solved.total[index],
                friction: solved.friction[index],
                wanted: joint.wanted,
                sticks: of
                    .filter(|(slider, _)| slider.joint == index)
                    .map(|(_, mode)| mode.is_stuck())
                    .collect(),
            }
        });
        let [external, dissipated, stored] = [0, 1, 2].map(|i| self.state.sums[i]);
        let kinetic = found.kinetic();
        let balance = kinetic + stored + dissipated - external - self.kinetic;
        let frame = Frame {
            time: self.state.time,
            nodes: nodes.collect(),
            connectors: connectors.collect(),
            energies: Energies { kinetic, external, dissipated, stored, balance },
            is_event,
        };
        self.solution.frames.push(frame);
        Ok(())
    }
}

/// Margins below this count as ties.
const TIE: f64 = 1e-9;

/// Where a step passed the end of a mode.
enum Crossing {
    /// Within it, at this part.
    Inside(f64),
    /// At its end.
    AtEnd,
}

/// Whether a switch became negative.
fn crossing<R: Number>(
    first: &[Switch<R>],
    inner: &[(f64, Vec<Switch<R>>)],
    last: &[Switch<R>],
) -> Option<Crossing> {
    let zero = R::integer(0);
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
    found.map(|(part, _)| Crossing::Inside(*part))
}
