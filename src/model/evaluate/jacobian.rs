//! The constraint Jacobian of a whole model as one sparse matrix.
//!
//! One row for each equation that connectors and multi-point constraints enforce, one column for each degree of freedom that they have
//! and nothing fixes. The pattern is found once; at each state the entries are written straight into their places from compact rows
//! ([`pintle_kinematics::connector::CompactRow`]), which as many threads as there are compute.
//!
//! Rows come in the order of the plan: connectors, u1 to ur3 of each, then MPCs, then relations. Columns are numbered by node, 1 to 6 and 10 of each,
//! in the order of the labels of the nodes. Rotations vary spatially, C → exp(δθ^) C. Columns of a node under `*TRANSFORM` are along
//! its axes, as its boundary conditions are.

use crate::evaluate::fixed::{Fixed, Freedom, NUMBERS};
use crate::evaluate::model::{ConnectorElement, Model};
use crate::evaluate::mpc::MpcElement;
use crate::evaluate::places::Places;
use crate::evaluate::plan::Plan;
use crate::evaluate::relation::RelationElement;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{CompactRow, Components, Group, Mask};
use pintle_kinematics::mpc;
use pintle_kinematics::mpc::MpcType;
use pintle_kinematics::node::{DOF_NUMBER, DOFS};
use pintle_kinematics::relation;
use pintle_kinematics::vector::{Matrix, Vector, dot};
use pintle_scene::{Label, LabelMap};
use std::ops::Range;
use std::sync::Arc;

/// What an equation belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Source {
    /// A connector, by its index in the model.
    Connector(usize),
    /// A multi-point constraint, by its index in the model.
    Mpc(usize),
    /// A relation, by its index in the model.
    Relation(usize),
}

/// A row: an equation that is enforced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Equation {
    /// What enforces it.
    pub source: Source,
    /// The component of a connector, 0 for u1 to 5 for ur3; the equation of an MPC, in the order of [`MpcType::row_name`];
    /// that of a relation, in the order of its rows.
    pub component: usize,
}

impl Equation {
    /// What it enforces and which of it, as reports call it: `HINGE 101 ur2`, `MPC LINK 4-7 δl`. For a model that has it.
    pub fn title(&self, model: &Model) -> String {
        let named = |title: Option<String>, name: &str| format!("{} {name}", title.unwrap_or_default());
        match self.source {
            Source::Connector(index) => {
                let title = model.connectors.get(index).map(ConnectorElement::title);
                named(title, COMPONENT.get(self.component).copied().unwrap_or_default())
            }
            Source::Mpc(index) => {
                let mpc = model.mpcs.get(index);
                let name = mpc.map(|mpc| mpc.constraint.kind().row_name(self.component));
                named(mpc.map(MpcElement::title), name.unwrap_or_default())
            }
            Source::Relation(index) => {
                let element = model.relations.get(index);
                let rows = element.map(|element| element.relation.rows()).unwrap_or_default();
                let name = rows.get(self.component).map_or("", |(name, _)| *name);
                named(element.map(RelationElement::title), name)
            }
        }
    }
}

/// A pattern that a sequence cannot fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ForeignPattern {
    /// It was made for another plan.
    #[error(
        "the pattern of the Jacobian was made for another plan: make it from the model and plan of the sequence"
    )]
    Plan,
    /// It has a row that depends on the history of a component, and the states so far have been passed without following that.
    #[error(
        "the pattern of the Jacobian has rows that depend on the history of components that the plan does not name: \
         name them in its request, or call `Sequence::follow_everything` before the first state"
    )]
    History,
}

/// Where the entries of one connector go.
#[derive(Clone, Debug)]
struct Block {
    /// The degrees of freedom of each row that have a column: bit j is that of [`pintle_kinematics::node::DOF`].
    columns: [u16; 6],
    /// Whether the columns of b come before those of a.
    is_swapped: bool,
    /// Which of the axes those of a and b are.
    axes: [Option<u32>; 2],
    /// The first of its entries.
    first: usize,
}

/// Where the entries of one MPC go.
#[derive(Clone, Debug)]
struct MpcBlock {
    /// Its entries among those of all MPCs.
    entries: Range<usize>,
    /// The axes of its nodes.
    axes: [Option<u32>; mpc::NODES],
}

