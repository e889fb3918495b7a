//! Why is it wrong? Wrong numbers are matched against what known mistakes make of the right ones: those of the self-test
//! ([`super::mutant`]) and changes of convention.
//!
//! A mistake *fits* where every entry that it makes is the one given, within the tolerance. One that fits is believed where chance
//! would not do it: an entry off by n tolerances is met by chance once in n, so that it is worth log₂ n bits, and all entries
//! explained must be worth log₂(1000 N) bits together, N being the number of mistakes tried. A mistake explains more than another
//! where the entries that only it explains are worth log₂ 1000 bits; those that explain as much are named beside it, for at this
//! state they make the same numbers. Where nothing is believed, that is said. Numbers that have lost digits besides are tried
//! again with tolerances so much wider.

use super::bound::Bound;
use super::case::Case;
use super::mutant::{Changes, Mistake, Scene, mutants};
use super::quantity::{Entries, Numbers, Quantity};
use crate::catalog::COMPONENT;
use crate::measure::Unit;
use crate::node::{self, DOF, DOFS};
use crate::scene::Code;
use crate::vector::{apply, cross};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

macro_rules! causes {
    ($($variant:ident = $code:ident, $relation:literal, $meaning:literal;)+) => {
        /// What makes wrong numbers of right ones. Where two make the same, the first is named first.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Cause {
            $(#[doc = concat!("The numbers equal ", $relation, ": ", $meaning, ".")] $variant,)+
        }

        impl Cause {
            /// The code, which `pintle explain` explains.
            pub const fn code(self) -> Code {
                match self { $(Self::$variant => Code::$code),+ }
            }

            /// What the numbers equal.
            const fn relation(self) -> &'static str {
                match self { $(Self::$variant => $relation),+ }
            }

            /// What that means.
            const fn meaning(self) -> &'static str {
                match self { $(Self::$variant => $meaning),+ }
            }
        }
    };
}

causes! {
    NodesSwapped = DiagnosisNodesSwapped, "what is expected with a and b exchanged", "nodes swapped";
    RowsSwapped = DiagnosisComponentsSwapped, "what is expected of each other", "components swapped";
    Reversed = DiagnosisSign, "minus what is expected", "opposite sign convention";
    SameSignForBoth = DiagnosisSignOfA, "minus what is expected", "sign of node a";
    RotationTakenAsLocal = DiagnosisRotationAsLocal, "Rᵀ × expected", "rotation degrees of freedom taken as local";
    RotationTurnedTwice = DiagnosisRotationTurnedTwice, "R × expected", "rotation degrees of freedom turned forth instead of back";
    BlockTransposed = DiagnosisBlockTransposed, "the transpose of what is expected", "block transposed";
    DegreesForRadians = DiagnosisDegrees, "what is expected × 180/π or × π/180", "degrees for radians";
    RotationHalved = DiagnosisRotationHalved, "half of what is expected", "rotation block halved";
    RotationDoubled = DiagnosisRotationDoubled, "twice what is expected", "rotation block doubled";
    GeometricTermMissing = DiagnosisGeometricTerm, "what is expected without the term of the lever d × δθ", "geometric term missing";
    LeverReversed = DiagnosisLeverReversed, "what is expected with minus the term of the lever d × δθ", "geometric term with the wrong sign";
    BracketKept = DiagnosisNotSymmetrised, "the derivatives of the rows", "second derivatives not symmetrised by half the bracket";
    ColumnsSwapped = DiagnosisColumnsSwapped, "what is expected of each other", "columns swapped";
    TurnForgotten = DiagnosisTurnsForgotten, "what is expected less whole turns", "previous turns forgotten";
    WrongParity = DiagnosisHalfTurn, "what is expected and half a turn", "nπ of the wrong parity";
    RatesOfAIgnored = DiagnosisRatesOfA, "what the rates of node b alone give", "rates of node a ignored";
    QuadraticPartMissing = DiagnosisQuadraticPart, "what the accelerations alone give", "the part quadratic in the rates missing";
    Dropped = DiagnosisDropped, "zero", "entry dropped";
    Sign = DiagnosisSignOfEntry, "minus what is expected", "sign of an entry";
    Spurious = DiagnosisSpurious, "what must be zero", "entry that must be zero";
    Scaled = DiagnosisScaled, "what is expected times a factor", "entry scaled";
}

