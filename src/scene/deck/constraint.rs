//! Equations, rigid bodies, couplings and ties. What of them cannot be read is named as a constraint that was not read.

use crate::deck::errors::Errors;
use crate::deck::faces;
use crate::deck::faces::Element;
use crate::deck::lookup::{check_orientation, element_set, node_set, node_target, target};
use crate::deck::{Deck, misplaced, unread};
use crate::diagnostic::{Code, Diagnostic, Result, suggest_scoped};
use crate::grammar;
use crate::label::labelled::{LabelMap, LabelSet};
use crate::label::{Instance, Label};
use crate::lexer::{Items, Keyword, Value, begun};
use crate::model::{Coupling, CouplingKind, Equation, EquationTerm, RigidBody, Surface, Tie, Weighting};
use crate::model::{Scene, SkippedConstraint, Target};
use crate::span::{Span, Spanned};
use indexmap::IndexMap;
use std::collections::HashSet;

/// A term of an equation, with sets for nodes.
#[derive(Debug, Clone)]
struct RawTerm {
    node: Spanned<Target>,
    degree_of_freedom: u64,
    factor: f64,
}

/// `*SURFACE`.
#[derive(Debug, Clone)]
struct RawSurface {
    surface: Surface,
    kind: SurfaceKind,
    /// Elements, and identifiers of their faces.
    faces: Vec<(Spanned<Target>, String)>,
}

/// What a surface is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SurfaceKind {
    Nodes,
    /// Faces of elements of types that are not read: of use where their nodes are all that is asked for.
    Faces,
    /// It is known by name only.
    Unread,
}

#[derive(Debug, Clone)]
struct RawBody {
    reference: Spanned<Target>,
    element_set: Option<Spanned<String>>,
    pin_set: Option<Spanned<String>>,
    tie_set: Option<Spanned<String>>,
    span: Span,
}

#[derive(Debug, Clone)]
struct RawCoupling {
    name: Spanned<String>,
    reference: Spanned<Target>,
    surface: Spanned<String>,
    orientation: Option<Spanned<String>>,
    influence_radius: Option<f64>,
    /// None until `*KINEMATIC` or `*DISTRIBUTING` says.
    kind: Option<CouplingKind>,
    span: Span,
}

/// What was read of constraints, before the references are resolved.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    equations: Vec<(Vec<RawTerm>, Span)>,
    surfaces: IndexMap<String, RawSurface>,
    bodies: Vec<RawBody>,
    couplings: Vec<RawCoupling>,
    ties: Vec<Tie>,
    /// The last `*COUPLING` is one that is not read.
    coupling_is_unread: bool,
}

impl Raw {
    /// The number of constraints and surfaces, which an instance copies.
    pub(super) fn len(&self) -> usize {
        let of_surfaces =
            self.surfaces.values().map(|raw| 1 + raw.surface.members.len() + raw.faces.len()).sum::<usize>();
        self.equations.len() + of_surfaces + self.bodies.len() + self.couplings.len() + self.ties.len()
    }

    /// Is there none?
    pub(super) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The orientations that are named.
    pub(super) fn orientations(&self) -> impl Iterator<Item = &str> {
        self.couplings.iter().filter_map(|coupling| Some(coupling.orientation.as_ref()?.value.as_str()))
    }

