//! Judging numbers against an answer: which entry, by how much, and how small an error would have been seen.

use super::bound::{Bound, C, U};
use super::case::Case;
use super::conditioned::{Conditioned, NOTICED};
use super::diagnosis::Cause;
use super::invariant::Demanded;
use super::mutant::{Mistake, Mutant};
use super::oracle::Answer;
use super::quantity::{Entries, Numbers, Quantity};
use super::sides::Sides;
use super::truth::{Locked, Truth};
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
    /// There is no derivative here, and one from each side, which differ.
    Kink,
    /// There is no derivative here that could be judged, and not one from each side either: a true singularity, a jump, or second
    /// derivatives on a kink. [`Finding::lack`] says which.
    Singular,
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
    pub const ALL: [Self; 8] = [
        Self::Pass,
        Self::IllConditioned,
        Self::Kink,
        Self::Singular,
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
            Self::Singular => "singular point",
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

/// A number of a connector, and by what it is multiplied where numbers are added up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summand {
    /// The kind of number.
    pub quantity: Quantity,
    /// The component (0-based).
    pub component: usize,
    /// The place within it.
    pub entry: usize,
    /// The factor.
    pub by: f64,
}

/// One entry, what it is and what it must be.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Finding {
    /// The entry by name: `∂ur1/∂θb3`.
    pub entry: String,
    /// The component (0-based) and the place within it, where it is one entry of a connector's.
    #[serde(skip)]
    pub at: Option<(usize, usize)>,
    /// Where it is what a law demands of one state: which demand.
    #[serde(skip)]
    pub demanded: Option<Demanded>,
    /// Where it is a sum of numbers of a connector, as along a direction: which.
    #[serde(skip)]
    pub sum: Vec<Summand>,
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
    /// Where there is no derivative: those from below and from above, not a number from a side that has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[Option<f64>; 2]>")]
    pub one_sided: Option<[f64; 2]>,
    /// At a singular point that is no kink: what there is no derivative for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lack: Option<&'static str>,
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

/// How far the product's dual numbers over 237 bits may be from the differences there and still prove the formula right: a part of
/// the tolerance C u F on doubles. What the differences are off by themselves is, in these units,
///
/// | differences | step | rounding 2⁻²³⁷ over the step | truncation, the step squared | over C u |
/// |---|---|---|---|---|
/// | of values, of rows | δ·1e-25 | 5e-47/δ | 1e-50 | 1e-31/δ |
/// | second, of accelerations, the tolerance being F/δ | δ·1e-18 | 5e-36/δ | 1e-36 | 1e-20/δ |
///
/// to which ten times the last column is added. A formula with an error that matters is beyond that by many decades.
const EXACT: f64 = 1e-9;

/// The same of second derivatives: their differences go ahead only where δ > 0.01, and a step of 1e-21 is left, eightfold over C u.
const EXACT_SECOND: f64 = 2e-5;

/// What differences are off by themselves, times δ, with a decade to spare.
const OF_DIFFERENCES: f64 = 1e-19;

/// An error larger than this, relative to the conditioned scale, is no loss of digits.
const LOST_DIGITS: f64 = 1e-4;

/// The product's numbers on 237 bits and their witness, at rotations that are such to the last of these: at triads that are rotations to
/// the last of 53 bits the two are apart by up to a tolerance, for they leave the group on different ways.
#[derive(Clone, Copy, Debug)]
pub struct Exact<'a> {
    /// The product's own source by dual numbers: without rounding.
    pub product: &'a Entries<Wide>,
    /// Differences: another mechanism.
    pub truth: &'a Entries<Wide>,
}

impl Exact<'_> {
    /// Whether the source gives what the differences say of an entry, but for [`EXACT`] or [`EXACT_SECOND`] of `tolerance`.
    fn proves(&self, (quantity, k, i): (Quantity, usize, usize), tolerance: f64, nearness: f64) -> bool {
        let (Some(product), Some(truth)) = (self.product.get(k, i), self.truth.get(k, i)) else {
            return false;
        };
        // On a singular set steps are as long as far from it.
        let near = if nearness > 0.0 { nearness } else { 1.0 };
        let exact = match quantity {
            Quantity::SecondDerivatives | Quantity::GeometricStiffness => EXACT_SECOND,
            _ => EXACT,
        };
        (product - truth).abs().to_f64() <= (exact + OF_DIFFERENCES / near) * tolerance
    }
}

