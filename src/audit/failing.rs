//! What fails a check, as values: a connector's case, a constraint, a friction, a belt, springs and dampers.

use super::behavior::SlopesCase;
use super::case::Case;
use super::certificate::{certificate, certificate_of_mpc};
use super::counterexample::{CounterExample, ReplayError};
use super::engine::{Settings, audit_case};
use super::friction::{BeltCase, FrictionCase};
use super::golden::audit_at;
use super::mpc::MpcCase;
use super::oracle::Oracle;
use super::outcome::{Against, Check, Expected, Report, Subject};
use super::recorded::Recorded;
use super::sheet::Sheet;
use super::shrink::shrink;
use serde::Serialize;
use std::collections::BTreeSet;

/// One state of something that is judged.
#[derive(Clone, Debug)]
pub enum Failing {
    /// A connector after its history.
    Connector(Box<Case>),
    /// A multi-point constraint.
    Mpc(Box<MpcCase>),
    /// A friction in an increment.
    Friction(Box<FrictionCase>),
    /// A belt around a ring in an increment.
    Belt(Box<BeltCase>),
    /// Springs and dampers at a motion.
    Slopes(Box<SlopesCase>),
}

impl Failing {
    /// All checks of it, on 237 bits too; with mutants where it `proves`.
    pub(super) fn checks(&self, settings: &Settings, proves: bool) -> Vec<Check> {
        match self {
            Self::Connector(case) => {
                let mut checks = audit_case(case, settings, true, 0);
                checks.extend(audit_at(case, settings));
                checks
            }
            Self::Mpc(case) => case.audit(settings, proves),
            Self::Friction(case) => case.judged(settings, true, proves),
            Self::Belt(case) => case.judged(settings, true, proves),
            Self::Slopes(case) => case.audit(settings, proves).into_iter().collect(),
        }
    }

    /// The numbers that are judged, of what is neither connector nor constraint.
    pub(super) fn sheets(&self) -> Vec<Sheet> {
        match self {
            Self::Connector(_) | Self::Mpc(_) => Vec::new(),
            Self::Friction(case) => case.all_sheets(),
            Self::Belt(case) => case.sheets(),
            Self::Slopes(case) => case.sheets(),
        }
    }

    /// Whether a deck and its states can hold it: of a friction, whether it is the predefined one of a type. Belts, springs and dampers have
    /// the scene that they were found in, or none.
    pub(super) fn has_deck(&self) -> bool {
        match self {
            Self::Connector(case) => CounterExample::record(case, Against::Own).deck().is_ok(),
            Self::Mpc(_) => Recorded::stated(self).is_some_and(|recorded| recorded.deck().is_ok()),
            // What its deck needs besides is not lost where numbers become simpler.
            Self::Friction(case) => case.predefined().is_some(),
            Self::Belt(_) | Self::Slopes(_) => true,
        }
    }

    /// Whether it is known of each number what it must be, and how far it may be from that.
    pub(super) fn is_known(&self) -> bool {
        let is_finite = |sheet: &Sheet| {
            let mut entries = sheet.entries.iter();
            entries.all(|entry| entry.want.to_f64().is_finite() && entry.tolerance().is_finite())
        };
        match self {
            Self::Connector(_) => true,
            Self::Mpc(case) => case.sheets().iter().all(is_finite),
            Self::Friction(_) | Self::Belt(_) | Self::Slopes(_) => self.sheets().iter().all(is_finite),
        }
    }

    /// What it is, and of which state, in words.
    pub fn title(&self) -> String {
        match self {
            Self::Connector(case) => case.definition.connection.name.to_string(),
            Self::Mpc(case) => format!("MPC {}", case.constraint.kind().name()),
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
            Self::Friction(_) | Self::Belt(_) | Self::Slopes(_) => None,
        };
        let expected = match self {
            Self::Connector(case) => Expected::of(&case.connector()),
            Self::Mpc(_) => Expected::of_constraint(),
            Self::Friction(_) | Self::Belt(_) | Self::Slopes(_) => Expected::default(),
        };
        let checks = self.checks(settings, true);
        let subject = Subject::new(format!("{} now", self.title()), certificate, 1, checks, &expected);
        Report::new(settings, vec![subject], Vec::new())
    }

    /// The simplest values found at which the same check fails the same way.
    pub(super) fn shrunk(&self, fails: &dyn Fn(&Self) -> bool) -> Self {
        match self {
            Self::Connector(case) => {
                let fails = |case: &Case| fails(&Self::Connector(Box::new(case.clone())));
                Self::Connector(Box::new(shrink(case, &fails)))
            }
            other => Recorded::shrunk(other, fails),
        }
    }
}

/// A counter-example in a file: of a connector, or of something else.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Example {
    /// Of a connector.
    Connector(Box<CounterExample>),
    /// Of a constraint, a friction, springs and dampers.
    Other(Box<Recorded>),
}

impl Example {
    /// Reads a file's text: what names its kind is no connector.
    ///
    /// # Errors
    /// What is no counter-example: no JSON, another kind than there are, missing or unknown fields.
    pub fn read(text: &str) -> Result<Self, serde_json::Error> {
        let document: serde_json::Value = serde_json::from_str(text)?;
        // From the text, for numbers of a value are not those of the text to the last bit.
        if document.get("kind").is_some() {
            return Ok(Self::Other(Box::new(serde_json::from_str(text)?)));
        }
        Ok(Self::Connector(Box::new(serde_json::from_str(text)?)))
    }

    /// Of a check that failed; `None` for one that did not, or of which nothing was kept.
    pub fn of(check: &Check, subject: &str) -> Option<Self> {
        match check.failing.as_deref()? {
            Failing::Connector(_) => Some(Self::Connector(Box::new(CounterExample::of(check, subject)?))),
            _ => Some(Self::Other(Box::new(Recorded::of(check, subject)?))),
        }
    }

    /// The same as what these oracles found.
    pub(super) fn found_by(mut self, asked: &BTreeSet<Oracle>) -> Self {
        if *asked != BTreeSet::from(Oracle::ALL) {
            let oracles = asked.iter().copied().collect();
            match &mut self {
                Self::Connector(example) => example.oracles = oracles,
                Self::Other(recorded) => recorded.oracles = oracles,
            }
        }
        self
    }

    /// The oracles that found it: a replay must ask the same.
    pub fn oracles(&self) -> BTreeSet<Oracle> {
        let written = match self {
            Self::Connector(example) => &example.oracles,
            Self::Other(recorded) => &recorded.oracles,
        };
        if written.is_empty() { Oracle::ALL.into() } else { written.iter().copied().collect() }
    }

    /// What failed, bit for bit.
    ///
    /// # Errors
    /// Another schema, values that make no such thing, values that are not finite.
    pub fn failing(&self) -> Result<Failing, ReplayError> {
        match self {
            Self::Connector(example) => Ok(Failing::Connector(Box::new(example.case()?))),
            Self::Other(recorded) => recorded.failing(),
        }
    }
}
