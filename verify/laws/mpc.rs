//! Multi-point constraints: derivatives are differences, rates are those of the rows, rigid motions of what is held cost nothing,
//! turns are counted, and the equations are those of connectors where both hold the same thing.

use super::{Check, U};
use crate::states::{Draw, exp};
use pintle_audit::mpc::{exact, moved};
use pintle_kinematics::Differentiable;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{
    Connector, Definition, Increment, NodalRow, Output, Request, Tally, Turns,
};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::mpc::{
    Body, Constraint, DOFS, Dofs, Evaluation, FLOW, MpcType, PHI, PSI_M, PSI_S, RHO, ROWS, Rows, State,
    THETA_M, THETA_S, Turning, XM, XS,
};
use pintle_kinematics::node;
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{
    Matrix, Vector, add, apply, column, cross, dot, product, scale, sub, transpose,
};
use std::f64::consts::{PI, TAU};

/// The step of central differences, in units of the degree of freedom.
const STEP: f64 = 1e-25;

const START: [Turns<f64>; 2] = [Turns { turns: 0.0, principal: 0.0 }; 2];

/// A constraint at a state, with what it was made of.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) kind: MpcType,
    pub(crate) positions: [Vector<f64>; 4],
    pub(crate) state: State<f64>,
    pub(crate) length: f64,
    /// Whether the constraint holds but for rounding.
    pub(crate) holds: bool,
}

impl Case {
    pub(crate) fn constraint<R: Differentiable>(&self) -> Constraint<R> {
        let [slave, master, first, second] = self.positions;
        Constraint::new(self.kind, slave, master, [first, second]).with_flow()
    }

    pub(crate) fn evaluate(&self, request: &Request) -> Evaluation<f64> {
        self.constraint().evaluate(&self.state, &START, &Turning::none(), request, &mut Tally::default())
    }

    /// The sizes of degrees of freedom: 1 rad, or a length.
    pub(crate) fn sizes(&self) -> Dofs<f64> {
        std::array::from_fn(|j| {
            let turns = (THETA_S..PSI_S).contains(&j) || (THETA_M..PSI_M).contains(&j) || j >= PHI;
            if turns { 1.0 } else { self.length }
        })
    }
}

/// Seeded states of every kind: where it holds, and where it is violated.
pub(crate) fn cases() -> Vec<Case> {
    let mut found = Vec::new();
    for kind in MpcType::ALL {
        let mut draw = Draw::new(&format!("mpc {}", kind.name()));
        for (number, (length, miss)) in
            [(1.0, 0.0), (1e3, 0.0), (1e-3, 0.0), (1.0, 1e-7), (1.0, 0.3), (1e3, 1.1), (1.0, 2.5)]
                .into_iter()
                .enumerate()
        {
            let positions = [(); 4].map(|()| draw.vector(length));
            let angles = [draw.between(-3.0, 3.0), draw.between(-1.2, 1.2)];
            let master = Body {
                displacement: draw.vector(length),
                rotation: exp(draw.rotation(0.3, 2.5)),
                flow: draw.between(-length, length),
            };
            let (off, slipped) = (draw.direction(), scale(draw.direction(), miss * length));
            let mut state = following(kind, &positions, &master, angles);
            state.slave.rotation = product(&exp(scale(off, miss)), &state.slave.rotation);
            state.slave.displacement = add(state.slave.displacement, slipped);
            let sizes = |rate: usize| {
                let size =
                    if matches!(rate, XS..THETA_S | XM..THETA_M | PSI_S | PSI_M) { length } else { 1.0 };
                (-size, size)
            };
            for j in 0..DOFS {
                let (low, high) = sizes(j);
                state.velocity[j] = draw.between(low, high);
                state.acceleration[j] = draw.between(low, high);
            }
            let name = format!("{} {}", kind.name(), number + 1);
            found.push(Case { name, kind, positions, state, length, holds: miss == 0.0 });
        }
    }
    found
}

