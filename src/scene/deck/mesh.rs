//! Nodes, sets, elements, orientations, and the properties of point elements.

use crate::deck::sets::SetBuilder;
use crate::deck::unread::Redefined;
use crate::deck::{Deck, table};
use crate::diagnostic::{Code, Diagnostic, Result, nearest, suggest};
use crate::freedom::element_rotates;
use crate::label::labelled::LabelSet;
use crate::label::{Instance, Label};
use crate::lexer::{Data, Item, Items, Keyword};
use crate::model::{
    ConnectorElement, Dimension, Discrete, Mass, Node, PointElement, PointKind, RotaryInertia, Scene,
    Transform, TransformKind,
};
use crate::orientation::{Definition, GLOBAL, Orientation, System, Triad, minus, sin_cos_degrees};
use crate::span::Span;
use indexmap::map::Entry;

pub(super) fn heading(deck: &mut Deck<'_>, _: &Keyword) -> Result<()> {
    while let Some(line) = deck.lexer.text()? {
        if !deck.scene.heading.is_empty() {
            deck.scene.heading.push('\n');
        }
        deck.scene.heading.push_str(&line);
    }
    Ok(())
}

pub(super) fn node(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let mut beyond = None;
    let read = nodes(deck, keyword, &mut beyond);
    beyond.into_iter().for_each(|warning| deck.warn(warning));
    read
}

/// The lines of `*NODE`, and a warning of the first that has more than coordinates.
fn nodes(deck: &mut Deck<'_>, keyword: &Keyword, beyond: &mut Option<Diagnostic>) -> Result<()> {
    let set = keyword.name_of("NSET")?;
    let system = keyword.word("SYSTEM", &["R", "C", "S"])?.unwrap_or("R");
    let axes = deck.system;
    let mut members =
        set.map(|name| deck.node_sets.entry(name.value).or_insert_with(|| SetBuilder::new(name.span)));
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let label = items.need("the node number")?.label_number("the node number")?;
        let mut coordinates = items.vector()?;
        let mut normal = [None; 3];
        for cosine in &mut normal {
            *cosine = items.number()?;
            if cosine.is_some() {
                deck.scene.skipped.count("normals below *NODE".to_owned(), line.span.line());
            }
        }
        if beyond.is_none() && beyond_coordinates(&line, normal) {
            let [x, y, z] = coordinates;
            let message = format!("node {label} is at ({x}, {y}, {z}), and its line goes on");
            *beyond = Some(
                Diagnostic::warning(Code::ItemsAfterCoordinates, line.span, message, "more than three coordinates")
                    .help("write decimal points, not decimal commas; what follows the coordinates is the normal at the node, of length 1"),
            );
        }
        items.end("a node number and three coordinates, and may go on with the normal at the node")?;
        if system == "C" && axes.is_none() {
            deck.scene.written.add_cylindrical(label.into(), coordinates);
        }
        coordinates = rectangular(system, coordinates);
        if let Some(axes) = axes {
            coordinates = axes.global(coordinates);
        }
        match deck.scene.nodes.entry(label.into()) {
            Entry::Vacant(place) => {
                place.insert(Node { coordinates, span: line.span });
            }
            Entry::Occupied(first) if first.get().coordinates == coordinates => {}
            Entry::Occupied(mut known) => {
                let again = Redefined { label: label.into(), first: known.get().span, again: line.span };
                // In a part its label is not yet the one that a connector has.
                if deck.assembly.is_open() {
                    return Err(again.error());
                }
                known.insert(Node { coordinates, span: line.span });
                deck.unread.redefined.push(again);
            }
        }
        if let Some(members) = &mut members {
            members.push_defined(label, line.span);
        }
    }
    Ok(())
}

/// Rectangular coordinates of a point in the system R, C or S: x, y, z; r, θ, z; or r, θ, φ, with φ from the plane, in degrees.
pub(super) fn rectangular(system: &str, [r, angle, rest]: [f64; 3]) -> [f64; 3] {
    if !["C", "S"].contains(&system) {
        return [r, angle, rest];
    }
    let (sine, cosine) = sin_cos_degrees(angle);
    let (radius, height) = match system {
        "C" => (r, rest),
        _ => {
            let (up, across) = sin_cos_degrees(rest);
            (r * across, r * up)
        }
    };
    [radius * cosine, radius * sine, height]
}

