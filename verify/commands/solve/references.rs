//! The stored solutions and the pages of `references/`: what is written there is what is solved.
//!
//! `PINTLE_UPDATE=1` writes pages and pictures, `PINTLE_UPDATE=solutions` the solutions on 237 bits besides (`doubles`: on doubles, where
//! that takes too long); `PINTLE_REFERENCE=NAME` takes one problem alone.

use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::scalar::Wide;
use pintle_report::solve::picture;
use pintle_scene::Scene;
use pintle_solve::{ConnectorFrame, Frame, Method, Number, Options, REFERENCES, Solution, Solvable, solve};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// The intervals of a stored solution, and those of a picture.
const STORED: usize = 20;
const DRAWN: usize = 240;

/// Digits of a stored solution.
const DIGITS: usize = 16;

/// How far doubles may be from it, relative to the largest of its kind: a hundred steps of 1e-14.
const ALLOWED: f64 = 2e-12;

/// How far the times of events may be from it, in units of time.
const EVENT: f64 = 1e-13;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("references").join(name)
}

fn end(scene: &Scene) -> f64 {
    let schedule = pintle_model::behavior::drive::Schedule::new(scene);
    let last = schedule.len().checked_sub(1).and_then(|last| schedule.span(last));
    last.map_or(0.0, |([_, end], _)| end)
}

fn times(scene: &Scene, count: usize) -> Vec<f64> {
    (1..count).map(|i| end(scene) * (i * DRAWN / count) as f64 / DRAWN as f64).collect()
}

fn solved<R: Solvable>(scene: &Scene, options: &Options) -> Solution<R> {
    solve(scene, options).unwrap_or_else(|ended| panic!("{} at {}: {}", scene.name, ended.time, ended.why))
}

/// An output of a connector.
type Six<R> = fn(&ConnectorFrame<R>) -> [R; 6];

/// What is stored of a frame: names and numbers, the same ones for each frame.
fn columns<R: Number>(solution: &Solution<R>, frame: &Frame<R>) -> Vec<(String, R)> {
    let mut found = vec![("time".to_string(), frame.time)];
    for (label, node) in solution.nodes.iter().zip(&frame.nodes) {
        let parts: [(&str, &[R]); 4] = [
            ("U", &node.displacement),
            ("UR", &node.rotation),
            ("V", &node.velocity[..3]),
            ("VR", &node.velocity[3..]),
        ];
        for (name, three) in parts {
            found
                .extend(three.iter().enumerate().map(|(k, x)| (format!("node {label} {name}{}", k + 1), *x)));
        }
    }
    for ((_, title), of) in solution.connectors.iter().zip(&frame.connectors) {
        let parts: [(&str, Six<R>); 4] = [
            ("CU", |of| of.displacement),
            ("CV", |of| of.velocity),
            ("CTF", |of| of.total),
            ("CSF", |of| of.friction),
        ];
        for (name, six) in parts {
            for k in (0..6).filter(|k| of.wanted[*k] && !(name == "CTF" && of.open[*k])) {
                found.push((format!("{title} {name} {}", COMPONENT[k]), six(of)[k]));
            }
        }
    }
    let energies = &frame.energies;
    found.push(("kinetic energy".to_string(), energies.kinetic));
    found.push(("stored energy".to_string(), energies.stored));
    found.push(("dissipated energy".to_string(), energies.dissipated));
    found.push(("external work".to_string(), energies.external));
    found
}

/// Column by column, of the frames that were asked for; those that are zero throughout are left out.
fn table<R: Number>(solution: &Solution<R>, every: usize) -> Vec<(String, Vec<R>)> {
    let frames: Vec<&Frame<R>> =
        solution.frames.iter().filter(|frame| !frame.is_event).step_by(every).collect();
    let mut found: Vec<(String, Vec<R>)> = Vec::new();
    for frame in frames {
        for (i, (name, x)) in columns(solution, frame).into_iter().enumerate() {
            match found.get_mut(i) {
                Some((_, column)) => column.push(x),
                None => found.push((name, vec![x])),
            }
        }
    }
    // The whole turns of what turns about several axes depend on the way: its rotation is not stored.
    let is_still = |all: &[R]| all.iter().all(|x| x.to_f64().abs() < 1e-14);
    let turning = found.iter().filter(|(name, all)| name.contains(" UR") && !is_still(all));
    let turning: Vec<String> = turning.map(|(name, _)| name[..name.len() - 1].to_string()).collect();
    let about = |name: &str| turning.iter().filter(|of| name.starts_with(of.as_str())).count();
    found.retain(|(name, _)| !name.contains(" UR") || about(name) < 2);
    found
}

