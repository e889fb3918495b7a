//! What is said on stderr.

use crate::cli::page_width;
use pintle_scene::grammar::{agree, shape};
use pintle_scene::{Code, Diagnostic};
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

/// What is said of many things in the same words is shown once, and counted.
#[derive(Default)]
pub(crate) struct Once(Vec<(Code, String, usize)>);

impl Once {
    /// Shows a warning, with its lines, or counts it where the like was shown.
    pub(crate) fn show(&mut self, warning: Diagnostic, quoted: impl FnOnce(Diagnostic) -> Diagnostic) {
        let (warning, unsaid) = warning.without_unsaid();
        let (code, shape) = (warning.code(), shape(warning.message()));
        match self.0.iter_mut().find(|(known, like, _)| *known == code && *like == shape) {
            Some((.., more)) => *more += 1 + unsaid,
            None => {
                self.0.push((code, shape, unsaid));
                show_diagnostic(&quoted(warning));
            }
        }
    }

    /// Says how often each was said.
    pub(crate) fn count(self) {
        for (code, _, more) in self.0.into_iter().filter(|(.., more)| *more > 0) {
            complain("note", &format!("{code} {more} more {}", agree(more, ["time", "times"])));
        }
    }
}

/// A line on stderr.
pub(crate) fn complain(kind: &str, text: &str) {
    let style = anstyle::Style::new().bold();
    _ = writeln!(anstream::stderr(), "{style}{kind}:{style:#} {text}");
}
