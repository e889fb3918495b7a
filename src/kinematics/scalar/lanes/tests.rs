//! Lanes against doubles, at points where formulas change: with fused products and without.

use crate::scalar::elementary::{atan2, atan2_opposite, elevation, norm};
use crate::scalar::lanes::{FirstOrder, LANES, LaneMask, Lanes, Real, SecondOrder};
use crate::scalar::{Duals, MAX_ORDER, Scalar, Seeded, Wide};
use crate::so3;
use crate::vector;
use crate::vector::Matrix;
use std::iter::zip;

macro_rules! fused_and_not {
    ($($test:ident),*) => {
        mod fused {
            $(#[test]
            fn $test() {
                super::$test::<true>();
            })*
        }
        mod unfused {
            $(#[test]
            fn $test() {
                super::$test::<false>();
            })*
        }
    };
}

fused_and_not!(
    arctangents,
    sines_and_cosines,
    norms_of_every_size,
    series_of_the_log,
    series_of_the_exponential,
    integers_and_turns,
    functions_of_each_lane,
    products_and_sums,
    derivatives_of_products,
    angles_of_cosines,
    rates_in_time,
    errors_of_angles_and_sines,
    sines_stay_in_their_lanes,
    derivatives_of_angles_and_norms,
    rotations_are_those_of_doubles,
    logs_continue_as_those_of_doubles,
    the_sign_of_a_zero_chooses_no_axis
);

type Second<const FUSED: bool, const N: usize> = SecondOrder<Lanes<FUSED>, N>;
type One<const N: usize> = <f64 as Duals>::Hessian<N>;

/// Two doubles are at most this many roundings of the larger one apart, or differ below the normal numbers. There the scaling of
/// one double by a fixed power of two makes 0 of what that of lanes keeps: 1e-160 over 1e150.
fn close(x: f64, y: f64, units: f64) -> bool {
    let subnormal = x != y && (x - y).abs() < f64::MIN_POSITIVE;
    x == y && x.is_sign_negative() == y.is_sign_negative()
        || (x - y).abs() <= units * f64::EPSILON / 2.0 * y.abs()
        || x.is_nan() && y.is_nan()
        || subnormal
}

fn lane_by_lane<const FUSED: bool>(
    points: &[[f64; 2]],
    lanes: impl Fn([Lanes<FUSED>; 2]) -> Lanes<FUSED>,
    one: impl Fn([f64; 2]) -> f64,
    units: f64,
) {
    // Every point meets every lane, with other neighbours each time.
    for shift in 0..points.len() {
        let at = |i: usize| points[(i * (shift + 1) + shift) % points.len()];
        let found = lanes([0, 1].map(|j| Lanes([0, 1, 2, 3].map(|i| at(i)[j]))));
        for i in 0..LANES {
            let expected = one(at(i));
            assert!(close(found.0[i], expected, units), "{:?}: {:e}, one: {expected:e}", at(i), found.0[i]);
        }
    }
}

fn grid() -> Vec<[f64; 2]> {
    let mut numbers = vec![0.0, 1.0, 0.4142, 0.4143, 2.414, 2.415, 1e-9, 1e-160, 1e150, 0.1, 0.7, 3.0];
    numbers.extend(numbers.clone().iter().map(|x| -x));
    numbers.iter().flat_map(|x| numbers.iter().map(|y| [*x, *y])).collect()
}

fn arctangents<const FUSED: bool>() {
    lane_by_lane(&grid(), |[y, x]: [Lanes<FUSED>; 2]| y.arctangent(x), |[y, x]| y.atan2(x), 3.0);
}

fn sines_and_cosines<const FUSED: bool>() {
    let mut points: Vec<[f64; 2]> = (-40..=40).map(|i| [f64::from(i) * 0.4, 0.0]).collect();
    points.extend([0.0, 1e-300, 1e-9, 1e4, 99_999.0, 1e5, 1e9].map(|x| [x, 0.0]));
    // Near a zero the error is that of the reduced angle.
    lane_by_lane(&points, |[x, _]: [Lanes<FUSED>; 2]| x.sine_cosine().0, |[x, _]| x.sin(), 4.0);
    lane_by_lane(&points, |[x, _]: [Lanes<FUSED>; 2]| x.sine_cosine().1, |[x, _]| x.cos(), 4.0);
}

