//! What does a value, a Jacobian or a Hessian cost here, and at which error?
//!
//! A type ([`Subject`]) is measured at states far from its singular points, near them and at rest ([`Proximity`]), with every way to get the numbers
//! ([`Method`]). The library has such ways ([`Way`]), and the caller may bring others. The truth is the 237-bit scalar: values by it,
//! derivatives by differences on it that have no step to tune. Errors come first: those of every way must be within what they come from allows
//! ([`Cause`]). One of pintle's own that is not is told as wrong ([`Wrong`]), any other way is listed ([`Untimed`]), and neither is timed or
//! drawn. Then rounds take turns, and of each way the least time counts, so that a machine with other work on it disturbs all alike.
//!
//! ```
//! use pintle_bench::{Order, Settings, measure};
//! use pintle_kinematics::catalog::ConnectionType;
//!
//! let settings = Settings { rounds: 1, states: 1, ..Settings::default() };
//! let report = measure(&settings, &[ConnectionType::named("SLIDE-PLANE", None)?], &|_| {});
//! assert!(report.wrong.is_empty());
//! let ours = report.points.iter().find(|point| point.method == "pintle" && point.order == Order::Jacobian);
//! assert!(ours.is_some_and(|point| point.largest_error < 1e-14 && point.nanoseconds > 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod batch;
mod bound;
mod environment;
mod method;
mod place;
mod subject;

pub use batch::{Rows, Tiles};
pub use bound::Cause;
pub use environment::Environment;
pub use method::{Method, Prepared, Way};
pub use place::{CLEAR, Proximity, REST, Unmeasured};
pub use subject::{Element, Order, Subject, worse};

/// The commit of its repository that a release of this crate was built from, with a mark where its sources had changes. A build for
/// development (debug) has none, nor has a crate from a registry.
pub const COMMIT: Option<&str> = option_env!("PINTLE_COMMIT");

/// The packages that the numbers rest on, with their versions.
pub const NUMBERS: &str = env!("PINTLE_NUMBERS");

use pintle_kinematics::catalog::{COMPONENT, ConnectionType};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// The version of a report's form.
pub const SCHEMA: &str = "pintle-bench/1";

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Rounds, in which every way takes its turn.
    pub rounds: usize,
    /// States of each type and place.
    pub states: usize,
    /// How many elements a way that takes batches goes through, the states over and over; no fewer than there are states.
    pub batch: usize,
    /// How far the states near a singular point are from it (rad, or lengths of the connector).
    pub distance: f64,
    /// How long a way is repeated in a round; once in any case.
    pub budget: Duration,
}

impl Default for Settings {
    fn default() -> Self {
        Self { rounds: 8, states: 16, batch: 0, distance: 1e-4, budget: Duration::from_millis(1) }
    }
}

/// What one way costs, at which error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The connection type.
    pub connection: String,
    /// Which states.
    pub place: Proximity,
    /// What is computed.
    pub order: Order,
    /// The way.
    pub method: Cow<'static, str>,
    /// Its step, of a way that has one.
    pub step: Option<f64>,
    /// The vector unit that it ran on, of a way that has several states in its lanes.
    #[serde(default)]
    pub vector_unit: Option<Cow<'static, str>>,
    /// The error of the median state: the largest of its entries' ([`Subject::errors`]).
    #[serde(deserialize_with = "or_infinite")]
    pub median_error: f64,
    /// The error of the worst state.
    #[serde(deserialize_with = "or_infinite")]
    pub largest_error: f64,
    /// The least time of one state, all rows (ns).
    #[serde(deserialize_with = "or_infinite")]
    pub nanoseconds: f64,
    /// The least time of the slowest round: how noisy the machine was.
    pub slowest_round: f64,
    /// The components whose rows are computed: `u1`.
    #[serde(default)]
    pub rows: Vec<Cow<'static, str>>,
    /// The components that have rows which are not: one-forms, which are no functions of the nodes.
    #[serde(default)]
    pub left_out: Vec<Cow<'static, str>>,
}

/// JSON has no infinity: it is null there.
fn or_infinite<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::INFINITY))
}

impl Point {
    /// Whether another point is one of the same diagram.
    pub fn is_beside(&self, other: &Self) -> bool {
        (&self.connection, self.place, self.order) == (&other.connection, other.place, other.order)
    }
}

/// A type that is not measured at a place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Omitted {
    /// The type.
    pub connection: String,
    /// Which states.
    pub place: Proximity,
    /// Why.
    pub why: Cow<'static, str>,
}

/// A way that is not timed for a type at a place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Untimed {
    /// The type.
    pub connection: String,
    /// Which states.
    pub place: Proximity,
    /// What is computed.
    pub order: Order,
    /// The way.
    pub method: Cow<'static, str>,
    /// Why.
    pub why: Cow<'static, str>,
}

