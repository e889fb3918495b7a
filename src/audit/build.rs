//! Deflates the reference numbers of JAX: three and a half megabytes of text are less than one in the program.

use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::env;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::PathBuf;

fn main() -> io::Result<()> {
    let folder = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    for name in ["jax", "forces", "friction"] {
        let text = format!("oracles/golden/{name}.json");
        println!("cargo::rerun-if-changed={text}");
        let mut deflated = DeflateEncoder::new(File::create(folder.join(name))?, Compression::best());
        deflated.write_all(&fs::read(text)?)?;
        deflated.finish()?;
    }
    Ok(())
}
