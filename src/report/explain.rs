//! `pintle explain TYPE`: what a connection type is, in the order of the manual's summary table, and what rests on what.

use crate::formulas;
use crate::formulas::Group;
use crate::layout;
use crate::layout::{BOLD, DIM, styled};
use crate::list::{is_measured, names};
use crate::words;
use crate::words::{NOTATION, ROWS, SIGNS};
use pintle_kinematics::catalog::{
    Availability, COMPONENT, Class, Condition, ConnectionType, Evidence, FORCE, Friction, OrientationRule,
    PLANE, SPATIAL, Slot,
};
use pintle_kinematics::measure::{Measure, SingularSet, Unit};
use pintle_scene::{Code, Severity};
use serde::Serialize;
use std::io::{self, Write};

/// The version of the JSON form.
pub const SCHEMA: &str = "pintle-explain/1";

/// Blanks before the text of a page.
pub(super) const INDENT: usize = 2;

/// A connection type explained.
#[derive(Debug, Serialize)]
pub struct Explanation {
    schema: &'static str,
    version: &'static str,
    name: String,
    class: Class,
    made_of: Vec<&'static str>,
    summary: Vec<Field>,
    notation: &'static str,
    components: Vec<Component>,
    forces: Vec<&'static str>,
    friction: Vec<Criterion>,
    rotations_at_a: bool,
    rotations_at_b: bool,
    two_dimensional_form: Vec<String>,
    three_dimensional: Availability,
    two_dimensional: Availability,
    orientation_at_a: OrientationRule,
    orientation_at_b: OrientationRule,
    rows: &'static str,
    signs: &'static str,
    remarks: Vec<&'static str>,
    sources: Vec<&'static str>,
    evidence: Vec<Tag>,
    /// Empty where a formula cannot be traced.
    formulas: Vec<Group>,
}

/// A criterion of predefined friction, Φ = P − μ |F_C + F_C^int| ≤ 0.
#[derive(Debug, Serialize)]
struct Criterion {
    tangential: String,
    contact: String,
    /// What stands in place of μ |F_C + F_C^int|, where that is a law of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    limit: Option<&'static str>,
    output: &'static str,
    /// P and F_C in two dimensions, where the type can be used there.
    two_dimensional: Option<[String; 2]>,
}

fn criteria(friction: &Friction, is_planar: bool) -> Vec<Criterion> {
    let formulas = |criterion: &pintle_kinematics::catalog::FrictionCriterion, present| {
        [criterion.tangential_formula(friction, present), criterion.contact_formula(friction, present)]
    };
    friction
        .criteria
        .iter()
        .map(|criterion| {
            let [tangential, contact] = formulas(criterion, SPATIAL);
            Criterion {
                tangential,
                contact,
                limit: criterion.limit_formula(),
                output: criterion.output,
                two_dimensional: is_planar.then(|| formulas(criterion, PLANE)),
            }
        })
        .collect()
}

/// A field of the manual's summary table.
#[derive(Debug, Serialize)]
pub(super) struct Field {
    pub(super) name: &'static str,
    pub(super) value: String,
}

/// What a tag such as `[S]` says.
#[derive(Debug, Serialize)]
pub(super) struct Tag {
    tag: Evidence,
    meaning: &'static str,
}

impl Tag {
    /// Every tag that pages use.
    pub(super) fn all() -> Vec<Self> {
        [Evidence::S, Evidence::D, Evidence::P, Evidence::R]
            .map(|tag| Self { tag, meaning: tag.meaning() })
            .into()
    }

    /// Writes what tags say, below a page.
    pub(super) fn write(tags: &[Self], out: &mut dyn Write, width: usize) -> io::Result<()> {
        writeln!(out)?;
        let tags: Vec<String> =
            tags.iter().map(|Self { tag, meaning }| format!("[{tag:?}] {meaning}")).collect();
        layout::paragraph(out, DIM, 0, &tags.join(" · "), width)?;
        Ok(())
    }
}

/// One component of relative motion.
#[derive(Debug, Serialize)]
struct Component {
    name: &'static str,
    role: &'static str,
    force: Option<&'static str>,
    position: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    stable: Option<&'static str>,
    unit: Unit,
    constraint: Option<String>,
    otherwise: Option<String>,
    winds: bool,
    one_form: bool,
    nodal_rates: bool,
    singular: Vec<Singular>,
}

/// Where a component or a derivative of it does not exist, or only its formula fails.
#[derive(Debug, Serialize)]
struct Singular {
    of: &'static str,
    #[serde(flatten)]
    set: SingularSet,
}

