//! Sets of indices, as ranges that neither overlap nor touch.

use crate::SweepError;
use serde::{Deserialize, Deserializer, Serialize};

/// How many states there are.
pub const MOST: u64 = 1_000_000_000_000_000;

/// The end of `count` indices from `first` on.
///
/// # Errors
/// Where it is beyond [`MOST`].
pub fn checked(first: u64, count: u64) -> Result<u64, SweepError> {
    let end = first.checked_add(count).filter(|end| *end <= MOST);
    end.ok_or(SweepError::TooMany { first, count })
}

/// Indices from a first one on to before an end, range after range.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Ranges(Vec<[u64; 2]>);

impl<'de> Deserialize<'de> for Ranges {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let ranges = Vec::<[u64; 2]>::deserialize(from)?;
        let is_ascending = ranges.iter().all(|[first, end]| first < end && *end <= MOST)
            && ranges.windows(2).all(|pair| pair[0][1] < pair[1][0]);
        if is_ascending {
            return Ok(Self(ranges));
        }
        Err(serde::de::Error::custom("ranges that do not ascend, or touch, are no set of indices"))
    }
}

impl Ranges {
    /// `count` indices from `first` on.
    pub fn of(first: u64, count: u64) -> Self {
        let end = first.saturating_add(count);
        Self(if first < end { vec![[first, end]] } else { Vec::new() })
    }

    /// Those of any of many.
    pub fn union(all: impl IntoIterator<Item = Self>) -> Self {
        let mut union = Self(all.into_iter().flat_map(|one| one.0).collect());
        union.add(&Self::default());
        union
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

    /// Whether all of these are among others.
    pub fn is_within(&self, other: &Self) -> bool {
        self.without(other).0.is_empty()
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
    pub fn chunks(&self, size: u64) -> impl Iterator<Item = (u64, u64)> + '_ {
        let size = size.max(1);
        let next = move |from: u64| (from / size).saturating_add(1).saturating_mul(size);
        self.0.iter().flat_map(move |[first, end]| {
            let firsts = std::iter::successors(Some(*first), move |from| Some(next(*from)));
            firsts.take_while(move |from| from < end).map(move |from| (from, next(from).min(*end) - from))
        })
    }

    /// How many chunks those are.
    pub fn count_chunks(&self, size: u64) -> u64 {
        let size = size.max(1);
        self.0.iter().map(|[first, end]| end.div_ceil(size) - first / size).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, Ranges, checked};

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
        assert_eq!(left.chunks(4).collect::<Vec<_>>(), [(0, 4), (4, 4), (8, 2), (17, 3)]);
        assert_eq!(left.count_chunks(4), 4);
        assert!(Ranges::of(12, 5).is_within(&done) && !Ranges::of(12, 6).is_within(&done));
        let mut again = left;
        again.add(&done);
        assert_eq!(again, Ranges::of(0, 30));
    }

    /// The chunks of very many states are not listed; ends are not computed beyond what a number holds.
    #[test]
    fn very_many_states_take_no_room() {
        let all = Ranges::of(0, MOST);
        assert_eq!((all.chunks(1).take(3).count(), all.count_chunks(1)), (3, MOST));
        assert_eq!(
            Ranges::of(u64::MAX - 3, 9).chunks(2).collect::<Vec<_>>(),
            [(u64::MAX - 3, 2), (u64::MAX - 1, 1)]
        );
        assert_eq!(checked(MOST - 2, 2).ok(), Some(MOST));
        assert!(checked(MOST - 2, 3).is_err() && checked(u64::MAX, 2).is_err());
    }

    #[test]
    fn what_is_no_set_is_not_read() {
        let of = |text: &str| serde_json::from_str::<Ranges>(text).is_ok();
        assert!(of("[[0,3],[4,5]]") && of("[]"));
        for text in ["[[3,0]]", "[[0,3],[3,5]]", "[[4,5],[0,3]]", "[[0,0]]", "[[0,1000000000000001]]"] {
            assert!(!of(text), "{text}");
        }
    }
}
