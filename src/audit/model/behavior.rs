//! Does what is attached to components act as it looks? Stops and locks that are passed initially or never met, entries that are ignored,
//! frictions that vanish.

use super::finding::{About, Finding};
use super::gather::Gathered;
use super::geometry::initial_positions;
use super::levels::Levels;
use super::pressing::nothing_presses;
use crate::behavior::entry;
use crate::catalog::{
    COMPONENT, Contact, FrictionCriterion, Load, PLANE, Quantity, SPATIAL, Traction, component_index,
};
use crate::connector::Components;
use crate::evaluate::{ConnectorElement, Model};
use crate::grammar::agree;
use crate::scene::{self, Behavior, Code, FrictionKind, FrictionLaw, Law, Limits, Scene, Span};

/// What is found of the behaviours of connectors.
pub(super) fn findings(scene: &Scene, model: &Model, levels: &Levels) -> Vec<Finding> {
    let mut gathered = Gathered::new(levels);
    for element in &model.connectors {
        let Some(given) = scene.connectors.get(&element.label) else { continue };
        let Some(behavior) = scene.section(given).and_then(|section| scene.behavior(section)) else {
            continue;
        };
        let needs_positions =
            !behavior.stops.is_empty() || !behavior.locks.is_empty() || !behavior.failures.is_empty();
        let positions = if needs_positions { initial_positions(element) } else { [None; 6] };
        let mut found = Vec::new();
        let beyond = |stop| violated(scene, element, stop, &positions, None);
        found.extend(behavior.stops.iter().filter_map(beyond));
        let locks = behavior.locks.iter().map(|lock| ("lock", lock.component, &lock.limits, lock.span));
        let failures =
            behavior.failures.iter().map(|fail| ("failure", fail.component, &fail.limits, fail.span));
        for law in locks.chain(failures) {
            found.extend(
                passed(scene, element, law, &positions).or_else(|| idle(scene, element, law, &positions)),
            );
        }
        found.extend(ignored(scene, element, behavior));
        for friction in &behavior.friction {
            found.extend(vanishing(scene, element, behavior, friction));
        }
        for finding in found {
            gathered.add(given.section, element.label, finding, |new, old| new.value > old.value);
        }
    }
    gathered.findings().collect()
}

fn about(element: &ConnectorElement, component: usize, value: f64) -> About {
    let components = vec![COMPONENT[component].to_string()];
    About { elements: vec![element.label], components, value: Some(value), ..About::default() }
}

/// Stops that are passed at the first state given, and not initially already.
pub(super) fn violated_at_first(
    scene: &Scene,
    element: &ConnectorElement,
    positions: &Components<f64>,
    state: u64,
) -> Vec<Finding> {
    let section = scene.connectors.get(&element.label).and_then(|given| scene.section(given));
    let Some(behavior) = section.and_then(|section| scene.behavior(section)) else { return Vec::new() };
    if behavior.stops.is_empty() {
        return Vec::new();
    }
    let initial = initial_positions(element);
    let is_new = |stop: &&scene::Stop| violated(scene, element, stop, &initial, None).is_none();
    let stops = behavior.stops.iter().filter(is_new);
    stops.filter_map(|stop| violated(scene, element, stop, positions, Some(state))).collect()
}

/// A stop that the position lies beyond, initially or at the first state given, of this number.
fn violated(
    scene: &Scene,
    element: &ConnectorElement,
    stop: &scene::Stop,
    positions: &Components<f64>,
    state: Option<u64>,
) -> Option<Finding> {
    let k = component_index(stop.component)?;
    let position = positions[k]?;
    let below = stop.lower.filter(|lower| position < *lower).map(|lower| (lower - position, "below", lower));
    let above = stop.upper.filter(|upper| position > *upper).map(|upper| (position - upper, "above", upper));
    let (by, side, limit) = below.or(above)?;
    let when = match state {
        None => "initially".to_string(),
        Some(state) => format!("at state {state}, the first one given"),
    };
    let message = format!(
        "element {}: {} is {position:.6} {when}, {by:.3e} {side} its stop at {limit}",
        element.label, COMPONENT[k]
    );
    let reason = "stops limit the position (CP), not the displacement from the initial one; angles in rad";
    let remedy = match state {
        None => "move the stop or the nodes, so that the initial position lies within",
        Some(_) => "move the stop, or begin with a state at which the position lies within",
    };
    let finding = Finding::new(scene, Code::ModelStopViolated, stop.span, message, reason, remedy);
    Some(finding.about(About { state, ..about(element, k, by) }))
}

