//! What rows leave open and other numbers tell: second derivatives, and the side of nodal forces.

use super::data::Expected;
use super::search::{Fit, GivenRows};
use super::space::{Reading, is_rotation};
use crate::convention::{Axes, Forces, Frame, Turned};
use pintle_audit::{Case, Quantity, Right, Step};
use pintle_kinematics::connector::{Definition, State};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, apply, product};

/// A step of differences, relative to the connector's length and to 1 rad.
const STEP: f64 = 1e-5;

/// How far such differences may be off, relative to the largest entry.
const ROUGH: f64 = 1e-6;

/// The states of a connector, and all that was given there.
pub(super) struct More<'a> {
    pub(super) definition: &'a Definition,
    pub(super) states: &'a [State<f64>],
    pub(super) given: &'a [GivenRows],
    pub(super) length: f64,
}

/// A state whose degree of freedom has moved a little, as a convention varies it.
fn moved(fit: &Fit, definition: &Definition, state: &State<f64>, place: usize, by: f64) -> State<f64> {
    let mut state = *state;
    let turned = Turned::of(definition, &state);
    let (end, of) = (place / 7, place % 7);
    let node = if end == 0 { &mut state.pair.a } else { &mut state.pair.b };
    let unit = |of: usize| -> Vector<f64> { [0, 1, 2].map(|i| if i == of { by } else { 0.0 }) };
    match of {
        0..=2 => node.displacement[of] += by,
        3..=5 => {
            let turn = apply(&fit.variations[end].jacobian(&turned[end]), unit(of - 3));
            node.triad = product(&so3::exp(turn), &node.triad);
        }
        _ => node.flow += by,
    }
    state
}

impl More<'_> {
    /// Whether the second derivatives are those of a fit; `None` where nothing tells.
    pub(super) fn bends(&self, fit: &Fit) -> Option<bool> {
        if fit.reading != Reading::Right
            || fit.frame != Frame::Global
            || fit.lines.iter().any(|of| of.is.is_as_angle)
        {
            return None;
        }
        let places = &fit.order.places;
        let width = places.len();
        let mut is_told = false;
        for (state, given) in self.states.iter().zip(self.given) {
            let Some(second) = &given.second else { continue };
            let expected = |place: usize, by: f64| {
                let state = moved(fit, self.definition, state, place, by);
                Expected::of(self.definition, &[state], fit.reading, fit.axes, self.length)
            };
            let both: Vec<(f64, Expected, Expected)> = places
                .iter()
                .map(|place| {
                    let by = if is_rotation(*place) { STEP } else { STEP * self.length };
                    Some((by, expected(*place, by)?, expected(*place, -by)?))
                })
                .collect::<Option<_>>()?;
            for of in &fit.lines {
                let Some(Some(got)) = second.get(of.line) else { continue };
                if got.len() != width * width {
                    return Some(false);
                }
                // ∂row_i/∂q_j, in the units of both columns.
                let slope = |i: usize, j: usize| {
                    let (by, ahead, behind) = &both[j];
                    let row = |of_state: &Expected| fit.entry(&of_state.at[0][of.of], places[i]).x;
                    let column = fit.units.of_entry(of.is.unit, is_rotation(places[j]))
                        / fit.units.of_value(of.is.unit);
                    (row(ahead) - row(behind)) / (2.0 * by) * fit.factor(of, places[i]) * column
                };
                let want: Vec<f64> = (0..width * width)
                    .map(|n| 0.5 * (slope(n / width, n % width) + slope(n % width, n / width)))
                    .collect();
                let largest = want.iter().chain(got).fold(0.0_f64, |most, x| most.max(x.abs()));
                is_told |= largest > 0.0;
                if want.iter().zip(got).any(|(want, got)| (want - got).abs() > ROUGH * largest) {
                    return Some(false);
                }
            }
        }
        is_told.then_some(true)
    }

    /// On which side the nodal forces are under a fit; `None` where none are given, or they are on neither.
    pub(super) fn side(&self, fit: &Fit) -> Option<Forces> {
        let convention = fit.convention();
        if fit.reading != Reading::Right || convention.axes != Axes::A || !convention.as_angle.is_empty() {
            return None;
        }
        let places = convention.places().ok()?;
        let mut sides = [(Forces::Residual, 1.0, true), (Forces::Body, -1.0, true)];
        let mut is_told = false;
        for (state, given) in self.states.iter().zip(self.given) {
            let Some(nodal) = &given.nodal else { continue };
            let step = Step { state: *state, ..Step::between(&self.definition.initial, state.pair) };
            let name = String::new();
            let case = Case {
                name,
                definition: self.definition.clone(),
                start: None,
                path: vec![step],
                length: self.length,
            };
            let right = Right::of(&case)?;
            let (connector, turned) = (case.connector(), Turned::of(self.definition, state));
            for of in &fit.lines {
                let Some(Some(got)) = nodal
                    .get(of.line)
                    .filter(|got| got.as_ref().is_some_and(|got| got.len() == places.len()))
                else {
                    continue;
                };
                let unit = convention.unit(of.is.k, &connector);
                let row = convention.line(got, &places, &turned).map(|x| x * unit);
                let want = |j: usize| right.numbers.entries(Quantity::NodalForces).get(of.is.k, j);
                let largest = (0..DOFS).filter_map(want).fold(0.0_f64, |most, x| most.max(x.abs()));
                for j in 0..DOFS {
                    let Some(want) = want(j) else { continue };
                    let off = right.bound.tolerance(Quantity::NodalForces, of.is.k, j) + 1e-13 * largest;
                    is_told |= want.abs() > 1e4 * off;
                    for (_, sign, fits) in &mut sides {
                        *fits &= (row[j] - *sign * want).abs() <= 2.0 * off;
                    }
                }
            }
        }
        sides.into_iter().find(|(.., fits)| is_told && *fits).map(|(side, ..)| side)
    }
}
