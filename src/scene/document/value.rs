//! The values of a scene's form that derived implementations cannot read, write or describe: values with their place, values by name,
//! values of several kinds, rows of tables.

use crate::document::de::PLACED;
use crate::document::form::{FullRow, List, Name, Range, placeless};
use crate::span::{Span, Spanned};
#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Deserialize, Serialize, Serializer};
#[cfg(feature = "schema")]
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// Values by name, in their order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entries<T>(pub(crate) Vec<(Name, T)>);

impl<T> Default for Entries<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> FromIterator<(String, T)> for Entries<T> {
    fn from_iter<I: IntoIterator<Item = (String, T)>>(entries: I) -> Self {
        Self(entries.into_iter().map(|(name, value)| (placeless(name), value)).collect())
    }
}

impl<T: Serialize> Serialize for Entries<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(&name.value, value)?;
        }
        map.end()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Entries<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Reader<T> {
            type Value = Entries<T>;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a table")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries<T>, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Entries(entries))
            }
        }
        deserializer.deserialize_map(Reader(PhantomData))
    }
}

#[cfg(feature = "schema")]
impl<T: JsonSchema> JsonSchema for Entries<T> {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        format!("entries of {}", T::schema_name()).into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let value = generator.subschema_for::<T>();
        json_schema!({"type": "object", "additionalProperties": value})
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Spanned<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Reader<T> {
            type Value = Spanned<T>;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a value")
            }
            fn visit_newtype_struct<D: Deserializer<'de>>(
                self,
                deserializer: D,
            ) -> Result<Spanned<T>, D::Error> {
                T::deserialize(deserializer).map(placeless)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Spanned<T>, A::Error> {
                let [start, line, length] = parts.next_element::<[u64; 3]>()?.unwrap_or_default();
                let line = u32::try_from(line).unwrap_or(u32::MAX);
                let span = Span::new(0, line, start, usize::try_from(length).unwrap_or(usize::MAX));
                let value = parts.next_element()?.ok_or_else(|| A::Error::missing_field("value"))?;
                Ok(Spanned::new(value, span))
            }
        }
        deserializer.deserialize_newtype_struct(PLACED, Reader(PhantomData))
    }
}

#[cfg(feature = "schema")]
impl<T: JsonSchema> JsonSchema for Spanned<T> {
    fn inline_schema() -> bool {
        T::inline_schema()
    }
    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }
    fn schema_id() -> Cow<'static, str> {
        T::schema_id()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

/// A type whose JSON Schema is written out, where it is used.
macro_rules! described {
    ($name:ident, $schema:tt) => {
        #[cfg(feature = "schema")]
        impl JsonSchema for $name {
            fn inline_schema() -> bool {
                true
            }
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }
            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!($schema)
            }
        }
    };
}

/// A type that is one of several simple ones: how it is read, written and described.
macro_rules! simple {
    (
        $(#[$meta:meta])*
        $name:ident, $expecting:literal, $schema:tt;
        $($method:ident($($value:ident: $type:ty)?) => $make:expr;)*
    ) => {
        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Reader;
                impl<'de> Visitor<'de> for Reader {
                    type Value = $name;
                    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                        formatter.write_str($expecting)
                    }
                    $(fn $method<E: Error>(self, $($value: $type)?) -> Result<$name, E> { $make })*
                }
                deserializer.deserialize_any(Reader)
            }
        }

        described!($name, $schema);
    };
}

/// A component of relative motion; its range is for the reader of decks to check.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Component(pub(crate) u64);

simple! {
    Component, "a component, 1 to 6", {"type": "integer", "minimum": 1, "maximum": 6};
    visit_u64(number: u64) => Ok(Component(number));
}

/// A number, or nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Item(pub(crate) Option<f64>);

#[expect(clippy::cast_precision_loss, reason = "the nearest double is meant")]
const fn nearest(number: u64) -> f64 {
    number as f64
}

simple! {
    Item, "a number, or \"\" for an empty item",
    {"anyOf": [{"type": "number"}, {"type": "null"}, {"type": "string", "maxLength": 0}]};
    visit_u64(number: u64) => Ok(Item(Some(nearest(number))));
    visit_f64(number: f64) => Ok(Item(Some(number)));
    visit_unit() => Ok(Item(None));
    visit_str(text: &str) => match text {
        "" => Ok(Item(None)),
        _ => Err(E::invalid_type(serde::de::Unexpected::Str(text), &"a number, or \"\" for an empty item")),
    };
}

/// A node or element number, a number of an instance such as CRANK-1.5, or the name of a set.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Target {
    /// A number.
    Number(u64),
    /// A label with an instance, or a set.
    Text(String),
}

impl fmt::Display for Target {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(formatter, "{number}"),
            Self::Text(text) => formatter.write_str(text),
        }
    }
}

impl Default for Target {
    fn default() -> Self {
        Self::Number(0)
    }
}

simple! {
    Target, "a number, or a text", {"type": ["integer", "string"], "minimum": 1};
    visit_u64(number: u64) => Ok(Target::Number(number));
    visit_str(text: &str) => Ok(Target::Text(text.to_owned()));
}

/// A component, or the name of a derived component.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Source {
    /// A component.
    Component(u64),
    /// A derived component.
    Derived(String),
}

impl Default for Source {
    fn default() -> Self {
        Self::Component(0)
    }
}

simple! {
    Source, "a component, or the name of a derived component",
    {"anyOf": [{"type": "integer", "minimum": 1, "maximum": 6}, {"type": "string"}]};
    visit_u64(number: u64) => Ok(Source::Component(number));
    visit_str(text: &str) => Ok(Source::Derived(text.to_owned()));
}

