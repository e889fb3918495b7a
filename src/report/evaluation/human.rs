//! Evaluations as tables for reading.

use crate::evaluation::block::{
    Block, BlockKind, Derivative, HingeFacts, NodalDerivative, Value, node_name, slopes,
};
use crate::evaluation::flags::flags_in_words;
use crate::evaluation::number::{Aligned, number};
use crate::evaluation::{Format, Renderer, Subject, Unevaluated, unevaluated};
use crate::layout;
use crate::layout::{BOLD, CARE, DIM, PLAIN, styled};
use crate::words;
use pintle_kinematics::connector::{Output, Tally};
use pintle_kinematics::measure::Unit;
use pintle_model::evaluate::HingeMoments;
use pintle_scene::grammar::count;
use std::io::{self, Write};
use std::ops::RangeInclusive;

/// How tables look.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// The width of the page, in cells.
    pub width: usize,
    /// The number of significant digits.
    pub digits: usize,
    /// Whether details are told.
    pub verbose: bool,
}

/// Tables for reading.
pub struct Human<'w> {
    out: &'w mut dyn Write,
    style: Style,
    first: u64,
    last: u64,
    scenes: u64,
    /// The relations of this state until now.
    relations: usize,
}

/// As many relations of a state are written: one for each node of a large coupling is a flood.
const RELATIONS_TOLD: usize = 12;
/// What is smaller than this, in comparison with the largest number of its table, is shown with four digits at most: it is
/// rounding, or nearly so, and its size says all.
const NEGLIGIBLE: f64 = 1e-10;
/// As many nodes of a constraint as its title tells.
const NODES_TOLD: usize = 8;
/// Blanks between columns.
const GAP: usize = 2;
/// Blanks before rows.
const INDENT: usize = 2;
/// The columns that name a component: name, role, unit.
const NAMES: usize = 26;

impl<'w> Human<'w> {
    /// Tables on a stream.
    pub fn new(out: &'w mut dyn Write, style: Style) -> Self {
        Self { out, style, first: 0, last: 0, scenes: 0, relations: 0 }
    }

    fn number(&self, value: f64) -> String {
        number(value, self.style.digits)
    }

    /// A number beside others of size `largest`: where it needs an exponent and is next to nothing in comparison, four digits
    /// are enough.
    fn beside(&self, value: f64, largest: f64) -> String {
        let is_rounding = value.abs() < 1e-4 && value.abs() < NEGLIGIBLE * largest;
        number(value, if is_rounding { self.style.digits.min(4) } else { self.style.digits })
    }

    /// Columns side by side behind a label, as many as fit, the rest below in the same way.
    fn columns(
        &mut self,
        title: &str,
        labels: &[String],
        columns: &[(String, Vec<String>)],
    ) -> io::Result<()> {
        let names = labels.iter().map(|label| layout::width(label)).max().unwrap_or(0) + INDENT;
        let names = names.max(layout::width(title));
        let layouts: Vec<Aligned> =
            columns.iter().map(|(heading, texts)| Aligned::new(heading, texts.iter())).collect();
        let mut first = 0;
        while first < columns.len() {
            let mut used = names;
            let mut end = first;
            while end < columns.len() && (end == first || used + GAP + layouts[end].cells <= self.style.width)
            {
                used += GAP + layouts[end].cells;
                end += 1;
            }
            let mut heading = String::new();
            for (column, layout) in columns[first..end].iter().zip(&layouts[first..end]) {
                heading.push_str(&" ".repeat(GAP));
                heading.push_str(&layout.heading(&column.0));
            }
            let title = if first == 0 { title } else { "" };
            let blanks = " ".repeat(names - layout::width(title));
            writeln!(self.out, "{}{blanks}{}", styled(BOLD, title), styled(DIM, heading.trim_end()))?;
            for (i, label) in labels.iter().enumerate() {
                let is_blank = columns[first..end].iter().all(|column| column.1[i].is_empty());
                if is_blank && columns.len() > 1 && first > 0 {
                    continue;
                }
                let mut line = " ".repeat(INDENT);
                layout::push_left(&mut line, label, names.saturating_sub(INDENT));
                for (column, layout) in columns[first..end].iter().zip(&layouts[first..end]) {
                    layout::push_blanks(&mut line, GAP);
                    layout.push_cell(&mut line, &column.1[i]);
                }
                writeln!(self.out, "{}", line.trim_end())?;
            }
            first = end;
        }
        Ok(())
    }

