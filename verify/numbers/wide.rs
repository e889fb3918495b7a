//! [`Wide`] against committed values from mpmath, and then `f64` and dual numbers against [`Wide`].
//!
//! Errors are in units of 2⁻²³⁷ relative to the value, or to the conditioned scale where the test says so. Half a unit to one
//! unit is a correctly rounded result. Each tolerance states the measured maximum.

#![expect(clippy::unwrap_used, reason = "a malformed golden file is a failed test")]

use num_dual::{Dual, Dual2, Dual2SVec, DualNum, DualSVec};
use num_traits::Num;
use pintle_kinematics::scalar::Duals;
use pintle_kinematics::scalar::{MAX_ORDER, Real, Scalar, Seeded, Series, Wide, elementary};
use serde_json::Value;
use std::sync::LazyLock;

static GOLDEN: LazyLock<Value> =
    LazyLock::new(|| serde_json::from_str(include_str!("../golden/wide.json")).unwrap());

/// The rows of one table; never empty.
fn rows(table: &str) -> &'static [Value] {
    let rows = GOLDEN[table].as_array().unwrap();
    assert!(rows.len() >= 20, "{table} has {} rows only", rows.len());
    rows
}

fn wide(text: &Value) -> Wide {
    text.as_str().unwrap().parse().unwrap()
}

fn wides(texts: &Value) -> Vec<Wide> {
    texts.as_array().unwrap().iter().map(wide).collect()
}

fn double(bits: &Value) -> f64 {
    f64::from_bits(u64::from_str_radix(bits.as_str().unwrap(), 16).unwrap())
}

/// |actual − expected| / scale in units of 2⁻²³⁷; infinite where that is no number.
fn units(actual: Wide, expected: Wide, scale: Wide) -> f64 {
    let difference = (actual - expected).abs();
    if difference == 0.0 {
        return 0.0;
    }
    let error = (difference / scale.abs() * Wide::from_f64(2f64.powi(237))).to_f64();
    if error.is_nan() { f64::INFINITY } else { error }
}

/// The greatest error seen, and where.
struct Worst {
    error: f64,
    place: String,
}

impl Worst {
    fn new() -> Self {
        Self { error: 0.0, place: String::new() }
    }

    fn see(&mut self, error: f64, place: impl FnOnce() -> String) {
        if error > self.error {
            (self.error, self.place) = (error, place());
        }
    }

    fn below(&self, tolerance: f64) {
        println!("worst {:.3} units at {}", self.error, self.place);
        assert!(self.error <= tolerance, "{:e} units at {}", self.error, self.place);
    }
}

/// Every decimal is read as the nearest number, and printed so that it reads back.
#[test]
fn decimals_are_exact() {
    for row in rows("parse") {
        let x = wide(&row[0]);
        let mut rest = x;
        for part in row[1].as_array().unwrap() {
            let part = double(part);
            assert_eq!(rest.to_f64().to_bits(), part.to_bits(), "{row}");
            rest -= part;
        }
        assert_eq!(rest, Wide::ZERO, "{row}");
        for text in [x.to_string(), format!("{x:e}"), format!("{x:?}")] {
            assert_eq!(text.parse::<Wide>().unwrap(), x, "{text}");
        }
    }
    assert!("1,5".parse::<Wide>().is_err());
    assert!(Wide::from_str_radix("10", 2).is_err());
    assert_eq!(format!("{:.100}", Wide::ratio(1, 4)).parse::<Wide>().unwrap(), Wide::ratio(1, 4));
}

#[test]
fn to_f64_rounds_half_to_even() {
    for row in rows("to_f64") {
        let mut x = wide(&row[0]);
        let mut exponent = row[1].as_i64().unwrap();
        while exponent != 0 {
            let step = exponent.clamp(-1000, 1000);
            x *= 2f64.powi(step as i32);
            exponent -= step;
        }
        assert_eq!(x.to_f64().to_bits(), double(&row[2]).to_bits(), "{row}: {:e}", x.to_f64());
    }
    for bits in
        [0, 1, 2, 0xf_ffff_ffff_ffff, 0x10_0000_0000_0000, 0x3ff0_0000_0000_0001, 0x7fef_ffff_ffff_ffff]
    {
        for x in [f64::from_bits(bits), -f64::from_bits(bits)] {
            assert_eq!(Wide::from_f64(x).to_f64().to_bits(), x.to_bits());
        }
    }
    assert_eq!(Wide::from_f64(f64::NEG_INFINITY).to_f64(), f64::NEG_INFINITY);
    assert!(Wide::from_f64(f64::NAN).to_f64().is_nan());
    let (high, low) = Wide::pi().split();
    assert_eq!((high, low), (std::f64::consts::PI, 1.224_646_799_147_353_2e-16));
}

