//! A scene as a document, and a document as text.

mod behavior;
mod text;

use crate::behavior::{Independent, TableRow};
use crate::deck;
use crate::diagnostic::Result;
use crate::document::form;
use crate::document::form::{Document, Entries, Item, placeless};
use crate::document::{Format, SCHEMA};
use crate::label::Label;
use crate::model::CouplingKind;
use crate::model::{
    Amplitude, Application, Boundary, ConditionKind, ConnectorMotion, Dimension, Discrete, MotionType,
    MpcKind, Operation, Procedure, Scene, Set, SkippedItem, Step, Target, TransformKind,
};
use crate::orientation::{Definition, Orientation, System};
use crate::span::Spanned;
use behavior::behavior;
use serde_json::Value;
use text::{json_text, toml_text};

/// A scene as text, and what of its file is not in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Converted {
    /// The text.
    pub text: String,
    /// What the text has not, one thing each: skipped keywords, parameters, comments, states in a deck …
    pub dropped: Vec<String>,
}

impl Scene {
    /// The scene as a deck, TOML or JSON. Reading the text gives the same scene, number by number to the last bit.
    ///
    /// # Errors
    /// A name that cannot be written, such as one with a quotation mark; scenes that were read have none.
    pub fn write(&self, format: Format) -> Result<Converted> {
        let mut dropped = Vec::new();
        self.skipped_things(&mut dropped);
        let mut document = document(self, &mut dropped);
        let text = match format {
            Format::Deck => {
                if !document.states.is_empty() {
                    let count = document.states.len();
                    dropped.push(format!("{count} state{}: a deck has none", plural(count as u64)));
                }
                let nodes = document.rotating_nodes.len();
                if nodes > 0 {
                    dropped.push(format!(
                        "rotations of {nodes} node{} of skipped elements and constraints: a deck would need those",
                        plural(nodes as u64)
                    ));
                }
                if document.axisymmetric {
                    dropped.push("that the model is axisymmetric: a deck would need its elements".to_owned());
                }
                if let Some(is_flat) = document.two_dimensional {
                    let count = if is_flat { "two" } else { "three" };
                    dropped.push(format!(
                        "that the model has {count} dimensions: a deck would need its elements"
                    ));
                }
                document.states.clear();
                deck::write::deck(&document)?.text
            }
            Format::Toml => toml_text(&value(&document)),
            Format::Json => json_text(&value(&document)),
        };
        Ok(Converted { text, dropped })
    }

    fn skipped_things(&self, dropped: &mut Vec<String>) {
        let count = |item: &SkippedItem, what: &str| {
            let lines = match item.data_lines {
                0 => String::new(),
                lines => format!(" with {lines} data line{}", plural(lines)),
            };
            let times = item.count;
            format!("{times} {what}{}{lines}, first on line {}", plural(times), item.first_line)
        };
        for (name, item) in &self.skipped.keywords {
            dropped.push(format!("*{name}: {}", count(item, "keyword")));
        }
        for (name, item) in &self.skipped.element_types {
            dropped.push(format!("elements of type {name}: {}", count(item, "element")));
        }
        for (name, item) in &self.skipped.parameters {
            dropped.push(format!("{name}: {}", count(item, "occurrence")));
        }
        if self.skipped.comments > 0 {
            let lines = self.skipped.comments;
            dropped.push(format!("{lines} comment line{}", plural(lines)));
        }
    }
}

fn plural(count: u64) -> &'static str {
    if count == 1 { "" } else { "s" }
}

fn value(document: &Document) -> Value {
    serde_json::to_value(document).unwrap_or_default()
}

// From the model to the form. Every field of the model is taken apart, so that a new one cannot be forgotten.

