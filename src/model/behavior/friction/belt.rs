//! Friction of a belt around a ring: two SLIPRINGs that share a node.
//!
//! The node is b of the first segment (tension T1) and a of the second (T2). Material flows past it by Ψ. The friction force F
//! (CSF2 of the first segment) acts on that flow, so that on degree of freedom 10 of the node T1 − T2 + F = 0, and
//!
//! ```text
//! |F| ≤ min(T1, T2) (exp(μ α) − 1),      which is max(T1, T2) ≤ min(T1, T2) exp(μ α)
//! ```
//!
//! with the angle of wrap α. F > 0 resists growth of Ψ: then T2 = T1 + F exceeds T1. The update takes the tension on the side
//! from which the material comes (T1 for F > 0, T2 for F < 0): in equilibrium that is the smaller one, and the limit has no
//! kink where T1 = T2.

use crate::behavior::Conditions;
use crate::behavior::friction::coefficient::Coefficient;
use crate::behavior::friction::criterion::{Derivatives, Point, parts};
use crate::behavior::friction::flags::{Flag, Flags};
use crate::behavior::friction::root::slip_increment;
use crate::behavior::friction::stick::{Limit, Stick, StickStiffness};
use crate::behavior::friction::update::{Branch, FrictionOutcome, State, Status, THRESHOLD};
use crate::behavior::friction::{Context, Ordered, capped, is_finite, is_zero};
use pintle_kinematics::Differentiable;
use pintle_kinematics::scalar::Duals;
use pintle_kinematics::scalar::elementary::{abs, atan2, direction, exp_m1, norm, recip};
use pintle_kinematics::scalar::{Real, Scalar, Seeded};
use pintle_kinematics::vector::{Vector, cross, dot, sub};
use serde::Serialize;

/// The friction of a belt around a ring.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Belt {
    /// μ. A table's contact force is the smaller tension.
    pub coefficient: Coefficient,
    /// τ_max, the largest friction force.
    pub maximum: Option<f64>,
    /// K_s, force over flow.
    pub stick_stiffness: StickStiffness,
}

/// The component that slides: u2 of SLIPRING, the flow past b (0-based).
pub const FLOW: usize = 1;

/// An increment.
#[derive(Clone, Debug)]
pub struct BeltInput<'a, S: Scalar> {
    /// ΔΨ of the shared node.
    pub flow: S,
    /// T1 and T2 at the end.
    pub tension: [S; 2],
    /// α (rad): given, zero (the default in Standard), or [`wrap_angle`] (the default in Explicit).
    pub angle: S,
    /// Δt, if the increment has a duration.
    pub duration: Option<S>,
    /// Temperature and field variables.
    pub conditions: &'a Conditions,
}

/// The exact consistent tangent: derivatives of F.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BeltTangent<R> {
    /// ∂F/∂ΔΨ.
    pub flow: R,
    /// ∂F/∂T1, ∂F/∂T2.
    pub tension: [R; 2],
    /// ∂F/∂α.
    pub angle: R,
    /// ∂F/∂Δt; zero without a duration.
    pub duration: R,
}

/// The angle of wrap in [0, π] of a belt from `before` over `ring` to `after`: the angle between the directions
/// of its segments, zero when they are in line.
///
/// ```
/// use pintle_model::behavior::friction::wrap_angle;
/// let (angle, _) = wrap_angle([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]);
/// assert_eq!(angle, std::f64::consts::FRAC_PI_2);
/// ```
pub fn wrap_angle<S>(before: Vector<S>, ring: Vector<S>, after: Vector<S>) -> (S, Vec<Flag>)
where
    S: Scalar,
    S::Real: Ordered,
{
    let (first, second) = (direction(sub(ring, before)), direction(sub(after, ring)));
    let sine = norm(cross(first, second));
    let angle = atan2(sine, dot(first, second));
    let mut flags = Vec::new();
    if is_zero(sine.real()) {
        let is_folded = dot(first, second).real().less(S::Real::ZERO);
        flags.push(Flag::WrapAngle { angle: if is_folded { std::f64::consts::PI } else { 0.0 } });
    }
    (angle, flags)
}

const INPUTS: usize = 5;

