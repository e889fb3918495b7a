//! Numbers with the digits that they were printed with.

use std::collections::{BTreeMap, BTreeSet};

/// So many digits has a double.
const FULL: usize = 16;

/// A number, and half a unit of its last printed digit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Printed {
    /// The number.
    pub x: f64,
    /// By how much what it stands for may differ.
    pub half: f64,
}

impl Printed {
    /// A number as text: `0.1250`, `-1.25E-01`, `1.25D-1`, `1.25-101` (an exponent of three digits, as Fortran prints it).
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let lower = text.to_ascii_lowercase().replace('d', "e");
        let body = lower.trim_start_matches(['+', '-']);
        if !body.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return None;
        }
        // An exponent without its letter.
        let split = lower.get(1..).and_then(|rest| rest.find(['+', '-'])).map(|at| at + 1);
        let whole = match split {
            Some(at) if !lower.contains('e') => format!("{}e{}", &lower[..at], &lower[at..]),
            _ => lower,
        };
        let x: f64 = whole.parse().ok().filter(|x: &f64| x.is_finite())?;
        let (mantissa, exponent) = whole.split_once('e').unwrap_or((&whole, "0"));
        let exponent: i32 = exponent.parse().ok()?;
        let Some((_, decimals)) = mantissa.split_once('.') else {
            // A whole number says what it is; one with an exponent has no digits beyond those that it shows.
            let half = if whole.contains('e') { 0.5 * 10.0_f64.powi(exponent) } else { 0.0 };
            return Some(Self { x, half });
        };
        // With an exponent, digits count from the first that is not zero: zero is zero.
        if x == 0.0 && whole.contains('e') {
            return Some(Self { x, half: 0.0 });
        }
        let digits = mantissa.bytes().filter(u8::is_ascii_digit).count();
        // A double with all its digits is exact to its rounding.
        let half = if digits >= FULL {
            x.abs() * f64::EPSILON
        } else {
            0.5 * 10.0_f64.powi(exponent - i32::try_from(decimals.len()).ok()?)
        };
        Some(Self { x, half })
    }

    /// A double, exact to its rounding; of a whole number exact.
    pub(crate) fn double(x: f64) -> Self {
        Self { x, half: if x.fract() == 0.0 { 0.0 } else { x.abs() * f64::EPSILON } }
    }

    /// The same number where its file writes no zeros at the end: it has as many digits as the longest there. Where that has one decimal,
    /// nobody rounded: `0.5` is what was given.
    pub(crate) fn shortest(self, Shortest { decimals, significant }: Shortest) -> Self {
        if significant >= FULL || decimals <= 1 {
            return Self::double(self.x);
        }
        let unit = |exponent: i32| 0.5 * 10.0_f64.powi(exponent);
        let places = unit(-decimals);
        if self.x == 0.0 {
            return Self { half: places, ..self };
        }
        let first = self.x.abs().log10().floor() as i32;
        let digits = unit(first + 1 - i32::try_from(significant).unwrap_or(i32::MAX));
        Self { half: places.max(digits), ..self }
    }

    /// The same number where it went through single precision: its digits beyond the seventh say nothing.
    pub(crate) fn single(self) -> Self {
        Self { half: self.half.max(self.x.abs() * 0.5 * f64::from(f32::EPSILON)), ..self }
    }

    /// The numbers of a line, and words between them; a sign that stands against the number before it begins another one.
    pub(crate) fn words(line: &str) -> Vec<&str> {
        let mut found = Vec::new();
        for word in line.split_whitespace() {
            let (bytes, mut from) = (word.as_bytes(), 0);
            for at in 1..bytes.len() {
                let is_sign = matches!(bytes[at], b'+' | b'-') && matches!(bytes[at - 1], b'0'..=b'9' | b'.');
                // An exponent without its letter has no point.
                let digits = bytes[at + 1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
                if is_sign && bytes.get(at + 1 + digits) == Some(&b'.') {
                    found.push(&word[from..at]);
                    from = at;
                }
            }
            found.push(&word[from..]);
        }
        found
    }

    /// The same number in another unit.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { x: self.x * factor, half: self.half * factor.abs() }
    }
}

/// The digits of numbers that have no zeros at the end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shortest {
    /// The most decimals of a number of the file.
    decimals: i32,
    /// The most significant digits.
    significant: usize,
}

/// How a file writes numbers, as far as some of its lines show.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Writing {
    /// The headings under which a number has all the digits of a double: the others there need no more than they have.
    full: BTreeSet<String>,
    /// The headings under which a number has a point.
    pointed: BTreeSet<String>,
    /// Where numbers have no zeros at the end, their digits.
    shortest: Option<Shortest>,
}