/// Measured 0 units: the four operations are correctly rounded.
#[test]
fn arithmetic_is_correctly_rounded() {
    for row in rows("arithmetic") {
        let (a, b) = (wide(&row[0]), wide(&row[1]));
        assert_eq!(vec![a + b, a - b, a * b, a / b], wides(&row[2]), "{row}");
    }
}

/// Measured 0 units: correctly rounded.
/// The roots of what Newton's method does not see: zeros, what has no end, what is less than zero, and what is no number.
#[test]
fn roots_of_special_values() {
    let root = |x: f64| Wide::from_f64(x).square_root().to_f64();
    assert_eq!(root(0.0).to_bits(), 0.0_f64.to_bits());
    assert_eq!(root(-0.0).to_bits(), (-0.0_f64).to_bits());
    assert_eq!(root(f64::INFINITY), f64::INFINITY);
    for none in [-1.0, -1e-300, f64::NEG_INFINITY, f64::NAN] {
        assert!(root(none).is_nan(), "{none}");
    }
}

#[test]
fn square_roots_and_reciprocals() {
    let mut worst = Worst::new();
    for row in rows("square_root") {
        let expected = wide(&row[1]);
        worst.see(units(wide(&row[0]).square_root(), expected, expected), || row.to_string());
    }
    for row in rows("reciprocal") {
        let expected = wide(&row[1]);
        worst.see(units(wide(&row[0]).reciprocal_or_zero(), expected, expected), || row.to_string());
    }
    worst.below(0.0);
    assert_eq!(Wide::ZERO.reciprocal_or_zero(), Wide::ZERO);
}

/// Measured 1.7 units, one unit in the last place.
#[test]
fn exponentials() {
    let mut worst = Worst::new();
    for row in rows("exponential") {
        let expected = wide(&row[1]);
        worst.see(units(wide(&row[0]).exponential(), expected, expected), || row.to_string());
    }
    worst.below(2.0);
    let of = |x: f64| Wide::from_f64(x).exponential().to_f64();
    assert_eq!(
        [f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300].map(of),
        [f64::INFINITY, 0.0, f64::INFINITY, 0.0]
    );
    assert!(of(f64::NAN).is_nan());
}

/// Measured 1.9 units, one unit in the last place.
#[test]
fn sines_and_cosines() {
    let mut worst = Worst::new();
    for row in rows("sine_cosine") {
        let (sine, cosine) = wide(&row[0]).sine_cosine();
        for (actual, expected) in [(sine, wide(&row[1])), (cosine, wide(&row[2]))] {
            worst.see(units(actual, expected, expected), || row.to_string());
        }
    }
    worst.below(2.0);
    assert!(Wide::from_f64(-0.0).sine_cosine().0.to_f64().is_sign_negative());
}

/// Measured 1.9 units, one unit in the last place.
#[test]
fn arctangents() {
    let mut worst = Worst::new();
    for row in rows("arctangent") {
        let expected = wide(&row[2]);
        worst.see(units(wide(&row[0]).arctangent(wide(&row[1])), expected, expected), || row.to_string());
    }
    worst.below(2.0);
}

