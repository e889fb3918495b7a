//! What is said on stderr.

use crate::cli::page_width;
use pintle_scene::Diagnostic;
use std::io::{self, Write};

/// Shows a diagnostic, and the others of its file that it carries, on stderr with their source lines.
pub(crate) fn show_diagnostic(diagnostic: &Diagnostic) {
    for one in std::iter::once(diagnostic).chain(diagnostic.further()) {
        let text = one.render(page_width(&io::stderr()), true);
        _ = writeln!(anstream::stderr(), "{}", text.trim_end());
    }
    if diagnostic.unsaid() > 0 {
        let count = diagnostic.unsaid();
        let text = format!("{count} more error{} not shown", if count == 1 { " is" } else { "s are" });
        complain("note", &text);
    }
}

/// A line on stderr.
pub(crate) fn complain(kind: &str, text: &str) {
    let style = anstyle::Style::new().bold();
    _ = writeln!(anstream::stderr(), "{style}{kind}:{style:#} {text}");
}
