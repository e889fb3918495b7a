//! What is found in an assembly: the findings that its facts make.

use crate::model::finding::{About, Finding};
use crate::model::levels::Levels;
use pintle_assembly::matrix::dense;
use pintle_assembly::modes::MODES;
use pintle_assembly::redundant::EXPLAINED;
use pintle_assembly::{
    Assembly, Constraint, Holds, Mode, NotAssembled, OPERATIONS, Position, Redundant, Role, Spent,
};
use pintle_kinematics::catalog::COMPONENT;
use pintle_model::evaluate::Freedom;
use pintle_scene::grammar::number as short;
use pintle_scene::grammar::{agree, count, ranges};
use pintle_scene::{Boundary, Code, ConnectorMotion, Label, Mpc, Scene, Severity, Span, Target, Words};
use std::collections::{BTreeMap, HashMap, HashSet};

/// The names that a message lists.
const NAMED: usize = 8;
/// What differs between given states is told in so many findings.
const SETS: usize = 20;

/// What is found of an assembly. Where there is much of a kind, that of each code and of each severity that `levels` set is shortened by itself.
pub(super) fn findings(scene: &Scene, assembly: &Assembly, levels: &Levels) -> Vec<Finding> {
    let mut found = not_read(scene);
    found.extend(redundancies(scene, assembly, levels));
    found.extend(at_states(scene, assembly, levels));
    found.extend(overdriven(scene, assembly));
    found.extend(skipped(scene, assembly));
    found.extend(without_derivative(scene, assembly));
    found.extend(undecided(scene, assembly));
    found.extend(off(scene, assembly));
    found.extend(not_assembled(scene, assembly));
    found.extend(mechanism(scene, assembly));
    found.extend(mechanism_at(scene, assembly));
    found
}

/// What is found of an assembly step by step: of later ones what was not found before.
pub(super) fn findings_in_steps(scene: &Scene, assemblies: &[Assembly], levels: &Levels) -> Vec<Finding> {
    let (mut told, mut all): (HashSet<(Code, String)>, Vec<Finding>) = (HashSet::new(), Vec::new());
    for (at, assembly) in assemblies.iter().enumerate() {
        let mut found = findings(scene, assembly, levels);
        found.retain(|finding| told.insert((finding.code(), finding.message().to_string())));
        let step = assembly.step;
        let in_step =
            |finding: Finding| if at == 0 { finding } else { finding.begin(&format!("in step {step}, ")) };
        all.extend(found.into_iter().map(in_step));
    }
    all
}

/// Where something was read: the connector, or the constraint.
fn place(scene: &Scene, constraint: &Constraint) -> Span {
    if let Some(span) = constraint.element.and_then(|element| place_of_motion(scene, element, constraint)) {
        return span;
    }
    if let Some(element) = constraint.element {
        return scene.connectors.get(&element).map(|element| element.span).unwrap_or_default();
    }
    if let Some((span, _)) = &constraint.joined {
        return *span;
    }
    if let Some(span) = constraint.node.and_then(|node| place_of_boundary(scene, node, constraint)) {
        return span;
    }
    constraint.index.and_then(|index| mpc_of(scene, index)).map(|mpc| mpc.span).unwrap_or_default()
}

/// The line of the motion that drives a component.
fn place_of_motion(scene: &Scene, element: Label, constraint: &Constraint) -> Option<Span> {
    let k = COMPONENT.iter().position(|name| *name == constraint.component)?;
    let of_steps = scene.steps.iter().flat_map(|step| &step.connector_motions);
    let mut motions = scene.connector_motions.iter().chain(of_steps);
    let is_it = |motion: &&ConnectorMotion| {
        let is_of = match &motion.target.value {
            Target::Label(label) => *label == element,
            Target::Set(name) => {
                scene.element_sets.get(name).is_some_and(|set| set.labels.contains(&element))
            }
        };
        is_of && usize::from(motion.component) == k + 1
    };
    (constraint.role == Role::Driven).then(|| motions.find(is_it)).flatten().map(|motion| motion.target.span)
}

/// The line of the boundary condition of a step that drives a degree of freedom of a node.
fn place_of_boundary(scene: &Scene, node: Label, constraint: &Constraint) -> Option<Span> {
    let number: u8 = constraint.component.parse().ok()?;
    let mut all = scene.steps.iter().flat_map(|step| &step.boundaries);
    let is_it = |boundary: &&Boundary| {
        let is_of = match &boundary.target.value {
            Target::Label(label) => *label == node,
            Target::Set(name) => scene.node_sets.get(name).is_some_and(|set| set.labels.contains(&node)),
        };
        is_of && boundary.degrees_of_freedom.contains(&number)
    };
    (constraint.role == Role::Driven).then(|| all.find(is_it)).flatten().map(|boundary| boundary.target.span)
}

/// The constraint at a place among those that are evaluated.
fn mpc_of(scene: &Scene, index: usize) -> Option<&Mpc> {
    scene.mpcs.iter().filter(|mpc| mpc.kind.evaluated().is_some()).nth(index)
}

