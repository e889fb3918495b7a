//! States from JSON, as they are read.

use crate::diagnostic::{Code, Diagnostic, Result};
use crate::forces::{ForceSign, JsonForces, StateForces};
use crate::freedom::NodeFreedom;
use crate::model::Scene;
use crate::span::Span;
use crate::states::source::{Source, unreadable};
use crate::states::table::empty;
use crate::states::{Fault, Motion, SCHEMA, State, Take, check_motion, check_node, check_number, label};
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use std::cell::{Cell, RefCell};
use std::io;

/// Carries the scene, and the fault of our own that stopped the reading, through serde.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub(crate) scene: &'a Scene,
    freedom: &'a NodeFreedom,
    fault: &'a Cell<Option<Fault>>,
    /// What becomes of a state: a fault stops the reading, and none does so too.
    states: Option<&'a dyn Fn(State) -> Result<(), Option<Fault>>>,
}

impl Context<'_> {
    pub(crate) fn stop<E: serde::de::Error>(self, fault: Fault) -> E {
        let error = E::custom(&fault.message);
        self.fault.set(Some(fault));
        error
    }
}

/// Hands on the states of a document, one after another.
pub(super) fn states(source: Source<'_>, scene: &Scene, take: &mut Take<'_>) -> Result<()> {
    let form = format!(
        "{{\"schema\": \"{SCHEMA}\", \"states\": [{{\"time\": 0, \"nodes\": {{\"1\": {{\"displacement\": [0, 0, 0]}}}}}}]}}"
    );
    let take = RefCell::new(take);
    let (count, last) = (Cell::new(0_u64), Cell::new(None));
    let stopped = Cell::new(false);
    let each = |state: State| {
        check_number(last.get(), state.number).map_err(Some)?;
        last.set(Some(state.number));
        count.set(count.get() + 1);
        let flow = take.borrow_mut()(state);
        stopped.set(flow.is_break());
        if flow.is_break() { Err(None) } else { Ok(()) }
    };
    let read = match source {
        Source::Text(text) => {
            let mut reader = serde_json::Deserializer::from_str(text);
            read_json(&mut reader, source, scene, &form, Some(&each), |context, reader| {
                JsonFile(context).deserialize(reader)
            })
        }
        Source::File(_) => {
            let file = source.reader(0).map_err(|error| unreadable(&error))?;
            let mut reader = serde_json::Deserializer::from_reader(file);
            read_json(&mut reader, source, scene, &form, Some(&each), |context, reader| {
                JsonFile(context).deserialize(reader)
            })
        }
    };
    if stopped.get() {
        return Ok(());
    }
    read?;
    if count.get() == 0 { Err(empty("states")) } else { Ok(()) }
}

/// Reads a document with `take`; `form` shows an example in the remedy.
pub(crate) fn read_json<'de, R: serde_json::de::Read<'de>, T>(
    reader: &mut serde_json::Deserializer<R>,
    source: Source<'_>,
    scene: &Scene,
    form: &str,
    states: Option<&dyn Fn(State) -> Result<(), Option<Fault>>>,
    take: impl FnOnce(Context<'_>, &mut serde_json::Deserializer<R>) -> Result<T, serde_json::Error>,
) -> Result<T> {
    let fault = Cell::new(None);
    let freedom = NodeFreedom::of(scene);
    let context = Context { scene, freedom: &freedom, fault: &fault, states };
    let result = take(context, reader).and_then(|read| reader.end().map(|()| read));
    result.map_err(|error| {
        let span = json_place(source, error.line(), error.column());
        match fault.take() {
            Some(fault) => fault.at(span, "ends here"),
            None if error.is_io() => unreadable(&io::Error::from(error)),
            None => {
                let message = error.to_string();
                let message = message.split(" at line ").next().unwrap_or_default().to_owned();
                let remedy = format!("the form is {form}");
                Diagnostic::error(Code::StatesMalformed, span, message, "here").help(remedy)
            }
        }
    })
}

/// The byte at 1-based `line` and `column` (in bytes).
fn json_place(source: Source<'_>, line: usize, column: usize) -> Span {
    let before = source.length_of_lines(line.saturating_sub(1));
    let start = (before + column.saturating_sub(1) as u64).min(source.length());
    Span::new(0, u32::try_from(line.max(1)).unwrap_or(u32::MAX), start, 1)
}

/// One JSON object or array, read with the scene at hand.
macro_rules! seed {
    ($name:ident, $output:ty, $method:ident, $expecting:literal) => {
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
                    number = Some(map.next_value::<u64>()?);
                }
                "time" => {
                    once(time.is_some(), "time")?;
                    time = Some(map.next_value::<f64>()?);
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
                other => return Err(A::Error::unknown_field(other, &["number", "time", "nodes", "forces"])),
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
            let node = label(&key, "node").map_err(|fault| self.0.stop(fault))?;
            check_node(node, self.0.scene, &state).map_err(|fault| self.0.stop(fault))?;
            let motion: Motion = map.next_value()?;
            let motion = motion.checked().map_err(|fault| self.0.stop(fault))?;
            check_motion(node, &motion, self.0.freedom).map_err(|fault| self.0.stop(fault))?;
            state.nodes.insert(node, motion);
        }
        Ok(state)
    }
}
