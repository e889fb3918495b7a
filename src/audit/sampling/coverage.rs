//! Which region of configuration space was exercised? A suite that saw only the neighbourhood of the initial state proves nothing
//! about the rest: most errors in terms of rotation vanish there.
//!
//! ```
//! use pintle_audit::Coverage;
//! use pintle_kinematics::catalog::ConnectionType;
//! use pintle_kinematics::connector::{Definition, State};
//! use pintle_kinematics::node::{DOFS, Node, Pair};
//! use pintle_scene::Code;
//! use pintle_kinematics::{so3, vector};
//!
//! let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
//! let initial = Pair { reference: [1.0, 0.0, 0.0], a: node(vector::identity()), b: node(vector::identity()) };
//! let definition = Definition::new(ConnectionType::named("CARTESIAN", Some("CARDAN"))?, initial);
//! let mut coverage = Coverage::default();
//! for i in 0..100 {
//!     let turn = so3::matrix(so3::exp_quaternion([1e-4 * f64::from(i), 0.0, 0.0]));
//!     let pair = Pair { b: node(turn), ..initial };
//!     coverage.add(&definition, &State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }, 1.0);
//! }
//! let codes: Vec<Code> = coverage.gaps().iter().map(|gap| gap.code).collect();
//! assert_eq!(codes, [Code::CoverageIdentity]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use pintle_kinematics::connector::{Connector, Definition, Increment, Output, Request, State, Tally};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{self, Matrix};
use pintle_scene::Code;
use pintle_scene::grammar::count;
use pintle_scene::grammar::number as short;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// The edges between bins of angles (rad).
pub const ANGLES: [f64; 11] = [0.0, 1e-6, 1e-3, 0.01, 0.1, 0.5, 1.0, FRAC_PI_2, 2.0, 3.0, PI + 1e-9];
/// The edges between bins of lengths, as ratios of the distance of the nodes to their initial one.
pub const STRETCHES: [f64; 9] = [0.0, 0.5, 0.9, 0.99, 0.999_999, 1.000_001, 1.01, 1.1, 2.0];
/// The edges between bins of distances to singular sets (rad, or lengths of the connector).
pub const MARGINS: [f64; 7] = [0.0, 1e-12, 1e-8, 1e-4, 0.05, 0.5, 1.0];

/// How often a quantity was in which bin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// What is counted.
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Where bins begin: the first bin is from `edges[0]` to below `edges[1]`, the last from the last edge on.
    pub edges: Vec<f64>,
    /// The number of samples in each bin.
    pub counts: Vec<u64>,
    /// The largest sample.
    pub largest: f64,
}

impl Histogram {
    fn new(quantity: &'static str, unit: &'static str, edges: &[f64]) -> Self {
        Self { quantity, unit, edges: edges.to_vec(), counts: vec![0; edges.len()], largest: 0.0 }
    }

    fn add(&mut self, sample: f64) {
        let bin = self.edges.iter().rposition(|edge| *edge <= sample);
        if let Some(count) = bin.and_then(|bin| self.counts.get_mut(bin)) {
            *count += 1;
            self.largest = self.largest.max(sample);
        }
    }

    /// The number of samples.
    pub fn samples(&self) -> u64 {
        self.counts.iter().sum()
    }
}

/// What the states of a suite exercised.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// |log(A A₀ᵀ)|: how far a was turned from its initial orientation, where it has rotations.
    pub rotation_a: Histogram,
    /// The same of b.
    pub rotation_b: Histogram,
    /// |log(Q Q₀ᵀ)|: how far b was turned relative to a, where either has rotations.
    pub relative_rotation: Histogram,
    /// |d|/|d₀|, where the nodes are apart initially.
    pub stretch: Histogram,
    /// The distance to the nearest singular set of any component.
    pub margin: Histogram,
    /// What of it tells formulas apart.
    #[serde(flatten)]
    pub exercise: Exercise,
}

