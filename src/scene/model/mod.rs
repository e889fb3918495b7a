//! What a scene consists of.
//!
//! Lengths, forces and times are in the units of the deck; angles are radians, except where a comment says
//! degrees. Names are in upper case unless the deck quotes them. Maps and lists keep the order of the deck.

mod constraint;
mod coupled;
mod motion;
mod scene;

pub use constraint::{Coupling, CouplingKind, Equation, EquationTerm, RigidBody, Surface, Tie, Weighting};
pub use motion::{ElementForces, ForceSign, NodeMotion, Rotation, State, StateForces};
pub use scene::{MAX_WARNINGS, Scene};

use crate::choice::choices;
use crate::label::Label;
use crate::label::labelled::LabelSet;
use crate::span::{Span, Spanned};
use indexmap::IndexMap;
use pintle_kinematics::mpc;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Which of the two ends of a connector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The first node.
    A,
    /// The second node.
    B,
}

/// A node.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Node {
    /// Initial position, in the global rectangular system.
    pub coordinates: [f64; 3],
    /// Where it was read.
    #[serde(skip)]
    pub span: Span,
}

/// A set of nodes or elements.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Set {
    /// The members that the scene has, each once: ascending, or as written when the set is UNSORTED.
    pub labels: Vec<Label>,
    /// The members stand as written, by UNSORTED, and do not ascend.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub unsorted: bool,
    /// Members that are elements of types that the scene does not have; for a set of nodes, elements whose nodes it lacks.
    pub unmodelled: u64,
    /// The ranges in which the former are.
    #[serde(skip)]
    pub(crate) others: Vec<(Label, u64, u64)>,
    /// Where it was first defined.
    #[serde(skip)]
    pub span: Span,
}

impl Set {
    /// Is it a member? In logarithmic time where the members ascend.
    #[must_use]
    pub fn contains(&self, label: Label) -> bool {
        if self.unsorted { self.labels.contains(&label) } else { self.labels.binary_search(&label).is_ok() }
    }
}

/// The space a connector element lives in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Dimension {
    /// CONN2D2: components 1, 2 and 6; plane or axisymmetric.
    #[serde(rename = "CONN2D2")]
    Two,
    /// CONN3D2: all components.
    #[serde(rename = "CONN3D2")]
    Three,
}

impl Dimension {
    /// The element type as a deck writes it.
    #[must_use]
    pub const fn spelling(self) -> &'static str {
        match self {
            Self::Two => "CONN2D2",
            Self::Three => "CONN3D2",
        }
    }
}

/// An element CONN3D2 or CONN2D2.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ConnectorElement {
    /// The space it lives in.
    pub dimension: Dimension,
    /// The first node; none is the ground, which sits at the initial position of the other node.
    pub a: Option<Label>,
    /// The second node; none is the ground.
    pub b: Option<Label>,
    /// The place of its section in [`Scene::connector_sections`].
    pub section: usize,
    /// Where it was read.
    #[serde(skip)]
    pub span: Span,
}

impl ConnectorElement {
    /// The node where an end is initially: its own, or of the ground the other one.
    fn node_at(&self, end: End) -> Option<Label> {
        match end {
            End::A => self.a.or(self.b),
            End::B => self.b.or(self.a),
        }
    }
}

pintle_kinematics::named! {
    /// Kinds of point elements.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[serde(rename_all = "UPPERCASE")]
    pub enum PointKind {
        /// A point mass.
        #[default]
        Mass = "MASS",
        /// A point with rotary inertia.
        Rotaryi = "ROTARYI",
        /// A spring from a node to ground, in one degree of freedom.
        Spring1 = "SPRING1",
        /// A spring between two nodes, in one degree of freedom each.
        Spring2 = "SPRING2",
        /// A spring along the line of two nodes.
        Springa = "SPRINGA",
        /// A dashpot from a node to ground.
        Dashpot1 = "DASHPOT1",
        /// A dashpot between two nodes, in one degree of freedom each.
        Dashpot2 = "DASHPOT2",
        /// A dashpot along the line of two nodes.
        Dashpota = "DASHPOTA",
    }
}

impl PointKind {
    /// The number of its nodes.
    #[must_use]
    pub fn node_count(self) -> usize {
        match self {
            Self::Mass | Self::Rotaryi | Self::Spring1 | Self::Dashpot1 => 1,
            Self::Spring2 | Self::Springa | Self::Dashpot2 | Self::Dashpota => 2,
        }
    }
}

