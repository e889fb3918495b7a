//! Judging numbers against an answer: which entry, by how much, and how small an error would have been seen.

use super::bound::Bound;
use super::diagnosis::Cause;
use super::mutant::{Mistake, Mutant};
use super::oracle::Answer;
use super::quantity::{Entries, Quantity};
use crate::scalar::Wide;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What is said of a quantity at a state, the mildest first.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Every entry is right to rounding.
    Pass,
    /// Every entry is as right as the state allows, which is not much: the point is ill-conditioned.
    IllConditioned,
    /// There is no derivative here, only one-sided ones.
    Kink,
    /// No independent oracle could answer.
    Undecided,
    /// The formula is right and loses digits on doubles.
    UnstableFormula,
    /// An entry is wrong.
    Wrong,
    /// A number is infinite or not a number.
    Invalid,
}

impl Verdict {
    /// Every verdict.
    pub const ALL: [Self; 7] = [
        Self::Pass,
        Self::IllConditioned,
        Self::Kink,
        Self::Undecided,
        Self::UnstableFormula,
        Self::Wrong,
        Self::Invalid,
    ];

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::IllConditioned => "ill-conditioned point",
            Self::Kink => "kink",
            Self::Undecided => "undecided",
            Self::UnstableFormula => "unstable formula",
            Self::Wrong => "wrong",
            Self::Invalid => "invalid",
        }
    }

    /// The verdict as a headline: a state that is ill-conditioned passes.
    pub const fn headline(self) -> Self {
        if matches!(self, Self::IllConditioned) { Self::Pass } else { self }
    }

    /// Whether it is a verified mismatch.
    pub const fn is_mismatch(self) -> bool {
        matches!(self, Self::UnstableFormula | Self::Wrong | Self::Invalid)
    }
}

/// One entry, what it is and what it must be.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Finding {
    /// The entry by name: `∂ur1/∂θb3`.
    pub entry: String,
    /// The component (0-based) and the place within it, where it is one entry of a connector's.
    #[serde(skip)]
    pub at: Option<(usize, usize)>,
    /// What was given.
    #[schemars(with = "Option<f64>")]
    pub got: f64,
    /// What it must be.
    #[schemars(with = "Option<f64>")]
    pub want: f64,
    /// How far apart they may be.
    #[schemars(with = "Option<f64>")]
    pub tolerance: f64,
    /// |got − want| in units of the tolerance.
    #[schemars(with = "Option<f64>")]
    pub units: f64,
    /// On a kink: the derivatives from below and from above.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[Option<f64>; 2]>")]
    pub one_sided: Option<[f64; 2]>,
}

/// The outcome of one comparison.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// The entry that decided it, or that came nearest to its tolerance.
    pub worst: Option<Finding>,
    /// How many entries were compared.
    pub compared: usize,
}

/// Beyond this fraction of a row's largest entry, a tolerance lets errors through that matter: the point is called
/// ill-conditioned.
pub(super) const COARSE: f64 = 1e-6;

/// How far the product's dual numbers over 237 bits may be from the truth, relative to the tolerance on doubles, and still
/// prove the formula right.
const EXACT: f64 = 1e-9;

/// An error larger than this, relative to the conditioned scale, is no loss of digits.
const LOST_DIGITS: f64 = 1e-4;

/// What surrounds a comparison.
pub struct Surroundings<'a> {
    /// The tolerances.
    pub bound: &'a Bound,
    /// The product's own source without rounding, where the numbers are the product's.
    pub exact: Option<&'a Entries<Wide>>,
    /// min(1, distance to the nearest singular set); 0 on it.
    pub nearness: f64,
    /// One-sided derivatives, for states on a singular set.
    pub one_sided: Option<[&'a Entries<Wide>; 2]>,
}

/// What a number must be, as the sum of two doubles: 106 bits, with which the error of a double is right to its own last digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    nearest: f64,
    rest: f64,
}

impl Wanted {
    /// A double that is taken for exact.
    pub const fn exactly(x: f64) -> Self {
        Self { nearest: x, rest: 0.0 }
    }

