//! Files that commands write: whole or not at all, and never in place of another unless that is asked for.

use super::Failure;
use pintle_sweep::whole::{self, Placing};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Whether files may take the place of others: `--force`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Files {
    force: bool,
}

impl Files {
    pub(crate) const fn new(force: bool) -> Self {
        Self { force }
    }

    /// Refuses files that are there, and one name for two: before anything is computed.
    pub(crate) fn check<'a>(self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), Failure> {
        let mut known: Vec<&PathBuf> = Vec::new();
        for path in paths {
            if known.contains(&path) && !is_stream(path) {
                let message = format!("{} is to be written twice: give another name", path.display());
                return Err(Failure::Unwritten(message));
            }
            self.check_one(path)?;
            known.push(path);
        }
        Ok(())
    }

    fn check_one(self, path: &Path) -> Result<(), Failure> {
        if self.force || !path.exists() || is_stream(path) {
            return Ok(());
        }
        if path.is_dir() {
            return Err(cannot(path, &io::Error::from(io::ErrorKind::IsADirectory)));
        }
        Err(there_already(path))
    }

    /// Refuses a folder with files of that ending, of which some might be overwritten.
    pub(crate) fn check_folder(self, folder: Option<&Path>, ending: &str) -> Result<(), Failure> {
        let Some(folder) = folder.filter(|_| !self.force) else { return Ok(()) };
        let known = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut known = known.filter(|path| path.extension().is_some_and(|of| of == ending));
        known.next().map_or(Ok(()), |path| self.check_one(&path))
    }

    /// Makes a folder.
    pub(crate) fn folder(self, path: &Path) -> Result<(), Failure> {
        fs::create_dir_all(path).map_err(|error| cannot(path, &error))
    }

    /// Writes a text.
    pub(crate) fn text(self, path: &Path, text: impl AsRef<[u8]>) -> Result<(), Failure> {
        self.write(path, |out| out.write_all(text.as_ref()))
    }

    /// Writes a file beside its name, and gives it the name when it is complete and on the disk. What is no file, such as a pipe or a
    /// device, is written to as it is.
    pub(crate) fn write(
        self,
        path: &Path,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        self.check_one(path)?;
        let written = if is_stream(path) {
            File::options().write(true).open(path).and_then(|file| {
                let mut out = BufWriter::new(file);
                content(&mut out)?;
                out.flush()
            })
        } else {
            // A link stays one.
            let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
            whole::write(&path, if self.force { Placing::Over } else { Placing::New }, content)
        };
        written.map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => there_already(path),
            _ => cannot(path, &error),
        })
    }
}

fn there_already(path: &Path) -> Failure {
    Failure::Unwritten(format!(
        "{} is there already, and was not overwritten: give another name, or --force",
        path.display()
    ))
}

/// Whether something is there that is neither a file nor a folder.
fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

fn cannot(path: &Path, error: &io::Error) -> Failure {
    Failure::Unwritten(format!("cannot write {}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What fails half-way leaves neither a part nor a change; what is there stays; a device is written to.
    #[test]
    fn files_are_whole_or_not_there() {
        let folder = std::env::temp_dir().join(format!("pintle-save-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("it.txt");
        let names = || fs::read_dir(&folder).unwrap().count();
        let fails = |files: Files| {
            files.write(&path, |out| {
                out.write_all(&[b'x'; 100_000])?;
                Err(io::Error::from(io::ErrorKind::StorageFull))
            })
        };
        assert!(matches!(fails(Files::new(false)), Err(Failure::Unwritten(_))));
        assert_eq!(names(), 0);
        Files::new(false).text(&path, "one").unwrap();
        assert!(matches!(Files::new(false).text(&path, "two"), Err(Failure::Unwritten(_))));
        assert!(fails(Files::new(true)).is_err());
        assert_eq!((fs::read_to_string(&path).unwrap(), names()), ("one".to_string(), 1));
        Files::new(true).text(&path, "two").unwrap();
        assert_eq!((fs::read_to_string(&path).unwrap(), names()), ("two".to_string(), 1));
        assert!(Files::new(true).check([&path, &path]).is_err());
        assert!(Files::new(false).check_folder(Some(&folder), "txt").is_err());
        assert!(Files::new(false).check_folder(Some(&folder), "svg").is_ok());
        if cfg!(target_os = "linux") {
            assert!(matches!(
                Files::new(false).text(Path::new("/dev/full"), "x"),
                Err(Failure::Unwritten(_))
            ));
            Files::new(false).text(Path::new("/dev/null"), "x").unwrap();
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}
