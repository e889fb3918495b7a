//! Changes of the columns of a row, and what they make of rows, rates and second derivatives.

use crate::case::Case;
use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::matching::Hypothesis;
use crate::mutants::mutant::{ROTATIONS, part};
use pintle_kinematics::node::{DOFS, PSI_A, THETA_A, THETA_B, XA, XB};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, apply, column, dot, product, transpose, transposed_product};
use std::f64::consts::PI;
use std::ops::Range;

/// What is done to a row, in place.
type Change = dyn Fn(&mut [f64]);

/// A linear change of the columns of a row: it changes rates and second derivatives alike.
pub(super) struct Operation {
    pub(super) cause: Cause,
    relation: Option<&'static str>,
    /// What it makes of rates, where that is not what it makes of columns.
    of_rates: Option<String>,
    /// Whether the self-test has it for rows.
    is_known: bool,
    /// Whether it says something of rows with columns of displacements only.
    needs_displacements: bool,
    /// Whether it multiplies the whole row, which second derivatives suffer once.
    is_scalar: bool,
    change: Box<Change>,
}

/// The blocks of columns.
pub(super) const BLOCKS: [Range<usize>; 6] =
    [XA..THETA_A, THETA_A..PSI_A, PSI_A..XB, XB..THETA_B, THETA_B..DOFS - 1, DOFS - 1..DOFS];

const DISPLACEMENTS: [usize; 2] = [XA, XB];

fn turned(row: &mut [f64], at: usize, by: &Matrix<f64>) {
    let block = apply(by, part(row, at));
    row[at..at + 3].copy_from_slice(&block);
}

fn multiplied(row: &mut [f64], columns: Range<usize>, factor: f64) {
    row[columns].iter_mut().for_each(|x| *x *= factor);
}

fn transpose_in_place(matrix: &mut [f64]) {
    (0..DOFS).for_each(|i| (0..i).for_each(|j| matrix.swap(i * DOFS + j, j * DOFS + i)));
}

impl Operation {
    fn new(cause: Cause, change: impl Fn(&mut [f64]) + 'static) -> Self {
        Self {
            cause,
            relation: None,
            of_rates: None,
            is_known: false,
            needs_displacements: false,
            is_scalar: false,
            change: Box::new(change),
        }
    }

    fn related(mut self, relation: &'static str) -> Self {
        self.relation = Some(relation);
        self
    }

    fn of_rates(mut self, relation: impl Into<String>) -> Self {
        self.of_rates = Some(relation.into());
        self
    }

    fn known(mut self) -> Self {
        self.is_known = true;
        self
    }

    /// The row with changed columns.
    pub(super) fn of(&self, row: &[f64]) -> Vec<f64> {
        let mut changed = row.to_vec();
        (self.change)(&mut changed);
        changed
    }

    fn hypothesis(&self, k: usize, changes: Vec<(usize, f64)>) -> Hypothesis {
        Hypothesis::of_row(self.cause, k, changes).related_if(self.relation)
    }

    /// Whether it says something of such a row.
    fn is_of(&self, row: &[f64]) -> bool {
        !self.needs_displacements || row[XA..THETA_A].iter().chain(&row[XB..THETA_B]).any(|x| *x != 0.0)
    }

    /// Of row k: the blocks that it changes.
    pub(super) fn of_row(&self, k: usize, row: &[f64]) -> Option<Hypothesis> {
        if self.is_known || !self.is_of(row) {
            return None;
        }
        let changed = self.of(row);
        let blocks = BLOCKS.into_iter().filter(|block| changed[block.clone()] != row[block.clone()]);
        let changes: Vec<_> = blocks.flatten().map(|j| (j, changed[j])).collect();
        (!changes.is_empty()).then(|| self.hypothesis(k, changes))
    }

