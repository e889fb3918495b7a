//! What is found in the models of an audit, for reading: findings, the assembly, coverage.

use crate::audit::groups;
use crate::layout;
use crate::layout::{BOLD, CARE, DIM, PLAIN, styled};
use pintle_assembly::{Assembly, Position};
use pintle_audit::model::{Finding, ModelReport, Nearest};
use pintle_audit::sampling::coverage::Histogram;
use pintle_kinematics::measure::Unit;
use pintle_scene::Severity;
use pintle_scene::grammar::number as short;
use pintle_scene::grammar::{count, ranges};
use std::io::{self, Write};

/// Writes every model: its findings, then what its assembly can do, then what its states exercised.
pub(super) fn human(
    out: &mut dyn Write,
    models: &[ModelReport],
    width: usize,
    verbose: bool,
) -> io::Result<()> {
    for model in models {
        writeln!(out, "\n{}", styled(BOLD, format!("model {}: {}", model.scene, headline(model))))?;
        for found in model.findings.iter().filter(|_| verbose) {
            finding(out, found, "", width)?;
        }
        for group in groups::findings(&model.findings).iter().filter(|_| !verbose) {
            finding(out, group.first, &group.others(), width)?;
        }
        for assembled in model.assembly.iter().chain(&model.later_steps) {
            assembly(out, assembled, width)?;
        }
        coverage(out, model, width)?;
        if let Some(nearest) = &model.nearest {
            layout::paragraph(out, PLAIN, 2, &self::nearest(nearest), width)?;
        }
    }
    Ok(())
}

/// The nearest singular set, in words.
pub(super) fn nearest(nearest: &Nearest) -> String {
    let Nearest { element, component, at, distance, unit, state } = nearest;
    let unit = if *unit == Unit::Angle { " rad" } else { "" };
    let when = state.map_or_else(|| "initially".to_string(), |state| format!("at state {state}"));
    format!(
        "nearest singular point: {component} of element {element} is {distance}{unit} from {at}, {when}",
        distance = short(*distance, 4)
    )
}

/// The number of findings, in words.
pub(super) fn headline(model: &ModelReport) -> String {
    let counted = [Severity::Error, Severity::Warning, Severity::Note].map(|severity| model.count(severity));
    let words: Vec<String> = counted
        .into_iter()
        .zip(["error", "warning", "note"])
        .filter(|(n, _)| *n > 0)
        .map(|(n, noun)| count(n, noun))
        .collect();
    if words.is_empty() { "nothing found".to_string() } else { words.join(", ") }
}

/// `file:line`, as far as it is known.
pub(super) fn place(finding: &Finding) -> String {
    finding.line().map_or_else(|| finding.file().to_string(), |line| format!("{}:{line}", finding.file()))
}

/// The name of a severity.
pub(super) const fn word(severity: Severity) -> &'static str {
    match severity {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    }
}

fn finding(out: &mut dyn Write, finding: &Finding, others: &str, width: usize) -> io::Result<()> {
    let severity = finding.severity();
    let head = format!("{}[{}]", word(severity), finding.code());
    let head = if severity == Severity::Note { head } else { styled(CARE, head) };
    writeln!(out, "  {head} {}", styled(DIM, place(finding)))?;
    layout::paragraph(out, PLAIN, 4, finding.message(), width)?;
    if !others.is_empty() {
        layout::paragraph(out, PLAIN, 4, others, width)?;
    }
    if !finding.reason().is_empty() {
        layout::paragraph(out, PLAIN, 4, &format!("why: {}", finding.reason()), width)?;
    }
    if !finding.remedy().is_empty() {
        layout::paragraph(out, PLAIN, 4, &format!("help: {}", finding.remedy()), width)?;
    }
    Ok(())
}

fn assembly(out: &mut dyn Write, assembly: &Assembly, width: usize) -> io::Result<()> {
    let of_step = match assembly.step {
        0 => "before the first step".to_string(),
        step => format!("with the boundary conditions of step {step}"),
    };
    let counted = format!(
        "assembly, {of_step}: {} of connectors and MPCs, {} held; {}, {}; mobility by Grübler {}.",
        count(assembly.degrees_of_freedom, "degree of freedom"),
        assembly.held,
        count(assembly.constraints, "constraint"),
        count(assembly.drives, "drive"),
        assembly.gruebler,
    );
    let Some(first) = assembly.positions.first() else {
        let text = format!("{counted} Its rank was not found.");
        return layout::paragraph(out, PLAIN, 2, &text, width);
    };
    let text = format!(
        "{counted} Rank {}: {} redundant, mobility {}, of which nothing drives {}. {}",
        number(first.rank),
        number(first.redundant),
        number(first.mobility),
        number(first.undriven),
        gap(assembly, first)
    );
    layout::paragraph(out, PLAIN, 2, &text, width)?;
    for line in besides(assembly) {
        layout::paragraph(out, PLAIN, 2, &line, width)?;
    }
    Ok(())
}