/// Where an entry of a row of a relation comes from.
#[derive(Clone, Copy, Debug)]
enum Taken {
    /// A column of the relation.
    Column(usize),
    /// A component, along axes by their number, of those three columns that there are.
    Along { axes: u32, columns: [Option<usize>; 3], component: usize },
}

/// Where the entries of one relation go.
#[derive(Clone, Debug)]
struct RelationBlock {
    /// What each of its rows is made of.
    taken: Vec<Taken>,
    /// The first of its entries.
    first: usize,
}

/// The pattern of a sparse Jacobian in compressed rows (CSR), and how to fill it: [`crate::evaluate::Sequence::assemble`].
///
/// ```
/// use pintle_kinematics::connector::Request;
/// use pintle_model::evaluate::{Fixed, Jacobian, Model, Plan, Selection, Sequence};
/// use pintle_scene::{Scene, State};
///
/// let deck = "*NODE\n1, 0., 0., 0.\n2, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
///             *CONNECTOR SECTION, ELSET=C\nLINK,\n*BOUNDARY\n1, 1, 3\n";
/// let scene = Scene::parse("link.inp", deck)?;
/// let model = Model::compile(&scene)?;
/// let plan = Plan::compile(&model, &Selection::All, Request::nothing(0))?;
/// let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::of(&scene)?);
/// let (mut sequence, mut values) = (Sequence::new(&model, &plan), Vec::new());
/// let care = sequence.assemble(&State::default(), &jacobian, &mut values)?;
/// // One equation, |x_b − x_a| = l; node 1 is fixed, and only the displacements of node 2 are left.
/// assert_eq!((jacobian.rows(), jacobian.columns()), (1, 3));
/// assert_eq!((jacobian.row(0), values.as_slice()), (&[0, 1, 2][..], &[1.0, 0.0, 0.0][..]));
/// assert!(care.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Jacobian {
    freedoms: Vec<Freedom>,
    equations: Vec<Equation>,
    offsets: Vec<usize>,
    columns: Vec<u32>,
    blocks: Vec<Block>,
    mpcs: Vec<MpcBlock>,
    /// For each entry of an MPC the equation, and the degree of freedom by which it is.
    mpc_entries: Vec<(u8, u8)>,
    /// The first entry of an MPC.
    first_mpc: usize,
    relations: Vec<RelationBlock>,
    axes: Vec<Matrix<f64>>,
    /// The plan that it belongs to.
    plan: [Vec<usize>; 3],
    /// What columns made of this pattern know it by.
    origin: Arc<()>,
}

/// The columns of nodes: the first of each, and which of [`NUMBERS`] it has.
struct Numbering<'a> {
    places: Places<'a>,
    first: Vec<u32>,
    has: Vec<u8>,
}

impl Numbering<'_> {
    /// The column of a degree of freedom, by the place of its node and its own in [`NUMBERS`].
    fn column(&self, place: usize, number: usize) -> Option<u32> {
        let (has, bit) = (self.has[place], 1_u8 << number);
        (has & bit != 0).then(|| self.first[place] + (has & (bit - 1)).count_ones())
    }
}

/// The place in [`NUMBERS`] of a degree of freedom.
fn place_of(number: u8) -> Option<usize> {
    NUMBERS.iter().position(|known| *known == number)
}

impl Jacobian {
    /// The pattern of what is enforced: the constrained components of the connectors of a plan, and the equations of its constraints.
    ///
    /// Rows follow from the connection types. What behaviour does to them, such as a stop that is reached, a lock, or a failure that
    /// releases a component, is not in the pattern.
    pub fn of_constraints(model: &Model, plan: &Plan, fixed: &Fixed) -> Self {
        Self::new(model, plan, fixed, |element, k| element.connector.is_constrained(k))
    }

