//! The audit for reading: a line per connector, then what is wrong, then what the checks are worth.

use super::super::layout::{BOLD, CARE, DIM, left, styled, table, wrap};
use crate::audit::{Against, Check, Quantity, Report, Subject, Verdict};
use crate::catalog::COMPONENT;
use crate::node::{DOF, DOFS};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Writes the audit for reading; `verbose` shows every check, not only those that say something.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn human(out: &mut dyn Write, report: &Report, width: usize, verbose: bool) -> io::Result<()> {
    let settings = &report.settings;
    writeln!(
        out,
        "{}",
        styled(
            BOLD,
            format!(
                "{} audited, {} numbers compared; tolerance C·u·(conditioned scale) with C = {}",
                count(report.subjects.len(), "subject"),
                report.compared(),
                report.constant
            )
        )
    )?;
    let names: Vec<&str> = settings.oracles.iter().map(|oracle| oracle.name()).collect();
    for line in wrap(&format!("oracles: {}", names.join(", ")), width.saturating_sub(2)) {
        writeln!(out, "  {line}")?;
    }
    writeln!(out)?;
    subjects(out, report)?;
    undecided_declarations(out, report, width)?;
    for subject in &report.subjects {
        let telling = subject
            .checks
            .iter()
            .filter(|check| verbose || check.verdict > Verdict::IllConditioned || check.score.survived > 0);
        let mut first = true;
        for check in telling {
            if std::mem::take(&mut first) {
                writeln!(out, "\n{}", styled(BOLD, title(subject)))?;
            }
            self::check(out, check, width)?;
        }
    }
    atlas(out, report)?;
    self_test(out, report)?;
    verdict(out, report)
}

