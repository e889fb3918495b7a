//! What bears on a connector or constraint only where one uses it: it is skipped and counted elsewhere, and an error there.

use crate::deck::lookup::target;
use crate::deck::{Deck, constraint};
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::label::Label;
use crate::label::labelled::LabelSet;
use crate::label::normal;
use crate::lexer::Keyword;
use crate::model::{Application, Scene, Target};
use crate::span::{Span, Spanned};
use indexmap::IndexMap;

/// What was passed over, until it is known whether something uses it.
#[derive(Debug, Default)]
pub(super) struct Unread {
    lines: Vec<OnNodes>,
    /// Amplitudes by name: where they are, and why they are not read.
    amplitudes: IndexMap<String, (Span, String)>,
    changes: Vec<Change>,
    /// What moves nodes or takes them from elsewhere.
    warnings: Vec<Diagnostic>,
    /// The model is in another deck.
    pub(super) is_elsewhere: bool,
}

/// Lines of one keyword that name nodes.
#[derive(Debug)]
struct OnNodes {
    what: String,
    targets: Vec<Spanned<Target>>,
    remedy: String,
}

/// Elements that `*MODEL CHANGE` removes or adds.
#[derive(Debug)]
struct Change {
    is_removal: bool,
    targets: Vec<Spanned<Target>>,
}

/// Passes over the lines of a keyword that has a parameter which is not known; each begins with a node or set.
pub(super) fn lines_on_nodes(deck: &mut Deck<'_>, keyword: &Keyword, parameter: &str) -> Result<()> {
    let mut targets = Vec::new();
    while let Some(line) = deck.lexer.row()? {
        targets.extend(line.items().maybe().map(|item| target(&item, "the node number")).transpose()?);
    }
    let what = format!("*{}, {parameter}", keyword.name);
    let remedy = format!("write it without {parameter}, with what it stands for on the data lines");
    deck.unread.lines.push(OnNodes { what, targets, remedy });
    Ok(())
}

/// `*NMAP`: nodes go elsewhere.
pub(super) fn mapping(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let set = keyword.need_name("NSET")?;
    let lines = deck.lexer.skip()?;
    deck.count_skipped(keyword, lines);
    let targets = vec![Spanned::new(Target::Set(set.value), set.span)];
    let remedy = "list the nodes under *NODE, at their final positions".to_owned();
    deck.unread.lines.push(OnNodes { what: "*NMAP".to_owned(), targets, remedy });
    Ok(())
}

/// `*PARAMETER`: names for numbers. What is no plain arithmetic leaves its name standing, which is an error where a number is read.
pub(super) fn parameter(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let mut others = 0;
    while let Some(line) = deck.lexer.text()? {
        others += u64::from(!deck.lexer.parameters.define(&line));
    }
    if others > 0 || !keyword.parameters.is_empty() {
        deck.count_skipped(keyword, others);
    }
    Ok(())
}

/// An amplitude whose values are not in the deck.
pub(super) fn amplitude(deck: &mut Deck<'_>, keyword: &Keyword, why: &str) -> Result<()> {
    let name = keyword.need_name("NAME")?;
    deck.lexer.skip()?;
    deck.scene.skipped.count(format!("*AMPLITUDE, {why}"), keyword.span.line());
    deck.unread.amplitudes.insert(name.value, (keyword.span, why.to_owned()));
    Ok(())
}

/// `*MODEL CHANGE`; the number of its lines.
pub(super) fn model_change(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<u64> {
    let (mut targets, mut lines) = (Vec::new(), 0);
    let is_of_elements = keyword.get("TYPE").is_none_or(|value| normal(value.text()) == "ELEMENT");
    while let Some(line) = deck.lexer.row()? {
        lines += 1;
        for item in line.items().filter(|item| is_of_elements && !item.text.is_empty()) {
            targets.extend(target(&item, "the element number").ok());
        }
    }
    deck.unread.changes.push(Change { is_removal: keyword.has("REMOVE"), targets });
    Ok(lines)
}

/// `*IMPERFECTION`, `*IMPORT` and `*RESTART, READ`: nodes, or all of the model, come from elsewhere.
pub(super) fn elsewhere(deck: &mut Deck<'_>, keyword: &Keyword) {
    let (message, label, remedy) = match keyword.name.as_str() {
        "RESTART" if !keyword.has("READ") => return,
        "IMPERFECTION" => (
            "*IMPERFECTION moves nodes, and is not read: connectors are where *NODE puts them",
            "moves nodes",
            "list the nodes under *NODE, at their final positions, if that matters",
        ),
        _ => (
            "the model is in another deck, from which this one goes on; what stands here is read alone",
            "goes on from another deck",
            "read the deck of the model",
        ),
    };
    let warning = Diagnostic::warning(Code::NotFollowed, keyword.span, message, label).help(remedy);
    deck.unread.is_elsewhere |= keyword.name != "IMPERFECTION";
    deck.unread.warnings.push(warning);
}

/// Whatever a target names of the members of `among`.
fn named<'a>(scene: &'a Scene, target: &'a Target, among: impl Fn(&Label) -> bool) -> Option<&'a Label> {
    match target {
        Target::Label(label) => Some(label).filter(|label| among(label)),
        Target::Set(name) => {
            scene.node_sets.get(name).into_iter().flat_map(|set| &set.labels).find(|label| among(label))
        }
    }
}

/// The nodes of connectors and constraints.
pub(super) fn bearing(scene: &Scene) -> LabelSet {
    let of_mpcs = scene.mpcs.iter().flat_map(|mpc| &mpc.nodes).copied();
    ends(scene).chain(of_mpcs).chain(constraint::nodes(scene)).collect()
}

fn ends(scene: &Scene) -> impl Iterator<Item = Label> + '_ {
    scene.connectors.values().flat_map(|element| [element.a, element.b]).flatten()
}

