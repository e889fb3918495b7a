//! The lines that generated nodes lie on.

use crate::deck::mesh::{Axes, rectangular};
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::lexer::{Items, Keyword};
use crate::model::Scene;
use crate::orientation::{cross, minus};
use crate::span::Span;

/// A line from one node to another.
#[derive(Debug, Clone, Copy)]
pub(super) enum Curve {
    Straight,
    /// Through this point at half of the parameter: (1 − t)(1 − 2t) a + 4t(1 − t) m + t(2t − 1) b.
    Parabola([f64; 3]),
    /// About this centre and unit axis, by an angle in radians; the distances from both change in proportion to it.
    Arc {
        centre: [f64; 3],
        axis: [f64; 3],
        angle: f64,
    },
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: [f64; 3]) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

/// x + s y.
fn along(x: [f64; 3], s: f64, y: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| x[k] + s * y[k])
}

impl Curve {
    /// The curve that LINE and the items after the increment give.
    pub(super) fn read(
        (scene, axes): (&Scene, Option<Axes>),
        keyword: &Keyword,
        items: &mut Items<'_>,
        [from, to]: [[f64; 3]; 2],
        span: Span,
    ) -> Result<Self> {
        let Some(line) = keyword.word("LINE", &["P", "C"])? else { return Ok(Self::Straight) };
        let system = keyword.word("SYSTEM", &["RC", "C", "S"])?.unwrap_or("RC");
        let node = items.maybe().map(|item| item.label("the number of the further node")).transpose()?;
        let mut point = [0.0; 3];
        let mut is_given = false;
        for coordinate in &mut point {
            let number = items.number()?;
            is_given |= number.is_some();
            *coordinate = number.unwrap_or(0.0);
        }
        let normal = items.vector()?;
        let defined = node.and_then(|node| scene.nodes.get(&node));
        let point = match (defined, node) {
            (Some(node), _) => node.coordinates,
            (None, _) if is_given => {
                axes.map_or(rectangular(system, point), |axes| axes.global(rectangular(system, point)))
            }
            (None, Some(node)) => {
                let message = format!("there is no node {node} above this line");
                return Err(Diagnostic::error(Code::UnknownNode, span, message, "not defined")
                    .help("define it under *NODE, above *NGEN, or give its coordinates"));
            }
            (None, None) => {
                let (message, what) =
                    ("a curve needs a further point", "the middle of a parabola, or the centre of an arc");
                return Err(Diagnostic::error(Code::MissingData, span, message, "on this line").help(
                    format!("write: first node, last node, increment, node (or blank), x, y, z: {what}"),
                ));
            }
        };
        if line == "P" { Ok(Self::Parabola(point)) } else { Self::arc(point, normal, [from, to], span) }
    }

    fn arc(centre: [f64; 3], normal: [f64; 3], ends: [[f64; 3]; 2], span: Span) -> Result<Self> {
        let [first, last] = ends.map(|end| minus(end, centre));
        let is_given = normal != [0.0; 3];
        let normal = if is_given { normal } else { cross(first, last) };
        let size = norm(normal);
        let smallest = if is_given { 0.0 } else { 1e-9 * norm(first) * norm(last) };
        if size <= smallest || !size.is_finite() {
            let message = "the centre and the ends of the arc lie on one line";
            return Err(Diagnostic::error(Code::GenerateRange, span, message, "this arc")
                .help("give the normal of the arc as items 8 to 10"));
        }
        let axis = normal.map(|part| part / size);
        let across = |v: [f64; 3]| along(v, -dot(v, axis), axis);
        let (a, b) = (across(first), across(last));
        let angle = dot(axis, cross(a, b)).atan2(dot(a, b));
        let angle = if is_given && angle <= 0.0 { angle + std::f64::consts::TAU } else { angle };
        Ok(Self::Arc { centre, axis, angle })
    }

    /// The point at a fraction of the way.
    pub(super) fn point(&self, [from, to]: [[f64; 3]; 2], t: f64) -> [f64; 3] {
        match *self {
            Self::Straight => along(from, t, minus(to, from)),
            Self::Parabola(middle) => {
                let weights = [(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)];
                std::array::from_fn(|k| weights[0] * from[k] + weights[1] * middle[k] + weights[2] * to[k])
            }
            Self::Arc { centre, axis, angle } => {
                let [first, last] = [from, to].map(|end| minus(end, centre));
                let [height, top] = [first, last].map(|v| dot(v, axis));
                let arm = along(first, -height, axis);
                let radius = norm(along(last, -top, axis));
                let scale = 1.0 + t * (radius / norm(arm) - 1.0);
                let (sine, cosine) = (t * angle).sin_cos();
                let turned = along(arm.map(|part| cosine * part), sine, cross(axis, arm));
                let lifted = along(centre, height + t * (top - height), axis);
                along(lifted, if scale.is_finite() { scale } else { 1.0 }, turned)
            }
        }
    }
}
