//! What one constraint gives at one state.

use crate::connector::{Output, Request, Tally, Turns, nearest_turn};
use crate::mpc::{
    Constraint, DOFS, Dofs, FLOW, PHI, PSI_M, PSI_S, RHO, ROWS, Rows, State, THETA_M, THETA_S, Translation,
    Turning, XM, XS,
};
use crate::scalar::{Duals, Scalar, Seeded};
use crate::so3;
use crate::vector;
use crate::vector::{Vector, add, dot, scale};

/// What an evaluation gives. Rows and rates are present as asked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Evaluation<R> {
    /// What the constraint requires to vanish: δ or δl (length), ρ (rad), δΨ (length).
    pub residual: Rows<R>,
    /// Its rate, J q̇.
    pub residual_rate: Rows<R>,
    /// The part of its acceleration that is quadratic in the rates, J̇ q̇.
    pub residual_bias: Rows<R>,
    /// Its acceleration, J q̈ + J̇ q̇.
    pub residual_acceleration: Rows<R>,
    /// ∂g_i/∂q_j; zero for degrees of freedom that the kind does not have.
    pub jacobian: Rows<Dofs<R>>,
    /// ∂²g_i/∂q_j∂q_k, symmetric: of g(exp(δθ^) C, …).
    pub hessian: Rows<Box<[Dofs<R>; DOFS]>>,
    /// The angles of the hinges that the rotations of S and M imply, turns counted (rad); zero for hinges that there are not.
    pub angles: [Turns<R>; 2],
    /// Their first and second rates, where rates were asked for (rad/time, rad/time²).
    pub angle_rates: Option<[[R; 2]; 2]>,
    /// The angles that the residual is taken at: those given, else those implied (rad).
    pub taken: [R; 2],
    /// The axes of the hinges as they are carried: a1 = C_M a1₀ and a2 = C(φ_1 a1) C_M a2₀.
    pub axes: [Option<Vector<R>>; 2],
}

/// Where a seed belongs: a degree of freedom, and one that enters with the opposite sign.
type Place = (usize, Option<usize>);

/// The degrees of freedom of rotation, in the order of their seeds.
const OF_ROTATION: [usize; 8] =
    [THETA_S, THETA_S + 1, THETA_S + 2, THETA_M, THETA_M + 1, THETA_M + 2, PHI, PHI + 1];

impl<R: Duals> Evaluation<R> {
    fn new(angles: [Turns<R>; 2], taken: [R; 2]) -> Self {
        Self {
            residual: [None; ROWS],
            residual_rate: [None; ROWS],
            residual_bias: [None; ROWS],
            residual_acceleration: [None; ROWS],
            jacobian: [None; ROWS],
            hessian: Default::default(),
            angles,
            angle_rates: None,
            taken,
            axes: [None; 2],
        }
    }

    /// Adds the derivatives of an equation by seeds to those by degrees of freedom.
    fn add<S: Seeded<N, Real = R>, const N: usize>(&mut self, row: usize, equation: S, places: [Place; N]) {
        let zero = R::ZERO;
        let into = self.jacobian[row].get_or_insert([zero; DOFS]);
        for (entry, (plus, minus)) in equation.gradient().into_iter().zip(places) {
            into[plus] = into[plus] + entry;
            if let Some(minus) = minus {
                into[minus] = into[minus] - entry;
            }
        }
        if const { S::ORDER < 2 } {
            return;
        }
        let into = self.hessian[row].get_or_insert_with(|| Box::new([[zero; DOFS]; DOFS]));
        for (line, (j, against_j)) in equation.hessian().into_iter().zip(places) {
            for (entry, (k, against_k)) in line.into_iter().zip(places) {
                into[j][k] = into[j][k] + entry;
                if let Some(against_k) = against_k {
                    into[j][against_k] = into[j][against_k] - entry;
                }
                if let Some(against_j) = against_j {
                    into[against_j][k] = into[against_j][k] - entry;
                }
                if let (Some(j), Some(k)) = (against_j, against_k) {
                    into[j][k] = into[j][k] + entry;
                }
            }
        }
    }

    /// Adds q_plus − q_minus to an equation.
    fn add_difference(&mut self, row: usize, plus: usize, minus: usize, order: u8) {
        let (zero, one) = (R::ZERO, R::integer(1));
        let gradient = self.jacobian[row].get_or_insert([zero; DOFS]);
        gradient[plus] = gradient[plus] + one;
        gradient[minus] = gradient[minus] - one;
        if order > 1 {
            self.hessian[row].get_or_insert_with(|| Box::new([[zero; DOFS]; DOFS]));
        }
    }
}

