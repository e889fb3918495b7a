//! States of a file, one after another.

use crate::diagnostic::{Diagnostic, Result};
use crate::model::Scene;
use crate::model::State;
use crate::states::source::{Source, is_json, located_in};
use crate::states::{document, table};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// A file of states that is read as often as it is asked for, one state at a time: it takes memory for one state, however many there
/// are.
///
/// ```
/// use pintle_scene::{Diagnostic, Scene, StateStream};
/// # let path = std::env::temp_dir().join(format!("pintle-stream-{}.csv", std::process::id()));
/// # std::fs::write(&path, "state,node,u1\n0,1,0.5\n1,1,0.75\n")?;
/// let scene = Scene::parse("one.inp", "*NODE\n1, 0., 0., 0.\n")?;
/// let mut last = 0.0;
/// StateStream::open(&path)?.for_each(&scene, |state| {
///     last = state.nodes.values().next().map_or(0.0, |node| node.displacement[0]);
///     Ok::<(), Diagnostic>(())
/// })?;
/// assert_eq!(last, 0.75);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StateStream {
    path: PathBuf,
    is_json: bool,
}

impl StateStream {
    /// A `.csv` or `.json` file. Nothing is read yet.
    ///
    /// # Errors
    /// A name with another ending.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Ok(Self { path: path.to_path_buf(), is_json: is_json(path, "states")? })
    }

    /// Whether the file can be read more than once: not so a pipe.
    pub fn is_repeatable(&self) -> bool {
        self.path.metadata().is_ok_and(|metadata| metadata.is_file())
    }

    /// Reads the file from its beginning and hands on its states, one after another, up to the first place where something is wrong.
    ///
    /// # Errors
    /// All that is wrong with the file, each with its place and a remedy; the first error of `take`, after which nothing more is
    /// read.
    pub fn for_each<E: From<Diagnostic>>(
        &self,
        scene: &Scene,
        mut take: impl FnMut(State) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut failure = None;
        let source = Source::File(&self.path);
        let mut each = |state| match take(state) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                failure = Some(error);
                ControlFlow::Break(())
            }
        };
        let read = match self.is_json {
            true => document::states(source, scene, &mut each),
            false => table::states(source, scene, &mut each),
        };
        if let Some(error) = failure {
            return Err(error);
        }
        read.map_err(|error| E::from(located_in(&self.path, error)))
    }
}
