//! Chunks of a sweep: texts and numbers in, texts out, so that any engine can carry them.

use pintle::sweep::{Folder, Generator, Own, Programs, Ranges, Summary, Sweep, SweepError};
use pintle_sweep::ranges::checked;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pythonize::depythonize;
use std::path::PathBuf;
use std::time::Duration;

fn raised(error: SweepError) -> PyErr {
    match error {
        SweepError::Unread(..) | SweepError::Unwritten(..) => PyOSError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// The plan of a sweep, as text: of a routine, where one is given as the plan names it.
///
/// # Errors
/// ValueError, where there is nothing of that name, or no such routine or convention.
#[pyfunction]
pub(crate) fn sweep_plan(
    py: Python<'_>,
    of: Vec<String>,
    generator: &str,
    seed: &str,
    share: f64,
    routine: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let generator = Generator::named(generator).ok_or_else(|| {
        let known = Generator::ALL.map(|one| format!("'{}'", one.name())).join(", ");
        PyValueError::new_err(format!("there is no generator '{generator}': choose {known}"))
    })?;
    let routine: Option<Own> = routine
        .map(depythonize)
        .transpose()
        .map_err(|error| PyValueError::new_err(format!("the routine or its convention: {error}")))?;
    py.detach(|| pintle::sweep::plan(&of, generator, seed, share, routine.as_ref()))
        .map_err(PyValueError::new_err)
}

/// The chunks that are left of `states`, as first index and count: of all where there is no folder.
///
/// # Errors
/// ValueError, where the folder is of another plan, or there are more than ten million chunks; OSError, where the folder cannot be read.
#[pyfunction]
pub(crate) fn sweep_left(
    py: Python<'_>,
    plan: &str,
    states: u64,
    chunk: u64,
    out: Option<PathBuf>,
) -> PyResult<Vec<(u64, u64)>> {
    const MOST: usize = 10_000_000;
    let left = || {
        checked(0, states)?;
        let wanted = Ranges::of(0, states);
        let left = match out {
            Some(out) => wanted.without(&Folder::open(&out, plan)?.done()?),
            None => wanted,
        };
        Ok(left.chunks(chunk).take(MOST + 1).collect::<Vec<_>>())
    };
    let chunks = py.detach(left).map_err(raised)?;
    if chunks.len() > MOST {
        return Err(PyValueError::new_err(format!(
            "{states} states are more than {MOST} chunks: make chunk_states larger"
        )));
    }
    Ok(chunks)
}

/// Computes a chunk on threads of its own, and gives its summary as text; with a folder it is kept there instead. A routine of the plan is
/// started by these words for a shell, Python and the command of this package, and has so many seconds for an answer.
///
/// # Errors
/// ValueError, where the plan is none, or its routine does not answer; OSError, where the folder cannot be written.
#[pyfunction]
pub(crate) fn sweep_chunk(
    py: Python<'_>,
    plan: &str,
    part: (u64, u64),
    out: Option<PathBuf>,
    threads: usize,
    started: (String, String, f64),
) -> PyResult<Option<String>> {
    let (python, pintle, seconds) = started;
    let programs = Programs { python, pintle };
    let answer = Duration::try_from_secs_f64(seconds)
        .map_err(|error| PyValueError::new_err(format!("timeout is {seconds}: {error}")))?;
    let pool = rayon::ThreadPoolBuilder::new().stack_size(pintle::STACK).num_threads(threads).build();
    let pool =
        pool.map_err(|error| PyRuntimeError::new_err(format!("no thread could be started: {error}")))?;
    let computed = || {
        let sweep = Sweep::new(plan)?;
        let summary = match pintle::sweep::routines(&sweep, Some(&programs), answer)? {
            Some(routines) => routines.run(part.0, part.1, &|_| {}),
            None => sweep.run(part.0, part.1, &|_| {}),
        }?;
        match out {
            Some(out) => Folder::open(&out, plan)?.keep(&summary).map(|()| None),
            None => summary.text().map(Some),
        }
    };
    py.detach(|| pool.install(computed)).map_err(raised)
}

/// The summary of texts, or of a folder, with its digest.
///
/// # Errors
/// ValueError, where they do not belong together.
#[pyfunction]
pub(crate) fn sweep_merged(
    py: Python<'_>,
    plan: &str,
    texts: Vec<String>,
    out: Option<PathBuf>,
) -> PyResult<(String, String)> {
    let merged = || {
        let mut all = Sweep::new(plan)?.empty();
        for text in texts {
            let one: Summary =
                serde_json::from_str(&text).map_err(|error| SweepError::Merge(error.to_string()))?;
            all.merge(&one)?;
        }
        if let Some(out) = out {
            all = Folder::open(&out, plan)?.merged(all)?;
        }
        Ok((all.text()?, all.digest()?))
    };
    py.detach(merged).map_err(raised)
}

/// The picture of a summary, as SVG.
///
/// # Errors
/// ValueError, where the text is no summary.
#[pyfunction]
pub(crate) fn sweep_picture(text: &str) -> PyResult<String> {
    let summary = serde_json::from_str(text).map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(pintle_report::sweep::picture(&summary))
}