impl Cause {
    /// The cause that a mistake of the self-test is; `None` for those that are not made in numbers of components.
    pub const fn of(mistake: Mistake) -> Option<Self> {
        Some(match mistake {
            Mistake::Dropped => Self::Dropped,
            Mistake::Sign => Self::Sign,
            Mistake::Spurious => Self::Spurious,
            Mistake::Scaled(_) => Self::Scaled,
            Mistake::RowsSwapped => Self::RowsSwapped,
            Mistake::ColumnsSwapped => Self::ColumnsSwapped,
            Mistake::BlockTransposed => Self::BlockTransposed,
            Mistake::RotationTakenAsLocal => Self::RotationTakenAsLocal,
            Mistake::NodesSwapped => Self::NodesSwapped,
            Mistake::SameSignForBoth => Self::SameSignForBoth,
            Mistake::RotationHalved => Self::RotationHalved,
            Mistake::DegreesForRadians => Self::DegreesForRadians,
            Mistake::GeometricTermMissing => Self::GeometricTermMissing,
            Mistake::BracketKept => Self::BracketKept,
            Mistake::WrongParity => Self::WrongParity,
            Mistake::TurnForgotten => Self::TurnForgotten,
            Mistake::RatesOfAIgnored => Self::RatesOfAIgnored,
            Mistake::QuadraticPartMissing => Self::QuadraticPartMissing,
            Mistake::NumberLeftOut
            | Mistake::MultipliedInsteadOfDivided
            | Mistake::StickForSlip
            | Mistake::CouplingMissing => return None,
        })
    }

    /// By how much rounding of what is expected grows in it.
    fn gain(self) -> f64 {
        match self {
            Self::DegreesForRadians => 1.0_f64.to_degrees(),
            Self::RotationDoubled | Self::LeverReversed => 2.0,
            _ => 1.0,
        }
    }

    /// Whether it says something of single entries only.
    const fn is_of_an_entry(self) -> bool {
        matches!(self, Self::Dropped | Self::Sign | Self::Spurious | Self::Scaled)
    }
}

/// One mistake that explains wrong entries.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Explained {
    /// The mistake.
    #[serde(skip)]
    pub cause: Cause,
    /// Its code.
    #[schemars(with = "String")]
    pub code: Code,
    /// What equals what, and what that means.
    pub sentence: String,
    /// Others that make the same numbers at this state.
    #[schemars(with = "Vec<String>")]
    pub also: Vec<Code>,
}

/// Why numbers are wrong.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Diagnosis {
    /// The mistakes that explain wrong entries, the one that explains most first.
    pub causes: Vec<Explained>,
    /// Wrong entries that no known mistake explains.
    pub unexplained: usize,
}

impl Diagnosis {
    /// One line for each mistake, and one for what nothing explains, with codes.
    pub fn lines(&self) -> Vec<(String, Code)> {
        let mut lines: Vec<(String, Code)> =
            self.causes.iter().map(|found| (found.said(), found.code)).collect();
        if self.unexplained > 0 {
            let besides = if self.causes.is_empty() { "" } else { " besides" };
            let entries = match self.unexplained {
                1 => "1 wrong entry".to_string(),
                n => format!("{n} wrong entries"),
            };
            lines.push((format!("no known mistake explains {entries}{besides}"), Code::DiagnosisUnknown));
        }
        lines
    }

    /// Whether it says more than another about the same check: all is explained, by fewer mistakes, with fewer alternatives.
    pub(super) fn is_clearer_than(&self, other: &Self) -> bool {
        let rank = |one: &Self| {
            let also: usize = one.causes.iter().map(|found| found.also.len()).sum();
            (one.causes.is_empty(), one.unexplained > 0, one.causes.len(), also)
        };
        rank(self) < rank(other)
    }
}

impl Explained {
    fn said(&self) -> String {
        if self.also.is_empty() {
            return self.sentence.clone();
        }
        let others: Vec<&str> = self.also.iter().map(|code| code.as_str()).collect();
        format!("{} (at this state the same as {})", self.sentence, others.join(", "))
    }
}

/// What a mistake would make of the numbers.
struct Hypothesis {
    cause: Cause,
    changes: Changes,
}

/// Wrong numbers, and what they must be.
pub struct Symptoms<'a> {
    /// What they are.
    pub quantity: Quantity,
    /// The numbers given.
    pub got: &'a Entries<f64>,
    /// Everything as it must be.
    pub want: &'a Numbers<f64>,
    /// The case at whose end they are.
    pub case: &'a Case,
    /// The tolerances.
    pub bound: &'a Bound,
}

