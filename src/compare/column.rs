//! What a heading means: names that are standard are known, a map says the rest.

use crate::printed::Writing;
use pintle_check::Angle;
use pintle_kinematics::connector::Output;
use pintle_model::evaluate::request;
use serde::Deserialize;
use std::collections::BTreeMap;

/// What a node does, by component (0-based).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Motion {
    /// U: displacement (length).
    Displacement(usize),
    /// UR: total rotation vector (rad).
    Rotation(usize),
    /// Quaternion, scalar first.
    Quaternion(usize),
    /// V (length/time).
    Velocity(usize),
    /// VR: spatial angular velocity (rad/time).
    AngularVelocity(usize),
    /// A (length/time²).
    Acceleration(usize),
    /// AR (rad/time²).
    AngularAcceleration(usize),
    /// Ψ (length).
    Flow,
    /// Ψ̇ (length/time).
    FlowVelocity,
    /// Ψ̈ (length/time²).
    FlowAcceleration,
}

/// A force at a node, global components: three forces, then three moments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Nodal {
    /// RF and RM: what holds the node.
    Reaction,
    /// NF and NM: of the connectors at the node, residual-side.
    Force,
}

impl Nodal {
    /// The name of a component, as headings have it: RF1, RM3, NF2.
    pub(crate) fn name(self, i: usize) -> String {
        let stem = match (self, i < 3) {
            (Self::Reaction, true) => "RF",
            (Self::Reaction, false) => "RM",
            (Self::Force, true) => "NF",
            (Self::Force, false) => "NM",
        };
        format!("{stem}{}", i % 3 + 1)
    }
}

/// What a matrix of a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MatrixKind {
    /// A row for each constraint, as `pintle eval --jacobian` writes it.
    Jacobian,
    /// The tangent of the nodal forces of connectors.
    Stiffness,
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Column {
    Time,
    State,
    Node,
    Element,
    Motion(Motion),
    /// An output of a component (0-based).
    Output(Output, usize),
    /// A force or moment at a node (0-based).
    Nodal(Nodal, usize),
    /// Nothing that is compared.
    Other,
}

/// What the rotations of nodes are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rotations {
    /// Total from the initial orientation.
    #[default]
    Total,
    /// Since the frame before.
    Incremental,
}

/// What is not standard in a file, as TOML. What is left out is as pintle and Abaqus have it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Map {
    /// The meaning of headings that are not standard: `"Door angle" = "CUR1"`.
    pub columns: BTreeMap<String, String>,
    /// The node of a file whose lines name none.
    pub node: Option<String>,
    /// The element of a file whose lines name none.
    pub element: Option<String>,
    /// The unit of the rotations of nodes.
    pub rotation_angles: Angle,
    /// The unit of connector outputs that are angles.
    pub angles: Angle,
    /// The unit of length of the file, in units of the scene: 0.001 for a file in mm and a scene in m.
    pub length: f64,
    /// The unit of force of the file, in units of the scene.
    pub force: f64,
    /// What the rotations of nodes are.
    pub rotations: Rotations,
    /// Whether numbers were computed or stored in single precision, whatever digits are printed.
    pub single: bool,
    /// What matrices are; without this, what their shape says.
    pub matrix: Option<MatrixKind>,
    /// The state, from 0 on, of a file with one matrix; without this the last.
    pub matrix_state: Option<u64>,
    /// How the file writes its numbers.
    #[serde(skip)]
    pub(crate) writing: Writing,
}

impl Default for Map {
    fn default() -> Self {
        Self {
            columns: BTreeMap::new(),
            node: None,
            element: None,
            rotation_angles: Angle::default(),
            angles: Angle::default(),
            length: 1.0,
            force: 1.0,
            rotations: Rotations::default(),
            single: false,
            matrix: None,
            matrix_state: None,
            writing: Writing::default(),
        }
    }
}

impl Map {
    /// That of a TOML document.
    ///
    /// # Errors
    /// In words, what is none, and where.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let map: Self = toml::from_str(text).map_err(|error| error.to_string())?;
        for (name, x) in [("length", map.length), ("force", map.force)] {
            if !(x > 0.0 && x.is_finite()) {
                return Err(format!("{name} is {x}, not a positive number"));
            }
        }
        for (heading, meaning) in &map.columns {
            if !meaning.eq_ignore_ascii_case("ignore") && standard(meaning) == Column::Other {
                return Err(format!(
                    "columns.{heading:?} = {meaning:?}: no such output, motion, time, node or element"
                ));
            }
        }
        Ok(map)
    }

    /// What a heading means.
    pub(crate) fn column(&self, heading: &str) -> Column {
        let heading = heading.trim();
        let given = self.columns.iter().find(|(known, _)| known.trim().eq_ignore_ascii_case(heading));
        standard(given.map_or(heading, |(_, meaning)| meaning))
    }

    /// The unit of a motion of the file, in the scene's.
    pub(crate) fn of_motion(&self, motion: Motion) -> f64 {
        match motion {
            Motion::Quaternion(_) => 1.0,
            Motion::Rotation(_) => self.rotation_angles.size(),
            Motion::AngularVelocity(_) | Motion::AngularAcceleration(_) => self.rotation_angles.size(),
            _ => self.length,
        }
    }
}

