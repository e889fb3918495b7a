//! Numbers in a list, each with what it must be and its conditioned scale: for what is not laid out by the components of a
//! connector.

use super::bound::{C, U};
use super::case::Case;
use super::diagnosis::{Cause, diagnose_sheet};
use super::mutant::{Mistake, of_number};
use super::oracle::Oracle;
use super::outcome::{Against, Check};
use super::quantity::Quantity;
use super::sides::Sides;
use super::verdict::{COARSE, Finding, HIGHER, Judgement, SIGNIFICANT, Score, Verdict, Wanted, units};
use crate::scalar::Wide;

/// One number.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its name: `∂ρ1/∂θS2`.
    pub name: String,
    /// What was given.
    pub got: f64,
    /// What it must be.
    pub want: Wide,
    /// Its conditioned scale; the tolerance is C u times it.
    pub scale: f64,
    /// Entries of one class have one unit: what is rounded in one of them may be found in another.
    pub class: (usize, usize, usize),
    /// How far what it must be may be off by itself; on top of C u times the scale.
    pub error: f64,
    /// On a kink: the derivatives from below and from above.
    pub sides: Option<Sides>,
    /// Whether it is formed of derivatives that do not exist on a singular set, as second ones are.
    pub is_open: bool,
}

impl Entry {
    /// A number that has a reference without an error of its own.
    pub const fn new(name: String, got: f64, want: Wide, scale: f64, class: (usize, usize, usize)) -> Self {
        Self { name, got, want, scale, class, error: 0.0, sides: None, is_open: false }
    }

    /// C u times the conditioned scale, and the error of the reference.
    pub const fn tolerance(&self) -> f64 {
        C * U * self.scale + self.error
    }

    /// What a number must be: on a kink, what is nearest to it of what may stand there.
    fn target(&self, got: f64) -> Wide {
        self.sides.map_or(self.want, |sides| sides.nearest(got))
    }
}

/// One mistake made once: the places that it changes, with the changed numbers.
#[derive(Clone, Debug)]
pub struct Change {
    /// The mistake.
    pub mistake: Mistake,
    /// (place in the sheet, changed number).
    pub changes: Vec<(usize, f64)>,
}

/// The numbers of one quantity at one state, row by row. Whoever has numbers of their own puts them into `got` of the entries, and
/// [`Sheet::check`] judges those.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// What they are.
    pub quantity: Quantity,
    /// The rows, as sentences name them: `∂ρ1`.
    pub rows: Vec<String>,
    /// What the entries of a row are derivatives by: `θS2`; nothing where a row is one number, or a matrix.
    pub columns: Vec<String>,
    /// The numbers: all of the first row, all of the second …
    pub entries: Vec<Entry>,
    /// Mistakes of more than a single entry, made in the right numbers.
    pub mistakes: Vec<Change>,
    /// Other conventions than expected, in the right numbers, which are tried where numbers are wrong.
    pub conventions: Vec<(Cause, Vec<(usize, f64)>)>,
    /// Why nobody can say what the numbers must be, of a sheet without any.
    pub undecided: Option<String>,
}

impl Sheet {
    /// A sheet without numbers.
    pub const fn new(quantity: Quantity) -> Self {
        Self {
            quantity,
            rows: Vec::new(),
            columns: Vec::new(),
            entries: Vec::new(),
            mistakes: Vec::new(),
            conventions: Vec::new(),
            undecided: None,
        }
    }

    /// A sheet of numbers whose witness has no answer.
    pub fn unanswered(quantity: Quantity, why: impl Into<String>) -> Self {
        Self { undecided: Some(why.into()), ..Self::new(quantity) }
    }

    /// How many entries a row has.
    pub fn width(&self) -> usize {
        (self.entries.len() / self.rows.len().max(1)).max(1)
    }

    /// What an entry must be, rounded to a double.
    pub fn want(&self, row: usize, column: usize) -> f64 {
        self.entries.get(row * self.width() + column).map_or(0.0, |entry| entry.want.to_f64())
    }

    fn tolerance(&self, i: usize) -> f64 {
        self.entries.get(i).map_or(0.0, Entry::tolerance)
    }