/// Chance may not do it more often than once in so many.
const CHANCE: f64 = 1000.0;

/// How much wider tolerances are tried for numbers that have lost digits.
const LOST: [f64; 4] = [1.0, 1e2, 1e4, 1e6];

/// Single entries without structure that are named one by one.
const SINGLE: usize = 2;

/// Why numbers are wrong; `None` where none is.
pub fn diagnose(symptoms: &Symptoms<'_>) -> Option<Diagnosis> {
    let hypotheses = symptoms.hypotheses();
    let first = symptoms.explain(&hypotheses, LOST[0])?;
    if first.unexplained == 0 {
        return Some(first);
    }
    let wider = LOST[1..].iter().filter_map(|wider| symptoms.explain(&hypotheses, *wider));
    let whole = wider.into_iter().find(|found| found.unexplained == 0 && !found.causes.is_empty());
    Some(whole.unwrap_or(first))
}

/// The class of an entry: numbers of one class have one unit.
fn class(quantity: Quantity, k: usize, i: usize) -> (usize, usize, usize) {
    let kind = |j: usize| match j % (DOFS / 2) {
        0..=2 => 0,
        3..=5 => 1,
        _ => 2,
    };
    match quantity {
        Quantity::FirstDerivatives | Quantity::NodalForces => (k / 3, kind(i), 0),
        Quantity::SecondDerivatives | Quantity::GeometricStiffness => {
            let [x, y] = [kind(i / DOFS), kind(i % DOFS)];
            (k / 3, x.min(y), x.max(y))
        }
        _ => (k / 3, 0, 0),
    }
}

