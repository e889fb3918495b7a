//! A scene as a deck: every part as the keywords and data lines from which it can be read again.
//!
//! Documents in TOML and JSON are read in the same way: as the deck they stand for, each item of which knows its
//! place in the document. What the reader of decks checks is therefore checked for them by the same code.

use super::history::NAMED;
use super::keywords;
use super::table::PER_LINE;
use crate::scene::choice::Choice;
use crate::scene::diagnostic::{Code, Diagnostic, Result, suggest};
use crate::scene::document::form::{
    self, Behavior, Boundary, Damage, Document, Entries, Friction, Hardening, Independent, Item, Law, Lock,
    Member, Options, Plasticity, PointOrNode, Potential, Row, Source, Step, Target,
};
use crate::scene::label::{Instance, Label, LabelError};
use crate::scene::lexer::{Places, normal};
use crate::scene::model::{Dimension, MotionType, Operation, PointKind};
use crate::scene::orientation::System;
use crate::scene::span::{Span, Spanned};
use indexmap::IndexMap;

/// Members of a set on one data line.
const MEMBERS_PER_LINE: usize = 16;

/// Nodes of a constraint on its first data line.
const NODES_PER_LINE: usize = 15;

/// A deck, and where its items come from.
#[derive(Default)]
pub(in crate::scene) struct Deck {
    pub(in crate::scene) text: String,
    pub(in crate::scene) places: Places,
    /// Has the line an item yet?
    begun: bool,
}

/// The deck that a document stands for.
pub(in crate::scene) fn deck(document: &Document) -> Result<Deck> {
    let mut deck = Deck::default();
    deck.heading(&document.heading)?;
    deck.mesh(document)?;
    deck.properties(document)?;
    if !instances(document).is_empty() {
        deck.keyword("END ASSEMBLY", Span::default());
        deck.go();
    }
    for (name, amplitude) in &document.amplitudes.0 {
        deck.amplitude(name, amplitude)?;
    }
    for (name, behavior) in &document.behaviors.0 {
        deck.behavior(name, behavior)?;
    }
    deck.actuation(&document.boundaries, &document.connector_motions)?;
    for step in &document.steps {
        deck.step(step)?;
    }
    Ok(deck)
}

type Name = Spanned<String>;

fn refuse(code: Code, span: Span, message: String, label: &str, remedy: &str) -> Diagnostic {
    Diagnostic::error(code, span, message, label).help(remedy)
}

fn has_control(text: &str) -> bool {
    text.chars().any(char::is_control)
}

/// A name as a deck writes it: between quotation marks if it would not be the same without them.
fn quoted(name: &Name) -> Result<String> {
    let text = name.value.as_str();
    if text.is_empty() || text.contains('"') || has_control(text) || text.trim() != text {
        let message = format!("`{}` is not a name", text.escape_debug());
        return Err(refuse(
            Code::MalformedName,
            name.span,
            message,
            "not a name",
            "a name has no quotation marks, no line breaks, and no blanks at its ends",
        ));
    }
    let numeric = text.starts_with(|letter: char| letter.is_ascii_digit() || "+-.".contains(letter));
    let plain = normal(text) == text && !numeric && !text.contains([',', '=', '*', '.']);
    Ok(if plain { text.to_owned() } else { format!("\"{text}\"") })
}

/// A word of our choice, which must not break the line.
fn plain(text: &Name, what: &str) -> Result<String> {
    let bad =
        has_control(&text.value) || text.value.contains([',', '"', '*', '=']) || text.value.trim().is_empty();
    if bad {
        let message = format!("`{}` is not {what}", text.value.escape_debug());
        return Err(refuse(Code::BadValue, text.span, message, "not a word", "write a word"));
    }
    Ok(text.value.trim().to_owned())
}

fn on_off(on: bool) -> &'static str {
    if on { "ON" } else { "OFF" }
}

fn yes_no(yes: bool) -> &'static str {
    if yes { "YES" } else { "NO" }
}

impl Deck {
    // Lines and their items.

    fn item(&mut self, text: &str, span: Span) {
        self.text.push_str(if self.begun { ", " } else { "" });
        self.text.push_str(text);
        self.places.item(span);
        self.begun = true;
    }

    fn end(&mut self, comma: bool) {
        self.text.push_str(if comma { ",\n" } else { "\n" });
        self.begun = false;
    }

    fn begin(&mut self, span: Span) {
        self.places.line(span);
    }

    fn keyword(&mut self, name: &str, span: Span) {
        self.begin(span);
        self.item(&format!("*{name}"), span);
    }

    /// The end of a keyword line.
    fn go(&mut self) {
        self.end(false);
    }

    fn flag(&mut self, name: &str, set: bool, span: Span) {
        if set {
            self.item(name, span);
        }
    }

    fn parameter(&mut self, name: &str, value: impl std::fmt::Display, span: Span) {
        self.item(&format!("{name}={value}"), span);
    }

    fn word<C: Choice>(&mut self, name: &str, choice: Option<C>, span: Span) {
        if let Some(choice) = choice {
            self.parameter(name, choice.spelling(), span);
        }
    }

    fn name(&mut self, parameter: &str, name: &Name) -> Result<()> {
        self.parameter(parameter, quoted(name)?, name.span);
        Ok(())
    }

    fn maybe_name(&mut self, parameter: &str, name: Option<&Name>) -> Result<()> {
        name.map_or(Ok(()), |name| self.name(parameter, name))
    }

    fn number_of(&mut self, parameter: &str, value: Option<Spanned<f64>>) {
        if let Some(value) = value {
            self.parameter(parameter, number(value.value), value.span);
        }
    }

    fn count_of(&mut self, parameter: &str, value: Option<Spanned<u64>>) {
        if let Some(value) = value {
            self.parameter(parameter, value.value, value.span);
        }
    }

    fn component_of(&mut self, component: Option<Spanned<form::Component>>) {
        if let Some(component) = component {
            self.parameter("COMPONENT", component.value.0, component.span);
        }
    }

    fn options(&mut self, (extrapolation, regularize, rtol): Options, span: Span) {
        self.word("EXTRAPOLATION", extrapolation, span);
        if let Some(regularize) = regularize {
            self.parameter("REGULARIZE", on_off(regularize), span);
        }
        self.number_of("RTOL", rtol);
    }

    fn dependencies(&mut self, count: usize, span: Span) {
        if count > 0 {
            self.parameter("DEPENDENCIES", count, span);
        }
    }

