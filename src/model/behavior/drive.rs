//! `*CONNECTOR MOTION` and `*CONNECTOR LOAD`: what is prescribed for a component, step by step.
//!
//! A motion prescribes the displacement from the initial position (CU), the velocity or the acceleration of an available component;
//! its reaction is CRF. A load is a force in the current direction of the component, positive driving it in its positive sense (CCF).
//!
//! *Time.* Steps follow one another; a state at the common time of two steps belongs to the first, for it is the end of an increment.
//! Linear perturbations take no time. A static step without times lasts 1.
//!
//! *Without an amplitude* a displacement is ramped from where it was at the beginning of the step, in Standard; in Explicit it is
//! applied at once. A velocity is applied at once in statics and in Explicit. Everything else follows `AMPLITUDE=` of the step: RAMP in
//! statics, STEP in dynamics, unless it is given.
//!
//! *From step to step.* With `OP=MOD`, what is not given again stays as it was at the end of the step that gave it, or follows its
//! amplitude where that counts total time. With `OP=NEW`, what is not given again is gone; a load is ramped down where loads are
//! ramped.

use crate::behavior::Unknown;
use crate::behavior::amplitude::Amplitude;
use pintle_kinematics::catalog::component_index;
use pintle_kinematics::scalar::{Real, Scalar};
use pintle_scene::{
    Application, Boundary, Code, ConditionKind, DefaultAmplitude, Diagnostic, MotionType, Procedure, Scene,
    Span, Step, Target,
};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// When a step begins and ends, and what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Interval {
    begin: f64,
    end: f64,
    is_dynamic: bool,
    is_explicit: bool,
    ramps: bool,
}

/// The steps of a scene in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schedule {
    steps: Vec<Interval>,
    /// Whether a step of unknown length follows.
    is_open: bool,
}

/// A number that is known beforehand, or the displacement that a component has at the beginning of a step (by its number).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Level {
    Known(f64),
    AtBeginning(usize),
}

/// How a quantity changes during a step.
#[derive(Clone, Debug, PartialEq)]
enum Course {
    /// It stays.
    Held(Level),
    /// Linear, over the step.
    Ramp(Level, f64),
    /// Magnitude times amplitude, or the amplitude itself, counted from `origin`.
    Follows { amplitude: Arc<Amplitude>, magnitude: f64, origin: f64, smoothing: f64 },
    /// A subroutine, another program or the solution gives it.
    External,
}

/// What is prescribed in one step.
#[derive(Clone, Debug, PartialEq)]
struct Phase {
    kind: MotionType,
    courses: Vec<Course>,
}

/// What is prescribed for one component, for each step of the schedule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drive {
    phases: Vec<Option<Phase>>,
    /// What holds where there are no steps.
    initially: Option<Phase>,
}

/// What is prescribed at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prescribed<S> {
    /// The displacement CU.
    Displacement(S),
    /// The velocity.
    Velocity(S),
    /// The acceleration.
    Acceleration(S),
    /// It is prescribed, and not known.
    Unknown(MotionType, Unknown),
}

/// The motions and loads of one connector, for each component.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drives {
    /// Motions.
    pub motions: [Option<Drive>; 6],
    /// Loads.
    pub loads: [Option<Drive>; 6],
}

impl Drives {
    /// Whether nothing is prescribed.
    pub fn is_empty(&self) -> bool {
        self.motions.iter().chain(&self.loads).all(Option::is_none)
    }
}

impl Schedule {
    /// How many steps have a place in time: motions and loads of the others are not evaluated.
    pub const fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether no step has a place in time.
    pub const fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// The steps of a scene.
    pub fn new(scene: &Scene) -> Self {
        let mut schedule = Self::default();
        let mut time = 0.0;
        for step in scene.steps.iter().filter(|step| takes_time(step)) {
            let Some(interval) = interval(step, time) else {
                schedule.is_open = true;
                break;
            };
            time = interval.end;
            schedule.steps.push(interval);
        }
        schedule
    }