/// The axes that nodes are given in: an origin and three directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    origin: [f64; 3],
    directions: Triad,
}

impl Axes {
    /// A point that is given in them.
    pub(super) fn global(&self, x: [f64; 3]) -> [f64; 3] {
        let Self { origin, directions: [e1, e2, e3] } = self;
        std::array::from_fn(|k| origin[k] + (x[0] * e1[k] + x[1] * e2[k] + x[2] * e3[k]))
    }
}

/// `*SYSTEM`: point a is the origin, b lies on the local X axis, c in the local XY plane. Without c the Z axis stays, and the X axis is
/// projected onto the XY plane; without b the axes stay parallel; without all they are the global ones again.
pub(super) fn system(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.system = None;
    let Some(line) = deck.lexer.row()? else { return Ok(()) };
    let mut items = line.items();
    let point = |items: &mut Items<'_>| -> Result<Option<[f64; 3]>> {
        let numbers = [items.number()?, items.number()?, items.number()?];
        Ok(numbers.iter().any(Option::is_some).then(|| numbers.map(|number| number.unwrap_or(0.0))))
    };
    let a = point(&mut items)?.unwrap_or_default();
    let b = point(&mut items)?;
    items.end("the coordinates of points a and b")?;
    let c = match deck.lexer.row()? {
        None => None,
        Some(line) => {
            let mut items = line.items();
            let c = point(&mut items)?;
            items.end("the coordinates of point c")?;
            c
        }
    };
    let Some(b) = b else {
        deck.system = Some(Axes { origin: a, directions: GLOBAL });
        return Ok(());
    };
    let x = minus(b, a);
    let definition = match c {
        Some(c) => Definition::Coordinates { a: b, b: c, c: a },
        None => Definition::Coordinates { a: [x[0], x[1], 0.0], b: [-x[1], x[0], 0.0], c: [0.0; 3] },
    };
    let (system, axis, angle, span) = (System::Rectangular, 1, 0.0, keyword.span);
    let axes = Orientation { system, definition, axis, angle, span };
    let directions = axes.triad("of *SYSTEM", &deck.scene, [0.0; 3], &[])?;
    deck.system = Some(Axes { origin: a, directions });
    Ok(())
}

/// Whether what follows the coordinates is no normal: its length is not 1, or all numbers are whole, as the parts of numbers with
/// decimal commas are.
fn beyond_coordinates(line: &Data<'_>, normal: [Option<f64>; 3]) -> bool {
    /// What rounding to two digits leaves of a length of 1.
    const ROUNDED: f64 = 0.02;
    let square: f64 = normal.iter().flatten().map(|cosine| cosine * cosine).sum();
    let is_given = normal.iter().any(Option::is_some);
    let is_whole = || line.text.bytes().all(|c| c.is_ascii_digit() || b",-+ \t\r\n".contains(&c));
    let is_unit = (square - 1.0).abs() < ROUNDED || square == 0.0;
    let lacks = normal.iter().any(Option::is_none);
    is_given && (!is_unit || (lacks != (square == 0.0) && is_whole()))
}

pub(super) fn node_set(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let name = keyword.need_name("NSET")?;
    let instance = deck.instance_of(keyword)?;
    let set = deck.node_sets.entry(name.value).or_insert_with(|| SetBuilder::new(name.span));
    if let Some(mut elements) = keyword.name_of("ELSET")? {
        if let Some(instance) = instance {
            elements.value = instance.scoped(&elements.value);
        }
        set.push_nodes_of(elements);
    }
    members(&mut deck.lexer, keyword, instance, set, "the node number")
}

pub(super) fn element_set(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let name = keyword.need_name("ELSET")?;
    let instance = deck.instance_of(keyword)?;
    let set = deck.element_sets.entry(name.value).or_insert_with(|| SetBuilder::new(name.span));
    members(&mut deck.lexer, keyword, instance, set, "the element number")
}

