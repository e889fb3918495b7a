//! The rules of the catalogue, asked about a scene: what is known of each connector, and where what breaks a rule was read.

use crate::behavior::entry;
use pintle_kinematics::catalog::{Breach, Evidence, Facts, Procedure, Rule};
use pintle_scene::grammar::number;
use pintle_scene::{
    Affected, Behavior, Code, ConnectorElement, ConnectorSection, DampingKind, Diagnostic, Dimension, Label,
    LabelMap, Law, Lock, MpcKind, NodeFreedom, Scene, Solver, Span, Spanned, System, Target,
};

/// The components (0-based) of each connector that motions and loads act on, and where they were read.
pub(super) fn actions(scene: &Scene) -> LabelMap<Vec<(usize, Span)>> {
    let mut found: LabelMap<Vec<(usize, Span)>> = LabelMap::default();
    let mut act = |target: &Spanned<Target>, component: u8| {
        for label in labels(scene, &target.value) {
            found.entry(*label).or_default().push((usize::from(component) - 1, target.span));
        }
    };
    for motion in scene.connector_motions.iter().chain(scene.steps.iter().flat_map(|s| &s.connector_motions))
    {
        act(&motion.target, motion.component);
    }
    for load in scene.steps.iter().flat_map(|step| &step.connector_loads) {
        act(&load.target, load.component);
    }
    found
}

/// The elements that a target names.
pub(super) fn labels<'a>(scene: &'a Scene, target: &'a Target) -> &'a [Label] {
    match target {
        Target::Label(label) => std::slice::from_ref(label),
        Target::Set(name) => scene.element_sets.get(name.as_str()).map_or(&[], |set| set.labels.as_slice()),
    }
}

/// What the rules of its type ask about one connector.
pub(super) fn facts(
    scene: &Scene,
    (section, element): (&ConnectorSection, &ConnectorElement),
    behavior: Option<&Behavior>,
    acting: &[(usize, Span)],
    coincident: bool,
) -> Facts {
    let orientations = [&section.orientation_a, &section.orientation_b];
    let mut facts = Facts {
        orientation: orientations.map(Option::is_some),
        planar: element.dimension == Dimension::Two,
        procedure: scene.solver.map(|solver| match solver {
            Solver::Standard => Procedure::Standard,
            Solver::Explicit => Procedure::Explicit,
        }),
        section_data: section.section_data.len(),
        contact_angle: matches!(section.section_data.get(1), Some(Some(_))),
        z_rectangular: z_rectangular(scene, section).next().is_some(),
        controls: section.controls.is_some(),
        elimination: section.elimination.is_some(),
        coincident,
        actions: acting.iter().map(|(k, _)| *k).collect(),
        ..Facts::default()
    };
    if let Some(behavior) = behavior {
        let index = |component: u8| usize::from(component) - 1;
        let affected = |affected: Affected| match affected {
            Affected::All => None,
            Affected::Component(component) => Some(index(component)),
        };
        // Zeros fill the places of components that have none.
        let is_given = |k: &usize| behavior.constitutive_reference[*k].is_some_and(|x| x != 0.0);
        facts.references = (0..6).filter(is_given).collect();
        let limits = behavior.limits_of_stops();
        facts.stops = (0..6).filter(|k| limits[*k].is_some()).collect();
        facts.predefined_friction = behavior.predefined_friction_parameters();
        facts.friction_numbers = behavior.friction.iter().find_map(constants).unwrap_or_default();
        facts.lock_temperature = behavior.locks.iter().any(has_fifth_item);
        facts.actions.extend(behavior.acts_on().map(index));
        facts.integration = behavior.integration.is_some();
        facts.frequency = behavior.places_of_law(Law::depends_on_frequency).next().is_some();
        facts.unsymmetric = behavior.places_of_law(Law::is_unsymmetric).next().is_some();
        facts.structural_damping = structural(behavior).next().is_some();
        let failures = behavior.failures.iter();
        facts.failures = failures.map(|law| (index(law.component), affected(law.released))).collect();
        let locks = behavior.locks.iter();
        facts.locks = locks.map(|law| (index(law.component), affected(law.locked))).collect();
    }
    facts.actions.sort_unstable();
    facts.actions.dedup();
    facts
}

