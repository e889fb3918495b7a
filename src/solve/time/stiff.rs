//! Stiff motion: something decays much faster than what moves, as between a hard spring and a hard dashpot.
//!
//! Explicit steps then are as short as what has long decayed would need. Stages of collocation are solved for instead, by Newton's method with
//! the Jacobian A of the flow ẏ = f(t, y). It need not be exact: the stages are those of f, whatever A leads to them.

use crate::motion::rows::Trouble;
use crate::motion::tangent::{DIFFERENCE, Tangent};
use crate::number::{Number, larger};
use crate::time::integrate::{Flow, Slope};
use nalgebra::{Complex, DMatrix, DVector, Dyn, LU, Schur};
use std::ops::Range;

/// Motion is stiff where a part decays so often within a step: explicit ones are not stable for much more.
const DECAYS: f64 = 1.0;

/// And where rates change by less than this part of what they would if it had not decayed.
const LEFT: f64 = 0.02;

/// The most iterations for eigenvalues.
const ITERATIONS: usize = 10_000;

/// The sizes of numbers y. `allowed` is the largest error of each, and last the relative one.
pub(crate) fn sizes<R: Number>(y: &[R], allowed: &[R]) -> Vec<R> {
    let relative = allowed.last().copied().unwrap_or(R::integer(1));
    y.iter().zip(allowed).map(|(y, most)| larger(y.magnitude(), *most / relative)).collect()
}

/// The derivatives of the rates at y along directions, by differences: a column for each.
pub(crate) fn derivatives<R: Number>(
    flow: &mut Flow<'_, R>,
    (t, y, slope): (R, &[R], &Slope<R>),
    directions: &DMatrix<f64>,
) -> Result<DMatrix<f64>, Trouble> {
    let step = R::from_f64(DIFFERENCE);
    let mut found = DMatrix::zeros(y.len(), directions.ncols());
    for (mut column, direction) in found.column_iter_mut().zip(directions.column_iter()) {
        let moved: Vec<R> = y.iter().zip(&direction).map(|(y, by)| *y + step * R::from_f64(*by)).collect();
        let there = flow(t, &moved)?;
        for (x, (then, now)) in column.iter_mut().zip(there.rates.iter().zip(&slope.rates)) {
            *x = ((*then - *now) / step).to_f64();
        }
    }
    Ok(found)
}

/// By how much rates change along the motion in a time h, and how large they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    changes: f64,
    rates: f64,
}

impl Pace {
    /// In units of what is allowed.
    pub(crate) fn of<R: Number>(
        flow: &mut Flow<'_, R>,
        (t, y, slope): (R, &[R], &Slope<R>),
        allowed: &[R],
        h: f64,
    ) -> Result<Self, Trouble> {
        let by = R::from_f64(h * DIFFERENCE);
        let there: Vec<R> = y.iter().zip(&slope.rates).map(|(y, rate)| *y + by * *rate).collect();
        let then = flow(t + by, &there)?;
        let size = |of: &mut dyn Iterator<Item = f64>| {
            of.zip(allowed).fold(0.0_f64, |most, (x, size)| most.max((x / size.to_f64()).abs()))
        };
        let pairs = then.rates.iter().zip(&slope.rates);
        let changes = size(&mut pairs.map(|(then, now)| ((*then - *now) / by).to_f64() * h));
        Ok(Self { changes, rates: size(&mut slope.rates.iter().map(|x| x.to_f64())) })
    }

    /// Whether that is more than anything leaves of them that decays as fast as steps may go.
    pub(crate) fn is_lively(&self) -> bool {
        /// What decays more often within an explicit step makes it fail.
        const FASTEST: f64 = 64.0;
        self.is_more_than_left_by(FASTEST)
    }

    fn is_more_than_left_by(&self, decays: f64) -> bool {
        self.changes > LEFT * decays * self.rates
    }
}

