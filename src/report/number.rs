//! Numbers for reading: as many significant digits as asked for, aligned at the decimal point.

use super::layout;

/// A number with up to `digits` significant digits, plain between 1e-4 and 10^digits, else with an exponent.
///
/// Zero is `0`; what is not zero never is: 1e-17 stays visible.
pub(crate) fn number(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let rounded = format!("{value:.*e}", digits.max(1) - 1);
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let power: i32 = exponent.parse().unwrap_or(0);
    let places = i32::try_from(digits).unwrap_or(i32::MAX) - 1 - power;
    match usize::try_from(places) {
        Ok(places) if power >= -4 => trimmed(&format!("{value:.places$}")).to_string(),
        _ => format!("{}e{exponent}", trimmed(mantissa)),
    }
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

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
    pub(crate) fn new(heading: &str, texts: &[String]) -> Self {
        let before = texts.iter().map(|text| whole(text)).max().unwrap_or(0);
        let after = texts.iter().map(|text| layout::width(text) - whole(text)).max().unwrap_or(0);
        let missing = layout::width(heading).saturating_sub(before + after);
        Self { cells: before + after + missing, whole: before + missing }
    }

    /// The heading, above the first digits.
    pub(crate) fn heading(&self, heading: &str) -> String {
        let blanks = usize::from(self.whole > 1).min(self.cells.saturating_sub(layout::width(heading)));
        layout::left(&format!("{}{heading}", " ".repeat(blanks)), self.cells)
    }

    /// A cell.
    pub(crate) fn cell(&self, text: &str) -> String {
        let before = self.whole.saturating_sub(whole(text));
        layout::left(&format!("{}{text}", " ".repeat(before)), self.cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn points_line_up() {
        let texts = ["0", "-0.25", "12.5", "1e-17"].map(String::from);
        let column = Aligned::new("CP", &texts);
        let cells: Vec<String> = texts.iter().map(|text| column.cell(text)).collect();
        assert_eq!(cells, [" 0    ", "-0.25 ", "12.5  ", " 1e-17"]);
    }
}
