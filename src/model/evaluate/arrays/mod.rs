//! Arrays of states in, arrays of numbers out.
//!
//! Connectors are taken in parts. Each part goes through all states by itself, so that its nodes and histories stay in the cache, and parts
//! wait for no other. Within a part, connectors of one kind go four at a time ([`pintle_kinematics::batch`]).
//!
//! Numbers differ from those of [`Sequence`](crate::evaluate::Sequence) by the roundings that [`pintle_kinematics::batch`] states: at most 3 of the
//! numbers that a value is computed from, 2.5 for a row. They are the same bits for any number of threads. What a batch does not give is
//! evaluated one connector at a time, and has the bits of `Sequence`: second derivatives, rates, connectors with material flow.

mod part;
mod quad;

use crate::evaluate::model::Model;
use crate::evaluate::plan::Plan;
use crate::evaluate::sequence::Needed;
use part::Part;
use pintle_kinematics::batch::Batch;
use pintle_kinematics::connector::{Connector, Evaluation, Output, Request, Tally};
use pintle_kinematics::node::DOFS;
use pintle_scene::{
    Label, Lack, MAX_ROTATION, NodeFreedom, NodeMotion, QUATERNION_TOLERANCE, Rotation, Scene, State,
};
use rayon::prelude::*;
use std::ops::Range;

/// Numbers by state and node, where they lie: those of node n at state s begin at number s · `of_state` + n · `of_node`.
#[derive(Clone, Copy, Debug)]
pub struct ByNode<'a> {
    numbers: &'a [f64],
    of_state: usize,
    of_node: usize,
}

impl<'a> ByNode<'a> {
    /// Numbers that stand so far apart; 0 for states or nodes that share them.
    pub const fn new(numbers: &'a [f64], of_state: usize, of_node: usize) -> Self {
        Self { numbers, of_state, of_node }
    }

    /// The first N numbers of a node at a state; NaN beyond the end.
    fn at<const N: usize>(&self, state: usize, node: usize) -> [f64; N] {
        let first = state * self.of_state + node * self.of_node;
        let found = self.numbers.get(first..).and_then(|rest| rest.first_chunk());
        found.copied().unwrap_or([f64::NAN; N])
    }
}