    fn number(&mut self, value: f64, span: Span) {
        self.item(&number(value), span);
    }

    fn numbers(&mut self, values: &[f64], span: Span) {
        for value in values {
            self.number(*value, span);
        }
    }

    fn maybe(&mut self, item: Option<f64>, span: Span) {
        self.item(&item.map(number).unwrap_or_default(), span);
    }

    /// A record of `width` items, eight on a line. Trailing empty ones of the last line are left out.
    fn record(&mut self, values: &[(Option<f64>, Span)], width: usize, span: Span) {
        let lines = width.max(values.len()).div_ceil(PER_LINE).max(1);
        for line in 0..lines {
            let rest = values.get(line * PER_LINE..).unwrap_or_default();
            // What is too much stands on the last line, where the reader finds it.
            let here = if line + 1 == lines { rest.len() } else { rest.len().min(PER_LINE) };
            let here = rest.get(..here).unwrap_or_default();
            let last = here.iter().rposition(|(value, _)| value.is_some()).map_or(0, |last| last + 1);
            self.begin(here.first().map_or(span, |(_, span)| *span));
            for (value, span) in here.iter().take(last) {
                self.maybe(*value, *span);
            }
            self.end(last == 0 || here.get(last - 1).is_some_and(|(value, _)| value.is_none()));
        }
    }

    /// A row as it is written.
    fn raw(&mut self, row: &Spanned<Vec<Spanned<Item>>>, width: usize) {
        let values: Vec<_> = row.value.iter().map(|item| (item.value.0, item.span)).collect();
        self.record(&values, width, row.span);
    }

    fn raws(&mut self, rows: &[Spanned<Vec<Spanned<Item>>>], width: usize) {
        for row in rows {
            self.raw(row, width);
        }
    }

    /// Rows of `columns` columns, with temperature and fields.
    fn rows(&mut self, rows: &[Spanned<Row>], columns: usize) -> Result<()> {
        let fields = fields(rows);
        for row in rows {
            let Row { values, temperature, fields: own } = &row.value;
            if values.len() > columns {
                let span = values.get(columns).map_or(row.span, |item| item.span);
                let message = format!("a row of {} numbers, where there are {columns} columns", values.len());
                return Err(refuse(
                    Code::SurplusData,
                    span,
                    message,
                    "too many",
                    "give a temperature and field variables as {values = […], temperature = …, fields = […]}",
                ));
            }
            let mut record: Vec<_> = values.iter().map(|item| (item.value.0, item.span)).collect();
            record.resize(columns, (None, row.span));
            record.push((temperature.map(|value| value.value), row.span));
            record.extend(own.iter().map(|item| (item.value.0, item.span)));
            self.record(&record, columns + 1 + fields, row.span);
        }
        Ok(())
    }

    fn components(&mut self, components: &[Spanned<form::Component>], span: Span) {
        self.begin(components.first().map_or(span, |component| component.span));
        for component in components {
            self.item(&component.value.0.to_string(), component.span);
        }
        self.end(components.is_empty());
    }

    fn target(&mut self, target: &Spanned<Target>) -> Result<()> {
        let text = match &target.value {
            Target::Number(number) => number.to_string(),
            Target::Text(text) => label_or_name(text, target.span)?,
        };
        self.item(&text, target.span);
        Ok(())
    }

    // The parts of a scene.

    fn heading(&mut self, heading: &Name) -> Result<()> {
        if heading.value.is_empty() {
            return Ok(());
        }
        self.keyword("HEADING", heading.span);
        self.go();
        for line in heading.value.lines() {
            if line.trim_start().starts_with('*') || has_control(line) {
                let message = format!("the heading has the line `{}`", line.escape_debug());
                return Err(refuse(
                    Code::BadValue,
                    heading.span,
                    message,
                    "no line of a heading",
                    "its lines do not begin with an asterisk, which in a deck begins a keyword",
                ));
            }
            self.begin(heading.span);
            self.item(line.trim(), heading.span);
            self.end(false);
        }
        Ok(())
    }

    fn mesh(&mut self, document: &Document) -> Result<()> {
        let instances = instances(document);
        if instances.is_empty() {
            self.level(document, None, &mut Written::default(), &mut Written::default())?;
        } else {
            self.assembly(document, &instances)?;
        }
        self.sets("NSET", &document.node_sets)?;
        self.sets("ELSET", &document.element_sets)?;
        for (name, orientation) in &document.orientations.0 {
            self.orientation(name, orientation)?;
        }
        for transform in &document.transforms {
            self.keyword("TRANSFORM", transform.span);
            self.name("NSET", &transform.value.node_set)?;
            self.word("TYPE", transform.value.kind, transform.span);
            self.go();
            self.begin(transform.value.a.span);
            self.numbers(&transform.value.a.value, transform.value.a.span);
            self.numbers(&transform.value.b.value, transform.value.b.span);
            self.end(false);
        }
        Ok(())
    }

    /// A node or element number that names an entry; within its instance that is a number alone.
    fn key(&mut self, label: &Name) {
        let text = label_of(label).map(|label| label.number().to_string());
        let text = text.unwrap_or_else(|| {
            // What is no label must not become another line; the reader of decks says what is wrong with it.
            label.value.escape_debug().to_string().replace([',', '*'], " ")
        });
        self.item(if text.trim().is_empty() { "\"\"" } else { text.trim() }, label.span);
    }

    /// A part for every instance, already in its place; then the assembly, which its caller ends.
    fn assembly(&mut self, document: &Document, instances: &IndexMap<Instance, Span>) -> Result<()> {
        for (instance, span) in instances {
            self.block("PART", "NAME", instance.name(), *span)?;
            let own = Some(*instance);
            self.level(document, own, &mut Written::default(), &mut Written::default())?;
            self.keyword("END PART", *span);
            self.go();
        }
        self.keyword("ASSEMBLY", Span::default());
        self.parameter("NAME", "ASSEMBLY", Span::default());
        self.go();
        let (mut nodes, mut elements) = (Written::default(), Written::default());
        for (instance, span) in instances {
            let before =
                |label: &Name| label_of(label).is_some_and(|label| label.instance() == Some(*instance));
            nodes.until = document.nodes.0.iter().position(|(label, _)| before(label)).unwrap_or(0);
            elements.until = document.connectors.0.iter().position(|(label, _)| before(label)).unwrap_or(0);
            self.level(document, None, &mut nodes, &mut elements)?;
            let name = Spanned::new(instance.name().to_owned(), *span);
            self.keyword("INSTANCE", *span);
            self.name("NAME", &name)?;
            self.name("PART", &name)?;
            self.go();
            self.keyword("END INSTANCE", *span);
            self.go();
        }
        (nodes.until, elements.until) = (usize::MAX, usize::MAX);
        self.level(document, None, &mut nodes, &mut elements)
    }

