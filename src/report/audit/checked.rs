//! Somebody's routine on one screen: what is right, what is wrong and why, how sure that is.

use crate::audit::human::{check, word};
use crate::audit::summary::{headline, is_sharp, self_test};
use crate::layout;
use crate::layout::{BOLD, CARE, DIM, styled, table, wrap};
use pintle_audit::{Check, Quantity, Report, Subject, Verdict};
use pintle_scene::grammar::count;
use std::io::{self, Write};

/// At most so many quantities are shown with what is wrong in them.
const SHOWN: usize = 2;

/// Writes the report of one routine in some 25 lines: a line a quantity, then the worst of what is wrong.
///
/// `notes` are sentences on what was not judged.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn checked(
    out: &mut dyn Write,
    report: &Report,
    of: &str,
    notes: &[String],
    width: usize,
) -> io::Result<()> {
    for subject in &report.subjects {
        let rows: Vec<Vec<String>> = Quantity::ALL
            .into_iter()
            .chain(Quantity::OF_BEHAVIOR)
            .filter_map(|quantity| row(subject, quantity))
            .collect();
        writeln!(out, "{}", styled(BOLD, format!("{} as {of}", subject.title())))?;
        write!(out, "{}", table(&["", "verdict", "error/tolerance", "δ seen", "states", "numbers"], &rows))?;
        let wrong: Vec<&Check> = Quantity::ALL
            .into_iter()
            .chain(Quantity::OF_BEHAVIOR)
            .filter_map(|quantity| worst_of(subject, quantity))
            .collect();
        for told in wrong.iter().take(SHOWN) {
            writeln!(out)?;
            check(out, told, width)?;
        }
        if wrong.len() > SHOWN {
            let others = wrong.iter().skip(SHOWN).filter_map(|check| check.quantity).map(Quantity::name);
            let others: Vec<&str> = others.collect();
            writeln!(out, "  wrong besides: {}", others.join(", "))?;
        }
        let open = subject.checks.iter().filter(|check| check.verdict == Verdict::Undecided);
        for why in open.flat_map(|check| check.undecided.keys()).take(1) {
            layout::paragraph(out, CARE, 2, &format!("undecided: {why}"), width)?;
        }
    }
    writeln!(out)?;
    for line in notes.iter().flat_map(|note| wrap(note, width)) {
        writeln!(out, "{}", styled(DIM, line))?;
    }
    let test = self_test(report);
    let noticed =
        format!("{} of {} planted in its numbers noticed", test.noticed, count(test.decisive, "mistake"));
    writeln!(out, "{} compared; {noticed}", count(report.compared(), "number"))?;
    let text = headline(report);
    writeln!(out, "{}", styled(BOLD, if report.mismatches() > 0 { styled(CARE, text) } else { text }))
}

/// What reports of the same routine as several connectors have in common where they say the same: type, quantities, verdicts, causes, notes.
pub fn likeness(report: &Report, of: &str, notes: &[String]) -> String {
    let of_check = |check: &Check| {
        let codes = check.diagnosis.iter().flat_map(|found| found.lines()).map(|(_, code)| code.as_str());
        let codes: Vec<&str> = codes.collect();
        format!("{:?} {:?} {}", check.quantity, check.verdict, codes.join(" "))
    };
    let checks = report.subjects.iter().flat_map(|subject| &subject.checks).map(of_check);
    let all: Vec<String> = checks.chain(notes.iter().cloned()).collect();
    format!("{of}\n{}", all.join("\n"))
}

fn of_quantity(subject: &Subject, quantity: Quantity) -> impl Iterator<Item = &Check> {
    subject.checks.iter().filter(move |check| check.quantity == Some(quantity))
}

/// What was found of a quantity: the severest verdict, the largest error, the smallest that would have been seen.
fn row(subject: &Subject, quantity: Quantity) -> Option<Vec<String>> {
    let severest = of_quantity(subject, quantity).map(|check| check.verdict).max()?;
    let largest = of_quantity(subject, quantity).map(|check| check.largest).fold(0.0, f64::max);
    let sharp = of_quantity(subject, quantity).filter(|check| is_sharp(check));
    let seen = sharp.filter_map(|check| check.score.detectable_median);
    let seen = seen.reduce(f64::max);
    let states: u64 = of_quantity(subject, quantity).map(Check::judged).max().unwrap_or(0);
    let numbers: u64 = of_quantity(subject, quantity).map(|check| check.compared).sum();
    let scaled = |x: f64| if x < 1000.0 { format!("{x:.2}") } else { format!("{x:.0e}") };
    Some(vec![
        quantity.name().to_string(),
        word(severest),
        scaled(largest),
        seen.map_or_else(|| "–".into(), |delta| format!("{delta:.0e}")),
        states.to_string(),
        numbers.to_string(),
    ])
}

/// The check of a quantity that says most of what is wrong with it: one with a cause before others.
fn worst_of(subject: &Subject, quantity: Quantity) -> Option<&Check> {
    let wrong = of_quantity(subject, quantity).filter(|check| check.verdict.is_mismatch());
    wrong.max_by_key(|check| {
        let causes = check.diagnosis.as_ref().map_or(0, |diagnosis| diagnosis.causes.len().min(1));
        (causes, is_sharp(check), check.comparison.is_some(), check.verdict)
    })
}