/// The nodes that the connector or constraint of an equation joins, in ascending order.
fn nodes_of(scene: &Scene, constraint: &Constraint) -> Vec<Label> {
    let mut nodes: Vec<Label> = match (constraint.element, constraint.index) {
        _ if constraint.joined.is_some() => {
            constraint.joined.iter().flat_map(|(_, nodes)| nodes.iter().copied()).collect()
        }
        (Some(element), _) => {
            let element = scene.connectors.get(&element);
            element.into_iter().flat_map(|element| [element.a, element.b]).flatten().collect()
        }
        (_, Some(index)) => mpc_of(scene, index).map(|mpc| mpc.nodes.clone()).unwrap_or_default(),
        _ => Vec::new(),
    };
    nodes.sort();
    nodes
}

fn listed(names: &[String]) -> String {
    match names.len() {
        0..=NAMED => names.join(", "),
        more => format!("{} and {} more", names[..NAMED].join(", "), more - NAMED),
    }
}

fn about(constraints: &[&Constraint]) -> About {
    let mut about = About::default();
    for constraint in constraints {
        about.elements.extend(constraint.element);
        about.mpcs.extend(constraint.mpc.clone());
        about.nodes.extend(constraint.node);
        if about.components.len() < 100 {
            about.components.push(constraint.component.clone());
        }
    }
    about.elements.dedup();
    about.mpcs.dedup();
    about
}

/// Of what is found, in its order, so much of each code and severity as is shown; and, with the last of each, what there is more.
fn shortened<T>(
    scene: &Scene,
    levels: &Levels,
    most: usize,
    found: impl IntoIterator<Item = (Code, Span, T)>,
) -> Vec<(Code, Span, T, Vec<T>)> {
    let mut shown: Vec<(Code, Span, T, Vec<T>)> = Vec::new();
    let mut kinds: HashMap<(Code, Severity), (usize, usize)> = HashMap::new();
    for (code, place, what) in found {
        let finding = Finding::new(scene, code, place, "", "", "");
        let Some(severity) = levels.of_finding(&finding) else { continue };
        let (count, last) = kinds.entry((code, severity)).or_default();
        *count += 1;
        if *count <= most {
            *last = shown.len();
            shown.push((code, place, what, Vec::new()));
        } else if let Some((.., more)) = shown.get_mut(*last) {
            more.push(what);
        }
    }
    shown
}

/// Where a redundancy holds, in words, with what that rests on.
const fn meaning(holds: Holds) -> &'static str {
    match holds {
        Holds::Throughout => {
            "it holds throughout (judged: the same at other states that the assembly was moved to)"
        }
        Holds::Singular => {
            "it holds throughout (judged: the same at other states that the assembly was moved to), at a singular position wherever that is: \
             second order excludes motions that are free to first order because of it"
        }
        Holds::Rigid => "it holds throughout (what belongs to it cannot move)",
        Holds::Here => {
            "it holds at this state and not at every other (proven to rounding: at another admissible state it does not)"
        }
        Holds::Differs => {
            "it holds at this state and not at another one given, to the digits of these (they satisfy the constraints to no more)"
        }
        Holds::Isolated => {
            "it holds at this singular position (second order excludes the motions that are free to first order because of it)"
        }
        Holds::Large => {
            "whether it holds at other states was not judged: its connected component has more than 20 000 degrees of freedom, or fills when it is eliminated; \
             audit its loop as a scene of its own"
        }
        Holds::Spent => {
            "whether it holds at other states was not judged: the operations that may be spent on that, of those of the assembly the share of its connected component, were spent"
        }
        Holds::Unjudged => "whether it holds at other states was not judged",
    }
}

/// Where a redundancy holds, whether it is certain, and the connector or MPC that it is of.
type Owner = (Holds, bool, Option<Label>, Option<usize>);

/// The code of a redundancy.
const fn code(holds: Holds) -> Code {
    match holds {
        Holds::Throughout | Holds::Singular | Holds::Rigid => Code::AssemblyRedundant,
        Holds::Here | Holds::Differs | Holds::Isolated => Code::AssemblyRedundantHere,
        Holds::Large | Holds::Spent | Holds::Unjudged => Code::AssemblyRedundantUnjudged,
    }
}