    fn values(&mut self, block: &Block<'_>) -> io::Result<()> {
        let nodes: Vec<String> = block.nodes.iter().map(|(_, node)| node_name(*node)).collect();
        let title = match block.kind {
            BlockKind::Connector => format!("{}  {}", block.title(), nodes.join(" → ")),
            BlockKind::Mpc | BlockKind::Relation => {
                let told = block.nodes.iter().take(NODES_TOLD);
                let mut nodes: Vec<String> =
                    told.map(|(role, node)| format!("{role} {}", node_name(*node))).collect();
                if block.nodes.len() > NODES_TOLD {
                    nodes.push(format!("{} more", block.nodes.len() - NODES_TOLD));
                }
                format!("{}  {}", block.title(), nodes.join(", "))
            }
        };
        if block.rows.is_empty() {
            return writeln!(self.out, "{}", styled(BOLD, title));
        }
        let labels: Vec<String> = block
            .rows
            .iter()
            .map(|row| {
                let unit = words::unit(row.unit);
                format!("{}{}{unit}", layout::left(row.name, 5), layout::left(row.role, 13))
            })
            .map(|label| layout::left(&label, NAMES - INDENT))
            .collect();
        let largest = largest(block.rows.iter().flat_map(|row| row.values).flatten().map(Value::number));
        let columns: Vec<(String, Vec<String>)> = block
            .outputs()
            .into_iter()
            .map(|output| {
                let cell = |value: Option<Value>| match value {
                    None => String::new(),
                    Some(Value::Stop(status)) => status.flag().to_string(),
                    Some(Value::Slip(status)) => words::slip(status).to_string(),
                    Some(value) => self.beside(value.number(), largest),
                };
                let texts = block.rows.iter().map(|row| cell(row.values[output as usize])).collect();
                (heading(output).to_string(), texts)
            })
            .collect();
        self.columns(&title, &labels, &columns)
    }

    fn jacobian(&mut self, block: &Block<'_>) -> io::Result<()> {
        if block.derivatives.is_empty() {
            return Ok(());
        }
        let shown: Vec<usize> = (0..block.columns.len())
            .filter(|j| block.derivatives.iter().any(|row| row.gradient[*j] != 0.0))
            .collect();
        let labels: Vec<String> =
            block.derivatives.iter().map(|row| format!("∂{}/", row.component)).collect();
        if shown.is_empty() {
            return writeln!(self.out, "  Jacobian: every entry is 0");
        }
        let largest = largest(block.derivatives.iter().flat_map(|row| row.gradient.iter().copied()));
        for group in shown.chunk_by(|i, j| block.columns[*i].node == block.columns[*j].node) {
            let Some(first) = group.first().map(|j| &block.columns[*j]) else { continue };
            let title = format!("  node {} ({})", first.node, first.role);
            let columns: Vec<(String, Vec<String>)> = group
                .iter()
                .map(|j| {
                    let entry = |row: &Derivative| match row.gradient[*j] {
                        0.0 => "·".to_string(),
                        entry => self.beside(entry, largest),
                    };
                    (format!("∂{}", block.columns[*j].name), block.derivatives.iter().map(entry).collect())
                })
                .collect();
            self.columns(&title, &labels, &columns)?;
        }
        let printed: Vec<String> = block
            .derivatives
            .iter()
            .filter_map(|row| row.printed.map(|formula| format!("{}: {formula}", row.component)))
            .collect();
        if !printed.is_empty() {
            let text = format!("rows of the constraint function, {}", printed.join("; "));
            layout::paragraph(&mut *self.out, DIM, INDENT, &text, self.style.width)?;
        }
        Ok(())
    }

