//! JAX as an oracle: what another language computes by formulas of its own, at states of its own.
//!
//! The numbers are those that `scripts/reference/reference.py` and `scripts/reference/reference_forces.py` wrote and `--check` recomputes
//! (`verify/golden`): values, rows and rates at every state, second derivatives and geometric stiffness at some, each with an estimate
//! of its own error. They are embedded as they are, but deflated, and a state is read when it is judged: a second copy of some of them
//! would have to be kept in step, for less evidence. Elsewhere JAX says nothing. The test suite reads the files by a reader of its
//! own (`verify/golden.rs`), which takes no field that it does not know.

use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::case::{Case, Step};
use crate::judge::bound::{Bound, C};
use crate::judge::components::{Exact, Surroundings};
use crate::judge::examined::{Examined, Trusted};
use crate::judge::outcome::Check;
use crate::judge::table::{Entry, ResultTable};
use crate::judge::verdict::{Summand, Wanted};
use crate::oracles::force::product_at;
use crate::oracles::oracle::{Answer, Narrow, Oracle, WideAnswers};
use crate::oracles::truth::Truth;
use crate::settings::Settings;
use flate2::read::DeflateDecoder;
use pintle_kinematics::catalog::{ConnectionType, FORCE, TABLE};
use pintle_kinematics::connector::{Components, Definition, Increment, State};
use pintle_kinematics::node::{DOF, DOFS, Node, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::scalar::{U, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, product as matrix_product, scale, sub};
use serde::Deserialize;
use serde_json::value::RawValue;
use std::cell::LazyCell;
use std::collections::BTreeMap;
use std::io::Read;
use std::sync::LazyLock;

type Square = [[f64; DOFS]; DOFS];

/// The text of a file that the build deflated; empty where it cannot be read.
pub(crate) fn inflated(deflated: &[u8]) -> String {
    let mut text = String::new();
    let read = DeflateDecoder::new(deflated).read_to_string(&mut text);
    read.map(|_| text).unwrap_or_default()
}

/// The numbers of the kinematics, a state a line.
static KINEMATICS: LazyLock<String> =
    LazyLock::new(|| inflated(include_bytes!(concat!(env!("OUT_DIR"), "/jax"))));
/// The nodal forces, at the same states.
static FORCES: LazyLock<String> =
    LazyLock::new(|| inflated(include_bytes!(concat!(env!("OUT_DIR"), "/forces"))));

#[derive(Deserialize)]
struct File<'a> {
    #[serde(borrow)]
    cases: Vec<&'a RawValue>,
}

/// Which state of which type a text is.
#[derive(Deserialize)]
struct Head {
    r#type: String,
    name: String,
}

/// The texts of one state.
#[derive(Clone, Copy, Debug)]
struct Texts {
    kinematics: &'static str,
    forces: Option<&'static str>,
}

