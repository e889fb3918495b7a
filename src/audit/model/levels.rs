//! How bad each code is taken to be: as it comes, or as the command line says.

use super::finding::Finding;
use crate::scene::{Code, Diagnostic, Severity};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Display};

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

/// The levels that were set, by code, by group of codes (`model`, `assembly`, `rule` …), or for all `notes` or `warnings`; everywhere, or
/// at a place: `CODE@FILE` or `CODE@FILE:LINE`. What is said of a line outweighs what is said of its file, and that what is said everywhere; at one
/// place, what is said of a code outweighs what is said of its group, and that what is said of all.
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
/// assert!(levels.set("diagnosis::secant", Level::Deny).is_err());
/// levels.set("model::stop-violated@deck.inp:12", Level::Note)?;
/// let at = |line| levels.at(Code::ModelStopViolated, Severity::Warning, "models/deck.inp", Some(line));
/// assert_eq!((at(11), at(12)), (Some(Severity::Error), Some(Severity::Note)));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Levels {
    set: BTreeMap<(Option<Place>, String), Level>,
}

/// A file, and a line of it, counted from 1, where one is named.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    file: String,
    line: Option<u32>,
}

impl Place {
    /// `FILE` or `FILE:LINE`.
    fn read(text: &str) -> Option<Self> {
        let (file, line) = match text.rsplit_once(':') {
            Some((file, line)) if line.bytes().all(|digit| digit.is_ascii_digit()) => {
                (file, Some(line.parse().ok().filter(|line| *line > 0)?))
            }
            _ => (text, None),
        };
        let file = file.strip_prefix("./").unwrap_or(file);
        (!file.is_empty()).then(|| Self { file: file.to_string(), line })
    }

    /// Whether a file is this one: by its path, or the end of it.
    fn is_of(&self, file: &str) -> bool {
        let before = file.strip_suffix(&self.file);
        before.is_some_and(|before| before.is_empty() || before.ends_with('/'))
    }

    /// Whether something of a file, at a line, is at this place.
    fn has(&self, file: &str, line: Option<u32>) -> bool {
        self.is_of(file) && (self.line.is_none() || self.line == line)
    }

    /// Whether it is this line of that file.
    fn is_line(&self, file: &str, line: Option<u32>) -> bool {
        self.line.is_some() && self.has(file, line)
    }
}

