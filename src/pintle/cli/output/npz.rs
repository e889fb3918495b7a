//! Arrays as NumPy reads them: `.npz`, an archive of `.npy` files, not compressed.

use rawzip::ZipArchiveWriter;
use std::io::{self, Write};

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

    /// As a file: magic, version 1.0, the length of the header, the header filled up to a multiple of 64, the items.
    fn npy(&self) -> Vec<u8> {
        const ALIGNED: usize = 64;
        const BEFORE: usize = 10;
        // Words have one width, of four bytes a letter.
        let (descr, width) = match &self.items {
            Items::Numbers(_) => ("<f8".to_string(), 0),
            Items::Counts(_) => ("<u8".to_string(), 0),
            Items::Words(words) => {
                let width = words.iter().map(|word| word.chars().count()).max().unwrap_or(0).max(1);
                (format!("<U{width}"), width)
            }
        };
        let shape: String = self.shape.iter().map(|length| format!("{length}, ")).collect();
        let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
        while !(BEFORE + header.len() + 1).is_multiple_of(ALIGNED) {
            header.push(' ');
        }
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
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

/// Writes arrays as one archive.
pub(crate) fn npz(out: &mut dyn Write, arrays: &[Array]) -> io::Result<()> {
    let written = || -> Result<(), rawzip::Error> {
        let mut archive = ZipArchiveWriter::new(out);
        for array in arrays {
            let (mut entry, stored) = archive.new_file(format!("{}.npy", array.name)).start()?;
            let mut writer = stored.wrap(&mut entry);
            writer.write_all(&array.npy())?;
            let (_, descriptor) = writer.finish()?;
            entry.finish(descriptor)?;
        }
        archive.finish()?;
        Ok(())
    };
    written().map_err(io::Error::other)
}