impl Belt {
    /// P = |T2 − T1|, the limit and Φ at given tensions and angle of wrap: the documented criterion. `normal` and `contact` are
    /// min(T1, T2), which must not be negative.
    pub fn at<S>(&self, tension: [S; 2], angle: S, coefficient: S) -> (Point<S>, Vec<Flag>)
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let mut flags = Flags::default();
        let [first, second] = tension;
        let tangential = abs(second - first);
        if is_zero(tangential.real()) {
            flags.add(Flag::NoTraction);
        }
        let least = if second.real().less(first.real()) { second } else { first };
        let (held, growth) = (positive(least, &mut flags), exp_m1(coefficient * angle));
        let limit = capped(times(held, growth), self.maximum, &mut flags);
        (Point { tangential, contact: held, normal: held, criterion: tangential - limit }, flags.into_vec())
    }

    pub(super) fn derivatives_any<R: Ordered + Differentiable>(
        &self,
        tension: [R; 2],
        angle: R,
        coefficient: R,
    ) -> (Point<Derivatives<R>>, Vec<Flag>) {
        let seed = <R as Duals>::Hessian::<6>::seed;
        let [first, second] = tension;
        let (point, flags) =
            self.at([seed(first, 0), seed(second, 1)], seed(angle, 2), Scalar::from_real(coefficient));
        (parts::<R>(point), flags)
    }

    pub(super) fn tangent_any<R: Ordered + Differentiable>(
        &self,
        state: &State<R>,
        input: &BeltInput<'_, R>,
        branch: Branch,
    ) -> (FrictionOutcome<R>, BeltTangent<R>) {
        let seed = <R as Duals>::Gradient::<INPUTS>::seed;
        let seeded = BeltInput {
            flow: seed(input.flow, 0),
            tension: [seed(input.tension[0], 1), seed(input.tension[1], 2)],
            angle: seed(input.angle, 3),
            duration: input.duration.map(|duration| seed(duration, 4)),
            conditions: input.conditions,
        };
        let dual = self.advance(state, &seeded, branch);
        let [flow, first, second, angle, duration] = dual.force[FLOW].gradient();
        let tangent = BeltTangent { flow, tension: [first, second], angle, duration };
        (dual.map(|x| x.real()), tangent)
    }

    /// μ, the limit and the slip rate after the slip Δγ.
    fn limit<S>(&self, held: S, input: &BeltInput<'_, S>, increment: S, flags: &mut Flags) -> (S, Limit<S>, S)
    where
        S: Scalar,
        S::Real: Ordered + Differentiable,
    {
        let context = Context { conditions: input.conditions, ..Context::default() };
        let rate = match input.duration {
            Some(duration) if S::Real::ZERO.less(duration.real()) => increment * recip(duration),
            _ => {
                if self.coefficient.depends_on_rate() {
                    flags.add(Flag::NoDuration);
                }
                S::zero()
            }
        };
        let coefficient = self.coefficient.evaluate(rate, held, &context, flags);
        let growth = exp_m1(coefficient * input.angle);
        let factors = if is_zero(held.real()) { [S::zero(); 2] } else { [held, growth] };
        (coefficient, Limit::new(factors, self.maximum, flags), rate)
    }

    pub(super) fn advance<S>(
        &self,
        state: &State<S::Real>,
        input: &BeltInput<'_, S>,
        branch: Branch,
    ) -> FrictionOutcome<S>
    where
        S: Scalar,
        S::Real: Ordered + Differentiable,
    {
        const { assert!(S::ORDER <= 1, "the slip equations are differentiated once") }
        let mut flags = Flags::default();
        let zero = S::Real::ZERO;
        // With no force yet, the direction is that of the flow.
        let carried = S::from_real(state.force[FLOW]);
        let is_backward = {
            let towards = match (self.stick_stiffness, state.stick_stiffness) {
                (StickStiffness::Given(stiffness), _) => {
                    state.force[FLOW] + S::Real::from_f64(stiffness) * input.flow.real()
                }
                (StickStiffness::ElasticSlip(_), Some(stiffness)) => {
                    state.force[FLOW] + stiffness * input.flow.real()
                }
                (StickStiffness::ElasticSlip(_), None) => input.flow.real(),
            };
            towards.less(zero)
        };
        let held = positive(if is_backward { input.tension[1] } else { input.tension[0] }, &mut flags);
        let (_, limit_at_rest, _) = self.limit(held, input, S::zero(), &mut flags);
        let at_rest = limit_at_rest.value();
        let is_held = zero.less(at_rest.real());
        let stick = self.stick_stiffness.stick(state.stick_stiffness, &limit_at_rest);
        let stiffness = stick.map(|stick| stick.stiffness());
        let trial = stiffness.map_or(carried, |stiffness| carried + stiffness * input.flow);
        let sign = S::Real::integer(if is_backward { -1 } else { 1 });
        let magnitude = trial.scale(sign);
        let excess = magnitude - at_rest;
        let status = match branch {
            Branch::Stick => Status::Stick,
            _ if !is_held => Status::Free,
            Branch::Slip => Status::Slip,
            Branch::Decided if zero.less(excess.real()) => Status::Slip,
            Branch::Decided => Status::Stick,
        };
        if is_held && !(S::Real::from_f64(THRESHOLD) * at_rest.real()).less(excess.real().magnitude()) {
            flags.add(Flag::Threshold);
        }
        let stretched = |stick: Stick<S>| (stick.stretch_of(state.force[FLOW]) + input.flow).scale(sign);
        let (force, increment) = match (status, stick) {
            (Status::Stick, _) => (trial, S::zero()),
            (Status::Free, None) | (Status::Slip, None) => (S::zero(), abs(input.flow)),
            (Status::Free, Some(stick)) => (S::zero(), abs(stretched(stick))),
            (Status::Slip, Some(stick)) => {
                let stretched = (stretched(stick), excess.real() / stick.stiffness().real());
                let increment = self.slip(held, input, stretched, &stick, &mut flags);
                let (_, limit, _) = self.limit(held, input, increment, &mut flags);
                (limit.value().scale(sign), increment)
            }
        };
        let (coefficient, limit, slip_rate) = self.limit(held, input, increment, &mut flags);
        let limit = limit.value();
        let stored = stiffness.map_or_else(S::zero, |stiffness| {
            (force * (force * recip(stiffness))).scale(S::Real::ratio(1, 2))
        });
        for (x, quantity) in [(force, "friction force"), (limit, "limit"), (increment, "slip increment")] {
            if !is_finite(x.real()) {
                flags.add(Flag::NotFinite { quantity });
            }
        }
        let along = |x: S| [S::zero(), x, S::zero(), S::zero(), S::zero(), S::zero()];
        FrictionOutcome {
            status,
            force: along(force),
            tangential: abs(force),
            contact: held,
            normal: held,
            coefficient,
            limit,
            criterion: abs(force) - limit,
            trial: excess,
            slip_increment: increment,
            slip: along(increment.scale(sign)),
            accumulated_slip: S::from_real(state.accumulated_slip) + increment,
            slip_rate,
            dissipation: abs(force) * increment,
            stored,
            stick_stiffness: stiffness,
            flags: flags.into_vec(),
        }
    }

    /// Δγ from |F_tr|/K − Δγ = L(Δγ)/K, of |F_tr|/K and what of it is beyond L(0)/K as the forces have it.
    fn slip<S>(
        &self,
        held: S,
        input: &BeltInput<'_, S>,
        (trial, beyond): (S, S::Real),
        stick: &Stick<S>,
        flags: &mut Flags,
    ) -> S
    where
        S: Scalar,
        S::Real: Ordered + Differentiable,
    {
        type Slope<R> = <R as Duals>::Gradient<1>;
        let constant = |x: S| Slope::<S::Real>::from_real(x.real());
        let fixed = BeltInput {
            flow: constant(input.flow),
            tension: input.tension.map(constant),
            angle: constant(input.angle),
            duration: input.duration.map(constant),
            conditions: input.conditions,
        };
        let still = stick.map(constant);
        let along = |slip: S::Real| {
            let (_, limit, _) =
                self.limit(constant(held), &fixed, Slope::<S::Real>::seed(slip, 0), &mut Flags::default());
            let limit = still.stretch_at(&limit);
            (limit.real(), limit.gradient()[0])
        };
        let duration = input.duration.map(Scalar::real);
        let rates = self.coefficient.rates().into_iter();
        let breaks = rates.filter_map(|rate| Some(S::Real::from_f64(rate) * duration?));
        let limit = |slip: S| stick.stretch_at(&self.limit(held, input, slip, &mut Flags::default()).1);
        let at_rest = limit(S::zero());
        let excess = (trial - at_rest).with_real(beyond);
        let rise_and_slope = |slip: S::Real| {
            let (limit, slope) = along(slip);
            (limit - at_rest.real(), slope)
        };
        slip_increment(excess, trial.real(), breaks, rise_and_slope, |slip| limit(slip) - at_rest, flags)
    }
}

/// A tension, or zero where a segment is slack.
fn positive<S>(tension: S, flags: &mut Flags) -> S
where
    S: Scalar,
    S::Real: Ordered,
{
    // What is no number stays one, and is told.
    let is_slack = tension.real().less(S::Real::ZERO) || is_zero(tension.real());
    if !is_slack {
        return tension;
    }
    flags.add(Flag::Slack);
    S::zero()
}

/// x y, zero where x is: a slack belt carries no friction however often it is wound.
fn times<S>(x: S, y: S) -> S
where
    S: Scalar,
    S::Real: Ordered,
{
    if is_zero(x.real()) { S::zero() } else { x * y }
}
