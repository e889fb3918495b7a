//! Numbers in a list, each with what it must be and its conditioned scale: for what is not laid out by the components of a
//! connector.

use super::bound::{C, U};
use super::mutant::{LADDER, Mistake, NOTHING};
use super::quantity::Quantity;
use super::verdict::{COARSE, Finding, Judgement, SIGNIFICANT, Score, Verdict, units};
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
    /// How far what it must be may be off by itself; on top of the tolerance.
    pub error: f64,
    /// On a kink: the derivatives from below and from above. Any number between them may stand for the derivative there.
    pub sides: Option<[Wide; 2]>,
}

impl Entry {
    /// A number that has a reference without an error of its own.
    pub const fn new(name: String, got: f64, want: Wide, scale: f64) -> Self {
        Self { name, got, want, scale, error: 0.0, sides: None }
    }

    /// What a number must be: on a kink, what of the interval between both derivatives is nearest to it.
    fn target(&self, got: f64) -> Wide {
        let Some([below, above]) = self.sides else { return self.want };
        let got = Wide::from_f64(got);
        let (low, high) = if below < above { (below, above) } else { (above, below) };
        if got < low {
            low
        } else if got > high {
            high
        } else {
            got
        }
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
        self.entries.get(i).map_or(0.0, |entry| C * U * entry.scale + entry.error)
    }

    /// Judges every number; `nearness` is 0 on a singular set.
    pub fn judge(&self, nearness: f64) -> Judgement {
        let mut worst: Option<Finding> = None;
        let largest = self.entries.iter().fold(0.0_f64, |most, entry| most.max(entry.got.abs()));
        let mut coarse = false;
        let mut kink: Option<Finding> = None;
        for (i, entry) in self.entries.iter().enumerate() {
            let Entry { name, got, scale, sides, .. } = entry;
            let (tolerance, want) = (self.tolerance(i), entry.target(*got));
            let units = units(*got, want, tolerance);
            coarse |= self.quantity != Quantity::Value && largest > 0.0 && C * U * scale > COARSE * largest;
            let one_sided = sides.map(|sides| sides.map(|side| side.to_f64()));
            let found = || {
                let (entry, want) = (name.clone(), want.to_f64());
                Finding { entry, at: None, got: *got, want, tolerance, units, one_sided }
            };
            let is_worse = worst.as_ref().is_none_or(|worst| units > worst.units || !got.is_finite());
            if kink.is_none() && sides.is_some() {
                kink = Some(found());
            }
            if is_worse {
                worst = Some(found());
            }
            if !got.is_finite() {
                return Judgement { verdict: Verdict::Invalid, worst, compared: self.entries.len() };
            }
        }
        if let (Some(kink), Some(true)) = (kink, worst.as_ref().map(|worst| worst.units <= 1.0)) {
            return Judgement { verdict: Verdict::Kink, worst: Some(kink), compared: self.entries.len() };
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
        for (i, entry) in self.entries.iter().enumerate().filter(|(_, entry)| entry.sides.is_none()) {
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
        for Change { mistake, changes } in mistakes {
            let (mut change, mut noticed) = (0.0_f64, false);
            for (i, x) in changes {
                let Some(entry) = self.entries.get(*i) else { continue };
                let tolerance = self.tolerance(*i);
                let moved = (x - entry.got).abs();
                change = change.max(if moved == 0.0 { 0.0 } else { moved / tolerance });
                noticed |= units(*x, entry.target(*x), tolerance) > 1.0;
            }
            if let (Mistake::Scaled(delta), Some((i, _))) = (mistake, changes.first())
                && let Some(entry) = self.entries.get(*i)
            {
                smallest = smallest.min(*delta);
                if !noticed && entry.got.abs() >= SIGNIFICANT * entry.scale {
                    missed = missed.max(*delta);
                }
            }
            let entry = changes.first().and_then(|(i, _)| self.entries.get(*i));
            score.count(*mistake, noticed, change, || entry.map(|e| e.name.clone()).unwrap_or_default());
        }
        if smallest.is_finite() {
            score.detectable_at.push(if missed > 0.0 { missed * 10.0 } else { smallest });
        }
        score
    }
}
