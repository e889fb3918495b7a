//! What a check has seen of all its states, right ones too. Wrong numbers near a special kind of states, and right ones elsewhere, are a
//! guard, a clamp, a series or another formula that begins there.

use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::places::{PLACES, Places};
use crate::mutants::diagnosis::{Diagnosis, Explained};
use pintle_scene::grammar::number as short;
use std::collections::BTreeMap;

/// So near states must be where all wrong ones are, in radians or lengths of the connector.
const FAR: f64 = 0.3;

/// So many states tell, wrong ones and right ones: chance puts all the wrong ones nearest in one of five thousand times, of each kind.
const TELL: [u32; 2] = [3, 30];

/// So many tell where some are right that are nearer than any wrong one, for there rounding hides what is wrong.
const TELL_BETWEEN: [u32; 2] = [4, 30];

/// One of so many states that are as near may be right all the same.
const SPARED: u32 = 10;

/// States at like distances from a special kind.
#[derive(Clone, Copy, Debug)]
struct Bin {
    /// Right ones, and wrong ones.
    states: [u32; 2],
    /// The smallest distance of a right one, and the largest.
    of_right: [f64; 2],
    /// The same of wrong ones.
    of_wrong: [f64; 2],
}

/// The distances of no state.
const NONE: [f64; 2] = [f64::INFINITY, 0.0];

/// What a check has seen of all its states.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// How far they were from each kind of special ones, by powers of two.
    places: BTreeMap<(usize, i32), Bin>,
    /// Of each component how many of its values were right, below zero and above, and how large.
    right: BTreeMap<(usize, bool), (usize, f64)>,
    /// At how many states each component was right as a whole, and not zero.
    whole: BTreeMap<usize, usize>,
    states: usize,
    wrong: usize,
}

impl Seen {
    /// Adds a value that is right.
    pub fn add_right(&mut self, k: usize, want: f64, tolerance: f64) {
        if want.abs() > tolerance {
            let known = self.right.entry((k, want > 0.0)).or_default();
            *known = (known.0 + 1, known.1.max(want.abs() - tolerance));
        }
    }

    /// How many values of a component were right, above zero or below, and how large the largest was.
    pub(super) fn right(&self, k: usize, is_above: bool) -> (usize, f64) {
        self.right.get(&(k, is_above)).copied().unwrap_or_default()
    }

    /// Adds a component that is right as a whole, and not zero.
    pub fn add_whole(&mut self, k: usize) {
        *self.whole.entry(k).or_default() += 1;
    }

    /// At how many states a component was right as a whole, and not zero.
    pub(super) fn whole(&self, k: usize) -> usize {
        self.whole.get(&k).copied().unwrap_or_default()
    }

    /// At how many states something was wrong.
    pub(super) const fn wrong(&self) -> usize {
        self.wrong
    }

    /// How many states.
    pub const fn states(&self) -> usize {
        self.states
    }

    /// Adds a state.
    pub fn add(&mut self, distances: &Places, is_wrong: bool) {
        self.states += 1;
        self.wrong += usize::from(is_wrong);
        for (kind, distance) in distances.iter().copied().enumerate() {
            // On the set itself numbers may be none, or be excused.
            if !distance.is_finite() || distance == 0.0 && !is_wrong {
                continue;
            }
            #[expect(clippy::cast_possible_truncation, reason = "a logarithm of a double")]
            let magnitude = distance.max(1e-300).log2().floor() as i32;
            let one = Bin {
                states: [u32::from(!is_wrong), u32::from(is_wrong)],
                of_right: if is_wrong { NONE } else { [distance; 2] },
                of_wrong: if is_wrong { [distance; 2] } else { NONE },
            };
            self.put((kind, magnitude), one);
        }
    }

    fn put(&mut self, place: (usize, i32), one: Bin) {
        let known =
            self.places.entry(place).or_insert(Bin { states: [0; 2], of_right: NONE, of_wrong: NONE });
        known.states.iter_mut().zip(one.states).for_each(|(known, more)| *known += more);
        for (known, [least, most]) in
            [(&mut known.of_right, one.of_right), (&mut known.of_wrong, one.of_wrong)]
        {
            *known = [known[0].min(least), known[1].max(most)];
        }
    }

