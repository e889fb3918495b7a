//! Documents of states, or of something else by state, from JSON, as they are read.

use crate::diagnostic::{Code, Result};
use crate::forces::JsonForces;
use crate::model::Scene;
use crate::model::State;
use crate::model::{ForceSign, StateForces};
use crate::states::faults::{Context, Documents};
use crate::states::source::Source;
use crate::states::table::empty;
use crate::states::{Fault, Motion, SCHEMA, Take, check_motion, check_node, label};
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use std::cell::{Cell, RefCell};
use std::fmt;
use std::ops::ControlFlow;

/// Hands on the states of a document, one after another.
pub(super) fn states(source: Source<'_>, scene: &Scene, take: &mut Take<'_>) -> Result<()> {
    let example = "{\"time\": 0, \"nodes\": {\"1\": {\"displacement\": [0, 0, 0]}}}";
    let documents = Documents::new(scene);
    documents.list(source, (SCHEMA, example), JsonState(documents.context()), take)
}

impl Documents<'_> {
    /// Hands on what a document lists under `states`, one after another, as the seed reads it. The form is a schema, by name, and an
    /// example of one.
    pub(crate) fn list<T, S>(
        &self,
        source: Source<'_>,
        (schema, example): (&'static str, &str),
        seed: S,
        take: &mut dyn FnMut(T) -> ControlFlow<()>,
    ) -> Result<()>
    where
        S: Copy + for<'de> DeserializeSeed<'de, Value = T>,
    {
        let form = format!("{{\"schema\": \"{schema}\", \"states\": [{example}]}}");
        let take = RefCell::new(take);
        let (count, stopped) = (Cell::new(0_u64), Cell::new(false));
        let each = |one: T| {
            if self.is_clean() {
                count.set(count.get() + 1);
                stopped.set(take.borrow_mut()(one).is_break());
            }
            !stopped.get()
        };
        let read = self.read(source, &form, || {
            JsonFile(JsonList { context: self.context(), schema, seed, each: &each })
        });
        if stopped.get() {
            return Ok(());
        }
        read?;
        if count.get() == 0 { Err(empty("states")) } else { Ok(()) }
    }
}

/// An object with the name of a schema and a list.
struct JsonFile<'a, T, S>(JsonList<'a, T, S>);

/// A list, read for as long as `each` says so.
struct JsonList<'a, T, S> {
    context: Context<'a>,
    schema: &'static str,
    seed: S,
    each: &'a dyn Fn(T) -> bool,
}

impl<'de, T, S: Copy + DeserializeSeed<'de, Value = T>> DeserializeSeed<'de> for JsonFile<'_, T, S> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de, T, S: Copy + DeserializeSeed<'de, Value = T>> DeserializeSeed<'de> for &JsonList<'_, T, S> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, T, S: Copy + DeserializeSeed<'de, Value = T>> Visitor<'de> for JsonFile<'_, T, S> {
    type Value = ();
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with `schema` and `states`")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let (mut schema, mut list) = (false, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "schema" => {
                    once(schema, "schema")?;
                    schema = true;
                    let written: String = map.next_value()?;
                    if written != self.0.schema {
                        let message = format!("the schema is `{written}`");
                        let remedy = format!("write \"schema\": \"{}\"", self.0.schema);
                        return Err(self.0.context.stop(Fault::new(Code::StatesMalformed, message, remedy)));
                    }
                }
                "states" => {
                    once(list.is_some(), "states")?;
                    list = Some(map.next_value_seed(&self.0)?);
                }
                other => return Err(A::Error::unknown_field(other, &["schema", "states"])),
            }
        }
        if !schema {
            return Err(A::Error::missing_field("schema"));
        }
        list.ok_or_else(|| A::Error::missing_field("states"))
    }
}

impl<'de, T, S: Copy + DeserializeSeed<'de, Value = T>> Visitor<'de> for &JsonList<'_, T, S> {
    type Value = ();
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an array of states")
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        while let Some(one) = sequence.next_element_seed(self.seed)? {
            if !(self.each)(one) {
                return Err(A::Error::custom("stopped"));
            }
        }
        Ok(())
    }
}

pub(crate) fn once<E: serde::de::Error>(seen: bool, name: &'static str) -> Result<(), E> {
    if seen { Err(E::duplicate_field(name)) } else { Ok(()) }
}

#[derive(Clone, Copy)]
struct JsonState<'a>(Context<'a>);

struct JsonNodes<'a>(Context<'a>);

impl<'de> DeserializeSeed<'de> for JsonState<'_> {
    type Value = State;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<State, D::Error> {
        let state = deserializer.deserialize_map(self)?;
        self.0.count(state.number)?;
        Ok(state)
    }
}

impl<'de> DeserializeSeed<'de> for JsonNodes<'_> {
    type Value = State;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<State, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for JsonState<'_> {
    type Value = State;
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with `time`, `nodes` and `forces`")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<State, A::Error> {
        let (mut number, mut time, mut state, mut forces) = (None, None, None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "number" => {
                    once(number.is_some(), "number")?;
                    number = self.0.value_of::<u64, A>(&mut map, "number")?;
                }
                "time" => {
                    once(time.is_some(), "time")?;
                    time = self.0.value_of::<f64, A>(&mut map, "time")?;
                }
                "nodes" => {
                    once(state.is_some(), "nodes")?;
                    state = Some(map.next_value_seed(JsonNodes(self.0))?);
                }
                "forces" => {
                    once(forces.is_some(), "forces")?;
                    let of_state = JsonForces { context: self.0, sign: ForceSign::Internal };
                    forces = Some(map.next_value_seed(of_state)?);
                }
                other => self.0.unknown(&mut map, other, &["number", "time", "nodes", "forces"])?,
            }
        }
        let state: State = state.ok_or_else(|| A::Error::missing_field("nodes"))?;
        let StateForces { elements, mpcs } = forces.unwrap_or_default();
        Ok(State { number, time, forces: elements, mpc_forces: mpcs, ..state })
    }
}

impl<'de> Visitor<'de> for JsonNodes<'_> {
    type Value = State;
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with a motion for each node number")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<State, A::Error> {
        let mut state = State::default();
        while let Some(key) = map.next_key::<String>()? {
            let named = label(&key, "node");
            let named = named.and_then(|node| check_node(node, self.0.scene, &state).map(|()| node));
            let node = self.0.value(named)?;
            let motion = self.0.value_of::<Motion, A>(&mut map, &format!("node {key}"))?;
            let Some(motion) = motion else { continue };
            let (Some(node), Some(motion)) = (node, self.0.value(motion.checked())?) else { continue };
            self.0.value(check_motion(node, &motion, self.0.freedom()))?;
            state.nodes.insert(node, motion);
        }
        Ok(state)
    }
}
