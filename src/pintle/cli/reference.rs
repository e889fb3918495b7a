//! The problems of `references/`, by their names.

use super::Failure;
use pintle_scene::{GALLERY, Scene};
use pintle_solve::{Difference, Method, Options, REFERENCES, Refusal, Solution, estimate, solve};
use std::fs;
use std::path::Path;

/// The scene of `references/NAME`, and of `gallery:NAME` where the gallery has none of that name; of a directory NAME, too, whose deck is
/// that of the reference.
pub(super) fn reference(name: &str) -> Option<Result<Scene, Failure>> {
    let of_gallery = name.strip_prefix("gallery:");
    let of_gallery = of_gallery.filter(|name| !GALLERY.iter().any(|example| example.name == *name));
    let named =
        of_gallery.or_else(|| name.strip_prefix("references/").map(|name| name.trim_end_matches('/')));
    let known = named.and_then(|name| REFERENCES.iter().find(|(known, _)| *known == name));
    let (name, deck) = known.or_else(|| of_directory(Path::new(name)))?;
    Some(Scene::parse(&format!("{name}.inp"), deck).map_err(Failure::from))
}

/// The reference of which a directory has the name and the deck.
fn of_directory(directory: &Path) -> Option<&'static (&'static str, &'static str)> {
    let whole = directory.canonicalize().ok().filter(|path| path.is_dir())?;
    let found = REFERENCES.iter().find(|(name, _)| whole.file_name().is_some_and(|last| last == *name))?;
    let deck = fs::read_to_string(whole.join("deck.inp")).ok()?;
    Some(found).filter(|(_, known)| *known == deck)
}

/// A solution at some times on doubles, and how far its witness is from it.
pub(super) fn both(scene: &Scene, times: Vec<f64>) -> Result<(Solution<f64>, Difference), Failure> {
    let options = Options { times, ..Options::default() };
    let witness = Options { method: Method::Collocation, ..options.clone() };
    let (one, other) = rayon::join(|| solve(scene, &options), || solve(scene, &witness));
    let [one, other] = [one, other].map(|of| of.map_err(|ended| Failure::Input(told(&ended.why))));
    let one = one?;
    let difference = one.difference(&other?);
    let difference = estimate(scene, &options, (&one, difference));
    Ok((one, difference))
}

/// The time at which the steps of a scene end, as far as it is known.
pub(super) fn length(scene: &Scene) -> f64 {
    let schedule = pintle_model::behavior::drive::Schedule::new(scene);
    let last = schedule.len().checked_sub(1).and_then(|last| schedule.span(last));
    last.map_or(0.0, |([_, end], _)| end)
}

/// Why something is not solved, with its remedy.
pub(super) fn told(why: &Refusal) -> String {
    match why {
        Refusal::Scene(diagnostic) => diagnostic.to_string(),
        Refusal::Of { what, why, remedy } => format!("{what}: {why}\n  help: {remedy}"),
    }
}