    /// The number of the step to which a time belongs; none after the last one.
    fn step<R: Real>(&self, time: R) -> Option<usize> {
        let is_within = |end: f64| !R::holds(R::from_f64(end).less(time));
        self.steps.iter().position(|step| is_within(step.end))
    }

    /// When a step begins and ends, by its number from 0, and whether it is dynamic.
    pub fn span(&self, step: usize) -> Option<([f64; 2], bool)> {
        self.steps.get(step).map(|step| ([step.begin, step.end], step.is_dynamic))
    }

    /// The steps that begin at this time, by number.
    pub fn beginning_at(&self, time: f64) -> impl Iterator<Item = usize> + '_ {
        self.steps.iter().enumerate().filter(move |(_, step)| step.begin == time).map(|(i, _)| i)
    }
}

/// Whether a step goes on in time: a linear perturbation does not.
pub const fn takes_time(step: &Step) -> bool {
    !step.perturbation
}

fn interval(step: &Step, begin: f64) -> Option<Interval> {
    let (times, is_dynamic, is_explicit) = match step.procedure.as_ref()? {
        Procedure::Static(times) => (times, false, false),
        Procedure::Dynamic { explicit, times } => (times, true, *explicit),
        Procedure::Other(_) => return None,
    };
    let length = times.total.or((!is_dynamic).then_some(1.0)).filter(|length| *length >= 0.0)?;
    let ramps = match step.default_amplitude {
        Some(default) => default == DefaultAmplitude::Ramp,
        None => !is_dynamic,
    };
    Some(Interval { begin, end: begin + length, is_dynamic, is_explicit, ramps: ramps && !is_explicit })
}

/// A motion or load as a deck gives it.
struct Given<'a> {
    kind: MotionType,
    magnitude: Option<f64>,
    applied: &'a Application,
    span: Span,
}

/// The motions and loads of the connectors of a scene, by element number.
///
/// # Errors
/// An amplitude that cannot be read; two motions of one component in one step.
pub fn drives<L: Ord + Copy>(
    scene: &Scene,
    schedule: &Schedule,
    labels: impl Fn(&Target) -> Vec<L>,
) -> Result<BTreeMap<L, Drives>, Diagnostic> {
    let amplitudes = amplitudes(scene)?;
    let mut all: BTreeMap<L, Drives> = BTreeMap::new();
    for motion in &scene.connector_motions {
        for label in labels(&motion.target.value) {
            let Some(k) = component_index(motion.component) else { continue };
            all.entry(label).or_default().motions[k] = Some(Drive::held());
        }
    }
    let steps = scene.steps.iter().filter(|step| takes_time(step)).take(schedule.steps.len());
    for (number, step) in steps.enumerate() {
        let mut given = InStep::default();
        for motion in step.connector_motions.iter().filter(|motion| !motion.applied.imaginary) {
            let Some(k) = component_index(motion.component) else { continue };
            for label in labels(&motion.target.value) {
                let one = Given {
                    kind: motion.kind,
                    magnitude: motion.magnitude,
                    applied: &motion.applied,
                    span: motion.target.span,
                };
                if let Some(first) = given.motions.insert((label, k), one) {
                    let message = format!(
                        "component {} has two motions in one step, the first at line {}",
                        k + 1,
                        first.span.line()
                    );
                    return Err(Diagnostic::error(
                        Code::RepeatedSuboption,
                        motion.target.span,
                        message,
                        "the second one",
                    )
                    .help("keep one of the two"));
                }
            }
        }
        for load in step.connector_loads.iter().filter(|load| !load.applied.imaginary) {
            let Some(k) = component_index(load.component) else { continue };
            for label in labels(&load.target.value) {
                given.load((label, k), load.magnitude, &load.applied, load.target.span);
            }
        }
        given.renews_motions = step.removes(ConditionKind::ConnectorMotion);
        given.renews_loads = step.removes(ConditionKind::ConnectorLoad);
        given.add_to(&mut all, &Context { schedule, number, amplitudes: &amplitudes });
    }
    all.retain(|_, drives| !drives.is_empty());
    Ok(all)
}

