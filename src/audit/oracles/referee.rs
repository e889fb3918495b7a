//! An oracle that shares elementary functions or the mechanism of derivatives with the product, as those on doubles do, does not
//! decide by itself that a number is wrong. Near singular sets it may have lost digits that the product keeps. What it calls wrong
//! is put before an independent oracle on 237 bits, if one was asked; where that passes the number, the oracle is undecided.

use crate::case::AtEnd;
use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::judge::components::{Surroundings, judge};
use crate::judge::outcome::Check;
use crate::judge::verdict::{Judgement, Verdict};
use crate::oracles::oracle::{Answer, Oracle};
use crate::oracles::truth::Truth;
use crate::settings::Settings;
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;

/// Why an oracle is undecided that others contradict.
pub const OVERRULED: &str = "it calls a number wrong that an independent oracle on 237 bits passes: what shares elementary functions \
     or derivatives with the product does not decide";

/// Why an oracle on doubles is undecided where nobody independent was asked.
const OUT_OF_RANGE: &str = "it calls a number wrong that it forms of powers of lengths which overflow or underflow doubles, and no independent \
     oracle on 237 bits was asked";

/// An independent oracle on 237 bits at the end of a case, asked where another one calls a number wrong.
pub struct Referee<'a> {
    end: &'a AtEnd<'a>,
    oracle: Option<Oracle>,
    known: Option<&'a Truth>,
    made: OnceCell<Truth>,
    /// What it said, by quantity.
    said: RefCell<BTreeMap<Quantity, bool>>,
}

impl<'a> Referee<'a> {
    /// At the end of a case, with the truth where it is known already.
    pub fn new(end: &'a AtEnd<'a>, settings: &Settings, known: Option<&'a Truth>) -> Self {
        let is_one = |oracle: &Oracle| {
            settings.oracles.contains(oracle)
                && oracle.is_independent()
                && oracle.answers(Quantity::FirstDerivatives)
        };
        let oracle = Oracle::ALL.into_iter().find(is_one);
        Self { end, oracle, known, made: OnceCell::new(), said: RefCell::default() }
    }

    fn truth(&self) -> &Truth {
        self.known.unwrap_or_else(|| self.made.get_or_init(|| Truth::at(self.end)))
    }

    fn answer(&self, quantity: Quantity, around: &Surroundings<'_>) -> Option<Answer> {
        let truth = self.truth();
        let oracle = self.oracle?;
        let numbers = match (oracle, quantity) {
            (Oracle::WideSymbolic, _) => truth.symbolic().entries(quantity).clone(),
            (_, Quantity::FirstDerivatives) => truth.first(),
            (_, Quantity::SecondDerivatives) => {
                let [second, _] = truth.second(false);
                second
            }
            _ => return None,
        };
        let answer = Answer::sharp(oracle, &numbers);
        Some(Answer { error: truth.own_error(quantity, around.bound), ..answer })
    }

    /// Whether what another oracle calls wrong is passed: always the same numbers of a quantity.
    pub(super) fn passes(&self, quantity: Quantity, got: &Entries<f64>, around: &Surroundings<'_>) -> bool {
        if let Some(said) = self.said.borrow().get(&quantity) {
            return *said;
        }
        let passes = self.answer(quantity, around).is_some_and(|answer| {
            let verdict = judge(quantity, got, &answer, around).verdict;
            !verdict.is_mismatch() && verdict != Verdict::Undecided
        });
        self.said.borrow_mut().insert(quantity, passes);
        passes
    }

    /// Why an oracle that calls numbers wrong does not decide: an independent one passes them, or there is none, and what it computes with
    /// leaves the range of doubles.
    fn excuse(
        &self,
        quantity: Quantity,
        got: &Entries<f64>,
        around: &Surroundings<'_>,
    ) -> Option<&'static str> {
        if self.oracle.is_none() {
            return self.end.case.is_out_of_range().then_some(OUT_OF_RANGE);
        }
        self.passes(quantity, got, around).then_some(OVERRULED)
    }

    /// The same of what any oracle says: one that is independent decides, and what is not finite is judged by nobody else.
    pub fn excuse_of(
        &self,
        oracle: Oracle,
        judgement: &Judgement,
        (quantity, got): (Quantity, &Entries<f64>),
        around: &Surroundings<'_>,
    ) -> Option<&'static str> {
        let verdict = judgement.verdict;
        let is_heard = !oracle.is_independent() && verdict.is_mismatch() && verdict != Verdict::Invalid;
        is_heard.then(|| self.excuse(quantity, got, around)).flatten()
    }

    /// The same of checks that were made apart: those that are excused become undecided.
    pub fn hears(
        &self,
        checks: &mut [Check],
        numbers: &Numbers<f64>,
        around: &Surroundings<'_>,
        state: &str,
    ) {
        for check in checks {
            let (Some(quantity), true) = (check.quantity, check.verdict == Verdict::Wrong) else { continue };
            if let Some(why) = self.excuse(quantity, numbers.entries(quantity), around) {
                *check = std::mem::replace(check, Check::new(None, check.against)).excused(why, state);
            }
        }
    }
}

impl Check {
    /// The check of a state at which an independent oracle passes what this one calls wrong.
    pub fn overruled(self, state: &str) -> Self {
        self.excused(OVERRULED, state)
    }

    fn excused(self, why: &'static str, state: &str) -> Self {
        let mut told = Self::new(self.quantity, self.against);
        told.add_excused(why, self.worst, self.compared, state);
        told
    }

    /// Adds a state at which an oracle calls numbers wrong, and does not decide.
    pub fn add_excused(
        &mut self,
        why: &'static str,
        worst: Option<crate::judge::verdict::Finding>,
        compared: u64,
        state: &str,
    ) {
        let compared = usize::try_from(compared).unwrap_or(usize::MAX);
        let judgement = Judgement { verdict: Verdict::Undecided, worst, compared };
        self.add_at(judgement, crate::judge::verdict::Score::default(), state, None);
        *self.undecided.entry(why.to_string()).or_default() += 1;
    }

    /// The verdict for the claim of a subject: that an oracle is overruled by an independent one leaves nothing open.
    pub fn claim(&self) -> Verdict {
        let overruled = self.undecided.get(OVERRULED).copied().unwrap_or(0);
        let open = self.states.get(&Verdict::Undecided).copied().unwrap_or(0);
        if self.verdict == Verdict::Undecided && open == overruled {
            let others = self.states.keys().filter(|verdict| **verdict != Verdict::Undecided);
            return others.max().copied().unwrap_or(Verdict::Pass);
        }
        self.verdict
    }
}
