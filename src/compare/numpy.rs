//! Files of NumPy: `.npy` with one array, `.npz` with several. Records are read one at a time, whatever the size of the file.

use crate::printed::Printed;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// The longest header that is read.
const LONGEST: usize = 1 << 20;

/// A number as it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stored {
    /// f, i, u or b.
    letter: u8,
    size: usize,
    is_big: bool,
}

/// An array, read from its first number on.
pub(crate) struct Array {
    /// In an `.npz`, else empty.
    pub(crate) name: String,
    pub(crate) shape: Vec<usize>,
    /// The fields of a record; one without a name where the array is of plain numbers.
    pub(crate) fields: Vec<String>,
    pub(crate) is_fortran: bool,
    stored: Vec<Stored>,
    from: Box<dyn Read>,
}

/// The longest text of an array, in characters.
const TEXT: usize = 1_000;

impl Stored {
    fn parse(descr: &str) -> Result<Self, String> {
        let refused =
            || format!("numbers of type {descr:?} are not read; there are f4, f8, i1 … i8, u1 … u8 and b1");
        let (order, rest) = descr.split_at_checked(1).ok_or_else(refused)?;
        let (order, rest) = if "<>|=".contains(order) { (order, rest) } else { ("<", descr) };
        let letter = *rest.as_bytes().first().ok_or_else(refused)?;
        let size: usize = rest[1..].parse().map_err(|_| refused())?;
        let is_known = match letter {
            b'f' => matches!(size, 4 | 8),
            b'i' | b'u' => matches!(size, 1 | 2 | 4 | 8),
            b'b' => size == 1,
            b'U' | b'S' => (1..=TEXT).contains(&size),
            _ => false,
        };
        let size = if letter == b'U' { 4 * size } else { size };
        if is_known { Ok(Self { letter, size, is_big: order == ">" }) } else { Err(refused()) }
    }

    const fn is_text(self) -> bool {
        matches!(self.letter, b'U' | b'S')
    }

    fn text(self, bytes: &[u8]) -> String {
        let code = |four: &[u8]| {
            let four = four.try_into().unwrap_or_default();
            let code = if self.is_big { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) };
            char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER)
        };
        let all: String = match self.letter {
            b'U' => bytes.chunks_exact(4).map(code).collect(),
            _ => String::from_utf8_lossy(bytes).into_owned(),
        };
        all.trim_end_matches('\0').to_string()
    }

    fn number(self, bytes: &[u8]) -> Printed {
        let mut little = [0_u8; 8];
        for (place, byte) in bytes.iter().enumerate() {
            little[if self.is_big { self.size - 1 - place } else { place }] = *byte;
        }
        match (self.letter, self.size) {
            (b'f', 4) => {
                let [a, b, c, d, ..] = little;
                Printed::double(f64::from(f32::from_le_bytes([a, b, c, d]))).single()
            }
            (b'f', _) => Printed::double(f64::from_le_bytes(little)),
            (b'i', size) => {
                let shift = 64 - 8 * size as u32;
                Printed::double((i64::from_le_bytes(little) << shift >> shift) as f64)
            }
            _ => Printed::double(u64::from_le_bytes(little) as f64),
        }
    }
}

impl Array {
    /// The array of a stream.
    fn read(name: String, mut from: Box<dyn Read>) -> Result<Self, String> {
        let mut start = [0_u8; 8];
        from.read_exact(&mut start).map_err(|error| error.to_string())?;
        if &start[..6] != b"\x93NUMPY" {
            return Err("this is no array of NumPy".into());
        }
        let mut length = [0_u8; 4];
        let bytes = if start[6] == 1 { 2 } else { 4 };
        from.read_exact(&mut length[..bytes]).map_err(|error| error.to_string())?;
        let length = u32::from_le_bytes(length) as usize;
        if length > LONGEST {
            return Err(format!("its header is {length} bytes long"));
        }
        let mut header = vec![0_u8; length];
        from.read_exact(&mut header).map_err(|error| error.to_string())?;
        let header = String::from_utf8_lossy(&header);
        let after = |key: &str| {
            let quoted = [format!("'{key}':"), format!("\"{key}\":")];
            let at = quoted.iter().find_map(|quoted| Some(header.find(quoted.as_str())? + quoted.len()));
            at.map(|at| header[at..].trim_start()).ok_or_else(|| format!("its header has no {key}"))
        };
        let is_fortran = after("fortran_order")?.starts_with("True");
        let inside = |text: &str, ends: [char; 2]| {
            let text = text.strip_prefix(ends[0])?;
            Some(text[..text.find(ends[1])?].to_string())
        };
        let shape = inside(after("shape")?, ['(', ')']).ok_or("its header has no shape")?;
        let shape = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
        let shape: Vec<usize> = shape
            .map(|size| size.parse().map_err(|_| format!("its shape has {size:?}")))
            .collect::<Result<_, _>>()?;
        let descr = after("descr")?;
        let strings = |text: &str| -> Vec<String> {
            let quoted = text.split(['\'', '"']).enumerate().filter(|(n, _)| n % 2 == 1);
            quoted.map(|(_, text)| text.to_string()).collect()
        };
        let (fields, types) = if descr.starts_with('[') {
            let list = inside(descr, ['[', ']']).ok_or("its header has no list of fields")?;
            let all = strings(&list);
            if all.len() % 2 != 0 || list.matches('(').count() * 2 != all.len() {
                return Err("fields that are arrays themselves are not read: give each number a field".into());
            }
            let names = all.iter().step_by(2).cloned().collect();
            (names, all.into_iter().skip(1).step_by(2).collect())
        } else {
            let kind =
                strings(&descr[..descr.len().min(40)]).into_iter().next().ok_or("its header has no type")?;
            (vec![String::new()], vec![kind])
        };
        let stored = types.iter().map(|of| Stored::parse(of)).collect::<Result<_, _>>()?;
        Ok(Self { name, shape, fields, is_fortran, stored, from })
    }

