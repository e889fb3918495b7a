//! A connection type, traced: its functions, their rows and second derivatives.

use crate::derivative::Derivation;
use crate::graph::{Graph, Id};
use crate::input::{InputUnit, Inputs, Shape};
use crate::symbol::{Symbol, TraceError, extend};
use pintle_kinematics::catalog::{COMPONENT, Condition, ConnectionType, Slot};
use pintle_kinematics::measure::{History, Measure, Section, Shared};
use pintle_kinematics::node;
use pintle_kinematics::node::{DOF, Node, Pair, Relative};
use pintle_kinematics::scalar::Real;
use pintle_kinematics::vector;
use std::sync::{Arc, Mutex, PoisonError};

/// What the derivatives are taken by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Frame {
    /// d and Q, in the directions of a: d(δ) = d + δ, Q(ρ) = exp(ρ^) Q, components along e_i^a.
    Relative,
    /// The nodes: displacements, triads turned by exp(δθ^), flows; global components, in the order of [`DOF`].
    Nodal,
}

/// The names of the relative variations, in order: along e1a, e2a, e3a.
pub const VARIATION: [&str; 8] = ["δ1", "δ2", "δ3", "ρ1", "ρ2", "ρ3", "Ψa", "Ψb"];

impl Frame {
    /// The names of what derivatives are taken by.
    pub const fn directions(self) -> &'static [&'static str] {
        match self {
            Self::Relative => &VARIATION,
            Self::Nodal => &DOF,
        }
    }

    /// In one word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Relative => "relative",
            Self::Nodal => "nodal",
        }
    }
}

/// A function of a connection type: the position of a component, or what its constraint enforces where that is another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Function {
    /// The component (from 0).
    pub component: usize,
    /// Whether it is the constraint rather than the position.
    pub is_constraint: bool,
    /// The measure.
    pub measure: Measure,
}

impl Function {
    /// Every function of a type, by components.
    pub fn of(connection: &ConnectionType) -> Vec<Self> {
        let mut found = Vec::new();
        for (component, slot) in connection.slots.iter().enumerate() {
            let Some(position) = slot.position() else { continue };
            found.push(Self { component, is_constraint: false, measure: position });
            if let Slot::Constrained(_, Condition::Zero(printed) | Condition::ZeroOrHeld(printed)) = *slot
                && printed != position
            {
                found.push(Self { component, is_constraint: true, measure: printed });
            }
        }
        found
    }

    /// The name: `ur2`, `ur2_constraint`.
    pub fn name(&self) -> String {
        let component = COMPONENT[self.component];
        if self.is_constraint { format!("{component}_constraint") } else { component.to_string() }
    }
}

/// The places of the groups of inputs.
#[derive(Clone, Copy, Debug)]
struct Groups {
    /// Relative: d, Q, Ψa, Ψb. Nodal: X, Ua, A, Ψa, Ub, B, Ψb.
    state: [usize; 7],
    q0: usize,
    length: usize,
    fixed: usize,
    flow_scale: usize,
    reference: usize,
    euler_sign: usize,
    torsion_turns: usize,
}

/// A connection type as expressions.
#[derive(Clone, Debug)]
pub struct Model {
    /// What derivatives are taken by.
    pub frame: Frame,
    /// The expressions.
    pub graph: Graph,
    /// What they are formed from.
    pub inputs: Inputs,
    /// The functions, in the order of the rows.
    pub functions: Vec<Function>,
    /// The principal value of each function; of a one-form, which has none, zero.
    pub values: Vec<Id>,
    /// The row of first derivatives of each function.
    pub jacobian: Vec<Vec<Id>>,
    /// The second derivatives of each function by two variations, rows one after the other; of a one-form how its row changes, in
    /// the nodal frame only.
    pub hessian: Vec<Vec<Id>>,
    needed: Vec<Id>,
}

/// The derivatives of one function.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivatives<R> {
    /// The row of first derivatives.
    pub first: Vec<R>,
    /// The second derivatives, rows one after the other.
    pub second: Vec<R>,
}

