//! The drawing of a scene, isometric or in its plane: nodes, triads, connectors coloured by verdict.

use crate::audit::html::figure::{Medium, lines, rendered};
use crate::audit::html::labels::Labels;
use askama::Template;
use pintle_audit::Verdict;
use pintle_audit::model::Finding;
use pintle_kinematics::vector::{Matrix, Vector, add, column, scale};
use pintle_model::evaluate::{Model, MpcElement};
use pintle_scene::{End, Label, Scene, Severity};
use std::collections::{BTreeMap, BTreeSet};

/// Connectors that are drawn at most: more than that is no picture any more.
pub(super) const MOST: usize = 2000;

/// Nodes and elements get their numbers up to so many connectors.
const NAMED: usize = 60;

/// The width of the picture.
const WIDTH: f64 = 1000.0;

/// The margin around what is drawn.
const MARGIN: f64 = 100.0;

/// The height of what is drawn at most.
const HEIGHT: f64 = 330.0;

/// The width of a letter of the name of a connector, and of a node.
const LETTER: [f64; 2] = [7.4, 5.9];

/// The nodes at each place of the page: their numbers, whether they are all ground, the place.
type Spots = BTreeMap<[i64; 2], (Vec<String>, bool, [f64; 2])>;

/// A connector or constraint to be drawn.
struct Piece {
    title: String,
    colour: Colour,
    is_constraint: bool,
    ends: [Vector<f64>; 2],
    triads: Option<[Matrix<f64>; 2]>,
    nodes: [Option<Label>; 2],
    /// The hinges of a constraint: the node of its angle, where that stands, and the direction of the axis.
    hinges: Vec<(Label, Vector<f64>, Vector<f64>)>,
}

/// How a connector or constraint is coloured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Colour {
    /// By the verdict on its numbers.
    Verdict(Verdict),
    /// Where its numbers were not audited: by the worst that was found of it in the model.
    Found(Severity),
    /// Where nothing was found either.
    Unseen,
}

impl Colour {
    /// Every one, in the order of a legend.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let verdicts = Verdict::ALL.into_iter().filter(|verdict| verdict.headline() == *verdict);
        let found = [Severity::Error, Severity::Warning, Severity::Note].map(Self::Found);
        verdicts.map(Self::Verdict).chain(found).chain([Self::Unseen])
    }

    /// Its class in style sheets.
    pub(super) fn class(self) -> String {
        match self {
            Self::Verdict(verdict) => name_of(verdict),
            Self::Found(severity) => severity_name(severity),
            Self::Unseen => "unseen".into(),
        }
    }

    /// What it means.
    pub(super) fn name(self) -> String {
        match self {
            Self::Verdict(verdict) => verdict.name().into(),
            Self::Found(severity) => format!("{} found, not audited", severity_name(severity)),
            Self::Unseen => "nothing found, not audited".into(),
        }
    }

    /// Whether it is drawn last, on top.
    fn needs_a_look(self) -> bool {
        match self {
            Self::Verdict(verdict) => verdict != Verdict::Pass,
            Self::Found(severity) => severity > Severity::Note,
            Self::Unseen => false,
        }
    }
}

/// A severity in style sheets and words.
fn severity_name(severity: Severity) -> String {
    format!("{severity:?}").to_lowercase()
}

/// The worst that was found of each connector and constraint, by number and by title.
#[derive(Default)]
pub(super) struct Worst<'a> {
    connectors: BTreeMap<Label, Severity>,
    constraints: BTreeMap<&'a str, Severity>,
}

impl<'a> Worst<'a> {
    pub(super) fn of(findings: impl Iterator<Item = &'a Finding>) -> Self {
        let mut worst = Self::default();
        for finding in findings {
            let severity = finding.severity();
            for label in &finding.about.elements {
                let known = worst.connectors.entry(*label).or_insert(severity);
                *known = severity.max(*known);
            }
            for title in &finding.about.mpcs {
                let known = worst.constraints.entry(title).or_insert(severity);
                *known = severity.max(*known);
            }
        }
        worst
    }
}

struct Link {
    class: String,
    title: String,
    is_constraint: bool,
    is_point: bool,
    from: [f64; 2],
    to: [f64; 2],
}

#[derive(PartialEq)]
struct AxisLine {
    name: u8,
    is_named: bool,
    from: [f64; 2],
    to: [f64; 2],
    label: [f64; 2],
}

/// The axis of a hinge.
struct Axis {
    title: String,
    from: [f64; 2],
    to: [f64; 2],
}

/// A colour, and what it means.
struct Key {
    x: f64,
    class: String,
    name: String,
}

struct Dot {
    title: String,
    is_ground: bool,
    at: [f64; 2],
}

