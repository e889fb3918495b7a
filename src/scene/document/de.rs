//! Values of a [`Tree`] as types that derive `Deserialize`. An error knows the innermost value that is at fault.

use crate::diagnostic::{Code, Diagnostic, MAX_ERRORS, suggest};
use crate::document::tree::{Key, Tree, Value};
use crate::lexer::{NotANumber, parse_number};
use crate::span::Span;
use serde::de::value::{SeqDeserializer, StrDeserializer};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, EnumAccess, Error as _, IntoDeserializer, MapAccess,
    SeqAccess, Unexpected, VariantAccess, Visitor,
};
use std::fmt::{self, Display};

/// Under this name a newtype asks for its place beside its value.
pub(crate) const PLACED: &str = "$pintle::placed";

/// Why a tree is not what is wanted.
#[derive(Debug)]
pub(super) struct Fault {
    code: Code,
    message: String,
    label: String,
    remedy: String,
    span: Option<Span>,
}

impl Fault {
    fn new(code: Code, message: String, label: &str, remedy: String) -> Self {
        Self { code, message, label: label.to_owned(), remedy, span: None }
    }

    /// At `span`, unless a value further in is at fault.
    fn at(mut self, span: Span) -> Self {
        self.span = self.span.or(Some(span));
        self
    }

    fn diagnostic(self) -> Diagnostic {
        let span = self.span.unwrap_or_default();
        Diagnostic::error(self.code, span, self.message, self.label).help(self.remedy)
    }
}

/// What a tree stands for; or else all that is wrong with it is added to the errors. A value that is at fault is taken out, and the tree
/// is read again; what lacks a value that was taken out goes with it.
pub(super) fn read<T: for<'t> Deserialize<'t>>(
    tree: &mut Tree<'_>,
    errors: &mut Vec<Diagnostic>,
) -> Option<T> {
    let from = errors.len();
    for _ in 0..2 * MAX_ERRORS {
        let fault = match T::deserialize(&*tree) {
            Ok(value) => return Some(value).filter(|_| errors.len() == from),
            Err(fault) => fault,
        };
        let pruned = fault.span.and_then(|span| tree.prune(span));
        if !pruned.unwrap_or(tree.is_pruned) {
            errors.push(fault.diagnostic());
        }
        if pruned.is_none() {
            break;
        }
    }
    None
}

impl Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}

const SEE_SCHEMA: &str = "`pintle schema` shows every field and what it takes";

impl serde::de::Error for Fault {
    fn custom<T: Display>(message: T) -> Self {
        Self::new(Code::SceneWrongType, message.to_string(), "this value", SEE_SCHEMA.to_owned())
    }

    fn invalid_type(unexpected: Unexpected<'_>, expected: &dyn serde::de::Expected) -> Self {
        let message = format!("expected {expected}, but found {unexpected}");
        Self::new(Code::SceneWrongType, message, "not of this kind", SEE_SCHEMA.to_owned())
    }

    fn invalid_length(length: usize, expected: &dyn serde::de::Expected) -> Self {
        let message = format!("expected {expected}, but found {length} items");
        Self::new(Code::SceneWrongType, message, "too few or too many items", SEE_SCHEMA.to_owned())
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        let message = format!("`{variant}` is not one of the words allowed here");
        let remedy =
            suggest(variant, expected.iter().copied(), || format!("write one of {}", expected.join(", ")));
        Self::new(Code::SceneUnknownWord, message, "not one of those allowed", remedy)
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let message = format!("there is no field `{field}` here");
        let remedy = suggest(field, expected.iter().copied(), || {
            if expected.is_empty() {
                return "remove it".to_owned();
            }
            format!("the fields here are {}", expected.join(", "))
        });
        Self::new(Code::SceneUnknownField, message, "not a field", remedy)
    }

    fn missing_field(field: &'static str) -> Self {
        let message = format!("the field `{field}` is missing");
        Self::new(Code::SceneMissingField, message, "here", format!("give `{field}`"))
    }

    fn duplicate_field(field: &'static str) -> Self {
        let message = format!("`{field}` is given twice");
        Self::new(Code::SceneRepeatedField, message, "here", "keep one of the two".to_owned())
    }
}

/// The double that a text of digits stands for.
fn number(text: &str) -> Result<f64, Fault> {
    parse_number(text).map_err(|why| match why {
        NotANumber::OutOfRange => Fault::new(
            Code::NumberOutOfRange,
            format!("{text} does not fit into a double"),
            "too large or too small",
            "doubles reach from 5e-324 to 1.8e308".to_owned(),
        ),
        NotANumber::Malformed => Fault::new(
            Code::MalformedNumber,
            format!("`{text}` is not a finite number"),
            "expected a number",
            "numbers of a scene are finite, such as 1, 0.5 or 1e-3".to_owned(),
        ),
    })
}

fn is_integer(text: &str) -> bool {
    let digits = text.strip_prefix('-').unwrap_or(text);
    !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
}

