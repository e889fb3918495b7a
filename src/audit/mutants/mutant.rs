//! The self-test: the same numbers with one mistake in them, as people make them, on which every check must speak.

use crate::case::Case;
use crate::case::quantity::{Entries, Numbers, OneOrMany, Quantity};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::{self, DOFS, Pair};
use pintle_kinematics::vector::{Matrix, Vector, apply_transposed, cross, skew, sub};
use serde::Serialize;
use std::f64::consts::PI;

/// The relative changes tried on every entry: decades from a tenth down to the last digit.
pub const LADDER: [f64; 14] =
    [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14];

/// What is below this part of its conditioned scale is taken to be zero but for rounding: that it is not must be noticed too.
pub(super) const NOTHING: f64 = 1e-9;

/// A mistake.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mistake {
    /// An entry is missing.
    Dropped,
    /// An entry has the wrong sign.
    Sign,
    /// An entry that must be zero is not.
    Spurious,
    /// An entry is multiplied by 1 + δ.
    Scaled(f64),
    /// Two components are exchanged.
    RowsSwapped,
    /// Two neighbouring columns are exchanged.
    ColumnsSwapped,
    /// A 3 × 3 block is transposed.
    BlockTransposed,
    /// The rotation degrees of freedom of a node are taken as local: its block is multiplied by its triad.
    RotationTakenAsLocal,
    /// The blocks of the nodes are exchanged.
    NodesSwapped,
    /// The block of the first node has the sign of the second's.
    SameSignForBoth,
    /// The rotation block of a node is halved.
    RotationHalved,
    /// Derivatives per degree instead of per radian.
    DegreesForRadians,
    /// The lever term g × d in the rotations of a is missing; of second derivatives, the second variation of the map.
    GeometricTermMissing,
    /// Second derivatives are those of the rows, without the half bracket that makes them symmetric.
    BracketKept,
    /// The angle is half a turn off: nπ of the wrong parity.
    WrongParity,
    /// The turns counted up to now are forgotten.
    TurnForgotten,
    /// The rates of the first node are ignored.
    RatesOfAIgnored,
    /// The part quadratic in the rates is missing.
    QuadraticPartMissing,
    /// A factor's number is left out: β = 1/L for 2/L.
    NumberLeftOut,
    /// A parameter multiplies that must divide: m · R_r for m/R_r.
    MultipliedInsteadOfDivided,
    /// The tangent of stick in slip, or the reverse.
    StickForSlip,
    /// What presses is held while a tangent is taken.
    CouplingMissing,
    /// The slopes by displacements and by velocities are exchanged.
    ElasticForViscous,
    /// F/u in place of ∂F/∂u.
    SecantForTangent,
}

impl Mistake {
    /// In words.
    pub fn name(self) -> String {
        match self {
            Self::Dropped => "entry dropped".into(),
            Self::Sign => "sign of an entry".into(),
            Self::Spurious => "entry that must be zero".into(),
            Self::Scaled(delta) => format!("entry × (1 + {delta:e})"),
            Self::RowsSwapped => "components swapped".into(),
            Self::ColumnsSwapped => "columns swapped".into(),
            Self::BlockTransposed => "block transposed".into(),
            Self::RotationTakenAsLocal => "rotation taken as local".into(),
            Self::NodesSwapped => "nodes swapped".into(),
            Self::SameSignForBoth => "sign of the first node".into(),
            Self::RotationHalved => "rotation block halved".into(),
            Self::DegreesForRadians => "degrees for radians".into(),
            Self::GeometricTermMissing => "geometric term missing".into(),
            Self::BracketKept => "second derivatives not symmetrised".into(),
            Self::WrongParity => "nπ of the wrong parity".into(),
            Self::TurnForgotten => "previous turns forgotten".into(),
            Self::RatesOfAIgnored => "rates of the first node ignored".into(),
            Self::QuadraticPartMissing => "quadratic part missing".into(),
            Self::NumberLeftOut => "β = 2/L without the 2".into(),
            Self::MultipliedInsteadOfDivided => "R_r multiplied instead of divided".into(),
            Self::StickForSlip => "stick for slip".into(),
            Self::CouplingMissing => "contact force held".into(),
            Self::ElasticForViscous => "elastic for viscous slopes".into(),
            Self::SecantForTangent => "secant for tangent".into(),
        }
    }
}