struct Name {
    class: &'static str,
    text: String,
    at: [f64; 2],
}

#[derive(Template)]
#[template(path = "drawing.svg", escape = "html")]
struct DrawingTemplate<'a> {
    title: &'a str,
    style: Option<&'static str>,
    width: f64,
    height: f64,
    axes: Vec<AxisLine>,
    links: Vec<Link>,
    hinges: Vec<Axis>,
    triads: Vec<AxisLine>,
    nodes: Vec<Dot>,
    names: Vec<Name>,
    /// In a file: the title in lines, and what colours mean.
    head: f64,
    heading: Vec<String>,
    keys: Vec<Key>,
}

/// From where a scene is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum View {
    /// 3 up, 1 and 2 to the lower left and right.
    Isometric,
    /// Against this axis (0-based), along which the scene has no extent.
    Plane(usize),
}

impl View {
    /// A scene whose nodes lie in a plane across an axis, and not in a line, is seen in that plane.
    pub(crate) fn of(points: impl Iterator<Item = Vector<f64>> + Clone) -> Self {
        /// What rounding leaves of no extent, of the largest.
        const FLAT: f64 = 1e-9;
        let extent = |axis: usize| {
            let all = points.clone().map(|point| point[axis]);
            let [low, high] =
                all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
            high - low
        };
        let extents = [0, 1, 2].map(extent);
        let largest = extents.into_iter().fold(0.0, f64::max);
        let mut flat = (0..3).filter(|axis| extents[*axis] <= FLAT * largest);
        match (flat.next(), flat.next()) {
            (Some(axis), None) => Self::Plane(axis),
            _ => Self::Isometric,
        }
    }

    /// A point or direction on the page.
    pub(crate) fn projected(self, x: Vector<f64>) -> [f64; 2] {
        let [cos, sin] = [3.0_f64.sqrt() / 2.0, 0.5];
        match self {
            Self::Isometric => [(x[1] - x[0]) * cos, (x[0] + x[1]) * sin - x[2]],
            Self::Plane(0) => [x[1], -x[2]],
            Self::Plane(1) => [x[0], -x[2]],
            Self::Plane(_) => [x[0], -x[1]],
        }
    }
}

/// A scene to be drawn, with the verdicts on its connectors.
pub(super) struct Drawing {
    pieces: Vec<Piece>,
    /// Connectors and constraints that there are.
    pub(super) count: usize,
}

impl Drawing {
    /// Of a scene; `verdict` is asked by the name of the subject. Of a large one, those connectors that did not pass first.
    pub(super) fn of(
        scene: &Scene,
        model: &Model,
        verdict: &dyn Fn(&str) -> Option<Verdict>,
        worst: &Worst<'_>,
    ) -> Self {
        let mut pieces = Vec::new();
        let found =
            |severity: Option<&Severity>| severity.map_or(Colour::Unseen, |found| Colour::Found(*found));
        let colour = |title: &str, severity: Option<&Severity>| {
            verdict(title).map_or_else(|| found(severity), |verdict| Colour::Verdict(verdict.headline()))
        };
        for element in &model.connectors {
            let Some(of_scene) = scene.connectors.get(&element.label) else { continue };
            let end = |end| scene.position(of_scene, end).unwrap_or_default();
            let title = element.title();
            pieces.push(Piece {
                colour: colour(&title, worst.connectors.get(&element.label)),
                title,
                is_constraint: false,
                ends: [end(End::A), end(End::B)],
                triads: Some(element.triads().map(|triad| *triad)),
                nodes: element.nodes,
                hinges: Vec::new(),
            });
        }
        // What a rule refuses is drawn as far as its nodes are known.
        let known: BTreeSet<Label> = model.connectors.iter().map(|element| element.label).collect();
        for (label, element) in scene.connectors.iter().filter(|(label, _)| !known.contains(label)) {
            let ends = [End::A, End::B].map(|end| scene.position(element, end));
            if let [Some(a), Some(b)] = ends {
                pieces.push(Piece {
                    title: format!("element {label}"),
                    colour: Colour::Found(Severity::Error),
                    is_constraint: false,
                    ends: [a, b],
                    triads: None,
                    nodes: [element.a, element.b],
                    hinges: Vec::new(),
                });
            }
        }
        for element in &model.mpcs {
            let place = |label: &Label| scene.nodes.get(label).map(|node| node.coordinates);
            let [Some(a), Some(b)] = [element.nodes.first(), element.nodes.get(1)] else { continue };
            let (Some(at), Some(to)) = (place(a), place(b)) else { continue };
            let title = element.title();
            pieces.push(Piece {
                colour: colour(&title, worst.constraints.get(title.as_str())),
                title,
                is_constraint: true,
                ends: [at, to],
                triads: None,
                nodes: [Some(*a), Some(*b)],
                hinges: hinges(element, &place),
            });
        }
        let count = pieces.len();
        pieces.sort_by_key(|piece| !piece.colour.needs_a_look());
        pieces.truncate(MOST);
        // What did not pass is drawn last, on top.
        pieces.reverse();
        Self { pieces, count }
    }

