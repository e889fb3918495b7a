//! Reports of an audit: each shows what was found, and no text of the input becomes markup.

use crate::audit::spoiled;
use pintle::audit::{Quantity, Report, Settings, audit_catalogue};
use pintle::report::audit as report;

/// A name that is markup in every form that a report has.
const HOSTILE: &str = "a|b <script>alert(1)</script> & *x* `y`";

/// A report with a wrong entry, on a connector with a hostile name.
pub(crate) fn wrong() -> Report {
    let mut report = spoiled("REVOLUTE", |_, rows| rows[3].as_mut().unwrap()[10] = 0.0);
    report.subjects[0].name = HOSTILE.to_string();
    report
}

/// A brief audit of the catalogue.
pub(crate) fn brief() -> Report {
    let settings = Settings { states: 10, near_singular_states: 4, wide_states: 1, ..Settings::default() };
    audit_catalogue(&settings, &|_| {})
}

fn text(write: impl Fn(&mut dyn std::io::Write, &Report) -> std::io::Result<()>, report: &Report) -> String {
    let mut text = Vec::new();
    write(&mut text, report).unwrap();
    String::from_utf8(text).unwrap()
}

#[test]
fn markdown_names_what_is_wrong() {
    let page = text(report::markdown, &wrong());
    assert!(page.starts_with("## ❌ pintle audit: 1 mismatch\n"), "{page}");
    assert!(page.contains("∂ur1/∂θb1 is `0e0`, must be `"), "{page}");
    assert!(!page.contains("<script>") && page.contains("a\\|b &lt;script&gt;"), "{page}");
    // Every row of a table has as many cells as its heading.
    let wide = 7 + Quantity::ALL.len();
    let cells = |line: &str| line.replace("\\|", "").matches('|').count();
    let rows: Vec<usize> = page.lines().filter(|line| line.starts_with('|')).map(cells).collect();
    assert!(rows.iter().filter(|n| **n == wide).count() >= 3, "{rows:?}");
    assert!(rows.iter().all(|n| [7, wide].contains(n)), "{rows:?}");
}

#[test]
fn markdown_of_a_clean_audit() {
    let report = brief();
    let page = text(report::markdown, &report);
    assert!(page.starts_with("## ✅ pintle audit: no mismatch"), "{page}");
    for subject in &report.subjects {
        assert!(page.contains(&format!("| {} | pass |", subject.name)), "{page}");
    }
    assert!(page.contains("<details>") && page.contains("</details>"));
}