    /// Nodal forces by node, and the entries of their derivatives.
    fn nodal(&mut self, block: &Block<'_>) -> io::Result<()> {
        let forces = &block.nodal.forces;
        let largest_force = largest(forces.iter().map(|force| force.force));
        for group in forces.chunk_by(|one, other| one.role == other.role) {
            let Some(first) = group.first() else { continue };
            let title = match first.node {
                Some(node) => format!("  node {node} ({})", first.role),
                None => format!("  ground ({})", first.role),
            };
            let columns: Vec<(String, Vec<String>)> = group
                .iter()
                .map(|force| (force.name.to_string(), vec![self.beside(force.force, largest_force)]))
                .collect();
            self.columns(&title, &["nodal force".to_string()], &columns)?;
        }
        let names: Vec<String> = block.columns.iter().map(|column| column.name.to_string()).collect();
        for NodalDerivative { output, by, rows: matrix } in &block.nodal.derivatives {
            let largest = largest(matrix.iter().flatten().copied());
            let by: Vec<&str> = match by {
                Some(by) => by.clone(),
                None => names.iter().map(String::as_str).collect(),
            };
            let columns: Vec<(String, Vec<String>)> = (0..by.len())
                .filter(|j| matrix.iter().any(|row| row[*j] != 0.0))
                .map(|j| {
                    let entry = |row: &Vec<f64>| match row[j] {
                        0.0 => "·".to_string(),
                        entry => self.beside(entry, largest),
                    };
                    (format!("∂{}", by[j]), matrix.iter().map(entry).collect())
                })
                .collect();
            if columns.is_empty() {
                writeln!(self.out, "  {}: every entry is 0", output.name())?;
            } else {
                self.columns(&format!("  {}", output.name()), &names, &columns)?;
            }
        }
        Ok(())
    }

    fn hessian(&mut self, block: &Block<'_>) -> io::Result<()> {
        let mut entries = Vec::new();
        let all = block.derivatives.iter().flat_map(|row| row.hessian.iter().flatten().flatten());
        let largest = largest(all.copied());
        for row in &block.derivatives {
            let Some(hessian) = &row.hessian else { continue };
            for (i, line) in hessian.iter().enumerate() {
                for (j, entry) in line.iter().enumerate() {
                    if *entry == 0.0 || (j < i && hessian[j][i] == *entry) {
                        continue;
                    }
                    let text = self.beside(*entry, largest);
                    let mirrored = j < i && self.beside(hessian[j][i], largest) == text;
                    if !mirrored {
                        let (first, second) = (block.columns[i].name, block.columns[j].name);
                        entries.push((format!("∂²{}/∂{first}∂{second}", row.component), text));
                    }
                }
            }
        }
        if block.derivatives.iter().all(|row| row.hessian.is_none()) {
            return Ok(());
        }
        if entries.is_empty() {
            return writeln!(self.out, "  second derivatives: every entry is 0");
        }
        writeln!(
            self.out,
            "  {}",
            styled(DIM, "second derivatives that are not 0; equal ones across the diagonal once")
        )?;
        let names = entries.iter().map(|(name, _)| layout::width(name)).max().unwrap_or(0);
        let aligned = Aligned::new("", entries.iter().map(|(_, text)| text));
        let each = names + 1 + aligned.cells + GAP;
        let per_line = ((self.style.width.saturating_sub(INDENT)) / each).max(1);
        for chunk in entries.chunks(per_line) {
            let mut line = String::new();
            for (name, text) in chunk {
                layout::push_blanks(&mut line, GAP);
                layout::push_left(&mut line, name, names + 1);
                aligned.push_cell(&mut line, text);
            }
            writeln!(self.out, "{}", line.trim_end())?;
        }
        Ok(())
    }

    /// Slopes of forces that are not zero.
    fn tangent(&mut self, block: &Block<'_>) -> io::Result<()> {
        let Some(tangent) = &block.tangent else { return Ok(()) };
        let slopes: Vec<(String, f64)> = slopes(tangent)
            .into_iter()
            .map(|(force, motion, slope)| (format!("∂{force}/∂{motion}"), slope))
            .collect();
        if slopes.is_empty() {
            return writeln!(self.out, "  slopes of forces: every entry is 0");
        }
        writeln!(self.out, "  {}", styled(DIM, "slopes of component forces that are not 0"))?;
        let largest = largest(slopes.iter().map(|(_, slope)| *slope));
        let names = slopes.iter().map(|(name, _)| layout::width(name)).max().unwrap_or(0);
        for (name, slope) in &slopes {
            writeln!(self.out, "  {} {}", layout::left(name, names), self.beside(*slope, largest))?;
        }
        Ok(())
    }

