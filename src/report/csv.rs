//! Evaluations as one table in long form, with a heading line.
//!
//! One line for each state × connector × component, one column for each output asked for. With derivatives there are five
//! columns more, `dof_1, node_1, dof_2, node_2, derivative`, and further lines that leave the outputs empty: one for each
//! first derivative that is not zero (`dof_2` empty) and each second derivative that is not zero, ∂²/∂dof_1∂dof_2.
//! Nodal forces (column NF) have lines of their own, with `dof_1` and `node_1`; so have the entries of KG, DNF, KT, CT and KR that are not
//! zero: of the force on `dof_1` by `dof_2`, which for KR names a reaction.
//! `flags` names what needs care, on the lines of the component. Numbers read back to the same double.

use super::block::{Block, Derivative, Kind, NodalDerivative, Value, node_name, slopes};
use super::evaluation::{Format, Renderer, Subject};
use super::words;
use crate::connector::{Flag, Output, Tally};
use std::io::{self, Write};
use std::sync::Arc;

/// One table.
pub struct Csv<'w> {
    out: &'w mut dyn Write,
    context: Arc<Context>,
}

/// What the lines of one state have in common.
#[derive(Clone)]
struct Context {
    outputs: Vec<Output>,
    has_dofs: bool,
    scene: String,
    state: String,
    time: String,
}

/// Lines of the table.
struct Lines<'c> {
    writer: csv::Writer<Vec<u8>>,
    context: &'c Context,
}

impl<'w> Csv<'w> {
    /// A table on a stream, with columns for `outputs` and, from order 1 on or with nodal outputs, for degrees of freedom and
    /// derivatives.
    pub fn new(out: &'w mut dyn Write, outputs: Vec<Output>, order: u8) -> Self {
        let has_dofs = order > 0 || outputs.iter().any(|output| output.is_nodal());
        let [scene, state, time] = [const { String::new() }; 3];
        Self { out, context: Arc::new(Context { outputs, has_dofs, scene, state, time }) }
    }
}

