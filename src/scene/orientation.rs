//! `*ORIENTATION`: three orthonormal directions at a point.

use crate::choice::choices;
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::label::Label;
use crate::model::{ConnectorSection, End, Scene};
use crate::span::Span;
use serde::Serialize;
use std::collections::HashSet;

/// The directions e1, e2, e3, each in global components: the columns of a rotation matrix.
pub type Triad = [[f64; 3]; 3];

/// The global directions.
pub const GLOBAL: Triad = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The sine of the smallest angle between two lines that still define a plane.
pub const SMALLEST_SINE: f64 = 1e-9;

choices! {
    /// What the points of an orientation mean.
    pub enum System {
        /// a on the local X′ axis, b in the X′Y′ plane, c the origin.
        Rectangular = "RECTANGULAR",
        /// a on the local Z′ axis, b in the X′Z′ plane, c the origin.
        ZRectangular = "Z RECTANGULAR",
        /// a and b on the axis; 1 radial, 2 tangential, 3 axial from a to b.
        Cylindrical = "CYLINDRICAL",
        /// a the centre, b on the polar axis; 1 radial, 2 circumferential, 3 meridional towards the pole.
        Spherical = "SPHERICAL",
        /// A user subroutine.
        User = "USER",
    }
}

/// How the points of an orientation are given.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Definition {
    /// Global coordinates.
    Coordinates {
        /// The first point.
        a: [f64; 3],
        /// The second point.
        b: [f64; 3],
        /// The origin.
        c: [f64; 3],
    },
    /// Nodes of the scene.
    Nodes {
        /// The first point.
        a: Label,
        /// The second point.
        b: Label,
        /// The origin; none is the global origin.
        c: Option<Label>,
    },
    /// Nodes of the element, counted from 1.
    OffsetToNodes {
        /// The first point.
        a: u64,
        /// The second point.
        b: u64,
        /// The origin; none is the first node.
        c: Option<u64>,
    },
    /// Nothing is given: a user subroutine says it.
    None,
}

/// An orientation: a system, its points, and an additional rotation about one of its directions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Orientation {
    /// What the points mean.
    pub system: System,
    /// The points.
    pub definition: Definition,
    /// The direction, 1 to 3, about which the system is turned further.
    pub axis: u8,
    /// By how much, **in degrees**, right-handed.
    pub angle: f64,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

impl Orientation {
    /// Does the triad depend on where it is evaluated?
    #[must_use]
    pub fn depends_on_point(&self) -> bool {
        matches!(self.system, System::Cylindrical | System::Spherical)
    }

    /// The triad at `point`, for an element whose nodes have the initial positions `element_nodes`
    /// (used by `DEFINITION=OFFSET TO NODES` only).
    ///
    /// `name` is that of the orientation, for the message. The directions are right to a few units in the last
    /// place for the differences of the given coordinates.
    ///
    /// # Errors
    /// [`Code::DegenerateOrientation`] where the points coincide or stand in a line (the sine of the angle between
    /// them is below [`SMALLEST_SINE`]) or `point` lies on the axis; [`Code::UnknownNode`] for nodes that do not
    /// exist; [`Code::UnsupportedOrientation`] for `SYSTEM=USER`.
    pub fn triad(
        &self,
        name: &str,
        scene: &Scene,
        point: [f64; 3],
        element_nodes: &[[f64; 3]],
    ) -> Result<Triad> {
        self.triad_of([name; 2], scene, point, element_nodes)
    }

