//! Which degrees of freedom the nodes of connectors have.

use crate::label::Label;
use crate::label::labelled::LabelMap;
use crate::model::{Dimension, PointKind, Scene, Solver};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::mpc::MpcType;

/// Whether the nodes of connectors rotate, and whether they are confined to the plane.
///
/// A node has translations. Rotations it has only where something gives them:
///
/// - a connector at an end where its type permits an orientation, but for JOIN, AXIAL and LINK
///   ([`ConnectionType::rotations`]);
/// - an element ROTARYI; springs and dashpots in degrees of freedom 4 to 6;
/// - the constraints BEAM, REVOLUTE and UNIVERSAL; the reference nodes of rigid bodies and couplings, and the nodes tied to rigid bodies;
/// - elements and constraints that the reader skips: beams, pipes, shells, rigid elements, user elements and substructures (whose
///   degrees of freedom it cannot know), the reference nodes of constraints that are not read ([`Scene::rotating_nodes`]).
///
/// A boundary condition or load gives none: it acts on those that there are.
#[derive(Debug, Clone, Default)]
pub struct NodeFreedom {
    nodes: LabelMap<Freedom>,
    /// Whether all nodes are confined to the plane.
    two_dimensional: bool,
}

/// What is known of a node.
#[derive(Debug, Clone, Copy, Default)]
struct Freedom {
    /// It belongs to a connector.
    is_connected: bool,
    rotates: bool,
    is_planar: bool,
}

impl NodeFreedom {
    /// The degrees of freedom of a scene, in one pass over what it has.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let ends = 2 * scene.connectors.len();
        let capacity = scene.nodes.len().min(ends);
        let mut nodes: LabelMap<Freedom> = LabelMap::with_capacity_and_hasher(capacity, Default::default());
        let of_section: Vec<[bool; 2]> =
            scene.connector_sections.iter().map(|s| rotations(s, scene.solver)).collect();
        for element in scene.connectors.values() {
            let rotations = of_section.get(element.section).copied().unwrap_or_default();
            for (node, rotates) in [element.a, element.b].into_iter().zip(rotations) {
                let Some(node) = node else { continue };
                let freedom = nodes.entry(node).or_default();
                freedom.is_connected = true;
                freedom.rotates |= rotates;
                freedom.is_planar |= element.dimension == Dimension::Two;
            }
        }
        let mut turn = |node: Label| nodes.entry(node).or_default().rotates = true;
        scene.rotating_nodes.iter().copied().for_each(&mut turn);
        for element in scene.point_elements.values().filter(|element| element.kind == PointKind::Rotaryi) {
            turn(element.node);
        }
        for discrete in scene.springs.iter().chain(&scene.dashpots) {
            let turns =
                |end: usize| discrete.degrees_of_freedom.get(end).is_some_and(|dof| matches!(dof, 4..=6));
            let set = scene.element_sets.get(discrete.element_set.value.as_str());
            for label in set.iter().flat_map(|set| &set.labels) {
                let Some(element) = scene.point_elements.get(label) else { continue };
                for (end, node) in [Some(element.node), element.second].into_iter().enumerate() {
                    node.filter(|_| turns(end)).into_iter().for_each(&mut turn);
                }
            }
        }
        for mpc in &scene.mpcs {
            if matches!(mpc.kind.evaluated(), Some(MpcType::Beam | MpcType::Revolute | MpcType::Universal)) {
                mpc.nodes.iter().copied().for_each(&mut turn);
            }
        }
        scene.couplings.iter().for_each(|coupling| turn(coupling.reference));
        for body in &scene.rigid_bodies {
            turn(body.reference);
            let set = body.tie_set.as_ref().and_then(|name| scene.node_sets.get(&name.value));
            set.into_iter().flat_map(|set| &set.labels).copied().for_each(&mut turn);
        }
        // What is tied to a node that turns turns with it, and so on along a chain of ties.
        let mut tied: LabelMap<Vec<Label>> = LabelMap::default();
        for mpc in scene.mpcs.iter().filter(|mpc| mpc.kind.evaluated() == Some(MpcType::Tie)) {
            for node in &mpc.nodes {
                tied.entry(*node).or_default().extend(mpc.nodes.iter().filter(|other| *other != node));
            }
        }
        let turns = |node: &Label| nodes.get(node).is_some_and(|freedom| freedom.rotates);
        let mut turning: Vec<Label> = tied.keys().copied().filter(turns).collect();
        while let Some(node) = turning.pop() {
            for other in tied.get(&node).into_iter().flatten() {
                let freedom = nodes.entry(*other).or_default();
                if !freedom.rotates {
                    freedom.rotates = true;
                    turning.push(*other);
                }
            }
        }
        Self { nodes, two_dimensional: scene.two_dimensional }
    }

    /// Whether a node has rotational degrees of freedom.
    #[must_use]
    pub fn rotates(&self, node: Label) -> bool {
        self.nodes.get(&node).is_some_and(|freedom| freedom.rotates)
    }

    /// Whether a node belongs to a connector and does not rotate.
    #[must_use]
    pub fn is_fixed_in_rotation(&self, node: Label) -> bool {
        self.nodes.get(&node).is_some_and(|freedom| freedom.is_connected && !freedom.rotates)
    }

    /// What a node lacks of three displacements and three rotations.
    #[must_use]
    pub fn lacks(&self, node: Label) -> [[Option<Lack>; 3]; 2] {
        let plane = self.is_planar(node).then_some(Lack::Plane);
        let turn = self.is_fixed_in_rotation(node).then_some(Lack::Rotations);
        [[None, None, plane], [turn.or(plane), turn.or(plane), turn]]
    }

    /// Whether a node belongs to an element CONN2D2, or to a model of two dimensions.
    #[must_use]
    pub fn is_planar(&self, node: Label) -> bool {
        self.two_dimensional || self.nodes.get(&node).is_some_and(|freedom| freedom.is_planar)
    }
}

