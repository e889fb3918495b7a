//! What differences of values on 237 bits have in common, of whatever they are taken: steps, noise, and the way along the rates.
//!
//! A step is a part of the size of a degree of freedom, and where a singular set is nearer than that, at a distance δ in sizes, of δ.

use pintle_kinematics::scalar::{Real, Wide};
use pintle_kinematics::vector::Vector;

/// The step of first differences, in sizes: what is left is about 1e-50 of truncation and 1e-45 of rounding.
pub const FIRST_STEP: f64 = 1e-25;
/// The step of second differences, in sizes, times √δ.
pub const SECOND_STEP: f64 = 1e-18;
/// The step of second differences that move two degrees of freedom ahead only, in sizes, times δ: what is left is 1e-21 of truncation and
/// 1e-29/δ² of rounding.
const STEP_AHEAD: f64 = 1e-21;
/// How near to a singular set, and how far from the origin, in sizes, second differences go ahead only: so that rounding leaves 1e-19 even of
/// what the set leaves alone, whose scale does not grow with 1/δ.
const NEAREST_AHEAD: f64 = 1e-2;
const FARTHEST_AHEAD: f64 = 1e4;
/// A hundred roundings of 237 bits.
pub const NOISE: f64 = 6e-70;

/// In which directions two degrees of freedom move from a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directions {
    /// Both ahead; one by itself ahead and back: half of the evaluations, for a truncation of first order in the step.
    Ahead,
    /// Both ahead, by as many of their sizes, and both back; one by itself ahead and back.
    Together,
    /// One ahead and the other back, no two by as many of their sizes; one by itself ahead, and twice as far. What has a second
    /// derivative has the same difference quotients; |x y|, x |x| and the like have others.
    Against,
}

/// The step of second differences of values, in sizes of the degrees of freedom, and where they move: that near to a singular set (0 on
/// one), and that far from the origin.
pub fn second(nearness: f64, far: f64) -> (f64, Directions) {
    if nearness >= NEAREST_AHEAD && far <= FARTHEST_AHEAD {
        (STEP_AHEAD * nearness, Directions::Ahead)
    } else {
        let near = if nearness > 0.0 { nearness } else { 1.0 };
        (SECOND_STEP * near.sqrt(), Directions::Together)
    }
}

/// How far such differences are off, in parts of the scale of second derivatives, which carries 1/δ.
pub(super) fn second_error(nearness: f64, far: f64) -> f64 {
    let noise = NOISE * far.max(1.0);
    8.0 * match second(nearness, far) {
        (step, Directions::Ahead) => noise / (step * step) + STEP_AHEAD,
        _ => noise / (SECOND_STEP * SECOND_STEP),
    }
}

/// The largest coordinate of some vectors, in lengths.
pub fn far<const N: usize>(vectors: [&Vector<Wide>; N], length: f64) -> f64 {
    vectors.into_iter().flatten().map(|x| x.abs().to_f64() / length).fold(0.0, f64::max)
}

/// The speed of the fastest degree of freedom, in its sizes: max(|q̇|, √|q̈|).
pub fn speed<const N: usize>(
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
pub fn times(nearness: f64, speed: f64) -> [f64; 2] {
    let near = if nearness > 0.0 { nearness } else { 1.0 };
    let of = |step: f64| if speed > 0.0 { step / speed } else { step };
    [of(FIRST_STEP * near), of(SECOND_STEP * near.sqrt())]
}

/// How far the degrees of freedom move in a time: q̇ t + q̈ t²/2.
pub fn carried_on<const N: usize>(velocity: &[Wide; N], acceleration: &[Wide; N], t: Wide) -> [Wide; N] {
    std::array::from_fn(|j| velocity[j] * t + acceleration[j] * t * t / Wide::integer(2))
}

/// f̈ from values after a time h and before it.
pub fn acceleration([before, still, after]: [Wide; 3], h: Wide) -> Wide {
    ((after - still) - (still - before)) / (h * h)
}