/// What was measured, where and when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: Cow<'static, str>,
    /// The machine and the program.
    pub environment: Environment,
    /// Rounds that took turns.
    pub rounds: usize,
    /// States of each type and place.
    pub states: usize,
    /// How many elements ways that take batches went through: the states over and over.
    pub batch: usize,
    /// How far the states near a singular point are from it (rad, or lengths of the connector).
    pub distance: f64,
    /// A point for each type, place, order, way and step.
    pub points: Vec<Point>,
    /// What could not be measured.
    pub omitted: Vec<Omitted>,
    /// Ways of others that are wrong somewhere, and ways that do not exist.
    pub untimed: Vec<Untimed>,
    /// Where pintle's own numbers are not those of the 237-bit scalar.
    #[serde(default)]
    pub wrong: Vec<Wrong>,
}

/// pintle's own numbers are not right, so that their time means nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error(
    "{connection}, {}: {} of {method} is wrong: the error is {error:.1e} where {bound:.1e} is allowed; its time would mean nothing",
    place.name(), order.name()
)]
pub struct Wrong {
    /// The type.
    pub connection: String,
    /// Which states.
    pub place: Proximity,
    /// What is wrong.
    pub order: Order,
    /// The way.
    pub method: Cow<'static, str>,
    /// The error that is the farthest beyond what is allowed, as [`Subject::errors`] tells it.
    #[serde(deserialize_with = "or_infinite")]
    pub error: f64,
    /// The error allowed there.
    #[serde(deserialize_with = "or_infinite")]
    pub bound: f64,
}

/// Measures types with every way that the library has; `progress` is told the name of each type that is prepared.
pub fn measure(settings: &Settings, types: &[ConnectionType], progress: &dyn Fn(&str)) -> Report {
    let mut report = Report::new(settings);
    let ways = Way::all();
    let methods: Vec<&dyn Method> = ways.iter().map(|way| way as &dyn Method).collect();
    for connection in types {
        progress(&connection.name);
        let subjects: Vec<Subject> = report.subjects(settings, connection);
        let mut session = Session::new(settings, &subjects, &methods);
        (0..settings.rounds).for_each(|_| drop(session.round()));
        report.take(&session);
    }
    report
}

impl Report {
    /// Without points.
    pub fn new(settings: &Settings) -> Self {
        let Settings { rounds, states, batch, distance, .. } = *settings;
        Self {
            schema: SCHEMA.into(),
            environment: Environment::here(),
            rounds,
            states,
            batch: batch.max(states),
            distance,
            points: Vec::new(),
            omitted: Vec::new(),
            untimed: Vec::new(),
            wrong: Vec::new(),
        }
    }

    /// What a session has found.
    pub fn take(&mut self, session: &Session<'_>) {
        self.points.extend(session.points());
        self.untimed.extend_from_slice(session.untimed());
        self.wrong.extend_from_slice(session.wrong());
    }

    /// A type at all places; says where it cannot be measured.
    pub fn subjects(&mut self, settings: &Settings, connection: &ConnectionType) -> Vec<Subject> {
        let mut found = Vec::new();
        for place in Proximity::ALL {
            match Subject::new(connection, place, settings.states, settings.distance) {
                Ok(subject) => found.push(subject.repeated(settings.batch)),
                Err(why) => self.omitted.push(Omitted {
                    connection: connection.name.to_string(),
                    place,
                    why: why.to_string().into(),
                }),
            }
        }
        found
    }
}

/// Ways whose errors are known, timed round by round. Room for numbers is made for one way at a time: what is held between two turns does
/// not grow with the number of ways.
pub struct Session<'s> {
    trials: Vec<Trial<'s>>,
    untimed: Vec<Untimed>,
    wrong: Vec<Wrong>,
    budget: Duration,
}

