//! What a sweep found: for reading, and drawn.

use crate::layout;
use pintle_audit::Verdict;
use pintle_sweep::{OfLaw, OfQuantity, OfSubject, Summary, Worst};
use std::fmt::Write as _;
use std::io::{self, Write};

/// A count with its thousands apart.
fn count(number: u64) -> String {
    layout::grouped(number, ',')
}

fn units(worst: Option<&Worst>) -> String {
    worst.map_or_else(|| "—".to_string(), |worst| short(worst.units.0))
}

fn short(x: f64) -> String {
    if (0.001..1000.0).contains(&x) || x == 0.0 { format!("{x:.3}") } else { format!("{x:.1e}") }
}

fn of_law(of: &OfLaw) -> String {
    of.largest.map_or_else(|| "—".into(), |largest| short(largest.value.0))
}

fn of_verdict(of: &OfQuantity, verdict: impl Fn(Verdict) -> bool) -> u64 {
    of.verdicts.iter().filter(|(known, _)| verdict(**known)).map(|(_, count)| count).sum()
}

fn line(of: &OfSubject) -> Vec<String> {
    vec![
        of.name.clone(),
        count(of.states()),
        count(of.judged),
        units(of.value.worst.first()),
        units(of.row.worst.first()),
        of_law(&of.rigid),
        of_law(&of.frame),
        count(of.wrong),
    ]
}

/// Writes a table for reading; `wanted` is how many states were asked for.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn human(
    out: &mut dyn Write,
    summary: &Summary,
    digest: &str,
    wanted: u64,
    width: usize,
) -> io::Result<()> {
    let head = ["", "states", "judged", "value", "row", "rigid", "frame", "wrong"];
    let lines: Vec<Vec<String>> = summary.subjects.iter().map(line).collect();
    write!(out, "{}", layout::table(&head, &lines))?;
    let legend = "value, row: the largest error of those judged on 237 bits, in units of the audit's bound; rigid: the most that is left of a row \
         along a rigid motion, of all states, in roundings; frame: the most that turning both nodes changes, of one state in 16, in roundings; \
         —: not asked; wrong: states at which a number is not finite, or beyond its bound";
    writeln!(out)?;
    layout::paragraph(out, layout::DIM, 0, legend, width)?;
    let sum = |of: &dyn Fn(&OfSubject) -> u64| summary.subjects.iter().map(of).sum::<u64>();
    let all = |of: &dyn Fn(&OfSubject) -> u64| count(sum(of));
    let done = summary.states.count();
    let states = if done == wanted { count(done) } else { format!("{} of {}", count(done), count(wanted)) };
    let both = |verdict: fn(Verdict) -> bool| {
        all(&move |of| of_verdict(&of.value, verdict) + of_verdict(&of.row, verdict))
    };
    writeln!(
        out,
        "\nstates    {states}, {} numbers, not finite at {} states",
        all(&|of| of.numbers),
        all(&|of| of.not_finite)
    )?;
    writeln!(
        out,
        "judged    {} states, {} entries: {} pass, {} ill-conditioned, {} on kinks or singular points, {} undecided, {} wrong",
        all(&|of| of.judged),
        all(&|of| of.value.compared + of.row.compared),
        both(|verdict| verdict == Verdict::Pass),
        both(|verdict| verdict == Verdict::IllConditioned),
        both(|verdict| matches!(verdict, Verdict::Kink | Verdict::Singular)),
        both(|verdict| verdict == Verdict::Undecided),
        both(Verdict::is_mismatch),
    )?;
    let passed = [
        (sum(&|of| of.outside), "outside the domain of the routine"),
        (sum(&|of| of.elsewhere), "other angles of the same rotation"),
        (sum(&|of| of.undefined), "no number, on a singular set"),
    ];
    for (states, what) in passed.iter().filter(|(states, _)| *states > 0) {
        writeln!(out, "passed    {} states, not judged: {what}", count(*states))?;
    }
    for of in summary.subjects.iter().filter(|of| of.wrong > 0) {
        wrong(out, of)?;
    }
    writeln!(out, "numbers   {:016x} on {}", summary.fingerprint, summary.arithmetic)?;
    writeln!(out, "digest    {digest}")
}

/// The worst of what is wrong.
fn wrong(out: &mut dyn Write, of: &OfSubject) -> io::Result<()> {
    if let Some(index) = of.first_not_finite {
        writeln!(out, "{}: state {index} has a number that is not finite", of.name)?;
    }
    if let Some(index) = of.first_wrong {
        writeln!(
            out,
            "{}: the first wrong state is {index}: the same command with --state {index} prints it",
            of.name
        )?;
    }
    let laws =
        [(&of.rigid, "a rigid motion changes a value"), (&of.frame, "turning both nodes changes numbers")];
    for (law, what) in laws {
        if let Some(largest) = law.largest.filter(|_| law.beyond > 0) {
            let (units, index) = (short(largest.value.0), largest.index);
            writeln!(out, "{}: at state {index} {what} by {units} roundings", of.name)?;
        }
    }
    let listed = [&of.value, &of.row].into_iter().flat_map(|of| &of.worst);
    for worst in listed.filter(|worst| worst.verdict.is_mismatch()) {
        let Worst { units, index, verdict, entry, got, want, .. } = worst;
        writeln!(
            out,
            "{}: {entry} at state {index} is {:e}, not {:e}: {} bounds, {}",
            of.name,
            got.0,
            want.0,
            short(units.0),
            verdict.name()
        )?;
    }
    Ok(())
}

