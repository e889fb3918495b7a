//! Forces from JSON, as they are read.

use crate::diagnostic::{Code, Result};
use crate::forces::{Group, Owner, Take};
use crate::model::Scene;
use crate::model::{ElementForces, ForceSign, StateForces};
use crate::states;
use crate::states::{Context, Documents, Fault, Source};
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use std::cell::{Cell, RefCell};
use std::fmt;

const SCHEMA: &str = "pintle-forces/1";

/// What becomes of the forces of a state: a fault stops the reading, and none does so too.
type Each<'a> = dyn Fn(Group) -> Result<(), Option<Fault>> + 'a;

#[derive(Clone, Copy)]
struct JsonFile<'a> {
    context: Context<'a>,
    sign: ForceSign,
    each: &'a Each<'a>,
}

/// Hands on the forces of a document, state by state.
pub(super) fn groups(source: Source<'_>, scene: &Scene, sign: ForceSign, take: &mut Take<'_>) -> Result<()> {
    let form = format!(
        "{{\"schema\": \"{SCHEMA}\", \"states\": [{{\"state\": 0, \"forces\": {{\"101\": {{\"f1\": 0}}}}}}]}}"
    );
    let take = RefCell::new(take);
    let (count, stopped) = (Cell::new(0_u64), Cell::new(false));
    let documents = Documents::new(scene);
    let each = |group: Group| {
        if !documents.is_clean() {
            return Ok(());
        }
        count.set(count.get() + 1);
        stopped.set(take.borrow_mut()(group).is_break());
        if stopped.get() { Err(None) } else { Ok(()) }
    };
    let file = JsonFile { context: documents.context(None), sign, each: &each };
    let read = documents.read(source, &form, file);
    if stopped.get() {
        return Ok(());
    }
    read?;
    if count.get() == 0 { Err(states::empty("states")) } else { Ok(()) }
}

/// The forces of one state by element number.
pub(crate) struct JsonForces<'a> {
    pub(crate) context: Context<'a>,
    pub(crate) sign: ForceSign,
}

struct JsonGroups<'a>(JsonFile<'a>);

struct JsonGroup<'a>(JsonFile<'a>);

struct JsonElement<'a> {
    context: Context<'a>,
    sign: ForceSign,
}

macro_rules! seed {
    ($name:ident, $output:ty, $method:ident) => {
        impl<'de> DeserializeSeed<'de> for $name<'_> {
            type Value = $output;
            fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<$output, D::Error> {
                deserializer.$method(self)
            }
        }
    };
}

seed!(JsonFile, (), deserialize_map);
seed!(JsonGroups, (), deserialize_seq);
seed!(JsonGroup, Group, deserialize_map);
seed!(JsonForces, StateForces, deserialize_map);
seed!(JsonElement, ElementForces, deserialize_map);

impl<'de> Visitor<'de> for JsonFile<'_> {
    type Value = ();
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with `schema` and `states`")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let (mut schema, mut groups) = (false, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "schema" => {
                    states::once(schema, "schema")?;
                    schema = true;
                    let written: String = map.next_value()?;
                    if written != SCHEMA {
                        let message = format!("the schema is `{written}`");
                        let remedy = format!("write \"schema\": \"{SCHEMA}\"");
                        return Err(self.context.stop(Fault::new(Code::StatesMalformed, message, remedy)));
                    }
                }
                "states" => {
                    states::once(groups.is_some(), "states")?;
                    groups = Some(map.next_value_seed(JsonGroups(self))?);
                }
                other => return Err(A::Error::unknown_field(other, &["schema", "states"])),
            }
        }
        if !schema {
            return Err(A::Error::missing_field("schema"));
        }
        groups.ok_or_else(|| A::Error::missing_field("states"))
    }
}

impl<'de> Visitor<'de> for JsonGroups<'_> {
    type Value = ();
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an array of states")
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        while let Some(group) = sequence.next_element_seed(JsonGroup(self.0))? {
            (self.0.each)(group).map_err(|fault| match fault {
                Some(fault) => self.0.context.stop(fault),
                None => A::Error::custom("stopped"),
            })?;
        }
        Ok(())
    }
}

impl<'de> Visitor<'de> for JsonGroup<'_> {
    type Value = Group;
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with `state` or `time`, and `forces`")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Group, A::Error> {
        let (mut group, mut forces) = (Group::default(), None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "state" => {
                    states::once(group.state.is_some(), "state")?;
                    group.span = self.0.context.place(&key);
                    group.state = self.0.context.value_of(&mut map, "state")?;
                }
                "time" => {
                    states::once(group.time.is_some(), "time")?;
                    if group.state.is_none() {
                        group.span = self.0.context.place(&key);
                    }
                    group.time = self.0.context.value_of(&mut map, "time")?;
                }
                "forces" => {
                    states::once(forces.is_some(), "forces")?;
                    if !group.span.is_known() {
                        group.span = self.0.context.place(&key);
                    }
                    let JsonFile { context, sign, .. } = self.0;
                    forces = Some(map.next_value_seed(JsonForces { context, sign })?);
                }
                other => self.0.context.unknown(&mut map, other, &["state", "time", "forces"])?,
            }
        }
        group.forces = forces.ok_or_else(|| A::Error::missing_field("forces"))?;
        Ok(group)
    }
}

impl<'de> Visitor<'de> for JsonForces<'_> {
    type Value = StateForces;
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with forces for each element number")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let Self { context, sign } = self;
        let mut found = StateForces::default();
        while let Some(key) = map.next_key::<String>()? {
            let owner = Owner::named(&key, context.scene);
            let owner = owner.and_then(|owner| found.check(&owner).map(|()| owner));
            let span = context.place(&key);
            let owner = context.value(owner)?;
            let forces = map.next_value_seed(JsonElement { context, sign })?;
            if let Some(owner) = owner {
                found.insert(owner, ElementForces { span, ..forces });
            }
        }
        Ok(found)
    }
}

impl<'de> Visitor<'de> for JsonElement<'_> {
    type Value = ElementForces;
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with f1, m2 …")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ElementForces, A::Error> {
        let mut forces = ElementForces { sign: self.sign, ..ElementForces::default() };
        while let Some(key) = map.next_key::<String>()? {
            let value = self.context.value_of::<Option<f64>, A>(&mut map, &key)?;
            if let Some(value) = value {
                self.context.value(forces.set(&key, value))?;
            }
        }
        Ok(forces)
    }
}
