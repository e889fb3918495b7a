//! Forces from JSON, as they are read.

use crate::diagnostic::Result;
use crate::forces::{Group, Owner, Take};
use crate::model::Scene;
use crate::model::{ElementForces, ForceSign, StateForces};
use crate::states;
use crate::states::{Context, Documents, Source};
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, Visitor};
use std::fmt;

const SCHEMA: &str = "pintle-forces/1";

/// Hands on the forces of a document, state by state.
pub(super) fn groups(source: Source<'_>, scene: &Scene, sign: ForceSign, take: &mut Take<'_>) -> Result<()> {
    let example = "{\"state\": 0, \"forces\": {\"101\": {\"f1\": 0}}}";
    let documents = Documents::new(scene);
    let forces = JsonForces { context: documents.context(), sign };
    documents.list(source, (SCHEMA, example), JsonGroup(forces), take)
}

/// The forces of one state by element number.
#[derive(Clone, Copy)]
pub(crate) struct JsonForces<'a> {
    pub(crate) context: Context<'a>,
    pub(crate) sign: ForceSign,
}

#[derive(Clone, Copy)]
struct JsonGroup<'a>(JsonForces<'a>);

struct JsonElement<'a>(JsonForces<'a>);

macro_rules! seed {
    ($name:ident, $output:ty) => {
        impl<'de> DeserializeSeed<'de> for $name<'_> {
            type Value = $output;
            fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<$output, D::Error> {
                deserializer.deserialize_map(self)
            }
        }
    };
}

seed!(JsonGroup, Group);
seed!(JsonForces, StateForces);
seed!(JsonElement, ElementForces);

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
                    forces = Some(map.next_value_seed(self.0)?);
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
        let Self { context, .. } = self;
        let mut found = StateForces::default();
        while let Some(key) = map.next_key::<String>()? {
            let owner = Owner::named(&key, context.scene);
            let owner = owner.and_then(|owner| found.check(&owner).map(|()| owner));
            let span = context.place(&key);
            let owner = context.value(owner)?;
            let forces = map.next_value_seed(JsonElement(self))?;
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
        let mut forces = ElementForces { sign: self.0.sign, ..ElementForces::default() };
        while let Some(key) = map.next_key::<String>()? {
            let value = self.0.context.value_of::<Option<f64>, A>(&mut map, &key)?;
            if let Some(value) = value {
                self.0.context.value(forces.set(&key, value))?;
            }
        }
        Ok(forces)
    }
}