/// The place of degree of freedom 6 among the motions and loads of [`on_angles`].
pub const ANGLE: usize = 5;

/// What is prescribed for the rotations about 3, degree of freedom 6, of the nodes that `labels` gives: boundary conditions and
/// concentrated moments, in [`Drives::motions`] and [`Drives::loads`] at [`ANGLE`]. They are the angles of hinges (`*MPC`), which are numbers
/// and not components of a rotation vector. A later boundary condition of a step replaces an earlier one.
///
/// # Errors
/// An amplitude that cannot be read.
pub fn on_angles<L: Ord + Copy>(
    scene: &Scene,
    schedule: &Schedule,
    labels: impl Fn(&Target) -> Vec<L>,
) -> Result<BTreeMap<L, Drives>, Diagnostic> {
    on_numbers(scene, schedule, ANGLE..=ANGLE, labels)
}

/// What is prescribed for degrees of freedom 1 to 6 of the nodes that `labels` gives: boundary conditions in [`Drives::motions`] and
/// concentrated loads in [`Drives::loads`], along the axes of the node. A later boundary condition of a step replaces an earlier one.
///
/// # Errors
/// An amplitude that cannot be read.
pub fn on_nodes<L: Ord + Copy>(
    scene: &Scene,
    schedule: &Schedule,
    labels: impl Fn(&Target) -> Vec<L>,
) -> Result<BTreeMap<L, Drives>, Diagnostic> {
    on_numbers(scene, schedule, 0..=5, labels)
}

/// The same for some degrees of freedom, counted from 0.
fn on_numbers<L: Ord + Copy>(
    scene: &Scene,
    schedule: &Schedule,
    wanted: RangeInclusive<usize>,
    labels: impl Fn(&Target) -> Vec<L>,
) -> Result<BTreeMap<L, Drives>, Diagnostic> {
    let amplitudes = amplitudes(scene)?;
    let places = |boundary: &Boundary| -> Vec<usize> {
        let numbers = boundary.degrees_of_freedom.iter();
        numbers.filter_map(|number| component_index(*number)).filter(|k| wanted.contains(k)).collect()
    };
    let mut all: BTreeMap<L, Drives> = BTreeMap::new();
    for boundary in &scene.boundaries {
        for k in places(boundary) {
            for label in labels(&boundary.target.value) {
                all.entry(label).or_default().motions[k] = Some(Drive::held());
            }
        }
    }
    let steps = scene.steps.iter().filter(|step| takes_time(step)).take(schedule.steps.len());
    for (number, step) in steps.enumerate() {
        let mut given = InStep::default();
        for boundary in step.boundaries.iter().filter(|boundary| !boundary.applied.imaginary) {
            for k in places(boundary) {
                for label in labels(&boundary.target.value) {
                    let one = Given {
                        kind: boundary.kind,
                        magnitude: Some(boundary.magnitude),
                        applied: &boundary.applied,
                        span: boundary.target.span,
                    };
                    given.motions.insert((label, k), one);
                }
            }
        }
        for load in step.concentrated_loads.iter().filter(|load| !load.applied.imaginary) {
            let Some(k) = component_index(load.degree_of_freedom).filter(|k| wanted.contains(k)) else {
                continue;
            };
            for label in labels(&load.target.value) {
                given.load((label, k), load.magnitude, &load.applied, load.target.span);
            }
        }
        given.renews_motions = step.removes(ConditionKind::Boundary);
        given.renews_loads = step.removes(ConditionKind::ConcentratedLoad);
        given.add_to(&mut all, &Context { schedule, number, amplitudes: &amplitudes });
    }
    all.retain(|_, drives| !drives.is_empty());
    Ok(all)
}

