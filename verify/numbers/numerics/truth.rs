//! The reference that the 237-bit scalar gives: values, derivatives and conditioned scales.

use super::function::Function;
use super::{Reference, U, order};
use pintle_kinematics::scalar::{Real, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector};

/// Perturbation of an input, relative, or of a rotation, in radians; for S only.
const STEP: f64 = 1e-25;

/// The numbers of a function, by output.
type Numbers = Vec<Vec<Wide>>;

/// The function of the exact inputs (for a log, of the rotation nearest to them), with S of every number.
pub(super) fn references(function: Function, inputs: &[f64]) -> Vec<Vec<Reference>> {
    let x: Vec<Wide> = inputs.iter().map(|c| Wide::from_f64(*c)).collect();
    let (base, changes) =
        if function.is_log() { of_rotation(function, &x) } else { of_numbers(function, &x) };
    let mut scales: Numbers = base.iter().map(|c| c.iter().map(|n| n.abs()).collect()).collect();
    for change in changes {
        for (scale, change) in scales.iter_mut().flatten().zip(change.iter().flatten()) {
            *scale += change.abs();
        }
    }
    let n = function.directions();
    if function.is_log() {
        for (scale, component) in scales.iter_mut().zip(&base) {
            let largest = component[1..=n].iter().fold(Wide::ZERO, |l, g| l.max(g.abs()));
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

/// (moved − base) / STEP, number by number.
fn slope(base: &Numbers, moved: &Numbers) -> Numbers {
    let of_output =
        |(b, m): (&Vec<Wide>, &Vec<Wide>)| b.iter().zip(m).map(|(b, m)| (*m - *b) / STEP).collect();
    base.iter().zip(moved).map(of_output).collect()
}

/// A function of plain numbers, and its changes per relative change of each input.
fn of_numbers(function: Function, x: &[Wide]) -> (Numbers, Vec<Numbers>) {
    let base = function.numbers(x);
    let changes = (0..function.rounded_inputs()).filter(|i| x[*i] != 0.0).map(|i| {
        let mut moved = x.to_vec();
        moved[i] *= Wide::integer(1) + STEP;
        slope(&base, &function.numbers(&moved))
    });
    (base.clone(), changes.collect())
}

/// A function of the rotation nearest to the inputs, and its changes per relative change of each input: by the change per
/// radian about the three axes, and the turn that the change of the input makes.
fn of_rotation(function: Function, x: &[Wide]) -> (Numbers, Vec<Numbers>) {
    let n = function.rounded_inputs();
    let (rotation, branch) = x.split_at(n);
    let at = |rotation: &[Wide]| function.numbers(&[rotation, branch].concat());
    let exact = if n == 4 { unit(rotation) } else { polar(rotation) };
    let base = at(&exact);
    let slopes = [0, 1, 2].map(|axis| {
        let about = |angle: Wide| {
            let mut phi = [Wide::ZERO; 3];
            phi[axis] = angle;
            let turn = so3::exp_quaternion(phi);
            if n == 4 {
                at(&so3::compose(turn, [exact[0], exact[1], exact[2], exact[3]]))
            } else {
                at(&vector::product(&so3::matrix(turn), &rows(&exact)).concat())
            }
        };
        let step = Wide::from_f64(STEP);
        let slope_forward = slope(&base, &about(step));
        // Where the step crosses the cut of a log at half a turn, the other direction stays on this side.
        let jumps = slope_forward.iter().any(|c| c[0].abs() > 0.1 / STEP);
        if jumps { slope(&about(-step), &base) } else { slope_forward }
    });
    let combined = |turn: Vector<Wide>| {
        let mut change = slopes[0].clone();
        for (c, number) in change.iter_mut().enumerate() {
            for (k, x) in number.iter_mut().enumerate() {
                *x = (0..3).map(|axis| slopes[axis][c][k] * turn[axis]).sum();
            }
        }
        change
    };
    let changes = (0..n).filter(|i| rotation[*i] != 0.0).map(|i| {
        let zero = Wide::ZERO;
        if n == 4 {
            // δq = δ^/2 q
            let mut change = [zero; 4];
            change[i] = rotation[i];
            let q = [exact[0], exact[1], exact[2], exact[3]];
            let [_, x, y, z] = so3::compose(change, so3::conjugate(q));
            combined(vector::scale([x, y, z], Wide::integer(2)))
        } else {
            // δR = δ^ R, δ^ the antisymmetric part
            let mut change = [[zero; 3]; 3];
            change[i / 3][i % 3] = rotation[i];
            let m = vector::product(&change, &vector::transpose(&rows(&exact)));
            let axial = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]];
            combined(vector::scale(axial, Wide::ratio(1, 2)))
        }
    });
    (base.clone(), changes.collect())
}

fn rows(entries: &[Wide]) -> Matrix<Wide> {
    [0, 3, 6].map(|i| [entries[i], entries[i + 1], entries[i + 2]])
}

/// q / |q|.
fn unit(q: &[Wide]) -> Vec<Wide> {
    let norm = q.iter().map(|c| *c * *c).sum::<Wide>().square_root();
    q.iter().map(|c| *c / norm).collect()
}

/// The rotation nearest to a rounded rotation matrix (by rows): X ← (X + X⁻ᵀ)/2, which squares the error of 1e−16 each time.
fn polar(entries: &[Wide]) -> Vec<Wide> {
    let mut x = rows(entries);
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