/// How rotations since the initial state are given.
#[derive(Clone, Copy, Debug)]
pub enum Rotations<'a> {
    /// Rotation vectors, with their turns (rad).
    Vectors(ByNode<'a>),
    /// Quaternions w, x, y, z of any length but zero.
    Quaternions(ByNode<'a>),
}

/// The motions of nodes at many states, as arrays; what is not given is zero.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeArrays<'a> {
    /// How many states.
    pub count: usize,
    /// The nodes that move. Others stay where they are.
    pub nodes: &'a [Label],
    /// Times, which only behaviours ask for.
    pub times: Option<&'a [f64]>,
    /// u, three numbers.
    pub displacement: Option<ByNode<'a>>,
    /// Rotations.
    pub rotation: Option<Rotations<'a>>,
    /// Time derivative of the displacement.
    pub velocity: Option<ByNode<'a>>,
    /// ω, spatial.
    pub angular_velocity: Option<ByNode<'a>>,
    /// Second time derivative of the displacement.
    pub acceleration: Option<ByNode<'a>>,
    /// ω̇, spatial.
    pub angular_acceleration: Option<ByNode<'a>>,
    /// Material flow and its two time derivatives, one number each.
    pub flow: [Option<ByNode<'a>>; 3],
}

/// What is wrong with an array of motions.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MotionError {
    /// A node that the scene does not have.
    #[error("there is no node {0} in {1}")]
    UnknownNode(Label, String),
    /// A node that comes twice.
    #[error("node {0} occurs twice")]
    RepeatedNode(Label),
    /// An array that is too short.
    #[error("{0} ends before the last node of the last state")]
    Short(&'static str),
    /// A number that is none, or a rotation that cannot be, and how many more there are.
    #[error("{array} of node {node} at state {state} (from 0): {what}{}", more(*.others))]
    Number {
        /// The array.
        array: &'static str,
        /// The state.
        state: usize,
        /// The node.
        node: Label,
        /// What is wrong, and what would be right.
        what: String,
        /// How many others of this array are wrong.
        others: usize,
    },
}

fn more(others: usize) -> String {
    if others == 0 { String::new() } else { format!("; so are {others} others of this array") }
}

impl NodeArrays<'_> {
    /// Whether its nodes are those of a scene, and all numbers finite, rotations up to 1e8 rad and quaternions of norm 1, as in files of states.
    /// No node moves along or about what it has no degree of freedom for.
    ///
    /// # Errors
    /// All that is wrong: the first of each array, with the number of others.
    pub fn check(&self, scene: &Scene, freedom: &NodeFreedom) -> Result<(), Vec<MotionError>> {
        let mut found = Vec::new();
        let unknown = self.nodes.iter().filter(|node| !scene.nodes.contains_key(*node));
        found.extend(unknown.take(SHOWN).map(|node| MotionError::UnknownNode(*node, scene.name.clone())));
        let mut sorted = self.nodes.to_vec();
        sorted.sort_unstable();
        let twice = sorted.windows(2).filter(|pair| pair[0] == pair[1]);
        found.extend(twice.take(SHOWN).map(|pair| MotionError::RepeatedNode(pair[0])));
        fn finite<const N: usize>(of: &[f64; N]) -> Option<String> {
            let wrong = of.iter().find(|x| !x.is_finite())?;
            Some(format!("{wrong} is no finite number"))
        }
        fn held(of: &[f64; 3], lacks: &[Option<Lack>; 3]) -> Option<String> {
            let held = of.iter().zip(lacks).filter(|(part, _)| **part != 0.0);
            let lack = held.filter_map(|(_, lack)| *lack).next()?;
            Some(format!("the node {}; {}", lack.what(), lack.remedy()))
        }
        let lacks: Vec<_> = self.nodes.iter().map(|node| freedom.lacks(*node)).collect();
        let of_moves = |n: usize| lacks.get(n).map_or(&[None; 3], |[moves, _]| moves);
        let of_turns = |n: usize| lacks.get(n).map_or(&[None; 3], |[_, turns]| turns);
        for (name, array) in
            [("u", self.displacement), ("velocity", self.velocity), ("acceleration", self.acceleration)]
        {
            let wrong = |n, of: &[f64; 3]| finite(of).or_else(|| held(of, of_moves(n)));
            self.check_array::<3>((name, array), wrong, &mut found);
        }
        for (name, array) in
            [("angular_velocity", self.angular_velocity), ("angular_acceleration", self.angular_acceleration)]
        {
            let wrong = |n, of: &[f64; 3]| finite(of).or_else(|| held(of, of_turns(n)));
            self.check_array::<3>((name, array), wrong, &mut found);
        }
        for (name, array) in ["flow", "flow_velocity", "flow_acceleration"].into_iter().zip(self.flow) {
            self.check_array::<1>((name, array), |_, of| finite(of), &mut found);
        }
        match self.rotation {
            Some(Rotations::Vectors(of)) => self.check_array::<3>(
                ("rotation_vector", Some(of)),
                |n, of| {
                    let length = of.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
                    let is_right = length <= MAX_ROTATION;
                    let too_large = || format!("a rotation of {length} rad; rotations are in rad, up to 1e8");
                    (!is_right).then(too_large).or_else(|| held(of, of_turns(n)))
                },
                &mut found,
            ),
            Some(Rotations::Quaternions(of)) => self.check_array::<4>(
                ("quaternion", Some(of)),
                |n, of: &[f64; 4]| {
                    let norm = of.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
                    let is_right = (norm - 1.0).abs() <= QUATERNION_TOLERANCE;
                    let unequal_one = || format!("a quaternion of norm {norm}; divide w, x, y, z by it");
                    let [_, x, y, z] = *of;
                    (!is_right).then(unequal_one).or_else(|| held(&[x, y, z], of_turns(n)))
                },
                &mut found,
            ),
            None => {}
        }
        if found.is_empty() { Ok(()) } else { Err(found) }
    }

    fn check_array<const N: usize>(
        &self,
        (array, of): (&'static str, Option<ByNode<'_>>),
        wrong: impl Fn(usize, &[f64; N]) -> Option<String>,
        found: &mut Vec<MotionError>,
    ) {
        let Some(of) = of else { return };
        let (Some(last), Some(end)) = (self.count.checked_sub(1), self.nodes.len().checked_sub(1)) else {
            return;
        };
        if of.numbers.len() < last * of.of_state + end * of.of_node + N {
            found.push(MotionError::Short(array));
            return;
        }
        let mut first = None;
        let mut others = 0;
        for state in 0..self.count {
            for (n, node) in self.nodes.iter().enumerate() {
                let Some(what) = wrong(n, &of.at::<N>(state, n)) else { continue };
                match first {
                    None => first = Some((state, *node, what)),
                    Some(_) => others += 1,
                }
            }
        }
        found.extend(first.map(|(state, node, what)| MotionError::Number {
            array,
            state,
            node,
            what,
            others,
        }));
    }

    /// Writes the motion of a node, by its place in the list. What is not given is left as it is.
    fn put_motion(&self, state: usize, node: usize, motion: &mut NodeMotion) {
        let put = |to: &mut [f64; 3], of: &Option<ByNode<'_>>| {
            if let Some(of) = of {
                *to = of.at(state, node);
            }
        };
        put(&mut motion.displacement, &self.displacement);
        put(&mut motion.velocity, &self.velocity);
        put(&mut motion.angular_velocity, &self.angular_velocity);
        put(&mut motion.acceleration, &self.acceleration);
        put(&mut motion.angular_acceleration, &self.angular_acceleration);
        let flows = [&mut motion.flow, &mut motion.flow_velocity, &mut motion.flow_acceleration];
        for (to, of) in flows.into_iter().zip(&self.flow) {
            if let Some(of) = of {
                [*to] = of.at(state, node);
            }
        }
        match &self.rotation {
            None => {}
            Some(Rotations::Vectors(of)) => motion.rotation = Rotation::Vector(of.at(state, node)),
            Some(Rotations::Quaternions(of)) => motion.rotation = Rotation::Quaternion(of.at(state, node)),
        }
    }

    /// Whether there are rates: velocities or accelerations other than zero.
    pub fn has_rates(&self) -> bool {
        let all = [self.velocity, self.angular_velocity, self.acceleration, self.angular_acceleration];
        let mut all = all.into_iter().chain([self.flow[1], self.flow[2]]).flatten();
        all.any(|of| of.numbers.iter().any(|x| *x != 0.0))
    }

    /// A state by itself.
    pub fn state(&self, state: usize) -> State {
        let nodes = self.nodes.iter().enumerate();
        let motion = |(n, label): (usize, &Label)| {
            let mut motion = NodeMotion::default();
            self.put_motion(state, n, &mut motion);
            (*label, motion)
        };
        State {
            time: self.times.and_then(|times| times.get(state).copied()),
            nodes: nodes.map(motion).collect(),
            ..State::default()
        }
    }
}

