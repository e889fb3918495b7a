//! The binary payload of a routine that announces it: states and answers as doubles, lowest byte first, after the line that says how many
//! bytes follow.

use crate::convention::Own;
use crate::protocol::{Answer, Layout};
use pintle_audit::Quantity;
use serde_json::Value;

const DOUBLE: usize = size_of::<f64>();

/// The numbers of a node, in the order of `pintle_node` in pintle_element.h.
const NODE: [(&str, usize); 13] = [
    ("x", 3),
    ("u", 3),
    ("triad", 9),
    ("quaternion", 4),
    ("rotation_vector", 3),
    ("flow", 1),
    ("increment", 3),
    ("velocity", 3),
    ("angular_velocity", 3),
    ("flow_velocity", 1),
    ("acceleration", 3),
    ("angular_acceleration", 3),
    ("flow_acceleration", 1),
];

/// So many numbers of a value, however nested: 0 where it is missing, NaN for null.
fn put(value: Option<&Value>, count: usize, bytes: &mut Vec<u8>) {
    fn flatten(value: &Value, bytes: &mut Vec<u8>) {
        match value {
            Value::Array(items) => items.iter().for_each(|item| flatten(item, bytes)),
            other => bytes.extend(other.as_f64().unwrap_or(f64::NAN).to_le_bytes()),
        }
    }
    let end = bytes.len() + count * DOUBLE;
    value.iter().for_each(|value| flatten(value, bytes));
    bytes.resize(end, 0);
}

/// States as messages have them, as numbers: a and b, both at the state before, the values there.
pub(crate) fn states(states: &[Value]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for state in states {
        let previous = state.get("previous");
        for of in [Some(state), previous] {
            for name in ["a", "b"] {
                let node = of.and_then(|of| of.get(name));
                for (key, count) in NODE {
                    put(node.and_then(|node| node.get(key)), count, &mut bytes);
                }
            }
        }
        put(previous.and_then(|previous| previous.get("values")), 6, &mut bytes);
    }
    bytes
}

/// How many numbers a line of a quantity has, and how many lines there are.
fn shape(quantity: Quantity, layout: Layout) -> (usize, usize) {
    let Layout { rows, columns, .. } = layout;
    match quantity {
        Quantity::ElementForces => (1, columns),
        Quantity::ElementStiffness => (1, columns * columns),
        Quantity::FirstDerivatives | Quantity::NodalForces => (rows, columns),
        Quantity::SecondDerivatives | Quantity::GeometricStiffness => (rows, columns * columns),
        _ => (rows, 1),
    }
}

/// Answers to so many states: of each what was wanted, in that order. A component that the connector has not, by `present`, has NaN
/// alone.
///
/// # Errors
/// In words, what has the wrong length.
pub(crate) fn answers(
    bytes: &[u8],
    layout: &dyn Fn(Quantity) -> Layout,
    wants: &[Quantity],
    (count, present): (usize, &[bool]),
) -> Result<Vec<Answer>, String> {
    let shapes: Vec<(usize, usize)> = wants.iter().map(|of| shape(*of, layout(*of))).collect();
    let each: usize = shapes.iter().map(|(lines, width)| lines * width).sum();
    if bytes.len() != each * count * DOUBLE {
        let due = each * DOUBLE;
        return Err(format!("{} bytes followed, and {count} states have {due} each", bytes.len()));
    }
    let numbers =
        bytes.chunks_exact(DOUBLE).map(|eight| f64::from_le_bytes(eight.try_into().unwrap_or_default()));
    let numbers: Vec<f64> = numbers.collect();
    let one = |mut rest: &[f64]| {
        let mut own = Own::default();
        for (quantity, (lines, width)) in wants.iter().zip(&shapes) {
            let (own_part, others) = rest.split_at(lines * width);
            rest = others;
            let by_columns = layout(*quantity).by_columns && *lines > 1 && *width > 1;
            let is_table = matches!(quantity, Quantity::FirstDerivatives | Quantity::NodalForces);
            let line = |k: usize| -> Vec<f64> {
                if by_columns && is_table {
                    own_part.iter().skip(k).step_by(*lines).copied().collect()
                } else {
                    own_part[k * width..(k + 1) * width].to_vec()
                }
            };
            let is_whole = *lines == 1;
            let read = (0..*lines).map(line).enumerate().map(|(k, line)| {
                let is_there = !is_whole && present.get(k).copied().unwrap_or(true);
                (is_there || !line.iter().all(|x| x.is_nan())).then_some(line)
            });
            own.given.push((*quantity, read.collect()));
        }
        Answer::Given(Box::new(own))
    };
    Ok(numbers.chunks(each.max(1)).map(one).collect())
}
