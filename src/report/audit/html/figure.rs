//! Figures as SVG: plots on log axes, heat maps. In a page they take its colours, light or dark; as files they bring their own.

use crate::audit::{Comparison, Illustration};
use crate::catalog::COMPONENT;
use crate::node::{DOF, DOFS};
use askama::Template;

/// The style of figures.
pub(super) const STYLE: &str = include_str!("figure.css");

/// Where a figure goes: into a page, or into a file of its own, which brings its style.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Page,
    File,
}

impl Place {
    pub(super) const fn style(self) -> Option<&'static str> {
        match self {
            Self::Page => None,
            Self::File => Some(STYLE),
        }
    }
}

/// A curve on log axes.
pub(crate) struct Curve<'a> {
    pub(crate) name: &'a str,
    /// Whether it is what the plot is about.
    pub(crate) is_main: bool,
    /// 1, 2, 3 …: colour and dashes.
    pub(crate) colour: u8,
    pub(crate) points: Vec<[f64; 2]>,
}

/// What a plot on log axes shows.
pub(crate) struct LogPlot<'a> {
    pub(crate) title: &'a str,
    /// What stands above the axes, below the title: where that is none, the title does not either.
    pub(crate) heading: Vec<String>,
    pub(crate) x_name: &'a str,
    pub(crate) y_name: &'a str,
    pub(crate) curves: Vec<Curve<'a>>,
    /// Horizontal lines with a name.
    pub(crate) levels: Vec<(f64, &'static str)>,
    /// Whether the names of the curves stand below the axes.
    pub(crate) has_legend: bool,
}

struct Tick {
    at: f64,
    power: i32,
}

struct Level<'a> {
    at: f64,
    name: &'a str,
}

struct Dot {
    x: f64,
    y: f64,
    clamped: bool,
    title: String,
}

struct Drawn {
    colour: u8,
    radius: f64,
    line: String,
    dots: Vec<Dot>,
}

#[derive(Template)]
#[template(path = "plot.svg", escape = "html")]
struct PlotTemplate<'a> {
    title: &'a str,
    style: Option<&'static str>,
    head: f64,
    heading: Vec<Line<'a>>,
    width: f64,
    height: f64,
    axis_name: f64,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x_name: &'a str,
    y_name: &'a str,
    x_ticks: Vec<Tick>,
    y_ticks: Vec<Tick>,
    levels: Vec<Level<'a>>,
    curves: Vec<Drawn>,
    names: Vec<Name<'a>>,
}

/// A line above the axes.
struct Line<'a> {
    class: &'static str,
    y: f64,
    text: &'a str,
}

/// A curve in the legend.
struct Name<'a> {
    x: f64,
    y: f64,
    colour: u8,
    text: &'a str,
}

/// A whole number of decades that holds all values, and the decades to label.
struct Axis {
    low: i32,
    high: i32,
    from: f64,
    to: f64,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let decades = values.filter(|x| x.is_finite() && *x > 0.0).map(f64::log10);
        let (low, high) =
            decades.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        if low > high {
            return Self { low: -1, high: 1, from, to };
        }
        // A decade that is touched by rounding only is not one more.
        const TOUCHED: f64 = 1e-9;
        let low = (low + TOUCHED).floor() as i32;
        let high = ((high - TOUCHED).ceil() as i32).max(low + 1);
        Self { low, high, from, to }
    }

    /// The place of a value; what is zero lies on the lower edge.
    fn at(&self, x: f64) -> f64 {
        let [low, high] = [self.low, self.high].map(f64::from);
        let decade = if x > 0.0 { x.log10().clamp(low, high) } else { low };
        let part = (decade - low) / (high - low);
        rounded(self.from + part * (self.to - self.from))
    }

    fn ticks(&self, most: i32) -> Vec<Tick> {
        let step =
            [1, 2, 3, 4, 5, 10, 20, 50, 100].into_iter().find(|step| (self.high - self.low) / step <= most);
        let step = step.unwrap_or(200);
        let first = self.low.div_euclid(step) * step;
        (0..)
            .map(|i| first + i * step)
            .take_while(|power| *power <= self.high)
            .filter(|power| *power >= self.low)
            .map(|power| Tick { at: self.at(10.0_f64.powi(power)), power })
            .collect()
    }
}

fn rounded(x: f64) -> f64 {
    (x * 100.0).round() / 100.0
}

