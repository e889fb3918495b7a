//! `pintle convert` and `pintle schema`.

use super::eval;
use super::tell::complain;
use super::{Convert, Described, Failure, Files, SceneFormat};
use pintle_model::evaluate::Model;
use pintle_scene::{Diagnostic, Format, Scene, Severity, StateFile};
use std::io::{self, BufWriter, Write};
use std::path::Path;

impl From<SceneFormat> for Format {
    fn from(format: SceneFormat) -> Self {
        match format {
            SceneFormat::Inp => Self::Deck,
            SceneFormat::Toml => Self::Toml,
            SceneFormat::Json => Self::Json,
        }
    }
}

/// The format of the result: as asked for, or by the ending of its file.
fn format(arguments: &Convert) -> Result<Format, Failure> {
    if let Some(format) = arguments.to {
        return Ok(format.into());
    }
    let Some(output) = &arguments.output else {
        let message = "say what to convert to: --to inp, toml or json, or -o with a file of that ending";
        return Err(Failure::Usage(message.to_owned()));
    };
    let ending = output.extension().map(|ending| ending.to_ascii_lowercase());
    match ending.as_ref().and_then(|ending| ending.to_str()) {
        Some("inp" | "toml" | "json") => Ok(Format::of_path(output)),
        _ => {
            let message = format!("{} does not end in .inp, .toml or .json; give --to", output.display());
            Err(Failure::Usage(message))
        }
    }
}

/// `pintle convert`.
pub(crate) fn run(arguments: &Convert, files: Files) -> Result<(), Failure> {
    files.check(arguments.output.iter().chain(&arguments.save_states))?;
    let format = format(arguments)?;
    let source = eval::source(&arguments.scene)?;
    let (mut scene, states) = eval::read(source, arguments.states.as_deref())?;
    scene.states = states;
    // A scene that breaks a rule converts all the same, but not one whose directions are none.
    let (_, broken) = Model::examine(&scene);
    let wrong = scene.orientation_errors();
    let is_new = |rule: &Diagnostic| wrong.iter().all(|error| error.span() != rule.span());
    let broken: Vec<Diagnostic> = broken.into_iter().filter(is_new).collect();
    if let Some(error) = Diagnostic::joined(wrong) {
        return Err(broken.into_iter().map(|rule| source.quoted(rule)).fold(error, Diagnostic::and).into());
    }
    source.warn(&scene, &broken, |_| Some(Severity::Warning));
    // A deck has no states: what goes to a file of its own is not lost.
    let is_apart = format == Format::Deck && arguments.save_states.is_some();
    let states = if is_apart { std::mem::take(&mut scene.states) } else { Vec::new() };
    let converted = scene.write(format)?;
    if is_apart {
        scene.states = states;
    }
    const TOLD: usize = 20;
    for what in converted.dropped.iter().take(TOLD) {
        complain("dropped", what);
    }
    if let Some(more) = converted.dropped.len().checked_sub(TOLD).filter(|more| *more > 0) {
        complain("dropped", &format!("… and {more} more: `pintle eval` counts them"));
    }
    if arguments.strict && !converted.dropped.is_empty() {
        let count = converted.dropped.len();
        let things = if count == 1 { "one thing" } else { "several things" };
        let message = format!("{things} would be lost, and --strict forbids it; nothing was written");
        return Err(Failure::Lost(message));
    }
    if let Some(file) = &arguments.save_states {
        save_states(file, &scene, files)?;
    }
    match &arguments.output {
        None => {
            let mut out = BufWriter::new(io::stdout().lock());
            out.write_all(converted.text.as_bytes())?;
            Ok(out.flush()?)
        }
        Some(path) => files.text(path, &converted.text),
    }
}

fn save_states(file: &Path, scene: &Scene, files: Files) -> Result<(), Failure> {
    // What reads them goes by the ending.
    if !file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
        let message = format!(
            "states are saved as JSON, and {} would not be read as such: end its name in .json",
            file.display()
        );
        return Err(Failure::Usage(message));
    }
    if scene.states.is_empty() {
        return Err(Failure::Usage("the scene has no states to save".to_owned()));
    }
    let states = StateFile { states: scene.states.clone() };
    let text = states.to_json().map_err(io::Error::from)?;
    files.text(file, text + "\n")
}

/// `pintle schema`.
pub(crate) fn schema(of: Described) -> Result<(), Failure> {
    let text = match of {
        Described::Scene => pintle_scene::SCHEMA_TEXT,
        Described::Audit => pintle_report::audit::SCHEMA_TEXT,
    };
    Ok(io::stdout().lock().write_all(text.as_bytes())?)
}
