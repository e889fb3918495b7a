//! `*NGEN` and `*ELGEN`: nodes on lines between two, and elements in rows, of which a deck gives the first.

pub(super) mod copy;
mod curve;

use crate::deck::Deck;
use crate::deck::generate::curve::Curve;
use crate::deck::mesh::{add_connector, add_point};
use crate::deck::sets::{MAX_MEMBERS, SetBuilder};
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::label::Label;
use crate::label::MAX_LABEL;
use crate::lexer::{Item, Items, Keyword};
use crate::model::{ConnectorElement, Node, PointElement};
use crate::span::Span;
use indexmap::map::Entry;

impl Deck<'_> {
    /// Counts what is generated, so that no line of a deck can ask for more than a deck may have.
    pub(super) fn count_generated(&mut self, count: u64, span: Span) -> Result<()> {
        let all = self.generated.saturating_add(count);
        if all <= MAX_MEMBERS {
            self.generated = all;
            return Ok(());
        }
        let message =
            format!("more than {MAX_MEMBERS} nodes, elements and sets are generated, or copied by instances");
        Err(Diagnostic::error(Code::GenerateRange, span, message, "up to this line")
            .help("check the numbers on this line, or split the model"))
    }
}

/// How much of its largest coordinate two computations of one place may differ by.
const SAME_PLACE: f64 = 1e-9;

impl Deck<'_> {
    /// Adds a node that is computed. One that is there already stays where it is, if that is the same place but for rounding.
    ///
    /// # Errors
    /// It is there already, elsewhere.
    pub(super) fn add_generated(&mut self, label: u64, coordinates: [f64; 3], span: Span) -> Result<()> {
        match self.scene.nodes.entry(label.into()) {
            Entry::Vacant(place) => drop(place.insert(Node { coordinates, span })),
            Entry::Occupied(known) => {
                let there = known.get().coordinates;
                let size = there.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
                if (0..3).any(|k| (there[k] - coordinates[k]).abs() > SAME_PLACE * size) {
                    let first = known.get().span;
                    let message = format!("node {label} is defined already, at another place");
                    let label = format!("first defined on line {}", first.line());
                    return Err(Diagnostic::error(Code::DuplicateNode, span, message, label)
                        .beside(first)
                        .help("give one of the two another number"));
                }
            }
        }
        Ok(())
    }
}

/// Nodes at equal distances between two that are defined above, on a straight line, a parabola or an arc.
pub(super) fn nodes(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let set = keyword.name_of("NSET")?;
    while let Some(line) = deck.lexer.row()? {
        let span = line.span;
        let mut items = line.items();
        let ends = [items.need("the first node")?, items.need("the last node")?];
        let [first, last] = [ends[0].label_number("the first node")?, ends[1].label_number("the last node")?];
        let step = items.maybe().map_or(Ok(1), |item| item.integer("the increment"))?;
        let length = last.abs_diff(first);
        if step == 0 || length == 0 || length % step != 0 {
            let message = format!("no nodes lie between {first} and {last} in steps of {step}");
            return Err(Diagnostic::error(Code::GenerateRange, span, message, "this line")
                .help("give an increment that divides the difference of the two numbers"));
        }
        let place = |number: u64| {
            deck.scene.nodes.get(&Label::from(number)).map(|node| node.coordinates).ok_or_else(|| {
                let message = format!("there is no node {number} above this line");
                Diagnostic::error(Code::UnknownNode, span, message, "not defined")
                    .help("define it under *NODE, above *NGEN")
            })
        };
        let ends = [place(first)?, place(last)?];
        let curve = Curve::read((&deck.scene, deck.system), keyword, &mut items, ends, span)?;
        items.end(
            "the first node, the last node and the increment; on a curve also a further point, and a normal",
        )?;
        let count = length / step;
        deck.count_generated(count, span)?;
        let number = |index: u64| if last > first { first + index * step } else { first - index * step };
        for index in 1..count {
            let place = curve.point(ends, index as f64 / count as f64);
            deck.add_generated(number(index), place, span)?;
        }
        if let Some(name) = &set {
            let set = deck.node_sets.entry(name.value.clone()).or_insert_with(|| SetBuilder::new(name.span));
            let (low, high) = (first.min(last), first.max(last));
            set.push_range(None, (low, high, step), span);
        }
    }
    Ok(())
}

/// How many, and by how much the numbers of nodes and elements grow from one to the next.
#[derive(Clone, Copy)]
struct Row {
    count: u64,
    node: u64,
    element: u64,
}

