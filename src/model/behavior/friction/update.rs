//! Stick and slip over an increment, with the exact consistent tangent.
//!
//! ```text
//! f_tr = f_n + K_k Δu_k                     each sliding component; K_k = K_s R_k² where R_k turns a moment into a force
//! P(f_tr) ≤ L:  stick, f = f_tr, Δγ = 0     L = min(μ F_N, τ_max) at no slip
//! else:         f_k = f_tr,k − K_k Δγ ∂P/∂f_k(f),  P(f) = L(Δγ)
//! ```
//!
//! They are solved in stretches of the springs of stick, t_k = f_k/K_s: K_s may be made of the same F_N as L, and what neither knows
//! is never multiplied in.
//!
//! L depends on Δγ where μ depends on the slip rate Δγ/Δt, or the internal contact force on the accumulated slip: the scalar
//! equation is solved, not lagged. For P a norm the return is radial. Where several Δγ satisfy it (a limit that falls with
//! slip), it is the first one met from stick. Derivatives come from one Newton step on dual numbers at the solution, which
//! makes them exact.

use crate::behavior::friction::coefficient::Coefficient;
use crate::behavior::friction::criterion::{Criterion, Tangential};
use crate::behavior::friction::flags::{Flag, Flags};
use crate::behavior::friction::slip::{Problem, Slip};
use crate::behavior::friction::stick::{Limit, StickStiffness};
use crate::behavior::friction::{Context, Ordered, is_finite, length};
use pintle_kinematics::Differentiable;
use pintle_kinematics::scalar::elementary::recip;
use pintle_kinematics::scalar::{Real, Scalar, Seeded};
use serde::{Deserialize, Serialize};

/// A trial traction this near to the limit, relative to it, is flagged.
pub const THRESHOLD: f64 = 1e-12;

/// One friction of a connector.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Friction {
    /// P, F_C, F_C^int.
    pub criterion: Criterion,
    /// μ.
    pub coefficient: Coefficient,
    /// τ_max, the largest friction force.
    pub maximum: Option<f64>,
    /// K_s.
    pub stick_stiffness: StickStiffness,
    /// The effective radius R of rotations in a potential: K = K_s R² there. 1 where the radii are those of the criterion.
    #[serde(deserialize_with = "crate::behavior::friction::read::radius")]
    pub radius: f64,
}

/// What a friction remembers from one increment to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<R> {
    /// The friction forces at the end of the last increment.
    pub force: [R; 6],
    /// The accumulated slip (CASU).
    pub accumulated_slip: R,
    /// K_s, once the default rule has set it.
    pub stick_stiffness: Option<R>,
}

impl<R: Real> Default for State<R> {
    fn default() -> Self {
        Self { force: [R::ZERO; 6], accumulated_slip: R::ZERO, stick_stiffness: None }
    }
}

/// An increment.
#[derive(Clone, Debug)]
pub struct Input<'a, S: Scalar> {
    /// Δu of the components; angles in radians.
    pub displacement: [S; 6],
    /// The forces from which F_C is formed, at the end: constraint forces, and in available components forces without
    /// friction.
    pub forces: [S; 6],
    /// Δt, if the increment has a duration.
    pub duration: Option<S>,
    /// Positions, motions, temperature and fields at the end. The accumulated slip of the context is not used.
    pub context: Context<'a, S>,
}

impl<'a, S: Scalar> Input<'a, S> {
    pub(super) fn map<T: Scalar<Real = S::Real>>(&self, to: impl Fn(S) -> T) -> Input<'a, T> {
        Input {
            displacement: self.displacement.map(&to),
            forces: self.forces.map(&to),
            duration: self.duration.map(&to),
            context: self.context.map(&to),
        }
    }
}

/// What the friction does in an increment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Φ < 0, or Φ = 0 from below: no slip at all.
    Stick,
    /// Φ = 0.
    Slip,
    /// The limit is zero: nothing holds.
    Free,
}

/// Which status to assume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Branch {
    /// The one that the criterion tells.
    #[default]
    Decided,
    /// Stick: at the threshold, the tangent from below.
    Stick,
    /// Slip: at the threshold, the tangent from above.
    Slip,
}

