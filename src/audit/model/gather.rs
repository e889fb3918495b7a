//! What is found alike in many connectors of a section is told once.

use super::finding::{About, Finding};
use crate::scene::{Code, Label};
use std::collections::{HashMap, HashSet};

/// Findings by what they are: of one code, section and components, the first or worst is told, and the others are counted.
#[derive(Default)]
pub(super) struct Gathered {
    order: Vec<Told>,
    known: HashMap<(Code, usize, Vec<String>), usize>,
}

struct Told {
    finding: Finding,
    elements: HashSet<Label>,
}

/// The number of elements that a finding names.
const NAMED: usize = 100;

impl Gathered {
    /// Adds what is found of an element of a section; `worse` says whether this one is to be told rather than the one so far.
    pub(super) fn add(
        &mut self,
        section: usize,
        label: Label,
        finding: Finding,
        worse: impl Fn(&About, &About) -> bool,
    ) {
        let key = (finding.code(), section, finding.about.components.clone());
        match self.known.get(&key).and_then(|place| self.order.get_mut(*place)) {
            None => {
                self.known.insert(key, self.order.len());
                self.order.push(Told { finding, elements: HashSet::from([label]) });
            }
            Some(told) => {
                let is_new = told.elements.insert(label);
                let mut named = std::mem::take(&mut told.finding.about.elements);
                if worse(&finding.about, &told.finding.about) {
                    let others = named.into_iter().filter(|other| *other != label);
                    named = finding.about.elements.iter().copied().chain(others).collect();
                    told.finding = finding;
                } else if is_new {
                    named.push(label);
                }
                named.truncate(NAMED);
                told.finding.about.elements = named;
            }
        }
    }

    /// The findings, each with the number of other elements of the section that it holds for.
    pub(super) fn findings(self) -> impl Iterator<Item = Finding> {
        self.order.into_iter().map(|told| match told.elements.len() {
            0 | 1 => told.finding,
            2 => told.finding.add(" (and so on for 1 other element of the section)"),
            more => told.finding.add(&format!(" (and so on for {} other elements of the section)", more - 1)),
        })
    }
}