fn declare(frame: Frame) -> (Inputs, Groups) {
    use InputUnit::{Angle, AnglePerLength, Length, None};
    let mut inputs = Inputs::default();
    let mut add = |words: [&str; 3], shape, unit| inputs.add(words, shape, unit);
    let state = match frame {
        Frame::Relative => {
            let d = add(
                ["d", "d", "position of b from a, components along e1a, e2a, e3a"],
                Shape::List(3),
                Length,
            );
            let q = add(["Q", "Q", "Q[i][j] = e_i^a . e_j^b, a rotation matrix"], Shape::Matrix, None);
            let psi_a = add(["Psi_a", "Ψa", "material flow at a"], Shape::Scalar, Length);
            let psi_b = add(["Psi_b", "Ψb", "material flow at b"], Shape::Scalar, Length);
            [d, q, psi_a, psi_b, d, q, psi_b]
        }
        Frame::Nodal => {
            let of = "columns are the current directions e1, e2, e3 of";
            let x =
                add(["X", "X", "X_b - X_a, reference position of b from a, global"], Shape::List(3), Length);
            let ua = add(["U_a", "Ua", "displacement of a, global"], Shape::List(3), Length);
            let a = add(["A", "A", &format!("{of} a, global")], Shape::Matrix, None);
            let psi_a = add(["Psi_a", "Ψa", "material flow at a"], Shape::Scalar, Length);
            let ub = add(["U_b", "Ub", "displacement of b, global"], Shape::List(3), Length);
            let b = add(["B", "B", &format!("{of} b, global")], Shape::Matrix, None);
            let psi_b = add(["Psi_b", "Ψb", "material flow at b"], Shape::Scalar, Length);
            [x, ua, a, psi_a, ub, b, psi_b]
        }
    };
    let along = match frame {
        Frame::Relative => "along e1a, e2a, e3a",
        Frame::Nodal => "global and fixed in space",
    };
    let fixed = format!("direction that stands in for d/|d| while the nodes coincide, {along}");
    let q0 = add(["Q0", "Q0", "Q in the initial state"], Shape::Matrix, None);
    let length = add(["l0", "l0", "initial length of the belt segment"], Shape::Scalar, Length);
    let fixed = add(["e_fixed", "e", &fixed], Shape::List(3), None);
    let flow_scale = add(["beta_s", "βs", "factor of the flow at b"], Shape::Scalar, AnglePerLength);
    let reference = "last rotation vector away from whole turns, along e1a, e2a, e3a; initially log(Q0)";
    let reference = add(["phi_ref", "φref", reference], Shape::List(3), Angle);
    let euler_sign =
        add(["s", "s", "sign of sin(beta) on the sheet of the Euler angles, +1 or -1"], Shape::Scalar, None);
    let torsion_turns =
        add(["n_torsion", "n", "whole turns of the torsion, an integer"], Shape::Scalar, None);
    let groups = Groups { state, q0, length, fixed, flow_scale, reference, euler_sign, torsion_turns };
    (inputs, groups)
}

/// What measures need, on symbols.
struct Scene {
    relative: Relative<Symbol>,
    triad_a: vector::Matrix<Symbol>,
    section: Section<Symbol>,
    history: History<Symbol>,
}

impl Scene {
    fn of(frame: Frame, inputs: &Inputs, groups: &Groups) -> Self {
        let (relative, triad_a) = match frame {
            Frame::Relative => {
                let [d, q, psi_a, psi_b, ..] = groups.state;
                let flow = [inputs.scalar(psi_a), inputs.scalar(psi_b)];
                (Relative { d: inputs.vector(d), q: inputs.matrix(q), flow, spin: None }, vector::identity())
            }
            Frame::Nodal => {
                let [x, ua, a, psi_a, ub, b, psi_b] = groups.state;
                let node = |u, triad, flow| Node {
                    displacement: inputs.vector(u),
                    triad: inputs.matrix(triad),
                    flow: inputs.scalar(flow),
                };
                let pair = Pair { reference: inputs.vector(x), a: node(ua, a, psi_a), b: node(ub, b, psi_b) };
                (pair.relative(), pair.a.triad)
            }
        };
        let section = Section {
            initial_orientation: inputs.matrix(groups.q0),
            initial_length: inputs.scalar(groups.length),
            fixed_direction: inputs.vector(groups.fixed),
            flow_scale: inputs.scalar(groups.flow_scale),
        };
        let history = History {
            rotation_vector: inputs.vector(groups.reference),
            euler_sign: inputs.scalar(groups.euler_sign),
            torsion_turns: inputs.scalar(groups.torsion_turns),
        };
        Self { relative, triad_a, section, history }
    }

    fn evaluate(&self, measure: Measure) -> Symbol {
        measure.evaluate(&mut Shared::new(&self.relative, &self.triad_a, &self.section, &self.history))
    }
}

/// How the entries of a matrix of columns change as these turn about direction i: those of e_i^ M.
fn turned(graph: &mut Graph, numbers: &[u32], i: usize) -> Vec<(u32, Id)> {
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let mut changes = Vec::new();
    for column in 0..3 {
        let entry = |row: usize| numbers.get(3 * row + column).copied();
        if let (Some(of_j), Some(of_k)) = (entry(j), entry(k)) {
            let (into_j, into_k) = (graph.input(of_k), graph.input(of_j));
            changes.push((of_j, graph.negate(into_j)));
            changes.push((of_k, into_k));
        }
    }
    changes
}

