//! `pintle explain WORD`: what a word of a report, an output, a flag or a key of JSON means. The reference pages are the one list; of keys of a
//! scene it is the schema of scenes.

use crate::layout::{self, BOLD, styled};
use serde_json::Value;
use std::borrow::Cow;
use std::io::{self, Write};

/// The pages: tables whose first column is the word, or words, and whose second is the meaning, or what a field holds.
const PAGES: [&str; 3] = [
    include_str!("../../docs/reference/verdicts.md"),
    include_str!("../../docs/reference/outputs.md"),
    include_str!("../../docs/reference/json.md"),
];

/// A word and what it means.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Meaning {
    /// The word, or several of one meaning, as the page has them.
    pub word: Cow<'static, str>,
    /// The meaning.
    pub meaning: Cow<'static, str>,
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
        (has_meanings && !word.starts_with("---"))
            .then_some(Meaning { word: word.into(), meaning: meaning.into() })
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
    let mut exact: Vec<Meaning> = meanings().filter(|row| lists(row, &|one| one == asked)).collect();
    exact.extend(of_scenes(&asked));
    if !exact.is_empty() || asked.chars().count() < 3 {
        return exact;
    }
    meanings().filter(|row| lists(row, &|one| one.starts_with(&asked))).collect()
}

/// What a key of a scene means, in each object that has it.
fn of_scenes(key: &str) -> Vec<Meaning> {
    let mut found = Vec::new();
    if let Ok(schema) = serde_json::from_str(pintle_scene::SCHEMA_TEXT) {
        properties("scene", &schema, &mut |object, name, property| {
            let meaning = property.get("description").and_then(Value::as_str);
            if let Some(meaning) = meaning.filter(|_| name.eq_ignore_ascii_case(key)) {
                let word = format!("`{name}` ({object})").into();
                let meaning = Meaning { word, meaning: meaning.replace('\n', " ").into() };
                if !found.contains(&meaning) {
                    found.push(meaning);
                }
            }
        });
    }
    found
}

/// Hands on the properties of a schema: of which object, their names, and what is said of them.
fn properties(object: &str, schema: &Value, take: &mut impl FnMut(&str, &str, &Value)) {
    let all = schema.get("properties").and_then(Value::as_object);
    all.into_iter().flatten().for_each(|(name, property)| take(object, name, property));
    match schema {
        Value::Object(all) => {
            for (key, below) in all {
                let definitions = below.as_object().filter(|_| key == "$defs");
                match definitions {
                    Some(all) => all.iter().for_each(|(name, below)| properties(name, below, take)),
                    None => properties(object, below, take),
                }
            }
        }
        Value::Array(all) => all.iter().for_each(|below| properties(object, below, take)),
        _ => {}
    }
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
    use super::{meanings, of, properties};
    use pintle_audit::Verdict;
    use std::collections::BTreeSet;

    /// Every key of the schemas has a meaning, and each meaning is told once.
    #[test]
    fn every_key_of_the_schemas_is_explained() {
        let mut asked = 0;
        for (text, least) in [(crate::audit::SCHEMA_TEXT, 90), (pintle_scene::SCHEMA_TEXT, 170)] {
            let mut keys = BTreeSet::new();
            properties("", &serde_json::from_str(text).unwrap(), &mut |_, name, _| {
                keys.extend([name.to_owned()])
            });
            assert!(keys.len() > least, "{}", keys.len());
            for key in keys {
                let found = of(&key);
                assert!(!found.is_empty(), "{key} is not explained");
                assert!(found.iter().all(|one| !one.meaning.is_empty()), "{key}: {found:?}");
                let once: BTreeSet<_> = found.iter().map(|one| (&one.word, &one.meaning)).collect();
                assert_eq!(once.len(), found.len(), "{key}: {found:?}");
                asked += 1;
            }
        }
        assert!(asked > 260, "{asked}");
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
