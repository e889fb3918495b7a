//! `pintle explain MPC` and `pintle explain MPC TYPE`: which multi-point constraints there are, and what each of them is
//! ([`pintle_kinematics::mpc`]).

use crate::explain::{Field, INDENT, SCHEMA, Tag, paragraph};
use crate::layout;
use crate::layout::{BOLD, PLAIN, styled};
use pintle_kinematics::measure::{SingularClass, SingularSet, Unit};
use pintle_kinematics::mpc::{MpcType, ROWS, TABLE, Translation};
use serde::Serialize;
use std::io::{self, Write};

const COLUMNS: &str = "A row is the gradient of one residual. Columns are the degrees of freedom of S, of M and, for hinges, \
     degree of freedom 6 of their nodes, global components. Rotations vary spatially, C → exp(δθ^) C, so that θ̇ is the \
     angular velocity. Where the constraint holds,";

const SIGNS: &str = "Residuals are what S is beyond where M and the hinges have it. Forces and moments are the total ones that the \
     constraint puts on its nodes, Jᵀλ with one multiplier λ for each residual; they do no work on motions that the constraint \
     allows. Angles of hinges are positive counter-clockwise about their axis, from M to S.";

/// An angle of a hinge, or residuals that belong together.
#[derive(Debug, Serialize)]
struct Component {
    names: Vec<&'static str>,
    role: &'static str,
    unit: Unit,
    formula: &'static str,
    constraint: Option<String>,
    winds: bool,
    singular: Option<SingularSet>,
    /// What happens at the singular set.
    consequence: Option<&'static str>,
}

/// The angles and residuals of a kind.
fn components(kind: MpcType) -> Vec<Component> {
    let entry = kind.entry();
    let mut found = Vec::new();
    if !entry.angles.is_empty() {
        let formula = if entry.angles.len() == 1 {
            "φJ = 2 atan2(v·a0, w), with (w, v) the quaternion of C(φM)ᵀ C(φS)"
        } else {
            "φ1, φ2 of C(φM)ᵀ C(φS) = C(φ1 a10) C(β n) C(φ2 a20), n along a20 × a10: φ1 = atan2(−n·v, (a10 × n)·v), \
             v = C(φM)ᵀ C(φS) a20; φ2 = atan2(−n·w, (n × a20)·w), w = C(φS)ᵀ C(φM) a10 [R]; Cardan angles if a10 ⊥ a20"
        };
        let singular = kind.angle_set();
        found.push(Component {
            names: entry.angles.to_vec(),
            role: "available",
            unit: Unit::Angle,
            formula,
            constraint: None,
            winds: true,
            singular,
            consequence: Some(if entry.angles.len() == 1 {
                "true singularity, no angle about the axis is determined"
            } else {
                "true singularity, only the sum or difference of the angles is determined"
            }),
        });
    }
    let groups: [(&[usize], &'static str); 3] = [
        (
            &[0, 1, 2],
            match entry.translation {
                Translation::Free => "",
                Translation::Equal => "δ = uS − uM, global components",
                Translation::Distance => "δl = |xS − xM| − |XS − XM|",
                Translation::Carried => "δ = xS − xM − C(φM) (XS − XM), global components",
            },
        ),
        (
            &[3, 4, 5],
            match entry.angles.len() {
                0 => "ρ, the rotation vector of C(φS) C(φM)ᵀ, global components [R]",
                1 => "ρ, the rotation vector of C(φS) [C(φJ a) C(φM)]ᵀ, global components [R]",
                _ => "ρ, the rotation vector of C(φS) [C(φ2 a2) C(φ1 a1) C(φM)]ᵀ, global components [R]",
            },
        ),
        (&[6], "δΨ = ΨS − ΨM, where both nodes have material flow"),
    ];
    let rows: [bool; ROWS] = kind.rows(true);
    for (group, formula) in groups {
        let names: Vec<_> = group.iter().filter(|row| rows[**row]).map(|row| kind.row_name(*row)).collect();
        let Some(first) = group.first().filter(|_| !names.is_empty()) else { continue };
        let whole = names.first().map(|name| name.trim_end_matches('1')).unwrap_or_default();
        let singular = kind.row_set(*first);
        let consequence = singular.map(|set| match set.class {
            SingularClass::BranchCut => "branch cut, the sign of ρ is not determined",
            _ => "kink, the link has no direction",
        });
        found.push(Component {
            constraint: Some(format!("{whole} = 0")),
            names,
            role: "constrained",
            unit: MpcType::row_unit(*first),
            formula,
            winds: false,
            singular,
            consequence,
        });
    }
    found
}

/// The page of a kind as JSON.
#[derive(Serialize)]
struct Page {
    schema: &'static str,
    version: &'static str,
    name: String,
    summary: Vec<Field>,
    components: Vec<Component>,
    rows: String,
    signs: &'static str,
    remarks: &'static [&'static str],
    sources: &'static [&'static str],
    evidence: Vec<Tag>,
}

/// Every kind as JSON.
#[derive(Serialize)]
struct Overview {
    schema: &'static str,
    version: &'static str,
    name: &'static str,
    types: Vec<Listed>,
}