/// A mass, rotary inertia, spring or dashpot element.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PointElement {
    /// Its kind.
    pub kind: PointKind,
    /// The first, or only, node.
    pub node: Label,
    /// The second node.
    pub second: Option<Label>,
    /// Where it was read.
    #[serde(skip)]
    pub span: Span,
}

/// `*CONNECTOR SECTION`.
#[derive(Debug, Clone, Serialize)]
pub struct ConnectorSection {
    /// The element set that it applies to.
    pub element_set: Spanned<String>,
    /// The behaviour, if there is one.
    pub behavior: Option<Spanned<String>>,
    /// One or two connection types, in upper case; what they mean is for the catalogue to say.
    pub type_names: Vec<Spanned<String>>,
    /// The orientation at the first node.
    pub orientation_a: Option<Spanned<String>>,
    /// The orientation at the second node.
    pub orientation_b: Option<Spanned<String>>,
    /// Line 3: RETRACTOR, FLOW-CONVERTER: β_s; SLIPRING: mass per unit length, contact angle in radians.
    pub section_data: Vec<Option<f64>>,
    /// `CONTROLS=`.
    pub controls: Option<Spanned<String>>,
    /// `ELIMINATION=`.
    pub elimination: Option<bool>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// The types of `*MPC`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum MpcKind {
    /// A type that is evaluated.
    Evaluated(mpc::MpcType),
    /// Kept, not evaluated.
    Other(String),
}

impl MpcKind {
    /// The name, as a deck writes it.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Evaluated(kind) => kind.name(),
            Self::Other(name) => name,
        }
    }

    /// The type, where it is evaluated.
    #[must_use]
    pub const fn evaluated(&self) -> Option<mpc::MpcType> {
        match self {
            Self::Evaluated(kind) => Some(*kind),
            Self::Other(_) => None,
        }
    }
}

/// One multi-point constraint.
#[derive(Debug, Clone, Serialize)]
pub struct Mpc {
    /// Its type.
    pub kind: MpcKind,
    /// Its nodes in the order of the deck; the first is the dependent one.
    pub nodes: Vec<Label>,
    /// The data line.
    #[serde(skip)]
    pub span: Span,
}

/// `*MASS`.
#[derive(Debug, Clone, Serialize)]
pub struct Mass {
    /// The set of MASS elements.
    pub element_set: Spanned<String>,
    /// The mass of each.
    pub mass: f64,
}

/// `*ROTARY INERTIA`.
#[derive(Debug, Clone, Serialize)]
pub struct RotaryInertia {
    /// The set of ROTARYI elements.
    pub element_set: Spanned<String>,
    /// The axes of the inertia; the global ones when there is none.
    pub orientation: Option<Spanned<String>>,
    /// I11, I22, I33, I12, I13, I23.
    pub inertia: [f64; 6],
}

/// `*SPRING` or `*DASHPOT`.
#[derive(Debug, Clone, Serialize)]
pub struct Discrete {
    /// The set of spring or dashpot elements.
    pub element_set: Spanned<String>,
    /// The axes in which the degrees of freedom count.
    pub orientation: Option<Spanned<String>>,
    /// One degree of freedom per node, none along the line of two nodes.
    pub degrees_of_freedom: Vec<u8>,
    /// Is the table one of force over displacement or velocity?
    pub nonlinear: bool,
    /// `COMPLEX STIFFNESS`.
    pub complex: bool,
    /// Linear: coefficient, frequency; nonlinear: force, displacement or velocity. Then temperature and fields.
    pub rows: Vec<Vec<Option<f64>>>,
}

/// `*TRANSFORM`: axes in which loads and boundary conditions of nodes are expressed.
#[derive(Debug, Clone, Serialize)]
pub struct Transform {
    /// The nodes.
    pub node_set: Spanned<String>,
    /// What the points mean.
    pub kind: TransformKind,
    /// The first point.
    pub a: [f64; 3],
    /// The second point.
    pub b: [f64; 3],
}

