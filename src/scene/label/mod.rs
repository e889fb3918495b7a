//! What nodes and elements are called: a number, and the instance of a part that they belong to.

pub(crate) mod labelled;

use serde::de::{self, Deserialize, Deserializer, Visitor};
use serde::{Serialize, Serializer};
use std::cmp::Ordering;
use std::collections::HashSet;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::str::FromStr;
use std::sync::{LazyLock, PoisonError, RwLock};

/// The largest node or element number: up to it, a double holds every whole number.
pub const MAX_LABEL: u64 = 1 << 53;

/// Blanks collapsed, upper case.
pub(crate) fn normal(text: &str) -> String {
    let mut name = String::with_capacity(text.len());
    for word in text.split_ascii_whitespace() {
        if !name.is_empty() {
            name.push(' ');
        }
        name.push_str(&word.to_ascii_uppercase());
    }
    name
}

/// The name of an instance of a part. Equal names are one name: it is copied and compared as a pointer.
///
/// Names are kept for as long as the program runs, each of them once, so that a label needs no memory of its own.
#[derive(Clone, Copy)]
pub struct Instance(&'static Name);

/// A name in its place. A thin pointer to it is half of one to its text.
struct Name(Box<str>);

#[derive(Clone, Copy)]
struct Known(&'static Name);

impl std::borrow::Borrow<str> for Known {
    fn borrow(&self) -> &str {
        &self.0.0
    }
}

impl PartialEq for Known {
    fn eq(&self, other: &Self) -> bool {
        self.0.0 == other.0.0
    }
}

impl Eq for Known {}

impl Hash for Known {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.0.hash(state);
    }
}

static NAMES: LazyLock<RwLock<HashSet<Known>>> = LazyLock::new(RwLock::default);

impl Instance {
    /// The instance called `name`, as it stands.
    #[must_use]
    pub fn named(name: &str) -> Self {
        let known = NAMES.read().unwrap_or_else(PoisonError::into_inner).get(name).copied();
        if let Some(Known(name)) = known {
            return Self(name);
        }
        let mut names = NAMES.write().unwrap_or_else(PoisonError::into_inner);
        let known = names.get(name).copied().unwrap_or_else(|| {
            let new = Known(Box::leak(Box::new(Name(name.into()))));
            names.insert(new);
            new
        });
        Self(known.0)
    }

    /// What is called `name` within it, as it is called outside: `CRANK-1.NAME`.
    #[must_use]
    pub fn scoped(self, name: &str) -> String {
        format!("{}.{name}", self.name())
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        &self.0.0
    }
}

impl PartialEq for Instance {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for Instance {}

impl Ord for Instance {
    fn cmp(&self, other: &Self) -> Ordering {
        if self == other { Ordering::Equal } else { self.name().cmp(other.name()) }
    }
}

impl PartialOrd for Instance {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Hash for Instance {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::ptr::from_ref(self.0).hash(state);
    }
}

impl fmt::Debug for Instance {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{self}")
    }
}

/// As a deck writes it: between quotation marks if it would not be the same name without them.
impl fmt::Display for Instance {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.name();
        let plain = normal(name) == name && !name.contains([' ', ',', '"', '=', '*']);
        if plain { formatter.write_str(name) } else { write!(formatter, "\"{name}\"") }
    }
}

/// The number of a node or element, and the instance of a part that numbers it.
///
/// A deck without parts has numbers alone: `5`. In an assembly, node 5 of the instance CRANK-1 is `CRANK-1.5`, and what the
/// assembly itself defines, such as a reference point, has a number alone again. Sixteen bytes, for a deck may have a
/// million of them. Numbers without an instance come first in their order; then instances by name.
///
/// ```
/// use pintle_scene::Label;
///
/// let label: Label = "crank-1.5".parse()?;
/// assert_eq!((label.to_string().as_str(), label.number()), ("CRANK-1.5", 5));
/// assert_eq!("5".parse(), Ok(Label::from(5)));
/// assert!(Label::from(7) < label);
/// # Ok::<(), pintle_scene::LabelError>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Label {
    instance: Option<Instance>,
    number: u64,
}