/// Where S is if it follows M, with hinges at the given angles.
pub(crate) fn following<R: Differentiable>(
    kind: MpcType,
    positions: &[Vector<f64>; 4],
    master: &Body<R>,
    angles: [R; 2],
) -> State<R> {
    let [slave, at, first, second] = *positions;
    let constraint = Constraint::<R>::new(kind, slave, at, [first, second]);
    let mut rotation = master.rotation;
    for (axis, angle) in constraint.initial_axes().into_iter().zip(angles) {
        let axis = axis.map_or([R::zero(); 3], |axis| scale(axis, angle));
        rotation = product(&rotation, &exp(axis));
    }
    let carried = sub(apply(&master.rotation, constraint.arm()), constraint.arm());
    let displacement = match kind {
        MpcType::Beam | MpcType::Link => add(master.displacement, carried),
        _ => master.displacement,
    };
    let slave = Body { displacement, rotation, flow: master.flow };
    let given = [0, 1].map(|i| Some(angles[i]).filter(|_| constraint.initial_axes()[i].is_some()));
    State { slave, master: *master, angles: given, ..State::at_rest() }
}

/// A constraint of 237-bit numbers at the same state.
pub(crate) struct Truth {
    pub(crate) constraint: Constraint<Wide>,
    pub(crate) state: State<Wide>,
    pub(crate) sizes: Dofs<f64>,
}

impl Truth {
    pub(crate) fn of(case: &Case) -> Self {
        Self { constraint: case.constraint(), state: exact(&case.state), sizes: case.sizes() }
    }

    pub(crate) fn at(&self, by: &Dofs<Wide>, request: &Request) -> Evaluation<Wide> {
        let zero = Turns { turns: Wide::zero(), principal: Wide::zero() };
        let state = moved(&self.state, by);
        self.constraint.evaluate(&state, &[zero; 2], &Turning::none(), request, &mut Tally::default())
    }

    pub(crate) fn along(&self, j: usize, sign: i32) -> (Dofs<Wide>, Wide) {
        let h = Wide::from_f64(STEP * self.sizes[j]);
        let mut by = [Wide::zero(); DOFS];
        by[j] = h * Wide::integer(sign);
        (by, h)
    }

    /// The derivative of anything along a degree of freedom, by central differences.
    pub(crate) fn difference<const N: usize>(
        &self,
        j: usize,
        of: impl Fn(&Dofs<Wide>) -> [Option<Wide>; N],
    ) -> [Option<Wide>; N] {
        let ((plus, h), (minus, _)) = (self.along(j, 1), self.along(j, -1));
        let (ahead, behind) = (of(&plus), of(&minus));
        std::array::from_fn(|i| Some((ahead[i]? - behind[i]?) / (h + h)))
    }
}

/// The conditioned scales of an equation: of its value, first and second derivatives (see [`super`]).
struct Scales {
    value: f64,
    first: Dofs<f64>,
    second: f64,
    sizes: Dofs<f64>,
}

impl Scales {
    fn new(value: f64, gradient: &Dofs<f64>, hessian: &[Dofs<f64>; DOFS], sizes: Dofs<f64>) -> Self {
        let f = value.abs() + (0..DOFS).map(|j| gradient[j].abs() * sizes[j]).sum::<f64>();
        let bent: Dofs<f64> =
            std::array::from_fn(|j| (0..DOFS).map(|k| hessian[j][k].abs() * sizes[k]).sum());
        let second = f + (0..DOFS).map(|j| bent[j] * sizes[j]).sum::<f64>();
        Self { value: f, first: std::array::from_fn(|j| f / sizes[j] + bent[j]), second, sizes }
    }
}

fn same_node(j: usize, k: usize) -> Option<usize> {
    [THETA_S, THETA_M].into_iter().find(|at| (*at..at + 3).contains(&j) && (*at..at + 3).contains(&k))
}