/// What surrounds a comparison.
pub struct Surroundings<'a> {
    /// The tolerances.
    pub bound: &'a Bound,
    /// Where the numbers are the product's: its own source without rounding, and what differences there say. Asked where numbers are
    /// wrong by little.
    pub exact: Option<&'a dyn Fn(Quantity) -> Option<Exact<'a>>>,
    /// min(1, distance to the nearest singular set) of each component; 0 on it.
    pub nearness: [f64; 6],
    /// What exists of the components that are on a singular set, from both sides.
    pub sides: Option<&'a Numbers<Sides>>,
    /// The components at a lock.
    pub locked: Locked,
    /// Whether powers of lengths, of which second derivatives are formed, leave the range of doubles.
    pub is_out_of_range: bool,
}

impl<'a> Surroundings<'a> {
    /// Where no more is known than how far components are from their singular sets.
    pub fn new(bound: &'a Bound, nearness: [f64; 6]) -> Self {
        Self { bound, exact: None, nearness, sides: None, locked: Locked::default(), is_out_of_range: false }
    }

    /// At the end of a case that is known on 237 bits.
    pub(super) fn of(
        case: &Case,
        truth: &Truth,
        bound: &'a Bound,
        sides: Option<&'a Numbers<Sides>>,
    ) -> Self {
        let nearness = truth.nearness_of_components();
        let (locked, is_out_of_range) = (truth.locked(), case.is_out_of_range());
        Self { sides, locked, is_out_of_range, ..Self::new(bound, nearness) }
    }

    /// Why a lock, a true singularity or rounding leaves nothing to compare a number with.
    fn undetermined(&self, quantity: Quantity, k: usize) -> Option<&'static str> {
        let is_value = quantity == Quantity::Value;
        // Nodal forces, rates and all others are formed of rows.
        let by_lock = if is_value { self.locked.values[k] } else { self.locked.rows[k] };
        if by_lock || self.locked.everything[k] {
            return Some(KEPT);
        }
        (self.locked.sides[k] && !is_value).then_some(BESIDE)
    }

    /// On a singular set: the sides of a derivative that differ by more than rounding. The two-sided difference is their mean there, which
    /// is no derivative, whoever agrees with it.
    fn kink(&self, quantity: Quantity, k: usize, i: usize) -> Option<&'a Sides> {
        let sides = self.sides_of(quantity, k, i)?;
        sides.differ(self.bound.tolerance(quantity, k, i)).then_some(sides)
    }

    fn sides_of(&self, quantity: Quantity, k: usize, i: usize) -> Option<&'a Sides> {
        let sides = self.sides.filter(|_| self.nearness[k] == 0.0)?;
        sides.entries(quantity).0.get(k)?.as_ref()?.get(i)
    }
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

    /// The number with the other sign.
    pub(super) const fn opposite(self) -> Self {
        Self { nearest: -self.nearest, rest: -self.rest }
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

/// What is known of one entry besides its number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Whether its component is on a singular set, and nobody has looked at its sides.
    pub(super) is_open: bool,
    /// Of a derivative whose two sides differ there: what one of them lacks, if anything.
    pub(super) sides: Option<Option<&'static str>>,
    /// Whether it is formed of numbers beyond the range of doubles.
    pub(super) overflows: bool,
}

/// What is formed of derivatives that do not exist.
const HIGHER: &str = "on a singular set values and one-sided first derivatives exist at most: what is formed of others is judged by nobody";

/// Why numbers have nothing to be compared with.
const KEPT: &str =
    "neither value nor derivatives are determined there: a convention stands for them, or rounding decides";

/// Why derivatives have nothing to be compared with.
const BESIDE: &str = "rounding alone holds the state off a singular set: which of the derivatives on its sides is meant nobody can say";