    fn block(&mut self, keyword: &str, parameter: &str, name: &str, span: Span) -> Result<()> {
        self.keyword(keyword, span);
        self.name(parameter, &Spanned::new(name.to_owned(), span))?;
        self.go();
        Ok(())
    }

    /// The nodes and elements of an instance, or of none, that are not written yet.
    fn level(
        &mut self,
        document: &Document,
        instance: Option<Instance>,
        nodes: &mut Written,
        elements: &mut Written,
    ) -> Result<()> {
        let here = |label: &Name| label_of(label).and_then(Label::instance) == instance;
        let mut open = false;
        for (label, point) in nodes.next(&document.nodes.0).iter().filter(|(label, _)| here(label)) {
            if !open {
                self.keyword("NODE", label.span);
                self.go();
                open = true;
            }
            self.begin(label.span);
            self.key(label);
            for coordinate in &point.value.0 {
                self.number(coordinate.value, coordinate.span);
            }
            self.end(false);
        }
        let mut open: Option<Dimension> = None;
        let connectors = elements.next(&document.connectors.0);
        for (label, connector) in connectors.iter().filter(|(label, _)| here(label)) {
            let dimension = connector.value.dimension.unwrap_or(Dimension::Three);
            if open != Some(dimension) {
                self.keyword("ELEMENT", label.span);
                self.parameter("TYPE", dimension.spelling(), label.span);
                self.go();
                open = Some(dimension);
            }
            self.begin(label.span);
            self.key(label);
            for end in [&connector.value.a, &connector.value.b] {
                match end {
                    Some(node) => self.node_of(node, label, instance)?,
                    None => self.item("", label.span),
                }
            }
            self.end(connector.value.b.is_none());
        }
        // Point elements of the assembly come last: nothing depends on their order among the connectors.
        let points = if elements.until == usize::MAX { document.point_elements.0.as_slice() } else { &[] };
        let mut open: Option<PointKind> = None;
        for (label, element) in points.iter().filter(|(label, _)| here(label)) {
            if open != Some(element.value.kind) {
                self.keyword("ELEMENT", label.span);
                self.parameter("TYPE", element.value.kind.name(), label.span);
                self.go();
                open = Some(element.value.kind);
            }
            self.begin(label.span);
            self.key(label);
            for node in &element.value.nodes {
                self.node_of(node, label, instance)?;
            }
            self.end(false);
        }
        Ok(())
    }

    /// A node of an element: within an instance its number, for there it can be no other's.
    fn node_of(&mut self, node: &Spanned<Target>, element: &Name, instance: Option<Instance>) -> Result<()> {
        let Some(instance) = instance else { return self.target(node) };
        match node.value.to_string().parse::<Label>() {
            Ok(label) if label.instance() == Some(instance) => {
                self.item(&label.number().to_string(), node.span);
                Ok(())
            }
            _ => {
                let message = format!(
                    "element {} belongs to instance {instance}, and its node {} does not",
                    element.value.escape_debug(),
                    node.value.to_string().escape_debug()
                );
                let remedy = "call the element by a number alone, or name a node of the instance";
                Err(refuse(Code::BadConnectivity, node.span, message, "of another instance", remedy))
            }
        }
    }

    fn sets(&mut self, keyword: &str, sets: &Entries<Vec<Spanned<Member>>>) -> Result<()> {
        for (name, members) in &sets.0 {
            let mut open = false;
            let ascending = members.iter().map(|member| match &member.value {
                Member::One(target) => target.to_string().parse().ok(),
                Member::Range(_) => None,
            });
            let ascending: Option<Vec<Label>> = ascending.collect();
            let unsorted = ascending.is_none_or(|labels| !labels.is_sorted());
            let start = |deck: &mut Self, generate: bool| -> Result<()> {
                deck.keyword(keyword, name.span);
                deck.name(keyword, name)?;
                deck.flag("GENERATE", generate, name.span);
                deck.flag("UNSORTED", unsorted && !generate, name.span);
                deck.go();
                Ok(())
            };
            let mut on_line = 0;
            let mut generating = None;
            for member in members {
                let generate = matches!(member.value, Member::Range(_));
                if generating != Some(generate) {
                    if on_line > 0 {
                        self.end(false);
                        on_line = 0;
                    }
                    start(self, generate)?;
                    (generating, open) = (Some(generate), true);
                }
                match &member.value {
                    Member::Range(range) => {
                        self.begin(member.span);
                        self.item(&range.first.value.to_string(), range.first.span);
                        self.item(&range.last.value.to_string(), range.last.span);
                        if let Some(step) = range.step {
                            self.item(&step.value.to_string(), step.span);
                        }
                        self.end(false);
                    }
                    Member::One(target) => {
                        if on_line == 0 {
                            self.begin(member.span);
                        }
                        self.target(&Spanned::new(target.clone(), member.span))?;
                        on_line += 1;
                        if on_line == MEMBERS_PER_LINE {
                            self.end(false);
                            on_line = 0;
                        }
                    }
                }
            }
            if on_line > 0 {
                self.end(false);
            }
            if !open {
                start(self, false)?;
            }
        }
        Ok(())
    }