/// The orientations of a section that are given by SYSTEM=Z RECTANGULAR.
fn z_rectangular<'a>(
    scene: &'a Scene,
    section: &'a ConnectorSection,
) -> impl Iterator<Item = &'a Spanned<String>> {
    let named = [&section.orientation_a, &section.orientation_b].into_iter().flatten();
    named.filter(|name| {
        let orientation = scene.orientations.get(name.value.as_str());
        orientation.is_some_and(|orientation| orientation.system == System::ZRectangular)
    })
}

/// Whether a lock has items after its limits: temperature, or field variables.
fn has_fifth_item(lock: &Lock) -> bool {
    lock.limits.iter().any(|limit| limit.temperature.is_some() || limit.fields.iter().any(Option::is_some))
}

/// Which numbers of a predefined friction are not zero.
fn constants(friction: &pintle_scene::Friction) -> Option<Vec<bool>> {
    match &friction.kind {
        pintle_scene::FrictionKind::Predefined { constants } => {
            Some(constants.iter().map(|number| number.is_some_and(|number| number != 0.0)).collect())
        }
        pintle_scene::FrictionKind::User { .. } => None,
    }
}

/// Where structural damping was read.
fn structural(behavior: &Behavior) -> impl Iterator<Item = Span> {
    let structural = behavior.damping.iter().filter(|damping| damping.kind == DampingKind::Structural);
    structural.map(|damping| damping.span)
}

/// Where what breaks a rule was read, each place once: suboptions, motions and loads, an orientation; else the section.
pub(super) fn places(
    scene: &Scene,
    breach: &Breach,
    behavior: Option<&Behavior>,
    acting: &[(usize, Span)],
    (section, element): (&ConnectorSection, &ConnectorElement),
) -> Vec<Span> {
    let item = breach.item.unwrap_or_default();
    let orientation = || {
        let name = section.orientation_a.as_ref().or(section.orientation_b.as_ref());
        name.map(|name| name.span).into_iter().collect()
    };
    let exact: Vec<Span> = match (breach.rule, behavior) {
        (Rule::ActionNotAvailable, _) => {
            let laws = behavior.into_iter().flat_map(|behavior| behavior.places_of_action(item as u8 + 1));
            laws.chain(acting.iter().filter(|(k, _)| *k == item).map(|(_, span)| *span)).collect()
        }
        (Rule::OrientationIgnored, _) if breach.item == Some(1) => {
            section.orientation_b.iter().map(|name| name.span).collect()
        }
        (Rule::OrientationIgnored | Rule::DirectionNotInExplicit, _) => orientation(),
        (Rule::ZRectangularNotInExplicit, _) => z_rectangular(scene, section).map(|name| name.span).collect(),
        (Rule::ControlsNotInExplicit, _) => section.controls.iter().map(|name| name.span).collect(),
        (Rule::StopNotAvailable, Some(behavior)) => {
            let stops = behavior.stops.iter().filter(|stop| usize::from(stop.component) == item + 1);
            stops.map(|stop| stop.span).collect()
        }
        (Rule::ReferenceNotAvailable, Some(behavior)) => vec![behavior.constitutive_reference_span],
        (
            Rule::FrictionNotPredefined | Rule::FrictionParameters | Rule::FrictionParameterUnused,
            Some(behavior),
        ) => behavior.place_of_predefined_friction().into_iter().collect(),
        (Rule::LockVelocity, Some(behavior)) => {
            behavior.locks.iter().filter(|lock| has_fifth_item(lock)).map(|lock| lock.span).collect()
        }
        (Rule::IntegrationNotInStandard, Some(behavior)) => vec![behavior.span],
        (Rule::FrequencyNotInExplicit, Some(behavior)) => {
            behavior.places_of_law(Law::depends_on_frequency).collect()
        }
        (Rule::UnsymmetricNotInExplicit, Some(behavior)) => {
            behavior.places_of_law(Law::is_unsymmetric).collect()
        }
        (Rule::StructuralDampingNotInExplicit, Some(behavior)) => structural(behavior).collect(),
        (Rule::FailureNotAvailable, Some(behavior)) => {
            behavior.failures.get(item).map(|law| law.span).into_iter().collect()
        }
        (Rule::LockNotAvailable, Some(behavior)) => {
            behavior.locks.get(item).map(|law| law.span).into_iter().collect()
        }
        _ => Vec::new(),
    };
    let mut found = Vec::new();
    for span in exact.into_iter().filter(|span| span.is_known()) {
        if !found.contains(&span) {
            found.push(span);
        }
    }
    if found.is_empty() {
        found.push(if section.span.is_known() { section.span } else { element.span });
    }
    found
}

