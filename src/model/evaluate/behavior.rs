//! What of a behaviour a request needs, and what it has to say.

use crate::behavior::drive::Prescribed;
use crate::behavior::friction;
use crate::behavior::state::{Event, Outcome};
use crate::behavior::{ForceKink, Tangent, Unknown};
use crate::evaluate::model::ElementBehavior;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Flag, Mask, Output, Request};

impl ElementBehavior {
    /// Whether anything of the behaviour has to be computed for a request, or for what is planned for the states that follow.
    pub(super) fn is_needed(&self, request: &Request, planned: &Request) -> bool {
        self.is_asked(request) || (self.has_history() && self.is_asked(planned))
    }

    /// Whether a request depends on the behaviour.
    pub(super) fn is_asked(&self, request: &Request) -> bool {
        let Self { behavior, drives, .. } = self;
        let is_driven = drives.motions.iter().any(Option::is_some);
        let holds = is_driven || !behavior.locks.is_empty() || behavior.elasticity.rigid().contains(&true);
        request.outputs().any(|output| match output {
            Output::RES | Output::RESV | Output::RESA => holds,
            Output::KT | Output::CT | Output::KR => true,
            Output::CSLST => behavior.has_stops() || !behavior.locks.is_empty(),
            other => other.is_of_behavior() || (other.is_of_forces() && !self.is_empty()),
        })
    }

    /// Whether friction has to be followed for what is planned: forces without it would be others.
    pub(super) fn slides(&self, planned: &Request) -> bool {
        let Self { behavior, .. } = self;
        let rests_on_it = |output: Output| {
            output.is_of_forces()
                || matches!(output, Output::CSF | Output::CRF | Output::CNF | Output::CASU | Output::CIVC)
                || matches!(output, Output::SLIP | Output::TANGENT)
        };
        behavior.slips_at_all()
            && (planned.outputs().any(rests_on_it) || (behavior.decides_by_force() && self.is_asked(planned)))
    }

    /// Whether nothing acts on the connector but its constraints.
    pub fn is_empty(&self) -> bool {
        self.behavior.is_empty() && self.drives.is_empty()
    }

    /// Whether the forces but for friction depend on the states before.
    pub(super) fn remembers_tension(&self) -> bool {
        self.behavior.has_history_without_friction() || self.drives.motions.iter().any(Option::is_some)
    }

    /// Whether the states that follow depend on what happens at this one.
    pub(super) fn has_history(&self) -> bool {
        self.behavior.has_history() || self.drives.motions.iter().any(Option::is_some)
    }

    /// The request with what the behaviour is a function of, as values.
    pub(super) fn request(&self, request: &Request, slides: bool) -> Request {
        let Self { behavior, drives, .. } = self;
        let has = |mask: Mask| mask.contains(&true);
        let is_damped = has(behavior.damping.components());
        let has_laws = slides || is_damped || has(behavior.elasticity.components());
        let driven = [0, 1, 2, 3, 4, 5].map(|k| drives.motions[k].is_some());
        let held = [0, 1, 2, 3, 4, 5].map(|k| driven[k] || behavior.limited()[k]);
        let of = |is: bool, mask: Mask| mask.map(|one| one && is);
        let all = behavior.available();
        let mut needed = request.clone();
        for (output, mask) in [
            (Output::CP, behavior.limited()),
            (Output::CP, of(has_laws, all)),
            (Output::CCU, of(has_laws, all)),
            // Where a friction acts may depend on the angles of constrained components too.
            (Output::CP, [slides; 6]),
            (Output::CCU, [slides; 6]),
            (Output::CU, of(is_damped || slides, all)),
            (Output::CU, driven),
            (Output::CV, of(is_damped, all)),
            (Output::CV, of(wants(request, Output::RESV), held)),
            (Output::CA, of(wants(request, Output::RESA), held)),
        ] {
            needed.add_values(output, mask);
        }
        needed
    }
}

/// Whether an output is wanted of any component.
pub(super) fn wants(request: &Request, output: Output) -> bool {
    (0..6).any(|k| request.wants(output, k))
}

/// An event as a flag.
pub(super) fn flag(event: Event) -> Flag {
    let name = |k: usize| COMPONENT[k];
    match event {
        Event::Kink(ForceKink { component, kink }) => {
            Flag::ForceKink { component: name(component), at: kink.at, left: kink.left, right: kink.right }
        }
        Event::BeyondStop { component, by } => Flag::BeyondStop { component: name(component), by },
        Event::StopPulls { component, reaction } => Flag::StopPulls { component: name(component), reaction },
        Event::Locked { component, by } => Flag::Locked { component: name(component), limit: by.in_words() },
        Event::Failed { component, by } => Flag::Failed { component: name(component), limit: by.in_words() },
        Event::Undecided { component, is_failure, why } => Flag::Undecided {
            component: name(component),
            criterion: if is_failure { "failure" } else { "lock" },
            why: why.in_words(),
        },
        Event::OutOfBalance { component, by } => Flag::OutOfBalance { component: name(component), by },
    }
}

