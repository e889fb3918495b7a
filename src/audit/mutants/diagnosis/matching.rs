//! Wrong numbers beside what mistakes would make of the right ones: which mistakes are believed, wherever the numbers come from.

use crate::judge::bound::C;
use crate::mutants::diagnosis::{Cause, Diagnosis, Explained};
use crate::mutants::mutant::{Changes, NOTHING};
use pintle_kinematics::scalar::U;
use pintle_scene::Code;
use pintle_scene::grammar::number as short;
use std::collections::{BTreeMap, BTreeSet};

/// Where a number stands: its row (a component, an equation, a part) and its place in that row.
pub(super) type Cell = (usize, usize);

/// Numbers of one class have one unit.
pub(super) type Class = (usize, usize, usize);

/// A number that may be wrong.
pub(super) struct Datum {
    /// What was given; none where nothing was.
    pub(super) got: Option<f64>,
    pub(super) want: f64,
    pub(super) tolerance: f64,
    pub(super) class: Class,
}

/// What a mistake would make of the numbers.
pub(super) struct Hypothesis {
    pub(super) cause: Cause,
    pub(super) changes: Changes,
}

impl Hypothesis {
    pub(super) fn one(cause: Cause, (k, i): Cell, x: f64) -> Self {
        Self { cause, changes: Changes::One([(k, i, x)]) }
    }
}

/// How numbers are called in sentences.
pub(super) trait Words {
    /// One of them.
    fn entry(&self, place: Cell) -> String;
    /// Some of them: `∂ur1/∂θa1..3`.
    fn region(&self, places: &BTreeSet<Cell>) -> String;
    /// The symbols, in a sentence, of the triads of the first and the second node.
    fn triads(&self) -> [&'static str; 2];
    /// Whether any of the places is a rotation of the first, and of the second node.
    fn rotations(&self, places: &BTreeSet<Cell>) -> [bool; 2];
}

/// Numbers, and mistakes that may explain them.
pub(super) struct Matching<'a> {
    pub(super) data: BTreeMap<Cell, Datum>,
    pub(super) hypotheses: Vec<Hypothesis>,
    pub(super) words: &'a dyn Words,
}

/// Chance may not do it more often than once in so many.
const CHANCE: f64 = 1000.0;

/// How much wider tolerances are tried for numbers that have lost digits.
const LOST: [f64; 4] = [1.0, 1e2, 1e4, 1e6];

/// What a mistake leaves of the errors that it explains: more than this part is no explanation, for what loses digits comes near to many
/// things.
const LEFT: f64 = 1e-2;

/// Single entries without structure that are named one by one.
const SINGLE: usize = 2;

