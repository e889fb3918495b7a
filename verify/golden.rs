//! What another language computes by other formulas: `src/audit/oracles/golden/jax.json`, written by `scripts/reference/reference.py`.
//!
//! Each case is walked along its history, so that turns are counted here and there apart. The file states the error of each of
//! its numbers, which includes two roundings of the natural size of the quantity; agreement is judged in units of that.

mod forces; // nodal forces and geometric stiffness

use crate::states::Draw;
use crate::tolerance::GOLDEN;
use pintle_kinematics::catalog::{ConnectionType, Slot, TABLE};
use pintle_kinematics::connector::{
    Components, Connector, Definition, Evaluation, Increment, Request, State, Tally, Turns,
};
use pintle_kinematics::mpc;
use pintle_kinematics::mpc::{Constraint, Turning};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, product, scale, sub};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

type Numbers = [Option<f64>; 6];
type Square<const N: usize> = [[f64; N]; N];

#[derive(Deserialize)]
struct File {
    schema: String,
    cases: Vec<Case>,
    mpc: Vec<Joint>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(non_snake_case, reason = "the names of the file")]
struct Case {
    r#type: String,
    name: String,
    steps: usize,
    X_a: Vector<f64>,
    X_b: Vector<f64>,
    A0: Matrix<f64>,
    B0: Matrix<f64>,
    theta_a: Vector<f64>,
    theta_b: Vector<f64>,
    beta_s: f64,
    reference: Numbers,
    U_a: Vector<f64>,
    U_b: Vector<f64>,
    v_a: Vector<f64>,
    v_b: Vector<f64>,
    a_a: Vector<f64>,
    a_b: Vector<f64>,
    omega_a: Vector<f64>,
    omega_b: Vector<f64>,
    alpha_a: Vector<f64>,
    alpha_b: Vector<f64>,
    flow_a: f64,
    flow_b: f64,
    flow_v_a: f64,
    flow_v_b: f64,
    flow_a_a: f64,
    flow_a_b: f64,
    role: [Option<String>; 6],
    position: Numbers,
    displacement: Numbers,
    residual: Numbers,
    constitutive: Numbers,
    velocity: Numbers,
    acceleration: Numbers,
    jacobian: [Option<[f64; DOFS]>; 6],
    #[serde(default)]
    hessian: Option<[Option<Square<DOFS>>; 6]>,
    error: Errors,
}

/// The error of each field, for each component.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Errors {
    position: Numbers,
    displacement: Numbers,
    residual: Numbers,
    constitutive: Numbers,
    velocity: Numbers,
    acceleration: Numbers,
    jacobian: Numbers,
    #[serde(default)]
    hessian: Numbers,
}

fn file() -> File {
    let text = include_str!("../src/audit/oracles/golden/jax.json");
    let file: File = serde_json::from_str(text).expect("the golden file can be read");
    assert_eq!(file.schema, "pintle-jax/1");
    file
}

/// Differences, in units of the error that the file states.
#[derive(Default)]
struct Agreement {
    worst: (f64, String),
    failures: Vec<String>,
    count: usize,
}

impl Agreement {
    fn compare(&mut self, place: &str, got: f64, want: f64, error: f64) {
        self.count += 1;
        let gap = (got - want).abs();
        let units = if gap == 0.0 { 0.0 } else { gap / error };
        let units = if units.is_nan() { f64::INFINITY } else { units };
        if units > self.worst.0 {
            self.worst = (units, place.to_string());
        }
        if units > GOLDEN {
            self.failures.push(format!("{place}: {got:e}, JAX {want:e}, {units:.2} of its error {error:e}"));
        }
    }

    /// Compares components; each must be present here and there, or in neither.
    fn components(&mut self, place: &str, got: &Components<f64>, want: &Numbers, error: &Numbers) {
        for c in 0..6 {
            match (got[c], want[c], error[c]) {
                (Some(got), Some(want), Some(error)) => {
                    self.compare(&format!("{place}, component {}", c + 1), got, want, error);
                }
                (None, None, None) => {}
                other => self.failures.push(format!("{place}, component {}: {other:?}", c + 1)),
            }
        }
    }

