//! Scenes in TOML and JSON.
//!
//! Both are read into one tree of values with places ([`tree`]), and from it into the types of [`form`], which are
//! also what the JSON Schema is made from. A document then stands for a deck ([`crate::deck::write`]), whose lines
//! know their places in the document: the reader of decks checks it, and says where it is at fault.

pub(super) mod de;
pub(super) mod form;
mod tree;
mod value;
mod write;

use crate::deck;
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::include::{Named, NoFiles};
use crate::label::Label;
use crate::model::{Scene, Skipped};
use crate::span::{Span, Spanned};
use crate::states;
use form::{Document, SCHEMA};
use std::io::Read;
use std::path::Path;

pub use write::Converted;

/// How a scene is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// A deck of keywords and data lines (.inp).
    Deck,
    /// TOML (.toml).
    Toml,
    /// JSON (.json).
    Json,
}

impl Format {
    /// The format that the ending of a file name stands for: `.toml`, `.json`, and for any other a deck.
    #[must_use]
    pub fn of_path(path: &Path) -> Self {
        let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
        match ending.as_ref().and_then(|ending| ending.to_str()) {
            Some("toml") => Self::Toml,
            Some("json") => Self::Json,
            _ => Self::Deck,
        }
    }
}

impl Diagnostic {
    /// The same, in the file of a scene that its place is in, and in the words of its format.
    #[must_use]
    pub fn in_scene(self, scene: &Scene) -> Self {
        let file = scene.files.get(usize::from(self.span().file()));
        let diagnostic = self.in_file(file.unwrap_or(&scene.name));
        match Format::of_path(Path::new(&scene.name)) {
            Format::Deck => diagnostic,
            Format::Toml | Format::Json => diagnostic.of_document(),
        }
    }
}

/// The largest document that is read, in bytes.
pub const MAX_DOCUMENT: u64 = 1 << 28;

const BYTE_ORDER_MARK: char = '\u{feff}';

/// The JSON Schema of scenes in TOML and JSON, as text: what [`Scene::parse_toml`] and [`Scene::parse_json`] read.
pub const SCHEMA_TEXT: &str = include_str!("../../../schema/pintle-scene-1.json");

/// The JSON Schema that the types give; [`SCHEMA_TEXT`] is its copy.
#[cfg(feature = "schema")]
#[must_use]
pub fn schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(Document);
    schema.insert("title".to_owned(), "pintle scene".into());
    schema.insert("$id".to_owned(), SCHEMA.into());
    schema.to_value()
}

impl Scene {
    /// Reads a scene from TOML. `name` stands for the file in messages.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a remedy.
    pub fn parse_toml(name: &str, text: &str) -> Result<Self> {
        parse(name, text, Format::Toml)
    }

    /// Reads a scene from JSON. `name` stands for the file in messages.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a remedy.
    pub fn parse_json(name: &str, text: &str) -> Result<Self> {
        parse(name, text, Format::Json)
    }
}

/// Reads a file of TOML or JSON.
pub(super) fn read(path: &Path, format: Format) -> Result<Scene> {
    let name = path.display().to_string();
    let unreadable = |message: String, remedy: &str| {
        Diagnostic::error(Code::Unreadable, Span::default(), message, "").help(remedy).in_file(&name)
    };
    let remedy = "check the path and its permissions";
    let file = std::fs::File::open(path)
        .map_err(|error| unreadable(format!("cannot be opened: {error}"), remedy))?;
    let mut bytes = Vec::new();
    file.take(MAX_DOCUMENT + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| unreadable(format!("cannot be read: {error}"), remedy))?;
    if bytes.len() as u64 > MAX_DOCUMENT {
        let message = format!("a document of more than {MAX_DOCUMENT} bytes");
        return Err(unreadable(message, "write a scene of this size as a deck (.inp)"));
    }
    match String::from_utf8(bytes) {
        Ok(text) => parse(&name, &text, format),
        Err(error) => {
            let place = error.utf8_error().valid_up_to();
            let bytes = error.into_bytes();
            let line = bytes.iter().take(place).filter(|byte| **byte == b'\n').count() + 1;
            let span = Span::new(0, u32::try_from(line).unwrap_or(u32::MAX), place as u64, 1);
            let mut errors = [Diagnostic::error(
                Code::NotUtf8,
                span,
                "bytes that are not UTF-8".to_owned(),
                "the first such byte",
            )
            .help("save the file as UTF-8")];
            Diagnostic::attach(&mut errors, &name, bytes.as_slice());
            let [error] = errors;
            Err(error)
        }
    }
}

