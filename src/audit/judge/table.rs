//! Numbers in a list, each with what it must be and its conditioned scale: for what is not laid out by the components of a
//! connector.

use crate::case::Case;
use crate::case::quantity::Quantity;
use crate::judge::bound::C;
use crate::judge::comparison::{Compared, Comparison};
use crate::judge::judged::{COARSE, Judge, Judged, SIGNIFICANT, Trials, moved_by};
use crate::judge::outcome::{Against, Check};
use crate::judge::verdict::{Finding, Judgement, Score, Verdict, Wanted, units};
use crate::mutants::diagnosis::{Hypothesis, diagnose_table};
use crate::mutants::mutant::{Mutant, of_number};
use crate::oracles::oracle::Oracle;
use crate::singular::sides::Sides;
use pintle_kinematics::scalar::{U, Wide};

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
    /// Whether a relative error of a billionth must be noticed on it, whatever is allowed: a significant entry where nothing is
    /// ill-conditioned.
    pub is_demanded: bool,
}

impl Entry {
    /// A number that has a reference without an error of its own.
    pub const fn new(name: String, got: f64, want: Wide, scale: f64, class: (usize, usize, usize)) -> Self {
        Self { name, got, want, scale, class, error: 0.0, sides: None, is_demanded: false }
    }

    /// C u times the conditioned scale, and the error of the reference. On a kink what is on either side of it is rounded, too.
    pub fn tolerance(&self) -> f64 {
        let sizes = self.sides.iter().filter(|sides| sides.exist == [true; 2]);
        let sides = sizes.flat_map(|sides| sides.quotients).map(|x| x.to_f64().abs());
        C * U * sides.fold(self.scale, f64::max) + self.error
    }

    /// What a number must be: on a kink, what is nearest to it of what may stand there.
    pub(crate) fn target(&self, got: f64) -> Wide {
        self.sides.map_or(self.want, |sides| sides.nearest(got))
    }
}

/// The numbers of one quantity at one state, row by row. Whoever has numbers of their own puts them into `got` of the entries, and
/// [`ResultTable::check`] judges those.
#[derive(Clone, Debug)]
pub struct ResultTable {
    /// What they are.
    pub quantity: Quantity,
    /// The rows, as sentences name them: `∂ρ1`.
    pub rows: Vec<String>,
    /// What the entries of a row are derivatives by: `θS2`; nothing where a row is one number, or a matrix.
    pub columns: Vec<String>,
    /// The numbers: all of the first row, all of the second …
    pub entries: Vec<Entry>,
    /// Mistakes of more than a single entry, made in the right numbers.
    pub mistakes: Vec<Mutant>,
    /// Other conventions than expected, in the right numbers, which are tried where numbers are wrong.
    pub conventions: Vec<Hypothesis>,
    /// Why nobody can say what the numbers must be, of a table without any.
    pub undecided: Option<String>,
}

impl ResultTable {
    /// A table without numbers.
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

    /// A table of numbers whose witness has no answer.
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

    /// Judges every number by itself: the severest verdict is that of the table. A tolerance that lets errors through which matter makes
    /// the point ill-conditioned, on a kink too.
    pub fn judge(&self) -> Judgement {
        let mut found = Judge::default();
        let mut coarse: Option<(f64, Finding)> = None;
        let sizes =
            self.entries.iter().map(|entry| entry.got.abs().max(entry.sides.map_or(0.0, |of| of.gap())));
        let largest = sizes.fold(0.0_f64, f64::max);
        for entry in &self.entries {
            let want = Wanted::from(entry.target(entry.got));
            let number = Judged {
                quantity: self.quantity,
                got: entry.got,
                want,
                allowed: entry.tolerance(),
                sides: entry.sides.as_ref(),
                is_open: false,
                overflows: want.to_f64().is_infinite(),
                undetermined: None,
            };
            let finding = || number.finding(entry.name.clone(), None);
            let allowed = C * U * entry.scale;
            let is_coarse = self.quantity != Quantity::Value && largest > 0.0 && allowed > COARSE * largest;
            if is_coarse && coarse.as_ref().is_none_or(|(most, _)| allowed > *most) {
                coarse = Some((allowed, finding()));
            }
            found.see(&number, finding);
        }
        let compared = found.compared;
        match (found.severest(), coarse) {
            ((Verdict::Pass | Verdict::Kink, _), Some((_, finding))) => {
                Judgement { verdict: Verdict::IllConditioned, worst: Some(finding), compared }
            }
            ((verdict, worst), _) => Judgement { verdict, worst, compared },
        }
    }

