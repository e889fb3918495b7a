//! The product against the 237-bit scalar on a large grid, and the 237-bit scalar against mpmath.

use super::function::{ALL, Function};
use super::{U, Worst, assert_gates, golden, judge, order, truth, unmeasured};
use crate::tolerance::NUMERICS_ON_LANES;
use pintle_kinematics::scalar::lanes::{LANES, Lanes};
use pintle_kinematics::scalar::{Real, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector};
use std::f64::consts::{FRAC_PI_2, PI};

/// A reproducible stream of numbers (SplitMix64).
pub(super) struct Stream(pub(super) u64);

impl Stream {
    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(super) fn signed(&mut self, magnitude: f64) -> f64 {
        if self.unit() < 0.5 { -magnitude } else { magnitude }
    }

    pub(super) fn vector(&mut self) -> Vector<f64> {
        std::array::from_fn(|_| self.between(-1.0, 1.0))
    }
}

/// 24 directions: the axes both ways, diagonals, nearly axial ones and random ones.
fn directions() -> Vec<Vector<Wide>> {
    let mut all = vec![
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, -1.0],
        [1.0, 1.0, 0.0],
        [0.0, -1.0, 1.0],
        [-1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 1e-9, 0.0],
        [1e-5, 1.0, -1e-12],
        [3e-17, 2e-8, 1.0],
        [-1.0, 1e-3, 1e-160],
        [0.5, 0.5000001, 0.49999],
    ];
    let mut stream = Stream(24);
    while all.len() < 24 {
        all.push(stream.vector());
    }
    all.into_iter().map(|d| Wide::direction_and_norm(vector::exact(d)).0).collect()
}

/// 10^k for k from `low` to `high` in steps of 1/`per_decade`.
fn decades(low: i32, high: i32, per_decade: i32) -> impl Iterator<Item = f64> {
    (low * per_decade..=high * per_decade).map(move |k| 10f64.powf(f64::from(k) / f64::from(per_decade)))
}

fn wide(x: f64) -> Wide {
    Wide::from_f64(x)
}

/// n π − δ, n π, n π + δ for δ from 10^smallest to 0.1.
fn near(n: i32, smallest: i32) -> Vec<Wide> {
    let centre = Wide::pi() * Wide::integer(n);
    let mut angles = vec![centre];
    for delta in decades(smallest, -1, 1) {
        angles.push(centre - delta);
        angles.push(centre + delta);
    }
    angles
}

/// {0} ∪ [1e−16, π], more densely where formulas change, and π ± 1e−17 … 0.1.
fn angles_to_pi() -> Vec<Wide> {
    let mut angles = vec![wide(0.0), wide(1e-300)];
    angles.extend(decades(-16, -1, 2).map(wide));
    angles.extend((1..=44).map(|k| wide(0.07 * f64::from(k))));
    angles.extend([wide(FRAC_PI_2), Wide::pi() * Wide::ratio(2, 3)]);
    angles.extend(near(1, -17));
    angles
}

/// Every angle about every direction.
fn rotation_vectors(angles: &[Wide]) -> Vec<Vector<Wide>> {
    let directions = directions();
    angles.iter().flat_map(|angle| directions.iter().map(|d| vector::scale(*d, *angle))).collect()
}

fn rounded(numbers: impl IntoIterator<Item = Wide>) -> Vec<f64> {
    // What is left of an exact zero is zero.
    numbers.into_iter().map(|x| if x.abs() < 1e-60 { 0.0 } else { x.to_f64() }).collect()
}

/// Rounded rotations with references a third of a radian away, on whatever turn.
fn continued(as_matrix: bool) -> Vec<Vec<f64>> {
    let mut angles: Vec<Wide> = (1..=30).map(|k| wide(0.2 * f64::from(k))).collect();
    angles.extend(near(1, -9));
    angles.extend(&near(2, -15)[1..]);
    for (n, smallest) in [(4, -15), (20, -12), (200, -9), (20_000, -6)] {
        angles.extend(&near(n, smallest)[1..]);
    }
    angles.extend([8.0, 9.5, 100.0, 6283.0, 62_831.0].map(wide));
    let mut stream = Stream(7);
    let mut inputs = Vec::new();
    for angle in angles {
        for direction in directions() {
            let q = so3::exp_quaternion(vector::scale(direction, angle));
            let mut input = if as_matrix { rounded(so3::matrix(q).concat()) } else { rounded(q) };
            // Outside the zone where the sheet is kept, but on it.
            let reference = angle + stream.signed(1.0 / 3.0);
            input.extend(rounded(vector::scale(direction, reference)));
            inputs.push(input);
        }
    }
    inputs
}

