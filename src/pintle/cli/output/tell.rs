//! What is said on stderr.

use crate::cli::page_width;
use pintle_scene::grammar::{agree, shape};
use pintle_scene::{Code, Diagnostic, Severity};
use std::io::{self, Write};

/// Shows a diagnostic, and the others of its file that it carries, on stderr with their source lines: what is alike once, with a count.
pub(crate) fn show_diagnostic(diagnostic: &Diagnostic) {
    let mut once = Once::default();
    let (all, unsaid) = diagnostic.clone().without_unsaid();
    for one in std::iter::once(&all).chain(all.further()) {
        once.show(one.clone(), |one| one);
    }
    once.count();
    if unsaid > 0 {
        complain("note", &format!("{unsaid} more {} not shown", agree(unsaid, ["error is", "errors are"])));
    }
}

/// What is said of many things in the same words is shown once, and counted.
#[derive(Default)]
pub(crate) struct Once(Vec<Like>);

/// Diagnostics of one code and one shape.
struct Like {
    code: Code,
    shape: String,
    more: usize,
    /// Whom or where those that are not shown are about, the first three.
    names: Vec<String>,
}

impl Once {
    /// So many names are told.
    const NAMES: usize = 3;

    /// Shows a diagnostic, with its lines, or counts it where the like was shown.
    pub(crate) fn show(&mut self, told: Diagnostic, quoted: impl FnOnce(Diagnostic) -> Diagnostic) {
        let (told, unsaid) = told.without_unsaid();
        let (code, shape) = (told.code(), shape(told.message()));
        let of_code: Vec<usize> = (0..self.0.len()).filter(|place| self.0[*place].code == code).collect();
        let same = of_code.iter().find(|place| self.0[**place].shape == shape);
        // Errors are all shown; of what is none, one of each code.
        let is_full = !of_code.is_empty() && told.severity() != Severity::Error;
        let last = of_code.last().filter(|_| is_full);
        match same.or(last).and_then(|place| self.0.get_mut(*place)) {
            Some(like) => {
                like.more += 1 + unsaid;
                if like.names.len() < Self::NAMES {
                    let element = told.elements().first().map(|element| format!("element {element}"));
                    let place = || told.line().map(|line| format!("{}:{line}", told.file()));
                    like.names.extend(element.or_else(place));
                }
            }
            None => {
                self.0.push(Like { code, shape, more: unsaid, names: Vec::new() });
                let text = quoted(told).render(page_width(&io::stderr()), true);
                _ = writeln!(anstream::stderr(), "{}", text.trim_end());
            }
        }
    }

    /// Says how often each was said, and of what.
    pub(crate) fn count(self) {
        for Like { code, more, names, .. } in self.0.into_iter().filter(|like| like.more > 0) {
            let rest = if more > names.len() { " …" } else { "" };
            let of = if names.is_empty() { String::new() } else { format!(": {}{rest}", names.join(", ")) };
            complain("note", &format!("{code} {more} more {}{of}", agree(more, ["time", "times"])));
        }
    }
}

/// A line on stderr.
pub(crate) fn complain(kind: &str, text: &str) {
    let style = anstyle::Style::new().bold();
    _ = writeln!(anstream::stderr(), "{style}{kind}:{style:#} {text}");
}
