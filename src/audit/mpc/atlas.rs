//! The singular points of multi-point constraints, approached on the ladder of the atlas: what is declared of an equation, or of the angle
//! of a hinge, is compared with what happens there.
//!
//! The angle of a hinge has no row among the numbers of a constraint. Its derivatives
//! are its rates as one degree of freedom moves at a time; the truth is differences of the angle on 237 bits.

use crate::case::failing::MpcCase;
use crate::judge::bound::scales;
use crate::mpc::{exact, moved};
use crate::oracles::truth::rotation;
use crate::singular::atlas::{Approach, Beside, LADDER, Rung, SIDES, classify};
use pintle_kinematics::connector::{Output, Request, Tally, Turns};
use pintle_kinematics::measure::{SingularSet, Unit};
use pintle_kinematics::mpc::{
    Body, Constraint, DOFS, Dofs, Evaluation, MpcType, PSI_M, PSI_S, RHO, ROWS, State, THETA_M, THETA_S,
    Turning,
};
use pintle_kinematics::scalar::{Scalar, Wide};
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{self, product, scale};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// The degrees of freedom of rotation of both nodes, by which the angles of hinges have derivatives.
const ROTATIONS: [usize; 6] = [THETA_S, THETA_S + 1, PSI_S - 1, THETA_M, THETA_M + 1, PSI_M - 1];

/// What a set is declared of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SetOf {
    /// An equation.
    Row(usize),
    /// The angle of a hinge.
    Angle(usize),
}

/// A declared set of a kind.
#[derive(Clone, Copy, Debug)]
struct DeclaredSet {
    kind: MpcType,
    subject: SetOf,
    set: SingularSet,
}

/// Every declared set of every kind, approached.
pub(crate) fn approaches() -> Vec<Approach> {
    let all: Vec<DeclaredSet> = MpcType::ALL.into_iter().flat_map(points).collect();
    all.par_iter().map(DeclaredSet::approach).collect()
}

fn points(kind: MpcType) -> Vec<DeclaredSet> {
    let rows = kind.rows(false);
    let of_rows = (0..ROWS)
        .filter(|row| rows[*row])
        .filter_map(|row| Some(DeclaredSet { kind, subject: SetOf::Row(row), set: kind.row_set(row)? }));
    let of_angles = (0..kind.entry().angles.len())
        .filter_map(|i| Some(DeclaredSet { kind, subject: SetOf::Angle(i), set: kind.angle_set()? }));
    of_rows.chain(of_angles).collect()
}

impl DeclaredSet {
    /// A state `distance` away, on the other side where negative, in the direction `azimuth` (rad).
    fn beside(&self, distance: f64, azimuth: f64) -> MpcCase {
        let Self { kind, subject, .. } = *self;
        let (sine, cosine) = azimuth.sin_cos();
        let [e1, e2, e3] = vector::identity::<f64>();
        let arm = [1.0, 0.0, 0.0];
        let mut body = [Body::at_rest(), Body::at_rest()];
        let common = exp([0.4, -0.7, 0.5]);
        let angles = [0.3, -0.4];
        let relative = match subject {
            // Across the link, so that it is as long as it says.
            SetOf::Row(row) if row < RHO => {
                body[0].displacement = [-1.0, distance * cosine, distance * sine];
                vector::identity()
            }
            SetOf::Row(_) => {
                // No component of the half turn is zero.
                let axis = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
                let across = [6.0 / 7.0, 2.0 / 7.0, -3.0 / 7.0];
                let direction = vector::add(scale(axis, cosine), scale(across, sine));
                let violation = product(&exp(scale(axis, PI)), &exp(scale(direction, -distance)));
                let hinges = angles.into_iter().zip([e3, e1]).take(kind.entry().angles.len());
                let allowed =
                    hinges.fold(common, |so_far, (angle, axis)| product(&so_far, &exp(scale(axis, angle))));
                product(&vector::transpose(&common), &product(&violation, &allowed))
            }
            // Half a turn across the axis; what is left of it turns by twice the distance.
            SetOf::Angle(_) if kind.entry().angles.len() == 1 => {
                let rest = vector::add(scale(e1, 2.0 * distance * cosine), scale(e2, 2.0 * distance * sine));
                product(&exp(scale(e1, PI)), &exp(rest))
            }
            // Turned by the first axis, across both, by the second: at a right angle only the difference of the first and the last is left.
            SetOf::Angle(_) => {
                let [first, last] = [0.7 + azimuth, -0.5 + azimuth].map(|angle| angle.rem_euclid(PI));
                let across = exp(scale(e2, FRAC_PI_2 - distance));
                product(&product(&exp(scale(e3, first)), &across), &exp(scale(e1, last)))
            }
        };
        let [slave, master] = &mut body;
        master.rotation = common;
        slave.rotation = product(&common, &relative);
        let [slave, master] = body;
        let given = if matches!(subject, SetOf::Row(_)) { angles.map(Some) } else { [None; 2] };
        let still = [0.0; DOFS];
        MpcCase {
            name: format!("{} {distance:e} from {}", kind.name(), self.set.at),
            constraint: Constraint::new(kind, arm, [0.0; 3], [e3, e1]),
            state: State { slave, master, angles: given, velocity: still, acceleration: still },
            turning: Turning::none(),
            before: [Turns { turns: 0.0, principal: 0.0 }; 2],
            length: 1.0,
        }
    }

