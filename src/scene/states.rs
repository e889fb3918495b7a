//! What the nodes of a scene do: one state, or many in order, from CSV or JSON.
//!
//! # CSV
//! The first line names the columns, in any order; columns that are not there are 0:
//! `state`, `time`, `node`, `u1` `u2` `u3` (displacement), `ur1` `ur2` `ur3` (rotation vector) or `q0` `q1` `q2`
//! `q3` (quaternion), `v1` `v2` `v3`, `vr1` `vr2` `vr3` (spatial angular velocity), `a1` `a2` `a3`, `ar1` `ar2`
//! `ar3` (spatial angular acceleration), `flow`, `flow_v`, `flow_a`. Only `node` is needed. Rows with the same
//! number in `state` form one state; the numbers increase, and reports call the states by them. Lines that begin with #
//! are comments.
//! In an assembly, `node` is `INSTANCE.NUMBER`, such as `CRANK-1.5`; likewise in JSON.
//!
//! # JSON
//! `{"schema": "pintle-states/1", "states": [{"time": 0.5, "nodes": {"2": {"displacement": [0, 0, 0],
//! "rotation": [0, 0, 7.5]}}}]}`, with the names of [`NodeMotion`]; `rotation` or `quaternion`. A state may have a
//! `number`, and beside `nodes` component forces by element number: `"forces": {"101": {"f1": 2.5}}` ([`super::ElementForces`]).

use super::diagnostic::{Code, Diagnostic, Result, suggest};
use super::forces::{self, ElementForces, ForceSign, GivenForces, JsonForces};
use super::freedom::NodeFreedom;
use super::label::{Label, LabelError};
use super::lexer::{NotANumber, parse_number};
use super::model::Scene;
use super::span::{Span, Spanned};
use schemars::JsonSchema;
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// The longest rotation vector, in radians: beyond it a double resolves less than 1e-8 rad.
pub const MAX_ROTATION: f64 = 1e8;

/// By how much the norm of a quaternion may differ from 1.
const QUATERNION_TOLERANCE: f64 = 1e-6;

const BYTE_ORDER_MARK: char = '\u{feff}';

const SCHEMA: &str = "pintle-states/1";

/// The total rotation of a node from its initial orientation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rotation {
    /// Rotation vector, radians: R = exp(θ^). Its length may exceed π and counts turns.
    Vector([f64; 3]),
    /// Quaternion q0, q1, q2, q3 (scalar first), of norm 1 within 1e-6. Turns are not in it.
    Quaternion([f64; 4]),
}

impl Default for Rotation {
    fn default() -> Self {
        Self::Vector([0.0; 3])
    }
}

/// What a node does. Everything is 0 unless given; components are global.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NodeMotion {
    /// From the initial position.
    pub displacement: [f64; 3],
    /// From the initial orientation.
    pub rotation: Rotation,
    /// Time derivative of the displacement.
    pub velocity: [f64; 3],
    /// Spatial angular velocity ω, with Ṙ = ω^ R.
    pub angular_velocity: [f64; 3],
    /// Time derivative of the velocity.
    pub acceleration: [f64; 3],
    /// Spatial angular acceleration ω̇.
    pub angular_acceleration: [f64; 3],
    /// Material flow Ψ (degree of freedom 10), a length.
    pub flow: f64,
    /// Time derivative of the flow.
    pub flow_velocity: f64,
    /// Second time derivative of the flow.
    pub flow_acceleration: f64,
}

