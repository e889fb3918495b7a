//! The references of constraints, once all of a deck is known; what a surface of faces gives them.

use super::{RawBody, RawCoupling, RawDistribution, RawSurface, RawTerm, SurfaceKind};
use crate::deck::errors::Errors;
use crate::deck::faces::{self, Element};
use crate::deck::lookup::{check_orientation, element_set, node_set, node_target};
use crate::deck::mesh::is_mechanical;
use crate::deck::{Deck, unread};
use crate::diagnostic::{Code, Diagnostic, Result, suggest_scoped};
use crate::grammar;
use crate::label::Label;
use crate::label::labelled::{LabelMap, LabelSet};
use crate::model::Weighting;
use crate::model::{
    Coupling, CouplingKind, Equation, EquationTerm, RigidBody, Scene, SkippedConstraint, Surface, Target, Tie,
};
use crate::span::{Span, Spanned};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::{dot, sub};
use std::collections::HashSet;

/// Nodes meet that are no farther apart than this share of the largest coordinate: six digits.
const MEETS: f64 = 2e-6;

/// The nodes of the constraints of a scene.
pub(in crate::deck) fn nodes(scene: &Scene) -> Vec<Label> {
    let mut found: Vec<Label> =
        scene.equations.iter().flat_map(|equation| &equation.terms).map(|term| term.node).collect();
    for body in &scene.rigid_bodies {
        found.extend(scene.body_nodes(body).into_iter().map(|(node, _)| node));
    }
    for coupling in &scene.couplings {
        found.extend(scene.coupling_nodes(coupling).into_iter().map(|(node, _)| node));
    }
    found.extend(scene.ties.iter().flat_map(|tie| scene.tied_nodes(tie)).flatten());
    found
}

/// The one node that is named.
fn one_node(scene: &Scene, target: &Spanned<Target>) -> Result<Label> {
    match node_target(scene, target)?.as_slice() {
        [node] => Ok(*node),
        nodes => {
            let message = format!("a reference node is one node, and the set has {}", nodes.len());
            Err(Diagnostic::error(Code::BadConnectivity, target.span, message, "not one node")
                .help("name a node, or a set of one node"))
        }
    }
}

/// An equation for each place of its sets; none of one in degrees of freedom of other physics.
fn equations(scene: &Scene, terms: &[RawTerm], span: Span) -> Result<Option<Vec<Equation>>> {
    let number = |term: &RawTerm| Some(term.degree_of_freedom).filter(|number| is_mechanical(*number));
    let Some(numbers) = terms.iter().map(number).collect::<Option<Vec<u8>>>() else {
        // Of CalculiX, the temperatures of a network.
        let all_zero = terms.iter().all(|term| term.degree_of_freedom == 0);
        let bad = terms.iter().find(|term| term.degree_of_freedom == 0 && !all_zero);
        let Some(bad) = bad else { return Ok(None) };
        let message = "a term is about degree of freedom 0";
        return Err(Diagnostic::error(Code::BadDegreeOfFreedom, bad.node.span, message, "this term")
            .help("degrees of freedom are 1 to 6, and 10"));
    };
    let nodes = terms.iter().map(|term| node_target(scene, &term.node)).collect::<Result<Vec<_>>>()?;
    let count = nodes.first().map_or(0, Vec::len);
    if count == 0 || nodes.iter().any(|members| members.len() != count && members.len() != 1) {
        let lengths: Vec<_> = nodes.iter().map(|members| members.len().to_string()).collect();
        let message = format!("the terms of an equation have {} nodes", lengths.join(", "));
        return Err(Diagnostic::error(Code::BadConnectivity, span, message, "this equation")
            .help("give sets of the size of the first one, or single nodes"));
    }
    let equation = |index: usize| {
        let terms = terms.iter().zip(&numbers).zip(&nodes).filter_map(|((term, number), members)| {
            let node = *members.get(index).or(members.first())?;
            Some(EquationTerm { node, degree_of_freedom: *number, factor: term.factor })
        });
        Equation { terms: terms.collect(), span }
    };
    Ok(Some((0..count).map(equation).collect()))
}

