//! The messages of `pintle-candidate/1`: one JSON document each, in both directions.

use crate::convention::{Convention, Own, Quaternions, Sense, Storage, Triads};
use crate::fit::GivenRows;
use pintle_audit::{Domain, Quantity, Question, initial_places};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Components, Connector, Definition, State};
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, add, column, product, transpose};
use serde::Deserialize;
use serde_json::{Map, Value, json};

/// The name and version of the protocol.
pub const PROTOCOL: &str = "pintle-candidate/1";

/// What a routine may offer, as the protocol names it.
pub const OFFERS: [(&str, Quantity); 9] = [
    ("values", Quantity::Value),
    ("rows", Quantity::FirstDerivatives),
    ("second_derivatives", Quantity::SecondDerivatives),
    ("rates", Quantity::Rate),
    ("accelerations", Quantity::Acceleration),
    ("nodal_forces", Quantity::NodalForces),
    ("geometric_stiffness", Quantity::GeometricStiffness),
    ("element_forces", Quantity::ElementForces),
    ("element_stiffness", Quantity::ElementStiffness),
];

/// What a friction may offer.
pub(crate) const OF_FRICTION: [(&str, Quantity); 4] = [
    ("criterion", Quantity::FrictionCriterion),
    ("gradients", Quantity::FrictionGradient),
    ("friction_forces", Quantity::FrictionForce),
    ("friction_tangent", Quantity::FrictionTangent),
];

/// What a routine says first.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hello {
    #[serde(rename = "protocol")]
    _protocol: Value,
    pub(crate) name: String,
    offers: Vec<String>,
    /// The components that it has; without them, all.
    pub(crate) components: Option<Vec<String>>,
    #[serde(default)]
    pub(crate) convention: Convention,
    /// Whether it keeps something from one state of a history to the next.
    #[serde(default)]
    pub(crate) memory: bool,
    /// Whether states and answers follow their messages as bytes.
    #[serde(default)]
    pub(crate) binary: bool,
    /// Whether it keeps its memory itself, and commits and reverts it as it is told.
    #[serde(default)]
    pub(crate) commits: bool,
    /// The connection types that it covers; without them, any.
    pub(crate) types: Option<Vec<String>>,
    /// Where states are drawn.
    #[serde(default)]
    pub(crate) domain: Domain,
}

/// That what was tried stands, or not.
pub(crate) fn told(word: &str) -> Value {
    json!({ word: {} })
}

/// What may be offered: names with what they are of.
pub(crate) type Offers = [(&'static str, Quantity)];

impl Hello {
    /// The quantities offered, of those that are `known`.
    ///
    /// # Errors
    /// In words, what is none.
    pub(crate) fn offers(&self, known: &Offers) -> Result<Vec<Quantity>, String> {
        let of = |name: &String| {
            let found = known.iter().find(|(known, _)| known == name).map(|(_, quantity)| *quantity);
            found.ok_or_else(|| {
                let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
                format!("its offers name {name:?}; there are {}", names.join(", "))
            })
        };
        self.offers.iter().map(of).collect()
    }

    /// That its components are among those of these names.
    ///
    /// # Errors
    /// In words, which one is none.
    pub(crate) fn names_among(&self, known: &[&str]) -> Result<(), String> {
        let unknown = |name: &&String| !known.contains(&name.as_str());
        match self.components.iter().flatten().find(unknown) {
            Some(name) => Err(format!("its components name {name:?}; there are {}", known.join(", "))),
            None => Ok(()),
        }
    }

    /// Whether it has the component of a name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.components.as_ref().is_none_or(|names| names.iter().any(|known| known == name))
    }
}

/// The name of a quantity in messages.
pub(crate) fn name(quantity: Quantity) -> &'static str {
    let mut all = OFFERS.into_iter().chain(OF_FRICTION);
    all.find(|(_, known)| *known == quantity).map_or("", |(name, _)| name)
}

/// How the numbers of an answer are laid out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Components, or equations.
    pub(crate) rows: usize,
    /// Degrees of freedom.
    pub(crate) columns: usize,
    /// Whether rows are stored as columns.
    pub(crate) by_columns: bool,
}

impl Layout {
    /// By a convention, of so many components or equations.
    pub(crate) fn of(convention: &Convention, rows: usize, columns: usize) -> Self {
        Self { rows, columns, by_columns: convention.storage == Storage::Columns }
    }
}