/// By type, the names of its states with their texts, in the order of the file. Empty where the files cannot be read, which the test
/// suite would notice.
static INDEX: LazyLock<BTreeMap<String, Vec<(String, Texts)>>> = LazyLock::new(|| {
    let read = |text: &'static str| -> Vec<(Head, &'static str)> {
        let file: Result<File<'static>, _> = serde_json::from_str(text);
        let cases = file.map(|file| file.cases).unwrap_or_default();
        let head = |case: &'static RawValue| Some((serde_json::from_str(case.get()).ok()?, case.get()));
        cases.into_iter().filter_map(head).collect()
    };
    let of_state = |(head, text): (Head, &'static str)| ((head.r#type, head.name), text);
    let forces: BTreeMap<(String, String), &'static str> = read(&FORCES).into_iter().map(of_state).collect();
    let mut found: BTreeMap<String, Vec<(String, Texts)>> = BTreeMap::new();
    for (head, kinematics) in read(&KINEMATICS) {
        let key = (head.r#type, head.name);
        let forces = forces.get(&key).copied();
        found.entry(key.0).or_default().push((key.1, Texts { kinematics, forces }));
    }
    found
});

#[derive(Deserialize)]
#[expect(non_snake_case, reason = "the names of the file")]
struct Given {
    name: String,
    steps: usize,
    X_a: Vector<f64>,
    X_b: Vector<f64>,
    A0: Matrix<f64>,
    B0: Matrix<f64>,
    theta_a: Vector<f64>,
    theta_b: Vector<f64>,
    beta_s: f64,
    reference: Components<f64>,
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
    displacement: Components<f64>,
    residual: Components<f64>,
    velocity: Components<f64>,
    acceleration: Components<f64>,
    jacobian: Components<[f64; DOFS]>,
    #[serde(default)]
    hessian: Option<Components<Square>>,
    error: Errors,
}

/// The error of each number of a component, as the file states it.
#[derive(Deserialize)]
struct Errors {
    displacement: Components<f64>,
    residual: Components<f64>,
    velocity: Components<f64>,
    acceleration: Components<f64>,
    jacobian: Components<f64>,
    #[serde(default)]
    hessian: Components<f64>,
}

#[derive(Deserialize)]
struct Forces {
    forces: Components<f64>,
    nodal: [f64; DOFS],
    stiffness: Option<Square>,
}

/// A state at which JAX has spoken.
struct Golden {
    case: Case,
    given: Given,
    forces: Option<Forces>,
}

impl Given {
    /// The nodes at a part of the way.
    fn at(&self, t: f64) -> Pair<f64> {
        let node = |u: Vector<f64>, theta: Vector<f64>, triad: &Matrix<f64>, flow: f64| Node {
            displacement: scale(u, t),
            triad: matrix_product(&so3::matrix(so3::exp_quaternion(scale(theta, t))), triad),
            flow: flow * t,
        };
        Pair {
            reference: sub(self.X_b, self.X_a),
            a: node(self.U_a, self.theta_a, &self.A0, self.flow_a),
            b: node(self.U_b, self.theta_b, &self.B0, self.flow_b),
        }
    }

    /// Velocities and accelerations in the order of the nodal degrees of freedom.
    fn rates(&self) -> [[f64; DOFS]; 2] {
        let join = |[x_a, theta_a, x_b, theta_b]: [&Vector<f64>; 4], flow: [f64; 2]| {
            let mut all = [0.0; DOFS];
            let a = x_a.iter().chain(theta_a).chain(&flow[..1]);
            let b = x_b.iter().chain(theta_b).chain(&flow[1..]);
            all.iter_mut().zip(a.chain(b)).for_each(|(place, x)| *place = *x);
            all
        };
        [
            join([&self.v_a, &self.omega_a, &self.v_b, &self.omega_b], [self.flow_v_a, self.flow_v_b]),
            join([&self.a_a, &self.alpha_a, &self.a_b, &self.alpha_b], [self.flow_a_a, self.flow_a_b]),
        ]
    }

    /// The history that leads to the state, in the steps of the file.
    fn case(&self, connection: &ConnectionType) -> Case {
        let node = |triad: &Matrix<f64>| Node { displacement: [0.0; 3], triad: *triad, flow: 0.0 };
        let initial = Pair { reference: sub(self.X_b, self.X_a), a: node(&self.A0), b: node(&self.B0) };
        let definition = Definition {
            flow_scale: self.beta_s,
            references: self.reference,
            ..Definition::new(connection.clone(), initial)
        };
        let steps = self.steps.max(1);
        let share = 1.0 / steps as f64;
        let increment = Increment {
            rotation: [scale(self.theta_a, share), scale(self.theta_b, share)],
            whole_turns: [[0.0; 3]; 2],
            flow: [self.flow_a * share, self.flow_b * share],
        };
        let [velocity, acceleration] = self.rates();
        let step = |k: usize| {
            let t = if k == steps { 1.0 } else { k as f64 * share };
            Step { state: State { pair: self.at(t), velocity, acceleration }, increment }
        };
        let path: Vec<Step> = (1..=steps).map(step).collect();
        let longest = path
            .iter()
            .fold(norm(initial.reference), |most, step| most.max(norm(step.state.pair.separation())));
        let length = if longest > 0.0 { longest } else { 1.0 };
        let name = format!("{} {} of JAX", connection.name, self.name);
        Case { name, definition, start: None, path, length }
    }

    /// What JAX says of a quantity, entry by entry, and how far it may be off by itself.
    fn answer(&self, quantity: Quantity) -> Option<Answer> {
        let error = &self.error;
        let one = |x: Option<f64>| Some(vec![x?]);
        // Of a constrained component the residual, of any other the displacement.
        let chosen = |k: usize| match self.residual[k] {
            Some(residual) => (Some(residual), error.residual[k]),
            None => (self.displacement[k], error.displacement[k]),
        };
        let of = |k: usize| -> (Option<Vec<f64>>, Option<f64>) {
            match quantity {
                Quantity::Value => (one(chosen(k).0), chosen(k).1),
                Quantity::FirstDerivatives => (self.jacobian[k].map(|row| row.to_vec()), error.jacobian[k]),
                Quantity::SecondDerivatives => {
                    let matrix = self.hessian.as_ref().and_then(|all| all[k].as_ref());
                    (matrix.map(|matrix| matrix.as_flattened().to_vec()), error.hessian[k])
                }
                Quantity::Rate => (one(self.velocity[k]), error.velocity[k]),
                Quantity::Acceleration => (one(self.acceleration[k]), error.acceleration[k]),
                _ => (None, None),
            }
        };
        let (mut numbers, mut errors) = (Entries::default(), Entries::default());
        for k in 0..6 {
            let (Some(found), Some(error)) = of(k) else { continue };
            errors.0[k] = Some(vec![error; found.len()]);
            numbers.0[k] = Some(found.into_iter().map(Wanted::exactly).collect());
        }
        let answer = Answer { oracle: Oracle::Jax, numbers, error: errors };
        (!answer.numbers.is_empty()).then_some(answer)
    }
}

impl Golden {
    fn read(connection: &ConnectionType, texts: &Texts) -> Option<Self> {
        let given: Given = serde_json::from_str(texts.kinematics).ok()?;
        let forces = texts.forces.and_then(|text| serde_json::from_str(text).ok());
        Some(Self { case: given.case(connection), given, forces })
    }

    /// The checks of every quantity that JAX has here, each with mutants.
    fn audit(&self, settings: &Settings) -> Vec<Check> {
        let Self { case, given, .. } = self;
        let Some(end) = case.at_end() else { return Vec::new() };
        let (mut numbers, narrow) = (product_at(&end), Narrow::at(&end));
        if let Some(planted) = settings.planted {
            planted.spoil(&mut numbers);
        }
        let nearness = narrow.nearness_of_components();
        // The bound does not rest on the numbers that are judged: on what JAX says, else on dual numbers by the nodes, as far as either goes.
        let mut trusted = numbers.clone();
        let nested = narrow.nested_dual();
        for quantity in Quantity::ALL {
            let answer = given.answer(quantity);
            let of = |k: usize, i: usize, x: f64| {
                let of_jax = answer.as_ref().and_then(|answer| answer.numbers.get(k, i));
                of_jax.map(Wanted::to_f64).or_else(|| nested.entries(quantity).get(k, i)).unwrap_or(x)
            };
            trusted.set(quantity, numbers.entries(quantity).map(of));
        }
        let examined = Examined::new(&end, &numbers, Trusted::Others(trusted), &nearness);
        let answers = LazyCell::new(|| WideAnswers::of(&Truth::at(&end)));
        let exact = |quantity: Quantity| Some(Exact::of(&answers, quantity));
        let around = Surroundings { exact: Some(&exact), ..Surroundings::new(&examined.bound, nearness) };
        let mut checks = Vec::new();
        for quantity in Quantity::ALL {
            let Some(answer) = given.answer(quantity) else { continue };
            let mut check = examined.check(quantity, &answer, &around, (None, true));
            examined.add_missing(&mut check, quantity, &answer, |_| false);
            checks.push(check);
        }
        for table in self.force_tables(&numbers, &examined.bound) {
            let mut check = table.check_against(Oracle::Jax, true, &case.name, Some(case));
            if let Some(worst) = &mut check.worst {
                let place = table.entries.iter().position(|entry| entry.name == worst.entry);
                worst.sum = place.map_or_else(Vec::new, |place| self.summands(table.quantity, place));
            }
            checks.push(check);
        }
        checks
    }

    /// The component forces that JAX was given.
    fn given_forces(&self) -> Vec<(usize, f64)> {
        let all = self.forces.as_ref().map_or(&[][..], |told| &told.forces[..]);
        all.iter().enumerate().filter_map(|(k, force)| Some((k, (*force)?))).collect()
    }

    /// What is added up in an entry of nodal forces.
    fn summands(&self, quantity: Quantity, entry: usize) -> Vec<Summand> {
        let of = |(component, by): (usize, f64)| Summand { quantity, component, entry, by };
        self.given_forces().into_iter().map(of).collect()
    }

    /// Nodal forces of given component forces, and their derivatives: sums over the components, for JAX differentiates one potential.
    fn force_tables(&self, numbers: &Numbers<f64>, bound: &Bound) -> Vec<ResultTable> {
        let (Some(told), errors) = (&self.forces, &self.given.error) else { return Vec::new() };
        let forces = self.given_forces();
        let all: f64 = forces.iter().map(|(_, force)| force.abs()).sum();
        // The errors of the rows, and a few roundings of each force.
        let error = |of: &Components<f64>| {
            all * (of.iter().flatten().fold(0.0_f64, |most, x| most.max(*x)) + 8.0 * U)
        };
        let named: Vec<String> = forces.iter().map(|(k, force)| format!("{} = {force}", FORCE[*k])).collect();
        let named = named.join(", ");
        let unit = |j: usize| if j % 7 == 6 { 2 } else { usize::from(matches!(j % 7, 3..=5)) };
        let table = |quantity: Quantity, want: &[f64], error: f64| {
            let entry = |(i, want): (usize, &f64)| {
                let sum =
                    |of: &dyn Fn(usize) -> f64| forces.iter().map(|(k, force)| force * of(*k)).sum::<f64>();
                let got = sum(&|k| numbers.entries(quantity).get(k, i).unwrap_or(f64::NAN));
                let allowed: f64 =
                    forces.iter().map(|(k, force)| force.abs() * bound.tolerance(quantity, *k, i)).sum();
                let (x, y) = (i / DOFS, i % DOFS);
                let (name, class) = if quantity == Quantity::NodalForces {
                    (format!("force on {} of {named}", DOF[y]), (unit(y), 0, 0))
                } else {
                    let [less, more] = [unit(x).min(unit(y)), unit(x).max(unit(y))];
                    (format!("∂(force on {})/∂{} of {named}", DOF[x], DOF[y]), (less, more, 0))
                };
                let scale = allowed / (C * U) + got.abs();
                Entry { error, ..Entry::new(name, got, Wide::from_f64(*want), scale, class) }
            };
            let mut table = ResultTable::new(quantity);
            table.rows = vec![quantity.name().to_string()];
            table.entries = want.iter().enumerate().map(entry).collect();
            table
        };
        let mut tables = vec![table(Quantity::NodalForces, &told.nodal, error(&errors.jacobian))];
        tables.extend(told.stiffness.as_ref().map(|stiffness| {
            table(Quantity::GeometricStiffness, stiffness.as_flattened(), error(&errors.hessian))
        }));
        tables
    }
}

/// How many states of a type JAX has spoken of.
pub fn states_of(connection: &ConnectionType) -> usize {
    INDEX.get(connection.name.as_ref()).map_or(0, Vec::len)
}

/// The checks of one state of a type, by its place; none where JAX is not asked.
pub fn audit_golden(connection: &ConnectionType, place: usize, settings: &Settings) -> Vec<Check> {
    if !settings.oracles.contains(&Oracle::Jax) {
        return Vec::new();
    }
    let state = INDEX.get(connection.name.as_ref()).and_then(|states| states.get(place));
    let golden = state.and_then(|(_, texts)| Golden::read(connection, texts));
    golden.map_or_else(Vec::new, |golden| golden.audit(settings))
}

/// The same of a case that is one of these states to the last bit, as a counter-example is.
pub fn audit_at(case: &Case, settings: &Settings) -> Vec<Check> {
    let is_same = |golden: &Golden| same(&golden.case, case);
    let states = INDEX.get(case.definition.connection.name.as_ref());
    let connection = TABLE.iter().find(|entry| entry.name == case.definition.connection.name);
    let (Some(states), Some(connection), true) =
        (states, connection, settings.oracles.contains(&Oracle::Jax))
    else {
        return Vec::new();
    };
    let mut all = states.iter().filter_map(|(_, texts)| Golden::read(connection, texts));
    all.find(is_same).map_or_else(Vec::new, |golden| golden.audit(settings))
}

/// Whether two cases are one state with one history, but for their names.
fn same(one: &Case, other: &Case) -> bool {
    let pair = |pair: &Pair<f64>| {
        let node = |node: &Node<f64>| (node.displacement, node.triad, node.flow);
        (pair.reference, node(&pair.a), node(&pair.b))
    };
    let step = |step: &Step| (pair(&step.state.pair), step.state.velocity, step.state.acceleration);
    let definition = |of: &Definition| (pair(&of.initial), of.flow_scale, of.references, of.planar);
    one.path.len() == other.path.len()
        && definition(&one.definition) == definition(&other.definition)
        && one.path.iter().zip(&other.path).all(|(x, y)| step(x) == step(y))
}

#[cfg(test)]
mod tests {
    use super::{INDEX, KINEMATICS, states_of};
    use pintle_kinematics::catalog::TABLE;

    #[test]
    fn every_type_has_its_states() {
        let all: usize = INDEX.values().map(Vec::len).sum();
        assert_eq!(all, KINEMATICS.matches("{\"type\":").count());
        for connection in TABLE {
            assert!(states_of(connection) >= 20, "{}", connection.name);
            let has_forces = (0..6).any(|k| connection.loading(k).is_some());
            let states = INDEX.get(connection.name.as_ref()).map_or(&[][..], Vec::as_slice);
            assert_eq!(
                states.iter().all(|(_, texts)| texts.forces.is_some()),
                has_forces,
                "{}",
                connection.name
            );
        }
    }
}
