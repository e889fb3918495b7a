//! The equations of an assembly: what is enforced, held and driven, without dimensions, and what belongs together.

use super::Skipped;
use super::contract::{self, Contracted, Layout};
use super::digits::Digits;
use super::eliminate::{Most, Sparse};
use super::found::ROUNDED;
use super::order::{Orders, Union};
use crate::audit::bound::U;
use crate::catalog::COMPONENT;
use crate::connector::{Flag, Mask, Output, Request};
use crate::evaluate::{
    Equation, Fixed, Freedom, Item, Jacobian, Model, NUMBERS, Plan, Sequence, Source, keeps_zero,
};
use crate::measure::{Measure, SingularClass, Unit};
use crate::mpc::Kind;
use crate::scalar::elementary::norm;
use crate::scene::{
    ConditionKind, ConnectorMotion, Diagnostic, Label, NodeMotion, Rotation, Scene, State, Target,
};
use crate::so3;
use crate::vector::{add, sub};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};

/// Why an equation holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// A connection type or a multi-point constraint enforces it.
    Enforced,
    /// A connector motion of zero holds an available component.
    Held,
    /// A connector motion, or a boundary condition that is not zero, drives it.
    Driven,
}

/// A row: an equation of the Jacobian, or a degree of freedom that a boundary condition drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Origin {
    Equation(Equation),
    Boundary(Freedom),
}

/// Equations that share degrees of freedom, directly or through others.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Rows of the system, ascending.
    pub(super) rows: Vec<u32>,
    /// Columns of the system, by node, ascending.
    pub(super) columns: Vec<u32>,
    /// The length by which lengths are divided.
    pub(super) length: f64,
    /// Which connectors and MPCs of the model.
    pub(super) connectors: Vec<usize>,
    pub(super) mpcs: Vec<usize>,
    /// What its elimination may cost.
    pub(super) most: Most,
    /// What may be spent on names, where that is not by its size.
    pub(super) names: Option<u64>,
    /// What its elimination is taken to cost, where that is not as predicted.
    pub(super) cost: Option<f64>,
    /// The orders of elimination that were found last, with what they are of.
    known: Arc<Mutex<Option<Known>>>,
}

/// The sets of groups that rows join, the widths of these, and their orders.
#[derive(Debug)]
struct Known {
    cliques: Vec<Vec<u32>>,
    widths: Vec<usize>,
    orders: Arc<Orders>,
}

/// Whether an elimination of such a cost is so dear that products with the matrix are tried first.
pub(super) const fn is_dear(cost: f64) -> bool {
    /// Some two seconds of processor.
    const CHEAP: f64 = 1e9;
    cost > CHEAP
}

/// Whether redundant constraints are named at such a cost, where the rank comes of products.
pub(super) const fn is_named(cost: f64) -> bool {
    /// Some tens of seconds of processor.
    const AFFORDABLE: f64 = 3e10;
    cost <= AFFORDABLE
}

impl Part {
    /// The orders in which the bodies of its matrix are eliminated. They are sought where they are not known of a matrix that joins the same.
    pub(super) fn orders(&self, contracted: &Contracted) -> Arc<Orders> {
        let (cliques, widths) = (contracted.cliques(), contracted.widths());
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known.as_ref().filter(|known| known.cliques == cliques && known.widths == widths)
        {
            return known.orders.clone();
        }
        let orders = Arc::new(Orders::of(&cliques, &widths));
        *known = Some(Known { cliques, widths, orders: orders.clone() });
        orders
    }
}

/// What is enforced and held, by whether it is of a connector, and the index of that or of the MPC.
type Evaluated = HashMap<(bool, usize), [Option<f64>; 7]>;

/// All equations of a plan.
pub(super) struct System<'a> {
    pub(super) model: &'a Model,
    pub(super) plan: &'a Plan,
    pub(super) jacobian: Jacobian,
    pub(super) prescribed: &'a Prescribed,
    pub(super) origins: Vec<Origin>,
    pub(super) roles: Vec<Role>,
    /// The columns that boundary conditions drive.
    driven: Vec<u32>,
    pub(super) parts: Vec<Part>,
    /// Rows whose nodes are all fixed.
    pub(super) fixed_rows: Vec<u32>,
    hinges: HashSet<Label>,
}

/// What is done to components of connectors, by element and component (0-based).
type Motions = HashMap<(Label, usize), Role>;

