//! A counter-example as a script for JAX: the reference formulas, and the state.

use crate::case::Case;
use crate::case::quantity::{Numbers, Quantity, request};
use crate::judge::verdict::Summand;
use crate::oracles::truth::Truth;
use crate::replay::counterexample::CounterExample;
use crate::replay::handover::{ExportError, NumberAt, comment, entry, list, matrix, number, vector};
use pintle_kinematics::catalog::Loading;
use pintle_kinematics::connector::{Branch, Connector};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, dot};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// The formulas, a second time: they know nothing of the Rust source.
const FORMULAS: &str = include_str!("../../oracles/golden/reference_formulas.py");

/// What the script does with the state, after formulas and values.
const JUDGES: &str = include_str!("judge.py");

/// The verdict on what a script found, its last lines.
const VERDICT: &str = include_str!("verdict.py");

/// The number of whole turns by which a rotation vector is longer than its principal one, along it.
fn sheet(pair: &Pair<f64>, continued: Vector<f64>) -> f64 {
    let principal = so3::log(&pair.relative().q);
    let size = norm(principal);
    if size == 0.0 { 0.0 } else { ((dot(principal, continued) / size - size) / TAU).round() }
}

/// A Python string.
fn text(text: &str) -> String {
    serde_json::Value::from(comment(text)).to_string()
}

fn nodes(name: &str, pair: &Pair<f64>) -> String {
    let node = |node: &Node<f64>| {
        format!("({}, {}, {})", vector(&node.displacement), matrix(&node.triad), number(node.flow))
    };
    format!("{name} = ({}, {}, {})\n", vector(&pair.reference), node(&pair.a), node(&pair.b))
}

impl CounterExample {
    /// A script for Python with JAX and NumPy, and nothing else: formulas of the connection types that share nothing with this crate,
    /// differentiated by JAX, at the same state. It prints what they give beside what was given and what must be, and ends with exit
    /// code 1 unless they confirm what must be.
    ///
    /// What a history decides (whole turns, the sheet of the rotation vector, the side of Euler angles) is handed over with the state;
    /// the script does not follow histories. What a FLOW-CONVERTER has accumulated it sums up by itself.
    ///
    /// # Errors
    /// What cannot be replayed; a mismatch of a law, or of a kind of number that the formulas do not have: moments of constraints that
    /// are conjugate to no component, reactions of the ground.
    pub(super) fn script(&self, case: &Case) -> Result<String, ExportError> {
        if self.law.is_some() {
            let message = format!(
                "{}: a law relates numbers of this program to each other, and a script for JAX has its own",
                self.against
            );
            return Err(ExportError::Lost(message));
        }
        let connector = case.connector();
        let (Some((evaluation, _)), Some(last)) = (case.evaluation(&request()), case.last()) else {
            return Err(ExportError::Lost("it has no state".to_string()));
        };
        let is_of_force =
            |quantity: Quantity| matches!(quantity, Quantity::NodalForces | Quantity::GeometricStiffness);
        let mut found: Vec<(NumberAt, f64)> = Vec::new();
        for Summand { quantity, component, entry, by } in &self.sum {
            let summand = NumberAt { quantity: *quantity, k: *component, i: *entry };
            let summand =
                if is_of_force(*quantity) { self.of_force(case, &connector, summand)? } else { summand };
            found.push((summand, *by));
        }
        if found.is_empty() {
            let one = match self.quantity {
                Some(quantity) if is_of_force(quantity) => {
                    let force = entry(self, &crate::product(case).unwrap_or_default())?;
                    self.of_force(case, &connector, force)?
                }
                _ => entry(self, &Numbers::of(&evaluation))?,
            };
            found.push((one, 1.0));
        }
        let judged = self.judged(case)?;
        let mut script = String::from(FORMULAS);
        script.push_str("\n\n# The state of the counter-example\n\n");
        self.describe(&mut script, case, &found, judged);
        script.push_str(&nodes("INITIAL", &case.definition.initial));
        script.push_str(&nodes("STATE", &last.state.pair));
        history(&mut script, case, &evaluation.branch);
        let active: Vec<&str> =
            connector.active().iter().map(|active| if *active { "True" } else { "False" }).collect();
        script.push_str(&format!(
            "RATES = {}\nACCELERATIONS = {}\nACTIVE = [{}]\nBETA = {}\n",
            list(&last.state.velocity),
            list(&last.state.acceleration),
            active.join(", "),
            number(case.definition.flow_scale)
        ));
        script.push_str("\n\n");
        script.push_str(JUDGES);
        script.push_str(VERDICT);
        Ok(script)
    }

