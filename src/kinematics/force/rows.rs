//! The rows of virtual work of a connector at one state.

use crate::catalog::{Loading, PrintedMoment};
use crate::connector::{
    Branch, Components, Connector, Differentiation, Evaluation, Mask, NodalMatrix, NodalRow, State, Tally,
};
use crate::force::Wrench;
use crate::force::dual::dual_basis;
use crate::measure::Measure;
use crate::node::{DOFS, PSI_A, PSI_B, THETA_A, THETA_B, XB};
use crate::scalar::{Duals, Real};
use crate::so3;
use crate::vector::{Matrix, Vector, add, apply, column, dot, identity, scale, skew};

/// What is wanted besides the rows themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Want {
    /// The derivatives of the rows: geometric stiffness.
    pub stiffness: bool,
    /// The rows of the equations enforced: multipliers.
    pub multipliers: bool,
    /// The rows of the positions of these components, by which their forces may change: tangents.
    pub motions: Mask,
}

/// The row of one force, and its derivative.
#[derive(Clone, Debug)]
pub struct ForceRow<R> {
    /// G_k: the nodal forces of a unit force.
    pub row: NodalRow<R>,
    /// ∂²c_k/∂q_i∂q_j where G_k is the gradient of a function c_k, else ∂G_ki/∂q_j; where it was wanted.
    pub change: Option<NodalMatrix<R>>,
    /// Whether G_k is the gradient of a function, and its change symmetric.
    pub is_gradient: bool,
}

/// The rows of virtual work at one state, of the components asked for.
#[derive(Clone, Debug)]
pub struct ForceRows<R> {
    rows: Components<ForceRow<R>>,
    /// The rows of positions that are not those of the force.
    motions: Components<ForceRow<R>>,
    /// The moments on b of unit multipliers of constrained rotations.
    residual: [Option<Vector<R>>; 3],
    is_constrained: Mask,
    printed: Option<(PrintedMoment, [Vector<R>; 3])>,
}

impl<R: Duals> Connector<R> {
    /// Whether component k (0-based) has a force.
    pub fn has_force(&self, k: usize) -> bool {
        self.position_measure(k).is_some() && self.connection().loading(k).is_some()
    }

