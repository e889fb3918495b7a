//! The atlas of singular points: each declared set, removable ones among them, is approached on a ladder of distances, from
//! several sides, and what happens there is compared with what the declaration says.

use crate::case::Case;
use crate::case::quantity::{Numbers, Quantity};
use crate::judge::bound::{Bound, C};
use crate::oracles::force::product_with_forces as product;
use crate::oracles::truth::Truth;
pub use crate::singular::beside::{Site, beside, near, random_near, sites};
use pintle_kinematics::catalog::{COMPONENT, ConnectionType};
use pintle_kinematics::connector::{Output, Request, State};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::{LOCK, SingularClass, Unit};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::{U, Wide};
use serde::Serialize;
use std::iter::zip;

/// The distances at which a set is approached.
pub const LADDER: [f64; 15] =
    [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15];

/// One rung of the ladder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Rung {
    /// The distance to the set (rad, or lengths of the connector).
    pub distance: f64,
    /// The error of the value in units u of its conditioned scale, against 237 bits.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub value_error: f64,
    /// The largest error of a first derivative in units u of the conditioned scale.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub first_error: f64,
    /// The same relative to the largest derivative of the row: how many digits are left.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub first_relative: f64,
    /// The largest first derivative, lengths in units of the connector's.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub steepness: f64,
    /// The relative error of the largest first derivative from which on it would have been noticed here, 2 C u F/|∂f| with its conditioned scale F; 1 where nothing less would.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub detectable: f64,
}

impl Rung {
    /// Of a value and of its first derivatives: as they are, as they must be, and their conditioned scales.
    pub fn of(distance: f64, [value, first]: [(&[f64], &[Wide], Vec<f64>); 2]) -> Self {
        // The largest error in units u of the scales, and relative to the largest number.
        let errors = |(got, want, scales): &(&[f64], &[Wide], Vec<f64>)| {
            let largest = largest(got);
            let mut worst = [0.0; 2];
            for (i, (want, scale)) in zip(*want, scales).enumerate() {
                let got = got.get(i).copied().unwrap_or(f64::NAN);
                let error = (Wide::from_f64(got) - *want).abs().to_f64();
                if error != 0.0 {
                    // A maximum would drop what is not a number.
                    let more = |most: f64, x: f64| if x <= most { most } else { x };
                    worst = [more(worst[0], error / (U * scale)), more(worst[1], error / largest)];
                }
            }
            worst
        };
        let [value_error, _] = errors(&value);
        let [first_error, first_relative] = errors(&first);
        let (got, _, scales) = &first;
        let detectable = detectable(zip(got.iter().copied(), scales.iter().copied()));
        Self { distance, value_error, first_error, first_relative, steepness: largest(got), detectable }
    }

    /// Whether errors are no more than rounding explains.
    pub fn is_exact(&self) -> bool {
        self.value_error <= C && self.first_error <= C
    }
}