    /// Both sides of a matrix.
    fn on_both(&self, matrix: &[f64]) -> Vec<f64> {
        let mut changed = matrix.to_vec();
        changed.chunks_exact_mut(DOFS).for_each(|row| (self.change)(row));
        if !self.is_scalar {
            transpose_in_place(&mut changed);
            changed.chunks_exact_mut(DOFS).for_each(|row| (self.change)(row));
            transpose_in_place(&mut changed);
        }
        changed
    }

    /// Of the second derivatives of component k.
    pub(super) fn of_matrix(&self, k: usize, matrix: &[f64]) -> Option<Hypothesis> {
        if !matrix.chunks(DOFS).any(|row| self.is_of(row)) {
            return None;
        }
        let changed = self.on_both(matrix);
        let changes = changed.into_iter().enumerate().filter(|(n, x)| *x != matrix[*n]);
        Some(self.hypothesis(k, changes.collect()))
    }

    /// Of the rate, or acceleration, of component k, from its row, and its second derivatives.
    pub(super) fn of_rate(
        &self,
        k: usize,
        (row, matrix): (&[f64], &[f64]),
        (velocity, acceleration): (&[f64], Option<&[f64]>),
    ) -> Option<Hypothesis> {
        let changed = self.of(row);
        if changed == row || !self.is_of(row) {
            return None;
        }
        let x = match acceleration {
            None => along(&changed, velocity),
            Some(acceleration) => along(&changed, acceleration) + twice(&self.on_both(matrix), velocity),
        };
        let mut made = self.hypothesis(k, vec![(0, x)]);
        if let Some(relation) = &self.of_rates {
            made = made.related(relation.clone());
        }
        // What its columns equal says nothing of a rate of another cause.
        Some(match self.cause {
            Cause::RotationTakenAsLocal | Cause::RotationTurnedTwice => {
                Hypothesis { cause: Cause::BodyRates, relation: None, ..made }
            }
            Cause::NodeLeftOut if changed[..XB].iter().all(|x| *x == 0.0) => {
                Hypothesis { cause: Cause::RatesOfAIgnored, relation: None, ..made }
            }
            _ => made,
        })
    }
}

/// Σ r_j v_j.
pub(super) fn along(row: &[f64], by: &[f64]) -> f64 {
    row.iter().zip(by).map(|(r, v)| r * v).sum()
}

/// vᵀ H v.
pub(super) fn twice(matrix: &[f64], by: &[f64]) -> f64 {
    matrix.chunks(DOFS).zip(by).map(|(row, v)| v * along(row, by)).sum()
}