    /// Adds others.
    pub fn merge(&mut self, others: Self) {
        self.states += others.states;
        self.wrong += others.wrong;
        for (k, count) in others.whole {
            *self.whole.entry(k).or_default() += count;
        }
        others.places.into_iter().for_each(|(place, one)| self.put(place, one));
        for (place, (count, largest)) in others.right {
            let known = self.right.entry(place).or_default();
            *known = (known.0 + count, known.1.max(largest));
        }
    }

    /// The special kind of states near which all is wrong, and beyond which all is right.
    pub(super) fn near(&self) -> Option<Near> {
        let of = |kind: usize| {
            let bins = || self.places.range((kind, i32::MIN)..=(kind, i32::MAX)).map(|(_, bin)| bin);
            let farthest = bins().map(|bin| bin.of_wrong[1]).fold(0.0, f64::max);
            let closest = bins().map(|bin| bin.of_wrong[0]).fold(f64::INFINITY, f64::min);
            let wrong: u32 = bins().map(|bin| bin.states[1]).sum();
            let right = |is: &dyn Fn(&Bin) -> bool| -> u32 {
                bins().filter(|bin| is(bin)).map(|bin| bin.states[0]).sum()
            };
            let is_beyond = |bin: &Bin| bin.of_right[0] > farthest;
            let is_nearer = |bin: &Bin| bin.of_right[1] < closest;
            let (beyond, nearer) = (right(&is_beyond), right(&is_nearer));
            let spared = right(&|bin| !is_beyond(bin) && !is_nearer(bin));
            let nearest =
                bins().filter(|bin| is_beyond(bin)).map(|bin| bin.of_right[0]).fold(f64::INFINITY, f64::min);
            let tell = if nearer == 0 { TELL } else { TELL_BETWEEN };
            let is_told =
                wrong >= tell[0] && beyond >= tell[1] && spared * SPARED <= wrong && farthest <= FAR;
            is_told.then_some((spared, Near { kind, farthest, nearest, wrong, right: beyond }))
        };
        let all = (0..PLACES.len()).filter_map(of);
        // Of distances that are alike the first kind: coincident nodes are on every axis.
        let order = |(spared, near): &(u32, Near)| {
            #[expect(clippy::cast_possible_truncation, reason = "a logarithm of a double")]
            let magnitude = near.farthest.max(1e-300).log10().ceil() as i32;
            (*spared, magnitude, near.kind)
        };
        all.min_by_key(order).map(|(_, near)| near)
    }
}

/// Where all that is wrong is near, and what is not near is right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    kind: usize,
    farthest: f64,
    nearest: f64,
    wrong: u32,
    right: u32,
}

impl Near {
    /// What is found, led by where it is.
    pub(super) fn leading(self, place: &str, found: Diagnosis) -> Diagnosis {
        let Self { kind, farthest, nearest, wrong, right } = self;
        let cause = Cause::NearOnly;
        let Some((at, unit)) = PLACES.get(kind) else { return found };
        let within = if farthest == 0.0 {
            format!("only where {at}")
        } else {
            format!("only within {} {unit} of states where {at}", short(farthest, 2))
        };
        let are = if place.contains(", ") { "are" } else { "is" };
        let sentence = format!(
            "{place} {are} wrong {within}, at {wrong} states, and right at {right} from {} {unit} on: {}",
            short(nearest, 2),
            cause.meaning()
        );
        let is_zero = found.causes.first().is_some_and(|one| one.cause == Cause::ComponentZero);
        let sentence = if is_zero { format!("{sentence}; it equals zero there") } else { sentence };
        let mut causes = vec![Explained { cause, code: cause.code(), sentence, also: Vec::new() }];
        if found.is_whole() && !is_zero {
            causes.extend(found.causes);
        }
        Diagnosis { causes, unexplained: 0 }
    }
}