/// The exponents of distances that are drawn: nearer ones are drawn with the nearest.
const NEAREST: i32 = -40;
/// Those of errors.
const LEAST: i32 = -20;
const MOST: i32 = 1;

/// The largest exponent of an error by the exponent of its distance.
fn worst_of(of: &OfSubject) -> Vec<Option<i32>> {
    let mut worst = vec![None; (1 - NEAREST) as usize];
    let entries = of.value.map.iter().chain(of.row.map.iter());
    for ([distance, error], _) in entries {
        let column = (distance.clamp(NEAREST, 0) - NEAREST) as usize;
        if let Some(known) = worst.get_mut(column) {
            *known = Some(known.map_or(error, |known: i32| known.max(error)));
        }
    }
    worst
}

/// The colour of an exponent: light where errors are small, dark at the bound, red beyond it.
fn colour(exponent: i32) -> String {
    if exponent >= 0 {
        return "#d03b3b".into();
    }
    let part = f64::from(exponent.clamp(LEAST, 0) - LEAST) / f64::from(-LEAST);
    let [light, dark] = [[205.0, 226.0, 251.0], [13.0, 54.0, 107.0]];
    let [r, g, b] = [0, 1, 2].map(|i: usize| (light[i] + (dark[i] - light[i]) * part) as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The worst error of each subject by the distance to its singular sets, as an SVG file.
pub fn picture(summary: &Summary) -> String {
    const CELL: usize = 15;
    const LEFT: usize = 210;
    const TOP: usize = 62;
    let subjects: Vec<&OfSubject> = summary.subjects.iter().filter(|of| of.judged > 0).collect();
    let columns = (1 - NEAREST) as usize;
    let (bottom, right) = (TOP + CELL * subjects.len(), LEFT + CELL * columns);
    let (width, height) = (right + 20, bottom + 92);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    let judged: u64 = subjects.iter().map(|of| of.judged).sum();
    let mut text = |x: usize, y: usize, anchor: &str, size: usize, words: &str| {
        let words = words.replace('&', "&amp;").replace('<', "&lt;");
        _ = writeln!(
            svg,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" font-size=\"{size}\" fill=\"#222\">{words}</text>"
        );
    };
    text(12, 22, "start", 15, "The worst error, by the distance to the nearest singular set");
    let heading = format!(
        "{} states, {} of them judged on 237 bits; each cell: the worst value or row among its states",
        count(summary.states.count()),
        count(judged)
    );
    text(12, 42, "start", 11, &heading);
    for (row, of) in subjects.iter().enumerate() {
        text(LEFT - 8, TOP + CELL * row + 11, "end", 11, &of.name);
    }
    for power in (NEAREST..=0).step_by(10) {
        let at = LEFT + CELL * (power - NEAREST) as usize;
        let name = if power == NEAREST { format!("≤ 2^{power}") } else { format!("2^{power}") };
        text(at, bottom + 16, "start", 11, &name);
    }
    text(
        LEFT,
        bottom + 34,
        "start",
        11,
        "distance to the nearest singular set (rad, or lengths of the connector); 1 where it is farther",
    );
    text(LEFT - 8, bottom + 62, "end", 11, "error / bound");
    for (i, power) in (LEAST..=MOST - 1).step_by(4).enumerate() {
        let name = if power == 0 { "beyond".into() } else { format!("2^{power}") };
        text(LEFT + 62 * i, bottom + 78, "start", 11, &name);
    }
    let mut cell = |x: usize, y: usize, colour: &str, title: &str| {
        let side = CELL - 1;
        _ = writeln!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{side}\" height=\"{side}\" rx=\"2\" fill=\"{colour}\"><title>{title}</title></rect>"
        );
    };
    for (row, of) in subjects.iter().enumerate() {
        for (column, worst) in worst_of(of).into_iter().enumerate() {
            let power = NEAREST + column as i32;
            let (fill, title) = match worst {
                Some(error) => (colour(error), format!("2^{power}: below 2^{} bounds", error + 1)),
                None => ("#f2f2f2".into(), format!("2^{power}: no state")),
            };
            cell(LEFT + CELL * column, TOP + CELL * row, &fill, &title);
        }
    }
    for (i, power) in (LEAST..=MOST - 1).step_by(4).enumerate() {
        cell(LEFT + 62 * i, bottom + 50, &colour(power), "");
    }
    svg + "</svg>\n"
}

/// Writes the summary and its digest as one JSON document.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn json(out: &mut dyn Write, summary: &Summary, digest: &str) -> io::Result<()> {
    #[derive(serde::Serialize)]
    struct Document<'a> {
        digest: &'a str,
        #[serde(flatten)]
        summary: &'a Summary,
    }
    serde_json::to_writer_pretty(&mut *out, &Document { digest, summary }).map_err(io::Error::from)?;
    writeln!(out)
}
