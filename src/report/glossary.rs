//! `pintle explain WORD`: what a word of a report, an output, a flag or a key of JSON means. The reference pages are the one list; of keys of a
//! scene it is the schema of scenes.

use crate::layout::{self, BOLD, styled};
use serde_json::Value;
use std::borrow::Cow;
use std::io::{self, Write};

/// The pages: tables whose first column is the word, or words, and whose second is the meaning, or what a field holds.
const PAGES: [&str; 4] = [
    include_str!("../../docs/reference/verdicts.md"),
    include_str!("../../docs/reference/outputs.md"),
    include_str!("../../docs/reference/json.md"),
    include_str!("../../docs/reference/keywords.md"),
];

/// The first column of tables of keywords, whose others have titles of their own.
const KEYWORD: &str = "keyword";

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
    // The titles of the columns after the first, of a table that is read.
    let mut titles: Option<Vec<&str>> = None;
    PAGES.iter().flat_map(|page| page.lines()).filter_map(move |line| {
        let Some(cells) = line.strip_prefix('|') else {
            titles = None;
            return None;
        };
        let cells: Vec<&str> = cells.trim_end().trim_end_matches('|').split('|').map(str::trim).collect();
        let (word, rest) = cells.split_first()?;
        if *word == KEYWORD || matches!(rest.first(), Some(&("meaning" | "holds"))) {
            titles = Some(if *word == KEYWORD { rest.to_vec() } else { vec![""] });
            return None;
        }
        let titles = titles.as_ref().filter(|_| !word.starts_with("---"))?;
        let told = titles.iter().zip(rest).filter(|(_, cell)| !cell.is_empty());
        let told: Vec<String> = told
            .map(|(title, cell)| if title.is_empty() { (*cell).into() } else { format!("{title}: {cell}") })
            .collect();
        let told = if told.is_empty() { "read".to_owned() } else { told.join("; ") };
        Some(Meaning { word: (*word).into(), meaning: without_links(&told).into() })
    })
}

/// The text of Markdown, `[text](place)` by its text alone.
fn without_links(text: &str) -> String {
    let mut parts = text.split("](");
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let after = part.split_once(')').map_or("", |(_, after)| after);
        if let Some(at) = plain.rfind('[') {
            plain.remove(at);
        }
        plain.push_str(after);
    }
    plain
}

/// The meanings of a word, in any case: of rows that list it, or of which it is the beginning.
pub fn of(word: &str) -> Vec<Meaning> {
    let asked = word.to_lowercase();
    let lists = |row: &Meaning, is_it: &dyn Fn(&str) -> bool| {
        row.word.split(", ").flat_map(|one| one.split(" with ")).any(|one| {
            // A path of JSON is known by its last key.
            let plain = one.replace(['`', '…', '*'], "").replace("[]", "").to_lowercase();
            is_it(&plain) || plain.rsplit_once('.').is_some_and(|(_, last)| is_it(last))
        })
    };
    let mut exact: Vec<Meaning> = meanings().filter(|row| lists(row, &|one| one == asked)).collect();
    exact.extend(of_scenes(&asked));
    if !exact.is_empty() || asked.chars().count() < 3 {
        return exact;
    }
    let begun: Vec<Meaning> = meanings().filter(|row| lists(row, &|one| one.starts_with(&asked))).collect();
    // An output of one component goes by the name of all: CRF2 and CRM2 are of CRF.
    let of_component = asked.strip_suffix(['1', '2', '3', '4', '5', '6']).filter(|_| begun.is_empty());
    of_component.map_or(begun, |all| {
        let all = all.strip_suffix('r').unwrap_or(all);
        let forces = all.strip_suffix('m').map_or_else(|| all.to_owned(), |start| format!("{start}f"));
        meanings().filter(|row| lists(row, &|one| one == forces)).collect()
    })
}

/// What is read of a keyword of decks.
pub fn of_keyword(name: &str) -> Vec<Meaning> {
    of(name).into_iter().filter(|row| row.word.contains("`*")).collect()
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
        assert!(meanings().all(|one| !one.meaning.contains("](")));
    }

    /// Keywords of decks, and outputs of one component.
    #[test]
    fn keywords_and_outputs_are_explained() {
        for word in [
            "EQUATION",
            "rigid body",
            "COUPLING",
            "KINEMATIC",
            "CONNECTOR STOP",
            "CONN3D2",
            "FRICTION",
            "TIE",
        ] {
            assert!(of(word).iter().any(|one| one.word.contains(&word.to_uppercase())), "{word}");
        }
        assert!(!super::of_keyword("TIE").is_empty() && super::of_keyword("MPCS").is_empty());
        for word in ["CRF2", "CRM1", "CTF3", "CUR1"] {
            assert!(!of(word).is_empty(), "{word}");
        }
    }
}