fn document(scene: &Scene, dropped: &mut Vec<String>) -> Document {
    let Scene {
        name: _,
        heading,
        nodes,
        node_sets,
        connectors,
        point_elements,
        element_sets,
        rotating_nodes,
        axisymmetric,
        two_dimensional,
        orientations,
        connector_sections,
        behaviors,
        mpcs,
        equations,
        surfaces,
        rigid_bodies,
        couplings,
        ties,
        masses,
        rotary_inertias,
        springs,
        dashpots,
        transforms,
        amplitudes,
        initial_velocities,
        boundaries,
        connector_motions,
        steps,
        states,
        solver: _,
        skipped: _,
        files: _,
        warnings: _,
        written: _,
    } = scene;
    let connector = |element: &crate::model::ConnectorElement| form::Connector {
        a: element.a.map(label),
        b: element.b.map(label),
        dimension: (element.dimension != Dimension::Three).then_some(element.dimension),
    };
    let section = |section: &crate::model::ConnectorSection| form::ConnectorSection {
        element_set: name(&section.element_set),
        r#type: form::OneOrMany(section.type_names.iter().map(name).collect()),
        behavior: section.behavior.as_ref().map(name),
        orientation_a: section.orientation_a.as_ref().map(name),
        orientation_b: section.orientation_b.as_ref().map(name),
        data: items(&section.section_data),
        controls: section.controls.as_ref().map(name),
        elimination: section.elimination,
    };
    let mut unmodelled = 0;
    for set in node_sets.values().chain(element_sets.values()) {
        unmodelled += set.unmodelled;
    }
    if unmodelled > 0 {
        dropped.push(format!("{unmodelled} member{} of sets: elements of skipped types", plural(unmodelled)));
    }
    Document {
        schema_link: None,
        schema: Some(placeless(SCHEMA.to_owned())),
        heading: placeless(heading.clone()),
        nodes: entries(nodes, |node| placeless(form::Point(node.coordinates.map(placeless).to_vec()))),
        node_sets: entries(node_sets, members),
        connectors: entries(connectors, |element| placeless(connector(element))),
        point_elements: entries(point_elements, |element| {
            let nodes = std::iter::once(element.node).chain(element.second).map(label).collect();
            placeless(form::PointElement { kind: element.kind, nodes })
        }),
        rotating_nodes: rotating_nodes.iter().copied().map(label).collect(),
        axisymmetric: *axisymmetric,
        two_dimensional: Some(*two_dimensional).filter(|is| *is != scene.has_flat_connectors_alone()),
        element_sets: entries(element_sets, members),
        orientations: entries(orientations, |given| placeless(orientation(given))),
        connector_sections: list(connector_sections, section),
        behaviors: entries(behaviors, |given| placeless(behavior(given))),
        mpcs: list(mpcs, |mpc| {
            let kind = mpc.kind.name();
            let user = match &mpc.kind {
                MpcKind::Other(name) => name.strip_prefix("USER "),
                _ => None,
            };
            form::Mpc {
                r#type: placeless(user.unwrap_or(kind).to_owned()),
                nodes: mpc.nodes.iter().copied().map(label).collect(),
                user: user.is_some(),
            }
        }),
        equations: list(equations, |equation| form::Equation {
            terms: list(&equation.terms, |term| form::EquationTerm {
                node: label(term.node),
                degree_of_freedom: placeless(u64::from(term.degree_of_freedom)),
                factor: placeless(term.factor),
            }),
        }),
        surfaces: entries(surfaces, |surface| {
            list(&surface.members, |(node, area)| form::SurfaceMember {
                node: target(node),
                area: area.map(placeless),
            })
        }),
        rigid_bodies: list(rigid_bodies, |body| form::RigidBody {
            reference: label(body.reference),
            element_set: body.element_set.as_ref().map(name),
            pin_set: body.pin_set.as_ref().map(name),
            tie_set: body.tie_set.as_ref().map(name),
            nodes: list(&body.others, |node| label(*node).value),
        }),
        couplings: list(couplings, |coupling| form::Coupling {
            name: name(&coupling.name),
            reference: label(coupling.reference),
            surface: name(&coupling.surface),
            orientation: coupling.orientation.as_ref().map(name),
            influence_radius: coupling.influence_radius.map(placeless),
            kinematic: match &coupling.kind {
                CouplingKind::Kinematic(numbers) => list(numbers, |number| u64::from(*number)),
                CouplingKind::Distributing(_) => Vec::new(),
            },
            distributing: match coupling.kind {
                CouplingKind::Distributing(weighting) => Some(weighting),
                CouplingKind::Kinematic(_) => None,
            },
        }),
        ties: list(ties, |tie| form::Tie {
            name: name(&tie.name),
            slave: name(&tie.slave),
            master: name(&tie.master),
            position_tolerance: tie.position_tolerance.map(placeless),
            no_rotation: tie.no_rotation,
        }),
        masses: list(masses, |mass| form::Mass {
            element_set: name(&mass.element_set),
            mass: placeless(mass.mass),
        }),
        rotary_inertias: list(rotary_inertias, |inertia| form::RotaryInertia {
            element_set: name(&inertia.element_set),
            inertia: placeless(inertia.inertia),
            orientation: inertia.orientation.as_ref().map(name),
        }),
        springs: list(springs, discrete),
        dashpots: list(dashpots, discrete),
        transforms: list(transforms, |transform| form::Transform {
            node_set: name(&transform.node_set),
            a: placeless(transform.a),
            b: placeless(transform.b),
            kind: (transform.kind != TransformKind::Rectangular).then_some(transform.kind),
        }),
        amplitudes: entries(amplitudes, |given| placeless(amplitude(given))),
        initial_velocities: list(initial_velocities, |given| form::InitialVelocity {
            target: target(&given.target),
            degree_of_freedom: placeless(given.degree_of_freedom.into()),
            magnitude: placeless(given.magnitude),
        }),
        boundaries: list(boundaries, boundary),
        connector_motions: list(connector_motions, motion),
        steps: steps.iter().map(|given| placeless(step(given, scene, dropped))).collect(),
        states: list(states, |state| form::State {
            number: state.number,
            time: state.time,
            forces: entries_of(state),
            nodes: state.nodes.iter().map(|(label, motion)| (label.to_string(), motion.into())).collect(),
        }),
    }
}

