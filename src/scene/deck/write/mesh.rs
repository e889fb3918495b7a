//! Nodes, instances, sets and orientations.

use crate::deck::write::{Deck, MEMBERS_PER_LINE, Name, has_control, refuse};
use crate::diagnostic::{Code, Result};
use crate::document::form;
use crate::document::form::{Document, Entries, Member, PointOrNode, Target};
use crate::label::{Instance, Label};
use crate::model::{Dimension, PointKind};
use crate::orientation::System;
use crate::span::{Span, Spanned};
use indexmap::IndexMap;

impl Deck {
    pub(super) fn heading(&mut self, heading: &Name) -> Result<()> {
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

    pub(super) fn mesh(&mut self, document: &Document) -> Result<()> {
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
pub(super) fn instances(document: &Document) -> IndexMap<Instance, Span> {
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
