//! Numbers at the end of a case, the product's or another's, compared with what an oracle says.
//!
//! A comparison gives the verdict, the mutants that prove that it would have spoken, and the reason where numbers are wrong.

use crate::case::quantity::{Numbers, Quantity};
use crate::case::stage::{invalid_stage, is_state};
use crate::case::{AtEnd, Case};
use crate::judge::bound::Bound;
use crate::judge::components::{Surroundings, judge, try_mutants};
use crate::judge::conditioned::Conditioned;
use crate::judge::outcome::{Against, Check};
use crate::judge::verdict::{Score, Verdict, Wanted};
use crate::laws as invariant;
use crate::laws::Demand;
use crate::mutants::diagnosis::{Places, Symptoms, places};
use crate::mutants::mutant::{self, Mutant, mutants};
use crate::oracles::oracle::Answer;
use crate::oracles::referee::Referee;
use crate::oracles::truth::Truth;
use crate::singular::sides::Sides;
use pintle_kinematics::connector::State;
use pintle_kinematics::measure::Unit;
use std::cell::OnceCell;

/// What the tolerances rest on.
pub enum Trusted {
    /// Numbers of 237 bits.
    Wide(Numbers<f64>),
    /// Other numbers than those that are judged.
    Others(Numbers<f64>),
    /// The numbers that are judged.
    Own,
}

/// Numbers at the end of a case.
pub struct Examined<'a> {
    pub(crate) case: &'a Case,
    pub(crate) numbers: &'a Numbers<f64>,
    /// What the bound rests on, as numbers.
    pub(super) trusted: Numbers<f64>,
    pub(crate) bound: Bound,
    /// The units of the components, where there is one.
    pub units: [Option<Unit>; 6],
    /// Which components are on no singular set.
    pub is_smooth: [bool; 6],
    state: &'a State<f64>,
    is_own: bool,
    /// How far the state is from special ones, of numbers of somebody else's routine.
    places: Option<Places>,
    conditioned: Conditioned,
    turns: [f64; 6],
    /// Whether a displacement counts from an origin that rounding decided.
    counts_from_rounding: bool,
    /// Every mistake in a quantity, once it is asked for.
    made: [OnceCell<Vec<Mutant>>; Quantity::ALL.len()],
}

impl<'a> Examined<'a> {
    /// At the end of a case; `nearness` is that of each component.
    pub fn new(end: &AtEnd<'a>, numbers: &'a Numbers<f64>, trusted: Trusted, nearness: &[f64; 6]) -> Self {
        let AtEnd { case, step, connector, after, .. } = end;
        let (is_wide, is_own) = (matches!(trusted, Trusted::Wide(_)), matches!(trusted, Trusted::Own));
        let trusted = match trusted {
            Trusted::Wide(numbers) | Trusted::Others(numbers) => numbers,
            Trusted::Own => numbers.clone(),
        };
        let bound = Bound::of_components(&trusted, &step.state, case.length, nearness);
        let units = std::array::from_fn(|k| connector.differentiated(k).map(|measure| measure.unit()));
        Self {
            case,
            numbers,
            conditioned: Conditioned::new(&trusted, case, &units, nearness),
            trusted,
            // What follows from a state that is no state is invalid.
            bound: bound.of_wide(is_wide && is_state(&step.state)),
            units,
            is_smooth: nearness.map(|near| near > 0.0),
            state: &step.state,
            is_own,
            places: None,
            turns: after.turns.map(|turns| turns.turns),
            counts_from_rounding: end.undetermined_origins().iter().any(Option::is_some),
            made: Default::default(),
        }
    }

    /// The same, and what is on the sides of the singular sets that the state is on, as it is known on 237 bits. Tolerances of
    /// components on one rest on the steepest of that. At the set itself the row is the one of least norm, as that of a flexion is
    /// zero, and rounding moves the value along the others all the same.
    pub fn on_sets(mut self, truth: Option<&Truth>) -> (Self, Option<Numbers<Sides>>) {
        let Some(truth) = truth.filter(|truth| truth.nearness() == 0.0) else { return (self, None) };
        let sides = truth.sides(&self.bound);
        let mut steepest = self.trusted.clone();
        for quantity in [Quantity::FirstDerivatives, Quantity::NodalForces] {
            let of_sides = sides.entries(quantity);
            let rows = steepest.entries(quantity).map(|k, i, row| {
                let sides = of_sides.get(k, i).filter(|_| !self.is_smooth[k]);
                sides.map_or(row, |sides| sides.steepest(row))
            });
            steepest.set(quantity, rows);
        }
        let nearness = truth.nearness_of_components();
        let bound = Bound::of_components(&steepest, self.state, self.case.length, &nearness);
        self.bound = bound.of_wide(is_state(self.state));
        (self, Some(sides))
    }

    /// The same with the tolerances of somebody else's routine.
    pub(crate) fn of_others(self) -> Self {
        let bound = self.bound.of_others(self.state);
        Self { bound, places: Some(places(self.case)), ..self }
    }

    /// Every mistake in a quantity, of components that are on no singular set.
    pub fn mutants(&self, quantity: Quantity) -> &[Mutant] {
        self.made[quantity as usize].get_or_init(|| {
            let Self { case, numbers, units, turns, bound, .. } = self;
            let scale = |k: usize, i: usize| bound.scale(quantity, k, i);
            let scene = mutant::Scene { numbers, case, units: *units, turns: *turns, scale: &scale };
            let mut made = mutants(quantity, &scene);
            made.retain(|mutant| mutant.changes.iter().all(|(k, ..)| self.is_smooth[*k]));
            made
        })
    }

