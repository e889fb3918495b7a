//! The extension module of the Python package `pintle`: objects in, objects out. Every number comes from the crates below.
//!
//! | module | question |
//! |---|---|
//! | `check` | is a Python callable right? |
//! | `report` | what does a check or an audit say? |
//! | `rows` | what do many states of one type give? |
//! | `scene` | what do the connectors of a scene give, and is the scene right? |
//! | `sweep` | what do the states of a chunk give? |
//! | `work` | where does Rust compute, while Python waits? |

mod arrays;
mod check;
mod report;
mod rows;
mod scene;
mod sweep;
mod work;

use pyo3::prelude::*;

/// Runs the command line, and gives its exit code.
#[pyfunction]
fn command_line(py: Python<'_>, words: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| pintle::command_line(words))
}

/// The connection types and constraints as JSON, as `pintle list --format json` prints them.
#[pyfunction]
fn catalog() -> PyResult<String> {
    report::text(|out| pintle_report::list::json(out))
}

#[pymodule]
mod _pintle {
    use super::*;

    #[pymodule_export]
    use super::catalog;
    #[pymodule_export]
    use super::check::ask;
    #[pymodule_export]
    use super::command_line;
    #[pymodule_export]
    use super::report::{Entry, Report};
    #[pymodule_export]
    use super::rows::Rows;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::sweep::{sweep_chunk, sweep_left, sweep_merged, sweep_picture, sweep_plan};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", pintle::VERSION)?;
        module.add("DRIVER", pintle::check::DRIVER)
    }
}