    pub(crate) fn force_rows_any(
        &self,
        state: &State<R>,
        branch: &Branch<R>,
        components: Mask,
        want: Want,
        evaluation: Option<&Evaluation<R>>,
        tally: &mut Tally,
    ) -> ForceRows<R> {
        let triad_a = state.pair.a.triad;
        let mut rows: Components<ForceRow<R>> = [const { None }; 6];
        let mut gradients: Vec<(usize, Measure)> = Vec::new();
        let mut tension = None;
        for k in (0..6).filter(|k| components[*k]) {
            let (Some(position), Some(loading)) = (self.position_measure(k), self.connection().loading(k))
            else {
                continue;
            };
            match loading {
                Loading::Conjugate => gradients.push((k, position)),
                Loading::Tension => {
                    tension = Some(k);
                    gradients.push((k, Measure::Distance));
                }
                Loading::AlongA(_) | Loading::FrozenAxis(_) => {
                    let axis = self.moment_axis(k, &triad_a);
                    rows[k] = axis.map(|axis| self.carried(axis, want.stiffness));
                }
            }
        }
        let history = branch.history();
        let reach = self.reach();
        // Rows of the evaluation leave out what does not move, those of forces hold the reactions of the ground.
        let known = evaluation.filter(|_| reach == self.active());
        let differentiated = |k: usize, measure: Measure| {
            let evaluation = known.filter(|_| self.differentiated(k) == Some(measure))?;
            let row = *evaluation.jacobian[k].as_ref()?;
            let change = evaluation.hessian[k].as_ref().filter(|_| want.stiffness);
            (change.is_some() == want.stiffness).then(|| (row, change.cloned()))
        };
        let input = Differentiation { state, history: &history, active: reach, second: want.stiffness };
        let mut take = |k: usize, mut row: NodalRow<R>, change| {
            if tension == Some(k) {
                (row[PSI_A], row[PSI_B]) = (R::integer(-1), R::integer(1));
            }
            let is_gradient = !self.position_measure(k).is_some_and(Measure::is_one_form);
            rows[k] = Some(ForceRow { row, change, is_gradient });
        };
        gradients.retain(|(k, measure)| {
            let found = differentiated(*k, *measure);
            let is_new = found.is_none();
            if let Some((row, change)) = found {
                take(*k, row, change);
            }
            is_new
        });
        self.differentiate(&input, &gradients, tally, &mut take);
        let mut motions: Components<ForceRow<R>> = [const { None }; 6];
        let others: Vec<(usize, Measure)> = (0..6)
            .filter(|k| {
                want.motions[*k] && (tension == Some(*k) || rows[*k].is_none() || !self.is_conjugate(*k))
            })
            .filter_map(|k| Some((k, self.position_measure(k)?)))
            .collect();
        self.differentiate(&input, &others, tally, &mut |k, row, change| {
            let is_gradient = !self.position_measure(k).is_some_and(Measure::is_one_form);
            motions[k] = Some(ForceRow { row, change, is_gradient });
        });
        let mut residual = [None; 3];
        if want.multipliers {
            let measures: Vec<(usize, Measure)> = (3..6)
                .filter(|k| self.is_constrained(*k))
                .filter_map(|k| self.differentiated(k).map(|measure| (k, measure)))
                .collect();
            let input = Differentiation { second: false, ..input };
            self.differentiate(&input, &measures, tally, &mut |k, row, _| {
                residual[k - 3] = Some(part(&row, THETA_B));
            });
        }
        let printed = self.connection().printed.and_then(|(formula, _)| {
            let directions = match formula {
                PrintedMoment::AlongA => [0, 1, 2].map(|i| column(&triad_a, i)),
                PrintedMoment::CardanAxes => self.axes(&triad_a, &state.pair.b.triad, branch)?,
                PrintedMoment::Midway => {
                    let q = crate::vector::transposed_product(&triad_a, &state.pair.b.triad);
                    let middle = so3::mid_frame(&q, None, branch.torsion.turns);
                    [0, 1, 2].map(|i| apply(&triad_a, column(&middle, i)))
                }
            };
            Some((formula, directions))
        });
        ForceRows {
            rows,
            motions,
            residual,
            is_constrained: [0, 1, 2, 3, 4, 5].map(|k| self.is_constrained(k)),
            printed,
        }
    }

    /// The direction, carried by a, along which a unit constraint moment of component k acts on b, where it is printed so.
    pub fn moment_axis(&self, k: usize, triad_a: &Matrix<R>) -> Option<Vector<R>> {
        Some(apply(triad_a, self.carried_moment_axis(k)?))
    }

    /// The same in components along e_i^a, which never change.
    pub fn carried_moment_axis(&self, k: usize) -> Option<Vector<R>> {
        match self.connection().loading(k)? {
            Loading::AlongA(i) => Some(column(&identity(), i - 1)),
            Loading::FrozenAxis(i) => Some(self.frozen_axes()[i - 1]),
            Loading::Conjugate | Loading::Tension => None,
        }
    }

    /// Whether the row of a force is that of the position of its component.
    fn is_conjugate(&self, k: usize) -> bool {
        matches!(self.connection().loading(k), Some(Loading::Conjugate))
    }

    /// The row of a moment on b along a direction that a carries, and its opposite on a.
    fn carried(&self, direction: Vector<R>, second: bool) -> ForceRow<R> {
        let zero = R::ZERO;
        let reach = self.reach();
        let mut row = [zero; DOFS];
        for i in 0..3 {
            row[THETA_A + i] = if reach[THETA_A + i] { -direction[i] } else { zero };
            row[THETA_B + i] = if reach[THETA_B + i] { direction[i] } else { zero };
        }
        let change = second.then(|| {
            // δv = δθ_a × v = −v^ δθ_a.
            let spin = skew(direction);
            let mut change = Box::new([[zero; DOFS]; DOFS]);
            for i in 0..3 {
                for j in 0..3 {
                    if reach[THETA_A + i] && reach[THETA_A + j] {
                        change[THETA_A + i][THETA_A + j] = spin[i][j];
                        change[THETA_B + i][THETA_A + j] = -spin[i][j];
                    }
                }
            }
            change
        });
        ForceRow { row, change, is_gradient: false }
    }

