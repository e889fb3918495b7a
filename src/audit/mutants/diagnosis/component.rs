//! Numbers of a connector's components.

use crate::case::Case;
use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::judge::bound::Bound;
use crate::mutants::diagnosis::matching::{Cell, Class, Datum, Hypothesis, Matching, Words, ranges};
use crate::mutants::diagnosis::{Cause, Diagnosis};
use crate::mutants::mutant::{Changes, OfRow, ROTATIONS, Scene, mutants, part, put};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node;
use pintle_kinematics::node::{DOF, DOFS};
use pintle_kinematics::vector::{Matrix, apply, cross};
use std::collections::BTreeSet;

/// Wrong numbers, and what they must be.
pub struct Symptoms<'a> {
    /// What they are.
    pub quantity: Quantity,
    /// The numbers given.
    pub got: &'a Entries<f64>,
    /// Everything as it must be.
    pub want: &'a Numbers<f64>,
    /// The case at whose end they are.
    pub case: &'a Case,
    /// The tolerances.
    pub bound: &'a Bound,
}

/// Why numbers are wrong; `None` where none is.
pub fn diagnose(symptoms: &Symptoms<'_>) -> Option<Diagnosis> {
    let Symptoms { quantity, got, bound, .. } = *symptoms;
    let data = symptoms.wanted().iter().map(|(k, i, want)| {
        let tolerance = bound.tolerance(quantity, k, i);
        ((k, i), Datum { got: got.get(k, i), want, tolerance, class: class(quantity, k, i) })
    });
    let words = ComponentWords { quantity };
    let hypotheses = symptoms.hypotheses();
    let mut matching = Matching { data: data.collect(), hypotheses, words: &words };
    matching.add_mistakes_of_entries();
    matching.diagnosis()
}

/// The class of an entry.
fn class(quantity: Quantity, k: usize, i: usize) -> Class {
    let kind = |j: usize| match j % (DOFS / 2) {
        0..=2 => 0,
        3..=5 => 1,
        _ => 2,
    };
    match quantity {
        Quantity::FirstDerivatives | Quantity::NodalForces => (k / 3, kind(i), 0),
        Quantity::SecondDerivatives | Quantity::GeometricStiffness => {
            let [x, y] = [kind(i / DOFS), kind(i % DOFS)];
            (k / 3, x.min(y), x.max(y))
        }
        _ => (k / 3, 0, 0),
    }
}

impl Symptoms<'_> {
    fn wanted(&self) -> &Entries<f64> {
        self.want.entries(self.quantity)
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        let connector = self.case.connector();
        let units: [Option<Unit>; 6] = std::array::from_fn(|k| connector.differentiated(k).map(|m| m.unit()));
        let turns = self.case.last().map(|step| {
            let before = self.case.branch_before(&connector);
            connector.advance(&step.state, &step.increment, &before).turns.map(|turns| turns.turns)
        });
        let scale = |k: usize, i: usize| self.bound.scale(self.quantity, k, i);
        let scene = Scene {
            numbers: self.want,
            case: self.case,
            units,
            turns: turns.unwrap_or_default(),
            scale: &scale,
        };
        let made = mutants(self.quantity, &scene).into_iter();
        let made =
            made.map(|mutant| Hypothesis { cause: Cause::of(mutant.mistake), changes: mutant.changes });
        let mut found: Vec<Hypothesis> = made.filter(|made| !made.cause.is_of_an_entry()).collect();
        for (k, entries) in self.wanted().0.iter().enumerate() {
            let Some(entries) = entries else { continue };
            let changes = entries.iter().enumerate().map(|(i, x)| (k, i, -x)).collect();
            found.push(Hypothesis { cause: Cause::Reversed, changes: Changes::Many(changes) });
            if matches!(self.quantity, Quantity::FirstDerivatives | Quantity::NodalForces) {
                found.extend(self.conventions(k, entries));
            }
        }
        found
    }

    /// Changes of convention of a row that are no mistakes of the self-test.
    fn conventions(&self, k: usize, row: &[f64]) -> Vec<Hypothesis> {
        let Some(pair) = self.case.last().map(|step| &step.state.pair) else { return Vec::new() };
        let mut found = conventions(row, [&pair.a.triad, &pair.b.triad]);
        let lever = cross(part(row, node::XB), pair.separation());
        let block = part(row, node::THETA_A);
        let reversed = [0, 1, 2].map(|i| block[i] - 2.0 * lever[i]);
        found.push((Cause::LeverReversed, put(node::THETA_A, reversed)));
        let of = |(cause, changes): (Cause, OfRow)| Hypothesis {
            cause,
            changes: Changes::Many(changes.into_iter().map(|(i, x)| (k, i, x)).collect()),
        };
        found.into_iter().map(of).collect()
    }
}

/// Rotations of a row of nodal derivatives by other conventions: turned twice by the triads of the nodes, and doubled.
pub fn conventions(row: &[f64], triads: [&Matrix<f64>; 2]) -> Vec<(Cause, OfRow)> {
    let of = |(at, triad): (usize, &Matrix<f64>)| {
        let block = part(row, at);
        let turned = (Cause::RotationTurnedTwice, put(at, apply(triad, block)));
        [turned, (Cause::RotationDoubled, put(at, block.map(|x| 2.0 * x)))]
    };
    ROTATIONS.into_iter().zip(triads).flat_map(of).collect()
}

struct ComponentWords {
    quantity: Quantity,
}

impl Words for ComponentWords {
    fn entry(&self, (k, i): Cell) -> String {
        self.quantity.entry_name(k, i)
    }

    fn region(&self, places: &BTreeSet<Cell>) -> String {
        let rows: BTreeSet<usize> = places.iter().map(|(k, _)| *k).collect();
        let rows: Vec<&str> = rows.into_iter().filter_map(|k| COMPONENT.get(k).copied()).collect();
        let each = |prefix: &str, suffix: &str| {
            let named: Vec<String> = rows.iter().map(|row| format!("{prefix}{row}{suffix}")).collect();
            named.join(", ")
        };
        match self.quantity {
            Quantity::Rate => each("d", "/dt"),
            Quantity::Acceleration => each("d²", "/dt²"),
            Quantity::SecondDerivatives => each("∂²", ""),
            Quantity::NodalForces => each("the nodal forces of ", &columns(places, " on ", " and ")),
            Quantity::GeometricStiffness => each("the geometric stiffness of ", ""),
            Quantity::FirstDerivatives => each("∂", &columns(places, "/∂", " and ∂")),
            _ => rows.join(", "),
        }
    }

    fn triads(&self) -> [&'static str; 2] {
        ["A", "B"]
    }

    fn rotations(&self, places: &BTreeSet<Cell>) -> [bool; 2] {
        [node::THETA_A, node::THETA_B].map(|at| places.iter().any(|(_, j)| (at..at + 3).contains(j)))
    }
}

/// The columns of entries in words, after a prefix; nothing where they are all columns.
fn columns(places: &BTreeSet<Cell>, prefix: &str, and: &str) -> String {
    let columns: BTreeSet<usize> = places.iter().map(|(_, j)| *j).collect();
    let name = |j: usize| DOF.get(j).copied().unwrap_or_default().to_string();
    // A connector need not have both flows.
    if columns.len() >= DOFS - 2 {
        String::new()
    } else {
        format!("{prefix}{}", ranges(&columns, &name).join(and))
    }
}
