//! Component forces of connectors, state by state, as FE codes export them.
//!
//! # Names
//! `f1` `f2` `f3` `m1` `m2` `m3`, or `CTF1` … `CTM3`: the total force CTF = CEF + CVF + CSF + CRF − CCF of each component. `CRF1` …
//! `CRM3`: the reaction, which is the total force of a constrained component; of an available one it is a part, and the total has
//! to be given. Components that a connector does not have may be 0.
//!
//! # CSV
//! The first line names the columns, in any order and case: `element`, `state` (the number of the state: its own, or counted from 0) or
//! `time`, and names of forces. Every force of an element that is named must be there.
//!
//! # JSON
//! `{"schema": "pintle-forces/1", "states": [{"state": 0, "forces": {"101": {"f1": 2.5, "m2": -0.1}}}]}`, with `state` or `time`. A
//! file of states has the same under `forces` beside `nodes`.
//!
//! # Multi-point constraints
//! `element` may be the nodes of an MPC, `10-20-30`: f1 f2 f3 and m1 m2 m3 are then the force and the moment that it puts on its first,
//! dependent node, global components; those that it does not transmit may be 0.
//!
//! # Signs
//! [`ForceSign`]: internal, positive resists growth of the component, unless the forces of constraints are said to be those on b.

use super::diagnostic::{Code, Diagnostic, Result};
use super::label::Label;
use super::model::{Mpc, Scene};
use super::span::{Span, Spanned};
use super::states::{self, Context, CsvRow, Fault, State, StateMark};
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt;
use std::path::Path;

const SCHEMA: &str = "pintle-forces/1";

/// How close the time of forces must be to that of a state, as a part of the largest time: exports have six or seven digits.
const SAME_TIME: f64 = 1e-6;

/// What a positive force means (decision D-14).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ForceSign {
    /// Every force resists growth of its component when it is positive: the total adds up as CEF + CVF + CSF + CRF − CCF.
    #[default]
    Internal,
    /// The forces of constrained components are those applied at node b to enforce the constraint: minus the internal ones.
    ConstraintsOnB,
}

/// The forces of one connector at one state, as given.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ElementForces {
    /// f1 … m3, CTF and CTM.
    pub total: [Option<f64>; 6],
    /// CRF and CRM.
    pub reaction: [Option<f64>; 6],
    /// What a positive force of a constraint means.
    pub sign: ForceSign,
    /// Where they stand in their file.
    pub span: Span,
}

/// The forces of one state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StateForces {
    /// Those of connectors, by element number.
    pub elements: BTreeMap<Label, ElementForces>,
    /// Those of multi-point constraints, by their nodes (`10-20-30`).
    pub mpcs: BTreeMap<String, ElementForces>,
}

/// What forces are of.
enum Owner {
    Element(Label),
    /// The nodes of an MPC.
    Mpc(String),
}

impl Owner {
    /// A connector element by its number, or an MPC by its nodes, `10-20-30`, where it has none.
    fn named(text: &str, scene: &Scene) -> Result<Self, Fault> {
        let label = states::label(text.trim(), "element");
        if let Ok(label) = &label
            && scene.connectors.contains_key(label)
        {
            return Ok(Self::Element(*label));
        }
        let nodes = |mpc: &Mpc| mpc.nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join("-");
        let evaluated = scene.mpcs.iter().filter(|mpc| mpc.kind.evaluated().is_some());
        let found = evaluated.filter(|mpc| nodes(mpc).eq_ignore_ascii_case(text.trim())).collect::<Vec<_>>();
        match found.as_slice() {
            [one] => return Ok(Self::Mpc(nodes(one))),
            [] => {}
            several => {
                let message = format!("{} MPCs have the nodes {}", several.len(), text.trim());
                let remedy = "forces cannot tell them apart: keep one, or leave their forces out";
                return Err(Fault::new(Code::ForcesUnknownElement, message, remedy));
            }
        }
        let remedy = format!(
            "use the numbers of the connector elements of {}, and the nodes of its MPCs, such as 10-20-30",
            scene.name
        );
        let message = format!("there is no connector element {}", label?);
        Err(Fault::new(Code::ForcesUnknownElement, message, remedy))
    }
}

impl StateForces {
    fn check(&self, owner: &Owner) -> Result<(), Fault> {
        let (is_known, name) = match owner {
            Owner::Element(label) => (self.elements.contains_key(label), format!("element {label}")),
            Owner::Mpc(nodes) => (self.mpcs.contains_key(nodes), format!("MPC {nodes}")),
        };
        if !is_known {
            return Ok(());
        }
        let remedy = "keep one of the two, or give the second one another state number or time";
        Err(Fault::new(Code::ForcesRepeatedElement, format!("{name} occurs twice in one state"), remedy))
    }