    /// The pattern of the rows that are `wanted` of connectors, by component (0-based), and of all equations of MPCs. Rows are those of
    /// [`pintle_kinematics::connector::Evaluation::jacobian`]: of the residual of a constrained component, of the displacement of any other.
    pub fn new(
        model: &Model,
        plan: &Plan,
        fixed: &Fixed,
        wanted: impl Fn(&ConnectorElement, usize) -> bool,
    ) -> Self {
        let nodes: Vec<Label> = plan.nodes.iter().copied().collect();
        let numbering = number(&nodes, model, plan, fixed);
        let mut jacobian = Self {
            freedoms: Vec::new(),
            equations: Vec::new(),
            offsets: vec![0],
            columns: Vec::new(),
            blocks: Vec::with_capacity(plan.connectors.len()),
            mpcs: Vec::with_capacity(plan.mpcs.len()),
            mpc_entries: Vec::new(),
            first_mpc: 0,
            relations: Vec::with_capacity(plan.relations.len()),
            axes: Vec::new(),
            plan: [plan.connectors.clone(), plan.mpcs.clone(), plan.relations.clone()],
            origin: Arc::default(),
        };
        for (node, has) in nodes.iter().zip(&numbering.has) {
            let numbers = NUMBERS.iter().enumerate().filter(|(place, _)| has & (1 << place) != 0);
            jacobian.freedoms.extend(numbers.map(|(_, number)| Freedom { node: *node, number: *number }));
        }
        let mut known = LabelMap::default();
        for index in &plan.connectors {
            jacobian.add_connector(
                *index,
                &model.connectors[*index],
                (&numbering, fixed),
                &wanted,
                &mut known,
            );
        }
        jacobian.first_mpc = jacobian.columns.len();
        for index in &plan.mpcs {
            jacobian.add_mpc(*index, &model.mpcs[*index], (&numbering, fixed), &mut known);
        }
        for index in &plan.relations {
            jacobian.add_relation(*index, &model.relations[*index], (&numbering, fixed), &mut known);
        }
        jacobian
    }

    /// The axes of a node, by number.
    fn axes_of(&mut self, node: Option<Label>, fixed: &Fixed, known: &mut LabelMap<u32>) -> Option<u32> {
        let node = node?;
        let axes = fixed.axes(node)?;
        if let Some(known) = known.get(&node) {
            return Some(*known);
        }
        let number = u32::try_from(self.axes.len()).ok()?;
        self.axes.push(*axes);
        known.insert(node, number);
        Some(number)
    }

    fn add_connector(
        &mut self,
        index: usize,
        element: &ConnectorElement,
        (numbering, fixed): (&Numbering, &Fixed),
        wanted: impl Fn(&ConnectorElement, usize) -> bool,
        known: &mut LabelMap<u32>,
    ) {
        let axes = element.nodes.map(|node| self.axes_of(node, fixed, known));
        let places = element.nodes.map(|node| numbering.places.of(node?));
        let column = |j: usize| {
            let number = place_of(DOF_NUMBER[j])?;
            numbering.column(places[usize::from(j >= DOFS / 2)]?, number)
        };
        let is_swapped = element.nodes[0] > element.nodes[1];
        let mut block = Block { columns: [0; 6], is_swapped, axes, first: self.columns.len() };
        for k in 0..6 {
            let Some(pattern) = element.connector.row_pattern(k).filter(|_| wanted(element, k)) else {
                continue;
            };
            let pattern = along_axes(pattern, axes.map(|axes| axes.is_some()));
            for j in order(is_swapped).filter(|j| pattern[*j]) {
                if let Some(column) = column(j) {
                    block.columns[k] |= 1 << j;
                    self.columns.push(column);
                }
            }
            self.equations.push(Equation { source: Source::Connector(index), component: k });
            self.offsets.push(self.columns.len());
        }
        self.blocks.push(block);
    }

    fn add_mpc(
        &mut self,
        index: usize,
        element: &MpcElement,
        (numbering, fixed): (&Numbering, &Fixed),
        known: &mut LabelMap<u32>,
    ) {
        let mut axes = [None; mpc::NODES];
        for (axes, node) in axes.iter_mut().zip(&element.nodes) {
            *axes = self.axes_of(Some(*node), fixed, known);
        }
        let from = self.mpc_entries.len();
        let has = element.constraint.columns();
        let column = |j: usize| {
            let (place, number) = MpcType::column_dof(j);
            numbering.column(numbering.places.of(*element.nodes.get(place)?)?, place_of(number)?)
        };
        // Degrees of freedom in the order of their columns; those without one are last.
        let mut order: [(u32, u8); mpc::DOFS] = std::array::from_fn(|j| {
            let column = Some(j).filter(|j| has[*j]).and_then(column);
            (column.unwrap_or(u32::MAX), j as u8)
        });
        order.sort_unstable();
        for (row, _) in element.constraint.rows().iter().enumerate().filter(|(_, is)| **is) {
            for (column, j) in order.iter().take_while(|(column, _)| *column < u32::MAX) {
                self.mpc_entries.push((row as u8, *j));
                self.columns.push(*column);
            }
            self.equations.push(Equation { source: Source::Mpc(index), component: row });
            self.offsets.push(self.columns.len());
        }
        self.mpcs.push(MpcBlock { entries: from..self.mpc_entries.len(), axes });
    }

