//! A comparison as text, and as a page with pictures.

use crate::evaluate::Why;
use crate::judge::{Comparison, Gap, Point, Series, Unjudged};
use pintle_report::{table, wrap};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::fmt::Write as _;
use std::io::{self, Write};

/// The most series that are shown with what is wrong.
const SHOWN: usize = 6;

/// How many characters a spark has at most.
const SPARK: usize = 48;

/// Width and heights of a picture.
const WIDTH: f64 = 720.0;
const HIGH: f64 = 180.0;
const LOW: f64 = 70.0;

impl Comparison {
    /// The answer in a sentence or two.
    pub fn headline(&self) -> String {
        let (compared, wrong) = (self.compared(), self.wrong());
        if compared == 0 {
            return "Nothing could be compared.".to_string();
        }
        let unread = match self.unread.as_slice() {
            [] => String::new(),
            [one] => format!(" The column {one} was not read."),
            all => format!(" {} columns were not read.", all.len()),
        };
        if wrong == 0 {
            return format!("All {compared} numbers agree, within the digits of the file.{unread}");
        }
        let of = self.series.iter().filter(|series| series.wrong > 0).count();
        let all = self.series.len();
        match &self.cause {
            Some(cause) => format!("{wrong} of {compared} numbers differ, and all agree if {cause}.{unread}"),
            None => format!("{wrong} of {compared} numbers differ, in {of} of {all} outputs.{unread}"),
        }
    }

    /// Writes it as text.
    ///
    /// # Errors
    /// Where the stream cannot be written to.
    pub fn write_human(&self, out: &mut dyn Write, of: &str, width: usize) -> io::Result<()> {
        for line in wrap(&format!("{of}: {}", self.headline()), width) {
            writeln!(out, "{line}")?;
        }
        if !self.series.is_empty() {
            let rows: Vec<Vec<String>> = self
                .series
                .iter()
                .map(|series| {
                    let worst = series.worst.map_or(0.0, |worst| worst.units());
                    let state = if series.wrong == 0 { "agrees" } else { "differs" };
                    vec![
                        format!("{} {}", series.type_name, series.element),
                        series.name.clone(),
                        state.to_string(),
                        format!("{} of {}", series.wrong, series.compared),
                        shown(worst),
                        match (&series.entry, series.of, series.worst) {
                            (Some(entry), ..) => entry.clone(),
                            (None, Some(_), Some(worst)) => shown(worst.at),
                            _ => String::new(),
                        },
                    ]
                })
                .collect();
            writeln!(out)?;
            write!(
                out,
                "{}",
                table(&["connector", "output", "", "wrong", "difference/allowed", "at"], &rows)
            )?;
        }
        for series in self.series.iter().filter(|series| series.wrong > 0).take(SHOWN) {
            writeln!(out)?;
            for line in wrap(&series.sentence(), width) {
                writeln!(out, "{line}")?;
            }
            for line in sparks(series) {
                writeln!(out, "  {line}")?;
            }
        }
        for words in self.refused() {
            for line in wrap(&format!("not compared: {words}"), width) {
                writeln!(out, "{line}")?;
            }
        }
        if self.between > 0 {
            for line in wrap(&self.interpolated(), width) {
                writeln!(out, "{line}")?;
            }
        }
        for Gap { what, request } in &self.gaps {
            let add = if request.is_empty() { "" } else { "; add to the step" };
            for line in wrap(&format!("the file cannot tell: {what}{add}"), width) {
                writeln!(out, "{line}")?;
            }
            for line in request {
                writeln!(out, "    {line}")?;
            }
        }
        Ok(())
    }

    /// What was not compared, a sentence for each element and cause.
    fn refused(&self) -> Vec<String> {
        let mut groups: Vec<(&str, &Why, Vec<&str>, u64)> = Vec::new();
        for Unjudged { element, name, count, why } in &self.unjudged {
            match groups.iter_mut().find(|(of, because, ..)| of == element && *because == why) {
                Some((.., names, sum)) => {
                    names.push(name);
                    *sum += count;
                }
                None => groups.push((element, why, vec![name], *count)),
            }
        }
        let words = groups.into_iter().map(|(element, why, names, count)| {
            format!("{} of {element} ({count} numbers): {why}", names.join(", "))
        });
        words.collect()
    }

    /// What was interpolated, in a sentence.
    fn interpolated(&self) -> String {
        format!(
            "interpolated: {} of {} states have no motion of their own; it lies between those of the files, and counts with what a \
             parabola differs",
            self.between, self.frames
        )
    }