/// Every change of columns at the end of a case.
pub(super) fn operations(case: &Case) -> Vec<Operation> {
    let Some(step) = case.last() else { return Vec::new() };
    let pair = step.state.pair;
    let [a, b] = [pair.a.triad, pair.b.triad];
    let [back_a, back_b] = [transpose(&a), transpose(&b)];
    let total = |now: &Matrix<f64>, initial: &Matrix<f64>| so3::log(&product(now, &transpose(initial)));
    let initial = &case.definition.initial;
    let total = [total(&a, &initial.a.triad), total(&b, &initial.b.triad)];
    let mut found = Vec::new();
    // Rotations along the axes of the nodes: of one node, of both, by its own triad or the other's.
    let local = Cause::RotationTakenAsLocal;
    let twice = Cause::RotationTurnedTwice;
    for (cause, at, triad, relation) in [
        (local, THETA_A, back_a, None),
        (local, THETA_B, back_b, None),
        (local, THETA_B, back_a, Some("Aᵀ × expected, the axes of a for those of b")),
        (local, THETA_A, back_b, Some("Bᵀ × expected, the axes of b for those of a")),
        (twice, THETA_A, a, None),
        (twice, THETA_B, b, None),
        (twice, THETA_B, a, Some("A × expected, at b")),
        (twice, THETA_A, b, Some("B × expected, at a")),
    ] {
        let made = Operation::new(cause, move |row| turned(row, at, &triad));
        found.push(if relation.is_none() { made.known() } else { Operation { relation, ..made } });
    }
    for (cause, [x, y], relation) in [
        (local, [back_a, back_b], None),
        (local, [back_a, back_a], Some("Aᵀ × expected, of b too")),
        (local, [back_b, back_b], Some("Bᵀ × expected, of a too")),
        (local, [back_b, back_a], Some("Bᵀ and Aᵀ × expected, the axes of each other")),
        (twice, [a, b], None),
        (twice, [a, a], Some("A × expected, of b too")),
        (twice, [b, b], Some("B × expected, of a too")),
        (twice, [b, a], Some("B and A × expected, the triads of each other")),
    ] {
        let change = move |row: &mut [f64]| {
            turned(row, THETA_A, &x);
            turned(row, THETA_B, &y);
        };
        found.push(Operation { relation, ..Operation::new(cause, change) });
    }
    // Variations along axes that turn with a node and were global ones at first.
    let since = |now: &Matrix<f64>, first: &Matrix<f64>| product(now, &transpose(first));
    let [of_a, of_b] = [since(&a, &initial.a.triad), since(&b, &initial.b.triad)];
    let relation = Some("Cᵀ × expected, C the rotation of the node since the start");
    for is_at in [[true, true], [true, false], [false, true]] {
        let change = move |row: &mut [f64]| {
            for (at, by) in [(THETA_A, &of_a), (THETA_B, &of_b)]
                .into_iter()
                .zip(is_at)
                .filter_map(|(x, is)| is.then_some(x))
            {
                turned(row, at, &transpose(by));
            }
        };
        found.push(Operation { relation, ..Operation::new(local, change) });
    }
    for (relation, x, y) in [
        ("Aᵀ × expected", back_a, back_a),
        ("Bᵀ × expected", back_b, back_b),
        ("Aᵀ and Bᵀ × expected", back_a, back_b),
        ("A × expected", a, a),
        ("B × expected", b, b),
    ] {
        let change = move |row: &mut [f64]| {
            turned(row, XA, &x);
            turned(row, XB, &y);
        };
        found.push(Operation::new(Cause::DisplacementTakenAsLocal, change).related(relation));
        // All columns along the axes of one node.
        let change = move |row: &mut [f64]| {
            for at in [XA, THETA_A] {
                turned(row, at, &x);
                turned(row, at + XB, &y);
            }
        };
        let all = Operation::new(Cause::DisplacementTakenAsLocal, change).related(relation);
        found.push(Operation { needs_displacements: true, ..all });
    }
    // The derivative by the total vector is Jᵀ times the spatial one.
    let jacobians = total.map(|phi: Vector<f64>| {
        [transpose(&so3::left_jacobian(phi)), transpose(&so3::inverse_left_jacobian(phi))]
    });
    for n in [0, 1] {
        let [x, y] = [jacobians[0][n], jacobians[1][n]];
        found.push(Operation::new(Cause::TotalVector, move |row| turned(row, THETA_A, &x)));
        found.push(Operation::new(Cause::TotalVector, move |row| turned(row, THETA_B, &y)));
        found.push(Operation::new(Cause::TotalVector, move |row| {
            turned(row, THETA_A, &x);
            turned(row, THETA_B, &y);
        }));
    }
    // Both rotations with the axes of one node for those of the other.
    let over = product(&b, &back_a);
    for (cause, by, relation) in [
        (Cause::AxesOfB, over, "B Aᵀ × expected, the axes of b for those of a"),
        (Cause::AxesOfA, transpose(&over), "A Bᵀ × expected, the axes of a for those of b"),
    ] {
        let change = move |row: &mut [f64]| ROTATIONS.iter().for_each(|at| turned(row, *at, &by));
        found.push(Operation::new(cause, change).related(relation));
    }
    let q = transposed_product(&a, &b);
    let (d, d0) = (pair.separation(), initial.separation());
    let across = |d: Vector<f64>, i: usize, j: usize| dot(column(&a, i), d).hypot(dot(column(&a, j), d));
    let lengths = [norm(d), norm(d0), across(d, 0, 1), norm(d) / norm(d0)];
    let cosine = (1.0 - q[0][2] * q[0][2]).max(0.0).sqrt();
    let sine = (1.0 - q[2][2] * q[2][2]).max(0.0).sqrt();
    let angle = norm(so3::log(&q));
    for factor in lengths.into_iter().chain([cosine, sine, 1.0 + q[2][2], q[2][2], angle]) {
        for factor in [factor, 1.0 / factor, factor * factor, 1.0 / (factor * factor)] {
            let all = Operation::new(Cause::NotNormalised, move |row| multiplied(row, 0..DOFS, factor));
            found.push(Operation { is_scalar: true, ..all });
            let turning = move |row: &mut [f64]| {
                ROTATIONS.iter().for_each(|at| multiplied(row, *at..at + 3, factor));
            };
            found.push(Operation::new(Cause::NotNormalised, turning));
        }
    }
    found.extend(of_blocks());
    found.extend(of_order());
    found
}

