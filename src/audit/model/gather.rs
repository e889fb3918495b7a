//! What is found alike in many connectors of a section is told once.

use crate::model::finding::{About, Finding};
use crate::model::levels::Levels;
use indexmap::IndexMap;
use pintle_scene::grammar::and_others;
use pintle_scene::{Code, Label, Severity};
use std::collections::HashMap;

/// What findings have in common that are told as one: code, section, which of the laws of its behaviour, components, and how bad each is taken to be.
type Common = (Code, usize, Option<usize>, Vec<String>, Option<Severity>);

/// Findings by what they are: of those that have all in common, the first or worst is told, and the others are counted.
pub(super) struct Gathered<'a> {
    levels: &'a Levels,
    order: Vec<Told>,
    known: HashMap<Common, usize>,
}

struct Told {
    /// The first or worst.
    finding: Finding,
    /// What it was found of: the elements of each finding, the one itself first, and how much.
    each: IndexMap<Label, About>,
}

impl<'a> Gathered<'a> {
    /// None yet; `levels` say which of them are as bad as each other.
    pub(super) fn new(levels: &'a Levels) -> Self {
        Self { levels, order: Vec::new(), known: HashMap::new() }
    }

    /// Adds what is found of an element of a section, and of which of the laws of its behaviour where it is of one. Two laws are
    /// two findings, however many elements have them. `worse` says whether this one is to be told rather than the one so far.
    pub(super) fn add(
        &mut self,
        (section, law): (usize, Option<usize>),
        label: Label,
        finding: Finding,
        worse: impl Fn(&About, &About) -> bool,
    ) {
        let severity = self.levels.of_finding(&finding);
        let key = (finding.code(), section, law, finding.about.components.clone(), severity);
        match self.known.get(&key).and_then(|place| self.order.get_mut(*place)) {
            None => {
                self.known.insert(key, self.order.len());
                let each = IndexMap::from([(label, finding.about.clone())]);
                self.order.push(Told { finding, each });
            }
            Some(told) => {
                match told.each.get_mut(&label) {
                    Some(known) if worse(&finding.about, known) => *known = finding.about.clone(),
                    Some(_) => {}
                    None => drop(told.each.insert(label, finding.about.clone())),
                }
                if worse(&finding.about, &told.finding.about) {
                    told.finding = finding;
                }
            }
        }
    }

    /// The findings, each with the elements of the section that it holds for and how much of each.
    pub(super) fn findings(self) -> impl Iterator<Item = Finding> {
        self.order.into_iter().map(|Told { mut finding, each }| {
            if each.len() < 2 {
                return finding;
            }
            let own = finding.about.elements.clone();
            let mut elements = own.clone();
            elements.extend(each.keys().filter(|label| !own.contains(label)));
            let others = and_others("element", elements.get(own.len()..).unwrap_or_default());
            let value = |label: &Label| each.get(label).and_then(|about| about.value);
            if finding.about.value.is_some() {
                finding.about.values = elements.iter().map(value).collect();
            }
            finding.about.elements = elements;
            finding.add(&others)
        })
    }
}
