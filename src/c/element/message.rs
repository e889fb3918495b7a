//! Numbers of messages, in and out.

use serde_json::{Map, Value, json};

/// The names of what a routine may give, each with its bit.
pub(crate) const OFFERS: [(&str, u32); 13] = [
    ("values", 1),
    ("rows", 2),
    ("second_derivatives", 4),
    ("rates", 8),
    ("accelerations", 16),
    ("nodal_forces", 32),
    ("geometric_stiffness", 64),
    ("element_forces", 128),
    ("element_stiffness", 256),
    ("criterion", 512),
    ("gradients", 1024),
    ("friction_forces", 2048),
    ("friction_tangent", 4096),
];

/// An answer for one state.
pub(crate) type Answer = Map<String, Value>;

/// What is asked of one state.
pub(crate) struct Asked<'a> {
    pub(crate) state: &'a Value,
    /// Bits of [`OFFERS`].
    pub(crate) wants: u32,
}

/// The bits of a list of names.
pub(crate) fn wants(names: Option<&Value>) -> u32 {
    let names = names.and_then(Value::as_array).into_iter().flatten();
    let bit = |name: &Value| OFFERS.iter().find(|(known, _)| name == known).map_or(0, |(_, bit)| *bit);
    names.map(bit).fold(0, |all, bit| all | bit)
}

/// The names of bits.
pub(crate) fn names(bits: u32) -> Vec<&'static str> {
    OFFERS.iter().filter(|(_, bit)| bits & bit != 0).map(|(name, _)| *name).collect()
}

/// A number; zero where there is none.
pub(crate) fn number(value: Option<&Value>) -> f64 {
    value.and_then(Value::as_f64).unwrap_or(0.0)
}

/// So many numbers of a list, however nested it is; zero where there are none.
pub(crate) fn numbers<const N: usize>(value: Option<&Value>) -> [f64; N] {
    fn flatten(value: &Value, into: &mut Vec<f64>) {
        match value {
            Value::Array(items) => items.iter().for_each(|item| flatten(item, into)),
            other => into.push(number(Some(other))),
        }
    }
    let mut found = Vec::new();
    value.iter().for_each(|value| flatten(value, &mut found));
    std::array::from_fn(|i| found.get(i).copied().unwrap_or(0.0))
}

/// A number as messages write it: what is not finite is a string.
pub(crate) fn written(x: f64) -> Value {
    match x {
        x if x.is_nan() => json!("NaN"),
        f64::INFINITY => json!("Infinity"),
        f64::NEG_INFINITY => json!("-Infinity"),
        x => json!(x),
    }
}

/// An answer that a state is outside the domain.
pub(crate) fn out_of_domain(why: String) -> Answer {
    [("out_of_domain".to_string(), json!(why))].into_iter().collect()
}
