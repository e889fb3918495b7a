//! What the connectors give at one state: the numbers of files, and what else those may be.

use crate::column::{Map, Nodal};
use crate::motion::{Motions, labels, shift};
use crate::printed::Printed;
use crate::read::Frame;
use pintle_check::is_vector;
use pintle_kinematics::catalog::{COMPONENT, ConnectionType};
use pintle_kinematics::connector::{Connector, Definition, Increment, Output, Request, Tally};
use pintle_kinematics::force::Want;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::vector::{
    Matrix, Vector, add, apply, apply_transposed, cross, product, scale, sub, transpose,
};
use pintle_model::evaluate::{ConnectorResult, Fixed, Freedom, Item, Model, Sequence};
use pintle_report::{Block, Value};
use pintle_scene::{Label, PointKind, Scene, State, Target};
use serde::{Serialize, Serializer};
use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::fmt::{self, Display, Formatter};

/// What is evaluated.
pub(crate) const OUTPUTS: [Output; 13] = [
    Output::CP,
    Output::CU,
    Output::CCU,
    Output::CV,
    Output::CA,
    Output::CTF,
    Output::CEF,
    Output::CVF,
    Output::CSF,
    Output::CRF,
    Output::CCF,
    Output::CNF,
    Output::CASU,
];

/// What a number is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Of {
    /// An output of a component of a connector.
    Output(Output, usize),
    /// A force or moment at a node.
    Nodal(Nodal, usize),
}

impl Of {
    /// As headings have it: CU1, CUR1, CTF1, CTM1, RF1.
    pub(crate) fn name(self) -> String {
        let (output, k) = match self {
            Self::Nodal(nodal, i) => return nodal.name(i),
            Self::Output(output, k) => (output, k),
        };
        let name = output.name();
        match (k, output.is_force()) {
            (0..=2, _) => format!("{name}{}", k + 1),
            (_, true) => format!("{}M{}", name.trim_end_matches('F'), k - 2),
            (_, false) if output.is_kinematic() => format!("{name}R{}", k - 2),
            _ => format!("{name}{}", k + 1),
        }
    }

    /// Its place among the three of its kind, and that of the first of them.
    pub(crate) const fn place(self) -> (usize, usize) {
        let (Self::Output(_, k) | Self::Nodal(_, k)) = self;
        (k % 3, k - k % 3)
    }

    /// The same of another component.
    pub(crate) const fn with(self, k: usize) -> Self {
        match self {
            Self::Output(output, _) => Self::Output(output, k),
            Self::Nodal(nodal, _) => Self::Nodal(nodal, k),
        }
    }

    /// Whether it is an angle.
    pub(crate) fn is_angle(self) -> bool {
        matches!(self, Self::Output(output, 3..) if output.is_kinematic())
    }
}

/// A number of an element or node.
pub(crate) type Key = (String, Of);

/// Why a number is not compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Why {
    /// The files have no motion of nodes when it was printed.
    NoMotion,
    /// They have no rates of nodes.
    NoRates,
    /// They lack the force of a component of a connector, each by its name.
    NoForce(String, String),
    /// Another reason.
    Other(String),
}

impl Display for Why {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoMotion => f.write_str("the files have no motion of nodes at these times"),
            Self::NoRates => f.write_str("the files have no such rates of nodes"),
            Self::NoForce(force, of) => write!(f, "the force {force} of {of} is not in the files"),
            Self::Other(why) => f.write_str(why),
        }
    }
}