/// A value of a parameter, or that it has none.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parameter(pub(crate) Option<String>);

simple! {
    Parameter, "a text, or true for a parameter without a value",
    {"anyOf": [{"type": "string"}, {"const": true}]};
    visit_str(text: &str) => Ok(Parameter(Some(text.to_owned())));
    visit_bool(truth: bool) => match truth {
        true => Ok(Parameter(None)),
        false => Err(E::custom("leave the parameter out instead of giving it the value false")),
    };
}

impl Serialize for Parameter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            Some(text) => serializer.serialize_str(text),
            None => serializer.serialize_bool(true),
        }
    }
}

macro_rules! listed {
    ($name:ident, $expecting:literal, $schema:tt; $item:ty; |$items:ident| $finish:expr;
     $($method:ident($value:ident: $type:ty) => $make:expr;)*) => {
        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Reader;
                impl<'de> Visitor<'de> for Reader {
                    type Value = $name;
                    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                        formatter.write_str($expecting)
                    }
                    $(fn $method<E: Error>(self, $value: $type) -> Result<$name, E> { $make })*
                    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<$name, A::Error> {
                        let mut $items: Vec<$item> = Vec::new();
                        while let Some(item) = parts.next_element()? {
                            $items.push(item);
                        }
                        $finish
                    }
                }
                deserializer.deserialize_any(Reader)
            }
        }

        described!($name, $schema);
    };
}

/// One to three coordinates; those that are not given are 0.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct Point(pub(crate) Vec<Spanned<f64>>);

listed! {
    Point, "a list of up to three coordinates",
    {"type": "array", "items": {"type": "number"}, "minItems": 1, "maxItems": 3};
    Spanned<f64>;
    |items| match items.len() {
        1..=3 => Ok(Point(items)),
        count => Err(A::Error::invalid_length(count, &"one to three coordinates")),
    };
}

/// Three coordinates, or a node.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum PointOrNode {
    /// Coordinates.
    Point(Vec<Spanned<f64>>),
    /// A node.
    Node(Target),
}

listed! {
    PointOrNode, "three coordinates, or a node",
    {"anyOf": [
        {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
        {"type": ["integer", "string"], "minimum": 1}
    ]};
    Spanned<f64>;
    |items| match items.len() {
        3 => Ok(PointOrNode::Point(items)),
        count => Err(A::Error::invalid_length(count, &"three coordinates")),
    };
    visit_u64(number: u64) => Ok(PointOrNode::Node(Target::Number(number)));
    visit_str(text: &str) => Ok(PointOrNode::Node(Target::Text(text.to_owned())));
}

/// One text or a list of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct OneOrMany(pub(crate) Vec<Name>);

impl Serialize for OneOrMany {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.as_slice() {
            [one] => one.serialize(serializer),
            many => many.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for OneOrMany {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let placed = Spanned::<Words>::deserialize(deserializer)?;
        Ok(Self(match placed.value {
            Words::One(text) => vec![Spanned::new(text, placed.span)],
            Words::Many(texts) => texts,
        }))
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for OneOrMany {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        "OneOrMany".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Words::json_schema(generator)
    }
}

enum Words {
    One(String),
    Many(Vec<Name>),
}

listed! {
    Words, "one connection type, or a list of two",
    {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1, "maxItems": 2}]};
    Name;
    |items| match items.len() {
        1 | 2 => Ok(Words::Many(items)),
        count => Err(A::Error::invalid_length(count, &"one connection type, or two")),
    };
    visit_str(text: &str) => Ok(Words::One(text.to_owned()));
}

/// A member of a set: a node or element, another set, or a range.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Member {
    /// A number, or a text as [`Target`] has it.
    One(Target),
    /// Numbers at equal distances.
    Range(Range),
}

impl<'de> Deserialize<'de> for Member {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Member;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a number, the name of a set, or a range such as {first = 1, last = 9}")
            }
            fn visit_u64<E: Error>(self, number: u64) -> Result<Member, E> {
                Ok(Member::One(Target::Number(number)))
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Member, E> {
                Ok(Member::One(Target::Text(text.to_owned())))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Member, A::Error> {
                Range::deserialize(serde::de::value::MapAccessDeserializer::new(map)).map(Member::Range)
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Member {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        "Member".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let range = generator.subschema_for::<Range>();
        json_schema!({"anyOf": [{"type": ["integer", "string"], "minimum": 1}, range]})
    }
}

/// A row of a table: its columns, or columns with a temperature and field variables.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Row {
    pub(crate) values: List<Item>,
    pub(crate) temperature: Option<Spanned<f64>>,
    pub(crate) fields: List<Item>,
}

impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.temperature.is_none() && self.fields.is_empty() {
            let mut list = serializer.serialize_seq(Some(self.values.len()))?;
            for value in &self.values {
                list.serialize_element(value)?;
            }
            return list.end();
        }
        let Self { values, temperature, fields } = self.clone();
        FullRow { values, temperature, fields }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Row {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Row;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a list of numbers, or a table with `values` and `temperature`")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Row, A::Error> {
                let mut row = Row::default();
                while let Some(item) = parts.next_element()? {
                    row.values.push(item);
                }
                Ok(row)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Row, A::Error> {
                let deserializer = serde::de::value::MapAccessDeserializer::new(map);
                let FullRow { values, temperature, fields } = FullRow::deserialize(deserializer)?;
                Ok(Row { values, temperature, fields })
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Row {
    fn schema_name() -> Cow<'static, str> {
        "Row".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let full = generator.subschema_for::<FullRow>();
        let item = generator.subschema_for::<Item>();
        json_schema!({"anyOf": [{"type": "array", "items": item}, full]})
    }
}
