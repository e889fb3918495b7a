//! Numbers of components as arrays.

use crate::evaluation::block::{Value, value_of};
use pintle_model::behavior::Conditions;
use pintle_model::behavior::state::Velocities;
use pintle_model::evaluate::{
    ArrayError, Item, Model, Motions, Numbers, Plan, Sequence, evaluate_arrays, is_kinematic,
};
use pintle_scene::State;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::convert::Infallible;

/// The numbers of the connectors of a plan at all states, whatever they follow from: by [`evaluate_arrays`] where they follow from the motion
/// alone, else by a walk.
///
/// # Errors
/// An array of another size.
pub fn into_arrays(
    model: &Model,
    plan: &Plan,
    motions: Motions<'_>,
    conditions: &Conditions,
    mut numbers: Numbers<'_>,
) -> Result<(), ArrayError> {
    if is_kinematic(model, plan).is_ok() {
        return evaluate_arrays(model, plan, motions, numbers).map(|_| ());
    }
    numbers.check(motions.count(), plan.connectors.len())?;
    let connectors = plan.connectors.len();
    let places: BTreeMap<usize, usize> = plan.connectors.iter().copied().zip(0..).collect();
    let mut sequence = Sequence::new(model, plan);
    let moves = match motions {
        Motions::Arrays(arrays) => arrays.has_rates(),
        Motions::States(states) => states.iter().any(State::has_rates),
    };
    if !moves {
        sequence.set_velocities(Velocities::Increments);
    }
    sequence.set_conditions(conditions.clone());
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
