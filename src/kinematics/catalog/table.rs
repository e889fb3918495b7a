//! The table of connection types, in the order of `pintle list`.

use crate::catalog::Availability::{Always, ExplicitOnly, Never, StandardOnly};
use crate::catalog::Condition::{Held, Zero, ZeroOrHeld};
use crate::catalog::Evidence::{D, P, S};
use crate::catalog::Loading::{AlongA, Conjugate, FrozenAxis, Tension};
use crate::catalog::Orientation::{Ignored, Optional, Required};
use crate::catalog::Slot::{Absent, Available, Constrained, Measured};
use crate::catalog::friction;
use crate::catalog::{Class, ConnectionType, Evidence, Half, Orientation, OrientationRule, PrintedMoment};
use crate::measure::Measure::{
    Cardan, ComponentFlexion, Cosine, Distance, Euler, Flexion, Flow, FlowConversion, Misalignment, Position,
    PositionAtB, ProjectedPosition, RadialDistance, RotationVector, RotationVectorAtB, Strain, Sweep,
    Torsion,
};
use std::borrow::Cow;

const fn rule(orientation: Orientation, evidence: Evidence) -> OrientationRule {
    OrientationRule { orientation, evidence }
}

const TRANSLATIONAL: Half = Half {
    name: "",
    class: Class::BasicTranslational,
    slots: [Absent; 3],
    loading: [Conjugate; 3],
    printed: None,
    orientation: [rule(Required, D), rule(Ignored, D)],
    planar: Always,
    availability: Always,
    in_standard: None,
    forces: "",
    friction: None,
    activates_rotations: true,
    stops: true,
    source: "",
    note: "",
};

const ROTATIONAL: Half = Half {
    class: Class::BasicRotational,
    orientation: [rule(Required, D), rule(Optional, D)],
    planar: Never,
    ..TRANSLATIONAL
};

static ACCELEROMETER: Half = Half {
    name: "ACCELEROMETER",
    slots: [Measured(PositionAtB(1)), Measured(PositionAtB(2)), Measured(PositionAtB(3))],
    orientation: [rule(Optional, P), rule(Optional, P)],
    planar: Never,
    availability: ExplicitOnly,
    in_standard: Some(&CARTESIAN),
    forces: "none",
    stops: false,
    source: "connection type ACCELEROMETER, Description (our reading)",
    note: "Output only: v_i = (v_b − v_a)·eib, a_i = (a_b − a_a)·eib, which are not time derivatives of u_i. In a Standard analysis \
           it is CARTESIAN.",
    ..TRANSLATIONAL
};

static AXIAL: Half = Half {
    name: "AXIAL",
    slots: [Available(Distance), Absent, Absent],
    orientation: [rule(Optional, D), rule(Optional, D)],
    activates_rotations: false,
    forces: "f = f1 q, q = d/|d|",
    source: "connection type AXIAL, Description and Summary",
    note: "While the nodes coincide, the direction e1 of the orientation at a (else at b), fixed in space, stands in for q.",
    ..TRANSLATIONAL
};

static CARTESIAN: Half = Half {
    name: "CARTESIAN",
    slots: [Available(Position(1)), Available(Position(2)), Available(Position(3))],
    orientation: [rule(Optional, D), rule(Ignored, D)],
    forces: "f = f1 e1a + f2 e2a + f3 e3a",
    source: "connection type CARTESIAN, Description and Summary",
    ..TRANSLATIONAL
};

static JOIN: Half = Half {
    name: "JOIN",
    slots: [Constrained(Position(1), Held), Constrained(Position(2), Held), Constrained(Position(3), Held)],
    orientation: [rule(Optional, D), rule(Ignored, D)],
    activates_rotations: false,
    forces: "f = f1 e1a + f2 e2a + f3 e3a",
    source: "connection type JOIN, Description and Summary",
    note: "Nodes that do not coincide initially keep the coordinates of b in the frame of a.",
    ..TRANSLATIONAL
};

static LINK: Half = Half {
    name: "LINK",
    slots: [Constrained(Distance, Held), Absent, Absent],
    orientation: [rule(Ignored, P), rule(Ignored, P)],
    activates_rotations: false,
    forces: "f = f1 q, q = d/|d|",
    stops: false,
    source: "connection type components, LINK (one line); the rest ours",
    note: "Needs a length: nodes that coincide initially have no direction to hold.",
    ..TRANSLATIONAL
};