fn members(
    lexer: &mut crate::lexer::Lexer<'_>,
    keyword: &Keyword,
    instance: Option<Instance>,
    set: &mut SetBuilder,
    what: &str,
) -> Result<()> {
    if keyword.has("UNSORTED") {
        set.set_unsorted();
    }
    let generate = keyword.has("GENERATE");
    while let Some(line) = lexer.row()? {
        if generate {
            range(&line, instance, set, what)?;
            continue;
        }
        for item in line.items().filter(|item| !item.text.is_empty()) {
            if item.is_integer() {
                set.push(Label::of(instance, item.label_number(what)?), item.span);
            } else if item.looks_numeric() {
                item.integer(what)?;
            } else if item.is_label() && instance.is_none() {
                set.push(item.label(what)?, item.span);
            } else {
                let mut name = item.name()?;
                if let Some(instance) = instance {
                    name.value = instance.scoped(&name.value);
                }
                set.push_set(name);
            }
        }
    }
    Ok(())
}

fn range(line: &Data<'_>, instance: Option<Instance>, set: &mut SetBuilder, what: &str) -> Result<()> {
    let mut items = line.items();
    let first = items.need(&format!("{what} to begin with"))?.label_number(what)?;
    let last = items.need(&format!("{what} to end with"))?.label_number(what)?;
    let step = items.maybe().map_or(Ok(1), |item| item.integer("the increment"))?;
    items.end("first, last and increment")?;
    let error = |message: String, remedy: &str| {
        Err(Diagnostic::error(Code::GenerateRange, line.span, message, "this range").help(remedy))
    };
    if last < first {
        return error(
            format!("the range ends at {last}, before it begins at {first}"),
            "write the smaller number first",
        );
    }
    if step == 0 {
        return error("an increment of 0 never ends".to_owned(), "use an increment of at least 1");
    }
    if (last - first) / step >= crate::deck::MAX_MEMBERS {
        return error(
            format!("the range has more than {} members", crate::deck::MAX_MEMBERS),
            "split the set, or use a larger increment",
        );
    }
    set.push_range(instance, (first, last, step), line.span);
    Ok(())
}

enum ElementType {
    Connector(Dimension),
    Point(PointKind),
    Other(String),
}

fn element_type(keyword: &Keyword) -> Result<ElementType> {
    let Some(value) = keyword.get("TYPE") else { return Err(keyword.missing("TYPE")) };
    let name = crate::label::normal(value.text());
    let points = PointKind::ALL;
    let connectors = ["CONN3D2", "CONN2D2"];
    Ok(match name.as_str() {
        "CONN3D2" => ElementType::Connector(Dimension::Three),
        "CONN2D2" => ElementType::Connector(Dimension::Two),
        other => match points.into_iter().find(|kind| kind.name() == other) {
            Some(kind) => ElementType::Point(kind),
            None if name.starts_with("CON") => {
                let remedy =
                    suggest(&name, connectors, || "connector elements are CONN3D2 and CONN2D2".to_owned());
                let message = format!("there is no element type {name}");
                return Err(Diagnostic::error(
                    Code::BadParameterValue,
                    value.span,
                    message,
                    "not an element type",
                )
                .help(remedy));
            }
            None => ElementType::Other(name),
        },
    })
}

