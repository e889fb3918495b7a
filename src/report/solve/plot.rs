//! Curves over time, with what sticks shaded and events marked.

use crate::audit::html::figure::{Medium, rendered};
use askama::Template;

/// The style of such plots: a page gives the colours.
pub(super) const STYLE: &str = include_str!("templates/panels.css");

/// The most points of a curve on a page, and in a file, which stays small.
const POINTS: [usize; 2] = [600, 130];

const WIDTH: f64 = 720.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 706.0;
const TOP: f64 = 28.0;
const BOTTOM: f64 = 150.0;
const HEIGHT: f64 = 176.0;

/// A quantity over time.
pub(super) struct Curve {
    pub(super) name: String,
    pub(super) points: Vec<[f64; 2]>,
    /// Whether it is the friction of a component.
    pub(super) is_friction: bool,
}

/// Curves of one unit.
pub(super) struct Plot {
    /// What is drawn upwards.
    pub(super) y_name: String,
    /// From when to when.
    pub(super) span: [f64; 2],
    pub(super) curves: Vec<Curve>,
    /// While something sticks.
    pub(super) shaded: Vec<[f64; 2]>,
    /// Events.
    pub(super) marks: Vec<(f64, String)>,
}

struct Tick {
    at: f64,
    name: String,
}

struct Line {
    colour: usize,
    points: String,
}

struct Key {
    at: f64,
    colour: usize,
    name: String,
}

struct Panel {
    shift: f64,
    y_name: String,
    shaded: Vec<[f64; 2]>,
    x_ticks: Vec<Tick>,
    y_ticks: Vec<Tick>,
    marks: Vec<Tick>,
    curves: Vec<Line>,
    keys: Vec<Key>,
}

#[derive(Template)]
#[template(path = "panels.svg", escape = "html")]
struct Panels<'a> {
    title: &'a str,
    style: Option<&'static str>,
    width: f64,
    height: f64,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    panels: Vec<Panel>,
}

fn rounded(x: f64) -> f64 {
    (x * 10.0).round() / 10.0
}

/// Round numbers in a range, some four of them, with their names.
fn ticks([low, high]: [f64; 2], wanted: f64) -> Vec<(f64, String)> {
    let rough = (high - low) / wanted;
    let power = 10.0_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= rough).unwrap_or(10.0);
    let step = factor * power;
    if !(step.is_finite() && step > 0.0) {
        return Vec::new();
    }
    let places = (-step.log10().floor()).max(0.0) as usize;
    let is_far = high.abs().max(low.abs()) >= 1e5 || places > 5;
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    let name = |x: f64| if is_far { format!("{x:.1e}") } else { format!("{x:.places$}") };
    (first..=last).map(|i| i as f64 * step).map(|x| (x, name(x).replace('-', "−"))).collect()
}

impl Plot {
    /// The time from 0 to 1 across the page.
    pub(super) const ACROSS: [f64; 2] = [LEFT, RIGHT];

    fn panel(&self, shift: f64, most: usize) -> Panel {
        let [begin, end] = self.span;
        let length = if end > begin { end - begin } else { 1.0 };
        let across = |t: f64| rounded(LEFT + (t - begin) / length * (RIGHT - LEFT));
        let all = || self.curves.iter().flat_map(|curve| &curve.points).map(|[_, y]| *y);
        let [low, high] =
            all().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)]);
        // What is rounding alone is a straight line.
        let pad = (0.08 * (high - low)).max(1e-9 * high.abs().max(low.abs())).max(1e-30);
        let pad = if high - low > 1e-9 * high.abs().max(low.abs()) { pad } else { 0.5 * high.abs().max(1.0) };
        let [low, high] = [low - pad, high + pad];
        let up = |y: f64| rounded(BOTTOM - (y - low) / (high - low) * (BOTTOM - TOP));
        let mut keys = Vec::new();
        // Names stand from the right, each as wide as it is.
        let mut at = RIGHT;
        for (i, curve) in self.curves.iter().enumerate().rev() {
            at -= 36.0 + 6.6 * curve.name.chars().count() as f64;
            keys.push(Key { at: rounded(at), colour: i % 6 + 1, name: curve.name.clone() });
        }
        let curves = self.curves.iter().enumerate().map(|(i, curve)| {
            let every = curve.points.len().div_ceil(most).max(1);
            let last = curve.points.len().saturating_sub(1);
            let kept = curve.points.iter().enumerate().filter(|(n, _)| n % every == 0 || *n == last);
            let points: Vec<String> = kept.map(|(_, [t, y])| format!("{},{}", across(*t), up(*y))).collect();
            Line { colour: i % 6 + 1, points: points.join(" ") }
        });
        let tick = |(x, name): (f64, String), place: &dyn Fn(f64) -> f64| Tick { at: place(x), name };
        Panel {
            shift,
            y_name: self.y_name.clone(),
            shaded: self
                .shaded
                .iter()
                .map(|[from, to]| [across(*from), rounded(across(*to) - across(*from))])
                .collect(),
            // The last one would stand where the name is.
            x_ticks: ticks(self.span, 8.0)
                .into_iter()
                .filter(|(t, _)| across(*t) < RIGHT - 40.0)
                .map(|of| tick(of, &across))
                .collect(),
            y_ticks: ticks([low, high], 4.0).into_iter().map(|of| tick(of, &up)).collect(),
            marks: self.marks.iter().map(|(t, name)| Tick { at: across(*t), name: name.clone() }).collect(),
            curves: curves.collect(),
            keys,
        }
    }

    /// Plots one below the other.
    pub(super) fn svg(all: &[Self], title: &str, place: Medium) -> String {
        let most = POINTS[usize::from(place == Medium::File)];
        let panels = all.iter().enumerate().map(|(i, plot)| plot.panel(i as f64 * HEIGHT, most)).collect();
        rendered(&Panels {
            title,
            style: (place == Medium::File).then_some(STYLE),
            width: WIDTH,
            height: HEIGHT * all.len() as f64,
            left: LEFT,
            right: RIGHT,
            top: TOP,
            bottom: BOTTOM,
            panels,
        })
    }
}