fn row(items: &mut Items<'_>, element: u64) -> Result<Row> {
    let mut whole =
        |what: &str, default| items.maybe().map_or(Ok(default), |item: Item<'_>| item.integer(what));
    Ok(Row {
        count: whole("the number of elements", 1)?.max(1),
        node: whole("the increment of node numbers", 1)?,
        element: whole("the increment of element numbers", element)?,
    })
}

/// Elements in a row, rows in a layer, layers: copies of one that is defined above, with all numbers counted on.
pub(super) fn elements(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let set = keyword.name_of("ELSET")?;
    while let Some(line) = deck.lexer.row()? {
        let span = line.span;
        let mut items = line.items();
        let master = items.need("the element")?.label_number("the element number")?;
        let rows = [row(&mut items, 1)?, row(&mut items, 0)?, row(&mut items, 0)?];
        items.end("an element, and three times a number, a node increment and an element increment")?;
        let count =
            rows.iter().try_fold(1_u64, |count, row| count.checked_mul(row.count)).unwrap_or(u64::MAX);
        deck.count_generated(count, span)?;
        if rows.iter().any(|row| row.count > 1 && row.element == 0) {
            let message = "copies of an element would have its number";
            return Err(Diagnostic::error(Code::GenerateRange, span, message, "this line")
                .help("give an element increment of at least 1 for each row and layer"));
        }
        let label = Label::from(master);
        let modelled =
            deck.scene.connectors.contains_key(&label) || deck.scene.point_elements.contains_key(&label);
        if !modelled && !deck.other_elements.contains_unsorted(master) {
            let message = format!("there is no element {master} above this line");
            return Err(Diagnostic::error(Code::UnknownElement, span, message, "not defined")
                .help("define it under *ELEMENT, above *ELGEN"));
        }
        if !modelled {
            deck.any_rotates |= !deck.other_rotations.is_empty();
            let skipped =
                deck.scene.skipped.element_types.entry("generated by *ELGEN".to_owned()).or_default();
            if skipped.first_line == 0 {
                skipped.first_line = span.line();
            }
            skipped.count += count - 1;
        }
        for index in 0..count {
            let places = [
                index % rows[0].count,
                index / rows[0].count % rows[1].count,
                index / rows[0].count / rows[1].count,
            ];
            let offset = |by: fn(&Row) -> u64| {
                let mut terms = rows.iter().zip(places).map(|(row, place)| by(row).checked_mul(place));
                terms
                    .try_fold(0_u64, |sum, term: Option<u64>| sum.checked_add(term?))
                    .filter(|offset| *offset <= MAX_LABEL)
            };
            let too_large = || {
                let message = "generated numbers grow beyond 2^53";
                Diagnostic::error(Code::BadLabel, span, message, "out of range")
                    .help("use smaller increments")
            };
            let element = offset(|row| row.element).ok_or_else(too_large)?;
            let node = offset(|row| row.node).ok_or_else(too_large)?;
            let label =
                master.checked_add(element).filter(|label| *label <= MAX_LABEL).ok_or_else(too_large)?;
            if index > 0 {
                copy(deck, master, label, node, span)?;
            }
            if let Some(name) = &set {
                let set =
                    deck.element_sets.entry(name.value.clone()).or_insert_with(|| SetBuilder::new(name.span));
                set.push_defined(label, span);
            }
        }
    }
    Ok(())
}

/// The element `master` as element `label`, with node numbers that are larger by `by`.
pub(super) fn copy(deck: &mut Deck<'_>, master: u64, label: u64, by: u64, span: Span) -> Result<()> {
    let master = Label::from(master);
    let shift = |node: Label| Label::of(node.instance(), node.number().saturating_add(by));
    let scene = &mut deck.scene;
    if let Some(element) = scene.connectors.get(&master) {
        let (a, b) = (element.a.map(shift), element.b.map(shift));
        let copy = ConnectorElement { a, b, span, ..*element };
        return add_connector(scene, label, copy);
    }
    if let Some(element) = scene.point_elements.get(&master) {
        let (node, second) = (shift(element.node), element.second.map(shift));
        let copy = PointElement { node, second, span, ..*element };
        return add_point(scene, label, copy);
    }
    deck.any_rotates |= !deck.other_rotations.is_empty();
    deck.other_elements.copy(master.number(), label, by);
    Ok(())
}