fn norms_of_every_size<const FUSED: bool>() {
    let mut points = grid();
    points.extend([[1e300, -3e299], [1e-300, 2e-300], [1e300, 1e-300], [-1e-300, 0.0]]);
    lane_by_lane(
        &points,
        |[x, y]| Lanes::<FUSED>::direction_and_norm([x, y]).1,
        |[x, y]| f64::direction_and_norm([x, y]).1,
        3.0,
    );
    lane_by_lane(
        &points,
        |[x, y]| Lanes::<FUSED>::direction_and_norm([x, y]).0[0],
        |[x, y]| f64::direction_and_norm([x, y]).0[0],
        4.0,
    );
    lane_by_lane(
        &points,
        |[x, y]| Lanes::<FUSED>::inverted([x, y])[1],
        |[x, y]| f64::inverted([x, y])[1],
        5.0,
    );
}

fn series_of_the_log<const FUSED: bool>() {
    // What is asked for beyond the second order is what doubles give.
    for k in 0..=MAX_ORDER {
        let points = [[0.0, 0.0], [0.3, 0.0], [0.7, 0.0], [1.0, 0.0]];
        lane_by_lane(
            &points,
            |[c, _]| Lanes::<FUSED>::log_series(c, MAX_ORDER)[k],
            |[c, _]| f64::log_series(c, MAX_ORDER)[k],
            0.0,
        );
    }
    let beyond = |order: usize| Lanes::<FUSED>::log_series(Lanes::splat(0.5), order)[order + 1..].to_vec();
    assert!((0..MAX_ORDER).all(|order| beyond(order).iter().all(|c| *c == Lanes::splat(0.0))));
    let points: Vec<[f64; 2]> = (0..=200).map(|i| [f64::from(i) / 200.0, 0.0]).collect();
    for order in 0..3 {
        lane_by_lane(
            &points,
            |[c, _]| Lanes::<FUSED>::log_series(c, 2)[order],
            // The recurrence by which doubles come to the second coefficient beyond 60° loses a digit of it.
            |[c, _]| Wide::log_series(Wide::from_f64(c), 2)[order].to_f64(),
            // Unfused, each product of a polynomial is rounded by itself.
            if FUSED { 4.0 } else { 6.0 },
        );
    }
}

fn integers_and_turns<const FUSED: bool>() {
    let points: Vec<[f64; 2]> = [0.5, -0.5, 1.5, 2.5, 0.499_999_999_999_999_94, -2.5, 3.2, 1e9, -0.2]
        .into_iter()
        .flat_map(|x| [[x, 3.0], [x, 1e9], [x, 0.0]])
        .collect();
    lane_by_lane(&points, |[x, _]: [Lanes<FUSED>; 2]| x.nearest_integer(), |[x, _]| x.nearest_integer(), 0.0);
    lane_by_lane(&points, |[x, n]| Lanes::<FUSED>::with_turns(x, n), |[x, n]| f64::with_turns(x, n), 0.0);
    lane_by_lane(
        &points,
        |[x, _]: [Lanes<FUSED>; 2]| x.reciprocal_or_zero(),
        |[x, _]| x.reciprocal_or_zero(),
        0.0,
    );
    lane_by_lane(
        &[[0.0, 0.0], [f64::NAN, 0.0]],
        |[x, _]: [Lanes<FUSED>; 2]| x.reciprocal_or_zero(),
        |[x, _]| x.reciprocal_or_zero(),
        0.0,
    );
}

