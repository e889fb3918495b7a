//! Tables by label.

use crate::label::Label;
use indexmap::IndexMap;
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::sync::LazyLock;

/// Things by label, in the order in which they came.
pub type ByLabel<T> = IndexMap<Label, T, LabelState>;
/// Things by label, in no order.
pub type LabelMap<T> = HashMap<Label, T, LabelState>;
/// Labels, in no order.
pub type LabelSet = HashSet<Label, LabelState>;

/// Labels in blocks of so many, a power of 2, that stay together in a table.
const BLOCK: u64 = 64;

/// Puts labels into tables such that neighbours, in number, are neighbours in memory.
///
/// Decks number in rows, and go through elements and nodes in that order. With a million of them, a table in which each label stood by itself
/// would have every second look-up wait for memory. Which block goes where is random, and not the same in two runs, so that no deck is slow on
/// purpose; nothing that is shown follows the order of such a table.
#[derive(Clone, Copy, Debug)]
pub struct LabelState {
    seed: u64,
}

impl Default for LabelState {
    fn default() -> Self {
        static SEED: LazyLock<u64> = LazyLock::new(|| RandomState::new().hash_one(0));
        Self { seed: *SEED }
    }
}

impl BuildHasher for LabelState {
    type Hasher = LabelHasher;

    fn build_hasher(&self) -> LabelHasher {
        LabelHasher { others: self.seed, number: 0 }
    }
}

/// The hasher of [`LabelState`].
#[derive(Clone, Debug)]
pub struct LabelHasher {
    /// The seed, and what was hashed before the number.
    others: u64,
    number: u64,
}

/// Both halves of a product with a number without pattern: all bits of the result depend on those of x.
fn folded(x: u64) -> u64 {
    let product = u128::from(x) * 0x9e37_79b9_7f4a_7c15;
    (product as u64) ^ ((product >> 64) as u64)
}

impl Hasher for LabelHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.others = folded(self.others ^ u64::from(*byte)));
    }

    /// An instance.
    fn write_usize(&mut self, instance: usize) {
        self.others = folded(self.others ^ instance as u64);
    }

    /// A number: the last one decides the place within a block.
    fn write_u64(&mut self, number: u64) {
        self.others = folded(self.others ^ self.number);
        self.number = number;
    }

    fn finish(&self) -> u64 {
        let (block, within) = (folded(self.others ^ (self.number / BLOCK)), self.number % BLOCK);
        // The low bits are the place, the highest seven tell neighbours apart.
        (block - block % BLOCK + within) ^ (within << 57)
    }
}

/// Looks labels up beside the one before.
///
/// Elements mostly name nodes that are numbered without gaps and stand in their order: one is as far behind the other as their numbers are apart. Sets mostly
/// list what they have in its order. To look there first waits for memory once, and not three times, where a table of millions has left the caches.
#[derive(Debug)]
pub(crate) struct Beside<'a, T> {
    table: &'a ByLabel<T>,
    /// The place after the last one found, and its number.
    last: Cell<(usize, u64)>,
}

impl<'a, T> Beside<'a, T> {
    /// Looks up in a table.
    pub(crate) const fn new(table: &'a ByLabel<T>) -> Self {
        Self { table, last: Cell::new((0, 0)) }
    }

    /// What has a label.
    pub(crate) fn get(&self, label: Label) -> Option<&'a T> {
        let (next, number) = self.last.get();
        let beside = (next as u64).wrapping_add(label.number()).wrapping_sub(number).wrapping_sub(1);
        let at = |place: usize| {
            let (known, found) = self.table.get_index(place)?;
            (*known == label).then_some((place, found))
        };
        let near = at(next).or_else(|| at(usize::try_from(beside).ok()?));
        let (place, found) =
            near.or_else(|| self.table.get_full(&label).map(|(place, _, found)| (place, found)))?;
        self.last.set((place + 1, label.number()));
        Some(found)
    }

    /// Whether it is there.
    pub(crate) fn contains(&self, label: Label) -> bool {
        self.get(label).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::{BLOCK, Beside, ByLabel, Label, LabelSet, LabelState};
    use crate::label::Instance;
    use std::collections::HashSet;
    use std::hash::BuildHasher;

    /// Neighbours are side by side, with marks of their own; blocks are anywhere, also those of labels with gaps.
    #[test]
    fn neighbours_stay_together() {
        let state = LabelState::default();
        let place = |label: Label, places: u64| state.hash_one(label) % places;
        let places = 1 << 20;
        for number in [64, 6_400_000, 64 << 30] {
            let first = place(Label::from(number), places);
            for next in 1..BLOCK {
                assert_eq!(place(Label::from(number + next), places), first + next);
            }
            let marks: HashSet<u64> =
                (number..number + BLOCK).map(|number| state.hash_one(Label::from(number)) >> 57).collect();
            assert_eq!(marks.len() as u64, BLOCK);
        }
        let (one, other) = (Instance::named("ONE-1"), Instance::named("OTHER-1"));
        for step in [BLOCK, 1000, 1 << 10, 1 << 20] {
            for instance in [None, Some(one), Some(other)] {
                let found: HashSet<u64> =
                    (0..1000).map(|i| place(Label::of(instance, i * step), places) / BLOCK).collect();
                // Of 16384 blocks, a thousand drawn at random are 970.
                assert!((920..=1000).contains(&found.len()), "{step} {instance:?}: {}", found.len());
            }
        }
        assert_ne!(state.hash_one(Label::of(Some(one), 5)), state.hash_one(Label::of(Some(other), 5)));
        assert_ne!(state.hash_one(Label::of(Some(one), 5)), state.hash_one(Label::from(5)));
    }

    #[test]
    fn every_label_is_found() {
        let labels = || (1..5000).map(|i| Label::of((i % 3 == 0).then(|| Instance::named("A-1")), i * i));
        let table: ByLabel<u64> = labels().map(|label| (label, label.number())).collect();
        let set: LabelSet = labels().collect();
        for label in labels() {
            assert!(table.get(&label) == Some(&label.number()) && set.contains(&label), "{label}");
            assert!(!set.contains(&Label::of(label.instance(), label.number() + 1)), "{label}");
        }
        assert_eq!((table.len(), set.len()), (4999, 4999));
        // In their order, far apart, backwards, and what is not there.
        let beside = Beside::new(&table);
        let others =
            (1..9000).map(|i| Label::of((i % 5 == 0).then(|| Instance::named("A-1")), i * 37 % 5003));
        for label in labels().chain(others).chain(labels().collect::<Vec<_>>().into_iter().rev()) {
            assert_eq!(beside.get(label), table.get(&label), "{label}");
        }
        assert_eq!(Beside::new(&ByLabel::<u64>::default()).get(Label::from(1)), None);
    }
}
