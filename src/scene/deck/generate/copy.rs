//! `*NFILL`, `*NCOPY` and `*ELCOPY`: nodes between and beside others, and elements with numbers counted on.

use crate::deck::assembly::placement;
use crate::deck::sets::SetBuilder;
use crate::deck::{Deck, generate};
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::label::Label;
use crate::label::MAX_LABEL;
use crate::lexer::{Item, Keyword};
use crate::orientation::{cross, minus};
use crate::span::Span;
use crate::written::Placement;

/// A whole number with a sign.
fn signed(item: &Item<'_>, what: &str) -> Result<i64> {
    let value = item.number()?;
    if value.fract() == 0.0 && value.abs() <= MAX_LABEL as f64 {
        return Ok(value as i64);
    }
    let message = format!("{what} must be a whole number, but is `{}`", item.text);
    Err(Diagnostic::error(Code::MalformedInteger, item.span, message, "expected a whole number")
        .help("write digits only"))
}

/// A number counted on by `step` for `times` times.
fn counted(number: u64, times: u64, step: i64, span: Span) -> Result<u64> {
    let by = i64::try_from(times).ok().and_then(|times| step.checked_mul(times));
    let label =
        by.and_then(|by| number.checked_add_signed(by)).filter(|label| (1..=MAX_LABEL).contains(label));
    label.ok_or_else(|| {
        let message = "generated numbers must be from 1 to 2^53";
        Diagnostic::error(Code::BadLabel, span, message, "out of range").help("use smaller increments")
    })
}

/// How far along its line each node lies, from 0 to 1: adjacent distances have the ratio `bias`, in pairs with `two_step`.
fn fractions(intervals: u64, bias: f64, two_step: bool, singular: Option<u64>) -> Vec<f64> {
    let length = |index: u64| bias.powf(-((if two_step { index / 2 } else { index }) as f64));
    let total: f64 = (0..intervals).map(length).sum();
    let mut sum = 0.0;
    let mut fractions: Vec<f64> = (0..intervals)
        .map(|index| {
            let here = if bias == 1.0 { index as f64 / intervals as f64 } else { sum / total };
            sum += length(index);
            here
        })
        .collect();
    fractions.push(1.0);
    let last = fractions.len() - 1;
    if last >= 2 {
        match singular {
            Some(1) => fractions[1] = fractions[2] / 4.0,
            Some(2) => fractions[last - 1] = 1.0 - (1.0 - fractions[last - 2]) / 4.0,
            _ => {}
        }
    }
    fractions
}

pub(in crate::deck) fn fill(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let set = keyword.name_of("NSET")?;
    let bias = keyword.number("BIAS")?.unwrap_or(1.0);
    let two_step = keyword.has("TWO STEP");
    let singular = keyword.get("SINGULAR").map(|value| value.integer("SINGULAR")).transpose()?;
    if bias <= 0.0 {
        let message = format!("BIAS is the ratio of two lengths, but is {bias}");
        return Err(Diagnostic::error(Code::NumberOutOfRange, keyword.span, message, "must be positive")
            .help("give a BIAS larger than 0"));
    }
    while let Some(line) = deck.lexer.row()? {
        let span = line.span;
        let mut items = line.items();
        let bounds = [items.need("the first node set")?.name()?, items.need("the last node set")?.name()?];
        let intervals = items.need("the number of intervals")?.integer("the number of intervals")?;
        let step = items.maybe().map_or(Ok(1), |item| signed(&item, "the increment"))?;
        items.end("two node sets, the number of intervals and the increment")?;
        if intervals == 0 || step == 0 {
            let message = "no nodes lie between the two sets";
            return Err(Diagnostic::error(Code::GenerateRange, span, message, "this line")
                .help("give a number of intervals and an increment other than 0"));
        }
        let [first, last] = bounds;
        let (first, last) = (deck.nodes_now(&first)?, deck.nodes_now(&last)?);
        let pairs = first.len().min(last.len()) as u64;
        deck.count_generated(pairs.saturating_mul(intervals), span)?;
        let fractions = fractions(intervals, bias, two_step, singular);
        for (a, b) in first.into_iter().zip(last) {
            let (Some(from), Some(to)) = (deck.place_of(a), deck.place_of(b)) else { continue };
            let mut made = Vec::new();
            for (index, t) in (0..).zip(&fractions).skip(1).take(fractions.len().saturating_sub(2)) {
                let label = counted(a, index, step, span)?;
                deck.add_generated(label, std::array::from_fn(|k| from[k] + t * (to[k] - from[k])), span)?;
                made.push(label);
            }
            if let Some(name) = &set {
                let set =
                    deck.node_sets.entry(name.value.clone()).or_insert_with(|| SetBuilder::new(name.span));
                for label in [a].into_iter().chain(made).chain([b]) {
                    set.push_defined(label, span);
                }
            }
        }
    }
    Ok(())
}

/// What takes a node to its copy.
enum Image {
    Moved(Placement),
    /// Through the line from a point along a unit vector.
    AcrossLine([f64; 3], [f64; 3]),
    /// Through the plane of a point and a unit normal.
    AcrossPlane([f64; 3], [f64; 3]),
    /// Through a point.
    AcrossPoint([f64; 3]),
    /// Away from a pole, as far again.
    FromPole([f64; 3]),
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Image {
    fn of(&self, x: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Moved(placement) => placement.point(x),
            Self::AcrossLine(a, e) => {
                let along = dot(minus(x, *a), *e);
                std::array::from_fn(|k| 2.0 * (a[k] + along * e[k]) - x[k])
            }
            Self::AcrossPlane(a, n) => {
                let height = dot(minus(x, *a), *n);
                std::array::from_fn(|k| x[k] - 2.0 * height * n[k])
            }
            Self::AcrossPoint(a) => std::array::from_fn(|k| 2.0 * a[k] - x[k]),
            Self::FromPole(pole) => std::array::from_fn(|k| 2.0 * x[k] - pole[k]),
        }
    }