    fn insert(&mut self, owner: Owner, forces: ElementForces) {
        match owner {
            Owner::Element(label) => drop(self.elements.insert(label, forces)),
            Owner::Mpc(nodes) => drop(self.mpcs.insert(nodes, forces)),
        }
    }
}

/// The forces of one state in a file.
#[derive(Debug, Clone, Default, PartialEq)]
struct Group {
    state: Option<u64>,
    time: Option<f64>,
    forces: StateForces,
    span: Span,
}

/// A file of component forces.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ForceFile {
    name: String,
    groups: Vec<Group>,
}

/// The total force, or the reaction, of a component (0-based).
#[derive(Clone, Copy)]
enum Given {
    Total(usize),
    Reaction(usize),
}

const NAMES: [(&str, Given); 18] = [
    ("f1", Given::Total(0)),
    ("f2", Given::Total(1)),
    ("f3", Given::Total(2)),
    ("m1", Given::Total(3)),
    ("m2", Given::Total(4)),
    ("m3", Given::Total(5)),
    ("CTF1", Given::Total(0)),
    ("CTF2", Given::Total(1)),
    ("CTF3", Given::Total(2)),
    ("CTM1", Given::Total(3)),
    ("CTM2", Given::Total(4)),
    ("CTM3", Given::Total(5)),
    ("CRF1", Given::Reaction(0)),
    ("CRF2", Given::Reaction(1)),
    ("CRF3", Given::Reaction(2)),
    ("CRM1", Given::Reaction(3)),
    ("CRM2", Given::Reaction(4)),
    ("CRM3", Given::Reaction(5)),
];

const KEYS: [&str; 3] = ["state", "time", "element"];

impl ElementForces {
    /// Sets a force by name.
    fn set(&mut self, name: &str, value: f64) -> Result<(), Fault> {
        let Some((_, given)) = NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) else {
            let message = format!("there is no force {name:?}");
            return Err(Fault::new(
                Code::StatesUnknownColumn,
                message,
                "forces are f1 to f3, m1 to m3; CTF1 to CTM3; CRF1 to CRM3",
            ));
        };
        let slot = match *given {
            Given::Total(k) => &mut self.total[k],
            Given::Reaction(k) => &mut self.reaction[k],
        };
        if slot.replace(value).is_some() {
            let message = format!("{name} is given twice");
            return Err(Fault::new(
                Code::StatesRepeatedColumn,
                message,
                "f1 and CTF1 are the same: keep one of them",
            ));
        }
        Ok(())
    }
}

impl Serialize for ElementForces {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, value) in self.named() {
            map.serialize_entry(name, &value)?;
        }
        map.end()
    }
}

impl ElementForces {
    /// The forces that are given, by name: each once.
    pub(super) fn named(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        NAMES[..6].iter().chain(&NAMES[12..]).filter_map(|(name, given)| {
            let value = match *given {
                Given::Total(k) => self.total[k],
                Given::Reaction(k) => self.reaction[k],
            };
            value.map(|value| (*name, value))
        })
    }
}

/// Component forces as a state names them: by element, then by name, each with its place.
pub(super) type GivenForces = Vec<(Spanned<String>, Vec<(Spanned<String>, Spanned<f64>)>)>;

/// The forces of one state that a scene itself gives: by element number, each by name.
pub(super) fn of_scene(given: GivenForces, scene: &Scene) -> Result<StateForces> {
    let mut found = StateForces::default();
    for (element, named) in given {
        let owner = Owner::named(&element.value, scene);
        let owner = owner.and_then(|owner| found.check(&owner).map(|()| owner));
        let owner = owner.map_err(|fault| fault.at(element.span, "this element"))?;
        let mut forces = ElementForces { span: element.span, ..ElementForces::default() };
        for (name, value) in named {
            forces.set(&name.value, value.value).map_err(|fault| fault.at(name.span, "this force"))?;
        }
        found.insert(owner, forces);
    }
    Ok(found)
}

impl ForceFile {
    /// Reads component forces of `scene` from a `.csv` or `.json` file.
    ///
    /// # Errors
    /// The first thing that is wrong with it, with its place and a remedy.
    pub fn read(path: impl AsRef<Path>, scene: &Scene, sign: ForceSign) -> Result<Self> {
        let (name, text, is_json) = states::text_of(path.as_ref(), "forces")?;
        if is_json {
            Self::parse_json(&name, &text, scene, sign)
        } else {
            Self::parse_csv(&name, &text, scene, sign)
        }
    }

    /// Reads forces from CSV. `name` stands for the file in messages.
    ///
    /// # Errors
    /// The first thing that is wrong with it, with its place and a remedy.
    pub fn parse_csv(name: &str, text: &str, scene: &Scene, sign: ForceSign) -> Result<Self> {
        let text = states::without_mark(text);
        let groups = csv_groups(text, scene, sign).map_err(|error| states::located(error, name, text))?;
        Ok(Self { name: name.to_string(), groups })
    }