/// Rounded rotations R_first(α) R_second(β) R_third(γ) at and near the values of β where the angles lock.
fn near_lock(axes: [usize; 3], locks: &[Wide]) -> Vec<Vec<f64>> {
    let mut stream = Stream(3);
    let ends = [0.0, FRAC_PI_2, -FRAC_PI_2, PI, 1e-9, 1e-200];
    let mut inputs = Vec::new();
    let mut offsets: Vec<f64> = decades(-16, -1, 2).collect();
    offsets.extend([0.3, 0.5, 0.8, 1.1, 1.4]);
    for lock in locks {
        for offset in &offsets {
            for k in 0..14 {
                let beta = *lock + stream.signed(*offset);
                let mut end = |at: usize| {
                    let index = (stream.unit() * 12.0) as usize;
                    if k % 3 == at && index < ends.len() { ends[index] } else { stream.between(-PI, PI) }
                };
                let (alpha, gamma) = (end(0), end(1));
                let parts =
                    [(axes[0], wide(alpha)), (axes[1], beta), (axes[2], wide(gamma))].map(|(axis, angle)| {
                        let mut phi = [wide(0.0); 3];
                        phi[axis] = angle;
                        so3::matrix(so3::exp_quaternion(phi))
                    });
                let r: Matrix<Wide> = vector::product(&vector::product(&parts[0], &parts[1]), &parts[2]);
                inputs.push(rounded(r.concat()));
            }
        }
    }
    inputs
}

/// Vectors of n components over the range of scales and of ratios, exact axes and zeros of both signs among them.
fn vectors(n: usize) -> Vec<Vec<f64>> {
    let mut stream = Stream(n as u64);
    let mut inputs = Vec::new();
    for scale in
        [1e-300, 1e-160, 1e-150, 1e-141, 1e-100, 1e-8, 0.1, 1.0, 3.0, 1e6, 1e100, 1e139, 1e150, 1e300]
    {
        for i in 0..n {
            for (sign, zero) in [(1.0, 0.0), (-1.0, 0.0), (1.0, -0.0), (-1.0, -0.0)] {
                let mut axis = vec![zero; n];
                axis[i] = sign * scale;
                inputs.push(axis);
            }
        }
        for ratio in decades(-20, 0, 2) {
            for _ in 0..3 {
                let small = (stream.unit() * n as f64) as usize;
                let v = (0..n).map(|i| {
                    let component = stream.between(0.1, 1.0);
                    let signed = stream.signed(component) * scale;
                    if (i == small) == (n > 2 || i == 0) { signed * ratio } else { signed }
                });
                inputs.push(v.collect());
            }
        }
        for _ in 0..40 {
            inputs.push((0..n).map(|_| stream.between(-1.0, 1.0) * scale).collect());
        }
    }
    inputs
}

fn inputs(function: Function) -> Vec<Vec<f64>> {
    let mut stream = Stream(1);
    match function {
        Function::Sqrt | Function::InverseSqrt | Function::Recip => {
            decades(-300, 300, 1).map(|x| vec![x * stream.between(1.0, 4.0)]).collect()
        }
        Function::SinCos => {
            decades(-16, 6, 30).flat_map(|x| [vec![x], vec![-x * stream.between(1.0, 2.0)]]).collect()
        }
        Function::Atan2 | Function::Norm2 => vectors(2),
        Function::Norm3 | Function::Direction3 => vectors(3),
        Function::ExpQuaternion | Function::ExpMatrix => {
            let mut angles = angles_to_pi();
            angles.extend(near(2, -15));
            angles.extend((8..=40).map(|k| wide(0.5 * f64::from(k))));
            angles.extend(decades(1, 6, 6).map(wide));
            rotation_vectors(&angles).into_iter().map(|phi| phi.map(Wide::to_f64).to_vec()).collect()
        }
        Function::LogQuaternion => rotation_vectors(&angles_to_pi())
            .into_iter()
            .map(|phi| rounded(so3::exp_quaternion(phi)))
            .collect(),
        Function::LogMatrix => rotation_vectors(&angles_to_pi())
            .into_iter()
            .map(|phi| rounded(so3::matrix(so3::exp_quaternion(phi)).concat()))
            .collect(),
        Function::ContinuousLog => continued(false),
        Function::ContinuousLogMatrix => continued(true),
        Function::Cardan => {
            let lock = Wide::pi() * Wide::ratio(1, 2);
            near_lock([0, 1, 2], &[lock, -lock])
        }
        Function::Euler => {
            let mut inputs = near_lock([2, 0, 2], &[wide(0.0), Wide::pi()]);
            for (k, input) in inputs.iter_mut().enumerate() {
                input.push(if k % 2 == 0 { 1.0 } else { -1.0 });
            }
            inputs
        }
    }
}