/// What angles at a lock may be off besides, for their rows do not tell from what they are formed: two angles of up to π.
const LOCKED_SCALE: f64 = std::f64::consts::TAU;

/// The verdict on one entry, by itself, and at a singular point what is lacking: `units` is how far it is from what it must be, on a
/// kink from what may stand there, in units of what is `allowed`.
///
/// A component that is not on a singular set is judged as everywhere, whatever the others of its connector do. On one, a value exists,
/// and of derivatives what their sides show. Nothing is decided where what is allowed, or what it must be, is no number: what is not
/// finite there is no error of a formula, and anywhere else it is invalid.
pub(super) fn verdict_of_entry(
    quantity: Quantity,
    (got, want): (f64, f64),
    allowed: f64,
    units: f64,
    at: Point,
) -> (Verdict, Option<&'static str>) {
    let exists = matches!(quantity, Quantity::Value | Quantity::FirstDerivatives);
    if !got.is_finite() {
        return (if at.overflows { Verdict::Undecided } else { Verdict::Invalid }, None);
    }
    match decided(want, allowed, units) {
        Verdict::Pass => match at.sides {
            None => (Verdict::Pass, None),
            Some(None) => (Verdict::Kink, None),
            Some(lack) => (Verdict::Singular, lack),
        },
        _ if at.is_open && !(exists && want.is_finite()) => (Verdict::Singular, Some(HIGHER)),
        other => (other, None),
    }
}

/// The verdict on a number that is so many units of what is allowed from what it must be, wherever numbers are judged: where there is no
/// finite tolerance, or nothing finite to be compared with, as where numbers overflow, nothing is decided.
pub(super) fn decided(want: f64, allowed: f64, units: f64) -> Verdict {
    if !allowed.is_finite() || !want.is_finite() {
        Verdict::Undecided
    } else if units <= 1.0 {
        Verdict::Pass
    } else {
        Verdict::Wrong
    }
}

/// By how many tolerances a mutant moves a number. What is less than the least normal double is lost in rounding, whatever is allowed,
/// and nothing counts where there is no finite tolerance.
pub(super) fn moved_by(moved: f64, allowed: f64) -> f64 {
    if moved < f64::MIN_POSITIVE {
        0.0
    } else if allowed.is_finite() {
        moved / allowed
    } else {
        1.0
    }
}

/// Judges the entries of one quantity, each by itself: the severest verdict is that of the quantity.
pub fn judge(
    quantity: Quantity,
    got: &Entries<f64>,
    answer: &Answer,
    around: &Surroundings<'_>,
) -> Judgement {
    // The entry that decides, by the severity of its verdict, and how clearly: the width of a kink, or the error in units.
    let mut worst: Option<(Verdict, f64, Finding)> = None;
    let mut compared = 0;
    let mut coarse = false;
    for (k, row) in got.0.iter().enumerate() {
        let (Some(row), Some(wanted)) = (row, &answer.numbers.0[k]) else { continue };
        let sized = |i: usize, x: f64| around.bound.sized(quantity, i, x.abs());
        let largest = row.iter().enumerate().fold(0.0_f64, |most, (i, x)| most.max(sized(i, *x)));
        for (i, (x, want)) in row.iter().zip(wanted).enumerate() {
            compared += 1;
            let mut allowed = answer.allowed(around.bound, quantity, k, i);
            if quantity == Quantity::Value && around.locked.rows[k] {
                allowed += C * U * LOCKED_SCALE;
            }
            let kink = around.kink(quantity, k, i);
            let want = kink.map_or(*want, |sides| sides.nearest(*x).into());
            let units = want.units(*x, allowed);
            coarse |= sized(i, allowed) > COARSE * largest && largest > 0.0 && quantity != Quantity::Value;
            let is_open = around.nearness[k] == 0.0 && around.sides_of(quantity, k, i).is_none();
            // On a singular set there is no finite scale either, but where lengths are beyond the range.
            let is_scaled = around.nearness[k] > 0.0 || around.is_out_of_range || want.to_f64().is_infinite();
            let overflows = is_scaled && around.bound.overflows(quantity, k, i, want.to_f64());
            let at = Point { is_open, sides: kink.map(Sides::lack), overflows };
            let (verdict, lack) = match verdict_of_entry(quantity, (*x, want.to_f64()), allowed, units, at) {
                (Verdict::Wrong, lack) => match around.undetermined(quantity, k) {
                    Some(why) => (Verdict::Singular, Some(why)),
                    None => (Verdict::Wrong, lack),
                },
                other => other,
            };
            let is_open = matches!(verdict, Verdict::Kink | Verdict::Singular);
            let clearly = kink.filter(|_| is_open).map_or(units, Sides::gap);
            if worst
                .as_ref()
                .is_none_or(|(most, least, _)| verdict > *most || verdict == *most && clearly > *least)
            {
                let finding = Finding {
                    entry: quantity.entry_name(k, i),
                    at: Some((k, i)),
                    demanded: None,
                    sum: Vec::new(),
                    got: *x,
                    want: want.to_f64(),
                    tolerance: allowed,
                    units,
                    one_sided: kink.and_then(Sides::to_f64),
                    lack,
                };
                worst = Some((verdict, clearly, finding));
            }
        }
    }
    let Some((verdict, _, mut worst)) = worst else {
        return Judgement { verdict: Verdict::Undecided, worst: None, compared };
    };
    let verdict = match verdict {
        Verdict::Pass if coarse && answer.oracle.is_wide() => Verdict::IllConditioned,
        Verdict::Wrong => why(quantity, &mut worst, around),
        verdict => verdict,
    };
    Judgement { verdict, worst: Some(worst), compared }
}