    /// Whether there is nothing to draw.
    pub(super) const fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Whether something in it has a colour.
    pub(super) fn has(&self, colour: Colour) -> bool {
        self.pieces.iter().any(|piece| piece.colour == colour)
    }

    /// What the picture shows.
    pub(super) fn caption(&self, scene: &str) -> String {
        if self.count > MOST {
            format!(
                "{scene}: {MOST} of {} connectors and constraints, those first that did not pass",
                self.count
            )
        } else {
            scene.to_string()
        }
    }

    /// The picture.
    pub(super) fn svg(&self, title: &str, place: Medium) -> String {
        let hinges = || self.pieces.iter().flat_map(|piece| piece.hinges.iter().map(|(_, at, _)| *at));
        let places = || self.pieces.iter().flat_map(|piece| piece.ends).chain(hinges());
        let view = View::of(places());
        let points = || places().map(|place| view.projected(place));
        let bounds = |axis: usize| {
            points().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                (low.min(p[axis]), high.max(p[axis]))
            })
        };
        let [(left, right), (top, bottom)] = [bounds(0), bounds(1)];
        let [wide, high] = [right - left, bottom - top];
        let inner = WIDTH - 2.0 * MARGIN;
        // A scene without extent is one point in the middle.
        let fit = (inner / wide).min(HEIGHT / high);
        let fit = if fit.is_finite() { fit } else { 1.0 };
        let height = (high * fit + 1.4 * MARGIN).max(200.0);
        let middle = [(left + right) / 2.0, (top + bottom) / 2.0];
        let on_page = |x: Vector<f64>| {
            let p = view.projected(x);
            [WIDTH / 2.0 + (p[0] - middle[0]) * fit, height / 2.0 + (p[1] - middle[1]) * fit]
                .map(|x| (x * 10.0).round() / 10.0)
        };
        let arm = 24.0 / fit;
        let is_small = self.pieces.len() <= NAMED;
        let mut shown: Spots = BTreeMap::new();
        let (mut links, mut triads, mut names) = (Vec::new(), Vec::<AxisLine>::new(), Vec::new());
        let mut axles = Vec::new();
        for piece in &self.pieces {
            let [from, to] = piece.ends.map(on_page);
            let is_point = (from[0] - to[0]).hypot(from[1] - to[1]) < 2.0;
            links.push(Link {
                class: piece.colour.class(),
                title: format!("{}: {}", piece.title, piece.colour.name()),
                is_constraint: piece.is_constraint,
                is_point,
                from,
                to,
            });
            for (label, at, axis) in &piece.hinges {
                // Along the axis, beyond the node of its angle and behind the master.
                let beyond = |from: Vector<f64>, part: f64| on_page(add(from, scale(*axis, arm * part)));
                axles.push(Axis {
                    title: format!("{}: axis of node {label}", piece.title),
                    from: beyond(piece.ends[1], -1.2),
                    to: beyond(*at, 1.2),
                });
                put(&mut shown, on_page(*at), Some(*label));
            }
            for end in 0..2 {
                if let Some(all) = &piece.triads {
                    let axes = (0..3).map(|i| {
                        let tip = |part: f64| {
                            on_page(add(piece.ends[end], scale(column(&all[end], i), arm * part)))
                        };
                        AxisLine {
                            name: i as u8 + 1,
                            is_named: is_small,
                            from: on_page(piece.ends[end]),
                            to: tip(1.0),
                            label: tip(1.35),
                        }
                    });
                    // Coincident nodes with the same directions show one triad.
                    for axis in axes {
                        // One that points at the reader has no length.
                        if axis.from != axis.to && !triads.contains(&axis) {
                            triads.push(axis);
                        }
                    }
                }
                put(&mut shown, on_page(piece.ends[end]), piece.nodes[end]);
            }
        }
        if is_small {
            names = named(&self.pieces, &links, &triads, &shown, [WIDTH, height]);
        }
        let nodes = shown.values().map(|(labels, is_ground, at)| Dot {
            title: format!("node {}", labels.join(", ")),
            is_ground: *is_ground,
            at: *at,
        });
        let origin = [50.0, height - 40.0];
        let axes = (0..3).map(|i| {
            let mut unit = [0.0; 3];
            unit[i] = 1.0;
            let p = view.projected(unit);
            let at = |length: f64| {
                [origin[0] + p[0] * length, origin[1] + p[1] * length].map(|x| (x * 10.0).round() / 10.0)
            };
            AxisLine {
                name: i as u8 + 1,
                is_named: true,
                from: origin,
                to: at(26.0),
                label: [at(36.0)[0], at(36.0)[1] + 4.0],
            }
        });
        let (mut heading, mut keys) = (Vec::new(), Vec::new());
        if place == Medium::File {
            heading = lines(title, WIDTH);
            let mut x = 16.0;
            for colour in Colour::all().filter(|colour| self.has(*colour)) {
                let name = colour.name();
                let width = 50.0 + LETTER[1] * name.chars().count() as f64;
                keys.push(Key { x, class: colour.class(), name });
                x += width;
            }
        }
        let page = DrawingTemplate {
            head: if heading.is_empty() { 0.0 } else { 26.0 + 14.0 * heading.len() as f64 },
            heading,
            keys,
            hinges: axles,
            title,
            style: place.style(),
            width: WIDTH,
            height,
            axes: axes.filter(|axis| axis.from != axis.to).collect(),
            links,
            triads,
            nodes: nodes.collect(),
            names,
        };
        rendered(&page)
    }
}