/// The accelerations of gravity (`*DLOAD`, GRAV) by what they act on, none being the whole model: its three components in
/// [`Drives::loads`] at 0, 1, 2 (length/time²).
///
/// # Errors
/// An amplitude that cannot be read.
pub fn gravity(scene: &Scene, schedule: &Schedule) -> Result<Vec<(Option<Target>, Drives)>, Diagnostic> {
    let amplitudes = amplitudes(scene)?;
    let mut targets: Vec<Option<Target>> = Vec::new();
    let mut all: BTreeMap<usize, Drives> = BTreeMap::new();
    let steps = scene.steps.iter().filter(|step| takes_time(step)).take(schedule.steps.len());
    for (number, step) in steps.enumerate() {
        let mut given = InStep::default();
        let loads = step.distributed_loads.iter().filter(|load| load.is_gravity());
        for load in loads.filter(|load| !load.applied.imaginary) {
            let target = load.target.as_ref().map(|target| target.value.clone());
            let span = load.target.as_ref().map_or(step.span, |target| target.span);
            let index = targets.iter().position(|known| *known == target).unwrap_or_else(|| {
                targets.push(target);
                targets.len() - 1
            });
            let value = |i: usize| load.values.get(i).copied().flatten().unwrap_or(0.0);
            let direction = [value(1), value(2), value(3)];
            let length = pintle_kinematics::scalar::elementary::norm(direction);
            for (k, along) in direction.into_iter().enumerate().filter(|_| length > 0.0) {
                given.load((index, k), value(0) * (along / length), &load.applied, span);
            }
        }
        given.renews_loads = step.removes(ConditionKind::DistributedLoad);
        given.add_to(&mut all, &Context { schedule, number, amplitudes: &amplitudes });
    }
    Ok(all.into_iter().filter_map(|(index, drives)| Some((targets.get(index)?.clone(), drives))).collect())
}

/// The amplitudes of a scene by name.
fn amplitudes(scene: &Scene) -> Result<BTreeMap<&str, Arc<Amplitude>>, Diagnostic> {
    let named = scene.amplitudes.iter();
    named.map(|(name, given)| Ok((name.as_str(), Arc::new(Amplitude::new(name, given)?)))).collect()
}

/// What one step gives.
struct InStep<'a, L> {
    motions: BTreeMap<(L, usize), Given<'a>>,
    loads: BTreeMap<(L, usize), Vec<Given<'a>>>,
    renews_motions: bool,
    renews_loads: bool,
}

impl<L> Default for InStep<'_, L> {
    fn default() -> Self {
        Self { motions: BTreeMap::new(), loads: BTreeMap::new(), renews_motions: false, renews_loads: false }
    }
}

impl<'a, L: Ord + Copy> InStep<'a, L> {
    fn load(&mut self, at: (L, usize), magnitude: f64, applied: &'a Application, span: Span) {
        let given = Given { kind: MotionType::Displacement, magnitude: Some(magnitude), applied, span };
        self.loads.entry(at).or_default().push(given);
    }

    /// Goes on with every drive through this step.
    fn add_to(mut self, all: &mut BTreeMap<L, Drives>, context: &Context<'_>) {
        for (label, _) in self.motions.keys().chain(self.loads.keys()) {
            all.entry(*label).or_default();
        }
        for (label, drives) in all {
            for k in 0..6 {
                let given = self.motions.remove(&(*label, k));
                context.motion(&mut drives.motions[k], given.as_ref(), self.renews_motions);
                let given = self.loads.remove(&(*label, k));
                context.load(&mut drives.loads[k], given.as_deref(), self.renews_loads);
            }
        }
    }
}

/// A step that is added to drives.
struct Context<'a> {
    schedule: &'a Schedule,
    number: usize,
    amplitudes: &'a BTreeMap<&'a str, Arc<Amplitude>>,
}

