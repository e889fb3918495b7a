//! `pintle explain WORD`: what a word of a report, an output, a flag or a key of JSON means. The reference pages are the one list; of keys of a
//! scene it is the schema of scenes.

use crate::layout::{self, BOLD, DIM, styled};
use serde_json::Value;
use std::borrow::Cow;
use std::io::{self, Write};
use std::iter;

/// The pages: tables whose first column is the word, or words, and whose second is the meaning, or what a field holds.
const PAGES: [&str; 14] = [
    include_str!("../../docs/reference/words.md"),
    include_str!("../../docs/reference/words-of-audits.md"),
    include_str!("../../docs/reference/verdicts.md"),
    include_str!("../../docs/reference/outputs.md"),
    include_str!("../../docs/reference/conventions.md"),
    include_str!("../../docs/reference/solution.md"),
    include_str!("../../docs/explanation/audit.md"),
    include_str!("../../docs/how-to/sweep.md"),
    include_str!("../../docs/reference/sweep-states.md"),
    include_str!("../../docs/reference/json.md"),
    include_str!("../../docs/reference/protocol.md"),
    include_str!("../../docs/reference/protocol-answers.md"),
    include_str!("../../docs/reference/keywords.md"),
    include_str!("../../docs/reference/keywords-not-read.md"),
];

/// The titles of a second column that has meanings.
const MEANINGS: [&str; 6] = ["meaning", "holds", "says", "sign", "convention", "of"];

/// The first columns of tables whose others have titles of their own.
const TITLED: [&str; 2] = ["keyword", "oracle"];

/// A word and what it means.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Meaning {
    /// The word, or several of one meaning, as the page has them.
    pub word: Cow<'static, str>,
    /// Where it stands: the page and its section, or the scene.
    pub place: Cow<'static, str>,
    /// The meaning.
    pub meaning: Cow<'static, str>,
}

