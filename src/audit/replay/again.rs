//! What failed, judged again: as it is, and made small for a counter-example.

use crate::case::Case;
use crate::case::failing::Failing;
use crate::engine::audit_case;
use crate::judge::outcome::{Against, Check, Expected, Report, Subject};
use crate::judge::table::ResultTable;
use crate::oracles::certificate::{certificate, certificate_named, certificate_of_mpc};
use crate::oracles::golden::audit_at;
use crate::replay::counterexample::CounterExample;
use crate::replay::shrink::{shrink, shrink_values};
use crate::settings::Settings;
use std::cell::Cell;

/// A counter-example of a report.
#[derive(Clone, Debug)]
pub struct Found {
    /// The subject and the check of which it is one, by their places in the report.
    pub at: [usize; 2],
    /// A name for its file, of which there is no other.
    pub name: String,
    /// Its values.
    pub example: CounterExample,
}

impl Failing {
    /// All checks of it, on 237 bits too; with mutants where it `proves`.
    pub fn checks(&self, settings: &Settings, proves: bool) -> Vec<Check> {
        match self {
            Self::Connector(case) => {
                let mut checks = audit_case(case, settings, true, 0);
                checks.extend(audit_at(case, settings));
                checks
            }
            Self::Mpc(case) => case.audit(settings, proves),
            Self::Relation(case) => case.audit(settings, proves),
            Self::Friction(case) => case.judged(settings, true, proves),
            Self::Belt(case) => case.judged(settings, true, proves),
            Self::Slopes(case) => case.audit(settings, proves).into_iter().collect(),
        }
    }

    /// The numbers that are judged, of what is neither connector nor constraint.
    pub fn tables(&self) -> Vec<ResultTable> {
        match self {
            Self::Connector(_) | Self::Mpc(_) => Vec::new(),
            Self::Relation(case) => case.tables(),
            Self::Friction(case) => case.all_tables(),
            Self::Belt(case) => case.tables(),
            Self::Slopes(case) => case.tables(),
        }
    }

    /// Whether a deck and its states can hold it, where it is of a connector.
    pub fn has_deck(&self) -> bool {
        match self {
            Self::Connector(case) => {
                CounterExample::record(case, Against::Own).deck_of_connector(case).is_ok()
            }
            Self::Mpc(_) | Self::Relation(_) | Self::Friction(_) | Self::Belt(_) | Self::Slopes(_) => true,
        }
    }

    /// Whether it is known of each number what it must be, and how far it may be from that.
    pub fn is_known(&self) -> bool {
        let is_finite = |table: &ResultTable| {
            let mut entries = table.entries.iter();
            entries.all(|entry| entry.want.to_f64().is_finite() && entry.tolerance().is_finite())
        };
        match self {
            Self::Connector(_) => true,
            Self::Mpc(case) => case.tables().iter().all(is_finite),
            Self::Relation(_) | Self::Friction(_) | Self::Belt(_) | Self::Slopes(_) => {
                self.tables().iter().all(is_finite)
            }
        }
    }

    /// What it is, and of which state, in words.
    pub fn title(&self) -> String {
        match self {
            Self::Connector(case) => case.definition.connection.name.to_string(),
            Self::Mpc(case) => format!("MPC {}", case.constraint.kind().name()),
            Self::Relation(case) => case.type_name.clone(),
            Self::Friction(case) => format!("friction of {}", case.name()),
            Self::Belt(case) => format!("belt of {}", case.name),
            Self::Slopes(case) => format!("springs and dampers of {}", case.name),
        }
    }

    /// Judges it again, by everything that is asked, with mutants.
    pub fn audit(&self, settings: &Settings) -> Report {
        let certificate = match self {
            Self::Connector(case) => certificate(&case.definition.connection),
            Self::Mpc(case) => certificate_of_mpc(case.constraint.kind()),
            Self::Relation(case) => certificate_named(&case.type_name),
            Self::Friction(_) | Self::Belt(_) | Self::Slopes(_) => None,
        };
        let expected = match self {
            Self::Connector(case) => Expected::of(&case.connector()),
            Self::Mpc(_) => Expected::of_constraint(),
            Self::Relation(case) => Expected::of_relation(&case.relation),
            Self::Friction(_) | Self::Belt(_) | Self::Slopes(_) => Expected::default(),
        };
        let checks = self.checks(settings, true);
        let subject = Subject::new(format!("{} now", self.title()), certificate, 1, checks, &expected);
        Report::new(settings, vec![subject], Vec::new())
    }

    /// The simplest values found at which the same check fails the same way.
    pub fn shrunk(&self, fails: &dyn Fn(&Self) -> bool) -> Self {
        match self {
            Self::Connector(case) => {
                let fails = |case: &Case| fails(&Self::Connector(Box::new(case.clone())));
                Self::Connector(Box::new(shrink(case, &fails)))
            }
            other => shrink_values(other, fails),
        }
    }
}

impl Report {
    /// A counter-example for every failed check, shrunk to the simplest values that still fail.
    pub fn counter_examples(&self) -> Vec<Found> {
        let mut found: Vec<Found> = Vec::new();
        for (of, subject) in self.subjects.iter().enumerate() {
            let failed = subject.checks.iter().enumerate().filter(|(_, check)| check.verdict.is_mismatch());
            for (i, (place, check)) in failed.enumerate() {
                let Some(failing) = &check.failing else { continue };
                // Of what is no connector, tables of other oracles are made apart.
                let oracles = match (check.against, failing.as_ref()) {
                    (Against::Oracle(oracle), other) if !matches!(other, Failing::Connector(_)) => {
                        [oracle].into()
                    }
                    _ => self.settings.oracles.clone(),
                };
                let settings = Settings { oracles, ..self.settings.clone() };
                // Values of which nobody can say what they make fail for another reason.
                let is_told = |check: &Check| {
                    check.worst.as_ref().is_some_and(|w| w.want.is_finite() && w.tolerance.is_finite())
                };
                let same = |failing: &Failing| {
                    let checks = failing.checks(&settings, false);
                    checks.into_iter().find(|other| {
                        (other.quantity, other.against) == (check.quantity, check.against)
                            && other.verdict == check.verdict
                            && (is_told(other) || !is_told(check))
                    })
                };
                // Once a scene can hold it, it stays what one can hold, and where every number is known, it stays where it is.
                let has_deck = Cell::new(failing.has_deck());
                let is_known = failing.is_known();
                let is_kept = |failing: &Failing| {
                    let deck = failing.has_deck();
                    let kept = (deck || !has_deck.get())
                        && same(failing).is_some()
                        && (!is_known || failing.is_known());
                    has_deck.set(has_deck.get() || kept && deck);
                    kept
                };
                let small = failing.shrunk(&is_kept);
                let example = CounterExample::of(same(&small).as_ref().unwrap_or(check), &subject.name)
                    .map(|example| example.found_by(&self.settings.oracles));
                let words: String = subject
                    .name
                    .chars()
                    .map(|c| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { '-' })
                    .collect();
                // Connectors of two scenes may have one name.
                let mut names = (i..).map(|i| format!("{words}-{i}.json"));
                let name = names.find(|name| found.iter().all(|other| other.name != *name));
                let with = |(name, example)| Found { at: [of, place], name, example };
                found.extend(name.zip(example).map(with));
            }
        }
        found
    }
}
