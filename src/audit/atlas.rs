//! The atlas of singular points: each declared set, removable ones among them, is approached on a ladder of distances, from
//! several sides, and what happens there is compared with what the declaration says.

pub use super::beside::{Site, beside, near, random_near, sites};
use super::bound::{Bound, C, U};
use super::case::Case;
use super::force::product_with_forces as product;
use super::quantity::{Entries, Numbers, Quantity};
use super::sample::Draw;
use super::truth::Truth;
use crate::catalog::{COMPONENT, ConnectionType};
use crate::connector::{Output, Request};
use crate::measure::{LOCK, SingularClass, Unit};
use crate::node::DOFS;
use crate::scalar::Wide;
use serde::Serialize;

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
    /// The singular set, as declared.
    pub set: &'static str,
    /// The point: the set as declared, or which of its turns.
    pub at: &'static str,
    /// What the declaration says.
    pub declared: SingularClass,
    /// What was seen; `None` where it fits no class.
    pub seen: Option<SingularClass>,
    /// Whether the errors on every rung stay within what rounding explains. A value that is kept because rounding decides it, 1e-15
    /// from a lock, has no derivative to compare.
    pub exact: bool,
    /// The ladder.
    pub rungs: Vec<Rung>,
}

impl Approach {
    /// Whether what was seen is what is declared, and the numbers beside it are right.
    pub fn is_confirmed(&self) -> bool {
        self.seen == Some(self.declared) && self.exact
    }

    /// What was declared and what was seen, in words.
    pub fn told(&self) -> String {
        let seen = self.seen.map_or("none of the classes".into(), |class| format!("{class:?}"));
        let errors = if self.exact { "" } else { ", and numbers beyond rounding" };
        format!("declared {:?}, seen {seen}{errors}", self.declared)
    }
}

/// Steepness may grow by this factor from 1e-2 to 1e-6 away without counting as unbounded.
pub(super) const BOUNDED: f64 = 30.0;

/// A difference between the two sides, in rad or lengths, that is not an approach to one limit.
pub(super) const JUMP: f64 = 1e-3;

/// What is left of a jump where value and derivatives continue, 1e-8 from the point.
const CONTINUES: f64 = 1e-6;