    fn add_relation(
        &mut self,
        index: usize,
        element: &RelationElement,
        (numbering, fixed): (&Numbering, &Fixed),
        known: &mut LabelMap<u32>,
    ) {
        let axes: Vec<Option<u32>> =
            element.nodes.iter().map(|node| self.axes_of(Some(*node), fixed, known)).collect();
        let places: Vec<Option<usize>> =
            element.nodes.iter().map(|node| numbering.places.of(*node)).collect();
        let own = element.relation.columns();
        let at = |place: usize, number: u8| own.binary_search(&(place, number)).ok();
        let mut taken = Vec::new();
        for (place, number) in element.relation.own_columns(|place| axes[place].is_some()) {
            let column = places[place].and_then(|of| numbering.column(of, place_of(number)?));
            let Some(column) = column else { continue };
            let from = match axes[place].filter(|_| number <= 6) {
                Some(axes) => {
                    let component = (usize::from(number) - 1) % 3;
                    let first = number - component as u8;
                    let columns = [0, 1, 2].map(|i| at(place, first + i));
                    Some(Taken::Along { axes, columns, component })
                }
                None => at(place, number).map(Taken::Column),
            };
            taken.extend(from.map(|from| (column, from)));
        }
        taken.sort_unstable_by_key(|(column, _)| *column);
        let first = self.columns.len();
        for component in 0..element.relation.rows().len() {
            self.columns.extend(taken.iter().map(|(column, _)| *column));
            self.equations.push(Equation { source: Source::Relation(index), component });
            self.offsets.push(self.columns.len());
        }
        let taken = taken.into_iter().map(|(_, from)| from).collect();
        self.relations.push(RelationBlock { taken, first });
    }

    /// The number of equations.
    pub const fn rows(&self) -> usize {
        self.equations.len()
    }

    /// The number of degrees of freedom.
    pub const fn columns(&self) -> usize {
        self.freedoms.len()
    }

    /// The number of entries of the pattern, some of which may be zero at some states.
    pub const fn entries(&self) -> usize {
        self.columns.len()
    }

    /// What the rows are.
    pub fn equations(&self) -> &[Equation] {
        &self.equations
    }

    /// What the columns are, by node and number.
    pub fn freedoms(&self) -> &[Freedom] {
        &self.freedoms
    }

    /// Compressed rows: the entries of row i are those from `offsets()[i]` to before `offsets()[i + 1]`.
    pub fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// The columns (0-based) of the entries of row i (0-based); none beyond the last row.
    pub fn row(&self, i: usize) -> &[u32] {
        self.range(i).and_then(|range| self.columns.get(range)).unwrap_or_default()
    }

    /// Where the entries of row i (0-based) are.
    pub fn range(&self, i: usize) -> Option<Range<usize>> {
        Some(*self.offsets.get(i)?..*self.offsets.get(i + 1)?)
    }

    pub(super) fn check(&self, plan: &Plan) -> Result<(), ForeignPattern> {
        let is_same =
            self.plan[0] == plan.connectors && self.plan[1] == plan.mpcs && self.plan[2] == plan.relations;
        if is_same { Ok(()) } else { Err(ForeignPattern::Plan) }
    }

    /// Whether this is a pattern that was made when that one was, or a copy of it.
    pub(super) fn is_copy_of(&self, origin: &Arc<()>) -> bool {
        Arc::ptr_eq(&self.origin, origin)
    }

    /// What it shares with its copies only.
    pub(super) const fn origin(&self) -> &Arc<()> {
        &self.origin
    }

    /// The first entry of a connector, by its place in the plan; beyond the last connector, that of the MPCs.
    pub(super) fn first_entry(&self, at: usize) -> usize {
        self.blocks.get(at).map_or(self.first_mpc, |block| block.first)
    }

    /// The first entry of an MPC, by its place in the plan; beyond the last, that of the relations.
    pub(super) fn first_mpc_entry(&self, at: usize) -> usize {
        let all = self.mpc_entries.len();
        self.first_mpc + self.mpcs.get(at).map_or(all, |block| block.entries.start)
    }

    /// The first entry of a relation, by its place in the plan; beyond the last, the number of entries.
    pub(super) fn first_relation_entry(&self, at: usize) -> usize {
        self.relations.get(at).map_or(self.entries(), |block| block.first)
    }

