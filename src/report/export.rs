//! `pintle export`: a connection type as a program in another language.

use crate::layout::wrap;
use crate::words::{NOTATION, SIGNS};
use pintle_kinematics::catalog::{ConnectionType, SPATIAL};
use pintle_symbolic::print::{C, Jax, Language, Latex, Listing, Rust, Sympy, Text, listing, runtime};
use pintle_symbolic::{
    Frame, FrictionModel, FrictionTraceError, Function, Graph, Id, Input, Inputs, Model, Shape,
};
use std::collections::BTreeSet;

/// What to export to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// Python, SymPy expressions.
    Sympy,
    /// Python, JAX arrays.
    Jax,
    /// C99.
    C,
    /// Rust, standard library only.
    Rust,
    /// LaTeX.
    Latex,
}

/// A result of a [`Routine`].
#[derive(Clone, Debug)]
pub struct Output {
    /// The name.
    pub name: &'static str,
    /// The extents, outermost first.
    pub shape: Vec<usize>,
    /// The unit, in words.
    pub unit: &'static str,
    /// What it is.
    pub meaning: String,
    ids: Vec<Id>,
}

/// A function of the exported program.
#[derive(Clone, Debug)]
pub struct Routine<'a> {
    /// The name.
    pub name: String,
    /// Its parameters, in order.
    pub takes: Vec<&'a Input>,
    /// Its results, in order.
    pub gives: Vec<Output>,
    graph: &'a Graph,
    inputs: &'a Inputs,
}

/// A connection type, traced and differentiated, ready to be written in any language.
#[derive(Clone, Debug)]
pub struct Export {
    name: String,
    model: Model,
    frictions: Vec<FrictionModel>,
    facts: Vec<String>,
}

/// The name of a type in programs: `cartesian_cardan`.
pub fn identifier(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_ascii_lowercase).collect::<Vec<_>>().join("_")
}

impl Export {
    /// Traces a type.
    ///
    /// # Errors
    /// [`FrictionTraceError`] where a formula cannot be traced.
    pub fn of(connection: &ConnectionType, frame: Frame) -> Result<Self, FrictionTraceError> {
        let model = Model::of(connection, frame, 2)?;
        let frictions = match &connection.friction {
            Some(friction) => FrictionModel::of(friction)?,
            None => Vec::new(),
        };
        let facts = facts(connection, &model, &frictions);
        Ok(Self { name: connection.name.to_string(), model, frictions, facts })
    }

