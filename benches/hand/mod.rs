//! The yardstick: rows of five connection types differentiated by hand, once and twice, on AVX2 and FMA.

#[path = "../../src/kinematics/scalar/coefficients.rs"]
#[expect(dead_code, reason = "the rows need some of them")]
mod coefficients;
mod hessian;
mod simd;
mod simd_values;
pub(crate) mod sweep;
pub(crate) mod types;
mod vector;