/// Redundant constraints at the initial state: one finding for each connector or MPC and where it holds, of each code up to a number.
fn redundancies(scene: &Scene, assembly: &Assembly, levels: &Levels) -> Vec<Finding> {
    const MOST: usize = 50;
    let mut of: BTreeMap<Owner, Vec<&Redundant>> = BTreeMap::new();
    for redundant in &assembly.redundant {
        let Redundant { holds, decided, constraint, .. } = redundant;
        let key = (*holds, *decided, constraint.element, constraint.index);
        of.entry(key).or_default().push(redundant);
    }
    let mut found = Vec::new();
    let evaluated: Vec<&Mpc> = scene.mpcs.iter().filter(|mpc| mpc.kind.evaluated().is_some()).collect();
    let place = |element: &Option<Label>, index: Option<usize>, first: Option<&&Redundant>| match element {
        Some(element) => scene.connectors.get(element).map(|element| element.span),
        None => match first.and_then(|first| first.constraint.joined.as_ref()) {
            Some((span, _)) => Some(*span),
            None => index.and_then(|index| evaluated.get(index)).map(|mpc| mpc.span),
        },
    };
    let owners = of.into_iter().map(|owner| {
        let (holds, _, element, index) = &owner.0;
        (code(*holds), place(element, *index, owner.1.first()).unwrap_or_default(), owner)
    });
    for (code, place, owner, more) in shortened(scene, levels, MOST, owners) {
        let ((holds, decided, element, index), redundant) = owner;
        let Some(first) = redundant.first() else { continue };
        let components: Vec<String> = redundant.iter().map(|one| one.constraint.component.clone()).collect();
        let title = match (&element, &first.constraint.mpc) {
            (Some(element), _) => format!("element {element}"),
            (_, Some(mpc)) => mpc.clone(),
            _ => "a boundary condition".to_string(),
        };
        let mut makers: Vec<&Constraint> = redundant
            .iter()
            .flat_map(|one| &one.from)
            .filter(|one| one.element != element || one.index != index)
            .collect();
        makers.sort_by_key(|one| (one.element, one.index, one.node));
        makers.dedup_by_key(|one| (one.element, one.index, one.node));
        let others: Vec<String> = makers.iter().map(|one| name(scene, one, first)).collect();
        let from = match others.as_slice() {
            [] if redundant.iter().all(|one| one.held) => {
                " from boundary conditions and what is held".to_string()
            }
            [] if redundant.iter().all(|one| one.from.is_empty()) => format!(
                " from others, which are named in connected components of up to {} equations with up to {EXPLAINED} redundant ones",
                dense::LARGEST
            ),
            [] => " from the others".to_string(),
            others => format!(" from those of {}", listed(others)),
        };
        let verb = if components.len() == 1 { "follows" } else { "follow" };
        let condition = if decided {
            String::new()
        } else {
            format!(", {}", if_rank(assembly.positions.first().and_then(|position| position.rank)))
        };
        let others = match more.len() {
            0 => String::new(),
            more => format!(
                "; {more} more {} redundant components of this code, which the report lists",
                agree(more, ["connector or constraint has", "connectors and constraints have"])
            ),
        };
        let message = format!(
            "{title}: {} {verb}{from}, initially{condition}; {}{others}",
            components.join(", "),
            meaning(holds)
        );
        let mut reason = "the rank of the constraint Jacobian; which of the constraints that depend on each other is named is a choice".to_string();
        if let Some(Spent { operations, most }) = assembly.spent.filter(|_| holds == Holds::Spent) {
            reason += &format!(
                "; of {most} operations {operations} were spent",
                most = short(most as f64, 2),
                operations = short(operations as f64, 2)
            );
        }
        let remedy = match holds {
            Holds::Here | Holds::Differs => {
                "start from another position, or drive through this one with care: forces grow without bound near it"
                    .into()
            }
            Holds::Isolated => {
                "move a node, or change a length, so that the position is not singular: the constraints resist loads along the motions that are free to \
                 first order only as it deforms, and forces grow without bound as it comes nearer"
                    .into()
            }
            _ => remedy(scene, &first.constraint, &makers, &redundant),
        };
        let of_more = more.iter().flat_map(|(_, redundant)| redundant);
        let constraints: Vec<&Constraint> =
            redundant.iter().chain(of_more).map(|one| &one.constraint).collect();
        let finding = Finding::new(scene, code, place, message, reason, remedy);
        found.push(finding.about(about(&constraints)));
    }
    found.extend(unnamed(scene, assembly));
    found
}

/// Redundant constraints of which no name is known.
fn unnamed(scene: &Scene, assembly: &Assembly) -> Option<Finding> {
    let more = Some(assembly.unnamed).filter(|more| *more > 0)?;
    let besides = if assembly.redundant.is_empty() { "" } else { " besides" };
    let message = format!(
        "{} {} redundant{besides}, counted and not named: with the operations that may be spent on names, rows were not found without which the rank \
         is the same",
        count(more, "constraint"),
        agree(more, ["is", "are"]),
    );
    let reason = "the rank of the constraint Jacobian";
    let remedy = "audit smaller pieces of the connected component as scenes of their own to have them named";
    Some(Finding::new(scene, Code::AssemblyRedundantUnjudged, Span::default(), message, reason, remedy))
}

/// Constraints, where they hold, and the states.
type AtStates<'a> = (Vec<&'a Constraint>, Holds, Vec<u64>);

/// A constraint that another follows from, by number; with the line where the two have the same title.
fn name(scene: &Scene, one: &Constraint, follows: &Redundant) -> String {
    match (&one.element, &one.mpc, &one.node) {
        (Some(element), ..) => element.to_string(),
        (_, Some(mpc), _) if follows.constraint.mpc.as_ref() == Some(mpc) => {
            format!("{mpc} of line {}", place(scene, one).line())
        }
        (_, Some(mpc), _) => mpc.clone(),
        (_, _, Some(node)) => format!("node {node}"),
        _ => String::new(),
    }
}

