//! Every angle that is counted, and what follows the turns, at every step of a motion that winds through ±π and 2πk, either way: the
//! angles are prescribed, so that each step has one right answer.

use crate::case::Step;
use crate::laws::{Demand, What};
use crate::sampling::{Turning, definition, pair, turning};
use crate::singular::beside::{by_cardan_angles, by_euler_angles, by_shafts};
use pintle_kinematics::catalog::{COMPONENT, ConnectionType};
use pintle_kinematics::connector::{Connector, Output, Request, Tally};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::scalar::U;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{Matrix, Vector, apply, column, dot, product, scale, sub};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// How far a motion winds (rad): both angles past ±4π and back through every multiple of π.
const FAR: f64 = 19.0;

/// The angle of a step (rad).
const STEP: f64 = 0.35;

/// The share of the last angle in the turns of the first, of the other sign: the two do not wind alike.
const SHARE: f64 = -0.7;

/// The last angle at the start (rad).
const LAST: f64 = -0.3;

/// The first angle at the start (rad).
const FIRST: f64 = 0.4;

/// A motion of b against a by its angles.
struct Winding {
    turning: Turning,
    /// The angle between the two that wind.
    middle: f64,
    /// The axis of a rotation vector, along a's directions.
    axis: Vector<f64>,
    /// d along a's directions.
    d: Vector<f64>,
}

impl Winding {
    fn of(connection: &ConnectionType, draw: &mut Draw) -> Option<Self> {
        let turning = turning(connection);
        let middle = match turning {
            Turning::Cardan => 0.4,
            Turning::Euler | Turning::Torsion => 0.9,
            Turning::Universal | Turning::Revolute | Turning::Align | Turning::RotationVector => 0.0,
            Turning::Flow | Turning::None => return None,
        };
        Some(Self { turning, middle, axis: draw.direction(), d: draw.direction() })
    }

    /// The first and the last angle after `t`.
    fn angles(&self, t: f64) -> [f64; 2] {
        match self.turning {
            Turning::Revolute => [FIRST + t, 0.0],
            _ => [FIRST + t, LAST + SHARE * t],
        }
    }

    /// Q after `t`.
    fn orientation(&self, t: f64) -> Matrix<f64> {
        let [first, last] = self.angles(t);
        let angles = [first, self.middle, last];
        match self.turning {
            Turning::Euler => by_euler_angles(angles),
            Turning::Torsion => by_shafts(angles),
            Turning::Align | Turning::RotationVector => exp(scale(self.axis, t)),
            _ => by_cardan_angles(angles),
        }
    }

    /// What a measure is after `t`, but for a constant; `None` of one that this motion says nothing of.
    fn position(&self, measure: Measure, t: f64) -> Option<f64> {
        let [first, last] = self.angles(t);
        // The directions midway between a and b follow half the torsion.
        let half = (first - last) / 2.0;
        Some(match (self.turning, measure) {
            (Turning::Cardan | Turning::Universal | Turning::Revolute, Measure::Cardan(i))
            | (Turning::Euler, Measure::Euler(i)) => [first, self.middle, last][i - 1],
            (Turning::Torsion, Measure::Torsion) => first + last,
            (Turning::Torsion, Measure::Sweep) => first,
            (Turning::Torsion, Measure::Flexion) => self.middle,
            (Turning::Torsion, Measure::ComponentFlexion(i)) => {
                self.middle * if i == 1 { (half + FRAC_PI_2).cos() } else { (half + FRAC_PI_2).sin() }
            }
            (Turning::Torsion, Measure::ProjectedPosition(i)) => {
                dot(column(&by_shafts([first, self.middle / 2.0, -half]), i - 1), self.d)
            }
            (Turning::RotationVector, Measure::RotationVector(i) | Measure::RotationVectorAtB(i)) => {
                t * self.axis[i - 1]
            }
            // Principal: what was turned by 2π is where it was.
            (Turning::Align, Measure::Misalignment(i)) => {
                let principal = t - TAU * (t / TAU).round();
                if PI - principal.abs() < STEP / 4.0 {
                    return None;
                }
                principal * self.axis[i - 1]
            }
            _ => return None,
        })
    }
}

/// What every angle of a type must be at every step of such a motion, of either direction, while a turns as well.
pub(super) fn winding(connection: &ConnectionType) -> Vec<Demand> {
    let draw = &mut Draw::new(&connection.name);
    let mut found = Vec::new();
    let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
    for sign in [1.0, -1.0] {
        let Some(winding) = Winding::of(connection, draw) else { return found };
        let (a0, common) = (draw.triad(), draw.rotation(0.3, 1.2));
        let initial = pair(apply(&a0, winding.d), a0, &winding.orientation(0.0));
        let definition = definition(connection, initial, 1.0);
        let connector = Connector::<f64>::new(&definition);
        let mut branch = connector.initial_branch();
        let mut before = initial;
        let steps = (FAR / STEP) as usize;
        for step in 1..=steps {
            let share = step as f64 / steps as f64;
            let t = sign * FAR * share;
            let mut after = initial;
            after.a.triad = product(&exp(scale(common, share)), &a0);
            after.b.triad = product(&after.a.triad, &winding.orientation(t));
            after.b.displacement = sub(apply(&after.a.triad, winding.d), initial.reference);
            let Step { state, increment } = Step::between(&before, after);
            let now = connector.evaluate(&state, &increment, &branch, &asked, &mut Tally::default());
            for (k, component) in COMPONENT.iter().enumerate() {
                let measured = match connector.differentiated(k) {
                    Some(measure @ Measure::Misalignment(_)) => Some((measure, now.residual[k])),
                    _ => connector.position_measure(k).map(|measure| (measure, now.displacement[k])),
                };
                let Some((measure, Some(offset))) = measured else { continue };
                let [Some(start), Some(end)] = [0.0, t].map(|t| winding.position(measure, t)) else {
                    continue;
                };
                let what = What::Said(format!("{component} on the way, turned by {t:.2} rad"));
                let allowed = 64.0 * U * (1.0 + t.abs());
                found.push(Demand { terms: Vec::new().into(), offset, want: end - start, allowed, what });
            }
            branch = now.branch;
            before = after;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use pintle_kinematics::catalog::TABLE;

    /// Every angle that winds, and every constraint on a frozen orientation, is asked of by some type, meets what is demanded, and would not
    /// one turn off.
    #[test]
    fn every_angle_is_followed_through_its_turns() {
        let mut asked = std::collections::BTreeSet::new();
        for connection in TABLE {
            for demand in winding(connection) {
                let error = (demand.offset - demand.want).abs();
                assert!(error <= demand.allowed, "{} {}: {error:e}", connection.name, demand.what);
                let component = demand.what.to_string().chars().take(3).collect::<String>();
                asked.insert((connection.name.to_string(), component));
            }
            let winds = |k: usize| {
                let measure = connection.slots[k].position();
                measure.is_some_and(|m| m.winds() || matches!(m, Measure::RotationVector(_)))
            };
            for k in (0..6).filter(|k| winds(*k)) {
                let is_free = matches!(connection.slots[k], pintle_kinematics::catalog::Slot::Available(_));
                let key = (connection.name.to_string(), COMPONENT[k].to_string());
                assert!(!is_free || asked.contains(&key), "{key:?}");
            }
        }
        for of in
            [("BEAM", "ur1"), ("WELD", "ur3"), ("TRANSLATOR", "ur2"), ("CARDAN", "ur3"), ("EULER", "ur3")]
        {
            assert!(asked.contains(&(of.0.to_string(), of.1.to_string())), "{of:?}");
        }
    }
}