/// Why a node cannot move along or about an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lack {
    /// It belongs to connectors, and nothing gives it rotations.
    Rotations,
    /// It is confined to the plane: degrees of freedom 3, 4 and 5.
    Plane,
}

impl Lack {
    /// What a node lacks.
    #[must_use]
    pub const fn what(self) -> &'static str {
        match self {
            Self::Rotations => "has no rotational degrees of freedom",
            Self::Plane => "of a two-dimensional element or model leaves the plane",
        }
    }

    /// How the motion is given right.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::Rotations => {
                "leave its rotation and angular rates out; JOIN, AXIAL, LINK and ends without an orientation give none, an \
                 element ROTARYI does"
            }
            Self::Plane => {
                "CONN2D2 and models of two dimensions have the degrees of freedom 1, 2, 6 and 10: give u1, u2, ur3, flow and \
                 their rates, or use CONN3D2"
            }
        }
    }
}

impl Scene {
    /// Whether the model is axisymmetric: it has elements of an axisymmetric type (CAX4, SAX1, MAX1, RAX2 …). A CONN2D2 element is
    /// the same in both: 1 is the radius, 2 the axis, and 6 the rotation from 1 to 2.
    #[must_use]
    pub fn is_axisymmetric(&self) -> bool {
        self.axisymmetric
    }

    /// Whether there are connectors, and all are CONN2D2.
    pub(crate) fn has_flat_connectors_alone(&self) -> bool {
        let mut all = self.connectors.values().map(|element| element.dimension).peekable();
        all.peek().is_some() && all.all(|dimension| dimension == Dimension::Two)
    }
}

/// The ends that the type of a section gives rotations; both where there is no such type.
fn rotations(section: &crate::model::ConnectorSection, solver: Option<Solver>) -> [bool; 2] {
    let [first, rest @ ..] = section.type_names.as_slice() else { return [true; 2] };
    let second = rest.first().map(|name| name.value.as_str());
    let Ok(connection) = ConnectionType::named(&first.value, second) else { return [true; 2] };
    let standard = (solver == Some(Solver::Standard)).then(|| connection.in_standard()).flatten();
    standard.map_or(connection.rotations, |other| other.rotations)
}

/// Whether an element type that is not read belongs to models of two dimensions or of three; None where it belongs to both. What gives a node the
/// degrees of freedom 3 to 5 counts for three: generalised plane strain, axisymmetric elements with twist or bending.
pub(super) fn element_dimension(name: &str) -> Option<Dimension> {
    const NEITHER: [&str; 7] = ["SPRING", "DASHPOT", "MASS", "ROTARYI", "HEATCAP", "GAPUNI", "DGAP"];
    const THREE: [&str; 5] = ["CPEG", "CGAX", "MGAX", "CAXA", "SAXA"];
    const TWO: [&str; 17] = [
        "CPS", "CPE", "CAX", "B2", "T2D", "R2D", "RB2D", "PIPE2", "FRAME2D", "DCOUP2D", "JOINT2D", "CINPS",
        "CINPE", "AC2D", "DC2D", "COH2D", "PSI2",
    ];
    let begins = |names: &[&str]| names.iter().any(|known| name.starts_with(known));
    let is_own = name.starts_with(['U', 'V', 'Z']) && name.chars().nth(1).is_some_and(|c| c.is_ascii_digit());
    if is_own || begins(&NEITHER) {
        None
    } else if !begins(&THREE) && (begins(&TWO) || name.contains("AX")) {
        Some(Dimension::Two)
    } else {
        Some(Dimension::Three)
    }
}

/// Whether the nodes of an element type that is not read have rotations, or may have: beams, pipes, elbows, frames, shells (not
/// continuum shells), rigid and joint elements, distributing couplings; user elements and substructures.
pub(super) fn element_rotates(name: &str) -> bool {
    const FAMILIES: [&str; 18] = [
        "B2", "B3", "PIPE2", "PIPE3", "ELBOW", "FRAME", "S3", "S4", "S8", "S9", "STRI", "SAX", "R2D2", "R3D",
        "RAX", "RB", "JOINT", "DCOUP",
    ];
    let numbered = |letter: char| {
        name.strip_prefix(letter).is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
    };
    FAMILIES.iter().any(|family| name.starts_with(family)) || numbered('U') || numbered('V') || numbered('Z')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn element_types_belong_to_two_dimensions_or_three() {
        let of = |names: &[&str], dimension| {
            for name in names {
                assert_eq!(element_dimension(name), dimension, "{name}");
            }
        };
        of(
            &["CPS4R", "CPE8RP", "CAX8", "SAX1", "RAX2", "B21", "T2D2", "R2D2", "PIPE21", "AC2D4"],
            Some(Dimension::Two),
        );
        of(
            &["C3D8R", "B31", "S4R", "R3D4", "T3D2", "CPEG4", "CGAX4", "SAXA12", "CAXA41", "DCOUP3D"],
            Some(Dimension::Three),
        );
        of(&["SPRINGA", "DASHPOT2", "MASS", "GAPUNI", "U1", "Z42"], None);
    }
}