choices! {
    /// How an amplitude is given.
    pub enum AmplitudeDefinition {
        /// Pairs of time and value, linear between them.
        Tabular = "TABULAR",
        /// Values at equal intervals.
        EquallySpaced = "EQUALLY SPACED",
        /// A Fourier series.
        Periodic = "PERIODIC",
        /// A product of two sines.
        Modulated = "MODULATED",
        /// An exponential decay.
        Decay = "DECAY",
        /// Pairs of time and value, with polynomials of fifth degree between them.
        SmoothStep = "SMOOTH STEP",
        /// Determined by the solution.
        SolutionDependent = "SOLUTION DEPENDENT",
        /// Determined by another program.
        Actuator = "ACTUATOR",
        /// Underwater explosion.
        Bubble = "BUBBLE",
        /// A response spectrum.
        Spectrum = "SPECTRUM",
        /// A power spectral density.
        PsdDefinition = "PSD DEFINITION",
        /// A user subroutine.
        User = "USER",
    }

    /// The time that an amplitude counts.
    pub enum AmplitudeTime {
        /// From the beginning of each step.
        StepTime = "STEP TIME",
        /// From the beginning of the analysis.
        TotalTime = "TOTAL TIME",
    }

    /// What the values of an amplitude are.
    pub enum AmplitudeValue {
        /// Factors of the magnitude.
        Relative = "RELATIVE",
        /// The magnitude itself.
        Absolute = "ABSOLUTE",
    }

    /// How loads without an amplitude change during a step.
    pub enum DefaultAmplitude {
        /// Linearly, from the value before.
        Ramp = "RAMP",
        /// At once.
        Step = "STEP",
    }

    /// How the axes of a `*TRANSFORM` are given.
    pub enum TransformKind {
        /// a on the local X′ axis, b in the X′Y′ plane, both as vectors from the global origin.
        Rectangular = "R",
        /// a and b on the axis; 1 radial, 2 tangential, 3 axial.
        Cylindrical = "C",
        /// a the centre, b on the polar axis; 1 radial, 2 circumferential, 3 meridional.
        Spherical = "S",
    }

    /// What is prescribed.
    #[derive(Default)]
    pub enum MotionType {
        /// Displacement or rotation, from the initial state.
        #[default]
        Displacement = "DISPLACEMENT",
        /// Velocity.
        Velocity = "VELOCITY",
        /// Acceleration.
        Acceleration = "ACCELERATION",
    }

    /// Does an option add to those of earlier steps or replace them?
    #[derive(Default)]
    pub enum Operation {
        /// Earlier ones stay.
        #[default]
        Modify = "MOD",
        /// Earlier ones are removed.
        New = "NEW",
    }

    /// What is prescribed in steps and goes on in later ones, by keyword.
    pub enum ConditionKind {
        /// Boundary conditions.
        Boundary = "BOUNDARY",
        /// Connector motions.
        ConnectorMotion = "CONNECTOR MOTION",
        /// Connector loads.
        ConnectorLoad = "CONNECTOR LOAD",
        /// Concentrated loads.
        ConcentratedLoad = "CLOAD",
        /// Distributed loads.
        DistributedLoad = "DLOAD",
    }
}

impl AmplitudeDefinition {
    /// Are its data pairs of time and value?
    #[must_use]
    pub fn has_pairs(self) -> bool {
        matches!(self, Self::Tabular | Self::SmoothStep)
    }
}

/// `*AMPLITUDE`.
#[derive(Debug, Clone, Serialize)]
pub struct Amplitude {
    /// `DEFINITION=`.
    pub definition: AmplitudeDefinition,
    /// `TIME=`; none is the step time.
    pub time: Option<AmplitudeTime>,
    /// `VALUE=`; none is relative.
    pub value: Option<AmplitudeValue>,
    /// `SMOOTH=`: the fraction of an interval that is smoothed.
    pub smooth: Option<f64>,
    /// `FIXED INTERVAL=` of equally spaced values.
    pub fixed_interval: Option<f64>,
    /// `BEGIN=`: the time of the first of them.
    pub begin: Option<f64>,
    /// All items of the data lines: pairs of time and value for a tabular one.
    pub data: Vec<Option<f64>>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// A number or a set, as loads and boundary conditions name what they act on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// One node or element.
    Label(Label),
    /// A set.
    Set(String),
}

impl Target {
    /// The name of the set.
    pub fn set(&self) -> Option<&str> {
        match self {
            Self::Set(name) => Some(name),
            Self::Label(_) => None,
        }
    }
}

