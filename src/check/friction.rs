//! A routine that is to be a friction.

use crate::convention::{Convention, Own, Storage};
use crate::exchange::Exchange;
use crate::process::{Door, Misbehaviour};
use crate::protocol::{Layout, OF_FRICTION};
use crate::{Asked, Checked};
use pintle_audit::friction::Told;
use pintle_audit::{FrictionCandidate, FrictionNumbers, FrictionSubject, Quantity};
use pintle_kinematics::catalog::COMPONENT;
use pintle_model::behavior::friction::StickStiffness;
use serde_json::{Map, Value, json};

/// How the numbers of a quantity are laid out.
fn layout(quantity: Quantity, by_columns: bool) -> Layout {
    let (rows, columns) = match quantity {
        Quantity::FrictionCriterion => (4, 1),
        Quantity::FrictionGradient => (4, 6),
        Quantity::FrictionForce => (10, 1),
        _ => (6, 12),
    };
    Layout { rows, columns, by_columns }
}

fn open(subject: &FrictionSubject) -> Value {
    let FrictionSubject { friction, coefficient, parameters, length, .. } = subject;
    let sliding = friction.criterion.tangential.components();
    let presses = friction.criterion.pressing_components();
    let names = |has: &dyn Fn(usize) -> bool| -> Vec<&str> {
        (0..COMPONENT.len()).filter(|k| has(*k)).map(|k| COMPONENT[k]).collect()
    };
    let parameters: Map<String, Value> =
        parameters.iter().map(|(name, value)| ((*name).to_string(), json!(value))).collect();
    let stiffness = match friction.stick_stiffness {
        StickStiffness::Given(stiffness) => json!(stiffness),
        StickStiffness::ElasticSlip(_) => Value::Null,
    };
    json!({ "open": {
        "type": format!("FRICTION {}", subject.name),
        "sliding": names(&|k| sliding.contains(&k)),
        "pressing": names(&|k| presses[k]),
        "coefficient": coefficient,
        "maximum": friction.maximum,
        "stick_stiffness": stiffness,
        "parameters": parameters,
        "length": length,
    } })
}

fn state(told: Told) -> Value {
    json!({
        "forces": told.forces,
        "increment": { "displacement": told.displacement, "pressing": told.pressing },
        "position": told.position,
        "motion": told.motion,
        "previous": {
            "forces": told.forces_before,
            "accumulated_slip": told.slip_before,
            "stick_stiffness": told.stick_stiffness,
        },
    })
}

fn read(own: &Own) -> FrictionNumbers {
    let mut given = FrictionNumbers::default();
    for (quantity, of) in &own.given {
        let scalar = |i: usize| of.get(i)?.as_ref()?.first().copied();
        match quantity {
            Quantity::FrictionCriterion => given.criterion = std::array::from_fn(scalar),
            Quantity::FrictionForce => given.forces = std::array::from_fn(scalar),
            Quantity::FrictionGradient => {
                given.gradients = std::array::from_fn(|i| {
                    let row = of.get(i)?.as_ref()?;
                    Some(std::array::from_fn(|j| row.get(j).copied().unwrap_or(0.0)))
                });
            }
            _ => {
                given.tangent = std::array::from_fn(|i| {
                    let row = of.get(i)?.as_ref()?;
                    Some(std::array::from_fn(|j| row.get(j).copied().unwrap_or(0.0)))
                });
            }
        }
    }
    given
}

/// Asks a routine behind a door to be a friction, and checks what it answers.
///
/// # Errors
/// [`Misbehaviour`].
pub(crate) fn check<D: Door>(
    door: D,
    subject: &FrictionSubject,
    asked: Asked,
) -> Result<Checked, Misbehaviour> {
    let mut exchange = Exchange::greet(door, asked.convention.as_ref())?.only_asked();
    let offers = exchange.offers(&OF_FRICTION)?;
    let Convention { storage, .. } = exchange.hello.convention;
    if exchange.hello.convention != (Convention { storage, ..Convention::default() }) {
        return Err(Misbehaviour::BadConvention(
            "a friction is read in pintle's conventions, but for \"storage\"".into(),
        ));
    }
    exchange.open(&open(subject))?;
    let name = asked.title(&exchange.hello.name);
    let candidate = FrictionCandidate::new(&name, subject).settings(asked.settings).offers(&offers);
    let laid = |quantity: Quantity| layout(quantity, storage == Storage::Columns);
    let (mut states, mut outside) = (0, 0);
    let report = candidate.try_check(|cases| {
        let messages = cases.iter().map(|case| state(case.told())).collect();
        let given = exchange.answers(&offers, messages, &laid)?;
        states += given.len() as u64;
        outside += given.iter().filter(|given| given.is_none()).count() as u64;
        Ok::<_, Misbehaviour>(given.iter().map(|own| own.as_ref().map(read)).collect())
    })?;
    let lacking = OF_FRICTION.iter().filter(|(_, of)| !offers.contains(of)).map(|(name, _)| *name);
    let not_offered = lacking.collect();
    exchange.ask_again(&laid)?;
    let requests = exchange.asked();
    exchange.close()?;
    Ok(Checked::without_history(report, (states, outside), not_offered, requests))
}
