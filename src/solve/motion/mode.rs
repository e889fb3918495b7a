//! What every friction, stop, lock and table does: a friction sticks or slips one way, a stop is open or closed.

use crate::number::Number;
use pintle_kinematics::connector::Mask;
use serde::{Deserialize, Serialize};

/// Margins below this count as ties.
pub(crate) const TIE: f64 = 1e-9;

/// What one friction does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Does<R> {
    /// Its components stand where they are: their positions.
    Sticks([R; 6]),
    /// It is held by a spring: the positions at which that is slack.
    Stretches([R; 6]),
    /// It slips along n, Σ n_k² = 1 over its components; one component keeps the sign of its n.
    Slips([R; 6]),
    /// It stands because others hold it, so that its force is open: taken as its limit against n, or, with n zero, as none.
    Stands([R; 6]),
}

/// The branches of a friction's magnitudes, which stay as they are within a step so that its formulas are smooth there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Branches<R> {
    /// The direction of A f of each magnitude; none where it is zero.
    pub(crate) magnitudes: Vec<Option<Vec<R>>>,
    /// The sign of F_C + F_C^int.
    pub(crate) normal: Option<R>,
    /// Whether the limit is the largest friction force; none where it is not known yet.
    pub(crate) is_capped: Option<bool>,
    /// Those that have turned since the last step, `None` is the sum: on the other side of zero they are by the error of the state.
    pub(crate) turned: Vec<Option<usize>>,
    /// Whether a magnitude that is zero counts as zero: within a step, where off the constraints it has a kink.
    #[serde(skip)]
    pub(crate) zeros_stay: bool,
}

/// A friction in a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Mode<R> {
    pub(crate) does: Does<R>,
    pub(crate) branches: Branches<R>,
    /// Whether its slip begins: next to rest its direction is that of its slip velocity as integrated from rest, for the one of the state is
    /// rounding.
    #[serde(default)]
    pub(crate) in_onset: bool,
}

/// An end of a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Side {
    Lower,
    Upper,
}

impl Side {
    pub(crate) const BOTH: [Self; 2] = [Self::Lower, Self::Upper];

    /// −1 at the lower end, 1 at the upper one: the sign of a force that resists going beyond it.
    pub(crate) fn sign<R: Number>(self) -> R {
        R::integer(if self == Self::Lower { -1 } else { 1 })
    }
}

/// What a stop does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Touch {
    /// Its component is between the limits.
    Open,
    /// It is at a limit, and going away from it.
    Leaves(Side),
    /// It is held at a limit.
    Closed(Side),
}

impl Touch {
    /// The limit at which it is.
    pub(crate) const fn side(self) -> Option<Side> {
        match self {
            Self::Open => None,
            Self::Leaves(side) | Self::Closed(side) => Some(side),
        }
    }
}

/// What a mechanism does: all that may be one way or another, and stays so for a while.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Modes<R> {
    /// Frictions.
    pub(crate) frictions: Vec<Mode<R>>,
    /// Stops.
    pub(crate) stops: Vec<Touch>,
    /// Where locks hold the components of each connector.
    pub(crate) locked: Vec<[Option<R>; 6]>,
    /// The components of each connector that have failed.
    pub(crate) failed: Vec<Mask>,
    /// Between which rows each table is: the number of rows below.
    pub(crate) spans: Vec<usize>,
    /// Of each stop that has been left with a rate: when, and by how much it was beyond its limit then, which is rounding.
    #[serde(default = "Vec::new")]
    pub(crate) left: Vec<Option<[R; 2]>>,
}

impl<R: Number> Modes<R> {
    /// Nothing sticks, no stop is closed, nothing is locked.
    pub(crate) const fn none() -> Self {
        Self {
            frictions: Vec::new(),
            stops: Vec::new(),
            locked: Vec::new(),
            failed: Vec::new(),
            spans: Vec::new(),
            left: Vec::new(),
        }
    }

    /// When a stop was left, and by how much it was beyond its limit then.
    pub(crate) fn left(&self, stop: usize) -> Option<[R; 2]> {
        self.left.get(stop).copied().flatten()
    }

    /// A stop is at its limit again: when it was left no longer matters.
    pub(crate) fn meet(&mut self, stop: usize) {
        if let Some(left) = self.left.get_mut(stop) {
            *left = None;
        }
    }

    /// The same with no friction at all.
    pub(crate) fn without_friction(&self) -> Self {
        Self { frictions: Vec::new(), ..self.clone() }
    }

    /// The position at which a lock holds component k of a connector.
    pub(crate) fn locked_at(&self, joint: usize, k: usize) -> Option<R> {
        self.locked.get(joint).and_then(|locked| locked[k])
    }

    /// Whether component k of a connector has failed.
    pub(crate) fn has_failed(&self, joint: usize, k: usize) -> bool {
        self.failed.get(joint).is_some_and(|failed| failed[k])
    }
}

/// What becomes negative when a mode ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// P reaches μ F_N: stick ends.
    Breaks,
    /// The slip rate reaches zero.
    Stops,
    /// A magnitude passes zero: its formula goes on in another branch. `None` is F_C + F_C^int.
    Turns(Option<usize>),
    /// The limit reaches the largest friction force, or leaves it.
    Caps,
    /// A component reaches this end of its range.
    Closes(Side),
    /// The force of a stop reaches zero.
    Opens,
    /// A lock or failure meets one of its four limits.
    Meets(usize),
    /// A table reaches the row at this end of its span.
    Passes(Side),
}

/// A quantity that is positive while a mode lasts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Switch<R> {
    /// Of which friction, stop, criterion or table, as the cause says.
    pub(crate) of: usize,
    pub(crate) cause: Cause,
    pub(crate) value: R,
    /// The size against which it counts as zero.
    pub(crate) scale: R,
}

impl<R: Number> Mode<R> {
    pub(crate) fn sticks(at: [R; 6]) -> Self {
        Self { does: Does::Sticks(at), branches: Branches::none(), in_onset: false }
    }

    pub(crate) fn slips(along: [R; 6]) -> Self {
        Self { does: Does::Slips(along), branches: Branches::none(), in_onset: true }
    }

    /// Held by a spring that is slack there.
    pub(crate) fn stretches(slack: [R; 6]) -> Self {
        Self { does: Does::Stretches(slack), branches: Branches::none(), in_onset: false }
    }

    pub(crate) fn is_stuck(&self) -> bool {
        !matches!(self.does, Does::Slips(_))
    }

    /// n, where the force is the limit against it.
    pub(crate) fn along(&self) -> Option<&[R; 6]> {
        match &self.does {
            Does::Slips(along) | Does::Stands(along) => Some(along),
            Does::Sticks(_) | Does::Stretches(_) => None,
        }
    }

    /// Where others hold it.
    pub(crate) fn stands(along: [R; 6]) -> Self {
        Self { does: Does::Stands(along), branches: Branches::none(), in_onset: false }
    }

    /// Whether others hold it.
    pub(crate) fn is_held_by_others(&self) -> bool {
        matches!(self.does, Does::Stands(_))
    }
}

impl<R> Branches<R> {
    pub(crate) fn none() -> Self {
        Self { magnitudes: Vec::new(), normal: None, is_capped: None, turned: Vec::new(), zeros_stay: false }
    }
}
