//! Stick and slip over an increment, with the exact consistent tangent.
//!
//! ```text
//! f_tr = f_n + K_k Δu_k                     each sliding component; K_k = K_s R_k² where R_k turns a moment into a force
//! P(f_tr) ≤ L:  stick, f = f_tr, Δγ = 0     L = min(μ F_N, τ_max) at no slip
//! else:         f_k = f_tr,k − K_k Δγ ∂P/∂f_k(f),  P(f) = L(Δγ)
//! ```
//!
//! L depends on Δγ where μ depends on the slip rate Δγ/Δt, or the internal contact force on the accumulated slip: the scalar
//! equation is solved, not lagged. For P a norm the return is radial. Where several Δγ satisfy it (a limit that falls with
//! slip), it is the first one met from stick. Derivatives come from one Newton step on dual numbers at the solution, which
//! makes them exact.

use super::coefficient::Coefficient;
use super::criterion::{Criterion, Tangential};
use super::derived::Potential;
use super::flags::{Flag, Flags};
use super::{Context, Ordered, capped, is_finite, is_zero, largest, length};
use crate::behavior::table::Variable;
use crate::scalar::elementary::{direction, recip};
use crate::scalar::{Differentiable, Real, Scalar, Seeded};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// The elastic slip allowed in stick by default, as a fraction of a characteristic length; in radians where the slip is an
/// angle (Abaqus/Standard; `SLIP TOLERANCE` replaces it).
pub const ELASTIC_SLIP: f64 = 1e-4;

/// A trial traction this near to the limit, relative to it, is flagged.
pub const THRESHOLD: f64 = 1e-12;