    /// The numbers beside what they must be.
    pub(crate) fn comparison(&self) -> Comparison {
        let compared = |entry: &Entry| {
            let tolerance = entry.tolerance();
            let units = units(entry.got, entry.want, tolerance);
            Compared { got: entry.got, want: entry.want.to_f64(), tolerance, units }
        };
        let name = |row: &String| row.trim_start_matches('∂').to_string();
        let entries = self.entries.chunks(self.width());
        let rows = self.rows.iter().map(name).zip(entries.map(|row| row.iter().map(compared).collect()));
        Comparison { columns: self.columns.clone(), rows: rows.collect() }
    }

    /// Every mistake: those of single entries, and those that it knows besides.
    pub fn all_mistakes(&self) -> Vec<Mutant> {
        let (mut found, width) = (Vec::new(), self.width());
        for (i, entry) in self.entries.iter().enumerate().filter(|(_, entry)| entry.sides.is_none()) {
            let of_entry = of_number(entry.got, entry.scale);
            let of_entry = of_entry.map(|(mistake, x)| Mutant::of_entry(mistake, i / width, i % width, x));
            found.extend(of_entry);
        }
        found.extend(self.mistakes.iter().cloned());
        found
    }

    /// Judges the numbers, with mutants of them where `proves`, and says why where they are wrong.
    pub fn check(&self, proves: bool, state: &str, case: Option<&Case>) -> Check {
        self.check_against(Oracle::WideDifferences, proves, state, case)
    }

    /// The same, where what the numbers must be is what an oracle says.
    pub fn check_against(&self, oracle: Oracle, proves: bool, state: &str, case: Option<&Case>) -> Check {
        if let Some(why) = &self.undecided {
            let mut check = Check::new(Some(self.quantity), Against::Oracle(oracle));
            check.add_undecided(why, state);
            return check;
        }
        let judgement = self.judge();
        // A check that speaks has proved that it can; mutants are made of right numbers.
        let proves = proves && !judgement.verdict.is_mismatch();
        let score =
            if proves { self.try_mistakes_of(oracle, &self.all_mistakes()) } else { Score::default() };
        let mut check = Check::new(Some(self.quantity), Against::Oracle(oracle));
        check.add_at(judgement, score, state, case);
        check.name_stage(|| Some(self.quantity.name()));
        if check.verdict == Verdict::Wrong {
            check.diagnosis = diagnose_table(self).map(Box::new);
            if self.quantity == Quantity::FirstDerivatives {
                check.comparison = Some(Box::new(self.comparison()));
            }
        }
        check
    }

    /// Tries mistakes on the same comparison.
    pub fn try_mistakes(&self, mistakes: &[Mutant]) -> Score {
        self.try_mistakes_of(Oracle::WideDifferences, mistakes)
    }

    /// The same where what the numbers must be is what an oracle says. What has two sides is left as it is: it has no single number that
    /// a mistake could spoil. By an oracle on 237 bits a relative error of [`NOTICED`] must be noticed wherever that is demanded.
    fn try_mistakes_of(&self, oracle: Oracle, mistakes: &[Mutant]) -> Score {
        let mut trials = Trials::default();
        let wanted: Vec<Wanted> = self.entries.iter().map(|entry| entry.want.into()).collect();
        let width = self.width();
        for Mutant { mistake, changes } in mistakes {
            let changes = || {
                let at = |(row, i, x): &(usize, usize, f64)| {
                    let place = row * width + i;
                    Some((*x, self.entries.get(place)?, wanted.get(place)?))
                };
                changes.iter().filter_map(at).filter(|(_, entry, _)| entry.sides.is_none())
            };
            let Some((_, first, _)) = changes().next() else { continue };
            let noticed = changes().any(|(x, entry, want)| want.units(x, entry.tolerance()) > 1.0);
            let is_significant = || first.got.abs() >= SIGNIFICANT * first.scale;
            let is_demanded = || first.is_demanded && oracle.is_wide();
            let change = || {
                let of = |(x, entry, _): (f64, &Entry, _)| moved_by((x - entry.got).abs(), entry.tolerance());
                changes().map(of).fold(0.0, f64::max)
            };
            let name = || first.name.clone();
            trials.add(*mistake, noticed, (is_significant, is_demanded), change, name);
        }
        trials.score()
    }
}
