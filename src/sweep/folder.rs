//! What is done already: a folder with the plan and one file for each chunk, each written beside its name and renamed.
//!
//! A worker that is killed loses the chunk in flight; nothing else is lost, whoever is killed.

use crate::SweepError;
use crate::plan::{Plan, sha256};
use crate::ranges::{Ranges, checked};
use crate::summary::{SCHEMA, Summary};
use crate::whole::{self, Placing};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file of the plan.
const PLAN: &str = "plan.json";
/// How the names of chunks begin.
const CHUNK: &str = "chunk-";

/// A folder of one plan.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    plan: String,
}

/// A file of a chunk.
struct Chunk {
    path: PathBuf,
    /// Its states, as its name says.
    states: Ranges,
}

impl Folder {
    /// Opens a folder for the text of a plan, and makes it where there is none.
    ///
    /// # Errors
    /// A folder of another plan, or one that cannot be written.
    pub fn open(path: &Path, plan: &str) -> Result<Self, SweepError> {
        fs::create_dir_all(path).map_err(|error| unwritten(path, error))?;
        let folder = Self { path: path.to_path_buf(), plan: sha256(plan) };
        let file = path.join(PLAN);
        if !file.exists() {
            let placed = whole::write(&file, Placing::New, |out| out.write_all(plan.as_bytes()));
            // Another worker may have been first: what it wrote is read as any other.
            placed.or_else(|error| match error.kind() {
                io::ErrorKind::AlreadyExists => Ok(()),
                _ => Err(unwritten(&file, error)),
            })?;
        }
        let known = read(&file)?;
        if known == plan {
            return Ok(folder);
        }
        let both = Plan::parse_any(&known).zip(Plan::parse_any(plan));
        let differs = both.and_then(|(known, asked)| known.differs(&asked));
        let what = differs.map_or_else(
            || "its plan is none of this program".into(),
            |what| format!("this folder is of another sweep; asked for is now {what}"),
        );
        Err(SweepError::File { file: file.display().to_string(), what, remedy: "give another folder" })
    }

    /// A folder that is there, and the text of its plan.
    ///
    /// # Errors
    /// A folder without a plan.
    pub fn known(path: &Path) -> Result<(Self, String), SweepError> {
        let plan = read(&path.join(PLAN))?;
        Ok((Self { path: path.to_path_buf(), plan: sha256(&plan) }, plan))
    }

    /// What its files hold together; `empty` where there is none. A file whose states are all in larger ones is passed over, as those of a
    /// worker with smaller chunks are.
    ///
    /// # Errors
    /// A file that is no summary of this plan, or whose states are partly in others.
    pub fn merged(&self, mut empty: Summary) -> Result<Summary, SweepError> {
        let mut chunks = self.chunks()?;
        // The sort keeps the order of names.
        chunks.sort_by_key(|chunk| std::cmp::Reverse(chunk.states.count()));
        for Chunk { path, states } in chunks {
            if states.is_within(&empty.states) {
                continue;
            }
            let refused = |what: String| SweepError::File {
                file: path.display().to_string(),
                what,
                remedy: "delete it, and what it held is computed again",
            };
            let found: Summary = serde_json::from_str(&read(&path)?)
                .map_err(|error| refused(format!("no summary: {error}")))?;
            if found.schema != SCHEMA || found.plan != self.plan {
                return Err(refused("a summary of another plan".into()));
            }
            if found.states != states || !found.is_whole() {
                return Err(refused("a summary of other states than its name says".into()));
            }
            if let Some(index) = found.states.overlap(&empty.states) {
                return Err(refused(format!(
                    "state {index} and others, but not all, are in other files, too"
                )));
            }
            empty.merge(&found)?;
        }
        Ok(empty)
    }

    /// Keeps the summary of one chunk, under the name of its states.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn keep(&self, summary: &Summary) -> Result<(), SweepError> {
        let [first, end] = summary.states.iter().next().unwrap_or_default();
        let path = self.path.join(format!("{CHUNK}{first:015}-{}.json", end - first));
        let text = summary.text()?;
        whole::write(&path, Placing::Over, |out| out.write_all(text.as_bytes()))
            .map_err(|error| unwritten(&path, error))
    }

    /// The states that its files hold, as their names say.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn done(&self) -> Result<Ranges, SweepError> {
        Ok(Ranges::union(self.chunks()?.into_iter().map(|chunk| chunk.states)))
    }

    /// The files of chunks, by name. Others are none of this program's.
    fn chunks(&self) -> Result<Vec<Chunk>, SweepError> {
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.path).map_err(|error| unread(&self.path, error))? {
            let name = entry.map_err(|error| unread(&self.path, error))?.file_name();
            let states = name.to_str().and_then(states_of);
            found.extend(states.map(|states| Chunk { path: self.path.join(name), states }));
        }
        found.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(found)
    }
}

/// What the name of a chunk says.
fn states_of(name: &str) -> Option<Ranges> {
    let (first, count) = name.strip_prefix(CHUNK)?.strip_suffix(".json")?.split_once('-')?;
    let (first, count) = (first.parse().ok()?, count.parse().ok()?);
    checked(first, count).ok().map(|_| Ranges::of(first, count))
}

fn unread(path: &Path, error: io::Error) -> SweepError {
    SweepError::Unread(path.display().to_string(), error)
}

fn unwritten(path: &Path, error: io::Error) -> SweepError {
    SweepError::Unwritten(path.display().to_string(), error)
}

fn read(file: &Path) -> Result<String, SweepError> {
    fs::read_to_string(file).map_err(|error| unread(file, error))
}
