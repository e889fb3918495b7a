//! Oracles that tell sums of derivatives along directions instead of entries: Taylor's remainder, and hyper-dual numbers.

use crate::case::Case;
use crate::case::quantity::Quantity;
use crate::judge::bound::Bound;
use crate::judge::components::{Along, try_along};
use crate::judge::examined::Examined;
use crate::judge::judged::decided;
use crate::judge::outcome::{Against, Check};
use crate::judge::verdict::{Finding, Judgement, Score, Summand, Verdict};
use crate::mutants::mutant::Mutant;
use crate::oracles::force::product_at;
use crate::oracles::oracle::{Narrow, Oracle, Remainder, WideAnswers, remainders};
use crate::oracles::truth::Truth;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::DOFS;

/// The sum of a component, what it must be, and how far apart they may be.
struct Sum {
    component: usize,
    entry: String,
    got: f64,
    want: f64,
    units: f64,
    tolerance: f64,
    /// What the sum must be less what it is, and what rounding of the entries alone allows that to be.
    off: (f64, f64),
}

impl Sum {
    fn finding(self, sum: Vec<Summand>) -> Finding {
        let Self { entry, got, want, units, tolerance, .. } = self;
        Finding { sum, ..Finding::new(entry, [got, want], tolerance, units) }
    }
}

/// The check of sums, each entry with its weight; `None` where there is no sum.
fn check(
    examined: &Examined<'_>,
    (quantity, oracle): (Quantity, Oracle),
    weight: &dyn Fn(usize) -> f64,
    sums: Vec<Sum>,
    made: &[Mutant],
) -> Option<Check> {
    let mut off = [None; 6];
    sums.iter().for_each(|sum| off[sum.component] = Some(sum.off));
    let compared = sums.len();
    // One without a tolerance tells less than a wrong one, and more than a right one.
    let told = |sum: &Sum| (decided(sum.want, sum.tolerance, sum.units), sum.units);
    let worst = sums.into_iter().reduce(|worst, sum| if told(&sum) > told(&worst) { sum } else { worst })?;
    let (verdict, _) = told(&worst);
    let rows = examined.numbers.entries(quantity);
    let score = match verdict {
        Verdict::Pass => try_along(quantity, rows, &Along { weight, off }, made),
        _ => Score::default(),
    };
    let mut check = Check::new(Some(quantity), Against::Oracle(oracle));
    let entries = (0..quantity.entries()).map(|entry| (entry, weight(entry))).filter(|(_, by)| *by != 0.0);
    let component = worst.component;
    let sum = entries.map(|(entry, by)| Summand { quantity, component, entry, by }).collect();
    check.add(Judgement { verdict, worst: Some(worst.finding(sum)), compared }, score, examined.case);
    check.compares(|k| rows.0[k].is_some(), |k| off[k].is_some());
    Some(check)
}

/// A random direction of the nodes: 1 rad, one length.
fn direction(draw: &mut Draw, length: f64, active: &[bool; DOFS]) -> [f64; DOFS] {
    let mut v = draw.rates(length);
    for (x, active) in v.iter_mut().zip(active) {
        if !active {
            *x = 0.0;
        }
    }
    v
}

/// Taylor's remainder of a component of the product along a direction.
pub fn remainder_along(case: &Case, component: usize, v: &[f64; DOFS]) -> Option<Remainder> {
    let end = case.at_end()?;
    let (numbers, truth) = (product_at(&end), Truth::at(&end));
    let nearness = truth.nearness_of_components();
    let trusted = WideAnswers::of(&truth).trusted(&nearness.map(|near| near > 0.0));
    let bound = Bound::of_components(&trusted, &end.step.state, case.length, &nearness);
    let rows = numbers.entries(Quantity::FirstDerivatives);
    let mut all = remainders(&truth, rows, &bound, v, &nearness).into_iter();
    all.find(|remainder| remainder.component == component)
}

/// First derivatives along a random direction, by the remainder of values on 237 bits.
pub fn taylor(
    examined: &Examined<'_>,
    truth: &Truth,
    nearness: &[f64; 6],
    draw: &mut Draw,
    made: &[Mutant],
) -> Option<Check> {
    let quantity = Quantity::FirstDerivatives;
    let mut active = [false; DOFS];
    for j in truth.active() {
        active[j] = true;
    }
    let v = direction(draw, examined.case.length, &active);
    let rows = examined.numbers.entries(quantity);
    let found = remainders(truth, rows, &examined.bound, &v, nearness).into_iter().map(|remainder| {
        let (k, [largest, allowed]) = (remainder.component, remainder.largest);
        Sum {
            component: k,
            entry: format!("∂{}·v, {}", COMPONENT[k], remainder.told()),
            got: largest,
            want: 0.0,
            units: remainder.units(),
            tolerance: allowed,
            off: (remainder.off, remainder.allowed),
        }
    });
    check(examined, (quantity, Oracle::Taylor), &|j| v[j], found.collect(), made)
}

/// Second derivatives along two random directions, by hyper-dual numbers.
pub fn hyper_dual(
    examined: &Examined<'_>,
    narrow: &Narrow,
    draw: &mut Draw,
    made: &[Mutant],
) -> Option<Check> {
    let quantity = Quantity::SecondDerivatives;
    let length = examined.case.length;
    let v = direction(draw, length, narrow.active());
    let w = direction(draw, length, narrow.active());
    let rows = examined.numbers.entries(quantity);
    let weight = |i: usize| v[i / DOFS] * w[i % DOFS];
    let told = narrow.hyper_dual(&v, &w).into_iter().enumerate().filter(|(k, _)| examined.is_smooth[*k]);
    let found = told.filter_map(|(k, want)| {
        let (want, matrix) = (want?, rows.0[k].as_ref()?);
        let (mut got, mut allowed) = (0.0, 0.0);
        for (i, entry) in matrix.iter().enumerate() {
            let product = weight(i);
            got += entry * product;
            // Once for the product's entries, once for the oracle's.
            allowed += 2.0 * examined.bound.tolerance(quantity, k, i) * product.abs();
        }
        let error = (got - want).abs();
        let units = if error == 0.0 { 0.0 } else { error / allowed };
        let units = if units.is_nan() { f64::INFINITY } else { units };
        let entry = format!("vᵀ ∂²{} w", COMPONENT[k]);
        Some(Sum { component: k, entry, got, want, units, tolerance: allowed, off: (want - got, allowed) })
    });
    check(examined, (quantity, Oracle::HyperDual), &weight, found.collect(), made)
}
