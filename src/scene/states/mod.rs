//! What the nodes of a scene do: one state, or many in order, from CSV or JSON.
//!
//! # CSV
//! The first line names the columns, in any order; columns that are not there are 0:
//! - `state`, `time`, `node`;
//! - `u1` `u2` `u3` (displacement), `ur1` `ur2` `ur3` (rotation vector) or `q0` `q1` `q2` `q3` (quaternion);
//! - `v1` `v2` `v3`, `vr1` `vr2` `vr3` (spatial angular velocity);
//! - `a1` `a2` `a3`, `ar1` `ar2` `ar3` (spatial angular acceleration);
//! - `flow`, `flow_v`, `flow_a`.
//!
//! Only `node` is needed. Rows with the same number in `state` form one state; the numbers increase, and reports call the states by
//! them. Lines that begin with # are comments. In an assembly, `node` is `INSTANCE.NUMBER`, such as `CRANK-1.5`; likewise in JSON.
//!
//! # JSON
//! `{"schema": "pintle-states/1", "states": [{"time": 0.5, "nodes": {"2": {"displacement": [0, 0, 0], "rotation": [0, 0, 7.5]}}}]}`,
//! with the names of [`NodeMotion`]; `rotation` or `quaternion`. A state may have a `number`, and beside `nodes` component forces
//! by element number: `"forces": {"101": {"f1": 2.5}}` ([`crate::ElementForces`]).

mod degrees;
mod document;
mod faults;
mod source;
mod stream;
mod table;
mod vanish;

use crate::diagnostic::{Code, Diagnostic, Result};
use crate::forces;
use crate::forces::GivenForces;
use crate::freedom::{Lack, NodeFreedom};
use crate::label::{Label, LabelError};
use crate::model::{NodeMotion, Rotation, Scene, State};
use crate::span::{Span, Spanned};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use std::ops::ControlFlow;
use std::path::Path;

pub use degrees::{Degrees, InDegrees, is_in_degrees, told_in_degrees};
pub(super) use document::once;
pub(super) use faults::{Context, Documents, Faults};
pub(super) use source::{Source, is_json, located, located_in, text_of, without_mark};
pub use stream::StateStream;
pub(super) use table::{CsvRow, csv_rows};
pub use vanish::Vanishing;

/// The longest rotation vector, in radians: beyond it a double resolves less than 1e-8 rad.
pub const MAX_ROTATION: f64 = 1e8;

/// By how much the norm of a quaternion may differ from 1.
pub const QUATERNION_TOLERANCE: f64 = 1e-6;

const SCHEMA: &str = "pintle-states/1";

/// What a state is called, and whether it has forces: all that has to be known of it to find it among others.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StateMark {
    /// Its number, if the file numbers its states.
    pub number: Option<u64>,
    /// The time, if it is known.
    pub time: Option<f64>,
    /// Whether it gives component forces.
    pub has_forces: bool,
}

impl StateMark {
    /// That of a state.
    #[must_use]
    pub fn of(state: &State) -> Self {
        Self {
            number: state.number,
            time: state.time,
            has_forces: !(state.forces.is_empty() && state.mpc_forces.is_empty()),
        }
    }
}

/// Takes one state after another, until it breaks off.
type Take<'a> = dyn FnMut(State) -> ControlFlow<()> + 'a;

/// States in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StateFile {
    /// The states; at least one.
    pub states: Vec<State>,
}

impl StateFile {
    /// Reads states of `scene` from a `.csv` or `.json` file.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a remedy.
    pub fn read(path: impl AsRef<Path>, scene: &Scene) -> Result<Self> {
        let (name, text, is_json) = text_of(path.as_ref(), "states")?;
        if is_json { Self::parse_json(&name, &text, scene) } else { Self::parse_csv(&name, &text, scene) }
    }

    /// Reads states from CSV. `name` stands for the file in messages.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a remedy.
    pub fn parse_csv(name: &str, text: &str, scene: &Scene) -> Result<Self> {
        let text = without_mark(text);
        Self::collect(|take| table::states(Source::Text(text), scene, take))
            .map_err(|error| located(error, name, text))
    }

    /// Reads states from JSON. `name` stands for the file in messages.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a remedy.
    pub fn parse_json(name: &str, text: &str, scene: &Scene) -> Result<Self> {
        let text = without_mark(text);
        Self::collect(|take| document::states(Source::Text(text), scene, take))
            .map_err(|error| located(error, name, text))
    }

    fn collect(read: impl FnOnce(&mut Take<'_>) -> Result<()>) -> Result<Self> {
        let mut states = Vec::new();
        read(&mut |state| {
            states.push(state);
            ControlFlow::Continue(())
        })?;
        Ok(Self { states })
    }

    /// The states as JSON; [`parse_json`](Self::parse_json) gives them back bit by bit.
    ///
    /// # Errors
    /// None for finite numbers.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string(self)
    }
}

