//! How bad each code is taken to be: as it comes, or as the command line says.

use super::finding::Finding;
use crate::scene::{Code, Severity};
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

/// The levels that were set, by code, by group of codes (`model`, `assembly`, `rule` …), or for all `notes` or `warnings`. What is
/// said of a code outweighs what is said of its group, and that what is said of all.
///
/// ```
/// use pintle::audit::model::{Level, Levels};
/// use pintle::scene::{Code, Severity};
///
/// let mut levels = Levels::default();
/// levels.set("warnings", Level::Deny)?;
/// levels.set("assembly::mechanism", Level::Allow)?;
/// assert_eq!(levels.of(Code::ModelStopViolated, Severity::Warning), Some(Severity::Error));
/// assert_eq!(levels.of(Code::AssemblyMechanism, Severity::Note), None);
/// assert!(levels.set("model::no-such", Level::Deny).is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Levels {
    set: BTreeMap<String, Level>,
}

/// What names the findings that are notes, or warnings, by themselves.
const ALL: [(&str, Severity); 2] = [("notes", Severity::Note), ("warnings", Severity::Warning)];

impl Levels {
    /// Sets the level of a code, of a group of codes, of `notes` or of `warnings`.
    ///
    /// # Errors
    /// In words, where there is no such code or group, or its level is set otherwise already.
    pub fn set(&mut self, name: &str, level: Level) -> Result<(), String> {
        let name = name.trim().to_ascii_lowercase();
        let name = name.strip_suffix("::*").unwrap_or(&name).to_string();
        let is_known = ALL.iter().any(|(all, _)| *all == name)
            || Code::ALL.iter().any(|code| [code.as_str(), code.group()].contains(&name.as_str()));
        if !is_known {
            let codes = Code::ALL.iter().map(|code| code.as_str());
            let near = crate::scene::nearest(&name, codes);
            let meant = near.map_or_else(String::new, |near| format!("; did you mean {near}?"));
            return Err(format!("there is no code or group of codes {name:?}{meant}"));
        }
        match self.set.insert(name.clone(), level) {
            Some(other) if other != level => Err(format!("the level of {name} is set twice, differently")),
            _ => Ok(()),
        }
    }

    /// How bad a finding of this code is, which would be of `severity` by itself; `None` where it is not shown. An error that
    /// refuses the model stays one.
    pub fn of(&self, code: Code, severity: Severity) -> Option<Severity> {
        if severity == Severity::Error {
            return Some(severity);
        }
        let all = ALL.iter().find(|(_, of)| *of == severity).map_or("", |(name, _)| *name);
        self.said(&[code.as_str(), code.group(), all]).map_or(Some(severity), Level::severity)
    }

    /// Whether a code or its group was set to less than an error; of no effect where the finding refuses the model.
    pub fn is_lowered(&self, code: Code) -> bool {
        self.said(&[code.as_str(), code.group()]).is_some_and(|level| level != Level::Deny)
    }

    /// What is said of the first of these names of which something is said.
    fn said(&self, names: &[&str]) -> Option<Level> {
        names.iter().find_map(|name| self.set.get(*name)).copied()
    }

    /// The findings that are shown, as bad as they are taken to be.
    pub fn apply(&self, findings: Vec<Finding>) -> Vec<Finding> {
        let shown = findings.into_iter().filter_map(|finding| {
            let severity = self.of(finding.code(), finding.severity())?;
            Some(finding.of_severity(severity))
        });
        shown.collect()
    }
}
