//! Why a series is not what it must be: a cause must explain every point of it.

use crate::evaluate::{Key, Known, Of};
use crate::judge::{Point, Series};
use pintle_kinematics::connector::Output;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::dot;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// What else the connectors of the files give, frame by frame: what a series may be in place of what it is called.
#[derive(Debug, Default)]
pub(crate) struct Alternatives {
    frames: Vec<(f64, Frame)>,
}

/// The numbers of one frame by their names, and what each may be besides.
#[derive(Debug, Default)]
struct Frame {
    numbers: BTreeMap<Key, f64>,
    variants: BTreeMap<Key, Vec<(String, f64)>>,
}

impl Alternatives {
    /// Takes what is known at a time, of some elements.
    pub(crate) fn add(&mut self, at: f64, known: Known, keeps: impl Fn(&str) -> bool) {
        let mut numbers = BTreeMap::new();
        for (element, of) in known.elements.into_iter().filter(|(element, _)| keeps(element)) {
            numbers.extend(
                of.values.into_iter().map(|((output, k), x)| ((element.clone(), Of::Output(output, k)), x)),
            );
        }
        self.frames.push((at, Frame { numbers, variants: known.variants }));
    }

    /// A number along the points of a series; `None` where one of them has it not.
    fn along(&self, series: &Series, of: impl Fn(&Frame) -> Option<f64>) -> Option<Vec<f64>> {
        let mut frames = self.frames.iter().peekable();
        let along = series.points.iter().map(|point| {
            while frames.peek().is_some_and(|(at, _)| *at < point.at) {
                frames.next();
            }
            let (_, all) = frames.peek().filter(|(at, _)| *at == point.at)?;
            of(all)
        });
        along.collect()
    }

