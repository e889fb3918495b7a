//! The equations of an assembly: what is enforced, held and driven, without dimensions, and what belongs together.

use crate::facts::{Role, Skipped};
use crate::matrix::contract::Contracted;
use crate::matrix::eliminate::Most;
use crate::matrix::noise::ROUNDED;
use crate::matrix::order::{Union, minimum_degree};
use crate::matrix::sparse;
use crate::matrix::sparse::{Layout, Sparse};
use crate::prescribed::Prescribed;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Flag, Mask, Output, Request};
use pintle_kinematics::measure::{Measure, SingularClass, Unit};
use pintle_kinematics::mpc::MpcType;
use pintle_kinematics::scalar::U;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{add, sub};
use pintle_model::evaluate::{Equation, Freedom, Item, Jacobian, Model, Plan, Sequence, Source};
use pintle_scene::{Label, NodeMotion, Rotation, State};
use std::collections::{HashMap, HashSet};
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};

/// A row: an equation of the Jacobian, or a degree of freedom that a boundary condition drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Origin {
    Equation(Equation),
    Boundary(Freedom),
}

/// Equations that share degrees of freedom, directly or through others.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConnectedComponent {
    /// Rows of the system, ascending.
    pub(crate) rows: Vec<u32>,
    /// Columns of the system, by node, ascending.
    pub(crate) columns: Vec<u32>,
    /// The length by which lengths are divided.
    pub(crate) length: f64,
    /// Which connectors, MPCs and relations of the model.
    pub(crate) connectors: Vec<usize>,
    pub(crate) mpcs: Vec<usize>,
    pub(crate) relations: Vec<usize>,
    /// What its elimination may cost.
    pub(crate) most: Most,
    /// The order of elimination that was found last, with what it is of.
    known: Arc<Mutex<Option<Known>>>,
}

/// The sets of groups that rows join, the widths of these, and their order; none where the elimination is too dear.
#[derive(Debug)]
struct Known {
    cliques: Vec<Vec<u32>>,
    widths: Vec<usize>,
    order: Option<Arc<Vec<u32>>>,
}

impl ConnectedComponent {
    /// The order in which the bodies of its matrix are eliminated; `None` where that would take more than it may. It is sought where it is not known of a
    /// matrix that joins the same.
    pub(crate) fn order(&self, contracted: &Contracted) -> Option<Arc<Vec<u32>>> {
        let (cliques, widths) = (contracted.cliques(), contracted.widths());
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known.as_ref().filter(|known| known.cliques == cliques && known.widths == widths)
        {
            return known.order.clone();
        }
        let order = minimum_degree(&widths, &cliques, self.most.work).map(Arc::new);
        *known = Some(Known { cliques, widths, order: order.clone() });
        order
    }
}

/// What is enforced and held, by what it belongs to.
type Evaluated = HashMap<Source, [Option<f64>; 7]>;

/// All equations of a plan.
pub(crate) struct System<'a> {
    pub(crate) model: &'a Model,
    pub(crate) plan: &'a Plan,
    pub(crate) jacobian: Jacobian,
    pub(crate) prescribed: &'a Prescribed,
    pub(crate) origins: Vec<Origin>,
    pub(crate) roles: Vec<Role>,
    /// The columns that boundary conditions drive.
    driven: Vec<u32>,
    pub(crate) components: Vec<ConnectedComponent>,
    /// Rows whose nodes are all fixed.
    pub(crate) fixed_rows: Vec<u32>,
    hinges: HashSet<Label>,
}

