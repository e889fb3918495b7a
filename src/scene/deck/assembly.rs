//! Parts, their instances, and the assembly of these.
//!
//! A part is read like a deck of its own. An instance is a copy of it, moved and turned. Its nodes and elements are called
//! `INSTANCE.NUMBER`, its sets and orientations `INSTANCE.NAME`. What its own lines add counts in the axes of the part, too.

use crate::deck::connector::RawMpc;
use crate::deck::constraint::Raw;
use crate::deck::faces::OtherElements;
use crate::deck::sets::SetBuilder;
use crate::deck::{Deck, keywords, unread};
use crate::diagnostic::{Code, Diagnostic, Result, suggest};
use crate::label::labelled::LabelSet;
use crate::label::{Instance, Label};
use crate::lexer::Keyword;
use crate::model::{Scene, Target, TransformKind};
use crate::orientation::{Definition, Orientation, System, minus, scaled, sin_cos_degrees};
use crate::span::{Span, Spanned};
use crate::written::Placement;
use indexmap::IndexMap;
use indexmap::map::Entry;

/// What a part, an instance or the model at large defines.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
    pub(super) scene: Scene,
    pub(super) node_sets: IndexMap<String, SetBuilder>,
    pub(super) element_sets: IndexMap<String, SetBuilder>,
    pub(super) other_elements: OtherElements,
    pub(super) mpcs: Vec<RawMpc>,
    pub(super) constraints: Raw,
    other_rotations: LabelSet,
    rotation_targets: Vec<Target>,
}

impl Level {
    /// The number of nodes, elements, sets and constraints, which an instance copies.
    fn size(&self) -> u64 {
        let Scene { nodes, connectors, point_elements, orientations, .. } = &self.scene;
        let entries = |sets: &IndexMap<String, SetBuilder>| sets.values().map(SetBuilder::len).sum::<usize>();
        let of_sets = entries(&self.node_sets) + entries(&self.element_sets);
        let others = self.mpcs.len()
            + self.constraints.len()
            + self.other_rotations.len()
            + self.rotation_targets.len();
        (nodes.len() + connectors.len() + point_elements.len() + orientations.len() + of_sets + others) as u64
    }
}

/// A part that instances may use.
#[derive(Debug)]
pub(super) struct Part {
    level: Level,
    span: Span,
    used: bool,
}

/// What is open: the keyword that opened it stands at the span.
#[derive(Debug)]
enum Open {
    Part(String),
    Assembly,
    Instance(Instance, Placement),
}

/// How far the reading of parts has come.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    parts: IndexMap<String, Part>,
    instances: IndexMap<String, Span>,
    open: Vec<(Open, Span)>,
    /// What is defined around the part or instance that is open.
    around: Option<Box<Level>>,
    /// The assembly itself.
    begun: Option<Span>,
    /// The first definition that stands in no part, instance or assembly.
    outside: Option<Span>,
}

impl Assembly {
    /// Whether a part, an instance or the assembly is being read.
    pub(super) fn is_open(&self) -> bool {
        !self.open.is_empty()
    }
}

impl Open {
    fn keyword(&self) -> &'static str {
        match self {
            Self::Part(_) => "PART",
            Self::Assembly => "ASSEMBLY",
            Self::Instance(..) => "INSTANCE",
        }
    }
}

impl Placement {
    /// R x + (1 − R) a + R t: exact where the axis is one of the coordinates and the angle a multiple of 90 degrees.
    pub(super) fn point(&self, x: [f64; 3]) -> [f64; 3] {
        let moved: [f64; 3] = std::array::from_fn(|k| x[k] + self.translation[k]);
        match &self.rotation {
            None => moved,
            Some((matrix, on_axis)) => {
                let turned = times(matrix, minus(moved, *on_axis));
                std::array::from_fn(|k| on_axis[k] + turned[k])
            }
        }
    }

    fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        self.rotation.as_ref().map_or(v, |(matrix, _)| times(matrix, v))
    }

    /// Points a and b of an axis through a. b may go far along it, so that its direction is not lost where a is far from the
    /// origin.
    fn axis(&self, a: [f64; 3], b: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let (from, mut along) = (self.point(a), self.direction(minus(b, a)));
        let size = |v: [f64; 3]| v.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
        while size(along) > 0.0 && size(along) < size(from) {
            along = along.map(|part| 2.0 * part);
        }
        (from, std::array::from_fn(|k| from[k] + along[k]))
    }

    /// An orientation of the part, as one of the instance; `nodes` are those of the part, where they were.
    fn orientation(
        &self,
        orientation: &mut Orientation,
        instance: Instance,
        nodes: &dyn Fn(Label) -> Option<[f64; 3]>,
    ) {
        let around_axis = matches!(orientation.system, System::Cylindrical | System::Spherical);
        let within = |label: Label| Label::of(Some(instance), label.number());
        match &mut orientation.definition {
            Definition::None | Definition::OffsetToNodes { .. } => {}
            Definition::Coordinates { a, b, .. } if around_axis => (*a, *b) = self.axis(*a, *b),
            Definition::Coordinates { a, b, c } => {
                if self.rotation.is_some() {
                    (*a, *b) = (self.direction(minus(*a, *c)), self.direction(minus(*b, *c)));
                    *c = [0.0; 3];
                }
            }
            Definition::Nodes { a, b, c: None } if !around_axis => {
                // The origin is that of the part, and no node.
                orientation.definition = match (nodes(*a), nodes(*b)) {
                    (Some(a), Some(b)) => {
                        Definition::Coordinates { a: self.direction(a), b: self.direction(b), c: [0.0; 3] }
                    }
                    _ => Definition::Nodes { a: within(*a), b: within(*b), c: None },
                };
            }
            Definition::Nodes { a, b, c } => {
                (*a, *b) = (within(*a), within(*b));
                *c = c.map(within);
            }
        }
    }
}

fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// cos θ 1 + (sin θ/|v|) v^ + ((1 − cos θ)/|v|²) v vᵀ, by rows, for θ in degrees; nothing where v is zero. The axis is not
/// normalized, so that round numbers stay round.
fn rotation_matrix(v: [f64; 3], degrees: f64) -> Option<[[f64; 3]; 3]> {
    let v = scaled(v);
    let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if !(square > 0.0 && square.is_finite()) {
        return None;
    }
    let (sine, cosine) = sin_cos_degrees(degrees);
    // 1 − cos θ = 2 sin² θ/2 keeps its digits at small angles.
    let (half, _) = sin_cos_degrees(degrees / 2.0);
    let versine = if cosine > 0.5 { 2.0 * half * half } else { 1.0 - cosine };
    let (along, across) = (versine / square, sine / square.sqrt());
    let skew = [[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]];
    Some(std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let diagonal = if i == j { cosine } else { 0.0 };
            diagonal + across * skew[i][j] + along * v[i] * v[j]
        })
    }))
}