/// Of one kind: names without labels and components.
fn kind(name: &str) -> String {
    let words: Vec<&str> = name.split(' ').collect();
    match words[..] {
        ["node", _, what] => what.trim_end_matches(char::is_numeric).to_string(),
        [_, _, what, component] => format!("{what}{}", component.starts_with("ur")),
        [.., last] if last == "energy" || last == "work" => "energy".to_string(),
        _ => name.to_string(),
    }
}

/// What is smaller in units of the decks counts as rounding of this size.
const NOTHING: f64 = 1e-3;

/// The largest of the same kind, or of what it is made of. A force counts as a moment too, at an arm as long as the model, and the other way round.
fn scale_of(all: &[(String, Vec<f64>)], of: &str, length: f64) -> f64 {
    let largest = |kind_of: &str| {
        let same = all.iter().filter(|(name, _)| kind(name) == kind_of);
        same.flat_map(|(_, column)| column).fold(NOTHING, |most: f64, x| most.max(x.abs()))
    };
    let own = kind(of);
    match own.as_str() {
        "CTFfalse" => largest(&own).max(largest("CTFtrue") / length),
        "CTFtrue" => largest(&own).max(largest("CTFfalse") * length),
        // Differences of those of nodes.
        "CVfalse" => largest(&own).max(largest("V")),
        "CVtrue" => largest(&own).max(largest("VR")),
        _ => largest(&own),
    }
}

/// The solution as it is stored: numbers as texts, a line for each column.
fn stored<R: Number>(one: &Solution<R>, error: f64) -> String {
    let is_wide = R::ROUNDING < f64::EPSILON / 4.0;
    let digits = if error > 0.0 { (-error.log10()).floor() as usize } else { DIGITS };
    let digits = digits.min(DIGITS);
    assert!(digits >= if is_wide { 13 } else { 11 }, "an error of {error:e}");
    let table = table(one, 1);
    let doubles: Vec<(String, Vec<f64>)> =
        table.iter().map(|(name, all)| (name.clone(), all.iter().map(|x| x.to_f64()).collect())).collect();
    // Digits beyond the error are not printed: a number is known to that of the largest of its kind.
    let number = |x: R, scale: f64| {
        let size = x.to_f64().abs();
        let known = digits as f64 + (size / scale).log10().ceil();
        if size == 0.0 || known < 1.0 { "0".to_string() } else { x.digits(known as usize) }
    };
    let list =
        |words: Vec<String>| words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
    let mut text = String::from("{\n");
    let _ = writeln!(text, " \"schema\": \"pintle-reference/1\",");
    let is =
        if is_wide { "reproduced: two methods on 237 bits" } else { "estimated: two methods on doubles" };
    let _ = writeln!(text, " \"is\": \"{is}\",");
    let _ = writeln!(
        text,
        " \"error\": {error:.0e},\n \"digits\": {digits},\n \"lipschitz\": {:.6},",
        one.lipschitz
    );
    let _ = writeln!(text, " \"events\": [");
    let last = one.frames.last().map_or(1.0, |frame| frame.time.to_f64());
    for (i, event) in one.events.iter().enumerate() {
        let comma = if i + 1 < one.events.len() { "," } else { "" };
        let components: Vec<String> = event.components.iter().map(|k| COMPONENT[*k].to_string()).collect();
        let margin = event.margin.map_or_else(|| "null".to_string(), |margin| format!("{margin:.6}"));
        let _ = writeln!(
            text,
            "  [\"{}\", \"{}\", [{}], \"{}\", {margin}]{comma}",
            number(event.time, last),
            one.connectors[event.connector].1,
            list(components),
            event.what.name(),
        );
    }
    let _ = writeln!(text, " ],\n \"columns\": {{");
    let kept: Vec<&(String, Vec<R>)> = table
        .iter()
        .filter(|(name, all)| {
            let scale = scale_of(&doubles, name, one.length);
            all.iter().any(|x| x.to_f64().abs() > 1e-15 * scale)
        })
        .collect();
    for (i, (name, all)) in kept.iter().enumerate() {
        let scale = scale_of(&doubles, name, one.length);
        let comma = if i + 1 < kept.len() { "," } else { "" };
        let all = all.iter().map(|x| number(*x, scale)).collect();
        let _ = writeln!(text, "  \"{name}\": [{}]{comma}", list(all));
    }
    text.push_str(" }\n}\n");
    text
}

