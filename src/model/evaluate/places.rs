//! Where labels stand in a list of them.

use pintle_scene::Label;
use std::cell::Cell;

/// Finds labels in a list that is in their order.
///
/// What is asked for one after another is mostly near, and mostly numbered without gaps: the place that follows from the one before is looked at
/// first, which needs no search through a list that has left the caches.
pub(super) struct Places<'a> {
    labels: &'a [Label],
    last: Cell<usize>,
}

impl<'a> Places<'a> {
    /// The places in a sorted list.
    pub(super) const fn new(labels: &'a [Label]) -> Self {
        Self { labels, last: Cell::new(0) }
    }

    /// The place of a label, if it is there.
    pub(super) fn of(&self, label: Label) -> Option<usize> {
        let last = self.last.get();
        let known = self.labels.get(last)?.number();
        let guess = usize::try_from((last as u64).wrapping_add(label.number()).wrapping_sub(known)).ok();
        let guess = guess.filter(|place| self.labels.get(*place) == Some(&label));
        let place = guess.or_else(|| self.labels.binary_search(&label).ok())?;
        self.last.set(place);
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::Places;
    use pintle_scene::{Instance, Label};

    #[test]
    fn places_are_those_of_a_search() {
        let instance = Some(Instance::named("PLACES-1"));
        let mut labels: Vec<Label> = (1..200).filter(|i| i % 7 != 3).map(Label::from).collect();
        labels.extend((50..90).map(|i| Label::of(instance, i)));
        labels.sort_unstable();
        let places = Places::new(&labels);
        for i in 0..2000 {
            let label = Label::of(instance.filter(|_| i % 5 == 0), i * 37 % 211);
            assert_eq!(places.of(label), labels.binary_search(&label).ok(), "{label}");
        }
        for label in labels.iter().chain(labels.iter().rev()) {
            assert_eq!(places.of(*label), labels.binary_search(label).ok(), "{label}");
        }
        assert_eq!(Places::new(&[]).of(Label::from(1)), None);
    }
}
