//! Mistakes in the equations of a multi-point constraint and in their derivatives, made in the right numbers.

use crate::case::failing::MpcCase;
use crate::case::quantity::Quantity;
use crate::judge::table::ResultTable;
use crate::mutants::diagnosis::{Cause, Gather, Hypothesis, conventions};
use crate::mutants::mutant::{
    Mistake, Mutant, OfRow, of_angle, of_matrix, of_rate, of_row, put, transposed_blocks,
};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::mpc::{
    DOFS, Dofs, MpcType, PHI, RHO, ROWS, State, THETA_M, THETA_S, Translation, XM, XS,
};
use pintle_kinematics::vector::Vector;

/// The right numbers of one table, by equation.
struct Right<'a> {
    table: &'a ResultTable,
    /// The equations (rows of the constraint) that the rows of the table are of.
    equations: Vec<usize>,
    found: Vec<Mutant>,
}

impl Right<'_> {
    /// The numbers of a row.
    fn row(&self, row: usize) -> Vec<f64> {
        (0..self.table.width()).map(|j| self.table.want(row, j)).collect()
    }

    /// Mistakes in entries of a row.
    fn add(&mut self, row: usize, made: impl IntoIterator<Item = (Mistake, OfRow)>) {
        self.found.extend(made.into_iter().map(|(mistake, changes)| Mutant::of_row(mistake, row, changes)));
    }

    fn is_angle(&self, row: usize) -> bool {
        self.equations.get(row).is_some_and(|equation| MpcType::row_unit(*equation) == Unit::Angle)
    }

    /// Exchanged equations of one unit.
    fn rows_swapped(&mut self) {
        for row in 0..self.equations.len() {
            for other in 0..row {
                if self.is_angle(other) != self.is_angle(row) {
                    continue;
                }
                let of = |to: usize, from: usize| {
                    self.row(from).into_iter().enumerate().map(move |(j, x)| (to, j, x))
                };
                let swapped = Mutant::many(Mistake::RowsSwapped, of(row, other).chain(of(other, row)));
                self.found.push(swapped);
            }
        }
    }

    /// Three equations of one vector.
    fn blocks_transposed(&mut self) {
        for first in [0, 3] {
            let rows: Vec<usize> =
                (first..first + 3).filter_map(|k| self.equations.iter().position(|e| *e == k)).collect();
            let Ok(rows) = <[usize; 3]>::try_from(rows) else { continue };
            let numbers = rows.map(|row| self.row(row));
            let placed = |block: [_; 9]| block.map(|(row, at, x): (usize, usize, f64)| (rows[row], at, x));
            let made = transposed_blocks(numbers.each_ref().map(Vec::as_slice));
            self.found.extend(made.map(|block| Mutant::many(Mistake::BlockTransposed, placed(block))));
        }
    }
}

/// Changes of single numbers.
fn alone(made: impl Iterator<Item = (Mistake, f64)>) -> impl Iterator<Item = (Mistake, OfRow)> {
    made.map(|(mistake, x)| (mistake, vec![(0, x)]))
}

impl MpcCase {
    fn triads(&self) -> [&[Vector<f64>; 3]; 2] {
        [&self.state.slave.rotation, &self.state.master.rotation]
    }

    /// The equations that there are.
    pub(super) fn equations(&self) -> Vec<usize> {
        (0..ROWS).filter(|row| self.constraint.rows()[*row]).collect()
    }

    /// Gives the tables of these equations every mistake that can be made in them, and other conventions.
    pub(super) fn add_mistakes(&self, tables: &mut [ResultTable], equations: &[usize]) {
        let first = tables.iter().find(|table| table.quantity == Quantity::FirstDerivatives);
        let rows: Vec<Dofs<f64>> = first.map_or_else(Vec::new, |table| {
            (0..table.rows.len()).map(|row| std::array::from_fn(|j| table.want(row, j))).collect()
        });
        self.add_mistakes_of(&rows, tables, equations);
    }

