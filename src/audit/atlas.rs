//! The atlas of singular points: each declared set is approached on a ladder of distances, from both sides, and what happens
//! there is compared with what the declaration says.

use super::bound::{Bound, U};
use super::case::{Case, Step, carried, turn};
use super::force::product_with_forces as product;
use super::quantity::{Numbers, Quantity};
use super::sample::{Draw, Motion, about_1, about_3, cube_orientations, definition, pair};
use super::truth::Truth;
use crate::catalog::{COMPONENT, ConnectionType};
use crate::measure::{Measure, SingularClass, Unit};
use crate::node::DOFS;
use crate::vector::{self, Matrix, Vector, apply, product as matrix_product, scale};
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The distances at which a set is approached.
pub const LADDER: [f64; 15] =
    [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15];

/// One rung of the ladder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Rung {
    /// The distance to the set (rad, or lengths of the connector).
    pub distance: f64,
    /// The error of the value in units u of its conditioned scale, against 237 bits.
    #[schemars(with = "Option<f64>")]
    pub value_error: f64,
    /// The largest error of a first derivative in units u of the conditioned scale.
    #[schemars(with = "Option<f64>")]
    pub first_error: f64,
    /// The same relative to the largest derivative of the row: how many digits are left.
    #[schemars(with = "Option<f64>")]
    pub first_relative: f64,
    /// The largest first derivative, lengths in units of the connector's.
    #[schemars(with = "Option<f64>")]
    pub steepness: f64,
}

/// One singular set of one component, approached.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Approach {
    /// The connection type.
    pub connection: String,
    /// The component: `ur1`.
    pub component: &'static str,
    /// The set, as declared.
    pub at: &'static str,
    /// What the declaration says.
    pub declared: SingularClass,
    /// What was seen; `None` where it fits no class.
    pub seen: Option<SingularClass>,
    /// The ladder.
    pub rungs: Vec<Rung>,
}

impl Approach {
    /// Whether what was seen is what is declared.
    pub fn is_confirmed(&self) -> bool {
        self.seen == Some(self.declared)
    }
}

/// Steepness may grow by this factor from 1e-2 to 1e-6 away without counting as unbounded.
const BOUNDED: f64 = 30.0;

/// A difference between the two sides, in rad or lengths, that is not an approach to one limit.
const JUMP: f64 = 1e-3;

/// Every singular set of a type.
pub fn atlas(connection: &ConnectionType) -> Vec<Approach> {
    let mut found = Vec::new();
    for k in 0..6 {
        let slot = connection.slots[k];
        let Some(measure) = slot.position() else { continue };
        let Some(set) = measure.singular_set() else { continue };
        let at = |distance: f64, azimuth: f64| {
            near(connection, measure, distance, azimuth, &mut Draw::new(&connection.name))
        };
        let row_is_of_it = Case::connector(&match at(0.1, 0.0) {
            Some(case) => case,
            None => continue,
        })
        .differentiated(k)
            == Some(measure);
        if !row_is_of_it {
            continue;
        }
        let rungs: Vec<Rung> = LADDER.iter().filter_map(|d| rung(&at(*d, 0.0)?, k, *d)).collect();
        found.push(Approach {
            connection: connection.name.to_string(),
            component: COMPONENT[k],
            at: set.at,
            declared: set.class,
            seen: classify(&at, k, &rungs, measure),
            rungs,
        });
    }
    found
}

/// The end of a case on doubles and in 237 bits: errors of component k.
fn rung(case: &Case, k: usize, distance: f64) -> Option<Rung> {
    let numbers = product(case)?;
    let truth = Truth::of(case)?.dual();
    let narrow = truth_to_f64(&truth);
    let still = [0.0; DOFS];
    let bound = Bound::new(&narrow, &still, &still, case.length, distance);
    let errors = |quantity: Quantity| {
        let mut worst = (0.0_f64, 0.0_f64);
        let largest =
            numbers.entries(quantity).0[k].iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (i, want) in truth.entries(quantity).0[k].iter().flatten().enumerate() {
            let got = numbers.entries(quantity).get(k, i).unwrap_or(f64::NAN);
            let error = (crate::scalar::Wide::from_f64(got) - *want).abs().to_f64();
            let units = error / (U * bound.scale(quantity, k, i));
            worst.0 = worst.0.max(if error == 0.0 { 0.0 } else { units });
            worst.1 = worst.1.max(if error == 0.0 { 0.0 } else { error / largest });
        }
        worst
    };
    let steepness = numbers.entries(Quantity::FirstDerivatives).0[k]
        .iter()
        .flatten()
        .fold(0.0_f64, |most, x| most.max(x.abs()));
    Some(Rung {
        distance,
        value_error: errors(Quantity::Value).0,
        first_error: errors(Quantity::FirstDerivatives).0,
        first_relative: errors(Quantity::FirstDerivatives).1,
        steepness,
    })
}