    /// A suite of JUnit of these files, a case for each output.
    fn suite(&self, of: &str) -> TestSuite {
        let mut suite = TestSuite::new(of);
        for series in &self.series {
            let mut status = TestCaseStatus::success();
            if series.wrong > 0 {
                status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                status.set_message(self.cause.clone().map_or_else(
                    || series.sentence(),
                    |cause| format!("{} All agree if {cause}.", series.sentence()),
                ));
            }
            let mut test = TestCase::new(format!("{} of {}", series.name, series.element), status);
            test.set_classname(format!("{} {}", series.type_name, series.element));
            suite.add_test_case(test);
        }
        for unjudged in &self.unjudged {
            let mut status = TestCaseStatus::skipped();
            status.set_message(unjudged.why.to_string());
            suite.add_test_case(TestCase::new(format!("{} of {}", unjudged.name, unjudged.element), status));
        }
        suite
    }

    /// Writes it as Markdown, for a comment in a review.
    ///
    /// # Errors
    /// Where the stream cannot be written to.
    pub fn write_markdown(&self, out: &mut dyn Write, of: &str) -> io::Result<()> {
        writeln!(out, "**{}**: {}\n", marked(of), marked(&self.headline()))?;
        if !self.series.is_empty() {
            writeln!(out, "| connector | output | wrong | difference/allowed |\n|---|---|---|---|")?;
        }
        for series in &self.series {
            let worst = series.worst.map_or(0.0, |worst| worst.units());
            writeln!(
                out,
                "| {} {} | {} | {} of {} | {} |",
                marked(&series.type_name),
                marked(&series.element),
                series.name,
                series.wrong,
                series.compared,
                shown(worst)
            )?;
        }
        writeln!(out)?;
        for series in self.series.iter().filter(|series| series.wrong > 0) {
            writeln!(out, "- {}", marked(&series.sentence()))?;
        }
        for words in self.refused() {
            writeln!(out, "- not compared: {}", marked(&words))?;
        }
        if self.between > 0 {
            writeln!(out, "- {}", self.interpolated())?;
        }
        for Gap { what, request } in &self.gaps {
            let add = if request.is_empty() { String::new() } else { format!(": `{}`", request.join("` `")) };
            writeln!(out, "- the file cannot tell: {}{add}", marked(what))?;
        }
        Ok(())
    }

