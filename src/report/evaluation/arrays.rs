//! Numbers of components as arrays.

use crate::evaluation::block::{Value, value_of};
use pintle_model::behavior::Conditions;
use pintle_model::behavior::state::Velocities;
use pintle_model::evaluate::{
    ArrayError, ArrayWalk, Item, Model, Motions, Numbers, Plan, Sequence, evaluate_arrays, is_kinematic,
};
use pintle_scene::State;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::convert::Infallible;

/// The numbers of the connectors of a plan at states in turn, whatever they follow from: by an [`ArrayWalk`] where they follow from the motion
/// alone, else by a [`Sequence`].
pub struct ArrayEvaluation<'a>(Way<'a>);

enum Way<'a> {
    Lanes(ArrayWalk<'a>),
    Sequence { plan: &'a Plan, sequence: Box<Sequence<'a>>, places: BTreeMap<usize, usize> },
}

impl<'a> ArrayEvaluation<'a> {
    /// From the initial state of the model on. `moves`: whether any state has rates; else velocities of damping are increments by time.
    pub fn new(model: &'a Model, plan: &'a Plan, conditions: &Conditions, moves: bool) -> Self {
        if let Ok(walk) = ArrayWalk::new(model, plan) {
            return Self(Way::Lanes(walk));
        }
        let mut sequence = Sequence::new(model, plan);
        if !moves {
            sequence.set_velocities(Velocities::Increments);
        }
        sequence.set_conditions(conditions.clone());
        let places = plan.connectors.iter().copied().zip(0..).collect();
        Self(Way::Sequence { plan, sequence: Box::new(sequence), places })
    }

    /// Evaluates the next states.
    ///
    /// # Errors
    /// An array of another size. Then nothing is evaluated.
    pub fn advance(&mut self, motions: Motions<'_>, mut numbers: Numbers<'_>) -> Result<(), ArrayError> {
        let (plan, sequence, places) = match &mut self.0 {
            Way::Lanes(walk) => return walk.advance(motions, numbers).map(|_| ()),
            Way::Sequence { plan, sequence, places } => (*plan, sequence, places),
        };
        let connectors = plan.connectors.len();
        numbers.check(motions.count(), connectors)?;
        for s in 0..motions.count() {
            let state: Cow<'_, State> = match motions {
                Motions::Arrays(arrays) => Cow::Owned(arrays.state(s)),
                Motions::States(states) => Cow::Borrowed(&states[s]),
            };
            let Ok(()) = sequence.visit(&state, |item| -> Result<(), Infallible> {
                let Item::Connector(result) = item else { return Ok(()) };
                let Some(c) = places.get(&result.index) else { return Ok(()) };
                let value = |output, k| {
                    let value = value_of(result, output, k).filter(|_| plan.request.wants(output, k));
                    value.map(Value::number)
                };
                numbers.put(s * connectors + c, value, &result.evaluation);
                Ok(())
            });
        }
        Ok(())
    }
}

/// The numbers of the connectors of a plan at all states, which fit into memory.
///
/// # Errors
/// An array of another size.
pub fn into_arrays(
    model: &Model,
    plan: &Plan,
    motions: Motions<'_>,
    conditions: &Conditions,
    numbers: Numbers<'_>,
) -> Result<(), ArrayError> {
    if is_kinematic(model, plan).is_ok() {
        return evaluate_arrays(model, plan, motions, numbers).map(|_| ());
    }
    let moves = match motions {
        Motions::Arrays(arrays) => arrays.has_rates(),
        Motions::States(states) => states.iter().any(State::has_rates),
    };
    ArrayEvaluation::new(model, plan, conditions, moves).advance(motions, numbers)
}
