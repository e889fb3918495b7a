//! The motion: the drawing of a scene whose nodes go where the solution has them.

use crate::audit::html::drawing::View;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, add, column, scale};
use pintle_model::evaluate::Model;
use pintle_scene::{End, Label, Scene};
use pintle_solve::{Number, Solution};
use std::collections::BTreeMap;

/// The width of the picture, what is drawn at most, and its margins.
const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 380.0;
const MARGIN: f64 = 70.0;

/// The length of an arm of a triad on the page.
const ARM: f64 = 22.0;

/// Until it is drawn.
const BEGIN: [[f64; 2]; 2] = [[0.0; 2]; 2];

/// A line between two points.
pub(super) struct Link {
    pub(super) class: &'static str,
    pub(super) title: String,
    pub(super) ends: [usize; 2],
    /// Where they are at first.
    pub(super) begin: [[f64; 2]; 2],
    /// The connector whose stick it shows.
    pub(super) connector: Option<usize>,
}

/// A node of the drawing.
pub(super) struct Dot {
    pub(super) point: usize,
    pub(super) label: String,
    pub(super) moves: bool,
    /// Where it is at first.
    pub(super) begin: [f64; 2],
}

/// Points on the page, at each frame.
pub(super) struct Motion {
    pub(super) height: f64,
    pub(super) links: Vec<Link>,
    pub(super) nodes: Vec<Dot>,
    /// x and y of each point, frame by frame.
    pub(super) frames: Vec<Vec<[f64; 2]>>,
    /// The paths of the nodes that move.
    pub(super) traces: Vec<String>,
}

/// A point of the drawing: a place, or that of a node, moved with it along its own axis.
#[derive(Clone, Copy, PartialEq)]
struct Point {
    place: Vector<f64>,
    node: Option<usize>,
    arm: Option<usize>,
}

impl Motion {
    pub(super) fn of<R: Number>(scene: &Scene, model: &Model, solution: &Solution<R>) -> Self {
        let index: BTreeMap<Label, usize> =
            solution.nodes.iter().enumerate().map(|(i, label)| (*label, i)).collect();
        let mut points: Vec<Point> = Vec::new();
        let mut put = |point: Point| {
            points.iter().position(|known| *known == point).unwrap_or_else(|| {
                points.push(point);
                points.len() - 1
            })
        };
        let mut arm_of = |label: Option<Label>, place: Vector<f64>, arm: Option<usize>| {
            put(Point { place, node: label.and_then(|label| index.get(&label).copied()), arm })
        };
        let mut point = |label: Option<Label>, place: Vector<f64>| arm_of(label, place, None);
        let place = |label: &Label| scene.nodes.get(label).map(|node| node.coordinates);
        let mut links = Vec::new();
        for (label, element) in scene.connectors.iter() {
            let ends = [End::A, End::B].map(|end| scene.position(element, end));
            let [Some(a), Some(b)] = ends else { continue };
            let known = model.connectors.iter().find(|known| known.label == *label);
            links.push(Link {
                class: "v-note",
                title: known.map_or_else(|| label.to_string(), |known| known.title()),
                ends: [point(element.a, a), point(element.b, b)],
                begin: BEGIN,
                connector: solution.connectors.iter().position(|(known, _)| known == label),
            });
        }
        let mut pair = |class: &'static str, title: String, one: Label, two: Label| {
            if let (Some(a), Some(b)) = (place(&one), place(&two)) {
                let ends = [point(Some(one), a), point(Some(two), b)];
                links.push(Link { class, title, ends, begin: BEGIN, connector: None });
            }
        };
        for mpc in &scene.mpcs {
            if let [one, two, ..] = mpc.nodes[..] {
                pair("v-unseen mpc", "constraint".into(), one, two);
            }
        }
        for (label, element) in scene.point_elements.iter() {
            if let Some(second) = element.second {
                pair("v-pass", format!("element {label}"), element.node, second);
            }
        }
        let mut nodes = Vec::new();
        for (i, label) in solution.nodes.iter().enumerate() {
            let Some(at) = place(label) else { continue };
            let is_moved = |frame: &pintle_solve::Frame<R>| {
                let of = &frame.nodes[i];
                of.displacement.iter().chain(&of.rotation).any(|x| x.to_f64().abs() > 1e-12)
            };
            let moves = solution.frames.iter().any(is_moved);
            let here = arm_of(Some(*label), at, None);
            nodes.push(Dot { point: here, label: label.to_string(), moves, begin: BEGIN[0] });
            let turns = |frame: &pintle_solve::Frame<R>| {
                frame.nodes[i].rotation.iter().any(|x| x.to_f64().abs() > 1e-12)
            };
            if solution.frames.iter().any(turns) {
                for arm in 0..3 {
                    let ends = [here, arm_of(Some(*label), at, Some(arm))];
                    let class = if arm == 0 { "triad t1" } else { "triad" };
                    links.push(Link { class, title: String::new(), ends, begin: BEGIN, connector: None });
                }
            }
        }
        drawn(&points, links, nodes, solution)
    }
}