/// The entries that a mistake changes: (component or row of a table, entry, changed number).
pub type Changes = OneOrMany<(usize, usize, f64)>;

/// One mistake made once.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// The mistake.
    pub mistake: Mistake,
    /// What it changes.
    pub changes: Changes,
}

impl Mutant {
    /// A change of one entry.
    pub const fn of_entry(mistake: Mistake, k: usize, i: usize, x: f64) -> Self {
        Self { mistake, changes: Changes::One([(k, i, x)]) }
    }

    /// Changes of entries of a row: place, number.
    pub fn of_row(mistake: Mistake, k: usize, changes: impl IntoIterator<Item = (usize, f64)>) -> Self {
        Self::many(mistake, changes.into_iter().map(|(i, x)| (k, i, x)))
    }

    /// Changes of entries of any rows.
    pub fn many(mistake: Mistake, changes: impl IntoIterator<Item = (usize, usize, f64)>) -> Self {
        Self { mistake, changes: Changes::Many(changes.into_iter().collect()) }
    }

    /// The numbers with the mistake in them.
    pub fn applied(&self, entries: &Entries<f64>) -> Entries<f64> {
        let mut changed = entries.clone();
        for (k, i, x) in self.changes.iter() {
            if let Some(entry) =
                changed.0.get_mut(*k).and_then(Option::as_mut).and_then(|all| all.get_mut(*i))
            {
                *entry = *x;
            }
        }
        changed
    }
}

/// What mistakes need to know of the state.
pub struct Scene<'a> {
    /// The numbers of the product.
    pub numbers: &'a Numbers<f64>,
    /// The case, for its triads and rates.
    pub case: &'a Case,
    /// The unit of each component, where it has one.
    pub units: [Option<Unit>; 6],
    /// The whole turns of each component.
    pub turns: [f64; 6],
    /// The size of each entry that a mistake adds where there must be zero.
    pub scale: &'a dyn Fn(usize, usize) -> f64,
}

/// Every mistake in a quantity, wherever it can be made.
pub fn mutants(quantity: Quantity, scene: &Scene<'_>) -> Vec<Mutant> {
    let entries = scene.numbers.entries(quantity);
    let mut found = entry_mistakes(entries, scene);
    match quantity {
        Quantity::Value => found.extend(value_mistakes(entries, scene)),
        Quantity::FirstDerivatives | Quantity::NodalForces => found.extend(row_mistakes(entries, scene)),
        Quantity::SecondDerivatives => {
            found.extend(matrix_mistakes(entries, scene.numbers.entries(Quantity::FirstDerivatives), scene));
        }
        Quantity::GeometricStiffness => {
            found.extend(matrix_mistakes(entries, scene.numbers.entries(Quantity::NodalForces), scene));
        }
        Quantity::Rate | Quantity::Acceleration => found.extend(rate_mistakes(quantity, entries, scene)),
        // These are no numbers of a connector's components.
        Quantity::FrictionCriterion
        | Quantity::FrictionGradient
        | Quantity::FrictionHessian
        | Quantity::FrictionTangent
        | Quantity::FrictionForce
        | Quantity::ConsistentTangent
        | Quantity::ElementForces
        | Quantity::ElementStiffness
        | Quantity::BehaviorTangent => {}
    }
    found
}

/// The mistakes that can be made in a number by itself, each with what it makes of it; `scale` is its conditioned scale.
pub fn of_number(x: f64, scale: f64) -> impl Iterator<Item = (Mistake, f64)> {
    let spurious = (x.abs() <= NOTHING * scale).then_some((Mistake::Spurious, x + 1e-3 * scale));
    let others = [(Mistake::Dropped, 0.0), (Mistake::Sign, -x)].into_iter();
    let others =
        others.chain(LADDER.into_iter().map(move |delta| (Mistake::Scaled(delta), x * (1.0 + delta))));
    spurious.into_iter().chain(others.filter(move |_| x != 0.0))
}

