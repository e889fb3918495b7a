//! The behaviour of one connector at one state, after its history.
//!
//! [`Behavior`] holds what a section's `*CONNECTOR BEHAVIOR` says for its connection type. [`History`] holds what the states before have
//! decided: locks, failures, where the component was. [`Behavior::at`] gives all forces at the next state, and the history to commit.
//! A history is committed by keeping it: none is changed in place, so that an iteration can be repeated.
//!
//! *What a motion tells.* Elastic and viscous forces and loads follow from the motion. A component that is held by a stop, a lock, a
//! prescribed motion or a rigid elasticity has a reaction besides. It follows only from a given total force:
//! CRF = CTF − CEF − CVF − CSF + CCF. Where it is not given, CRF and CTF of that component are not known, and said to be so. A
//! component that is free has CRF = 0. A constrained component has CTF = CRF, given or not known.

use crate::behavior::damping::Damping;
use crate::behavior::drive::{Drives, Prescribed, Schedule};
use crate::behavior::elasticity::Elasticity;
use crate::behavior::friction;
use crate::behavior::friction::Frictions;
use crate::behavior::limits::{Criterion, Passed, Verdict};
use crate::behavior::slide::{Beyond, Slip};
use crate::behavior::{Conditions, ForceKink, Forces, Motion, PRINTED, Unknown};
use num_dual::Dual2_64;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Components, Evaluation, Mask, Stop, StopStatus};
use pintle_scene as scene;
use pintle_scene::{Diagnostic, MotionType};
use serde::{Deserialize, Serialize};

/// The behaviour of a connection type, as a deck gives it.
#[derive(Clone, Debug, Default)]
pub struct Behavior {
    /// Springs.
    pub elasticity: Elasticity,
    /// Dampers.
    pub damping: Damping,
    /// Locks.
    pub locks: Vec<Criterion>,
    /// Failures.
    pub failures: Vec<Criterion>,
    /// Friction.
    pub friction: Frictions,
    stops: Components<Stop>,
    pub(super) available: Mask,
    pub(super) constrained: Mask,
    /// The components that slide.
    pub(super) slips: Mask,
    /// The components on which plasticity, damage or a uniaxial behaviour acts.
    inelastic: Mask,
}

/// What the states up to now decide about the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// The position at which a component was locked.
    pub locked: Components<f64>,
    /// The components that have failed.
    pub failed: Mask,
    /// The time of the last state.
    pub time: Option<f64>,
    /// The displacements at the last state.
    pub displacement: Components<f64>,
    /// What each friction remembers, in the order of the behaviour; `None` before the first state, and for a friction from the
    /// first state on at which it was not known.
    pub friction: Option<Vec<Option<friction::State<f64>>>>,
    /// The displacements at the beginnings of steps, by the number of the step.
    pub beginnings: Vec<(usize, Components<f64>)>,
}

/// Where velocities come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Velocities {
    /// From the rates of the nodes, as in dynamics.
    #[default]
    Rates,
    /// From increments of displacement over the time between states, as in statics.
    Increments,
}

/// What is known of a state.
#[derive(Clone, Copy, Debug)]
pub struct Kinematics<'a> {
    /// CP.
    pub position: &'a Components<f64>,
    /// CU.
    pub displacement: &'a Components<f64>,
    /// CCU.
    pub constitutive: &'a Components<f64>,
    /// CV.
    pub velocity: &'a Components<f64>,
    /// CA.
    pub acceleration: &'a Components<f64>,
    /// The time.
    pub time: Option<f64>,
    /// Which velocities are meant.
    pub velocities: Velocities,
    /// Whether friction is followed. Where it is not, forces are those without it, and nothing of it is remembered.
    pub slides: bool,
    /// The belt on the other side of the ring at b, where there is one.
    pub beyond: Option<Beyond>,
}

