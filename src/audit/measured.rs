//! Values and rows of one state against 237 bits, without mutants: what a sweep over very many states asks of each that it judges.

use crate::candidate::Given;
use crate::case::Case;
use crate::case::quantity::{Numbers, Quantity};
use crate::judge::components::{Exact, Surroundings};
use crate::judge::examined::{Examined, Trusted};
use crate::judge::verdict::{Finding, Verdict};
use crate::oracles::oracle::{Answer, Oracle, WideAnswers};
use crate::oracles::truth::Truth;
use std::cell::LazyCell;

/// What is measured of numbers of one quantity at one state.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The verdict on them.
    pub verdict: Verdict,
    /// The entries compared.
    pub compared: u64,
    /// The entry that decided it, or that came nearest to its tolerance.
    pub worst: Option<Finding>,
}

/// One state that is known on 237 bits.
#[derive(Clone, Debug)]
pub struct AgainstTruth {
    /// min(1, distance to the nearest singular set), in radians and lengths of the connector.
    pub nearness: f64,
    /// Values and rows.
    pub found: [Measured; 2],
}

/// Judges values and rows at the end of a case against differences on 237 bits, by the bound of the audit.
///
/// Two things differ from [`crate::audit_case`]. The bound rests on derivatives by dual numbers on 237 bits, where the audit's rests on
/// differences off the singular sets. They are equal to far below rounding, and second differences cost most of the time. And no referee
/// excuses what is wrong by what another oracle says. `None` for an empty path.
pub fn against_truth(case: &Case, numbers: &Numbers<f64>) -> Option<AgainstTruth> {
    judged(case, numbers, false)
}

/// The same of somebody else's routine, by the bound of others. What it does not give is not judged.
pub fn others_against_truth(case: &Case, given: &Given) -> Option<AgainstTruth> {
    judged(case, given.numbers(), true)
}

fn judged(case: &Case, numbers: &Numbers<f64>, is_of_others: bool) -> Option<AgainstTruth> {
    let end = case.at_end()?;
    let truth = Truth::at(&end);
    let nearness = truth.nearness_of_components();
    let dual = truth.dual_functions();
    let mut trusted = Numbers::default();
    for quantity in [Quantity::Value, Quantity::FirstDerivatives, Quantity::SecondDerivatives] {
        trusted.set(quantity, dual.entries(quantity).map(|_, _, x| x.to_f64()));
    }
    let examined = Examined::new(&end, numbers, Trusted::Wide(trusted), &nearness);
    let (examined, sides) = examined.on_sets(Some(&truth));
    let examined = if is_of_others { examined.of_others() } else { examined };
    let bound = &examined.bound;
    let answers = LazyCell::new(|| WideAnswers::of(&truth));
    let exact = |quantity: Quantity| Some(Exact::of(&answers, quantity));
    let around =
        Surroundings { exact: Some(&exact), ..Surroundings::of(case, &truth, bound, sides.as_ref()) };
    let measured = |quantity: Quantity, answer: Answer| {
        let answer = answer.with_error_of(&truth, quantity, bound);
        let check = examined.check_wide(quantity, &answer, &around, (None, false));
        Measured { verdict: check.verdict, compared: check.compared, worst: check.worst }
    };
    let found = [
        measured(Quantity::Value, Answer::sharp(Oracle::WideDifferences, &truth.value())),
        measured(Quantity::FirstDerivatives, Answer::sharp(Oracle::WideDifferences, &truth.first())),
    ];
    Some(AgainstTruth { nearness: truth.nearness(), found })
}
