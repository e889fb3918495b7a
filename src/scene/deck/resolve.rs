//! References between the parts of a deck, once all of it is known.

use crate::behavior::{Behavior, FrictionKind, Potential, Source};
use crate::deck::Deck;
use crate::deck::connector::RawMpc;
use crate::deck::constraint;
use crate::deck::errors::Errors;
use crate::deck::faces::OtherElements;
use crate::deck::lookup::{
    check_name, check_orientation, complete_node_set, element_set, node_set, node_target, unknown,
};
use crate::deck::mesh::duplicate_element;
use crate::deck::sets;
use crate::deck::sets::{Kind, Known, Member, unknown_set};
use crate::deck::unread;
use crate::diagnostic::{Code, Diagnostic, Result, suggest};
use crate::label::Label;
use crate::label::labelled::{Beside, LabelMap, LabelSet};
use crate::model::{Application, ConnectorSection, Discrete, Mpc, PointKind, Scene, Set, Target};
use crate::span::Spanned;
use crate::wording::{definition, keyword};
use std::cell::OnceCell;
use std::collections::HashSet;

/// Checks every reference. What is wrong is added to the errors of the deck.
pub(super) fn resolve(deck: &mut Deck<'_>) {
    let mut errors = std::mem::take(&mut deck.errors);
    unread::judge_definitions(deck, &mut errors);
    elements(deck, &mut errors);
    let sets = build_sets(deck, &mut errors);
    errors.value(sets);
    sections(&mut deck.scene, &std::mem::take(&mut deck.unread.fasteners), &mut errors);
    for (name, behavior) in &deck.scene.behaviors {
        errors.value(check_behavior(name, behavior));
    }
    properties(&deck.scene, &mut errors);
    let raw = std::mem::take(&mut deck.mpcs);
    deck.scene.mpcs = mpcs(&deck.scene, &raw, &mut errors);
    constraint::resolve(deck, &mut errors);
    other_rotations(deck);
    let bearing = unread::bearing(&deck.scene);
    errors.value(transforms(&deck.scene, &bearing));
    deck.errors = errors;
    let (nodes, are_known) = deck.other_elements.nodes();
    let of_others = nodes.filter(|node| bearing.contains(node)).collect();
    deck.scene.skipped.nodes = are_known.then_some(of_others);
    unread::judge(deck, &bearing);
    if deck.unread.is_elsewhere {
        unread::drop_steps(deck);
    }
    let mut errors = std::mem::take(&mut deck.errors);
    let excused = actuation(deck, &bearing, &mut errors);
    deck.errors = errors;
    excused.into_iter().for_each(|error| deck.excuse(error));
    drop_conditions(deck);
}

/// What acts on a node whose line cannot be read acts on nothing.
fn drop_conditions(deck: &mut Deck<'_>) {
    let Deck { scene, unread, .. } = deck;
    let Scene { nodes, boundaries, initial_velocities, steps, skipped, .. } = scene;
    let mut is_kept = |target: &Spanned<Target>| match &target.value {
        Target::Label(label) if unread.nodes.contains(label) && !nodes.contains_key(label) => {
            skipped.count("conditions on nodes that cannot be read".to_owned(), target.span.line());
            false
        }
        _ => true,
    };
    boundaries.retain(|boundary| is_kept(&boundary.target));
    initial_velocities.retain(|velocity| is_kept(&velocity.target));
    for step in steps {
        step.boundaries.retain(|boundary| is_kept(&boundary.target));
        step.concentrated_loads.retain(|load| is_kept(&load.target));
    }
}

fn elements(deck: &mut Deck<'_>, errors: &mut Errors) {
    deck.other_elements.sort();
    let is_elsewhere = deck.unread.is_elsewhere;
    let scene = &deck.scene;
    let connectors =
        scene.connectors.iter().map(|(&label, element)| (label, element.span, [element.a, element.b]));
    let points = scene.point_elements.iter();
    let points = points.map(|(&label, element)| (label, element.span, [Some(element.node), element.second]));
    let known = Beside::new(&scene.nodes);
    for (label, span, nodes) in connectors.chain(points) {
        if deck.other_elements.contains(label) {
            errors.add(duplicate_element(label, None, span));
        }
        for node in nodes.into_iter().flatten() {
            if !known.contains(node) {
                let message = format!("element {label} uses node {node}, which is not defined");
                let elsewhere = || ["the model is in another deck: read that one"; 2].map(String::from);
                let remedy = if is_elsewhere { elsewhere() } else { Kind::Node.undefined() };
                let label = format!("no node {node}");
                errors.misses(node, Diagnostic::error(Code::UnknownNode, span, message, label).help(remedy));
            }
        }
    }
}