impl<'s> Session<'s> {
    /// Every method for every subject, as far as its errors are within their bounds, of a sweep of steps those of the best.
    pub fn new(settings: &Settings, subjects: &'s [Subject], methods: &[&'s dyn Method]) -> Self {
        let (mut trials, mut untimed, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
        for subject in subjects {
            let from = trials.len();
            for method in methods {
                match method.prepare(subject) {
                    Ok(prepared) => trials.push(Trial::new(settings, subject, *method, prepared)),
                    Err(why) => untimed.push(Untimed::new(subject, *method, why.into())),
                }
            }
            let of_subject = trials.split_off(from);
            for trial in &of_subject {
                let sweep = of_subject.iter().filter(|other| other.is_of_sweep(trial));
                let best =
                    sweep.map(|other| other.judged).min_by(|a, b| (a[0] / a[1]).total_cmp(&(b[0] / b[1])));
                let [error, bound] = best.unwrap_or(trial.judged);
                if error <= bound {
                    trials.push(trial.clone());
                    continue;
                }
                let (method, order) = (trial.method, trial.point.order);
                if method.cause() == Cause::Ours {
                    let connection = subject.connection.name.to_string();
                    let place = subject.place;
                    wrong.push(Wrong {
                        connection,
                        place,
                        order,
                        method: method.name().into(),
                        error,
                        bound,
                    });
                    continue;
                }
                let why = format!("its error is {error:.1e} where {bound:.1e} is allowed");
                let of = Untimed::new(subject, method, why.into());
                if !untimed.contains(&of) {
                    untimed.push(of);
                }
            }
        }
        Self { trials, untimed, wrong, budget: settings.budget }
    }

    /// Where pintle's own numbers are not right.
    pub fn wrong(&self) -> &[Wrong] {
        &self.wrong
    }

    /// The ways of others that are not timed.
    pub fn untimed(&self) -> &[Untimed] {
        &self.untimed
    }

    /// Times each way once; the times of this round (ns per state), in the order of the points.
    pub fn round(&mut self) -> Vec<f64> {
        let mut times: Vec<f64> = Vec::with_capacity(self.trials.len());
        for i in 0..self.trials.len() {
            let (before, rest) = self.trials.split_at_mut(i);
            let Some(trial) = rest.first_mut() else { continue };
            // Ways that differ in their steps alone take the same time.
            let same = before.last().filter(|known| {
                let (point, known) = (&trial.point, &known.point);
                point.step.is_some() && known.is_beside(point) && known.method == point.method
            });
            let time = match (same, times.last()) {
                (Some(_), Some(time)) => *time,
                _ => trial.time(self.budget),
            };
            trial.take(time);
            times.push(time);
        }
        times
    }

    /// What is known after the rounds up to now.
    pub fn points(&self) -> Vec<Point> {
        self.trials.iter().map(|trial| trial.point.clone()).collect()
    }
}

impl Untimed {
    fn new(subject: &Subject, method: &dyn Method, why: Cow<'static, str>) -> Self {
        Self {
            connection: subject.connection.name.to_string(),
            place: subject.place,
            order: method.order(),
            method: method.name().into(),
            why,
        }
    }
}

/// The names of components (0-based).
fn named(components: &[usize]) -> Vec<Cow<'static, str>> {
    components.iter().filter_map(|k| COMPONENT.get(*k)).map(|name| Cow::Borrowed(*name)).collect()
}

/// One way for one subject.
#[derive(Clone)]
struct Trial<'s> {
    point: Point,
    /// The error by which it is judged, and the largest that is allowed there.
    judged: [f64; 2],
    subject: &'s Subject,
    method: &'s dyn Method,
}

impl<'s> Trial<'s> {
    fn new(
        settings: &Settings,
        subject: &'s Subject,
        method: &'s dyn Method,
        mut prepared: Box<dyn Prepared + 's>,
    ) -> Self {
        prepared.run();
        let (order, numbers) = (method.order(), prepared.numbers());
        let [median_error, largest_error] = subject.errors(order, &numbers);
        let (place, distance) = (subject.place, subject.place.distance(settings.distance));
        let judged = match method.cause().bound(order, place, distance) {
            Some(bound) => [largest_error, bound],
            None => subject.beyond_rounding(order, &numbers),
        };
        let point = Point {
            connection: subject.connection.name.to_string(),
            place: subject.place,
            order,
            method: method.name().into(),
            step: method.step(),
            vector_unit: method.vector_unit().map(Into::into),
            median_error,
            largest_error,
            nanoseconds: f64::INFINITY,
            slowest_round: 0.0,
            rows: named(&subject.components),
            left_out: named(&subject.left_out),
        };
        Self { point, judged, subject, method }
    }

    /// Whether another way differs in its step alone, if at all.
    fn is_of_sweep(&self, other: &Self) -> bool {
        let (own, other) = (&self.point, &other.point);
        own.is_beside(other) && own.method == other.method && own.step.is_some() == other.step.is_some()
    }

    /// The least time of a state, ns. The first run, into memory that is new, is not timed.
    fn time(&self, budget: Duration) -> f64 {
        let Ok(mut prepared) = self.method.prepare(self.subject) else { return f64::INFINITY };
        prepared.run();
        let (begin, mut least) = (Instant::now(), f64::INFINITY);
        loop {
            let start = Instant::now();
            black_box(&mut prepared).run();
            least = least.min(start.elapsed().as_secs_f64());
            if begin.elapsed() >= budget {
                return 1e9 * least / prepared.states() as f64;
            }
        }
    }

    fn take(&mut self, time: f64) {
        self.point.nanoseconds = self.point.nanoseconds.min(time);
        self.point.slowest_round = self.point.slowest_round.max(time);
    }
}
