//! Equations, rigid bodies, couplings and ties against JAX: other formulas, another language (`scripts/reference/reference_relation.py`,
//! `verify/golden/relation.json`).

use crate::tolerance::GOLDEN_MPC;
use pintle_kinematics::connector::{Request, Tally};
use pintle_kinematics::relation::{Point, Relation, place_of};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector};
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
    X: Vec<Vector<f64>>,
    u: Vec<Vector<f64>>,
    theta: Vec<Vector<f64>>,
    psi: Vec<f64>,
    rates: Vec<[f64; 7]>,
    accelerations: Vec<[f64; 7]>,
    #[serde(default)]
    terms: Vec<(usize, Vector<f64>, usize, f64)>,
    axes: Option<Matrix<f64>>,
    fixed: Option<[bool; 6]>,
    #[serde(default)]
    weights: Vec<f64>,
    residual: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    jacobian: Vec<Vec<f64>>,
}

impl Case {
    fn relation(&self) -> Relation<f64> {
        match (self.kind.as_str(), self.axes, self.fixed) {
            ("EQUATION" | "TIE", ..) => Relation::linear(&self.terms),
            ("DISTRIBUTING COUPLING", ..) => {
                let nodes: Vec<_> = self.weights.iter().copied().zip(self.X[1..].iter().copied()).collect();
                Relation::mean(self.X[0], &nodes)
            }
            (_, Some(axes), Some(fixed)) => Relation::carried(self.X[0], self.X[1], axes, fixed),
            (kind, ..) => panic!("{kind} without axes"),
        }
    }

    fn points(&self) -> Vec<Point<f64>> {
        let point = |place: usize| Point {
            displacement: self.u[place],
            rotation: so3::matrix(so3::exp_quaternion(self.theta[place])),
            vector: self.theta[place],
            flow: self.psi[place],
            velocity: self.rates[place],
            acceleration: self.accelerations[place],
        };
        (0..self.u.len()).map(point).collect()
    }
}

fn file() -> File {
    serde_json::from_str(include_str!("golden/relation.json")).unwrap()
}

/// How many states of each kind the file has.
pub(crate) fn states_by_kind() -> BTreeMap<String, u64> {
    let mut found = BTreeMap::new();
    for case in file().cases {
        *found.entry(case.kind).or_default() += 1;
    }
    found
}

/// Residuals, rates, accelerations and rows of every kind. What a relation leaves out of its columns is zero.
#[test]
fn relations_agree_with_jax() {
    let file = file();
    assert_eq!(file.schema, "pintle-reference-relation/1");
    let (mut compared, mut worst) = (0_usize, (0.0_f64, String::new()));
    let mut failures = Vec::new();
    for case in &file.cases {
        let relation = case.relation();
        let rows = relation.evaluate(&case.points(), &Request::everything(1), &mut Tally::default());
        assert_eq!(rows.len(), case.residual.len(), "{} {}", case.kind, case.name);
        let mut compare = |what: String, got: f64, want: f64| {
            let error = (got - want).abs();
            compared += 1;
            if error > worst.0 || error.is_nan() {
                worst = (error, format!("{} {}, {what}", case.kind, case.name));
            }
            if error > GOLDEN_MPC || !error.is_finite() {
                failures.push(format!("{} {}, {what}: {got:e}, not {want:e}", case.kind, case.name));
            }
        };
        for (k, row) in rows.iter().enumerate() {
            compare(format!("residual {k}"), row.residual, case.residual[k]);
            compare(format!("rate {k}"), row.rate.unwrap(), case.velocity[k]);
            compare(format!("acceleration {k}"), row.acceleration.unwrap(), case.acceleration[k]);
            for (j, want) in case.jacobian[k].iter().enumerate() {
                let is_of = |(place, number): &(usize, u8)| 7 * place + place_of(*number) == j;
                let at = relation.columns().iter().position(is_of);
                compare(format!("row {k} ∂{j}"), at.map_or(0.0, |at| row.gradient[at]), *want);
            }
        }
    }
    println!("{compared} numbers, worst {:.1e} at {}", worst.0, worst.1);
    assert!(compared > 1000 && states_by_kind().len() == 5, "{compared} compared");
    assert!(
        failures.is_empty(),
        "{} fail\n{}",
        failures.len(),
        failures[..failures.len().min(10)].join("\n")
    );
}
