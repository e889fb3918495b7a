//! Times against errors: for reading, as JSON, CSV, Markdown, and drawn.

use crate::audit::figure::{Curve, LogPlot, Medium as On};
use crate::layout;
use pintle_bench::{Order, Point, Proximity, REST, Report, Wrong};
use std::io::{self, Write};

/// The points of one diagram: a type, a place, an order.
struct Diagram<'a> {
    points: Vec<&'a Point>,
}

impl<'a> Diagram<'a> {
    /// All, in the order of the report.
    fn all(report: &'a Report) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for point in &report.points {
            let own =
                all.iter_mut().find(|diagram| diagram.points.iter().any(|known| known.is_beside(point)));
            match own {
                Some(diagram) => diagram.points.push(point),
                None => all.push(Self { points: vec![point] }),
            }
        }
        all
    }

    fn first(&self) -> Option<&'a Point> {
        self.points.first().copied()
    }

    /// The least time of pintle itself, one by one.
    fn ours(&self) -> Option<f64> {
        self.points.iter().find(|point| point.method == "pintle").map(|point| point.nanoseconds)
    }

    /// A point of each way, of a sweep of steps the one with the smallest error, the fastest way first.
    fn best(&self) -> Vec<(&'a Point, usize)> {
        let mut best: Vec<(&Point, usize)> = Vec::new();
        for point in &self.points {
            match best.iter_mut().find(|(known, _)| known.method == point.method) {
                Some((known, steps)) => {
                    *steps += 1;
                    if point.largest_error < known.largest_error {
                        *known = point;
                    }
                }
                None => best.push((point, 1)),
            }
        }
        best.sort_by(|(a, _), (b, _)| a.nanoseconds.total_cmp(&b.nanoseconds));
        best
    }
}

/// A time with three digits.
fn time(nanoseconds: f64) -> String {
    match nanoseconds {
        ns if ns < 10.0 => format!("{ns:.2} ns"),
        ns if ns < 100.0 => format!("{ns:.1} ns"),
        ns if ns < 1000.0 => format!("{ns:.0} ns"),
        ns if ns < 1e4 => format!("{:.2} µs", ns / 1e3),
        ns if ns < 1e5 => format!("{:.1} µs", ns / 1e3),
        ns if ns < 1e6 => format!("{:.0} µs", ns / 1e3),
        ns => format!("{:.2} ms", ns / 1e6),
    }
}

fn times(ratio: Option<f64>) -> String {
    match ratio {
        Some(ratio) if ratio < 10.0 => format!("{ratio:.2}"),
        Some(ratio) if ratio < 100.0 => format!("{ratio:.1}"),
        Some(ratio) => format!("{ratio:.0}"),
        None => String::new(),
    }
}

fn error(error: f64) -> String {
    if error == 0.0 { "0".into() } else { format!("{error:.1e}") }
}

fn where_(place: Proximity, distance: f64) -> String {
    match place {
        Proximity::Far => "far from singular points".into(),
        Proximity::Near => format!("{distance:e} from a singular point or half a turn"),
        Proximity::Rest => format!("{REST:e} rad from no rotation"),
    }
}

/// The name of a way, and the vector unit that it runs on.
fn way(point: &Point) -> String {
    match &point.vector_unit {
        Some(unit) => format!("{}, {unit}", point.method),
        None => point.method.to_string(),
    }
}

const HEAD: [&str; 7] = ["", "way", "time", "× pintle", "median error", "largest error", "step"];