    /// The node sets, and the element sets, that are named.
    pub(super) fn sets(&self) -> [Vec<&str>; 2] {
        fn all<'a>(names: impl Iterator<Item = &'a Spanned<String>>) -> impl Iterator<Item = &'a str> {
            names.map(|name| name.value.as_str())
        }
        let terms = self.equations.iter().flat_map(|(terms, _)| terms).map(|term| &term.node);
        let members = self
            .surfaces
            .values()
            .filter(|raw| raw.kind == SurfaceKind::Nodes)
            .flat_map(|raw| &raw.surface.members);
        let targets = terms.chain(members.map(|(member, _)| member));
        let targets = targets.chain(self.bodies.iter().map(|body| &body.reference));
        let targets = targets.chain(self.couplings.iter().map(|coupling| &coupling.reference));
        let of_bodies = self.bodies.iter().flat_map(|body| body.pin_set.iter().chain(&body.tie_set));
        let elements = self.bodies.iter().filter_map(|body| body.element_set.as_ref());
        [
            targets.filter_map(|target| target.value.set()).chain(all(of_bodies)).collect(),
            all(elements).collect(),
        ]
    }

    /// The element sets of faces that a coupling or a tie uses.
    pub(super) fn sets_of_faces(&self) -> impl Iterator<Item = &str> {
        let ties = self.ties.iter().flat_map(|tie| [&tie.slave, &tie.master]);
        let used = self.couplings.iter().map(|coupling| &coupling.surface).chain(ties);
        let faces = used.filter_map(|name| self.surfaces.get(&name.value)).flat_map(|raw| &raw.faces);
        faces.filter_map(|(target, _)| target.value.set())
    }

    /// Takes those of a part, for an instance of it.
    pub(super) fn place(&mut self, part: Self, instance: Instance, target: &impl Fn(Target) -> Target) {
        let Self { equations, surfaces, bodies, couplings, ties, coupling_is_unread: _ } = part;
        let placed = |node: &mut Spanned<Target>| node.value = target(node.value.clone());
        let scoped = |name: &mut Spanned<String>| name.value = instance.scoped(&name.value);
        for (mut terms, span) in equations {
            terms.iter_mut().for_each(|term| placed(&mut term.node));
            self.equations.push((terms, span));
        }
        for (name, mut raw) in surfaces {
            raw.surface.members.iter_mut().for_each(|(member, _)| placed(member));
            raw.faces.iter_mut().for_each(|(element, _)| placed(element));
            self.surfaces.insert(instance.scoped(&name), raw);
        }
        for mut body in bodies {
            placed(&mut body.reference);
            let sets = [&mut body.element_set, &mut body.pin_set, &mut body.tie_set];
            sets.into_iter().flatten().for_each(scoped);
            self.bodies.push(body);
        }
        for mut coupling in couplings {
            placed(&mut coupling.reference);
            scoped(&mut coupling.name);
            scoped(&mut coupling.surface);
            coupling.orientation.iter_mut().for_each(scoped);
            self.couplings.push(coupling);
        }
        for mut tie in ties {
            [&mut tie.name, &mut tie.slave, &mut tie.master].into_iter().for_each(scoped);
            self.ties.push(tie);
        }
    }
}

impl Deck<'_> {
    /// Names a constraint that is not read, and counts it with the keywords that are skipped.
    fn leave_out(&mut self, keyword: &'static str, span: Span, data_lines: u64) {
        self.scene.skipped.constraints.push(SkippedConstraint { keyword, span });
        let skipped = self.scene.skipped.keywords.entry(keyword.to_owned()).or_default();
        if skipped.count == 0 {
            skipped.first_line = span.line();
        }
        skipped.count += 1;
        skipped.data_lines += data_lines;
    }

    /// The same with the data of the keyword that is being read; what gives nodes rotations does so all the same.
    fn pass_constraint(&mut self, keyword: &Keyword, name: &'static str) -> Result<()> {
        self.leave_out(name, keyword.span, 0);
        for parameter in ["REF NODE", "TIE NSET"] {
            let node = keyword.get(parameter).and_then(|value| named(value).ok());
            self.rotation_targets.extend(node.map(|node| node.value));
        }
        let lines = self.lexer.skip()?;
        if let Some(skipped) = self.scene.skipped.keywords.get_mut(name) {
            skipped.data_lines += lines;
        }
        Ok(())
    }
}

/// A node, or a set, that a parameter names.
pub(super) fn named(value: &Value) -> Result<Spanned<Target>> {
    let name = value.name()?;
    // A name in quotation marks keeps its case as the instance of a node: `"Part 1".2`.
    let label = value.text().parse().or_else(|_| name.value.parse());
    let target = label.map_or_else(|_| Target::Set(name.value.clone()), Target::Label);
    Ok(Spanned::new(target, name.span))
}

