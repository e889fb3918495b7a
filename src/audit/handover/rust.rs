//! A counter-example as a test in Rust.

use super::{Entry, ExportError, comment, entry, list, matrix, number, vector};
use crate::audit::case::Case;
use crate::audit::counterexample::CounterExample;
use crate::audit::quantity::Quantity;
use crate::connector::{Branch, Definition, State};
use crate::node::{DOFS, Pair};
use crate::vector::Vector;

/// A double that need not be finite.
fn literal(x: f64) -> String {
    if x.is_finite() { number(x) } else { format!("f64::from_bits({:#x})", x.to_bits()) }
}

fn pair(pair: &Pair<f64>) -> String {
    let node = |node: &crate::node::Node<f64>| {
        format!(
            "Node {{ displacement: {}, triad: {}, flow: {} }}",
            vector(&node.displacement),
            matrix(&node.triad),
            number(node.flow)
        )
    };
    format!(
        "Pair {{\n        reference: {},\n        a: {},\n        b: {},\n    }}",
        vector(&pair.reference),
        node(&pair.a),
        node(&pair.b)
    )
}

fn optional(x: Option<f64>) -> String {
    x.map_or("None".into(), |x| format!("Some({})", number(x)))
}

/// The statements that differ from what [`Definition::new`] gives.
fn definition(of: &Definition) -> String {
    let plain = Definition::new(of.connection.clone(), of.initial);
    let mut text = String::new();
    let mut set = |field: &str, value: String| text.push_str(&format!("    definition.{field} = {value};\n"));
    if of.flow_scale != plain.flow_scale {
        set("flow_scale", number(of.flow_scale));
    }
    if of.fixed_direction != plain.fixed_direction {
        set("fixed_direction", vector(&of.fixed_direction));
    }
    for (k, x) in of.references.iter().enumerate().filter(|(_, x)| x.is_some()) {
        set(&format!("references[{k}]"), optional(*x));
    }
    for (k, stop) in of.stops.iter().enumerate() {
        if let Some(stop) = stop {
            let (lower, upper) = (optional(stop.lower), optional(stop.upper));
            set(&format!("stops[{k}]"), format!("Some(Stop {{ lower: {lower}, upper: {upper} }})"));
        }
    }
    for (field, is, was) in [("planar", of.planar, plain.planar)] {
        if is != was {
            set(field, is.to_string());
        }
    }
    for (field, is, was) in [("moves", of.moves, plain.moves), ("rotates", of.rotates, plain.rotates)] {
        if is != was {
            set(field, format!("{is:?}"));
        }
    }
    text
}

fn branch(of: &Branch<f64>) -> String {
    let turns = |t: &crate::connector::Turns<f64>| {
        format!("Turns {{ turns: {}, principal: {} }}", number(t.turns), number(t.principal))
    };
    format!(
        "Branch {{\n        turns: [{}],\n        torsion: {},\n        rotation_vector: {},\n        euler_sign: {},\n        accumulated: {},\n        accumulated_rest: {},\n    }}",
        of.turns.iter().map(turns).collect::<Vec<_>>().join(", "),
        turns(&of.torsion),
        vector(&of.rotation_vector),
        number(of.euler_sign),
        number(of.accumulated),
        number(of.accumulated_rest)
    )
}

/// How the number in question is taken from an evaluation, and the statements before it.
fn taken(Entry { quantity, k, i }: Entry) -> Option<(&'static str, String)> {
    const FORCES: &str = "    \
        let want = Want { stiffness: true, ..Want::default() };\n    \
        let rows = connector.force_rows(&state, &found.branch, [true; 6], want, &mut Tally::default());\n";
    let (row, column) = (i / DOFS, i % DOFS);
    let plain = |text: String| Some(("", text));
    match quantity {
        Quantity::Value => plain(format!("found.residual[{k}].or(found.displacement[{k}])")),
        Quantity::FirstDerivatives => plain(format!("found.jacobian[{k}].map(|row| row[{i}])")),
        Quantity::SecondDerivatives => {
            plain(format!("found.hessian[{k}].as_ref().map(|matrix| matrix[{row}][{column}])"))
        }
        Quantity::Rate => plain(format!("found.residual_rate[{k}].or(found.velocity[{k}])")),
        Quantity::Acceleration => {
            plain(format!("found.residual_acceleration[{k}].or(found.acceleration[{k}])"))
        }
        Quantity::NodalForces => Some((FORCES, format!("rows.row({k}).map(|row| row.row[{i}])"))),
        Quantity::GeometricStiffness => {
            let change = format!(
                "rows.row({k}).and_then(|row| row.change.as_ref()).map(|change| change[{row}][{column}])"
            );
            Some((FORCES, change))
        }
        _ => None,
    }
}

