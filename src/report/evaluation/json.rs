//! Evaluations as one JSON document, written as they come.
//!
//! Every number is the shortest decimal that reads back to the same double. One that is not finite is `null`, and a flag
//! says so.

use crate::evaluation::block::{
    Block, BlockKind, Column, ComponentRow, Derivative, HingeFacts, NodalDerivative, Value, slopes,
};
use crate::evaluation::{Format, Renderer, Subject, unevaluated};
use crate::words::{ROWS, SIGNS};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Output, StopStatus, Tally};
use pintle_model::behavior::Tangent;
use pintle_scene::Label;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use serde_json::json;
use std::io::{self, Write};

/// The version of the form.
pub const SCHEMA: &str = "pintle-eval/1";

/// One JSON document.
pub struct Json<'w> {
    out: &'w mut dyn Write,
    scenes: u64,
    states: u64,
    blocks: u64,
    kind: BlockKind,
}

impl<'w> Json<'w> {
    /// A document on a stream.
    pub fn new(out: &'w mut dyn Write) -> Self {
        Self { out, scenes: 0, states: 0, blocks: 0, kind: BlockKind::Connector }
    }

    fn value(&mut self, value: &impl Serialize) -> io::Result<()> {
        serde_json::to_writer(&mut *self.out, value).map_err(io::Error::from)
    }
}

impl Format for Json<'_> {
    fn begin(&mut self) -> io::Result<()> {
        write!(self.out, "{{\"schema\":")?;
        self.value(&SCHEMA)?;
        write!(self.out, ",\n\"version\":")?;
        self.value(&pintle_kinematics::VERSION)?;
        write!(self.out, ",\n\"signs\":")?;
        self.value(&SIGNS)?;
        write!(self.out, ",\n\"rows\":")?;
        self.value(&ROWS)?;
        write!(self.out, ",\n\"units\":")?;
        self.value(&json!({"length": "of the deck", "angle": "rad", "none": "1", "time": "of the deck"}))?;
        write!(self.out, ",\n\"scenes\":[")
    }

    fn scene(&mut self, subject: &Subject<'_>) -> io::Result<()> {
        write!(self.out, "{}\n{{\"scene\":", if self.scenes > 0 { "," } else { "" })?;
        self.scenes += 1;
        self.states = 0;
        self.value(&subject.scene.name)?;
        write!(self.out, ",\"heading\":")?;
        self.value(&subject.scene.heading.trim())?;
        write!(self.out, ",\"not_evaluated\":")?;
        self.value(&unevaluated(subject.scene, subject.model))?;
        write!(self.out, ",\n\"states\":[")
    }

    fn state(&mut self, index: u64, time: Option<f64>) -> io::Result<()> {
        write!(self.out, "{}\n{{\"index\":{index},\"time\":", if self.states > 0 { "," } else { "" })?;
        self.states += 1;
        self.value(&time)?;
        (self.blocks, self.kind) = (0, BlockKind::Connector);
        write!(self.out, ",\"connectors\":[")
    }

    fn renderer(&self) -> Renderer {
        Box::new(|block, text| serde_json::to_writer(text, block).map_err(io::Error::from))
    }

    fn rendered(&mut self, kind: BlockKind, text: &[u8]) -> io::Result<()> {
        if kind != self.kind {
            self.blocks = 0;
            let begins = match (self.kind, kind) {
                (BlockKind::Connector, BlockKind::Relation) => "],\"mpcs\":[],\"relations\":[",
                (_, BlockKind::Relation) => "],\"relations\":[",
                _ => "],\"mpcs\":[",
            };
            write!(self.out, "{begins}")?;
            self.kind = kind;
        }
        writeln!(self.out, "{}", if self.blocks > 0 { "," } else { "" })?;
        self.blocks += 1;
        self.out.write_all(text)
    }

    fn end_state(&mut self) -> io::Result<()> {
        match self.kind {
            BlockKind::Connector => write!(self.out, "],\"mpcs\":[]}}"),
            BlockKind::Mpc | BlockKind::Relation => write!(self.out, "]}}"),
        }
    }

    fn end_scene(&mut self, work: Tally) -> io::Result<()> {
        write!(self.out, "],\n\"work\":")?;
        self.value(&work)?;
        write!(self.out, "}}")
    }

    fn end(&mut self) -> io::Result<()> {
        writeln!(self.out, "]}}")?;
        self.out.flush()
    }
}