impl Explanation {
    /// Everything that the catalogue knows about a type.
    pub fn of(connection: &ConnectionType) -> Self {
        let [at_a, at_b] = connection.orientation;
        let some =
            |list: &[&'static str]| list.iter().copied().filter(|text| !text.is_empty()).collect::<Vec<_>>();
        Self {
            schema: SCHEMA,
            version: pintle_kinematics::VERSION,
            name: connection.name.to_string(),
            class: connection.class,
            made_of: words::made_of(connection),
            summary: summary(connection),
            notation: NOTATION,
            components: (0..6).filter_map(|k| component(connection, k)).collect(),
            forces: some(&connection.forces),
            friction: connection
                .friction
                .map(|friction| criteria(&friction, connection.planar != Availability::Never))
                .unwrap_or_default(),
            rotations_at_a: connection.rotations[0],
            rotations_at_b: connection.rotations[1],
            two_dimensional_form: two_dimensional(connection),
            three_dimensional: connection.availability,
            two_dimensional: connection.planar,
            orientation_at_a: at_a,
            orientation_at_b: at_b,
            rows: ROWS,
            signs: SIGNS,
            remarks: some(&connection.notes),
            sources: some(&connection.source),
            evidence: Tag::all(),
            formulas: formulas::groups(connection).unwrap_or_default(),
        }
    }

    /// Writes the explanation as JSON.
    ///
    /// # Errors
    /// Those of the stream.
    pub fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, self)?;
        writeln!(out)
    }

    /// Writes the explanation as text.
    ///
    /// # Errors
    /// Those of the stream.
    pub fn human(&self, out: &mut dyn Write, width: usize) -> io::Result<()> {
        writeln!(out, "{}", styled(BOLD, &self.name))?;
        let column = 41;
        for Field { name, value } in &self.summary {
            write!(out, "{}", layout::labelled(name, INDENT, column, value, width))?;
        }
        writeln!(out, "\n{}", styled(BOLD, "Components"))?;
        self.write_components(out, width)?;
        let paragraph =
            |out: &mut dyn Write, title: &str, texts: &[&str]| paragraph(out, title, texts, width);
        paragraph(out, "Forces and moments", &self.forces)?;
        paragraph(out, "Rotations of the nodes", &[rotations([self.rotations_at_a, self.rotations_at_b])])?;
        let form: Vec<&str> = self.two_dimensional_form.iter().map(String::as_str).collect();
        paragraph(out, "Two-dimensional and axisymmetric (CONN2D2)", &form)?;
        paragraph(out, "Signs", &[self.signs])?;
        paragraph(out, "Rows of derivatives", &[self.rows])?;
        formulas::human(&self.formulas, out, width)?;
        paragraph(out, "Remarks", &self.remarks)?;
        paragraph(out, "Sources", &self.sources)?;
        Tag::write(&self.evidence, out, width)
    }

    fn write_components(&self, out: &mut dyn Write, width: usize) -> io::Result<()> {
        let (start, column) = (7, 20);
        let line = |out: &mut dyn Write, label: &str, text: &str| {
            write!(out, "{}", layout::labelled(label, start, column, text, width))
        };
        layout::paragraph(out, DIM, 2, NOTATION, width)?;
        for component in &self.components {
            let unit = words::unit(component.unit);
            let force = component.force.map(|force| format!(", conjugate to {force}")).unwrap_or_default();
            let head = layout::labelled(
                component.name,
                2,
                start,
                &format!("{}, {}{force}", component.role, bracket(unit)),
                width,
            );
            write!(out, "{head}")?;
            line(out, "position", component.position)?;
            if let Some(stable) = component.stable {
                line(out, "", &format!("{stable}, keeps the digits that this one loses next to α = π"))?;
            }
            if let Some(constraint) = &component.constraint {
                line(out, "enforced", constraint)?;
            }
            if let Some(otherwise) = &component.otherwise {
                line(out, "", otherwise)?;
            }
            if component.winds {
                line(out, "period", "2π; whole turns are counted from state to state")?;
            }
            if component.one_form {
                line(
                    out,
                    "one-form",
                    "only its rate is a function of the state: the value accumulates from state to state, by the direction halfway",
                )?;
            }
            if component.nodal_rates {
                line(out, "rates", "nodal rates resolved in b, not time derivatives of the position")?;
            }
            for Singular { of, set } in &component.singular {
                let (class, meaning) = words::singular_class(set.class);
                let distance = format!("distance {} {}", set.distance, bracket(words::unit(set.unit)));
                line(out, "singular", &format!("{of}, at {}: {class}, {meaning}; {distance}", set.at))?;
            }
            if component.singular.is_empty() {
                line(out, "singular", "nowhere")?;
            }
        }
        Ok(())
    }
}

/// Writes what the code of a diagnostic means.
///
/// # Errors
/// Those of the stream.
pub fn code(out: &mut dyn Write, code: Code, width: usize) -> io::Result<()> {
    writeln!(out, "{}", styled(BOLD, code))?;
    write!(out, "{}", layout::labelled("", 2, 2, code.explanation(), width))?;
    write!(out, "{}", layout::labelled("", 2, 2, severity_help(code), width))
}