impl<R: Duals> Constraint<R> {
    /// The residual for nodes moved by nilpotent amounts.
    fn residual<S: Scalar<Real = R>>(&self, state: &State<R>, angles: [R; 2], moved: &Dofs<S>) -> Rows<S> {
        let part = |at: usize| [moved[at], moved[at + 1], moved[at + 2]];
        let wanted = self.rows();
        let mut rows = [None; ROWS];
        let mut put = |at: usize, part: Vector<S>| {
            for (row, entry) in rows[at..at + 3].iter_mut().zip(part) {
                *row = Some(entry);
            }
        };
        let (of_slave, of_master) = (part(XS), part(XM));
        match self.kind.entry().translation {
            Translation::Free => {}
            Translation::Equal => put(0, self.slip(state, of_slave, of_master)),
            Translation::Carried => {
                let apart: Vector<S> = vector::constant(self.separation(state));
                let apart = add(apart, vector::sub(of_slave, of_master));
                put(0, add(apart, self.carried(state, part(THETA_M))));
            }
            Translation::Distance => {
                rows[0] = Some(self.stretch(state, vector::sub(of_slave, of_master)));
            }
        }
        if wanted[RHO + 2] {
            let violation = self.violation(state, angles, OF_ROTATION.map(|j| moved[j]));
            for (row, entry) in rows[RHO..FLOW].iter_mut().zip(violation) {
                *row = Some(entry);
            }
        }
        if wanted[FLOW] {
            let apart = S::from_real(state.slave.flow - state.master.flow);
            rows[FLOW] = Some(apart + moved[PSI_S] - moved[PSI_M]);
        }
        for (row, wanted) in rows.iter_mut().zip(wanted) {
            *row = row.filter(|_| wanted);
        }
        rows
    }

    pub(crate) fn evaluate_any(
        &self,
        state: &State<R>,
        previous: &[Turns<R>; 2],
        turning: &Turning<R>,
        request: &Request,
        tally: &mut Tally,
    ) -> Evaluation<R> {
        let zero = R::ZERO;
        let still = [zero; DOFS];
        let along = |acceleration: &Dofs<R>| -> Dofs<R::Time> {
            std::array::from_fn(|j| R::moving(zero, state.velocity[j], acceleration[j]))
        };
        let wants = |wanted: &[Output]| request.outputs().any(|output| wanted.contains(&output));
        let count = self.rows().into_iter().filter(|row| *row).count() as u64;
        let hinges = self.hinges();

        let (principal, angle_rates) = if hinges > 0 && wants(&[Output::CV, Output::CA]) {
            tally.rates += hinges as u64;
            let moving = along(&state.acceleration);
            let part = |at: usize| [moving[at], moving[at + 1], moving[at + 2]];
            let angles = self.implied_angles(state, part(THETA_S), part(THETA_M));
            let rates = angles.map(|angle| {
                let (first, second) = R::rates(angle);
                [first, second]
            });
            (angles.map(Scalar::real), Some(rates))
        } else {
            tally.values += hinges as u64;
            (self.implied_angles(state, [zero; 3], [zero; 3]), None)
        };
        let taken = [0, 1].map(|i| state.angles[i].unwrap_or(principal[i]));
        let axes = self.carried_axes(state, taken);
        let winding = self.winding_axes(state);
        let angles = [0, 1].map(|i| {
            let (whole, rest) = (dot(winding[i], turning.whole), dot(winding[i], turning.rest));
            let none = Turns { turns: zero, principal: zero };
            if i < hinges { nearest_turn(principal[i], &previous[i], whole, rest).0 } else { none }
        });

        let mut evaluation = Evaluation { angle_rates, axes, ..Evaluation::new(angles, taken) };
        if wants(&[Output::RESV, Output::RESA]) {
            tally.rates += count;
            let moving = self.residual(state, taken, &along(&state.acceleration));
            evaluation.residual = moving.map(|row| row.map(Scalar::real));
            evaluation.residual_rate = moving.map(|row| row.map(|moving| R::rates(moving).0));
            evaluation.residual_acceleration = moving.map(|row| row.map(|moving| R::rates(moving).1));
        } else {
            tally.values += count;
            evaluation.residual = self.residual(state, taken, &still);
        }
        if wants(&[Output::RESB]) {
            tally.rates += count;
            let unaccelerated = self.residual(state, taken, &along(&still));
            evaluation.residual_bias = unaccelerated.map(|row| row.map(|moving| R::rates(moving).1));
        }
        match request.order {
            0 => {}
            1 => tally.gradients += count,
            _ => tally.hessians += count,
        }
        self.differentiate(state, request.order, &mut evaluation);
        evaluation
    }

