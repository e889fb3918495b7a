//! The revolute-joint multi-point constraint.
//!
//! Node S (the first, dependent), node M (the second) and node J (the third), whose degree of freedom 6 is the relative
//! rotation φ_J about the joint's axis a, carried by M:
//!
//! > C(φ_S) = C(φ_J a) C(φ_M),  a = C(φ_M) a₀,  ω_S = ω_M + φ̇_J a,
//!
//! (seed Revolute joint, Eq. 1). The constraint is imposed as the rotation vector of C(φ_S) [C(φ_J a) C(φ_M)]ᵀ, three
//! numbers that are regular wherever the constraint nearly holds: three constraints and one more unknown. The product
//! C(φ_J a) C(φ_M) equals C(φ_M) C(φ_J a₀), which needs no turned axis and is what is computed.
//!
//! The axis runs from M to J in the initial geometry, along the global z if they coincide. Translations are not tied; add a
//! PIN for that.

use crate::connector::{
    CERTAIN_INCREMENT, Flag, ILL_CONDITIONED, Output, Request, Tally, Turns, nearest_turn,
};
use crate::measure::SingularClass;
use crate::scalar::elementary::{atan2, norm};
use crate::scalar::{Differentiable, Real, Scalar, Seeded};
use crate::so3;
use crate::vector::{self, Matrix, Vector, dot, dot_real};

/// The number of degrees of freedom that enter the constraint: θ_S, θ_M, φ_J.
pub const DOFS: usize = 7;

/// Their names, in order.
pub const DOF: [&str; DOFS] = ["θS1", "θS2", "θS3", "θM1", "θM2", "θM3", "φJ"];

/// The names of the three constraints: the global components of the rotation vector that violates them.
pub const CONSTRAINT: [&str; 3] = ["ρ1", "ρ2", "ρ3"];

/// A revolute-joint multi-point constraint on numbers of type R.
#[derive(Clone, Copy, Debug)]
pub struct Revolute<R: Differentiable> {
    axis: Vector<R>,
}

/// The three nodes at one instant.
#[derive(Clone, Copy, Debug)]
pub struct State<R: Real> {
    /// C(φ_S).
    pub slave: Matrix<R>,
    /// C(φ_M).
    pub master: Matrix<R>,
    /// φ_J where it is given; otherwise it is taken from the rotations ([`Evaluation::angle`]).
    pub joint: Option<R>,
    /// ω_S, ω_M, φ̇_J (rad/time).
    pub velocity: [R; DOFS],
    /// α_S, α_M, φ̈_J (rad/time²).
    pub acceleration: [R; DOFS],
}

/// What an evaluation gives. Rows and rates are present as asked for.
#[derive(Clone, Debug)]
pub struct Evaluation<R> {
    /// The rotation vector of C(φ_S) [C(φ_J a) C(φ_M)]ᵀ, global components (rad); zero where the constraint holds.
    pub residual: [R; 3],
    /// Its rate, ω_S − ω_M − φ̇_J a where the constraint holds (rad/time).
    pub residual_rate: Option<[R; 3]>,
    /// The part of its acceleration that is quadratic in the rates, J̇ q̇.
    pub residual_bias: Option<[R; 3]>,
    /// Its acceleration, J q̈ + J̇ q̇.
    pub residual_acceleration: Option<[R; 3]>,
    /// ∂ρ_i/∂(θ_S, θ_M, φ_J).
    pub jacobian: Option<[[R; DOFS]; 3]>,
    /// ∂²ρ_i/∂q_j∂q_k.
    pub hessian: Option<Box<[[[R; DOFS]; DOFS]; 3]>>,
    /// The angle about a that the rotations of S and M imply, turns counted (rad).
    pub angle: Turns<R>,
    /// Its first and second rate, where rates were asked for.
    pub angle_rates: Option<[R; 2]>,
    /// The axis a = C(φ_M) a₀.
    pub axis: Vector<R>,
}

/// C with a nilpotent rotation: exp(θ^) C.
fn turned<S: Scalar>(rotation: &Matrix<S::Real>, theta: Vector<S>) -> Matrix<S> {
    let constant =
        [vector::constant(rotation[0]), vector::constant(rotation[1]), vector::constant(rotation[2])];
    vector::product(&so3::matrix(so3::exp(theta)), &constant)
}