fn name(given: &Spanned<String>) -> Spanned<String> {
    placeless(given.value.clone())
}

fn list<T, F>(given: &[T], form: impl Fn(&T) -> F) -> Vec<Spanned<F>> {
    given.iter().map(|item| placeless(form(item))).collect()
}

fn entries<K: ToString, T, F, S>(given: &indexmap::IndexMap<K, T, S>, form: impl Fn(&T) -> F) -> Entries<F> {
    given.iter().map(|(key, item)| (key.to_string(), form(item))).collect()
}

fn entries_of(state: &crate::model::State) -> Entries<Entries<Spanned<f64>>> {
    let named = |forces: &crate::model::ElementForces| {
        forces.named().map(|(name, value)| (name.to_owned(), placeless(value))).collect()
    };
    let elements = state.forces.iter().map(|(element, forces)| (element.to_string(), named(forces)));
    elements.chain(state.mpc_forces.iter().map(|(nodes, forces)| (nodes.clone(), named(forces)))).collect()
}

fn label_of(label: Label) -> form::Target {
    match label.instance() {
        None => form::Target::Number(label.number()),
        Some(_) => form::Target::Text(label.to_string()),
    }
}

fn label(label: Label) -> Spanned<form::Target> {
    placeless(label_of(label))
}

fn members(set: &Set) -> Vec<Spanned<form::Member>> {
    let one = |label: &Label| placeless(form::Member::One(label_of(*label)));
    set.labels.iter().map(one).collect()
}

fn unless(value: f64, default: f64) -> Option<Spanned<f64>> {
    (value.to_bits() != default.to_bits()).then(|| placeless(value))
}

fn maybe(value: Option<f64>) -> Option<Spanned<f64>> {
    value.map(placeless)
}

fn items(values: &[Option<f64>]) -> Vec<Spanned<Item>> {
    values.iter().map(|value| placeless(Item(*value))).collect()
}

/// Without the empty items at the end.
fn trimmed(values: &[Option<f64>]) -> Vec<Spanned<Item>> {
    let length = values.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
    items(values.get(..length).unwrap_or(values))
}

fn raw(rows: &[Vec<Option<f64>>]) -> Vec<Spanned<Vec<Spanned<Item>>>> {
    rows.iter().map(|row| placeless(trimmed(row))).collect()
}

/// The number of field variables in rows that are kept as they are written.
fn dependencies(rows: &[Vec<Option<f64>>], others: usize) -> Option<Spanned<u64>> {
    let width = rows.iter().map(Vec::len).max().unwrap_or(0);
    let fields = u64::try_from(width.saturating_sub(others)).unwrap_or(0);
    (fields > 0).then(|| placeless(fields))
}

fn table(rows: &[TableRow]) -> Vec<Spanned<form::Row>> {
    list(rows, |row| form::Row {
        values: trimmed(&row.values),
        temperature: maybe(row.temperature),
        fields: items(&row.fields),
    })
}

fn components(components: &[u8]) -> Vec<Spanned<form::Component>> {
    components.iter().copied().map(component).collect()
}

fn component(component: u8) -> Spanned<form::Component> {
    placeless(form::Component(component.into()))
}

fn independent(independent: Option<&Independent>) -> Option<form::Independent> {
    independent.map(|independent| form::Independent {
        basis: independent.basis,
        components: components(&independent.components),
    })
}