    /// Reads forces from JSON. `name` stands for the file in messages.
    ///
    /// # Errors
    /// The first thing that is wrong with it, with its place and a remedy.
    pub fn parse_json(name: &str, text: &str, scene: &Scene, sign: ForceSign) -> Result<Self> {
        let text = states::without_mark(text);
        let form = format!(
            "{{\"schema\": \"{SCHEMA}\", \"states\": [{{\"state\": 0, \"forces\": {{\"101\": {{\"f1\": 0}}}}}}]}}"
        );
        let groups = states::read_json(text, scene, &form, |context, reader| {
            JsonFile { context, sign }.deserialize(reader)
        })
        .map_err(|error| states::located(error, name, text))?;
        Ok(Self { name: name.to_string(), groups })
    }

    /// Gives the forces to the states they belong to; states without numbers of their own count from `first`.
    ///
    /// # Errors
    /// Forces of a state that there is not, of a time that no state or several have, or of a state that has forces already.
    pub fn attach(&self, states: &mut [State], first: u64) -> Result<()> {
        let marks: Vec<StateMark> = states.iter().map(StateMark::of).collect();
        for (index, forces) in self.assign(&marks, first)? {
            if let Some(state) = states.get_mut(index) {
                state.forces.clone_from(&forces.elements);
                state.mpc_forces.clone_from(&forces.mpcs);
            }
        }
        Ok(())
    }

    /// The forces by the places of the states they belong to, of states that are known by their marks only.
    ///
    /// # Errors
    /// Those of [`ForceFile::attach`].
    pub fn assign(&self, states: &[StateMark], first: u64) -> Result<BTreeMap<usize, &StateForces>> {
        let known = Known::of(states, first);
        let mut assigned = BTreeMap::new();
        for group in &self.groups {
            let index = self.index(group, states, &known)?;
            let Some(state) = states.get(index) else { continue };
            let is_given = assigned.contains_key(&index);
            if state.has_forces || is_given {
                let number = state.number.unwrap_or(first + index as u64);
                let message = format!("state {number} is given forces twice");
                let remedy = "keep one of them: in the file of states or in that of forces, once";
                return Err(self.fail(Code::ForcesRepeatedElement, group, message, remedy));
            }
            // An empty group gives nothing.
            if !(group.forces.elements.is_empty() && group.forces.mpcs.is_empty()) {
                assigned.insert(index, &group.forces);
            }
        }
        Ok(assigned)
    }

    /// The name of the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn fail(&self, code: Code, group: &Group, message: String, remedy: &str) -> Diagnostic {
        Diagnostic::error(code, group.span, message, "here").help(remedy).in_file(&self.name)
    }

    fn index(&self, group: &Group, states: &[StateMark], known: &Known) -> Result<usize> {
        let fail =
            |message: String, remedy: &str| Err(self.fail(Code::ForcesUnknownState, group, message, remedy));
        let remedy = "give the numbers of the states, as `pintle eval` prints them, in `state`";
        match (group.state, group.time) {
            (Some(number), _) => {
                let Some(index) = known.numbers.get(&number).copied() else {
                    let [lowest, highest] = known.range();
                    let message = format!("forces of state {number}: the states are {lowest} to {highest}");
                    return fail(message, remedy);
                };
                match (group.time, states.get(index).and_then(|state| state.time)) {
                    (Some(given), Some(time)) if (given - time).abs() > known.tolerance(given) => fail(
                        format!("forces of state {number} at time {given}, which is at {time}"),
                        "leave out `time` or `state`, or correct one of them",
                    ),
                    _ => Ok(index),
                }
            }
            (None, Some(given)) => match known.at(given) {
                [(_, index)] => Ok(*index),
                [] => fail(format!("no state has the time {given} of these forces"), remedy),
                several => {
                    fail(format!("{} states have the time {given} of these forces", several.len()), remedy)
                }
            },
            (None, None) if states.len() == 1 => Ok(0),
            (None, None) => {
                fail(format!("forces without a state, and there are {} states", states.len()), remedy)
            }
        }
    }
}

/// The states by number and by time.
struct Known {
    numbers: HashMap<u64, usize>,
    /// In order of time.
    times: Vec<(f64, usize)>,
}

impl Known {
    fn of(states: &[StateMark], first: u64) -> Self {
        let numbered = (first..).zip(states).enumerate();
        let numbers = numbered.map(|(index, (counted, state))| (state.number.unwrap_or(counted), index));
        let timed = states.iter().enumerate();
        let mut times: Vec<(f64, usize)> =
            timed.filter_map(|(index, state)| Some((state.time?, index))).collect();
        times.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        Self { numbers: numbers.collect(), times }
    }