impl<'a> System<'a> {
    /// The equations of a plan.
    pub(crate) fn new(model: &'a Model, plan: &'a Plan, prescribed: &'a Prescribed) -> Self {
        let role = |label: Label, k: usize| prescribed.motions.get(&(label, k)).copied();
        let jacobian = Jacobian::new(model, plan, &prescribed.held, |element, k| {
            element.connector.is_constrained(k) || role(element.label, k).is_some()
        });
        let mut origins: Vec<Origin> =
            jacobian.equations().iter().map(|row| Origin::Equation(*row)).collect();
        let mut roles: Vec<Role> = jacobian
            .equations()
            .iter()
            .map(|row| match row.source {
                Source::Connector(index) => {
                    let element = &model.connectors[index];
                    let is_enforced = element.connector.is_constrained(row.component);
                    let motion = || role(element.label, row.component).unwrap_or(Role::Held);
                    if is_enforced { Role::Enforced } else { motion() }
                }
                Source::Mpc(_) | Source::Relation(_) => Role::Enforced,
            })
            .collect();
        let mut driven = Vec::new();
        for (column, freedom) in jacobian.freedoms().iter().enumerate() {
            if prescribed.driven.contains(freedom) {
                driven.push(column as u32);
                origins.push(Origin::Boundary(*freedom));
                roles.push(Role::Driven);
            }
        }
        let hinges =
            plan.mpcs.iter().flat_map(|index| model.mpcs[*index].nodes.iter().skip(2)).copied().collect();
        let mut system = Self {
            model,
            plan,
            jacobian,
            prescribed,
            origins,
            roles,
            driven,
            components: Vec::new(),
            fixed_rows: Vec::new(),
            hinges,
        };
        system.divide();
        system
    }

    /// How many connectors and constraints are evaluated.
    pub(crate) fn evaluated_elements(&self) -> usize {
        self.plan.connectors.len() + self.plan.mpcs.len() + self.plan.relations.len()
    }

    /// A number of the connector or constraint that enforces a row.
    fn source(&self, row: usize) -> u32 {
        match self.origins[row] {
            Origin::Equation(equation) if self.roles[row] == Role::Enforced => match equation.source {
                Source::Connector(index) => index as u32,
                Source::Mpc(index) => (self.model.connectors.len() + index) as u32,
                Source::Relation(index) => {
                    (self.model.connectors.len() + self.model.mpcs.len() + index) as u32
                }
            },
            _ => sparse::NONE,
        }
    }

    /// The columns of a row.
    fn row(&self, row: usize) -> &[u32] {
        match row.checked_sub(self.jacobian.rows()) {
            None => self.jacobian.row(row),
            Some(driven) => std::slice::from_ref(&self.driven[driven]),
        }
    }

    /// The length of what a row belongs to, where it has one: nodes that are no farther apart than rounding makes them are meant to coincide.
    fn length(&self, row: usize) -> Option<f64> {
        let Origin::Equation(equation) = self.origins[row] else { return None };
        let length = match equation.source {
            Source::Connector(index) => norm(self.model.connectors[index].reference),
            Source::Mpc(index) => norm(self.model.mpcs[index].constraint.arm()),
            Source::Relation(index) => self.model.relations[index].length(),
        };
        Some(length).filter(|length| *length > ROUNDED * U * self.coordinates(equation.source))
    }

    /// The sum of the largest coordinates of the nodes of a connector or constraint, of those that are rounded.
    fn coordinates(&self, source: Source) -> f64 {
        let of = |node: &Label| self.prescribed.rounded.get(node).copied().unwrap_or_default();
        match source {
            Source::Connector(index) => self.model.connectors[index].nodes.iter().flatten().map(of).sum(),
            Source::Mpc(index) => self.model.mpcs[index].nodes.iter().map(of).sum(),
            // A mean rounds as one of its nodes does.
            Source::Relation(index) => {
                let nodes = &self.model.relations[index].nodes;
                2.0 * nodes.iter().map(of).fold(0.0, f64::max)
            }
        }
    }

    /// Whether the directions of an equation are those of the line of the nodes, and so as uncertain as that is. Those of others are given, and
    /// their levers as uncertain as the coordinates.
    fn is_along_line(&self, Equation { source, component }: Equation) -> bool {
        match source {
            Source::Connector(index) => {
                self.model.connectors[index].connector.differentiated(component).is_some_and(|measure| {
                    matches!(measure, Measure::Distance | Measure::Strain | Measure::RadialDistance)
                })
            }
            Source::Mpc(index) => self.model.mpcs[index].constraint.kind() == MpcType::Link,
            Source::Relation(_) => false,
        }
    }

