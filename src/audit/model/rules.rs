//! Rules that the scene breaks, as the reader and the catalogue tell them.

use crate::model::finding::{About, Finding};
use pintle_model::evaluate::Model;
use pintle_scene::grammar::count;
use pintle_scene::{Diagnostic, Scene};

/// Every error and warning of reading and resolving the scene.
pub(super) fn findings(scene: &Scene, model: &Model, errors: Vec<Diagnostic>) -> Vec<Finding> {
    let told = errors.into_iter().chain(scene.warnings.iter().cloned()).chain(model.warnings.iter().cloned());
    told.map(|diagnostic| {
        let mut elements = diagnostic.elements().to_vec();
        elements.dedup();
        let others = match elements.len() {
            0 | 1 => String::new(),
            several => format!(" (and so on for {})", count(several - 1, "other element")),
        };
        Finding::from(diagnostic).add(&others).about(About { elements, ..About::default() })
    })
    .collect()
}
