//! The audit as GitHub-flavoured Markdown: a summary for a comment on a change.

use crate::audit::groups;
use crate::audit::groups::{Fault, Findings};
use crate::audit::summary::{
    AuditOutcome, LEGEND, PAGE_UNREAD, SubjectRow, against_tolerance, headline, left_out, outcome, samples,
    self_test, sides, symbols, undecided,
};
use pintle_audit::model::{Finding, ModelReport};
use pintle_audit::{Report, Subject};
use pintle_scene::grammar::count;
use std::io::{self, Write};

/// Rows of a table that are shown at once; a longer table is folded.
const AT_ONCE: usize = 12;

/// Characters that a comment on GitHub may have.
pub const LIMIT: usize = 65_536;

/// What the notes about what was left out may take in all.
const NOTES: usize = 1_000;

/// Writes the audit as Markdown: the headline, what is wrong, findings in models, those with errors first, what else did not plainly
/// pass, then a line per connector. All text of the input is
/// escaped. What would make it longer than [`LIMIT`] is left out, and that is said.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn markdown(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let footer = footer(report);
    let mut page = Page { text: String::new(), left: LIMIT - NOTES };
    page.left = page.left.saturating_sub(footer.chars().count());
    page.add(&head(report));
    let (wrong, mild) = items(report);
    page.add_section("What is wrong", &wrong);
    models(&mut page, report);
    page.add_section("What needs a look", &mild);
    table(&mut page, report);
    out.write_all(page.text.as_bytes())?;
    writeln!(out, "{footer}")
}

/// The text, and how many characters it may still get.
struct Page {
    text: String,
    left: usize,
}

impl Page {
    /// Adds a line, whatever its length; lines that belong to each other are one text.
    fn add(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
        self.left = self.left.saturating_sub(line.chars().count() + 1);
    }

    /// Adds lines, each with what it is about, as far as they fit; the number that did not.
    fn add_fitting(&mut self, lines: &[String]) -> usize {
        for (n, line) in lines.iter().enumerate() {
            if line.chars().count() + 1 > self.left {
                self.left = 0;
                return lines.len() - n;
            }
            self.add(line);
        }
        0
    }

    /// Adds items under a heading, and says how many did not fit.
    fn add_section(&mut self, heading: &str, items: &[String]) {
        if items.is_empty() {
            return;
        }
        self.add(&format!("\n### {heading}\n"));
        let left_out = self.add_fitting(items);
        self.note(left_out, "item");
    }

    /// Says what was left out.
    fn note(&mut self, left_out: usize, what: &str) {
        if left_out > 0 {
            let more = count(left_out, what);
            self.text.push_str(&format!(
                "\n*{more} left out here, where a comment has room for {LIMIT} characters.*\n"
            ));
        }
    }
}

fn head(report: &Report) -> String {
    let mark = match outcome(report) {
        AuditOutcome::Failed => "❌",
        AuditOutcome::Undecided => "❔",
        AuditOutcome::Warned => "⚠️",
        AuditOutcome::Clean => "✅",
    };
    let test = self_test(report);
    format!(
        "## {mark} pintle audit: {}\n\n\
         | audited | numbers compared | mismatches | undecided | warnings | mutants noticed | survived |\n\
         |---:|---:|---:|---:|---:|---:|---:|\n\
         | {} | {} | {} | {} | {} | {} of {} | {} |",
        escaped(&headline(report)),
        report.subjects.len(),
        report.compared(),
        report.mismatches(),
        report.undecided(),
        report.warnings(),
        test.noticed,
        test.decisive,
        report.survivors()
    )
}

fn footer(report: &Report) -> String {
    let names: Vec<&str> = report.settings.oracles.iter().map(|oracle| oracle.name()).collect();
    format!(
        "\npintle {}; tolerance C·u·(conditioned scale), C = {}; oracles: {}",
        report.version,
        report.constant,
        names.join(", ")
    )
}

/// What is wrong, and what else did not plainly pass, an item each.
fn items(report: &Report) -> (Vec<String>, Vec<String>) {
    let (mut wrong, mut mild) = (Vec::new(), Vec::new());
    for fault in groups::faults(report) {
        if fault.is_mild() { &mut mild } else { &mut wrong }.push(item(&fault));
    }
    for approach in report.atlas.iter().filter(|approach| !approach.is_confirmed()) {
        wrong.push(format!(
            "- **{}** {} at {}: {}",
            escaped(&approach.connection),
            approach.component,
            escaped(approach.at),
            approach.told()
        ));
    }
    mild.extend(samples(report).map(|text| format!("- {}", escaped(&text))));
    for (text, names) in left_out(report) {
        let names: Vec<String> = names.into_iter().map(escaped).collect();
        mild.push(format!("- **{}**: {text}", names.join(", ")));
    }
    (wrong, mild)
}