/// How a motion or load is applied.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Application {
    /// How it changes in time.
    pub amplitude: Option<Spanned<String>>,
    /// Together with earlier steps.
    pub operation: Operation,
    /// `FIXED`: held where it is at the start of the step.
    pub fixed: bool,
    /// `USER`: a user subroutine gives the value, not the magnitude.
    pub user: bool,
    /// `FOLLOWER`: the load rotates with the node.
    pub follower: bool,
    /// `IMAGINARY`: the imaginary part of a harmonic value.
    pub imaginary: bool,
    /// `LOAD CASE=`.
    pub load_case: Option<u64>,
}

/// A line of `*BOUNDARY`.
#[derive(Debug, Clone, Serialize)]
pub struct Boundary {
    /// The nodes.
    pub target: Spanned<Target>,
    /// Degrees of freedom: 1 to 6, or 10 for material flow.
    pub degrees_of_freedom: Vec<u8>,
    /// The prescribed value.
    pub magnitude: f64,
    /// What the value is.
    pub kind: MotionType,
    /// How it is applied.
    pub applied: Application,
}

/// A line of `*CONNECTOR MOTION`.
#[derive(Debug, Clone, Serialize)]
pub struct ConnectorMotion {
    /// The connectors.
    pub target: Spanned<Target>,
    /// The component, 1 to 6.
    pub component: u8,
    /// The prescribed value, from the initial state; rotations in radians. None: held fixed.
    pub magnitude: Option<f64>,
    /// What the value is.
    pub kind: MotionType,
    /// How it is applied.
    pub applied: Application,
}

/// A line of `*CONNECTOR LOAD`: a force or moment in the current direction of the component.
#[derive(Debug, Clone, Serialize)]
pub struct ConnectorLoad {
    /// The connectors.
    pub target: Spanned<Target>,
    /// The component, 1 to 6.
    pub component: u8,
    /// The load; positive drives the component in its positive sense.
    pub magnitude: f64,
    /// How it is applied.
    pub applied: Application,
}

/// A line of `*INITIAL CONDITIONS, TYPE=VELOCITY`.
#[derive(Debug, Clone, Serialize)]
pub struct InitialVelocity {
    /// The nodes.
    pub target: Spanned<Target>,
    /// 1 to 6.
    pub degree_of_freedom: u8,
    /// The velocity, or angular velocity in radians over time.
    pub magnitude: f64,
}

/// A line of `*CLOAD`.
#[derive(Debug, Clone, Serialize)]
pub struct ConcentratedLoad {
    /// The nodes.
    pub target: Spanned<Target>,
    /// 1 to 6, or 10 for a flow force.
    pub degree_of_freedom: u8,
    /// Force, moment or flow force.
    pub magnitude: f64,
    /// How it is applied.
    pub applied: Application,
}

/// A line of `*DLOAD`.
#[derive(Debug, Clone, Serialize)]
pub struct DistributedLoad {
    /// The elements; none is the whole model.
    pub target: Option<Spanned<Target>>,
    /// The label, such as GRAV.
    pub label: String,
    /// Magnitude, and for GRAV the direction x, y, z.
    pub values: Vec<Option<f64>>,
    /// How it is applied.
    pub applied: Application,
}

impl DistributedLoad {
    /// Whether it is gravity: no other load of elements acts on connectors, through masses.
    pub fn is_gravity(&self) -> bool {
        self.label == "GRAV"
    }
}

/// Abaqus/Standard or Abaqus/Explicit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Solver {
    /// Implicit.
    Standard,
    /// Explicit dynamics.
    Explicit,
}

/// Initial, total, smallest and largest time or increment; none is the default of the code.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Times {
    /// The first increment.
    pub initial: Option<f64>,
    /// The length of the step.
    pub total: Option<f64>,
    /// The smallest increment.
    pub minimum: Option<f64>,
    /// The largest increment.
    pub maximum: Option<f64>,
}

/// What a step does.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Procedure {
    /// `*STATIC`.
    Static(Times),
    /// `*DYNAMIC`, explicit or not.
    Dynamic {
        /// `EXPLICIT`.
        explicit: bool,
        /// Its times.
        times: Times,
    },
    /// Another one, by keyword; its data are skipped.
    Other(String),
}