    fn range(&self) -> [u64; 2] {
        [self.numbers.keys().min(), self.numbers.keys().max()]
            .map(|number| number.copied().unwrap_or_default())
    }

    fn tolerance(&self, given: f64) -> f64 {
        let ends = [self.times.first(), self.times.last()].into_iter().flatten();
        SAME_TIME * ends.fold(given.abs(), |most, (time, _)| most.max(time.abs()))
    }

    fn at(&self, given: f64) -> &[(f64, usize)] {
        let tolerance = self.tolerance(given);
        let from = self.times.partition_point(|(time, _)| *time < given - tolerance);
        let to = self.times.partition_point(|(time, _)| *time <= given + tolerance);
        self.times.get(from..to).unwrap_or_default()
    }
}

fn csv_groups(text: &str, scene: &Scene, sign: ForceSign) -> Result<Vec<Group>> {
    let mut groups: Vec<Group> = Vec::new();
    let mut seen: HashSet<(Option<u64>, Option<u64>)> = HashSet::new();
    let known = || KEYS.into_iter().chain(NAMES.iter().map(|(name, _)| *name));
    let find = |field: &str| known().find(|known| known.eq_ignore_ascii_case(field));
    states::csv_rows(
        states::Source::Text(text),
        &known().collect::<Vec<_>>(),
        find,
        "element",
        |row: &CsvRow<'_>| {
            let (state, time) = (row.integer("state")?, row.number("time")?);
            let is_same = groups.last().is_some_and(|last| last.state == state && last.time == time);
            if !is_same {
                let key = (state, time.filter(|_| state.is_none()).map(f64::to_bits));
                if !seen.insert(key) {
                    let message = "rows of one state are apart, or have different times";
                    return Err(Diagnostic::error(Code::StatesOrder, row.span(), message, "this row")
                        .help("put the rows of a state together, all with its number and time"));
                }
                groups.push(Group { state, time, forces: StateForces::default(), span: row.span() });
            }
            let Some(element) = row.field("element") else {
                return Err(Diagnostic::error(
                    Code::StatesMalformedNumber,
                    row.span(),
                    "a row without an element",
                    "this row",
                )
                .help("give the element number in the column `element`"));
            };
            let Some(group) = groups.last_mut() else { return Ok(()) };
            let owner = Owner::named(element, scene);
            let owner = owner.and_then(|owner| group.forces.check(&owner).map(|()| owner));
            let owner = owner.map_err(|fault| fault.at(row.place("element"), "this element"))?;
            let mut forces = ElementForces { sign, span: row.span(), ..ElementForces::default() };
            for (name, _) in &NAMES {
                if let Some(value) = row.number(name)? {
                    forces.set(name, value).map_err(|fault| fault.at(row.place(name), "this column"))?;
                }
            }
            group.forces.insert(owner, forces);
            Ok(())
        },
    )?;
    Ok(groups)
}

#[derive(Clone, Copy)]
struct JsonFile<'a> {
    context: Context<'a>,
    sign: ForceSign,
}

/// The forces of one state by element number.
pub(super) struct JsonForces<'a> {
    pub(super) context: Context<'a>,
    pub(super) sign: ForceSign,
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

seed!(JsonFile, Vec<Group>, deserialize_map);
seed!(JsonGroups, Vec<Group>, deserialize_seq);
seed!(JsonGroup, Group, deserialize_map);
seed!(JsonForces, StateForces, deserialize_map);
seed!(JsonElement, ElementForces, deserialize_map);

impl<'de> Visitor<'de> for JsonFile<'_> {
    type Value = Vec<Group>;
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with `schema` and `states`")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Vec<Group>, A::Error> {
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
    type Value = Vec<Group>;
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an array of states")
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Vec<Group>, A::Error> {
        let mut groups = Vec::new();
        while let Some(group) = sequence.next_element_seed(JsonGroup(self.0))? {
            groups.push(group);
        }
        Ok(groups)
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
                    group.state = Some(map.next_value()?);
                }
                "time" => {
                    states::once(group.time.is_some(), "time")?;
                    group.time = Some(map.next_value()?);
                }
                "forces" => {
                    states::once(forces.is_some(), "forces")?;
                    let JsonFile { context, sign } = self.0;
                    forces = Some(map.next_value_seed(JsonForces { context, sign })?);
                }
                other => return Err(A::Error::unknown_field(other, &["state", "time", "forces"])),
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
            let owner = owner.map_err(|fault| context.stop(fault))?;
            found.insert(owner, map.next_value_seed(JsonElement { context, sign })?);
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
            let value = map.next_value::<f64>()?;
            forces.set(&key, value).map_err(|fault| self.context.stop(fault))?;
        }
        Ok(forces)
    }
}