/// The references of the constraints; those that cannot be read are left out, and named.
pub(in crate::deck) fn resolve(deck: &mut Deck<'_>, errors: &mut Errors) {
    let raw = std::mem::take(&mut deck.constraints);
    let mut network =
        if raw.equations.is_empty() { LabelSet::default() } else { deck.other_elements.network() };
    let ends: LabelSet = unread::ends(&deck.scene).collect();
    network.retain(|node| !ends.contains(node));
    let is_of_network =
        |term: &RawTerm| matches!(&term.node.value, Target::Label(label) if network.contains(label));
    for (terms, span) in &raw.equations {
        if terms.iter().all(is_of_network) {
            deck.scene.skipped.count("*EQUATION of a network of fluids".to_owned(), span.line());
            continue;
        }
        if !terms.iter().all(|term| is_whole(&deck.scene, &term.node)) {
            deck.leave_out("EQUATION", *span, 0);
            continue;
        }
        let Some(found) = errors.value(equations(&deck.scene, terms, *span)) else { continue };
        match found {
            Some(found) => deck.scene.equations.extend(found),
            None => {
                let what = "*EQUATION in degrees of freedom of other physics".to_owned();
                deck.scene.skipped.count(what, span.line());
                // With one that nodes move in, it holds something that is not known.
                let mixed = terms.iter().find(|term| is_mechanical(term.degree_of_freedom));
                if let Some(other) =
                    mixed.and_then(|_| terms.iter().find(|term| !is_mechanical(term.degree_of_freedom)))
                {
                    let number = other.degree_of_freedom;
                    let message = format!(
                        "an equation of displacements has degree of freedom {number}, and is not read"
                    );
                    let warning = Diagnostic::warning(
                        Code::NotFollowed,
                        other.node.span,
                        message,
                        "this term is of other physics",
                    );
                    deck.warn(
                        warning.help("it holds no node here; degrees of freedom of nodes are 1 to 6, and 10"),
                    );
                    let skipped = SkippedConstraint { keyword: "EQUATION", span: *span };
                    deck.scene.skipped.constraints.push(skipped);
                }
            }
        }
    }
    let has = |name: &Spanned<String>| match raw.surfaces.get(&name.value) {
        Some(surface) => Ok(surface.kind),
        None => {
            let message = format!("there is no surface {}", name.value);
            let names = raw.surfaces.keys().map(String::as_str);
            let remedy = suggest_scoped(&name.value, names, || {
                format!("define it by *SURFACE, TYPE=NODE, NAME={}", name.value)
            });
            Err(Diagnostic::error(Code::UnknownSurface, name.span, message, "not defined").help(remedy))
        }
    };
    let means = raw.couplings.iter().filter(|one| matches!(one.kind, Some(CouplingKind::Distributing(_))));
    let weighing: HashSet<&str> = means.map(|one| one.surface.value.as_str()).collect();
    for (name, surface) in &raw.surfaces {
        let weighs = weighing.contains(name.as_str());
        let of_faces =
            if surface.kind == SurfaceKind::Faces { face_nodes(deck, surface, weighs) } else { None };
        if let Some(members) = of_faces {
            deck.scene.surfaces.insert(name.clone(), Surface { members, span: surface.surface.span });
        }
        if surface.kind != SurfaceKind::Nodes {
            continue;
        }
        let members = &surface.surface.members;
        // A set that lacks nodes of skipped elements makes what uses it one of those that are not read.
        let is_whole = members.iter().all(|(member, _)| is_whole(&deck.scene, member));
        if is_whole {
            for (member, _) in members {
                errors.value(node_target(&deck.scene, member));
            }
            deck.scene.surfaces.insert(name.clone(), surface.surface.clone());
        }
    }
    let mut used = HashSet::new();
    // Of use in equations: not a surface of the scene for that.
    let mut used_faces = HashSet::new();
    for coupling in raw.couplings {
        let surface = coupling.surface.value.clone();
        if errors.value(resolved_coupling(deck, coupling, &has)) == Some(true) {
            used.insert(surface);
        }
    }
    for distribution in raw.distributions {
        let couplings = errors.value(couplings_of(deck, &distribution));
        for coupling in couplings.into_iter().flatten() {
            errors.value(resolved_coupling(deck, coupling, &has));
        }
    }
    for (tie, is_nodal) in raw.ties {
        let kinds = [&tie.slave, &tie.master].map(|name| errors.value(has(name)));
        let are_known =
            [&tie.slave, &tie.master].iter().all(|name| deck.scene.surfaces.contains_key(&name.value));
        // Between the nodes of a face that is tied to, only shape functions tell where a node goes.
        let meets = kinds[1] != Some(SurfaceKind::Faces) || are_known && all_meet(&deck.scene, &tie);
        if kinds.iter().all(Option::is_some) && are_known && meets {
            used.extend([tie.slave.value.clone(), tie.master.value.clone()]);
            let apart = untied(&deck.scene, &tie);
            deck.scene.ties.push(tie);
            apart.into_iter().for_each(|warning| deck.warn(warning));
            continue;
        }
        // A mean over the surface around a node is another thing than the point of it.
        let is_nodal = is_nodal || kinds[0] == Some(SurfaceKind::Nodes);
        let master = raw.surfaces.get(&tie.master.value).filter(|_| are_known && is_nodal);
        match master.and_then(|master| within_faces(deck, &tie, master)) {
            Some(equations) => {
                deck.scene.equations.extend(equations);
                used_faces.insert(tie.master.value.clone());
                used_faces.insert(tie.slave.value);
            }
            None => deck.leave_out("TIE", tie.span, 1),
        }
    }
    // Faces that were of use are no longer among what is skipped.
    deck.scene.surfaces.retain(|name, _| {
        used.contains(name) || raw.surfaces.get(name).is_none_or(|raw| raw.kind == SurfaceKind::Nodes)
    });
    let of_faces = |name: &&String| raw.surfaces.get(*name).is_some_and(|raw| raw.kind == SurfaceKind::Faces);
    let count = used.union(&used_faces).filter(of_faces).count() as u64;
    if let Some(skipped) = deck.scene.skipped.keywords.get_mut("SURFACE") {
        skipped.count = skipped.count.saturating_sub(count);
        if skipped.count == 0 {
            deck.scene.skipped.keywords.shift_remove("SURFACE");
        }
    }
    for body in raw.bodies {
        let found = self::body(deck, body);
        errors.value(found);
    }
}