/// The errors of one function over its grid, on four threads.
fn measured(function: Function, numbers: impl Fn(&[f64]) -> Vec<Vec<f64>> + Sync) -> Vec<Worst> {
    measured_at(function, inputs(function), numbers)
}

fn measured_at(
    function: Function,
    inputs: Vec<Vec<f64>>,
    numbers: impl Fn(&[f64]) -> Vec<Vec<f64>> + Sync,
) -> Vec<Worst> {
    let per_thread = inputs.len().div_ceil(4);
    let part = |inputs: &[Vec<f64>]| {
        let mut worst = unmeasured(function);
        for input in inputs {
            judge(&mut worst, function, input, &numbers(input), &truth::references(function, input));
        }
        worst
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> =
            inputs.chunks(per_thread).map(|inputs| scope.spawn(move || part(inputs))).collect();
        let mut worst = unmeasured(function);
        for thread in threads {
            for (worst, other) in worst.iter_mut().zip(thread.join().unwrap()) {
                worst.include(other);
            }
        }
        worst
    })
}

#[test]
fn product_agrees_with_wide() {
    let measured = ALL.iter().flat_map(|function| measured(*function, |input| function.numbers(input)));
    assert_gates("237-bit scalar", &measured.collect::<Vec<_>>(), &[]);
}

#[test]
fn lanes_agree_with_wide() {
    let on_lanes = |function: Function, input: &[f64]| -> Vec<Vec<f64>> {
        let lanes: Vec<Lanes<true>> = input.iter().map(|x| Lanes([*x; LANES])).collect();
        let outputs = function.numbers(&lanes).into_iter();
        outputs.map(|numbers| numbers.iter().map(|lanes| lanes.0[0]).collect()).collect()
    };
    // Lanes have no numbers below the normal ones.
    let is_normal = |input: &Vec<f64>| input.iter().any(|x| x.abs() > 1e-299);
    let measured = ALL.iter().flat_map(|function| {
        let inputs = inputs(*function).into_iter().filter(is_normal).collect();
        measured_at(*function, inputs, |input| on_lanes(*function, input))
    });
    assert_gates("lanes", &measured.collect::<Vec<_>>(), NUMERICS_ON_LANES);
}

/// mpmath judges the reference: agreement within a hundred-thousandth of the unit in which the product is measured.
#[test]
fn wide_agrees_with_mpmath() {
    for function in ALL {
        for case in golden::cases(function) {
            let computed = truth::references(function, &case.inputs);
            let of_order = |k: usize| order(k, function.directions());
            let mut largest = [0.0f64; 3];
            for output in &case.outputs {
                for (k, number) in output.iter().enumerate() {
                    largest[of_order(k)] = largest[of_order(k)].max(number.scale);
                }
            }
            for (a, b) in computed.iter().zip(&case.outputs) {
                for (k, (a, b)) in a.iter().zip(b).enumerate() {
                    let place = || format!("{function:?} at {:?}: {a:?} for {b:?}", case.inputs);
                    if b.scale.is_infinite() {
                        assert!(a.scale.is_infinite(), "{}", place());
                        continue;
                    }
                    let scale = a.scale.max(b.scale);
                    let exact_zero = b.value == 0.0 && b.scale == 0.0 && scale < 1e-8 * largest[of_order(k)];
                    let subnormal = scale < 1e-290;
                    if exact_zero || subnormal {
                        continue;
                    }
                    assert!((a.scale - b.scale).abs() <= 1e-5 * scale, "scales of {}", place());
                    let values = (a.value - b.value) / scale / U;
                    let rests = (a.rest * a.scale - b.rest * b.scale) / scale;
                    assert!((values + rests).abs() < 1e-5, "{}", place());
                }
            }
        }
    }
}
