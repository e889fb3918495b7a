//! A counter-example as a test in Rust.

use crate::case::Case;
use crate::case::quantity::Quantity;
use crate::judge::verdict::Summand;
use crate::replay::counterexample::CounterExample;
use crate::replay::handover::law::{Asked, Equality, Side, law};
use crate::replay::handover::{ExportError, NumberAt, about, embedded, entry, list, matrix, number, vector};
use pintle_kinematics::connector::{Branch, Definition, State};
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::vector::Vector;

/// A double that need not be finite.
pub(super) fn literal(x: f64) -> String {
    if x.is_finite() { number(x) } else { format!("f64::from_bits({:#x})", x.to_bits()) }
}

fn pair(pair: &Pair<f64>) -> String {
    let node = |node: &pintle_kinematics::node::Node<f64>| {
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
    let turns = |t: &pintle_kinematics::connector::Turns<f64>| {
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

/// The statements that lead to `rows`, the nodal forces of components.
fn force_rows(components: &str) -> String {
    format!(
        "    let wanted = Want {{ stiffness: true, ..Want::default() }};\n    \
         let rows = connector.force_rows(&state, &found.branch, {components}, wanted, &mut Tally::default());\n"
    )
}

/// How a number is taken from an evaluation, and whether it needs nodal forces.
fn taken(NumberAt { quantity, k, i }: NumberAt) -> Option<(bool, String)> {
    let (row, column) = (i / DOFS, i % DOFS);
    let plain = |text: String| Some((false, text));
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
        Quantity::NodalForces => Some((true, format!("rows.row({k}).map(|row| row.row[{i}])"))),
        Quantity::GeometricStiffness => {
            let change = format!(
                "rows.row({k}).and_then(|row| row.change.as_ref()).map(|change| change[{row}][{column}])"
            );
            Some((true, change))
        }
        _ => None,
    }
}

/// The statements that lead to `found`, the evaluation of a connector at the end of a case.
fn evaluated(case: &Case, asked: &str) -> String {
    let connection = &case.definition.connection;
    let (first, second) = match connection.halves {
        [Some(first), Some(second)] => (first.name.to_string(), format!("Some({:?})", second.name)),
        _ => (connection.name.to_string(), "None".into()),
    };
    let definition = definition(&case.definition);
    let changed = |is: bool| if is { "mut " } else { "" };
    let start = case.start.as_ref().map_or("connector.initial_branch()".into(), branch);
    let mut text = format!(
        "    let connection = ConnectionType::named({first:?}, {second}).unwrap();\n    let initial = {};\n    \
         let {}definition = Definition::new(connection, initial);\n{definition}    \
         let connector = Connector::<f64>::new(&definition);\n    let {}branch = {start};\n",
        pair(&case.definition.initial),
        changed(!definition.is_empty()),
        changed(case.path.len() > 1)
    );
    for (n, step) in case.path.iter().enumerate() {
        let State { pair: at, velocity, acceleration } = &step.state;
        let increment = &step.increment;
        let vectors = |both: &[Vector<f64>; 2]| format!("[{}, {}]", vector(&both[0]), vector(&both[1]));
        let then = if n + 1 == case.path.len() {
            format!(
                "let asked = {asked};\n    \
                 let found = connector.evaluate(&state, &increment, &branch, &asked, &mut Tally::default());"
            )
        } else {
            "branch = connector.advance(&state, &increment, &branch);".to_string()
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
    text
}

/// What of the crate a text uses, as its imports.
fn imports(text: &str) -> String {
    let uses = |name: &&str| {
        ["::", " {"].iter().any(|after| {
            let word = format!("{name}{after}");
            text.match_indices(&word)
                .any(|(at, _)| !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == ':'))
        })
    };
    let of_connector = [
        "Branch",
        "Connector",
        "Definition",
        "Increment",
        "Output",
        "Request",
        "State",
        "Stop",
        "Tally",
        "Turns",
    ];
    let of_connector: Vec<&str> = of_connector.into_iter().filter(uses).collect();
    let force = if uses(&"Want") { "use pintle::force::Want;\n" } else { "" };
    format!(
        "use pintle::catalog::ConnectionType;\nuse pintle::connector::{{{}}};\n{force}use pintle::node::{{Node, Pair}};\n",
        of_connector.join(", ")
    )
}

/// The expression of what is asked for, and the components whose forces are.
fn asked(of: Asked) -> (String, String) {
    let whole = "[true; 6]".to_string();
    match of {
        Asked::Whole => ("Request::everything(2)".to_string(), whole),
        Asked::Rows => ("Request::new(&[Output::CU, Output::RES], [true; 6], 1)".to_string(), whole),
        Asked::Alone(k) => {
            let only = format!("{:?}", std::array::from_fn::<bool, 6, _>(|other| other == k));
            let outputs = "Output::CU, Output::CV, Output::CA, Output::RES, Output::RESV, Output::RESA";
            (format!("Request::new(&[{outputs}], {only}, 2)"), only)
        }
    }
}

impl CounterExample {
    /// A test in Rust that needs this crate and nothing else. It evaluates the connector after the same history, bit for bit, and
    /// compares the number in question with what it must be. Of a sum of numbers, or of a law, it compares the sum, at the same
    /// state or at its twin. Of Taylor's remainder it computes that again, along the same direction. What is no number of one
    /// evaluation, as one that is missing, one that must be no number, or what a history loses when it is saved, is judged again as
    /// the audit does.
    ///
    /// # Errors
    /// What cannot be replayed; a mismatch of a kind of number that is not of a connector; of a law that is not of one state.
    pub(super) fn test_of_connector(&self, case: &Case) -> Result<String, ExportError> {
        if self.is_of_taylor() {
            return self.taylor_again(case);
        }
        if !self.sum.is_empty() {
            return self.test_of(case, &self.law_of_sum());
        }
        match law(self, case) {
            Ok(Some(law)) => return self.test_of(case, &law),
            Err(_) if self.is_of_a_law_of_states() => return self.judged_again(case),
            Err(refused) => return Err(refused),
            Ok(None) => {}
        }
        let numbers = crate::product(case).unwrap_or_default();
        let is_of_connector =
            self.quantity.is_some_and(|quantity| taken(NumberAt { quantity, k: 0, i: 0 }).is_some());
        let found = match entry(self, &numbers) {
            Ok(found) if self.want.0.is_finite() && self.tolerance.0.is_finite() => found,
            _ if is_of_connector => return self.judged_again(case),
            other => other?,
        };
        let Some((before, taken)) = taken(found) else {
            return Err(ExportError::Lost(format!("{} is no number of a connector alone", self.entry)));
        };
        let before = if before { force_rows("[true; 6]") } else { String::new() };
        let text = format!(
            "{}{before}    let got = {taken}.unwrap();\n    let want: f64 = {};\n",
            evaluated(case, "Request::everything(2)"),
            literal(self.want.0)
        );
        Ok(self.test(case, &text))
    }

    /// A sum of numbers that must be what the counter-example wants.
    fn law_of_sum(&self) -> Equality {
        let nothing = || Side { case: None, asked: Asked::Whole, terms: Vec::new(), velocity: None };
        let term = |of: &Summand| (of.quantity, of.component, of.entry, of.by);
        let terms = self.sum.iter().map(term).collect();
        Equality { got: Side { terms, ..nothing() }, want: nothing(), constant: self.want.0 }
    }

    /// A test that computes Taylor's remainder again.
    fn taylor_again(&self, case: &Case) -> Result<String, ExportError> {
        self.taylor()?;
        let statements = "    let example = CounterExample::read(COUNTER_EXAMPLE).unwrap();\n    \
             // The remainder over the step, in units of what it may be, at the worst of the steps.\n    \
             let got: f64 = example.remainder().unwrap();\n    \
             assert!(got <= 1.0, \"{got:e} times what it may be\");\n";
        self.embedded_test(case, "use pintle::audit::CounterExample;\n", statements)
    }

    /// A test that judges the state again by every oracle and law.
    fn judged_again(&self, case: &Case) -> Result<String, ExportError> {
        let statements = "    let failing = CounterExample::read(COUNTER_EXAMPLE).unwrap().failing().unwrap();\n    \
             let report = failing.audit(&Settings::default());\n    \
             assert_eq!(report.mismatches(), 0, \"{:#?}\", report.subjects);\n";
        self.embedded_test(case, "use pintle::audit::{CounterExample, Settings};\n", statements)
    }

    fn embedded_test(&self, case: &Case, imports: &str, statements: &str) -> Result<String, ExportError> {
        let (heading, values) = (self.heading(case), embedded(self)?);
        Ok(format!("{heading}{imports}\n{values}#[test]\nfn counter_example() {{\n{statements}}}\n"))
    }

    fn heading(&self, case: &Case) -> String {
        format!("// {}.\n", about(&case.definition.connection.name, self))
    }

    /// A test of two sums.
    fn test_of(&self, case: &Case, law: &Equality) -> Result<String, ExportError> {
        let block = |sum: &Side| -> Result<String, ExportError> {
            if sum.terms.is_empty() && sum.velocity.is_none() {
                return Ok(literal(law.constant));
            }
            let (request, components) = asked(sum.asked);
            let mut text = format!("{{\n{}", evaluated(sum.case.as_ref().unwrap_or(case), &request));
            let (mut forces, mut terms) = (false, Vec::new());
            for (quantity, k, i, by) in &sum.terms {
                let Some((needs_forces, taken)) = taken(NumberAt { quantity: *quantity, k: *k, i: *i })
                else {
                    return Err(ExportError::Lost(format!(
                        "{} is no number of a connector alone",
                        self.entry
                    )));
                };
                forces |= needs_forces;
                terms.push(format!("{} * {taken}.unwrap()", number(*by)));
            }
            terms.extend(sum.velocity.map(|k| format!("found.velocity[{k}].unwrap()")));
            if forces {
                text.push_str(&force_rows(&components));
            }
            text.push_str(&format!(
                "    [\n        {}\n    ].iter().sum::<f64>()\n    }}",
                terms.join(",\n        ")
            ));
            Ok(text)
        };
        let text =
            format!("    let got: f64 = {};\n    let want: f64 = {};\n", block(&law.got)?, block(&law.want)?);
        Ok(self.test(case, &text))
    }

    /// A test that compares `got` and `want`, which statements give.
    fn test(&self, case: &Case, statements: &str) -> String {
        format!(
            "{}{}\n#[test]\nfn counter_example() {{\n{statements}    \
             let tolerance: f64 = {};\n    \
             assert!((got - want).abs() <= tolerance, \"{{got:e}}, must be {{want:e}} within {{tolerance:e}}\");\n}}\n",
            self.heading(case),
            imports(statements),
            literal(self.tolerance.0)
        )
    }
}