/// A face of an element of a type that is not read.
struct Face {
    nodes: Vec<Label>,
    /// Where its nodes are.
    corners: Vec<[f64; 3]>,
    is_edge: bool,
    is_solid: bool,
    span: Span,
}

/// The faces of a surface, each once; both sides of a shell are one. None where one of them is not known.
fn faces_of(deck: &Deck<'_>, surface: &RawSurface) -> Option<Vec<Face>> {
    let mut found = Vec::new();
    let mut seen = HashSet::new();
    for (target, face) in &surface.faces {
        let ranges = match &target.value {
            Target::Label(label) => vec![(*label, label.number(), 1)],
            Target::Set(name) => {
                let set = deck.scene.element_sets.get(name)?;
                if !set.labels.is_empty() {
                    return None;
                }
                set.others.clone()
            }
        };
        for element in ranges.into_iter().flat_map(|range| deck.other_elements.within(range)) {
            let element = element?;
            let nodes = element.face(face)?;
            if seen.insert((element.label, if face == "SNEG" { "SPOS" } else { face })) {
                let place = |node: &Label| Some(deck.scene.nodes.get(node)?.coordinates);
                let corners = nodes.iter().map(place).collect::<Option<Vec<_>>>()?;
                let (is_edge, is_solid) = (element.is_edge(face), element.is_solid());
                found.push(Face { nodes, corners, is_edge, is_solid, span: target.span });
            }
        }
        if found.is_empty() {
            return None;
        }
    }
    Some(found)
}