/// 237-bit numbers rounded to doubles.
pub(super) fn truth_to_f64(truth: &Numbers<crate::scalar::Wide>) -> Numbers<f64> {
    let mut narrow = Numbers::default();
    for quantity in Quantity::ALL {
        narrow.set(quantity, truth.entries(quantity).map(|_, _, x| x.to_f64()));
    }
    narrow
}

/// What happens at the set: derivatives that grow without bound, a value that jumps, a derivative that jumps.
fn classify(
    at: &impl Fn(f64, f64) -> Option<Case>,
    k: usize,
    rungs: &[Rung],
    measure: Measure,
) -> Option<SingularClass> {
    let steepness =
        |distance: f64| rungs.iter().find(|rung| rung.distance == distance).map(|rung| rung.steepness);
    if steepness(1e-6)? > BOUNDED * steepness(1e-2)? {
        return Some(SingularClass::TrueSingularity);
    }
    const NEAR: f64 = 1e-8;
    let this = product(&at(NEAR, 0.0)?)?;
    let value = |numbers: &Numbers<f64>| numbers.entries(Quantity::Value).get(k, 0);
    let row = |numbers: &Numbers<f64>| numbers.entries(Quantity::FirstDerivatives).0[k].clone();
    let mut jump = 0.0_f64;
    // From the other side, and from the side, towards one and the same point of the set.
    for (distance, azimuth) in [(-NEAR, 0.0), (NEAR, 1.0), (NEAR, -2.0)] {
        let other = product(&at(distance, azimuth)?)?;
        if (value(&this)? - value(&other)?).abs() > JUMP {
            let is_period = measure.unit() == Unit::Angle;
            return is_period.then_some(SingularClass::BranchCut);
        }
        jump = row(&this)?.iter().zip(row(&other)?).fold(jump, |most, (x, y)| most.max((x - y).abs()));
    }
    (jump > JUMP).then_some(SingularClass::Kink)
}