/// The motions of all nodes that move, at one time.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct State {
    /// Its number, if the file numbers its states: the column `state`, or `number` in JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<u64>,
    /// The time, if it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Motions by node number. A node that is not in it is at rest in its initial place.
    pub nodes: BTreeMap<Label, NodeMotion>,
    /// Component forces by element number, where they are given.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub forces: BTreeMap<Label, ElementForces>,
    /// The forces and moments that multi-point constraints put on their first nodes, by their nodes (`10-20-30`), where they are
    /// given: residual-side, global components.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub mpc_forces: BTreeMap<String, ElementForces>,
}

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
    /// The first thing that is wrong with it, with its place and a remedy.
    pub fn read(path: impl AsRef<Path>, scene: &Scene) -> Result<Self> {
        let (name, text, is_json) = text_of(path.as_ref(), "states")?;
        if is_json { Self::parse_json(&name, &text, scene) } else { Self::parse_csv(&name, &text, scene) }
    }

    /// Reads states from CSV. `name` stands for the file in messages.
    ///
    /// # Errors
    /// The first thing that is wrong with it, with its place and a remedy.
    pub fn parse_csv(name: &str, text: &str, scene: &Scene) -> Result<Self> {
        let text = without_mark(text);
        csv_states(text, scene).map_err(|error| located(error, name, text))
    }

    /// Reads states from JSON. `name` stands for the file in messages.
    ///
    /// # Errors
    /// The first thing that is wrong with it, with its place and a remedy.
    pub fn parse_json(name: &str, text: &str, scene: &Scene) -> Result<Self> {
        let text = without_mark(text);
        json_states(text, scene).map_err(|error| located(error, name, text))
    }

    /// The states as JSON; [`parse_json`](Self::parse_json) gives them back bit by bit.
    ///
    /// # Errors
    /// None for finite numbers.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string(self)
    }
}

/// The name and text of a file of `what`, and whether it is JSON rather than CSV.
pub(super) fn text_of(path: &Path, what: &str) -> Result<(String, String, bool)> {
    let name = path.display().to_string();
    let fail = |code, message: String, remedy: &str| {
        Diagnostic::error(code, Span::default(), message, "").help(remedy).in_file(&name)
    };
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    let is_json = match ending.as_ref().and_then(|ending| ending.to_str()) {
        Some("csv") => false,
        Some("json") => true,
        _ => {
            let remedy = format!("name the file of {what} .csv or .json, as it is written");
            return Err(fail(Code::UnknownFormat, "neither .csv nor .json".to_string(), &remedy));
        }
    };
    let text = std::fs::read_to_string(path).map_err(|error| {
        fail(Code::Unreadable, format!("cannot be read: {error}"), "check the path and its permissions")
    })?;
    Ok((name, text, is_json))
}

pub(super) fn without_mark(text: &str) -> &str {
    text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)
}