impl Context<'_> {
    fn interval(&self) -> Interval {
        self.schedule.steps[self.number]
    }

    /// What was prescribed before this step.
    fn before<'b>(&self, drive: Option<&'b Drive>) -> Option<&'b Phase> {
        match self.number.checked_sub(1) {
            None => drive?.initially.as_ref(),
            Some(last) => drive?.phases.get(last)?.as_ref(),
        }
    }

    /// The value at the end of the step before.
    fn end_before(&self, phase: &Phase) -> Option<f64> {
        let end = self.interval().begin;
        let steps = self.schedule.steps.get(..self.number)?;
        let before = steps.last();
        phase.courses.iter().try_fold(0.0, |sum, course| {
            let value = course.value(end, before, &|_| None);
            value.ok().map(|value: f64| sum + value)
        })
    }

    fn push(&self, drive: &mut Option<Drive>, phase: Option<Phase>) {
        if drive.is_none() && phase.is_none() {
            return;
        }
        let drive = drive.get_or_insert_with(Drive::default);
        drive.phases.resize(self.number, None);
        drive.phases.push(phase);
    }

    fn motion(&self, drive: &mut Option<Drive>, given: Option<&Given<'_>>, renews: bool) {
        let before = self.before(drive.as_ref());
        let begin = if self.number == 0 { Level::Known(0.0) } else { Level::AtBeginning(self.number) };
        // Where a displacement was prescribed until now, its last value is where the component is.
        let start = before
            .filter(|phase| phase.kind == MotionType::Displacement)
            .and_then(|phase| self.end_before(phase))
            .map_or(begin, Level::Known);
        let phase = match given {
            None if renews => None,
            None => before.map(|phase| self.continued(phase)),
            Some(given) if given.applied.fixed => {
                Some(Phase { kind: MotionType::Displacement, courses: vec![Course::Held(start)] })
            }
            Some(given) => {
                let Interval { is_dynamic, is_explicit, ramps, .. } = self.interval();
                let ramps = match given.kind {
                    MotionType::Displacement => !is_explicit,
                    MotionType::Velocity if !is_dynamic => false,
                    _ => ramps,
                };
                let from = if given.kind == MotionType::Displacement {
                    start
                } else {
                    let same = before.filter(|phase| phase.kind == given.kind);
                    Level::Known(same.and_then(|phase| self.end_before(phase)).unwrap_or(0.0))
                };
                let smooths = is_dynamic && given.kind != MotionType::Acceleration;
                Some(Phase { kind: given.kind, courses: vec![self.course(given, ramps, from, smooths)] })
            }
        };
        self.push(drive, phase);
    }

    fn load(&self, drive: &mut Option<Drive>, given: Option<&[Given<'_>]>, renews: bool) {
        let before = self.before(drive.as_ref());
        let last = before.and_then(|phase| self.end_before(phase));
        let kind = MotionType::Displacement;
        let ramps = self.interval().ramps;
        let phase = match given {
            None if renews && ramps => last
                .filter(|last| *last != 0.0)
                .map(|last| Phase { kind, courses: vec![Course::Ramp(Level::Known(last), 0.0)] }),
            None if renews => None,
            None => before.map(|phase| self.continued(phase)),
            Some(given) => {
                // Several loads of one component add up; the first is ramped from what was there.
                let mut from = last.unwrap_or(0.0);
                let courses = given.iter().map(|given| {
                    let course = self.course(given, ramps, Level::Known(from), false);
                    if matches!(course, Course::Ramp(..)) {
                        from = 0.0;
                    }
                    course
                });
                Some(Phase { kind, courses: courses.collect() })
            }
        };
        self.push(drive, phase);
    }

    fn course(&self, given: &Given<'_>, ramps: bool, from: Level, smooths: bool) -> Course {
        let magnitude = given.magnitude.unwrap_or(0.0);
        let Interval { begin, is_explicit, .. } = self.interval();
        let amplitude =
            given.applied.amplitude.as_ref().and_then(|name| self.amplitudes.get(name.value.as_str()));
        match amplitude {
            _ if given.applied.user => Course::External,
            Some(amplitude) => Course::Follows {
                amplitude: Arc::clone(amplitude),
                magnitude: if amplitude.is_absolute { 1.0 } else { magnitude },
                origin: if amplitude.is_total_time { 0.0 } else { begin },
                smoothing: if smooths { amplitude.smoothing(is_explicit) } else { 0.0 },
            },
            None if ramps => Course::Ramp(from, magnitude),
            None => Course::Held(Level::Known(magnitude)),
        }
    }

    /// What a phase becomes in the step after it.
    fn continued(&self, phase: &Phase) -> Phase {
        let before = self.number.checked_sub(1).and_then(|last| self.schedule.steps.get(last));
        let end = self.interval().begin;
        let courses = phase.courses.iter().map(|course| match course {
            Course::Follows { amplitude, .. } if amplitude.is_total_time => course.clone(),
            Course::Held(level) => Course::Held(*level),
            Course::External => Course::External,
            Course::Ramp(_, to) => Course::Held(Level::Known(*to)),
            Course::Follows { .. } => {
                let value: Result<f64, Unknown> = course.value(end, before, &|_| None);
                value.map_or(Course::External, |value| Course::Held(Level::Known(value)))
            }
        });
        Phase { kind: phase.kind, courses: courses.collect() }
    }
}