    /// Whether a comparison with an answer would have noticed them.
    pub fn score(&self, quantity: Quantity, answer: &Answer) -> Score {
        let size = |i: usize| quantity.entry_size(i, self.case.length);
        let got = self.numbers.entries(quantity);
        let sizes: (&dyn Fn(usize) -> f64, _) = (&size, &self.conditioned);
        try_mutants(quantity, got, answer, &self.bound, sizes, self.mutants(quantity))
    }

    /// Whether a law would have noticed them.
    pub fn score_of_law(&self, quantity: Quantity, demands: &[Demand]) -> Score {
        let size = |quantity: Quantity, i: usize| quantity.entry_size(i, self.case.length);
        let is_conditioned =
            |quantity: Quantity, k: usize, i: usize, x: f64| self.conditioned.demands(quantity, k, i, x);
        let made = self.mutants(quantity);
        invariant::try_mutants(quantity, self.numbers, demands, made, (&size, &is_conditioned))
    }

    /// Whether a component is right as a whole, and not zero.
    fn is_whole(&self, quantity: Quantity, k: usize) -> bool {
        let got = self.numbers.entries(quantity);
        let Some(want) = self.trusted.entries(quantity).0[k].as_deref() else { return false };
        let mut is_zero = true;
        for (i, want) in want.iter().enumerate() {
            let tolerance = self.bound.tolerance(quantity, k, i);
            if !got.get(k, i).is_some_and(|x| (x - want).abs() <= tolerance) {
                return false;
            }
            is_zero &= want.abs() <= tolerance;
        }
        !is_zero
    }

    /// The check of a quantity against an answer; with mutants where it `proves`. What the referee excuses is undecided.
    pub fn check(
        &self,
        quantity: Quantity,
        answer: &Answer,
        around: &Surroundings<'_>,
        (referee, proves): (Option<&Referee<'_>>, bool),
    ) -> Check {
        let got = self.numbers.entries(quantity);
        let mut check = Check::new(Some(quantity), Against::Oracle(answer.oracle));
        let mut judgement = judge(quantity, got, answer, around);
        if quantity == Quantity::Value && self.counts_from_rounding && judgement.verdict == Verdict::Pass {
            judgement.verdict = Verdict::IllConditioned;
        }
        let excuse =
            |referee: &Referee<'_>| referee.excuse_of(answer.oracle, &judgement, (quantity, got), around);
        if let Some(why) = referee.and_then(excuse) {
            check.add_excused(why, judgement.worst, judgement.compared as u64, &self.case.name);
            check.compares(|k| got.0[k].is_some(), |_| false);
            return check;
        }
        // A check that speaks has proved that it can; mutants are made of right numbers.
        let proves = proves && !judgement.verdict.is_mismatch();
        let score = if proves { self.score(quantity, answer) } else { Score::default() };
        check.add(judgement, score, self.case);
        check.compares(|k| got.0[k].is_some(), |k| answer.numbers.0[k].is_some());
        check.name_stage(|| invalid_stage(self.state, self.numbers));
        if let Some(places) = &self.places {
            let right = got.iter().filter_map(|(k, i, x)| {
                let want = self.trusted.entries(quantity).get(k, i)?;
                let tolerance = self.bound.tolerance(quantity, k, i);
                ((x - want).abs() <= tolerance).then_some((k, want, tolerance))
            });
            let is_number = matches!(quantity, Quantity::Value | Quantity::Rate | Quantity::Acceleration);
            check.has_seen(places, right.filter(|_| is_number), |k| self.is_whole(quantity, k));
        }
        if check.verdict.is_mismatch() {
            // Where the bound rests on what is wrong, what is right is what the oracle says.
            let told = self.is_own.then(|| {
                let mut told = self.trusted.clone();
                let of_oracle = |k, i, x| answer.numbers.get(k, i).map_or(x, Wanted::to_f64);
                told.set(quantity, got.map(of_oracle));
                told
            });
            let want = told.as_ref().unwrap_or(&self.trusted);
            let Self { case, bound, .. } = self;
            let rows = self.numbers.entries(Quantity::FirstDerivatives);
            check.explain(&Symptoms { quantity, got, rows, want, case, bound }, answer);
        }
        check
    }

    /// The check of a quantity against an answer on 237 bits, which has every entry: one that is missing is wrong.
    pub fn check_wide(
        &self,
        quantity: Quantity,
        answer: &Answer,
        around: &Surroundings<'_>,
        by: (Option<&Referee<'_>>, bool),
    ) -> Check {
        let mut check = self.check(quantity, answer, around, by);
        self.add_missing(&mut check, quantity, answer, |_| false);
        check
    }

    /// Adds to a check what is missing, but for entries of components that may be: the first of them.
    pub fn add_missing(
        &self,
        check: &mut Check,
        quantity: Quantity,
        answer: &Answer,
        may_lack: impl Fn(usize) -> bool,
    ) {
        let got = self.numbers.entries(quantity);
        let mut wanted = answer.numbers.iter().filter(|(k, ..)| !may_lack(*k));
        if let Some((k, i, _)) = wanted.find(|(k, i, _)| got.get(*k, *i).is_none()) {
            check.misplaced(format!("{} is missing", quantity.entry_name(k, i)), f64::NAN, self.case);
        }
    }
}