/// Values, rows and second derivatives of every kind are differences of 237-bit values.
#[test]
fn derivatives_are_differences() {
    let (mut value, mut first, mut second) =
        (Check::of("mpc, value"), Check::of("mpc, first derivatives"), Check::of("mpc, second derivatives"));
    for case in cases() {
        let got = case.evaluate(&Request::everything(2));
        let truth = Truth::of(&case);
        let residual = Request::new(&[Output::RES], [true; 6], 0);
        let rows = Request::new(&[], [true; 6], 1);
        let still = truth.at(&[Wide::zero(); DOFS], &residual).residual;
        let at_rest = truth.at(&[Wide::zero(); DOFS], &rows).jacobian;
        let gradients: [Rows<Wide>; DOFS] =
            std::array::from_fn(|j| truth.difference(j, |by| truth.at(by, &residual).residual));
        for row in (0..ROWS).filter(|row| case.constraint::<f64>().rows()[*row]) {
            let place = |what: String| {
                let (case, name) = (&case.name, case.kind.row_name(row));
                move || format!("{case}, {name}, {what}")
            };
            let (gradient, hessian) = (got.jacobian[row].unwrap(), got.hessian[row].as_ref().unwrap());
            let scales = Scales::new(got.residual[row].unwrap(), &gradient, hessian, truth.sizes);
            value.compare(
                place("value".into()),
                got.residual[row].unwrap(),
                still[row].unwrap(),
                scales.value,
            );
            for j in 0..DOFS {
                let want = gradients[j][row].unwrap();
                first.compare(place(format!("∂{j}")), gradient[j], want, scales.first[j]);
            }
            for k in 0..DOFS {
                let change = truth.difference(k, |by| truth.at(by, &rows).jacobian[row].unwrap().map(Some));
                for j in 0..DOFS {
                    // exp(ε e_j) exp(h e_k) = exp(ε e_j + h e_k + ½ εh e_j × e_k).
                    let mut want = change[j].unwrap();
                    if let Some(at) = same_node(j, k) {
                        let mut axes = [[Wide::zero(); 3]; 2];
                        axes[0][j - at] = Wide::integer(1);
                        axes[1][k - at] = Wide::integer(1);
                        let row = at_rest[row].unwrap();
                        want -= dot(cross(axes[0], axes[1]), [row[at], row[at + 1], row[at + 2]])
                            / Wide::integer(2);
                    }
                    let scale = scales.second / (scales.sizes[j] * scales.sizes[k]);
                    second.compare(place(format!("∂{j}∂{k}")), hessian[j][k], want, scale);
                    assert!((hessian[j][k] - hessian[k][j]).abs() <= U * scale, "{}: symmetric", case.name);
                }
            }
        }
    }
    value.finish();
    first.finish();
    second.finish();
}

/// g at the time t of a motion with constant accelerations, rotations by exp((ω t + α t²/2)^).
fn along_time(truth: &Truth, t: Wide) -> Dofs<Wide> {
    let half = Wide::ratio(1, 2);
    std::array::from_fn(|j| t * (truth.state.velocity[j] + half * t * truth.state.acceleration[j]))
}

/// RESV = J q̇, RESA = J q̈ + RESB, and both are the derivatives of the residual in time; so are the rates of the angles.
#[test]
fn rates_are_those_of_the_rows() {
    let (mut rows, mut time) = (Check::of("mpc, rates from rows"), Check::of("mpc, rates in time"));
    for case in cases() {
        let got = case.evaluate(&Request::everything(2));
        let truth = Truth::of(&case);
        let sum = |row: &Dofs<f64>, rate: &Dofs<f64>| -> (f64, f64) {
            let terms = || row.iter().zip(rate).map(|(row, rate)| row * rate);
            (terms().sum(), terms().map(f64::abs).sum())
        };
        let (velocity, acceleration) = (&case.state.velocity, &case.state.acceleration);
        let values = Request::new(&[Output::RES, Output::CP], [true; 6], 0);
        let h = Wide::from_f64(1e-18);
        let [behind, here, ahead] = [-1, 0, 1].map(|n| {
            let by = along_time(&truth, h * Wide::integer(n));
            let found = truth.at(&by, &values);
            (found.residual, found.angles.map(|angle| Wide::with_turns(angle.principal, angle.turns)))
        });
        let differences = |[b, c, a]: [Wide; 3]| ((a - b) / (h + h), (a - c - c + b) / (h * h));
        for row in (0..ROWS).filter(|row| case.constraint::<f64>().rows()[*row]) {
            let place = |what: &'static str| {
                let (case, name) = (&case.name, case.kind.row_name(row));
                move || format!("{case}, {name}, {what}")
            };
            let gradient = got.jacobian[row].unwrap();
            let hessian = got.hessian[row].as_ref().unwrap();
            let (rate, rate_scale) = sum(&gradient, velocity);
            let bent: Dofs<f64> = std::array::from_fn(|j| sum(&hessian[j], velocity).0);
            let sizes: Dofs<f64> = std::array::from_fn(|j| sum(&hessian[j], velocity).1);
            let (bias, _) = sum(&bent, velocity);
            let bias_scale = sum(&sizes, &velocity.map(f64::abs)).0;
            let (accelerated, accelerated_scale) = sum(&gradient, acceleration);
            let resv = got.residual_rate[row].unwrap();
            let (resb, resa) = (got.residual_bias[row].unwrap(), got.residual_acceleration[row].unwrap());
            let scales = Scales::new(got.residual[row].unwrap(), &gradient, hessian, truth.sizes);
            let rate_scale = sum(&scales.first, &velocity.map(f64::abs)).0.max(rate_scale);
            let size: f64 = velocity.iter().zip(truth.sizes).map(|(rate, size)| rate.abs() / size).sum();
            let bias_scale = bias_scale.max(scales.second * size * size);
            let all = bias_scale + accelerated_scale.max(sum(&scales.first, &acceleration.map(f64::abs)).0);
            rows.against(place("J q̇"), resv, rate, rate_scale);
            rows.against(place("J̇ q̇"), resb, bias, bias_scale);
            rows.against(place("J q̈ + J̇ q̇"), resa, accelerated + bias, all);
            let (first, second) = differences([behind.0, here.0, ahead.0].map(|of| of[row].unwrap()));
            time.compare(place("rate"), resv, first, rate_scale);
            time.compare(place("acceleration"), resa, second, all);
        }
        for (i, name) in case.kind.entry().angles.iter().enumerate() {
            let (first, second) = differences([behind.1[i], here.1[i], ahead.1[i]]);
            let [rate, acceleration] = got.angle_rates.unwrap()[i];
            // The angles of a universal joint grow like 1/sin of the angle between its axes, as their margin tells.
            let margin = case.constraint::<f64>().margins(&case.state, &got).angles[i].unwrap().distance;
            let spins: f64 = velocity.iter().map(|rate| rate.abs()).sum();
            let scale = (spins + acceleration.abs() + spins * spins) / (margin * margin * margin);
            time.compare(|| format!("{}, rate of {name}", case.name), rate, first, spins / (margin * margin));
            time.compare(|| format!("{}, acceleration of {name}", case.name), acceleration, second, scale);
        }
    }
    rows.finish();
    time.finish();
}