/// `*STEP` to `*END STEP`.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Step {
    /// `NAME=`.
    pub name: Option<String>,
    /// Geometrically nonlinear; none leaves it to the procedure.
    pub nlgeom: Option<bool>,
    /// A linear perturbation.
    pub perturbation: bool,
    /// The largest number of increments.
    pub increments: Option<u64>,
    /// `AMPLITUDE=`, for what has no amplitude of its own; none leaves it to the procedure.
    pub default_amplitude: Option<DefaultAmplitude>,
    /// What it does.
    pub procedure: Option<Procedure>,
    /// The kinds of which a keyword of the step says OP=NEW, with data lines or without ([`Step::removes`]).
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub removed: BTreeSet<ConditionKind>,
    /// Boundary conditions.
    pub boundaries: Vec<Boundary>,
    /// Concentrated loads.
    pub concentrated_loads: Vec<ConcentratedLoad>,
    /// Distributed loads.
    pub distributed_loads: Vec<DistributedLoad>,
    /// Connector motions.
    pub connector_motions: Vec<ConnectorMotion>,
    /// Connector loads.
    pub connector_loads: Vec<ConnectorLoad>,
    /// Output requests.
    pub outputs: Vec<OutputRequest>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

impl Step {
    /// Whether the conditions of a kind that earlier steps gave are removed: the step says so of the kind, or of a condition of its own.
    pub fn removes(&self, kind: ConditionKind) -> bool {
        fn any<'a>(mut of: impl Iterator<Item = &'a Application>) -> bool {
            of.any(|applied| applied.operation == Operation::New)
        }
        self.removed.contains(&kind)
            || match kind {
                ConditionKind::Boundary => any(self.boundaries.iter().map(|given| &given.applied)),
                ConditionKind::ConnectorMotion => {
                    any(self.connector_motions.iter().map(|given| &given.applied))
                }
                ConditionKind::ConnectorLoad => any(self.connector_loads.iter().map(|given| &given.applied)),
                ConditionKind::ConcentratedLoad => {
                    any(self.concentrated_loads.iter().map(|given| &given.applied))
                }
                ConditionKind::DistributedLoad => {
                    any(self.distributed_loads.iter().map(|given| &given.applied))
                }
            }
    }
}

/// `*OUTPUT`, `*ELEMENT OUTPUT` and their kin.
#[derive(Debug, Clone, Serialize)]
pub struct OutputRequest {
    /// The keyword.
    pub keyword: String,
    /// Its other parameters as written.
    pub parameters: IndexMap<String, Option<String>>,
    /// `ELSET=`.
    pub element_set: Option<Spanned<String>>,
    /// `NSET=`.
    pub node_set: Option<Spanned<String>>,
    /// The identifiers on its data lines, in upper case.
    pub variables: Vec<String>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// What a deck has and the scene has not.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Skipped {
    /// Keywords.
    pub keywords: IndexMap<String, SkippedItem>,
    /// Elements of types that are not connectors, masses, springs or dashpots.
    pub element_types: IndexMap<String, SkippedItem>,
    /// Parameters and data of keywords that are understood, such as `*STATIC, DIRECT`.
    #[serde(skip)]
    pub parameters: IndexMap<String, SkippedItem>,
    /// Comment lines.
    #[serde(skip)]
    pub comments: u64,
    /// Those of the keywords that constrain nodes, such as `*EQUATION`, in order.
    #[serde(skip)]
    pub constraints: Vec<SkippedConstraint>,
    /// The nodes of connectors and constraints that are nodes of elements of such types, too; none where those are not known.
    #[serde(skip)]
    pub nodes: Option<LabelSet>,
}

/// A keyword that was skipped, and constrains nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkippedConstraint {
    /// Its name, without the asterisk.
    pub keyword: &'static str,
    /// Where it is.
    pub span: Span,
}

impl Skipped {
    /// Counts a parameter or data of a keyword on a line.
    pub(super) fn count(&mut self, what: String, line: u32) {
        let item = self.parameters.entry(what).or_default();
        if item.count == 0 {
            item.first_line = line;
        }
        item.count += 1;
    }
}

/// How much of one kind was skipped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct SkippedItem {
    /// How often the keyword occurs, or how many elements there are.
    pub count: u64,
    /// Data lines skipped.
    pub data_lines: u64,
    /// The line where it first occurs.
    pub first_line: u32,
}