/// The lines of a type at a place: an order by the other.
fn lines(report: &Report, connection: &str, place: Proximity) -> Vec<Vec<String>> {
    let mut lines = Vec::new();
    for diagram in Diagram::all(report) {
        let Some(first) = diagram.first().filter(|p| p.connection == connection && p.place == place) else {
            continue;
        };
        for (i, (point, steps)) in diagram.best().into_iter().enumerate() {
            let order = if i == 0 { first.order.name() } else { "" };
            let step = point.step.map(|step| format!("{step:.0e}, best of {steps}"));
            lines.push(vec![
                order.to_string(),
                way(point),
                time(point.nanoseconds),
                times(diagram.ours().map(|ours| point.nanoseconds / ours)),
                error(point.median_error),
                error(point.largest_error),
                step.unwrap_or_default(),
            ]);
        }
    }
    for wrong in report.wrong.iter().filter(|wrong| wrong.connection == connection && wrong.place == place) {
        let cells = [wrong.order.name(), &wrong.method, "wrong", "", "", &error(wrong.error)];
        let allowed = format!("{} is allowed", error(wrong.bound));
        lines.push(cells.map(str::to_string).into_iter().chain([allowed]).collect());
    }
    lines
}

/// The types and places of a report, in its order.
fn sections(report: &Report) -> Vec<(&str, Proximity)> {
    let mut found: Vec<(&str, Proximity)> = Vec::new();
    let of_points = report.points.iter().map(|point| (point.connection.as_str(), point.place));
    let of_wrong = report.wrong.iter().map(|wrong| (wrong.connection.as_str(), wrong.place));
    for section in of_points.chain(of_wrong) {
        if !found.contains(&section) {
            found.push(section);
        }
    }
    found
}

/// The rows that no way computes, type by type.
fn left_out(report: &Report) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for point in report.points.iter().filter(|point| !point.left_out.is_empty()) {
        let line = format!(
            "{}: every way leaves out the row of {}, a one-form: there is no function of the nodes to difference; what is measured are those of {}",
            point.connection,
            point.left_out.join(", "),
            point.rows.join(", ")
        );
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    lines
}

/// The ways that are not timed somewhere, and why.
fn untimed(report: &Report) -> Vec<String> {
    let line = |of: &pintle_bench::Untimed| {
        format!(
            "{}, {}: {} of {} is not timed: {}",
            of.connection,
            of.place.name(),
            of.order.name(),
            of.method,
            of.why
        )
    };
    report.untimed.iter().map(line).collect()
}

/// What the numbers are.
fn legend(report: &Report) -> String {
    let Report { rounds, states, batch, .. } = report;
    let repeated = if batch > states {
        format!(
            ", for ways that take batches over and over to {batch} and into as much memory, for all others into the same"
        )
    } else {
        String::new()
    };
    format!(
        "times: the least of {rounds} rounds that took turns, of one state with all the rows that are measured, one thread, {states} states{repeated}; \
         errors against 237 bits: of values over |f| + Σ |∂f/∂q| s, s = 1 rad or the length of the connector, of derivatives over the \
         largest number of the row"
    )
}

/// What the reader must know before the numbers.
fn warnings(report: &Report) -> Vec<String> {
    let mut found = Vec::new();
    if !report.environment.is_optimised {
        found.push("built without optimisation: these times say nothing of a release build".into());
    }
    let cores = report.environment.cores as f64;
    if let Some(load) = report.environment.load.filter(|load| *load > 1.0) {
        let busy = if load > cores { "the machine is overloaded" } else { "the machine does other work" };
        found.push(format!("{busy} (load {load:.1}): trust the ratios more than the times"));
    }
    found
}

/// Writes tables for reading.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn human(out: &mut dyn Write, report: &Report, width: usize) -> io::Result<()> {
    layout::paragraph(out, layout::PLAIN, 0, &report.environment.line(), width)?;
    for warning in warnings(report) {
        writeln!(out, "{}", layout::styled(layout::CARE, warning))?;
    }
    for (connection, place) in sections(report) {
        writeln!(out, "\n{}, {}", layout::styled(layout::BOLD, connection), where_(place, report.distance))?;
        write!(out, "{}", layout::table(&HEAD, &lines(report, connection, place)))?;
    }
    writeln!(out)?;
    for omitted in &report.omitted {
        writeln!(out, "{}, {}: not measured: {}", omitted.connection, omitted.place.name(), omitted.why)?;
    }
    for line in left_out(report).iter().chain(&untimed(report)).flat_map(|line| layout::wrap(line, width)) {
        writeln!(out, "{line}")?;
    }
    layout::paragraph(out, layout::DIM, 0, &legend(report), width)?;
    Ok(())
}

