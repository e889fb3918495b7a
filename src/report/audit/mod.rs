//! Reports of an audit: for reading, as JSON, as JUnit XML, as Markdown, as HTML.

mod checked;
mod groups;
pub(crate) mod html;
mod human;
mod junit;
mod markdown;
mod model;
mod summary;

pub use checked::{checked, likeness};
pub(crate) use html::figure;
pub use html::{Audited, Supplement, figures, html};
pub use human::human;
pub use junit::junit;
pub use markdown::{LIMIT as MARKDOWN_LIMIT, markdown};

use pintle_audit::Report;
use std::io::{self, Write};

/// The schema of the JSON report.
pub const SCHEMA: &str = "pintle-audit/1";

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Described {
    name: &'static str,
    meaning: &'static str,
    shares: pintle_audit::oracles::oracle::Shares,
    independent: bool,
}

/// The JSON Schema of the JSON report, as text.
pub const SCHEMA_TEXT: &str = include_str!("../../../schema/pintle-audit-1.json");

/// The JSON Schema that the types give; [`SCHEMA_TEXT`] is its copy.
#[cfg(feature = "schema")]
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
        commit: pintle_bench::COMMIT,
        signs: crate::SIGNS,
        rows: crate::ROWS,
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

/// A report as an assertion.
pub trait AssertOk {
    /// Panics with the report for reading, unless nothing is wrong and something is verified: for `#[test]`s. Claims on numbers are
    /// that derivatives are those of the function, and that the formula is the manual's. Each is verified where an independent oracle has judged
    /// it; what is undecided is no pass. The claim on the declaration, which no routine's numbers bear on, is not asked.
    ///
    /// ```should_panic
    /// # use pintle_audit::{Candidate, Oracle, Settings};
    /// # use pintle_report::audit::AssertOk;
    /// # use pintle_kinematics::catalog::ConnectionType;
    /// # use pintle_kinematics::connector::Definition;
    /// # use pintle_kinematics::node::{Node, Pair};
    /// # use pintle_kinematics::vector::identity;
    /// # let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    /// # let pair = Pair { reference: [2.0, 0.0, 0.0], a: node, b: node };
    /// # let axial = Definition::new(ConnectionType::named("AXIAL", None).unwrap(), pair);
    /// # let routine = |state: &pintle_kinematics::connector::State<f64>| {
    /// #     let d = state.pair.separation();
    /// #     let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
    /// #     let row = std::array::from_fn(|j| match j { 0..3 => -d[j] / length, 7..10 => d[j - 7] / length, _ => 0.0 });
    /// #     ([Some(length - 2.0), None, None, None, None, None], [Some(row), None, None, None, None, None])
    /// # };
    /// // Right or not: dual numbers share with ours how derivatives come about, and no other witness is asked.
    /// let settings = Settings { states: 20, atlas: false, oracles: [Oracle::NodalDual].into(), ..Settings::default() };
    /// Candidate::new("my AXIAL", &axial).settings(settings).check(routine).assert_ok();
    /// ```
    ///
    /// # Panics
    /// Where a number is wrong, nothing was compared, a mutant survived, or the derivative or the formula of a subject is undecided. The message
    /// ends with what was not decided and how to get a decision.
    #[track_caller]
    fn assert_ok(&self);
}

impl AssertOk for Report {
    #[track_caller]
    fn assert_ok(&self) {
        let open = self.open_claims();
        let is_proven = self.survivors() == 0 && self.contradictions() == 0;
        let fine = self.mismatches() == 0 && is_proven && self.compared() > 0 && open.is_empty();
        if !fine {
            let mut text = Vec::new();
            let written = human(&mut text, self, 100, false);
            let text = written.map(|()| String::from_utf8_lossy(&text).into_owned()).unwrap_or_default();
            #[expect(clippy::panic, reason = "an assertion for tests")]
            {
                panic!("{}{}", anstream::adapter::strip_str(&text), open.concat());
            }
        }
    }
}