/// The largest number.
fn largest(of: &[f64]) -> f64 {
    of.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// The relative error of the largest of some first derivatives, each with its conditioned scale, that a rung would notice.
/// It exceeds what the derivative may be off, [`C`] units u of that scale, whatever it is off by already.
fn detectable(first: impl Iterator<Item = (f64, f64)>) -> f64 {
    let largest = first.max_by(|x, y| x.0.abs().total_cmp(&y.0.abs()));
    let least = largest.map_or(f64::INFINITY, |(first, scale)| 2.0 * C * U * scale / first.abs());
    if least <= 1.0 { least } else { 1.0 }
}

/// One singular set of one component, approached.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
const BOUNDED: f64 = 30.0;

/// A difference between the two sides, in rad or lengths, that is not an approach to one limit.
const JUMP: f64 = 1e-3;

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
        let sides = if site.has_two_sides() { SIDES.as_slice() } else { &SIDES[..1] };
        let is_kept = |rung: &Rung| site.measure.locks() && rung.distance < LOCK;
        found.push(Approach {
            connection: connection.name.to_string(),
            component: COMPONENT[k],
            set: site.set.at,
            at: site.at,
            declared: site.set.class,
            seen: classify(sides, site.measure.unit(), |distance, azimuth| {
                of_component(&at(distance, azimuth)?, k, &site)
            }),
            exact: rungs.len() == LADDER.len() && rungs.iter().all(|rung| is_kept(rung) || rung.is_exact()),
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
        let state = State { velocity: still, acceleration: still, ..case.last()?.state };
        let bound = Bound::new(&trusted, &state, case.length, distance);
        Some(Self { distance, numbers, truth, bound })
    }

    /// Errors of component k.
    fn rung(&self, k: usize) -> Rung {
        let of = |quantity: Quantity| {
            let got = self.numbers.entries(quantity).0[k].as_deref().unwrap_or_default();
            let want = self.truth.entries(quantity).0[k].as_deref().unwrap_or_default();
            let scales = (0..want.len().max(got.len())).map(|i| self.bound.scale(quantity, k, i));
            (got, want, scales.collect::<Vec<f64>>())
        };
        Rung::of(self.distance, [Quantity::Value, Quantity::FirstDerivatives].map(of))
    }
}

/// 237-bit numbers rounded to doubles.
pub fn truth_to_f64(truth: &Numbers<Wide>) -> Numbers<f64> {
    let mut narrow = Numbers::default();
    for quantity in Quantity::ALL {
        narrow.set(quantity, truth.entries(quantity).map(|_, _, x| x.to_f64()));
    }
    narrow
}

/// What a function is at a state beside a point, on doubles.
pub struct Beside {
    pub(crate) value: f64,
    pub(crate) first: Vec<f64>,
    /// Empty, where what continues need not be told from what is removable.
    pub(crate) second: Vec<f64>,
}

impl Beside {
    fn is_finite(&self) -> bool {
        let Self { value, first, second } = self;
        [value].into_iter().chain(first).chain(second).all(|x| x.is_finite())
    }

    /// The largest first derivative.
    pub fn steepness(&self) -> f64 {
        largest(&self.first)
    }
}

/// What component k is beside a point of it.
fn of_component(case: &Case, k: usize, site: &Site) -> Option<Beside> {
    let numbers = product(case)?;
    let of = |quantity: Quantity| numbers.entries(quantity).0[k].clone();
    let [first, second] = [Quantity::FirstDerivatives, Quantity::SecondDerivatives].map(of);
    // Not by the displacement: the initial state may be another for each side.
    let value = if case.connector().position_measure(k) == Some(site.measure) {
        case.evaluation(&Request::new(&[Output::CP], [true; 6], 0))?.0.position[k]
    } else {
        of(Quantity::Value)?.first().copied()
    };
    Some(Beside { value: value?, first: first?, second: second? })
}

/// From one side, from the other, and from the side, towards one and the same point: signs and azimuths (rad).
pub const SIDES: [(f64, f64); 4] = [(1.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (1.0, -2.0)];

/// What happens at a point that is approached from some sides:
///
/// - derivatives grow without bound from every side
/// - a value jumps, with derivatives that jump or without
/// - derivatives jump alone
/// - nothing
///
/// None of these where a number is not finite, or a length jumps.
pub fn classify(
    sides: &[(f64, f64)],
    unit: Unit,
    seen: impl Fn(f64, f64) -> Option<Beside>,
) -> Option<SingularClass> {
    const NEAR: f64 = 1e-8;
    let from =
        |distance: f64, (sign, azimuth): (f64, f64)| seen(sign * distance, azimuth).filter(Beside::is_finite);
    let mut unbounded = 0;
    for side in sides {
        let [near, far] = [from(1e-6, *side)?, from(1e-2, *side)?].map(|beside| beside.steepness());
        unbounded += usize::from(near > BOUNDED * far);
    }
    if unbounded == sides.len() {
        return Some(SingularClass::TrueSingularity);
    }
    let all: Vec<Beside> = sides.iter().map(|side| from(NEAR, *side)).collect::<Option<_>>()?;
    let this = all.first()?;
    let apart = |x: &[f64], y: &[f64]| zip(x, y).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
    let value = |other: &Beside| (this.value - other.value).abs();
    let first = |other: &Beside| apart(&this.first, &other.first);
    if all.iter().any(|other| value(other) > JUMP) {
        // From the sides where the value is the same, towards one and the same point.
        let turns = all.iter().any(|other| value(other) <= JUMP && first(other) > JUMP);
        let class = if turns { SingularClass::Reversal } else { SingularClass::BranchCut };
        return (unit == Unit::Angle).then_some(class);
    }
    if all.iter().any(|other| first(other) > JUMP) {
        return Some(SingularClass::Kink);
    }
    // What continues from all sides must be what is said at the point itself, second derivatives too.
    let there = from(0.0, *sides.first()?)?;
    let continues = |other: &Beside| {
        let second = apart(&this.second, &other.second);
        [value(other), first(other), second].iter().all(|apart| *apart < CONTINUES)
    };
    all.iter().chain([&there]).all(continues).then_some(SingularClass::Removable)
}