impl<'a> Kinematics<'a> {
    /// What an evaluation knows, where friction is followed and no belt goes on beyond b.
    pub const fn of(evaluation: &'a Evaluation<f64>, time: Option<f64>, velocities: Velocities) -> Self {
        Self {
            position: &evaluation.position,
            displacement: &evaluation.displacement,
            constitutive: &evaluation.constitutive,
            velocity: &evaluation.velocity,
            acceleration: &evaluation.acceleration,
            time,
            velocities,
            slides: true,
            beyond: None,
        }
    }
}

/// Something that happened at a state, or needs care.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The slope of a force jumps here.
    Kink(ForceKink<f64>),
    /// A position lies beyond its stop by so much.
    BeyondStop {
        /// The component (0-based).
        component: usize,
        /// How far.
        by: f64,
    },
    /// A given total force leaves a reaction at a stop that pulls.
    StopPulls {
        /// The component (0-based).
        component: usize,
        /// CRF.
        reaction: f64,
    },
    /// A lock closed.
    Locked {
        /// The component (0-based) whose limit was passed.
        component: usize,
        /// The limit.
        by: Passed,
    },
    /// A failure released components.
    Failed {
        /// The component (0-based) whose limit was passed.
        component: usize,
        /// The limit.
        by: Passed,
    },
    /// A criterion could not be checked.
    Undecided {
        /// The component (0-based).
        component: usize,
        /// Whether it is a failure, else a lock.
        is_failure: bool,
        /// Why.
        why: Unknown,
    },
    /// The total force given for a component that nothing holds differs from the sum of its parts.
    OutOfBalance {
        /// The component (0-based).
        component: usize,
        /// Given minus sum.
        by: f64,
    },
}

/// The behaviour at one state.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// CEF.
    pub elastic: Forces<f64>,
    /// CVF.
    pub viscous: Forces<f64>,
    /// CSF.
    pub friction: Forces<f64>,
    /// Each friction, in the order of the behaviour, then that of a belt; empty where friction is not followed.
    pub slips: Vec<Slip>,
    /// The time since the previous state, where it is known: without one there is no slip rate.
    pub duration: Option<f64>,
    /// CCF.
    pub load: Forces<f64>,
    /// CRF.
    pub reaction: Forces<f64>,
    /// CTF.
    pub total: Forces<f64>,
    /// What is prescribed.
    pub prescribed: Components<Prescribed<f64>>,
    /// What a prescribed motion, a lock or a rigid elasticity enforces to be zero: value, rate and acceleration as far as they are
    /// enforced.
    pub residual: Components<[Option<f64>; 3]>,
    /// CSLST: a stop reached or a lock closed.
    pub held: Components<StopStatus>,
    /// The components that a lock holds.
    pub locked: Mask,
    /// CFAILST.
    pub failed: Mask,
    /// The motion from which forces were taken; velocities that are not known are zero.
    pub motion: Motion<f64>,
    /// The time step of velocities that are increments.
    pub time_step: Option<f64>,
    /// What happened, and what needs care.
    pub events: Vec<Event>,
    /// The history to commit.
    pub history: History,
}

impl Behavior {
    /// The behaviour that a deck gives to a connection type.
    ///
    /// # Errors
    /// Tables out of order or incomplete; a component that is not available; two laws of one kind for one component.
    pub fn new(
        given: &scene::Behavior,
        connection: &ConnectionType,
        is_planar: bool,
        is_explicit: bool,
        characteristic_length: f64,
    ) -> Result<Self, Diagnostic> {
        let friction = friction::of_behavior(given, connection, is_planar, characteristic_length)?;
        let has = |k: usize| !is_planar || matches!(k, 0 | 1 | 5);
        let available = [0, 1, 2, 3, 4, 5].map(|k| has(k) && connection.slots[k].is_available());
        let constrained = [0, 1, 2, 3, 4, 5].map(|k| has(k) && connection.slots[k].is_constrained());
        let stops = given.limits_of_stops().map(|limits| limits.map(|[lower, upper]| Stop { lower, upper }));
        let masks = [available, constrained];
        let defaults = &given.table;
        let locks = given.locks.iter().map(|lock| Criterion::lock(lock, available, defaults));
        let failures =
            given.failures.iter().map(|failure| Criterion::failure(failure, masks, is_explicit, defaults));
        Ok(Self {
            elasticity: Elasticity::new(&given.elasticity, available, defaults)?,
            damping: Damping::new(&given.damping, available, defaults)?,
            locks: locks.collect::<Result<_, _>>()?,
            failures: failures.collect::<Result<_, _>>()?,
            stops,
            available,
            constrained,
            slips: crate::behavior::slide::sliding(&friction, available),
            friction,
            inelastic: inelastic(given, available),
        })
    }