    fn read(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<Self> {
        let reflect = keyword.word("REFLECT", &["LINE", "MIRROR", "POINT"])?;
        if reflect.is_none() && !keyword.has("POLE") {
            return placement(deck).map(Self::Moved);
        }
        let missing = || {
            Diagnostic::error(
                Code::MissingData,
                keyword.span,
                "*NCOPY has no data line",
                "a data line should follow",
            )
            .help("give the points that define the reflection, or the pole")
        };
        let Some(line) = deck.lexer.row()? else { return Err(missing()) };
        let span = line.span;
        let mut items = line.items();
        if reflect.is_none() {
            let node = items.maybe().map(|item| item.label("the pole")).transpose()?;
            let given = items.vector()?;
            let known = node.and_then(|node| deck.scene.nodes.get(&node));
            return Ok(Self::FromPole(known.map_or(given, |node| node.coordinates)));
        }
        let a = items.vector()?;
        if reflect == Some("POINT") {
            return Ok(Self::AcrossPoint(a));
        }
        let b = minus(items.vector()?, a);
        let vector = if reflect == Some("LINE") {
            b
        } else {
            let Some(line) = deck.lexer.row()? else { return Err(missing()) };
            cross(b, minus(line.items().vector()?, a))
        };
        let length = vector[0].hypot(vector[1]).hypot(vector[2]);
        if !(length > 0.0 && length.is_finite()) {
            let message = "the points of the reflection coincide, or lie on one line";
            return Err(Diagnostic::error(Code::DegenerateRotation, span, message, "no line or plane")
                .help("give two different points of a line, or three points of a plane"));
        }
        let unit = vector.map(|part| part / length);
        Ok(if reflect == Some("LINE") { Self::AcrossLine(a, unit) } else { Self::AcrossPlane(a, unit) })
    }
}

pub(in crate::deck) fn nodes(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let whole = |name| keyword.get(name).map(|value| value.integer(name)).transpose();
    let step = whole("CHANGE NUMBER")?.unwrap_or(0);
    let times = whole("MULTIPLE")?.unwrap_or(1);
    let old = keyword.need_name("OLD SET")?;
    let set = keyword.name_of("NEW SET")?;
    let image = Image::read(deck, keyword)?;
    let span = keyword.span;
    let mut from: Vec<(u64, [f64; 3])> = Vec::new();
    for label in deck.nodes_now(&old)? {
        from.extend(deck.place_of(label).map(|place| (label, place)));
    }
    deck.count_generated(times.saturating_mul(from.len() as u64), span)?;
    // Copies of nothing are nothing, however many.
    if from.is_empty() {
        return Ok(());
    }
    let step = i64::try_from(step).unwrap_or(i64::MAX);
    for round in 1..=times {
        for (label, place) in &mut from {
            *place = image.of(*place);
            let label = counted(*label, round, step, span)?;
            deck.add_generated(label, *place, span)?;
            if let Some(name) = &set {
                let set =
                    deck.node_sets.entry(name.value.clone()).or_insert_with(|| SetBuilder::new(name.span));
                set.push_defined(label, span);
            }
        }
    }
    Ok(())
}

pub(in crate::deck) fn elements(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let whole = |name| keyword.get(name).map_or(Ok(0), |value| value.integer(name));
    let (shift, of_nodes) = (whole("ELEMENT SHIFT")?, whole("SHIFT NODES")?);
    let old = keyword.need_name("OLD SET")?;
    let set = keyword.name_of("NEW SET")?;
    let span = keyword.span;
    let masters = deck.elements_now(&old)?;
    deck.count_generated(masters.len() as u64, span)?;
    let shift = i64::try_from(shift).unwrap_or(i64::MAX);
    for master in masters {
        let label = counted(master, 1, shift, span)?;
        generate::copy(deck, master, label, of_nodes, span)?;
        if let Some(name) = &set {
            let set =
                deck.element_sets.entry(name.value.clone()).or_insert_with(|| SetBuilder::new(name.span));
            set.push_defined(label, span);
        }
    }
    Ok(())
}

impl Deck<'_> {
    fn place_of(&self, number: u64) -> Option<[f64; 3]> {
        self.scene.nodes.get(&Label::from(number)).map(|node| node.coordinates)
    }
}

#[cfg(test)]
mod tests {
    use super::fractions;

    #[test]
    fn bias_is_the_ratio_of_adjacent_distances() {
        for (bias, two_step) in [(1.0, false), (0.5, false), (1.5, false), (0.5, true)] {
            let found = fractions(6, bias, two_step, None);
            assert_eq!((found.len(), found[0], found[6]), (7, 0.0, 1.0));
            let lengths: Vec<f64> = found.windows(2).map(|pair| pair[1] - pair[0]).collect();
            for (index, pair) in lengths.windows(2).enumerate() {
                let expected = if two_step && index % 2 == 0 { 1.0 } else { bias };
                assert!((pair[0] / pair[1] - expected).abs() < 1e-12, "{bias} {two_step}: {lengths:?}");
            }
        }
        assert_eq!(fractions(4, 1.0, false, Some(1)), [0.0, 0.125, 0.5, 0.75, 1.0]);
        assert_eq!(fractions(4, 1.0, false, Some(2)), [0.0, 0.25, 0.5, 0.875, 1.0]);
    }
}
