//! Multi-point constraints against JAX: other formulas, another language (`scripts/reference/reference_mpc.py`, `verify/golden/mpc.json`).

use crate::tolerance::GOLDEN_MPC;
use pintle_kinematics::connector::{Request, Tally, Turns};
use pintle_kinematics::mpc::{Body, Constraint, DOFS, Dofs, MpcType, State, Turning};
use pintle_kinematics::so3;
use pintle_kinematics::vector::Vector;
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Deserialize)]
struct File {
    schema: String,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(non_snake_case, reason = "the names of the file")]
struct Case {
    kind: String,
    name: String,
    X: [Vector<f64>; 4],
    u_S: Vector<f64>,
    theta_S: Vector<f64>,
    psi_S: f64,
    u_M: Vector<f64>,
    theta_M: Vector<f64>,
    psi_M: f64,
    phi: [f64; 2],
    rates: Dofs<f64>,
    accelerations: Dofs<f64>,
    residual: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    jacobian: Vec<Dofs<f64>>,
    hessian: Vec<[Dofs<f64>; DOFS]>,
    angles: Vec<f64>,
    angle_velocity: Vec<f64>,
    angle_acceleration: Vec<f64>,
}

impl Case {
    fn state(&self) -> State<f64> {
        let body = |displacement, theta, flow| Body {
            displacement,
            rotation: so3::matrix(so3::exp_quaternion(theta)),
            flow,
        };
        State {
            slave: body(self.u_S, self.theta_S, self.psi_S),
            master: body(self.u_M, self.theta_M, self.psi_M),
            angles: self.phi.map(Some),
            velocity: self.rates,
            acceleration: self.accelerations,
        }
    }
}

/// How many states of each kind the file has, under the names `MPC BEAM`.
pub(crate) fn states_by_kind() -> BTreeMap<String, u64> {
    let file: File = serde_json::from_str(include_str!("golden/mpc.json")).unwrap();
    let mut found = BTreeMap::new();
    for case in file.cases {
        *found.entry(format!("MPC {}", case.kind)).or_default() += 1;
    }
    found
}

/// Residuals, rates, rows, second derivatives and angles of every kind.
#[test]
fn constraints_agree_with_jax() {
    let file: File = serde_json::from_str(include_str!("golden/mpc.json")).unwrap();
    assert_eq!(file.schema, "pintle-reference-mpc/1");
    let mut worst = (0.0_f64, String::new());
    let mut failures = Vec::new();
    let mut kinds = Vec::new();
    for case in &file.cases {
        let kind = MpcType::named(&case.kind).unwrap();
        kinds.push(kind);
        let [slave, master, first, second] = case.X;
        let constraint = Constraint::<f64>::new(kind, slave, master, [first, second]).with_flow();
        let start = [Turns { turns: 0.0, principal: 0.0 }; 2];
        let request = Request::everything(2);
        let got =
            constraint.evaluate(&case.state(), &start, &Turning::none(), &request, &mut Tally::default());
        let mut compare = |what: &str, got: f64, want: f64| {
            let error = (got - want).abs();
            if error > worst.0 || error.is_nan() {
                worst = (error, format!("{} {}, {what}", case.kind, case.name));
            }
            if error > GOLDEN_MPC || !error.is_finite() {
                failures.push(format!("{} {}, {what}: {got:e}, not {want:e}", case.kind, case.name));
            }
        };
        let rows: Vec<usize> = (0..constraint.rows().len()).filter(|row| constraint.rows()[*row]).collect();
        assert_eq!(rows.len(), case.residual.len(), "{} {}", case.kind, case.name);
        for (i, row) in rows.into_iter().enumerate() {
            compare("residual", got.residual[row].unwrap(), case.residual[i]);
            compare("rate", got.residual_rate[row].unwrap(), case.velocity[i]);
            compare("acceleration", got.residual_acceleration[row].unwrap(), case.acceleration[i]);
            for j in 0..DOFS {
                compare(&format!("row {row} ∂{j}"), got.jacobian[row].unwrap()[j], case.jacobian[i][j]);
                for k in 0..DOFS {
                    let second = got.hessian[row].as_ref().unwrap()[j][k];
                    compare(&format!("row {row} ∂{j}∂{k}"), second, case.hessian[i][j][k]);
                }
            }
        }
        for (i, angle) in case.angles.iter().enumerate() {
            compare("angle", got.angles[i].principal, *angle);
            let [rate, acceleration] = got.angle_rates.unwrap()[i];
            compare("angle rate", rate, case.angle_velocity[i]);
            compare("angle acceleration", acceleration, case.angle_acceleration[i]);
        }
        assert_eq!(case.angles.len(), kind.entry().angles.len());
    }
    println!("worst {:.1e} at {}", worst.0, worst.1);
    assert!(MpcType::ALL.iter().all(|kind| kinds.contains(kind)));
    assert!(
        failures.is_empty(),
        "{} fail\n{}",
        failures.len(),
        failures[..failures.len().min(20)].join("\n")
    );
}
