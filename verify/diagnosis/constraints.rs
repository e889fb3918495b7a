//! Wrong multi-point constraints as engineers write them, each with its cause: all are found, and the cause is said in words.

use super::said;
use pintle_audit::{ConstraintCandidate, ConstraintNumbers, MpcCase, Quantity, Report, Settings};
use pintle_kinematics::connector::{Request, Tally};
use pintle_kinematics::mpc::{
    Constraint, DOFS, Dofs, Evaluation, MpcType, PHI, RHO, State, THETA_M, THETA_S, XM, XS,
};
use pintle_kinematics::so3::{exp, inverse_left_jacobian, log, quaternion};
use pintle_kinematics::vector::{
    Vector, add, apply, apply_transposed, cross, dot, identity, product, scale, sub, transpose,
};

const F: Quantity = Quantity::Value;
const DF: Quantity = Quantity::FirstDerivatives;
const DDF: Quantity = Quantity::SecondDerivatives;
const RATE: Quantity = Quantity::Rate;
const ACC: Quantity = Quantity::Acceleration;

fn constraint(kind: MpcType) -> Constraint<f64> {
    Constraint::new(kind, [0.7, -0.4, 0.9], [0.0; 3], [[1.0, -2.0, 2.0], [2.0, 2.0, 1.0]])
}

pub(crate) fn right(case: &MpcCase) -> Evaluation<f64> {
    let request = Request::everything(2);
    case.constraint.evaluate(&case.state, &case.before, &case.turning, &request, &mut Tally::default())
}

/// A wrong routine: the kind, what is wrong, what it gives, how, and the code of its cause with a word of the place.
pub(crate) type Wrong = (
    MpcType,
    &'static str,
    &'static [Quantity],
    fn(&MpcCase, &mut Evaluation<f64>),
    &'static str,
    &'static str,
);

fn each_row(found: &mut Evaluation<f64>, rows: std::ops::Range<usize>, change: impl Fn(&mut Dofs<f64>)) {
    found.jacobian[rows].iter_mut().flatten().for_each(change);
}

fn rho(found: &mut Evaluation<f64>, value: Vector<f64>) {
    (0..3).for_each(|i| found.residual[RHO + i] = Some(value[i]));
}

fn spins(state: &mut State<f64>, change: impl Fn(Vector<f64>, &[Vector<f64>; 3]) -> Vector<f64>) {
    for (at, body) in [(THETA_S, state.slave), (THETA_M, state.master)] {
        let spin =
            change([state.velocity[at], state.velocity[at + 1], state.velocity[at + 2]], &body.rotation);
        state.velocity[at..at + 3].copy_from_slice(&spin);
    }
}

/// x_S − x_M.
fn apart(case: &MpcCase) -> Vector<f64> {
    add(case.constraint.arm(), sub(case.state.slave.displacement, case.state.master.displacement))
}

