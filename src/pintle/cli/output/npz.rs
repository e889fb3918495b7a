//! Arrays as NumPy reads them: `.npz`, an archive of `.npy` files, not compressed.

use rawzip::ZipArchiveWriter;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};

/// The numbers or words of an array.
pub(crate) enum Items {
    Numbers(Vec<f64>),
    Counts(Vec<u64>),
    Words(Vec<String>),
}

/// An array with its name and shape.
pub(crate) struct Array {
    pub(crate) name: &'static str,
    pub(crate) shape: Vec<usize>,
    pub(crate) items: Items,
}

impl Array {
    /// Of numbers.
    pub(crate) const fn numbers(name: &'static str, shape: Vec<usize>, numbers: Vec<f64>) -> Self {
        Self { name, shape, items: Items::Numbers(numbers) }
    }

    /// A list of words.
    pub(crate) fn words(name: &'static str, words: Vec<String>) -> Self {
        Self { name, shape: vec![words.len()], items: Items::Words(words) }
    }

    /// As a file: header and items.
    fn npy(&self) -> Vec<u8> {
        // Words have one width, of four bytes a letter.
        let (descr, width) = match &self.items {
            Items::Numbers(_) => (NUMBER.to_string(), 0),
            Items::Counts(_) => ("<u8".to_string(), 0),
            Items::Words(words) => {
                let width = words.iter().map(|word| word.chars().count()).max().unwrap_or(0).max(1);
                (format!("<U{width}"), width)
            }
        };
        let mut bytes = header(&descr, &self.shape);
        match &self.items {
            Items::Numbers(numbers) => bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes())),
            Items::Counts(counts) => bytes.extend(counts.iter().flat_map(|x| x.to_le_bytes())),
            Items::Words(words) => {
                for word in words {
                    let letters = word.chars().map(u32::from).chain(std::iter::repeat(0)).take(width);
                    bytes.extend(letters.flat_map(u32::to_le_bytes));
                }
            }
        }
        bytes
    }
}

/// What doubles are called.
const NUMBER: &str = "<f8";

/// The header of an array: magic, version 1.0, its length, itself filled up to a multiple of 64.
fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    const ALIGNED: usize = 64;
    const BEFORE: usize = 10;
    let shape: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
    while !(BEFORE + header.len() + 1).is_multiple_of(ALIGNED) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes
}

/// An array of numbers of which a part is known at a time, in C order.
pub(crate) struct Growing {
    pub(crate) name: &'static str,
    pub(crate) shape: Vec<usize>,
}

/// Takes the next numbers of each growing array.
pub(crate) type Put<'p> = dyn FnMut(&[&[f64]]) -> io::Result<()> + 'p;

/// Writes arrays as one archive.
pub(crate) fn npz(out: &mut dyn Write, arrays: &[Array]) -> io::Result<()> {
    let mut archive = ZipArchiveWriter::new(out);
    arrays.iter().try_for_each(|array| put(&mut archive, array))?;
    archive.finish().map_err(io::Error::other)?;
    Ok(())
}

/// Writes arrays as one archive, and those that `fill` gives a part of at a time. The largest of these goes where it is to be, the others
/// through temporary files.
///
/// # Errors
/// Those of `fill` and of writing; arrays that do not have the numbers of their shapes.
pub(crate) fn npz_growing<E: From<io::Error>>(
    out: &mut dyn Write,
    arrays: &[Array],
    growing: &[Growing],
    fill: impl FnOnce(&mut Put<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let mut archive = ZipArchiveWriter::new(out);
    arrays.iter().try_for_each(|array| put(&mut archive, array))?;
    let size = |of: &Growing| of.shape.iter().product::<usize>();
    let Some(largest) = (0..growing.len()).max_by_key(|at| size(&growing[*at])) else {
        return Ok(archive.finish().map(|_| ()).map_err(io::Error::other)?);
    };
    let mut spools = Vec::new();
    for _ in 1..growing.len() {
        spools.push(BufWriter::new(tempfile::spooled_tempfile(SPOOLED)));
    }
    let mut counts = vec![0; growing.len()];
    within(&mut archive, &growing[largest], |writer| {
        fill(&mut |parts: &[&[f64]]| {
            let mut spools = spools.iter_mut();
            for (at, numbers) in parts.iter().enumerate() {
                counts[at] += numbers.len();
                match at == largest {
                    true => doubles(writer, numbers)?,
                    false => {
                        spools.next().map_or(Ok(()), |spool| doubles(spool, numbers)).map_err(of_folder)?
                    }
                }
            }
            Ok(())
        })
    })?;
    if counts.iter().zip(growing).any(|(count, of)| *count != size(of)) {
        return Err(io::Error::other("the states have changed while they were read").into());
    }
    let others = (0..growing.len()).filter(|at| *at != largest);
    for (at, spool) in others.zip(spools) {
        let mut file = spool.into_inner().map_err(|error| of_folder(error.into_error()))?;
        file.seek(SeekFrom::Start(0))?;
        within(&mut archive, &growing[at], |mut writer| io::copy(&mut file, &mut writer).map(|_| ()))?;
    }
    archive.finish().map_err(io::Error::other)?;
    Ok(())
}

/// How many bytes of an array are held before they go to a temporary file.
const SPOOLED: usize = 8 << 20;

/// What is wrong with a temporary file, with its folder.
fn of_folder(error: io::Error) -> io::Error {
    let folder = std::env::temp_dir();
    io::Error::new(error.kind(), format!("a temporary file in {}: {error}", folder.display()))
}

type Archive<'w> = ZipArchiveWriter<&'w mut dyn Write>;

fn put(archive: &mut Archive<'_>, array: &Array) -> io::Result<()> {
    entry(archive, array.name, |writer| writer.write_all(&array.npy()))
}

fn within<E: From<io::Error>>(
    archive: &mut Archive<'_>,
    of: &Growing,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    entry(archive, of.name, |writer| {
        writer.write_all(&header(NUMBER, &of.shape))?;
        fill(writer)
    })
}

/// A file of the archive.
fn entry<E: From<io::Error>>(
    archive: &mut Archive<'_>,
    name: &str,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let (mut entry, stored) = archive.new_file(format!("{name}.npy")).start().map_err(io::Error::other)?;
    let mut writer = stored.wrap(&mut entry);
    fill(&mut writer)?;
    let (_, descriptor) = writer.finish().map_err(io::Error::other)?;
    entry.finish(descriptor).map_err(io::Error::other)?;
    Ok(())
}

fn doubles(out: &mut (impl Write + ?Sized), numbers: &[f64]) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(AT_ONCE * 8);
    for part in numbers.chunks(AT_ONCE) {
        bytes.clear();
        bytes.extend(part.iter().flat_map(|x| x.to_le_bytes()));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// How many doubles are made bytes at a time.
const AT_ONCE: usize = 8192;