    /// The rows of a connector that have columns, by its place in the plan: none between nodes that are fixed.
    pub(super) fn wanted(&self, at: usize) -> Mask {
        self.blocks[at].columns.map(|columns| columns != 0)
    }

    /// Writes the entries of a connector: `of` gives the derivatives of a row by a group, `flow` those by the flow of an end, of b if
    /// that is so.
    pub(super) fn write(
        &self,
        at: usize,
        entries: &mut [f64],
        of: impl Fn(usize, Group) -> Vector<f64>,
        flow: impl Fn(usize, bool) -> f64,
    ) {
        const GROUPS: [[Group; 2]; 2] =
            [[Group::TranslationA, Group::RotationA], [Group::TranslationB, Group::RotationB]];
        let block = &self.blocks[at];
        let mut rest = entries;
        for k in 0..6 {
            if block.columns[k] == 0 {
                continue;
            }
            for is_b in [block.is_swapped, !block.is_swapped] {
                let end = usize::from(is_b);
                let mut bits = block.columns[k] >> (end * (DOFS / 2));
                for group in GROUPS[end] {
                    let own = bits & 0b111;
                    bits >>= 3;
                    if own == 0 {
                        continue;
                    }
                    let derivatives = match block.axes[end] {
                        None => of(k, group),
                        axes => self.turned(axes, of(k, group)),
                    };
                    if own == 0b111
                        && let Some((three, others)) = std::mem::take(&mut rest).split_first_chunk_mut::<3>()
                    {
                        *three = derivatives;
                        rest = others;
                        continue;
                    }
                    for (i, derivative) in derivatives.into_iter().enumerate() {
                        if own >> i & 1 != 0
                            && let Some((entry, others)) = std::mem::take(&mut rest).split_first_mut()
                        {
                            *entry = derivative;
                            rest = others;
                        }
                    }
                }
                if bits & 1 != 0
                    && let Some((entry, others)) = std::mem::take(&mut rest).split_first_mut()
                {
                    *entry = flow(k, is_b);
                    rest = others;
                }
            }
        }
    }

    /// The same of rows by themselves. One that is not there has entries that are no numbers: the others keep their places.
    pub(super) fn write_rows(&self, at: usize, rows: &Components<CompactRow<f64>>, entries: &mut [f64]) {
        let row = |k: usize| rows.get(k).and_then(Option::as_ref);
        self.write(
            at,
            entries,
            |k, group| row(k).map_or([f64::NAN; 3], |row| row.group(group)),
            |k, is_b| row(k).map_or(f64::NAN, |row| row.flow()[usize::from(is_b)]),
        );
    }

    /// Gives the entries of an MPC in the order of the rows.
    pub(super) fn write_mpc(&self, at: usize, rows: &mpc::Rows<mpc::Dofs<f64>>, mut put: impl FnMut(f64)) {
        let MpcBlock { entries, axes } = &self.mpcs[at];
        for (row, j) in self.mpc_entries.get(entries.clone()).unwrap_or_default() {
            let Some(row) = &rows[usize::from(*row)] else {
                put(f64::NAN);
                continue;
            };
            let j = usize::from(*j);
            let (place, number) = MpcType::column_dof(j);
            let axes = axes.get(place).copied().flatten();
            put(match (axes, number, place) {
                (Some(_), 1..=6, 0 | 1) => {
                    let component = (usize::from(number) - 1) % 3;
                    let from = j - component;
                    self.turned(axes, [row[from], row[from + 1], row[from + 2]])[component]
                }
                _ => row[j],
            });
        }
    }

    /// Gives the entries of a relation in the order of the rows.
    pub(super) fn write_relation(
        &self,
        at: usize,
        rows: &[relation::ConstraintRow<f64>],
        mut put: impl FnMut(f64),
    ) {
        for row in rows {
            let entry = |at: usize| row.gradient.get(at).copied().unwrap_or(f64::NAN);
            for taken in &self.relations[at].taken {
                put(match *taken {
                    Taken::Column(at) => entry(at),
                    Taken::Along { axes, columns, component } => {
                        self.turned(Some(axes), columns.map(|at| at.map_or(0.0, entry)))[component]
                    }
                });
            }
        }
    }

