//! What of a friction needs care at a state.

use crate::behavior::table::{Table, Variable};
use crate::behavior::{Conditions, Unknown};
use pintle_kinematics::scalar::Real;
use serde::Serialize;

/// A state at which a friction's value or its derivatives need care.
///
/// Where a derivative does not exist the one of least norm is reported, which is zero at the zero of a magnitude.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "flag", rename_all = "kebab-case")]
pub enum Flag {
    /// P = 0: the traction has no direction, and P no derivative.
    NoTraction,
    /// A magnitude of which F_C is formed is zero: along it F_C grows to both sides.
    LoadAtZero {
        /// The magnitude: `|m1|`, `√(f2² + f3²)`.
        load: String,
    },
    /// F_C + F_C^int = 0: F_N grows to both sides.
    NoContactForce,
    /// A Macauley bracket ⟨x⟩ = max(x, 0) at x = 0.
    MacauleyAtZero {
        /// The term, from 1.
        term: usize,
    },
    /// A contribution to a potential, or a magnitude in a derived component, is at zero.
    ContributionAtZero {
        /// The term, from 1.
        term: usize,
    },
    /// A contribution to a potential with an exponent below 2 is at zero, where second derivatives of P are infinite. Those given are
    /// what is left without it; so is a consistent tangent that has this flag.
    InfiniteCurvature {
        /// The term, from 1.
        term: usize,
    },
    /// Two contributions to a MAX potential are equal: the derivatives are those of the first.
    TiedMaximum {
        /// The terms, from 1.
        terms: [usize; 2],
    },
    /// The sum of the signed contributions to a potential is negative, so that its root does not exist: P is taken as zero.
    NegativePotential,
    /// A table is at a row where two slopes meet.
    TableRow {
        /// What the table gives.
        table: &'static str,
        /// Where the slopes meet.
        at: f64,
    },
    /// μ F_N = τ_max: beyond, the limit is constant.
    LimitAtMaximum,
    /// The trial traction is at the limit to within 1e-12 of it: the tangents of stick and of slip differ, and rounding tells
    /// them apart.
    Threshold,
    /// The coefficient depends on the slip rate, and the increment has no duration: the rate is taken as zero.
    NoDuration,
    /// The traction was returned along its own direction, and not against the gradient of the potential. That has no solution
    /// that Newton's method finds: at an edge of the potential, or where this is not convex.
    ReturnedAlongTraction,
    /// The limit falls faster with slip than the stick stiffness can carry, or than P of a potential that is not convex does: the
    /// traction jumps at this increment.
    Unstable,
    /// No traction on the way to zero satisfies the criterion: P(0) exceeds the limit.
    NoAdmissibleTraction,
    /// The slip puts energy in instead of losing it: the criterion shuts out the traction zero, as shifts of a potential can.
    NegativeDissipation,
    /// A tension of a belt is not positive: slack segments carry no friction.
    Slack,
    /// The segments of a belt are in line (0) or folded back (π): the angle of wrap has no derivative across.
    WrapAngle {
        /// The angle (rad).
        angle: f64,
    },
    /// A table depends on a temperature or a field variable that is not given: it is taken as zero.
    NotGiven {
        /// Which.
        what: Unknown,
    },
    /// A number is infinite or not a number.
    NotFinite {
        /// Which.
        quantity: &'static str,
    },
}

impl Flag {
    /// The name, as JSON has it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::NoTraction => "no-traction",
            Self::LoadAtZero { .. } => "load-at-zero",
            Self::NoContactForce => "no-contact-force",
            Self::MacauleyAtZero { .. } => "macauley-at-zero",
            Self::ContributionAtZero { .. } => "contribution-at-zero",
            Self::InfiniteCurvature { .. } => "infinite-curvature",
            Self::TiedMaximum { .. } => "tied-maximum",
            Self::NegativePotential => "negative-potential",
            Self::TableRow { .. } => "table-row",
            Self::LimitAtMaximum => "limit-at-maximum",
            Self::Threshold => "threshold",
            Self::NoDuration => "no-duration",
            Self::ReturnedAlongTraction => "returned-along-traction",
            Self::Unstable => "unstable",
            Self::NoAdmissibleTraction => "no-admissible-traction",
            Self::NegativeDissipation => "negative-dissipation",
            Self::Slack => "slack",
            Self::WrapAngle { .. } => "wrap-angle",
            Self::NotGiven { .. } => "not-given",
            Self::NotFinite { .. } => "not-finite",
        }
    }
}

/// Collects flags, each once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Flags(Vec<Flag>);

impl Flags {
    pub(super) fn add(&mut self, flag: Flag) {
        if !self.0.contains(&flag) {
            self.0.push(flag);
        }
    }

    /// The rows of a table at which its arguments lie, and the conditions that it needs and that are not given.
    pub(super) fn rows<R: Real>(
        &mut self,
        name: &'static str,
        table: &Table,
        conditions: &Conditions,
        output: usize,
        argument: impl Fn(Variable) -> R,
    ) {
        for what in table.depends_on().filter_map(|variable| conditions.lacks(variable)) {
            self.add(Flag::NotGiven { what });
        }
        for kink in table.kinks(output, argument) {
            self.add(Flag::TableRow { table: name, at: kink.at });
        }
    }

    pub(super) fn into_vec(self) -> Vec<Flag> {
        self.0
    }
}
