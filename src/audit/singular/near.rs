//! States of a given connector beside its singular points: for somebody's own routine, which has one definition and no history.

use crate::case::{Case, Step};
use crate::sampling::rates;
use crate::singular::beside::{Site, Way, by_cardan_angles, by_euler_angles, by_shafts, sites};
use pintle_kinematics::connector::Definition;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::Pair;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{
    Matrix, Vector, apply, apply_transposed, product, scale, sub, transpose, transposed_product,
};
use std::f64::consts::PI;

/// How often a point and a direction are drawn.
const ATTEMPTS: usize = 40;

/// The singular points of a definition that its nodes can be brought to.
#[derive(Clone, Debug)]
pub struct Sites(Vec<Site>);

/// Whether a definition has singular points that [`near_initial`] can lead to.
pub fn has_sites(definition: &Definition) -> bool {
    !Sites::of(definition).is_empty()
}

/// A state 1e-1 to 1e-12 away from a singular point of a connector, removable ones among them, from either side, any direction; the
/// nodes that can have turned and moved besides. `None` where the degrees of freedom lead to none.
pub fn near_initial(definition: &Definition, length: f64, name: &str, draw: &mut Draw) -> Option<Case> {
    let (mut step, told) = Sites::of(definition).near(definition, length, draw)?;
    step.state.velocity = rates(definition, length, draw);
    step.state.acceleration = rates(definition, length, draw);
    let name = format!("{name}, {told}");
    Some(Case { name, definition: definition.clone(), start: None, path: vec![step], length })
}