/// Where motions come from.
#[derive(Clone, Copy, Debug)]
pub enum Motions<'a> {
    /// Arrays.
    Arrays(&'a NodeArrays<'a>),
    /// States as files hold them.
    States(&'a [State]),
}

impl Motions<'_> {
    /// How many states.
    pub const fn count(&self) -> usize {
        match self {
            Self::Arrays(arrays) => arrays.count,
            Self::States(states) => states.len(),
        }
    }
}

/// Arrays that take numbers, in C order. All of them are written: NaN where a connector has no such number.
#[derive(Debug, Default)]
pub struct Numbers<'a> {
    /// Values (state, connector, 6) of the outputs named.
    pub values: Vec<(Output, &'a mut [f64])>,
    /// Rows (state, connector, 6, 14), from order 1 on.
    pub jacobian: Option<&'a mut [f64]>,
    /// Second derivatives (state, connector, 6, 14, 14), of order 2.
    pub hessian: Option<&'a mut [f64]>,
}

impl Numbers<'_> {
    /// Writes values and what an evaluation has of derivatives at a place: state × connectors + connector.
    pub fn put(&mut self, place: usize, value: impl Fn(Output, usize) -> Option<f64>, of: &Evaluation<f64>) {
        let first = place * 6;
        for (output, array) in &mut self.values {
            for (k, to) in array.iter_mut().skip(first).take(6).enumerate() {
                *to = value(*output, k).unwrap_or(f64::NAN);
            }
        }
        if let Some(array) = &mut self.jacobian {
            for (row, to) in of.jacobian.iter().zip(array.chunks_exact_mut(DOFS).skip(first)) {
                to.copy_from_slice(row.as_ref().unwrap_or(&[f64::NAN; DOFS]));
            }
        }
        if let Some(array) = &mut self.hessian {
            for (matrix, to) in of.hessian.iter().zip(array.chunks_exact_mut(DOFS * DOFS).skip(first)) {
                match matrix {
                    Some(matrix) => to.copy_from_slice(matrix.as_flattened()),
                    None => to.fill(f64::NAN),
                }
            }
        }
    }

    /// Whether the arrays have the numbers of so many states and connectors.
    ///
    /// # Errors
    /// The first of another size.
    pub fn check(&self, states: usize, connectors: usize) -> Result<(), ArrayError> {
        let each = states.saturating_mul(connectors).saturating_mul(6);
        let length = |what, found: usize, expected| {
            if found == expected { Ok(()) } else { Err(ArrayError::Length { what, found, expected }) }
        };
        for (output, values) in &self.values {
            length(output.name(), values.len(), each)?;
        }
        for (what, array, width) in
            [("jacobian", &self.jacobian, DOFS), ("hessian", &self.hessian, DOFS * DOFS)]
        {
            if let Some(array) = array {
                length(what, array.len(), each.saturating_mul(width))?;
            }
        }
        Ok(())
    }
}