/// Writes what the code of a diagnostic means, as JSON.
///
/// # Errors
/// Those of the stream.
pub fn code_json(out: &mut dyn Write, code: Code) -> io::Result<()> {
    let document = serde_json::json!({
        "schema": SCHEMA, "version": pintle_kinematics::VERSION, "code": code.as_str(), "explanation": code.explanation(),
        "severity": (!code.names_a_cause()).then(|| code.severity()), "severity_help": severity_help(code),
    });
    serde_json::to_writer_pretty(&mut *out, &document)?;
    writeln!(out)
}

/// What can be done about the severity of a code, in a sentence.
fn severity_help(code: Code) -> &'static str {
    const SET: &str =
        "pintle audit takes it for what --allow, --note, --warn and --deny say, of this code or its group.";
    match (code.severity(), code.group()) {
        _ if code.names_a_cause() => {
            "It names the cause of a number that is wrong, and a wrong number fails the audit whatever its cause: --allow, --note, --warn and --deny \
             do not apply to it."
        }
        (Severity::Note | Severity::Warning, _) => SET,
        (Severity::Error, "rule") if code.leaves_numbers() => {
            "The scene is refused, but every number of it is defined: pintle audit goes on where --allow, --note or --warn say so, of this code \
             or its group."
        }
        (Severity::Error, "rule") => {
            "It leaves no connector, or no constraint, that numbers could be said of: what breaks it cannot be evaluated, and its severity stays \
             that of an error, whatever --allow, --note and --warn say."
        }
        (Severity::Error, _) => {
            "What has it is not read, or not evaluated, so that there is nothing to audit: no level that --allow, --note, --warn and --deny set \
             applies to it."
        }
    }
}

/// Writes texts under a title; nothing where there are none.
pub(super) fn paragraph(out: &mut dyn Write, title: &str, texts: &[&str], width: usize) -> io::Result<()> {
    if texts.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n{}", styled(BOLD, title))?;
    for text in texts {
        write!(out, "{}", layout::labelled("", INDENT, INDENT, text, width))?;
    }
    Ok(())
}

fn bracket(unit: &str) -> String {
    format!("[{unit}]")
}

fn tagged(text: &str, evidence: Evidence) -> String {
    format!("{text} [{evidence:?}]")
}

/// The manual's summary table: its fields in its order.
fn summary(connection: &ConnectionType) -> Vec<Field> {
    let mut fields = Vec::new();
    let mut field = |name, value| fields.push(Field { name, value });
    let rule = |rule: OrientationRule| tagged(words::orientation(rule.orientation), rule.evidence);
    field("Basic, assembled, or complex", words::class(connection).to_string());
    field("Kinematic constraints", connection.constraint_list());
    field("Constraint force and moment output", connection.force_list(Slot::is_constrained));
    field("Available components", connection.component_list(Slot::is_available));
    let measured = names(connection, is_measured);
    if !measured.is_empty() {
        field("Components for output only", measured.join(", "));
    }
    field("Kinetic force and moment output", connection.force_list(Slot::is_available));
    field("Orientation at a", rule(connection.orientation[0]));
    field("Orientation at b", rule(connection.orientation[1]));
    field("Connector stops", connection.stop_list());
    field("Constitutive reference lengths, angles", connection.reference_list());
    let none = || "none".to_string();
    field(
        "Predefined friction parameters",
        connection.friction.map_or_else(none, |friction| {
            let group = |required: bool| {
                let symbols: Vec<&str> =
                    friction.parameters.iter().filter(|p| p.required == required).map(|p| p.symbol).collect();
                let word = if required { "required" } else { "optional" };
                (!symbols.is_empty()).then(|| format!("{word}: {}", symbols.join(", ")))
            };
            let groups: Vec<String> = [group(true), group(false)].into_iter().flatten().collect();
            if groups.is_empty() { none() } else { tagged(&groups.join("; "), friction.evidence) }
        }),
    );
    field(
        "Contact force for predefined friction",
        connection.friction.map_or_else(none, |friction| {
            let all: Vec<String> = criteria(&friction, connection.planar != Availability::Never)
                .into_iter()
                .map(|criterion| {
                    let Criterion { tangential, contact, limit, output, two_dimensional } = criterion;
                    let limit = limit.map(|limit| format!(", limit {limit}")).unwrap_or_default();
                    let plane = match two_dimensional {
                        Some([p, c]) if p != tangential || c != contact => {
                            format!("; in two dimensions F_C = {c}, against P = {p}")
                        }
                        _ => String::new(),
                    };
                    format!("F_C = {contact}{limit}, against P = {tangential} ({output}){plane}")
                })
                .collect();
            let constants = friction
                .constants
                .iter()
                .map(|constant| format!("; {} = {}, {}", constant.symbol, constant.value, constant.meaning));
            let unused =
                friction.unused_parameters().map(|symbol| format!("; {symbol} is read and not used"));
            let notes: String = constants.chain(unused).collect();
            tagged(&format!("{}{notes}", all.join("; ")), friction.evidence)
        }),
    );
    field(
        "Abaqus/Standard, Abaqus/Explicit",
        match connection.availability {
            Availability::Always => "both",
            Availability::ExplicitOnly => "Explicit only",
            Availability::StandardOnly => "Standard only",
            Availability::Never => "neither",
        }
        .to_string(),
    );
    fields
}

