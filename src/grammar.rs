//! Numbers and nouns in sentences.

use std::fmt::Display;

/// `1 state`, `2 states`; `1 degree of freedom`, `3 degrees of freedom`; `2 mismatches`, `2 entries`.
pub(crate) fn count<N: Copy + Display + PartialEq + From<bool>>(n: N, noun: &str) -> String {
    if is_one(n) { format!("{n} {noun}") } else { format!("{n} {}", plural(noun)) }
}

/// The form of a verb, or of another word, that goes with a number: `agree(1, ["leaves", "leave"])`.
pub(crate) fn agree<N: Copy + PartialEq + From<bool>>(n: N, [one, several]: [&str; 2]) -> &str {
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

#[cfg(test)]
mod tests {
    use super::{agree, count};

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