    /// The directions about which the angles grow when S turns: C_M a1₀ and C_S a2₀.
    pub(super) fn winding_axes(&self, state: &State<R>) -> [Vector<R>; 2] {
        let [first, second] = self.axes;
        [vector::apply(&state.master.rotation, first), vector::apply(&state.slave.rotation, second)]
    }

    /// a1 = C_M a1₀ and a2 = C(φ_1 a1) C_M a2₀ = C_M C(φ_1 a1₀) a2₀.
    fn carried_axes(&self, state: &State<R>, angles: [R; 2]) -> [Option<Vector<R>>; 2] {
        let hinges = self.hinges();
        let carried = |axis| vector::apply(&state.master.rotation, axis);
        let first = (hinges > 0).then(|| carried(self.axes[0]));
        let second = (hinges > 1).then(|| {
            let turn = so3::matrix(so3::exp_quaternion(scale(self.axes[0], angles[0])));
            carried(vector::apply(&turn, self.axes[1]))
        });
        [first, second]
    }

    /// Rows and second derivatives, up to the order asked for.
    fn differentiate(&self, state: &State<R>, order: u8, evaluation: &mut Evaluation<R>) {
        if order == 0 {
            return;
        }
        let first = order == 1;
        let wanted = self.rows();
        match self.kind.entry().translation {
            Translation::Free => {}
            Translation::Equal => {
                (0..3).for_each(|i| evaluation.add_difference(i, XS + i, XM + i, order));
            }
            Translation::Carried => {
                (0..3).for_each(|i| evaluation.add_difference(i, XS + i, XM + i, order));
                if first {
                    self.add_carried::<R::Gradient<3>>(state, evaluation);
                } else {
                    self.add_carried::<R::Hessian<3>>(state, evaluation);
                }
            }
            Translation::Distance if first => self.add_stretch::<R::Gradient<3>>(state, evaluation),
            Translation::Distance => self.add_stretch::<R::Hessian<3>>(state, evaluation),
        }
        if wanted[RHO + 2] {
            match (self.hinges(), first) {
                (0, true) => self.add_violation::<R::Gradient<6>, 6>(state, evaluation),
                (0, false) => self.add_violation::<R::Hessian<6>, 6>(state, evaluation),
                (1, true) => self.add_violation::<R::Gradient<7>, 7>(state, evaluation),
                (1, false) => self.add_violation::<R::Hessian<7>, 7>(state, evaluation),
                (_, true) => self.add_violation::<R::Gradient<8>, 8>(state, evaluation),
                (_, false) => self.add_violation::<R::Hessian<8>, 8>(state, evaluation),
            }
        }
        if wanted[FLOW] {
            evaluation.add_difference(FLOW, PSI_S, PSI_M, order);
        }
        for row in (0..ROWS).filter(|row| !wanted[*row]) {
            (evaluation.jacobian[row], evaluation.hessian[row]) = (None, None);
        }
    }

    fn add_carried<S: Seeded<3, Real = R>>(&self, state: &State<R>, evaluation: &mut Evaluation<R>) {
        let theta = [0, 1, 2].map(|i| S::seed(R::ZERO, i));
        let places = [0, 1, 2].map(|i| (THETA_M + i, None));
        for (row, equation) in self.carried(state, theta).into_iter().enumerate() {
            evaluation.add(row, equation, places);
        }
    }

    fn add_stretch<S: Seeded<3, Real = R>>(&self, state: &State<R>, evaluation: &mut Evaluation<R>) {
        let moved = [0, 1, 2].map(|i| S::seed(R::ZERO, i));
        let places = [0, 1, 2].map(|i| (XS + i, Some(XM + i)));
        evaluation.add(0, self.stretch(state, moved), places);
    }

    fn add_violation<S: Seeded<N, Real = R>, const N: usize>(
        &self,
        state: &State<R>,
        evaluation: &mut Evaluation<R>,
    ) {
        let zero = R::ZERO;
        let moved: [S; 8] = std::array::from_fn(|i| if i < N { S::seed(zero, i) } else { S::zero() });
        let places: [Place; N] = std::array::from_fn(|i| (OF_ROTATION[i], None));
        for (i, equation) in self.violation(state, evaluation.taken, moved).into_iter().enumerate() {
            evaluation.add(RHO + i, equation, places);
        }
    }
}
