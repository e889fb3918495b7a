//! Histograms over powers of two: a bin is the exponent of a number, which no rounding and no logarithm decides.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// The exponents that are told apart: what is below or above them is counted in the first or last one.
pub const LEAST: i32 = -64;
/// The last of them.
pub const MOST: i32 = 63;
const COUNT: usize = (MOST - LEAST + 1) as usize;

/// ⌊log₂ |x|⌋ between [`LEAST`], of zero too, and [`MOST`], of what is no number too.
pub const fn exponent(x: f64) -> i32 {
    let exponent = ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    match exponent {
        ..=LEAST => LEAST,
        MOST.. => MOST,
        _ => exponent,
    }
}

/// How many numbers had which exponent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bins([u64; COUNT]);

impl Default for Bins {
    fn default() -> Self {
        Self([0; COUNT])
    }
}

impl Bins {
    /// Counts a number.
    pub fn add(&mut self, x: f64) {
        if let Some(count) = self.0.get_mut((exponent(x) - LEAST) as usize) {
            *count += 1;
        }
    }

    /// Adds the counts of another.
    pub fn merge(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(count, more)| *count += more);
    }

    /// Exponents with their counts, but for those that nothing had.
    pub fn iter(&self) -> impl Iterator<Item = (i32, u64)> + '_ {
        (LEAST..).zip(self.0).filter(|(_, count)| *count > 0)
    }
}

impl Serialize for Bins {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.iter())
    }
}

impl<'de> Deserialize<'de> for Bins {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let mut bins = Self::default();
        for (exponent, count) in BTreeMap::<i32, u64>::deserialize(from)? {
            let place = usize::try_from(exponent.wrapping_sub(LEAST)).ok();
            let bin = place.and_then(|place| bins.0.get_mut(place));
            *bin.ok_or_else(|| D::Error::custom(format!("{exponent} is no exponent of a bin")))? = count;
        }
        Ok(bins)
    }
}

/// How many states had which exponents of two numbers, the first by the second.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Map(BTreeMap<i32, BTreeMap<i32, u64>>);

impl Map {
    /// Counts a pair.
    pub fn add(&mut self, [first, second]: [f64; 2]) {
        *self.0.entry(exponent(first)).or_default().entry(exponent(second)).or_default() += 1;
    }

    /// Adds the counts of another.
    pub fn merge(&mut self, other: &Self) {
        for (first, row) in &other.0 {
            let own = self.0.entry(*first).or_default();
            row.iter().for_each(|(second, count)| *own.entry(*second).or_default() += count);
        }
    }

    /// Both exponents and their counts.
    pub fn iter(&self) -> impl Iterator<Item = ([i32; 2], u64)> + '_ {
        self.0
            .iter()
            .flat_map(|(first, row)| row.iter().map(move |(second, count)| ([*first, *second], *count)))
    }
}

#[cfg(test)]
mod tests {
    use super::{Bins, LEAST, MOST, exponent};

    #[test]
    fn bins_are_exponents() {
        let cases =
            [(1.0, 0), (1.99, 0), (2.0, 1), (-0.3, -2), (0.0, LEAST), (1e-300, LEAST), (f64::NAN, MOST)];
        let mut bins = Bins::default();
        for (x, of) in cases {
            assert_eq!(exponent(x), of, "{x}");
            bins.add(x);
        }
        let text = serde_json::to_string(&bins).unwrap();
        assert_eq!(text, r#"{"-64":2,"-2":1,"0":2,"1":1,"63":1}"#);
        assert_eq!(serde_json::from_str::<Bins>(&text).unwrap(), bins);
        assert!(serde_json::from_str::<Bins>(r#"{"64":1}"#).is_err());
    }
}
