//! Sets while they are read, and what they contain once everything is known.

use crate::deck::Deck;
use crate::deck::errors::Errors;
use crate::deck::faces::OtherElements;
use crate::diagnostic::{Code, Diagnostic, Result, Severity, suggest_scoped};
use crate::label::labelled::{LabelSet, LabelState};
use crate::label::{Instance, Label};
use crate::model::Set;
use crate::span::{Span, Spanned};
use crate::wording::{definition, keyword};
use indexmap::IndexMap;
use std::cell::OnceCell;
use std::collections::HashSet;

/// The largest number of members of a GENERATE range, and of all sets of a deck together.
pub const MAX_MEMBERS: u64 = 10_000_000;

/// So many ranges of skipped elements are kept before repeated ones are looked for.
const FEW_RANGES: usize = 64;

/// The largest number of numbers that all sets of a deck may list, whether something has them or not.
const MAX_LISTED: u64 = 200_000_000;

impl Deck<'_> {
    /// The nodes that a set has by now, of those defined here, in its order.
    pub(super) fn nodes_now(&mut self, name: &Spanned<String>) -> Result<Vec<u64>> {
        let nodes = &self.scene.nodes;
        let is_there = |number: u64| nodes.contains_key(&Label::from(number));
        let found = members_now(Kind::Node, &self.node_sets, name, &is_there)?;
        self.count_generated(found.len() as u64, name.span)?;
        Ok(found)
    }

    /// The elements that a set has by now, read or skipped, of those defined here.
    pub(super) fn elements_now(&mut self, name: &Spanned<String>) -> Result<Vec<u64>> {
        self.other_elements.sort();
        let (scene, others) = (&self.scene, &self.other_elements);
        let is_there = |number: u64| {
            let label = Label::from(number);
            scene.connectors.contains_key(&label)
                || scene.point_elements.contains_key(&label)
                || others.contains(label)
        };
        let found = members_now(Kind::Element, &self.element_sets, name, &is_there)?;
        self.count_generated(found.len() as u64, name.span)?;
        Ok(found)
    }
}

/// What a set has by now. Sets within it count, each once.
fn members_now(
    kind: Kind,
    builders: &IndexMap<String, SetBuilder>,
    name: &Spanned<String>,
    is_there: &dyn Fn(u64) -> bool,
) -> Result<Vec<u64>> {
    let Some((place, _, builder)) = builders.get_full(&name.value) else {
        return Err(unknown_set(kind, name, builders.keys().map(String::as_str)));
    };
    let is_unsorted = builder.unsorted;
    let (mut found, mut looked_at) = (Vec::new(), 0_u64);
    let mut seen = HashSet::from([place]);
    let mut open = vec![builder.entries.iter()];
    while let Some(entries) = open.last_mut() {
        match entries.next() {
            None => drop(open.pop()),
            Some(&Entry::Range { instance: None, first, last, step, .. }) => {
                looked_at = looked_at.saturating_add((last - first) / step + 1);
                if looked_at > MAX_LISTED {
                    let message = format!("set {} lists more than {MAX_LISTED} numbers", name.value);
                    return Err(Diagnostic::error(Code::GenerateRange, name.span, message, "too large")
                        .help("give the set the numbers that exist"));
                }
                let numbers = (0..=(last - first) / step).map(|index| first + index * step);
                found.extend(numbers.filter(|number| is_there(*number)));
            }
            Some(Entry::Range { .. }) => {}
            Some(Entry::Fault(error)) => return Err((**error).clone()),
            Some(Entry::Set(inner)) => {
                if let Some((_, _, inner)) =
                    builders.get_full(&inner.value).filter(|(place, ..)| seen.insert(*place))
                {
                    open.push(inner.entries.iter());
                }
            }
            Some(Entry::NodesOf(elements)) => {
                let message = format!("set {} takes the nodes of element set {}", name.value, elements.value);
                return Err(Diagnostic::error(
                    Code::NodesOfSkipped,
                    name.span,
                    message,
                    "needed here already",
                )
                .help("list its nodes under *NSET"));
            }
        }
    }
    if is_unsorted {
        let mut seen = HashSet::with_capacity(found.len());
        found.retain(|number| seen.insert(*number));
    } else {
        found.sort_unstable();
        found.dedup();
    }
    Ok(found)
}

