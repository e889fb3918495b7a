//! Numbers and nouns in sentences.

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

#[cfg(test)]
mod tests {
    use super::{agree, count, ranges, with_article};

    #[test]
    fn numbers_that_follow_each_other_are_ranges() {
        assert_eq!(ranges("state", &[3]), "state 3");
        assert_eq!(ranges("state", &[0, 1, 2, 3, 5, 7, 8]), "states 0 to 3, 5, 7, 8");
        let odd: Vec<u64> = (0..12).map(|k| 2 * k + 1).collect();
        assert_eq!(ranges("state", &odd), "states 1, 3, 5, 7, 9, 11, 13, 15 and 4 more");
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