/// Each order asked for, and nothing beyond it.
fn series_of_the_exponential<const FUSED: bool>() {
    let points: Vec<[f64; 2]> = [0.0, 1e-20, 0.3, 5.0, 30.0, 400.0].map(|s| [s, 0.0]).to_vec();
    for order in 0..=MAX_ORDER {
        for k in 0..=MAX_ORDER {
            let of_one = |s: f64| f64::exp_series(s, order);
            let of_lanes = |s: Lanes<FUSED>| Lanes::exp_series(s, order);
            // Without derivatives lanes have sines of their own.
            let units = if order == 0 { 3.0 } else { 0.0 };
            lane_by_lane(&points, |[s, _]| of_lanes(s).0[k], |[s, _]| of_one(s).0[k], units);
            lane_by_lane(&points, |[s, _]| of_lanes(s).1[k], |[s, _]| of_one(s).1[k], units);
        }
    }
}

/// cos x and sin x / (2 x), x = √s / 2, without derivatives, of rotation vectors from 1e−9 to 2e5 rad: 1 u of 1 + x, for the rounding
/// of x turns by as much.
#[test]
fn errors_of_the_exponential() {
    fn worst<const FUSED: bool>() -> f64 {
        let mut worst = 0.0_f64;
        for i in 0..20_000 {
            let length = 1e-9 * (f64::from(i) * 0.001_64).exp();
            let s = length * length;
            let (w, k) = Lanes::<FUSED>::exp_series(Lanes::splat(s), 0);
            let x = Wide::from_f64(s).square_root() / Wide::integer(2);
            let (sine, cosine) = x.sine_cosine();
            // A rounding of x turns by u x.
            let size = 1.0 + x.to_f64();
            let of_cosine = (cosine - w[0].0[i as usize % LANES]).abs().to_f64() / size;
            let of_sine = (sine / x / Wide::integer(2) - k[0].0[i as usize % LANES]).abs().to_f64() * 2.0
                / (1.0 + 1.0 / x.to_f64().max(1.0));
            worst = worst.max(of_cosine.max(of_sine) * 2f64.powi(53));
        }
        worst
    }
    let found = [worst::<true>(), worst::<false>()];
    println!("{found:?}");
    assert!(found.iter().all(|of| (0.5..=1.0).contains(of)), "{found:?}");
}

/// What holds of all lanes and of any, for each of the sixteen answers.
#[test]
fn answers_of_four() {
    for bits in 0..16 {
        let lanes = [1, 2, 4, 8].map(|bit| bits & bit != 0);
        let mask = LaneMask(lanes);
        assert_eq!((mask.all(), mask.any()), (bits == 15, bits != 0));
        assert_eq!(Lanes::<true>::holds(mask), bits == 15);
        let number = Lanes::<true>(lanes.map(|holds| if holds { 2.0 } else { -2.0 }));
        assert_eq!(Lanes::shortcut_where_positive(|| number), bits == 15);
        assert_eq!(Scalar::select(mask, Lanes::splat(2.0), Lanes::<true>::splat(-2.0)), number);
        assert_eq!(Lanes::choose(mask, || Lanes::splat(2.0), || Lanes::<true>::splat(-2.0)), number);
        assert_eq!(Lanes::splat(0.0).less(number).0, lanes);
        assert!(!number.less(number).any());
    }
}