/// A lock or failure of which a limit of position is passed initially.
fn passed(
    scene: &Scene,
    element: &ConnectorElement,
    (what, component, limits, span): (&str, u8, &Vec<Limits>, Span),
    positions: &Components<f64>,
) -> Option<Finding> {
    let k = component_index(component)?;
    let position = positions[k]?;
    // Limits that depend on temperature or fields are those of the first row.
    let first = limits.first()?;
    let below = first.lower_position.filter(|lower| position < *lower);
    let above = first.upper_position.filter(|upper| position > *upper);
    let limit = below.or(above)?;
    let message = format!(
        "element {}: {} is {position:.6} initially, beyond the limit {limit} of a {what}, which acts from the start",
        element.label, COMPONENT[k]
    );
    let reason =
        "limits are those of the position (CP), not of the displacement from the initial one; angles in rad";
    let remedy = "move the limit or the nodes, so that the initial position lies within";
    let finding = Finding::new(scene, Code::ModelLockMet, span, message, reason, remedy);
    Some(finding.about(about(element, k, (position - limit).abs())))
}

/// A lock or failure of which all limits are of the position of a component that is constrained and stays within them.
fn idle(
    scene: &Scene,
    element: &ConnectorElement,
    (what, component, limits, span): (&str, u8, &Vec<Limits>, Span),
    positions: &Components<f64>,
) -> Option<Finding> {
    let k = component_index(component)?;
    let position = positions[k].filter(|_| element.connector.is_constrained(k))?;
    let of_force = |limit: &Limits| limit.lower_force.is_some() || limit.upper_force.is_some();
    let of_position = |limit: &Limits| limit.lower_position.is_some() || limit.upper_position.is_some();
    if limits.iter().any(of_force) || !limits.iter().any(of_position) {
        return None;
    }
    let name = COMPONENT[k];
    let message = format!(
        "element {}: a {what} is triggered by the position of {name} alone, which {} constrains: it stays at {position:.6}, within the limits",
        element.label,
        element.connector.connection().name
    );
    let reason = "what is constrained does not move, so that its position passes no limit";
    let remedy = "limit the force of the component, or the position of one that is available";
    let finding = Finding::new(scene, Code::ModelLimitUnreachable, span, message, reason, remedy);
    let about =
        About { elements: vec![element.label], components: vec![name.to_string()], ..About::default() };
    Some(finding.about(about))
}

/// Entries of coupled tables, not zero, for components that are not available: they are ignored.
fn ignored(scene: &Scene, element: &ConnectorElement, behavior: &Behavior) -> Option<Finding> {
    /// The entries that a message names.
    const NAMED: usize = 8;
    let present = if element.is_planar() { PLANE } else { SPATIAL };
    let connection = element.connector.connection();
    let is_available = |k: usize| connection.slots[k].is_available() && present[k];
    let elasticities = behavior.elasticity.iter().map(|law| ("elasticity", "D", &law.law, law.span));
    let dampings = behavior.damping.iter().map(|law| ("damping", "C", &law.law, law.span));
    let (mut told, mut place, mut count) = (Vec::new(), None, 0);
    for (what, letter, law, span) in elasticities.chain(dampings) {
        let Law::Coupled { unsymmetric, rows, .. } = law else { continue };
        let is_given = |at: usize| {
            rows.iter().any(|row| row.values.get(at).copied().flatten().is_some_and(|value| value != 0.0))
        };
        let pairs = (0..6).flat_map(|j| (0..6).map(move |i| (i, j)));
        let names: Vec<String> = pairs
            .filter(|(i, j)| *unsymmetric || i <= j)
            .filter(|(i, j)| !(is_available(*i) && is_available(*j)) && is_given(entry(*unsymmetric, *i, *j)))
            .map(|(i, j)| format!("{letter}{}{}", i + 1, j + 1))
            .collect();
        if names.is_empty() {
            continue;
        }
        count += names.len();
        place = place.or(Some(span));
        let more = match names.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        told.push(format!("{} of its coupled {what}{more}", names[..names.len().min(NAMED)].join(", ")));
    }
    let unavailable = (0..6).filter(|k| !is_available(*k)).map(|k| COMPONENT[k].to_string()).collect();
    let message = format!(
        "element {}: {} {} ignored, for {} does not leave all of their components available",
        element.label,
        told.join(", and "),
        agree(count, ["is", "are"]),
        connection.name
    );
    let reason = "a coupled matrix acts between available components only; entries of others are left out, whatever they are";
    let remedy = "write 0 for them, or choose a type that leaves the components available";
    let finding = Finding::new(scene, Code::ModelEntriesIgnored, place?, message, reason, remedy);
    let about = About {
        elements: vec![element.label],
        components: unavailable,
        value: Some(f64::from(u32::try_from(count).unwrap_or(u32::MAX))),
        ..About::default()
    };
    Some(finding.about(about))
}