fn build_sets(deck: &mut Deck<'_>, errors: &mut Errors) -> Result<()> {
    let scene = &deck.scene;
    let mut warnings = Vec::new();
    let nodes = Beside::new(&scene.nodes);
    let node = |label| if nodes.contains(label) { Member::Modelled } else { Member::Unknown };
    let (connectors, points) = (Beside::new(&scene.connectors), Beside::new(&scene.point_elements));
    let element = |label| {
        if connectors.contains(label) || points.contains(label) {
            Member::Modelled
        } else if deck.other_elements.contains(label) {
            Member::Unmodelled
        } else {
            Member::Unknown
        }
    };
    let mut warn = |warning| warnings.push(warning);
    let (needed_nodes, needed_elements) = needed_sets(deck);
    let (named_nodes, named_elements) = named_sets(deck, &needed_nodes, &needed_elements);
    let elements = Known {
        member: &element,
        count: scene.connectors.len() + scene.point_elements.len(),
        labels: &|| scene.connectors.keys().chain(scene.point_elements.keys()).copied().collect(),
        sorted: OnceCell::new(),
        other: &deck.other_elements,
        needed: &|name| needed_elements.contains(name),
        named: &|name| named_elements.contains(name),
    };
    let element_sets =
        sets::resolve(Kind::Element, &deck.element_sets, &elements, &|_, _| Ok(()), &mut warn, errors)?;
    let nodes_of = |name: &Spanned<String>, set: &mut Set| {
        let Some(elements) = element_sets.get(&name.value) else {
            return Err(unknown_set(Kind::Element, name, element_sets.keys().map(String::as_str)));
        };
        for label in &elements.labels {
            let connector = scene.connectors.get(label).map(|element| [element.a, element.b]);
            let point = scene.point_elements.get(label).map(|element| [Some(element.node), element.second]);
            set.labels.extend(connector.or(point).into_iter().flatten().flatten());
        }
        let mut found = LabelSet::default();
        for element in elements.others.iter().flat_map(|range| deck.other_elements.within(*range)) {
            match element.filter(|element| element.nodes().all(|node| nodes.contains(node))) {
                Some(element) => found.extend(element.nodes()),
                None => set.unmodelled = set.unmodelled.saturating_add(1),
            }
        }
        set.labels.extend(found);
        Ok(())
    };
    let known = Known {
        member: &node,
        count: scene.nodes.len(),
        labels: &|| scene.nodes.keys().copied().collect(),
        sorted: OnceCell::new(),
        other: &OtherElements::default(),
        needed: &|name| needed_nodes.contains(name),
        named: &|name| named_nodes.contains(name),
    };
    let node_sets = sets::resolve(Kind::Node, &deck.node_sets, &known, &nodes_of, &mut warn, errors)?;
    (deck.scene.node_sets, deck.scene.element_sets) = (node_sets, element_sets);
    warnings.into_iter().for_each(|warning| deck.warn(warning));
    Ok(())
}

/// The set that a target names.
fn set(target: &Spanned<Target>) -> Option<&str> {
    target.value.set()
}

