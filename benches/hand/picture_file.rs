//! The file that the picture of a bench is drawn into: `--picture FILE.svg`, or one in the folder of what is built.

use std::error::Error;
use std::path::{Path, PathBuf};

/// That file; `name` is its name where none is given.
///
/// # Errors
/// Another argument.
pub(crate) fn picture_file(name: &str) -> Result<PathBuf, Box<dyn Error + Send + Sync>> {
    // The first is what cargo gives to every bench.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    match words.as_slice() {
        [] => Ok(Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)),
        [option, file] if option == "--picture" => Ok(file.into()),
        _ => Err(format!("unknown: {}; there is: --picture FILE.svg", words.join(" ")).into()),
    }
}