    /// The functions of the program, in order.
    pub fn routines(&self) -> Vec<Routine<'_>> {
        let Model { graph, inputs, functions, values, jacobian, hessian, frame, .. } = &self.model;
        let all: Vec<Id> =
            values.iter().chain(jacobian.iter().flatten()).chain(hessian.iter().flatten()).copied().collect();
        let takes = inputs.used(graph, &all);
        let names = |of: &[String]| of.join(", ");
        let of_values: Vec<usize> = (0..functions.len()).filter(|k| self.model.has_value(*k)).collect();
        let named = |ks: &[usize]| {
            names(&ks.iter().filter_map(|k| functions.get(*k)).map(Function::name).collect::<Vec<_>>())
        };
        let columns = frame.directions().len();
        let routine =
            |name: &str, gives| Routine { name: name.into(), graph, inputs, takes: takes.clone(), gives };
        let mut found = Vec::new();
        if !of_values.is_empty() {
            found.push(routine(
                "values",
                vec![Output {
                    name: "values",
                    shape: vec![of_values.len()],
                    unit: "length, rad or a pure number",
                    meaning: named(&of_values),
                    ids: of_values.iter().filter_map(|k| values.get(*k)).copied().collect(),
                }],
            ));
        }
        let rows: Vec<usize> = (0..functions.len()).collect();
        if rows.is_empty() {
            return found;
        }
        let by = frame.directions().join(", ");
        found.push(routine(
            "jacobian",
            vec![Output {
                name: "jacobian",
                shape: vec![rows.len(), columns],
                unit: "of the function per length or rad",
                meaning: format!("rows {}; columns {by}", named(&rows)),
                ids: jacobian.concat(),
            }],
        ));
        found.push(routine(
            "hessian",
            vec![Output {
                name: "hessian",
                shape: vec![rows.len(), columns, columns],
                unit: "of the function per length or rad, twice",
                meaning: format!("[{}] by two of the columns of the Jacobian", named(&rows)),
                ids: hessian.concat(),
            }],
        ));
        for (i, friction) in self.frictions.iter().enumerate() {
            let FrictionModel { graph, inputs, forces, names, point, gradient, hessian, .. } = friction;
            let used: Vec<Id> = point.iter().chain(gradient).chain(hessian).copied().collect();
            found.push(Routine {
                name: format!("friction_{}", i + 1),
                graph,
                inputs,
                takes: inputs.used(graph, &used),
                gives: vec![
                    Output {
                        name: "point",
                        shape: vec![4],
                        unit: "force, or moment",
                        meaning: "P, F_C, F_N, Phi".into(),
                        ids: point.to_vec(),
                    },
                    Output {
                        name: "gradient",
                        shape: vec![*forces],
                        unit: "of Phi per unit",
                        meaning: format!("of Phi by {}", names.join(", ")),
                        ids: gradient.clone(),
                    },
                    Output {
                        name: "hessian",
                        shape: vec![*forces, *forces],
                        unit: "of Phi per unit, twice",
                        meaning: "of Phi by two of them".into(),
                        ids: hessian.clone(),
                    },
                ],
            });
        }
        found
    }

    /// The program, with a header that states conventions, inputs and outputs.
    ///
    /// ```
    /// use pintle_kinematics::catalog::ConnectionType;
    /// use pintle_report::export::{Export, Target};
    /// use pintle_symbolic::Frame;
    /// let slot = Export::of(&ConnectionType::named("SLOT", None)?, Frame::Relative)?;
    /// assert!(slot.write(Target::C).contains("void pintle_slot_values(const double d[3], double values[3])"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn write(&self, target: Target) -> String {
        let language: &dyn Language = match target {
            Target::Sympy => &Sympy,
            Target::Jax => &Jax,
            Target::C => &C,
            Target::Rust => &Rust,
            Target::Latex => &Latex,
        };
        let mut called = BTreeSet::new();
        let mut bodies = Vec::new();
        for routine in self.routines() {
            let ids: Vec<Id> = routine.gives.iter().flat_map(|output| &output.ids).copied().collect();
            let written = listing(routine.graph, routine.inputs, &ids, language);
            called.extend(written.called.iter());
            bodies.push(match target {
                Target::C => c_function(&identifier(&self.name), &routine, &written),
                Target::Rust => rust_function(&routine, &written),
                Target::Jax => python_function(&routine, &written, true),
                Target::Sympy => python_function(&routine, &written, false),
                Target::Latex => latex_section(&routine, &written),
            });
        }
        let header = self.header(target);
        match target {
            Target::C => format!(
                "/*\n{}*/\n\n#include <math.h>\n\n{}\n{}",
                commented(&header, " * "),
                runtime::text(runtime::C, &called),
                bodies.join("\n")
            ),
            Target::Rust => format!(
                "{}\n{}\n{}",
                commented(&header, "// "),
                runtime::text(runtime::RUST, &called),
                bodies.join("\n")
            ),
            Target::Jax => format!(
                "\"\"\"{header}\"\"\"\n\nimport jax\nimport jax.numpy as jnp\n\njax.config.update(\"jax_enable_x64\", True)\n\n\n{}{}",
                runtime::text(runtime::JAX, &called),
                bodies.join("\n\n")
            ),
            Target::Sympy => {
                let frame = self.model.frame.name();
                format!(
                    "\"\"\"{header}\"\"\"\n\nfrom sympy import (\n    Abs, Dummy, Integer, Piecewise, Rational, acos, atan2, cos, diff, exp, \
                     factorial, floor, hyper, pi, rf, sign, sin, sqrt,\n    sympify,\n)\nfrom mpmath.libmp import prec_to_dps\n\nVERSION = \"{}\"\nTYPE = \"{}\"\nFRAME = \"{frame}\"\nFUNCTIONS = {}\nVALUES = {}\nCOLUMNS = {}\n\n\n{}{}",
                    pintle_kinematics::VERSION,
                    self.name,
                    python_list(self.model.functions.iter().map(Function::name)),
                    python_list(
                        (0..self.model.functions.len())
                            .filter(|k| self.model.has_value(*k))
                            .filter_map(|k| self.model.functions.get(k))
                            .map(Function::name)
                    ),
                    python_list(self.model.frame.directions().iter().map(ToString::to_string)),
                    runtime::text(runtime::SYMPY, &called),
                    bodies.join("\n\n")
                )
            }
            Target::Latex => format!(
                "{}\\documentclass{{article}}\n\\usepackage{{amsmath}}\n\\begin{{document}}\n{}\\end{{document}}\n",
                commented(&header, "% "),
                bodies.join("\n")
            ),
        }
    }

    /// The expression graph of the values, in the DOT language of Graphviz.
    pub fn graphviz(&self) -> String {
        let Model { graph, inputs, functions, values, .. } = &self.model;
        let named = functions.iter().zip(values).enumerate().filter(|(k, _)| self.model.has_value(*k));
        let roots: Vec<(String, Id)> = named.map(|(_, (function, id))| (function.name(), *id)).collect();
        pintle_symbolic::graphviz(graph, inputs, &roots)
    }

    fn header(&self, target: Target) -> String {
        let mut text = String::new();
        let frame = self.model.frame;
        text.push_str(&format!(
            "{}, {} variables. Written by pintle {}; do not edit.\n\n",
            self.name,
            frame.name(),
            pintle_kinematics::VERSION
        ));
        for fact in &self.facts {
            for line in textwrap(fact) {
                text.push_str(&format!("{line}\n"));
            }
        }
        for routine in self.routines() {
            text.push_str(&format!("\n{}\n", routine.name));
            for input in &routine.takes {
                let line = format!(
                    "in  {} {}, {}: {}",
                    input.name,
                    input.shape.name(),
                    input.unit.name(),
                    input.meaning
                );
                for line in textwrap(&line) {
                    text.push_str(&format!("  {line}\n"));
                }
            }
            for output in &routine.gives {
                let shape: String = output.shape.iter().map(|n| format!("[{n}]")).collect();
                let line = format!("out {} {shape}, {}: {}", output.name, output.unit, output.meaning);
                for line in textwrap(&line) {
                    text.push_str(&format!("  {line}\n"));
                }
            }
        }
        if target == Target::C {
            text.push_str("\nMatrices are arrays of nine by rows: Q[3*i + j] is Q[i][j].\n");
        }
        text
    }
}

