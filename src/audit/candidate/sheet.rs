//! Sheets of angles: the same rotation by other angles.
//!
//! Where a state is far from the one before, several sheets continue the angles. None is wrong that is no farther from there than the one of
//! the product. That is measured by the sum of what the angles move, by the sum of squares, and by the largest.

use crate::candidate::Given;
use crate::case::Case;
use crate::case::quantity::Quantity;
use pintle_kinematics::connector::Components;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{add, dot, scale, sub, transposed_product};
use std::f64::consts::{PI, TAU};

/// How far angles of one rotation may be apart (rad): more than rounding, and less than any fault that matters here.
const SAME: f64 = 1e-6;

/// Whether it is a component of a rotation vector, which another sheet lengthens.
pub(super) const fn is_of_vector(measure: &Measure) -> bool {
    matches!(measure, Measure::RotationVector(_) | Measure::RotationVectorAtB(_))
}

/// Whether angles differ by whole turns.
fn is_turn(by: f64) -> bool {
    (by - TAU * (by / TAU).round()).abs() < SAME
}

/// Whether other numbers stand for the same rotation.
fn has_sheets(measure: &Measure) -> bool {
    measure.winds() || is_of_vector(measure)
}

/// Angles of a connector at a state: those given, and those of the product.
struct Angles {
    components: Vec<usize>,
    measures: Vec<Measure>,
    found: Vec<f64>,
    wanted: Vec<f64>,
    first: Components<f64>,
}

impl Angles {
    /// None where there are none, or not all are given as numbers.
    fn of(case: &Case, given: &Given) -> Option<Self> {
        let connector = case.connector();
        let kinds = (0..6).filter_map(|k| Some((k, connector.differentiated(k).filter(has_sheets)?)));
        let (components, measures): (Vec<usize>, Vec<Measure>) = kinds.unzip();
        let value = |k: &usize| given.0.entries(Quantity::Value).get(*k, 0).filter(|x| x.is_finite());
        let found: Vec<f64> = components.iter().map(value).collect::<Option<_>>()?;
        if found.is_empty() {
            return None;
        }
        let right = case.values();
        let wanted = components.iter().map(|k| right[*k]).collect::<Option<_>>()?;
        Some(Self { components, measures, found, wanted, first: case.at_rest().positions() })
    }

    /// The position of one at first.
    fn first(&self, at: usize) -> f64 {
        self.first[self.components[at]].unwrap_or(0.0)
    }

    fn positions(&self, of: &[f64]) -> Vec<f64> {
        of.iter().enumerate().map(|(at, x)| x + self.first(at)).collect()
    }
}

/// Whether what is given continues the angles on another sheet: no farther from the state before, where its values are given.
pub(super) fn is_another(case: &Case, given: &Given, before: Option<&Components<f64>>) -> bool {
    let connector = case.connector();
    if !(0..6).any(|k| connector.differentiated(k).is_some_and(|measure| has_sheets(&measure))) {
        return is_projected_otherwise(case, given);
    }
    let Some(angles) = Angles::of(case, given) else { return false };
    let Angles { components, measures, found, wanted, .. } = &angles;
    if found.iter().zip(wanted).all(|(x, y)| (x - y).abs() < SAME) {
        return false;
    }
    let is_near = |before: &Components<f64>| {
        let start: Option<Vec<f64>> = components.iter().map(|k| before[*k]).collect();
        start.is_some_and(|start| is_as_near(found, wanted, &start))
    };
    is_same(measures, &angles.positions(found), &angles.positions(wanted)) && before.is_none_or(is_near)
}

/// Where two of three Euler angles are those of the other sheet, and one is wrong besides: the values put on the sheet of the right ones, so that
/// the wrong one is judged. Derivatives are of the other sheet.
pub(super) fn mostly_another(case: &Case, given: &Given, before: Option<&Components<f64>>) -> Option<Given> {
    let angles = Angles::of(case, given)?;
    let other = mostly_euler(&angles, before)?;
    let mut put = given.clone();
    for (at, k) in angles.components.iter().enumerate() {
        if let Some(x) = put.0.entries_mut(Quantity::Value).0[*k].as_mut().and_then(|x| x.first_mut()) {
            *x = angles.wanted[at] + (angles.found[at] - other[at]);
        }
    }
    Some(put)
}