pub(super) fn equation(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    // In a step it is not of the model throughout.
    if keyword.has("REMOVE") || deck.step.is_some() {
        return deck.pass_constraint(keyword, "EQUATION");
    }
    while let Some(line) = deck.lexer.row()? {
        let span = line.span;
        let mut items = line.items();
        let count = items.need("the number of terms")?.integer("the number of terms")?;
        items.end("the number of terms; the terms follow on the next lines")?;
        let mut terms: Vec<RawTerm> = Vec::new();
        while (terms.len() as u64) < count {
            let Some(line) = deck.lexer.row()? else {
                let message = format!("an equation of {} has {}", grammar::count(count, "term"), terms.len());
                return Err(Diagnostic::error(Code::MissingData, span, message, "begins here").help(
                    "give node, degree of freedom and factor of each term, up to four terms on a line",
                ));
            };
            let mut items = line.items();
            while let Some(item) = items.maybe() {
                let node = target(&item, "the node of a term")?;
                let number = "the degree of freedom of a term";
                let degree_of_freedom = items.need(number)?.integer(number)?;
                let factor = items.need("the factor of a term")?.number()?;
                terms.push(RawTerm { node, degree_of_freedom, factor });
            }
        }
        if terms.len() as u64 > count {
            let message = format!("an equation of {} has {}", grammar::count(count, "term"), terms.len());
            return Err(Diagnostic::error(Code::SurplusData, span, message, "begins here")
                .help("correct the number of terms, or begin the next equation on a line of its own"));
        }
        deck.constraints.equations.push((terms, span));
    }
    Ok(())
}

pub(super) fn surface(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let name = keyword.need_name("NAME")?;
    let of_type = keyword.get("TYPE").map(|value| crate::label::normal(value.text()));
    // Shortened or not.
    let of_type = of_type.as_deref().map(|word| begun(word, &["NODE", "ELEMENT"]).unwrap_or(word));
    let kind = match of_type {
        _ if keyword.has("COMBINE") || keyword.has("CROP") => SurfaceKind::Unread,
        Some("NODE") => SurfaceKind::Nodes,
        Some("ELEMENT") | None => SurfaceKind::Faces,
        Some(_) => SurfaceKind::Unread,
    };
    let (mut members, mut faces) = (Vec::new(), Vec::new());
    match kind {
        SurfaceKind::Nodes => {
            while let Some(line) = deck.lexer.row()? {
                let mut items = line.items();
                let member = target(&items.need("a node or node set")?, "a node or node set")?;
                let area = items.number()?;
                members.push((member, area));
            }
        }
        _ => {
            let mut lines = 0;
            while let Some(line) = deck.lexer.row()? {
                lines += 1;
                let mut items = line.items();
                let element = items.maybe().and_then(|item| target(&item, "an element or element set").ok());
                let face = items.maybe().map_or(String::new(), |item| crate::label::normal(item.text));
                faces.extend(element.map(|element| (element, face)));
            }
            let skipped = deck.scene.skipped.keywords.entry("SURFACE".to_owned()).or_default();
            if skipped.count == 0 {
                skipped.first_line = keyword.span.line();
            }
            skipped.count += 1;
            skipped.data_lines += lines;
        }
    }
    let surface = Surface { members, span: keyword.span };
    let raw = RawSurface { surface, kind, faces };
    if let Some(known) = deck.constraints.surfaces.get_mut(&name.value) {
        // A surface may be given in several parts.
        if known.kind != raw.kind {
            known.kind = SurfaceKind::Unread;
        }
        known.surface.members.extend(raw.surface.members);
        known.faces.extend(raw.faces);
    } else {
        deck.constraints.surfaces.insert(name.value, raw);
    }
    Ok(())
}

