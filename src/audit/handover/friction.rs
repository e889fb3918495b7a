//! A counter-example of a friction or a belt as a script for JAX; of a predefined friction, as a deck.

use super::deck::{Deck, Difference};
use super::jax::{VERDICT, text};
use super::{ExportError, number};
use crate::audit::failing::Failing;
use crate::audit::friction::{BeltCase, FrictionCase, Place, Predefined};
use crate::audit::recorded::{Kind, Recorded};
use crate::audit::scene::{Target, last_frictions};
use crate::connector::Request;
use crate::evaluate::{Model, Plan, Selection};
use crate::scene::{Scene, StateFile};

/// The formulas of friction, a second time.
const FORMULAS: &str = include_str!("../../../scripts/reference_friction_formulas.py");

/// What the script does with the values, after formulas and these.
const JUDGES: &str = include_str!("judge_friction.py");

/// A deck's numbers are those of the counter-example to rounding; what is off by more, relative to the largest of its kind, is of another
/// increment.
const OTHER: f64 = 1e-6;

fn python(is: bool) -> &'static str {
    if is { "True" } else { "False" }
}

fn tuple<T>(all: &[T], to: impl Fn(&T) -> String) -> String {
    format!("[{}]", all.iter().map(to).collect::<Vec<_>>().join(", "))
}

fn script(
    recorded: &Recorded,
    (failing, place): (&Failing, &Place),
    named: Option<&Predefined>,
    is_returned_along: bool,
) -> Result<String, ExportError> {
    let lost = |error: &dyn std::fmt::Display| ExportError::Lost(error.to_string());
    let Some(values) = Recorded::stated(failing).map(|stated| stated.values) else {
        return Err(recorded.unknown());
    };
    let values = serde_json::to_string_pretty(&values).map_err(|error| lost(&error))?;
    let kind = if recorded.kind == Kind::Belt { "belt" } else { "friction" };
    let of = if place.is_of_criterion { "criterion" } else { "increment" };
    let places = [&[place.output], place.inputs.as_slice()].concat();
    let named = named.map_or_else(
        || "None".to_string(),
        |of| {
            format!(
                "({}, {}, {}, {})",
                text(&of.connection.name),
                of.place,
                super::list(&of.parameters),
                tuple(&of.present(), |is| python(*is).to_string())
            )
        },
    );
    let mut script = String::from(FORMULAS);
    script.push_str(&format!(
        "\n\n# The values of the counter-example, doubles in hexadecimal\n\nnull, true, false = None, True, False\n\
         ABOUT = {}\nKIND, OF, PLACE = {}, {}, {}\nGIVEN = float({:?})\nWANTED = float({:?})\nTOLERANCE = float({:?})\n\
         NAMED = {named}\nRETURNED_ALONG = {}\nVALUES = {values}\n\n\n",
        text(&super::about(&recorded.heading(), recorded)),
        text(kind),
        text(of),
        tuple(&places, usize::to_string),
        number(recorded.got.0),
        number(recorded.want.0),
        number(recorded.tolerance.0),
        python(is_returned_along)
    ));
    script.push_str(JUDGES);
    script.push_str(VERDICT);
    Ok(script)
}

fn place_in(recorded: &Recorded, place: Option<Place>) -> Result<Place, ExportError> {
    if !(recorded.want.0.is_finite() && recorded.tolerance.0.is_finite()) {
        return Err(ExportError::Lost(format!("{}: what it must be is no finite number", recorded.entry)));
    }
    place.ok_or_else(|| recorded.unknown())
}

/// A script of a friction.
pub(super) fn jax_of_friction(recorded: &Recorded, case: &FrictionCase) -> Result<String, ExportError> {
    let of = recorded.quantity.and_then(|quantity| case.place(quantity, &recorded.entry));
    let place = place_in(recorded, of)?;
    let failing = Failing::Friction(Box::new(case.clone()));
    script(recorded, (&failing, &place), case.predefined().as_ref(), case.is_returned_along())
}

/// A script of a belt.
pub(super) fn jax_of_belt(recorded: &Recorded, case: &BeltCase) -> Result<String, ExportError> {
    let of = recorded.quantity.and_then(|quantity| case.place(quantity, &recorded.entry));
    let place = place_in(recorded, of)?;
    script(recorded, (&Failing::Belt(Box::new(case.clone())), &place), None, false)
}

/// A deck with the type's connector, an increment, and what presses.
pub(super) fn deck(recorded: &Recorded, case: &FrictionCase) -> Result<Deck, ExportError> {
    let lost = |why: &dyn std::fmt::Display| ExportError::Lost(format!("it cannot be a deck: {why}"));
    let Some(place) = recorded.quantity.and_then(|quantity| case.place(quantity, &recorded.entry)) else {
        return Err(recorded.unknown());
    };
    let (model, states) = case.stated(&place).map_err(|why| recorded.has_no(&format!("deck: {why}")))?;
    let scene = Scene::parse("the deck", &model)?;
    let read = StateFile::parse_json("its states", &states, &scene)?;
    let compiled = Model::compile(&scene)?;
    let plan =
        Plan::compile(&compiled, &Selection::All, Request::nothing(0)).map_err(|error| lost(&error))?;
    let target = Target { name: "the deck", model: &compiled, plan: &plan, states: &read.states };
    let again = last_frictions(&target).into_iter().find(|again| again.is_of(case));
    let again = again.ok_or_else(|| lost(&"its friction is not known there"))?;
    let both = case.numbers(&place).into_iter().zip(again.numbers(&place));
    let mut differences = Vec::new();
    for ((quantity, was), (_, is)) in both {
        let gap = |(x, y): (&f64, &f64)| match (x, y) {
            (x, y) if x.to_bits() == y.to_bits() || x == y => 0.0,
            (x, y) if (x - y).is_finite() => (x - y).abs(),
            _ => f64::INFINITY,
        };
        let largest = was.iter().zip(&is).map(gap).fold(0.0, f64::max);
        let size = was.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        if largest > OTHER * size {
            let why =
                "its friction does something else there: the states of a deck cannot lead to this increment";
            return Err(lost(&why));
        }
        differences.push(Difference { quantity, largest });
    }
    let about = super::about(&recorded.heading(), recorded);
    let numbers = format!(
        "{}\n** Judge it at the last of its states: pintle audit THIS --at THOSE; its forces: --show 1 --outputs CSF,CNF,CASU,TANGENT below",
        recorded.numbers()
    );
    Ok(Deck::new(&about, numbers, &model, states, differences))
}
