//! The slip equations of an increment: f and Δγ on real numbers, then their derivatives.
//!
//! With t = f/K, p(t) = P(K t)/K and ℓ = L/K they are t_k = t_tr,k − R_k² Δγ ∂P/∂f_k and p(t) = ℓ(Δγ), in lengths.

use crate::behavior::friction::derived::Potential;
use crate::behavior::friction::flags::{Flag, Flags};
use crate::behavior::friction::root::{Equations, SLOTS, slip_increment};
use crate::behavior::friction::stick::{Limit, Stick};
use crate::behavior::friction::stretch::Stretch;
use crate::behavior::friction::update::{Friction, Input};
use crate::behavior::friction::{Context, Ordered, is_zero, largest};
use crate::behavior::table::Variable;
use pintle_kinematics::Differentiable;
use pintle_kinematics::scalar::Duals;
use pintle_kinematics::scalar::elementary::{direction, norm, recip};
use pintle_kinematics::scalar::{Real, Scalar, Seeded};

/// A solution of the slip equations.
pub(super) struct Slip<S> {
    pub(super) force: [S; 6],
    pub(super) increment: S,
    pub(super) slip: [S; 6],
}

/// The slip equations at some forces and slip: their matrix, what is left of them, and their unknowns.
struct Linearised<R> {
    equations: Equations<R>,
    residual: [R; SLOTS],
    stretch: Stretch<R>,
}

/// An increment that slips.
pub(super) struct Problem<'a, 'b, S: Scalar> {
    pub(super) friction: &'a Friction,
    /// The slip accumulated before.
    pub(super) before: S::Real,
    pub(super) input: &'a Input<'b, S>,
    pub(super) contact: S,
    /// t_tr.
    pub(super) trial: [S; 6],
    pub(super) stick: Stick<S>,
    pub(super) radii: &'a [(usize, S::Real)],
}

