//! Where the nodes of a mechanism are, and how fast.

use crate::fault::{Fault, has};
use crate::number::Number;
use pintle_kinematics::connector::Branch;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector, add, scale, sub};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Degrees of freedom of a node: x, θ, Ψ.
pub(crate) const DOFS: usize = 7;

/// A node.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Pose<R> {
    /// u.
    pub(crate) displacement: Vector<R>,
    /// C.
    pub(crate) rotation: Matrix<R>,
    /// φ, with its turns.
    pub(crate) vector: Vector<R>,
    /// Ψ.
    pub(crate) flow: R,
}

impl<R: Number> Pose<R> {
    pub(crate) fn at_rest() -> Self {
        let zero = R::ZERO;
        Self { displacement: [zero; 3], rotation: vector::identity(), vector: [zero; 3], flow: zero }
    }

    /// Moved by δx, exp(δθ), δΨ. A node that turns about one axis alone counts its angle; the vector of any other is the one next to it
    /// of its rotation, where that is asked for.
    pub(crate) fn moved(&self, by: &[R; DOFS], turns: [bool; 3], with_vector: bool) -> Self {
        let [x, y, z, p, q, r, flow] = *by;
        let turn = [p, q, r];
        let displacement = add(self.displacement, [x, y, z]);
        if turns == [false; 3] {
            return Self { displacement, flow: self.flow + flow, ..*self };
        }
        let told = add(self.vector, turn);
        let rotation = match has(Fault::RotationAdded) {
            true => so3::exp(told),
            false => vector::product(&so3::exp(turn), &self.rotation),
        };
        let vector = match turns.iter().filter(|turns| **turns).count() {
            1 => told,
            _ if !with_vector => told,
            _ => self.followed(turn),
        };
        Self { displacement, rotation, vector, flow: self.flow + flow }
    }

    /// The rotation vector after a turn about one axis, followed in pieces: which of the vectors of a rotation is the next one does not depend on
    /// how often it is asked for. Beside a whole turn, where the vector swings, pieces are shorter.
    fn followed(&self, turn: Vector<R>) -> Vector<R> {
        /// The longest piece (rad), the shortest, and the part of the way to the next whole turn that is one.
        const PIECES: [f64; 3] = [0.1, 1e-4, 0.25];
        let [longest, shortest, part] = PIECES;
        let whole = norm(turn).to_f64();
        let (mut vector, mut before, mut done) = (self.vector, [R::ZERO; 3], 0.0);
        while done < whole {
            let length = norm(vector).to_f64();
            let turns = (length / TAU).round().max(1.0);
            done += ((length - TAU * turns).abs() * part).clamp(shortest, longest);
            let reached = if done < whole { scale(turn, R::from_f64(done / whole)) } else { turn };
            let rotation = vector::product(&so3::exp(reached), &self.rotation);
            let log = so3::continuous_log(&rotation, vector);
            vector = if log.is_reference() { log.phi } else { add(vector, sub(reached, before)) };
            before = reached;
        }
        vector
    }
}

/// A mechanism at one time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State<R> {
    pub(crate) time: R,
    pub(crate) poses: Vec<Pose<R>>,
    /// v, ω, Ψ̇ of each node.
    pub(crate) rates: Vec<[R; DOFS]>,
    /// What the histories of connectors have decided.
    pub(crate) branches: Vec<Branch<R>>,
    /// External work, dissipation, elastic energy since the beginning; the slip of each friction; and R_k v_k of those of several components,
    /// integrated from rest while their slip begins ([`crate::motion::mode::Mode::in_onset`]), else zero.
    pub(crate) sums: Vec<R>,
}

/// The sums of a state that are no slips.
pub(crate) const WORKS: usize = 3;