/// What is not as initially at the states given, and what was not looked at, in words.
pub(super) fn besides(assembly: &Assembly) -> Vec<String> {
    let mut lines = Vec::new();
    if !assembly.skipped.is_empty() {
        lines.push(format!(
            "{} of {} not looked at, for elimination would take too much memory or time",
            assembly.skipped.len(),
            count(assembly.connected_components, "connected component")
        ));
    }
    if assembly.unnamed > 0 {
        let constraints = count(assembly.unnamed, "redundant constraint");
        lines.push(format!("{constraints} counted and not named"));
    }
    lines.extend(along(assembly));
    if !assembly.unread.is_empty() {
        let kinds: Vec<&str> = assembly.unread.iter().map(|kind| kind.what.as_str()).collect();
        lines.push(format!("constraints that were not read: {}", kinds.join(", ")));
    }
    if !assembly.off.is_empty() {
        let states = count(assembly.off.len(), "state");
        lines.push(format!("{states} not looked at, for not satisfying the constraints"));
    }
    if !assembly.off_boundary.is_empty() {
        let states = count(assembly.off_boundary.len(), "state");
        lines.push(format!("{states} not looked at, for moving what boundary conditions hold"));
    }
    lines
}

/// A number, where it is known.
pub(super) fn number(known: Option<usize>) -> String {
    known.map_or_else(|| "not known".to_string(), |number| number.to_string())
}

/// Which of the states given has which rank and motions.
fn along(assembly: &Assembly) -> Vec<String> {
    /// What is not the same at given states is told in so many lines.
    const LINES: usize = 12;
    type Numbers = (Option<usize>, Option<usize>, Option<usize>, bool);
    let mut sets: Vec<(Numbers, Vec<u64>)> = Vec::new();
    for position in assembly.positions.iter().skip(1) {
        let Some(state) = position.state else { continue };
        let numbers = (position.rank, position.mobility, position.undriven, position.decided);
        match sets.iter_mut().find(|(other, _)| *other == numbers) {
            Some((_, states)) => states.push(state),
            None => sets.push((numbers, vec![state])),
        }
    }
    let told = |((rank, mobility, undriven, decided), states): &(Numbers, Vec<u64>)| {
        let certain = if *decided { "" } else { " (undecided)" };
        format!(
            "at {}: rank {}{certain}, mobility {}, of which nothing drives {}",
            ranges("state", states),
            number(*rank),
            number(*mobility),
            number(*undriven)
        )
    };
    let mut lines: Vec<String> = sets.iter().take(LINES).map(told).collect();
    if let Some(more) = sets.len().checked_sub(LINES).filter(|more| *more > 0) {
        lines.push(format!("and {} of ranks, in JSON", count(more, "other set")));
    }
    lines
}

/// How certain a rank is.
pub(super) fn gap(assembly: &Assembly, position: &Position) -> String {
    if position.rank.is_none() {
        return "The rank is not known, for a part was not looked at.".to_string();
    }
    let what = if assembly.unread.is_empty() { "rank" } else { "rank of what was read" };
    let certainty = format!("The {what} is {}", if position.decided { "certain" } else { "undecided" });
    match position.gap.singular_values {
        Some([nonzero, zero]) => {
            format!(
                "{certainty}: between singular values of {nonzero} and {zero} of the largest.",
                nonzero = short(nonzero, 2),
                zero = short(zero, 2)
            )
        }
        None if position.gap.nonzero.is_infinite() => format!("{certainty}."),
        None => format!(
            "{certainty}: numbers that a relative change of {} makes zero count as zero, the next needs {}.",
            short(position.gap.zero, 2),
            short(position.gap.nonzero, 2)
        ),
    }
}

fn coverage(out: &mut dyn Write, model: &ModelReport, width: usize) -> io::Result<()> {
    let coverage = &model.coverage;
    if coverage.exercise.is_empty() {
        return Ok(());
    }
    let largest = |histogram: &Histogram| {
        if histogram.samples() == 0 { "none".to_string() } else { format!("{:.3} rad", histogram.largest) }
    };
    let text = format!(
        "coverage: {}{}{}; largest rotations: a {}, b {}, b relative to a {}; both nodes turned in {} of {}, free components displaced in \
         {} of {}",
        count(coverage.exercise.samples, "connector state"),
        if model.drawn { ", drawn about the initial one" } else { "" },
        match coverage.exercise.standing {
            0 => String::new(),
            standing => format!(", and {standing} whose nodes stand still"),
        },
        largest(&coverage.rotation_a),
        largest(&coverage.rotation_b),
        largest(&coverage.relative_rotation),
        coverage.exercise.both_turned,
        coverage.exercise.could_turn_both,
        coverage.exercise.deformed,
        coverage.exercise.could_deform
    );
    layout::paragraph(out, PLAIN, 2, &text, width)
}
