//! Sets of indices, as ranges that neither overlap nor touch.

use serde::{Deserialize, Serialize};

/// Indices from a first one on to before an end, range after range.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Ranges(Vec<[u64; 2]>);

impl Ranges {
    /// `count` indices from `first` on.
    pub fn of(first: u64, count: u64) -> Self {
        let end = first.saturating_add(count);
        Self(if first < end { vec![[first, end]] } else { Vec::new() })
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.0.iter().map(|[first, end]| end - first).sum()
    }

    /// Range by range.
    pub fn iter(&self) -> impl Iterator<Item = [u64; 2]> + '_ {
        self.0.iter().copied()
    }

    /// The first index that both have.
    pub fn overlap(&self, other: &Self) -> Option<u64> {
        let first = |a: &[u64; 2]| {
            let common = other.0.iter().find(|b| a[0].max(b[0]) < a[1].min(b[1]))?;
            Some(a[0].max(common[0]))
        };
        self.0.iter().find_map(first)
    }

    /// Adds others, which may touch these.
    pub fn add(&mut self, other: &Self) {
        self.0.extend(&other.0);
        self.0.sort_unstable();
        let mut merged: Vec<[u64; 2]> = Vec::with_capacity(self.0.len());
        for range in &self.0 {
            match merged.last_mut().filter(|last| last[1] >= range[0]) {
                Some(last) => last[1] = last[1].max(range[1]),
                None => merged.push(*range),
            }
        }
        self.0 = merged;
    }

    /// What is left of these without others.
    #[must_use]
    pub fn without(&self, other: &Self) -> Self {
        let mut left = Vec::new();
        for [first, end] in &self.0 {
            let mut from = *first;
            for [start, stop] in other.0.iter().filter(|[start, stop]| start < end && stop > first) {
                if *start > from {
                    left.push([from, *start]);
                }
                from = from.max(*stop);
            }
            if from < *end {
                left.push([from, *end]);
            }
        }
        Self(left)
    }

    /// In chunks of at most `size` that begin at multiples of it, or where a range does: as (first, count).
    pub fn chunks(&self, size: u64) -> Vec<(u64, u64)> {
        let size = size.max(1);
        let mut found = Vec::new();
        for [first, end] in &self.0 {
            let mut from = *first;
            while from < *end {
                let to = (from / size).saturating_add(1).saturating_mul(size).min(*end);
                found.push((from, to - from));
                from = to;
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::Ranges;

    #[test]
    fn what_is_done_and_what_is_left_is_all() {
        let mut done = Ranges::of(10, 5);
        done.add(&Ranges::of(20, 10));
        done.add(&Ranges::of(15, 2));
        assert_eq!(done.iter().collect::<Vec<_>>(), [[10, 17], [20, 30]]);
        assert_eq!(done.overlap(&Ranges::of(16, 9)), Some(16));
        assert_eq!(done.overlap(&Ranges::of(17, 3)), None);
        let all = Ranges::of(0, 28);
        let left = all.without(&done);
        assert_eq!(left.iter().collect::<Vec<_>>(), [[0, 10], [17, 20]]);
        assert_eq!(left.chunks(4), [(0, 4), (4, 4), (8, 2), (17, 3)]);
        let mut again = left;
        again.add(&done);
        assert_eq!(again, Ranges::of(0, 30));
    }
}
