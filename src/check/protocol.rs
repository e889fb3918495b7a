//! The messages of `pintle-candidate/1`: one JSON document a line, in both directions.

use crate::convention::{Convention, Own, Storage};
use pintle_audit::Question;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Connector, Definition};
use pintle_kinematics::node::{DOFS, Node};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, add, column, product, transpose};
use serde::Deserialize;
use serde_json::{Map, Value, json};

/// The name and version of the protocol.
pub const PROTOCOL: &str = "pintle-candidate/1";

/// What a routine says first.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hello {
    #[serde(rename = "protocol")]
    _protocol: Value,
    pub(crate) name: String,
    pub(crate) offers: Vec<Offer>,
    /// The components that it has; without them, all.
    pub(crate) components: Option<Vec<String>>,
    #[serde(default)]
    pub(crate) convention: Convention,
}

/// What a routine offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Offer {
    /// Residuals of constrained components, displacements of others.
    Values,
    /// Their derivatives by the degrees of freedom of the nodes.
    Rows,
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

/// The first message.
pub(crate) fn hello() -> Value {
    json!({ "hello": { "protocol": PROTOCOL, "version": pintle_kinematics::VERSION } })
}

/// The connector that the routine is to be.
pub(crate) fn open(definition: &Definition, convention: &Convention) -> Value {
    let connector = Connector::<f64>::new(definition);
    let of = |k: usize| {
        let measure = connector.differentiated(k)?;
        let kind = if connector.is_constrained(k) { "constrained" } else { "free" };
        let unit = format!("{:?}", measure.unit()).to_lowercase();
        Some(json!({ "name": COMPONENT[k], "kind": kind, "unit": unit }))
    };
    let components: Vec<Value> = (0..6).map(|k| of(k).unwrap_or(Value::Null)).collect();
    let initial = &definition.initial;
    let at = |node: &Node<f64>, x: Vector<f64>| json!({ "x": x.map(|x| x / convention.length), "triad": directions(node) });
    json!({ "open": {
        "type": definition.connection.name,
        "components": components,
        "initial": { "a": at(&initial.a, [0.0; 3]), "b": at(&initial.b, initial.reference) },
        "flow_scale": definition.flow_scale * convention.length,
        "planar": definition.planar,
    } })
}

/// e1, e2, e3 of a node.
fn directions(node: &Node<f64>) -> [Vector<f64>; 3] {
    [0, 1, 2].map(|i| column(&node.triad, i))
}

/// A request for values or rows at one state, which may follow another.
pub(crate) fn evaluate(
    id: u64,
    asked: &Question<'_>,
    definition: &Definition,
    convention: &Convention,
) -> Value {
    let initial = &definition.initial;
    let node = |now: &Node<f64>, first: &Node<f64>, x: Vector<f64>| {
        let rotation = product(&now.triad, &transpose(&first.triad));
        let place = add(x, now.displacement);
        json!({
            "x": place.map(|x| x / convention.length),
            "u": now.displacement.map(|u| u / convention.length),
            "triad": directions(now),
            "quaternion": so3::quaternion(&rotation),
            "rotation_vector": so3::log(&rotation),
            "flow": now.flow / convention.length,
        })
    };
    let state = |state: &pintle_kinematics::connector::State<f64>| {
        json!({
            "a": node(&state.pair.a, &initial.a, [0.0; 3]),
            "b": node(&state.pair.b, &initial.b, initial.reference),
        })
    };
    let mut one = state(asked.state);
    if let (Some(before), Some(one)) = (asked.before, one.as_object_mut()) {
        one.insert("previous".to_string(), state(before));
    }
    let want: &[&str] = if asked.wants_rows { &["values", "rows"] } else { &["values"] };
    json!({ "evaluate": { "id": id, "want": want, "states": [one] } })
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

/// The answers to one state of an object `{"id": …, "answers": […]}`.
///
/// # Errors
/// In words, what has the wrong shape.
pub(crate) fn answer(
    object: &Map<String, Value>,
    convention: &Convention,
    wants_rows: bool,
) -> Result<Answer, String> {
    let answers = object.get("answers").and_then(Value::as_array).ok_or("\"answers\" is no list")?;
    let [one] = answers.as_slice() else {
        return Err(format!("\"answers\" has {} items, and one state was asked", answers.len()));
    };
    let one = one.as_object().ok_or("an item of \"answers\" is no object")?;
    let text = |key: &str| one.get(key).map(|why| why.as_str().map_or_else(|| why.to_string(), String::from));
    if let Some(why) = text("error") {
        return Ok(Answer::Error(excerpt(&why)));
    }
    if let Some(why) = text("out_of_domain") {
        return Ok(Answer::OutOfDomain(excerpt(&why)));
    }
    let mut own = Own { values: [None; 6], rows: [const { None }; 6] };
    let values = list(one.get("values"), 6, "\"values\"")?;
    for (k, value) in values.into_iter().flatten().enumerate() {
        own.values[k] = number(value, &format!("\"values\"[{k}]"))?;
    }
    if !wants_rows {
        return Ok(Answer::Given(Box::new(own)));
    }
    let width = convention.columns.len();
    match convention.storage {
        Storage::Rows => {
            for (k, row) in list(one.get("rows"), 6, "\"rows\"")?.into_iter().flatten().enumerate() {
                let place = format!("\"rows\"[{k}]");
                let Some(row) = list(Some(row), width, &place)? else { continue };
                let entry = |(j, x)| Ok(number(x, &format!("{place}[{j}]"))?.unwrap_or(0.0));
                own.rows[k] = Some(row.iter().enumerate().map(entry).collect::<Result<_, String>>()?);
            }
        }
        Storage::Columns => {
            let columns = list(one.get("rows"), width, "\"rows\", which are stored by columns,")?;
            for (j, column) in columns.into_iter().flatten().enumerate() {
                let place = format!("\"rows\"[{j}]");
                for (k, x) in list(Some(column), 6, &place)?.into_iter().flatten().enumerate() {
                    if let Some(x) = number(x, &format!("{place}[{k}]"))? {
                        own.rows[k].get_or_insert_with(|| vec![0.0; width])[j] = x;
                    }
                }
            }
        }
    }
    debug_assert!(width <= DOFS);
    Ok(Answer::Given(Box::new(own)))
}

/// A list of that many items; none where it is missing or null.
fn list<'a>(value: Option<&'a Value>, count: usize, name: &str) -> Result<Option<&'a Vec<Value>>, String> {
    match value {
        None | Some(Value::Null) => Ok(None),
        Some(Value::Array(items)) if items.len() == count => Ok(Some(items)),
        Some(Value::Array(items)) => Err(format!("{name} has {} items, not {count}", items.len())),
        Some(other) => Err(format!("{name} is {}, not a list of {count}", excerpt(&other.to_string()))),
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