impl Label {
    /// The number `number` of an instance.
    #[must_use]
    pub const fn of(instance: Option<Instance>, number: u64) -> Self {
        Self { instance, number }
    }

    /// The instance that numbers it; none is the assembly, or a deck without parts.
    #[must_use]
    pub const fn instance(self) -> Option<Instance> {
        self.instance
    }

    /// The number.
    #[must_use]
    pub const fn number(self) -> u64 {
        self.number
    }
}

/// The instance first: [`crate::LabelState`] keeps what has the same one, and numbers that are neighbours, together.
impl Hash for Label {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let instance = self.instance.map_or(0, |Instance(name)| std::ptr::from_ref(name).addr());
        state.write_usize(instance);
        state.write_u64(self.number);
    }
}

impl From<u64> for Label {
    fn from(number: u64) -> Self {
        Self { instance: None, number }
    }
}

impl PartialEq<u64> for Label {
    fn eq(&self, number: &u64) -> bool {
        self.instance.is_none() && self.number == *number
    }
}

impl fmt::Display for Label {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.instance {
            Some(instance) => write!(formatter, "{instance}.{}", self.number),
            None => write!(formatter, "{}", self.number),
        }
    }
}

impl fmt::Debug for Label {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{self}")
    }
}

/// Why a text is not a label.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LabelError {
    /// Neither digits nor a name, a full stop and digits.
    #[error("`{0}` is neither a number nor INSTANCE.NUMBER")]
    Malformed(String),
    /// Zero, or beyond [`MAX_LABEL`].
    #[error("the number of `{0}` must be from 1 to 2^53")]
    OutOfRange(String),
}

/// `name.number` in its two halves, `"name".number` and `"name.number"` likewise; quotation marks are gone, names without
/// them are in upper case. The first half is nothing when there is no full stop outside quotation marks or within a
/// pair that surrounds everything.
pub(super) fn split(text: &str) -> (Option<String>, &str) {
    let inner = text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    let whole = inner.filter(|inner| !inner.contains('"'));
    let Some((name, rest)) = whole.unwrap_or(text).rsplit_once('.') else { return (None, text) };
    let quoted = name.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    let name = match quoted.or(whole.map(|_| name)) {
        Some(exact) => exact.trim().to_owned(),
        None => normal(name),
    };
    (Some(name), rest)
}

impl FromStr for Label {
    type Err = LabelError;

    fn from_str(text: &str) -> Result<Self, LabelError> {
        let text = text.trim_ascii();
        let (name, digits) = match split(text) {
            (None, whole) => (None, whole),
            (Some(name), digits) if !name.is_empty() && !name.contains('"') => (Some(name), digits),
            _ => return Err(LabelError::Malformed(text.to_owned())),
        };
        if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(LabelError::Malformed(text.to_owned()));
        }
        let number = digits.parse().ok().filter(|number| (1..=MAX_LABEL).contains(number));
        let number = number.ok_or_else(|| LabelError::OutOfRange(text.to_owned()))?;
        // `1.5` is a number with a decimal point, not node 5 of an instance called 1.
        let numeric = |name: &String| {
            name.starts_with(|letter: char| letter.is_ascii_digit() || "+-.".contains(letter))
        };
        if name.as_ref().is_some_and(|name| numeric(name) && !text.starts_with('"')) {
            return Err(LabelError::Malformed(text.to_owned()));
        }
        Ok(Self { instance: name.as_deref().map(Instance::named), number })
    }
}

