//! Which constraints of a deck were not read?

use crate::facts::{LISTED, Line, Unread};
use indexmap::IndexMap;
use pintle_scene::{Scene, Span};

/// What is not read, by kind, with the place of each.
pub fn of_scene(scene: &Scene) -> IndexMap<String, Vec<Span>> {
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
pub fn is_any(scene: &Scene) -> bool {
    !scene.skipped.constraints.is_empty() || scene.mpcs.iter().any(|mpc| mpc.kind.evaluated().is_none())
}

/// The constraints of a scene that are not read, by kind.
pub(crate) fn unread(scene: &Scene) -> Vec<Unread> {
    let place = |span: &Span| {
        let file = scene.files.get(usize::from(span.file())).unwrap_or(&scene.name);
        Line { file: file.clone(), line: span.line() }
    };
    let of_kind = |(what, spans): (String, Vec<Span>)| Unread {
        what,
        count: spans.len(),
        places: spans.iter().take(LISTED).map(place).collect(),
    };
    of_scene(scene).into_iter().map(of_kind).collect()
}
