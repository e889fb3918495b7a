//! Which region of configuration space was exercised? A suite that saw only the neighbourhood of the initial state proves nothing
//! about the rest: most errors in terms of rotation vanish there.
//!
//! ```
//! use pintle::audit::Coverage;
//! use pintle::catalog::ConnectionType;
//! use pintle::connector::{Definition, State};
//! use pintle::node::{DOFS, Node, Pair};
//! use pintle::scene::Code;
//! use pintle::{so3, vector};
//!
//! let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
//! let initial = Pair { reference: [1.0, 0.0, 0.0], a: node(vector::identity()), b: node(vector::identity()) };
//! let definition = Definition::new(ConnectionType::named("CARTESIAN", Some("CARDAN"))?, initial);
//! let mut coverage = Coverage::default();
//! for i in 0..100 {
//!     let turn = so3::matrix(so3::exp([1e-4 * f64::from(i), 0.0, 0.0]));
//!     let pair = Pair { b: node(turn), ..initial };
//!     coverage.add(&definition, &State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] });
//! }
//! let codes: Vec<Code> = coverage.gaps().iter().map(|gap| gap.code).collect();
//! assert_eq!(codes, [Code::CoverageIdentity]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::connector::{Connector, Definition, Increment, Output, Request, State, Tally};
use crate::grammar::count;
use crate::measure::Unit;
use crate::scalar::elementary::norm;
use crate::scene::Code;
use crate::so3;
use crate::vector::{self, Matrix};
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
    /// The number of states of connectors, each connector at each state.
    pub samples: u64,
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
    /// Samples in which both nodes were turned, each by more than 0.1 rad.
    pub both_turned: u64,
    /// Samples of connectors both of whose nodes have rotations.
    pub could_turn_both: u64,
    /// Samples in which a component that is free to move was displaced by more than 1e-6 rad or lengths.
    pub deformed: u64,
    /// Samples of connectors that have such components.
    pub could_deform: u64,
    /// Samples outside of the neighbourhood of the initial state.
    pub away: u64,
}

