//! Equations, rigid bodies, couplings and ties. What of them cannot be read is named as a constraint that was not read.

mod resolve;

use crate::deck::lookup::target;
use crate::deck::mesh::{LAST_FREEDOM, any_degree_of_freedom};
use crate::deck::{Deck, misplaced};
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::grammar;
use crate::label::Instance;
use crate::lexer::{Items, Keyword, Value, begun};
use crate::model::{CouplingKind, SkippedConstraint, Surface, Target, Tie, Weighting};
use crate::span::{Span, Spanned};
use indexmap::IndexMap;

pub(super) use resolve::{nodes, resolve};

/// A term of an equation, with sets for nodes.
#[derive(Debug, Clone)]
struct RawTerm {
    node: Spanned<Target>,
    degree_of_freedom: u8,
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

/// `*DISTRIBUTING COUPLING`: the nodes of these elements are the reference nodes.
#[derive(Debug, Clone)]
struct RawDistribution {
    elements: Spanned<String>,
    surface: Spanned<String>,
    span: Span,
}

/// What was read of constraints, before the references are resolved.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    equations: Vec<(Vec<RawTerm>, Span)>,
    surfaces: IndexMap<String, RawSurface>,
    bodies: Vec<RawBody>,
    couplings: Vec<RawCoupling>,
    distributions: Vec<RawDistribution>,
    /// With whether it is one of nodes to a surface, whatever the dependent surface is made of.
    ties: Vec<(Tie, bool)>,
    /// The last `*COUPLING` is one that is not read.
    coupling_is_unread: bool,
}

impl Raw {
    /// The number of constraints and surfaces, which an instance copies.
    pub(super) fn len(&self) -> usize {
        let of_surfaces =
            self.surfaces.values().map(|raw| 1 + raw.surface.members.len() + raw.faces.len()).sum::<usize>();
        let of_lists =
            [self.equations.len(), self.bodies.len(), self.couplings.len(), self.distributions.len()];
        of_lists.iter().sum::<usize>() + of_surfaces + self.ties.len()
    }

    /// Nodes as a surface that nothing else names.
    fn own_surface(
        &mut self,
        of: &str,
        members: Vec<(Spanned<Target>, Option<f64>)>,
        span: Span,
    ) -> Spanned<String> {
        let surfaces = &mut self.surfaces;
        let mut name =
            |n: usize| Some(format!("{of}_COUPLING_{n}")).filter(|name| !surfaces.contains_key(name));
        let name = (surfaces.len() + 1..).find_map(&mut name).unwrap_or_default();
        let surface = Surface { members, span };
        surfaces.insert(name.clone(), RawSurface { surface, kind: SurfaceKind::Nodes, faces: Vec::new() });
        Spanned::new(name, span)
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
        let elements = elements.chain(self.distributions.iter().map(|one| &one.elements));
        [
            targets.filter_map(|target| target.value.set()).chain(all(of_bodies)).collect(),
            all(elements).collect(),
        ]
    }

    /// The element sets of faces that a coupling or a tie uses.
    pub(super) fn sets_of_faces(&self) -> impl Iterator<Item = &str> {
        let ties = self.ties.iter().flat_map(|(tie, _)| [&tie.slave, &tie.master]);
        let used = self.couplings.iter().map(|coupling| &coupling.surface).chain(ties);
        let faces = used.filter_map(|name| self.surfaces.get(&name.value)).flat_map(|raw| &raw.faces);
        faces.filter_map(|(target, _)| target.value.set())
    }

    /// Takes those of a part, for an instance of it.
    pub(super) fn place(&mut self, part: Self, instance: Instance, target: &impl Fn(Target) -> Target) {
        let Self { equations, surfaces, bodies, couplings, distributions, ties, coupling_is_unread: _ } =
            part;
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
        for mut distribution in distributions {
            scoped(&mut distribution.elements);
            scoped(&mut distribution.surface);
            self.distributions.push(distribution);
        }
        for (mut tie, is_nodal) in ties {
            [&mut tie.name, &mut tie.slave, &mut tie.master].into_iter().for_each(scoped);
            self.ties.push((tie, is_nodal));
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
                let degree_of_freedom = any_degree_of_freedom(&items.need(number)?)?;
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
    if first == 0 || last < first || last > LAST_FREEDOM.into() {
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
        let surface = deck.constraints.own_surface("KINEMATIC", vec![(member, None)], line.span);
        deck.constraints.couplings.push(RawCoupling {
            name: Spanned::new(String::new(), keyword.span),
            reference: reference.clone(),
            surface,
            orientation: orientation.clone(),
            influence_radius: None,
            kind: Some(CouplingKind::Kinematic(numbers)),
            span: keyword.span,
        });
    }
    Ok(())
}

/// `*DISTRIBUTING COUPLING`, the older form: elements whose node moves with the mean of nodes, each with its weight.
pub(super) fn distributing_coupling(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let elements = keyword.need_name("ELSET")?;
    // Mass that is distributed, too.
    if keyword.has("MASS") {
        return deck.pass_constraint(keyword, "DISTRIBUTING COUPLING");
    }
    let mut members = Vec::new();
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let member = target(&items.need("a node or node set")?, "a node or node set")?;
        let weight = items.need("the weight of each of the nodes")?.number()?;
        items.end("a node or node set, and its weight")?;
        members.push((member, Some(weight)));
    }
    let surface = deck.constraints.own_surface("DISTRIBUTING", members, keyword.span);
    deck.constraints.distributions.push(RawDistribution { elements, surface, span: keyword.span });
    Ok(())
}

/// Says what the coupling above does.
fn decide(deck: &mut Deck<'_>, keyword: &Keyword, kind: Option<CouplingKind>) -> Result<()> {
    if deck.constraints.coupling_is_unread {
        return Ok(());
    }
    let Some(coupling) = deck.constraints.couplings.last_mut().filter(|coupling| coupling.kind.is_none())
    else {
        return Err(misplaced(keyword, ["*COUPLING"; 2]));
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
        deck.constraints.ties.push((tie, is_nodal));
    }
    others.into_iter().for_each(|span| deck.leave_out("TIE", span, 1));
    Ok(())
}