    /// Writes it as one self-contained page.
    ///
    /// # Errors
    /// Where the stream cannot be written to.
    pub fn write_html(&self, out: &mut dyn Write, of: &str) -> io::Result<()> {
        writeln!(
            out,
            "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
             <title>pintle compare</title><style>body{{font:16px/1.5 system-ui,sans-serif;max-width:46rem;margin:2rem auto;padding:0 1rem}}\
             svg{{width:100%;height:auto}}td,th{{text-align:left;padding:.1rem .8rem .1rem 0}}table{{display:block;overflow-x:auto}}\
             .got{{stroke:#b3261e}}.want{{stroke:#1a5fb4}}.apart{{stroke:#333}}path{{fill:none;stroke-width:1.5}}</style>"
        )?;
        writeln!(out, "<h1>{}</h1><p>{}</p>", escaped(of), escaped(&self.headline()))?;
        writeln!(out, "<table><tr><th>connector<th>output<th>wrong<th>difference/allowed</tr>")?;
        for series in &self.series {
            let worst = series.worst.map_or(0.0, |worst| worst.units());
            writeln!(
                out,
                "<tr><td>{} {}<td>{}<td>{} of {}<td>{}</tr>",
                escaped(&series.type_name),
                escaped(&series.element),
                series.name,
                series.wrong,
                series.compared,
                shown(worst)
            )?;
        }
        writeln!(out, "</table>")?;
        let wrong = self.series.iter().filter(|series| series.wrong > 0);
        for series in wrong {
            writeln!(
                out,
                "<h2>{} of {}</h2><p>{}</p>",
                series.name,
                escaped(&series.element),
                escaped(&series.sentence())
            )?;
            if series.points.len() > 1 {
                write!(out, "{}", picture(series))?;
            }
        }
        for words in self.refused() {
            writeln!(out, "<p>Not compared: {}.</p>", escaped(&words))?;
        }
        if self.between > 0 {
            writeln!(out, "<p>{}.</p>", escaped(&self.interpolated()))?;
        }
        for Gap { what, request } in &self.gaps {
            writeln!(out, "<p>The file cannot tell: {}.</p>", escaped(what))?;
            if !request.is_empty() {
                writeln!(out, "<pre>{}</pre>", escaped(&request.join("\n")))?;
            }
        }
        writeln!(out, "</html>")
    }
}

impl Series {
    /// What is wrong, where first, and why.
    fn sentence(&self) -> String {
        let mut words = match &self.of {
            Some(_) => format!("{} of {}", self.name, self.element),
            None => format!("{} {}", self.type_name, self.element),
        };
        if let Some(first) = self.first {
            let place = match (&self.entry, self.wrong) {
                (Some(entry), _) => format!("at {entry}"),
                (None, 1) => format!("at {} alone", shown(first.at)),
                (None, wrong) if wrong == self.since => format!("from {} on", shown(first.at)),
                (None, wrong) => {
                    format!("at {wrong} of {} states, first at {}", self.compared, shown(first.at))
                }
            };
            let _ = write!(words, " differs {place}: got {}, want {}", shown(first.got), shown(first.want));
        }
        let _ = match &self.cause {
            Some(cause) => write!(words, "; {cause}."),
            None => write!(words, "."),
        };
        words
    }
}

/// A number for reading.
fn shown(x: f64) -> String {
    match x.abs() {
        _ if x == 0.0 => "0".to_string(),
        size if (1e-3..1e6).contains(&size) => {
            let text = format!("{x:.6}");
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        }
        _ => format!("{x:.4e}"),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A text in Markdown: what would be a mark is none.
fn marked(text: &str) -> String {
    let mut marked = String::new();
    for c in text.chars() {
        if matches!(c, '|' | '*' | '_' | '`' | '<' | '[' | ']' | '\\' | '#') {
            marked.push('\\');
        }
        marked.push(if c == '\n' { ' ' } else { c });
    }
    marked
}

/// JUnit XML of some comparisons.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn write_junit(out: &mut dyn Write, all: &[(String, Comparison)]) -> io::Result<()> {
    let mut document = Report::new("pintle compare");
    for (name, comparison) in all {
        document.add_test_suite(comparison.suite(name));
    }
    let text = document.to_string().map_err(io::Error::other)?;
    out.write_all(text.as_bytes())
}

/// Both curves and their difference as lines of text.
fn sparks(series: &Series) -> Vec<String> {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let points = &series.points;
    if points.len() < 3 {
        return Vec::new();
    }
    let count = points.len().min(SPARK);
    let some: Vec<&Point> =
        (0..count).map(|n| &points[n * (points.len() - 1) / (count - 1).max(1)]).collect();
    let range = |of: &dyn Fn(&Point) -> [f64; 2]| {
        let all = || some.iter().flat_map(|point| of(point)).filter(|x| x.is_finite());
        (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max))
    };
    let spark = |of: &dyn Fn(&Point) -> f64, (low, high): (f64, f64)| -> String {
        let bar = |point: &&Point| {
            let part = (of(point) - low) / (high - low);
            if part.is_finite() { BARS[((part * 7.0).round() as usize).min(7)] } else { BARS[0] }
        };
        some.iter().map(bar).collect()
    };
    let both = range(&|point| [point.got, point.want]);
    let apart = range(&|point| [point.got - point.want; 2]);
    vec![
        format!("file       {}  {} … {}", spark(&|point| point.got, both), shown(both.0), shown(both.1)),
        format!("pintle     {}", spark(&|point| point.want, both)),
        format!(
            "difference {}  {} … {}",
            spark(&|point| point.got - point.want, apart),
            shown(apart.0),
            shown(apart.1)
        ),
    ]
}

/// One number of a point.
type Of = dyn Fn(&Point) -> f64;

/// Both curves, and their difference beneath.
fn picture(series: &Series) -> String {
    let points = &series.points;
    let range = |all: &[&Of]| {
        let every =
            || points.iter().flat_map(|point| all.iter().map(move |of| of(point))).filter(|x| x.is_finite());
        let (low, high) = (every().fold(f64::INFINITY, f64::min), every().fold(f64::NEG_INFINITY, f64::max));
        if high > low { (low, high) } else { (low - 1.0, low + 1.0) }
    };
    let (got, want): (&Of, &Of) = (&|point| point.got, &|point| point.want);
    let (at, apart): (&Of, &Of) = (&|point| point.at, &|point| point.got - point.want);
    let times = range(&[at]);
    let values = range(&[got, want]);
    let differences = range(&[apart]);
    let path = |class: &str, of: &Of, (low, high): (f64, f64), top: f64, height: f64| {
        let mut d = String::new();
        for point in points.iter().filter(|point| of(point).is_finite()) {
            let x = WIDTH * (point.at - times.0) / (times.1 - times.0);
            let y = top + height * (high - of(point)) / (high - low);
            let _ = write!(d, "{}{x:.1} {y:.1}", if d.is_empty() { "M" } else { "L" });
        }
        format!("<path class=\"{class}\" d=\"{d}\"/>")
    };
    let label = |y: f64, words: &str| format!("<text x=\"4\" y=\"{y}\" font-size=\"13\">{words}</text>");
    format!(
        "<svg viewBox=\"-2 -2 {} {}\" role=\"img\">{}{}{}{}{}{}</svg>\n",
        WIDTH + 4.0,
        HIGH + LOW + 40.0,
        path("want", want, values, 0.0, HIGH),
        path("got", got, values, 0.0, HIGH),
        label(14.0, &format!("{} … {}: red the file, blue pintle", shown(values.0), shown(values.1))),
        path("apart", apart, differences, HIGH + 30.0, LOW),
        label(HIGH + 26.0, &format!("difference, {} … {}", shown(differences.0), shown(differences.1))),
        label(HIGH + LOW + 36.0, &format!("from {} to {}", shown(times.0), shown(times.1))),
    )
}