/// By two methods, with their difference as the error.
fn written<R: Solvable>(scene: &Scene, [options, witness]: [&Options; 2]) -> String {
    let (one, other): (Solution<R>, Solution<R>) =
        rayon::join(|| solved(scene, options), || solved(scene, witness));
    let error = one.difference(&other).largest();
    // Forces of hard springs and dashpots have so many digits less than what they hold.
    let is_wide = R::ROUNDING < f64::EPSILON / 4.0;
    if is_wide && error > 1e-14 && options.digits < DIGITS + 4 {
        let more = [options, witness].map(|of| Options { digits: of.digits + 4, ..of.clone() });
        return written::<R>(scene, [&more[0], &more[1]]);
    }
    stored(&one, error)
}

/// The page of a problem.
fn page(name: &str, scene: &Scene, (stored, open): (&Value, &[String])) -> String {
    let sentence = scene.heading.trim();
    let stop = if sentence.ends_with('.') { "" } else { "." };
    let title = name.replace('_', " ");
    let mut text = format!("# {title}\n\n![{sentence}](picture.svg)\n\n{sentence}{stop}\n\n");
    let beside = |file: &str| -> Option<Value> {
        let text = fs::read_to_string(folder(name).join(file)).ok()?;
        Some(serde_json::from_str(&text).unwrap())
    };
    let closed = beside("closed.json");
    let _ = writeln!(text, "| | |\n|---|---|\n| deck | [deck.inp](deck.inp) |");
    let error = stored["error"].as_f64().unwrap();
    let _ = writeln!(
        text,
        "| solution | [solution.json](solution.json), {}: they differ by {error:.0e} at most |",
        stored["is"].as_str().unwrap()
    );
    if let Some(closed) = &closed {
        let form = closed["form"].as_str().unwrap_or_default().replace('|', "\\|");
        let kind = closed["from"].as_str().and_then(|from| from.split(':').next()).unwrap_or_default();
        let _ = writeln!(text, "| {kind} | [closed.json](closed.json): {form} |");
    }
    if let Some(published) = beside("published.json") {
        let from = published["from"].as_str().unwrap();
        let _ = writeln!(text, "| published | [published.json](published.json): {from} |");
    }
    if !open.is_empty() {
        const MOST: usize = 3;
        let first = open[..open.len().min(MOST)].join(", ");
        let more = if open.len() > MOST { format!(" and {} more", open.len() - MOST) } else { String::new() };
        let why = "constraints repeat each other, so that many forces fit";
        let _ = writeln!(text, "| open CTF | {first}{more}: {why} |");
    }
    let kappa = stored["lipschitz"].as_f64().unwrap();
    let rubs = stored["columns"].as_object().unwrap().keys().any(|name| name.contains("CSF"));
    if rubs {
        let _ =
            writeln!(text, "| unique | κ = {kappa:.3} < 1: the friction forces are the only ones that fit |");
    }
    let _ = writeln!(text, "| your run | `pintle compare references/{name} --against my-run.csv` |");
    let events = stored["events"].as_array().unwrap();
    const MOST: usize = 12;
    if !events.is_empty() {
        let _ = writeln!(text, "\n| time | connector | event | margin |\n|---|---|---|---|");
        for event in events.iter().take(MOST) {
            let margin = event[4].as_f64().map_or_else(|| "–".to_string(), |margin| format!("{margin:.3}"));
            let _ = writeln!(
                text,
                "| {} | {} | {} | {margin} |",
                event[0].as_str().unwrap(),
                event[1].as_str().unwrap(),
                event[3].as_str().unwrap()
            );
        }
        if events.len() > MOST {
            let _ = writeln!(text, "\nThe other {} are in solution.json.", events.len() - MOST);
        }
    }
    let columns = stored["columns"].as_object().unwrap();
    let last: Vec<(&String, &str)> = columns
        .iter()
        .filter(|(name, _)| !name.starts_with("node") && *name != "time" && !name.contains("energy"))
        .map(|(name, all)| (name, all.as_array().unwrap().last().unwrap().as_str().unwrap()))
        .filter(|(name, x)| *x != "0" && *name != "external work")
        .take(MOST)
        .collect();
    if !last.is_empty() {
        let _ = writeln!(text, "\n| at the end | |\n|---|---|");
        for (name, x) in last {
            let _ = writeln!(text, "| {name} | {x} |");
        }
    }
    text
}