/// Writes tables as GitHub-flavoured Markdown.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn markdown(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    writeln!(out, "{}.", report.environment.line())?;
    for warning in warnings(report) {
        writeln!(out, "\n**Note:** {warning}.")?;
    }
    for (connection, place) in sections(report) {
        writeln!(out, "\n**{connection}**, {}\n", where_(place, report.distance))?;
        writeln!(out, "| {} |\n|---|---|---:|---:|---:|---:|---|", HEAD.join(" | "))?;
        for line in lines(report, connection, place) {
            writeln!(out, "| {} |", line.join(" | "))?;
        }
    }
    for omitted in &report.omitted {
        writeln!(out, "\n{}, {}: not measured: {}.", omitted.connection, omitted.place.name(), omitted.why)?;
    }
    for line in left_out(report).iter().chain(&untimed(report)) {
        writeln!(out, "\n{line}.")?;
    }
    writeln!(out, "\nIn the table {}.", legend(report))
}

/// Writes every point, of all steps, as one JSON document, schema [`pintle_bench::SCHEMA`]. An error without bound is `null`.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn json(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, report).map_err(io::Error::from)?;
    writeln!(out)
}

/// Writes every point, of all steps, as a table with a heading line; then, without times, what is wrong.
///
/// # Errors
/// Where the stream cannot be written to.
pub fn csv(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(out);
    let heading = [
        "type",
        "place",
        "order",
        "method",
        "step",
        "vector_unit",
        "nanoseconds",
        "slowest_round",
        "median_error",
        "largest_error",
        "rows",
        "left_out",
        "wrong_beyond",
    ];
    writer.write_record(heading)?;
    for point in &report.points {
        let number = |x: f64| format!("{x:e}");
        writer.write_record([
            point.connection.as_str(),
            point.place.name(),
            point.order.name(),
            &point.method,
            &point.step.map(number).unwrap_or_default(),
            point.vector_unit.as_deref().unwrap_or_default(),
            &number(point.nanoseconds),
            &number(point.slowest_round),
            &number(point.median_error),
            &number(point.largest_error),
            &point.rows.join(" "),
            &point.left_out.join(" "),
            "",
        ])?;
    }
    for Wrong { connection, place, order, method, error, bound } in &report.wrong {
        let mut cells = [""; 13].map(String::from);
        let told = [connection.clone(), place.name().into(), order.name().into(), method.to_string()];
        cells.iter_mut().zip(told).for_each(|(cell, told)| *cell = told);
        cells[9] = format!("{error:e}");
        cells[12] = format!("{bound:e}");
        writer.write_record(&cells)?;
    }
    writer.flush()
}

/// The colour of a way, the same in every figure of an order.
fn colour(name: &str, order: Order, report: &Report) -> u8 {
    let mut names: Vec<&str> = Vec::new();
    for point in report.points.iter().filter(|point| point.order == order) {
        if !names.contains(&point.method.as_ref()) {
            names.push(&point.method);
        }
    }
    let at = names.iter().position(|known| *known == name).unwrap_or_default();
    (at % 12) as u8 + 1
}

/// A way, its error and its time.
type Named<'a> = (&'a str, [f64; 2]);

/// Curves of points with a way, an error and a time: one for each way.
fn curves<'a>(points: &[Named<'a>], order: Order, report: &Report) -> Vec<Curve<'a>> {
    let mut curves: Vec<Curve<'_>> = Vec::new();
    for (name, at) in points.iter().copied().filter(|(_, [error, _])| error.is_finite()) {
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.points.push(at),
            None => {
                let is_main = name.starts_with("pintle");
                curves.push(Curve { name, is_main, colour: colour(name, order, report), points: vec![at] });
            }
        }
    }
    curves
}