pub(super) fn rigid_body(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let is_elsewhere = keyword.get("POSITION").is_some_and(|value| value.text().starts_with(['C', 'c']));
    // NSET is CalculiX's: its nodes have displacements alone, and the body turns as it will unless a ROT NODE says how.
    let is_other = keyword.has("ROT NODE")
        || keyword.has("ANALYTICAL SURFACE")
        || (keyword.has("NSET") && keyword.has("PIN NSET"));
    let has_nodes = ["ELSET", "PIN NSET", "TIE NSET", "NSET"].iter().any(|parameter| keyword.has(parameter));
    // A surface that moves with its reference node constrains no other node.
    if keyword.has("ANALYTICAL SURFACE") && !has_nodes {
        let lines = deck.lexer.skip()?;
        deck.count_skipped(keyword, lines);
        return Ok(());
    }
    let Some(reference) = keyword.get("REF NODE").filter(|_| !is_elsewhere && !is_other && has_nodes) else {
        return deck.pass_constraint(keyword, "RIGID BODY");
    };
    let body = RawBody {
        reference: named(reference)?,
        element_set: keyword.name_of("ELSET")?,
        pin_set: keyword.name_of("PIN NSET")?.or(keyword.name_of("NSET")?),
        tie_set: keyword.name_of("TIE NSET")?,
        span: keyword.span,
    };
    deck.constraints.bodies.push(body);
    deck.lexer.skip()?;
    Ok(())
}

pub(super) fn coupling(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let (Some(reference), Some(surface)) = (keyword.get("REF NODE"), keyword.name_of("SURFACE")?) else {
        deck.constraints.coupling_is_unread = true;
        return deck.pass_constraint(keyword, "COUPLING");
    };
    let name = keyword.name_of("CONSTRAINT NAME")?;
    let coupling = RawCoupling {
        name: name.unwrap_or_else(|| Spanned::new(String::new(), keyword.span)),
        reference: named(reference)?,
        surface,
        orientation: keyword.name_of("ORIENTATION")?,
        influence_radius: keyword.number("INFLUENCE RADIUS")?,
        kind: None,
        span: keyword.span,
    };
    deck.constraints.coupling_is_unread = false;
    deck.constraints.couplings.push(coupling);
    Ok(())
}

/// The degrees of freedom on data lines; all where there are none. Those of other physics are passed over.
fn degrees_of_freedom(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<Vec<u8>> {
    let mut found: Vec<u8> = Vec::new();
    let mut any = false;
    while let Some(line) = deck.lexer.row()? {
        let of_line = from_to(line.items(), keyword, line.span)?;
        any |= of_line.is_some();
        found.extend(of_line.into_iter().flatten());
    }
    found.sort_unstable();
    found.dedup();
    Ok(if any { found } else { (1..=6).collect() })
}

/// The first and the last of degrees of freedom, as items that end a line; none where there are none.
fn from_to(mut items: Items<'_>, keyword: &Keyword, line: Span) -> Result<Option<Vec<u8>>> {
    let Some(first) = items.maybe() else { return Ok(None) };
    let first = first.integer("the first degree of freedom")?;
    let last = items.maybe().map_or(Ok(first), |item| item.integer("the last degree of freedom"))?;
    items.end("the first and the last degree of freedom")?;
    if first == 0 || last < first {
        let message = format!("*{} names no degrees of freedom from {first} to {last}", keyword.name);
        return Err(Diagnostic::error(Code::BadDegreeOfFreedom, line, message, "this line")
            .help("write the first and the last degree of freedom, 1 to 6"));
    }
    Ok(Some((first..=last.min(6)).filter_map(|number| u8::try_from(number).ok()).collect()))
}

/// `*KINEMATIC COUPLING`, the older form: a coupling for each of its lines, which name nodes and what of them is coupled.
pub(super) fn kinematic_coupling(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let Some(reference) = keyword.get("REF NODE") else {
        return deck.pass_constraint(keyword, "KINEMATIC COUPLING");
    };
    let (reference, orientation) = (named(reference)?, keyword.name_of("ORIENTATION")?);
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let member = target(&items.need("a node or node set")?, "a node or node set")?;
        let numbers = from_to(items, keyword, line.span)?.unwrap_or_else(|| (1..=6).collect());
        // Degrees of freedom of other physics alone.
        if numbers.is_empty() {
            continue;
        }
        let surfaces = &mut deck.constraints.surfaces;
        let is_free = |n: &usize| !surfaces.contains_key(&format!("KINEMATIC_COUPLING_{n}"));
        let Some(n) = (surfaces.len() + 1..).find(is_free) else { continue };
        let name = format!("KINEMATIC_COUPLING_{n}");
        let surface = Surface { members: vec![(member, None)], span: line.span };
        surfaces.insert(name.clone(), RawSurface { surface, kind: SurfaceKind::Nodes, faces: Vec::new() });
        deck.constraints.couplings.push(RawCoupling {
            name: Spanned::new(String::new(), keyword.span),
            reference: reference.clone(),
            surface: Spanned::new(name, line.span),
            orientation: orientation.clone(),
            influence_radius: None,
            kind: Some(CouplingKind::Kinematic(numbers)),
            span: keyword.span,
        });
    }
    Ok(())
}

