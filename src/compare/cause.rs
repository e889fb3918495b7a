//! Why a series is not what it must be: a cause must explain every point of it.

use crate::judge::{Point, Series};
use crate::walk::name_of;
use pintle_kinematics::connector::Output;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// All numbers of one connector at one time.
type Numbers = BTreeMap<(Output, usize), f64>;

/// What else the connectors of the files give, frame by frame: what a series may be in place of what it is called.
#[derive(Debug, Default)]
pub(crate) struct Alternatives {
    frames: Vec<(f64, BTreeMap<String, Numbers>)>,
}

impl Alternatives {
    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }

    pub(crate) fn add(&mut self, at: f64, all: impl Iterator<Item = (String, Numbers)>) {
        self.frames.push((at, all.collect()));
    }

    /// Another output along the points of a series; `None` where one of them has it not.
    fn along(&self, series: &Series, element: &str, of: (Output, usize)) -> Option<Vec<f64>> {
        let mut found = Vec::new();
        let mut frames = self.frames.iter().peekable();
        for point in &series.points {
            while frames.peek().is_some_and(|(at, _)| *at < point.at) {
                frames.next();
            }
            let (_, all) = frames.peek().filter(|(at, _)| *at == point.at)?;
            found.push(*all.get(element)?.get(&of)?);
        }
        Some(found)
    }

    fn others(&self) -> Option<&BTreeMap<String, Numbers>> {
        self.frames.first().map(|(_, all)| all)
    }
}

/// Factors that have a name.
const FACTORS: [(f64, &str); 11] = [
    (-1.0, "the sign is the opposite: forces on the other side, or the nodes exchanged"),
    (180.0 / PI, "it is in degrees"),
    (-180.0 / PI, "it is in degrees, with the opposite sign"),
    (PI / 180.0, "it was turned from degrees into radians twice"),
    (1e3, "it is in a unit a thousandth of the scene's, as mm are of m"),
    (1e-3, "it is in a unit a thousand times the scene's, as m are of mm"),
    (1.0 / 0.0254, "it is in inches, and the scene in m"),
    (1.0 / 25.4, "it is in inches, and the scene in mm"),
    (2.0, "it is counted twice"),
    (0.5, "it is half of what it must be"),
    (0.0, "it is zero throughout"),
];

/// Whether a point is right, were another number wanted.
fn is(point: &Point, want: f64) -> bool {
    (point.got - want).abs() <= 2.0 * point.allowed + 1e-12 * want.abs()
}

/// Whether every point is what another series says, and that says anything.
fn all(series: &Series, want: impl Fn(usize, &Point) -> f64) -> bool {
    // A number that is as good as zero tells nothing.
    let tells = |point: &Point| point.got.abs() > 10.0 * point.allowed;
    let points = || series.points.iter().enumerate();
    points().all(|(n, point)| is(point, want(n, point)))
        && (points().any(|(_, point)| tells(point)) || points().any(|(n, point)| want(n, point) == 0.0))
}

/// The cause of a series, in a sentence.
pub(crate) fn explain(series: &Series, alternatives: &Alternatives) -> Option<String> {
    let points = &series.points;
    let first_wrong = points.iter().position(Point::is_wrong)?;
    let k = series.component;
    for (factor, words) in FACTORS {
        let is_zero = factor == 0.0 && points.iter().all(|point| point.got == 0.0);
        if is_zero || factor != 0.0 && all(series, |_, point| factor * point.want) {
            return Some(words.to_string());
        }
    }
    // Another output of the same connector, or of another one.
    let known = alternatives.others()?;
    let of_same = known
        .get(&series.element)
        .into_iter()
        .flat_map(|numbers| numbers.keys().map(|of| (&series.element, *of)));
    let of_others = known
        .iter()
        .filter(|(element, _)| **element != series.element)
        .flat_map(|(element, numbers)| numbers.keys().map(move |of| (element, *of)));
    for (element, of) in of_same.chain(of_others) {
        let other = name_of(of.0, of.1);
        let is_itself = *element == series.element && other == series.name;
        if is_itself || *element != series.element && other != series.name {
            continue;
        }
        let Some(along) = alternatives.along(series, element, of) else { continue };
        for (sign, told) in [(1.0, ""), (-1.0, " with the opposite sign")] {
            if all(series, |n, _| sign * along[n]) {
                return Some(match (*element == series.element, of.1 == k) {
                    (true, true) => format!("it is {other}{told}, not {}", series.name),
                    (true, false) => format!("it is {other}{told}: components are exchanged"),
                    (false, _) => format!("it is that of element {element}{told}"),
                });
            }
        }
    }
    // Whole turns from some time on.
    let turns = |point: &Point| ((point.got - point.want) / TAU).round();
    let is_angle = series.name.contains('R') && !series.name.starts_with("CRF");
    if is_angle && all(series, |_, point| point.want + TAU * turns(point)) {
        let count = turns(&points[first_wrong]);
        let whole = if count.abs() == 1.0 {
            "a whole turn is".to_string()
        } else {
            format!("{} whole turns are", count.abs())
        };
        let lost = if count * points[first_wrong].want.signum() < 0.0 { "lost" } else { "too much" };
        let from = points[first_wrong].at;
        let principal = points.iter().all(|point| point.got.abs() <= PI + point.allowed);
        let also = if principal { "; the values are principal, from −π to π" } else { "" };
        return Some(format!("{whole} {lost} from {from} on{also}"));
    }
    for (by, words) in [(1_isize, "it is one increment early"), (-1, "it is one increment late")] {
        let shifted = |n: usize| n.checked_add_signed(by).and_then(|m| points.get(m)).map(|point| point.want);
        if points.len() > 3 && all(series, |n, point| shifted(n).unwrap_or(point.got)) {
            return Some(words.to_string());
        }
    }
    // A constant tells no offset from a factor.
    if points.len() > 2
        && all(series, |_, _| points[0].got)
        && points.iter().all(|point| (point.want - points[0].want).abs() <= 2.0 * point.allowed)
    {
        let by = points[0].got - points[0].want;
        return Some(format!("both are constant, {by:.6} apart: an offset and a factor are the same here"));
    }
    // What is found from one point has the digits of that point.
    let near = |from: &Point, point: &Point, want: f64| {
        (point.got - want).abs() <= 2.0 * (point.allowed + from.allowed)
    };
    let offset = points[first_wrong].got - points[first_wrong].want;
    if points.len() > 2 && points.iter().all(|point| near(&points[first_wrong], point, point.want + offset)) {
        let is_flat = points.iter().all(|point| is(point, points[0].got));
        if !is_flat {
            return Some(format!(
                "a constant {offset:.6} is added: an initial value or a reference is subtracted otherwise"
            ));
        }
    }
    let largest = points.iter().max_by(|one, other| one.want.abs().total_cmp(&other.want.abs()))?;
    let factor = largest.got / largest.want;
    if factor.is_finite()
        && points.len() > 2
        && points.iter().all(|point| near(largest, point, factor * point.want))
    {
        return Some(format!("it is {factor:.6} times what it must be"));
    }
    (first_wrong > 0).then(|| {
        format!(
            "it is right up to {}, and wrong from {} on",
            points[first_wrong - 1].at,
            points[first_wrong].at
        )
    })
}