/// Zeros, infinities and their signs are as f64's own function has them.
#[test]
fn arctangents_of_special_values() {
    let special = [0.0, 1.0, 2.0, f64::MIN_POSITIVE, f64::MAX, f64::INFINITY, f64::NAN];
    for y in special.iter().flat_map(|y| [*y, -y]) {
        for x in special.iter().flat_map(|x| [*x, -x]) {
            let (wide, expected) = (Wide::from_f64(y).arctangent(Wide::from_f64(x)), y.atan2(x));
            if expected.is_nan() {
                assert!(wide.to_f64().is_nan(), "{y} {x}");
            } else {
                let wide =
                    if wide.to_f64().abs() < f64::MIN_POSITIVE { wide.to_f64() * 0.0 } else { wide.to_f64() };
                let expected = if expected.abs() < f64::MIN_POSITIVE { expected * 0.0 } else { expected };
                assert!(
                    (wide - expected).abs() <= f64::EPSILON * expected.abs(),
                    "{y} {x}: {wide} {expected}"
                );
                assert_eq!(wide.is_sign_negative(), expected.is_sign_negative(), "{y} {x}");
            }
        }
    }
}

/// Measured 0 units: correctly rounded.
#[test]
fn turns() {
    let mut worst = Worst::new();
    for row in rows("with_turns") {
        let (actual, expected) = (
            Wide::with_turns(
                wide(&row[0]),
                num_traits::FromPrimitive::from_i64(row[1].as_i64().unwrap()).unwrap(),
            ),
            wide(&row[2]),
        );
        worst.see(units(actual, expected, expected), || row.to_string());
    }
    worst.below(0.0);
}

/// Measured 2.0 units: the roundings of three squares, two sums, a root and a quotient.
#[test]
fn directions_and_norms() {
    let mut worst = Worst::new();
    for row in rows("direction_and_norm") {
        let v = wides(&row[0]);
        let (direction, norm) = Wide::direction_and_norm([v[0], v[1], v[2]]);
        for (actual, expected) in direction.iter().zip(wides(&row[1])) {
            worst.see(units(*actual, expected, expected), || row.to_string());
        }
        let expected = wide(&row[2]);
        worst.see(units(norm, expected, expected), || row.to_string());
    }
    worst.below(3.0);
    let zero = Wide::ZERO;
    assert_eq!(Wide::direction_and_norm([zero; 3]), ([zero; 3], zero));
}

/// Errors of Taylor coefficients at x relative to |f_n| + |x (n + 1) f_(n+1)|.
fn see_series(worst: &mut Worst, x: Wide, actual: &Series<Wide>, expected: &[Wide], place: &str) {
    for n in 0..=MAX_ORDER {
        let scale = expected[n].abs() + (x * expected[n + 1] * (n as f64 + 1.0)).abs();
        worst.see(units(actual[n], expected[n], scale), || format!("order {n}, {place}"));
    }
}

/// Measured 5.1 units in the values, relative even where they are 1e−72 at a zero: two terms of that size are subtracted.
/// Measured 7.1 units in the coefficients on their conditioned scale: the power series alternates.
#[test]
fn exp_series() {
    let mut worst = Worst::new();
    let mut value = Worst::new();
    for row in rows("exp_series") {
        let s = wide(&row[0]);
        let place = format!("s = {:e}", s.to_f64());
        for order in 0..=MAX_ORDER {
            let (w, k) = Wide::exp_series(s, order);
            let (mut full_w, mut full_k) = Wide::exp_series(s, MAX_ORDER);
            full_w[order + 1..].fill(Wide::ZERO);
            full_k[order + 1..].fill(Wide::ZERO);
            assert_eq!((w, k), (full_w, full_k), "order {order}, {place}");
        }
        let (w, k) = Wide::exp_series(s, MAX_ORDER);
        for (actual, expected, name) in [(w, wides(&row[1]), "w"), (k, wides(&row[2]), "k")] {
            see_series(&mut worst, s, &actual, &expected, &format!("{name}, {place}"));
            value.see(units(actual[0], expected[0], expected[0]), || format!("{name}, {place}"));
        }
    }
    value.below(8.0);
    worst.below(8.0);
}

/// Measured 7.3 units at order 4: the roundings of the recurrence add up, nothing cancels.
#[test]
fn log_series() {
    let mut worst = Worst::new();
    for row in rows("log_series") {
        let (c, expected) = (wide(&row[0]), wides(&row[1]));
        for order in 0..=MAX_ORDER {
            let k = Wide::log_series(c, order);
            for n in 0..=order {
                worst.see(units(k[n], expected[n], expected[n]), || format!("order {n}, c = {c:?}"));
            }
            assert!(k[order + 1..].iter().all(|k| *k == 0.0));
        }
    }
    worst.below(12.0);
}