/// The three Euler angles of the other sheet, where two of those given are these, and the sheet is as near to where they come from.
fn mostly_euler(angles: &Angles, before: Option<&Components<f64>>) -> Option<Vec<f64>> {
    let Angles { components, measures, found, wanted, .. } = angles;
    if measures.len() != 3 || !measures.iter().all(|of| matches!(of, Measure::Euler(_))) {
        return None;
    }
    let from = |(k, right): (&usize, &f64)| before.map_or(*right, |of| of[*k].unwrap_or(0.0));
    let start: Vec<f64> = components.iter().zip(wanted).map(from).collect();
    // (α + π, −β, γ + π), less what they are at first, on the turn that is given, or else on that which is nearest to where it comes from.
    let others = |at: usize| {
        let position = wanted[at] + angles.first(at);
        let other = if at == 1 { -position } else { position + PI } - angles.first(at);
        let near = if is_turn(found[at] - other) { found[at] } else { start[at] };
        other - TAU * ((other - near) / TAU).round()
    };
    let other: Vec<f64> = (0..3).map(others).collect();
    let met = |of: &[f64]| of.iter().zip(found).filter(|(x, y)| (*x - *y).abs() < SAME).count();
    let is_apart = other.iter().zip(wanted).all(|(x, y)| (x - y).abs() > SAME);
    let is_near = || before.is_none() || is_as_near(&other, wanted, &start);
    (is_apart && met(&other) == 2 && met(wanted) == 0 && is_near()).then_some(other)
}

/// Whether coordinates along axes midway between those of both nodes have the other sign where the torsion is half a turn: rounding decides
/// there which way is midway.
fn is_projected_otherwise(case: &Case, given: &Given) -> bool {
    let connector = case.connector();
    let of_axis =
        |i: usize| (0..6).find(|k| connector.differentiated(*k) == Some(Measure::ProjectedPosition(i)));
    let ([Some(x), Some(y), Some(z)], Some(step)) = ([1, 2, 3].map(of_axis), case.last()) else {
        return false;
    };
    let pair = &step.state.pair;
    if so3::torsion(&transposed_product(&pair.a.triad, &pair.b.triad)).abs() < PI - SAME {
        return false;
    }
    let [wanted, first] = [case.positions(), case.at_rest().positions()];
    let is_it = |k: usize, sign: f64| {
        let (Some(value), Some(wanted)) = (given.0.entries(Quantity::Value).get(k, 0), wanted[k]) else {
            return false;
        };
        let found = value + first[k].unwrap_or(0.0);
        (found - sign * wanted).abs() <= SAME * (1.0 + wanted.abs())
    };
    is_it(x, -1.0) && is_it(y, -1.0) && is_it(z, 1.0)
}

/// Whether they are angles of one rotation.
fn is_same(measures: &[Measure], found: &[f64], wanted: &[f64]) -> bool {
    let (mut vector, mut euler) = (Vec::new(), Vec::new());
    let mut turns = true;
    for (at, measure) in measures.iter().enumerate() {
        match measure {
            Measure::RotationVector(_) | Measure::RotationVectorAtB(_) => vector.push(at),
            Measure::Euler(_) => euler.push(at),
            _ => turns &= is_turn(found[at] - wanted[at]),
        }
    }
    let of_vector = match vector[..] {
        [] => true,
        [i, j, k] => {
            let (found, wanted) = ([found[i], found[j], found[k]], [wanted[i], wanted[j], wanted[k]]);
            let length = norm(wanted);
            length > SAME && {
                let axis = scale(wanted, 1.0 / length);
                let by = TAU * (dot(sub(found, wanted), axis) / TAU).round();
                // Next to a whole turn the axis has no more digits than the angle left.
                let apart = norm(sub(found, add(wanted, scale(axis, by))));
                apart < SAME * (1.0 + length)
            }
        }
        _ => false,
    };
    let of_euler = match euler[..] {
        [] => true,
        [i, j, k] => {
            let by = |at: usize| found[at] - wanted[at];
            let same = [i, j, k].into_iter().all(|at| is_turn(by(at)));
            let other = is_turn(by(i) - PI) && is_turn(found[j] + wanted[j]) && is_turn(by(k) - PI);
            same || other
        }
        _ => false,
    };
    turns && of_vector && of_euler
}

