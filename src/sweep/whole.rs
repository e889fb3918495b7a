//! Files that are whole or not there: written beside their names, and given them when they are on the disk.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Whether a file may take the place of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placing {
    /// It may.
    Over,
    /// It may not, whoever makes that file meanwhile.
    New,
}

/// Writes a file under a hidden name of its own, and gives it the name when it is complete and on the disk, the name itself included.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`] where it is to be new and is not; a file that cannot be written. Either leaves what there was.
pub fn write(
    path: &Path,
    placing: Placing,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let mut prefix = std::ffi::OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Not the default, which only its owner may read.
    let mut builder = tempfile::Builder::new();
    let part = builder.prefix(&prefix).suffix(".part").make_in(folder, |path| File::create_new(path))?;
    let mut out = BufWriter::new(part);
    content(&mut out)?;
    let part = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    part.as_file().sync_all()?;
    let placed = match placing {
        Placing::Over => part.persist(path),
        Placing::New => part.persist_noclobber(path),
    };
    placed.map_err(|error| error.error)?;
    sync(folder)
}

/// Makes the names in a folder last, where the system can.
fn sync(folder: &Path) -> io::Result<()> {
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        Err(error) if !matches!(error.kind(), InvalidInput | PermissionDenied | Unsupported) => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Placing, write};
    use std::fs;
    use std::io::ErrorKind;

    /// Of many that write one name at once one is placed, and the others leave nothing.
    #[test]
    fn one_of_many_is_placed() {
        let folder = std::env::temp_dir().join(format!("pintle-whole-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("plan");
        let text = |i: usize| format!("{i}").repeat(50_000);
        let placed: Vec<usize> = std::thread::scope(|scope| {
            let path = &path;
            let all: Vec<_> = (0..8)
                .map(|i| {
                    scope.spawn(move || {
                        let done = write(path, Placing::New, |out| out.write_all(text(i).as_bytes()));
                        assert!(
                            done.as_ref().err().is_none_or(|error| error.kind() == ErrorKind::AlreadyExists)
                        );
                        done.is_ok().then_some(i)
                    })
                })
                .collect();
            all.into_iter().filter_map(|one| one.join().unwrap()).collect()
        });
        assert_eq!(placed.len(), 1, "{placed:?}");
        assert_eq!(fs::read_to_string(&path).unwrap(), text(placed[0]));
        write(&path, Placing::Over, |out| out.write_all(b"x")).unwrap();
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let usual = folder.join("usual");
            fs::write(&usual, "").unwrap();
            let mode = |path| fs::metadata(path).unwrap().permissions().mode();
            assert_eq!(mode(&path), mode(&usual), "others may read it as any file");
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}