impl Deck<'_> {
    fn swap_level(&mut self, level: &mut Level) {
        std::mem::swap(&mut self.scene, &mut level.scene);
        std::mem::swap(&mut self.node_sets, &mut level.node_sets);
        std::mem::swap(&mut self.element_sets, &mut level.element_sets);
        std::mem::swap(&mut self.other_elements, &mut level.other_elements);
        std::mem::swap(&mut self.mpcs, &mut level.mpcs);
        std::mem::swap(&mut self.constraints, &mut level.constraints);
        std::mem::swap(&mut self.other_rotations, &mut level.other_rotations);
        std::mem::swap(&mut self.rotation_targets, &mut level.rotation_targets);
        // What is skipped is counted for the deck as a whole.
        std::mem::swap(&mut self.scene.skipped, &mut level.scene.skipped);
    }

    /// Reads what follows into `level`, until [`leave`](Self::leave).
    fn enter(&mut self, mut level: Level) {
        self.swap_level(&mut level);
        self.system = None;
        self.assembly.around = Some(Box::new(level));
    }

    fn leave(&mut self) -> Level {
        let mut level = self.assembly.around.take().map(|level| *level).unwrap_or_default();
        self.swap_level(&mut level);
        self.system = None;
        level
    }

    /// Definitions belong to parts, instances and the assembly where there are such, and everything else to none of them.
    pub(super) fn check_level(&mut self, keyword: &Keyword, name: &str) -> Result<()> {
        let misplaced = |message: String, label: &str, remedy: String| {
            Err(Diagnostic::error(Code::MisplacedKeyword, keyword.span, message, label).help(remedy))
        };
        let assembly = &mut self.assembly;
        let has_parts = !assembly.parts.is_empty() || assembly.begun.is_some();
        match assembly.open.last() {
            _ if keywords::is_of_assembly(name) || keywords::is_constraint(name) => Ok(()),
            // Below *END ASSEMBLY they belong to the assembly.
            None if keywords::is_of_level(name) && assembly.begun.is_some() => Ok(()),
            None if keywords::is_of_level(name) && has_parts => misplaced(
                format!("*{name} stands outside every part, instance and assembly"),
                "belongs into one of them",
                "move it between *PART and *END PART, or to the instances in the *ASSEMBLY".to_owned(),
            ),
            None => {
                if keywords::is_of_level(name) {
                    assembly.outside.get_or_insert(keyword.span);
                }
                Ok(())
            }
            Some((open, span)) if !keywords::is_of_level(name) => misplaced(
                format!("*{name} stands in the *{} of line {}", open.keyword(), span.line()),
                "belongs to the model at large",
                if matches!(open, Open::Part(_)) {
                    "close the part by *END PART, and move the keyword below *END ASSEMBLY".to_owned()
                } else {
                    "move the keyword below *END ASSEMBLY".to_owned()
                },
            ),
            Some(_) => Ok(()),
        }
    }

    fn assembly_line(&self) -> u32 {
        self.assembly.open.last().map_or(0, |(_, span)| span.line())
    }

    /// Everything that was opened must be closed by now.
    pub(super) fn check_closed(&self) -> Result<()> {
        if let Some((open, span)) = self.assembly.open.last() {
            let name = open.keyword();
            let message = format!("a *{name} does not end");
            return Err(Diagnostic::error(Code::UnfinishedBlock, *span, message, "begins here")
                .help(format!("close it by *END {name}")));
        }
        if let (None, Some((name, part))) = (self.assembly.begun, self.assembly.parts.first()) {
            let message = format!("part {name} is in no assembly");
            return Err(Diagnostic::error(
                Code::MissingAssembly,
                part.span,
                message,
                "a part alone is no model",
            )
            .help("add *ASSEMBLY with an *INSTANCE of the part, or leave *PART and *END PART out"));
        }
        Ok(())
    }

    /// The instance that a set takes its members from.
    pub(super) fn instance_of(&self, keyword: &Keyword) -> Result<Option<Instance>> {
        let Some(name) = keyword.name_of("INSTANCE")? else { return Ok(None) };
        if !self.assembly.instances.contains_key(&name.value) {
            let message = format!("there is no instance {}", name.value);
            let names = self.assembly.instances.keys().map(String::as_str);
            let remedy = suggest(&name.value, names, || {
                "name an instance that is defined above; sets of instances stand in the *ASSEMBLY".to_owned()
            });
            return Err(
                Diagnostic::error(Code::UnknownInstance, name.span, message, "not defined").help(remedy)
            );
        }
        Ok(Some(Instance::named(&name.value)))
    }

    fn place(&mut self, level: Level, instance: Instance, placement: &Placement) {
        let within = |label: Label| Label::of(Some(instance), label.number());
        let target = |target: Target| match target {
            Target::Label(label) => Target::Label(within(label)),
            Target::Set(name) => Target::Set(instance.scoped(&name)),
        };
        let Level {
            mut scene,
            node_sets,
            element_sets,
            other_elements,
            mpcs,
            constraints,
            other_rotations,
            rotation_targets,
        } = level;
        self.other_rotations.extend(other_rotations.into_iter().map(within));
        let scoped = |name: &mut Spanned<String>| name.value = instance.scoped(&name.value);
        for (name, mut orientation) in std::mem::take(&mut scene.orientations) {
            let place = |label: Label| scene.nodes.get(&label).map(|node| node.coordinates);
            let written = orientation.definition.clone();
            placement.orientation(&mut orientation, instance, &place);
            if let Definition::Coordinates { .. } = orientation.definition
                && orientation.definition != written
            {
                let written = match written {
                    Definition::Nodes { a, b, c } => {
                        Definition::Nodes { a: within(a), b: within(b), c: c.map(within) }
                    }
                    other => other,
                };
                self.scene.written.add_orientation(instance.scoped(&name), written);
            }
            self.scene.orientations.insert(instance.scoped(&name), orientation);
        }
        self.scene.nodes.reserve(scene.nodes.len());
        let place = self.scene.written.add_placement(placement);
        for (label, mut node) in scene.nodes {
            let at = node.coordinates;
            self.scene.written.place(&scene.written, (label, at), within(label), place);
            node.coordinates = placement.point(at);
            self.scene.nodes.insert(within(label), node);
        }
        for (label, mut element) in scene.connectors {
            (element.a, element.b) = (element.a.map(within), element.b.map(within));
            self.scene.connectors.insert(within(label), element);
        }
        for (label, mut element) in scene.point_elements {
            (element.node, element.second) = (within(element.node), element.second.map(within));
            self.scene.point_elements.insert(within(label), element);
        }
        self.other_elements.place(other_elements, instance);
        for (sets, into) in [(node_sets, &mut self.node_sets), (element_sets, &mut self.element_sets)] {
            for (name, set) in sets {
                match into.entry(instance.scoped(&name)) {
                    Entry::Vacant(place) => drop(place.insert(set.within(instance))),
                    Entry::Occupied(mut place) => place.get_mut().extend(set.within(instance)),
                }
            }
        }
        for mut section in scene.connector_sections {
            scoped(&mut section.element_set);
            section.orientation_a.iter_mut().for_each(scoped);
            section.orientation_b.iter_mut().for_each(scoped);
            self.scene.connector_sections.push(section);
        }
        for mut mass in scene.masses {
            scoped(&mut mass.element_set);
            self.scene.masses.push(mass);
        }
        for mut inertia in scene.rotary_inertias {
            scoped(&mut inertia.element_set);
            inertia.orientation.iter_mut().for_each(scoped);
            self.scene.rotary_inertias.push(inertia);
        }
        let discrete = [(scene.springs, &mut self.scene.springs), (scene.dashpots, &mut self.scene.dashpots)];
        for (list, into) in discrete {
            for mut discrete in list {
                scoped(&mut discrete.element_set);
                discrete.orientation.iter_mut().for_each(scoped);
                into.push(discrete);
            }
        }
        for mut transform in scene.transforms {
            scoped(&mut transform.node_set);
            (transform.a, transform.b) = match transform.kind {
                TransformKind::Rectangular => {
                    (placement.direction(transform.a), placement.direction(transform.b))
                }
                TransformKind::Cylindrical | TransformKind::Spherical => {
                    placement.axis(transform.a, transform.b)
                }
            };
            self.scene.transforms.push(transform);
        }
        for mut mpc in mpcs {
            for item in &mut mpc.items {
                item.value = target(item.value.clone());
            }
            self.mpcs.push(mpc);
        }
        self.constraints.place(constraints, instance, &target);
        self.rotation_targets.extend(rotation_targets.into_iter().map(target));
    }

    /// `needs` must be open, or nothing if it is none.
    fn open_block(&mut self, keyword: &Keyword, needs: Option<&str>) -> Result<()> {
        let open = self.assembly.open.last().map(|(open, _)| open.keyword());
        if open == needs {
            return Ok(());
        }
        let name = &keyword.name;
        let (message, remedy) = match (open, needs) {
            (Some(open), _) => (
                format!("*{name} stands in the *{open} of line {}", self.assembly_line()),
                format!("close that one by *END {open} first"),
            ),
            (None, Some(needs)) => (
                format!("*{name} stands in no *{needs}"),
                format!("move it between *{needs} and *END {needs}"),
            ),
            (None, None) => return Ok(()),
        };
        Err(Diagnostic::error(Code::MisplacedKeyword, keyword.span, message, "not here").help(remedy))
    }

    fn close_block(&mut self, keyword: &Keyword, name: &str) -> Result<Open> {
        match self.assembly.open.pop() {
            Some((open, _)) if open.keyword() == name => Ok(open),
            open => {
                let message = format!("*{} closes nothing", keyword.name);
                let remedy = match open {
                    Some((open, span)) => {
                        format!(
                            "remove it, or close the *{0} of line {1} by *END {0} first",
                            open.keyword(),
                            span.line()
                        )
                    }
                    None => format!("remove it, or begin by *{name}"),
                };
                Err(Diagnostic::error(
                    Code::MisplacedKeyword,
                    keyword.span,
                    message,
                    format!("no *{name} is open"),
                )
                .help(remedy))
            }
        }
    }
}

