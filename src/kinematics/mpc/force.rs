//! What forces a constraint transmits, and what it leaves to be solved for.
//!
//! A constraint does no work on motions that it allows: the forces and moments that it puts on its nodes are F = Jᵀλ, one
//! multiplier λ for each equation. Where the constraint holds, λ is the force and moment on S, and the rows say the rest:
//! `M_M = −M_S` and `F_M = −F_S`. For hinges `M_J = −M_S·a = M_M·a` (seed Revolute joint, virtual work). For a BEAM besides
//! `M_M = −M_S − (x_S − x_M) × F_S`.
//!
//! Abaqus eliminates the dependent degrees of freedom: with `J_d δq_d + J_i δq_i = 0` all variations are those of the others. Forces
//! F_d on the dependent ones have the multipliers `λ = J_d⁻ᵀ F_d` ([`Constraint::multipliers`]).
//!
//! *Signs.* F is residual-side if what is put in is: internal forces of the elements at S give λ on that side.

use crate::mpc::{
    Constraint, DOFS, Dofs, Evaluation, FLOW, PHI, PSI_S, RHO, ROWS, Rows, State, THETA_M, THETA_S,
    Translation, XS,
};
use crate::scalar::{Duals, Real};
use crate::vector::{Vector, cross, dot, scale, skew};

/// A matrix over the degrees of freedom.
pub type DofMatrix<R> = Box<[Dofs<R>; DOFS]>;

fn zeros<R: Real>() -> DofMatrix<R> {
    Box::new([[R::ZERO; DOFS]; DOFS])
}

fn part<R: Copy>(of: &Dofs<R>, at: usize) -> Vector<R> {
    [of[at], of[at + 1], of[at + 2]]
}

impl<R: Duals> Evaluation<R> {
    /// Rows with a multiplier, those without left out.
    fn loaded<'a>(
        &'a self,
        multipliers: &'a Rows<R>,
    ) -> impl Iterator<Item = (R, &'a Dofs<R>, Option<&'a DofMatrix<R>>)> {
        let rows = multipliers.iter().zip(self.jacobian.iter().zip(&self.hessian));
        rows.filter_map(|(multiplier, (row, hessian))| {
            Some(((*multiplier)?, row.as_ref()?, hessian.as_ref()))
        })
    }

    /// The forces, moments and flow forces Jᵀλ that multipliers put on the nodes. Needs rows: order 1 or more.
    pub fn nodal(&self, multipliers: &Rows<R>) -> Dofs<R> {
        let mut nodal = [R::ZERO; DOFS];
        for (multiplier, row, _) in self.loaded(multipliers) {
            for (sum, entry) in nodal.iter_mut().zip(row) {
                *sum = *sum + multiplier * *entry;
            }
        }
        nodal
    }

    /// The geometric stiffness Σ λ ∂²g, symmetric: the second variation along x and exp(δθ^) C. Needs order 2.
    pub fn geometric_stiffness(&self, multipliers: &Rows<R>) -> DofMatrix<R> {
        let mut sum = zeros();
        for (multiplier, _, hessian) in self.loaded(multipliers) {
            for (line, hessian) in sum.iter_mut().zip(hessian.into_iter().flat_map(|hessian| hessian.iter()))
            {
                for (entry, second) in line.iter_mut().zip(hessian) {
                    *entry = *entry + multiplier * *second;
                }
            }
        }
        sum
    }

    /// ∂F_i/∂q_j: how the nodal forces change along x and spatial rotations exp(δθ^) C, at constant multipliers. This is the
    /// geometric stiffness, and −½ M^ besides in the rotations of each node, M the moment on that node: successive rotations do
    /// not commute. Needs order 2.
    pub fn derivative(&self, multipliers: &Rows<R>) -> DofMatrix<R> {
        let mut sum = self.geometric_stiffness(multipliers);
        let nodal = self.nodal(multipliers);
        for at in [THETA_S, THETA_M] {
            let spin = skew(scale(part(&nodal, at), R::ratio(1, 2)));
            for i in 0..3 {
                for j in 0..3 {
                    sum[at + i][at + j] = sum[at + i][at + j] - spin[i][j];
                }
            }
        }
        sum
    }
}