/// Nodes or elements?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Node,
    Element,
}

impl Kind {
    /// The keyword that lists members.
    fn keyword(self) -> &'static str {
        match self {
            Self::Node => "NSET",
            Self::Element => "ELSET",
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::Element => "element",
        }
    }

    /// What to do about one that is not there.
    pub(super) fn undefined(self) -> [String; 2] {
        let of = match self {
            Self::Node => "NODE",
            Self::Element => "ELEMENT",
        };
        keyword(of).map(|keyword| format!("define it under {keyword}"))
    }

    pub(super) fn unknown(self) -> Code {
        match self {
            Self::Node => Code::UnknownNode,
            Self::Element => Code::UnknownElement,
        }
    }

    pub(super) fn unknown_set(self) -> Code {
        match self {
            Self::Node => Code::UnknownNodeSet,
            Self::Element => Code::UnknownElementSet,
        }
    }
}

/// What a number stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Member {
    /// A node or element of the scene.
    Modelled,
    /// An element of a type that was skipped.
    Unmodelled,
    /// Nothing.
    Unknown,
}

/// A set as its lines give it.
#[derive(Debug, Clone, Default)]
pub(super) struct SetBuilder {
    entries: Vec<Entry>,
    unsorted: bool,
    span: Span,
}

#[derive(Debug, Clone)]
enum Entry {
    /// Written as `GENERATE` or as numbers one after the other.
    Range { instance: Option<Instance>, first: u64, last: u64, step: u64, generated: bool, span: Span },
    /// Another set.
    Set(Spanned<String>),
    /// The nodes of an element set.
    NodesOf(Spanned<String>),
    /// A line that cannot be read.
    Fault(Box<Diagnostic>),
}

impl SetBuilder {
    pub(super) fn new(span: Span) -> Self {
        Self { span, ..Self::default() }
    }

    /// The number of its entries, and one for itself.
    pub(super) fn len(&self) -> usize {
        1 + self.entries.len()
    }

    pub(super) fn set_unsorted(&mut self) {
        self.unsorted = true;
    }

    /// One member. Numbers that follow each other on one line share an entry.
    pub(super) fn push(&mut self, label: Label, span: Span) {
        self.push_one(label, span, |place| (place.file(), place.line()) == (span.file(), span.line()));
    }

    /// A member that is defined by the same line; numbers that follow each other share an entry.
    pub(super) fn push_defined(&mut self, label: u64, span: Span) {
        self.push_one(label.into(), span, |_| true);
    }

    fn push_one(&mut self, label: Label, span: Span, joins: impl Fn(Span) -> bool) {
        let number = label.number();
        if let Some(Entry::Range { instance, last, step: 1, generated: false, span: place, .. }) =
            self.entries.last_mut()
            && *instance == label.instance()
            && joins(*place)
            && last.checked_add(1) == Some(number)
        {
            *last = number;
            return;
        }
        let (instance, generated) = (label.instance(), false);
        self.entries.push(Entry::Range { instance, first: number, last: number, step: 1, generated, span });
    }

    pub(super) fn push_range(
        &mut self,
        instance: Option<Instance>,
        (first, last, step): (u64, u64, u64),
        span: Span,
    ) {
        self.entries.push(Entry::Range { instance, first, last, step, generated: true, span });
    }

    pub(super) fn push_set(&mut self, name: Spanned<String>) {
        self.entries.push(Entry::Set(name));
    }

    /// The sets of the same kind that it names.
    pub(super) fn inner(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().filter_map(|entry| match entry {
            Entry::Set(name) => Some(name.value.as_str()),
            Entry::Range { .. } | Entry::NodesOf(_) | Entry::Fault(_) => None,
        })
    }

    /// The element sets whose nodes it takes.
    pub(super) fn element_sets(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().filter_map(|entry| match entry {
            Entry::NodesOf(name) => Some(name.value.as_str()),
            Entry::Range { .. } | Entry::Set(_) | Entry::Fault(_) => None,
        })
    }