fn whole(text: &str) -> Result<u64, Fault> {
    if !is_integer(text) || text.starts_with('-') {
        let message = format!("{text} is not a whole number from 0");
        let remedy = "write digits only".to_owned();
        return Err(Fault::new(Code::MalformedInteger, message, "expected a whole number", remedy));
    }
    text.parse().map_err(|_| {
        let message = format!("{text} is too large");
        Fault::new(Code::NumberOutOfRange, message, "too large", "use a smaller number".to_owned())
    })
}

impl Tree<'_> {
    fn unexpected(&self) -> Unexpected<'_> {
        match &self.value {
            Value::Null => Unexpected::Unit,
            Value::Boolean(truth) => Unexpected::Bool(*truth),
            Value::Number(_) => Unexpected::Other("a number"),
            Value::Text(text) => Unexpected::Str(text),
            Value::Array(_) => Unexpected::Other("a list"),
            Value::Table(_) => Unexpected::Other("a table"),
        }
    }

    fn wrong(&self, expected: &dyn serde::de::Expected) -> Fault {
        Fault::invalid_type(self.unexpected(), expected)
    }
}

type Reader<'t, 'a> = &'t Tree<'a>;

macro_rules! integers {
    ($($method:ident)+) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
            match &self.value {
                Value::Number(text) => whole(text).and_then(|number| visitor.visit_u64(number)),
                _ => Err(self.wrong(&visitor)),
            }
            .map_err(|fault: Fault| fault.at(self.span))
        }
    )+};
}

impl<'de, 't: 'de, 'a> Deserializer<'de> for Reader<'t, 'a> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match &self.value {
            Value::Null => visitor.visit_unit(),
            Value::Boolean(truth) => visitor.visit_bool(*truth),
            Value::Number(text) if is_integer(text) && !text.starts_with('-') => {
                whole(text).and_then(|number| visitor.visit_u64(number))
            }
            Value::Number(text) => number(text).and_then(|number| visitor.visit_f64(number)),
            Value::Text(text) => visitor.visit_borrowed_str(text),
            Value::Array(items) => {
                let mut items = Items(items.iter());
                let value = visitor.visit_seq(&mut items)?;
                match items.0.len() {
                    0 => Ok(value),
                    left => Err(Fault::custom(format!(
                        "the list has {left} item{} too many",
                        if left == 1 { "" } else { "s" }
                    ))),
                }
            }
            Value::Table(entries) => visitor.visit_map(Entries { entries: entries.iter(), value: None }),
        }
        .map_err(|fault: Fault| fault.at(self.span))
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match &self.value {
            Value::Number(text) => number(text).and_then(|number| visitor.visit_f64(number)),
            _ => Err(self.wrong(&visitor)),
        }
        .map_err(|fault: Fault| fault.at(self.span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match &self.value {
            Value::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        if name == PLACED {
            return visitor.visit_seq(Placed { span: self.span, state: 0, value: PlacedValue::Tree(self) });
        }
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match &self.value {
            Value::Text(text) => visitor.visit_enum(Word(text)),
            _ => Err(Fault::invalid_type(self.unexpected(), &"a word")),
        }
        .map_err(|fault: Fault| fault.at(self.span))
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_unit()
    }

    integers! {
        deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64 deserialize_u8 deserialize_u16 deserialize_u32
        deserialize_u64
    }

    serde::forward_to_deserialize_any! {
        bool char str string bytes byte_buf unit unit_struct seq map identifier
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.deserialize_f64(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Fault> {
        match &self.value {
            Value::Array(items) if items.len() != length => Err(Fault::invalid_length(items.len(), &visitor)),
            Value::Array(_) => self.deserialize_any(visitor),
            _ => Err(self.wrong(&visitor)),
        }
        .map_err(|fault: Fault| fault.at(self.span))
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match &self.value {
            Value::Table(_) => self.deserialize_any(visitor),
            _ => Err(Fault::invalid_type(self.unexpected(), &"a table")),
        }
        .map_err(|fault: Fault| fault.at(self.span))
    }
}

struct Items<'t, 'a>(std::slice::Iter<'t, Tree<'a>>);

impl<'de, 't: 'de, 'a> SeqAccess<'de> for &mut Items<'t, 'a> {
    type Error = Fault;
    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Fault> {
        self.0.next().map(|item| seed.deserialize(item).map_err(|fault| fault.at(item.span))).transpose()
    }
    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

struct Entries<'t, 'a> {
    entries: std::slice::Iter<'t, (Key<'a>, Tree<'a>)>,
    value: Option<&'t Tree<'a>>,
}

impl<'de, 't: 'de, 'a> MapAccess<'de> for Entries<'t, 'a> {
    type Error = Fault;
    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Fault> {
        let Some((key, value)) = self.entries.next() else { return Ok(None) };
        self.value = Some(value);
        seed.deserialize(KeyReader(key)).map(Some).map_err(|fault| fault.at(key.span))
    }
    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Fault> {
        let Some(value) = self.value.take() else { return Err(Fault::custom("a value without a name")) };
        seed.deserialize(value).map_err(|fault| fault.at(value.span))
    }
}

/// A key, as a text that may ask for its place.
struct KeyReader<'t, 'a>(&'t Key<'a>);

impl<'de, 't: 'de, 'a> Deserializer<'de> for KeyReader<'t, 'a> {
    type Error = Fault;
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_borrowed_str(&self.0.name)
    }
    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        if name == PLACED {
            let value = PlacedValue::<'t, 'a>::Key(&self.0.name);
            return visitor.visit_seq(Placed { span: self.0.span, state: 0, value });
        }
        visitor.visit_newtype_struct(self)
    }
    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

