//! What the problems of `references/` take: a solution with its witness and the error that both tell.
//!
//! On doubles as `pintle solve` does it, both methods at once; with `wide`, both on 237 bits to 25 digits. Each has the events that are stored.

#![expect(clippy::expect_used, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;

use pintle_kinematics::scalar::Wide;
use pintle_scene::Scene;
use pintle_solve::{Difference, Method, Options, REFERENCES, Solution, Solvable, estimate, solve};
use std::fs;
use std::path::Path;
use std::time::Instant;

/// How many of the slowest are named.
const NAMED: usize = 8;

struct Taken {
    name: &'static str,
    seconds: f64,
    steps: usize,
    evaluations: usize,
    error: f64,
}

fn solved<R: Solvable>(scene: &Scene, options: &Options) -> Solution<R> {
    solve::<R>(scene, options).map_err(|ended| ended.why).expect("a problem of references is solved")
}

/// A solution beside its witness, and how far it is from the truth.
fn taken<R: Solvable>(name: &'static str, deck: &str, digits: usize) -> Taken {
    let scene = Scene::parse(name, deck).expect("a problem of references is read");
    let options = Options { digits, ..Options::default() };
    let witness = Options { method: Method::Collocation, ..options.clone() };
    let start = Instant::now();
    let (one, other): (Solution<R>, Solution<R>) =
        rayon::join(|| solved(&scene, &options), || solved(&scene, &witness));
    let error: Difference = estimate(&scene, &options, (&one, one.difference(&other)));
    let seconds = start.elapsed().as_secs_f64();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("references").join(name).join("solution.json");
    let stored = fs::read_to_string(path).expect("a problem has a solution");
    let stored: serde_json::Value = serde_json::from_str(&stored).expect("a solution is JSON");
    let events = stored["events"].as_array().map(Vec::len);
    assert!(error.same_events && events == Some(one.events.len()), "{name}: other events than stored");
    let (steps, evaluations) = (one.steps + other.steps, one.evaluations + other.evaluations);
    Taken { name, seconds, steps, evaluations, error: error.largest() }
}

fn told(mut all: Vec<Taken>, limit: f64) {
    all.sort_by(|one, other| other.seconds.total_cmp(&one.seconds));
    let within = all.iter().filter(|of| of.seconds <= limit).count();
    let sum: f64 = all.iter().map(|of| of.seconds).sum();
    println!("{within} of {} problems take {limit} s or less, all together {sum:.1} s", all.len());
    println!("{:<20}{:>9}{:>8}{:>10}{:>10}", "slowest", "seconds", "steps", "instants", "error");
    for of in all.iter().take(NAMED) {
        let Taken { name, seconds, steps, evaluations, error } = of;
        println!("{name:<20}{seconds:>9.2}{steps:>8}{evaluations:>10}{error:>10.0e}");
    }
}

fn main() {
    if commit::is_told() {
        return;
    }
    let is_wide = std::env::args().any(|word| word == "wide");
    let all = REFERENCES.iter().copied();
    match is_wide {
        false => told(all.map(|(name, deck)| taken::<f64>(name, deck, 14)).collect(), 1.0),
        true => told(all.map(|(name, deck)| taken::<Wide>(name, deck, 25)).collect(), 120.0),
    }
}