/// Conventions, and where the formulas hold.
fn facts(connection: &ConnectionType, model: &Model, frictions: &[FrictionModel]) -> Vec<String> {
    let by = match model.frame {
        Frame::Relative => {
            "Derivatives are taken by δ and ρ, components along e1a, e2a, e3a: d(δ) = d + δ, Q(ρ) = exp(ρ^) Q, and by the flows."
        }
        Frame::Nodal => {
            "Derivatives are taken by displacements and spatial rotations of the nodes, U + δx, A → exp(δθ^) A, global components, and \
             by the flows."
        }
    };
    let mut facts = vec![
        NOTATION.to_string(),
        by.to_string(),
        "Second derivatives by rotations of one body are those of exp(θ^) at θ = 0, which are symmetric.".to_string(),
        "Angles are principal, in (−π, π]: whole turns are added by the caller. A position is not yet a displacement: subtract \
         its initial value. Where a derivative does not exist, the one of least norm is given."
            .to_string(),
    ];
    for function in &model.functions {
        let mut fact = format!("{} = {}", function.name(), function.measure.formula());
        for set in function.measure.singular_sets() {
            fact.push_str(&format!("; singular: {}", set.at));
        }
        if function.measure.is_one_form() {
            fact.push_str("; a one-form: its row is given, it has no value; the second derivatives are how its row changes");
            if model.frame == Frame::Relative {
                fact.push_str(", zero in the directions of a");
            }
        }
        facts.push(fact);
    }
    if let Some(friction) = &connection.friction {
        for (i, criterion) in friction.criteria.iter().enumerate().take(frictions.len()) {
            let law = criterion.limit_formula().map_or_else(
                || "F_N = |F_C + F_C^int|, Φ = P − μ F_N".to_string(),
                |limit| format!("F_N = F_C, Φ = P − {limit}"),
            );
            facts.push(format!(
                "friction_{}: P = {}, F_C = {}, {law}",
                i + 1,
                criterion.tangential_formula(friction, SPATIAL),
                criterion.contact_formula(friction, SPATIAL),
            ));
        }
    }
    facts.push(SIGNS.to_string());
    facts
}