/// The meaning of a standard name, as Abaqus and pintle write it: `U1`, `U-U1`, `UR3`, `q0`, `CU1`, `CUR1`, `CTF-CTM3`, `Node Label`.
fn standard(heading: &str) -> Column {
    let upper = heading.trim().to_ascii_uppercase();
    let upper = upper.replace([' ', '_'], "");
    match upper.as_str() {
        "TIME" | "T" | "TOTALTIME" => return Column::Time,
        "STATE" | "FRAME" | "INCREMENT" | "INC" => return Column::State,
        "NODE" | "NODELABEL" | "NODEID" => return Column::Node,
        "ELEMENT" | "ELEMENTLABEL" | "CONNECTOR" | "ELEMENTID" => return Column::Element,
        "FLOW" => return Column::Motion(Motion::Flow),
        "FLOWVELOCITY" => return Column::Motion(Motion::FlowVelocity),
        "FLOWACCELERATION" => return Column::Motion(Motion::FlowAcceleration),
        _ => {}
    }
    // U-U1 of a report is U1; a magnitude is none of its components.
    let name = match upper.split_once('-') {
        Some((group, name)) if group.starts_with(|c: char| c.is_ascii_alphabetic()) => name,
        _ => &upper,
    };
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let digit = name[stem.len()..].parse::<usize>().ok();
    if stem == "Q" {
        return digit.filter(|n| *n < 4).map_or(Column::Other, |n| Column::Motion(Motion::Quaternion(n)));
    }
    let Some(n) = digit.and_then(|n| n.checked_sub(1)).filter(|n| *n < 6) else { return Column::Other };
    let motion: Option<fn(usize) -> Motion> = match stem {
        "U" => Some(Motion::Displacement),
        "UR" => Some(Motion::Rotation),
        "V" => Some(Motion::Velocity),
        "VR" => Some(Motion::AngularVelocity),
        "A" => Some(Motion::Acceleration),
        "AR" => Some(Motion::AngularAcceleration),
        _ => None,
    };
    if let Some(motion) = motion {
        return if n < 3 { Column::Motion(motion(n)) } else { Column::Other };
    }
    let nodal = match stem {
        "RF" => Some((Nodal::Reaction, 0)),
        "RM" => Some((Nodal::Reaction, 3)),
        "NF" => Some((Nodal::Force, 0)),
        "NM" => Some((Nodal::Force, 3)),
        _ => None,
    };
    if let Some((nodal, first)) = nodal {
        return if first + n < 6 { Column::Nodal(nodal, first + n) } else { Column::Other };
    }
    let Ok(wanted) = request([name], 0) else { return Column::Other };
    let one = Output::ALL.into_iter().find_map(|output| {
        let components: Vec<usize> = (0..6).filter(|k| wanted.wants(output, *k)).collect();
        (components.len() == 1).then(|| Column::Output(output, components[0]))
    });
    one.filter(|column| !matches!(column, Column::Output(output, _) if output.is_nodal()))
        .unwrap_or(Column::Other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_names_are_known() {
        for (heading, column) in [
            ("Time", Column::Time),
            ("U-U1", Column::Motion(Motion::Displacement(0))),
            ("ur3", Column::Motion(Motion::Rotation(2))),
            ("q0", Column::Motion(Motion::Quaternion(0))),
            ("Node Label", Column::Node),
            ("CU2", Column::Output(Output::CU, 1)),
            ("CUR1", Column::Output(Output::CU, 3)),
            ("CTF-CTM3", Column::Output(Output::CTF, 5)),
            ("CRF1", Column::Output(Output::CRF, 0)),
            ("RF-RF2", Column::Nodal(Nodal::Reaction, 1)),
            ("RM3", Column::Nodal(Nodal::Reaction, 5)),
            ("RF5", Column::Nodal(Nodal::Reaction, 4)),
            ("NM4", Column::Other),
            ("U-Magnitude", Column::Other),
            ("S11", Column::Other),
            ("U9", Column::Other),
        ] {
            assert_eq!(Map::default().column(heading), column, "{heading}");
        }
        let map = Map::from_toml("[columns]\n\"Door angle\" = \"CUR1\"").unwrap();
        assert_eq!(map.column("door ANGLE"), Column::Output(Output::CU, 3));
        assert!(Map::from_toml("[columns]\nx = \"CUR9\"").is_err());
    }
}