    /// The length that counts for the directions and levers of a row, where it has one.
    fn counting(&self, component: &ConnectedComponent, row: usize) -> Option<f64> {
        let Origin::Equation(equation) = self.origins[row] else { return None };
        let length = self.length(row)?;
        Some(if self.is_along_line(equation) { length.min(component.length) } else { component.length })
    }

    /// By how much, in rounding units, the rounding of coordinates changes the entries of a row that are not zero. Nodes that coincide are
    /// meant to, and so are distances of zero along an axis.
    fn rough(&self, component: &ConnectedComponent, row: usize) -> f32 {
        let (Some(length), Origin::Equation(equation)) = (self.counting(component, row), self.origins[row])
        else {
            return 0.0;
        };
        (self.coordinates(equation.source) / length) as f32
    }

    /// By how much the digits of the scene leave the entries of a row that are not zero open, relative to the largest.
    fn open(&self, component: &ConnectedComponent, row: usize) -> f32 {
        let Origin::Equation(equation) = self.origins[row] else { return 0.0 };
        let digits = &self.prescribed.digits;
        let length = self.counting(component, row);
        let of = |node: &Label| length.map_or(0.0, |length| digits.of_node(node, length) / length);
        let all: f64 = match equation.source {
            Source::Connector(index) => {
                let element = &self.model.connectors[index];
                digits.of_directions(&element.label) + element.nodes.iter().flatten().map(of).sum::<f64>()
            }
            Source::Mpc(index) => self.model.mpcs[index].nodes.iter().map(of).sum(),
            Source::Relation(index) => {
                2.0 * self.model.relations[index].nodes.iter().map(of).fold(0.0, f64::max)
            }
        };
        all as f32
    }

    /// Finds what belongs together.
    fn divide(&mut self) {
        let freedoms = self.jacobian.freedoms();
        let mut node_of = Vec::with_capacity(freedoms.len());
        let mut nodes = 0;
        for (column, freedom) in freedoms.iter().enumerate() {
            if column > 0 && freedoms[column - 1].node != freedom.node {
                nodes += 1;
            }
            node_of.push(nodes);
        }
        let count = if freedoms.is_empty() { 0 } else { nodes as usize + 1 };
        let mut union = Union::new(count);
        for row in 0..self.origins.len() {
            let columns = self.row(row);
            if let [first, rest @ ..] = columns {
                for column in rest {
                    union.join(node_of[*first as usize], node_of[*column as usize]);
                }
            }
        }
        let mut part_of: HashMap<u32, usize> = HashMap::new();
        let mut components: Vec<ConnectedComponent> = Vec::new();
        for column in 0..freedoms.len() {
            let root = union.find(node_of[column]);
            let component = *part_of.entry(root).or_insert_with(|| {
                components.push(ConnectedComponent::default());
                components.len() - 1
            });
            components[component].columns.push(column as u32);
        }
        let mut lengths: Vec<(f64, usize)> = vec![(0.0, 0); components.len()];
        let mut before: Option<Origin> = None;
        let mut fixed_rows = Vec::new();
        for row in 0..self.origins.len() {
            let columns = self.row(row);
            let Some(first) = columns.first() else {
                fixed_rows.push(row as u32);
                continue;
            };
            let Some(component) = part_of.get(&union.find(node_of[*first as usize])).copied() else {
                continue;
            };
            components[component].rows.push(row as u32);
            let origin = self.origins[row];
            let is_same = match (before, origin) {
                (Some(Origin::Equation(old)), Origin::Equation(new)) => old.source == new.source,
                _ => false,
            };
            if !is_same {
                if let Origin::Equation(equation) = origin {
                    match equation.source {
                        Source::Connector(index) => components[component].connectors.push(index),
                        Source::Mpc(index) => components[component].mpcs.push(index),
                        Source::Relation(index) => components[component].relations.push(index),
                    }
                }
                if let Some(length) = self.length(row) {
                    lengths[component].0 += length;
                    lengths[component].1 += 1;
                }
            }
            before = Some(origin);
        }
        for (component, (sum, count)) in components.iter_mut().zip(lengths) {
            component.length = if count > 0 { sum / count as f64 } else { 1.0 };
        }
        self.components = components;
        self.fixed_rows = fixed_rows;
    }