impl Serialize for Why {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl From<&str> for Why {
    fn from(why: &str) -> Self {
        Self::Other(why.into())
    }
}

/// The numbers of one connector.
#[derive(Clone, Debug, Default)]
pub(crate) struct Numbers {
    pub(crate) type_name: String,
    pub(crate) units: [Option<Unit>; 6],
    pub(crate) values: BTreeMap<(Output, usize), f64>,
    /// The components that have a viscous force.
    pub(crate) viscous: [bool; 6],
}

/// The forces of one connector at a node.
#[derive(Clone, Debug)]
struct Part {
    element: String,
    forces: [f64; 6],
    /// The way from its other node.
    way: Vector<f64>,
    /// The axes of its nodes.
    axes: [Matrix<f64>; 2],
}

/// The forces of all connectors at one node, residual-side.
#[derive(Clone, Debug, Default)]
pub(crate) struct AtNode {
    pub(crate) sum: [f64; 6],
    /// What the digits of forces that the files give change.
    digits: [f64; 6],
    /// Of each connector.
    parts: Vec<Part>,
    /// The force that is not known.
    missing: Option<Why>,
}

/// Everything at one state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    pub(crate) elements: BTreeMap<String, Numbers>,
    pub(crate) nodes: BTreeMap<String, AtNode>,
    /// What a number may be in place of what it is called, in words.
    pub(crate) variants: BTreeMap<Key, Vec<(String, f64)>>,
}

