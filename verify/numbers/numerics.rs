//! How exact the elementary functions and the rotations are, derivative by derivative.
//!
//! The unit of error is u S: u = 2⁻⁵³ and S = |f| + Σ|x_i||∂f/∂x_i| over all input doubles, the *conditioned scale*: what one
//! rounding of each input already forces, f being the value or an entry of the first or second derivative. Vectors, matrices
//! and the derivatives of one quantity are measured in the maximum norm: largest error over largest S. (Entry by entry
//! no formula could pass: an exact zero that rests on cancellation has S = 0.) Cardan and Euler angles are measured both
//! together and one by one.
//! Derivatives of functions of a rotation are along R(e) = exp(e^) R.
//!
//! Two references stand beside each other. Golden numbers from mpmath (`scripts/numbers/numerics_golden.py`, formulas and jets of its
//! own) judge the product and the 237-bit scalar alike, on few points; the 237-bit scalar judges the product on many.

mod chain;
mod function;
mod fuzz;
mod golden;
mod grid;
mod identity;
mod jacobian;
mod margins;
mod midway;
mod orders;
mod truth;
mod turns;

use crate::tolerance::{Gate, NUMERICS};
use function::Function;
use std::fmt::Write;

/// u, the unit of rounding of `f64`.
const U: f64 = 1.0 / 9_007_199_254_740_992.0;

/// The order of derivative of the number `index` of an output in `n` directions: value, gradient, upper triangle.
const fn order(index: usize, n: usize) -> usize {
    if index == 0 {
        0
    } else if index <= n {
        1
    } else {
        2
    }
}

/// The largest error met so far, for each order, and where.
#[derive(Clone)]
struct Worst {
    function: &'static str,
    orders: [(f64, String); 3],
}

impl Worst {
    fn new(function: &'static str) -> Self {
        Self { function, orders: [const { (0.0, String::new()) }; 3] }
    }

    fn include(&mut self, other: Self) {
        for (ours, theirs) in self.orders.iter_mut().zip(other.orders) {
            if theirs.0 > ours.0 || ours.1.is_empty() {
                *ours = theirs;
            }
        }
    }

    /// Notes an error; one that is not a number counts as infinite.
    fn note(&mut self, order: usize, error: f64, place: impl FnOnce() -> String) {
        let error = if error.is_nan() { f64::INFINITY } else { error };
        let worst = &mut self.orders[order];
        if error > worst.0 || worst.1.is_empty() {
            *worst = (error, place());
        }
    }
}

/// Prints what was measured and fails where a gate is missed: one of `own` before the common ones.
fn assert_gates(title: &str, measured: &[Worst], own: &[Gate]) {
    let mut table = format!("{title}: largest error in u of the conditioned scale (gate)\n");
    let mut missed = String::new();
    for worst in measured {
        let gate = own.iter().chain(NUMERICS).find(|g| g.function == worst.function).expect(worst.function);
        let _ = write!(table, "{:22}", worst.function);
        for (k, (error, place)) in worst.orders.iter().enumerate() {
            let _ = write!(table, " {:>9.3} ({:>2})", error, gate.orders[k]);
            if *error > gate.orders[k] {
                let _ = writeln!(
                    missed,
                    "{} order {k}: {error:.4e} > {} at {place}",
                    worst.function, gate.orders[k]
                );
            }
        }
        let _ = writeln!(table);
        for (k, (_, place)) in worst.orders.iter().enumerate() {
            let _ = writeln!(table, "    order {k} at {place}");
        }
    }
    println!("{table}");
    assert!(missed.is_empty(), "{title}: gates missed\n{missed}");
}

/// A reference number: rounded, its conditioned scale S, and what the rounding left in units u S.
#[derive(Clone, Copy, Debug)]
struct Reference {
    value: f64,
    scale: f64,
    rest: f64,
}

/// The errors of all numbers of a function at one point, order by order, in units u of the largest S, noted for each of its
/// measures.
///
/// An order whose true numbers overflow is not judged.
fn judge(
    measured: &mut [Worst],
    function: Function,
    inputs: &[f64],
    computed: &[Vec<f64>],
    references: &[Vec<Reference>],
) {
    assert_eq!(computed.len(), references.len(), "{function:?}");
    for (worst, (_, together)) in measured.iter_mut().zip(function.measures()) {
        for (computed, references) in computed.chunks(*together).zip(references.chunks(*together)) {
            for k in 0..3 {
                let of_order = |i: &usize| order(*i, function.directions()) == k;
                let pairs = computed.iter().zip(references).flat_map(|(c, r)| {
                    assert_eq!(c.len(), r.len(), "{function:?}");
                    (0..c.len()).filter(of_order).map(|i| (c[i], r[i])).collect::<Vec<_>>()
                });
                let pairs: Vec<_> = pairs.collect();
                let scale = pairs.iter().fold(0.0, |s: f64, (_, r)| s.max(r.scale));
                if scale.is_infinite() {
                    continue;
                }
                for (x, reference) in pairs {
                    let place = || format!("{inputs:?}: {x:e} for {:e}", reference.value);
                    worst.note(k, error(x, reference, scale), place);
                }
            }
        }
    }
}

/// Nothing measured yet, for each measure of a function.
fn unmeasured(function: Function) -> Vec<Worst> {
    function.measures().iter().map(|(name, _)| Worst::new(name)).collect()
}

/// |computed − reference| in units u times `scale`; the spacing at the bottom of the range is no error.
fn error(computed: f64, reference: Reference, scale: f64) -> f64 {
    const SPACING: f64 = 4.0 * f64::MIN_POSITIVE * f64::EPSILON;
    let difference = computed - reference.value;
    if difference.abs() <= SPACING && scale < SPACING / U {
        return 0.0;
    }
    if scale == 0.0 {
        return if difference == 0.0 { 0.0 } else { f64::INFINITY };
    }
    (difference / scale / U - reference.rest * (reference.scale / scale)).abs()
}