/// The nodes of the faces of a surface, each once, with its area where that weighs; none where one of them is not known.
fn face_nodes(
    deck: &Deck<'_>,
    surface: &RawSurface,
    weighs: bool,
) -> Option<Vec<(Spanned<Target>, Option<f64>)>> {
    let mut known: LabelMap<usize> = LabelMap::default();
    let mut found: Vec<(Spanned<Target>, Option<f64>)> = Vec::new();
    for Face { nodes, corners, is_edge, span, .. } in faces_of(deck, surface)? {
        let shares = if weighs && !is_edge { faces::shares(&corners) } else { None };
        for (index, node) in nodes.into_iter().enumerate() {
            let place = *known.entry(node).or_insert(found.len());
            if place == found.len() {
                found.push((Spanned::new(Target::Label(node), span), weighs.then_some(0.0)));
            }
            let share = shares.as_ref().and_then(|shares| shares.get(index));
            if let Some((_, area)) = found.get_mut(place) {
                *area = area.zip(share).map(|(area, share)| area + share);
            }
        }
    }
    Some(found)
}

/// Faces by where they are.
struct Places<'a> {
    /// Along the axis on which they spread most, by where they begin.
    sorted: Vec<([[f64; 2]; 3], &'a Face)>,
    axis: usize,
    longest: f64,
}

impl<'a> Places<'a> {
    /// Each with a margin around its nodes.
    fn of(faces: &'a [Face], margin: f64) -> Self {
        let ends = |face: &Face| {
            let along = |i: usize| face.corners.iter().map(move |x| x[i]);
            let [low, high] = [
                [0, 1, 2].map(|i| along(i).fold(f64::INFINITY, f64::min)),
                [0, 1, 2].map(|i| along(i).fold(f64::NEG_INFINITY, f64::max)),
            ];
            // A curved face of second order leaves the box of its nodes.
            let slack = if face.nodes.len() > 4 { 0.25 } else { 0.0 };
            let longest = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
            let more = slack * longest + margin;
            [0, 1, 2].map(|i| [low[i] - more, high[i] + more])
        };
        let mut sorted: Vec<_> = faces.iter().map(|face| (ends(face), face)).collect();
        let spread = |i: usize| {
            let low = sorted.iter().map(|(sides, _)| sides[i][0]).fold(f64::INFINITY, f64::min);
            sorted.iter().map(|(sides, _)| sides[i][1]).fold(f64::NEG_INFINITY, f64::max) - low
        };
        let axis = (0..3).max_by(|one, other| spread(*one).total_cmp(&spread(*other))).unwrap_or(0);
        sorted.sort_by(|(one, _), (other, _)| one[axis][0].total_cmp(&other[axis][0]));
        let longest = sorted.iter().map(|(sides, _)| sides[axis][1] - sides[axis][0]).fold(0.0, f64::max);
        Self { sorted, axis, longest }
    }

    /// Those in whose boxes a point is.
    fn around(&self, x: [f64; 3]) -> Vec<&'a Face> {
        let Self { sorted, axis, longest } = self;
        let first = sorted.partition_point(|(sides, _)| sides[*axis][0] < x[*axis] - longest);
        let near = sorted.iter().skip(first).take_while(|(sides, _)| sides[*axis][0] <= x[*axis]);
        let is_in = |sides: &[[f64; 2]; 3]| (0..3).all(|i| sides[i][0] <= x[i] && x[i] <= sides[i][1]);
        near.filter(|(sides, _)| is_in(sides)).map(|(_, face)| *face).collect()
    }
}

/// The nodes of a face with whose displacements a point of it moves, each with its share: one node where it is that, else the shape functions N_i.
/// None where the point is farther from all faces than `reach`.
fn shares_of(near: &[&Face], x: [f64; 3], reach: f64) -> Option<Vec<(Label, f64)>> {
    /// The share of a node that is none.
    const ROUNDED: f64 = 1e-12;
    let apart = |corner: &[f64; 3]| norm(sub(x, *corner));
    let corners = near.iter().flat_map(|face| face.nodes.iter().zip(&face.corners));
    let met = corners.filter(|(_, corner)| apart(corner) <= reach);
    if let Some((node, _)) = met.min_by(|(_, one), (_, other)| apart(one).total_cmp(&apart(other))) {
        return Some(vec![(*node, 1.0)]);
    }
    let on = near.iter().filter_map(|face| Some((faces::shape::at(&face.corners, x)?, face)));
    let ((shares, apart), face) = on.min_by(|one, other| one.0.1.total_cmp(&other.0.1))?;
    let shares = face.nodes.iter().copied().zip(shares);
    (apart <= reach).then(|| shares.filter(|(_, share)| share.abs() > ROUNDED).collect())
}

