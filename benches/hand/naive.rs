//! The rows of five types as anyone would write them first, with the functions that num-dual brings.
#![expect(clippy::disallowed_methods, reason = "num-dual as it comes is what is measured beside ours")]
#![expect(clippy::panic, reason = "a benchmark fails by panicking")]

use num_dual::{Dual2SVec, DualNum, DualSVec};
use pintle_kinematics::scalar::Seeded;
use std::ops::{Add, Mul, Neg, Sub};

/// Numbers of num-dual with a seed for each nodal degree of freedom.
pub(crate) trait Number:
    DualNum<Primitive = f64>
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// The order of its derivatives.
    const ORDER: usize;

    /// value + the variation `index`.
    fn seeded(value: f64, index: usize) -> Self;
}

macro_rules! number {
    ($type:ty, $order:literal, $seeded:expr) => {
        impl Number for $type {
            const ORDER: usize = $order;

            fn seeded(value: f64, index: usize) -> Self {
                $seeded(value, index)
            }
        }
    };
}
number!(f64, 0, |value, _| value);
number!(DualSVec<f64, 12>, 1, Seeded::seed);
number!(Dual2SVec<f64, 12>, 2, Seeded::seed);

fn dot<D: Number>(a: [D; 3], b: [D; 3]) -> D {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross<D: Number>(a: [D; 3], b: [D; 3]) -> [D; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The columns of a triad turned by exp(θ^) at θ = 0, to the order of the number.
fn turned<D: Number>(triad: &[f64], first: usize) -> [[D; 3]; 3] {
    let e = |i: usize, j: usize| triad[3 * i + j];
    if D::ORDER == 0 {
        return std::array::from_fn(|j| std::array::from_fn(|i| D::from(e(i, j))));
    }
    let theta: [D; 3] = std::array::from_fn(|i| D::seeded(0.0, first + i));
    std::array::from_fn(|j| {
        let [x, y, z] = [e(0, j), e(1, j), e(2, j)];
        let spun = [theta[1] * z - theta[2] * y, theta[2] * x - theta[0] * z, theta[0] * y - theta[1] * x];
        let mut column = [spun[0] + x, spun[1] + y, spun[2] + z];
        if D::ORDER > 1 {
            let again = cross(theta, spun);
            column = std::array::from_fn(|i| column[i] + again[i] * 0.5);
        }
        column
    })
}

/// Twice the vector of the skew part over twice the sine of the angle, times the angle: no branch near 0 and near π.
fn rotation_vector<D: Number>(a: [[D; 3]; 3], b: [[D; 3]; 3]) -> [D; 3] {
    let q = |i: usize, j: usize| dot(a[i], b[j]);
    let v = [q(2, 1) - q(1, 2), q(0, 2) - q(2, 0), q(1, 0) - q(0, 1)];
    let sine = DualNum::sqrt(&dot(v, v));
    let cosine = q(0, 0) + q(1, 1) + q(2, 2) - 1.0;
    let factor = DualNum::atan2(&sine, cosine) / sine;
    v.map(|x| x * factor)
}

/// The rows of a state, given as X_b − X_a, U_a, U_b, A and B by rows.
pub(crate) fn rows<D: Number>(name: &str, state: &[f64], put: &mut impl FnMut(usize, D)) {
    let (a, b) = (turned::<D>(&state[9..18], 3), turned::<D>(&state[18..27], 9));
    let coordinates = |put: &mut dyn FnMut(usize, D)| {
        let d: [D; 3] =
            std::array::from_fn(|i| D::seeded(state[6 + i], 6 + i) - D::seeded(state[3 + i], i) + state[i]);
        (0..3).for_each(|i| put(i, dot(a[i], d)));
    };
    match name {
        "SLIDE-PLANE" => coordinates(put),
        "REVOLUTE" => {
            put(0, DualNum::atan2(&-dot(a[1], b[2]), dot(a[2], b[2])));
            put(1, dot(a[0], b[2]));
            put(2, dot(a[0], b[1]));
        }
        "TRANSLATOR" => {
            coordinates(put);
            rotation_vector(a, b).into_iter().enumerate().for_each(|(i, x)| put(3 + i, x));
        }
        "ROTATION" => rotation_vector(a, b).into_iter().enumerate().for_each(|(i, x)| put(i, x)),
        "CARDAN" => {
            let (y, x, s) = (-dot(a[1], b[2]), dot(a[2], b[2]), dot(a[0], b[2]));
            put(0, DualNum::atan2(&y, x));
            put(1, DualNum::atan2(&s, DualNum::sqrt(&(x * x + y * y))));
            put(2, DualNum::atan2(&-dot(a[0], b[1]), dot(a[0], b[0])));
        }
        other => panic!("{other} is not written here"),
    }
}