    fn finish(self) {
        let Self { worst, failures, count } = self;
        println!("golden: {count} numbers, worst {:.2} of the stated error at {}", worst.0, worst.1);
        assert!(count > 0, "nothing was compared");
        let shown = failures.iter().take(40).cloned().collect::<Vec<_>>().join("\n");
        assert!(failures.is_empty(), "{} of {count} differ\n{shown}", failures.len());
    }
}

impl Case {
    fn definition(&self, connection: &ConnectionType) -> Definition {
        let node = |triad: &Matrix<f64>| Node { displacement: [0.0; 3], triad: *triad, flow: 0.0 };
        let initial = Pair { reference: sub(self.X_b, self.X_a), a: node(&self.A0), b: node(&self.B0) };
        Definition {
            flow_scale: self.beta_s,
            references: self.reference,
            ..Definition::new(connection.clone(), initial)
        }
    }

    fn at(&self, t: f64) -> Pair<f64> {
        let node = |u: Vector<f64>, theta: Vector<f64>, triad: &Matrix<f64>, flow: f64| Node {
            displacement: scale(u, t),
            triad: product(&so3::matrix(so3::exp_quaternion(scale(theta, t))), triad),
            flow: flow * t,
        };
        Pair {
            reference: sub(self.X_b, self.X_a),
            a: node(self.U_a, self.theta_a, &self.A0, self.flow_a),
            b: node(self.U_b, self.theta_b, &self.B0, self.flow_b),
        }
    }

    fn rates(&self) -> [[f64; DOFS]; 2] {
        let join = |x: &[&Vector<f64>; 4], psi: [f64; 2]| {
            let [[a1, a2, a3], [a4, a5, a6], [b1, b2, b3], [b4, b5, b6]] = x.map(|v| *v);
            [a1, a2, a3, a4, a5, a6, psi[0], b1, b2, b3, b4, b5, b6, psi[1]]
        };
        [
            join(&[&self.v_a, &self.omega_a, &self.v_b, &self.omega_b], [self.flow_v_a, self.flow_v_b]),
            join(&[&self.a_a, &self.alpha_a, &self.a_b, &self.alpha_b], [self.flow_a_a, self.flow_a_b]),
        ]
    }

    /// The evaluation at the end of the history, walked in the file's steps.
    fn walk(&self, connector: &Connector<f64>) -> Evaluation<f64> {
        let share = 1.0 / self.steps as f64;
        let increment = Increment {
            rotation: [scale(self.theta_a, share), scale(self.theta_b, share)],
            whole_turns: [[0.0; 3]; 2],
            flow: [self.flow_a * share, self.flow_b * share],
        };
        let [velocity, acceleration] = self.rates();
        let mut branch = connector.initial_branch();
        for k in 1..self.steps {
            let pair = self.at(k as f64 * share);
            let state = State { pair, velocity, acceleration };
            branch = connector.advance(&state, &increment, &branch);
        }
        let state = State { pair: self.at(1.0), velocity, acceleration };
        let request = Request::everything(2);
        connector.evaluate(&state, &increment, &branch, &request, &mut Tally::default())
    }
}