fn entry_mistakes(entries: &Entries<f64>, scene: &Scene<'_>) -> Vec<Mutant> {
    let of = |(k, i, x)| {
        of_number(x, (scene.scale)(k, i)).map(move |(mistake, x)| Mutant::of_entry(mistake, k, i, x))
    };
    entries.iter().flat_map(of).collect()
}

/// The mistakes of a number that is an angle (rad), of so many whole turns.
pub fn of_angle(x: f64, turns: f64) -> impl Iterator<Item = (Mistake, f64)> {
    let forgotten = (turns != 0.0).then_some((Mistake::TurnForgotten, x - 2.0 * PI * turns));
    let always = [(Mistake::WrongParity, x + PI), (Mistake::DegreesForRadians, x.to_degrees())];
    always.into_iter().chain(forgotten)
}

fn value_mistakes(entries: &Entries<f64>, scene: &Scene<'_>) -> Vec<Mutant> {
    let angles = entries.iter().filter(|(k, ..)| scene.units[*k] == Some(Unit::Angle));
    let made = angles.flat_map(|(k, i, x)| {
        of_angle(x, scene.turns[k]).map(move |(mistake, x)| Mutant::of_entry(mistake, k, i, x))
    });
    let mut found: Vec<Mutant> = made.collect();
    found.extend(swapped_components(entries, 1));
    found
}

/// Exchanged neighbours of one class: u1, u2, u3 or ur1, ur2, ur3.
fn swapped_components(entries: &Entries<f64>, width: usize) -> Vec<Mutant> {
    let mut found = Vec::new();
    for (k, l) in [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5)] {
        if let (Some(x), Some(y)) = (&entries.0[k], &entries.0[l]) {
            let changes = (0..width).flat_map(|i| [(k, i, y[i]), (l, i, x[i])]);
            found.push(Mutant::many(Mistake::RowsSwapped, changes));
        }
    }
    found
}

/// Where three displacements or three rotations of a node begin in a row of nodal derivatives: of a connector as of a constraint, whose angles
/// of hinges come after.
pub(crate) const BLOCKS: [usize; 4] = [node::XA, node::THETA_A, node::XB, node::THETA_B];

/// Where those are rotations.
pub(crate) const ROTATIONS: [usize; 2] = [node::THETA_A, node::THETA_B];

/// The number of degrees of freedom of one node.
const HALF: usize = DOFS / 2;

/// The place of the same degree of freedom of the other node; what is of neither stays.
const fn exchanged(j: usize) -> usize {
    if j < DOFS { (j + HALF) % DOFS } else { j }
}

/// Three entries of a row, from a place on.
pub(crate) fn part(row: &[f64], at: usize) -> Vector<f64> {
    [0, 1, 2].map(|i| row.get(at + i).copied().unwrap_or(0.0))
}

/// Changed entries of a row: place, changed number.
pub type OfRow = Vec<(usize, f64)>;

/// Three changed entries of a row.
pub(crate) fn put(at: usize, v: Vector<f64>) -> OfRow {
    v.into_iter().enumerate().map(|(i, x)| (at + i, x)).collect()
}

/// The mistakes of a row of first derivatives, of an angle or of a length; those of its rotations by the triads of the nodes, where known.
pub fn of_row(row: &[f64], is_angle: bool, triads: Option<[&Matrix<f64>; 2]>) -> Vec<(Mistake, OfRow)> {
    let mut found = Vec::new();
    let neighbours = BLOCKS.into_iter().flat_map(|at| [at, at + 1]);
    found.extend(neighbours.map(|j| (Mistake::ColumnsSwapped, vec![(j, row[j + 1]), (j + 1, row[j])])));
    found.push((Mistake::NodesSwapped, (0..DOFS).map(|j| (j, row[exchanged(j)])).collect()));
    found.push((Mistake::SameSignForBoth, (0..HALF).map(|j| (j, -row[j])).collect()));
    let mut degrees = OfRow::new();
    for (end, at) in ROTATIONS.into_iter().enumerate() {
        let block = part(row, at);
        found.push((Mistake::RotationHalved, put(at, block.map(|x| x / 2.0))));
        degrees.extend(put(at, block.map(f64::to_radians)));
        let local = triads.map(|triads| put(at, apply_transposed(triads[end], block)));
        found.extend(local.map(|local| (Mistake::RotationTakenAsLocal, local)));
    }
    if is_angle {
        // An angle in degrees against lengths and rotations in radians.
        degrees = row.iter().enumerate().map(|(j, x)| (j, x.to_degrees())).collect();
    }
    found.push((Mistake::DegreesForRadians, degrees));
    found
}