/// Where a point is, and the direction of its arm.
type Placed = (Vector<f64>, Option<Vector<f64>>);

fn drawn<R: Number>(
    points: &[Point],
    mut links: Vec<Link>,
    mut nodes: Vec<Dot>,
    solution: &Solution<R>,
) -> Motion {
    let three = |of: &[R; 3]| of.map(Number::to_f64);
    let spatial: Vec<Vec<Placed>> = solution
        .frames
        .iter()
        .map(|frame| {
            let each = points.iter().map(|point| {
                let Some(of) = point.node.map(|node| &frame.nodes[node]) else { return (point.place, None) };
                let at = add(point.place, three(&of.displacement));
                let arm = point.arm.map(|arm| column(&so3::exp(three(&of.rotation)), arm));
                (at, arm)
            });
            each.collect()
        })
        .collect();
    let places = || spatial.iter().flatten().map(|(at, _)| *at);
    let view = View::of(places());
    let bounds = |axis: usize| {
        let all = places().map(|at| view.projected(at)[axis]);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let [[left, right], [top, bottom]] = [bounds(0), bounds(1)];
    let fit = ((WIDTH - 2.0 * MARGIN) / (right - left)).min(HEIGHT / (bottom - top));
    let fit = if fit.is_finite() { fit } else { 1.0 };
    let height = ((bottom - top) * fit + 2.0 * MARGIN).max(180.0);
    let middle = [(left + right) / 2.0, (top + bottom) / 2.0];
    let on_page = |(at, arm): &Placed| {
        let at = arm.map_or(*at, |arm| add(*at, scale(arm, ARM / fit)));
        let p = view.projected(at);
        [WIDTH / 2.0 + (p[0] - middle[0]) * fit, height / 2.0 + (p[1] - middle[1]) * fit]
            .map(|x| (x * 10.0).round() / 10.0)
    };
    let frames: Vec<Vec<[f64; 2]>> = spatial.iter().map(|all| all.iter().map(on_page).collect()).collect();
    let traces = nodes.iter().filter(|dot| dot.moves).map(|Dot { point, .. }| {
        let mut path: Vec<String> =
            frames.iter().map(|all| format!("{},{}", all[*point][0], all[*point][1])).collect();
        path.dedup();
        path.join(" ")
    });
    let traces = traces.collect();
    if let Some(first) = frames.first() {
        links.iter_mut().for_each(|link| link.begin = link.ends.map(|end| first[end]));
        nodes.iter_mut().for_each(|dot| dot.begin = first[dot.point]);
    }
    Motion { height, links, nodes, frames, traces }
}

impl Motion {
    /// The width of the picture.
    pub(super) const WIDTH: f64 = WIDTH;
}