    pub(super) fn push_nodes_of(&mut self, name: Spanned<String>) {
        self.entries.push(Entry::NodesOf(name));
    }

    /// Its lines that cannot be read.
    fn faults(&self) -> impl Iterator<Item = &Diagnostic> {
        self.entries.iter().filter_map(|entry| match entry {
            Entry::Fault(error) => Some(&**error),
            _ => None,
        })
    }

    /// A line that cannot be read, which matters to what uses the set.
    pub(super) fn push_fault(&mut self, error: Diagnostic) {
        self.entries.push(Entry::Fault(Box::new(error)));
    }

    /// The set of a part as one of its instance.
    pub(super) fn within(mut self, within: Instance) -> Self {
        for entry in &mut self.entries {
            match entry {
                Entry::Range { instance, .. } => {
                    instance.get_or_insert(within);
                }
                Entry::Set(name) | Entry::NodesOf(name) => name.value = within.scoped(&name.value),
                Entry::Fault(_) => {}
            }
        }
        self
    }

    /// What two definitions of one set list together.
    pub(super) fn extend(&mut self, other: Self) {
        self.entries.extend(other.entries);
        self.unsorted |= other.unsorted;
    }
}

/// What sets may have as members.
pub(super) struct Known<'a> {
    /// What one label stands for.
    pub(super) member: &'a dyn Fn(Label) -> Member,
    /// How much the scene has.
    pub(super) count: usize,
    /// All of that.
    pub(super) labels: &'a dyn Fn() -> Vec<Label>,
    /// The same in order, once it is needed.
    pub(super) sorted: OnceCell<Vec<Label>>,
    /// What was skipped.
    pub(super) other: &'a OtherElements,
    /// Whether a set of that name is evaluated: only then it may list nothing that is not there.
    pub(super) needed: &'a dyn Fn(&str) -> bool,
    /// Whether anything that is read names it: only then a line of it that cannot be read may list what matters.
    pub(super) named: &'a dyn Fn(&str) -> bool,
}

impl Known<'_> {
    /// Those of the scene among `first`, `first + step` … `last`, and how many of the skipped ones. It takes as long as there
    /// are such, however wide the range.
    fn within(&self, first: Label, last: u64, step: u64) -> (impl Iterator<Item = Label>, u64) {
        let sorted = self.sorted.get_or_init(|| {
            let mut labels = (self.labels)();
            labels.sort_unstable();
            labels
        });
        let after = sorted.partition_point(|label| *label < first);
        let end = Label::of(first.instance(), last);
        let inside = sorted.iter().skip(after).take_while(move |label| **label <= end).copied();
        let met = inside.filter(move |label| (label.number() - first.number()).is_multiple_of(step));
        (met, self.other.count((first, last, step)))
    }
}

/// The nodes of the elements of a set: they are needed by node sets that are given by element sets.
pub(super) type NodesOf<'a> = &'a dyn Fn(&Spanned<String>, &mut Set) -> Result<()>;

