//! How bad each code is taken to be: as it comes, or as the command line says.

use crate::model::finding::Finding;
use pintle_scene::{Code, Diagnostic, Severity};
use std::collections::BTreeMap;

/// What becomes of the findings of a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// They are not shown.
    Allow,
    /// They are notes.
    Note,
    /// They are warnings.
    Warn,
    /// They are errors: the audit fails.
    Deny,
}

impl Level {
    const fn severity(self) -> Option<Severity> {
        match self {
            Self::Allow => None,
            Self::Note => Some(Severity::Note),
            Self::Warn => Some(Severity::Warning),
            Self::Deny => Some(Severity::Error),
        }
    }
}

/// The levels that were set, by code, by group of codes (`model`, `assembly`, `rule` …), or for all `notes` or `warnings`. What is said of a code
/// outweighs what is said of its group, and that what is said of all.
///
/// ```
/// use pintle_audit::model::{Level, Levels};
/// use pintle_scene::{Code, Severity};
///
/// let mut levels = Levels::default();
/// levels.set("warnings", Level::Deny)?;
/// levels.set("assembly::mechanism", Level::Allow)?;
/// assert_eq!(levels.of(Code::ModelStopViolated, Severity::Warning), Some(Severity::Error));
/// assert_eq!(levels.of(Code::AssemblyMechanism, Severity::Note), None);
/// assert!(levels.set("model::no-such", Level::Deny).is_err());
/// assert!(levels.set("diagnosis::secant", Level::Deny).is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Levels {
    set: BTreeMap<String, Level>,
}

/// What names the findings that are notes, or warnings, by themselves.
const ALL: [(&str, Severity); 2] = [("notes", Severity::Note), ("warnings", Severity::Warning)];

/// By what a finding is named: its code, its group, and all of its severity.
fn names(code: Code, severity: Severity) -> [&'static str; 3] {
    let all = ALL.iter().find(|(_, of)| *of == severity).map_or("", |(name, _)| *name);
    [code.as_str(), code.group(), all]
}

/// The groups that have a code to which a level applies.
fn groups() -> Vec<&'static str> {
    let takes = |group: &&str| Code::ALL.iter().any(|code| code.group() == *group && code.takes_level());
    Code::groups().into_iter().filter(takes).collect()
}

/// In words why no level applies to a code, or to any of a group.
fn refuse(name: &str) -> Result<(), String> {
    let mut of_name =
        Code::ALL.iter().filter(|code| [code.as_str(), code.group()].contains(&name)).peekable();
    let Some(first) = of_name.peek().copied() else { return Ok(()) };
    if of_name.any(|code| code.takes_level()) {
        return Ok(());
    }
    let (why, remedy) = if first.names_a_cause() {
        let why =
            "it names the cause of a wrong number, and a wrong number fails the audit whatever its cause";
        (why, "correct the number")
    } else {
        ("it is an error that leaves nothing to audit", "correct the file in which it is")
    };
    let page = if name == first.as_str() { format!(" (pintle explain {name})") } else { String::new() };
    Err(format!("no level applies to {name}: {why}; leave it out here, and {remedy}{page}"))
}

impl Levels {
    /// Sets the level of a code, of a group of codes, of `notes` or of `warnings`.
    ///
    /// # Errors
    /// In words, where there is no such code or group, none that a level applies to ([`Code::takes_level`]), or its level is set otherwise already.
    pub fn set(&mut self, name: &str, level: Level) -> Result<(), String> {
        let whole = name.trim();
        let name = whole.to_ascii_lowercase();
        let name = name.strip_suffix("::*").unwrap_or(&name).to_string();
        let is_known = ALL.iter().any(|(all, _)| *all == name)
            || Code::ALL.iter().any(|code| [code.as_str(), code.group()].contains(&name.as_str()));
        if !is_known {
            let meant = match Code::nearest(&name) {
                Some(near) => format!("; did you mean {}?", near.as_str()),
                None => format!(
                    "; findings have their codes in brackets, groups are {}, and there are notes and warnings",
                    groups().join(", ")
                ),
            };
            return Err(format!("there is no code or group of codes {name:?}{meant}"));
        }
        refuse(&name)?;
        match self.set.insert(name, level) {
            Some(other) if other != level => Err(format!("the level of {whole} is set twice, differently")),
            _ => Ok(()),
        }
    }

    /// How bad a finding of this code is, which would be of `severity` by itself; `None` where it is not shown. An error that leaves nothing to
    /// evaluate stays one ([`Code::leaves_numbers`]).
    pub fn of(&self, code: Code, severity: Severity) -> Option<Severity> {
        if severity == Severity::Error && !code.leaves_numbers() {
            return Some(severity);
        }
        self.said(code, severity).map_or(Some(severity), Level::severity)
    }

    /// Whether what refuses a scene is taken for less than an error, so that the scene is not refused.
    pub fn lets_pass(&self, diagnostic: &Diagnostic) -> bool {
        self.of_diagnostic(diagnostic) != Some(Severity::Error)
    }

    /// Whether a finding is of a code that was set to less than an error; of no effect where it leaves nothing to evaluate.
    pub fn is_lowered(&self, finding: &Finding) -> bool {
        self.said(finding.code(), Severity::Error).is_some_and(|level| level != Level::Deny)
    }

    /// What is said of a code, else of its group, else of all of its severity.
    fn said(&self, code: Code, severity: Severity) -> Option<Level> {
        names(code, severity).into_iter().find_map(|name| self.set.get(name).copied())
    }

    /// How bad a finding is taken to be; `None` where it is not shown.
    pub fn of_finding(&self, finding: &Finding) -> Option<Severity> {
        self.of_diagnostic(finding.diagnostic())
    }

    /// How bad what a diagnostic says is taken to be; `None` where it is not shown.
    pub fn of_diagnostic(&self, diagnostic: &Diagnostic) -> Option<Severity> {
        self.of(diagnostic.code(), diagnostic.severity())
    }

    /// The findings that are shown, as bad as they are taken to be.
    pub fn apply(&self, findings: Vec<Finding>) -> Vec<Finding> {
        let shown = findings.into_iter().filter_map(|finding| {
            let severity = self.of_finding(&finding)?;
            Some(finding.of_severity(severity))
        });
        shown.collect()
    }
}