    /// The duals of the axes e1a, cos α₀ e2a + sin α₀ e3a, e3b of the Cardan angles frozen initially, components along e_i^a.
    ///
    /// Where the frozen β₀ = ±π/2, the first and third axis are parallel: the dual of the third is zero then, and the components are
    /// flagged as singular.
    fn frozen_axes(&self) -> [Vector<R>; 3] {
        const LOCK: f64 = 2e-15;
        let (zero, one) = (R::ZERO, R::integer(1));
        let q = self.initial_orientation();
        let (sine, cosine) = self.initial_branch().turns[3].principal.sine_cosine();
        let first = [one, zero, zero];
        let square = q[1][2] * q[1][2] + q[2][2] * q[2][2];
        R::choose(
            R::direction_and_norm([q[1][2], q[2][2]]).1.less(R::from_f64(LOCK)),
            || [first, [zero, cosine, sine], [zero; 3]],
            || {
                // (e1 − e3b (e1·e3b))/|e1 × e3b|² and (e3b − e1 (e1·e3b))/|e1 × e3b|², without the difference that is 1, or 0.
                let third = [zero, q[1][2] / square, q[2][2] / square];
                let along = q[0][2];
                [[one, -along * third[1], -along * third[2]], [zero, cosine, sine], third]
            },
        )
    }

    /// The axes of the successive rotations, global components. They are (e1a, cos α e2a + sin α e3a, e3b) of Cardan and (e3a, cos α e1a +
    /// sin α e2a, e3b) of Euler angles; `None` for other types.
    fn axes(&self, a: &Matrix<R>, b: &Matrix<R>, branch: &Branch<R>) -> Option<[Vector<R>; 3]> {
        let (first, [zeroth, right]) = match (3..6).find_map(|k| self.position_measure(k))? {
            Measure::Cardan(_) => (0, [1, 2]),
            Measure::Euler(_) => (2, [0, 1]),
            _ => return None,
        };
        let (sine, cosine) = branch.turns[3].principal.sine_cosine();
        let second = add(scale(column(a, zeroth), cosine), scale(column(a, right), sine));
        Some([column(a, first), second, column(b, 2)])
    }
}

/// Σ c_i v_i.
fn combination<R: Real>(v: [Vector<R>; 3], c: [R; 3]) -> Vector<R> {
    add(add(scale(v[0], c[0]), scale(v[1], c[1])), scale(v[2], c[2]))
}

/// Three entries of a row.
fn part<R: Copy>(row: &NodalRow<R>, at: usize) -> Vector<R> {
    [row[at], row[at + 1], row[at + 2]]
}

impl<R: Real> ForceRows<R> {
    /// The row of component k (0-based).
    pub const fn row(&self, k: usize) -> Option<&ForceRow<R>> {
        self.rows[k].as_ref()
    }