    /// No behaviour: a connection type with its motions and loads alone.
    pub fn none(connection: &ConnectionType, is_planar: bool) -> Self {
        let has = |k: usize| !is_planar || matches!(k, 0 | 1 | 5);
        Self {
            available: [0, 1, 2, 3, 4, 5].map(|k| has(k) && connection.slots[k].is_available()),
            constrained: [0, 1, 2, 3, 4, 5].map(|k| has(k) && connection.slots[k].is_constrained()),
            ..Self::default()
        }
    }

    /// Whether there is nothing that acts or is said of a component.
    pub fn is_empty(&self) -> bool {
        let acts = [self.elasticity.components(), self.damping.components()].as_flattened().contains(&true);
        let acts = acts || [self.slips, self.inelastic].as_flattened().contains(&true);
        !acts && self.locks.is_empty() && self.failures.is_empty() && self.stops.iter().all(Option::is_none)
    }

    /// Whether there is friction.
    pub fn slips_at_all(&self) -> bool {
        !self.friction.frictions.is_empty() || self.friction.belt.is_some()
    }

    /// Whether there is friction that motions alone tell: what presses is no constraint force.
    pub fn tells_friction(&self) -> bool {
        let frictions = self.friction.frictions.iter();
        let mut pressing = frictions.map(|friction| friction.criterion.pressing_components());
        pressing.any(|presses| (0..6).all(|k| !(presses[k] && self.constrained[k])))
    }

    /// Whether a lock or a failure depends on a force.
    pub fn decides_by_force(&self) -> bool {
        self.locks.iter().chain(&self.failures).any(Criterion::needs_force)
    }

    /// The components on which plasticity, damage or a uniaxial behaviour acts, none of which is evaluated.
    pub const fn inelastic(&self) -> Mask {
        self.inelastic
    }

    /// Whether there are stops.
    pub fn has_stops(&self) -> bool {
        self.stops.iter().any(Option::is_some)
    }

    /// The stops (CP: lengths, and angles in radians).
    pub const fn stops(&self) -> &Components<Stop> {
        &self.stops
    }

    /// Whether the history matters: locks, failures, friction, and velocities from increments follow it.
    pub fn has_history(&self) -> bool {
        self.has_history_without_friction() || self.slips_at_all()
    }

    /// Whether the history matters to forces other than friction.
    pub fn has_history_without_friction(&self) -> bool {
        let has_limits = !self.locks.is_empty() || !self.failures.is_empty();
        has_limits || self.damping.components().contains(&true)
    }

    /// The components whose motion the behaviour depends on.
    pub const fn available(&self) -> Mask {
        self.available
    }

    /// The components that the connection type constrains.
    pub const fn constrained(&self) -> Mask {
        self.constrained
    }

    /// The components whose positions stops, locks and failures ask for, or may freeze.
    pub fn limited(&self) -> Mask {
        let criteria = self.locks.iter().chain(&self.failures);
        let mut limited = [0, 1, 2, 3, 4, 5].map(|k| self.stops[k].is_some());
        for criterion in criteria {
            for k in 0..6 {
                limited[k] |= k == criterion.component || criterion.affected[k];
            }
        }
        limited
    }

