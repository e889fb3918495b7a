//! The audit for reading: a line per connector, then what is wrong, then what the checks are worth.

use crate::audit::groups;
use crate::audit::summary::{
    AuditOutcome, LEGEND, PAGE_UNREAD, SubjectRow, against_tolerance, headline, outcome, samples,
    self_test as tested, sides, symbols, unconfirmed, undecided,
};
use crate::layout;
use crate::layout::{BOLD, CARE, DIM, PLAIN, left, styled, table};
use pintle_audit::{Against, Approach, Check, Compared, Comparison, Report, Verdict};
use pintle_scene::grammar::{agree, count};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Writes the audit for reading; `verbose` shows every check, not only those that say something.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn human(out: &mut dyn Write, report: &Report, width: usize, verbose: bool) -> io::Result<()> {
    if !report.subjects.is_empty() {
        numbers(out, report, width, verbose)?;
    }
    crate::audit::model::human(out, &report.models, width, verbose)?;
    verdict(out, report)
}

/// What was audited of numbers.
fn numbers(out: &mut dyn Write, report: &Report, width: usize, verbose: bool) -> io::Result<()> {
    let settings = &report.settings;
    writeln!(
        out,
        "{}",
        styled(
            BOLD,
            format!(
                "{} audited, {} compared; tolerance C·u·(conditioned scale) with C = {}",
                count(report.subjects.len(), "subject"),
                count(report.compared(), "number"),
                report.constant
            )
        )
    )?;
    let names: Vec<&str> = settings.oracles.iter().map(|oracle| oracle.name()).collect();
    layout::paragraph(out, PLAIN, 2, &format!("oracles: {}", names.join(", ")), width)?;
    for text in samples(report) {
        layout::paragraph(out, CARE, 2, &text, width)?;
    }
    writeln!(out)?;
    subjects(out, report, verbose)?;
    undecided_declarations(out, report, width)?;
    left_out(out, report, width)?;
    for subject in report.subjects.iter().filter(|_| verbose) {
        writeln!(out, "\n{}", styled(BOLD, subject.title()))?;
        for check in &subject.checks {
            self::check(out, check, width)?;
        }
    }
    let mut last = String::new();
    for fault in groups::faults(report).iter().filter(|_| !verbose) {
        let title = fault.title();
        if title != last {
            writeln!(out, "\n{}", styled(BOLD, &title))?;
        }
        last = title;
        check(out, fault.check, width)?;
        layout::paragraph(out, DIM, 4, &fault.witnesses(), width)?;
    }
    if report.lacks_counter_examples() {
        let text = "replay: --counter-examples FOLDER writes what is wrong as values; pintle replay FOLDER/FILE runs it again";
        writeln!(out)?;
        layout::paragraph(out, PLAIN, 0, text, width)?;
    }
    atlas(out, report)?;
    self_test(out, report)
}

pub(super) fn word(verdict: Verdict) -> String {
    let verdict = verdict.headline();
    if verdict.is_mismatch() { styled(CARE, verdict.name()) } else { verdict.name().to_string() }
}

/// Which declarations nobody confirms in full: once for each reason.
fn undecided_declarations(out: &mut dyn Write, report: &Report, width: usize) -> io::Result<()> {
    let mut reasons: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for subject in report.subjects.iter().filter(|subject| subject.declaration == Verdict::Undecided) {
        let page = unconfirmed(subject);
        let names = reasons.entry(page).or_default();
        if !names.contains(&subject.name.as_str()) {
            names.push(&subject.name);
        }
    }
    for (page, names) in reasons {
        let text = format!("{}: {page}", some_of(&names));
        layout::paragraph(out, DIM, 2, &text, width)?;
    }
    Ok(())
}

/// Which numbers no state exercises, and which laws were not asked: once for each list of them.
fn left_out(out: &mut dyn Write, report: &Report, width: usize) -> io::Result<()> {
    for (text, subjects) in crate::audit::summary::left_out(report) {
        layout::paragraph(out, DIM, 2, &format!("{}: {text}", some_of(&subjects)), width)?;
    }
    Ok(())
}