pub(crate) const ALL: &[Wrong] = &[
    (
        MpcType::Link,
        "the row of (l² − l₀²)/(2 l₀)",
        &[DF],
        |case, found| {
            let [x, arm] = [apart(case), case.constraint.arm()].map(|x| dot(x, x).sqrt());
            each_row(found, 0..1, |row| row.iter_mut().for_each(|slope| *slope *= x / arm));
        },
        "other-length",
        "|x_S",
    ),
    (
        MpcType::Beam,
        "lever arm at first",
        &[DF],
        |case, found| {
            let arm = case.constraint.arm();
            for (i, axis) in identity::<f64>().into_iter().enumerate() {
                let row = found.jacobian[i].as_mut().unwrap();
                row[THETA_M..THETA_M + 3].copy_from_slice(&cross(axis, arm));
            }
        },
        "initial-axes",
        "∂δ1, ∂δ2, ∂δ3 equal the row with the arm at first",
    ),
    (
        MpcType::Universal,
        "rotation vectors added",
        &[F],
        |case, found| {
            let [s, m] = [case.state.slave, case.state.master].map(|body| log(&body.rotation));
            let turned = |hinge: usize| {
                let axis = case.constraint.initial_axes()[hinge].unwrap();
                scale(apply(&case.state.master.rotation, axis), found.taken[hinge])
            };
            rho(found, sub(sub(s, m), add(turned(0), turned(1))));
        },
        "other-parameters",
        "equal φ_S − φ_M − Σ φ C_M a",
    ),
    (
        MpcType::Universal,
        "the second hinge not turned by the first",
        &[DF],
        |case, found| {
            let inverse = inverse_left_jacobian([0, 1, 2].map(|i| found.residual[RHO + i].unwrap()));
            let axis = apply(&case.state.master.rotation, case.constraint.initial_axes()[1].unwrap());
            let column = apply(&transpose(&inverse), axis);
            (0..3).for_each(|i| found.jacobian[RHO + i].as_mut().unwrap()[PHI + 1] = -column[i]);
        },
        "motion-ignored",
        "equal the row with the second hinge's axis not turned by the first",
    ),
    (
        MpcType::Revolute,
        "the hinge's axis at first, in its column",
        &[DF],
        |case, found| {
            let inverse = inverse_left_jacobian([0, 1, 2].map(|i| found.residual[RHO + i].unwrap()));
            let column = apply(&transpose(&inverse), case.constraint.initial_axes()[0].unwrap());
            (0..3).for_each(|i| found.jacobian[RHO + i].as_mut().unwrap()[PHI] = -column[i]);
        },
        "initial-axes",
        "equal the row with the initial axes of the hinges in their columns: axes or an arm that do not turn with M",
    ),
    (
        MpcType::Beam,
        "no lever arm",
        &[F, DF],
        |_, found| each_row(found, 0..3, |row| row[THETA_M..THETA_M + 3].fill(0.0)),
        "geometric-term-missing",
        "∂δ1/∂θM1..3",
    ),
    (
        MpcType::Beam,
        "lever arm reversed",
        &[DF],
        |_, found| {
            each_row(found, 0..3, |row| row[THETA_M..THETA_M + 3].iter_mut().for_each(|x| *x = -*x));
        },
        // Of a skew block the transpose is the opposite, and is named first.
        "block-transposed",
        "∂δ1",
    ),
    (
        MpcType::Beam,
        "lever arm twice",
        &[DF],
        |_, found| {
            each_row(found, 0..3, |row| row[THETA_M..THETA_M + 3].iter_mut().for_each(|x| *x *= 2.0));
        },
        "geometric-term-doubled",
        "∂δ1",
    ),
    (
        MpcType::Beam,
        "lever arm at S",
        &[DF],
        |_, found| {
            each_row(found, 0..3, |row| {
                row.copy_within(THETA_M..THETA_M + 3, THETA_S);
                row[THETA_M..THETA_M + 3].fill(0.0);
            })
        },
        "lever-at-b",
        "∂δ1",
    ),
    (
        MpcType::Beam,
        "arm does not turn",
        &[F, DF],
        |case, found| {
            let slip = sub(case.state.slave.displacement, case.state.master.displacement);
            (0..3).for_each(|i| found.residual[i] = Some(slip[i]));
            each_row(found, 0..3, |row| row[THETA_M..THETA_M + 3].fill(0.0));
        },
        "motion-ignored",
        "δ1",
    ),
    (
        MpcType::Beam,
        "no initial value",
        &[F],
        |case, found| {
            let apart = apart(case);
            (0..3).for_each(|i| found.residual[i] = Some(apart[i]));
        },
        "initial-value-kept",
        "δ1",
    ),
    (
        MpcType::Beam,
        "along the axes of M",
        &[F, DF],
        |case, found| {
            let body = &case.state.master.rotation;
            let delta = [0, 1, 2].map(|i| found.residual[i].unwrap());
            let local = apply_transposed(body, delta);
            for j in 0..DOFS {
                let axis = [0, 1, 2].map(|i| if j == THETA_M + i { 1.0 } else { 0.0 });
                let column = [0, 1, 2].map(|i| found.jacobian[i].unwrap()[j]);
                let turned = apply_transposed(body, sub(column, cross(axis, delta)));
                (0..3).for_each(|i| found.jacobian[i].as_mut().unwrap()[j] = turned[i]);
            }
            (0..3).for_each(|i| found.residual[i] = Some(local[i]));
        },
        "axes-of-b",
        "δ1",
    ),
    (
        MpcType::Tie,
        "initial separation turned with M",
        &[F],
        |case, found| {
            let turned = sub(apart(case), apply(&case.state.master.rotation, case.constraint.arm()));
            (0..3).for_each(|i| found.residual[i] = Some(turned[i]));
        },
        "initial-separation-turned",
        "δ1",
    ),
    (
        MpcType::Pin,
        "positions for displacements",
        &[F],
        |case, found| {
            let apart = apart(case);
            (0..3).for_each(|i| found.residual[i] = Some(apart[i]));
        },
        "initial-value-kept",
        "δ1",
    ),
    (
        MpcType::Pin,
        "M left out",
        &[DF],
        |_, found| each_row(found, 0..3, |row| row[XM..PHI].fill(0.0)),
        "node-left-out",
        "xM",
    ),
    (
        MpcType::Pin,
        "S and M exchanged",
        &[F],
        |_, found| {
            found.residual.iter_mut().flatten().for_each(|x| *x = -*x);
        },
        "nodes-swapped",
        "δ1",
    ),
    (
        MpcType::Link,
        "no initial length",
        &[F],
        |case, found| {
            found.residual[0] = Some(dot(apart(case), apart(case)).sqrt());
        },
        "initial-value-kept",
        "δl",
    ),
    (
        MpcType::Link,
        "squares",
        &[F, DF],
        |case, found| {
            let (d, arm) = (apart(case), case.constraint.arm());
            found.residual[0] = Some(dot(d, d) - dot(arm, arm));
            each_row(found, 0..1, |row| {
                (0..3).for_each(|i| (row[XS + i], row[XM + i]) = (2.0 * d[i], -2.0 * d[i]))
            });
        },
        "other-length",
        "δl",
    ),
    (
        MpcType::Link,
        "row not normalised",
        &[DF],
        |case, found| {
            let d = apart(case);
            each_row(found, 0..1, |row| (0..3).for_each(|i| (row[XS + i], row[XM + i]) = (d[i], -d[i])));
        },
        "other-length",
        "δl",
    ),
    (
        MpcType::Revolute,
        "quaternion",
        &[F],
        |case, found| {
            let value = [0, 1, 2].map(|i| found.residual[RHO + i].unwrap());
            let [_, x, y, z] = quaternion(&exp(value));
            assert_eq!(case.constraint.kind(), MpcType::Revolute);
            rho(found, [2.0 * x, 2.0 * y, 2.0 * z]);
        },
        "other-parameters",
        "ρ1",
    ),
    (
        MpcType::Revolute,
        "axial vector",
        &[F, DF],
        |_, found| {
            let value = [0, 1, 2].map(|i| found.residual[RHO + i].unwrap());
            let angle = dot(value, value).sqrt();
            if angle > 1e-3 {
                let (f, slope) = (angle.sin() / angle, (angle.cos() - angle.sin() / angle) / (angle * angle));
                for j in 0..DOFS {
                    let column = [0, 1, 2].map(|i| found.jacobian[RHO + i].unwrap()[j]);
                    let mapped = add(scale(column, f), scale(value, slope * dot(value, column)));
                    (0..3).for_each(|i| found.jacobian[RHO + i].as_mut().unwrap()[j] = mapped[i]);
                }
                rho(found, scale(value, f));
            }
        },
        "other-parameters",
        "ρ1",
    ),
    (
        MpcType::Revolute,
        "axis does not turn",
        &[F],
        |case, found| {
            let State { slave, master, angles, .. } = &case.state;
            let axis = case.constraint.initial_axes()[0].unwrap();
            let allowed = product(&exp(scale(axis, angles[0].unwrap())), &master.rotation);
            rho(found, log(&product(&slave.rotation, &transpose(&allowed))));
        },
        "initial-axes",
        "ρ1",
    ),
    (
        MpcType::Revolute,
        "angle reversed",
        &[F, DF],
        |case, found| {
            let mut other = case.clone();
            other.state.angles[0] = other.state.angles[0].map(|angle| -angle);
            *found = right(&other);
            each_row(found, RHO..6, |row| row[PHI] = -row[PHI]);
        },
        "sign",
        "ρ1",
    ),
    (
        MpcType::Revolute,
        "angle in degrees",
        &[F],
        |case, found| {
            let mut other = case.clone();
            other.state.angles[0] = other.state.angles[0].map(f64::to_radians);
            *found = right(&other);
        },
        "degrees",
        "ρ1",
    ),
    (
        MpcType::Revolute,
        "angle left out",
        &[F],
        |case, found| {
            let mut other = case.clone();
            other.state.angles[0] = Some(0.0);
            *found = right(&other);
        },
        "motion-ignored",
        "ρ1",
    ),
    (
        MpcType::Revolute,
        "column of the angle missing",
        &[DF],
        |_, found| each_row(found, RHO..6, |row| row[PHI] = 0.0),
        "node-left-out",
        "φJ",
    ),
    (
        MpcType::Revolute,
        "column of the angle reversed",
        &[DF],
        |_, found| {
            each_row(found, RHO..6, |row| row[PHI] = -row[PHI]);
        },
        "sign-of-block",
        "φJ",
    ),
    (
        MpcType::Revolute,
        "row of the constraint that holds",
        &[DF],
        |case, found| {
            let State { slave, master, angles, .. } = &case.state;
            let axis = case.constraint.initial_axes()[0].unwrap();
            let allowed = product(&master.rotation, &exp(scale(axis, angles[0].unwrap())));
            let violation = product(&slave.rotation, &transpose(&allowed));
            let hinge = apply(&violation, apply(&master.rotation, axis));
            for i in 0..3 {
                let row = found.jacobian[RHO + i].as_mut().unwrap();
                *row = [0.0; DOFS];
                row[THETA_S + i] = 1.0;
                (0..3).for_each(|j| row[THETA_M + j] = -violation[i][j]);
                row[PHI] = -hinge[i];
            }
        },
        "other-jacobian",
        "∂ρ1",
    ),
    (
        MpcType::Revolute,
        "Jacobian of the other side",
        &[DF],
        |case, found| {
            let value = [0, 1, 2].map(|i| found.residual[RHO + i].unwrap());
            let left = inverse_left_jacobian(value);
            let others = right(case);
            for j in 0..DOFS {
                let column = [0, 1, 2].map(|i| others.jacobian[RHO + i].unwrap()[j]);
                // J_r⁻¹ = J_l⁻ᵀ of what J_l⁻¹ is applied to.
                let moved = apply(&transpose(&left), solve(&left, column));
                (0..3).for_each(|i| found.jacobian[RHO + i].as_mut().unwrap()[j] = moved[i]);
            }
        },
        "other-jacobian",
        "∂ρ1",
    ),
    (
        MpcType::Revolute,
        "rotations of S taken as local",
        &[DF],
        |case, found| {
            let body = case.state.slave.rotation;
            each_row(found, RHO..6, |row| {
                let local = apply_transposed(&body, [row[THETA_S], row[THETA_S + 1], row[THETA_S + 2]]);
                row[THETA_S..THETA_S + 3].copy_from_slice(&local);
            });
        },
        "rotation-as-local",
        "θS",
    ),
    (
        MpcType::Universal,
        "order of the hinges",
        &[F],
        |case, found| {
            let State { slave, master, angles, .. } = &case.state;
            let [first, second] = case.constraint.initial_axes().map(Option::unwrap);
            let [one, two] = [(second, angles[1]), (first, angles[0])]
                .map(|(axis, angle)| exp(scale(axis, angle.unwrap())));
            let allowed = product(&product(&master.rotation, &one), &two);
            rho(found, log(&product(&slave.rotation, &transpose(&allowed))));
        },
        "other-order",
        "ρ1",
    ),
    (
        MpcType::Universal,
        "rows in degrees",
        &[DF],
        |_, found| {
            each_row(found, RHO..6, |row| {
                row.iter_mut().for_each(|x| *x = x.to_degrees());
            })
        },
        "degrees",
        "∂ρ1",
    ),
    (
        MpcType::Universal,
        "rows exchanged",
        &[DF],
        |_, found| found.jacobian.swap(RHO, RHO + 1),
        "components-swapped",
        "ρ1",
    ),
    (
        MpcType::Beam,
        "second derivatives not symmetrised",
        &[DDF],
        |_, found| {
            for i in 0..3 {
                let row = found.jacobian[RHO + i].unwrap();
                let matrix = found.hessian[RHO + i].as_mut().unwrap();
                for at in [THETA_S, THETA_M] {
                    for (j, k, l, sign) in [(0, 1, 2, 0.5), (1, 2, 0, 0.5), (2, 0, 1, 0.5)] {
                        matrix[at + j][at + k] += sign * row[at + l];
                        matrix[at + k][at + j] -= sign * row[at + l];
                    }
                }
            }
        },
        "not-symmetrised",
        "∂²ρ1",
    ),
    (
        MpcType::Revolute,
        "body rates",
        &[RATE],
        |case, found| {
            let mut other = case.clone();
            spins(&mut other.state, |spin, rotation| apply_transposed(rotation, spin));
            found.residual_rate = right(&other).residual_rate;
        },
        "body-rates",
        "dρ1/dt",
    ),
    (
        MpcType::Beam,
        "rates of M alone",
        &[RATE],
        |case, found| {
            for (row, rate) in found.jacobian.iter().zip(&mut found.residual_rate) {
                if let (Some(row), Some(rate)) = (row, rate) {
                    *rate = (XM..PHI).map(|j| row[j] * case.state.velocity[j]).sum();
                }
            }
        },
        "rates-of-a-ignored",
        "dδ1/dt",
    ),
    (
        MpcType::Beam,
        "no centripetal acceleration",
        &[ACC],
        |case, found| {
            for (row, second) in found.jacobian.iter().zip(&mut found.residual_acceleration) {
                if let (Some(row), Some(second)) = (row, second) {
                    *second = (0..DOFS).map(|j| row[j] * case.state.acceleration[j]).sum();
                }
            }
        },
        "quadratic-part-missing",
        "d²δ1/dt²",
    ),
    (
        MpcType::Link,
        "not a number where nothing is violated",
        &[F, DF],
        |case, found| {
            if found.residual[0].unwrap().abs() < 1e-13 {
                each_row(found, 0..1, |row| row[XS] = f64::NAN);
            }
            assert!(case.length > 0.0);
        },
        "not-a-number",
        "∂δl",
    ),
    (
        MpcType::Tie,
        "rotation of M left out",
        &[F],
        |case, found| {
            let mut other = case.clone();
            other.state.master.rotation = identity();
            *found = right(&other);
        },
        "motion-ignored",
        "ρ1",
    ),
];

