//! What needs a look: what went wrong, subject by subject, what tells most first.

use crate::audit::groups;
use crate::audit::groups::Fault;
use crate::audit::html::figure;
use crate::audit::html::figure::Medium;
use crate::audit::html::prose::{capital, full_name, sentence};
use crate::audit::summary;
use crate::audit::summary::{against_tolerance, is_sharp};
use pintle_audit::{Check, Report, Subject};
use pintle_scene::grammar::count;

/// What is to be said of one subject: what tells most, and the rest.
pub(super) struct ProblemGroup {
    pub(super) subject: String,
    pub(super) is_mild: bool,
    pub(super) shown: Vec<Problem>,
    pub(super) rest: Vec<Problem>,
    /// How many they are.
    pub(super) more: String,
}

pub(super) struct Problem {
    pub(super) is_mild: bool,
    pub(super) said: String,
    /// Sentences with codes.
    pub(super) diagnosis: Vec<(String, &'static str)>,
    /// The matrix, where it is one of first derivatives.
    pub(super) heat: String,
    pub(super) numbers: String,
    pub(super) more: Vec<String>,
}

pub(super) fn problems(report: &Report) -> Vec<ProblemGroup> {
    let mut found = Vec::new();
    let faults = groups::faults(report);
    let (mild, wrong): (Vec<&Fault<'_>>, Vec<&Fault<'_>>) = faults.iter().partition(|fault| fault.is_mild());
    for fault in wrong.into_iter().chain(mild) {
        let Some(subject) = fault.subjects.first() else { continue };
        let checks = std::iter::once(fault.check).chain(fault.also.iter().copied());
        found.push(group(fault.title(), checks.map(|check| problem(subject, check)).collect()));
    }
    for approach in report.atlas.iter().filter(|approach| !approach.is_confirmed()) {
        let problem = Problem {
            is_mild: false,
            said: format!("At {}: {}.", approach.at, approach.told()),
            diagnosis: Vec::new(),
            heat: String::new(),
            numbers: String::new(),
            more: Vec::new(),
        };
        found.push(group(format!("{} {}", approach.connection, approach.component), vec![problem]));
    }
    found
}

/// Each diagnosis is shown once, at the first check that it is of; without any, the first check. The rest is folded.
pub(super) fn group(subject: String, mut all: Vec<Problem>) -> ProblemGroup {
    all.sort_by_key(|problem| problem.is_mild);
    let is_mild = all.iter().all(|problem| problem.is_mild);
    let (mut shown, mut rest): (Vec<Problem>, Vec<Problem>) = (Vec::new(), Vec::new());
    for mut problem in all {
        let is_new = !problem.diagnosis.is_empty()
            && shown.iter().all(|known: &Problem| known.diagnosis != problem.diagnosis);
        if is_new {
            shown.push(problem);
        } else {
            if !problem.diagnosis.is_empty() {
                problem.heat = String::new();
            }
            rest.push(problem);
        }
    }
    if shown.is_empty() && !rest.is_empty() {
        shown.push(rest.remove(0));
    }
    let more = count(rest.len(), "more check");
    ProblemGroup { subject, is_mild, shown, rest, more }
}

pub(super) fn problem(subject: &Subject, check: &Check) -> Problem {
    let of = check.quantity.map_or_else(String::new, |quantity| format!("{} against ", quantity.name()));
    let mut numbers = String::new();
    if let Some(worst) = &check.worst {
        numbers = against_tolerance(worst);
        if let Some(state) = &check.worst_state {
            numbers += &format!(", at {state}");
        }
    }
    let mut more: Vec<String> = summary::sides(check).map(|text| sentence(&text)).collect();
    more.extend(summary::undecided(check));
    more.extend(
        check.score.survivors.iter().map(|(mistake, entry)| format!("Survived: {mistake} ({entry}).")),
    );
    Problem {
        is_mild: !check.verdict.is_mismatch() && check.score.survived == 0,
        said: capital(&format!("{of}{}: {}.", check.against.name(), check.verdict.headline().name())),
        diagnosis: check
            .diagnosis
            .iter()
            .flat_map(|diagnosis| diagnosis.lines())
            .map(|(sentence, code)| (capital(&sentence), code.as_str()))
            .collect(),
        heat: check.comparison.as_ref().filter(|_| is_sharp(check)).map_or_else(String::new, |comparison| {
            figure::heat(&full_name(subject), comparison, Medium::Page)
        }),
        numbers,
        more,
    }
}