/// What a scene says of the forces at its nodes.
pub(crate) struct Evaluator<'a> {
    pub(crate) model: &'a Model,
    pub(crate) map: &'a Map,
    request: Request,
    /// By element: the nodes.
    pub(crate) ends: BTreeMap<String, [Option<Label>; 2]>,
    labels: BTreeMap<String, Label>,
    places: BTreeMap<Label, Vector<f64>>,
    held: BTreeSet<Freedom>,
    /// What else acts on a node.
    others: BTreeMap<Label, &'static str>,
    masses: BTreeSet<Label>,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(scene: &Scene, model: &'a Model, map: &'a Map) -> Result<Self, String> {
        let upper = |label: &Label| label.to_string().to_ascii_uppercase();
        let ends = model.connectors.iter().map(|of| (upper(&of.label), of.nodes)).collect();
        let mut held = BTreeSet::new();
        for step in 0..=scene.steps.len() {
            held.extend(Fixed::in_step(scene, step).map_err(|error| error.to_string())?.iter());
        }
        let mut others: BTreeMap<Label, &'static str> = BTreeMap::new();
        for mpc in &model.mpcs {
            others.extend(mpc.nodes.iter().map(|node| (*node, "a multi-point constraint")));
        }
        for relation in &model.relations {
            others.extend(
                relation.nodes.iter().map(|node| (*node, "an equation, rigid body, coupling or tie")),
            );
        }
        const UNREAD: &str = "an element or constraint that is not read";
        let skipped = &scene.skipped;
        let anywhere = !skipped.constraints.is_empty()
            || !model.other_mpcs.is_empty()
            || !skipped.element_types.is_empty() && skipped.nodes.is_none();
        others.extend(skipped.nodes.iter().flatten().map(|node| (*node, UNREAD)));
        if anywhere {
            others.extend(scene.nodes.keys().map(|node| (*node, UNREAD)));
        }
        let mut masses = BTreeSet::new();
        for element in scene.point_elements.values() {
            let nodes = [Some(element.node), element.second].into_iter().flatten();
            if matches!(element.kind, PointKind::Mass | PointKind::Rotaryi) {
                masses.extend(nodes);
            } else {
                others.extend(nodes.map(|node| (node, "a spring or dashpot")));
            }
        }
        for load in scene.steps.iter().flat_map(|step| &step.concentrated_loads) {
            match &load.target.value {
                Target::Label(label) => others.extend([(*label, "a concentrated load")]),
                Target::Set(name) => {
                    let set = scene.node_sets.get(name.as_str());
                    let nodes = set.into_iter().flat_map(|set| &set.labels);
                    others.extend(nodes.map(|label| (*label, "a concentrated load")));
                }
            }
        }
        Ok(Self {
            model,
            map,
            request: Request::new(&OUTPUTS, [true; 6], 0),
            ends,
            labels: labels(scene),
            places: scene.nodes.iter().map(|(label, node)| (*label, node.coordinates)).collect(),
            held,
            others,
            masses,
        })
    }

    pub(crate) fn request(&self) -> Request {
        self.request.clone()
    }

    /// Everything at the next state. With forces at nodes where the frame has some; with what a number may be besides, where that is
    /// looked for.
    pub(crate) fn at(
        &self,
        sequence: &mut Sequence<'_>,
        state: &State,
        (frame, has_variants): (&Frame, bool),
    ) -> Known {
        let mut known = Known::default();
        let Ok(()) = sequence.visit(state, |item| -> Result<(), Infallible> {
            if let Item::Connector(result) = item {
                self.add(&mut known, result, (frame, has_variants));
            }
            Ok(())
        });
        if has_variants {
            for node in frame.forces.keys() {
                self.add_variants_of_node(&mut known, node, state);
            }
        }
        known
    }

    fn add(&self, known: &mut Known, result: &ConnectorResult, (frame, has_variants): (&Frame, bool)) {
        let block = Block::of_connector(self.model, &self.request, result);
        let viscous = self.model.connectors[result.index].behavior.behavior.damping.components();
        let mut numbers = Numbers { type_name: block.type_name.to_string(), viscous, ..Numbers::default() };
        for row in &block.rows {
            let Some(k) = COMPONENT.iter().position(|name| *name == row.name) else { continue };
            numbers.units[k] = Some(row.unit);
            for (output, value) in Output::ALL.into_iter().zip(row.values) {
                if let Some(Value::Number(x)) = value {
                    numbers.values.insert((output, k), x);
                }
            }
        }
        let label = block.label.to_ascii_uppercase();
        if !frame.forces.is_empty() {
            self.add_forces(known, result, (&label, &numbers), frame);
        }
        if has_variants && frame.elements.contains_key(&label) {
            self.add_variants(known, result, (&label, &numbers));
        }
        known.elements.insert(label, numbers);
    }

    /// The forces of the components: those that follow from the motion, and else those of the files.
    pub(crate) fn component_forces(
        &self,
        result: &ConnectorResult,
        (label, numbers): (&str, &Numbers),
        frame: &Frame,
    ) -> Result<[Option<Printed>; 6], Why> {
        let element = &self.model.connectors[result.index];
        let connector = &element.connector;
        let of_file = |output: Output, k: usize| {
            let all = frame.elements.get(label)?;
            let found = all.iter().find(|(of, component, _)| (*of, *component) == (output, k));
            found.map(|(.., x)| x.times(unit_of(self.map, output, numbers.units[k])))
        };
        let mut forces = [None; 6];
        for k in (0..6).filter(|k| connector.has_force(*k)) {
            let exact = |x: f64| Printed { x, half: 0.0 };
            let is_free = !connector.is_constrained(k) && element.behavior.is_empty();
            let told = numbers.values.get(&(Output::CTF, k)).copied().map(exact);
            let reaction = || of_file(Output::CRF, k).filter(|_| connector.is_constrained(k));
            let force = told.or_else(|| of_file(Output::CTF, k)).or_else(reaction);
            forces[k] = force.or(is_free.then(|| exact(0.0)));
            if forces[k].is_none() {
                return Err(Why::NoForce(Of::Output(Output::CTF, k).name(), element.title()));
            }
        }
        Ok(forces)
    }

    fn add_forces(
        &self,
        known: &mut Known,
        result: &ConnectorResult,
        (label, numbers): (&str, &Numbers),
        frame: &Frame,
    ) {
        let element = &self.model.connectors[result.index];
        let forces = self.component_forces(result, (label, numbers), frame);
        let separation = result.state.pair.separation();
        let axes = [result.state.pair.a.triad, result.state.pair.b.triad];
        let (all, digits) = match &forces {
            Err(_) => ([0.0; 14], [0.0; 14]),
            Ok(forces) => {
                let mask = forces.map(|force| force.is_some());
                let (branch, tally) = (&result.evaluation.branch, &mut Tally::default());
                let rows = element.connector.force_rows(&result.state, branch, mask, Want::default(), tally);
                let mut digits = [0.0; 14];
                for (k, half) in forces.iter().enumerate().filter_map(|(k, of)| Some((k, (*of)?.half))) {
                    let mut one = [None; 6];
                    one[k] = Some(half).filter(|half| *half > 0.0);
                    let part = rows.nodal(&one);
                    digits.iter_mut().zip(part).for_each(|(sum, x)| *sum += x.abs());
                }
                (rows.nodal(&forces.map(|force| force.map(|force| force.x))), digits)
            }
        };
        for (end, node) in element.nodes.iter().enumerate().filter_map(|(end, node)| Some((end, (*node)?))) {
            let at = known.nodes.entry(node.to_string().to_ascii_uppercase()).or_default();
            let own: [f64; 6] = std::array::from_fn(|i| all[7 * end + i]);
            for i in 0..6 {
                at.sum[i] += own[i];
                at.digits[i] += digits[7 * end + i];
            }
            let way = scale(separation, if end == 0 { -1.0 } else { 1.0 });
            at.parts.push(Part { element: label.to_string(), forces: own, way, axes });
            if let Err(why) = &forces {
                at.missing.get_or_insert_with(|| why.clone());
            }
        }
    }

    /// What a force at a node must be, with what the digits of given forces allow.
    ///
    /// # Errors
    /// Why that is not known.
    pub(crate) fn at_node(
        &self,
        known: &Known,
        (node, of): (&str, (Nodal, usize)),
        state: &State,
    ) -> Result<Printed, Why> {
        let Some(label) = self.labels.get(node) else { return Err("the scene has no such node".into()) };
        let Some(at) = known.nodes.get(node) else { return Err("no connector is at that node".into()) };
        let (nodal, i) = of;
        let number = u8::try_from(i + 1).unwrap_or(0);
        if nodal == Nodal::Reaction {
            if !self.held.contains(&Freedom { node: *label, number }) {
                return Ok(Printed::default());
            }
            if let Some(what) = self.others.get(label) {
                return Err(Why::Other(format!("{what} acts there, too")));
            }
            let moves = state.nodes.get(label).is_some_and(|motion| *motion != Default::default());
            if moves && self.masses.contains(label) {
                return Err("inertia acts there, too".into());
            }
        }
        match &at.missing {
            Some(why) => Err(why.clone()),
            None => Ok(Printed { x: at.sum[i], half: at.digits[i] }),
        }
    }

    /// The viscous force of a connector in a number.
    pub(crate) fn viscous(&self, known: &Known, (owner, of): &Key) -> Option<f64> {
        match of {
            Of::Output(Output::CVF | Output::CTF, k) => {
                let numbers = known.elements.get(owner).filter(|numbers| numbers.viscous[*k])?;
                Some(numbers.values.get(&(Output::CVF, *k)).copied().unwrap_or(0.0))
            }
            Of::Output(..) => None,
            Of::Nodal(..) => {
                let parts = &known.nodes.get(owner)?.parts;
                let all = parts.iter().filter_map(|part| known.elements.get(&part.element));
                all.into_iter().any(|numbers| numbers.viscous.contains(&true)).then_some(f64::INFINITY)
            }
        }
    }

    /// The number of a key.
    pub(crate) fn value(&self, known: &Known, (owner, of): &Key, state: &State) -> Option<f64> {
        match of {
            Of::Output(output, k) => known.elements.get(owner)?.values.get(&(*output, *k)).copied(),
            Of::Nodal(nodal, i) => Some(self.at_node(known, (owner, (*nodal, *i)), state).ok()?.x),
        }
    }

    /// Vectors along other axes, and moments about the other node.
    fn add_variants(&self, known: &mut Known, result: &ConnectorResult, (label, numbers): (&str, &Numbers)) {
        let element = &self.model.connectors[result.index];
        let connector = &element.connector;
        let pair = &result.state.pair;
        let blocks = [0, 3].map(|first| is_vector(connector, first));
        let mut put = |of: Of, words: &str, vector: Vector<f64>| {
            let (_, first) = of.place();
            for (i, x) in vector.into_iter().enumerate() {
                let key = (label.to_string(), of.with(first + i));
                known.variants.entry(key).or_default().push((words.to_string(), x));
            }
        };
        let vector = |output: Output, first: usize| {
            let all = [0, 1, 2].map(|i| numbers.values.get(&(output, first + i)).copied());
            Some([all[0]?, all[1]?, all[2]?])
        };
        let [initial_a, initial_b] = element.triads();
        for (first, output) in [0, 3].into_iter().flat_map(|first| OUTPUTS.map(|output| (first, output))) {
            let Some(given) = vector(output, first).filter(|_| blocks[first / 3]) else { continue };
            let of = Of::Output(output, first);
            if first == 0 && output == Output::CU {
                let separation = pair.separation();
                put(of, "it is along global axes", sub(separation, element.reference));
                put(
                    of,
                    "it is along the initial axes of node a",
                    apply_transposed(initial_a, sub(separation, element.reference)),
                );
                let along_b = sub(
                    apply_transposed(&pair.b.triad, separation),
                    apply_transposed(initial_b, element.reference),
                );
                put(of, "it is along the axes of node b", along_b);
                continue;
            }
            let global = apply(&pair.a.triad, given);
            put(of, "it is along global axes", global);
            put(of, "it is along the initial axes of node a", apply_transposed(initial_a, global));
            put(of, "it is along the axes of node b", apply_transposed(&pair.b.triad, global));
        }
        if let Some(own) = vector(Output::CU, 3).filter(|_| numbers.units[3..] == [Some(Unit::Angle); 3]) {
            for (words, angles) in other_angles(result, element.reference, [initial_a, initial_b]) {
                if angles[0] != own {
                    put(Of::Output(Output::CU, 3), &words, angles[0]);
                    put(Of::Output(Output::CP, 3), &words, angles[1]);
                }
            }
        }
        if blocks == [true; 2] {
            let arm = apply_transposed(&pair.a.triad, pair.separation());
            for output in OUTPUTS.into_iter().filter(|output| output.is_force()) {
                if let (Some(force), Some(moment)) = (vector(output, 0), vector(output, 3)) {
                    let more = cross(arm, force);
                    put(Of::Output(output, 3), "it is the moment about node a, not b", add(moment, more));
                    put(
                        Of::Output(output, 3),
                        "it is the moment about node a, not b, with the arm reversed",
                        sub(moment, more),
                    );
                }
            }
        }
    }

    /// Moments about other points, parts of sums, other axes.
    fn add_variants_of_node(&self, known: &mut Known, node: &str, state: &State) {
        let Some(at) = known.nodes.get(node).cloned().filter(|at| at.missing.is_none()) else { return };
        let Some(label) = self.labels.get(node) else { return };
        let mut put = |words: String, first: usize, vector: Vector<f64>| {
            for nodal in [Nodal::Reaction, Nodal::Force] {
                for (i, x) in vector.into_iter().enumerate() {
                    let key = (node.to_string(), Of::Nodal(nodal, first + i));
                    known.variants.entry(key).or_default().push((words.clone(), x));
                }
            }
        };
        let part = |of: &[f64; 6], first: usize| [of[first], of[first + 1], of[first + 2]];
        let (force, moment) = (part(&at.sum, 0), part(&at.sum, 3));
        let moved = state.nodes.get(label).map_or([0.0; 3], |motion| motion.displacement);
        let place = add(self.places.get(label).copied().unwrap_or_default(), moved);
        let about = |way: Vector<f64>| add(moment, cross(way, force));
        for Part { element, way, .. } in &at.parts {
            put(format!("it is a moment about the other node of {element}: M + r × F"), 3, about(*way));
            put(
                format!("it is a moment about the middle of {element}: M + r × F"),
                3,
                about(scale(*way, 0.5)),
            );
        }
        put("it is a moment about the origin: M + r × F".into(), 3, about(place));
        put("it is a moment about the initial place of the node: M + r × F".into(), 3, about(moved));
        for Part { element, forces: own, axes, .. } in &at.parts {
            for first in [0, 3] {
                if at.parts.len() > 1 {
                    put(format!("it is that of element {element} alone"), first, part(own, first));
                }
                for (name, triad) in ["a", "b"].into_iter().zip(axes) {
                    let along = apply_transposed(triad, part(&at.sum, first));
                    put(format!("it is along the axes of node {name} of {element}"), first, along);
                }
            }
        }
    }

    /// By how much each of some numbers changes, as the motion changes by what its digits leave open.
    pub(crate) fn uncertain(
        &self,
        before: &Sequence<'_>,
        (state, frame, right): (&State, &Frame, &Known),
        motions: &Motions,
        suspects: &[Key],
    ) -> Vec<f64> {
        let mut found = vec![0.0; suspects.len()];
        let mut again = before.clone();
        let counts = |label: &Label| {
            suspects.iter().any(|(owner, of)| match of {
                Of::Output(..) => self.ends.get(owner).is_some_and(|ends| ends.contains(&Some(*label))),
                // The force at a node is that of its connectors, which have other nodes.
                Of::Nodal(..) => self.ends.values().any(|ends| {
                    ends.contains(&Some(*label)) && ends.contains(&self.labels.get(owner).copied())
                }),
            })
        };
        for (node, numbers) in &frame.nodes {
            let label =
                motions.labels.get(node).filter(|label| counts(label) && state.nodes.contains_key(*label));
            let Some(label) = label else { continue };
            for (motion, of) in numbers.iter().filter(|(_, of)| of.half > 0.0) {
                let mut moved = state.clone();
                let Some(node) = moved.nodes.get_mut(label) else { continue };
                shift(node, *motion, of.half);
                again.clone_from(before);
                let all = self.at(&mut again, &moved, (frame, false));
                for (found, key) in found.iter_mut().zip(suspects) {
                    if let (Some(one), Some(other)) =
                        (self.value(right, key, state), self.value(&all, key, &moved))
                    {
                        *found += (one - other).abs();
                    }
                }
            }
        }
        found
    }
}