impl Matching<'_> {
    /// Adds what every number can suffer by itself: that it is missing, that it has the wrong sign.
    pub(super) fn add_mistakes_of_entries(&mut self) {
        for (place, datum) in self.data.iter().filter(|(_, datum)| datum.want != 0.0) {
            self.hypotheses.push(Hypothesis::one(Cause::Dropped, *place, 0.0));
            self.hypotheses.push(Hypothesis::one(Cause::Sign, *place, -datum.want));
        }
    }

    /// Why numbers are wrong; `None` where none is.
    pub(super) fn diagnosis(&self) -> Option<Diagnosis> {
        let first = self.explain(LOST[0])?;
        if first.unexplained == 0 {
            return Some(first);
        }
        let wider = LOST[1..].iter().filter_map(|wider| self.explain(*wider));
        let whole = wider.into_iter().find(|found| found.is_whole());
        Some(whole.unwrap_or(first))
    }

    /// The mistakes that explain what is wrong, with tolerances `wider` times as wide; `None` where nothing is wrong.
    fn explain(&self, wider: f64) -> Option<Diagnosis> {
        let mut class_tolerance: BTreeMap<Class, f64> = BTreeMap::new();
        for datum in self.data.values() {
            let most = class_tolerance.entry(datum.class).or_default();
            *most = most.max(datum.tolerance);
        }
        // What is given has the rounding of the right numbers once more: they are compared with rounded ones.
        let allowed = |datum: &Datum, cause: Cause| {
            let class = class_tolerance.get(&datum.class).copied().unwrap_or(0.0);
            2.0 * wider * cause.gain() * class
        };
        // Bits that each wrong entry is worth.
        let mut wrong: BTreeMap<Cell, f64> = BTreeMap::new();
        for (place, datum) in &self.data {
            let Some(got) = datum.got else { continue };
            let error = (got - datum.want).abs();
            let tolerance = wider * datum.tolerance;
            let is_wrong = error.is_nan() || error > tolerance;
            if is_wrong {
                wrong.insert(*place, (error / tolerance).log2().clamp(0.0, f64::from(f64::MANTISSA_DIGITS)));
            }
        }
        if wrong.is_empty() {
            return None;
        }
        let fits = |hypothesis: &&Hypothesis| {
            let of_wrong = hypothesis.changes.iter().filter(|(k, i, _)| wrong.contains_key(&(*k, *i)));
            let [error, left] = of_wrong.fold([0.0_f64; 2], |[error, left], (k, i, x)| {
                let off = |from: f64, got: f64| if got == from { 0.0 } else { (got - from).abs() };
                match self.data.get(&(*k, *i)).and_then(|datum| Some((datum.want, datum.got?))) {
                    Some((want, got)) => [error.max(off(want, got)), left.max(off(*x, got))],
                    None => [error, left],
                }
            });
            error > 0.0
                && left <= LEFT * error
                && hypothesis.changes.iter().all(|(k, i, x)| {
                    let datum = self.data.get(&(*k, *i));
                    datum.and_then(|datum| Some((datum, datum.got?))).is_some_and(|(datum, got)| {
                        got == *x || (got - x).abs() <= allowed(datum, hypothesis.cause)
                    })
                })
        };
        let fitting: Vec<&Hypothesis> = self.hypotheses.iter().filter(fits).collect();
        let mut found = Diagnosis::default();
        let enough = (CHANCE * self.hypotheses.len().max(1) as f64).log2();
        while !wrong.is_empty() {
            let Some(explained) = self.best(&fitting, &mut wrong, enough) else { break };
            found.causes.push(explained);
        }
        // What stands out of tolerances that were widened is the largest of the digits lost.
        if wrong.len() <= SINGLE && wider <= LOST[0] {
            for place in std::mem::take(&mut wrong).into_keys() {
                found.causes.push(self.single(place));
            }
        }
        found.unexplained = wrong.len();
        Some(found)
    }

    /// The mistake that explains most of what is wrong, which is then explained.
    fn best(
        &self,
        fitting: &[&Hypothesis],
        wrong: &mut BTreeMap<Cell, f64>,
        enough: f64,
    ) -> Option<Explained> {
        #[derive(Default)]
        struct Explains {
            entries: BTreeSet<Cell>,
            region: BTreeSet<Cell>,
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
        let bits =
            |entries: &BTreeSet<Cell>| -> f64 { entries.iter().filter_map(|place| wrong.get(place)).sum() };
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
        let shown = if cause.is_of_an_entry() { &explains.entries } else { &explains.region };
        let place = match shown.first() {
            Some(only) if shown.len() == 1 => self.words.entry(*only),
            _ => self.words.region(shown),
        };
        wrong.retain(|place, _| !explains.entries.contains(place));
        let relation = self.relation(cause, &explains.region);
        let equals = if place.contains(", ") { "equal" } else { "equals" };
        let sentence = format!("{place} {equals} {relation}: {}", cause.meaning());
        Some(Explained { cause, code: cause.code(), sentence, also })
    }

    /// What the numbers equal, with the triads in question.
    fn relation(&self, cause: Cause, region: &BTreeSet<Cell>) -> String {
        let [a, b] = self.words.triads();
        match (cause, self.words.rotations(region)) {
            (Cause::RotationTakenAsLocal, [true, true]) => format!("{a}ᵀ and {b}ᵀ × expected"),
            (Cause::RotationTurnedTwice, [true, true]) => format!("{a} and {b} × expected"),
            (Cause::RotationTakenAsLocal | Cause::RotationTurnedTwice, [is_of_a, _]) => {
                cause.relation().replace('R', if is_of_a { a } else { b })
            }
            _ => cause.relation().to_string(),
        }
    }

    /// An entry that is wrong by itself.
    fn single(&self, place: Cell) -> Explained {
        let name = self.words.entry(place);
        let datum = self.data.get(&place);
        let of = |f: fn(&Datum) -> Option<f64>| datum.and_then(f).unwrap_or(f64::NAN);
        let (got, want) = (of(|datum| datum.got), of(|datum| Some(datum.want)));
        // What is left of a cancellation has no relative error of its own.
        let is_nothing =
            datum.is_some_and(|datum| datum.want.abs() <= datum.tolerance * (NOTHING / (C * U)).max(1.0));
        let is_zero = datum.is_some_and(|datum| datum.want.abs() <= datum.tolerance);
        let cause = if is_nothing { Cause::Spurious } else { Cause::Scaled };
        let sentence = match cause {
            Cause::Spurious if is_zero => {
                format!("{name} equals {got}, and must be zero", got = short(got, 4))
            }
            Cause::Spurious => {
                format!(
                    "{name} equals {got}, and must be {want}, which is next to nothing",
                    got = short(got, 4),
                    want = short(want, 2)
                )
            }
            _ => format!("{name} equals {:.10} × expected: {}", got / want, cause.meaning()),
        };
        Explained { cause, code: cause.code(), sentence, also: Vec::new() }
    }
}

/// Columns in words, runs of one name with increasing numbers together: `θa1..3`, `xb2`.
pub(super) fn ranges(columns: &BTreeSet<usize>, name: &dyn Fn(usize) -> String) -> Vec<String> {
    let numbered = |name: &str| {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        Some((stem.to_string(), name.strip_prefix(stem)?.parse::<usize>().ok()?))
    };
    let mut found = Vec::new();
    let mut columns = columns.iter().copied().peekable();
    while let Some(first) = columns.next() {
        let start = name(first);
        let mut last = numbered(&start);
        let mut length = 1;
        while let (Some((stem, number)), Some(next)) = (&last, columns.peek()) {
            let next = numbered(&name(*next)).filter(|(other, n)| other == stem && *n == number + 1);
            if next.is_none() {
                break;
            }
            (last, length) = (next, length + 1);
            columns.next();
        }
        found.push(match last {
            Some((_, number)) if length > 1 => format!("{start}..{number}"),
            _ => start,
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::ranges;

    #[test]
    fn runs_of_columns_are_named_together() {
        let names = ["xa1", "xa2", "xa3", "θa1", "Ψa", "xb1", "xb2"];
        let of = |columns: &[usize]| {
            ranges(&columns.iter().copied().collect(), &|j| names[j].to_string()).join(" ")
        };
        assert_eq!(of(&[0, 1, 2]), "xa1..3");
        assert_eq!(of(&[0, 2, 3, 4, 5, 6]), "xa1 xa3 θa1 Ψa xb1..2");
        assert_eq!(of(&[]), "");
    }
}