/// A kind in a list.
#[derive(Debug, Serialize)]
pub(super) struct Listed {
    name: &'static str,
    nodes: &'static [&'static str],
    residuals: Vec<&'static str>,
    available: &'static [&'static str],
    constraint: &'static str,
}

impl Listed {
    /// Every kind.
    pub(super) fn all() -> Vec<Self> {
        let listed = |kind: MpcType| {
            let entry = kind.entry();
            let rows = kind.rows(true);
            let fact = entry.facts.iter().find(|(name, _)| *name == "Constraint");
            Self {
                name: entry.name,
                nodes: entry.nodes,
                residuals: (0..ROWS).filter(|row| rows[*row]).map(|row| kind.row_name(row)).collect(),
                available: entry.angles,
                constraint: fact.map_or("", |(_, constraint)| *constraint),
            }
        };
        TABLE.iter().map(|entry| listed(entry.kind)).collect()
    }

    /// Every kind, as a table.
    pub(super) fn table() -> String {
        let dash = |list: &[&str]| if list.is_empty() { "–".to_string() } else { list.join(" ") };
        let rows: Vec<Vec<String>> = Self::all()
            .into_iter()
            .map(|Self { name, nodes, residuals, available, .. }| {
                vec![name.to_string(), nodes.join(" "), dash(&residuals), dash(available)]
            })
            .collect();
        layout::table(&["MPC", "nodes", "constrained", "available"], &rows)
    }
}

fn rows(kind: MpcType) -> String {
    format!("{COLUMNS} {}", kind.entry().rows)
}

/// Writes the page of a kind, or of all together, as JSON.
///
/// # Errors
/// Those of the stream.
pub fn json(out: &mut dyn Write, kind: Option<MpcType>) -> io::Result<()> {
    match kind {
        Some(kind) => {
            let entry = kind.entry();
            let field = |(name, value): &(&'static str, &str)| Field { name, value: (*value).to_string() };
            let page = Page {
                schema: SCHEMA,
                version: pintle_kinematics::VERSION,
                name: format!("MPC {}", entry.name),
                summary: entry.facts.iter().map(field).collect(),
                components: components(kind),
                rows: rows(kind),
                signs: SIGNS,
                remarks: entry.remarks,
                sources: entry.sources,
                evidence: Tag::all(),
            };
            serde_json::to_writer_pretty(&mut *out, &page)?;
        }
        None => {
            let (schema, version) = (SCHEMA, pintle_kinematics::VERSION);
            let overview = Overview { schema, version, name: "MPC", types: Listed::all() };
            serde_json::to_writer_pretty(&mut *out, &overview)?;
        }
    }
    writeln!(out)
}

/// Writes the page of a kind, or of all together, as text.
///
/// # Errors
/// Those of the stream.
pub fn human(out: &mut dyn Write, kind: Option<MpcType>, width: usize) -> io::Result<()> {
    match kind {
        Some(kind) => page(out, kind, width),
        None => overview(out, width),
    }
}

fn overview(out: &mut dyn Write, width: usize) -> io::Result<()> {
    writeln!(out, "{}", styled(BOLD, "MPC, multi-point constraints"))?;
    for Listed { name, constraint, .. } in Listed::all() {
        write!(out, "{}", layout::labelled(name, INDENT, 13, constraint, width))?;
    }
    writeln!(out)?;
    let more = "S is the first node of an MPC, which it makes dependent, M the second; nodes of hinges follow. \
                `pintle explain MPC TYPE` says more.";
    layout::paragraph(out, PLAIN, 0, more, width)?;
    Tag::write(&Tag::all(), out, width)
}

fn page(out: &mut dyn Write, kind: MpcType, width: usize) -> io::Result<()> {
    let entry = kind.entry();
    writeln!(out, "{}", styled(BOLD, format!("MPC {}", entry.name)))?;
    for (name, value) in entry.facts {
        write!(out, "{}", layout::labelled(name, INDENT, 36, value, width))?;
    }
    writeln!(out, "\n{}", styled(BOLD, "Components"))?;
    let line = |out: &mut dyn Write, label: &str, text: &str| {
        write!(out, "{}", layout::labelled(label, 7, 20, text, width))
    };
    for component in components(kind) {
        let (names, unit) = (component.names.join(", "), crate::words::unit(component.unit));
        writeln!(out, "  {names}  {}, [{unit}]", component.role)?;
        line(out, "formula", component.formula)?;
        if let Some(constraint) = &component.constraint {
            line(out, "enforced", constraint)?;
        }
        if component.winds {
            line(out, "period", "2π; whole turns are counted from state to state")?;
        }
        if let (Some(SingularSet { at, distance, unit, .. }), Some(consequence)) =
            (component.singular, component.consequence)
        {
            let unit = crate::words::unit(unit);
            line(out, "singular", &format!("at {at}: {consequence}; distance {distance} [{unit}]"))?;
        }
    }
    paragraph(out, "Signs", &[SIGNS], width)?;
    paragraph(out, "Rows of derivatives", &[&rows(kind)], width)?;
    paragraph(out, "Remarks", entry.remarks, width)?;
    paragraph(out, "Sources", entry.sources, width)?;
    Tag::write(&Tag::all(), out, width)
}
