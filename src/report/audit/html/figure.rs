//! Figures as SVG: plots on log axes, heat maps. In a page they take its colours, light or dark; as files they bring their own.

use crate::audit::html::labels::Area;
use crate::audit::html::prose::full_name;
use askama::Template;
use pintle_audit::{Comparison, Illustration, Subject};

/// The style of figures.
pub(crate) const STYLE: &str = include_str!("templates/figure.css");

/// Where a figure goes: into a page, or into a file of its own, which brings its style.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Medium {
    Page,
    File,
}

impl Medium {
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
    /// Where the name stands, and how it is anchored there.
    x: f64,
    y: f64,
    anchor: &'static str,
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
    heading: Vec<Line>,
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
struct Line {
    class: &'static str,
    y: f64,
    text: String,
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
    pub(crate) fn svg(&self, place: Medium) -> String {
        let (width, left, right, top) = (420.0, 48.0, 408.0, 26.0);
        // A file has nobody else to name its curves.
        let has_legend = self.has_legend || place == Medium::File;
        let mut height = if self.has_legend { 330.0 } else { 250.0 };
        let bottom = height - 44.0;
        let in_two = self.curves.iter().all(|curve| curve.name.chars().count() < 28);
        let wide = if in_two { 2 } else { 1 };
        let names: Vec<Name<'_>> = if has_legend {
            let each = self.curves.iter().enumerate();
            each.map(|(i, curve)| Name {
                x: left + (i % wide) as f64 * 180.0,
                y: height + 10.0 + (i / wide) as f64 * 16.0,
                colour: curve.colour,
                text: curve.name,
            })
            .collect()
        } else {
            Vec::new()
        };
        let axis_name = height - 4.0;
        height += names.len().div_ceil(wide) as f64 * 16.0;
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
        let curves: Vec<Drawn> = curves.collect();
        let ways: Vec<Vec<[f64; 2]>> =
            curves.iter().map(|curve| curve.dots.iter().map(|dot| [dot.x, dot.y]).collect()).collect();
        let titles = if self.heading.is_empty() && place == Medium::Page {
            Vec::new()
        } else {
            lines(self.title, width)
        };
        let mut heading: Vec<Line> = Vec::new();
        for text in titles {
            heading.push(Line { class: "label", y: 15.0 * (heading.len() + 1) as f64, text });
        }
        let first = heading.last().map_or(3.0, |line| line.y + 1.0);
        let below = self.heading.iter().enumerate();
        heading.extend(below.map(|(i, text)| Line {
            class: "tiny",
            y: first + 12.0 * (i + 1) as f64,
            text: text.clone(),
        }));
        let head = heading.last().map_or(0.0, |line| line.y + 4.0);
        let page = PlotTemplate {
            title: self.title,
            style: place.style(),
            head,
            heading,
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
            levels: self
                .levels
                .iter()
                .map(|(value, name)| level((y.at(*value), name), [left, right, top, bottom], &ways))
                .collect(),
            curves,
            names,
        };
        rendered(&page)
    }
}