    fn notes(&mut self, notes: &[Unevaluated]) -> io::Result<()> {
        if notes.is_empty() {
            return Ok(());
        }
        let list: Vec<String> = notes
            .iter()
            .map(|Unevaluated { count, what, names, .. }| match names.as_slice() {
                [] => format!("{count} {what}"),
                names => format!("{count} {what} ({})", names.join(", ")),
            })
            .collect();
        let text = format!("read, not evaluated: {}", list.join(", "));
        layout::paragraph(&mut *self.out, DIM, INDENT, &text, self.style.width)?;
        if self.style.verbose {
            for note in notes.iter().filter(|note| !note.details.is_empty()) {
                let text = format!("{}: {}", note.what, note.details.join("; "));
                layout::paragraph(&mut *self.out, DIM, 2 * INDENT, &text, self.style.width)?;
            }
        }
        Ok(())
    }
}

/// The largest magnitude.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest, value| value.abs().max(largest))
}

/// The heading of an output's column.
const fn heading(output: Output) -> &'static str {
    match output {
        Output::CV => "CV [/time]",
        Output::CA => "CA [/time²]",
        Output::RESV => "RESV [/time]",
        Output::RESB => "RESB [/time²]",
        Output::RESA => "RESA [/time²]",
        other => other.name(),
    }
}

/// Which states are shown, where not all are.
fn shown(subject: &Subject<'_>) -> String {
    if subject.shown.contains(&(subject.first..=subject.last)) {
        return String::new();
    }
    let range = |range: &RangeInclusive<u64>| {
        if range.start() == range.end() {
            range.start().to_string()
        } else {
            format!("{}-{}", range.start(), range.end())
        }
    };
    let list: Vec<String> = subject.shown.iter().map(range).collect();
    format!(" (shown: {}; --show all shows every one)", list.join(", "))
}

impl Human<'_> {
    /// A connector or MPC.
    fn write(&mut self, block: &Block<'_>) -> io::Result<()> {
        if block.is_empty() {
            return Ok(());
        }
        self.values(block)?;
        if let Some(facts) = &block.mpc {
            let mut texts: Vec<String> = facts
                .hinges
                .iter()
                .map(|HingeFacts { name, given, axis, .. }| {
                    let given = given.map(|given| format!("{name} given as {}; ", self.number(given)));
                    let whose =
                        if facts.hinges.len() > 1 { format!("axis of {name}") } else { "axis".into() };
                    let axis = axis.map(|entry| self.number(entry)).join(", ");
                    format!("{}{whose} ({axis})", given.unwrap_or_default())
                })
                .collect();
            for HingeFacts { name, moments, constraint, .. } in &facts.hinges {
                if let Some(moment) = constraint {
                    texts.push(format!("moment of the constraint on {name}: {}", self.number(*moment)));
                }
                match moments {
                    Some(Ok(HingeMoments { spring, stiffness, energy, dashpot, damping, .. })) => {
                        let number = |value: &f64| self.number(*value);
                        let (spring, stiffness, energy) = (number(spring), number(stiffness), number(energy));
                        texts.push(format!(
                            "spring on {name}: moment {spring}, stiffness {stiffness}, energy {energy}"
                        ));
                        if let (Some(moment), Some(damping)) = (dashpot, damping) {
                            let (moment, damping) = (number(moment), number(damping));
                            texts.push(format!("dashpot on {name}: moment {moment}, damping {damping}"));
                        }
                    }
                    Some(Err(unknown)) => {
                        texts.push(format!(
                            "the moments of springs and dashpots on {name} are not known: {}",
                            unknown.in_words()
                        ));
                    }
                    None => {}
                }
            }
            if let Some(misalignment) = facts.misalignment {
                let what = if facts.hinges.len() > 1 {
                    "the angle between the axes is off by"
                } else {
                    "axes of S and M differ by"
                };
                texts.push(format!("{what} {} rad", self.number(misalignment)));
            }
            layout::paragraph(&mut *self.out, DIM, INDENT, &texts.join("; "), self.style.width)?;
        }
        let margins = block.rows.iter().filter_map(|row| match row.values[Output::MARGIN as usize] {
            Some(Value::Margin(margin)) => Some((row.name, margin)),
            _ => None,
        });
        for (name, margin) in margins {
            let unit = if margin.set.unit == Unit::None { "" } else { words::unit(margin.set.unit) };
            let text =
                format!("margin of {name}: {} {unit} to {}", self.number(margin.distance), margin.set.at);
            writeln!(self.out, "  {}", styled(DIM, text))?;
        }
        self.nodal(block)?;
        self.jacobian(block)?;
        self.hessian(block)?;
        self.tangent(block)?;
        for text in flags_in_words(&block.flags) {
            layout::paragraph(&mut *self.out, CARE, INDENT, &format!("! {text}"), self.style.width)?;
        }
        Ok(())
    }
}

