//! `pintle explain WORD`: what a word of a report, an output, a flag or a key of JSON means. The reference pages are the one list.

use crate::layout::{self, BOLD, styled};
use std::io::{self, Write};

/// The pages: tables whose first column is the word, or words, and whose second is the meaning, or what a field holds.
const PAGES: [&str; 3] = [
    include_str!("../../docs/reference/verdicts.md"),
    include_str!("../../docs/reference/outputs.md"),
    include_str!("../../docs/reference/json.md"),
];

/// A word and what it means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Meaning {
    /// The word, or several of one meaning, as the page has them.
    pub word: &'static str,
    /// The meaning.
    pub meaning: &'static str,
}

/// Every word of the pages that has a meaning, in their order.
pub fn meanings() -> impl Iterator<Item = Meaning> {
    let mut has_meanings = false;
    PAGES.iter().flat_map(|page| page.lines()).filter_map(move |line| {
        let Some(cells) = line.strip_prefix('|') else {
            has_meanings = false;
            return None;
        };
        let mut cells = cells.split('|').map(str::trim);
        let (word, meaning) = (cells.next()?, cells.next()?);
        if meaning == "meaning" || meaning == "holds" {
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
        row.word.split(", ").any(|one| {
            // A path of JSON is known by its last key.
            let plain = one.replace(['`', '…'], "").replace("[]", "").to_lowercase();
            is_it(&plain) || plain.rsplit_once('.').is_some_and(|(_, last)| is_it(last))
        })
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
    use std::collections::BTreeSet;

    /// Every key of the schema of an audit has a meaning.
    #[test]
    fn every_key_and_flag_is_explained() {
        let mut keys = BTreeSet::new();
        properties(&serde_json::from_str(crate::audit::SCHEMA_TEXT).unwrap(), &mut keys);
        let asked = keys.len();
        let lacking: Vec<&String> = keys.iter().filter(|key| of(key).is_empty()).collect();
        assert!(lacking.is_empty() && asked > 90, "{asked}: {lacking:?}");
    }

    /// The names of properties of a schema.
    fn properties(schema: &serde_json::Value, keys: &mut BTreeSet<String>) {
        if let Some(found) = schema.get("properties").and_then(|found| found.as_object()) {
            keys.extend(found.keys().cloned());
        }
        let below: Vec<&serde_json::Value> = match schema {
            serde_json::Value::Object(all) => all.values().collect(),
            serde_json::Value::Array(all) => all.iter().collect(),
            _ => Vec::new(),
        };
        below.into_iter().for_each(|schema| properties(schema, keys));
    }

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