/// Factors and signs of blocks.
fn of_blocks() -> Vec<Operation> {
    let mut found = Vec::new();
    let both = |cause: Cause, ats: [usize; 2], factor: f64| {
        Operation::new(cause, move |row: &mut [f64]| {
            ats.iter().for_each(|at| multiplied(row, *at..at + 3, factor))
        })
    };
    for (factor, relation) in
        [(PI / 180.0, "what is expected × π/180"), (180.0 / PI, "what is expected × 180/π")]
    {
        found.push(both(Cause::DegreesForRadians, ROTATIONS, factor).related(relation));
        let all = move |row: &mut [f64]| multiplied(row, 0..DOFS, factor);
        let all = Operation::new(Cause::DegreesForRadians, all).related(relation);
        found.push(Operation { is_scalar: true, ..all });
        for at in ROTATIONS {
            let one = move |row: &mut [f64]| multiplied(row, at..at + 3, factor);
            found.push(Operation::new(Cause::DegreesForRadians, one).related(relation));
        }
    }
    for (factor, relation) in [(1e3, "1000 × expected"), (1e-3, "0.001 × expected")] {
        found.push(both(Cause::LengthUnit, ROTATIONS, factor).related(relation));
        found.push(both(Cause::LengthUnit, DISPLACEMENTS, factor).related(relation));
        let all = move |row: &mut [f64]| multiplied(row, 0..DOFS, factor);
        let all = Operation::new(Cause::LengthUnit, all).related(relation);
        found.push(Operation { is_scalar: true, ..all });
    }
    for (cause, factor, share) in
        [(Cause::RotationHalved, 0.5, "half"), (Cause::RotationDoubled, 2.0, "twice")]
    {
        let told = |whose: &str| format!("what is expected with {share} the spin of {whose}");
        for (at, whose) in ROTATIONS.into_iter().zip(["a", "b"]) {
            let one = Operation::new(cause, move |row: &mut [f64]| multiplied(row, at..at + 3, factor));
            found.push(one.known().of_rates(told(whose)));
        }
        found.push(both(cause, ROTATIONS, factor).of_rates(told("both nodes")));
    }
    for (from, to) in [(THETA_A, THETA_B), (THETA_B, THETA_A)] {
        let moved = move |row: &mut [f64]| {
            for i in 0..3 {
                row[to + i] += row[from + i];
                row[from + i] = 0.0;
            }
        };
        found
            .push(Operation::new(Cause::LeverAtB, moved).related("the moments of both nodes at one of them"));
    }
    const RATES: [&str; 6] = [
        "the velocity of a",
        "the spin of a",
        "the flow rate at a",
        "the velocity of b",
        "the spin of b",
        "the flow rate at b",
    ];
    let same = Operation::new(Cause::SameSignForBoth, |row: &mut [f64]| multiplied(row, 0..XB, -1.0));
    found.push(same.known().of_rates("what is expected with the other sign of the rates of a"));
    found.push(Operation::new(Cause::NodeLeftOut, |row| multiplied(row, 0..XB, 0.0)));
    let of_b = Operation::new(Cause::NodeLeftOut, |row: &mut [f64]| multiplied(row, XB..DOFS, 0.0));
    found.push(of_b.of_rates("what is expected without the rates of b"));
    for (cause, factor, how) in
        [(Cause::BlockReversed, -1.0, "with the other sign of"), (Cause::BlockMissing, 0.0, "without")]
    {
        let told = |rates: &str| format!("what is expected {how} {rates}");
        for (block, rates) in BLOCKS.into_iter().zip(RATES) {
            let one = Operation::new(cause, move |row: &mut [f64]| multiplied(row, block.clone(), factor));
            found.push(one.of_rates(told(rates)));
        }
        found.push(both(cause, ROTATIONS, factor).of_rates(told("the spins")));
        found.push(both(cause, DISPLACEMENTS, factor).of_rates(told("the velocities")));
        let flows = Operation::new(cause, move |row: &mut [f64]| {
            multiplied(row, PSI_A..XB, factor);
            multiplied(row, DOFS - 1..DOFS, factor);
        });
        found.push(flows.of_rates(told("the flow rates")));
    }
    found
}