fn component(connection: &ConnectionType, k: usize) -> Option<Component> {
    let slot = connection.slots[k];
    let position = slot.position()?;
    let symbol = position.symbol();
    let otherwise = matches!(slot, Slot::Constrained(_, Condition::ZeroOrHeld(_)))
        .then(|| format!("{symbol} = {symbol}0 where it does not hold initially"));
    let measures = [("position", position)].into_iter().chain(slot.printed().map(|m| ("constraint", m)));
    let singular = measures
        .flat_map(|(of, measure)| {
            let sets = measure.singular_sets().chain(measure.removable_sets().iter().copied());
            sets.map(move |set| Singular { of, set })
        })
        .collect();
    Some(Component {
        name: COMPONENT[k],
        role: words::role(slot),
        force: (!matches!(slot, Slot::Measured(_))).then_some(FORCE[k]),
        position: position.formula(),
        stable: position.stable_formula(),
        unit: position.unit(),
        constraint: connection.constraint(k),
        otherwise,
        winds: position.winds(),
        one_form: position.is_one_form(),
        nodal_rates: position.has_nodal_rates(),
        singular,
    })
}

/// Which nodes the type gives rotations.
const fn rotations(given: [bool; 2]) -> &'static str {
    match given {
        [true, true] => "a and b get rotational degrees of freedom",
        [true, false] => {
            "a gets rotational degrees of freedom; those of b count only where something else gives them to it"
        }
        [false, true] => {
            "b gets rotational degrees of freedom; those of a count only where something else gives them to it"
        }
        [false, false] => {
            "none are given: without rotations from elsewhere directions stay fixed, and no moment acts"
        }
    }
}

/// What is left in the plane: components u1, u2 and ur3, what they enforce, and what the plane asks for.
fn two_dimensional(connection: &ConnectionType) -> Vec<String> {
    let solver = match connection.planar {
        Availability::Never => return vec!["not available".to_string()],
        Availability::StandardOnly => " (Abaqus/Standard only)",
        Availability::ExplicitOnly => " (Abaqus/Explicit only)",
        Availability::Always => "",
    };
    let form = connection.in_plane();
    let kept: Vec<String> = (0..6)
        .filter(|k| PLANE[*k])
        .filter(|k| connection.slots[*k] != Slot::Absent)
        .map(|k| format!("{} {}", COMPONENT[k], words::role(connection.slots[k])))
        .collect();
    let dropped: Vec<String> = [2, 3, 4]
        .into_iter()
        .filter(|k| connection.slots[*k] != Slot::Absent)
        .map(|k| format!("{} = {}", COMPONENT[k], FORCE[k]))
        .collect();
    let kept = if kept.is_empty() { "no component".to_string() } else { kept.join(", ") };
    let dropped = if dropped.is_empty() { String::new() } else { format!("; {} = 0", dropped.join(" = ")) };
    let mut texts = vec![format!("{kept}{dropped}{solver}")];
    let enforced: Vec<String> = (0..6).filter_map(|k| form.constraint(k)).collect();
    texts.push(match enforced.len() {
        0 => "no constraint".to_string(),
        1 => format!("1 constraint: {}", enforced.join(", ")),
        count => format!("{count} constraints: {}", enforced.join(", ")),
    });
    let measures = || form.slots.iter().filter_map(|slot| slot.position());
    if measures().any(Measure::counts_torsion) {
        texts.push(
            "e1 and e2 halve the angle between those of a and b, which is counted on past ±π.".to_string(),
        );
    }
    if connection.slots[2].position() == Some(Measure::Flow(1)) {
        texts.push("Ψa is read at the node, as its degree of freedom 10.".to_string());
    }
    if measures().any(|measure| measure.turns_with_a()) {
        texts.push(
            "e3 of every orientation is ±z, the same at a and b; with e3 = −z, ur3 is minus the rotation of b against a from 1 to 2."
                .to_string(),
        );
    }
    texts.push(
        "In an axisymmetric model 1 is the radius and 2 the axis; the formulas are the same.".to_string(),
    );
    texts
}