impl<R: Differentiable> Revolute<R> {
    /// The constraint with the axis from M (at `master`) to J (at `joint`), or the global z where they coincide
    /// (keyword *MPC, type REVOLUTE).
    ///
    /// ```
    /// use pintle::mpc::Revolute;
    /// let joint = Revolute::<f64>::between([0.0; 3], [0.0, 2.0, 0.0]);
    /// assert_eq!(joint.axis(), [0.0, 1.0, 0.0]);
    /// assert_eq!(Revolute::<f64>::between([1.0; 3], [1.0; 3]).axis(), [0.0, 0.0, 1.0]);
    /// ```
    pub fn between(master: Vector<f64>, joint: Vector<f64>) -> Self {
        let separation = vector::sub(vector::exact::<R>(joint), vector::exact(master));
        let (axis, length) = R::direction_and_norm(separation);
        let (zero, one) = (R::integer(0), R::integer(1));
        Self { axis: R::choose(zero.less(length), || axis, || [zero, zero, one]) }
    }

    /// a₀, the axis in the initial geometry, of unit length, global components.
    pub const fn axis(&self) -> Vector<R> {
        self.axis
    }

    /// The violation, for nodes moved by nilpotent θ_S, θ_M and φ_J.
    fn violation<S: Scalar<Real = R>>(&self, state: &State<R>, joint: R, moved: [S; DOFS]) -> Vector<S> {
        let [s1, s2, s3, m1, m2, m3, phi] = moved;
        let slave = turned(&state.slave, [s1, s2, s3]);
        let master = turned(&state.master, [m1, m2, m3]);
        let phi = S::from_real(joint) + phi;
        let about_axis = so3::matrix(so3::exp([
            phi.scale(self.axis[0]),
            phi.scale(self.axis[1]),
            phi.scale(self.axis[2]),
        ]));
        let expected = vector::product(&master, &about_axis);
        so3::log(&vector::product(&slave, &vector::transpose(&expected)))
    }

    /// The principal angle about a₀ of C(φ_M)ᵀ C(φ_S): 2 atan(v·a₀ / w) of its quaternion.
    fn implied_angle<S: Scalar<Real = R>>(&self, state: &State<R>, moved: [S; DOFS]) -> S {
        let [s1, s2, s3, m1, m2, m3, _] = moved;
        let slave = turned(&state.slave, [s1, s2, s3]);
        let master = turned(&state.master, [m1, m2, m3]);
        let [w, x, y, z] = so3::quaternion(&vector::transposed_product(&master, &slave));
        atan2(dot_real(self.axis, [x, y, z]), w).scale(R::integer(2))
    }

    /// How far the relative rotation is from being about the axis at all: the angle of a carried by S to a carried by M (rad).
    pub fn misalignment(&self, state: &State<R>) -> R {
        let of_slave = vector::apply(&state.slave, self.axis);
        let of_master = vector::apply(&state.master, self.axis);
        atan2(norm(vector::cross(of_slave, of_master)), dot(of_slave, of_master))
    }

    /// Evaluates the constraint. Turns of the angle are counted to the nearest of `previous`, from where the whole turns of S
    /// against M since then (`whole_turns`, global components) would have taken it.
    pub fn evaluate(
        &self,
        state: &State<R>,
        previous: &Turns<R>,
        whole_turns: Vector<R>,
        request: &Request,
        tally: &mut Tally,
    ) -> Evaluation<R> {
        let zero = R::integer(0);
        let axis = vector::apply(&state.master, self.axis);
        let along = |acceleration: &[R; DOFS]| {
            let mut moving = [R::moving(zero, zero, zero); DOFS];
            for (j, entry) in moving.iter_mut().enumerate() {
                *entry = R::moving(zero, state.velocity[j], acceleration[j]);
            }
            moving
        };
        let wants = |wanted: &[Output]| request.outputs().any(|output| wanted.contains(&output));
        let of_angle = wants(&[Output::CV, Output::CA]);
        let of_residual = wants(&[Output::RESV, Output::RESA]);
        let (principal, angle_rates) = if of_angle {
            tally.rates += 1;
            let angle = self.implied_angle(state, along(&state.acceleration));
            let (first, second) = R::rates(angle);
            (angle.real(), Some([first, second]))
        } else {
            tally.values += 1;
            (self.implied_angle(state, [zero; DOFS]), None)
        };
        let (turns, _) = nearest_turn(principal, previous, dot(axis, whole_turns), zero);
        let joint = state.joint.unwrap_or(principal);

        let mut evaluation = Evaluation {
            residual: [zero; 3],
            residual_rate: None,
            residual_bias: None,
            residual_acceleration: None,
            jacobian: None,
            hessian: None,
            angle: turns,
            angle_rates,
            axis,
        };
        if of_residual {
            tally.rates += 3;
            let violation = self.violation(state, joint, along(&state.acceleration));
            evaluation.residual = vector::real(violation);
            evaluation.residual_rate = Some(violation.map(|moving| R::rates(moving).0));
            evaluation.residual_acceleration = Some(violation.map(|moving| R::rates(moving).1));
        } else {
            tally.values += 3;
            evaluation.residual = self.violation(state, joint, [zero; DOFS]);
        }
        if wants(&[Output::RESB]) {
            tally.rates += 3;
            let still = self.violation(state, joint, along(&[zero; DOFS]));
            evaluation.residual_bias = Some(still.map(|moving| R::rates(moving).1));
        }
        match request.order {
            0 => {}
            1 => {
                tally.gradients += 3;
                evaluation.jacobian =
                    Some(self.differentiate::<R::Gradient<DOFS>>(state, joint).map(Seeded::gradient));
            }
            _ => {
                tally.hessians += 3;
                let rows = self.differentiate::<R::Hessian<DOFS>>(state, joint);
                evaluation.jacobian = Some(rows.map(Seeded::gradient));
                evaluation.hessian = Some(Box::new(rows.map(Seeded::hessian)));
            }
        }
        evaluation
    }

