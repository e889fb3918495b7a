//! Where numbers cease to be finite: the first stage, from the state to what is formed of it last.

use crate::case::quantity::{Numbers, Quantity};
use pintle_kinematics::connector::State;

fn is_finite<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> bool {
    numbers.into_iter().all(|x| x.is_finite())
}

/// Whether a state has finite numbers alone.
pub fn is_state(state: &State<f64>) -> bool {
    let State { pair, velocity, acceleration } = state;
    let nodes = [&pair.a, &pair.b].into_iter().all(|node| {
        let triad = node.triad.as_flattened();
        is_finite(node.displacement.iter().chain(triad).chain([&node.flow]))
    });
    nodes && is_finite(pair.reference.iter().chain(velocity).chain(acceleration))
}

/// The first stage at which a number is infinite or not a number: `state`, `relative pair`, or the kind of numbers; `None` where all
/// of them are finite.
pub fn invalid_stage(state: &State<f64>, numbers: &Numbers<f64>) -> Option<&'static str> {
    if !is_state(state) {
        return Some("state");
    }
    let relative = state.pair.relative();
    if !is_finite(relative.d.iter().chain(relative.q.as_flattened())) {
        return Some("relative pair");
    }
    let is_lost = |quantity: &Quantity| numbers.entries(*quantity).iter().any(|(.., x)| !x.is_finite());
    Quantity::ALL.into_iter().find(is_lost).map(Quantity::name)
}