    /// The behaviour at a state that follows `history`, with the total forces (CTF) that are given.
    pub fn at(
        &self,
        now: &Kinematics<'_>,
        total: &Components<f64>,
        (drives, schedule): (&Drives, &Schedule),
        conditions: &Conditions,
        history: &History,
    ) -> Outcome {
        let mut events = Vec::new();
        // Before the first state the model was at rest in its initial place, at time 0.
        let duration = now.time.map(|time| time - history.time.unwrap_or(0.0)).filter(|step| *step > 0.0);
        let time_step = duration.filter(|_| now.velocities == Velocities::Increments);
        let velocity = self.velocity(now, time_step, history);
        let value = |of: &Components<f64>| of.map(|value| value.unwrap_or(0.0));
        let motion = Motion {
            position: value(now.position),
            constitutive: value(now.constitutive),
            velocity: value(&velocity),
        };
        let mut elastic = self.elasticity.forces(&motion, conditions);
        for k in (0..6).filter(|k| self.inelastic[*k]) {
            (elastic.value[k], elastic.unknown[k]) = (None, Some(Unknown::Inelastic));
        }
        let mut viscous = self.damping.forces(&motion, conditions);
        for k in (0..6).filter(|k| self.damping.components()[*k]) {
            let is_known = (0..6).all(|j| !self.available[j] || velocity[j].is_some());
            if !is_known && viscous.value[k].is_some() {
                (viscous.value[k], viscous.unknown[k]) = (None, Some(Unknown::TimeStep));
            }
        }
        let load = self.loads(drives, schedule, now.time);
        let prescribed = self.prescribed(drives, schedule, now, history);

        let stopped = self.stopped(now.position);
        let locked = history.locked.map(|at| at.is_some());
        let rigid = self.elasticity.rigid();
        let held = [0, 1, 2, 3, 4, 5].map(|k| {
            let at_stop = matches!(stopped[k], Some(StopStatus::AtLower | StopStatus::AtUpper));
            locked[k] || rigid[k] || prescribed[k].is_some() || at_stop
        });
        let pressing = self.pressing(held, total, [&elastic, &viscous], &load, history);
        let friction = now.slides.then(|| self.slide(now, &pressing, duration, &motion, conditions, history));
        // Where friction is not followed, the sums that it is a part of are not known.
        let left_out =
            || Forces { value: [None; 6], unknown: self.slips.map(|is| is.then_some(Unknown::Part)) };
        let (friction, slips) = friction.unwrap_or_else(|| (left_out(), Vec::new()));
        let mut outcome = Outcome {
            elastic,
            viscous,
            friction,
            slips,
            duration,
            load,
            reaction: Forces::none(),
            total: Forces::none(),
            prescribed: prescribed.map(|prescribed| prescribed.map(Prescribed::real)),
            residual: [None; 6],
            held: stopped,
            locked,
            failed: history.failed,
            motion,
            time_step,
            events: Vec::new(),
            history: history.clone(),
        };
        for k in 0..6 {
            self.balance(k, held[k], total[k], &mut outcome, &mut events);
        }
        self.fail(now, conditions, &mut outcome, &mut events);
        self.lock(now, conditions, &mut outcome, &mut events);
        // The total of a component that has failed since is not what it was compared with.
        events.retain(
            |event| !matches!(event, Event::OutOfBalance { component, .. } if outcome.failed[*component]),
        );
        for k in (0..6).filter(|k| !outcome.failed[*k]) {
            outcome.residual[k] = self.residual(k, now, &velocity, prescribed[k], &outcome.history);
            self.check_stop(k, now.position[k], &outcome, &mut events);
            if outcome.locked[k] {
                outcome.held[k] = Some(StopStatus::Locked);
            }
        }
        let is_known = |kink: &ForceKink<f64>| !outcome.failed[kink.component];
        events.extend(self.kinks(&motion, conditions).filter(is_known).map(Event::Kink));

        outcome.history.friction = self.slips_at_all().then(|| {
            outcome
                .slips
                .iter()
                .map(|slip| slip.outcome.as_ref().ok().map(friction::FrictionOutcome::state))
                .collect()
        });
        outcome.history.time = now.time.or(history.time);
        outcome.history.displacement = *now.displacement;
        for step in now.time.into_iter().flat_map(|time| schedule.beginning_at(time)) {
            if outcome.history.beginnings.iter().all(|(known, _)| *known != step) {
                outcome.history.beginnings.push((step, *now.displacement));
            }
        }
        outcome.events = events;
        outcome
    }