/// What a routine answered for one state.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Answer {
    Given(Box<Own>),
    /// It does not cover this state.
    OutOfDomain(String),
    /// It failed.
    Error(String),
}

impl Answer {
    /// Bit for bit, NaN included.
    pub(crate) fn is_same_as(&self, other: &Self) -> bool {
        format!("{self:?}") == format!("{other:?}")
    }
}

/// The first message.
pub(crate) fn hello() -> Value {
    json!({ "hello": { "protocol": PROTOCOL, "version": pintle_kinematics::VERSION } })
}

/// The connector that the routine is to be.
pub(crate) fn open(definition: &Definition, convention: &Convention, springs: &Components<f64>) -> Value {
    let connector = Connector::<f64>::new(definition);
    let of = |k: usize| {
        let measure = connector.differentiated(k)?;
        let kind = if connector.is_constrained(k) { "constrained" } else { "free" };
        let unit = format!("{:?}", measure.unit()).to_lowercase();
        Some(json!({ "name": COMPONENT[k], "kind": kind, "unit": unit }))
    };
    let components: Vec<Value> = (0..6).map(|k| of(k).unwrap_or(Value::Null)).collect();
    let initial = &definition.initial;
    let at = |node: &Node<f64>, x: Vector<f64>| json!({ "x": x.map(|x| x / convention.length), "triad": directions(node, convention) });
    // An energy in the routine's length, over its component's unit squared.
    let spring =
        |k: usize| springs[k].map(|d| d * convention.unit(k, &connector).powi(2) / convention.length);
    let springs = [0, 1, 2, 3, 4, 5].map(spring);
    let [of_a, of_b] = initial_places(definition.initial.reference, definition.planar);
    json!({ "open": {
        "springs": springs,
        "type": definition.connection.name,
        "components": components,
        "initial": { "a": at(&initial.a, of_a), "b": at(&initial.b, of_b) },
        "flow_scale": definition.flow_scale * convention.length,
        "planar": definition.planar,
    } })
}

/// e1, e2, e3 of a node, or the matrix that has them as columns.
fn directions(node: &Node<f64>, convention: &Convention) -> [Vector<f64>; 3] {
    match convention.triads {
        Triads::Axes => [0, 1, 2].map(|i| column(&node.triad, i)),
        Triads::Matrix => node.triad,
    }
}

/// A place, rotation and flow of each node.
fn places(pair: &Pair<f64>, definition: &Definition, convention: &Convention) -> Map<String, Value> {
    let initial = &definition.initial;
    let node = |now: &Node<f64>, first: &Node<f64>, x: Vector<f64>| {
        let mut rotation = product(&now.triad, &transpose(&first.triad));
        if convention.sense == Sense::Inverse {
            rotation = transpose(&rotation);
        }
        let place = add(x, now.displacement);
        node_of(place, now.displacement, directions(now, convention), &rotation, now.flow, convention)
    };
    let [of_a, of_b] = initial_places(definition.initial.reference, definition.planar);
    [("a", node(&pair.a, &initial.a, of_a)), ("b", node(&pair.b, &initial.b, of_b))]
        .into_iter()
        .map(|(name, node)| (name.to_string(), node))
        .collect()
}

/// A place, rotation and flow of a node, lengths in a routine's unit.
pub(crate) fn node_of(
    place: Vector<f64>,
    displacement: Vector<f64>,
    triad: [Vector<f64>; 3],
    rotation: &Matrix<f64>,
    flow: f64,
    convention: &Convention,
) -> Value {
    let length = convention.length;
    let mut quaternion = so3::quaternion(rotation);
    if convention.quaternion == Quaternions::Xyzw {
        quaternion.rotate_left(1);
    }
    json!({
        "x": place.map(|x| x / length),
        "u": displacement.map(|u| u / length),
        "triad": triad,
        "quaternion": quaternion,
        "rotation_vector": so3::log(rotation),
        "flow": flow / length,
    })
}

/// Adds the rates of a node, seven of each kind: of x, rotation and flow.
pub(crate) fn add_rates(node: &mut Value, kind: &str, of: &[f64], length: f64) {
    let Some(node) = node.as_object_mut() else { return };
    let lengths = |x: &[f64]| x.iter().map(|x| x / length).collect::<Vec<f64>>();
    node.insert(kind.into(), json!(of.get(..3).map(lengths)));
    node.insert(format!("angular_{kind}"), json!(of.get(3..6)));
    node.insert(format!("flow_{kind}"), json!(of.get(6).map(|x| x / length)));
}