fn textwrap(text: &str) -> Vec<String> {
    wrap(text, 110)
}

fn commented(text: &str, mark: &str) -> String {
    text.lines().map(|line| format!("{mark}{line}").trim_end().to_string() + "\n").collect()
}

fn python_list(names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.map(|name| format!("\"{name}\"")).collect();
    format!("[{}]", names.join(", "))
}

/// The results one by one, each with the indices of its place.
fn entries<'a>(
    routine: &'a Routine<'_>,
    written: &'a Listing,
) -> impl Iterator<Item = (&'a Output, usize, &'a Text)> {
    let places = routine.gives.iter().flat_map(|output| (0..output.ids.len()).map(move |i| (output, i)));
    places.zip(&written.results).map(|((output, i), text)| (output, i, text))
}

/// `[1][0][2]`.
fn subscript(shape: &[usize], place: usize) -> String {
    let mut left = place;
    let mut indices: Vec<String> = Vec::new();
    for extent in shape.iter().rev() {
        indices.push(format!("[{}]", left % extent));
        left /= extent;
    }
    indices.into_iter().rev().collect()
}

fn c_function(prefix: &str, routine: &Routine<'_>, written: &Listing) -> String {
    let inputs = routine.takes.iter().map(|input| match input.shape {
        Shape::Scalar => format!("double {}", input.name),
        shape => format!("const double {}[{}]", input.name, shape.len()),
    });
    let outputs = routine.gives.iter().map(|output| {
        let shape: String = output.shape.iter().map(|n| format!("[{n}]")).collect();
        format!("double {}{shape}", output.name)
    });
    let parameters: Vec<String> = inputs.chain(outputs).collect();
    let mut text = format!("void pintle_{prefix}_{}({})\n{{\n", routine.name, parameters.join(", "));
    for statement in &written.statements {
        text.push_str(&format!("    {statement}\n"));
    }
    for (output, place, result) in entries(routine, written) {
        text.push_str(&format!(
            "    {}{} = {};\n",
            output.name,
            subscript(&output.shape, place),
            result.text
        ));
    }
    for input in &routine.takes {
        text.push_str(&format!("    (void){};\n", input.name));
    }
    text.push_str("}\n");
    text
}

/// Nested brackets around results in order.
fn nested(shape: &[usize], texts: &[String], indent: usize, line_end: &str) -> String {
    let Some((extent, rest)) = shape.split_first() else { return texts.join(", ") };
    if rest.is_empty() {
        return format!("[{}]", texts.join(", "));
    }
    let size = texts.len() / (*extent).max(1);
    let margin = " ".repeat(indent + 4);
    let mut text = String::from("[\n");
    for part in texts.chunks(size.max(1)) {
        text.push_str(&format!("{margin}{}{line_end}", nested(rest, part, indent + 4, line_end)));
    }
    text.push_str(&format!("{}]", " ".repeat(indent)));
    text
}

