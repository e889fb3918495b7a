//! A scene as a whole, and what its parts say together.

use crate::behavior::Behavior;
use crate::diagnostic::{Diagnostic, Result};
use crate::label::Label;
use crate::label::labelled::{Beside, ByLabel};
use crate::model::constraint::{Coupling, Equation, RigidBody, Surface, Tie};
use crate::model::motion::State;
use crate::model::{
    Amplitude, Boundary, ConnectorElement, ConnectorMotion, ConnectorSection, Discrete, End, InitialVelocity,
    Mass, Mpc, Node, PointElement, RotaryInertia, Set, Skipped, Solver, Step, Transform, TransformKind,
};
use crate::orientation::{Definition, GLOBAL, Orientation, System, Triad};
use crate::wording::keyword;
use crate::written::Written;
use indexmap::IndexMap;
use serde::Serialize;
use std::collections::BTreeSet;
/// A model: nodes, connectors and what acts on them.
///
/// All references between its parts have been checked: a name or number that occurs in it is defined in it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Scene {
    /// The name of the file, or what the caller called the text.
    pub name: String,
    /// Every file that was read, the deck first; spans count here.
    #[serde(skip)]
    pub files: Vec<String>,
    /// The text under `*HEADING`.
    pub heading: String,
    /// Nodes by number.
    pub nodes: ByLabel<Node>,
    /// Node sets by name.
    pub node_sets: IndexMap<String, Set>,
    /// Connector elements by number.
    pub connectors: ByLabel<ConnectorElement>,
    /// Masses, rotary inertias, springs and dashpots by element number.
    pub point_elements: ByLabel<PointElement>,
    /// The nodes of connectors and constraints to which elements and constraints that are not read give rotational degrees of freedom.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub rotating_nodes: BTreeSet<Label>,
    /// Whether there are elements of an axisymmetric type.
    pub axisymmetric: bool,
    /// Whether all elements are two-dimensional: nodes have the degrees of freedom 1, 2, 6 and 10 alone.
    pub two_dimensional: bool,
    /// Element sets by name.
    pub element_sets: IndexMap<String, Set>,
    /// Orientations by name.
    pub orientations: IndexMap<String, Orientation>,
    /// Connector sections; [`ConnectorElement::section`] counts here.
    pub connector_sections: Vec<ConnectorSection>,
    /// Connector behaviours by name.
    pub behaviors: IndexMap<String, Behavior>,
    /// Multi-point constraints.
    pub mpcs: Vec<Mpc>,
    /// `*EQUATION`.
    pub equations: Vec<Equation>,
    /// Surfaces of nodes by name.
    pub surfaces: IndexMap<String, Surface>,
    /// `*RIGID BODY`.
    pub rigid_bodies: Vec<RigidBody>,
    /// `*COUPLING`.
    pub couplings: Vec<Coupling>,
    /// `*TIE`.
    pub ties: Vec<Tie>,
    /// `*MASS`: one value per set of MASS elements.
    pub masses: Vec<Mass>,
    /// `*ROTARY INERTIA`.
    pub rotary_inertias: Vec<RotaryInertia>,
    /// `*SPRING`.
    pub springs: Vec<Discrete>,
    /// `*DASHPOT`.
    pub dashpots: Vec<Discrete>,
    /// `*TRANSFORM`.
    pub transforms: Vec<Transform>,
    /// Amplitudes by name.
    pub amplitudes: IndexMap<String, Amplitude>,
    /// `*INITIAL CONDITIONS, TYPE=VELOCITY`.
    pub initial_velocities: Vec<InitialVelocity>,
    /// Boundary conditions given before the first step.
    pub boundaries: Vec<Boundary>,
    /// Connector motions given before the first step: components held fixed.
    pub connector_motions: Vec<ConnectorMotion>,
    /// Steps in order.
    pub steps: Vec<Step>,
    /// States given with the scene; a deck has none.
    pub states: Vec<State>,
    /// Which solver the procedures belong to, if there are any.
    pub solver: Option<Solver>,
    /// What was passed over.
    pub skipped: Skipped,
    /// What deserves a look; at most [`MAX_WARNINGS`] of each code, of which the first counts the rest.
    #[serde(skip)]
    pub warnings: Vec<Diagnostic>,
    /// What was written where coordinates are computed.
    #[serde(skip)]
    pub written: Written,
}