/// Whether motion is stiff for steps of length h: something decays that fast, and rates change far less, for of that nothing is left.
/// The derivatives of the rates are those along the directions of a tangent.
pub(crate) fn is_stiff((tangent, derivatives): (&Tangent, &DMatrix<f64>), pace: Pace, h: f64) -> bool {
    let matrix = h * &tangent.parts * derivatives;
    if !matrix.iter().all(|x| x.is_finite()) {
        return false;
    }
    // No eigenvalue is beyond a norm of the matrix, nor its square beyond one of the square: mostly that is enough, and Schur's form is dear.
    let norm =
        |of: &DMatrix<f64>| of.row_iter().map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max);
    let is_too_slow = |largest: f64| largest < DECAYS || pace.is_more_than_left_by(largest);
    if is_too_slow(norm(&matrix)) || is_too_slow(norm(&(&matrix * &matrix)).sqrt()) {
        return false;
    }
    let Some(found) = Schur::try_new(matrix, f64::EPSILON, ITERATIONS) else { return false };
    let is_fast =
        |x: &Complex<f64>| x.re <= -DECAYS && x.im.abs() <= -x.re && !pace.is_more_than_left_by(-x.re);
    found.complex_eigenvalues().iter().any(is_fast)
}

/// The eigenvalues and eigenvectors of the matrix a of stages, on doubles. Of a pair that are conjugate the one above the real axis stands
/// for both.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    matrix: DMatrix<f64>,
    values: Vec<Complex<f64>>,
    /// For how many each stands.
    counts: Vec<f64>,
    /// By columns.
    vectors: DMatrix<Complex<f64>>,
    /// The lines of the inverse of all vectors, as columns.
    inverse: DMatrix<Complex<f64>>,
}

impl Spectrum {
    /// `None` where they cannot be formed.
    pub(crate) fn of<R: Number>(matrix: &[Vec<R>]) -> Option<Self> {
        let stages = matrix.len();
        let real = DMatrix::from_fn(stages, stages, |i, j| matrix[i][j].to_f64());
        let a = real.map(Complex::from);
        let values = Schur::try_new(real.clone(), f64::EPSILON, ITERATIONS)?.complex_eigenvalues();
        let mut vectors = DMatrix::zeros(stages, stages);
        for (m, value) in values.iter().enumerate() {
            // Inverse iteration, next to the eigenvalue.
            let near = Complex::from(value.norm() * 1e-10) + value;
            let shifted = (&a - DMatrix::identity(stages, stages) * near).lu();
            let mut vector = DVector::from_fn(stages, |i, _| Complex::new(1.0, 0.1 * i as f64));
            for _ in 0..3 {
                let solved = shifted.solve(&vector)?;
                let largest = solved.iter().map(|x| x.norm()).fold(0.0, f64::max);
                vector = solved / Complex::from(largest);
            }
            vectors.set_column(m, &vector);
        }
        let inverse = vectors.clone().try_inverse()?;
        let those: Vec<usize> = (0..stages).filter(|m| values[*m].im >= 0.0).collect();
        Some(Self {
            matrix: real,
            values: those.iter().map(|m| values[*m]).collect(),
            counts: those.iter().map(|m| if values[*m].im > 0.0 { 2.0 } else { 1.0 }).collect(),
            vectors: vectors.select_columns(&those),
            inverse: inverse.transpose().select_columns(&those),
        })
    }
}

/// How rates change at a stage: along the directions D of a tangent, of which a change has the parts P, by the derivatives C. A = C P.
pub(crate) struct Change {
    pub(crate) tangent: Tangent,
    /// A column for each direction.
    pub(crate) derivatives: DMatrix<f64>,
}

/// Newton's step for the stages of collocation, K_i = f(y + h Σ a_ij K_j), on doubles.
///
/// With the A of one stage for all, 1 − h a ⊗ P C is the matrix of P ΔK. The eigenvalues of a take it apart (Hairer, Wanner, II, IV.8). The
/// change ΔK is what lacks and h a ⊗ C (P ΔK).
///
/// Where the A of several stages are known those between are interpolated, and what such a step leaves is solved for again.
pub(crate) struct Improvement<'a> {
    spectrum: &'a Spectrum,
    h: f64,
    /// With their weights in each stage: first the one for all.
    changes: Vec<(Change, Vec<f64>)>,
    eliminated: Vec<Eliminated>,
}