    fn velocity(&self, now: &Kinematics<'_>, time_step: Option<f64>, history: &History) -> Components<f64> {
        match now.velocities {
            Velocities::Rates => *now.velocity,
            Velocities::Increments => [0, 1, 2, 3, 4, 5].map(|k| {
                let change = now.displacement[k]? - history.displacement[k].unwrap_or(0.0);
                // What has not moved has no velocity, however long that took.
                if change == 0.0 { Some(0.0) } else { Some(change / time_step?) }
            }),
        }
    }

    fn loads(&self, drives: &Drives, schedule: &Schedule, time: Option<f64>) -> Forces<f64> {
        let mut forces = Forces::none();
        for k in (0..6).filter(|k| self.available[*k]) {
            match drives.loads[k].as_ref().map(|drive| drive.load(schedule, time)) {
                Some(Ok(load)) => forces.value[k] = Some(load),
                Some(Err(unknown)) => forces.unknown[k] = Some(unknown),
                None => {}
            }
        }
        forces
    }

    fn prescribed(
        &self,
        drives: &Drives,
        schedule: &Schedule,
        now: &Kinematics<'_>,
        history: &History,
    ) -> Components<Prescribed<Dual2_64>> {
        let time = now.time.map(|time| Dual2_64::new(time, 1.0, 0.0));
        [0, 1, 2, 3, 4, 5].map(|k| {
            let drive = drives.motions[k].as_ref().filter(|_| self.available[k])?;
            drive.at(schedule, time, |step| {
                let found = history.beginnings.iter().find(|(known, _)| *known == step);
                found.and_then(|(_, displacement)| displacement[k])
            })
        })
    }

    /// Whether stops are reached.
    fn stopped(&self, position: &Components<f64>) -> Components<StopStatus> {
        [0, 1, 2, 3, 4, 5].map(|k| Some(StopStatus::at(&self.stops[k]?, position[k]?)))
    }

    /// CRF and CTF of component k: the reaction is what a given total force leaves.
    fn balance(
        &self,
        k: usize,
        is_held: bool,
        given: Option<f64>,
        outcome: &mut Outcome,
        events: &mut Vec<Event>,
    ) {
        if outcome.failed[k] || !(self.available[k] || self.constrained[k]) {
            return;
        }
        if self.constrained[k] {
            (outcome.reaction.value[k], outcome.total.value[k]) = (given, given);
            if given.is_none() {
                (outcome.reaction.unknown[k], outcome.total.unknown[k]) =
                    (Some(Unknown::Reaction), Some(Unknown::Reaction));
            }
            return;
        }
        let parts = [&outcome.elastic, &outcome.viscous, &outcome.friction];
        let rigid = self.elasticity.rigid()[k];
        let is_missing = parts.iter().any(|part| part.unknown[k].is_some_and(|why| why != Unknown::Rigid));
        let missing =
            is_missing || outcome.load.unknown[k].is_some() || outcome.friction.unknown[k].is_some();
        let sum: f64 =
            parts.iter().filter_map(|part| part.value[k]).sum::<f64>() - outcome.load.value[k].unwrap_or(0.0);
        let scale: f64 =
            parts.iter().chain(&[&outcome.load]).filter_map(|part| part.value[k]).map(f64::abs).sum();
        // Where nothing in the model acts, the force given comes from outside of it.
        let acts = parts
            .iter()
            .chain(&[&outcome.load])
            .any(|part| part.value[k].is_some() || part.unknown[k].is_some());
        let (total, reaction) = match (is_held, given) {
            (false, Some(given)) if !acts => (Ok(given), Ok(0.0)),
            _ if missing => (given.ok_or(Unknown::Part), Err(Unknown::Part)),
            (true, Some(given)) => (Ok(given), Ok(given - sum)),
            (true, None) => (Err(Unknown::Reaction), Err(Unknown::Reaction)),
            (false, _) => (Ok(sum), Ok(0.0)),
        };
        if let (false, false, true, Some(given)) = (is_held, missing, acts, given)
            && (given - sum).abs() > PRINTED * (given.abs() + scale)
        {
            events.push(Event::OutOfBalance { component: k, by: given - sum });
        }
        (outcome.total.value[k], outcome.total.unknown[k]) = (total.ok(), total.err());
        // What keeps a rigid elasticity at its reference is its elastic force.
        if rigid
            && matches!(outcome.held[k], None | Some(StopStatus::Free))
            && !outcome.locked[k]
            && outcome.prescribed[k].is_none()
        {
            (outcome.elastic.value[k], outcome.elastic.unknown[k]) =
                (reaction.ok(), reaction.err().map(|_| Unknown::Rigid));
            outcome.reaction.value[k] = Some(0.0);
        } else {
            (outcome.reaction.value[k], outcome.reaction.unknown[k]) = (reaction.ok(), reaction.err());
        }
    }