/// The node sets, and the element sets, of which what is evaluated takes the members.
fn needed_sets<'a>(deck: &'a Deck<'_>) -> (HashSet<&'a str>, HashSet<&'a str>) {
    let Scene { transforms, steps, connector_sections, masses, rotary_inertias, .. } = &deck.scene;
    let nodes = deck.mpcs.iter().flat_map(|mpc| &mpc.items).filter_map(set);
    let nodes = nodes.chain(transforms.iter().map(|transform| transform.node_set.value.as_str()));
    let [of_constraints, bodies] = deck.constraints.sets();
    let nodes = nodes.chain(of_constraints);
    let nodes = sets::closure(&deck.node_sets, nodes);
    let motions = steps.iter().flat_map(|step| &step.connector_motions).chain(&deck.scene.connector_motions);
    let loads = steps.iter().flat_map(|step| &step.connector_loads);
    let elements = connector_sections.iter().map(|section| section.element_set.value.as_str());
    let elements = elements.chain(masses.iter().map(|mass| mass.element_set.value.as_str()));
    let elements = elements.chain(rotary_inertias.iter().map(|inertia| inertia.element_set.value.as_str()));
    let discrete = deck.scene.springs.iter().chain(&deck.scene.dashpots);
    let elements = elements.chain(discrete.map(|discrete| discrete.element_set.value.as_str()));
    let elements = elements.chain(motions.filter_map(|motion| set(&motion.target)));
    let elements = elements.chain(loads.filter_map(|load| set(&load.target)));
    let elements = elements.chain(bodies);
    let of_nodes = nodes.iter().filter_map(|name| deck.node_sets.get(*name));
    let elements = elements.chain(of_nodes.flat_map(|builder| builder.element_sets()));
    let elements = sets::closure(&deck.element_sets, elements);
    (nodes, elements)
}

/// The node sets, and the element sets, that anything which is read names: these `needed`, and those that something acts on.
fn named_sets<'a>(
    deck: &'a Deck<'_>,
    needed_nodes: &HashSet<&'a str>,
    needed_elements: &HashSet<&'a str>,
) -> (HashSet<&'a str>, HashSet<&'a str>) {
    let Scene { steps, boundaries, initial_velocities, .. } = &deck.scene;
    let held = steps.iter().flat_map(|step| &step.boundaries).chain(boundaries).map(|held| &held.target);
    let loaded = steps.iter().flat_map(|step| &step.concentrated_loads).map(|load| &load.target);
    let moved = initial_velocities.iter().map(|moved| &moved.target);
    let nodes = held.chain(loaded).chain(moved).chain(deck.unread.targets()).filter_map(set);
    let nodes = nodes.chain(deck.unread.node_sets()).chain(needed_nodes.iter().copied());
    let nodes = sets::closure(&deck.node_sets, nodes);
    let drawn = steps.iter().flat_map(|step| &step.distributed_loads).filter_map(|load| load.target.as_ref());
    let of_nodes = nodes.iter().filter_map(|name| deck.node_sets.get(*name));
    let elements = drawn.filter_map(set).chain(of_nodes.flat_map(|builder| builder.element_sets()));
    let elements = elements.chain(deck.unread.element_sets()).chain(deck.constraints.sets_of_faces());
    let elements = elements.chain(needed_elements.iter().copied());
    let elements = sets::closure(&deck.element_sets, elements);
    (nodes, elements)
}

/// Names on connector sections, and one section for each connector.
fn sections(scene: &mut Scene, fasteners: &[String], errors: &mut Errors) {
    for place in 0..scene.connector_sections.len() {
        let section = &scene.connector_sections[place];
        errors.value(check_name(
            section.behavior.as_ref(),
            &scene.behaviors,
            "connector behaviour",
            "CONNECTOR BEHAVIOR",
            Code::UnknownBehavior,
        ));
        for orientation in [&section.orientation_a, &section.orientation_b] {
            errors.value(check_orientation(scene, orientation.as_ref()));
        }
        let name = &section.element_set.value;
        let is_empty =
            scene.element_sets.get(name).is_none_or(|set| set.labels.is_empty() && set.unmodelled == 0);
        if is_empty && fasteners.contains(name) {
            let (what, line) = ("connectors that *FASTENER generates".to_owned(), section.span.line());
            scene.skipped.count(what, line);
            continue;
        }
        let labels = errors.value(section_elements(scene, section)).unwrap_or_default();
        for label in labels {
            let Some(connector) = scene.connectors.get_mut(&label) else { continue };
            if let Some(first) =
                scene.connector_sections.get(connector.section).filter(|_| connector.section != place)
            {
                let span = scene.connector_sections[place].element_set.span;
                let message = format!("connector {label} has two sections");
                let label = format!("the first one is on line {}", first.span.line());
                errors.add(
                    Diagnostic::error(Code::TwoSections, span, message, label)
                        .beside(first.span)
                        .help("take the element out of one of the two sets"),
                );
                continue;
            }
            connector.section = place;
        }
    }
    for (label, connector) in &scene.connectors {
        if connector.section == usize::MAX {
            let message = format!("connector {label} has no section");
            let section = ["*CONNECTOR SECTION", "connector_sections"];
            errors.add(
                Diagnostic::error(
                    Code::MissingSection,
                    connector.span,
                    message,
                    section.map(|it| format!("no {it}")),
                )
                .help(section.map(|it| format!("put the element into a set and give that set a {it}"))),
            );
        }
    }
}