/// A common rigid motion of nodes that hold changes nothing, for the kinds that are rigid connections; for PIN and TIE a common
/// translation does.
#[test]
fn rigid_motions_keep_what_holds() {
    let mut check = Check::of("mpc, rigid motion");
    for case in cases().into_iter().filter(|case| case.holds) {
        let mut draw = Draw::new(&format!("{} rigid", case.name));
        let turned =
            matches!(case.kind, MpcType::Beam | MpcType::Link | MpcType::Revolute | MpcType::Universal);
        let q: Matrix<f64> = if turned { exp(draw.rotation(0.2, 3.0)) } else { vector::identity() };
        let c = draw.vector(case.length);
        let place = |body: &Body<f64>, at: Vector<f64>| Body {
            displacement: sub(add(c, apply(&q, add(at, body.displacement))), at),
            rotation: product(&q, &body.rotation),
            ..*body
        };
        let [at_slave, at_master, ..] = case.positions;
        let state = State {
            slave: place(&case.state.slave, at_slave),
            master: place(&case.state.master, at_master),
            ..case.state
        };
        let carried = Case { state, ..case.clone() };
        for (which, case) in [("before", &case), ("after", &carried)] {
            let got = case.evaluate(&Request::everything(1));
            for (row, residual) in got.residual.iter().enumerate() {
                let Some(residual) = residual else { continue };
                let size = if matches!(row, RHO..FLOW) { 1.0 } else { case.length };
                check.against(|| format!("{}, {which}, row {row}", case.name), *residual, 0.0, size);
            }
        }
    }
    check.finish();
}

/// Every equation is independent of the others, and of itself if only the dependent degrees of freedom may move.
#[test]
fn equations_are_independent() {
    for case in cases() {
        let got = case.evaluate(&Request::new(&[], [true; 6], 1));
        let mut basis: Vec<Dofs<f64>> = Vec::new();
        let sizes = case.sizes();
        for row in got.jacobian.iter().flatten() {
            let row: Dofs<f64> = std::array::from_fn(|j| row[j] * sizes[j]);
            let inner = |a: &Dofs<f64>, b: &Dofs<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let mut rest = row;
            for other in &basis {
                let along = inner(&rest, other);
                rest.iter_mut().zip(other).for_each(|(rest, other)| *rest -= along * other);
            }
            let left = inner(&rest, &rest).sqrt();
            assert!(left > 0.1 * inner(&row, &row).sqrt(), "{}: dependent rows", case.name);
            basis.push(rest.map(|x| x / left));
        }
        let net = case.kind.rows(true).iter().filter(|row| **row).count();
        assert_eq!(basis.len(), net, "{}", case.name);
    }
}

