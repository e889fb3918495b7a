//! Numbers in a list, each with what it must be and its conditioned scale: for what is not laid out by the components of a
//! connector.

use super::bound::{C, U};
use super::mutant::{LADDER, Mistake, NOTHING};
use super::quantity::Quantity;
use super::verdict::{COARSE, Finding, Judgement, SIGNIFICANT, Score, Verdict, Wanted, units};
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
}

/// One mistake made once: the places that it changes, with the changed numbers.
#[derive(Clone, Debug)]
pub struct Change {
    /// The mistake.
    pub mistake: Mistake,
    /// (place in the sheet, changed number).
    pub changes: Vec<(usize, f64)>,
}

/// The numbers of one quantity at one state.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// What they are.
    pub quantity: Quantity,
    /// The numbers.
    pub entries: Vec<Entry>,
}

impl Sheet {
    fn tolerance(&self, i: usize) -> f64 {
        self.entries.get(i).map_or(0.0, |entry| C * U * entry.scale)
    }

    /// Judges every number; `nearness` is 0 on a singular set.
    pub fn judge(&self, nearness: f64) -> Judgement {
        let mut worst: Option<Finding> = None;
        let largest = self.entries.iter().fold(0.0_f64, |most, entry| most.max(entry.got.abs()));
        let mut coarse = false;
        for (i, Entry { name, got, want, .. }) in self.entries.iter().enumerate() {
            let tolerance = self.tolerance(i);
            let units = units(*got, *want, tolerance);
            coarse |= self.quantity != Quantity::Value && largest > 0.0 && tolerance > COARSE * largest;
            let is_worse = worst.as_ref().is_none_or(|worst| units > worst.units || !got.is_finite());
            if is_worse {
                worst = Some(Finding {
                    entry: name.clone(),
                    at: None,
                    got: *got,
                    want: want.to_f64(),
                    tolerance,
                    units,
                    one_sided: None,
                });
            }
            if !got.is_finite() {
                return Judgement { verdict: Verdict::Invalid, worst, compared: self.entries.len() };
            }
        }
        let verdict = match &worst {
            None => Verdict::Undecided,
            Some(worst) if worst.units > 1.0 && nearness == 0.0 => Verdict::Kink,
            Some(worst) if worst.units > 1.0 => Verdict::Wrong,
            Some(_) if coarse => Verdict::IllConditioned,
            Some(_) => Verdict::Pass,
        };
        Judgement { verdict, worst, compared: self.entries.len() }
    }

    /// The mistakes that can be made in single entries.
    pub fn mistakes(&self) -> Vec<Change> {
        let mut found = Vec::new();
        for (i, entry) in self.entries.iter().enumerate() {
            let x = entry.got;
            let mut one = |mistake, x| found.push(Change { mistake, changes: vec![(i, x)] });
            if x.abs() <= NOTHING * entry.scale {
                one(Mistake::Spurious, x + 1e-3 * entry.scale);
            }
            if x == 0.0 {
                continue;
            }
            one(Mistake::Dropped, 0.0);
            one(Mistake::Sign, -x);
            for delta in LADDER {
                one(Mistake::Scaled(delta), x * (1.0 + delta));
            }
        }
        found
    }

    /// Tries mistakes on the same comparison.
    pub fn try_mistakes(&self, mistakes: &[Change]) -> Score {
        let mut score = Score::default();
        let (mut missed, mut smallest) = (0.0_f64, f64::INFINITY);
        let wanted: Vec<Wanted> = self.entries.iter().map(|entry| entry.want.into()).collect();
        for Change { mistake, changes } in mistakes {
            let noticed = changes.iter().any(|(i, x)| {
                let want = wanted.get(*i);
                want.is_some_and(|want| want.units(*x, self.tolerance(*i)) > 1.0)
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