impl Default for Coverage {
    fn default() -> Self {
        Self {
            samples: 0,
            rotation_a: Histogram::new("rotation of a", "rad", &ANGLES),
            rotation_b: Histogram::new("rotation of b", "rad", &ANGLES),
            relative_rotation: Histogram::new("relative rotation", "rad", &ANGLES),
            stretch: Histogram::new("distance / initial distance", "", &STRETCHES),
            margin: Histogram::new("distance to a singular set", "rad or lengths", &MARGINS),
            both_turned: 0,
            could_turn_both: 0,
            deformed: 0,
            could_deform: 0,
            away: 0,
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

/// Angles (rad) and displacements, in lengths of the connector, below which a state is in the neighbourhood of the initial one.
const NEIGHBOURHOOD: f64 = 0.05;
/// An angle that tells formulas apart: its sine differs from it by 2e-4, and its cosine from 1 by 5e-3.
const TURNED: f64 = 0.1;
/// A displacement that is more than rounding.
const DISPLACED: f64 = 1e-6;

/// The angle of a rotation from one triad to another.
fn angle(now: &Matrix<f64>, before: &Matrix<f64>) -> f64 {
    norm(so3::log(&vector::product(now, &vector::transpose(before))))
}

impl Coverage {
    /// Counts a connector at a state.
    pub fn add(&mut self, definition: &Definition, state: &State<f64>) {
        self.add_of(&Connector::new(definition), definition, state);
    }

    /// The same, of a connector that is made already.
    pub fn add_of(&mut self, connector: &Connector<f64>, definition: &Definition, state: &State<f64>) {
        let (initial, pair) = (&definition.initial, &state.pair);
        let turns = [0, 1].map(|end| definition.moves[end] && definition.rotates[end]);
        let angles = [angle(&pair.a.triad, &initial.a.triad), angle(&pair.b.triad, &initial.b.triad)];
        let [before, now] = [initial, pair].map(crate::node::Pair::relative);
        let relative = angle(&now.q, &before.q);
        let (length, distance) = (norm(initial.reference), norm(pair.separation()));
        let size = if length > 0.0 { length } else { 1.0 };
        self.samples += 1;
        for (histogram, (turns, angle)) in
            [&mut self.rotation_a, &mut self.rotation_b].into_iter().zip(turns.into_iter().zip(angles))
        {
            if turns {
                histogram.add(angle);
            }
        }
        if turns.contains(&true) {
            self.relative_rotation.add(relative);
        }
        if length > 0.0 {
            self.stretch.add(distance / length);
        }
        if turns == [true; 2] {
            self.could_turn_both += 1;
            self.both_turned += u64::from(angles[0] > TURNED && angles[1] > TURNED);
        }
        let request = Request::new(&[Output::CU], [true; 6], 0);
        let (branch, mut tally) = (connector.initial_branch(), Tally::default());
        let result = connector.evaluate(state, &Increment::none(), &branch, &request, &mut tally);
        let margins = connector.margins(state, &branch, [true; 6]).into_iter().flatten();
        let nearest = margins
            .map(|margin| margin.distance / if margin.set.unit == Unit::Length { size } else { 1.0 })
            .reduce(f64::min);
        nearest.into_iter().for_each(|distance| self.margin.add(distance));
        let free: Vec<usize> = (0..6)
            .filter(|k| connector.position_measure(*k).is_some() && !connector.is_constrained(*k))
            .collect();
        if !free.is_empty() {
            let moved = |k: &usize| {
                let is_length =
                    connector.position_measure(*k).is_some_and(|measure| measure.unit() == Unit::Length);
                result.displacement[*k]
                    .is_some_and(|u| u.abs() > DISPLACED * if is_length { size } else { 1.0 })
            };
            self.could_deform += 1;
            self.deformed += u64::from(free.iter().any(moved));
        }
        let displaced = vector::sub(pair.b.displacement, pair.a.displacement);
        let reach = [angles[0], angles[1], relative, norm(displaced) / size];
        self.away += u64::from(reach.into_iter().any(|x| x > NEIGHBOURHOOD));
    }

    /// What was not exercised.
    pub fn gaps(&self) -> Vec<Lack> {
        if self.samples == 0 {
            return Vec::new();
        }
        let lack = |code, message: String, remedy| Lack { code, message, remedy };
        if self.away == 0 {
            let most =
                self.rotation_a.largest.max(self.rotation_b.largest).max(self.relative_rotation.largest);
            let message = format!(
                "{} saw only the neighbourhood of the initial one: the largest rotation is {most:.2e} rad",
                count(self.samples, "state")
            );
            let remedy = "add states with both nodes turned by a radian and more, and components displaced";
            return vec![lack(Code::CoverageIdentity, message, remedy)];
        }
        let mut lacks = Vec::new();
        let [a, b] = [&self.rotation_a, &self.rotation_b].map(|histogram| histogram.largest > TURNED);
        if self.could_turn_both > 0 && self.both_turned == 0 && (a || b) {
            let message = format!(
                "in none of {} were both nodes of a connector turned by more than {TURNED} rad",
                count(self.could_turn_both, "state")
            );
            let remedy =
                "turn both nodes: in the same state, differently, about directions that no axis is along";
            lacks.push(lack(Code::CoverageOneNode, message, remedy));
        }
        if self.could_deform > 0 && self.deformed == 0 {
            let message = format!(
                "in none of {} was a component displaced that is free to move",
                count(self.could_deform, "state")
            );
            lacks.push(lack(
                Code::CoverageUndeformed,
                message,
                "add states in which the nodes move relative to each other",
            ));
        }
        if self.deformed > 0
            && self.relative_rotation.samples() > 0
            && self.relative_rotation.largest <= TURNED
        {
            let message =
                format!("the largest relative rotation is {:.2e} rad", self.relative_rotation.largest);
            let remedy =
                "add states with relative rotations of a radian and more, where the type permits them";
            lacks.push(lack(Code::CoverageSmallAngles, message, remedy));
        }
        lacks
    }
}