    fn first(&self) -> Option<&Frame> {
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
pub(crate) fn explain(
    series: &Series,
    siblings: [Option<&Series>; 3],
    alternatives: &Alternatives,
) -> Option<String> {
    let found =
        single(series, alternatives).or_else(|| direction(series, siblings)).or_else(|| fallback(series))?;
    let (first, last) = (series.points.first()?.at, series.points.last()?.at);
    let is_part = (series.points.len() as u64) < series.compared;
    Some(if is_part { format!("{found} (seen from {first} to {last})") } else { found })
}

/// What explains the series by itself, or as another one.
fn single(series: &Series, alternatives: &Alternatives) -> Option<String> {
    for (factor, words) in FACTORS {
        let is_zero = factor == 0.0 && series.points.iter().all(|point| point.got == 0.0);
        if is_zero || factor != 0.0 && all(series, |_, point| factor * point.want) {
            return Some(words.to_string());
        }
    }
    other(series, alternatives).or_else(|| turned(series)).or_else(|| moved(series))
}

/// Another output of the same connector, or of another one; along other axes, about another point.
fn other(series: &Series, alternatives: &Alternatives) -> Option<String> {
    let of = series.of?;
    let own = (series.element.clone(), of);
    let first = alternatives.first()?;
    let is_it = |along: &Option<Vec<f64>>, sign: f64| {
        along.as_ref().is_some_and(|along| all(series, |n, _| sign * along[n]))
    };
    const SIGNS: [(f64, &str); 2] = [(1.0, ""), (-1.0, ", with the opposite sign")];
    let same = first.numbers.keys().filter(|(element, _)| *element == series.element);
    let others = first.numbers.keys().filter(|(element, is)| *element != series.element && *is == of);
    for key in same.chain(others).filter(|key| **key != own) {
        let along = alternatives.along(series, |frame| frame.numbers.get(key).copied());
        let name = key.1.name();
        for (sign, told) in SIGNS {
            if is_it(&along, sign) {
                let is_same = (key.0 == series.element, key.1.place() == of.place());
                return Some(match is_same {
                    (true, true) => format!("it is {name}{told}, not {}", series.name),
                    (true, false) => format!("it is {name}{told}: components are exchanged"),
                    (false, _) => format!("it is that of element {}{told}", key.0),
                });
            }
        }
    }
    for (n, (words, _)) in first.variants.get(&own).into_iter().flatten().enumerate() {
        let along = alternatives.along(series, |frame| {
            frame.variants.get(&own)?.get(n).filter(|(known, _)| known == words).map(|(_, x)| *x)
        });
        for (sign, told) in SIGNS {
            if is_it(&along, sign) {
                return Some(format!("{words}{told}"));
            }
        }
    }
    None
}

/// Whole turns from some time on.
fn turned(series: &Series) -> Option<String> {
    let points = &series.points;
    let first = points.iter().find(|point| point.is_wrong())?;
    let turns = |point: &Point| ((point.got - point.want) / TAU).round();
    if !series.is_angle() || !all(series, |_, point| point.want + TAU * turns(point)) {
        return None;
    }
    let count = turns(first);
    let whole = if count.abs() == 1.0 {
        "a whole turn is".to_string()
    } else {
        format!("{} whole turns are", count.abs())
    };
    let lost = if count * first.want.signum() < 0.0 { "lost" } else { "too much" };
    let principal = points.iter().all(|point| point.got.abs() <= PI + point.allowed);
    let also = if principal { "; the values are principal, from −π to π" } else { "" };
    Some(format!("{whole} {lost} from {} on{also}", first.at))
}

/// An increment early or late, an offset, a factor.
fn moved(series: &Series) -> Option<String> {
    let points = &series.points;
    let first = points.iter().find(|point| point.is_wrong())?;
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
    let offset = first.got - first.want;
    if points.len() > 2 && points.iter().all(|point| near(first, point, point.want + offset)) {
        let is_flat = points.iter().all(|point| is(point, points[0].got));
        if !is_flat {
            return Some(format!(
                "a constant {offset:.6} is added: an initial value or a reference is subtracted otherwise"
            ));
        }
    }
    let largest = points.iter().max_by(|one, other| one.want.abs().total_cmp(&other.want.abs()))?;
    let factor = largest.got / largest.want;
    let is_it = factor.is_finite()
        && points.len() > 2
        && points.iter().all(|point| near(largest, point, factor * point.want));
    is_it.then(|| format!("it is {factor:.6} times what it must be"))
}

/// A vector of the right size in another direction.
fn direction(series: &Series, siblings: [Option<&Series>; 3]) -> Option<String> {
    let there: Vec<&Series> = siblings.into_iter().flatten().collect();
    let is_beside = |of: &&Series| of.points.len() == series.points.len();
    if there.len() < 2 || !there.iter().all(is_beside) || series.points.len() < 3 {
        return None;
    }
    let mut angles: Vec<f64> = Vec::new();
    for n in 0..series.points.len() {
        let (mut got, mut want, mut allowed) = ([0.0; 3], [0.0; 3], 0.0);
        for (i, of) in there.iter().enumerate() {
            let point = of.points[n];
            if point.at != series.points[n].at {
                return None;
            }
            (got[i], want[i]) = (point.got, point.want);
            allowed += point.allowed;
        }
        let sizes = [norm(got), norm(want)];
        if (sizes[0] - sizes[1]).abs() > 2.0 * allowed + 1e-12 * sizes[1] {
            return None;
        }
        if sizes[1] > 100.0 * allowed {
            angles.push((dot(got, want) / sizes[0] / sizes[1]).clamp(-1.0, 1.0).acos().to_degrees());
        }
    }
    let (least, most) =
        angles.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    if angles.len() < 3 || most < 1e-3 {
        return None;
    }
    let names: Vec<&str> = there.iter().map(|of| of.name.as_str()).collect();
    let is_friction = matches!(series.of, Some(Of::Output(Output::CSF, _)));
    let what = if is_friction { "friction" } else { "a vector" };
    let by = if most - least < 1e-3 * most {
        format!("{most:.3}°")
    } else {
        format!("{least:.3}° to {most:.3}°")
    };
    Some(format!("{} are {what} of the right size in another direction, {by} away", names.join(", ")))
}

/// When it begins: all that follows is wrong.
fn fallback(series: &Series) -> Option<String> {
    let points = &series.points;
    let first = points.iter().position(Point::is_wrong).filter(|first| *first > 0)?;
    if series.since > series.wrong || series.wrong == 1 {
        return None;
    }
    Some(format!("it is right up to {}, and wrong from {} on", points[first - 1].at, points[first].at))
}
