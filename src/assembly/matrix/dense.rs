//! Small connected components as dense matrices: singular values, and on which equations a dependent one depends.

use crate::matrix::sparse::Sparse;
use nalgebra::{DMatrix, DVector};

/// The size (the smaller of rows and columns) up to which a connected component is looked at as a dense matrix.
pub const LARGEST: usize = 200;

/// Contributions below this part of the largest are rounding.
const CONTRIBUTES: f64 = 1e-8;

/// Whether a matrix is small enough: of this size, and not too long.
pub(crate) fn is_small(matrix: &Sparse, largest: usize) -> bool {
    matrix.rows().min(matrix.width()) <= largest && matrix.rows() * matrix.width() <= 8 * largest * largest
}

fn dense(matrix: &Sparse, rows: &[usize]) -> DMatrix<f64> {
    let mut full = DMatrix::zeros(rows.len(), matrix.width());
    for (i, row) in rows.iter().enumerate() {
        for place in matrix.range(*row) {
            full[(i, matrix.columns[place] as usize)] = matrix.values[place];
        }
    }
    full
}

/// The root of the sum of squares, of numbers that are no duals.
pub(crate) fn size<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    numbers.into_iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A = U Σ Vᵀ, in no order; columns of U whose singular value is zero may be zero.
struct Decomposed {
    u: DMatrix<f64>,
    values: DVector<f64>,
    v: DMatrix<f64>,
}

/// Rounding of decompositions, relative.
const ROUNDING: f64 = 1e-12;

fn is_same(x: f64, y: f64) -> bool {
    (x - y).abs() <= ROUNDING * y
}

/// The singular values and vectors; none where an entry is not finite.
///
/// That of nalgebra 0.35 is wrong of some matrices when vectors are asked for (its issue 1172), which the product shows; then by rotations.
fn decomposed(full: &DMatrix<f64>) -> Option<Decomposed> {
    if !full.iter().all(|x| x.is_finite()) {
        return None;
    }
    let by_library = || -> Option<Decomposed> {
        let svd = full.clone().try_svd(true, true, f64::EPSILON, 10_000)?;
        Some(Decomposed { u: svd.u?, values: svd.singular_values, v: svd.v_t?.transpose() })
    };
    let product = |svd: &Decomposed| &svd.u * DMatrix::from_diagonal(&svd.values) * svd.v.transpose();
    let is_right = |svd: &Decomposed| {
        is_same(size(&svd.values), size(full)) && size(&(product(svd) - full)) <= ROUNDING * size(full)
    };
    by_library().filter(is_right).or_else(|| by_rotations(full).filter(is_right))
}

/// By rotations of pairs of columns until all are orthogonal (Hestenes, 1958).
fn by_rotations(full: &DMatrix<f64>) -> Option<Decomposed> {
    const SWEEPS: usize = 60;
    if full.nrows() < full.ncols() {
        let Decomposed { u, values, v } = by_rotations(&full.transpose())?;
        return Some(Decomposed { u: v, values, v: u });
    }
    let qr = full.clone().qr();
    let (mut columns, count) = (qr.r(), full.ncols());
    let mut v = DMatrix::<f64>::identity(count, count);
    let rotate = |matrix: &mut DMatrix<f64>, i: usize, j: usize, [c, s]: [f64; 2]| {
        for row in 0..matrix.nrows() {
            let (x, y) = (matrix[(row, i)], matrix[(row, j)]);
            matrix[(row, i)] = c * x - s * y;
            matrix[(row, j)] = s * x + c * y;
        }
    };
    for _ in 0..SWEEPS {
        let mut is_done = true;
        for i in 0..count {
            for j in i + 1..count {
                let [a, b] = [i, j].map(|k| columns.column(k).norm_squared());
                let dot = columns.column(i).dot(&columns.column(j));
                if dot == 0.0 || dot.abs() <= 8.0 * f64::EPSILON * (a * b).sqrt() {
                    continue;
                }
                is_done = false;
                let zeta = (b - a) / (2.0 * dot);
                let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                rotate(&mut columns, i, j, [cosine, cosine * tangent]);
                rotate(&mut v, i, j, [cosine, cosine * tangent]);
            }
        }
        if is_done {
            break;
        }
    }
    let values = DVector::from_iterator(count, columns.column_iter().map(|column| size(column.iter())));
    for (mut column, value) in columns.column_iter_mut().zip(values.iter()) {
        if *value > 0.0 {
            column /= *value;
        }
    }
    Some(Decomposed { u: qr.q() * columns, values, v })
}

impl Decomposed {
    /// The shortest of the nearest solutions of A x = right; singular values up to `zero` are zero.
    fn solve(&self, right: &DMatrix<f64>, zero: f64) -> DMatrix<f64> {
        let mut parts = self.u.transpose() * right;
        for (mut row, value) in parts.row_iter_mut().zip(self.values.iter()) {
            row *= if *value > zero { 1.0 / *value } else { 0.0 };
        }
        &self.v * parts
    }
}

/// The shortest of the nearest solutions of A x = right; singular values up to this part of the largest are zero.
pub(crate) fn solution(full: &DMatrix<f64>, right: &DMatrix<f64>, zero: f64) -> Option<DMatrix<f64>> {
    let svd = decomposed(full)?;
    Some(svd.solve(right, zero * svd.values.amax()))
}