fn parse(name: &str, text: &str, format: Format) -> Result<Scene> {
    let mut result = scene(name, text, format).map_err(Diagnostic::of_document);
    if let Ok(scene) = &mut result {
        let warnings = std::mem::take(&mut scene.warnings).into_iter();
        scene.warnings = warnings.map(Diagnostic::of_document).collect();
    }
    let source = Named { root: name, text: Some(text.as_bytes()), files: &NoFiles };
    let (scene, error) = result.map_or_else(|error| (Scene::default(), Some(error)), |scene| (scene, None));
    let (scene, error) = deck::finish((scene, error, vec![name.to_owned()]), &source);
    error.map_or(Ok(scene), Err)
}

fn scene(name: &str, text: &str, format: Format) -> Result<Scene> {
    let content = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    let lines = tree::Lines::of(content, text.len() - content.len());
    let mut errors = Vec::new();
    let mut tree = match format {
        Format::Toml => tree::of_toml(content, &lines)?,
        Format::Deck | Format::Json => tree::of_json(content, &lines, &mut errors)?,
    };
    let read: Option<Document> = de::read(&mut tree, &mut errors);
    let schema = read.as_ref().and_then(|document| document.schema.as_ref());
    errors.extend(schema.filter(|schema| schema.value != SCHEMA).map(|schema| {
        let message = format!("the schema is `{}`", schema.value.escape_debug());
        Diagnostic::error(Code::SceneUnknownSchema, schema.span, message, "not this one")
            .help(format!("write schema = \"{SCHEMA}\", or leave it out"))
    }));
    errors.sort_by_key(|error| error.span().start());
    let Some(mut document) = read.filter(|_| errors.is_empty()) else {
        return Err(Diagnostic::joined(errors).unwrap_or_else(deck::lost));
    };
    // What names the schema was written as a scene, and may be an empty one.
    if document.nodes.0.is_empty() && document.schema.is_none() {
        return Err(Diagnostic::error(Code::SceneMissingField, tree.span, "the scene has no nodes", "here")
            .help("give nodes, such as nodes.1 = [0, 0, 0]"));
    }
    let states = std::mem::take(&mut document.states);
    let (mut scene, error, _) = deck::of_document(name, &document);
    error.map_or(Ok(()), Err)?;
    name.clone_into(&mut scene.name);
    scene.axisymmetric = document.axisymmetric;
    scene.two_dimensional = document.two_dimensional.unwrap_or_else(|| scene.has_flat_connectors_alone());
    // What a document passes over stands in its warnings; the deck it stands for may name procedures without data.
    scene.skipped = Skipped::default();
    for node in &document.rotating_nodes {
        let label = node.value.to_string().parse::<Label>().ok();
        match label.filter(|label| scene.nodes.contains_key(label)) {
            Some(label) => {
                scene.rotating_nodes.insert(label);
            }
            None => {
                let message = format!("there is no node {}", node.value.to_string().escape_debug());
                errors.push(
                    Diagnostic::error(Code::UnknownNode, node.span, message, "not defined")
                        .help("name nodes of the scene"),
                );
            }
        }
    }
    let states = states.into_iter().map(|state| {
        let form::State { number, time, nodes, forces } = state.value;
        let forces = forces.0.into_iter().map(|(element, named)| (element, named.0)).collect();
        Spanned::new(states::Given { number, time, nodes: nodes.0, forces }, state.span)
    });
    match states::of_scene(states, &scene) {
        Ok(states) => scene.states = states,
        Err(error) => errors.push(error),
    }
    Diagnostic::joined(errors).map_or(Ok(scene), Err)
}