/// Rotations that are prescribed at nodes without rotational degrees of freedom.
pub(super) fn boundaries(scene: &Scene, freedom: &NodeFreedom, warnings: &mut Vec<Diagnostic>) {
    for boundary in scene.steps.iter().flat_map(|step| &step.boundaries) {
        let turns = boundary.degrees_of_freedom.iter().any(|dof| matches!(dof, 4..=6));
        if !turns || boundary.magnitude == 0.0 {
            continue;
        }
        let nodes: &[Label] = match &boundary.target.value {
            Target::Label(label) => std::slice::from_ref(label),
            Target::Set(name) => scene.node_sets.get(name.as_str()).map_or(&[], |set| set.labels.as_slice()),
        };
        let Some(node) = nodes.iter().find(|node| freedom.is_fixed_in_rotation(**node)) else { continue };
        let mut connectors = scene.connectors.iter();
        let of = connectors.find(|(_, element)| [element.a, element.b].contains(&Some(*node)));
        let element = of.map_or_else(String::new, |(label, _)| format!(" of element {label}"));
        let message =
            format!("node {node}{element} has no rotational degrees of freedom, and one is prescribed");
        let label = "by the connector element library, active degrees of freedom";
        let remedy =
            "name an orientation where the connection type permits one, or give the node an element ROTARYI";
        let warning = Diagnostic::warning(Code::NoRotation, boundary.target.span, message, label)
            .help(remedy)
            .in_scene(scene);
        warnings.push(match of {
            Some((label, _)) => warning.concerning(*label),
            None => warning,
        });
    }
}

/// Stiffnesses and damping coefficients that are negative, of each suboption the first.
pub(super) fn stiffnesses(scene: &Scene, warnings: &mut Vec<Diagnostic>) {
    let least = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::min);
    let of_law = |law: &Law| match law {
        Law::Linear { rows, .. } => {
            least(&mut rows.iter().filter_map(|row| row.values.first().copied().flatten()))
        }
        Law::Coupled { unsymmetric, rows, .. } => least(&mut rows.iter().flat_map(|row| {
            (0..6).filter_map(|k| row.values.get(entry(*unsymmetric, k, k)).copied().flatten())
        })),
        Law::Nonlinear { .. } | Law::Rigid { .. } => 0.0,
    };
    // A table whose force is positive first and negative beyond pushes away from where it is zero.
    let falls = |law: &Law| match law {
        Law::Nonlinear { rows, .. } => {
            let forces = rows.iter().filter_map(|row| row.values.first().copied().flatten());
            let signs: Vec<f64> = forces.filter(|force| *force != 0.0).map(f64::signum).collect();
            signs.windows(2).any(|pair| pair[0] > pair[1])
        }
        _ => false,
    };
    for (name, behavior) in &scene.behaviors {
        let elastic = behavior.elasticity.iter().map(|one| (&one.law, one.span, "stiffness"));
        let viscous = behavior.damping.iter().map(|one| (&one.law, one.span, "damping coefficient"));
        for (law, span, what) in elastic.chain(viscous) {
            let least = of_law(law);
            let falls = falls(law);
            if least < 0.0 || falls {
                let message = match falls {
                    true => format!(
                        "a {what} of behavior {name} is negative where the force of its table is zero"
                    ),
                    false => format!("a {what} of behavior {name} is negative: {}", number(least, 6)),
                };
                let reason = "a negative one pushes away from where the force is zero, or feeds energy in";
                let warning = Diagnostic::finding(Code::ModelNegativeStiffness, span, message, reason)
                    .help("remove the minus sign, or allow this code where it is meant");
                warnings.push(warning.in_scene(scene));
            }
        }
    }
}

