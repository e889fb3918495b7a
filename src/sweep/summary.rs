//! What is known of many states in the end: it merges exactly, in any order.

use crate::SweepError;
use crate::bins::{Bins, Map};
use crate::plan::sha256;
use crate::ranges::Ranges;
use crate::states::Place;
use pintle_audit::{Finding, Verdict};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// The form of a summary.
pub const SCHEMA: &str = "pintle-sweep/2";

/// How many of the worst states are kept of each subject and quantity.
pub const WORST: usize = 4;

/// Bytes in hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let digit = |nibble: u8| char::from(DIGITS[usize::from(nibble & 15)]);
    bytes.iter().flat_map(|byte| [digit(byte >> 4), digit(*byte)]).collect()
}

/// A double, written as its bits: infinite ones, and those that are no number, are written too.
#[derive(Clone, Copy, Debug)]
pub struct Bits(pub f64);

impl PartialEq for Bits {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits()
    }
}

impl Serialize for Bits {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&format!("{:016x}", self.0.to_bits()))
    }
}

impl<'de> Deserialize<'de> for Bits {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        let bits = u64::from_str_radix(&text, 16).map_err(serde::de::Error::custom)?;
        Ok(Self(f64::from_bits(bits)))
    }
}

/// The largest of many numbers, and the first state that has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Largest {
    /// The number.
    pub value: Bits,
    /// The index of the state.
    pub index: u64,
}

impl Largest {
    fn beats(self, other: Self) -> bool {
        self.value.0.total_cmp(&other.value.0).then(other.index.cmp(&self.index)).is_gt()
    }

    /// The larger one, of equal ones the first.
    pub fn of(known: Option<Self>, other: Option<Self>) -> Option<Self> {
        match (known, other) {
            (Some(a), Some(b)) => Some(if b.beats(a) { b } else { a }),
            (a, b) => a.or(b),
        }
    }
}

/// How far a law was from holding, in roundings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OfLaw {
    /// The states of which it was asked.
    pub states: u64,
    /// These by the exponent of what was left.
    pub left: Bins,
    /// The largest of that; none where nothing was asked.
    pub largest: Option<Largest>,
    /// The states at which more was left than may be.
    pub beyond: u64,
}

impl OfLaw {
    /// Adds a state; whether the law holds there.
    pub fn add(&mut self, left: f64, most: f64, index: u64) -> bool {
        self.states += 1;
        self.left.add(left);
        self.largest = Largest::of(self.largest, Some(Largest { value: Bits(left), index }));
        let holds = left <= most;
        self.beyond += u64::from(!holds);
        holds
    }

    fn merge(&mut self, other: &Self) {
        self.states += other.states;
        self.left.merge(&other.left);
        self.largest = Largest::of(self.largest, other.largest);
        self.beyond += other.beyond;
    }
}

/// A state that is among the worst.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// The error in units of the bound.
    pub units: Bits,
    /// The index of the state.
    pub index: u64,
    /// The verdict.
    pub verdict: Verdict,
    /// The entry.
    pub entry: String,
    /// What was given.
    pub got: Bits,
    /// What it must be.
    pub want: Bits,
    /// How far apart they may be.
    pub tolerance: Bits,
}

impl Worst {
    /// From what the audit found at a state.
    pub fn new(index: u64, verdict: Verdict, finding: &Finding) -> Self {
        Self {
            units: Bits(finding.units),
            index,
            verdict,
            entry: finding.entry.clone(),
            got: Bits(finding.got),
            want: Bits(finding.want),
            tolerance: Bits(finding.tolerance),
        }
    }

    fn as_largest(&self) -> Largest {
        Largest { value: self.units, index: self.index }
    }
}

/// What 237 bits said of one quantity.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OfQuantity {
    /// The states by verdict.
    pub verdicts: BTreeMap<Verdict, u64>,
    /// The entries compared.
    pub compared: u64,
    /// The states by the exponents of their distance to the nearest singular set and of their error in units of the bound.
    pub map: Map,
    /// The worst states, the worst first.
    pub worst: Vec<Worst>,
}

impl OfQuantity {
    /// Adds a state at that distance from its singular sets.
    pub fn add(&mut self, nearness: f64, measured: &pintle_audit::Measured, index: u64) {
        let verdict = measured.verdict;
        *self.verdicts.entry(verdict).or_default() += 1;
        self.compared += measured.compared;
        let Some(finding) = &measured.worst else { return };
        // On a kink or at a singular point there is nothing that an error could be of.
        if matches!(verdict, Verdict::Pass | Verdict::IllConditioned) || verdict.is_mismatch() {
            self.map.add([nearness, finding.units]);
            self.keep(Worst::new(index, verdict, finding));
        }
    }

    fn keep(&mut self, one: Worst) {
        let is_kept = self.worst.len() < WORST
            || self.worst.last().is_some_and(|last| one.as_largest().beats(last.as_largest()));
        if is_kept {
            let at = self.worst.partition_point(|known| known.as_largest().beats(one.as_largest()));
            self.worst.insert(at, one);
            self.worst.truncate(WORST);
        }
    }

    fn merge(&mut self, other: &Self) {
        for (verdict, count) in &other.verdicts {
            *self.verdicts.entry(*verdict).or_default() += count;
        }
        self.compared += other.compared;
        self.map.merge(&other.map);
        other.worst.iter().for_each(|one| self.keep(one.clone()));
    }
}

