//! Digits: no number at special states, fewer digits the nearer they are, or few digits everywhere.

use crate::case::quantity::Quantity;
use crate::judge::bound::C;
use crate::mutants::diagnosis::cells::Cell;
use crate::mutants::diagnosis::component::Symptoms;
use crate::mutants::diagnosis::matching::{Matching, Words, equation};
use crate::mutants::diagnosis::places::{FORMULAS, OF_ANGLES, PLACES, places};
use crate::mutants::diagnosis::seen::Seen;
use crate::mutants::diagnosis::{Cause, Diagnosis, Explained};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::scalar::U;
use std::collections::BTreeSet;

/// So near to a special state (rad, or lengths of the connector) that numbers are lost there.
const NEAR: f64 = 1e-6;

/// So near that a constraint holds it there.
const HELD: f64 = 1e-13;

/// So near that digits are.
const CLOSE: f64 = 0.1;

/// What is larger than this part of its conditioned scale is no loss of digits.
const LOST: f64 = 1e-4;

/// How many roundings, over the distance or its square, are still a loss of digits.
const ROUNDINGS: f64 = 1e3;

/// A special kind of states, and how far a state is from it.
struct Special {
    at: &'static str,
    formula: &'static str,
    distance: f64,
}

/// How far a state is from special ones; those of an angle count where it has wrong numbers.
fn specials(symptoms: &Symptoms<'_>, components: &BTreeSet<usize>) -> Vec<Special> {
    let case = symptoms.case;
    if case.last().is_none() {
        return Vec::new();
    }
    let told = PLACES.into_iter().zip(FORMULAS).zip(places(case));
    let all = told.map(|(((at, _), formula), distance)| Special { at, formula, distance });
    let is_meant = |n: &usize| *n < OF_ANGLES || components.contains(&(3 + (n - OF_ANGLES) % 3));
    all.enumerate().filter(|(n, _)| is_meant(n)).map(|(_, special)| special).collect()
}

/// Whether errors are smaller the nearer states are to a special kind: what loses digits there has larger ones.
fn grows_with_distance(states: &[Vec<Special>], errors: &[f64], n: usize) -> bool {
    /// By so much distances, and errors, must differ.
    const MUCH: f64 = 10.0;
    let all = || states.iter().filter_map(|at| at.get(n)).map(|special| special.distance).zip(errors);
    let Some(nearest) = all().min_by(|x, y| x.0.total_cmp(&y.0)) else { return false };
    let Some(farthest) = all().max_by(|x, y| x.0.total_cmp(&y.0)) else { return false };
    farthest.0 > MUCH * nearest.0 && *farthest.1 > MUCH * nearest.1
}

fn told(cause: Cause, sentence: String, cells: &BTreeSet<Cell>) -> Diagnosis {
    let explained = Explained { cause, code: cause.code(), sentence, also: Vec::new() };
    Diagnosis { causes: if cells.is_empty() { Vec::new() } else { vec![explained] }, unexplained: 0 }
}

fn place(cells: &BTreeSet<Cell>, words: &dyn Words) -> String {
    match cells.first() {
        Some(only) if cells.len() == 1 => words.entry(*only),
        _ => words.region(cells),
    }
}

/// The special kind of states at which all of these are: the index, and the largest distance.
fn common(states: &[Vec<Special>], far: f64) -> Option<usize> {
    let first = states.first()?;
    (0..first.len())
        .find(|n| states.iter().all(|at| at.get(*n).is_some_and(|special| special.distance <= far)))
}