/// The equations of nodes of the dependent surface of a tie that lie on faces of solids.
///
/// Along each axis e_j of the node u_s·e_j = Σ N_i u_i·e_j, with the shape functions N_i of the face there. None where a node lies off the faces, or a
/// face is of another kind.
fn within_faces(deck: &Deck<'_>, tie: &Tie, master: &RawSurface) -> Option<Vec<Equation>> {
    /// Of the size of a face, how far off it a node is tied where nothing else is said.
    const SHARE: f64 = 0.05;
    let scene = &deck.scene;
    let faces = faces_of(deck, master)?;
    if faces.iter().any(|face| !face.is_solid) {
        return None;
    }
    // As decks are rounded; no more than a tie reaches by itself, a share of the size of a face.
    let largest = faces.iter().flat_map(|face| face.corners.as_flattened());
    let rounded = MEETS * largest.fold(0.0_f64, |most, x| most.max(x.abs()));
    let size = |face: &Face| face.corners.iter().map(|x| norm(sub(*x, face.corners[0]))).fold(0.0, f64::max);
    let smallest = faces.iter().map(size).filter(|size| *size > 0.0).fold(f64::INFINITY, f64::min);
    let reach = rounded.min(SHARE * smallest).min(tie.position_tolerance.unwrap_or(f64::INFINITY));
    let places = Places::of(&faces, reach);
    let masters: LabelSet = faces.iter().flat_map(|face| face.nodes.iter().copied()).collect();
    let mut found = Vec::new();
    // A node that both surfaces share is tied to itself.
    let slaves = scene.surface_nodes(&tie.slave.value).into_iter().map(|(node, _)| node);
    for slave in slaves.filter(|node| !masters.contains(node)) {
        let x = scene.nodes.get(&slave)?.coordinates;
        let shares = shares_of(&places.around(x), x, reach)?;
        // Along the axes of the node itself, so that each equation begins with another of its degrees of freedom.
        for (axis, of_slave) in scene.nodal_axes(slave).ok()?.into_iter().zip(1..) {
            let mut terms = vec![EquationTerm { node: slave, degree_of_freedom: of_slave, factor: 1.0 }];
            for (node, share) in &shares {
                for (along, degree_of_freedom) in scene.nodal_axes(*node).ok()?.into_iter().zip(1..) {
                    let cosine = dot(along, axis);
                    if cosine.abs() > f64::EPSILON {
                        terms.push(EquationTerm { node: *node, degree_of_freedom, factor: -share * cosine });
                    }
                }
            }
            found.push(Equation { terms, span: tie.span });
        }
    }
    Some(found)
}

/// That nodes of the dependent surface of a tie are too far from the other.
fn untied(scene: &Scene, tie: &Tie) -> Option<Diagnostic> {
    let (apart, within) = scene.untied_nodes(tie);
    let first = apart.first()?;
    let (slave, master) = (&tie.slave.value, &tie.master.value);
    let names: Vec<String> = apart.iter().take(3).map(ToString::to_string).collect();
    let more = if apart.len() > names.len() { " …" } else { "" };
    let message = format!(
        "{} of {slave} {} farther than {} from every node of {master}, and not tied: {}{more}",
        grammar::count(apart.len(), "node"),
        grammar::agree(apart.len(), ["is", "are"]),
        format!("{within:.3e}").parse().unwrap_or(within),
        names.join(", "),
    );
    let label = format!("node {first}, for one, is free");
    let remedy = "give POSITION TOLERANCE the largest distance at which a node is tied, or take these nodes out of the surface";
    Some(Diagnostic::warning(Code::TieApart, tie.slave.span, message, label).help(remedy))
}