impl CounterExample {
    /// A test in Rust that needs this crate and nothing else: it evaluates the connector after the same history, bit for bit, and
    /// compares the number in question with what it must be.
    ///
    /// # Errors
    /// What cannot be replayed; a mismatch of a law, or of a kind of number, that is not one entry of an evaluation.
    pub fn rust(&self) -> Result<String, ExportError> {
        let case = self.case()?;
        let numbers = crate::audit::product(&case).unwrap_or_default();
        let found = entry(self, &numbers)?;
        let Some((before, taken)) = taken(found) else {
            return Err(ExportError::Lost(format!("{} is no number of a connector alone", self.entry)));
        };
        Ok(self.test(&case, before, &taken))
    }

    fn test(&self, case: &Case, before: &str, taken: &str) -> String {
        let halves: Vec<String> = self.connector.types.iter().map(|name| format!("{name:?}")).collect();
        let (first, second) = match halves.as_slice() {
            [first, second, ..] => (first.clone(), format!("Some({second})")),
            [first] => (first.clone(), "None".into()),
            [] => ("\"\"".into(), "None".into()),
        };
        let mut text = String::new();
        let title = format!(
            "// {} by {}: {} against {}, written by pintle {}.\n",
            case.definition.connection.name,
            comment(&self.subject),
            comment(&self.entry),
            comment(&self.against),
            comment(&self.version)
        );
        text.push_str(&title);
        let definition = definition(&case.definition);
        let has_stop = case.definition.stops.iter().any(Option::is_some);
        let mut used = vec!["Connector", "Definition", "Increment", "Request", "State", "Tally"];
        if has_stop {
            used.push("Stop");
        }
        if case.start.is_some() {
            used.extend(["Branch", "Turns"]);
        }
        used.sort_unstable();
        let force = if before.is_empty() { "" } else { "use pintle::force::Want;\n" };
        let changed = |is: bool| if is { "mut " } else { "" };
        let start = case.start.as_ref().map_or("connector.initial_branch()".into(), branch);
        text.push_str(&format!("use pintle::catalog::ConnectionType;\nuse pintle::connector::{{{}}};\n{force}use pintle::node::{{Node, Pair}};\n\n\
             #[test]\nfn counter_example() {{\n    \
             let connection = ConnectionType::named({first}, {second}).unwrap();\n    let initial = {};\n    \
             let {}definition = Definition::new(connection, initial);\n{definition}    \
             let connector = Connector::<f64>::new(&definition);\n    let {}branch = {start};\n",
            used.join(", "),
            pair(&case.definition.initial),
            changed(!definition.is_empty()),
            changed(case.path.len() > 1)));
        for (n, step) in case.path.iter().enumerate() {
            let State { pair: at, velocity, acceleration } = &step.state;
            let increment = &step.increment;
            let vectors = |both: &[Vector<f64>; 2]| format!("[{}, {}]", vector(&both[0]), vector(&both[1]));
            let then = if n + 1 == case.path.len() {
                "let asked = Request::everything(2);\n    \
                 let found = connector.evaluate(&state, &increment, &branch, &asked, &mut Tally::default());"
            } else {
                "branch = connector.advance(&state, &increment, &branch);"
            };
            text.push_str(&format!("    let pair = {};\n    let state = State {{\n        pair,\n        velocity: {},\n        acceleration: {},\n    }};\n    \
                 let increment = Increment {{\n        rotation: {},\n        whole_turns: {},\n        flow: {},\n    }};\n    {then}\n",
                pair(at),
                list(velocity),
                list(acceleration),
                vectors(&increment.rotation),
                vectors(&increment.whole_turns),
                list(&increment.flow)));
        }
        text.push_str(&format!("{before}    let got = {taken}.unwrap();\n    let want: f64 = {};\n    \
             let tolerance: f64 = {};\n    \
             assert!((got - want).abs() <= tolerance, \"{{got:e}}, must be {{want:e}} within {{tolerance:e}}\");\n}}\n",
            literal(self.want.0),
            literal(self.tolerance.0)));
        text
    }
}