impl<'a> Improvement<'a> {
    /// For a step of length h. `None` where the matrix cannot be inverted.
    pub(crate) fn new(spectrum: &'a Spectrum, of_all: Change, h: f64) -> Option<Self> {
        let Change { tangent, derivatives } = &of_all;
        let matrix = h * &tangent.parts * derivatives;
        let all = spectrum.values.iter().map(|value| Eliminated::new(&matrix, *value, tangent.positions));
        let eliminated = all.collect::<Option<_>>()?;
        let weights = vec![1.0; spectrum.matrix.nrows()];
        Some(Self { spectrum, h, changes: vec![(of_all, weights)], eliminated })
    }

    /// Whether all stages change as one.
    pub(crate) const fn is_of_one(&self) -> bool {
        self.changes.len() == 1
    }

    /// Takes the changes at other stages. `places` are those of all that are known, the first one's first; `points` those of the stages.
    pub(crate) fn refine(&mut self, others: Vec<Change>, places: &[usize], points: &[f64]) {
        let weight = |at: usize, x: f64| {
            let others = places.iter().filter(|of| **of != at);
            others.fold(1.0, |weight, of| weight * (x - points[*of]) / (points[at] - points[*of]))
        };
        self.changes.extend(others.into_iter().map(|change| (change, Vec::new())));
        for ((_, weights), at) in self.changes.iter_mut().zip(places) {
            *weights = points.iter().map(|x| weight(*at, *x)).collect();
        }
    }

    /// By what the stages change where they lack so much.
    pub(crate) fn changes<R: Number>(&self, lacks: &[Vec<R>]) -> Option<Vec<Vec<R>>> {
        /// The most solutions of what is left, and the part that counts as nothing.
        const TIMES: usize = 8;
        const LEAST: f64 = 1e-2;
        let n = lacks.first()?.len();
        let lack = DMatrix::from_fn(n, lacks.len(), |i, stage| lacks[stage][i].to_f64());
        let mut found = self.solve(&lack)?;
        let mut before = f64::INFINITY;
        for _ in 0..if self.is_of_one() { 0 } else { TIMES } {
            let change = self.solve(&(&lack - &found + self.along(&found)))?;
            let size = change.amax();
            if size > 0.5 * before {
                break;
            }
            found += change;
            before = size;
            if size < LEAST * found.amax() {
                break;
            }
        }
        let stage = |column: usize| found.column(column).iter().map(|x| R::from_f64(*x)).collect();
        Some((0..lacks.len()).map(stage).collect())
    }

    /// (1 − γ h A)⁻¹ of a difference, γ one over the number of stages (Hairer, Wanner, II, IV.8). Of what decays within the step a difference
    /// tells nothing but its rounding. `None` where that is not determined.
    pub(crate) fn damped(&self, difference: &[f64]) -> Option<Vec<f64>> {
        let (Change { tangent, derivatives }, _) = self.changes.first()?;
        let difference = DVector::from_column_slice(difference);
        let gamma = self.h / self.spectrum.matrix.nrows() as f64;
        let matrix = gamma * &tangent.parts * derivatives;
        let parts = (DMatrix::identity(matrix.nrows(), matrix.nrows()) - matrix).lu();
        let along = parts.solve(&(&tangent.parts * &difference))?;
        Some((difference + gamma * derivatives * along).as_slice().to_vec())
    }

    /// h A_i Σ a_ij ΔK_j.
    fn along(&self, changes: &DMatrix<f64>) -> DMatrix<f64> {
        let sums = self.h * changes * self.spectrum.matrix.transpose();
        let mut all = DMatrix::zeros(changes.nrows(), changes.ncols());
        for (Change { tangent, derivatives }, weights) in &self.changes {
            let mut parts = &tangent.parts * &sums;
            parts.column_iter_mut().zip(weights).for_each(|(mut column, weight)| column *= *weight);
            all += derivatives * parts;
        }
        all
    }

    /// The changes where all stages have the A of one.
    fn solve(&self, lack: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (Change { tangent, derivatives }, _) = self.changes.first()?;
        let mut apart = (&tangent.parts * lack).map(Complex::from) * &self.spectrum.inverse;
        for (m, (eliminated, count)) in self.eliminated.iter().zip(&self.spectrum.counts).enumerate() {
            let solved = eliminated.solve(apart.column(m).into_owned())? * Complex::from(*count);
            apart.set_column(m, &solved);
        }
        let along = (apart * self.spectrum.vectors.transpose()).map(|x| x.re);
        Some(lack + self.h * derivatives * along * self.spectrum.matrix.transpose())
    }
}