/// Degrees of freedom that a kind does not have do not enter; those that it has do somewhere.
#[test]
fn columns_are_those_declared() {
    for kind in MpcType::ALL {
        let mut enters = [false; DOFS];
        for case in cases().into_iter().filter(|case| case.kind == kind) {
            let truth = Truth::of(&case);
            let residual = Request::new(&[Output::RES], [true; 6], 0);
            for (j, enters) in enters.iter_mut().enumerate() {
                let change = truth.difference(j, |by| truth.at(by, &residual).residual);
                *enters |= change.into_iter().flatten().any(|change| change.to_f64().abs() > 1e-6);
            }
        }
        assert_eq!(enters, kind.columns(true), "{}", kind.name());
    }
}

/// Angles are counted through turns, as a whole in one increment that tells them or step by step.
#[test]
fn angles_are_counted() {
    let mut check = Check::of("mpc, turns");
    for (kind, second) in [(MpcType::Revolute, 0.0), (MpcType::Universal, 0.8)] {
        let mut draw = Draw::new("turns of an MPC");
        let positions = [(); 4].map(|()| draw.vector(1.0));
        let [slave, master, first, other] = positions;
        let constraint = Constraint::<f64>::new(kind, slave, master, [first, other]);
        let master = Body { rotation: exp(draw.rotation(0.5, 1.0)), ..Body::at_rest() };
        let request = Request::new(&[Output::CP], [true; 6], 0);
        let mut angles = START;
        let steps = 400;
        for end in [1.0, -2.0] {
            for n in 1..=steps {
                let t = f64::from(n) / f64::from(steps) * end;
                let state = following(kind, &positions, &master, [60.0 * t, second * (9.0 * t).sin()]);
                angles = constraint
                    .evaluate(&state, &angles, &Turning::none(), &request, &mut Tally::default())
                    .angles;
            }
            let got = f64::with_turns(angles[0].principal, angles[0].turns);
            check.against(|| format!("{} after {end}", kind.name()), got, 60.0 * end, 60.0 * end.abs());
            // From the end of one path to the beginning of the other in one increment that tells its turns.
            let state = following(kind, &positions, &master, [0.0, 0.0]);
            let axis = apply(&master.rotation, constraint.initial_axes()[0].unwrap());
            let turning = Turning { whole: scale(axis, -TAU * angles[0].turns), rest: [0.0; 3] };
            let last = constraint.evaluate(&state, &angles, &turning, &request, &mut Tally::default());
            assert_eq!(last.angles[0].turns, 0.0, "{}", kind.name());
            angles = START;
        }
    }
    check.finish();
}

/// A hinge turned by exactly half a turn from nothing is at +π, or the way that S turned.
#[test]
fn a_joint_turned_by_half_is_principal() {
    let hinges = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    for kind in [MpcType::Revolute, MpcType::Universal] {
        let joint = Constraint::<f64>::new(kind, [0.0; 3], [0.0; 3], hinges);
        let rotation = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        let state = State { slave: Body { rotation, ..Body::at_rest() }, ..State::at_rest() };
        for (rest, turns) in [(0.0, 0.0), (PI, 0.0), (-PI, -1.0)] {
            let turning = Turning { whole: [0.0; 3], rest: [0.0, 0.0, rest] };
            let got =
                joint.evaluate(&state, &START, &turning, &Request::everything(0), &mut Tally::default());
            assert_eq!((got.angles[0].turns, got.angles[0].principal), (turns, PI), "{kind:?} {rest}");
        }
    }
}

