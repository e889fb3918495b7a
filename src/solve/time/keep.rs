//! A run is kept as it goes, and goes on from there.

use crate::motion::mode::Modes;
use crate::motion::rows::{Beginnings, Layout};
use crate::motion::state::State;
use crate::number::Number;
use crate::time::run::Run;
use crate::time::solution::{Event, Frame};
use crate::time::step::Quiet;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::time::{Duration, Instant};

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
    quiet: Quiet,
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
    liveliest: f64,
}

/// Where a run is kept, and how often.
pub struct Keeping<'a, R> {
    every: Duration,
    take: Box<dyn FnMut(Kept<R>) + 'a>,
    last: Instant,
}

impl<'a, R> Keeping<'a, R> {
    /// Hands the run on as often as that, and at its end.
    pub fn new(every: Duration, take: impl FnMut(Kept<R>) + 'a) -> Self {
        Self { every, take: Box::new(take), last: Instant::now() }
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
            quiet: self.quiet,
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
            liveliest: self.solution.liveliest,
        });
        keeping.last = Instant::now();
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
        self.quiet = kept.quiet;
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
        self.solution.liveliest = kept.liveliest;
        self.is_launched = true;
        self.is_resumed = true;
        kept.is_done
    }
}