/// Every word of the pages that has a meaning, in their order.
pub fn meanings() -> impl Iterator<Item = Meaning> {
    // Of a table: the titles of its columns after the first, if it is read.
    let mut table: Option<Option<Vec<&str>>> = None;
    let (mut page, mut section) = ("", "");
    PAGES.iter().flat_map(|page| page.lines()).filter_map(move |line| {
        let Some(cells) = line.strip_prefix('|') else {
            table = None;
            if let Some(title) = line.strip_prefix("# ") {
                (page, section) = (title, "");
            }
            section = line.strip_prefix("## ").unwrap_or(section);
            return None;
        };
        let cells: Vec<&str> = cells.trim_end().trim_end_matches('|').split('|').map(str::trim).collect();
        let (word, rest) = cells.split_first()?;
        let Some(titles) = &table else {
            let is_titled = TITLED.contains(word);
            let is_read = is_titled || rest.first().is_some_and(|title| MEANINGS.contains(title));
            table = Some(is_read.then(|| if is_titled { rest.to_vec() } else { vec![""] }));
            return None;
        };
        let titles = titles.as_ref().filter(|_| !word.starts_with("---"))?;
        let told = titles.iter().zip(rest).filter(|(_, cell)| !cell.is_empty());
        let told: Vec<String> = told
            .map(|(title, cell)| if title.is_empty() { (*cell).into() } else { format!("{title}: {cell}") })
            .collect();
        let told = if told.is_empty() { "read".to_owned() } else { told.join("; ") };
        let place = if section.is_empty() { page.to_owned() } else { format!("{page}: {section}") };
        Some(Meaning {
            word: (*word).into(),
            place: place.replace('`', "").into(),
            meaning: without_links(&told).into(),
        })
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

/// Whether a row lists a word, or what `is_it` asks of its words: as a whole, and each of several.
fn lists(row: &Meaning, is_it: &dyn Fn(&str) -> bool) -> bool {
    let several = row.word.split(", ").flat_map(|one| one.split(" with "));
    iter::once(&*row.word).chain(several).any(|one| {
        let plain = one.replace(['`', '…', '*'], "").replace("[]", "").to_lowercase();
        // A path of JSON is known by its last key.
        let last = plain.rsplit_once('.').map(|(_, last)| last).filter(|_| one.contains('`'));
        is_it(&plain) || last.is_some_and(is_it)
    })
}

/// The meanings of a word, in any case: of rows that list it, or of which it is the beginning. A heading is known without its unit, a derivative
/// by what it is of, and by what.
pub fn of(word: &str) -> Vec<Meaning> {
    let found = exactly(word);
    if !found.is_empty() {
        return found;
    }
    let plain = word.split_once(" [").map_or(word, |(plain, _)| plain).trim_end_matches([':', '/']);
    match plain.strip_prefix("∂²").or_else(|| plain.strip_prefix('∂')) {
        Some(derivative) => derivative.split("/∂").flat_map(as_written).collect(),
        None => as_written(plain),
    }
}

/// The meanings of rows that list a word, in any case.
pub fn exactly(word: &str) -> Vec<Meaning> {
    let asked = word.to_lowercase();
    if asked.is_empty() {
        return Vec::new();
    }
    let listed = meanings().filter(|row| lists(row, &|one| one == asked));
    listed.chain(of_scenes(&asked)).collect()
}

/// The meanings of a word, or of those of which it is the beginning.
fn as_written(word: &str) -> Vec<Meaning> {
    let exact = exactly(word);
    let asked = word.to_lowercase();
    if !exact.is_empty() || asked.chars().count() < 3 {
        return exact;
    }
    let begun: Vec<Meaning> = meanings().filter(|row| lists(row, &|one| one.starts_with(&asked))).collect();
    // One component goes by the name of all: CRF2 and CRM2 are of CRF, CUR1 of CU, vr1 of vr.
    let of_component = asked.strip_suffix(['1', '2', '3', '4', '5', '6']).filter(|_| begun.is_empty());
    of_component.map_or(begun, |all| {
        let of_rotations = all.strip_suffix('r').unwrap_or(all);
        let of_moments = all.strip_suffix('m').map_or_else(|| all.to_owned(), |start| format!("{start}f"));
        let names = [all, of_rotations, &of_moments];
        meanings().filter(|row| lists(row, &|one| names.contains(&one))).collect()
    })
}

/// What a key of a scene means, in each object that has it.
fn of_scenes(key: &str) -> Vec<Meaning> {
    let mut found: Vec<Meaning> = Vec::new();
    if let Ok(schema) = serde_json::from_str(pintle_scene::SCHEMA_TEXT) {
        properties("scene", &schema, &mut |object, name, property| {
            let meaning = property.get("description").and_then(Value::as_str);
            if let Some(meaning) = meaning.filter(|_| name.eq_ignore_ascii_case(key)) {
                let meaning = meaning.replace('\n', " ");
                match found.iter_mut().find(|known: &&mut Meaning| known.meaning == meaning) {
                    Some(Meaning { place, .. }) if place.split([' ', ',']).any(|known| known == object) => {}
                    Some(Meaning { place, .. }) => *place = format!("{place}, {object}").into(),
                    None => found.push(Meaning {
                        word: format!("`{name}`").into(),
                        place: format!("a scene in TOML or JSON: {object}").into(),
                        meaning: meaning.into(),
                    }),
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
    for Meaning { word, place, meaning } in found {
        writeln!(out, "{}  {}", styled(BOLD, word), styled(DIM, place))?;
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
    use super::{exactly, meanings, of, properties};
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
        assert!(exactly("TIE").iter().any(|one| one.word.contains("*TIE")) && exactly("TI").is_empty());
        for word in ["CRF2", "CRM1", "CTF3", "CUR1"] {
            assert!(!of(word).is_empty(), "{word}");
        }
    }
}
