//! Numbers and nouns in sentences, and numbers for reading.

use pintle_kinematics::catalog::ConnectionType;
use std::fmt::Display;

/// `1 state`, `2 states`; `1 degree of freedom`, `3 degrees of freedom`; `2 mismatches`, `2 entries`.
pub fn count<N: Copy + Display + PartialEq + From<bool>>(n: N, noun: &str) -> String {
    if is_one(n) { format!("{n} {noun}") } else { format!("{n} {}", plural(noun)) }
}

/// The form of a verb, or of another word, that goes with a number: `agree(1, ["leaves", "leave"])`.
pub fn agree<N: Copy + PartialEq + From<bool>>(n: N, [one, several]: [&str; 2]) -> &str {
    if is_one(n) { one } else { several }
}

fn is_one<N: PartialEq + From<bool>>(n: N) -> bool {
    n == N::from(true)
}

/// The plural of a noun; of one with "of" or "in" after it, of the noun itself.
fn plural(noun: &str) -> String {
    for and in [" of ", " in "] {
        if let Some((first, rest)) = noun.split_once(and) {
            return format!("{}{and}{rest}", plural(first));
        }
    }
    match noun.strip_suffix('y') {
        Some(stem) if !stem.ends_with(['a', 'e', 'i', 'o', 'u']) => format!("{stem}ies"),
        _ if noun.ends_with("ch") || noun.ends_with(['s', 'x']) => format!("{noun}es"),
        _ => format!("{noun}s"),
    }
}

/// A name of a connection type after its article: `a HINGE`, `a UJOINT`, `an AXIAL`.
pub fn with_article(name: &str) -> String {
    let article = if name.starts_with(['A', 'E', 'I', 'O']) { "an" } else { "a" };
    format!("{article} {name}")
}