impl Symptoms<'_> {
    fn wanted(&self) -> &Entries<f64> {
        self.want.entries(self.quantity)
    }

    fn tolerance(&self, k: usize, i: usize) -> f64 {
        self.bound.tolerance(self.quantity, k, i)
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        let connector = self.case.connector();
        let units: [Option<Unit>; 6] = std::array::from_fn(|k| connector.differentiated(k).map(|m| m.unit()));
        let turns = self.case.last().map(|step| {
            let before = self.case.branch_before(&connector);
            connector.advance(&step.state, &step.increment, &before).turns.map(|turns| turns.turns)
        });
        let scale = |k: usize, i: usize| self.bound.scale(self.quantity, k, i);
        let scene = Scene {
            numbers: self.want,
            case: self.case,
            units,
            turns: turns.unwrap_or_default(),
            scale: &scale,
        };
        let made = mutants(self.quantity, &scene).into_iter();
        let made = made.filter_map(|mutant| {
            Some(Hypothesis { cause: Cause::of(mutant.mistake)?, changes: mutant.changes })
        });
        let mut found: Vec<Hypothesis> = made.filter(|made| !made.cause.is_of_an_entry()).collect();
        for (k, entries) in self.wanted().0.iter().enumerate() {
            let Some(entries) = entries else { continue };
            let changes: Vec<_> = entries.iter().enumerate().map(|(i, x)| (k, i, -x)).collect();
            found.push(Hypothesis { cause: Cause::Reversed, changes: changes.into() });
            if matches!(self.quantity, Quantity::FirstDerivatives | Quantity::NodalForces) {
                found.extend(self.conventions(k, entries));
            }
        }
        for (k, i, x) in self.wanted().iter().filter(|(_, _, x)| *x != 0.0) {
            found.push(Hypothesis { cause: Cause::Dropped, changes: Changes::One([(k, i, 0.0)]) });
            found.push(Hypothesis { cause: Cause::Sign, changes: Changes::One([(k, i, -x)]) });
        }
        found
    }

    /// Changes of convention of a row that are no mistakes of the self-test.
    fn conventions(&self, k: usize, row: &[f64]) -> Vec<Hypothesis> {
        let Some(pair) = self.case.last().map(|step| &step.state.pair) else { return Vec::new() };
        let part = |at: usize| [0, 1, 2].map(|i| row.get(at + i).copied().unwrap_or(0.0));
        let put = |cause: Cause, at: usize, block: [f64; 3]| Hypothesis {
            cause,
            changes: Changes::Many(block.into_iter().enumerate().map(|(i, x)| (k, at + i, x)).collect()),
        };
        let mut found = Vec::new();
        for (at, triad) in [(node::THETA_A, &pair.a.triad), (node::THETA_B, &pair.b.triad)] {
            let block = part(at);
            found.push(put(Cause::RotationTurnedTwice, at, apply(triad, block)));
            found.push(put(Cause::RotationDoubled, at, block.map(|x| 2.0 * x)));
        }
        let lever = cross(part(node::XB), pair.separation());
        let block = part(node::THETA_A);
        found.push(put(Cause::LeverReversed, node::THETA_A, [0, 1, 2].map(|i| block[i] - 2.0 * lever[i])));
        found
    }

    /// The mistakes that explain what is wrong, with tolerances `wider` times as wide; `None` where nothing is wrong.
    fn explain(&self, hypotheses: &[Hypothesis], wider: f64) -> Option<Diagnosis> {
        let mut class_tolerance: BTreeMap<(usize, usize, usize), f64> = BTreeMap::new();
        for (k, i, _) in self.wanted().iter() {
            let most = class_tolerance.entry(class(self.quantity, k, i)).or_default();
            *most = most.max(self.tolerance(k, i));
        }
        // What is given has the rounding of the right numbers once more: they are compared with rounded ones.
        let allowed = |k: usize, i: usize, cause: Cause| {
            let class = class_tolerance.get(&class(self.quantity, k, i)).copied().unwrap_or(0.0);
            2.0 * wider * cause.gain() * class
        };
        // Bits that each wrong entry is worth.
        let mut wrong: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        for (k, i, want) in self.wanted().iter() {
            let Some(got) = self.got.get(k, i) else { continue };
            let error = (got - want).abs();
            let tolerance = wider * self.tolerance(k, i);
            let is_wrong = error.is_nan() || error > tolerance;
            if is_wrong {
                wrong.insert((k, i), (error / tolerance).log2().clamp(0.0, f64::from(f64::MANTISSA_DIGITS)));
            }
        }
        if wrong.is_empty() {
            return None;
        }
        let fits = |hypothesis: &&Hypothesis| {
            let explains = hypothesis.changes.iter().any(|(k, i, _)| wrong.contains_key(&(*k, *i)));
            explains
                && hypothesis.changes.iter().all(|(k, i, x)| {
                    self.got
                        .get(*k, *i)
                        .is_some_and(|got| (got - x).abs() <= allowed(*k, *i, hypothesis.cause))
                })
        };
        let fitting: Vec<&Hypothesis> = hypotheses.iter().filter(fits).collect();
        let mut found = Diagnosis::default();
        let enough = (CHANCE * hypotheses.len().max(1) as f64).log2();
        while !wrong.is_empty() {
            let Some(explained) = self.best(&fitting, &mut wrong, enough) else { break };
            found.causes.push(explained);
        }
        if wrong.len() <= SINGLE {
            for (k, i) in std::mem::take(&mut wrong).into_keys() {
                found.causes.push(self.single(k, i));
            }
        }
        found.unexplained = wrong.len();
        Some(found)
    }

    /// The mistake that explains most of what is wrong, which is then explained.
    fn best(
        &self,
        fitting: &[&Hypothesis],
        wrong: &mut BTreeMap<(usize, usize), f64>,
        enough: f64,
    ) -> Option<Explained> {
        #[derive(Default)]
        struct Explains {
            entries: BTreeSet<(usize, usize)>,
            region: BTreeSet<(usize, usize)>,
            times: usize,
        }
        let mut by_cause: BTreeMap<Cause, Explains> = BTreeMap::new();
        for hypothesis in fitting {
            let places = || hypothesis.changes.iter().map(|(k, i, _)| (*k, *i));
            if !places().any(|place| wrong.contains_key(&place)) {
                continue;
            }
            let explains = by_cause.entry(hypothesis.cause).or_default();
            explains.times += 1;
            explains.entries.extend(places().filter(|place| wrong.contains_key(place)));
            explains.region.extend(places());
        }
        let bits = |entries: &BTreeSet<(usize, usize)>| -> f64 {
            entries.iter().filter_map(|place| wrong.get(place)).sum()
        };
        let most = by_cause.values().map(|explains| bits(&explains.entries)).fold(0.0, f64::max);
        if most < enough {
            return None;
        }
        let contenders =
            by_cause.iter().filter(|(_, explains)| bits(&explains.entries) > most - CHANCE.log2());
        let contenders: BTreeSet<(usize, Cause)> =
            contenders.map(|(cause, explains)| (explains.times, *cause)).collect();
        let (_, cause) = *contenders.first()?;
        let explains = by_cause.get(&cause)?;
        let also: Vec<Code> = contenders.iter().skip(1).map(|(_, other)| other.code()).collect();
        let place = self.place(cause, &explains.entries, &explains.region);
        wrong.retain(|place, _| !explains.entries.contains(place));
        let relation = match cause {
            Cause::RotationTakenAsLocal | Cause::RotationTurnedTwice => {
                let has = |at: usize| explains.region.iter().any(|(_, j)| (at..at + 3).contains(j));
                let triad = match (has(node::THETA_A), has(node::THETA_B)) {
                    (true, true) => "",
                    (true, false) => "A",
                    _ => "B",
                };
                match (triad, cause) {
                    ("", Cause::RotationTakenAsLocal) => "Aᵀ and Bᵀ × expected".to_string(),
                    ("", _) => "A and B × expected".to_string(),
                    (triad, _) => cause.relation().replace('R', triad),
                }
            }
            _ => cause.relation().to_string(),
        };
        let equals = if place.contains(", ") { "equal" } else { "equals" };
        let sentence = format!("{place} {equals} {relation}: {}", cause.meaning());
        Some(Explained { cause, code: cause.code(), sentence, also })
    }

    /// An entry that is wrong by itself.
    fn single(&self, k: usize, i: usize) -> Explained {
        let name = self.quantity.entry_name(k, i);
        let (got, want) =
            (self.got.get(k, i).unwrap_or(f64::NAN), self.wanted().get(k, i).unwrap_or(f64::NAN));
        let cause = if want.abs() <= self.tolerance(k, i) { Cause::Spurious } else { Cause::Scaled };
        let sentence = match cause {
            Cause::Spurious => format!("{name} equals {got:.3e}, and must be zero"),
            _ => format!("{name} equals {:.10} × expected: {}", got / want, cause.meaning()),
        };
        Explained { cause, code: cause.code(), sentence, also: Vec::new() }
    }

    /// The entries in words: `∂ur1/∂θa1..3`; of single entries only those that are wrong.
    fn place(
        &self,
        cause: Cause,
        entries: &BTreeSet<(usize, usize)>,
        region: &BTreeSet<(usize, usize)>,
    ) -> String {
        let shown = if cause.is_of_an_entry() { entries } else { region };
        let rows: BTreeSet<usize> = shown.iter().map(|(k, _)| *k).collect();
        let rows: Vec<&str> = rows.into_iter().filter_map(|k| COMPONENT.get(k).copied()).collect();
        let each = |prefix: &str, suffix: &str| {
            let named: Vec<String> = rows.iter().map(|row| format!("{prefix}{row}{suffix}")).collect();
            named.join(", ")
        };
        match self.quantity {
            _ if shown.len() == 1 => shown.iter().map(|(k, i)| self.quantity.entry_name(*k, *i)).collect(),
            Quantity::Rate => each("d", "/dt"),
            Quantity::Acceleration => each("d²", "/dt²"),
            Quantity::SecondDerivatives => each("∂²", ""),
            Quantity::NodalForces => each("the nodal forces of ", &columns(shown, " on ", " and ")),
            Quantity::GeometricStiffness => each("the geometric stiffness of ", ""),
            Quantity::FirstDerivatives => each("∂", &columns(shown, "/∂", " and ∂")),
            _ => rows.join(", "),
        }
    }
}

/// The columns of entries in words, after a prefix; nothing where they are all columns.
fn columns(shown: &BTreeSet<(usize, usize)>, prefix: &str, and: &str) -> String {
    let columns: BTreeSet<usize> = shown.iter().map(|(_, j)| *j).collect();
    // A connector need not have both flows.
    if columns.len() >= DOFS - 2 { String::new() } else { format!("{prefix}{}", ranges(&columns).join(and)) }
}

/// Columns in words: `θa1..3`, `xb2`.
fn ranges(columns: &BTreeSet<usize>) -> Vec<String> {
    let half = DOFS / 2;
    let blocks = [0, 3, 6, half, half + 3, half + 6];
    let mut found = Vec::new();
    for (n, first) in blocks.iter().enumerate() {
        let end = blocks.get(n + 1).copied().unwrap_or(DOFS);
        let inside: Vec<usize> = columns.range(*first..end).copied().collect();
        match inside.as_slice() {
            [] => {}
            [start, .., last] if last - start + 1 == inside.len() => {
                let number = last - first + 1;
                found.push(format!("{}..{number}", DOF[*start]));
            }
            _ => found.extend(inside.iter().map(|j| DOF[*j].to_string())),
        }
    }
    found
}