/// The derivations along the variations of a frame.
fn derivations(graph: &mut Graph, frame: Frame, inputs: &Inputs, groups: &Groups) -> Vec<Derivation> {
    let mut found = Vec::new();
    let one = graph.integer(1);
    let linear = |number| Derivation::along([(number, one)]);
    match frame {
        Frame::Relative => {
            let [d, q, psi_a, psi_b, ..] = groups.state;
            found.extend(inputs.numbers(d).into_iter().map(linear));
            let numbers = inputs.numbers(q);
            found.extend((0..3).map(|i| Derivation::along(turned(graph, &numbers, i))));
            found.extend([psi_a, psi_b].into_iter().flat_map(|psi| inputs.numbers(psi)).map(linear));
        }
        Frame::Nodal => {
            let [_, ua, a, psi_a, ub, b, psi_b] = groups.state;
            for (u, triad, psi) in [(ua, a, psi_a), (ub, b, psi_b)] {
                found.extend(inputs.numbers(u).into_iter().map(linear));
                let numbers = inputs.numbers(triad);
                found.extend((0..3).map(|i| Derivation::along(turned(graph, &numbers, i))));
                found.extend(inputs.numbers(psi).into_iter().map(linear));
            }
        }
    }
    found
}

/// The node (0, 1) that a variation turns, in the nodal frame; the relative rotation counts as one.
fn turns(frame: Frame, variation: usize) -> Option<usize> {
    match (frame, variation) {
        (Frame::Relative, 3..=5) | (Frame::Nodal, 3..=5) => Some(0),
        (Frame::Nodal, 10..=12) => Some(1),
        _ => None,
    }
}

