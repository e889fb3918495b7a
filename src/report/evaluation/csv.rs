//! Evaluations as one table in long form, with a heading line.
//!
//! One line for each state × connector × component, one column for each output asked for. With derivatives there are five columns
//! more, `dof_1, node_1, dof_2, node_2, derivative`, and further lines that leave the outputs empty. There is one for each first
//! derivative that is not zero (`dof_2` empty), and for each second derivative that is not zero, ∂²/∂dof_1∂dof_2. Nodal forces
//! (column NF) have lines of their own, with `dof_1` and `node_1`. So have the entries of KG, DNF, KT, CT and KR that are not zero.
//! They are of the force on `dof_1` by `dof_2`, which for KR names a reaction. `flags` names what needs care, on the lines of the component.
//! Numbers read back to the same double.

use crate::evaluation::block::{Block, BlockKind, Derivative, NodalDerivative, Value, node_name, slopes};
use crate::evaluation::{Format, Renderer, Subject};
use crate::words;
use pintle_kinematics::connector::{Output, Tally};
use pintle_scene::Label;
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

/// Lines of the table. What many lines begin with is written once and copied.
struct Lines<'a, 'c> {
    text: &'a mut Vec<u8>,
    context: &'c Context,
    /// The cells that all lines begin with.
    head: Vec<u8>,
    /// The cells of degrees of freedom when there are none.
    no_dofs: &'static str,
}

/// A degree of freedom and its node, as two cells.
type Column = Vec<u8>;

impl<'w> Csv<'w> {
    /// A table on a stream, with columns for `outputs` and, from order 1 on or with nodal outputs, for degrees of freedom and
    /// derivatives.
    pub fn new(out: &'w mut dyn Write, outputs: Vec<Output>, order: u8) -> Self {
        let has_dofs = order > 0 || outputs.iter().any(|output| output.is_nodal());
        let [scene, state, time] = [const { String::new() }; 3];
        Self { out, context: Arc::new(Context { outputs, has_dofs, scene, state, time }) }
    }
}

/// Cells as the table has them, quoted where they must be, without the end of their line.
fn cells<'c>(cells: impl IntoIterator<Item = &'c str>) -> io::Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().buffer_capacity(256).from_writer(Vec::new());
    writer.write_record(cells).map_err(|error| match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    })?;
    let mut text = writer.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
    text.pop_if(|end| *end == b'\n');
    Ok(text)
}

impl Lines<'_, '_> {
    fn put(&mut self, text: &[u8]) {
        self.text.extend_from_slice(text);
    }

    /// A cell that is not the first of its line: the shortest decimal that reads back to the same double; a zero has no sign.
    fn number(&mut self, value: f64) {
        self.text.push(b',');
        self.text.extend_from_slice(zmij::Buffer::new().format(value + 0.0).as_bytes());
    }

    /// The rows of first and second derivatives of one component; entries that are 0 are left out.
    fn derivatives(&mut self, block: &Block<'_>, row: &Derivative, columns: &[Column]) -> io::Result<()> {
        let mut start = self.start(block, row.component, "", "")?;
        start.resize(start.len() + self.context.outputs.len(), b',');
        let mut entry = |value: f64, first: &Column, second: &[u8]| {
            if value == 0.0 {
                return Ok(());
            }
            for cells in [&start, b",".as_slice(), first, b",", second] {
                self.put(cells);
            }
            self.number(value);
            self.text.push(b'\n');
            Ok::<(), io::Error>(())
        };
        for (value, column) in row.gradient.iter().zip(columns) {
            entry(*value, column, b",")?;
        }
        for (line, first) in row.hessian.iter().flatten().zip(columns) {
            for (value, second) in line.iter().zip(columns) {
                entry(*value, first, second)?;
            }
        }
        Ok(())
    }

    /// Nodal forces, and the entries of their derivatives that are not 0.
    fn nodal(&mut self, block: &Block<'_>, columns: &[Column]) -> io::Result<()> {
        if block.nodal.forces.is_empty() && block.nodal.derivatives.is_empty() {
            return Ok(());
        }
        let start = self.start(block, "", "", "")?;
        let outputs = self.context.outputs.clone();
        let mut entry = |of: Output, value: f64, first: &Column, second: &[u8]| {
            self.put(&start);
            for output in &outputs {
                match *output == of {
                    true => self.number(value),
                    false => self.put(b","),
                }
            }
            for cells in [b",".as_slice(), first, b",", second, b",\n"] {
                self.put(cells);
            }
            Ok::<(), io::Error>(())
        };
        for force in &block.nodal.forces {
            entry(Output::NF, force.force, &cells([force.name, &node_name(force.node)])?, b",")?;
        }
        for NodalDerivative { output, by, rows } in &block.nodal.derivatives {
            let named: Vec<Column> =
                by.iter().flatten().map(|name| cells([*name, ""])).collect::<io::Result<_>>()?;
            let by = if by.is_some() { &named } else { columns };
            for (line, first) in rows.iter().zip(columns) {
                for (value, second) in line.iter().zip(by).filter(|(value, _)| **value != 0.0) {
                    entry(*output, *value, first, second)?;
                }
            }
        }
        Ok(())
    }

