//! Nodal forces and geometric stiffness as JAX has them: `src/audit/oracles/golden/forces.json`, written by `scripts/reference/reference_forces.py` at
//! the states of `jax.json`.

use super::{Agreement, Square};
use crate::laws::U;
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::{Components, Connector, State, Tally};
use pintle_kinematics::force::Want;
use pintle_kinematics::node::DOFS;
use serde::Deserialize;
use std::collections::BTreeSet;

#[derive(Deserialize)]
struct File {
    schema: String,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    r#type: String,
    name: String,
    forces: Components<f64>,
    nodal: [f64; DOFS],
    stiffness: Option<Square<DOFS>>,
}

/// Every type with forces, at every state; the error allowed is that of the rows in `jax.json`, and a few roundings of each force.
#[test]
fn forces_agree_with_jax() {
    let file: File = serde_json::from_str(include_str!("../../src/audit/oracles/golden/forces.json"))
        .expect("the golden file can be read");
    assert_eq!(file.schema, "pintle-forces-golden/1");
    let states = super::file();
    let mut agreement = Agreement::default();
    let mut seen = BTreeSet::new();
    for case in &file.cases {
        let of = |state: &&super::Case| state.r#type == case.r#type && state.name == case.name;
        let state = states.cases.iter().find(of).expect("a state of jax.json");
        let connection = TABLE.iter().find(|entry| entry.name == case.r#type).expect(&case.r#type);
        let connector = Connector::<f64>::new(&state.definition(connection));
        let branch = state.walk(&connector).branch;
        let [velocity, acceleration] = state.rates();
        let now = State { pair: state.at(1.0), velocity, acceleration };
        let want = Want { stiffness: true, multipliers: false, motions: [false; 6] };
        let rows = connector.force_rows(&now, &branch, [true; 6], want, &mut Tally::default());
        for k in 0..6 {
            assert_eq!(connector.has_force(k), case.forces[k].is_some(), "{} {k}", case.r#type);
        }
        let all: f64 = case.forces.iter().flatten().map(|force| force.abs()).sum();
        let most = |errors: &Components<f64>| errors.iter().flatten().fold(0.0, |most: f64, e| most.max(*e));
        let nodal = rows.nodal(&case.forces);
        let place = format!("{} {}", case.r#type, case.name);
        for j in 0..DOFS {
            let allowed = all * (most(&state.error.jacobian) + 8.0 * U);
            agreement.compare(&format!("{place}, force {j}"), nodal[j], case.nodal[j], allowed);
        }
        let Some(stiffness) = &case.stiffness else { continue };
        seen.insert(&case.r#type);
        let geometric = rows.geometric_stiffness(&case.forces);
        for j in 0..DOFS {
            for k in 0..DOFS {
                let allowed = all * (most(&state.error.hessian) + 8.0 * U);
                let place = format!("{place}, stiffness {j} {k}");
                agreement.compare(&place, geometric[j][k], stiffness[j][k], allowed);
            }
        }
    }
    let with_forces = TABLE.iter().filter(|entry| (0..6).any(|k| entry.loading(k).is_some()));
    assert_eq!(seen.len(), with_forces.count(), "a type has no stiffness in the file");
    agreement.finish();
}
