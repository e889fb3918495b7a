//! Which contact forces are always zero?

use pintle_kinematics::catalog::{COMPONENT, PLANE, SPATIAL, component_index};
use pintle_model::behavior::entry;
use pintle_model::evaluate::ConnectorElement;
use pintle_scene::{Affected, Behavior, DerivedTerm, Friction, FrictionKind, Law, Source, TableRow};

/// Why a source of contact force is zero in every state; `None` where it need not be.
pub(super) fn nothing_presses(
    element: &ConnectorElement,
    behavior: &Behavior,
    source: &Source,
) -> Option<String> {
    match source {
        Source::Component(component) => {
            let k = component_index(*component)?;
            (!has_force(element, behavior, k)).then(|| without_force(behavior, k))
        }
        Source::Derived(name) => {
            let terms = behavior.derived_components.get(name)?;
            let whys: Vec<String> =
                terms.iter().map(|term| vanishes(element, behavior, term)).collect::<Option<_>>()?;
            let mut whys: Vec<String> = whys.into_iter().filter(|why| !why.is_empty()).collect();
            whys.dedup();
            Some(if whys.is_empty() {
                format!("derived component {name} has no term")
            } else {
                format!("every term of derived component {name} vanishes ({})", whys.join("; "))
            })
        }
    }
}

fn without_force(behavior: &Behavior, k: usize) -> String {
    let name = COMPONENT[k];
    let has_law = laws(behavior).any(|law| law.components().iter().any(|of| component_index(*of) == Some(k)));
    if has_law { format!("the force of {name} is zero by its table") } else { format!("{name} has no force") }
}

/// The elastic and viscous laws.
fn laws(behavior: &Behavior) -> impl Iterator<Item = &Law> {
    let elastic = behavior.elasticity.iter().map(|elasticity| &elasticity.law);
    elastic.chain(behavior.damping.iter().map(|damping| &damping.law))
}

/// Whether a law may give a component a force: where it is a table, a number of it that is of the component is not zero.
fn gives_force(law: &Law, k: usize) -> bool {
    let is_it = |component: &u8| component_index(*component) == Some(k);
    let is_given = |rows: &[TableRow], at: usize| {
        // What has no row is refused by a rule.
        rows.is_empty() || rows.iter().any(|row| row.values.get(at).copied().flatten().unwrap_or(0.0) != 0.0)
    };
    match law {
        Law::Linear { component, rows } | Law::Nonlinear { component, rows, .. } => {
            is_it(component) && is_given(rows, 0)
        }
        Law::Coupled { unsymmetric, rows, .. } => (0..6)
            .any(|j| is_given(rows, entry(*unsymmetric, k, j)) || is_given(rows, entry(*unsymmetric, j, k))),
        Law::Rigid { components } => components.is_empty() || components.iter().any(is_it),
    }
}

/// Why a term of a derived component is zero whatever the forces.
fn vanishes(element: &ConnectorElement, behavior: &Behavior, term: &DerivedTerm) -> Option<String> {
    let mut whys = Vec::new();
    for (place, component) in term.components.iter().enumerate() {
        let k = component_index(*component)?;
        let is_zero = !term.rows.is_empty()
            && term.rows.iter().all(|row| row.values.get(place).copied().flatten() == Some(0.0));
        if is_zero {
            whys.push(format!("the factor of {} is zero", COMPONENT[k]));
        } else if has_force(element, behavior, k) {
            return None;
        } else {
            whys.push(without_force(behavior, k));
        }
    }
    Some(whys.join(", "))
}

/// Whether a friction may act in any component: one by a potential, or a predefined one.
fn slips_in_several(friction: &Friction) -> bool {
    match &friction.kind {
        FrictionKind::Predefined { .. } => true,
        FrictionKind::User { potential, .. } => potential.is_some(),
    }
}

/// Whether a component may have a force: a reaction where it is constrained or driven, or that of a behaviour.
fn has_force(element: &ConnectorElement, behavior: &Behavior, k: usize) -> bool {
    let present = if element.is_planar() { PLANE } else { SPATIAL };
    if element.connector.is_constrained(k) {
        return true;
    }
    if !element.connector.connection().slots[k].is_available() || !present[k] {
        return false;
    }
    let is_it = |component: u8| component_index(component) == Some(k);
    let slips = |friction: &Friction| matches!(friction.kind, FrictionKind::User { component: Some(component), .. } if is_it(component));
    laws(behavior).any(|law| gives_force(law, k))
        || behavior.friction.iter().any(slips)
        || behavior.plasticity.iter().filter_map(|plasticity| plasticity.component).any(is_it)
        || behavior.plasticity.iter().any(|plasticity| plasticity.component.is_none())
        || behavior.friction.iter().any(slips_in_several)
        || behavior.stops.iter().any(|stop| is_it(stop.component))
        || behavior.locks.iter().any(|lock| match lock.locked {
            Affected::All => true,
            Affected::Component(component) => is_it(component),
        })
        || element.behavior.drives.motions[k].is_some()
}