fn count(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

fn word(verdict: Verdict) -> String {
    let verdict = verdict.headline();
    if verdict.is_mismatch() { styled(CARE, verdict.name()) } else { verdict.name().to_string() }
}

/// The worst error of the sharp oracles in units of the tolerance.
fn worst(subject: &Subject, quantity: Quantity) -> String {
    let of_it = subject.checks.iter().filter(|check| check.quantity == Some(quantity) && is_sharp(check));
    let units = of_it
        .map(|check| check.largest)
        .fold(None, |most: Option<f64>, x| Some(most.map_or(x, |most| most.max(x))));
    units.map_or_else(|| "–".into(), |units| format!("{units:.2}"))
}

const fn is_sharp(check: &Check) -> bool {
    matches!(check.against, Against::Oracle(oracle) if oracle.is_independent())
}

/// The name, with the scene that it is of.
fn title(subject: &Subject) -> String {
    match &subject.scene {
        Some(scene) => format!("{} of {scene}", subject.name),
        None => subject.name.clone(),
    }
}

/// Why declarations are undecided: once for each reason.
fn undecided_declarations(out: &mut dyn Write, report: &Report, width: usize) -> io::Result<()> {
    let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for subject in report.subjects.iter().filter(|subject| subject.declaration == Verdict::Undecided) {
        let page = subject.certificate.as_ref().map_or("never typed a second time", |c| &c.manual_page);
        let names = reasons.entry(page).or_default();
        if !names.contains(&subject.name.as_str()) {
            names.push(&subject.name);
        }
    }
    for (page, names) in reasons {
        const SHOWN: usize = 4;
        let more = names.len().saturating_sub(SHOWN);
        let mut text = names.iter().take(SHOWN).copied().collect::<Vec<_>>().join(", ");
        if more > 0 {
            text.push_str(&format!(" and {more} more"));
        }
        for line in wrap(&format!("{text}: declaration undecided: {page}"), width.saturating_sub(2)) {
            writeln!(out, "  {}", styled(DIM, line))?;
        }
    }
    Ok(())
}

/// A table of the catalogue, and one of each scene.
fn subjects(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let mut scenes: Vec<Option<&str>> = Vec::new();
    for subject in &report.subjects {
        if !scenes.contains(&subject.scene.as_deref()) {
            scenes.push(subject.scene.as_deref());
        }
    }
    for (i, scene) in scenes.iter().enumerate() {
        let heading = if scene.is_none() { "type" } else { "connector" };
        if let Some(scene) = scene {
            let gap = if i > 0 { "\n" } else { "" };
            writeln!(out, "{gap}{}", styled(BOLD, scene))?;
        }
        let rows: Vec<Vec<String>> =
            report.subjects.iter().filter(|subject| subject.scene.as_deref() == *scene).map(cells).collect();
        let heading =
            [heading, "derivative", "formula", "declaration", "states", "f", "∂f", "∂²f", "ḟ", "f̈", "δ seen"];
        write!(out, "{}", table(&heading, &rows))?;
    }
    writeln!(
        out,
        "{}",
        styled(
            DIM,
            "f … f̈: worst error in units of its tolerance; δ seen: the smallest relative error of an entry that the check notices, median"
        )
    )
}

fn cells(subject: &Subject) -> Vec<String> {
    let detectable = subject
        .checks
        .iter()
        .filter(|check| check.quantity == Some(Quantity::FirstDerivatives) && is_sharp(check))
        .map(|check| check.score.detectable_median)
        .fold(0.0, f64::max);
    let mut row = vec![
        subject.name.clone(),
        word(subject.derivative),
        word(subject.formula),
        word(subject.declaration),
        subject.cases.to_string(),
    ];
    row.extend(Quantity::ALL.map(|quantity| worst(subject, quantity)));
    row.push(if detectable > 0.0 { format!("{detectable:.0e}") } else { "–".into() });
    row
}

fn check(out: &mut dyn Write, check: &Check, width: usize) -> io::Result<()> {
    let of = check.quantity.map_or_else(String::new, |quantity| format!("{} against ", quantity.name()));
    let states: Vec<String> =
        check.states.iter().map(|(verdict, n)| format!("{} {n}", verdict.name())).collect();
    writeln!(out, "  {of}{}: {} ({})", check.against.name(), word(check.verdict), states.join(", "))?;
    let Some(worst) = &check.worst else { return Ok(()) };
    let state = check.worst_state.as_deref().unwrap_or("");
    let text = format!(
        "{}: {:.17e}, must be {:.17e}, tolerance {:.2e}: {:.3e} tolerances, at {state}",
        worst.entry, worst.got, worst.want, worst.tolerance, worst.units
    );
    for line in wrap(&text, width.saturating_sub(4)) {
        writeln!(out, "    {line}")?;
    }
    if let Some([below, above]) = worst.one_sided {
        writeln!(out, "    from below {below:.10e}, from above {above:.10e}")?;
    }
    for (mistake, entry) in &check.score.survivors {
        writeln!(out, "    {} {mistake} ({entry})", styled(CARE, "survived:"))?;
    }
    if check.verdict == Verdict::Wrong && check.quantity == Some(Quantity::FirstDerivatives) {
        diagram(out, check)?;
    }
    Ok(())
}

/// The blocks of the Jacobian, with the wrong entry marked.
fn diagram(out: &mut dyn Write, check: &Check) -> io::Result<()> {
    let Some((k, j)) = check.worst.as_ref().and_then(|worst| worst.at) else { return Ok(()) };
    let widths = DOF.map(|name| name.chars().count());
    let heading: Vec<String> = DOF.iter().map(|name| (*name).to_string()).collect();
    writeln!(out, "         {}", heading.join(" "))?;
    for (row, component) in COMPONENT.iter().enumerate() {
        let cells: Vec<String> = (0..DOFS)
            .map(|column| {
                let mark = if (row, column) == (k, j) { "✗" } else { "·" };
                left(mark, widths[column])
            })
            .collect();
        writeln!(out, "    ∂{} {}", left(component, 3), cells.join(" ").trim_end())?;
    }
    Ok(())
}

fn atlas(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    if report.atlas.is_empty() {
        return Ok(());
    }
    let confirmed = report.atlas.iter().filter(|approach| approach.is_confirmed()).count();
    writeln!(
        out,
        "\nsingular points: {confirmed} of {} declared sets approached to 1e-15 are what they are declared to be",
        report.atlas.len()
    )?;
    for approach in report.atlas.iter().filter(|approach| !approach.is_confirmed()) {
        let seen = approach.seen.map_or("none of the classes".into(), |class| format!("{class:?}"));
        let text = format!(
            "{} {} at {}: declared {:?}, seen {seen}",
            approach.connection, approach.component, approach.at, approach.declared
        );
        writeln!(out, "  {}", styled(CARE, text))?;
    }
    Ok(())
}

fn self_test(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let checks = || report.subjects.iter().flat_map(|subject| &subject.checks);
    let by_oracle = || checks().filter(|check| matches!(check.against, Against::Oracle(_)));
    let sum = |of: fn(&Check) -> u64| by_oracle().map(of).sum::<u64>();
    let (killed, decisive) = (sum(|c| c.score.killed), sum(|c| c.score.decisive()));
    writeln!(
        out,
        "\nself-test: {killed} of {decisive} mutants noticed by the oracles; {} changed nothing, {} less than twice the tolerance",
        sum(|c| c.score.equivalent),
        sum(|c| c.score.below_resolution)
    )?;
    let mut laws: BTreeMap<&str, u64> = BTreeMap::new();
    for check in checks() {
        if let Against::Law(law) = check.against {
            *laws.entry(law.name()).or_default() += check.score.killed;
        }
    }
    for (law, killed) in laws {
        writeln!(out, "  {}  {killed} mutants noticed", left(law, 32))?;
    }
    Ok(())
}

fn verdict(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let (mismatches, undecided, survivors) = (report.mismatches(), report.undecided(), report.survivors());
    let text = match (survivors, mismatches, undecided) {
        (1.., ..) => styled(CARE, format!("self-test failed: {survivors} mutants survived")),
        (0, 1.., _) => styled(CARE, count(mismatches, "mismatch").replace("mismatchs", "mismatches")),
        (0, 0, 1..) => format!("no mismatch; {} undecided", count(undecided, "subject")),
        _ => "no mismatch".to_string(),
    };
    writeln!(out, "\n{}", styled(BOLD, text))
}