/// A level with its name where it covers least of the curves: at the right or left, else between, above or below its line, and not in the name of the
/// axis.
fn level<'a>(
    (at, name): (f64, &'a str),
    [left, right, top, bottom]: [f64; 4],
    curves: &[Vec<[f64; 2]>],
) -> Level<'a> {
    const LETTER: f64 = 6.4;
    const HEIGHT: f64 = 12.0;
    const STEP: f64 = 12.0;
    /// What a dot is worth, as a length of a curve.
    const DOT: f64 = 8.0;
    const NEVER: f64 = 1e6;
    let width = name.chars().count() as f64 * LETTER;
    let [above, below] = [-4.0, 13.0];
    let ends = [
        (right - 2.0, "end", above),
        (left + 4.0, "start", above),
        (right - 2.0, "end", below),
        (left + 4.0, "start", below),
    ];
    let between = (1..)
        .map(|i| right - 2.0 - width - f64::from(i) * STEP)
        .take_while(|x| *x > left + 4.0)
        .flat_map(|x| [(x, "start", above), (x, "start", below)]);
    let cost = |(x, anchor, shift): &(f64, &str, f64)| {
        let from = if *anchor == "end" { x - width } else { *x };
        let base = at + shift;
        let area = Area([from - 4.0, base - HEIGHT, from + width + 4.0, base + 4.0]);
        let is_in = |dot: &&[f64; 2]| {
            let [left, top, right, bottom] = area.0;
            (left..=right).contains(&dot[0]) && (top..=bottom).contains(&dot[1])
        };
        let of_curve = |way: &Vec<[f64; 2]>| {
            let dots = way.iter().filter(is_in).count() as f64;
            way.windows(2).map(|ends| area.covered(&[ends[0], ends[1]])).sum::<f64>() + DOT * dots
        };
        let is_outside = base + 4.0 > bottom || (*anchor == "start" && base - HEIGHT < top);
        curves.iter().map(of_curve).sum::<f64>() + if is_outside { NEVER } else { 0.0 }
    };
    // The first of equals.
    let mut best = (f64::INFINITY, ends[0]);
    for place in ends.into_iter().chain(between) {
        let cost = cost(&place);
        if cost < best.0 {
            best = (cost, place);
        }
    }
    let (x, anchor, shift) = best.1;
    Level { at, name, x: rounded(x), y: rounded(at + shift), anchor }
}

/// A title in lines that fit into a width: broken at spaces, or where a word is longer than a line.
pub(super) fn lines(text: &str, width: f64) -> Vec<String> {
    const LETTER: f64 = 6.8;
    let most = ((width - 16.0) / LETTER) as usize;
    let mut found: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let letters: Vec<char> = word.chars().collect();
        for part in letters.chunks(most.max(1)) {
            let part: String = part.iter().collect();
            match found.last_mut() {
                Some(line) if line.chars().count() + 1 + part.chars().count() <= most => {
                    line.push(' ');
                    line.push_str(&part);
                }
                _ => found.push(part),
            }
        }
    }
    found
}

/// A template with its values in it. Writing to a text does not fail.
pub(crate) fn rendered(template: &impl Template) -> String {
    template.render().unwrap_or_default()
}

/// A connector and its state; a state of a scene names its connector by itself.
pub(super) fn title(shown: &Illustration) -> String {
    let Illustration { scene, subject, state, .. } = shown;
    match scene {
        Some(scene) => format!("{scene}: {state}"),
        None => format!("{subject}, {state}"),
    }
}