/// Each block of three rows of one vector transposed: row (0 to 2), place, changed number.
pub fn transposed_blocks(rows: [&[f64]; 3]) -> impl Iterator<Item = [(usize, usize, f64); 9]> + '_ {
    BLOCKS.into_iter().map(move |at| {
        let block = rows.map(|row| part(row, at));
        std::array::from_fn(|n| (n / 3, at + n % 3, block[n % 3][n / 3]))
    })
}

fn row_mistakes(entries: &Entries<f64>, scene: &Scene<'_>) -> Vec<Mutant> {
    let mut found = swapped_components(entries, DOFS);
    let pair = scene.case.last().map(|step| &step.state.pair);
    for (k, row) in entries.0.iter().enumerate() {
        let Some(row) = row else { continue };
        let triads = pair.map(|pair| [&pair.a.triad, &pair.b.triad]);
        let mut made = of_row(row, scene.units[k] == Some(Unit::Angle), triads);
        if let Some(pair) = pair {
            let lever = cross(part(row, node::XB), pair.separation());
            let without = sub(part(row, node::THETA_A), lever);
            made.push((Mistake::GeometricTermMissing, put(node::THETA_A, without)));
        }
        found.extend(made.into_iter().map(|(mistake, changes)| Mutant::of_row(mistake, k, changes)));
    }
    for first in [0, 3] {
        let rows = [0, 1, 2].map(|i| entries.0[first + i].as_deref());
        let [Some(x), Some(y), Some(z)] = rows else { continue };
        let placed = |block: [_; 9]| block.map(|(row, at, x)| (first + row, at, x));
        found.extend(
            transposed_blocks([x, y, z]).map(|block| Mutant::many(Mistake::BlockTransposed, placed(block))),
        );
    }
    found
}

/// The second variations of the map from nodal to relative variations, for a row with g = ∂f/∂x_b and h = ∂f/∂θ_b.
pub(super) fn second_variation(row: &[f64], pair: &Pair<f64>) -> Vec<(usize, usize, f64)> {
    let (g, h, d) = (part(row, node::XB), part(row, node::THETA_B), pair.separation());
    let (spin_g, spin_h) = (skew(g), skew(h));
    let along: f64 = (0..3).map(|i| g[i] * d[i]).sum();
    let mut terms = Vec::new();
    for i in 0..3 {
        for j in 0..3 {
            let mut both = |a: usize, b: usize, x: f64| {
                terms.push((a, b, x));
                terms.push((b, a, x));
            };
            both(node::THETA_A + i, node::XB + j, spin_g[i][j]);
            both(node::THETA_A + i, node::XA + j, -spin_g[i][j]);
            both(node::THETA_A + i, node::THETA_B + j, 0.5 * spin_h[i][j]);
            let centripetal = 0.5 * (g[i] * d[j] + g[j] * d[i]) - if i == j { along } else { 0.0 };
            terms.push((node::THETA_A + i, node::THETA_A + j, centripetal));
        }
    }
    terms
}