/// 1 − z A without positions q: x_q = (1 − z A_qq)⁻¹ (r_q + z A_qv x_v). Their rates follow from the other numbers v, and from q of the same
/// node.
struct Eliminated {
    /// (1 − z A_qq)⁻¹ in blocks.
    blocks: Vec<(Range<usize>, DMatrix<Complex<f64>>)>,
    /// z A_qv by rows: what is not zero.
    moving: Vec<Vec<(usize, Complex<f64>)>>,
    /// z A_vq.
    forces: DMatrix<Complex<f64>>,
    /// 1 − z A_vv − z A_vq (1 − z A_qq)⁻¹ z A_qv.
    others: LU<Complex<f64>, Dyn, Dyn>,
}

impl Eliminated {
    fn new(jacobian: &DMatrix<f64>, z: Complex<f64>, positions: usize) -> Option<Self> {
        let m = jacobian.ncols() - positions;
        let entry = |i: usize, j: usize| z * jacobian[(i, j)];
        let one = |i: usize, j: usize| Complex::from(if i == j { 1.0 } else { 0.0 });
        let mut blocks: Vec<(Range<usize>, DMatrix<Complex<f64>>)> = Vec::new();
        let mut start = 0;
        while start < positions {
            let (mut end, mut i) = (start + 1, start);
            while i < end {
                let couples = |j: &usize| jacobian[(i, *j)] != 0.0 || jacobian[(*j, i)] != 0.0;
                end = (end..positions).rev().find(couples).map_or(end, |last| last + 1);
                i += 1;
            }
            let of = |i: usize, j: usize| one(i, j) - entry(start + i, start + j);
            blocks.push((start..end, DMatrix::from_fn(end - start, end - start, of).try_inverse()?));
            start = end;
        }
        let row = |i: usize| -> Vec<(usize, Complex<f64>)> {
            (0..m).map(|j| (j, entry(i, positions + j))).filter(|(_, x)| *x != Complex::from(0.0)).collect()
        };
        let moving: Vec<_> = (0..positions).map(row).collect();
        let forces = DMatrix::from_fn(m, positions, |i, j| entry(positions + i, j));
        let mut others = DMatrix::from_fn(m, m, |i, j| one(i, j) - entry(positions + i, positions + j));
        for (range, inverse) in &blocks {
            for (b, i) in range.clone().enumerate() {
                for (j, x) in &moving[i] {
                    for (a, q) in range.clone().enumerate() {
                        let by = -inverse[(a, b)] * x;
                        others.column_mut(*j).axpy(by, &forces.column(q), Complex::from(1.0));
                    }
                }
            }
        }
        Some(Self { blocks, moving, forces, others: others.lu() })
    }

    fn solve(&self, right: DVector<Complex<f64>>) -> Option<DVector<Complex<f64>>> {
        let positions = self.moving.len();
        let mut x = right;
        self.turn(&mut x);
        let rest = x.rows(positions, x.len() - positions) + &self.forces * x.rows(0, positions);
        let rest = if rest.is_empty() { rest } else { self.others.solve(&rest)? };
        let mut by = DVector::zeros(x.len());
        for (by, row) in by.iter_mut().zip(&self.moving) {
            *by = row.iter().fold(Complex::from(0.0), |sum, (j, entry)| sum + entry * rest[*j]);
        }
        self.turn(&mut by);
        x.iter_mut().zip(&by).take(positions).for_each(|(x, by)| *x += by);
        x.rows_mut(positions, rest.len()).copy_from(&rest);
        Some(x)
    }