/// What prescribed motions do in a step: components of connectors that are held or driven, degrees of freedom that are.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Prescribed {
    pub(super) held: Fixed,
    /// What of it was held in all steps before, and is zero.
    resting: Fixed,
    /// What is held in every step: of a state whose step is not known.
    always: Fixed,
    /// Whether it is known when the steps end.
    has_times: bool,
    pub(super) motions: Motions,
    pub(super) driven: HashSet<Freedom>,
    /// Where the nodes are.
    places: HashMap<Label, [f64; 3]>,
    /// The largest coordinate of each node that has rounded ones.
    rounded: HashMap<Label, f64>,
    /// How exact the numbers are that the scene gives.
    digits: Digits,
}

/// Whether a coordinate is taken for rounded: it has digits down to the last. Of rounded numbers one in a million ends in so many zeros.
fn is_rounded(coordinate: f64) -> bool {
    const ZEROS: u32 = 20;
    coordinate != 0.0 && coordinate.to_bits().trailing_zeros() < ZEROS
}

/// The largest coordinate of the nodes that have rounded ones.
fn rounded(scene: &Scene) -> HashMap<Label, f64> {
    let largest = |[x, y, z]: [f64; 3]| x.abs().max(y.abs()).max(z.abs());
    let nodes = scene.nodes.iter().map(|(label, node)| (*label, node.coordinates));
    nodes.filter(|(_, x)| x.iter().any(|x| is_rounded(*x))).map(|(label, x)| (label, largest(x))).collect()
}

/// Every degree of freedom that nodes may have.
fn freedoms_of(nodes: &BTreeSet<Label>) -> impl Iterator<Item = Freedom> {
    nodes.iter().flat_map(|node| NUMBERS.map(|number| Freedom { node: *node, number }))
}

impl Prescribed {
    /// What is prescribed in a step, counted from 1; 0 is before the first.
    pub(super) fn of(scene: &Scene, step: usize) -> Result<Self, Diagnostic> {
        let held = Fixed::held_in_step(scene, step)?;
        let resting = Fixed::resting_in_step(scene, step)?;
        let always = Fixed::resting_in_step(scene, scene.steps.len())?;
        let has_times = super::steps::ends(scene).is_some();
        let driven = Fixed::in_step(scene, step)?.iter().filter(|freedom| !held.contains(*freedom)).collect();
        let mut motions = Motions::new();
        // What earlier steps drove is not where it was initially, and is driven back, as of nodes.
        let mut driven_before: HashSet<(Label, usize)> = HashSet::new();
        let put = |motion: &ConnectorMotion, motions: &mut Motions, before: &HashSet<(Label, usize)>| {
            let is_held = keeps_zero(scene, (motion.kind, motion.magnitude.unwrap_or(0.0)), &motion.applied);
            let labels: &[Label] = match &motion.target.value {
                Target::Label(label) => std::slice::from_ref(label),
                Target::Set(name) => {
                    scene.element_sets.get(name.as_str()).map_or(&[], |set| set.labels.as_slice())
                }
            };
            for label in labels {
                let key = (*label, usize::from(motion.component).saturating_sub(1));
                motions
                    .insert(key, if is_held && !before.contains(&key) { Role::Held } else { Role::Driven });
            }
        };
        for motion in &scene.connector_motions {
            put(motion, &mut motions, &driven_before);
        }
        for step in scene.steps.iter().take(step) {
            let driven = motions.iter().filter(|(_, role)| **role == Role::Driven).map(|(key, _)| *key);
            driven_before.extend(driven);
            if step.removed.contains(&ConditionKind::ConnectorMotion) {
                motions.clear();
            }
            for motion in &step.connector_motions {
                put(motion, &mut motions, &driven_before);
            }
        }
        let places = scene.nodes.iter().map(|(label, node)| (*label, node.coordinates)).collect();
        let (rounded, digits) = (rounded(scene), Digits::of(scene));
        Ok(Self { held, resting, always, has_times, motions, driven, places, rounded, digits })
    }