pub(super) fn located(error: Diagnostic, name: &str, text: &str) -> Diagnostic {
    let mut errors = [error];
    Diagnostic::attach(&mut errors, name, text.as_bytes());
    let [error] = errors;
    error
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
fn check_number(last: Option<&State>, number: Option<u64>) -> Result<(), Fault> {
    let message = match last.map(|last| (last.number, number)) {
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
    if freedom.is_fixed_in_rotation(node) && turns.as_flattened().iter().any(|part| *part != 0.0) {
        let message = format!("node {node} is turned and has no rotational degrees of freedom");
        let remedy = "leave its rotation and angular rates out; JOIN, AXIAL, LINK and ends without an orientation give none, an \
                      element ROTARYI does";
        return Err(Fault::new(Code::StatesNoRotation, message, remedy));
    }
    let leaves = moves.iter().any(|[_, _, along]| *along != 0.0)
        || turns.iter().any(|[first, second, _]| *first != 0.0 || *second != 0.0);
    if freedom.is_planar(node) && leaves {
        let message = format!("node {node} of a two-dimensional element leaves the plane");
        let remedy = "CONN2D2 has the degrees of freedom 1, 2, 6 and 10: give u1, u2, ur3, flow and their rates, or use CONN3D2";
        return Err(Fault::new(Code::StatesOutOfPlane, message, remedy));
    }
    Ok(())
}

const COLUMNS: [&str; 28] = [
    "state", "time", "node", "u1", "u2", "u3", "ur1", "ur2", "ur3", "q0", "q1", "q2", "q3", "v1", "v2", "v3",
    "vr1", "vr2", "vr3", "a1", "a2", "a3", "ar1", "ar2", "ar3", "flow", "flow_v", "flow_a",
];

/// Hands on the rows of a table, whose columns `find` knows by the fields of its first line; `known` lists them.
pub(super) fn csv_rows(
    text: &str,
    known: &[&'static str],
    find: impl Fn(&str) -> Option<&'static str>,
    needed: &'static str,
    mut take: impl FnMut(&CsvRow<'_>) -> Result<()>,
) -> Result<()> {
    // A comment that ends the file without a line break would be read as an empty row.
    let lines = io::Read::chain(text.as_bytes(), b"\n".as_slice());
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(lines);
    let malformed = |error: &csv::Error| {
        let span = error.position().map(place).unwrap_or_default();
        Diagnostic::error(Code::StatesMalformed, span, format!("malformed CSV: {error}"), "here")
            .help(format!("separate fields by commas, one row per {needed} and state"))
    };
    let mut record = csv::StringRecord::new();
    // A line of blanks is none, as an empty one.
    let mut next = |record: &mut csv::StringRecord| loop {
        let is_there = reader.read_record(record).map_err(|error| malformed(&error))?;
        if !(is_there && record.len() == 1 && record.iter().all(str::is_empty)) {
            return Ok(is_there);
        }
    };
    if !next(&mut record)? {
        return Err(empty("columns"));
    }
    let columns = header_columns(&record, row_span(&record, text), known, find, needed)?;
    let mut is_empty = true;
    while next(&mut record)? {
        let span = row_span(&record, text);
        if record.len() != columns.len() {
            let message = format!("a row of {} fields under a header of {}", record.len(), columns.len());
            return Err(Diagnostic::error(Code::StatesMalformed, span, message, "this row")
                .help("give every row as many fields as the header; an empty field is 0"));
        }
        take(&CsvRow { record: &record, columns: &columns, span, text })?;
        is_empty = false;
    }
    if is_empty { Err(empty("rows")) } else { Ok(()) }
}

fn csv_states(text: &str, scene: &Scene) -> Result<StateFile> {
    let freedom = NodeFreedom::of(scene);
    let mut states: Vec<(u64, State)> = Vec::new();
    let find = |field: &str| COLUMNS.into_iter().find(|column| *column == field);
    csv_rows(text, &COLUMNS, find, "node", |row| {
        let span = row.span;
        let (number, time) = (row.integer("state")?.unwrap_or(0), row.number("time")?);
        let disorder = |message: String, remedy: &str| {
            Err(Diagnostic::error(Code::StatesOrder, span, message, "this row").help(remedy))
        };
        match states.last_mut() {
            Some((last, state)) if *last == number => {
                if state.time != time {
                    let message = format!("state {number} has rows of different time");
                    return disorder(
                        message,
                        "give all rows of a state the same time, or another state number",
                    );
                }
            }
            Some((last, _)) if *last > number => {
                let message = format!("state {number} comes after state {last}");
                return disorder(message, "put the rows of a state together, and number the states upwards");
            }
            _ => {
                let own = row.has("state").then_some(number);
                states.push((number, State { number: own, time, ..State::default() }));
            }
        }
        let Some((_, state)) = states.last_mut() else { return Ok(()) };
        let Some(node) = row.label("node")? else {
            return Err(Diagnostic::error(
                Code::StatesMalformedNumber,
                span,
                "a row without a node",
                "this row",
            )
            .help("give the node number in the column `node`"));
        };
        check_node(node, scene, state).map_err(|fault| fault.at(row.place("node"), "this node"))?;
        let motion = row.motion()?;
        check_motion(node, &motion, &freedom).map_err(|fault| fault.at(span, "this row"))?;
        state.nodes.insert(node, motion);
        Ok(())
    })?;
    Ok(StateFile { states: states.into_iter().map(|(_, state)| state).collect() })
}

fn empty(what: &str) -> Diagnostic {
    Diagnostic::error(Code::StatesEmpty, Span::default(), format!("the file has no {what}"), "")
        .help("give a header line and at least one row, or leave out --states for the initial state")
}

fn place(position: &csv::Position) -> Span {
    Span::new(0, u32::try_from(position.line()).unwrap_or(u32::MAX), position.byte(), 0)
}

/// The first line of a record, after the blank lines and comments that its position may include.
fn row_span(record: &csv::StringRecord, text: &str) -> Span {
    let Some(position) = record.position() else { return Span::default() };
    let (mut start, mut line) = (position.byte(), u32::try_from(position.line()).unwrap_or(u32::MAX));
    let rest = usize::try_from(start).ok().and_then(|start| text.get(start..)).unwrap_or_default();
    for whole in rest.split_inclusive('\n') {
        let content = whole.trim_end();
        if !content.is_empty() && !content.starts_with('#') {
            return Span::new(0, line, start, content.len());
        }
        (start, line) = (start + whole.len() as u64, line.saturating_add(1));
    }
    Span::new(0, line, start, 0)
}

fn header_columns(
    record: &csv::StringRecord,
    span: Span,
    known: &[&'static str],
    find: impl Fn(&str) -> Option<&'static str>,
    needed: &'static str,
) -> Result<Vec<&'static str>> {
    let mut columns: Vec<&'static str> = Vec::with_capacity(record.len());
    for field in record {
        let Some(column) = find(field) else {
            let remedy =
                suggest(field, known.iter().copied(), || format!("columns are {}", known.join(", ")));
            let message = format!("there is no column `{field}`");
            return Err(
                Diagnostic::error(Code::StatesUnknownColumn, span, message, "the header").help(remedy)
            );
        };
        if columns.contains(&column) {
            let message = format!("the column `{column}` occurs twice");
            return Err(Diagnostic::error(Code::StatesRepeatedColumn, span, message, "the header")
                .help("remove one of the two"));
        }
        columns.push(column);
    }
    if !columns.contains(&needed) {
        let message = format!("no column `{needed}`");
        return Err(Diagnostic::error(Code::StatesMissingColumn, span, message, "the header")
            .help(format!("name the column of {needed} numbers `{needed}`")));
    }
    Ok(columns)
}

pub(super) struct CsvRow<'a> {
    record: &'a csv::StringRecord,
    columns: &'a [&'static str],
    span: Span,
    text: &'a str,
}

impl CsvRow<'_> {
    fn has(&self, column: &str) -> bool {
        self.columns.contains(&column)
    }

    pub(super) const fn span(&self) -> Span {
        self.span
    }

    pub(super) fn field(&self, column: &str) -> Option<&str> {
        let index = self.columns.iter().position(|known| *known == column)?;
        self.record.get(index).filter(|field| !field.is_empty())
    }

    /// Where a field stands; the whole row if it has quotation marks.
    pub(super) fn place(&self, column: &str) -> Span {
        let index = self.columns.iter().position(|known| *known == column);
        let start = usize::try_from(self.span.start()).unwrap_or(usize::MAX);
        let row =
            self.text.get(start..).and_then(|rest| rest.lines().next()).filter(|row| !row.contains('"'));
        let (Some(index), Some(row)) = (index, row) else { return self.span };
        let before: usize = row.split(',').take(index).map(|field| field.len() + 1).sum();
        let field = row.split(',').nth(index).unwrap_or_default();
        let lead = field.len() - field.trim_start().len();
        Span::new(0, self.span.line(), (start + before + lead) as u64, field.trim().len())
    }

    pub(super) fn number(&self, column: &str) -> Result<Option<f64>> {
        let Some(field) = self.field(column) else { return Ok(None) };
        parse_number(field).map(Some).map_err(|why| {
            let (code, message, remedy) = match why {
                NotANumber::Malformed => (
                    Code::StatesMalformedNumber,
                    format!("`{field}` in column {column} is not a number"),
                    "write numbers like 1, 0.5 or 1e-3; states are finite",
                ),
                NotANumber::OutOfRange => (
                    Code::StatesNumberOutOfRange,
                    format!("{field} in column {column} does not fit into a double"),
                    "doubles reach from 5e-324 to 1.8e308",
                ),
            };
            Diagnostic::error(code, self.place(column), message, format!("column {column}")).help(remedy)
        })
    }

    pub(super) fn integer(&self, column: &str) -> Result<Option<u64>> {
        let Some(field) = self.field(column) else { return Ok(None) };
        field.parse().map(Some).map_err(|_| {
            let message = format!("`{field}` in column {column} is not a whole number");
            Diagnostic::error(
                Code::StatesMalformedNumber,
                self.place(column),
                message,
                format!("column {column}"),
            )
            .help("write digits only")
        })
    }

    pub(super) fn label(&self, column: &str) -> Result<Option<Label>> {
        let Some(field) = self.field(column) else { return Ok(None) };
        label(field, column)
            .map(Some)
            .map_err(|fault| fault.at(self.place(column), &format!("column {column}")))
    }

    /// The numbers of several columns; none when all of them are empty or absent.
    fn numbers<const N: usize>(&self, columns: [&str; N]) -> Result<Option<[f64; N]>> {
        let mut values = [0.0; N];
        let mut given = false;
        for (value, column) in values.iter_mut().zip(columns) {
            if let Some(number) = self.number(column)? {
                (*value, given) = (number, true);
            }
        }
        Ok(given.then_some(values))
    }

    fn motion(&self) -> Result<NodeMotion> {
        let vector = |columns| Ok(self.numbers::<3>(columns)?.unwrap_or_default());
        let rotation =
            rotation(self.numbers(["ur1", "ur2", "ur3"])?, self.numbers(["q0", "q1", "q2", "q3"])?)
                .map_err(|fault| fault.at(self.span, "this row"))?;
        Ok(NodeMotion {
            displacement: vector(["u1", "u2", "u3"])?,
            rotation,
            velocity: vector(["v1", "v2", "v3"])?,
            angular_velocity: vector(["vr1", "vr2", "vr3"])?,
            acceleration: vector(["a1", "a2", "a3"])?,
            angular_acceleration: vector(["ar1", "ar2", "ar3"])?,
            flow: self.number("flow")?.unwrap_or(0.0),
            flow_velocity: self.number("flow_v")?.unwrap_or(0.0),
            flow_acceleration: self.number("flow_a")?.unwrap_or(0.0),
        })
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
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    let freedom = NodeFreedom::of(scene);
    for Spanned { value: Given { number, time, nodes, forces }, span } in states {
        check_number(read.last(), number).map_err(|fault| fault.at(span, "this state"))?;
        let mut state = State { number, time, ..State::default() };
        let given = forces::of_scene(forces, scene)?;
        (state.forces, state.mpc_forces) = (given.elements, given.mpcs);
        for (name, motion) in nodes {
            let node =
                label(&name.value, "node").and_then(|node| check_node(node, scene, &state).map(|()| node));
            let motion = node.and_then(|node| {
                let motion = motion.checked()?;
                check_motion(node, &motion, &freedom).map(|()| (node, motion))
            });
            let (node, motion) = motion.map_err(|fault| fault.at(name.span, "this node"))?;
            state.nodes.insert(node, motion);
        }
        read.push(state);
    }
    Ok(read)
}

/// Carries the scene, and the fault of our own that stopped the reading, through serde.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    pub(super) scene: &'a Scene,
    freedom: &'a NodeFreedom,
    fault: &'a Cell<Option<Fault>>,
}

impl Context<'_> {
    pub(super) fn stop<E: serde::de::Error>(self, fault: Fault) -> E {
        let error = E::custom(&fault.message);
        self.fault.set(Some(fault));
        error
    }
}