/// The stiffness of stick.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum StickStiffness {
    /// `STICK STIFFNESS`: K_s, in the unit of P over that of the slip.
    Given(f64),
    /// Our default rule \[R\]: K_s = L / s_el, with L the limit, without slip, of the first increment in which anything presses;
    /// kept from then on ([`State::stick_stiffness`]). `ElasticSlip(s_el)`, s_el = [`ELASTIC_SLIP`] · characteristic length.
    ElasticSlip(f64),
}

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
        Self { force: [R::integer(0); 6], accumulated_slip: R::integer(0), stick_stiffness: None }
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
    fn map<T: Scalar<Real = S::Real>>(&self, to: impl Fn(S) -> T) -> Input<'a, T> {
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
pub struct Outcome<S> {
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

impl<S: Copy> Outcome<S> {
    /// The same on another scalar.
    pub(super) fn map<T>(self, to: impl Fn(S) -> T) -> Outcome<T> {
        Outcome {
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

impl<R: Real> Outcome<R> {
    /// Nothing presses and nothing is asked to slide: no force, and what was remembered stays.
    pub(in crate::behavior) fn idle(state: &State<R>) -> Self {
        let zero = R::integer(0);
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

/// F_N, μ and the limit after some slip.
#[derive(Clone, Copy)]
struct Limit<S> {
    normal: S,
    coefficient: S,
    limit: S,
    rate: S,
}

/// A solution of the slip equations.
struct Slip<S> {
    force: [S; 6],
    increment: S,
    slip: [S; 6],
}

impl Friction {
    /// The increment from a state.
    pub fn update<R: Ordered + Differentiable>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        branch: Branch,
    ) -> Outcome<R> {
        self.advance(state, input, branch)
    }

    /// The increment from a state with its exact consistent tangent.
    ///
    /// ```
    /// use pintle::behavior::friction::{Branch, Coefficient, Context, Criterion, Friction, Input, State, Status, StickStiffness};
    /// use pintle::catalog::ConnectionType;
    /// let slot = ConnectionType::named("SLOT", None)?.friction.ok_or("no friction")?;
    /// let criterion = Criterion::predefined(&slot, &[], &[], false)?.remove(0);
    /// let stick_stiffness = StickStiffness::Given(1e4);
    /// let friction =
    ///     Friction { criterion, coefficient: Coefficient::Constant(0.5), maximum: None, stick_stiffness, radius: 1.0 };
    /// let input = Input {
    ///     displacement: [0.1, 0.0, 0.0, 0.0, 0.0, 0.0],
    ///     forces: [0.0, 3.0, 4.0, 0.0, 0.0, 0.0],
    ///     duration: None,
    ///     context: Context::default(),
    /// };
    /// let (outcome, tangent) = friction.tangent(&State::default(), &input, Branch::Decided);
    /// assert_eq!((outcome.status, outcome.force[0]), (Status::Slip, 2.5)); // μ F_N = 0.5 · 5
    /// assert_eq!(tangent.force[0].displacement[0], 0.0);
    /// assert_eq!(tangent.force[0].forces[1..3], [0.3, 0.4]); // μ ∂F_N/∂λ
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn tangent<R: Ordered + Differentiable>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        branch: Branch,
    ) -> (Outcome<R>, Tangent<R>) {
        self.tangent_while(state, input, branch, [false; 6])
    }

    /// The same where some components slide no more: their positions and motions move, and no slip follows.
    pub(crate) fn tangent_while<R: Ordered + Differentiable>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        branch: Branch,
        failed: [bool; 6],
    ) -> (Outcome<R>, Tangent<R>) {
        let constant = R::Gradient::<INPUTS>::from_real;
        let mut seeded = input.map(constant);
        for k in 0..6 {
            let moved = R::Gradient::<INPUTS>::seed(R::integer(0), k);
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
    pub(crate) fn radii(&self) -> Vec<(usize, f64)> {
        match &self.criterion.tangential {
            Tangential::Norm(components) => components.clone(),
            Tangential::Potential(potential) => {
                let radius = |k: usize| if k >= 3 { self.radius } else { 1.0 };
                potential.components().into_iter().map(|k| (k, radius(k))).collect()
            }
        }
    }

    /// F_N and the limit after the slip Δγ, at the contact force of an increment.
    pub(crate) fn limit_after<R: Ordered + Differentiable>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        increment: R,
    ) -> [R; 2] {
        let flags = &mut Flags::default();
        let contact = self.criterion.pressing.evaluate(&input.forces, &input.context, flags);
        let Limit { normal, limit, .. } =
            self.limit(contact, state.accumulated_slip, input, increment, flags);
        [normal, limit]
    }

    /// F_N, μ and the limit after the slip Δγ.
    fn limit<S>(
        &self,
        contact: S,
        accumulated_slip: S::Real,
        input: &Input<'_, S>,
        increment: S,
        flags: &mut Flags,
    ) -> Limit<S>
    where
        S: Scalar,
        S::Real: Ordered + Differentiable,
    {
        let context =
            Context { accumulated_slip: S::from_real(accumulated_slip) + increment, ..input.context.clone() };
        let normal = self.criterion.normal(contact, &context, flags);
        let rate = match input.duration {
            Some(duration) if S::Real::integer(0).less(duration.real()) => increment * recip(duration),
            _ => {
                if self.coefficient.depends_on_rate() {
                    flags.add(Flag::NoDuration);
                }
                S::zero()
            }
        };
        let coefficient = self.coefficient.evaluate(rate, normal, &context, flags);
        let limit = capped(coefficient * normal, self.maximum, flags);
        Limit { normal, coefficient, limit, rate }
    }

    /// The increment on any scalar with at most first derivatives.
    fn advance<S>(&self, state: &State<S::Real>, input: &Input<'_, S>, branch: Branch) -> Outcome<S>
    where
        S: Scalar,
        S::Real: Ordered + Differentiable,
    {
        const { assert!(S::ORDER <= 1, "the slip equations are differentiated once") }
        let mut flags = Flags::default();
        let zero = S::Real::integer(0);
        let radii: Vec<(usize, S::Real)> =
            self.radii().into_iter().map(|(k, radius)| (k, S::Real::from_f64(radius))).collect();
        let contact = self.criterion.pressing.evaluate(&input.forces, &input.context, &mut flags);
        let before = state.accumulated_slip;
        let at_rest = self.limit(contact, before, input, S::zero(), &mut flags);
        let is_pressed = zero.less(at_rest.limit.real());
        let stiffness = match (self.stick_stiffness, state.stick_stiffness) {
            (StickStiffness::Given(stiffness), _) => Some(S::from_real(S::Real::from_f64(stiffness))),
            (StickStiffness::ElasticSlip(_), Some(stiffness)) => Some(S::from_real(stiffness)),
            (StickStiffness::ElasticSlip(slip), None) => {
                is_pressed.then(|| at_rest.limit.scale(S::Real::integer(1) / S::Real::from_f64(slip)))
            }
        };
        let mut trial = [S::zero(); 6];
        for (k, radius) in &radii {
            let elastic = stiffness.map_or_else(S::zero, |stiffness| {
                stiffness * input.displacement[*k].scale(*radius * *radius)
            });
            trial[*k] = S::from_real(state.force[*k]) + elastic;
        }
        let context = Context { accumulated_slip: S::from_real(before), ..input.context.clone() };
        let magnitude = self.criterion.tangential.evaluate(&trial, &context, &mut flags);
        let excess = magnitude - at_rest.limit;
        let status = match branch {
            Branch::Stick => Status::Stick,
            _ if !is_pressed => Status::Free,
            Branch::Slip => Status::Slip,
            Branch::Decided if zero.less(excess.real()) => Status::Slip,
            Branch::Decided => Status::Stick,
        };
        let distance = excess.real() / larger_or_one(at_rest.limit.real());
        if is_pressed && !S::Real::from_f64(THRESHOLD).less(distance.magnitude()) {
            flags.add(Flag::Threshold);
        }
        let solved = match (status, stiffness) {
            (Status::Stick, _) => Slip { force: trial, increment: S::zero(), slip: [S::zero(); 6] },
            (Status::Free, _) | (_, None) => freed(&radii, stiffness, &state.force, &input.displacement),
            (Status::Slip, Some(stiffness)) => {
                let problem = Problem {
                    friction: self,
                    before,
                    input,
                    contact,
                    trial,
                    magnitude,
                    stiffness,
                    radii: &radii,
                };
                match &self.criterion.tangential {
                    Tangential::Norm(_) => problem.radial(&mut flags),
                    Tangential::Potential(potential) => {
                        problem.against(potential, at_rest.limit.real(), &mut flags)
                    }
                }
            }
        };
        let Slip { force, increment, slip } = solved;
        let end = self.limit(contact, before, input, increment, &mut flags);
        let context = Context { accumulated_slip: S::from_real(before) + increment, ..input.context.clone() };
        let tangential = self.criterion.tangential.evaluate(&force, &context, &mut Flags::default());
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
        finite(end.limit, "limit");
        finite(increment, "slip increment");
        Outcome {
            status,
            force,
            tangential,
            contact,
            normal: end.normal,
            coefficient: end.coefficient,
            limit: end.limit,
            criterion: tangential - end.limit,
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

/// Nothing holds: the force is zero, and all of the motion, with what was stored in stick, is slip.
fn freed<S>(
    radii: &[(usize, S::Real)],
    stiffness: Option<S>,
    force: &[S::Real; 6],
    displacement: &[S; 6],
) -> Slip<S>
where
    S: Scalar,
    S::Real: Ordered + Differentiable,
{
    let mut slip = [S::zero(); 6];
    let mut scaled = [S::zero(); 6];
    for (k, radius) in radii {
        let stored = stiffness
            .map_or_else(S::zero, |stiffness| recip(stiffness.scale(*radius * *radius)).scale(force[*k]));
        slip[*k] = displacement[*k] + stored;
        scaled[*k] = slip[*k].scale(*radius);
    }
    Slip { force: [S::zero(); 6], increment: length(&scaled), slip }
}

/// The limit as a scale for its own error.
fn larger_or_one<R: Ordered + Differentiable>(limit: R) -> R {
    if R::integer(0).less(limit) { limit } else { R::integer(1) }
}

/// An increment that slips.
struct Problem<'a, 'b, S: Scalar> {
    friction: &'a Friction,
    before: S::Real,
    input: &'a Input<'b, S>,
    contact: S,
    trial: [S; 6],
    /// P of the trial traction.
    magnitude: S,
    stiffness: S,
    radii: &'a [(usize, S::Real)],
}

impl<S> Problem<'_, '_, S>
where
    S: Scalar,
    S::Real: Ordered + Differentiable,
{
    /// The limit after the slip Δγ.
    fn limit(&self, increment: S, flags: &mut Flags) -> S {
        self.friction.limit(self.contact, self.before, self.input, increment, flags).limit
    }

    /// The limit after a real slip and its derivative, everything else being fixed.
    fn limit_and_slope(&self, increment: S::Real) -> (S::Real, S::Real) {
        type Slope<R> = <R as Differentiable>::Gradient<1>;
        let constant = |x: S| Slope::<S::Real>::from_real(x.real());
        let input = self.input.map(constant);
        let seeded = Slope::<S::Real>::seed(increment, 0);
        let limit = self
            .friction
            .limit(constant(self.contact), self.before, &input, seeded, &mut Flags::default())
            .limit;
        (limit.real(), limit.gradient()[0])
    }

    /// Whether the limit changes with slip.
    fn limit_depends_on_slip(&self) -> bool {
        self.friction.coefficient.depends_on_rate()
            || self.friction.criterion.internal.slip_column().is_some()
    }

    /// The slips below `most` at which the slope of the limit may change, in increasing order.
    fn breaks(&self, most: S::Real) -> Vec<S::Real> {
        let mut slips = Vec::new();
        if let Some(duration) = self.input.duration {
            let rates = self.friction.coefficient.rates().into_iter();
            slips.extend(rates.map(|rate| S::Real::from_f64(rate) * duration.real()));
        }
        if let Some((table, column)) = self.friction.criterion.internal.slip_column() {
            let rows = table.rows(Variable::Column(column)).into_iter();
            slips.extend(rows.map(|row| S::Real::from_f64(row) - self.before));
        }
        sorted(slips.into_iter(), most)
    }

    /// P is a norm: f = (L/P(f_tr)) f_tr and P(f_tr) − K Δγ = L(Δγ).
    fn radial(&self, flags: &mut Flags) -> Slip<S> {
        let (zero, p, stiffness) = (S::Real::integer(0), self.magnitude.real(), self.stiffness.real());
        let (root, fall) = if self.limit_depends_on_slip() {
            let root = first_root(&self.breaks(p / stiffness), p / stiffness, |slip| {
                let (limit, slope) = self.limit_and_slope(slip);
                (p - stiffness * slip - limit, -(stiffness + slope))
            });
            (root, stiffness + self.limit_and_slope(root).1)
        } else {
            ((p - self.limit(S::zero(), &mut Flags::default()).real()) / stiffness, stiffness)
        };
        if !zero.less(fall) {
            flags.add(Flag::Unstable);
        }
        let there = S::from_real(root);
        let left = self.magnitude - self.stiffness.scale(root) - self.limit(there, &mut Flags::default());
        let increment = there + left.scale(fall.reciprocal_or_zero());
        let limit = self.limit(increment, flags);
        let mut scaled = [S::zero(); 6];
        for (k, radius) in self.radii {
            scaled[*k] = self.trial[*k].scale(S::Real::integer(1) / *radius);
        }
        let along = direction(scaled);
        let (mut force, mut slip) = ([S::zero(); 6], [S::zero(); 6]);
        for (k, radius) in self.radii {
            force[*k] = (along[*k] * limit).scale(*radius);
            slip[*k] = (along[*k] * increment).scale(S::Real::integer(1) / *radius);
        }
        Slip { force, increment, slip }
    }

    /// P is a potential: f against its gradient at f, by Newton's method on f and Δγ together.
    fn against(&self, potential: &Potential, limit: S::Real, flags: &mut Flags) -> Slip<S> {
        let size = largest(&self.trial.map(Scalar::real));
        match self.newton(potential, size, limit) {
            Some((force, increment)) => self.lifted(potential, size, limit, force, increment, flags),
            None => {
                flags.add(Flag::ReturnedAlongTraction);
                self.along_traction(potential, flags)
            }
        }
    }

    /// The unknowns f_k/size and K Δγ/size, K_k/K = R_k²; the residuals of the flow, over size, and of P = L, over the limit.
    fn residual(
        &self,
        potential: &Potential,
        (size, scale): (S::Real, S::Real),
        force: &[S::Real; 6],
        increment: S::Real,
    ) -> (Equations<S::Real>, [S::Real; SLOTS]) {
        let n = self.radii.len();
        let (zero, one) = (S::Real::integer(0), S::Real::integer(1));
        let stiffness = self.stiffness.real();
        let seeded = [0, 1, 2, 3, 4, 5].map(|k| <S::Real as Differentiable>::Hessian::<6>::seed(force[k], k));
        let context = self.context(increment).map(|x| Scalar::from_real(x.real()));
        let p = potential.evaluate(&seeded, &context, &mut Flags::default());
        let (gradient, hessian) = (p.gradient(), p.hessian());
        let (limit, slope) = self.limit_and_slope(increment);
        let flow = increment * stiffness / size;
        let mut jacobian = [[zero; SLOTS]; SLOTS];
        let mut residual = [zero; SLOTS];
        for (i, (k, radius)) in self.radii.iter().enumerate() {
            let square = *radius * *radius;
            residual[i] = (force[*k] - self.trial[*k].real()) / size + flow * square * gradient[*k];
            for (j, (l, _)) in self.radii.iter().enumerate() {
                let unit = if i == j { one } else { zero };
                jacobian[i][j] = unit + flow * square * hessian[*k][*l] * size;
            }
            jacobian[i][n] = square * gradient[*k];
            jacobian[n][i] = gradient[*k] * (size / scale);
        }
        residual[n] = (p.real() - limit) / scale;
        jacobian[n][n] = -(slope / stiffness) * (size / scale);
        (Equations { jacobian, n: n + 1 }, residual)
    }

    fn context(&self, increment: S::Real) -> Context<'_, S> {
        Context { accumulated_slip: S::from_real(self.before + increment), ..self.input.context.clone() }
    }

    /// f and Δγ, as real numbers; none where Newton's method with backtracking ends short of a solution.
    fn newton(
        &self,
        potential: &Potential,
        size: S::Real,
        scale: S::Real,
    ) -> Option<([S::Real; 6], S::Real)> {
        /// A residual this small is a solution, to rounding.
        const SOLVED: f64 = 1e-11;
        const STEPS: usize = 60;
        const HALVINGS: usize = 40;
        let (zero, stiffness) = (S::Real::integer(0), self.stiffness.real());
        let (mut force, mut increment) = (self.trial.map(Scalar::real), zero);
        let (mut equations, mut residual) = self.residual(potential, (size, scale), &force, increment);
        let mut error = largest(&residual);
        for _ in 0..STEPS {
            let step = equations.solve(&residual)?;
            let mut fraction = S::Real::integer(1);
            let mut found = None;
            for _ in 0..HALVINGS {
                let mut tried = force;
                for (i, (k, _)) in self.radii.iter().enumerate() {
                    tried[*k] = tried[*k] - fraction * step[i] * size;
                }
                let slip = increment - fraction * step[self.radii.len()] * size / stiffness;
                let (next, left) = self.residual(potential, (size, scale), &tried, slip);
                let size_left = largest(&left);
                let is_less =
                    size_left.less(error * (S::Real::integer(1) - fraction * S::Real::from_f64(1e-4)));
                if is_less && is_finite(size_left) {
                    found = Some((tried, slip, next, left, size_left));
                    break;
                }
                fraction = fraction * S::Real::ratio(1, 2);
            }
            let Some(found) = found else { break };
            (force, increment, equations, residual, error) = found;
            if is_zero(error) {
                break;
            }
        }
        let is_solved = error.less(S::Real::from_f64(SOLVED)) && !increment.less(zero);
        is_solved.then_some((force, increment))
    }

    /// One Newton step on the scalar at the real solution: derivatives of f and Δγ.
    fn lifted(
        &self,
        potential: &Potential,
        size: S::Real,
        scale: S::Real,
        force: [S::Real; 6],
        increment: S::Real,
        flags: &mut Flags,
    ) -> Slip<S> {
        let n = self.radii.len();
        let context = self.context(increment);
        let constant = force.map(S::from_real);
        let p = potential.evaluate(&constant, &context, flags);
        let limit = self.limit(S::from_real(increment), flags);
        let gradient = self.gradient(potential, &force, &context);
        let (equations, _) = self.residual(potential, (size, scale), &force, increment);
        let mut residual = [S::zero(); SLOTS];
        for (i, (k, radius)) in self.radii.iter().enumerate() {
            let flow = (self.stiffness * gradient[*k]).scale(*radius * *radius * increment / size);
            residual[i] = (constant[*k] - self.trial[*k]).scale(S::Real::integer(1) / size) + flow;
        }
        residual[n] = (p - limit).scale(S::Real::integer(1) / scale);
        let step = equations.solve(&residual).unwrap_or([S::zero(); SLOTS]);
        let (mut end, mut slip) = ([S::zero(); 6], [S::zero(); 6]);
        for (i, (k, radius)) in self.radii.iter().enumerate() {
            end[*k] = constant[*k] - step[i].scale(size);
            slip[*k] = (self.trial[*k] - end[*k]) * recip(self.stiffness.scale(*radius * *radius));
        }
        let increment = S::from_real(increment) - step[n].scale(size / self.stiffness.real());
        Slip { force: end, increment, slip }
    }

    /// ∂P/∂f at real forces, as the scale factors of derived components move with the context.
    fn gradient(&self, potential: &Potential, force: &[S::Real; 6], context: &Context<'_, S>) -> [S; 6] {
        type First<R> = <R as Differentiable>::Gradient<6>;
        type Mixed<R> = <R as Differentiable>::Hessian<2>;
        let seeded = [0, 1, 2, 3, 4, 5].map(|k| First::<S::Real>::seed(force[k], k));
        let still = context.map(|x| First::<S::Real>::from_real(x.real()));
        let p = potential.evaluate(&seeded, &still, &mut Flags::default());
        let mut lifted = p.gradient().map(S::from_real);
        if S::ORDER == 0 || !potential.moves() {
            return lifted;
        }
        for (k, _) in self.radii {
            let mut forces = force.map(Mixed::<S::Real>::from_real);
            forces[*k] = Mixed::<S::Real>::seed(force[*k], 0);
            for j in 0..6 {
                let mut moving = context.map(|x| Mixed::<S::Real>::from_real(x.real()));
                moving.position[j] = Mixed::<S::Real>::seed(context.position[j].real(), 1);
                let by_position = potential.evaluate(&forces, &moving, &mut Flags::default()).hessian()[0][1];
                moving.position[j] = Mixed::<S::Real>::from_real(context.position[j].real());
                moving.motion[j] = Mixed::<S::Real>::seed(context.motion[j].real(), 1);
                let by_motion = potential.evaluate(&forces, &moving, &mut Flags::default()).hessian()[0][1];
                lifted[*k] = lifted[*k]
                    + context.position[j].nilpotent().scale(by_position)
                    + context.motion[j].nilpotent().scale(by_motion);
            }
        }
        lifted
    }

    /// f = s f_tr with P(f) = L and the slip that this takes, Δγ = (1 − s) Σ f_tr,k²/(K_k P(f_tr)): by bisection, which cannot
    /// fail.
    fn along_traction(&self, potential: &Potential, flags: &mut Flags) -> Slip<S> {
        let (zero, one) = (S::Real::integer(0), S::Real::integer(1));
        // Σ f_tr,k²/(K_k P), formed without squaring large numbers.
        let inverse = recip(self.magnitude);
        let mut whole = S::zero();
        for (k, radius) in self.radii {
            let elastic = self.trial[*k] * recip(self.stiffness.scale(*radius * *radius));
            whole = whole + elastic * (self.trial[*k] * inverse);
        }
        let excess = |share: S, flags: &mut Flags| {
            let increment = (S::one() - share) * whole;
            let context = Context {
                accumulated_slip: S::from_real(self.before) + increment,
                ..self.input.context.clone()
            };
            let p = potential.evaluate(&self.trial.map(|x| x * share), &context, flags);
            p - self.limit(increment, flags)
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
            type Slope<R> = <R as Differentiable>::Gradient<1>;
            let constant = |x: S| Slope::<S::Real>::from_real(x.real());
            let seeded = Slope::<S::Real>::seed(share, 0);
            let slip = (Slope::<S::Real>::one() - seeded).scale(whole.real());
            let context = self.context((one - share) * whole.real()).map(constant);
            let p = potential.evaluate(&self.trial.map(constant).map(|x| x * seeded), &context, &mut unseen);
            let limit = self
                .friction
                .limit(constant(self.contact), self.before, &self.input.map(constant), slip, &mut unseen)
                .limit;
            let slope = (p - limit).gradient()[0];
            lifted = lifted - excess(lifted, flags).scale(slope.reciprocal_or_zero());
        }
        let lost = S::one() - lifted;
        let (mut force, mut slip) = ([S::zero(); 6], [S::zero(); 6]);
        for (k, radius) in self.radii {
            force[*k] = self.trial[*k] * lifted;
            slip[*k] = self.trial[*k] * recip(self.stiffness.scale(*radius * *radius)) * lost;
        }
        Slip { force, increment: whole * lost, slip }
    }
}

/// The first root in [0, most] of a function that is positive at 0 and not at `most`, given with its slope; by Newton's method,
/// safeguarded by bisection. Between `breaks` the function is smooth.
pub(super) fn first_root<R: Ordered + Differentiable>(breaks: &[R], most: R, h: impl Fn(R) -> (R, R)) -> R {
    let zero = R::integer(0);
    let (mut low, mut high) = (zero, most);
    for point in breaks {
        if zero.less(h(*point).0) {
            low = *point;
        } else {
            high = *point;
            break;
        }
    }
    /// Bisection alone narrows 1e300 to the last of 237 bits in fewer.
    const ITERATIONS: usize = 1300;
    let mut x = low;
    for _ in 0..ITERATIONS {
        let (value, slope) = h(x);
        if is_zero(value) {
            return x;
        }
        if zero.less(value) {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let is_inside = low.less(newton) && newton.less(high);
        let next = if is_inside { newton } else { low + (high - low) * R::ratio(1, 2) };
        if is_zero(next - x) || is_zero(next - low) || is_zero(next - high) {
            return next;
        }
        x = next;
    }
    x
}

/// The slips below `most`, each once, in increasing order.
pub(super) fn sorted<R: Ordered + Differentiable>(slips: impl Iterator<Item = R>, most: R) -> Vec<R> {
    let mut sorted: Vec<R> = slips.filter(|slip| R::integer(0).less(*slip) && slip.less(most)).collect();
    sorted.sort_by(|x, y| match (x.less(*y), y.less(*x)) {
        (true, _) => Ordering::Less,
        (_, true) => Ordering::Greater,
        _ => Ordering::Equal,
    });
    sorted.dedup_by(|x, y| !y.less(*x));
    sorted
}

/// Places in the slip equations: six forces and the slip.
const SLOTS: usize = 7;

/// The matrix of a linear system of n equations.
struct Equations<R> {
    jacobian: [[R; SLOTS]; SLOTS],
    n: usize,
}

impl<R: Ordered + Differentiable> Equations<R> {
    /// The solution for a right-hand side that may carry derivatives, by elimination with row pivoting; none where the matrix
    /// is singular.
    fn solve<S: Scalar<Real = R>>(&self, right: &[S; SLOTS]) -> Option<[S; SLOTS]> {
        let (mut a, mut b, n) = (self.jacobian, *right, self.n);
        for column in 0..n {
            let mut pivot = column;
            for row in column + 1..n {
                if a[pivot][column].magnitude().less(a[row][column].magnitude()) {
                    pivot = row;
                }
            }
            if is_zero(a[pivot][column]) || !is_finite(a[pivot][column]) {
                return None;
            }
            a.swap(column, pivot);
            b.swap(column, pivot);
            for row in column + 1..n {
                let factor = a[row][column] / a[column][column];
                for k in column..n {
                    a[row][k] = a[row][k] - factor * a[column][k];
                }
                b[row] = b[row] - b[column].scale(factor);
            }
        }
        for column in (0..n).rev() {
            for k in column + 1..n {
                b[column] = b[column] - b[k].scale(a[column][k]);
            }
            b[column] = b[column].scale(R::integer(1) / a[column][column]);
        }
        Some(b)
    }
}

#[cfg(test)]
mod tests {
    use super::sorted;

    /// Each once, in increasing order; a table of a hundred thousand rows costs no time.
    #[test]
    fn slips_are_sorted_once() {
        let given = [3.0, 1.0, 9.0, 1.0, f64::NAN, -1.0, 2.0, 0.0];
        assert_eq!(sorted(given.into_iter(), 9.0), [1.0, 2.0, 3.0]);
        let many = (1..=100_000).rev().map(f64::from);
        assert_eq!(sorted(many, 1e9).len(), 100_000);
    }
}
