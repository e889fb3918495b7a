//! The audit as GitHub-flavoured Markdown: a summary for a comment on a change.

use super::summary::{LEGEND, Row, detectable, headline, self_test, symbols, telling};
use crate::audit::{Check, Report, Subject};
use std::io::{self, Write};

/// Rows of a table that are shown at once; a longer table is folded.
const AT_ONCE: usize = 12;

/// Writes the audit as Markdown: the headline, what is wrong, then a line per connector. All text of the input is escaped.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn markdown(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let mark = if report.mismatches() > 0 || report.survivors() > 0 || report.failing_models() > 0 {
        "❌"
    } else {
        "✅"
    };
    writeln!(out, "## {mark} pintle audit: {}\n", escaped(&headline(report)))?;
    writeln!(out, "| audited | numbers compared | mismatches | undecided | mutants noticed | survived |")?;
    writeln!(out, "|---:|---:|---:|---:|---:|---:|")?;
    let test = self_test(report);
    writeln!(
        out,
        "| {} | {} | {} | {} | {} of {} | {} |",
        report.subjects.len(),
        report.compared(),
        report.mismatches(),
        report.undecided(),
        test.noticed,
        test.decisive,
        report.survivors()
    )?;
    wrong(out, report)?;
    table(out, report)?;
    models(out, report)?;
    let names: Vec<&str> = report.settings.oracles.iter().map(|oracle| oracle.name()).collect();
    writeln!(
        out,
        "\npintle {}; tolerance C·u·(conditioned scale), C = {}; oracles: {}",
        report.version,
        report.constant,
        names.join(", ")
    )
}

/// What did not plainly pass, an item each.
fn wrong(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let unconfirmed = report.atlas.iter().filter(|approach| !approach.is_confirmed());
    let mut lines: Vec<String> = Vec::new();
    for subject in &report.subjects {
        lines.extend(telling(subject).map(|check| item(subject, check)));
    }
    for approach in unconfirmed {
        let seen = approach.seen.map_or("none of the classes".into(), |class| format!("{class:?}"));
        lines.push(format!(
            "- **{}** {} at {}: declared {:?}, seen {seen}",
            escaped(&approach.connection),
            approach.component,
            escaped(approach.at),
            approach.declared
        ));
    }
    if lines.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n### What needs a look\n")?;
    lines.iter().try_for_each(|line| writeln!(out, "{line}"))
}

fn item(subject: &Subject, check: &Check) -> String {
    let of = check.quantity.map_or_else(String::new, |quantity| format!("{} against ", quantity.name()));
    let mut line = format!(
        "- **{}**, {of}{}: {}",
        escaped(&subject.title()),
        check.against.name(),
        check.verdict.headline().name()
    );
    if let Some(worst) = check.worst.as_ref().filter(|_| check.verdict.is_mismatch()) {
        let state = check.worst_state.as_deref().unwrap_or("");
        line += &format!(
            "; {} is `{:e}`, must be `{:e}`: {:.3e} tolerances, at {}",
            escaped(&worst.entry),
            worst.got,
            worst.want,
            worst.units,
            escaped(state)
        );
    }
    for (sentence, code) in check.diagnosis.iter().flat_map(|diagnosis| diagnosis.lines()) {
        line += &format!("; **{}** `{code}`", escaped(&sentence));
    }
    for (mistake, entry) in &check.score.survivors {
        line += &format!("; survived: {} ({})", escaped(mistake), escaped(entry));
    }
    line
}

fn table(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    if report.subjects.is_empty() {
        return Ok(());
    }
    let folded = report.subjects.len() > AT_ONCE;
    writeln!(out)?;
    if folded {
        writeln!(out, "<details><summary>All {} connectors and types</summary>\n", report.subjects.len())?;
    }
    let symbols = symbols();
    writeln!(
        out,
        "| connector | derivative | formula | declaration | states | {} | δ seen |",
        symbols.join(" | ")
    )?;
    writeln!(out, "|---|---|---|---|---:|{}---:|", "---:|".repeat(symbols.len()))?;
    for subject in &report.subjects {
        let row = Row::of(subject);
        let worst: Vec<String> =
            row.worst.iter().map(|units| units.map_or("–".into(), |units| format!("{units:.2}"))).collect();
        let seen = detectable(subject).map_or("–".into(), |delta| format!("{delta:.0e}"));
        let verdicts = row.verdicts.map(|verdict| {
            let name = verdict.headline().name();
            if verdict.is_mismatch() { format!("**{name}**") } else { name.to_string() }
        });
        writeln!(
            out,
            "| {} | {} | {} | {} | {seen} |",
            escaped(&subject.title()),
            verdicts.join(" | "),
            row.states,
            worst.join(" | ")
        )?;
    }
    writeln!(out, "\n{LEGEND}.")?;
    if folded {
        writeln!(out, "\n</details>")?;
    }
    Ok(())
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

/// What is found in models: a line each.
fn models(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    for model in &report.models {
        writeln!(out, "\n### {}: {}\n", escaped(&model.scene), super::model::headline(model))?;
        for finding in &model.findings {
            writeln!(
                out,
                "- **{}** `{}` {}: {}",
                super::model::word(finding.severity()),
                finding.code(),
                escaped(&super::model::place(finding)),
                escaped(finding.message())
            )?;
        }
    }
    Ok(())
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