/// Multi-point constraints that Explicit does not have.
pub(super) fn constraints(scene: &Scene) -> impl Iterator<Item = Diagnostic> {
    let turning = |kind: &MpcKind| kind.evaluated().is_some_and(|kind| kind.entry().standard_only);
    let is_refused = scene.solver == Some(Solver::Explicit);
    scene.mpcs.iter().filter(move |mpc| is_refused && turning(&mpc.kind)).map(|mpc| {
        let name = mpc.kind.name();
        let message = format!("the multi-point constraint {name} is available only in Abaqus/Standard");
        let label = "by keyword *MPC";
        Diagnostic::error(Code::MpcNotInExplicit, mpc.span, message, label)
            .help("use the connection type HINGE or UJOINT, or an implicit step")
            .in_scene(scene)
    })
}

/// The stable code of a rule.
const fn code(rule: Rule) -> Code {
    match rule {
        Rule::OrientationRequired => Code::OrientationRequired,
        Rule::OrientationIgnored => Code::OrientationIgnored,
        Rule::NotInTwoDimensions => Code::NotInTwoDimensions,
        Rule::NotInProcedure => Code::NotInProcedure,
        Rule::StopNotAvailable => Code::StopNotAvailable,
        Rule::ReferenceNotAvailable => Code::ReferenceNotAvailable,
        Rule::ActionNotAvailable => Code::ActionNotAvailable,
        Rule::FrictionNotPredefined => Code::FrictionNotPredefined,
        Rule::FrictionParameters => Code::FrictionParameters,
        Rule::SectionDataUnused => Code::SectionDataUnused,
        Rule::CoincidentNodes => Code::CoincidentNodes,
        Rule::ZRectangularNotInExplicit => Code::ZRectangularNotInExplicit,
        Rule::DirectionNotInExplicit => Code::DirectionNotInExplicit,
        Rule::ControlsNotInExplicit => Code::ControlsNotInExplicit,
        Rule::EliminationNotInStandard => Code::EliminationNotInStandard,
        Rule::IntegrationNotInStandard => Code::IntegrationNotInStandard,
        Rule::FrequencyNotInExplicit => Code::FrequencyNotInExplicit,
        Rule::UnsymmetricNotInExplicit => Code::UnsymmetricNotInExplicit,
        Rule::StructuralDampingNotInExplicit => Code::StructuralDampingNotInExplicit,
        Rule::FailureNotAvailable => Code::FailureNotAvailable,
        Rule::LockNotAvailable => Code::LockNotAvailable,
        Rule::ContactAngleDefault => Code::ContactAngleDefault,
        Rule::FrictionParameterUnused => Code::FrictionParameterUnused,
        Rule::LockVelocity => Code::LockVelocity,
    }
}

/// A broken rule as a diagnostic, naming the element and the source of the rule.
pub(super) fn diagnose(breach: &Breach, label: Label, place: Span, scene: &Scene) -> Diagnostic {
    // Two orientations may stand on one line.
    let section = scene.connectors.get(&label).and_then(|element| scene.section(element));
    let orientation = section
        .filter(|_| breach.rule == Rule::ZRectangularNotInExplicit)
        .and_then(|section| z_rectangular(scene, section).find(|name| name.span == place))
        .map_or_else(String::new, |name| format!(" (orientation {})", name.value));
    let message = breach.message.each_ref().map(|message| format!("element {label}: {message}{orientation}"));
    let here = format!("by {}", breach.source);
    let build = if breach.refuses() { Diagnostic::error } else { Diagnostic::warning };
    let certainty = match breach.evidence {
        Evidence::S | Evidence::D => "",
        Evidence::P | Evidence::R => " (the rule rests on our reading, so this is a warning)",
    };
    build(code(breach.rule), place, message, here)
        .help(breach.remedy.each_ref().map(|remedy| format!("{remedy}{certainty}")))
        .in_scene(scene)
}
