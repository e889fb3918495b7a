//! What needs care at a state: singular sets and how near they are, violations of the axes, turns that are not certain.

use crate::connector::{
    CERTAIN_INCREMENT, CERTAIN_TOLD, CERTAIN_TURNS, Flag, Holding, ILL_CONDITIONED, Turned, Turns,
};
use crate::measure::{Margin, Unit};
use crate::mpc::{Constraint, Evaluation, FLOW, MpcType, RHO, ROWS, Rows, State, Turning, angle_between};
use crate::scalar::elementary::norm;
use crate::scalar::{Duals, Real};
use crate::so3;
use crate::vector;
use crate::vector::{cross, dot};
use std::f64::consts::{PI, TAU};

impl<R: Duals> Constraint<R> {
    /// How far the relative rotation is from what the hinges allow (rad). One hinge: the angle of a carried by S to a carried by
    /// M. Two: how much the angle between the axes, a2 carried by S, differs from the initial one. `None` without hinges, where
    /// the residual tells it.
    pub fn misalignment(&self, state: &State<R>) -> Option<R> {
        let [first, second] = self.axes;
        let of_master = vector::apply(&state.master.rotation, first);
        let of_slave = |axis| vector::apply(&state.slave.rotation, axis);
        match self.hinges() {
            0 => None,
            1 => Some(angle_between(of_slave(first), of_master)),
            _ => {
                let now = angle_between(of_slave(second), of_master);
                Some((now - angle_between(second, first)).magnitude())
            }
        }
    }
}

/// The distances of a constraint to the points where its angles or equations, or derivatives of them, do not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Of the angles of the hinges.
    pub angles: [Option<Margin>; 2],
    /// Of the equations.
    pub rows: Rows<Margin>,
}

impl Constraint<f64> {
    /// The distances to singular points.
    pub fn margins(&self, state: &State<f64>, evaluation: &Evaluation<f64>) -> Margins {
        let relative = || vector::transposed_product(&state.master.rotation, &state.slave.rotation);
        let hinge = match self.hinges() {
            0 => None,
            1 => {
                let [w, x, y, z] = so3::quaternion(&relative());
                Some(norm([w, dot(self.axes[0], [x, y, z])]))
            }
            _ => Some(norm(cross(self.axes[0], vector::apply(&relative(), self.axes[1])))),
        };
        let hinge = hinge.and_then(|distance| Some(Margin { distance, set: self.kind.angle_set()? }));
        let [_, _, _, x, y, z, _] = evaluation.residual;
        let half_turn = || PI - norm([x, y, z].map(Option::unwrap_or_default));
        let mut rows = [None; ROWS];
        for (row, margin) in rows.iter_mut().enumerate().filter(|(row, _)| self.rows()[*row]) {
            let Some(set) = self.kind.row_set(row) else { continue };
            let distance = if row < RHO { norm(self.separation(state)) } else { half_turn() };
            *margin = Some(Margin { distance, set });
        }
        Margins { angles: [0, 1].map(|i| hinge.filter(|_| i < self.hinges())), rows }
    }

    /// What needs care at a state: no angles about the axes, a violation near half a turn, coincident nodes of a LINK. So
    /// do an increment too large to count its turns, and a residual beyond rounding of the coordinates.
    pub fn flags(
        &self,
        state: &State<f64>,
        previous: &[Turns<f64>; 2],
        turning: &Turning<f64>,
        evaluation: &Evaluation<f64>,
    ) -> Vec<Flag> {
        let mut flags = Vec::new();
        let Margins { angles, rows } = self.margins(state, evaluation);
        let names = self.kind.entry().angles;
        let once = rows.into_iter().enumerate().filter(|(row, _)| MpcType::flagged_row(*row) == *row);
        let named = once.map(|(row, margin)| (self.kind.row_name(row), margin));
        let of_angles = names.iter().copied().zip(angles);
        for (component, margin) in of_angles.chain(named) {
            let Some(Margin { distance, set }) = margin else { continue };
            let size = if set.unit == Unit::Length { self.extent(state) } else { 1.0 };
            if distance <= 0.0 {
                flags.push(Flag::Singular { component, at: set.at, class: set.class });
            } else if distance < ILL_CONDITIONED * size {
                flags.push(Flag::IllConditioned { component, at: set.at, class: set.class, distance });
            }
        }
        let winding = self.winding_axes(state);
        for (i, component) in names.iter().enumerate() {
            let (now, before) = (evaluation.angles[i], previous[i]);
            let axis = winding[i];
            let change = f64::with_turns(now.principal - before.principal, now.turns - before.turns);
            let whole = dot(axis, turning.whole) / TAU;
            let besides = change - dot(axis, turning.whole);
            let is_told =
                turning.whole != [0.0; 3] && (besides - dot(axis, turning.rest)).abs() < CERTAIN_TOLD * PI;
            let is_large = besides.abs() > CERTAIN_INCREMENT * PI && !is_told;
            if is_large || (whole - whole.round()).abs() > CERTAIN_TURNS {
                flags.push(Flag::LargeIncrement { component, of: Turned::Component, change });
            }
        }
        let sizes = |row| match row {
            RHO..FLOW => 1.0,
            FLOW => state.slave.flow.abs().max(state.master.flow.abs()),
            _ => self.extent(state),
        };
        flags.extend(evaluation.residual.iter().enumerate().filter_map(|(row, residual)| {
            Flag::off(self.kind.row_name(row), Holding::Constraint, (*residual)?, sizes(row))
        }));
        flags
    }