/// Says what the coupling above does.
fn decide(deck: &mut Deck<'_>, keyword: &Keyword, kind: Option<CouplingKind>) -> Result<()> {
    if deck.constraints.coupling_is_unread {
        return Ok(());
    }
    let Some(coupling) = deck.constraints.couplings.last_mut().filter(|coupling| coupling.kind.is_none())
    else {
        return Err(misplaced(keyword, "*COUPLING"));
    };
    coupling.kind = kind;
    if coupling.kind.is_none() {
        let Some(left) = deck.constraints.couplings.pop() else { return Ok(()) };
        deck.rotation_targets.push(left.reference.value);
        deck.leave_out("COUPLING", left.span, 0);
        deck.constraints.coupling_is_unread = true;
    }
    Ok(())
}

pub(super) fn kinematic(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let numbers = degrees_of_freedom(deck, keyword)?;
    // Degrees of freedom of other physics alone.
    let kind = (!numbers.is_empty()).then_some(CouplingKind::Kinematic(numbers));
    decide(deck, keyword, kind)
}

/// A mean of rotations, a released rotation, and cyclic symmetry are not read.
pub(super) fn distributing(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let weighting = keyword.choice::<Weighting>("WEIGHTING METHOD")?.unwrap_or(Weighting::Uniform);
    let is_structural = keyword.word("COUPLING", &["CONTINUUM", "STRUCTURAL"])? == Some("STRUCTURAL");
    let numbers = degrees_of_freedom(deck, keyword)?;
    let is_whole = [4, 5, 6].iter().all(|number| numbers.contains(number));
    let is_read = is_whole && !is_structural && !keyword.has("CYCLIC SYMMETRY");
    decide(deck, keyword, is_read.then_some(CouplingKind::Distributing(weighting)))
}

pub(super) fn tie(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let is_other = ["CYCLIC SYMMETRY", "MULTISTAGE", "MULTIPHYSICS", "FLUID PERIODIC", "CONSTRAINT RATIO"];
    let is_nodal =
        keyword.get("TYPE").is_some_and(|value| crate::label::normal(value.text()) == "NODE TO SURFACE");
    if is_other.iter().any(|parameter| keyword.has(parameter)) || (keyword.has("TYPE") && !is_nodal) {
        return deck.pass_constraint(keyword, "TIE");
    }
    let name = keyword.name_of("NAME")?.unwrap_or_else(|| Spanned::new(String::new(), keyword.span));
    let mut others = Vec::new();
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let slave = items.need("the dependent surface")?.name()?;
        let Some(master) = items.maybe() else {
            // One surface alone, or node sets, tie something else.
            others.push(line.span);
            continue;
        };
        let tie = Tie {
            name: name.clone(),
            slave,
            master: master.name()?,
            position_tolerance: keyword.number("POSITION TOLERANCE")?,
            no_rotation: keyword.has("NO ROTATION"),
            span: line.span,
        };
        deck.constraints.ties.push(tie);
    }
    others.into_iter().for_each(|span| deck.leave_out("TIE", span, 1));
    Ok(())
}

