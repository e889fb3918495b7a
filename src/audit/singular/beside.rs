//! Cases whose end lies at a given distance from a singular point.

use crate::case::{Case, Step, carried};
use crate::sampling::{Motion, about_1, about_3, cube_orientations, definition, pair};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::{Measure, SingularSet};
use pintle_kinematics::so3::{self, exp};
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector, apply, product as matrix_product, scale};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// By what a singular point is approached: the one place that says it of a measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// |d|.
    Distance,
    /// The distance of b from the axis e3a.
    Radius,
    /// The material that is left.
    Material,
    /// The middle one of three Cardan angles.
    Cardan,
    /// The middle one of three Euler angles.
    Euler,
    /// The angle of two shafts.
    Shafts,
    /// A turn of b from its initial orientation.
    Misalignment,
    /// A turn of b against a.
    Turn,
}

impl Way {
    /// That of a measure; `None` where it has no singular point.
    pub(super) const fn of(measure: Measure) -> Option<Self> {
        Some(match measure {
            Measure::Distance => Self::Distance,
            Measure::RadialDistance => Self::Radius,
            Measure::Strain => Self::Material,
            Measure::Cardan(_) => Self::Cardan,
            Measure::Euler(_) => Self::Euler,
            Measure::Flexion
            | Measure::Sweep
            | Measure::Torsion
            | Measure::ComponentFlexion(_)
            | Measure::ProjectedPosition(_) => Self::Shafts,
            Measure::Misalignment(_) => Self::Misalignment,
            Measure::RotationVector(_) | Measure::RotationVectorAtB(_) => Self::Turn,
            Measure::Position(_)
            | Measure::PositionAtB(_)
            | Measure::Flow(_)
            | Measure::Cosine(..)
            | Measure::FlowConversion => return None,
        })
    }
}

fn about_2(angle: f64) -> Matrix<f64> {
    exp([0.0, angle, 0.0])
}

fn composed(first: &Matrix<f64>, middle: &Matrix<f64>, last: &Matrix<f64>) -> Matrix<f64> {
    matrix_product(&matrix_product(first, middle), last)
}

/// Rx(α) Ry(β) Rz(γ).
pub fn by_cardan_angles([alpha, beta, gamma]: [f64; 3]) -> Matrix<f64> {
    composed(&about_1(alpha), &about_2(beta), &about_3(gamma))
}

/// Rz(α) Rx(β) Rz(γ).
pub fn by_euler_angles([alpha, beta, gamma]: [f64; 3]) -> Matrix<f64> {
    composed(&about_3(alpha), &about_1(beta), &about_3(gamma))
}

/// Rz(φ) Ry(α) Rz(ψ): shafts at the angle α.
pub fn by_shafts([phi, alpha, psi]: [f64; 3]) -> Matrix<f64> {
    composed(&about_3(phi), &about_2(alpha), &about_3(psi))
}

/// A singular point of a measure that is approached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// The measure.
    pub measure: Measure,
    /// The set that the point is of, as declared.
    pub set: SingularSet,
    /// The point, in words.
    pub at: &'static str,
    /// The angle at which it lies (rad); of no meaning for lengths, and for locks.
    angle: f64,
}

impl Site {
    /// By what it is approached.
    pub(super) fn way(&self) -> Option<Way> {
        if self.set == Measure::COINCIDENT { Some(Way::Distance) } else { Way::of(self.measure) }
    }

    /// Whether there are states on its other side, at negative distances: material that is less than none is not.
    pub fn has_two_sides(&self) -> bool {
        self.way() != Some(Way::Material)
    }

    /// Whether it lies at an angle of zero.
    pub(super) fn is_at_rest(&self) -> bool {
        self.angle == 0.0
    }

    /// The angle at which it lies (rad).
    pub(super) const fn angle(&self) -> f64 {
        self.angle
    }

    /// The point of the declared singular set, a removable one where there is only such.
    fn first(measure: Measure) -> Option<Self> {
        Self::all(measure).next()
    }