/// f64's own coefficients against these, in units of 2⁻⁵³ of |f_n| + |x (n + 1) f_(n+1)|, n ≤ 3.
///
/// | orders asked for | 0 | 1 | 2 | 3 | 4 | from |
/// |---|---|---|---|---|---|---|
/// | exp | 1.9 | 1.9 | 2.0 | 4.7 | 4.7 | roundings of factors and terms |
/// | log | 2.1 | 2.1 | 4.4 | 11.2 | 11.2 | the recurrence subtracts where c is between 0 and 1/2 |
#[test]
fn f64_series_agree() {
    let mut worst = [[0.0f64; MAX_ORDER + 1]; 2];
    let mut see = |function: usize, order: usize, x: f64, actual: &Series<f64>, exact: &Series<Wide>| {
        for n in 0..=order.min(MAX_ORDER - 1) {
            let scale = exact[n].abs() + (exact[n + 1] * x * (n as f64 + 1.0)).abs();
            let error = ((exact[n] - actual[n]).abs() / scale).to_f64() * 2f64.powi(53);
            let worst = &mut worst[function][order];
            *worst = worst.max(if error.is_nan() { f64::INFINITY } else { error });
        }
    };
    for i in 0..600 {
        let s = 10f64.powf(-16.0 + 0.047 * f64::from(i));
        let (w, k) = Wide::exp_series(Wide::from_f64(s), MAX_ORDER);
        let c = 1.0 - 1.99 * f64::from(i) / 600.0;
        let log = Wide::log_series(Wide::from_f64(c), MAX_ORDER);
        for order in 0..=MAX_ORDER {
            let actual = f64::exp_series(s, order);
            see(0, order, s, &actual.0, &w);
            see(0, order, s, &actual.1, &k);
            see(1, order, c, &f64::log_series(c, order), &log);
        }
    }
    println!("{worst:.1?}");
    let bounds = [[2.5, 2.5, 2.5, 6.0, 6.0], [2.5, 2.5, 6.0, 14.0, 14.0]];
    for (worst, bound) in worst.as_flattened().iter().zip(bounds.as_flattened()) {
        assert!(worst <= bound, "{worst:.1} > {bound}");
    }
}

/// A function through every elementary one, with derivatives of no simple form.
fn composite<S: Scalar>(x: S) -> S {
    let (sine, cosine) = elementary::sin_cos(x);
    let (length, [along, across]) = elementary::norm_and_direction([sine + x, cosine * x]);
    let angle = elementary::atan2(along, across);
    elementary::sqrt(length)
        + angle * elementary::recip(x)
        + x.lift(&S::Real::exp_series(x.real(), S::ORDER).1)
}

/// The derivatives of orders 0 to 4 along one direction.
fn nested<R>(function: impl Fn(Dual2<Dual2<R>>) -> Dual2<Dual2<R>>, x: R) -> [R; 5]
where
    R: Real + DualNum<Primitive = f64>,
    Dual2<Dual2<R>>: Scalar<Real = R>,
{
    let (zero, one) = (R::ZERO, R::integer(1));
    let inner = |re, v1| Dual2::new(re, v1, zero);
    let y = function(Dual2::new(inner(x, one), inner(one, zero), inner(zero, zero)));
    [y.re.re, y.re.v1, y.re.v2, y.v1.v2, y.v2.v2]
}

/// Nested dual numbers over [`Wide`] against the derivatives of arctan, known in closed form, at t = 3/4.
#[test]
fn nested_duals_are_exact() {
    let t = Wide::ratio(3, 4);
    let actual = nested(|y| elementary::atan2(y, Dual2::from_real(Wide::integer(1))), t);
    let q = Wide::integer(1) + t * t;
    let expected = [
        t.arctangent(Wide::integer(1)),
        q.reciprocal_or_zero(),
        t * -2.0 / (q * q),
        (t * t * 3.0 - 1.0) * 2.0 / (q * q * q),
        (t - t * t * t) * 24.0 / (q * q * q * q),
    ];
    for (actual, expected) in actual.into_iter().zip(expected) {
        assert!(units(actual, expected, expected) < 16.0, "{actual} {expected}");
    }
    // At the exact right angle too: x = 0, y from 1 on; all derivatives in y vanish, those in x do not.
    let actual = nested(|x| elementary::atan2(Dual2::from_real(Wide::integer(1)), x), Wide::ZERO);
    assert_eq!(actual, [Wide::pi() / 2.0, Wide::integer(-1), Wide::ZERO, Wide::integer(2), Wide::ZERO]);
}

