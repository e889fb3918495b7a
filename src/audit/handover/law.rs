//! A mismatch of a law as a test: which numbers of the state are added up, and which they must be equal to.

use super::ExportError;
use crate::audit::bound::Bound;
use crate::audit::case::Case;
use crate::audit::counterexample::CounterExample;
use crate::audit::invariant::{Context, Invariant, What};
use crate::audit::oracle::Narrow;
use crate::audit::quantity::Quantity;
use crate::catalog::Loading;
use crate::node::DOFS;

/// A number, by its kind, component (0-based) and place, and what it is multiplied by.
pub(super) type Term = (Quantity, usize, usize, f64);

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
pub(super) struct Sum {
    /// The state; none for that of the counter-example.
    pub(super) case: Option<Case>,
    pub(super) asked: Asked,
    pub(super) terms: Vec<Term>,
    /// The component whose velocity is added besides.
    pub(super) velocity: Option<usize>,
}

/// Two sums that must be equal.
pub(super) struct Law {
    pub(super) got: Sum,
    pub(super) want: Sum,
    /// What is wanted besides.
    pub(super) constant: f64,
}

/// What a law demands that a counter-example breaks; `None` where it is of no law.
pub(super) fn law(example: &CounterExample, case: &Case) -> Result<Option<Law>, ExportError> {
    let Some(law) = Invariant::ALL.into_iter().find(|law| law.name() == example.against) else {
        return Ok(None);
    };
    let lost = |why: &str| Err(ExportError::Lost(format!("{}: {why}", example.against)));
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
    let (Some(numbers), Some(last), Some(narrow)) =
        (crate::audit::product(case), case.last(), Narrow::of(case))
    else {
        return lost("it has no state");
    };
    let (velocity, acceleration) = (&last.state.velocity, &last.state.acceleration);
    let bound = Bound::new(&numbers, velocity, acceleration, case.length, narrow.nearness());
    let Some(context) = Context::new(case, &numbers, &bound) else { return lost("it has no state") };
    let all = context.demands(law);
    let Some(demand) = all.iter().find(|demand| demand.what.to_string() == example.entry) else {
        let what = if example.entry.is_empty() { "no entry" } else { &example.entry };
        return lost(&format!("it names {what}, which this law does not speak of at this state"));
    };
    let nothing = || Sum { case: None, asked: Asked::Whole, terms: Vec::new(), velocity: None };
    let mut found = Law {
        got: Sum { terms: demand.terms.iter().copied().collect(), ..nothing() },
        want: nothing(),
        constant: 0.0,
    };
    match (law, &demand.what) {
        (Invariant::Frame, What::Entry(_, quantity, k, i, _)) => {
            let (rotation, turned) = context.turned();
            found.want.case = Some(turned);
            found.want.terms = if quantity.entries() == 1 {
                vec![(*quantity, *k, *i, 1.0)]
            } else {
                // Rᵀ times the vector of the node.
                let component = i % (DOFS / 2) % 3;
                (0..3).map(|j| (*quantity, *k, i - component + j, rotation[j][component])).collect()
            };
        }
        (Invariant::NodeSwap, What::Entry(_, quantity, k, i, _)) => {
            let twin = (i + DOFS / 2) % DOFS;
            found.want.case = Some(context.swapped());
            let sign = context.exchanged(*k).unwrap_or(1.0);
            found.want.terms = vec![(*quantity, *k, twin, sign)];
        }
        (Invariant::Halves, What::Entry(_, quantity, k, i, _)) => {
            found.want.case = context.half(*k);
            found.want.terms = vec![(*quantity, *k, *i, 1.0)];
        }
        (Invariant::Restricted, What::Entry(_, quantity, k, i, after)) => {
            found.want.asked = if after.contains("alone") { Asked::Alone(*k) } else { Asked::Rows };
            found.want.terms = vec![(*quantity, *k, *i, 1.0)];
        }
        (Invariant::Power, _) if demand.want != 0.0 => {
            let of_force =
                demand.terms.iter().find(|term| term.0 == Quantity::NodalForces).map(|term| term.1);
            match of_force.map(|k| (k, case.definition.connection.loading(k))) {
                Some((k, Some(Loading::Conjugate))) => found.want.velocity = Some(k),
                _ => found.constant = demand.want,
            }
        }
        _ => found.constant = demand.want,
    }
    Ok(Some(found))
}