    /// A connected component that was not looked at.
    pub(crate) fn skipped(&self, component: &ConnectedComponent) -> Option<Skipped> {
        let first = *component.columns.first()? as usize;
        Some(Skipped {
            connectors: component.connectors.len(),
            mpcs: component.mpcs.len(),
            relations: component.relations.len(),
            degrees_of_freedom: component.columns.len(),
            constraints: component.rows.len(),
            node: self.jacobian.freedoms().get(first)?.node,
        })
    }

    /// Whether a row is an equation between lengths.
    fn is_length(&self, row: usize) -> bool {
        match self.origins[row] {
            Origin::Boundary(freedom) => is_length(freedom.number),
            Origin::Equation(Equation { source: Source::Mpc(_), component }) => {
                MpcType::row_unit(component) == Unit::Length
            }
            Origin::Equation(Equation { source: Source::Relation(index), component }) => {
                let rows = self.model.relations[index].relation.rows();
                rows.get(component).is_none_or(|(_, unit)| *unit == Unit::Length)
            }
            Origin::Equation(Equation { source: Source::Connector(index), component }) => {
                let connector = &self.model.connectors[index].connector;
                connector.differentiated(component).is_some_and(|measure| measure.unit() == Unit::Length)
            }
        }
    }

    /// By what the equation of a row is divided, so that it has no dimension.
    fn scale(&self, component: &ConnectedComponent, row: usize) -> f64 {
        if self.is_length(row) { component.length } else { 1.0 }
    }

    /// The rows and the matrix of a connected component without dimensions, from the entries of the Jacobian at a state. What is enforced comes
    /// before what is held, and that before what is driven: of rows that depend on each other the last are named.
    pub(crate) fn matrix(
        &self,
        component: &ConnectedComponent,
        (state, values): (&State, &[f64]),
        wanted: impl Fn(Role) -> bool,
    ) -> (Vec<u32>, Sparse) {
        let freedoms = self.jacobian.freedoms();
        let mut matrix = Sparse { offsets: vec![0], ..Sparse::default() };
        let mut layout = Layout { length: component.length, ..Layout::default() };
        let mut last = None;
        for (local, column) in component.columns.iter().enumerate() {
            let node = freedoms[*column as usize].node;
            if last != Some(node) {
                matrix.groups.push(local as u32);
                let displacement = state.nodes.get(&node).map(|motion| motion.displacement);
                let place = self.prescribed.places.get(&node).copied().unwrap_or([f64::NAN; 3]);
                layout.places.push([place, displacement.unwrap_or_default()]);
                layout.axes.push(self.prescribed.held.axes(node).copied());
            }
            layout.numbers.push(freedoms[*column as usize].number);
            last = Some(node);
        }
        matrix.groups.push(component.columns.len() as u32);
        let of_role =
            |role: Role| component.rows.iter().copied().filter(move |row| self.roles[*row as usize] == role);
        let roles = [Role::Enforced, Role::Held, Role::Driven];
        let rows: Vec<u32> = roles.into_iter().filter(|role| wanted(*role)).flat_map(of_role).collect();
        for row in &rows {
            let row = *row as usize;
            let scale = self.scale(component, row);
            let entries = self.jacobian.range(row).filter(|_| row < self.jacobian.rows());
            for (at, column) in self.row(row).iter().enumerate() {
                let value = entries.as_ref().map_or(1.0, |entries| values[entries.start + at]);
                let by = if is_length(freedoms[*column as usize].number) { component.length } else { 1.0 };
                let Ok(local) = component.columns.binary_search(column) else { continue };
                matrix.columns.push(local as u32);
                matrix.values.push(value * by / scale);
            }
            matrix.offsets.push(matrix.columns.len());
            matrix.rough.push(self.rough(component, row));
            matrix.open.push(self.open(component, row));
            layout.sources.push(self.source(row));
        }
        matrix.layout = Some(layout);
        (rows, matrix)
    }