/// One state of a request: what it is, what was before, what the routine kept.
pub(crate) fn state(
    asked: &Question<'_>,
    (definition, connector): (&Definition, &Connector<f64>),
    convention: &Convention,
    memory: Option<&Value>,
) -> Value {
    let now: &State<f64> = asked.state();
    let mut one = places(&now.pair, definition, convention);
    let has_rates = asked.wants.iter().any(|of| matches!(of, Quantity::Rate | Quantity::Acceleration));
    for (end, name) in ["a", "b"].into_iter().enumerate() {
        let Some(node) = one.get_mut(name) else { continue };
        if let Some(node) = node.as_object_mut() {
            node.insert("increment".into(), json!(asked.step.increment.rotation[end]));
        }
        if has_rates {
            for (kind, of) in [("velocity", &now.velocity), ("acceleration", &now.acceleration)] {
                add_rates(node, kind, &of[7 * end..7 * end + 7], convention.length);
            }
        }
    }
    let before = asked.before().map_or(definition.initial, |before| before.pair);
    let mut previous = places(&before, definition, convention);
    let offsets = convention.positions.offsets(definition, connector);
    let value = |k: usize| {
        asked.values_before[k].map(|x| (x + offsets[k].unwrap_or(0.0)) / convention.unit(k, connector))
    };
    let before: Vec<Option<f64>> = convention.lines().into_iter().map(value).collect();
    previous.insert("values".into(), json!(before));
    if let Some(memory) = memory {
        previous.insert("memory".into(), memory.clone());
    }
    one.insert("previous".into(), Value::Object(previous));
    Value::Object(one)
}

/// A request at several states.
pub(crate) fn evaluate(id: u64, wants: &[Quantity], states: Vec<Value>) -> Value {
    let wants: Vec<&str> = wants.iter().map(|of| name(*of)).collect();
    json!({ "evaluate": { "id": id, "want": wants, "states": states } })
}

/// The same, where the states follow as so many bytes.
pub(crate) fn evaluate_bytes(id: u64, wants: &[Quantity], count: usize, bytes: usize) -> Value {
    let wants: Vec<&str> = wants.iter().map(|of| name(*of)).collect();
    json!({ "evaluate": { "id": id, "want": wants, "count": count, "bytes": bytes } })
}

/// How many bytes follow a message.
pub(crate) fn bytes_after(line: &str) -> Option<u64> {
    // Of a long line, which has its numbers in itself, nothing follows.
    const LONGEST: usize = 200;
    if line.len() > LONGEST || !line.contains("\"bytes\"") {
        return None;
    }
    serde_json::from_str::<Value>(line).ok()?.get("bytes")?.as_u64()
}

/// The last message.
pub(crate) fn close() -> Value {
    json!({ "close": {} })
}

/// A line as a JSON object.
///
/// # Errors
/// In words, what else it is.
pub(crate) fn object(line: &str) -> Result<Map<String, Value>, String> {
    match serde_json::from_str(line) {
        Ok(Value::Object(object)) => Ok(object),
        Ok(other) => Err(format!("{} is no JSON object", excerpt(&other.to_string()))),
        Err(error) => Err(format!("{:?} is no JSON document ({error})", excerpt(line))),
    }
}

/// At most a hundred characters of a text.
pub(crate) fn excerpt(text: &str) -> String {
    const SHOWN: usize = 100;
    let mut shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() {
        shown.push('…');
    }
    shown
}

/// The answers to so many states of an object `{"id": …, "answers": […]}`.
///
/// # Errors
/// In words, what has the wrong shape.
pub(crate) fn answers(
    object: &Map<String, Value>,
    layout: &dyn Fn(Quantity) -> Layout,
    wants: &[Quantity],
    count: usize,
) -> Result<Vec<Answer>, String> {
    let answers = object.get("answers").and_then(Value::as_array).ok_or("\"answers\" is no list")?;
    if answers.len() != count {
        let states = if count == 1 { "one state was" } else { &format!("{count} states were") };
        return Err(format!("\"answers\" has {} items, and {states} asked", answers.len()));
    }
    answers.iter().map(|one| answer(one, layout, wants)).collect()
}

