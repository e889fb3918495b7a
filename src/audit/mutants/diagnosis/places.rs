//! Special kinds of states, at which formulas lose digits or have no number, and how far a state is from each.

use crate::case::Case;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, column, dot, product, transpose, transposed_product};
use std::f64::consts::PI;

const RAD: &str = "rad";
const LENGTHS: &str = "lengths of the connector";

/// Special kinds of states of any connector, and the units of distances from them.
pub(super) const PLACES: [(&str, &str); 17] = [
    ("nothing has moved", RAD),
    ("b has not turned against a since the initial state", RAD),
    ("the axes of a and b coincide", RAD),
    ("b is turned by π against a", RAD),
    ("b has turned by π against a since the initial state", RAD),
    ("b has turned by nothing or by π since the initial state", RAD),
    ("e3a and e3b coincide", RAD),
    ("e3a and e3b are opposite", RAD),
    ("the second angle is at ±π/2", RAD),
    ("the nodes coincide", LENGTHS),
    ("b is on the axis e3a", LENGTHS),
    ("ur1 is at 0 or ±π", RAD),
    ("ur2 is at 0 or ±π", RAD),
    ("ur3 is at 0 or ±π", RAD),
    ("ur1 is at ±π/2", RAD),
    ("ur2 is at ±π/2", RAD),
    ("ur3 is at ±π/2", RAD),
];

/// From which of them on they are places of single angles.
pub(super) const OF_ANGLES: usize = 11;

const ACOS: &str = "acos, or 1 − cos";
const ASIN: &str = "asin, or a tangent";

/// What loses digits there.
pub(super) const FORMULAS: [&str; PLACES.len()] = [
    "0/0 at the initial state",
    "an angle or axis from a rotation that is none",
    "acos((tr Q − 1)/2), or a division by the angle",
    "acos((tr Q − 1)/2), or a division by the sine",
    "a division by the sine",
    "acos of a trace, or a division by the angle or its sine",
    "acos(e3a·e3b), or 1 − cos of a small angle",
    "acos(e3a·e3b)",
    "asin of an entry of Q, or a division by its cosine",
    "a division by the distance, or a difference of large numbers",
    "the root of a difference of squares, or a division by the radius",
    ACOS,
    ACOS,
    ACOS,
    ASIN,
    ASIN,
    ASIN,
];

/// How far a state is from each of the special places, in their units.
pub type Places = [f64; PLACES.len()];

/// How far the end of a case is from each of them.
pub fn places(case: &Case) -> Places {
    let Some(step) = case.last() else { return [f64::NAN; PLACES.len()] };
    let (pair, initial) = (&step.state.pair, &case.definition.initial);
    let relative = |pair: &Pair<f64>| transposed_product(&pair.a.triad, &pair.b.triad);
    let (q, q0) = (relative(pair), relative(initial));
    let angle = |r: &Matrix<f64>| norm(so3::log(r));
    let (coincide, since) = (angle(&q), angle(&product(&q, &transpose(&q0))));
    let bent = (q[0][2].hypot(q[1][2])).atan2(q[2][2]);
    let tilted = q[0][2].clamp(-1.0, 1.0).asin();
    let across = [0, 1].map(|i| dot(column(&pair.a.triad, i), pair.separation()));
    let has_moved =
        |now: &Node<f64>, then: &Node<f64>| now.triad != then.triad || now.displacement != then.displacement;
    let nothing = !has_moved(&pair.a, &initial.a) && !has_moved(&pair.b, &initial.b);
    let connector = case.connector();
    let position = case.positions();
    let from = |k: usize, place: f64| {
        let is_angle = connector.differentiated(k).is_some_and(|measure| measure.unit() == Unit::Angle);
        let off = |x: f64| (x - place) - PI * ((x - place) / PI).round();
        position[k].filter(|_| is_angle).map_or(f64::INFINITY, off)
    };
    let all = [
        if nothing { 0.0 } else { 1.0 },
        since,
        coincide,
        coincide - PI,
        since - PI,
        since.min(PI - since),
        bent,
        bent - PI,
        tilted.abs() - PI / 2.0,
        norm(pair.separation()) / case.length,
        across[0].hypot(across[1]) / case.length,
        from(3, 0.0),
        from(4, 0.0),
        from(5, 0.0),
        from(3, PI / 2.0),
        from(4, PI / 2.0),
        from(5, PI / 2.0),
    ];
    all.map(f64::abs)
}