/// What each lane computes by itself.
fn functions_of_each_lane<const FUSED: bool>() {
    type Pair<const FUSED: bool> = (fn(Lanes<FUSED>, Lanes<FUSED>) -> Lanes<FUSED>, fn(f64, f64) -> f64);
    let functions: [Pair<FUSED>; 18] = [
        (|x, _| Scalar::from_real(x), |x, _| x),
        (|x, _| Scalar::real(x), |x, _| x),
        (|x, _| Scalar::nilpotent(x), |_, _| 0.0),
        (|x, y| Scalar::scale(x, y), |x, y| x * y),
        (|x, y| x - y, |x, y| x - y),
        (|x, y| x / y, |x, y| x / y),
        (|x, _| -x, |x, _| -x),
        (|_, _| Real::from_f64(-1.5), |_, _| -1.5),
        (|_, _| Real::integer(-7), |_, _| -7.0),
        (|_, _| Real::pi(), |_, _| std::f64::consts::PI),
        (|x, _| x.exponential_minus_one(), |x, _| x.exp_m1()),
        (|x, _| x.exponential(), |x, _| x.exp()),
        (|x, y| x.magnitude().power(y), |x, y| x.abs().powf(y)),
        (|x, _| x.magnitude().square_root(), |x, _| x.abs().sqrt()),
        (|x, y| x.with_sign_of(y), |x, y| x.copysign(y)),
        (|x, y| x.lesser(y), f64::min),
        (|x, y| x.greater(y), f64::max),
        (|x, y| x.mirrored_by(y), |x, y| if y < 0.0 { -x } else { x }),
    ];
    let points = [[0.25, -1.5], [-1.5, 0.3], [3.0, 2.0], [1e-3, 7.0], [-0.7, -0.9]];
    for (lanes, one) in functions {
        lane_by_lane(&points, |[x, y]| lanes(x, y), |[x, y]| one(x, y), 0.0);
    }
}

/// x y + z with one rounding or two: 1 − (1 + 2⁻³⁰)(1 − 2⁻³⁰) is 2⁻⁶⁰ or 0.
fn products_and_sums<const FUSED: bool>() {
    let small = 2f64.powi(-30);
    let points = [[1.0 + small, -1.0], [3.0, 5.0], [-2.0, 0.5], [0.0, 7.0]];
    let factor = 1.0 - small;
    let expected = |[x, z]: [f64; 2]| if FUSED { x.mul_add(factor, z) } else { x * factor + z };
    lane_by_lane(&points, |[x, z]: [Lanes<FUSED>; 2]| x.multiply_add(Lanes::splat(factor), z), expected, 0.0);
    lane_by_lane(&points, |[x, z]: [Lanes<FUSED>; 2]| x.scale_add(Lanes::splat(factor), z), expected, 0.0);
    lane_by_lane(&points, |[x, z]: [Lanes<FUSED>; 2]| x.with_real(z), |[_, z]| z, 0.0);
}

/// Sums, products and functions of numbers with every derivative, in integers, as num-dual's arithmetic has them.
fn derivatives_of_products<const FUSED: bool>() {
    /// A number whose derivatives differ in every direction, and in each lane.
    fn number<T: Seeded<2, Real = R>, R: Real>(real: impl Fn(i32) -> R, k: i32) -> T {
        let (mixed, unused) = (real(4 - k), real(77));
        T::assemble(
            real(2 + k),
            [real(3 * k - 1), real(5 - 2 * k)],
            [[real(7 * k), unused], [mixed, real(k - 6)]],
        )
    }
    fn operations<T: Scalar>(x: T, y: T, z: T) -> [T; 12] {
        let c = [3, -2, 5, 0, 0].map(T::Real::integer);
        [
            x + y,
            x - y,
            -x,
            x * y,
            x.scale(T::Real::integer(-3)),
            x.multiply_add(y, z),
            x.scale_add(T::Real::integer(4), z),
            x.lift(&c),
            x.nilpotent(),
            x.with_real(T::Real::integer(9)),
            x.nilpotent().nilpotent_product(y.nilpotent()),
            x * x.nilpotent().lift(&c) * z,
        ]
    }
    let lanes = |k: i32| Lanes::<FUSED>([0, 1, 2, 3].map(|lane| f64::from(k * (lane + 1) - lane)));
    let [first, second] = [
        operations::<FirstOrder<Lanes<FUSED>, 2>>(number(lanes, 1), number(lanes, 2), number(lanes, 3))
            .map(|found| (found.real(), found.gradient(), found.hessian())),
        operations::<Second<FUSED, 2>>(number(lanes, 1), number(lanes, 2), number(lanes, 3))
            .map(|found| (found.real(), found.gradient(), found.hessian())),
    ];
    for lane in 0..LANES {
        let one = |k: i32| lanes(k).0[lane];
        let expected = operations::<One<2>>(number(one, 1), number(one, 2), number(one, 3));
        for (n, expected) in expected.into_iter().enumerate() {
            for (order, found) in [(1, first[n]), (2, second[n])] {
                assert_eq!(found.0.0[lane], expected.real(), "{n}, order {order}");
                assert_eq!(found.1.map(|d| d.0[lane]), expected.gradient(), "{n}, order {order}");
                let hessian = if order == 2 { expected.hessian() } else { [[0.0; 2]; 2] };
                assert_eq!(found.2.map(|row| row.map(|d| d.0[lane])), hessian, "{n}, order {order}");
            }
        }
    }
}

