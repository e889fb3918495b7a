//! Laws of a type: the initial state, and turns without end. The numbers judged are in the demands themselves.

use crate::case::Case;
use crate::laws::turns::winding;
use crate::laws::{Demand, Invariant, What};
use crate::sampling::{Motion, Turning, aligned, definition, pair, spin_axis, turning};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Connector, Increment, Output, Request, State, Tally};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::U;
use pintle_kinematics::vector::{self, Vector, column, scale};

/// What a type must give at its initial state, and after turns about the axis about which it may turn without end. The numbers
/// judged are in the demands themselves.
pub fn of_type(connection: &ConnectionType, invariant: Invariant) -> Vec<Demand> {
    match invariant {
        Invariant::Start => start(connection),
        Invariant::Turns => {
            let mut found = turns(connection, false);
            found.extend(winding(connection));
            found
        }
        Invariant::FreeAxis => turns(connection, true),
        _ => Vec::new(),
    }
}

fn start(connection: &ConnectionType) -> Vec<Demand> {
    let draw = &mut Draw::new(&connection.name);
    let mut found = Vec::new();
    for _ in 0..4 {
        let q0 = aligned(connection, draw);
        let definition = definition(connection, pair(draw.direction(), draw.triad(), &q0), 1.0);
        let connector = Connector::<f64>::new(&definition);
        let state = State { pair: definition.initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let mut tally = Tally::default();
        let evaluation =
            connector.evaluate(&state, &Increment::none(), &connector.initial_branch(), &asked, &mut tally);
        for k in 0..6 {
            let name = pintle_kinematics::catalog::COMPONENT[k];
            if let Some(offset) = evaluation.displacement[k] {
                let what = What::Said(format!("displacement {name} at the start"));
                found.push(Demand { terms: Vec::new().into(), offset, want: 0.0, allowed: 0.0, what });
            }
            if let Some(offset) = evaluation.residual[k] {
                // A printed cosine is as far from zero as the directions given are.
                let what = What::Said(format!("residual {name} at the start"));
                found.push(Demand { terms: Vec::new().into(), offset, want: 0.0, allowed: 8.0 * U, what });
            }
        }
    }
    found
}

/// After turns about the free axis: what the angles must be, or that the printed constraints of axes are met.
fn turns(connection: &ConnectionType, constraints: bool) -> Vec<Demand> {
    const SIZES: [f64; 6] = [3.0, 3.3, 6.2, 6.4, 20.0, 100.0];
    let draw = &mut Draw::new(&connection.name);
    let mut found = Vec::new();
    for size in SIZES.into_iter().flat_map(|size| [size, -size]) {
        let q0 = match turning(connection) {
            Turning::RotationVector => vector::identity(),
            _ => aligned(connection, draw),
        };
        let a0 = draw.triad();
        let axis = spin_axis(connection, &a0, draw);
        let definition = definition(connection, pair(draw.direction(), a0, &q0), 1.0);
        let steps = (size.abs() / 0.35) as usize;
        let motion = Motion { steps, ..Motion::random(draw, 1.0, scale(axis, size)) };
        let path = motion.path(&definition.initial);
        let case = Case { name: String::new(), definition, start: None, path, length: 1.0 };
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let Some((evaluation, _)) = case.evaluation(&asked) else { continue };
        if constraints {
            let is_met = matches!(turning(connection), Turning::Universal | Turning::Revolute);
            for k in (3..6).filter(|_| is_met) {
                let Some(offset) = evaluation.residual[k] else { continue };
                let what = What::Said(format!(
                    "residual {} after {size} rad",
                    pintle_kinematics::catalog::COMPONENT[k]
                ));
                // Each step turns the triads once more, and each time they are rounded.
                let allowed = 8.0 * U * (1.0 + steps as f64);
                found.push(Demand { terms: Vec::new().into(), offset, want: 0.0, allowed, what });
            }
            continue;
        }
        let along: Vector<f64> = [0, 1, 2].map(|i| {
            let direction = column(&a0, i);
            (0..3).map(|j| direction[j] * axis[j]).sum()
        });
        for k in 3..6 {
            let position = connection.slots[k].position();
            let want = match (turning(connection), position) {
                (Turning::Cardan | Turning::Universal | Turning::Revolute, Some(Measure::Cardan(1)))
                | (Turning::Euler, Some(Measure::Euler(1)))
                | (_, Some(Measure::Torsion)) => size,
                (_, Some(Measure::RotationVector(i))) => size * along[i - 1],
                _ => continue,
            };
            // CONSTANT VELOCITY measures torsion about shafts that stay; elsewhere the axis is that of the angle.
            let Some(offset) = evaluation.displacement[k] else { continue };
            let what = What::Said(format!("{} after {size} rad", pintle_kinematics::catalog::COMPONENT[k]));
            let allowed = 64.0 * U * (1.0 + size.abs());
            found.push(Demand { terms: Vec::new().into(), offset, want, allowed, what });
        }
    }
    found
}