    fn differentiate<S: Seeded<DOFS, Real = R>>(&self, state: &State<R>, joint: R) -> Vector<S> {
        let seeds = [0, 1, 2, 3, 4, 5, 6].map(|i| S::seed(R::integer(0), i));
        self.violation(state, joint, seeds)
    }
}

impl Revolute<f64> {
    /// What needs care at a state: no angle about the axis (the relative rotation is a half turn about a direction across it),
    /// a violation near half a turn, an increment too large to count its turns.
    pub fn flags(
        &self,
        state: &State<f64>,
        previous: &Turns<f64>,
        whole_turns: Vector<f64>,
        evaluation: &Evaluation<f64>,
    ) -> Vec<Flag> {
        let [w, x, y, z] = so3::quaternion(&vector::transposed_product(&state.master, &state.slave));
        let about_axis = norm([w, dot(self.axis, [x, y, z])]);
        let half_turn = std::f64::consts::PI - norm(evaluation.residual);
        let mut flags = Vec::new();
        for (component, at, class, distance) in [
            (
                "φJ",
                "S turned by π from M about a direction across the axis",
                SingularClass::TrueSingularity,
                about_axis,
            ),
            ("ρ1", "S turned by π from where the constraint has it", SingularClass::BranchCut, half_turn),
        ] {
            if distance <= 0.0 {
                flags.push(Flag::Singular { component, at, class });
            } else if distance < ILL_CONDITIONED {
                flags.push(Flag::IllConditioned { component, at, class, distance });
            }
        }
        let turns = evaluation.angle.turns - previous.turns;
        let change = f64::with_turns(evaluation.angle.principal - previous.principal, turns);
        if (change - dot(evaluation.axis, whole_turns)).abs() > CERTAIN_INCREMENT * std::f64::consts::PI {
            flags.push(Flag::LargeIncrement { component: "φJ", change });
        }
        flags
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flags(of_slave: Vector<f64>) -> Vec<Flag> {
        let joint = Revolute::<f64>::between([0.0; 3], [0.0, 0.0, 1.0]);
        let state = State {
            slave: so3::matrix(so3::exp(of_slave)),
            master: vector::identity(),
            joint: None,
            velocity: [0.0; DOFS],
            acceleration: [0.0; DOFS],
        };
        let previous = Turns { turns: 0.0, principal: 0.0 };
        let nothing = Request::nothing(0);
        let evaluation = joint.evaluate(&state, &previous, [0.0; 3], &nothing, &mut Tally::default());
        joint.flags(&state, &previous, [0.0; 3], &evaluation)
    }

    /// A half turn across the axis leaves no angle about it, and one about it cannot be counted.
    #[test]
    fn half_turns_are_flagged() {
        use std::f64::consts::PI;
        assert!(flags([0.1, 0.2, 0.3]).is_empty());
        let across = flags([PI, 0.0, 0.0]);
        assert!(
            across.iter().any(|flag| flag.component() == "φJ" && flag.name() == "ill-conditioned"),
            "{across:?}"
        );
        let about = flags([0.0, 0.0, 3.1]);
        assert!(matches!(about[..], [Flag::LargeIncrement { component: "φJ", .. }]), "{about:?}");
    }
}
