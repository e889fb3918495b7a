//! Rules that the scene breaks, as the reader and the catalogue tell them.

use super::finding::{About, Finding};
use crate::evaluate::Model;
use crate::scene::{Diagnostic, Label, Scene};

/// Every error and warning of reading and resolving the scene.
pub(super) fn findings(scene: &Scene, model: &Model, errors: Vec<Diagnostic>) -> Vec<Finding> {
    let told = errors.into_iter().chain(scene.warnings.iter().cloned()).chain(model.warnings.iter().cloned());
    told.map(|diagnostic| {
        let elements = element_of(&diagnostic, scene).into_iter().collect();
        Finding::from(diagnostic).about(About { elements, ..About::default() })
    })
    .collect()
}

/// The connector that a message of a rule names: `element 101: …`.
fn element_of(diagnostic: &Diagnostic, scene: &Scene) -> Option<Label> {
    let (_, rest) = diagnostic.message().split_once("element ")?;
    let word: String = rest.chars().take_while(|letter| !matches!(letter, ' ' | ':' | ',')).collect();
    let label = word.parse().ok()?;
    scene.connectors.contains_key(&label).then_some(label)
}