    /// What the product says that far away.
    fn said(&self, distance: f64, azimuth: f64) -> Option<Beside> {
        let case = self.beside(distance, azimuth);
        match self.subject {
            SetOf::Row(row) => Beside::of_equation(&case.said(), row),
            SetOf::Angle(i) => Some(Beside::of_angle(&case, i)),
        }
    }

    /// The same, and how far off it is.
    fn rung(&self, distance: f64) -> Option<Rung> {
        let case = self.beside(distance, 0.0);
        match self.subject {
            SetOf::Row(row) => of_equation(&case, row, distance),
            SetOf::Angle(i) => Some(of_angle(&case, i, distance)),
        }
    }

    fn approach(&self) -> Approach {
        let rungs: Vec<Rung> = LADDER.par_iter().filter_map(|distance| self.rung(*distance)).collect();
        let (component, unit) = match self.subject {
            SetOf::Row(row) => (self.kind.row_name(row), MpcType::row_unit(row)),
            SetOf::Angle(i) => (self.kind.entry().angles.get(i).copied().unwrap_or_default(), Unit::Angle),
        };
        Approach {
            connection: self.kind.name().to_string(),
            component,
            set: self.set.at,
            at: self.set.at,
            declared: self.set.class,
            seen: classify(&SIDES, unit, |distance, azimuth| self.said(distance, azimuth)),
            exact: rungs.len() == LADDER.len() && rungs.iter().all(Rung::is_exact),
            rungs,
        }
    }
}

impl Beside {
    /// An equation, as an evaluation has it.
    fn of_equation(got: &Evaluation<f64>, row: usize) -> Option<Self> {
        let first = got.jacobian[row]?.to_vec();
        let second = got.hessian[row].as_ref()?.as_flattened().to_vec();
        Some(Self { value: got.residual[row]?, first, second })
    }

    /// The angle of hinge `i`, whose derivatives are its rates as one degree of freedom moves at a time.
    fn of_angle(case: &MpcCase, i: usize) -> Self {
        let along = |j: Option<usize>| {
            let mut state = case.state;
            state.velocity = std::array::from_fn(|at| if Some(at) == j { 1.0 } else { 0.0 });
            let request = Request::new(&[Output::CV], [true; 6], 0);
            let tally = &mut Tally::default();
            case.constraint.evaluate(&state, &case.before, &Turning::none(), &request, tally)
        };
        let value = along(None).angles[i].principal;
        let rate = |j: usize| along(Some(j)).angle_rates.map_or(f64::NAN, |rates| rates[i][0]);
        Self { value, first: ROTATIONS.map(rate).to_vec(), second: Vec::new() }
    }
}