/// The composition in the order of the theory, C(φ2 a2) C(φ1 a1) C_M with the axes as they are carried, is what is computed;
/// axes need not be orthogonal.
#[test]
fn compositions_agree() {
    let mut check = Check::of("mpc, compositions");
    for case in cases().into_iter().filter(|case| case.holds) {
        let got = case.evaluate(&Request::everything(1));
        let mut rotation = case.state.master.rotation;
        for (i, axis) in got.axes.into_iter().enumerate() {
            let Some(axis) = axis else { continue };
            rotation = product(&exp(scale(axis, case.state.angles[i].unwrap())), &rotation);
            // ∂ρ/∂φ_i = −a_i where the constraint holds.
            for k in 0..3 {
                let entry = got.jacobian[RHO + k].unwrap()[PHI + i];
                check.against(|| format!("{}, row of φ{}", case.name, i + 1), entry, -axis[k], 1.0);
            }
        }
        if case.kind.entry().hinges.is_none() {
            continue;
        }
        for (i, (got, want)) in
            rotation.as_flattened().iter().zip(case.state.slave.rotation.as_flattened()).enumerate()
        {
            check.against(|| format!("{}, entry {i}", case.name), *got, *want, 1.0);
        }
        for (i, name) in case.kind.entry().angles.iter().enumerate() {
            let angle = f64::with_turns(got.angles[i].principal, got.angles[i].turns);
            let margin = case.constraint::<f64>().margins(&case.state, &got).angles[i].unwrap().distance;
            let want = case.state.angles[i].unwrap();
            check.against(|| format!("{}, {name}", case.name), angle, want, (1.0 + want.abs()) / margin);
        }
    }
    check.finish();
}

/// A connector between M (a) and S (b) at the state of a case, with e1 of M along the first axis and e3 of S along the second.
fn connector(
    case: &Case,
    name: &str,
    triads: [Matrix<f64>; 2],
) -> pintle_kinematics::connector::Evaluation<f64> {
    let connection = ConnectionType::named(name, None).unwrap();
    let [slave, master, ..] = case.positions;
    let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let initial = Pair { reference: sub(slave, master), a: node(triads[0]), b: node(triads[1]) };
    let connector = Connector::<f64>::new(&Definition::new(connection, initial));
    let placed = |body: &Body<f64>, triad| Node {
        displacement: body.displacement,
        triad: product(&body.rotation, triad),
        flow: body.flow,
    };
    let pair = Pair {
        reference: initial.reference,
        a: placed(&case.state.master, &triads[0]),
        b: placed(&case.state.slave, &triads[1]),
    };
    let mut rates = [[0.0; node::DOFS]; 2];
    for (to, from) in rates.iter_mut().zip([&case.state.velocity, &case.state.acceleration]) {
        to[..7].copy_from_slice(&from[XM..PHI]);
        to[7..].copy_from_slice(&from[..XM]);
    }
    let state = pintle_kinematics::connector::State { pair, velocity: rates[0], acceleration: rates[1] };
    let (branch, request) = (connector.initial_branch(), Request::everything(2));
    connector.evaluate(&state, &Increment::none(), &branch, &request, &mut Tally::default())
}

/// A row of a connector between M and S by the degrees of freedom of a constraint.
fn reordered(row: &NodalRow<f64>) -> Dofs<f64> {
    std::array::from_fn(|j| match j {
        XS..XM => row[7 + j],
        XM..PHI => row[j - XM],
        _ => 0.0,
    })
}

/// The equations of a constraint span those of a connector that holds the same: whatever moves keep the one keep the other.
fn spans(check: &mut Check, case: &Case, rows: &[Dofs<f64>], of_connector: &[(String, Dofs<f64>)]) {
    let sizes = case.sizes();
    let scaled = |row: &Dofs<f64>| -> Dofs<f64> { std::array::from_fn(|j| row[j] * sizes[j]) };
    let inner = |a: &Dofs<f64>, b: &Dofs<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut basis: Vec<Dofs<f64>> = Vec::new();
    let reduce = |basis: &[Dofs<f64>], row: &Dofs<f64>| {
        let mut rest = *row;
        for _ in 0..2 {
            for other in basis {
                let along = inner(&rest, other);
                rest.iter_mut().zip(other).for_each(|(rest, other)| *rest -= along * other);
            }
        }
        rest
    };
    for row in rows {
        let rest = reduce(&basis, &scaled(row));
        let left = inner(&rest, &rest).sqrt();
        basis.push(rest.map(|x| x / left));
    }
    for (name, row) in of_connector {
        let row = scaled(row);
        let rest = reduce(&basis, &row);
        let size = inner(&row, &row).sqrt();
        check.against(|| format!("{}, {name}", case.name), inner(&rest, &rest).sqrt(), 0.0, size);
    }
}

