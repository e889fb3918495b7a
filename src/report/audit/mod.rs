//! Reports of an audit: for reading, as JSON, as JUnit XML, as Markdown, as HTML.

mod html;
mod human;
mod junit;
mod markdown;
mod model;
mod summary;

pub(crate) use html::figure;
pub use html::{Audited, Supplement, figures, html};
pub use human::human;
pub use junit::junit;
pub use markdown::{LIMIT as MARKDOWN_LIMIT, markdown};

use crate::audit::Report;
use std::io::{self, Write};

/// The schema of the JSON report.
pub const SCHEMA: &str = "pintle-audit/1";

#[derive(serde::Serialize, schemars::JsonSchema)]
struct Document<'a> {
    schema: &'static str,
    /// What the program was built from, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    commit: Option<&'static str>,
    signs: &'static str,
    rows: &'static str,
    oracles: Vec<Described>,
    mismatches: usize,
    undecided: usize,
    /// Subjects with numbers of which no state tells whether a mistake would have been noticed.
    not_exercised: usize,
    /// Subjects with a state on a singular set where nobody could judge something.
    unjudged: usize,
    /// Models of which a finding is an error.
    failing_models: usize,
    warnings: usize,
    survivors: u64,
    /// Quantities of subjects on which independent oracles contradict each other.
    contradictions: usize,
    compared: u64,
    #[serde(flatten)]
    report: &'a Report,
}

#[derive(serde::Serialize, schemars::JsonSchema)]
struct Described {
    name: &'static str,
    meaning: &'static str,
    shares: crate::audit::oracle::Shares,
    independent: bool,
}

/// The JSON Schema of the JSON report.
pub fn schema() -> serde_json::Value {
    let settings = schemars::generate::SchemaSettings::default().for_serialize();
    let mut schema = settings.into_generator().into_root_schema_for::<Document<'_>>();
    schema.insert("title".to_owned(), SCHEMA.into());
    schema.to_value()
}

/// One JSON document, schema [`SCHEMA`].
///
/// # Errors
/// Where the stream cannot be written to.
pub fn json(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let oracles = report.settings.oracles.iter().map(|oracle| Described {
        name: oracle.name(),
        meaning: oracle.meaning(),
        shares: oracle.shares(),
        independent: oracle.is_independent(),
    });
    let document = Document {
        schema: SCHEMA,
        commit: crate::COMMIT,
        signs: super::SIGNS,
        rows: super::ROWS,
        oracles: oracles.collect(),
        mismatches: report.mismatches(),
        undecided: report.undecided(),
        not_exercised: report.not_exercised(),
        unjudged: report.unjudged(),
        failing_models: report.failing_models(),
        warnings: report.warnings(),
        survivors: report.survivors(),
        contradictions: report.contradictions(),
        compared: report.compared(),
        report,
    };
    serde_json::to_writer_pretty(&mut *out, &document).map_err(io::Error::from)?;
    writeln!(out)
}