/// A number where there is no instance, otherwise a text.
impl Serialize for Label {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.instance {
            None => serializer.serialize_u64(self.number),
            Some(_) => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for Label {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;

        impl Visitor<'_> for Reader {
            type Value = Label;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a number from 1, or a text like \"CRANK-1.5\"")
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<Label, E> {
                if (1..=MAX_LABEL).contains(&number) {
                    return Ok(Label::from(number));
                }
                Err(E::custom(LabelError::OutOfRange(number.to_string())))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Label, E> {
                let known = u64::try_from(number);
                known.map_or_else(
                    |_| Err(E::custom(LabelError::OutOfRange(number.to_string()))),
                    |number| self.visit_u64(number),
                )
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Label, E> {
                text.parse().map_err(E::custom)
            }
        }

        deserializer.deserialize_any(Reader)
    }
}

#[cfg(test)]
mod tests {
    use super::{Instance, Label, LabelError};
    use std::collections::BTreeMap;

    fn label(text: &str) -> Label {
        text.parse().unwrap()
    }

    #[test]
    fn labels_are_small_and_come_back() {
        assert_eq!(size_of::<Label>(), 16);
        for (text, shown) in [
            ("5", "5"),
            (" 007 ", "7"),
            ("crank-1.5", "CRANK-1.5"),
            ("CRANK-1.005", "CRANK-1.5"),
            ("\"my part-1\".5", "\"my part-1\".5"),
            ("\"my part-1.5\"", "\"my part-1\".5"),
            ("\"CRANK-1\".5", "CRANK-1.5"),
            ("a.b.5", "A.B.5"),
            ("\"1\".5", "1.5"),
        ] {
            assert_eq!(label(text).to_string(), shown);
            if text != "\"1\".5" {
                assert_eq!(label(shown), label(text));
            }
        }
    }

    #[test]
    fn what_is_not_a_label() {
        for text in [
            "",
            "x",
            "CRANK-1",
            "CRANK-1.",
            ".5",
            "1.5",
            "-5",
            "+5",
            "1e3",
            "CRANK-1.x",
            "\"a.5",
            "a\".5",
            "\"\".5",
        ] {
            assert_eq!(text.parse::<Label>(), Err(LabelError::Malformed(text.to_owned())), "{text}");
        }
        for text in ["0", "A-1.0", "9007199254740993", "A-1.99999999999999999999999"] {
            assert_eq!(text.parse::<Label>(), Err(LabelError::OutOfRange(text.to_owned())), "{text}");
        }
    }

    #[test]
    fn order_is_by_name_whoever_came_first() {
        let (late, early) =
            (Instance::named("ZZZ of the order test"), Instance::named("AAA of the order test"));
        assert!(early < late);
        let mut labels = vec![
            Label::of(Some(late), 1),
            Label::of(Some(early), 20),
            Label::from(9),
            Label::of(Some(early), 3),
        ];
        labels.sort();
        assert_eq!(
            labels,
            [Label::from(9), Label::of(Some(early), 3), Label::of(Some(early), 20), Label::of(Some(late), 1)]
        );
    }

    #[test]
    fn json_has_numbers_and_texts() {
        let labels = vec![label("5"), label("crank-1.5")];
        assert_eq!(serde_json::to_string(&labels).unwrap(), "[5,\"CRANK-1.5\"]");
        assert_eq!(serde_json::from_str::<Vec<Label>>("[5,\"Crank-1.5\"]").unwrap(), labels);
        let map: BTreeMap<Label, u8> = labels.iter().map(|label| (*label, 1)).collect();
        let json = serde_json::to_string(&map).unwrap();
        assert_eq!(json, "{\"5\":1,\"CRANK-1.5\":1}");
        assert_eq!(serde_json::from_str::<BTreeMap<Label, u8>>(&json).unwrap(), map);
        for wrong in ["[0]", "[-1]", "[\"0\"]", "[1.5]", "[\"x\"]"] {
            assert!(serde_json::from_str::<Vec<Label>>(wrong).is_err(), "{wrong}");
        }
    }
}