    /// The same of tables that need not be all of the state, whose first derivatives are `rows`.
    fn add_mistakes_of(&self, rows: &[Dofs<f64>], tables: &mut [ResultTable], equations: &[usize]) {
        let elsewhere = self.elsewhere();
        for table in tables {
            table.mistakes = self.mistakes(table, rows, equations);
            table.conventions = self.conventions(table, equations);
            let quantity = table.quantity;
            table.conventions.extend(elsewhere.iter().flat_map(|other| other.of(quantity, equations)));
        }
    }

    /// Gives tables that need not be all of the state what may explain them.
    pub(crate) fn explain(&self, tables: &mut [ResultTable], equations: &[usize]) {
        let got = self.said();
        let rows: Vec<Dofs<f64>> =
            equations.iter().map(|row| got.jacobian[*row].unwrap_or([0.0; DOFS])).collect();
        self.add_mistakes_of(&rows, tables, equations);
    }

    /// Every mistake in a quantity, wherever it can be made; `rows` are the first derivatives.
    fn mistakes(&self, table: &ResultTable, rows: &[Dofs<f64>], equations: &[usize]) -> Vec<Mutant> {
        let mut right = Right { table, equations: equations.to_vec(), found: Vec::new() };
        right.rows_swapped();
        for (row, gradient) in rows.iter().enumerate() {
            let (numbers, is_angle) = (right.row(row), right.is_angle(row));
            let State { velocity, acceleration, .. } = &self.state;
            match (table.quantity, numbers.as_slice()) {
                (Quantity::Value, [x]) if is_angle => right.add(row, alone(of_angle(*x, 0.0))),
                (Quantity::FirstDerivatives, all) => {
                    right.add(row, of_row(all, is_angle, Some(self.triads())));
                }
                // Each matrix is symmetric: transposing it is no mistake.
                (Quantity::SecondDerivatives, all) => right.add(row, of_matrix(all, DOFS, gradient)),
                (Quantity::Rate, [x]) => {
                    right.add(row, alone(of_rate(*x, (gradient, velocity), (is_angle, false))));
                }
                (Quantity::Acceleration, [x]) => {
                    right.add(row, alone(of_rate(*x, (gradient, acceleration), (is_angle, true))));
                }
                _ => {}
            }
        }
        if table.quantity == Quantity::FirstDerivatives {
            right.blocks_transposed();
        }
        right.found
    }

    /// Changes of convention of rows that are no mistakes of the self-test.
    fn conventions(&self, table: &ResultTable, equations: &[usize]) -> Vec<Hypothesis> {
        let rows = if table.quantity == Quantity::FirstDerivatives { table.rows.len() } else { 0 };
        let is_carried = self.constraint.kind().entry().translation == Translation::Carried;
        let mut found = Vec::new();
        for row in 0..rows {
            let numbers: Vec<f64> = (0..DOFS).map(|j| table.want(row, j)).collect();
            let made = conventions(&numbers, self.triads());
            found.extend(made.into_iter().map(|(cause, changes)| Hypothesis::of_row(cause, row, changes)));
            for (columns, what) in [
                (XS..XM, "the columns of S"),
                (XM..PHI, "the columns of M"),
                (PHI..DOFS, "the columns of the hinges"),
            ] {
                found.row(Cause::NodeLeftOut, row, columns.map(|j| (j, 0.0)), format!("zero in {what}"));
            }
            let what = "minus what is expected in the columns of the hinges";
            found.row(Cause::BlockReversed, row, (PHI..DOFS).map(|j| (j, -numbers[j])), what);
            if !is_carried || equations.get(row).is_none_or(|equation| *equation >= RHO) {
                continue;
            }
            let lever = [0, 1, 2].map(|i| numbers[THETA_M + i]);
            let block = |factor: f64| put(THETA_M, lever.map(|x| factor * x));
            for (cause, factor, how) in [
                (Cause::GeometricTermMissing, 0.0, "without"),
                (Cause::GeometricTermDoubled, 2.0, "with twice"),
                (Cause::LeverReversed, -1.0, "with minus"),
            ] {
                let what = format!("what is expected {how} the term of the arm C_M (X_S − X_M)");
                found.row(cause, row, block(factor), what);
            }
            let at_s = block(0.0).into_iter().chain(put(THETA_S, lever));
            found.row(Cause::LeverAtB, row, at_s, "what is expected with the term of the arm at S");
        }
        found
    }
}
