//! What differences of values on 237 bits have in common, of whatever they are taken: steps, noise, and the way along the rates.
//!
//! A step is a part of the size of a degree of freedom, and where a singular set is nearer than that, at a distance δ in sizes, of δ.

use crate::scalar::{Real, Wide};

/// The step of first differences, in sizes: what is left is about 1e-50 of truncation and 1e-45 of rounding.
pub(super) const FIRST_STEP: f64 = 1e-25;
/// The step of second differences, in sizes, times √δ.
pub(super) const SECOND_STEP: f64 = 1e-18;
/// A hundred roundings of 237 bits.
pub(super) const NOISE: f64 = 6e-70;

/// The speed of the fastest degree of freedom, in its sizes: max(|q̇|, √|q̈|).
pub(super) fn speed<const N: usize>(
    velocity: &[Wide; N],
    acceleration: &[Wide; N],
    size: impl Fn(usize) -> f64,
) -> f64 {
    (0..N).fold(0.0_f64, |most, j| {
        let [v, a] = [velocity[j], acceleration[j]].map(|rate| (rate.to_f64() / size(j)).abs());
        most.max(v).max(a.sqrt())
    })
}

/// The steps in time of first and second differences, at a speed and that near to a singular set; on one, as far from it.
pub(super) fn times(nearness: f64, speed: f64) -> [f64; 2] {
    let near = if nearness > 0.0 { nearness } else { 1.0 };
    let of = |step: f64| if speed > 0.0 { step / speed } else { step };
    [of(FIRST_STEP * near), of(SECOND_STEP * near.sqrt())]
}

/// How far the degrees of freedom move in a time: q̇ t + q̈ t²/2.
pub(super) fn carried_on<const N: usize>(
    velocity: &[Wide; N],
    acceleration: &[Wide; N],
    t: Wide,
) -> [Wide; N] {
    std::array::from_fn(|j| velocity[j] * t + acceleration[j] * t * t / Wide::integer(2))
}

/// f̈ from values after a time h and before it.
pub(super) fn acceleration([before, still, after]: [Wide; 3], h: Wide) -> Wide {
    ((after - still) - (still - before)) / (h * h)
}
