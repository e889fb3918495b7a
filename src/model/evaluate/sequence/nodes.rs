//! Where nodes are at a state, and how they turned since the one before.

use pintle_kinematics::connector::Flag;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::so3::Quaternion;
use pintle_kinematics::vector::{Matrix, Vector, cross, dot, identity, scale, sub};
use pintle_scene::{NodeMotion, Rotation};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4, PI, TAU};

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
    /// The angle of another increment that fits the two states as well (rad).
    pub(crate) other_turn: Option<f64>,
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
pub(in crate::evaluate) const STILL: Moved = Moved {
    displacement: [0.0; 3],
    rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    flow: 0.0,
    rates: [0.0; 7],
    accelerations: [0.0; 7],
    change: [0.0; 3],
    whole_turns: [0.0; 3],
    other_turn: None,
    flow_change: 0.0,
    sixth: None,
    vector: [0.0; 3],
};

/// How a node was rotated at the last state: enough to form the increment to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::evaluate) struct Orientation {
    quaternion: Quaternion<f64>,
    /// The total rotation vector: as given, or that of a quaternion continued from the state before.
    vector: Vector<f64>,
    /// The quaternion is exp of the vector; else it may be the negative of that.
    is_of_vector: bool,
    flow: f64,
}

pub(in crate::evaluate) const UNTURNED: Orientation =
    Orientation { quaternion: [1.0, 0.0, 0.0, 0.0], vector: [0.0; 3], is_of_vector: true, flow: 0.0 };

/// Translational, rotational and flow rates of a node, in one.
const fn rates([x1, x2, x3]: Vector<f64>, [r1, r2, r3]: Vector<f64>, flow: f64) -> [f64; 7] {
    [x1, x2, x3, r1, r2, r3, flow]
}

/// Whether a node is turned by nothing, and no turns are to be remembered.
pub(super) fn is_unturned(orientation: &Orientation) -> bool {
    orientation.quaternion == UNTURNED.quaternion && orientation.vector == UNTURNED.vector
}

impl Moved {
    /// Brings a node to its next state: rotation matrix, and increments since the last one, which [`increment`] tells.
    ///
    /// Of a node whose turning is not `followed` there is no increment. At the `first` state the one before is the initial one.
    pub(in crate::evaluate) fn follow(
        &mut self,
        motion: &NodeMotion,
        orientation: &mut Orientation,
        given: bool,
        followed: bool,
        first: bool,
    ) {
        self.displacement = motion.displacement;
        self.rates = rates(motion.velocity, motion.angular_velocity, motion.flow_velocity);
        self.accelerations =
            rates(motion.acceleration, motion.angular_acceleration, motion.flow_acceleration);
        self.flow_change = motion.flow - orientation.flow;
        self.flow = motion.flow;
        orientation.flow = motion.flow;
        self.sixth = match motion.rotation {
            Rotation::Vector(phi) if given => Some(phi[2]),
            _ => None,
        };
        if motion.rotation == Rotation::default() && is_unturned(orientation) {
            self.rotation = identity();
            self.change = [0.0; 3];
            self.whole_turns = [0.0; 3];
            self.other_turn = None;
            self.vector = [0.0; 3];
            return;
        }
        let quaternion = match motion.rotation {
            Rotation::Vector(phi) => so3::exp_quaternion(phi),
            Rotation::Quaternion(q) => so3::normalize(q),
        };
        self.rotation = match motion.rotation {
            Rotation::Vector([0.0, 0.0, 0.0]) => identity(),
            _ => so3::matrix(quaternion),
        };
        (self.change, self.whole_turns, self.other_turn) = ([0.0; 3], [0.0; 3], None);
        if followed {
            let relative = so3::compose(quaternion, so3::conjugate(orientation.quaternion));
            let principal = so3::log_quaternion(relative);
            let turn = match motion.rotation {
                Rotation::Vector(new) => increment(new, orientation, relative, principal),
                Rotation::Quaternion(_) => Turn { increment: principal, other: None },
            };
            self.change = turn.increment;
            self.whole_turns = sub(turn.increment, principal);
            self.other_turn = turn.other.filter(|_| !first);
        }
        self.vector = match motion.rotation {
            Rotation::Vector(new) => new,
            Rotation::Quaternion(_) => so3::continuous_log_quaternion(quaternion, orientation.vector).phi,
        };
        orientation.quaternion = quaternion;
        orientation.vector = self.vector;
        orientation.is_of_vector = matches!(motion.rotation, Rotation::Vector(_));
    }
}

