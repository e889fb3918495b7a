//! Numbers by the components of a connector, judged against an answer: which entry, by how much, and how small an error would have been
//! seen.

use crate::case::Case;
use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::judge::bound::{Bound, C};
use crate::judge::conditioned::Conditioned;
use crate::judge::judged::{COARSE, Judge, Judged, SIGNIFICANT, Trials, moved_by};
use crate::judge::verdict::{Finding, Judgement, Score, Verdict};
use crate::mutants::mutant::Mutant;
use crate::oracles::oracle::{Answer, WideAnswers};
use crate::oracles::truth::{Locked, Truth};
use crate::singular::sides::Sides;
use pintle_kinematics::scalar::{U, Wide};

/// Why numbers have nothing to be compared with.
const KEPT: &str =
    "neither value nor derivatives are determined there: a convention stands for them, or rounding decides";

/// Why derivatives have nothing to be compared with.
const BESIDE: &str = "rounding alone holds the state off a singular set: which of the derivatives on its sides is meant nobody can say";

/// What angles at a lock may be off besides, for their rows do not tell from what they are formed: two angles of up to π.
const LOCKED_SCALE: f64 = std::f64::consts::TAU;

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

/// The product's numbers on 237 bits and their witness, at rotations that are such to the last of these. At triads that are rotations
/// to the last of 53 bits the two are apart by up to a tolerance, for they leave the group on different ways.
#[derive(Clone, Copy, Debug)]
pub struct Exact<'a> {
    /// The product's own source by dual numbers: without rounding.
    pub product: &'a Entries<Wide>,
    /// Differences: another mechanism.
    pub truth: &'a Entries<Wide>,
}