    fn orientation(&mut self, name: &Name, orientation: &Spanned<form::Orientation>) -> Result<()> {
        let span = name.span;
        let form::Orientation { system, definition, a, b, c, axis, angle } = &orientation.value;
        self.keyword("ORIENTATION", span);
        self.name("NAME", name)?;
        self.word("SYSTEM", *system, span);
        if let Some(definition) = definition {
            let definition = match definition {
                form::Definition::Coordinates => "COORDINATES",
                form::Definition::Nodes => "NODES",
                form::Definition::OffsetToNodes => "OFFSET TO NODES",
            };
            self.parameter("DEFINITION", definition, span);
        }
        self.go();
        if *system == Some(System::User) {
            if let Some(point) = [a, b, c].into_iter().flatten().next() {
                let message = "an orientation of a user subroutine has no points".to_owned();
                return Err(refuse(
                    Code::SurplusData,
                    point.span,
                    message,
                    "not used",
                    "leave the point out",
                ));
            }
        } else {
            let nodes = definition.is_some_and(|definition| definition != form::Definition::Coordinates);
            for (point, which) in [(a, 'a'), (b, 'b')] {
                if point.is_none() {
                    let message = format!("orientation {} has no point {which}", name.value);
                    let remedy = format!("give point {which}");
                    return Err(refuse(Code::MissingData, span, message, "this orientation", &remedy));
                }
            }
            self.begin(a.as_ref().map_or(span, |a| a.span));
            for point in [a, b, c].into_iter().flatten() {
                match &point.value {
                    PointOrNode::Point(coordinates) if !nodes => {
                        for coordinate in coordinates {
                            self.number(coordinate.value, coordinate.span);
                        }
                    }
                    PointOrNode::Node(node) if nodes => {
                        self.target(&Spanned::new(node.clone(), point.span))?;
                    }
                    _ => {
                        let (message, remedy) = if nodes {
                            (
                                "coordinates, where a node is wanted",
                                "give a node, or leave the definition out",
                            )
                        } else {
                            (
                                "a node, where coordinates are wanted",
                                "give three coordinates, or definition = \"nodes\"",
                            )
                        };
                        return Err(refuse(
                            Code::BadValue,
                            point.span,
                            message.to_owned(),
                            "not of this kind",
                            remedy,
                        ));
                    }
                }
            }
            self.end(false);
        }
        if axis.is_some() || angle.is_some() {
            self.begin(span);
            let axis = axis.unwrap_or(Spanned::new(1, span));
            self.item(&axis.value.to_string(), axis.span);
            if let Some(angle) = angle {
                self.number(angle.value, angle.span);
            }
            self.end(false);
        }
        Ok(())
    }