/// A⁻¹ v by Cramer's rule.
fn solve(a: &[Vector<f64>; 3], v: Vector<f64>) -> Vector<f64> {
    let column = |j: usize| [a[0][j], a[1][j], a[2][j]];
    let det = |x: Vector<f64>, y: Vector<f64>, z: Vector<f64>| dot(x, cross(y, z));
    let whole = det(column(0), column(1), column(2));
    [
        det(v, column(1), column(2)) / whole,
        det(column(0), v, column(2)) / whole,
        det(column(0), column(1), v) / whole,
    ]
}

fn settings(states: usize, near: usize) -> Settings {
    Settings { states, near_singular_states: near, wide_states: 6, atlas: false, ..Settings::default() }
}

fn checked(kind: MpcType, offers: &[Quantity], spoil: fn(&MpcCase, &mut Evaluation<f64>)) -> Report {
    let constraint = constraint(kind);
    let candidate = ConstraintCandidate::new("mine", &constraint).settings(settings(24, 0)).offers(offers);
    candidate.check(|case| {
        let mut found = right(case);
        spoil(case, &mut found);
        found.into()
    })
}

/// The corpus: every routine is found, and the first cause that is told is the one.
#[test]
fn causes_of_wrong_constraints_are_named() {
    let (mut table, mut named) = (String::new(), 0);
    for (kind, name, offers, spoil, cause, place) in ALL {
        let report = checked(*kind, offers, *spoil);
        assert!(report.mismatches() > 0, "{} {name}: not found", kind.name());
        let checks = report.subjects.iter().flat_map(|subject| &subject.checks);
        let told: Vec<String> =
            checks.filter_map(|check| check.diagnosis.as_ref()).map(|found| said(found)).collect();
        let is_it = |line: &&str| line.contains(&format!("diagnosis::{cause}]")) && line.contains(place);
        if told.iter().any(|told| told.lines().next().as_ref().is_some_and(is_it)) {
            named += 1;
        } else {
            table += &format!("{} {name}, {cause} of {place}:\n{}\n", kind.name(), told.join("\n"));
        }
    }
    println!("{named} of {} named\n{table}", ALL.len());
    assert!(ALL.len() >= 30 && named == ALL.len(), "{named} of {} named\n{table}", ALL.len());
}

