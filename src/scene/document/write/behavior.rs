//! A behaviour as a document.

use crate::behavior::{
    Affected, Behavior, Damage, DamageEvolution, Friction, FrictionKind, FrictionLaw, Hardening, Law, Limits,
    Potential, Source, TableOptions,
};
use crate::document::form;
use crate::document::form::placeless;
use crate::document::write::{
    component, components, dependencies, entries, independent, items, list, maybe, raw, table, unless,
};
use crate::span::Spanned;

pub(super) fn behavior(behavior: &Behavior) -> form::Behavior {
    let Behavior {
        table: options,
        integration,
        constitutive_reference,
        constitutive_reference_span: _,
        elasticity,
        damping,
        friction,
        derived_components,
        plasticity,
        damage,
        uniaxial: _,
        stops,
        locks,
        failures,
        span: _,
    } = behavior;
    let reference = constitutive_reference.iter().zip(1..).filter_map(|(value, component): (_, u8)| {
        value.map(|value| (component.to_string(), placeless(value)))
    });
    let lock = |component_: u8, affected: Affected, limits_: &[Limits], table: TableOptions| {
        let affected = match affected {
            Affected::All => None,
            Affected::Component(affected) => Some(component(affected)),
        };
        let limits = list(limits_, limits);
        let mut lock =
            form::Lock { component: component(component_), affected, limits, ..form::Lock::default() };
        lock.set_options(table);
        lock
    };
    let mut form = form::Behavior {
        integration: *integration,
        constitutive_reference: reference.collect(),
        elasticity: list(elasticity, |elasticity| law(&elasticity.law, elasticity.table)),
        damping: list(damping, |damping| {
            let kind = crate::behavior::DampingKind::Viscous;
            form::Law {
                r#type: (damping.kind != kind).then_some(damping.kind),
                ..law(&damping.law, damping.table)
            }
        }),
        friction: list(friction, self::friction),
        derived_components: entries(derived_components, |terms| {
            list(terms, |term| {
                let mut form = form::DerivedTerm {
                    components: components(&term.components),
                    operator: Some(term.operator),
                    negative: term.sign < 0.0,
                    independent: independent(term.independent.as_ref()),
                    rows: table(&term.rows),
                    ..form::DerivedTerm::default()
                };
                form.set_options(term.table);
                form
            })
        }),
        plasticity: list(plasticity, |plasticity| form::Plasticity {
            component: plasticity.component.map(component),
            potential: plasticity.potential.as_ref().map(potential),
            hardening: list(&plasticity.hardening, hardening),
        }),
        damage: list(damage, self::damage),
        stops: list(stops, |stop| form::Stop {
            component: component(stop.component),
            lower: maybe(stop.lower),
            upper: maybe(stop.upper),
        }),
        locks: list(locks, |given| lock(given.component, given.locked, &given.limits, given.table)),
        failures: list(failures, |given| {
            lock(given.component, given.released, &given.limits, TableOptions::default())
        }),
        ..form::Behavior::default()
    };
    form.set_options(*options);
    form
}

fn limits(limits: &Limits) -> form::Limits {
    let Limits { lower_position, upper_position, lower_force, upper_force, temperature, fields } = limits;
    form::Limits {
        lower_position: maybe(*lower_position),
        upper_position: maybe(*upper_position),
        lower_force: maybe(*lower_force),
        upper_force: maybe(*upper_force),
        temperature: maybe(*temperature),
        fields: items(fields),
    }
}

fn law(law: &Law, options: TableOptions) -> form::Law {
    let mut form = match law {
        Law::Linear { component: given, rows } => {
            form::Law { component: Some(component(*given)), rows: table(rows), ..form::Law::default() }
        }
        Law::Coupled { unsymmetric, frequency, rows } => form::Law {
            unsymmetric: *unsymmetric,
            frequency_dependence: *frequency,
            rows: table(rows),
            ..form::Law::default()
        },
        Law::Nonlinear { component: given, independent: on, rows } => form::Law {
            component: Some(component(*given)),
            nonlinear: true,
            independent: independent(on.as_ref()),
            rows: table(rows),
            ..form::Law::default()
        },
        Law::Rigid { components: given } => {
            form::Law { rigid: true, components: components(given), ..form::Law::default() }
        }
    };
    form.set_options(options);
    form
}