/// The increment of a rotation between two states, and the angle of another that fits them (rad), where it is no less likely.
struct Turn {
    increment: Vector<f64>,
    other: Option<f64>,
}

/// Which of two nodes, by name, have rotation vectors that fit another turn than the one taken.
pub(in crate::evaluate) fn ambiguous_turns(nodes: [(&'static str, &Moved); 2]) -> impl Iterator<Item = Flag> {
    nodes.into_iter().filter_map(|(node, moved)| {
        let other = moved.other_turn?;
        Some(Flag::AmbiguousTurn { component: "all", node, taken: norm(moved.change), other })
    })
}

/// The increment from one total rotation vector to the next: a log of `relative` = C(new) C(old)ᵀ, whose `principal` one is known.
///
/// 1. *About a fixed axis* (the vectors are parallel) it is the difference of the vectors, where the old one is zero or one of the
///    two is longer than a whole turn: these vectors tell their turns. So does a whole turn that zero follows. The vector of a quaternion,
///    continued from the states before, tells none.
/// 2. *Else* it is the shorter of the two ways round: right for every motion sampled at less than 0.9 π, whichever sheet each of
///    the vectors is on. At half a turn it is the way of the straight path between the vectors.
///
/// The straight path between two vectors of one sheet turns the short way. The longer way is `other` in these cases:
///
/// - that path takes it, and it is less than twice as long; seven times where a vector is longer than half a turn;
/// - vectors beyond a whole turn speak of turns about no fixed axis.
///
/// The difference of parallel vectors, one of them longer than half a turn, is `other` where it is another turn. The shorter way must exceed
/// π/4 then, or be nothing at all.
fn increment(
    new: Vector<f64>,
    before: &Orientation,
    relative: Quaternion<f64>,
    principal: Vector<f64>,
) -> Turn {
    /// Vectors are parallel if their directions differ by no more (rad): files have six digits.
    const PARALLEL: f64 = 1e-6;
    /// How far half a turn, or a whole one, may have been rounded up (rad).
    const ROUNDED: f64 = 1e-3;
    let old = before.vector;
    let [length, old_length, shorter] = [norm(new), norm(old), norm(principal)];
    let starts = old_length == 0.0;
    let is_fixed = norm(cross(new, old)) <= PARALLEL * length * old_length;
    // Back to exactly nothing from a whole turn, as a table of angles has it.
    let is_home = length == 0.0 && old_length > TAU - ROUNDED && before.is_of_vector;
    // The vector of a quaternion has turns that the states before made, and that this one need not know.
    let told_length = if before.is_of_vector { old_length } else { 0.0 };
    let is_beyond = length.max(told_length) > TAU + ROUNDED || is_home;
    // Along the straight path the quaternion changes without a jump: it ends as ±relative, and w < 0 is the long way.
    let is_negative = !before.is_of_vector && {
        let ([w, x, y, z], [a, b, c, d]) = (so3::exp_quaternion(old), before.quaternion);
        w * a + x * b + y * c + z * d < 0.0
    };
    let is_long = is_negative != (relative[0] < 0.0);
    let longer = TAU - shorter;
    let is_even = longer - shorter < ROUNDED;
    if is_fixed && (starts || is_beyond) {
        let difference = sub(new, old);
        let increment = so3::continuous_log_quaternion(relative, difference).phi;
        // Close past a whole turn, vectors swing to the other side: the fixed axis may be a coincidence.
        let sheet = |length: f64| (length / TAU).round();
        let swings = dot(new, old) < 0.0 && sheet(length) == sheet(old_length);
        let is_ambiguous = match (is_beyond, is_home) {
            (_, true) => old_length < TAU + ROUNDED,
            (true, false) => swings,
            (false, false) => is_long || is_even,
        };
        return Turn { increment, other: is_ambiguous.then_some(shorter) };
    }
    let leaps = is_beyond && (length - old_length).abs() > shorter + ROUNDED;
    // Vectors none of which is longer than half a turn are reduced, most likely.
    let likely = if length.max(old_length) > PI + ROUNDED { FRAC_PI_4 } else { 2.0 * FRAC_PI_3 };
    // The vectors tell another turn than the shorter one, or whole turns and nothing else; close to zero that is rounding.
    let told = norm(sub(new, old));
    let tells = is_fixed && told - shorter > ROUNDED && length.max(old_length) > PI + ROUNDED;
    let is_whole = shorter < ROUNDED && length.min(old_length) > ROUNDED;
    let is_ambiguous = (is_long && (is_beyond || shorter > likely))
        || leaps
        || is_even
        || (tells && (shorter > likely || is_whole));
    if is_even && is_long {
        let other_way = scale(principal, 1.0 - TAU / shorter);
        let increment = so3::continuous_log_quaternion(relative, other_way).phi;
        return Turn { increment, other: Some(shorter) };
    }
    Turn { increment: principal, other: is_ambiguous.then_some(if tells { told } else { longer }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn follow(motion: &NodeMotion, before: &Orientation, first: bool) -> (Moved, Orientation) {
        let (mut node, mut orientation) = (STILL, *before);
        node.follow(motion, &mut orientation, true, true, first);
        (node, orientation)
    }

    fn motion(rotation: Rotation) -> NodeMotion {
        NodeMotion { rotation, ..NodeMotion::default() }
    }

    /// The rotation about the axis 1 that a node has made after states that give it as rotation vectors.
    fn turned(angles: &[f64]) -> f64 {
        let mut before = UNTURNED;
        let mut sum = 0.0;
        for angle in angles {
            let motion =
                NodeMotion { rotation: Rotation::Vector([*angle, 0.0, 0.0]), ..NodeMotion::default() };
            let (node, after) = follow(&motion, &before, false);
            sum += node.change[0];
            before = after;
        }
        sum
    }

    /// Turns survive a change from quaternions to rotation vectors.
    #[test]
    fn quaternions_and_vectors_mix() {
        let quaternion = |angle: f64| Rotation::Quaternion(so3::exp_quaternion([angle, 0.0, 0.0]));
        let mut before = UNTURNED;
        let mut sum = 0.0;
        for rotation in
            [quaternion(0.3), Rotation::Vector([20.6, 0.0, 0.0]), quaternion(22.0), quaternion(24.0)]
        {
            let (node, after) = follow(&NodeMotion { rotation, ..NodeMotion::default() }, &before, false);
            sum += node.change[0];
            before = after;
        }
        assert!((sum - 24.0).abs() < 1e-13, "{sum}");
        assert!((before.vector[0] - 24.0).abs() < 1e-13, "{:?}", before.vector);
    }

    /// After quaternions a vector may be of any sheet: what it is short of are no turns.
    #[test]
    fn a_reduced_vector_follows_quaternions() {
        let mut compared = 0;
        for step in [0.1, 1.5, 2.8, -2.8] {
            for forms in ["qqqqqr", "qrqrqrqr", "qqqqrrrr", "qqqqqcc", "qqccqrq"] {
                let (mut before, mut sum, mut angle) = (UNTURNED, 0.0, 0.0);
                for form in forms.bytes() {
                    angle += step;
                    let rotation = match form {
                        b'q' => Rotation::Quaternion(so3::exp_quaternion([0.0, angle, 0.0])),
                        b'r' => Rotation::Vector([0.0, angle - TAU * (angle / TAU).round(), 0.0]),
                        _ => Rotation::Vector([0.0, angle, 0.0]),
                    };
                    let (node, after) = follow(&motion(rotation), &before, false);
                    (sum, before) = (sum + node.change[1], after);
                    compared += 1;
                }
                assert!((sum - angle).abs() < 1e-12, "{forms}, {step}: {sum}, not {angle}");
            }
        }
        assert_eq!(compared, 4 * (6 + 8 + 8 + 7 + 7));
    }

    #[test]
    fn vectors_keep_their_turns_or_are_wrapped() {
        let tau = TAU;
        let is =
            |angles: &[f64], expected: f64| assert!((turned(angles) - expected).abs() < 1e-12, "{angles:?}");
        is(&[3.0, 3.2, 7.0, 3000.0, 2.0], 2.0);
        is(&[3.0, 4.0, -4.0], tau - 4.0);
        is(&[3.0, 6.0, 0.1, -0.2], tau - 0.2);
        is(&[1.0, 7.5, -7.5, 0.0], 0.0);
        is(&[3.0, -3.0, -0.5], tau - 0.5);
        // Half a turn, as a file has it that rounds π up.
        let half = PI + 7e-6;
        is(&[half], half);
        is(&[3.0, half, 3.3], 3.3);
        is(&[3.0, half, -3.0], tau - 3.0);
        is(&[-3.0, half, 3.0], 3.0 - tau);
    }

    /// A generator of numbers in [−1, 1).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn vector(&mut self, length: f64) -> Vector<f64> {
            let v = [self.next(), self.next(), self.next()];
            scale(v, length / norm(v))
        }
    }

    /// A vector on another sheet, shorter than π or than 2π.
    fn reduced(q: Quaternion<f64>, below_two_turns: bool) -> Vector<f64> {
        let short = so3::log_quaternion(q);
        let length = norm(short);
        if below_two_turns { scale(short, 1.0 - TAU / length) } else { short }
    }

    /// Motions about no fixed axis, in every form of input, with increments up to 0.9 π: from rest, from many turns, and from close
    /// past a whole turn, where continued vectors swing to the other side.
    #[test]
    fn increments_are_those_of_the_motion() {
        let mut numbers = Numbers(1);
        let (mut compared, mut swung) = (0, 0);
        for start in [0.37, 6.1, 6.27, 12.5, 40.0, 1e3, 1e4] {
            for largest in [0.02, 0.2, 1.0, 0.9 * PI] {
                let mut continued = numbers.vector(start);
                let first = motion(Rotation::Vector(continued));
                let mut before = [follow(&first, &UNTURNED, true).1; 5];
                let mut q = so3::exp_quaternion(continued);
                for step in 0..400 {
                    let length = largest * (0.55 + 0.45 * numbers.next());
                    let true_increment = numbers.vector(length);
                    // The vector is continued in pieces, as a program does that takes small steps.
                    let old = continued;
                    for _ in 0..64 {
                        q = so3::normalize(so3::compose(
                            so3::exp_quaternion(scale(true_increment, 1.0 / 64.0)),
                            q,
                        ));
                        continued = so3::continuous_log_quaternion(q, continued).phi;
                    }
                    swung += usize::from(norm(sub(continued, old)) > PI);
                    let forms = [
                        Rotation::Vector(continued),
                        Rotation::Vector(reduced(q, false)),
                        Rotation::Vector(reduced(q, true)),
                        Rotation::Vector(reduced(q, step % 3 == 0)),
                        if step % 2 == 0 { Rotation::Quaternion(q) } else { Rotation::Vector(continued) },
                    ];
                    for (form, before) in forms.into_iter().zip(&mut before) {
                        let (node, after) = follow(&motion(form), before, false);
                        let off = norm(sub(node.change, true_increment));
                        assert!(off < 1e-11, "{start} {largest} {step}: {form:?} off by {off:e}");
                        *before = after;
                        compared += 1;
                    }
                }
            }
        }
        assert_eq!(compared, 7 * 4 * 400 * 5);
        assert!(swung > 500, "{swung}");
    }

    /// About a fixed axis, whatever it is, vectors beyond a whole turn tell any number of turns.
    #[test]
    fn about_a_fixed_axis_vectors_tell_their_turns() {
        let mut numbers = Numbers(2);
        let mut compared = 0;
        for _ in 0..200 {
            let axis = numbers.vector(1.0);
            let mut angle = 0.0;
            let mut before = UNTURNED;
            for _ in 0..50 {
                let next = match numbers.next() {
                    turn if turn < 0.0 => angle + 3.0 * numbers.next(),
                    _ => 7.0 + 1e3 * numbers.next().abs(),
                };
                let (node, after) = follow(&motion(Rotation::Vector(scale(axis, next))), &before, false);
                // Both within a whole turn, and more than half a turn apart, are another question.
                let is_told = angle == 0.0 || angle.abs().max(next.abs()) > TAU + 0.01;
                if is_told || (next - angle).abs() < 3.0 {
                    let off = norm(sub(node.change, scale(axis, next - angle)));
                    assert!(off < 1e-9, "{angle} to {next}: off by {off:e}");
                    compared += 1;
                }
                (before, angle) = (after, next);
            }
        }
        assert!(compared > 9_900, "{compared}");
    }

    /// Where two turns are alike, the other is told; where one of them is far shorter, it is not.
    #[test]
    fn another_turn_that_fits_is_told() {
        let other = |old: f64, new: f64| {
            let (_, before) = follow(&motion(Rotation::Vector([0.0, 0.0, old])), &UNTURNED, true);
            follow(&motion(Rotation::Vector([0.0, 0.0, new])), &before, false).0
        };
        for (old, new, taken, told) in [
            (-1.91, 1.74, -2.633_185_307_179_586, Some(3.65)),
            (-1.91, 3.5, -0.873_185_307_179_586, Some(5.41)),
            (-1.6, 1.6, 3.2 - TAU, Some(3.2)),
            (-FRAC_PI_2, FRAC_PI_2, PI, Some(PI)),
            (PI, TAU, PI, Some(PI)),
            (0.0, 5.0, 5.0, Some(1.283_185_307_179_586)),
            (7.5, -7.5, -15.0, Some(2.433_629_385_640_828)),
            (2.1, -2.7, TAU - 4.8, None),
            (3.0, -3.0, TAU - 6.0, None),
            (6.2, 0.1, TAU - 6.1, None),
            (TAU, 0.0, -TAU, Some(0.0)),
            (2.0 * TAU, 0.0, -2.0 * TAU, None),
            (TAU, -TAU, 0.0, Some(2.0 * TAU)),
            (5.0, -5.0, 2.0 * TAU - 10.0, Some(10.0)),
            (0.5, 0.5 - TAU, 0.0, Some(TAU)),
            (6.27, 1e-7, TAU - 6.27 + 1e-7, None),
            (0.3, 20.0, 19.7, None),
            (0.3, 2.9, 2.6, None),
        ] {
            let node = other(old, new);
            assert!((node.change[2] - taken).abs() < 1e-14, "{old} {new}: {:?}", node.change);
            match (node.other_turn, told) {
                (None, None) => {}
                (Some(other), Some(told)) => assert!((other - told).abs() < 1e-14, "{old} {new}: {other}"),
                (other, _) => panic!("{old} {new}: {other:?}, not {told:?}"),
            }
        }
    }
}
