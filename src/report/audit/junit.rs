//! JUnit XML: a suite per connector, a case per check.

use crate::audit::{Check, Report, Verdict};
use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Writes the audit as JUnit XML. Mismatches and surviving mutants are failures, what is undecided is skipped.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn junit(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let mut document = quick_junit::Report::new("pintle audit");
    for subject in &report.subjects {
        let mut suite = TestSuite::new(subject.title());
        for check in &subject.checks {
            suite.add_test_case(TestCase::new(title(check), status(check)));
        }
        for (claim, verdict) in [("formula", subject.formula), ("declaration", subject.declaration)] {
            suite.add_test_case(TestCase::new(format!("claim: {claim}"), plain(verdict)));
        }
        document.add_test_suite(suite);
    }
    if !report.atlas.is_empty() {
        let mut suite = TestSuite::new("singular points");
        for approach in &report.atlas {
            let title = format!("{} {} at {}", approach.connection, approach.component, approach.at);
            let status = if approach.is_confirmed() {
                TestCaseStatus::success()
            } else {
                let mut failure = TestCaseStatus::non_success(NonSuccessKind::Failure);
                failure.set_message(format!("declared {:?}, seen {:?}", approach.declared, approach.seen));
                failure
            };
            suite.add_test_case(TestCase::new(title, status));
        }
        document.add_test_suite(suite);
    }
    let text = document.to_string().map_err(io::Error::other)?;
    out.write_all(text.as_bytes())
}

fn title(check: &Check) -> String {
    match check.quantity {
        Some(quantity) => format!("{} against {}", quantity.name(), check.against.name()),
        None => check.against.name().to_string(),
    }
}

fn status(check: &Check) -> TestCaseStatus {
    if check.score.survived > 0 {
        let mut failure = TestCaseStatus::non_success(NonSuccessKind::Error);
        failure.set_message(format!("{} mutants survived", check.score.survived));
        return failure;
    }
    let mut status = plain(check.verdict);
    if let (TestCaseStatus::NonSuccess { .. }, Some(worst)) = (&status, &check.worst) {
        let state = check.worst_state.as_deref().unwrap_or("");
        let why = check.diagnosis.iter().flat_map(|diagnosis| diagnosis.lines());
        let why: String = why.map(|(sentence, code)| format!("; {sentence} [{code}]")).collect();
        status.set_message(format!(
            "{}: {:e}, not {:e}: {:.3e} of the tolerance {:e}, at {state}{why}",
            worst.entry, worst.got, worst.want, worst.units, worst.tolerance
        ));
    }
    status
}

fn plain(verdict: Verdict) -> TestCaseStatus {
    match verdict {
        Verdict::Pass | Verdict::IllConditioned | Verdict::Kink => TestCaseStatus::success(),
        Verdict::Undecided => TestCaseStatus::skipped(),
        Verdict::UnstableFormula | Verdict::Wrong | Verdict::Invalid => {
            let mut failure = TestCaseStatus::non_success(NonSuccessKind::Failure);
            failure.set_message(verdict.name());
            failure
        }
    }
}
