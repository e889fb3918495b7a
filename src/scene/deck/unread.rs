//! What bears on a connector or constraint only where one uses it: it is skipped and counted elsewhere. There it is an error, or the warning
//! `deck::not-followed` where only what acts on it is not read.

use crate::deck::errors::Errors;
use crate::deck::lookup::target;
use crate::deck::sets::Kind;
use crate::deck::{Deck, constraint};
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::label::Label;
use crate::label::labelled::LabelSet;
use crate::label::normal;
use crate::lexer::Keyword;
use crate::model::{Application, Scene, SkippedConstraint, Target};
use crate::span::{Span, Spanned};
use indexmap::IndexMap;
use std::collections::HashSet;

/// What was passed over, until it is known whether something uses it.
#[derive(Debug, Default)]
pub(super) struct Unread {
    lines: Vec<OnNodes>,
    /// Amplitudes by name: where they are, and why they are not read.
    amplitudes: IndexMap<String, (Span, Why)>,
    /// Lines that cannot be read, each with what it bears on.
    faults: Vec<(Bears, Diagnostic)>,
    /// There is a connector or a constraint, or a keyword that is meant for one.
    pub(super) any_bears: bool,
    changes: Vec<Change>,
    /// What moves nodes, these or any, or takes them from elsewhere.
    warnings: Vec<(Option<Vec<Spanned<Target>>>, Diagnostic)>,
    /// Sets of connectors that are generated.
    pub(super) fasteners: Vec<String>,
    /// Nodes that are defined again, at another place.
    pub(super) redefined: Vec<Redefined>,
    /// The model is in another deck.
    pub(super) is_elsewhere: bool,
    /// Nodes whose lines cannot be read, and that no connector or constraint has.
    pub(super) nodes: LabelSet,
}

/// Lines of one keyword that name nodes.
#[derive(Debug)]
struct OnNodes {
    what: String,
    targets: Vec<Spanned<Target>>,
    remedy: String,
    /// Without them the model is another one, or only what acts on it.
    moves_nodes: bool,
    /// They hold what they act on.
    holds: bool,
    /// They may act on nodes of a network of fluids.
    is_mass_flow: bool,
}

/// Why an amplitude is not read.
#[derive(Debug)]
enum Why {
    /// Its values are elsewhere.
    Elsewhere(String),
    /// Its lines are faulty.
    Faulty(Diagnostic),
}

/// What a line that cannot be read bears on.
#[derive(Debug)]
pub(super) enum Bears {
    /// No connector and no constraint.
    Nothing,
    /// These nodes.
    Nodes(Spanned<Target>),
    /// The nodes of the elements of a set.
    Elements(String),
    /// The nodes of a set.
    NodeSet(String),
    /// What uses an orientation.
    Orientation(String),
    /// What uses a set.
    Set(Kind, String),
}

/// What an error of a keyword bears on, if that can be told; the faulty line was read last.
pub(super) fn bears(deck: &mut Deck<'_>, rule: &str, keyword: &Keyword, error: &Diagnostic) -> Option<Bears> {
    if deck.assembly.is_open() || !error.further().is_empty() {
        return None;
    }
    let set = |parameter| Some(keyword.name_of(parameter).ok()??.value);
    match rule {
        "NODE" => {
            deck.lexer.again();
            let line = deck.lexer.row().ok()??;
            let first = line.items().maybe()?;
            let label = first.label_number("the node number").ok()?;
            Some(Bears::Nodes(Spanned::new(Target::Label(label.into()), first.span)))
        }
        "BOUNDARY" | "CLOAD" | "INITIAL CONDITIONS" => {
            deck.lexer.again();
            let line = deck.lexer.row().ok()??;
            let first = line.items().maybe()?;
            target(&first, "the node number").ok().map(Bears::Nodes)
        }
        "DLOAD" => {
            deck.lexer.again();
            let line = deck.lexer.row().ok()??;
            let is_gravity = line.items().nth(1).is_some_and(|item| normal(item.text) == "GRAV");
            (!is_gravity).then_some(Bears::Nothing)
        }
        "MASS" | "ROTARY INERTIA" | "SPRING" | "DASHPOT" => set("ELSET").map(Bears::Elements),
        "NSET" => set("NSET").map(|name| Bears::Set(Kind::Node, name)),
        "ELSET" => set("ELSET").map(|name| Bears::Set(Kind::Element, name)),
        "TRANSFORM" => set("NSET").map(Bears::NodeSet),
        "ORIENTATION" => set("NAME").map(Bears::Orientation),
        _ => None,
    }
}