/// Where a text differs from that of a file, or nothing; under PINTLE_UPDATE it is written.
fn differs(path: &Path, text: &str) -> Option<String> {
    if std::env::var_os("PINTLE_UPDATE").is_some() {
        fs::write(path, text).unwrap();
        return None;
    }
    let known = fs::read_to_string(path).unwrap_or_default();
    let line = known.lines().zip(text.lines()).position(|(known, now)| known != now);
    (known != text).then(|| format!("{}:{}", path.display(), line.map_or(0, |line| line + 1)))
}

#[test]
fn stored_solutions_are_those_of_the_solver_and_pages_are_current() {
    let what = std::env::var("PINTLE_UPDATE").unwrap_or_default();
    let is_writing = ["solutions", "doubles"].contains(&what.as_str());
    let only = std::env::var("PINTLE_REFERENCE").ok();
    let (mut numbers, mut events, mut pages) = (0, 0, 0);
    let mut stale = Vec::new();
    for (name, deck) in REFERENCES.iter().filter(|(name, _)| only.as_deref().is_none_or(|only| only == *name))
    {
        let scene = Scene::parse(&format!("{name}.inp"), deck).unwrap();
        let path = folder(name).join("solution.json");
        if is_writing {
            let begin = std::time::Instant::now();
            let options = Options {
                digits: if what == "doubles" { 14 } else { DIGITS + 1 },
                times: times(&scene, STORED),
                ..Options::default()
            };
            let witness = Options { method: Method::Collocation, ..options.clone() };
            let text = if what == "doubles" {
                written::<f64>(&scene, [&options, &witness])
            } else {
                written::<Wide>(&scene, [&options, &witness])
            };
            println!("{name}: {:?}", begin.elapsed());
            fs::write(&path, text).unwrap();
        }
        let text = fs::read_to_string(&path).unwrap();
        let wanted: Value = serde_json::from_str(&text).unwrap();
        let options = Options { times: times(&scene, DRAWN), ..Options::default() };
        let solution: Solution<f64> = solved(&scene, &options);
        let found = table(&solution, DRAWN / STORED);
        let columns = wanted["columns"].as_object().unwrap();
        let at_event = |i: usize| {
            let time = end(&scene) * i as f64 / STORED as f64;
            solution.events.iter().any(|event| (event.time - time).abs() < 1e-9 * end(&scene))
        };
        for (of, column) in &found {
            let scale = scale_of(&found, of, solution.length).max(1e-300);
            let stored: Vec<f64> = match columns.get(of) {
                Some(all) => {
                    all.as_array().unwrap().iter().map(|x| x.as_str().unwrap().parse().unwrap()).collect()
                }
                None => vec![0.0; STORED + 1],
            };
            assert_eq!(column.len(), stored.len(), "{name}: {of}");
            for (i, (x, want)) in column.iter().zip(&stored).enumerate() {
                // At an event forces jump, and rounding decides on which side a frame is.
                if at_event(i) {
                    continue;
                }
                assert!((x - want).abs() <= ALLOWED * scale, "{name}: {of}, frame {i}: {x:e}, not {want:e}");
                numbers += 1;
            }
        }
        let told = wanted["events"].as_array().unwrap();
        assert_eq!(solution.events.len(), told.len(), "{name}");
        for (event, told) in solution.events.iter().zip(told) {
            let time: f64 = told[0].as_str().unwrap().parse().unwrap();
            assert!((event.time - time).abs() <= EVENT, "{name}: {} {time}", event.time);
            assert_eq!(event.what.name(), told[3].as_str().unwrap(), "{name}");
            events += 1;
        }
        let title = scene.heading.trim().to_string();
        let last = &solution.frames.last().unwrap().connectors;
        let open = solution.connectors.iter().zip(last).flat_map(|((_, title), of)| {
            (0..6).filter(|k| of.open[*k]).map(move |k| format!("{title} {}", COMPONENT[k]))
        });
        let open: Vec<String> = open.collect();
        stale.extend(differs(&folder(name).join("README.md"), &page(name, &scene, (&wanted, &open))));
        stale.extend(differs(&folder(name).join("picture.svg"), &picture(&solution, &title)));
        pages += 1;
    }
    println!("{pages} pages, {numbers} numbers, {events} events");
    assert!(stale.is_empty(), "PINTLE_UPDATE=1 writes them again: {stale:?}");
    assert!(
        only.is_some() || pages >= 70 && numbers > 20_000 && events >= 150,
        "{pages}, {numbers}, {events}"
    );
}