/// The elements of a connector section: connectors only.
fn section_elements(scene: &Scene, section: &ConnectorSection) -> Result<Vec<Label>> {
    let set = element_set(scene, &section.element_set)?;
    let Spanned { value: name, span } = &section.element_set;
    if set.labels.is_empty() && set.unmodelled == 0 {
        let message = format!("element set {name} is empty");
        return Err(Diagnostic::error(Code::EmptySet, *span, message, "has no elements")
            .help("put connector elements into the set, or remove the section"));
    }
    let other = set.labels.iter().find(|label| !scene.connectors.contains_key(*label));
    if set.unmodelled > 0 || other.is_some() {
        let which = other.map_or_else(|| "elements".to_owned(), |label| format!("element {label}"));
        let message = format!("set {name} has {which} that cannot have a connector section");
        return Err(Diagnostic::error(Code::WrongElementType, *span, message, "not only connectors").help(
            ["*CONNECTOR SECTION", "connector_sections"]
                .map(|section| format!("give {section} a set of CONN3D2 or CONN2D2 elements only")),
        ));
    }
    Ok(set.labels.clone())
}

fn check_behavior(name: &str, behavior: &Behavior) -> Result<()> {
    let source = |source: &Spanned<Source>| match &source.value {
        Source::Derived(derived) if !behavior.derived_components.contains_key(derived) => {
            let message = format!("behaviour {name} has no derived component {derived}");
            let names = behavior.derived_components.keys().map(String::as_str);
            let remedy =
                suggest(derived, names, || definition("CONNECTOR DERIVED COMPONENT", "NAME", derived));
            Err(Diagnostic::error(Code::UnknownDerivedComponent, source.span, message, "not defined")
                .help(remedy))
        }
        _ => Ok(()),
    };
    let terms = |potential: &Option<Potential>| {
        potential.iter().flat_map(|potential| &potential.terms).try_for_each(|term| source(&term.source))
    };
    for friction in &behavior.friction {
        if let FrictionKind::User { component, potential, contact_force, .. } = &friction.kind {
            contact_force.iter().try_for_each(source)?;
            terms(potential)?;
            if component.is_none() && potential.is_none() {
                return Err(Diagnostic::error(
                    Code::MissingParameter,
                    friction.span,
                    "this friction has no direction of slip",
                    ["neither COMPONENT nor a potential", "neither component nor potential"],
                )
                .help([
                    "give COMPONENT=…, or *CONNECTOR POTENTIAL below, or PREDEFINED",
                    "give component, potential or predefined",
                ]));
            }
        }
        if friction.coefficient.is_none() {
            let message = format!("a friction of behaviour {name} has no coefficient");
            return Err(Diagnostic::error(
                Code::MissingFriction,
                friction.span,
                message,
                ["*FRICTION is missing", "coefficient is missing"],
            )
            .help([
                "put *FRICTION with the coefficient directly below *CONNECTOR FRICTION",
                "give the friction its `coefficient`",
            ]));
        }
    }
    for plasticity in &behavior.plasticity {
        terms(&plasticity.potential)?;
        if plasticity.component.is_none() && plasticity.potential.is_none() {
            return Err(Diagnostic::error(
                Code::MissingParameter,
                plasticity.span,
                "this plasticity has no yield function",
                ["neither COMPONENT nor a potential", "neither component nor potential"],
            )
            .help(["give COMPONENT=…, or *CONNECTOR POTENTIAL below", "give component or potential"]));
        }
    }
    for damage in &behavior.damage {
        terms(&damage.potential)?;
        damage.evolution.iter().try_for_each(|evolution| terms(&evolution.potential))?;
    }
    Ok(())
}