/// Gives S of a revolute joint the spins that its hinge allows: ω_S = ω_M + φ̇ a, α_S = α_M + φ̈ a + φ̇ ω_M × a. Spins that it does
/// not allow bend the angle nearest to the rotations and the first Cardan angle differently.
fn follow_rates(case: &mut Case) {
    let got = case.evaluate(&Request::everything(0));
    let axis = got.axes[0].unwrap();
    let State { velocity, acceleration, .. } = &mut case.state;
    let spin: Vector<f64> = std::array::from_fn(|i| velocity[THETA_M + i]);
    let turned = cross(spin, axis);
    for i in 0..3 {
        velocity[THETA_S + i] = velocity[THETA_M + i] + velocity[PHI] * axis[i];
        acceleration[THETA_S + i] =
            acceleration[THETA_M + i] + acceleration[PHI] * axis[i] + velocity[PHI] * turned[i];
    }
}

/// Motions that a hinge allows keep the constraint, with the rates of the angle that were put in.
#[test]
fn allowed_motions_keep_the_constraint() {
    let mut check = Check::of("mpc, allowed motions");
    for mut case in cases().into_iter().filter(|case| case.holds && case.kind == MpcType::Revolute) {
        follow_rates(&mut case);
        let got = case.evaluate(&Request::everything(0));
        for row in RHO..FLOW {
            for (what, rates) in [("rate", got.residual_rate), ("acceleration", got.residual_acceleration)] {
                check.against(|| format!("{}, {what}", case.name), rates[row].unwrap(), 0.0, 10.0);
            }
        }
        let [rate, acceleration] = got.angle_rates.unwrap()[0];
        check.against(|| format!("{}, φ̇", case.name), rate, case.state.velocity[PHI], 10.0);
        check.against(|| format!("{}, φ̈", case.name), acceleration, case.state.acceleration[PHI], 10.0);
    }
    check.finish();
}

/// REVOLUTE, UNIVERSAL, BEAM, LINK and PIN hold what the connectors of those names (PIN: JOIN, of coincident nodes) hold: the
/// residuals vanish together, the rows span the same, the angles are the same.
#[test]
fn constraints_are_those_of_connectors() {
    let mut check = Check::of("mpc, as connectors");
    let mut compared = 0;
    for mut case in cases().into_iter().filter(|case| case.holds) {
        let identity: Matrix<f64> = vector::identity();
        if case.kind == MpcType::Pin {
            case.positions[0] = case.positions[1];
        }
        if case.kind == MpcType::Universal {
            // Orthogonal axes, as those of the connector.
            let [_, master, first, second] = case.positions;
            let (a, b) = (sub(first, master), sub(second, master));
            case.positions[3] = add(master, sub(b, scale(a, dot(a, b) / dot(a, a))));
            let angles = case.state.angles.map(|angle| angle.unwrap());
            let following = following(case.kind, &case.positions, &case.state.master, angles);
            case.state.slave.rotation = following.slave.rotation;
        }
        let constraint = case.constraint::<f64>();
        let [first, second] = constraint.initial_axes();
        let unit = |v: Vector<f64>| f64::direction_and_norm(v).0;
        let triad = |e1: Vector<f64>, e3: Vector<f64>| transpose(&[e1, unit(cross(e3, e1)), e3]);
        let (name, triads) = match case.kind {
            MpcType::Revolute => {
                let e1 = first.unwrap();
                let triad = triad(e1, unit(cross(e1, [0.3, -0.5, 0.7])));
                ("REVOLUTE", [triad, triad])
            }
            MpcType::Universal => {
                let triad = triad(first.unwrap(), unit(second.unwrap()));
                ("UNIVERSAL", [triad, triad])
            }
            MpcType::Beam => ("BEAM", [identity, identity]),
            MpcType::Link => ("LINK", [identity, identity]),
            MpcType::Pin => ("JOIN", [identity, identity]),
            MpcType::Tie => continue,
        };
        if case.kind == MpcType::Revolute {
            follow_rates(&mut case);
        }
        let got = case.evaluate(&Request::everything(2));
        let of = connector(&case, name, triads);
        let mut rows = Vec::new();
        for k in 0..6 {
            let Some(residual) = of.residual[k] else { continue };
            let size = if k < 3 { case.length } else { 1.0 };
            check.against(|| format!("{}, residual {k}", case.name), residual, 0.0, size);
            rows.push((format!("row {k}"), reordered(&of.jacobian[k].unwrap())));
            compared += 1;
        }
        // With the angles of hinges free, what is left of the rows: those across the axes.
        let mut held: Vec<Dofs<f64>> = Vec::new();
        let [a1, a2] = got.axes;
        let directions: Vec<Vector<f64>> = match (a1, a2) {
            (Some(a1), Some(a2)) => vec![unit(cross(a1, a2))],
            (Some(a1), None) => {
                let across = unit(cross(a1, [0.3, 0.1, -0.9]));
                vec![across, cross(a1, across)]
            }
            _ => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        };
        held.extend(got.jacobian[..RHO].iter().flatten());
        if case.kind.entry().hinges.is_some() {
            for direction in directions {
                held.push(std::array::from_fn(|j| {
                    (0..3).map(|i| direction[i] * got.jacobian[RHO + i].unwrap()[j]).sum()
                }));
            }
        }
        let of_rows: Vec<(String, Dofs<f64>)> =
            held.iter().enumerate().map(|(i, row)| (format!("equation {i}"), *row)).collect();
        let only: Vec<Dofs<f64>> = rows.iter().map(|(_, row)| *row).collect();
        assert_eq!(held.len(), only.len(), "{}: as many equations", case.name);
        spans(&mut check, &case, &held, &rows);
        spans(&mut check, &case, &only, &of_rows);
        let angles: &[usize] = match case.kind {
            MpcType::Revolute => &[3],
            MpcType::Universal => &[3, 5],
            _ => &[],
        };
        for (i, k) in angles.iter().enumerate() {
            let [rate, acceleration] = got.angle_rates.unwrap()[i];
            let angle = f64::with_turns(got.angles[i].principal, got.angles[i].turns);
            for (what, got, want) in [
                ("angle", angle, of.position[*k]),
                ("rate", rate, of.velocity[*k]),
                ("acceleration", acceleration, of.acceleration[*k]),
            ] {
                check.against(|| format!("{}, {what} {i}", case.name), got, want.unwrap(), 30.0);
            }
        }
        if case.kind == MpcType::Link {
            // The very same function.
            let (value, row) = (got.residual[0].unwrap(), got.jacobian[0].unwrap());
            check.against(|| case.name.clone(), value, of.residual[0].unwrap(), case.length);
            for (entry, want) in row.iter().zip(reordered(&of.jacobian[0].unwrap())) {
                check.against(|| format!("{}, row", case.name), *entry, want, 1.0);
            }
        }
    }
    assert!(compared > 30, "{compared}");
    check.finish();
}

