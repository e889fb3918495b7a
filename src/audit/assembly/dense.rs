//! Small parts as dense matrices: singular values, and on which equations a dependent one depends.

use super::eliminate::Sparse;
use nalgebra::{DMatrix, DVector};

/// The size (the smaller of rows and columns) up to which a part is looked at as a dense matrix.
pub(super) const LARGEST: usize = 200;

/// Contributions below this part of the largest are rounding.
pub(super) const CONTRIBUTES: f64 = 1e-8;

/// Whether a matrix is small enough: of this size, and not too long.
pub(super) fn is_small(matrix: &Sparse, largest: usize) -> bool {
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

/// The singular values, the largest first; none where an entry is not finite, or where they are not found in reasonable time.
pub(super) fn singular_values(matrix: &Sparse) -> Vec<f64> {
    let rows: Vec<usize> = (0..matrix.rows()).collect();
    let full = dense(matrix, &rows);
    if full.is_empty() || !full.iter().all(|x| x.is_finite()) {
        return Vec::new();
    }
    let Some(svd) = full.try_svd(false, false, f64::EPSILON, 10_000) else { return Vec::new() };
    let mut values: Vec<f64> = svd.singular_values.iter().copied().collect();
    values.sort_by(|x, y| y.total_cmp(x));
    values
}

/// The independent rows that a dependent one is made of.
pub(super) fn made_of(matrix: &Sparse, dependent: &[u32], row: u32) -> Vec<u32> {
    let independent: Vec<usize> =
        (0..matrix.rows()).filter(|other| dependent.binary_search(&(*other as u32)).is_err()).collect();
    if independent.is_empty() {
        return Vec::new();
    }
    let basis = dense(matrix, &independent).transpose();
    let wanted: DVector<f64> = dense(matrix, &[row as usize]).row(0).transpose();
    if basis.is_empty() {
        return Vec::new();
    }
    let svd = basis.try_svd(true, true, f64::EPSILON, 10_000);
    let Some(weights) = svd.and_then(|svd| svd.solve(&wanted, 1e-12).ok()) else { return Vec::new() };
    let largest = weights.amax();
    let contributes = |weight: f64| weight.abs() > CONTRIBUTES * largest;
    independent
        .iter()
        .zip(weights.iter())
        .filter(|(_, weight)| contributes(**weight))
        .map(|(row, _)| *row as u32)
        .collect()
}

/// The shortest solution of J δ = right, or of the nearest right-hand side that has one.
pub(super) fn least(matrix: &Sparse, right: &[f64]) -> Option<Vec<f64>> {
    /// Singular values below this part of the largest are zero: far below those at the distances that parts are moved.
    const ZERO: f64 = 1e-9;
    let rows: Vec<usize> = (0..matrix.rows()).collect();
    let full = dense(matrix, &rows);
    if full.is_empty() {
        // Without equations nothing has to move, and without columns nothing can.
        return Some(vec![0.0; full.ncols()]);
    }
    let svd = full.try_svd(true, true, f64::EPSILON, 10_000)?;
    let largest = svd.singular_values.iter().fold(0.0_f64, |most, x| most.max(*x));
    let solution = svd.solve(&DVector::from_column_slice(right), ZERO * largest).ok()?;
    Some(solution.iter().copied().collect())
}