    /// The double that is nearest.
    pub const fn to_f64(self) -> f64 {
        self.nearest
    }

    /// |got − want|. Where the two are near each other got − nearest has no rounding; elsewhere the rest does not matter.
    pub fn error(self, got: f64) -> f64 {
        ((got - self.nearest) - self.rest).abs()
    }

    /// |got − want| in units of what is allowed; infinite where it is not a number.
    pub fn units(self, got: f64, allowed: f64) -> f64 {
        let error = self.error(got);
        if error == 0.0 {
            return 0.0;
        }
        let units = error / allowed;
        if units.is_nan() { f64::INFINITY } else { units }
    }
}

impl From<Wide> for Wanted {
    fn from(want: Wide) -> Self {
        let (nearest, rest) = want.split();
        Self { nearest, rest }
    }
}

/// |got − want| in units of what is allowed; infinite where it is not a number.
pub(super) fn units(got: f64, want: Wide, allowed: f64) -> f64 {
    Wanted::from(want).units(got, allowed)
}

/// Judges the entries of one quantity.
pub fn judge(
    quantity: Quantity,
    got: &Entries<f64>,
    answer: &Answer,
    around: &Surroundings<'_>,
) -> Judgement {
    // (units, component, entry) of the entry nearest to its tolerance, or farthest beyond.
    let mut farthest: Option<(f64, usize, usize)> = None;
    let mut compared = 0;
    let mut coarse = false;
    let mut is_finite = true;
    for (k, row) in got.0.iter().enumerate() {
        let (Some(row), Some(wanted)) = (row, &answer.numbers.0[k]) else { continue };
        let largest = row.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (i, (x, want)) in row.iter().zip(wanted).enumerate() {
            compared += 1;
            let allowed = answer.allowed(around.bound, quantity, k, i);
            let units = want.units(*x, allowed);
            coarse |= allowed > COARSE * largest && largest > 0.0 && quantity != Quantity::Value;
            is_finite = x.is_finite();
            if !is_finite || farthest.is_none_or(|(most, ..)| units > most) {
                farthest = Some((units, k, i));
            }
            if !is_finite {
                break;
            }
        }
        if !is_finite {
            break;
        }
    }
    let mut worst = farthest.and_then(|(units, k, i)| {
        Some(Finding {
            entry: quantity.entry_name(k, i),
            at: Some((k, i)),
            got: got.get(k, i)?,
            want: answer.numbers.get(k, i)?.to_f64(),
            tolerance: answer.allowed(around.bound, quantity, k, i),
            units,
            one_sided: None,
        })
    });
    if !is_finite {
        return Judgement { verdict: Verdict::Invalid, worst, compared };
    }
    if compared == 0 {
        return Judgement { verdict: Verdict::Undecided, worst: None, compared };
    }
    if let Some(kink) = kink(quantity, got, answer, around) {
        return Judgement { verdict: Verdict::Kink, worst: Some(kink), compared };
    }
    let beyond = worst.as_ref().is_some_and(|w| w.units > 1.0);
    let verdict = match (beyond, &mut worst) {
        (false, _) if coarse && answer.oracle.is_wide() => Verdict::IllConditioned,
        (true, Some(worst)) => why(quantity, worst, around),
        _ => Verdict::Pass,
    };
    Judgement { verdict, worst, compared }
}

