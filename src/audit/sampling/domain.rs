//! The domain of a connection type, as its slots tell it: which initial orientations satisfy the printed constraints, and
//! about which axis b may turn against a without end.

use pintle_kinematics::catalog::{Class, Condition, ConnectionType, Slot, TABLE};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::so3::{self, exp};
use pintle_kinematics::vector::{self, Matrix, Vector, column, product};

/// Every entry of the table and every free pair of a translational and a rotational type.
pub fn types() -> Vec<ConnectionType> {
    let mut found = TABLE.to_vec();
    let of = |wanted: fn(Class) -> bool| TABLE.iter().filter(move |entry| wanted(entry.class));
    for t in of(|class| class == Class::BasicTranslational) {
        for r in of(|class| matches!(class, Class::BasicRotational | Class::SpecialisedRotational)) {
            let pair = ConnectionType::named(&t.name, Some(&r.name));
            found.extend(pair.ok().filter(|pair| !is_in_table(pair)));
        }
    }
    found
}

/// Whether the type is an entry of the table, rather than a free pair.
pub fn is_in_table(connection: &ConnectionType) -> bool {
    TABLE.iter().any(|entry| entry.name == connection.name)
}

/// The rotational measure of a type, which decides its domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turning {
    /// Angles of Rx Ry Rz, none held.
    Cardan,
    /// As `Cardan`, with e1a·e3b = 0.
    Universal,
    /// As `Cardan`, with e1a = e1b.
    Revolute,
    /// No rotation at all.
    Align,
    /// Angles of Rz Rx Rz.
    Euler,
    /// The rotation vector.
    RotationVector,
    /// Angles of Rz Ry Rz: flexion, torsion and sweep, or the directions midway between a and b.
    Torsion,
    /// The one-form of FLOW-CONVERTER.
    Flow,
    /// No rotational measure.
    None,
}

/// How a type turns.
pub fn turning(connection: &ConnectionType) -> Turning {
    let printed = |wanted: Measure| {
        connection.slots.iter().any(|slot| match slot {
            Slot::Constrained(_, Condition::Zero(m) | Condition::ZeroOrHeld(m)) => *m == wanted,
            _ => false,
        })
    };
    let position = |wanted: fn(Measure) -> bool| connection.positions().any(wanted);
    if printed(Measure::Misalignment(1)) {
        Turning::Align
    } else if printed(Measure::Cosine(1, 2)) {
        Turning::Revolute
    } else if printed(Measure::Cosine(1, 3)) {
        Turning::Universal
    } else if position(|m| matches!(m, Measure::Cardan(_))) {
        Turning::Cardan
    } else if position(|m| matches!(m, Measure::Euler(_))) {
        Turning::Euler
    } else if position(|m| matches!(m, Measure::RotationVector(_) | Measure::RotationVectorAtB(_))) {
        Turning::RotationVector
    } else if position(|m| m == Measure::Torsion || m.counts_torsion()) {
        Turning::Torsion
    } else if position(Measure::is_one_form) {
        Turning::Flow
    } else {
        Turning::None
    }
}

/// Whether the type measures a length that has no derivative where the nodes coincide, and so needs nodes apart.
pub fn needs_length(connection: &ConnectionType) -> bool {
    connection.positions().any(|m| m.singular_set().is_some_and(|set| set.unit == Unit::Length))
}

/// Whether turning b far against a, in the way that the type's rotations ask for, leads through e3b = −e3a. Its directions midway
/// between a and b do not exist there: PROJECTION CARTESIAN beside a joint that does not turn about e3.
pub(super) fn turns_shafts_over(connection: &ConnectionType) -> bool {
    connection.positions().any(Measure::counts_torsion)
        && !matches!(turning(connection), Turning::Torsion | Turning::Euler | Turning::Flow)
}

/// Whether the type measures an angle that does not exist, or has no derivative, where e3a and e3b are parallel.
pub(super) fn needs_tilt(connection: &ConnectionType) -> bool {
    connection.positions().any(|m| matches!(m, Measure::Euler(_) | Measure::Flexion | Measure::Sweep))
}

/// Rx(angle).
pub fn about_1(angle: f64) -> Matrix<f64> {
    exp([angle, 0.0, 0.0])
}

/// Rz(angle).
pub fn about_3(angle: f64) -> Matrix<f64> {
    exp([0.0, 0.0, angle])
}

/// An initial Q₀ at which the printed constraints of the type hold.
pub fn aligned(connection: &ConnectionType, draw: &mut Draw) -> Matrix<f64> {
    let (x, y) = (draw.between(-0.7, 0.7), draw.between(-0.7, 0.7));
    match turning(connection) {
        Turning::Align => vector::identity(),
        Turning::Revolute => about_1(x),
        Turning::Universal => product(&about_1(x), &about_3(y)),
        Turning::Euler | Turning::Torsion if needs_tilt(connection) => {
            let tilt = about_1(draw.between(0.7, 1.4));
            product(&product(&about_3(x), &tilt), &about_3(y))
        }
        _ => exp(draw.rotation(0.1, 0.6)),
    }
}

/// An initial Q₀ at which the printed constraints do not hold.
pub(super) fn misaligned(connection: &ConnectionType, draw: &mut Draw) -> Matrix<f64> {
    let start = aligned(connection, draw);
    product(&exp(draw.rotation(0.2, 0.4)), &start)
}

/// The axis, in the initial global frame, about which b can turn against a without meeting a singular set on the way.
pub fn spin_axis(connection: &ConnectionType, a0: &Matrix<f64>, draw: &mut Draw) -> Vector<f64> {
    match turning(connection) {
        Turning::Cardan | Turning::Universal | Turning::Revolute => column(a0, 0),
        Turning::Euler | Turning::Torsion | Turning::Flow => column(a0, 2),
        Turning::Align | Turning::RotationVector | Turning::None => draw.direction(),
    }
}

/// The angle that winds, or is principal, at Q₀ about [`spin_axis`].
pub(super) fn angle_at_start(connection: &ConnectionType, q0: &Matrix<f64>) -> f64 {
    match turning(connection) {
        Turning::Cardan | Turning::Universal | Turning::Revolute => so3::cardan_first(q0),
        Turning::Euler => so3::euler_angle(q0, 1.0, 1),
        Turning::Torsion => so3::torsion(q0),
        _ => 0.0,
    }
}