impl LogPlot<'_> {
    /// The plot as SVG.
    pub(crate) fn svg(&self, place: Place) -> String {
        let (width, left, right, top) = (420.0, 48.0, 408.0, 26.0);
        let mut height = if self.has_legend { 330.0 } else { 250.0 };
        let bottom = height - 44.0;
        let names: Vec<Name<'_>> = if self.has_legend {
            let each = self.curves.iter().enumerate();
            each.map(|(i, curve)| Name {
                x: left + (i % 2) as f64 * 180.0,
                y: height + 10.0 + (i / 2) as f64 * 16.0,
                colour: curve.colour,
                text: curve.name,
            })
            .collect()
        } else {
            Vec::new()
        };
        let axis_name = height - 4.0;
        height += names.len().div_ceil(2) as f64 * 16.0;
        let all = || self.curves.iter().flat_map(|curve| &curve.points);
        let x = Axis::new(all().map(|p| p[0]), left + 6.0, right - 6.0);
        let levels = self.levels.iter().map(|(value, _)| *value);
        let y = Axis::new(all().map(|p| p[1]).chain(levels), bottom - 4.0, top + 4.0);
        let curves = self.curves.iter().map(|curve| {
            let mut line = String::new();
            let mut dots = Vec::new();
            for [h, error] in curve.points.iter().copied().filter(|p| p[1].is_finite()) {
                let at = [x.at(h), y.at(error)];
                line.push_str(&format!("{},{} ", at[0], at[1]));
                let title = format!("{}: {h:.1e}, {error:.3e}", curve.name);
                dots.push(Dot { x: at[0], y: at[1], clamped: error == 0.0, title });
            }
            let radius = if curve.is_main { 4.0 } else { 2.4 };
            Drawn { colour: curve.colour, radius, line: line.trim_end().to_string(), dots }
        });
        let head = if self.heading.is_empty() { 0.0 } else { 20.0 + 12.0 * self.heading.len() as f64 };
        let title = (!self.heading.is_empty()).then_some(Line { class: "label", y: 15.0, text: self.title });
        let below = self.heading.iter().enumerate();
        let below = below.map(|(i, text)| Line { class: "tiny", y: 28.0 + 12.0 * i as f64, text });
        let page = PlotTemplate {
            title: self.title,
            style: place.style(),
            head,
            heading: title.into_iter().chain(below).collect(),
            width,
            height,
            axis_name,
            left,
            right,
            top,
            bottom,
            x_name: self.x_name,
            y_name: self.y_name,
            x_ticks: x.ticks(8),
            y_ticks: y.ticks(7),
            levels: self.levels.iter().map(|(value, name)| Level { at: y.at(*value), name }).collect(),
            curves: curves.collect(),
            names,
        };
        rendered(&page)
    }
}

/// A template with its values in it. Writing to a text does not fail.
pub(super) fn rendered(template: &impl Template) -> String {
    template.render().unwrap_or_default()
}

/// Errors of ∂f·v against the step.
pub(super) fn steps(shown: &Illustration, place: Place) -> String {
    let plot = LogPlot {
        title: &format!("{}: error of ∂f·v against the step", shown.subject),
        heading: Vec::new(),
        x_name: "step h",
        y_name: "error, tolerances",
        curves: vec![
            Curve {
                name: "Taylor remainder / h",
                is_main: false,
                colour: 1,
                points: shown.steps.remainder.clone(),
            },
            Curve {
                name: "central difference",
                is_main: false,
                colour: 2,
                points: shown.steps.differences.clone(),
            },
        ],
        levels: vec![(1.0, "tolerance")],
        has_legend: false,
    };
    plot.svg(place)
}

struct Head {
    x: f64,
    y: f64,
    name: String,
}

struct Cell {
    x: f64,
    y: f64,
    w: f64,
    h: f64,
    class: &'static str,
    title: Option<String>,
    mark: Option<&'static str>,
}

#[derive(Template)]
#[template(path = "heatmap.svg", escape = "html")]
struct HeatTemplate<'a> {
    title: &'a str,
    style: Option<&'static str>,
    width: f64,
    height: f64,
    /// The width that it has at most on a page.
    most: f64,
    heads: Vec<Head>,
    rows: Vec<Head>,
    cells: Vec<Cell>,
}

/// The class of an error in units of its tolerance.
fn class(units: f64) -> &'static str {
    match units {
        0.0 => "h0",
        x if x < 0.01 => "h1",
        x if x < 0.1 => "h2",
        x if x < 0.5 => "h3",
        x if x <= 1.0 => "h4",
        _ => "bad",
    }
}