impl Course {
    /// The value at a time of a step; `beginning` knows the displacements at the beginnings of steps.
    fn value<S: Scalar>(
        &self,
        time: S,
        step: Option<&Interval>,
        beginning: &impl Fn(usize) -> Option<f64>,
    ) -> Result<S, Unknown> {
        let number = |x: f64| S::Real::from_f64(x);
        let level = |level: &Level| match level {
            Level::Known(value) => Ok(S::from_real(number(*value))),
            Level::AtBeginning(step) => {
                beginning(*step).map(|value| S::from_real(number(value))).ok_or(Unknown::StepBeginning)
            }
        };
        match self {
            Self::Held(at) => level(at),
            Self::Ramp(from, to) => {
                let (from, to) = (level(from)?, S::from_real(number(*to)));
                let Some(Interval { begin, end, .. }) = step else { return Ok(to) };
                let length = number(*end) - number(*begin);
                if *end <= *begin {
                    return Ok(to);
                }
                let zero = S::Real::ZERO;
                let inverse = S::Real::integer(1) / length;
                let [since, left] = [time.real() - number(*begin), number(*end) - time.real()];
                // From the nearer end, so that both are met exactly.
                let is_nearer = S::Real::holds(since.less(left));
                let (base, part) = if is_nearer { (from, since / length) } else { (to, -(left / length)) };
                Ok(base + (to - from) * time.lift(&[part, inverse, zero, zero, zero]))
            }
            Self::Follows { amplitude, magnitude, origin, smoothing } => {
                let since = time - S::from_real(number(*origin));
                let value = amplitude.evaluate(since, *smoothing).ok_or(Unknown::External)?;
                Ok(value.scale(number(*magnitude)))
            }
            Self::External => Err(Unknown::External),
        }
    }
}

impl Drive {
    /// Held where it is from the beginning.
    fn held() -> Self {
        let courses = vec![Course::Held(Level::Known(0.0))];
        Self { phases: Vec::new(), initially: Some(Phase { kind: MotionType::Displacement, courses }) }
    }

    /// What is prescribed at a time, with the time derivatives that it carries; `None` where nothing is. `beginning` knows the
    /// displacement of the component at the beginning of a step, by its number.
    pub fn at<S: Scalar>(
        &self,
        schedule: &Schedule,
        time: Option<S>,
        beginning: impl Fn(usize) -> Option<f64>,
    ) -> Option<Prescribed<S>> {
        let (phase, step) = if schedule.steps.is_empty() && !schedule.is_open {
            (self.initially.as_ref()?, None)
        } else {
            let Some(time) = time else {
                // Without a time it is known only if it is the same at all times.
                let mut phases = self.phases.iter();
                let first = phases.next()?.as_ref()?;
                let constant = matches!(first.courses.as_slice(), [Course::Held(Level::Known(_))]);
                let same = !schedule.is_open
                    && self.phases.len() == schedule.steps.len()
                    && phases.all(|phase| phase.as_ref() == Some(first));
                if !(constant && same) {
                    return Some(Prescribed::Unknown(first.kind, Unknown::Time));
                }
                return Some(first.prescribed(S::zero(), None, &beginning));
            };
            match schedule.step(time.real()) {
                Some(step) => (self.phases.get(step)?.as_ref()?, schedule.steps.get(step)),
                None => {
                    let last = self.phases.last()?.as_ref()?;
                    return Some(Prescribed::Unknown(last.kind, Unknown::AfterSteps));
                }
            }
        };
        Some(phase.prescribed(time.unwrap_or(S::zero()), step, &beginning))
    }