fn json_states(text: &str, scene: &Scene) -> Result<StateFile> {
    let form = format!(
        "{{\"schema\": \"{SCHEMA}\", \"states\": [{{\"time\": 0, \"nodes\": {{\"1\": {{\"displacement\": [0, 0, 0]}}}}}}]}}"
    );
    let states = read_json(text, scene, &form, |context, reader| JsonFile(context).deserialize(reader))?;
    Ok(StateFile { states })
}

/// What a document with `states` holds, of which there must be one; `form` shows an example in the remedy.
pub(super) fn read_json<T>(
    text: &str,
    scene: &Scene,
    form: &str,
    read: impl FnOnce(Context<'_>, &mut JsonReader<'_>) -> Result<Vec<T>, serde_json::Error>,
) -> Result<Vec<T>> {
    let fault = Cell::new(None);
    let mut reader = serde_json::Deserializer::from_str(text);
    let freedom = NodeFreedom::of(scene);
    let context = Context { scene, freedom: &freedom, fault: &fault };
    let result = read(context, &mut reader).and_then(|states| reader.end().map(|()| states));
    let states = result.map_err(|error| {
        let span = json_place(text, error.line(), error.column());
        match fault.take() {
            Some(fault) => fault.at(span, "ends here"),
            None => {
                let message = error.to_string();
                let message = message.split(" at line ").next().unwrap_or_default().to_owned();
                let remedy = format!("the form is {form}");
                Diagnostic::error(Code::StatesMalformed, span, message, "here").help(remedy)
            }
        }
    })?;
    if states.is_empty() { Err(empty("states")) } else { Ok(states) }
}