/// Masses, inertias, springs and dashpots.
fn properties(scene: &Scene, errors: &mut Errors) {
    let of_kind = |name: &Spanned<String>, of: &str, kinds: &[PointKind]| {
        let set = element_set(scene, name)?;
        let wrong = set.labels.iter().find(|label| {
            scene.point_elements.get(*label).is_none_or(|element| !kinds.contains(&element.kind))
        });
        if set.unmodelled > 0 || wrong.is_some() || set.labels.is_empty() {
            let names: Vec<_> = kinds.iter().map(|kind| kind.name()).collect();
            let keyword = keyword(of);
            let message = keyword.each_ref().map(|keyword| match wrong {
                Some(label) => format!("element {label} of set {} cannot have a {keyword}", name.value),
                None => format!("set {} has elements that cannot have a {keyword}, or none", name.value),
            });
            let remedy =
                keyword.map(|keyword| format!("give {keyword} a set of {} elements", names.join(", ")));
            return Err(
                Diagnostic::error(Code::WrongElementType, name.span, message, "of another type").help(remedy)
            );
        }
        Ok(set)
    };
    for mass in &scene.masses {
        errors.value(of_kind(&mass.element_set, "MASS", &[PointKind::Mass]));
    }
    for inertia in &scene.rotary_inertias {
        errors.value(of_kind(&inertia.element_set, "ROTARY INERTIA", &[PointKind::Rotaryi]));
        errors.value(check_orientation(scene, inertia.orientation.as_ref()));
    }
    let springs = [PointKind::Spring1, PointKind::Spring2, PointKind::Springa];
    let dashpots = [PointKind::Dashpot1, PointKind::Dashpot2, PointKind::Dashpota];
    for (of, kinds, list) in [("SPRING", springs, &scene.springs), ("DASHPOT", dashpots, &scene.dashpots)] {
        for discrete in list {
            errors.value(check_orientation(scene, discrete.orientation.as_ref()));
            let Some(set) = errors.value(of_kind(&discrete.element_set, of, &kinds)) else { continue };
            let kinds = set
                .labels
                .iter()
                .filter_map(|label| scene.point_elements.get(label))
                .map(|element| element.kind);
            errors.value(check_degrees_of_freedom(discrete, of, kinds));
        }
    }
}

/// The axes of every node of a connector or constraint that has some, and no such node with two.
fn transforms(scene: &Scene, bearing: &LabelSet) -> Result<()> {
    let mut known: LabelMap<usize> = LabelMap::default();
    for (index, transform) in scene.transforms.iter().enumerate() {
        // A set may lack nodes where there is no connector that could have one of them.
        let set = if bearing.is_empty() {
            node_set(scene, &transform.node_set)?
        } else {
            complete_node_set(scene, &transform.node_set)?
        };
        for label in set.labels.iter().filter(|label| bearing.contains(*label)) {
            if let Some(node) = scene.nodes.get(label) {
                transform.triad(scene, node.coordinates)?;
            }
            let Some(first) = known.insert(*label, index).and_then(|first| scene.transforms.get(first))
            else {
                continue;
            };
            let (first, span) = (first.node_set.span, transform.node_set.span);
            let message = ["*TRANSFORMs", "transforms"].map(|axes| format!("node {label} has two {axes}"));
            let label = format!("the first one is on line {}", first.line());
            return Err(Diagnostic::error(Code::TwoTransforms, span, message, label)
                .beside(first)
                .help("take the node out of one of the two sets"));
        }
    }
    Ok(())
}

fn check_degrees_of_freedom(
    discrete: &Discrete,
    of: &str,
    kinds: impl Iterator<Item = PointKind>,
) -> Result<()> {
    for kind in kinds {
        let needed = match kind {
            PointKind::Spring1 | PointKind::Dashpot1 => 1,
            PointKind::Spring2 | PointKind::Dashpot2 => 2,
            _ => 0,
        };
        let given = discrete.degrees_of_freedom.len();
        if given != needed {
            let (name, span) = (kind.name(), discrete.element_set.span);
            let message = keyword(of).map(|keyword| {
                format!("{keyword} of {name} elements gives {given} degrees of freedom, not {needed}")
            });
            let first_line = ["on the first data line", "in degrees_of_freedom"];
            let remedy = match needed {
                0 => ["leave the first data line blank", "leave degrees_of_freedom out"].map(String::from),
                1 => first_line.map(|place| format!("give one degree of freedom {place}")),
                _ => first_line.map(|place| format!("give two degrees of freedom {place}")),
            };
            let label = format!("elements of type {name}");
            return Err(Diagnostic::error(Code::MissingData, span, message, label).help(remedy));
        }
    }
    Ok(())
}