/// Numbers that are none: at which states.
pub(super) fn without_numbers(symptoms: &[&Symptoms<'_>], words: &dyn Words) -> Option<Diagnosis> {
    let of = |one: &Symptoms<'_>| -> Vec<Cell> {
        one.got.iter().filter(|(.., x)| !x.is_finite()).map(|(k, i, _)| (k, i)).collect()
    };
    let cells: BTreeSet<Cell> = symptoms.iter().flat_map(|one| of(one)).collect();
    let components: BTreeSet<usize> = cells.iter().map(|(k, _)| *k).collect();
    let states: Vec<Vec<Special>> = symptoms.iter().map(|one| specials(one, &components)).collect();
    let (place, of) = (place(&cells, words), Matching::at_states(states.len(), states.len()));
    let is = if place.contains(", ") { "are" } else { "is" };
    let meaning = Cause::NotANumber.meaning();
    let known = common(&states, NEAR).and_then(|n| states.first()?.get(n));
    let still = known.map_or_else(|| still(symptoms), |_| Vec::new());
    let sentence = match (known, still.as_slice()) {
        (Some(Special { at, formula, .. }), _) => {
            format!("{place} {is} no number where {at}{of}: {formula}; {meaning}")
        }
        (None, []) => {
            format!("{place} {is} no number{of} that have nothing in common: {meaning}, or a failure there")
        }
        (None, still) => {
            let has = if still.len() > 1 { "are zero" } else { "is zero" };
            format!(
                "{place} {is} no number where {} {has}{of}: a division by it; {meaning}",
                still.join(", ")
            )
        }
    };
    Some(told(Cause::NotANumber, sentence, &cells))
}