/// The forces that are asked for and not known.
pub(super) fn not_known(outcome: &Outcome, request: &Request) -> Vec<Flag> {
    let mut flags = Vec::new();
    for (k, component) in COMPONENT.into_iter().enumerate() {
        for (output, forces) in [
            (Output::CTF, &outcome.total),
            (Output::CEF, &outcome.elastic),
            (Output::CVF, &outcome.viscous),
            (Output::CSF, &outcome.friction),
            (Output::CRF, &outcome.reaction),
            (Output::CCF, &outcome.load),
        ] {
            if let (true, Some(unknown)) = (request.wants(output, k), forces.unknown[k]) {
                flags.push(Flag::NotKnown { component, quantity: output.name(), why: unknown.in_words() });
            }
        }
        if let (true, Some(Prescribed::Unknown(_, unknown))) =
            (request.wants(Output::DRIVEN, k), outcome.prescribed[k])
        {
            flags.push(Flag::NotKnown {
                component,
                quantity: Output::DRIVEN.name(),
                why: unknown.in_words(),
            });
        }
    }
    flags.extend(frictions(outcome, request));
    flags
}

/// The outputs of a friction beside its force.
const OF_FRICTION: [Output; 4] = [Output::CNF, Output::CASU, Output::CIVC, Output::SLIP];

/// The outputs that are slopes of forces.
pub(super) const SLOPES: [Output; 4] = [Output::TANGENT, Output::KT, Output::CT, Output::KR];

/// The slopes that are asked for and not known.
pub(super) fn slopes_not_known(tangent: &Tangent<f64>, request: &Request) -> Vec<Flag> {
    let flag = |(k, why): (usize, Unknown)| Flag::NotKnown {
        component: COMPONENT[k],
        quantity: Output::TANGENT.name(),
        why: why.in_words(),
    };
    let unknown = tangent.unknown.into_iter().enumerate();
    let wanted = unknown.filter(|(k, _)| request.wants(Output::TANGENT, *k));
    wanted.filter_map(|(k, why)| Some(flag((k, why?)))).collect()
}

/// What of frictions is asked for and not known, or needs care.
fn frictions(outcome: &Outcome, request: &Request) -> Vec<Flag> {
    let mut flags = Vec::new();
    let wants_slopes = SLOPES.into_iter().any(|output| wants(request, output));
    for slip in &outcome.slips {
        let sliding = || (0..6).filter(|k| slip.components[*k]);
        let component = match (sliding().next(), sliding().count()) {
            (Some(k), 1) => COMPONENT[k],
            _ => "C",
        };
        let wants = |output: Output| sliding().any(|k| request.wants(output, k));
        for output in OF_FRICTION.into_iter().filter(|output| wants(*output)) {
            let lacks_rate = output == Output::CIVC && outcome.duration.is_none();
            let unknown = slip.outcome.as_ref().err().copied().or(lacks_rate.then_some(Unknown::TimeStep));
            flags.extend(unknown.map(|unknown| Flag::NotKnown {
                component,
                quantity: output.name(),
                why: unknown.in_words(),
            }));
        }
        if let Ok(slip) = &slip.outcome
            && (wants_slopes || wants(Output::CSF) || OF_FRICTION.into_iter().any(wants))
        {
            let told = slip.flags.iter().filter(|flag| wants_slopes || !concerns_derivatives(flag));
            flags.extend(told.map(|flag| Flag::Friction { component, what: flag.name() }));
        }
    }
    flags
}

/// Whether a flag says that a derivative of friction, which is not reported here, does not exist, while the value is exact.
const fn concerns_derivatives(flag: &friction::Flag) -> bool {
    use friction::Flag;
    matches!(
        flag,
        Flag::NoTraction
            | Flag::LoadAtZero { .. }
            | Flag::NoContactForce
            | Flag::MacauleyAtZero { .. }
            | Flag::ContributionAtZero { .. }
            | Flag::InfiniteCurvature { .. }
            | Flag::TiedMaximum { .. }
            | Flag::TableRow { .. }
            | Flag::LimitAtMaximum
            | Flag::WrapAngle { .. }
    )
}