    /// The cells before the outputs: those that all lines of a block begin with, and those of a component.
    fn start(&self, block: &Block<'_>, component: &str, role: &str, unit: &str) -> io::Result<Vec<u8>> {
        let mut start = self.head.clone();
        write!(start, ",{component},{role},{unit},")?;
        // What is said of all components stands with the first of a block, and with its nodal lines.
        let is_first = component.is_empty() || block.rows.first().is_some_and(|row| row.name == component);
        let is_here = |of: &str| of == component || of == "all" && is_first;
        let flags = block.flags.iter().filter(|flag| is_here(flag.component()));
        for (at, flag) in flags.enumerate() {
            write!(start, "{}{}", if at > 0 { " " } else { "" }, flag.name())?;
        }
        Ok(start)
    }

    /// The cells that say what a block is of.
    fn head(context: &Context, block: &Block<'_>) -> io::Result<Vec<u8>> {
        let kind = match block.kind {
            BlockKind::Connector => "connector",
            BlockKind::Mpc => "mpc",
            BlockKind::Relation => "relation",
        };
        let nodes: Vec<String> = block.nodes.iter().map(|(_, node)| node_name(*node)).collect();
        cells([
            context.scene.as_str(),
            &context.state,
            &context.time,
            kind,
            &block.label,
            block.type_name,
            &nodes.join(" "),
        ])
    }

    /// A connector or MPC.
    fn block(&mut self, block: &Block<'_>) -> io::Result<()> {
        for row in &block.rows {
            let start = self.start(block, row.name, row.role, words::unit(row.unit))?;
            self.put(&start);
            for output in &self.context.outputs {
                match row.values[*output as usize] {
                    None => self.put(b","),
                    Some(Value::Stop(status)) => write!(self.text, ",{}", status.flag())?,
                    Some(Value::Slip(status)) => write!(self.text, ",{}", words::slip(status))?,
                    Some(value) => self.number(value.number()),
                }
            }
            self.put(self.no_dofs.as_bytes());
            self.text.push(b'\n');
        }
        for (force, motion, slope) in block.tangent.iter().flat_map(slopes) {
            let mut start = self.start(block, force, "", "")?;
            start.resize(start.len() + self.context.outputs.len(), b',');
            self.put(&start);
            write!(self.text, ",{motion},,,")?;
            self.number(slope);
            self.text.push(b'\n');
        }
        let mut columns: Vec<Column> = Vec::with_capacity(block.columns.len());
        let mut last: Option<(Label, Vec<u8>)> = None;
        for column in &block.columns {
            // Those of one node follow each other.
            let name = match last.take().filter(|(node, _)| *node == column.node) {
                Some((_, name)) => name,
                None => cells([column.node.to_string().as_str()])?,
            };
            columns.push([column.name.as_bytes(), b",", &name].concat());
            last = Some((column.node, name));
        }
        self.nodal(block, &columns)?;
        block.derivatives.iter().try_for_each(|row| self.derivatives(block, row, &columns))
    }
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
        self.out.write_all(&cells(heading)?)?;
        self.out.write_all(b"\n")
    }

    fn scene(&mut self, subject: &Subject<'_>) -> io::Result<()> {
        Arc::make_mut(&mut self.context).scene.clone_from(&subject.scene.name);
        Ok(())
    }

    fn state(&mut self, index: u64, time: Option<f64>) -> io::Result<()> {
        let context = Arc::make_mut(&mut self.context);
        context.state = index.to_string();
        context.time = time.map(|time| format!("{time:?}")).unwrap_or_default();
        Ok(())
    }

    fn renderer(&self) -> Renderer {
        let context = Arc::clone(&self.context);
        Box::new(move |block, text| {
            let no_dofs = if context.has_dofs { ",,,,," } else { "" };
            let head = Lines::head(&context, block)?;
            Lines { text, context: &context, head, no_dofs }.block(block)
        })
    }

    fn rendered(&mut self, _kind: BlockKind, text: &[u8]) -> io::Result<()> {
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