/// What others take for the three angles of a connection, CU and CP (rad): those of other types, and of the sequence 3-2-1. With
/// Q = C_aᵀ C_b = R₃(ψ) R₂(θ) R₁(φ) these are φ = atan2(Q₃₂, Q₃₃), θ = −asin Q₃₁, ψ = atan2(Q₂₁, Q₁₁).
fn other_angles(
    result: &ConnectorResult,
    reference: Vector<f64>,
    [a, b]: [&Matrix<f64>; 2],
) -> Vec<(String, [Vector<f64>; 2])> {
    let node = |triad: &Matrix<f64>| Node { displacement: [0.0; 3], triad: *triad, flow: 0.0 };
    let initial = Pair { reference, a: node(a), b: node(b) };
    let request = Request::new(&[Output::CP, Output::CU], [true; 6], 0);
    let of_type = |name: &str| {
        let connection = ConnectionType::named(name, None).ok()?;
        let connector = Connector::<f64>::new(&Definition::new(connection, initial));
        let (still, tally) = (Increment::none(), &mut Tally::default());
        let found = connector.evaluate(&result.state, &still, &connector.initial_branch(), &request, tally);
        let all = |of: [Option<f64>; 6]| Some([of[3]?, of[4]?, of[5]?]);
        Some((format!("it is what a {name} has"), [all(found.displacement)?, all(found.position)?]))
    };
    let sequence = |pair: &Pair<f64>| {
        let q = product(&transpose(&pair.a.triad), &pair.b.triad);
        [q[2][1].atan2(q[2][2]), (-q[2][0]).clamp(-1.0, 1.0).asin(), q[1][0].atan2(q[0][0])]
    };
    let (now, first) = (sequence(&result.state.pair), sequence(&initial));
    let types = ["ROTATION", "CARDAN", "EULER", "FLEXION-TORSION"].into_iter().filter_map(of_type);
    types.chain([("it is angles in the sequence 3-2-1".to_string(), [sub(now, first), now])]).collect()
}

/// The unit of an output of the file, in the scene's.
pub(crate) fn unit_of(map: &Map, output: Output, unit: Option<Unit>) -> f64 {
    let of_component = match unit {
        Some(Unit::Angle) => map.angles.size(),
        Some(Unit::Length) => map.length,
        _ => 1.0,
    };
    if !output.is_force() {
        return of_component;
    }
    // A force on a rotation is a moment.
    if unit == Some(Unit::Angle) { map.force * map.length } else { map.force }
}