/// A node that is defined twice.
#[derive(Debug)]
pub(super) struct Redefined {
    pub(super) label: Label,
    pub(super) first: Span,
    pub(super) again: Span,
}

impl Redefined {
    /// That it is at two places.
    pub(super) fn error(&self) -> Diagnostic {
        let message = format!("node {} is defined twice, at different places", self.label);
        let label = format!("first defined on line {}", self.first.line());
        Diagnostic::error(Code::DuplicateNode, self.again, message, label)
            .beside(self.first)
            .help("give one of the two another number")
    }
}

/// Elements that `*MODEL CHANGE` removes or adds.
#[derive(Debug)]
struct Change {
    is_removal: bool,
    targets: Vec<Spanned<Target>>,
}

impl Unread {
    /// Notes a warning that matters if these are nodes of connectors or constraints.
    pub(super) fn warn_of(&mut self, targets: Vec<Spanned<Target>>, warning: Diagnostic) {
        self.warnings.push((Some(targets), warning));
    }

    /// What it acts on, or would.
    pub(super) fn targets(&self) -> impl Iterator<Item = &Spanned<Target>> {
        let lines = self.lines.iter().flat_map(|line| &line.targets);
        let warned = self.warnings.iter().filter_map(|(targets, _)| targets.as_ref()).flatten();
        let faults = self.faults.iter().filter_map(|(bears, _)| match bears {
            Bears::Nodes(target) => Some(target),
            _ => None,
        });
        lines.chain(warned).chain(faults)
    }

    /// The node sets of lines that cannot be read.
    pub(super) fn node_sets(&self) -> impl Iterator<Item = &str> {
        self.faults.iter().filter_map(|(bears, _)| match bears {
            Bears::NodeSet(name) => Some(name.as_str()),
            _ => None,
        })
    }

    /// The element sets of lines that cannot be read, and of what is removed or added.
    pub(super) fn element_sets(&self) -> impl Iterator<Item = &str> {
        let faults = self.faults.iter().filter_map(|(bears, _)| match bears {
            Bears::Elements(name) => Some(name.as_str()),
            _ => None,
        });
        let changed = self.changes.iter().flat_map(|change| &change.targets);
        faults.chain(changed.filter_map(|target| target.value.set()))
    }

    /// Notes a line that cannot be read.
    pub(super) fn fault(&mut self, bears: Bears, error: Diagnostic) {
        self.faults.push((bears, error));
    }
}

/// So many lines that cannot be read are kept until it is known what they bear on.
const MOST_FAULTS: usize = 10_000;

/// Notes a line that cannot be read with what it bears on: a set keeps its own.
pub(super) fn note(deck: &mut Deck<'_>, bears: Bears, error: Diagnostic) {
    let builders = match bears {
        Bears::Set(Kind::Node, _) => &mut deck.node_sets,
        _ => &mut deck.element_sets,
    };
    match &bears {
        Bears::Set(_, name) if let Some(set) = builders.get_mut(name) => set.push_fault(error),
        _ if deck.unread.faults.len() < MOST_FAULTS => deck.unread.fault(bears, error),
        _ => deck.errors.add(error),
    }
}