/// Why arrays cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ArrayError {
    /// An array of another size.
    #[error("{what} has {found} numbers, and {expected} are needed")]
    Length {
        /// Which.
        what: &'static str,
        /// Its numbers.
        found: usize,
        /// Those needed.
        expected: usize,
    },
    /// An output that needs more than the kinematics of connectors.
    #[error("{0} is none of the outputs that follow from the motion of nodes alone")]
    Output(&'static str),
    /// A behaviour that has to be worked out.
    #[error("what a connector does depends on its behaviour, which arrays do not follow")]
    Behavior,
}

/// Those that lanes give.
const IN_LANES: [Output; 5] = [Output::CP, Output::CU, Output::CCU, Output::RES, Output::TURNS];

/// Connectors whose measures are the same.
struct Kind<'a> {
    connector: &'a Connector<f64>,
    batch: Batch,
}

/// The connectors of a plan, sorted.
struct Sorted<'a> {
    model: &'a Model,
    plan: &'a Plan,
    kinds: Vec<Kind<'a>>,
    /// The kind of each connector of the plan; `None` of those that are taken one at a time.
    kind_of: Vec<Option<u32>>,
}

/// States that follow those before.
struct Given<'m> {
    motions: Motions<'m>,
    /// The nodes of arrays by label.
    columns: Vec<(Label, u32)>,
}

/// Evaluates the connectors of a plan at some states after others, as [`evaluate_arrays`] does at all of them: what is held does not grow
/// with the states.
pub struct ArrayWalk<'a> {
    sorted: Sorted<'a>,
    parts: Vec<Part<'a>>,
}

