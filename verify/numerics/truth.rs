//! The reference that the 237-bit scalar gives: values, derivatives and conditioned scales.

use super::function::Function;
use super::{Reference, U, order};
use pintle::scalar::{Real, Wide};
use pintle::vector::Matrix;

/// Relative perturbation of an input, for S only.
const STEP: f64 = 1e-25;

/// The function of the exact inputs, with S of every number from one relative perturbation of each input.
pub(super) fn references(function: Function, inputs: &[f64]) -> Vec<Vec<Reference>> {
    let x: Vec<Wide> = inputs.iter().map(|c| Wide::from_f64(*c)).collect();
    let base = exact(function, &x);
    let mut scales: Vec<Vec<Wide>> = base.iter().map(|c| c.iter().map(|n| n.abs()).collect()).collect();
    for i in (0..function.rounded_inputs()).filter(|i| inputs[*i] != 0.0) {
        let moved = moved(function, &x, i, &base);
        for (scale, (a, b)) in scales.iter_mut().zip(base.iter().zip(&moved)) {
            for (s, (a, b)) in scale.iter_mut().zip(a.iter().zip(b)) {
                *s += (*b - *a).abs() / STEP;
            }
        }
    }
    let n = function.directions();
    if function.is_log() {
        for (scale, component) in scales.iter_mut().zip(&base) {
            let largest = component[1..=n].iter().fold(Wide::integer(0), |l, g| l.max(g.abs()));
            for (k, s) in scale.iter_mut().enumerate() {
                if order(k, n) == 2 {
                    *s += largest;
                }
            }
        }
    }
    let reference = |(x, s): (&Wide, &Wide)| {
        let (value, scale) = (x.to_f64(), s.to_f64());
        let rest = if scale > 0.0 && value.is_finite() { ((*x - value) / *s / U).to_f64() } else { 0.0 };
        Reference { value, scale: if value.is_finite() { scale } else { f64::INFINITY }, rest }
    };
    base.iter().zip(&scales).map(|(c, s)| c.iter().zip(s).map(reference).collect()).collect()
}

/// The function where input i has grown by [`STEP`], or shrunk where growing it crosses the cut of a log at half a turn.
fn moved(function: Function, x: &[Wide], i: usize, base: &[Vec<Wide>]) -> Vec<Vec<Wide>> {
    let at = |factor: Wide| {
        let mut x = x.to_vec();
        x[i] *= factor;
        exact(function, &x)
    };
    let one = Wide::integer(1);
    let grown = at(one + STEP);
    let jumps = |(a, b): (&Vec<Wide>, &Vec<Wide>)| (b[0] - a[0]).abs() > a[0].abs() + one;
    if base.iter().zip(&grown).any(jumps) { at(one - STEP) } else { grown }
}

/// The function of the rotation nearest to the inputs.
fn exact(function: Function, x: &[Wide]) -> Vec<Vec<Wide>> {
    if !function.is_log() {
        return function.numbers(x);
    }
    let n = function.rounded_inputs();
    let mut rotation = if n == 4 { unit(&x[..4]) } else { polar(&x[..9]) };
    rotation.extend(&x[n..]);
    function.numbers(&rotation)
}

/// q / |q|.
fn unit(q: &[Wide]) -> Vec<Wide> {
    let norm = q.iter().map(|c| *c * *c).sum::<Wide>().square_root();
    q.iter().map(|c| *c / norm).collect()
}

/// The rotation nearest to a rounded rotation matrix (by rows): X ← (X + X⁻ᵀ)/2, which squares the error of 1e−16 each time.
fn polar(entries: &[Wide]) -> Vec<Wide> {
    let mut x: Matrix<Wide> = [0, 3, 6].map(|i| [entries[i], entries[i + 1], entries[i + 2]]);
    for _ in 0..3 {
        let mut cofactors = x;
        for i in 0..3 {
            for j in 0..3 {
                let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
                cofactors[i][j] = x[i1][j1] * x[i2][j2] - x[i1][j2] * x[i2][j1];
            }
        }
        let determinant = x[0][0] * cofactors[0][0] + x[0][1] * cofactors[0][1] + x[0][2] * cofactors[0][2];
        for i in 0..3 {
            for j in 0..3 {
                x[i][j] = (x[i][j] + cofactors[i][j] / determinant) * Wide::ratio(1, 2);
            }
        }
    }
    x.concat()
}
