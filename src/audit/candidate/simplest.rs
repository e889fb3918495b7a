//! The simplest state at which a routine is wrong.

use crate::candidate::{Asked, Candidate, Given, Question};
use crate::case::Case;
use crate::case::failing::Failing;
use crate::case::quantity::Quantity;
use crate::judge::outcome::{Against, Check};
use crate::replay::shrink::shrink_state;
use pintle_kinematics::node::{DOF, Node};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, product, transpose};
use std::cell::RefCell;

/// So often is a routine asked.
const TRIALS: usize = 300;

impl Candidate<'_> {
    /// The simplest state found at which numbers are wrong that a check calls wrong, in words. It has zero, one or few digits in place of each
    /// number, and right angles in place of each rotation. The connector stays what it is, and the state within the domain. `None` of a check that calls nothing wrong.
    ///
    /// # Errors
    /// The first of the routine.
    pub fn simplest<E>(
        &self,
        check: &Check,
        routine: &mut impl FnMut(&[Question<'_>]) -> Result<Vec<Option<Given>>, E>,
    ) -> Result<Option<String>, E> {
        let (Some(Failing::Connector(case)), Some(quantity)) = (check.failing.as_deref(), check.quantity)
        else {
            return Ok(None);
        };
        let (error, left) = (RefCell::new(None), RefCell::new((TRIALS, routine)));
        let fails = |case: &Case| {
            let (trials, routine) = &mut *left.borrow_mut();
            if *trials == 0 || error.borrow().is_some() {
                return false;
            }
            *trials -= 1;
            self.is_wrong(case, (quantity, check.against), routine).unwrap_or_else(|failed| {
                *error.borrow_mut() = Some(failed);
                false
            })
        };
        let found = shrink_state(case, &fails).as_ref().map(told);
        error.into_inner().map_or(Ok(found), Err)
    }

    /// Whether numbers of a quantity are wrong at the end of a case. The routine's own differences are asked for where they are the judge.
    fn is_wrong<E>(
        &self,
        case: &Case,
        (quantity, against): (Quantity, Against),
        routine: &mut impl FnMut(&[Question<'_>]) -> Result<Vec<Option<Given>>, E>,
    ) -> Result<bool, E> {
        let asked = Asked::new(0, case.clone());
        let is_in = case.last().is_some_and(|step| self.domain.holds(self.definition, &step.state.pair));
        let (true, Some(question)) = (is_in, asked.question(&self.offers)) else { return Ok(false) };
        let Some(given) = routine(&[question])?.into_iter().next().flatten() else { return Ok(false) };
        let judged = if against == Against::Own { &self.offers[..] } else { &[quantity] };
        let checks = self.judge_on_sheet((&asked, given), judged, routine, false, &mut Vec::new())?;
        let is_wrong = |check: &Check| check.quantity == Some(quantity) && check.verdict.is_mismatch();
        Ok(checks.is_some_and(|checks| checks.iter().any(is_wrong)))
    }
}

/// The end of a case: what of it is not as it was initially.
fn told(case: &Case) -> String {
    let Some(step) = case.last() else { return String::new() };
    let (pair, initial) = (&step.state.pair, &case.definition.initial);
    let vector = |v: Vector<f64>| format!("({}, {}, {})", v[0], v[1], v[2]);
    let node = |name: &str, now: &Node<f64>, then: &Node<f64>| {
        let turned = so3::log(&product(&now.triad, &transpose(&then.triad)));
        let mut parts = vec![format!("u = {}", vector(now.displacement)), format!("φ = {}", vector(turned))];
        if now.flow != 0.0 {
            parts.push(format!("Ψ = {}", now.flow));
        }
        format!("{name}: {}", parts.join(", "))
    };
    let mut all = vec![node("a", &pair.a, &initial.a), node("b", &pair.b, &initial.b)];
    for (name, rates) in [("q̇", &step.state.velocity), ("q̈", &step.state.acceleration)] {
        let moving = rates.iter().zip(DOF).filter(|(x, _)| **x != 0.0);
        let moving: Vec<String> = moving.map(|(x, dof)| format!("{dof} {x}")).collect();
        if !moving.is_empty() {
            all.push(format!("{name}: {}", moving.join(", ")));
        }
    }
    all.join("; ")
}