/// The product's own numbers are right in every quantity of every kind, near singular sets too, and each quantity is compared.
#[test]
fn right_constraints_are_not_called_wrong() {
    let mut compared = 0;
    for kind in MpcType::ALL {
        let constraint = constraint(kind);
        let all = [F, DF, DDF, RATE, ACC];
        let candidate = ConstraintCandidate::new("mine", &constraint).settings(settings(36, 12)).offers(&all);
        let report = candidate.check(MpcCase::product);
        let subject = &report.subjects[0];
        let wrong: Vec<_> = subject.checks.iter().filter(|check| check.verdict.is_mismatch()).collect();
        assert!(wrong.is_empty(), "{}: {wrong:#?}", kind.name());
        assert!(!subject.verdict().is_mismatch(), "{}", kind.name());
        for quantity in all {
            let of = subject.checks.iter().filter(|check| check.quantity == Some(quantity));
            let count: u64 = of.map(|check| check.compared).sum();
            assert!(count >= 36, "{} {}: {count}", kind.name(), quantity.name());
            compared += count;
        }
    }
    println!("{compared} numbers compared");
    assert!(compared > 100_000, "{compared}");
}

/// Residuals of rotations that a routine composes anew, of three turns: rotations to several roundings only.
#[test]
fn composed_rotations_raise_no_alarm() {
    let mut compared = 0;
    for kind in MpcType::ALL {
        let constraint = constraint(kind);
        let candidate =
            ConstraintCandidate::new("mine", &constraint).settings(settings(120, 60)).offers(&[F]);
        let report = candidate.check(|case: &MpcCase| {
            let mut composed = case.clone();
            for body in [&mut composed.state.slave, &mut composed.state.master] {
                let third = exp(scale(log(&body.rotation), 1.0 / 3.0));
                body.rotation = product(&third, &product(&third, &third));
            }
            MpcCase::product(&composed)
        });
        let checks: Vec<_> =
            report.subjects[0].checks.iter().map(|check| (check.largest, &check.worst)).collect();
        assert_eq!(report.mismatches(), 0, "{}: {checks:?}", kind.name());
        compared += report.compared();
    }
    assert!(compared > 1_000, "{compared}");
}

