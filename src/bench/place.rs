//! States of a type: far from its singular points, near them, and where nothing is turned; all with the same rows.

use pintle_audit::case::carried;
use pintle_audit::sampling::{Region, aligned, definition, draw_case, pair};
use pintle_audit::singular::atlas::{Site, beside};
use pintle_audit::{Case, Step};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Components, Connector, Increment, State};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{Matrix, Vector, identity, product, scale, transpose};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

pintle_kinematics::named! {
    /// Which states.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Proximity {
        /// At least [`CLEAR`] from every singular point of the rows and, where a rotation vector is measured, from no rotation and half
        /// a turn. Both nodes are moved and turned moderately, from orientations that are aligned initially and, where that leaves the
        /// rows what they are, from others. There are also states with any orientation of both nodes.
        Far = "far",
        /// Near a singular point of the rows or, where a rotation vector is measured, near half a turn: where formulas lose digits.
        Near = "near",
        /// [`REST`] from where b is not turned against a, or its shaft not against that of a: where formulas that divide by an angle or its sine
        /// lose digits, though nothing is singular.
        Rest = "rest",
    }
}

/// How far from every singular point states that are far from them are (rad, lengths of the connector).
pub const CLEAR: f64 = 0.15;

/// How far states at rest are from it (rad).
pub const REST: f64 = 1e-8;

/// How often a case is drawn anew until it is clear.
const ATTEMPTS: usize = 400;

impl Proximity {
    /// How far its states are from what they are far from or near to, if near is `distance`.
    pub const fn distance(self, distance: f64) -> f64 {
        match self {
            Self::Far => CLEAR,
            Self::Near => distance,
            Self::Rest => REST,
        }
    }
}

/// Why a type is not measured at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unmeasured {
    /// Its components are one-forms, or it has none.
    #[error("it has no function of the nodes")]
    NoFunction,
    /// There is nothing to be near to.
    #[error("its rows have no singular point")]
    NoSingularPoint,
    /// No formula of its rows divides by an angle that is zero at rest, or one is singular there.
    #[error("at rest its rows are regular by any formula, or singular")]
    NothingAtRest,
    /// None of the states drawn is clear of the singular points.
    #[error("no state was found that is clear of its singular points")]
    NotClear,
    /// The distance from the singular set of a measure cannot be had.
    #[error("no state was found at this distance from: {0}")]
    NotNear(&'static str),
    /// There is nothing to measure at.
    #[error("no states are asked for")]
    NoState,
    /// The 237-bit scalar cannot tell what is right at one of the states.
    #[error("the 237-bit scalar has no derivatives at one of the states")]
    NoTruth,
}

/// What is differentiated of each component.
pub(super) fn rows_of(connector: &Connector<f64>) -> Components<Measure> {
    [0, 1, 2, 3, 4, 5].map(|k| connector.differentiated(k))
}

/// A measure that is a logarithm of a rotation, whose formulas change at rest and half a turn.
const fn is_rotation_vector(measure: Measure) -> bool {
    matches!(measure, Measure::RotationVector(_) | Measure::RotationVectorAtB(_) | Measure::Misalignment(_))
}

/// `count` cases of a type, always the same, all of whose rows are those of the type with its constraints met initially.
pub(super) fn draw(
    connection: &ConnectionType,
    place: Proximity,
    count: usize,
    distance: f64,
) -> Result<Vec<Case>, Unmeasured> {
    let mut draw = Draw::new(&format!("bench {} {}", connection.name, place.name()));
    let rows = rows_of(&from_rest(connection, still([0.5, -0.25, 1.0]), &mut draw).connector());
    let measures: Vec<Measure> = rows.iter().flatten().copied().collect();
    let sites = sites(&measures, place);
    let one = |i: usize| match place {
        Proximity::Far => far(connection, i, &rows, &mut draw).ok_or(Unmeasured::NotClear),
        Proximity::Near | Proximity::Rest => {
            let none = if place == Proximity::Near {
                Unmeasured::NoSingularPoint
            } else {
                Unmeasured::NothingAtRest
            };
            let site = sites.get(i % sites.len().max(1)).ok_or(none)?;
            let case = at(connection, site, place.distance(distance), &rows, &mut draw)
                .ok_or(Unmeasured::NotNear(site.at))?;
            // What is removable for one row may be singular for another.
            if place == Proximity::Rest && !case.is_clear(0.0, CLEAR) { Err(none) } else { Ok(case) }
        }
    };
    (0..count).map(one).collect()
}