impl Writing {
    /// That of a file's numbers, by headings; `is_short` where the format never writes zeros at the end.
    pub(crate) fn of<'a>(numbers: impl Iterator<Item = &'a (String, String)>, is_short: bool) -> Self {
        let mut found = Self::default();
        let (mut most, mut is_padded, mut varies) = (Shortest::default(), false, is_short);
        let mut decimals: BTreeMap<&str, usize> = BTreeMap::new();
        for (heading, text) in numbers {
            let lower = text.to_ascii_lowercase().replace('d', "e");
            let (mantissa, exponent) = lower.split_once('e').unwrap_or((&lower, "0"));
            let after = mantissa.split_once('.').map(|(_, after)| after);
            let digits = mantissa.trim_start_matches(['+', '-', '0', '.']);
            let significant = digits.bytes().filter(u8::is_ascii_digit).count();
            if significant >= FULL {
                found.full.insert(heading.clone());
            }
            let shown = after.map_or(0, str::len);
            if shown > 0 {
                found.pointed.insert(heading.clone());
            }
            is_padded |= shown > 1 && mantissa.ends_with('0');
            varies |= *decimals.entry(heading).or_insert(shown) != shown && exponent == "0";
            let places = i32::try_from(shown).unwrap_or(0) - exponent.parse::<i32>().unwrap_or(0);
            most.decimals = most.decimals.max(places);
            most.significant = most.significant.max(significant);
        }
        found.shortest = (varies && !is_padded && !found.pointed.is_empty()).then_some(most);
        found
    }

    /// A number under a heading, with the digits that it has there.
    pub(crate) fn known(&self, heading: &str, number: Printed) -> Printed {
        match self.shortest {
            _ if self.full.contains(heading) => Printed::double(number.x),
            Some(shortest) if self.pointed.contains(heading) => number.shortest(shortest),
            _ => number,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_the_digits_it_shows() {
        let is = |text: &str, x: f64, half: f64| {
            let found = Printed::parse(text).unwrap();
            assert_eq!(found.x, x, "{text}");
            assert!((found.half - half).abs() <= 1e-12 * half, "{text}: {}", found.half);
        };
        is("0.1250", 0.125, 5e-5);
        is("-1.25E-01", -0.125, 5e-4);
        is("1.25D-1", 0.125, 5e-4);
        is("1.2500-101", 1.25e-101, 5e-106);
        is("3", 3.0, 0.0);
        is("1E3", 1000.0, 500.0);
        is("0.000", 0.0, 5e-4);
        is("0.000000E+00", 0.0, 0.0);
        is("0.1000000000000000055", 0.1, 0.1 * f64::EPSILON);
        let line = "  201 0.000000E+00-9.545213E+02-1.25-101 5000.-.5E-3 A-1.5";
        assert_eq!(
            Printed::words(line),
            ["201", "0.000000E+00", "-9.545213E+02", "-1.25-101", "5000.", "-.5E-3", "A-1.5"]
        );
        let writing = |texts: &[&str], is_short: bool| {
            let all: Vec<(String, String)> = texts.iter().map(|x| ("CU1".into(), (*x).into())).collect();
            Writing::of(all.iter(), is_short)
        };
        let half = |texts: &[&str], is_short: bool, text: &str| {
            writing(texts, is_short).known("CU1", Printed::parse(text).unwrap()).half
        };
        for (texts, is_short, text, wanted) in [
            // As %.4f, as %g, as rounded and then written, as JSON and as a double.
            (&["0.1250", "12.0000"][..], false, "0.1250", 5e-5),
            (&["0.5", "1.5"], false, "0.5", 0.05),
            (&["0.5", "1.54"], false, "0.5", 5e-3),
            (&["0.000123456", "2"], false, "2", 5e-6),
            (&["12.3456", "0.5", "0"], false, "0", 5e-5),
            (&["1.5", "2.5"], true, "2.5", 2.5 * f64::EPSILON),
            (&["0", "1.5"], false, "1.5", 1.5 * f64::EPSILON),
            (&["0.1000000000000000055", "0.5"], false, "0.5", 0.5 * f64::EPSILON),
        ] {
            let found = half(texts, is_short, text);
            assert!((found - wanted).abs() <= 1e-12 * wanted, "{texts:?} {text}: {found}");
        }
        for no in ["", "abc", "nan", "inf", "-", "1.2.3", "1e999"] {
            assert_eq!(Printed::parse(no), None, "{no}");
        }
    }
}