/// Numbers of things, ascending, those that follow each other as ranges, eight of them at most: `states 0 to 3, 5 and 7 more`.
pub fn ranges(noun: &str, numbers: &[u64]) -> String {
    const NAMED: usize = 8;
    let mut found: Vec<[u64; 2]> = Vec::new();
    for number in numbers {
        match found.last_mut() {
            Some([_, last]) if last.checked_add(1) == Some(*number) => *last = *number,
            _ => found.push([*number; 2]),
        }
    }
    let named: u64 = found.iter().take(NAMED).map(|[first, last]| last - first + 1).sum();
    let words: Vec<String> = found
        .iter()
        .take(NAMED)
        .map(|[first, last]| match last - first {
            0 => first.to_string(),
            1 => format!("{first}, {last}"),
            _ => format!("{first} to {last}"),
        })
        .collect();
    let more = match numbers.len() as u64 - named {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let plural = if numbers.len() == 1 { "" } else { "s" };
    format!("{noun}{plural} {}{more}", words.join(", "))
}

/// A number with up to `digits` significant digits, plain between 1e-4 and 10^digits, else with an exponent.
///
/// Zero is `0`; what is not zero never is: 1e-17 stays visible.
pub fn number(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let rounded = rounded(value, digits.max(1));
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let power: i32 = exponent.parse().unwrap_or(0);
    let is_plain = power >= -4 && i32::try_from(digits).is_ok_and(|digits| power < digits.max(1));
    if is_plain { plain(mantissa, power) } else { format!("{}e{exponent}", trimmed(mantissa)) }
}

/// The digits up to which the shortest decimal that reads back to a double, filled up with zeros, is the double rounded.
const DECIMAL_DIGITS: usize = f64::DIGITS as usize;

/// `value` with up to `digits` significant digits, as mantissa and exponent. The shortest decimal is found faster than a
/// number of digits, most of all where that would be zeros.
fn rounded(value: f64, digits: usize) -> String {
    if value.is_normal() && digits <= DECIMAL_DIGITS {
        let shortest = format!("{value:e}");
        let given = shortest.bytes().take_while(|&byte| byte != b'e').filter(u8::is_ascii_digit).count();
        if given <= digits {
            return shortest;
        }
    }
    format!("{value:.*e}", digits - 1)
}

/// The decimal of a mantissa and a power of ten, without an exponent.
fn plain(mantissa: &str, power: i32) -> String {
    let (sign, mantissa) = mantissa.strip_prefix('-').map_or(("", mantissa), |rest| ("-", rest));
    let mut digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let Ok(whole) = usize::try_from(power + 1) else {
        let zeros = power.unsigned_abs() as usize - 1;
        return format!("{sign}0.{}{}", "0".repeat(zeros), digits.trim_end_matches('0'));
    };
    while digits.len() < whole {
        digits.push('0');
    }
    let (whole, fraction) = digits.split_at(whole);
    let whole = if whole.is_empty() { "0" } else { whole };
    trimmed(&format!("{sign}{whole}.{fraction}")).to_string()
}

/// A decimal without zeros at its end.
pub fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// A text with every word in which there is a digit, and every connection type, left open: texts of one shape say the same of different things.
pub fn shape(text: &str) -> String {
    let is_type = |word: &str| {
        let name = word.trim_end_matches(|c: char| !c.is_ascii_alphanumeric());
        name.starts_with(|c: char| c.is_ascii_uppercase())
            && name.chars().all(|c| c.is_ascii_uppercase() || c == '-')
            && ConnectionType::named(name, None).is_ok()
    };
    let open = |word: &str| word.contains(|c: char| c.is_ascii_digit()) || is_type(word);
    text.split_whitespace().map(|word| if open(word) { "#" } else { word }).collect::<Vec<_>>().join(" ")
}

/// " (and so on for 199 other elements: 2, 3, 4 …)", the first three by name; nothing where there are no others.
pub fn and_others(what: &str, others: &[impl Display]) -> String {
    let names: Vec<String> = others.iter().take(3).map(ToString::to_string).collect();
    let (several, rest) =
        (if others.len() == 1 { "" } else { "s" }, if others.len() > 3 { " …" } else { "" });
    match others.len() {
        0 => String::new(),
        count => format!(" (and so on for {count} other {what}{several}: {}{rest})", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::{agree, count, number, ranges, shape, with_article};

    #[test]
    fn numbers_that_follow_each_other_are_ranges() {
        assert_eq!(ranges("state", &[3]), "state 3");
        assert_eq!(ranges("state", &[0, 1, 2, 3, 5, 7, 8]), "states 0 to 3, 5, 7, 8");
        let odd: Vec<u64> = (0..12).map(|k| 2 * k + 1).collect();
        assert_eq!(ranges("state", &odd), "states 1, 3, 5, 7, 9, 11, 13, 15 and 4 more");
    }

    #[test]
    fn numbers_are_short() {
        let shown = [0.8, -1.0, 0.0, 1e-9, 123_456.0, 1.5e7, -0.791_412_3].map(|x| number(x, 4));
        assert_eq!(shown, ["0.8", "-1", "0", "1e-9", "1.235e5", "1.5e7", "-0.7914"]);
    }

    #[test]
    fn shapes_leave_names_open() {
        assert_eq!(shape("element 7: u1 is 0.5 off"), shape("element 9: ur3 is -2e-3 off"));
        assert_ne!(shape("element 7: u1 is 0.5 off"), shape("element 7: u1 is 0.5 rad off"));
        assert_eq!(shape("element 7: HINGE requires it"), shape("element 9: SLIDE-PLANE requires it"));
        assert_ne!(shape("element 7: a weld requires it"), shape("element 9: a link requires it"));
        assert_ne!(shape("*BEAM SECTION is skipped"), shape("*NODE is skipped"));
    }

    #[test]
    fn articles() {
        assert_eq!(
            ["AXIAL", "EULER", "HINGE", "UJOINT"].map(with_article),
            ["an AXIAL", "an EULER", "a HINGE", "a UJOINT"]
        );
    }

    #[test]
    fn one_and_several() {
        assert_eq!(count(1_usize, "state"), "1 state");
        assert_eq!(count(0_u64, "state"), "0 states");
        assert_eq!(count(2_u64, "degree of freedom"), "2 degrees of freedom");
        assert_eq!(count(1_u64, "degree of freedom"), "1 degree of freedom");
        assert_eq!(count(3_u32, "mismatch"), "3 mismatches");
        assert_eq!(count(3_u32, "wrong entry"), "3 wrong entries");
        assert_eq!(count(3_u32, "way"), "3 ways");
        assert_eq!(
            (agree(1_u64, ["leaves", "leave"]), agree(2_u64, ["leaves", "leave"])),
            ("leaves", "leave")
        );
    }
}