/// Every singular point of a type.
pub fn atlas(connection: &ConnectionType) -> Vec<Approach> {
    let mut found = Vec::new();
    // Components that share a point share the states beside it.
    let mut known: Vec<(&'static str, Vec<Seen>)> = Vec::new();
    for (k, site) in sites(connection) {
        let at = |distance: f64, azimuth: f64| {
            beside(connection, &site, distance, azimuth, &mut Draw::new(&connection.name))
        };
        let row_is_of_it =
            at(0.1, 0.0).is_some_and(|case| case.connector().differentiated(k) == Some(site.measure));
        if !row_is_of_it {
            continue;
        }
        if !known.iter().any(|(known, _)| *known == site.at) {
            known.push((site.at, LADDER.iter().filter_map(|d| Seen::at(&at(*d, 0.0)?, *d)).collect()));
        }
        let seen = known.iter().filter(|(known, _)| *known == site.at).flat_map(|(_, seen)| seen);
        let rungs: Vec<Rung> = seen.map(|seen| seen.rung(k)).collect();
        let is_exact = |rung: &Rung| rung.value_error <= C && rung.first_error <= C;
        let is_kept = |rung: &Rung| site.measure.locks() && rung.distance < LOCK;
        found.push(Approach {
            connection: connection.name.to_string(),
            component: COMPONENT[k],
            set: site.set.at,
            at: site.at,
            declared: site.set.class,
            seen: classify(&at, k, &site),
            exact: rungs.len() == LADDER.len() && rungs.iter().all(|rung| is_kept(rung) || is_exact(rung)),
            rungs,
        });
    }
    found
}

/// The end of a case on doubles, and what differences on 237 bits say of it.
struct Seen {
    distance: f64,
    numbers: Numbers<f64>,
    truth: Numbers<Wide>,
    bound: Bound,
}

impl Seen {
    fn at(case: &Case, distance: f64) -> Option<Self> {
        let numbers = product(case)?;
        let wide = Truth::of(case)?;
        let mut truth = Numbers::default();
        truth.set(Quantity::Value, wide.value());
        truth.set(Quantity::FirstDerivatives, wide.first());
        // Second derivatives are in the bound alone.
        let mut trusted = truth_to_f64(&truth);
        trusted.set(Quantity::SecondDerivatives, numbers.entries(Quantity::SecondDerivatives).clone());
        let still = [0.0; DOFS];
        let bound = Bound::new(&trusted, &still, &still, case.length, distance);
        Some(Self { distance, numbers, truth, bound })
    }

    /// Errors of component k.
    fn rung(&self, k: usize) -> Rung {
        let steepness = steepness(&self.numbers, k);
        let errors = |quantity: Quantity| {
            let mut worst = (0.0_f64, 0.0_f64);
            let given = &self.numbers.entries(quantity).0[k];
            let largest = given.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
            for (i, want) in self.truth.entries(quantity).0[k].iter().flatten().enumerate() {
                let got = self.numbers.entries(quantity).get(k, i).unwrap_or(f64::NAN);
                let error = (Wide::from_f64(got) - *want).abs().to_f64();
                if error == 0.0 {
                    continue;
                }
                let all = [error / (U * self.bound.scale(quantity, k, i)), error / largest];
                // A maximum would drop what is not a number.
                let more = |most: f64, x: f64| if x <= most { most } else { x };
                worst = (more(worst.0, all[0]), more(worst.1, all[1]));
            }
            worst
        };
        let (first_error, first_relative) = errors(Quantity::FirstDerivatives);
        let value_error = errors(Quantity::Value).0;
        Rung { distance: self.distance, value_error, first_error, first_relative, steepness }
    }
}

/// The largest first derivative of component k.
fn steepness(numbers: &Numbers<f64>, k: usize) -> f64 {
    let row = numbers.entries(Quantity::FirstDerivatives).0[k].iter().flatten();
    row.fold(0.0_f64, |most, x| most.max(x.abs()))
}

/// 237-bit numbers rounded to doubles.
pub(super) fn truth_to_f64(truth: &Numbers<Wide>) -> Numbers<f64> {
    let mut narrow = Numbers::default();
    for quantity in Quantity::ALL {
        narrow.set(quantity, truth.entries(quantity).map(|_, _, x| x.to_f64()));
    }
    narrow
}

/// What happens at a point: derivatives that grow without bound from every side, a value that jumps, with derivatives that jump or without,
/// derivatives that jump alone, or nothing.
fn classify(at: &impl Fn(f64, f64) -> Option<Case>, k: usize, site: &Site) -> Option<SingularClass> {
    // From one side, from the other, and from the side, towards one and the same point.
    let sides: &[(f64, f64)] = if site.has_two_sides() {
        &[(1.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (1.0, -2.0)]
    } else {
        &[(1.0, 0.0)]
    };
    let from = |distance: f64, (sign, azimuth): (f64, f64)| {
        let case = at(sign * distance, azimuth)?;
        let mut numbers = product(&case)?;
        // Not by the displacement: the initial state may be another for each side.
        let position = || Some(case.evaluation(&Request::new(&[Output::CP], [true; 6], 0))?.0.position[k]);
        if case.connector().position_measure(k) == Some(site.measure) {
            let mut values = Entries::default();
            values.0[k] = position()?.map(|x| vec![x]);
            numbers.set(Quantity::Value, values);
        }
        Some(numbers)
    };
    let mut unbounded = 0;
    for side in sides {
        let [near, far] = [from(1e-6, *side)?, from(1e-2, *side)?].map(|numbers| steepness(&numbers, k));
        unbounded += usize::from(near > BOUNDED * far);
    }
    if unbounded == sides.len() {
        return Some(SingularClass::TrueSingularity);
    }
    const NEAR: f64 = 1e-8;
    let jump = |x: &Numbers<f64>, y: &Numbers<f64>, quantity: Quantity| {
        let of = |numbers: &Numbers<f64>| numbers.entries(quantity).0[k].clone();
        Some(of(x)?.into_iter().zip(of(y)?).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs())))
    };
    let this = from(NEAR, (1.0, 0.0))?;
    let others: Vec<Numbers<f64>> = sides.iter().filter_map(|side| from(NEAR, *side)).collect();
    let largest = |quantity: Quantity| {
        others.iter().try_fold(0.0_f64, |most, other| Some(most.max(jump(&this, other, quantity)?)))
    };
    if largest(Quantity::Value)? > JUMP {
        // From the sides where the value is the same, towards one and the same point.
        let mut turns = false;
        for other in &others {
            let is_same = jump(&this, other, Quantity::Value)? <= JUMP;
            turns |= is_same && jump(&this, other, Quantity::FirstDerivatives)? > JUMP;
        }
        let class = if turns { SingularClass::Reversal } else { SingularClass::BranchCut };
        return (site.measure.unit() == Unit::Angle).then_some(class);
    }
    if largest(Quantity::FirstDerivatives)? > JUMP {
        return Some(SingularClass::Kink);
    }
    // What continues from all sides must be what is said at the point itself, second derivatives too.
    let there = from(0.0, (1.0, 0.0))?;
    let mut continues = true;
    for quantity in [Quantity::Value, Quantity::FirstDerivatives, Quantity::SecondDerivatives] {
        let most = largest(quantity)?.max(jump(&this, &there, quantity)?);
        continues &= most < CONTINUES;
    }
    continues.then_some(SingularClass::Removable)
}
