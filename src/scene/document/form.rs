//! How a scene is written in TOML and JSON. The JSON Schema is made from these types.

use crate::behavior::{
    Basis, DamageCriterion, DamageEvolutionKind, DampingKind, Degradation, Extrapolation,
    HardeningDefinition, HardeningKind, Integration, Operator, PotentialFunction, PotentialOperator,
    RateInterpolation, Softening, TableOptions,
};
pub(crate) use crate::document::value::{
    Component, Entries, Item, Member, OneOrMany, Parameter, Point, PointOrNode, Row, Source, Target,
};
use crate::model::Weighting;
use crate::model::{
    AmplitudeDefinition, AmplitudeTime, AmplitudeValue, ConditionKind, DefaultAmplitude, Dimension,
    MotionType, Operation, PointKind, TransformKind,
};
use crate::orientation::System;
use crate::span::{Span, Spanned};
use crate::states::Motion;
use serde::{Deserialize, Serialize};

/// The version of the form.
pub(crate) const SCHEMA: &str = "pintle-scene/1";

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Fields that must be there stand before the semicolon, the others after it.
macro_rules! form {
    (tabulated $(#[$meta:meta])* $name:ident {
        $($(#[$needed_meta:meta])* $needed:ident: $needed_type:ty),*;
        $($(#[$field_meta:meta])* $field:ident: $type:ty),* $(,)?
    }) => {
        form! {
            $(#[$meta])* $name {
                $($(#[$needed_meta])* $needed: $needed_type),*;
                $($(#[$field_meta])* $field: $type,)*
                /// What the table gives beyond its ends; constant unless given here or by the behaviour.
                extrapolation: Option<Extrapolation>,
                /// Is the table regularised in Abaqus/Explicit?
                regularize: Option<bool>,
                /// The tolerance of the regularisation.
                rtol: Option<Spanned<f64>>,
            }
        }
        impl $name {
            pub(crate) fn options(&self) -> Options {
                (self.extrapolation, self.regularize, self.rtol)
            }
            pub(super) fn set_options(&mut self, table: TableOptions) {
                self.extrapolation = table.extrapolation;
                self.regularize = table.regularize;
                self.rtol = table.rtol.map(placeless);
            }
        }
    };
    ($(#[$meta:meta])* $name:ident {
        $($(#[$needed_meta:meta])* $needed:ident: $needed_type:ty),*;
        $($(#[$field_meta:meta])* $field:ident: $type:ty),* $(,)?
    }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $name {
            $($(#[$needed_meta])* pub(crate) $needed: $needed_type,)*
            $($(#[$field_meta])* #[serde(default, skip_serializing_if = "is_default")]
              pub(crate) $field: $type,)*
        }
    };
}

/// Extrapolation, regularisation, tolerance.
pub(crate) type Options = (Option<Extrapolation>, Option<bool>, Option<Spanned<f64>>);

/// A value that was not read anywhere.
pub(super) fn placeless<T>(value: T) -> Spanned<T> {
    Spanned::new(value, Span::default())
}

/// A name.
pub(super) type Name = Spanned<String>;
pub(super) type List<T> = Vec<Spanned<T>>;

form! {
    /// A scene of pintle: connectors, what they connect, and what acts on them. Lengths, forces and times are in units of
    /// your choice; angles are radians, except where a field says degrees.
    Document {
        ;
        /// For editors; not read.
        #[serde(rename = "$schema")]
        schema_link: Option<String>,
        /// The version of this form: pintle-scene/1.
        schema: Option<Name>,
        /// What the scene is about.
        heading: Name,
        /// Nodes by number: the initial position x, y, z in the global rectangular system.
        nodes: Entries<Spanned<Point>>,
        /// Node sets by name.
        node_sets: Entries<List<Member>>,
        /// Connector elements by number.
        connectors: Entries<Spanned<Connector>>,
        /// Masses, rotary inertias, springs and dashpots by element number.
        point_elements: Entries<Spanned<PointElement>>,
        /// Nodes that have rotations without a connector giving them: those of beams, shells, rigid bodies …
        rotating_nodes: List<Target>,
        /// Is the model axisymmetric?
        axisymmetric: bool,
        /// Have all nodes the degrees of freedom 1, 2, 6 and 10 alone? If not given, yes where all connectors are two-dimensional.
        two_dimensional: Option<bool>,
        /// Element sets by name.
        element_sets: Entries<List<Member>>,
        /// Orientations by name.
        orientations: Entries<Spanned<Orientation>>,
        /// The type, orientations and behaviour of sets of connectors.
        connector_sections: List<ConnectorSection>,
        /// Connector behaviours by name.
        behaviors: Entries<Spanned<Behavior>>,
        /// Multi-point constraints.
        mpcs: List<Mpc>,
        /// Linear equations between degrees of freedom.
        equations: List<Equation>,
        /// Surfaces of nodes by name.
        surfaces: Entries<List<SurfaceMember>>,
        /// Rigid bodies.
        rigid_bodies: List<RigidBody>,
        /// Couplings of nodes to a reference node.
        couplings: List<Coupling>,
        /// Ties of the nodes of one surface to those of another.
        ties: List<Tie>,
        /// The mass of sets of MASS elements.
        masses: List<Mass>,
        /// The inertia of sets of ROTARYI elements.
        rotary_inertias: List<RotaryInertia>,
        /// The stiffness of sets of spring elements.
        springs: List<Discrete>,
        /// The coefficient of sets of dashpot elements.
        dashpots: List<Discrete>,
        /// Axes in which loads and boundary conditions of nodes are expressed.
        transforms: List<Transform>,
        /// Amplitudes by name.
        amplitudes: Entries<Spanned<Amplitude>>,
        /// Velocities at the beginning.
        initial_velocities: List<InitialVelocity>,
        /// Boundary conditions before the first step.
        boundaries: List<Boundary>,
        /// Components of connectors held fixed before the first step.
        connector_motions: List<ConnectorMotion>,
        /// Steps in order.
        steps: List<Step>,
        /// What the nodes do, one state after the other.
        states: List<State>,
    }
}

form! {
    /// What the nodes do at one time.
    State {
        ;
        /// Its number; all states are numbered, upwards, or none.
        number: Option<u64>,
        /// The time.
        time: Option<f64>,
        /// Motions by node number; a node that is not among them is at rest in its initial place.
        nodes: Entries<Motion>,
        /// Component forces by element number: f1 to f3, m1 to m3; CRF1 to CRM3. Positive resists growth of the component.
        forces: Entries<Entries<Spanned<f64>>>,
    }
}

form! {
    /// A connector element. An end that is not given is the ground.
    Connector {
        ;
        /// The first node.
        a: Option<Spanned<Target>>,
        /// The second node.
        b: Option<Spanned<Target>>,
        /// CONN3D2 unless given.
        dimension: Option<Dimension>,
    }
}

form! {
    /// A mass, rotary inertia, spring or dashpot element.
    PointElement {
        /// The kind of element.
        kind: PointKind,
        /// Its one or two nodes.
        nodes: List<Target>;
    }
}

form! {
    /// Three directions at a point, by the points a, b and c.
    Orientation {
        ;
        /// What the points mean; rectangular unless given: a on the local 1-axis, b in the 1-2-plane, c the origin.
        system: Option<System>,
        /// How the points are given; coordinates unless given.
        definition: Option<Definition>,
        /// The first point.
        a: Option<Spanned<PointOrNode>>,
        /// The second point.
        b: Option<Spanned<PointOrNode>>,
        /// The origin.
        c: Option<Spanned<PointOrNode>>,
        /// The local direction, 1 to 3, about which the system is turned further; 1 unless given.
        axis: Option<Spanned<u64>>,
        /// By how much, in degrees.
        angle: Option<Spanned<f64>>,
    }
}

/// How the points of an orientation are given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(crate) enum Definition {
    /// Global coordinates.
    Coordinates,
    /// Nodes of the scene.
    Nodes,
    /// Nodes of the element, counted from 1.
    OffsetToNodes,
}

form! {
    /// What connects a set of connectors.
    ConnectorSection {
        /// The set of connector elements.
        element_set: Name,
        /// One connection type, or a basic translational and a basic rotational one.
        r#type: OneOrMany;
        /// The connector behaviour.
        behavior: Option<Name>,
        /// The orientation at the first node.
        orientation_a: Option<Name>,
        /// The orientation at the second node.
        orientation_b: Option<Name>,
        /// RETRACTOR, FLOW-CONVERTER: scale factor of the flow; SLIPRING: mass per length, contact angle in radians.
        data: List<Item>,
        /// Section controls.
        controls: Option<Name>,
        /// Is the constraint eliminated in Abaqus/Explicit?
        elimination: Option<bool>,
    }
}

form! {
    tabulated
    /// What the available components of a connector do.
    Behavior {
        ;
        /// How it is integrated in Abaqus/Explicit.
        integration: Option<Integration>,
        /// Reference lengths of the components 1 to 3, reference angles in degrees of 4 to 6, by component.
        constitutive_reference: Entries<Spanned<f64>>,
        /// Force over displacement.
        elasticity: List<Law>,
        /// Force over velocity.
        damping: List<Law>,
        /// Friction.
        friction: List<Friction>,
        /// Derived components by name, each a list of terms that add up.
        derived_components: Entries<List<DerivedTerm>>,
        /// Plasticity.
        plasticity: List<Plasticity>,
        /// Damage.
        damage: List<Damage>,
        /// Limits of positions.
        stops: List<Stop>,
        /// What locks components.
        locks: List<Lock>,
        /// What releases components.
        failures: List<Lock>,
    }
}

form! {
    tabulated
    /// A force that depends on components: linear for one component, coupled without one, nonlinear, or rigid.
    Law {
        ;
        /// The component, 1 to 6.
        component: Option<Spanned<Component>>,
        /// Force, then displacement or velocity, or one column for each independent component.
        nonlinear: bool,
        /// No motion at all, of `component` or `components` or all.
        rigid: bool,
        /// The components of a rigid behaviour.
        components: List<Component>,
        /// Damping only: viscous unless given.
        r#type: Option<DampingKind>,
        /// A coupled matrix of 36 terms instead of the 21 of the upper triangle.
        unsymmetric: bool,
        /// A coupled matrix is followed by a frequency.
        frequency_dependence: bool,
        /// The components on which a nonlinear force depends, if not on its own.
        independent: Option<Independent>,
        /// Linear: coefficient, frequency. Coupled: the matrix. Nonlinear: see there.
        rows: List<Row>,
    }
}

form! {
    /// The components on which a table depends.
    Independent {
        /// Positions or constitutive displacements.
        basis: Basis,
        /// The components.
        components: List<Component>;
    }
}

form! {
    tabulated
    /// Friction, predefined for the connection type or described here.
    Friction {
        ;
        /// Predefined: the geometric constants of the type, then internal contact forces.
        predefined: Option<Spanned<Vec<Spanned<Item>>>>,
        /// The component that slips; none with a potential.
        component: Option<Spanned<Component>>,
        /// The direction of slip of a coupled friction.
        potential: Option<Spanned<Potential>>,
        /// The normal force: a component or a derived component.
        contact_force: Option<Spanned<Source>>,
        /// The components on which the internal contact force depends.
        independent: Option<Independent>,
        /// The number of field variables in the rows.
        dependencies: Option<Spanned<u64>>,
        /// Effective radius if translations and rotations mix, internal contact force, independent motions, accumulated
        /// slip, temperature, field variables.
        rows: List<Vec<Spanned<Item>>>,
        /// The stiffness of sticking.
        stick_stiffness: Option<Spanned<f64>>,
        /// The friction coefficient.
        coefficient: Option<Spanned<Coefficient>>,
    }
}

form! {
    /// A friction coefficient: a table, an exponential decay, or test data.
    Coefficient {
        ;
        /// μ, slip rate, contact force.
        rows: List<Row>,
        /// μ_k + (μ_s − μ_k) exp(−d_c·slip rate): the static coefficient, the kinetic coefficient, the decay.
        exponential: Option<Spanned<[f64; 3]>>,
        /// Test data of an exponential decay.
        test_data: List<Vec<Spanned<Item>>>,
        /// The largest friction force.
        maximum: Option<Spanned<f64>>,
        /// The slip tolerance.
        slip_tolerance: Option<Spanned<f64>>,
        /// The elastic slip allowed, in the unit of the slip; in place of the tolerance.
        elastic_slip: Option<Spanned<f64>>,
    }
}

form! {
    tabulated
    /// A term of a derived component.
    DerivedTerm {
        /// The components.
        components: List<Component>;
        /// How they are combined; norm unless given.
        operator: Option<Operator>,
        /// The term counts negative.
        negative: bool,
        /// The components on which the scale factors depend.
        independent: Option<Independent>,
        /// One scale factor for each component, then one value for each independent component. Without rows the factors are 1.
        rows: List<Row>,
    }
}

form! {
    /// A potential: how forces or motions of several components combine.
    Potential {
        /// The contributions.
        terms: List<PotentialTerm>;
        /// How they are combined; sum unless given.
        operator: Option<PotentialOperator>,
        /// β, 2 unless given.
        exponent: Option<Spanned<f64>>,
    }
}

form! {
    /// A contribution sign·H(X/scale − shift)^exponent.
    PotentialTerm {
        /// X: a component or a derived component.
        of: Spanned<Source>;
        /// R, 1 unless given.
        scale: Option<Spanned<f64>>,
        /// α; that of the potential unless given.
        exponent: Option<Spanned<f64>>,
        /// H, abs unless given.
        function: Option<PotentialFunction>,
        /// a, 0 unless given.
        shift: Option<Spanned<f64>>,
        /// 1 or −1; 1 unless given.
        sign: Option<Spanned<f64>>,
    }
}

form! {
    /// Plasticity of a component, or coupled by a potential.
    Plasticity {
        ;
        /// The component.
        component: Option<Spanned<Component>>,
        /// The yield function of a coupled plasticity.
        potential: Option<Spanned<Potential>>,
        /// Hardening.
        hardening: List<Hardening>,
    }
}

form! {
    tabulated
    /// How the yield force grows.
    Hardening {
        /// The rows, with the columns of the definition.
        rows: List<Row>;
        /// Isotropic unless given.
        r#type: Option<HardeningKind>,
        /// Tabular for isotropic and half_cycle for kinematic hardening, unless given.
        definition: Option<HardeningDefinition>,
        /// The filter of the rate.
        rate_filter: Option<Spanned<f64>>,
        /// How the rate is interpolated.
        rate_interpolation: Option<RateInterpolation>,
    }
}

form! {
    tabulated
    /// What begins damage of a component, or of several by a potential.
    Damage {
        /// Force, motion: lower and upper limit. Plastic motion: motion, mode mix, rate. Then temperature, field variables.
        rows: List<Vec<Spanned<Item>>>;
        /// What is compared with the limits; force unless given.
        criterion: Option<DamageCriterion>,
        /// The component.
        component: Option<Spanned<Component>>,
        /// What is compared with the limits of a coupled criterion.
        potential: Option<Spanned<Potential>>,
        /// The number of field variables in the rows.
        dependencies: Option<Spanned<u64>>,
        /// The filter of the rate.
        rate_filter: Option<Spanned<f64>>,
        /// How the rate is interpolated.
        rate_interpolation: Option<RateInterpolation>,
        /// How damage grows.
        evolution: Option<Spanned<DamageEvolution>>,
    }
}

form! {
    tabulated
    /// How damage grows.
    DamageEvolution {
        /// Linear: motion at failure. Exponential: that, and the exponent. Tabular: damage, motion. Energy: energy. Then mode
        /// mix, temperature, field variables.
        rows: List<Vec<Spanned<Item>>>;
        /// Motion unless given.
        r#type: Option<DamageEvolutionKind>,
        /// Linear unless given.
        softening: Option<Softening>,
        /// Maximum unless given.
        degradation: Option<Degradation>,
        /// The components that are damaged; those of the initiation unless given.
        affected: List<Component>,
        /// The motion of a coupled evolution.
        potential: Option<Spanned<Potential>>,
        /// The number of field variables in the rows.
        dependencies: Option<Spanned<u64>>,
    }
}

form! {
    /// Limits of a position; angles in radians.
    Stop {
        /// The component.
        component: Spanned<Component>;
        /// The lower limit.
        lower: Option<Spanned<f64>>,
        /// The upper limit.
        upper: Option<Spanned<f64>>,
    }
}

form! {
    tabulated
    /// What locks or releases components.
    Lock {
        /// The component that triggers.
        component: Spanned<Component>;
        /// The component that is locked or released; all unless given.
        affected: Option<Spanned<Component>>,
        /// When.
        limits: List<Limits>,
    }
}

form! {
    /// Limits of a component; one that is not given does not limit.
    Limits {
        ;
        /// Lower position.
        lower_position: Option<Spanned<f64>>,
        /// Upper position.
        upper_position: Option<Spanned<f64>>,
        /// Lower force or moment.
        lower_force: Option<Spanned<f64>>,
        /// Upper force or moment.
        upper_force: Option<Spanned<f64>>,
        /// The temperature, if the limits depend on it.
        temperature: Option<Spanned<f64>>,
        /// Field variables.
        fields: List<Item>,
    }
}

form! {
    /// A multi-point constraint.
    Mpc {
        /// Its type, such as REVOLUTE.
        r#type: Name,
        /// Its nodes or node sets, the dependent one first.
        nodes: List<Target>;
        /// The type is that of a user subroutine.
        user: bool,
    }
}

form! {
    /// A linear equation: the terms add up to zero.
    Equation {
        /// Its terms.
        terms: List<EquationTerm>;
    }
}

form! {
    /// A factor times a degree of freedom.
    EquationTerm {
        /// The node or node set.
        node: Spanned<Target>,
        /// The degree of freedom, 1 to 6 or 10.
        degree_of_freedom: Spanned<u64>,
        /// The factor.
        factor: Spanned<f64>;
    }
}

form! {
    /// Nodes of a surface.
    SurfaceMember {
        /// The node or node set.
        node: Spanned<Target>;
        /// The area, or weight, of each node; 1 unless given.
        area: Option<Spanned<f64>>,
    }
}

form! {
    /// A rigid body.
    RigidBody {
        /// The reference node.
        reference: Spanned<Target>;
        /// Elements whose nodes belong to it, with their rotations where they have some.
        element_set: Option<Name>,
        /// Nodes that belong to it without their rotations.
        pin_set: Option<Name>,
        /// Nodes that belong to it with their rotations.
        tie_set: Option<Name>,
        /// More of these, one by one: those of elements that are not read.
        nodes: List<Target>,
    }
}

form! {
    /// A coupling, kinematic or distributing.
    Coupling {
        /// Its name.
        name: Name,
        /// The reference node.
        reference: Spanned<Target>,
        /// The surface whose nodes it couples.
        surface: Name;
        /// The axes of its degrees of freedom; the global ones unless given.
        orientation: Option<Name>,
        /// Nodes that are farther from the reference node are left out.
        influence_radius: Option<Spanned<f64>>,
        /// Kinematic: the degrees of freedom in which the reference node carries the others.
        kinematic: List<u64>,
        /// Distributing: how the weights fall off with the distance from the reference node.
        distributing: Option<Weighting>,
    }
}

form! {
    /// A tie between the nodes of two surfaces.
    Tie {
        /// Its name.
        name: Name,
        /// The surface whose nodes are dependent.
        slave: Name,
        /// The surface to whose nodes they are tied.
        master: Name;
        /// Nodes that are farther apart are not tied.
        position_tolerance: Option<Spanned<f64>>,
        /// Do rotations stay free?
        no_rotation: bool,
    }
}

form! {
    /// The mass of MASS elements.
    Mass {
        /// The set of elements.
        element_set: Name,
        /// The mass of each.
        mass: Spanned<f64>;
    }
}

form! {
    /// The inertia of ROTARYI elements.
    RotaryInertia {
        /// The set of elements.
        element_set: Name,
        /// I11, I22, I33, I12, I13, I23.
        inertia: Spanned<[f64; 6]>;
        /// The axes of the inertia; the global ones unless given.
        orientation: Option<Name>,
    }
}

form! {
    /// The stiffness of springs or the coefficient of dashpots.
    Discrete {
        /// The set of elements.
        element_set: Name,
        /// Coefficient, frequency; nonlinear: force, displacement or velocity. Then temperature, field variables.
        rows: List<Vec<Spanned<Item>>>;
        /// The axes in which the degrees of freedom count.
        orientation: Option<Name>,
        /// One degree of freedom for each node; none along the line of two nodes.
        degrees_of_freedom: List<u64>,
        /// The rows are force over displacement or velocity.
        nonlinear: bool,
        /// A complex stiffness; springs only.
        complex: bool,
        /// The number of field variables in the rows.
        dependencies: Option<Spanned<u64>>,
    }
}

form! {
    /// A velocity of nodes at the beginning.
    InitialVelocity {
        /// A node or node set.
        target: Spanned<Target>,
        /// 1 to 6.
        degree_of_freedom: Spanned<u64>,
        /// The velocity, or angular velocity in radians over time.
        magnitude: Spanned<f64>;
    }
}

form! {
    /// Axes at nodes.
    Transform {
        /// The nodes.
        node_set: Name,
        /// The first point.
        a: Spanned<[f64; 3]>,
        /// The second point.
        b: Spanned<[f64; 3]>;
        /// What the points mean; rectangular unless given.
        kind: Option<TransformKind>,
    }
}

form! {
    /// A function of time.
    Amplitude {
        ;
        /// Tabular unless given.
        definition: Option<AmplitudeDefinition>,
        /// The time that counts; that of the step unless given.
        time: Option<AmplitudeTime>,
        /// Factors or values; relative unless given.
        value: Option<AmplitudeValue>,
        /// The fraction of an interval that is smoothed.
        smooth: Option<Spanned<f64>>,
        /// The interval of equally spaced values.
        fixed_interval: Option<Spanned<f64>>,
        /// The time of the first of them.
        begin: Option<Spanned<f64>>,
        /// Tabular, smooth step: pairs of time and value.
        pairs: List<[Spanned<f64>; 2]>,
        /// Other definitions: their numbers.
        data: List<Item>,
    }
}

macro_rules! acting {
    ($(#[$meta:meta])* $name:ident {
        $($(#[$needed_meta:meta])* $needed:ident: $needed_type:ty),*;
        $($(#[$field_meta:meta])* $field:ident: $type:ty),* $(,)?
    }) => {
        form! {
            $(#[$meta])* $name {
                $($(#[$needed_meta])* $needed: $needed_type),*;
                $($(#[$field_meta])* $field: $type,)*
                /// How it changes in time.
                amplitude: Option<Name>,
                /// Modify: those of earlier steps stay, the default; new: they are removed.
                operation: Option<Operation>,
                /// The load case.
                load_case: Option<Spanned<u64>>,
            }
        }
    };
}

acting! {
    /// Prescribed degrees of freedom of nodes.
    Boundary {
        /// A node or node set.
        target: Spanned<Target>,
        /// 1 to 6, or 10 for material flow.
        degrees_of_freedom: List<u64>;
        /// The prescribed value, 0 unless given.
        magnitude: Option<Spanned<f64>>,
        /// What the value is; displacement unless given.
        r#type: Option<MotionType>,
        /// Held where it is at the start of the step.
        fixed: bool,
        /// A user subroutine gives the value.
        user: bool,
    }
}

acting! {
    /// A prescribed component of connectors.
    ConnectorMotion {
        /// A connector or a set of connectors.
        target: Spanned<Target>,
        /// The component.
        component: Spanned<Component>;
        /// The prescribed value from the initial state, rotations in radians; held fixed unless given.
        magnitude: Option<Spanned<f64>>,
        /// What the value is; displacement unless given.
        r#type: Option<MotionType>,
        /// Held where it is at the start of the step.
        fixed: bool,
        /// A user subroutine gives the value.
        user: bool,
        /// The imaginary part of a harmonic value.
        imaginary: bool,
    }
}

acting! {
    /// A force or moment in the current direction of a component.
    ConnectorLoad {
        /// A connector or a set of connectors.
        target: Spanned<Target>,
        /// The component.
        component: Spanned<Component>,
        /// The load; positive drives the component in its positive sense.
        magnitude: Spanned<f64>;
        /// The imaginary part of a harmonic value.
        imaginary: bool,
    }
}

acting! {
    /// A force, moment or flow force at nodes.
    ConcentratedLoad {
        /// A node or node set.
        target: Spanned<Target>,
        /// 1 to 6, or 10 for material flow.
        degree_of_freedom: Spanned<u64>,
        /// Force, moment or flow force.
        magnitude: Spanned<f64>;
        /// It rotates with the node.
        follower: bool,
        /// The imaginary part of a harmonic value.
        imaginary: bool,
    }
}

acting! {
    /// A load on elements.
    DistributedLoad {
        /// Its label, such as GRAV.
        label: Name;
        /// An element or element set; the whole model unless given.
        target: Option<Spanned<Target>>,
        /// The magnitude, and for GRAV the direction x, y, z.
        values: List<Item>,
        /// It rotates with the element.
        follower: bool,
        /// The imaginary part of a harmonic value.
        imaginary: bool,
    }
}

form! {
    /// A step of the analysis.
    Step {
        ;
        /// Its name.
        name: Option<Name>,
        /// Is it geometrically nonlinear?
        nlgeom: Option<bool>,
        /// Is it a linear perturbation?
        perturbation: bool,
        /// The largest number of increments.
        increments: Option<Spanned<u64>>,
        /// How what has no amplitude of its own changes.
        default_amplitude: Option<DefaultAmplitude>,
        /// static, dynamic, dynamic_explicit, or the keyword of another procedure, whose data are not kept.
        procedure: Option<Name>,
        /// Times of a static or dynamic step.
        times: Option<Spanned<Times>>,
        /// Kinds of which those of earlier steps are removed; a condition whose operation is `new` says the same of its own kind.
        removed: List<ConditionKind>,
        /// Boundary conditions.
        boundaries: List<Boundary>,
        /// Concentrated loads.
        concentrated_loads: List<ConcentratedLoad>,
        /// Distributed loads.
        distributed_loads: List<DistributedLoad>,
        /// Connector motions.
        connector_motions: List<ConnectorMotion>,
        /// Connector loads.
        connector_loads: List<ConnectorLoad>,
        /// Output requests.
        outputs: List<OutputRequest>,
    }
}

form! {
    /// Times of a step.
    Times {
        ;
        /// The first increment.
        initial: Option<Spanned<f64>>,
        /// The length of the step.
        total: Option<Spanned<f64>>,
        /// The smallest increment.
        minimum: Option<Spanned<f64>>,
        /// The largest increment.
        maximum: Option<Spanned<f64>>,
    }
}

form! {
    /// What an analysis writes.
    OutputRequest {
        /// OUTPUT, ELEMENT OUTPUT, NODE OUTPUT, ENERGY OUTPUT, INCREMENTATION OUTPUT or CONTACT OUTPUT.
        keyword: Name;
        /// The elements.
        element_set: Option<Name>,
        /// The nodes.
        node_set: Option<Name>,
        /// Other parameters by name: a text, or true for one without a value.
        parameters: Entries<Spanned<Parameter>>,
        /// Identifiers, such as CTF.
        variables: Vec<Name>,
    }
}

form! {
    /// The numbers first, first + step … up to last. Those that do not exist are left out.
    Range {
        /// The first number.
        first: Spanned<u64>,
        /// The last number.
        last: Spanned<u64>;
        /// The distance, 1 unless given.
        step: Option<Spanned<u64>>,
    }
}

form! {
    /// A row that depends on temperature or field variables.
    FullRow {
        /// The columns.
        values: List<Item>;
        /// The temperature.
        temperature: Option<Spanned<f64>>,
        /// Field variables.
        fields: List<Item>,
    }
}