/// Why an entry is beyond its tolerance.
fn why(quantity: Quantity, worst: &mut Finding, around: &Surroundings<'_>) -> Verdict {
    let Some((k, i)) = worst.at else { return Verdict::Wrong };
    let scale = around.bound.scale(quantity, k, i);
    let error = (worst.got - worst.want).abs();
    let tolerance = around.bound.tolerance(quantity, k, i);
    let is_proven = || {
        let exact = around.exact.and_then(|exact| exact(quantity));
        exact.is_some_and(|exact| exact.proves((quantity, k, i), tolerance, around.nearness[k]))
    };
    if error <= LOST_DIGITS * scale && is_proven() { Verdict::UnstableFormula } else { Verdict::Wrong }
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
    /// The smallest δ for which every significant entry × (1 + δ) was noticed: the worst of all states; none where no entry was
    /// judged by itself.
    pub detectable: Option<f64>,
    /// The same at the median state.
    pub detectable_median: Option<f64>,
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
        self.detectable = self.detectable_at.last().copied();
        self.detectable_median = self.detectable_at.get(self.detectable_at.len() / 2).copied();
    }

    /// Mutants that had to be noticed.
    pub const fn decisive(&self) -> u64 {
        self.killed + self.survived
    }
}

/// Entries smaller than this part of the largest of their row, in units of the degrees of freedom, do not count for the smallest
/// error that is noticed: what is left of a cancellation has no relative error of its own.
pub(super) const SIGNIFICANT: f64 = 1e-3;

/// The smallest relative error from which on a comparison noticed every one that was tried.
#[derive(Clone, Copy, Debug)]
pub(super) struct Smallest {
    tried: f64,
    missed: f64,
}

impl Smallest {
    pub(super) const fn of_none() -> Self {
        Self { tried: f64::INFINITY, missed: 0.0 }
    }

    /// An error that was tried; what is not `significant` may be missed.
    pub(super) fn see(&mut self, delta: f64, noticed: bool, significant: bool) {
        self.tried = self.tried.min(delta);
        if !noticed && significant {
            self.missed = self.missed.max(delta);
        }
    }

    /// Adds it to a score, where any was tried: the steps are tenfold.
    pub(super) fn tell(self, score: &mut Score) {
        if self.tried.is_finite() {
            score.detectable_at.push(if self.missed > 0.0 { self.missed * 10.0 } else { self.tried });
        }
    }
}

