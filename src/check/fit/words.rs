//! A fit as a convention, and in words.

use super::search::Fit;
use super::space::{Names, Order, Reading};
use crate::convention::{
    Angle, Axes, Convention, Frame, Positions, Quaternions, Sense, Storage, Triads, Variation, Variations,
};
use pintle_kinematics::measure::Unit;

impl Fit {
    /// As a routine declares it.
    pub(super) fn convention(&self) -> Convention {
        let mut convention = Convention::default();
        let names = &self.names;
        let all: Vec<usize> = (0..pintle_kinematics::mpc::PHI + names.hinges).collect();
        if self.order.places != all {
            convention.columns = self.order.names(names);
        }
        let is_in_place = self.height == names.height && self.lines.iter().all(|of| of.line == of.is.k);
        if !is_in_place {
            convention.rows = self.rows();
        }
        convention.rotations = match self.variations {
            [a, b] if a == b => Variations::Both(a),
            each => Variations::Each(each),
        };
        convention.displacements = self.frame;
        convention.axes = self.axes;
        convention.positions = self.positions;
        convention.storage = self.storage;
        match self.reading {
            Reading::Right => {}
            Reading::Transposed => convention.triads = Triads::Matrix,
            Reading::ScalarLast => convention.quaternion = Quaternions::Xyzw,
            Reading::Inverse => convention.sense = Sense::Inverse,
        }
        convention.angles = self.units.row_angle;
        convention.column_angles = self.units.column_angle;
        convention.row_length = self.units.row_length;
        convention.column_length = self.units.column_length;
        for of in &self.lines {
            if let Some(factor) = convention.factors.get_mut(of.is.k) {
                *factor = of.factor;
            }
            if of.is.is_as_angle {
                convention.as_angle.push(names.rows[of.is.k].to_string());
            }
        }
        convention
    }

    /// The components by line; lines without any take the names that are left.
    fn rows(&self) -> Vec<String> {
        let mut names: Vec<Option<usize>> = vec![None; self.height];
        for of in &self.lines {
            names[of.line] = Some(of.is.k);
        }
        let mut left = (0..self.names.height).filter(|k| !self.lines.iter().any(|of| of.is.k == *k));
        let filled = names.into_iter().map(|name| name.or_else(|| left.next()));
        filled.flatten().map(|k| self.names.rows[k].to_string()).collect()
    }

    /// What it says on each question, the plain answer included.
    pub(super) fn answers(&self) -> Vec<(&'static str, String)> {
        let names = &self.names;
        let has = |unit: Unit| self.lines.iter().any(|of| of.is.unit == unit);
        let minus: Vec<&str> =
            self.lines.iter().filter(|of| of.factor < 0.0).map(|of| names.rows[of.is.k]).collect();
        let signs = match minus.as_slice() {
            [] => "as pintle's".to_string(),
            all if all.len() == self.lines.len() => "all opposite: forces in place of residuals".to_string(),
            some => format!("opposite of {}", some.join(", ")),
        };
        let odd: Vec<String> = self
            .lines
            .iter()
            .filter(|of| of.factor.abs() != 1.0)
            .map(|of| format!("{} times {}", names.rows[of.is.k], of.factor.abs()))
            .collect();
        let as_angle: Vec<&str> =
            self.lines.iter().filter(|of| of.is.is_as_angle).map(|of| names.rows[of.is.k]).collect();
        let mut found = vec![
            ("order of columns", describe_order(&self.order, names)),
            (names.rotations[0], describe_variation(self.variations[0]).to_string()),
            (names.rotations[1], describe_variation(self.variations[1]).to_string()),
            ("displacements", describe_frame(self.frame, names)),
            ("order of rows", {
                let mut lines = self.lines.clone();
                lines.sort_by_key(|of| of.line);
                lines.iter().map(|of| names.rows[of.is.k]).collect::<Vec<_>>().join(", ")
            }),
            ("signs of rows", signs),
            (
                "storage",
                match self.storage {
                    Storage::Rows => "a row for each component".to_string(),
                    Storage::Columns => "transposed, a line for each degree of freedom".to_string(),
                },
            ),
            (
                "vectors",
                match self.axes {
                    Axes::A => "along the axes of a".to_string(),
                    Axes::Global => "along global axes".to_string(),
                    Axes::B => "along the axes of b".to_string(),
                },
            ),
            (
                "orientations",
                match self.reading {
                    Reading::Right => "read as they are sent".to_string(),
                    Reading::Transposed => "triads read transposed".to_string(),
                    Reading::ScalarLast => "quaternions read with the scalar last".to_string(),
                    Reading::Inverse => "rotations read backwards".to_string(),
                },
            ),
            (
                "values",
                match self.positions {
                    Positions::Displacement => "displacements CU and residuals".to_string(),
                    Positions::Position => "positions CP".to_string(),
                    Positions::Constitutive => "constitutive displacements CCU".to_string(),
                },
            ),
        ];
        if has(Unit::Length) {
            found.push(("length of rows", describe_length(self.units.row_length)));
        }
        if has(Unit::Angle) {
            found.push(("angle of rows", self.units.row_angle.name().to_string()));
        }
        found.push(("length of columns", describe_length(self.units.column_length)));
        found.push(("angle of columns", describe_angle(self.units.column_angle)));
        if !as_angle.is_empty() {
            found.push(("cosines", format!("given as angles: {}", as_angle.join(", "))));
        } else if self.lines.iter().any(|of| of.is.unit == Unit::None) {
            found.push(("cosines", "as they are".to_string()));
        }
        if !odd.is_empty() {
            found.push(("factors", odd.join(", ")));
        }
        found
    }
}

fn describe_angle(angle: Angle) -> String {
    angle.name().to_string()
}

fn describe_length(x: f64) -> String {
    if x == 1.0 { "that of the states".to_string() } else { format!("{x} of the unit of the states") }
}

const fn describe_variation(variation: Variation) -> &'static str {
    match variation {
        Variation::Spatial => "spatial, about global axes",
        Variation::Body => "body, about the axes of the node",
        Variation::TotalVector => "of the total rotation vector",
        Variation::Angles123 => "of Cardan angles about axes 1, 2, 3",
        Variation::Angles321 => "of yaw, pitch and roll about axes 3, 2, 1",
        Variation::Angles313 => "of Euler angles about axes 3, 1, 3",
    }
}

fn describe_frame(frame: Frame, names: &Names) -> String {
    match frame {
        Frame::Global => "along global axes".to_string(),
        Frame::A => format!("along the axes of {}", names.nodes[0]),
        Frame::B => format!("along the axes of {}", names.nodes[1]),
        Frame::Own => "of each node along its own axes".to_string(),
    }
}

/// `a.u1 … a.ur3, b.u1 … b.ur3`: runs of names shortened.
fn describe_order(order: &Order, names: &Names) -> String {
    let names = order.names(names);
    let mut parts: Vec<String> = Vec::new();
    let mut at = 0;
    while at < names.len() {
        let mut end = at;
        while end + 1 < names.len() && order.places[end + 1] == order.places[end] + 1 {
            end += 1;
        }
        parts.push(match end - at {
            0 => names[at].clone(),
            1 => format!("{}, {}", names[at], names[end]),
            _ => format!("{} … {}", names[at], names[end]),
        });
        at = end + 1;
    }
    parts.join(", ")
}