static PROJECTION_CARTESIAN: Half = Half {
    name: "PROJECTION CARTESIAN",
    slots: [
        Available(ProjectedPosition(1)),
        Available(ProjectedPosition(2)),
        Available(ProjectedPosition(3)),
    ],
    orientation: [rule(Required, P), rule(Optional, P)],
    forces: "f = f1 e1 + f2 e2 + f3 e3",
    source: "connection type PROJECTION CARTESIAN, Description (our reading)",
    note: "The directions e1, e2, e3 lie midway between those of a and b; forces load the rotations of both nodes.",
    ..TRANSLATIONAL
};

static RADIAL_THRUST: Half = Half {
    name: "RADIAL-THRUST",
    slots: [Available(RadialDistance), Absent, Available(Position(3))],
    orientation: [rule(Required, D), rule(Ignored, P)],
    planar: Never,
    forces: "f = f1 er + f3 e3a, er = ((e1a·d) e1a + (e2a·d) e2a)/r",
    source: "connection type RADIAL-THRUST, Description and Summary",
    note: "A single radial spring: nothing holds b tangentially but f1/r.",
    ..TRANSLATIONAL
};

static SLIDE_PLANE: Half = Half {
    name: "SLIDE-PLANE",
    slots: [Constrained(Position(1), Held), Available(Position(2)), Available(Position(3))],
    planar: Never,
    forces: "f = f1 e1a, f_s-p = f2 e2a + f3 e3a",
    friction: Some(friction::SLIDE_PLANE),
    source: "connection type SLIDE-PLANE, Description and Friction; summary in the Analysis Guide 31.1.5",
    ..TRANSLATIONAL
};

static SLOT: Half = Half {
    name: "SLOT",
    slots: [Available(Position(1)), Constrained(Position(2), Held), Constrained(Position(3), Held)],
    forces: "f = f2 e2a + f3 e3a, f_slot = f1 e1a",
    friction: Some(friction::SLOT),
    source: "connection type SLOT, Description and Summary",
    ..TRANSLATIONAL
};

static ALIGN: Half = Half {
    name: "ALIGN",
    slots: [
        Constrained(Cardan(1), Zero(Misalignment(1))),
        Constrained(Cardan(2), Zero(Misalignment(2))),
        Constrained(Cardan(3), Zero(Misalignment(3))),
    ],
    loading: [FrozenAxis(1), FrozenAxis(2), FrozenAxis(3)],
    printed: Some((PrintedMoment::AlongA, D)),
    orientation: [rule(Optional, D), rule(Optional, D)],
    planar: Always,
    forces: "m = m1 e1a + m2 e2a + m3 e3a",
    stops: false,
    source: "connection type ALIGN, Description and Summary",
    note: "Directions that do not coincide initially keep their relative orientation; the position output is its Cardan angles. Of such, \
           m1, m2, m3 are the components of the moment M on b along axes that a carries: M·e1a, M·(cos α e2a + sin α e3a), M·e, with the \
           initial α and e3b = e initially; a unit moment of one has no component along the two others (our reading).",
    ..ROTATIONAL
};

static CARDAN: Half = Half {
    name: "CARDAN",
    slots: [Available(Cardan(1)), Available(Cardan(2)), Available(Cardan(3))],
    orientation: [rule(Required, P), rule(Optional, P)],
    forces: "m1 = M·e1a, m2 = M·(cos α e2a + sin α e3a), m3 = M·e3b",
    source: "connection type CARDAN, Description",
    note: "Locks at β = ±π/2: give the stiffest rotation to component 5.",
    ..ROTATIONAL
};

static CONSTANT_VELOCITY: Half = Half {
    name: "CONSTANT VELOCITY",
    slots: [Absent, Constrained(Torsion, Held), Absent],
    forces: "m = m2 (e3a + e3b)/(1 + e3a·e3b)",
    stops: false,
    source: "connection type CONSTANT VELOCITY, Description (our reading)",
    note: "The shafts are e3a and e3b. The printed angle B is −β: it stays constant.",
    ..ROTATIONAL
};

static EULER: Half = Half {
    name: "EULER",
    slots: [Available(Euler(1)), Available(Euler(2)), Available(Euler(3))],
    orientation: [rule(Required, P), rule(Optional, P)],
    forces: "m1 = M·e3a, m2 = M·(cos α e1a + sin α e2a), m3 = M·e3b",
    source: "connection type EULER, Description; β = ± acos(e3a·e3b) + 2jπ where the page prints + jπ (our reading)",
    note: "Locks where e3a and e3b are parallel: give b an orientation of its own.",
    ..ROTATIONAL
};

