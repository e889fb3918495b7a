//! Three-vectors and 3 × 3 matrices as plain arrays, for every [`Scalar`].
//!
//! A matrix is indexed `m[row][column]`; a triad holds its directions e1, e2, e3 as columns.

use crate::scalar::{Real, Scalar};

/// A vector of three components.
pub type Vector<S> = [S; 3];

/// A 3 × 3 matrix, `m[row][column]`.
pub type Matrix<S> = [[S; 3]; 3];

/// u · v.
#[inline(always)]
pub fn dot<S: Scalar>(u: Vector<S>, v: Vector<S>) -> S {
    u[2].multiply_add(v[2], u[1].multiply_add(v[1], u[0] * v[0]))
}

/// u × v.
#[inline(always)]
pub fn cross<S: Scalar>(u: Vector<S>, v: Vector<S>) -> Vector<S> {
    [
        u[1].multiply_add(v[2], -(u[2] * v[1])),
        u[2].multiply_add(v[0], -(u[0] * v[2])),
        u[0].multiply_add(v[1], -(u[1] * v[0])),
    ]
}

/// u + v.
#[inline(always)]
pub fn add<S: Scalar>(u: Vector<S>, v: Vector<S>) -> Vector<S> {
    [u[0] + v[0], u[1] + v[1], u[2] + v[2]]
}

/// u − v.
#[inline(always)]
pub fn sub<S: Scalar>(u: Vector<S>, v: Vector<S>) -> Vector<S> {
    [u[0] - v[0], u[1] - v[1], u[2] - v[2]]
}

/// f v for a real factor f.
#[inline(always)]
pub fn scale<S: Scalar>(v: Vector<S>, factor: S::Real) -> Vector<S> {
    [v[0].scale(factor), v[1].scale(factor), v[2].scale(factor)]
}

/// f v.
#[inline(always)]
pub fn times<S: Scalar>(v: Vector<S>, factor: S) -> Vector<S> {
    [v[0] * factor, v[1] * factor, v[2] * factor]
}

/// u · v for a constant u.
#[inline(always)]
pub fn dot_real<S: Scalar>(u: Vector<S::Real>, v: Vector<S>) -> S {
    v[2].scale_add(u[2], v[1].scale_add(u[1], v[0].scale(u[0])))
}

/// u × v for a constant v.
#[inline(always)]
pub fn cross_real<S: Scalar>(u: Vector<S>, v: Vector<S::Real>) -> Vector<S> {
    [
        u[1].scale(v[2]) - u[2].scale(v[1]),
        u[2].scale(v[0]) - u[0].scale(v[2]),
        u[0].scale(v[1]) - u[1].scale(v[0]),
    ]
}

/// The constant v.
#[inline(always)]
pub fn constant<S: Scalar>(v: Vector<S::Real>) -> Vector<S> {
    [S::from_real(v[0]), S::from_real(v[1]), S::from_real(v[2])]
}

/// The doubles v, exactly.
#[inline(always)]
pub fn exact<R: Real>(v: Vector<f64>) -> Vector<R> {
    [R::from_f64(v[0]), R::from_f64(v[1]), R::from_f64(v[2])]
}

/// The doubles m, exactly.
#[inline(always)]
pub fn exact_matrix<R: Real>(m: &Matrix<f64>) -> Matrix<R> {
    [exact(m[0]), exact(m[1]), exact(m[2])]
}

/// The real parts of v.
#[inline(always)]
pub fn real<S: Scalar>(v: Vector<S>) -> Vector<S::Real> {
    [v[0].real(), v[1].real(), v[2].real()]
}

/// The column j (0-based) of m.
#[inline(always)]
pub fn column<S: Scalar>(m: &Matrix<S>, j: usize) -> Vector<S> {
    [m[0][j], m[1][j], m[2][j]]
}

/// m v.
#[inline(always)]
pub fn apply<S: Scalar>(m: &Matrix<S>, v: Vector<S>) -> Vector<S> {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

/// mᵀ v.
#[inline(always)]
pub fn apply_transposed<S: Scalar>(m: &Matrix<S>, v: Vector<S>) -> Vector<S> {
    [dot(column(m, 0), v), dot(column(m, 1), v), dot(column(m, 2), v)]
}

/// mᵀ v for a constant m.
#[inline(always)]
pub fn apply_real_transposed<S: Scalar>(m: &Matrix<S::Real>, v: Vector<S>) -> Vector<S> {
    [dot_real(column(m, 0), v), dot_real(column(m, 1), v), dot_real(column(m, 2), v)]
}

/// a b.
#[inline(always)]
pub fn product<S: Scalar>(a: &Matrix<S>, b: &Matrix<S>) -> Matrix<S> {
    let (b1, b2, b3) = (column(b, 0), column(b, 1), column(b, 2));
    let row = |r: Vector<S>| [dot(r, b1), dot(r, b2), dot(r, b3)];
    [row(a[0]), row(a[1]), row(a[2])]
}

/// aᵀ.
#[inline(always)]
pub fn transpose<S: Scalar>(a: &Matrix<S>) -> Matrix<S> {
    [column(a, 0), column(a, 1), column(a, 2)]
}

/// aᵀ b: its entry (i, j) is column i of a times column j of b, as in Q_ij = e_i^a · e_j^b.
#[inline(always)]
pub fn transposed_product<S: Scalar>(a: &Matrix<S>, b: &Matrix<S>) -> Matrix<S> {
    product(&transpose(a), b)
}

/// The matrix v^ with v^ x = v × x, of the unit of v.
#[inline(always)]
pub fn skew<S: Scalar>(v: Vector<S>) -> Matrix<S> {
    let zero = S::zero();
    [[zero, -v[2], v[1]], [v[2], zero, -v[0]], [-v[1], v[0], zero]]
}

/// The identity.
#[inline(always)]
pub fn identity<S: Scalar>() -> Matrix<S> {
    let (o, i) = (S::zero(), S::one());
    [[i, o, o], [o, i, o], [o, o, i]]
}
