//! How a text becomes a sentence of the page.

use crate::audit::summary;
use crate::layout;
use pintle_audit::Subject;

/// With a capital, where it begins with a word of the language: symbols stay what they are (μ, ur1, e1a, x_b).
pub(super) fn capital(text: &str) -> String {
    let word = text.split(|c: char| c.is_whitespace() || ",.;:".contains(c)).next().unwrap_or_default();
    let is_word = word.len() > 1 && word.chars().all(|c| c.is_ascii_lowercase() || "-'’".contains(c));
    let is_word = is_word || (word == "a" && is_article(text));
    if !is_word {
        return text.to_string();
    }
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Whether a text that begins with `a` begins with the article, and not with the node: what follows that is a verb or a conjunction.
pub(super) fn is_article(text: &str) -> bool {
    const AFTER_A_NODE: [&str; 7] = ["and", "or", "to", "at", "by", "from", "against"];
    let next = text.split_whitespace().nth(1).unwrap_or_default();
    let is_word = next.len() > 1 && next.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    is_word && !next.ends_with('s') && !AFTER_A_NODE.contains(&next)
}

/// With a capital and a full stop.
pub(super) fn sentence(text: &str) -> String {
    let stop = if text.ends_with(['.', '!', '?', ':']) { "" } else { "." };
    capital(text) + stop
}

/// A count with thin spaces between thousands.
pub(super) fn grouped(n: u64) -> String {
    layout::grouped(n, '\u{202f}')
}

/// The same of a number that may be negative.
pub(super) fn grouped_signed(n: i64) -> String {
    let sign = if n < 0 { "−" } else { "" };
    format!("{sign}{}", grouped(n.unsigned_abs()))
}

/// The name of a subject, after that of its scene where it has one.
pub(super) fn full_name(subject: &Subject) -> String {
    match summary::scene(subject) {
        Some(scene) => format!("{scene}: {}", subject.name),
        None => subject.name.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::{capital, grouped_signed, sentence};

    #[test]
    fn thousands_are_set_apart() {
        let said = [-1234, 0, 999, 100_000].map(grouped_signed);
        assert_eq!(said, ["−1\u{202f}234", "0", "999", "100\u{202f}000"]);
    }

    #[test]
    fn symbols_keep_their_case() {
        for (text, shown) in [
            ("μ = 0", "μ = 0."),
            ("e1 is taken along a", "e1 is taken along a."),
            ("ur1 follows from the others", "ur1 follows from the others."),
            ("δl follows", "δl follows."),
            ("∂ur1/∂θa1 is zero", "∂ur1/∂θa1 is zero."),
            ("exp(μ α) overflows", "exp(μ α) overflows."),
            ("nothing presses", "Nothing presses."),
            ("a term is left out", "A term is left out."),
            ("a coincides with b", "a coincides with b."),
            ("a and b coincide", "a and b coincide."),
            ("second-order, then", "Second-order, then."),
        ] {
            assert_eq!(sentence(text), shown);
        }
        assert_eq!(capital(""), "");
    }
}
