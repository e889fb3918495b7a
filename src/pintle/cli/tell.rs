//! What is said on stderr.

use super::page_width;
use pintle_scene::Diagnostic;
use std::io::{self, Write};

/// Shows a diagnostic on stderr with its source line.
pub(crate) fn show_diagnostic(diagnostic: &Diagnostic) {
    let text = diagnostic.render(page_width(&io::stderr()), true);
    _ = writeln!(anstream::stderr(), "{}", text.trim_end());
}

/// A line on stderr.
pub(crate) fn complain(kind: &str, text: &str) {
    let style = anstyle::Style::new().bold();
    _ = writeln!(anstream::stderr(), "{style}{kind}:{style:#} {text}");
}