/// Why a motion cannot be, apart from its place.
pub(super) struct Fault {
    code: Code,
    message: String,
    remedy: String,
}

impl Fault {
    pub(super) fn new(code: Code, message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { code, message: message.into(), remedy: remedy.into() }
    }

    pub(super) fn at(self, span: Span, label: &str) -> Diagnostic {
        Diagnostic::error(self.code, span, self.message, label).help(self.remedy)
    }
}

/// A node or element, as files name it.
pub(super) fn label(text: &str, what: &str) -> Result<Label, Fault> {
    text.parse().map_err(|error: LabelError| {
        let remedy = format!("write the {what} number in digits, and in an assembly INSTANCE.NUMBER");
        Fault::new(Code::StatesMalformedNumber, error.to_string(), remedy)
    })
}

fn check_node(node: Label, scene: &Scene, state: &State) -> Result<(), Fault> {
    if !scene.nodes.contains_key(&node) {
        let remedy = format!("use the node numbers of {}", scene.name);
        return Err(Fault::new(Code::StatesUnknownNode, format!("there is no node {node}"), remedy));
    }
    if state.nodes.contains_key(&node) {
        let message = format!("node {node} occurs twice in one state");
        let remedy = "keep one of the two, or give the second one another state number";
        return Err(Fault::new(Code::StatesRepeatedNode, message, remedy));
    }
    Ok(())
}

fn rotation(vector: Option<[f64; 3]>, quaternion: Option<[f64; 4]>) -> Result<Rotation, Fault> {
    let length = |parts: &[f64]| parts.iter().fold(0.0_f64, |sum, part| sum.hypot(*part));
    match (vector, quaternion) {
        (Some(_), Some(_)) => Err(Fault::new(
            Code::StatesTwoRotations,
            "a rotation vector and a quaternion for one node",
            "give the rotation vector (it counts turns) or the quaternion, not both",
        )),
        (_, Some(quaternion)) => {
            let norm = length(&quaternion);
            if (norm - 1.0).abs() <= QUATERNION_TOLERANCE {
                return Ok(Rotation::Quaternion(quaternion));
            }
            let message = format!("a quaternion of norm {norm}");
            let remedy = "divide q0, q1, q2, q3 by their norm; no rotation is 1, 0, 0, 0";
            Err(Fault::new(Code::StatesQuaternionNorm, message, remedy))
        }
        (vector, None) => {
            let vector = vector.unwrap_or_default();
            let length = length(&vector);
            if length <= MAX_ROTATION {
                return Ok(Rotation::Vector(vector));
            }
            let message = format!("a rotation of {length} rad");
            let remedy = "rotations are in radians, up to 1e8";
            Err(Fault::new(Code::StatesRotationTooLarge, message, remedy))
        }
    }
}

/// States are numbered upwards, or not at all.
///
/// `last` is the number, or none, of the state before, if there is one.
fn check_number(last: Option<Option<u64>>, number: Option<u64>) -> Result<(), Fault> {
    let message = match last.map(|last| (last, number)) {
        Some((Some(last), Some(number))) if number <= last => {
            format!("state {number} comes after state {last}")
        }
        Some((Some(_), None) | (None, Some(_))) => "some states have a number, and some have none".into(),
        _ => return Ok(()),
    };
    Err(Fault::new(Code::StatesOrder, message, "number all states, upwards, or none"))
}

/// What of a motion a node of a connector has no degrees of freedom for.
fn check_motion(node: Label, motion: &NodeMotion, freedom: &NodeFreedom) -> Result<(), Fault> {
    let rotation = match motion.rotation {
        Rotation::Vector(vector) => vector,
        Rotation::Quaternion([_, q1, q2, q3]) => [q1, q2, q3],
    };
    let turns = [rotation, motion.angular_velocity, motion.angular_acceleration];
    let moves = [motion.displacement, motion.velocity, motion.acceleration];
    let [of_moves, of_turns] = freedom.lacks(node);
    let given = |motions: [[f64; 3]; 3], lacks: [Option<Lack>; 3]| {
        motions.into_iter().flat_map(move |motion| motion.into_iter().zip(lacks))
    };
    let lack = given(turns, of_turns).chain(given(moves, of_moves));
    match lack.filter(|(part, _)| *part != 0.0).find_map(|(_, lack)| lack) {
        None => Ok(()),
        Some(lack @ Lack::Rotations) => {
            let message = format!("node {node} is turned and {}", lack.what());
            Err(Fault::new(Code::StatesNoRotation, message, lack.remedy()))
        }
        Some(lack @ Lack::Plane) => {
            let message = format!("node {node} {}", lack.what());
            Err(Fault::new(Code::StatesOutOfPlane, message, lack.remedy()))
        }
    }
}

