//! The judge of single numbers, wherever they stand: which of them decides, and which mistakes in them would have been noticed.

use crate::case::quantity::Quantity;
use crate::judge::conditioned::NOTICED;
use crate::judge::verdict::{Finding, Score, Verdict, Wanted};
use crate::mutants::mutant::Mistake;
use crate::singular::sides::Sides;

/// Beyond this fraction of a row's largest entry, a tolerance lets errors through that matter: the point is called
/// ill-conditioned.
pub(super) const COARSE: f64 = 1e-6;

/// What is formed of derivatives that do not exist.
const HIGHER: &str = "on a singular set values and one-sided first derivatives exist at most: what is formed of others is judged by nobody";

/// One number, what it must be, and what is known of the state that it is of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judged<'a> {
    pub(super) quantity: Quantity,
    pub(super) got: f64,
    /// What it must be; on a kink, what is nearest to it of what may stand there.
    pub(super) want: Wanted,
    /// How far it may be from that.
    pub(super) allowed: f64,
    /// Of a derivative whose two sides differ: these.
    pub(super) sides: Option<&'a Sides>,
    /// Whether its component is on a singular set, and nobody has looked at its sides.
    pub(super) is_open: bool,
    /// Whether it is formed of numbers beyond the range of doubles.
    pub(super) overflows: bool,
    /// Why nothing determines what it must be.
    pub(super) undetermined: Option<&'static str>,
}

impl Judged<'_> {
    fn units(&self) -> f64 {
        self.want.units(self.got, self.allowed)
    }

    /// The verdict on it by itself, and at a singular point what is lacking.
    ///
    /// A component that is not on a singular set is judged as everywhere, whatever the others of its connector do. On one, a value
    /// exists, and of derivatives what their sides show. Nothing is decided where what is allowed, or what it must be, is no number: what
    /// is not finite there is no error of a formula, and anywhere else it is invalid.
    fn verdict(&self) -> (Verdict, Option<&'static str>) {
        let want = self.want.to_f64();
        let exists = matches!(self.quantity, Quantity::Value | Quantity::FirstDerivatives);
        if !self.got.is_finite() {
            return (if self.overflows { Verdict::Undecided } else { Verdict::Invalid }, None);
        }
        match decided(want, self.allowed, self.units()) {
            Verdict::Pass => match self.sides.map(Sides::lack) {
                None => (Verdict::Pass, None),
                Some(None) => (Verdict::Kink, None),
                Some(lack) => (Verdict::Singular, lack),
            },
            _ if self.is_open && !(exists && want.is_finite()) => (Verdict::Singular, Some(HIGHER)),
            Verdict::Wrong if self.undetermined.is_some() => (Verdict::Singular, self.undetermined),
            other => (other, None),
        }
    }

    /// What is said of it, by its name and, of a connector, its component and place.
    pub(super) fn finding(&self, entry: String, at: Option<(usize, usize)>) -> Finding {
        Finding {
            at,
            one_sided: self.sides.and_then(Sides::to_f64),
            lack: self.verdict().1,
            ..Finding::new(entry, [self.got, self.want.to_f64()], self.allowed, self.units())
        }
    }
}

/// Many numbers, each judged by itself: the severest verdict decides.
#[derive(Default)]
pub(super) struct Judge {
    /// The number that decides, by the severity of its verdict, and how clearly: the width of a kink, or the error in units.
    worst: Option<(Verdict, f64, Finding)>,
    pub(super) compared: usize,
}

impl Judge {
    /// Judges a number, whose finding `tell` writes.
    pub(super) fn see(&mut self, number: &Judged<'_>, tell: impl FnOnce() -> Finding) {
        self.compared += 1;
        let (verdict, _) = number.verdict();
        let is_open = matches!(verdict, Verdict::Kink | Verdict::Singular);
        let clearly = number.sides.filter(|_| is_open).map_or_else(|| number.units(), Sides::gap);
        let is_worse = |(most, least, _): &(Verdict, f64, Finding)| {
            verdict > *most || verdict == *most && clearly > *least
        };
        if self.worst.as_ref().is_none_or(is_worse) {
            self.worst = Some((verdict, clearly, tell()));
        }
    }

    /// The verdict, and the number that decided it; undecided without any.
    pub(super) fn severest(self) -> (Verdict, Option<Finding>) {
        self.worst.map_or((Verdict::Undecided, None), |(verdict, _, worst)| (verdict, Some(worst)))
    }
}

/// The verdict on a number that is so many units of what is allowed from what it must be, wherever numbers are judged. Without a
/// finite tolerance, or anything finite to compare with, as where numbers overflow, nothing is decided.
pub fn decided(want: f64, allowed: f64, units: f64) -> Verdict {
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
pub fn moved_by(moved: f64, allowed: f64) -> f64 {
    if moved < f64::MIN_POSITIVE {
        0.0
    } else if allowed.is_finite() {
        moved / allowed
    } else {
        1.0
    }
}

/// Entries smaller than this part of the largest of their row, in units of the degrees of freedom, do not count for the smallest
/// error that is noticed. What is left of a cancellation has no relative error of its own.
pub const SIGNIFICANT: f64 = 1e-3;

/// Mistakes that are tried on one comparison.
pub struct Trials {
    score: Score,
    /// The smallest relative error that was tried, and the largest that was missed.
    tried: f64,
    missed: f64,
}

impl Default for Trials {
    fn default() -> Self {
        Self { score: Score::default(), tried: f64::INFINITY, missed: 0.0 }
    }
}

impl Trials {
    /// A relative error that was tried; what is not `significant` may be missed.
    pub fn see(&mut self, delta: f64, noticed: bool, significant: bool) {
        self.tried = self.tried.min(delta);
        if !noticed && significant {
            self.missed = self.missed.max(delta);
        }
    }

    /// A mistake in an entry of that name, which it changes by so many tolerances; of a relative error `is_significant` says whether
    /// the entry is. A relative error of [`NOTICED`] must be noticed wherever that `is_demanded`, whatever is allowed.
    pub fn add(
        &mut self,
        mistake: Mistake,
        noticed: bool,
        (is_significant, is_demanded): (impl FnOnce() -> bool, impl FnOnce() -> bool),
        change: impl FnOnce() -> f64,
        entry: impl FnOnce() -> String,
    ) {
        let mut is_noticeable = false;
        if let Mistake::Scaled(delta) = mistake {
            self.see(delta, noticed, is_significant());
            is_noticeable = delta >= NOTICED;
        }
        let change = || match change() {
            small if small > 0.0 && small < 2.0 && is_noticeable && is_demanded() => f64::INFINITY,
            change => change,
        };
        self.score.count(mistake, noticed, change, entry);
    }

    /// How the mistakes fared. The smallest relative error from which on every one was noticed is told where any was tried: the steps are
    /// tenfold.
    pub fn score(self) -> Score {
        let Self { mut score, tried, missed } = self;
        if tried.is_finite() {
            score.detectable_at.push(if missed > 0.0 { missed * 10.0 } else { tried });
        }
        score
    }
}