    /// Judges every number, each by itself: the severest verdict is that of all.
    pub fn judge(&self) -> Judgement {
        let mut worst: Option<Finding> = None;
        let largest = self.entries.iter().fold(0.0_f64, |most, entry| most.max(entry.got.abs()));
        let mut coarse = false;
        // The entry without a derivative that is told: a singular point before a kink.
        let mut open: Option<(Verdict, Finding)> = None;
        for (i, entry) in self.entries.iter().enumerate() {
            let Entry { name, got, scale, sides, .. } = entry;
            let (tolerance, want) = (self.tolerance(i), entry.target(*got));
            let units = units(*got, want, tolerance);
            coarse |= self.quantity != Quantity::Value && largest > 0.0 && C * U * scale > COARSE * largest;
            let one_sided = sides.and_then(|sides| sides.to_f64());
            let lack = sides.and_then(|sides| sides.lack());
            let found = || {
                let (entry, want) = (name.clone(), want.to_f64());
                Finding { entry, at: None, got: *got, want, tolerance, units, one_sided, lack }
            };
            // Values exist on a singular set, and first derivatives and rates from each side; second ones may not.
            if entry.is_open && units > 1.0 && got.is_finite() {
                if open.as_ref().is_none_or(|(known, _)| Verdict::Singular > *known) {
                    open = Some((Verdict::Singular, Finding { lack: Some(HIGHER), ..found() }));
                }
                continue;
            }
            let is_worse = worst.as_ref().is_none_or(|worst| units > worst.units || !got.is_finite());
            let verdict = if lack.is_some() { Verdict::Singular } else { Verdict::Kink };
            if sides.is_some() && open.as_ref().is_none_or(|(known, _)| verdict > *known) {
                open = Some((verdict, found()));
            }
            if is_worse {
                worst = Some(found());
            }
            if !got.is_finite() {
                return Judgement { verdict: Verdict::Invalid, worst, compared: self.entries.len() };
            }
        }
        let is_right = worst.as_ref().is_none_or(|worst| worst.units <= 1.0);
        if let Some((verdict, open)) = open.filter(|_| is_right) {
            return Judgement { verdict, worst: Some(open), compared: self.entries.len() };
        }
        let verdict = match &worst {
            None => Verdict::Undecided,
            Some(worst) if worst.units > 1.0 => Verdict::Wrong,
            Some(_) if coarse => Verdict::IllConditioned,
            Some(_) => Verdict::Pass,
        };
        Judgement { verdict, worst, compared: self.entries.len() }
    }

    /// Every mistake: those of single entries, and those that it knows besides.
    pub fn all_mistakes(&self) -> Vec<Change> {
        let mut found = Vec::new();
        for (i, entry) in self.entries.iter().enumerate().filter(|(_, entry)| entry.sides.is_none()) {
            let of_entry = of_number(entry.got, entry.scale);
            found.extend(of_entry.map(|(mistake, x)| Change { mistake, changes: vec![(i, x)] }));
        }
        found.extend(self.mistakes.iter().cloned());
        found
    }

    /// Judges the numbers, with mutants of them where `proves`, and says why where they are wrong.
    pub fn check(&self, nearness: f64, proves: bool, state: &str, case: Option<&Case>) -> Check {
        self.check_against(Oracle::WideDifferences, nearness, proves, state, case)
    }

    /// The same, where what the numbers must be is what an oracle says.
    pub(super) fn check_against(
        &self,
        oracle: Oracle,
        nearness: f64,
        proves: bool,
        state: &str,
        case: Option<&Case>,
    ) -> Check {
        if let Some(why) = &self.undecided {
            let mut check = Check::new(Some(self.quantity), Against::Oracle(oracle));
            check.add_undecided(why, state);
            return check;
        }
        let judgement = self.judge();
        // A check that speaks has proved that it can; mutants are made of right numbers.
        let proves = proves && nearness > 0.0 && !judgement.verdict.is_mismatch();
        let score = if proves { self.try_mistakes(&self.all_mistakes()) } else { Score::default() };
        let mut check = Check::new(Some(self.quantity), Against::Oracle(oracle));
        check.add_at(judgement, score, state, case);
        check.name_stage(|| Some(self.quantity.name()));
        if check.verdict == Verdict::Wrong {
            check.diagnosis = diagnose_sheet(self).map(Box::new);
        }
        check
    }

    /// Tries mistakes on the same comparison.
    pub fn try_mistakes(&self, mistakes: &[Change]) -> Score {
        let mut score = Score::default();
        let (mut missed, mut smallest) = (0.0_f64, f64::INFINITY);
        let wanted: Vec<Wanted> = self.entries.iter().map(|entry| entry.want.into()).collect();
        for Change { mistake, changes } in mistakes {
            let noticed = changes.iter().any(|(i, x)| match (self.entries.get(*i), wanted.get(*i)) {
                (Some(entry), _) if entry.sides.is_some() => {
                    units(*x, entry.target(*x), self.tolerance(*i)) > 1.0
                }
                (_, Some(want)) => want.units(*x, self.tolerance(*i)) > 1.0,
                _ => false,
            });
            let change = |(i, x): &(usize, f64)| {
                let moved = self.entries.get(*i).map_or(0.0, |entry| (x - entry.got).abs());
                if moved == 0.0 { 0.0 } else { moved / self.tolerance(*i) }
            };
            if let (Mistake::Scaled(delta), Some((i, _))) = (mistake, changes.first())
                && let Some(entry) = self.entries.get(*i)
            {
                smallest = smallest.min(*delta);
                if !noticed && entry.got.abs() >= SIGNIFICANT * entry.scale {
                    missed = missed.max(*delta);
                }
            }
            let entry = changes.first().and_then(|(i, _)| self.entries.get(*i));
            let change = || changes.iter().map(change).fold(0.0_f64, f64::max);
            score.count(*mistake, noticed, change, || entry.map(|e| e.name.clone()).unwrap_or_default());
        }
        if smallest.is_finite() {
            score.detectable_at.push(if missed > 0.0 { missed * 10.0 } else { smallest });
        }
        score
    }
}
