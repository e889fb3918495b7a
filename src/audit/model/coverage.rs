//! Which connectors, and which types, did the given states exercise?

use crate::model::finding::{About, Finding};
use crate::sampling::coverage::{Exercise, Lack};
use indexmap::IndexMap;
use pintle_model::evaluate::{ConnectorElement, Model};
use pintle_scene::grammar::{agree, count};
use pintle_scene::{Code, Label, Scene, Severity, Span};

/// The names that a message lists.
const NAMED: usize = 8;

/// The connectors of a type, each with what its states exercised.
type OfType<'a> = IndexMap<&'a str, Vec<(&'a ConnectorElement, &'a Exercise)>>;

/// What the states exercised of no connector of a type, as bad as its code says; and, as a note, connectors that never moved, of types of
/// which another did.
pub(super) fn findings(scene: &Scene, model: &Model, exercises: &[Exercise]) -> Vec<Finding> {
    let mut types: OfType<'_> = IndexMap::new();
    for (element, exercise) in model.connectors.iter().zip(exercises).filter(|(_, of)| of.samples > 0) {
        types.entry(element.connector.connection().name.as_ref()).or_default().push((element, exercise));
    }
    let mut by_code: IndexMap<Code, Vec<(String, Vec<Label>, Lack)>> = IndexMap::new();
    let mut still: Vec<(String, Vec<Label>)> = Vec::new();
    for (name, connectors) in &types {
        let whole = connectors.iter().fold(Exercise::default(), |sum, (_, of)| sum.with(of));
        let lacks = whole.gaps();
        let labels = |wanted: &dyn Fn(&Exercise) -> bool| -> Vec<Label> {
            connectors.iter().filter(|(_, of)| wanted(of)).map(|(element, _)| element.label).collect()
        };
        if whole.away > 0 {
            let unmoved = labels(&|of| of.away == 0);
            if !unmoved.is_empty() {
                still.push(((*name).to_string(), unmoved));
            }
        }
        for lack in lacks {
            by_code.entry(lack.code).or_default().push(((*name).to_string(), labels(&|_| true), lack));
        }
    }
    let reason = "the states given, every connector at each, by connection type";
    let mut found = Vec::new();
    for (code, of_types) in by_code {
        let words: Vec<String> = of_types
            .iter()
            .take(NAMED)
            .map(|(name, labels, lack)| format!("{name} ({}): {}", elements(labels), lack.message))
            .collect();
        let more = match of_types.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!("; and so on for {}", count(more, "other type")),
        };
        let Some(remedy) = of_types.first().map(|(_, _, lack)| lack.remedy) else { continue };
        let message = format!("{}{more}", words.join("; "));
        let labels = of_types.iter().flat_map(|(_, labels, _)| labels.iter().copied());
        found.push(finding(scene, code, message, (reason, remedy), labels));
    }
    if !still.is_empty() {
        let all: usize = still.iter().map(|(_, labels)| labels.len()).sum();
        let words: Vec<String> =
            still.iter().take(NAMED).map(|(name, labels)| format!("{name} ({})", elements(labels))).collect();
        let more = match still.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!("; and {}", count(more, "other type")),
        };
        let message = format!(
            "{} never {} the neighbourhood of the initial state, while others of the type do: {}{more}",
            count(all, "connector"),
            agree(all, ["leaves", "leave"]),
            words.join("; ")
        );
        let remedy = "add states in which they move, unless the others of their type stand for them";
        let labels = still.iter().flat_map(|(_, labels)| labels.iter().copied());
        let one = finding(scene, Code::CoverageIdentity, message, (reason, remedy), labels);
        found.push(one.of_severity(Severity::Note));
    }
    found
}

fn finding(
    scene: &Scene,
    code: Code,
    message: String,
    (reason, remedy): (&str, &str),
    labels: impl Iterator<Item = Label>,
) -> Finding {
    let about = About { elements: labels.take(100).collect(), ..About::default() };
    Finding::new(scene, code, Span::default(), message, reason, remedy).about(about)
}

/// Elements, by number.
fn elements(labels: &[Label]) -> String {
    let named: Vec<String> = labels.iter().take(NAMED).map(ToString::to_string).collect();
    let more = match labels.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{} {}{more}", agree(labels.len(), ["element", "elements"]), named.join(", "))
}
