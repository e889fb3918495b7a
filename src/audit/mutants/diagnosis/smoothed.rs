//! Lengths that were made smooth at zero: √(l² + ε²) for l, or l + ε where it divides. Each state tells an ε; a mistake has the same at all.

use crate::case::Case;
use crate::case::quantity::{Entries, Quantity};
use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::matching::Hypothesis;
use pintle_kinematics::measure::Measure;
use pintle_scene::grammar::number as short;

/// What a smoothed length makes of values and rows.
pub(super) fn of_smoothed(
    case: &Case,
    quantity: Quantity,
    want: &Entries<f64>,
    got: &Entries<f64>,
) -> Vec<Hypothesis> {
    let connector = case.connector();
    let (now, first) = (case.positions(), case.at_rest().positions());
    let mut found = Vec::new();
    for (k, wanted) in want.0.iter().enumerate() {
        let is_length =
            matches!(connector.differentiated(k), Some(Measure::Distance | Measure::RadialDistance));
        let (Some(wanted), Some(given), Some(now), Some(first)) = (wanted, &got.0[k], now[k], first[k])
        else {
            continue;
        };
        let is_size = |x: &f64| *x > 0.0 && x.is_finite();
        match quantity {
            Quantity::Value if is_length => {
                let Some(x) = given.first() else { continue };
                let both = of_both(*x, now, first);
                let one = ((x + first).powi(2) - now * now).sqrt();
                for (what, size) in [("√(l² + ε²) − √(l₀² + ε²)", both), ("√(l² + ε²) − l₀", one)]
                {
                    let told = Some(size).filter(is_size);
                    let made = told.map(|size| (size, Hypothesis::one(Cause::Regularised, (k, 0), *x)));
                    found.extend(made.map(|(size, made)| made.related(said(what, size))));
                }
            }
            Quantity::FirstDerivatives | Quantity::NodalForces if is_length => {
                let largest = (0..wanted.len()).max_by(|i, j| wanted[*i].abs().total_cmp(&wanted[*j].abs()));
                let Some(factor) = largest.map(|i| given[i] / wanted[i]).filter(|f| *f > 0.0 && *f < 1.0)
                else {
                    continue;
                };
                let (root, sum) = (now * (1.0 / (factor * factor) - 1.0).sqrt(), now * (1.0 / factor - 1.0));
                for (what, size) in
                    [("what is expected × l/√(l² + ε²)", root), ("what is expected × l/(l + ε)", sum)]
                {
                    if is_size(&size) {
                        let all = wanted.iter().map(|x| factor * x).enumerate();
                        found.push(Hypothesis::of_row(Cause::Regularised, k, all).related(said(what, size)));
                    }
                }
            }
            _ => {}
        }
    }
    found
}

/// ε of a value √(l² + ε²) − √(l₀² + ε²), by Newton's method in ε².
fn of_both(x: f64, now: f64, first: f64) -> f64 {
    let mut square = 0.0_f64;
    for _ in 0..40 {
        let (l, l0) = ((now * now + square).sqrt(), (first * first + square).sqrt());
        let slope = 0.5 / l - 0.5 / l0;
        square = (square - (l - l0 - x) / slope).max(0.0);
    }
    square.sqrt()
}

fn said(what: &str, size: f64) -> String {
    format!("{what} with ε = {}", short(size, 3))
}