    /// The derivative that a nodal force of a unit force is, or its change: that of the component, where its force is conjugate to it.
    fn of_force(
        &self,
        case: &Case,
        connector: &Connector<f64>,
        of: NumberAt,
    ) -> Result<NumberAt, ExportError> {
        let NumberAt { quantity, k, i } = of;
        let lost = |why: &str| Err(ExportError::Lost(format!("{}: {why}", self.entry)));
        let is_conjugate = matches!(case.definition.connection.loading(k), Some(Loading::Conjugate));
        if !is_conjugate || connector.differentiated(k) != connector.position_measure(k) {
            return lost(
                "the JAX formulas have derivatives, and this force is not conjugate to what is differentiated",
            );
        }
        let (quantity, columns) = match quantity {
            Quantity::NodalForces => (Quantity::FirstDerivatives, vec![i]),
            _ => (Quantity::SecondDerivatives, vec![i / DOFS, i % DOFS]),
        };
        if columns.iter().any(|j| connector.reach()[*j] && !connector.active()[*j]) {
            return lost("the JAX formulas have no derivatives by what the ground holds");
        }
        Ok(NumberAt { quantity, k, i })
    }

    /// What was given, what it must be and its tolerance; of Taylor's test, the row along the direction and the slope of the values there, on
    /// 237 bits, for the remainder itself is no number of a formula.
    fn judged(&self, case: &Case) -> Result<[f64; 3], ExportError> {
        let judged = [self.got.0, self.want.0, self.tolerance.0];
        if !self.is_of_taylor() {
            return match judged[1..].iter().all(|x| x.is_finite()) {
                true => Ok(judged),
                false => {
                    Err(ExportError::Lost(format!("{}: what it must be is no finite number", self.entry)))
                }
            };
        }
        let (_, remainder) = self.taylor()?;
        let (Some(numbers), Some(truth)) = (crate::product(case), Truth::of(case)) else {
            return Err(ExportError::Lost("it has no state".to_string()));
        };
        let first = truth.first();
        let (mut got, mut want) = (0.0, 0.0);
        for Summand { component, entry, by, .. } in &self.sum {
            let row = numbers.entries(Quantity::FirstDerivatives);
            got += by * row.get(*component, *entry).unwrap_or(f64::NAN);
            want += by * first.get(*component, *entry).map_or(f64::NAN, |slope| slope.to_f64());
        }
        Ok([got, want, remainder.allowed])
    }

    fn describe(
        &self,
        script: &mut String,
        case: &Case,
        found: &[(NumberAt, f64)],
        [got, want, tolerance]: [f64; 3],
    ) {
        let Some((NumberAt { quantity, .. }, _)) = found.first() else { return };
        let field = match quantity {
            Quantity::FirstDerivatives => "jacobian",
            Quantity::SecondDerivatives => "hessian",
            Quantity::Rate => "velocity",
            Quantity::Acceleration => "acceleration",
            _ => "measure",
        };
        let place = |(NumberAt { quantity, k, i }, by): &(NumberAt, f64)| {
            let place = match quantity {
                Quantity::FirstDerivatives => format!("{k}, {i}"),
                Quantity::SecondDerivatives => format!("{k}, {}, {}", i / DOFS, i % DOFS),
                _ => format!("{k},"),
            };
            format!("(({place}), {})", number(*by))
        };
        // A pair is two connectors side by side: translations of the first, rotations of the second.
        let mut kinds: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for one in found {
            let half = case.definition.connection.halves[usize::from(one.0.k >= 3)].map(|half| half.name);
            kinds.entry(half.unwrap_or(&case.definition.connection.name)).or_default().push(place(one));
        }
        let of_kind =
            |(kind, places): (&&str, &Vec<String>)| format!("{}: [{}]", text(kind), places.join(", "));
        let places: Vec<String> = kinds.iter().map(of_kind).collect();
        let words = format!(
            "{} by {}: {} against {}, written by pintle {}",
            case.definition.connection.name, self.subject, self.entry, self.against, self.version
        );
        script.push_str(&format!("ABOUT = {}\nFIELD, PLACES = {}, {{{}}}\nGIVEN = float({:?})\nWANTED = float({:?})\nTOLERANCE = float({:?})\n",
            text(&words),
            text(field),
            places.join(", "),
            number(got),
            number(want),
            number(tolerance)));
    }
}

/// What the history decided, and the increments of the path.
fn history(script: &mut String, case: &Case, branch: &Branch<f64>) {
    let turns = branch.turns.map(|turns| turns.turns);
    let sheet = case.last().map_or(0.0, |last| sheet(&last.state.pair, branch.rotation_vector));
    let start = case.start.map_or(0.0, |start| start.accumulated + start.accumulated_rest);
    script.push_str(&format!(
        "TURNS = {}\nSHEET, SIDE, TWIST, START = {}, {}, {}, {}\nINCREMENTS = [\n",
        list(&turns),
        number(sheet),
        number(branch.euler_sign),
        number(branch.torsion.turns),
        number(start)
    ));
    for step in &case.path {
        let (a, increment) = (&step.state.pair.a, &step.increment);
        let [turn_a, turn_b] = &increment.rotation;
        script.push_str(&format!(
            "    ({}, {}, {}, {}),\n",
            matrix(&a.triad),
            vector(turn_a),
            vector(turn_b),
            number(increment.flow[1])
        ));
    }
    script.push_str("]\n");
}