/// Before references are resolved: what makes nodes and orientations that connectors and constraints use is an error where it cannot be read.
pub(super) fn judge_definitions(deck: &mut Deck<'_>, errors: &mut Errors) {
    let scene = &deck.scene;
    let discrete = scene.springs.iter().chain(&scene.dashpots).map(|discrete| &discrete.orientation);
    let inertias = scene.rotary_inertias.iter().map(|inertia| &inertia.orientation);
    let sections = scene.connector_sections.iter();
    let sections = sections.flat_map(|section| [&section.orientation_a, &section.orientation_b]);
    let of_scene = discrete.chain(inertias).chain(sections).flatten().map(|name| name.value.as_str());
    let used: HashSet<&str> = of_scene.chain(deck.constraints.orientations()).collect();
    let is_used = |bears: &Bears| matches!(bears, Bears::Orientation(name) if used.contains(name.as_str()));
    // Which nodes a set of a constraint has cannot be told while one of them is not known.
    let has_sets = !deck.mpcs.is_empty() || !deck.constraints.is_empty();
    let ends: LabelSet = ends(scene).chain(points(scene)).collect();
    let is_end = |bears: &Bears| match bears {
        Bears::Nodes(Spanned { value: Target::Label(label), .. }) => {
            !scene.nodes.contains_key(label) && (has_sets || ends.contains(label))
        }
        _ => false,
    };
    let faults = std::mem::take(&mut deck.unread.faults);
    for (bears, error) in faults {
        if is_used(&bears) || is_end(&bears) {
            errors.add(error);
            match bears {
                Bears::Nodes(Spanned { value: Target::Label(label), .. }) => errors.lose(label),
                _ => errors.spoil("ORIENTATION"),
            }
        } else {
            deck.unread.faults.push((bears, error));
        }
    }
}

/// Passes over the lines of a keyword that has a parameter which is not known; each begins with a node or set.
pub(super) fn lines_on_nodes(deck: &mut Deck<'_>, keyword: &Keyword, parameter: &str) -> Result<()> {
    let mut targets = Vec::new();
    while let Some(line) = deck.lexer.row()? {
        targets.extend(line.items().maybe().map(|item| target(&item, "the node number")).transpose()?);
    }
    let what = format!("*{}, {parameter}", keyword.name);
    let remedy = format!("write it without {parameter}, with what it stands for on the data lines");
    let (holds, is_mass_flow) = (keyword.name == "BOUNDARY", parameter == "MASS FLOW");
    deck.unread.lines.push(OnNodes { what, targets, remedy, moves_nodes: false, holds, is_mass_flow });
    Ok(())
}

/// `*NMAP`: nodes go elsewhere.
pub(super) fn mapping(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let set = keyword.need_name("NSET")?;
    let lines = deck.lexer.skip()?;
    deck.count_skipped(keyword, lines);
    let targets = vec![Spanned::new(Target::Set(set.value), set.span)];
    let remedy = "list the nodes under *NODE, at their final positions".to_owned();
    let (what, holds, is_mass_flow) = ("*NMAP".to_owned(), false, false);
    deck.unread.lines.push(OnNodes { what, targets, remedy, moves_nodes: true, holds, is_mass_flow });
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
    deck.unread.amplitudes.insert(name.value, (keyword.span, Why::Elsewhere(why.to_owned())));
    Ok(())
}