    /// The rows with forces, those without left out.
    fn loaded<'a>(
        &'a self,
        forces: &Components<R>,
    ) -> impl Iterator<Item = (R, &'a ForceRow<R>)> + use<'a, R> {
        let forces = *forces;
        self.rows.iter().zip(forces).filter_map(|(row, force)| Some((force?, row.as_ref()?)))
    }

    /// The nodal forces Σ f_k G_kᵀ of component forces: forces (global components), moments, flow forces of a and of b, residual-side.
    pub fn nodal(&self, forces: &Components<R>) -> NodalRow<R> {
        let mut nodal = [R::ZERO; DOFS];
        for (force, ForceRow { row, .. }) in self.loaded(forces) {
            for (sum, entry) in nodal.iter_mut().zip(row) {
                *sum = *sum + force * *entry;
            }
        }
        nodal
    }

    /// The force on b and the moment about b, residual-side. [`Wrench::shifted`] refers it to another point.
    pub fn wrench(&self, forces: &Components<R>) -> Wrench<R> {
        let nodal = self.nodal(forces);
        Wrench { force: part(&nodal, XB), moment: part(&nodal, THETA_B) }
    }

    /// The moment Σ m_k h_k on b of the rotation components alone.
    pub fn moment(&self, forces: &Components<R>) -> Vector<R> {
        let mut moments = *forces;
        moments[..3].fill(None);
        self.wrench(&moments).moment
    }

    /// The geometric stiffness Σ f_k ∂²c_k, where rows were wanted with their changes.
    ///
    /// Symmetric but for forces whose row is no gradient (FLOW-CONVERTER's m3; the constraint moments of REVOLUTE and ALIGN, which a
    /// carries): for those it is ∂G_ki/∂q_j.
    pub fn geometric_stiffness(&self, forces: &Components<R>) -> NodalMatrix<R> {
        let mut sum = Box::new([[R::ZERO; DOFS]; DOFS]);
        for (force, ForceRow { change, .. }) in self.loaded(forces) {
            for (line, change) in sum.iter_mut().zip(change.iter().flat_map(|change| change.iter())) {
                for (entry, change) in line.iter_mut().zip(change) {
                    *entry = *entry + force * *change;
                }
            }
        }
        sum
    }

    /// ∂F_i/∂q_j: how the nodal forces change along x, Ψ and spatial rotations exp(δθ^) C, at constant component forces.
    ///
    /// This is the geometric stiffness, and for gradient rows, in the rotations of each node, −½ M^ besides, M the moment on that node.
    /// For the second variation is taken along exp(δθ^), and successive rotations do not commute.
    pub fn derivative(&self, forces: &Components<R>) -> NodalMatrix<R> {
        let mut sum = Box::new([[R::ZERO; DOFS]; DOFS]);
        for (force, row) in self.loaded(forces) {
            let Some(change) = turned(row, force) else { continue };
            for (line, change) in sum.iter_mut().zip(change.iter()) {
                for (entry, change) in line.iter_mut().zip(change) {
                    *entry = *entry + *change;
                }
            }
        }
        sum
    }

    /// The row of the position of component k, where it was wanted.
    fn motion(&self, k: usize) -> Option<&ForceRow<R>> {
        self.motions[k].as_ref().or(self.rows[k].as_ref())
    }

    /// Jᵀ D J: how nodal forces change with nodal displacements (or velocities) as the forces of components change with their
    /// displacements (or velocities), D_ij = ∂F_i/∂u_j. Rows of forces on the left, of positions on the right
    /// ([`Want::motions`] for every j with a slope); they differ for the tension of SLIPRING, whose u1 is a strain.
    pub fn material_stiffness(&self, slopes: &[[R; 6]; 6]) -> NodalMatrix<R> {
        let mut sum = Box::new([[R::ZERO; DOFS]; DOFS]);
        for (force, slopes) in self.rows.iter().zip(slopes) {
            let Some(force) = force else { continue };
            let change = self.change_of_force(slopes, |motion| motion.row);
            add_product(&mut sum, &force.row, &change);
        }
        sum
    }

    /// Jᵀ D ∂(J q̇)/∂q: how nodal forces change with nodal displacements at constant nodal velocities, because the velocities of
    /// components do, D_ij = ∂F_i/∂v_j. Needs [`Want::stiffness`].
    pub fn convective_stiffness(&self, slopes: &[[R; 6]; 6], velocity: &NodalRow<R>) -> NodalMatrix<R> {
        let mut sum = Box::new([[R::ZERO; DOFS]; DOFS]);
        for (force, slopes) in self.rows.iter().zip(slopes) {
            let Some(force) = force else { continue };
            let change = self.change_of_force(slopes, |motion| {
                let mut along = [R::ZERO; DOFS];
                let Some(change) = turned(motion, R::integer(1)) else { return along };
                for (line, rate) in change.iter().zip(velocity) {
                    for (entry, second) in along.iter_mut().zip(line) {
                        *entry = *entry + *rate * *second;
                    }
                }
                along
            });
            add_product(&mut sum, &force.row, &change);
        }
        sum
    }

    /// Σ_j D_j x_j over the positions.
    fn change_of_force(&self, slopes: &[R; 6], of: impl Fn(&ForceRow<R>) -> NodalRow<R>) -> NodalRow<R> {
        let mut change = [R::ZERO; DOFS];
        for (j, slope) in slopes.iter().enumerate().filter(|(_, slope)| !is_zero(**slope)) {
            let Some(motion) = self.motion(j) else { continue };
            for (entry, part) in change.iter_mut().zip(of(motion)) {
                *entry = *entry + *slope * part;
            }
        }
        change
    }

    /// The multipliers λ_k of the equations enforced, Σ λ_k ∂res_k = Σ f_k G_k over the constrained components, from reported forces.
    /// A constrained component without a force counts as zero. Needs [`Want::multipliers`] for rotations.
    ///
    /// Exact in both directions: the moments of REVOLUTE are perpendicular to e1a either way, those of UNIVERSAL parallel. They are
    /// `None` where the equations are dependent, such as those of a REVOLUTE whose axes are at a right angle.
    pub fn multipliers(&self, forces: &Components<R>) -> Components<R> {
        let constraint = self.constrained_only(forces);
        let duals = dual_basis(self.residual);
        let moment = self.moment(&constraint);
        [0, 1, 2, 3, 4, 5].map(|k| match k {
            0..3 => constraint[k],
            _ => duals[k - 3].map(|dual| dot(dual, moment)),
        })
    }

    /// How independent the equations enforced are, for each rotation: the sine of the angle of its row to the rows of the others, 0 where
    /// there are no multipliers. Needs [`Want::multipliers`].
    pub fn independence(&self) -> [Option<R>; 3] {
        let duals = dual_basis(self.residual);
        let length = |v: Vector<R>| R::direction_and_norm(v).1;
        [0, 1, 2].map(|i| {
            let row = self.residual[i]?;
            Some(duals[i].map_or(R::ZERO, |dual| (length(dual) * length(row)).reciprocal_or_zero()))
        })
    }

    fn constrained_only(&self, of: &Components<R>) -> Components<R> {
        [0, 1, 2, 3, 4, 5].map(|k| of[k].filter(|_| self.is_constrained[k]))
    }

    /// The moments m1, m2, m3 by which the printed formula ([`PrintedMoment`]) gives the exact moment; `None` for types whose print is
    /// that of the conjugate components, and where a component is absent.
    pub fn printed(&self, forces: &Components<R>) -> Components<R> {
        let mut found = [None; 6];
        let Some((_, directions)) = self.printed else { return found };
        let moment = self.moment(forces);
        let duals = dual_basis(directions.map(Some));
        for k in 3..6 {
            found[k] = duals[k - 3].filter(|_| self.rows[k].is_some()).map(|dual| dot(dual, moment));
        }
        found
    }

    /// The moment vector that the printed formula gives for printed moments, global components.
    pub fn of_printed(&self, printed: [R; 3]) -> Option<Vector<R>> {
        let (_, directions) = self.printed?;
        Some(combination(directions, printed))
    }
}

/// force · ∂G_i/∂q_j along x and exp(δθ^) C, where the change was wanted.
fn turned<R: Real>(row: &ForceRow<R>, force: R) -> Option<NodalMatrix<R>> {
    let mut change = row.change.clone()?;
    for entry in change.iter_mut().flatten() {
        *entry = force * *entry;
    }
    if row.is_gradient {
        let half = R::ratio(1, 2) * force;
        for at in [THETA_A, THETA_B] {
            let spin = skew(scale(part(&row.row, at), half));
            for i in 0..3 {
                for j in 0..3 {
                    change[at + i][at + j] = change[at + i][at + j] - spin[i][j];
                }
            }
        }
    }
    Some(change)
}

/// Adds a bᵀ.
fn add_product<R: Real>(sum: &mut NodalMatrix<R>, a: &NodalRow<R>, b: &NodalRow<R>) {
    for (line, a) in sum.iter_mut().zip(a) {
        for (entry, b) in line.iter_mut().zip(b) {
            *entry = *entry + *a * *b;
        }
    }
}

/// Whether a number is zero: exactly, for it is an entry that was never set.
fn is_zero<R: Real>(x: R) -> bool {
    let zero = R::ZERO;
    !R::holds(zero.less(x.magnitude()))
}