/// Tells which of what was passed over bears on connectors and constraints. The sets and constraints must be resolved.
pub(super) fn judge(deck: &mut Deck<'_>, bearing: &LabelSet) {
    let Unread { lines, amplitudes, changes, warnings, is_elsewhere } = std::mem::take(&mut deck.unread);
    deck.unread.is_elsewhere = is_elsewhere;
    let scene = &mut deck.scene;
    let ends: LabelSet = ends(scene).collect();
    for OnNodes { what, targets, remedy } in lines {
        // Equations also join nodes of a network of fluids, whose degree of freedom 1 is no displacement.
        let bearing = if what.ends_with("MASS FLOW") { &ends } else { bearing };
        for target in targets {
            if let Some(label) = named(scene, &target.value, |label| bearing.contains(label)) {
                let message =
                    format!("{what} acts on node {label} of a connector or constraint, and is not read");
                let error = Diagnostic::error(Code::UnsupportedKeyword, target.span, message, "not read");
                deck.errors.add(error.help(&remedy));
            }
        }
    }
    if !amplitudes.is_empty() {
        drop_unread(deck, &amplitudes, bearing);
    }
    if !bearing.is_empty() || is_elsewhere {
        warnings.into_iter().for_each(|warning| deck.warn(warning));
    }
    for Change { is_removal, targets } in changes {
        for target in targets {
            let scene = &deck.scene;
            let among = |label: &&Label| scene.connectors.contains_key(*label);
            let found = match &target.value {
                Target::Label(label) => Some(label).filter(among),
                Target::Set(name) => {
                    scene.element_sets.get(name).into_iter().flat_map(|set| &set.labels).find(among)
                }
            };
            let Some(label) = found else { continue };
            let does = if is_removal { "removes" } else { "adds" };
            let message =
                format!("*MODEL CHANGE {does} connector {label}, which is evaluated in every state");
            let warning = Diagnostic::warning(Code::NotFollowed, target.span, message, "not followed")
                .help("evaluate the steps before and after apart, with --connector");
            deck.warn(warning);
        }
    }
}

/// Takes out what acts on a model that another deck has, and counts it.
pub(super) fn drop_steps(deck: &mut Deck<'_>) {
    let Scene { steps, boundaries, initial_velocities, skipped, .. } = &mut deck.scene;
    let mut drop = |count: usize, line: u32| {
        for _ in 0..count {
            skipped.count("what acts on the model of another deck".to_owned(), line);
        }
    };
    drop(std::mem::take(boundaries).len(), 0);
    drop(std::mem::take(initial_velocities).len(), 0);
    for step in steps {
        let line = step.span.line();
        drop(std::mem::take(&mut step.boundaries).len(), line);
        drop(std::mem::take(&mut step.concentrated_loads).len(), line);
        drop(std::mem::take(&mut step.distributed_loads).len(), line);
        drop(std::mem::take(&mut step.outputs).len(), line);
    }
}

/// Takes out what an amplitude scales that is not read, and counts it; an error where it acts on a connector or constraint.
fn drop_unread(deck: &mut Deck<'_>, amplitudes: &IndexMap<String, (Span, String)>, bearing: &LabelSet) {
    let Scene { steps, boundaries, connector_motions, node_sets, skipped, .. } = &mut deck.scene;
    let mut errors = Vec::new();
    let mut goes = |applied: &Application, what: &str, nodes: Option<&Target>| {
        let Some(name) = &applied.amplitude else { return false };
        let Some((place, why)) = amplitudes.get(&name.value) else { return false };
        let is_bearing = |label: &Label| bearing.contains(label);
        let bears = match nodes {
            None => true,
            Some(Target::Label(label)) => is_bearing(label),
            Some(Target::Set(set)) => node_sets.get(set).is_some_and(|set| set.labels.iter().any(is_bearing)),
        };
        if bears {
            let message =
                format!("amplitude {} of line {} is {why}, which is not read", name.value, place.line());
            let error =
                Diagnostic::error(Code::UnknownAmplitude, name.span, message, "its values are not known");
            errors.push(error.help("write the values as time, value, time, value … under *AMPLITUDE"));
        } else {
            skipped.count(format!("{what} with an amplitude that is not read"), name.span.line());
        }
        true
    };
    connector_motions.retain(|motion| !goes(&motion.applied, "*CONNECTOR MOTION", None));
    boundaries.retain(|held| !goes(&held.applied, "*BOUNDARY", Some(&held.target.value)));
    for step in steps {
        step.connector_motions.retain(|motion| !goes(&motion.applied, "*CONNECTOR MOTION", None));
        step.connector_loads.retain(|load| !goes(&load.applied, "*CONNECTOR LOAD", None));
        step.boundaries.retain(|held| !goes(&held.applied, "*BOUNDARY", Some(&held.target.value)));
        step.concentrated_loads.retain(|load| !goes(&load.applied, "*CLOAD", Some(&load.target.value)));
        let nowhere = Target::Set(String::new());
        step.distributed_loads.retain(|load| !goes(&load.applied, "*DLOAD", Some(&nowhere)));
    }
    errors.into_iter().for_each(|error| deck.errors.add(error));
}
