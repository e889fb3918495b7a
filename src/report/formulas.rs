//! The formulas of a connection type, traced: what is computed, in the sources' symbols.

use crate::layout::{BOLD, labelled, styled};
use pintle_kinematics::catalog::{COMPONENT, ConnectionType};
use pintle_symbolic::print::{Language, Latex, Unicode, named_listing};
use pintle_symbolic::{
    Condition, Frame, FrictionModel, FrictionTraceError, Function, Graph, Id, Inputs, Model, POINT,
};
use serde::Serialize;
use std::collections::HashMap;
use std::io::{self, Write};

/// An equation.
#[derive(Clone, Debug, Serialize)]
pub struct Equation {
    /// The left side: `ur1`, `∂ur1/∂ρ1`, or a name for what occurs more than once.
    pub left: String,
    /// The right side.
    pub right: String,
}

/// Equations that belong together.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// What they say.
    pub title: String,
    /// What occurs in them more than once, in order, and then they themselves.
    pub equations: Vec<Equation>,
    /// Branch conditions and domains that the trace met.
    pub conditions: Vec<String>,
}

/// Left sides, in a notation.
#[derive(Clone, Copy)]
struct Notation {
    language: &'static dyn Language,
    is_latex: bool,
}

const UNICODE: Notation = Notation { language: &Unicode, is_latex: false };
const LATEX: Notation = Notation { language: &Latex, is_latex: true };

impl Notation {
    fn symbol(self, name: &str) -> String {
        if !self.is_latex {
            return name.to_string();
        }
        match name.strip_prefix("ur") {
            Some(i) => format!("u_{{r{i}}}"),
            None => Latex::symbol(name),
        }
    }

    fn function(self, function: &Function) -> String {
        if !self.is_latex {
            return function.name();
        }
        let constraint = if function.is_constraint { "^{\\mathrm{constraint}}" } else { "" };
        self.symbol(COMPONENT[function.component]) + constraint
    }

    /// The derivative of what is so written.
    fn derivative(self, of: &str, by: &str) -> String {
        let by = self.symbol(by);
        if self.is_latex {
            format!("\\frac{{\\partial {of}}}{{\\partial {by}}}")
        } else {
            format!("∂{of}/∂{by}")
        }
    }

    fn condition(self, condition: Condition, of: &[String]) -> String {
        let first = of.first().map_or("", String::as_str);
        let second = of.get(1).map_or("", String::as_str);
        let [not, least] = if self.is_latex { ["\\ne", "\\ge"] } else { ["≠", "≥"] };
        let math = if self.is_latex { "$" } else { "" };
        let (formula, words) = match condition {
            Condition::Branch(..) => (format!("{first} < {second}"), " decides"),
            Condition::NotZero(_) => (format!("{first} {not} 0"), ""),
            Condition::NotBothZero(..) => (format!("({second}, {first}) {not} 0"), ""),
            Condition::NotNegative(_) => (format!("{first} {least} 0"), ""),
            Condition::AboveMinusOne(_) => (format!("{first} > -1"), ""),
        };
        format!("{math}{formula}{math}{words}")
    }

    fn group(self, title: &str, graph: &Graph, inputs: &Inputs, roots: &[(String, Id)]) -> Group {
        let shown: Vec<&(String, Id)> = roots.iter().filter(|(_, id)| !graph.is(*id, 0)).collect();
        let mut ids: Vec<Id> = shown.iter().map(|(_, id)| *id).collect();
        let conditions = graph.conditions(&ids);
        let count = ids.len();
        ids.extend(conditions.iter().flat_map(|condition| condition.operands()));
        let names: HashMap<Id, String> = shown.iter().map(|(name, id)| (*id, name.clone())).collect();
        let written = named_listing(graph, inputs, &ids, &names, self.language);
        let split = if self.is_latex { " &= " } else { " = " };
        let mut equations: Vec<Equation> = written
            .statements
            .iter()
            .filter_map(|statement| statement.split_once(split))
            .map(|(left, right)| Equation { left: left.into(), right: right.into() })
            .collect();
        for ((name, _), text) in shown.iter().zip(&written.results) {
            if text.text != *name {
                equations.push(Equation { left: name.clone(), right: text.text.clone() });
            }
        }
        let mut operands = written.results.iter().skip(count).map(|text| text.text.clone());
        let conditions = conditions
            .into_iter()
            .map(|condition| {
                let of: Vec<String> = operands.by_ref().take(condition.operands().len()).collect();
                self.condition(condition, &of)
            })
            .collect();
        Group { title: title.into(), equations, conditions }
    }

