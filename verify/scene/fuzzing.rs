//! What must hold of any bytes whatever, given as a scene or as states: the bodies of the fuzz targets in `fuzz/`.
//!
//! Bytes are read or refused; what is refused has a place and a remedy; what is read reads the same again, and can be evaluated
//! and shown. A scene in TOML or JSON is the same scene after it was written in any form and read from there. Every input ever found to break this stands in `fuzz/regressions/`, and is tried here with the seeds.

use pintle_kinematics::connector::Request;
use pintle_model::evaluate::{Item, Model, Plan, Selection, Sequence};
use pintle_report::csv::Csv;
use pintle_report::human::{Human, Style};
use pintle_report::json::Json;
use pintle_report::{Block, Format, Subject};
use pintle_scene::{
    Diagnostic, Format as Form, GALLERY, NodeMotion, Rotation, Scene, Severity, Skipped, State, StateFile,
};
use std::io;

/// Any bytes as a deck.
pub(crate) fn deck(bytes: &[u8]) {
    let read = || Scene::parse_bytes("deck.inp", bytes);
    match read() {
        Err(error) => refused(&error, "deck.inp", bytes),
        Ok(scene) => {
            scene.warnings.iter().for_each(|warning| warned(warning, bytes));
            assert_eq!(json(&scene), json(&read().expect("the same deck is read again")));
            evaluate(&scene, &[State::default(), moved(&scene)]);
        }
    }
}

/// Any text as a scene in TOML.
pub(crate) fn toml_scene(bytes: &[u8]) {
    document(bytes, "scene.toml", Form::Toml);
}

/// Any text as a scene in JSON.
pub(crate) fn json_scene(bytes: &[u8]) {
    document(bytes, "scene.json", Form::Json);
}

fn document(bytes: &[u8], name: &str, form: Form) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match parse(name, text, form) {
        Err(error) => {
            assert!(error.line().is_some(), "{error} has no place");
            refused(&error, name, bytes);
        }
        Ok(scene) => {
            scene.warnings.iter().for_each(|warning| warned(warning, bytes));
            assert_eq!(
                json(&scene),
                json(&parse(name, text, form).expect("the same document is read again"))
            );
            survives(&scene);
            let mut states = scene.states[..scene.states.len().min(4)].to_vec();
            states.push(moved(&scene));
            evaluate(&scene, &states);
        }
    }
}

fn parse(name: &str, text: &str, form: Form) -> Result<Scene, Diagnostic> {
    match form {
        Form::Deck => Scene::parse(name, text),
        Form::Toml => Scene::parse_toml(name, text),
        Form::Json => Scene::parse_json(name, text),
    }
}

/// Written in any form and read from there, a scene is the same: a deck has no states, and what only skipped elements tell.
fn survives(scene: &Scene) {
    for form in [Form::Deck, Form::Toml, Form::Json] {
        let text = scene.write(form).expect("a scene that was read can be written").text;
        let again = parse("again", &text, form)
            .unwrap_or_else(|error| panic!("{}\n{text}", error.render(110, false)));
        let (before, after) = (content(scene, form), content(&again, form));
        assert!(before == after, "{form:?} loses something:\n{before}\n{after}\n{text}");
    }
}

/// What a form says of a scene, without what the reader notes of the file.
fn content(scene: &Scene, form: Form) -> String {
    let mut scene = scene.clone();
    scene.name.clear();
    scene.skipped = Skipped::default();
    if form == Form::Deck {
        scene.states.clear();
        scene.rotating_nodes.clear();
        scene.axisymmetric = false;
    }
    json(&scene)
}

/// Any text as states of a scene of the gallery, written as CSV.
pub(crate) fn csv_states(bytes: &[u8]) {
    states(bytes, "states.csv", StateFile::parse_csv);
}

/// Any text as states of a scene of the gallery, written as JSON.
pub(crate) fn json_states(bytes: &[u8]) {
    states(bytes, "states.json", StateFile::parse_json);
}

type Parse = fn(&str, &str, &Scene) -> Result<StateFile, Diagnostic>;

fn states(bytes: &[u8], name: &str, parse: Parse) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    for example in GALLERY {
        let scene = example.scene().expect("the gallery is sound");
        match parse(name, text, &scene) {
            Err(error) => refused(&error, name, bytes),
            Ok(file) => {
                let json = file.to_json().expect("finite numbers have JSON");
                let again = StateFile::parse_json("again.json", &json, &scene).expect("our JSON is read");
                assert_eq!(file, again, "JSON loses something");
                let few = &file.states[..file.states.len().min(4)];
                evaluate(&scene, few);
            }
        }
    }
}

/// An error is complete: a remedy, the name of the file, and, if it has a place, one in the file.
fn refused(error: &Diagnostic, file: &str, bytes: &[u8]) {
    assert_eq!(error.severity(), Severity::Error);
    assert!(!error.message().is_empty() && !error.remedy().is_empty(), "{error}");
    assert_eq!(error.file(), file, "{error}");
    in_place(error, bytes);
}

fn warned(warning: &Diagnostic, bytes: &[u8]) {
    assert_eq!(warning.severity(), Severity::Warning);
    assert!(!warning.message().is_empty() && !warning.remedy().is_empty(), "{warning}");
    in_place(warning, bytes);
}

