//! What every friction does: it sticks, or it slips one way.

use crate::number::Number;

/// What one friction does.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Does<R> {
    /// Its components stand where they are: their positions.
    Sticks([R; 6]),
    /// It slips along n, Σ n_k² = 1 over its components; one component keeps the sign of its n.
    Slips([R; 6]),
}

/// The branches of a friction's magnitudes, which stay as they are within a step so that its formulas are smooth there.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Branches<R> {
    /// The direction of A f of each magnitude; none where it is zero.
    pub(crate) magnitudes: Vec<Option<Vec<R>>>,
    /// The sign of F_C + F_C^int.
    pub(crate) normal: Option<R>,
    /// Whether the limit is the largest friction force.
    pub(crate) is_capped: bool,
}

/// A friction in a mode.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mode<R> {
    pub(crate) does: Does<R>,
    pub(crate) branches: Branches<R>,
}

/// What becomes negative when a mode ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// P reaches μ F_N: stick ends.
    Breaks,
    /// The slip rate reaches zero.
    Stops,
    /// A magnitude passes zero: its formula goes on in another branch.
    Turns,
    /// The limit reaches the largest friction force, or leaves it.
    Caps,
}

/// A quantity that is positive while a friction stays in its mode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Switch<R> {
    pub(crate) slider: usize,
    pub(crate) cause: Cause,
    /// Which magnitude turns; `None` for F_C + F_C^int.
    pub(crate) part: Option<usize>,
    pub(crate) value: R,
    /// The size against which it counts as zero.
    pub(crate) scale: R,
}

impl<R: Number> Mode<R> {
    pub(crate) fn sticks(at: [R; 6]) -> Self {
        Self { does: Does::Sticks(at), branches: Branches::none() }
    }

    pub(crate) fn slips(along: [R; 6]) -> Self {
        Self { does: Does::Slips(along), branches: Branches::none() }
    }

    pub(crate) fn is_stuck(&self) -> bool {
        matches!(self.does, Does::Sticks(_))
    }
}

impl<R> Branches<R> {
    pub(crate) fn none() -> Self {
        Self { magnitudes: Vec::new(), normal: None, is_capped: false }
    }
}