impl<S> Problem<'_, '_, S>
where
    S: Scalar,
    S::Real: Ordered + Differentiable,
{
    /// L after the slip Δγ.
    fn limit(&self, increment: S, flags: &mut Flags) -> Limit<S> {
        self.friction.limit(self.contact, self.before, self.input, increment, flags).limit
    }

    /// ℓ after the slip Δγ.
    fn limit_stretch(&self, increment: S, flags: &mut Flags) -> S {
        self.stick.stretch_at(&self.limit(increment, flags))
    }

    /// ℓ after a real slip and its derivative, everything else being fixed.
    fn limit_and_slope(&self, increment: S::Real) -> (S::Real, S::Real) {
        type Slope<R> = <R as Duals>::Gradient<1>;
        let constant = |x: S| Slope::<S::Real>::from_real(x.real());
        let input = self.input.map(constant);
        let seeded = Slope::<S::Real>::seed(increment, 0);
        let limited =
            self.friction.limit(constant(self.contact), self.before, &input, seeded, &mut Flags::default());
        let limit = self.stick.map(constant).stretch_at(&limited.limit);
        (limit.real(), limit.gradient()[0])
    }

    /// The slips at which the slope of the limit may change.
    fn breaks(&self) -> impl Iterator<Item = S::Real> {
        let duration = self.input.duration.map(Scalar::real);
        let rates = self.friction.coefficient.rates().into_iter();
        let of_rates = rates.filter_map(move |rate| Some(S::Real::from_f64(rate) * duration?));
        let before = self.before;
        let column = self.friction.criterion.internal.slip_column().into_iter();
        let rows = column.flat_map(|(table, column)| table.rows(Variable::Column(column)));
        of_rates.chain(rows.map(move |row| S::Real::from_f64(row) - before))
    }

    /// P is a norm: f = (L/P(f_tr)) f_tr and p(t_tr) − Δγ = ℓ(Δγ).
    ///
    /// `excess` is P(f_tr) − L(0) as the forces have it, by which slip was told from stick: derivatives are those of p − ℓ(0).
    pub(super) fn radial(&self, excess: S::Real, flags: &mut Flags) -> Slip<S> {
        let mut scaled = [S::zero(); 6];
        for (k, radius) in self.radii {
            scaled[*k] = self.trial[*k].scale(S::Real::integer(1) / *radius);
        }
        let at_rest = self.limit_stretch(S::zero(), &mut Flags::default());
        let magnitude = norm(scaled);
        let increment = slip_increment(
            (magnitude - at_rest).with_real(excess / self.stick.stiffness().real()),
            magnitude.real(),
            self.breaks(),
            |slip| {
                let (limit, slope) = self.limit_and_slope(slip);
                (limit - at_rest.real(), slope)
            },
            |slip| self.limit_stretch(slip, &mut Flags::default()) - at_rest,
            flags,
        );
        let limit = self.limit(increment, flags).value();
        let along = direction(scaled);
        let (mut force, mut slip) = ([S::zero(); 6], [S::zero(); 6]);
        for (k, radius) in self.radii {
            force[*k] = (along[*k] * limit).scale(*radius);
            slip[*k] = (along[*k] * increment).scale(S::Real::integer(1) / *radius);
        }
        Slip { force, increment, slip }
    }

    /// P is a potential: f against its gradient at f, by Newton's method on f and Δγ together: from stick, then from what lies
    /// along the traction.
    pub(super) fn against(&self, potential: &Potential, flags: &mut Flags) -> Slip<S> {
        let size = largest(&self.trial.map(Scalar::real));
        let limit = self.limit_and_slope(S::Real::ZERO).0;
        let (mut stretched, mut increment) = (self.trial.map(Scalar::real), S::Real::ZERO);
        let magnitude = self.magnitude(potential, &mut Flags::default()).real();
        if Stretch::new(potential, magnitude, size, self.stick.stiffness().real()).is_any() {
            // Without a slip small tractions would be sent far over zero.
            let share = limit / magnitude;
            stretched = stretched.map(|x| x * share);
            increment = self.elastic_slip(potential).real() * (S::Real::integer(1) - share);
        }
        let scales = (size, limit);
        let (stretched, increment) = match self.newton(potential, scales, (stretched, increment)) {
            Some(solution) => solution,
            None => {
                let mut seen = Flags::default();
                let along = self.along_traction(potential, &mut seen);
                let (t, slip) = along;
                let start = (t.map(Scalar::real), slip.real());
                let Some(solution) = self.newton(potential, scales, start) else {
                    flags.add(Flag::ReturnedAlongTraction);
                    seen.into_vec().into_iter().for_each(|flag| flags.add(flag));
                    return self.returned(t, slip);
                };
                solution
            }
        };
        let (unit, context) = (self.stick.stiffness().real(), self.input.context.map(Scalar::real));
        for term in potential.infinitely_curved(&stretched, unit, &context) {
            flags.add(Flag::InfiniteCurvature { term });
        }
        self.lifted(potential, scales, stretched, increment, flags)
    }

    /// p(t_tr).
    fn magnitude(&self, potential: &Potential, flags: &mut Flags) -> S {
        potential.evaluate(&self.trial, self.stick.stiffness(), &self.input.context, flags)
    }

    /// f = K t, and the slip of each component, (t_tr,k − t_k)/R_k².
    fn returned(&self, t: [S; 6], increment: S) -> Slip<S> {
        let stiffness = self.stick.stiffness();
        let (mut force, mut slip) = ([S::zero(); 6], [S::zero(); 6]);
        for (k, radius) in self.radii {
            force[*k] = stiffness * t[*k];
            slip[*k] = (self.trial[*k] - t[*k]).scale(S::Real::integer(1) / (*radius * *radius));
        }
        Slip { force, increment, slip }
    }

    /// The unknowns t_k/size, or what stands for it, and Δγ/size; the residuals of the flow, over size, and of p = ℓ, over the limit.
    fn linearised(
        &self,
        potential: &Potential,
        (size, scale): (S::Real, S::Real),
        t: &[S::Real; 6],
        increment: S::Real,
    ) -> Linearised<S::Real> {
        let n = self.radii.len();
        let zero = S::Real::ZERO;
        let unit = self.stick.stiffness().real();
        let seeded = [0, 1, 2, 3, 4, 5].map(|k| <S::Real as Duals>::Hessian::<6>::seed(t[k], k));
        let context = self.input.context.map(|x| Scalar::from_real(x.real()));
        let p = potential.evaluate(&seeded, Scalar::from_real(unit), &context, &mut Flags::default());
        let (gradient, hessian) = (p.gradient(), p.hessian());
        let (limit, slope) = self.limit_and_slope(increment);
        let flow = increment / size;
        let stretch = Stretch::new(potential, p.real(), size, unit);
        let mut jacobian = [[zero; SLOTS]; SLOTS];
        let mut residual = [zero; SLOTS];
        for (i, (k, radius)) in self.radii.iter().enumerate() {
            let square = *radius * *radius;
            residual[i] = (t[*k] - self.trial[*k].real()) / size + flow * square * gradient[*k];
            for (j, (l, _)) in self.radii.iter().enumerate() {
                let (rise, second) = (stretch.rise(*l, t[*l]), hessian[*k][*l]);
                jacobian[i][j] = if i == j {
                    rise + flow * square * stretch.curvature(*k, t[*k], second)
                } else {
                    flow * square * second * size * rise
                };
            }
            jacobian[i][n] = square * gradient[*k];
            jacobian[n][i] = gradient[*k] * (size / scale) * stretch.rise(*k, t[*k]);
        }
        residual[n] = (p.real() - limit) / scale;
        jacobian[n][n] = -slope * (size / scale);
        Linearised { equations: Equations { jacobian, n: n + 1 }, residual, stretch }
    }

    /// t and Δγ, as real numbers, from a first guess; none where Newton's method with backtracking ends short of a solution.
    fn newton(
        &self,
        potential: &Potential,
        (size, scale): (S::Real, S::Real),
        start: ([S::Real; 6], S::Real),
    ) -> Option<([S::Real; 6], S::Real)> {
        /// A residual this small is a solution, to rounding.
        const SOLVED: f64 = 1e-11;
        const STEPS: usize = 60;
        const HALVINGS: usize = 40;
        let zero = S::Real::ZERO;
        let (mut t, mut increment) = start;
        let mut here = self.linearised(potential, (size, scale), &t, increment);
        let size_of = |of: &Linearised<S::Real>| of.residual.iter().fold(zero, |sum, x| sum + x.magnitude());
        let mut error = size_of(&here);
        for _ in 0..STEPS {
            let step = here.equations.solve(&here.residual)?;
            let mut fraction = S::Real::integer(1);
            let mut found = None;
            for _ in 0..HALVINGS {
                let mut tried = t;
                for (i, (k, _)) in self.radii.iter().enumerate() {
                    tried[*k] = here.stretch.stepped(*k, tried[*k], fraction * step[i]);
                }
                let slip = increment - fraction * step[self.radii.len()] * size;
                let there = self.linearised(potential, (size, scale), &tried, slip);
                let left = size_of(&there);
                if left.less(error) {
                    found = Some((tried, slip, there, left));
                    break;
                }
                fraction = fraction * S::Real::ratio(1, 2);
            }
            let Some(found) = found else { break };
            (t, increment, here, error) = found;
            if is_zero(error) {
                break;
            }
        }
        // What is tiny beside other unknowns is as exact as they are only after a step that their rounding hides.
        if !is_zero(error)
            && let Some(step) = here.equations.solve(&here.residual)
        {
            let mut last = t;
            for (i, (k, _)) in self.radii.iter().enumerate() {
                last[*k] = here.stretch.stepped(*k, last[*k], step[i]);
            }
            let slip = increment - step[self.radii.len()] * size;
            let left = size_of(&self.linearised(potential, (size, scale), &last, slip));
            if !(error + error).less(left) {
                (t, increment, error) = (last, slip, left);
            }
        }
        let is_solved = error.less(S::Real::from_f64(SOLVED)) && !increment.less(zero);
        is_solved.then_some((t, increment))
    }

    /// One Newton step on the scalar at the real solution: derivatives of t and Δγ.
    fn lifted(
        &self,
        potential: &Potential,
        (size, scale): (S::Real, S::Real),
        t: [S::Real; 6],
        increment: S::Real,
        flags: &mut Flags,
    ) -> Slip<S> {
        let n = self.radii.len();
        let constant = t.map(S::from_real);
        let p = potential.evaluate(&constant, self.stick.stiffness(), &self.input.context, flags);
        let limit = self.limit_stretch(S::from_real(increment), flags);
        let gradient = self.gradient(potential, &t);
        let Linearised { equations, stretch, .. } = self.linearised(potential, (size, scale), &t, increment);
        let mut residual = [S::zero(); SLOTS];
        for (i, (k, radius)) in self.radii.iter().enumerate() {
            let flow = gradient[*k].scale(*radius * *radius * increment / size);
            residual[i] = (constant[*k] - self.trial[*k]).scale(S::Real::integer(1) / size) + flow;
        }
        residual[n] = (p - limit).scale(S::Real::integer(1) / scale);
        let step = equations.solve(&residual).unwrap_or([S::zero(); SLOTS]);
        if !falls(&equations, n) {
            flags.add(Flag::Unstable);
        }
        let mut end = constant;
        for (i, (k, _)) in self.radii.iter().enumerate() {
            end[*k] = constant[*k] - step[i].scale(size * stretch.rise(*k, t[*k]));
        }
        let increment = S::from_real(increment) - step[n].scale(size);
        let is_negative = increment.real().less(S::Real::ZERO);
        let increment = if is_negative { increment.with_real(S::Real::ZERO) } else { increment };
        self.returned(end, increment)
    }

    /// ∂P/∂f at real t, as K moves, and as the scale factors of derived components move with the context.
    fn gradient(&self, potential: &Potential, t: &[S::Real; 6]) -> [S; 6] {
        type First<R> = <R as Duals>::Gradient<6>;
        type Mixed<R> = <R as Duals>::Hessian<2>;
        let seeded = [0, 1, 2, 3, 4, 5].map(|k| First::<S::Real>::seed(t[k], k));
        let (context, stiffness) = (&self.input.context, self.stick.stiffness());
        let still = context.map(|x| First::<S::Real>::from_real(x.real()));
        let unit = First::<S::Real>::from_real(stiffness.real());
        let p = potential.evaluate(&seeded, unit, &still, &mut Flags::default());
        let mut lifted = p.gradient().map(S::from_real);
        if S::ORDER == 0 {
            return lifted;
        }
        for (k, _) in self.radii {
            let mut turned = t.map(Mixed::<S::Real>::from_real);
            turned[*k] = Mixed::<S::Real>::seed(t[*k], 0);
            let mixed = |unit: Mixed<S::Real>, context: &Context<'_, Mixed<S::Real>>| {
                potential.evaluate(&turned, unit, context, &mut Flags::default()).hessian()[0][1]
            };
            let mut moving = context.map(|x| Mixed::<S::Real>::from_real(x.real()));
            let by_stiffness = mixed(Mixed::<S::Real>::seed(stiffness.real(), 1), &moving);
            lifted[*k] = lifted[*k] + stiffness.nilpotent().scale(by_stiffness);
            if !potential.moves() {
                continue;
            }
            let unit = Mixed::<S::Real>::from_real(stiffness.real());
            for j in 0..6 {
                moving.position[j] = Mixed::<S::Real>::seed(context.position[j].real(), 1);
                let by_position = mixed(unit, &moving);
                moving.position[j] = Mixed::<S::Real>::from_real(context.position[j].real());
                moving.motion[j] = Mixed::<S::Real>::seed(context.motion[j].real(), 1);
                let by_motion = mixed(unit, &moving);
                moving.motion[j] = Mixed::<S::Real>::from_real(context.motion[j].real());
                lifted[*k] = lifted[*k]
                    + context.position[j].nilpotent().scale(by_position)
                    + context.motion[j].nilpotent().scale(by_motion);
            }
        }
        lifted
    }

    /// Σ (t_tr,k/R_k)²/p(t_tr), formed without squaring large numbers.
    fn elastic_slip(&self, potential: &Potential) -> S {
        let inverse = recip(self.magnitude(potential, &mut Flags::default()));
        let mut whole = S::zero();
        for (k, radius) in self.radii {
            let elastic = self.trial[*k].scale(S::Real::integer(1) / (*radius * *radius));
            whole = whole + elastic * (self.trial[*k] * inverse);
        }
        whole
    }

    /// t = s t_tr with p(t) = ℓ and the slip that this takes, Δγ = (1 − s) Σ (t_tr,k/R_k)²/p(t_tr): by bisection, which cannot
    /// fail.
    fn along_traction(&self, potential: &Potential, flags: &mut Flags) -> ([S; 6], S) {
        let (zero, one) = (S::Real::ZERO, S::Real::integer(1));
        let (whole, unit) = (self.elastic_slip(potential), self.stick.stiffness());
        let excess = |share: S, flags: &mut Flags| {
            let increment = (S::one() - share) * whole;
            let p = potential.evaluate(&self.trial.map(|x| x * share), unit, &self.input.context, flags);
            p - self.limit_stretch(increment, flags)
        };
        let mut unseen = Flags::default();
        let (mut low, mut high) = (zero, one);
        if zero.less(excess(S::zero(), &mut unseen).real()) {
            flags.add(Flag::NoAdmissibleTraction);
            high = zero;
        } else {
            loop {
                let middle = low + (high - low) * S::Real::ratio(1, 2);
                if !(low.less(middle) && middle.less(high)) {
                    break;
                }
                if zero.less(excess(S::from_real(middle), &mut unseen).real()) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
        }
        let share = low;
        let mut lifted = S::from_real(share);
        if zero.less(high) {
            type Slope<R> = <R as Duals>::Gradient<1>;
            let constant = |x: S| Slope::<S::Real>::from_real(x.real());
            let seeded = Slope::<S::Real>::seed(share, 0);
            let slip = (Slope::<S::Real>::one() - seeded).scale(whole.real());
            let context = self.input.context.map(constant);
            let t = self.trial.map(constant).map(|x| x * seeded);
            let p = potential.evaluate(&t, constant(unit), &context, &mut unseen);
            let input = self.input.map(constant);
            let limit =
                self.friction.limit(constant(self.contact), self.before, &input, slip, &mut unseen).limit;
            let slope = (p - self.stick.map(constant).stretch_at(&limit)).gradient()[0];
            lifted = lifted - excess(lifted, flags).scale(slope.reciprocal_or_zero());
        }
        (self.trial.map(|x| x * lifted), whole * (S::one() - lifted))
    }
}