impl Model {
    /// Traces every function of a type, and differentiates it `order` times: 0, 1 or 2.
    ///
    /// # Errors
    /// [`TraceError`] where a formula branches too often.
    ///
    /// ```
    /// use pintle_kinematics::catalog::ConnectionType;
    /// use pintle_symbolic::{Frame, Model};
    /// let revolute = ConnectionType::named("REVOLUTE", None)?;
    /// let model = Model::of(&revolute, Frame::Relative, 1)?;
    /// // Q = I; d does not enter. The row of ur1 = α is that of a turn about e1a.
    /// let mut inputs = vec![0.0; model.inputs.len()];
    /// (inputs[3], inputs[7], inputs[11]) = (1.0, 1.0, 1.0);
    /// assert_eq!(model.graph.evaluate(&model.jacobian[0], &inputs), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(connection: &ConnectionType, frame: Frame, order: u8) -> Result<Self, TraceError> {
        let (inputs, groups) = declare(frame);
        let functions = Function::of(connection);
        let mut graph = Graph::default();
        let mut values = Vec::new();
        for function in &functions {
            let scene = || Scene::of(frame, &inputs, &groups);
            let (extended, [value]) = extend(graph, &[], || [scene().evaluate(function.measure)])?;
            graph = extended;
            values.push(value);
        }
        let mut along = derivations(&mut graph, frame, &inputs, &groups);
        let mut model = Self {
            frame,
            graph,
            inputs,
            functions,
            values,
            jacobian: Vec::new(),
            hessian: Vec::new(),
            needed: Vec::new(),
        };
        if order > 0 {
            model.rows(&groups, &mut along)?;
        }
        if order > 1 {
            model.second(&mut along);
        }
        model.needed = model.graph.reachable(&model.derivatives());
        Ok(model)
    }

    /// The nodal model of second order of a type, traced once; `None` where it cannot be traced.
    pub fn shared(connection: &ConnectionType) -> Option<Arc<Self>> {
        type Known = Vec<([Slot; 6], Arc<Model>)>;
        static KNOWN: Mutex<Known> = Mutex::new(Vec::new());
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, model)) = known.iter().find(|(slots, _)| *slots == connection.slots) {
            return Some(Arc::clone(model));
        }
        let model = Arc::new(Self::of(connection, Frame::Nodal, 2).ok()?);
        known.push((connection.slots, Arc::clone(&model)));
        Some(model)
    }

    fn rows(&mut self, groups: &Groups, along: &mut [Derivation]) -> Result<(), TraceError> {
        for (function, value) in self.functions.iter().zip(&self.values) {
            let row = if function.measure.is_one_form() {
                let (frame, inputs) = (self.frame, &self.inputs);
                let form = || {
                    let scene = Scene::of(frame, inputs, groups);
                    function.measure.one_form::<Symbol>(&scene.triad_a, &scene.section)
                };
                let (graph, row) = extend(std::mem::take(&mut self.graph), &[], form)?;
                self.graph = graph;
                match self.frame {
                    Frame::Nodal => row.to_vec(),
                    // ρ = δθ_b − δθ_a.
                    Frame::Relative => {
                        let zero = self.graph.integer(0);
                        let mut found = vec![zero; 3];
                        found.extend(&row[node::THETA_B..node::PSI_B]);
                        found.extend([row[node::PSI_A], row[node::PSI_B]]);
                        found
                    }
                }
            } else {
                along.iter_mut().map(|derivation| derivation.of(&mut self.graph, *value)).collect()
            };
            self.jacobian.push(row);
        }
        Ok(())
    }

    fn second(&mut self, along: &mut [Derivation]) {
        for (function, row) in self.functions.iter().zip(&self.jacobian) {
            let count = row.len();
            let graph = &mut self.graph;
            // Derivative k of entry j, at j·count + k.
            let mut both: Vec<Id> = Vec::with_capacity(count * count);
            for entry in row {
                both.extend(along.iter_mut().map(|derivation| derivation.of(graph, *entry)));
            }
            if !function.measure.is_one_form() {
                let raw = both.clone();
                for j in 0..count {
                    for k in 0..count {
                        let at = |j: usize, k: usize| raw.get(j * count + k).copied();
                        let (Some(one), Some(other)) = (at(j.min(k), j.max(k)), at(j.max(k), j.min(k)))
                        else {
                            continue;
                        };
                        // Turns of the same body do not commute: the second derivative is the mean of both orders.
                        let body = turns(self.frame, j);
                        let mean = if j != k && body.is_some() && body == turns(self.frame, k) {
                            let half = graph.ratio(1, 2);
                            let sum = graph.add(one, other);
                            graph.multiply(half, sum)
                        } else {
                            one
                        };
                        if let Some(entry) = both.get_mut(j * count + k) {
                            *entry = mean;
                        }
                    }
                }
            }
            self.hessian.push(both);
        }
    }

    /// Every derivative.
    fn derivatives(&self) -> Vec<Id> {
        self.jacobian.iter().chain(&self.hessian).flatten().copied().collect()
    }

    /// The derivatives of each function at a state; those that were not asked for are empty.
    pub fn evaluate<R: Real<Mask = bool>>(&self, inputs: &[R]) -> Vec<Derivatives<R>> {
        let all = self.graph.evaluate_along(&self.needed, &self.derivatives(), inputs);
        let mut left = all.into_iter();
        let firsts: Vec<Vec<R>> =
            self.jacobian.iter().map(|row| left.by_ref().take(row.len()).collect()).collect();
        let mut seconds = self.hessian.iter().map(|all| left.by_ref().take(all.len()).collect::<Vec<R>>());
        firsts
            .into_iter()
            .map(|first| Derivatives { first, second: seconds.next().unwrap_or_default() })
            .collect()
    }

    /// Whether function k has values: a one-form has a row only.
    pub fn has_value(&self, k: usize) -> bool {
        self.functions.get(k).is_some_and(|function| !function.measure.is_one_form())
    }
}

/// The inputs of a nodal model, in their order, at a state.
pub fn nodal_inputs<R: Real>(pair: &Pair<R>, section: &Section<R>, history: &History<R>) -> Vec<R> {
    let mut inputs = Vec::new();
    let node = |inputs: &mut Vec<R>, node: &Node<R>| {
        inputs.extend(node.displacement);
        inputs.extend(node.triad.iter().flatten());
        inputs.push(node.flow);
    };
    inputs.extend(pair.reference);
    node(&mut inputs, &pair.a);
    node(&mut inputs, &pair.b);
    section_inputs(&mut inputs, section, history);
    inputs
}

/// The inputs of a relative model, in their order, at a state; `section.fixed_direction` along e1a, e2a, e3a.
pub fn relative_inputs<R: Real>(
    relative: &Relative<R>,
    section: &Section<R>,
    history: &History<R>,
) -> Vec<R> {
    let mut inputs = relative.d.to_vec();
    inputs.extend(relative.q.iter().flatten());
    inputs.extend(relative.flow);
    section_inputs(&mut inputs, section, history);
    inputs
}

fn section_inputs<R: Real>(inputs: &mut Vec<R>, section: &Section<R>, history: &History<R>) {
    inputs.extend(section.initial_orientation.iter().flatten());
    inputs.push(section.initial_length);
    inputs.extend(section.fixed_direction);
    inputs.push(section.flow_scale);
    inputs.extend(history.rotation_vector);
    inputs.push(history.euler_sign);
    inputs.push(history.torsion_turns);
}