/// The same formulas on `f64` and on [`Wide`], every derivative compared.
#[test]
fn duals_agree_with_f64() {
    for x in [1e-3, 0.3, 1.0, 2.5, 7.0] {
        let (exact, actual) = (nested(composite, Wide::from_f64(x)), nested(composite, x));
        for (n, (actual, exact)) in actual.into_iter().zip(exact).enumerate() {
            let exact = exact.to_f64();
            assert!((actual - exact).abs() <= 1e-13 * exact.abs(), "order {n} at {x}: {actual} {exact}");
        }
    }
}

/// Central differences on [`Wide`] give 45 digits of the first and 33 of the second derivative.
#[test]
fn differences_confirm_duals() {
    for x in [0.3, 1.0, 2.5].map(Wide::from_f64) {
        let duals = nested(composite, x);
        let h = Wide::from_f64(1e-25);
        let first = (composite(x + h) - composite(x - h)) / (h * 2.0);
        assert!(((first - duals[1]) / duals[1]).abs() < 1e-45, "{first} {}", duals[1]);
        let h = Wide::from_f64(1e-18);
        let second = (composite(x + h) - composite(x) * 2.0 + composite(x - h)) / (h * h);
        assert!(((second - duals[2]) / duals[2]).abs() < 1e-33, "{second} {}", duals[2]);
    }
}

/// Gradient, Hessian and time rates over [`Wide`]: |v|, whose derivatives are u and (1 − u uᵀ)/|v|.
#[test]
fn gradients_and_hessians() {
    let v = [3.0, -4.0, 12.0].map(Wide::from_f64);
    let near = |actual: Wide, expected: Wide| units(actual, expected, Wide::integer(1)) < 4.0;
    let first = elementary::norm::<DualSVec<Wide, 3>, 3>([0, 1, 2].map(|i| Seeded::seed(v[i], i)));
    let second = elementary::norm::<Dual2SVec<Wide, 3>, 3>([0, 1, 2].map(|i| Seeded::seed(v[i], i)));
    let (gradient, hessian) = (second.gradient(), second.hessian());
    assert_eq!((Scalar::real(first), Scalar::real(second)), (Wide::integer(13), Wide::integer(13)));
    for i in 0..3 {
        let u = v[i] / 13.0;
        assert!(near(gradient[i], u) && near(first.gradient()[i], u));
        for j in 0..3 {
            let unit = f64::from(u8::from(i == j));
            assert!(near(hessian[i][j], (-(u * v[j] / 13.0) + unit) / 13.0), "{i} {j}");
        }
    }
    // A point on the unit circle with rate 2: the angle has rate 2 and no acceleration.
    let zero = Wide::ZERO;
    let x = Wide::moving(Wide::integer(1), zero, Wide::integer(-4));
    let y = Wide::moving(zero, Wide::integer(2), zero);
    assert_eq!(Wide::rates(elementary::atan2(y, x)), (Wide::integer(2), zero));
    // Of second derivatives given whole, those on and below the diagonal count, for others are not filled in.
    let [two, five, eleven, unused] = [2, 5, 11, 99].map(Wide::integer);
    let given = Dual2SVec::<Wide, 2>::assemble(zero, [zero; 2], [[two, unused], [five, eleven]]);
    assert_eq!(given.hessian(), [[two, five], [five, eleven]]);
    let single = elementary::recip(Dual::new(Wide::integer(3), Wide::integer(1)));
    assert!(near(single.eps, Wide::ratio(-1, 9)));
}