/// How many nodes are named that cannot be.
const SHOWN: usize = 5;

/// How many connectors go through all states together: enough for fours of each kind, and some parts for the threads.
fn part_size(connectors: usize) -> usize {
    connectors.div_ceil(4).clamp(64, 256)
}

/// Whether all that a plan asks for follows from the motion of the nodes alone, so that [`evaluate_arrays`] gives it.
pub fn is_kinematic(model: &Model, plan: &Plan) -> Result<(), ArrayError> {
    let is_of_nodes =
        |output: Output| output.is_of_motion() || matches!(output, Output::CSLST | Output::TURNS);
    let other = plan.request.outputs().find(|output| !is_of_nodes(*output));
    if let Some(output) = other {
        return Err(ArrayError::Output(output.name()));
    }
    let needs = |index: &usize| {
        let Needed { by_plan, always } = Needed::of(&model.connectors[*index].behavior, &plan.request);
        by_plan || always
    };
    if plan.connectors.iter().any(needs) { Err(ArrayError::Behavior) } else { Ok(()) }
}

/// Evaluates the connectors of a plan at every state, from the initial state of the model on, on the threads of rayon's current pool. Tells what
/// was computed.
///
/// # Errors
/// An array of another size, an output that is not kinematic, a behaviour ([`is_kinematic`]).
pub fn evaluate_arrays(
    model: &Model,
    plan: &Plan,
    motions: Motions<'_>,
    numbers: Numbers<'_>,
) -> Result<Tally, ArrayError> {
    is_kinematic(model, plan)?;
    numbers.check(motions.count(), plan.connectors.len())?;
    let (sorted, given) = (Sorted::new(model, plan), Given::new(motions));
    let arrays = divided(numbers, (motions.count(), plan.connectors.len()));
    let parts: Vec<_> = sorted.parts().zip(arrays).collect();
    let tallies = parts
        .into_par_iter()
        .map(|(members, arrays)| Part::new(&sorted, members).run(&sorted, &given, arrays));
    Ok(tallies.reduce(Tally::default, sum))
}

impl<'a> ArrayWalk<'a> {
    /// A walk that starts from the initial state of the model.
    ///
    /// # Errors
    /// An output that is not kinematic, a behaviour ([`is_kinematic`]).
    pub fn new(model: &'a Model, plan: &'a Plan) -> Result<Self, ArrayError> {
        is_kinematic(model, plan)?;
        let sorted = Sorted::new(model, plan);
        let members: Vec<Range<usize>> = sorted.parts().collect();
        let parts = members.into_par_iter().map(|members| Part::new(&sorted, members)).collect();
        Ok(Self { sorted, parts })
    }

    /// Evaluates the next states. Tells what was computed.
    ///
    /// # Errors
    /// An array of another size. Then nothing is evaluated.
    pub fn advance(&mut self, motions: Motions<'_>, numbers: Numbers<'_>) -> Result<Tally, ArrayError> {
        let connectors = self.sorted.plan.connectors.len();
        numbers.check(motions.count(), connectors)?;
        let given = Given::new(motions);
        let Self { sorted, parts } = self;
        let parts: Vec<_> = parts.iter_mut().zip(divided(numbers, (motions.count(), connectors))).collect();
        let tallies = parts.into_par_iter().map(|(part, arrays)| part.run(sorted, &given, arrays));
        Ok(tallies.reduce(Tally::default, sum))
    }
}

/// What was computed in both.
fn sum(mut sum: Tally, more: Tally) -> Tally {
    sum += more;
    sum
}

