//! Where Rust computes, while Python waits.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Once;
use std::thread;

/// The pool of rayon with the stacks that derivatives of derivatives need; it is started by the first computation, not by the import.
fn pool() {
    static STARTED: Once = Once::new();
    STARTED.call_once(|| {
        // It fails only where there is a pool already, which then serves.
        _ = rayon::ThreadPoolBuilder::new().stack_size(pintle::STACK).build_global();
    });
}

/// What `work` gives, computed on a thread with a stack that is large enough, while `wait` runs here.
///
/// # Errors
/// What `wait` raises; RuntimeError where no thread starts, or the work panics.
pub(crate) fn beside<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send,
    wait: impl FnOnce() -> PyResult<()>,
) -> PyResult<T> {
    pool();
    thread::scope(|scope| {
        let worker = thread::Builder::new().stack_size(pintle::STACK).spawn_scoped(scope, work);
        let worker = worker
            .map_err(|error| PyRuntimeError::new_err(format!("no thread could be started: {error}")))?;
        let waited = wait();
        let done = py.detach(|| worker.join());
        waited?;
        done.map_err(|_| PyRuntimeError::new_err("a defect of pintle; please report it with its input"))
    })
}

/// What `work` gives, without the lock of the interpreter.
///
/// # Errors
/// RuntimeError where no thread starts, or the work panics.
pub(crate) fn apart<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    beside(py, work, || Ok(()))
}
