//! From time to time: steps, events, modes.

use crate::fault::{Fault, has};
use crate::motion::equations::Solved;
use crate::motion::linear::Newton;
use crate::motion::mechanism::{Hold, Mechanism};
use crate::motion::mode::{Branches, Cause, Does, Mode, Modes, Side, Switch, TIE, Touch};
use crate::motion::rows::{Assembled, Beginnings, Instant, Layout, NoPivotAt, Owner, Trouble};
use crate::motion::state::{DOFS, Pose, State, WORKS};
use crate::number::{Number, larger, largest};
use crate::refusal::Refusal;
use crate::time::integrate::{Method, Rule, Stages, Tableau};
use crate::time::keep::{Keeping, Kept};
use crate::time::solution::{ConnectorFrame, Energies, Frame, NodeFrame, Solution};
use crate::time::step::Quiet;
use pintle_kinematics::connector::StopStatus;
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::sub;
use pintle_model::behavior::friction::StickStiffness;
use pintle_model::evaluate::Model;
use pintle_scene::{Label, Rotation, Scene};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// What stick is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stick {
    /// What sticks stands still.
    #[default]
    Rigid,
    /// A spring of the stick stiffness K holds it, as in finite-element programs. K is `STICK STIFFNESS`, or the limit at the beginning over
    /// the elastic slip. Slip begins where P reaches μ F_N. It ends where its plastic part n·v − (μ F_N)˙/K does.
    Elastic,
}

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
    /// What stick is.
    pub stick: Stick,
    /// The most steps.
    pub most_steps: usize,
    /// Which of several runs that differ by their steps and rounding alone; 0 is the run itself.
    pub trial: u8,
    /// The size of lengths; none is that of the mechanism, see [`Solution::length`].
    pub length: Option<f64>,
    /// Where the time is kept that has been reached, as the bits of a double: for those who wait.
    pub reached: Option<Arc<AtomicU64>>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            digits: 14,
            method: Method::default(),
            until: None,
            times: Vec::new(),
            from: None,
            stick: Stick::default(),
            most_steps: 1_000_000,
            trial: 0,
            length: None,
            reached: None,
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
pub(crate) struct Run<'a, R: Number> {
    pub(crate) scene: &'a Scene,
    pub(crate) model: &'a Model,
    pub(crate) options: &'a Options,
    pub(crate) rule: Rule<R>,
    /// That of static slips along curves.
    pub(crate) radau: Option<Tableau<R>>,
    /// What static equilibria are found by.
    pub(crate) newton: Option<Newton<R>>,
    pub(crate) mechanism: Mechanism<R>,
    pub(crate) beginnings: Beginnings,
    pub(crate) step: usize,
    pub(crate) state: State<R>,
    pub(crate) modes: Modes<R>,
    pub(crate) layout: Layout,
    pub(crate) kinetic: R,
    /// What springs hold at the state that is gone on from.
    continued: R,
    pub(crate) solution: Solution<R>,
    /// The length of the next step.
    pub(crate) h: f64,
    /// The largest speed until now, lengths by the size of the model.
    pub(crate) fastest: f64,
    /// Whether the mode has just begun.
    pub(crate) is_new: bool,
    /// Whether the step is done again, in which a magnitude grew from zero.
    pub(crate) has_grown: bool,
    /// Steps since the last event, and whether motion has been found to be stiff.
    pub(crate) quiet: Quiet,
    /// The limits of frictions as the step began, where there are no others.
    pub(crate) limits: Vec<R>,
    /// The stages of the last step.
    pub(crate) stages: Option<Stages<R>>,
    /// The energy in the spring of each friction as slip began, where stick is elastic.
    pub(crate) stretched: Vec<R>,
    /// How sharply what happens now is met: the margin of its events.
    pub(crate) crossing: Option<f64>,
    /// Whether the step is static.
    pub(crate) is_still: bool,
    /// Whether the velocities at the beginning have been given.
    pub(crate) is_launched: bool,
    /// When this step of the scene began.
    pub(crate) began: f64,
    /// Whether the step goes on in its middle.
    pub(crate) is_resumed: bool,
    /// Where the run is kept.
    pub(crate) keeping: Option<Keeping<'a, R>>,
}