pub(super) fn part(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.open_block(keyword, None)?;
    let name = keyword.need_name("NAME")?;
    let assembly = &mut deck.assembly;
    if let Some(outside) = assembly.outside {
        let message = "a deck with parts defines nothing outside them";
        let label = format!("nodes, elements or sets stand outside on line {}", outside.line());
        return Err(Diagnostic::error(Code::MisplacedKeyword, keyword.span, message, label)
            .beside(outside)
            .help("move those into a part or into the assembly, or leave the parts out"));
    }
    if let Some(begun) = assembly.begun {
        let message = "a part stands below the assembly";
        let label = format!("the assembly begins on line {}", begun.line());
        return Err(Diagnostic::error(Code::MisplacedKeyword, keyword.span, message, label)
            .beside(begun)
            .help("define the parts before *ASSEMBLY"));
    }
    if let Some(first) = assembly.parts.get(&name.value) {
        return Err(keyword.duplicate(&name, first.span));
    }
    assembly.open.push((Open::Part(name.value), keyword.span));
    deck.enter(Level::default());
    Ok(())
}

pub(super) fn end_part(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let begun = deck.assembly.open.last().map_or(keyword.span, |(_, span)| *span);
    if let Open::Part(name) = deck.close_block(keyword, "PART")? {
        let level = deck.leave();
        deck.assembly.parts.insert(name, Part { level, span: begun, used: false });
    }
    Ok(())
}

