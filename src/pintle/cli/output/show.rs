//! Which states are written.

use std::ops::RangeInclusive;
use std::str::FromStr;

/// A list of states: numbers, ranges, `first`, `middle`, `last`, `all`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Show(Vec<Item>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Item {
    All,
    First,
    Middle,
    Last,
    Numbers(RangeInclusive<u64>),
}

impl Show {
    /// Every state.
    pub(crate) fn all() -> Self {
        Self(vec![Item::All])
    }

    /// Middle and last: the first is at rest.
    pub(crate) fn overview() -> Self {
        Self(vec![Item::Middle, Item::Last])
    }

    /// The numbers of the states that are shown, out of those in `known`, which increase. The ends of a range are states.
    ///
    /// # Errors
    /// A number that is not one of them, in words.
    pub(crate) fn among(&self, known: &[u64]) -> Result<Vec<RangeInclusive<u64>>, String> {
        let ([first, ..], [.., last]) = (known, known) else { return Ok(Vec::new()) };
        let middle = known.get((known.len() - 1) / 2).unwrap_or(first);
        let one = |number: &u64| Ok(*number..=*number);
        self.0
            .iter()
            .map(|item| match item {
                Item::All => Ok(*first..=*last),
                Item::First => one(first),
                Item::Middle => one(middle),
                Item::Last => one(last),
                Item::Numbers(range) => {
                    match [range.start(), range.end()]
                        .into_iter()
                        .find(|end| known.binary_search(end).is_err())
                    {
                        None => Ok(range.clone()),
                        Some(wrong) => Err(format!("there is no state {wrong}: they are {first} to {last}")),
                    }
                }
            })
            .collect()
    }
}

impl FromStr for Show {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<u64>().ok();
        text.split(',')
            .map(|item| match item.trim().to_ascii_lowercase().as_str() {
                "all" => Ok(Item::All),
                "first" => Ok(Item::First),
                "middle" => Ok(Item::Middle),
                "last" => Ok(Item::Last),
                other => {
                    let (from, to) = other.split_once('-').unwrap_or((other, other));
                    match (number(from), number(to)) {
                        (Some(from), Some(to)) if from <= to => Ok(Item::Numbers(from..=to)),
                        _ => Err(format!(
                            "{item:?} is no state: write numbers, ranges (3-5), first, middle, last or all"
                        )),
                    }
                }
            })
            .collect::<Result<Vec<Item>, String>>()
            .map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_states() {
        let show: Show = "0, 3-5,middle,LAST".parse().unwrap();
        let states = |range: std::ops::Range<u64>| range.collect::<Vec<u64>>();
        assert_eq!(show.among(&states(0..9)).unwrap(), [0..=0, 3..=5, 4..=4, 8..=8]);
        assert_eq!(show.among(&states(2..11)).unwrap_err(), "there is no state 0: they are 2 to 10");
        assert_eq!(show.among(&states(0..5)).unwrap_err(), "there is no state 5: they are 0 to 4");
        // Numbers of a file, with gaps.
        let show: Show = "10-40,middle,last".parse().unwrap();
        assert_eq!(show.among(&[10, 20, 40, 70]).unwrap(), [10..=40, 20..=20, 70..=70]);
        assert_eq!(show.among(&[10, 20, 70]).unwrap_err(), "there is no state 40: they are 10 to 70");
        for wrong in ["", "1,", "5-3", "x", "-1"] {
            assert!(wrong.parse::<Show>().is_err(), "{wrong}");
        }
    }
}