/// An amplitude whose lines are faulty, which is an error where it acts on a connector or constraint.
pub(super) fn faulty_amplitude(deck: &mut Deck<'_>, name: String, place: Span, error: Diagnostic) {
    deck.unread.amplitudes.insert(name, (place, Why::Faulty(error)));
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

/// `*IMPORT`, `*RESTART, READ` and `*INSTANCE, LIBRARY`: the model, or a part of it, is in another deck.
pub(super) fn elsewhere(deck: &mut Deck<'_>, keyword: &Keyword) {
    if keyword.name == "RESTART" && !keyword.has("READ") {
        return;
    }
    let message = "the model is in another deck, from which this one goes on; what stands here is read alone";
    let label = "goes on from another deck";
    let warning = Diagnostic::warning(Code::NotFollowed, keyword.span, message, label);
    deck.unread.is_elsewhere = true;
    deck.unread.warnings.push((None, warning.help("read the deck of the model")));
}

/// `*IMPERFECTION`: nodes are elsewhere, those that its lines name or any. The number of its lines.
pub(super) fn imperfection(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<u64> {
    let is_of_lines = ["FILE", "INPUT", "SYSTEM"].iter().all(|parameter| !keyword.has(parameter));
    let (mut targets, mut lines) = (Vec::new(), 0);
    while let Some(line) = deck.lexer.row()? {
        lines += 1;
        let first = line.items().maybe().map(|item| target(&item, "the node number")).transpose();
        targets.extend(first.ok().flatten());
    }
    let message = "*IMPERFECTION moves nodes, and is not read: connectors are where *NODE puts them";
    let warning = Diagnostic::warning(Code::NotFollowed, keyword.span, message, "moves nodes")
        .help("list the nodes under *NODE, at their final positions, if that matters");
    deck.unread.warnings.push((is_of_lines.then_some(targets), warning));
    Ok(lines)
}

/// `*FASTENER` generates the connectors of its set, which is empty in the deck.
pub(super) fn fastener(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let set = keyword.name_of("ELSET")?;
    deck.unread.fasteners.extend(set.map(|set| set.value));
    Ok(())
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

/// Whether what acts on a node or set acts on one of these.
pub(super) fn acts_on(scene: &Scene, target: &Target, bearing: &LabelSet) -> bool {
    named(scene, target, |label| bearing.contains(label)).is_some()
}

/// The nodes of connectors and constraints, their reference nodes too, and of what stands beside them: masses, springs and dashpots.
pub(super) fn bearing(scene: &Scene) -> LabelSet {
    let of_mpcs = scene.mpcs.iter().flat_map(|mpc| &mpc.nodes).copied();
    let references = scene.rigid_bodies.iter().map(|body| body.reference);
    let references = references.chain(scene.couplings.iter().map(|coupling| coupling.reference));
    ends(scene)
        .chain(of_mpcs)
        .chain(constraint::nodes(scene))
        .chain(references)
        .chain(points(scene))
        .collect()
}

/// The nodes of masses, springs and dashpots.
fn points(scene: &Scene) -> impl Iterator<Item = Label> + '_ {
    scene.point_elements.values().flat_map(|element| [Some(element.node), element.second]).flatten()
}

pub(super) fn ends(scene: &Scene) -> impl Iterator<Item = Label> + '_ {
    scene.connectors.values().flat_map(|element| [element.a, element.b]).flatten()
}

/// Tells which of what was passed over bears on connectors and constraints. The sets and constraints must be resolved.
pub(super) fn judge(deck: &mut Deck<'_>, bearing: &LabelSet) {
    let Unread { lines, amplitudes, changes, warnings, is_elsewhere, redefined, faults, any_bears, .. } =
        std::mem::take(&mut deck.unread);
    (deck.unread.is_elsewhere, deck.unread.any_bears) = (is_elsewhere, any_bears);
    for (bears, error) in faults {
        let found = match &bears {
            Bears::Nothing | Bears::Orientation(_) | Bears::Set(..) => false,
            Bears::Nodes(target) => {
                let is_known = match &target.value {
                    // A node that is used has been judged with the definitions.
                    Target::Label(_) => true,
                    Target::Set(name) => deck.scene.node_sets.contains_key(name),
                };
                !is_known || acts_on(&deck.scene, &target.value, bearing)
            }
            Bears::NodeSet(name) => {
                !deck.scene.node_sets.contains_key(name)
                    || acts_on(&deck.scene, &Target::Set(name.clone()), bearing)
            }
            // All masses, springs and dashpots bear.
            Bears::Elements(name) => deck.scene.element_sets.get(name).is_none_or(|set| {
                set.labels.iter().any(|label| deck.scene.point_elements.contains_key(label))
            }),
        };
        if found {
            deck.errors.add(error);
        } else {
            if let Bears::Nodes(Spanned { value: Target::Label(label), .. }) = bears
                && !deck.scene.nodes.contains_key(&label)
            {
                deck.unread.nodes.insert(label);
            }
            deck.scene.skipped.count("lines that cannot be read".to_owned(), error.span().line());
            deck.excuse(error);
        }
    }
    for node in redefined {
        if bearing.contains(&node.label) {
            deck.errors.add(node.error());
        } else {
            let what = "nodes defined again: the last place counts".to_owned();
            deck.scene.skipped.count(what, node.again.line());
        }
    }
    let scene = &deck.scene;
    let ends: LabelSet = ends(scene).collect();
    let mut not_followed = Vec::new();
    for OnNodes { what, targets, remedy, moves_nodes, holds, is_mass_flow } in lines {
        // Equations also join nodes of a network of fluids, whose degree of freedom 1 is no displacement.
        let bearing = if is_mass_flow { &ends } else { bearing };
        for target in targets {
            if let Some(label) = named(scene, &target.value, |label| bearing.contains(label)) {
                let message =
                    format!("{what} acts on node {label} of a connector or constraint, and is not read");
                if moves_nodes {
                    let error = Diagnostic::error(Code::UnsupportedKeyword, target.span, message, "not read");
                    deck.errors.add(error.help(remedy.as_str()));
                } else {
                    let warning = Diagnostic::warning(Code::NotFollowed, target.span, message, "not read");
                    not_followed.push((holds, warning.help(remedy.as_str())));
                }
            }
        }
    }
    for (holds, warning) in not_followed {
        if holds {
            let constraint = SkippedConstraint { keyword: "BOUNDARY", span: warning.span() };
            deck.scene.skipped.constraints.push(constraint);
        }
        deck.warn(warning);
    }
    if !amplitudes.is_empty() {
        drop_unread(deck, &amplitudes, bearing);
    }
    for (targets, warning) in warnings {
        let bears = match targets {
            None => !bearing.is_empty() || is_elsewhere,
            Some(targets) => targets.iter().any(|target| acts_on(&deck.scene, &target.value, bearing)),
        };
        if bears {
            deck.warn(warning);
        }
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

/// Takes out what acts on a model that another deck has, and counts it: on nodes, elements and sets that are not here.
pub(super) fn drop_steps(deck: &mut Deck<'_>) {
    let others = &deck.other_elements;
    let Scene {
        steps,
        boundaries,
        initial_velocities,
        connector_motions,
        skipped,
        nodes,
        node_sets,
        connectors,
        point_elements: points,
        element_sets,
        ..
    } = &mut deck.scene;
    let (nodes, node_sets, element_sets) = (&*nodes, &*node_sets, &*element_sets);
    let (connectors, points) = (&*connectors, &*points);
    let is_node = |target: &Target| match target {
        Target::Label(label) => nodes.contains_key(label),
        Target::Set(name) => node_sets.contains_key(name),
    };
    let is_element = |target: &Target| match target {
        Target::Label(label) => {
            connectors.contains_key(label) || points.contains_key(label) || others.contains(*label)
        }
        Target::Set(name) => element_sets.contains_key(name),
    };
    let mut keeps = |is_here: bool, line: u32| {
        if !is_here {
            skipped.count("what acts on the model of another deck".to_owned(), line);
        }
        is_here
    };
    boundaries.retain(|held| keeps(is_node(&held.target.value), held.target.span.line()));
    initial_velocities.retain(|given| keeps(is_node(&given.target.value), given.target.span.line()));
    connector_motions.retain(|motion| keeps(is_element(&motion.target.value), motion.target.span.line()));
    for step in steps {
        let line = step.span.line();
        step.boundaries.retain(|held| keeps(is_node(&held.target.value), held.target.span.line()));
        step.concentrated_loads.retain(|load| keeps(is_node(&load.target.value), load.target.span.line()));
        step.connector_motions
            .retain(|motion| keeps(is_element(&motion.target.value), motion.target.span.line()));
        step.connector_loads.retain(|load| keeps(is_element(&load.target.value), load.target.span.line()));
        step.distributed_loads
            .retain(|load| keeps(load.target.as_ref().is_none_or(|target| is_element(&target.value)), line));
        step.outputs.retain(|request| {
            let elements =
                request.element_set.as_ref().is_none_or(|set| element_sets.contains_key(&set.value));
            let nodes = request.node_set.as_ref().is_none_or(|set| node_sets.contains_key(&set.value));
            keeps(elements && nodes, line)
        });
    }
}

/// Takes out what an amplitude scales that is not read, and counts it; an error where it acts on a connector or constraint.
fn drop_unread(deck: &mut Deck<'_>, amplitudes: &IndexMap<String, (Span, Why)>, bearing: &LabelSet) {
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
        if let (true, Why::Faulty(error)) = (bears, why) {
            errors.push(error.clone());
        } else if let (true, Why::Elsewhere(why)) = (bears, why) {
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
        step.distributed_loads.retain(|load| {
            !goes(&load.applied, "*DLOAD", if load.is_gravity() { None } else { Some(&nowhere) })
        });
    }
    let is_used = |fault: &Diagnostic| errors.iter().any(|error| error.span() == fault.span());
    let unused = amplitudes.values().filter_map(|(_, why)| match why {
        Why::Faulty(error) if !is_used(error) => Some(error.clone()),
        _ => None,
    });
    unused.for_each(|error| deck.excuse(error));
    errors.into_iter().for_each(|error| deck.errors.add(error));
}