/// The result of an increment; that of a belt slides in component 2, the flow past b.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrictionOutcome<S> {
    /// Stick, slip or neither.
    pub status: Status,
    /// Friction forces (CSF1 … CSM3).
    pub force: [S; 6],
    /// P of the friction forces; the output CSFC of a coupled friction.
    pub tangential: S,
    /// F_C; of a belt the tension on the side from which the material comes.
    pub contact: S,
    /// F_N = |F_C + F_C^int| (CNF); of a belt the tension that holds.
    pub normal: S,
    /// μ.
    pub coefficient: S,
    /// min(μ F_N, τ_max); of a belt T (exp(μ α) − 1) in place of μ F_N.
    pub limit: S,
    /// Φ = P − limit after the update: negative in stick, zero to rounding in slip.
    pub criterion: S,
    /// Φ of the trial traction, with the limit without slip.
    pub trial: S,
    /// Δγ ≥ 0, in units of length (or rad); exactly zero in stick.
    pub slip_increment: S,
    /// The slip of each component, Δγ ∂P/∂f_k.
    pub slip: [S; 6],
    /// The accumulated slip (CASU).
    pub accumulated_slip: S,
    /// Δγ/Δt (CIVC); zero without a duration.
    pub slip_rate: S,
    /// Work lost in the increment, Σ f_k · slip_k.
    pub dissipation: S,
    /// Energy stored in stick, Σ f_k²/(2 K_k).
    pub stored: S,
    /// K_s; none while nothing ever pressed.
    pub stick_stiffness: Option<S>,
    /// What needs care.
    pub flags: Vec<Flag>,
}

impl<S: Copy> FrictionOutcome<S> {
    /// The same on another scalar.
    pub(super) fn map<T>(self, to: impl Fn(S) -> T) -> FrictionOutcome<T> {
        FrictionOutcome {
            status: self.status,
            force: self.force.map(&to),
            tangential: to(self.tangential),
            contact: to(self.contact),
            normal: to(self.normal),
            coefficient: to(self.coefficient),
            limit: to(self.limit),
            criterion: to(self.criterion),
            trial: to(self.trial),
            slip_increment: to(self.slip_increment),
            slip: self.slip.map(&to),
            accumulated_slip: to(self.accumulated_slip),
            slip_rate: to(self.slip_rate),
            dissipation: to(self.dissipation),
            stored: to(self.stored),
            stick_stiffness: self.stick_stiffness.map(&to),
            flags: self.flags,
        }
    }
}

impl<R: Real> FrictionOutcome<R> {
    /// Nothing presses and nothing is asked to slide: no force, and what was remembered stays.
    pub(crate) fn idle(state: &State<R>) -> Self {
        let zero = R::ZERO;
        Self {
            status: Status::Free,
            force: [zero; 6],
            tangential: zero,
            contact: zero,
            normal: zero,
            coefficient: zero,
            limit: zero,
            criterion: zero,
            trial: zero,
            slip_increment: zero,
            slip: [zero; 6],
            accumulated_slip: state.accumulated_slip,
            slip_rate: zero,
            dissipation: zero,
            stored: zero,
            stick_stiffness: state.stick_stiffness,
            flags: Vec::new(),
        }
    }

    /// What to remember.
    pub const fn state(&self) -> State<R> {
        State {
            force: self.force,
            accumulated_slip: self.accumulated_slip,
            stick_stiffness: self.stick_stiffness,
        }
    }
}

/// Derivatives of one result: with respect to Δu (6), to the forces that press (6) and to Δt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Partial<R> {
    /// ∂/∂Δu_k, positions and motions at the end moving along.
    pub displacement: [R; 6],
    /// ∂/∂f_k of the forces from which F_C is formed: −μ ∂F_N/∂λ in Φ, which makes the tangent unsymmetric.
    pub forces: [R; 6],
    /// ∂/∂Δt; zero without a duration.
    pub duration: R,
}

/// The exact consistent tangent of an increment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tangent<R> {
    /// Of each friction force.
    pub force: [Partial<R>; 6],
    /// Of Δγ.
    pub slip_increment: Partial<R>,
    /// Of F_N.
    pub normal: Partial<R>,
    /// Of the limit.
    pub limit: Partial<R>,
}

/// The number of inputs that a tangent is taken with respect to.
const INPUTS: usize = 13;

/// F_N, μ, the limit and the slip rate after some slip.
#[derive(Clone, Copy)]
pub(super) struct Limited<S> {
    normal: S,
    coefficient: S,
    pub(super) limit: Limit<S>,
    rate: S,
}