/// What of a friction vanishes.
fn vanishing(
    scene: &Scene,
    element: &ConnectorElement,
    behavior: &Behavior,
    friction: &scene::Friction,
) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut tell = |what: String, reason: &str, remedy: &str, component: String| {
        let message = format!("element {}: {what}", element.label);
        let finding =
            Finding::new(scene, Code::ModelFrictionVanishes, friction.span, message, reason, remedy);
        let about = About { elements: vec![element.label], components: vec![component], ..About::default() };
        found.push(finding.about(about));
    };
    if let Some(coefficient) = &friction.coefficient {
        let is_zero = match &coefficient.law {
            FrictionLaw::Table(rows) => {
                !rows.is_empty()
                    && rows.iter().all(|row| row.values.first().copied().flatten().unwrap_or(0.0) == 0.0)
            }
            FrictionLaw::Exponential { static_coefficient, kinetic_coefficient, .. } => {
                *static_coefficient == 0.0 && *kinetic_coefficient == 0.0
            }
            FrictionLaw::TestData(_) => false,
        };
        if is_zero {
            tell(
                "the friction coefficient is zero: there is no friction".into(),
                "μ = 0",
                "give μ, or remove the friction",
                "μ".into(),
            );
        } else if let FrictionLaw::Exponential { kinetic_coefficient: 0.0, decay, .. } = &coefficient.law
            && *decay != 0.0
        {
            tell(
                "the kinetic friction coefficient is zero: friction vanishes the faster it slips".into(),
                "μ = μ_s exp(−d_c·slip rate), without the term of μ_k",
                "give μ_k, unless friction is meant to vanish in fast slip",
                "μ_k".into(),
            );
        }
        if !is_zero && coefficient.maximum == Some(0.0) {
            tell(
                "TAUMAX is zero: there is no friction".into(),
                "τ ≤ τ_max",
                "leave TAUMAX out, or give it",
                "τ_max".into(),
            );
        }
    }
    match &friction.kind {
        FrictionKind::Predefined { constants } => {
            let Some(of_type) = element.connector.connection().friction else { return found };
            let section = scene.connectors.get(&element.label).and_then(|given| scene.section(given));
            let angle = section.and_then(|section| section.section_data.get(1).copied().flatten());
            if element.connector.connection().is_belt() && angle == Some(0.0) {
                tell(
                    "the contact angle of the section is zero: the belt goes straight on at node b, and there is no friction".into(),
                    "F_C (exp(μ α) − 1) with α = 0",
                    "give the angle of wrap (rad) as the second number of the section, or remove the friction",
                    "α".into(),
                );
            }
            let present = if element.is_planar() { PLANE } else { SPATIAL };
            for (i, parameter) in of_type.parameters.iter().enumerate() {
                if constants.get(i).copied().flatten().unwrap_or(0.0) != 0.0 {
                    continue;
                }
                let lost: Vec<String> =
                    of_type.criteria.iter().flat_map(|criterion| lost(criterion, i, present)).collect();
                if lost.is_empty() {
                    continue;
                }
                let what = format!(
                    "{} of the predefined friction is {}: {}",
                    parameter.symbol,
                    if constants.get(i).copied().flatten().is_some() { "zero" } else { "left out, so zero" },
                    lost.join("; ")
                );
                let reason =
                    "a term that is multiplied by a parameter that is zero, or divided by one, is left out";
                tell(
                    what,
                    reason,
                    "give the parameter, unless the term is meant to vanish",
                    parameter.symbol.into(),
                );
            }
        }
        FrictionKind::User { contact_force: None, rows, .. } => {
            let is_zero = rows.iter().flatten().all(|value| value.unwrap_or(0.0) == 0.0);
            if is_zero {
                let what =
                    "neither a contact force nor an internal one is given: nothing presses".to_string();
                tell(
                    what,
                    "F_N = |F_C + F_C^int| = 0",
                    "name CONTACT FORCE, or give the internal contact force",
                    "F_N".into(),
                );
            }
        }
        FrictionKind::User { contact_force: Some(source), rows, .. } => {
            if let Some(why) = nothing_presses(element, behavior, &source.value) {
                // Items: radius, internal contact force …
                let is_internal =
                    rows.iter().any(|row| row.get(1).copied().flatten().is_some_and(|value| value != 0.0));
                let rest =
                    if is_internal { "only the internal contact force presses" } else { "nothing presses" };
                tell(
                    format!("the contact force is always zero, for {why}: {rest}"),
                    "F_N = |F_C + F_C^int| with F_C = 0",
                    "give the derived component factors that are not zero, of components that have a force, or name another contact force",
                    "F_C".into(),
                );
            }
        }
    }
    found
}

/// What of a criterion vanishes where parameter `i` is zero.
fn lost(criterion: &FrictionCriterion, i: usize, present: [bool; 6]) -> Vec<String> {
    let is = |quantity: &Quantity| *quantity == Quantity::Parameter(i);
    let feels = |load: &Load| Some(format!("the contact force does not feel {}", load.formula(present)?));
    let mut lost = Vec::new();
    if let Contact::Sum { arm, terms } = criterion.contact {
        if arm.iter().any(is) {
            lost.push("nothing but an internal contact force presses".to_string());
        } else {
            let gone =
                terms.iter().filter(|term| term.factor.over == Some(i) || term.factor.times.iter().any(is));
            lost.extend(gone.filter_map(|term| feels(&term.load)));
        }
    }
    let of_radius = |traction: &&Traction| traction.radius == Some(i) && present[traction.component];
    lost.extend(
        criterion
            .traction
            .iter()
            .filter(of_radius)
            .map(|traction| format!("{} meets no friction", COMPONENT[traction.component])),
    );
    lost
}