static FLEXION_TORSION: Half = Half {
    name: "FLEXION-TORSION",
    slots: [Available(Flexion), Available(Torsion), Available(Sweep)],
    orientation: [rule(Required, P), rule(Optional, P)],
    forces: "m = m1 q + m2 (e3a + e3b)/(1 + c) + m3 (e3a − c e3b)/sin²α, c = e3a·e3b",
    source: "connection type FLEXION-TORSION, Description; formulas ours",
    note: "The sweep is meant as an independent variable of the behaviour: it does not exist without flexion.",
    ..ROTATIONAL
};

static FLOW_CONVERTER: Half = Half {
    name: "FLOW-CONVERTER",
    class: Class::SpecialisedRotational,
    slots: [Absent, Absent, Constrained(FlowConversion, Zero(FlowConversion))],
    orientation: [rule(Required, S), rule(Ignored, S)],
    planar: StandardOnly,
    forces: "m3: moment m3 e3a on a, −m3 e3a on b, flow force −βs m3 at b",
    stops: false,
    source: "connection type FLOW-CONVERTER, Description; RETRACTOR, Summary (our reading)",
    note: "Positive from a minus b, opposite to every other rotation; degree of freedom 10 at b must be restrained.",
    ..ROTATIONAL
};

static PROJECTION_FLEXION_TORSION: Half = Half {
    name: "PROJECTION FLEXION-TORSION",
    slots: [Available(ComponentFlexion(1)), Available(ComponentFlexion(2)), Available(Torsion)],
    printed: Some((PrintedMoment::Midway, P)),
    forces: "for moderate flexion m = m1 e1 + m2 e2 + m3 e3",
    source: "connection type PROJECTION FLEXION-TORSION, Description; formulas ours",
    note: "Regular without flexion, unlike FLEXION-TORSION; the directions e1, e2, e3 lie midway between those of a and b.",
    ..ROTATIONAL
};

static REVOLUTE: Half = Half {
    name: "REVOLUTE",
    slots: [
        Available(Cardan(1)),
        Constrained(Cardan(2), ZeroOrHeld(Cosine(1, 3))),
        Constrained(Cardan(3), ZeroOrHeld(Cosine(1, 2))),
    ],
    loading: [Conjugate, AlongA(2), AlongA(3)],
    printed: Some((PrintedMoment::AlongA, S)),
    orientation: [rule(Required, S), rule(Optional, S)],
    forces: "m = m2 e2a + m3 e3a, m_revolute = m1 e1a",
    source: "connection type REVOLUTE, Description and Summary (our reading)",
    note: "Axes that do not align initially keep their second and third Cardan angles.",
    ..ROTATIONAL
};

static ROTATION: Half = Half {
    name: "ROTATION",
    slots: [Available(RotationVector(1)), Available(RotationVector(2)), Available(RotationVector(3))],
    printed: Some((PrintedMoment::AlongA, S)),
    orientation: [rule(Optional, S), rule(Optional, S)],
    planar: Always,
    forces: "m_i = M·eia as printed; work-conjugate: M = A H⁻ᵀ m (our reading)",
    source: "connection type ROTATION, Description and Summary (our reading)",
    note: "Not suited to behaviour at finite three-dimensional rotation: CARDAN or EULER are.",
    ..ROTATIONAL
};

static ROTATION_ACCELEROMETER: Half = Half {
    name: "ROTATION-ACCELEROMETER",
    slots: [Measured(RotationVectorAtB(1)), Measured(RotationVectorAtB(2)), Measured(RotationVectorAtB(3))],
    orientation: [rule(Optional, S), rule(Optional, S)],
    availability: ExplicitOnly,
    forces: "none",
    stops: false,
    source: "connection type ROTATION-ACCELEROMETER, Description and Summary (our reading)",
    note: "Output only: vr_i = (ω_b − ω_a)·eib, ar_i = (α_b − α_a)·eib, which are not time derivatives of ur_i.",
    ..ROTATIONAL
};