pub(super) fn element(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let kind = element_type(keyword)?;
    deck.unread.any_bears |= matches!(kind, ElementType::Connector(_));
    if let ElementType::Other(name) = &kind
        && let Some(near) = nearest(name, PointKind::ALL.map(PointKind::name))
    {
        let message = format!("elements of type {name} are skipped");
        deck.warn(
            Diagnostic::warning(Code::MisspeltKeyword, keyword.span, message, "not a type that is read")
                .help(format!("did you mean {near}?")),
        );
    }
    let set = keyword.name_of("ELSET")?;
    let mut members =
        set.map(|name| deck.element_sets.entry(name.value).or_insert_with(|| SetBuilder::new(name.span)));
    let (mut count, mut lines) = (0, 0);
    let mut continued = false;
    let mut last = 0;
    // What is not read may still give its nodes rotations.
    let mut rotating = Rotating(match &kind {
        ElementType::Other(name) if element_rotates(name) => Some(&mut deck.other_rotations),
        _ => None,
    });
    // What follows the nodes of a type does not go on on the next line.
    let all = match &kind {
        ElementType::Other(name) => node_count(name),
        _ => usize::MAX,
    };
    let mut room = all;
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        if continued {
            lines += 1;
            let here = items.clone().filter(|item| !item.text.is_empty()).count();
            deck.other_elements.extend(last, rotating.nodes(items).take(room));
            room = room.saturating_sub(here);
            continued = room > 0 && line.text.trim_end().ends_with(',');
            continue;
        }
        let label = items.need("the element number")?.label_number("the element number")?;
        match &kind {
            ElementType::Connector(dimension) => {
                let element = connector(*dimension, items, &line)?;
                add_connector(&mut deck.scene, label, element)?;
            }
            ElementType::Point(kind) => {
                let element = point(*kind, items, &line)?;
                add_point(&mut deck.scene, label, element)?;
            }
            ElementType::Other(name) => {
                last = label;
                let here = items.clone().filter(|item| !item.text.is_empty()).count();
                deck.other_elements.push(label, name);
                deck.other_elements.extend(label, rotating.nodes(items).take(all));
                room = all.saturating_sub(here);
                continued = room > 0 && line.text.trim_end().ends_with(',');
                (count, lines) = (count + 1, lines + 1);
            }
        }
        if let Some(members) = &mut members {
            members.push_defined(label, line.span);
        }
    }
    if let ElementType::Other(name) = kind {
        let skipped = deck.scene.skipped.element_types.entry(name).or_default();
        if skipped.first_line == 0 {
            skipped.first_line = keyword.span.line();
        }
        skipped.count += count;
        skipped.data_lines += lines;
    }
    Ok(())
}

/// How many nodes elements of a continuum type have, which its name says; of other types any number.
fn node_count(type_name: &str) -> usize {
    let rest = ["C3D", "CPE", "CPS"].iter().find_map(|family| type_name.strip_prefix(family));
    // C3D15V has 15 to 18.
    let rest = rest.filter(|rest| !rest.ends_with('V'));
    let digits = rest.map(|rest| rest.trim_end_matches(|letter: char| !letter.is_ascii_digit()));
    digits.and_then(|digits| digits.parse().ok()).filter(|count| *count > 2).unwrap_or(usize::MAX)
}

/// The nodes that elements of a type which is not read give rotations, if they do.
struct Rotating<'a>(Option<&'a mut LabelSet>);

impl Rotating<'_> {
    /// The nodes that items of an element name, which are given rotations; none for anything else.
    fn nodes<'t>(&mut self, items: Items<'t>) -> impl Iterator<Item = Option<Label>> {
        let named = items.filter(|item| !item.text.is_empty()).map(|item| item.text.parse::<Label>().ok());
        named.inspect(|node| {
            if let Some(known) = &mut self.0 {
                known.extend(*node);
            }
        })
    }
}

/// A number that an element of another definition has already.
pub(super) fn duplicate_element(label: Label, first: Option<Span>, span: Span) -> Diagnostic {
    let message = format!("element {label} is defined twice, and differently");
    let place = first.map_or_else(
        || "also an element of a skipped type".to_owned(),
        |first| format!("first defined on line {}", first.line()),
    );
    let error = Diagnostic::error(Code::DuplicateElement, span, message, place);
    let error = first.map_or(error.clone(), |first| error.beside(first));
    error.help("give one of the two another number")
}

/// Adds a connector, unless its number is taken by another element; the same one may stand twice.
pub(super) fn add_connector(scene: &mut Scene, label: u64, element: ConnectorElement) -> Result<()> {
    let first = scene.point_elements.get(&Label::from(label)).map(|element| element.span);
    let first = first.or_else(|| {
        let known = scene.connectors.get(&Label::from(label))?;
        let same = (known.dimension, known.a, known.b) == (element.dimension, element.a, element.b);
        (!same).then_some(known.span)
    });
    check_first(label, first, element.span)?;
    scene.connectors.entry(label.into()).or_insert(element);
    Ok(())
}

/// The same for a mass, spring or dashpot.
pub(super) fn add_point(scene: &mut Scene, label: u64, element: PointElement) -> Result<()> {
    let first = scene.connectors.get(&Label::from(label)).map(|element| element.span);
    let first = first.or_else(|| {
        let known = scene.point_elements.get(&Label::from(label))?;
        let same = (known.kind, known.node, known.second) == (element.kind, element.node, element.second);
        (!same).then_some(known.span)
    });
    check_first(label, first, element.span)?;
    scene.point_elements.entry(label.into()).or_insert(element);
    Ok(())
}