/// A Jacobian: colour is error in units of the tolerance, structure is what is not an open square.
pub(super) fn heat(title: &str, comparison: &Comparison, place: Place) -> String {
    const SIZE: [f64; 2] = [24.0, 20.0];
    const GAP: f64 = 2.0;
    const BETWEEN_BLOCKS: f64 = 7.0;
    let is_flow = |j: usize| j % (DOFS / 2) == DOFS / 2 - 1;
    let entries = || comparison.0.iter().flatten();
    let has = |j: usize| !is_flow(j) || entries().any(|row| row[j].got != 0.0 || row[j].want != 0.0);
    let mut heads = Vec::new();
    let mut columns: Vec<(usize, f64)> = Vec::new();
    let mut x = 42.0;
    for j in 0..DOFS {
        if j > 0 && matches!(j % (DOFS / 2), 0 | 3) {
            x += BETWEEN_BLOCKS;
        }
        if has(j) {
            heads.push(Head { x: x + SIZE[0] / 2.0, y: 12.0, name: DOF[j].to_string() });
            columns.push((j, x));
            x += SIZE[0] + GAP;
        }
    }
    let (mut rows, mut cells, mut y) = (Vec::new(), Vec::new(), 18.0);
    for (k, row) in comparison.0.iter().enumerate() {
        let Some(row) = row else { continue };
        rows.push(Head { x: 36.0, y: y + 14.0, name: COMPONENT[k].to_string() });
        for (j, x) in &columns {
            let entry = row[*j];
            let is_zero = entry.got == 0.0 && entry.units == 0.0;
            let title = (!is_zero).then(|| {
                format!(
                    "∂{}/∂{} = {:e}, must be {:e}: {:.3e} tolerances of {:.2e}",
                    COMPONENT[k], DOF[*j], entry.got, entry.want, entry.units, entry.tolerance
                )
            });
            let class = if is_zero { "zero" } else { class(entry.units) };
            let mark = (class == "bad").then_some("✗");
            cells.push(Cell { x: *x, y, w: SIZE[0], h: SIZE[1], class, title, mark });
        }
        y += SIZE[1] + GAP;
    }
    let page = HeatTemplate {
        title,
        style: place.style(),
        width: x + 2.0,
        height: y + 2.0,
        most: (1.12 * x).round(),
        heads,
        rows,
        cells,
    };
    rendered(&page)
}

struct StripDot {
    x: f64,
    low: f64,
    high: f64,
    title: String,
}

#[derive(Template)]
#[template(path = "strip.svg", escape = "html")]
struct StripTemplate<'a> {
    title: &'a str,
    width: f64,
    height: f64,
    left: f64,
    right: f64,
    ticks: Vec<Tick>,
    dots: Vec<StripDot>,
}

/// Pairs of positive numbers by name, side by side on one log axis: the first a dot, the second a ring.
pub(super) fn strip(title: &str, all: &[(String, [f64; 2])]) -> String {
    let (width, height, left, right) = (1000.0, 190.0, 48.0, 992.0);
    let axis = Axis::new(all.iter().flat_map(|(_, pair)| *pair), height - 12.0, 12.0);
    let gap = (right - left) / all.len().max(1) as f64;
    let dots = all.iter().enumerate().map(|(i, (name, [dot, ring]))| StripDot {
        x: rounded(left + (i as f64 + 0.5) * gap),
        low: axis.at(*dot),
        high: axis.at(*ring),
        title: format!("{name}: {dot:.0e} at the median state, {ring:.0e} at the worst"),
    });
    let dots = dots.collect();
    rendered(&StripTemplate { title, width, height, left, right, ticks: axis.ticks(8), dots })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_their_values_in_whole_decades() {
        let axis = Axis::new([1e-3, 2.0, 0.0, f64::INFINITY].into_iter(), 0.0, 100.0);
        assert_eq!((axis.low, axis.high), (-3, 1));
        assert_eq!((axis.at(1e-3), axis.at(0.0), axis.at(10.0), axis.at(1e-1)), (0.0, 0.0, 100.0, 50.0));
        let powers: Vec<i32> =
            Axis::new([1e-24, 1.0].into_iter(), 0.0, 1.0).ticks(8).iter().map(|t| t.power).collect();
        assert_eq!(powers, [-24, -21, -18, -15, -12, -9, -6, -3, 0]);
        assert_eq!(Axis::new([1e-15].into_iter(), 0.0, 1.0).high, -14);
    }

    #[test]
    fn a_wrong_entry_is_marked() {
        let mut comparison = Comparison::default();
        let fine = crate::audit::Compared { got: 1.0, want: 1.0, tolerance: 1e-15, units: 0.0 };
        let mut row = [crate::audit::Compared { got: 0.0, want: 0.0, ..fine }; DOFS];
        (row[0], row[4]) = (fine, crate::audit::Compared { got: 0.0, units: f64::INFINITY, ..fine });
        comparison.0[3] = Some(row);
        let svg = heat("<x>", &comparison, Place::File);
        assert!(svg.contains("&#60;x&#62;") && svg.contains("<style>"), "{svg}");
        let count = |what: &str| svg.matches(what).count();
        assert_eq!(
            (count("class=\"bad\""), count("class=\"h0\""), count("class=\"zero\"")),
            (1, 1, 10),
            "{svg}"
        );
        assert!(svg.contains("∂ur1/∂θa2 = 0e0, must be 1e0"), "{svg}");
    }
}