/// The values, rows and rates of so many answers, as they are: no convention is undone.
///
/// # Errors
/// In words, what is no list of numbers.
pub(crate) fn as_it_is(answers: Option<&Value>, count: usize) -> Result<Vec<GivenRows>, String> {
    let answers = answers.and_then(Value::as_array).ok_or("\"answers\" is no list")?;
    if answers.len() != count {
        return Err(format!("there are {} answers, and {count} states", answers.len()));
    }
    let of = |(n, one): (usize, &Value)| {
        let one = one.as_object().ok_or_else(|| format!("answer {} is no object", n + 1))?;
        for key in ["error", "out_of_domain"] {
            if let Some(why) = one.get(key) {
                return Err(format!("answer {} is {key}: {}", n + 1, excerpt(&why.to_string())));
            }
        }
        let rows = one.get("rows").and_then(Value::as_array).filter(|rows| !rows.is_empty());
        let rows = rows.ok_or_else(|| format!("answer {} has no \"rows\"", n + 1))?;
        let numbers = |list: &[Value], name: &str| {
            list.iter().map(|x| number(x, name)).collect::<Result<Vec<Option<f64>>, String>>()
        };
        let filled = |list: &[Value]| {
            let all = numbers(list, "an entry of \"rows\"")?;
            Ok::<_, String>(all.into_iter().map(|x| x.unwrap_or(0.0)).collect::<Vec<f64>>())
        };
        let is_flat = rows.iter().all(|item| !item.is_array() && !item.is_null());
        let rows = if is_flat {
            vec![Some(filled(rows)?)]
        } else {
            let line = |item: &Value| match item {
                Value::Null => Ok(None),
                Value::Array(list) => filled(list).map(Some),
                other => {
                    Err(format!("{} among the lists of \"rows\" is no list", excerpt(&other.to_string())))
                }
            };
            rows.iter().map(line).collect::<Result<_, String>>()?
        };
        let list = |key: &str| match one.get(key) {
            Some(Value::Array(list)) => numbers(list, key).map(Some),
            _ => Ok(None),
        };
        // What is not laid out as rows are tells nothing of their conventions.
        let lines = |key: &str| -> Option<Vec<Option<Vec<f64>>>> {
            let flat = |item: &Value| match item {
                Value::Null => Some(None),
                Value::Array(list) => {
                    let all =
                        list.iter().flat_map(|x| x.as_array().map_or(std::slice::from_ref(x), Vec::as_slice));
                    all.map(Value::as_f64).collect::<Option<Vec<f64>>>().map(Some)
                }
                _ => None,
            };
            one.get(key)?.as_array()?.iter().map(flat).collect()
        };
        let (second, nodal) = (lines("second_derivatives"), lines("nodal_forces"));
        Ok(GivenRows { rows, values: list("values")?, rates: list("rates")?, second, nodal })
    };
    answers.iter().enumerate().map(of).collect()
}

/// The answers of a file: a list, an object with such a list under "answers", or a line for each.
///
/// # Errors
/// In words, what is none.
pub fn answers_of_file(text: &str, count: usize) -> Result<Vec<GivenRows>, String> {
    match serde_json::from_str::<Value>(text) {
        Ok(Value::Object(one)) if one.contains_key("answers") => as_it_is(one.get("answers"), count),
        Ok(one @ Value::Object(_)) => as_it_is(Some(&Value::Array(vec![one])), count),
        Ok(all) => as_it_is(Some(&all), count),
        Err(error) => {
            let lines = text.lines().filter(|line| !line.trim().is_empty());
            let all = lines.map(serde_json::from_str).collect::<Result<Vec<Value>, _>>();
            match all {
                Ok(all) if all.len() > 1 => as_it_is(Some(&Value::Array(all)), count),
                _ => Err(format!("this is no JSON document, nor one a line: {error}")),
            }
        }
    }
}