/// The singular values, the largest first; none where an entry is not finite, or where they are not found in reasonable time.
pub(crate) fn singular_values(matrix: &Sparse) -> Vec<f64> {
    let rows: Vec<usize> = (0..matrix.rows()).collect();
    let full = dense(matrix, &rows);
    if full.is_empty() || !full.iter().all(|x| x.is_finite()) {
        return Vec::new();
    }
    let mut values: Vec<f64> = match full.clone().try_svd(false, false, f64::EPSILON, 10_000) {
        Some(svd) if is_same(size(&svd.singular_values), size(&full)) => {
            svd.singular_values.iter().copied().collect()
        }
        _ => match decomposed(&full) {
            Some(Decomposed { values, .. }) => values.iter().copied().collect(),
            None => return Vec::new(),
        },
    };
    values.sort_by(|x, y| y.total_cmp(x));
    values
}

/// By how much the singular value in this place, from 0, can change, to first order, where entries are others within what their digits leave
/// open ([`Sparse::openness`]): Σ |uᵢ| Eᵢⱼ |vⱼ|.
pub(crate) fn openness(matrix: &Sparse, at: usize) -> Option<f64> {
    let rows: Vec<usize> = (0..matrix.rows()).collect();
    let open: Vec<f64> = rows.iter().map(|row| matrix.openness(*row)).collect();
    if open.iter().all(|open| *open == 0.0) {
        return Some(0.0);
    }
    let svd = decomposed(&dense(matrix, &rows))?;
    let mut order: Vec<usize> = (0..svd.values.len()).collect();
    order.sort_by(|x, y| svd.values[*y].total_cmp(&svd.values[*x]));
    let at = *order.get(at)?;
    let (u, v) = (svd.u.column(at), svd.v.column(at));
    let of_row = |row: &usize| {
        let entries = matrix.range(*row).filter(|place| matrix.values[*place] != 0.0);
        u[*row].abs() * open[*row] * entries.map(|place| v[matrix.columns[place] as usize].abs()).sum::<f64>()
    };
    Some(rows.iter().map(of_row).sum())
}

/// By dependent row, the combination of all rows that is zero and has one of this row, none of the other dependent ones.
pub(crate) fn combinations(matrix: &Sparse, dependent: &[u32]) -> Option<DMatrix<f64>> {
    let is_dependent = |row: &usize| dependent.binary_search(&(*row as u32)).is_ok();
    let independent: Vec<usize> = (0..matrix.rows()).filter(|row| !is_dependent(row)).collect();
    let wanted: Vec<usize> = dependent.iter().map(|row| *row as usize).collect();
    let mut all = DMatrix::zeros(matrix.rows(), dependent.len());
    let basis = dense(matrix, &independent).transpose();
    if !basis.is_empty() {
        let weights = solution(&basis, &dense(matrix, &wanted).transpose(), ROUNDING)?;
        for (row, of_row) in independent.iter().zip(weights.row_iter()) {
            all.set_row(*row, &(-of_row));
        }
    }
    for (at, row) in wanted.iter().enumerate() {
        all[(*row, at)] = 1.0;
    }
    Some(all)
}

/// Whether combinations of rows are zero to rounding.
pub(crate) fn vanish(matrix: &Sparse, combinations: &DMatrix<f64>) -> bool {
    /// Beyond what elimination counts as zero.
    const ROUNDING: f64 = 1e-9;
    let rows: Vec<usize> = (0..matrix.rows()).collect();
    let full = dense(matrix, &rows);
    full.is_empty()
        || (combinations.transpose() * &full).amax() <= ROUNDING * combinations.amax() * full.amax()
}

/// The independent rows that each of the dependent ones is made of.
pub(crate) fn made_of(matrix: &Sparse, dependent: &[u32]) -> Vec<Vec<u32>> {
    let Some(combinations) = combinations(matrix, dependent) else { return Vec::new() };
    let independent = |row: &usize| dependent.binary_search(&(*row as u32)).is_err();
    let others: Vec<usize> = (0..matrix.rows()).filter(independent).collect();
    let of_one = |at: usize| -> Vec<u32> {
        let weight = |row: &usize| combinations[(*row, at)].abs();
        let largest = others.iter().map(weight).fold(0.0, f64::max);
        others.iter().filter(|row| weight(row) > CONTRIBUTES * largest).map(|row| *row as u32).collect()
    };
    (0..dependent.len()).map(of_one).collect()
}

/// The shortest solution of J δ = right, or of the nearest right-hand side that has one.
pub(crate) fn least(matrix: &Sparse, right: &[f64]) -> Option<Vec<f64>> {
    /// Singular values below this part of the largest are zero: far below those at the distances that parts are moved.
    const ZERO: f64 = 1e-9;
    let rows: Vec<usize> = (0..matrix.rows()).collect();
    let full = dense(matrix, &rows);
    if full.is_empty() {
        // Without equations nothing has to move, and without columns nothing can.
        return Some(vec![0.0; full.ncols()]);
    }
    let right = DMatrix::from_column_slice(right.len(), 1, right);
    Some(solution(&full, &right, ZERO)?.iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrices of which the library's decomposition is wrong when vectors are asked for: all ones, and others.
    #[test]
    fn decompositions_are_right() {
        for (rows, columns) in [(3, 5), (6, 21), (21, 6), (4, 4), (1, 3)] {
            let full = DMatrix::from_element(rows, columns, 1.0);
            for svd in [decomposed(&full).unwrap(), by_rotations(&full).unwrap()] {
                assert!(is_same(svd.values.amax(), ((rows * columns) as f64).sqrt()), "{rows} {columns}");
                let product = &svd.u * DMatrix::from_diagonal(&svd.values) * svd.v.transpose();
                assert!(size(&(product - &full)) < 1e-13 * size(&full), "{rows} {columns}");
            }
            let solution = solution(&full, &DMatrix::from_element(rows, 1, 1.0), ROUNDING).unwrap();
            assert!(solution.iter().all(|x| is_same(*x, 1.0 / columns as f64)), "{solution}");
        }
    }
}