/// The members of all sets of one kind. Sets may name sets that are defined later.
pub(super) fn resolve(
    kind: Kind,
    builders: &IndexMap<String, SetBuilder>,
    known: &Known<'_>,
    nodes_of: NodesOf<'_>,
    warn: &mut dyn FnMut(Diagnostic),
    errors: &mut Errors,
) -> Result<IndexMap<String, Set>> {
    let mut done: Vec<Option<Set>> = vec![None; builders.len()];
    let (mut total, mut listed) = (0, 0);
    // A set that nothing names refuses nothing but a circle.
    let mut tell = |name: &str, error: Diagnostic| {
        if error.code() == Code::SetCycle || (known.named)(name) {
            errors.add(error);
        } else {
            warn(error.of_severity(Severity::Warning));
        }
    };
    let places = order(kind, builders, &mut tell);
    for (name, builder) in builders {
        builder.faults().for_each(|error| tell(name, error.clone()));
    }
    if builders.iter().any(|(name, builder)| (known.named)(name) && builder.faults().next().is_some()) {
        errors.spoil(kind.keyword());
    }
    for place in places {
        let Some((name, builder)) = builders.get_index(place) else { continue };
        let mut set = Set { span: builder.span, ..Set::default() };
        let mut room = FEW_RANGES;
        for entry in &builder.entries {
            match entry {
                Entry::Set(inner) => {
                    let inner = builders.get_index_of(&inner.value).and_then(|place| done[place].as_ref());
                    if let Some(inner) = inner {
                        set.labels.extend_from_slice(&inner.labels);
                        set.unmodelled = set.unmodelled.saturating_add(inner.unmodelled);
                        set.others.extend_from_slice(&inner.others);
                        // A set that is named again and again brings the same ranges.
                        if set.others.len() > room {
                            set.others.sort_unstable();
                            set.others.dedup();
                            room = FEW_RANGES + 2 * set.others.len();
                        }
                    }
                }
                Entry::NodesOf(elements) => {
                    let before = set.unmodelled;
                    errors.value(nodes_of(elements, &mut set));
                    if set.unmodelled > before {
                        let count = set.unmodelled - before;
                        let message = format!(
                            "of {count} elements of set {} that are of types that are not read, nodes are not defined",
                            elements.value
                        );
                        warn(
                            Diagnostic::warning(
                                Code::NodesOfSkipped,
                                elements.span,
                                message,
                                format!("set {name} lacks their nodes"),
                            )
                            .help("list the nodes themselves if a connector or a constraint needs them"),
                        );
                    }
                }
                Entry::Fault(_) => {}
                &Entry::Range { instance, first, last, step, generated, span } => {
                    let range = (Label::of(instance, first), last, step, generated);
                    match expand(kind, range, span, known, &mut set, warn) {
                        Ok(found) => listed += found,
                        Err(error) if (known.needed)(name) => errors.add(error),
                        // No connector and no constraint has to do with the set.
                        Err(error) => warn(error.of_severity(Severity::Warning)),
                    }
                    if listed > MAX_LISTED {
                        let message =
                            format!("the {} sets list more than {MAX_LISTED} numbers together", kind.name());
                        return Err(Diagnostic::error(
                            Code::GenerateRange,
                            span,
                            message,
                            format!("up to {name}"),
                        )
                        .help("remove sets that no connector needs"));
                    }
                }
            }
            if total + (set.labels.len() + set.others.len()) as u64 > MAX_MEMBERS {
                let message =
                    format!("the {} sets have more than {MAX_MEMBERS} members together", kind.name());
                return Err(Diagnostic::error(
                    Code::GenerateRange,
                    builder.span,
                    message,
                    format!("up to {name}"),
                )
                .help("remove sets that no connector needs"));
            }
        }
        if builder.unsorted {
            let mut seen = LabelSet::with_capacity_and_hasher(set.labels.len(), LabelState::default());
            set.labels.retain(|label| seen.insert(*label));
            set.unsorted = !set.labels.is_sorted();
        } else {
            set.labels.sort_unstable();
            set.labels.dedup();
        }
        set.others.sort_unstable();
        set.others.dedup();
        total += (set.labels.len() + set.others.len()) as u64;
        done[place] = Some(set);
    }
    Ok(builders.keys().cloned().zip(done.into_iter().map(Option::unwrap_or_default)).collect())
}