/// What to do about a redundancy that does not depend on the position, by what it follows from.
fn remedy(scene: &Scene, of: &Constraint, makers: &[&Constraint], redundant: &[&Redundant]) -> Words {
    let is_mpc = of.index.is_some();
    let is_held = redundant.iter().all(|one| one.held);
    let remedy = match makers {
        [] if is_held && is_mpc => {
            "its nodes are held as it would hold them: leave out the constraint, or free one of the nodes"
        }
        [] if is_held => {
            return ["*BOUNDARY", "boundaries"]
                .map(|held| {
                    format!(
                        "its nodes are held as it would hold them: free one of the nodes in {held}, or choose a connection type that leaves the \
                         component available"
                    )
                })
                .into();
        }
        [one] if nodes_of(scene, one) == nodes_of(scene, of) && is_mpc => {
            "it and the other one join the same nodes: remove one of the two"
        }
        [one] if nodes_of(scene, one) == nodes_of(scene, of) => {
            "it and the other one join the same nodes: remove one of the two, or choose for one a connection type that leaves the component available"
        }
        _ if is_mpc => {
            "replace it by one that constrains less (a PIN or LINK for a BEAM, say), or by a connector that leaves the component available; or accept \
             that its force is not determined"
        }
        _ => {
            "free the component: choose a connection type that leaves it available (of a planar loop of hinges, make one a SLOT along its axis with CARDAN, say), or \
             accept that its force is not determined"
        }
    };
    remedy.into()
}

/// Constraints that are redundant at a given state and not at others: a finding for each set of them, with its states.
fn at_states(scene: &Scene, assembly: &Assembly, levels: &Levels) -> Vec<Finding> {
    let mut by_state: BTreeMap<(u64, Holds), Vec<&Constraint>> = BTreeMap::new();
    for (state, constraint, holds) in &assembly.redundant_at {
        by_state.entry((*state, *holds)).or_default().push(constraint);
    }
    let mut sets: Vec<AtStates<'_>> = Vec::new();
    for ((state, holds), set) in by_state {
        match sets.iter_mut().find(|(other, of, _)| *other == set && *of == holds) {
            Some((.., states)) => states.push(state),
            None => sets.push((set, holds, vec![state])),
        }
    }
    let sets = sets.into_iter().map(|set| {
        let place = set.0.first().map(|first| place(scene, first)).unwrap_or_default();
        (Code::AssemblyRedundantHere, place, set)
    });
    let of = |(code, place, set, more): (Code, Span, AtStates<'_>, Vec<AtStates<'_>>)| {
        let mut found = redundant_at(scene, assembly, (code, place), &set);
        let all: Vec<&Constraint> =
            [&set].into_iter().chain(&more).flat_map(|(at, ..)| at).copied().collect();
        found.about = About { state: found.about.state, ..about(&all) };
        match more.len() {
            0 => found,
            more => found.add(&format!("; {} besides, which the report lists", count(more, "such set"))),
        }
    };
    shortened(scene, levels, SETS, sets).into_iter().map(of).collect()
}

fn redundant_at(
    scene: &Scene,
    assembly: &Assembly,
    (code, place): (Code, Span),
    (at, holds, states): &AtStates<'_>,
) -> Finding {
    let names: Vec<String> = at.iter().map(ToString::to_string).collect();
    /// What a change of the matrix by more than this makes zero is not zero to rounding, but to the digits of the state.
    const ROUNDING: f64 = 1e-12;
    let is_here = |position: &&Position| position.state.is_some_and(|state| states.contains(&state));
    let zero =
        assembly.positions.iter().filter(is_here).map(|position| position.gap.zero).fold(0.0, f64::max);
    let holds = if zero > ROUNDING {
        format!(
            "to the digits of the state, which a relative change of the matrix by {zero} allows for, it holds there only: at another \
             state given it does not",
            zero = short(zero, 2)
        )
    } else {
        meaning(*holds).to_string()
    };
    let message = format!(
        "at {}, {} {} on other constraints; {holds}",
        ranges("state", states),
        listed(&names),
        agree(names.len(), ["depends", "depend"]),
    );
    let reason = "the rank of the constraint Jacobian is smaller than initially, or at another state given";
    let remedy =
        "keep clear of this position, or drive through it with care: forces grow without bound near it";
    let finding = Finding::new(scene, code, place, message, reason, remedy);
    finding.about(About { state: states.first().copied(), ..about(at) })
}

