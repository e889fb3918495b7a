//! Why is it wrong? Wrong numbers are matched against what known mistakes make of the right ones: those of the self-test
//! ([`crate::mutants::mutant`]) and changes of convention.
//!
//! Numbers of a connector's components are [`Symptoms`]; those of multi-point constraints, frictions and slopes of behaviour stand in
//! a [`ResultTable`](crate::judge::table::ResultTable).
//!
//! A mistake *fits* where every entry that it makes is the one given, within the tolerance. One that fits is believed where chance
//! would not do it. Chance meets an entry off by n tolerances once in n, so that it is worth log₂ n bits. All entries explained
//! must be worth log₂(1000 N) bits together, N being the number of mistakes tried. A mistake explains more than another where the
//! entries that only it explains are worth log₂ 1000 bits. Those that explain as much are named beside it.
//!
//! All states are judged together at which a check was wrong: [`diagnose_all`]. What explains everything at nearly all of them comes
//! first, and what says least last: single entries, a constant. A constant is told of one number, the same at every state. Where nothing
//! is believed, that is said. Numbers that have lost digits besides are tried again with tolerances so much wider.
//!
//! | file | what mistakes make of |
//! |---|---|
//! | `cells` | (numbers by where they stand) |
//! | `columns` | the columns of rows, and with them rates and second derivatives |
//! | `component` | rows, rates, second derivatives, forces, stiffness |
//! | `values` | values |
//! | `dictionary` | values, rows and rates that are another number of the nodes |
//! | `parts` | rows that are a sum or a product of two directions |
//! | `elsewhere` | all of them, at other nodes than those that are meant |
//! | `matching` | one number at all states: constant factors, offsets, bounds, regularised norms, squares |
//! | `smoothed` | lengths that were made smooth at zero |
//! | `places` | special states: where they are |
//! | `seen` | numbers near special states, and nowhere else |
//! | `patterns` | digits: lost near special states, or few everywhere |

mod cells;
mod columns;
mod component;
mod dictionary;
mod elsewhere;
mod matching;
mod parts;
mod patterns;
mod places;
mod sample;
mod seen;
mod smoothed;
mod table;
mod values;

use pintle_scene::Code;
use pintle_scene::grammar::count;
use serde::Serialize;

pub use crate::mutants::cause::Cause;
pub use component::{Symptoms, conventions, diagnose, diagnose_all};
pub(crate) use dictionary::PARAMETERS;
pub(crate) use matching::Gather;
pub use matching::Hypothesis;
pub use places::{Places, places};
pub use sample::Sample;
pub use seen::Seen;
pub use table::{diagnose_table, diagnose_tables};

/// What becomes of a sum with other multiples of one of its parts: how many times the part more, and that in words.
pub(crate) const MULTIPLES: [(f64, &str); 4] =
    [(-1.0, "without"), (-0.5, "with half of"), (1.0, "with twice"), (-2.0, "with the other sign of")];

/// One mistake that explains wrong entries.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Explained {
    /// The mistake.
    #[serde(skip)]
    pub cause: Cause,
    /// Its code.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub code: Code,
    /// What equals what, and what that means.
    pub sentence: String,
    /// Others that make the same numbers at these states.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>"))]
    pub also: Vec<Code>,
}

/// Why numbers are wrong.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Diagnosis {
    /// The mistakes that explain wrong entries, the one that explains most first.
    pub causes: Vec<Explained>,
    /// Wrong entries that no known mistake explains.
    pub unexplained: usize,
}

impl Diagnosis {
    /// One line for each mistake, and one for what nothing explains, with codes.
    pub fn lines(&self) -> Vec<(String, Code)> {
        let mut lines: Vec<(String, Code)> =
            self.causes.iter().map(|found| (found.said(), found.code)).collect();
        if self.unexplained > 0 {
            let besides = if self.causes.is_empty() { "" } else { " besides" };
            let entries = count(self.unexplained, "wrong entry");
            lines.push((format!("no known mistake explains {entries}{besides}"), Code::DiagnosisUnknown));
        }
        lines
    }

    /// Whether known mistakes explain all that is wrong.
    pub fn is_whole(&self) -> bool {
        self.unexplained == 0 && !self.causes.is_empty()
    }

    /// Whether it says more than another about the same check: all is explained, by fewer mistakes, with fewer alternatives.
    pub fn is_clearer_than(&self, other: &Self) -> bool {
        let rank = |one: &Self| {
            let also: usize = one.causes.iter().map(|found| found.also.len()).sum();
            (one.causes.is_empty(), one.unexplained > 0, one.causes.len(), also)
        };
        rank(self) < rank(other)
    }
}

impl Explained {
    fn said(&self) -> String {
        // What says less of the same numbers adds nothing.
        let says_more = |code: &&Code| {
            !matches!(
                code,
                Code::DiagnosisDropped
                    | Code::DiagnosisSignOfEntry
                    | Code::DiagnosisSpurious
                    | Code::DiagnosisScaled
                    | Code::DiagnosisFactor
                    | Code::DiagnosisOffset
                    | Code::DiagnosisSignOfBlock
                    | Code::DiagnosisBlockMissing
            )
        };
        let others: Vec<&str> = self.also.iter().filter(says_more).map(|code| code.as_str()).collect();
        if others.is_empty() {
            return self.sentence.clone();
        }
        format!("{} (here the same as {})", self.sentence, others.join(", "))
    }
}
