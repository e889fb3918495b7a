//! Slips of several components as they begin.
//!
//! A slip that grazes begins as v ~ t². Its friction has the direction of v, which follows the force at once: next to rest the equations are
//! stiff without bound, μ F_N/(m |v|). So R_k v_k are numbers of their own, integrated from zero: their direction is exact though they are tiny.
//! The stages of collocation are solved for them by Newton's method, with their slopes at each stage. Other numbers follow.
//!
//! Where they begin from rest, the first iteration has the direction that the force has there; later ones turn it. The method is derived here; the
//! turntable of `references/` is solved apart by SciPy's Radau method (`scripts/reference/reference_solve.py`).

use crate::motion::rows::Trouble;
use crate::number::Number;
use crate::time::integrate::Flow;
use nalgebra::{DMatrix, DVector};

/// A slip that begins: the places of its R_k v_k in y, with the direction that it has at rest.
pub(crate) type Onset<R> = Vec<(usize, R)>;

/// By which part of a velocity it is moved for a difference.
const DIFFERENCE: f64 = 1e-7;

/// Newton's step for the stages of slips that begin, on doubles.
pub(crate) struct Turns<'a, R> {
    onsets: &'a [Onset<R>],
    /// Which of them are at rest as the step begins.
    at_rest: Vec<bool>,
    /// The matrix a of stages.
    matrix: DMatrix<f64>,
}

impl<'a, R: Number> Turns<'a, R> {
    /// For a step from y.
    pub(crate) fn new(onsets: &'a [Onset<R>], y: &[R], matrix: &[Vec<R>]) -> Self {
        let is_zero = |(place, _): &(usize, R)| !R::ZERO.less(y[*place].magnitude());
        let at_rest = onsets.iter().map(|onset| onset.iter().all(is_zero)).collect();
        let n = matrix.len();
        Self { onsets, at_rest, matrix: DMatrix::from_fn(n, n, |i, j| matrix[i][j].to_f64()) }
    }

    fn resting(&self) -> impl Iterator<Item = &'a Onset<R>> + '_ {
        self.onsets.iter().zip(&self.at_rest).filter(|(_, at_rest)| **at_rest).map(|(onset, _)| onset)
    }

    fn places(&self) -> impl Iterator<Item = usize> + '_ {
        self.onsets.iter().flatten().map(|(place, _)| *place)
    }

    /// A stage before anything is known of it: what begins at rest has the direction it has there.
    pub(crate) fn rest(&self, stage: &mut [R]) {
        self.resting().flatten().for_each(|(place, _)| stage[*place] = R::ZERO);
    }

    /// The rates that are found there: along that direction alone, which the next iteration turns.
    pub(crate) fn begin(&self, rates: &mut [R]) {
        for onset in self.resting() {
            let along = onset.iter().fold(R::ZERO, |sum, (place, n)| sum + rates[*place] * *n);
            onset.iter().for_each(|(place, n)| rates[*place] = along * *n);
        }
    }

    /// The derivatives of all rates by each velocity at a stage.
    pub(crate) fn slopes(
        &self,
        flow: &mut Flow<'_, R>,
        (time, stage, rates): (R, &[R], &[R]),
    ) -> Result<Vec<Vec<f64>>, Trouble> {
        let mut found = Vec::new();
        for onset in self.onsets {
            let size = onset.iter().map(|(place, _)| stage[*place].to_f64().powi(2)).sum::<f64>().sqrt();
            for (place, _) in onset {
                if size <= f64::MIN_POSITIVE {
                    found.push(vec![0.0; rates.len()]);
                    continue;
                }
                let by = R::from_f64(size * DIFFERENCE);
                let mut moved = stage.to_vec();
                moved[*place] = moved[*place] + by;
                let there = flow(time, &moved)?;
                let pairs = there.rates.iter().zip(rates);
                found.push(pairs.map(|(then, now)| ((*then - *now) / by).to_f64()).collect());
            }
        }
        Ok(found)
    }

    /// By what the stages change where they lack so much: x − h ∂f/∂w Σ a_ij x_j for the velocities w, and what follows for all others.
    pub(crate) fn changes(
        &self,
        lacks: Vec<Vec<R>>,
        slopes: &[Vec<Vec<f64>>],
        h: f64,
    ) -> Option<Vec<Vec<R>>> {
        let places: Vec<usize> = self.places().collect();
        let (stages, m) = (lacks.len(), places.len());
        let matrix = DMatrix::from_fn(stages * m, stages * m, |row, column| {
            let ((i, p), (j, q)) = ((row / m, row % m), (column / m, column % m));
            let one = if row == column { 1.0 } else { 0.0 };
            // Σ_r ∂f_p/∂w_r h a_ij x_jr
            one - h * self.matrix[(i, j)] * slopes[i][q][places[p]]
        });
        let right = DVector::from_fn(stages * m, |row, _| lacks[row / m][places[row % m]].to_f64());
        let found = matrix.lu().solve(&right)?;
        let mut changes = lacks;
        for (i, changes) in changes.iter_mut().enumerate() {
            let moved: Vec<f64> = (0..m)
                .map(|q| h * (0..stages).map(|j| self.matrix[(i, j)] * found[j * m + q]).sum::<f64>())
                .collect();
            for (place, change) in changes.iter_mut().enumerate() {
                match places.iter().position(|known| *known == place) {
                    Some(p) => *change = R::from_f64(found[i * m + p]),
                    None => {
                        let follows: f64 =
                            slopes[i].iter().zip(&moved).map(|(slope, by)| slope[place] * by).sum();
                        *change = *change + R::from_f64(follows);
                    }
                }
            }
        }
        Some(changes)
    }
}

/// How often a slip's direction decays to where it belongs, by unit of time: the largest derivative of its acceleration by its velocity.
pub(crate) fn decay<R: Number>(
    flow: &mut Flow<'_, R>,
    (time, y): (R, &[R]),
    places: &[usize],
) -> Result<f64, Trouble> {
    let onset: Onset<R> = places.iter().map(|place| (*place, R::ZERO)).collect();
    let onsets = [onset];
    let turns = Turns::new(&onsets, y, &[]);
    let rates = flow(time, y)?.rates;
    let slopes = turns.slopes(flow, (time, y, &rates))?;
    let all = slopes.iter().flat_map(|column| places.iter().map(|place| column[*place].abs()));
    Ok(all.fold(0.0, f64::max))
}