fn overdriven(scene: &Scene, assembly: &Assembly) -> Option<Finding> {
    let first = assembly.overdriven.first()?;
    let names: Vec<String> = assembly.overdriven.iter().map(ToString::to_string).collect();
    let with_line = |constraint: &Constraint| match place(scene, constraint) {
        span if span.is_known() => format!("{constraint} (line {})", span.line()),
        _ => constraint.to_string(),
    };
    let besides: Vec<String> = assembly.driven_besides.iter().map(with_line).collect();
    let besides = match besides.as_slice() {
        [] => String::new(),
        all => format!("; prescribed besides: {}", listed(all)),
    };
    let message = format!(
        "a motion is prescribed for what is determined already, initially: {}{besides}",
        listed(&names)
    );
    let reason = "with the drives, the rank grows by less than their number";
    let remedy = "remove the motion, or free what determines it; at a dead centre, drive another component";
    let finding = Finding::new(scene, Code::AssemblyOverdriven, place(scene, first), message, reason, remedy);
    Some(finding.about(about(&assembly.overdriven.iter().collect::<Vec<_>>())))
}

/// Connected components that were not looked at.
fn skipped(scene: &Scene, assembly: &Assembly) -> Option<Finding> {
    let largest = assembly.skipped.iter().max_by_key(|component| component.degrees_of_freedom)?;
    let others = assembly.connected_components.saturating_sub(assembly.skipped.len());
    let more = match assembly.skipped.len() - 1 {
        0 => String::new(),
        more => format!(" (and of {})", count(more, "connected component like it")),
    };
    let rest = match others {
        0 => String::new(),
        others => format!(
            "; what is said besides is of the {} that {} looked at",
            count(others, "other connected component"),
            agree(others, ["was", "were"])
        ),
    };
    let message = format!(
        "the rank of the constraints is undecided for the connected component of node {}, with {} and {}{more}: its elimination would take more than {:.0e} operations, or 1.3 GB{rest}",
        largest.node,
        count(largest.connectors, "connector"),
        count(largest.degrees_of_freedom, "degree of freedom"),
        OPERATIONS as f64
    );
    let reason = "the nodes are joined so densely that the constraint Jacobian fills when it is eliminated";
    let remedy = "audit smaller pieces of the connected component as scenes of their own";
    let finding = Finding::new(scene, Code::AssemblyUndecided, Span::default(), message, reason, remedy);
    Some(finding.about(About {
        nodes: assembly.skipped.iter().map(|component| component.node).take(100).collect(),
        ..About::default()
    }))
}

fn undecided(scene: &Scene, assembly: &Assembly) -> Option<Finding> {
    // Connected components that were not looked at are told by themselves.
    let is_open = |position: &&Position| {
        !position.decided
            && position.without_derivative.is_empty()
            && (position.rank.is_some() || !position.doubtful.is_empty() || !position.finite)
    };
    let position = assembly.positions.iter().find(is_open)?;
    // Where all is certain elsewhere, and the rank no smaller, it is the position that is near one of smaller rank.
    let elsewhere = assembly.positions.iter().find(|other| other.decided && other.rank >= position.rank);
    if let Some(elsewhere) = elsewhere.filter(|_| position.finite) {
        let more = assembly.positions.iter().filter(is_open).count() - 1;
        return Some(near_singular(scene, position, elsewhere, more));
    }
    let when = when(position.state);
    let doubtful: Vec<String> = position.doubtful.iter().map(ToString::to_string).collect();
    let named = if doubtful.is_empty() { String::new() } else { format!(", in {}", listed(&doubtful)) };
    let gap = match position.gap.singular_values {
        Some([nonzero, zero]) => {
            format!(
                "the singular values next to each other are {nonzero} and {zero} of the largest",
                nonzero = short(nonzero, 2),
                zero = short(zero, 2)
            )
        }
        None => format!(
            "relative changes of {} and {} tell them apart",
            short(position.gap.nonzero, 2),
            short(position.gap.zero, 2)
        ),
    };
    let message =
        format!("the rank of the constraints is not certain {when}{named}: {gap}{}", consequence(position));
    let reason = "more than rounding explains, and less than the digits of a deck warrant";
    let remedy =
        "give coordinates and directions with all their digits, or move the position off the singular one";
    let first = position.doubtful.first();
    let place = first.map(|one| place(scene, one)).unwrap_or_default();
    let about = About { state: position.state, ..about(&position.doubtful.iter().collect::<Vec<_>>()) };
    Some(Finding::new(scene, Code::AssemblyUndecided, place, message, reason, remedy).about(about))
}

/// Constraints that do not show in the Jacobian, for they have no derivative: at the first such state.
fn without_derivative(scene: &Scene, assembly: &Assembly) -> Option<Finding> {
    let is_one = |position: &&Position| !position.without_derivative.is_empty();
    let mut all = assembly.positions.iter().filter(is_one);
    let position = all.next()?;
    let names: Vec<String> = position.without_derivative.iter().map(ToString::to_string).collect();
    let also = match all.count() {
        0 => String::new(),
        more => format!(" (and the like at {})", count(more, "more state")),
    };
    let message = format!(
        "the rank of the constraints is not certain {}: {} {} at a singular point, where derivatives do not exist or lose their digits: what is constrained \
         there does not show in the Jacobian{also}",
        when(position.state),
        listed(&names),
        agree(names.len(), ["is", "are"]),
    );
    let reason = "a constraint whose row is reported as zero, or along one direction, still holds: it is neither redundant nor does it leave a motion";
    let remedy = "correct the orientations or the position, so that the component is off its singular point";
    let place = position.without_derivative.first().map(|one| place(scene, one)).unwrap_or_default();
    let about =
        About { state: position.state, ..about(&position.without_derivative.iter().collect::<Vec<_>>()) };
    Some(Finding::new(scene, Code::AssemblyUndecided, place, message, reason, remedy).about(about))
}