/// Whether each node of the dependent surface of a tie is where one of the other is.
fn all_meet(scene: &Scene, tie: &Tie) -> bool {
    let masters: LabelSet =
        scene.surface_nodes(&tie.master.value).into_iter().map(|(label, _)| label).collect();
    let slaves = scene.surface_nodes(&tie.slave.value);
    let coordinates = masters.iter().filter_map(|label| scene.nodes.get(label));
    let largest = coordinates.flat_map(|node| node.coordinates).fold(0.0_f64, |most, x| most.max(x.abs()));
    let rounded = MEETS * largest;
    // Where coordinates are large, no more than a tie reaches by itself.
    let own = scene.tie_reach(&Tie { position_tolerance: None, ..tie.clone() });
    let within = Tie { position_tolerance: Some(rounded.min(own)), ..tie.clone() };
    let apart = slaves.iter().filter(|(label, _)| !masters.contains(label)).count();
    scene.tied_nodes(&within).len() >= apart
}

fn body(deck: &mut Deck<'_>, body: RawBody) -> Result<()> {
    let scene = &deck.scene;
    let reference = one_node(scene, &body.reference);
    let node_sets: Vec<_> =
        [&body.pin_set, &body.tie_set].into_iter().flatten().map(|name| node_set(scene, name)).collect();
    let elements = body.element_set.as_ref().map(|name| element_set(scene, name)).transpose();
    let faults = node_sets.iter().filter_map(|set| set.as_ref().err());
    let faults: Vec<Diagnostic> =
        reference.as_ref().err().into_iter().chain(faults).chain(elements.as_ref().err()).cloned().collect();
    if let Some(faults) = Diagnostic::joined(faults) {
        return Err(faults);
    }
    let reference = reference?;
    // What is known of the body is read, and that it is not all is said.
    let mut lacks = node_sets.iter().flatten().any(|set| set.unmodelled > 0);
    let mut others = Vec::new();
    if let Some(set) = elements? {
        let ranges = &set.others;
        if !ranges.is_empty() {
            // The rest of a rigid mesh bears on nothing.
            let used = used_nodes(&deck.scene);
            for element in ranges.iter().flat_map(|range| deck.other_elements.within(*range)) {
                lacks |= element.is_none();
                others.extend(element.iter().flat_map(Element::nodes).filter(|node| used.contains(node)));
            }
            others.sort_unstable();
            others.dedup();
        }
    }
    if lacks {
        deck.leave_out("RIGID BODY", body.span, 0);
    }
    let RawBody { element_set, pin_set, tie_set, span, .. } = body;
    deck.scene.rigid_bodies.push(RigidBody { reference, element_set, others, pin_set, tie_set, span });
    Ok(())
}

/// The nodes of what is read: of elements and constraints, and those that are held or driven.
fn used_nodes(scene: &Scene) -> LabelSet {
    let mut used = unread::bearing(scene);
    let boundaries = scene.boundaries.iter().chain(scene.steps.iter().flat_map(|step| &step.boundaries));
    for boundary in boundaries {
        match &boundary.target.value {
            Target::Label(label) => drop(used.insert(*label)),
            Target::Set(name) => {
                used.extend(scene.node_sets.get(name).into_iter().flat_map(|set| &set.labels))
            }
        }
    }
    used
}