/// The order of the legend: that of the least times.
fn fastest_first(mut curves: Vec<Curve<'_>>) -> Vec<Curve<'_>> {
    let least = |curve: &Curve<'_>| curve.points.iter().fold(f64::INFINITY, |least, [_, ns]| least.min(*ns));
    curves.sort_by(|a, b| least(a).total_cmp(&least(b)));
    curves
}

/// Time against error on log axes, a figure for each type, place and order, by file name; of several types together, the geometric mean of
/// their Jacobians too.
pub fn figures(report: &Report) -> Vec<(String, String)> {
    let machine = format!("one core of {}", report.environment.short());
    let states = |place| format!("states {}", where_(place, report.distance));
    let each = Diagram::all(report).into_iter().filter_map(|diagram| {
        let Point { connection, place, order, .. } = diagram.first()?;
        if *order == Order::Value && diagram.points.len() < 2 {
            return None;
        }
        let points: Vec<Named<'_>> = diagram
            .points
            .iter()
            .map(|point| (point.method.as_ref(), [point.largest_error, point.nanoseconds]))
            .collect();
        let plot = LogPlot {
            title: &format!("{connection}: {}, time against error", order.name()),
            heading: vec![states(*place), machine.clone()],
            x_name: match order {
                Order::Value => "largest error / (|f| + Σ |∂f/∂q| s)",
                _ => "largest error / largest number of the row",
            },
            y_name: "ns per state",
            curves: fastest_first(curves(&points, *order, report)),
            levels: Vec::new(),
            has_legend: true,
        };
        let words = format!("{connection} {} {}", order.name(), place.name());
        let name: Vec<String> = words
            .split(|c: char| !c.is_ascii_alphanumeric())
            .filter(|word| !word.is_empty())
            .map(str::to_ascii_lowercase)
            .collect();
        Some((format!("{}.svg", name.join("-")), plot.svg(On::File)))
    });
    let together = Proximity::ALL.into_iter().filter_map(|place| {
        let (points, types) = means(report, place)?;
        let plot = LogPlot {
            title: &format!("Value and Jacobian, time against error: mean of {} types", types.len()),
            heading: vec![format!("geometric mean of {}", types.join(", ")), states(place), machine.clone()],
            x_name: "largest error / largest number of the row",
            y_name: "ns per state",
            curves: fastest_first(curves(&points, Order::Jacobian, report)),
            levels: Vec::new(),
            has_legend: true,
        };
        Some((format!("jacobian-{}.svg", place.name()), plot.svg(On::File)))
    });
    each.chain(together).collect()
}

/// The geometric means of errors and times, over all types with Jacobians at a place, of the ways that all of them have; `None` for
/// less than two.
fn means(report: &Report, place: Proximity) -> Option<(Vec<Named<'_>>, Vec<&str>)> {
    let own = || report.points.iter().filter(move |p| p.place == place && p.order == Order::Jacobian);
    let mut types: Vec<&str> = Vec::new();
    for point in own() {
        if !types.contains(&point.connection.as_str()) {
            types.push(&point.connection);
        }
    }
    let first = *types.get(1).and(types.first())?;
    let of = |point: &Point| {
        let same = own().filter(|other| other.method == point.method && other.step == point.step);
        let same: Vec<&Point> = same.collect();
        let mean = |x: fn(&Point) -> f64| {
            // What is exact is compared as one rounding.
            let logarithms = same.iter().map(|point| x(point).max(f64::EPSILON / 2.0).ln());
            (logarithms.sum::<f64>() / same.len() as f64).exp()
        };
        (same.len() == types.len()).then(|| [mean(|p| p.largest_error), mean(|p| p.nanoseconds)])
    };
    let points = own().filter(|point| point.connection == first);
    let points = points.filter_map(|point| Some((point.method.as_ref(), of(point)?))).collect();
    Some((points, types))
}