    /// The same, where decks and documents call it differently.
    pub(crate) fn triad_of(
        &self,
        names: [&str; 2],
        scene: &Scene,
        point: [f64; 3],
        element_nodes: &[[f64; 3]],
    ) -> Result<Triad> {
        let [name, _] = names;
        let [a, b, c] = self.points(name, scene, element_nodes)?;
        let fail = |why: &str, remedy: &str| {
            let message =
                names.map(|name| format!("orientation {name} does not define three directions: {why}"));
            Diagnostic::error(Code::DegenerateOrientation, self.span, message, "this orientation")
                .help(remedy)
        };
        let unless_rectangular = |why: &str, act: &str| {
            let system = ["SYSTEM=RECTANGULAR", "system = RECTANGULAR"];
            fail(why, "").help(system.map(|system| format!("{act}, or use {system}")))
        };
        let triad = match self.system {
            System::User => {
                let message = format!(
                    "orientation {name} comes from a user subroutine, or differs from element to element"
                );
                return Err(Diagnostic::error(
                    Code::UnsupportedOrientation,
                    self.span,
                    message,
                    "SYSTEM=USER, or a *DISTRIBUTION",
                )
                .help([
                    "give the directions by SYSTEM=RECTANGULAR and the points a, b",
                    "give the directions by system = RECTANGULAR and the points a, b",
                ]));
            }
            System::Rectangular | System::ZRectangular => {
                let (first, second) = (minus(a, c), minus(b, c));
                let along = direction(first).ok_or_else(|| {
                    fail(
                        "point a coincides with the origin c",
                        "move a away from c (the global origin unless given)",
                    )
                })?;
                let normal = normal(first, second).ok_or_else(|| {
                    fail(
                        "points a, b and the origin c stand in a line",
                        "move b off the line through c and a",
                    )
                })?;
                if self.system == System::Rectangular {
                    [along, cross(normal, along), normal]
                } else {
                    [cross(normal, along), normal, along]
                }
            }
            System::Cylindrical => {
                let line = minus(b, a);
                let axial = direction(line).ok_or_else(|| {
                    fail("points a and b coincide", "give two different points of the axis")
                })?;
                let tangential = normal(line, minus(point, a))
                    .ok_or_else(|| unless_rectangular("the node lies on the axis", "move the axis"))?;
                [cross(tangential, axial), tangential, axial]
            }
            System::Spherical => {
                let (polar, radius) = (minus(b, a), minus(point, a));
                direction(polar).ok_or_else(|| {
                    fail("points a and b coincide", "give the centre and another point of the polar axis")
                })?;
                let radial = direction(radius)
                    .ok_or_else(|| unless_rectangular("the node lies at the centre", "move the centre"))?;
                let circumferential = normal(polar, radius).ok_or_else(|| {
                    unless_rectangular("the node lies on the polar axis", "turn the polar axis")
                })?;
                [radial, circumferential, cross(radial, circumferential)]
            }
        };
        Ok(turned(triad, usize::from(self.axis.clamp(1, 3)) - 1, self.angle))
    }

    /// The points a, b and c by which it is given.
    pub fn points(&self, name: &str, scene: &Scene, element_nodes: &[[f64; 3]]) -> Result<[[f64; 3]; 3]> {
        match &self.definition {
            Definition::None => Ok([[0.0; 3]; 3]),
            Definition::Coordinates { a, b, c } => Ok([*a, *b, *c]),
            Definition::Nodes { a, b, c } => {
                let node = |label: Label| {
                    scene.nodes.get(&label).map(|node| node.coordinates).ok_or_else(|| {
                        let message = format!("orientation {name} uses node {label}, which is not defined");
                        Diagnostic::error(Code::UnknownNode, self.span, message, "this orientation").help([
                            "define the node under *NODE, or use DEFINITION=COORDINATES",
                            "define the node under nodes, or use definition = COORDINATES",
                        ])
                    })
                };
                Ok([node(*a)?, node(*b)?, c.map_or(Ok([0.0; 3]), node)?])
            }
            Definition::OffsetToNodes { a, b, c } => {
                let node = |number: u64| {
                    let place = usize::try_from(number).ok().and_then(|number| number.checked_sub(1));
                    place.and_then(|place| element_nodes.get(place)).copied().ok_or_else(|| {
                        let (count, plural) = (element_nodes.len(), if element_nodes.len() == 1 { "" } else { "s" });
                        let message = format!(
                            "orientation {name} uses node {number} of its element, which has {count} node{plural}"
                        );
                        Diagnostic::error(Code::DegenerateOrientation, self.span, message, "OFFSET TO NODES")
                            .help([
                                "number the nodes of the element from 1, or use DEFINITION=COORDINATES",
                                "number the nodes of the element from 1, or use definition = COORDINATES",
                            ])
                    })
                };
                Ok([node(*a)?, node(*b)?, node(c.unwrap_or(1))?])
            }
        }
    }
}