impl<'a> Exact<'a> {
    /// Of a quantity.
    pub fn of(answers: &'a WideAnswers, quantity: Quantity) -> Self {
        Self { product: answers.dual.entries(quantity), truth: answers.differences.entries(quantity) }
    }

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
    pub fn of(case: &Case, truth: &Truth, bound: &'a Bound, sides: Option<&'a Numbers<Sides>>) -> Self {
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

/// Judges the entries of one quantity, each by itself: the severest verdict is that of the quantity.
pub fn judge(
    quantity: Quantity,
    got: &Entries<f64>,
    answer: &Answer,
    around: &Surroundings<'_>,
) -> Judgement {
    let mut found = Judge::default();
    let mut coarse = false;
    for (k, row) in got.0.iter().enumerate() {
        let (Some(row), Some(wanted)) = (row, &answer.numbers.0[k]) else { continue };
        let sized = |i: usize, x: f64| around.bound.sized(quantity, i, x.abs());
        let largest = row.iter().enumerate().fold(0.0_f64, |most, (i, x)| most.max(sized(i, *x)));
        for (i, (x, want)) in row.iter().zip(wanted).enumerate() {
            let mut allowed = answer.allowed(around.bound, quantity, k, i);
            if quantity == Quantity::Value && around.locked.rows[k] {
                allowed += C * U * LOCKED_SCALE;
            }
            coarse |= sized(i, allowed) > COARSE * largest && largest > 0.0 && quantity != Quantity::Value;
            let sides = around.kink(quantity, k, i);
            let want = sides.map_or(*want, |sides| sides.nearest(*x).into());
            // On a singular set there is no finite scale either, but where lengths are beyond the range.
            let is_scaled = around.nearness[k] > 0.0 || around.is_out_of_range || want.to_f64().is_infinite();
            let number = Judged {
                quantity,
                got: *x,
                want,
                allowed,
                sides,
                is_open: around.nearness[k] == 0.0 && around.sides_of(quantity, k, i).is_none(),
                overflows: is_scaled && around.bound.overflows(quantity, k, i, want.to_f64()),
                undetermined: around.undetermined(quantity, k),
            };
            found.see(&number, || number.finding(quantity.entry_name(k, i), Some((k, i))));
        }
    }
    let compared = found.compared;
    let (verdict, worst) = found.severest();
    let verdict = match (verdict, &worst) {
        (Verdict::Pass, _) if coarse && answer.oracle.is_wide() => Verdict::IllConditioned,
        (Verdict::Wrong, Some(worst)) => why(quantity, worst, around),
        (verdict, _) => verdict,
    };
    Judgement { verdict, worst, compared }
}

/// Why an entry is beyond its tolerance.
fn why(quantity: Quantity, worst: &Finding, around: &Surroundings<'_>) -> Verdict {
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

/// A comparison of sums instead of entries: Σ_i w_i x_i of each component.
pub struct Along<'a> {
    /// The weight of an entry.
    pub weight: &'a dyn Fn(usize) -> f64,
    /// What the sum must be less what it is, and how far that may be from zero; of the components that are compared.
    pub off: [Option<(f64, f64)>; 6],
}

/// Tries every mutant on a comparison of sums.
pub fn try_along(quantity: Quantity, got: &Entries<f64>, along: &Along<'_>, mutants: &[Mutant]) -> Score {
    let mut trials = Trials::default();
    let largest = largest(got, |i| (along.weight)(i).abs());
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
        let is_significant = || {
            let size = (got.get(*k, *i).unwrap_or(0.0) * (along.weight)(*i)).abs();
            size >= SIGNIFICANT * largest[*k] && size > 0.0
        };
        let change = || {
            let of = |(moved, (_, allowed)): (f64, (f64, f64))| moved_by(moved.abs(), allowed);
            compared().map(of).fold(0.0_f64, f64::max)
        };
        let entry = || quantity.entry_name(*k, *i);
        trials.add(mutant.mistake, noticed, (is_significant, || false), change, entry);
    }
    trials.score()
}

/// The largest entry of each component, in units of what entries are measured by.
fn largest(got: &Entries<f64>, size: impl Fn(usize) -> f64) -> [f64; 6] {
    let mut largest = [0.0_f64; 6];
    got.iter().for_each(|(k, i, x)| largest[k] = largest[k].max(x.abs() * size(i)));
    largest
}

/// Tries every mutant on the same comparison; `size` is the unit of an entry's degrees of freedom. By an oracle on 237 bits a relative
/// error of [`NOTICED`](crate::judge::conditioned::NOTICED) must be noticed wherever `conditioned` demands it, whatever is allowed.
pub fn try_mutants(
    quantity: Quantity,
    got: &Entries<f64>,
    answer: &Answer,
    bound: &Bound,
    (size, conditioned): (&dyn Fn(usize) -> f64, &Conditioned),
    mutants: &[Mutant],
) -> Score {
    let mut trials = Trials::default();
    let largest = largest(got, size);
    let answered = |k: usize| answer.numbers.0.get(k).is_some_and(Option::is_some);
    for mutant in mutants.iter().filter(|mutant| mutant.changes.iter().any(|(k, ..)| answered(*k))) {
        let Some((first, place, _)) = mutant.changes.first().copied() else { continue };
        let noticed = mutant.changes.iter().any(|(k, i, x)| {
            let want = answer.numbers.get(*k, *i);
            let is_given = got.get(*k, *i).is_some();
            is_given && want.is_some_and(|want| want.units(*x, answer.allowed(bound, quantity, *k, *i)) > 1.0)
        });
        let entry = got.get(first, place);
        let is_significant = || entry.unwrap_or(0.0).abs() * size(place) >= SIGNIFICANT * largest[first];
        let is_demanded = || {
            let demands = |x: f64| conditioned.demands(quantity, first, place, x);
            answer.oracle.is_wide() && entry.is_some_and(demands)
        };
        // By how many tolerances it moves an entry; one that nobody compares survives whatever changes it.
        let change = |(k, i, x): &(usize, usize, f64)| {
            let Some(was) = got.get(*k, *i).filter(|_| answered(*k)) else { return 0.0 };
            match answer.numbers.get(*k, *i) {
                None => f64::INFINITY,
                Some(_) => moved_by((x - was).abs(), answer.allowed(bound, quantity, *k, *i)),
            }
        };
        let change = || mutant.changes.iter().map(change).fold(0.0_f64, f64::max);
        let name = || quantity.entry_name(first, place);
        trials.add(mutant.mistake, noticed, (is_significant, is_demanded), change, name);
    }
    trials.score()
}
