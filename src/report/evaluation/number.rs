//! Numbers for reading: as many significant digits as asked for, aligned at the decimal point.

use crate::layout;

pub(crate) use pintle_scene::grammar::number;

/// Cells of one column, aligned at the decimal point, under a heading.
pub(crate) struct Aligned {
    /// The width of the column.
    pub(crate) cells: usize,
    whole: usize,
}

/// The characters before the decimal point, the exponent, or the end.
fn whole(text: &str) -> usize {
    text.find(['.', 'e']).unwrap_or_else(|| layout::width(text))
}

impl Aligned {
    /// The layout of a column.
    pub(crate) fn new<'t>(heading: &str, texts: impl Iterator<Item = &'t String>) -> Self {
        let (mut before, mut after) = (0, 0);
        for text in texts {
            let whole = whole(text);
            (before, after) = (before.max(whole), after.max(layout::width(text) - whole));
        }
        let missing = layout::width(heading).saturating_sub(before + after);
        Self { cells: before + after + missing, whole: before + missing }
    }

    /// The heading, above the first digits.
    pub(crate) fn heading(&self, heading: &str) -> String {
        let blanks = usize::from(self.whole > 1).min(self.cells.saturating_sub(layout::width(heading)));
        layout::left(&format!("{}{heading}", " ".repeat(blanks)), self.cells)
    }

    /// Appends a cell to a line.
    pub(crate) fn push_cell(&self, line: &mut String, text: &str) {
        let before = self.whole.saturating_sub(whole(text));
        layout::push_blanks(line, before);
        layout::push_left(line, text, self.cells.saturating_sub(before));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pintle_scene::grammar::trimmed;

    #[test]
    fn digits_are_significant_and_truthful() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-0.4, "-0.4"),
            (std::f64::consts::FRAC_PI_2, "1.570796327"),
            (-0.23431457505076203, "-0.2343145751"),
            (1.2246467991473532e-16, "1.224646799e-16"),
            (1e-4, "0.0001"),
            (1.23456789012e-5, "1.23456789e-5"),
            (9999999999.4, "9999999999"),
            (9999999999.6, "1e10"),
            (1e300, "1e300"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(number(value, 10), text, "{value:e}");
        }
        assert_eq!(number(0.1, 17), "0.10000000000000001");
        assert_eq!(number(2.0 / 3.0, 1), "0.7");
    }

    /// The same digits as those of the standard library, whichever way they are found.
    #[test]
    fn digits_are_rounded_once() {
        let mut bits = 1_u64;
        for _ in 0..20_000 {
            bits = bits.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
            let short = f64::from((bits >> 40) as i32) * 10_f64.powi((bits >> 32 & 31) as i32 - 20);
            for value in
                [f64::from_bits(bits), f64::from_bits(bits >> 12), f64::from_bits(bits >> 20 << 12), short]
            {
                for digits in [1, 5, 10, 15, 16, 17] {
                    let text = number(value, digits);
                    if !value.is_finite() || value == 0.0 {
                        continue;
                    }
                    let exact = format!("{value:.*e}", digits - 1);
                    let power: i32 = exact.split_once('e').unwrap().1.parse().unwrap();
                    assert_eq!(text.parse::<f64>(), exact.parse::<f64>(), "{value:e} to {digits}: {text}");
                    let is_plain = (-4..digits as i32).contains(&power);
                    assert_eq!(!text.contains('e'), is_plain, "{text}");
                    if is_plain {
                        let places = (digits as i32 - 1 - power) as usize;
                        assert_eq!(text, trimmed(&format!("{value:.places$}")), "{value:e} to {digits}");
                    }
                }
            }
        }
    }

    #[test]
    fn points_line_up() {
        let texts = ["0", "-0.25", "12.5", "1e-17"].map(String::from);
        let column = Aligned::new("CP", texts.iter());
        let mut line = String::new();
        texts.iter().for_each(|text| column.push_cell(&mut line, text));
        assert_eq!(line, " 0    -0.25 12.5   1e-17");
    }
}