    /// Whether something is prescribed in a step, by its number from 0.
    pub fn acts_in(&self, schedule: &Schedule, step: usize) -> bool {
        match schedule.steps.is_empty() {
            true => self.initially.is_some(),
            false => self.phases.get(step).is_some_and(Option::is_some),
        }
    }

    /// The times of a step, by its number from 0, at which it is not smooth.
    pub fn breaks(&self, step: usize) -> Vec<f64> {
        let phase = self.phases.get(step).and_then(Option::as_ref);
        let courses = phase.map_or(&[][..], |phase| phase.courses.as_slice());
        let each = courses.iter().map(|course| match course {
            Course::Follows { amplitude, origin, smoothing, .. } => {
                amplitude.breaks(*smoothing).into_iter().map(|time| time + origin).collect()
            }
            Course::Held(_) | Course::Ramp(..) | Course::External => Vec::new(),
        });
        each.collect::<Vec<Vec<f64>>>().concat()
    }

    /// Whether it is a displacement that is known to stay zero throughout a step.
    pub fn rests(&self, schedule: &Schedule, step: usize) -> bool {
        let phase = match schedule.steps.is_empty() {
            true => self.initially.as_ref(),
            false => self.phases.get(step).and_then(Option::as_ref),
        };
        phase.is_some_and(|phase| {
            phase.kind == MotionType::Displacement
                && phase.courses.iter().all(|course| match course {
                    Course::Held(Level::Known(at)) => *at == 0.0,
                    Course::Ramp(Level::Known(from), to) => *from == 0.0 && *to == 0.0,
                    Course::Follows { magnitude, amplitude, .. } => {
                        *magnitude == 0.0 && !amplitude.is_absolute
                    }
                    Course::Held(Level::AtBeginning(_))
                    | Course::Ramp(Level::AtBeginning(_), _)
                    | Course::External => false,
                })
        })
    }

    /// What is prescribed at a time of a step, by its number from 0, that of its beginning included; as [`Drive::at`].
    pub fn within<S: Scalar>(
        &self,
        schedule: &Schedule,
        step: usize,
        time: S,
        beginning: impl Fn(usize) -> Option<f64>,
    ) -> Option<Prescribed<S>> {
        match schedule.steps.get(step) {
            None => self.at(schedule, Some(time), beginning),
            some => Some(self.phases.get(step)?.as_ref()?.prescribed(time, some, &beginning)),
        }
    }

    /// The load at a time: 0 where there is none.
    ///
    /// # Errors
    /// Why it is not known.
    pub fn load<S: Scalar>(&self, schedule: &Schedule, time: Option<S>) -> Result<S, Unknown> {
        match self.at(schedule, time, |_| None) {
            None => Ok(S::zero()),
            Some(Prescribed::Displacement(load)) => Ok(load),
            Some(Prescribed::Velocity(_) | Prescribed::Acceleration(_)) => Err(Unknown::External),
            Some(Prescribed::Unknown(_, unknown)) => Err(unknown),
        }
    }
}

impl Phase {
    fn prescribed<S: Scalar>(
        &self,
        time: S,
        step: Option<&Interval>,
        beginning: &impl Fn(usize) -> Option<f64>,
    ) -> Prescribed<S> {
        let sum = self
            .courses
            .iter()
            .try_fold(S::zero(), |sum, course| course.value(time, step, beginning).map(|value| sum + value));
        match (sum, self.kind) {
            (Err(unknown), kind) => Prescribed::Unknown(kind, unknown),
            (Ok(value), MotionType::Displacement) => Prescribed::Displacement(value),
            (Ok(value), MotionType::Velocity) => Prescribed::Velocity(value),
            (Ok(value), MotionType::Acceleration) => Prescribed::Acceleration(value),
        }
    }
}