impl Serialize for StateFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2))?;
        map.serialize_entry("schema", SCHEMA)?;
        map.serialize_entry("states", &self.states)?;
        map.end()
    }
}

impl Serialize for NodeMotion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Motion::from(self).serialize(serializer)
    }
}

/// What a node does. Everything is 0 unless given; components are global.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub(super) struct Motion {
    /// From the initial position.
    #[serde(skip_serializing_if = "is_zero")]
    displacement: [f64; 3],
    /// The rotation vector from the initial orientation, radians. Its length may exceed π and counts turns.
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation: Option<[f64; 3]>,
    /// Instead of it, a quaternion of norm 1, scalar first; turns are not in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    quaternion: Option<[f64; 4]>,
    /// Time derivative of the displacement.
    #[serde(skip_serializing_if = "is_zero")]
    velocity: [f64; 3],
    /// Spatial angular velocity.
    #[serde(skip_serializing_if = "is_zero")]
    angular_velocity: [f64; 3],
    /// Time derivative of the velocity.
    #[serde(skip_serializing_if = "is_zero")]
    acceleration: [f64; 3],
    /// Spatial angular acceleration.
    #[serde(skip_serializing_if = "is_zero")]
    angular_acceleration: [f64; 3],
    /// Material flow (degree of freedom 10), a length.
    #[serde(skip_serializing_if = "vanishes")]
    flow: f64,
    /// Time derivative of the flow.
    #[serde(skip_serializing_if = "vanishes")]
    flow_velocity: f64,
    /// Second time derivative of the flow.
    #[serde(skip_serializing_if = "vanishes")]
    flow_acceleration: f64,
}

/// Nothing is lost when it is left out: −0 is something.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn vanishes(value: &f64) -> bool {
    value.to_bits() == 0
}

fn is_zero(vector: &[f64; 3]) -> bool {
    vector.iter().all(vanishes)
}

impl From<&NodeMotion> for Motion {
    fn from(motion: &NodeMotion) -> Self {
        let (rotation, quaternion) = match motion.rotation {
            Rotation::Vector(vector) if is_zero(&vector) => (None, None),
            Rotation::Vector(vector) => (Some(vector), None),
            Rotation::Quaternion(quaternion) => (None, Some(quaternion)),
        };
        Self {
            displacement: motion.displacement,
            rotation,
            quaternion,
            velocity: motion.velocity,
            angular_velocity: motion.angular_velocity,
            acceleration: motion.acceleration,
            angular_acceleration: motion.angular_acceleration,
            flow: motion.flow,
            flow_velocity: motion.flow_velocity,
            flow_acceleration: motion.flow_acceleration,
        }
    }
}

impl Motion {
    fn checked(self) -> Result<NodeMotion, Fault> {
        Ok(NodeMotion {
            displacement: self.displacement,
            rotation: rotation(self.rotation, self.quaternion)?,
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
            acceleration: self.acceleration,
            angular_acceleration: self.angular_acceleration,
            flow: self.flow,
            flow_velocity: self.flow_velocity,
            flow_acceleration: self.flow_acceleration,
        })
    }
}

/// A state that a scene itself gives; the names of the entries are node numbers and element numbers.
#[derive(Debug)]
pub(super) struct Given {
    pub(super) number: Option<u64>,
    pub(super) time: Option<f64>,
    pub(super) nodes: Vec<(Spanned<String>, Motion)>,
    pub(super) forces: GivenForces,
}

/// The states that a scene itself gives.
pub(super) fn of_scene(
    states: impl IntoIterator<Item = Spanned<Given>>,
    scene: &Scene,
) -> Result<Vec<State>> {
    let mut read = Vec::new();
    let mut faults = Faults::default();
    let freedom = NodeFreedom::of(scene);
    for Spanned { value: Given { number, time, nodes, forces }, span } in states {
        if let Err(fault) = check_number(read.last().map(|last: &State| last.number), number) {
            faults.add(fault.at(span, "this state"));
        }
        let mut state = State { number, time, ..State::default() };
        let given = forces::of_scene(forces, scene, &mut faults);
        (state.forces, state.mpc_forces) = (given.elements, given.mpcs);
        for (name, motion) in nodes {
            let node =
                label(&name.value, "node").and_then(|node| check_node(node, scene, &state).map(|()| node));
            let motion = node.and_then(|node| {
                let motion = motion.checked()?;
                check_motion(node, &motion, &freedom).map(|()| (node, motion))
            });
            match motion {
                Ok((node, motion)) => {
                    state.nodes.insert(node, motion);
                }
                Err(fault) => faults.add(fault.at(name.span, "this node")),
            }
        }
        read.push(state);
    }
    faults.end().map(|()| read)
}