/// States given that were not looked at, told once.
fn off(scene: &Scene, assembly: &Assembly) -> Option<Finding> {
    let first = *assembly.off.iter().chain(&assembly.off_boundary).min()?;
    let of = |states: &[u64], verbs: [&str; 2], what: &str| {
        (!states.is_empty())
            .then(|| format!("{} {} {what}", ranges("state", states), agree(states.len(), verbs)))
    };
    let constraints = of(&assembly.off, ["does", "do"], "not satisfy the constraints");
    let boundary = of(&assembly.off_boundary, ["moves", "move"], "what boundary conditions hold");
    let which: Vec<String> = constraints.into_iter().chain(boundary).collect();
    let is_all = assembly.positions.iter().all(|position| position.state.is_none());
    let count = assembly.off.len() + assembly.off_boundary.len();
    let begin = match (is_all, count) {
        (true, 1) => {
            "the state given is none that the assembly can come to, and its rank is known initially only"
        }
        (true, _) => {
            "no state given is one that the assembly can come to, and its rank is known initially only"
        }
        (false, 1) => {
            "a state given is none that the assembly can come to, and its rank there is not looked at"
        }
        (false, _) => {
            "some states given are none that the assembly can come to, and its rank there is not looked at"
        }
    };
    let message = format!(
        "{begin}: {} (by more than 1e-4 rad, or 1e-4 of the length of a connector)",
        which.join(", ")
    );
    let reason = "each connector is audited at every state, whatever the others do; the rank of the whole is that of states which it can come to";
    let remedy = "nothing is to be done where states are only to exercise the connectors one by one; else give states with more digits, or correct them, \
                  or the boundary conditions of their step";
    let finding = Finding::new(scene, Code::AssemblyUndecided, Span::default(), message, reason, remedy);
    Some(finding.about(About { state: Some(first), ..About::default() }))
}

/// Under the condition that what was taken for zero is zero.
fn if_rank(rank: Option<usize>) -> String {
    match rank {
        Some(rank) => format!("if the rank of the constraints is {rank}, which is not certain"),
        None => "if what was taken for zero is zero, which is not certain".to_string(),
    }
}

/// What an uncertain rank would mean.
fn consequence(position: &Position) -> String {
    let ways = position.undriven_undecided;
    match (position.rank, position.redundant) {
        (Some(rank), Some(redundant)) => format!(
            "; if it is {rank}, {} redundant, and what it is of can move in {} that nothing drives",
            [count(redundant, "constraint"), agree(redundant, ["is", "are"]).to_string()].join(" "),
            count(ways, "way")
        ),
        _ => String::new(),
    }
}

fn when(state: Option<u64>) -> String {
    state.map_or_else(|| "initially".to_string(), |state| format!("at state {state}"))
}

/// A number, where it is known.
fn number(known: Option<usize>) -> String {
    known.map_or_else(|| "not known".to_string(), |number| number.to_string())
}

/// A position of which its digits do not tell whether it is singular, where another one is not.
fn near_singular(scene: &Scene, position: &Position, elsewhere: &Position, more: usize) -> Finding {
    let doubtful: Vec<String> = position.doubtful.iter().map(ToString::to_string).collect();
    let named = if doubtful.is_empty() { "the constraints".to_string() } else { listed(&doubtful) };
    let depend = agree(doubtful.len(), ["depends", "depend"]);
    let distance = match position.gap.singular_values {
        Some([nonzero, _]) if nonzero < position.gap.nonzero => nonzero,
        _ => position.gap.nonzero,
    };
    let also = match more {
        0 => String::new(),
        more => format!(" (and the like at {})", count(more, "more state")),
    };
    let message = format!(
        "{} the assembly is within {distance} (relative, of the constraint Jacobian) of a singular position, a change point say: {named} nearly \
         {depend} on other constraints, so that the rank is {}, or less; {} it is certain, {}{also}",
        when(position.state),
        number(position.rank),
        when(elsewhere.state),
        number(elsewhere.rank),
        distance = short(distance, 2)
    );
    let reason = "more than rounding explains, and less than the digits of a state warrant";
    let remedy = "keep clear of this position, or drive through it with care: forces grow without bound near it, and the assembly can go on \
         in more ways than one";
    let place = position.doubtful.first().map(|one| place(scene, one)).unwrap_or_default();
    let about = About {
        state: position.state,
        value: Some(distance),
        ..about(&position.doubtful.iter().collect::<Vec<_>>())
    };
    Finding::new(scene, Code::AssemblyNearSingular, place, message, reason, remedy).about(about)
}

