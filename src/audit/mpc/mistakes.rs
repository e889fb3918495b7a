//! Mistakes in the equations of a multi-point constraint and in their derivatives, made in the right numbers.

use super::MpcCase;
use crate::audit::diagnosis::Cause;
use crate::audit::mutant::Mistake;
use crate::audit::quantity::Quantity;
use crate::audit::sheet::{Change, Sheet};
use crate::measure::Unit;
use crate::mpc::{DOFS, Dofs, Kind, PHI, ROWS, THETA_M, THETA_S, XM, XS};
use crate::vector::{Vector, apply, apply_transposed, cross, dot};
use std::f64::consts::PI;
use std::ops::Range;

/// Where the rotations of the two nodes stand.
const ROTATIONS: [usize; 2] = [THETA_S, THETA_M];

/// The right numbers of one sheet, by equation.
struct Right<'a> {
    sheet: &'a Sheet,
    /// The equations (rows of the constraint) that the rows of the sheet are of.
    equations: Vec<usize>,
    found: Vec<Change>,
}

impl Right<'_> {
    fn at(&self, row: usize, j: usize) -> f64 {
        self.sheet.want(row, j)
    }

    fn block(&self, row: usize, at: usize) -> Vector<f64> {
        [0, 1, 2].map(|i| self.at(row, at + i))
    }

    fn add(&mut self, mistake: Mistake, changes: Vec<(usize, f64)>) {
        self.found.push(Change { mistake, changes });
    }

    /// Entries of a row, changed.
    fn changed(&self, row: usize, columns: Range<usize>, f: impl Fn(usize) -> f64) -> Vec<(usize, f64)> {
        let width = self.sheet.width();
        columns.map(|j| (row * width + j, f(j))).collect()
    }

    fn is_angle(&self, row: usize) -> bool {
        self.equations.get(row).is_some_and(|equation| Kind::row_unit(*equation) == Unit::Angle)
    }

    /// Exchanged equations of one unit.
    fn rows_swapped(&mut self) {
        let width = self.sheet.width();
        for row in 0..self.equations.len() {
            for other in 0..row {
                if self.is_angle(other) != self.is_angle(row) {
                    continue;
                }
                let mut changes = self.changed(row, 0..width, |j| self.at(other, j));
                changes.extend(self.changed(other, 0..width, |j| self.at(row, j)));
                self.add(Mistake::RowsSwapped, changes);
            }
        }
    }

    fn values(&mut self) {
        for row in (0..self.equations.len()).filter(|row| self.is_angle(*row)).collect::<Vec<_>>() {
            self.add(Mistake::DegreesForRadians, self.changed(row, 0..1, |_| self.at(row, 0).to_degrees()));
            self.add(Mistake::WrongParity, self.changed(row, 0..1, |_| self.at(row, 0) + PI));
        }
    }

    fn first_derivatives(&mut self, triads: [&[Vector<f64>; 3]; 2]) {
        for row in 0..self.equations.len() {
            let at = |j: usize| self.at(row, j);
            let mut made = vec![
                (Mistake::NodesSwapped, self.changed(row, 0..PHI, |j| at((j + XM) % PHI))),
                (Mistake::SameSignForBoth, self.changed(row, XS..XM, |j| -at(j))),
            ];
            let mut degrees = Vec::new();
            for (theta, triad) in ROTATIONS.into_iter().zip(triads) {
                let block = self.block(row, theta);
                let local = apply_transposed(triad, block);
                made.push((Mistake::RotationHalved, self.changed(row, theta..theta + 3, |j| at(j) / 2.0)));
                made.push((
                    Mistake::RotationTakenAsLocal,
                    self.changed(row, theta..theta + 3, |j| local[j - theta]),
                ));
                degrees.extend(self.changed(row, theta..theta + 3, |j| at(j).to_radians()));
            }
            for start in [XS, THETA_S, XM, THETA_M] {
                for j in start..start + 2 {
                    let swapped = self.changed(row, j..j + 2, |n| at(2 * j + 1 - n));
                    made.push((Mistake::ColumnsSwapped, swapped));
                }
            }
            if self.is_angle(row) {
                degrees = self.changed(row, 0..DOFS, |j| at(j).to_degrees());
            }
            made.push((Mistake::DegreesForRadians, degrees));
            made.into_iter().for_each(|(mistake, changes)| self.add(mistake, changes));
        }
        // Three equations of one vector.
        for first in [0, 3] {
            let rows: Vec<usize> =
                (first..first + 3).filter_map(|k| self.equations.iter().position(|e| *e == k)).collect();
            let [x, y, z] = rows.as_slice() else { continue };
            for start in [XS, THETA_S, XM, THETA_M] {
                let all = [*x, *y, *z];
                let block = all.map(|row| self.block(row, start));
                let changes = all
                    .iter()
                    .enumerate()
                    .flat_map(|(n, row)| self.changed(*row, start..start + 3, move |j| block[j - start][n]));
                let changes = changes.collect();
                self.add(Mistake::BlockTransposed, changes);
            }
        }
    }

    /// `rows` are the first derivatives. Each matrix is symmetric: transposing it is no mistake.
    fn second_derivatives(&mut self, rows: &[Dofs<f64>]) {
        let turns = |j: usize| ROTATIONS.into_iter().find(|theta| (*theta..theta + 3).contains(&j));
        for (row, gradient) in rows.iter().enumerate() {
            let at = |i: usize, j: usize| self.at(row, i * DOFS + j);
            let all = |f: &dyn Fn(usize, usize) -> f64| {
                self.changed(row, 0..DOFS * DOFS, |n| f(n / DOFS, n % DOFS))
            };
            let other = |j: usize| if j < PHI { (j + XM) % PHI } else { j };
            let halved =
                |i, j| if turns(i).is_some() && turns(j).is_some() { at(i, j) / 2.0 } else { at(i, j) };
            let bracket = |i: usize, j: usize| {
                let (Some(theta), true) = (turns(i), turns(i) == turns(j)) else { return 0.0 };
                let axis = |n: usize| [0, 1, 2].map(|m| if theta + m == n { 1.0 } else { 0.0 });
                dot(cross(axis(i), axis(j)), [0, 1, 2].map(|m| gradient[theta + m])) / 2.0
            };
            let made = [
                (Mistake::NodesSwapped, all(&|i, j| at(other(i), other(j)))),
                (Mistake::RotationHalved, all(&halved)),
                (Mistake::BracketKept, all(&|i, j| at(i, j) + bracket(i, j))),
            ];
            made.into_iter().for_each(|(mistake, changes)| self.add(mistake, changes));
        }
    }

    /// `rows` are the first derivatives, `along` the velocities or accelerations of the degrees of freedom.
    fn rates(&mut self, rows: &[Dofs<f64>], along: &Dofs<f64>, has_quadratic_part: bool) {
        for (row, gradient) in rows.iter().enumerate() {
            let sum = |columns: Range<usize>| -> f64 { columns.map(|j| gradient[j] * along[j]).sum() };
            let x = self.at(row, 0);
            let mut one = |mistake, x| self.add(mistake, self.changed(row, 0..1, |_| x));
            one(Mistake::RatesOfAIgnored, x - sum(XS..XM));
            if has_quadratic_part {
                one(Mistake::QuadraticPartMissing, sum(0..DOFS));
            }
            if self.is_angle(row) {
                self.add(Mistake::DegreesForRadians, self.changed(row, 0..1, |_| x.to_degrees()));
            }
        }
    }
}