static UNIVERSAL: Half = Half {
    name: "UNIVERSAL",
    slots: [Available(Cardan(1)), Constrained(Cardan(2), ZeroOrHeld(Cosine(1, 3))), Available(Cardan(3))],
    printed: Some((PrintedMoment::CardanAxes, D)),
    forces: "m = m2 (cos α e2a + sin α e3a), m_universal = m1 e1a + m3 e3b",
    source: "connection type UNIVERSAL, Description and Summary (our reading)",
    note: "The shafts are e2a and e2b. A second Cardan angle that is not zero initially is kept.",
    ..ROTATIONAL
};

/// Every connection type: basic translational, basic rotational, assembled, complex; alphabetical within each.
pub static TABLE: &[ConnectionType] = &[
    ConnectionType::basic(&ACCELEROMETER),
    ConnectionType::basic(&AXIAL),
    ConnectionType::basic(&CARTESIAN),
    ConnectionType::basic(&JOIN),
    ConnectionType::basic(&LINK),
    ConnectionType::basic(&PROJECTION_CARTESIAN),
    ConnectionType::basic(&RADIAL_THRUST),
    ConnectionType::basic(&SLIDE_PLANE),
    ConnectionType::basic(&SLOT),
    ConnectionType::basic(&ALIGN),
    ConnectionType::basic(&CARDAN),
    ConnectionType::basic(&CONSTANT_VELOCITY),
    ConnectionType::basic(&EULER),
    ConnectionType::basic(&FLEXION_TORSION),
    ConnectionType::basic(&FLOW_CONVERTER),
    ConnectionType::basic(&PROJECTION_FLEXION_TORSION),
    ConnectionType::basic(&REVOLUTE),
    ConnectionType::basic(&ROTATION),
    ConnectionType::basic(&ROTATION_ACCELEROMETER),
    ConnectionType::basic(&UNIVERSAL),
    ConnectionType::assembled("BEAM", &JOIN, &ALIGN, None, "connection type BEAM"),
    ConnectionType::assembled(
        "BUSHING",
        &PROJECTION_CARTESIAN,
        &PROJECTION_FLEXION_TORSION,
        None,
        "connection type BUSHING, Description and Summary",
    ),
    ConnectionType::assembled("CVJOINT", &JOIN, &CONSTANT_VELOCITY, None, "connection type CVJOINT"),
    ConnectionType::assembled(
        "CYLINDRICAL",
        &SLOT,
        &REVOLUTE,
        Some(friction::CYLINDRICAL),
        "connection type CYLINDRICAL",
    ),
    ConnectionType::assembled("HINGE", &JOIN, &REVOLUTE, Some(friction::HINGE), "connection type HINGE"),
    ConnectionType::assembled(
        "PLANAR",
        &SLIDE_PLANE,
        &REVOLUTE,
        Some(friction::PLANAR),
        "connection type PLANAR (second friction criterion: our reading)",
    ),
    ConnectionType::assembled(
        "RETRACTOR",
        &JOIN,
        &FLOW_CONVERTER,
        None,
        "connection type RETRACTOR, Summary",
    ),
    ConnectionType::assembled(
        "TRANSLATOR",
        &SLOT,
        &ALIGN,
        Some(friction::TRANSLATOR),
        "connection type TRANSLATOR, Friction and Summary (our reading)",
    ),
    ConnectionType::assembled(
        "UJOINT",
        &JOIN,
        &UNIVERSAL,
        Some(friction::UJOINT),
        "connection type UJOINT (friction: our reading)",
    ),
    ConnectionType::assembled("WELD", &JOIN, &ALIGN, None, "connection type components, WELD"),
    ConnectionType {
        name: Cow::Borrowed("SLIPRING"),
        class: Class::Complex,
        halves: [None, None],
        slots: [Available(Strain), Available(Flow(2)), Measured(Flow(1)), Absent, Absent, Absent],
        loading: [Tension, Conjugate, Conjugate, Conjugate, Conjugate, Conjugate],
        printed: None,
        orientation: [rule(Ignored, P), rule(Ignored, P)],
        planar: StandardOnly,
        availability: Always,
        forces: ["f = f1 q, q = d/|d|; flow forces −f1 at a, +f1 at b", ""],
        friction: Some(friction::SLIPRING),
        stops: false,
        flow: [true, true],
        rotations: [false, false],
        source: ["connection type SLIPRING, Description (our reading: strain = λ − 1)", ""],
        notes: ["Ψa > 0 where material enters the segment, Ψb > 0 where it leaves it.", ""],
    },
];
