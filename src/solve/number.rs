//! The numbers that a solution is computed on.

use num_bigint::{BigInt, BigUint};
use pintle_kinematics::Differentiable;
use pintle_kinematics::scalar::{Real, Wide};
use pintle_model::behavior::friction::Ordered;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::cmp::Ordering;

/// A number of a solution: `f64`, or [`Wide`] with 237 bits.
pub trait Number: Differentiable + Ordered + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// Half of the distance from 1 to the next number.
    const ROUNDING: f64;

    /// The nearest double.
    fn to_f64(self) -> f64;

    /// Whether it is zero, of either sign.
    fn is_nothing(self) -> bool;

    /// So many significant digits, in scientific notation.
    fn digits(self, count: usize) -> String;
}

impl Number for f64 {
    const ROUNDING: f64 = f64::EPSILON / 2.0;

    fn to_f64(self) -> f64 {
        self
    }

    fn is_nothing(self) -> bool {
        self == 0.0
    }

    fn digits(self, count: usize) -> String {
        let places = count.saturating_sub(1);
        format!("{self:.places$e}")
    }
}

impl Number for Wide {
    // 2⁻²³⁷
    const ROUNDING: f64 = 4.5e-72;

    fn to_f64(self) -> f64 {
        Self::to_f64(self)
    }

    fn is_nothing(self) -> bool {
        self == Self::default()
    }

    fn digits(self, count: usize) -> String {
        scientific(self, count.max(1)).unwrap_or_else(|| Self::to_f64(self).to_string())
    }
}

/// The decimal nearest to x with so many digits, ties to even, by exact integers: f256's own formatting brings 12 MB of tables along.
/// `None` where x is not finite.
fn scientific(x: Wide, count: usize) -> Option<String> {
    /// 2¹⁰⁰, by which numbers are brought near to 1: that is exact.
    const STEP: i32 = 100;
    if !is_finite(x) {
        return None;
    }
    let zero = Wide::ZERO;
    let sign = if x.less(zero) { "-" } else { "" };
    let step = Wide::from_f64(2.0_f64.powi(STEP));
    let (mut rest, mut exponent) = (x.magnitude(), 0_i32);
    if !zero.less(rest) {
        return Some(format!("0.{:0>1$}e0", "", count - 1).replace(".e", "e"));
    }
    while rest.less(Wide::integer(1)) {
        (rest, exponent) = (rest * step, exponent - STEP);
    }
    while !rest.less(step) {
        (rest, exponent) = (rest / step, exponent + STEP);
    }
    // 237 bits are six doubles at most, each the leading bits of what is left: multiples of 2⁻²³⁶, written as 53 bits times 2⁻²⁸⁸ or more.
    const LEAST: i32 = 288;
    let mut whole = BigInt::from(0);
    while zero.less(rest.magnitude()) {
        let part = rest.to_f64();
        rest -= Wide::from_f64(part);
        let bits = part.to_bits();
        let power = i32::try_from(bits >> 52 & 0x7ff).ok()? - 1075;
        let significand = BigInt::from(bits & ((1 << 52) - 1) | 1 << 52);
        let shifted = significand << u32::try_from(power + LEAST).ok()?;
        whole += if part < 0.0 { -shifted } else { shifted };
    }
    let whole = whole.to_biguint()?;
    let exponent = exponent - LEAST;
    // x = whole · 2^exponent; its decimal exponent, but for one.
    let bits = i32::try_from(whole.bits()).ok()?;
    let mut decimal = (f64::from(bits - 1 + exponent) * std::f64::consts::LOG10_2).floor() as i32;
    let places = i32::try_from(count).ok()? - 1;
    let power = |base: u32, of: i32| BigUint::from(base).pow(of.max(0).unsigned_abs());
    loop {
        let tens = places - decimal;
        let above = &whole * power(10, tens) * power(2, exponent);
        let below = power(10, -tens) * power(2, -exponent);
        let (quotient, remainder) = (&above / &below, &above % &below);
        let twice = remainder * 2_u32;
        let is_odd = quotient.bit(0);
        let rounds_up = twice > below || twice == below && is_odd;
        let digits = (quotient + u32::from(rounds_up)).to_string();
        match digits.len().cmp(&count) {
            Ordering::Less => decimal -= 1,
            Ordering::Greater => decimal += 1,
            Ordering::Equal => {
                let (first, others) = digits.split_at(1);
                let point = if others.is_empty() { "" } else { "." };
                return Some(format!("{sign}{first}{point}{others}e{decimal}"));
            }
        }
    }
}

/// Whether x is neither infinite nor NaN.
pub(crate) fn is_finite<R: Number>(x: R) -> bool {
    (x * R::ZERO).magnitude().less(R::integer(1))
}

/// The larger of two numbers.
pub(crate) fn larger<R: Number>(x: R, y: R) -> R {
    if x.less(y) { y } else { x }
}

/// The largest magnitude.
pub(crate) fn largest<R: Number>(of: impl IntoIterator<Item = R>) -> R {
    of.into_iter().fold(R::ZERO, |most, x| larger(most, x.magnitude()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The digits are those of f256's own formatting, which is another way to them, at special values and over all magnitudes.
    #[test]
    fn digits_are_those_of_the_number() {
        let third = Wide::integer(1) / Wide::integer(3);
        let mut numbers =
            vec![Wide::ZERO, Wide::integer(1), Wide::integer(-25), Wide::ratio(5, 2), Wide::ratio(-35, 100)];
        let mut x = third;
        for n in 0..400 {
            numbers.push(if n % 2 == 0 { x } else { -x });
            x *= Wide::ratio(123_457, 10_000);
            if n == 200 {
                x = third * Wide::from_f64(1e-300);
            }
        }
        // What rounds up to another power of ten.
        numbers.push(Wide::integer(1) - Wide::from_f64(1e-60));
        let mut compared = 0;
        for x in numbers {
            for count in [1, 2, 15, 33, 60] {
                let places = count - 1;
                assert_eq!(x.digits(count), format!("{x:.places$e}"), "{count}");
                compared += 1;
            }
        }
        assert!(compared > 2_000);
    }
}