fn item(fault: &Fault<'_>) -> String {
    let check = fault.check;
    let of = check.quantity.map_or_else(String::new, |quantity| format!("{} against ", quantity.name()));
    let mut line = format!(
        "- **{}**, {of}{}: {}",
        escaped(&fault.title()),
        check.against.name(),
        check.verdict.headline().name()
    );
    if let Some(worst) = check.worst.as_ref().filter(|_| check.verdict.is_mismatch()) {
        let state = check.worst_state.as_deref().unwrap_or("");
        line += &format!("; {}, at {}", escaped(&against_tolerance(worst)), escaped(state));
    }
    let told: Vec<String> = sides(check).collect();
    if let (false, Some(worst)) = (told.is_empty(), &check.worst) {
        line += &format!("; {}: {}", escaped(&worst.entry), escaped(&told.join("; ")));
    }
    for why in undecided(check) {
        line += &format!("; {}", escaped(&why));
    }
    for (sentence, code) in check.diagnosis.iter().flat_map(|diagnosis| diagnosis.lines()) {
        line += &format!("; **{}** `{code}`", escaped(&sentence));
    }
    for (mistake, entry) in &check.score.survivors {
        line += &format!("; survived: {} ({})", escaped(mistake), escaped(entry));
    }
    match fault.witnesses() {
        told if told.is_empty() => line,
        told => format!("{line}; {}", escaped(&told)),
    }
}

fn table(page: &mut Page, report: &Report) {
    if report.subjects.is_empty() {
        return;
    }
    let folded = report.subjects.len() > AT_ONCE;
    page.add("");
    if folded {
        let all = count(report.subjects.len(), "subject");
        page.add(&format!("<details><summary>Verdicts on {all}</summary>\n"));
    }
    let symbols = symbols();
    let heading = format!(
        "| connector | derivative | formula | declaration | states | independent | {} | δ seen |\n|---|---|---|---|---:|---:|{}---:|",
        symbols.join(" | "),
        "---:|".repeat(symbols.len())
    );
    page.add(&heading);
    let row = |subject: &Subject| {
        let row = SubjectRow::of(subject);
        let worst = row.worst.map(|units| units.map_or("–".into(), |units| format!("{units:.2}")));
        let seen = row.seen.map_or("–".into(), |delta| format!("{delta:.0e}"));
        let mut verdicts = row.verdicts.map(|verdict| {
            let name = verdict.headline().name();
            if verdict.is_mismatch() { format!("**{name}**") } else { name.to_string() }
        });
        if row.is_page_unread {
            verdicts[2] = PAGE_UNREAD.to_string();
        }
        format!(
            "| {} | {} | {} | {} | {} | {seen} |",
            escaped(&subject.title()),
            verdicts.join(" | "),
            row.states,
            row.independent,
            worst.join(" | ")
        )
    };
    // What did not pass comes first where not all of them have room.
    let mut subjects: Vec<&Subject> = report.subjects.iter().collect();
    let rows =
        |subjects: &[&Subject]| -> Vec<String> { subjects.iter().map(|subject| row(subject)).collect() };
    let mut lines = rows(&subjects);
    if lines.iter().map(|line| line.chars().count() + 1).sum::<usize>() > page.left {
        subjects.sort_by_key(|subject| std::cmp::Reverse(subject.verdict()));
        lines = rows(&subjects);
    }
    let left_out = page.add_fitting(&lines);
    page.note(left_out, "subject");
    page.text.push_str(&format!("\n{LEGEND}.\n"));
    if folded {
        page.text.push_str("\n</details>\n");
    }
}

/// A text that is shown as it is: what Markdown or HTML would read is escaped, and a line break is a blank.
fn escaped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => result.push_str("&amp;"),
            '<' => result.push_str("&lt;"),
            '>' => result.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '(' | ')' | '#' | '|' | '~' | '!' | '@' | '$' => {
                result.push('\\');
                result.push(c);
            }
            c if c.is_control() => result.push(' '),
            c => result.push(c),
        }
    }
    result
}

/// What is found in models: a line each, models with errors first, and errors first in each.
fn models(page: &mut Page, report: &Report) {
    let (mut findings_left_out, mut models_left_out) = (0, 0);
    let mut models: Vec<&ModelReport> = report.models.iter().collect();
    models.sort_by_key(|model| !model.fails());
    for model in models {
        let title = format!("\n### {}: {}\n", escaped(&model.scene), crate::audit::model::headline(model));
        let mut findings: Vec<&Finding> = model.findings.iter().collect();
        findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity()));
        let lines: Vec<String> = groups::findings(findings).iter().map(line).collect();
        let untitled = page.add_fitting(&[title]);
        models_left_out += untitled;
        findings_left_out += if untitled == 0 { page.add_fitting(&lines) } else { lines.len() };
    }
    page.note(models_left_out, "model");
    page.note(findings_left_out, "finding");
}

fn line(group: &Findings<'_>) -> String {
    let finding = group.first;
    let line = format!(
        "- **{}** `{}` {}: {}",
        crate::audit::model::word(finding.severity()),
        finding.code(),
        escaped(&crate::audit::model::place(finding)),
        escaped(finding.message())
    );
    let line = match group.others() {
        others if others.is_empty() => line,
        others => format!("{line}; {}", escaped(&others)),
    };
    match finding.remedy() {
        "" => line,
        remedy => format!("{line}; *help:* {}", escaped(remedy)),
    }
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn text_of_the_input_cannot_become_markup() {
        assert_eq!(escaped("A|B\n<b>*x*</b>"), "A\\|B &lt;b&gt;\\*x\\*&lt;/b&gt;");
        assert_eq!(escaped("∂ur1/∂θa1 [link](x)"), "∂ur1/∂θa1 \\[link\\]\\(x\\)");
    }
}
