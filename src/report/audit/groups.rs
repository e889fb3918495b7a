//! What is said more than once, said once: findings of one code that differ in names, wrong numbers of many connectors.

use crate::audit::summary::{is_sharp, telling};
use pintle_audit::model::Finding;
use pintle_audit::{Check, Report, Subject};
use pintle_scene::Severity;
use pintle_scene::grammar::shape;

/// Names that are listed.
const NAMED: usize = 3;

/// What errors of one code say in different words is shown so often; the rest is counted. What is no error is shown once for each code.
const KINDS: usize = 3;

/// The first names, and how many there are more.
pub(super) fn named(names: &[String]) -> String {
    let shown = names.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(NAMED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Findings of one code and severity that say the same of different things.
pub(super) struct Findings<'a> {
    pub(super) first: &'a Finding,
    others: Vec<&'a Finding>,
}

impl Findings<'_> {
    /// The others, in a few words; nothing where there are none.
    pub(super) fn others(&self) -> String {
        if self.others.is_empty() {
            return String::new();
        }
        let mut names: Vec<String> = Vec::new();
        for name in self.others.iter().map(|finding| name(finding)) {
            if !names.contains(&name) && names.len() <= NAMED {
                names.push(name);
            }
        }
        let shown = names.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = if names.len() > NAMED { ", …" } else { "" };
        format!("and {} more of this code: {shown}{more}", self.others.len())
    }
}

/// What a finding is about, in a word or two.
fn name(finding: &Finding) -> String {
    let about = &finding.about;
    let element = about.elements.first().map(|label| format!("element {label}"));
    let node = || about.nodes.first().map(|label| format!("node {label}"));
    let line = || finding.line().map(|line| format!("line {line}"));
    let found = element.or_else(|| about.mpcs.first().cloned()).or_else(node).or_else(line);
    found.unwrap_or_else(|| finding.file().to_string())
}

/// Findings in their order, those of one code and severity together; what has the same words but for names is one.
pub(super) fn findings<'a>(all: impl IntoIterator<Item = &'a Finding>) -> Vec<Findings<'a>> {
    let mut found: Vec<(Findings<'a>, String)> = Vec::new();
    for finding in all {
        let shape = shape(finding.message());
        let is_code = |known: &Findings<'_>| {
            (known.first.code(), known.first.severity()) == (finding.code(), finding.severity())
        };
        let of_code: Vec<usize> = (0..found.len()).filter(|at| is_code(&found[*at].0)).collect();
        let same = of_code.iter().copied().find(|at| found[*at].1 == shape);
        let last = of_code.last().copied();
        let most = if finding.severity() == Severity::Error { KINDS } else { 1 };
        match (same, last) {
            (Some(at), _) => found[at].0.others.push(finding),
            (None, Some(last)) if of_code.len() >= most => found[last].0.others.push(finding),
            (None, last) => {
                let at = last.map_or(found.len(), |last| last + 1);
                found.insert(at, (Findings { first: finding, others: Vec::new() }, shape));
            }
        }
    }
    found.into_iter().map(|(group, _)| group).collect()
}

/// One thing that is wrong, or needs a look, of all connectors that have it.
pub(super) struct Fault<'a> {
    /// The connectors or types.
    pub(super) subjects: Vec<&'a Subject>,
    /// The check that tells most, of the first of them.
    pub(super) check: &'a Check,
    /// Others of the same that tell of it too.
    pub(super) also: Vec<&'a Check>,
}

impl Fault<'_> {
    /// Whether nothing is wrong.
    pub(super) fn is_mild(&self) -> bool {
        is_mild(self.check)
    }

    /// Whose it is: the first names, with their scene.
    pub(super) fn title(&self) -> String {
        let names: Vec<String> = self.subjects.iter().map(|subject| subject.name.clone()).collect();
        let scene = self.subjects.first().and_then(|subject| subject.scene.as_deref());
        scene.map_or_else(|| named(&names), |scene| format!("{} of {scene}", named(&names)))
    }

    /// Who else tells of it; nothing where nobody does.
    pub(super) fn witnesses(&self) -> String {
        let mut names: Vec<&str> = self.also.iter().map(|check| check.against.name()).collect();
        names.sort_unstable();
        names.dedup();
        names.retain(|name| *name != self.check.against.name());
        if names.is_empty() { String::new() } else { format!("told by {} too", names.join(", ")) }
    }
}

fn is_mild(check: &Check) -> bool {
    !check.verdict.is_mismatch() && check.score.survived == 0
}

/// What makes two checks of different connectors the same fault.
fn is_same(one: (&Subject, &Check), other: (&Subject, &Check)) -> bool {
    let entry =
        |check: &Check| check.worst.as_ref().map(|worst| worst.entry.clone()).filter(|_| !is_mild(check));
    let causes = |check: &Check| {
        let told = check.diagnosis.iter().flat_map(|diagnosis| diagnosis.lines());
        told.map(|(_, code)| code.as_str()).collect::<Vec<_>>()
    };
    let key = |check: &Check| {
        let open: Vec<String> = check.undecided.keys().cloned().collect();
        let lack = check.worst.as_ref().and_then(|worst| worst.lack);
        let what = (check.quantity, check.verdict, entry(check), causes(check));
        (what, open, lack)
    };
    let owner = |subject: &Subject| (subject.type_name.clone(), subject.scene.clone());
    owner(one.0) == owner(other.0) && key(one.1) == key(other.1)
}

/// Everything that needs a look, each thing once. Of a connector the checks of one kind of numbers are one, told by the one that tells
/// most; what laws say beside them is theirs too.
pub(super) fn faults(report: &Report) -> Vec<Fault<'_>> {
    let mut found: Vec<Fault<'_>> = Vec::new();
    let mut add = |subject, check, also: Vec<_>| {
        let same = found.iter_mut().find(|known| {
            known.subjects.first().is_some_and(|first| is_same((first, known.check), (subject, check)))
        });
        match same {
            Some(known) if known.subjects.last().is_some_and(|last| std::ptr::eq(*last, subject)) => {
                known.also.push(check);
            }
            Some(known) => known.subjects.push(subject),
            None => found.push(Fault { subjects: vec![subject], check, also }),
        }
    };
    for subject in &report.subjects {
        let (mild, wrong): (Vec<&Check>, Vec<&Check>) = telling(subject).partition(|check| is_mild(check));
        let mut left = wrong;
        while let Some(quantity) = left.iter().map(|check| check.quantity).max_by_key(Option::is_some) {
            let of_it = |check: &&Check| check.quantity == quantity || check.quantity.is_none();
            let (mut group, rest): (Vec<&Check>, Vec<&Check>) = left.into_iter().partition(of_it);
            left = rest;
            let tells = |check: &Check| {
                (
                    check.quantity.is_some(),
                    check.diagnosis.is_some(),
                    is_sharp(check),
                    check.comparison.is_some(),
                )
            };
            let most = (0..group.len()).rev().max_by_key(|at| tells(group[*at]));
            let Some(most) = most else { break };
            let check = group.remove(most);
            add(subject, check, group);
        }
        mild.into_iter().for_each(|check| add(subject, check, Vec::new()));
    }
    found
}
