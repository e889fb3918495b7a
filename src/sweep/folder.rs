//! What is done already: a folder with the plan and one file for each chunk, each written beside its name and renamed.
//!
//! A worker that is killed loses the chunk in flight; nothing else is lost, whoever is killed.

use crate::SweepError;
use crate::plan::sha256;
use crate::ranges::Ranges;
use crate::summary::{SCHEMA, Summary};
use std::fs::{self, File};
use std::io::{self, Write};
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

impl Folder {
    /// Opens a folder for the text of a plan, and makes it where there is none.
    ///
    /// # Errors
    /// A folder of another plan, or one that cannot be written.
    pub fn open(path: &Path, plan: &str) -> Result<Self, SweepError> {
        fs::create_dir_all(path).map_err(|error| disk(path, error))?;
        let folder = Self { path: path.to_path_buf(), plan: sha256(plan) };
        let file = path.join(PLAN);
        if file.exists() {
            if read(&file)? != plan {
                return Err(SweepError::File {
                    file: file.display().to_string(),
                    what: "this folder is of another plan: other connectors, another seed or another share"
                        .into(),
                    remedy: "give another folder",
                });
            }
        } else {
            write(&file, plan)?;
        }
        Ok(folder)
    }

    /// A folder that is there, and the text of its plan.
    ///
    /// # Errors
    /// A folder without a plan.
    pub fn known(path: &Path) -> Result<(Self, String), SweepError> {
        let plan = read(&path.join(PLAN))?;
        Ok((Self { path: path.to_path_buf(), plan: sha256(&plan) }, plan))
    }

    /// What its files hold together; `empty` where there is none.
    ///
    /// # Errors
    /// A file that is no summary of this plan, or summaries with common states.
    pub fn merged(&self, mut empty: Summary) -> Result<Summary, SweepError> {
        for file in self.files()? {
            let refused = |what: String| SweepError::File {
                file: file.display().to_string(),
                what,
                remedy: "delete it, and what it held is computed again",
            };
            let found: Summary = serde_json::from_str(&read(&file)?)
                .map_err(|error| refused(format!("no summary: {error}")))?;
            if found.schema != SCHEMA || found.plan != self.plan {
                return Err(refused("a summary of another plan".into()));
            }
            empty.merge(&found).map_err(|error| refused(error.to_string()))?;
        }
        Ok(empty)
    }

    /// Keeps the summary of one chunk, under the name of its states.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn keep(&self, summary: &Summary) -> Result<(), SweepError> {
        let name = summary.states.iter().next().map_or([0; 2], |[first, end]| [first, end - first]);
        write(&self.path.join(format!("{CHUNK}{:015}-{}.json", name[0], name[1])), &summary.text()?)
    }

    /// What is left of some states.
    ///
    /// # Errors
    /// As [`Folder::merged`].
    pub fn left(&self, wanted: &Ranges, empty: Summary) -> Result<Ranges, SweepError> {
        Ok(wanted.without(&self.merged(empty)?.states))
    }

    /// The files of chunks, by name.
    fn files(&self) -> Result<Vec<PathBuf>, SweepError> {
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.path).map_err(|error| disk(&self.path, error))? {
            let name = entry.map_err(|error| disk(&self.path, error))?.file_name();
            let is_chunk =
                name.to_str().is_some_and(|name| name.starts_with(CHUNK) && name.ends_with(".json"));
            if is_chunk {
                found.push(self.path.join(name));
            }
        }
        found.sort();
        Ok(found)
    }
}

fn disk(path: &Path, error: io::Error) -> SweepError {
    SweepError::Disk(path.display().to_string(), error)
}

fn read(file: &Path) -> Result<String, SweepError> {
    fs::read_to_string(file).map_err(|error| disk(file, error))
}

/// Writes beside the name, and renames when it is whole and on the disk.
fn write(file: &Path, text: &str) -> Result<(), SweepError> {
    let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let part = file.with_file_name(format!(".{name}.{}.part", std::process::id()));
    let whole = File::create(&part).and_then(|mut out| {
        out.write_all(text.as_bytes())?;
        out.sync_all()
    });
    let placed = whole.and_then(|()| fs::rename(&part, file));
    placed.map_err(|error| {
        _ = fs::remove_file(&part);
        disk(file, error)
    })
}
