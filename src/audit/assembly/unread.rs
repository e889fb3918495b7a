//! Which constraints of a deck were not read?

use super::LISTED;
use crate::audit::model::{About, Finding};
use crate::grammar::{count, ranges};
use crate::scene::{Code, Scene, Span};
use indexmap::IndexMap;
use serde::Serialize;

/// Constraints of one kind that are not read, and not in the rank: where there are any, the nodes of connectors may move in fewer ways than is
/// said, and more constraints may be redundant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unread {
    /// The keyword, with its asterisk, or the kind of multi-point constraint: `*EQUATION`, `MPC SLIDER`.
    pub what: String,
    /// How many there are.
    pub count: usize,
    /// Where they are; at most a thousand.
    pub places: Vec<Place>,
}

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Place {
    /// The file.
    pub file: String,
    /// The line.
    pub line: u32,
}

/// What is not read, by kind, with the place of each.
fn of_scene(scene: &Scene) -> IndexMap<String, Vec<Span>> {
    let mut found: IndexMap<String, Vec<Span>> = IndexMap::new();
    for skipped in &scene.skipped.constraints {
        found.entry(format!("*{}", skipped.keyword)).or_default().push(skipped.span);
    }
    for mpc in scene.mpcs.iter().filter(|mpc| mpc.kind.evaluated().is_none()) {
        found.entry(format!("MPC {}", mpc.kind.name())).or_default().push(mpc.span);
    }
    found
}

/// Whether a scene has constraints that are not read.
pub(super) fn is_any(scene: &Scene) -> bool {
    !scene.skipped.constraints.is_empty() || scene.mpcs.iter().any(|mpc| mpc.kind.evaluated().is_none())
}

/// The constraints of a scene that are not read, by kind.
pub(super) fn unread(scene: &Scene) -> Vec<Unread> {
    let place = |span: &Span| {
        let file = scene.files.get(usize::from(span.file())).unwrap_or(&scene.name);
        Place { file: file.clone(), line: span.line() }
    };
    let of_kind = |(what, spans): (String, Vec<Span>)| Unread {
        what,
        count: spans.len(),
        places: spans.iter().take(LISTED).map(place).collect(),
    };
    of_scene(scene).into_iter().map(of_kind).collect()
}

/// A finding for each kind, at the first of them.
pub(super) fn findings(scene: &Scene) -> Vec<Finding> {
    let finding = |(what, spans): (String, Vec<Span>)| {
        let first = spans.first().copied().unwrap_or_default();
        let here: Vec<u64> = spans
            .iter()
            .filter(|span| span.file() == first.file() && span.is_known())
            .map(|span| u64::from(span.line()))
            .collect();
        let elsewhere = match spans.len() - here.len() {
            0 => String::new(),
            more => format!(" and {more} in other files"),
        };
        let lines = if here.is_empty() {
            count(spans.len(), "time")
        } else {
            format!("{}{elsewhere}", ranges("line", &here))
        };
        let message = format!(
            "{what} ({lines}) constrains nodes and is not read: the rank is that of what was read, and with all constraints the nodes of connectors \
             may move in fewer ways than is said, and more constraints may be redundant"
        );
        let reason = "the rank is that of connectors, multi-point constraints that are evaluated, boundary conditions and connector motions";
        let remedy = "where it joins nodes of connectors, write it as connectors or multi-point constraints (BEAM for a rigid body, say) to have it \
                      judged with the others; where it does not, allow this code";
        let about = About { value: Some(spans.len() as f64), ..About::default() };
        Finding::new(scene, Code::AssemblyConstraintsUnread, first, message, reason, remedy).about(about)
    };
    of_scene(scene).into_iter().map(finding).collect()
}
