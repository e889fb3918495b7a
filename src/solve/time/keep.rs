//! A run is kept as it goes, and goes on from there, or from a state that is given.

use crate::motion::mode::Modes;
use crate::motion::rows::{Beginnings, Instant, Layout};
use crate::motion::state::State;
use crate::number::Number;
use crate::refusal::Refusal;
use crate::time::integrate::Stages;
use crate::time::run::{Run, Stick};
use crate::time::solution::{Event, Frame};
use crate::time::step::Quiet;
use pintle_kinematics::vector::Vector;
use pintle_model::behavior::{Conditions, Motion};
use serde::{Deserialize, Serialize};
use std::time::Duration;
use std::{fmt, time};

/// A solution in the making: all that its next step depends on, and what it has found.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Kept<R> {
    is_done: bool,
    step: usize,
    began: f64,
    state: State<R>,
    modes: Modes<R>,
    layout: Layout,
    kinetic: R,
    h: f64,
    fastest: f64,
    is_new: bool,
    #[serde(default)]
    has_grown: bool,
    #[serde(default)]
    quiet: Quiet,
    #[serde(default = "Option::default")]
    stages: Option<Stages<R>>,
    stretched: Vec<R>,
    stiffness: Vec<R>,
    beginnings: Beginnings,
    frames: Vec<Frame<R>>,
    events: Vec<Event<R>>,
    #[serde(default)]
    ties: Vec<(f64, usize)>,
    lipschitz: f64,
    steps: usize,
    evaluations: usize,
    violation: f64,
    #[serde(default)]
    changed: f64,
    #[serde(default)]
    stored_is_open: bool,
    #[serde(default)]
    liveliest: f64,
    #[serde(default)]
    farthest: f64,
}

/// Where a run is kept, and how often.
pub struct Keeping<'a, R> {
    every: Duration,
    take: Box<dyn FnMut(Kept<R>) + 'a>,
    last: time::Instant,
}

impl<'a, R> Keeping<'a, R> {
    /// Hands the run on as often as that, and at its end.
    pub fn new(every: Duration, take: impl FnMut(Kept<R>) + 'a) -> Self {
        Self { every, take: Box::new(take), last: time::Instant::now() }
    }
}

impl<R> fmt::Debug for Keeping<'_, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Keeping").field("every", &self.every).finish_non_exhaustive()
    }
}