pub(super) fn assembly(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.open_block(keyword, None)?;
    let state = &mut deck.assembly;
    let other = state.begun.map(|begun| ("a deck has one assembly", begun, "the first one begins"));
    let outside = state.outside.map(|span| {
        ("a deck with an assembly defines nothing outside it", span, "nodes, elements or sets stand outside")
    });
    if let Some((message, span, label)) = other.or(outside) {
        let label = format!("{label} on line {}", span.line());
        return Err(Diagnostic::error(Code::MisplacedKeyword, keyword.span, message, label)
            .beside(span)
            .help("put everything into one assembly"));
    }
    state.begun = Some(keyword.span);
    // In capitals or between quotation marks, names are compared in any case.
    deck.lexer.assembly = keyword.name_of("NAME")?.map(|name| name.value);
    let state = &mut deck.assembly;
    state.open.push((Open::Assembly, keyword.span));
    Ok(())
}

pub(super) fn end_assembly(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.close_block(keyword, "ASSEMBLY")?;
    let unused: Vec<(String, Span)> = deck
        .assembly
        .parts
        .iter()
        .filter(|(_, part)| !part.used)
        .map(|(name, part)| (name.clone(), part.span))
        .collect();
    for (name, span) in unused {
        let message = format!("no instance uses part {name}");
        deck.warn(
            Diagnostic::warning(Code::UnusedPart, span, message, "not in the model")
                .help("add an *INSTANCE of it to the assembly, or remove the part"),
        );
    }
    deck.assembly.parts.values_mut().for_each(|part| part.level = Level::default());
    Ok(())
}