impl Scene {
    /// What is wrong with orientations that connectors use: with those that hold everywhere, and with every other at the connector. Reading a scene
    /// leaves that to whoever evaluates it: an audit tells all of them.
    pub fn orientation_errors(&self) -> Vec<Diagnostic> {
        let everywhere = |orientation: &Orientation| {
            !orientation.depends_on_point()
                && orientation.system != System::User
                && !matches!(orientation.definition, Definition::OffsetToNodes { .. })
        };
        let mut found = Vec::new();
        let named =
            |section: &ConnectorSection| [section.orientation_a.clone(), section.orientation_b.clone()];
        let used: HashSet<String> =
            self.connector_sections.iter().flat_map(named).flatten().map(|name| name.value).collect();
        for (name, orientation) in self.orientations.iter().filter(|(name, _)| used.contains(*name)) {
            if everywhere(orientation) {
                found.extend(orientation.triad(name, self, [0.0; 3], &[]).err());
            }
        }
        for connector in self.connectors.values() {
            let Some(section) = self.section(connector) else { continue };
            for (end, name) in [(End::A, &section.orientation_a), (End::B, &section.orientation_b)] {
                let Some(name) = name else { continue };
                let orientation = self.orientations.get(&name.value).filter(|known| !everywhere(known));
                let Some(orientation) = orientation else { continue };
                let Some(point) = self.position(connector, end) else { continue };
                let nodes = self.element_nodes(connector);
                found.extend(orientation.triad(&name.value, self, point, &nodes).err());
            }
        }
        found.into_iter().map(|error: Diagnostic| error.in_scene(self)).collect()
    }
}

pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The vector times a power of two that keeps its squares within range.
pub(crate) fn scaled(v: [f64; 3]) -> [f64; 3] {
    let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
    let factor = if largest > 1e140 {
        2f64.powi(-600)
    } else if largest < 1e-140 {
        2f64.powi(600)
    } else {
        1.0
    };
    v.map(|x| x * factor)
}

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// v/|v|, unless v is zero or not finite.
fn direction(v: [f64; 3]) -> Option<[f64; 3]> {
    let v = scaled(v);
    let length = length(v);
    (length > 0.0 && length.is_finite()).then(|| v.map(|x| x / length))
}

/// The direction of u × v, unless they are parallel.
fn normal(u: [f64; 3], v: [f64; 3]) -> Option<[f64; 3]> {
    let (u, v) = (scaled(u), scaled(v));
    let bound = SMALLEST_SINE * length(u) * length(v);
    let product = cross(u, v);
    if length(product) > bound { direction(product) } else { None }
}

/// u × v, each component to two units in the last place also where its two products cancel.
pub(crate) fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let product = c * d;
        let error = (-c).mul_add(d, product);
        a.mul_add(b, -product) + error
    };
    [
        difference(u[1], v[2], u[2], v[1]),
        difference(u[2], v[0], u[0], v[2]),
        difference(u[0], v[1], u[1], v[0]),
    ]
}

/// The triad turned right-handed about its direction number `axis` (0 to 2) by `angle` degrees.
fn turned(triad: Triad, axis: usize, angle: f64) -> Triad {
    if angle == 0.0 {
        return triad;
    }
    let (sine, cosine) = sin_cos_degrees(angle);
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let combine = |p: f64, u: [f64; 3], q: f64, v: [f64; 3]| std::array::from_fn(|k| p * u[k] + q * v[k]);
    let mut result = triad;
    result[i] = combine(cosine, triad[i], sine, triad[j]);
    result[j] = combine(cosine, triad[j], -sine, triad[i]);
    result
}

/// Sine and cosine of an angle in degrees: exact at multiples of 90, and reduced without error elsewhere.
pub(crate) fn sin_cos_degrees(angle: f64) -> (f64, f64) {
    let within = angle % 360.0;
    let quarter = (within / 90.0).round();
    let (sine, cosine) = ((within - 90.0 * quarter) * (std::f64::consts::PI / 180.0)).sin_cos();
    match quarter.rem_euclid(4.0) {
        1.0 => (cosine, -sine),
        2.0 => (-sine, -cosine),
        3.0 => (-cosine, sine),
        _ => (sine, cosine),
    }
}

#[cfg(test)]
mod tests {
    use super::sin_cos_degrees;

    #[test]
    fn right_angles_are_exact() {
        for (angle, sine, cosine) in [
            (0.0, 0.0, 1.0),
            (90.0, 1.0, 0.0),
            (180.0, 0.0, -1.0),
            (270.0, -1.0, 0.0),
            (-90.0, -1.0, 0.0),
            (36090.0, 1.0, 0.0),
        ] {
            assert_eq!(sin_cos_degrees(angle), (sine, cosine), "{angle}");
        }
        let (sine, cosine) = sin_cos_degrees(3.6e7 + 30.0);
        assert!((sine - 0.5).abs() < 1e-15 && (cosine - 0.75f64.sqrt()).abs() < 1e-15);
    }
}