/// The first few names, and how many more there are.
fn some_of(names: &[&str]) -> String {
    const SHOWN: usize = 4;
    let more = names.len().saturating_sub(SHOWN);
    let mut text = names.iter().take(SHOWN).copied().collect::<Vec<_>>().join(", ");
    if more > 0 {
        text.push_str(&format!(" and {more} more"));
    }
    text
}

/// A table of the catalogue, and one of each scene.
fn subjects(out: &mut dyn Write, report: &Report, verbose: bool) -> io::Result<()> {
    let mut scenes: Vec<Option<&str>> = Vec::new();
    for subject in &report.subjects {
        if !scenes.contains(&subject.scene.as_deref()) {
            scenes.push(subject.scene.as_deref());
        }
    }
    for (i, scene) in scenes.iter().enumerate() {
        if let Some(scene) = scene {
            let gap = if i > 0 { "\n" } else { "" };
            writeln!(out, "{gap}{}", styled(BOLD, scene))?;
        }
        let of_it = report.subjects.iter().filter(|subject| subject.scene.as_deref() == *scene);
        let rows: Vec<SubjectRow> = of_it.map(SubjectRow::of).collect();
        let is_long = scene.is_some() && !verbose && rows.len() > ROWS;
        let rows = if is_long { SubjectRow::by_type(rows) } else { rows };
        let rows: Vec<Vec<String>> = rows.into_iter().map(cells).collect();
        let first = if scene.is_none() { "type" } else { "connector" };
        let mut heading = vec![first, "derivative", "formula", "declaration", "states", "independent"];
        heading.extend(symbols());
        heading.push("δ seen");
        write!(out, "{}", table(&heading, &rows))?;
    }
    writeln!(out, "{}", styled(DIM, LEGEND))
}

/// A scene with more connectors has a line for those of a type that came out alike; `-v` shows each.
const ROWS: usize = 40;

fn cells(row: SubjectRow) -> Vec<String> {
    let mut cells = vec![row.name];
    let [derivative, formula, declaration] = row.verdicts.map(word);
    cells.extend([
        derivative,
        formula,
        if row.is_page_unread { PAGE_UNREAD.to_string() } else { declaration },
    ]);
    cells.extend([row.states, row.independent].map(|states| states.to_string()));
    cells.extend(row.worst.map(|units| units.map_or_else(|| "–".into(), |units| format!("{units:.2}"))));
    cells.push(row.seen.map_or_else(|| "–".into(), |delta| format!("{delta:.0e}")));
    cells
}

pub(super) fn check(out: &mut dyn Write, check: &Check, width: usize) -> io::Result<()> {
    let of = check.quantity.map_or_else(String::new, |quantity| format!("{} against ", quantity.name()));
    let states: Vec<String> =
        check.states.iter().map(|(verdict, n)| format!("{} {n}", verdict.name())).collect();
    let seen = match (check.score.detectable_median, check.score.detectable) {
        (Some(median), Some(worst)) => format!("; δ seen {median:.0e}, at worst {worst:.0e}"),
        _ => String::new(),
    };
    writeln!(out, "  {of}{}: {} ({}){seen}", check.against.name(), word(check.verdict), states.join(", "))?;
    for why in undecided(check) {
        layout::paragraph(out, PLAIN, 4, &why, width)?;
    }
    let Some(worst) = &check.worst else { return Ok(()) };
    let state = check.worst_state.as_deref().unwrap_or("");
    let text = format!("{}, at {state}", against_tolerance(worst));
    layout::paragraph(out, PLAIN, 4, &text, width)?;
    for text in sides(check) {
        layout::paragraph(out, PLAIN, 4, &text, width)?;
    }
    for (sentence, code) in check.diagnosis.iter().flat_map(|diagnosis| diagnosis.lines()) {
        layout::paragraph(out, BOLD, 4, &format!("{sentence} [{code}]"), width)?;
    }
    for (mistake, entry) in &check.score.survivors {
        writeln!(out, "    {} {mistake} ({entry})", styled(CARE, "survived:"))?;
    }
    if let Some(comparison) = &check.comparison {
        diagram(out, comparison)?;
    }
    if let Some(file) = &check.counter_example {
        writeln!(out, "    replay: pintle replay {}", quoted(file))?;
    }
    Ok(())
}