    fn fail(
        &self,
        now: &Kinematics<'_>,
        conditions: &Conditions,
        outcome: &mut Outcome,
        events: &mut Vec<Event>,
    ) {
        for criterion in &self.failures {
            let component = criterion.component;
            if (0..6).all(|k| !criterion.affected[k] || outcome.failed[k]) {
                continue;
            }
            match criterion.check(now.position, &outcome.total.value, conditions) {
                Verdict::Met(by) => {
                    events.push(Event::Failed { component, by });
                    for k in (0..6).filter(|k| criterion.affected[*k]) {
                        outcome.failed[k] = true;
                    }
                }
                Verdict::NotMet => {}
                Verdict::Undecided(why) => events.push(Event::Undecided { component, is_failure: true, why }),
            }
        }
        // The forces of released components vanish in the increment of the failure.
        for k in (0..6).filter(|k| outcome.failed[*k]) {
            let parts = [
                &mut outcome.elastic,
                &mut outcome.viscous,
                &mut outcome.friction,
                &mut outcome.load,
                &mut outcome.reaction,
                &mut outcome.total,
            ];
            for part in parts {
                let was_there = part.value[k].is_some() || part.unknown[k].is_some();
                (part.value[k], part.unknown[k]) = (was_there.then_some(0.0), None);
            }
            outcome.total.value[k] = Some(0.0);
            outcome.reaction.value[k] = Some(0.0);
            outcome.prescribed[k] = None;
            outcome.locked[k] = false;
            outcome.history.locked[k] = None;
            outcome.held[k] = outcome.held[k].map(|_| StopStatus::Free);
        }
        outcome.history.failed = outcome.failed;
    }

    fn lock(
        &self,
        now: &Kinematics<'_>,
        conditions: &Conditions,
        outcome: &mut Outcome,
        events: &mut Vec<Event>,
    ) {
        for criterion in &self.locks {
            let component = criterion.component;
            let remains = |k: usize| criterion.affected[k] && !outcome.locked[k] && !outcome.failed[k];
            let remaining = [0, 1, 2, 3, 4, 5].map(remains);
            if !remaining.contains(&true) {
                continue;
            }
            match criterion.check(now.position, &outcome.total.value, conditions) {
                Verdict::Met(by) => {
                    events.push(Event::Locked { component, by });
                    for k in (0..6).filter(|k| remaining[*k]) {
                        outcome.locked[k] = true;
                        outcome.history.locked[k] = now.position[k];
                    }
                }
                Verdict::NotMet => {}
                Verdict::Undecided(why) => {
                    events.push(Event::Undecided { component, is_failure: false, why })
                }
            }
        }
    }