/// A relative error of 1e-9 in one quantity is found in it and nowhere else; what is missing or too much is said.
#[test]
fn errors_of_constraints_are_found_in_their_quantity() {
    for kind in MpcType::ALL {
        for quantity in [F, DF, DDF, RATE, ACC] {
            let spoilt = |case: &MpcCase| {
                let mut found = right(case);
                let by = |x: &mut f64| *x *= 1.0 + 1e-9;
                match quantity {
                    F => found.residual.iter_mut().flatten().for_each(by),
                    DF => found.jacobian.iter_mut().flatten().flatten().for_each(by),
                    RATE => found.residual_rate.iter_mut().flatten().for_each(by),
                    ACC => found.residual_acceleration.iter_mut().flatten().for_each(by),
                    _ => found.hessian.iter_mut().flatten().flat_map(|h| h.iter_mut()).flatten().for_each(by),
                }
                found.into()
            };
            let constraint = constraint(kind);
            let candidate = ConstraintCandidate::new("mine", &constraint)
                .settings(settings(24, 0))
                .offers(&[F, DF, DDF, RATE, ACC]);
            let report = candidate.check(spoilt);
            let wrong = report.subjects[0].checks.iter().filter(|check| check.verdict.is_mismatch());
            let wrong: Vec<Option<Quantity>> = wrong.map(|check| check.quantity).collect();
            // A PIN is linear: its second derivatives are zero, and stay so.
            let expected =
                if (kind, quantity) == (MpcType::Pin, DDF) { vec![] } else { vec![Some(quantity)] };
            assert_eq!(wrong, expected, "{} {}", kind.name(), quantity.name());
        }
    }
    let beam = constraint(MpcType::Beam);
    let candidate = ConstraintCandidate::new("mine", &beam).settings(settings(4, 0));
    let lacking = candidate.check(|case| ConstraintNumbers::from(right(case)).values([None; 7]));
    let of = |report: &Report| report.subjects[0].checks[0].worst.as_ref().unwrap().entry.clone();
    assert_eq!(of(&lacking), "values of δ1 is missing");
    let too_much = candidate.check(|case| {
        let mut found = right(case);
        found.residual[6] = Some(0.0);
        found.into()
    });
    assert_eq!(of(&too_much), "δΨ is given, and MPC BEAM has no such equation");
}
