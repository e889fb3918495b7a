//! The springs of stick, and limits in units of their stretch.
//!
//! The default stiffness is the limit itself over an elastic slip: there L/K depends on no force that presses, and a ratio of two limits,
//! each rounded, would not know. Factors are kept apart, and the derivatives of one that two limits share cancel exactly.

use crate::behavior::friction::flags::Flags;
use crate::behavior::friction::{Ordered, cap};
use pintle_kinematics::scalar::{Real, Scalar};

/// The elastic slip allowed in stick by default, as a fraction of a characteristic length; in radians where the slip is an
/// angle (Abaqus/Standard; `SLIP TOLERANCE` replaces it).
pub const ELASTIC_SLIP: f64 = 1e-4;

/// The stiffness of stick.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum StickStiffness {
    /// `STICK STIFFNESS`: K_s, in the unit of P over that of the slip.
    Given(f64),
    /// Our default rule \[R\]: K_s = L / s_el, with L the limit, without slip, of the first increment in which anything presses;
    /// kept from then on ([`State::stick_stiffness`](crate::behavior::friction::State::stick_stiffness)). `ElasticSlip(s_el)`, s_el = [`ELASTIC_SLIP`] ·
    /// characteristic length.
    ElasticSlip(f64),
}

impl StickStiffness {
    /// K_s where `kept` is what was remembered and `at_rest` the limit without slip; none while nothing ever pressed.
    pub(super) fn stick<S>(self, kept: Option<S::Real>, at_rest: &Limit<S>) -> Option<Stick<S>>
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let one = S::Real::integer(1);
        let constant =
            |stiffness| Stick { of: Limit { factors: [S::one(), S::from_real(stiffness)] }, per: one };
        match (self, kept) {
            (Self::Given(stiffness), _) => Some(constant(S::Real::from_f64(stiffness))),
            (Self::ElasticSlip(_), Some(stiffness)) => Some(constant(stiffness)),
            (Self::ElasticSlip(slip), None) => S::Real::ZERO
                .less(at_rest.value().real())
                .then(|| Stick { of: *at_rest, per: S::Real::from_f64(slip) }),
        }
    }
}

/// A limit: μ and F_N, or what stands in their places; τ_max stands alone.
#[derive(Clone, Copy)]
pub(super) struct Limit<S> {
    factors: [S; 2],
}

impl<S> Limit<S>
where
    S: Scalar,
    S::Real: Ordered,
{
    /// min(μ F_N, τ_max).
    pub(super) fn new(factors: [S; 2], maximum: Option<f64>, flags: &mut Flags) -> Self {
        let whole = Self { factors };
        match cap(whole.value().real(), maximum, flags) {
            Some(maximum) => Self { factors: [S::from_real(maximum), S::one()] },
            None => whole,
        }
    }

    /// The limit.
    pub(super) fn value(&self) -> S {
        let [first, second] = self.factors;
        first * second
    }
}

/// K_s, as a force over the slip that it takes.
#[derive(Clone, Copy)]
pub(super) struct Stick<S: Scalar> {
    of: Limit<S>,
    per: S::Real,
}

impl<S> Stick<S>
where
    S: Scalar,
    S::Real: Ordered,
{
    /// The same on another scalar.
    pub(super) fn map<T: Scalar<Real = S::Real>>(&self, to: impl Fn(S) -> T) -> Stick<T> {
        Stick { of: Limit { factors: self.of.factors.map(to) }, per: self.per }
    }

    /// K_s.
    pub(super) fn stiffness(&self) -> S {
        self.of.value().scale(S::Real::integer(1) / self.per)
    }

    /// f/K of a force that is no variable.
    pub(super) fn stretch_of(&self, force: S::Real) -> S {
        ratio(S::from_real(force), self.stiffness())
    }

    /// L/K.
    pub(super) fn stretch_at(&self, limit: &Limit<S>) -> S {
        let [first, second] = [0, 1].map(|i| ratio(limit.factors[i], self.of.factors[i]));
        (first * second).scale(self.per)
    }
}

/// x/y with (x/y)′ = (x′ − (x/y) y′)/y, exactly zero where x and y are one.
fn ratio<S: Scalar>(x: S, y: S) -> S {
    const { assert!(S::ORDER <= 1, "ratios of limits are differentiated once") }
    let ratio = x.real() / y.real();
    S::from_real(ratio) + (x - y.scale(ratio)).nilpotent().scale(y.real().reciprocal_or_zero())
}