fn orientation(orientation: &Orientation) -> form::Orientation {
    let Orientation { system, definition, axis, angle, span: _ } = orientation;
    let point = |point: &[f64; 3]| Some(placeless(form::PointOrNode::Point(point.map(placeless).to_vec())));
    let node = |node: Label| Some(placeless(form::PointOrNode::Node(label_of(node))));
    let place = |place: u64| Some(placeless(form::PointOrNode::Node(form::Target::Number(place))));
    let (kind, [a, b, c]) = match definition {
        Definition::Coordinates { a, b, c } => {
            let c = c.iter().any(|value| value.to_bits() != 0).then_some(c);
            (None, [point(a), point(b), c.and_then(point)])
        }
        Definition::Nodes { a, b, c } => {
            (Some(form::Definition::Nodes), [node(*a), node(*b), c.and_then(node)])
        }
        Definition::OffsetToNodes { a, b, c } => {
            (Some(form::Definition::OffsetToNodes), [place(*a), place(*b), c.and_then(place)])
        }
        Definition::None => (None, [None, None, None]),
    };
    let turned = *axis != 1 || angle.to_bits() != 0;
    form::Orientation {
        system: (*system != System::Rectangular).then_some(*system),
        definition: kind,
        a,
        b,
        c,
        axis: turned.then(|| placeless(u64::from(*axis))),
        angle: turned.then(|| placeless(*angle)),
    }
}

fn discrete(discrete: &Discrete) -> form::Discrete {
    let Discrete { element_set, orientation, degrees_of_freedom, nonlinear, complex, rows } = discrete;
    form::Discrete {
        element_set: name(element_set),
        rows: raw(rows),
        orientation: orientation.as_ref().map(name),
        degrees_of_freedom: degrees_of_freedom.iter().map(|freedom| placeless(u64::from(*freedom))).collect(),
        nonlinear: *nonlinear,
        complex: *complex,
        dependencies: dependencies(rows, 3),
    }
}

fn amplitude(amplitude: &Amplitude) -> form::Amplitude {
    let Amplitude { definition, time, value, smooth, fixed_interval, begin, data, span: _ } = amplitude;
    let (mut pairs, mut numbers) = (Vec::new(), Vec::new());
    if definition.has_pairs() {
        pairs = data
            .chunks_exact(2)
            .filter_map(|pair| match pair {
                [Some(time), Some(value)] => Some(placeless([placeless(*time), placeless(*value)])),
                _ => None,
            })
            .collect();
    } else {
        numbers = items(data);
    }
    form::Amplitude {
        definition: Some(*definition),
        time: *time,
        value: *value,
        smooth: maybe(*smooth),
        fixed_interval: maybe(*fixed_interval),
        begin: maybe(*begin),
        pairs,
        data: numbers,
    }
}

fn target(target: &Spanned<Target>) -> Spanned<form::Target> {
    match &target.value {
        Target::Label(given) => label(*given),
        Target::Set(name) => placeless(form::Target::Text(name.clone())),
    }
}

/// Amplitude, operation, load case.
type Applied = (Option<Spanned<String>>, Option<Operation>, Option<Spanned<u64>>);

fn applied(applied: &Application) -> Applied {
    (
        applied.amplitude.as_ref().map(name),
        (applied.operation != Operation::Modify).then_some(applied.operation),
        applied.load_case.map(placeless),
    )
}

fn motion_type(kind: MotionType) -> Option<MotionType> {
    (kind != MotionType::Displacement).then_some(kind)
}

fn boundary(boundary: &Boundary) -> form::Boundary {
    let Boundary { target: on, degrees_of_freedom, magnitude, kind, applied: how } = boundary;
    let (amplitude, operation, load_case) = applied(how);
    form::Boundary {
        target: target(on),
        degrees_of_freedom: degrees_of_freedom.iter().map(|freedom| placeless(u64::from(*freedom))).collect(),
        magnitude: unless(*magnitude, 0.0),
        r#type: motion_type(*kind),
        fixed: how.fixed,
        user: how.user,
        amplitude,
        operation,
        load_case,
    }
}

fn motion(motion: &ConnectorMotion) -> form::ConnectorMotion {
    let ConnectorMotion { target: on, component: given, magnitude, kind, applied: how } = motion;
    let (amplitude, operation, load_case) = applied(how);
    form::ConnectorMotion {
        target: target(on),
        component: component(*given),
        magnitude: maybe(*magnitude),
        r#type: motion_type(*kind),
        fixed: how.fixed,
        user: how.user,
        imaginary: how.imaginary,
        amplitude,
        operation,
        load_case,
    }
}