/// Puts the members of a range into a set; gives the number of labels looked at.
fn expand(
    kind: Kind,
    (first, last, step, generated): (Label, u64, u64, bool),
    span: Span,
    known: &Known<'_>,
    set: &mut Set,
    warn: &mut dyn FnMut(Diagnostic),
) -> Result<u64> {
    let name = kind.name();
    let count = (last - first.number()) / step + 1;
    let (before, unmodelled_before) = (set.labels.len(), set.unmodelled);
    if generated && count > known.count as u64 {
        let (modelled, unmodelled) = known.within(first, last, step);
        set.labels.extend(modelled);
        set.unmodelled = set.unmodelled.saturating_add(unmodelled);
    } else {
        let mut number = first.number();
        while number <= last {
            let label = Label::of(first.instance(), number);
            match (known.member)(label) {
                Member::Modelled => set.labels.push(label),
                Member::Unmodelled => set.unmodelled = set.unmodelled.saturating_add(1),
                Member::Unknown if generated => {}
                Member::Unknown => {
                    let message = format!("the set contains {name} {label}, which is not defined");
                    return Err(Diagnostic::error(kind.unknown(), span, message, format!("no such {name}"))
                        .help(kind.undefined()));
                }
            }
            number += step;
        }
    }
    if set.unmodelled > unmodelled_before {
        set.others.push((first, last, step));
    }
    let looked_at = count.min(known.count as u64);
    let found = (set.labels.len() - before) as u64 + (set.unmodelled - unmodelled_before);
    let gaps = count.saturating_sub(found);
    let last = Label::of(first.instance(), last);
    if found == 0 {
        let message = format!("no {name} from {first} to {last} is defined");
        return Err(Diagnostic::error(kind.unknown(), span, message, format!("no such {name}s"))
            .help(kind.undefined()));
    }
    if gaps > 0 {
        let message = format!("{gaps} of {count} {name}s from {first} to {last} are not defined");
        warn(
            Diagnostic::warning(Code::GenerateGaps, span, message, "left out of the set")
                .help(format!("check the range; the set has the {name}s that exist")),
        );
    }
    Ok(looked_at)
}

/// The sets of some names, and all sets within them.
pub(super) fn closure<'a>(
    builders: &'a IndexMap<String, SetBuilder>,
    names: impl Iterator<Item = &'a str>,
) -> HashSet<&'a str> {
    let mut found = HashSet::new();
    let mut open: Vec<&str> = names.collect();
    while let Some(name) = open.pop() {
        if found.insert(name) {
            open.extend(builders.get(name).into_iter().flat_map(SetBuilder::inner));
        }
    }
    found
}

/// An order in which every set comes after those that it names.
fn order(
    kind: Kind,
    builders: &IndexMap<String, SetBuilder>,
    tell: &mut dyn FnMut(&str, Diagnostic),
) -> Vec<usize> {
    let mut order = Vec::with_capacity(builders.len());
    let mut mark = vec![Mark::New; builders.len()];
    for root in 0..builders.len() {
        let mut path = vec![(root, 0)];
        while let Some((place, entry)) = path.pop() {
            if mark[place] == Mark::Done {
                continue;
            }
            mark[place] = Mark::Open;
            let Some((own, builder)) = builders.get_index(place) else { continue };
            let inner = builder.entries.iter().enumerate().skip(entry);
            let inner = inner.filter_map(|(at, entry)| match entry {
                Entry::Set(name) => Some((at, name)),
                Entry::Range { .. } | Entry::NodesOf(_) | Entry::Fault(_) => None,
            });
            let mut next = None;
            for (at, name) in inner {
                let Some(child) = builders.get_index_of(&name.value) else {
                    tell(own, unknown_set(kind, name, builders.keys().map(String::as_str)));
                    continue;
                };
                match mark[child] {
                    Mark::Done => {}
                    Mark::Open => {
                        let message = format!("{} set {} contains itself", kind.name(), name.value);
                        tell(
                            own,
                            Diagnostic::error(Code::SetCycle, name.span, message, "closes the circle")
                                .help("remove this name from the set"),
                        );
                    }
                    Mark::New => {
                        next = Some((at, child));
                        break;
                    }
                }
            }
            match next {
                Some((at, child)) => path.extend([(place, at), (child, 0)]),
                None => {
                    mark[place] = Mark::Done;
                    order.push(place);
                }
            }
        }
    }
    order
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    New,
    Open,
    Done,
}

/// The error for a set that does not exist.
pub(super) fn unknown_set<'a>(
    kind: Kind,
    name: &Spanned<String>,
    names: impl IntoIterator<Item = &'a str>,
) -> Diagnostic {
    let message = format!("there is no {} set {}", kind.name(), name.value);
    let keyword = kind.keyword();
    let remedy = suggest_scoped(&name.value, names, || definition(keyword, keyword, &name.value));
    Diagnostic::error(kind.unknown_set(), name.span, message, "not defined").help(remedy)
}