/// By how much the states of one connector, or of many, leave the initial one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Exercise {
    /// The number of states of connectors, each connector at each state, but for those whose nodes stand still.
    pub samples: u64,
    /// The number of states of connectors whose nodes stand still, which are counted in nothing else.
    pub standing: u64,
    /// Samples in which both nodes were turned, each by more than 0.1 rad.
    pub both_turned: u64,
    /// Samples of connectors both of whose nodes have rotations, of which nothing is known to hold one.
    pub could_turn_both: u64,
    /// Samples in which a component that is free to move was displaced by more than 1e-6 rad or lengths.
    pub deformed: u64,
    /// Samples of connectors that have such components.
    pub could_deform: u64,
    /// Samples outside of the neighbourhood of the initial state: turned by more than 0.1 rad, or displaced by more than 0.05 lengths.
    pub away: u64,
    /// The largest rotation of a node (rad), where one has rotations.
    pub largest_rotation: Option<f64>,
    /// The largest relative rotation (rad), of connectors that leave one free, unless both nodes are held.
    pub largest_relative_rotation: Option<f64>,
    /// The largest relative displacement of the nodes, in lengths of the connector.
    pub largest_displacement: f64,
}

/// One connector at one state.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// How far each node was turned (rad), where it has rotations.
    rotations: [Option<f64>; 2],
    /// How far b was turned relative to a (rad).
    relative: f64,
    /// Whether a component that is an angle is free.
    turns_freely: bool,
    /// |d|/|d₀|, where the nodes are apart initially.
    stretch: Option<f64>,
    /// The distance to the nearest singular set.
    margin: Option<f64>,
    /// Whether a free component was displaced; `None` where there is none.
    deformed: Option<bool>,
    /// The relative displacement of the nodes, in lengths of the connector.
    displacement: f64,
    /// Whether either node was moved or turned.
    moves: bool,
    /// Whether something holds each node from turning.
    held: [bool; 2],
    /// Whether something holds both nodes from moving.
    stands: bool,
}

impl Default for Coverage {
    fn default() -> Self {
        Self {
            rotation_a: Histogram::new("rotation of a", "rad", &ANGLES),
            rotation_b: Histogram::new("rotation of b", "rad", &ANGLES),
            relative_rotation: Histogram::new("relative rotation", "rad", &ANGLES),
            stretch: Histogram::new("distance / initial distance", "", &STRETCHES),
            margin: Histogram::new("distance to a singular set", "rad or lengths", &MARGINS),
            exercise: Exercise::default(),
        }
    }
}

/// What a suite lacks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Lack {
    /// The code.
    pub code: Code,
    /// What, in a sentence.
    pub message: String,
    /// What to do.
    pub remedy: &'static str,
}

/// Displacements, in lengths of the connector, below which a state is in the neighbourhood of the initial one.
const NEIGHBOURHOOD: f64 = 0.05;
/// An angle that tells formulas apart: its sine differs from it by 2e-4, and its cosine from 1 by 5e-3.
const TURNED: f64 = 0.1;
/// A displacement that is more than rounding.
const DISPLACED: f64 = 1e-6;

/// The angle of a rotation from one triad to another.
fn angle(now: &Matrix<f64>, before: &Matrix<f64>) -> f64 {
    norm(so3::log(&vector::product(now, &vector::transpose(before))))
}