fn not_assembled(scene: &Scene, assembly: &Assembly) -> Option<Finding> {
    let NotAssembled { state, why } = assembly.not_assembled.as_ref()?;
    let message = format!("{} and after, the assembly was not judged: {why}", when(*state));
    let (reason, remedy) =
        ("the Jacobian of the constraints could not be assembled", "please report it, with the scene");
    let finding = Finding::new(scene, Code::AssemblyNotAssembled, Span::default(), message, reason, remedy);
    Some(finding.about(About { state: *state, ..About::default() }))
}

/// A motion, by the degree of freedom that stands for it, and the other nodes that move.
fn motion(mode: &Mode) -> String {
    let Freedom { node, number } = mode.leading;
    let others: Vec<String> =
        mode.nodes.iter().filter(|other| **other != node).map(ToString::to_string).collect();
    let Some(moving) = mode.moving else { return format!("{number} of node {node} and what follows it") };
    let more = match moving.saturating_sub(1 + others.len().min(NAMED)) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let named = &others[..others.len().min(NAMED)];
    match others.len() {
        0 => format!("{number} of node {node}"),
        1 => format!("{number} of node {node}, with node {}", others[0]),
        _ => format!("{number} of node {node}, with nodes {}{more}", named.join(", ")),
    }
}

fn mechanism(scene: &Scene, assembly: &Assembly) -> Option<Finding> {
    let initial = assembly.positions.first()?;
    let modes: Vec<&Mode> = assembly.modes.iter().filter(|mode| mode.decided).collect();
    // Where a connected component was not looked at, those of the others.
    let undriven = initial.undriven.map_or(modes.len(), |all| all - initial.undriven_undecided);
    if undriven == 0 {
        return None;
    }
    let is_isolated = |one: &Redundant| one.holds == Holds::Isolated;
    let excludes = assembly.redundant.iter().any(is_isolated);
    // What is left of the degrees of freedom are motions to first order.
    let order = if excludes || assembly.redundant.iter().any(|one| one.holds == Holds::Singular) {
        "; to first order: at its singular position second order excludes some of them, or all"
    } else {
        ""
    };
    let message =
        format!("the assembly can move in {} initially{}{order}", ways(undriven), named(&modes, undriven));
    Some(moves(scene, (message, &modes), undriven, None, excludes))
}

/// A number of motions.
fn ways(undriven: usize) -> String {
    format!("{} that nothing drives,", count(undriven, "way"))
}

/// Motions, by degrees of freedom.
fn named(modes: &[&Mode], undriven: usize) -> String {
    if modes.is_empty() {
        return ", which are not named, for a thousand others are".to_string();
    }
    let words: Vec<String> = modes.iter().take(NAMED).map(|mode| motion(mode)).collect();
    let more = if undriven > NAMED { format!("; and {} more", undriven - NAMED) } else { String::new() };
    let short = if modes.iter().take(NAMED).any(|mode| mode.moving.is_none()) {
        format!(" (all that moves is named for the first {MODES} motions of a connected component)")
    } else {
        String::new()
    };
    format!(", by degree of freedom {}{more}{short}", words.join("; "))
}

/// Motions at given states where there are more, or fewer, than initially: a finding for each set of them, with its states.
fn mechanism_at(scene: &Scene, assembly: &Assembly) -> Vec<Finding> {
    let Some(initial) = assembly.positions.first().and_then(|position| position.undriven) else {
        return Vec::new();
    };
    let mut sets: Vec<(&Position, usize, Vec<u64>)> = Vec::new();
    for position in assembly.positions.iter().filter(|position| position.differs && position.decided) {
        let (Some(state), Some(undriven)) = (position.state, position.undriven) else { continue };
        if undriven == initial || undriven == 0 {
            continue;
        }
        match sets.iter_mut().find(|(other, ..)| other.modes == position.modes) {
            Some((.., states)) => states.push(state),
            None => sets.push((position, undriven, vec![state])),
        }
    }
    let more = sets.len().saturating_sub(SETS);
    let of = |(position, undriven, states): &(&Position, usize, Vec<u64>)| {
        let modes: Vec<&Mode> = position.modes.iter().collect();
        let message = format!(
            "at {}, the assembly can move in {} not {initial} as initially{}",
            ranges("state", states),
            ways(*undriven),
            named(&modes, *undriven)
        );
        moves(scene, (message, &modes), *undriven, states.first().copied(), false)
    };
    let mut found: Vec<Finding> = sets.iter().take(SETS).map(of).collect();
    if more > 0
        && let Some(last) = found.pop()
    {
        found.push(last.add(&format!("; {} besides, which the report lists", count(more, "such set"))));
    }
    found
}