    /// The components along the axes of a node.
    fn turned(&self, axes: Option<u32>, of: Vector<f64>) -> Vector<f64> {
        match axes.and_then(|axes| self.axes.get(axes as usize)) {
            Some(axes) => axes.map(|axis| dot(axis, of)),
            None => of,
        }
    }
}

/// The degrees of freedom of a connector in the order of its columns.
fn order(is_swapped: bool) -> impl Iterator<Item = usize> {
    let half = DOFS / 2;
    (0..DOFS).map(move |j| if is_swapped { (j + half) % DOFS } else { j })
}

/// A pattern along turned axes: one component of a vector becomes three.
fn along_axes(mut pattern: [bool; DOFS], is_turned: [bool; 2]) -> [bool; DOFS] {
    for (end, _) in is_turned.iter().enumerate().filter(|(_, is)| **is) {
        for from in [end * DOFS / 2, end * DOFS / 2 + 3] {
            let any = pattern[from..from + 3].contains(&true);
            pattern[from..from + 3].fill(any);
        }
    }
    pattern
}

/// Numbers the degrees of freedom of the nodes of a plan that are not fixed.
fn number<'a>(nodes: &'a [Label], model: &Model, plan: &Plan, fixed: &Fixed) -> Numbering<'a> {
    let mut numbering = Numbering {
        first: Vec::with_capacity(nodes.len()),
        has: vec![0; nodes.len()],
        places: Places::new(nodes),
    };
    let mut add = |node: Label, place: Option<usize>, number: u8| {
        let is_fixed = fixed.contains(Freedom { node, number });
        if let (Some(place), Some(bit), false) = (place, place_of(number), is_fixed) {
            numbering.has[place] |= 1 << bit;
        }
    };
    let places = Places::new(nodes);
    for index in &plan.connectors {
        let element = &model.connectors[*index];
        let of = element.nodes.map(|node| places.of(node?));
        for (j, _) in element.connector.active().iter().enumerate().filter(|(_, active)| **active) {
            let end = usize::from(j >= DOFS / 2);
            if let Some(node) = element.nodes[end] {
                add(node, of[end], DOF_NUMBER[j]);
            }
        }
    }
    for index in &plan.mpcs {
        let element = &model.mpcs[*index];
        for (j, _) in element.constraint.columns().iter().enumerate().filter(|(_, is)| **is) {
            let (place, number) = MpcType::column_dof(j);
            if let Some(node) = element.nodes.get(place) {
                add(*node, places.of(*node), number);
            }
        }
    }
    for index in &plan.relations {
        let element = &model.relations[*index];
        let has_axes = |place: usize| fixed.axes(element.nodes[place]).is_some();
        for (place, number) in element.relation.own_columns(has_axes) {
            let node = element.nodes[place];
            add(node, places.of(node), number);
        }
    }
    let mut next = 0;
    for has in &numbering.has {
        numbering.first.push(next);
        next += has.count_ones();
    }
    numbering
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Selection;
    use pintle_kinematics::connector::{Request, Tally};
    use pintle_kinematics::node::Pair;
    use pintle_scene::Scene;

    /// A row that is not there is no number, and the others keep their places.
    #[test]
    fn a_missing_row_moves_no_other() {
        let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
                    *CONNECTOR SECTION, ELSET=C\nJOIN\n";
        let model = Model::compile(&Scene::parse("deck.inp", deck).unwrap()).unwrap();
        let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
        let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::default());
        let element = &model.connectors[0];
        let still = pintle_kinematics::connector::State {
            pair: Pair { ..element.definition().initial },
            velocity: [0.0; DOFS],
            acceleration: [0.0; DOFS],
        };
        let branch = element.connector.initial_branch();
        let mut tally = Tally::default();
        let mut rows = element.connector.compact_rows(&still, &branch, jacobian.wanted(0), &mut tally);
        let [mut whole, mut lacking] = [0, 1].map(|_| vec![0.0; jacobian.entries()]);
        jacobian.write_rows(0, &rows, &mut whole);
        rows[0] = None;
        jacobian.write_rows(0, &rows, &mut lacking);
        assert_eq!((whole.len(), lacking.len()), (jacobian.entries(), jacobian.entries()));
        let first = jacobian.offsets()[1];
        assert!(first > 0 && whole.iter().all(|x| x.is_finite()));
        assert!(lacking[..first].iter().all(|x| x.is_nan()), "{lacking:?}");
        assert_eq!(lacking[first..], whole[first..]);
    }
}