/// The number of warnings of one code that a scene keeps.
pub const MAX_WARNINGS: usize = 100;

impl Scene {
    /// The initial position of an end of a connector. The ground sits where the other node is.
    #[must_use]
    pub fn position(&self, connector: &ConnectorElement, end: End) -> Option<[f64; 3]> {
        self.nodes.get(&connector.node_at(end)?).map(|node| node.coordinates)
    }

    /// The same for one end after another, each looked up beside the one before.
    pub fn positions(&self) -> impl Fn(&ConnectorElement, End) -> Option<[f64; 3]> + '_ {
        let nodes = Beside::new(&self.nodes);
        move |connector, end| nodes.get(connector.node_at(end)?).map(|node| node.coordinates)
    }

    /// The initial positions of the nodes of a connector, without the ground.
    #[must_use]
    pub fn element_nodes(&self, connector: &ConnectorElement) -> Vec<[f64; 3]> {
        let nodes = [connector.a, connector.b].into_iter().flatten();
        nodes.filter_map(|node| self.nodes.get(&node)).map(|node| node.coordinates).collect()
    }

    /// The directions of displacements, rotations, forces and moments of a node in boundary conditions, loads and nodal output.
    ///
    /// They are those of its `*TRANSFORM` at the initial position of the node, or the global ones. Connectors do not know them: what they measure
    /// and their own forces are as without.
    ///
    /// # Errors
    /// [`Code::DegenerateOrientation`](crate::Code::DegenerateOrientation) where the points of the transform define no
    /// directions at the node; the reader of decks has excluded it.
    pub fn nodal_axes(&self, node: Label) -> Result<Triad> {
        let Some(position) = self.nodes.get(&node).map(|node| node.coordinates) else { return Ok(GLOBAL) };
        let holds = |transform: &&Transform| {
            self.node_sets.get(&transform.node_set.value).is_some_and(|set| set.contains(node))
        };
        self.transforms.iter().find(holds).map_or(Ok(GLOBAL), |transform| transform.triad(self, position))
    }

    /// The section of a connector element.
    #[must_use]
    pub fn section(&self, connector: &ConnectorElement) -> Option<&ConnectorSection> {
        self.connector_sections.get(connector.section)
    }

    /// The behaviour that a section names.
    #[must_use]
    pub fn behavior(&self, section: &ConnectorSection) -> Option<&Behavior> {
        self.behaviors.get(section.behavior.as_ref()?.value.as_str())
    }
}

impl Transform {
    /// The directions at `point`: e1, e2, e3, each in global components. They are right to a few units in the last place.
    ///
    /// # Errors
    /// [`Code::DegenerateOrientation`](crate::Code::DegenerateOrientation) where the points define no directions there.
    pub fn triad(&self, scene: &Scene, point: [f64; 3]) -> Result<Triad> {
        let system = match self.kind {
            TransformKind::Rectangular => System::Rectangular,
            TransformKind::Cylindrical => System::Cylindrical,
            TransformKind::Spherical => System::Spherical,
        };
        let definition = Definition::Coordinates { a: self.a, b: self.b, c: [0.0; 3] };
        let axes = Orientation { system, definition, axis: 1, angle: 0.0, span: self.node_set.span };
        let names =
            keyword("TRANSFORM").map(|keyword| format!("by {keyword} of set {}", self.node_set.value));
        axes.triad_of(names.each_ref().map(String::as_str), scene, point, &[])
    }
}