    /// Whether its entries are texts.
    pub(crate) fn is_text(&self) -> bool {
        self.stored.iter().any(|of| of.is_text())
    }

    /// All entries of an array of labels, whole numbers or texts.
    pub(crate) fn labels(&mut self) -> Result<Vec<String>, String> {
        let all = self.shape.iter().try_fold(1, |all: usize, size| all.checked_mul(*size));
        let count = all.ok_or_else(|| format!("its shape {:?} is too large", self.shape))?;
        if !self.is_text() {
            return Ok(self.take(count)?.into_iter().map(|number| number.x.to_string()).collect());
        }
        let [stored] = self.stored[..] else { return Err("its labels have fields".into()) };
        let mut found = Vec::new();
        let mut bytes = vec![0_u8; stored.size];
        for _ in 0..count {
            self.from.read_exact(&mut bytes).map_err(|error| error.to_string())?;
            found.push(stored.text(&bytes));
        }
        Ok(found)
    }

    /// The next record; `None` at the end of the stream.
    pub(crate) fn next(&mut self) -> Result<Option<Vec<Printed>>, String> {
        if self.is_text() {
            return Err(format!("{} has texts, and is no array of numbers: leave it out", self.name));
        }
        let size: usize = self.stored.iter().map(|of| of.size).sum();
        let mut bytes = vec![0_u8; size];
        match self.from.read_exact(&mut bytes) {
            Ok(()) => {}
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => return Ok(None),
            Err(error) => return Err(error.to_string()),
        }
        let mut at = 0;
        let numbers = self.stored.iter().map(|of| {
            at += of.size;
            of.number(&bytes[at - of.size..at])
        });
        Ok(Some(numbers.collect()))
    }

    /// So many numbers of a plain array.
    pub(crate) fn take(&mut self, count: usize) -> Result<Vec<Printed>, String> {
        let mut found = Vec::new();
        while found.len() < count {
            match self.next()? {
                Some(record) => found.extend(record),
                None => return Err(format!("it ends after {} of {count} numbers", found.len())),
            }
        }
        Ok(found)
    }
}