/// Of an equation. Second derivatives are in the scales alone.
fn of_equation(case: &MpcCase, row: usize, distance: f64) -> Option<Rung> {
    let got = case.said();
    let truth = case.truth(&got);
    let beside = Beside::of_equation(&got, row)?;
    let value = truth.values_of(truth.given)[row]?;
    let first: Vec<Wide> = truth.first().iter().map(|rows| rows[row]).collect::<Option<_>>()?;
    let slopes: Vec<f64> = first.iter().map(|x| x.to_f64()).collect();
    let still = [0.0; DOFS];
    let input = case.inputs(&got.taken);
    let [of_value, of_first, ..] = scales(
        value.to_f64(),
        &slopes,
        &beside.second,
        (&truth.sizes, &input),
        (&still, &still),
        truth.nearness[row],
    );
    Some(Rung::of(distance, [(&[beside.value], &[value], of_value), (&beside.first, &first, of_first)]))
}

/// Of the angle of hinge `i`, `distance` away from its set.
fn of_angle(case: &MpcCase, i: usize, distance: f64) -> Rung {
    let beside = Beside::of_angle(case, i);
    let given = exact(&case.state);
    let mut state = given;
    for body in [&mut state.slave, &mut state.master] {
        body.rotation = rotation(body.rotation);
    }
    let constraint: Constraint<Wide> = case.constraint.exact();
    let angle = |state: &State<Wide>| {
        let zero = Wide::zero();
        let start = [Turns { turns: zero, principal: zero }; 2];
        let tally = &mut Tally::default();
        constraint.evaluate(state, &start, &Turning::none(), &Request::nothing(0), tally).angles[i].principal
    };
    let after = |steps: &[(usize, Wide)]| {
        let mut by: Dofs<Wide> = [Wide::zero(); DOFS];
        for (j, step) in steps {
            by[*j] += *step;
        }
        angle(&moved(&state, &by))
    };
    let h = Wide::from_f64(1e-25 * distance);
    let first = ROTATIONS.map(|j| (after(&[(j, h)]) - after(&[(j, -h)])) / (h + h));
    // Ahead alone: second derivatives are in the scales alone.
    let h = Wide::from_f64(1e-18 * distance);
    let still = angle(&state);
    let alone = ROTATIONS.map(|j| after(&[(j, h)]) - still);
    let mut second = [[0.0; ROTATIONS.len()]; ROTATIONS.len()];
    for (m, j) in ROTATIONS.into_iter().enumerate() {
        for (n, k) in ROTATIONS.into_iter().enumerate().take(m + 1) {
            let both = after(&[(j, h), (k, h)]) - still;
            second[m][n] = ((both - alone[m] - alone[n]) / (h * h)).to_f64();
            second[n][m] = second[m][n];
        }
    }
    let (sizes, still) = ([1.0; ROTATIONS.len()], [0.0; ROTATIONS.len()]);
    let slopes = first.map(|x| x.to_f64());
    let sides = (&sizes[..], &sizes[..]);
    let [of_value, of_first, ..] =
        scales(beside.value, &slopes, second.as_flattened(), sides, (&still, &still), distance);
    let value = angle(&given);
    Rung::of(distance, [(&[beside.value], &[value], of_value), (&beside.first, &first, of_first)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each declared set is what it is declared to be, to 1e-15 and with numbers that are right to rounding; the states are as far from it
    /// as they say.
    #[test]
    fn declared_sets_are_what_they_are() {
        let found = approaches();
        let declared: usize = MpcType::ALL.into_iter().map(|kind| points(kind).len()).sum();
        assert!(found.len() == declared && declared == 16, "{declared}");
        for approach in &found {
            let Approach { connection, component, .. } = approach;
            assert!(approach.is_confirmed(), "{connection} {component}: {} {approach:?}", approach.told());
        }
        for point in MpcType::ALL.into_iter().flat_map(points) {
            let case = point.beside(1e-3, 0.0);
            let request = Request::nothing(0);
            let tally = &mut Tally::default();
            let got = case.constraint.evaluate(&case.state, &case.before, &case.turning, &request, tally);
            let margins = case.constraint.margins(&case.state, &got);
            let margin = match point.subject {
                SetOf::Row(row) => margins.rows[row],
                SetOf::Angle(i) => margins.angles[i],
            };
            let distance = margin.map_or(f64::NAN, |margin| margin.distance);
            assert!((distance - 1e-3).abs() < 1e-8, "{point:?}: {distance}");
        }
    }
}
