//! JUnit XML: a suite per connector, a case per check; a suite per model, a case per finding.

use crate::audit::model::{gap, place, word};
use crate::audit::summary::{laws_not_asked, not_exercised, samples, sides, undecided, without_witness};
use pintle_assembly::Assembly;
use pintle_audit::model::{Finding, ModelReport};
use pintle_audit::{Check, Report, Verdict};
use pintle_scene::Severity;
use pintle_scene::grammar::count;
use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Writes the audit as JUnit XML. Mismatches are failures, surviving mutants errors, what is undecided is skipped, and a failure
/// where the audit was asked to be strict. A suite for each model has a case for the rank of its assembly, and one for each of its
/// findings. A finding that is an error fails, others pass and are told on standard output. The `classname` is what a test is of:
/// the connector, the constraint or the type, the model, the code of a finding. No test has a `time`. Each gathers numbers of many
/// states, judged in parallel with those of others, and two reports of the same numbers are the same to the byte.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn junit(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let strict = report.settings.strict;
    let mut document = quick_junit::Report::new("pintle audit");
    for subject in &report.subjects {
        let mut suite = TestSuite::new(subject.title());
        suite.add_property(("states", subject.cases.to_string().as_str()));
        suite
            .add_property(("states judged independently", subject.judged_independently.to_string().as_str()));
        for check in &subject.checks {
            let mut test = classified(&subject.title(), title(check), status(check, strict));
            let told: Vec<String> = sides(check).collect();
            if let (false, Some(worst)) = (told.is_empty(), &check.worst) {
                let state = check.worst_state.as_deref().unwrap_or("");
                let verdict = check.verdict.name();
                test.set_system_out(format!("{verdict}: {} at {state}: {}", worst.entry, told.join("; ")));
            }
            suite.add_test_case(test);
        }
        let claims = [
            ("derivative", subject.derivative),
            ("formula", subject.formula),
            ("declaration", subject.declaration),
        ];
        for (claim, verdict) in claims {
            // A page of the manual that could not be read is no fault of the scene.
            let fails_as_open = strict && !(claim == "declaration" && subject.is_page_unread());
            let status = plain(verdict, fails_as_open);
            suite.add_test_case(classified(&subject.title(), format!("claim: {claim}"), status));
        }
        for text in without_witness(subject).into_iter().chain(not_exercised(subject)) {
            suite.add_test_case(classified(&subject.title(), text, open(strict)));
        }
        if let Some(text) = laws_not_asked(subject) {
            suite.add_test_case(classified(&subject.title(), text, TestCaseStatus::skipped()));
        }
        document.add_test_suite(suite);
    }
    for (share, text) in report.sampled.iter().zip(samples(report)) {
        let mut suite = TestSuite::new(format!("sample of {}", share.scene));
        suite.add_test_case(classified(&share.scene, text, open(strict)));
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
                failure.set_message(approach.told());
                failure
            };
            suite.add_test_case(classified(&approach.connection, title, status));
        }
        document.add_test_suite(suite);
    }
    for law in report.blind_laws() {
        let mut suite = TestSuite::new("self-test");
        let mut failure = TestCaseStatus::non_success(NonSuccessKind::Error);
        failure.set_message("no mutant of what it speaks of was noticed");
        suite.add_test_case(classified("self-test", law.name().to_string(), failure));
        document.add_test_suite(suite);
    }
    for model in &report.models {
        document.add_test_suite(findings(model, strict));
    }
    let text = document.to_string().map_err(io::Error::other)?;
    out.write_all(text.as_bytes())
}

/// The findings of a model: errors are failures; warnings and notes pass, and are told on their standard output.
fn findings(model: &ModelReport, strict: bool) -> TestSuite {
    let name = format!("model {}", model.scene);
    let mut suite = TestSuite::new(name.as_str());
    for assembly in model.assembly.iter().chain(&model.later_steps) {
        let title = format!("rank of the assembly in step {}", assembly.step);
        let mut status = TestCaseStatus::success();
        if !assembly.is_decided() {
            status = open(strict);
            status.set_message(why_open(assembly));
        }
        suite.add_test_case(classified(&name, title, status));
    }
    for finding in &model.findings {
        suite.add_test_case(test_of(finding));
    }
    if model.findings.is_empty() {
        suite.add_test_case(classified(&name, "nothing found".to_string(), TestCaseStatus::success()));
    }
    suite
}

