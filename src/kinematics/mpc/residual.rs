//! What a constraint requires to vanish, and the angles of its hinges, for every scalar.

use crate::mpc::{Constraint, State};
use crate::scalar::elementary::{atan2, norm};
use crate::scalar::{Duals, Scalar};
use crate::so3;
use crate::vector;
use crate::vector::{Matrix, Vector, add, constant, cross, dot_real, sub};

/// C with a nilpotent rotation: exp(θ^) C.
pub(crate) fn turned<S: Scalar>(rotation: &Matrix<S::Real>, theta: Vector<S>) -> Matrix<S> {
    let constant = [constant(rotation[0]), constant(rotation[1]), constant(rotation[2])];
    vector::product(&so3::matrix(so3::exp_quaternion(theta)), &constant)
}

impl<R: Duals> Constraint<R> {
    /// u_S − u_M, for nodes moved by x_S and x_M.
    pub(super) fn slip<S: Scalar<Real = R>>(
        &self,
        state: &State<R>,
        slave: Vector<S>,
        master: Vector<S>,
    ) -> Vector<S> {
        add(constant(sub(state.slave.displacement, state.master.displacement)), sub(slave, master))
    }

    /// |x_S − x_M| − |X_S − X_M|, for x_S − x_M moved by a nilpotent vector.
    pub(super) fn stretch<S: Scalar<Real = R>>(&self, state: &State<R>, moved: Vector<S>) -> S {
        let (_, initial) = R::direction_and_norm(self.arm);
        norm(add(constant(self.separation(state)), moved)) - S::from_real(initial)
    }

    /// x_S − x_M.
    pub(super) fn separation(&self, state: &State<R>) -> Vector<R> {
        add(self.arm, sub(state.slave.displacement, state.master.displacement))
    }

    /// −C_M (X_S − X_M), for M turned by a nilpotent θ.
    pub(super) fn carried<S: Scalar<Real = R>>(&self, state: &State<R>, theta: Vector<S>) -> Vector<S> {
        let arm = vector::apply(&state.master.rotation, self.arm);
        let arm = vector::apply(&so3::matrix(so3::exp_quaternion(theta)), constant(arm));
        [-arm[0], -arm[1], -arm[2]]
    }

    /// The rotation vector of C_S [C_M C(φ_1 a1₀) C(φ_2 a2₀)]ᵀ, for nodes moved by nilpotent θ_S, θ_M, φ_1 and φ_2.
    pub(super) fn violation<S: Scalar<Real = R>>(
        &self,
        state: &State<R>,
        angles: [R; 2],
        moved: [S; 8],
    ) -> Vector<S> {
        let [s1, s2, s3, m1, m2, m3, hinges @ ..] = moved;
        let slave = turned(&state.slave.rotation, [s1, s2, s3]);
        let mut expected = turned(&state.master.rotation, [m1, m2, m3]);
        for (i, change) in hinges.into_iter().enumerate().take(self.hinges()) {
            let angle = S::from_real(angles[i]) + change;
            let turn = self.axes[i].map(|component| angle.scale(component));
            expected = vector::product(&expected, &so3::matrix(so3::exp_quaternion(turn)));
        }
        so3::log(&vector::product(&slave, &vector::transpose(&expected)))
    }

    /// The principal angles of the hinges that C_Mᵀ C_S implies; zero for hinges that there are not.
    ///
    /// One hinge: 2 atan(v·a0 / w) of the quaternion (w, v), the rotation about a that comes nearest. Two: the first and the
    /// last of C(φ_1 a1₀) C(β n) C(φ_2 a2₀) with n along a2₀ × a1₀. Every rotation can be taken apart so, for orthogonal axes into
    /// Cardan angles. β is the violation.
    pub(super) fn implied_angles<S: Scalar<Real = R>>(
        &self,
        state: &State<R>,
        slave: Vector<S>,
        master: Vector<S>,
    ) -> [S; 2] {
        let slave = turned(&state.slave.rotation, slave);
        let relative = vector::transposed_product(&turned(&state.master.rotation, master), &slave);
        match self.hinges() {
            0 => [S::zero(); 2],
            1 => {
                let [w, x, y, z] = so3::quaternion(&relative);
                [atan2(dot_real(self.axes[0], [x, y, z]), w).scale(R::integer(2)), S::zero()]
            }
            _ => {
                let [first, second] = self.axes;
                let (across, _) = R::direction_and_norm(cross(second, first));
                // The second axis turns about the first, and the first, seen from S, backwards about the second.
                let ahead = vector::apply(&relative, constant(second));
                let back = vector::apply_transposed(&relative, constant(first));
                let angle =
                    |v: Vector<S>, zero: Vector<R>| atan2(S::zero() - dot_real(across, v), dot_real(zero, v));
                [angle(ahead, cross(first, across)), angle(back, cross(across, second))]
            }
        }
    }
}
