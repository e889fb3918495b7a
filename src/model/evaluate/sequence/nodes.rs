//! Where nodes are at a state, and how they turned since the one before.

use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::so3::Quaternion;
use pintle_kinematics::vector::{Matrix, Vector, identity, sub};
use pintle_scene::{NodeMotion, Rotation};
use serde::{Deserialize, Serialize};

/// A node at one state, its rotation worked out once for all connectors that share it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved {
    pub(crate) displacement: Vector<f64>,
    pub(crate) rotation: Matrix<f64>,
    pub(crate) flow: f64,
    pub(crate) rates: [f64; 7],
    pub(crate) accelerations: [f64; 7],
    /// Since the previous state.
    pub(crate) change: Vector<f64>,
    pub(crate) whole_turns: Vector<f64>,
    pub(super) flow_change: f64,
    /// Component 3 of the rotation as given: degree of freedom 6.
    pub(crate) sixth: Option<f64>,
    /// The total rotation vector, with its turns.
    pub(crate) vector: Vector<f64>,
}

impl Moved {
    /// The ground.
    pub(crate) const fn still() -> Self {
        STILL
    }
}

/// The ground.
pub(super) const STILL: Moved = Moved {
    displacement: [0.0; 3],
    rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    flow: 0.0,
    rates: [0.0; 7],
    accelerations: [0.0; 7],
    change: [0.0; 3],
    whole_turns: [0.0; 3],
    flow_change: 0.0,
    sixth: None,
    vector: [0.0; 3],
};

/// How a node was rotated at the last state: enough to form the increment to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Orientation {
    quaternion: Quaternion<f64>,
    /// The total rotation vector: as given, or that of a quaternion continued from the state before.
    vector: Vector<f64>,
    flow: f64,
}

pub(super) const UNTURNED: Orientation =
    Orientation { quaternion: [1.0, 0.0, 0.0, 0.0], vector: [0.0; 3], flow: 0.0 };

/// Translational, rotational and flow rates of a node, in one.
const fn rates([x1, x2, x3]: Vector<f64>, [r1, r2, r3]: Vector<f64>, flow: f64) -> [f64; 7] {
    [x1, x2, x3, r1, r2, r3, flow]
}

/// Whether a node is turned by nothing, and no turns are to be remembered.
pub(super) fn is_unturned(orientation: &Orientation) -> bool {
    orientation.quaternion == UNTURNED.quaternion && orientation.vector == UNTURNED.vector
}

/// A node at its next state: rotation matrix, and increments since the last one.
///
/// The increment is the rotation vector of C(new) C(old)ᵀ. It is principal, unless one of the two states gave a rotation
/// vector beyond half a turn: those keep their turns, and the increment then continues their difference. Vectors that are
/// wrapped at half a turn stay principal where π was rounded up: both within 0.001 rad of half a turn or less, and more than
/// 3π/2 apart. Of a node whose turning is not `followed` there is no increment.
pub(super) fn follow(
    motion: &NodeMotion,
    before: &Orientation,
    given: bool,
    followed: bool,
) -> (Moved, Orientation) {
    if motion.rotation == Rotation::default() && is_unturned(before) {
        let node = Moved {
            displacement: motion.displacement,
            flow: motion.flow,
            rates: rates(motion.velocity, motion.angular_velocity, motion.flow_velocity),
            accelerations: rates(motion.acceleration, motion.angular_acceleration, motion.flow_acceleration),
            flow_change: motion.flow - before.flow,
            sixth: given.then_some(0.0),
            ..STILL
        };
        return (node, Orientation { flow: motion.flow, ..UNTURNED });
    }
    let quaternion = match motion.rotation {
        Rotation::Vector(phi) => so3::exp(phi),
        Rotation::Quaternion(q) => so3::normalize(q),
    };
    let still = [0.0; 3];
    let relative = so3::compose(quaternion, so3::conjugate(before.quaternion));
    let principal = if followed { so3::log_quaternion(relative) } else { still };
    let (vector, change) = match motion.rotation {
        Rotation::Vector(new) if !followed => (new, still),
        Rotation::Vector(new) if keep_turns(new, before.vector) => {
            (new, so3::continuous_log_quaternion(relative, sub(new, before.vector)).phi)
        }
        Rotation::Vector(new) => (new, principal),
        Rotation::Quaternion(_) => (so3::continuous_log_quaternion(quaternion, before.vector).phi, principal),
    };
    let rotation = match motion.rotation {
        Rotation::Vector([0.0, 0.0, 0.0]) => identity(),
        _ => so3::matrix(quaternion),
    };
    let node = Moved {
        displacement: motion.displacement,
        rotation,
        flow: motion.flow,
        rates: rates(motion.velocity, motion.angular_velocity, motion.flow_velocity),
        accelerations: rates(motion.acceleration, motion.angular_acceleration, motion.flow_acceleration),
        change,
        whole_turns: sub(change, principal),
        flow_change: motion.flow - before.flow,
        sixth: match motion.rotation {
            Rotation::Vector(phi) if given => Some(phi[2]),
            _ => None,
        },
        vector,
    };
    (node, Orientation { quaternion, vector, flow: motion.flow })
}