    fn groups(self, connection: &ConnectionType) -> Result<Vec<Group>, FrictionTraceError> {
        let model = Model::of(connection, Frame::Relative, 1)?;
        let Model { graph, inputs, functions, values, jacobian, .. } = &model;
        let named = functions.iter().zip(values).enumerate().filter(|(k, _)| model.has_value(*k));
        let values: Vec<(String, Id)> =
            named.map(|(_, (function, id))| (self.function(function), *id)).collect();
        let mut found = Vec::new();
        if !values.is_empty() {
            found.push(self.group("Positions and constraints", graph, inputs, &values));
        }
        let mut rows: Vec<(String, Id)> = Vec::new();
        for (function, row) in functions.iter().zip(jacobian) {
            let columns = Frame::Relative.directions().iter().zip(row);
            rows.extend(columns.map(|(by, id)| (self.derivative(&self.function(function), by), *id)));
        }
        if rows.iter().any(|(_, id)| !graph.is(*id, 0)) {
            found.push(self.group("Rows of derivatives", graph, inputs, &rows));
        }
        let frictions = match &connection.friction {
            Some(friction) => FrictionModel::of(friction)?,
            None => Vec::new(),
        };
        for (i, friction) in frictions.iter().enumerate() {
            let FrictionModel { graph, inputs, point, names, gradient, .. } = friction;
            let point = POINT.iter().zip(point).map(|(name, id)| (self.symbol(name), *id));
            let phi = self.symbol("Φ");
            let gradient = names.iter().zip(gradient).map(|(by, id)| (self.derivative(&phi, by), *id));
            let criterion = if self.is_latex { "$\\Phi = P - \\mu F_N$" } else { "Φ = P − μ F_N" };
            let number = if frictions.len() > 1 { format!(", criterion {}", i + 1) } else { String::new() };
            let title = format!("Friction {criterion} and its gradient{number}");
            found.push(self.group(&title, graph, inputs, &point.chain(gradient).collect::<Vec<_>>()));
        }
        Ok(found)
    }
}

/// The formulas of a type: positions and constraints, rows by the relative variations, friction and its gradient; entries that are zero
/// are left out.
///
/// # Errors
/// [`FrictionTraceError`] where a formula cannot be traced.
pub fn groups(connection: &ConnectionType) -> Result<Vec<Group>, FrictionTraceError> {
    UNICODE.groups(connection)
}

/// What rows are taken by, and the functions that no textbook names.
pub const LEGEND: &str = "δi and ρi: translation and spatial rotation of b against a along eia, so that δQ = δρ^ Q; \
     K(c) = 2 acos(c)/√(1 − c²), K′ its derivative: the rotation vector of a unit quaternion (w, v) is K(w) v; 1/x stands for 0 at x = 0. \
     Entries that are not listed are zero.";

/// Writes formulas as text.
pub(super) fn human(groups: &[Group], out: &mut dyn Write, width: usize) -> io::Result<()> {
    writeln!(out, "\n{}", styled(BOLD, "Formulas as computed (traced)"))?;
    write!(out, "{}", labelled("", 2, 2, LEGEND, width))?;
    for Group { title, equations, conditions } in groups {
        write!(out, "{}", labelled("", 2, 2, title, width))?;
        for Equation { left, right } in equations {
            write!(out, "{}", labelled("", 4, 8, &format!("{left} = {right}"), width))?;
        }
        if !conditions.is_empty() {
            write!(out, "{}", labelled("", 4, 8, &format!("where {}", conditions.join("; ")), width))?;
        }
    }
    Ok(())
}

/// Writes the formulas of a type in LaTeX (amsmath).
///
/// # Errors
/// Those of the stream; a formula that cannot be traced is one of them.
pub fn latex(connection: &ConnectionType, out: &mut dyn Write) -> io::Result<()> {
    let groups = LATEX.groups(connection).map_err(io::Error::other)?;
    writeln!(
        out,
        "% {}: formulas as pintle {} computes them. Needs amsmath.",
        connection.name,
        pintle_kinematics::VERSION
    )?;
    writeln!(
        out,
        "% Derivatives: \\delta_i, \\rho_i are translation and spatial rotation of b against a along e_i^a."
    )?;
    for Group { title, equations, conditions } in groups {
        writeln!(out, "\n\\paragraph{{{title}}}\n\\begin{{align*}}")?;
        let lines: Vec<String> =
            equations.iter().map(|Equation { left, right }| format!("{left} &= {right}")).collect();
        writeln!(out, "{}\n\\end{{align*}}", lines.join("\\\\\n"))?;
        if !conditions.is_empty() {
            writeln!(out, "where {}.", conditions.join("; "))?;
        }
    }
    Ok(())
}