/// A file's name as a shell takes it.
fn quoted(file: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/\\:._-+".contains(c);
    if file.chars().all(is_plain) { file.to_string() } else { format!("'{}'", file.replace('\'', "'\\''")) }
}

/// The Jacobian in its blocks: ✗ where an entry is beyond its tolerance, ■ where it is not zero, · where it is.
fn diagram(out: &mut dyn Write, comparison: &Comparison) -> io::Result<()> {
    let blocks = comparison.blocks();
    let names = comparison.rows.iter().map(|(name, _)| name.chars().count() + 1);
    let margin = names.max().unwrap_or(0);
    let line = |cell: &dyn Fn(usize) -> String| -> String {
        let of = |j: &usize| left(&cell(*j), comparison.columns[*j].chars().count());
        let block = |block: &Vec<usize>| block.iter().map(of).collect::<Vec<_>>().join(" ");
        blocks.iter().map(block).collect::<Vec<_>>().join(" │ ").trim_end().to_string()
    };
    writeln!(out, "    {} {}", left("", margin), line(&|j| comparison.columns[j].clone()))?;
    for (name, row) in &comparison.rows {
        let mark = |entry: &Compared| match () {
            () if entry.units > 1.0 => "✗",
            () if entry.is_zero() => "·",
            () => "■",
        };
        let cells = line(&|j| row.get(j).map_or("", mark).to_string());
        writeln!(out, "    {} {cells}", left(&format!("∂{name}"), margin))?;
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
        "\nsingular points: {confirmed} of {} approached to 1e-15 {} declared to be",
        count(report.atlas.len(), "declared set"),
        agree(report.atlas.len(), ["is what it is", "are what they are"])
    )?;
    let mut noticed: Vec<f64> =
        report.atlas.iter().flat_map(|approach| &approach.rungs).map(|rung| rung.detectable).collect();
    noticed.sort_by(f64::total_cmp);
    if let Some(median) = noticed.get(noticed.len() / 2) {
        writeln!(
            out,
            "  an error of {median:.0e} of the largest derivative would have been noticed, in the median of all distances"
        )?;
    }
    for approach in report.atlas.iter().filter(|approach| !approach.is_confirmed()) {
        let Approach { connection, component, at, .. } = approach;
        let text = format!("{connection} {component} at {at}: {}", approach.told());
        writeln!(out, "  {}", styled(CARE, text))?;
    }
    Ok(())
}

fn self_test(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let test = tested(report);
    writeln!(
        out,
        "\nself-test: {} of {} noticed by the oracles; {} changed nothing, {} less than twice the tolerance",
        test.noticed,
        count(test.decisive, "mutant"),
        test.equivalent,
        test.below_resolution
    )?;
    let mut laws: BTreeMap<&str, u64> = BTreeMap::new();
    for check in report.subjects.iter().flat_map(|subject| &subject.checks) {
        if let Against::Law(law) = check.against {
            *laws.entry(law.name()).or_default() += check.score.killed;
        }
    }
    for (law, killed) in laws {
        writeln!(out, "  {}  {} noticed", left(law, 32), count(killed, "mutant"))?;
    }
    for law in report.blind_laws() {
        let text = format!("{}: no mutant of what it speaks of was noticed", law.name());
        writeln!(out, "  {} {text}", styled(CARE, "survived:"))?;
    }
    Ok(())
}

fn verdict(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let is_clean = outcome(report) == AuditOutcome::Clean;
    let text = if is_clean { headline(report) } else { styled(CARE, headline(report)) };
    writeln!(out, "\n{}", styled(BOLD, text))
}