/// On a singular set: the first derivative whose sides differ most, if they differ by more than rounding. The two-sided difference
/// is their mean there, which is no derivative, whoever agrees with it.
fn kink(
    quantity: Quantity,
    got: &Entries<f64>,
    answer: &Answer,
    around: &Surroundings<'_>,
) -> Option<Finding> {
    let [below, above] = around.one_sided?;
    if quantity != Quantity::FirstDerivatives || around.nearness > 0.0 {
        return None;
    }
    let mut most: Option<(f64, Finding)> = None;
    for (k, i, x) in got.iter() {
        let (Some(b), Some(a)) = (below.get(k, i), above.get(k, i)) else { continue };
        let tolerance = around.bound.tolerance(quantity, k, i);
        let gap = units(b.to_f64(), a, 2.0 * tolerance);
        if gap > 1.0 && most.as_ref().is_none_or(|(widest, _)| gap > *widest) {
            let want = answer.numbers.get(k, i).unwrap_or_else(|| a.into());
            let finding = Finding {
                entry: quantity.entry_name(k, i),
                at: Some((k, i)),
                got: x,
                want: want.to_f64(),
                tolerance,
                units: want.units(x, tolerance),
                one_sided: Some([b.to_f64(), a.to_f64()]),
            };
            most = Some((gap, finding));
        }
    }
    most.map(|(_, finding)| finding)
}

/// Why an entry is beyond its tolerance.
fn why(quantity: Quantity, worst: &mut Finding, around: &Surroundings<'_>) -> Verdict {
    let Some((k, i)) = worst.at else { return Verdict::Wrong };
    // Values exist on a kink, and first derivatives whose sides agree; what is formed from other derivatives may not.
    let exists = matches!(quantity, Quantity::Value | Quantity::FirstDerivatives);
    if around.nearness == 0.0 && !exists {
        return Verdict::Kink;
    }
    let scale = around.bound.scale(quantity, k, i);
    let error = (worst.got - worst.want).abs();
    let proven = around
        .exact
        .and_then(|exact| exact.get(k, i))
        .is_some_and(|exact| units(worst.want, exact, worst.tolerance.max(f64::MIN_POSITIVE)) < 1.0 + EXACT);
    if proven && error <= LOST_DIGITS * scale { Verdict::UnstableFormula } else { Verdict::Wrong }
}

/// How mutants with one kind of mistake fared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Fared {
    /// Noticed.
    pub killed: u64,
    /// Changed nothing.
    pub equivalent: u64,
    /// Changed less than twice what is allowed.
    pub below_resolution: u64,
    /// Not noticed, though the change exceeds twice what is allowed.
    pub survived: u64,
}

impl Fared {
    /// Adds others.
    pub const fn add(&mut self, other: Self) {
        self.killed += other.killed;
        self.equivalent += other.equivalent;
        self.below_resolution += other.below_resolution;
        self.survived += other.survived;
    }

    /// Mutants that had to be noticed.
    pub const fn decisive(self) -> u64 {
        self.killed + self.survived
    }
}

/// How mutants of the same numbers fared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Score {
    /// Noticed.
    pub killed: u64,
    /// Changed nothing.
    pub equivalent: u64,
    /// Changed less than twice what is allowed.
    pub below_resolution: u64,
    /// Not noticed, though the change exceeds twice what is allowed.
    pub survived: u64,
    /// By kind of mistake, by the code that explains it.
    #[schemars(with = "BTreeMap<String, Fared>")]
    pub by_mistake: BTreeMap<Cause, Fared>,
    /// The mistakes that survived, with an entry each.
    pub survivors: BTreeMap<String, String>,
    /// The smallest δ for which every significant entry × (1 + δ) was noticed: the worst of all states.
    #[schemars(with = "Option<f64>")]
    pub detectable: f64,
    /// The same at the median state.
    #[schemars(with = "Option<f64>")]
    pub detectable_median: f64,
    /// The smallest δ at each state.
    #[serde(skip)]
    pub detectable_at: Vec<f64>,
}

impl Score {
    /// Counts a mutant that changes a number by `change` tolerances, in an entry of that name.
    pub(super) fn count(
        &mut self,
        mistake: Mistake,
        noticed: bool,
        change: impl FnOnce() -> f64,
        entry: impl FnOnce() -> String,
    ) {
        let of_kind = self.by_mistake.entry(Cause::of(mistake)).or_default();
        let change = if noticed { f64::INFINITY } else { change() };
        let (all, kind) = if noticed {
            (&mut self.killed, &mut of_kind.killed)
        } else if change == 0.0 {
            (&mut self.equivalent, &mut of_kind.equivalent)
        } else if change < 2.0 {
            (&mut self.below_resolution, &mut of_kind.below_resolution)
        } else {
            self.survivors.insert(mistake.name(), entry());
            (&mut self.survived, &mut of_kind.survived)
        };
        (*all, *kind) = (*all + 1, *kind + 1);
    }