/// Whether turns of two consecutive rotation vectors count: one is beyond half a turn, and not by the rounding of π only.
fn keep_turns(new: Vector<f64>, old: Vector<f64>) -> bool {
    use std::f64::consts::PI;
    const ROUNDED_UP: f64 = 1e-3;
    let longest = norm(new).max(norm(old));
    longest > PI && (longest > PI + ROUNDED_UP || norm(sub(new, old)) < 1.5 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rotation about the axis 1 that a node has made after states that give it as rotation vectors.
    fn turned(angles: &[f64]) -> f64 {
        let mut before = UNTURNED;
        let mut sum = 0.0;
        for angle in angles {
            let motion =
                NodeMotion { rotation: Rotation::Vector([*angle, 0.0, 0.0]), ..NodeMotion::default() };
            let (node, after) = follow(&motion, &before, true, true);
            sum += node.change[0];
            before = after;
        }
        sum
    }

    /// Turns survive a change from quaternions to rotation vectors.
    #[test]
    fn quaternions_and_vectors_mix() {
        let quaternion = |angle: f64| Rotation::Quaternion(so3::exp([angle, 0.0, 0.0]));
        let mut before = UNTURNED;
        let mut sum = 0.0;
        for rotation in
            [quaternion(0.3), Rotation::Vector([20.6, 0.0, 0.0]), quaternion(22.0), quaternion(24.0)]
        {
            let (node, after) =
                follow(&NodeMotion { rotation, ..NodeMotion::default() }, &before, true, true);
            sum += node.change[0];
            before = after;
        }
        assert!((sum - 24.0).abs() < 1e-13, "{sum}");
        assert!((before.vector[0] - 24.0).abs() < 1e-13, "{:?}", before.vector);
    }

    #[test]
    fn vectors_keep_their_turns_or_are_wrapped() {
        let tau = std::f64::consts::TAU;
        let is =
            |angles: &[f64], expected: f64| assert!((turned(angles) - expected).abs() < 1e-12, "{angles:?}");
        is(&[3.0, 3.2, 7.0, 3000.0, 2.0], 2.0);
        is(&[3.0, 4.0, -4.0], -4.0);
        is(&[3.0, -3.0, -0.5], tau - 0.5);
        // Half a turn, as a file has it that rounds π up.
        let half = std::f64::consts::PI + 7e-6;
        is(&[half], half);
        is(&[3.0, half, 3.3], 3.3);
        is(&[3.0, half, -3.0], tau - 3.0);
        is(&[-3.0, half, 3.0], 3.0 - tau);
    }
}