/// A document that is being read.
pub(super) type JsonReader<'a> = serde_json::Deserializer<serde_json::de::StrRead<'a>>;

/// The byte at 1-based `line` and `column` (in bytes).
fn json_place(text: &str, line: usize, column: usize) -> Span {
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let start = (before + column.saturating_sub(1)).min(text.len());
    Span::new(0, u32::try_from(line.max(1)).unwrap_or(u32::MAX), start as u64, 1)
}

/// One JSON object or array, read with the scene at hand.
macro_rules! seed {
    ($name:ident, $output:ty, $method:ident, $expecting:literal) => {
        struct $name<'a>(Context<'a>);

        impl<'de> DeserializeSeed<'de> for $name<'_> {
            type Value = $output;
            fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<$output, D::Error> {
                deserializer.$method(self)
            }
        }

        impl $name<'_> {
            fn describe(formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str($expecting)
            }
        }
    };
}

seed!(JsonFile, Vec<State>, deserialize_map, "an object with `schema` and `states`");
seed!(JsonStates, Vec<State>, deserialize_seq, "an array of states");
seed!(JsonState, State, deserialize_map, "an object with `time`, `nodes` and `forces`");
seed!(JsonNodes, State, deserialize_map, "an object with a motion for each node number");

pub(super) fn once<E: serde::de::Error>(seen: bool, name: &'static str) -> Result<(), E> {
    if seen { Err(E::duplicate_field(name)) } else { Ok(()) }
}