impl Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.file)?;
        self.line.map_or(Ok(()), |line| write!(formatter, ":{line}"))
    }
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
    /// Sets the level of a code, of a group of codes, of `notes` or of `warnings`, everywhere or at a place after `@`.
    ///
    /// # Errors
    /// In words, where there is no such code or group, none that a level applies to ([`Code::takes_level`]), the place is none, or its level is set
    /// otherwise already.
    pub fn set(&mut self, name: &str, level: Level) -> Result<(), String> {
        let whole = name.trim();
        let (name, place) = match whole.split_once('@') {
            Some((name, place)) => {
                let read = Place::read(place);
                let wrong = || {
                    format!("{place:?} is no place: after @ stands FILE or FILE:LINE, lines counted from 1")
                };
                (name, Some(read.ok_or_else(wrong)?))
            }
            None => (whole, None),
        };
        let name = name.to_ascii_lowercase();
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
        match self.set.insert((place, name), level) {
            Some(other) if other != level => Err(format!("the level of {whole} is set twice, differently")),
            _ => Ok(()),
        }
    }

    /// The files for which a level was set that are none of these, but for what is not shown: a list of what is accepted in many files may be longer
    /// than that of those audited.
    pub fn of_other_files(&self, files: &[&str]) -> Vec<&str> {
        let set = self.set.iter().filter(|(_, level)| **level != Level::Allow);
        let places = set.filter_map(|((place, _), _)| place.as_ref());
        let mut others: Vec<&str> = places
            .filter(|place| !files.iter().any(|file| place.is_of(file)))
            .map(|place| place.file.as_str())
            .collect();
        others.dedup();
        others
    }

    /// The levels of lines, `CODE@FILE:LINE`, in files of these, to which no finding answers: `answered` has those to which one does
    /// ([`super::ModelReport::answered`]).
    pub fn unanswered(&self, files: &[&str], answered: &BTreeSet<String>) -> Vec<String> {
        let is_audited = |place: &Place| files.iter().any(|file| place.is_of(file));
        let of_lines = self.set.keys().filter_map(|(place, name)| {
            let place = place.as_ref().filter(|place| place.line.is_some() && is_audited(place))?;
            Some(format!("{name}@{place}"))
        });
        of_lines.filter(|said| !answered.contains(said)).collect()
    }

    /// Those of them to which findings answer, as bad as they come.
    pub(super) fn answered(&self, findings: &[Finding]) -> BTreeSet<String> {
        findings.iter().flat_map(|finding| self.of_line(finding)).collect()
    }

    /// Whether a level was set for the very line at which a finding is: it is told by itself then.
    pub(in crate::audit) fn singles_out(&self, finding: &Finding) -> bool {
        self.of_line(finding).next().is_some()
    }

    /// The levels of lines to which a finding answers.
    fn of_line(&self, finding: &Finding) -> impl Iterator<Item = String> {
        let names = names(finding.code(), finding.severity());
        self.set.keys().filter_map(move |(place, name)| {
            let place = place.as_ref().filter(|place| place.is_line(finding.file(), finding.line()))?;
            names.contains(&name.as_str()).then(|| format!("{name}@{place}"))
        })
    }

    /// How bad a finding of this code is, which would be of `severity` by itself, where nothing is said of its place; `None` where it is not shown.
    pub fn of(&self, code: Code, severity: Severity) -> Option<Severity> {
        self.at(code, severity, "", None)
    }

    /// The same of one in a file, at a line. An error that leaves nothing to evaluate stays one ([`Code::leaves_numbers`]).
    pub fn at(&self, code: Code, severity: Severity, file: &str, line: Option<u32>) -> Option<Severity> {
        if severity == Severity::Error && !code.leaves_numbers() {
            return Some(severity);
        }
        self.said(code, severity, file, line).map_or(Some(severity), Level::severity)
    }

    /// Whether what refuses a scene is taken for less than an error, so that the scene is not refused.
    pub fn lets_pass(&self, diagnostic: &Diagnostic) -> bool {
        self.of_diagnostic(diagnostic) != Some(Severity::Error)
    }

    /// Whether a finding is of a code that was set to less than an error there; of no effect where it leaves nothing to evaluate.
    pub fn is_lowered(&self, finding: &Finding) -> bool {
        let said = self.said(finding.code(), Severity::Error, finding.file(), finding.line());
        said.is_some_and(|level| level != Level::Deny)
    }

    /// What is said of a code, its group, or all of its severity, at the narrowest place.
    fn said(&self, code: Code, severity: Severity, file: &str, line: Option<u32>) -> Option<Level> {
        let names = names(code, severity);
        let weight = |(place, name): &(Option<Place>, String)| {
            let of_place = match place {
                None => 0,
                Some(place) if !place.has(file, line) => return None,
                Some(Place { line: None, .. }) => 1,
                Some(_) => 2,
            };
            let of_name = names.iter().rev().position(|of| of == name)?;
            Some((of_place, of_name))
        };
        let heaviest =
            self.set.iter().filter_map(|(key, level)| Some((weight(key)?, level))).max_by_key(|x| x.0);
        heaviest.map(|(_, level)| *level)
    }

    /// How bad a finding is taken to be, where it is; `None` where it is not shown.
    pub fn of_finding(&self, finding: &Finding) -> Option<Severity> {
        self.of_diagnostic(finding.diagnostic())
    }

    /// How bad what a diagnostic says is taken to be, where it is; `None` where it is not shown.
    pub fn of_diagnostic(&self, diagnostic: &Diagnostic) -> Option<Severity> {
        self.at(diagnostic.code(), diagnostic.severity(), diagnostic.file(), diagnostic.line())
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
