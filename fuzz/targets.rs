//! A fuzz target: a body of `verify/scene/fuzzing.rs`, and mutations by lines beside those by bytes.

use libfuzzer_sys::fuzzer_mutate;
use std::path::Path;
use std::sync::LazyLock;

#[path = "../verify/scene/fuzzing.rs"]
#[expect(dead_code, reason = "each target uses one body")]
pub mod bodies;

/// Declares the target whose body has the same name.
macro_rules! target {
    ($body:ident) => {
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::bodies::$body(bytes));
        libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
            targets::mutate(data, size, max_size, seed)
        });
    };
}
pub(crate) use target;

/// Directories whose files lend their lines.
const LENDERS: [&str; 7] = [
    "../decks",
    "../verify/faults/deck",
    "../verify/faults/states",
    "../verify/faults/toml",
    "../verify/faults/json",
    "seeds/toml_scene",
    "seeds/json_scene",
];

/// Every line of the scenes and faults of the repository, once.
static LINES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let directories = LENDERS.iter().filter_map(|directory| std::fs::read_dir(root.join(directory)).ok());
    let files = directories.flatten().flatten().filter_map(|entry| std::fs::read(entry.path()).ok());
    let mut lines: Vec<Vec<u8>> =
        files.flat_map(|text| text.split(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect::<Vec<_>>()).collect();
    lines.retain(|line| (1..200).contains(&line.len()) && !line.starts_with(b"**"));
    lines.sort();
    lines.dedup();
    lines
});

/// A small generator: splitmix64.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit.max(1) as u64) as usize
    }
}

/// In half of the cases the mutations of libFuzzer; else a line is put in, taken out, moved, repeated or loses an item.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let mut random = Random(u64::from(seed));
    if random.below(2) == 0 || LINES.is_empty() {
        return fuzzer_mutate(data, size, max_size);
    }
    let mut lines: Vec<Vec<u8>> = data[..size].split(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
    for _ in 0..=random.below(4) {
        let at = random.below(lines.len());
        match random.below(6) {
            0 | 1 => lines.insert(at, LINES[random.below(LINES.len())].clone()),
            2 if lines.len() > 1 => drop(lines.remove(at)),
            3 => lines.insert(random.below(lines.len()), lines[at].clone()),
            4 => {
                let other = random.below(lines.len());
                lines.swap(at, other);
            }
            _ => {
                let mut items: Vec<&[u8]> = lines[at].split(|&byte| byte == b',').collect();
                let other = LINES[random.below(LINES.len())].split(|&byte| byte == b',');
                let other: Vec<&[u8]> = other.collect();
                let place = random.below(items.len());
                items[place] = other[random.below(other.len())];
                lines[at] = items.join(&b','); 
            }
        }
    }
    let text = lines.join(&b'\n');
    let length = text.len().min(max_size);
    data[..length].copy_from_slice(&text[..length]);
    length
}