/// A place, then the value there.
struct Placed<'t, 'a> {
    span: Span,
    state: u8,
    value: PlacedValue<'t, 'a>,
}

#[derive(Clone, Copy)]
enum PlacedValue<'t, 'a> {
    Tree(&'t Tree<'a>),
    Key(&'t str),
}

impl<'de, 't: 'de, 'a> SeqAccess<'de> for Placed<'t, 'a> {
    type Error = Fault;
    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Fault> {
        self.state += 1;
        match (self.state, self.value) {
            (1, _) => {
                let length = self.span.end() - self.span.start();
                let parts = [self.span.start(), u64::from(self.span.line()), length];
                seed.deserialize(SeqDeserializer::new(parts.into_iter())).map(Some)
            }
            (2, PlacedValue::Tree(tree)) => {
                seed.deserialize(tree).map(Some).map_err(|fault| fault.at(tree.span))
            }
            (2, PlacedValue::Key(name)) => {
                let reader: StrDeserializer<'_, Fault> = name.into_deserializer();
                seed.deserialize(reader).map(Some).map_err(|fault| fault.at(self.span))
            }
            _ => Ok(None),
        }
    }
}

/// A variant without content.
struct Word<'t>(&'t str);

impl<'de, 't: 'de> EnumAccess<'de> for Word<'t> {
    type Error = Fault;
    type Variant = Self;
    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Fault> {
        let reader: StrDeserializer<'_, Fault> = self.0.into_deserializer();
        Ok((seed.deserialize(reader)?, self))
    }
}

impl<'de, 't: 'de> VariantAccess<'de> for Word<'t> {
    type Error = Fault;
    fn unit_variant(self) -> Result<(), Fault> {
        Ok(())
    }
    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, _: S) -> Result<S::Value, Fault> {
        Err(Fault::custom("expected a word"))
    }
    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, Fault> {
        Err(Fault::custom("expected a word"))
    }
    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, Fault> {
        Err(Fault::custom("expected a word"))
    }
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use crate::diagnostic::{Diagnostic, Result};

    fn lines(read: Result<Scene>) -> Vec<u32> {
        let Err(first) = read else { return Vec::new() };
        [&first].into_iter().chain(first.further()).map(Diagnostic::span).map(|span| span.line()).collect()
    }

    /// Every value of a document that is wrong is told in one run, each once, and not what lacks a value that is wrong.
    #[test]
    fn every_fault_of_a_document_is_told_in_one_run() {
        let toml = |text: &str| lines(Scene::parse_toml("s.toml", text));
        assert_eq!(toml("[nodes]\n1 = [0, 0, 0]\n2 = [1, 0, 0]\n"), Vec::<u32>::new());
        let wrong = "axisymmetric = 3\n[nodes]\n1 = [0, 0, 'x']\n2 = [1, 0]\n3 = [0, 'y', 'z']\n4 = [1, 1, 0]\n\
            [[elements]]\ntype = 5\n[[elements]]\nkind = 3\n";
        assert_eq!(toml(wrong), [1, 3, 5, 5, 7]);
        // No TOML at all, at three places.
        assert_eq!(toml("[nodes]\n1 = = [0, 0, 0]\n2 = [1, 0, 0]\n3 = ]\n4 = [0, 0\n"), [2, 4, 5]);
        let json = |text: &str| lines(Scene::parse_json("s.json", text));
        let wrong = "{\"nodes\": {\n\"1\": [0, 0, true],\n\"2\": [1, 0, 0],\n\"2\": [1, 0, 0],\n\"3\": 7},\n\"node\": 1,\n\
            \"states\": [{\"number\": -1}]}";
        assert_eq!(json(wrong), [2, 4, 5, 6, 7]);
        let late = "{\"nodes\": {\"1\": [0, 0, 0]},\n\"rotating_nodes\": [7,\n 8],\n\"states\": [{\"nodes\": {\n\"9\": {}}},\n\
            {\"nodes\": {\"1\": {\"quaternion\": [2, 0, 0, 0]}}}]}";
        assert_eq!(json(late), [2, 3, 5, 6]);
    }
}