/// The singular points of measures, or what is removable at rest.
fn sites(measures: &[Measure], place: Proximity) -> Vec<Site> {
    let mut found: Vec<Site> = Vec::new();
    for measure in measures {
        let is_wanted = |site: &Site| match (place, measure) {
            (Proximity::Rest, _) => Some(&site.set) == measure.removable_sets().first(),
            // Whole turns of a rotation vector are no place of the principal one that others measure.
            (_, Measure::RotationVector(_) | Measure::RotationVectorAtB(_)) => {
                Some(&site.set) == measure.removable_sets().get(1)
            }
            _ => Some(site.set) == measure.singular_set(),
        };
        if let Some(site) = Site::all(*measure).find(is_wanted)
            && !found.iter().any(|known| known.at == site.at)
        {
            found.push(site);
        }
    }
    found
}

/// A pair at rest with both triads along the global axes.
fn still(reference: Vector<f64>) -> Pair<f64> {
    pair(reference, identity(), &identity())
}

/// A case of one state, whatever the motion that led there, from an initial state that meets the constraints of the type. That has no rotation of
/// b against a, where the type is regular there.
fn from_rest(connection: &ConnectionType, end: Pair<f64>, draw: &mut Draw) -> Case {
    let state = State { pair: end, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
    let a0 = draw.triad();
    let from = |q0: &Matrix<f64>| Case {
        name: format!("{} from rest", connection.name),
        definition: definition(connection, pair(end.reference, a0, q0), 1.0),
        start: None,
        path: vec![Step { state, increment: Increment::none() }],
        length: 1.0,
    };
    let regular = from(&identity());
    if regular.is_clear(CLEAR, 0.0) { regular } else { from(&aligned(connection, draw)) }
}

fn far(connection: &ConnectionType, i: usize, rows: &Components<Measure>, draw: &mut Draw) -> Option<Case> {
    let has_reference = rows.iter().flatten().any(|measure| matches!(measure, Measure::Misalignment(_)));
    let region = match i % 3 {
        0 => Some(Region::Aligned),
        // Where misalignment is measured from Q₀, that is I.
        1 if !has_reference => Some(Region::Misaligned),
        _ => None,
    };
    let is_right = |case: &Case| rows_of(&case.connector()) == *rows && is_far(case, rows);
    let moderate =
        region.and_then(|region| (0..8).filter_map(|_| draw_case(connection, region, draw)).find(is_right));
    let anywhere = |draw: &mut Draw| {
        let mut end = still(scale(draw.direction(), draw.between(0.7, 1.4)));
        for node in [&mut end.a, &mut end.b] {
            (node.displacement, node.triad) = (draw.vector(0.5), draw.triad());
        }
        from_rest(connection, end, draw)
    };
    moderate
        .or_else(|| (0..ATTEMPTS).map(|_| anywhere(draw)).find(is_right))
        .or_else(|| draw_case(connection, Region::Aligned, draw).filter(is_right))
}

/// Whether the end of a case is [`CLEAR`] from every singular point and, for rotation vectors, from rest and half a turn.
fn is_far(case: &Case, rows: &Components<Measure>) -> bool {
    let connector = case.connector();
    let Some(end) = case.last() else { return false };
    let q = end.state.pair.relative().q;
    let angle = |q: &Matrix<f64>| norm(so3::log(q));
    let is_between = |angle: f64| (CLEAR..=PI - CLEAR).contains(&angle);
    case.is_clear(CLEAR, CLEAR)
        && rows.iter().flatten().filter(|measure| is_rotation_vector(**measure)).all(
            |measure| match measure {
                Measure::Misalignment(_) => {
                    is_between(angle(&product(&q, &transpose(&connector.section().initial_orientation))))
                }
                _ => is_between(angle(&q)),
            },
        )
}

/// A state so far from a singular point, from any side; both nodes turned together besides.
fn at(
    connection: &ConnectionType,
    site: &Site,
    distance: f64,
    rows: &Components<Measure>,
    draw: &mut Draw,
) -> Option<Case> {
    let azimuth = draw.between(-PI, PI);
    let mut case = if is_rotation_vector(site.measure) {
        // Principal rotation vectors, on whatever sheet the motion that led there ended.
        let half_turn = Some(&site.set) != site.measure.removable_sets().first();
        let spin = if half_turn { PI - distance } else { distance };
        let mut end = still([0.5, -0.25, 1.0]);
        end.b.triad = exp(scale(draw.direction(), spin));
        from_rest(connection, end, draw)
    } else {
        beside(connection, site, distance, azimuth, draw)?
    };
    if rows_of(&case.connector()) != *rows {
        // The state that it starts from does not meet the constraints.
        case = from_rest(connection, case.last()?.state.pair, draw);
    }
    let mut step = *case.last()?;
    step.state.pair = carried(&step.state.pair, &exp(draw.rotation(0.3, 1.2)), draw.vector(0.5));
    step.increment = Increment::none();
    case.path = vec![step];
    (rows_of(&case.connector()) == *rows).then_some(case)
}