/// Whether P − L falls as slip (unknown n) grows and the tractions follow, as far as rounding tells. Where the stick stiffness is
/// many orders stiffer than the limit, the slip is a difference of numbers that are as much larger.
fn falls<R: Ordered + Differentiable>(equations: &Equations<R>, n: usize) -> bool {
    let mut of_excess = [R::ZERO; SLOTS];
    of_excess[n] = R::integer(1);
    let Some(by) = equations.solve(&of_excess) else { return false };
    let mut row = 0;
    for i in 1..n {
        if equations.jacobian[row][n].magnitude().less(equations.jacobian[i][n].magnitude()) {
            row = i;
        }
    }
    let parts = (0..n).map(|j| (equations.jacobian[row][j] * by[j]).magnitude());
    let sum = parts.fold(R::ZERO, |sum, part| sum + part);
    let noise = sum * R::from_f64(4.0 * f64::EPSILON) / equations.jacobian[row][n].magnitude();
    by[n].less(noise)
}

#[cfg(test)]
mod tests {
    use super::falls;
    use crate::behavior::friction::root::{Equations, SLOTS};

    /// Rows that are orthogonal to (1, −1, y), and a third whose product with it is one: P − L grows by y. Rounding hides 4 ε (1 + 1) of it,
    /// in whatever unit a row is.
    #[test]
    fn what_rounding_hides_falls() {
        for unit in [1.0 / 16.0, 1.0, 16.0] {
            for (y, expected) in [(-1.0, true), (-1e-14, true), (8e-16, true), (3e-15, false), (1.0, false)] {
                let mut jacobian = [[0.0; SLOTS]; SLOTS];
                jacobian[0][..3].copy_from_slice(&[unit, unit * (1.0 + y), unit]);
                jacobian[1][..3].copy_from_slice(&[1.0, 1.0, 0.0]);
                jacobian[2][0] = 1.0;
                assert_eq!(falls(&Equations { jacobian, n: 3 }, 2), expected, "{unit} {y}");
            }
        }
    }
}