/// The angles of (x, −y) and (|(x, z)|, y) on first derivatives, for which lanes have formulas of their own. They are those of doubles, at right
/// angles and beside the lock too, and zero at it.
fn angles_of_cosines<const FUSED: bool>() {
    let points = [
        [[1.0, 0.0, -1e-3, 0.6], [0.5, -2.0, 1.0, -0.8], [0.0, 0.3, -0.0, 0.1]],
        [[0.0, 1.0, -1.0, 1e-149], [0.0, 1e-12, 0.0, -1e-149], [1.0, 1e-12, 1e-100, 0.0]],
        [[0.0, -0.0, -0.0, 0.0], [1.0, -1.0, 1.0, -0.0], [0.0, -0.0, 1e-16, 1.0]],
    ];
    for [y, x, z] in points {
        let seed = |value: [f64; 4], i: usize| FirstOrder::<Lanes<FUSED>, 3>::seed(Lanes(value), i);
        let (y_of, x_of, z_of) = (seed(y, 0), seed(x, 1), seed(z, 2));
        let found = [atan2_opposite(y_of, x_of), elevation(y_of, [x_of, z_of])];
        for lane in 0..LANES {
            let seed = |value: [f64; 4], i: usize| One::<3>::seed(value[lane], i);
            let (y, x, z) = (seed(y, 0), seed(x, 1), seed(z, 2));
            let expected = [atan2_opposite(y, x), elevation(y, [x, z])];
            for (found, expected) in zip(&found, expected) {
                let (value, known) = (found.real().0[lane], expected.real());
                assert!(close(value, known, 4.0) && value.is_sign_positive() == known.is_sign_positive());
                for i in 0..3 {
                    let (slope, known) = (found.gradient()[i].0[lane], expected.gradient()[i]);
                    assert!(close(slope, known, 6.0), "lane {lane}, {i}: {slope:e} for {known:e}");
                }
            }
        }
    }
}

fn rates_in_time<const FUSED: bool>() {
    let [x, v, a] = [1.0, 2.0, 3.0].map(|first| Lanes::<FUSED>([first, 5.0, -first, 0.5]));
    let moving = Duals::moving(x, v, a);
    assert_eq!((moving.real(), <Lanes<FUSED> as Duals>::rates(moving)), (x, (v, a)));
}

/// Errors against the wide scalar: a constant that is wrong in its last digit counts. Measured: 2.4 u of arctangents, 1.8 u of sines and
/// cosines up to half a turn, 2.7 u beyond.
fn errors_of_angles_and_sines<const FUSED: bool>() {
    let units = |found: f64, exact: Wide| ((exact - found) / exact).abs().to_f64() * 2f64.powi(53);
    let mut worst = [0.0_f64; 5];
    for i in 0..20_000 {
        let angle = f64::from(i) * 0.000_313 - 3.13;
        let (y, x) = (1.7 * angle.sin(), 1.7 * angle.cos());
        let found = Lanes::<FUSED>::splat(y).arctangent(Lanes::splat(x)).0[i as usize % LANES];
        worst[0] = worst[0].max(units(found, Wide::from_f64(y).arctangent(Wide::from_f64(x))));
        let (sine, cosine) = Lanes::<FUSED>::splat(angle).sine_cosine();
        let exact = Wide::from_f64(angle).sine_cosine();
        worst[1] = worst[1].max(units(sine.0[0], exact.0));
        worst[2] = worst[2].max(units(cosine.0[0], exact.1));
        // From 3 to 1.2e5 rad, of either sign.
        let angle = angle.signum() * 3.0 * (f64::from(i) * 0.000_53).exp();
        let (sine, cosine) = Lanes::<FUSED>::splat(angle).sine_cosine();
        let exact = Wide::from_f64(angle).sine_cosine();
        worst[3] = worst[3].max(units(sine.0[0], exact.0));
        worst[4] = worst[4].max(units(cosine.0[0], exact.1));
    }
    println!("{worst:?}");
    assert!(
        worst[0] <= 2.5 && worst[1] <= 1.9 && worst[2] <= 1.9 && worst[3] <= 2.8 && worst[4] <= 2.8,
        "{worst:?}"
    );
}