fn in_place(diagnostic: &Diagnostic, bytes: &[u8]) {
    if let Some(line) = diagnostic.line() {
        let start = usize::try_from(diagnostic.span().start()).expect("a place in memory");
        let before = bytes.get(..start).expect("a place in the file");
        let lines = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
        assert_eq!(lines, line as usize, "{diagnostic} points elsewhere");
    }
    assert!(!diagnostic.render(80, false).is_empty());
}

fn json(scene: &Scene) -> String {
    serde_json::to_string(scene).expect("a scene has JSON")
}

/// A state in which every node has moved, turned and has rates, each differently.
fn moved(scene: &Scene) -> State {
    let motion = |place: usize| {
        let part = |k: usize| ((place * 7 + k * 3) % 11) as f64 / 11.0 - 0.4;
        let three = |k| [part(k), part(k + 1), part(k + 2)];
        NodeMotion {
            displacement: three(0),
            rotation: Rotation::Vector(three(3)),
            velocity: three(6),
            angular_velocity: three(9),
            acceleration: three(12),
            angular_acceleration: three(15),
            flow: part(18),
            flow_velocity: part(19),
            flow_acceleration: part(20),
        }
    };
    let nodes = scene.nodes.keys().enumerate().map(|(place, node)| (*node, motion(place)));
    State { time: Some(1.0), nodes: nodes.collect(), ..State::default() }
}

/// Evaluates everything with first derivatives, in all formats. A number that is not finite is flagged.
fn evaluate(scene: &Scene, states: &[State]) {
    let model = match Model::compile(scene) {
        Ok(model) => model,
        Err(error) => {
            assert!(!error.message().is_empty() && !error.remedy().is_empty(), "{error}");
            return;
        }
    };
    let request = Request::everything(1);
    let plan = Plan::compile(&model, &Selection::All, request.clone()).expect("all can be selected");
    let (mut human, mut json, mut csv) = (io::sink(), io::sink(), io::sink());
    let style = Style { width: 80, digits: 6, verbose: true };
    let mut formats: [Box<dyn Format + '_>; 3] = [
        Box::new(Human::new(&mut human, style)),
        Box::new(Json::new(&mut json)),
        Box::new(Csv::new(&mut csv, request.outputs().collect(), request.order)),
    ];
    let shown = [0..=u64::MAX];
    let subject = Subject {
        scene,
        model: &model,
        plan: &plan,
        states: states.len(),
        shown: &shown,
        first: 0,
        last: u64::MAX,
    };
    let mut sequence = Sequence::new(&model, &plan);
    let mut write = |call: &mut dyn FnMut(&mut dyn Format) -> io::Result<()>| {
        formats.iter_mut().try_for_each(|format| call(format.as_mut())).expect("a sink takes everything");
    };
    write(&mut |format| format.begin());
    write(&mut |format| format.scene(&subject));
    for state in states {
        write(&mut |format| format.state(sequence.states(), state.time));
        let Ok(()) = sequence.visit(state, |item| -> Result<(), std::convert::Infallible> {
            let block = match item {
                Item::Connector(result) => Block::of_connector(&model, &request, result),
                Item::Mpc(result) => Block::of_mpc(&model, &request, result),
                Item::Relation(result) => Block::of_relation(&model, &request, result),
            };
            let values = block.rows.iter().flat_map(|row| row.values.iter().flatten()).map(|v| v.number());
            let rows = block.derivatives.iter().flat_map(|row| row.gradient.iter().copied());
            let is_finite = values.chain(rows).all(f64::is_finite);
            assert!(is_finite || !block.flags.is_empty(), "{} is not finite and not flagged", block.title());
            write(&mut |format| format.block(&block));
            Ok(())
        });
        write(&mut |format| format.end_state());
    }
    write(&mut |format| format.end_scene(sequence.tally()));
    write(&mut |format| format.end());
}

#[cfg(test)]
mod seeds {
    use std::fs;
    use std::path::Path;

    /// Every seed and regression of a target.
    fn all(target: &str, seeds: &[&str], body: fn(&[u8])) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let own = [format!("fuzz/seeds/{target}"), format!("fuzz/regressions/{target}")];
        let mut tried = 0;
        for directory in own.iter().map(String::as_str).chain(seeds.iter().copied()) {
            // A target that has found nothing yet has no directory of finds.
            for entry in fs::read_dir(root.join(directory)).into_iter().flatten() {
                let path = entry.unwrap().path();
                if path.is_file() {
                    body(&fs::read(path).unwrap());
                    tried += 1;
                }
            }
        }
        assert!(tried > 0);
    }

    #[test]
    fn decks() {
        all("deck", &["decks", "verify/faults/deck"], super::deck);
    }

    #[test]
    fn scenes_in_toml() {
        all("toml_scene", &["verify/faults/toml"], super::toml_scene);
    }

    #[test]
    fn scenes_in_json() {
        all("json_scene", &["verify/faults/json"], super::json_scene);
    }

    #[test]
    fn states_as_csv() {
        all("csv_states", &["verify/faults/states"], super::csv_states);
    }

    #[test]
    fn states_as_json() {
        all("json_states", &["verify/faults/states"], super::json_states);
    }
}
