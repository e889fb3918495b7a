//! A comparison as text, and as a page with pictures.

use crate::judge::{Comparison, Point, Series};
use pintle_report::{table, wrap};
use std::fmt::Write as _;
use std::io::{self, Write};

/// The most series that are shown with what is wrong.
const SHOWN: usize = 6;

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
        if wrong == 0 {
            return format!("All {compared} numbers agree, within the digits of the file.");
        }
        let of = self.series.iter().filter(|series| series.wrong > 0).count();
        let all = self.series.len();
        match &self.cause {
            Some(cause) => format!("{wrong} of {compared} numbers differ, and all agree if {cause}."),
            None => format!("{wrong} of {compared} numbers differ, in {of} of {all} outputs."),
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
                        series.worst.map_or_else(String::new, |worst| shown(worst.at)),
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
        }
        for unjudged in &self.unjudged {
            let words = format!(
                "not compared: {} of {} ({} numbers): {}",
                unjudged.name, unjudged.element, unjudged.count, unjudged.why
            );
            for line in wrap(&words, width) {
                writeln!(out, "{line}")?;
            }
        }
        for gap in &self.gaps {
            for line in wrap(&format!("the file cannot tell: {gap}"), width) {
                writeln!(out, "{line}")?;
            }
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
            write!(out, "{}", picture(series))?;
        }
        for unjudged in &self.unjudged {
            writeln!(
                out,
                "<p>Not compared: {} of {} ({} numbers): {}.</p>",
                escaped(&unjudged.name),
                escaped(&unjudged.element),
                unjudged.count,
                escaped(&unjudged.why)
            )?;
        }
        for gap in &self.gaps {
            writeln!(out, "<p>The file cannot tell: {}.</p>", escaped(gap))?;
        }
        writeln!(out, "</html>")
    }
}

impl Series {
    /// What is wrong, where first, and why.
    fn sentence(&self) -> String {
        let mut words = format!("{} of {}", self.name, self.element);
        if let Some(first) = self.first {
            let _ = write!(
                words,
                " differs from {} on: got {}, want {}",
                shown(first.at),
                shown(first.got),
                shown(first.want)
            );
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