fn check_first(label: u64, first: Option<Span>, span: Span) -> Result<()> {
    first.map_or(Ok(()), |first| Err(duplicate_element(label.into(), Some(first), span)))
}

fn connector(dimension: Dimension, mut items: Items<'_>, line: &Data<'_>) -> Result<ConnectorElement> {
    let mut end = || items.maybe().map(|item: Item<'_>| item.label("the node number")).transpose();
    let (a, b) = (end()?, end()?);
    items.end("an element number and two nodes")?;
    let bad = |message: &str, remedy: &str| {
        Err(Diagnostic::error(Code::BadConnectivity, line.span, message, "this element").help(remedy))
    };
    match (a, b) {
        (None, None) => {
            bad("a connector element without a node", "give two nodes; an empty item is the ground")
        }
        (Some(a), Some(b)) if a == b => bad(
            "both ends of a connector are the same node",
            "give two different nodes; an empty item is the ground",
        ),
        _ => Ok(ConnectorElement { dimension, a, b, section: usize::MAX, span: line.span }),
    }
}

fn point(kind: PointKind, mut items: Items<'_>, line: &Data<'_>) -> Result<PointElement> {
    let node = items.need("the node")?.label("the node number")?;
    let second = if kind.node_count() == 2 {
        Some(items.need("the second node")?.label("the node number")?)
    } else {
        None
    };
    items.end(if second.is_some() {
        "an element number and two nodes"
    } else {
        "an element number and one node"
    })?;
    if second == Some(node) {
        return Err(Diagnostic::error(
            Code::BadConnectivity,
            line.span,
            "both ends of an element are the same node",
            "this element",
        )
        .help("give two different nodes"));
    }
    Ok(PointElement { kind, node, second, span: line.span })
}

pub(super) fn orientation(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let name = keyword.need_name("NAME")?;
    let systems = [
        ("RECTANGULAR", System::Rectangular),
        ("R", System::Rectangular),
        ("Z RECTANGULAR", System::ZRectangular),
        ("Z", System::ZRectangular),
        ("CYLINDRICAL", System::Cylindrical),
        ("C", System::Cylindrical),
        ("SPHERICAL", System::Spherical),
        ("S", System::Spherical),
        ("USER", System::User),
    ];
    let system = keyword.word("SYSTEM", &systems.map(|(name, _)| name))?;
    let mut system =
        systems.into_iter().find(|(name, _)| Some(*name) == system).map_or(System::Rectangular, |(_, s)| s);
    let definition = keyword.word("DEFINITION", &["COORDINATES", "NODES", "OFFSET TO NODES"])?;
    let definition = if system == System::User {
        Definition::None
    } else {
        let Some(line) = deck.lexer.row()? else {
            let message = keyword.words().map(|keyword| format!("{keyword} {} has no points", name.value));
            return Err(Diagnostic::error(Code::MissingData, keyword.span, message, table::LINE_FOLLOWS)
                .help(["line", "row"].map(|line| format!("give a {line} with Xa, Ya, Za, Xb, Yb, Zb"))));
        };
        let definition = definition.unwrap_or("COORDINATES");
        if definition == "COORDINATES" && line.items().maybe().is_some_and(|item| is_distribution(&item)) {
            // Each element has directions of its own, which are not read: an error where a connector uses them.
            system = System::User;
            deck.scene.skipped.count("*ORIENTATION by a distribution".to_owned(), line.span.line());
            Definition::None
        } else {
            points(&line, definition)?
        }
    };
    let (mut axis, mut angle) = (1, 0.0);
    if let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        if let Some(item) = items.maybe() {
            let number = item.integer("the axis")?;
            axis = u8::try_from(number).ok().filter(|axis| (1..=3).contains(axis)).ok_or_else(|| {
                let message = format!("there is no axis {number}");
                Diagnostic::error(Code::BadValue, item.span, message, "must be 1, 2 or 3").help(
                    keyword.words().map(|keyword| {
                        format!("line 2 of {keyword} is: axis, additional rotation in degrees about it")
                    }),
                )
            })?;
        }
        angle = items.number()?.unwrap_or(0.0);
        items.end("an axis (1, 2, 3) and an additional rotation in degrees")?;
    }
    if keyword.has("LOCAL DIRECTIONS") {
        deck.lexer.skip()?;
    }
    let orientation = Orientation { system, definition, axis, angle, span: keyword.span };
    if let Some(first) = deck.scene.orientations.get(&name.value) {
        return Err(keyword.duplicate(&name, first.span));
    }
    deck.scene.orientations.insert(name.value, orientation);
    Ok(())
}

