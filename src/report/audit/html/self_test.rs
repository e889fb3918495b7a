//! Would it have noticed? How mutants fared, and what was left out.

use crate::audit::html::prose::{full_name, grouped};
use crate::audit::summary;
use crate::audit::summary::OfKind;
use pintle_audit::{Against, Cause, Report};
use std::collections::BTreeMap;

pub(super) struct ScoreRow {
    pub(super) name: &'static str,
    pub(super) killed: Count,
    pub(super) decisive: Count,
    pub(super) survived: Count,
    pub(super) equivalent: Count,
    pub(super) below: Count,
    pub(super) share: f64,
    pub(super) percent: String,
}

/// A count, shown with thin spaces between thousands.
pub(super) struct Count(pub(super) u64);

impl std::fmt::Display for Count {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&grouped(self.0))
    }
}

/// Mutants with one kind of mistake.
pub(super) struct KindRow {
    pub(super) name: &'static str,
    pub(super) code: &'static str,
    pub(super) killed: Count,
    pub(super) decisive: Count,
    pub(super) survived: Count,
    pub(super) equivalent: Count,
    pub(super) below: Count,
    pub(super) by_laws: Count,
    pub(super) share: f64,
    pub(super) percent: String,
}

pub(super) fn scores(report: &Report) -> Vec<ScoreRow> {
    let mut by_check: BTreeMap<(bool, Against), ScoreRow> = BTreeMap::new();
    for check in report.subjects.iter().flat_map(|subject| &subject.checks) {
        let key = (matches!(check.against, Against::Law(_)), check.against);
        let row = by_check.entry(key).or_insert_with(|| ScoreRow {
            name: check.against.name(),
            killed: Count(0),
            decisive: Count(0),
            survived: Count(0),
            equivalent: Count(0),
            below: Count(0),
            share: 0.0,
            percent: String::new(),
        });
        // What a law does not notice is no survivor.
        row.killed.0 += check.score.killed;
        row.decisive.0 += check.score.decisive();
        row.survived.0 += check.score.survived;
        row.equivalent.0 += check.score.equivalent;
        row.below.0 += check.score.below_resolution;
    }
    let mut rows: Vec<ScoreRow> = by_check.into_values().collect();
    for row in &mut rows {
        (row.share, row.percent) = share(row.killed.0, row.decisive.0);
    }
    rows.retain(|row| row.decisive.0 + row.equivalent.0 + row.below.0 > 0);
    rows
}

/// The part of mutants that was noticed, in percent: as a number, and in words.
pub(super) fn share(killed: u64, decisive: u64) -> (f64, String) {
    if decisive == 0 {
        return (0.0, String::new());
    }
    let share = 100.0 * killed as f64 / decisive as f64;
    (share, format!("{share:.1} %"))
}

pub(super) fn kinds(report: &Report) -> Vec<KindRow> {
    let row = |(cause, OfKind { by_oracles, by_laws }): (Cause, OfKind)| {
        let (share, percent) = share(by_oracles.killed, by_oracles.decisive());
        KindRow {
            name: cause.meaning(),
            code: cause.code().as_str(),
            killed: Count(by_oracles.killed),
            decisive: Count(by_oracles.decisive()),
            survived: Count(by_oracles.survived),
            equivalent: Count(by_oracles.equivalent),
            below: Count(by_oracles.below_resolution),
            by_laws: Count(by_laws),
            share,
            percent,
        }
    };
    summary::by_mistake(report).into_iter().map(row).collect()
}

/// Numbers without a witness, those that no state exercises, and laws that were not asked, with the connectors: once for each list.
pub(super) fn left_out(report: &Report) -> Vec<String> {
    let of = |(text, subjects): (String, Vec<&str>)| format!("{}: {text}.", subjects.join(", "));
    summary::left_out(report).into_iter().map(of).collect()
}

pub(super) fn survivors(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    for subject in &report.subjects {
        for check in &subject.checks {
            for (mistake, entry) in &check.score.survivors {
                lines.push(format!(
                    "{}, {}: {mistake} survived ({entry})",
                    full_name(subject),
                    check.against.name()
                ));
            }
        }
    }
    lines
}