/// A case whose end is `distance` away from the singular set of a measure, on its other side where negative, in the direction
/// `azimuth` (rad) about the point of the set that is nearest; lengths are 1. `None` where the measure has no singular set.
pub fn near(
    connection: &ConnectionType,
    measure: Measure,
    distance: f64,
    azimuth: f64,
    draw: &mut Draw,
) -> Option<Case> {
    let set = measure.singular_set()?;
    // The 24 orientations of a cube turn without rounding.
    let cubes = cube_orientations();
    let a0 = cubes[draw.below(cubes.len())];
    let axis = draw.direction();
    let direction = apply(&turn([0.0, azimuth, 0.0]), axis);
    let [alpha, gamma] = [draw.between(0.3, 0.9), draw.between(-0.9, -0.3)];
    let about_2 = |angle: f64| turn([0.0, angle, 0.0]);
    let between = |first: &Matrix<f64>, middle: &Matrix<f64>, last: &Matrix<f64>| {
        matrix_product(&matrix_product(first, middle), last)
    };
    let mut reference = apply(&a0, [0.5, -0.25, 1.0]);
    let mut flow = [0.0; 2];
    // Q at the start, which is regular, and at the end.
    let still = turn([0.2, -0.3, 0.1]);
    let (start, end) = match measure {
        Measure::Distance => {
            reference = scale(direction, distance);
            (still, still)
        }
        Measure::Strain => {
            reference = apply(&a0, [1.0, 0.0, 0.0]);
            flow = [0.0, 1.0 - distance];
            (still, still)
        }
        Measure::RadialDistance => {
            reference = apply(&a0, [distance * (0.6 + azimuth).cos(), distance * (0.6 + azimuth).sin(), 1.0]);
            (still, still)
        }
        Measure::Cardan(_) => {
            // At β = π/2 only γ + α is left.
            let q = |beta: f64| between(&about_1(alpha + azimuth), &about_2(beta), &about_3(gamma - azimuth));
            (q(0.6), q(FRAC_PI_2 - distance))
        }
        Measure::Euler(_) => {
            let q = |beta: f64| between(&about_3(alpha + azimuth), &about_1(beta), &about_3(gamma - azimuth));
            (q(0.6), q(distance))
        }
        Measure::Flexion | Measure::Sweep => {
            let q = |beta: f64| between(&about_3(alpha + azimuth), &about_2(beta), &about_3(gamma - azimuth));
            (q(0.6), q(distance))
        }
        Measure::Torsion | Measure::ComponentFlexion(_) | Measure::ProjectedPosition(_) => {
            // At α = π only the difference of the two is left.
            let q = |beta: f64| between(&about_3(alpha + azimuth), &about_2(beta), &about_3(gamma + azimuth));
            (q(2.0), q(PI - distance))
        }
        Measure::Misalignment(_) => (vector::identity(), turn(scale(axis, PI - distance))),
        Measure::RotationVector(_) | Measure::RotationVectorAtB(_) => {
            return Some(beside_a_turn(connection, direction, a0, distance, draw));
        }
        _ => return None,
    };
    let definition = definition(connection, pair(reference, a0, &start), 1.0);
    let mut after = pair(reference, a0, &end);
    [after.a.flow, after.b.flow] = flow;
    let mut step = Step::between(&definition.initial, after);
    step.state.velocity = draw.rates(1.0);
    step.state.acceleration = draw.rates(1.0);
    let name = format!("{} {distance:e} from {}", connection.name, set.at);
    Some(Case { name, definition, start: None, path: vec![step], length: 1.0 })
}

/// Random states near the singular sets of a type: 1e-1 to 1e-12 away, from either side, from any direction, with both nodes
/// turned besides. Nothing for a type that has no singular set.
pub fn random_near(connection: &ConnectionType, draw: &mut Draw) -> Option<Case> {
    let measures: Vec<Measure> = connection.singular_measures().collect();
    let measure = *measures.get(draw.below(measures.len()))?;
    let sign = if draw.unit() < 0.5 { 1.0 } else { -1.0 };
    let distance = sign * 10.0_f64.powf(-draw.between(1.0, 12.0));
    // A strain has no other side.
    let distance = if measure == Measure::Strain { distance.abs() } else { distance };
    let azimuth = draw.between(-PI, PI);
    let mut case = near(connection, measure, distance, azimuth, draw)?;
    // Turned together, exactly: entries change places and signs.
    let cubes = cube_orientations();
    let together = cubes[draw.below(cubes.len())];
    for step in &mut case.path {
        step.state.pair = carried(&step.state.pair, &together, [0.0; 3]);
    }
    Some(case)
}

/// φ of length 2π − distance, reached in steps.
fn beside_a_turn(
    connection: &ConnectionType,
    direction: Vector<f64>,
    a0: Matrix<f64>,
    distance: f64,
    draw: &mut Draw,
) -> Case {
    let reference = apply(&a0, [0.5, -0.25, 1.0]);
    let definition = definition(connection, pair(reference, a0, &vector::identity()), 1.0);
    let still = [0.0; 3];
    let motion = Motion {
        common: still,
        spin: apply(&a0, scale(direction, TAU - distance)),
        displacement: [still; 2],
        flow: [0.0; 2],
        steps: 16,
    };
    let mut path = motion.path(&definition.initial);
    if let Some(end) = path.last_mut() {
        end.state.velocity = draw.rates(1.0);
        end.state.acceleration = draw.rates(1.0);
    }
    let name = format!("{} {distance:e} from |φ| = 2π", connection.name);
    Case { name, definition, start: None, path, length: 1.0 }
}