impl<'a> Sorted<'a> {
    fn new(model: &'a Model, plan: &'a Plan) -> Self {
        let mut kinds: Vec<Kind<'a>> = Vec::new();
        let request = &plan.request;
        let in_lanes = request.order < 2 && request.outputs().all(|output| IN_LANES.contains(&output));
        let mut last = 0;
        let mut kind = |index: &usize| {
            let connector = &model.connectors[*index].connector;
            let is_known = |kind: &Kind<'_>| kind.connector.has_measures_of(connector);
            let known = kinds.get(last).filter(|kind| is_known(kind)).map(|_| last);
            let known = known.or_else(|| kinds.iter().position(is_known));
            let place = match known {
                Some(place) => place,
                None => {
                    kinds.push(Kind { connector, batch: Batch::new(connector, request.components()).ok()? });
                    kinds.len() - 1
                }
            };
            last = place;
            u32::try_from(place).ok()
        };
        let kind_of = plan.connectors.iter().map(|index| if in_lanes { kind(index) } else { None }).collect();
        Self { model, plan, kinds, kind_of }
    }

    /// The connectors that go through all states together, by their numbers in the plan.
    fn parts(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let connectors = self.plan.connectors.len();
        let size = part_size(connectors);
        (0..connectors).step_by(size).map(move |first| first..connectors.min(first + size))
    }

    const fn request(&self) -> &'a Request {
        &self.plan.request
    }
}

impl<'m> Given<'m> {
    fn new(motions: Motions<'m>) -> Self {
        let mut columns = match motions {
            Motions::Arrays(arrays) => arrays.nodes.iter().copied().zip(0..).collect(),
            Motions::States(_) => Vec::new(),
        };
        columns.sort_unstable();
        Self { motions, columns }
    }

    /// The place of a node in the arrays.
    fn column(&self, label: Label) -> Option<usize> {
        let at = self.columns.binary_search_by_key(&label, |(label, _)| *label).ok()?;
        Some(self.columns[at].1 as usize)
    }

    /// Writes the motion of a node, and tells whether it is given; `column` is its place in arrays.
    fn put_motion(
        &self,
        state: usize,
        (label, column): (Label, Option<usize>),
        motion: &mut NodeMotion,
    ) -> bool {
        let given = match self.motions {
            Motions::Arrays(arrays) => {
                return column.is_some_and(|column| {
                    arrays.put_motion(state, column, motion);
                    true
                });
            }
            Motions::States(states) => states.get(state).and_then(|state| state.nodes.get(&label)),
        };
        *motion = given.copied().unwrap_or_default();
        given.is_some()
    }
}

/// The arrays of each part, state by state.
fn divided(numbers: Numbers<'_>, (states, connectors): (usize, usize)) -> Vec<Vec<Numbers<'_>>> {
    let Numbers { values, jacobian, hessian } = numbers;
    let mut parts: Vec<Vec<Numbers<'_>>> = Vec::new();
    if connectors == 0 {
        return parts;
    }
    // Histories are followed through states of which no number is wanted.
    parts.resize_with(connectors.div_ceil(part_size(connectors)), || {
        let mut of_part = Vec::new();
        of_part.resize_with(states, Numbers::default);
        of_part
    });
    fn give<'a>(
        parts: &mut [Vec<Numbers<'a>>],
        (array, connectors, each): (&'a mut [f64], usize, usize),
        mut put: impl FnMut(&mut Numbers<'a>, &'a mut [f64]),
    ) {
        let size = part_size(connectors) * each;
        for (s, of_state) in array.chunks_exact_mut(connectors * each).enumerate() {
            for (part, of_part) in parts.iter_mut().zip(of_state.chunks_mut(size)) {
                if let Some(numbers) = part.get_mut(s) {
                    put(numbers, of_part);
                }
            }
        }
    }
    for (output, array) in values {
        give(&mut parts, (array, connectors, 6), |own, array| own.values.push((output, array)));
    }
    if let Some(array) = jacobian {
        give(&mut parts, (array, connectors, 6 * DOFS), |own, array| own.jacobian = Some(array));
    }
    if let Some(array) = hessian {
        give(&mut parts, (array, connectors, 6 * DOFS * DOFS), |own, array| own.hessian = Some(array));
    }
    parts
}