/// A node or set that loads and boundary conditions act on; a set that lacks nodes has been warned about.
fn known_node_target(scene: &Scene, target: &Spanned<Target>) -> Result<()> {
    match &target.value {
        Target::Label(label) if scene.nodes.contains_key(label) => Ok(()),
        Target::Label(label) => Err(unknown(Kind::Node, *label, target.span)),
        Target::Set(name) => node_set(scene, &Spanned::new(name.clone(), target.span)).map(drop),
    }
}

/// Of the nodes to which what is not read gives rotations, those that belong to a connector or a constraint.
fn other_rotations(deck: &mut Deck<'_>) {
    let scene = &mut deck.scene;
    for target in &deck.rotation_targets {
        match target {
            Target::Label(label) => drop(deck.other_rotations.insert(*label)),
            Target::Set(name) => {
                let nodes = scene.node_sets.get(name).into_iter().flat_map(|set| &set.labels);
                deck.other_rotations.extend(nodes);
            }
        }
    }
    let ends = scene.connectors.values().flat_map(|element| [element.a, element.b]).flatten();
    let joined = constraint::nodes(scene);
    let rotates = |node: &Label| deck.any_rotates || deck.other_rotations.contains(node);
    scene.rotating_nodes = ends.chain(joined).filter(rotates).collect();
    deck.other_rotations = LabelSet::default();
}

/// One constraint per line, or one per member where sets are given.
fn mpcs(scene: &Scene, raw: &[RawMpc], errors: &mut Errors) -> Vec<Mpc> {
    let mut mpcs = Vec::with_capacity(raw.len());
    for raw in raw {
        match miscounted(raw) {
            // It follows from no other error.
            Some(error) => errors.tell(error),
            None => errors.value(constraints(scene, raw, &mut mpcs)).unwrap_or_default(),
        }
    }
    mpcs
}

/// That a constraint has another number of nodes than its kind.
fn miscounted(RawMpc { kind, items, span }: &RawMpc) -> Option<Diagnostic> {
    let known = kind.evaluated()?;
    let (name, needed) = (known.name(), known.entry().nodes.len());
    (items.len() != needed).then(|| {
        let message = format!("{name} takes {needed} nodes, not {}", items.len());
        Diagnostic::error(Code::BadConnectivity, *span, message, "this constraint")
            .help(format!("write: {name}, and {needed} nodes, the dependent one first"))
    })
}

fn constraints(scene: &Scene, raw: &RawMpc, mpcs: &mut Vec<Mpc>) -> Result<()> {
    let RawMpc { kind, items, span } = raw;
    let nodes = items.iter().map(|item| node_target(scene, item)).collect::<Result<Vec<_>>>()?;
    let bad = |message: String, remedy: String| {
        Err(Diagnostic::error(Code::BadConnectivity, *span, message, "this constraint").help(remedy))
    };
    if kind.evaluated().is_some() {
        let count = nodes.iter().map(Vec::len).max().unwrap_or(0);
        if nodes.iter().any(|members| members.len() != count && members.len() != 1) || count == 0 {
            let lengths: Vec<_> = nodes.iter().map(|members| members.len().to_string()).collect();
            return bad(
                format!("the sets have {} nodes", lengths.join(", ")),
                "give sets of equal size, or single nodes".to_owned(),
            );
        }
        for index in 0..count {
            let at = |members: &Vec<Label>| members.get(index).or(members.first()).copied();
            let chosen: Vec<Label> = nodes.iter().filter_map(at).collect();
            if chosen.first().is_some_and(|dependent| chosen[1..].contains(dependent)) {
                return bad(
                    format!("node {} is constrained to itself", chosen[0]),
                    "the first node is the dependent one and may stand there only".to_owned(),
                );
            }
            mpcs.push(Mpc { kind: kind.clone(), nodes: chosen, span: *span });
        }
        return Ok(());
    }
    mpcs.push(Mpc { kind: kind.clone(), nodes: nodes.into_iter().flatten().collect(), span: *span });
    Ok(())
}

