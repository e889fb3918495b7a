//! Component forces of connectors, state by state, as FE codes export them.
//!
//! # Names
//! - `f1` `f2` `f3` `m1` `m2` `m3`, or `CTF1` … `CTM3`: the total force `CTF = CEF + CVF + CSF + CRF − CCF` of each component.
//! - `CRF1` … `CRM3`: the reaction, which is the total force of a constrained component; of an available one it is a part, and the
//!   total has to be given.
//!
//! Components that a connector does not have may be 0.
//!
//! # CSV
//! The first line names the columns, in any order and case: `element`, `state` (the number of the state: its own, or counted from 0) or
//! `time`, and names of forces. A blank cell, or a column that is not there, is a gap: that force is not given, and not zero.
//!
//! # JSON
//! `{"schema": "pintle-forces/1", "states": [{"state": 0, "forces": {"101": {"f1": 2.5, "m2": -0.1}}}]}`, with `state` or `time`. A
//! file of states has the same under `forces` beside `nodes`.
//!
//! # Multi-point constraints
//! The `element` may be the nodes of an MPC, `10-20-30`. Then f1 f2 f3 and m1 m2 m3 are the force and the moment that it puts on
//! its first, dependent node, global components. Those that it does not transmit may be 0.
//!
//! # Signs
//! [`ForceSign`](crate::ForceSign): internal, positive resists growth of the component, unless the forces of constraints are said to be those on b.

mod document;
mod file;
mod table;

pub(super) use document::JsonForces;
pub use file::{ForceFile, ForceStream, StateIndex};

use crate::diagnostic::Code;
use crate::label::Label;
use crate::model::{ElementForces, Mpc, Scene, StateForces};
use crate::span::{Span, Spanned};
use crate::states;
use crate::states::{Fault, Faults};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::ops::ControlFlow;

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

/// Takes the forces of one state after another, until it breaks off.
type Take<'a> = dyn FnMut(Group) -> ControlFlow<()> + 'a;

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
    fn set(&mut self, name: &str, value: Option<f64>) -> Result<(), Fault> {
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
        // None is a gap.
        if value.is_some_and(|value| slot.replace(value).is_some()) {
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

/// The forces of one state that a scene itself gives: by element number, each by name. What is wrong is added to the faults.
pub(super) fn of_scene(given: GivenForces, scene: &Scene, faults: &mut Faults) -> StateForces {
    let mut found = StateForces::default();
    for (element, named) in given {
        let mut forces = ElementForces { span: element.span, ..ElementForces::default() };
        for (name, value) in named {
            if let Err(fault) = forces.set(&name.value, Some(value.value)) {
                faults.add(fault.at(name.span, "this force"));
            }
        }
        let owner = Owner::named(&element.value, scene);
        match owner.and_then(|owner| found.check(&owner).map(|()| owner)) {
            Ok(owner) => found.insert(owner, forces),
            Err(fault) => faults.add(fault.at(element.span, "this element")),
        }
    }
    found
}