impl<R: Number> Run<'_, R> {
    /// Keeps the run, where it is time for that.
    pub(crate) fn keep(&mut self, is_done: bool) {
        let Some(keeping) = &mut self.keeping else { return };
        if !is_done && keeping.last.elapsed() < keeping.every {
            return;
        }
        (keeping.take)(Kept {
            is_done,
            step: self.step,
            began: self.began,
            state: self.state.clone(),
            modes: self.modes.clone(),
            layout: self.layout.clone(),
            kinetic: self.kinetic,
            h: self.h,
            fastest: self.fastest,
            is_new: self.is_new,
            has_grown: self.has_grown,
            quiet: self.quiet,
            stages: self.stages.clone(),
            stretched: self.stretched.clone(),
            stiffness: self.mechanism.stiffness.clone(),
            beginnings: self.beginnings.clone(),
            frames: self.solution.frames.clone(),
            events: self.solution.events.clone(),
            ties: self.solution.ties.clone(),
            lipschitz: self.solution.lipschitz,
            steps: self.solution.steps,
            evaluations: self.solution.evaluations,
            violation: self.solution.violation,
            changed: self.solution.changed,
            stored_is_open: self.solution.stored_is_open,
            liveliest: self.solution.liveliest,
            farthest: self.solution.farthest,
        });
        keeping.last = time::Instant::now();
    }

    /// Goes back to where a run was kept; whether that is its end.
    pub(crate) fn resume(&mut self, kept: Kept<R>) -> bool {
        self.step = kept.step;
        self.began = kept.began;
        self.state = kept.state;
        self.modes = kept.modes;
        self.layout = kept.layout;
        self.kinetic = kept.kinetic;
        self.h = kept.h;
        self.fastest = kept.fastest;
        self.is_new = kept.is_new;
        self.has_grown = kept.has_grown;
        self.quiet = kept.quiet;
        self.stages = kept.stages;
        self.stretched = kept.stretched;
        self.mechanism.stiffness = kept.stiffness;
        self.beginnings = kept.beginnings;
        self.solution.frames = kept.frames;
        self.solution.events = kept.events;
        self.solution.ties = kept.ties;
        self.solution.lipschitz = kept.lipschitz;
        self.solution.steps = kept.steps;
        self.solution.evaluations = kept.evaluations;
        self.solution.violation = kept.violation;
        self.solution.changed = kept.changed;
        self.solution.stored_is_open = kept.stored_is_open;
        self.solution.liveliest = kept.liveliest;
        self.solution.farthest = kept.farthest;
        self.is_launched = true;
        self.is_resumed = true;
        kept.is_done
    }

    /// The energy in springs; none where one of them has no potential.
    pub(crate) fn held_by_springs(&self, state: &State<R>) -> Result<Option<R>, Refusal> {
        let still = vec![[R::ZERO; 3]; state.poses.len()];
        let instant = Instant::of(state, self.step, &still);
        let found = self.mechanism.assemble(&instant, &Modes::none(), &self.beginnings);
        let found = found.map_err(|trouble| self.say(trouble))?;
        let conditions = Conditions::default();
        let mut sum = R::ZERO;
        for (joint, now) in self.mechanism.joints.iter().zip(&found.joints) {
            let elasticity = &joint.behavior.behavior.elasticity;
            let is_belt = joint.connector.connection().is_belt();
            let motion = Motion { position: now.position, constitutive: now.motion, velocity: now.velocity };
            let energy = elasticity.energy(&motion, &conditions);
            let has_potential = !is_belt || !elasticity.components().contains(&true);
            let Some(energy) = energy.filter(|_| has_potential) else { return Ok(None) };
            sum = sum + energy;
        }
        for (spring, [stretch, _]) in self.mechanism.springs.iter().zip(&found.springs) {
            let Ok(energy) = spring.law.energy(*stretch, &conditions) else { return Ok(None) };
            sum = sum + energy;
        }
        Ok(Some(sum))
    }

    /// Refuses to go on from a later state where what follows depends on more than a state tells.
    pub(crate) fn refuse_forgotten(&self) -> Result<(), Refusal> {
        if self.state.time.to_f64() <= 0.0 {
            return Ok(());
        }
        let mechanism = &self.mechanism;
        let remedy = "solve it from the beginning: --keep and --resume go on exactly";
        let refused = |joint: usize, what: &str| {
            let why = format!("a state does not tell {what}, on which what follows depends");
            Err(Refusal::of(self.joint_title(joint), &why, remedy))
        };
        if let Some(criterion) = mechanism.criteria.first() {
            let what = if criterion.is_failure { "whether it has failed" } else { "where it has locked" };
            return refused(criterion.joint, what);
        }
        for slider in &mechanism.sliders {
            if slider.ring.is_some() {
                return refused(slider.joint, "how far its belt has run over the ring");
            }
            if self.options.stick == Stick::Elastic {
                return refused(slider.joint, "how far the spring of its stick is stretched");
            }
            if mechanism.friction(slider).is_some_and(|of| of.criterion.depends_on_slip()) {
                return refused(slider.joint, "how far it has slipped");
            }
        }
        Ok(())
    }

    /// Takes the histories of connectors to a state that is given: the whole rotation is their increment.
    pub(crate) fn follow_given(&mut self) {
        let turned: Vec<Vector<R>> = self.state.poses.iter().map(|pose| pose.vector).collect();
        let instant = Instant { turned: &turned, ..Instant::of(&self.state, self.step, &turned) };
        if let Ok(found) = self.mechanism.assemble(&instant, &Modes::none(), &self.beginnings) {
            self.state.branches = found.joints.iter().map(|now| now.branch).collect();
        }
    }
}