/// PIN keeps the offset of nodes that are apart as it is in space, and the connector JOIN turns it with its first node.
#[test]
fn pin_is_no_join_at_a_distance() {
    let positions = [[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3], [0.0; 3]];
    let master = Body { rotation: exp([0.0, 0.0, 0.5]), ..Body::at_rest() };
    let state = State { master, ..State::at_rest() };
    let case = Case { name: "apart".into(), kind: MpcType::Pin, positions, state, length: 1.0, holds: true };
    let got = case.evaluate(&Request::everything(1));
    assert_eq!(got.residual[..3], [Some(0.0); 3]);
    let of = connector(&case, "JOIN", [vector::identity(), vector::identity()]);
    assert!((of.residual[0].unwrap() - (0.5_f64.cos() - 1.0)).abs() < 1e-15);
    assert!((of.residual[1].unwrap() + 0.5_f64.sin()).abs() < 1e-15);
}

/// A LINK of coincident nodes has no direction: the row is zero, finite and flagged, and so is that of the connector.
#[test]
fn a_link_of_no_length_is_flagged() {
    let constraint = Constraint::<f64>::new(MpcType::Link, [1.0; 3], [1.0; 3], [[0.0; 3]; 2]);
    let state = State::at_rest();
    let request = Request::everything(2);
    let got = constraint.evaluate(&state, &START, &Turning::none(), &request, &mut Tally::default());
    assert_eq!(got.jacobian[0], Some([0.0; DOFS]));
    assert!(got.hessian[0].as_ref().unwrap().as_flattened().iter().all(|entry| entry.is_finite()));
    let flags = constraint.flags(&state, &START, &Turning::none(), &got);
    assert_eq!((flags[0].component(), flags[0].name()), ("δl", "singular"));
    assert_eq!(Some(Measure::Distance.singular_set()), Some(MpcType::Link.row_set(0)));
    let column = column(&state.slave.rotation, 0);
    assert_eq!(so3::log(&exp(scale(column, 0.0))), [0.0; 3]);
}