/// Values, roles, rows, second derivatives and rates of every case.
#[test]
fn the_catalogue_agrees_with_jax() {
    let mut agreement = Agreement::default();
    for case in &file().cases {
        let connection = TABLE.iter().find(|entry| entry.name == case.r#type).expect(&case.r#type);
        let place = format!("{} {}", case.r#type, case.name);
        for c in 0..6 {
            let role = match connection.slots[c] {
                Slot::Absent => None,
                Slot::Available(_) => Some("available"),
                Slot::Constrained(..) => Some("constrained"),
                Slot::Measured(_) => Some("measured"),
            };
            assert_eq!(role, case.role[c].as_deref(), "{place}: the role of component {}", c + 1);
        }
        let connector = Connector::<f64>::new(&case.definition(connection));
        let got = case.walk(&connector);
        let constrained = |c: usize| connection.slots[c].is_constrained();
        let chosen = |of_residual: &Components<f64>, of_position: &Components<f64>| {
            [0, 1, 2, 3, 4, 5].map(|c| if constrained(c) { of_residual[c] } else { of_position[c] })
        };
        let error = &case.error;
        let velocity = chosen(&got.residual_rate, &got.velocity);
        let acceleration = chosen(&got.residual_acceleration, &got.acceleration);
        for (name, got, want, error) in [
            ("position", &got.position, &case.position, &error.position),
            ("displacement", &got.displacement, &case.displacement, &error.displacement),
            ("residual", &got.residual, &case.residual, &error.residual),
            ("constitutive", &got.constitutive, &case.constitutive, &error.constitutive),
            ("velocity", &velocity, &case.velocity, &error.velocity),
            ("acceleration", &acceleration, &case.acceleration, &error.acceleration),
        ] {
            agreement.components(&format!("{place}, {name}"), got, want, error);
        }
        for c in 0..6 {
            let place = |what: &str| format!("{place}, component {}, {what}", c + 1);
            assert_eq!(got.jacobian[c].is_some(), case.jacobian[c].is_some(), "{}", place("row"));
            let (Some(row), Some(want), Some(allowed)) =
                (got.jacobian[c], case.jacobian[c], error.jacobian[c])
            else {
                continue;
            };
            for j in 0..DOFS {
                agreement.compare(&place(&format!("∂{j}")), row[j], want[j], allowed);
            }
            let Some(hessian) = &case.hessian else { continue };
            let (want, allowed) = (hessian[c].unwrap(), error.hessian[c].unwrap());
            let hessian = got.hessian[c].as_ref().unwrap();
            for j in 0..DOFS {
                for k in 0..DOFS {
                    agreement.compare(&place(&format!("∂{j}∂{k}")), hessian[j][k], want[j][k], allowed);
                }
            }
        }
    }
    agreement.finish();
}

/// How many states of each type the file has.
pub(crate) fn states_by_type() -> BTreeMap<String, u64> {
    let mut found = BTreeMap::new();
    for case in file().cases {
        *found.entry(case.r#type).or_default() += 1;
    }
    found
}

/// Every type of the table is in the file, every type of the file in the table; each with enough states, and second derivatives.
#[test]
fn every_type_is_in_the_file() {
    let file = file();
    let here: BTreeSet<&str> = TABLE.iter().map(|entry| &*entry.name).collect();
    let there: BTreeSet<&str> = file.cases.iter().map(|case| &*case.r#type).collect();
    assert_eq!(here, there, "the catalogue and scripts/reference/reference.py do not know the same types");
    for name in here {
        let of = || file.cases.iter().filter(move |case| case.r#type == name);
        for kind in ["random", "tiny", "near-pi", "past-2pi", "right-angle", "far", "millimetre", "kilometre"]
        {
            assert!(of().any(|case| case.name.starts_with(kind)), "{name} has no {kind} state");
        }
        assert!(of().filter(|case| case.hessian.is_some()).count() >= 5, "{name} has few second derivatives");
    }
}

/// The comparison can fail: one digit changed anywhere in a case is seen.
#[test]
fn a_changed_digit_is_seen() {
    let case = &file().cases[0];
    let connection = TABLE.iter().find(|entry| entry.name == case.r#type).expect(&case.r#type);
    let got = case.walk(&Connector::new(&case.definition(connection)));
    let draw = &mut Draw::new("digits");
    for c in 0..3 {
        let mut agreement = Agreement::default();
        let value = got.position[c].unwrap() * (1.0 + 1e-12 * draw.between(0.5, 1.0));
        agreement.compare("changed", value, case.position[c].unwrap(), case.error.position[c].unwrap());
        assert_eq!(agreement.failures.len(), 1, "component {}", c + 1);
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(non_snake_case, reason = "the names of the file")]
struct Joint {
    name: String,
    steps: usize,
    axis: Vector<f64>,
    theta_S: Vector<f64>,
    theta_M: Vector<f64>,
    phi_J: f64,
    omega_S: Vector<f64>,
    omega_M: Vector<f64>,
    phi_v_J: f64,
    alpha_S: Vector<f64>,
    alpha_M: Vector<f64>,
    phi_a_J: f64,
    residual: [f64; 3],
    angle: f64,
    velocity: [f64; 3],
    acceleration: [f64; 3],
    angle_velocity: f64,
    angle_acceleration: f64,
    jacobian: [[f64; 7]; 3],
    #[serde(rename = "angle_jacobian")]
    _angle_jacobian: [f64; 7],
    #[serde(default)]
    hessian: Option<[Square<7>; 3]>,
    #[serde(default, rename = "angle_hessian")]
    _angle_hessian: Option<Square<7>>,
    error: JointErrors,
}

#[derive(Deserialize)]
struct JointErrors {
    residual: f64,
    angle: f64,
    velocity: f64,
    acceleration: f64,
    angle_velocity: f64,
    angle_acceleration: f64,
    jacobian: f64,
    #[serde(default)]
    hessian: Option<f64>,
}

/// Where the seven degrees of freedom of the file, θ_S, θ_M, φ_J, are among those of a constraint.
const PLACES: [usize; 7] = [3, 4, 5, 10, 11, 12, 14];

impl Joint {
    fn state(&self, t: f64) -> mpc::State<f64> {
        let body = |theta: Vector<f64>| {
            let rotation = so3::matrix(so3::exp_quaternion(scale(theta, t)));
            mpc::Body { rotation, ..mpc::Body::at_rest() }
        };
        let join = |s: Vector<f64>, m: Vector<f64>, j: f64| {
            let mut all = [0.0; mpc::DOFS];
            for (place, rate) in PLACES.into_iter().zip(s.into_iter().chain(m).chain([j])) {
                all[place] = rate;
            }
            all
        };
        mpc::State {
            slave: body(self.theta_S),
            master: body(self.theta_M),
            angles: [Some(self.phi_J * t), None],
            velocity: join(self.omega_S, self.omega_M, self.phi_v_J),
            acceleration: join(self.alpha_S, self.alpha_M, self.phi_a_J),
        }
    }
}

/// The revolute-joint multi-point constraint: residual, rates, rows, second derivatives, and its angle through turns.
#[test]
fn the_joint_agrees_with_jax() {
    let mut agreement = Agreement::default();
    for joint in &file().mpc {
        let hinges = [joint.axis, [0.0; 3]];
        let constraint = Constraint::<f64>::new(mpc::MpcType::Revolute, [0.0; 3], [0.0; 3], hinges);
        let mut turns = [Turns { turns: 0.0, principal: 0.0 }; 2];
        let mut last = None;
        for k in 1..=joint.steps {
            let state = joint.state(k as f64 / joint.steps as f64);
            let request = Request::everything(2);
            let got = constraint.evaluate(&state, &turns, &Turning::none(), &request, &mut Tally::default());
            turns = got.angles;
            last = Some(got);
        }
        let got = last.expect("a history has an end");
        let error = &joint.error;
        let angle = got.angles[0].principal + std::f64::consts::TAU * got.angles[0].turns;
        let [[rate, acceleration], _] = got.angle_rates.expect("rates");
        for (name, got, want, error) in [
            ("angle", angle, joint.angle, error.angle),
            ("angle rate", rate, joint.angle_velocity, error.angle_velocity),
            ("angle acceleration", acceleration, joint.angle_acceleration, error.angle_acceleration),
        ] {
            agreement.compare(&format!("MPC {}, {name}", joint.name), got, want, error);
        }
        for i in 0..3 {
            let place = |what: &str| format!("MPC {}, equation {}, {what}", joint.name, i + 1);
            let row = mpc::RHO + i;
            for (what, got, want, error) in [
                ("residual", got.residual, joint.residual, error.residual),
                ("rate", got.residual_rate, joint.velocity, error.velocity),
                ("acceleration", got.residual_acceleration, joint.acceleration, error.acceleration),
            ] {
                agreement.compare(&place(what), got[row].unwrap(), want[i], error);
            }
            for (j, at) in PLACES.into_iter().enumerate() {
                let gradient = got.jacobian[row].unwrap();
                agreement.compare(
                    &place(&format!("∂{j}")),
                    gradient[at],
                    joint.jacobian[i][j],
                    error.jacobian,
                );
                let Some(hessian) = &joint.hessian else { continue };
                for (k, other) in PLACES.into_iter().enumerate() {
                    let second = got.hessian[row].as_ref().unwrap()[at][other];
                    let allowed = error.hessian.unwrap();
                    agreement.compare(&place(&format!("∂{j}∂{k}")), second, hessian[i][j][k], allowed);
                }
            }
        }
    }
    agreement.finish();
}
