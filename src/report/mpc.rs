//! `pintle explain MPC`: what the revolute-joint multi-point constraint is ([`crate::mpc`]).

use super::explain::{Field, INDENT, SCHEMA, Tag, paragraph};
use super::layout::{self, BOLD, styled};
use crate::measure::{SingularClass, SingularSet, Unit};
use crate::mpc::{CONSTRAINT, DOF};
use serde::Serialize;
use std::io::{self, Write};

const SUMMARY: [(&str, &str); 8] = [
    ("Nodes", "S (the first, dependent), M (the second), J (the third)"),
    ("Constraint", "C(φS) = C(φJ a) C(φM) [S]"),
    ("Axis", "a = C(φM) a0 [S]; a0 from M to J initially, global z if they coincide [D]"),
    ("Additional degree of freedom", "φJ, the relative rotation: degree of freedom 6 of J [S]"),
    ("Number of constraints", "3 with one more unknown: 2 net, 3 if φJ is prescribed [S]"),
    ("Angular velocity", "ωS = ωM + φ̇J a [S]"),
    ("Moments", "MS = −MM, MJ = −MS·a = MM·a [S]; not evaluated"),
    ("Abaqus/Standard, Abaqus/Explicit", "Standard [D]"),
];

const ROWS: &str = "A row is the gradient of one residual. Columns are the degrees of freedom 4–6 of S (θS1–θS3), 4–6 of M \
     (θM1–θM3) and 6 of J (φJ), global components. Rotations vary spatially, C → exp(δθ^) C, so that θ̇ is the angular \
     velocity. Where the constraint holds, δρ = δθS − δθM − a δφJ.";

const SIGNS: &str = "φJ is positive counter-clockwise about a, from M to S. ρ is the rotation that takes S from where M and φJ \
     have it to where it is. Moments are the total ones at their nodes, MJ that in the joint: MS·δφS + MM·δφM + MJ δφJ = 0.";

const REMARKS: [&str; 3] = [
    "In the residual and its rows, φJ is degree of freedom 6 of J where the states give it, and otherwise the angle that the \
     rotations of S and M imply; its rates in those of the residual are always those of J. The outputs CP, CU, CV and CA of φJ \
     are always those of the implied angle.",
    "Translations are not tied: add a PIN.",
    "C(φJ a) C(φM) = C(φM) C(φJ a0), which is what is computed.",
];

const SOURCES: [&str; 2] = [
    "seed Revolute joint, Eq. 1 and the text around it",
    "keyword *MPC, type REVOLUTE (initial axis, solver)",
];

/// A component of the constraint, or the three of the residual together.
#[derive(Debug, Serialize)]
struct Component {
    names: &'static [&'static str],
    role: &'static str,
    unit: Unit,
    formula: &'static str,
    constraint: Option<&'static str>,
    winds: bool,
    singular: SingularSet,
    /// What happens at the singular set.
    consequence: &'static str,
}

const COMPONENTS: [Component; 2] = [
    Component {
        names: &[DOF[6]],
        role: "available",
        unit: Unit::Angle,
        formula: "φJ = 2 atan2(v·a0, w), with (w, v) the quaternion of C(φM)ᵀ C(φS)",
        constraint: None,
        winds: true,
        singular: SingularSet {
            at: "S turned by π from M about a direction across the axis",
            class: SingularClass::TrueSingularity,
            distance: "|(w, v·a0)|",
            unit: Unit::None,
        },
        consequence: "true singularity, no angle about the axis is determined",
    },
    Component {
        names: &CONSTRAINT,
        role: "constrained",
        unit: Unit::Angle,
        formula: "ρ, the rotation vector of C(φS) [C(φJ a) C(φM)]ᵀ, global components [R]",
        constraint: Some("ρ = 0"),
        winds: false,
        singular: SingularSet {
            at: "S turned by π from where the constraint has it",
            class: SingularClass::BranchCut,
            distance: "π − |ρ|",
            unit: Unit::Angle,
        },
        consequence: "branch cut, the sign of ρ is not determined",
    },
];

/// The page as JSON.
#[derive(Serialize)]
struct Page {
    schema: &'static str,
    version: &'static str,
    name: &'static str,
    summary: Vec<Field>,
    components: [Component; 2],
    rows: &'static str,
    signs: &'static str,
    remarks: [&'static str; 3],
    sources: [&'static str; 2],
    evidence: Vec<Tag>,
}

const NAME: &str = "MPC REVOLUTE";

/// Writes the page as JSON.
///
/// # Errors
/// Those of the stream.
pub fn json(out: &mut dyn Write) -> io::Result<()> {
    let page = Page {
        schema: SCHEMA,
        version: crate::VERSION,
        name: NAME,
        summary: SUMMARY.map(|(name, value)| Field { name, value: value.to_string() }).into(),
        components: COMPONENTS,
        rows: ROWS,
        signs: SIGNS,
        remarks: REMARKS,
        sources: SOURCES,
        evidence: Tag::all(),
    };
    serde_json::to_writer_pretty(&mut *out, &page)?;
    writeln!(out)
}

/// Writes the page as text.
///
/// # Errors
/// Those of the stream.
pub fn human(out: &mut dyn Write, width: usize) -> io::Result<()> {
    writeln!(out, "{}", styled(BOLD, NAME))?;
    for (name, value) in SUMMARY {
        write!(out, "{}", layout::labelled(name, INDENT, 36, value, width))?;
    }
    writeln!(out, "\n{}", styled(BOLD, "Components"))?;
    let line = |out: &mut dyn Write, label: &str, text: &str| {
        write!(out, "{}", layout::labelled(label, 7, 20, text, width))
    };
    for component in COMPONENTS {
        let names = component.names.join(", ");
        writeln!(out, "  {names}  {}, [rad]", component.role)?;
        line(out, "formula", component.formula)?;
        if let Some(constraint) = component.constraint {
            line(out, "enforced", constraint)?;
        }
        if component.winds {
            line(out, "period", "2π; whole turns are counted from state to state")?;
        }
        let SingularSet { at, distance, unit, .. } = component.singular;
        let unit = super::words::unit(unit);
        line(out, "singular", &format!("at {at}: {}; distance {distance} [{unit}]", component.consequence))?;
    }
    paragraph(out, "Signs", &[SIGNS], width)?;
    paragraph(out, "Rows of derivatives", &[ROWS], width)?;
    paragraph(out, "Remarks", &REMARKS, width)?;
    paragraph(out, "Sources", &SOURCES, width)?;
    Tag::write(&Tag::all(), out, width)
}