/// The displacements that are zero at all of these states.
fn still(symptoms: &[&Symptoms<'_>]) -> Vec<&'static str> {
    let rests = |one: &&Symptoms<'_>, k: usize| {
        let (now, first) = (one.case.positions()[k], one.case.at_rest().positions()[k]);
        now.zip(first).is_some_and(|(now, first)| (now - first).abs() <= NEAR * one.case.length)
    };
    (0..3).filter(|k| symptoms.iter().all(|one| rests(one, *k))).map(|k| COMPONENT[k]).collect()
}

/// The largest error of components, as a part of the largest entry of the row as a whole.
fn relative(one: &Symptoms<'_>, components: &BTreeSet<usize>) -> f64 {
    let of = |k: &usize| {
        let want = one.want.entries(one.quantity).0[*k].as_deref().unwrap_or_default();
        let got = one.got.0[*k].as_deref().unwrap_or_default();
        let size = want.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let error = want.iter().zip(got).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
        if error > 0.0 { error / size } else { 0.0 }
    };
    components.iter().map(of).fold(0.0, f64::max)
}

/// Numbers that are wrong by little, and more the nearer their states are to special ones.
pub(super) fn digits_lost(symptoms: &[&Symptoms<'_>], words: &dyn Words) -> Option<Diagnosis> {
    let Errors { cells, largest: lost, .. } = errors(symptoms);
    if lost.iter().any(|lost| *lost > LOST) {
        return None;
    }
    let components: BTreeSet<usize> = cells.iter().map(|(k, _)| *k).collect();
    let of_rows: Vec<f64> = symptoms.iter().map(|one| relative(one, &components)).collect();
    let is_value = symptoms.iter().any(|one| one.quantity == Quantity::Value);
    let states: Vec<Vec<Special>> = symptoms.iter().map(|one| specials(one, &components)).collect();
    let count = states.len();
    // One state tells of no tendency.
    if count < 2 {
        return None;
    }
    let kinds = states.first()?.len();
    let is_lost = |n: usize| {
        let near = |at: &Vec<Special>, lost: f64| {
            let distance = at.get(n).map_or(1.0, |special| special.distance);
            distance < CLOSE && lost * distance * distance <= ROUNDINGS * U
        };
        let nearest = states.iter().filter_map(|at| at.get(n)).map(|special| special.distance);
        let mean = nearest.map(|x| x.max(U).ln()).sum::<f64>() / count as f64;
        // What a constraint holds there is near it everywhere.
        let is_held = states.iter().filter_map(|at| at.get(n)).all(|special| special.distance < HELD);
        let is_lost = states.iter().zip(&lost).all(|(at, lost)| near(at, *lost))
            && (is_value || states.iter().zip(&of_rows).all(|(at, lost)| near(at, *lost)))
            && !grows_with_distance(&states, &lost, n);
        (is_lost && !is_held && mean < CLOSE.powi(2).ln()).then_some(mean)
    };
    let nearest = (0..kinds).filter_map(|n| Some((n, is_lost(n)?))).min_by(|x, y| x.1.total_cmp(&y.1));
    let (n, _) = nearest?;
    let Special { at, formula, .. } = states.first()?.get(n)?;
    let (place, of) = (place(&cells, words), Matching::at_states(count, count));
    let loses = if place.contains(", ") { "lose" } else { "loses" };
    let sentence =
        format!("{place} {loses} digits where {at}{of}: {formula}; {}", Cause::DigitsLost.meaning());
    Some(told(Cause::DigitsLost, sentence, &cells))
}

/// Wrong numbers everywhere, and by how much at most, in conditioned scales, at each state.
struct Errors {
    cells: BTreeSet<Cell>,
    count: usize,
    largest: Vec<f64>,
}

fn errors(symptoms: &[&Symptoms<'_>]) -> Errors {
    let mut found = Errors { cells: BTreeSet::new(), count: 0, largest: Vec::new() };
    for one in symptoms {
        let mut largest = 0.0_f64;
        for (k, i, want) in one.want.entries(one.quantity).iter() {
            let Some(got) = one.got.get(k, i) else { continue };
            let (error, tolerance) = ((got - want).abs(), one.bound.tolerance(one.quantity, k, i));
            if error > tolerance {
                found.cells.insert((k, i));
                found.count += 1;
                largest = largest.max(error * C * U / tolerance);
            }
        }
        found.largest.push(largest);
    }
    found
}

/// Numbers of few decimal digits: chance gives one in ten thousand so few.
pub(super) fn rounded(symptoms: &[&Symptoms<'_>], words: &dyn Words) -> Option<Diagnosis> {
    /// Digits, and the largest error of what is still called rounded.
    const FEW: (usize, f64) = (12, 1e-2);
    let is_few = |x: f64| {
        let written = format!("{x:e}");
        let digits = written.split('e').next().unwrap_or_default().bytes().filter(u8::is_ascii_digit).count();
        digits <= FEW.0
    };
    short_numbers((Cause::Rounded, FEW.1), is_few, symptoms, words)
}

/// Numbers of 24 bits: chance gives one in 2²⁹ so few.
pub(super) fn single_precision(symptoms: &[&Symptoms<'_>], words: &dyn Words) -> Option<Diagnosis> {
    #[expect(clippy::cast_possible_truncation, reason = "that is what is looked for")]
    let is_single = |x: f64| x == f64::from(x as f32);
    // A zero has few digits, too: as a rounding it stands for what is as small as one of single precision.
    const ROUNDINGS: f64 = 1e9;
    let is_zeroed = |one: &&Symptoms<'_>| {
        one.got.iter().any(|(k, i, x)| {
            let want = one.want.entries(one.quantity).get(k, i).unwrap_or(0.0);
            x == 0.0 && want.abs() > ROUNDINGS * one.bound.tolerance(one.quantity, k, i)
        })
    };
    let found = short_numbers((Cause::SinglePrecision, LOST), is_single, symptoms, words);
    found.filter(|_| !symptoms.iter().any(is_zeroed))
}

/// Of a row by which a short entry is off at most.
const LEAST_OF_ROW: f64 = 1e-4;

/// Numbers that are all short or right, and wrong by less than some part of their conditioned scales.
fn short_numbers(
    (cause, most): (Cause, f64),
    is_short: impl Fn(f64) -> bool,
    symptoms: &[&Symptoms<'_>],
    words: &dyn Words,
) -> Option<Diagnosis> {
    let errors = errors(symptoms);
    // An entry that is short by chance, as zero is, is off by more.
    let is_near = |one: &Symptoms<'_>, k: usize, error: f64| {
        let row = one.want.entries(one.quantity).0[k].as_deref().unwrap_or_default();
        let value = one.want.entries(Quantity::Value).get(k, 0).filter(|_| one.quantity == Quantity::Value);
        value.is_some()
            || error <= most.max(LEAST_OF_ROW) * row.iter().fold(0.0, |size: f64, x| size.max(x.abs()))
    };
    let is_meant = |one: &Symptoms<'_>, (k, i, x): (usize, usize, f64)| {
        let want = one.want.entries(one.quantity).get(k, i).unwrap_or(x);
        let error = (x - want).abs();
        is_short(x) && is_near(one, k, error) || error <= one.bound.tolerance(one.quantity, k, i)
    };
    let is_little = errors.largest.iter().all(|largest| *largest < most);
    let all = symptoms.iter().all(|one| one.got.iter().all(|number| is_meant(one, number)));
    (errors.count > 2 && is_little && all).then(|| everywhere(cause, &errors, words))
}

fn everywhere(cause: Cause, errors: &Errors, words: &dyn Words) -> Diagnosis {
    let count = errors.largest.len();
    let place = place(&errors.cells, words);
    let at = Matching::at_states(count, count);
    told(cause, equation(&place, cause.relation(), cause.meaning(), &at), &errors.cells)
}

/// Values that are right to 24 bits of what they are formed of at every state, and have more digits: single precision on the way.
pub(super) fn single_precision_on_the_way(
    symptoms: &[&Symptoms<'_>],
    words: &dyn Words,
) -> Option<Diagnosis> {
    /// Between these the largest error of most states is, and so many states tell.
    const SINGLE: ([f64; 2], usize) = ([1e-10, 2e-7], 6);
    let errors = errors(symptoms);
    let is_single = |largest: &f64| (SINGLE.0[0]..SINGLE.0[1]).contains(largest);
    // Differences and constants of few digits have larger errors everywhere, or smaller ones.
    let most = errors.largest.iter().copied().fold(0.0, f64::max);
    let is_value = symptoms.iter().all(|one| one.quantity == Quantity::Value);
    let typical = errors.largest.iter().filter(|largest| is_single(largest)).count();
    // Where what is rounded is small, the error is smaller.
    let is_it = is_value && errors.largest.len() >= SINGLE.1 && 2 * typical >= errors.largest.len();
    (is_it && most > 10.0 * SINGLE.0[0] && most < SINGLE.0[1])
        .then(|| everywhere(Cause::SinglePrecision, &errors, words))
}

/// Derivatives that are right to fewer digits at every state: differences.
pub(super) fn differences(symptoms: &[&Symptoms<'_>], words: &dyn Words) -> Option<Diagnosis> {
    /// What differences are wrong by at least, and how many states tell.
    const LEAST: (f64, usize) = (1e-13, 4);
    /// Differences are no rougher.
    const ROUGH: f64 = 1e-2;
    let errors = errors(symptoms);
    let components = errors.cells.iter().map(|(k, _)| *k).collect();
    let is_regular =
        |one: &&&Symptoms<'_>| specials(one, &components).iter().all(|special| special.distance > NEAR);
    let is_little = errors.largest.iter().all(|largest| *largest > LEAST.0 && *largest < LOST);
    let is_derivative = symptoms.iter().all(|one| one.quantity != Quantity::Value);
    // The scale of an acceleration may be far larger than it is.
    let is_close = |one: &&&Symptoms<'_>| relative(one, &components) < ROUGH;
    let are_close = 2 * symptoms.iter().filter(is_close).count() > symptoms.len();
    (is_derivative && is_little && are_close && symptoms.iter().filter(is_regular).count() >= LEAST.1)
        .then(|| everywhere(Cause::Differences, &errors, words))
}

/// Where all that is wrong is near a special kind of states, and what is farther is right, that first; then what it is there. Digits that are
/// lost, and numbers that are none, have said where.
pub(super) fn led_by_place(
    symptoms: &[Symptoms<'_>],
    seen: &Seen,
    words: &dyn Words,
    found: Diagnosis,
) -> Diagnosis {
    let says_where = |cause: Cause| matches!(cause, Cause::DigitsLost | Cause::NotANumber);
    if found.causes.first().is_some_and(|one| says_where(one.cause)) {
        return found;
    }
    let Some(near) = seen.near() else { return found };
    let all: Vec<&Symptoms<'_>> = symptoms.iter().collect();
    near.leading(&place(&errors(&all).cells, words), found)
}
