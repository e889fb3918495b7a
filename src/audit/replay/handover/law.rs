//! A mismatch of a law as a test: which numbers of the state are added up, and which they must be equal to.

use crate::case::Case;
use crate::judge::bound::Bound;
use crate::laws::{Claim, Context, Demanded, Invariant, Term, exchanged_entry, turned_terms};
use crate::oracles::force::product_at;
use crate::oracles::oracle::Narrow;
use crate::replay::counterexample::{BrokenLaw, CounterExample};
use crate::replay::handover::ExportError;
use pintle_kinematics::catalog::Loading;

/// What of a connector is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Asked {
    /// Everything.
    Whole,
    /// One component.
    Alone(usize),
    /// Values and first derivatives.
    Rows,
}

/// Numbers of one evaluation, which are added up.
pub(super) struct Side {
    /// The state; none for that of the counter-example.
    pub(super) case: Option<Case>,
    pub(super) asked: Asked,
    pub(super) terms: Vec<Term>,
    /// The component whose velocity is added besides.
    pub(super) velocity: Option<usize>,
}

/// Two sums that must be equal.
pub(super) struct Equality {
    pub(super) got: Side,
    pub(super) want: Side,
    /// What is wanted besides.
    pub(super) constant: f64,
}

/// What a law demands that a counter-example breaks; `None` where it is of no law.
pub(super) fn law(example: &CounterExample, case: &Case) -> Result<Option<Equality>, ExportError> {
    let lost = |why: &str| Err(ExportError::Lost(format!("{}: {why}", example.against)));
    let Some(BrokenLaw { name: law, demanded }) = example.law else {
        return Ok(None);
    };
    match law {
        Invariant::Restored => {
            return lost(
                "what a history loses when it is saved is no number of a state; judge it by `pintle replay`",
            );
        }
        Invariant::Start | Invariant::Turns | Invariant::FreeAxis => {
            return lost("it is a law of a type, not of one state; `pintle audit` asks it of the type");
        }
        Invariant::Carried => {
            return lost("it is of a friction, which follows from more than a state; audit the scene again");
        }
        Invariant::RigidModes
        | Invariant::Frame
        | Invariant::Equilibrium
        | Invariant::Power
        | Invariant::Symmetry
        | Invariant::Sparsity
        | Invariant::NodeSwap
        | Invariant::Halves
        | Invariant::Restricted => {}
    }
    let Some(end) = case.at_end() else { return lost("it has no state") };
    let numbers = product_at(&end);
    let bound = Bound::new(&numbers, &end.step.state, case.length, Narrow::at(&end).nearness());
    let context = Context::at(end, &numbers, &bound);
    let all = context.demands(law);
    let found = demanded.and_then(|broken| {
        let demand = all.iter().find(|demand| demand.what.demanded() == Some(broken))?;
        Some((broken, demand))
    });
    let Some((Demanded { claim, quantity, component: k, entry: i }, demand)) = found else {
        let what = if example.entry.is_empty() { "no entry" } else { &example.entry };
        return lost(&format!("it names {what}, which this law does not speak of at this state"));
    };
    let nothing = || Side { case: None, asked: Asked::Whole, terms: Vec::new(), velocity: None };
    let mut found = Equality {
        got: Side { terms: demand.terms.iter().copied().collect(), ..nothing() },
        want: nothing(),
        constant: 0.0,
    };
    match claim {
        Claim::TurnedAxes => {
            let (rotation, turned) = context.turned();
            found.want.case = Some(turned);
            found.want.terms = turned_terms(&rotation, quantity, k, i);
        }
        Claim::ExchangedNodes => {
            found.want.case = Some(context.swapped());
            found.want.terms = vec![(quantity, k, exchanged_entry(quantity, i), 1.0)];
        }
        Claim::Half => {
            found.want.case = context.half(k);
            found.want.terms = vec![(quantity, k, i, 1.0)];
        }
        Claim::Alone | Claim::WithoutRates => {
            found.want.asked = if claim == Claim::Alone { Asked::Alone(k) } else { Asked::Rows };
            found.want.terms = vec![(quantity, k, i, 1.0)];
        }
        // The rate that a conjugate force works along is a number of the same evaluation.
        Claim::Power
            if demand.want != 0.0 && case.definition.connection.loading(k) == Some(Loading::Conjugate) =>
        {
            found.want.velocity = Some(k);
        }
        Claim::Power
        | Claim::Translation
        | Claim::Rotation
        | Claim::AlongRows
        | Claim::Symmetry
        | Claim::DeclaredZero
        | Claim::RestoredHistory => found.constant = demand.want,
    }
    Ok(Some(found))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::outcome::Against;
    use crate::sampling::{Extent, cases};
    use pintle_kinematics::catalog::ConnectionType;

    /// Every demand of every law is found by what it claims, and no other, whatever words stand in the file; and what is asked for is a
    /// matter of that claim.
    #[test]
    fn demands_are_found_whatever_their_words() {
        let mut alone = 0;
        for name in ["REVOLUTE", "TRANSLATOR", "ROTATION", "SLIPRING"] {
            let connection = ConnectionType::named(name, None).unwrap();
            let case = cases(&connection, Extent::Brief).pop().unwrap();
            let numbers = crate::product(&case).unwrap();
            let state = case.last().unwrap().state;
            let bound = Bound::new(&numbers, &state, case.length, 1.0);
            let context = Context::new(&case, &numbers, &bound).unwrap();
            for invariant in Invariant::ALL {
                let demands = context.demands(invariant);
                for (n, demand) in demands.iter().enumerate() {
                    let demanded = demand.what.demanded();
                    let is_other = |other: &crate::laws::Demand| other.what.demanded() != demanded;
                    assert!(demands.iter().skip(n + 1).all(is_other), "{name}: {}", demand.what);
                    // What is bit for bit the same is a long list.
                    if n % 23 != 0 && demands.len() > 100 || invariant == Invariant::Restored {
                        continue;
                    }
                    let example = CounterExample {
                        against: "a law".to_string(),
                        entry: "alone".to_string(),
                        law: Some(BrokenLaw { name: invariant, demanded }),
                        ..CounterExample::record(&case, Against::Own)
                    };
                    let found = law(&example, &case).unwrap().unwrap();
                    assert_eq!(found.got.terms, demand.terms.to_vec(), "{name}: {}", demand.what);
                    let is_alone = demanded.is_some_and(|broken| broken.claim == Claim::Alone);
                    assert_eq!(
                        matches!(found.want.asked, Asked::Alone(_)),
                        is_alone,
                        "{name}: {}",
                        demand.what
                    );
                    alone += usize::from(is_alone);
                }
            }
        }
        assert!(alone > 20, "{alone}");
    }
}