/// The nodes of the constraints of a scene.
pub(super) fn nodes(scene: &Scene) -> Vec<Label> {
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
    let number = |term: &RawTerm| match term.degree_of_freedom {
        number @ (1..=6 | 10) => u8::try_from(number).ok(),
        _ => None,
    };
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
pub(super) fn resolve(deck: &mut Deck<'_>, errors: &mut Errors) {
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
    for coupling in raw.couplings {
        let surface = coupling.surface.value.clone();
        if errors.value(resolved_coupling(deck, coupling, &has)) == Some(true) {
            used.insert(surface);
        }
    }
    for tie in raw.ties {
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
        } else {
            deck.leave_out("TIE", tie.span, 1);
        }
    }
    // Faces that were of use are no longer among what is skipped.
    deck.scene.surfaces.retain(|name, _| {
        used.contains(name) || raw.surfaces.get(name).is_none_or(|raw| raw.kind == SurfaceKind::Nodes)
    });
    let of_faces = |name: &&String| raw.surfaces.get(*name).is_some_and(|raw| raw.kind == SurfaceKind::Faces);
    let count = used.iter().filter(of_faces).count() as u64;
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

/// The nodes of the faces of a surface, each once, with its area where that weighs; none where one of them is not known.
fn face_nodes(
    deck: &Deck<'_>,
    surface: &RawSurface,
    weighs: bool,
) -> Option<Vec<(Spanned<Target>, Option<f64>)>> {
    let mut known: LabelMap<usize> = LabelMap::default();
    let mut found: Vec<(Spanned<Target>, Option<f64>)> = Vec::new();
    // A surface has a face once, whatever names it; both sides of a shell are one.
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
        let from = found.len();
        for element in ranges.into_iter().flat_map(|range| deck.other_elements.within(range)) {
            let element = element?;
            let nodes = element.face(face)?;
            if !seen.insert((element.label, if face == "SNEG" { "SPOS" } else { face })) {
                continue;
            }
            let place = |node: &Label| Some(deck.scene.nodes.get(node)?.coordinates);
            let corners = nodes.iter().map(place).collect::<Option<Vec<_>>>()?;
            let shares = if weighs && !element.is_edge(face) { faces::shares(&corners) } else { None };
            for (index, node) in nodes.into_iter().enumerate() {
                let place = *known.entry(node).or_insert(found.len());
                if place == found.len() {
                    found.push((Spanned::new(Target::Label(node), target.span), weighs.then_some(0.0)));
                }
                let share = shares.as_ref().and_then(|shares| shares.get(index));
                if let Some((_, area)) = found.get_mut(place) {
                    *area = area.zip(share).map(|(area, share)| area + share);
                }
            }
        }
        if from == found.len() && known.is_empty() {
            return None;
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
        "{} of {slave} {} farther than {within} from every node of {master}, and not tied: {}{more}",
        grammar::count(apart.len(), "node"),
        grammar::agree(apart.len(), ["is", "are"]),
        names.join(", "),
    );
    let label = format!("node {first}, for one, is free");
    let remedy = "give POSITION TOLERANCE the largest distance at which a node is tied, or take these nodes out of the surface";
    Some(Diagnostic::warning(Code::TieApart, tie.slave.span, message, label).help(remedy))
}

/// Whether each node of the dependent surface of a tie is where one of the other is.
fn all_meet(scene: &Scene, tie: &Tie) -> bool {
    /// Of the largest coordinate: six digits.
    const MEETS: f64 = 2e-6;
    let masters: LabelSet =
        scene.surface_nodes(&tie.master.value).into_iter().map(|(label, _)| label).collect();
    let slaves = scene.surface_nodes(&tie.slave.value);
    let coordinates = masters.iter().filter_map(|label| scene.nodes.get(label));
    let largest = coordinates.flat_map(|node| node.coordinates).fold(0.0_f64, |most, x| most.max(x.abs()));
    let within = Tie { position_tolerance: Some(MEETS * largest), ..tie.clone() };
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