fn source(given: &Spanned<Source>) -> Spanned<form::Source> {
    placeless(match &given.value {
        Source::Component(component) => form::Source::Component((*component).into()),
        Source::Derived(name) => form::Source::Derived(name.clone()),
    })
}

fn potential(potential: &Potential) -> Spanned<form::Potential> {
    use crate::behavior::{PotentialFunction, PotentialOperator};
    let Potential { operator, exponent, terms, span: _ } = potential;
    placeless(form::Potential {
        terms: list(terms, |term| form::PotentialTerm {
            of: source(&term.source),
            scale: unless(term.scale, 1.0),
            exponent: maybe(term.exponent),
            function: (term.function != PotentialFunction::Abs).then_some(term.function),
            shift: unless(term.shift, 0.0),
            sign: unless(term.sign, 1.0),
        }),
        operator: (*operator != PotentialOperator::Sum).then_some(*operator),
        exponent: unless(*exponent, 2.0),
    })
}

pub(super) fn friction(friction: &Friction) -> form::Friction {
    let Friction { stick_stiffness, kind, coefficient, table: options, span: _ } = friction;
    let mut form = match kind {
        FrictionKind::Predefined { constants } => {
            form::Friction { predefined: Some(placeless(items(constants))), ..form::Friction::default() }
        }
        FrictionKind::User { component: given, potential: along, contact_force, independent: on, rows } => {
            let others = 4 + on.as_ref().map_or(0, |on| on.components.len());
            form::Friction {
                component: given.map(component),
                potential: along.as_ref().map(potential),
                contact_force: contact_force.as_ref().map(source),
                independent: independent(on.as_ref()),
                dependencies: dependencies(rows, others),
                rows: raw(rows),
                ..form::Friction::default()
            }
        }
    };
    form.stick_stiffness = maybe(*stick_stiffness);
    form.coefficient = coefficient.as_ref().map(|coefficient| {
        let mut form = form::Coefficient {
            maximum: maybe(coefficient.maximum),
            slip_tolerance: maybe(coefficient.slip_tolerance),
            elastic_slip: maybe(coefficient.elastic_slip),
            ..form::Coefficient::default()
        };
        match &coefficient.law {
            FrictionLaw::Table(rows) => form.rows = table(rows),
            FrictionLaw::Exponential { static_coefficient, kinetic_coefficient, decay } => {
                form.exponential = Some(placeless([*static_coefficient, *kinetic_coefficient, *decay]));
            }
            FrictionLaw::TestData(rows) => form.test_data = raw(rows),
        }
        placeless(form)
    });
    form.set_options(*options);
    form
}

fn hardening(hardening: &Hardening) -> form::Hardening {
    let Hardening { kind, definition, rate_filter, rate_interpolation, rows, table: options } = hardening;
    let mut form = form::Hardening {
        rows: table(rows),
        r#type: Some(*kind),
        definition: Some(*definition),
        rate_filter: maybe(*rate_filter),
        rate_interpolation: *rate_interpolation,
        ..form::Hardening::default()
    };
    form.set_options(*options);
    form
}

fn damage(damage: &Damage) -> form::Damage {
    let Damage {
        criterion,
        component: given,
        potential: coupled,
        rows,
        rate_filter,
        rate_interpolation,
        evolution: growth,
        table: options,
        span: _,
    } = damage;
    let mut form = form::Damage {
        rows: raw(rows),
        criterion: Some(*criterion),
        component: given.map(component),
        potential: coupled.as_ref().map(potential),
        dependencies: dependencies(rows, 4),
        rate_filter: maybe(*rate_filter),
        rate_interpolation: *rate_interpolation,
        evolution: growth.as_ref().map(|growth| placeless(evolution(growth))),
        ..form::Damage::default()
    };
    form.set_options(*options);
    form
}

fn evolution(evolution: &DamageEvolution) -> form::DamageEvolution {
    let DamageEvolution { kind, softening, degradation, affected, potential: coupled, rows, table: options } =
        evolution;
    let mut form = form::DamageEvolution {
        rows: raw(rows),
        r#type: Some(*kind),
        softening: Some(*softening),
        degradation: Some(*degradation),
        affected: components(affected),
        potential: coupled.as_ref().map(potential),
        dependencies: dependencies(rows, 4),
        ..form::DamageEvolution::default()
    };
    form.set_options(*options);
    form
}