/// What is known of one subject.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OfSubject {
    /// Its name.
    pub name: String,
    /// The states by where they lie.
    pub places: BTreeMap<Place, u64>,
    /// The numbers computed of them, values and entries of rows.
    pub numbers: u64,
    /// The states with a number that is not finite, and the first of them.
    pub not_finite: u64,
    /// The first of them.
    pub first_not_finite: Option<u64>,
    /// The states by the exponent of sin²(θ/2), θ the angle by which b is turned against a.
    pub turned: Bins,
    /// The states by the exponent of |d|², in lengths of the connector.
    pub apart: Bins,
    /// What is left of rows along rigid motions, in roundings of what is added up: at most [`crate::sweep::RIGID`].
    pub rigid: OfLaw,
    /// What turning both nodes as one changes, in roundings of the audit's scale: at most [`crate::sweep::FRAME`].
    pub frame: OfLaw,
    /// The states judged on 237 bits.
    pub judged: u64,
    /// What was said of their values.
    pub value: OfQuantity,
    /// What was said of their rows.
    pub row: OfQuantity,
    /// The states at which anything is wrong, each counted once.
    pub wrong: u64,
    /// The first state at which a number of a routine is wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_wrong: Option<u64>,
    /// The states outside the domain of a routine. Of these and the next two nothing else is known.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub outside: u64,
    /// The states at which a routine gives other angles of the same rotation.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub elsewhere: u64,
    /// The states on a singular set, not a removable one, at which a routine gives what is no number.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub undefined: u64,
}

/// The smaller index.
pub(crate) fn first(known: Option<u64>, other: Option<u64>) -> Option<u64> {
    known.zip(other).map(|(a, b)| a.min(b)).or(known).or(other)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde gives a reference")]
const fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl OfSubject {
    fn merge(&mut self, other: &Self) {
        for (place, count) in &other.places {
            *self.places.entry(*place).or_default() += count;
        }
        self.numbers += other.numbers;
        self.not_finite += other.not_finite;
        self.first_not_finite = first(self.first_not_finite, other.first_not_finite);
        self.first_wrong = first(self.first_wrong, other.first_wrong);
        self.turned.merge(&other.turned);
        self.apart.merge(&other.apart);
        self.rigid.merge(&other.rigid);
        self.frame.merge(&other.frame);
        self.judged += other.judged;
        self.value.merge(&other.value);
        self.row.merge(&other.row);
        self.wrong += other.wrong;
        self.outside += other.outside;
        self.elsewhere += other.elsewhere;
        self.undefined += other.undefined;
    }

    /// The states of it.
    pub fn states(&self) -> u64 {
        self.places.values().sum()
    }
}

/// What is known of all states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Summary {
    /// [`SCHEMA`].
    pub schema: String,
    /// The SHA-256 of the text of the plan.
    pub plan: String,
    /// The vector unit on which numbers were computed: others round otherwise.
    pub arithmetic: String,
    /// The indices of the states.
    pub states: Ranges,
    /// The sum, modulo 2⁶⁴, of a hash of all bits of all numbers of each state.
    #[serde(with = "as_hex")]
    pub fingerprint: u64,
    /// By subject.
    pub subjects: Vec<OfSubject>,
}

/// A number of 64 bits as hexadecimal digits: JSON has no such integers everywhere.
mod as_hex {
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(number: &u64, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&format!("{number:016x}"))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<u64, D::Error> {
        let text = String::deserialize(from)?;
        u64::from_str_radix(&text, 16).map_err(serde::de::Error::custom)
    }
}

impl Summary {
    /// Of no state.
    pub fn empty(plan: &str, arithmetic: &str, names: impl Iterator<Item = String>) -> Self {
        Self {
            schema: SCHEMA.into(),
            plan: plan.into(),
            arithmetic: arithmetic.into(),
            states: Ranges::default(),
            fingerprint: 0,
            subjects: names.map(|name| OfSubject { name, ..OfSubject::default() }).collect(),
        }
    }

    /// Adds what is known of other states.
    ///
    /// # Errors
    /// Summaries of different plans, of numbers that were rounded otherwise, or of one state twice.
    pub fn merge(&mut self, other: &Self) -> Result<(), SweepError> {
        let refused = |what: String| Err(SweepError::Merge(what));
        if self.plan != other.plan || self.subjects.len() != other.subjects.len() {
            return refused(
                "two summaries are of different plans: sweep each into a folder of its own".into(),
            );
        }
        if self.arithmetic != other.arithmetic {
            return refused(format!(
                "two summaries were computed on {} and on {}, which round otherwise: sweep on processors of one kind",
                self.arithmetic, other.arithmetic
            ));
        }
        if let Some(index) = self.states.overlap(&other.states) {
            return refused(format!("state {index} is in two summaries: delete the file of one of them"));
        }
        self.states.add(&other.states);
        self.fingerprint = self.fingerprint.wrapping_add(other.fingerprint);
        self.subjects.iter_mut().zip(&other.subjects).for_each(|(own, other)| own.merge(other));
        Ok(())
    }

    /// Whether its subjects have as many states as it has.
    pub fn is_whole(&self) -> bool {
        let states = self.subjects.iter().try_fold(0_u64, |sum, of| {
            of.places.values().try_fold(sum, |sum, count| sum.checked_add(*count))
        });
        states == Some(self.states.count())
    }

    /// As its one text.
    ///
    /// # Errors
    /// Never: every number of it is an integer.
    pub fn text(&self) -> Result<String, SweepError> {
        serde_json::to_string(self).map_err(|error| SweepError::Merge(error.to_string()))
    }

    /// The SHA-256 of its text.
    ///
    /// # Errors
    /// As [`Summary::text`].
    pub fn digest(&self) -> Result<String, SweepError> {
        Ok(sha256(&self.text()?))
    }

    /// The number of states at which something is wrong.
    pub fn wrong(&self) -> u64 {
        self.subjects.iter().map(|of| of.wrong).sum()
    }
}