impl<'de> Visitor<'de> for JsonFile<'_> {
    type Value = Vec<State>;
    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Self::describe(formatter)
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Vec<State>, A::Error> {
        let (mut schema, mut states) = (false, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "schema" => {
                    once(schema, "schema")?;
                    schema = true;
                    let written: String = map.next_value()?;
                    if written != SCHEMA {
                        let message = format!("the schema is `{written}`");
                        let remedy = format!("write \"schema\": \"{SCHEMA}\"");
                        return Err(self.0.stop(Fault::new(Code::StatesMalformed, message, remedy)));
                    }
                }
                "states" => {
                    once(states.is_some(), "states")?;
                    states = Some(map.next_value_seed(JsonStates(self.0))?);
                }
                other => return Err(A::Error::unknown_field(other, &["schema", "states"])),
            }
        }
        if !schema {
            return Err(A::Error::missing_field("schema"));
        }
        states.ok_or_else(|| A::Error::missing_field("states"))
    }
}

impl<'de> Visitor<'de> for JsonStates<'_> {
    type Value = Vec<State>;
    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Self::describe(formatter)
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Vec<State>, A::Error> {
        let mut states = Vec::new();
        while let Some(state) = sequence.next_element_seed(JsonState(self.0))? {
            check_number(states.last(), state.number).map_err(|fault| self.0.stop(fault))?;
            states.push(state);
        }
        Ok(states)
    }
}

impl<'de> Visitor<'de> for JsonState<'_> {
    type Value = State;
    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Self::describe(formatter)
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<State, A::Error> {
        let (mut number, mut time, mut state, mut forces) = (None, None, None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "number" => {
                    once(number.is_some(), "number")?;
                    number = Some(map.next_value::<u64>()?);
                }
                "time" => {
                    once(time.is_some(), "time")?;
                    time = Some(map.next_value::<f64>()?);
                }
                "nodes" => {
                    once(state.is_some(), "nodes")?;
                    state = Some(map.next_value_seed(JsonNodes(self.0))?);
                }
                "forces" => {
                    once(forces.is_some(), "forces")?;
                    let of_state = JsonForces { context: self.0, sign: ForceSign::Internal };
                    forces = Some(map.next_value_seed(of_state)?);
                }
                other => return Err(A::Error::unknown_field(other, &["number", "time", "nodes", "forces"])),
            }
        }
        let state: State = state.ok_or_else(|| A::Error::missing_field("nodes"))?;
        let forces::Forces { elements, mpcs } = forces.unwrap_or_default();
        Ok(State { number, time, forces: elements, mpc_forces: mpcs, ..state })
    }
}

impl<'de> Visitor<'de> for JsonNodes<'_> {
    type Value = State;
    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Self::describe(formatter)
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<State, A::Error> {
        let mut state = State::default();
        while let Some(key) = map.next_key::<String>()? {
            let node = label(&key, "node").map_err(|fault| self.0.stop(fault))?;
            check_node(node, self.0.scene, &state).map_err(|fault| self.0.stop(fault))?;
            let motion: Motion = map.next_value()?;
            let motion = motion.checked().map_err(|fault| self.0.stop(fault))?;
            check_motion(node, &motion, self.0.freedom).map_err(|fault| self.0.stop(fault))?;
            state.nodes.insert(node, motion);
        }
        Ok(state)
    }
}