/// A coupling for each element of a `*DISTRIBUTING COUPLING`; named as unread where the node of one is not known.
fn couplings_of(deck: &mut Deck<'_>, distribution: &RawDistribution) -> Result<Vec<RawCoupling>> {
    let RawDistribution { elements, surface, span } = distribution;
    let set = element_set(&deck.scene, elements)?;
    let all = set.others.iter().flat_map(|range| deck.other_elements.within(*range));
    let reference = |element: Option<Element<'_>>| element.filter(Element::distributes)?.nodes().next();
    let references: Option<Vec<Label>> = all.map(reference).collect();
    // Weights that add up to nothing make no mean.
    let weights = deck.scene.surfaces.get(&surface.value).into_iter().flat_map(|surface| &surface.members);
    let weights: Vec<f64> = weights.map(|(_, weight)| weight.unwrap_or(1.0)).collect();
    let has_mean = weights.iter().all(|weight| *weight >= 0.0) && weights.iter().any(|weight| *weight > 0.0);
    let is_known = |found: &Vec<Label>| !found.is_empty() && set.labels.is_empty() && has_mean;
    let Some(references) = references.filter(is_known) else {
        deck.leave_out("DISTRIBUTING COUPLING", *span, 0);
        return Ok(Vec::new());
    };
    let coupling = |reference: Label| RawCoupling {
        name: Spanned::new(String::new(), *span),
        reference: Spanned::new(Target::Label(reference), elements.span),
        surface: surface.clone(),
        orientation: None,
        influence_radius: None,
        kind: Some(CouplingKind::Distributing(Weighting::Uniform)),
        span: *span,
    };
    if let Some(skipped) = deck.scene.skipped.element_types.get_mut(Element::DISTRIBUTES) {
        skipped.count = skipped.count.saturating_sub(references.len() as u64);
    }
    deck.scene.skipped.element_types.retain(|_, skipped| skipped.count > 0);
    Ok(references.into_iter().map(coupling).collect())
}

fn resolved_coupling(
    deck: &mut Deck<'_>,
    coupling: RawCoupling,
    has: &impl Fn(&Spanned<String>) -> Result<SurfaceKind>,
) -> Result<bool> {
    if let Target::Set(name) = &coupling.reference.value
        && deck.scene.node_sets.get(name).is_some_and(|set| set.labels.len() > 1)
    {
        // Which node of the surface goes with which of several reference nodes is not followed.
        deck.leave_out("COUPLING", coupling.span, 0);
        return Ok(false);
    }
    let reference = one_node(&deck.scene, &coupling.reference);
    let surface = has(&coupling.surface);
    let faults = reference.as_ref().err().into_iter().chain(surface.as_ref().err()).cloned();
    if let Some(faults) = Diagnostic::joined(faults) {
        return Err(faults);
    }
    let (reference, kind_of_surface) = (reference?, surface?);
    // Faces weigh the nodes of a mean by their areas.
    let known = deck.scene.surfaces.get(&coupling.surface.value);
    let weighs = || known.is_some_and(|known| known.members.iter().all(|(_, area)| area.is_some()));
    let is_known = known.is_some()
        && match kind_of_surface {
            SurfaceKind::Nodes => true,
            SurfaceKind::Faces => matches!(coupling.kind, Some(CouplingKind::Kinematic(_))) || weighs(),
            SurfaceKind::Unread => false,
        };
    let Some(kind) = coupling.kind.filter(|_| is_known) else {
        deck.rotation_targets.push(Target::Label(reference));
        deck.leave_out("COUPLING", coupling.span, 0);
        return Ok(false);
    };
    check_orientation(&deck.scene, coupling.orientation.as_ref())?;
    let RawCoupling { name, surface, orientation, influence_radius, span, .. } = coupling;
    let coupling = Coupling { name, reference, surface, orientation, influence_radius, kind, span };
    // Of faces a radius takes all nodes of each that it cuts, or of the nearest one.
    let all = Coupling { influence_radius: None, ..coupling.clone() };
    let within = |coupling: &Coupling| deck.scene.coupling_nodes(coupling).len();
    if kind_of_surface == SurfaceKind::Faces && within(&coupling) < within(&all) {
        deck.rotation_targets.push(Target::Label(reference));
        deck.leave_out("COUPLING", span, 0);
        return Ok(false);
    }
    if deck.scene.coupling_nodes(&coupling).is_empty() {
        let message = "a coupling has no coupling nodes";
        return Err(Diagnostic::error(Code::EmptySet, coupling.surface.span, message, "no nodes")
            .help("give the surface other nodes than the reference node, within the influence radius"));
    }
    deck.scene.couplings.push(coupling);
    Ok(true)
}

/// Whether a member of a surface lacks no nodes.
fn is_whole(scene: &Scene, member: &Spanned<Target>) -> bool {
    match &member.value {
        Target::Label(_) => true,
        Target::Set(name) => scene.node_sets.get(name).is_none_or(|set| set.unmodelled == 0),
    }
}
