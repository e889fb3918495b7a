//! In which directions a state may change without leaving its equations.
//!
//! What decays moves along them alone. Newton's method needs the derivatives of a flow along these few, where those by each number would take an
//! instant for each.

use crate::motion::rows::{Assembled, Layout, Row, Trouble};
use crate::motion::state::WORKS;
use crate::number::Number;
use nalgebra::{DMatrix, DVector};

/// By which part of its size each number is moved for a difference.
pub(crate) const DIFFERENCE: f64 = 6e-8;

/// Directions of y = (q, v, …), and how much of each is in a change of y.
#[derive(Clone, Debug)]
pub(crate) struct Tangent {
    /// A column for each, as long as the sizes of what it moves.
    pub(crate) directions: DMatrix<f64>,
    /// A line for each.
    pub(crate) parts: DMatrix<f64>,
    /// How many move positions: the first.
    pub(crate) positions: usize,
}

/// The equations at y.
pub(crate) type Equations<'a, R> = dyn Fn(&[R]) -> Result<Assembled<R>, Trouble> + 'a;

/// What tells where a state may go.
pub(crate) struct Ways<'a, R> {
    pub(crate) layout: &'a Layout,
    /// q̇ at y.
    pub(crate) moving: &'a dyn Fn(&[R]) -> Vec<R>,
    pub(crate) assemble: &'a Equations<'a, R>,
}

impl Tangent {
    /// Each number by itself, of such sizes; the first are positions.
    pub(crate) fn whole<R: Number>(sizes: &[R], positions: usize) -> Self {
        let diagonal = |of: &dyn Fn(f64) -> f64| {
            DMatrix::from_diagonal(&DVector::from_iterator(sizes.len(), sizes.iter().map(|x| of(x.to_f64()))))
        };
        Self { directions: diagonal(&|x| x), parts: diagonal(&f64::recip), positions }
    }

    /// Those of y that equations leave, numbers in units of such sizes. A change of positions takes the velocities along that equations ask for.
    pub(crate) fn at<R: Number>(y: &[R], sizes: &[R], ways: &Ways<'_, R>) -> Result<Self, Trouble> {
        let n = ways.layout.columns.len();
        let sizes: Vec<f64> = sizes.iter().map(|x| x.to_f64()).collect();
        let (of_positions, of_rates) = (&sizes[..n], &sizes[n..2 * n]);
        let here = (ways.assemble)(y)?;
        let positions = Free::of(&here, ways.layout, of_positions, |row| row.residual.is_some());
        let rates = Free::of(&here, ways.layout, of_rates, |row| row.rate.is_some());
        // Turns change by what is made of angular velocities.
        let now = (ways.moving)(y);
        let moves = positions.free.column_iter().map(|free| {
            let mut moved = y.to_vec();
            for i in 0..n {
                moved[n + i] = moved[n + i] + R::from_f64(free[i] * of_positions[i]);
            }
            let there = (ways.moving)(&moved);
            DVector::from_fn(n, |i, _| (there[i] - now[i]).to_f64() / of_positions[i])
        });
        let moves: Vec<DVector<f64>> = moves.collect();
        let moves =
            if moves.is_empty() { DMatrix::zeros(n, 0) } else { DMatrix::from_columns(&moves).qr().q() };
        let others = (2 * n + WORKS).min(y.len())..y.len();
        let count = moves.ncols() + rates.free.ncols() + others.len();
        let mut directions = DMatrix::zeros(y.len(), count);
        let mut parts = DMatrix::zeros(count, y.len());
        let step = R::from_f64(DIFFERENCE);
        for (d, by) in moves.column_iter().enumerate() {
            let mut moved = y.to_vec();
            for i in 0..n {
                moved[i] = moved[i] + step * R::from_f64(by[i] * of_positions[i]);
            }
            let there = (ways.assemble)(&moved)?;
            let change = |row: &usize| {
                let [then, now] = [&there, &here].map(|of| of.rows.get(*row).and_then(|row| row.rate));
                Some(((then? - now?) / step).to_f64())
            };
            let along = rates.answer(ways.layout.kept.iter().filter_map(change));
            let scale = 1.0 / along.amax().max(1.0);
            for i in 0..n {
                directions[(i, d)] = scale * by[i] * of_positions[i];
                directions[(n + i, d)] = -scale * along[i] * of_rates[i];
                parts[(d, i)] = by[i] / (scale * of_positions[i]);
            }
        }
        for (d, by) in (moves.ncols()..).zip(rates.free.column_iter()) {
            for i in 0..n {
                directions[(n + i, d)] = by[i] * of_rates[i];
                parts[(d, n + i)] = by[i] / of_rates[i];
            }
        }
        for (d, i) in (count - others.len()..).zip(others) {
            directions[(i, d)] = sizes[i];
            parts[(d, i)] = 1.0 / sizes[i];
        }
        Ok(Self { directions, parts, positions: moves.ncols() })
    }
}

/// What equations leave free of unknowns that are divided by their sizes.
struct Free {
    /// Orthonormal columns.
    free: DMatrix<f64>,
    /// Q and R of Aᵀ = Q R, where A are the equations.
    normal: DMatrix<f64>,
    upper: DMatrix<f64>,
}

impl Free {
    fn of<R: Number>(
        assembled: &Assembled<R>,
        layout: &Layout,
        sizes: &[f64],
        counts: impl Fn(&Row<R>) -> bool,
    ) -> Self {
        let n = sizes.len();
        let rows: Vec<&Row<R>> =
            layout.kept.iter().filter_map(|row| assembled.rows.get(*row)).filter(|row| counts(row)).collect();
        let mut transposed = DMatrix::zeros(n, rows.len());
        for (r, row) in rows.iter().enumerate() {
            for (dof, entry) in assembled.lines.of(row.coefficients) {
                if let Some(place) = layout.place[*dof] {
                    transposed[(place, r)] += entry.to_f64() * sizes[place];
                }
            }
        }
        let rank = rows.len().min(n);
        let found = transposed.qr();
        let mut all = DMatrix::identity(n, n);
        found.q_tr_mul(&mut all);
        Self { free: all.rows(rank, n - rank).transpose(), normal: found.q(), upper: found.r() }
    }

    /// The least change of unknowns by which equations change so much.
    fn answer(&self, changes: impl Iterator<Item = f64>) -> DVector<f64> {
        let changes = DVector::from_vec(changes.collect());
        let found = (changes.len() == self.upper.nrows() && self.upper.is_square())
            .then(|| self.upper.tr_solve_upper_triangular(&changes))
            .flatten();
        found.map_or_else(|| DVector::zeros(self.normal.nrows()), |found| &self.normal * found)
    }
}