    /// The residuals of all rows of the system at the state that a sequence of the same plan comes to, without dimensions.
    pub(crate) fn all_residuals(&self, sequence: &Sequence<'_>, state: &State) -> Vec<f64> {
        let mut all = vec![0.0; self.origins.len()];
        let of_source = self.evaluated(sequence, state);
        for component in &self.components {
            for row in &component.rows {
                all[*row as usize] = self.residual(component, *row as usize, &of_source);
            }
        }
        all
    }

    /// The residuals of the rows of a connected component at the state that a sequence of the same plan comes to, without dimensions: those of driven rows are 0.
    pub(crate) fn residuals(
        &self,
        component: &ConnectedComponent,
        sequence: &Sequence<'_>,
        state: &State,
    ) -> Vec<f64> {
        let of_source = self.evaluated(sequence, state);
        component.rows.iter().map(|row| self.residual(component, *row as usize, &of_source)).collect()
    }

    /// Rows whose derivatives do not exist, or have lost their digits, at the state that a sequence of the same plan comes to, ascending.
    pub(crate) fn without_derivative(&self, sequence: &Sequence<'_>, state: &State) -> Vec<u32> {
        let mut flagged: HashSet<(Source, &'static str)> = HashSet::new();
        let mut lost: HashSet<Source> = HashSet::new();
        let mut note = |source: Source, flags: &[Flag]| {
            let is_one = |flag: &&Flag| match flag {
                Flag::Singular { class, .. } | Flag::IllConditioned { class, .. } => match class {
                    SingularClass::Kink | SingularClass::TrueSingularity | SingularClass::Reversal => true,
                    SingularClass::BranchCut | SingularClass::Removable => false,
                },
                flag => matches!(flag, Flag::NotFinite { .. }),
            };
            flagged.extend(flags.iter().filter(is_one).map(|flag| (source, flag.component())));
        };
        let Ok(()) = sequence.clone().visit(state, |item| -> Result<(), Infallible> {
            // A line that is no longer than rounding makes it has no direction.
            let (source, flags, line) = match &item {
                Item::Connector(result) => {
                    (Source::Connector(result.index), &result.flags, result.state.pair.separation())
                }
                Item::Mpc(result) => {
                    let moved = sub(result.state.slave.displacement, result.state.master.displacement);
                    let arm = self.model.mpcs[result.index].constraint.arm();
                    (Source::Mpc(result.index), &result.flags, add(arm, moved))
                }
                Item::Relation(result) => (Source::Relation(result.index), &result.flags, [0.0; 3]),
            };
            note(source, flags);
            let length = norm(line);
            if length > 0.0 && length <= ROUNDED * U * self.coordinates(source) {
                lost.insert(source);
            }
            Ok(())
        });
        if flagged.is_empty() && lost.is_empty() {
            return Vec::new();
        }
        let is_flagged = |origin: &Origin| match origin {
            Origin::Boundary(_) => false,
            Origin::Equation(equation)
                if lost.contains(&equation.source) && self.is_along_line(*equation) =>
            {
                true
            }
            Origin::Equation(Equation { source, component }) => {
                let name = match source {
                    Source::Connector(_) => COMPONENT[*component],
                    Source::Mpc(index) => {
                        self.model.mpcs[*index].constraint.kind().row_name(MpcType::flagged_row(*component))
                    }
                    Source::Relation(index) => {
                        let rows = self.model.relations[*index].relation.rows();
                        rows.get(*component).map_or("", |(name, _)| *name)
                    }
                };
                flagged.contains(&(*source, name))
            }
        };
        (0..).zip(&self.origins).filter(|(_, origin)| is_flagged(origin)).map(|(row, _)| row).collect()
    }

    /// By how much a state moves what boundary conditions hold: rotations (rad), and displacements over the mean length of the connected components.
    pub(crate) fn moves_held(&self, state: &State) -> f64 {
        let Prescribed { resting, always, has_times, .. } = self.prescribed;
        let held = if *has_times && state.time.is_some() { resting } else { always };
        let lengths: f64 = self.components.iter().map(|component| component.length).sum();
        let length = if self.components.is_empty() { 1.0 } else { lengths / self.components.len() as f64 };
        let mut largest = 0.0_f64;
        for (node, motion) in &state.nodes {
            for (number, amount) in held.moved_by(*node, motion) {
                let size = if (4..=6).contains(&number) { 1.0 } else { length };
                largest = sparse::largest(&[largest, amount / size]);
            }
        }
        largest
    }

    /// What is enforced and held.
    fn evaluated(&self, sequence: &Sequence<'_>, state: &State) -> Evaluated {
        let mut sequence = sequence.clone();
        let mut of_source = Evaluated::new();
        let Ok(()) = sequence.visit(state, |item| -> Result<(), Infallible> {
            match item {
                Item::Connector(result) => {
                    let evaluation = &result.evaluation;
                    let connector = &self.model.connectors[result.index].connector;
                    let mut of = [None; 7];
                    for k in 0..6 {
                        of[k] = if connector.is_constrained(k) {
                            evaluation.residual[k]
                        } else {
                            evaluation.displacement[k]
                        };
                    }
                    of_source.insert(Source::Connector(result.index), of);
                }
                Item::Mpc(result) => {
                    of_source.insert(Source::Mpc(result.index), result.evaluation.residual);
                }
                Item::Relation(result) => {
                    let residual = |row: usize| result.rows.get(row).map(|row| row.residual);
                    of_source.insert(Source::Relation(result.index), std::array::from_fn(residual));
                }
            }
            Ok(())
        });
        of_source
    }

    fn residual(&self, component: &ConnectedComponent, row: usize, of_source: &Evaluated) -> f64 {
        let Origin::Equation(equation) = self.origins[row] else { return 0.0 };
        if self.roles[row] == Role::Driven {
            return 0.0;
        }
        // An equation whose residual is not known is not taken for satisfied.
        let residual =
            of_source.get(&equation.source).and_then(|of| of[equation.component]).unwrap_or(f64::NAN);
        residual / self.scale(component, row)
    }

    /// A state whose nodes are moved by a solution without dimensions.
    pub(crate) fn moved(&self, component: &ConnectedComponent, state: &State, solution: &[f64]) -> State {
        let freedoms = self.jacobian.freedoms();
        let mut changes: HashMap<Label, [f64; 7]> = HashMap::new();
        for (column, change) in component.columns.iter().zip(solution) {
            let Freedom { node, number } = freedoms[*column as usize];
            let by = if is_length(number) { component.length } else { 1.0 };
            let place = if number == 10 { 6 } else { usize::from(number) - 1 };
            changes.entry(node).or_default()[place] = change * by;
        }
        let mut next = state.clone();
        for (node, change) in changes {
            let motion = next.nodes.entry(node).or_default();
            let turned = |at: usize| {
                let along = [change[at], change[at + 1], change[at + 2]];
                match self.prescribed.held.axes(node) {
                    // Axes are rows: the vector is the sum of the axes times the components along them.
                    Some(axes) => pintle_kinematics::vector::apply_transposed(axes, along),
                    None => along,
                }
            };
            let [by, turn] = [turned(0), turned(3)];
            for i in 0..3 {
                motion.displacement[i] += by[i];
            }
            motion.flow += change[6];
            motion.rotation = rotated(motion, turn, self.hinges.contains(&node));
        }
        next
    }
}

/// The rotation of a node after a turn; the angle of a hinge is component 3 of its vector.
fn rotated(motion: &NodeMotion, turn: [f64; 3], is_hinge: bool) -> Rotation {
    match motion.rotation {
        Rotation::Vector([x, y, angle]) if is_hinge => Rotation::Vector([x, y, angle + turn[2]]),
        rotation if turn == [0.0; 3] => rotation,
        Rotation::Vector(vector) => Rotation::Quaternion(so3::normalize(so3::compose(
            so3::exp_quaternion(turn),
            so3::exp_quaternion(vector),
        ))),
        Rotation::Quaternion(q) => {
            Rotation::Quaternion(so3::normalize(so3::compose(so3::exp_quaternion(turn), q)))
        }
    }
}

/// Whether a degree of freedom is a length: displacements and material flow.
fn is_length(number: u8) -> bool {
    !matches!(number, 4..=6)
}

/// What residuals are made of.
pub fn request() -> Request {
    const ALL: Mask = [true; 6];
    Request::new(&[Output::CU, Output::RES], ALL, 0)
}
