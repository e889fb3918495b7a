//! `pintle explain WORD`: what a word of a report means. The page of words is the one list.

use crate::layout::{self, BOLD, styled};
use std::io::{self, Write};

/// The page: tables whose first column is the word, or words, and whose second is the meaning.
const PAGE: &str = include_str!("../../docs/reference/verdicts.md");

/// A word and what it means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Meaning {
    /// The word, or several of one meaning, as the page has them.
    pub word: &'static str,
    /// The meaning.
    pub meaning: &'static str,
}

/// Every word of the page that has a meaning, in its order.
pub fn meanings() -> impl Iterator<Item = Meaning> {
    let mut has_meanings = false;
    PAGE.lines().filter_map(move |line| {
        let Some(cells) = line.strip_prefix('|') else {
            has_meanings = false;
            return None;
        };
        let mut cells = cells.split('|').map(str::trim);
        let (word, meaning) = (cells.next()?, cells.next()?);
        if meaning == "meaning" {
            has_meanings = true;
            return None;
        }
        (has_meanings && !word.starts_with("---")).then_some(Meaning { word, meaning })
    })
}

/// The meanings of a word, in any case: of rows that list it, or of which it is the beginning.
pub fn of(word: &str) -> Vec<Meaning> {
    let asked = word.to_lowercase();
    let lists = |row: &Meaning, is_it: &dyn Fn(&str) -> bool| {
        row.word.split(", ").any(|one| is_it(&one.replace('`', "").to_lowercase()))
    };
    let exact: Vec<Meaning> = meanings().filter(|row| lists(row, &|one| one == asked)).collect();
    if !exact.is_empty() || asked.chars().count() < 3 {
        return exact;
    }
    meanings().filter(|row| lists(row, &|one| one.starts_with(&asked))).collect()
}

/// Writes meanings for reading.
///
/// # Errors
/// Those of the stream.
pub fn human(out: &mut dyn Write, found: &[Meaning], width: usize) -> io::Result<()> {
    for Meaning { word, meaning } in found {
        writeln!(out, "{}", styled(BOLD, word))?;
        write!(out, "{}", layout::labelled("", 2, 2, meaning, width))?;
    }
    Ok(())
}

/// Writes meanings as JSON.
///
/// # Errors
/// Those of the stream.
pub fn json(out: &mut dyn Write, found: &[Meaning]) -> io::Result<()> {
    let document = serde_json::json!({ "schema": "pintle-words/1", "version": pintle_kinematics::VERSION, "words": found });
    serde_json::to_writer_pretty(&mut *out, &document)?;
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::{meanings, of};
    use pintle_audit::Verdict;

    /// Each verdict that a report prints, and the other words of which readers asked.
    #[test]
    fn every_word_of_a_verdict_is_explained() {
        assert!(meanings().count() > 40, "{}", meanings().count());
        let verdicts = Verdict::ALL.map(Verdict::name);
        let others =
            ["stop", "not exercised", "mutant", "survived", "oracle", "witness", "law", "lock", "refused"];
        let mut compared = 0;
        for word in verdicts.into_iter().chain(others) {
            assert!(!of(word).is_empty(), "{word}");
            compared += 1;
        }
        assert!(compared > 15);
        assert!(of("").is_empty() && of("nonsense").is_empty());
    }
}