impl Serialize for Block<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        if self.kind == BlockKind::Connector {
            map.serialize_entry("element", &self.label.parse::<Label>().ok())?;
        }
        map.serialize_entry("type", self.type_name)?;
        if self.kind == BlockKind::Relation {
            let nodes: Vec<Option<Label>> = self.nodes.iter().map(|(_, node)| *node).collect();
            map.serialize_entry("relation", &self.label)?;
            map.serialize_entry("nodes", &nodes)?;
        } else {
            map.serialize_entry("nodes", &named(&self.nodes, |(role, node)| (*role, *node)))?;
        }
        map.serialize_entry("components", &named(&self.rows, |row| (row.name, row)))?;
        if !self.derivatives.is_empty() {
            map.serialize_entry("jacobian", &Jacobian { dofs: &self.columns, of: &self.derivatives })?;
        }
        if self.derivatives.iter().any(|row| row.hessian.is_some()) {
            map.serialize_entry("hessian", &named(&self.derivatives, |row| (row.component, &row.hessian)))?;
        }
        if let Some(tangent) = &self.tangent {
            map.serialize_entry("tangent", &Slopes(tangent))?;
        }
        if !self.nodal.forces.is_empty() {
            map.serialize_entry("nodal_forces", &self.nodal.forces)?;
        }
        for NodalDerivative { output, by, rows } in &self.nodal.derivatives {
            let name = match output {
                Output::KG => "geometric_stiffness",
                Output::DNF => "nodal_force_derivative",
                Output::KT => "tangent_stiffness",
                Output::CT => "tangent_damping",
                _ => "tangent_by_reactions",
            };
            match by {
                None => map.serialize_entry(name, &json!({"dofs": &self.columns, "rows": rows}))?,
                Some(by) => {
                    map.serialize_entry(name, &json!({"dofs": &self.columns, "by": by, "rows": rows}))?;
                }
            }
        }
        if let Some(branch) = &self.branch {
            map.serialize_entry("branch", branch)?;
        }
        if let Some(facts) = &self.mpc {
            let hinge = |of: &HingeFacts| {
                let mut hinge = json!({"given": of.given, "axis": of.axis});
                match of.moments {
                    Some(Ok(moments)) => hinge["moments"] = json!(moments),
                    Some(Err(unknown)) => hinge["moments"] = json!({"unknown": unknown}),
                    None => {}
                }
                if let Some(moment) = of.constraint {
                    hinge["constraint_moment"] = json!(moment);
                }
                (of.name, hinge)
            };
            map.serialize_entry("hinges", &named(&facts.hinges, hinge))?;
            map.serialize_entry("misalignment", &facts.misalignment)?;
        }
        map.serialize_entry("flags", &self.flags)?;
        map.end()
    }
}

/// Items as a map from names.
struct Named<'a, T, F>(&'a [T], F);

fn named<'a, T, V: Serialize, F: Fn(&'a T) -> (&'static str, V)>(
    items: &'a [T],
    entry: F,
) -> Named<'a, T, F> {
    Named(items, entry)
}

impl<'a, T, V: Serialize, F: Fn(&'a T) -> (&'static str, V)> Serialize for Named<'a, T, F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(&self.1))
    }
}

/// The slopes of component forces: for each force, those that are not 0 by what they are by.
struct Slopes<'a>(&'a Tangent<f64>);

impl Serialize for Slopes<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let entries = slopes(self.0);
        let of: Vec<_> = entries.chunk_by(|one, other| one.0 == other.0).collect();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("time_step", &self.0.time_step)?;
        let reacting: Vec<&str> =
            COMPONENT.into_iter().zip(self.0.reacting).filter_map(|(name, is)| is.then_some(name)).collect();
        map.serialize_entry("reacting", &reacting)?;
        let line = |of: &&[(&'static str, &'static str, f64)]| {
            let name = of.first().map_or("", |(force, _, _)| *force);
            let slopes: serde_json::Map<String, serde_json::Value> =
                of.iter().map(|(_, by, slope)| ((*by).to_string(), json!(slope))).collect();
            (name, slopes)
        };
        map.serialize_entry("rows", &named(&of, line))?;
        map.end()
    }
}

struct Jacobian<'a> {
    dofs: &'a [Column],
    of: &'a [Derivative],
}

impl Serialize for Jacobian<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("dofs", self.dofs)?;
        map.serialize_entry("rows", &named(self.of, |row| (row.component, &row.gradient)))?;
        let printed: Vec<&Derivative> = self.of.iter().filter(|row| row.printed.is_some()).collect();
        map.serialize_entry("of_constraint_function", &named(&printed, |row| (row.component, row.printed)))?;
        map.end()
    }
}

impl Serialize for ComponentRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("role", self.role)?;
        map.serialize_entry("unit", &self.unit)?;
        for (output, value) in Output::ALL.into_iter().zip(&self.values) {
            if let Some(value) = value {
                map.serialize_entry(output.name(), value)?;
            }
            if let Some(Value::Stop(status)) = value {
                map.serialize_entry("stop", status as &StopStatus)?;
            }
        }
        map.end()
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => number.serialize(serializer),
            Self::Stop(status) => status.flag().serialize(serializer),
            Self::Slip(status) => status.serialize(serializer),
            Self::Turns(turns) => turns.serialize(serializer),
            Self::Margin(margin) => margin.serialize(serializer),
        }
    }
}
