//! Friction in connectors: Φ = P(f) − μ F_N ≤ 0, predefined by the connection type or defined by the user.
//!
//! | module | question |
//! |---|---|
//! | [`Criterion`] | what are P, F_C, F_N and Φ at given forces, and their derivatives? |
//! | [`Derived`], [`Potential`] | how are forces combined to a contact force or a direction of slip? |
//! | [`Coefficient`] | what is μ? |
//! | [`Friction`] | what does an increment do: stick or slip, friction force, accumulated slip, tangent? |
//! | [`Belt`] | the same for a belt around a ring (SLIPRING) |
//!
//! In P the forces of the sliding components are the friction tractions; F_C is formed from what presses: constraint forces,
//! or in available components the forces without friction. Signs: a friction force is internal, as every reported component
//! force: positive resists growth of its component.
//!
//! # Where there is no derivative
//! A norm at zero, |f1| at 0, F_C + F_C^int = 0, a Macauley bracket at zero: the value is exact, derivatives are those of least
//! norm (zero), and a [`Flag`] names the place. Second derivatives of |f1|^α with 1 < α < 2 are infinite at f1 = 0: those given leave
//! the term out and are flagged ([`Flag::InfiniteCurvature`]), while the consistent tangent is the limit, ∂f1 = 0. Norms are scaled: forces from 1e-300 to 1e300 neither overflow nor vanish.

mod belt;
mod build;
mod coefficient;
mod compiled;
mod criterion;
mod derived;
mod flags;
mod read;
mod root; // where a limit is met first; linear systems
mod slip; // the slip equations, solved and lifted
mod stick; // the springs of stick
mod stretch; // unknowns of the slip equations where P is curved infinitely
#[cfg(test)]
mod tests;
mod update;

pub use belt::{Belt, BeltInput, BeltTangent, FLOW, wrap_angle};
pub use build::{Frictions, of_behavior};
pub use coefficient::{Coefficient, CoefficientError};
pub use compiled::Frictional;
pub use criterion::{
    ContactParts, Criterion, Derivatives, Internal, ParameterError, Point, Pressing, Tangential, Term,
};
pub use criterion::{FactorMistake, TermMistake};
pub use derived::{Contribution, Derived, DerivedPart, Form, Potential, PotentialError};
pub use flags::Flag;
pub use stick::{ELASTIC_SLIP, StickStiffness};
pub use update::{Branch, Friction, FrictionOutcome, Input, Partial, State, Status, THRESHOLD, Tangent};

use crate::behavior::Conditions;
use flags::Flags;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::scalar::{Real, Scalar};
use pintle_scene::Basis;

/// A real number with an order, on which stick and slip can be told apart.
pub trait Ordered: Real<Mask = bool> {}

impl<R: Real<Mask = bool>> Ordered for R {}

/// What a friction may depend on besides forces.
#[derive(Clone, Debug)]
pub struct Context<'a, S: Scalar> {
    /// Positions (CP) of the components: lengths, and angles in radians.
    pub position: [S; 6],
    /// Displacements from the constitutive reference (CCU); angles in radians.
    pub motion: [S; 6],
    /// The slip accumulated so far (CASU). An update adds the slip of its increment.
    pub accumulated_slip: S,
    /// Temperature and field variables. What is needed and not given is taken as zero, and flagged.
    pub conditions: &'a Conditions,
}

/// Nothing is known of temperature and fields.
static UNKNOWN: Conditions = Conditions { temperature: None, fields: Vec::new() };

impl<S: Scalar> Default for Context<'_, S> {
    fn default() -> Self {
        Self {
            position: [S::zero(); 6],
            motion: [S::zero(); 6],
            accumulated_slip: S::zero(),
            conditions: &UNKNOWN,
        }
    }
}

impl<'a, S: Scalar> Context<'a, S> {
    /// The same on another scalar.
    pub fn map<T: Scalar<Real = S::Real>>(&self, to: impl Fn(S) -> T) -> Context<'a, T> {
        Context {
            position: self.position.map(&to),
            motion: self.motion.map(&to),
            accumulated_slip: to(self.accumulated_slip),
            conditions: self.conditions,
        }
    }

    const fn of(&self, basis: Basis) -> [S; 6] {
        match basis {
            Basis::Position => self.position,
            Basis::ConstitutiveMotion => self.motion,
        }
    }
}

/// The maximum where it is below the limit.
fn cap<R: Ordered>(limit: R, maximum: Option<f64>, flags: &mut Flags) -> Option<R> {
    let maximum = R::from_f64(maximum?);
    if limit.less(maximum) {
        return None;
    }
    if !maximum.less(limit) {
        flags.add(Flag::LimitAtMaximum);
    }
    Some(maximum)
}

/// min(limit, maximum).
fn capped<S>(limit: S, maximum: Option<f64>, flags: &mut Flags) -> S
where
    S: Scalar,
    S::Real: Ordered,
{
    cap(limit.real(), maximum, flags).map_or(limit, S::from_real)
}

/// Whether a number is positive, and it and its reciprocal are finite.
fn is_divisor(x: f64) -> bool {
    x.is_sign_positive() && x.is_finite() && x.recip().is_finite()
}

fn is_zero<R: Ordered>(x: R) -> bool {
    let zero = R::ZERO;
    // The last is false for NaN.
    !x.less(zero) && !zero.less(x) && x.magnitude().less(R::integer(1))
}

fn is_finite<R: Ordered>(x: R) -> bool {
    let zero = R::ZERO;
    (x * zero).magnitude().less(R::integer(1))
}

/// The larger of two numbers.
fn larger<R: Ordered>(x: R, y: R) -> R {
    if x.less(y) { y } else { x }
}

/// The largest magnitude.
fn largest<R: Ordered>(of: &[R]) -> R {
    of.iter().fold(R::ZERO, |most, x| larger(most, x.magnitude()))
}

/// The most contributions that a potential may have.
const MOST_CONTRIBUTIONS: usize = 24;

/// The norm of a list of at most [`MOST_CONTRIBUTIONS`] numbers.
fn length<S: Scalar>(of: &[S]) -> S {
    fn filled<S: Scalar, const N: usize>(of: &[S]) -> S {
        let mut all = [S::zero(); N];
        for (place, x) in all.iter_mut().zip(of) {
            *place = *x;
        }
        norm(all)
    }
    match of.len() {
        0..=3 => filled::<S, 3>(of),
        4..=6 => filled::<S, 6>(of),
        _ => filled::<S, MOST_CONTRIBUTIONS>(of),
    }
}