/// Solves a scene: every step that takes time, from its initial state or the one given.
///
/// # Errors
/// What is not solved, before it begins; or where it ends early, with the solution so far.
pub fn solve<R: Solvable>(scene: &Scene, options: &Options) -> Result<Solution<R>, Box<Ended<R>>> {
    R::solve(scene, options, None, None)
}

/// The same, kept as it goes, and from where it was kept: bit for bit as if it had not been interrupted.
///
/// # Errors
/// Those of [`solve`].
pub fn solve_keeping<R: Solvable>(
    scene: &Scene,
    options: &Options,
    from: Option<Kept<R>>,
    keeping: Option<Keeping<'_, R>>,
) -> Result<Solution<R>, Box<Ended<R>>> {
    R::solve(scene, options, from, keeping)
}

/// The numbers of which this crate holds the solver's code, so that no crate that calls it compiles it again.
pub trait Solvable: Number {
    /// [`solve_keeping`] on these numbers.
    ///
    /// # Errors
    /// As of [`solve`].
    fn solve(
        scene: &Scene,
        options: &Options,
        from: Option<Kept<Self>>,
        keeping: Option<Keeping<'_, Self>>,
    ) -> Result<Solution<Self>, Box<Ended<Self>>>;
}

macro_rules! solvable {
    ($($number:ty),+) => { $(
        impl Solvable for $number {
            #[inline(never)]
            fn solve(
                scene: &Scene,
                options: &Options,
                from: Option<Kept<Self>>,
                keeping: Option<Keeping<'_, Self>>,
            ) -> Result<Solution<Self>, Box<Ended<Self>>> {
                solve_on(scene, options, from, keeping)
            }
        }
    )+ };
}

solvable! { f64, Wide }

fn solve_on<R: Number>(
    scene: &Scene,
    options: &Options,
    from: Option<Kept<R>>,
    keeping: Option<Keeping<'_, R>>,
) -> Result<Solution<R>, Box<Ended<R>>> {
    let nothing =
        |why: Refusal| Box::new(Ended { solution: Solution::empty(options.method), time: 0.0, why });
    let model = Model::compile(scene).map_err(|error| nothing(error.into()))?;
    let mut run = Run::new(scene, &model, options).map_err(nothing)?;
    run.keeping = keeping;
    if let Some(kept) = from
        && run.resume(kept)
    {
        return Ok(run.solution);
    }
    match run.all() {
        Ok(()) => Ok(run.solution),
        Err(why) => Err(Box::new(Ended { time: run.state.time.to_f64(), solution: run.solution, why })),
    }
}

/// The size of lengths: that of the model. Where all its nodes coincide: how far a node goes, and no less than the
/// largest radius of gyration.
fn size(scene: &Scene, model: &Model, options: &Options, gyration: f64) -> f64 {
    /// How many digits a trial has.
    const DIGITS: usize = 4;
    /// How many times less than the size of its trial a motion may be, to be known by it.
    const KNOWN: f64 = 1e3;
    /// How often the size is sought again, each time by so much less: lengths may be metres in a model of micrometres.
    const TRIALS: usize = 4;
    if let Some(length) = options.length.or(model.extent) {
        return length;
    }
    let is_body = gyration > 0.0;
    let mut length = if is_body { gyration } else { 1.0 };
    for _ in 0..TRIALS {
        let options = Options {
            digits: DIGITS,
            method: Method::Extrapolation,
            times: Vec::new(),
            length: Some(length),
            trial: 0,
            reached: None,
            ..options.clone()
        };
        let goes = match solve::<f64>(scene, &options) {
            Ok(solution) => solution.farthest,
            Err(ended) => ended.solution.farthest,
        };
        if !(goes > f64::MIN_POSITIVE && goes.is_finite()) {
            break;
        }
        if is_body {
            // To a power of two: the digits of a trial are not those of a size.
            return length.max(goes.log2().ceil().exp2());
        }
        let is_known = goes * KNOWN > length;
        length = goes;
        if is_known {
            break;
        }
    }
    length
}

impl<R> Solution<R> {
    fn empty(method: Method) -> Self {
        Self {
            nodes: Vec::new(),
            connectors: Vec::new(),
            frames: Vec::new(),
            events: Vec::new(),
            ties: Vec::new(),
            lipschitz: 0.0,
            method,
            steps: 0,
            evaluations: 0,
            violation: 0.0,
            changed: 0.0,
            stored_is_open: false,
            liveliest: 0.0,
            farthest: 0.0,
            length: 1.0,
        }
    }
}