impl Context {
    /// The text of lines.
    fn text(&self, write: impl FnOnce(&mut Lines<'_>) -> io::Result<()>) -> io::Result<Vec<u8>> {
        let mut lines = Lines { writer: csv::Writer::from_writer(Vec::new()), context: self };
        write(&mut lines)?;
        lines.writer.into_inner().map_err(|error| io::Error::other(error.to_string()))
    }
}

impl Lines<'_> {
    fn line<'c>(&mut self, cells: impl IntoIterator<Item = &'c str>) -> io::Result<()> {
        let write = || {
            cells.into_iter().try_for_each(|cell| self.writer.write_field(cell))?;
            self.writer.write_record(None::<&[u8]>)
        };
        write().map_err(|error| match error.into_kind() {
            csv::ErrorKind::Io(error) => error,
            other => io::Error::other(format!("{other:?}")),
        })
    }

    /// The rows of first and second derivatives of one component; entries that are 0 are left out.
    fn derivatives(
        &mut self,
        block: &Block<'_>,
        row: &Derivative,
        columns: &[[String; 2]],
    ) -> io::Result<()> {
        let start = self.start(block, row.component, "", "");
        let without_outputs = vec![""; self.context.outputs.len()];
        let none = [const { String::new() }; 2];
        let mut entry = |value: f64, columns: [&[String; 2]; 2]| {
            if value == 0.0 {
                return Ok(());
            }
            let value = exact(value);
            let derivative = columns.into_iter().flatten().chain([&value]);
            let start = start.iter().map(String::as_str).chain(without_outputs.iter().copied());
            self.line(start.chain(derivative.map(String::as_str)))
        };
        for (value, column) in row.gradient.iter().zip(columns) {
            entry(*value, [column, &none])?;
        }
        for (line, first) in row.hessian.iter().flatten().zip(columns) {
            for (value, second) in line.iter().zip(columns) {
                entry(*value, [first, second])?;
            }
        }
        Ok(())
    }

    /// Nodal forces, and the entries of their derivatives that are not 0.
    fn nodal(&mut self, block: &Block<'_>, columns: &[[String; 2]]) -> io::Result<()> {
        let start = self.start(block, "", "", "");
        let outputs = &self.context.outputs;
        let none = [const { String::new() }; 2];
        let mut entry = |of: Output, value: f64, [first, second]: [&[String; 2]; 2]| {
            let value = exact(value);
            let cells = outputs.iter().map(|output| if *output == of { value.as_str() } else { "" });
            let dofs = first.iter().chain(second).map(String::as_str).chain([""]);
            self.line(start.iter().map(String::as_str).chain(cells).chain(dofs))
        };
        for force in &block.nodal.forces {
            let column = [force.name.to_string(), node_name(force.node)];
            entry(Output::NF, force.force, [&column, &none])?;
        }
        for NodalDerivative { output, by, rows } in &block.nodal.derivatives {
            let named: Vec<[String; 2]> =
                by.iter().flatten().map(|name| [(*name).to_string(), String::new()]).collect();
            let by = if by.is_some() { &named } else { columns };
            for (line, first) in rows.iter().zip(columns) {
                for (value, second) in line.iter().zip(by).filter(|(value, _)| **value != 0.0) {
                    entry(*output, *value, [first, second])?;
                }
            }
        }
        Ok(())
    }

    /// The cells before the outputs.
    fn start(&self, block: &Block<'_>, component: &str, role: &str, unit: &str) -> [String; 11] {
        let kind = match block.kind {
            Kind::Connector => "connector",
            Kind::Mpc => "mpc",
        };
        let nodes: Vec<String> = block.nodes.iter().map(|(_, node)| node_name(*node)).collect();
        let flags: Vec<&str> =
            block.flags.iter().filter(|flag| flag.component() == component).map(Flag::name).collect();
        [
            &self.context.scene,
            &self.context.state,
            &self.context.time,
            kind,
            &block.label,
            block.type_name,
            &nodes.join(" "),
            component,
            role,
            unit,
            &flags.join(" "),
        ]
        .map(ToString::to_string)
    }

    /// A connector or MPC.
    fn block(&mut self, block: &Block<'_>) -> io::Result<()> {
        for row in &block.rows {
            let mut cells = self.start(block, row.name, row.role, words::unit(row.unit)).to_vec();
            for output in &self.context.outputs {
                cells.push(match row.values[*output as usize] {
                    None => String::new(),
                    Some(Value::Stop(status)) => status.flag().to_string(),
                    Some(Value::Slip(status)) => words::slip(status).to_string(),
                    Some(value) => exact(value.number()),
                });
            }
            if self.context.has_dofs {
                cells.extend([const { String::new() }; 5]);
            }
            self.line(cells.iter().map(String::as_str))?;
        }
        for (force, motion, slope) in block.tangent.iter().flat_map(slopes) {
            let mut cells = self.start(block, force, "", "").to_vec();
            cells.extend(self.context.outputs.iter().map(|_| String::new()));
            cells.extend([motion, "", "", ""].map(String::from));
            cells.push(exact(slope));
            self.line(cells.iter().map(String::as_str))?;
        }
        let columns: Vec<[String; 2]> =
            block.columns.iter().map(|column| [column.name.to_string(), column.node.to_string()]).collect();
        self.nodal(block, &columns)?;
        block.derivatives.iter().try_for_each(|row| self.derivatives(block, row, &columns))
    }
}

/// The shortest decimal that reads back to the same double.
fn exact(value: f64) -> String {
    format!("{value:?}")
}

impl Format for Csv<'_> {
    fn begin(&mut self) -> io::Result<()> {
        let mut heading = vec![
            "scene",
            "state",
            "time",
            "kind",
            "label",
            "type",
            "nodes",
            "component",
            "role",
            "unit",
            "flags",
        ];
        heading.extend(self.context.outputs.iter().map(|output| output.name()));
        if self.context.has_dofs {
            heading.extend(["dof_1", "node_1", "dof_2", "node_2", "derivative"]);
        }
        let text = self.context.text(|lines| lines.line(heading))?;
        self.out.write_all(&text)
    }

    fn scene(&mut self, subject: &Subject<'_>) -> io::Result<()> {
        Arc::make_mut(&mut self.context).scene.clone_from(&subject.scene.name);
        Ok(())
    }

    fn state(&mut self, index: u64, time: Option<f64>) -> io::Result<()> {
        let context = Arc::make_mut(&mut self.context);
        context.state = index.to_string();
        context.time = time.map(exact).unwrap_or_default();
        Ok(())
    }

    fn renderer(&self) -> Renderer {
        let context = Arc::clone(&self.context);
        Box::new(move |block| context.text(|lines| lines.block(block)))
    }

    fn rendered(&mut self, _kind: Kind, text: &[u8]) -> io::Result<()> {
        self.out.write_all(text)
    }

    fn end_state(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn end_scene(&mut self, _work: Tally) -> io::Result<()> {
        Ok(())
    }

    fn end(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