/// Large angles and what is no number change no bit of another lane.
fn sines_stay_in_their_lanes<const FUSED: bool>() {
    let usual = [0.156, -2.5, 40.0, 0.7];
    let (sine, cosine) = Lanes::<FUSED>(usual).sine_cosine();
    for lane in 0..LANES {
        for large in [3e5, -1e17, f64::NAN, f64::INFINITY] {
            let mut x = usual;
            x[lane] = large;
            let (s, c) = Lanes::<FUSED>(x).sine_cosine();
            for other in (0..LANES).filter(|other| *other != lane) {
                assert_eq!((s.0[other], c.0[other]), (sine.0[other], cosine.0[other]));
            }
            assert!(close(s.0[lane], large.sin(), 0.0) && close(c.0[lane], large.cos(), 0.0), "{large}");
        }
    }
}

/// First and second derivatives, each lane at another kind of point.
fn derivatives_of_angles_and_norms<const FUSED: bool>() {
    let y = [1.0, 0.0, -1e-3, 3.0];
    let x = [0.0, -2.0, 1.0, -4.0];
    let seed = |i: usize| -> [One<2>; 2] { [One::<2>::seed(y[i], 0), One::<2>::seed(x[i], 1)] };
    let lanes = [Second::<FUSED, 2>::seed(Lanes(y), 0), Second::<FUSED, 2>::seed(Lanes(x), 1)];
    let check = |found: Second<FUSED, 2>, one: fn([One<2>; 2]) -> One<2>| {
        for i in 0..LANES {
            let expected = one(seed(i));
            for j in 0..2 {
                assert!(close(found.gradient()[j].0[i], expected.gradient()[j], 4.0), "lane {i}, {j}");
                for k in 0..2 {
                    let (x, y) = (found.hessian()[j][k].0[i], expected.hessian()[j][k]);
                    assert!((x - y).abs() <= 1e-15 * (1.0 + y.abs()), "lane {i}, {j} {k}: {x:e} {y:e}");
                }
            }
        }
    };
    check(atan2(lanes[0], lanes[1]), |[y, x]| atan2(y, x));
    check(norm(lanes), norm);
}