/// The arrays of a file, and the format of a sparse matrix of SciPy, where they are one.
pub(crate) fn arrays(path: &Path) -> Result<(Vec<Array>, Option<String>), String> {
    let named = |why: String| format!("{}: {why}", path.display());
    let opened = || File::open(path).map_err(|error| format!("cannot read {}: {error}", path.display()));
    let is_archive = path.extension().is_some_and(|of| of.eq_ignore_ascii_case("npz"));
    if !is_archive {
        let array = Array::read(String::new(), Box::new(BufReader::new(opened()?))).map_err(named)?;
        return Ok((vec![array], None));
    }
    let mut buffer = vec![0_u8; rawzip::RECOMMENDED_BUFFER_SIZE];
    let broken = |error: rawzip::Error| named(error.to_string());
    let archive = rawzip::ZipArchive::from_file(opened()?, &mut buffer).map_err(broken)?;
    let mut entries = archive.entries(&mut buffer);
    let (mut found, mut format) = (Vec::new(), None);
    while let Some(entry) = entries.next_entry().map_err(broken)? {
        let path = entry.file_path();
        let name = String::from_utf8_lossy(path.as_ref()).trim_end_matches(".npy").to_string();
        let (method, place) = (entry.compression_method(), entry.wayfinder());
        let (from, to) = archive.get_entry(place).map_err(broken)?.compressed_data_range();
        // Each array is read by itself, from its place in the file.
        let mut file = BufReader::new(opened()?);
        file.seek(SeekFrom::Start(from)).map_err(|error| named(error.to_string()))?;
        let stored = file.take(to - from);
        let from: Box<dyn Read> = match method {
            rawzip::CompressionMethod::STORE => Box::new(stored),
            rawzip::CompressionMethod::DEFLATE => {
                Box::new(BufReader::new(flate2::read::DeflateDecoder::new(stored)))
            }
            _ => {
                return Err(named(format!(
                    "{name} is packed in a way that is not read: use np.savez or np.savez_compressed"
                )));
            }
        };
        if name == "format" {
            let mut text = Vec::new();
            from.take(LONGEST as u64).read_to_end(&mut text).map_err(|error| named(error.to_string()))?;
            format = text.get(text.len().saturating_sub(3)..).map(|end| String::from_utf8_lossy(end).into());
            continue;
        }
        found.push(Array::read(name.clone(), from).map_err(|why| named(format!("{name}: {why}")))?);
    }
    Ok((found, format))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn header(descr: &str, shape: &str, is_fortran: bool) -> Vec<u8> {
        let order = if is_fortran { "True" } else { "False" };
        let text = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes
    }

    fn read(bytes: Vec<u8>) -> Result<Array, String> {
        Array::read(String::new(), Box::new(std::io::Cursor::new(bytes)))
    }

    /// Texts are labels, and no numbers, however long: a matrix of them is refused.
    #[test]
    fn texts_are_labels_only() {
        let mut bytes = header("'<U5'", "(2, 1)", false);
        for text in ["A-1", "node2"] {
            bytes.extend(
                text.chars().chain(std::iter::repeat('\0')).take(5).flat_map(|c| u32::from(c).to_le_bytes()),
            );
        }
        assert!(read(bytes.clone()).unwrap().next().unwrap_err().contains("has texts"));
        assert_eq!(read(bytes).unwrap().labels().unwrap(), ["A-1", "node2"]);
        let huge = header("'<U1'", &format!("({0}, {0})", usize::MAX), false);
        assert!(read(huge).unwrap().labels().unwrap_err().contains("too large"));
    }

    #[test]
    fn arrays_are_read_with_what_their_numbers_can_tell() {
        let mut bytes = header("[('time', '<f8'), ('U1', '>f4'), ('node', '<i2')]", "(2,)", false);
        for (time, u, node) in [(0.5_f64, 0.1_f32, -3_i16), (1.0, 0.25, 7)] {
            bytes.extend(time.to_le_bytes());
            bytes.extend(u.to_be_bytes());
            bytes.extend(node.to_le_bytes());
        }
        let mut array = read(bytes).unwrap();
        assert_eq!(
            (array.shape.clone(), array.fields.clone()),
            (vec![2], vec!["time".into(), "U1".into(), "node".into()])
        );
        let first = array.next().unwrap().unwrap();
        assert_eq!((first[0].x, first[1].x, first[2].x), (0.5, f64::from(0.1_f32), -3.0));
        assert!((first[1].half / (0.1 * 2.0_f64.powi(-24)) - 1.0).abs() < 1e-6);
        assert_eq!(array.next().unwrap().unwrap()[1].x, 0.25);
        assert!(array.next().unwrap().is_none());
        for (wrong, words) in [
            (header("'<c16'", "(2,)", false), "c16"),
            (header("[('U', '<f8', (3,))]", "(2,)", false), "fields that are arrays"),
            (header("'<U0'", "(2,)", false), "U0"),
            (b"not an array".to_vec(), "no array of NumPy"),
            (vec![], "fill whole buffer"),
        ] {
            let why = read(wrong).err().unwrap();
            assert!(why.contains(words), "{why}");
        }
    }

    #[test]
    fn archives_are_read_packed_and_not() {
        let folder = std::env::temp_dir().join(format!("pintle-npz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("run.npz");
        let mut bytes = header("'<f8'", "(3,)", false);
        for x in [1.0_f64, 2.5, -4.0] {
            bytes.extend(x.to_le_bytes());
        }
        let mut archive = rawzip::ZipArchiveWriter::new(Vec::new());
        for (name, method) in
            [("time.npy", rawzip::CompressionMethod::STORE), ("U.npy", rawzip::CompressionMethod::DEFLATE)]
        {
            let (mut entry, config) = archive.new_file(name).compression_method(method).start().unwrap();
            let packed = if method == rawzip::CompressionMethod::STORE {
                bytes.clone()
            } else {
                let mut packer = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
                packer.write_all(&bytes).unwrap();
                packer.finish().unwrap()
            };
            let mut writer = config.wrap(&mut entry);
            writer.write_all(&packed).unwrap();
            let (_, output) = writer.finish().unwrap();
            entry.finish(output).unwrap();
        }
        std::fs::write(&path, archive.finish().unwrap()).unwrap();
        let (mut all, format) = arrays(&path).unwrap();
        assert_eq!(format, None);
        assert_eq!(all.iter().map(|of| of.name.as_str()).collect::<Vec<_>>(), ["time", "U"]);
        for array in &mut all {
            let found: Vec<f64> = array.take(3).unwrap().into_iter().map(|x| x.x).collect();
            assert_eq!(found, [1.0, 2.5, -4.0]);
            assert!(array.take(1).is_err());
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