impl Sample {
    /// A connector at a state. What lengths are compared with is the initial distance of the nodes; where they coincide, but for
    /// rounding, it is `length`: the connector's own ([`Case::length`](crate::Case::length)), or one that is typical of the model.
    pub fn of(connector: &Connector<f64>, definition: &Definition, state: &State<f64>, length: f64) -> Self {
        /// What is shorter than this part of the connector's own length is a coincidence with rounding.
        const COINCIDENT: f64 = 1e-9;
        let (initial, pair) = (&definition.initial, &state.pair);
        let turns = [0, 1].map(|end| definition.moves[end] && definition.rotates[end]);
        let angles = [angle(&pair.a.triad, &initial.a.triad), angle(&pair.b.triad, &initial.b.triad)];
        let [before, now] = [initial, pair].map(pintle_kinematics::node::Pair::relative);
        let (apart, distance) = (norm(initial.reference), norm(pair.separation()));
        let is_apart = apart > COINCIDENT * length;
        let size = if is_apart { apart } else { length };
        let request = Request::new(&[Output::CU], [true; 6], 0);
        let (branch, mut tally) = (connector.initial_branch(), Tally::default());
        let result = connector.evaluate(state, &Increment::none(), &branch, &request, &mut tally);
        let margins = connector.margins(state, &branch, [true; 6]).into_iter().flatten();
        let margin = margins
            .map(|margin| margin.distance / if margin.set.unit == Unit::Length { size } else { 1.0 })
            .reduce(f64::min);
        let free: Vec<usize> = (0..6)
            .filter(|k| connector.position_measure(*k).is_some() && !connector.is_constrained(*k))
            .collect();
        let is_length =
            |k: usize| connector.position_measure(k).is_some_and(|measure| measure.unit() == Unit::Length);
        let moved = |k: &usize| {
            let size = if is_length(*k) { size } else { 1.0 };
            result.displacement[*k].is_some_and(|u| u.abs() > DISPLACED * size)
        };
        Self {
            rotations: [0, 1].map(|end| turns[end].then_some(angles[end])),
            relative: angle(&now.q, &before.q),
            turns_freely: free.iter().any(|k| !is_length(*k)),
            stretch: is_apart.then_some(distance / apart),
            margin,
            deformed: (!free.is_empty()).then(|| free.iter().any(moved)),
            displacement: norm(vector::sub(pair.b.displacement, pair.a.displacement)) / size,
            moves: [pair.a, pair.b].iter().any(|node| norm(node.displacement) > DISPLACED * size)
                || angles.iter().any(|angle| *angle > DISPLACED),
            held: [false; 2],
            stands: false,
        }
    }

    /// The same where something holds an end from turning, or both from moving: what cannot be is not asked for. A state that turns or moves them
    /// all the same, to exercise the connector, asks for the rest.
    #[must_use]
    pub fn held(self, ends: [bool; 2], stands: bool) -> Self {
        let is_turned = |end: usize| self.rotations[end].is_some_and(|angle| angle > DISPLACED);
        Self { held: [0, 1].map(|end| ends[end] && !is_turned(end)), stands: stands && !self.moves, ..self }
    }
}

impl Exercise {
    /// Whether there was no state of a connector.
    pub fn is_empty(&self) -> bool {
        self.samples + self.standing == 0
    }

    /// Counts a sample.
    pub fn add(&mut self, sample: &Sample) {
        let turned = |angle: Option<f64>| angle.is_some_and(|angle| angle > TURNED);
        let [a, b] = sample.rotations;
        let rotation = a.into_iter().chain(b).reduce(f64::max);
        let relative = rotation.map(|_| sample.relative);
        let is_away = turned(a) || turned(b) || turned(relative) || sample.displacement > NEIGHBOURHOOD;
        if sample.stands {
            self.standing += 1;
            return;
        }
        let free = relative.filter(|_| sample.turns_freely && sample.held != [true; 2]);
        self.samples += 1;
        if sample.rotations.iter().zip(sample.held).all(|(angle, is_held)| angle.is_some() && !is_held) {
            self.could_turn_both += 1;
            self.both_turned += u64::from(turned(a) && turned(b));
        }
        if let Some(deformed) = sample.deformed {
            self.could_deform += 1;
            self.deformed += u64::from(deformed);
        }
        self.away += u64::from(is_away);
        // A maximum of what is not there is what is there.
        self.largest_rotation = self.largest_rotation.into_iter().chain(rotation).reduce(f64::max);
        self.largest_relative_rotation =
            self.largest_relative_rotation.into_iter().chain(free).reduce(f64::max);
        self.largest_displacement = self.largest_displacement.max(sample.displacement);
    }