/// Notes that a node, or the ground, stands at a place of the page.
fn put(shown: &mut Spots, at: [f64; 2], node: Option<Label>) {
    let spot = shown.entry(at.map(|x| x.round() as i64)).or_insert_with(|| (Vec::new(), true, at));
    let label = node.map_or_else(|| "ground".to_string(), |label| label.to_string());
    spot.1 &= node.is_none();
    if !spot.0.contains(&label) {
        spot.0.push(label);
    }
}

/// The hinges of a constraint, by the nodes of their angles.
fn hinges(
    element: &MpcElement,
    place: &dyn Fn(&Label) -> Option<Vector<f64>>,
) -> Vec<(Label, Vector<f64>, Vector<f64>)> {
    let axes = element.constraint.initial_axes().into_iter().flatten();
    let nodes = element.nodes.iter().skip(2);
    nodes.zip(axes).filter_map(|(label, axis)| Some((*label, place(label)?, axis))).collect()
}

/// The names of connectors and nodes, each where it covers least; `pieces` and `links` are in one order.
fn named(pieces: &[Piece], links: &[Link], triads: &[AxisLine], shown: &Spots, size: [f64; 2]) -> Vec<Name> {
    let mut labels = Labels::new(size);
    for Link { is_point, from, to, .. } in links {
        if *is_point {
            labels.spot(*from, 10.0);
        } else {
            labels.line(*from, *to);
        }
    }
    for axis in triads {
        labels.line(axis.from, axis.to);
        labels.spot([axis.label[0], axis.label[1] - 3.0], 4.0);
    }
    for (_, _, at) in shown.values() {
        labels.spot(*at, 4.0);
    }
    // The axes of space in the corner.
    labels.spot([50.0, size[1] - 40.0], 45.0);
    let width = |text: &str, letter: f64| text.chars().count() as f64 * letter;
    let mut names = Vec::new();
    for (piece, Link { is_point, from, to, .. }) in pieces.iter().zip(links) {
        let along = |part: f64| [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
        let points: Vec<[f64; 2]> =
            if *is_point { vec![*from] } else { [0.5, 0.42, 0.58, 0.34, 0.66].map(along).into() };
        let at = labels.place(&points, width(&piece.title, LETTER[0]));
        names.push(Name { class: "label", text: piece.title.clone(), at });
    }
    for (numbers, _, at) in shown.values() {
        let text = numbers.join(", ");
        let at = labels.place(&[*at], width(&text, LETTER[1]));
        names.push(Name { class: "minor", text, at });
    }
    names
}

/// The class of a verdict in style sheets: its name as it is serialised.
pub(super) fn name_of(verdict: Verdict) -> String {
    serde_json::to_value(verdict)
        .ok()
        .and_then(|value| value.as_str().map(str::to_string))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::View;

    #[test]
    fn a_plane_is_seen_in_itself() {
        let of = |points: &[[f64; 3]]| View::of(points.iter().copied());
        let square = [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 1.0, 2.0]];
        assert_eq!(of(&square), View::Plane(2));
        assert_eq!(of(&square.map(|[x, y, z]| [x, z, y])), View::Plane(1));
        assert_eq!(of(&square.map(|[x, y, z]| [z, x, y])), View::Plane(0));
        assert_eq!(of(&[[0.0; 3], [1.0, 0.0, 0.0]]), View::Isometric);
        assert_eq!(of(&[[0.0; 3], [1.0, 1.0, 1.0], [1.0, 0.0, 0.5]]), View::Isometric);
        assert_eq!(View::Plane(2).projected([3.0, 4.0, 9.0]), [3.0, -4.0]);
    }
}