/// The finding of motions at a state; `excludes` says whether second order excludes some of them.
fn moves(
    scene: &Scene,
    (message, modes): (String, &[&Mode]),
    undriven: usize,
    state: Option<u64>,
    excludes: bool,
) -> Finding {
    // Whether a node that moves is one of an element that is not read.
    let may_hold = scene.skipped.nodes.as_ref().is_none_or(|known| {
        let is_told = |mode: &&&Mode| mode.moving.is_some_and(|count| count <= mode.nodes.len());
        !modes.iter().all(|mode| is_told(&mode))
            || modes.iter().flat_map(|mode| &mode.nodes).any(|node| known.contains(node))
    });
    let types = scene.skipped.element_types.keys().map(String::as_str);
    let others: Vec<&str> = types.filter(|_| may_hold).take(NAMED).collect();
    let reason = if !scene.unread_constraints().is_empty() {
        "degrees of freedom less the rank of the constraints and drives that are read; other constraints, springs, friction, stops and other \
         elements are not looked at"
    } else {
        "degrees of freedom less the rank of constraints and drives; springs, friction, stops and other elements are not looked at"
    };
    let remedy = if excludes {
        "move a node, or change a length, so that the position is not singular: what second order excludes is then no motion; what is left is as it should be for a \
         mechanism under forces, and in statics hold or drive it"
    } else if others.is_empty() {
        "as it should be for a mechanism under forces; in statics, hold or drive the motion"
    } else {
        "nothing is to be done where these elements hold what moves; what they do not hold is as it should be for a mechanism under forces"
    };
    let message = match others.as_slice() {
        [] => message,
        _ => format!("{message}; elements that are not read ({}) may hold it", others.join(", ")),
    };
    let mut nodes: Vec<Label> = modes.iter().flat_map(|mode| mode.nodes.iter().copied()).collect();
    nodes.sort();
    nodes.dedup();
    nodes.truncate(100);
    let about = About { nodes, value: Some(undriven as f64), state, ..About::default() };
    Finding::new(scene, Code::AssemblyMechanism, Span::default(), message, reason, remedy).about(about)
}

/// Constraints that were not read: a finding for each kind, at the first of them.
fn not_read(scene: &Scene) -> Vec<Finding> {
    let finding = |(what, spans): (String, Vec<Span>)| {
        let first = spans.first().copied().unwrap_or_default();
        let here: Vec<u64> = spans
            .iter()
            .filter(|span| span.file() == first.file() && span.is_known())
            .map(|span| u64::from(span.line()))
            .collect();
        let elsewhere = match spans.len() - here.len() {
            0 => String::new(),
            more => format!(" and {more} in other files"),
        };
        let lines = if here.is_empty() {
            count(spans.len(), "time")
        } else {
            format!("{}{elsewhere}", ranges("line", &here))
        };
        let message = format!(
            "{what} ({lines}) constrains nodes and is not read: the rank is that of what was read, and with all constraints the nodes of connectors \
             may move in fewer ways than is said, and more constraints may be redundant"
        );
        let reason = "the rank is that of connectors, multi-point constraints that are evaluated, boundary conditions and connector motions";
        let remedy = "where it joins nodes of connectors, write it as connectors or multi-point constraints (BEAM for a rigid body, say) to have it \
                      judged with the others; where it does not, allow this code";
        let about = About { value: Some(spans.len() as f64), ..About::default() };
        Finding::new(scene, Code::AssemblyConstraintsUnread, first, message, reason, remedy).about(about)
    };
    scene.unread_constraints().into_iter().map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pintle_model::evaluate::Model;
    use pintle_scene::{NodeMotion, State};

    /// States that the assembly cannot come to, for whatever reason, are told once.
    #[test]
    fn states_off_are_told_once() {
        let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n1, 1, 2\n*CONNECTOR SECTION, ELSET=C\nBEAM\n*BOUNDARY\n1, 1, 6\n";
        let scene = Scene::parse("scene.inp", text).unwrap();
        let model = Model::compile(&scene).unwrap();
        let moved = |nodes: &[(&str, f64)], number: u64| {
            let motion = |y: f64| NodeMotion { displacement: [0.0, y, 0.0], ..NodeMotion::default() };
            State {
                number: Some(number),
                nodes: nodes.iter().map(|(node, y)| (node.parse().unwrap(), motion(*y))).collect(),
                ..State::default()
            }
        };
        let both = |y: f64, number: u64| moved(&[("1", y), ("2", y)], number);
        let told = |states: &[State]| -> Vec<String> {
            let assembly = pintle_assembly::analyse(&scene, &model, states, 1).unwrap();
            let found = findings(&scene, &assembly, &Levels::default());
            found.iter().map(|finding| finding.message().to_string()).collect()
        };
        let off = [both(1.0, 1), moved(&[("2", 0.5)], 2), both(2.0, 3), both(3.0, 4)];
        let all = told(&off);
        assert_eq!(all.len(), 1, "{all:?}");
        assert!(all[0].starts_with("no state given is one that the assembly can come to"), "{all:?}");
        assert!(
            all[0].contains("state 2 does not satisfy the constraints, states 1, 3, 4 move what"),
            "{all:?}"
        );
        let some = told(&[both(0.0, 0), both(1.0, 1)]);
        assert!(some.len() == 1 && some[0].contains("its rank there is not looked at: state 1 moves what"));
        assert!(told(&[both(0.0, 0)]).is_empty());
    }
}
