//! What JAX computes of friction, by formulas and solutions of its own: `src/audit/oracles/golden/friction.json`, written by
//! `scripts/reference/reference_friction.py`.

use super::{U, component};
use crate::tolerance::friction as gate;
use pintle_kinematics::catalog::ConnectionType;
use pintle_model::behavior::friction::{
    Belt, Branch, Coefficient, Context, Criterion, Derivatives, Friction, Input, Internal, Potential,
    Pressing, State, StickStiffness, Tangential,
};
use pintle_scene::{PotentialFunction, PotentialOperator};
use serde::Deserialize;

type Six = [f64; 6];

#[derive(Deserialize)]
struct File {
    schema: String,
    criteria: Vec<Forces>,
    updates: Vec<Update>,
    belts: Vec<Wrapped>,
    potentials: Vec<Closest>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Forces {
    r#type: String,
    criterion: usize,
    parameters: Vec<f64>,
    coefficient: f64,
    forces: Six,
    position: Six,
    /// P, F_C, F_N, Φ.
    values: [f64; 4],
    gradients: [Six; 4],
    hessians: [[Six; 6]; 4],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Update {
    r#type: String,
    criterion: usize,
    parameters: Vec<f64>,
    coefficients: [f64; 3],
    stick_stiffness: f64,
    start: Six,
    accumulated_slip: f64,
    displacement: Six,
    forces: Six,
    duration: f64,
    position: Six,
    /// Six forces, Δγ, accumulated slip, F_N.
    values: [f64; 9],
    tangent: [[f64; 13]; 9],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wrapped {
    tension: [f64; 2],
    angle: f64,
    coefficient: f64,
    /// P, Φ.
    values: [f64; 2],
    gradients: [[f64; 3]; 2],
    hessians: [[[f64; 3]; 3]; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Closest {
    scale: [f64; 3],
    radius: f64,
    stick_stiffness: f64,
    start: [f64; 3],
    displacement: [f64; 3],
    normal: f64,
    coefficient: f64,
    /// f1, f2, m1, Δγ.
    values: [f64; 4],
    tangent: [[f64; 4]; 4],
}

fn file() -> File {
    let file: File =
        serde_json::from_str(include_str!("../../src/audit/oracles/golden/friction.json")).unwrap();
    assert_eq!(file.schema, "pintle-friction/1");
    file
}

/// How many states the file has of each kind, as certificates name them.
pub(crate) fn states_by_kind() -> std::collections::BTreeMap<String, u64> {
    let file = file();
    let mut found = std::collections::BTreeMap::new();
    for case in &file.criteria {
        *found.entry(format!("BEHAVIOR friction of {}", case.r#type)).or_default() += 1;
    }
    found.insert("BEHAVIOR friction of a belt".into(), file.belts.len() as u64);
    found.insert("BEHAVIOR friction by potential".into(), file.potentials.len() as u64);
    found
}

fn criterion(name: &str, place: usize, parameters: &[f64]) -> Criterion {
    let friction = ConnectionType::named(name, None).unwrap().friction.unwrap();
    let numbers: Vec<Option<f64>> = parameters.iter().copied().map(Some).collect();
    Criterion::predefined(&friction, &numbers, &[], false).unwrap().remove(place)
}

/// Agreement in roundings of the largest number of what is compared: JAX differentiates through square roots in doubles.
fn agree(what: &str, ours: &[f64], theirs: &[f64]) {
    let size = theirs.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
    for (i, (a, b)) in ours.iter().zip(theirs).enumerate() {
        let error = (a - b).abs() / (U * size);
        assert!(error <= gate("JAX"), "{what}[{i}]: {a}, JAX {b} ({error} u)");
    }
}

#[test]
fn criteria_agree_with_jax() {
    for case in file().criteria {
        let context = Context { position: case.position, ..Context::default() };
        let (point, flags) = criterion(&case.r#type, case.criterion, &case.parameters).derivatives(
            &case.forces,
            case.coefficient,
            None,
            &context,
        );
        assert!(flags.is_empty());
        let all: [Derivatives<f64>; 4] = [point.tangential, point.contact, point.normal, point.criterion];
        for (i, ours) in all.iter().enumerate() {
            let what = format!("{} {} result {i}", case.r#type, case.criterion);
            agree(&what, &[ours.value], &case.values[i..=i]);
            agree(&what, &ours.gradient, &case.gradients[i]);
            agree(&what, ours.hessian.as_flattened(), case.hessians[i].as_flattened());
        }
    }
}

#[test]
fn updates_agree_with_jax() {
    let mut slips = 0;
    for case in file().updates {
        let [at_rest, kinetic, decay] = case.coefficients;
        let friction = Friction {
            criterion: criterion(&case.r#type, case.criterion, &case.parameters),
            coefficient: Coefficient::Exponential { at_rest, kinetic, decay },
            maximum: None,
            stick_stiffness: StickStiffness::Given(case.stick_stiffness),
            radius: 1.0,
        };
        let state = State {
            force: case.start,
            accumulated_slip: case.accumulated_slip,
            stick_stiffness: Some(case.stick_stiffness),
        };
        let input = Input {
            displacement: case.displacement,
            forces: case.forces,
            duration: Some(case.duration),
            context: Context { position: case.position, ..Context::default() },
        };
        let (outcome, tangent) = friction.tangent(&state, &input, Branch::Decided);
        slips += usize::from(outcome.slip_increment > 0.0);
        let what = format!("{} {}", case.r#type, case.criterion);
        let mut ours = outcome.force.to_vec();
        ours.extend([outcome.slip_increment, outcome.accumulated_slip, outcome.normal]);
        agree(&what, &ours, &case.values);
        let partials =
            tangent.force.into_iter().chain([tangent.slip_increment, tangent.slip_increment, tangent.normal]);
        for (i, partial) in partials.enumerate() {
            let mut row = partial.displacement.to_vec();
            row.extend(partial.forces);
            row.push(partial.duration);
            agree(&format!("{what} row {i}"), &row, &case.tangent[i]);
        }
    }
    assert!(slips > 10, "{slips}");
}

#[test]
fn belts_agree_with_jax() {
    let belt = Belt {
        coefficient: Coefficient::Constant(0.1),
        maximum: None,
        stick_stiffness: StickStiffness::Given(1.0),
    };
    for case in file().belts {
        let (point, _) = belt.derivatives(case.tension, case.angle, case.coefficient);
        for (i, ours) in [point.tangential, point.criterion].iter().enumerate() {
            agree("belt", &[ours.value], &case.values[i..=i]);
            agree("belt", &ours.gradient[..3], &case.gradients[i]);
            for j in 0..3 {
                agree("belt", &ours.hessian[j][..3], &case.hessians[i][j]);
            }
        }
    }
}

#[test]
fn closest_points_agree_with_jax() {
    for case in file().potentials {
        let scales = case.scale;
        let terms = [(0, scales[0]), (1, scales[1]), (3, scales[2])].map(|(k, scale)| {
            pintle_model::behavior::friction::Contribution {
                scale,
                ..component(k, 2.0, PotentialFunction::Abs)
            }
        });
        let potential = Potential::new(PotentialOperator::Sum, 2.0, terms.to_vec()).unwrap();
        let friction = Friction {
            criterion: Criterion {
                tangential: Tangential::Potential(potential),
                pressing: Pressing::Component(4),
                internal: Internal::Constant(0.0),
                output: "CSFC",
            },
            coefficient: Coefficient::Constant(case.coefficient),
            maximum: None,
            stick_stiffness: StickStiffness::Given(case.stick_stiffness),
            radius: case.radius,
        };
        let placed = |x: [f64; 3]| [x[0], x[1], 0.0, x[2], 0.0, 0.0];
        let state = State { force: placed(case.start), ..State::default() };
        let input = Input {
            displacement: placed(case.displacement),
            forces: [0.0, 0.0, 0.0, 0.0, case.normal, 0.0],
            duration: None,
            context: Context::default(),
        };
        let (outcome, tangent) = friction.tangent(&state, &input, Branch::Decided);
        let ours = [outcome.force[0], outcome.force[1], outcome.force[3], outcome.slip_increment];
        agree("closest point", &ours, &case.values);
        let rows = [tangent.force[0], tangent.force[1], tangent.force[3], tangent.slip_increment];
        for (i, row) in rows.iter().enumerate() {
            let row = [row.displacement[0], row.displacement[1], row.displacement[3], row.forces[4]];
            agree(&format!("closest point, row {i}"), &row, &case.tangent[i]);
        }
    }
}