impl Sites {
    /// Those of a definition.
    pub fn of(definition: &Definition) -> Self {
        let all = sites(&definition.connection).into_iter().map(|(_, site)| site);
        Self(all.filter(|site| leads_to(definition, site)).collect())
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The step from the initial state of their definition to one as of [`near_initial`], at rest, and how near to what it is, in words.
    pub fn near(&self, definition: &Definition, length: f64, draw: &mut Draw) -> Option<(Step, String)> {
        if self.is_empty() {
            return None;
        }
        for _ in 0..ATTEMPTS {
            let site = self.0.get(draw.below(self.0.len()))?;
            let distance = 10.0_f64.powf(-draw.between(1.0, 12.0));
            let Some(after) = beside(definition, site, distance, length, draw) else { continue };
            let step = Step::between(&definition.initial, after);
            return Some((step, format!("{distance:.1e} from {}", site.at)));
        }
        None
    }
}

/// Whether the nodes can be brought there, and what they give does not depend on how they came.
fn leads_to(definition: &Definition, site: &Site) -> bool {
    let turns = (0..2).any(|end| definition.moves[end] && definition.rotates[end]);
    let Some(way) = site.way() else { return false };
    match way {
        Way::Distance => definition.moves != [false; 2],
        Way::Radius => definition.moves != [false; 2] && !definition.planar,
        Way::Material => definition.moves[1],
        // Whole turns, and which of two half turns it is, are a matter of history.
        Way::Turn => site.is_at_rest() && turns && !definition.planar,
        Way::Cardan | Way::Euler | Way::Shafts | Way::Misalignment => turns && !definition.planar,
    }
}

/// The pair there.
fn beside(
    definition: &Definition,
    site: &Site,
    distance: f64,
    length: f64,
    draw: &mut Draw,
) -> Option<Pair<f64>> {
    let initial = &definition.initial;
    let can_turn = [0, 1].map(|end| definition.moves[end] && definition.rotates[end]);
    let in_plane = |v: Vector<f64>| if definition.planar { [v[0], v[1], 0.0] } else { v };
    let about = |draw: &mut Draw, most: f64| {
        let spin = scale(draw.direction(), draw.between(0.0, most));
        exp(if definition.planar { [0.0, 0.0, spin[2]] } else { spin })
    };
    let q0 = transposed_product(&initial.a.triad, &initial.b.triad);
    let way = site.way()?;
    let q = relative((site, way), &q0, distance, draw);
    let mut after = *initial;
    match (q, can_turn) {
        (Some(q), [true, true]) => {
            after.a.triad = product(&about(draw, 3.0), &initial.a.triad);
            after.b.triad = product(&after.a.triad, &q);
        }
        (Some(q), [false, true]) => after.b.triad = product(&initial.a.triad, &q),
        (Some(q), [true, false]) => after.a.triad = product(&initial.b.triad, &transpose(&q)),
        (Some(_), [false, false]) => return None,
        (None, turns) => {
            let common = about(draw, 3.0);
            for (node, turns) in [&mut after.a, &mut after.b].into_iter().zip(turns) {
                if turns {
                    node.triad = product(&common, &node.triad);
                }
            }
        }
    }
    let a = &after.a.triad;
    let separation = match way {
        Way::Distance => {
            let direction = in_plane(draw.direction());
            scale(direction, distance * length / norm(direction))
        }
        Way::Radius => {
            let angle = draw.between(-PI, PI);
            let [x, y] = [angle.cos(), angle.sin()].map(|part| part * distance * length);
            let along = apply_transposed(&initial.a.triad, initial.reference)[2];
            apply(a, [x, y, if along == 0.0 { length } else { along }])
        }
        Way::Material | Way::Cardan | Way::Euler | Way::Shafts | Way::Misalignment | Way::Turn => {
            let by = scale(in_plane(draw.direction()), draw.between(0.0, 0.5) * length);
            let carried = apply(a, apply_transposed(&initial.a.triad, initial.separation()));
            [0, 1, 2].map(|i| carried[i] + by[i])
        }
    };
    let relative = sub(separation, initial.reference);
    match definition.moves {
        [true, true] => {
            after.a.displacement = scale(in_plane(draw.direction()), draw.between(0.0, 0.5) * length);
            after.b.displacement = [0, 1, 2].map(|i| after.a.displacement[i] + relative[i]);
        }
        [false, true] => after.b.displacement = [0, 1, 2].map(|i| after.a.displacement[i] + relative[i]),
        [true, false] => after.a.displacement = [0, 1, 2].map(|i| after.b.displacement[i] - relative[i]),
        [false, false] => {}
    }
    if way == Way::Material {
        // The material that is left: l₀ + Ψ_a − Ψ_b.
        after.b.flow = norm(initial.reference) + after.a.flow - distance * length;
    }
    Some(after)
}

/// Q beside the point, its other angles within half a radian of those of the initial Q₀; `None` where it is a length that matters.
fn relative(
    (site, way): (&Site, Way),
    q0: &Matrix<f64>,
    distance: f64,
    draw: &mut Draw,
) -> Option<Matrix<f64>> {
    // Away from ±π, where a principal value jumps.
    let mut beside = |angle: f64| {
        let by = draw.between(0.05, 0.5);
        if angle > 0.0 { angle - by } else { angle + by }
    };
    let middle = if site.is_at_rest() { distance } else { site.angle() - distance };
    let of_shafts = [q0[1][2].atan2(q0[0][2]), q0[2][1].atan2(-q0[2][0])];
    Some(match way {
        Way::Distance | Way::Radius | Way::Material => return None,
        Way::Cardan => {
            let [alpha, gamma] = [(-q0[1][2]).atan2(q0[2][2]), (-q0[0][1]).atan2(q0[0][0])].map(&mut beside);
            by_cardan_angles([alpha, site.angle() - site.angle().signum() * distance, gamma])
        }
        Way::Euler => {
            let [alpha, gamma] = [q0[0][2].atan2(-q0[1][2]), q0[2][0].atan2(q0[2][1])].map(&mut beside);
            by_euler_angles([alpha, middle, gamma])
        }
        Way::Shafts => {
            let [sweep, rest] = of_shafts.map(&mut beside);
            by_shafts([sweep, middle, rest])
        }
        Way::Misalignment => product(&exp(scale(draw.direction(), middle)), q0),
        Way::Turn => exp(scale(draw.direction(), distance)),
    })
}