/// What num-dual asks for besides, against f64's own functions.
#[test]
#[expect(clippy::disallowed_methods, reason = "the methods under test are those that formulas must not use")]
fn functions_for_num_dual() {
    type Pair = (&'static str, fn(&Wide) -> Wide, fn(f64) -> f64);
    let functions: [Pair; 26] = [
        ("sqrt", DualNum::sqrt, f64::sqrt),
        ("cbrt", DualNum::cbrt, f64::cbrt),
        ("exp", DualNum::exp, f64::exp),
        ("exp2", DualNum::exp2, f64::exp2),
        ("exp_m1", DualNum::exp_m1, f64::exp_m1),
        ("ln", DualNum::ln, f64::ln),
        ("log2", DualNum::log2, f64::log2),
        ("log10", DualNum::log10, f64::log10),
        ("ln_1p", DualNum::ln_1p, f64::ln_1p),
        ("sin", DualNum::sin, f64::sin),
        ("cos", DualNum::cos, f64::cos),
        ("tan", DualNum::tan, f64::tan),
        ("asin", DualNum::asin, f64::asin),
        ("acos", DualNum::acos, f64::acos),
        ("atan", DualNum::atan, f64::atan),
        ("sinh", DualNum::sinh, f64::sinh),
        ("cosh", DualNum::cosh, f64::cosh),
        ("tanh", DualNum::tanh, f64::tanh),
        ("asinh", DualNum::asinh, f64::asinh),
        ("acosh", DualNum::acosh, f64::acosh),
        ("atanh", DualNum::atanh, f64::atanh),
        ("recip", DualNum::recip, f64::recip),
        ("powi", |x| x.powi(-3), |x| x.powi(-3)),
        ("powf", |x| x.powf(2.5), |x| x.powf(2.5)),
        ("log", |x| x.log(3.0), |x| x.log(3.0)),
        ("sph_j0", DualNum::sph_j0, |x| x.sin() / x),
    ];
    for (name, wide, plain) in functions {
        for x in [1e-60, 1e-30, 1e-3, 0.2, 0.9, 1.0, 1.5, 3.0, 30.0] {
            for x in [x, -x] {
                let (actual, expected) = (wide(&Wide::from_f64(x)).to_f64(), plain(x));
                let equal = actual == expected || actual.is_nan() && expected.is_nan();
                assert!(
                    equal || (actual - expected).abs() <= 1e-15 * expected.abs(),
                    "{name}({x}): {actual} {expected}"
                );
            }
        }
    }
    for x in [0.0, 1e-9, 0.5, -3.0, 20.0].map(Wide::from_f64) {
        let (sine, cosine) = x.sine_cosine();
        let square = x * x;
        // The defining relations, free of the division by x.
        assert!((x.sph_j0() * x - sine).abs() < 1e-70);
        assert!((x.sph_j1() * square - (sine - x * cosine)).abs() < 1e-68);
        assert!((x.sph_j2() * square * x - (sine * (-square + 3.0) - x * cosine * 3.0)).abs() < 1e-66);
    }
    assert!((Wide::from_f64(1e-30).sph_j2() * 15.0 / 1e-60 - 1.0).abs() < 1e-15);
}

/// What the traits of numbers promise: neutral elements, sums and products, signs, conversions, the parts of a dual number.
#[test]
#[expect(clippy::disallowed_methods, reason = "the methods under test are those that formulas must not use")]
fn numbers_obey_their_traits() {
    use num_dual::DualStruct;
    use num_traits::{FromPrimitive, One, Signed, Zero};
    let [quarter, seven, none] = [Wide::ratio(1, 4), Wide::integer(-7), <Wide as Zero>::zero()];
    assert!(none.is_zero() && !quarter.is_zero() && !seven.is_zero() && <Wide as One>::one() == 1.0);
    assert_eq!(quarter + none, quarter);
    assert_eq!([quarter, seven, quarter].into_iter().product::<Wide>() * 16.0, seven);
    assert_eq!([quarter, seven, quarter, quarter, quarter].into_iter().sum::<Wide>(), Wide::integer(-6));
    assert_eq!((Signed::abs(&quarter), Signed::abs(&seven)), (quarter, Wide::integer(7)));
    assert_eq!((quarter.signum(), seven.signum()), (Wide::integer(1), Wide::integer(-1)));
    assert_eq!((quarter.is_positive(), seven.is_positive()), (true, false));
    assert_eq!((quarter.is_negative(), seven.is_negative()), (false, true));
    // The positive difference: 0 where the other is greater.
    assert_eq!((quarter.abs_sub(&seven), seven.abs_sub(&quarter)), (quarter + 7.0, none));
    assert_eq!((quarter.max(seven), quarter.min(seven)), (quarter, seven));
    assert!(quarter != 0.3 && seven == -7.0 && seven < 0.5 && quarter > 0.125);
    let large = u64::MAX;
    let halves = Wide::from_f64((large >> 32) as f64) * 2f64.powi(32) + (large & 0xffff_ffff) as f64;
    assert_eq!(<Wide as FromPrimitive>::from_u64(large), Some(halves));
    assert_eq!(<Wide as FromPrimitive>::from_i64(-7), Some(seven));
    assert_eq!(<Wide as FromPrimitive>::from_f64(-7.0), Some(seven));
    assert_eq!(
        (quarter.re(), Wide::from_inner(&quarter), <Wide as DualNum>::from_re(quarter)),
        (0.25, quarter, quarter)
    );
    assert_eq!((Wide::from(-7.0), Wide::from(0.25)), (seven, quarter));
    assert_eq!(DualNum::scale(quarter, &seven) * 4.0, seven);
    assert_eq!(Scalar::scale(quarter, seven) * 4.0, seven);
    assert_eq!((Scalar::real(quarter), Scalar::nilpotent(quarter)), (quarter, none));
    assert_eq!(Scalar::with_real(quarter, seven), seven);
    let nearest = [2.5, -2.5, 0.25, -7.75].map(|x| Wide::from_f64(x).nearest_integer());
    assert_eq!(nearest, [3, -3, 0, -8].map(Wide::integer));
    assert_eq!(DualNum::sin_cos(&quarter), quarter.sine_cosine());
    assert_eq!(DualNum::atan2(&quarter, seven), quarter.arctangent(seven));
    // Far out, where eˣ overflows, the hyperbolic tangent is 1.
    assert_eq!(DualNum::tanh(&Wide::integer(-1_000_000)), Wide::integer(-1));
}

/// Decimals asked for are given, to the seventy-fifth.
#[test]
fn decimals_asked_for_are_given() {
    let third = Wide::ratio(1, 3);
    assert_eq!((format!("{third:.3}"), format!("{third:.2e}")), ("0.333".into(), "3.33e-1".into()));
    assert_eq!(format!("{third:.1000}").len(), 77);
    assert_eq!(format!("{third:.75}"), format!("{third:.76}"));
    assert_eq!(format!("{third:.75e}"), format!("{third:.1000e}"));
    assert_eq!(format!("{:8.2}", Wide::ratio(1, 4)), "    0.25");
}

/// No operation panics or hangs on a special value.
#[test]
fn special_values_are_harmless() {
    let special = [0.0, 1.0, f64::INFINITY, f64::NAN, f64::MAX, 5e-324];
    let special = special.iter().flat_map(|x| [*x, -x]).map(Wide::from_f64);
    let largest = (0..9).fold(Wide::from_f64(f64::MAX), |x, _| if (x * x).is_finite() { x * x } else { x });
    let special: Vec<_> = special.chain([largest, largest.reciprocal_or_zero()]).collect();
    for a in &special {
        for b in &special {
            for result in
                [*a + *b, *a - *b, *a * *b, *a / *b, *a % *b, a.max(*b), a.min(*b), a.arctangent(*b)]
            {
                assert!(!format!("{result} {result:e} {result:?}").is_empty());
                assert!(result.is_finite() || !result.split().0.is_finite());
            }
        }
        let values = [
            a.square_root(),
            a.reciprocal_or_zero(),
            a.sine_cosine().0,
            a.sine_cosine().1,
            Wide::with_turns(*a, Wide::integer(3)),
        ];
        let series = [Wide::exp_series(*a, 4).0, Wide::exp_series(*a, 4).1, Wide::log_series(*a, 4)];
        assert!(a.is_finite() || !values.iter().all(|value| value.is_finite()));
        assert!(a.partial_cmp(a).is_some() || !series.iter().flatten().any(|value| value.is_finite()));
    }
}