    /// The same for some nodes and elements alone, with degrees of freedom that are held besides.
    pub(super) fn restricted(&self, nodes: &BTreeSet<Label>, elements: &[Label], held: &[Freedom]) -> Self {
        let of_elements = elements.iter().flat_map(|label| (0..6).map(move |k| (*label, k)));
        Self {
            held: self.held.restricted(nodes, held),
            resting: self.resting.restricted(nodes, &[]),
            always: self.always.restricted(nodes, &[]),
            has_times: self.has_times,
            motions: of_elements.filter_map(|key| Some((key, *self.motions.get(&key)?))).collect(),
            driven: freedoms_of(nodes).filter(|freedom| self.driven.contains(freedom)).collect(),
            places: nodes.iter().filter_map(|node| Some((*node, *self.places.get(node)?))).collect(),
            rounded: nodes.iter().filter_map(|node| Some((*node, *self.rounded.get(node)?))).collect(),
            digits: self.digits.restricted(nodes.iter(), elements),
        }
    }
}

impl<'a> System<'a> {
    /// The equations of a plan.
    pub(super) fn new(model: &'a Model, plan: &'a Plan, prescribed: &'a Prescribed) -> Self {
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
                Source::Mpc(_) => Role::Enforced,
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
            parts: Vec::new(),
            fixed_rows: Vec::new(),
            hinges,
        };
        system.divide();
        system
    }

    /// A number of the connector or constraint that enforces a row.
    fn source(&self, row: usize) -> u32 {
        match self.origins[row] {
            Origin::Equation(equation) if self.roles[row] == Role::Enforced => match equation.source {
                Source::Connector(index) => index as u32,
                Source::Mpc(index) => (self.model.connectors.len() + index) as u32,
            },
            _ => contract::NONE,
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
        };
        Some(length).filter(|length| *length > ROUNDED * U * self.coordinates(equation.source))
    }

    /// The sum of the largest coordinates of the nodes of a connector or constraint, of those that are rounded.
    fn coordinates(&self, source: Source) -> f64 {
        let of = |node: &Label| self.prescribed.rounded.get(node).copied().unwrap_or_default();
        match source {
            Source::Connector(index) => self.model.connectors[index].nodes.iter().flatten().map(of).sum(),
            Source::Mpc(index) => self.model.mpcs[index].nodes.iter().map(of).sum(),
        }
    }

    /// Whether the directions of an equation are those of the line of the nodes, and so as uncertain as that is; those of others are given, and
    /// their levers as uncertain as the coordinates.
    fn is_along_line(&self, Equation { source, component }: Equation) -> bool {
        match source {
            Source::Connector(index) => {
                self.model.connectors[index].connector.differentiated(component).is_some_and(|measure| {
                    matches!(measure, Measure::Distance | Measure::Strain | Measure::RadialDistance)
                })
            }
            Source::Mpc(index) => self.model.mpcs[index].constraint.kind() == Kind::Link,
        }
    }

    /// The length that counts for the directions and levers of a row, where it has one.
    fn counting(&self, part: &Part, row: usize) -> Option<f64> {
        let Origin::Equation(equation) = self.origins[row] else { return None };
        let length = self.length(row)?;
        Some(if self.is_along_line(equation) { length.min(part.length) } else { part.length })
    }

    /// By how much, in rounding units, the rounding of coordinates changes the entries of a row that are not zero. Nodes that coincide are
    /// meant to, and so are distances of zero along an axis.
    fn rough(&self, part: &Part, row: usize) -> f32 {
        let (Some(length), Origin::Equation(equation)) = (self.counting(part, row), self.origins[row]) else {
            return 0.0;
        };
        (self.coordinates(equation.source) / length) as f32
    }

    /// By how much the digits of the scene leave the entries of a row that are not zero open, relative to the largest.
    fn open(&self, part: &Part, row: usize) -> f32 {
        let Origin::Equation(equation) = self.origins[row] else { return 0.0 };
        let digits = &self.prescribed.digits;
        let length = self.counting(part, row);
        let of = |node: &Label| length.map_or(0.0, |length| digits.of_node(node, length) / length);
        let all: f64 = match equation.source {
            Source::Connector(index) => {
                let element = &self.model.connectors[index];
                digits.of_directions(&element.label) + element.nodes.iter().flatten().map(of).sum::<f64>()
            }
            Source::Mpc(index) => self.model.mpcs[index].nodes.iter().map(of).sum(),
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
        let mut parts: Vec<Part> = Vec::new();
        for column in 0..freedoms.len() {
            let root = union.find(node_of[column]);
            let part = *part_of.entry(root).or_insert_with(|| {
                parts.push(Part::default());
                parts.len() - 1
            });
            parts[part].columns.push(column as u32);
        }
        let mut lengths: Vec<(f64, usize)> = vec![(0.0, 0); parts.len()];
        let mut before: Option<Origin> = None;
        let mut fixed_rows = Vec::new();
        for row in 0..self.origins.len() {
            let columns = self.row(row);
            let Some(first) = columns.first() else {
                fixed_rows.push(row as u32);
                continue;
            };
            let Some(part) = part_of.get(&union.find(node_of[*first as usize])).copied() else { continue };
            parts[part].rows.push(row as u32);
            let origin = self.origins[row];
            let is_same = match (before, origin) {
                (Some(Origin::Equation(old)), Origin::Equation(new)) => old.source == new.source,
                _ => false,
            };
            if !is_same {
                if let Origin::Equation(equation) = origin {
                    match equation.source {
                        Source::Connector(index) => parts[part].connectors.push(index),
                        Source::Mpc(index) => parts[part].mpcs.push(index),
                    }
                }
                if let Some(length) = self.length(row) {
                    lengths[part].0 += length;
                    lengths[part].1 += 1;
                }
            }
            before = Some(origin);
        }
        for (part, (sum, count)) in parts.iter_mut().zip(lengths) {
            part.length = if count > 0 { sum / count as f64 } else { 1.0 };
        }
        self.parts = parts;
        self.fixed_rows = fixed_rows;
    }

    /// Gives all parts a length.
    pub(super) fn put_length(&mut self, length: f64) {
        self.parts.iter_mut().for_each(|part| part.length = length);
    }

    /// A part that was not looked at, for a front of so many columns would be too large.
    pub(super) fn skipped(&self, part: &Part, front: usize) -> Option<Skipped> {
        let first = *part.columns.first()? as usize;
        Some(Skipped {
            connectors: part.connectors.len(),
            mpcs: part.mpcs.len(),
            degrees_of_freedom: part.columns.len(),
            constraints: part.rows.len(),
            node: self.jacobian.freedoms().get(first)?.node,
            front,
        })
    }

    /// Whether a row is an equation between lengths.
    fn is_length(&self, row: usize) -> bool {
        match self.origins[row] {
            Origin::Boundary(freedom) => is_length(freedom.number),
            Origin::Equation(Equation { source: Source::Mpc(_), component }) => {
                Kind::row_unit(component) == Unit::Length
            }
            Origin::Equation(Equation { source: Source::Connector(index), component }) => {
                let connector = &self.model.connectors[index].connector;
                connector.differentiated(component).is_some_and(|measure| measure.unit() == Unit::Length)
            }
        }
    }

    /// By what the equation of a row is divided, so that it has no dimension.
    fn scale(&self, part: &Part, row: usize) -> f64 {
        if self.is_length(row) { part.length } else { 1.0 }
    }

    /// The rows and the matrix of a part without dimensions, from the entries of the Jacobian at a state: rows of the roles wanted, what is enforced
    /// before what is held before what is driven, so that of rows that depend on each other the last are named.
    pub(super) fn matrix(
        &self,
        part: &Part,
        (state, values): (&State, &[f64]),
        wanted: impl Fn(Role) -> bool,
    ) -> (Vec<u32>, Sparse) {
        let freedoms = self.jacobian.freedoms();
        let mut matrix = Sparse { offsets: vec![0], ..Sparse::default() };
        let mut layout = Layout { length: part.length, ..Layout::default() };
        let mut last = None;
        for (local, column) in part.columns.iter().enumerate() {
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
        matrix.groups.push(part.columns.len() as u32);
        let of_role =
            |role: Role| part.rows.iter().copied().filter(move |row| self.roles[*row as usize] == role);
        let roles = [Role::Enforced, Role::Held, Role::Driven];
        let rows: Vec<u32> = roles.into_iter().filter(|role| wanted(*role)).flat_map(of_role).collect();
        for row in &rows {
            let row = *row as usize;
            let scale = self.scale(part, row);
            let entries = self.jacobian.range(row).filter(|_| row < self.jacobian.rows());
            for (at, column) in self.row(row).iter().enumerate() {
                let value = entries.as_ref().map_or(1.0, |entries| values[entries.start + at]);
                let by = if is_length(freedoms[*column as usize].number) { part.length } else { 1.0 };
                let Ok(local) = part.columns.binary_search(column) else { continue };
                matrix.columns.push(local as u32);
                matrix.values.push(value * by / scale);
            }
            matrix.offsets.push(matrix.columns.len());
            matrix.rough.push(self.rough(part, row));
            matrix.open.push(self.open(part, row));
            layout.sources.push(self.source(row));
        }
        matrix.layout = Some(layout);
        (rows, matrix)
    }

    /// The residuals of all rows of the system at the state that a sequence of the same plan comes to, without dimensions.
    pub(super) fn all_residuals(&self, sequence: &Sequence<'_>, state: &State) -> Vec<f64> {
        let mut all = vec![0.0; self.origins.len()];
        let of_source = self.evaluated(sequence, state);
        for part in &self.parts {
            for row in &part.rows {
                all[*row as usize] = self.residual(part, *row as usize, &of_source);
            }
        }
        all
    }

    /// The residuals of the rows of a part at the state that a sequence of the same plan comes to, without dimensions: those of driven rows are 0.
    pub(super) fn residuals(&self, part: &Part, sequence: &Sequence<'_>, state: &State) -> Vec<f64> {
        let of_source = self.evaluated(sequence, state);
        part.rows.iter().map(|row| self.residual(part, *row as usize, &of_source)).collect()
    }

    /// Rows whose derivatives do not exist, or have lost their digits, at the state that a sequence of the same plan comes to, ascending.
    pub(super) fn without_derivative(&self, sequence: &Sequence<'_>, state: &State) -> Vec<u32> {
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
                        self.model.mpcs[*index].constraint.kind().row_name(Kind::flagged_row(*component))
                    }
                };
                flagged.contains(&(*source, name))
            }
        };
        (0..).zip(&self.origins).filter(|(_, origin)| is_flagged(origin)).map(|(row, _)| row).collect()
    }

    /// By how much a state moves what boundary conditions hold: rotations (rad), and displacements over the mean length of the parts.
    pub(super) fn moves_held(&self, state: &State) -> f64 {
        let Prescribed { resting, always, has_times, .. } = self.prescribed;
        let held = if *has_times && state.time.is_some() { resting } else { always };
        let lengths: f64 = self.parts.iter().map(|part| part.length).sum();
        let length = if self.parts.is_empty() { 1.0 } else { lengths / self.parts.len() as f64 };
        let mut largest = 0.0_f64;
        for (node, motion) in &state.nodes {
            for (number, amount) in held.moved_by(*node, motion) {
                let size = if (4..=6).contains(&number) { 1.0 } else { length };
                largest = super::largest(&[largest, amount / size]);
            }
        }
        largest
    }

    /// What is enforced and held, by connector (true) or MPC and index.
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
                    of_source.insert((true, result.index), of);
                }
                Item::Mpc(result) => {
                    of_source.insert((false, result.index), result.evaluation.residual);
                }
            }
            Ok(())
        });
        of_source
    }

    fn residual(&self, part: &Part, row: usize, of_source: &Evaluated) -> f64 {
        let Origin::Equation(equation) = self.origins[row] else { return 0.0 };
        if self.roles[row] == Role::Driven {
            return 0.0;
        }
        let key = match equation.source {
            Source::Connector(index) => (true, index),
            Source::Mpc(index) => (false, index),
        };
        // An equation whose residual is not known is not taken for satisfied.
        let residual = of_source.get(&key).and_then(|of| of[equation.component]).unwrap_or(f64::NAN);
        residual / self.scale(part, row)
    }

    /// A state whose nodes are moved by a solution without dimensions.
    pub(super) fn moved(&self, part: &Part, state: &State, solution: &[f64]) -> State {
        let freedoms = self.jacobian.freedoms();
        let mut changes: HashMap<Label, [f64; 7]> = HashMap::new();
        for (column, change) in part.columns.iter().zip(solution) {
            let Freedom { node, number } = freedoms[*column as usize];
            let by = if is_length(number) { part.length } else { 1.0 };
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
                    Some(axes) => crate::vector::apply_transposed(axes, along),
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
        Rotation::Vector(vector) => {
            Rotation::Quaternion(so3::normalize(so3::compose(so3::exp(turn), so3::exp(vector))))
        }
        Rotation::Quaternion(q) => Rotation::Quaternion(so3::normalize(so3::compose(so3::exp(turn), q))),
    }
}

/// Whether a degree of freedom is a length: displacements and material flow.
fn is_length(number: u8) -> bool {
    !matches!(number, 4..=6)
}

/// What residuals are made of.
pub(super) fn request() -> Request {
    const ALL: Mask = [true; 6];
    Request::new(&[Output::CU, Output::RES], ALL, 0)
}
