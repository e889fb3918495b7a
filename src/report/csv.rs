//! Evaluations as one table in long form, with a heading line.
//!
//! One line for each state × connector × component, one column for each output asked for. With derivatives there are five
//! columns more, `dof_1, node_1, dof_2, node_2, derivative`, and further lines that leave the outputs empty: one for each
//! first derivative that is not zero (`dof_2` empty) and each second derivative that is not zero, ∂²/∂dof_1∂dof_2.
//! `flags` names what needs care, on the lines of the component. Numbers read back to the same double.

use super::block::{Block, Column, Kind, Value, node_name, slopes};
use super::evaluation::{Format, Subject};
use super::words;
use crate::connector::{Flag, Output, Tally};
use std::io::{self, Write};

/// One table.
pub struct Csv<'w> {
    writer: csv::Writer<&'w mut dyn Write>,
    outputs: Vec<Output>,
    order: u8,
    scene: String,
    state: String,
    time: String,
}

impl<'w> Csv<'w> {
    /// A table on a stream, with columns for `outputs` and, from order 1 on, for derivatives.
    pub fn new(out: &'w mut dyn Write, outputs: Vec<Output>, order: u8) -> Self {
        let writer = csv::Writer::from_writer(out);
        Self { writer, outputs, order, scene: String::new(), state: String::new(), time: String::new() }
    }

    fn line(&mut self, cells: &[String]) -> io::Result<()> {
        self.writer.write_record(cells).map_err(|error| match error.into_kind() {
            csv::ErrorKind::Io(error) => error,
            other => io::Error::other(format!("{other:?}")),
        })
    }

    fn start(&self, block: &Block<'_>, component: &str, role: &str, unit: &str) -> Vec<String> {
        let kind = match block.kind {
            Kind::Connector => "connector",
            Kind::Mpc => "mpc",
        };
        let nodes: Vec<String> = block.nodes.iter().map(|(_, node)| node_name(*node)).collect();
        let flags: Vec<&str> =
            block.flags.iter().filter(|flag| flag.component() == component).map(Flag::name).collect();
        [
            &self.scene,
            &self.state,
            &self.time,
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
        .to_vec()
    }

    fn derivative(
        &mut self,
        block: &Block<'_>,
        component: &str,
        [first, second]: [Option<&Column>; 2],
        value: f64,
    ) -> io::Result<()> {
        if value == 0.0 {
            return Ok(());
        }
        let mut cells = self.start(block, component, "", "");
        cells.extend(self.outputs.iter().map(|_| String::new()));
        for column in [first, second] {
            cells.push(column.map(|column| column.name.to_string()).unwrap_or_default());
            cells.push(column.map(|column| column.node.to_string()).unwrap_or_default());
        }
        cells.push(exact(value));
        self.line(&cells)
    }
}

/// The shortest decimal that reads back to the same double.
fn exact(value: f64) -> String {
    format!("{value:?}")
}

impl Format for Csv<'_> {
    fn begin(&mut self) -> io::Result<()> {
        let mut heading: Vec<String> = [
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
        ]
        .map(String::from)
        .to_vec();
        heading.extend(self.outputs.iter().map(|output| output.name().to_string()));
        if self.order > 0 {
            heading.extend(["dof_1", "node_1", "dof_2", "node_2", "derivative"].map(String::from));
        }
        self.line(&heading)
    }

    fn scene(&mut self, subject: &Subject<'_>) -> io::Result<()> {
        self.scene.clone_from(&subject.scene.name);
        Ok(())
    }

    fn state(&mut self, index: u64, time: Option<f64>) -> io::Result<()> {
        self.state = index.to_string();
        self.time = time.map(exact).unwrap_or_default();
        Ok(())
    }

    fn block(&mut self, block: &Block<'_>) -> io::Result<()> {
        for row in &block.rows {
            let mut cells = self.start(block, row.name, row.role, words::unit(row.unit));
            for output in &self.outputs {
                cells.push(match row.values[*output as usize] {
                    None => String::new(),
                    Some(Value::Stop(status)) => status.flag().to_string(),
                    Some(value) => exact(value.number()),
                });
            }
            if self.order > 0 {
                cells.extend([const { String::new() }; 5]);
            }
            self.line(&cells)?;
        }
        for (force, motion, slope) in block.tangent.iter().flat_map(slopes) {
            let mut cells = self.start(block, force, "", "");
            cells.extend(self.outputs.iter().map(|_| String::new()));
            cells.extend([motion, "", "", ""].map(String::from));
            cells.push(exact(slope));
            self.line(&cells)?;
        }
        for row in &block.derivatives {
            for (entry, column) in row.gradient.iter().zip(&block.columns) {
                self.derivative(block, row.component, [Some(column), None], *entry)?;
            }
            for (line, first) in row.hessian.iter().flatten().zip(&block.columns) {
                for (entry, second) in line.iter().zip(&block.columns) {
                    self.derivative(block, row.component, [Some(first), Some(second)], *entry)?;
                }
            }
        }
        Ok(())
    }

    fn end_state(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn end_scene(&mut self, _work: Tally) -> io::Result<()> {
        Ok(())
    }

    fn end(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}