/// The mistakes of a symmetric matrix of second derivatives with so many columns, where `gradient` are the first ones.
pub fn of_matrix(matrix: &[f64], width: usize, gradient: &[f64]) -> [(Mistake, OfRow); 3] {
    let at = |i: usize, j: usize| matrix[i * width + j];
    let all = |f: &dyn Fn(usize, usize) -> f64| -> OfRow {
        (0..matrix.len()).map(|n| (n, f(n / width, n % width))).collect()
    };
    // Where the rotations of the node begin that a degree of freedom turns.
    let turned = |j: usize| ROTATIONS.into_iter().find(|at| (*at..at + 3).contains(&j));
    let halved = |i: usize, j: usize| {
        if turned(i).is_some() && turned(j).is_some() { at(i, j) / 2.0 } else { at(i, j) }
    };
    let bracket = |i: usize, j: usize| {
        let (Some(theta), true) = (turned(i), turned(i) == turned(j)) else { return 0.0 };
        let axis = |n: usize| [0, 1, 2].map(|m| if theta + m == n { 1.0 } else { 0.0 });
        let (v, gradient) = (cross(axis(i), axis(j)), part(gradient, theta));
        (0..3).map(|m| v[m] * gradient[m]).sum::<f64>() / 2.0
    };
    [
        (Mistake::NodesSwapped, all(&|i, j| at(exchanged(i), exchanged(j)))),
        (Mistake::RotationHalved, all(&halved)),
        (Mistake::BracketKept, all(&|i, j| at(i, j) + bracket(i, j))),
    ]
}

fn matrix_mistakes(entries: &Entries<f64>, first: &Entries<f64>, scene: &Scene<'_>) -> Vec<Mutant> {
    let mut found = swapped_components(entries, DOFS * DOFS);
    let pair = scene.case.last().map(|step| step.state.pair);
    for (k, matrix) in entries.0.iter().enumerate() {
        let Some(matrix) = matrix else { continue };
        let mut add = |(mistake, changes)| found.push(Mutant::of_row(mistake, k, changes));
        let transposed = (0..DOFS * DOFS).map(|n| (n, matrix[n % DOFS * DOFS + n / DOFS])).collect();
        add((Mistake::BlockTransposed, transposed));
        let row = first.0[k].as_deref();
        let [swapped, halved, bracket] = of_matrix(matrix, DOFS, row.unwrap_or_default());
        add(swapped);
        add(halved);
        let (Some(pair), Some(row)) = (&pair, row) else { continue };
        let mut missing: Vec<f64> = matrix.clone();
        for (i, j, term) in second_variation(row, pair) {
            if missing[i * DOFS + j] != 0.0 {
                missing[i * DOFS + j] -= term;
            }
        }
        add((Mistake::GeometricTermMissing, missing.into_iter().enumerate().collect()));
        add(bracket);
    }
    found
}

/// The mistakes of a rate, or of an acceleration, from the row of what changes and the rates or accelerations `along` it.
pub fn of_rate(
    x: f64,
    (row, along): (&[f64], &[f64]),
    (is_angle, is_acceleration): (bool, bool),
) -> impl Iterator<Item = (Mistake, f64)> {
    let sum = |count: usize| row.iter().zip(along).take(count).map(|(r, v)| r * v).sum::<f64>();
    let linear = is_acceleration.then(|| (Mistake::QuadraticPartMissing, sum(row.len())));
    let degrees = is_angle.then(|| (Mistake::DegreesForRadians, x.to_degrees()));
    [(Mistake::RatesOfAIgnored, x - sum(HALF))].into_iter().chain(linear).chain(degrees)
}

fn rate_mistakes(quantity: Quantity, entries: &Entries<f64>, scene: &Scene<'_>) -> Vec<Mutant> {
    let mut found = swapped_components(entries, 1);
    let rows = scene.numbers.entries(Quantity::FirstDerivatives);
    let Some(state) = scene.case.last().map(|step| step.state) else { return found };
    let is_acceleration = quantity == Quantity::Acceleration;
    let along = if is_acceleration { &state.acceleration } else { &state.velocity };
    for (k, i, x) in entries.iter() {
        let Some(row) = &rows.0[k] else { continue };
        let is_angle = scene.units[k] == Some(Unit::Angle);
        let made = of_rate(x, (row, along), (is_angle, is_acceleration));
        found.extend(made.map(|(mistake, x)| Mutant::of_entry(mistake, k, i, x)));
    }
    found
}