/// Whether the one is as near to where both come from as the other, by any of three measures.
fn is_as_near(found: &[f64], wanted: &[f64], start: &[f64]) -> bool {
    let measures = |of: &[f64]| {
        let by = of.iter().zip(start).map(|(x, y)| (x - y).abs());
        by.fold([0.0_f64; 3], |[sum, square, most], x| [sum + x, x.mul_add(x, square), most.max(x)])
    };
    measures(found).into_iter().zip(measures(wanted)).any(|(one, other)| one <= other * (1.0 + SAME))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sheets are of one rotation, and none is taken that is farther by every measure.
    #[test]
    fn sheets_are_of_one_rotation() {
        let euler = [Measure::Euler(0), Measure::Euler(1), Measure::Euler(2)];
        let wanted = [0.4, 0.7, -1.1];
        assert!(is_same(&euler, &[0.4 + PI, -0.7, -1.1 - PI], &wanted));
        assert!(is_same(&euler, &[0.4 + TAU, 0.7, -1.1], &wanted));
        for wrong in [[0.4 + PI, 0.7, -1.1 + PI], [0.4, 0.7, -1.0], [0.4 + PI, -0.7, -1.1]] {
            assert!(!is_same(&euler, &wrong, &wanted), "{wrong:?}");
        }
        let vector = [Measure::RotationVector(0), Measure::RotationVector(1), Measure::RotationVector(2)];
        let wanted = [1.0, 2.0, -2.0];
        let longer = |turns: f64| [0, 1, 2].map(|i| wanted[i] * (1.0 + TAU * turns / 3.0));
        assert!(is_same(&vector, &longer(1.0), &wanted) && is_same(&vector, &longer(-2.0), &wanted));
        assert!(!is_same(&vector, &longer(0.5), &wanted) && !is_same(&vector, &[2.0, 1.0, -2.0], &wanted));
        assert!(
            is_as_near(&[1.0, 1.0], &[0.0, 1.5], &[0.0; 2])
                && !is_as_near(&[3.0, 1.0], &[0.0, 0.5], &[0.0; 2])
        );
    }

    /// Two of three Euler angles of the other sheet say that it is meant, the third then being wrong: not one alone, nor where it is farther.
    #[test]
    fn two_angles_tell_the_sheet() {
        let wanted = vec![0.4, 0.7, -1.1];
        let other = [0.4 + PI, -0.7 - 2.0 * 0.2, -1.1 + PI];
        let told = |found: [f64; 3], before: Option<[f64; 3]>| {
            let angles = Angles {
                components: vec![3, 4, 5],
                measures: [1, 2, 3].map(Measure::Euler).to_vec(),
                found: found.to_vec(),
                wanted: wanted.clone(),
                first: [None, None, None, Some(0.1), Some(0.2), Some(0.3)],
            };
            let before = before.map(|[x, y, z]| [None, None, None, Some(x), Some(y), Some(z)]);
            mostly_euler(&angles, before.as_ref())
        };
        let [x, y, z] = other;
        let found = told([x, -y, z], None).unwrap();
        assert!(found.iter().zip(other).all(|(x, y)| is_turn(x - y)), "{found:?} {other:?}");
        assert!(told([x, y + 0.3, z], Some([3.0, -1.0, 2.0])).is_some());
        assert!(told([x, y + 0.3, z + 0.2], None).is_none());
        assert!(told([0.4, y, z], None).is_none());
        assert!(told([x, y + 0.3, z], Some([0.4, 0.7, -1.0])).is_none());
    }
}