fn test_of(finding: &Finding) -> TestCase {
    let (severity, place) = (word(finding.severity()), place(finding));
    let mut text = format!("{severity}[{}] {place}: {}", finding.code(), finding.message());
    for (what, said) in [("why", finding.reason()), ("help", finding.remedy())] {
        if !said.is_empty() {
            text.push_str(&format!("\n{what}: {said}"));
        }
    }
    let is_error = finding.severity() == Severity::Error;
    let mut status = TestCaseStatus::success();
    if is_error {
        status = TestCaseStatus::non_success(NonSuccessKind::Failure);
        status.set_message(finding.message()).set_type(finding.code().as_str()).set_description(&text);
    }
    let mut test = classified(finding.code().as_str(), format!("{} at {place}", finding.code()), status);
    test.extra.insert("file".into(), finding.file().into());
    if let Some(line) = finding.line() {
        test.extra.insert("line".into(), line.to_string().into());
    }
    if !is_error {
        test.set_system_out(text);
    }
    test
}

/// A test of something.
fn classified(of: &str, name: String, status: TestCaseStatus) -> TestCase {
    let mut test = TestCase::new(name, status);
    test.set_classname(of);
    test
}

fn title(check: &Check) -> String {
    match check.quantity {
        Some(quantity) => format!("{} against {}", quantity.name(), check.against.name()),
        None => check.against.name().to_string(),
    }
}

/// Why the rank of an assembly is undecided.
fn why_open(assembly: &Assembly) -> String {
    match (assembly.positions.iter().find(|position| !position.decided), &assembly.not_assembled) {
        (Some(position), _) => {
            let when = position.state.map_or_else(String::new, |state| format!("at state {state}: "));
            format!("{when}{}", gap(assembly, position))
        }
        (None, Some(stopped)) => stopped.why.clone(),
        (None, None) => "its rank was not found".to_string(),
    }
}

/// What is undecided: skipped, or a failure.
fn open(strict: bool) -> TestCaseStatus {
    if !strict {
        return TestCaseStatus::skipped();
    }
    let mut failure = TestCaseStatus::non_success(NonSuccessKind::Failure);
    failure.set_message(Verdict::Undecided.name()).set_type(Verdict::Undecided.name());
    failure
}

fn status(check: &Check, strict: bool) -> TestCaseStatus {
    // What is wrong comes before what was not noticed.
    if check.score.survived > 0 && !check.verdict.is_mismatch() {
        let mut failure = TestCaseStatus::non_success(NonSuccessKind::Error);
        failure.set_message(format!("{} survived", count(check.score.survived, "mutant")));
        return failure;
    }
    let mut status = plain(check.verdict, strict);
    let reasons: Vec<String> = undecided(check).collect();
    if check.verdict == Verdict::Undecided && !reasons.is_empty() {
        status.set_message(reasons.join("; "));
    }
    let is_failure =
        check.verdict != Verdict::Undecided && matches!(status, TestCaseStatus::NonSuccess { .. });
    if let (true, Some(worst)) = (is_failure, &check.worst) {
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

fn plain(verdict: Verdict, strict: bool) -> TestCaseStatus {
    match verdict {
        Verdict::Pass | Verdict::IllConditioned | Verdict::Kink => TestCaseStatus::success(),
        // Nobody judged it: what fails where the audit is strict.
        Verdict::Singular if strict => {
            let mut failure = open(strict);
            failure.set_message(verdict.name()).set_type(verdict.name());
            failure
        }
        Verdict::Singular => TestCaseStatus::success(),
        Verdict::Undecided => open(strict),
        Verdict::UnstableFormula | Verdict::Wrong | Verdict::Invalid => {
            let mut failure = TestCaseStatus::non_success(NonSuccessKind::Failure);
            failure.set_message(verdict.name());
            failure
        }
    }
}