    /// The same of several connectors together.
    #[must_use]
    pub fn with(self, other: &Self) -> Self {
        let most = |x: Option<f64>, y: Option<f64>| x.into_iter().chain(y).reduce(f64::max);
        Self {
            samples: self.samples + other.samples,
            standing: self.standing + other.standing,
            both_turned: self.both_turned + other.both_turned,
            could_turn_both: self.could_turn_both + other.could_turn_both,
            deformed: self.deformed + other.deformed,
            could_deform: self.could_deform + other.could_deform,
            away: self.away + other.away,
            largest_rotation: most(self.largest_rotation, other.largest_rotation),
            largest_relative_rotation: most(self.largest_relative_rotation, other.largest_relative_rotation),
            largest_displacement: self.largest_displacement.max(other.largest_displacement),
        }
    }

    /// What was not exercised.
    pub fn gaps(&self) -> Vec<Lack> {
        if self.samples == 0 {
            return Vec::new();
        }
        let lack = |code, message: String, remedy| Lack { code, message, remedy };
        if self.away == 0 {
            let (most, remedy) = match self.largest_rotation {
                Some(most) => (
                    format!("the largest rotation is {most} rad", most = short(most, 3)),
                    "add states with both nodes turned by a radian and more, and components displaced, as far as the mechanism allows it",
                ),
                None => (
                    format!(
                        "the nodes move relative to each other by {} lengths at most",
                        short(self.largest_displacement, 3)
                    ),
                    "add states in which the nodes move relative to each other, by lengths of the connector",
                ),
            };
            let message = format!(
                "{} saw only the neighbourhood of the initial one: {most}",
                count(self.samples, "state")
            );
            return vec![lack(Code::CoverageIdentity, message, remedy)];
        }
        let mut lacks = Vec::new();
        let small = self.largest_relative_rotation.filter(|most| self.deformed > 0 && *most <= TURNED);
        let is_turned = self.largest_rotation.is_some_and(|most| most > TURNED);
        // Where neither node was turned, and relative rotations are told of, nothing is added.
        if self.could_turn_both > 0 && self.both_turned == 0 && (is_turned || small.is_none()) {
            let message = format!(
                "in none of {} were both nodes of a connector turned by more than {TURNED} rad",
                count(self.could_turn_both, "state")
            );
            let remedy = "turn both nodes, as far as the mechanism allows it: in the same state, differently, about directions that no axis is along";
            lacks.push(lack(Code::CoverageOneNode, message, remedy));
        }
        if self.could_deform > 0 && self.deformed == 0 {
            let message = format!(
                "in none of {} was a component displaced that is free to move",
                count(self.could_deform, "state")
            );
            let remedy =
                "add states in which the nodes move relative to each other, if the mechanism allows it";
            lacks.push(lack(Code::CoverageUndeformed, message, remedy));
        }
        if let Some(most) = small {
            let message = format!("the largest relative rotation is {most} rad", most = short(most, 3));
            let remedy = "add states with relative rotations of a radian and more, where the type and the mechanism permit them";
            lacks.push(lack(Code::CoverageSmallAngles, message, remedy));
        }
        lacks
    }
}

impl Coverage {
    /// Counts a connector at a state; `length` is that of [`Sample::of`].
    pub fn add(&mut self, definition: &Definition, state: &State<f64>, length: f64) {
        self.take(&Sample::of(&Connector::new(definition), definition, state, length));
    }

    /// Counts a sample.
    pub fn take(&mut self, sample: &Sample) {
        let Sample { rotations: [a, b], relative, stretch, margin, stands, .. } = *sample;
        self.exercise.add(sample);
        if stands {
            return;
        }
        a.into_iter().for_each(|angle| self.rotation_a.add(angle));
        b.into_iter().for_each(|angle| self.rotation_b.add(angle));
        if a.is_some() || b.is_some() {
            self.relative_rotation.add(relative);
        }
        stretch.into_iter().for_each(|ratio| self.stretch.add(ratio));
        margin.into_iter().for_each(|distance| self.margin.add(distance));
    }

    /// What was not exercised, of all connectors together.
    pub fn gaps(&self) -> Vec<Lack> {
        self.exercise.gaps()
    }
}
