//! Numbers with the digits that they were printed with.

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
        let half = if digits >= 16 {
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

    /// Whether a text has all the digits of a double.
    pub(crate) fn is_full(text: &str) -> bool {
        let mantissa =
            text.split(['e', 'E', 'd', 'D']).next().unwrap_or("").trim_start_matches(['+', '-', '0', '.']);
        mantissa.bytes().filter(u8::is_ascii_digit).count() >= 16
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
        for no in ["", "abc", "nan", "inf", "-", "1.2.3", "1e999"] {
            assert_eq!(Printed::parse(no), None, "{no}");
        }
    }
}
