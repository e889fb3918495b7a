//! States from JSON, as they are read.

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

/// Hands on the states of a document, one after another.
pub(super) fn states(source: Source<'_>, scene: &Scene, take: &mut Take<'_>) -> Result<()> {
    let form = format!(
        "{{\"schema\": \"{SCHEMA}\", \"states\": [{{\"time\": 0, \"nodes\": {{\"1\": {{\"displacement\": [0, 0, 0]}}}}}}]}}"
    );
    let take = RefCell::new(take);
    let (count, stopped) = (Cell::new(0_u64), Cell::new(false));
    let documents = Documents::new(scene);
    let each = |state: State| {
        if !documents.is_clean() {
            return Ok(());
        }
        count.set(count.get() + 1);
        stopped.set(take.borrow_mut()(state).is_break());
        if stopped.get() { Err(None) } else { Ok(()) }
    };
    let read = documents.read(source, &form, JsonFile(documents.context(Some(&each))));
    if stopped.get() {
        return Ok(());
    }
    read?;
    if count.get() == 0 { Err(empty("states")) } else { Ok(()) }
}

/// One JSON object or array, read with the scene at hand.
macro_rules! seed {
    ($name:ident, $output:ty, $method:ident, $expecting:literal) => {
        #[derive(Clone, Copy)]
        struct $name<'a>(Context<'a>);

        impl<'de> DeserializeSeed<'de> for $name<'_> {
            type Value = $output;
            fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<$output, D::Error> {
                deserializer.$method(self)
            }
        }

        impl $name<'_> {
            fn describe(formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str($expecting)
            }
        }
    };
}

seed!(JsonFile, (), deserialize_map, "an object with `schema` and `states`");
seed!(JsonStates, (), deserialize_seq, "an array of states");
seed!(JsonState, State, deserialize_map, "an object with `time`, `nodes` and `forces`");
seed!(JsonNodes, State, deserialize_map, "an object with a motion for each node number");

pub(crate) fn once<E: serde::de::Error>(seen: bool, name: &'static str) -> Result<(), E> {
    if seen { Err(E::duplicate_field(name)) } else { Ok(()) }
}

impl<'de> Visitor<'de> for JsonFile<'_> {
    type Value = ();
    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Self::describe(formatter)
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let (mut schema, mut states) = (false, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "schema" => {
                    once(schema, "schema")?;
                    schema = true;
                    let written: String = map.next_value()?;
                    if written != SCHEMA {
                        let message = format!("the schema is `{written}`");
                        let remedy = format!("write \"schema\": \"{SCHEMA}\"");
                        return Err(self.0.stop(Fault::new(Code::StatesMalformed, message, remedy)));
                    }
                }
                "states" => {
                    once(states.is_some(), "states")?;
                    states = Some(map.next_value_seed(JsonStates(self.0))?);
                }
                other => return Err(A::Error::unknown_field(other, &["schema", "states"])),
            }
        }
        if !schema {
            return Err(A::Error::missing_field("schema"));
        }
        states.ok_or_else(|| A::Error::missing_field("states"))
    }
}

impl<'de> Visitor<'de> for JsonStates<'_> {
    type Value = ();
    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Self::describe(formatter)
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        while let Some(state) = sequence.next_element_seed(JsonState(self.0))? {
            self.0.count(state.number)?;
            let Some(take) = self.0.states else { continue };
            take(state).map_err(|fault| match fault {
                Some(fault) => self.0.stop(fault),
                None => A::Error::custom("stopped"),
            })?;
        }
        Ok(())
    }
}

impl<'de> Visitor<'de> for JsonState<'_> {
    type Value = State;
    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Self::describe(formatter)
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
    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Self::describe(formatter)
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
