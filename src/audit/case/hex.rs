//! Doubles in hexadecimal, bit for bit: `0x1.8p+1` is 3.
//!
//! The form is C's and Python's `float.hex`; decimal numbers are read as well, so that a file can be edited by hand.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// A double that is written in hexadecimal.
///
/// ```
/// use pintle_audit::Hex;
/// assert_eq!(Hex(3.0).to_string(), "0x1.8p+1");
/// assert_eq!("0x1.8p+1".parse::<Hex>().unwrap().0, 3.0);
/// assert_eq!("-0x0.0000000000001p-1022".parse::<Hex>().unwrap().0, -5e-324);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hex(pub f64);

const FRACTION_BITS: u32 = 52;
const BIAS: i64 = 1023;

impl fmt::Display for Hex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let x = self.0;
        let sign = if x.is_sign_negative() { "-" } else { "" };
        if x.is_nan() {
            return write!(f, "nan");
        }
        if x.is_infinite() {
            return write!(f, "{sign}inf");
        }
        if x == 0.0 {
            return write!(f, "{sign}0x0p+0");
        }
        let bits = x.to_bits();
        let fraction = bits & ((1 << FRACTION_BITS) - 1);
        let exponent = (bits >> FRACTION_BITS & 0x7ff) as i64;
        let (lead, power) = if exponent == 0 { (0, 1 - BIAS) } else { (1, exponent - BIAS) };
        let digits = format!("{fraction:013x}");
        let digits = digits.trim_end_matches('0');
        let point = if digits.is_empty() { "" } else { "." };
        write!(f, "{sign}0x{lead}{point}{digits}p{power:+}")
    }
}

/// A text that is no number.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no number: expected a form such as 0x1.8p+1, 3.0, inf or nan")]
pub struct HexError(String);

impl std::str::FromStr for Hex {
    type Err = HexError;

    fn from_str(text: &str) -> Result<Self, HexError> {
        let fail = || HexError(text.to_string());
        let (negative, rest) = match text.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let Some(rest) = rest.strip_prefix("0x") else { return text.parse().map(Hex).map_err(|_| fail()) };
        let (digits, power) = rest.split_once('p').ok_or_else(fail)?;
        let power: i64 = power.parse().map_err(|_| fail())?;
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        // At most 1 + 13 digits are written; more would not be exact.
        if whole.len() > 1 || fraction.len() > 13 || digits.contains(['+', '-']) {
            return Err(fail());
        }
        let lead = u64::from_str_radix(whole, 16).map_err(|_| fail())?;
        let tail =
            if fraction.is_empty() { 0 } else { u64::from_str_radix(fraction, 16).map_err(|_| fail())? };
        let tail = tail << (4 * (13 - fraction.len()));
        let magnitude = match (lead, power) {
            (0, _) if tail == 0 => 0.0,
            (0, p) if p == 1 - BIAS => f64::from_bits(tail),
            (1, p) if (1 - BIAS..=BIAS).contains(&p) => {
                f64::from_bits(((p + BIAS) as u64) << FRACTION_BITS | tail)
            }
            _ => return Err(fail()),
        };
        Ok(Self(if negative { -magnitude } else { magnitude }))
    }
}

/// Writes a double in hexadecimal.
///
/// # Errors
/// Those of the serializer.
pub fn serialize<S: Serializer>(x: &f64, to: S) -> Result<S::Ok, S::Error> {
    Hex(*x).serialize(to)
}

/// Reads a double in hexadecimal or decimal.
///
/// # Errors
/// What is no number.
pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Hex::deserialize(from).map(|hex| hex.0)
}

impl Serialize for Hex {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Hex {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Form {
            Number(f64),
            Text(String),
        }
        match Form::deserialize(deserializer)? {
            Form::Number(x) => Ok(Self(x)),
            Form::Text(text) => text.parse().map_err(serde::de::Error::custom),
        }
    }
}