impl MpcCase {
    fn triads(&self) -> [&[Vector<f64>; 3]; 2] {
        [&self.state.slave.rotation, &self.state.master.rotation]
    }

    /// The equations that there are.
    pub(super) fn equations(&self) -> Vec<usize> {
        (0..ROWS).filter(|row| self.constraint.rows()[*row]).collect()
    }

    /// Gives the sheets every mistake that can be made in them, and other conventions.
    pub(super) fn add_mistakes(&self, sheets: &mut [Sheet]) {
        let first = sheets.iter().find(|sheet| sheet.quantity == Quantity::FirstDerivatives);
        let rows: Vec<Dofs<f64>> = first.map_or_else(Vec::new, |sheet| {
            (0..sheet.rows.len()).map(|row| std::array::from_fn(|j| sheet.want(row, j))).collect()
        });
        for sheet in sheets {
            sheet.mistakes = self.mistakes(sheet, &rows);
            sheet.conventions = self.conventions(sheet);
        }
    }

    /// Every mistake in a quantity, wherever it can be made; `rows` are the first derivatives.
    fn mistakes(&self, sheet: &Sheet, rows: &[Dofs<f64>]) -> Vec<Change> {
        let mut right = Right { sheet, equations: self.equations(), found: Vec::new() };
        right.rows_swapped();
        match sheet.quantity {
            Quantity::Value => right.values(),
            Quantity::FirstDerivatives => right.first_derivatives(self.triads()),
            Quantity::SecondDerivatives => right.second_derivatives(rows),
            Quantity::Rate => right.rates(rows, &self.state.velocity, false),
            Quantity::Acceleration => right.rates(rows, &self.state.acceleration, true),
            _ => {}
        }
        right.found
    }

    /// Changes of convention of rows that are no mistakes of the self-test.
    fn conventions(&self, sheet: &Sheet) -> Vec<(Cause, Vec<(usize, f64)>)> {
        let mut found = Vec::new();
        if sheet.quantity != Quantity::FirstDerivatives {
            return found;
        }
        for row in 0..sheet.rows.len() {
            for (theta, triad) in ROTATIONS.into_iter().zip(self.triads()) {
                let block = [0, 1, 2].map(|i| sheet.want(row, theta + i));
                let places = |block: Vector<f64>| {
                    block.into_iter().enumerate().map(|(i, x)| (row * DOFS + theta + i, x)).collect()
                };
                found.push((Cause::RotationTurnedTwice, places(apply(triad, block))));
                found.push((Cause::RotationDoubled, places(block.map(|x| 2.0 * x))));
            }
        }
        found
    }
}