/// Errors of ∂f·v against the step.
pub(super) fn steps(shown: &Illustration, place: Medium) -> String {
    let plot = LogPlot {
        title: &match place {
            Medium::Page => format!("{}: error of ∂f·v against the step", shown.subject),
            Medium::File => format!("{}: error of ∂f·v against the step", title(shown)),
        },
        heading: Vec::new(),
        x_name: "step h",
        y_name: "error, tolerances",
        curves: vec![
            Curve {
                name: "Taylor remainder / h, 237 bits",
                is_main: false,
                colour: 1,
                points: shown.steps.remainder.clone(),
            },
            Curve {
                name: "central difference, doubles",
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

/// The colours of errors, with what they mean.
const KEY: [(&str, &str); 7] = [
    ("zero", "zero"),
    ("h0", "exact"),
    ("h1", "< 0.01"),
    ("h2", "< 0.1"),
    ("h3", "< 0.5"),
    ("h4", "≤ 1"),
    ("bad", "✗ beyond"),
];

struct Key {
    x: f64,
    y: f64,
    class: &'static str,
    name: &'static str,
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
    /// The height above the columns.
    top: f64,
    heading: Vec<Line>,
    heads: Vec<Head>,
    rows: Vec<Head>,
    cells: Vec<Cell>,
    keys: Vec<Key>,
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
pub(super) fn heat(title: &str, comparison: &Comparison, place: Medium) -> String {
    const SIZE: [f64; 2] = [24.0, 20.0];
    const GAP: f64 = 2.0;
    const BETWEEN_BLOCKS: f64 = 7.0;
    let mut heads: Vec<Head> = Vec::new();
    let mut columns: Vec<(usize, f64)> = Vec::new();
    let mut x = 42.0;
    for (i, block) in comparison.blocks().into_iter().enumerate() {
        x += if i > 0 { BETWEEN_BLOCKS } else { 0.0 };
        for j in block {
            heads.push(Head { x: x + SIZE[0] / 2.0, y: 12.0, name: comparison.columns[j].clone() });
            columns.push((j, x));
            x += SIZE[0] + GAP;
        }
    }
    let (mut rows, mut cells, mut y) = (Vec::new(), Vec::new(), 18.0);
    for (of_row, row) in &comparison.rows {
        rows.push(Head { x: 36.0, y: y + 14.0, name: of_row.clone() });
        for (j, x) in &columns {
            let (Some(entry), Some(column)) = (row.get(*j), comparison.columns.get(*j)) else { continue };
            let is_plain = entry.got == 0.0 && entry.units == 0.0;
            let title = (!is_plain).then(|| {
                format!(
                    "∂{}/∂{} = {:e}, must be {:e}: {:.3e} tolerances of {:.2e}",
                    of_row,
                    column,
                    entry.got + 0.0,
                    entry.want + 0.0,
                    entry.units,
                    entry.tolerance
                )
            });
            let class = if entry.is_zero() { "zero" } else { class(entry.units) };
            let mark = (class == "bad").then_some("✗");
            cells.push(Cell { x: *x, y, w: SIZE[0], h: SIZE[1], class, title, mark });
        }
        y += SIZE[1] + GAP;
    }
    let (width, mut height) = (x + 2.0, y + 2.0);
    let (mut heading, mut keys) = (Vec::new(), Vec::new());
    if place == Medium::File {
        for text in lines(title, width) {
            heading.push(Line { class: "label", y: 14.0 * (heading.len() + 1) as f64, text });
        }
        const KEY_WIDTH: f64 = 66.0;
        let in_line = ((width / KEY_WIDTH) as usize).max(1);
        keys.extend(KEY.iter().enumerate().map(|(i, (class, name))| Key {
            x: 8.0 + (i % in_line) as f64 * KEY_WIDTH,
            y: height + 26.0 + (i / in_line) as f64 * 18.0,
            class,
            name,
        }));
        height = keys.last().map_or(height, |key| key.y + 18.0);
    }
    let page = HeatTemplate {
        title,
        style: place.style(),
        width,
        height,
        most: (1.12 * x).round(),
        top: heading.last().map_or(0.0, |line| line.y + 8.0),
        heading,
        heads,
        rows,
        cells,
        keys,
    };
    rendered(&page)
}

struct StripDot {
    x: f64,
    low: f64,
    high: f64,
    title: String,
    /// Where there is room for it.
    name: Option<String>,
}

#[derive(Template)]
#[template(path = "strip.svg", escape = "html")]
struct StripTemplate<'a> {
    title: &'a str,
    style: Option<&'static str>,
    width: f64,
    height: f64,
    /// What a file has above and below the axes.
    head: f64,
    foot: f64,
    left: f64,
    right: f64,
    ticks: Vec<Tick>,
    dots: Vec<StripDot>,
}

/// Pairs of positive numbers by name, side by side on one log axis: the first a dot, the second a ring. A file names what stands where,
/// as far as there is room.
pub(super) fn strip(title: &str, all: &[(&Subject, [f64; 2])], place: Medium) -> String {
    /// More names than that are no names any more.
    const NAMED: usize = 80;
    let (width, height, left, right) = (1000.0, 190.0, 48.0, 992.0);
    let axis = Axis::new(all.iter().flat_map(|(_, pair)| *pair), height - 12.0, 12.0);
    let gap = (right - left) / all.len().max(1) as f64;
    let is_named = place == Medium::File && all.len() <= NAMED;
    // One scene is named once, in the title.
    let scene = all.first().and_then(|(subject, _)| subject.scene.as_deref());
    let is_of_it = |(subject, _): &(&Subject, _)| subject.scene.as_deref() == scene;
    let scene = scene.filter(|_| place == Medium::File && all.iter().all(is_of_it));
    let title = &scene.map_or_else(|| title.to_string(), |scene| format!("{scene}: {title}"));
    let short = |subject: &Subject| if scene.is_some() { subject.name.clone() } else { full_name(subject) };
    let dots = all.iter().enumerate().map(|(i, (subject, [dot, ring]))| StripDot {
        x: rounded(left + (i as f64 + 0.5) * gap),
        low: axis.at(*dot),
        high: axis.at(*ring),
        title: format!("{}: {dot:.0e} at the median state, {ring:.0e} at the worst", full_name(subject)),
        name: is_named.then(|| short(subject)),
    });
    let dots: Vec<StripDot> = dots.collect();
    let longest =
        dots.iter().flat_map(|dot| &dot.name).map(|name| name.chars().count()).max().unwrap_or_default();
    let (head, foot) = if place == Medium::File { (44.0, 10.0 + 5.8 * longest as f64) } else { (0.0, 0.0) };
    rendered(&StripTemplate {
        title,
        style: place.style(),
        width,
        height,
        head,
        foot,
        left,
        right,
        ticks: axis.ticks(8),
        dots,
    })
}

/// A bin of a histogram: how full by decades of the share, 0 for none, where it begins, how many.
pub(super) struct Bin {
    pub(super) depth: usize,
    pub(super) from: String,
    pub(super) count: String,
}

/// A histogram: what it is of, and its bins.
pub(super) struct Map {
    pub(super) name: String,
    pub(super) bins: Vec<Bin>,
    pub(super) largest: String,
}

struct Box {
    x: f64,
    y: f64,
    w: f64,
    depth: usize,
    count: String,
    from: String,
}

struct Strip {
    y: f64,
    name: String,
    boxes: Vec<Box>,
}

#[derive(Template)]
#[template(path = "coverage.svg", escape = "html")]
struct CoverageTemplate<'a> {
    title: &'a str,
    style: Option<&'static str>,
    width: f64,
    height: f64,
    heading: Vec<Line>,
    strips: Vec<Strip>,
    keys: Vec<Key>,
}

/// The histograms of a scene, one below the other, as a file of its own.
pub(super) fn coverage(title: &str, maps: &[Map]) -> String {
    const EACH: f64 = 66.0;
    let (width, left) = (1000.0, 16.0);
    let mut heading: Vec<Line> = Vec::new();
    for text in lines(title, width) {
        heading.push(Line { class: "label", y: 20.0 + 14.0 * heading.len() as f64, text });
    }
    let head = heading.last().map_or(20.0, |line| line.y) + 20.0;
    let strips: Vec<Strip> = maps
        .iter()
        .enumerate()
        .map(|(n, map)| {
            let y = head + n as f64 * EACH;
            let w = (width - 2.0 * left) / map.bins.len().max(1) as f64;
            let place = |i: usize| rounded(left + i as f64 * w);
            let boxes = map.bins.iter().enumerate().map(|(i, bin)| Box {
                x: place(i),
                y: y + 8.0,
                w: rounded(w - 2.0),
                depth: bin.depth,
                count: bin.count.clone(),
                from: bin.from.clone(),
            });
            Strip { y, name: format!("{}; largest {}", map.name, map.largest), boxes: boxes.collect() }
        })
        .collect();
    let y = head + maps.len() as f64 * EACH;
    let shares =
        [("m0", "none"), ("m1", "< 1 % of the samples"), ("m2", "< 10 %"), ("m3", "< 50 %"), ("m4", "more")];
    let keys = shares.into_iter().enumerate();
    let keys = keys.map(|(i, (class, name))| Key { x: left + i as f64 * 180.0, y, class, name });
    rendered(&CoverageTemplate {
        title,
        style: Medium::File.style(),
        width,
        height: y + 26.0,
        heading,
        strips,
        keys: keys.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use pintle_kinematics::node::{DOF, DOFS};

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

    /// A curve with few dots crosses the name all the same: at both ends here, above and below, so that it stands between.
    #[test]
    fn names_of_levels_are_not_struck_through() {
        let frame = [0.0, 400.0, 0.0, 200.0];
        let across = vec![[0.0, 60.0], [0.0, 140.0], [60.0, 70.0], [60.0, 130.0]];
        let down = vec![[300.0, 60.0], [400.0, 140.0], [300.0, 140.0], [400.0, 60.0]];
        let placed =
            level(("tolerance".len() as f64 + 91.0, "tolerance"), frame, &[across.clone(), down.clone()]);
        let from = if placed.anchor == "end" { placed.x - 58.0 } else { placed.x };
        let area = Area([from, placed.y - 12.0, from + 58.0, placed.y + 4.0]);
        for way in [across, down] {
            let covered: f64 = way.windows(2).map(|ends| area.covered(&[ends[0], ends[1]])).sum();
            assert_eq!(covered, 0.0, "{from} {}", placed.y);
        }
    }

    #[test]
    fn a_wrong_entry_is_marked() {
        let mut comparison = Comparison::default();
        let fine = pintle_audit::Compared { got: 1.0, want: 1.0, tolerance: 1e-15, units: 0.0 };
        let mut row = [pintle_audit::Compared { got: 0.0, want: 0.0, ..fine }; DOFS];
        (row[0], row[4]) = (fine, pintle_audit::Compared { got: 0.0, units: f64::INFINITY, ..fine });
        comparison.columns = DOF.map(String::from).to_vec();
        comparison.rows = vec![("ur1".to_string(), row.to_vec())];
        let svg = heat("<x>", &comparison, Medium::File);
        assert!(svg.contains("&#60;x&#62;") && svg.contains("<style>"), "{svg}");
        let count = |what: &str| svg.matches(what).count();
        assert_eq!(
            (count("class=\"bad\""), count("class=\"h0\""), count("class=\"zero\"")),
            (1, 1, 10),
            "{svg}"
        );
        assert!(svg.contains("∂ur1/∂θa2 = 0e0, must be 1e0"), "{svg}");
        // Its title and what its colours mean stand in the file.
        assert!(svg.contains("<text class=\"label\"") && svg.contains(">✗ beyond</text>"), "{svg}");
    }

    /// What a formula makes zero to rounding is no error, and no dependence; what should be far from zero is.
    #[test]
    fn what_is_zero_to_rounding_is_shown_as_zero() {
        let mut comparison = Comparison::default();
        let zero = pintle_audit::Compared { got: 0.0, want: 0.0, tolerance: 1e-15, units: 0.0 };
        let mut row = [zero; DOFS];
        row[3] = pintle_audit::Compared { want: -2e-17, units: 0.02, ..zero };
        row[4] = pintle_audit::Compared { got: 3e-16, want: -3e-16, units: 0.6, ..zero };
        row[5] = pintle_audit::Compared { want: 2e-15, units: 2.0, ..zero };
        row[0] = pintle_audit::Compared { got: 1.0, want: 1.0 + 3e-16, units: 0.3, ..zero };
        comparison.columns = DOF.map(String::from).to_vec();
        comparison.rows = vec![("u1".to_string(), row.to_vec())];
        let svg = heat("AXIAL", &comparison, Medium::Page);
        let count = |what: &str| svg.matches(what).count();
        assert_eq!(
            [count("\"zero\""), count("\"bad\""), count("\"h3\""), count("\"h1\"")],
            [10, 1, 1, 0],
            "{svg}"
        );
        assert!(svg.contains("must be -2e-17"), "the digits are still to be seen: {svg}");
    }

    #[test]
    fn long_titles_are_broken_into_lines() {
        let found = lines(&format!("of {} at state 3", "x".repeat(90)), 420.0);
        assert!(found.len() == 3 && found.iter().all(|line| line.chars().count() <= 59), "{found:?}");
        assert_eq!(found.concat().replace(' ', "").len(), 2 + 90 + 8);
    }
}