    /// Adds another score.
    pub fn merge(&mut self, other: Self) {
        self.killed += other.killed;
        self.equivalent += other.equivalent;
        self.below_resolution += other.below_resolution;
        self.survived += other.survived;
        for (cause, fared) in other.by_mistake {
            self.by_mistake.entry(cause).or_default().add(fared);
        }
        for (mistake, entry) in other.survivors {
            self.survivors.entry(mistake).or_insert(entry);
        }
        self.detectable_at.extend(other.detectable_at);
    }

    /// Settles the figures over all states.
    pub fn finish(&mut self) {
        self.detectable_at.sort_by(f64::total_cmp);
        self.detectable = self.detectable_at.last().copied().unwrap_or(0.0);
        self.detectable_median = self.detectable_at.get(self.detectable_at.len() / 2).copied().unwrap_or(0.0);
    }

    /// Mutants that had to be noticed.
    pub const fn decisive(&self) -> u64 {
        self.killed + self.survived
    }
}

/// Entries smaller than this part of the largest of their row, in units of the degrees of freedom, do not count for the smallest
/// error that is noticed: what is left of a cancellation has no relative error of its own.
pub(super) const SIGNIFICANT: f64 = 1e-3;

/// Tries every mutant on the same comparison; `size` is the unit of an entry's degrees of freedom.
pub fn try_mutants(
    quantity: Quantity,
    got: &Entries<f64>,
    answer: &Answer,
    bound: &Bound,
    size: &dyn Fn(usize) -> f64,
    mutants: &[Mutant],
) -> Score {
    let mut score = Score::default();
    // The smallest ladder step from which on every entry was noticed.
    let mut missed = 0.0_f64;
    let mut smallest = f64::INFINITY;
    let mut largest = [0.0_f64; 6];
    for (k, i, x) in got.iter() {
        largest[k] = largest[k].max(x.abs() * size(i));
    }
    let answered = |k: usize| answer.numbers.0.get(k).is_some_and(Option::is_some);
    for mutant in mutants.iter().filter(|mutant| mutant.changes.iter().any(|(k, ..)| answered(*k))) {
        let noticed = mutant.changes.iter().any(|(k, i, x)| {
            let want = answer.numbers.get(*k, *i);
            let is_given = got.get(*k, *i).is_some();
            is_given && want.is_some_and(|want| want.units(*x, answer.allowed(bound, quantity, *k, *i)) > 1.0)
        });
        if let (Mistake::Scaled(delta), Some((k, i, _))) = (mutant.mistake, mutant.changes.first()) {
            smallest = smallest.min(delta);
            let size = got.get(*k, *i).unwrap_or(0.0).abs() * size(*i);
            if !noticed && size >= SIGNIFICANT * largest[*k] {
                missed = missed.max(delta);
            }
        }
        // By how many tolerances it moves an entry; one that nobody compares survives whatever changes it.
        let change = |(k, i, x): &(usize, usize, f64)| {
            let Some(was) = got.get(*k, *i).filter(|_| answered(*k)) else { return 0.0 };
            let moved = (x - was).abs();
            match answer.numbers.get(*k, *i) {
                None => f64::INFINITY,
                Some(_) if moved == 0.0 => 0.0,
                Some(_) => moved / answer.allowed(bound, quantity, *k, *i),
            }
        };
        let largest_change = || mutant.changes.iter().map(change).fold(0.0_f64, f64::max);
        let entry = || mutant.changes.first().map(|(k, i, _)| quantity.entry_name(*k, *i));
        score.count(mutant.mistake, noticed, largest_change, || entry().unwrap_or_default());
    }
    if smallest.is_finite() {
        score.detectable_at.push(if missed > 0.0 { missed * 10.0 } else { smallest });
    }
    score
}
