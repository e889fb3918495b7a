//! Which constraints of a deck were not read?

use crate::facts::{LISTED, Line, Unread};
use pintle_scene::{Scene, Span};

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
    scene.unread_constraints().into_iter().map(of_kind).collect()
}