    /// What holds component k, to be zero: a lock, else a prescribed motion, else a rigid elasticity.
    fn residual(
        &self,
        k: usize,
        now: &Kinematics<'_>,
        velocity: &Components<f64>,
        prescribed: Option<Prescribed<Dual2_64>>,
        history: &History,
    ) -> Option<[Option<f64>; 3]> {
        let rates = [velocity[k], now.acceleration[k]];
        if let (Some(at), Some(position)) = (history.locked[k], now.position[k]) {
            return Some([Some(position - at), rates[0], rates[1]]);
        }
        match prescribed {
            Some(Prescribed::Displacement(wanted)) => {
                let minus = |value: Option<f64>, wanted: f64| value.map(|value| value - wanted);
                Some([
                    minus(now.displacement[k], wanted.re),
                    minus(rates[0], wanted.v1),
                    minus(rates[1], wanted.v2),
                ])
            }
            Some(Prescribed::Velocity(wanted)) => {
                Some([None, rates[0].map(|rate| rate - wanted.re), rates[1].map(|second| second - wanted.v1)])
            }
            Some(Prescribed::Acceleration(wanted)) => {
                Some([None, None, rates[1].map(|second| second - wanted.re)])
            }
            Some(Prescribed::Unknown(..)) => None,
            None if self.elasticity.rigid()[k] => Some([now.constitutive[k], rates[0], rates[1]]),
            None => None,
        }
    }

    fn check_stop(&self, k: usize, position: Option<f64>, outcome: &Outcome, events: &mut Vec<Event>) {
        let (Some(stop), Some(position), Some(status)) = (self.stops[k], position, outcome.held[k]) else {
            return;
        };
        let (limit, sign) = match status {
            StopStatus::Free | StopStatus::Locked => return,
            StopStatus::AtLower => (stop.lower, -1.0),
            StopStatus::AtUpper => (stop.upper, 1.0),
        };
        let by = limit.map_or(0.0, |limit: f64| sign * (position - limit));
        if by > 0.0 {
            events.push(Event::BeyondStop { component: k, by });
        }
        // At the upper stop the reaction resists growth: it is positive.
        let is_alone = !outcome.locked[k] && outcome.prescribed[k].is_none();
        if let Some(reaction) = outcome.reaction.value[k]
            && is_alone
            && sign * reaction < 0.0
        {
            events.push(Event::StopPulls { component: k, reaction });
        }
    }
}

/// The components on which plasticity, damage or a uniaxial behaviour acts: a coupled one acts on all available ones.
fn inelastic(given: &scene::Behavior, available: Mask) -> Mask {
    let mut mask = [false; 6];
    let uniaxial = given.uniaxial.iter().copied().map(Some);
    let plastic = given.plasticity.iter().map(|plasticity| plasticity.component).chain(uniaxial);
    // Without an evolution damage stays 0.
    let evolving =
        given.damage.iter().filter_map(|damage| Some((damage.component, damage.evolution.as_ref()?)));
    let mut damaged = Vec::new();
    for (component, evolution) in evolving {
        damaged.extend(evolution.affected.iter().copied().map(Some));
        if evolution.affected.is_empty() {
            damaged.push(component);
        }
    }
    for component in plastic.chain(damaged) {
        match component {
            Some(component) => add(&mut mask, component),
            None => mask = available,
        }
    }
    mask
}

fn add(mask: &mut Mask, component: u8) {
    if let Some(place) = mask.get_mut(usize::from(component).wrapping_sub(1)) {
        *place = true;
    }
}

impl Prescribed<Dual2_64> {
    /// Without the time derivatives.
    pub(crate) const fn real(self) -> Prescribed<f64> {
        match self {
            Self::Displacement(value) => Prescribed::Displacement(value.re),
            Self::Velocity(value) => Prescribed::Velocity(value.re),
            Self::Acceleration(value) => Prescribed::Acceleration(value.re),
            Self::Unknown(kind, unknown) => Prescribed::Unknown(kind, unknown),
        }
    }
}

impl Prescribed<f64> {
    /// The value, and what it is of.
    pub const fn value(self) -> (MotionType, Option<f64>) {
        match self {
            Self::Displacement(value) => (MotionType::Displacement, Some(value)),
            Self::Velocity(value) => (MotionType::Velocity, Some(value)),
            Self::Acceleration(value) => (MotionType::Acceleration, Some(value)),
            Self::Unknown(kind, _) => (kind, None),
        }
    }
}