/// Does the first item of an orientation name a `*DISTRIBUTION`?
fn is_distribution(item: &Item<'_>) -> bool {
    item.text.starts_with(|letter: char| letter.is_alphabetic() || letter == '"' || letter == '_')
}

fn points(line: &Data<'_>, definition: &str) -> Result<Definition> {
    let mut items = line.items();
    if definition == "COORDINATES" {
        let [a, b] = [vector(&mut items, "point a")?, vector(&mut items, "point b")?];
        let c = items.vector()?;
        items.end("the coordinates of points a, b and c")?;
        return Ok(Definition::Coordinates { a, b, c });
    }
    let (a, b) = (items.need("point a")?, items.need("point b")?);
    let c = items.maybe();
    items.end("the nodes a, b and c")?;
    let what = "the node number";
    Ok(if definition == "NODES" {
        let node = |item: Item<'_>| item.label(what);
        Definition::Nodes { a: node(a)?, b: node(b)?, c: c.map(node).transpose()? }
    } else {
        let count = |item: Item<'_>| item.label_number(what);
        Definition::OffsetToNodes { a: count(a)?, b: count(b)?, c: c.map(count).transpose()? }
    })
}

/// Three coordinates, at least one of which must be written.
fn vector(items: &mut Items<'_>, what: &str) -> Result<[f64; 3]> {
    let mut start = items.clone();
    let mut vector = [0.0; 3];
    let mut written = false;
    for coordinate in &mut vector {
        if let Some(item) = items.maybe() {
            *coordinate = item.number()?;
            written = true;
        }
    }
    if !written {
        start.need(&format!("the coordinates of {what}"))?;
    }
    Ok(vector)
}

pub(super) fn transform(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let node_set = keyword.need_name("NSET")?;
    let kind = keyword.choice("TYPE")?.unwrap_or(TransformKind::Rectangular);
    let Some(line) = deck.lexer.row()? else {
        return Err(table::no_rows((&keyword.name, keyword.span), &["Xa", "Ya", "Za", "Xb", "Yb", "Zb"]));
    };
    let mut items = line.items();
    let [a, b] = [vector(&mut items, "point a")?, vector(&mut items, "point b")?];
    items.end("the coordinates of points a and b")?;
    deck.scene.transforms.push(Transform { node_set, kind, a, b });
    Ok(())
}

pub(super) fn mass(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let element_set = keyword.need_name("ELSET")?;
    if keyword.word("TYPE", &["ISOTROPIC", "ANISOTROPIC"])? == Some("ANISOTROPIC") {
        deck.scene.skipped.count("*MASS, TYPE=ANISOTROPIC".to_owned(), keyword.span.line());
        return deck.lexer.skip().map(drop);
    }
    let Some(record) = table::record(&mut deck.lexer, 1)? else {
        return Err(table::no_rows((&keyword.name, keyword.span), &["the mass"]));
    };
    let mass = record.need(0, "the mass")?;
    not_negative(mass, "the mass", record.span)?;
    deck.scene.masses.push(Mass { element_set, mass });
    Ok(())
}

/// An error when a quantity that cannot be negative is.
pub(super) fn not_negative(value: f64, what: &str, span: Span) -> Result<()> {
    if value >= 0.0 {
        return Ok(());
    }
    Err(Diagnostic::error(
        Code::NumberOutOfRange,
        span,
        format!("{what} is negative: {value}"),
        "must not be negative",
    )
    .help(format!("give {what} as a positive number")))
}