    /// The largest of the lengths from which x_S − x_M is formed.
    fn extent(&self, state: &State<f64>) -> f64 {
        let lengths = [self.arm, state.slave.displacement, state.master.displacement];
        lengths.as_flattened().iter().fold(0.0, |most, length| most.max(length.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connector::{Request, Tally};
    use crate::mpc::{Body, MpcType};
    use crate::vector::Vector;

    const START: [Turns<f64>; 2] = [Turns { turns: 0.0, principal: 0.0 }; 2];

    fn flags(kind: MpcType, of_slave: Vector<f64>, displacement: Vector<f64>) -> Vec<Flag> {
        let hinges = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        let constraint = Constraint::<f64>::new(kind, [3.0, 0.0, 0.0], [0.0; 3], hinges);
        let slave = Body { rotation: so3::matrix(so3::exp_quaternion(of_slave)), displacement, flow: 0.0 };
        let state = State { slave, ..State::at_rest() };
        let turning = Turning::none();
        let evaluation =
            constraint.evaluate(&state, &START, &turning, &Request::nothing(0), &mut Tally::default());
        constraint.flags(&state, &START, &turning, &evaluation)
    }

    fn is(flags: &[Flag], component: &str, name: &str) -> bool {
        flags.iter().any(|flag| flag.component() == component && flag.name() == name)
    }

    /// A half turn across the axis leaves no angle about it, and one about it cannot be counted.
    #[test]
    fn half_turns_are_flagged() {
        let revolute = |of_slave| flags(MpcType::Revolute, of_slave, [0.0; 3]);
        assert!(revolute([0.0, 0.0, 0.3]).is_empty());
        let across = revolute([PI, 0.0, 0.0]);
        assert!(is(&across, "φJ", "ill-conditioned"), "{across:?}");
        let tilted = revolute([0.1, 0.2, 0.3]);
        assert!(is(&tilted, "ρ1", "off-constraint") && is(&tilted, "ρ2", "off-constraint"), "{tilted:?}");
        let about = revolute([0.0, 0.0, 3.1]);
        assert!(matches!(about[..], [Flag::LargeIncrement { component: "φJ", .. }]), "{about:?}");
    }

    /// The axes of a universal joint become parallel by a quarter turn across both.
    #[test]
    fn parallel_axes_are_flagged() {
        let universal = |of_slave| flags(MpcType::Universal, of_slave, [0.0; 3]);
        assert!(universal([0.1, 0.0, 0.0]).is_empty());
        let locked = universal([0.0, PI / 2.0, 0.0]);
        assert!(is(&locked, "φ1", "ill-conditioned") && is(&locked, "φ2", "ill-conditioned"), "{locked:?}");
    }

    /// A link whose nodes meet has no direction; a rigid beam that turned by half has no sign.
    #[test]
    fn links_and_beams_are_flagged() {
        assert!(flags(MpcType::Link, [0.0; 3], [-3.0, 3.0, 0.0]).is_empty());
        assert!(flags(MpcType::Link, [0.0; 3], [-3.0, 3.000_005, 0.0]).is_empty());
        assert!(is(&flags(MpcType::Link, [0.0; 3], [-3.0, 3.000_007, 0.0]), "δl", "off-constraint"));
        assert!(is(&flags(MpcType::Link, [0.0; 3], [-3.0, 0.0, 0.0]), "δl", "singular"));
        assert!(is(&flags(MpcType::Link, [0.0; 3], [-3.0, 1e-9, 0.0]), "δl", "ill-conditioned"));
        assert!(is(&flags(MpcType::Beam, [PI - 1e-9, 0.0, 0.0], [0.0; 3]), "ρ1", "ill-conditioned"));
        let pin = flags(MpcType::Pin, [PI, 0.0, 0.0], [9.0; 3]);
        assert!(pin.len() == 3 && is(&pin, "δ2", "off-constraint"), "{pin:?}");
        assert!(flags(MpcType::Pin, [PI, 0.0, 0.0], [0.0; 3]).is_empty());
    }
}