/// A comparison of sums instead of entries: Σ_i w_i x_i of each component.
pub struct Along<'a> {
    /// The weight of an entry.
    pub weight: &'a dyn Fn(usize) -> f64,
    /// What the sum must be less what it is, and how far that may be from zero; of the components that are compared.
    pub off: [Option<(f64, f64)>; 6],
}

/// Tries every mutant on a comparison of sums.
pub fn try_along(quantity: Quantity, got: &Entries<f64>, along: &Along<'_>, mutants: &[Mutant]) -> Score {
    let mut score = Score::default();
    let mut smallest = Smallest::of_none();
    let mut largest = [0.0_f64; 6];
    for (k, i, x) in got.iter() {
        largest[k] = largest[k].max((x * (along.weight)(i)).abs());
    }
    for mutant in mutants {
        let mut moved = [0.0; 6];
        for (k, i, x) in mutant.changes.iter() {
            if let Some(was) = got.get(*k, *i) {
                moved[*k] += (x - was) * (along.weight)(*i);
            }
        }
        let compared = || moved.iter().zip(&along.off).filter_map(|(moved, off)| Some((*moved, (*off)?)));
        let entry = || mutant.changes.iter().find(|(k, ..)| along.off.get(*k).is_some_and(Option::is_some));
        let Some((k, i, _)) = entry() else { continue };
        let noticed = compared().any(|(moved, (off, allowed))| (off - moved).abs() > allowed);
        if let Mistake::Scaled(delta) = mutant.mistake {
            let size = (got.get(*k, *i).unwrap_or(0.0) * (along.weight)(*i)).abs();
            smallest.see(delta, noticed, size >= SIGNIFICANT * largest[*k] && size > 0.0);
        }
        let change = || {
            let of = |(moved, (_, allowed)): (f64, (f64, f64))| moved_by(moved.abs(), allowed);
            compared().map(of).fold(0.0_f64, f64::max)
        };
        score.count(mutant.mistake, noticed, change, || quantity.entry_name(*k, *i));
    }
    smallest.tell(&mut score);
    score
}

/// Tries every mutant on the same comparison; `size` is the unit of an entry's degrees of freedom. By an oracle on 237 bits a relative
/// error of [`NOTICED`] must be noticed wherever `conditioned` demands it, whatever is allowed.
pub fn try_mutants(
    quantity: Quantity,
    got: &Entries<f64>,
    answer: &Answer,
    bound: &Bound,
    (size, conditioned): (&dyn Fn(usize) -> f64, &Conditioned),
    mutants: &[Mutant],
) -> Score {
    let mut score = Score::default();
    let mut smallest = Smallest::of_none();
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
            let size = got.get(*k, *i).unwrap_or(0.0).abs() * size(*i);
            smallest.see(delta, noticed, size >= SIGNIFICANT * largest[*k]);
        }
        // By how many tolerances it moves an entry; one that nobody compares survives whatever changes it.
        let change = |(k, i, x): &(usize, usize, f64)| {
            let Some(was) = got.get(*k, *i).filter(|_| answered(*k)) else { return 0.0 };
            match answer.numbers.get(*k, *i) {
                None => f64::INFINITY,
                Some(_) => moved_by((x - was).abs(), answer.allowed(bound, quantity, *k, *i)),
            }
        };
        let is_demanded = || match (mutant.mistake, mutant.changes.first()) {
            (Mistake::Scaled(delta), Some((k, i, _))) if delta >= NOTICED && answer.oracle.is_wide() => {
                got.get(*k, *i).is_some_and(|x| conditioned.demands(quantity, *k, *i, x))
            }
            _ => false,
        };
        let largest_change = || match mutant.changes.iter().map(change).fold(0.0_f64, f64::max) {
            small if small > 0.0 && small < 2.0 && is_demanded() => f64::INFINITY,
            change => change,
        };
        let entry = || mutant.changes.first().map(|(k, i, _)| quantity.entry_name(*k, *i));
        score.count(mutant.mistake, noticed, largest_change, || entry().unwrap_or_default());
    }
    smallest.tell(&mut score);
    score
}