    /// x_q as (1 − z A_qq)⁻¹ x_q.
    fn turn(&self, x: &mut DVector<Complex<f64>>) {
        for (range, inverse) in &self.blocks {
            let turned = inverse * x.rows(range.start, range.len());
            x.rows_mut(range.start, range.len()).copy_from(&turned);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Complex, DMatrix, DVector, Eliminated, Pace, Tangent, derivatives, is_stiff, sizes};
    use crate::number::Number;
    use crate::time::integrate::{Method, Newton, Rule, Slope};
    use pintle_kinematics::scalar::Wide;

    /// ẏ = −λ (y − x), ẋ = −x: y follows x at a distance of x/(λ − 1).
    fn flow<R: Number>(fast: f64) -> impl FnMut(R, &[R]) -> Result<Slope<R>, crate::motion::rows::Trouble> {
        let fast = R::from_f64(fast);
        move |_, y| Ok(Slope { rates: vec![-(fast * (y[0] - y[1])), -y[1]], switches: Vec::new() })
    }

    fn error_after<R: Number>(method: Method, digits: usize) -> f64 {
        let rule: Rule<R> = Rule::new(method, digits);
        const STEPS: i32 = 32;
        let (mut flow, fast, h) = (flow::<R>(1e6), R::from_f64(1e6), R::ratio(1, STEPS));
        let apart = |x: R| x / (fast - R::integer(1)) + x;
        let mut y = vec![apart(R::integer(1)), R::integer(1)];
        let allowed = vec![R::from_f64(10.0_f64.powi(-(digits as i32))); 3];
        for i in 0..STEPS {
            let t = R::ratio(i, STEPS);
            let slope = flow(t, &y).unwrap();
            let newton = Newton::All(sizes(&y, &allowed));
            let tried = rule.step(&mut flow, (t, &y, &slope), h, &allowed, (&newton, None)).unwrap();
            assert!(tried.error <= 1.0, "{method:?}: {}", tried.error);
            y = tried.end;
        }
        let wanted = (-1.0_f64).exp();
        let of_x = (y[1].to_f64() - wanted).abs();
        of_x.max((y[0] - apart(y[1])).magnitude().to_f64())
    }

    /// Two nodes that turn about three axes and one, with rates that depend on all: what is solved for fits 1 − z A.
    #[test]
    fn positions_are_eliminated_exactly() {
        let (positions, n) = (5, 12);
        let is_there =
            |i: usize, j: usize| i >= positions || j >= positions && (i < 3) == (j < 8) || i / 3 == j / 3;
        let number = |i: usize, j: usize| ((7 * i + 13 * j + i * j) % 17) as f64 / 17.0 - 0.4;
        let jacobian = DMatrix::from_fn(n, n, |i, j| if is_there(i, j) { number(i, j) } else { 0.0 });
        let z = Complex::new(0.7, -0.4);
        let found = Eliminated::new(&jacobian, z, positions).unwrap();
        assert_eq!(found.blocks.iter().map(|(range, _)| range.clone()).collect::<Vec<_>>(), [0..3, 3..5]);
        let right = DVector::from_fn(n, |i, _| Complex::new(1.0 + i as f64, 0.5 - i as f64));
        let x = found.solve(right.clone()).unwrap();
        for i in 0..n {
            let times = (0..n).fold(Complex::from(0.0), |sum, j| sum + z * jacobian[(i, j)] * x[j]);
            assert!((x[i] - times - right[i]).norm() < 1e-12, "{i}");
        }
    }

    #[test]
    fn what_has_decayed_takes_no_steps() {
        for method in [Method::Extrapolation, Method::Collocation] {
            for error in [error_after::<f64>(method, 14), error_after::<Wide>(method, 30)] {
                assert!(error < 1e-14, "{method:?}: {error:e}");
            }
        }
    }

    #[test]
    fn what_decays_is_stiff_once_it_has_decayed() {
        let allowed = [1e-14; 3];
        let stiff = |fast: f64, y: [f64; 2], h: f64| {
            let mut flow = flow::<f64>(fast);
            let slope = flow(0.0, &y).unwrap();
            let all = Tangent::whole(&sizes(&y, &allowed), 0);
            let known = derivatives(&mut flow, (0.0, &y, &slope), &all.directions).unwrap();
            let pace = Pace::of(&mut flow, (0.0, &y, &slope), &allowed, h).unwrap();
            is_stiff((&all, &known), pace, h)
        };
        assert!(stiff(1e4, [1.0 + 1.0 / 9999.0, 1.0], 1e-3));
        assert!(!stiff(1e4, [2.0, 1.0], 1e-3), "still decaying");
        assert!(!stiff(1e4, [1.0 + 1.0 / 9999.0, 1.0], 1e-5), "short steps");
        assert!(!stiff(2.0, [1.0, 1.0], 1.0), "as slow as what moves");
    }
}
