//! The audit as one page of HTML: nothing is loaded from elsewhere, it reads without scripts, and sorts and filters with them.
//! Everything from the input is escaped by the templates.

mod cards;
pub(crate) mod drawing;
pub(crate) mod figure;
mod found;
mod labels;
mod page;
mod problems;
mod prose;
mod self_test;

use drawing::{Drawing, Worst};
use figure::Medium;
use pintle_audit::{Approach, Illustration, Report, Verdict};
use pintle_model::evaluate::Model;
use pintle_scene::Scene;
use std::io::{self, Write};

/// A scene that was audited, to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Audited<'a> {
    /// Its name in the report.
    pub name: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// The same, resolved.
    pub model: &'a Model,
}

/// What a page shows besides the report.
#[derive(Clone, Debug, Default)]
pub struct Supplement<'a> {
    /// Whether the types of the catalogue were audited.
    pub catalogue: bool,
    /// The scenes.
    pub scenes: Vec<Audited<'a>>,
    /// One state of each connector, as far as it is to be shown.
    pub illustrations: Vec<Illustration>,
    /// The singular sets of the types that the scenes use, where the catalogue was not audited.
    pub approaches: Vec<Approach>,
    /// What was run, as it was typed.
    pub command: String,
}

/// Writes the audit as one self-contained page of HTML.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn html(out: &mut dyn Write, report: &Report, supplement: &Supplement<'_>) -> io::Result<()> {
    out.write_all(page::page(report, supplement)?.as_bytes())
}

/// The figures of the page, each as an SVG file of its own, by file name.
pub fn figures(report: &Report, supplement: &Supplement<'_>) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for shown in &supplement.illustrations {
        let name = file_name(&shown.subject);
        let title = figure::title(shown);
        found.push((format!("jacobian-{name}.svg"), figure::heat(&title, &shown.comparison, Medium::File)));
        if !shown.steps.remainder.is_empty() {
            found.push((format!("steps-{name}.svg"), figure::steps(shown, Medium::File)));
        }
    }
    let noticed = cards::strip(report, Medium::File);
    if !noticed.is_empty() {
        found.push(("smallest-error-noticed.svg".to_string(), noticed));
    }
    for (scene, figure) in found::coverage_figures(report) {
        found.push((format!("coverage-{}.svg", file_name(&scene)), figure));
    }
    for approach in report.atlas.iter().chain(&supplement.approaches) {
        let name = file_name(&format!("{} {}", approach.connection, approach.component));
        // A component may have several singular points.
        let nth = |n: usize| if n == 1 { String::new() } else { format!("-{n}") };
        let mut names = (1..).map(|n| format!("singular-{name}{}.svg", nth(n)));
        let name = names.find(|name| found.iter().all(|(taken, _)| taken != name));
        found.extend(name.map(|name| (name, cards::approach(approach, Medium::File))));
    }
    for scene in &supplement.scenes {
        let drawing = drawing(report, scene);
        if !drawing.is_empty() {
            let name = file_name(scene.name);
            found.push((format!("scene-{name}.svg"), drawing.svg(scene.name, Medium::File)));
        }
    }
    // Names that became equal get numbers.
    let mut seen: std::collections::BTreeMap<String, usize> = std::collections::BTreeMap::new();
    for (name, _) in &mut found {
        let count = seen.entry(name.clone()).or_default();
        *count += 1;
        if *count > 1 {
            *name = format!("{}-{count}.svg", name.trim_end_matches(".svg"));
        }
    }
    found
}

fn drawing(report: &Report, scene: &Audited<'_>) -> Drawing {
    let of_scene: std::collections::HashMap<&str, Verdict> = report
        .subjects
        .iter()
        .filter(|subject| crate::audit::summary::scene(subject).is_none_or(|name| name == scene.name))
        .map(|subject| (subject.name.as_str(), subject.verdict()))
        .collect();
    let models = report.models.iter().filter(|model| model.scene == scene.scene.name);
    let worst = Worst::of(models.flat_map(|model| &model.findings));
    Drawing::of(scene.scene, scene.model, &|name| of_scene.get(name).copied(), &worst)
}

/// A name of a file: letters and digits of the text, lower case, the rest as hyphens.
fn file_name(text: &str) -> String {
    let words: Vec<String> = text
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(str::to_ascii_lowercase)
        .collect();
    words.join("-")
}