impl Friction {
    pub(super) fn tangent_any<R: Ordered + Differentiable>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        branch: Branch,
        failed: [bool; 6],
    ) -> (FrictionOutcome<R>, Tangent<R>) {
        let constant = R::Gradient::<INPUTS>::from_real;
        let mut seeded = input.map(constant);
        for k in 0..6 {
            let moved = R::Gradient::<INPUTS>::seed(R::ZERO, k);
            if !failed[k] {
                seeded.displacement[k] = seeded.displacement[k] + moved;
            }
            seeded.context.position[k] = seeded.context.position[k] + moved;
            seeded.context.motion[k] = seeded.context.motion[k] + moved;
            seeded.forces[k] = R::Gradient::seed(input.forces[k], 6 + k);
        }
        seeded.duration = input.duration.map(|duration| R::Gradient::seed(duration, INPUTS - 1));
        let dual = self.advance(state, &seeded, branch);
        let partial = |x: R::Gradient<INPUTS>| {
            let gradient = x.gradient();
            Partial {
                displacement: [0, 1, 2, 3, 4, 5].map(|k| gradient[k]),
                forces: [6, 7, 8, 9, 10, 11].map(|k| gradient[k]),
                duration: gradient[INPUTS - 1],
            }
        };
        let tangent = Tangent {
            force: dual.force.map(partial),
            slip_increment: partial(dual.slip_increment),
            normal: partial(dual.normal),
            limit: partial(dual.limit),
        };
        (dual.map(|x| x.real()), tangent)
    }

    /// R_k of each sliding component (from 0): K_k = K_s R_k².
    pub fn radii(&self) -> Vec<(usize, f64)> {
        match &self.criterion.tangential {
            Tangential::Norm(components) => components.clone(),
            Tangential::Potential(potential) => {
                let radius = |k: usize| if k >= 3 { self.radius } else { 1.0 };
                potential.components().into_iter().map(|k| (k, radius(k))).collect()
            }
        }
    }

    pub(super) fn limit_any<R: Ordered + Differentiable>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        increment: R,
    ) -> [R; 2] {
        let flags = &mut Flags::default();
        let contact = self.criterion.pressing.evaluate(&input.forces, &input.context, flags);
        let Limited { normal, limit, .. } =
            self.limit(contact, state.accumulated_slip, input, increment, flags);
        [normal, limit.value()]
    }

    /// F_N, μ and the limit after the slip Δγ.
    pub(super) fn limit<S>(
        &self,
        contact: S,
        accumulated_slip: S::Real,
        input: &Input<'_, S>,
        increment: S,
        flags: &mut Flags,
    ) -> Limited<S>
    where
        S: Scalar,
        S::Real: Ordered + Differentiable,
    {
        let context =
            Context { accumulated_slip: S::from_real(accumulated_slip) + increment, ..input.context.clone() };
        let normal = self.criterion.normal(contact, &context, flags);
        let rate = match input.duration {
            Some(duration) if S::Real::ZERO.less(duration.real()) => increment * recip(duration),
            _ => {
                if self.coefficient.depends_on_rate() {
                    flags.add(Flag::NoDuration);
                }
                S::zero()
            }
        };
        let coefficient = self.coefficient.evaluate(rate, normal, &context, flags);
        let limit = Limit::new([coefficient, normal], self.maximum, flags);
        Limited { normal, coefficient, limit, rate }
    }

    /// The increment on any scalar with at most first derivatives.
    pub(super) fn advance<S>(
        &self,
        state: &State<S::Real>,
        input: &Input<'_, S>,
        branch: Branch,
    ) -> FrictionOutcome<S>
    where
        S: Scalar,
        S::Real: Ordered + Differentiable,
    {
        const { assert!(S::ORDER <= 1, "the slip equations are differentiated once") }
        let mut flags = Flags::default();
        let zero = S::Real::ZERO;
        let radii: Vec<(usize, S::Real)> =
            self.radii().into_iter().map(|(k, radius)| (k, S::Real::from_f64(radius))).collect();
        let contact = self.criterion.pressing.evaluate(&input.forces, &input.context, &mut flags);
        let before = state.accumulated_slip;
        let at_rest = self.limit(contact, before, input, S::zero(), &mut flags);
        let most = at_rest.limit.value();
        let is_pressed = zero.less(most.real());
        let stick = self.stick_stiffness.stick(state.stick_stiffness, &at_rest.limit);
        let stiffness = stick.map(|stick| stick.stiffness());
        let (mut trial, mut stretched) = ([S::zero(); 6], [S::zero(); 6]);
        for (k, radius) in &radii {
            let turned = input.displacement[*k].scale(*radius * *radius);
            let elastic = stiffness.map_or_else(S::zero, |stiffness| stiffness * turned);
            trial[*k] = S::from_real(state.force[*k]) + elastic;
            stretched[*k] = stick.map_or_else(S::zero, |stick| stick.stretch_of(state.force[*k])) + turned;
        }
        let magnitude = self.criterion.tangential.evaluate(&trial, &input.context, &mut flags);
        let excess = magnitude - most;
        let status = match branch {
            Branch::Stick => Status::Stick,
            _ if !is_pressed => Status::Free,
            Branch::Slip => Status::Slip,
            Branch::Decided if zero.less(excess.real()) => Status::Slip,
            Branch::Decided => Status::Stick,
        };
        let distance = excess.real() / larger_or_one(most.real());
        if is_pressed && !S::Real::from_f64(THRESHOLD).less(distance.magnitude()) {
            flags.add(Flag::Threshold);
        }
        let solved = match (status, stick) {
            (Status::Stick, _) => Slip { force: trial, increment: S::zero(), slip: [S::zero(); 6] },
            (Status::Free, _) | (_, None) => freed(&radii, &stretched),
            (Status::Slip, Some(stick)) => {
                let problem = Problem {
                    friction: self,
                    before,
                    input,
                    contact,
                    trial: stretched,
                    stick,
                    radii: &radii,
                };
                match &self.criterion.tangential {
                    Tangential::Norm(_) => problem.radial(excess.real(), &mut flags),
                    Tangential::Potential(potential) => problem.against(potential, &mut flags),
                }
            }
        };
        let Slip { force, increment, slip } = solved;
        let end = self.limit(contact, before, input, increment, &mut flags);
        let limit = end.limit.value();
        let tangential = self.criterion.tangential.evaluate(&force, &input.context, &mut Flags::default());
        let half = S::Real::ratio(1, 2);
        let (mut dissipation, mut stored) = (S::zero(), S::zero());
        for (k, radius) in &radii {
            dissipation = dissipation + force[*k] * slip[*k];
            if let Some(stiffness) = stiffness {
                let inverse = recip(stiffness.scale(*radius * *radius));
                stored = stored + (force[*k] * (force[*k] * inverse)).scale(half);
            }
        }
        if dissipation.real().less(zero) {
            flags.add(Flag::NegativeDissipation);
        }
        let mut finite = |x: S, quantity: &'static str| {
            if !is_finite(x.real()) {
                flags.add(Flag::NotFinite { quantity });
            }
        };
        force.iter().for_each(|x| finite(*x, "friction force"));
        finite(limit, "limit");
        finite(increment, "slip increment");
        FrictionOutcome {
            status,
            force,
            tangential,
            contact,
            normal: end.normal,
            coefficient: end.coefficient,
            limit,
            criterion: tangential - limit,
            trial: excess,
            slip_increment: increment,
            slip,
            accumulated_slip: S::from_real(before) + increment,
            slip_rate: end.rate,
            dissipation,
            stored,
            stick_stiffness: stiffness,
            flags: flags.into_vec(),
        }
    }
}

/// Nothing holds: the force is zero, and all that stretches the springs is slip.
fn freed<S>(radii: &[(usize, S::Real)], stretched: &[S; 6]) -> Slip<S>
where
    S: Scalar,
    S::Real: Ordered + Differentiable,
{
    let mut slip = [S::zero(); 6];
    let mut scaled = [S::zero(); 6];
    for (k, radius) in radii {
        let inverse = S::Real::integer(1) / *radius;
        scaled[*k] = stretched[*k].scale(inverse);
        slip[*k] = scaled[*k].scale(inverse);
    }
    Slip { force: [S::zero(); 6], increment: length(&scaled), slip }
}

/// The limit as a scale for its own error.
fn larger_or_one<R: Ordered + Differentiable>(limit: R) -> R {
    if R::ZERO.less(limit) { limit } else { R::integer(1) }
}