fn step(step: &Step, scene: &Scene, dropped: &mut Vec<String>) -> form::Step {
    let Step {
        name: called,
        nlgeom,
        perturbation,
        increments,
        default_amplitude,
        procedure,
        removed,
        boundaries,
        concentrated_loads,
        distributed_loads,
        connector_motions,
        connector_loads,
        outputs,
        span: _,
    } = step;
    let (procedure, times) = match procedure {
        None => (None, None),
        Some(Procedure::Static(times)) => (Some("static"), Some(times)),
        Some(Procedure::Dynamic { explicit: false, times }) => (Some("dynamic"), Some(times)),
        Some(Procedure::Dynamic { explicit: true, times }) => (Some("dynamic_explicit"), Some(times)),
        Some(Procedure::Other(name)) => (Some(name.as_str()), None),
    };
    let times = times.map(|times| form::Times {
        initial: maybe(times.initial),
        total: maybe(times.total),
        minimum: maybe(times.minimum),
        maximum: maybe(times.maximum),
    });
    let known = |load: &&crate::model::DistributedLoad| match load.target.as_ref().map(|on| &on.value) {
        Some(Target::Label(label)) => {
            scene.connectors.contains_key(label) || scene.point_elements.contains_key(label)
        }
        _ => true,
    };
    let loads: Vec<_> = distributed_loads.iter().filter(known).collect();
    let lost = distributed_loads.len() - loads.len();
    if lost > 0 {
        dropped.push(format!("{lost} *DLOAD line{} on elements of skipped types", plural(lost as u64)));
    }
    let is_new = |applied: &Application| applied.operation == Operation::New;
    let is_told = |kind: &&ConditionKind| match kind {
        ConditionKind::Boundary => boundaries.iter().any(|given| is_new(&given.applied)),
        ConditionKind::ConnectorMotion => connector_motions.iter().any(|given| is_new(&given.applied)),
        ConditionKind::ConnectorLoad => connector_loads.iter().any(|given| is_new(&given.applied)),
        ConditionKind::ConcentratedLoad => concentrated_loads.iter().any(|given| is_new(&given.applied)),
        ConditionKind::DistributedLoad => loads.iter().any(|given| is_new(&given.applied)),
    };
    form::Step {
        name: called.clone().map(placeless),
        nlgeom: *nlgeom,
        perturbation: *perturbation,
        increments: increments.map(placeless),
        default_amplitude: *default_amplitude,
        procedure: procedure.map(|name| placeless(name.to_owned())),
        times: times.filter(|times| *times != form::Times::default()).map(placeless),
        removed: removed.iter().filter(|kind| !is_told(kind)).copied().map(placeless).collect(),
        boundaries: list(boundaries, boundary),
        concentrated_loads: list(concentrated_loads, |load| {
            let (amplitude, operation, load_case) = applied(&load.applied);
            form::ConcentratedLoad {
                target: target(&load.target),
                degree_of_freedom: placeless(load.degree_of_freedom.into()),
                magnitude: placeless(load.magnitude),
                follower: load.applied.follower,
                imaginary: load.applied.imaginary,
                amplitude,
                operation,
                load_case,
            }
        }),
        distributed_loads: loads
            .into_iter()
            .map(|load| {
                let (amplitude, operation, load_case) = applied(&load.applied);
                placeless(form::DistributedLoad {
                    label: placeless(load.label.clone()),
                    target: load.target.as_ref().map(target),
                    values: items(&load.values),
                    follower: load.applied.follower,
                    imaginary: load.applied.imaginary,
                    amplitude,
                    operation,
                    load_case,
                })
            })
            .collect(),
        connector_motions: list(connector_motions, motion),
        connector_loads: list(connector_loads, |load| {
            let (amplitude, operation, load_case) = applied(&load.applied);
            form::ConnectorLoad {
                target: target(&load.target),
                component: component(load.component),
                magnitude: placeless(load.magnitude),
                imaginary: load.applied.imaginary,
                amplitude,
                operation,
                load_case,
            }
        }),
        outputs: list(outputs, |request| form::OutputRequest {
            keyword: placeless(request.keyword.clone()),
            element_set: request.element_set.as_ref().map(name),
            node_set: request.node_set.as_ref().map(name),
            parameters: entries(&request.parameters, |value| placeless(form::Parameter(value.clone()))),
            variables: request.variables.iter().cloned().map(placeless).collect(),
        }),
    }
}