/// Refuses what would be the solution of another mechanism: constraints that were not read, and elements of other types on the same nodes.
fn refuse_unread(scene: &Scene) -> Result<(), Refusal> {
    let unread = scene.unread_constraints();
    if !unread.is_empty() {
        let all: Vec<&str> = unread.keys().map(String::as_str).collect();
        let why = format!("{}: nodes are constrained by what is not read", all.join(", "));
        return Err(Refusal::of(
            &scene.name,
            &why,
            "write them as *MPC, *EQUATION, *COUPLING or *RIGID BODY",
        ));
    }
    let types: Vec<&str> = scene.skipped.element_types.keys().map(String::as_str).collect();
    if !types.is_empty() && scene.skipped.nodes.as_ref().is_none_or(|nodes| !nodes.is_empty()) {
        let why = format!(
            "elements of type {} act on nodes of its connectors, and are not solved",
            types.join(", ")
        );
        return Err(Refusal::of(
            &scene.name,
            &why,
            "take them out, or put springs, dashpots, masses or rigid bodies in their place",
        ));
    }
    Ok(())
}

impl<'a, R: Number> Run<'a, R> {
    pub(crate) fn new(scene: &'a Scene, model: &'a Model, options: &'a Options) -> Result<Self, Refusal> {
        refuse_unread(scene)?;
        let mut mechanism: Mechanism<R> = Mechanism::new(scene, model, 0)?;
        if mechanism.schedule.is_empty() {
            return Err(Refusal::of(
                &scene.name,
                "its first step has no known length",
                "begin with *STEP, *DYNAMIC or *STATIC with its initial increment and length, *END STEP",
            ));
        }
        mechanism.length = size(scene, model, options, mechanism.gyration());
        let zero = R::ZERO;
        let mut state = State {
            time: zero,
            poses: vec![Pose::at_rest(); mechanism.bodies.len()],
            rates: vec![[zero; DOFS]; mechanism.bodies.len()],
            branches: mechanism.joints.iter().map(|joint| joint.connector.initial_branch()).collect(),
            sums: vec![
                zero;
                WORKS
                    + mechanism.sliders.len()
                    + mechanism.turning().map(|(_, all)| all.len()).sum::<usize>()
            ],
        };
        let initial = state.clone();
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
                    rotation: pintle_kinematics::so3::exp(vector.map(R::from_f64)),
                    flow: R::from_f64(motion.flow),
                };
                let all =
                    motion.velocity.iter().chain(&motion.angular_velocity).chain([&motion.flow_velocity]);
                for (rate, x) in rates.iter_mut().zip(all) {
                    *rate = R::from_f64(*x);
                }
            }
        }
        let told = state.poses.clone();
        mechanism.bring(&mut state.poses, &mut state.rates);
        let mut solution = Solution::empty(options.method);
        // What a state says of a node that is carried counts as a violation, as far as it is elsewhere.
        let is_told =
            |label: &Label| options.from.as_ref().is_some_and(|from| from.nodes.contains_key(label));
        let all = mechanism.bodies.iter().zip(told.iter().zip(&state.poses));
        for (_, (told, now)) in all.filter(|(body, _)| is_told(&body.label)) {
            let moved = norm(sub(told.displacement, now.displacement)).to_f64() / mechanism.length;
            let pairs = told.rotation.iter().flatten().zip(now.rotation.iter().flatten());
            let turned = largest(pairs.map(|(told, now)| *told - *now)).to_f64();
            solution.violation = solution.violation.max(moved).max(turned);
        }
        solution.length = mechanism.length;
        solution.nodes = mechanism.bodies.iter().map(|body| body.label).collect();
        solution.connectors =
            mechanism.joints.iter().map(|joint| (joint.label, joint.title.clone())).collect();
        let rule = Rule::new(options.method, options.digits);
        let mut run = Self {
            scene,
            model,
            options,
            rule,
            radau: None,
            newton: None,
            beginnings: Beginnings::default(),
            step: 0,
            modes: Modes::none(),
            layout: Layout::default(),
            kinetic: zero,
            continued: zero,
            state,
            solution,
            mechanism,
            h: 0.0,
            fastest: 0.0,
            is_new: false,
            has_grown: false,
            quiet: Quiet::default(),
            limits: Vec::new(),
            stages: None,
            stretched: Vec::new(),
            crossing: None,
            is_still: false,
            is_launched: options.from.is_some(),
            began: 0.0,
            is_resumed: false,
            keeping: None,
        };
        if options.from.is_some() {
            let initial = run.held_by_springs(&initial)?;
            run.refuse_forgotten()?;
            run.follow_given();
            let now = run.held_by_springs(&run.state)?;
            match (now, initial) {
                (Some(now), Some(initial)) => run.state.sums[2] = now - initial,
                _ => run.solution.stored_is_open = true,
            }
            run.continued = run.state.sums[2];
        }
        Ok(run)
    }

    pub(crate) fn all(&mut self) -> Result<(), Refusal> {
        let begin = self.state.time.to_f64();
        for step in 0..self.mechanism.schedule.len() {
            let Some(([from, to], is_dynamic)) = self.mechanism.schedule.span(step) else { break };
            if step < self.step || to <= begin && to > 0.0 {
                continue;
            }
            let to = self.options.until.map_or(to, |until| until.min(to));
            if to < from || to <= begin && begin > 0.0 {
                break;
            }
            if step > 0 {
                let stiffness = std::mem::take(&mut self.mechanism.stiffness);
                self.mechanism = Mechanism::new(self.scene, self.model, step)?;
                self.mechanism.stiffness = stiffness;
                self.mechanism.length = self.solution.length;
            }
            self.step = step;
            self.is_still = !is_dynamic;
            if !is_dynamic && self.options.stick == Stick::Elastic {
                return Err(Refusal::of(
                    &format!("step {}", step + 1),
                    "elastic stick is not solved in static steps",
                    "ask for rigid stick",
                ));
            }
            if is_dynamic { self.one(to)? } else { self.still(to)? }
        }
        self.keep(true);
        Ok(())
    }

    pub(crate) fn say(&self, trouble: Trouble) -> Refusal {
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
            Trouble::Singular(NoPivotAt::Slider(_)) | Trouble::NotFound => {
                let slipping =
                    (0..self.modes.frictions.len()).filter(|s| !self.modes.frictions[*s].is_stuck());
                let mut names: Vec<&str> = slipping.map(|s| self.title(s)).collect();
                names.dedup();
                Refusal::of(
                    &if names.is_empty() { "friction".to_string() } else { names.join(", ") },
                    &format!("no friction forces fit at time {time}"),
                    "a coefficient so large that the mechanism jams has no solution, or several",
                )
            }
            Trouble::NotFinite => Refusal::of(
                "the solution",
                &format!("a number overflows at time {time}"),
                "check masses and stiffnesses",
            ),
        }
    }

    pub(crate) fn rows(&self) -> Vec<Owner> {
        let still = vec![[R::ZERO; 3]; self.state.poses.len()];
        let instant = Instant::of(&self.state, self.step, &still);
        let found = self.mechanism.assemble(&instant, &self.modes, &self.beginnings);
        found.map_or(Vec::new(), |found| found.rows.iter().map(|row| row.owner).collect())
    }

    pub(crate) fn assembled(&self, modes: &Modes<R>) -> Result<Assembled<R>, Trouble> {
        let still = vec![[R::ZERO; 3]; self.state.poses.len()];
        let instant = Instant::of(&self.state, self.step, &still);
        let mut found = self.mechanism.assemble(&instant, modes, &self.beginnings)?;
        if self.is_still {
            found.rest(&self.mechanism);
        }
        Ok(found)
    }

    /// One step of the scene, to a time.
    pub(crate) fn one(&mut self, to: f64) -> Result<(), Refusal> {
        if !std::mem::take(&mut self.is_resumed) {
            self.began = self.state.time.to_f64();
            self.begin()?;
        }
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
            let is_break = breaks.contains(&time);
            self.reach(time, is_break)?;
            if is_frame {
                self.record(false)?;
            }
            if is_break && time < to {
                self.pass()?;
            }
        }
        Ok(())
    }

    /// Goes past a time at which something that acts is not smooth: rates that are prescribed may jump there, and so may loads.
    pub(crate) fn pass(&mut self) -> Result<(), Refusal> {
        let time = self.state.time;
        self.state.time =
            time + larger(time.magnitude(), R::from_f64(1e-300)) * R::from_f64(4.0 * R::ROUNDING);
        if self.rates_jump()? {
            // As at the beginning of a step: friction takes no impulse, and stops only push.
            let frictions = std::mem::take(&mut self.modes.frictions);
            self.modes.stops = vec![Touch::Open; self.mechanism.stops.len()];
            let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
            self.layout = Layout::new(&self.mechanism, &found, &self.modes)?;
            self.jump()?;
            self.touch()?;
            self.modes.frictions = frictions;
            let known = self.solution.events.len();
            self.begin_modes()?;
            return if self.solution.events.len() > known { self.record(true) } else { Ok(()) };
        }
        self.jump()?;
        let open = self.standing();
        self.choose(&open)
    }

    /// Whether rates are prescribed from now on that things do not have.
    fn rates_jump(&self) -> Result<bool, Refusal> {
        /// As much of the usual speed is no jump.
        const SMALL: f64 = 1e-10;
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let least = SMALL * self.usual_speed();
        let kept = self.layout.kept.iter().filter_map(|index| found.rows.get(*index));
        let rates = kept.filter_map(|row| Some((row.rate?.magnitude() / self.size_of(row.owner)).to_f64()));
        Ok(rates.into_iter().any(|rate| rate > least))
    }

    /// Brings rates to what is prescribed from now on. All other equations take no work of the impulse, so that its work is the change of
    /// the kinetic energy.
    pub(crate) fn jump(&mut self) -> Result<(), Refusal> {
        let kinetic = |run: &Self| {
            run.assembled(&run.modes).map(|found| found.kinetic()).map_err(|trouble| run.say(trouble))
        };
        let before = kinetic(self)?;
        self.project()?;
        if !self.is_still {
            let gained = kinetic(self)? - before;
            self.state.sums[0] = self.state.sums[0] + gained;
        }
        Ok(())
    }

    /// The frictions that stick rigidly, and have something to do.
    pub(crate) fn standing(&self) -> Vec<usize> {
        let stands = |s: &usize| {
            matches!(self.modes.frictions[*s].does, Does::Sticks(_) | Does::Stands(_))
                && !self.mechanism.is_idle(&self.modes, &self.mechanism.sliders[*s])
        };
        (0..self.modes.frictions.len()).filter(stands).collect()
    }

    /// The times at which something that acts is not smooth.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        if has(Fault::CornersPassed) {
            return Vec::new();
        }
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
    pub(crate) fn begin(&mut self) -> Result<(), Refusal> {
        self.remember()?;
        let before = std::mem::take(&mut self.modes.frictions);
        let have_springs = !self.mechanism.stiffness.is_empty();
        self.prepare()?;
        if !std::mem::replace(&mut self.is_launched, true) {
            self.launch()?;
            self.round_otherwise()?;
        }
        self.touch()?;
        self.stiffen()?;
        if have_springs {
            // Springs of stick go on from step to step.
            self.modes.frictions = before;
        }
        self.begin_modes()?;
        if self.solution.frames.is_empty() {
            let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
            self.kinetic = found.kinetic() + self.continued;
        }
        Ok(())
    }

    /// Keeps where things are as the step begins.
    pub(crate) fn remember(&mut self) -> Result<(), Refusal> {
        let found = self.assembled(&Modes::none()).map_err(|trouble| self.say(trouble))?;
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
        Ok(())
    }

    /// Nothing sticks, and rates fit; what is locked or has failed stays so.
    pub(crate) fn prepare(&mut self) -> Result<(), Refusal> {
        let count = self.mechanism.joints.len();
        self.modes.locked.resize(count, [None; 6]);
        self.modes.failed.resize(count, [false; 6]);
        self.modes.frictions.clear();
        self.modes.spans.clear();
        self.modes.stops = vec![Touch::Open; self.mechanism.stops.len()];
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        self.layout = Layout::new(&self.mechanism, &found, &self.modes)?;
        if self.solution.frames.is_empty() { self.project() } else { self.jump() }
    }

    /// The stick stiffness of each friction, where stick is elastic: once, at the beginning.
    fn stiffen(&mut self) -> Result<(), Refusal> {
        if self.options.stick == Stick::Rigid || !self.mechanism.stiffness.is_empty() {
            return Ok(());
        }
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let sliders = self.mechanism.sliders.iter();
        let mut modes = self.modes.clone();
        modes.spans = self.spans(&found);
        modes.frictions = sliders.map(|of| Mode::stretches(found.joints[of.joint].position)).collect();
        let (_, _, solved) = self.instant(&modes)?;
        let mut stiffness = Vec::with_capacity(self.mechanism.sliders.len());
        for (slider, limit) in self.mechanism.sliders.iter().zip(&solved.limits) {
            let title = self.joint_title(slider.joint);
            if slider.components.len() > 1 {
                let why = "elastic stick of several components together is not solved";
                return Err(Refusal::of(title, why, "ask for rigid stick"));
            }
            let given = self.mechanism.friction(slider).map(|friction| friction.stick_stiffness);
            stiffness.push(match given {
                Some(StickStiffness::Given(stiffness)) => R::from_f64(stiffness),
                Some(StickStiffness::ElasticSlip(slip)) if R::ZERO.less(limit.value) => {
                    limit.value / R::from_f64(slip)
                }
                _ => {
                    let why = "nothing presses its friction at the beginning, which would give it a stick stiffness";
                    return Err(Refusal::of(title, why, "give STICK STIFFNESS"));
                }
            });
        }
        self.stretched = vec![R::ZERO; stiffness.len()];
        self.mechanism.stiffness = stiffness;
        Ok(())
    }

    /// What the springs of frictions that slip hold more than as slip began: their force has changed with the limit.
    fn restored(&self, solved: &Solved<R>) -> R {
        let all = self.mechanism.stiffness.iter().zip(&self.stretched).zip(&self.modes.frictions).enumerate();
        all.filter(|(_, (_, mode))| !mode.is_stuck()).fold(R::ZERO, |sum, (s, ((stiffness, before), _))| {
            let limit = solved.limits.get(s).map_or(R::ZERO, |limit| limit.value);
            sum + limit * limit / *stiffness * R::ratio(1, 2) - *before
        })
    }

    /// The equations that count in a mode, and its solution.
    pub(crate) fn instant(&mut self, modes: &Modes<R>) -> Result<(Assembled<R>, Layout, Solved<R>), Refusal> {
        self.solution.evaluations += 1;
        let found = self.assembled(modes).map_err(|trouble| self.say(trouble))?;
        let layout = Layout::new(&self.mechanism, &found, modes)?;
        // Where forces have jumped, what presses may be on the other side of zero, or of the largest friction force.
        let mut free = modes.clone();
        let mut solved = match found.solve(&self.mechanism, &layout, modes) {
            Err(Trouble::NotFound) => {
                free.frictions.iter_mut().for_each(|mode| mode.branches = Branches::none());
                found.solve(&self.mechanism, &layout, &free)
            }
            known => known,
        }
        .map_err(|trouble| self.say(trouble))?;
        for _ in 0..modes.frictions.len() {
            let has_jumped = |switch: &&Switch<R>| {
                matches!(switch.cause, Cause::Turns(_) | Cause::Caps)
                    && switch.value.less(-switch.scale * R::from_f64(TIE))
            };
            let jumped: Vec<usize> = solved.switches.iter().filter(has_jumped).map(|one| one.of).collect();
            if jumped.is_empty() {
                break;
            }
            jumped.into_iter().for_each(|s| free.frictions[s].branches = Branches::none());
            solved = found.solve(&self.mechanism, &layout, &free).map_err(|trouble| self.say(trouble))?;
        }
        Ok((found, layout, solved))
    }

    /// Whose forces are open. Where more frictions stand than hold, theirs are with all that they hold.
    fn undetermined(&self, found: &Assembled<R>) -> Result<Vec<Owner>, Refusal> {
        let owners = |found: &Assembled<R>, open: &[usize]| -> Vec<Owner> {
            open.iter().filter_map(|row| found.rows.get(*row)).map(|row| row.owner).collect()
        };
        if !self.modes.frictions.iter().any(Mode::is_held_by_others) {
            return Ok(owners(found, &self.layout.open));
        }
        let mut modes = self.modes.clone();
        for (slider, mode) in self.mechanism.sliders.iter().zip(&mut modes.frictions) {
            if mode.is_held_by_others() {
                *mode = Mode::sticks(found.joints[slider.joint].position);
            }
        }
        let found = self.assembled(&modes).map_err(|trouble| self.say(trouble))?;
        let open = self.layout.undetermined(&self.mechanism, &found, &modes)?;
        Ok(owners(&found, &open))
    }

    /// Keeps this state as a frame.
    pub(crate) fn record(&mut self, is_event: bool) -> Result<(), Refusal> {
        let found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let solved =
            found.solve(&self.mechanism, &self.layout, &self.modes).map_err(|trouble| self.say(trouble))?;
        self.refuse_others(&found, &self.layout, (&self.modes, &solved))?;
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
        let accelerations = match self.is_still {
            true => vec![[R::ZERO; DOFS]; solved.accelerations.len()],
            false => solved.accelerations.clone(),
        };
        let reactions = found.reactions(&self.layout, &solved, &accelerations);
        let mut held = found.supported(&self.mechanism, &self.layout);
        let open = self.undetermined(&found)?;
        let is_undecided = self.modes.frictions.iter().any(Mode::is_held_by_others);
        for node in open.iter().filter(|_| is_undecided).flat_map(|owner| self.mechanism.nodes_of(*owner)) {
            held[DOFS * node..DOFS * (node + 1)].fill(false);
        }
        let nodes = self.state.poses.iter().enumerate().map(|(node, pose)| NodeFrame {
            displacement: pose.displacement,
            rotation: pose.vector,
            velocity: six(&self.state.rates[node]),
            acceleration: six(&accelerations[node]),
            flow: [pose.flow, self.state.rates[node][DOFS - 1], accelerations[node][DOFS - 1]],
            reaction: [0, 1, 2, 3, 4, 5].map(|k| {
                let dof = DOFS * node + k;
                if held[dof] { reactions[dof] } else { R::ZERO }
            }),
            held: [0, 1, 2, 3, 4, 5].map(|k| held[DOFS * node + k]),
        });
        let still = vec![[R::ZERO; 3]; self.state.poses.len()];
        let instant = Instant::of(&self.state, self.step, &still);
        let connectors = self.mechanism.joints.iter().enumerate().map(|(index, joint)| {
            let now = &found.joints[index];
            let of = self.mechanism.sliders.iter().zip(&self.modes.frictions);
            let held = |k: usize| {
                if let Hold::Locked(_) = self.mechanism.hold(&self.modes, index, k) {
                    return Some(StopStatus::Locked);
                }
                let mut stops = self.mechanism.stops.iter().zip(&self.modes.stops);
                let (_, touch) = stops.find(|(stop, _)| stop.joint == index && stop.component == k)?;
                Some(match touch {
                    Touch::Closed(Side::Lower) => StopStatus::AtLower,
                    Touch::Closed(Side::Upper) => StopStatus::AtUpper,
                    Touch::Open | Touch::Leaves(_) => StopStatus::Free,
                })
            };
            let [mut position, mut displacement, mut velocity] =
                self.mechanism.free_motion(index, &instant, now.branch);
            for k in (0..6).filter(|k| !joint.free[*k]) {
                position[k] = now.position[k];
                displacement[k] = now.displacement[k];
                velocity[k] = now.velocity[k];
            }
            ConnectorFrame {
                position,
                displacement,
                velocity,
                total: solved.total[index],
                open: [0, 1, 2, 3, 4, 5].map(|k| open.contains(&Owner::Joint(index, k))),
                open_friction: [0, 1, 2, 3, 4, 5].map(|k| {
                    let mut of = self.mechanism.sliders.iter().filter(|slider| slider.joint == index);
                    let rubs = of.any(|slider| slider.components.iter().any(|(of, _)| *of == k));
                    rubs && open.contains(&Owner::Joint(index, k))
                }),
                friction: solved.friction[index],
                wanted: joint.wanted,
                free: joint.free,
                sticks: of
                    .filter(|(slider, _)| slider.joint == index)
                    .map(|(slider, mode)| mode.is_stuck() && !self.mechanism.is_gone(&self.modes, slider))
                    .collect(),
                limits: self
                    .mechanism
                    .sliders
                    .iter()
                    .zip(solved.tangential.iter().zip(&solved.limits))
                    .filter(|(slider, _)| slider.joint == index)
                    .map(|(slider, (tangential, limit))| {
                        let is_gone = self.mechanism.is_gone(&self.modes, slider);
                        if is_gone { [R::ZERO; 2] } else { [*tangential, limit.value] }
                    })
                    .collect(),
                held: [0, 1, 2, 3, 4, 5].map(held),
                failed: self.modes.failed.get(index).copied().unwrap_or([false; 6]),
            }
        });
        let taken = self.restored(&solved);
        let [external, dissipated, stored] = [0, 1, 2].map(|i| self.state.sums[i]);
        let (dissipated, stored) = (dissipated - taken, stored + taken);
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
