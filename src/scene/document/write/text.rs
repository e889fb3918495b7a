//! A tree of values as JSON or TOML, of which what is small stands on one line.

use serde_json::Value;
use toml_writer::{ToTomlKey, ToTomlValue, TomlKeyBuilder, TomlStringBuilder};

/// The widest line on which a table or list is written whole.
const WIDTH: usize = 100;

/// Numbers, texts and truth values, and lists of them.
fn is_simple(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.iter().all(is_simple),
        Value::Object(_) => false,
        _ => true,
    }
}

pub(super) fn json_text(value: &Value) -> String {
    let mut text = String::new();
    json(&mut text, value, 0);
    text.push('\n');
    text
}

fn json(text: &mut String, value: &Value, depth: usize) {
    let compact = value.to_string();
    let (brackets, count) = match value {
        Value::Object(fields) => (['{', '}'], fields.len()),
        Value::Array(items) => (['[', ']'], items.len()),
        _ => ([' ', ' '], 0),
    };
    if count == 0 || depth > 0 && compact.len() + 2 * depth <= WIDTH && !has_tables(value) {
        text.push_str(&compact);
        return;
    }
    let [open, close] = brackets;
    text.push(open);
    let mut separator = "\n";
    let mut begin = |text: &mut String| {
        text.push_str(separator);
        text.push_str(&"  ".repeat(depth + 1));
        separator = ",\n";
    };
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                begin(text);
                text.push_str(&format!("{}: ", Value::from(key.as_str())));
                json(text, value, depth + 1);
            }
        }
        Value::Array(items) => {
            for item in items {
                begin(text);
                json(text, item, depth + 1);
            }
        }
        _ => {}
    }
    text.push('\n');
    text.push_str(&"  ".repeat(depth));
    text.push(close);
}

/// Does it hold tables of tables, or several of them?
fn has_tables(value: &Value) -> bool {
    match value {
        Value::Object(fields) => fields.values().any(|value| !is_simple(value)),
        Value::Array(items) => items.iter().any(|item| !is_simple(item)),
        _ => false,
    }
}

fn key(key: &str) -> String {
    TomlKeyBuilder::new(key).as_default().to_toml_key()
}

/// A value on one line.
fn inline(text: &mut String, value: &Value) {
    match value {
        // An empty item; a field that is not there is not written at all.
        Value::Null => text.push_str("\"\""),
        Value::Bool(truth) => {
            text.push_str(&format!("{truth}"));
        }
        Value::Number(number) => {
            text.push_str(&format!("{number}"));
        }
        Value::String(string) => {
            text.push_str(&TomlStringBuilder::new(string).as_basic().to_toml_value());
        }
        Value::Array(items) => {
            text.push('[');
            for (place, item) in items.iter().enumerate() {
                text.push_str(if place > 0 { ", " } else { "" });
                inline(text, item);
            }
            text.push(']');
        }
        Value::Object(fields) if fields.is_empty() => text.push_str("{}"),
        Value::Object(fields) => {
            text.push_str("{ ");
            for (place, (name, value)) in fields.iter().enumerate() {
                text.push_str(if place > 0 { ", " } else { "" });
                text.push_str(&format!("{} = ", key(name)));
                inline(text, value);
            }
            text.push_str(" }");
        }
    }
}

pub(super) fn toml_text(document: &Value) -> String {
    let mut text = String::new();
    if let Value::Object(fields) = document {
        toml_table(&mut text, fields, "");
    }
    text
}

/// Is it written below a header of its own?
fn has_header(value: &Value, path: &str) -> bool {
    match value {
        Value::Object(fields) => path.is_empty() || !fits(value) || fields.is_empty() && path.is_empty(),
        Value::Array(items) => {
            !items.is_empty()
                && items.iter().all(Value::is_object)
                && (path.is_empty() || !items.iter().all(fits))
        }
        _ => false,
    }
}

fn fits(value: &Value) -> bool {
    let mut text = String::new();
    inline(&mut text, value);
    text.len() <= WIDTH
}

/// Is it a table or a list of tables?
fn is_table(value: &Value) -> bool {
    match value {
        Value::Object(_) => true,
        Value::Array(items) => !items.is_empty() && items.iter().all(Value::is_object),
        _ => false,
    }
}

fn toml_table(text: &mut String, fields: &serde_json::Map<String, Value>, path: &str) {
    // What has no header must come first: tables keep their order only if all of them have one, or none.
    let any = fields.values().any(|value| has_header(value, path));
    let has_header = |value: &Value| any && is_table(value);
    for (name, value) in fields.iter().filter(|(_, value)| !has_header(value)) {
        text.push_str(&format!("{} = ", key(name)));
        match value {
            Value::Array(items) if !fits(value) => {
                text.push_str("[\n");
                for line in items.chunks(if items.iter().any(|item| item.is_array() || item.is_object()) {
                    1
                } else {
                    10
                }) {
                    text.push_str("  ");
                    for (place, item) in line.iter().enumerate() {
                        text.push_str(if place > 0 { " " } else { "" });
                        inline(text, item);
                        text.push(',');
                    }
                    text.push('\n');
                }
                text.push(']');
            }
            _ => inline(text, value),
        }
        text.push('\n');
    }
    for (name, value) in fields.iter().filter(|(_, value)| has_header(value)) {
        let path = if path.is_empty() { key(name) } else { format!("{path}.{}", key(name)) };
        match value {
            Value::Array(items) => {
                for item in items {
                    text.push_str(&format!("\n[[{path}]]\n"));
                    if let Value::Object(fields) = item {
                        toml_table(text, fields, &path);
                    }
                }
            }
            Value::Object(fields) => {
                let any = fields.values().any(|value| self::has_header(value, &path));
                let headed = any && fields.values().all(is_table);
                if !headed {
                    text.push_str(&format!("\n[{path}]\n"));
                }
                toml_table(text, fields, &path);
            }
            _ => {}
        }
    }
}