    fn properties(&mut self, document: &Document) -> Result<()> {
        for section in &document.connector_sections {
            self.section(section)?;
        }
        for mpc in &document.mpcs {
            let form::Mpc { r#type, nodes, user } = &mpc.value;
            self.keyword("MPC", mpc.span);
            self.flag("USER", *user, mpc.span);
            self.go();
            self.begin(mpc.span);
            self.item(&plain(r#type, "a type of constraints")?, r#type.span);
            for (place, node) in nodes.iter().enumerate() {
                if place > 0 && place % NODES_PER_LINE == 0 && !user {
                    self.end(false);
                    self.begin(node.span);
                    self.item("0", node.span);
                }
                self.target(node)?;
            }
            self.end(false);
        }
        for mass in &document.masses {
            self.keyword("MASS", mass.span);
            self.name("ELSET", &mass.value.element_set)?;
            self.go();
            self.begin(mass.value.mass.span);
            self.number(mass.value.mass.value, mass.value.mass.span);
            self.end(false);
        }
        for inertia in &document.rotary_inertias {
            self.keyword("ROTARY INERTIA", inertia.span);
            self.name("ELSET", &inertia.value.element_set)?;
            self.maybe_name("ORIENTATION", inertia.value.orientation.as_ref())?;
            self.go();
            self.begin(inertia.value.inertia.span);
            self.numbers(&inertia.value.inertia.value, inertia.value.inertia.span);
            self.end(false);
        }
        for (keyword, list) in [("SPRING", &document.springs), ("DASHPOT", &document.dashpots)] {
            for discrete in list {
                self.discrete(keyword, discrete)?;
            }
        }
        Ok(())
    }

    fn discrete(&mut self, keyword: &str, discrete: &Spanned<form::Discrete>) -> Result<()> {
        let span = discrete.span;
        let value = &discrete.value;
        let width = 3 + dependencies(value.dependencies);
        self.keyword(keyword, span);
        self.name("ELSET", &value.element_set)?;
        self.flag("NONLINEAR", value.nonlinear, span);
        self.maybe_name("ORIENTATION", value.orientation.as_ref())?;
        self.flag("COMPLEX STIFFNESS", value.complex, span);
        self.count_of("DEPENDENCIES", value.dependencies);
        self.go();
        self.begin(value.degrees_of_freedom.first().map_or(span, |freedom| freedom.span));
        for freedom in &value.degrees_of_freedom {
            self.item(&freedom.value.to_string(), freedom.span);
        }
        self.end(false);
        self.raws(&value.rows, width);
        Ok(())
    }

    fn section(&mut self, section: &Spanned<form::ConnectorSection>) -> Result<()> {
        let span = section.span;
        let form::ConnectorSection {
            element_set,
            r#type,
            behavior,
            orientation_a,
            orientation_b,
            data,
            controls,
            elimination,
        } = &section.value;
        self.keyword("CONNECTOR SECTION", span);
        self.name("ELSET", element_set)?;
        self.maybe_name("BEHAVIOR", behavior.as_ref())?;
        self.maybe_name("CONTROLS", controls.as_ref())?;
        if let Some(elimination) = elimination {
            self.parameter("ELIMINATION", yes_no(*elimination), span);
        }
        self.go();
        self.begin(span);
        for name in &r#type.0 {
            self.item(&plain(name, "a connection type")?, name.span);
        }
        self.end(false);
        if orientation_a.is_some() || orientation_b.is_some() || !data.is_empty() {
            self.begin(span);
            for (place, orientation) in [orientation_a, orientation_b].into_iter().enumerate() {
                match orientation {
                    Some(name) => self.item(&quoted(name)?, name.span),
                    None if place == 0 && orientation_b.is_some() => self.item("", span),
                    None => {}
                }
            }
            self.end(false);
        }
        if !data.is_empty() {
            self.begin(span);
            for item in data {
                self.maybe(item.value.0, item.span);
            }
            self.end(true);
        }
        Ok(())
    }

    fn amplitude(&mut self, name: &Name, amplitude: &Spanned<form::Amplitude>) -> Result<()> {
        let span = name.span;
        let form::Amplitude { definition, time, value, smooth, fixed_interval, begin, pairs, data } =
            &amplitude.value;
        self.keyword("AMPLITUDE", span);
        self.name("NAME", name)?;
        self.word("DEFINITION", *definition, span);
        self.word("TIME", *time, span);
        self.word("VALUE", *value, span);
        self.number_of("SMOOTH", *smooth);
        self.number_of("FIXED INTERVAL", *fixed_interval);
        self.number_of("BEGIN", *begin);
        self.go();
        let takes_pairs = definition.is_none_or(|definition| definition.has_pairs());
        if let Some(item) = data.first().filter(|_| takes_pairs) {
            let message = format!("amplitude {} takes pairs of time and value", name.value);
            let remedy = "write pairs = [[time, value], …]";
            return Err(refuse(Code::BadValue, item.span, message, "not pairs", remedy));
        }
        if let Some(pair) = pairs.first().filter(|_| !takes_pairs) {
            let message = format!("amplitude {} takes no pairs", name.value);
            return Err(refuse(Code::BadValue, pair.span, message, "not used", "write data = [numbers]"));
        }
        let pairs = pairs.iter().flat_map(|pair| pair.value).map(|number| (Some(number.value), number.span));
        let data = data.iter().map(|item| (item.value.0, item.span));
        let items: Vec<_> = pairs.chain(data).collect();
        for line in items.chunks(PER_LINE) {
            self.begin(line.first().map_or(span, |(_, span)| *span));
            for (value, span) in line {
                self.maybe(*value, *span);
            }
            self.end(line.last().is_some_and(|(value, _)| value.is_none()));
        }
        Ok(())
    }

    fn behavior(&mut self, name: &Name, behavior: &Spanned<Behavior>) -> Result<()> {
        let span = name.span;
        let value = &behavior.value;
        self.keyword("CONNECTOR BEHAVIOR", span);
        self.name("NAME", name)?;
        self.word("INTEGRATION", value.integration, span);
        self.options(value.options(), span);
        self.go();
        self.constitutive_reference(&value.constitutive_reference)?;
        for (name, terms) in &value.derived_components.0 {
            for term in terms {
                self.derived_term(name, term)?;
            }
        }
        for law in &value.elasticity {
            if let Some(span) = law.value.r#type.map(|_| law.span) {
                let message = "an elasticity has no type".to_owned();
                return Err(refuse(
                    Code::SceneUnknownField,
                    span,
                    message,
                    "not a field here",
                    "remove it, or move it to damping",
                ));
            }
            self.law("CONNECTOR ELASTICITY", law)?;
        }
        for law in &value.damping {
            self.law("CONNECTOR DAMPING", law)?;
        }
        for friction in &value.friction {
            self.friction(friction)?;
        }
        for plasticity in &value.plasticity {
            self.plasticity(plasticity)?;
        }
        for damage in &value.damage {
            self.damage(damage)?;
        }
        for stop in &value.stops {
            self.keyword("CONNECTOR STOP", stop.span);
            self.component_of(Some(stop.value.component));
            self.go();
            let at = |value: Option<Spanned<f64>>| {
                (value.map(|value| value.value), value.map_or(stop.span, |value| value.span))
            };
            self.begin(stop.span);
            let limits = [at(stop.value.lower), at(stop.value.upper)];
            for (value, span) in limits {
                self.maybe(value, span);
            }
            self.end(true);
        }
        for (keyword, parameter, list) in
            [("CONNECTOR LOCK", "LOCK", &value.locks), ("CONNECTOR FAILURE", "RELEASE", &value.failures)]
        {
            for lock in list {
                self.lock(keyword, parameter, lock)?;
            }
        }
        Ok(())
    }

    fn constitutive_reference(&mut self, reference: &Entries<Spanned<f64>>) -> Result<()> {
        let Some((first, _)) = reference.0.first() else { return Ok(()) };
        let mut values = [None; 6];
        for (component, value) in &reference.0 {
            let place = component.value.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
            let Some(place) = place.and_then(|place| values.get_mut(place)) else {
                let message = format!("there is no component `{}`", component.value);
                return Err(refuse(
                    Code::BadComponent,
                    component.span,
                    message,
                    "must be 1 to 6",
                    "write for example 1 = 0.5 for a length, 4 = 90 for an angle in degrees",
                ));
            };
            *place = Some(*value);
        }
        self.keyword("CONNECTOR CONSTITUTIVE REFERENCE", first.span);
        self.go();
        self.begin(first.span);
        for value in values {
            self.maybe(value.map(|value| value.value), value.map_or(first.span, |value| value.span));
        }
        self.end(true);
        Ok(())
    }

    fn independent(&mut self, independent: Option<&Independent>, span: Span) {
        if let Some(independent) = independent {
            self.word("INDEPENDENT COMPONENTS", Some(independent.basis), span);
        }
    }

    fn law(&mut self, keyword: &str, law: &Spanned<Law>) -> Result<()> {
        let span = law.span;
        let value = &law.value;
        self.keyword(keyword, span);
        self.component_of(value.component);
        self.word("TYPE", value.r#type, span);
        self.flag("NONLINEAR", value.nonlinear, span);
        self.flag("RIGID", value.rigid, span);
        self.flag("UNSYMM", value.unsymmetric, span);
        self.flag("FREQUENCY DEPENDENCE", value.frequency_dependence, span);
        self.independent(value.independent.as_ref(), span);
        self.dependencies(fields(&value.rows), span);
        self.options(value.options(), span);
        self.go();
        if let Some(component) = value.components.first().filter(|_| !value.rigid) {
            let message = "components are listed for what is not rigid".to_owned();
            let remedy = "write component = …, or rigid = true";
            return Err(refuse(Code::ConflictingParameters, component.span, message, "not used", remedy));
        }
        if !value.components.is_empty() {
            self.components(&value.components, span);
        }
        if let Some(independent) = &value.independent {
            self.components(&independent.components, span);
        }
        let columns = match (value.nonlinear, value.component) {
            (true, _) => {
                let listed = value.independent.as_ref().map_or(0, |independent| independent.components.len());
                let own = value.independent.is_none() || keyword == "CONNECTOR DAMPING";
                1 + usize::from(own) + listed
            }
            (false, Some(_)) => 2,
            (false, None) => {
                let terms = if value.unsymmetric { 36 } else { 21 };
                terms + usize::from(value.frequency_dependence)
            }
        };
        self.rows(&value.rows, columns)
    }

    fn derived_term(&mut self, name: &Name, term: &Spanned<form::DerivedTerm>) -> Result<()> {
        let span = term.span;
        let value = &term.value;
        self.keyword("CONNECTOR DERIVED COMPONENT", span);
        self.name("NAME", name)?;
        self.word("OPERATOR", value.operator, span);
        if value.negative {
            self.parameter("SIGN", "NEGATIVE", span);
        }
        self.independent(value.independent.as_ref(), span);
        self.dependencies(fields(&value.rows), span);
        self.options(value.options(), span);
        self.go();
        self.components(&value.components, span);
        let mut columns = value.components.len();
        if let Some(independent) = &value.independent {
            self.components(&independent.components, span);
            columns += independent.components.len();
        }
        self.rows(&value.rows, columns)
    }

    fn source(source: &Spanned<Source>) -> Result<String> {
        match &source.value {
            Source::Component(component) => Ok(component.to_string()),
            Source::Derived(name) => quoted(&Spanned::new(name.clone(), source.span)),
        }
    }

    fn friction(&mut self, friction: &Spanned<Friction>) -> Result<()> {
        let span = friction.span;
        let value = &friction.value;
        self.keyword("CONNECTOR FRICTION", span);
        self.flag("PREDEFINED", value.predefined.is_some(), span);
        self.component_of(value.component);
        if let Some(force) = &value.contact_force {
            self.parameter("CONTACT FORCE", Self::source(force)?, force.span);
        }
        self.number_of("STICK STIFFNESS", value.stick_stiffness);
        self.independent(value.independent.as_ref(), span);
        self.count_of("DEPENDENCIES", value.dependencies);
        self.options(value.options(), span);
        self.go();
        if let Some(constants) = &value.predefined {
            if !constants.value.is_empty() {
                self.begin(constants.span);
                for item in &constants.value {
                    self.maybe(item.value.0, item.span);
                }
                self.end(true);
            }
            if let Some(row) = value.rows.first() {
                let message = "a predefined friction has no rows".to_owned();
                let remedy = "remove the rows, or `predefined`";
                return Err(refuse(Code::ConflictingParameters, row.span, message, "not used", remedy));
            }
        }
        let mut width = 4 + dependencies(value.dependencies);
        if let Some(independent) = &value.independent {
            self.components(&independent.components, span);
            width += independent.components.len();
        }
        self.raws(&value.rows, width);
        if let Some(potential) = &value.potential {
            self.potential(potential)?;
        }
        value.coefficient.as_ref().map_or(Ok(()), |coefficient| self.coefficient(coefficient))
    }

    fn coefficient(&mut self, coefficient: &Spanned<form::Coefficient>) -> Result<()> {
        let span = coefficient.span;
        let form::Coefficient { rows, exponential, test_data, maximum, slip_tolerance, elastic_slip } =
            &coefficient.value;
        let given = [!rows.is_empty(), exponential.is_some(), !test_data.is_empty()];
        if given.iter().filter(|given| **given).count() != 1 {
            let message = "a friction coefficient is given in one of three ways".to_owned();
            let remedy = "give either rows, or exponential, or test_data";
            return Err(refuse(Code::ConflictingParameters, span, message, "this coefficient", remedy));
        }
        self.keyword("FRICTION", span);
        self.flag("EXPONENTIAL DECAY", exponential.is_some() || !test_data.is_empty(), span);
        self.flag("TEST DATA", !test_data.is_empty(), span);
        self.number_of("TAUMAX", *maximum);
        self.number_of("SLIP TOLERANCE", *slip_tolerance);
        self.number_of("ELASTIC SLIP", *elastic_slip);
        self.dependencies(fields(rows), span);
        self.go();
        if let Some(exponential) = exponential {
            self.begin(exponential.span);
            self.numbers(&exponential.value, exponential.span);
            self.end(false);
        }
        self.raws(test_data, 3);
        self.rows(rows, 3)
    }

    fn potential(&mut self, potential: &Spanned<Potential>) -> Result<()> {
        let Potential { terms, operator, exponent } = &potential.value;
        self.keyword("CONNECTOR POTENTIAL", potential.span);
        self.word("OPERATOR", *operator, potential.span);
        self.number_of("EXPONENT", *exponent);
        self.go();
        for term in terms {
            let span = term.span;
            let form::PotentialTerm { of, scale, exponent, function, shift, sign } = &term.value;
            self.begin(of.span);
            self.item(&Self::source(of)?, of.span);
            let number = |deck: &mut Self, value: &Option<Spanned<f64>>| {
                deck.maybe(value.map(|value| value.value), value.map_or(span, |value| value.span));
            };
            number(self, scale);
            number(self, exponent);
            self.item(function.map_or("", Choice::spelling), span);
            number(self, shift);
            number(self, sign);
            self.end(true);
        }
        Ok(())
    }

    fn plasticity(&mut self, plasticity: &Spanned<Plasticity>) -> Result<()> {
        self.keyword("CONNECTOR PLASTICITY", plasticity.span);
        self.component_of(plasticity.value.component);
        self.go();
        if let Some(potential) = &plasticity.value.potential {
            self.potential(potential)?;
        }
        plasticity.value.hardening.iter().try_for_each(|hardening| self.hardening(hardening))
    }

    fn hardening(&mut self, hardening: &Spanned<Hardening>) -> Result<()> {
        let span = hardening.span;
        let value = &hardening.value;
        self.keyword("CONNECTOR HARDENING", span);
        self.word("TYPE", value.r#type, span);
        self.word("DEFINITION", value.definition, span);
        self.number_of("RATE FILTER FACTOR", value.rate_filter);
        self.word("RATE INTERPOLATION", value.rate_interpolation, span);
        self.dependencies(fields(&value.rows), span);
        self.options(value.options(), span);
        self.go();
        let definition = value.definition.unwrap_or_else(|| value.r#type.unwrap_or_default().definition());
        self.rows(&value.rows, definition.columns().len())
    }

    fn damage(&mut self, damage: &Spanned<Damage>) -> Result<()> {
        let span = damage.span;
        let value = &damage.value;
        self.keyword("CONNECTOR DAMAGE INITIATION", span);
        self.component_of(value.component);
        self.word("CRITERION", value.criterion, span);
        self.number_of("RATE FILTER FACTOR", value.rate_filter);
        self.word("RATE INTERPOLATION", value.rate_interpolation, span);
        self.count_of("DEPENDENCIES", value.dependencies);
        self.options(value.options(), span);
        self.go();
        self.raws(&value.rows, 4 + dependencies(value.dependencies));
        if let Some(potential) = &value.potential {
            self.potential(potential)?;
        }
        let Some(evolution) = &value.evolution else { return Ok(()) };
        let span = evolution.span;
        let value = &evolution.value;
        self.keyword("CONNECTOR DAMAGE EVOLUTION", span);
        self.word("TYPE", value.r#type, span);
        self.word("SOFTENING", value.softening, span);
        self.word("DEGRADATION", value.degradation, span);
        self.flag("AFFECTED COMPONENTS", !value.affected.is_empty(), span);
        self.count_of("DEPENDENCIES", value.dependencies);
        self.options(value.options(), span);
        self.go();
        if !value.affected.is_empty() {
            self.components(&value.affected, span);
        }
        self.raws(&value.rows, 4 + dependencies(value.dependencies));
        value.potential.as_ref().map_or(Ok(()), |potential| self.potential(potential))
    }

    fn lock(&mut self, keyword: &str, parameter: &str, lock: &Spanned<Lock>) -> Result<()> {
        let span = lock.span;
        let value = &lock.value;
        let fields = value.limits.iter().map(|limits| limits.value.fields.len()).max().unwrap_or(0);
        self.keyword(keyword, span);
        self.component_of(Some(value.component));
        if let Some(affected) = value.affected {
            self.parameter(parameter, affected.value.0, affected.span);
        }
        self.dependencies(fields, span);
        self.options(value.options(), span);
        self.go();
        for limits in &value.limits {
            let form::Limits {
                lower_position,
                upper_position,
                lower_force,
                upper_force,
                temperature,
                fields: own,
            } = &limits.value;
            let at = |value: &Option<Spanned<f64>>| {
                (value.map(|value| value.value), value.map_or(limits.span, |value| value.span))
            };
            let mut record = vec![
                at(lower_position),
                at(upper_position),
                at(lower_force),
                at(upper_force),
                at(temperature),
            ];
            record.extend(own.iter().map(|item| (item.value.0, item.span)));
            self.record(&record, 5 + fields, limits.span);
        }
        Ok(())
    }

    fn actuation(
        &mut self,
        boundaries: &[Spanned<Boundary>],
        motions: &[Spanned<form::ConnectorMotion>],
    ) -> Result<()> {
        for boundary in boundaries {
            self.boundary(boundary)?;
        }
        for motion in motions {
            let span = motion.span;
            let value = &motion.value;
            self.keyword("CONNECTOR MOTION", span);
            self.motion_type(value.r#type, span);
            self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
            self.flag("FIXED", value.fixed, span);
            self.flag("USER", value.user, span);
            self.flag("IMAGINARY", value.imaginary, span);
            self.go();
            self.begin(span);
            self.target(&value.target)?;
            self.item(&value.component.value.0.to_string(), value.component.span);
            if let Some(magnitude) = value.magnitude {
                self.number(magnitude.value, magnitude.span);
            }
            self.end(false);
        }
        Ok(())
    }

    fn motion_type(&mut self, kind: Option<MotionType>, span: Span) {
        self.word("TYPE", kind, span);
    }

    fn applied(
        &mut self,
        amplitude: Option<&Name>,
        operation: Option<Operation>,
        load_case: Option<Spanned<u64>>,
        span: Span,
    ) -> Result<()> {
        self.maybe_name("AMPLITUDE", amplitude)?;
        self.word("OP", operation, span);
        self.count_of("LOAD CASE", load_case);
        Ok(())
    }

    fn boundary(&mut self, boundary: &Spanned<Boundary>) -> Result<()> {
        let span = boundary.span;
        let value = &boundary.value;
        self.keyword("BOUNDARY", span);
        self.motion_type(value.r#type, span);
        self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
        self.flag("FIXED", value.fixed, span);
        self.flag("USER", value.user, span);
        self.go();
        let held: Vec<u64> = value.degrees_of_freedom.iter().map(|freedom| freedom.value).collect();
        let Some(first) = value.degrees_of_freedom.first() else {
            let message = "a boundary condition without a degree of freedom".to_owned();
            let remedy = "list degrees of freedom, 1 to 6 or 10";
            return Err(refuse(Code::MissingData, span, message, "holds nothing", remedy));
        };
        let named = NAMED.iter().find(|(_, freedoms)| {
            freedoms.iter().map(|freedom| u64::from(*freedom)).eq(held.iter().copied())
        });
        let following = |a: u64, b: u64| b == a + 1 || (a, b) == (6, 10);
        let run = held.windows(2).all(|pair| matches!(pair, [a, b] if following(*a, *b)));
        let runs: Vec<&[Spanned<u64>]> = if run || (named.is_some() && value.magnitude.is_none()) {
            vec![value.degrees_of_freedom.as_slice()]
        } else {
            value.degrees_of_freedom.chunk_by(|a, b| following(a.value, b.value)).collect()
        };
        for freedoms in runs {
            self.begin(span);
            self.target(&value.target)?;
            match named.filter(|_| !run && value.magnitude.is_none()) {
                Some((name, _)) => self.item(name, first.span),
                None => {
                    for freedom in [freedoms.first(), freedoms.last()].into_iter().flatten() {
                        self.item(&freedom.value.to_string(), freedom.span);
                    }
                    if let Some(magnitude) = value.magnitude {
                        self.number(magnitude.value, magnitude.span);
                    }
                }
            }
            self.end(false);
        }
        Ok(())
    }

    fn step(&mut self, step: &Spanned<Step>) -> Result<()> {
        let span = step.span;
        let value = &step.value;
        self.keyword("STEP", span);
        self.maybe_name("NAME", value.name.as_ref())?;
        if let Some(nlgeom) = value.nlgeom {
            self.parameter("NLGEOM", yes_no(nlgeom), span);
        }
        self.flag("PERTURBATION", value.perturbation, span);
        self.count_of("INC", value.increments);
        self.word("AMPLITUDE", value.default_amplitude, span);
        self.go();
        self.procedure(value, span)?;
        self.actuation(&value.boundaries, &value.connector_motions)?;
        for load in &value.connector_loads {
            let (span, value) = (load.span, &load.value);
            self.keyword("CONNECTOR LOAD", span);
            self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
            self.flag("IMAGINARY", value.imaginary, span);
            self.go();
            self.begin(span);
            self.target(&value.target)?;
            self.item(&value.component.value.0.to_string(), value.component.span);
            self.number(value.magnitude.value, value.magnitude.span);
            self.end(false);
        }
        for load in &value.concentrated_loads {
            let (span, value) = (load.span, &load.value);
            self.keyword("CLOAD", span);
            self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
            self.flag("FOLLOWER", value.follower, span);
            self.flag("IMAGINARY", value.imaginary, span);
            self.go();
            self.begin(span);
            self.target(&value.target)?;
            self.item(&value.degree_of_freedom.value.to_string(), value.degree_of_freedom.span);
            self.number(value.magnitude.value, value.magnitude.span);
            self.end(false);
        }
        for load in &value.distributed_loads {
            let (span, value) = (load.span, &load.value);
            self.keyword("DLOAD", span);
            self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
            self.flag("FOLLOWER", value.follower, span);
            self.flag("IMAGINARY", value.imaginary, span);
            self.go();
            self.begin(span);
            match &value.target {
                Some(target) => self.target(target)?,
                None => self.item("", span),
            }
            self.item(&quoted(&value.label)?, value.label.span);
            for item in &value.values {
                self.maybe(item.value.0, item.span);
            }
            self.end(true);
        }
        for request in &value.outputs {
            self.output(request)?;
        }
        self.keyword("END STEP", span);
        self.go();
        Ok(())
    }

    fn procedure(&mut self, step: &Step, span: Span) -> Result<()> {
        let times = step.times.as_ref();
        let Some(procedure) = &step.procedure else {
            return times.map_or(Ok(()), |times| {
                let message = "times of a step without a procedure".to_owned();
                let remedy = "give procedure = \"static\" or \"dynamic\"";
                Err(refuse(Code::MissingParameter, times.span, message, "not used", remedy))
            });
        };
        let name = normal(&procedure.value);
        match name.as_str() {
            "STATIC" | "DYNAMIC" => self.keyword(&name, procedure.span),
            "DYNAMIC_EXPLICIT" => {
                self.keyword("DYNAMIC", procedure.span);
                self.flag("EXPLICIT", true, procedure.span);
            }
            other if keywords::is_procedure(other) => {
                if let Some(times) = times {
                    let message = format!("the times of {other} are not kept");
                    return Err(refuse(Code::SurplusData, times.span, message, "not used", "remove them"));
                }
                self.keyword(other, procedure.span);
            }
            other => {
                let words = ["static", "dynamic", "dynamic_explicit"];
                let message = format!("there is no procedure `{}`", other.escape_debug());
                let remedy = suggest(&procedure.value, words, || {
                    "write static, dynamic or dynamic_explicit, or the keyword of another procedure"
                        .to_owned()
                });
                return Err(refuse(
                    Code::BadValue,
                    procedure.span,
                    message,
                    "not one of those allowed",
                    &remedy,
                ));
            }
        }
        self.go();
        if let Some(times) = times {
            let form::Times { initial, total, minimum, maximum } = &times.value;
            self.begin(times.span);
            for value in [initial, total, minimum, maximum] {
                let place = value.map_or(span, |value| value.span);
                self.maybe(value.map(|value| value.value), place);
            }
            self.end(true);
        }
        Ok(())
    }

    fn output(&mut self, request: &Spanned<form::OutputRequest>) -> Result<()> {
        let form::OutputRequest { keyword, element_set, node_set, parameters, variables } = &request.value;
        let name = normal(&keyword.value);
        if !keywords::is_output(&name) {
            let names: Vec<&str> = keywords::outputs().collect();
            let message = format!("`{}` is no output request", name.escape_debug());
            let remedy =
                suggest(&name, names.iter().copied(), || format!("write one of {}", names.join(", ")));
            return Err(refuse(Code::BadValue, keyword.span, message, "not one of those allowed", &remedy));
        }
        self.keyword(&name, request.span);
        for (name, value) in &parameters.0 {
            let key = plain(name, "the name of a parameter")?;
            match &value.value.0 {
                None => self.item(&key, name.span),
                Some(text) => {
                    let quotes = text.bytes().filter(|byte| *byte == b'"').count();
                    let outside = text.split('"').step_by(2).any(|part| part.contains(','));
                    if has_control(text) || quotes % 2 == 1 || outside {
                        let message = format!("`{}` cannot be the value of a parameter", text.escape_debug());
                        let remedy = "write no commas, quotation marks or line breaks";
                        return Err(refuse(
                            Code::BadParameterValue,
                            value.span,
                            message,
                            "not a value",
                            remedy,
                        ));
                    }
                    self.parameter(&key, text, value.span);
                }
            }
        }
        self.maybe_name("ELSET", element_set.as_ref())?;
        self.maybe_name("NSET", node_set.as_ref())?;
        self.go();
        for line in variables.chunks(PER_LINE) {
            self.begin(line.first().map_or(request.span, |variable| variable.span));
            for variable in line {
                self.item(&plain(variable, "an output variable")?, variable.span);
            }
            self.end(false);
        }
        Ok(())
    }
}

/// The shortest digits that read back to the same double.
fn number(value: f64) -> String {
    let mut text = String::new();
    text.push_str(&format!("{value:?}"));
    text
}

/// What of a list is written: up to `done`, and next up to `until`.
#[derive(Debug, Clone, Copy)]
struct Written {
    done: usize,
    until: usize,
}

impl Default for Written {
    fn default() -> Self {
        Self { done: 0, until: usize::MAX }
    }
}

impl Written {
    fn next<'a, T>(&mut self, list: &'a [T]) -> &'a [T] {
        let until = self.until.min(list.len()).max(self.done);
        let next = list.get(self.done..until).unwrap_or_default();
        self.done = until;
        next
    }
}

fn label_of(name: &Name) -> Option<Label> {
    name.value.parse().ok()
}

/// The instances of which a document has nodes or elements, in their order.
fn instances(document: &Document) -> IndexMap<Instance, Span> {
    let nodes = document.nodes.0.iter().map(|(label, _)| label);
    let connectors = document.connectors.0.iter().map(|(label, _)| label);
    let points = document.point_elements.0.iter().map(|(label, _)| label);
    let mut found = IndexMap::new();
    for name in nodes.chain(connectors).chain(points) {
        if let Some(instance) = label_of(name).and_then(Label::instance) {
            found.entry(instance).or_insert(name.span);
        }
    }
    found
}

/// The number of field variables of a table: that of the row with the most.
fn fields(rows: &[Spanned<Row>]) -> usize {
    rows.iter().map(|row| row.value.fields.len()).max().unwrap_or(0)
}

fn dependencies(count: Option<Spanned<u64>>) -> usize {
    let count = count.map_or(0, |count| count.value);
    usize::try_from(count).unwrap_or(usize::MAX).min(super::MAX_DEPENDENCIES)
}

/// A label as a deck writes it, or a name.
fn label_or_name(text: &str, span: Span) -> Result<String> {
    match text.parse::<Label>() {
        Ok(label) => Ok(label.to_string()),
        Err(LabelError::OutOfRange(_)) => Ok(text.trim().to_owned()),
        Err(LabelError::Malformed(_)) => quoted(&Spanned::new(text.to_owned(), span)),
    }
}