pub(super) fn rotary_inertia(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let element_set = keyword.need_name("ELSET")?;
    let orientation = keyword.name_of("ORIENTATION")?;
    let Some(record) = table::record(&mut deck.lexer, 6)? else {
        return Err(table::no_rows(
            (&keyword.name, keyword.span),
            &["I11", "I22", "I33", "I12", "I13", "I23"],
        ));
    };
    let inertia = std::array::from_fn(|index| record.values.get(index).copied().flatten().unwrap_or(0.0));
    for value in inertia.iter().take(3) {
        not_negative(*value, "a principal rotary inertia", record.span)?;
    }
    deck.scene.rotary_inertias.push(RotaryInertia { element_set, orientation, inertia });
    Ok(())
}

pub(super) fn spring(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let spring = discrete(deck, keyword)?;
    deck.scene.springs.push(spring);
    Ok(())
}

pub(super) fn dashpot(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let dashpot = discrete(deck, keyword)?;
    deck.scene.dashpots.push(dashpot);
    Ok(())
}

fn discrete(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<Discrete> {
    let element_set = keyword.need_name("ELSET")?;
    let orientation = keyword.name_of("ORIENTATION")?;
    let (nonlinear, fields) = (keyword.has("NONLINEAR"), keyword.dependencies()?);
    let mut degrees_of_freedom = Vec::new();
    // A spring along its line may begin with its coefficient, without the blank line of degrees of freedom.
    let begins_with_number =
        |line: &Data<'_>| line.items().maybe().is_some_and(|item| item.looks_numeric() && !item.is_integer());
    let has_freedoms = deck.lexer.data()?.map(|line| !begins_with_number(&line));
    if has_freedoms.is_some() {
        deck.lexer.again();
    }
    if let Some(line) = if has_freedoms == Some(true) { deck.lexer.data()? } else { None } {
        let mut items = line.items();
        while degrees_of_freedom.len() < 2 {
            let Some(item) = items.maybe() else { break };
            degrees_of_freedom.push(degree_of_freedom(&item)?);
        }
        items.end("one degree of freedom for each node; for elements along a line it is blank")?;
    }
    let columns: &[&str] = if nonlinear { &["the force", "the displacement"] } else { &["the coefficient"] };
    let width = 3 + fields;
    let records = table::records(&mut deck.lexer, width)?;
    if records.is_empty() {
        return Err(table::no_rows((&keyword.name, keyword.span), columns));
    }
    for record in &records {
        for (index, what) in columns.iter().enumerate() {
            record.need(index, what)?;
        }
    }
    let rows = records.into_iter().map(|record| record.values).collect();
    let complex = keyword.has("COMPLEX STIFFNESS");
    Ok(Discrete { element_set, orientation, degrees_of_freedom, nonlinear, complex, rows })
}

/// Whether a degree of freedom is one of connectors: 1 to 6, or 10 for material flow.
pub(super) fn is_mechanical(dof: u8) -> bool {
    matches!(dof, 1..=6 | 10)
}

/// The largest degree of freedom there is: temperatures of shells count from 11.
pub(super) const LAST_FREEDOM: u8 = 30;

/// Any degree of freedom: those of other physics too, warping (7), pressure (8), potential (9), temperature (11, in some programs 0).
pub(super) fn any_degree_of_freedom(item: &Item<'_>) -> Result<u8> {
    let number = item.integer("a degree of freedom")?;
    u8::try_from(number).ok().filter(|dof| *dof <= LAST_FREEDOM).ok_or_else(|| {
        let message = format!("there is no degree of freedom {number}");
        Diagnostic::error(Code::BadDegreeOfFreedom, item.span, message, "too large")
            .help("1 to 3 are translations, 4 to 6 rotations, 10 is material flow")
    })
}

/// 1 to 6, or 10 for material flow.
pub(super) fn degree_of_freedom(item: &Item<'_>) -> Result<u8> {
    let number = item.integer("a degree of freedom")?;
    u8::try_from(number).ok().filter(|dof| is_mechanical(*dof)).ok_or_else(|| {
        let message = format!("there is no degree of freedom {number} here");
        Diagnostic::error(Code::BadDegreeOfFreedom, item.span, message, "must be 1 to 6, or 10")
            .help("1 to 3 are translations, 4 to 6 rotations, 10 is material flow")
    })
}