/// Boundary conditions, motions, loads and output requests. Gives what is wrong with those that bear on no connector.
fn actuation(deck: &Deck<'_>, bearing: &LabelSet, errors: &mut Errors) -> Vec<Diagnostic> {
    let scene = &deck.scene;
    let mut excused = Vec::new();
    let amplitude = |name: &Option<Spanned<String>>| {
        check_name(name.as_ref(), &scene.amplitudes, "amplitude", "AMPLITUDE", Code::UnknownAmplitude)
    };
    let connectors = |target: &Spanned<Target>| {
        let named = |label: &Label| scene.connectors.contains_key(label);
        let wrong = |what: String| {
            let message = format!("{what} cannot be driven or loaded by component");
            Err(Diagnostic::error(Code::WrongElementType, target.span, message, "not a connector")
                .help("name a connector element, or a set of connector elements"))
        };
        match &target.value {
            Target::Label(label) if named(label) => Ok(()),
            Target::Label(label) if scene.point_elements.contains_key(label) => {
                wrong(format!("element {label}"))
            }
            Target::Label(label) => Err(unknown(Kind::Element, *label, target.span)),
            Target::Set(name) => {
                let set = element_set(scene, &Spanned::new(name.clone(), target.span))?;
                let all = set.unmodelled == 0 && !set.labels.is_empty() && set.labels.iter().all(named);
                if all { Ok(()) } else { wrong(format!("set {name}")) }
            }
        }
    };
    let motions =
        scene.connector_motions.iter().chain(scene.steps.iter().flat_map(|step| &step.connector_motions));
    for motion in motions {
        errors.value(connectors(&motion.target));
        errors.value(amplitude(&motion.applied.amplitude));
    }
    let boundaries = scene.boundaries.iter().chain(scene.steps.iter().flat_map(|step| &step.boundaries));
    // Of what acts on nodes that are known, and on none of a connector, the amplitude does not matter.
    let is_unread =
        |target: &Target| matches!(target, Target::Label(label) if deck.unread.nodes.contains(label));
    let mut on_nodes = |target: &Spanned<Target>, applied: &Application, errors: &mut Errors| {
        let known = match known_node_target(scene, target) {
            // What follows from a line that refuses nothing refuses nothing.
            Err(error) if is_unread(&target.value) => return excused.push(error),
            known => errors.value(known),
        };
        let Some(error) = amplitude(&applied.amplitude).err() else { return };
        let bears = known.is_none() || unread::acts_on(scene, &target.value, bearing);
        if bears { errors.add(error) } else { excused.push(error) }
    };
    for boundary in boundaries {
        on_nodes(&boundary.target, &boundary.applied, errors);
    }
    for velocity in &scene.initial_velocities {
        on_nodes(&velocity.target, &Application::default(), errors);
    }
    for step in &scene.steps {
        for load in &step.connector_loads {
            errors.value(connectors(&load.target));
            errors.value(amplitude(&load.applied.amplitude));
        }
        for load in &step.concentrated_loads {
            on_nodes(&load.target, &load.applied, errors);
        }
    }
    for step in &scene.steps {
        for load in &step.distributed_loads {
            let elements = match &load.target {
                Some(Spanned { value: Target::Set(name), span }) => {
                    element_set(scene, &Spanned::new(name.clone(), *span)).err()
                }
                Some(Spanned { value: Target::Label(label), span }) => {
                    let known = scene.connectors.contains_key(label)
                        || scene.point_elements.contains_key(label)
                        || deck.other_elements.contains(*label);
                    (!known).then(|| unknown(Kind::Element, *label, *span))
                }
                None => None,
            };
            let found = amplitude(&load.applied.amplitude).err().into_iter().chain(elements);
            if load.is_gravity() { found.for_each(|error| errors.add(error)) } else { excused.extend(found) }
        }
        for request in &step.outputs {
            excused.extend(request.element_set.iter().filter_map(|name| element_set(scene, name).err()));
            excused.extend(request.node_set.iter().filter_map(|name| node_set(scene, name).err()));
        }
    }
    excused
}