/// Logs, torsions and component flexions of rotations on lanes, with first and second derivatives, are those of doubles. They
/// are compared at no rotation and near it, at exact quarter and half turns about every axis, near half turns, anywhere.
fn rotations_are_those_of_doubles<const FUSED: bool>() {
    let axes: [[f64; 3]; 6] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.6, 0.0, -0.8],
        [-0.36, 0.48, 0.8],
        [0.48, 0.64, -0.6],
    ];
    let angles = [0.0, 1e-9, 0.3, 1.2, 1.6, 2.2, 3.0, 3.13];
    let mut rotations: Vec<Matrix<f64>> = Vec::new();
    for axis in axes {
        for angle in angles {
            rotations.push(so3::matrix(so3::exp_quaternion(axis.map(|e| e * angle))));
            rotations.push(so3::matrix(so3::exp_quaternion(axis.map(|e| -e * angle))));
        }
    }
    for (i, j) in [(1, 2), (2, 0), (0, 1)] {
        // A quarter turn and a half one, exact.
        let mut quarter = [[0.0; 3]; 3];
        (quarter[3 - i - j][3 - i - j], quarter[i][j], quarter[j][i]) = (1.0, -1.0, 1.0);
        rotations.push(quarter);
        rotations.push(vector::product(&quarter, &quarter));
    }
    /// φ, β, α_1 and α_2 of exp(σ^) R.
    fn measured<S: Scalar>(r: &Matrix<S>, spin: [S; 3]) -> [S; 6] {
        let [x, y, z] = spin;
        let zero = S::zero();
        let skew = [[zero, -z, y], [z, zero, -x], [-y, x, zero]];
        let (first, second) = (vector::product(&skew, r), vector::product(&skew, &vector::product(&skew, r)));
        let half = S::Real::ratio(1, 2);
        let turned = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[i][j] + first[i][j] + second[i][j].scale(half)));
        let log = so3::log_along(&turned, Some(spin));
        let [x, y] = so3::component_flexions(&turned, Some(spin), S::Real::ZERO);
        [log[0], log[1], log[2], so3::torsion_along(&turned, Some(spin)), x, y]
    }
    for shift in 0..rotations.len() {
        // Each lane another kind of rotation.
        let at = |lane: usize| &rotations[(shift + 17 * lane) % rotations.len()];
        let r = [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| Second::<FUSED, 3>::from_real(Lanes([0, 1, 2, 3].map(|lane| at(lane)[i][j]))))
        });
        let found = measured(&r, [0, 1, 2].map(|k| Second::<FUSED, 3>::seed(Lanes::<FUSED>::integer(0), k)));
        for lane in 0..LANES {
            let r = at(lane).map(|row| row.map(One::<3>::from_real));
            let expected = measured(&r, [0, 1, 2].map(|k| One::<3>::seed(0.0, k)));
            // Torsion and flexions end where the third directions are opposite, the log's derivatives grow towards half a turn.
            let to_opposite = 1.0 + at(lane)[2][2];
            let trace = at(lane)[0][0] + at(lane)[1][1] + at(lane)[2][2];
            for c in 0..6 {
                let distance: f64 =
                    if c < 3 { (trace + 1.0).max(0.0).sqrt() } else { to_opposite.max(0.0).sqrt() };
                if distance < 0.05 {
                    continue;
                }
                let size = 1.0 / distance;
                let near = |x: f64, y: f64, scale: f64| (x - y).abs() <= 2e-15 * (scale + y.abs());
                let (x, y) = (found[c].real().0[lane], expected[c].real());
                assert!(near(x, y, size), "{c} of {:?}: {x:e}, one: {y:e}", at(lane));
                for j in 0..3 {
                    let (x, y) = (found[c].gradient()[j].0[lane], expected[c].gradient()[j]);
                    assert!(near(x, y, size * size), "∂{c}/∂{j} of {:?}: {x:e}, one: {y:e}", at(lane));
                    for k in 0..3 {
                        let (x, y) = (found[c].hessian()[j][k].0[lane], expected[c].hessian()[j][k]);
                        let scale = size * size * size;
                        assert!(
                            near(x, y, 4.0 * scale),
                            "∂²{c}/∂{j}∂{k} of {:?}: {x:e}, one: {y:e}",
                            at(lane)
                        );
                    }
                }
            }
        }
    }
}