/// Other orders of the columns.
fn of_order() -> Vec<Operation> {
    let mut found = Vec::new();
    let mut order = |order: [usize; DOFS], is_known: bool| {
        let change = move |row: &mut [f64]| {
            let from = row.to_vec();
            order.iter().enumerate().for_each(|(j, k)| row[j] = from[*k]);
        };
        found.push(Operation { is_known, ..Operation::new(Cause::ColumnsSwapped, change) });
    };
    let swapped = |pairs: &[(usize, usize)]| {
        let mut all: [usize; DOFS] = std::array::from_fn(|j| j);
        pairs.iter().for_each(|(x, y)| all.swap(*x, *y));
        all
    };
    for at in [XA, THETA_A, XB, THETA_B] {
        order(swapped(&[(at, at + 2)]), false);
        order(swapped(&[(at, at + 1)]), true);
        order(swapped(&[(at + 1, at + 2)]), true);
    }
    for (x, y) in [(0, 1), (1, 2), (0, 2)] {
        for ats in [[THETA_A, THETA_B], [XA, XB]] {
            order(swapped(&ats.map(|at| (at + x, at + y))), false);
        }
        order(swapped(&[XA, THETA_A, XB, THETA_B].map(|at| (at + x, at + y))), false);
    }
    // Rotations before displacements; displacements of both nodes before rotations of both.
    let rotations_first = [(0, 3), (1, 4), (2, 5)];
    let of_both = rotations_first.into_iter().chain(rotations_first.map(|(x, y)| (x + XB, y + XB)));
    order(swapped(&of_both.collect::<Vec<_>>()), false);
    order([0, 1, 2, 7, 8, 9, 6, 3, 4, 5, 10, 11, 12, 13], false);
    // Rotations, and displacements, of the nodes exchanged.
    order(swapped(&[(3, 10), (4, 11), (5, 12)]), false);
    order(swapped(&[(0, 7), (1, 8), (2, 9)]), false);
    let cycled = |by: usize| -> [usize; DOFS] {
        std::array::from_fn(|j| if j % XB == PSI_A { j } else { j - j % XB % 3 + (j % XB % 3 + by) % 3 })
    };
    order(cycled(1), false);
    order(cycled(2), false);
    let exchanged: [usize; DOFS] = std::array::from_fn(|j| (j + XB) % DOFS);
    found.push(
        Operation::new(Cause::NodesSwapped, move |row: &mut [f64]| {
            let from = row.to_vec();
            exchanged.iter().enumerate().for_each(|(j, k)| row[j] = from[*k]);
        })
        .known(),
    );
    found
}