fn results_of(output: &Output, routine: &Routine<'_>, written: &Listing) -> Vec<String> {
    entries(routine, written)
        .filter(|(of, ..)| std::ptr::eq(*of, output))
        .map(|(_, _, text)| text.text.clone())
        .collect()
}

fn rust_function(routine: &Routine<'_>, written: &Listing) -> String {
    let inputs = routine.takes.iter().map(|input| {
        let name = input.name.to_lowercase();
        match input.shape {
            Shape::Scalar => format!("{name}: f64"),
            Shape::List(n) => format!("{name}: &[f64; {n}]"),
            Shape::Matrix => format!("{name}: &[[f64; 3]; 3]"),
        }
    });
    let parameters: Vec<String> = inputs.collect();
    let types: Vec<String> = routine
        .gives
        .iter()
        .map(|output| output.shape.iter().rev().fold("f64".to_string(), |of, n| format!("[{of}; {n}]")))
        .collect();
    let result = if types.len() == 1 { types.concat() } else { format!("({})", types.join(", ")) };
    let mut text =
        format!("/// {}.\n", routine.gives.iter().map(|output| output.name).collect::<Vec<_>>().join(", "));
    text.push_str(&format!("pub fn {}({}) -> {result} {{\n", routine.name, parameters.join(", ")));
    let names: Vec<String> = routine.takes.iter().map(|input| input.name.to_lowercase()).collect();
    if !names.is_empty() {
        text.push_str(&format!("    let _ = ({},);\n", names.join(", ")));
    }
    for statement in &written.statements {
        text.push_str(&format!("    {statement}\n"));
    }
    let all: Vec<String> = routine
        .gives
        .iter()
        .map(|output| nested(&output.shape, &results_of(output, routine, written), 4, ",\n"))
        .collect();
    text.push_str(&format!(
        "    {}\n}}\n",
        if all.len() == 1 { all.concat() } else { format!("({})", all.join(", ")) }
    ));
    text
}

fn python_function(routine: &Routine<'_>, written: &Listing, arrays: bool) -> String {
    let names: Vec<&str> = routine.takes.iter().map(|input| input.name.as_str()).collect();
    let mut text = format!("def {}({}):\n", routine.name, names.join(", "));
    let what: Vec<String> =
        routine.gives.iter().map(|output| format!("{}: {}", output.name, output.meaning)).collect();
    text.push_str(&format!("    \"\"\"{}.\"\"\"\n", what.join("; ")));
    for statement in &written.statements {
        text.push_str(&format!("    {statement}\n"));
    }
    let all: Vec<String> = routine
        .gives
        .iter()
        .map(|output| {
            let nested = nested(&output.shape, &results_of(output, routine, written), 4, ",\n");
            if arrays { format!("jnp.array({nested}, dtype=jnp.float64)") } else { nested }
        })
        .collect();
    text.push_str(&format!("    return {}\n", all.join(", ")));
    text
}

fn latex_section(routine: &Routine<'_>, written: &Listing) -> String {
    let mut lines: Vec<String> = written.statements.clone();
    for (output, place, result) in entries(routine, written) {
        if result.text != "0" {
            let index = subscript(&output.shape, place).replace("][", ",").replace(['[', ']'], "");
            let index: Vec<String> = index
                .split(',')
                .map(|i| i.parse::<usize>().map_or(i.to_string(), |i| (i + 1).to_string()))
                .collect();
            lines.push(format!("\\mathrm{{{}}}_{{{}}} &= {}", output.name, index.join(","), result.text));
        }
    }
    let name = routine.name.replace('_', " ");
    let mut text = format!("\\section*{{{name}}}\n");
    for part in lines.chunks(30) {
        text.push_str(&format!("\\begin{{align*}}\n{}\n\\end{{align*}}\n", part.join("\\\\\n")));
    }
    text
}