    /// Every point of a measure that is approached: of each declared set one, of a lock and of parallel shafts both, of the turns of a
    /// rotation vector two.
    pub fn all(measure: Measure) -> impl Iterator<Item = Self> {
        let declared = measure.singular_sets().flat_map(move |set| {
            let points: &[(&'static str, f64)] = match measure {
                Measure::RotationVector(_) | Measure::RotationVectorAtB(_) => {
                    &[("|φ| = 2π", TAU), ("|φ| = 4π", 2.0 * TAU)]
                }
                Measure::Cardan(_) => &[("β = π/2 (lock)", FRAC_PI_2), ("β = −π/2 (lock)", -FRAC_PI_2)],
                Measure::Euler(_) => &[("e3b = e3a, β = 0 (lock)", 0.0), ("e3b = −e3a, β = π (lock)", PI)],
                Measure::Flexion | Measure::Sweep => &[("e3b = e3a, α = 0", 0.0), ("e3b = −e3a, α = π", PI)],
                _ => &[("", PI)],
            };
            points.iter().map(move |(at, angle)| {
                let at = if at.is_empty() { set.at } else { at };
                Self { measure, set, at, angle: *angle }
            })
        });
        let removable = measure.removable_sets().iter().enumerate().map(move |(i, set)| {
            // Rest comes first, half a turn second.
            Self { measure, set: *set, at: set.at, angle: i as f64 * PI }
        });
        declared.chain(removable)
    }
}

/// The singular points of a type, each once, by the components that have them as position or as constraint.
pub fn sites(connection: &ConnectionType) -> Vec<(usize, Site)> {
    let slots = connection.slots.iter().enumerate();
    let measures = slots.flat_map(|(k, slot)| {
        let both = [slot.position(), slot.printed()];
        both.into_iter().flatten().map(move |measure| (k, measure))
    });
    measures.flat_map(|(k, measure)| Site::all(measure).map(move |site| (k, site))).collect()
}

/// A case whose end is `distance` away from the singular set of a measure, on its other side where negative. The direction is
/// `azimuth` (rad) about the nearest point of the set. Lengths are 1. `None` where the measure has no singular set.
pub fn near(
    connection: &ConnectionType,
    measure: Measure,
    distance: f64,
    azimuth: f64,
    draw: &mut Draw,
) -> Option<Case> {
    beside(connection, &Site::first(measure)?, distance, azimuth, draw)
}

/// The same beside one of its singular points, a removable one perhaps.
pub fn beside(
    connection: &ConnectionType,
    site: &Site,
    distance: f64,
    azimuth: f64,
    draw: &mut Draw,
) -> Option<Case> {
    let way = site.way()?;
    let angle = site.angle;
    // The 24 orientations of a cube turn without rounding.
    let cubes = cube_orientations();
    let a0 = cubes[draw.below(cubes.len())];
    let axis = draw.direction();
    let direction = apply(&exp([0.0, azimuth, 0.0]), axis);
    // With structure the nodes turn about one axis, and lie along one.
    let is_structured = draw.is_structured();
    let [alpha, gamma] =
        if is_structured { [0.0; 2] } else { [draw.between(0.3, 0.9), draw.between(-0.9, -0.3)] };
    let azimuth = if is_structured { 0.0 } else { azimuth };
    let offset = if is_structured { draw.direction() } else { [0.5, -0.25, 1.0] };
    let mut reference = apply(&a0, offset);
    let mut flow = [0.0; 2];
    // Q at the start, which is regular, and at the end.
    let still = if is_structured { vector::identity() } else { exp([0.2, -0.3, 0.1]) };
    let (start, end) = match way {
        Way::Distance => {
            reference = scale(direction, distance);
            // A belt segment has material all the same, which has flowed in.
            flow = [if site.measure == Measure::Strain { 1.0 } else { 0.0 }, 0.0];
            (still, still)
        }
        Way::Material => {
            reference = apply(&a0, [1.0, 0.0, 0.0]);
            flow = [0.0, 1.0 - distance];
            (still, still)
        }
        Way::Radius if is_structured => {
            reference = apply(&a0, [distance, 0.0, 1.0]);
            (still, still)
        }
        Way::Radius => {
            reference = apply(&a0, [distance * (0.6 + azimuth).cos(), distance * (0.6 + azimuth).sin(), 1.0]);
            (still, still)
        }
        Way::Cardan => {
            // At β = π/2 only γ + α is left, at −π/2 only γ − α.
            let sign = angle.signum();
            let q = |beta: f64| by_cardan_angles([alpha + azimuth, sign * beta, gamma - sign * azimuth]);
            (q(0.6), q(FRAC_PI_2 - distance))
        }
        Way::Euler | Way::Shafts => {
            let by = if way == Way::Euler { by_euler_angles } else { by_shafts };
            // At π only the difference of the two is left, at 0 only their sum.
            let other = if angle > 0.0 { gamma + azimuth } else { gamma - azimuth };
            let q = |middle: f64| by([alpha + azimuth, middle, other]);
            if angle > 0.0 { (q(2.0), q(angle - distance)) } else { (q(0.6), q(distance)) }
        }
        Way::Misalignment => {
            let spin = if angle > 0.0 { scale(axis, angle - distance) } else { scale(direction, distance) };
            (vector::identity(), exp(spin))
        }
        Way::Turn => {
            return Some(beside_a_turn(connection, site, [axis, direction], a0, distance, draw));
        }
    };
    let definition = definition(connection, pair(reference, a0, &start), 1.0);
    let mut after = pair(reference, a0, &end);
    [after.a.flow, after.b.flow] = flow;
    let mut step = Step::between(&definition.initial, after);
    step.state.velocity = draw.rates(1.0);
    step.state.acceleration = draw.rates(1.0);
    let name = format!("{} {distance:e} from {}", connection.name, site.at);
    Some(Case { name, definition, start: None, path: vec![step], length: 1.0 })
}

/// Random states near the singular points of a type, removable ones among them: 1e-1 to 1e-12 away, from either side, from any
/// direction, with both nodes turned besides. A draw with structure ([`Draw::structured`]) gives states as models have them: one axis turns, the
/// nodes lie along one, and nothing moves but one degree of freedom. Nothing for a type that has no singular point.
pub fn random_near(connection: &ConnectionType, draw: &mut Draw) -> Option<Case> {
    let sites = sites(connection);
    let (_, site) = sites.get(draw.below(sites.len()))?;
    let sign = if draw.unit() < 0.5 { 1.0 } else { -1.0 };
    let distance = sign * 10.0_f64.powf(-draw.between(1.0, 12.0));
    let distance = if site.has_two_sides() { distance } else { distance.abs() };
    let azimuth = draw.between(-PI, PI);
    let mut case = beside(connection, site, distance, azimuth, draw)?;
    // Turned together, exactly: entries change places and signs.
    let cubes = cube_orientations();
    let together = cubes[draw.below(cubes.len())];
    for step in &mut case.path {
        step.state.pair = carried(&step.state.pair, &together, [0.0; 3]);
    }
    Some(case)
}

/// φ beside rest, half a turn or whole turns, reached in steps. Whole turns about any axis end in one orientation, half turns do
/// not: those are about `axis`, and what is left of them goes along `direction`.
fn beside_a_turn(
    connection: &ConnectionType,
    site: &Site,
    [axis, direction]: [Vector<f64>; 2],
    a0: Matrix<f64>,
    distance: f64,
    draw: &mut Draw,
) -> Case {
    let offset = if draw.is_structured() { draw.direction() } else { [0.5, -0.25, 1.0] };
    let reference = apply(&a0, offset);
    let definition = definition(connection, pair(reference, a0, &vector::identity()), 1.0);
    let still = [0.0; 3];
    let spin = if site.angle == 0.0 {
        scale(direction, distance)
    } else if site.angle < TAU {
        let half = scale(axis, site.angle);
        so3::continuous_log(&matrix_product(&exp(half), &exp(scale(direction, -distance))), half).phi
    } else {
        scale(direction, site.angle - distance)
    };
    let steps = (8.0 * site.angle / PI).max(1.0) as usize;
    let motion =
        Motion { common: still, spin: apply(&a0, spin), displacement: [still; 2], flow: [0.0; 2], steps };
    let mut path = motion.path(&definition.initial);
    if let Some(end) = path.last_mut() {
        end.state.velocity = draw.rates(1.0);
        end.state.acceleration = draw.rates(1.0);
    }
    let name = format!("{} {distance:e} from {}", connection.name, site.at);
    Case { name, definition, start: None, path, length: 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pintle_kinematics::catalog::TABLE;

    /// What has a singular point has a way to it, and what has none has none; each way leads there.
    #[test]
    fn every_singular_point_has_a_way() {
        let mut ways = Vec::new();
        for connection in TABLE {
            let slots = connection.slots.iter();
            for measure in slots.flat_map(|slot| [slot.position(), slot.printed()]).flatten() {
                let sites: Vec<Site> = Site::all(measure).collect();
                assert_eq!(Way::of(measure).is_some(), !sites.is_empty(), "{measure:?}");
                ways.extend(Way::of(measure).filter(|way| !ways.contains(way)));
            }
            let draw = &mut Draw::new(&connection.name);
            for (k, site) in sites(connection) {
                let case = beside(connection, &site, 1e-3, 0.4, draw).unwrap();
                let end = case.at_end().unwrap();
                let margin = end.connector.margins(&end.step.state, &end.after, [true; 6])[k];
                let is_there = margin.is_some_and(|margin| (margin.distance - 1e-3).abs() < 1e-9);
                let is_declared = site.measure.singular_sets().any(|set| set == site.set);
                assert!(is_there || !is_declared, "{} {k} {}: {margin:?}", connection.name, site.at);
            }
        }
        assert_eq!(ways.len(), 8, "{ways:?}");
    }
}