pub(super) fn instance(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.open_block(keyword, Some("ASSEMBLY"))?;
    if keyword.has("LIBRARY") {
        return of_library(deck, keyword);
    }
    let name = keyword.need_name("NAME")?;
    if deck.lexer.assembly.as_ref().is_some_and(|assembly| assembly.eq_ignore_ascii_case(&name.value)) {
        // Then its name qualifies what the instance has.
        deck.lexer.assembly = None;
    }
    let part = keyword.need_name("PART")?;
    if let Some(first) = deck.assembly.instances.get(&name.value) {
        return Err(keyword.duplicate(&name, *first));
    }
    let placement = placement(deck)?;
    let Some(known) = deck.assembly.parts.get_mut(&part.value) else {
        let message = format!("there is no part {}", part.value);
        let remedy = suggest(&part.value, deck.assembly.parts.keys().map(String::as_str), || {
            format!("define it by *PART, NAME={} above the assembly", part.value)
        });
        return Err(Diagnostic::error(Code::UnknownPart, part.span, message, "not defined").help(remedy));
    };
    // The first instance of a part is as large as its lines; further ones are larger than theirs.
    let copied = if known.used { known.level.size() } else { 0 };
    known.used = true;
    let level = known.level.clone();
    deck.count_generated(copied, keyword.span)?;
    deck.enter(level);
    let instance = Instance::named(&name.value);
    deck.assembly.instances.insert(name.value, keyword.span);
    deck.assembly.open.push((Open::Instance(instance, placement), keyword.span));
    Ok(())
}

/// An instance of another deck's model: nothing is known of it but its name.
fn of_library(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    unread::elsewhere(deck, keyword);
    let name = keyword.need_name("INSTANCE")?;
    let placement = placement(deck)?;
    deck.enter(Level::default());
    let instance = Instance::named(&name.value);
    deck.assembly.instances.insert(name.value, keyword.span);
    deck.assembly.open.push((Open::Instance(instance, placement), keyword.span));
    Ok(())
}

pub(super) fn end_instance(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    if let Open::Instance(instance, placement) = deck.close_block(keyword, "INSTANCE")? {
        let level = deck.leave();
        deck.place(level, instance, &placement);
    }
    Ok(())
}

/// The data lines of `*INSTANCE`: a translation, then two points of an axis and an angle in degrees.
pub(super) fn placement(deck: &mut Deck<'_>) -> Result<Placement> {
    // −0 adds nothing, not even to −0.
    let mut placement = Placement { translation: [-0.0; 3], rotation: None };
    let Some(line) = deck.lexer.data()? else { return Ok(placement) };
    let mut items = line.items();
    placement.translation = items.vector()?;
    items.end("a translation x, y, z")?;
    let Some(line) = deck.lexer.row()? else { return Ok(placement) };
    let mut items = line.items();
    let (a, b) = (items.vector()?, items.vector()?);
    let angle = items.need("the angle of rotation in degrees")?.number()?;
    items.end("two points of the axis, and the angle in degrees")?;
    if angle == 0.0 {
        return Ok(placement);
    }
    let Some(matrix) = rotation_matrix(minus(b, a), angle) else {
        let message = "the two points of the axis of rotation coincide";
        return Err(Diagnostic::error(Code::DegenerateRotation, line.span, message, "no axis")
            .help("write: Xa, Ya, Za, Xb, Yb, Zb, angle in degrees, with two different points of the axis"));
    };
    placement.rotation = Some((matrix, a));
    Ok(placement)
}