impl Format for Human<'_> {
    fn begin(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn scene(&mut self, subject: &Subject<'_>) -> io::Result<()> {
        if self.scenes > 0 {
            writeln!(self.out)?;
        }
        self.scenes += 1;
        (self.first, self.last) = (subject.first, subject.last);
        let scene = subject.scene;
        writeln!(self.out, "{}", styled(BOLD, &scene.name))?;
        for line in scene.heading.lines().map(str::trim).filter(|line| !line.is_empty()) {
            layout::paragraph(&mut *self.out, PLAIN, INDENT, line, self.style.width)?;
        }
        let plan = subject.plan;
        let mut counts = vec![count(plan.connectors.len(), "connector")];
        if !plan.mpcs.is_empty() {
            counts.push(count(plan.mpcs.len(), "MPC"));
        }
        if !plan.relations.is_empty() {
            counts.push(count(plan.relations.len(), "relation"));
        }
        counts.push(count(subject.states, "state") + &shown(subject));
        let text = format!("{}; lengths in the unit of the deck, angles in rad", counts.join(", "));
        layout::paragraph(&mut *self.out, PLAIN, INDENT, &text, self.style.width)?;
        self.notes(&unevaluated(scene, subject.model))
    }

    fn state(&mut self, index: u64, time: Option<f64>) -> io::Result<()> {
        let time = time.map(|time| format!(", t = {}", self.number(time))).unwrap_or_default();
        let (first, last) = (self.first, self.last);
        self.relations = 0;
        writeln!(self.out, "\n{}", styled(BOLD, format!("── state {index} of {first} … {last}{time} ──")))
    }

    fn renderer(&self) -> Renderer {
        let style = self.style;
        Box::new(move |block, text| Human::new(text, style).write(block))
    }

    fn rendered(&mut self, kind: BlockKind, text: &[u8]) -> io::Result<()> {
        if kind == BlockKind::Relation {
            self.relations += 1;
            if self.relations > RELATIONS_TOLD {
                return Ok(());
            }
        }
        self.out.write_all(text)
    }

    fn end_state(&mut self) -> io::Result<()> {
        match self.relations.saturating_sub(RELATIONS_TOLD) {
            0 => Ok(()),
            more => writeln!(
                self.out,
                "{}",
                styled(DIM, format!("{more} more relations: --format csv or json writes every one"))
            ),
        }
    }

    fn end_scene(&mut self, work: Tally) -> io::Result<()> {
        if self.style.verbose {
            let Tally { values, gradients, hessians, rates, histories, margins, rotations, behaviors } = work;
            let text = format!(
                "\n  computed: {values} values, {gradients} gradients, {hessians} Hessians, {rates} pairs of rates, \
                 {histories} histories, {margins} margins, {behaviors} behaviours, {rotations} rotations of nodes"
            );
            writeln!(self.out, "{}", styled(DIM, text))?;
        }
        Ok(())
    }

    fn end(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
