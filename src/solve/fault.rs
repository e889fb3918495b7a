//! Deliberate faults of the solver, by which tests see that the references would notice them; outside of tests there are none.

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Slip begins along the friction force, not against it.
    SlipReversed,
    /// Slip begins along the first component, whichever way friction points.
    OnsetByDefault,
    /// Positions are not brought back to their equations.
    Drift,
    /// Events are where a straight line between the ends of a step puts them.
    EventInterpolated,
    /// The limit of a friction is that of the forces without it.
    CouplingLeftOut,
    /// A magnitude that passes zero is no event.
    KinkPassed,
    /// A row of a table is no event, and its line goes on.
    RowPassed,
    /// The energy of impacts is not counted.
    ImpactForgotten,
    /// A stop holds what goes away.
    StopPulls,
    /// Whole turns within a step are lost.
    TurnLost,
    /// Whole turns of two nodes are those of each by itself.
    TurnsApart,
    /// A magnitude that passes zero with another one keeps its sign for a step.
    KinksApart,
    /// A lock lets go of the velocity that it stops.
    LockSlips,
    /// What comes to rest sticks, whatever pulls.
    SticksAlways,
    /// What comes to rest slips back, whatever holds.
    ReversesAlways,
    /// Slip begins a little beyond the limit: a tolerance.
    OnsetLate,
    /// J̇ q̇ is left out.
    BiasLeftOut,
    /// ω × I ω is left out.
    GyroscopicLeftOut,
    /// Corners of what acts are stepped over.
    CornersPassed,
    /// The energy that a failure releases is not counted.
    FailureForgotten,
    /// What friction takes is not counted.
    FrictionForgotten,
    /// The work of what is prescribed is not counted.
    DriveForgotten,
    /// Rotation vectors are added.
    RotationAdded,
    /// A rotation vector grows with ω.
    TurnRateTaken,
    /// A belt slips as if it were pulled from its other end.
    CapstanTurned,
}

#[cfg(test)]
thread_local! {
    pub(crate) static NOW: std::cell::Cell<Option<Fault>> = const { std::cell::Cell::new(None) };
}

/// Whether a test has asked for a fault.
#[cfg(test)]
pub(crate) fn has(fault: Fault) -> bool {
    NOW.get() == Some(fault)
}

/// No fault.
#[cfg(not(test))]
pub(crate) const fn has(_: Fault) -> bool {
    false
}