impl<R: Duals> Constraint<R> {
    /// The degrees of freedom that the constraint makes dependent: those of S that it has. A LINK takes the displacement of S along
    /// which it points most; the first of equal ones \[R\].
    pub fn dependent(&self, state: &State<R>) -> [bool; DOFS] {
        let columns = self.columns();
        if self.kind.entry().translation != Translation::Distance {
            return std::array::from_fn(|j| j <= PSI_S && columns[j]);
        }
        let [x, y, z] = self.separation(state).map(R::magnitude);
        let most = if R::holds(x.less(y)) {
            1 + usize::from(R::holds(y.less(z)))
        } else {
            2 * usize::from(R::holds(x.less(z)))
        };
        std::array::from_fn(|j| j == XS + most)
    }

    /// The multipliers that put given forces and moments on the dependent degrees of freedom: λ = J_d⁻ᵀ F_d. Forces on others are not
    /// looked at. What the constraint then puts on the others is [`Evaluation::nodal`] of them. Needs rows: order 1 or more.
    ///
    /// Where a LINK has no length nothing can be solved for: λ is zero there, and the state is flagged.
    pub fn multipliers(&self, state: &State<R>, evaluation: &Evaluation<R>, forces: &Dofs<R>) -> Rows<R> {
        let dependent = self.dependent(state);
        let jacobian = &evaluation.jacobian;
        let along = |direction: &[R], at: usize| {
            let terms = direction.iter().zip(&forces[at..]);
            terms.fold(R::ZERO, |sum, (entry, force)| sum + *entry * *force)
        };
        let mut multipliers: Rows<R> = [None; ROWS];
        // One equation for one degree of freedom each.
        let singly = |row: usize| {
            let at = match row {
                FLOW => PSI_S,
                // In the plane there is one rotation.
                5 => THETA_S + 2,
                _ => (XS..THETA_S)
                    .find(|j| dependent[*j] && jacobian[row].is_some_and(|of| !is_zero(of[*j])))?,
            };
            Some(at)
        };
        let is_planar = jacobian[RHO].is_none();
        for row in (0..RHO).chain((RHO..FLOW).filter(|_| is_planar)).chain([FLOW]) {
            let (Some(of), Some(at)) = (jacobian[row].as_ref(), singly(row)) else { continue };
            multipliers[row] = Some(along(&[of[at].reciprocal_or_zero()], at));
        }
        // Three equations for the rotation of S: J_d⁻¹ by the dual basis of its rows.
        if let [Some(a), Some(b), Some(c)] = [jacobian[RHO], jacobian[RHO + 1], jacobian[RHO + 2]] {
            let [u, v, w] = [a, b, c].map(|row| part(&row, THETA_S));
            let volume = dot(u, cross(v, w)).reciprocal_or_zero();
            let duals = [cross(v, w), cross(w, u), cross(u, v)].map(|dual| scale(dual, volume));
            for (row, dual) in duals.into_iter().enumerate() {
                multipliers[RHO + row] = Some(along(&dual, THETA_S));
            }
        }
        multipliers
    }
}

fn is_zero<R: Real>(x: R) -> bool {
    let zero = R::ZERO;
    !R::holds(zero.less(x.magnitude()))
}

/// The moments that the constraint puts on the hinges, from forces on all degrees of freedom.
///
/// ```
/// use pintle_kinematics::connector::{Request, Tally, Turns};
/// use pintle_kinematics::mpc::{Constraint, MpcType, State, Turning, PHI, THETA_M, THETA_S, force};
///
/// // A revolute joint about (2, 1, 2)/3, unturned, transmits a moment.
/// let joint = Constraint::<f64>::new(MpcType::Revolute, [0.0; 3], [0.0; 3], [[2.0, 1.0, 2.0], [0.0; 3]]);
/// let (state, start) = (State::at_rest(), [Turns { turns: 0.0, principal: 0.0 }; 2]);
/// let result = joint.evaluate(&state, &start, &Turning::none(), &Request::everything(1), &mut Tally::default());
/// let mut on_slave = [0.0; pintle_kinematics::mpc::DOFS];
/// on_slave[THETA_S..THETA_S + 3].copy_from_slice(&[3.0, 0.0, 0.0]);
/// let multipliers = joint.multipliers(&state, &result, &on_slave);
/// let nodal = result.nodal(&multipliers);
/// assert_eq!(nodal[THETA_M], -3.0); // M_M = −M_S
/// assert!((force::hinge_moments(&nodal)[0] + 2.0).abs() < 1e-15); // M_J = −M_S·a
/// # let _ = PHI;
/// ```
pub fn hinge_moments<R: Real>(nodal: &Dofs<R>) -> [R; 2] {
    [nodal[PHI], nodal[PHI + 1]]
}