fn answer(one: &Value, layout: &dyn Fn(Quantity) -> Layout, wants: &[Quantity]) -> Result<Answer, String> {
    let one = one.as_object().ok_or("an item of \"answers\" is no object")?;
    let text = |key: &str| one.get(key).map(|why| why.as_str().map_or_else(|| why.to_string(), String::from));
    if let Some(why) = text("error") {
        return Ok(Answer::Error(excerpt(&why)));
    }
    if let Some(why) = text("out_of_domain") {
        return Ok(Answer::OutOfDomain(excerpt(&why)));
    }
    let mut own = Own { given: Vec::new(), memory: one.get("memory").cloned() };
    for quantity in wants {
        let name = name(*quantity);
        let Some(given) = one.get(name).filter(|given| !given.is_null()) else { continue };
        let Layout { rows, columns: width, by_columns } = layout(*quantity);
        let mut of: Vec<Option<Vec<f64>>> = vec![None; rows];
        match quantity {
            Quantity::ElementForces => {
                let entries = list(given, width, &format!("{name:?}"))?.iter().enumerate();
                let entry = |(j, x)| Ok(number(x, &format!("{name:?}[{j}]"))?.unwrap_or(0.0));
                of[0] = Some(entries.map(entry).collect::<Result<_, String>>()?);
            }
            Quantity::ElementStiffness => of[0] = Some(matrix(given, width, name)?),
            Quantity::FirstDerivatives
            | Quantity::NodalForces
            | Quantity::FrictionGradient
            | Quantity::FrictionTangent => {
                let (outer, inner) = if by_columns { (width, rows) } else { (rows, width) };
                for (i, j, x) in table(given, outer, inner, name)? {
                    let (line, column) = if by_columns { (j, i) } else { (i, j) };
                    if let Some(x) = x {
                        of[line].get_or_insert_with(|| vec![0.0; width])[column] = x;
                    }
                }
            }
            Quantity::SecondDerivatives | Quantity::GeometricStiffness => {
                for (i, given) in list(given, rows, &format!("{name:?}"))?.iter().enumerate() {
                    if !given.is_null() {
                        of[i] = Some(matrix(given, width, &format!("{name}[{i}]"))?);
                    }
                }
            }
            _ => {
                for (k, value) in list(given, rows, &format!("{name:?}"))?.iter().enumerate() {
                    of[k] = number(value, &format!("{name:?}[{k}]"))?.map(|x| vec![x]);
                }
            }
        }
        own.given.push((*quantity, of));
    }
    Ok(Answer::Given(Box::new(own)))
}

/// A square matrix, row by row.
fn matrix(value: &Value, width: usize, name: &str) -> Result<Vec<f64>, String> {
    Ok(table(value, width, width, name)?.into_iter().map(|(_, _, x)| x.unwrap_or(0.0)).collect())
}

/// The numbers of a list of lists, or of one flat list, with their places; those of a line that is null are none.
fn table(
    value: &Value,
    outer: usize,
    inner: usize,
    name: &str,
) -> Result<Vec<(usize, usize, Option<f64>)>, String> {
    let mut found = Vec::with_capacity(outer * inner);
    let is_flat = value.as_array().is_some_and(|items| {
        items.len() == outer * inner && !items.iter().any(Value::is_array) && !items.is_empty()
    });
    if is_flat {
        for (n, x) in list(value, outer * inner, &format!("{name:?}"))?.iter().enumerate() {
            found.push((n / inner, n % inner, number(x, &format!("{name:?}[{n}]"))?));
        }
        return Ok(found);
    }
    for (i, line) in list(value, outer, &format!("{name:?}"))?.iter().enumerate() {
        if line.is_null() {
            found.extend((0..inner).map(|j| (i, j, None)));
            continue;
        }
        let place = format!("{name:?}[{i}]");
        for (j, x) in list(line, inner, &place)?.iter().enumerate() {
            found.push((i, j, number(x, &format!("{place}[{j}]"))?));
        }
    }
    Ok(found)
}

/// A list of that many items.
fn list<'a>(value: &'a Value, count: usize, name: &str) -> Result<&'a Vec<Value>, String> {
    match value {
        Value::Array(items) if items.len() == count => Ok(items),
        Value::Array(items) => Err(format!("{name} has {} items, not {count}", items.len())),
        other => Err(format!("{name} is {}, not a list of {count}", excerpt(&other.to_string()))),
    }
}

/// A number; NaN and infinities are strings, null is none.
fn number(value: &Value, name: &str) -> Result<Option<f64>, String> {
    match value {
        Value::Null => Ok(None),
        Value::Number(number) => Ok(number.as_f64()),
        Value::String(text) => match text.as_str() {
            "NaN" => Ok(Some(f64::NAN)),
            "Infinity" => Ok(Some(f64::INFINITY)),
            "-Infinity" => Ok(Some(f64::NEG_INFINITY)),
            other => Err(format!("{name} is {:?}, not a number", excerpt(other))),
        },
        other => Err(format!("{name} is {}, not a number", excerpt(&other.to_string()))),
    }
}