/// Logs that continue a reference on other sheets, up to two turns from it, with first and second derivatives: each lane on its own.
fn logs_continue_as_those_of_doubles<const FUSED: bool>() {
    let axes: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [-0.36, 0.48, 0.8]];
    let mut points: Vec<(Matrix<f64>, [f64; 3])> = Vec::new();
    for axis in axes {
        for angle in [0.05, 0.3, 1.2, 1.6, 2.2, 3.0, 3.13] {
            for turns in [-2.0, -1.0, 0.0, 1.0, 2.0] {
                let whole = angle + turns * std::f64::consts::TAU;
                // The reference lags behind, and points a little elsewhere.
                let reference = [0, 1, 2].map(|i| axis[i] * (whole - 0.2) + [0.01, -0.02, 0.015][i]);
                points.push((so3::matrix(so3::exp_quaternion(axis.map(|e| e * angle))), reference));
            }
        }
    }
    /// The log of exp(σ^) R that continues a reference.
    fn continued<S: Scalar>(
        spin: [S; 3],
        reference: [S::Real; 3],
        real: impl Fn(usize, usize) -> S,
    ) -> [S; 3] {
        let [x, y, z] = spin;
        let zero = S::zero();
        let skew = [[zero, -z, y], [z, zero, -x], [-y, x, zero]];
        let r = [0, 1, 2].map(|i| [0, 1, 2].map(|j| real(i, j)));
        let (first, second) =
            (vector::product(&skew, &r), vector::product(&skew, &vector::product(&skew, &r)));
        let half = S::Real::ratio(1, 2);
        let turned = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[i][j] + first[i][j] + second[i][j].scale(half)));
        so3::continuous_log_along(&turned, Some(spin), reference).phi
    }
    for shift in 0..points.len() {
        let at = |lane: usize| &points[(shift + 13 * lane) % points.len()];
        let four = |of: &dyn Fn(usize) -> f64| Lanes::<FUSED>([0, 1, 2, 3].map(of));
        let found = continued(
            [0, 1, 2].map(|k| Second::<FUSED, 3>::seed(Lanes::<FUSED>::integer(0), k)),
            [0, 1, 2].map(|i| four(&|lane| at(lane).1[i])),
            |i, j| Second::<FUSED, 3>::from_real(four(&|lane| at(lane).0[i][j])),
        );
        for lane in 0..LANES {
            let (r, reference) = at(lane);
            let spin = [0, 1, 2].map(|k| One::<3>::seed(0.0, k));
            let expected = continued(spin, *reference, |i, j| One::<3>::from_real(r[i][j]));
            // Beyond half a turn derivatives grow towards whole turns.
            let sine = ((3.0 - r[0][0] - r[1][1] - r[2][2]) / 4.0).sqrt();
            for c in 0..3 {
                let near = |x: f64, y: f64, scale: f64| (x - y).abs() <= 4e-15 * (scale + y.abs());
                let (x, y) = (found[c].real().0[lane], expected[c].real());
                assert!(near(x, y, norm(*reference)), "{c} of {:?}: {x:e}, one: {y:e}", at(lane));
                for j in 0..3 {
                    let (x, y) = (found[c].gradient()[j].0[lane], expected[c].gradient()[j]);
                    let scale = norm(*reference) / sine;
                    assert!(near(x, y, scale), "∂{c}/∂{j} of {:?}: {x:e}, one: {y:e}", at(lane));
                    for k in 0..3 {
                        let (x, y) = (found[c].hessian()[j][k].0[lane], expected[c].hessian()[j][k]);
                        assert!(
                            near(x, y, 4.0 * scale / sine),
                            "∂²{c}/∂{j}∂{k} of {:?}: {x:e}, one: {y:e}",
                            at(lane)
                        );
                    }
                }
            }
        }
    }
}

/// Half a turn about each axis, with zeros of either sign in its matrix: the same rotation vector.
fn the_sign_of_a_zero_chooses_no_axis<const FUSED: bool>() {
    for axis in 0..3 {
        for signs in 0..1 << 9 {
            let mut r = [[Lanes::<FUSED>::splat(0.0); 3]; 3];
            for i in 0..3 {
                for j in 0..3 {
                    let zero = if signs >> (3 * i + j) & 1 == 1 { -0.0 } else { 0.0 };
                    let turned = if i == axis { 1.0 } else { -1.0 };
                    r[i][j] = Lanes::splat(if i == j { turned } else { zero });
                }
            }
            let phi = so3::log(&r);
            for k in 0..3 {
                let expected = if k == axis { std::f64::consts::PI } else { 0.0 };
                assert!(
                    phi[k].0.iter().all(|x| close(*x, expected, 4.0) || *x == expected),
                    "{axis}: {phi:?}"
                );
            }
        }
    }
}
