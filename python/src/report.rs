//! What a check or an audit says.

use pintle::audit::Report as Audited;
use pintle::check::Checked;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::collections::BTreeSet;
use std::io::{self, Write};

/// An entry that was judged.
#[pyclass(frozen, module = "pintle", get_all)]
pub(crate) struct Entry {
    /// Its name: `∂ur1/∂θb3`.
    entry: String,
    /// What was given.
    got: f64,
    /// What it must be.
    want: f64,
    /// How far apart they may be.
    tolerance: f64,
    /// |got − want| in units of the tolerance.
    units: f64,
    /// Where it was seen.
    state: Option<String>,
    /// The simplest state found at which it is wrong.
    simplest: Option<String>,
}

#[pymethods]
impl Entry {
    fn __repr__(&self) -> String {
        let Self { entry, got, want, units, .. } = self;
        format!("{entry}: {got:?}, must be {want:?} ({units:.3e} tolerances off)")
    }
}

/// What a check or an audit found.
#[pyclass(frozen, module = "pintle")]
pub(crate) struct Report {
    report: Audited,
    notes: Vec<String>,
}

/// What `write` writes, without the colours of a terminal.
pub(crate) fn text(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> PyResult<String> {
    let mut out = anstream::StripStream::new(Vec::new());
    write(&mut out).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    Ok(String::from_utf8_lossy(&out.into_inner()).into_owned())
}

impl Report {
    pub(crate) fn of_check(checked: Checked) -> Self {
        let notes = checked.notes();
        Self { report: checked.report, notes }
    }

    pub(crate) fn of_audit(report: Audited) -> Self {
        Self { report, notes: Vec::new() }
    }

    fn faults(&self) -> impl Iterator<Item = &pintle_audit::Check> {
        self.report
            .subjects
            .iter()
            .flat_map(|subject| &subject.checks)
            .filter(|check| check.verdict.is_mismatch())
    }
}

#[pymethods]
impl Report {
    /// Whether every number is verified to be right.
    #[getter]
    fn ok(&self) -> bool {
        self.verdict() == "pass"
    }

    /// `pass`; `unstable formula`, `wrong` or `invalid` where a number is not right; `self-test failed`; `undecided`.
    #[getter]
    fn verdict(&self) -> &'static str {
        let report = &self.report;
        match self.faults().map(|check| check.verdict).max() {
            Some(verdict) => verdict.name(),
            None if report.is_verified_wrong() => "wrong",
            None if report.survivors() > 0 || report.contradictions() > 0 => "self-test failed",
            None if report.failing_models() > 0 => "a finding of the model is an error",
            None if report.is_open() || report.compared() == 0 && report.models.is_empty() => "undecided",
            None => "pass",
        }
    }

    /// The entry that is wrong most clearly, or None.
    #[getter]
    fn worst(&self) -> Option<Entry> {
        let found = self.faults().filter_map(|check| Some((check, check.worst.as_ref()?)));
        let clearest = |(one, a): &(_, &pintle_audit::Finding), (other, b): &(_, &pintle_audit::Finding)| {
            let verdict = |check: &&pintle_audit::Check| check.verdict;
            verdict(one).cmp(&verdict(other)).then(a.units.total_cmp(&b.units))
        };
        let (check, worst) = found.max_by(clearest)?;
        Some(Entry {
            entry: worst.entry.clone(),
            got: worst.got,
            want: worst.want,
            tolerance: worst.tolerance,
            units: worst.units,
            state: check.worst_state.clone(),
            simplest: check.simplest.clone(),
        })
    }

    /// Why: one sentence for each mistake that explains wrong entries.
    #[getter]
    fn cause(&self) -> Vec<String> {
        let mut told = Vec::new();
        for (line, _) in
            self.faults().filter_map(|check| check.diagnosis.as_ref()).flat_map(|found| found.lines())
        {
            if !told.contains(&line) {
                told.push(line);
            }
        }
        told
    }

    /// The codes of the causes: `diagnosis::sign` …; `pintle explain CODE` says more.
    #[getter]
    fn codes(&self) -> BTreeSet<&'static str> {
        let found = self.faults().filter_map(|check| check.diagnosis.as_ref());
        found.flat_map(|found| found.lines()).map(|(_, code)| code.as_str()).collect()
    }

    /// What was not judged, in sentences.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// How many numbers were compared.
    #[getter]
    fn compared(&self) -> u64 {
        self.report.compared()
    }

    /// The report for reading, as `pintle check` prints it.
    #[getter]
    fn text(&self) -> PyResult<String> {
        const WIDTH: usize = 100;
        text(|out| pintle_report::audit::human(out, &self.report, WIDTH, false))
    }

    /// The report as a JSON document of the schema pintle-audit/1.
    fn to_json(&self) -> PyResult<String> {
        text(|out| pintle_report::audit::json(out, &self.report))
    }

    /// The report as a page of HTML.
    fn to_html(&self) -> PyResult<String> {
        text(|out| {
            pintle_report::audit::html(out, &self.report, &pintle_report::audit::Supplement::default())
        })
    }
}
